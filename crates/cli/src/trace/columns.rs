//! The trace as a table: a line for each increment, or for each iteration.

use super::fields::Fields;
use crate::print::text::printable;
use std::io::{self, Write};

/// Lines after which the header is repeated.
const PAGE: usize = 25;

/// A column: field of the event, heading, width, and how the number is written.
type Column = (&'static str, &'static str, usize, fn(f64) -> String);

/// Columns of an iteration.
const ITERATION: [Column; 7] = [
    ("iteration", "iter", 5, whole),
    ("energy", "energy [J]", 16, |energy| format!("{energy:.8e}")),
    ("residual", "residual", 9, |residual| format!("{residual:.2e}")),
    ("step", "step", 9, |step| format!("{step:.2e}")),
    ("shift", "shift", 9, |shift| if shift == 0.0 { "0".to_owned() } else { format!("{shift:.1e}") }),
    ("contacts", "contacts", 8, whole),
    ("factorisations", "factor", 6, whole),
];

/// Columns of an increment, behind its number and status; work is counted over the step so far.
const INCREMENT: [Column; 5] = [
    ("iterations", "iter", 6, whole),
    ("factorisations", "factor", 6, whole),
    ("residual", "residual", 9, |residual| format!("{residual:.2e}")),
    ("energy", "energy [J]", 16, |energy| format!("{energy:.8e}")),
    ("contacts", "contacts", 8, whole),
];

/// Width of the number and the status of an increment.
const NUMBER: usize = 9;
const STATUS: usize = 20;

/// The table so far.
pub struct Columns {
    iterations: bool,
    /// Name of the run among several, with a comma.
    case: String,
    step: String,
    increment: String,
    /// Last energy and number of contacts, which only iterations state.
    last: Fields,
    /// Lines since the last header.
    lines: usize,
    /// Whether the increment has a headline yet.
    named: bool,
}

impl Columns {
    /// With a line for each iteration, or only for each increment.
    pub fn new(iterations: bool) -> Self {
        let (case, step, increment) = (String::new(), String::new(), String::new());
        Self { iterations, case, step, increment, last: Fields::default(), lines: PAGE, named: false }
    }

    /// A span has begun.
    pub fn span(&mut self, name: &str, fields: &Fields) {
        match name {
            "case" => self.case = fields.text("name").map(|name| format!("{}, ", printable(name))).unwrap_or_default(),
            "step" => {
                self.step = printable(fields.text("name").unwrap_or_default());
                self.lines = PAGE;
            }
            "increment" => {
                let index = fields.number("index").map(|index| format!("{index:.0}"));
                self.increment = match index.as_deref() {
                    Some("0") => "start".to_owned(),
                    index => index.unwrap_or_default().to_owned(),
                };
            }
            _ => return,
        }
        self.named = false;
    }

    /// An event: its line, with the header where it is due.
    pub fn event(&mut self, target: &str, fields: &Fields, out: &mut impl Write) -> io::Result<()> {
        match target {
            "wireloom::iteration" => {
                self.last = fields.clone();
                if self.iterations { self.iteration(fields, out) } else { Ok(()) }
            }
            "wireloom::increment" => self.increment(fields, out),
            _ => Ok(()),
        }
    }

    fn iteration(&mut self, fields: &Fields, out: &mut impl Write) -> io::Result<()> {
        if !self.named || self.lines >= PAGE {
            let what =
                if self.increment == "start" { "start".to_owned() } else { format!("increment {}", self.increment) };
            writeln!(out, "\n{}step `{}`, {what}\n{}", self.case, self.step, header(&ITERATION))?;
            (self.named, self.lines) = (true, 0);
        }
        self.lines += 1;
        writeln!(out, "{}", cells(&ITERATION, |name| fields.number(name)))
    }

    fn increment(&mut self, fields: &Fields, out: &mut impl Write) -> io::Result<()> {
        let status = fields.text("status").unwrap_or_default();
        if self.iterations {
            return writeln!(out, "increment {}: {status}", self.increment);
        }
        if self.lines >= PAGE {
            let head = format!("{:>NUMBER$}  {:STATUS$}", "increment", "status");
            writeln!(out, "\n{}step `{}`\n{head}{}", self.case, self.step, header(&INCREMENT))?;
            self.lines = 0;
        }
        self.lines += 1;
        let number = |name: &str| fields.number(name).or_else(|| self.last.number(name));
        writeln!(out, "{:>NUMBER$}  {status:STATUS$}{}", self.increment, cells(&INCREMENT, number))
    }
}

fn header(columns: &[Column]) -> String {
    let headings: Vec<String> = columns.iter().map(|(_, heading, width, _)| format!("{heading:>width$}")).collect();
    headings.join("  ")
}

fn cells(columns: &[Column], number: impl Fn(&str) -> Option<f64>) -> String {
    let cell = |(name, _, width, text): &Column| {
        let cell = number(name).map_or_else(|| "–".to_owned(), text);
        format!("{cell:>width$}")
    };
    columns.iter().map(cell).collect::<Vec<_>>().join("  ")
}

fn whole(number: f64) -> String {
    format!("{number:.0}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(all: &[(&'static str, serde_json::Value)]) -> Fields {
        Fields(all.to_vec())
    }

    fn traced(iterations: bool) -> String {
        let mut columns = Columns::new(iterations);
        let mut out = vec![];
        columns.span("step", &fields(&[("name", "pull".into()), ("index", 0.into())]));
        for k in 1..=2 {
            columns.span("increment", &fields(&[("index", k.into())]));
            let iteration = [
                ("iteration", 1.into()),
                ("energy", (-0.5).into()),
                ("residual", 1e-3.into()),
                ("step", 1.0.into()),
                ("shift", 0.0.into()),
                ("contacts", 3.into()),
            ];
            columns.event("wireloom::iteration", &fields(&iteration), &mut out).expect("written");
            let end = [("status", "converged".into()), ("iterations", k.into()), ("residual", 1e-9.into())];
            columns.event("wireloom::increment", &fields(&end), &mut out).expect("written");
        }
        String::from_utf8(out).expect("text")
    }

    #[test]
    fn an_increment_is_a_line() {
        let expected = "\nstep `pull`\n\
            increment  status                iter  factor   residual        energy [J]  contacts\n        \
            1  converged                1       –   1.00e-9     -5.00000000e-1         3\n        \
            2  converged                2       –   1.00e-9     -5.00000000e-1         3\n";
        let squeezed = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(squeezed(&traced(false)), squeezed(expected));
        let text = traced(false);
        let widths: Vec<usize> = text.lines().skip(2).map(|line| line.chars().count()).collect();
        assert!(widths.iter().all(|width| *width == widths[0]), "{text}");
    }

    #[test]
    fn an_iteration_is_a_line_under_its_increment() {
        let text = traced(true);
        let lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
        assert_eq!((lines[0], lines[3]), ("step `pull`, increment 1", "increment 1: converged"));
        assert!(lines[1].trim_start().starts_with("iter"), "{text}");
        let cells: Vec<&str> = lines[2].split_whitespace().collect();
        assert_eq!(cells, ["1", "-5.00000000e-1", "1.00e-3", "1.00e0", "0", "3", "–"]);
        assert_eq!(lines.len(), 8);
    }
}
