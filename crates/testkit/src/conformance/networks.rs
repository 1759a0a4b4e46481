//! Small harnesses, built from whatever kinds a registry knows.

use wireloom_core::constraint::{ConstraintSpec, Limits};
use wireloom_core::joint::{JointSpec, WireShare};
use wireloom_core::network::{BranchPlan, ConstraintPlan, JointPlan, Place};
use wireloom_core::rod::{Mesh, RodSpec};
use wireloom_core::rotation::{columns, frame_from};
use wireloom_core::{
    Arm, ArmSpring, Conditions, JointModel, Mounting, Network, Parameters, Problem, Registry, Rotation, Section, State,
    Vector,
};

/// A harness in its rest shape, with its conditions.
pub struct Sample {
    /// The harness.
    pub network: Network,
    /// Gravity, and every constraint where its station is in `state`.
    pub conditions: Conditions,
    /// The rest shape.
    pub state: State,
}

impl Sample {
    /// The problem.
    pub fn problem(&self) -> Problem<'_> {
        Problem::new(&self.network, self.conditions.clone())
    }
}

/// A branch as straight piece, `start + s d3`.
struct Straight {
    name: String,
    start: Vector,
    to: Vector,
    frame: Rotation,
    length: f64,
    segments: usize,
    /// Joint at its start and at its end.
    joints: [Option<usize>; 2],
    /// Half as stiff as the trunk.
    thin: bool,
}

impl Straight {
    fn end(&self, start: bool) -> Vector {
        if start { self.start } else { self.to }
    }
}

/// A harness while it is drawn: joints are points in space with world axes. An arm whose end is not drawn at its joint
/// leaves it with an offset.
#[derive(Default)]
pub struct Sketch {
    branches: Vec<Straight>,
    joints: Vec<(String, Vector)>,
    clamped: Vec<(usize, bool)>,
    wires: Vec<WireShare>,
}

/// Section of the trunk, or of a thin arm.
pub fn section(thin: bool) -> Section {
    let f = if thin { 0.5 } else { 1.0 };
    Section {
        name: if thin { "thin" } else { "trunk" }.into(),
        diameter: 0.008,
        linear_density: 0.08 * f,
        axial_stiffness: 2e4 * f,
        shear_stiffness: [8e3 * f, 8e3 * f],
        bending_stiffness: [0.012 * f, 0.012 * f],
        torsion_stiffness: 0.009 * f,
        coupling_stiffness: [0.0; 3],
        min_bend_radius: None,
        min_bend_radius_moving: None,
        max_tension: None,
        max_torsion: None,
        thermal_expansion: 0.0,
        thermal_curvature: Vector::zeros(),
        friction: Default::default(),
        set: None,
        laws: Default::default(),
    }
}

impl Sketch {
    /// A joint of this model.
    pub fn joint(&mut self, model: &str, at: Vector) -> usize {
        self.joints.push((model.into(), at));
        self.joints.len() - 1
    }

    /// A straight branch; gives its index.
    pub fn branch(
        &mut self,
        from: Vector,
        to: Vector,
        segments: usize,
        joints: [Option<usize>; 2],
        thin: bool,
    ) -> usize {
        let up = if (to - from).cross(&Vector::z()).norm() > 1e-6 { Vector::z() } else { Vector::x() };
        self.branches.push(Straight {
            name: format!("branch {}", self.branches.len()),
            start: from,
            to,
            frame: frame_from(&(to - from), &up).expect("neither zero nor parallel"),
            length: (to - from).norm(),
            segments,
            joints,
            thin,
        });
        self.branches.len() - 1
    }

    /// Clamps one end of a branch by a `connector`.
    pub fn clamp(&mut self, branch: usize, at_start: bool) {
        self.clamped.push((branch, at_start));
    }

    /// Gives every joint this table of wires.
    pub fn wires(&mut self, wires: Vec<WireShare>) {
        self.wires = wires;
    }

    fn arms(&self, joint: usize) -> (Vec<Arm>, Vec<usize>) {
        let (mut arms, mut branches) = (vec![], vec![]);
        for (b, branch) in self.branches.iter().enumerate() {
            for (end, starts_here) in [(0, true), (1, false)] {
                if branch.joints[end] == Some(joint) {
                    arms.push(Arm {
                        branch: branch.name.clone(),
                        starts_here,
                        rest: branch.frame,
                        offset: branch.end(starts_here) - self.joints[joint].1,
                        section: section(branch.thin),
                        segment_length: branch.length / branch.segments as f64,
                        length: branch.length,
                        curvature: Vector::zeros(),
                        spring: ArmSpring { bending: Some([0.3, 0.5]), torsion: Some(0.2), ..Default::default() },
                    });
                    branches.push(b);
                }
            }
        }
        (arms, branches)
    }

    /// Builds it.
    ///
    /// # Panics
    /// If the registry knows no rod `cosserat`, no constraint `connector` or not the joints drawn.
    pub fn build(self, registry: &Registry) -> Sample {
        let none = Parameters::default();
        let rods = registry.rod("cosserat").expect("the rod `cosserat`");
        let mut models: Vec<Box<dyn JointModel>> = Vec::new();
        for (j, (kind, _)) in self.joints.iter().enumerate() {
            let spec = JointSpec { name: format!("joint {j}"), arms: self.arms(j).0, wires: self.wires.clone() };
            let kind = registry.joint(kind).unwrap_or_else(|| panic!("no joint `{kind}`"));
            models.push((kind.build)(&spec, &none).expect("a joint"));
        }
        let branches = self.branches.iter().map(|branch| {
            let n = branch.segments;
            let has_station = |joint: Option<usize>| joint.is_none_or(|j| models[j].mounting() != Mounting::Point);
            let ends = [(0, branch.joints[0]), (n, branch.joints[1])];
            let stations = ends.into_iter().filter(|(_, joint)| has_station(*joint)).map(|(node, _)| node).collect();
            let mesh = Mesh::new(vec![branch.length / n as f64; n], stations);
            let name = branch.name.clone();
            let spec = RodSpec { name, sections: section(branch.thin).into(), mesh, curvature: Vector::zeros() };
            BranchPlan {
                name: branch.name.clone(),
                kind: rods.name.clone(),
                rod: (rods.build)(&spec, &none).expect("a rod"),
                sections: spec.sections,
                path: vec![],
                drawn: vec![],
            }
        });
        let branches: Vec<_> = branches.collect();
        let joints = models.into_iter().enumerate().map(|(j, model)| {
            let (arms, branches) = self.arms(j);
            let (kind, name) = (self.joints[j].0.clone(), format!("joint {j}"));
            JointPlan { name, kind, model, arms, branches, mass: 0.0 }
        });
        let joints: Vec<_> = joints.collect();
        let connector = registry.constraint("connector").expect("the constraint `connector`");
        let constraints = self.clamped.iter().map(|&(branch, at_start)| ConstraintPlan {
            name: format!("clamp of branch {branch}"),
            kind: "connector".into(),
            model: (connector.build)(&ConstraintSpec::default(), &none).expect("a connector"),
            outputs: Vec::new(),
            stations: vec![Place::Node { branch, node: if at_start { 0 } else { self.branches[branch].segments } }],
            span: None,
            position: None,
            tangent: None,
            orientation: None,
            mount: None,
            slide: None,
            limits: Limits::default(),
            nearest: false,
            from_start: true,
        });
        let network = Network::new(branches, joints, constraints.collect(), vec![]);
        let mut state = State::origin(&network);
        for (branch, plan) in network.branches.iter().zip(&self.branches) {
            let s = branch.rod.mesh().arc_lengths();
            let d3 = columns(&plan.frame)[2];
            for (x, s) in state.points[branch.points.clone()].iter_mut().zip(s) {
                *x = plan.start + d3 * s;
            }
            state.frames[branch.frames.clone()].fill(plan.frame);
        }
        for (joint, (_, at)) in network.joints.iter().zip(&self.joints) {
            state.points[joint.point] = *at;
        }
        network.follow_ties(&mut state);
        let conditions = Conditions::new(&network, Vector::new(0.0, 0.0, -9.81), &state);
        Sample { network, conditions, state }
    }
}

/// A cable of 1 m along x, clamped at both ends. Constraint 1 holds its far end.
pub fn cable(registry: &Registry, segments: usize) -> Sample {
    let mut sketch = Sketch::default();
    let b = sketch.branch(Vector::zeros(), Vector::x(), segments, [None, None], false);
    sketch.clamp(b, true);
    sketch.clamp(b, false);
    sketch.build(registry)
}

/// The cable of [`cable`] cut in the middle by a joint; all wires run through.
pub fn cut_cable(registry: &Registry, model: &str, segments: usize) -> Sample {
    let mut sketch = Sketch::default();
    let middle = Vector::x() * 0.5;
    let j = sketch.joint(model, middle);
    let a = sketch.branch(Vector::zeros(), middle, segments / 2, [None, Some(j)], false);
    let b = sketch.branch(middle, Vector::x(), segments / 2, [Some(j), None], false);
    sketch.wires(vec![WireShare { from: 0, to: 1, fraction: 1.0 }]);
    sketch.clamp(a, true);
    sketch.clamp(b, false);
    sketch.build(registry)
}

/// A trunk and two thin arms, one of them run towards the joint; all three ends clamped.
pub fn y_harness(registry: &Registry, model: &str, segments: usize) -> Sample {
    sized_y_harness(registry, model, segments, 0.0)
}

/// The harness of [`y_harness`], its arms leaving the joint at this distance (m) from its centre.
pub fn sized_y_harness(registry: &Registry, model: &str, segments: usize, radius: f64) -> Sample {
    let mut sketch = Sketch::default();
    let j = sketch.joint(model, Vector::zeros());
    let ends = [Vector::new(-0.5, 0.0, 0.0), Vector::new(0.3, 0.2, 0.0), Vector::new(0.3, -0.2, 0.0)];
    let at_joint = ends.map(|end| end.normalize() * radius);
    let trunk = sketch.branch(ends[0], at_joint[0], segments, [None, Some(j)], false);
    let left = sketch.branch(at_joint[1], ends[1], segments, [Some(j), None], true);
    let right = sketch.branch(ends[2], at_joint[2], segments, [None, Some(j)], true);
    sketch.clamp(trunk, true);
    sketch.clamp(left, false);
    sketch.clamp(right, true);
    sketch.build(registry)
}

/// A triangle of three branches hanging on a clamped tail; `cut` says how many pieces its last side has.
pub fn ring(registry: &Registry, model: &str, segments: usize, cut: usize) -> Sample {
    let mut sketch = Sketch::default();
    let corners = [Vector::zeros(), Vector::new(0.3, 0.2, 0.0), Vector::new(0.3, -0.2, 0.0)];
    let [a, b, c] = corners.map(|at| sketch.joint(model, at));
    let tail = sketch.branch(Vector::x() * -0.4, corners[0], segments, [None, Some(a)], false);
    sketch.branch(corners[0], corners[1], segments, [Some(a), Some(b)], true);
    sketch.branch(corners[1], corners[2], segments, [Some(b), Some(c)], true);
    let mut from = (corners[2], c);
    for piece in 1..=cut {
        let at = corners[2] + (corners[0] - corners[2]) * (piece as f64 / cut as f64);
        let to = if piece == cut { (corners[0], a) } else { (at, sketch.joint(model, at)) };
        sketch.branch(from.0, to.0, segments / cut, [Some(from.1), Some(to.1)], true);
        from = to;
    }
    sketch.clamp(tail, true);
    sketch.build(registry)
}
