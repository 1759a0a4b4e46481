//! The designs of `wireloom optimise`, one a line, and what was found.

use crate::print::sheet;
use crate::print::text::{counted, printable};
use std::io::{self, Write};
use std::path::Path;
use wireloom::optimise::{Design, Kind, Optimisation};

/// Width of a column of values.
const WIDTH: usize = 11;
/// Largest number of variables that are shown; the file has all.
const SHOWN: usize = 6;

/// Word for a kind of run.
pub fn word(kind: Kind) -> &'static str {
    match kind {
        Kind::Start => "start",
        Kind::Step => "step",
        Kind::Difference => "difference",
        Kind::Certificate => "certificate",
    }
}

/// Lines of a table whose rows come one by one.
pub struct Table {
    header: Option<String>,
}

impl Table {
    /// A table of designs with these variables.
    pub fn new(keys: &[String]) -> Self {
        let mut header = String::new();
        for (k, key) in keys.iter().take(SHOWN).enumerate() {
            header += &format!("x{} = {}\n", k + 1, printable(key));
        }
        if keys.len() > SHOWN {
            header += &format!("and {} more\n", keys.len() - SHOWN);
        }
        header += &format!("\n{:>4}  {:<11}", "run", "kind");
        (0..keys.len().min(SHOWN)).for_each(|k| header += &format!("  {:>WIDTH$}", format!("x{}", k + 1)));
        header += &format!("  {:>WIDTH$}  {:>8}  verdict     tightest", "objective", "margin");
        Self { header: Some(header) }
    }

    /// Prints one more row.
    pub fn row(&mut self, design: &Design, out: &mut dyn Write) -> io::Result<()> {
        if let Some(header) = self.header.take() {
            writeln!(out, "{header}")?;
        }
        write!(out, "{:>4}  {:<11}", design.run, word(design.kind))?;
        for value in design.values.iter().take(SHOWN) {
            let short = value.parse().map_or_else(|_| printable(value), number);
            write!(out, "  {short:>WIDTH$}")?;
        }
        match &design.failure {
            Some(failure) => writeln!(out, "  {}", printable(failure)),
            None => {
                let objective = design.objective.map_or_else(String::new, number);
                let margin = design.margin.map_or_else(String::new, |margin| format!("{:.2} %", 1e2 * margin));
                let words = |word: &Option<String>| printable(word.as_deref().unwrap_or_default());
                let (verdict, tightest) = (words(&design.verdict), words(&design.tightest));
                let line = format!("  {objective:>WIDTH$}  {margin:>8}  {verdict:<10}  {tightest}");
                writeln!(out, "{}", line.trim_end())
            }
        }
    }
}

/// Seven significant digits.
fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || !(1e-4..1e7).contains(&size) {
        return format!("{x:.6e}");
    }
    format!("{x:.*}", (6 - size.log10().floor() as i32).max(0) as usize)
}

/// Prints what was found. `beside`: the scenario's file, if it names others.
pub fn end(found: &Optimisation, folder: &Path, beside: Option<&Path>, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out)?;
    if let Some(optimum) = &found.optimum {
        match &optimum.certificate {
            Some(run) => {
                sheet::print(run, out)?;
                writeln!(out, "the best design, run afresh; its objective is {}", number(optimum.objective))?;
            }
            None => writeln!(
                out,
                "the best design so far, run {}, keeps all requirements; its objective is {}; it was not run afresh",
                optimum.run,
                number(optimum.objective)
            )?,
        }
    }
    let counts = &found.counts;
    writeln!(
        out,
        "{}: {} ({} failed, {} for differences), derivatives at {}",
        found.ending.words(),
        counted(counts.runs, "run", "runs"),
        counts.failed,
        counts.differences,
        counted(counts.gradients, "equilibrium", "equilibria"),
    )?;
    writeln!(out, "{}", folder.display())?;
    if let (Some(file), true) = (beside, found.optimum.is_some()) {
        writeln!(out, "optimum.toml names other files: put it beside {}", file.display())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_seven_digits() {
        let shown = [0.0, 0.212_345_678, -3.25, 123_456.78, 4e-7].map(number);
        assert_eq!(shown, ["0.000000e0", "0.2123457", "-3.250000", "123456.8", "4.000000e-7"]);
    }
}
