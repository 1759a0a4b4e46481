//! Faults of a scenario, and their places in the text.

use crate::span::Span;

/// One fault of a scenario file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Its place in the text, bytes.
    pub span: Span,
    /// The fault, with the offending value.
    pub message: String,
    /// The correction.
    pub help: String,
}

impl Fault {
    /// Line and column of its beginning in `text`, both from 1; columns count characters. For many faults of one text
    /// see [`Places`].
    pub fn position(&self, text: &str) -> (usize, usize) {
        Places::of(text).position(self.span.start)
    }
}

/// Lines and columns of a text, found from stored positions instead of from the beginning of the text.
pub struct Places<'t> {
    text: &'t str,
    /// Byte, line and column of positions at regular distances.
    marks: Vec<(usize, usize, usize)>,
}

impl<'t> Places<'t> {
    /// Bytes between two stored positions.
    const APART: usize = 4096;

    /// Places of a text.
    pub fn of(text: &'t str) -> Self {
        let (mut marks, mut line, mut column) = (Vec::new(), 1, 1);
        for (at, c) in text.char_indices() {
            if at >= marks.len() * Self::APART {
                marks.push((at, line, column));
            }
            (line, column) = after(c, line, column);
        }
        Self { text, marks }
    }

    /// Line and column of the character at a byte (beyond the text: of its end), both from 1; columns count characters.
    pub fn position(&self, at: usize) -> (usize, usize) {
        let at = self.text.floor_char_boundary(at);
        let before = self.marks.partition_point(|(mark, ..)| *mark <= at);
        let Some(&(mark, mut line, mut column)) = before.checked_sub(1).map(|k| &self.marks[k]) else { return (1, 1) };
        for c in self.text[mark..at].chars() {
            (line, column) = after(c, line, column);
        }
        (line, column)
    }
}

/// Line and column after a character. A byte order mark, which no editor shows, has no column.
fn after(c: char, line: usize, column: usize) -> (usize, usize) {
    match c {
        '\n' => (line + 1, 1),
        '\u{feff}' => (line, column),
        _ => (line, column + 1),
    }
}

/// All faults as text: `LINE:COLUMN: MESSAGE`, then `  help: HELP`, two lines for each.
pub fn render(text: &str, faults: &[Fault]) -> String {
    let places = Places::of(text);
    faults
        .iter()
        .map(|fault| {
            let (line, column) = places.position(fault.span.start);
            format!("{line}:{column}: {}\n  help: {}\n", fault.message, fault.help)
        })
        .collect()
}

/// The faults of a refused file as text without control characters: `FILE:LINE:COLUMN: MESSAGE`, then `  help: HELP`,
/// two lines for each, then their number.
pub fn refusal(file: &str, text: &str, faults: &[Fault]) -> String {
    let places = Places::of(text);
    let mut lines = String::new();
    for Fault { span, message, help } in faults {
        let (line, column) = places.position(span.start);
        lines += &format!("{file}:{line}:{column}: {}\n  help: {}\n", safe(message), safe(help));
    }
    lines + &count(file, faults.len())
}

/// `error: FILE refused: 2 faults`, and a line feed.
pub fn count(file: &str, faults: usize) -> String {
    format!("error: {file} refused: {faults} fault{}\n", if faults == 1 { "" } else { "s" })
}

/// Lines without control characters, whatever is quoted in them.
pub fn safe(text: &str) -> String {
    text.lines().map(printable).collect::<Vec<_>>().join("\n")
}

/// Text without control characters, which are escaped as `\u{1b}`: names come from files.
pub fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}') {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// The known word nearest to `word`, if one is near enough.
pub(crate) fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&word.to_lowercase(), &k.to_lowercase()), k))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, k)| *distance <= word.chars().count().min(k.chars().count()) / 3)
        .map(|(_, k)| k)
}

/// Help for an unknown word.
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    if let Some(near) = nearest(word, known.clone()) {
        return format!("did you mean `{near}`?");
    }
    let all: Vec<String> = known.into_iter().map(|k| format!("`{k}`")).collect();
    if all.is_empty() { "there is none".into() } else { format!("known: {}", all.join(", ")) }
}

/// `a, b and c`.
pub(crate) fn listed<S: AsRef<str>>(words: &[S]) -> String {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    match words.as_slice() {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_lines_and_characters_from_one() {
        let text = "a = 1\nµ² = 2\n";
        let at =
            |start: usize| Fault { span: start..start, message: String::new(), help: String::new() }.position(text);
        assert_eq!(at(0), (1, 1));
        assert_eq!(at(6), (2, 1));
        assert_eq!(at(text.find("= 2").unwrap()), (2, 4));
        assert_eq!(at(1000), (3, 1));
    }

    #[test]
    fn places_are_those_that_are_counted_from_the_beginning() {
        let text = "µm\n".repeat(3000) + &"é".repeat(9000) + "\n\n";
        let places = Places::of(&text);
        for at in (0..text.len() + 5).step_by(7).chain(text.len() - 3..text.len() + 3) {
            let before = &text[..text.floor_char_boundary(at)];
            let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
            assert_eq!(places.position(at), (before.matches('\n').count() + 1, column), "at {at}");
        }
        assert_eq!(Places::of("").position(3), (1, 1));
    }

    #[test]
    fn names_command_no_terminal() {
        assert_eq!(printable("a\u{1b}[31mb\n\u{202e}"), "a\\u{1b}[31mb\\u{a}\\u{202e}");
        assert_eq!(printable("Größe–2 µm"), "Größe–2 µm");
        assert_eq!(safe("unknown key `a\u{1b}[31m`\n  help: x\n"), "unknown key `a\\u{1b}[31m`\n  help: x");
    }

    #[test]
    fn a_refusal_is_lines_that_editors_know() {
        let text = "schema = 1\nlenght = 2\n[[branches]]\nname = \"a\"\n";
        let fault = |span, message: &str| Fault { span, message: message.into(), help: "did you mean it?".into() };
        assert_eq!(
            refusal("y.toml", text, &[fault(11..17, "unknown key"), fault(22..46, "a lost branch")]),
            "y.toml:2:1: unknown key\n  help: did you mean it?\n\
             y.toml:3:1: a lost branch\n  help: did you mean it?\n\
             error: y.toml refused: 2 faults\n"
        );
    }

    #[test]
    fn nearest_word_is_near() {
        let known = ["length", "segments", "section"];
        assert_eq!(nearest("lenght", known), Some("length"));
        assert_eq!(nearest("colour", known), None);
        assert_eq!(nearest("A", ["B", "a"]), Some("a"));
        assert_eq!(nearest("A", ["B", "C"]), None);
        assert_eq!(listed(&["x", "y", "z"]), "x, y and z");
    }
}
