//! Assembles the shaders from their files, validates each in both precisions, and generates Rust code with their names,
//! bindings, workgroup sizes and struct layouts. An invalid shader fails the build, with its location.

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, StorageAccess, TypeInner};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

/// WGSL type for `real`, and the capabilities that naga must assume.
const PRECISIONS: [(&str, Capabilities); 2] = [("f32", Capabilities::empty()), ("f64", Capabilities::FLOAT64)];
/// Structs whose layout is compared with that in Rust.
const STRUCTS: [&str; 3] = ["Offsets", "Range", "Control"];

fn main() {
    println!("cargo::rerun-if-changed=stages");
    println!("cargo::rerun-if-changed=shared");
    let mut names: Vec<String> = fs::read_dir("stages")
        .expect("the folder of the stages")
        .map(|entry| entry.expect("an entry").path().file_stem().expect("a name").to_string_lossy().into_owned())
        .collect();
    names.sort();
    let (mut bindings, mut structs) = (Vec::new(), [String::new(), String::new()]);
    let mut texts = String::new();
    let mut sizes = String::new();
    for name in &names {
        let mut size = 0;
        let mut both = Vec::new();
        for ((real, capabilities), structs) in PRECISIONS.iter().zip(&mut structs) {
            let mut text = format!("alias real = {real};\n");
            import(&format!("stages/{name}.wgsl"), real, &mut BTreeSet::new(), &mut text);
            let module = check(name, real, &text, *capabilities);
            size = workgroup_size(name, &module);
            note_bindings(name, &module, &mut bindings);
            note_structs(&module, structs);
            both.push(text);
        }
        let variant = camel(name);
        writeln!(texts, "            (Stage::{variant}, Real::F32) => {:?},", both[0]).expect("memory");
        writeln!(texts, "            (Stage::{variant}, Real::F64) => {:?},", both[1]).expect("memory");
        writeln!(sizes, "            Stage::{variant} => {size},").expect("memory");
    }
    bindings.sort();
    let out = render(&names, &texts, &sizes, &bindings, &structs);
    let path = Path::new(&env::var("OUT_DIR").expect("cargo sets it")).join("stages.rs");
    fs::write(path, out).expect("the output can be written");
}

/// Appends a file after its imports; each file once. `{real}` in the name of an import is the precision.
fn import(path: &str, real: &str, seen: &mut BTreeSet<String>, text: &mut String) {
    if !seen.insert(path.to_owned()) {
        return;
    }
    let content = fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let (imports, rest): (Vec<&str>, Vec<&str>) = content.lines().partition(|line| line.starts_with("#import "));
    for line in imports {
        let name = line["#import ".len()..].trim().replace("{real}", real);
        import(&format!("shared/{name}.wgsl"), real, seen, text);
    }
    for line in rest.into_iter().filter(|line| !line.trim_start().starts_with("//")) {
        text.push_str(line);
        text.push('\n');
    }
}

fn check(name: &str, real: &str, text: &str, capabilities: Capabilities) -> Module {
    let module = naga::front::wgsl::parse_str(text)
        .unwrap_or_else(|error| panic!("{name} ({real}): {}", error.emit_to_string_with_path(text, name)));
    if let Err(error) = Validator::new(ValidationFlags::all(), capabilities).validate(&module) {
        panic!("{name} ({real}): {}", error.emit_to_string_with_path(text, name));
    }
    module
}

fn workgroup_size(name: &str, module: &Module) -> u32 {
    let [entry] = module.entry_points.as_slice() else { panic!("{name}: one entry point is wanted") };
    assert_eq!(entry.name, "main", "{name}: the entry point is called main");
    let [size, 1, 1] = entry.workgroup_size else { panic!("{name}: workgroups are one-dimensional") };
    size
}

/// Binding, name and access of every resource; all stages must agree.
fn note_bindings(name: &str, module: &Module, bindings: &mut Vec<(u32, String, &'static str)>) {
    for (_, variable) in module.global_variables.iter() {
        let Some(place) = &variable.binding else { continue };
        assert_eq!(place.group, 0, "{name}: all resources are in group 0");
        let access = match variable.space {
            AddressSpace::Uniform => "Uniform",
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => "ReadWrite",
            AddressSpace::Storage { .. } => "Read",
            other => panic!("{name}: {other:?}"),
        };
        let own = (place.binding, variable.name.clone().expect("a name"), access);
        match bindings.iter().find(|(binding, ..)| *binding == own.0) {
            None => bindings.push(own),
            Some(there) => assert_eq!(*there, own, "{name}: a binding of another stage"),
        }
    }
}

/// Size and member offsets of the shared structs, as a Rust array.
fn note_structs(module: &Module, out: &mut String) {
    if !out.is_empty() {
        return;
    }
    for (_, kind) in module.types.iter() {
        let (Some(name), TypeInner::Struct { members, span }) = (&kind.name, &kind.inner) else { continue };
        if STRUCTS.contains(&name.as_str()) {
            let members: Vec<String> = members
                .iter()
                .map(|m| format!("({:?}, {})", m.name.as_deref().unwrap_or_default(), m.offset))
                .collect();
            write!(out, "Record {{ name: {name:?}, size: {span}, members: &[{}] }}, ", members.join(", "))
                .expect("memory");
        }
    }
}

/// `linearise_segments` as `LineariseSegments`.
fn camel(name: &str) -> String {
    let word = |word: &str| {
        let (first, rest) = word.split_at(1);
        first.to_uppercase() + rest
    };
    name.split('_').map(word).collect()
}

fn render(
    names: &[String],
    texts: &str,
    sizes: &str,
    bindings: &[(u32, String, &'static str)],
    structs: &[String; 2],
) -> String {
    let variants: Vec<String> =
        names.iter().map(|name| format!("    /// `stages/{name}.wgsl`.\n    {},\n", camel(name))).collect();
    let all: Vec<String> = names.iter().map(|name| format!("Stage::{}", camel(name))).collect();
    let words: Vec<String> =
        names.iter().map(|name| format!("            Stage::{} => {name:?},\n", camel(name))).collect();
    let bindings: Vec<String> = bindings
        .iter()
        .map(|(place, name, access)| format!("Binding {{ place: {place}, name: {name:?}, access: Access::{access} }}"))
        .collect();
    format!(
        "/// A step of the computation: a WGSL file of `stages/`.\n\
         #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]\npub enum Stage {{\n{}}}\n\n\
         impl Stage {{\n    /// All stages.\n    pub const ALL: &'static [Stage] = &[{}];\n\n\
         /// Name of the stage and of its file.\n    pub fn name(self) -> &'static str {{\n\
         match self {{\n{}        }}\n    }}\n\n\
         /// Complete source text; the entry point is `main`.\n    pub fn text(self, real: Real) -> &'static str {{\n\
         match (self, real) {{\n{texts}        }}\n    }}\n\n\
         /// Number of invocations in a workgroup.\n    pub fn workgroup_size(self) -> u32 {{\n\
         match self {{\n{sizes}        }}\n    }}\n}}\n\n\
         /// Bindings of the stages, all in group 0; the same for every stage.\n\
         pub const BINDINGS: &[Binding] = &[{}];\n\n\
         /// Struct layouts of the shaders, for f32 and for f64.\n\
         pub const RECORDS: [&[Record]; 2] = [&[{}], &[{}]];\n",
        variants.concat(),
        all.join(", "),
        words.concat(),
        bindings.join(", "),
        structs[0],
        structs[1],
    )
}
