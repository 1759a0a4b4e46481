//! Conformance suite of the gradient minimisers, as built by the registry, and comparisons between them.

use wireloom_core::minimiser::{Minimiser, Report, Stop};
use wireloom_core::status::Status;
use wireloom_core::{Parameters, Registry, State, Value, Vector};
use wireloom_testkit::conformance::networks::{Sample, cable};
use wireloom_testkit::minimiser_conformance;

fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    wireloom_solve::register(&mut registry);
    registry
}

/// A minimiser with these options.
fn minimiser(kind: &'static str, options: &[(&'static str, Value)]) -> impl Fn() -> Box<dyn Minimiser> {
    let options = Parameters(options.iter().map(|(key, value)| ((*key).into(), value.clone())).collect());
    let registry = registry();
    move || (registry.minimiser(kind).unwrap().build)(&(), &options).unwrap()
}

fn word(word: &str) -> Value {
    Value::Word(word.into())
}

minimiser_conformance!(lbfgs, minimiser("lbfgs", &[]), registry);
minimiser_conformance!(ncg, minimiser("ncg", &[]), registry);
minimiser_conformance!(polak_ribiere, minimiser("ncg", &[("formula", word("polak-ribiere"))]), registry);

// The methods without a metric find the same equilibria (below), but on the harnesses of the suite not always within
// its 100,000 iterations.

/// Equilibrium of the cable with its far end moved in and aside.
fn drawn_near(sample: &Sample, minimiser: &mut dyn Minimiser) -> (State, Report) {
    let mut problem = sample.problem();
    let mut target = sample.conditions.targets[1];
    target.position = Vector::new(0.9, 0.05, 0.1);
    problem.set_target(1, target);
    let mut state = sample.state.clone();
    let report = minimiser.minimise(&mut problem, &mut state, &Stop { force_tolerance: 1e-6, max_iterations: 100_000 });
    assert_eq!(report.status, Status::Converged, "{report:?}");
    (state, report)
}

#[test]
fn every_method_finds_the_equilibrium_of_newton() {
    let sample = cable(&registry(), 12);
    let (want, _) = drawn_near(&sample, minimiser("newton", &[])().as_mut());
    let methods = [
        ("lbfgs", vec![]),
        ("lbfgs", vec![("memory", Value::Count(1)), ("refresh", Value::Count(100))]),
        ("lbfgs", vec![("preconditioner", word("none"))]),
        ("lbfgs", vec![("preconditioner", word("none")), ("memory", Value::Count(3)), ("slope", Value::Number(0.3))]),
        ("ncg", vec![]),
        ("ncg", vec![("formula", word("polak-ribiere")), ("refresh", Value::Count(1))]),
        ("ncg", vec![("preconditioner", word("none")), ("formula", word("hager-zhang"))]),
        ("ncg", vec![("preconditioner", word("none")), ("formula", word("polak-ribiere"))]),
    ];
    for (kind, options) in methods {
        let (state, report) = drawn_near(&sample, minimiser(kind, &options)().as_mut());
        let apart = state.points.iter().zip(&want.points).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(apart < 1e-6, "{kind} {options:?}: {apart:e} m apart, {report:?}");
    }
}

/// Benefit of the metric: a few iterations instead of thousands, and several iterations per factorisation.
#[test]
fn the_metric_saves_iterations_and_a_factorisation_serves_several() {
    let sample = cable(&registry(), 12);
    for kind in ["lbfgs", "ncg"] {
        let (_, metric) = drawn_near(&sample, minimiser(kind, &[])().as_mut());
        let (_, none) = drawn_near(&sample, minimiser(kind, &[("preconditioner", word("none"))])().as_mut());
        assert!(30 * metric.iterations < none.iterations, "{kind}: {metric:?}, without {none:?}");
        assert_eq!(none.factorisations, 0, "{kind}");
        let (_, rarely) = drawn_near(&sample, minimiser(kind, &[("refresh", Value::Count(50))])().as_mut());
        let (_, always) = drawn_near(&sample, minimiser(kind, &[("refresh", Value::Count(1))])().as_mut());
        assert!(rarely.factorisations < always.factorisations, "{kind}: {rarely:?}, {always:?}");
        assert!(always.iterations < rarely.iterations, "{kind}: {rarely:?}, {always:?}");
    }
}
