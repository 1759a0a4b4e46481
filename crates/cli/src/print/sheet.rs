//! The sheet of requirements: all of it, or the worst of it.

use crate::print::table::Columns;
use crate::print::text::{counted, printable};
use std::io::{self, Write};
use wireloom::export::sheet::{Line, headline, is_open, sorted};
use wireloom::result::{RequirementResult, Verdict};
use wireloom::{Run, Status};

/// Requirements that the summary of a run shows.
const WORST: usize = 6;

/// Heading of a column, and what stands in it.
type Column = (&'static str, fn(&Line) -> &String);

const COLUMNS: [Column; 11] = [
    ("verdict", |line| &line.verdict),
    ("requirement", |line| &line.name),
    ("quantity", |line| &line.quantity),
    (">worst", |line| &line.worst),
    (">limit", |line| &line.limit),
    (">margin", |line| &line.margin),
    (">error", |line| &line.error),
    ("where", |line| &line.place),
    ("in step", |line| &line.moment),
    ("because", |line| &line.because),
    ("remark", |line| &line.reason),
];

/// Prints the whole sheet, then the verdict on the harness and the status of the run.
pub fn print(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    table(&sorted(&run.requirements), out)?;
    verdict(run, out)?;
    status(run, "", out)
}

/// Prints the verdict, what was not checked, and the requirements that fail or are unresolved, the worst first; of a
/// run that did not converge those that fail, since all others are unresolved.
pub fn brief(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    verdict(run, out)?;
    let unchecked: Vec<&RequirementResult> =
        run.requirements.iter().filter(|line| line.verdict == Verdict::NotChecked).collect();
    for line in unchecked.iter().take(WORST) {
        writeln!(out, "not checked: `{}`: {}", printable(&line.name), line.reason.as_deref().unwrap_or_default())?;
    }
    if unchecked.len() > WORST {
        writeln!(out, "({} more not checked: see result.json)", unchecked.len() - WORST)?;
    }
    let converged = run.status() == Status::Converged;
    let shown = |line: &&RequirementResult| if converged { is_open(line) } else { line.verdict == Verdict::Fail };
    let open: Vec<&RequirementResult> = sorted(&run.requirements).into_iter().filter(shown).collect();
    if open.is_empty() {
        return Ok(());
    }
    writeln!(out)?;
    table(&open[..open.len().min(WORST)], out)?;
    if open.len() > WORST {
        let more = counted(open.len() - WORST, "requirement fails or is", "requirements fail or are");
        writeln!(out, "({more} unresolved besides: see result.json)\n")?;
    }
    Ok(())
}

/// Prints the verdict in one line.
fn verdict(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "verdict: {}", headline(run))
}

/// Prints the status of the run in one line, with `more` about it.
pub fn status(run: &Run, more: &str, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "status:  {}{more}\n", run.status().word())
}

/// Prints these lines, without columns in which nothing stands.
fn table(lines: &[&RequirementResult], out: &mut dyn Write) -> io::Result<()> {
    let lines: Vec<Line> = lines.iter().map(|line| Line::of(line)).collect();
    let used = |(_, cell): &&Column| lines.iter().any(|line| !cell(line).is_empty());
    let columns: Vec<&Column> = COLUMNS.iter().filter(used).collect();
    let mut table = Columns::new(columns.iter().map(|(heading, _)| *heading));
    for line in &lines {
        table.row(columns.iter().map(|(_, cell)| cell(line).clone()));
    }
    table.print(out)
}
