//! Finds, checks and loads plugins. A plugin's mistake becomes a fault that names the plugin.
//!
//! A plugin is native code: once loaded, it can do whatever this process can do. Only files that the caller names are
//! loaded.
//!
//! Steps of loading: [`Plugins::load`] opens the library; `handshake` checks its entry before anything in it is called;
//! `describe` reads its kinds; `proxy` turns them into constraints, `joint` into joint models and `rod` into rods, with
//! the same interface as the built-in ones. Every call goes through `instance` and `call`, which record what each
//! thread is calling for the watchdog and the signal handler (`crash_handler`).
#![allow(unsafe_code, reason = "this crate calls into libraries of others")]

mod buffers;
mod call;
mod crash_handler;
mod describe;
mod error;
mod find;
mod floating_point;
mod handshake;
mod image;
mod instance;
mod joint;
mod proxy;
mod read;
mod rod;
mod supervision;

pub use call::floating_point_changes;
pub use crash_handler::{LATE, install_crash_handler};
pub use error::{LoadError, Reason};
pub use find::{SearchPath, file_name, open_regular_file, resolve};
pub use instance::numeric_derivatives;
pub use proxy::notes;
#[cfg(unix)]
pub use supervision::record_calls;
pub use supervision::{RecordedCall, begin_record, recorded_calls};
pub use wireloom_abi::{ABI_MAJOR, ABI_MINOR, HEADER, HEADER_CPP};

use describe::{Functions, KindDescription};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use wireloom_core::Registry;

/// A loaded plugin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plugin {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// One-line description.
    pub doc: String,
    /// Path of its file.
    pub file: PathBuf,
    /// SHA-256 of the file, hexadecimal.
    pub hash: String,
    /// ABI that it was built for: major and minor version.
    pub abi: (u32, u32),
    /// Names of its kinds of constraints.
    pub constraints: Vec<String>,
    /// Names of its joint models.
    pub joints: Vec<String>,
    /// Names of its rods.
    pub rods: Vec<String>,
}

/// All plugins of this process.
#[derive(Debug, Default)]
pub struct Plugins(Vec<Plugin>);

impl Plugins {
    /// Loaded plugins, in the order of loading.
    pub fn loaded(&self) -> &[Plugin] {
        &self.0
    }

    /// Loads a library and adds its kinds to the registry. The library stays loaded until the process ends.
    ///
    /// # Errors
    /// If the file is not a plugin for this program, or a name is already in use. The registry is then unchanged.
    pub fn load(&mut self, file: &Path, registry: &mut Registry) -> Result<&Plugin, LoadError> {
        let refuse = LoadError::new(file);
        let opened = handshake::open(file).map_err(&refuse)?;
        if let Some(other) = self.0.iter().find(|other| other.name == opened.name) {
            return Err(refuse(Reason::NameTaken { name: opened.name, other: other.file.clone() }));
        }
        let taken = |kind: &&KindDescription| match kind.functions {
            Functions::Constraint(..) => registry.constraint(&kind.name).is_some(),
            Functions::Joint(_) => registry.joint(&kind.name).is_some(),
            Functions::Rod(_) => registry.rod(&kind.name).is_some(),
        };
        if let Some(kind) = opened.kinds.iter().find(taken) {
            let has = |other: &&Plugin| {
                [&other.constraints, &other.joints, &other.rods].iter().any(|names| names.contains(&kind.name))
            };
            let owner = self.0.iter().find(has);
            let owner = owner.map_or("the program itself".to_owned(), |other| {
                format!("plugin `{}` ({})", other.name, other.file.display())
            });
            return Err(refuse(Reason::KindTaken { kind: kind.name.clone(), owner }));
        }
        let plugin = Plugin {
            name: opened.name,
            version: opened.version,
            doc: opened.doc,
            file: file.to_owned(),
            hash: opened.hash,
            abi: opened.abi,
            constraints: names(&opened.kinds, |functions| matches!(functions, Functions::Constraint(..))),
            joints: names(&opened.kinds, |functions| matches!(functions, Functions::Joint(_))),
            rods: names(&opened.kinds, |functions| matches!(functions, Functions::Rod(_))),
        };
        let owner = Arc::new(format!("plugin `{}` {} ({})", plugin.name, plugin.version, file.display()));
        for kind in opened.kinds {
            // No name is in use: this was checked above.
            match kind.functions {
                Functions::Constraint(functions, ref attaches, ref outputs) => {
                    let made = (functions, attaches.clone(), outputs.clone());
                    let _ = registry.add_constraint(proxy::kind(kind, made, owner.clone(), opened.notes));
                }
                Functions::Joint(functions) => {
                    let _ = registry.add_joint(joint::kind(kind, functions, owner.clone()));
                }
                Functions::Rod(functions) => {
                    let _ = registry.add_rod(rod::kind(kind, functions, owner.clone()));
                }
            }
        }
        self.0.push(plugin);
        Ok(self.0.last().expect("one was just added"))
    }
}

/// Names of the kinds that pass a filter.
fn names(kinds: &[KindDescription], which: impl Fn(&Functions) -> bool) -> Vec<String> {
    kinds.iter().filter(|kind| which(&kind.functions)).map(|kind| kind.name.clone()).collect()
}
