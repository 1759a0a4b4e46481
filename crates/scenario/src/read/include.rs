//! Other files that a scenario names and that are read with keys of their own.

use super::entry::Entry;
use super::files::Files;
use super::reader::Reader;
use super::toml_text::table;
use crate::fault::{Fault, Places};
use crate::format::form::Keys;
use crate::span::Span;
use wireloom_core::Registry;

/// Reads another file, named at `span`, as TOML with keys of its own. Its faults are noted at `span`, each with its
/// place in that file.
pub(crate) fn include<T>(
    reader: &Reader<'_>,
    path: &str,
    span: Span,
    keys: &'static Keys,
    read: impl FnOnce(&Entry<'_>) -> T,
) -> Option<T> {
    let text = reader.file(path, span.clone())?;
    let (found, faults) = included(path, &text, reader.files, reader.registry, keys, read);
    let places = Places::of(&text);
    for fault in faults {
        let (line, column) = places.position(fault.span.start);
        reader.fault(span.clone(), format!("{path}:{line}:{column}: {}", fault.message), fault.help);
    }
    found
}

/// Reads a separate text, and returns its faults with their places in it; `name`: its name in messages.
pub(crate) fn included<T>(
    name: &str,
    text: &str,
    files: &dyn Files,
    registry: &Registry,
    keys: &'static Keys,
    read: impl FnOnce(&Entry<'_>) -> T,
) -> (Option<T>, Vec<Fault>) {
    let table = match table(text) {
        Ok(table) => table,
        Err(faults) => return (None, faults),
    };
    let reader = Reader::new(text, files, registry);
    let found = read(&Entry::new(&reader, table.get_ref(), 0..0, keys, name.to_owned()));
    (Some(found), reader.finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::OUTPUT;
    use crate::read::files::NoFiles;

    struct Two;

    impl Files for Two {
        fn read(&self, path: &str) -> Result<String, String> {
            match path {
                "good.toml" => Ok("vtk = true".into()),
                "bad.toml" => Ok("\nvkt = true\ncsv = 3".into()),
                "torn.toml" => Ok("vtk = ".into()),
                _ => Err("no such file".into()),
            }
        }
    }

    #[test]
    fn another_file_is_read_with_keys_of_its_own_and_its_faults_stand_where_it_is_named() {
        let registry = Registry::default();
        let reader = Reader::new("", &Two, &registry);
        let read = |path| include(&reader, path, 3..5, &OUTPUT, |entry| entry.flag("vtk"));
        assert_eq!(read("good.toml"), Some(Some(true)));
        assert_eq!(reader.fault_count(), 0);
        assert_eq!(read("bad.toml"), Some(None));
        assert_eq!(read("torn.toml"), None);
        assert_eq!(read("none.toml"), None);
        let faults = reader.finish();
        assert!(faults.iter().all(|fault| fault.span == (3..5)));
        let said: Vec<&str> = faults.iter().map(|fault| fault.message.as_str()).collect();
        assert_eq!(said[0], "bad.toml:2:1: unknown key `vkt` in bad.toml");
        assert!(said[1].starts_with("torn.toml:1:"), "{}", said[1]);
        assert_eq!(said[2], "cannot read \"none.toml\": no such file");
    }

    #[test]
    fn a_text_without_a_folder_has_no_files() {
        let registry = Registry::default();
        let reader = Reader::new("", &NoFiles, &registry);
        assert_eq!(reader.file("good.toml", 0..0), None);
        assert_eq!(reader.finish()[0].message, "cannot read \"good.toml\": the scenario is a text without a folder");
    }
}
