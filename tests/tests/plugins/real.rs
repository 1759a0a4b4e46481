//! The plugins of this repository, each in the scenario of its name, against a closed form.

use crate::*;
use wireloom_tests::cables::{branch, connector, section};

pub fn trials() -> Vec<Named> {
    vec![
        named("cable-tie: two cantilevers drawn together bear 3 EI δ / L³", cable_tie),
        named("hinge-guide: a cable along the hinge is twisted by G J φ / L", hinge_guide),
        named("elastic-strap: strap and cantilever are two springs in a row", elastic_strap),
        named("spring-joint: a cantilever with the joint half way sinks by F L³ / 3 E I + F (L/2)² / k", spring_joint),
        named("softening-bundle: a moment bends it to the arc of its closed form", softening_bundle),
        named("a potential and equations in one, in C: a cone and a spring", potential_and_equations),
        named("tensions beside a constraint, what it remembers of them, and its events, in C", tensions_and_events),
        named("all of them keep what they promise", all_keep_their_promises),
        named("a plugin in C and one in Rust in one scenario", both_languages),
        named("list shows what is installed, with parameters", list),
        named("a run that was killed goes on to the same bits with its plugins, and not with others", resumed),
    ]
}

/// A cable of 0.5 m hangs from a clamp and is pulled at its end; a spring of 20 N/m holds it to a place above its
/// station, at 0.3 m. The spring takes its force off the tension before it.
fn tensions_and_events() -> Checked {
    let place = Place::new()?;
    compile(&root().join("tests/tests/plugins/fuse.c"), &place.path("libfuse.so"), &[])?;
    let pull = |name: &str, factor: f64| {
        format!("[[steps]]\nname = \"{name}\"\nincrements = 2\nload = [{{ load = \"hand\", factor = {factor} }}]\n")
    };
    let text = [
        "schema = 1\nname = \"fuse\"\n[plugins]\nload = [\"fuse\"]\n[minimiser]\nforce_tolerance = 1e-9\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.5, 50),
        "[[constraints]]\nname = \"clamp\"\nkind = \"connector\"\nat = { end = \"A\" }\nposition = [0, 0, 0]\n\
         tangent = [0, 0, -1]\n\
         [[constraints]]\nname = \"fuse\"\nkind = \"fuse\"\nat = { branch = \"cable\", s = 0.3 }\nstiffness = 20\n\
         limit = 0.5\nposition = [0, 0, -0.29]\n\
         [[loads]]\nname = \"hand\"\nat = { end = \"B\" }\nforce = [0, 0, -1]\nfactor = 0\n",
        &pull("pull", 1.0),
        &pull("let go", 0.0),
    ]
    .concat();
    fs::write(place.path("s.toml"), text)?;
    let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "libfuse.so"])?.expect(0)?;
    let result = place.json("out/s/result.json")?;
    for (step, hand) in [(0, 1.0), (1, 0.0)] {
        let end = &result["steps"][step]["constraints"]["fuse"];
        let behind = hand + 0.2 * 0.05 * 9.81;
        near("behind", number(end, "/outputs/behind"), behind, 1e-6)?;
        near("before", number(end, "/outputs/before"), behind - number(end, "/force/2"), 1e-6)?;
        ensure((end["outputs"]["overloaded"].as_f64().is_some()) == (step == 0), end)?;
    }
    ensure(number(&result["steps"][0]["constraints"]["fuse"], "/force/2") > 0.1, "the spring bears nothing")?;
    near("largest", number(&result["steps"][1]["constraints"]["fuse"], "/outputs/largest"), 1.0981, 1e-6)?;
    let events = result["events"].as_array().ok_or("no events")?;
    let [event] = &events[..] else { return Err(format!("{events:?}").into()) };
    ensure(event["kind"] == "reported" && event["place"]["fixing"] == "fuse", event)?;
    ensure(event["message"] == "overloaded: the cable pulls too much, 1.0981 N", event)?;
    // Half way back the hand pulls with 0.5 N.
    ensure(event["increments"] == 3 && event["first"]["increment"] == 1, event)?;
    near("value", number(event, "/value"), 1.0981, 1e-6)?;
    ensure(ended.out.contains("overloaded: the cable pulls too much"), &ended)?;
    let listed = place.wireloom_with(&["plugin", "list"], Some(place.0.path()))?.expect(0)?;
    ensure(listed.out.contains("    event overloaded (N): the cable pulls too much"), &listed)
}

/// Runs the scenario of a plugin with its library.
fn run(plugin: &str, library: &Path) -> Result<Value, Failed> {
    let place = Place::new()?;
    let scenario = root().join(format!("plugins/{plugin}/{plugin}.toml"));
    let (scenario, library) = (scenario.to_string_lossy(), library.to_string_lossy());
    let ended = place.wireloom(&["run", &scenario, "--allow-plugin", &library, "--out", "out"])?.expect(0)?;
    ensure(ended.out.contains(&format!("\nplugin `{plugin}` 0.1.0 from {library} (SHA-256 ")), &ended)?;
    let result = place.json("out/result.json")?;
    ensure(result["status"] == "converged", &result["status"])?;
    ensure(result["plugins"][0]["name"] == plugin, &result["plugins"])?;
    ensure(ended.out.contains(result["plugins"][0]["hash"].as_str().unwrap_or("no hash")), &ended)?;
    Ok(result)
}

fn cable_tie() -> Checked {
    let result = run("cable-tie", &library("cable-tie"))?;
    let end = &result["steps"][0];
    let (lower, upper) = ("/branches/lower/position/25/2", "/branches/upper/position/25/2");
    let apart = number(end, upper) - number(end, lower);
    // The equation d = D is met to 1e-8 m; the ends stay one above the other.
    near("distance", apart, 6e-3, 1e-5)?;
    near("length of the tie", number(end, "/constraints/tie/outputs/length"), 6e-3, 1e-9)?;
    ensure(number(end, "/constraints/tie/outputs/gap").abs() < 1e-7, &end["constraints"]["tie"])?;
    // Small deflections: (δ/L)² = 2e-4.
    let force = 3.0 * 0.01 * 7e-3 / 0.125;
    near("force on the lower end", number(end, "/constraints/tie/stations/0/force/2"), force, 1e-3)?;
    near("force on the upper end", number(end, "/constraints/tie/stations/1/force/2"), -force, 1e-3)
}

fn hinge_guide() -> Checked {
    let result = run("hinge-guide", &library("hinge-guide"))?;
    let end = &result["steps"][0];
    let moment = 0.008 * std::f64::consts::FRAC_PI_2 / 0.5;
    // A straight rod that is twisted: exact but for the tolerance of the equilibrium.
    near("angle", number(end, "/constraints/door/outputs/angle"), std::f64::consts::FRAC_PI_2, 1e-12)?;
    near("moment of the clip", number(end, "/constraints/door/moment/0"), moment, 1e-6)?;
    near("turns of the cable", number(end, "/branches/cable/twist_turns"), 0.25, 1e-6)
}

fn elastic_strap() -> Checked {
    let place = Place::new()?;
    let result = run("elastic-strap", &strap(place.0.path())?)?;
    let end = &result["steps"][0];
    // Small deflections: (δ/L)² = 4e-4.
    near("height of the end", number(end, "/branches/cable/position/25/2"), 10e-3, 2e-3)?;
    near("force of the strap", number(end, "/constraints/strap/force/2"), 2.4e-3, 2e-3)?;
    let force = number(end, "/constraints/strap/force/2").hypot(number(end, "/constraints/strap/force/0"));
    let [elongation, tension] =
        ["elongation", "tension"].map(|output| number(end, &format!("/constraints/strap/outputs/{output}")));
    near("tension", tension, force, 1e-9)?;
    near("elongation", elongation, tension / number(&stiffness()?, ""), 1e-9)
}

/// Stiffness of the strap in its scenario, N/m.
fn stiffness() -> Result<Value, Failed> {
    let text = fs::read_to_string(root().join("plugins/elastic-strap/elastic-strap.toml"))?;
    let line = text.lines().find_map(|line| line.trim().strip_prefix("stiffness = ")).ok_or("no stiffness")?;
    let number: f64 = line.trim_matches('"').split_whitespace().next().unwrap_or_default().parse()?;
    Ok(number.into())
}

/// The joint, which is in C++.
fn joint(folder: &Path) -> Result<PathBuf, Failed> {
    let library = folder.join("libspring_joint.so");
    compile_cpp(&root().join("plugins/spring-joint/spring_joint.cpp"), &library, &[])?;
    Ok(library)
}

/// A cone around the target, on which the end of a cable is held, and a spring of 3 N/m to the target, in one.
fn potential_and_equations() -> Checked {
    let place = Place::new()?;
    compile(&root().join("tests/tests/plugins/liar.c"), &place.path("libliar.so"), &["-DCASE=4"])?;
    let text = [
        "schema = 1\nname = \"cone\"\ngravity = [0, 0, 9.81]\n\n[plugins]\nload = [\"liar\"]\n\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.5, 20),
        &connector("clamp", "A", [0.0, 0.0, 0.0]),
        "[[constraints]]\nname = \"cone\"\nkind = \"liar\"\nat = { end = \"B\" }\nposition = [0.47, 0, 0]\n",
    ]
    .concat();
    fs::write(place.path("s.toml"), text)?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "libliar.so"])?.expect(0)?;
    let end = &place.json("out/s/result.json")?["steps"][0];
    let at = |what: &str, k: usize| number(end, &format!("/constraints/cone/{what}/{k}"));
    let away = [at("position", 0) - 0.47, at("position", 1), at("position", 2)];
    let across = away[0].hypot(away[1]);
    ensure(away[2] > 1e-3 && (across - 0.5 * away[2]).abs() < 1e-8, format!("{away:?} is not on the cone"))?;
    // What is left of its force without the spring is across the cone.
    let [fx, fz] = [0, 2].map(|k| at("force", k) + 3.0 * away[k]);
    ensure((fx * away[0] + fz * away[2]).abs() < 1e-6 * (fx * fx + fz * fz).sqrt(), format!("{fx} N and {fz} N"))
}

fn spring_joint() -> Checked {
    let place = Place::new()?;
    let result = run("spring-joint", &joint(place.0.path())?)?;
    // Small deflections: (δ/L)² = 4e-4; 20 segments each.
    near("end", number(&result, "/steps/0/branches/right/position/20/2"), -10.4167e-3, 1e-3)
}

fn softening_bundle() -> Checked {
    let result = run("softening-bundle", &library("softening-bundle"))?;
    let end = &result["steps"][0];
    // An arc of curvature 4 1/m that is turned by 2 rad; the scheme is of second order, the curvature is exact.
    near("end", number(end, "/branches/cable/position/50/0"), 2.0_f64.sin() / 4.0, 1e-4)?;
    near("height of the end", number(end, "/branches/cable/position/50/2"), (1.0 - 2.0_f64.cos()) / 4.0, 1e-4)?;
    for node in [0, 25, 50] {
        near("bend radius", number(end, &format!("/branches/cable/bend_radius/{node}")), 0.25, 1e-6)?;
    }
    // L ½ EI κ² of a linear cable of EI = 0.0025 N m², and 0.75 EI κ₀² (√5 − 1) L.
    let energy = 0.5 * (0.5 * 0.0025 * 16.0 + 0.03 * (5.0_f64.sqrt() - 1.0));
    near("energy", number(end, "/energy/bend"), energy, 1e-6)
}

fn all_keep_their_promises() -> Checked {
    let place = Place::new()?;
    let (strap, joint) = (strap(place.0.path())?, joint(place.0.path())?);
    for library in [library("cable-tie"), library("hinge-guide"), library("softening-bundle"), strap, joint] {
        let ended = place.wireloom(&["plugin", "check", &library.to_string_lossy()])?.expect(0)?;
        ensure(ended.out.ends_with("all tests passed\n") && !ended.out.contains("not tested"), &ended)?;
    }
    Ok(())
}

/// The cantilevers of the tie, and a strap between their middles.
fn both_languages() -> Checked {
    let place = Place::new()?;
    let text = fs::read_to_string(root().join("plugins/cable-tie/cable-tie.toml"))?
        .replace(r#"load = ["cable-tie"]"#, r#"load = ["cable-tie", "elastic-strap"]"#)
        + r#"
        [[steps]]
        name = "strap"
        increments = 2
        [[steps.add]]
        name = "strap"
        kind = "elastic-strap"
        at = [{ branch = "lower", s = 0.26 }, { branch = "upper", s = 0.26 }]
        stiffness = "5 N/m"
        pretension = "1 mN"
        "#;
    fs::write(place.path("both.toml"), text)?;
    let (tie, strap) = (library("cable-tie"), strap(place.0.path())?);
    let allowed = ["--allow-plugin", &tie.to_string_lossy(), "--allow-plugin", &strap.to_string_lossy()];
    place.wireloom(&[&["run", "both.toml"], &allowed[..]].concat())?.expect(0)?;
    let result = place.json("out/both/result.json")?;
    let end = &result["steps"][1];
    let middle = |branch: &str| number(end, &format!("/branches/{branch}/position/13/2"));
    // The strap began at the distance of the step before.
    let before = &result["steps"][0];
    let put_on = number(before, "/branches/upper/position/13/2") - number(before, "/branches/lower/position/13/2");
    let drawn = (middle("upper") - middle("lower")) - (put_on - 1e-3 / 5.0);
    near("force of the strap", number(end, "/constraints/strap/stations/0/force/2"), 5.0 * drawn, 1e-3)?;
    ensure(result["plugins"].as_array().is_some_and(|plugins| plugins.len() == 2), &result["plugins"])
}

fn list() -> Checked {
    let place = Place::new()?;
    fs::create_dir(place.path("plugins"))?;
    strap(&place.path("plugins"))?;
    fs::copy(library("cable-tie"), place.path("plugins/libcable_tie.so"))?;
    fs::write(place.path("plugins/broken.so"), "no library")?;
    let ended = place.wireloom_with(&["plugin", "list"], Some(&place.path("plugins")))?.expect(0)?;
    for words in [
        "plugin `cable-tie` 0.1.0",
        "constraint `cable-tie` on 2 stations",
        "gap (m, at least 0; default 0)",
        "constraint `elastic-strap` on 1 to 2 stations",
        "stiffness (N/m, above 0; required): of the drawn strap",
        "broken.so: is not a library that this system can load",
    ] {
        ensure(ended.out.contains(words), (words, &ended))?;
    }
    Ok(())
}

/// Stops a run after its first step by a plugin that is another one in the second, and takes it up again with the
/// first.
fn resumed() -> Checked {
    let place = Place::new()?;
    let source = root().join("tests/tests/plugins/hostile.c");
    let library = place.path("libhostile.so");
    compile(&source, &library, &["-DCASE=0"])?;
    fs::write(place.path("s.toml"), hostile::scenario())?;
    let run = ["run", "s.toml", "--allow-plugin", "libhostile.so", "--out", "whole"];
    place.wireloom(&run)?.expect(0)?;
    let whole = place.json("whole/result.json")?;
    compile(&source, &library, &["-DCASE=0", "-DOTHER"])?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "libhostile.so", "--out", "other"])?.expect(0)?;
    let other = place.json("other/result.json")?;
    ensure(whole["plugins"][0]["hash"] != other["plugins"][0]["hash"], "the same hash for another library")?;
    // The crash leaves what --resume needs; the library with which the run began is the only one it goes on with.
    compile(&source, &library, &["-DCASE=37"])?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "libhostile.so", "--out", "crashed"])?.expect(3)?;
    compile(&source, &library, &["-DCASE=0"])?;
    place
        .wireloom(&["run", "--resume", "crashed", "--allow-plugin", "libhostile.so"])?
        .expect(1)?
        .says(&["plugin `hostile` has changed since the run was interrupted"])
}
