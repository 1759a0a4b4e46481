//! A new user, with nothing but what `plugin new` says: five commands from nothing to a run with a constraint of their
//! own.

use crate::*;

pub fn trials() -> Vec<Named> {
    vec![
        named("new user, C: five commands, for each kind", in_c),
        named("new user, C++: five commands, for each kind; then exceptions", in_cpp),
        named("new user, Rust: five commands; then panics in every function", in_rust),
        named("plugin new refuses what is no name, or is taken", bad_names),
    ]
}

/// Runs the commands that `plugin new` prints, in a shell as a user would.
fn follow(place: &Place, arguments: &[&str]) -> Result<PathBuf, Failed> {
    let ended = place.wireloom(arguments)?.expect(0)?;
    let commands: Vec<&str> = ended.out.lines().filter_map(|line| line.strip_prefix("  ")).collect();
    ensure(commands.len() == 4 && commands[0] == "cd my-spring", &ended)?;
    let bin = place.path("bin");
    fs::create_dir(&bin)?;
    fs::copy(program(), bin.join("wireloom").with_extension(std::env::consts::EXE_EXTENSION))?;
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap_or_default());
    let output = Command::new("sh")
        .arg("-ec")
        .arg(commands.join("\n"))
        .current_dir(place.path("."))
        .env("PATH", path)
        .env_remove("WIRELOOM_PLUGINS")
        .env_remove("CARGO_TARGET_DIR")
        .env("CARGO_NET_OFFLINE", "true")
        .output()?;
    let words = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    ensure(output.status.success() && words.contains("all tests passed"), &words)?;
    let kind = arguments.iter().skip_while(|argument| **argument != "--kind").nth(1).unwrap_or(&"constraint");
    closed_form(kind, &place.json("my-spring/out/my-spring/result.json")?)?;
    Ok(place.path("my-spring"))
}

/// What the scenario of a kind says of itself.
fn closed_form(kind: &str, result: &Value) -> Checked {
    let last = result["steps"].as_array().and_then(|steps| steps.last()).cloned().unwrap_or_default();
    let (end, what) = ("/branches/cable/position/0/2", format!("end, {kind}"));
    match kind {
        "constraint" => near(&what, number(&last, end), -2.4525e-3, 1e-9),
        // The equation is met to 1e-8 m.
        "equation" => near(&what, number(&last, end), -0.05, 1e-6),
        // The spring holds the force at which it yields, up to the tolerance of the equilibrium.
        "memory" => near(&what, number(&last, "/constraints/spring/force/2"), 1.0, 1e-6),
        // Small deflections: (δ/L)² = 4e-4.
        "joint" => near(&what, number(&last, "/branches/right/position/20/2"), -10.4167e-3, 1e-3),
        // Of second order in the 50 segments.
        "rod" => near(&what, number(&last, "/branches/cable/position/50/2"), (1.0 - 2.0_f64.cos()) / 4.0, 1e-4),
        other => Err(format!("no kind {other}").into()),
    }
}

/// The kinds besides the default.
const KINDS: [&str; 4] = ["equation", "memory", "joint", "rod"];

fn in_c() -> Checked {
    let place = Place::new()?;
    let folder = follow(&place, &["plugin", "new", "my-spring", "--c"])?;
    let test = Command::new("make").arg("test").current_dir(&folder).output()?;
    ensure(test.status.success(), &test)?;
    for kind in KINDS {
        follow(&Place::new()?, &["plugin", "new", "my-spring", "--c", "--kind", kind])?;
    }
    Ok(())
}

fn in_cpp() -> Checked {
    for kind in KINDS {
        follow(&Place::new()?, &["plugin", "new", "my-spring", "--cpp", "--kind", kind])?;
    }
    let place = Place::new()?;
    let folder = follow(&place, &["plugin", "new", "my-spring", "--cpp"])?;
    let source = fs::read_to_string(folder.join("my-spring.cpp"))?;
    // Constraints are evaluated once as a scenario is read: what is thrown there refuses it.
    let cases = [
        ("double d[3], energy", "throw std::runtime_error(\"on purpose\");", "panicked in `evaluate`: on purpose"),
        ("double d[3], energy", "throw 7;", "panicked in `evaluate`: an exception that is no std::exception"),
        ("description.has_hessian = 1;", "throw wireloom::Refusal(\"too soft\");", "refuses: too soft"),
    ];
    for (place_of, thrown, words) in cases {
        ensure(source.contains(place_of), place_of)?;
        fs::write(folder.join("my-spring.cpp"), source.replacen(place_of, &format!("{thrown} {place_of}"), 1))?;
        ensure(Command::new("make").current_dir(&folder).output()?.status.success(), thrown)?;
        let run = ["run", "my-spring/my-spring.toml", "--allow-plugin", "my-spring/my-spring.so", "--quiet"];
        place.wireloom(&run)?.expect(1)?.says(&[words])?;
    }
    Ok(())
}

fn in_rust() -> Checked {
    let place = Place::new()?;
    let folder = follow(&place, &["plugin", "new", "my-spring"])?;
    let source = fs::read_to_string(folder.join("src/lib.rs"))?;
    let build = |arguments: &[&str], source: &str| -> Result<std::process::Output, Failed> {
        fs::write(folder.join("src/lib.rs"), source)?;
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo
            .args(arguments)
            .args(["--release", "--offline", "--quiet"])
            .current_dir(&folder)
            .env_remove("CARGO_TARGET_DIR");
        Ok(cargo.output()?)
    };
    let test = build(&["test"], &source)?;
    ensure(test.status.success(), &test)?;
    let panics = [
        ("build: Box::new(|_, parameters| {", "panicked in `create`: on purpose (src/lib.rs:", 1),
        ("fn energy(&self, at: &ConstraintView<'_>) -> f64 {", "panicked in `evaluate`: on purpose (src/lib.rs:", 3),
        (
            "fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], _span: &mut [Vector]) -> f64 {",
            "panicked in `evaluate`: on purpose",
            3,
        ),
        (
            "fn hessian(&self, _at: &ConstraintView<'_>, stations: &mut [Matrix], _span: &mut [Matrix]) {",
            "panicked in `evaluate`: on purpose",
            1,
        ),
        ("pub fn kind() -> ConstraintKind {", "could not list its kinds: on purpose (src/lib.rs:", 1),
    ];
    let more = [
        ("fn target(&self, base: &Pose, _progress: f64) -> Pose {", "*base }", "panicked in `target`: on purpose", 3),
        ("fn memory(&self) -> Vec<f64> {", "vec![] }", "panicked in `create`: on purpose", 1),
    ];
    let mut cases = vec![];
    for (function, words, code) in panics {
        ensure(source.contains(function), function)?;
        let wrong = source
            .replace(function, &format!("{function}\n    if std::hint::black_box(true) {{ panic!(\"on purpose\") }}"));
        cases.push((wrong, words, code));
    }
    for (function, rest, words, code) in more {
        let own =
            format!("    {function} if std::hint::black_box(true) {{ panic!(\"on purpose\") }} {rest}\n    fn action");
        let wrong = source.replacen("    fn action", &own, 1).replace("core::{Action,", "core::{Pose, Action,");
        cases.push((wrong, words, code));
    }
    for (wrong, words, code) in cases {
        let built = build(&["build"], &wrong)?;
        ensure(built.status.success(), &built)?;
        let library = format!(
            "my-spring/target/release/{}my_spring{}",
            std::env::consts::DLL_PREFIX,
            std::env::consts::DLL_SUFFIX
        );
        let ended = place.wireloom(&["run", "my-spring/my-spring.toml", "--allow-plugin", &library, "--quiet"])?;
        let ended = ended.expect(code)?;
        ended.says(&[words])?;
    }
    for kind in KINDS {
        let other = Place::new()?;
        other.wireloom(&["plugin", "new", "my-spring", "--kind", kind])?.expect(0)?;
        let built = build(&["build"], &fs::read_to_string(other.path("my-spring/src/lib.rs"))?)?;
        ensure(built.status.success(), &built)?;
        fs::copy(other.path("my-spring/my-spring.toml"), folder.join("my-spring.toml"))?;
        let library = format!(
            "my-spring/target/release/{}my_spring{}",
            std::env::consts::DLL_PREFIX,
            std::env::consts::DLL_SUFFIX
        );
        place.wireloom(&["plugin", "check", &library])?.expect(0)?;
        let run = ["run", "my-spring/my-spring.toml", "--allow-plugin", &library, "--out", kind];
        place.wireloom(&run)?.expect(0)?;
        closed_form(kind, &place.json(&format!("{kind}/result.json"))?)?;
    }
    parts_of_plugins_are_as_good(&place, &folder, &build)
}

/// As the first scenario has it.
const COLLAR: &str = "kind = \"collar\"";
const MODEL: &str = "model = \"cosserat\"";

/// Builds with another source.
type Build<'b> = dyn Fn(&[&str], &str) -> Result<std::process::Output, Failed> + 'b;

/// The built-in collar and joint, exported by a plugin under other names, hold a harness to the same bits, and pass the
/// check.
fn parts_of_plugins_are_as_good(place: &Place, folder: &Path, build: &Build<'_>) -> Checked {
    let manifest = fs::read_to_string(folder.join("Cargo.toml"))?;
    let models = format!("wireloom-models = {{ path = {:?} }}\n", root().join("crates/models"));
    fs::write(folder.join("Cargo.toml"), manifest.replace("[dependencies]\n", &format!("[dependencies]\n{models}")))?;
    let source = r#"
        use wireloom_plugin::core::registry::{ConstraintKind, JointKind};
        wireloom_plugin::export! { constraints: [kind()], joints: [joint()] }
        pub fn kind() -> ConstraintKind {
            ConstraintKind { name: "own-collar".into(), ..wireloom_models::constraints::collar() }
        }
        fn joint() -> JointKind {
            JointKind { name: "own-cosserat".into(), ..wireloom_models::joints::cosserat::kind() }
        }
    "#;
    let built = build(&["build"], source)?;
    ensure(built.status.success(), &built)?;
    let library = format!("target/release/{}my_spring{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let text = fs::read_to_string(root().join("scenarios/first.toml"))?;
    ensure(text.contains(COLLAR), "the first scenario has no collar")?;
    let mut found = vec![];
    place.wireloom(&["plugin", "check", &format!("my-spring/{library}")])?.expect(0)?;
    ensure(text.contains(MODEL), "the first scenario has no joint of this model")?;
    for (kind, model) in [("collar", "cosserat"), ("own-collar", "own-cosserat")] {
        let more = "\n[plugins]\nload = [\"target/release/my-spring\"]\n[output]\nincrements = true\npicture = false\n";
        let text =
            text.replace(COLLAR, &format!("kind = \"{kind}\"")).replace(MODEL, &format!("model = \"{model}\"")) + more;
        fs::write(folder.join("collars.toml"), text)?;
        let out = format!("out-{kind}");
        let arguments =
            ["run", "my-spring/collars.toml", "--allow-plugin", &format!("my-spring/{library}"), "--out", &out];
        place.wireloom(&arguments)?.expect(0)?;
        let mut result = place.json(&format!("{out}/result.json"))?;
        for step in result["steps"].as_array_mut().into_iter().flatten() {
            step["minimiser"]["seconds"] = Value::Null;
            for (_, constraint) in step["constraints"].as_object_mut().into_iter().flatten() {
                constraint["kind"] = Value::Null;
            }
        }
        found.push(result);
    }
    ensure(found[0]["steps"].as_array().is_some_and(|steps| steps.len() == 40), &found[0]["steps"])?;
    ensure(found[0]["steps"] == found[1]["steps"], "parts of a plugin give other bits than the built-in ones")
}

fn bad_names() -> Checked {
    let place = Place::new()?;
    for name in ["My-Spring", "7up", "a b", "../up", "", "ü"] {
        place.wireloom(&["plugin", "new", name, "--c"])?.expect(1)?.says(&["is no name for a plugin"])?;
    }
    place.wireloom(&["plugin", "new", "collar", "--c"])?.expect(1)?.says(&["a kind `collar` is built in"])?;
    place.wireloom(&["plugin", "new", "kirchhoff", "--c"])?.expect(1)?.says(&["a kind `kirchhoff` is built in"])?;
    fs::create_dir(place.path("mine"))?;
    place.wireloom(&["plugin", "new", "mine", "--c"])?.expect(1)?.says(&["there is a `mine` already"])?;
    place.wireloom(&["plugin", "new", "other", "--sources", "."])?.expect(1)?.says(&["--sources DIR", "--c"])?;
    Ok(())
}
