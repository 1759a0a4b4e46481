//! Refuses a harness that nothing holds: rigid motions that no constraint opposes.

use crate::fault::{Fault, listed};
use crate::placement::{Placement, branch_of};
use crate::scenario::{Facing, Scenario};
use crate::timeline::{Stage, stages};
use nalgebra::{Matrix6, SymmetricEigen, Vector6};
use wireloom_core::rotation::columns;
use wireloom_core::{Action, Constraint, Matrix, Network, Pose, RotationHold, Vector};

/// Eigenvalues below this, for rows of unit length, belong to motions that nothing opposes.
const UNOPPOSED: f64 = 1e-12;

/// What each connected piece of the harness can do although it should be held; for each piece the first time only.
pub(crate) fn refuse_unheld(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let (pieces, count) = network.pieces();
    let placement = Placement::new(scenario, &pieces);
    let mut poses: Vec<Pose> = scenario.constraints.iter().map(|constraint| placement.pose(constraint.at)).collect();
    for (pose, constraint) in poses.iter_mut().zip(&scenario.constraints) {
        pose.position = constraint.position.unwrap_or(pose.position);
        pose.orientation = match constraint.facing {
            Facing::Left => pose.orientation,
            Facing::Tangent(tangent) => turned_to(pose, &tangent),
            Facing::Orientation(orientation) => orientation,
        };
    }
    let mut faults = Vec::new();
    let mut refused = vec![false; count];
    for stage in stages(scenario) {
        for piece in (0..count).filter(|piece| !refused[*piece]).collect::<Vec<_>>() {
            let fault = refuse_piece(scenario, network, &pieces, piece, &stage, &poses);
            refused[piece] = fault.is_some();
            faults.extend(fault);
        }
        for motion in stage.step.into_iter().flat_map(|step| &step.moves) {
            for journey in motion.journeys(|fixing| poses[fixing]) {
                poses[journey.fixing()] = journey.at(1.0);
            }
        }
    }
    faults
}

fn turned_to(pose: &Pose, tangent: &Vector) -> wireloom_core::Rotation {
    wireloom_core::rotation::shortest(&columns(&pose.orientation)[2], tangent) * pose.orientation
}

fn refuse_piece(
    scenario: &Scenario,
    network: &Network,
    pieces: &[usize],
    piece: usize,
    stage: &Stage<'_>,
    poses: &[Pose],
) -> Option<Fault> {
    let branches: Vec<usize> = (0..pieces.len()).filter(|branch| pieces[*branch] == piece).collect();
    let size: f64 = branches.iter().map(|branch| scenario.branches[*branch].length).sum();
    let here = |at| pieces[branch_of(scenario, at)] == piece;
    let holding: Vec<usize> =
        stage.active.iter().copied().filter(|fixing| here(scenario.constraints[*fixing].at)).collect();
    let centre = holding.iter().map(|f| poses[*f].position).sum::<Vector>() / holding.len().max(1) as f64;
    let rows: Vec<Vector6<f64>> = holding
        .iter()
        .flat_map(|f| {
            let local = Pose { position: (poses[*f].position - centre) / size, ..poses[*f] };
            rows(network.fixings[*f].constraint.as_ref(), &local)
        })
        .collect();
    let heavy = stage.gravity && has_mass(scenario, &branches);
    let loaded = heavy || stage.loads.iter().any(|load| here(scenario.loads[*load].at));
    let (translations, rotations) = unopposed(&rows);
    let mut free = Vec::new();
    if !translations.is_empty() {
        free.push(format!("move along {}", named(&translations)));
    }
    if !loaded && !rotations.is_empty() {
        free.push(format!("turn about {}", named(&rotations)));
    }
    if free.is_empty() {
        return None;
    }
    let names: Vec<String> = branches.iter().map(|b| format!("\"{}\"", scenario.branches[*b].name)).collect();
    let (word, are) = if names.len() == 1 { ("branch", "is") } else { ("branches", "are") };
    let first = holding.first().map(|f| &scenario.constraints[*f].spans);
    let span =
        stage.span.clone().unwrap_or_else(|| first.unwrap_or(&scenario.branches[branches[0]].spans).entry.clone());
    let help = if translations.is_empty() {
        "nothing pulls on it either: hold a tangent and the twist, for example with a connector, or give it gravity"
    } else {
        "add a constraint that holds the position there, such as a connector at an end"
    };
    Some(Fault {
        span,
        message: format!("{word} {} {are} not held {}: free to {}", listed(&names), stage.label, free.join(" and to ")),
        help: help.to_owned(),
    })
}

fn has_mass(scenario: &Scenario, branches: &[usize]) -> bool {
    branches.iter().any(|b| scenario.sections[scenario.branches[*b].section].linear_density > 0.0)
        || scenario.joints.iter().any(|joint| joint.mass > 0.0 && branches.contains(&joint.arms[0].branch))
}

/// Rigid motions `(t, ω)` that a constraint opposes: rows `(d, r × d)` for its point, `(0, a)` for its frame.
fn rows(constraint: &dyn Constraint, pose: &Pose) -> Vec<Vector6<f64>> {
    let row = |t: Vector, w: Vector| Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z);
    let [d1, d2, d3] = columns(&pose.orientation);
    let (directions, axes) = match constraint.action() {
        Action::Prescribed(hold) => {
            let axes = match hold.rotation {
                RotationHold::Free => vec![],
                RotationHold::Tangent => vec![d1, d2],
                RotationHold::Twist => vec![d3],
                RotationHold::All => vec![d1, d2, d3],
                RotationHold::Hinge(axis) => {
                    let across = wireloom_core::rotation::orthogonal(&axis);
                    vec![across, axis.cross(&across)]
                }
            };
            (hold.held_directions(), axes)
        }
        Action::Potential(potential) => {
            let [points, _, frames] = potential.hessian(pose, pose);
            let axes = stiff(&frames).into_iter().map(|axis| pose.orientation * axis).collect();
            (stiff(&points), axes)
        }
    };
    let of_point = directions.into_iter().map(|d| row(d, pose.position.cross(&d)));
    of_point.chain(axes.into_iter().map(|a| row(Vector::zeros(), a))).collect()
}

/// Directions in which a stiffness matrix opposes motion.
fn stiff(matrix: &Matrix) -> Vec<Vector> {
    eigen(matrix).into_iter().filter(|(value, _)| *value > 1e-9 * matrix.norm()).map(|(_, vector)| vector).collect()
}

/// Eigenvalues and eigenvectors of a symmetric matrix; none where it is not finite.
fn eigen(matrix: &Matrix) -> Vec<(f64, Vector)> {
    if !matrix.iter().all(|x| x.is_finite()) {
        return Vec::new();
    }
    let eigen = matrix.symmetric_eigen();
    (0..3).map(|k| (eigen.eigenvalues[k], eigen.eigenvectors.column(k).into_owned())).collect()
}

/// Orthonormal bases of the translations, and of the axes of the rotations, that no row opposes.
fn unopposed(rows: &[Vector6<f64>]) -> (Vec<Vector>, Vec<Vector>) {
    let point = |row: &Vector6<f64>| Vector::new(row[0], row[1], row[2]);
    let frame = |row: &Vector6<f64>| Vector::new(row[3], row[4], row[5]);
    let translation: Matrix = rows.iter().map(|row| point(row) * point(row).transpose()).sum();
    let translations =
        eigen(&translation).into_iter().filter(|(value, _)| *value < UNOPPOSED).map(|(_, v)| v).collect();
    let all: Matrix6<f64> = rows.iter().map(|row| row * row.transpose()).sum();
    if !all.iter().all(|x| x.is_finite()) {
        return (translations, Vec::new());
    }
    let modes = SymmetricEigen::new(all);
    let axes: Matrix = (0..6)
        .filter(|k| modes.eigenvalues[*k] < UNOPPOSED)
        .map(|k| frame(&modes.eigenvectors.column(k).into_owned()))
        .map(|axis| axis * axis.transpose())
        .sum();
    let rotations = eigen(&axes).into_iter().filter(|(value, _)| *value > 1e-6).map(|(_, v)| v).collect();
    (translations, rotations)
}

/// The directions of a subspace in words: world axes by name where they span it.
fn named(basis: &[Vector]) -> String {
    let inside = |axis: &Vector| basis.iter().map(|b| b.dot(axis).powi(2)).sum::<f64>() > 1.0 - 1e-6;
    let axes: Vec<&str> = [("x", Vector::x()), ("y", Vector::y()), ("z", Vector::z())]
        .into_iter()
        .filter(|(_, axis)| inside(axis))
        .map(|(name, _)| name)
        .collect();
    match basis {
        _ if axes.len() == basis.len() => listed(&axes),
        [one] => written(one),
        [a, b, ..] => format!("anything across {}", written(&a.cross(b))),
        [] => String::new(),
    }
}

/// A direction with its largest component positive.
fn written(direction: &Vector) -> String {
    let v = direction * direction[direction.iamax()].signum();
    let [x, y, z] = [v.x, v.y, v.z].map(|c| if c.abs() < 5e-4 { 0.0 } else { c });
    format!("[{x:.3}, {y:.3}, {z:.3}]")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pins_leave_the_turn_about_their_line() {
        let pin = |r: Vector| {
            [Vector::x(), Vector::y(), Vector::z()].map(|d| {
                let w = r.cross(&d);
                Vector6::new(d.x, d.y, d.z, w.x, w.y, w.z)
            })
        };
        let rows = [pin(Vector::new(-0.5, 0.0, 0.0)), pin(Vector::new(0.5, 0.0, 0.0))].concat();
        let (translations, rotations) = unopposed(&rows);
        assert!(translations.is_empty());
        assert_eq!(named(&rotations), "x");
        assert_eq!(named(&unopposed(&[]).0), "x, y and z");
        assert_eq!(named(&unopposed(&rows[..3]).1), "x, y and z");
    }

    #[test]
    fn oblique_directions_are_written_out() {
        let oblique = Vector::new(1.0, -1.0, 0.0).normalize();
        assert_eq!(named(&[-oblique]), "[0.707, -0.707, 0.000]");
        assert_eq!(named(&[Vector::z(), oblique]), "anything across [0.707, 0.707, 0.000]");
    }
}
