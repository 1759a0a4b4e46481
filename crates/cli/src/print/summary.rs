//! Summary of a run: verdict, what fails, status, steps, forces of constraints, bends, contacts, clearances, events,
//! notes.

use crate::extremes::{Bend, Extremes, Load};
use crate::print::table::{Columns, ROWS};
use crate::print::text::{printable, time};
use crate::print::{operations, sheet};
use std::io::{self, Write};
use wireloom::geometry::Vector;
use wireloom::result::{
    BranchResult, Clearance, ConstraintResult, Deviation, DeviationCause, Event, Group, Identified, Identities,
    ObstacleResult, grouped,
};
use wireloom::{Run, StepResult};

/// Notes of a kind that are shown. Where there are more, only their number is: the results have them.
const NOTES: usize = 3;

/// Prints the summary of a run of a harness of this size, in words; the first `built` of its notes were known before
/// it began.
pub fn print(run: &Run, size: &str, extremes: &Extremes, built: usize, out: &mut dyn Write) -> io::Result<()> {
    sheet::brief(run, out)?;
    sheet::status(run, &format!(" ({}: {size})", printable(&run.scenario)), out)?;
    for plugin in &run.plugins {
        writeln!(out, "{}", printable(&plugin.to_string()))?;
    }
    if !run.plugins.is_empty() {
        writeln!(out)?;
    }
    steps(run, out)?;
    operations::print(run, out)?;
    let end = run.steps.last().filter(|end| end.status.is_balanced());
    if end.is_none() {
        let none = extremes.bends.is_empty();
        let what = if none { "no increment ended in an equilibrium" } else { "the end is not an equilibrium" };
        let shown = if none { "" } else { ": the tables are of the increments that ended in one" };
        writeln!(out, "{what}{shown}\n")?;
    }
    constraints(end, &extremes.loads, &run.identities, out)?;
    end.map_or(Ok(()), |end| outputs(end, out))?;
    bends(&extremes.bends, out)?;
    end.map_or(Ok(()), |end| deviations(&end.branches, out))?;
    if let Some(drawn_start) = &run.drawn_start {
        drawn_start.lines().iter().try_for_each(|line| writeln!(out, "{}", printable(line)))?;
        writeln!(out)?;
    }
    end.map_or(Ok(()), |end| obstacles(end, out))?;
    clearances(&run.clearances, out)?;
    events(&run.events, out)?;
    notes(&run.notes, built, out)
}

/// Prints the notes of the run, then those of the scenario; of many, their number.
pub fn notes(notes: &[String], built: usize, out: &mut dyn Write) -> io::Result<()> {
    let (before, during) = notes.split_at(built.min(notes.len()));
    for (notes, on) in [(during, "the run"), (before, "the scenario")] {
        if notes.len() > NOTES {
            writeln!(out, "{} notes on {on}: see result.json", notes.len())?;
            continue;
        }
        for note in notes {
            writeln!(out, "note: {}", printable(note))?;
        }
    }
    if notes.is_empty() { Ok(()) } else { writeln!(out) }
}

fn steps(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let mut table =
        Columns::new(["step", "status", ">increments", ">iterations", ">time", ">residual", ">energy [J]", "stable"]);
    for (k, end) in run.steps.iter().enumerate() {
        // With `increments = true` every increment has an entry; the last one of a step stands for it.
        if run.steps.get(k + 1).is_some_and(|next| next.name == end.name && next.increment > end.increment) {
            continue;
        }
        let m = &end.minimiser;
        table.row([
            end.name.clone(),
            end.status.word().to_owned(),
            if end.increment == end.increments {
                end.increments.to_string()
            } else {
                format!("{} of {}", end.increment, end.increments)
            },
            match m.polish {
                0 => m.iterations.to_string(),
                polish => format!("{} ({polish} to polish)", m.iterations),
            },
            time(m.seconds),
            format!("{:.0e}", m.force_residual),
            format!("{:.4}", end.energy.total()),
            match end.stable {
                Some(true) => "yes",
                Some(false) => "NO",
                None => "unknown",
            }
            .to_owned(),
        ]);
    }
    table.print(out)
}

/// Forces of constraints: the largest ones, and those at the end if that is an equilibrium.
fn constraints(
    end: Option<&StepResult>,
    loads: &[Load],
    identities: &Identities,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut loads: Vec<&Load> = loads.iter().collect();
    let left_out = keep(&mut loads, |load| load.force);
    let parts = loads.iter().any(|load| identities.find(Identified::Constraint, &load.name).is_some());
    let mut columns = vec!["constraint", "kind"];
    if parts {
        columns.push("part");
    }
    columns.extend(["force at the end [N]", "moment at the end [N m]", ">largest force [N]", "in step"]);
    let mut table = Columns::new(columns);
    for load in loads {
        let vector = |part: fn(&ConstraintResult) -> Vector, digits| {
            let Some(end) = end else { return "unknown".into() };
            let now = end.constraints.iter().find(|constraint| constraint.name == load.name);
            now.map_or_else(|| "released".into(), |constraint| vector(&part(constraint), digits))
        };
        let part = identities.find(Identified::Constraint, &load.name).and_then(|own| own.part.clone());
        let mut row = vec![load.name.clone(), load.kind.clone()];
        if parts {
            row.push(part.unwrap_or_default());
        }
        row.extend([
            vector(|constraint| constraint.force, 3),
            vector(|constraint| constraint.moment, 4),
            format!("{:.3}", load.force),
            load.step.clone(),
        ]);
        table.row(row);
    }
    table.print(out)?;
    if left_out > 0 {
        writeln!(out, "({left_out} constraints with smaller forces: see result.json)\n")?;
    }
    Ok(())
}

/// Outputs of plugins at the end.
fn outputs(end: &StepResult, out: &mut dyn Write) -> io::Result<()> {
    let mut table = Columns::new(["constraint", "output", ">value at the end [SI]"]);
    let all = end.constraints.iter().flat_map(|of| of.outputs.iter().map(|output| (&of.name, output)));
    let left_out = all.clone().count().saturating_sub(ROWS);
    for (constraint, (output, value)) in all.take(ROWS) {
        table.row([constraint.clone(), output.clone(), format!("{value:.6}")]);
    }
    table.print(out)?;
    if left_out > 0 {
        writeln!(out, "({left_out} more outputs: see result.json)\n")?;
    }
    Ok(())
}

fn bends(bends: &[Bend], out: &mut dyn Write) -> io::Result<()> {
    let mut bends: Vec<&Bend> = bends.iter().collect();
    let left_out = keep(&mut bends, |bend| if bend.limit.is_some() { bend.use_of_limit() } else { -bend.radius });
    let mut table = Columns::new(["branch", ">tightest bend [mm]", ">at s [mm]", "in step", ">limit [mm]", ""]);
    for bend in bends {
        let straight = bend.radius.is_infinite();
        table.row([
            bend.name.clone(),
            if straight { "straight".into() } else { format!("{:.1}", 1e3 * bend.radius) },
            if straight { String::new() } else { format!("{:.0}", 1e3 * bend.s) },
            if straight { String::new() } else { bend.step.clone() },
            bend.limit.map_or_else(|| "no limit".into(), |limit| format!("{:.1}", 1e3 * limit)),
            if bend.use_of_limit() > 1.0 { "TOO TIGHT" } else { "" }.to_owned(),
        ]);
    }
    table.print(out)?;
    if left_out > 0 {
        writeln!(out, "({left_out} branches further from their limits: see result.json)\n")?;
    }
    Ok(())
}

/// Distances from the drawn lines at the end, and for branches that do not lie where they are drawn the reason.
fn deviations(branches: &[BranchResult], out: &mut dyn Write) -> io::Result<()> {
    let drawn: Vec<(&BranchResult, &Deviation)> =
        branches.iter().filter_map(|branch| Some((branch, branch.deviation.as_ref()?))).collect();
    let Some((farthest, most)) = drawn.iter().max_by(|a, b| a.1.max.total_cmp(&b.1.max)) else { return Ok(()) };
    let away: Vec<_> = drawn.iter().filter_map(|(branch, own)| Some((*branch, *own, own.cause.as_ref()?))).collect();
    let few = away.iter().filter(|(_, _, cause)| matches!(cause, DeviationCause::FewConstraints { .. })).count();
    let free = away.iter().filter(|(_, _, cause)| matches!(cause, DeviationCause::FreeEnd { .. })).count();
    writeln!(
        out,
        "deviation from the drawing at the end: up to {:.1} mm (branch {} at s = {:.0} mm); {} of {} drawn branches \
         lie more than their diameter away: {few} with too few constraints to keep their shape, {free} with free \
         ends, {} held elsewhere",
        1e3 * most.max,
        printable(&farthest.name),
        1e3 * most.s,
        away.len(),
        drawn.len(),
        away.len() - few - free
    )?;
    writeln!(out)?;
    let mut rows: Vec<_> = away.iter().collect();
    let left_out = keep(&mut rows, |row| row.1.max);
    let mut table =
        Columns::new(["branch", ">median deviation [mm]", ">largest [mm]", ">at s [mm]", ">diameter [mm]", "reason"]);
    for (branch, deviation, cause) in rows {
        table.row([
            branch.name.clone(),
            format!("{:.1}", 1e3 * deviation.median),
            format!("{:.1}", 1e3 * deviation.max),
            format!("{:.0}", 1e3 * deviation.s),
            format!("{:.1}", 1e3 * branch.diameter),
            cause.to_string(),
        ]);
    }
    table.print(out)?;
    if left_out > 0 {
        writeln!(out, "({left_out} branches with smaller deviations: see result.json)\n")?;
    }
    Ok(())
}

fn obstacles(end: &StepResult, out: &mut dyn Write) -> io::Result<()> {
    let mut touched: Vec<&ObstacleResult> = end.obstacles.iter().filter(|obstacle| obstacle.contacts > 0).collect();
    let left_out = keep(&mut touched, |obstacle| obstacle.force.norm());
    let mut table = Columns::new(["obstacle", "force on the harness [N]", "moment [N m]", ">contacts", ">depth [µm]"]);
    for obstacle in touched {
        table.row([
            obstacle.name.clone(),
            vector(&obstacle.force, 3),
            vector(&obstacle.moment, 4),
            obstacle.contacts.to_string(),
            format!("{:.1}", 1e6 * obstacle.depth),
        ]);
    }
    table.print(out)?;
    if left_out > 0 {
        writeln!(out, "({left_out} obstacles with smaller forces: see result.json)\n")?;
    }
    Ok(())
}

fn clearances(clearances: &[Clearance], out: &mut dyn Write) -> io::Result<()> {
    let mut least: Vec<&Clearance> = clearances.iter().collect();
    let left_out = keep(&mut least, |clearance| clearance.required.unwrap_or(0.0) - clearance.distance);
    let mut table =
        Columns::new(["branch", "nearest to", ">clearance [mm]", ">at s [mm]", "in step", ">required [mm]", ""]);
    for clearance in least {
        table.row([
            clearance.branch.clone(),
            clearance.from.to_string(),
            format!("{:.1}", 1e3 * clearance.distance),
            format!("{:.0}", 1e3 * clearance.s),
            format!("{} ({})", clearance.moment.step, clearance.moment.increment),
            clearance.required.map_or_else(String::new, |required| format!("{:.1}", 1e3 * required)),
            if clearance.is_short() { "TOO NEAR" } else { "" }.to_owned(),
        ]);
    }
    table.print(out)?;
    if left_out > 0 {
        writeln!(out, "({left_out} pairs further apart: see result.json)\n")?;
    }
    Ok(())
}

fn events(events: &[Event], out: &mut dyn Write) -> io::Result<()> {
    let groups = grouped(events);
    let mut table = Columns::new(["event", "where", "worst value", "in step", ">increments"]);
    for Group { worst, increments, .. } in groups.iter().take(ROWS) {
        table.row([
            worst.kind.title().to_owned(),
            worst.place.to_string(),
            worst.message.clone(),
            format!("{} ({})", worst.worst.step, worst.worst.increment),
            increments.to_string(),
        ]);
    }
    table.print(out)?;
    if groups.len() > ROWS {
        writeln!(out, "({} more events: see result.json)\n", groups.len() - ROWS)?;
    }
    Ok(())
}

/// Keeps the rows of largest weight, in their order. Returns the number of rows removed.
fn keep<T>(rows: &mut Vec<&T>, weight: impl Fn(&T) -> f64) -> usize {
    if rows.len() <= ROWS {
        return 0;
    }
    let mut weights: Vec<f64> = rows.iter().map(|row| weight(row)).collect();
    weights.sort_by(|a, b| b.total_cmp(a));
    let least = weights[ROWS - 1];
    let all = rows.len();
    rows.retain(|row| weight(row) >= least);
    rows.truncate(ROWS);
    all - rows.len()
}

fn vector(v: &Vector, digits: usize) -> String {
    // Adding zero turns −0 into 0, and rounding first avoids `-0.000`.
    let scale = 10f64.powi(digits as i32);
    let [x, y, z] = [v.x, v.y, v.z].map(|c| format!("{:8.digits$}", (c * scale).round() / scale + 0.0));
    format!("{x} {y} {z}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_readable() {
        assert_eq!(vector(&Vector::new(-0.0, -1e-9, 12.3456), 3), "   0.000    0.000   12.346");
    }

    #[test]
    fn long_tables_keep_the_heaviest_rows_in_order() {
        let numbers: Vec<f64> = (0..50).map(|k| f64::from((k * 7) % 50)).collect();
        let mut rows: Vec<&f64> = numbers.iter().collect();
        assert_eq!(keep(&mut rows, |x| *x), 30);
        assert_eq!(rows.len(), ROWS);
        assert!(rows.iter().all(|x| **x >= 30.0));
        assert_eq!(*rows[0], 35.0);
    }
}
