//! The program, the machine and the time, as results state them.

use crate::print::text::counted;

/// Name and version of this program.
pub const PROGRAM: &str = concat!("wireloom ", env!("CARGO_PKG_VERSION"));

/// Processor, number of cores and system, as far as they are known.
pub fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let processor = processor.unwrap_or_else(|| std::env::consts::ARCH.to_owned());
    format!("{processor}, {}, {}", counted(cores, "core", "cores"), std::env::consts::OS)
}

/// The time, RFC 3339.
pub fn now() -> String {
    humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string()
}
