//! Which plugins a scenario gets. A plugin is native code: it is loaded only where the user trusts it.

use crate::arguments::Allowed;
use crate::failure::{Failure, Refusal};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;
use wireloom::core::Registry;
use wireloom::core::equilibrium::Library;
use wireloom::gpu::SharedDevice;
use wireloom::gpu::batch::Batch;
use wireloom::host::{LoadError, Plugin, Plugins, SearchPath, install_crash_handler, resolve};
use wireloom::scenario::Fault;
use wireloom::solve::Progress;

/// Time that a plugin has to say what it is, where no scenario says so, s.
const LOOK_LIMIT: f64 = 10.0;
/// Names the folders of the search path.
const PATH: &str = "WIRELOOM_PLUGINS";

/// The folders of the search path that exist: those of the variable, then the one in the home folder.
pub fn search_path() -> SearchPath {
    let mut folders = std::env::var_os(PATH).map(|path| SearchPath::of(&path)).unwrap_or_default();
    folders.0.extend(std::env::home_dir().map(|home| home.join(".wireloom/plugins")));
    folders.0.retain(|folder| folder.is_dir());
    folders
}

fn devices(allowed: &Allowed) -> SharedDevice {
    SharedDevice::for_single_runs(allowed.device.as_deref())
}

/// Whom the user trusts, and which device they wish.
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
    pub fn to_look(allowed: &Allowed) -> Self {
        Self { folders: None, allowed: allowed.allow_plugin.clone(), devices: devices(allowed) }
    }

    /// The same, for many harnesses at a time.
    pub fn for_batches(self) -> Self {
        Self { devices: self.devices.for_batches(), ..self }
    }

    /// What brings them to the device together.
    pub fn batch(&self) -> &Batch {
        self.devices.batch()
    }

    /// The built-in kinds, on the device that the user wishes.
    pub fn registry(&self) -> Registry {
        wireloom::registry_on(self.devices.clone())
    }

    /// The file of what a scenario in `folder` calls `wanted`, or what is wrong with that: message and help.
    fn file(&self, wanted: &str, folder: &Path) -> Result<PathBuf, (String, String)> {
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

    /// An allowed file that is called so.
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

/// What becomes of this process where a plugin ends it before there is anything to save: it says so.
pub fn prepare_for_the_worst(time_limit: f64) {
    become_heir(&[], time_limit);
}

fn become_heir(arguments: &[OsString], time_limit: f64) {
    let Ok(program) = std::env::current_exe() else { return };
    let arguments = [&["plugin-fault".into()], arguments, &["--".into()]].concat();
    install_crash_handler(&program, &arguments, Duration::try_from_secs_f64(time_limit).unwrap_or(Duration::MAX));
}

/// What becomes of this process where a plugin ends it during a run: it says so, with the increment at hand, and saves what there is.
pub struct Worst {
    folder: PathBuf,
    steps: Vec<String>,
    time_limit: f64,
}

impl Worst {
    /// Of a run with these steps whose results go to `folder`; it begins now.
    pub fn new(folder: &Path, steps: Vec<String>, time_limit: f64) -> Self {
        let worst = Self { folder: folder.to_owned(), steps, time_limit };
        worst.prepare(0, 1);
        worst
    }

    /// An increment has ended.
    pub fn after(&self, progress: &Progress) {
        if progress.increment < progress.increments {
            self.prepare(progress.step_index, progress.increment + 1);
        } else if progress.step_index + 1 < progress.steps {
            self.prepare(progress.step_index + 1, 1);
        }
    }

    fn prepare(&self, step: usize, increment: usize) {
        let name = self.steps.get(step).map_or(ALONE, String::as_str);
        let increment = increment.to_string();
        let folder = self.folder.as_os_str().to_owned();
        become_heir(
            &["--folder".into(), folder, "--step".into(), name.into(), "--increment".into(), increment.into()],
            self.time_limit,
        );
    }
}

/// The step of a scenario that has none.
const ALONE: &str = "equilibrium";

/// Loads the plugins that the scenario in `path` wants, as far as the user trusts them.
pub fn load(path: &Path, text: &str, trust: &Trust, registry: &mut Registry) -> Result<Vec<Plugin>, Failure> {
    let wanted = wireloom::scenario::plugins(text);
    let mut plugins = Plugins::default();
    let mut faults = vec![];
    if !wanted.load.is_empty() {
        prepare_for_the_worst(wanted.time_limit);
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

/// Loads the plugins that are allowed by name, whoever may want them.
pub fn load_allowed(allowed: &Allowed, registry: &mut Registry) -> Result<Plugins, Failure> {
    let mut plugins = Plugins::default();
    for file in &allowed.allow_plugin {
        prepare_for_the_worst(LOOK_LIMIT);
        let loaded = plugins.load(file, registry);
        loaded.map_err(|error| Failure::Input(format!("{error}; {}", error.reason.help())))?;
    }
    Ok(plugins)
}

/// How the result remembers a plugin.
pub fn record(plugin: &Plugin) -> Library {
    Library {
        name: plugin.name.clone(),
        version: plugin.version.clone(),
        file: plugin.file.display().to_string(),
        hash: plugin.hash.clone(),
    }
}
