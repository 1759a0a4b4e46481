//! The drawings of a board, read again: lengths in the DXF, pages of the PDF, lines of the SVG.
#![cfg(feature = "drawings")]

use lopdf::Document;
use wireloom_formboard::drawing::{Drawing, Paper, Table, branches, dxf, not_printable, parts, pdf, svg};
use wireloom_formboard::{
    Arm, Board, Branch, Clip, Error, Harness, Holds, Joint, Line, Options, Peg, Place, Point, Rotation, Vector, Vertex,
    lay,
};

/// A trunk of four pieces with two arms at each fork.
fn harness() -> Harness {
    let mut harness = Harness::default();
    let vertex = |name: String, part: Option<&str>| Vertex { name, part: part.map(str::to_owned) };
    harness.vertices.extend((0..5).map(|k| vertex(format!("J{k}"), None)));
    let mut arms: Vec<Vec<Arm>> = vec![Vec::new(); 5];
    let along = |x: f64, y: f64| Rotation::face_towards(&Vector::new(x, y, 0.0), &Vector::z());
    let branch = |name: String, ends: [usize; 2], length: f64, diameter: f64| Branch {
        name,
        ends,
        length,
        diameter,
        min_bend_radius: Some(6.0 * diameter),
        linear_density: 4e3 * diameter * diameter,
        clips: Vec::new(),
    };
    for k in 0..4 {
        arms[k].push(Arm { branch: harness.branches.len(), orientation: along(1.0, 0.0) });
        arms[k + 1].push(Arm { branch: harness.branches.len(), orientation: along(1.0, 0.0) });
        harness.branches.push(branch(format!("trunk-{k}"), [k, k + 1], 0.7311 + 0.01 * k as f64, 0.02));
    }
    for (k, own) in arms.iter_mut().enumerate().take(4).skip(1) {
        for (side, y) in [("links", 1.0), ("rechts", -1.0)] {
            let end = harness.vertices.len();
            harness.vertices.push(vertex(format!("{side} {k}"), Some("Stecker für Tür")));
            own.push(Arm { branch: harness.branches.len(), orientation: along(0.2, y) });
            harness.branches.push(branch(format!("{side}-{k}"), [k, end], 0.3 + 0.05 * k as f64, 0.006));
        }
    }
    harness.branches[0].clips.push(Clip { name: "clip".to_owned(), s: 0.2 });
    let joints = arms.into_iter().enumerate().filter(|(_, arms)| arms.len() > 1);
    harness.joints.extend(joints.map(|(vertex, arms)| Joint { vertex, arms }));
    harness.roots.push(0);
    harness
}

fn on(board: Option<[f64; 2]>) -> (Harness, Board) {
    let harness = harness();
    let board = lay(&harness, &Options { board, ..Options::default() }).expect("it fits");
    (harness, board)
}

fn tables(harness: &Harness, board: &Board) -> Vec<Table> {
    vec![parts(harness, board), branches(harness, board)]
}

#[test]
fn a_dxf_that_is_read_again_has_the_lengths_and_dimensions() {
    // The second board is shorter than the trunk, so that there are arcs.
    for (room, arcs) in [(None, false), (Some([2.2, 1.8]), true)] {
        let (harness, board) = on(room);
        let drawing = Drawing { title: "test", harness: &harness, board: &board, tables: &[] };
        let mut bytes = Vec::new();
        dxf(&drawing, &mut bytes).expect("written");
        let mut again = Vec::new();
        dxf(&drawing, &mut again).expect("written");
        assert!(bytes == again, "the same board, other bytes");
        let file = ::dxf::Drawing::load(&mut &bytes[..]).expect("DXF");
        let (mut lengths, mut dimensions, mut bent) = (Vec::new(), Vec::new(), 0);
        for entity in file.entities().filter(|entity| ["cables", "dimensions"].contains(&&*entity.common.layer)) {
            match &entity.specific {
                ::dxf::entities::EntityType::Line(line) => {
                    lengths.push((line.p1.x - line.p2.x).hypot(line.p1.y - line.p2.y));
                }
                ::dxf::entities::EntityType::Arc(arc) => {
                    bent += 1;
                    lengths.push(arc.radius * (arc.end_angle - arc.start_angle).rem_euclid(360.0).to_radians());
                }
                ::dxf::entities::EntityType::RotatedDimension(own) => {
                    dimensions.push(own.dimension_base.actual_measurement);
                }
                _ => {}
            }
        }
        let mut expected: Vec<f64> = harness.branches.iter().map(|branch| branch.length * 1e3).collect();
        expected.sort_by(f64::total_cmp);
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths.len(), expected.len());
        // A DXF number has twelve digits after the point; angles of arcs are in degrees.
        assert!(lengths.iter().zip(&expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{lengths:?} {expected:?}");
        assert_eq!((bent > 0, dimensions.len() + bent), (arcs, expected.len()));
        assert!(dimensions.iter().all(|own| expected.iter().any(|length| (own / length - 1.0).abs() < 1e-9)));
    }
}

#[test]
fn a_pdf_that_is_read_again_has_its_pages_at_their_size() {
    let (harness, board) = on(None);
    let tables = tables(&harness, &board);
    let drawing = Drawing { title: "Prüfling", harness: &harness, board: &board, tables: &tables };
    for (paper, [short, long]) in [(Paper::A0, [841.0, 1189.0]), (Paper::A3, [297.0, 420.0])] {
        let bytes = pdf(&drawing, paper);
        assert!(bytes == pdf(&drawing, paper), "the same board, other bytes");
        let file = Document::load_mem(&bytes).expect("PDF");
        let pages = file.get_pages();
        let sizes: Vec<[f64; 2]> = pages
            .values()
            .map(|&id| {
                let page = file.get_dictionary(id).expect("a page");
                let media = page.get(b"MediaBox").and_then(|media| media.as_array()).expect("a box");
                [2, 3].map(|k| f64::from(media[k].as_float().expect("a number")) * 25.4 / 72.0)
            })
            .collect();
        let is = |size: &[f64; 2], a: f64, b: f64| (size[0] - a).abs() < 0.1 && (size[1] - b).abs() < 0.1;
        // The overview, the pages of the board, and a page for each table.
        assert!(is(&sizes[0], 297.0, 210.0), "{sizes:?}");
        let at_scale = sizes[1..sizes.len() - 2].to_vec();
        assert!(at_scale.iter().all(|size| is(size, short, long) || is(size, long, short)), "{sizes:?}");
        // The trunk of 2.98 m takes three pages A0 of 1.17 m on their sides, or four upright.
        let least = (2.984 / (long * 1e-3 - 0.02)).ceil() as usize;
        assert!(at_scale.len() >= least && at_scale.len() <= 60, "{}", at_scale.len());
        let numbers: Vec<u32> = pages.keys().copied().collect();
        let text = file.extract_text(&numbers).expect("text");
        assert!(text.contains("Prüfling") && text.contains("Stecker für Tür") && text.contains("731.1"), "{text}");
    }
    assert!(not_printable(&drawing).is_empty());
    let chinese = Drawing { title: "x", tables: &[Table::new("线束 Ω", &["a"])], ..drawing };
    assert_eq!(not_printable(&chinese), ['Ω', '束', '线']);
}

/// All pages of the box around a long cable were printed, whether it crosses them or not.
#[test]
fn a_slanted_cable_is_on_the_pages_that_it_crosses_alone() {
    let (harness, mut board) = on(None);
    let trunk = board.lines[0];
    board.size = [10.0, 10.0];
    for line in &mut board.lines {
        *line = Line { start: Point::zeros(), direction: std::f64::consts::FRAC_PI_4, ..trunk };
    }
    board.lines[0].length = 14.0;
    (board.pegs, board.sheets) = (Vec::new(), None);
    let drawing = Drawing { title: "", harness: &harness, board: &board, tables: &[] };
    let pages = Document::load_mem(&pdf(&drawing, Paper::A4)).expect("PDF").get_pages().len();
    // 52 columns of 190 mm and 36 rows of 277 mm: as many borders are crossed, and beside each is another page.
    assert!((52..300).contains(&pages), "{pages}");
}

#[test]
fn an_svg_has_every_branch_at_its_place() {
    let (harness, board) = on(None);
    let drawing = Drawing { title: "a < b & c", harness: &harness, board: &board, tables: &[] };
    let mut bytes = Vec::new();
    svg(&drawing, &mut bytes).expect("written");
    let text = String::from_utf8(bytes).expect("UTF-8");
    assert!(text.contains("<title>a &lt; b &amp; c</title>"));
    let cables = text.split("<g id=\"cables\"").nth(1).and_then(|rest| rest.split("</g>").next()).expect("cables");
    for line in &board.lines {
        let height = board.size[1];
        let round = |x: f64| (x * 1e6).round() / 1e3;
        let start = format!("M{} {}", round(line.start.x), round(height - line.start.y));
        assert!(cables.contains(&start), "{start} in {cables}");
    }
}

#[test]
fn pegs_share_the_weight_so_that_none_bears_a_newton() {
    let (harness, board) = on(None);
    // Each peg has half of the cable up to its neighbours.
    let mut loads = vec![0.0; board.pegs.len()];
    for (k, branch) in harness.branches.iter().enumerate() {
        let mut held: Vec<(f64, usize)> = Vec::new();
        for (index, Peg { at, .. }) in board.pegs.iter().enumerate() {
            match at {
                Place::Vertex(vertex) if *vertex == branch.ends[0] => held.push((0.0, index)),
                Place::Vertex(vertex) if *vertex == branch.ends[1] => held.push((branch.length, index)),
                Place::Along { branch, s } if *branch == k => held.push((*s, index)),
                _ => {}
            }
        }
        held.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(held[0].0 == 0.0 && held[held.len() - 1].0 == branch.length, "both ends are held");
        for pair in held.windows(2) {
            let weight = branch.linear_density * 9.81 * (pair[1].0 - pair[0].0);
            assert!(pair[1].0 - pair[0].0 <= 0.4 + 1e-9);
            loads[pair[0].1] += 0.5 * weight;
            loads[pair[1].1] += 0.5 * weight;
        }
    }
    assert!(loads.iter().all(|load| *load < 0.75), "{loads:?}");
    assert!(board.pegs.iter().any(|peg| peg.holds == Holds::Clip));
}

#[test]
fn boards_and_distances_that_cannot_be_are_refused_with_what_would_be_right() {
    let harness = harness();
    let refused = |options: Options| lay(&harness, &options).expect_err("refused").to_string();
    let own = Options::default();
    let told = refused(Options { board: Some([0.4, 0.3]), ..own });
    assert!(told.contains("does not fit on a board of 400 mm x 300 mm") && told.contains("it needs 3"), "{told}");
    let told = refused(Options { board: Some([0.08, 0.08]), ..own });
    assert!(told.contains("does not fit"), "{told}");
    assert!(refused(Options { gap: f64::NAN, ..own }).contains("gap"));
    assert!(refused(Options { margin: -1.0, ..own }).contains("margin of the board must be 0 or more, not -1 m"));
    assert!(refused(Options { board: Some([1.0, f64::INFINITY]), ..own }).contains("height"));
    assert_eq!(lay(&Harness::default(), &own), Err(Error::Empty));
}

#[test]
fn frames_follow_their_lines_and_joints_are_at_rest() {
    let (harness, board) = on(Some([2.2, 1.8]));
    for (joint, arms) in harness.joints.iter().zip(&board.arms) {
        for (arm, frame) in joint.arms.iter().zip(arms) {
            let branch = &harness.branches[arm.branch];
            let s = if branch.ends[0] == joint.vertex { 0.0 } else { branch.length };
            assert!(board.frame(arm.branch, s).angle_to(frame) < 1e-9);
            let direction = board.lines[arm.branch].direction_at(s);
            let along = Vector::new(direction.cos(), direction.sin(), 0.0);
            assert!((frame * Vector::z() - along).norm() < 1e-9);
        }
    }
    for (k, line) in board.lines.iter().enumerate() {
        let curvature = board.curvature(k);
        assert!((curvature.norm() - line.curvature.abs()).abs() < 1e-12 && curvature.z.abs() < 1e-9);
    }
}
