//! The minimisers side by side, on the same steps of the same cable to the same certificate.

use super::{Case, cable, hung, stroke};
use wireloom_core::registry::{Parameters, Value};
use wireloom_core::{Minimiser, Problem, Registry, Stop, Vector};
use wireloom_solve::minimisers::newton::Newton;

/// Segments of the cable.
const SEGMENTS: usize = 1_000;
/// Strokes, and steps each way, of a minimiser that has a metric, and of one that has none: that takes so long that two
/// must do.
const STROKES: [(usize, usize); 2] = [(10, 10), (1, 1)];

/// A minimiser and what a step costs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Contender {
    /// Kind of the minimiser.
    pub minimiser: &'static str,
    /// Its preconditioner, where it has a choice.
    pub preconditioner: Option<&'static str>,
    /// The steps.
    pub case: Case,
    /// Time relative to `newton`; a lower bound if it does not converge.
    pub times_newton: f64,
}

/// `newton`, and the methods that go by gradients with and without a preconditioner; steps are given up after so many
/// iterations.
///
/// # Panics
/// If a built-in minimiser is not there.
pub fn minimisers(registry: &Registry, max_iterations: usize) -> Vec<Contender> {
    let stop = Stop { force_tolerance: 1e-8, max_iterations };
    let network = cable(SEGMENTS);
    let (start, state) = hung(&network, &mut Newton::new(), &stop, Vector::new(-0.4, 0.0, 0.0));
    let drag = |minimiser: &mut dyn Minimiser, strokes| {
        let problem = Problem::new(&network, start.conditions().clone());
        stroke("minimisers", (problem, state.clone()), minimiser, &stop, 1, Vector::x(), strokes)
    };
    let mut all: Vec<Contender> = Vec::new();
    let kinds = [("newton", None)].into_iter();
    let others = ["lbfgs", "ncg"].into_iter().flat_map(|kind| [(kind, Some("hessian")), (kind, Some("none"))]);
    for (kind, preconditioner) in kinds.chain(others) {
        let chosen = preconditioner.map(|word| ("preconditioner".to_owned(), Value::Word(word.to_owned())));
        let mut minimiser = registry
            .minimiser(kind)
            .and_then(|found| (found.build)(&(), &Parameters(chosen.into_iter().collect())).ok());
        let minimiser = minimiser.as_mut().expect("a built-in kind").as_mut();
        let case = drag(minimiser, STROKES[usize::from(preconditioner == Some("none"))]);
        let newton = all.first().map_or(case.seconds_per_step, |newton| newton.case.seconds_per_step);
        let times_newton = case.seconds_per_step / newton;
        all.push(Contender { minimiser: kind, preconditioner, case, times_newton });
    }
    all
}
