//! Imports among the files of a crate, and the rings in them.
//!
//! A file imports another one if it names a path into it, in a `use` or in code. Re-exports (`pub use`) do not count:
//! a module that only declares and re-exports its children imports nothing. Test modules are left out.
#![allow(clippy::missing_panics_doc, reason = "sources that cannot be read end the test")]

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Path of a module, from the root of its crate.
type Module = Vec<String>;

/// Modules of a crate that have files of their own.
#[derive(Default)]
struct Crate {
    files: BTreeMap<Module, File>,
}

/// Paths that a file names, each with the (inline) module in which it stands.
#[derive(Default)]
struct File {
    paths: Vec<(Module, Vec<String>)>,
    /// Names that `pub use` gives to paths.
    exports: BTreeMap<String, (Module, Vec<String>)>,
}

/// Groups of files that import each other in a ring, in the sources below a folder with a `lib.rs` or `main.rs`.
pub fn rings(sources: &Path) -> Vec<Vec<String>> {
    let root = ["lib.rs", "main.rs"].map(|name| sources.join(name)).into_iter().find(|file| file.exists());
    let mut all = Crate::default();
    all.read(&root.expect("a root of a crate"), sources, vec![]);
    let modules: Vec<&Module> = all.files.keys().collect();
    let n = modules.len();
    let mut reaches = vec![vec![false; n]; n];
    for (from, (module, file)) in all.files.iter().enumerate() {
        for target in file.paths.iter().filter_map(|(place, path)| all.target(place, path, 0)) {
            let to = modules.binary_search(&&target).expect("a file");
            reaches[from][to] |= *module != target;
        }
    }
    for via in 0..n {
        let onward = reaches[via].clone();
        for row in reaches.iter_mut().filter(|row| row[via]) {
            row.iter_mut().zip(&onward).for_each(|(reaches, more)| *reaches |= more);
        }
    }
    let mut rings = BTreeSet::new();
    for (from, row) in reaches.iter().enumerate().filter(|(from, row)| row[*from]) {
        let name = |k: usize| if modules[k].is_empty() { "the root".to_owned() } else { modules[k].join("::") };
        rings.insert((0..n).filter(|to| row[*to] && reaches[*to][from]).map(name).collect::<Vec<_>>());
    }
    rings.into_iter().collect()
}

impl Crate {
    /// Reads the file of a module, and those of its children, which lie in `folder`.
    fn read(&mut self, file: &Path, folder: &Path, module: Module) {
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let tokens: TokenStream = text.parse().unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let (mut found, mut children) = (File::default(), vec![]);
        found.read(tokens, &module, &mut children);
        for child in children {
            let name = child.last().expect("a name");
            let inner =
                child[module.len()..child.len() - 1].iter().fold(folder.to_owned(), |path, part| path.join(part));
            let flat = inner.join(format!("{name}.rs"));
            let file = if flat.exists() { flat } else { inner.join(name).join("mod.rs") };
            self.read(&file, &inner.join(name), child);
        }
        self.files.insert(module, found);
    }

    /// File that a path leads to, if it is one of this crate.
    fn target(&self, place: &Module, path: &[String], depth: usize) -> Option<Module> {
        let (mut at, mut rest) = (place.clone(), path);
        match path.first()?.as_str() {
            "crate" => (at, rest) = (vec![], &path[1..]),
            "self" => rest = &path[1..],
            "super" => {
                while rest.first().is_some_and(|part| part == "super") {
                    at.pop();
                    rest = &rest[1..];
                }
            }
            first => {
                if !self.files.contains_key(&[place.as_slice(), &[first.to_owned()]].concat()) {
                    return None;
                }
            }
        }
        while let Some(part) = rest.first() {
            let inner = [at.as_slice(), std::slice::from_ref(part)].concat();
            if !self.files.contains_key(&inner) {
                break;
            }
            (at, rest) = (inner, &rest[1..]);
        }
        // An inline module belongs to the file around it.
        while !self.files.contains_key(&at) {
            at.pop();
        }
        let export = rest.first().and_then(|name| self.files[&at].exports.get(name)).filter(|_| depth < 8);
        export.and_then(|(place, path)| self.target(place, path, depth + 1)).or(Some(at))
    }
}

impl File {
    /// Collects paths of some tokens, and modules that have files of their own.
    fn read(&mut self, tokens: TokenStream, module: &Module, children: &mut Vec<Module>) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut k = 0;
        while k < tokens.len() {
            if is_test(&tokens[k..]) {
                // The item ends with a block or a semicolon.
                let ends = |token: &TokenTree| is(token, ';') || group(token, Delimiter::Brace).is_some();
                k += tokens[k..].iter().position(ends).map_or(tokens.len(), |length| length + 1);
                continue;
            }
            match word(&tokens[k]).as_deref() {
                Some("use") => {
                    let length = tokens[k..].iter().position(|token| is(token, ';')).unwrap_or(1);
                    let public = tokens[..k].iter().rev().find(|token| group(token, Delimiter::Parenthesis).is_none());
                    let public = public.and_then(word).is_some_and(|word| word == "pub");
                    for (path, name) in leaves(&tokens[k + 1..k + length], &[]) {
                        match public {
                            true => drop(self.exports.insert(name, (module.clone(), path))),
                            false => self.paths.push((module.clone(), path)),
                        }
                    }
                    k += length;
                }
                Some("mod") if tokens.get(k + 1).and_then(word).is_some() => {
                    let inner = [module.as_slice(), &[word(&tokens[k + 1]).expect("a name")]].concat();
                    match tokens.get(k + 2).and_then(|token| group(token, Delimiter::Brace)) {
                        Some(block) => self.read(block, &inner, children),
                        None => children.push(inner),
                    }
                    k += 3;
                }
                Some(_) => {
                    let path = path(&tokens[k..]);
                    let length = 3 * path.len() - 2;
                    let member = k > 0 && (is(&tokens[k - 1], ':') && k > 1 && is(&tokens[k - 2], ':'));
                    if path.len() > 1 && !member {
                        self.paths.push((module.clone(), path));
                    }
                    k += length;
                }
                None => {
                    if let TokenTree::Group(group) = &tokens[k] {
                        self.read(group.stream(), module, children);
                    }
                    k += 1;
                }
            }
        }
    }
}

/// Whether an attribute says that an item is there in tests only.
fn is_test(tokens: &[TokenTree]) -> bool {
    let [hash, attribute, ..] = tokens else { return false };
    let words = |stream: TokenStream| stream.to_string().replace(' ', "");
    is(hash, '#')
        && group(attribute, Delimiter::Bracket)
            .map(words)
            .is_some_and(|text| text == "cfg(test)" || text.starts_with("cfg(all(test,"))
}

/// Leaves of the tree of a `use`: paths, and the names that they get.
fn leaves(tree: &[TokenTree], prefix: &[String]) -> Vec<(Vec<String>, String)> {
    let own = path(tree);
    let full = [prefix, &own].concat();
    let rest = &tree[(3 * own.len()).saturating_sub(2).min(tree.len())..];
    if let Some(block) = rest.iter().find_map(|token| group(token, Delimiter::Brace)) {
        let tokens: Vec<TokenTree> = block.into_iter().collect();
        return tokens
            .split(|token| is(token, ','))
            .filter(|part| !part.is_empty())
            .flat_map(|p| leaves(p, &full))
            .collect();
    }
    let name = match rest {
        [as_, name, ..] if word(as_).is_some_and(|word| word == "as") => word(name),
        _ => full.last().cloned(),
    };
    vec![(full, name.unwrap_or_default())]
}

/// Words joined by `::` at the beginning of some tokens.
fn path(tokens: &[TokenTree]) -> Vec<String> {
    let mut path: Vec<String> = tokens.first().and_then(word).into_iter().collect();
    while let [first, second, third, ..] = &tokens[(3 * path.len()).saturating_sub(2).min(tokens.len())..]
        && is(first, ':')
        && is(second, ':')
        && let Some(next) = word(third)
        && !path.is_empty()
    {
        path.push(next);
    }
    path
}

fn word(token: &TokenTree) -> Option<String> {
    if let TokenTree::Ident(word) = token { Some(word.to_string()) } else { None }
}

fn is(token: &TokenTree, character: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == character)
}

fn group(token: &TokenTree, delimiter: Delimiter) -> Option<TokenStream> {
    match token {
        TokenTree::Group(group) if group.delimiter() == delimiter => Some(group.stream()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::rings;
    use std::fs;

    fn found(files: &[(&str, &str)]) -> Vec<Vec<String>> {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("written");
        }
        rings(folder.path())
    }

    #[test]
    fn rings_are_found_in_uses_and_in_code() {
        let ring = [["a".to_owned(), "b".to_owned()].to_vec()];
        assert_eq!(
            found(&[("lib.rs", "mod a; mod b;"), ("a.rs", "use crate::b::B;"), ("b.rs", "use super::a::A;")]),
            ring
        );
        let code = "fn f() { vec![crate::a::A] }";
        assert_eq!(found(&[("lib.rs", "mod a; mod b;"), ("a.rs", "use crate::{b::{C, B}};"), ("b.rs", code)]), ring);
        let through =
            [("lib.rs", "mod a; mod b; pub use a::A;"), ("a.rs", "use crate::b::B;"), ("b.rs", "use crate::A;")];
        assert_eq!(found(&through), ring, "through a re-export");
    }

    #[test]
    fn re_exports_comments_texts_and_tests_are_no_imports() {
        let child = "use super::shared::S; #[cfg(test)] mod tests { use crate::a::A; }";
        let files = [
            ("lib.rs", "mod a; /* crate::a::b */"),
            ("a.rs", "mod b; mod shared; pub use b::B; // use b::B;\nconst TEXT: &str = \"b::B\";"),
            ("a/b.rs", child),
            ("a/shared.rs", "pub struct S;"),
        ];
        assert_eq!(found(&files), Vec::<Vec<String>>::new());
    }
}
