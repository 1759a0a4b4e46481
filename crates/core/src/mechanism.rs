//! Mechanisms: bodies that joints connect with the ground and with each other, such as a door on its hinge, a bonnet on
//! four bars, or the arm of a robot.
//!
//! A mechanism is given as it is drawn: origins and axes of its joints in world coordinates, and the values of its
//! freedoms there. The pose of a body is that of its drawn axes, so the drawn mechanism has the identity for every
//! body. A joint between bodies a and b with the motion `M(q)` from its drawn values to q, in drawn coordinates, says
//! `B_b = B_a M(q)`. A spanning tree of joints gives the poses; every further joint closes a loop ([`closure`]).
//!
//! Nothing here is dynamic, and what is mounted on a body does not load it: the values of driven joints are prescribed,
//! those of the others in a loop follow from them.

pub mod closure;

use crate::rotation::skew;
use crate::{Matrix, Pose, Rotation, Vector};
use nalgebra::Unit;
use serde::{Deserialize, Serialize};

/// Index of the body that does not move.
pub const GROUND: usize = 0;
/// Smallest sine of the angle between the axes of a universal joint: nearer to parallel they are one axis.
const CROSSED: f64 = 1e-3;
/// Sine of the angle below which directions are parallel.
const PARALLEL: f64 = 1e-9;
/// Angle below which series replace quotients, rad.
const SMALL_ANGLE: f64 = 1e-4;

/// Kind of a joint, with the directions of its axes: unit vectors, as drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// No freedom.
    Fixed,
    /// Rotation about an axis, rad.
    Revolute(Unit<Vector>),
    /// Translation along an axis, m.
    Prismatic(Unit<Vector>),
    /// Rotation about an axis, rad, and translation along it, m.
    Cylindrical(Unit<Vector>),
    /// Rotation about an axis, rad, with a translation along it, m for each turn.
    Screw(Unit<Vector>, f64),
    /// Rotation about a first axis, then about a second one that turns with it, rad.
    Universal([Unit<Vector>; 2]),
    /// Any rotation about a point: a rotation vector, rad.
    Spherical,
    /// Translations along two directions that are at right angles, m, and rotation about the normal of both, rad.
    Planar([Unit<Vector>; 2]),
    /// Any translation, m, then a rotation vector, rad, both in these axes.
    Floating(Rotation),
}

impl JointKind {
    /// Number of its freedoms.
    pub fn freedoms(&self) -> usize {
        match self {
            JointKind::Fixed => 0,
            JointKind::Revolute(_) | JointKind::Prismatic(_) | JointKind::Screw(..) => 1,
            JointKind::Cylindrical(_) | JointKind::Universal(_) => 2,
            JointKind::Spherical | JointKind::Planar(_) => 3,
            JointKind::Floating(_) => 6,
        }
    }

    /// Whether a freedom is a length (m) and not an angle (rad).
    pub fn is_length(&self, freedom: usize) -> bool {
        match self {
            JointKind::Prismatic(_) => true,
            JointKind::Cylindrical(_) => freedom == 1,
            JointKind::Planar(_) => freedom < 2,
            JointKind::Floating(_) => freedom < 3,
            _ => false,
        }
    }
}

/// A joint of a mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismJoint {
    /// Name.
    pub name: String,
    /// Kind and axes.
    pub kind: JointKind,
    /// The bodies that it connects; its values are motions of the second relative to the first.
    pub bodies: [usize; 2],
    /// A point of the axis, or the centre, as drawn, m.
    pub origin: Vector,
    /// Values of its freedoms as drawn, rad and m.
    pub drawn: Vec<f64>,
    /// Smallest and largest value of each freedom; infinite where there is none.
    pub limits: Vec<[f64; 2]>,
    /// The joint whose changes it follows (by index), and the factor. Both have one freedom, and are in no loop.
    pub follows: Option<(usize, f64)>,
}

/// Body that something is mounted on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mount {
    /// Index of the mechanism.
    pub mechanism: usize,
    /// Index of the body.
    pub body: usize,
}

/// Velocity of a body when a value changes by 1 in a unit of time: `ω × (x − p) + v` at x.
#[derive(Clone, Copy, Debug)]
struct Twist {
    /// ω.
    turn: Vector,
    /// p, m.
    point: Vector,
    /// v.
    slide: Vector,
}

impl Twist {
    fn at(&self, x: &Vector) -> Vector {
        self.turn.cross(&(x - self.point)) + self.slide
    }

    /// The same of a body that has moved.
    fn moved(&self, by: &Pose) -> Self {
        Self { turn: by.orientation * self.turn, point: by.world(&self.point), slide: by.orientation * self.slide }
    }
}

impl MechanismJoint {
    /// `M(q)`: motion of the second body relative to the first, in drawn coordinates. As drawn the identity, to the
    /// bit.
    pub fn motion(&self, q: &[f64]) -> Pose {
        let about = |axis: &Unit<Vector>, angle: f64| self.about_origin(Rotation::from_axis_angle(axis, angle));
        let along = |way: Vector| Pose { position: way, ..Pose::identity() };
        let d = |f: usize| q[f] - self.drawn[f];
        match &self.kind {
            JointKind::Fixed => Pose::identity(),
            JointKind::Revolute(axis) => about(axis, d(0)),
            JointKind::Prismatic(axis) => along(**axis * d(0)),
            JointKind::Cylindrical(axis) => along(**axis * d(1)).compose(&about(axis, d(0))),
            JointKind::Screw(axis, pitch) => {
                along(**axis * (pitch * d(0) / std::f64::consts::TAU)).compose(&about(axis, d(0)))
            }
            JointKind::Universal([first, second]) => about(first, d(0)).compose(&about(second, d(1))),
            JointKind::Spherical => self.about_origin(from_to(&vector(&self.drawn), &vector(q))),
            JointKind::Planar([u, v]) => {
                let turn = Rotation::from_scaled_axis(u.cross(v) * d(2));
                along(**u * d(0) + **v * d(1)).compose(&self.about_origin(turn))
            }
            JointKind::Floating(axes) => {
                let turn = from_to(&(axes * vector(&self.drawn[3..])), &(axes * vector(&q[3..])));
                along(axes * Vector::new(d(0), d(1), d(2))).compose(&self.about_origin(turn))
            }
        }
    }

    fn about_origin(&self, turn: Rotation) -> Pose {
        if turn == Rotation::identity() {
            return Pose::identity();
        }
        Pose { position: self.origin - turn * self.origin, orientation: turn }
    }

    /// Velocities of the second body relative to the first, in drawn coordinates of the first, one for each freedom:
    /// `∂M/∂q M⁻¹`.
    fn twists(&self, q: &[f64]) -> Vec<Twist> {
        let turn = |axis: Vector| Twist { turn: axis, point: self.origin, slide: Vector::zeros() };
        let slide = |axis: Vector| Twist { turn: Vector::zeros(), point: self.origin, slide: axis };
        let d = |f: usize| q[f] - self.drawn[f];
        match &self.kind {
            JointKind::Fixed => Vec::new(),
            JointKind::Revolute(axis) => vec![turn(**axis)],
            JointKind::Prismatic(axis) => vec![slide(**axis)],
            JointKind::Cylindrical(axis) => vec![turn(**axis), slide(**axis)],
            JointKind::Screw(axis, pitch) => {
                vec![Twist { slide: **axis * (pitch / std::f64::consts::TAU), ..turn(**axis) }]
            }
            JointKind::Universal([first, second]) => {
                vec![turn(**first), turn(Rotation::from_axis_angle(first, d(0)) * **second)]
            }
            JointKind::Spherical => {
                let left = left_jacobian(&vector(q));
                left.column_iter().map(|column| turn(column.into_owned())).collect()
            }
            JointKind::Planar([u, v]) => {
                let point = self.origin + **u * d(0) + **v * d(1);
                vec![slide(**u), slide(**v), Twist { point, ..turn(u.cross(v)) }]
            }
            JointKind::Floating(axes) => {
                let point = self.origin + axes * Vector::new(d(0), d(1), d(2));
                let left = left_jacobian(&vector(&q[3..]));
                let slides = Matrix::identity().column_iter().map(|axis| slide(axes * axis)).collect::<Vec<_>>();
                let turns = left.column_iter().map(|axis| Twist { point, ..turn(axes * axis) });
                slides.into_iter().chain(turns).collect()
            }
        }
    }
}

/// The first three of some values.
fn vector(values: &[f64]) -> Vector {
    Vector::new(values[0], values[1], values[2])
}

/// Rotation that leads from that of one rotation vector to that of another, rad; the identity if they are equal, to the
/// bit.
fn from_to(from: &Vector, to: &Vector) -> Rotation {
    if from == to {
        return Rotation::identity();
    }
    Rotation::from_scaled_axis(*to) * Rotation::from_scaled_axis(*from).inverse()
}

/// Derivative of the rotation by a rotation vector φ, as an angular velocity:
/// `I + (1 − cos θ)/θ² [φ]ₓ + (θ − sin θ)/θ³ [φ]ₓ²`, θ = |φ| (Barfoot, State Estimation for Robotics, eq. 7.77).
fn left_jacobian(phi: &Vector) -> Matrix {
    let angle = phi.norm();
    let (a, b) = if angle < SMALL_ANGLE {
        (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0)
    } else {
        ((1.0 - angle.cos()) / (angle * angle), (angle - angle.sin()) / angle.powi(3))
    };
    let cross = skew(phi);
    Matrix::identity() + cross * a + cross * cross * b
}

/// Why bodies and joints make no mechanism.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MechanismFault {
    /// No chain of joints leads from the ground to a body (by index).
    #[error("no chain of joints connects body {0} with the ground")]
    Loose(usize),
    /// A joint (by index) connects a body with itself.
    #[error("joint {0} connects a body with itself")]
    Itself(usize),
    /// The axes of a universal joint (by index) are parallel.
    #[error("the axes of joint {0} are parallel")]
    Parallel(usize),
    /// A joint (by index) follows another one, and one of them has not one freedom, follows on, or is in a loop.
    #[error("joint {0} cannot follow another one")]
    Follows(usize),
}

/// Bodies and joints. See the [module](self).
#[derive(Clone, Debug, PartialEq)]
pub struct Mechanism {
    /// Name.
    pub name: String,
    /// Names of the bodies; the first is the ground.
    pub bodies: Vec<String>,
    /// The joints.
    pub joints: Vec<MechanismJoint>,
    /// First freedom of each joint; then the number of all.
    starts: Vec<usize>,
    /// Bodies from the ground outwards: body, the joint that leads to it, and whether it is the joint's second.
    tree: Vec<(usize, usize, bool)>,
    /// Joints that close a loop, each with the joints of that loop, itself included.
    loops: Vec<(usize, Vec<usize>)>,
}

impl Mechanism {
    /// A mechanism of these bodies, of which the first is the ground.
    ///
    /// # Errors
    /// If a body hangs on no joint, or a joint is none.
    pub fn new(name: String, bodies: Vec<String>, joints: Vec<MechanismJoint>) -> Result<Self, MechanismFault> {
        for (k, joint) in joints.iter().enumerate() {
            if joint.bodies[0] == joint.bodies[1] {
                return Err(MechanismFault::Itself(k));
            }
            if let JointKind::Universal([first, second]) = joint.kind
                && first.cross(&second).norm() < CROSSED
            {
                return Err(MechanismFault::Parallel(k));
            }
        }
        let mut starts = vec![0];
        starts.extend(joints.iter().scan(0, |sum, joint| {
            *sum += joint.kind.freedoms();
            Some(*sum)
        }));
        let mut tree: Vec<(usize, usize, bool)> = Vec::new();
        let mut reached = vec![false; bodies.len()];
        reached[GROUND] = true;
        let mut in_tree = vec![false; joints.len()];
        let mut leads = |joint: &MechanismJoint, k: usize| {
            let [a, b] = joint.bodies;
            if in_tree[k] || reached[a] == reached[b] {
                return None;
            }
            in_tree[k] = true;
            let to = if reached[a] { b } else { a };
            reached[to] = true;
            Some((to, k, to == b))
        };
        while let Some(next) = joints.iter().enumerate().find_map(|(k, joint)| leads(joint, k)) {
            tree.push(next);
        }
        if let Some(loose) = reached.iter().position(|reached| !reached) {
            return Err(MechanismFault::Loose(loose));
        }
        let mut new = Self { name, bodies, joints, starts, tree, loops: Vec::new() };
        let closing = (0..new.joints.len()).filter(|k| !in_tree[*k]);
        new.loops = closing.map(|k| (k, new.joints_of_loop(k))).collect();
        let free = |k: usize| new.joints[k].kind.freedoms() == 1 && new.loops.iter().all(|(_, all)| !all.contains(&k));
        let follows = |k: usize| {
            let (of, _) = new.joints[k].follows?;
            let leads = new.joints.get(of).is_some_and(|leader| leader.follows.is_none());
            (!(leads && free(of) && free(k))).then_some(k)
        };
        match (0..new.joints.len()).find_map(follows) {
            Some(k) => Err(MechanismFault::Follows(k)),
            None => Ok(new),
        }
    }

    /// Joints of the loop that a joint closes: those on the way from the ground to one of its bodies alone, and itself.
    fn joints_of_loop(&self, closing: usize) -> Vec<usize> {
        let [a, b] = self.joints[closing].bodies.map(|body| self.way_to(body));
        let alone = |of: &[usize], other: &[usize]| -> Vec<usize> {
            of.iter().copied().filter(|joint| !other.contains(joint)).collect()
        };
        let mut all = [alone(&a, &b), alone(&b, &a), vec![closing]].concat();
        all.sort_unstable();
        all
    }

    /// Joints of the tree from a body to the ground.
    fn way_to(&self, mut body: usize) -> Vec<usize> {
        let mut way = Vec::new();
        while let Some(&(_, joint, forward)) = self.tree.iter().find(|(to, ..)| *to == body) {
            way.push(joint);
            body = self.joints[joint].bodies[usize::from(!forward)];
        }
        way
    }

    /// Number of freedoms of all joints.
    pub fn freedoms(&self) -> usize {
        self.starts[self.joints.len()]
    }

    /// Values of all freedoms as drawn.
    pub fn drawn(&self) -> Vec<f64> {
        self.joints.iter().flat_map(|joint| joint.drawn.iter().copied()).collect()
    }

    /// Freedoms of a joint among those of all.
    pub fn freedoms_of(&self, joint: usize) -> std::ops::Range<usize> {
        self.starts[joint]..self.starts[joint + 1]
    }

    /// The joint of a freedom.
    pub fn joint_of(&self, freedom: usize) -> usize {
        self.starts.partition_point(|start| *start <= freedom) - 1
    }

    /// Whether a freedom is a length (m) and not an angle (rad).
    fn is_length(&self, freedom: usize) -> bool {
        let joint = self.joint_of(freedom);
        self.joints[joint].kind.is_length(freedom - self.starts[joint])
    }

    /// Poses of all bodies where the joints have these values: a point that is drawn at x on body b is at
    /// `poses[b]` applied to x.
    pub fn poses(&self, values: &[f64]) -> Vec<Pose> {
        let mut poses = vec![Pose::identity(); self.bodies.len()];
        for &(to, k, forward) in &self.tree {
            let motion = self.joints[k].motion(&values[self.freedoms_of(k)]);
            let [a, b] = self.joints[k].bodies;
            poses[to] = if forward { poses[a].compose(&motion) } else { poses[b].compose(&motion.inverse()) };
        }
        poses
    }

    /// Whether no joint between the ground and a body can turn a direction of the drawn mechanism.
    pub fn keeps(&self, body: usize, direction: &Vector) -> bool {
        let along = |axis: &Unit<Vector>| axis.cross(direction).norm() <= PARALLEL * direction.norm();
        self.way_to(body).into_iter().all(|joint| match &self.joints[joint].kind {
            JointKind::Fixed | JointKind::Prismatic(_) => true,
            JointKind::Revolute(axis) | JointKind::Cylindrical(axis) | JointKind::Screw(axis, _) => along(axis),
            JointKind::Planar([u, v]) => direction.dot(u).hypot(direction.dot(v)) <= PARALLEL * direction.norm(),
            JointKind::Universal(_) | JointKind::Spherical | JointKind::Floating(_) => false,
        })
    }

    /// Length of the mechanism: that of the box around the origins of its joints, m; 1 if there is none.
    fn size(&self) -> f64 {
        let origins = || self.joints.iter().map(|joint| joint.origin);
        let low = origins().fold(Vector::repeat(f64::INFINITY), |low, x| low.inf(&x));
        let high = origins().fold(Vector::repeat(f64::NEG_INFINITY), |high, x| high.sup(&x));
        let size = (high - low).norm();
        if size > 0.0 && size.is_finite() { size } else { 1.0 }
    }
}

#[cfg(test)]
mod tests;
