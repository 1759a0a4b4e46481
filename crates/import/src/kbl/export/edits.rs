//! Changes of an XML text by byte ranges, which leave everything else as it is.

use crate::curve::Vector;
use crate::xml::{Xml, children};
use std::collections::HashSet;
use std::ops::Range;

/// Changes that were collected, and the ids of the text.
pub struct Edits<'t> {
    text: &'t str,
    list: Vec<(Range<usize>, String)>,
    ids: HashSet<String>,
}

impl<'t> Edits<'t> {
    /// None yet; `ids`: those that are taken.
    pub fn new(text: &'t str, ids: impl Iterator<Item = &'t str>) -> Self {
        Self { text, list: Vec::new(), ids: ids.map(str::to_owned).collect() }
    }

    pub fn replace(&mut self, range: Range<usize>, new: String) {
        self.list.push((range, new));
    }

    pub fn insert(&mut self, at: usize, new: String) {
        self.replace(at..at, new);
    }

    /// Removes an element and the white space before it.
    pub fn remove(&mut self, node: Xml) {
        let Range { start, end } = node.range();
        self.replace(start - self.space_before(start).len()..end, String::new());
    }

    /// Replaces the text of an element, without the white space around it; comments within it go with it.
    pub fn set(&mut self, node: Xml, value: &str) {
        let Some((first, last)) = node.first_child().zip(node.last_child()) else { return };
        let range = first.range().start..last.range().end;
        let own = &self.text[range.clone()];
        let start = range.start + own.len() - own.trim_start().len();
        let range = start..start + own.trim().len();
        if &self.text[range.clone()] != value {
            self.replace(range, value.to_owned());
        }
    }

    /// Replaces the three numbers in elements of a name; false, and nothing, if there are not three.
    pub fn set_vector(&mut self, node: Xml, name: &'static str, value: [String; 3]) -> bool {
        let parts: Vec<Xml> = children(node, name).collect();
        let whole = parts.len() == 3;
        if whole {
            parts.iter().zip(&value).for_each(|(part, value)| self.set(*part, value));
        }
        whole
    }

    /// An id that no element has: this one, or with a number.
    pub fn fresh(&mut self, id: &str) -> String {
        let numbered = (2..).map(|k| format!("{id}_{k}"));
        let free = std::iter::once(id.to_owned()).chain(numbered).find(|id| !self.ids.contains(id));
        let free = free.unwrap_or_else(|| unreachable!("the numbers do not end"));
        self.ids.insert(free.clone());
        free
    }

    /// White space directly before a byte, with the line break.
    pub fn space_before(&self, at: usize) -> &'t str {
        let before = &self.text[..at];
        &before[before.trim_end().len()..]
    }

    /// White space directly behind a byte.
    pub fn space_behind(&self, at: usize) -> &'t str {
        let behind = &self.text[at..];
        &behind[..behind.len() - behind.trim_start().len()]
    }

    /// Prefix of the name of an element, with its colon; mostly empty.
    pub fn prefix(&self, node: Xml) -> &'t str {
        let name = &self.text[node.range().start + 1..];
        let end = name.find(|c: char| c.is_whitespace() || c == '>' || c == '/').unwrap_or(0);
        name[..end].rfind(':').map_or("", |colon| &name[..=colon])
    }

    /// The changed text.
    pub fn apply(mut self) -> String {
        self.list.sort_by_key(|(range, _)| (range.start, range.end));
        let mut out = String::with_capacity(self.text.len());
        let mut done = 0;
        for (range, new) in &self.list {
            out.push_str(&self.text[done..range.start]);
            out.push_str(new);
            done = range.end;
        }
        out.push_str(&self.text[done..]);
        out
    }
}

/// Coordinates in mm, to 1e-9 m.
pub fn coordinates(point: &Vector) -> [String; 3] {
    [point.x, point.y, point.z].map(|x| decimals(x * 1e3, 6))
}

/// Components of a direction.
pub fn direction(vector: &Vector) -> [String; 3] {
    [vector.x, vector.y, vector.z].map(|x| decimals(x, 9))
}

/// A number with this many decimals, without a negative zero.
pub fn decimals(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(size) if size.bytes().all(|byte| matches!(byte, b'0' | b'.')) => size.to_owned(),
        _ => text,
    }
}

/// A number with 12 significant digits, in the shortest form: lengths of scenarios have nine.
pub fn significant(value: f64) -> String {
    format!("{value:.11e}").parse::<f64>().unwrap_or(value).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_decimal_and_short() {
        assert_eq!([decimals(-1e-9, 6), decimals(-1.25, 6)], ["0.000000", "-1.250000"]);
        assert_eq!([significant(0.3079 / 1e-3), significant(250.0)], ["307.9", "250"]);
        assert_eq!(coordinates(&Vector::new(0.1, -0.2, 1e-9)), ["100.000000", "-200.000000", "0.000001"]);
    }

    #[test]
    fn changes_keep_what_is_around_them() {
        let text = "<a id=\"x\">\r\n <b> 1 <!-- one --></b>\r\n <c/>\r\n</a>";
        let at = |what: &str| text.find(what).unwrap_or_default();
        let mut edits = Edits::new(text, ["x", "y_2"].into_iter());
        edits.insert(at("<c/>"), "<d/>".to_owned());
        edits.replace(at("1 <!")..at("1 <!") + 1, "2".to_owned());
        assert_eq!([edits.space_before(at("<b>")), edits.space_behind(at("</b>") + 4)], ["\r\n ", "\r\n "]);
        assert_eq!(["x", "x", "y", "y"].map(|id| edits.fresh(id)), ["x_2", "x_3", "y", "y_3"]);
        assert_eq!(edits.apply(), "<a id=\"x\">\r\n <b> 2 <!-- one --></b>\r\n <d/><c/>\r\n</a>");
    }
}
