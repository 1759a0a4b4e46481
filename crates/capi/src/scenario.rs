//! Scenarios: a text, and the files that it names.

use crate::call::{WireloomError, call};
use crate::failure::{Failure, WireloomCode};
use crate::files::{self, Files};
use crate::handles;
use crate::pointers::{self, SizedStruct};
use crate::text::{self, WireloomText};
use serde_json::Value as Json;
use std::ffi::c_char;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use wireloom::scenario::fault::did_you_mean;
use wireloom::scenario::{Built, Fault, Scenario, record};
use wireloom::session::Monitor;
use wireloom::{Registry, mesh};

/// What the handle is called.
const WHAT: &str = "scenario";

/// A scenario: a text and its files. Other handles that were made of it do not change with it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomScenario {
    /// 0: none.
    pub id: u64,
}

/// A body of the surroundings, with the triangles of its surface.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomBody {
    /// sizeof(WireloomBody), set by the caller.
    pub size: usize,
    /// Its name, which no other body has.
    pub name: *const c_char,
    /// Corners, m, in the axes of the body: three numbers for each.
    pub corners: *const f64,
    /// Number of corners.
    pub corner_count: usize,
    /// Triangles: three indices of corners for each, from 0, counter-clockwise as seen from outside. The surface is
    /// closed.
    pub triangles: *const u32,
    /// Number of triangles.
    pub triangle_count: usize,
    /// Its position at the start, m.
    pub position: [f64; 3],
    /// Its orientation at the start: quaternion w, x, y, z of any length but zero.
    pub orientation: [f64; 4],
    /// Coefficient of Coulomb friction; 0 is smooth.
    pub friction: f64,
    /// Required clearance of cables, m; NaN: none.
    pub min_clearance: f64,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomBody {}

/// A scenario as text, with what is needed to read it.
#[derive(Clone)]
pub struct Source {
    pub text: String,
    pub files: Files,
}

/// What the handle stands for.
struct Kept(Mutex<Source>);

impl Kept {
    fn lock(&self) -> MutexGuard<'_, Source> {
        // A text is changed in one assignment.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A copy of a scenario as it is now.
pub fn source(scenario: WireloomScenario) -> Result<Source, Failure> {
    Ok(handles::get::<Kept>(scenario.id, WHAT)?.lock().clone())
}

impl Source {
    /// Refuses a text that loads plugins.
    pub fn refuse_plugins(&self) -> Result<(), Vec<Fault>> {
        let Some((name, span)) = wireloom::scenario::plugins(&self.text).load.into_iter().next() else {
            return Ok(());
        };
        let message = format!("the C library does not load plugins yet, so \"{name}\" is not loaded");
        let help = "carry the scenario out with the command line: wireloom run".to_owned();
        Err(vec![Fault { span, message, help }])
    }

    /// Reads, checks and builds it.
    pub fn load(&self, registry: &Registry) -> Result<(Scenario, Built), Vec<Fault>> {
        self.refuse_plugins()?;
        wireloom::load_with_files(&self.text, &self.files, registry)
    }

    /// The same, on the mesh that its accuracy asks for.
    pub fn load_with_mesh(&self, registry: &Registry, monitor: &Monitor) -> Result<(Scenario, Built), Failure> {
        self.load(registry)
            .and_then(|(scenario, built)| mesh::by_accuracy(scenario, built, registry, monitor))
            .map_err(|faults| Failure::refused(&self.text, &faults))
    }

    /// The same scenario with another value of a key.
    pub fn with_value(&self, key: &str, json: &str, registry: &Registry) -> Result<String, Failure> {
        let value = value_of(key, json)?;
        // This fails if the text is not TOML, and then only.
        record::with_markers(&self.text, &[]).map_err(|fault| Failure::refused(&self.text, &[fault]))?;
        record::with_json(&self.text, key, &value, registry).map_err(|fault| not_set(&self.text, &value, &fault))
    }

    /// Adds a body: an entry of the text, and a file with its surface.
    fn add_body(&mut self, body: &WireloomBody) -> Result<(), Failure> {
        let WireloomBody { position, orientation, friction, min_clearance, .. } = *body;
        let name = pointers::text(body.name, "name")?;
        let triangles = pointers::list(body.triangles, 3 * body.triangle_count.min(usize::MAX / 3), "triangles")?;
        let corners = pointers::list(body.corners, 3 * body.corner_count.min(usize::MAX / 3), "corners")?;
        let given = corners.iter().chain(&position).chain(&orientation).chain([&friction]);
        if !given.clone().all(|x| x.is_finite()) || min_clearance.is_infinite() {
            return Err(Failure::value(format!("body \"{name}\" has numbers that are not finite"), "give finite ones"));
        }
        if record::rotation(orientation).is_none() {
            let message = format!("{orientation:?} is not an orientation of body \"{name}\"");
            return Err(Failure::value(message, "give a quaternion [w, x, y, z] that is not zero"));
        }
        if let Some(beyond) = triangles.iter().find(|k| **k as usize >= body.corner_count) {
            let message = format!("body \"{name}\": there is no corner {beyond}");
            return Err(Failure::not_found(message, format!("corners are 0 to {}", body.corner_count.max(1) - 1)));
        }
        let file = format!("{name}.obj");
        let bodies = record::value_at(&self.text, "obstacles").unwrap_or_default();
        let same = |own: &Json| own["name"] == *name || own["mesh"] == *file;
        if self.files.held(&file).is_some() || bodies.as_array().is_some_and(|bodies| bodies.iter().any(same)) {
            let message = format!("there is a body \"{name}\" or a file \"{file}\"");
            return Err(Failure::value(message, "give it another name"));
        }
        let mut obj = String::new();
        corners.chunks(3).for_each(|c| writeln!(obj, "v {} {} {}", c[0], c[1], c[2]).unwrap_or_default());
        let one = |k: u32| u64::from(k) + 1;
        triangles
            .chunks(3)
            .for_each(|t| writeln!(obj, "f {} {} {}", one(t[0]), one(t[1]), one(t[2])).unwrap_or_default());
        let line = if self.text.ends_with('\n') { "" } else { "\n" };
        let mut entry = format!(
            "{line}\n[[obstacles]]\nname = {}\nmesh = {}\nposition = {position:?}\norientation = {orientation:?}\n",
            quoted(name),
            quoted(&file),
        );
        if friction != 0.0 {
            entry += &format!("friction = {friction:?}\n");
        }
        if !min_clearance.is_nan() {
            entry += &format!("min_clearance = {min_clearance:?}\n");
        }
        let text = format!("{}{entry}", self.text);
        self.files.hold_body(file, obj.into_bytes());
        self.text = text;
        Ok(())
    }
}

/// The value that a key is to have.
pub fn value_of(key: &str, json: &str) -> Result<Json, Failure> {
    serde_json::from_str(json)
        .map_err(|error| Failure::value(format!("the value of `{key}` is not JSON: {error}"), "write JSON"))
}

/// Why a key of a text in TOML could not be set to a value: there is no such key, or no such value.
pub fn not_set(text: &str, value: &Json, fault: &Fault) -> Failure {
    let code = if in_toml(value) { WireloomCode::NotFound } else { WireloomCode::BadValue };
    Failure::of_fault(code, text, fault)
}

/// Whether TOML has such a value: it lacks null, and whole numbers of more than 64 bits with their sign.
fn in_toml(value: &Json) -> bool {
    match value {
        Json::Null => false,
        Json::Number(number) => number.is_i64() || !number.is_u64(),
        Json::Array(list) => list.iter().all(in_toml),
        Json::Object(table) => table.values().all(in_toml),
        Json::Bool(_) | Json::String(_) => true,
    }
}

/// The absolute path of a folder or a file, for a host that goes to another folder later.
fn absolute(path: &str) -> Result<PathBuf, Failure> {
    // An empty path is where the host is, too.
    std::path::absolute(Path::new(".").join(path)).map_err(|error| {
        let message = format!("`{path}` has no absolute path: {error}");
        Failure::new(WireloomCode::System, message, "give an absolute path")
    })
}

/// A text as TOML has it.
fn quoted(text: &str) -> String {
    // Strings of JSON are strings of TOML, but for one character.
    Json::from(text).to_string().replace('\u{7f}', "\\u007f")
}

/// Makes a scenario of a text, which is not checked yet.
///
/// `text` has `length` bytes, in UTF-8, without a 0 at the end. `folder` is that of the files which the text names; a
/// null pointer: it names no files but those that are added. A relative one is relative to where the host is now.
/// wireloom_scenario_read does the same with a file.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_scenario_new(
    text: *const c_char,
    length: usize,
    folder: *const c_char,
    scenario: *mut WireloomScenario,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        pointers::place(scenario, "scenario")?;
        let text = pointers::text_of_length(text, length, "text")?.to_owned();
        let folder = pointers::text_if_given(folder, "folder")?.map(absolute).transpose()?;
        let id = handles::new(Kept(Mutex::new(Source { text, files: Files::new(folder) })));
        pointers::put(scenario, "scenario", WireloomScenario { id })
    })
}

/// Makes a scenario of a file, which is not checked yet. The files that it names are looked for beside it.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_scenario_read(
    path: *const c_char,
    scenario: *mut WireloomScenario,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        pointers::place(scenario, "scenario")?;
        let given = pointers::text(path, "path")?;
        let path = absolute(given)?;
        let bytes = files::read_text(&path).map_err(|error| {
            let message = format!("cannot read {given}: {error}");
            Failure::new(WireloomCode::System, message, "give the path of a scenario's file")
        })?;
        let text = pointers::utf8(&bytes, given)?.to_owned();
        let folder = path.parent().map(Path::to_path_buf);
        let id = handles::new(Kept(Mutex::new(Source { text, files: Files::new(folder) })));
        pointers::put(scenario, "scenario", WireloomScenario { id })
    })
}

/// Adds a file that the text may name. It goes before one of that name in the folder, and replaces one that was added
/// before; the surface of a body it does not.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_scenario_add_file(
    scenario: WireloomScenario,
    name: *const c_char,
    bytes: *const u8,
    count: usize,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = handles::get::<Kept>(scenario.id, WHAT)?;
        let name = pointers::text(name, "name")?.to_owned();
        let bytes = pointers::list(bytes, count, "bytes")?.to_vec();
        let mut source = kept.lock();
        if source.files.is_body(&name) {
            return Err(Failure::value(format!("\"{name}\" is the surface of a body"), "give it another name"));
        }
        source.files.hold(name, bytes);
        Ok(())
    })
}

/// Adds a body of the surroundings: an entry of `[[obstacles]]` at the end of the text. Its surface is a file that the
/// scenario keeps. The text and the scenario have no body or file of that name yet.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_scenario_add_body(
    scenario: WireloomScenario,
    body: *const WireloomBody,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = handles::get::<Kept>(scenario.id, WHAT)?;
        let body = pointers::given(body, "body")?;
        let body = body.ok_or_else(|| Failure::new(WireloomCode::NullPointer, "`body` is null", "give a pointer"))?;
        kept.lock().add_body(&body)
    })
}

/// Sets the value of a key, such as "branches.left.length" or "joints.J.model", to a value in JSON, such as "0.41",
/// "\"410 mm\"" or "\"fused\"". Comments of the text stay. WIRELOOM_CODE_NOT_FOUND: there is no such key;
/// WIRELOOM_CODE_BAD_VALUE: it is not JSON, or has a null; WIRELOOM_CODE_REFUSED: the text is not TOML.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_scenario_set(
    scenario: WireloomScenario,
    key: *const c_char,
    json: *const c_char,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = handles::get::<Kept>(scenario.id, WHAT)?;
        let (key, json) = (pointers::text(key, "key")?, pointers::text(json, "json")?);
        let mut source = kept.lock();
        source.text = source.with_value(key, json, &wireloom::registry())?;
        Ok(())
    })
}

/// The text, as it is now.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_scenario_text(
    scenario: WireloomScenario,
    text: *mut WireloomText,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        pointers::place(text, "text")?;
        text::hand_over(source(scenario)?.text.into_bytes(), text)
    })
}

/// The bytes of a file that the scenario keeps: one that was added, or "NAME.obj" with the surface of the body NAME. A
/// text that is saved needs them beside it.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_scenario_file(
    scenario: WireloomScenario,
    name: *const c_char,
    bytes: *mut WireloomText,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        pointers::place(bytes, "bytes")?;
        let name = pointers::text(name, "name")?;
        let files = source(scenario)?.files;
        let held = files.held(name).ok_or_else(|| {
            let message = format!("the scenario keeps no file \"{name}\"");
            Failure::not_found(message, did_you_mean(name, files.names()))
        })?;
        text::hand_over(held.to_vec(), bytes)
    })
}

/// Frees a scenario. What was made of it stays.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_scenario_free(scenario: WireloomScenario) -> WireloomCode {
    call(std::ptr::null_mut(), || handles::free::<Kept>(scenario.id, WHAT))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_absolute() {
        let own = std::env::current_dir().ok();
        assert_eq!(absolute("").ok(), own);
        assert_eq!(absolute("./a.toml").ok(), own.map(|own| own.join("a.toml")));
        assert_eq!(absolute("/a/b").ok(), Some(PathBuf::from("/a/b")));
    }
}
