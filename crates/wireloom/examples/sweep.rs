//! A sweep from text: the points of `[sweep.vary]`, on all cores.
//!
//! `cargo run -p wireloom --example sweep`
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use std::sync::Mutex;
use wireloom::export::table::Cell;
use wireloom::scenario::{NoFiles, render};
use wireloom::session::Monitor;
use wireloom::sweep::tubes::Stations;
use wireloom::sweep::{Points, header};

const TEXT: &str = include_str!("../../../scenarios/first.toml");
const VARY: &str = "\n[sweep.vary]\n\"branches.trunk.length\" = { from = \"580 mm\", to = \"620 mm\", count = 9 }\n";

fn main() -> Result<(), String> {
    let text = format!("{TEXT}{VARY}");
    let registry = wireloom::registry();
    let (scenario, built) = wireloom::load(&text, &registry).map_err(|faults| render(&text, &faults))?;
    let sweep = scenario.sweep.as_ref().ok_or("the text has a sweep")?;
    let header = header(sweep, &built.network);
    let stations = Stations::of(&built.network, &built.schedule);
    let (text, files, minimiser, registry) = (&text, &NoFiles, None, &registry);
    let points = Points { text, files, minimiser, registry, batch: None, sweep, header, stations };
    let chains: Vec<usize> = (0..points.chain_count()).collect();
    let rows = Mutex::new(Vec::new());
    // Chains come as they are done; one that could not be kept would end the sweep.
    points.compute(&chains, &Monitor::default(), &|| (), |chain, new| {
        rows.lock().map(|mut rows| rows.push((chain, new))).map_err(|error| error.to_string())
    })?;
    let mut rows = rows.into_inner().map_err(|error| error.to_string())?;
    rows.sort_by_key(|(chain, _)| *chain);
    let radius = points.header.numbers().iter().position(|name| name == "bend_radius");
    let radius = radius.ok_or("there is no such column")?;
    for row in rows.iter().flat_map(|(_, chain)| &chain.rows) {
        let Cell::Number(length) = &row.values[0] else { continue };
        let tightest = row.numbers[radius].map_or("-".to_owned(), |radius| format!("{:.1} mm", 1e3 * radius));
        println!("trunk of {:.1} mm: {}, tightest bend {tightest}", 1e3 * length, row.status);
    }
    Ok(())
}
