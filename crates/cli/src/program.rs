//! The program, the machine and the time, as results state them.

use crate::print::text::counted;
use sha2::{Digest, Sha256};

/// Name and version of this program.
pub const PROGRAM: &str = concat!("wireloom ", env!("CARGO_PKG_VERSION"));

/// Commit that this program was built from, as far as it is known; changes that were not committed do not show.
pub fn commit() -> Option<&'static str> {
    Some(env!("WIRELOOM_COMMIT")).filter(|commit| !commit.is_empty())
}

/// SHA-256 of this program's file, in hexadecimal; `None` if it cannot be read.
pub fn fingerprint() -> Option<String> {
    let mut hash = Sha256::new();
    std::io::copy(&mut std::fs::File::open(std::env::current_exe().ok()?).ok()?, &mut hash).ok()?;
    Some(format!("{:x}", hash.finalize()))
}

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
