//! Computed harnesses written back into a small KBL file of our own. The computed lines are made up here; those of real
//! runs are in `tests/tests/kbl.rs`.

#[path = "common/drawn.rs"]
mod drawn;

use drawn::{Drawn, Vector, rest, valid};
use nalgebra::UnitQuaternion;
use wireloom_import::kbl::export::{Computed, ExportError, Exported, Held, export};
use wireloom_import::kbl::{Options, import};

const SMALL: &str = include_str!("small.kbl");
const TOLERANCE: f64 = 1e-4;

/// The small file with a curve of `right` that fits; in the file it is that of another segment.
fn file() -> String {
    let stale = "<Center_curve id=\"k3\"><Degree>2</Degree><Control_points>pA pA1 pB</Control_points></Center_curve>";
    assert!(SMALL.contains(stale));
    SMALL.replacen(
        stale,
        "<Center_curve id=\"k3\"><Degree>1</Degree><Control_points>pJ pC</Control_points></Center_curve>",
        1,
    )
}

/// A branch along a smooth line.
fn along(name: &str, segment: &str, length: f64, curve: impl Fn(f64) -> Vector) -> Drawn {
    Drawn::new(name, segment, length, (0..=2000).map(|k| curve(f64::from(k) / 2000.0)).collect())
}

fn straight(name: &str, segment: &str, length: f64, from: Vector, to: Vector) -> Drawn {
    along(name, segment, length, move |f| from.lerp(&to, f))
}

fn mm(x: f64, y: f64, z: f64) -> Vector {
    Vector::new(x, y, z) * 1e-3
}

/// The parabola of the trunk, from the file's control points, moved at its end.
fn trunk(end: Vector) -> Drawn {
    let [a, b] = [mm(0.0, 0.0, 0.0), mm(150.0, 60.0, 0.0)];
    along("trunk", "s1", 0.3079, move |f| a * ((1.0 - f) * (1.0 - f)) + b * (2.0 * f * (1.0 - f)) + end * (f * f))
}

/// The harness as drawn but for its joint, which is at `joint`.
fn harness(joint: Vector) -> Vec<Drawn> {
    vec![
        trunk(joint),
        straight("left", "s2", 0.26, mm(500.0, 100.0, 0.0), joint),
        straight("right", "s3", 0.25, joint, mm(500.0, -100.0, 0.0)),
        straight("stub", "s4", 0.03, joint, joint + mm(0.0, 0.0, 30.0)),
    ]
}

fn joint() -> Vector {
    mm(300.0, 0.0, 0.0)
}

/// The clip where it is seated: on the point of the trunk nearest to its drawn place, in the middle.
fn clip(trunk: &Drawn) -> Held {
    let tangent = (trunk.at(0.501) - trunk.at(0.499)).normalize();
    Held { name: "clip-1".into(), assignment: "f1".into(), position: trunk.at(0.5), tangent, slides: None }
}

fn written(text: &str, drawn: &[Drawn], fixings: Vec<Held>) -> Result<Exported, ExportError> {
    export(text, &Computed { branches: drawn.iter().map(Drawn::branch).collect(), fixings }, TOLERANCE)
}

/// The numbers of an element in the order of the file.
fn numbers(text: &str, id: &str, name: &str) -> Vec<f64> {
    let xml = roxmltree::Document::parse(text).unwrap();
    let element = xml.descendants().find(|node| node.attribute("id") == Some(id)).unwrap();
    let of_name = element.descendants().filter(|node| node.has_tag_name(name));
    of_name.map(|node| node.text().unwrap().trim().parse().unwrap()).collect()
}

#[test]
fn what_lies_as_drawn_keeps_every_byte() {
    // Also with Windows line ends and a byte-order mark.
    for text in [file(), format!("\u{feff}{}", file().replace('\n', "\r\n"))] {
        let drawn = harness(joint());
        let found = written(&text, &drawn, vec![clip(&drawn[0])]).unwrap();
        assert_eq!(found.segments.iter().map(|own| own.curve).collect::<Vec<_>>(), [None; 4]);
        assert!(found.text == text, "{:?}", found.placements);
        assert!(found.nodes.is_empty() && found.placements.is_empty() && found.fixings.is_empty(), "{found:?}");
        assert!(found.notes.is_empty(), "{:?}", found.notes);
    }
}

#[test]
fn a_moved_joint_moves_its_node_and_the_curves_that_end_there_and_nothing_else() {
    let (text, moved) = (file(), mm(310.0, -20.0, 5.0));
    let drawn = harness(moved);
    let found = written(&text, &drawn, vec![clip(&drawn[0])]).unwrap();
    valid(&found.text, &text);
    assert!(found.segments.iter().all(|own| own.curve.is_some_and(|curve| curve.distance <= TOLERANCE)));
    assert_eq!(found.nodes.iter().map(|own| own.id.as_str()).collect::<Vec<_>>(), ["n2", "n5"]);
    // pJ was a control point of curves that are replaced, and is that of the node alone now: it moves itself.
    assert_eq!(numbers(&found.text, "pJ", "Coordinates"), [310.0, -20.0, 5.0]);
    assert_eq!(numbers(&found.text, "pA", "Coordinates"), [0.0; 3]);
    assert_eq!(numbers(&found.text, "pS", "Coordinates"), [310.0, -20.0, 35.0]);
    // A segment without a curve has one now, behind its end node; all have the ids of their old curves.
    let new = "    <End_node>n2</End_node>\n    <Center_curve id=\"s2_Center_curve\">\n      <Degree>3</Degree>\n";
    assert!(found.text.contains(new));
    let new = "<Center_curve id=\"k1\">\n      <Degree>3</Degree>\n      <Control_points>pA1 k1_point";
    assert!(found.text.contains(new));
    // The lengths of the cable are as before.
    for (id, before) in [("l1", 307.9), ("l2p", 0.26), ("l3", 250.0), ("l4", 30.0)] {
        assert_eq!(numbers(&found.text, id, "Value_component"), [before]);
    }
    // The virtual length beside a physical one is that of the new curve.
    let chord = (moved - mm(500.0, 100.0, 0.0)).norm() * 1e3;
    assert!((numbers(&found.text, "l2", "Value_component")[0] - chord).abs() < 1e-5);
    // The clip went with the trunk.
    let [x, y, z] = numbers(&found.text, "pClip", "Coordinates")[..] else { panic!("three coordinates") };
    assert!((mm(x, y, z) - drawn[0].at(0.5)).norm() < 0.0085 && z > 8.0, "{x} {y} {z}");
    // What is not named is as it was, byte by byte.
    assert_eq!(rest(&found.text), rest(&text));
}

#[test]
fn a_second_import_gives_the_lengths_and_the_lines_within_the_tolerance() {
    let drawn = harness(mm(310.0, -20.0, 5.0));
    let found = written(&file(), &drawn, vec![clip(&drawn[0])]).unwrap();
    let again = import(&found.text, &Options { max_segment: 0.002, ..Options::default() }).unwrap();
    let table: toml::Table = toml::from_str(&again.scenario).unwrap();
    let point = |value: &toml::Value| Vector::from([0, 1, 2].map(|k| value[k].as_float().unwrap()));
    for (own, branch) in drawn.iter().zip(table["branches"].as_array().unwrap()) {
        assert_eq!(branch["length"].as_float(), own.s.last().copied(), "{}", own.name);
        let path: Vec<Vector> = branch["path"].as_array().unwrap().iter().map(point).collect();
        for (k, x) in path.iter().enumerate() {
            let distance = own.distance(x);
            assert!(distance < TOLERANCE + 1e-6, "{} {k}: {distance}", own.name);
        }
    }
    let clip = &table["constraints"].as_array().unwrap()[2];
    assert_eq!(clip["name"].as_str(), Some("clip-1"));
    assert!((point(&clip["position"]) - drawn[0].at(0.5)).norm() < 2.0 * TOLERANCE, "{clip:?}");
}

#[test]
fn changed_lengths_are_written_in_the_unit_of_the_file_and_listed() {
    let mut drawn = harness(joint());
    for (own, length) in drawn.iter_mut().zip([0.3079, 0.2712, 0.25, 0.031]) {
        let before = own.s[own.s.len() - 1];
        own.s.iter_mut().for_each(|s| *s *= length / before);
    }
    let found = written(&file(), &drawn, vec![clip(&drawn[0])]).unwrap();
    let changed = found.segments.iter().filter(|own| own.has_new_length());
    let changed: Vec<_> = changed.map(|own| (own.id.as_str(), own.before, (own.length * 1e9).round() / 1e9)).collect();
    assert_eq!(changed, [("s2", 0.26, 0.2712), ("s4", 0.03, 0.031)]);
    assert_eq!(numbers(&found.text, "l2p", "Value_component"), [0.2712]);
    assert_eq!(numbers(&found.text, "l2", "Value_component"), [250.0], "the drawn line is as it was");
    assert!(found.text.contains("<Value_component>31</Value_component>"));
}

#[test]
fn a_segment_without_a_length_gets_one_with_its_new_curve() {
    let length = "    <Virtual_length id=\"l4\"><Unit_component>uMM</Unit_component>\
                  <Value_component>30</Value_component>\
                  </Virtual_length>\n";
    let text = file();
    assert!(text.contains(length));
    let text = text.replacen(length, "", 1);
    let drawn = harness(mm(310.0, -20.0, 5.0));
    let found = written(&text, &drawn, vec![clip(&drawn[0])]).unwrap();
    valid(&found.text, &text);
    assert_eq!(numbers(&found.text, "s4_Virtual_length", "Value_component").len(), 1);
    let again = import(&found.text, &Options::default()).unwrap().scenario;
    assert!(again.contains("length = 0.03\nkbl = \"s4\""), "{again}");
}

#[test]
fn a_fixing_that_sits_elsewhere_has_a_new_place() {
    let drawn = harness(joint());
    let absolute = "<Location>0.5</Location><Absolute_location id=\"al\"><Unit_component>uMM</Unit_component>\
                    <Value_component>153.95</Value_component></Absolute_location>";
    let text = file().replacen("<Location>0.5</Location>", absolute, 1);
    let held = Held { position: drawn[0].at(0.75), tangent: Vector::x(), ..clip(&drawn[0]) };
    let found = written(&text, &drawn, vec![held]).unwrap();
    assert_eq!(numbers(&found.text, "f1", "Location"), [0.75]);
    assert!((numbers(&found.text, "al", "Value_component")[0] - 0.75 * 307.9).abs() < 1e-6);
    assert_eq!(found.fixings.len(), 1);
    assert!((found.fixings[0].fractions[0] - 0.5).abs() < 1e-3, "{:?}", found.fixings);
    // Beside the segment it is told, and left.
    let held = Held { position: mm(0.0, 0.0, 300.0), ..clip(&drawn[0]) };
    let found = written(&text, &drawn, vec![held]).unwrap();
    assert!(found.text == text && found.notes[0].items[0].starts_with("f1 (`clip-1`"), "{:?}", found.notes);
}

#[test]
fn a_point_that_two_elements_share_moves_with_the_one_that_moves() {
    // The plug is placed at the point of its node: both move. The fixing is placed at that of another node: only this
    // one moves.
    let text = file()
        .replacen(
            "<Id>plug B</Id>",
            "<Id>plug B</Id><Placement id=\"pB1\"><U>1</U><U>0</U><U>0</U><V>0</V><V>1</V><V>0</V>\
                  <Cartesian_point>pB</Cartesian_point></Placement>",
            1,
        )
        .replacen("<Cartesian_point>pClip<", "<Cartesian_point>pC<", 1);
    let [b, c] = [mm(500.0, 130.0, 0.0), mm(500.0, -140.0, 0.0)];
    let mut drawn = harness(joint());
    drawn[1] = straight("left", "s2", 0.26, b, joint());
    drawn[2] = straight("right", "s3", 0.25, joint(), c);
    let found = written(&text, &drawn, vec![]).unwrap();
    valid(&found.text, &text);
    assert_eq!(numbers(&found.text, "pB", "Coordinates"), [500.0, 130.0, 0.0]);
    assert_eq!(numbers(&found.text, "pC", "Coordinates"), [500.0, -100.0, 0.0]);
    assert_eq!(numbers(&found.text, "pC_moved", "Coordinates"), [500.0, -140.0, 0.0]);
    assert!(found.text.contains("<Node id=\"n4\"><Id>C</Id><Cartesian_point>pC_moved</Cartesian_point>"));
    // The plug turned with the end of its cable.
    let turn = UnitQuaternion::rotation_between(&(joint() - mm(500.0, 100.0, 0.0)), &(joint() - b)).unwrap();
    let [x, y, z] = numbers(&found.text, "pB1", "U")[..] else { panic!("three numbers") };
    assert!((Vector::new(x, y, z) - turn * Vector::x()).norm() < 1e-8, "{x} {y} {z}");
    let told = found.notes.iter().map(|note| note.to_string()).collect::<Vec<_>>();
    assert_eq!(told, ["fixings that no constraint of the result holds; left as they are: f1"]);
}

#[test]
fn the_halves_of_a_split_branch_are_one_segment_again() {
    let whole = harness(joint());
    let middle = whole[1].at(0.12 / 0.26);
    let mut drawn = harness(joint());
    // In any order.
    drawn[1] = straight("left-2", "s2", 0.14, middle, joint());
    drawn.push(straight("left", "s2", 0.12, mm(500.0, 100.0, 0.0), middle));
    let found = written(&file(), &drawn, vec![clip(&drawn[0])]).unwrap();
    assert!(found.text == file());
    assert_eq!(found.segments[1].branches, ["left", "left-2"]);
    let gap = mm(0.0, 1.0, 0.0);
    drawn[4] = straight("left", "s2", 0.12, mm(500.0, 100.0, 0.0), middle + gap);
    let refused = written(&file(), &drawn, vec![]).unwrap_err().to_string();
    assert!(refused.contains("`left-2`, `left`") || refused.contains("`left`, `left-2`"), "{refused}");
    assert!(refused.contains("segment `s2`"), "{refused}");
}

#[test]
fn what_has_no_partner_is_listed_and_what_the_file_cannot_say_is_refused() {
    let mut drawn = harness(joint());
    drawn[3].segment = None;
    let found = written(&file(), &drawn, vec![clip(&drawn[0])]).unwrap();
    let told: Vec<String> = found.notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        told,
        [
            "branches that come from no segment of the file; not written: stub",
            "segments without a branch in the result; left as they are: s4",
        ]
    );
    drawn[3].segment = Some("s9".to_owned());
    let refused = written(&file(), &drawn, vec![]).unwrap_err().to_string();
    assert!(refused.contains("no segments `s9` (of branch `stub`)"), "{refused}");
    drawn.iter_mut().for_each(|own| own.segment = None);
    assert_eq!(written(&file(), &drawn, vec![]).unwrap_err(), ExportError::NoPartner);
    // Two arms that end 5 mm apart at one node.
    let mut drawn = harness(joint());
    drawn[3] = straight("stub", "s4", 0.03, mm(300.0, 0.0, 5.0), mm(300.0, 0.0, 30.0));
    let refused = written(&file(), &drawn, vec![]).unwrap_err().to_string();
    assert!(refused.contains("`trunk` and `stub` end at node `n2` of the file but 5.000 mm apart"), "{refused}");
    // A shape that is not there.
    let mut drawn = harness(joint());
    drawn[0].points[0].x = f64::NAN;
    let refused = written(&file(), &drawn, vec![]).unwrap_err();
    assert_eq!(refused, ExportError::NotFinite("trunk".into()));
    // A tolerance that no curve keeps: the numbers of the file end at 1e-9 m.
    let drawn = harness(mm(310.0, -20.0, 5.0));
    let computed = Computed { branches: drawn.iter().map(Drawn::branch).collect(), fixings: vec![] };
    let refused = export(&file(), &computed, 1e-12).unwrap_err().to_string();
    assert!(refused.contains("segment `s1` cannot be fitted to"), "{refused}");
}

#[test]
fn no_damaged_file_panics() {
    let drawn = harness(mm(310.0, -20.0, 5.0));
    let text = file();
    let places: Vec<usize> = text.match_indices(['<', '>', '"']).map(|(at, _)| at).step_by(7).collect();
    for at in places {
        let damaged = format!("{}{}", &text[..at], &text[at + 1..]);
        drop(written(&damaged, &drawn, vec![clip(&drawn[0])]));
    }
}
