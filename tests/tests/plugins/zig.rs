//! The example in Zig, as its README builds it.

use crate::*;

/// The compiler of Zig.
fn zig() -> std::ffi::OsString {
    std::env::var_os("ZIG").unwrap_or_else(|| "zig".into())
}

/// Its trial; ignored where there is no compiler.
pub fn trial() -> Trial {
    let absent = !Command::new(zig()).arg("version").output().is_ok_and(|done| done.status.success());
    let reason = if absent { " (ignored: no Zig, `zig` or what ZIG names)" } else { "" };
    let name = format!("zig-pull: spring and cantilever are two springs in a row{reason}");
    Trial::test(name, two_springs).with_ignored_flag(absent)
}

fn two_springs() -> Checked {
    let place = Place::new()?;
    let here = root().join("plugins/zig-pull");
    fs::copy(here.join("pull.zig"), place.path("pull.zig"))?;
    let header = root().join("crates/abi/include/wireloom_plugin.h");
    let translated = Command::new(zig()).args(["translate-c", "-lc"]).arg(header).output()?;
    ensure(translated.status.success(), String::from_utf8_lossy(&translated.stderr))?;
    fs::write(place.path("wireloom_plugin.zig"), translated.stdout)?;
    let built = Command::new(zig())
        .args(["build-lib", "-dynamic", "-O", "ReleaseSafe", "-lc", "pull.zig"])
        .current_dir(place.0.path())
        .output()?;
    ensure(built.status.success(), String::from_utf8_lossy(&built.stderr))?;
    place.wireloom(&["plugin", "check", "libpull.so"])?.expect(0)?;
    let scenario = here.join("zig-pull.toml");
    place.wireloom(&["run", &scenario.to_string_lossy(), "--allow-plugin", "libpull.so"])?.expect(0)?;
    let result = place.json("out/zig-pull/result.json")?;
    let beam = 3.0 * 0.01 / 0.3_f64.powi(3);
    // The bend is small: 1e-4 of the force is in the geometry.
    let want = 0.01 / (1.0 / beam + 1.0 / 2.0);
    near("force of the spring", number(&result, "/steps/0/constraints/spring/force/2"), want, 1e-3)
}
