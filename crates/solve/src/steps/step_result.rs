//! Result of an increment, and the check of the requirements at its end.

use super::driver::{Driver, is_balanced};
use crate::report::branch;
use crate::report::clearance::Cables;
use crate::report::deviation;
use crate::report::events;
use crate::report::requirements::Equilibrium;
use crate::report::result;
use crate::report::sheet::Here;
use crate::report::spans::Spans;
use crate::steps::certificate::Grade;
use crate::steps::stability::Inspection;
use wireloom_core::equilibrium::{
    BranchResult, ConstraintResult, MinimiserResult, OperationResult, RequirementResult, StepResult,
};
use wireloom_core::requirement::{Measure, Requirement, Verdict};
use wireloom_core::status::Status;
use wireloom_core::steps::Step;
use wireloom_core::{Moment, Problem, State, Tangent};

impl Driver<'_, '_> {
    /// Result of an increment at the present state.
    pub(crate) fn step_result(&mut self, step: &Step, increment: usize, grade: Grade, seconds: f64) -> StepResult {
        let status = grade.status();
        // Stability is defined for an equilibrium; without a potential it is no minimum, and only divergence can be
        // detected.
        let known = status == Status::Converged && self.problem.has_potential();
        let inspect = || self.certifier.inspect(&mut self.problem, &self.state);
        let inspection = self.inspection.take().or_else(|| known.then(inspect));
        let stable = match status {
            Status::Converged if !known => self.certifier.diverges(&mut self.problem, &self.state).then_some(false),
            _ => inspection.filter(|_| known).and_then(|inspection| inspection.stability.flag()),
        };
        let touching = self.problem.touching_points(&self.state);
        let mut branches = self.branch_results(inspection, &touching);
        let deviations = deviation::deviations(&self.problem, &branches);
        branches.iter_mut().zip(deviations).for_each(|(branch, deviation)| branch.deviation = deviation);
        let minimiser = MinimiserResult {
            kind: self.minimiser.name().to_owned(),
            device: self.minimiser.device(),
            iterations: self.iterations,
            polish: self.polish,
            factorisations: self.factorisations,
            seconds,
            force_residual: self.residual,
            shape_error: inspection.map(|inspection| inspection.move_left),
            constraint_residual: self.violation,
        };
        let (problem, state, gradient) = (&mut self.problem, &self.state, &self.certifier.gradient);
        StepResult {
            name: step.name.clone(),
            increment,
            increments: step.increments,
            status,
            operations: self.operations.clone(),
            violations: self.log.violations().to_vec(),
            stable,
            ..equilibrium(problem, state, gradient, branches, &touching, minimiser)
        }
    }

    /// Results of all branches at the present state, which was inspected so, and their errors; `touching` marks its
    /// points in contact.
    fn branch_results(&mut self, inspection: Option<Inspection>, touching: &[bool]) -> Vec<BranchResult> {
        let network = self.problem.network;
        let branch = |b: usize| branch::result(&self.problem, b, &self.state, touching);
        let mut branches = network.map(network.branches.len(), branch);
        let hessian = if self.problem.has_potential() { inspection.is_some() } else { !self.problem.has_slides() };
        self.errors = self.certifier.discretisation(&mut self.problem, &self.state, &branches, hessian);
        for (branch, errors) in branches.iter_mut().zip(&self.all_errors()) {
            branch.error = errors.largest(branch);
        }
        branches
    }

    /// Checks the requirements at the end of an increment, if that is an equilibrium; `ends_step`: whether it ends its
    /// step.
    pub(super) fn check_at_end(&mut self, end: &StepResult, (cables, spans): (&Cables<'_>, &Spans), ends_step: bool) {
        if is_balanced(end.status) {
            let results = (&end.branches[..], &end.constraints[..], &end.operations[..]);
            let here = match end.stable {
                Some(false) => Here::UnstableEnd,
                None if self.certifier.wanders(&self.state) => Here::WanderingEnd,
                _ => Here::End,
            };
            self.check(results, (cables, spans), (here, ends_step), |_| true);
        }
    }

    /// Checks the requirements at the initial equilibrium, and returns a sheet of it alone.
    pub(super) fn check_start(&mut self, end: &mut StepResult) -> Vec<RequirementResult> {
        let log = std::mem::take(&mut self.log);
        self.log.begin(Moment { step: end.name.clone(), step_index: 0, increment: 0 });
        self.began.copy_from(&self.state);
        let cables = Cables::new(self.problem.network, &end.branches);
        let spans = Spans::new(&self.problem, &self.state);
        self.check_at_end(end, (&cables, &spans), false);
        let start = std::mem::replace(&mut self.log, log);
        end.violations = start.violations().to_vec();
        start.sheet.lines(self.problem.network, end.status)
    }

    /// A remark if the initial equilibrium, before the first step, fails requirements: it is no increment, so that no
    /// verdict counts it.
    pub(super) fn start_note(&mut self) -> Option<String> {
        if self.problem.network.requirements.is_empty() {
            return None;
        }
        self.starting = true;
        let status = self.certify(Status::Stalled);
        let mut end = self.step_result(&Step::default(), 0, status, 0.0);
        let failed = self.check_start(&mut end).into_iter().filter(|own| own.verdict == Verdict::Fail);
        let failed: Vec<String> = failed.map(|own| format!("`{}` ({})", own.name, own.measure.word())).collect();
        self.starting = false;
        (!failed.is_empty()).then(|| {
            format!(
                "before the first step the harness fails {}; verdicts count the increments of steps only, so more \
                 increments, or the same scenario without steps, tell more",
                failed.join(", ")
            )
        })
    }

    /// Checks the requirements, and logs the limits that are broken, at an equilibrium on the way through an increment;
    /// with `distances_alone` only clearances and contact forces count. On the way to the initial equilibrium,
    /// increment 0, no state is one of the harness.
    pub(super) fn check_on_the_way(&mut self, distances_alone: bool) {
        let of_distance = |own: &Requirement| matches!(own.measure, Measure::Clearance | Measure::ContactForce);
        let counts = |own: &Requirement| !distances_alone || of_distance(own);
        let asked = self.all_clearances || self.problem.network.requirements.iter().any(counts);
        if self.log.now().increment > 0 && asked {
            let touching = self.problem.touching_points(&self.state);
            let inspect = self.problem.has_potential();
            let inspection = inspect.then(|| self.certifier.inspect(&mut self.problem, &self.state));
            let branches = self.branch_results(inspection, &touching);
            let constraints = result::constraints(&self.problem, &self.state, &self.certifier.gradient, &branches);
            let operations = self.operations.clone();
            let cables = Cables::new(self.problem.network, &branches);
            let spans = Spans::new(&self.problem, &self.state);
            let results = (&branches[..], &constraints[..], &operations[..]);
            self.check(results, (&cables, &spans), (Here::OnTheWay, false), counts);
            let (log, problem, all) = (&mut self.log, &self.problem, self.all_clearances);
            events::short_clearances(log, problem, &cables, all);
            if !distances_alone {
                events::bends(log, &branches);
                events::constraints(log, problem, &constraints);
            }
        }
    }

    /// Checks those requirements that count with these results; `ends_step`: whether the step ends here.
    fn check(
        &mut self,
        results: (&[BranchResult], &[ConstraintResult], &[OperationResult]),
        measured: (&Cables<'_>, &Spans),
        (here, ends_step): (Here, bool),
        counts: impl Fn(&Requirement) -> bool,
    ) {
        let requirements = &self.problem.network.requirements;
        let step = ((!self.starting).then(|| self.log.now().step_index), ends_step);
        let states = (&self.state, &self.began);
        let errors = self.all_errors();
        let found = (&errors[..], Some(&self.driven[..]));
        let equilibrium = Equilibrium::new(&mut self.problem, states, results, measured, found, step);
        let values = |own: &Requirement| if counts(own) { equilibrium.values(own) } else { Vec::new() };
        let found = requirements.iter().map(values).collect();
        self.log.check(requirements, found, here);
    }
}

/// What follows from the equilibrium `state` alone; `gradient` is the whole gradient there, `branches` are the results
/// of all branches, `touching` marks the points in contact, and `minimiser` found it. The rest is empty.
pub(super) fn equilibrium(
    problem: &mut Problem<'_>,
    state: &State,
    gradient: &Tangent,
    branches: Vec<BranchResult>,
    touching: &[bool],
    minimiser: MinimiserResult,
) -> StepResult {
    let network = problem.network;
    StepResult {
        name: String::new(),
        increment: 0,
        increments: 0,
        status: Status::Stalled,
        joints: (0..network.joints.len()).map(|j| result::joint(problem, j, state, touching)).collect(),
        constraints: result::constraints(problem, state, gradient, &branches),
        obstacles: result::obstacles(problem, state),
        mechanisms: result::mechanisms(problem),
        markers: result::markers(network, &branches),
        operations: Vec::new(),
        energy: problem.energy(state),
        min_bend_radius: result::tightest_bend(&branches),
        branches,
        violations: Vec::new(),
        stable: None,
        minimiser,
    }
}
