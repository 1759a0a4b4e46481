//! Joint models from plugins: one in C against the plain cable, and what it may do wrong.

use crate::*;

/// Fault of the plugin, exit code, and words of the message.
const WRONG: &[(u32, i32, &[&str])] = &[
    (1, 1, &["wrote no mounting: `create` must fill in the description"]),
    (2, 1, &["has mounting 7; 1 to 4 are known"]),
    (3, 1, &["returned success from `create` but wrote no instance"]),
    (4, 3, &["returned NaN as energy"]),
    (5, 3, &["returned -3 from `evaluate`"]),
    (6, 3, &["did not return within 0.5 s (in `evaluate`)"]),
    (7, 3, &["crashed: invalid memory access (SIGSEGV) (in `evaluate`)"]),
    (8, 3, &["wrote no energy in `evaluate`, which was requested"]),
    (9, 1, &["table of functions of kind `two-arm-spring` says it has 8 bytes; ABI 1.0 has"]),
    (10, 1, &["the function `destroy` of kind `two-arm-spring` is null"]),
    (11, 1, &["has no function `evaluate`"]),
    (12, 1, &["the family of kind `two-arm-spring` is 4; 1 is a constraint, 2 a joint model, 3 a rod"]),
    (13, 1, &["its kind `fused` already exists, from the program itself"]),
    (14, 1, &["the table of functions of kind `two-arm-spring` is null"]),
    (15, 1, &["the table of functions of kind `two-arm-spring` is null"]),
];

pub fn trials() -> Vec<Named> {
    let mut all = vec![
        named("a joint model in C is the plain cable, and passes the check", as_good_as_the_cable),
        named("a compliant hub in C is the built-in one, and passes the check", as_good_as_the_hub),
        named("a hub in C that slips is the built-in one, and passes the check", slips_as_the_hub),
        named("a joint model refuses arms that it cannot join", three_arms),
        named("a joint model that was built for ABI 1.6 is loaded", of_an_earlier_version),
    ];
    for (case, code, words) in WRONG {
        all.push((
            format!("hostile joint model, {}", words[0]),
            Box::new(move || {
                let place = Place::new()?;
                write(&place, *case, "two-arm-spring")?;
                let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "libjoiner.so"])?.expect(*code)?;
                ended.says(words)?;
                if *code == 3 {
                    ended.says(&["joint `J` (two-arm-spring) in step `hang`, "])?;
                    let fault = &place.json("out/s/result.json")?["fault"];
                    ensure(fault["joint"] == "J" && fault["kind"] == "two-arm-spring", fault)?;
                }
                Ok(())
            }),
        ));
    }
    all
}

/// The plugin, and the scenario of the built-in joint with this model instead.
fn write(place: &Place, case: u32, model: &str) -> Checked {
    let flag = format!("-DCASE={case}");
    compile(&root().join("tests/tests/plugins/joint.c"), &place.path("libjoiner.so"), &[&flag])?;
    let text = fs::read_to_string(root().join("scenarios/analytic/two_arm_joint.toml"))?;
    let own = "model = \"cosserat\"";
    ensure(text.contains(own) && text.contains("schema = 1\n"), "the scenario is another one now")?;
    let text = text
        .replace(own, &format!("model = \"{model}\""))
        .replace("wires = [{ between = [\"left\", \"right\"], share = 1.0 }]", "")
        .replace("schema = 1\n", "schema = 1\nplugins = { load = [\"joiner\"], time_limit = 0.5 }\n");
    fs::write(place.path("s.toml"), text)?;
    Ok(())
}

/// The spring bends as the rod does, but knows nothing of the variation of curvature around it.
fn as_good_as_the_cable() -> Checked {
    let place = Place::new()?;
    write(&place, 0, "two-arm-spring")?;
    let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "libjoiner.so"])?.expect(0)?;
    let words = "kind `two-arm-spring` of plugin `joiner` 0.0.1 (libjoiner.so) gives not all derivatives: gradient and \
                 Hessian are taken numerically";
    ensure(ended.out.contains(words), &ended)?;
    let result = place.json("out/s/result.json")?;
    let last = result["steps"].as_array().map_or(0, Vec::len) - 1;
    for (branch, first, nodes) in [("left", 0, 25), ("right", 24, 37)] {
        for node in 0..nodes {
            for (axis, shift) in [(0, 0.0), (1, 0.5), (2, 0.0)] {
                let got = number(&result, &format!("/steps/{last}/branches/{branch}/position/{node}/{axis}"));
                let plain = number(&result, &format!("/steps/{last}/branches/plain/position/{}/{axis}", first + node));
                ensure((got - shift - plain).abs() < 1e-5, format!("{branch} {node} {axis}: {got} beside {plain}"))?;
            }
        }
    }
    let listed = place.wireloom_with(&["plugin", "list"], Some(place.0.path()))?.expect(0)?;
    ensure(listed.out.contains("joint model `two-arm-spring`: a spring between two arms"), &listed)
}

/// The built-in springs are k φ to the fourth power of the angle, which is 0.24 rad at most.
fn as_good_as_the_hub() -> Checked {
    let place = Place::new()?;
    compile(&root().join("tests/tests/plugins/joint.c"), &place.path("libjoiner.so"), &["-DCASE=20"])?;
    let text = fs::read_to_string(root().join("scenarios/analytic/compliant_hub.toml"))?;
    ensure(text.contains("model = \"compliant-hub\""), "the scenario is another one now")?;
    // Differences of the energy reach a balance of 1e-6.
    let text = text.replace("force_tolerance = 1e-9", "force_tolerance = 1e-5");
    fs::write(place.path("h.toml"), &text)?;
    let own = text.replace("model = \"compliant-hub\"", "model = \"two-arm-spring\"");
    fs::write(place.path("s.toml"), own.replace("schema = 1\n", "schema = 1\nplugins = { load = [\"joiner\"] }\n"))?;
    place.wireloom(&["run", "h.toml"])?.expect(0)?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "libjoiner.so"])?.expect(0)?;
    let [built_in, plugin] = [place.json("out/h/result.json")?, place.json("out/s/result.json")?];
    for step in 0..3 {
        for (branch, nodes) in [("left", 21), ("right", 31)] {
            for (node, axis) in (0..nodes).flat_map(|node| (0..3).map(move |axis| (node, axis))) {
                let at = format!("/steps/{step}/branches/{branch}/position/{node}/{axis}");
                let [want, got] = [&built_in, &plugin].map(|result| number(result, &at));
                ensure((got - want).abs() < 2e-5, format!("{at}: {got} beside {want}"))?;
            }
        }
    }
    let checked = place.wireloom(&["plugin", "check", "libjoiner.so"])?.expect(0)?;
    ensure(checked.out.contains("a hub, the ends of the arms have frames"), &checked)
}

/// What it remembers is committed with each increment: after the last step, let go, the cable has the same set.
fn slips_as_the_hub() -> Checked {
    let place = Place::new()?;
    compile(&root().join("tests/tests/plugins/joint.c"), &place.path("libjoiner.so"), &["-DCASE=21"])?;
    let text = fs::read_to_string(root().join("scenarios/analytic/arm_friction.toml"))?;
    let friction = text.find("[joints.arms.friction]").zip(text.find("[[constraints]]"));
    let (from, to) = friction.ok_or("the scenario is another one now")?;
    let text = text.replace("force_tolerance = 1e-9", "force_tolerance = 1e-5");
    let elastic = [&text[..from], &text[to..]].concat();
    let friction = "friction = { bending = [{ stiffness = 0.2, moment = 0.01 }] }\n";
    let built_in = "model = \"compliant-hub\"\n";
    fs::write(place.path("h.toml"), elastic.replace(built_in, &format!("{built_in}{friction}")))?;
    let own = elastic.replace(built_in, "model = \"two-arm-spring\"\n");
    let loads = "schema = 1\nplugins = { load = [\"joiner\"] }\n";
    fs::write(place.path("s.toml"), own.replace("schema = 1\n", loads))?;
    place.wireloom(&["run", "h.toml"])?.expect(0)?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "libjoiner.so"])?.expect(0)?;
    let [built_in, plugin] = [place.json("out/h/result.json")?, place.json("out/s/result.json")?];
    for (step, node, axis) in (0..4)
        .flat_map(|step| [10, 30].map(|node| (step, node)))
        .flat_map(|(step, node)| (0..3).map(move |axis| (step, node, axis)))
    {
        let at = format!("/steps/{step}/branches/right/position/{node}/{axis}");
        let [want, got] = [&built_in, &plugin].map(|result| number(result, &at));
        ensure((got - want).abs() < 5e-5, format!("{at}: {got} beside {want}"))?;
    }
    let let_go = number(&plugin, "/steps/1/branches/right/position/30/2");
    ensure(let_go.abs() > 0.01, format!("it keeps no set: {let_go} m"))?;
    place.wireloom(&["plugin", "check", "libjoiner.so"])?.expect(0).map(|_| ())
}

/// Its descriptors end before what ABI 1.7 appended.
fn of_an_earlier_version() -> Checked {
    let place = Place::new()?;
    write(&place, 22, "two-arm-spring")?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "libjoiner.so"])?.expect(0).map(|_| ())
}

fn three_arms() -> Checked {
    let place = Place::new()?;
    write(&place, 0, "two-arm-spring")?;
    let text = fs::read_to_string(root().join("scenarios/branches/y_cosserat.toml"))?;
    let text = text.replace("model = \"cosserat\"", "model = \"two-arm-spring\"");
    fs::write(place.path("y.toml"), text.replace("schema = 1\n", "schema = 1\nplugins = { load = [\"joiner\"] }\n"))?;
    let ended = place.wireloom(&["run", "y.toml", "--allow-plugin", "libjoiner.so"])?.expect(1)?;
    ended.says(&["refuses: it joins two arms, not more"])
}
