//! Studies of a scenario: derivatives, identification, optimisation. Answers are JSON, as the command line prints it.

use crate::failure::Failure;
use crate::source::{Loaded, Source};
use crate::worker::{answer, attend, caught, interruptible, spawn};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use serde::Serialize;
use serde_json::json;
use std::sync::mpsc::channel;
use wireloom::Registry;
use wireloom::identify::{self as identification, Identified, NoFit, Request, Wishes};
use wireloom::optimise::{Design, NoOptimum, Optimisation, Search};
use wireloom::scenario::value_for;
use wireloom::sensitivity::{NoAnswer, Question, Source as Study, Study as Sensitivity};
use wireloom::session::Monitor;

fn json(answer: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(answer).map_err(|error| Failure::Internal(error.to_string()))
}

/// Derivatives at the end of a step, as JSON.
#[pyfunction]
pub fn sensitivities(
    py: Python<'_>,
    source: Source,
    of: Vec<String>,
    by: Vec<String>,
    step: Option<String>,
) -> PyResult<String> {
    interruptible(py, move |monitor| {
        let Loaded { registry, files, .. } = source.load()?;
        let study = Study { monitor: monitor.clone(), ..Study::new(&source.text, &files, &registry) };
        let question = Question { of: &of, by: &by, step: step.as_deref() };
        let found = Sensitivity::new(study).and_then(|mut study| study.answer(&question));
        json(&found.map_err(|none| match none {
            NoAnswer::Faults(faults) => source.refused(faults),
            NoAnswer::Part(fault) => Failure::Part(fault.to_string()),
            NoAnswer::Question(words) => Failure::Question(words),
            none => Failure::NoAnswer(none.to_string()),
        })?)
    })
}

/// A number as Python has it: SI, or text with a unit.
#[derive(FromPyObject)]
pub enum Given {
    Number(f64),
    Text(String),
}

impl Given {
    /// The value for a key of a scenario, SI.
    fn value(&self, key: &str, text: &str, registry: &Registry) -> Result<f64, Failure> {
        match self {
            Self::Number(number) => Ok(*number),
            Self::Text(words) => value_for(text, key, words.trim(), registry)
                .map_err(|fault| Failure::Question(format!("the value for `{key}`: {fault}"))),
        }
    }
}

/// What is to be identified.
#[derive(FromPyObject)]
pub struct Fit {
    /// Names and contents of tables.
    #[pyo3(item(0))]
    tables: Vec<(String, String)>,
    /// Whether they are bending curves.
    #[pyo3(item(1))]
    bending: bool,
    #[pyo3(item(2))]
    fit: Vec<String>,
    /// Keys with values and deviations.
    #[pyo3(item(3))]
    priors: Vec<(String, [Given; 2])>,
    /// Keys with least and largest values.
    #[pyo3(item(4))]
    bounds: Vec<(String, [Given; 2])>,
    /// Keys of which neighbours differ by a deviation.
    #[pyo3(item(5))]
    smooth: Vec<(Vec<String>, Given)>,
    /// m or N.
    #[pyo3(item(6))]
    noise: Option<f64>,
}

impl Fit {
    fn identify(&self, source: &Source, monitor: &Monitor) -> Result<Identified, Failure> {
        let Loaded { registry, files, .. } = source.load()?;
        let value = |key: &str, given: &Given| given.value(key, &source.text, &registry);
        let pairs = |all: &[(String, [Given; 2])]| {
            let pair =
                |(key, [one, other]): &(String, [Given; 2])| Ok((key.clone(), [value(key, one)?, value(key, other)?]));
            all.iter().map(pair).collect::<Result<Vec<_>, Failure>>()
        };
        let (priors, bounds) = (pairs(&self.priors)?, pairs(&self.bounds)?);
        let smoothness = |(keys, given): &(Vec<String>, Given)| {
            let Some(first) = keys.first() else {
                return Err(Failure::Question("`smooth` has a list of no keys".to_owned()));
            };
            Ok((keys.clone(), value(first, given)?))
        };
        let smooth = self.smooth.iter().map(smoothness).collect::<Result<Vec<_>, _>>()?;
        let tables: Vec<&str> = self.tables.iter().map(|(_, content)| content.as_str()).collect();
        let (points, curves): (&[&str], &[&str]) = if self.bending { (&[], &tables) } else { (&tables, &[]) };
        let wishes = Wishes { fit: &self.fit, priors: &priors, bounds: &bounds, smooth: &smooth };
        let request = Request { tables: points, bending: curves, wishes, noise: self.noise };
        let study = Study { monitor: monitor.clone(), ..Study::new(&source.text, &files, &registry) };
        identification::identify(study, &request).map_err(|none| match none {
            NoFit::Faults(faults) => source.refused(faults),
            NoFit::Table(k, faults) => {
                let (name, text) = self.tables[k].clone();
                Failure::Refused { name, text, faults }
            }
            NoFit::Part(fault) => Failure::Part(fault.to_string()),
            NoFit::Question(words) => Failure::Question(words),
            none => Failure::NoAnswer(none.to_string()),
        })
    }
}

/// The answer, the text with the fitted values, and whether Ctrl-C ended it early.
#[pyfunction]
pub fn identify(py: Python<'_>, source: Source, fit: Fit) -> PyResult<(String, String, bool)> {
    let (monitor, (sender, messages)) = (Monitor::default(), channel());
    let own = monitor.clone();
    spawn(move || {
        sender.send(caught(|| fit.identify(&source, &own).and_then(|found| Ok((json(&found)?, found.text)))).flatten())
    })?;
    let (found, outcome) = answer(py, messages, &monitor);
    let (answer, text, interrupted) = kept(py, found, outcome)?;
    Ok((answer, text, interrupted))
}

/// What was found, though Ctrl-C may have ended it early.
fn kept<T, U>(py: Python<'_>, found: Option<Result<(T, U), Failure>>, outcome: PyResult<()>) -> PyResult<(T, U, bool)> {
    let found = found.unwrap_or_else(|| Err(Failure::Internal("the work has vanished".to_owned())));
    match (outcome, found) {
        (Err(error), Ok((one, other))) if error.is_instance_of::<PyKeyboardInterrupt>(py) => Ok((one, other, true)),
        (Err(error), _) => Err(error),
        (Ok(()), found) => found.map(|(one, other)| (one, other, false)).map_err(PyErr::from),
    }
}

/// What the calling thread is told of an optimisation.
enum Message {
    Design(Box<Design>),
    End(Box<Result<(String, Option<String>), Failure>>),
}

/// What was found, and the text of the optimum.
fn optimised(found: &Optimisation) -> Result<(String, Option<String>), Failure> {
    let optimum = found.optimum.as_ref().map(|optimum| {
        let certificate = optimum
            .certificate
            .as_ref()
            .map(|run| json!({ "status": run.status().word(), "verdict": run.verdict().word() }));
        json!({
            "run": optimum.run,
            "objective": optimum.objective,
            "values": optimum.values,
            "certificate": certificate,
        })
    });
    let answer = json!({
        "ending": found.ending,
        "words": found.ending.words(),
        "counts": found.counts,
        "keys": found.keys,
        "units": found.units,
        "designs": found.designs,
        "optimum": optimum,
    });
    Ok((answer.to_string(), found.optimum.as_ref().map(|optimum| optimum.text.clone())))
}

/// The answer, the text of the optimum, and whether Ctrl-C ended it early. `on_design` is called with each design, as
/// JSON, in the calling thread.
#[pyfunction]
pub fn optimise(
    py: Python<'_>,
    source: Source,
    on_design: Option<Py<PyAny>>,
) -> PyResult<(String, Option<String>, bool)> {
    let (monitor, (sender, messages)) = (Monitor::default(), channel());
    let (own, designs) = (monitor.clone(), sender.clone());
    let search = move || {
        let Loaded { registry, files, .. } = source.load()?;
        let study = Study { monitor: own, ..Study::new(&source.text, &files, &registry) };
        let refused = |none: NoOptimum| match none {
            NoOptimum::Faults(faults) => source.refused(faults),
            NoOptimum::NothingAsked => Failure::Question(none.to_string()),
            NoOptimum::Stopped => Failure::NoAnswer(none.to_string()),
        };
        let search = Search::new(study).map_err(refused)?;
        let found = search.run(&mut |design| {
            // The calling thread waits for the end.
            let _ = designs.send(Message::Design(Box::new(design.clone())));
        });
        optimised(&found.map_err(refused)?)
    };
    spawn(move || sender.send(Message::End(Box::new(caught(search).flatten()))))?;
    let mut found = None;
    let outcome = attend(py, messages, &monitor, |message| match message {
        Message::End(answer) => {
            found = Some(*answer);
            Ok(())
        }
        Message::Design(design) => match &on_design {
            Some(call) => call.call1(py, (json(&*design)?,)).map(|_| ()),
            None => Ok(()),
        },
    });
    kept(py, found, outcome)
}
