use super::closure::{Driven, WayFault};
use super::{JointKind, Mechanism, MechanismFault, MechanismJoint};
use crate::{Rotation, Vector};
use nalgebra::Unit;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn joint(name: &str, kind: JointKind, bodies: [usize; 2], origin: [f64; 3]) -> MechanismJoint {
    let (drawn, limits) = (vec![0.0; kind.freedoms()], vec![[f64::NEG_INFINITY, f64::INFINITY]; kind.freedoms()]);
    MechanismJoint { name: name.to_owned(), kind, bodies, origin: origin.into(), drawn, limits, follows: None }
}

fn about_z() -> JointKind {
    JointKind::Revolute(Vector::z_axis())
}

fn mechanism(bodies: usize, joints: Vec<MechanismJoint>) -> Mechanism {
    let names = (0..bodies).map(|k| format!("body {k}")).collect();
    Mechanism::new("test".to_owned(), names, joints).unwrap()
}

fn to(freedom: usize, value: f64) -> Driven {
    Driven { freedom, through: vec![(1.0, value)] }
}

/// A four-bar linkage: pivots A and D on the ground, the moving pivots B and C.
fn four_bar([a, b, c, d]: [[f64; 3]; 4]) -> Mechanism {
    let joints = vec![
        joint("A", about_z(), [0, 1], a),
        joint("B", about_z(), [1, 2], b),
        joint("C", about_z(), [2, 3], c),
        joint("D", about_z(), [3, 0], d),
    ];
    mechanism(4, joints)
}

const CRANK: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.0, 0.1, 0.0], [0.3, 0.35, 0.0], [0.4, 0.0, 0.0]];

/// Pivot C of a four-bar linkage: where the circles about B and D meet, on the drawn side of the line BD.
fn closed_form(points: [[f64; 3]; 4], crank: f64) -> Vector {
    let [a, b, c, d] = points.map(Vector::from);
    let b_now = a + Rotation::from_axis_angle(&Vector::z_axis(), crank) * (b - a);
    let (r, s) = ((c - b).norm(), (c - d).norm());
    let line = d - b_now;
    let length = line.norm();
    let along = (r * r - s * s + length * length) / (2.0 * length);
    let beside = (r * r - along * along).sqrt();
    let side = (d - b).cross(&(c - b)).z.signum();
    b_now + line / length * along + Vector::z().cross(&line) / length * beside * side
}

#[test]
fn a_hinge_moves_exactly_on_its_arc_and_back_to_the_bit() {
    let hinge = mechanism(2, vec![joint("hinge", about_z(), [0, 1], [0.1, -0.2, 0.0])]);
    let open = hinge.way(&[0.0], &[to(0, 1.2)]).unwrap();
    let drawn = Vector::new(0.9, 0.3, 0.4);
    for t in [0.0, 0.1, 0.37, 1.0] {
        let angle = 1.2 * t;
        let values = hinge.at(&open, t);
        let (x, y) = (0.8, 0.5);
        let on_arc =
            Vector::new(0.1 + x * angle.cos() - y * angle.sin(), -0.2 + x * angle.sin() + y * angle.cos(), 0.4);
        assert!((hinge.poses(&values)[1].world(&drawn) - on_arc).norm() < 1e-15, "{t}");
    }
    let shut = hinge.way(open.end(), &[to(0, 0.0)]).unwrap();
    assert_eq!(hinge.poses(&hinge.at(&shut, 1.0))[1].world(&drawn), drawn);
}

/// A crank that turns all the way around, with the closed form at fractions that are no knots.
#[test]
fn a_four_bar_linkage_follows_its_closed_form() {
    let linkage = four_bar(CRANK);
    let way = linkage.way(&[0.0; 4], &[to(0, TAU)]).unwrap();
    for k in 0..=40 {
        let t = k as f64 / 40.0;
        let c = linkage.poses(&linkage.at(&way, t))[2].world(&CRANK[2].into());
        let error = (c - closed_form(CRANK, TAU * t)).norm();
        assert!(error < 1e-12, "{error:e} at {t}");
    }
}

/// The linkage does not move in its plane alone: it is turned in space, and closes all the same.
#[test]
fn a_loop_closes_whichever_way_its_joints_are_given() {
    let turn = Rotation::from_euler_angles(0.4, -1.1, 2.0);
    let axis = Unit::new_normalize(turn * Vector::z());
    let moved = CRANK.map(|x| turn * Vector::from(x) + Vector::new(0.3, 1.0, -2.0));
    let straight = four_bar(CRANK);
    let way = straight.way(&[0.0; 4], &[to(0, 2.0)]).unwrap();
    let expected = turn * straight.poses(way.end())[2].world(&CRANK[2].into()) + Vector::new(0.3, 1.0, -2.0);
    for reversed in 0..16 {
        let ends = [[0, 1], [1, 2], [2, 3], [3, 0]];
        let joints = (0..4).map(|k| {
            let backwards = reversed >> k & 1 == 1;
            let [a, b] = ends[k];
            joint("", JointKind::Revolute(axis), if backwards { [b, a] } else { [a, b] }, moved[k].into())
        });
        let linkage = mechanism(4, joints.collect());
        let value = if reversed & 1 == 1 { -2.0 } else { 2.0 };
        let way = linkage.way(&[0.0; 4], &[to(0, value)]).unwrap();
        let c = linkage.poses(way.end())[2].world(&moved[2]);
        assert!((c - expected).norm() < 1e-12, "{reversed:b}: {:e}", (c - expected).norm());
    }
}

/// A parallelogram: at 90° all pivots lie on one line, where it could fold into an antiparallelogram.
#[test]
fn a_parallelogram_keeps_to_its_branch_from_wherever_it_starts_and_does_not_begin_at_a_dead_point() {
    let linkage = four_bar([[0.0, 0.0, 0.0], [0.0, 0.1, 0.0], [0.2, 0.1, 0.0], [0.2, 0.0, 0.0]]);
    // Joints B and D turn back as far as A and C turn.
    let right = |values: &[f64], angle: f64| {
        let expected = [angle, -angle, angle, -angle];
        assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{angle}: {values:?}");
    };
    for first in [-60.0, -89.0, -89.5, -89.99, -90.01, -90.5, -95.0] {
        let mut values = vec![0.0; 4];
        for angle in [first, -120.0, -170.0, -10.0, 0.0] {
            let angle = f64::to_radians(angle);
            let way = linkage.way(&values, &[to(0, angle)]).unwrap();
            values = way.end().to_vec();
            right(&values, angle);
        }
    }
    let dead = -FRAC_PI_2;
    let through = |knots: &[(f64, f64)]| [Driven { freedom: 0, through: knots.to_vec() }];
    let fault = linkage.way(&[0.0; 4], &through(&[(0.5, dead), (1.0, -2.0)])).unwrap_err();
    assert!(matches!(fault, WayFault::Open { fraction: 0.5, missing: 1, .. }), "{fault}");
    let there = linkage.way(&[0.0; 4], &[to(0, dead)]).unwrap();
    let fault = linkage.way(there.end(), &[to(0, -2.0)]).unwrap_err();
    assert!(matches!(fault, WayFault::Open { fraction: 0.0, missing: 1, .. }), "{fault}");
}

#[test]
fn a_joint_that_follows_has_one_freedom_and_follows_a_joint_of_one_freedom() {
    let follows = |kinds: [JointKind; 2], of: usize| {
        let [a, b] = kinds;
        let mut joints = vec![joint("a", a, [0, 1], [0.0; 3]), joint("b", b, [1, 2], [0.1, 0.0, 0.0])];
        joints[1].follows = Some((of, 2.0));
        let names = (0..3).map(|k| format!("body {k}")).collect();
        Mechanism::new("test".to_owned(), names, joints)
    };
    assert!(follows([about_z(), about_z()], 0).is_ok());
    for (kinds, of) in [
        ([JointKind::Fixed, about_z()], 0),
        ([about_z(), JointKind::Fixed], 0),
        ([about_z(), JointKind::Spherical], 0),
        ([about_z(), about_z()], 1),
        ([about_z(), about_z()], 2),
    ] {
        assert_eq!(follows(kinds, of).unwrap_err(), MechanismFault::Follows(1));
    }
}

/// A slide does not turn what is on it, whatever hangs beyond.
#[test]
fn a_body_keeps_a_direction_that_only_joints_beyond_it_turn() {
    let joints = vec![
        joint("slide", JointKind::Prismatic(Vector::x_axis()), [0, 1], [0.0; 3]),
        joint("flap", about_z(), [1, 2], [0.1, 0.0, 0.0]),
    ];
    let both = mechanism(3, joints);
    assert!(both.keeps(1, &Vector::x()) && !both.keeps(2, &Vector::x()) && both.keeps(2, &Vector::z()));
}

/// A gas strut: cylindrical between two spherical joints would turn about itself; with a universal joint it does not.
#[test]
fn a_strut_between_a_body_and_the_ground_follows_and_a_free_turn_of_it_is_refused() {
    let [foot, head] = [[0.0, 0.0, 0.0], [0.3, 0.0, 0.4]];
    let along = Unit::new_normalize(Vector::from(head) - Vector::from(foot));
    let strut = |kind: JointKind| {
        mechanism(
            4,
            vec![
                joint("hinge", JointKind::Revolute(Vector::y_axis()), [0, 1], [0.5, 0.0, 0.5]),
                joint("head", JointKind::Spherical, [1, 2], head),
                joint("rod", JointKind::Prismatic(along), [2, 3], foot),
                joint("foot", kind, [3, 0], foot),
            ],
        )
    };
    let open = strut(JointKind::Spherical).way(&[0.0; 8], &[to(0, 0.5)]);
    assert!(matches!(open, Err(WayFault::Open { missing: 1, .. })), "{open:?}");
    let firm = strut(JointKind::Universal([Vector::x_axis(), Vector::y_axis()]));
    let way = firm.way(&[0.0; 7], &[to(0, 0.5)]).unwrap();
    let values = firm.at(&way, 0.77);
    let poses = firm.poses(&values);
    let now = poses[1].world(&head.into());
    assert!((poses[2].world(&head.into()) - now).norm() < 1e-13);
    assert!((poses[3].world(&foot.into()) - Vector::from(foot)).norm() < 1e-13);
    let longer = values[firm.freedoms_of(2)][0];
    assert!((0.5 + longer - now.norm()).abs() < 1e-13 || (0.5 - longer - now.norm()).abs() < 1e-13);
}

#[test]
fn a_loop_that_cannot_close_is_refused_where_it_opens() {
    // A rocker: pivot B passes no further than where the coupler and the other arm are one line.
    let points = [[0.0, 0.0, 0.0], [0.0, 0.3, 0.0], [0.15, 0.4, 0.0], [0.4, 0.0, 0.0]];
    let [b, c, d] = [points[1], points[2], points[3]].map(Vector::from);
    let reach = (c - b).norm() + (c - d).norm();
    // Cosines: |B − D|² = 0.3² + 0.4² − 2·0.3·0.4 cos(angle at A).
    let angle = ((0.09 + 0.16 - reach * reach) / 0.24).acos();
    let most = angle - FRAC_PI_2;
    let linkage = four_bar(points);
    linkage.way(&[0.0; 4], &[to(0, most - 1e-3)]).unwrap();
    match linkage.way(&[0.0; 4], &[to(0, 2.0)]) {
        Err(WayFault::Parted { fraction, apart: (distance, _), .. }) => {
            assert!((2.0 * fraction - most).abs() < 1e-5, "{} instead of {most}", 2.0 * fraction);
            assert!(distance > 1e-3);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn two_driven_joints_of_one_loop_that_disagree_are_refused() {
    let linkage = four_bar(CRANK);
    let both = linkage.way(&[0.0; 4], &[to(0, 0.3), to(3, 0.3)]);
    assert!(matches!(both, Err(WayFault::Parted { .. })), "{both:?}");
}

#[test]
fn a_joint_stops_at_its_limit_and_may_come_back_from_beyond() {
    let mut hinge = joint("hinge", about_z(), [0, 1], [0.0; 3]);
    hinge.limits = vec![[0.1, 1.0]];
    let hinge = mechanism(2, vec![hinge]);
    assert!(hinge.way(&[0.0], &[to(0, 0.05)]).is_ok(), "towards its limits");
    assert!(matches!(hinge.way(&[0.0], &[to(0, 1.5)]), Err(WayFault::Limit { limit: 1.0, .. })));
    assert!(matches!(hinge.way(&[0.0], &[to(0, -0.1)]), Err(WayFault::Limit { limit: 0.1, .. })));
    let mut slide = joint("slide", JointKind::Cylindrical(Vector::z_axis()), [0, 1], [0.0; 3]);
    slide.limits[1] = [0.0, 0.02];
    let slide = mechanism(2, vec![slide]);
    assert!(slide.way(&[0.0; 2], &[to(0, 9.0), to(1, 0.02)]).is_ok(), "its turn has no limit");
    let passed = slide.way(&[0.0; 2], &[to(0, 9.0), to(1, 0.03)]);
    assert!(matches!(passed, Err(WayFault::Limit { joint: 0, freedom: 1, limit: 0.02, .. })), "{passed:?}");
}

/// Values count from those as drawn, and a joint that follows takes the changes of the other one.
#[test]
fn a_mechanism_drawn_half_open_is_where_it_is_drawn() {
    let mut leader = joint("leader", about_z(), [0, 1], [0.1, 0.0, 0.0]);
    leader.drawn = vec![0.5];
    let mut follower = joint("follower", about_z(), [1, 2], [0.3, 0.0, 0.0]);
    (follower.drawn, follower.follows) = (vec![-0.2], Some((0, -1.0)));
    let both = mechanism(3, vec![leader, follower]);
    assert_eq!(both.drawn(), [0.5, -0.2]);
    assert!(both.poses(&both.drawn()).iter().all(|pose| *pose == crate::Pose::identity()));
    let way = both.way(&both.drawn(), &[to(0, 0.9)]).unwrap();
    assert!((way.end()[1] + 0.6).abs() < 1e-15);
    let axis = Vector::z_axis();
    let [first, second] = [0.4, -0.4].map(|turn| Rotation::from_axis_angle(&axis, turn));
    let poses = both.poses(way.end());
    assert!(poses[1].orientation.angle_to(&first) < 1e-15 && poses[2].orientation.angle_to(&(first * second)) < 1e-15);
}

#[test]
fn bodies_that_hang_on_nothing_are_refused() {
    let names = || ["ground", "a", "b"].map(str::to_owned).to_vec();
    let loose = Mechanism::new("m".to_owned(), names(), vec![joint("j", about_z(), [1, 2], [0.0; 3])]);
    assert_eq!(loose.unwrap_err(), MechanismFault::Loose(1));
    let itself = Mechanism::new("m".to_owned(), names(), vec![joint("j", about_z(), [1, 1], [0.0; 3])]);
    assert_eq!(itself.unwrap_err(), MechanismFault::Itself(0));
    let universal = JointKind::Universal([Vector::z_axis(), -Vector::z_axis()]);
    let parallel = Mechanism::new("m".to_owned(), names(), vec![joint("j", universal, [0, 1], [0.0; 3])]);
    assert_eq!(parallel.unwrap_err(), MechanismFault::Parallel(0));
}

/// Joints of every kind in one chain: the velocities that Newton's method uses against differences of the poses, and
/// the identity as drawn.
#[test]
fn velocities_of_all_kinds_are_the_derivatives_of_the_poses() {
    let axis = Unit::new_normalize(Vector::new(0.3, -0.5, 0.8));
    let mut joints = vec![
        joint("r", JointKind::Revolute(axis), [0, 1], [0.1, 0.2, 0.3]),
        joint("p", JointKind::Prismatic(axis), [1, 2], [0.4, 0.1, 0.0]),
        joint("c", JointKind::Cylindrical(Vector::y_axis()), [2, 3], [0.5, -0.2, 0.1]),
        joint("s", JointKind::Screw(axis, 0.02), [3, 4], [0.0, 0.7, 0.2]),
        joint("u", JointKind::Universal([Vector::x_axis(), axis]), [4, 5], [0.3, 0.3, 0.9]),
        joint("b", JointKind::Spherical, [5, 6], [0.2, 0.6, 0.1]),
        joint("f", JointKind::Planar([Vector::x_axis(), Vector::z_axis()]), [6, 7], [-0.2, 0.1, 0.4]),
        joint("m", JointKind::Floating(Rotation::from_euler_angles(0.3, 1.2, -0.7)), [7, 8], [0.6, 0.2, -0.3]),
    ];
    for (k, joint) in joints.iter_mut().enumerate() {
        joint.drawn.iter_mut().enumerate().for_each(|(f, drawn)| *drawn = 0.2 - 0.11 * k as f64 + 0.3 * f as f64);
    }
    let chain = mechanism(9, joints);
    assert!(chain.poses(&chain.drawn()).iter().all(|pose| *pose == crate::Pose::identity()));
    let values: Vec<f64> = (0..chain.freedoms()).map(|k| 0.3 + 0.17 * k as f64 - 0.02 * (k * k) as f64).collect();
    let twists = chain.twists(&values, &chain.poses(&values));
    let drawn = Vector::new(0.7, -0.4, 0.2);
    let at = |values: &[f64]| chain.poses(values)[8];
    let step = 1e-5;
    for f in 0..chain.freedoms() {
        let moved = |by: f64| {
            let mut values = values.clone();
            values[f] += by;
            at(&values)
        };
        let [low, high] = [moved(-step), moved(step)];
        let velocity = (high.world(&drawn) - low.world(&drawn)) / (2.0 * step);
        let turned = (high.orientation * low.orientation.inverse()).scaled_axis() / (2.0 * step);
        let x = at(&values).world(&drawn);
        assert!((twists[f].at(&x) - velocity).norm() < 1e-9, "freedom {f}");
        assert!((twists[f].turn - turned).norm() < 1e-9, "freedom {f}");
    }
}

#[test]
fn a_screw_advances_by_its_pitch() {
    let screw = mechanism(2, vec![joint("s", JointKind::Screw(Vector::z_axis(), 0.002), [0, 1], [0.0; 3])]);
    let x = screw.poses(&[3.0 * TAU])[1].world(&Vector::new(0.1, 0.0, 0.0));
    assert!((x - Vector::new(0.1, 0.0, 0.006)).norm() < 1e-15);
    let half = screw.poses(&[PI])[1].world(&Vector::new(0.1, 0.0, 0.0));
    assert!((half - Vector::new(-0.1, 0.0, 0.001)).norm() < 1e-15);
}

#[test]
fn a_way_through_several_values_turns_back_where_it_is_told() {
    let hinge = mechanism(2, vec![joint("hinge", about_z(), [0, 1], [0.0; 3])]);
    let there_and_back = Driven { freedom: 0, through: vec![(0.25, 1.0), (0.5, 1.0), (1.0, 0.2)] };
    let way = hinge.way(&[0.4], &[there_and_back]).unwrap();
    for (t, value) in [(0.0, 0.4), (0.125, 0.7), (0.25, 1.0), (0.4, 1.0), (0.75, 0.6), (1.0, 0.2)] {
        assert!((hinge.at(&way, t)[0] - value).abs() < 1e-15, "{t}");
    }
    assert_eq!(way.corners(), [0.25, 0.5]);
}
