//! Reads written scenarios.

use wireloom_core::minimiser::{Minimiser, Report, Stop};
use wireloom_core::registry::MinimiserKind;
use wireloom_core::status::Status;
use wireloom_core::{Problem, Registry, State};
use wireloom_scenario::{Scenario, parse, render};

/// The minimiser that written scenarios name; it is never used.
struct Idle;

impl Minimiser for Idle {
    fn name(&self) -> &str {
        "newton"
    }
    fn minimise(&mut self, _: &mut Problem<'_>, _: &mut State, _: &Stop) -> Report {
        Report { residual: 0.0, ..Report::begun(Status::Failed) }
    }
    fn forget(&mut self) {}
}

/// A written scenario, checked: its sections have numbers.
pub fn checked(text: &str) -> Scenario {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    let build = Box::new(|(): &(), _: &wireloom_core::Parameters| Ok(Box::new(Idle) as Box<dyn Minimiser>));
    let newton = MinimiserKind { name: "newton".into(), doc: "none".into(), parameters: vec![], build };
    assert!(registry.add_minimiser(newton).is_ok());
    parse(text, &registry).unwrap_or_else(|faults| panic!("{}", render(text, &faults)))
}
