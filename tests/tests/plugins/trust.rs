//! A plugin is native code: nothing is loaded but what the user trusts.

use crate::*;

pub fn trials() -> Vec<Named> {
    vec![
        named("a library that the user did not allow is not loaded", not_allowed),
        named("check loads nothing on its own", check_loads_nothing),
        named("the search path is trusted, its first folder first", search_path),
        named("a plugin that is nowhere is looked for in places that are named", nowhere),
        named("a kind of a plugin that is not named is refused with what to do", not_named),
        named("two plugins of one name are refused with both files", same_name),
    ]
}

/// A plugin that leaves a file behind as it is loaded.
fn telltale(place: &Place) -> Result<PathBuf, Failed> {
    let library = place.path("libhostile.so");
    compile(&root().join("tests/tests/plugins/hostile.c"), &library, &["-DCASE=0", "-DTELLTALE"])?;
    fs::write(place.path("s.toml"), hostile::scenario())?;
    Ok(library)
}

fn not_allowed() -> Checked {
    let place = Place::new()?;
    telltale(&place)?;
    place.wireloom(&["run", "s.toml"])?.expect(1)?.says(&[
        "s.toml:6:9: plugin \"hostile\" (libhostile.so) is not loaded: it is not in the search path",
        "native code, which may do whatever you may: if you trust it, add --allow-plugin libhostile.so",
    ])?;
    ensure(!place.path("telltale").exists(), "it was loaded")?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "libhostile.so"])?.expect(0)?;
    ensure(place.path("telltale").exists(), "it was not loaded")
}

fn check_loads_nothing() -> Checked {
    let place = Place::new()?;
    telltale(&place)?;
    let here = Some(place.0.path());
    place
        .wireloom_with(&["check", "s.toml"], here)?
        .expect(1)?
        .says(&["plugin \"hostile\" (libhostile.so) is not loaded here", "--allow-plugin libhostile.so"])?;
    ensure(!place.path("telltale").exists(), "check loaded it")?;
    place.wireloom(&["check", "s.toml", "--allow-plugin", "libhostile.so"])?.expect(0)?;
    Ok(())
}

fn search_path() -> Checked {
    let place = Place::new()?;
    let library = telltale(&place)?;
    fs::create_dir(place.path("trusted"))?;
    fs::rename(library, place.path("trusted/libhostile.so"))?;
    let ended = place.wireloom_with(&["run", "s.toml"], Some(&place.path("trusted")))?.expect(0)?;
    ensure(ended.out.contains("trusted/libhostile.so (SHA-256 "), &ended)
}

fn nowhere() -> Checked {
    let place = Place::new()?;
    fs::write(place.path("s.toml"), hostile::scenario())?;
    place
        .wireloom_with(&["run", "s.toml"], Some(place.0.path()))?
        .expect(1)?
        .says(&["there is no plugin \"hostile\"; looked for in ", "WIRELOOM_PLUGINS"])
}

fn not_named() -> Checked {
    let place = Place::new()?;
    let text = hostile::scenario().replace("[plugins]\nload = [\"hostile\"]\ntime_limit = 0.5\n", "");
    fs::write(place.path("s.toml"), text)?;
    place.wireloom(&["run", "s.toml"])?.expect(1)?.says(&[
        "unknown constraint kind \"hostile\"",
        "for a kind of a plugin, name the plugin in `load` of [plugins]",
    ])
}

fn same_name() -> Checked {
    let place = Place::new()?;
    let first = telltale(&place)?;
    fs::copy(&first, place.path("libsecond.so"))?;
    let text = hostile::scenario().replace("[\"hostile\"]", "[\"hostile\", \"second\"]");
    fs::write(place.path("s.toml"), text)?;
    let allowed = ["--allow-plugin", "libhostile.so", "--allow-plugin", "libsecond.so"];
    place
        .wireloom(&[&["run", "s.toml"], &allowed[..]].concat())?
        .expect(1)?
        .says(&["plugin libsecond.so: is named `hostile`, as is libhostile.so"])
}
