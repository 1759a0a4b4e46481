//! Plugins: constraints and joints out of dynamic libraries.
//!
//! A plugin is native code that may do all that the process may do: load only what the user trusts.
//!
//! ```
//! use std::path::Path;
//! use wireloom::plugins::Plugins;
//!
//! let mut registry = wireloom::registry();
//! let mut plugins = Plugins::default();
//! match plugins.load(Path::new("libelastic_strap.so"), &mut registry) {
//!     Ok(plugin) => println!("{} {}", plugin.name, plugin.version),
//!     Err(error) => println!("{error}; {}", error.reason.help()),
//! }
//! ```

#[cfg(unix)]
pub use wireloom_host::record_calls;
pub use wireloom_host::{
    ABI_MAJOR, ABI_MINOR, HEADER, HEADER_CPP, LATE, LoadError, Plugin, Plugins, Reason, RecordedCall, SearchPath,
    begin_record, file_name, floating_point_changes, install_crash_handler, notes, numeric_derivatives,
    open_regular_file, recorded_calls, resolve,
};
