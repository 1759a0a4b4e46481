//! Runs a scene as a user would, and reads its `result.json`.

use super::scene::Scene;
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use wireloom::Control;
use wireloom::geometry::{Rotation, Vector};
use wireloom::scenario::Fault;
use wireloom::session::{Checkpoint, Observer, Progress, Resumed};

/// A number of a result, which writes `null` for what is not finite.
fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

fn vector<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vector, D::Error> {
    let v = <[Option<f64>; 3]>::deserialize(deserializer)?;
    Ok(Vector::from(v.map(|x| x.unwrap_or(f64::NAN))))
}

fn vectors<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vector>, D::Error> {
    let all = Vec::<[Option<f64>; 3]>::deserialize(deserializer)?;
    Ok(all.into_iter().map(|v| Vector::from(v.map(|x| x.unwrap_or(f64::NAN)))).collect())
}

fn rotation<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Rotation, D::Error> {
    let [w, i, j, k] = <[Option<f64>; 4]>::deserialize(deserializer)?.map(|x| x.unwrap_or(f64::NAN));
    Ok(Rotation::from_quaternion(nalgebra::Quaternion::new(w, i, j, k)))
}

/// Part of `result.json` that the hunt reads.
#[derive(Clone, Debug, Deserialize)]
pub struct Outcome {
    /// Status of the run.
    pub status: String,
    /// The last increment of every step.
    pub steps: Vec<StepOutcome>,
    /// Events.
    #[serde(default)]
    pub events: Vec<EventOutcome>,
}

/// Something that happened.
#[derive(Clone, Debug, Deserialize)]
pub struct EventOutcome {
    /// Its kind.
    pub kind: String,
    /// Value.
    pub value: Option<f64>,
}

/// A step.
#[derive(Clone, Debug, Deserialize)]
pub struct StepOutcome {
    /// Status.
    pub status: String,
    /// By name.
    pub branches: BTreeMap<String, BranchOutcome>,
    /// By name.
    pub joints: BTreeMap<String, JointOutcome>,
    /// By name.
    pub constraints: BTreeMap<String, ConstraintOutcome>,
    /// By name.
    #[serde(default)]
    pub obstacles: BTreeMap<String, ObstacleOutcome>,
    /// By name of the constraint.
    #[serde(default)]
    pub sliding: BTreeMap<String, SlidingOutcome>,
    /// J.
    pub energy: EnergyOutcome,
    /// Claimed stability.
    pub stable: Option<bool>,
}

/// A branch: one entry a node.
#[derive(Clone, Debug, Deserialize)]
pub struct BranchOutcome {
    /// Arc lengths, m.
    pub s: Vec<f64>,
    /// m.
    #[serde(deserialize_with = "vectors")]
    pub position: Vec<Vector>,
    /// Tangent.
    #[serde(deserialize_with = "vectors")]
    pub d3: Vec<Vector>,
    /// First director.
    #[serde(deserialize_with = "vectors")]
    pub d1: Vec<Vector>,
    /// N.
    #[serde(deserialize_with = "vectors")]
    pub force: Vec<Vector>,
    /// N m.
    #[serde(deserialize_with = "vectors")]
    pub moment: Vec<Vector>,
    /// Twist.
    #[serde(deserialize_with = "number")]
    pub twist_turns: f64,
}

impl BranchOutcome {
    /// Length of segment `i`, m: the drawn one or the unstressed one, whichever is longer.
    pub fn chord(&self, i: usize) -> f64 {
        (self.position[i + 1] - self.position[i]).norm().max(self.s[i + 1] - self.s[i])
    }
}

/// A joint.
#[derive(Clone, Debug, Deserialize)]
pub struct JointOutcome {
    /// m.
    #[serde(deserialize_with = "vector")]
    pub position: Vector,
    /// Its frame.
    #[serde(deserialize_with = "rotation")]
    pub orientation: Rotation,
}

/// A constraint that acts.
#[derive(Clone, Debug, Deserialize)]
pub struct ConstraintOutcome {
    /// The held point, m.
    #[serde(deserialize_with = "vector")]
    pub position: Vector,
    /// The held frame.
    #[serde(deserialize_with = "rotation")]
    pub orientation: Rotation,
    /// On the harness, N.
    #[serde(deserialize_with = "vector")]
    pub force: Vector,
    /// On the harness about the held point, N m.
    #[serde(deserialize_with = "vector")]
    pub moment: Vector,
}

/// An obstacle.
#[derive(Clone, Debug, Deserialize)]
pub struct ObstacleOutcome {
    /// m.
    #[serde(deserialize_with = "vector")]
    pub position: Vector,
    /// On the harness, N.
    #[serde(deserialize_with = "vector")]
    pub force: Vector,
    /// On the harness about its position, N m.
    #[serde(deserialize_with = "vector")]
    pub moment: Vector,
    /// Places that it pushes.
    pub contacts: usize,
}

/// A constraint that slides.
#[derive(Clone, Debug, Deserialize)]
pub struct SlidingOutcome {
    /// m.
    #[serde(deserialize_with = "number")]
    pub contact_arclength: f64,
}

/// Energy by effect, J.
#[derive(Clone, Debug, Deserialize)]
#[allow(missing_docs, reason = "the names say it")]
pub struct EnergyOutcome {
    #[serde(deserialize_with = "number")]
    pub total: f64,
    #[serde(deserialize_with = "number")]
    pub stretch: f64,
    #[serde(deserialize_with = "number")]
    pub shear: f64,
    #[serde(deserialize_with = "number")]
    pub bend: f64,
    #[serde(deserialize_with = "number")]
    pub twist: f64,
    #[serde(deserialize_with = "number")]
    pub gravity: f64,
    #[serde(deserialize_with = "number")]
    pub load: f64,
    #[serde(deserialize_with = "number")]
    pub joint: f64,
    #[serde(deserialize_with = "number")]
    pub constraint: f64,
}

/// Outcome of a run.
pub enum Ran {
    /// The text was refused.
    Refused(String),
    /// A panic.
    Panicked(String),
    /// It ended.
    Ended(Box<Outcome>),
}

impl Ran {
    /// Result, if the run and all of its steps are called converged.
    pub fn converged(self) -> Option<Outcome> {
        match self {
            Self::Ended(outcome) if outcome.status == "converged" => Some(*outcome),
            _ => None,
        }
    }
}

/// Keeps the checkpoint at the beginning of one step.
struct Keeper {
    step: usize,
    seen: usize,
    kept: Option<Checkpoint>,
    results: Vec<wireloom::StepResult>,
}

impl Observer for Keeper {
    fn increment(&mut self, progress: &Progress, end: &wireloom::StepResult, kept: bool) -> Control {
        if progress.step_index < self.step && kept {
            self.results.push(end.clone());
        }
        if progress.increment == progress.increments {
            self.seen = progress.step_index + 1;
        }
        Control::Continue
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        if self.seen == self.step && self.kept.is_none() {
            self.kept = Some(checkpoint.clone());
        }
    }
}

/// Runs a scene.
pub fn run(scene: &Scene) -> Ran {
    run_keeping(scene, usize::MAX, None).0
}

/// Runs a scene, from `resumed` where there is one, and keeps what it takes to go on from the beginning of a step.
pub fn run_keeping(scene: &Scene, step: usize, resumed: Option<Resumed>) -> (Ran, Option<Resumed>) {
    let text = scene.text();
    let caught = catch_unwind(AssertUnwindSafe(|| {
        let registry = wireloom::registry();
        let (scenario, built) = match wireloom::load(&text, &registry) {
            Ok(loaded) => loaded,
            Err(faults) => return (Ran::Refused(said(&text, &faults)), None),
        };
        let mut keeper = Keeper { step, seen: 0, kept: None, results: Vec::new() };
        let run = wireloom::run_observed(built, resumed, &mut keeper);
        let provenance = wireloom::export::provenance("hunt", &scenario, &[], &[], &[]);
        let mut json = Vec::new();
        wireloom::export::json::write(&run, &provenance, &mut json).expect("a Vec takes everything");
        let outcome: Outcome = serde_json::from_slice(&json).expect("result.json has the form it is said to have");
        let kept = keeper.kept.map(|checkpoint| Resumed { checkpoint, steps: keeper.results });
        (Ran::Ended(Box::new(outcome)), kept)
    }));
    caught.unwrap_or_else(|panic| {
        let words = panic.downcast_ref::<String>().cloned();
        let words = words.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        (Ran::Panicked(words.unwrap_or_default()), None)
    })
}

fn said(text: &str, faults: &[Fault]) -> String {
    wireloom::scenario::render(text, faults)
}
