//! Rods from plugins: one in C against the built-in one, and what it may do wrong.

use crate::*;

/// Fault of the plugin, exit code, and words of the message.
const WRONG: &[(u32, i32, &[&str])] = &[
    (1, 1, &["returned success from `create` but wrote no instance"]),
    (2, 1, &["has no law of stretch and none of bending: `create` must fill in the description"]),
    (3, 1, &["has no function `bend`, which it describes"]),
    (4, 3, &["returned NaN as moments, entry 122 of 123"]),
    (5, 3, &["returned -3 from `bend`"]),
    (6, 3, &["did not return within 0.5 s (in `bend`)"]),
    (7, 3, &["crashed: invalid memory access (SIGSEGV) (in `bend`)"]),
    (8, 3, &["wrote no energies, entry 0 of 41 in `bend`, which was requested"]),
    (9, 1, &["table of functions of kind `straight-laws` says it has 8 bytes; ABI 1.0 has"]),
    (10, 1, &["the function `destroy` of kind `straight-laws` is null"]),
    (11, 1, &["the family of kind `straight-laws` is 4; 1 is a constraint, 2 a joint model, 3 a rod"]),
    (12, 1, &["its kind `kirchhoff` already exists, from the program itself"]),
    (13, 1, &["the table of functions of kind `straight-laws` is null"]),
    (14, 3, &["wrote beyond the end of the array `moments`, which has 123 numbers (in `bend`)"]),
    (15, 3, &["wrote before the beginning of the array `Hessians`, which has 360 numbers (in `stretch`)"]),
    (16, 1, &["branch \"cable\": plugin `rodder` 0.0.1 (librodder.so) refuses: it is too long"]),
    (17, 1, &["wrote beyond the end of the description in `create`"]),
    (30, 3, &["its first derivatives are not those of its values: along one line they give a slope of"]),
    (31, 3, &["its first derivatives are not those of its values: along one line they give a slope of"]),
    (32, 3, &["its second derivatives are not those of its first derivatives: along one line they give a slope of"]),
];

/// As `WRONG`, of the rod that remembers.
const WRONG_MEMORY: &[(u32, i32, &[&str])] = &[
    (1, 1, &["has a memory of couplings, and no function `commit`"]),
    (2, 1, &["says that a coupling remembers 5000 numbers; at most 1000 can be"]),
    (3, 1, &["has a memory of couplings, and no law of bending"]),
    (4, 3, &["returned NaN as memory, entry 1 of 102"]),
    (5, 3, &["as dissipated energy in `commit`; it is never negative"]),
    (7, 3, &["wrote beyond the end of the array `memory`, which has 102 numbers (in `commit`)"]),
];

/// Case of a memory that is wrong, and what is.
const FORGETS: &[(u32, &str)] =
    &[(6, "remembers another slip than its moments"), (8, "dissipates without a slip"), (4, "remembers no number")];

/// Case of numbers that are wrong, what is wrong, and tests of `plugin check` that must fail.
const FOUND: &[(u32, &str, &[&str])] = &[
    (30, "doubled forces", &["forces are the derivative of the energy", "a run finds no derivatives wrong"]),
    (31, "an energy that exerts nothing", &["forces are the derivative of the energy"]),
    (32, "wrong second derivatives", &["hessian is the derivative of the forces", "a run finds no derivatives wrong"]),
    (33, "a law that knows the direction", &["the sign of the first component changes nothing"]),
    (34, "second derivatives that are not symmetric", &["hessian is the derivative of the forces"]),
    (35, "an energy at rest", &["there is no energy at rest and nowhere less"]),
    (4, "a number that is none", &["forces are the derivative of the energy", "rigid motion changes nothing"]),
];

pub fn trials() -> Vec<Named> {
    let mut all = vec![
        named("a rod in C is the built-in one of the same laws, and passes the check", as_good_as_the_built_in),
        named("a rod that leaves second derivatives to the program finds the same equilibrium", without_hessian),
        named("the parameters of a rod are checked as those of a built-in one", parameters),
        named("joints and sections that a rod of a plugin would leave out are refused", refused),
        named("a rod in C that remembers is the section with the same friction", remembers_as_a_section),
        named("a place that slides is refused on a rod of a plugin that remembers", slides_on_what_remembers),
    ];
    for (case, code, words) in WRONG_MEMORY {
        let slips = move || slipping(&Place::new()?, *case, ELEMENT, *code)?.says(words);
        all.push((format!("hostile memory of a rod {case}, {}", words[0]), Box::new(slips)));
    }
    for (case, what) in FORGETS {
        all.push((
            format!("plugin check finds a rod that {what}"),
            Box::new(move || {
                let place = Place::new()?;
                build(&place, "slipping", *case)?;
                let ended = place.wireloom(&["plugin", "check", "libslipping.so"])?.expect(3)?;
                ensure(ended.out.contains("an increment is remembered once … FAILED"), &ended)
            }),
        ));
    }
    for (case, code, words) in WRONG {
        all.push((
            format!("hostile rod {case}, {}", words[0]),
            Box::new(move || {
                let ended = run(&Place::new()?, *case, "", *code)?;
                ended.says(words)?;
                if *code == 3 { ended.says(&["rod `cable` (straight-laws) in step `hang`, "]) } else { Ok(()) }
            }),
        ));
    }
    for (case, what, tests) in FOUND {
        all.push((
            format!("plugin check finds {what} of a rod"),
            Box::new(move || {
                let place = Place::new()?;
                build(&place, "rodder", *case)?;
                let ended = place.wireloom(&["plugin", "check", "librodder.so"])?.expect(3)?;
                let all = tests.iter().all(|test| ended.out.contains(&format!("{test} … FAILED")));
                ensure(all, &ended)
            }),
        ));
    }
    all
}

/// Builds a library out of its source here.
fn build(place: &Place, name: &str, case: u32) -> Checked {
    let source = root().join(format!("tests/tests/plugins/{name}.c"));
    compile(&source, &place.path(&format!("lib{name}.so")), &[&format!("-DCASE={case}")])
}

/// A cable that hangs, twisted, between two clamps, with these lines in its section and its branch.
fn scenario(section: &str, branch: &str) -> String {
    format!(
        r#"
        schema = 1
        name = "hanging"
        [sections.cable]
        diameter = "6 mm"
        linear_density = "50 g/m"
        axial_stiffness = 1e4
        torsion_stiffness = 0.008
        {section}
        [[branches]]
        name = "cable"
        from = "A"
        to = "B"
        section = "cable"
        length = 0.6
        segments = 40
        {branch}
        [[constraints]]
        name = "A"
        kind = "connector"
        at = {{ end = "A" }}
        position = [0, 0, 0]
        tangent = [1, 0, 0]
        up = [0, 0, 1]
        [[constraints]]
        name = "B"
        kind = "connector"
        at = {{ end = "B" }}
        position = [0.4, 0.1, 0]
        tangent = [1, 0, 0]
        up = [0, 1, 0]
        [[steps]]
        name = "hang"
        [minimiser]
        force_tolerance = 1e-10
        "#
    )
}

const STIFF: &str = "bending_stiffness = 0.01";
const LOADS: &str = "plugins = { load = [\"rodder\"], time_limit = 0.5 }";

/// Runs the cable as the rod of a case.
fn run(place: &Place, case: u32, more: &str, code: i32) -> Result<Ended, Failed> {
    build(place, "rodder", case)?;
    let text = scenario(STIFF, &format!("rod = \"straight-laws\"\n{more}"));
    fs::write(place.path("s.toml"), text.replace("schema = 1", &format!("schema = 1\n{LOADS}")))?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "librodder.so"])?.expect(code)
}

/// Positions and moments of the run beside those of a built-in rod of the same scheme.
fn is_the_built_in(place: &Place, tolerance: f64) -> Checked {
    // A curve through points on a line is EI; with it the scheme is of second order, as it is with laws of plugins.
    let line = "bending_curve = [[1, 0.01], [2, 0.02], [3, 0.03]]";
    fs::write(place.path("b.toml"), scenario(line, ""))?;
    place.wireloom(&["run", "b.toml"])?.expect(0)?;
    let [built_in, plugin] = [place.json("out/b/result.json")?, place.json("out/s/result.json")?];
    for (key, size) in [("position", 1.0), ("moment", 0.02)] {
        for (node, axis) in (0..41).flat_map(|node| (0..3).map(move |axis| (node, axis))) {
            let at = format!("/steps/0/branches/cable/{key}/{node}/{axis}");
            let [want, got] = [&built_in, &plugin].map(|result| number(result, &at));
            ensure((got - want).abs() < tolerance * size, format!("{at}: {got} beside {want}"))?;
        }
    }
    let [want, got] = [&built_in, &plugin].map(|result| number(result, "/steps/0/branches/cable/bend_radius/0"));
    near("radius at the clamp", got, want, tolerance)
}

fn as_good_as_the_built_in() -> Checked {
    let place = Place::new()?;
    let ended = run(&place, 0, "", 0)?;
    ensure(!ended.out.contains("numerically"), &ended)?;
    is_the_built_in(&place, 1e-9)?;
    let listed = place.wireloom_with(&["plugin", "list"], Some(place.0.path()))?.expect(0)?;
    ensure(listed.out.contains("rod `straight-laws`: the laws of its section"), &listed)?;
    let checked = place.wireloom(&["plugin", "check", "librodder.so"])?.expect(0)?;
    ensure(checked.out.contains("ok: laws of stretch and of bending"), &checked)
}

fn without_hessian() -> Checked {
    let place = Place::new()?;
    let ended = run(&place, 20, "", 0)?;
    let words = "kind `straight-laws` of plugin `rodder` 0.0.1 (librodder.so) gives not all derivatives: the Hessian \
                 is taken numerically";
    ensure(ended.out.contains(words), &ended)?;
    is_the_built_in(&place, 1e-8)?;
    let checked = place.wireloom(&["plugin", "check", "librodder.so"])?.expect(0)?;
    ensure(checked.out.contains("hessian is the derivative of the forces … not tested"), &checked)
}

fn parameters() -> Checked {
    let place = Place::new()?;
    run(&place, 0, "tightness = 0.5", 0)?;
    run(&place, 0, "tightnes = 0.5", 1)?
        .says(&["s.toml:19:1: unknown key `tightnes` in branch \"cable\"", "did you mean `tightness`?"])?;
    run(&place, 0, "tightness = 2", 1)?.says(&["`tightness` = 2 is too large", "it must be from 0 to 1"])?;
    let text = fs::read_to_string(place.path("s.toml"))?.replace("straight-laws", "straight-law");
    fs::write(place.path("s.toml"), text)?;
    let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "librodder.so"])?.expect(1)?;
    ended.says(&["straight-law", "straight-laws"])
}

fn refused() -> Checked {
    let place = Place::new()?;
    build(&place, "rodder", 0)?;
    let branch = "rod = \"straight-laws\"";
    let friction = format!("{STIFF}\nfriction = {{ bending = [{{ stiffness = 0.01, moment = 0.01 }}] }}");
    let text = scenario(&friction, branch).replace("schema = 1", &format!("schema = 1\n{LOADS}"));
    fs::write(place.path("s.toml"), text)?;
    let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "librodder.so"])?.expect(1)?;
    ended.says(&["has `friction`, and its rod \"straight-laws\" does not say that it models this"])?;
    let text = fs::read_to_string(root().join("scenarios/analytic/two_arm_joint.toml"))?;
    let text = text.replace("schema = 1\n", &format!("schema = 1\n{LOADS}\n"));
    fs::write(place.path("j.toml"), text.replace("name = \"left\"\n", &format!("name = \"left\"\n{branch}\n")))?;
    let ended = place.wireloom(&["run", "j.toml", "--allow-plugin", "librodder.so"])?.expect(1)?;
    ended.says(&["by its linear stiffness, but its rod \"straight-laws\" has another law", "model = \"fused\""])
}

/// Friction in `analytic/friction_set.toml`, as the rod of a plugin has it.
const ELEMENT: &str = "rod = \"slipping\"\nslip_stiffness = 0.02\nslip_moment = 0.01\n";

/// A cable that is turned at its end and let go, turned back and let go, with these lines in its branch.
fn turned(branch: &str, friction: &str) -> Result<String, Failed> {
    let text = fs::read_to_string(root().join("scenarios/analytic/friction_set.toml"))?;
    let (before, after) = text.split_once("[sections.cable.friction]").ok_or("the scenario has no friction")?;
    let (_, after) = after.split_once("]\n\n").ok_or("its friction has no end")?;
    let text = format!("{before}{friction}\n{after}");
    let text = text.replace("schema = 1\n", "schema = 1\nplugins = { load = [\"slipping\"], time_limit = 0.5 }\n");
    Ok(text.replace("segments = 50\n", &format!("segments = 50\n{branch}")))
}

/// Runs that cable as the rod that remembers.
fn slipping(place: &Place, case: u32, branch: &str, code: i32) -> Result<Ended, Failed> {
    build(place, "slipping", case)?;
    fs::write(place.path("s.toml"), turned(branch, "")?)?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "libslipping.so"])?.expect(code)
}

/// Both are of second order in the segment length: they agree to the tolerance of the equilibrium.
fn remembers_as_a_section() -> Checked {
    let place = Place::new()?;
    slipping(&place, 0, ELEMENT, 0)?;
    let friction = "friction = { bending = [{ stiffness = 0.02, moment = 0.01 }] }";
    fs::write(place.path("b.toml"), turned("", friction)?)?;
    place.wireloom(&["run", "b.toml", "--out", "b", "--allow-plugin", "libslipping.so"])?.expect(0)?;
    let [section, plugin] = [place.json("b/result.json")?, place.json("out/s/result.json")?];
    let branch = |step: usize, key: &str| format!("/steps/{step}/branches/cable/{key}");
    for step in 0..4 {
        for (key, tolerance) in [("position/50/0", 1e-9), ("friction/set/25/1", 1e-9), ("friction/dissipated", 1e-9)] {
            let at = branch(step, key);
            near(&at, number(&plugin, &at), number(&section, &at), tolerance)?;
        }
    }
    let set = number(&plugin, &branch(1, "friction/set/25/1"));
    ensure(set.abs() > 0.3, format!("a set of {set} 1/m"))?;
    let checked = place.wireloom(&["plugin", "check", "libslipping.so"])?.expect(0)?;
    ensure(checked.out.contains("a coupling remembers 2 numbers"), &checked)?;
    ensure(checked.out.contains("an increment is remembered once … ok"), &checked)
}

fn slides_on_what_remembers() -> Checked {
    let place = Place::new()?;
    let sliding = "[[constraints]]\nname = \"ring\"\nkind = \"handle\"\nat = { branch = \"cable\", s = 0.2 }\nposition \
                   = [0.2, 0, 0]\nslide = true\n";
    let text = turned(ELEMENT, "")?.replacen("[[steps]]", &format!("{sliding}[[steps]]"), 1);
    build(&place, "slipping", 0)?;
    fs::write(place.path("s.toml"), text)?;
    let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "libslipping.so"])?.expect(1)?;
    ended.says(&["moves the mesh along branch \"cable\", whose rod \"slipping\" remembers"])
}
