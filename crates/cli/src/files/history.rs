//! Histories of measurements: files with one JSON document a line, to which `bench --history` appends.

use super::load;
use crate::failure::Failure;
use serde_json::Value;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What the key `document` of every line says.
pub const DOCUMENT: &str = "wireloom bench";
/// Version of the form of a line, key `schema`.
pub const SCHEMA: u64 = 1;

/// A history that is open to be appended to; what it has is never changed.
#[derive(Debug)]
pub struct History {
    file: File,
    path: PathBuf,
}

impl History {
    /// Opens a history, or begins one where there is no file.
    ///
    /// # Errors
    /// If the file has anything but lines of a history, or cannot be read or written.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        if path.exists() {
            check(&load::text(path)?, path)?;
        }
        let file = OpenOptions::new().append(true).create(true).open(path).map_err(Failure::io("write", path))?;
        Ok(Self { file, path: path.to_owned() })
    }

    /// Appends a document as one line.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn append(&mut self, document: &Value) -> Result<(), Failure> {
        // One call: lines of programs that measure at the same time do not mix.
        self.file.write_all(format!("{document}\n").as_bytes()).map_err(Failure::io("write", &self.path))
    }
}

/// Every line must be a whole document of [`DOCUMENT`] in this form.
fn check(text: &str, path: &Path) -> Result<(), Failure> {
    let refused = |line: usize, why: String| {
        Failure::Input(format!(
            "{}:{line}: no line of a history of `wireloom bench`: {why}\nnothing was changed; name another file, or \
             one that does not exist",
            path.display()
        ))
    };
    for (k, line) in text.lines().enumerate() {
        let document: Value = serde_json::from_str(line).map_err(|error| refused(k + 1, error.to_string()))?;
        if document["document"] != DOCUMENT {
            return Err(refused(k + 1, format!("its key `document` is not {DOCUMENT:?}")));
        }
        if document["schema"] != SCHEMA {
            return Err(refused(k + 1, format!("its key `schema` is {}, not {SCHEMA}", document["schema"])));
        }
    }
    match text.is_empty() || text.ends_with('\n') {
        true => Ok(()),
        false => Err(refused(text.lines().count(), "it has no end; add a line break".to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn line(k: usize) -> Value {
        json!({ "document": DOCUMENT, "schema": SCHEMA, "k": k })
    }

    #[test]
    fn lines_are_added_to_what_there_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("history.jsonl");
        for k in 0..3 {
            History::open(&path).and_then(|mut history| history.append(&line(k))).expect("a sound history");
        }
        let text = std::fs::read_to_string(&path).expect("it is there");
        let found: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
        assert_eq!(found, [line(0), line(1), line(2)]);
    }

    #[test]
    fn a_foreign_file_is_refused_and_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("history.jsonl");
        let own = line(0).to_string();
        let newer = own.replace("\"schema\":1", "\"schema\":2");
        let cases = [
            ("schema = 1\n".to_owned(), ":1: "),
            ("{}\n".to_owned(), "key `document`"),
            (format!("{own}\n[1, 2]\n"), ":2: "),
            (format!("{own}\n\n"), ":2: "),
            (format!("{own}\n{newer}\n"), "key `schema` is 2, not 1"),
            (own.clone(), "has no end"),
            (format!("{own}\n{}", &own[..9]), ":2: "),
        ];
        for (text, words) in cases {
            std::fs::write(&path, &text).expect("room");
            let failure = History::open(&path).expect_err(&text);
            assert!(failure.code() == 1 && failure.to_string().contains(words), "{text}: {failure}");
            assert_eq!(std::fs::read_to_string(&path).expect("it is there"), text);
        }
        std::fs::write(&path, [0xff, b'\n']).expect("room");
        assert!(History::open(&path).expect_err("no text").to_string().contains("not UTF-8"));
    }

    #[test]
    fn a_folder_or_a_path_without_folder_is_no_history() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(History::open(folder.path()).is_err());
        assert_eq!(History::open(&folder.path().join("no/history.jsonl")).expect_err("no folder").code(), 3);
    }
}
