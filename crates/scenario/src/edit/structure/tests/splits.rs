//! Branches that are split.

use super::*;

#[test]
fn a_branch_is_split_and_what_attaches_behind_follows() {
    let swept = TEXT.replace("[sweep]", "[other]");
    let plain = &swept[..swept.find("[other]").unwrap()];
    let text = with_split(plain, "trunk", 0.25, "trunk 2", "T").expect("inside it");
    let mut found = difference(plain, &text);
    let mut expected = vec![
        "-to = \"J\" # the joint",
        "-length = \"600 mm\" # by the drawing",
        "-segments = 60",
        "-  { branch = \"trunk\", direction = [-1, 0, 0], up = [0, 0, 1] }, # from behind",
        wires("-", "trunk"),
        "-at = { branch = \"trunk\", s = \"300 mm\" }",
        "+to = \"T\" # the joint",
        "+length = \"250 mm\" # by the drawing",
        "+segments = 25",
        "+[[branches]]",
        "+name = \"trunk 2\"",
        "+from = \"T\"",
        "+to = \"J\"",
        "+section = \"cable\"",
        "+length = \"350 mm\"",
        "+segments = 35",
        "+  { branch = \"trunk 2\", direction = [-1, 0, 0], up = [0, 0, 1] }, # from behind",
        wires("+", "trunk 2"),
        "+[[joints]]",
        "+name = \"T\"",
        "+arms = [",
        "+  { branch = \"trunk\", direction = [-1, 0, 0], up = [0, 0, 1] },",
        "+  { branch = \"trunk 2\", direction = [1, 0, 0], up = [0, 0, 1] },",
        "+]",
        "+at = { branch = \"trunk 2\", s = \"50 mm\" }",
        "+[[requirements]]",
        "+name = \"trunk bend (trunk 2)\"",
        "+quantity = \"bend_radius\"",
        "+of = { branch = \"trunk 2\" }",
        "+min = \"30 mm\"",
        "+steps = [\"mate\"]",
    ];
    expected.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, expected, "{text}");
    let behind = text.find("name = \"trunk 2\"").unwrap();
    assert!(behind < text.find("name = \"left\"").unwrap(), "{text}");
    // Exactly at the clip: the joint is what it holds.
    let text = with_split(plain, "trunk", 0.3, "trunk 2", "T").expect("inside it");
    assert!(text.contains("at = { joint = \"T\" }"), "{text}");
    let said = |branch: &str, s: f64| message(with_split(plain, branch, s, "b2", "T"));
    assert!(said("trunk", 0.6).contains("give a place inside it, between 0 and 0.6 m"), "{}", said("trunk", 0.6));
    assert!(said("trunk", f64::NAN).contains("cannot be split"));
    assert!(said("nothing", 0.1).contains("there is no branch"));
    let varied = "[sweep] varies `branches.trunk.length`, and branch \"trunk\" is to become two";
    assert!(message(with_split(TEXT, "trunk", 0.1, "b2", "T")).contains(varied));
    let wrapped =
        format!("{plain}\n[[loads]]\nname = \"wind\"\nspan = {{ branch = \"left\", from = 0.1, to = 0.3 }}\n");
    assert!(
        message(with_split(&wrapped, "left", 0.2, "b2", "T"))
            .contains("along a span of branch \"left\" across s = 0.2 m")
    );
    let behind = with_split(&wrapped, "left", 0.05, "b2", "T").expect("before the span");
    assert!(behind.contains("span = { branch = \"b2\", from = 0.05, to = 0.25 }"), "{behind}");
}

#[test]
fn a_path_and_a_drawn_line_are_divided_where_their_branch_is() {
    let path = "path = [[0, 0, 0], [\"100 mm\", 0, 0], [0.1, 0.3, 0]]\ndrawn = [[0, 0, 1], [0.8, 0, 1]]";
    let text = format!("[[branches]]\nname = \"b\"\nfrom = \"A\"\nto = \"B\"\nlength = \"0.8 m\"\n{path}\n");
    let text = with_split(&text, "b", 0.4, "b2", "J").expect("inside it");
    assert!(text.contains("path = [[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0]]"), "{text}");
    assert!(text.contains("path = [[0.1, 0.1, 0], [0.1, 0.3, 0]]") && text.contains("length = \"0.4 m\""), "{text}");
    assert!(text.contains("drawn = [[0, 0, 1], [0.4, 0, 1]]") && text.contains("drawn = [[0.4, 0, 1], [0.8, 0, 1]]"));
}

/// The text without its sweep.
fn plain() -> &'static str {
    &TEXT[..TEXT.find("[sweep]").unwrap()]
}

/// A requirement in a text, as one line of `[[requirements]]`.
fn requirement(name: &str, keys: &str) -> String {
    format!("\n[[requirements]]\nname = \"{name}\"\n{keys}\n")
}

/// What the text says of the trunk when it is split at 0.25 m into "trunk" and "trunk 2".
fn split_trunk(further: &str) -> Result<String, Fault> {
    with_split(&format!("{}{further}", plain()), "trunk", 0.25, "trunk 2", "T")
}

/// It stayed on the first half, and a failed one passed.
#[test]
fn a_requirement_between_a_branch_and_another_part_counts_on_both_halves() {
    let near = requirement(
        "gap",
        "quantity = \"clearance\"\nbetween = [{ branch = \"trunk\", to = 0.4 }, { obstacle = \"wall\" }]\nmin = 0.01",
    );
    let text = split_trunk(&near).expect("both halves keep it");
    assert!(text.contains("between = [{ branch = \"trunk\"}, { obstacle = \"wall\" }]"), "{text}");
    let second = "name = \"gap (trunk 2)\"\nquantity = \"clearance\"\n\
                  between = [{ branch = \"trunk 2\", to = 0.15 }, { obstacle = \"wall\" }]\nmin = 0.01";
    assert!(text.contains(second), "{text}");
    // As tables of their own.
    let tables = "\n[[requirements]]\nname = \"gap\"\nquantity = \"clearance\"\nmin = 0.01\n\
                  [[requirements.between]]\nbranch = \"trunk\"\n[[requirements.between]]\nbranch = \"left\"\n";
    let text = split_trunk(tables).expect("both halves keep it");
    assert!(text.contains("between = [{ branch = \"trunk 2\" }, { branch = \"left\" }]"), "{text}");
    let sub =
        "\n[[requirements]]\nname = \"soft\"\nquantity = \"tension\"\nmax = 1\n[requirements.of]\nbranch = \"trunk\"\n";
    let text = split_trunk(sub).expect("both halves keep it");
    assert!(
        text.contains("name = \"soft (trunk 2)\"\nquantity = \"tension\"\nmax = 1\nof = { branch = \"trunk 2\" }"),
        "{text}"
    );
    let itself =
        "quantity = \"clearance\"\nbetween = [{ branch = \"trunk\" }, { branch = \"trunk\", from = 0.2 }]\nmin = 0.01";
    let said = message(split_trunk(&requirement("loop", itself)));
    assert!(said.contains("requirement \"loop\" is between branch \"trunk\" and itself"), "{said}");
}

/// A pattern that named the branch did not name its second half, and a failed requirement passed.
#[test]
fn a_requirement_with_a_pattern_that_names_one_half_refuses_the_split() {
    let of = |pattern: &str| {
        requirement("r", &format!("quantity = \"bend_radius\"\nof = {{ branches = \"{pattern}\" }}\nmin = 0.05"))
    };
    let said = |pattern: &str| message(split_trunk(&of(pattern)));
    assert!(
        said("trun?").contains("is about branches like \"trun?\": \"trunk\", and not \"trunk 2\""),
        "{}",
        said("trun?")
    );
    assert!(said("* 2").contains("is about branches like \"* 2\": \"trunk 2\", and not \"trunk\""), "{}", said("* 2"));
    assert!(split_trunk(&of("t*")).is_ok() && split_trunk(&of("left")).is_ok());
    let between = "quantity = \"clearance\"\nbetween = [{ branches = \"trunk\" }, { obstacle = \"wall\" }]\nmin = 0.01";
    assert!(message(split_trunk(&requirement("r", between))).contains("and not \"trunk 2\""));
}

/// Two halves that each have one turn passed what two turns failed.
#[test]
fn a_requirement_on_a_branch_as_a_whole_refuses_the_split() {
    for (keys, refuses) in [
        ("quantity = \"turns\"\nof = { branch = \"trunk\" }\nmax = 1.5", true),
        ("quantity = \"turns\"\nof = { branch = \"trunk\", to = 0.1 }\nmax = 1.5", true),
        ("quantity = \"turns\"\nmax = 1.5", true),
        ("quantity = \"reach\"\nof = { branches = \"*\" }\nmax = 0.98", true),
        ("quantity = \"slack\"\nof = { branch = \"trunk\" }\nmin = 0.01", true),
        ("quantity = \"slack\"\nof = { branch = \"trunk\", to = 0.1 }\nmin = 0.01", false),
        ("quantity = \"contact_force\"\nof = { branch = \"trunk\" }\nmax = 4", true),
        ("quantity = \"contact_force\"\nof = { obstacle = \"wall\" }\nmax = 4", false),
        ("quantity = \"clearance\"\nof = { branch = \"trunk\" }\nmax = 0.1", true),
        ("quantity = \"turns\"\nof = { branch = \"left\" }\nmax = 1.5", false),
        ("quantity = \"tension\"\nmax = 4", false),
        ("quantity = \"bend_radius\"\nof = { branch = \"trunk\" }\nmin = 0.05\nmotion = \"moving\"", true),
        ("quantity = \"bend_radius\"\nof = { branches = \"t*\" }\nmin = 0.05\nmotion = \"moving\"", true),
        ("quantity = \"bend_radius\"\nmin = 0.05\nmotion = \"moving\"", true),
        ("quantity = \"bend_radius\"\nof = { branch = \"left\" }\nmin = 0.05\nmotion = \"moving\"", false),
    ] {
        let said = message(split_trunk(&requirement("r", keys)));
        assert_eq!(said.contains("of branch \"trunk\" as a whole"), refuses, "{keys}: {said}");
    }
}

/// Keys of places, of every branch, and of outputs were not seen.
#[test]
fn a_split_is_refused_where_a_study_varies_or_measures_what_it_changes() {
    let said = |study: &str| message(split_trunk(study));
    let varied = |key: &str| said(&format!("\n[sweep.vary]\n'{key}' = {{ from = 0.1, to = 0.2 }}\n"));
    for key in [
        "branches.trunk.length",
        "branches.\"trunk\".length",
        "branches.*.length",
        "branches.0.length",
        "branches.1.length",
        "constraints.clip.at.s",
        "constraints.*.at.s",
        "joints.J.arms.trunk.direction.0",
        "requirements.trunk bend.min",
    ] {
        assert!(varied(key).contains("[sweep] varies `"), "{key}: {}", varied(key));
    }
    for key in ["branches.left.length", "constraints.plug-A.at.s", "sections.cable.diameter", "gravity.2"] {
        assert!(!varied(key).contains("[sweep]") || varied(key).contains("taken: "), "{key}: {}", varied(key));
    }
    let output = "\n[sweep.outputs]\ntip = { quantity = \"position\", of = { branch = \"trunk\", s = 0.5 } }\n";
    assert!(said(output).contains("[sweep] names branch \"trunk\""), "{}", said(output));
    let place = "\n[optimise.vary]\n\"constraints.plug-A.at\" = { values = [{ branch = \"trunk\", s = 0.5 }] }\n";
    assert!(said(place).contains("[optimise] names branch \"trunk\""), "{}", said(place));
    for minimise in ["\"trunk bend\"", "[{ name = \"trunk bend\", weight = 2 }]"] {
        let said = said(&format!("\n[optimise]\nminimise = {minimise}\n"));
        assert!(said.contains("[optimise] minimises requirement \"trunk bend\""), "{said}");
    }
    assert!(split_trunk("\n[optimise]\nminimise = \"length\"\n").is_ok());
}

/// The nearest place may lie on the second half.
#[test]
fn a_clip_that_closes_at_the_nearest_place_refuses_the_split() {
    let clip = "\n[[steps]]\nname = \"close\"\n[[steps.clip]]\nname = \"c\"\nat = { branch = \"trunk\" }\n\
                position = [0, 0, 0]\n";
    let said = message(split_trunk(clip));
    assert!(said.contains("an entry of `steps` closes at the nearest place of branch \"trunk\""), "{said}");
}

/// The second half had the part number too: the parts list counted it twice.
#[test]
fn the_part_number_of_a_branch_and_of_a_component_stays_on_the_first_half() {
    let text = plain().replacen("segments = 60", "segments = 60\npart = \"4711\"\ncolour = \"black\"", 1);
    let tape =
        "\n[[components]]\nname = \"tape\"\nkind = \"tape\"\npart = \"4712\"\nbranch = \"trunk\"\nto = \"400 mm\"\n";
    let clip = "\n[[components]]\nname = \"mark\"\nbranch = \"trunk\"\nfrom = 0.3\nto = 0.35\n";
    let text = with_split(&format!("{text}{tape}{clip}"), "trunk", 0.25, "trunk 2", "T").expect("inside it");
    assert_eq!((text.matches("4711").count(), text.matches("4712").count(), text.matches("black").count()), (1, 1, 1));
    assert!(text.contains("name = \"tape\"\nkind = \"tape\"\npart = \"4712\"\nbranch = \"trunk\"\n\n"), "{text}");
    let second = "name = \"tape (trunk 2)\"\nkind = \"tape\"\nbranch = \"trunk 2\"\nto = \"150 mm\"\n";
    assert!(text.contains(second), "{text}");
    assert!(text.contains("name = \"mark\"\nbranch = \"trunk 2\"\nfrom = 0.05\nto = 0.1\n"), "{text}");
}

/// The wire lost the length of the second half.
#[test]
fn a_wire_runs_through_both_halves_in_their_order() {
    let wire = |name: &str, way: &str| format!("\n[[connections]]\nname = \"{name}\"\nbranches = {way}\n");
    let wires = [("forth", r#"["trunk", "left"]"#), ("back", r#"["left", "trunk"]"#), ("alone", r#"["trunk"]"#)];
    let text = split_trunk(&wires.map(|(name, way)| wire(name, way)).concat()).expect("inside it");
    for (name, way) in [
        ("forth", r#"["trunk", "trunk 2", "left"]"#),
        ("back", r#"["left", "trunk 2", "trunk"]"#),
        ("alone", r#"["trunk", "trunk 2"]"#),
    ] {
        assert!(text.contains(&wire(name, way)), "{name}: {text}");
    }
}

/// The half that does not move was not held to the radius while moving.
#[test]
fn a_bend_radius_while_moving_refuses_the_split() {
    let limited = plain().replacen("[sections.cable]", "[sections.cable]\nmin_bend_radius_moving = 0.05", 1);
    assert_ne!(limited, plain());
    let said = message(with_split(&limited, "trunk", 0.25, "trunk 2", "T"));
    assert!(said.contains("section \"cable\" has `min_bend_radius_moving`"), "{said}");
}

#[test]
fn parts_with_another_section_stay_on_their_halves() {
    let swept = TEXT.replace("[sweep]", "[other]");
    let thin = "{ section = \"thin\", to = \"100 mm\" }";
    let tube = "{ section = \"tube\", from = \"200 mm\", to = \"400 mm\" }";
    let parts = format!("sections = [{thin}, {tube}, {{ section = \"thin\", from = \"500 mm\" }}]\n");
    let own = "section = \"cable\"\n";
    let plain = swept[..swept.find("[other]").unwrap()].replacen(own, &[own, &parts].concat(), 1);
    let split = |s: f64| {
        let text = with_split(&plain, "trunk", s, "trunk 2", "T").expect("inside it");
        let lines = text.lines().filter(|line| line.starts_with("sections = ")).map(str::to_owned);
        lines.collect::<Vec<_>>()
    };
    assert_eq!(
        split(0.25),
        [
            format!("sections = [{thin}, {{ section = \"tube\", from = \"200 mm\" }}]"),
            "sections = [{ section = \"tube\", to = \"150 mm\" }, { section = \"thin\", from = \"250 mm\" }]"
                .to_owned(),
        ]
    );
    assert_eq!(
        split(0.45),
        [format!("sections = [{thin}, {tube}]"), "sections = [{ section = \"thin\", from = \"50 mm\" }]".to_owned()]
    );
    assert_eq!(split(0.05).len(), 2);
    let named = renamed(&plain, Part::Section, "cable", "wire").expect("a section");
    assert!(named.contains("section = \"wire\"\nsections = [{ section = \"thin\""), "{named}");
    let bare = plain.replacen("{ section = \"thin\", from = \"500 mm\" }", "{ section = \"cable\", from = 0.5 }", 1);
    assert!(renamed(&bare, Part::Section, "cable", "wire").expect("a section").contains("{ section = \"wire\", from"));
}
