//! Constraints and joint models written in Python. `python/wireloom/parts.py` declares them, and its adapters make
//! and read the bytes that cross here: doubles of this machine.

use crate::failure::Failure;
use crate::worker::{caught, interruptible};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::BTreeMap;
use std::panic::{set_hook, take_hook};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use wireloom::Registry;
use wireloom::geometry::{Pose, Rotation, Vector};
use wireloom::parts::numeric::NOTE;
use wireloom::parts::{
    Action, Arm, Attaches, BuildError, Constraint, ConstraintEnergy, ConstraintKind, ConstraintSpec, ConstraintView,
    Form, JointEnergy, JointKind, JointModel, JointShape, JointSpec, Mounting, Numeric, Output, Parameter, Parameters,
    SpanSpec, SpanUse, StationSpec, Value,
};
use wireloom::result::Library;
use wireloom::scenario::quantity_in;
use wireloom::testing::conformance::{constraint, joint};

/// Help of a refusal by a part's own code.
const HELP: &str = "see the class of this kind";

/// Arms of the largest joint that a model is tried with: with more of them it would take minutes.
const ARMS: usize = 4;

/// Round-off of derivatives that are differences of an energy, relative to them.
const OF_DIFFERENCES: f64 = 1e-8;

/// A remark on a part; `differences`: whether its gradient is taken by differences.
fn note(differences: bool) -> String {
    let slow = "it is computed in Python, which is slow";
    if differences { format!("{slow}; {NOTE}") } else { slow.to_owned() }
}

/// A part as Python declares it: a tuple.
#[derive(FromPyObject)]
pub struct Part {
    /// `constraint` or `joint`.
    #[pyo3(item(0))]
    family: String,
    /// Name of its kind.
    #[pyo3(item(1))]
    kind: String,
    #[pyo3(item(2))]
    doc: String,
    #[pyo3(item(3))]
    parameters: Vec<Declared>,
    /// Least and greatest number of stations, and use of a span: `never`, `maybe` or `always`.
    #[pyo3(item(4))]
    attaches: (usize, usize, String),
    /// Name, description and unit of each output, and whether it is an event.
    #[pyo3(item(5))]
    outputs: Vec<(String, String, String, bool)>,
    /// Makes an adapter of one part.
    #[pyo3(item(6))]
    make: Py<PyAny>,
    /// Class, file and SHA-256 of its source.
    #[pyo3(item(7))]
    source: (String, String, String),
    /// Whether it gives its gradient.
    #[pyo3(item(8))]
    has_gradient: bool,
}

/// Reads the parts of a scenario.
pub fn shared(list: &Bound<'_, PyAny>) -> PyResult<Vec<Arc<Part>>> {
    Ok(list.extract::<Vec<Part>>()?.into_iter().map(Arc::new).collect())
}

/// The built-in kinds and those of these parts.
pub fn registry(parts: &[Arc<Part>]) -> Result<Registry, Failure> {
    let mut registry = wireloom::registry();
    parts.iter().try_for_each(|part| part.register(&mut registry))?;
    Ok(registry)
}

/// What results say of the origin of these parts.
pub fn libraries(parts: &[Arc<Part>]) -> impl Iterator<Item = Library> {
    parts.iter().map(|part| {
        let (class, file, hash) = part.source.clone();
        Library { name: class, version: String::new(), file, hash }
    })
}

/// A declared parameter: a tuple.
#[derive(FromPyObject)]
struct Declared {
    #[pyo3(item(0))]
    name: String,
    #[pyo3(item(1))]
    doc: String,
    /// `number`, `vector`, `count`, `flag` or `choice`.
    #[pyo3(item(2))]
    form: String,
    /// SI unit of a number or a vector.
    #[pyo3(item(3))]
    unit: String,
    /// Least and greatest number, and whether the least one itself is excluded.
    #[pyo3(item(4))]
    range: (f64, f64, bool),
    /// Words of a choice.
    #[pyo3(item(5))]
    words: Vec<String>,
    #[pyo3(item(6))]
    default: Option<Given>,
    #[pyo3(item(7))]
    required: bool,
}

/// A value from Python.
#[derive(FromPyObject)]
pub enum Given {
    Flag(bool),
    Number(f64),
    Word(String),
    Vector([f64; 3]),
}

impl Given {
    /// The value of a parameter of this form.
    fn value(&self, name: &str, form: &Form) -> Result<Value, Failure> {
        let value = match (self, form) {
            (Self::Number(x), Form::Number { .. }) => Some(Value::Number(*x)),
            (Self::Number(x), Form::Count { minimum }) if x.fract() == 0.0 && *x >= *minimum as f64 => {
                Some(Value::Count(*x as usize))
            }
            (Self::Flag(flag), Form::Flag) => Some(Value::Flag(*flag)),
            (Self::Word(word), Form::Choice(words)) if words.contains(word) => Some(Value::Word(word.clone())),
            (Self::Vector(x), Form::Vector { .. }) => Some(Value::Vector(Vector::from(*x))),
            _ => None,
        };
        let help = "give one that its declaration allows, a number in SI units".to_owned();
        value.ok_or_else(|| Failure::Request(format!("that is no value of the parameter {name}"), help))
    }
}

impl Declared {
    fn parameter(&self) -> Result<Parameter, Failure> {
        let (minimum, maximum, exclusive) = self.range;
        let quantity = || {
            quantity_in(&self.unit).ok_or_else(|| {
                let help = "give one of the SI, such as N/m or N m/rad, or 1 for a pure number";
                Failure::Request(
                    format!("\"{}\" of {} is no unit of a parameter", self.unit, self.name),
                    help.to_owned(),
                )
            })
        };
        let form = match self.form.as_str() {
            "vector" => Form::Vector { quantity: quantity()? },
            "count" => Form::Count { minimum: minimum as usize },
            "flag" => Form::Flag,
            "choice" => Form::Choice(self.words.clone()),
            _ => Form::Number { quantity: quantity()?, minimum, exclusive, maximum },
        };
        let default = self.default.as_ref().map(|given| given.value(&self.name, &form)).transpose()?;
        Ok(Parameter { name: self.name.clone(), doc: self.doc.clone(), form, default, required: self.required })
    }
}

impl Part {
    fn declared(&self) -> Result<Vec<Parameter>, Failure> {
        self.parameters.iter().map(Declared::parameter).collect()
    }

    fn declared_outputs(&self) -> Result<Vec<Output>, Failure> {
        let output = |(name, doc, unit, event): &(String, String, String, bool)| match quantity_in(unit) {
            Some(quantity) => Ok(Output { name: name.clone(), doc: doc.clone(), quantity, event: *event }),
            None => {
                let help = "give one of the SI, or 1 for a pure number".to_owned();
                Err(Failure::Request(format!("\"{unit}\" of output {name} is no unit"), help))
            }
        };
        self.outputs.iter().map(output).collect()
    }

    fn attaches(&self) -> Attaches {
        let (least, most, span) = &self.attaches;
        let span = match span.as_str() {
            "always" => SpanUse::Always,
            "maybe" => SpanUse::Maybe,
            _ => SpanUse::Never,
        };
        Attaches { stations: *least..=*most, span }
    }

    /// Adds its kind to a registry.
    fn register(self: &Arc<Self>, registry: &mut Registry) -> Result<(), Failure> {
        let (name, doc, parameters, own) = (self.kind.clone(), self.doc.clone(), self.declared()?, self.clone());
        let taken = if self.family == "constraint" {
            let (attaches, outputs) = (self.attaches(), self.declared_outputs()?);
            let build = Box::new(move |spec: &ConstraintSpec, values: &Parameters| own.constraint(spec, values));
            registry.add_constraint(ConstraintKind { name, doc, attaches, parameters, outputs, build }).is_err()
        } else {
            let build = Box::new(move |spec: &JointSpec, values: &Parameters| own.joint(spec, values));
            registry.add_joint(JointKind { name, doc, parameters, build }).is_err()
        };
        if taken {
            let help = "give the class another kind".to_owned();
            return Err(Failure::Request(format!("there is a kind \"{}\" already", self.kind), help));
        }
        Ok(())
    }

    /// Makes an adapter with what `arguments` makes of the interpreter.
    fn adapter<'py>(
        &self,
        py: Python<'py>,
        arguments: impl FnOnce(&Bound<'py, PyDict>) -> PyResult<()>,
        values: &Parameters,
    ) -> PyResult<Bound<'py, PyAny>> {
        let named = PyDict::new(py);
        arguments(&named)?;
        let given = PyDict::new(py);
        for (name, value) in &values.0 {
            match value {
                Value::Number(x) => given.set_item(name, x)?,
                Value::Vector(x) => given.set_item(name, (x.x, x.y, x.z))?,
                Value::Count(n) => given.set_item(name, n)?,
                Value::Flag(flag) => given.set_item(name, flag)?,
                Value::Word(word) => given.set_item(name, word)?,
            }
        }
        named.set_item("values", given)?;
        self.make.bind(py).call((), Some(&named))
    }

    fn constraint(&self, spec: &ConstraintSpec, values: &Parameters) -> Result<Box<dyn Constraint>, BuildError> {
        let arguments = |named: &Bound<'_, PyDict>| {
            let stations: Vec<(Option<(String, f64)>, f64)> =
                spec.stations.iter().map(|station| (station.place.clone(), station.diameter)).collect();
            let span = spec.span.as_ref().map(|span| (span.branch.clone(), span.range, span.diameter));
            named.set_item("name", &spec.name)?;
            named.set_item("stations", stations)?;
            named.set_item("span", span)
        };
        let made = Python::attach(|py| {
            let adapter = self.adapter(py, arguments, values)?;
            let memory: Vec<f64> = adapter.getattr("memory")?.extract()?;
            let objective = adapter.getattr("objective")?.extract()?;
            let energy = Numeric(Adapter { object: adapter.unbind(), fault: OnceLock::new() });
            let (differences, reports) = (!self.has_gradient, !self.outputs.is_empty());
            PyResult::Ok(OwnConstraint { energy, memory, objective, differences, reports })
        });
        Ok(Box::new(made.map_err(refusal)?))
    }

    fn joint(&self, spec: &JointSpec, values: &Parameters) -> Result<Box<dyn JointModel>, BuildError> {
        let arguments = |named: &Bound<'_, PyDict>| {
            let arms = spec.arms.iter().map(|arm| arm_of(named.py(), arm)).collect::<PyResult<Vec<_>>>()?;
            let wires: Vec<(usize, usize, f64)> =
                spec.wires.iter().map(|wire| (wire.from, wire.to, wire.fraction)).collect();
            named.set_item("name", &spec.name)?;
            named.set_item("arms", arms)?;
            named.set_item("wires", wires)
        };
        let made = Python::attach(|py| {
            let adapter = self.adapter(py, arguments, values)?;
            let is = |word: &str| -> PyResult<bool> { adapter.getattr(word)?.extract() };
            let mounting = match (is("hub")?, is("at_stations")?) {
                (true, _) => Mounting::CompliantHub,
                (false, true) => Mounting::Stations,
                (false, false) => Mounting::Point,
            };
            let memory: Vec<f64> = adapter.getattr("memory")?.extract()?;
            let adapter = Adapter { object: adapter.unbind(), fault: OnceLock::new() };
            let differences = !self.has_gradient;
            PyResult::Ok(Numeric(OwnJoint { adapter, memory, mounting, differences, note: spec.note_on_coupling() }))
        });
        Ok(Box::new(made.map_err(refusal)?))
    }
}

/// An arm as keyword arguments.
fn arm_of<'py>(py: Python<'py>, arm: &Arm) -> PyResult<Bound<'py, PyDict>> {
    let (named, section) = (PyDict::new(py), &arm.section);
    named.set_item("branch", &arm.branch)?;
    named.set_item("starts_here", arm.starts_here)?;
    named.set_item("rest", PyBytes::new(py, &bytes(quaternion(&arm.rest))))?;
    named.set_item("offset", <[f64; 3]>::from(arm.offset))?;
    named.set_item("segment_length", arm.segment_length)?;
    named.set_item("length", arm.length)?;
    named.set_item("curvature", <[f64; 3]>::from(arm.curvature))?;
    named.set_item("diameter", section.diameter)?;
    named.set_item("linear_density", section.linear_density)?;
    named.set_item("axial_stiffness", section.axial_stiffness)?;
    named.set_item("shear_stiffness", section.shear_stiffness)?;
    named.set_item("bending_stiffness", section.bending_stiffness)?;
    named.set_item("torsion_stiffness", section.torsion_stiffness)?;
    named.set_item("spring_bending", arm.spring.bending)?;
    named.set_item("spring_torsion", arm.spring.torsion)?;
    Ok(named)
}

/// The refusal of a part by its own code.
fn refusal(error: PyErr) -> BuildError {
    BuildError::new(Python::attach(|py| words(py, &error)), HELP)
}

/// An exception in words, with the place where it was raised.
fn words(py: Python<'_>, error: &PyErr) -> String {
    let traceback = error.traceback(py).and_then(|traceback| traceback.format().ok()).unwrap_or_default();
    let place = traceback.lines().rfind(|line| line.trim_start().starts_with("File "));
    place.map_or_else(|| error.to_string(), |place| format!("{error} ({})", place.trim()))
}

/// The bytes of numbers, as NumPy reads them.
fn bytes(numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(f64::to_ne_bytes).collect()
}

/// The numbers of bytes that NumPy made.
fn numbers(bytes: &[u8]) -> impl Iterator<Item = f64> {
    bytes.chunks_exact(size_of::<f64>()).map(|one| f64::from_ne_bytes(one.try_into().expect("eight bytes")))
}

/// Writes numbers into vectors; false where there are too many or too few.
fn fill<'v>(bytes: &[u8], vectors: impl ExactSizeIterator<Item = &'v mut Vector>) -> bool {
    let fits = bytes.len() == vectors.len() * size_of::<Vector>();
    let mut numbers = numbers(bytes);
    if fits {
        vectors.for_each(|to| *to = Vector::from_fn(|_, _| numbers.next().expect("as many as fit")));
    }
    fits
}

fn quaternion(q: &Rotation) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// Positions and quaternions of stations, those of their targets, nodes of the span, their lengths, the memory, and the
/// tensions if they are known.
fn view(at: &ConstraintView<'_>) -> Vec<f64> {
    let of = |poses: &[Pose]| -> Vec<f64> {
        let positions = poses.iter().flat_map(|pose| <[f64; 3]>::from(pose.position));
        positions.chain(poses.iter().flat_map(|pose| quaternion(&pose.orientation))).collect()
    };
    let span = at.span.iter().flat_map(|x| <[f64; 3]>::from(*x));
    let rest = span.chain(at.span_lengths.iter().copied()).chain(at.memory.iter().copied());
    let rest = rest.chain(at.tensions.iter().copied().flatten());
    [of(at.stations), of(at.targets), rest.collect()].concat()
}

/// The Python object behind a part.
struct Adapter {
    object: Py<PyAny>,
    /// The first exception; after it, the object is not called again.
    fault: OnceLock<String>,
}

impl Adapter {
    /// Calls a method; `None` where it fails, or has failed before.
    fn call<T>(
        &self,
        method: &str,
        numbers: &[f64],
        progress: f64,
        read: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Option<T> {
        // What is not finite is not asked for: no answer would be.
        if self.fault.get().is_some() || !numbers.iter().all(|x| x.is_finite()) {
            return None;
        }
        Python::attach(|py| {
            let argument = PyBytes::new(py, &bytes(numbers.iter().copied()));
            let answer = self.object.bind(py).call_method1(method, (argument, progress));
            answer.and_then(|answer| read(&answer)).map_err(|error| self.fail(words(py, &error))).ok()
        })
    }

    fn fail(&self, words: String) {
        // The first one counts.
        let _ = self.fault.set(words);
    }

    fn energy(&self, numbers: &[f64], progress: f64) -> f64 {
        let energy = self.call("energy", numbers, progress, |energy| energy.extract::<f64>());
        if let Some(energy) = energy.filter(|energy| !energy.is_finite()) {
            self.fail(format!("its energy is {energy}"));
        }
        energy.unwrap_or(f64::NAN)
    }

    /// The energy, and whether the derivatives were written; `None`: they are not known.
    fn gradient<'v>(
        &self,
        numbers: &[f64],
        progress: f64,
        vectors: impl ExactSizeIterator<Item = &'v mut Vector>,
    ) -> Option<f64> {
        let answer = self.call("gradient", numbers, progress, |answer| {
            let Some((energy, slopes)) = answer.extract::<Option<(f64, Bound<'_, PyBytes>)>>()? else {
                return Ok(None);
            };
            Ok(fill(slopes.as_bytes(), vectors).then_some(energy))
        });
        answer.unwrap_or(Some(f64::NAN))
    }

    /// Replaces what a part remembers.
    fn commit(&self, numbers: &[f64], progress: f64, memory: &mut [f64]) {
        match self.call("commit", numbers, progress, |next| next.extract::<Vec<f64>>()) {
            Some(next) if next.len() == memory.len() && next.iter().all(|x| x.is_finite()) => {
                memory.copy_from_slice(&next);
            }
            Some(next) => self.fail(format!("`commit` returned {next:?}, not {} finite numbers", memory.len())),
            None => {}
        }
    }
}

/// A constraint written in Python.
struct OwnConstraint {
    energy: Numeric<Adapter>,
    memory: Vec<f64>,
    objective: bool,
    /// Whether its gradient is taken by differences.
    differences: bool,
    /// Whether it has outputs.
    reports: bool,
}

impl ConstraintEnergy for Adapter {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        self.energy(&view(at), at.progress)
    }

    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], span: &mut [Vector]) -> Option<f64> {
        let mut all = vec![Vector::repeat(f64::NAN); stations.len() + span.len()];
        let energy = self.gradient(&view(at), at.progress, all.iter_mut())?;
        let (first, second) = all.split_at(stations.len());
        stations.copy_from_slice(first);
        span.copy_from_slice(second);
        Some(energy)
    }
}

impl Constraint for OwnConstraint {
    fn action(&self) -> Action<'_> {
        Action::Potential(&self.energy)
    }

    fn objective(&self) -> bool {
        self.objective
    }

    fn memory(&self) -> Vec<f64> {
        self.memory.clone()
    }

    fn commit(&self, at: &ConstraintView<'_>, memory: &mut [f64]) {
        self.energy.0.commit(&view(at), at.progress, memory);
    }

    fn outputs(&self, at: &ConstraintView<'_>) -> Vec<(String, f64)> {
        if !self.reports {
            return Vec::new();
        }
        let read = |values: &Bound<'_, PyAny>| values.extract::<Vec<(String, f64)>>();
        self.energy.0.call("report", &view(at), at.progress, read).unwrap_or_default()
    }

    fn fault(&self) -> Option<String> {
        self.energy.0.fault.get().cloned()
    }

    fn notes(&self) -> Vec<String> {
        vec![note(self.differences)]
    }
}

/// A joint model written in Python.
struct OwnJoint {
    adapter: Adapter,
    memory: Vec<f64>,
    mounting: Mounting,
    /// Whether its gradient is taken by differences.
    differences: bool,
    /// What it is not told.
    note: Option<String>,
}

impl OwnJoint {
    fn numbers(shape: &JointShape<'_>) -> Vec<f64> {
        shape.frames.iter().flat_map(quaternion).chain(shape.memory.iter().copied()).collect()
    }
}

impl JointEnergy for OwnJoint {
    fn mounting(&self) -> Mounting {
        self.mounting
    }

    fn energy(&self, shape: &JointShape<'_>) -> f64 {
        self.adapter.energy(&Self::numbers(shape), 1.0)
    }

    fn gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> Option<f64> {
        gradient.fill(Vector::repeat(f64::NAN));
        self.adapter.gradient(&Self::numbers(shape), 1.0, gradient.iter_mut())
    }

    fn memory(&self) -> Vec<f64> {
        self.memory.clone()
    }

    fn commit(&self, shape: &JointShape<'_>, memory: &mut [f64], _: &mut [f64]) {
        self.adapter.commit(&Self::numbers(shape), 1.0, memory);
    }

    fn fault(&self) -> Option<String> {
        self.adapter.fault.get().cloned()
    }

    fn notes(&self) -> Vec<String> {
        [note(self.differences)].into_iter().chain(self.note.clone()).collect()
    }
}

/// One check at a time: each of them exchanges the panic hook.
static CHECKING: Mutex<()> = Mutex::new(());

/// Holds a part with these values of its parameters against the contract of its family: what it does not keep, as the
/// name of the check and words. A constraint is tried with so many stations, and nodes of a span (0: none).
#[pyfunction]
pub fn check_part(
    py: Python<'_>,
    part: Part,
    values: BTreeMap<String, Given>,
    stations: usize,
    nodes: usize,
) -> PyResult<Vec<(String, String)>> {
    interruptible(py, move |_| {
        let declared = part.declared()?;
        let mut set = Parameters::default();
        for one in &declared {
            let given = values.get(&one.name).map(|given| given.value(&one.name, &one.form)).transpose()?;
            set.0.extend(given.or_else(|| one.default.clone()).map(|value| (one.name.clone(), value)));
        }
        let values = set;
        let mut broken = Vec::new();
        let mut try_one = |name: &str, check: &mut dyn FnMut()| {
            // Differences are not held against differences.
            if name.contains("hessian") || !part.has_gradient && name.starts_with("gradient_is") {
                return;
            }
            if let Err(Failure::Internal(words)) = caught(check) {
                broken.push((name.replace('_', " "), words));
            }
        };
        let failed = |error: BuildError| Failure::Part(error.message);
        // What a check finds is told by its panic; nobody else is to hear of it. The hook is that of the process.
        let _one = CHECKING.lock().unwrap_or_else(PoisonError::into_inner);
        let hook = take_hook();
        set_hook(Box::new(|_| {}));
        let tried = if part.family == "constraint" {
            let station = StationSpec { place: Some(("branch".to_owned(), 0.1)), diameter: 0.01 };
            let span = SpanSpec { branch: "branch".to_owned(), range: (0.1, 0.2), diameter: 0.01 };
            let spec = ConstraintSpec {
                name: "trial".to_owned(),
                stations: vec![station; stations],
                span: (nodes > 0).then_some(span),
                ..ConstraintSpec::default()
            };
            part.constraint(&spec, &values).map_err(failed).map(|_| {
                let make = || part.constraint(&spec, &values).unwrap_or_else(|error| panic!("{}", error.message));
                let subject = constraint::Subject::new(make, stations, nodes);
                constraint::checks(&subject).iter().for_each(|(name, check)| try_one(name, &mut || check(&subject)));
            })
        } else {
            let make = |spec| part.joint(&spec, &values).unwrap_or_else(|error| panic!("{}", error.message));
            let mut subject = joint::Subject::new(make).with_arms_up_to(ARMS);
            if !part.has_gradient {
                subject = subject.with_round_off(OF_DIFFERENCES);
            }
            joint::CHECKS.iter().for_each(|(name, check)| try_one(name, &mut || check(&subject)));
            Ok(())
        };
        set_hook(hook);
        tried?;
        Ok(broken)
    })
}
