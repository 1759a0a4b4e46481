//! Conformance suite of the minimiser `newton`, and tests of joints, the certificate and static condensation.

mod contact;
mod helpers;
mod matrix;

use helpers::{largest_free_force, perturbed, plan, registry};
use wireloom_core::conditions::Conditions;
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::network::Place;
use wireloom_core::status::Status;
use wireloom_core::{Problem, State, Tangent, Vector};
use wireloom_solve::contact::multipliers::update_constraints;
use wireloom_solve::minimisers::condensation::Condensation;
use wireloom_solve::minimisers::newton::Newton;
use wireloom_solve::report::branch;
use wireloom_solve::steps::certificate::Certifier;
use wireloom_testkit::conformance::networks::{Sample, cable, cut_cable, ring};
use wireloom_testkit::constraints::Link;
use wireloom_testkit::minimiser_conformance;

minimiser_conformance!(newton, || Box::new(Newton::new()), registry);

/// Equilibrium with the far end of the cable moved in, to the limit of round-off, and its energy (J).
fn hung(sample: &Sample) -> (State, f64) {
    let mut problem = sample.problem();
    let mut state = sample.state.clone();
    let mut newton = Newton::new();
    for x in [0.95, 0.9, 0.85, 0.8] {
        let mut target = sample.conditions.targets[1];
        target.position = Vector::new(x, 0.02, 0.05);
        problem.set_target(1, target);
        newton.minimise(&mut problem, &mut state, &Stop { force_tolerance: 1e-12, max_iterations: 100 });
    }
    let energy = problem.energy(&state).total();
    (state, energy)
}

/// Largest distance between the nodes of one branch and those of its two halves.
fn apart(whole: &Sample, a: &State, halves: &Sample, b: &State) -> f64 {
    let nodes = |sample: &Sample, state: &State| -> Vec<Vector> {
        let branches = &sample.network.branches;
        let skip = |i: usize| usize::from(i > 0);
        branches.iter().enumerate().flat_map(|(i, b)| state.points[b.points.clone()][skip(i)..].to_vec()).collect()
    };
    nodes(whole, a).iter().zip(&nodes(halves, b)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn a_two_arm_joint_with_all_wires_running_through_is_the_plain_rod() {
    let registry = registry();
    let (whole, halves) = (cable(&registry, 40), cut_cable(&registry, "cosserat", 40));
    let ((a, energy_a), (b, energy_b)) = (hung(&whole), hung(&halves));
    assert!((energy_a - energy_b).abs() <= 1e-12 * energy_a.abs(), "{energy_a:e} J and {energy_b:e} J");
    let apart = apart(&whole, &a, &halves, &b);
    assert!(apart <= 1e-12, "{apart:e} m apart");
}

#[test]
fn a_fused_two_arm_joint_changes_the_shape_to_second_order_only() {
    let registry = registry();
    let distances = [20, 40, 80].map(|n| {
        let (whole, halves) = (cable(&registry, n), cut_cable(&registry, "fused", n));
        apart(&whole, &hung(&whole).0, &halves, &hung(&halves).0)
    });
    assert!(distances[0] < 2e-3, "{distances:?}");
    for pair in distances.windows(2) {
        assert!(pair[1] < 0.4 * pair[0], "{distances:?}");
    }
}

#[test]
fn a_ring_is_the_same_wherever_a_through_joint_closes_it() {
    // The last side in one piece and in two, joined so that all wires run through.
    let registry = registry();
    let solved = [1, 2].map(|cut| {
        let sample = ring(&registry, "cosserat", 12, cut);
        let mut state = sample.state.clone();
        let stop = Stop { force_tolerance: 1e-9, max_iterations: 200 };
        let report = Newton::new().minimise(&mut sample.problem(), &mut state, &stop);
        assert_eq!(report.status, Status::Converged, "{report:?}");
        (sample, state)
    });
    for corner in 0..3 {
        let [one, two] = [0, 1].map(|k| solved[k].1.points[solved[k].0.network.joints[corner].point]);
        assert!((one - two).norm() < 1e-8, "corner {corner}: {one} and {two}");
    }
}

#[test]
fn a_false_claim_of_convergence_does_not_pass() {
    let sample = cable(&registry(), 20);
    let mut problem = sample.problem();
    let stop = Stop::default();
    let mut certifier = Certifier::new(&sample.network);
    let mut claim = |problem: &mut Problem<'_>, state: &State| {
        let certificate = certifier.certify(problem, state, &stop, Status::Converged);
        (certificate.grade, certificate.residual, certificate.violation)
    };
    // No force balances the weight of a straight cable.
    let (status, residual, violation) = claim(&mut problem, &sample.state);
    assert!(status == Status::Failed && residual > stop.force_tolerance && violation == 0.0, "{status:?} {residual:e}");
    let mut state = sample.state.clone();
    Newton::new().minimise(&mut problem, &mut state, &stop);
    assert_eq!(claim(&mut problem, &state).0, Status::Converged);
    // In balance, but off its target.
    let mut target = sample.conditions.targets[1];
    target.position.x += 1e-6;
    problem.set_target(1, target);
    let (status, residual, violation) = claim(&mut problem, &state);
    assert!(
        status == Status::Failed && residual <= stop.force_tolerance && violation > 5e-7,
        "{status:?} {residual:e}"
    );
    problem.set_target(1, sample.conditions.targets[1]);
    state.points[9].y = f64::NAN;
    assert_eq!(claim(&mut problem, &state).0, Status::Failed);
}

#[test]
fn condensed_points_are_in_balance_and_condensation_is_undone_exactly() {
    for kind in registry().joints() {
        let sample = ring(&registry(), &kind.name, 4, 1);
        let mut problem = sample.problem();
        let mut state = perturbed(&sample);
        problem.update_held(&state);
        problem.place_held(&mut state);
        let (before, mut gradient) = (state.clone(), Tangent::zeros(&sample.network));
        let energy = problem.gradient(&state, &mut gradient);
        let force = largest_free_force(&gradient, &problem);
        let mut condensation = Condensation::new(&problem);
        assert!(
            !condensation.condense(&mut problem, &mut state, &gradient, 2.0 * force),
            "{}: nothing to do",
            kind.name
        );
        assert!(condensation.condense(&mut problem, &mut state, &gradient, 0.0), "{}", kind.name);
        let condensed = problem.gradient(&state, &mut gradient);
        let rest = largest_free_force(&gradient, &problem);
        assert!(condensed < energy, "{}: {condensed} J after {energy} J", kind.name);
        assert!(rest < 1e-9 * force, "{}: {rest:e} N of {force:e} N are left", kind.name);
        assert_eq!(state.frames, before.frames);
        condensation.undo(&mut state);
        assert_eq!(state, before);
    }
}

/// Newton steps on a cable with a link between two of its nodes, after a small motion of its end: near the solution
/// each step squares the residual at fixed multipliers and penalty, and the next update of the multipliers satisfies
/// the link.
#[test]
fn newton_keeps_its_order_through_equations() {
    let mut sample = cable(&registry(), 60);
    let nodes = [15, 45].map(|node| Place::Node { branch: 0, node });
    sample.network.add_constraint(plan(Box::new(Link(0.35)), nodes.into(), None));
    sample.conditions = Conditions::new(&sample.network, Vector::new(0.0, 0.0, -9.81), &sample.state);
    let (mut problem, mut state, mut newton) = (sample.problem(), sample.state.clone(), Newton::new());
    let (stop, mut last) = (Stop { force_tolerance: 1e-10, max_iterations: 500 }, Vec::new());
    let violation = |problem: &Problem<'_>, state: &State| problem.worst_residual(state).expect("a link").violation;
    for x in [0.95, 0.9, 0.85, 0.8] {
        let mut target = problem.conditions().targets[1];
        target.position = Vector::new(x, 0.02, 0.05);
        problem.set_target(1, target);
        last.clear();
        for _ in 0..20 {
            newton.minimise(&mut problem, &mut state, &stop);
            update_constraints(&mut problem, &state, 1e-10, &mut last);
        }
        assert!(violation(&problem, &state) < 1e-10, "{:e}", violation(&problem, &state));
    }
    let mut target = problem.conditions().targets[1];
    target.position.x -= 0.002;
    problem.set_target(1, target);
    let one = Stop { force_tolerance: 0.0, max_iterations: 1 };
    let residuals: Vec<f64> = (0..8).map(|_| newton.minimise(&mut problem, &mut state, &one).residual).collect();
    let near = residuals.iter().position(|r| *r < 1e-2).expect("near the solution");
    let solved = residuals.iter().position(|r| *r < 1e-9).expect("solved");
    assert!(residuals[near + 1] <= residuals[near].powi(2) && solved - near <= 3, "{residuals:?}");
    update_constraints(&mut problem, &state, 1e-10, &mut last);
    newton.minimise(&mut problem, &mut state, &stop);
    assert!(violation(&problem, &state) < 1e-7, "{:e}", violation(&problem, &state));
}

#[test]
fn the_moment_at_a_clamped_end_is_the_reaction_of_the_clamp() {
    let sample = cable(&registry(), 20);
    let (state, _) = hung(&sample);
    let mut problem = sample.problem();
    problem.update_held(&state);
    let mut gradient = Tangent::zeros(&sample.network);
    problem.gradient(&state, &mut gradient);
    let branch = branch::result(&problem, 0, &state, &vec![false; sample.network.points]);
    for (constraint, inner) in [(0, -branch.moment[0]), (1, branch.moment[20])] {
        let reaction = problem.reaction(constraint, &state, &gradient).1;
        let off = (inner - reaction).norm();
        assert!(off <= 1e-9 * reaction.norm(), "clamp {constraint}: {inner} and {reaction}, N m");
    }
}
