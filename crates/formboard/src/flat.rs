//! Joints laid flat, and the frames of branches on the board.

use crate::harness::{Harness, Joint, Ways};
use crate::line::Line;
use crate::{Rotation, Vector};
use nalgebra::{Matrix3, Rotation3, SymmetricEigen};

/// Weight of the reference direction relative to those of the arms in the choice of a joint's plane.
const REFERENCE: f64 = 0.05;

/// The plane in which a joint is laid flat.
pub(crate) struct Plane {
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

    /// A frame of the joint on the board, where its arm has this direction, rad. What stands out of the plane is tilted
    /// into it.
    fn laid(&self, drawn: &Rotation, direction: f64) -> Rotation {
        let turn = direction - self.angle(&(drawn * Vector::z()));
        let flat = Rotation3::from_axis_angle(&Vector::z_axis(), turn)
            * Rotation3::from_matrix_unchecked(self.axes.transpose());
        let frame = Rotation::from_rotation_matrix(&flat) * drawn;
        let along = Vector::new(direction.cos(), direction.sin(), 0.0);
        let tilt = Rotation::rotation_between(&(frame * Vector::z()), &along).unwrap_or_default();
        tilt * frame
    }
}

fn any_across(v: &Vector) -> Vector {
    let axis = if v.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
    v.cross(&axis).normalize()
}

/// Direction in which a branch leaves a joint.
fn outward(harness: &Harness, joint: &Joint, branch: usize, orientation: &Rotation) -> Vector {
    let d3 = orientation * Vector::z();
    if harness.branches[branch].ends[0] == joint.vertex { d3 } else { -d3 }
}

/// The plane of every joint, from the root outward: its normal is that of the joint before it, transported along the
/// branch without twist, so that the branch can lie flat without twist.
pub(crate) fn planes(harness: &Harness, ways: &Ways) -> Vec<Plane> {
    let joint_at = joints_at(harness);
    let orientation = |joint: usize, branch: usize| {
        harness.joints[joint].arms.iter().find(|arm| arm.branch == branch).map(|arm| arm.orientation)
    };
    let mut planes: Vec<Option<Plane>> = harness.joints.iter().map(|_| None).collect();
    for &vertex in &ways.order {
        let Some(index) = joint_at[vertex] else { continue };
        let joint = &harness.joints[index];
        let transported = ways.before[vertex].and_then(|(branch, before)| {
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

fn joints_at(harness: &Harness) -> Vec<Option<usize>> {
    let mut joint_at = vec![None; harness.vertices.len()];
    for (index, joint) in harness.joints.iter().enumerate() {
        joint_at[joint.vertex] = Some(index);
    }
    joint_at
}

/// Directions in which branches leave their ends in the planes of the joints there, rad; 0 at a free end.
pub(crate) fn leaves_at(harness: &Harness, planes: &[Plane]) -> Vec<[f64; 2]> {
    let mut leaves = vec![[0.0; 2]; harness.branches.len()];
    for (joint, plane) in harness.joints.iter().zip(planes) {
        for arm in &joint.arms {
            let end = usize::from(harness.branches[arm.branch].ends[0] != joint.vertex);
            leaves[arm.branch][end] = plane.angle(&outward(harness, joint, arm.branch, &arm.orientation));
        }
    }
    leaves
}

/// Frames of the branches at their first ends, and of the arms of every joint, on the board.
pub(crate) struct Frames {
    pub branches: Vec<Rotation>,
    pub arms: Vec<Vec<Rotation>>,
}

/// Frames on the board, d3 along the lines: every branch is turned as the joint at its inner end, whose plane becomes
/// that of the board, and follows its line without twist. At the outer end the joint takes the frame that the branch
/// has there, so nothing is twisted.
pub(crate) fn frames(harness: &Harness, ways: &Ways, planes: &[Plane], lines: &[Line], cut: &[usize]) -> Frames {
    let joint_at = joints_at(harness);
    let about_z = |angle: f64| Rotation::from_axis_angle(&Vector::z_axis(), angle);
    let bend = |branch: usize| lines[branch].curvature * lines[branch].length;
    // The frame of a branch at its first end, from the joint at one of its ends.
    let of_joint = |branch: usize, vertex: usize| -> Option<Rotation> {
        let index = joint_at[vertex]?;
        let arm = harness.joints[index].arms.iter().find(|arm| arm.branch == branch)?;
        let line = &lines[branch];
        if harness.branches[branch].ends[0] == vertex {
            return Some(planes[index].laid(&arm.orientation, line.direction));
        }
        Some(about_z(-bend(branch)) * planes[index].laid(&arm.orientation, line.direction_at(line.length)))
    };
    let mut inner: Vec<usize> = harness.branches.iter().map(|branch| branch.ends[0]).collect();
    for before in ways.before.iter().flatten() {
        inner[before.0] = before.1;
    }
    let branches: Vec<Rotation> = harness
        .branches
        .iter()
        .enumerate()
        .map(|(k, branch)| {
            let outer = if inner[k] == branch.ends[0] { branch.ends[1] } else { branch.ends[0] };
            // A branch that is cut at its second end belongs to its first one.
            let outer = Some(outer).filter(|_| !cut.contains(&k));
            let found = of_joint(k, inner[k]).or_else(|| of_joint(k, outer?));
            found.unwrap_or_else(|| about_z(lines[k].direction) * upright())
        })
        .collect();
    let arms = harness.joints.iter().zip(planes).map(|(joint, plane)| {
        let arm = |arm: &crate::Arm| {
            let (k, line) = (arm.branch, &lines[arm.branch]);
            let starts = harness.branches[k].ends[0] == joint.vertex;
            match (starts, cut.contains(&k)) {
                (true, _) => branches[k],
                (false, false) => about_z(bend(k)) * branches[k],
                // As drawn, beside the other arms: the end of the branch lies elsewhere.
                (false, true) => plane.laid(&arm.orientation, line.direction_at(line.length)),
            }
        };
        joint.arms.iter().map(arm).collect()
    });
    let arms = arms.collect();
    Frames { branches, arms }
}

/// The frame with d3 along x and d1 along z.
fn upright() -> Rotation {
    let columns = Matrix3::from_columns(&[Vector::z(), -Vector::y(), Vector::x()]);
    Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns))
}
