//! Random harnesses over wide distributions.

use super::scene::{Arm, Branch, Constraint, Facing, Joint, Load, Move, Obstacle, Place, Scene, Shape, Step};
use fastrand::Rng;
use std::f64::consts::TAU;
use wireloom::geometry::{Pose, Rotation, Vector};

/// Random numbers of the forms that are needed.
struct Dice(Rng);

impl Dice {
    fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.0.f64()
    }

    /// Evenly spread exponents.
    fn decades(&mut self, a: f64, b: f64) -> f64 {
        10f64.powf(self.between(a, b))
    }

    fn chance(&mut self, share: f64) -> bool {
        self.0.f64() < share
    }

    fn direction(&mut self) -> Vector {
        loop {
            let v = Vector::from_fn(|_, _| self.between(-1.0, 1.0));
            if (0.01..=1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }

    fn rotation(&mut self) -> Rotation {
        let axis = self.direction();
        Rotation::from_scaled_axis(axis * self.between(0.0, 0.5 * TAU))
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.0.usize(0..of.len())]
    }
}

/// Properties of a scene as a whole.
struct Manner {
    /// Stiffness of the softest branch, N m², and decades that others may be stiffer.
    softest: f64,
    decades: f64,
    /// Rarely few segments, or always.
    coarse: bool,
    rod: Option<&'static str>,
    model: Option<&'static str>,
    /// Little weight, and constraints near where the harness rests without them: one equilibrium alone.
    mild: bool,
    gravity: Vector,
}

/// A scene that grows.
struct Grower {
    dice: Dice,
    manner: Manner,
    scene: Scene,
    /// Vertices: where they are at rest, and the frame of their joint, or of the branch that ends there.
    poses: Vec<Pose>,
    /// Of every vertex the least length of cable that joins it to the first one, m.
    reach: Vec<f64>,
}

/// The harness of a seed.
pub fn generate(seed: u64) -> Scene {
    let mut dice = Dice(Rng::with_seed(seed));
    let mild = dice.chance(0.25);
    let manner = Manner {
        softest: dice.decades(-5.5, -1.0),
        decades: if dice.chance(0.4) { dice.between(0.0, 6.0) } else { 1.0 },
        coarse: dice.chance(0.25),
        rod: dice.chance(0.5).then(|| dice.pick(&["cosserat", "kirchhoff"])),
        model: dice.chance(0.5).then(|| dice.pick(&["cosserat", "rigid-body", "fused"])),
        mild,
        gravity: match dice.0.usize(0..20) {
            0..14 => Vector::new(0.0, 0.0, -9.81),
            14..17 => Vector::zeros(),
            _ => dice.direction() * 9.81,
        },
    };
    let scene = Scene {
        gravity: manner.gravity,
        branches: Vec::new(),
        joints: Vec::new(),
        constraints: Vec::new(),
        loads: Vec::new(),
        obstacles: Vec::new(),
        cables: None,
        steps: Vec::new(),
        minimiser: None,
    };
    let start = Pose { position: dice.direction() * 0.3, orientation: dice.rotation() };
    let mut grower = Grower { dice, manner, scene, poses: vec![start], reach: vec![0.0] };
    grower.grow();
    grower.close_loops();
    grower.steps();
    grower.fix();
    grower.load();
    grower.obstruct();
    grower.make_mild();
    soften(&mut grower.scene, seed);
    grower.scene
}

impl Grower {
    /// A branch from a vertex at a pose to a new one, or to one that is there.
    fn branch(&mut self, from: usize, to: usize, length: f64) -> Branch {
        let Self { dice, manner, .. } = self;
        let ei = manner.softest * if dice.chance(0.7) { dice.decades(0.0, manner.decades) } else { 1.0 };
        let diameter = dice.between(0.002, 0.012);
        let uneven = if dice.chance(0.2) { dice.decades(0.0, 1.5) } else { 1.0 };
        let segments = if manner.coarse || dice.chance(0.1) { dice.0.usize(1..=3) } else { dice.0.usize(4..=24) };
        let ea = (16.0 * ei / diameter.powi(2) * dice.decades(-1.5, 1.0)).max(1.0);
        let plain = dice.chance(0.8);
        Branch {
            name: self.scene.branches.len(),
            ends: [from, to],
            length,
            segments,
            rod: manner.rod.unwrap_or_else(|| dice.pick(&["cosserat", "kirchhoff"])),
            diameter,
            density: if dice.chance(0.2) { dice.decades(-4.0, -2.0) } else { dice.between(0.005, 0.3) },
            ea,
            ga: dice.chance(0.2).then(|| [ea * dice.decades(-1.0, 0.0), ea * dice.decades(-1.0, 0.0)]),
            ei: [ei, ei * uneven],
            gj: ei * dice.decades(-1.0, 0.3),
            curvature: if plain { Vector::zeros() } else { Vector::from_fn(|_, _| dice.between(-3.0, 3.0) / length) },
        }
    }

    /// A random tree.
    fn grow(&mut self) {
        let wanted = if self.dice.chance(0.3) { self.dice.0.usize(1..=2) } else { self.dice.0.usize(3..=10) };
        let mut open = vec![(0, None)];
        let mut joint_wanted = self.dice.chance(0.05).then(|| self.dice.0.usize(8..=16));
        while let Some((vertex, parent)) = open.pop() {
            let left = wanted.saturating_sub(self.scene.branches.len());
            let from_parent = usize::from(parent.is_some());
            let mut arms = match joint_wanted.take() {
                Some(arms) => arms,
                None if left == 0 => continue,
                None => self.dice.0.usize(2..=5).min(left + from_parent),
            };
            if arms < 2 {
                if parent.is_some() {
                    continue;
                }
                arms = 1;
            }
            if parent.is_none() && arms > 1 && self.dice.chance(0.5) {
                // Begin with an end.
                arms = 1;
            }
            let children = arms - from_parent;
            if children == 0 {
                continue;
            }
            let hub = arms > 1;
            let joint = hub.then(|| self.hub(vertex, parent, children));
            for k in 0..children {
                let next = self.poses.len();
                let length = self.dice.between(0.05, 0.6);
                let mut branch = self.branch(vertex, next, length);
                let away = self.dice.chance(0.5);
                // Frame of the branch where it leaves, d3 outwards.
                let start = match &joint {
                    Some(joint) => {
                        let arm = &joint.arms[from_parent + k];
                        self.poses[vertex].compose(&Pose { position: arm.offset, orientation: arm.orientation })
                    }
                    None => self.poses[vertex],
                };
                let end = start.compose(&laid(&branch.curvature, length));
                self.poses.push(end);
                self.reach.push(self.reach[vertex] + length);
                if !away {
                    // It runs towards the first vertex: the same curve, told from its other end.
                    branch.ends.swap(0, 1);
                    branch.curvature = Vector::new(-branch.curvature.x, branch.curvature.y, branch.curvature.z);
                    self.poses[next].orientation *= about_d1();
                    if joint.is_none() {
                        self.poses[vertex].orientation *= about_d1();
                    }
                }
                open.push((next, Some(branch.name)));
                self.scene.branches.push(branch);
            }
            if let Some(mut joint) = joint {
                // Frames of arms are so far those that lead outwards.
                for arm in &mut joint.arms {
                    let own = self.scene.branch(arm.branch);
                    let outwards = own.ends[0] == vertex;
                    let parent = Some(arm.branch) == parent;
                    if !parent && !outwards {
                        arm.orientation *= about_d1();
                    }
                }
                self.scene.joints.push(joint);
            }
            self.dice.0.shuffle(&mut open);
        }
    }

    /// A joint at the end of `parent`, with so many arms besides, which are named before they are there; all arms but
    /// that of the parent lead outwards with d3. Leaves the vertex' pose as that of the joint.
    fn hub(&mut self, vertex: usize, parent: Option<usize>, children: usize) -> Joint {
        let Self { dice, manner, scene, poses, .. } = self;
        let model = manner.model.unwrap_or_else(|| dice.pick(&["cosserat", "rigid-body", "fused"]));
        let mut arms: Vec<Arm> = Vec::new();
        let first = scene.branches.len();
        let straight = dice.chance(0.3);
        for branch in parent.into_iter().chain(first..first + children) {
            let offset = if model == "rigid-body" && dice.chance(0.5) {
                dice.direction() * dice.between(0.0, 0.02)
            } else {
                Vector::zeros()
            };
            // Often the first two arms run straight through.
            let orientation = match arms.first() {
                Some(other) if straight && arms.len() == 1 => {
                    let into = parent.is_some_and(|p| scene.branch(p).ends[1] == vertex);
                    other.orientation * if into { Rotation::identity() } else { about_d1() }
                }
                _ => dice.rotation(),
            };
            arms.push(Arm { branch, orientation, offset, spring: None });
        }
        if parent.is_some() {
            let arm = Pose { position: arms[0].offset, orientation: arms[0].orientation };
            poses[vertex] = poses[vertex].compose(&arm.inverse());
        }
        let wires = if model == "cosserat" && arms.len() > 2 && dice.chance(0.2) {
            let share = dice.between(0.05, 0.95);
            vec![(0, 1, share), (0, 2, 1.0 - share)]
        } else {
            Vec::new()
        };
        let mass = if dice.chance(0.2) { dice.decades(-3.0, 0.3) } else { 0.0 };
        Joint { vertex, model, mass, arms, wires }
    }

    /// Sometimes further branches join vertices that are there.
    fn close_loops(&mut self) {
        if self.scene.joints.is_empty() || self.poses.len() < 4 || !self.dice.chance(0.15) {
            return;
        }
        for _ in 0..self.dice.0.usize(1..=2) {
            let joined: Vec<usize> = self.scene.joints.iter().map(|j| j.vertex).collect();
            let a = self.dice.pick(&joined);
            let b = self.dice.0.usize(0..self.poses.len());
            let both = |branch: &Branch| branch.ends.contains(&a) && branch.ends.contains(&b);
            if a == b || self.scene.branches.iter().any(both) {
                continue;
            }
            let chord = (self.poses[b].position - self.poses[a].position).norm();
            let length = (chord * self.dice.between(0.9, 1.5)).max(0.05);
            let branch = self.branch(a, b, length);
            let name = branch.name;
            if self.scene.joint(b).is_none() {
                // A free end becomes a joint of two arms, its frame that of the branch that ends there.
                let other = self.scene.branches.iter().find(|other| other.ends.contains(&b)).expect("a branch").name;
                let model = self.dice.pick(&["cosserat", "rigid-body", "fused"]);
                let arm =
                    Arm { branch: other, orientation: Rotation::identity(), offset: Vector::zeros(), spring: None };
                self.scene.joints.push(Joint { vertex: b, model, mass: 0.0, arms: vec![arm], wires: Vec::new() });
            }
            for v in [a, b] {
                let orientation = self.dice.rotation();
                let joint = self.scene.joints.iter_mut().find(|j| j.vertex == v).expect("a joint");
                joint.arms.push(Arm { branch: name, orientation, offset: Vector::zeros(), spring: None });
            }
            self.scene.branches.push(branch);
        }
    }

    fn steps(&mut self) {
        let steps = if self.dice.chance(0.5) { 0 } else { self.dice.0.usize(1..=3) };
        for _ in 0..steps {
            let increments = self.dice.0.usize(1..=5);
            self.scene.steps.push(Step { increments, ..Step::default() });
        }
    }

    /// Constraints at ends, on branches and at joints, and how they move.
    fn fix(&mut self) {
        let mut ends: Vec<usize> = (0..self.poses.len()).filter(|v| self.scene.joint(*v).is_none()).collect();
        if ends.is_empty() {
            // Loops alone have joints only.
            ends.push(0);
        }
        let first = self.dice.pick(&ends);
        for &end in &ends {
            let kind = match () {
                // What a joint has no frame for.
                () if self.scene.joint(end).is_some() => 1,
                () if end == first => 0,
                () => self.dice.0.usize(0..4),
            };
            let from_step = (end != first && !self.scene.steps.is_empty() && self.dice.chance(0.15))
                .then(|| self.dice.0.usize(0..self.scene.steps.len()));
            let rest = self.poses[end];
            let span = self.reach[end] + self.reach[first];
            let off = if end == first || from_step.is_some() {
                Vector::zeros()
            } else if self.manner.mild {
                self.dice.direction() * (0.02 * span)
            } else if self.dice.chance(0.3) {
                // Anywhere that is not too far from the first one.
                let away = self.dice.direction() * (self.dice.between(0.1, 0.9) * span);
                self.poses[first].position + away - rest.position
            } else {
                self.dice.direction() * (self.dice.between(0.0, 0.4) * span)
            };
            let turn = if end == first {
                Rotation::identity()
            } else if self.manner.mild {
                Rotation::from_scaled_axis(self.dice.direction() * 0.1)
            } else {
                self.dice.rotation()
            };
            let name = self.scene.constraints.len();
            let mut constraint = Constraint {
                name,
                kind: "connector",
                at: Place::Vertex(end),
                position: Some(rest.position + off),
                facing: Facing::Frame(turn * rest.orientation),
                stiffness: None,
                slide: None,
                rail: None,
                free_axis: None,
                from_step,
            };
            match kind {
                0 => {}
                1 => (constraint.kind, constraint.facing) = ("handle", Facing::Open),
                2 => {
                    (constraint.kind, constraint.facing) = ("handle", Facing::Open);
                    constraint.stiffness = Some(self.dice.decades(0.0, 3.0));
                }
                _ => continue,
            }
            if from_step.is_some() {
                // It takes hold of the cable where it is.
                (constraint.position, constraint.facing) = (None, Facing::Open);
            } else if kind == 0 && end != first && self.dice.chance(0.1) {
                constraint.rail = Some(self.dice.direction());
            } else if kind == 0 && end != first && self.dice.chance(0.1) {
                constraint.free_axis = Some(self.dice.direction());
            }
            self.scene.constraints.push(constraint);
        }
        self.fix_branches();
        self.motions(first);
    }

    /// Collars, sleeves and rings.
    fn fix_branches(&mut self) {
        let count = if self.dice.chance(0.3) { self.dice.0.usize(1..=2) } else { 0 };
        for _ in 0..count {
            let branch = self.scene.branches[self.dice.0.usize(0..self.scene.branches.len())].clone();
            if branch.segments < 4
                || self.scene.constraints.iter().any(|f| matches!(f.at, Place::On(b, _) if b == branch.name))
            {
                continue;
            }
            let s = branch.length * self.dice.between(0.25, 0.75);
            let slides = self.dice.chance(0.5);
            let steps = self.scene.steps.len();
            let from_step = (!slides && steps > 0 && self.dice.chance(0.5)).then(|| self.dice.0.usize(0..steps));
            // About where the branch is at rest.
            let [a, b] = branch.ends.map(|v| self.poses[v].position);
            let place = a + (b - a) * (s / branch.length) + self.dice.direction() * (0.1 * branch.length);
            let tangent = ((b - a).normalize() + self.dice.direction() * 0.3).normalize();
            let collar = self.dice.chance(0.5);
            let friction = if self.dice.chance(0.5) { self.dice.between(0.0, 0.6) } else { 0.0 };
            let here = from_step.is_some();
            self.scene.constraints.push(Constraint {
                name: self.scene.constraints.len(),
                kind: if collar { "collar" } else { "handle" },
                at: Place::On(branch.name, s),
                position: (!here).then_some(place),
                facing: if collar && !here { Facing::Tangent(tangent) } else { Facing::Open },
                stiffness: None,
                slide: slides.then_some(friction),
                rail: None,
                free_axis: None,
                from_step,
            });
        }
    }

    fn motions(&mut self, first: usize) {
        for k in 0..self.scene.steps.len() {
            let acting: Vec<Constraint> =
                self.scene.constraints.iter().filter(|f| f.from_step.is_none_or(|s| s < k)).cloned().collect();
            let gone = |scene: &Scene, name: usize| scene.steps[..=k].iter().any(|s| s.release.contains(&name));
            for constraint in acting {
                if gone(&self.scene, constraint.name) || constraint.slide.is_some() {
                    continue;
                }
                let (Some(position), Place::Vertex(end)) = (constraint.position, constraint.at) else { continue };
                let span = self.reach[end].max(0.1);
                match self.dice.0.usize(0..6) {
                    0 => {
                        let far = if self.manner.mild { 0.02 } else { self.dice.between(0.0, 0.4) };
                        let position = position + self.dice.direction() * (far * span);
                        self.scene.steps[k].moves.push(Move {
                            constraint: constraint.name,
                            position: Some(position),
                            facing: Facing::Open,
                            turns: 0.0,
                        });
                    }
                    1 if constraint.kind == "connector" && constraint.free_axis.is_none() => {
                        let most = if self.manner.mild {
                            0.05
                        } else if self.dice.chance(0.3) {
                            5.0
                        } else {
                            0.5
                        };
                        let turns = self.dice.between(-most, most);
                        self.scene.steps[k].moves.push(Move {
                            constraint: constraint.name,
                            position: None,
                            facing: Facing::Open,
                            turns,
                        });
                    }
                    2 if end != first => self.scene.steps[k].release.push(constraint.name),
                    _ => {}
                }
            }
            if self.dice.chance(0.1) {
                self.scene.steps[k].gravity = Some(self.dice.direction() * self.manner.gravity.norm());
            }
        }
    }

    fn load(&mut self) {
        let count = if self.dice.chance(0.3) { self.dice.0.usize(1..=2) } else { 0 };
        let held: Vec<Place> = self.scene.constraints.iter().map(|f| f.at).collect();
        for name in 0..count {
            let branch = self.scene.branches[self.dice.0.usize(0..self.scene.branches.len())].clone();
            let at = match self.dice.0.usize(0..3) {
                0 => Place::On(branch.name, branch.length * self.dice.between(0.1, 0.9)),
                k => Place::Vertex(branch.ends[k - 1]),
            };
            let joint = matches!(at, Place::Vertex(v) if self.scene.joint(v).is_some());
            if held.contains(&at) || self.scene.loads.iter().any(|l| l.at == at) {
                continue;
            }
            let ei = branch.ei[0].max(branch.ei[1]);
            let strength = if self.manner.mild { 0.1 } else { self.dice.between(0.0, 4.0) };
            let weighs = branch.density * branch.length * self.manner.gravity.norm();
            let force =
                if self.manner.mild { ei / branch.length.powi(2) } else { weighs.max(ei / branch.length.powi(2)) };
            let moment = !joint && self.dice.chance(0.15);
            let load = Load {
                name,
                at,
                force: if moment { Vector::zeros() } else { self.dice.direction() * (strength * force) },
                moment: if moment { self.dice.direction() * (strength * ei / branch.length) } else { Vector::zeros() },
                factor: if self.scene.steps.is_empty() || self.dice.chance(0.5) { 1.0 } else { 0.0 },
            };
            if load.factor == 0.0 {
                let k = self.dice.0.usize(0..self.scene.steps.len());
                self.scene.steps[k].loads.push((name, 1.0));
            }
            self.scene.loads.push(load);
        }
    }

    /// A floor, or bodies, or cables that touch each other.
    fn obstruct(&mut self) {
        if self.manner.mild || !self.dice.chance(0.12) {
            return;
        }
        let friction = if self.dice.chance(0.6) { self.dice.between(0.05, 0.6) } else { 0.0 };
        let held: Vec<Vector> = self.scene.constraints.iter().filter_map(|f| f.position).collect();
        let moved = self.scene.steps.iter().flat_map(|s| &s.moves).filter_map(|m| m.position);
        let held: Vec<Vector> = held.into_iter().chain(moved).collect();
        let lowest = held.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
        let far = |x: &Vector| held.iter().map(|h| (h - x).norm()).fold(f64::INFINITY, f64::min);
        match self.dice.0.usize(0..10) {
            0..7 => {
                let position = Vector::new(0.0, 0.0, lowest - 0.02 - self.dice.between(0.0, 0.3));
                let shape = Shape::Plane;
                self.scene.obstacles.push(Obstacle { shape, position, orientation: Rotation::identity(), friction });
            }
            7..9 => {
                for _ in 0..2 {
                    let branch = &self.scene.branches[self.dice.0.usize(0..self.scene.branches.len())];
                    let [a, b] = branch.ends.map(|v| self.poses[v].position);
                    let position = (a + b) * 0.5 - Vector::z() * self.dice.between(0.05, 0.2);
                    let size = self.dice.between(0.01, 0.05);
                    let shape = match self.dice.0.usize(0..3) {
                        0 => Shape::Sphere(size),
                        1 => Shape::Box(Vector::new(size, 2.0 * size, size)),
                        _ => Shape::Cylinder(size, 4.0 * size),
                    };
                    if far(&position) > 4.0 * size + 0.02 {
                        let orientation = self.dice.rotation();
                        self.scene.obstacles.push(Obstacle { shape, position, orientation, friction });
                    }
                }
            }
            // Many cables that may touch take long.
            _ if self.scene.branches.len() <= 4 => self.scene.cables = Some(friction),
            _ => {}
        }
    }

    /// Makes everything so light that it bends little.
    fn make_mild(&mut self) {
        if !self.manner.mild {
            return;
        }
        let gravity = self.manner.gravity.norm();
        let total: f64 = self.scene.branches.iter().map(|b| b.length).sum();
        let softest = self.scene.branches.iter().flat_map(|b| b.ei).fold(f64::INFINITY, f64::min);
        if gravity > 0.0 {
            // Less than a twentieth of what the softest branch, as long as all of them, would bear.
            let most = 0.05 * softest / (gravity * total.powi(3));
            self.scene.branches.iter_mut().for_each(|b| b.density = b.density.min(most));
            self.scene.joints.iter_mut().for_each(|j| j.mass = j.mass.min(most * total));
        }
        let most = 0.05 * softest / total.powi(2);
        for load in &mut self.scene.loads {
            load.force *= (most / load.force.norm().max(most)).min(1.0);
            load.moment *= (most * total / load.moment.norm().max(most * total)).min(1.0);
        }
    }
}

/// Half of the rigid bodies become compliant hubs, whose springs are 1 to 1000 times as stiff as their arms. By numbers
/// of its own, so that the other harnesses of a seed stay as they are.
fn soften(scene: &mut Scene, seed: u64) {
    let mut dice = Dice(Rng::with_seed(!seed));
    for k in 0..scene.joints.len() {
        if scene.joints[k].model != "rigid-body" || dice.chance(0.5) {
            continue;
        }
        scene.joints[k].model = "compliant-hub";
        for a in 0..scene.joints[k].arms.len() {
            let own = scene.branch(scene.joints[k].arms[a].branch);
            let [ei1, ei2] = own.ei;
            let spring = [ei1, ei2, own.gj].map(|c| c / own.length * dice.decades(0.0, 3.0));
            scene.joints[k].arms[a].spring = Some(spring);
        }
    }
}

fn about_d1() -> Rotation {
    Rotation::from_axis_angle(&Vector::x_axis(), 0.5 * TAU)
}

/// Pose of the end of a branch at rest, relative to its start.
fn laid(curvature: &Vector, length: f64) -> Pose {
    const PARTS: usize = 64;
    let step = length / PARTS as f64;
    let mut pose = Pose::identity();
    for _ in 0..PARTS {
        let half = Rotation::from_scaled_axis(curvature * (0.5 * step));
        pose.position += (pose.orientation * half) * Vector::z() * step;
        pose.orientation *= half * half;
    }
    pose
}
