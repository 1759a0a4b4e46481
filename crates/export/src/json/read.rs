//! Reads a `result.json` back, as far as results are compared.

use crate::ending::{BranchEnd, Closed, Ending, FixingEnd, count};
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::io::{self, Read};
use std::marker::PhantomData;
use wireloom_core::equilibrium::Energy;
use wireloom_core::{EventKind, Status, Vector};

/// How the run of a `result.json` ended; `None` where it has no steps. Of all steps but the last, shapes are forgotten as they are
/// read.
///
/// # Errors
/// Those of `input`; `InvalidData`, with the place, where it is no result.
pub fn read(input: impl Read) -> io::Result<Option<Ending>> {
    let document: Document = serde_json::from_reader(io::BufReader::new(input))?;
    known_schema(document.schema)?;
    let Document {
        scenario,
        status,
        events,
        steps: Steps { last, closed, iterations, polish, factorisations, seconds },
        ..
    } = document;
    let Some(end) = last else { return Ok(None) };
    let kinds = events.iter().filter_map(|event| EventKind::ALL.into_iter().find(|kind| kind.word() == event.kind));
    let slides = end.sliding.0;
    let fixings = end.constraints.0.into_iter().map(|(name, fixing)| FixingEnd {
        position: vector(fixing.position),
        force: vector(fixing.force),
        moment: vector(fixing.moment),
        slide: slides
            .iter()
            .find(|(sliding, _)| *sliding == name)
            .map(|(_, s)| (s.branch.clone(), s.contact_arclength)),
        name,
    });
    let mut ending = Ending {
        scenario,
        converged: status == Status::Converged.word(),
        status,
        stable: end.stable,
        fixings: fixings.collect(),
        branches: end.branches.0.into_iter().map(|(name, branch)| branch.named(name)).collect(),
        closed,
        energy: end.energy.plain(),
        events: count(kinds.collect::<Vec<_>>().into_iter()),
        iterations,
        polish,
        factorisations,
        seconds,
        minimiser: end.minimiser.kind,
    };
    ending.settle();
    Ok(Some(ending))
}

/// Refuses a form that this program does not know.
pub fn known_schema(schema: u32) -> io::Result<()> {
    if schema == super::SCHEMA {
        return Ok(());
    }
    Err(invalid(format!("schema {schema} is not known to this program, which reads {}", super::SCHEMA)))
}

/// What is no result.
pub fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message)
}

#[derive(Deserialize)]
struct Document {
    schema: u32,
    scenario: String,
    status: String,
    #[serde(default)]
    events: Vec<Occurrence>,
    steps: Steps,
}

#[derive(Deserialize)]
struct Occurrence {
    kind: String,
}

#[derive(Deserialize)]
struct Step {
    name: String,
    increment: usize,
    branches: Entries<Branch>,
    constraints: Entries<Constraint>,
    #[serde(default)]
    sliding: Entries<Slide>,
    #[serde(default)]
    operations: Vec<Operation>,
    energy: EnergyByEffect,
    stable: Option<bool>,
    minimiser: Minimiser,
}

#[derive(Deserialize)]
struct Operation {
    operation: String,
    constraint: Option<String>,
    branch: Option<String>,
    s: Option<f64>,
}

impl Operation {
    fn closed(self) -> Option<Closed> {
        let closes = matches!(self.operation.as_str(), "grasp" | "clip");
        self.constraint.filter(|_| closes).map(|fixing| Closed { fixing, place: self.branch.zip(self.s) })
    }
}

/// A number that is null where it was not finite.
pub type Number = Option<f64>;

/// A number; NaN where it was not finite.
pub fn number(number: Number) -> f64 {
    number.unwrap_or(f64::NAN)
}

#[derive(Deserialize)]
struct Branch {
    s: Vec<f64>,
    position: Vec<[Number; 3]>,
    d3: Vec<[Number; 3]>,
    bend_radius: Vec<Number>,
    twist_turns: Number,
}

impl Branch {
    fn named(self, name: String) -> BranchEnd {
        BranchEnd {
            name,
            s: self.s,
            position: self.position.into_iter().map(vector).collect(),
            tangent: self.d3.into_iter().map(vector).collect(),
            bend_radius: self.bend_radius.into_iter().map(|radius| radius.unwrap_or(f64::INFINITY)).collect(),
            twist_turns: self.twist_turns.unwrap_or(f64::NAN),
        }
    }
}

#[derive(Deserialize)]
struct Constraint {
    position: [Number; 3],
    force: [Number; 3],
    moment: [Number; 3],
}

#[derive(Deserialize)]
struct Slide {
    branch: String,
    contact_arclength: f64,
}

#[derive(Deserialize)]
pub struct EnergyByEffect {
    stretch: Number,
    shear: Number,
    bend: Number,
    twist: Number,
    gravity: Number,
    load: Number,
    joint: Number,
    constraint: Number,
}

impl EnergyByEffect {
    /// As results have it.
    pub fn plain(&self) -> Energy {
        Energy {
            stretch: number(self.stretch),
            shear: number(self.shear),
            bend: number(self.bend),
            twist: number(self.twist),
            gravity: number(self.gravity),
            load: number(self.load),
            joint: number(self.joint),
            constraint: number(self.constraint),
        }
    }
}

#[derive(Deserialize)]
struct Minimiser {
    kind: String,
    iterations: usize,
    #[serde(default)]
    polish: usize,
    factorisations: usize,
    seconds: Number,
}

/// A vector; NaN where it was not finite.
pub fn vector(v: [Number; 3]) -> Vector {
    Vector::from(v.map(number))
}

/// The last step of a list, and what adds up over all of them.
#[derive(Default)]
struct Steps {
    last: Option<Step>,
    closed: Vec<Closed>,
    iterations: usize,
    polish: usize,
    factorisations: usize,
    seconds: f64,
}

impl Steps {
    fn see(&mut self, mut step: Step) {
        self.closed.extend(std::mem::take(&mut step.operations).into_iter().filter_map(Operation::closed));
        // Work counts are those of the step so far: of its increments the last one holds.
        if let Some(before) =
            self.last.take().filter(|before| before.name == step.name && step.increment > before.increment)
        {
            self.iterations -= before.minimiser.iterations;
            self.polish -= before.minimiser.polish;
            self.factorisations -= before.minimiser.factorisations;
            self.seconds -= before.minimiser.seconds.unwrap_or(0.0);
        }
        self.iterations += step.minimiser.iterations;
        self.polish += step.minimiser.polish;
        self.factorisations += step.minimiser.factorisations;
        self.seconds += step.minimiser.seconds.unwrap_or(0.0);
        self.last = Some(step);
    }
}

impl<'de> Deserialize<'de> for Steps {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Each;
        impl<'de> Visitor<'de> for Each {
            type Value = Steps;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of steps")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Steps, A::Error> {
                let mut steps = Steps::default();
                while let Some(step) = list.next_element()? {
                    steps.see(step);
                }
                Ok(steps)
            }
        }
        deserializer.deserialize_seq(Each)
    }
}

/// An object whose keys are names, in the order of the text.
pub struct Entries<T>(pub Vec<(String, T)>);

impl<T> Default for Entries<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Entries<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Each<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Each<T> {
            type Value = Entries<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entries<T>, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Entries(entries))
            }
        }
        deserializer.deserialize_map(Each(PhantomData))
    }
}
