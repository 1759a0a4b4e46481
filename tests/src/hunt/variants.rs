//! The same harness said otherwise: turned, shifted, larger, with branches reversed, on another mesh, beside a
//! stranger. Their results must have the same shape.

use super::scene::{Arm, Branch, Constraint, Facing, Minimiser, Obstacle, Place, Scene, Shape, Step};
use std::f64::consts::PI;
use wireloom::geometry::{Rotation, Vector};

/// A scene that says the same as another one, and how its shape is taken back to that of the other.
pub struct Variant {
    /// Name of the change.
    pub what: &'static str,
    /// The scene.
    pub scene: Scene,
    /// World axes of the first one in the second one.
    pub turn: Rotation,
    /// Its origin, m of the second one.
    pub shift: Vector,
    /// Lengths of the second one per length of the first one.
    pub scale: f64,
    /// Names of branches that run the other way.
    pub reversed: Vec<usize>,
}

impl Variant {
    fn plain(what: &'static str, scene: Scene) -> Self {
        Self { what, scene, turn: Rotation::identity(), shift: Vector::zeros(), scale: 1.0, reversed: Vec::new() }
    }

    /// A point of the variant, where it is in the first one.
    pub fn back(&self, x: &Vector) -> Vector {
        self.turn.inverse() * (x - self.shift) / self.scale
    }
}

/// Turned and shifted.
pub fn moved(scene: &Scene, turn: Rotation, shift: Vector) -> Variant {
    let mut s = scene.clone();
    let point = |x: &Vector| turn * x + shift;
    s.gravity = turn * s.gravity;
    for constraint in &mut s.constraints {
        constraint.position = constraint.position.map(|x| point(&x));
        constraint.facing = turned(constraint.facing, &turn);
        constraint.rail = constraint.rail.map(|r| turn * r);
        constraint.free_axis = constraint.free_axis.map(|r| turn * r);
    }
    for load in &mut s.loads {
        load.force = turn * load.force;
        load.moment = turn * load.moment;
    }
    for Obstacle { position, orientation, .. } in &mut s.obstacles {
        *position = point(position);
        *orientation = turn * *orientation;
    }
    for step in &mut s.steps {
        step.gravity = step.gravity.map(|g| turn * g);
        for motion in &mut step.moves {
            motion.position = motion.position.map(|x| point(&x));
            motion.facing = turned(motion.facing, &turn);
        }
    }
    Variant { turn, shift, ..Variant::plain("turned and shifted", s) }
}

fn turned(facing: Facing, turn: &Rotation) -> Facing {
    match facing {
        Facing::Open => Facing::Open,
        Facing::Tangent(t) => Facing::Tangent(turn * t),
        Facing::Frame(q) => Facing::Frame(turn * q),
    }
}

/// Lengths times `k`, forces times `f`; gravity stays.
pub fn scaled(scene: &Scene, k: f64, f: f64) -> Variant {
    let mut s = scene.clone();
    for b in &mut s.branches {
        b.length *= k;
        b.diameter *= k;
        b.density *= f / k;
        b.ea *= f;
        b.ga = b.ga.map(|ga| ga.map(|x| x * f));
        b.ei = b.ei.map(|x| x * f * k * k);
        b.gj *= f * k * k;
        b.curvature /= k;
    }
    for joint in &mut s.joints {
        joint.mass *= f;
        for arm in &mut joint.arms {
            arm.offset *= k;
            arm.spring = arm.spring.map(|spring| spring.map(|c| c * f * k));
        }
    }
    for constraint in &mut s.constraints {
        constraint.position = constraint.position.map(|x| x * k);
        constraint.stiffness = constraint.stiffness.map(|c| c * f / k);
        constraint.at = larger(constraint.at, k);
    }
    for load in &mut s.loads {
        load.force *= f;
        load.moment *= f * k;
        load.at = larger(load.at, k);
    }
    for obstacle in &mut s.obstacles {
        obstacle.position *= k;
        obstacle.shape = match obstacle.shape {
            Shape::Plane => Shape::Plane,
            Shape::Sphere(r) => Shape::Sphere(r * k),
            Shape::Box(size) => Shape::Box(size * k),
            Shape::Cylinder(r, l) => Shape::Cylinder(r * k, l * k),
        };
    }
    for motion in s.steps.iter_mut().flat_map(|step| &mut step.moves) {
        motion.position = motion.position.map(|x| x * k);
    }
    Variant { scale: k, ..Variant::plain(if k > 1.0 { "larger" } else { "smaller" }, s) }
}

fn larger(place: Place, k: f64) -> Place {
    match place {
        Place::On(branch, s) => Place::On(branch, s * k),
        vertex => vertex,
    }
}

/// The branches of these names run from `to` to `from`. Frames turn by half a turn about d1, so that d3 points the
/// other way: with `F'(s) = F(L − s) X`, `X = diag(1, −1, −1)`, the rest curvature is `κ' = −X κ`.
pub fn reversed(scene: &Scene, names: Vec<usize>) -> Variant {
    let mut s = scene.clone();
    let about_d1 = Rotation::from_axis_angle(&Vector::x_axis(), PI);
    let is_reversed = |name: usize| names.contains(&name);
    let flipped = |facing: Facing| match facing {
        Facing::Open => Facing::Open,
        Facing::Tangent(t) => Facing::Tangent(-t),
        Facing::Frame(q) => Facing::Frame(q * about_d1),
    };
    // The branch whose frame a place has; a joint has its own.
    let owner = |place: Place| match place {
        Place::On(branch, _) => Some(branch),
        Place::Vertex(v) if scene.joint(v).is_some() => None,
        Place::Vertex(v) => scene.branches.iter().find(|b| b.ends.contains(&v)).map(|b| b.name),
    };
    let along = |place: Place| match place {
        Place::On(branch, s) if is_reversed(branch) => Place::On(branch, scene.branch(branch).length - s),
        place => place,
    };
    for b in s.branches.iter_mut().filter(|b| is_reversed(b.name)) {
        b.ends.swap(0, 1);
        b.curvature = Vector::new(-b.curvature.x, b.curvature.y, b.curvature.z);
    }
    for arm in s.joints.iter_mut().flat_map(|joint| &mut joint.arms).filter(|arm| is_reversed(arm.branch)) {
        arm.orientation *= about_d1;
    }
    let mut flips = Vec::new();
    for constraint in &mut s.constraints {
        if owner(constraint.at).is_some_and(is_reversed) {
            constraint.facing = flipped(constraint.facing);
            flips.push(constraint.name);
        }
        constraint.at = along(constraint.at);
    }
    for load in &mut s.loads {
        load.at = along(load.at);
    }
    for motion in s.steps.iter_mut().flat_map(|step| &mut step.moves).filter(|m| flips.contains(&m.constraint)) {
        motion.facing = flipped(motion.facing);
        motion.turns = -motion.turns;
    }
    Variant { reversed: names, ..Variant::plain("reversed", s) }
}

/// Every segment in so many parts.
pub fn refined(scene: &Scene, times: usize) -> Variant {
    let mut s = scene.clone();
    s.branches.iter_mut().for_each(|b| b.segments *= times);
    Variant::plain("finer", s)
}

/// Another minimiser.
pub fn minimised(scene: &Scene, minimiser: Minimiser) -> Variant {
    Variant::plain("another minimiser", Scene { minimiser: Some(minimiser), ..scene.clone() })
}

/// Beside it, joined to nothing and far away, stands a bar that is all but rigid.
pub fn with_stranger(scene: &Scene) -> Variant {
    let mut s = scene.clone();
    let name = 1 + s.branches.iter().map(|b| b.name).max().unwrap_or(0);
    let vertex = 1 + s.branches.iter().flat_map(|b| b.ends).max().unwrap_or(0);
    s.branches.push(Branch {
        name,
        ends: [vertex, vertex + 1],
        length: 1.0,
        segments: 4,
        rod: "cosserat",
        diameter: 0.01,
        density: 0.1,
        ea: 1e9,
        ga: None,
        ei: [1e6; 2],
        gj: 1e6,
        curvature: Vector::zeros(),
    });
    s.constraints.push(Constraint {
        name: 1 + s.constraints.iter().map(|f| f.name).max().unwrap_or(0),
        kind: "connector",
        at: Place::Vertex(vertex),
        position: Some(Vector::new(50.0, 50.0, 50.0)),
        facing: Facing::Frame(Rotation::identity()),
        stiffness: None,
        slide: None,
        rail: None,
        free_axis: None,
        from_step: None,
    });
    Variant::plain("beside a stranger", s)
}

/// Gravity at the end is disturbed by `share` of what counts, and then put right again: two more steps.
pub fn nudged(scene: &Scene, share: f64) -> Scene {
    let mut s = scene.clone();
    let end = s.gravity_at(Some(s.steps.len()));
    // Where nothing weighs anything, what bends the softest branch a little.
    let softest = |b: &Branch| b.ei[0].min(b.ei[1]) / (b.density * b.length.powi(3));
    let size = if end.norm() > 0.0 { end.norm() } else { s.branches.iter().map(softest).fold(f64::INFINITY, f64::min) };
    // A direction that nothing is along.
    let nudge = Vector::new(0.482, -0.611, 0.628) * (share * size);
    for gravity in [end + nudge, end] {
        s.steps.push(Step { increments: 1, gravity: Some(gravity), ..Step::default() });
    }
    s
}

/// An arm's place in the harness after a branch was dropped.
pub fn without_arm(arms: &[Arm], branch: usize) -> Vec<Arm> {
    arms.iter().filter(|arm| arm.branch != branch).cloned().collect()
}
