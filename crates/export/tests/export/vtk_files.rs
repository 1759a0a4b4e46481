//! `.vtp` and `.pvd`, read back strictly.

use crate::samples::{broken, run, step, y_harness};
use std::collections::BTreeMap;
use wireloom_core::Vector;
use wireloom_core::equilibrium::{ArmFriction, FrictionResult, Violation};
use wireloom_core::identity::{Identified, Identities, Identity, Part};
use wireloom_core::requirement::{Bound, Measure, Severity};
use wireloom_core::{EventPlace, StepResult};
use wireloom_export::vtk::{SeriesFile, times, write, write_series, write_surfaces};

/// A PolyData file taken apart; every promise of the header is checked on the way.
struct PolyData {
    points: Vec<f64>,
    lines: Vec<Vec<i64>>,
    branch: Vec<i64>,
    names: Vec<String>,
    parts: Option<Vec<String>>,
    /// Name → components, values.
    arrays: BTreeMap<String, (usize, Vec<f64>)>,
}

fn read(step: &StepResult) -> PolyData {
    read_with(step, &Identities::default())
}

fn read_with(step: &StepResult, identities: &Identities) -> PolyData {
    let mut bytes = Vec::new();
    write(step, identities, &mut bytes).unwrap();
    let start = find(&bytes, b"encoding=\"raw\">\n_") + b"encoding=\"raw\">\n_".len();
    let end = bytes.len() - b"\n</AppendedData>\n</VTKFile>\n".len();
    assert_eq!(&bytes[end..], b"\n</AppendedData>\n</VTKFile>\n");
    let head = format!("{}</AppendedData></VTKFile>", std::str::from_utf8(&bytes[..start]).unwrap());
    let document = roxmltree::Document::parse(&head).unwrap();
    let file = document.root_element();
    for (key, value) in [("type", "PolyData"), ("byte_order", "LittleEndian"), ("header_type", "UInt64")] {
        assert_eq!(file.attribute(key), Some(value));
    }
    let piece = document.descendants().find(|node| node.has_tag_name("Piece")).unwrap();
    let count = |key: &str| piece.attribute(key).unwrap().parse::<usize>().unwrap();
    let (n, lines) = (count("NumberOfPoints"), count("NumberOfLines"));
    assert_eq!(count("NumberOfVerts") + count("NumberOfStrips") + count("NumberOfPolys"), 0);

    let data = &bytes[start..end];
    let mut expected_offset = 0;
    let mut array = |node: roxmltree::Node<'_, '_>| {
        assert_eq!(node.attribute("format"), Some("appended"));
        let offset: usize = node.attribute("offset").unwrap().parse().unwrap();
        assert_eq!(offset, expected_offset, "arrays follow one another without gaps");
        let size = u64::from_le_bytes(data[offset..offset + 8].try_into().unwrap()) as usize;
        expected_offset = offset + 8 + size;
        assert!(expected_offset <= data.len() && size.is_multiple_of(8));
        let words = data[offset + 8..expected_offset].chunks_exact(8).map(|w| w.try_into().unwrap());
        words.collect::<Vec<[u8; 8]>>()
    };
    let floats = |words: Vec<[u8; 8]>| words.into_iter().map(f64::from_le_bytes).collect::<Vec<_>>();
    let integers = |words: Vec<[u8; 8]>| words.into_iter().map(i64::from_le_bytes).collect::<Vec<_>>();
    let section = |name: &str| {
        let parent = piece.children().find(|node| node.has_tag_name(name)).unwrap();
        parent.children().filter(|node| node.is_element()).collect::<Vec<_>>()
    };

    let mut arrays = BTreeMap::new();
    for node in section("PointData") {
        assert_eq!(node.attribute("type"), Some("Float64"));
        let components: usize = node.attribute("NumberOfComponents").unwrap().parse().unwrap();
        let values = floats(array(node));
        assert_eq!(values.len(), components * n);
        arrays.insert(node.attribute("Name").unwrap().to_string(), (components, values));
    }
    let cell_data = section("CellData");
    let of: Vec<_> = cell_data.iter().map(|node| node.attribute("Name").unwrap()).collect();
    assert!(of == ["branch", "name"] || of == ["branch", "name", "part"], "{of:?}");
    let branch = integers(array(cell_data[0]));
    let (names, parts) = (strings(cell_data[1]), cell_data.get(2).map(|node| strings(*node)));
    assert!(branch.len() == lines && names.len() == lines && parts.as_ref().is_none_or(|all| all.len() == lines));
    let points = floats(array(section("Points")[0]));
    assert_eq!(points.len(), 3 * n);
    let [connectivity, offsets] = section("Lines")[..] else { panic!("two arrays of lines") };
    assert_eq!(connectivity.attribute("Name"), Some("connectivity"));
    assert_eq!(offsets.attribute("Name"), Some("offsets"));
    let (connectivity, offsets) = (integers(array(connectivity)), integers(array(offsets)));
    assert_eq!(expected_offset, data.len(), "nothing is left over");
    assert_eq!(offsets.len(), lines);
    assert_eq!(offsets.last().map_or(0, |last| *last as usize), connectivity.len());
    assert!(connectivity.iter().all(|i| (0..n as i64).contains(i)));
    let mut first = 0;
    let lines = offsets
        .into_iter()
        .map(|end| connectivity[std::mem::replace(&mut first, end as usize)..end as usize].to_vec())
        .collect();
    PolyData { points, lines, branch, names, parts, arrays }
}

/// An array of strings, each as the codes of its bytes with a zero behind.
fn strings(array: roxmltree::Node<'_, '_>) -> Vec<String> {
    assert_eq!((array.attribute("type"), array.attribute("format")), (Some("String"), Some("ascii")));
    let codes = array.text().unwrap().split_whitespace().map(|code| code.parse::<u8>().unwrap());
    let text = String::from_utf8(codes.collect()).unwrap();
    let all: Vec<String> = text.split_terminator('\0').map(str::to_owned).collect();
    assert_eq!(array.attribute("NumberOfTuples"), Some(all.len().to_string().as_str()));
    all
}

fn find(bytes: &[u8], pattern: &[u8]) -> usize {
    bytes.windows(pattern.len()).position(|window| window == pattern).unwrap()
}

#[test]
fn sets_are_there_where_a_branch_has_friction() {
    let name = "set d1 d2 d3 [1/m]";
    let mut step = y_harness();
    assert!(!read(&step).arrays.contains_key(name));
    let set: Vec<Vector> = step.branches[1].s.iter().map(|s| Vector::new(s / 3.0, -s, 0.1)).collect();
    step.branches[1].friction = Some(FrictionResult { set: set.clone(), dissipated: 0.1, dissipated_in_all: 0.3 });
    let (components, values) = read(&step).arrays.remove(name).expect("an array");
    let before = 3 * step.branches[0].s.len();
    let own: Vec<f64> = set.iter().flat_map(|set| set.iter().copied()).collect();
    assert_eq!((components, &values[before..][..own.len()]), (3, &own[..]));
    assert!(values[..before].iter().chain(&values[before + own.len()..]).all(|x| *x == 0.0));
}

#[test]
fn sets_of_arms_are_at_the_ends_of_their_branches() {
    let name = "set at joint d1 d2 d3 [rad]";
    let mut step = y_harness();
    assert!(!read(&step).arrays.contains_key(name));
    let arm = |branch: usize, starts_here: bool, x: f64| ArmFriction {
        branch: step.branches[branch].name.clone(),
        starts_here,
        set: Vector::new(x, 2.0 * x, 3.0 * x),
        dissipated: 0.1,
        dissipated_in_all: 0.3,
    };
    let friction = vec![arm(0, false, 0.125), arm(1, true, 0.25)];
    step.joints[0].friction = friction;
    let (components, values) = read(&step).arrays.remove(name).expect("an array");
    let nodes = step.branches[0].s.len();
    assert_eq!((components, &values[3 * nodes - 3..3 * nodes + 3]), (3, &[0.125, 0.25, 0.375, 0.25, 0.5, 0.75][..]));
    let others = values[..3 * nodes - 3].iter().chain(&values[3 * nodes + 3..]);
    assert!(others.copied().all(|x| x == 0.0), "{values:?}");
}

#[test]
fn one_polyline_a_branch() {
    let step = y_harness();
    // Left to be opened in ParaView.
    let mut bytes = Vec::new();
    write(&step, &Identities::default(), &mut bytes).unwrap();
    std::fs::write(concat!(env!("CARGO_TARGET_TMPDIR"), "/y.vtp"), bytes).unwrap();
    let file = read(&step);
    assert_eq!(file.branch, [0, 1, 2, 3]);
    assert_eq!(file.arrays["tension [N]"].0, 1);
    assert_eq!(file.arrays["force [N]"].0, 3);
    for (branch, line) in step.branches.iter().zip(&file.lines) {
        assert_eq!(line.len(), branch.s.len());
        for (i, point) in line.iter().map(|p| *p as usize).enumerate() {
            let vector = |array: &[f64]| array[3 * point..3 * point + 3].to_vec();
            assert_eq!(vector(&file.points), branch.position[i].as_slice());
            assert_eq!(vector(&file.arrays["force [N]"].1), branch.force[i].as_slice());
            assert_eq!(vector(&file.arrays["moment [N m]"].1), branch.moment[i].as_slice());
            assert_eq!(file.arrays["arc length [m]"].1[point], branch.s[i]);
            assert_eq!(file.arrays["tube radius [m]"].1[point], 0.5 * branch.diameter);
            assert_eq!(file.arrays["curvature [1/m]"].1[point], 1.0 / branch.bend_radius[i]);
            let ratio = file.arrays["bend limit/radius"].1[point];
            assert_eq!(ratio.is_nan(), branch.bend_radius_limit.is_none());
        }
    }
}

#[test]
fn cells_have_the_names_and_part_numbers_of_their_branches() {
    let step = y_harness();
    let names: Vec<String> = step.branches.iter().map(|branch| branch.name.clone()).collect();
    let file = read(&step);
    assert_eq!((file.names, file.parts), (names.clone(), None));
    let part = |of: Identified, name: &str, number: &str| Part {
        of,
        name: name.to_owned(),
        identity: Identity { part: Some(number.to_owned()), ..Identity::default() },
    };
    // A joint of the same name is another part.
    let parts =
        vec![part(Identified::Joint, &names[0], "J 1"), part(Identified::Branch, &names[1], "8K0 971 824 \u{e4}<1>")];
    let file = read_with(&step, &Identities { parts, ..Identities::default() });
    assert_eq!(
        (file.names, file.parts),
        (names, Some(["", "8K0 971 824 \u{e4}<1>", "", ""].map(str::to_owned).into()))
    );
}

#[test]
fn branches_without_a_line_are_left_out() {
    let mut short = y_harness();
    for keep in [0, 1] {
        let branch = &mut short.branches[keep];
        branch.s.truncate(keep);
        branch.position.truncate(keep);
        branch.frame.truncate(keep);
        branch.force.truncate(keep);
        branch.moment.truncate(keep);
        branch.bend_radius.truncate(keep);
    }
    let file = read(&short);
    assert_eq!(
        (file.branch, file.names),
        (vec![2, 3], vec![short.branches[2].name.clone(), short.branches[3].name.clone()])
    );
    assert!(read(&step(vec![], vec![], vec![])).lines.is_empty());
    read(&broken());
    short.branches[2].moment.pop();
    let written = write(&short, &Identities::default(), &mut Vec::new());
    assert_eq!(written.unwrap_err().kind(), std::io::ErrorKind::InvalidInput);
}

#[test]
fn a_series_counts_steps() {
    let mut steps = Vec::new();
    for (name, increment, increments) in
        [("plug B", 1, 2), ("plug B", 2, 2), ("tool on", 1, 4), ("tool on", 4, 4), ("tool on", 4, 4), ("x", 0, 0)]
    {
        steps.push(StepResult { name: name.into(), increment, increments, ..step(vec![], vec![], vec![]) });
    }
    let times = times(&run("s", steps));
    assert_eq!(times, [0.5, 1.0, 1.25, 2.0, 3.0, 4.0]);

    let files: Vec<SeriesFile> =
        times.iter().map(|time| SeriesFile { file: format!("a&b-{time}.vtp"), time: *time }).collect();
    let mut bytes = Vec::new();
    write_series(&files, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    assert_eq!(document.root_element().attribute("type"), Some("Collection"));
    let read: Vec<SeriesFile> = document
        .descendants()
        .filter(|node| node.has_tag_name("DataSet"))
        .map(|node| SeriesFile {
            file: node.attribute("file").unwrap().into(),
            time: node.attribute("timestep").unwrap().parse().unwrap(),
        })
        .collect();
    assert_eq!(read, files);
}

#[test]
fn surfaces_are_polygons_by_obstacle() {
    let surface = crate::samples::cube(1).shape.surface(1.0);
    let mut bytes = Vec::new();
    write_surfaces(&[(3, surface.clone()), (5, surface)], &mut bytes).unwrap();
    let start = find(&bytes, b"encoding=\"raw\">\n_") + b"encoding=\"raw\">\n_".len();
    let head = std::str::from_utf8(&bytes[..start]).unwrap();
    assert!(head.contains("NumberOfPoints=\"48\"") && head.contains("NumberOfPolys=\"24\""), "{head}");
    let word = |k: usize| i64::from_le_bytes(bytes[start + 8 * k..start + 8 * (k + 1)].try_into().unwrap());
    // The cell array: its length in bytes, then 12 times each index.
    assert_eq!((word(0), word(1), word(12), word(13), word(24)), (8 * 24, 3, 3, 5, 5));
    // Points, connectivity and offsets follow.
    let connectivity = 25 + 1 + 3 * 48;
    assert_eq!((word(25), word(connectivity), word(connectivity + 1 + 72)), (8 * 144, 8 * 72, 8 * 24));
    assert!((0..72).all(|k| (0..48).contains(&word(connectivity + 1 + k))));
    assert!(bytes.ends_with(b"\n</AppendedData>\n</VTKFile>\n"));
}

#[test]
fn files_of_one_time_are_parts() {
    let file = |file: &str, time| SeriesFile { file: file.into(), time };
    let mut bytes = Vec::new();
    write_series(&[file("a", 0.5), file("b", 0.5), file("c", 1.0)], &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let parts: Vec<&str> = text.split("part=\"").skip(1).map(|rest| &rest[..1]).collect();
    assert_eq!(parts, ["0", "1", "0"]);
}

#[test]
fn the_field_data_says_what_an_increment_does_not_keep() {
    let mut step = y_harness();
    step.violations = vec![Violation {
        name: "bend of left, für \u{201e}<A>\u{201c}".into(),
        measure: Measure::BendRadius,
        severity: Severity::Must,
        value: 0.0331,
        limit: 0.045,
        bound: Bound::Min,
        place: EventPlace::branch("left", 0.38),
    }];
    let mut bytes = Vec::new();
    write(&step, &Identities::default(), &mut bytes).unwrap();
    let end = find(&bytes, b"<Piece ");
    let head = format!("{}</PolyData></VTKFile>", std::str::from_utf8(&bytes[..end]).unwrap());
    let document = roxmltree::Document::parse(&head).unwrap();
    let field = |name: &str| strings(document.descendants().find(|node| node.attribute("Name") == Some(name)).unwrap());
    assert_eq!(field("status"), ["converged"]);
    let place = EventPlace::branch("left", 0.38).to_string();
    let sentence = "bend of left, für \u{201e}<A>\u{201c} (must): bend_radius 33.1 mm, min 45.0 mm, ";
    assert_eq!(field("violations"), [format!("{sentence}{place}")]);
    step.violations.clear();
    assert_eq!(read(&step).branch.len(), step.branches.len());
}
