//! The harness flat on a formboard, held by pegs.

use super::curve::Vector;
use super::findings::Findings;
use super::harness::{Harness, Joint, Place};
use super::names::Names;
use super::tree::Tree;
use crate::layout::{Edge, Layout, Point, unfold};
use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion};

/// Distance, m, of the board below the lowest point of the installed harness.
const BELOW: f64 = 0.3;

/// Largest distance, m, between pegs along a branch: they alone keep the cable from sagging, as the board itself bears
/// nothing.
const PEG_SPACING: f64 = 0.4;

/// Stiffness of a peg, N/m: a fork of sheet metal or plastic. Between two rigid pegs a slightly bent bundle would have
/// kilonewtons.
const PEG_STIFFNESS: f64 = 2000.0;

/// Weight of the reference direction relative to those of the arms in the choice of a joint's plane.
const REFERENCE: f64 = 0.05;

/// The flat harness.
pub(super) struct Board {
    pub pegs: Vec<Peg>,
    /// Frame of every branch on the board: d3 `from → to`.
    pub frames: Vec<UnitQuaternion<f64>>,
    /// Positions of the vertices, m.
    pub points: Vec<Vector>,
}

/// Elastic support of a place of the harness on the board.
pub(super) struct Peg {
    pub name: String,
    pub at: Place,
    /// m.
    pub position: Vector,
}

impl Peg {
    /// N/m.
    pub const STIFFNESS: f64 = PEG_STIFFNESS;
}

/// The plane in which a joint is laid flat.
struct Plane {
    /// Right-handed: two directions in the plane, and its normal, which will point upwards from the board.
    axes: Matrix3<f64>,
}

impl Plane {
    /// The plane nearest to the directions d_i of the arms: the normal n minimises `Σ (n·d_i)² − ε (n·r)²`.
    /// The reference r decides which side is up, and the plane of two arms.
    fn new(directions: &[Vector], reference: &Vector) -> Self {
        let mut spread = -reference * reference.transpose() * REFERENCE;
        for d in directions {
            spread += d * d.transpose();
        }
        let eigen = SymmetricEigen::new(spread);
        let least = (0..3).min_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b])).unwrap_or(0);
        let normal: Vector = eigen.eigenvectors.column(least).into_owned();
        let normal = if normal.dot(reference) < 0.0 { -normal } else { normal };
        let first = directions[0].cross(&normal).try_normalize(1e-6).unwrap_or_else(|| any_across(&normal));
        Self { axes: Matrix3::from_columns(&[first, normal.cross(&first), normal]) }
    }

    fn normal(&self) -> Vector {
        self.axes.column(2).into_owned()
    }

    /// Direction of a vector in the plane, rad; that of a vector along the normal is 0.
    fn angle(&self, v: &Vector) -> f64 {
        let v = self.axes.transpose() * v;
        v.y.atan2(v.x)
    }
}

fn any_across(v: &Vector) -> Vector {
    let axis = if v.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
    v.cross(&axis).normalize()
}

/// The harness on the board: straight branches of true length in a horizontal plane below the vehicle, turned about
/// the vertical to be as near as possible to the installed harness. The arms of every joint keep their order, and
/// their angles if there is room.
pub(super) fn lay(harness: &Harness, tree: &Tree, findings: &mut Findings) -> Board {
    let planes = planes(harness, tree);
    let mut edges: Vec<Edge> = harness
        .branches
        .iter()
        .map(|branch| Edge { ends: branch.ends, length: branch.length, leaves_at: [0.0; 2] })
        .collect();
    for (joint, plane) in harness.joints.iter().zip(&planes) {
        for arm in &joint.arms {
            let end = usize::from(harness.branches[arm.branch].ends[0] != joint.vertex);
            edges[arm.branch].leaves_at[end] = plane.angle(&outward(harness, joint, arm.branch, &arm.orientation));
        }
    }
    let layout = unfold(harness.vertices.len(), &edges);
    note(harness, &layout, findings);
    let points = beside_the_vehicle(harness, tree, &layout.points);
    let frames = frames(harness, tree, &planes, &points);
    let pegs = pegs(harness, tree, &points);
    Board { pegs, frames, points }
}

/// Direction in which a branch leaves a joint.
fn outward(harness: &Harness, joint: &Joint, branch: usize, orientation: &UnitQuaternion<f64>) -> Vector {
    let d3 = orientation * Vector::z();
    if harness.branches[branch].ends[0] == joint.vertex { d3 } else { -d3 }
}

/// The plane of every joint, from the root outward: its normal is that of the joint before it, transported along the
/// branch without twist, so that the branch can lie flat without twist.
fn planes(harness: &Harness, tree: &Tree) -> Vec<Plane> {
    let mut joint_at = vec![None; harness.vertices.len()];
    for (index, joint) in harness.joints.iter().enumerate() {
        joint_at[joint.vertex] = Some(index);
    }
    let orientation = |joint: usize, branch: usize| {
        harness.joints[joint].arms.iter().find(|arm| arm.branch == branch).map(|arm| arm.orientation)
    };
    let mut planes: Vec<Option<Plane>> = harness.joints.iter().map(|_| None).collect();
    for &vertex in &tree.order {
        let Some(index) = joint_at[vertex] else { continue };
        let joint = &harness.joints[index];
        let transported = tree.parent[vertex].and_then(|(branch, before)| {
            let before = joint_at[before]?;
            let (from, to) = (orientation(before, branch)?, orientation(index, branch)?);
            Some(to * from.inverse() * planes[before].as_ref()?.normal())
        });
        let directions: Vec<Vector> =
            joint.arms.iter().map(|arm| outward(harness, joint, arm.branch, &arm.orientation)).collect();
        planes[index] = Some(Plane::new(&directions, &transported.unwrap_or_else(Vector::z)));
    }
    planes.into_iter().flatten().collect()
}

fn note(harness: &Harness, layout: &Layout, findings: &mut Findings) {
    let name = |branch: usize| format!("`{}`", harness.branches[branch].name);
    for &branch in &layout.closing {
        let [a, b] = harness.branches[branch].ends.map(|end| layout.points[end]);
        let ([apart, length], name) = ([(a - b).norm(), harness.branches[branch].length], name(branch));
        let what = if apart > length {
            "branches close loops and cannot lie flat with their lengths; they start overstretched from end to end"
        } else {
            "branches close loops; on the board they lie slack between their ends"
        };
        findings.add_to(what, format!("{name} ({:.0} mm over {:.0} mm)", length * 1e3, apart * 1e3));
    }
    for &[a, b] in &layout.crossings {
        findings.add_to("branches cross on the board", format!("{} and {}", name(a), name(b)));
    }
}

/// The flat points, rotated and moved in their plane to the least sum of squared horizontal distances from the
/// installed vertices (Kabsch 1976, in two dimensions: the angle is that of `Σ conj(p_i) q_i`), and `BELOW` the
/// lowest of these.
fn beside_the_vehicle(harness: &Harness, tree: &Tree, flat: &[Point]) -> Vec<Vector> {
    let count = tree.order.len().max(1) as f64;
    let installed = |vertex: usize| harness.vertices[vertex].position.xy();
    let centre = tree.order.iter().map(|&v| flat[v]).sum::<Point>() / count;
    let target = tree.order.iter().map(|&v| installed(v)).sum::<Point>() / count;
    let (mut cosine, mut sine) = (0.0, 0.0);
    for &v in &tree.order {
        let (p, q) = (flat[v] - centre, installed(v) - target);
        cosine += p.dot(&q);
        sine += p.perp(&q);
    }
    let turn = nalgebra::Rotation2::new(sine.atan2(cosine));
    let lowest = tree.order.iter().map(|&v| harness.vertices[v].position.z).fold(f64::INFINITY, f64::min);
    flat.iter()
        .map(|p| {
            let p = turn * (p - centre) + target;
            Vector::new(p.x, p.y, lowest - BELOW)
        })
        .collect()
}

/// Frames of the branches on the board: each is turned with its inner joint, whose plane becomes that of the board, and
/// then along the branch.
fn frames(harness: &Harness, tree: &Tree, planes: &[Plane], points: &[Vector]) -> Vec<UnitQuaternion<f64>> {
    let mut frames: Vec<UnitQuaternion<f64>> = harness
        .branches
        .iter()
        .map(|branch| {
            let along = points[branch.ends[1]] - points[branch.ends[0]];
            with_up(&along, &Vector::z())
        })
        .collect();
    // From the outermost joint inward, so that the inner joint of a branch decides.
    let mut joints: Vec<usize> = (0..harness.joints.len()).collect();
    joints.sort_by(|&a, &b| {
        let [a, b] = [a, b].map(|joint| tree.distance[harness.joints[joint].vertex]);
        b.total_cmp(&a)
    });
    for index in joints {
        let (joint, plane) = (&harness.joints[index], &planes[index]);
        for arm in &joint.arms {
            let branch = &harness.branches[arm.branch];
            let along = points[branch.ends[1]] - points[branch.ends[0]];
            let drawn = arm.orientation * Vector::z();
            let turn = along.y.atan2(along.x) - plane.angle(&drawn);
            let flat = Rotation3::from_axis_angle(&Vector::z_axis(), turn)
                * Rotation3::from_matrix_unchecked(plane.axes.transpose());
            let frame = UnitQuaternion::from_rotation_matrix(&flat) * arm.orientation;
            let tilt = UnitQuaternion::rotation_between(&(frame * Vector::z()), &along).unwrap_or_default();
            frames[arm.branch] = tilt * frame;
        }
    }
    frames
}

/// The frame with d3 along a vector and d1 as near to `up` as possible.
fn with_up(along: &Vector, up: &Vector) -> UnitQuaternion<f64> {
    let d3 = along.try_normalize(1e-12).unwrap_or_else(Vector::x);
    let d1 = (up - d3 * d3.dot(up)).try_normalize(1e-6).unwrap_or_else(|| any_across(&d3));
    let columns = Matrix3::from_columns(&[d1, d3.cross(&d1), d3]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns))
}

/// A peg at every vertex except the roots, at every clip, and between them if they are far apart.
fn pegs(harness: &Harness, tree: &Tree, points: &[Vector]) -> Vec<Peg> {
    let (mut pegs, mut names) = (Vec::new(), Names::default());
    let mut is_joint = vec![false; harness.vertices.len()];
    harness.joints.iter().for_each(|joint| is_joint[joint.vertex] = true);
    for &vertex in tree.order.iter().filter(|vertex| !tree.roots.contains(vertex)) {
        let at = if is_joint[vertex] { Place::Joint(vertex) } else { Place::End(vertex) };
        let name = names.unique(&format!("peg {}", harness.vertices[vertex].name));
        pegs.push(Peg { name, at, position: points[vertex] });
    }
    let mut clips: Vec<Vec<(&str, f64)>> = vec![Vec::new(); harness.branches.len()];
    for constraint in &harness.constraints {
        if let Place::Along { branch, s } = constraint.at {
            clips[branch].push((&constraint.name, s));
        }
    }
    for (index, (branch, clips)) in harness.branches.iter().zip(clips).enumerate() {
        let place = |s: f64| points[branch.ends[0]].lerp(&points[branch.ends[1]], s / branch.length);
        let mut held = vec![0.0, branch.length];
        for (name, s) in clips {
            let name = names.unique(&format!("peg {name}"));
            pegs.push(Peg { name, at: Place::Along { branch: index, s }, position: place(s) });
            held.push(s);
        }
        held.sort_by(f64::total_cmp);
        let mut count = 0;
        for span in held.windows(2) {
            let parts = ((span[1] - span[0]) / PEG_SPACING).ceil().max(1.0) as usize;
            for part in 1..parts {
                let s = span[0] + (span[1] - span[0]) * part as f64 / parts as f64;
                count += 1;
                let name = names.unique(&format!("peg {} {count}", branch.name));
                pegs.push(Peg { name, at: Place::Along { branch: index, s }, position: place(s) });
            }
        }
    }
    pegs
}
