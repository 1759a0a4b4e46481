//! The largest reaction of each constraint and the tightest bend of each branch over all increments that ended in an
//! equilibrium, which are seldom those at the end.

use serde::{Deserialize, Serialize};
use wireloom::StepResult;
use wireloom::result::{BranchResult, ConstraintResult};

/// The largest force of a constraint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// The constraint.
    pub name: String,
    /// Its kind.
    pub kind: String,
    /// N.
    pub force: f64,
    /// The step in which it occurs.
    pub step: String,
}

/// The bend of a branch that is nearest to its limit; without one, the tightest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bend {
    /// The branch.
    pub name: String,
    /// Bend radius, m; infinite where the branch was always straight.
    pub radius: f64,
    /// Arc length, m.
    pub s: f64,
    /// The step in which it occurs.
    pub step: String,
    /// Smallest radius allowed, m.
    pub limit: Option<f64>,
}

impl Bend {
    /// Limit of the bend radius over the smallest one: above 1 the bend is too tight; 0 where there is no limit.
    pub fn use_of_limit(&self) -> f64 {
        self.limit.map_or(0.0, |limit| limit / self.radius)
    }
}

/// The extremes so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extremes {
    /// By constraint, in the order in which they begin to act.
    pub loads: Vec<Load>,
    /// By branch, in the order of the scenario.
    pub bends: Vec<Bend>,
}

impl Extremes {
    /// Takes one more increment into account, if it ended in an equilibrium.
    pub fn see(&mut self, end: &StepResult) {
        if !end.status.is_balanced() {
            return;
        }
        for constraint in &end.constraints {
            self.see_constraint(constraint, &end.name);
        }
        for (k, branch) in end.branches.iter().enumerate() {
            self.see_branch(k, branch, &end.name);
        }
    }

    fn see_constraint(&mut self, constraint: &ConstraintResult, step: &str) {
        let force = constraint.largest_force();
        match self.loads.iter_mut().find(|load| load.name == constraint.name) {
            Some(load) if force > load.force => (load.force, load.step) = (force, step.to_owned()),
            Some(_) => {}
            None => self.loads.push(Load {
                name: constraint.name.clone(),
                kind: constraint.kind.clone(),
                force,
                step: step.to_owned(),
            }),
        }
    }

    fn see_branch(&mut self, k: usize, branch: &BranchResult, step: &str) {
        if k == self.bends.len() {
            self.bends.push(Bend {
                name: branch.name.clone(),
                radius: f64::INFINITY,
                s: 0.0,
                step: step.to_owned(),
                limit: branch.bend_radius_limit,
            });
        }
        let bend = &mut self.bends[k];
        let known = wireloom::result::Bend { s: bend.s, radius: bend.radius, limit: bend.limit };
        let worst = branch.bends().min_by(wireloom::result::Bend::compare);
        if let Some(own) = worst.filter(|own| own.compare(&known).is_lt()) {
            (bend.radius, bend.s, bend.limit) = (own.radius, own.s, own.limit);
            step.clone_into(&mut bend.step);
        }
    }
}
