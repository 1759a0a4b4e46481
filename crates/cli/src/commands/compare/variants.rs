//! Variants that `wireloom compare` carries out: of one scenario, and those of the harness in a file of another format.

use crate::arguments::CompareArguments;
use crate::arguments::values::setting;
use crate::commands::import::{ACCURACY, HarnessFormat};
use crate::failure::Failure;
use crate::files::load;
use crate::print::text::{counted, printable};
use std::io::{self, Write};
use std::path::Path;
use wireloom::import::kbl::{Options, Selection};
use wireloom::scenario::Setting;

/// One of the runs to be compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variant {
    /// Its name among the others.
    pub name: String,
    /// Its settings.
    pub settings: Vec<Setting>,
}

/// Every combination of the values of the options; none where there are no options.
pub fn variants(arguments: &CompareArguments) -> Result<Vec<Variant>, Failure> {
    let mut axes: Vec<Vec<(String, Setting)>> = vec![];
    let kinds = [
        ("joints.*.model", &arguments.joint),
        ("branches.*.rod", &arguments.rod),
        ("minimiser.kind", &arguments.minimiser),
    ];
    axes.extend(kinds.map(|(key, kinds)| kinds.iter().map(|kind| (kind.clone(), Setting::new(key, kind))).collect()));
    let segments = arguments.segments.iter();
    axes.push(
        segments.map(|n| (format!("{n} segments"), Setting::new("branches.*.segments", n.to_string()))).collect(),
    );
    for set in &arguments.set {
        let Setting { key, value: values } = setting(set)?;
        axes.push(
            listed(&values)
                .into_iter()
                .map(|value| (format!("{key} = {value}"), Setting::new(key.as_str(), value)))
                .collect(),
        );
    }
    axes.retain(|axis| !axis.is_empty());
    let mut all = vec![Variant { name: String::new(), settings: vec![] }];
    // An option with one value is the same for all: it is no part of names.
    let told = axes.iter().any(|axis| axis.len() > 1);
    for axis in &axes {
        let more = |variant: &Variant| {
            let mut more = vec![];
            for (name, setting) in axis {
                let mut next = variant.clone();
                if axis.len() > 1 || !told {
                    next.name = if next.name.is_empty() { name.clone() } else { format!("{}, {name}", next.name) };
                }
                next.settings.push(setting.clone());
                more.push(next);
            }
            more
        };
        all = all.iter().flat_map(more).collect();
    }
    Ok(if axes.is_empty() { vec![] } else { all })
}

/// Variants of the harness in a KBL or VEC file, as installed: names and texts. Those `wanted`, or all that have
/// modules.
pub fn of_file(file: &Path, format: &HarnessFormat, wanted: &[String]) -> Result<Vec<(String, String)>, Failure> {
    let text = load::text(file)?;
    let refused = |error| Failure::Input(format!("{} cannot be imported: {error}", file.display()));
    let names: Vec<String> = if wanted.is_empty() {
        let all = (format.contents)(&text).map_err(refused)?.variants;
        all.into_iter().filter(|variant| !variant.modules.is_empty()).map(|variant| variant.name).collect()
    } else {
        wanted.iter().map(|name| name.trim().to_owned()).collect()
    };
    let mut found: Vec<(String, String)> = Vec::new();
    for name in names {
        if found.iter().any(|(known, _)| *known == name) {
            return Err(Failure::Input(format!("--variants names `{}` twice", printable(&name))));
        }
        let selection = Selection::Variant(name.clone());
        let options = Options { accuracy: Some(ACCURACY), selection, ..Options::default() };
        let imported = (format.import)(&text, &options).map_err(refused)?;
        // If standard error is closed, the work goes on.
        let _ = writeln!(
            io::stderr(),
            "{}: {}; `wireloom {} --variant` tells what they are",
            printable(&name),
            counted(imported.findings.len(), "finding of the import", "findings of the import"),
            format.command,
        );
        found.push((name, imported.scenario));
    }
    Ok(found)
}

/// Values between commas; commas in brackets and quotes belong to a value.
fn listed(text: &str) -> Vec<&str> {
    let (mut values, mut start, mut depth, mut quote) = (vec![], 0, 0, None);
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), c) if open == c => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth -= 1,
            (None, ',') if depth == 0 => {
                values.push(text[start..at].trim());
                start = at + 1;
            }
            (None, _) => {}
        }
    }
    values.push(text[start..].trim());
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::{Arguments, Command};
    use clap::Parser;

    fn names(arguments: &[&str]) -> Vec<String> {
        let all = Arguments::parse_from(["wireloom", "compare", "s.toml"].iter().chain(arguments));
        let Command::Compare(arguments) = all.command else { panic!("it is `compare`") };
        variants(&arguments).unwrap().into_iter().map(|variant| variant.name).collect()
    }

    #[test]
    fn every_combination_has_a_name_that_tells_it_from_the_others() {
        assert_eq!(names(&["--joint", "a,b"]), ["a", "b"]);
        assert_eq!(names(&["--joint", "a,b", "--minimiser", "lbfgs"]), ["a", "b"]);
        assert_eq!(names(&["--segments", "2,4", "--set", "x.y=1"]), ["2 segments", "4 segments"]);
        assert_eq!(names(&["--joint", "a,b", "--set", "x=1,2"]), ["a, x = 1", "a, x = 2", "b, x = 1", "b, x = 2"]);
        assert_eq!(names(&["--set", "x=[1,2],\"a,b\", 500 mm"]), ["x = [1,2]", "x = \"a,b\"", "x = 500 mm"]);
        assert!(names(&[]).is_empty());
    }
}
