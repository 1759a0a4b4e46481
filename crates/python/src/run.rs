//! Runs: carried out in a thread of their own, or read from a folder.

use crate::failure::{Failure, interrupted};
use crate::files::{Made, PROGRAM, Recipe};
use crate::parts;
use crate::result::Step;
use crate::source::{Loaded, Source};
use crate::table::Table;
use crate::worker::{attend, caught, guarded, spawn};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wireloom::export::fields;
use wireloom::export::json::{self, Opened};
use wireloom::export::picture::{self, Drawing};
use wireloom::result::{Event, EventPlace, Moment, RequirementResult};
use wireloom::sensitivity::{Source as Study, add_sensitivities};
use wireloom::session::{Checkpoint, Monitor, Observer, Progress};
use wireloom::{Control, StepResult};
use wireloom_studio::protocol::Scene;
use wireloom_studio::replay::Recorder;
use wireloom_studio::{PAGE, scene};

/// Handle of a run.
#[pyclass(frozen, module = "wireloom._wireloom")]
pub struct Run {
    run: Arc<wireloom::Run>,
    origin: Origin,
}

/// Where a run comes from.
enum Origin {
    /// It was carried out here.
    Here { recipe: Box<Recipe>, made: Made, scene: Box<Scene> },
    /// It is read from this `result.json`, and the file with the fields of its nodes, as equilibria are asked for.
    File { path: PathBuf, opened: Box<Mutex<Opened<File>>> },
}

/// What a computing thread tells the calling one.
enum Message {
    /// An increment has ended.
    Increment { progress: Progress, end: Option<Box<StepResult>>, reply: SyncSender<Control> },
    /// The run has ended.
    End(Box<Result<Run, Failure>>),
}

/// The observer of a run: hands increments to the calling thread and waits for its decision.
struct Watcher {
    messages: Sender<Message>,
    monitor: Monitor,
    /// Whether equilibria are asked for.
    ends: bool,
    /// Whether anything is asked for.
    watched: bool,
    /// What its files need of every increment.
    made: Made,
    recipe: Option<Box<Recipe>>,
}

impl Observer for Watcher {
    fn increment(&mut self, progress: &Progress, end: &StepResult, _: bool) -> Control {
        if let Some(recipe) = &self.recipe {
            self.made.see(recipe, progress, end);
        }
        if !self.watched {
            return Control::Continue;
        }
        let (reply, answer) = sync_channel(1);
        let end = self.ends.then(|| Box::new(end.clone()));
        let sent = self.messages.send(Message::Increment { progress: progress.clone(), end, reply });
        // Without a calling thread nobody wants the rest.
        if sent.is_err() { Control::Stop } else { answer.recv().unwrap_or(Control::Stop) }
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        if let Some(recipe) = &self.recipe {
            self.made.begin(recipe, checkpoint);
        }
    }

    fn monitor(&self) -> Monitor {
        self.monitor.clone()
    }
}

/// Reads, checks and carries out a scenario.
fn carry_out(source: &Source, watcher: &mut Watcher) -> Result<Run, Failure> {
    let Loaded { scenario, built, texts, hashed, registry, files } = source.load_with_mesh(&watcher.monitor)?;
    let asked = scenario.output.sensitivities;
    watcher.recipe = Some(Box::new(Recipe::of(&scenario, &built, texts, &hashed)));
    let schedule = &built.schedule;
    let scene = Box::new(scene::of(schedule, PROGRAM, &built.network));
    let mut run = wireloom::run_observed(built, None, watcher);
    run.plugins.extend(parts::libraries(&source.parts));
    run.drawn_start = wireloom::compare_with_drawn_start(&scenario, &run, &registry, &watcher.monitor);
    if asked {
        let study = Study { monitor: watcher.monitor.clone(), ..Study::new(&source.text, &files, &registry) };
        add_sensitivities(&mut run, study);
    }
    let lost = || Failure::Internal("the files of the run are lost".to_owned());
    let recipe = watcher.recipe.take().ok_or_else(lost)?;
    let mut made = std::mem::take(&mut watcher.made);
    made.finish(&recipe, &watcher.monitor);
    Ok(Run { run: Arc::new(run), origin: Origin::Here { recipe, made, scene } })
}

/// Carries out a scenario. `progress` is called with step, its number and the number of steps, increment and number of
/// increments; `on_increment` with the `Step`, and stops the run if it returns `False`. Both are called in the calling
/// thread.
#[pyfunction]
pub fn run(
    py: Python<'_>,
    source: Source,
    progress: Option<Py<PyAny>>,
    on_increment: Option<Py<PyAny>>,
) -> PyResult<Run> {
    let monitor = Monitor::default();
    let (messages, received) = channel();
    let mut watcher = Watcher {
        messages: messages.clone(),
        monitor: monitor.clone(),
        ends: on_increment.is_some(),
        watched: progress.is_some() || on_increment.is_some(),
        made: Made::default(),
        recipe: None,
    };
    spawn(move || {
        let ended = caught(|| carry_out(&source, &mut watcher)).flatten();
        // The calling thread waits for this.
        let _ = messages.send(Message::End(Box::new(ended)));
    })?;
    let mut ended = None;
    let outcome = attend(py, received, &monitor, |message| match message {
        Message::End(run) => {
            ended = Some(*run);
            Ok(())
        }
        Message::Increment { progress: now, end, reply } => {
            let asked = || {
                if let Some(progress) = &progress {
                    progress.call1(py, (now.step, now.step_index, now.steps, now.increment, now.increments))?;
                }
                match (&on_increment, end) {
                    (Some(call), Some(end)) => {
                        let answer = call.call1(py, (Step::alone(*end),))?;
                        Ok(if answer.is(&*py_false(py)) { Control::Stop } else { Control::Continue })
                    }
                    _ => Ok(Control::Continue),
                }
            };
            let control: PyResult<Control> = asked();
            // A computation that waits for no answer has ended.
            let _ = reply.send(*control.as_ref().unwrap_or(&Control::Stop));
            control.map(|_| ())
        }
    });
    let ran = ended.unwrap_or_else(|| Err(Failure::Internal("the run has vanished".to_owned())));
    match (outcome, ran) {
        // The run so far is kept in the exception.
        (Err(error), Ok(ran)) if error.is_instance_of::<pyo3::exceptions::PyKeyboardInterrupt>(py) => {
            Err(interrupted(py, Bound::new(py, ran)?.into_any()))
        }
        (Err(error), _) => Err(error),
        (Ok(()), ran) => Ok(ran?),
    }
}

fn py_false(py: Python<'_>) -> Bound<'_, pyo3::types::PyBool> {
    pyo3::types::PyBool::new(py, false).to_owned()
}

/// Opens the run of a folder, or of a `result.json`.
#[pyfunction]
pub fn open(py: Python<'_>, path: PathBuf) -> PyResult<Run> {
    guarded(py, || {
        let path = if path.is_dir() { path.join(json::FILE) } else { path };
        let file = File::open(&path).map_err(Failure::io("read", &path))?;
        let beside = path.with_file_name(fields::FILE);
        let mut lacking = None;
        let opened = Opened::open(file, || {
            File::open(&beside).inspect_err(|error| lacking = Some(io::Error::new(error.kind(), error.to_string())))
        });
        let mut opened = opened.map_err(|error| match lacking {
            Some(error) => Failure::io("read", &beside)(error),
            None => unreadable(&path)(error),
        })?;
        let path = std::path::absolute(&path).map_err(Failure::io("find", &path))?;
        let none = wireloom::Run { steps: vec![], ..opened.run.clone() };
        let run = Arc::new(std::mem::replace(&mut opened.run, none));
        Ok(Run { run, origin: Origin::File { path, opened: Box::new(Mutex::new(opened)) } })
    })
}

/// Why the result in this file cannot be read.
fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> Failure {
    move |error| match error.kind() {
        io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => {
            Failure::Result(format!("{} is no result of this version: {error}", path.display()))
        }
        _ => Failure::io("read", path)(error),
    }
}

/// A file that appears whole or not at all.
fn write_whole(path: &Path, content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), Failure> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    // Two processes may write at the same time.
    let partial = path.with_file_name(format!(".{name}.{}.partial", std::process::id()));
    let attempt = || {
        let mut out = BufWriter::new(File::create(&partial)?);
        content(&mut out)?;
        out.flush()?;
        out.get_ref().sync_all()?;
        fs::rename(&partial, path)
    };
    attempt().map_err(|error| {
        // What is incomplete goes; the first error is reported.
        let _ = fs::remove_file(&partial);
        Failure::io("write", path)(error)
    })
}

/// Writes a file of this name, which may lead into folders below.
fn below(
    folder: &Path,
    name: &str,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<PathBuf, Failure> {
    let path = folder.join(name);
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent).map_err(Failure::io("make the folder", parent))?;
    }
    write_whole(&path, content)?;
    Ok(path)
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A panic while an equilibrium is read leaves nothing half done.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Run {
    /// Whether it was read from two files.
    fn has_fields_apart(&self) -> bool {
        matches!(&self.origin, Origin::File { opened, .. } if locked(opened).has_fields_apart())
    }
}

/// One write at a time: threads share the name of the incomplete file.
static WRITING: Mutex<()> = Mutex::new(());

type Place = (Option<String>, Option<String>, Option<String>, Option<f64>, Option<String>, Option<f64>, String);
type At = (String, usize, usize);

/// Constraint, obstacle, branch, s (m), other branch, other s (m), and all of it in words.
fn place(own: &EventPlace) -> Place {
    let EventPlace { constraint, obstacle, branch, s, other_branch, other_s } = own.clone();
    (constraint, obstacle, branch, s, other_branch, other_s, own.to_string())
}

/// Step, its index from 0, and increment from 1.
fn at(moment: &Moment) -> At {
    (moment.step.clone(), moment.step_index, moment.increment)
}

#[pymethods]
impl Run {
    #[getter]
    fn scenario(&self) -> &str {
        &self.run.scenario
    }

    #[getter]
    fn status(&self) -> &'static str {
        self.run.status().word()
    }

    #[getter]
    fn verdict(&self) -> &'static str {
        self.run.verdict().word()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.run.notes.clone()
    }

    /// Part numbers and the like, as JSON.
    fn identities(&self) -> PyResult<String> {
        serde_json::to_string(&*self.run.identities).map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    /// The fault of a part that ended the run early, in words.
    #[getter]
    fn fault(&self) -> Option<String> {
        self.run.fault().map(ToString::to_string)
    }

    /// Number of the equilibria that were kept.
    fn step_count(&self) -> usize {
        match &self.origin {
            Origin::Here { .. } => self.run.steps.len(),
            Origin::File { opened, .. } => locked(opened).len(),
        }
    }

    /// An equilibrium that was kept, by its number from 0; read from the file for each call.
    fn step(&self, py: Python<'_>, index: usize) -> PyResult<Option<Step>> {
        match &self.origin {
            Origin::Here { .. } => Ok((index < self.run.steps.len()).then(|| Step::of_run(&self.run, index))),
            Origin::File { path, opened } => guarded(py, || {
                let end = locked(opened).step(index).map_err(unreadable(path))?;
                Ok(end.map(Step::alone))
            }),
        }
    }

    /// Kind, place, first, worst and last increment, number of increments, value, limit, message of every event.
    #[expect(clippy::type_complexity, reason = "a row of a table, which Python names")]
    fn events(&self) -> Vec<(&'static str, Place, At, At, At, usize, Option<f64>, Option<f64>, String)> {
        let of = |own: &Event| {
            let Event { kind, place: own_place, first, worst, last, increments, value, limit, message } = own;
            let message = message.clone();
            (kind.word(), place(own_place), at(first), at(worst), at(last), *increments, *value, *limit, message)
        };
        self.run.events.iter().map(of).collect()
    }

    /// Name, quantity, unit, severity, verdict, worst value, limit, bound, margin, error, increment, place, origin,
    /// because and reason: two tuples for every requirement.
    #[expect(clippy::type_complexity, reason = "a row of a table, which Python names")]
    fn requirements(
        &self,
    ) -> Vec<(
        (String, &'static str, &'static str, &'static str, &'static str, Option<f64>, f64, &'static str),
        (Option<f64>, Option<f64>, Option<At>, Place, &'static str, Option<String>, Option<String>),
    )> {
        let of = |own: &RequirementResult| {
            let moment = own.moment.as_ref().map(at);
            let (measure, because, reason) = (own.measure, own.because.clone(), own.reason.clone());
            let (severity, verdict, bound) = (own.severity.word(), own.verdict.word(), own.bound.word());
            (
                (own.name.clone(), measure.word(), measure.unit(), severity, verdict, own.worst, own.limit, bound),
                (own.margin(), own.error, moment, place(&own.place), own.origin.word(), because, reason),
            )
        };
        self.run.requirements.iter().map(of).collect()
    }

    /// The events as a table of Arrow.
    fn event_table(&self) -> PyResult<Table> {
        Table::events(&self.run)
    }

    /// The requirements as a table of Arrow.
    fn requirement_table(&self) -> PyResult<Table> {
        Table::requirements(&self.run)
    }

    /// Writes the files that `[output]` asks for into a folder, which is made where it is missing; returns their
    /// paths, `result.json` last, and a remark. `machine` and `written`: the machine and the time, as the report states
    /// them.
    fn save(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        machine: &str,
        written: &str,
    ) -> PyResult<(Vec<PathBuf>, Option<String>)> {
        guarded(py, || {
            fs::create_dir_all(&folder).map_err(Failure::io("make the folder", &folder))?;
            let _one = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
            let (mut paths, mut remark) = (vec![], None);
            match &self.origin {
                Origin::Here { recipe, made, .. } => {
                    for (name, bytes) in &made.files {
                        let bytes = bytes.as_ref().map_err(|error| Failure::Result(format!("{name}: {error}")))?;
                        paths.push(below(&folder, name, |out| out.write_all(bytes))?);
                    }
                    remark.clone_from(&made.remark);
                    let ended = recipe.ended(&self.run, made, machine, written);
                    for format in recipe.asked() {
                        for file in format.at_end(&ended) {
                            let name = file.name.clone();
                            paths.push(below(&folder, &name, |out| file.write(out))?);
                        }
                    }
                }
                Origin::File { path, .. } => {
                    for name in [fields::FILE, json::FILE] {
                        let from = if name == json::FILE { path.clone() } else { path.with_file_name(name) };
                        if name == fields::FILE && !self.has_fields_apart() {
                            continue;
                        }
                        let mut from_file = File::open(&from).map_err(Failure::io("read", &from))?;
                        paths.push(below(&folder, name, |out| io::copy(&mut from_file, out).map(|_| ()))?);
                    }
                }
            }
            paths.sort_by_key(|path| path.ends_with(json::FILE));
            Ok((paths, remark))
        })
    }

    /// The picture of an equilibrium as SVG; `None` where there is no step of this number.
    fn picture(&self, py: Python<'_>, step: usize) -> PyResult<Option<String>> {
        guarded(py, || {
            let read;
            let end = match &self.origin {
                Origin::Here { .. } => self.run.steps.get(step),
                Origin::File { path, opened } => {
                    read = locked(opened).step(step).map_err(unreadable(path))?;
                    read.as_ref()
                }
            };
            let Some(end) = end else { return Ok(None) };
            let obstacles = match &self.origin {
                Origin::Here { recipe, .. } => recipe.obstacles(),
                Origin::File { .. } => &[],
            };
            let drawing =
                Drawing { step: end, obstacles, title: &self.run.scenario, run: Some(&self.run), of_step: None };
            let mut svg = Vec::new();
            picture::write(&drawing, &mut svg).map_err(|error| Failure::Result(error.to_string()))?;
            Ok(Some(String::from_utf8_lossy(&svg).into_owned()))
        })
    }

    /// A page that plays the run; `None` for a run that was read from a file, which has no scene.
    fn page(&self, py: Python<'_>) -> PyResult<Option<String>> {
        guarded(py, || {
            let Origin::Here { scene, .. } = &self.origin else { return Ok(None) };
            let mut recorder = Recorder::new((**scene).clone());
            self.run.steps.iter().for_each(|step| recorder.record(step));
            Ok(Some(recorder.finish(&self.run).page(PAGE)))
        })
    }
}
