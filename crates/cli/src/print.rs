//! Output in the terminal: tables, messages, progress.

pub mod diagnostics;
pub mod differences;
pub mod exported;
pub mod identified;
pub mod operations;
pub mod optimise;
pub mod points;
pub mod progress;
pub mod sensitivities;
pub mod sheet;
pub mod summary;
pub mod table;
pub mod terminal;
pub mod text;
