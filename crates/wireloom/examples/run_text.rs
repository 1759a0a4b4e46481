//! Runs a scenario from its text and looks at what came of it: the status first, then events, shapes and forces.
//!
//! `cargo run -p wireloom --example run_text`
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use wireloom::scenario::render;
use wireloom::{Control, Run, Status};

const TEXT: &str = include_str!("../../../scenarios/first.toml");

fn main() -> Result<(), String> {
    let registry = wireloom::registry();
    // A text that is refused has all its faults listed, each with its place and what would be right.
    let (scenario, built) = wireloom::load(TEXT, &registry).map_err(|faults| render(TEXT, &faults))?;
    // Seen after every increment; `Control::Stop` would end the run and keep what is computed.
    let run: Run = wireloom::run(built, &mut |progress, end| {
        println!("{} {}/{}: {}", progress.step, progress.increment, progress.increments, end.status.word());
        Control::Continue
    });
    for event in &run.events {
        println!("{} at {}: {}", event.kind.title(), event.place, event.message);
    }
    if run.status() != Status::Converged {
        return Err(format!("{}: {}", scenario.name, run.status().word()));
    }
    let end = run.steps.last().ok_or("a run has a step")?;
    for branch in &end.branches {
        let tightest = branch.bend_radius.iter().copied().fold(f64::INFINITY, f64::min);
        println!("branch {}: {} nodes, tightest bend {:.1} mm", branch.name, branch.position.len(), 1e3 * tightest);
    }
    for constraint in &end.constraints {
        println!("{} exerts {:.3} N and {:.4} N m", constraint.name, constraint.force.norm(), constraint.moment.norm());
    }
    Ok(())
}
