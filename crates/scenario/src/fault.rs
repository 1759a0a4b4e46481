//! What is wrong with a scenario, and where.

use std::ops::Range;

/// One fault of a scenario file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Where, in bytes of the text.
    pub span: Range<usize>,
    /// What is wrong, naming the offending value.
    pub message: String,
    /// What would be right.
    pub help: String,
}

impl Fault {
    /// Line and column of the beginning in `text`, both from 1; columns count characters.
    pub fn position(&self, text: &str) -> (usize, usize) {
        let before = &text[..text.floor_char_boundary(self.span.start)];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        (line, column)
    }
}

/// All faults as text: `LINE:COLUMN: MESSAGE`, then `  help: HELP`, two lines for each.
pub fn render(text: &str, faults: &[Fault]) -> String {
    faults
        .iter()
        .map(|fault| {
            let (line, column) = fault.position(text);
            format!("{line}:{column}: {}\n  help: {}\n", fault.message, fault.help)
        })
        .collect()
}

/// The known word nearest to `word`, where one is near enough to be meant.
pub(crate) fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&word.to_lowercase(), &k.to_lowercase()), k))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, k)| *distance <= word.chars().count().min(k.chars().count()) / 3)
        .map(|(_, k)| k)
}

/// Help for a word that is none of the known ones.
pub(crate) fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
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
    fn nearest_word_is_near() {
        let known = ["length", "segments", "section"];
        assert_eq!(nearest("lenght", known), Some("length"));
        assert_eq!(nearest("colour", known), None);
        assert_eq!(nearest("A", ["B", "a"]), Some("a"));
        assert_eq!(nearest("A", ["B", "C"]), None);
        assert_eq!(listed(&["x", "y", "z"]), "x, y and z");
    }
}
