//! Results made by hand.

use std::sync::Arc;
use wireloom_core::equilibrium::{
    BranchResult, Clearance, ClearanceFrom, ConstraintResult, Energy, Event, EventKind, EventPlace, JointResult,
    Library, MinimiserResult, Moment, ObstacleResult, Outcome, Run, StepResult, TightestBend,
};
use wireloom_core::obstacle::{Obstacle, Shape, Surface, Touch};
use wireloom_core::requirement::{Bound, Measure, Origin, RequirementResult, Severity, Verdict};
use wireloom_core::rotation::{frame_from, orthogonal};
use wireloom_core::{Pose, Rotation, Status, Vector};

pub fn v(x: f64, y: f64, z: f64) -> Vector {
    Vector::new(x, y, z)
}

/// A branch along `curve` (parameter 0..1), with bend radii from differences and made-up forces.
pub fn branch(
    name: &str,
    diameter: f64,
    limit: Option<f64>,
    segments: usize,
    curve: impl Fn(f64) -> Vector,
) -> BranchResult {
    let h = 1e-4;
    let at = |i: usize| i as f64 / segments as f64;
    let position: Vec<Vector> = (0..=segments).map(|i| curve(at(i))).collect();
    let mut s = vec![0.0];
    for edge in position.windows(2) {
        s.push(s[s.len() - 1] + (edge[1] - edge[0]).norm());
    }
    let derivatives = |t: f64| {
        let (a, b, c) = (curve(t - h), curve(t), curve(t + h));
        ((c - a) / (2.0 * h), (c - b * 2.0 + a) / (h * h))
    };
    let frame = |i: usize| {
        let (d, _) = derivatives(at(i));
        frame_from(&d, &v(0.0, 0.0, 1.0)).or_else(|| frame_from(&d, &orthogonal(&d))).unwrap_or_else(Rotation::identity)
    };
    let bend_radius = |i: usize| {
        let (d, dd) = derivatives(at(i));
        let k = d.cross(&dd).norm() / d.norm().powi(3);
        if k > 1e-5 { 1.0 / k } else { f64::INFINITY }
    };
    BranchResult {
        name: name.into(),
        diameter,
        bend_radius_limit: limit,
        axial_stiffness: 1e4,
        sections: Vec::new(),
        strain: None,
        force: (0..=segments).map(|i| v(1.5, 0.1 / 3.0, -at(i))).collect(),
        moment: (0..=segments).map(|i| v(0.0, 0.02 * at(i), 1e-300)).collect(),
        frame: (0..=segments).map(frame).collect(),
        bend_radius: (0..=segments).map(bend_radius).collect(),
        s,
        position,
        sides: Vec::new(),
        twist_turns: 0.25,
        error: None,
        deviation: None,
        friction: None,
    }
}

pub fn constraint(name: &str, kind: &str, position: Vector, force: Vector) -> ConstraintResult {
    ConstraintResult {
        name: name.into(),
        kind: kind.into(),
        position,
        orientation: Rotation::identity(),
        force,
        moment: v(0.01, 0.0, 0.0),
        stations: vec![],
        span: None,
        slide: None,
        outputs: vec![],
    }
}

pub fn joint(name: &str, position: Vector) -> JointResult {
    JointResult { name: name.into(), position, orientation: Rotation::identity(), friction: vec![] }
}

pub fn step(branches: Vec<BranchResult>, joints: Vec<JointResult>, constraints: Vec<ConstraintResult>) -> StepResult {
    let mut tightest: Option<TightestBend> = None;
    for branch in &branches {
        for (s, value) in branch.s.iter().zip(&branch.bend_radius) {
            if value.is_finite() && tightest.as_ref().is_none_or(|t| *value < t.value) {
                let limit = branch.bend_radius_limit;
                tightest = Some(TightestBend { branch: branch.name.clone(), s: *s, value: *value, limit });
            }
        }
    }
    StepResult {
        obstacles: vec![],
        mechanisms: vec![],
        markers: vec![],
        name: "equilibrium".into(),
        increment: 1,
        increments: 1,
        status: Status::Converged,
        branches,
        joints,
        constraints,
        operations: vec![],
        energy: Energy {
            stretch: 0.1,
            shear: 0.2,
            bend: 0.3,
            twist: 1e-17,
            gravity: -4.0,
            load: 5.0,
            joint: 0.0,
            constraint: 0.7,
        },
        min_bend_radius: tightest,
        violations: vec![],
        stable: Some(true),
        minimiser: MinimiserResult {
            kind: "newton".into(),
            device: None,
            iterations: 6,
            polish: 0,
            factorisations: 7,
            seconds: 0.004,
            force_residual: 1.25e-9,
            shape_error: Some(3.5e-10),
            constraint_residual: None,
        },
    }
}

pub fn run(scenario: &str, steps: Vec<StepResult>) -> Run {
    Run {
        scenario: scenario.into(),
        outcome: Outcome::Graded(Status::Converged),
        notes: vec!["a remark".into()],
        events: vec![event()],
        steps,
        clearances: vec![],
        requirements: vec![],
        plugins: vec![Library {
            name: "straps".into(),
            version: "1.2.3".into(),
            file: "plugins/libstraps.so".into(),
            hash: "5e".into(),
        }],
        identities: Default::default(),
        drawn_start: None,
        sensitivities: Vec::new(),
    }
}

/// A Y that sags, turns up and down, with one bend that is too tight and one arm without a limit.
pub fn y_harness() -> StepResult {
    let trunk = |t: f64| v(0.6 * t, 0.05 * (3.0 * t).sin(), -0.18 * t * (2.0 - t));
    let j = trunk(1.0);
    let left = move |t: f64| j + v(0.35 * t, 0.25 * t * t, 0.12 * (4.2 * t).sin() - 0.05 * t);
    let right =
        move |t: f64| j + v(0.24 * t + 0.035 * (9.0 * t).sin(), -0.2 * t, -0.16 * t + 0.035 * (9.0 * t).cos() - 0.035);
    let spare = move |t: f64| j + v(0.1 * t, 0.02 * t, -0.22 * t - 0.03 * (3.0 * t).sin());
    step(
        vec![
            branch("trunk", 0.012, Some(0.048), 60, trunk),
            branch("left", 0.008, Some(0.04), 40, left),
            branch("right", 0.005, Some(0.045), 120, right),
            branch("spare", 0.006, None, 40, spare),
        ],
        vec![joint("J", j)],
        vec![
            constraint("plug-A", "connector", trunk(0.0), v(1.0, 2.0, 3.0)),
            constraint("clip-1", "collar", trunk(0.5), v(0.0, 0.0, 5.0)),
            constraint("plug-B", "connector", left(1.0), v(0.5, 0.0, 0.0)),
            constraint("hand", "handle", right(1.0), v(0.0, 0.0, 7.25)),
            constraint("magnet <north> & \"south\"", "my-plugin", left(0.5), v(0.0, 0.1, 0.0)),
        ],
    )
}

/// 30 trunks in a row, each with four arms: 150 branches.
pub fn big_harness() -> StepResult {
    let (mut branches, mut joints, mut constraints) = (Vec::new(), Vec::new(), Vec::new());
    let spine = |u: f64| v(u, 0.3 * (2.2 * u).sin(), 0.15 * (5.0 * u).cos() - 0.1 * u);
    for k in 0..30 {
        let (a, b) = (0.12 * k as f64, 0.12 * (k + 1) as f64);
        branches.push(branch(&format!("spine-{k}"), 0.02, Some(0.1), 20, move |t| spine(a + t * (b - a))));
        let j = spine(b);
        joints.push(joint(&format!("J{k}"), j));
        if k % 5 == 0 {
            constraints.push(constraint(&format!("clip-{k}"), "collar", spine(a), v(0.0, 0.0, 3.0 + k as f64)));
        }
        for arm in 0..4 {
            let phase = 1.3 * k as f64 + 1.57 * arm as f64;
            let reach = 0.25 + 0.02 * ((7 * k + 3 * arm) % 11) as f64;
            let curve = move |t: f64| {
                j + v(
                    0.1 * t * phase.sin() + 0.015 * (11.0 * t).sin(),
                    reach * t * phase.cos(),
                    reach * t * phase.sin() - 0.2 * t * t,
                )
            };
            branches.push(branch(&format!("arm-{k}-{arm}"), 0.006, Some(0.02), 30, curve));
            let kind = if arm == 3 { "handle" } else { "connector" };
            constraints.push(constraint(
                &format!("plug-{k}-{arm}"),
                kind,
                curve(1.0),
                v(0.0, 0.0, 0.1 * (k + arm) as f64),
            ));
        }
    }
    step(branches, joints, constraints)
}

/// A straight cable along one axis (0, 1, 2).
pub fn straight(axis: usize) -> StepResult {
    let mut end = v(0.0, 0.0, 0.0);
    end[axis] = 1.2;
    let start = v(5.0, -3.0, 0.7);
    step(
        vec![branch("cable", 0.008, Some(0.05), 50, move |t| start + end * t)],
        vec![],
        vec![
            constraint("plug-A", "connector", start, v(1.0, 0.0, 0.0)),
            constraint("plug-B", "connector", start + end, v(-1.0, 0.0, 0.0)),
        ],
    )
}

/// A harness drawn in the plane z = 0.
pub fn planar() -> StepResult {
    let a = |t: f64| v(0.5 * t, 0.1 * (4.0 * t).sin(), 0.0);
    let j = a(1.0);
    let b = move |t: f64| j + v(0.3 * t, 0.3 * t * t, 0.0);
    let c = move |t: f64| j + v(0.3 * t, -0.4 * t * t, 0.0);
    step(
        vec![branch("a", 0.01, None, 50, a), branch("b", 0.01, None, 50, b), branch("c", 0.004, None, 50, c)],
        vec![joint("J", j)],
        vec![
            constraint("start", "connector", a(0.0), v(1.0, 0.0, 0.0)),
            constraint("upper end", "connector", b(1.0), v(0.0, 1.0, 0.0)),
            constraint("lower end", "handle", c(1.0), v(0.0, -1.0, 0.0)),
        ],
    )
}

/// Everything that a failed run may leave behind.
pub fn broken() -> StepResult {
    let mut step = y_harness();
    step.status = Status::Failed;
    step.stable = None;
    step.branches[0].position[10] = v(f64::NAN, 0.0, 0.0);
    step.branches[0].bend_radius[10] = f64::NAN;
    step.branches[1].position[40] = v(0.0, f64::INFINITY, 0.0);
    step.branches[1].force[0] = v(f64::NEG_INFINITY, 0.0, 0.0);
    step.branches[2].diameter = f64::NAN;
    step.branches[3].bend_radius[3] = 0.0;
    step.constraints[0].position = v(1e300, 0.0, 0.0);
    step.constraints[1].force = v(f64::NAN, 0.0, 0.0);
    step.joints[0].position = v(f64::NAN, f64::NAN, f64::NAN);
    step.energy.bend = f64::NAN;
    step.minimiser.force_residual = f64::INFINITY;
    step
}

/// A surface and nothing else.
struct Drawn(Surface);

impl Shape for Drawn {
    fn distance(&self, _: &Vector, _: f64) -> f64 {
        f64::INFINITY
    }
    fn touches(&self, _: &Vector, _: f64, _: &mut dyn FnMut(Touch)) {}
    fn crossing(&self, _: &Vector, _: &Vector) -> Option<f64> {
        None
    }
    fn surface(&self, _: f64) -> Surface {
        self.0.clone()
    }
}

/// A cube of edge 0.2 m, its faces divided `n` times.
pub fn cube(n: u32) -> Obstacle {
    let mut surface = Surface::default();
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let first = surface.corners.len() as u32;
        let at = |k: u32| 0.2 * f64::from(k) / f64::from(n) - 0.1;
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            let mut corner = v(0.0, 0.0, 0.0);
            (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (0.1 * side, at(i), side * at(j));
            surface.corners.push(corner);
        }
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| first + i * (n + 1) + j);
            surface.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Obstacle {
        name: "a <cube>".into(),
        kind: "mesh".into(),
        shape: Arc::new(Drawn(surface)),
        pose: Pose::identity(),
        mount: None,
        friction: 0.0,
        min_clearance: None,
        max_contact_force: None,
    }
}

/// Something that touches it, and something that is near.
pub fn among_obstacles() -> Run {
    let mut end = y_harness();
    end.obstacles.push(ObstacleResult {
        name: "floor".into(),
        pose: Pose { position: v(0.0, 0.0, -0.2), orientation: Rotation::identity() },
        force: v(0.0, 0.25, 1.5),
        moment: v(0.125, 0.0, 0.0),
        contact_force: 1.75,
        contacts: 7,
        depth: 2e-7,
    });
    let mut run = run("on the floor", vec![end]);
    let moment = Moment { step: "equilibrium".into(), step_index: 0, increment: 1 };
    let clearance = |from: ClearanceFrom, required: Option<f64>| Clearance {
        branch: "trunk".into(),
        from,
        distance: 0.0045,
        s: 0.25,
        position: v(0.2, 0.0, -0.1),
        required,
        moment: moment.clone(),
    };
    run.clearances = vec![
        clearance(ClearanceFrom::Obstacle("post".into()), Some(0.006)),
        clearance(ClearanceFrom::Branch { name: "left".into(), s: 0.125 }, None),
    ];
    run
}

/// An event of some length.
pub fn event() -> Event {
    let moment = |increment| Moment { step: "pull".into(), step_index: 1, increment };
    Event {
        kind: EventKind::BendRadius,
        place: EventPlace::branch("trunk", 0.25),
        first: moment(2),
        worst: moment(3),
        last: moment(4),
        increments: 3,
        value: Some(0.04),
        limit: Some(0.05),
        message: "bend radius 40.0 mm, allowed 50.0 mm".into(),
    }
}

/// A line of the sheet about a place of the last step; a margin decides its verdict.
pub fn requirement(name: &str, measure: Measure, [worst, limit]: [f64; 2], place: EventPlace) -> RequirementResult {
    let bound = match measure {
        Measure::BendRadius | Measure::Clearance | Measure::Slack => Bound::Min,
        _ => Bound::Max,
    };
    RequirementResult {
        name: name.into(),
        origin: Origin::Scenario,
        measure,
        severity: Severity::Must,
        because: None,
        verdict: if bound.gap(worst, limit) < 0.0 { Verdict::Fail } else { Verdict::Pass },
        reason: None,
        worst: Some(worst),
        limit,
        bound,
        error: None,
        moment: Some(Moment { step: "equilibrium".into(), step_index: 0, increment: 1 }),
        place,
    }
}

/// The Y with a sheet that has a line of every verdict: a bend too tight, a trunk pulled too much, a doubted clearance.
pub fn failing() -> Run {
    let end = y_harness();
    let bend = end.min_bend_radius.clone().expect("a bend");
    let mut run = run("y <harness>", vec![end]);
    run.requirements = vec![
        requirement("plug-A", Measure::Force, [3.742, 80.0], EventPlace::constraint("plug-A")),
        RequirementResult {
            origin: Origin::Section,
            because: Some("VW <60306>".into()),
            error: Some(4e-4),
            ..requirement("wire", Measure::BendRadius, [bend.value, 0.045], EventPlace::branch(&bend.branch, bend.s))
        },
        requirement("trunk pull", Measure::Tension, [1.42, 1.4], EventPlace::branch("trunk", 0.0)),
        RequirementResult {
            verdict: Verdict::Unresolved,
            reason: Some("the discretisation error reaches over the limit".into()),
            ..requirement("gap", Measure::Clearance, [0.0062, 0.006], EventPlace::branch("left", 0.2))
        },
        RequirementResult {
            severity: Severity::Should,
            ..requirement("hand", Measure::Force, [7.25, 5.0], EventPlace::constraint("hand"))
        },
        RequirementResult {
            verdict: Verdict::NotChecked,
            reason: Some("it was not pushed in in these steps".into()),
            worst: None,
            moment: None,
            ..requirement("push", Measure::InsertionForce, [0.0, 45.0], EventPlace::default())
        },
    ];
    run
}
