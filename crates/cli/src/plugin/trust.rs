//! Trust in plugins. A plugin is native code: it is loaded only where the user trusts it.

use crate::arguments::Allowed;
use crate::interrupt;
use std::path::{Path, PathBuf};
use wireloom::Registry;
use wireloom::gpu::{Batch, SharedDevice};
use wireloom::plugins::{SearchPath, resolve};

/// Environment variable with the folders of the search path.
const PATH: &str = "WIRELOOM_PLUGINS";

/// The folders of the search path that exist: those of the variable, then that of the user's home.
pub fn search_path() -> SearchPath {
    let mut folders = std::env::var_os(PATH).map(|path| SearchPath::of(&path)).unwrap_or_default();
    folders.0.extend(std::env::home_dir().map(|home| home.join(".wireloom/plugins")));
    folders.0.retain(|folder| folder.is_dir());
    folders
}

fn devices(allowed: &Allowed) -> SharedDevice {
    SharedDevice::for_single_runs(allowed.device.as_deref())
}

/// Plugins that the user trusts, and the device.
pub struct Trust {
    folders: Option<SearchPath>,
    allowed: Vec<PathBuf>,
    devices: SharedDevice,
}

impl Trust {
    /// The search path, and what is allowed besides.
    pub fn to_run(allowed: &Allowed) -> Self {
        Self { folders: Some(search_path()), allowed: allowed.allow_plugin.clone(), devices: devices(allowed) }
    }

    /// Only what is allowed by name.
    pub fn to_check(allowed: &Allowed) -> Self {
        Self { folders: None, allowed: allowed.allow_plugin.clone(), devices: devices(allowed) }
    }

    /// The same, for many harnesses at a time.
    pub fn for_batches(self) -> Self {
        Self { devices: self.devices.for_batches(), ..self }
    }

    /// The batch that brings them to the device together.
    pub fn batch(&self) -> &Batch {
        self.devices.batch()
    }

    /// The built-in kinds, on the chosen device.
    pub fn registry(&self) -> Registry {
        wireloom::registry_on(self.devices.clone(), interrupt::monitor())
    }

    /// The file of the plugin that a scenario in `folder` calls `wanted`, or message and help.
    pub fn file(&self, wanted: &str, folder: &Path) -> Result<PathBuf, (String, String)> {
        let is_name = Path::new(wanted).file_name().is_some_and(|name| name == wanted);
        let searched = self.folders.as_ref().filter(|_| is_name).and_then(|folders| folders.find(wanted));
        let Some(file) = searched.or_else(|| self.allowed_by_name(wanted)).or_else(|| resolve(&folder.join(wanted)))
        else {
            return Err(self.nowhere(wanted, folder, is_name));
        };
        let same = |other: &PathBuf| {
            other.canonicalize().is_ok_and(|other| file.canonicalize().is_ok_and(|file| file == other))
        };
        if self.folders.as_ref().is_some_and(|folders| folders.contains(&file)) || self.allowed.iter().any(same) {
            return Ok(file);
        }
        let file = file.display();
        let where_ = if self.folders.is_some() { ": it is not in the search path" } else { " here" };
        Err((
            format!("plugin \"{wanted}\" ({file}) is not loaded{where_}"),
            format!("it is native code, which may do whatever you may: if you trust it, add --allow-plugin {file}"),
        ))
    }

    /// An allowed file of this name.
    fn allowed_by_name(&self, name: &str) -> Option<PathBuf> {
        self.allowed.iter().find(|file| resolve(&file.with_file_name(name)).as_ref() == Some(file)).cloned()
    }

    fn nowhere(&self, wanted: &str, folder: &Path, is_name: bool) -> (String, String) {
        let Some(folders) = self.folders.as_ref() else {
            let message = format!("plugin \"{wanted}\" is not loaded here, so its kinds are not known");
            return (message, "if you trust it, give its library: --allow-plugin FILE".into());
        };
        let mut places: Vec<String> =
            if is_name { folders.0.iter().map(|f| f.display().to_string()).collect() } else { vec![] };
        places.push(folder.join(wanted).display().to_string());
        let help = format!(
            "give the path of its library from the scenario's folder, or put it into a folder that {PATH} names"
        );
        (format!("there is no plugin \"{wanted}\"; looked for in {}", places.join(", ")), help)
    }
}
