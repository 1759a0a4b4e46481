//! Types of constraints: shipped, of a library file, of the scenario. Values of a constraint take precedence over its
//! type.

mod common;

use wireloom_core::constraint::{Limits, Slide};
use wireloom_core::{HoldWord, Value};
use wireloom_scenario::{Constraint, Files, NoFiles, parse, parse_with_files, render};

const HARNESS: &str = concat!(include_str!("section.toml"), include_str!("branch.toml"));

struct Mine;

impl Files for Mine {
    fn read(&self, path: &str) -> Result<String, String> {
        match path {
            "mine.toml" => Ok("[fixings.\"edge-clip\"]\npull_out_force = 7\n[fixings.other]\nslide = true".into()),
            "bad.toml" => Ok("[fixings.worse]\nkind = \"colar\"\npull_out = 7".into()),
            "parts.toml" => Ok(PARTS.into()),
            "doubled.toml" => Ok("[fixings.a]\nparts = [\"8K0 971 824\"]\n[fixings.b]\nparts = [\"8K0971824\"]".into()),
            _ => Err("no such file".into()),
        }
    }
}

/// A catalogue: a clip by its number, clips and a clamp by patterns.
const PARTS: &str = r#"
[fixings.clip-824]
parts = ["8K0 971 824"]
pull_out_force = "70 N"
[fixings.clips]
parts = ["8K0 971 *"]
slide = true
friction = 0.2
[fixings.clamp]
kind = "handle"
stiffness = 5
parts = ["1J0*", "N 908 1?0"]
[fixings.wide]
parts = ["N 908*"]
"#;

/// The constraint that has these keys in a scenario with that catalogue.
fn of_catalogue(keys: &str) -> Result<Constraint, String> {
    let text = format!("catalogue = \"parts.toml\"\n{HARNESS}[[constraints]]\nname = \"it\"\n{MIDDLE}{keys}");
    let scenario = parse_with_files(&text, &Mine, &common::registry());
    scenario.map(|mut scenario| scenario.constraints.remove(1)).map_err(|faults| render(&text, &faults))
}

/// The constraint that has these keys, in a scenario with these tables.
fn read(keys: &str, tables: &str) -> Constraint {
    let text = format!("{HARNESS}[[constraints]]\nname = \"it\"\n{keys}\n{tables}");
    let scenario = parse_with_files(&text, &Mine, &common::registry());
    scenario.unwrap_or_else(|faults| panic!("{}", render(&text, &faults))).constraints.remove(1)
}

fn refused(keys: &str, tables: &str) -> String {
    let text = format!("{HARNESS}[[constraints]]\nname = \"it\"\n{keys}\n{tables}");
    parse_with_files(&text, &Mine, &common::registry()).err().map(|faults| render(&text, &faults)).unwrap_or_default()
}

const MIDDLE: &str = "at = { branch = \"b\", s = 0.5 }\n";

/// Every type of the shipped file can be used and has a description.
#[test]
fn every_shipped_type_is_known() {
    let file: toml::Table = include_str!("../library/fixings.toml").parse().unwrap();
    let types = file["fixings"].as_table().unwrap();
    assert!(types.len() > 10);
    for (name, of) in types {
        assert!(of["doc"].as_str().is_some_and(|doc| doc.len() > 20), "{name}");
        let needs = of.get("needs").and_then(|needs| needs.as_array()).map(Vec::as_slice).unwrap_or_default();
        let given = needs.iter().map(|need| match need.as_str() {
            Some("rail") => "rail = [[1, 0, 0]]\n",
            Some("free_axis") => "free_axis = [0, 0, 1]\n",
            other => panic!("{name} needs {other:?}"),
        });
        let it = read(&format!("kind = \"{name}\"\n{MIDDLE}{}", given.collect::<String>()), "");
        assert_eq!(it.called, *name);
        assert_eq!(it.kind, of.get("kind").and_then(|kind| kind.as_str()).unwrap_or("collar"));
        assert_eq!(it.slide.is_some(), of.get("slide").is_some());
        assert_eq!(it.limits.pull_out_force.is_some(), of.get("pull_out_force").is_some());
    }
}

#[test]
fn a_type_gives_freedoms_limits_and_parameters() {
    let grommet = read(&format!("kind = \"grommet\"\n{MIDDLE}"), "");
    assert_eq!((grommet.kind.as_str(), grommet.called.as_str()), ("collar", "grommet"));
    assert_eq!((grommet.hold, grommet.slide), (Some(vec![HoldWord::Position]), Some(Slide { friction: 0.5 })));
    let limits = Limits { pull_out_force: Some(150.0), max_moment: None, insertion_force: Some(80.0) };
    assert_eq!(grommet.limits, limits);
    let clamp = read(&format!("kind = \"cushioned-clamp\"\n{MIDDLE}"), "");
    assert_eq!((clamp.kind.as_str(), clamp.hold), ("handle", None));
    assert_eq!(clamp.parameters.number("stiffness"), Some(2.4e5));
}

#[test]
fn what_a_constraint_says_goes_before_its_type() {
    let own = "friction = 0.1\nhold = [\"position\", \"tangent\"]\npull_out_force = \"1 N\"\n";
    let grommet = read(&format!("kind = \"grommet\"\n{MIDDLE}{own}"), "");
    assert_eq!(grommet.slide, Some(Slide { friction: 0.1 }));
    assert_eq!(grommet.hold, Some(vec![HoldWord::Position, HoldWord::Tangent]));
    assert_eq!((grommet.limits.pull_out_force, grommet.limits.insertion_force), (Some(1.0), Some(80.0)));
    assert_eq!(read(&format!("kind = \"grommet\"\nslide = false\n{MIDDLE}"), "").slide, None);
    let clamp = read(&format!("kind = \"cushioned-clamp\"\nstiffness = 5\n{MIDDLE}"), "");
    assert_eq!(
        (clamp.parameters.number("stiffness"), clamp.parameters.number("angular_stiffness")),
        (Some(5.0), Some(2.9))
    );
}

#[test]
fn a_scenario_and_its_files_have_types_of_their_own() {
    let library = "[library]\nfiles = [\"mine.toml\"]\n";
    let own = "[fixings.own]\ntwist = \"held\"\nmax_moment = \"2 N m\"\n";
    assert_eq!(read(&format!("kind = \"edge-clip\"\n{MIDDLE}"), library).limits.pull_out_force, Some(7.0));
    assert_eq!(read(&format!("kind = \"other\"\n{MIDDLE}"), library).slide, Some(Slide { friction: 0.0 }));
    let it = read(&format!("kind = \"own\"\n{MIDDLE}"), own);
    assert_eq!((it.parameters.0.get("twist"), it.limits.max_moment), (Some(&Value::Word("held".into())), Some(2.0)));
}

#[test]
fn types_may_be_grasped_and_clipped() {
    let steps = "[[steps]]\n[[steps.clip]]\nname = \"c\"\nkind = \"edge-clip\"\nat = { branch = \"b\" }\n\
                 position = [1, 0, 0]\n[[steps.grasp]]\nname = \"g\"\nkind = \"gripper\"\nat = { end = \"B\" }\n";
    let text = format!("{HARNESS}{steps}");
    let scenario = parse(&text, &common::registry()).unwrap_or_else(|faults| panic!("{}", render(&text, &faults)));
    let called: Vec<&str> = scenario.constraints.iter().map(|it| it.called.as_str()).collect();
    assert_eq!(called, ["connector", "gripper", "edge-clip"]);
}

#[test]
fn faults_of_files_and_of_use_are_said() {
    let bad = refused(&format!("kind = \"handle\"\n{MIDDLE}"), "[library]\nfiles = [\"bad.toml\"]\n");
    assert!(bad.contains("bad.toml:2:8: unknown constraint kind \"colar\" in fixing type \"worse\""), "{bad}");
    // A faulty type is not also reported as unknown.
    let bad = refused(&format!("kind = \"own\"\n{MIDDLE}"), "[fixings.own]\nmax_moment = 0\n");
    assert_eq!(bad.matches("help").count(), 1, "{bad}");
    let unknown = refused(&format!("kind = \"edge-clap\"\n{MIDDLE}"), "");
    assert!(unknown.contains("did you mean `edge-clip`?"), "{unknown}");
    assert!(parse_with_files(HARNESS, &NoFiles, &common::registry()).is_ok());
}

/// A part number chooses the type: the number itself before a pattern, spaces aside. Own keys and types go first.
#[test]
fn a_part_number_chooses_the_type_of_a_clip() {
    let of = |keys: &str| of_catalogue(keys).unwrap_or_else(|faults| panic!("{faults}"));
    let exact = of("kind = \"collar\"\npart = \"8K0971824\"");
    assert_eq!((exact.called.as_str(), exact.kind.as_str()), ("clip-824", "collar"));
    assert_eq!((exact.limits.pull_out_force, exact.slide), (Some(70.0), None));
    let other = of("kind = \"collar\"\npart = \"8K0 971 825 A\"");
    assert_eq!((other.called.as_str(), other.slide), ("clips", Some(Slide { friction: 0.2 })));
    // The generic clip gives way to another kind, a part that is not in the catalogue does not.
    let clamp = of("kind = \"collar\"\npart = \"1J0 957 818\"");
    assert_eq!((clamp.kind.as_str(), clamp.parameters.number("stiffness")), ("handle", Some(5.0)));
    assert_eq!(of("kind = \"collar\"\npart = \"2K0 1\"").called, "collar");
    assert_eq!(of("kind = \"swivel\"\npart = \"8K0 971 824\"").called, "swivel");
    let own = of("kind = \"collar\"\npart = \"8K0 971 824\"\npull_out_force = \"9 N\"");
    assert_eq!(own.limits.pull_out_force, Some(9.0));
}

#[test]
fn parts_that_no_entry_has_are_listed_and_doubled_ones_refused_with_both_places() {
    let text = format!(
        "catalogue = \"parts.toml\"\n{HARNESS}[[constraints]]\nname = \"it\"\nkind = \"collar\"\n{MIDDLE}\
         part = \"2K0 1\"\n"
    );
    let scenario = parse_with_files(&text, &Mine, &common::registry());
    let scenario = scenario.unwrap_or_else(|faults| panic!("{}", render(&text, &faults)));
    assert_eq!(scenario.unmatched, ["2K0 1"]);

    let doubled = parse_with_files(&text.replace("parts.toml", "doubled.toml"), &Mine, &common::registry());
    let Err(doubled) = doubled else { panic!("not refused") };
    let doubled = render("", &doubled);
    assert!(
        doubled.contains(
            "the part number \"8K0971824\" is given twice: doubled.toml:2:10 (\"a\") and doubled.toml:4:10 (\"b\")"
        ),
        "{doubled}"
    );
    let several = of_catalogue("kind = \"collar\"\npart = \"N 908 110\"").unwrap_err();
    assert!(
        several.contains("fits several types: parts.toml:12:18 (\"clamp\", \"N 908 1?0\"), parts.toml:14:10"),
        "{several}"
    );
    let kind = of_catalogue("kind = \"connector\"\npart = \"1J0 957 818\"").unwrap_err();
    assert!(kind.contains("that of the type \"clamp\", a handle, and kind = \"connector\""), "{kind}");
}
