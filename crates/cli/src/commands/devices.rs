//! `wireloom devices`: devices for the minimiser `gpu`.

use crate::failure::{Failure, Outcome};
use crate::print::table::Columns;
use std::io::{self, Write};
use wireloom::gpu::DeviceInfo;

/// Lists every device of the machine.
pub fn list(out: &mut dyn Write) -> Result<Outcome, Failure> {
    print(&wireloom::gpu::list(), out).map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}

fn print(devices: &[DeviceInfo], out: &mut dyn Write) -> io::Result<()> {
    if devices.is_empty() {
        return writeln!(out, "{}; {}", wireloom::gpu::OpenError::None, wireloom::gpu::OpenError::None.help());
    }
    let mut table =
        Columns::new([">", "device", "by", "sort", "driver", "double precision", ">largest buffer", "usable"]);
    for device in devices {
        table.row([
            device.index.to_string(),
            device.name.clone(),
            device.backend.clone(),
            device.kind.to_owned(),
            device.driver.clone(),
            if device.double { "yes" } else { "no" }.to_owned(),
            format!("{} MiB", device.largest_buffer >> 20),
            device.refusal.clone().map_or_else(|| "yes".to_owned(), |reason| format!("no: {reason}")),
        ]);
    }
    table.print(out)
}
