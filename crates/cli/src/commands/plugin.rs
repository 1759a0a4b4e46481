//! `wireloom plugin`: lists plugins, makes new ones, checks them.

use crate::arguments::PluginTask;
use crate::failure::{Failure, Outcome};
use crate::plugin::describe::{describe, describe_joint, describe_rod};
use crate::plugin::load::record;
use crate::plugin::{check, crash, new, trust};
use crate::print::text::printable;
use std::io::Write;
use wireloom::plugins::Plugins;

/// Carries out a task.
pub fn plugin(task: &PluginTask, out: &mut dyn Write) -> Result<Outcome, Failure> {
    match task {
        PluginTask::New { name, kind, c, cpp, sources } => {
            let language = match (c, cpp) {
                (true, _) => new::Language::C,
                (false, true) => new::Language::Cpp,
                (false, false) => new::Language::Rust,
            };
            new::new(name, *kind, language, sources.as_deref(), out)
        }
        PluginTask::Check { file, time_limit } => check::check(file, *time_limit, out),
        PluginTask::List => list(out),
    }
}

/// All plugins of the search path; one that cannot be loaded is listed with the reason.
fn list(out: &mut dyn Write) -> Result<Outcome, Failure> {
    let folders = trust::search_path();
    let files = folders.libraries().map_err(|(folder, error)| Failure::io("read the folder", &folder)(error))?;
    let mut print = || {
        if folders.0.is_empty() {
            return writeln!(
                out,
                "the search path is empty: \
                 name folders in WIRELOOM_PLUGINS, or make .wireloom/plugins in your home folder"
            );
        }
        if files.is_empty() {
            let folders: Vec<String> = folders.0.iter().map(|folder| folder.display().to_string()).collect();
            return writeln!(out, "no plugins in {}", folders.join(", "));
        }
        let mut loaded = Plugins::default();
        for file in &files {
            crash::prepare(10.0);
            let mut registry = wireloom::registry();
            match loaded.load(file, &mut registry) {
                Ok(plugin) => {
                    let record = record(plugin);
                    writeln!(out, "{}: {}", printable(&record.to_string()), printable(&plugin.doc))?;
                    for kind in plugin.constraints.iter().filter_map(|name| registry.constraint(name)) {
                        describe(kind, out)?;
                    }
                    for kind in plugin.joints.iter().filter_map(|name| registry.joint(name)) {
                        describe_joint(kind, out)?;
                    }
                    for kind in plugin.rods.iter().filter_map(|name| registry.rod(name)) {
                        describe_rod(kind, out)?;
                    }
                }
                Err(error) => writeln!(out, "{}\n  {}", printable(&error.to_string()), error.reason.help())?,
            }
            writeln!(out)?;
        }
        Ok(())
    };
    print().map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}
