//! The trace as JSON, one object a line.
//!
//! | key | meaning |
//! | --- | --- |
//! | `span` | `"new"` or `"close"`, where a span begins or ends |
//! | `name` | name of the span |
//! | `target` | target of an event: `wireloom::iteration`, `wireloom::increment`, `wireloom::step` |
//! | `fields` | fields of the span or event; null where a number is not finite |
//! | `in` | fields of the spans around it, by their names |

use super::fields::{Fields, Kept};
use crate::files::place::Writer;
use serde_json::{Map, Value, json};
use std::io::{self, Write};

/// Writer of the lines. The first error ends the writing and is reported at the end.
pub struct Lines {
    file: Option<Writer>,
    failure: Option<io::Error>,
}

impl Lines {
    /// Into this file.
    pub fn new(file: Writer) -> Self {
        Self { file: Some(file), failure: None }
    }

    /// A span that begins or ends.
    pub fn span(&mut self, what: &str, name: &str, fields: &Fields, outer: &[Kept]) {
        self.line(&json!({ "span": what, "name": name, "fields": fields.object(), "in": around(outer) }));
    }

    /// An event.
    pub fn event(&mut self, target: &str, fields: &Fields, outer: &[Kept]) {
        self.line(&json!({ "target": target, "fields": fields.object(), "in": around(outer) }));
    }

    /// The file, with all lines.
    ///
    /// # Errors
    /// The first that a line met.
    pub fn finish(&mut self) -> io::Result<Writer> {
        let closed = || io::Error::other("it is closed");
        match self.failure.take() {
            Some(error) => Err(error),
            None => self.file.take().ok_or_else(closed),
        }
    }

    fn line(&mut self, object: &Value) {
        let Some(file) = &mut self.file else { return };
        if let Err(error) = writeln!(file, "{object}") {
            self.failure = Some(error);
            self.file = None;
        }
    }
}

/// The spans around something, the outermost first.
fn around(outer: &[Kept]) -> Map<String, Value> {
    outer.iter().rev().map(|span| (span.name.to_owned(), span.fields.object().into())).collect()
}
