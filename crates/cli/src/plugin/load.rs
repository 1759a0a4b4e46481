//! Loads the plugins that the user trusts.

use crate::arguments::Allowed;
use crate::failure::{Failure, Refusal};
use crate::plugin::crash;
use crate::plugin::trust::Trust;
use std::io::ErrorKind;
use std::path::Path;
use wireloom::Registry;
use wireloom::plugins::{LoadError, Plugin, Plugins, Reason};
use wireloom::result::Library;
use wireloom::scenario::Fault;

/// Time limit of a plugin's description where no scenario states one, s.
const LOOK_LIMIT: f64 = 10.0;
/// Loads the plugins that the scenario in `path` names, if the user trusts them.
pub fn load(path: &Path, text: &str, trust: &Trust, registry: &mut Registry) -> Result<Vec<Plugin>, Failure> {
    let wanted = wireloom::scenario::plugins(text);
    let mut plugins = Plugins::default();
    let mut faults = vec![];
    if !wanted.load.is_empty() {
        crash::prepare(wanted.time_limit);
    }
    for (name, span) in &wanted.load {
        let loaded = trust.file(name, path.parent().unwrap_or(Path::new(""))).and_then(|file| {
            plugins
                .load(&file, registry)
                .map(|_| ())
                .map_err(|error: LoadError| (error.to_string(), error.reason.help().to_owned()))
        });
        if let Err((message, help)) = loaded {
            faults.push(Fault { span: span.clone(), message, help });
        }
    }
    if faults.is_empty() {
        return Ok(plugins.loaded().to_vec());
    }
    Err(Failure::Refused(vec![Refusal { file: path.display().to_string(), text: text.to_owned(), faults }]))
}

/// Loads the plugins that are allowed by name.
pub fn load_allowed(allowed: &Allowed, registry: &mut Registry) -> Result<Plugins, Failure> {
    let mut plugins = Plugins::default();
    for file in &allowed.allow_plugin {
        crash::prepare(LOOK_LIMIT);
        plugins.load(file, registry).map_err(not_loaded)?;
    }
    Ok(plugins)
}

/// The failure of a plugin that is named on the command line. A file that is missing or cannot be read is an I/O fault,
/// one of an unsuitable kind is refused input, as for [`crate::files::load::text`].
pub fn not_loaded(error: LoadError) -> Failure {
    let help = error.reason.help();
    match error.reason {
        Reason::Unreadable(source) if source.kind() != ErrorKind::InvalidInput => {
            Failure::Io { what: format!("cannot read the plugin {}", error.file.display()), source }
        }
        _ => Failure::Input(format!("{error}\n  help: {help}")),
    }
}

/// A plugin as results record it.
pub fn record(plugin: &Plugin) -> Library {
    Library {
        name: plugin.name.clone(),
        version: plugin.version.clone(),
        file: plugin.file.display().to_string(),
        hash: plugin.hash.clone(),
    }
}
