//! What the texts of a session may name, and their faults.

use super::harness::tightens_in_first_step;
use crate::frame::number;
use crate::protocol::TextFault;
use std::sync::{Arc, Mutex, PoisonError};
use wireloom::Registry;
use wireloom::harness::ShapeFile;
use wireloom::parts::{Parameters, ShapeSpec, Value};
use wireloom::scenario::record::{Written, with_steps};
use wireloom::scenario::{Fault, Files, NoFiles, Places};
use wireloom::session::{DrivenHarness, Monitor, Refusal};

/// Largest text that is taken, bytes: a harness of some thousand branches.
pub(crate) const MAX_TEXT: usize = 4 << 20;
/// Largest file that a page may give to be imported, bytes: ten times the harness of a car as KBL. A larger one is
/// opened by its path.
pub const MAX_FILE: usize = 16 << 20;
/// Largest number of faults that are sent to a page.
const MAX_FAULTS: usize = 100;

/// The files that texts of a session may name. Texts that were read stay as they were, so that all equilibria of a run
/// have the same.
pub trait SessionFiles: Files + Send + Sync {
    /// The same files, as they are now.
    fn anew(&self) -> Arc<dyn SessionFiles>;
}

impl SessionFiles for NoFiles {
    fn anew(&self) -> Arc<dyn SessionFiles> {
        Arc::new(NoFiles)
    }
}

/// What is needed to check a text, on any thread.
pub(crate) struct Known {
    /// Those of the session's present text.
    files: Mutex<Arc<dyn SessionFiles>>,
    /// Kinds that the scenario can use.
    pub(super) registry: Registry,
}

impl Known {
    pub(super) fn new(files: Arc<dyn SessionFiles>, registry: Registry) -> Self {
        Self { files: Mutex::new(files), registry }
    }

    /// From now on texts are checked with these files.
    pub(super) fn check_with(&self, files: &Arc<dyn SessionFiles>) {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).clone_from(files);
    }

    /// The harness of a text, and the text with the step that its first equilibrium needs.
    pub(super) fn load(
        &self,
        text: &str,
        files: &dyn SessionFiles,
        monitor: &Monitor,
    ) -> Result<(String, DrivenHarness), Vec<Fault>> {
        let load = |text: &str| DrivenHarness::load(text, files, &self.registry, monitor);
        let harness = load(text)?;
        if !harness.schedule.steps.is_empty() || !tightens_in_first_step(&harness.network) {
            return Ok((text.to_owned(), harness));
        }
        // The first equilibrium of `run` then differs from the start.
        let equilibrium = Written { name: "equilibrium".to_owned(), ..Written::default() };
        let text = with_steps(text, 0, &[equilibrium]).map_err(|fault| vec![fault])?;
        let harness = load(&text)?;
        Ok((text, harness))
    }

    /// Whether the surface in a file has borders. STEP files say their unit; of others it does not matter here.
    ///
    /// # Errors
    /// Why it can be no obstacle.
    pub(crate) fn has_borders(&self, name: &str, bytes: Vec<u8>) -> Result<bool, Refusal> {
        let kind = self.registry.shape("mesh");
        let kind = kind.ok_or_else(|| Refusal::new("no kind of obstacle is a mesh", "register the shape `mesh`"))?;
        let spec = ShapeSpec { file: Some(ShapeFile { name: name.to_owned(), bytes, scale: 1.0 }) };
        let open = Parameters([("open".to_owned(), Value::Flag(true))].into());
        match (kind.build)(&spec, &Parameters::default()) {
            Ok(_) => Ok(false),
            // A sheet is none either if it cannot be read.
            Err(_) if (kind.build)(&spec, &open).is_ok() => Ok(true),
            Err(error) => Err(Refusal::new(error.message, error.help)),
        }
    }

    /// The faults of a text; none if it is valid.
    pub(crate) fn check(&self, text: &str) -> Vec<Fault> {
        if text.len() > MAX_TEXT {
            return vec![too_large(text)];
        }
        // Not locked while it is checked.
        let files = self.files.lock().unwrap_or_else(PoisonError::into_inner).clone();
        wireloom::load_with_files(text, &*files, &self.registry).err().unwrap_or_default()
    }
}

/// The place of a fault as pages count it.
pub(crate) fn text_faults(text: &str, faults: &[Fault]) -> Vec<TextFault> {
    let places = Places::of(text);
    let units = |at: usize| {
        let before = &text[..text.floor_char_boundary(at.min(text.len()))];
        number(before.encode_utf16().count())
    };
    let fault = |fault: &Fault| {
        let (line, column) = places.position(fault.span.start);
        TextFault {
            from: units(fault.span.start),
            to: units(fault.span.end.max(fault.span.start)),
            line: number(line),
            column: number(column),
            message: fault.message.clone(),
            help: fault.help.clone(),
        }
    };
    faults.iter().take(MAX_FAULTS).map(fault).collect()
}

pub(super) fn too_large(text: &str) -> Fault {
    Fault {
        span: 0..0,
        message: format!("the text has {} bytes", text.len()),
        help: format!("edit a scenario of more than {MAX_TEXT} bytes in an editor, and load it anew"),
    }
}
