//! `wireloom plugin check`: loads a plugin and tests the contracts of its kinds.

mod constraint;
mod joint;
mod rod;
mod trial;

use crate::failure::{Failure, Outcome};
use crate::plugin::crash;
use crate::plugin::describe::{describe, describe_joint, describe_rod};
use crate::plugin::load::{not_loaded, record};
use crate::print::text::{counted, printable};
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use trial::{Trial, Verdict};
use wireloom::plugins::Plugins;

/// Tests all kinds of the plugin in `file`.
pub fn check(file: &Path, time_limit: f64, out: &mut dyn Write) -> Result<Outcome, Failure> {
    if !(time_limit.is_finite() && time_limit > 0.0) {
        return Err(Failure::Input(format!("--time-limit {time_limit} is not valid: give seconds above 0")));
    }
    crash::prepare(time_limit);
    let mut registry = wireloom::registry();
    let mut loaded = Plugins::default();
    let plugin = loaded.load(file, &mut registry).map_err(not_loaded)?;
    let mut faults = 0;
    let mut print = || {
        writeln!(out, "{}: {}", printable(&record(plugin).to_string()), printable(&plugin.doc))?;
        faults += carry_out(vec![trial::floating_point(" as it is loaded")], out)?;
        for kind in plugin.constraints.iter().filter_map(|name| registry.constraint(name)) {
            describe(kind, out)?;
            faults += carry_out(constraint::trials(kind), out)?;
        }
        for kind in plugin.joints.iter().filter_map(|name| registry.joint(name)) {
            describe_joint(kind, out)?;
            faults += carry_out(joint::trials(kind), out)?;
        }
        for kind in plugin.rods.iter().filter_map(|name| registry.rod(name)) {
            describe_rod(kind, out)?;
            faults += carry_out(rod::trials(kind), out)?;
        }
        if faults == 0 { writeln!(out, "all tests passed") } else { Ok(()) }
    };
    print().map_err(Failure::standard_output)?;
    out.flush().map_err(Failure::standard_output)?;
    match faults {
        0 => Ok(Outcome::Done),
        n => Err(Failure::Plugin(counted(n, "test failed", "tests failed"))),
    }
}

/// Runs all tests; returns the number of failures.
fn carry_out(trials: Vec<Trial<'_>>, out: &mut dyn Write) -> io::Result<usize> {
    let mut faults = 0;
    for (what, try_it) in trials {
        // Shows the test at hand, should the plugin crash the program.
        write!(out, "    {what} … ")?;
        out.flush()?;
        match quietly(try_it) {
            Ok(words) => writeln!(out, "{words}")?,
            Err(words) => {
                faults += 1;
                writeln!(out, "FAILED\n      {}", printable(&words))?;
            }
        }
    }
    Ok(faults)
}

/// Outcome of a test; a panic is a failure with its message.
fn quietly(try_it: Box<dyn FnOnce() -> Verdict + '_>) -> Verdict {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let verdict = catch_unwind(AssertUnwindSafe(try_it));
    std::panic::set_hook(before);
    verdict.unwrap_or_else(|payload| {
        let words = payload.downcast_ref::<String>().cloned();
        Err(words.or_else(|| payload.downcast_ref::<&str>().map(|s| (*s).to_owned())).unwrap_or_default())
    })
}
