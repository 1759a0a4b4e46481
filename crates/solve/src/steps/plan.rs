//! Plan of a step: its motions, loads, temperatures and time as functions of its progress.

use serde::{Deserialize, Serialize};
use wireloom_core::mechanism::Mount;
use wireloom_core::network::AttachedConstraint;
use wireloom_core::problem::Problem;
use wireloom_core::steps::{Course, Drive, Journey, Move, Operation, Step, Track, Turn};
use wireloom_core::{Network, Pose, Vector};

/// Fraction of a part that is round-off.
const ROUND_OFF: f64 = 1e-6;
/// Largest number of turns of an obstacle from one equilibrium to the next: what it meets on its way, and how it rubs
/// there, is taken from the poses at both ends.
const OBSTACLE_TURNS: f64 = 1.0 / 24.0;

/// Motions, loads and temperatures of a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Plan {
    /// Of constraints; where one is mounted on a body, in the axes of that.
    journeys: Vec<Journey>,
    drives: Vec<Drive>,
    /// Obstacles that move by themselves, by index.
    obstacles: Vec<(usize, Course)>,
    /// Fractions of the step at which a path has a corner.
    pub corners: Vec<f64>,
    /// Operations of the step.
    pub operations: Vec<Operation>,
    gravity: (Vector, Vector),
    angular_velocity: (Vector, Vector),
    loads: Vec<(usize, f64, f64)>,
    temperatures: Vec<(usize, f64, f64)>,
    /// Time of the run at its beginning and at its end, s.
    time: (f64, f64),
    /// Constraints that begin with the step.
    begun: Vec<usize>,
    /// Whether the drawn shape is released from being the rest shape.
    pub release_drawn_shape: bool,
    /// Whether the loads without a potential are applied.
    pub apply_without_potential: bool,
}

impl Plan {
    /// Plan of a step from the present conditions. `added`: constraints that begin to act now.
    pub fn of_step(problem: &Problem<'_>, step: &Step, added: &[usize]) -> Self {
        let (network, now) = (problem.network, problem.conditions());
        let own =
            |f: usize| now.body(network, network.constraints[f].mount).inverse().compose(&now.constraints[f].base);
        let mut journeys: Vec<Journey> = step.moves.iter().flat_map(|m| m.journeys(own)).collect();
        for (f, constraint) in network.constraints.iter().enumerate() {
            if journeys.iter().any(|journey| journey.constraint() == f) {
                continue;
            }
            if added.contains(&f) {
                journeys.push(journey_to_target(f, constraint, own(f)));
            } else if now.active[f] && drives(&step.drives, constraint.mount) {
                journeys.push(Journey::of(f, &Track::default(), &own(f)));
            }
        }
        Self { drives: step.drives.clone(), ..Self::new(problem, step, journeys) }
    }

    /// Plan of what a step changes besides its constraints and mechanisms, with these journeys of constraints.
    pub fn new(problem: &Problem<'_>, step: &Step, journeys: Vec<Journey>) -> Self {
        let now = problem.conditions();
        let driven = step.drives.iter().flat_map(|drive| drive.way.corners().iter().copied());
        Self {
            journeys,
            drives: Vec::new(),
            obstacles: step
                .obstacle_moves
                .iter()
                .map(|m| (m.obstacle, m.track.from(&now.contact.poses[m.obstacle])))
                .collect(),
            corners: step.moves.iter().flat_map(Move::corners).chain(driven).collect(),
            operations: step.operations.clone(),
            gravity: (now.gravity, step.gravity.unwrap_or(now.gravity)),
            angular_velocity: (now.rotation.velocity, step.angular_velocity.unwrap_or(now.rotation.velocity)),
            loads: step.loads.iter().map(|&(load, end)| (load, now.load_factors[load], end)).collect(),
            temperatures: step.temperatures.iter().map(|&(b, end)| (b, now.temperatures[b], end)).collect(),
            time: (now.time, now.time + step.duration),
            begun: Vec::new(),
            release_drawn_shape: false,
            apply_without_potential: false,
        }
    }

    /// The plan, with these constraints beginning in the step.
    pub fn beginning(self, begun: Vec<usize>) -> Self {
        Self { begun, ..self }
    }

    /// Fractions of the step at which the way of an obstacle that moves by itself has a corner.
    pub fn obstacle_corners(&self) -> impl Iterator<Item = f64> {
        self.obstacles.iter().flat_map(|(_, course)| course.corners())
    }

    /// Whether an obstacle moves.
    pub fn moves_obstacles(&self, network: &Network) -> bool {
        !self.obstacles.is_empty() || network.obstacles.iter().any(|obstacle| drives(&self.drives, obstacle.mount))
    }

    /// Whether gravity, rotation, loads or temperatures change, or time passes.
    pub fn changes_loads(&self) -> bool {
        self.gravity.0 != self.gravity.1
            || self.angular_velocity.0 != self.angular_velocity.1
            || !self.loads.is_empty()
            || !self.temperatures.is_empty()
            || self.takes_time()
    }

    /// Whether time passes.
    pub fn takes_time(&self) -> bool {
        self.time.0 != self.time.1
    }

    /// Largest number of turns that a constraint makes about its tangent over a fraction of the step.
    pub fn turns(&self, fraction: f64) -> f64 {
        self.journeys.iter().map(|journey| journey.turns(fraction)).fold(0.0, f64::max)
    }

    /// Number of equal parts of the interval from `a` to `b` of the step in which no constraint and no body makes more
    /// than `most` turns, and no obstacle goes on with more than [`OBSTACLE_TURNS`], if all turn uniformly.
    pub fn parts(&self, network: &Network, a: f64, b: f64, most: f64) -> f64 {
        let spinning = self.journeys.iter().filter(|journey| journey.turns(1.0) > 0.0);
        let turned = spinning.map(|journey| journey.turned(a, b) / most);
        let carries = |mechanism: usize| {
            network.obstacles.iter().any(|obstacle| obstacle.mount.is_some_and(|mount| mount.mechanism == mechanism))
        };
        let driven = self.drives.iter().map(|Drive { mechanism, way }| {
            let turns = network.mechanisms[*mechanism].turned(way, a, b);
            turns / if carries(*mechanism) { OBSTACLE_TURNS } else { most }
        });
        let obstacles = self.obstacles.iter().map(|(_, course)| course.turned(a, b) / OBSTACLE_TURNS);
        turned.chain(driven).chain(obstacles).map(|parts| (parts - ROUND_OFF).ceil()).fold(1.0, f64::max)
    }

    /// Sets the conditions at fraction `t`.
    pub fn apply(&self, problem: &mut Problem<'_>, t: f64) {
        let mix = |a: f64, b: f64| if t >= 1.0 { b } else { a + (b - a) * t };
        if self.changes_loads() {
            problem.change(|c| {
                c.gravity = self.gravity.0.zip_map(&self.gravity.1, mix);
                c.rotation.velocity = self.angular_velocity.0.zip_map(&self.angular_velocity.1, mix);
                for &(load, a, b) in &self.loads {
                    c.load_factors[load] = mix(a, b);
                }
                for &(branch, a, b) in &self.temperatures {
                    c.temperatures[branch] = mix(a, b);
                }
                c.time = mix(self.time.0, self.time.1);
            });
        }
        for &f in &self.begun {
            problem.set_progress(f, t);
        }
        let network = problem.network;
        for Drive { mechanism, way } in &self.drives {
            let values = network.mechanisms[*mechanism].at(way, t);
            problem.set_mechanism(*mechanism, values);
        }
        for journey in &self.journeys {
            let f = journey.constraint();
            let body = problem.conditions().body(network, network.constraints[f].mount);
            problem.set_target(f, body.compose(&journey.at(t)));
        }
        for (o, obstacle) in network.obstacles.iter().enumerate() {
            if drives(&self.drives, obstacle.mount) {
                let body = problem.conditions().body(network, obstacle.mount);
                problem.set_obstacle(o, body.compose(&obstacle.pose));
            }
        }
        for (obstacle, course) in &self.obstacles {
            problem.set_obstacle(*obstacle, course.at(t));
        }
        if self.release_drawn_shape {
            problem.set_drawn_fraction(1.0 - t);
        }
        if self.apply_without_potential {
            problem.set_fraction_without_potential(t);
        }
    }
}

/// Whether the mechanism of a body is driven.
fn drives(drives: &[Drive], body: Option<Mount>) -> bool {
    body.is_some_and(|body| drives.iter().any(|drive| drive.mechanism == body.mechanism))
}

/// Journey of a constraint from its present pose to the pose of the scenario.
pub(crate) fn journey_to_target(f: usize, constraint: &AttachedConstraint, from: Pose) -> Journey {
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
