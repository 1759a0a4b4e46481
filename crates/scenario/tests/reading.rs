//! The scenario and the network of a valid file.

mod common;

use wireloom_core::constraint::Limits;
use wireloom_core::load::{Axes, LoadAction};
use wireloom_core::network::{BranchEnd, Place};
use wireloom_core::steps::Turn;
use wireloom_core::{Rotation, Vector};
use wireloom_scenario::{At, Built, Division, Facing, Scenario, parse, render};

const HARNESS: &str = include_str!("harness.toml");

fn read(text: &str) -> Scenario {
    parse(text, &common::registry()).unwrap_or_else(|faults| panic!("{}", render(text, &faults)))
}

fn built(text: &str) -> Built {
    let registry = common::registry();
    let scenario = read(text);
    scenario.build(&registry).unwrap_or_else(|faults| panic!("{}", render(text, &faults)))
}

#[test]
fn values_arrive_in_si() {
    let scenario = read(HARNESS);
    assert_eq!(scenario.name, "y-harness");
    assert_eq!(scenario.gravity, Vector::new(0.0, 0.0, -9.81));
    // Sections come in the order of the file.
    let [trunk, arm] = scenario.sections.as_slice() else { panic!() };
    assert_eq!((trunk.name.as_str(), trunk.diameter, trunk.linear_density), ("trunk", 0.008, 0.12));
    assert_eq!(trunk.bending_stiffness, [0.012, 0.013]);
    assert_eq!((trunk.shear_stiffness, trunk.min_bend_radius), ([8000.0; 2], Some(0.048)));
    assert_eq!((arm.shear_stiffness, arm.min_bend_radius), ([10000.0 / 2.6; 2], None));
    assert_eq!(scenario.branches[0].length, 0.6);
    assert_eq!(scenario.branches[0].curvature, Vector::new(0.0, 0.5, 0.0));
    assert_eq!(scenario.branches[2].division, Division::MaxSegment(0.03));
    assert_eq!(scenario.branches[2].path.len(), 3);
    let LoadAction::At { load, .. } = &scenario.loads[1].action else { panic!() };
    let exerted = load.on(&Rotation::from_axis_angle(&Vector::z_axis(), 1.0));
    assert_eq!((load.axes(), exerted[1]), (Axes::World, Vector::new(0.005, 0.0, 0.0)));
    assert_eq!(scenario.minimiser.stop.force_tolerance, 1e-8);
    assert_eq!(scenario.minimiser.stop.max_iterations, 100);
    let output = scenario.output;
    assert_eq!((output.increments, output.csv, output.vtk, output.picture), (true, false, true, true));
}

#[test]
fn sections_have_limits_in_si() {
    let limits = "min_bend_radius_moving = \"75 mm\"\nmax_tension = \"0.2 kN\"\nmax_torsion = \"0.5 turns/m\"\n";
    let text = HARNESS.replace("min_bend_radius = ", &format!("{limits}min_bend_radius = "));
    let [trunk, arm] = &read(&text).sections[..] else { panic!() };
    assert_eq!((trunk.min_bend_radius_moving, trunk.max_tension), (Some(0.075), Some(200.0)));
    assert_eq!(trunk.max_torsion, Some(std::f64::consts::PI));
    assert_eq!((arm.min_bend_radius_moving, arm.max_tension, arm.max_torsion), (None, None, None));
    // A twist per length, not an angle.
    let wrong = text.replace("0.5 turns/m", "0.5 turns");
    let faults = parse(&wrong, &common::registry()).err().map(|faults| render(&wrong, &faults)).unwrap_or_default();
    assert!(faults.contains("max_torsion"), "{faults}");
}

#[test]
fn joint_arms_have_the_frames_of_their_branches() {
    let scenario = read(HARNESS);
    let arms = &scenario.joints[0].arms;
    assert_eq!((arms[0].starts_here, arms[1].starts_here), (false, true));
    // The trunk ends here: its arm points to −x, its d3 to +x.
    assert!((arms[0].rest * Vector::z() - Vector::x()).norm() < 1e-12);
    assert!((arms[0].rest * Vector::x() - Vector::z()).norm() < 1e-12);
    assert!((arms[1].rest * Vector::z() - Vector::new(0.866, 0.5, 0.0).normalize()).norm() < 1e-12);
    assert_eq!(arms[2].rest, Rotation::identity());
    assert_eq!(scenario.joints[0].wires.len(), 2);
}

#[test]
fn constraints_know_what_they_are_given() {
    let scenario = read(HARNESS);
    let [plug, clip, hand, plug_b] = scenario.constraints.as_slice() else { panic!() };
    assert_eq!(plug.at, [At::Branch { branch: 0, s: 0.0 }]);
    assert!(matches!(plug.facing, Facing::Orientation(_)) && plug.tangent_given && plug.up_given);
    assert!(clip.tangent_given && !clip.up_given && clip.from_start);
    assert_eq!(clip.parameters.word("twist"), Some("held"));
    assert_eq!((clip.limits.pull_out_force, clip.limits.max_moment), (Some(120.0), Some(0.5)));
    assert_eq!((clip.limits.insertion_force, clip.slide, plug.limits), (None, None, Limits::default()));
    let built = built(HARNESS);
    assert_eq!(built.network.constraints[1].limits, clip.limits);
    assert!(hand.tangent_given && !hand.up_given && hand.facing == Facing::Left);
    assert!(plug_b.tangent_given && plug_b.up_given && !plug_b.from_start && plug_b.position.is_none());
}

#[test]
fn steps_are_resolved() {
    let scenario = read(HARNESS);
    let [first, second] = scenario.steps.as_slice() else { panic!() };
    assert_eq!((first.name.as_str(), first.increments, first.add.as_slice()), ("plug B", 40, [3].as_slice()));
    let constraint = |k: usize| first.moves[k].carried.iter().map(|carried| carried.constraint).collect::<Vec<_>>();
    assert_eq!((constraint(0), constraint(1)), (vec![3], vec![2]));
    let shares: Vec<f64> = first.moves[0].track.positions.iter().map(|knot| knot.0).collect();
    assert_eq!((shares, first.moves[0].track.spin), (vec![0.5, 1.0], 0.5));
    assert_eq!(first.moves[1].track.turns, [(1.0, Turn::Tangent(Vector::y()))]);
    assert_eq!((second.release.as_slice(), second.loads.as_slice()), ([2].as_slice(), [(0, 1.0)].as_slice()));
}

#[test]
fn attachments_sit_on_nodes_and_the_network_is_put_together() {
    let built = built(HARNESS);
    let network = &built.network;
    let trunk = &network.branches[0];
    let mesh = trunk.rod.mesh();
    assert_eq!(mesh.segments(), 60);
    assert_eq!(network.constraints[1].place, Place::Node { branch: 0, node: 30 });
    assert!((mesh.arc_lengths()[30] - 0.305).abs() < 1e-15);
    assert_eq!(mesh.stations, [0, 30]);
    assert_eq!((trunk.start, trunk.end), (BranchEnd::Free, BranchEnd::Joint { joint: 0, arm: 0 }));
    // 100 mm and 300 mm in segments of at most 30 mm; a load with a moment makes a station.
    let right = network.branches[2].rod.mesh();
    assert_eq!((right.segments(), right.stations.as_slice()), (14, [4, 14].as_slice()));
    assert_eq!(network.branches[2].path.len(), 3);
    assert_eq!(built.notes, ["joint \"J\": 3 arms"]);
    assert_eq!(built.minimiser.name(), "newton");
    assert_eq!(built.schedule.steps.len(), 2);
    assert!(built.schedule.increments);
    assert!(built.schedule.initial.is_some());
}

#[test]
fn hubs_have_stations_at_their_arms() {
    let text = HARNESS
        .replace("model = \"cosserat\"", "model = \"rigid-body\"\nmass = \"30 g\"")
        .replace("orientation = [1, 0, 0, 0] }", "orientation = [2, 0, 0, 0], offset = [\"25 mm\", 0, 0] }");
    let built = built(&text);
    assert_eq!(built.network.joints[0].mass, 0.03);
    assert_eq!(built.network.branches[0].rod.mesh().stations, [0, 30, 60]);
    assert_eq!(built.network.joints[0].arms[2].offset, Vector::new(0.025, 0.0, 0.0));
}

#[test]
fn a_minimal_file_has_defaults() {
    let text = r#"
        schema = 1
        [sections.s]
        diameter = 0.01
        linear_density = 0
        axial_stiffness = 1
        bending_stiffness = 1
        torsion_stiffness = 1
        [[branches]]
        name = "b"
        from = "A"
        to = "B"
        section = "s"
        length = 1
        segments = 2
        [[constraints]]
        name = "c"
        kind = "connector"
        at = { end = "A" }
    "#;
    let scenario = read(text);
    assert_eq!((scenario.name.as_str(), scenario.minimiser.kind.as_str()), ("harness", "newton"));
    assert_eq!(scenario.gravity, Vector::new(0.0, 0.0, -9.81));
    assert!(scenario.steps.is_empty() && scenario.output.picture && !scenario.output.increments);
}

#[test]
fn handing_over_is_no_contradiction() {
    let text = HARNESS.replace(
        "[[steps.load]]",
        "[[steps.add]]\nname = \"second hand\"\nkind = \"handle\"\nat = { end = \"B\" }\n[[steps.load]]",
    );
    read(&text);
}

#[test]
fn obstacles_have_shapes_that_stand_and_move() {
    let text = format!(
        "{HARNESS}
[contact]
cables = true
[[obstacles]]
name = \"floor\"
shape = \"plane\"
point = [0, 0, \"-200 mm\"]
[[obstacles]]
name = \"door\"
shape = \"box\"
size = [0.4, 0.2, \"10 mm\"]
position = [1, 0, 0]
tangent = [1, 0, 0]
friction = 0.3
min_clearance = \"6 mm\"
max_contact_force = \"12 N\"
[[steps]]
name = \"close\"
increments = 3
[[steps.move]]
obstacle = \"door\"
via = [[1, 1, 0]]
position = [2, 1, 0]
turns = 0.25
"
    );
    let scenario = read(&text);
    let network = built(&text).network;
    assert!(network.contact.cables && !network.contact.resolve);
    let [floor, door] = network.obstacles.as_slice() else { panic!("{} obstacles", network.obstacles.len()) };
    assert_eq!((floor.name.as_str(), floor.kind.as_str(), floor.min_clearance), ("floor", "plane", None));
    assert_eq!(floor.shape.distance(&Vector::zeros(), 1.0), 0.2);
    assert_eq!((door.friction, door.min_clearance, door.max_contact_force), (0.3, Some(0.006), Some(12.0)));
    assert_eq!(floor.max_contact_force, None);
    // Its third axis, along which it is thin, points along x.
    assert!((door.pose.orientation * Vector::z() - Vector::x()).norm() < 1e-15);
    let [motion] = scenario.steps.last().unwrap().obstacle_moves.as_slice() else { panic!() };
    assert_eq!((motion.obstacle, motion.track.spin), (1, 0.25));
    assert_eq!(motion.track.positions, [(0.5, Vector::new(1.0, 1.0, 0.0)), (1.0, Vector::new(2.0, 1.0, 0.0))]);
}
