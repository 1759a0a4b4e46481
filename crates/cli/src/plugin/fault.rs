//! The report of a plugin that crashed the program or did not return: it names the plugin and writes the results of
//! the run so far.

use crate::arguments::PluginFault;
use crate::failure::{Failure, Outcome};
use crate::files::results::RESULT;
use crate::files::saved::{self, Keeper, Origin};
use crate::messages::Message;
use std::io::Write;
use std::path::Path;
use wireloom::export::json;
use wireloom::plugins::LATE;
use wireloom::result::{Outcome as RunOutcome, PartFamily, PartFault};
use wireloom::session::Checkpoint;
use wireloom::{Run, Status};

/// Saves all that is computed, and returns the failure; or tells a sweep.
pub fn report(fault: &PluginFault, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let what = format!("{} (in `{}`)", fault.happened, fault.function);
    if fault.sweep {
        let late = fault.happened.starts_with(LATE);
        let message = Message::Fault { late, reason: format!("{} {what}", fault.site) };
        message.send(out).map_err(Failure::standard_output)?;
        return Ok(Outcome::Done);
    }
    let Some(folder) = fault.folder.as_deref() else { return Err(Failure::Plugin(format!("{} {what}", fault.site))) };
    let (family, name, kind, owner) = parts(&fault.site);
    let fault = PartFault {
        family,
        name: name.to_owned(),
        kind: kind.to_owned(),
        step: fault.step.clone().unwrap_or_default(),
        increment: fault.increment.unwrap_or_default(),
        message: format!("{owner} {what}"),
    };
    Err(match save(folder, RunOutcome::Fault(fault.clone())) {
        Ok(()) => Failure::Part(fault),
        Err(other) => Failure::Plugin(format!("{fault}; what was computed before cannot be written: {other}")),
    })
}

/// Family, name, kind and the rest of "constraint `tie` (cable-tie): plugin …".
fn parts(site: &str) -> (PartFamily, &str, &str, &str) {
    let parts = |family: PartFamily| {
        let (name, rest) = site.strip_prefix(family.word())?.strip_prefix(" `")?.split_once("` (")?;
        let (kind, owner) = rest.split_once("): ")?;
        Some((family, name, kind, owner))
    };
    let known = [PartFamily::Constraint, PartFamily::Joint, PartFamily::Rod].into_iter().find_map(parts);
    known.unwrap_or((PartFamily::Constraint, "", "", site))
}

/// Saves all that is computed of a run that was interrupted in a call of a plugin. It can be resumed.
pub fn interrupted(folder: &Path) -> Result<(), Failure> {
    save(folder, RunOutcome::Graded(Status::Interrupted))
}

/// Writes the result of all kept equilibria.
fn save(place: &Path, outcome: RunOutcome) -> Result<(), Failure> {
    let mut folder = saved::interrupted(place)?;
    let origin = Origin::read(&folder)?;
    let (steps, checkpoint) = Keeper::salvage(&folder)?;
    let checkpoint = checkpoint.as_ref();
    let run = Run {
        scenario: origin.scenario,
        outcome,
        notes: checkpoint.map_or(&[][..], Checkpoint::notes).to_vec(),
        events: checkpoint.map_or(&[][..], Checkpoint::events).to_vec(),
        steps,
        clearances: vec![],
        requirements: vec![],
        plugins: origin.plugins,
        identities: origin.identities.into(),
        drawn_start: None,
        sensitivities: Vec::new(),
    };
    folder.write(RESULT, |out| json::write(&run, &origin.provenance, out))
}
