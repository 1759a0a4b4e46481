//! What changes over a step, as functions of its progress.

use serde::{Deserialize, Serialize};
use wireloom_core::network::AttachedConstraint;
use wireloom_core::problem::Problem;
use wireloom_core::steps::{Course, Journey, Move, Operation, Step, Track, Turn};
use wireloom_core::{Pose, Vector};

/// Share of a part that is round-off.
const ROUND_OFF: f64 = 1e-6;

/// Everything that changes over a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Plan {
    journeys: Vec<Journey>,
    /// Obstacles that move, by index.
    obstacles: Vec<(usize, Course)>,
    /// Shares of the step at which something takes a turn.
    pub corners: Vec<f64>,
    /// What all this is for.
    pub operations: Vec<Operation>,
    gravity: (Vector, Vector),
    loads: Vec<(usize, f64, f64)>,
    /// The constraints that begin with the step.
    begun: Vec<usize>,
    /// Whether the drawn shape ceases to count as the rest shape.
    pub undraw: bool,
    /// Whether the dead moments come.
    pub take_up_moments: bool,
}

impl Plan {
    /// What a step changes from now on, with the journeys of its constraints.
    pub fn new(problem: &Problem<'_>, step: &Step, journeys: Vec<Journey>) -> Self {
        let now = problem.conditions();
        Self {
            journeys,
            obstacles: step
                .obstacle_moves
                .iter()
                .map(|m| (m.obstacle, m.track.from(&now.contact.poses[m.obstacle])))
                .collect(),
            corners: step.moves.iter().flat_map(Move::corners).collect(),
            operations: step.operations.clone(),
            gravity: (now.gravity, step.gravity.unwrap_or(now.gravity)),
            loads: step.loads.iter().map(|&(load, end)| (load, now.load_factors[load], end)).collect(),
            begun: Vec::new(),
            undraw: false,
            take_up_moments: false,
        }
    }

    /// The same, for a step in which these constraints begin.
    pub fn beginning(self, begun: Vec<usize>) -> Self {
        Self { begun, ..self }
    }

    /// Whether an obstacle moves.
    pub fn moves_obstacles(&self) -> bool {
        !self.obstacles.is_empty()
    }

    /// Whether gravity or loads change.
    pub fn changes_loads(&self) -> bool {
        self.gravity.0 != self.gravity.1 || !self.loads.is_empty()
    }

    /// Most turns that something makes about its tangent over a fraction of the step.
    pub fn turns(&self, fraction: f64) -> f64 {
        self.journeys.iter().map(|journey| journey.turns(fraction)).fold(0.0, f64::max)
    }

    /// Into how many parts a fraction of the step must be divided, so that nothing that goes round makes more than `most` turns in one of them, if all go
    /// evenly.
    pub fn parts(&self, a: f64, b: f64, most: f64) -> f64 {
        let spinning = self.journeys.iter().filter(|journey| journey.turns(1.0) > 0.0);
        let parts = |journey: &Journey| (journey.turned(a, b) / most - ROUND_OFF).ceil();
        spinning.map(parts).fold(1.0, f64::max)
    }

    /// Sets the conditions at fraction `t`.
    pub fn apply(&self, problem: &mut Problem<'_>, t: f64) {
        let mix = |a: f64, b: f64| if t >= 1.0 { b } else { a + (b - a) * t };
        if self.changes_loads() {
            problem.change(|c| {
                c.gravity = self.gravity.0.zip_map(&self.gravity.1, mix);
                for &(load, a, b) in &self.loads {
                    c.load_factors[load] = mix(a, b);
                }
            });
        }
        for &f in &self.begun {
            problem.set_progress(f, t);
        }
        for journey in &self.journeys {
            problem.set_target(journey.constraint(), journey.at(t));
        }
        for (obstacle, course) in &self.obstacles {
            problem.set_obstacle(*obstacle, course.at(t));
        }
        if self.undraw {
            problem.set_drawn_fraction(1.0 - t);
        }
        if self.take_up_moments {
            problem.set_moment_fraction(t);
        }
    }
}

/// The way of a constraint from where it is to the pose the scenario gives it.
pub(crate) fn home(f: usize, constraint: &AttachedConstraint, from: Pose) -> Journey {
    let turn = match (constraint.orientation, constraint.tangent) {
        (Some(q), _) => Some(Turn::Orientation(q)),
        (None, tangent) => tangent.map(Turn::Tangent),
    };
    let track = Track {
        positions: constraint.position.map(|position| (1.0, position)).into_iter().collect(),
        turns: turn.map(|turn| (1.0, turn)).into_iter().collect(),
        spin: 0.0,
    };
    Journey::of(f, &track, &from)
}
