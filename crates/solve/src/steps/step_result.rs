//! Result of an increment.

use super::driver::Driver;
use crate::report::result;
use wireloom_core::equilibrium::{MinimiserResult, StepResult};
use wireloom_core::status::Status;
use wireloom_core::steps::Step;

impl Driver<'_, '_> {
    /// Result of an increment at the present state.
    pub(crate) fn step_result(&mut self, step: &Step, increment: usize, status: Status, seconds: f64) -> StepResult {
        // Stability is defined for an equilibrium; under dead moments only divergence can be detected.
        let known = status == Status::Converged && !self.problem.has_dead_moments();
        let inspect = || self.certifier.inspect(&mut self.problem, &self.state);
        let inspection = self.inspection.take().or_else(|| known.then(inspect));
        let stable = match status {
            Status::Converged if !known => self.certifier.diverges(&mut self.problem, &self.state).then_some(false),
            _ => inspection.filter(|_| known).and_then(|inspection| inspection.stability.flag()),
        };
        let (problem, state) = (&mut self.problem, &self.state);
        let network = problem.network;
        let touching = problem.touching_points(state);
        let branch = |b: usize| result::branch(problem, b, state, &touching);
        let branches: Vec<_> = (0..network.branches.len()).map(branch).collect();
        StepResult {
            name: step.name.clone(),
            increment,
            increments: step.increments,
            status,
            joints: network.joints.iter().map(|j| result::joint(problem, j, state, &touching)).collect(),
            constraints: result::constraints(problem, state, &self.certifier.gradient),
            obstacles: result::obstacles(problem, state),
            markers: result::markers(network, &branches),
            operations: self.operations.clone(),
            energy: problem.energy(state),
            min_bend_radius: result::tightest_bend(&branches),
            branches,
            stable,
            minimiser: MinimiserResult {
                kind: self.minimiser.name().to_owned(),
                device: self.minimiser.device(),
                iterations: self.iterations,
                polish: self.polish,
                factorisations: self.factorisations,
                seconds,
                force_residual: self.residual,
                shape_error: inspection.map(|inspection| inspection.move_left),
                constraint_residual: self.violation,
            },
        }
    }
}
