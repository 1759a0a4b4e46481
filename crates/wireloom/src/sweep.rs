//! Sweeps: a scenario over many values. Every point begins afresh, so that it does not depend on its neighbours, on the number of
//! threads, or on where an interrupted sweep was taken up again.

use rayon::prelude::*;
use std::ops::Range;
use wireloom_core::{Network, Registry, Status};
use wireloom_export::ending::Ending;
use wireloom_export::table::{Cell, Header, Row};
use wireloom_scenario::sweep::{Sweep, Value};
use wireloom_scenario::{Fault, Files};
use wireloom_solve::Control;

/// What is computed at each point.
pub struct Points<'a> {
    /// The scenario's text.
    pub text: &'a str,
    /// The files it names.
    pub files: &'a (dyn Files + Sync),
    /// What is set at all points.
    pub minimiser: Option<&'a str>,
    /// The kinds.
    pub registry: &'a Registry,
    /// The sweep of the scenario.
    pub sweep: &'a Sweep,
    /// Names of the columns.
    pub header: Header,
}

/// Names of the columns of a sweep over this harness.
pub fn header(sweep: &Sweep, network: &Network) -> Header {
    let mut fixings: Vec<String> = Vec::new();
    // A name may be taken again when a fixing has let go.
    for fixing in &network.fixings {
        if !fixings.contains(&fixing.name) {
            fixings.push(fixing.name.clone());
        }
    }
    Header {
        keys: sweep.axes.iter().map(|axis| axis.key.clone()).collect(),
        branches: network.branches.iter().map(|branch| branch.name.clone()).collect(),
        fixings,
    }
}

impl Points<'_> {
    /// Computes points on all cores, in order; `None` where `stop` says so before all are done. `done` is told of each.
    pub fn compute(
        &self,
        points: Range<usize>,
        stop: &(dyn Fn() -> bool + Sync),
        done: &(dyn Fn() + Sync),
    ) -> Option<Vec<Row>> {
        let point = |k| {
            let row = self.point(k, stop);
            done();
            row
        };
        points.into_par_iter().map(point).collect()
    }

    fn point(&self, k: usize, stop: &(dyn Fn() -> bool + Sync)) -> Option<Row> {
        if stop() {
            return None;
        }
        let cell = |(axis, value): (&wireloom_scenario::sweep::Axis, Value)| match value.number {
            Some(number) if axis.range.is_numeric() => Cell::Number(number),
            _ => Cell::Word(value.word().to_owned()),
        };
        let values: Vec<Cell> = self.sweep.axes.iter().zip(self.sweep.point(k)).map(cell).collect();
        let mut settings = self.sweep.settings(k);
        settings.extend(self.minimiser.map(wireloom_scenario::Setting::minimiser));
        let built = match crate::load_with_settings(self.text, &settings, self.files, self.registry) {
            Ok((_, built)) => built,
            Err(faults) => return Some(self.header.refused(values, said(&faults))),
        };
        let control = || if stop() { Control::Stop } else { Control::Continue };
        let run = crate::run(built, &mut |_, _| control());
        if run.status == Status::Interrupted {
            return None;
        }
        // Why a run ended before its time.
        let message = run.fault.as_ref().map(|fault| fault.message.clone());
        let row = match Ending::of(&run) {
            Some(ending) => self.header.row(values, &ending),
            None => Row { status: run.status.word().to_owned(), ..self.header.refused(values, String::new()) },
        };
        Some(Row { message, ..row })
    }
}

fn said(faults: &[Fault]) -> String {
    faults.iter().map(|fault| fault.message.as_str()).collect::<Vec<_>>().join("; ")
}
