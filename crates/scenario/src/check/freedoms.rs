//! Refuses a harness with rigid motions that no constraint opposes.

use super::timeline::{Stage, stages};
use crate::attachment::At;
use crate::build::placement::{Placement, branch_of};
use crate::fault::{Fault, listed};
use crate::scenario::{Constraint as Given, Facing, Scenario};
use nalgebra::{Matrix6, SymmetricEigen, Vector6};
use wireloom_core::network::AttachedConstraint;
use wireloom_core::rotation::columns;
use wireloom_core::{
    Action, Constraint, ConstraintView, Equations, Matrix, Network, Pose, Potential, Relation, RotationHold, Vector,
};

/// Eigenvalues below this, for rows of unit length, belong to motions that nothing opposes.
const UNOPPOSED: f64 = 1e-12;

/// The unopposed rigid motions of each connected piece of the harness; for each piece only the first time.
pub(crate) fn refuse_unheld(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let (pieces, count) = network.pieces();
    let placement = Placement::new(scenario, &pieces);
    let mut poses: Vec<Pose> =
        scenario.constraints.iter().map(|constraint| placement.pose(constraint.place())).collect();
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
        let pieces = tied(scenario, &pieces, &stage);
        let apart = |piece: &usize| !refused[*piece] && pieces.contains(piece);
        for piece in (0..count).filter(apart).collect::<Vec<_>>() {
            let fault = refuse_piece(scenario, network, &pieces, piece, &stage, (&placement, &poses));
            refused[piece] = fault.is_some();
            faults.extend(fault);
        }
        for motion in stage.step.into_iter().flat_map(|step| &step.moves) {
            for journey in motion.journeys(|constraint| poses[constraint]) {
                poses[journey.constraint()] = journey.at(1.0);
            }
        }
    }
    faults
}

/// For each branch the number of its piece; pieces that a constraint ties together count as one.
fn tied(scenario: &Scenario, pieces: &[usize], stage: &Stage<'_>) -> Vec<usize> {
    let mut pieces = pieces.to_vec();
    for constraint in &stage.active {
        let mut on =
            scenario.constraints[*constraint].places().map(|at| pieces[branch_of(scenario, at)]).collect::<Vec<_>>();
        on.sort_unstable();
        on.dedup();
        if let [first, _, ..] = *on {
            pieces.iter_mut().filter(|piece| on.contains(piece)).for_each(|piece| *piece = first);
        }
    }
    pieces
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
    (placement, poses): (&Placement<'_>, &[Pose]),
) -> Option<Fault> {
    let branches: Vec<usize> = (0..pieces.len()).filter(|branch| pieces[*branch] == piece).collect();
    let size: f64 = branches.iter().map(|branch| scenario.branches[*branch].length).sum();
    let here = |at| pieces[branch_of(scenario, at)] == piece;
    let holding: Vec<usize> =
        stage.active.iter().copied().filter(|constraint| here(scenario.constraints[*constraint].place())).collect();
    let centre = holding.iter().map(|f| poses[*f].position).sum::<Vector>() / holding.len().max(1) as f64;
    let rows: Vec<Vector6<f64>> = holding
        .iter()
        .flat_map(|f| {
            let constraint = &network.constraints[*f];
            if constraint.stations.len() == 1 && constraint.residuals.is_empty() && constraint.span.is_none() {
                let local = Pose { position: (poses[*f].position - centre) / size, ..poses[*f] };
                return rows(constraint.model.as_ref(), &local);
            }
            rows_of_several(constraint, &scenario.constraints[*f], network, placement, (&centre, size))
        })
        .collect();
    let heavy = stage.gravity && has_mass(scenario, &branches);
    let loaded = heavy || stage.loads.iter().any(|load| scenario.loads[*load].places().any(here));
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
        "no force acts on it either: hold a tangent and the twist, for example with a connector, or give it gravity"
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
    branches
        .iter()
        .flat_map(|b| scenario.branches[*b].sections())
        .any(|own| scenario.sections[own].linear_density > 0.0)
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
            let mut table = [Matrix::zeros(); 4];
            let (poses, memory) = ([*pose], constraint.memory());
            let at = ConstraintView {
                stations: &poses,
                targets: &poses,
                span: &[],
                span_lengths: &[],
                progress: 0.0,
                memory: &memory,
                tensions: &[],
            };
            potential.hessian(&at, &mut table, &mut []);
            let axes = stiff(&table[3]).into_iter().map(|axis| pose.orientation * axis).collect();
            (stiff(&table[0]), axes)
        }
        Action::Equations(_) | Action::PotentialAndEquations(..) => (vec![], vec![]),
    };
    let of_point = directions.into_iter().map(|d| row(d, pose.position.cross(&d)));
    of_point.chain(axes.into_iter().map(|a| row(Vector::zeros(), a))).collect()
}

/// Rigid motions that a constraint of several stations, of a span, or of equations opposes: rows of unit length.
/// Pieces that are tied together move as one here, so only the resistance against motion relative to the world
/// counts.
fn rows_of_several(
    constraint: &AttachedConstraint,
    own: &Given,
    network: &Network,
    placement: &Placement<'_>,
    (centre, size): (&Vector, f64),
) -> Vec<Vector6<f64>> {
    let stations: Vec<Pose> = own.at.iter().map(|&at| placement.pose(at)).collect();
    let (mut span, mut lengths) = (Vec::new(), Vec::new());
    if let (Some(own), Some(span_of)) = (own.span, &constraint.span) {
        let lengths_of = &network.branches[own.branch].rod.mesh().rest_lengths;
        let first = span_of.points.start - network.branches[own.branch].points.start;
        let between = &lengths_of[first..first + span_of.points.len() - 1];
        let mut s = own.from;
        for node in 0..=between.len() {
            let (before, after) = (node.checked_sub(1).map_or(0.0, |j| between[j]), between.get(node).unwrap_or(&0.0));
            s += before;
            span.push(placement.pose(At::Branch { branch: own.branch, s }).position);
            lengths.push(0.5 * (before + after));
        }
    }
    let memory = constraint.model.memory();
    let at = ConstraintView {
        stations: &stations,
        targets: &stations,
        span: &span,
        span_lengths: &lengths,
        progress: 0.0,
        memory: &memory,
        tensions: &[],
    };
    let (m, n) = (stations.len(), span.len());
    // Motion of stations and nodes with (t, ω), lengths in units of `size`: δx = size (t + ω × r), θ = Rᵀ ω.
    let of_point = |x: &Vector, g: &Vector| -> Vector6<f64> {
        let w = ((x - centre) / size).cross(g) * size;
        Vector6::new(size * g.x, size * g.y, size * g.z, w.x, w.y, w.z)
    };
    let of_frame = |pose: &Pose, g: &Vector| -> Vector6<f64> {
        let w = pose.orientation * g;
        Vector6::new(0.0, 0.0, 0.0, w.x, w.y, w.z)
    };
    let of_all = |g: &[Vector]| -> Vector6<f64> {
        let of = |(pose, g): (&Pose, &[Vector])| of_point(&pose.position, &g[0]) + of_frame(pose, &g[1]);
        stations.iter().zip(g.chunks_exact(2)).map(of).sum()
    };
    let of_equations = |equations: &dyn Equations| -> Vec<Vector6<f64>> {
        let mut c = vec![0.0; constraint.residuals.len()];
        let mut of_stations = vec![Vector::zeros(); 2 * m * constraint.of_stations];
        let mut of_span = vec![Vector::zeros(); constraint.residuals.len() - constraint.of_stations];
        equations.jacobian(&at, &mut c, &mut of_stations, &mut of_span);
        let per_node = of_span.len() / n.max(1);
        let stations = of_stations.chunks_exact(2 * m.max(1)).map(of_all);
        let nodes = of_span.iter().enumerate().map(|(r, g)| of_point(&span[r / per_node], g));
        let all = stations.chain(nodes).zip(&constraint.residuals);
        // An inequality opposes motion to one side only.
        all.filter(|(_, residual)| residual.relation == Relation::Zero).map(|(row, _)| row).collect()
    };
    let of_potential = |potential: &dyn Potential| -> Vec<Vector6<f64>> {
        let (mut table, mut nodes) = (vec![Matrix::zeros(); 4 * m * m], vec![Matrix::zeros(); n]);
        potential.hessian(&at, &mut table, &mut nodes);
        // Columns of the stiffness against rigid motions, one motion after the other.
        let column = |k: usize| -> Vector6<f64> {
            let motion = Vector6::ith(k, 1.0);
            let (t, w) = (motion.fixed_rows::<3>(0).into_owned(), motion.fixed_rows::<3>(3).into_owned());
            let moved = |x: &Vector| size * (t + w.cross(&((x - centre) / size)));
            let motions: Vec<Vector> = stations
                .iter()
                .flat_map(|pose| [moved(&pose.position), pose.orientation.inverse_transform_vector(&w)])
                .collect();
            let forces: Vec<Vector> = table
                .chunks_exact(2 * m.max(1))
                .map(|row| row.iter().zip(&motions).map(|(block, motion)| block * motion).sum())
                .collect();
            of_all(&forces) + span.iter().zip(&nodes).map(|(x, h)| of_point(x, &(h * moved(x)))).sum::<Vector6<f64>>()
        };
        let stiffness = Matrix6::from_fn(|i, k| column(k)[i]);
        if !stiffness.iter().all(|x| x.is_finite()) {
            return vec![];
        }
        let modes = SymmetricEigen::new((stiffness + stiffness.transpose()) * 0.5);
        let opposed = |k: &usize| modes.eigenvalues[*k] > 1e-9 * modes.eigenvalues.amax();
        (0..6).filter(opposed).map(|k| modes.eigenvectors.column(k).into_owned()).collect()
    };
    let action = constraint.model.action();
    let rows = action.equations().map_or_else(Vec::new, of_equations).into_iter();
    let rows = rows.chain(action.potential().map_or_else(Vec::new, of_potential));
    rows.filter_map(|row| row.try_normalize(1e-9)).collect()
}

/// Directions in which a stiffness matrix opposes motion.
fn stiff(matrix: &Matrix) -> Vec<Vector> {
    eigen(matrix).into_iter().filter(|(value, _)| *value > 1e-9 * matrix.norm()).map(|(_, vector)| vector).collect()
}

/// Eigenvalues and eigenvectors of a symmetric matrix; empty if it is not finite.
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

/// The directions of a subspace in words: world axes by name if they span it.
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
