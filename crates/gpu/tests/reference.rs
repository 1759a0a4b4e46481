//! The CPU reference of the stages against the problem, without a device: energy, forces and second derivatives are
//! those of [`wireloom_core::Problem`], and a minimiser made of the reference satisfies the contract of
//! [`wireloom_core::Minimiser`].

mod common;

use common::registry;
use fastrand::Rng;
use wireloom_core::joint::JointSpec;
use wireloom_core::minimiser::Report;
use wireloom_core::registry::{JointKind, Parameters, RodKind};
use wireloom_core::rod::RodSpec;
use wireloom_core::rotation::turned;
use wireloom_core::section::FrictionElement;
use wireloom_core::{Minimiser, Problem, Registry, State, Status, Stop, Tangent, Vector};
use wireloom_gpu::flatten::{Flattening, accepts};
use wireloom_shaders::harness::{self, Algorithm};
use wireloom_shaders::memory::Memory;
use wireloom_shaders::plan::Plan;
use wireloom_shaders::{Real, Stage, reference};
use wireloom_testkit::conformance::networks::{Sample, cable, ring, sized_y_harness, y_harness};

/// Friction within a section has no law on the GPU: left out there, a cable would spring back.
#[test]
fn what_slips_within_a_section_is_refused_by_name() {
    let plain = wireloom_models::rods::cosserat::kind();
    let build = move |spec: &RodSpec, values: &Parameters| {
        let mut spec = spec.clone();
        let slipping = FrictionElement { stiffness: 0.01, moment: 0.01 };
        spec.sections.iter_mut().for_each(|section| section.friction.torsion.push(slipping));
        (plain.build)(&spec, values)
    };
    let kind = RodKind { name: "cosserat".into(), doc: String::new(), parameters: vec![], build: Box::new(build) };
    let mut registry = Registry::default();
    assert!(
        registry.add_rod(kind).is_ok() && registry.add_constraint(wireloom_models::constraints::connector()).is_ok()
    );
    let refusal = accepts(&cable(&registry, 8).network).expect_err("it has friction");
    assert!(refusal.message.starts_with("what slips or yields in the section of branch `"), "{refusal:?}");
}

/// Nor has what slips between an arm and its hub.
#[test]
fn what_slips_at_an_arm_is_refused_by_the_name_of_its_joint() {
    let plain = wireloom_models::joints::compliant_hub::kind();
    let build = move |spec: &JointSpec, values: &Parameters| {
        let mut spec = spec.clone();
        spec.arms[1].spring.friction.torsion.push(FrictionElement { stiffness: 0.01, moment: 0.01 });
        (plain.build)(&spec, values)
    };
    let name = "compliant-hub".into();
    let kind = JointKind { name, doc: String::new(), parameters: vec![], build: Box::new(build) };
    let mut registry = Registry::default();
    assert!(registry.add_rod(wireloom_models::rods::cosserat::kind()).is_ok());
    assert!(registry.add_joint(kind).is_ok());
    assert!(registry.add_constraint(wireloom_models::constraints::connector()).is_ok());
    let refusal = accepts(&y_harness(&registry, "compliant-hub", 6).network).expect_err("it has friction");
    assert_eq!(refusal.message, "what slips at the arms of joint `joint 0` has no law on the GPU");
}

/// A station of the shaders has one frame: that of an arm cannot turn on a lever of its hub.
#[test]
fn a_compliant_hub_with_offsets_is_refused_by_name() {
    let refusal = accepts(&sized_y_harness(&registry(), "compliant-hub", 6, 0.02).network).expect_err("it has offsets");
    let says = "joint `joint 0` (compliant-hub), whose arms have offsets, has no law on the GPU";
    assert_eq!(refusal.message, says);
}

/// The reference as a minimiser.
struct ReferenceMinimiser {
    algorithm: Algorithm,
    leaf: usize,
}

impl Minimiser for ReferenceMinimiser {
    fn name(&self) -> &str {
        "reference"
    }

    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        problem.update_held(state);
        let flattening = Flattening::new(problem.network);
        let harness = flattening.harness(problem, state);
        let plan = Plan::new(harness.topology(), self.leaf);
        let mut memory = Memory::new(&plan, 1);
        memory.set_harness(&plan, 0, &harness).expect("its own links");
        memory.set_shape(&plan, 0, &flattening.shape(state));
        let scales = problem.least_scales();
        let own = harness::Stop {
            force_scale: scales.force,
            moment_scale: scales.moment,
            length_scale: scales.length,
            tolerance: stop.force_tolerance,
            max_iterations: stop.max_iterations as u32,
            algorithm: self.algorithm,
        };
        memory.begin(0, &own, Real::F64, harness.moves());
        reference::descend(&mut memory, &plan, 5000);
        flattening.write_back(&memory.shape(&plan, 0), problem.network, state);
        problem.place_held(state);
        let control = &memory.control[0];
        let status = match control.outcome {
            _ if problem.monitor.is_stopped() => Status::Interrupted,
            1 => Status::Converged,
            2 => Status::Stalled,
            3 => Status::IterationLimit,
            _ => Status::Failed,
        };
        Report {
            status,
            iterations: control.iterations as usize,
            polish: 0,
            factorisations: control.factorisations as usize,
            evaluations: control.evaluations as usize,
            residual: control.residual,
            convex: false,
        }
    }

    fn forget(&mut self) {}
}

fn minimiser(algorithm: Algorithm, leaf: usize) -> Box<dyn Minimiser> {
    Box::new(ReferenceMinimiser { algorithm, leaf })
}

wireloom_testkit::minimiser_conformance!(newton, || minimiser(Algorithm::Newton, 8), registry);
wireloom_testkit::minimiser_conformance!(newton_of_batches, || minimiser(Algorithm::Newton, usize::MAX), registry);
wireloom_testkit::minimiser_conformance!(gradient, || minimiser(Algorithm::Gradient, 8), registry);

/// Harnesses with all types of joints.
fn samples() -> Vec<(&'static str, Sample)> {
    let registry = registry();
    vec![
        ("a cable", cable(&registry, 12)),
        ("arms in a point", y_harness(&registry, "cosserat", 6)),
        ("a hub with offsets", sized_y_harness(&registry, "rigid-body", 6, 0.02)),
        ("a compliant hub", y_harness(&registry, "compliant-hub", 6)),
        ("a ring", ring(&registry, "fused", 9, 4)),
    ]
}

/// At states away from equilibrium.
#[test]
fn the_reference_computes_what_the_problem_does() {
    let mut rng = Rng::with_seed(5);
    for (name, sample) in samples() {
        for round in 0..3 {
            let mut problem = sample.problem();
            let mut state = sample.state.clone();
            let mut vector = |size: f64| Vector::from_fn(|_, _| size * (rng.f64() - 0.5));
            state.points.iter_mut().for_each(|x| *x += vector(4e-3));
            state.frames.iter_mut().for_each(|q| *q = turned(q, &vector(0.3 * f64::from(round))));
            sample.network.follow_ties(&mut state);
            problem.update_held(&state);
            problem.place_held(&mut state);
            problem.update_held(&state);
            let mut gradient = Tangent::zeros(&sample.network);
            let energy = problem.gradient(&state, &mut gradient);
            problem.free_part(&mut gradient);
            let flattening = Flattening::new(&sample.network);
            let harness = flattening.harness(&problem, &state);
            let plan = Plan::new(harness.topology(), 4);
            let mut memory = Memory::new(&plan, 1);
            memory.set_harness(&plan, 0, &harness).expect("its own links");
            memory.set_shape(&plan, 0, &flattening.shape(&state));
            let scales = problem.least_scales();
            let stop = harness::Stop {
                force_scale: scales.force,
                moment_scale: scales.moment,
                length_scale: scales.length,
                tolerance: 0.0,
                max_iterations: 9,
                algorithm: Algorithm::Newton,
            };
            memory.begin(0, &stop, Real::F64, harness.moves());
            for dispatch in plan.cycle() {
                reference::run(&mut memory, dispatch);
                if dispatch.stage == Stage::RecordTrial {
                    break;
                }
            }
            let control = &memory.control[0];
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-13 * a.abs().max(b.abs());
            assert!(near(control.trial_energy, energy), "{name}: {} J and {energy} J", control.trial_energy);
            let largest = |all: &[Vector]| all.iter().map(Vector::norm).fold(0.0, f64::max);
            let residual = (largest(&gradient.points) / scales.force).max(largest(&gradient.frames) / scales.moment);
            assert!(near(control.trial_residual, residual), "{name}: {} and {residual}", control.trial_residual);
        }
    }
}

/// Few iterations and residuals near round-off show that the second derivatives are those of the problem.
#[test]
fn equilibria_of_the_reference_are_those_of_the_problem() {
    let mut work = vec![];
    for (name, sample) in samples() {
        let mut problem = sample.problem();
        let mut state = sample.state.clone();
        let stop = Stop { force_tolerance: 1e-10, max_iterations: 100 };
        let mut minimiser = ReferenceMinimiser { algorithm: Algorithm::Newton, leaf: 4 };
        let report = minimiser.minimise(&mut problem, &mut state, &stop);
        let mut gradient = Tangent::zeros(&sample.network);
        problem.update_held(&state);
        problem.gradient(&state, &mut gradient);
        problem.free_part(&mut gradient);
        let residual = problem.residual(&gradient);
        assert!(report.status == Status::Converged && residual <= 1e-9, "{name}: {residual:e}, {report:?}");
        work.push(report.iterations);
    }
    assert_eq!(work, [6, 5, 6, 5, 36]);
}
