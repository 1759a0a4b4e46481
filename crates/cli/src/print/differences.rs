//! Tables of `wireloom compare`: last equilibria, differences, groups of equal equilibria and causes of the others.

use crate::print::table::{Columns, ROWS};
use crate::print::text::{counted, printable, time};
use std::io::{self, Write};
use wireloom::compare::{BranchDifference, Case, Comparison, Part, Trend, forces};
use wireloom::export::sheet;
use wireloom::result::RequirementResult;

/// Prints a comparison; `alike`: all are the same problem, so that they could have ended in the same equilibrium.
pub fn print(
    cases: &[Case],
    comparison: &Comparison,
    trends: &[Trend],
    alike: bool,
    out: &mut dyn Write,
) -> io::Result<()> {
    endings(cases, out)?;
    requirements(cases, out)?;
    outputs(cases, out)?;
    if !alike {
        forces_of_constraints(cases, out)?;
    }
    differences(cases, comparison, out)?;
    branches(comparison, out)?;
    convergence(trends, out)?;
    if !alike {
        return Ok(());
    }
    groups(cases, comparison, out)?;
    parts(cases, comparison, out)
}

/// Last equilibrium of each run.
fn endings(cases: &[Case], out: &mut dyn Write) -> io::Result<()> {
    let mut table = Columns::new([
        "result",
        "status",
        "verdict",
        "stable",
        ">energy [J]",
        ">tightest bend [mm]",
        "on",
        ">iterations",
        ">time",
    ]);
    for Case { name, ending } in cases {
        let tightest = ending.tightest();
        table.row([
            name.clone(),
            ending.status.clone(),
            sheet::capitals(ending.verdict),
            match ending.stable {
                Some(true) => "yes",
                Some(false) => "NO",
                None => "unknown",
            }
            .to_owned(),
            format!("{:.6}", ending.energy.total()),
            tightest.map_or("straight".into(), |(_, _, radius)| millimetres(radius)),
            tightest.map_or(String::new(), |(branch, s, _)| format!("{branch}, s = {:.0} mm", 1e3 * s)),
            ending.iterations.to_string(),
            time(ending.seconds),
        ]);
    }
    table.print(out)
}

/// Requirements that are not kept everywhere, the results side by side: verdict, worst value, margin, place.
fn requirements(cases: &[Case], out: &mut dyn Write) -> io::Result<()> {
    let sheets: Vec<&[RequirementResult]> = cases.iter().map(|case| &case.ending.requirements[..]).collect();
    let open = sheet::open_in_any(&sheets);
    if open.is_empty() {
        return Ok(());
    }
    let headings = ["requirement"].into_iter().chain(cases.iter().map(|case| case.name.as_str()));
    let mut table = Columns::new(headings);
    for name in open.iter().take(ROWS) {
        let cells = sheets.iter().map(|lines| match lines.iter().find(|line| line.name == *name) {
            Some(line) => sheet::brief(line),
            None => "–".to_owned(),
        });
        table.row([(*name).to_owned()].into_iter().chain(cells));
    }
    table.print(out)?;
    if open.len() > ROWS {
        writeln!(out, "({} more besides)\n", counted(open.len() - ROWS, "requirement", "requirements"))?;
    }
    Ok(())
}

/// Largest forces of constraints, the results side by side.
fn forces_of_constraints(cases: &[Case], out: &mut dyn Write) -> io::Result<()> {
    let all = forces(cases);
    let headings = ["constraint", ">largest force [N]", "in"].map(str::to_owned);
    let of_cases = cases.iter().map(|case| format!(">{} [N]", case.name));
    let mut table = Columns::new(headings.into_iter().chain(of_cases));
    let newtons = |force: f64| format!("{force:.2}");
    for own in all.iter().take(ROWS) {
        let cells = own.of.iter().map(|force| force.map_or("–".to_owned(), newtons));
        let largest = [own.constraint.clone(), newtons(own.most()), cases[own.largest].name.clone()];
        table.row(largest.into_iter().chain(cells));
    }
    table.print(out)?;
    if all.len() > ROWS {
        writeln!(out, "({} with smaller forces)\n", counted(all.len() - ROWS, "more constraint", "more constraints"))?;
    }
    Ok(())
}

/// Outputs of plugins, the results side by side, in SI units.
fn outputs(cases: &[Case], out: &mut dyn Write) -> io::Result<()> {
    let mut names: Vec<(&str, &str)> = vec![];
    for constraint in cases.iter().flat_map(|case| &case.ending.constraints) {
        for (output, _) in &constraint.outputs {
            if !names.contains(&(&constraint.name, output)) {
                names.push((&constraint.name, output));
            }
        }
    }
    let mut table =
        Columns::new(["constraint", "output [SI]"].into_iter().chain(cases.iter().map(|c| c.name.as_str())));
    for (constraint, output) in names {
        let value = |case: &Case| {
            let own = case.ending.constraints.iter().find(|own| own.name == constraint);
            let found = own.and_then(|own| own.outputs.iter().find(|(name, _)| name == output));
            found.map_or("–".to_owned(), |(_, value)| format!("{value:.6}"))
        };
        table.row([constraint.to_owned(), output.to_owned()].into_iter().chain(cases.iter().map(value)));
    }
    table.print(out)
}

/// Difference from the reference.
fn differences(cases: &[Case], comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let reference = &cases[comparison.reference].name;
    writeln!(out, "Differences from {}:\n", printable(reference))?;
    let mut table = Columns::new([
        "result",
        ">farthest apart [mm]",
        "on",
        ">mean [mm]",
        ">energy [J]",
        ">largest force difference [N]",
        "at constraint",
    ]);
    for (k, (case, difference)) in cases.iter().zip(&comparison.differences).enumerate() {
        if k == comparison.reference {
            continue;
        }
        let (farthest, hardest) = (difference.farthest(), difference.hardest());
        table.row([
            case.name.clone(),
            farthest.map_or("–".into(), |branch| millimetres(branch.largest)),
            farthest.map_or(String::new(), place),
            millimetres(difference.mean()),
            format!("{:+.3e}", difference.energy),
            hardest.map_or("–".into(), |constraint| format!("{:.4}", constraint.force)),
            hardest.map_or(String::new(), |constraint| constraint.name.clone()),
        ]);
    }
    table.print(out)
}

/// Differences branch by branch, of two results that are not the same.
fn branches(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let others = comparison.differences.iter().enumerate().filter(|(k, _)| *k != comparison.reference);
    let [(_, difference)] = others.collect::<Vec<_>>()[..] else { return Ok(()) };
    if comparison.groups.len() == 1 {
        return Ok(());
    }
    let mut rows: Vec<&BranchDifference> = difference.branches.iter().collect();
    rows.sort_by(|a, b| b.largest.total_cmp(&a.largest));
    let mut table = Columns::new([
        "branch",
        ">farthest apart [mm]",
        ">at s [mm]",
        ">mean [mm]",
        ">tightest bend [mm]",
        ">in the reference",
        ">twist [turns]",
        ">in the reference",
    ]);
    for branch in rows.iter().take(ROWS) {
        let [before, now] =
            branch.bend_radius.map(|radius| if radius.is_finite() { millimetres(radius) } else { "straight".into() });
        let [twist_before, twist_now] = branch.twist_turns.map(|turns| format!("{:.3}", turns + 0.0));
        table.row([
            branch.name.clone(),
            millimetres(branch.largest),
            format!("{:.0}", 1e3 * branch.s),
            millimetres(branch.mean),
            now,
            before,
            twist_now,
            twist_before,
        ]);
    }
    table.print(out)?;
    if rows.len() > ROWS {
        writeln!(out, "({} more branches with smaller differences)\n", rows.len() - ROWS)?;
    }
    Ok(())
}

/// Convergence under mesh refinement.
fn convergence(trends: &[Trend], out: &mut dyn Write) -> io::Result<()> {
    let mut table = Columns::new([
        "quantity",
        "unit",
        "changes from mesh to mesh",
        ">observed order",
        ">error of the finest",
        ">limit",
    ]);
    for trend in trends {
        let changes: Vec<String> = trend.changes.iter().map(|change| format!("{change:.2e}")).collect();
        table.row([
            trend.quantity.to_owned(),
            trend.unit.to_owned(),
            changes.join(", "),
            trend.order.map_or("–".into(), |order| format!("{order:.2}")),
            trend.error.map_or("–".into(), |error| format!("{error:.1e}")),
            trend.limit.map_or(String::new(), |limit| format!("{limit:.6}")),
        ]);
    }
    table.print(out)
}

fn groups(cases: &[Case], comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let within = format!("{} mm", 1e3 * comparison.tolerance);
    let none = comparison.groups.iter().filter(|group| !cases[group.cases[0]].ending.converged).count();
    if let ([group], 0) = (&comparison.groups[..], none) {
        return writeln!(
            out,
            "All {} are the same equilibrium: no branch is farther than {within} from its place in another one, and \
             twist, forces and energy agree.",
            group.cases.len()
        );
    }
    let equilibria = match comparison.groups.len() - none {
        0 => "no equilibrium".to_owned(),
        count => counted(count, "equilibrium", "different equilibria"),
    };
    let others = match none {
        0 => String::new(),
        none => format!(" and {} that did not converge", counted(none, "result", "results")),
    };
    writeln!(
        out,
        "{equilibria}{others} (equal: no branch is farther apart than {within}; twist, forces and energy agree):\n"
    )?;
    for (k, group) in comparison.groups.iter().enumerate() {
        write!(out, "{}. {}", k + 1, named(cases, &group.cases))?;
        if group.reasons.is_empty() {
            writeln!(out)?;
            continue;
        }
        let difference = &comparison.differences[group.cases[0]];
        let apart = difference.branches.iter().filter(|branch| branch.largest > comparison.tolerance).count();
        if group.cases[0] != comparison.reference {
            write!(out, ": {:+.3} mJ", 1e3 * difference.energy)?;
        }
        if let Some(farthest) = difference.farthest().filter(|_| apart > 0) {
            let branches = counted(apart, "branch has", "branches have");
            write!(
                out,
                "; {branches} another shape, by up to {} mm on {}",
                millimetres(farthest.largest),
                printable(&place(farthest))
            )?;
        }
        writeln!(out)?;
        for reason in group.reasons.iter().take(REASONS) {
            writeln!(out, "   {}", printable(&reason.to_string()))?;
        }
        if group.reasons.len() > REASONS {
            writeln!(out, "   and {} more reasons of these kinds", group.reasons.len() - REASONS)?;
        }
    }
    writeln!(out)
}

/// Reasons shown for each group.
const REASONS: usize = 5;

/// Parts with more than one shape.
fn parts(cases: &[Case], comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    if comparison.parts.is_empty() {
        return Ok(());
    }
    writeln!(out, "Parts of the harness with more than one shape:\n")?;
    let mut table = Columns::new(["part", ">shape", ">from shape 1 [mm]", "on", "results"]);
    for part in comparison.parts.iter().take(ROWS) {
        for (k, way) in part.ways.iter().enumerate() {
            table.row([
                if k == 0 { branch_names(part) } else { String::new() },
                (k + 1).to_string(),
                way.farthest.as_ref().map_or(String::new(), |(_, _, distance)| millimetres(*distance)),
                way.farthest.as_ref().map_or(String::new(), |(name, s, _)| format!("{name}, s = {:.0} mm", 1e3 * s)),
                named(cases, &way.cases),
            ]);
        }
    }
    table.print(out)?;
    if comparison.parts.len() > ROWS {
        writeln!(out, "({} more parts with smaller differences)\n", comparison.parts.len() - ROWS)?;
    }
    Ok(())
}

/// `Segment_13, Segment_20 and 3 more`.
fn branch_names(part: &Part) -> String {
    const SHOWN: usize = 2;
    let more = part.branches.len().saturating_sub(SHOWN);
    let shown = part.branches[..part.branches.len().min(SHOWN)].join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}

fn named(cases: &[Case], which: &[usize]) -> String {
    let mut which = which.to_vec();
    which.sort_unstable();
    printable(&which.iter().map(|k| cases[*k].name.as_str()).collect::<Vec<_>>().join(", "))
}

fn place(branch: &BranchDifference) -> String {
    format!("{}, s = {:.0} mm", branch.name, 1e3 * branch.s)
}

/// With as many digits as a small difference needs.
fn millimetres(metres: f64) -> String {
    let value = 1e3 * metres;
    match value.abs() {
        0.0 => "0".into(),
        size if size < 0.01 => format!("{value:.1e}"),
        size if size < 1.0 => format!("{value:.3}"),
        _ => format!("{value:.1}"),
    }
}
