//! Errors of results that the division of time leaves, see `steps::time`.

use super::discretisation::NodalErrors;
use super::nodes::{curvatures, twists};
use serde::{Deserialize, Serialize};
use wireloom_core::Vector;
use wireloom_core::equilibrium::BranchResult;

/// Errors of the results of a branch that parts of time leave, the same at all its nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct TimeError {
    /// Of the curvature, 1/m.
    pub curvature: f64,
    /// Of the twist per length of the frames, 1/m.
    pub twist: f64,
    /// N.
    pub force: f64,
    /// N m.
    pub moment: f64,
    /// m.
    pub position: f64,
}

impl TimeError {
    /// Largest differences between two results of a branch.
    pub fn between(one: &BranchResult, other: &BranchResult) -> Self {
        let largest = |a: &[Vector], b: &[Vector]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let numbers = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        Self {
            curvature: numbers(&curvatures(one), &curvatures(other)),
            twist: numbers(&twists(one), &twists(other)),
            force: largest(&one.force, &other.force),
            moment: largest(&one.moment, &other.moment),
            position: largest(&one.position, &other.position),
        }
    }

    /// Adds other ones.
    pub fn add(&mut self, other: &Self) {
        self.curvature += other.curvature;
        self.twist += other.twist;
        self.force += other.force;
        self.moment += other.moment;
        self.position += other.position;
    }

    /// Adds these errors to those of the nodes.
    pub fn add_to(&self, errors: &mut NodalErrors) {
        let add = |all: &mut Vec<f64>, error: f64| all.iter_mut().for_each(|own| *own += error);
        add(&mut errors.curvature, self.curvature);
        add(&mut errors.torsion, self.twist);
        add(&mut errors.twist, self.twist);
        add(&mut errors.force, self.force);
        add(&mut errors.moment, self.moment);
        add(&mut errors.position, self.position);
    }
}
