//! Any rod with any joint and any minimiser: one small Y harness, all of them side by side.
//!
//! For one rod and one joint all minimisers must come to one equilibrium. Rods differ by what they are: `kirchhoff` by
//! the shear of `cosserat`, which is next to nothing here, and `mass-spring` by half a segment of softness wherever
//! something holds it, a few millimetres on 30 segments of 10 to 13 mm.

use wireloom::geometry::Vector;
use wireloom::{Run, Status, StepResult};

/// The Y of `scenarios/branches`, coarser, with other kinds in place of its own.
fn run(rod: &str, joint: &str, minimiser: &str) -> Run {
    let path = wireloom_tests::root().join("scenarios/branches/y_fused.toml");
    let text = std::fs::read_to_string(path).expect("a scenario of the repository");
    let text = text.replace("[[joints]]\n", "[[joints]]\nbending_stiffness = 0.3\ntorsion_stiffness = 0.15\n");
    let registry = wireloom::registry();
    let mut scenario = wireloom::scenario::parse(&text, &registry).expect("no faults");
    for branch in &mut scenario.branches {
        branch.rod = rod.into();
        branch.division = wireloom::scenario::Division::Segments(30);
    }
    scenario.joints.iter_mut().for_each(|at| at.model = joint.into());
    scenario.minimiser.kind = minimiser.into();
    scenario.minimiser.stop.force_tolerance = 1e-8;
    let built = scenario.build(&registry).expect("any rod goes with any joint");
    wireloom::run(built, &mut |_, _| wireloom::Control::Continue)
}

/// Largest distance between nodes at the ends of all steps, m.
fn apart(one: &Run, other: &Run) -> f64 {
    let nodes = |step: &StepResult| -> Vec<Vector> { step.branches.iter().flat_map(|b| b.position.clone()).collect() };
    let pairs = one.steps.iter().zip(&other.steps).flat_map(|(a, b)| nodes(a).into_iter().zip(nodes(b)));
    pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn converged(rod: &str, joint: &str, minimiser: &str) -> Run {
    let run = run(rod, joint, minimiser);
    assert_eq!(run.status(), Status::Converged, "{rod}, {joint}, {minimiser}: {:?}", run.notes);
    let name = |step: &StepResult| step.minimiser.kind == minimiser;
    assert!(run.steps.iter().all(name), "{minimiser} did the work");
    run
}

fn agree(joint: &str) {
    let found = ["cosserat", "kirchhoff", "mass-spring"].map(|rod| {
        let newton = converged(rod, joint, "newton");
        for minimiser in ["lbfgs", "ncg"] {
            let apart = apart(&newton, &converged(rod, joint, minimiser));
            assert!(apart < 1e-6, "{rod}, {joint}: {minimiser} and newton are {apart:e} m apart");
        }
        newton
    });
    let [cosserat, kirchhoff, springs] = &found;
    let shear = apart(cosserat, kirchhoff);
    assert!(shear > 1e-8 && shear < 1e-4, "{joint}: cosserat and kirchhoff are {shear:e} m apart");
    let soft = apart(kirchhoff, springs);
    assert!(soft > 1e-3 && soft < 2e-2, "{joint}: kirchhoff and mass-spring are {soft:e} m apart");
}

#[test]
fn rods_and_minimisers_at_a_cosserat_joint() {
    agree("cosserat");
}

#[test]
fn rods_and_minimisers_at_a_rigid_body() {
    agree("rigid-body");
}

#[test]
fn rods_and_minimisers_at_a_compliant_hub() {
    agree("compliant-hub");
}

#[test]
fn rods_and_minimisers_at_a_fused_joint() {
    agree("fused");
}
