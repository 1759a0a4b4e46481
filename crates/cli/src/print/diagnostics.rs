//! Messages of faults: in a terminal with the line, a caret and a suggestion; elsewhere one line each, in the form
//! `FILE:LINE:COLUMN: fault` that editors and scripts know.

use crate::failure::{Failure, Refusal};
use miette::{
    Diagnostic, LabeledSpan, MietteError, MietteHandlerOpts, MietteSpanContents, ReportHandler, SourceCode, SourceSpan,
    SpanContents,
};
use std::fmt;
use std::io::{IsTerminal, Write};
use wireloom::scenario::fault::{count, refusal as plain, safe};
use wireloom::scenario::{Fault, Places};

/// Shows a failure on standard error.
pub fn show(failure: &Failure, err: &mut (impl Write + IsTerminal)) {
    if let Failure::Several(all) = failure {
        all.iter().for_each(|failure| show(failure, err));
        return;
    }
    let text = match failure {
        Failure::Refused(refusals) => {
            let fancy = err.is_terminal();
            refusals
                .iter()
                .map(|refusal| {
                    if fancy {
                        drawn(refusal, &terminal())
                    } else {
                        plain(&refusal.file, &refusal.text, &refusal.faults)
                    }
                })
                .collect()
        }
        _ => format!("error: {}\n", safe(&failure.to_string())),
    };
    // If this fails, there is no other place to report it.
    let _ = err.write_all(text.as_bytes());
}

/// A file's text with a `?` for every byte of a control character, so that offsets stay the same.
fn masked(text: &str) -> String {
    let commands = |c: char| c.is_control() && !"\n\r\t".contains(c);
    text.chars().map(|c| if commands(c) { "?".repeat(c.len_utf8()) } else { c.to_string() }).collect()
}

/// The same with the lines at fault.
fn drawn(refusal: &Refusal, handler: &dyn ReportHandler) -> String {
    let masked = masked(&refusal.text);
    let source = Source { name: &refusal.file, text: &masked, places: Places::of(&masked) };
    let mut text = String::new();
    for fault in &refusal.faults {
        let drawing = Drawing { report: Report { fault, source: &source }, handler };
        text += &format!("{drawing:?}\n");
    }
    text + &count(&refusal.file, refusal.faults.len())
}

/// Colours, width and characters of the terminal.
fn terminal() -> impl ReportHandler {
    MietteHandlerOpts::new().build()
}

/// A file's text, of which a fault shows its line alone; lines are counted once for all faults.
struct Source<'a> {
    name: &'a str,
    text: &'a str,
    places: Places<'a>,
}

impl SourceCode for Source<'_> {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let (at, end) = (span.offset(), span.offset() + span.len());
        let (Some(head), Some(tail)) = (self.text.get(..at), self.text.get(end..)) else {
            return Err(MietteError::OutOfBounds);
        };
        // The requested number of lines before and after.
        let first = head.rmatch_indices('\n').nth(before).map_or(0, |(newline, _)| newline + 1);
        let last = tail.match_indices('\n').nth(after).map_or(self.text.len(), |(newline, _)| end + newline + 1);
        let shown = &self.text[first..last];
        let (line, column) = self.places.position(first);
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.to_owned(),
            shown.as_bytes(),
            (first, last - first).into(),
            line - 1,
            column - 1,
            shown.lines().count(),
        )))
    }
}

/// A report, drawn by a handler.
struct Drawing<'a> {
    report: Report<'a>,
    handler: &'a dyn ReportHandler,
}

impl fmt::Debug for Drawing<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.handler.debug(&self.report, f)
    }
}

/// One fault in its file.
struct Report<'a> {
    fault: &'a Fault,
    source: &'a Source<'a>,
}

impl fmt::Debug for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&safe(&self.fault.message))
    }
}

impl std::error::Error for Report<'_> {}

impl Diagnostic for Report<'_> {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(safe(&self.fault.help)))
    }
    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(self.source)
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        // An entry of many lines would be drawn as a bracket over all of them: its first line is enough.
        let length = self.source.text.len();
        let start = self.fault.span.start.min(length);
        let end = self.fault.span.end.clamp(start, length);
        let line = self.source.text.get(start..end).and_then(|text| text.lines().next()).unwrap_or_default();
        Some(Box::new(std::iter::once(LabeledSpan::new(None, start, line.len().max(1).min(length - start)))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_files_say_commands_no_terminal() {
        assert_eq!(masked("a\u{1b}[31m\u{9b}\tb\r\n"), "a?[31m??\tb\r\n");
    }
    use miette::{GraphicalReportHandler, GraphicalTheme};

    fn refusal() -> Refusal {
        let text = "schema = 1\nlenght = 2\n[[branches]]\nname = \"a\"\n".to_owned();
        let fault = |span, message: &str| Fault { span, message: message.into(), help: "did you mean it?".into() };
        Refusal {
            file: "y.toml".into(),
            faults: vec![fault(11..17, "unknown key"), fault(22..46, "a lost branch")],
            text,
        }
    }

    #[test]
    fn drawn_faults_point_at_the_place() {
        let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor());
        let text = drawn(&refusal(), &handler);
        assert!(text.contains("[y.toml:2:1]"), "{text}");
        assert!(text.contains("lenght = 2\n   · ──────"), "{text}");
        assert!(text.contains("help: did you mean it?"), "{text}");
        assert!(text.contains("[y.toml:3:1]"), "{text}");
    }

    #[test]
    fn a_fault_at_the_end_of_an_empty_file_is_drawn() {
        let fault = Fault { span: 0..0, message: "nothing here".into(), help: "write something".into() };
        let refusal = Refusal { file: "empty.toml".into(), text: String::new(), faults: vec![fault] };
        let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor());
        assert!(drawn(&refusal, &handler).contains("nothing here"));
    }
}
