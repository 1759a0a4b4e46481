//! The C header matches this crate, and a C compiler agrees with Rust about the layout of every struct.

use std::fmt::Write;
use std::mem::{align_of, offset_of, size_of};
use std::path::{Path, PathBuf};
use std::process::Command;
use wireloom_abi::*;

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn header() -> PathBuf {
    here().join("include/wireloom_plugin.h")
}

/// Structs of the header. C has no modules, so each gets the prefix `Wireloom`.
const STRUCTS: &[&str] = &[
    "Text",
    "Entry",
    "Kinds",
    "Kind",
    "Parameter",
    "Value",
    "Pose",
    "Station",
    "Span",
    "ConstraintKind",
    "Output",
    "ConstraintSpec",
    "Description",
    "Hold",
    "Situation",
    "Evaluation",
    "JointKind",
    "Arm",
    "WireShare",
    "JointSpec",
    "JointDescription",
    "JointEvaluation",
    "RodKind",
    "RodSpec",
    "RodDescription",
    "RodResponse",
    "RodCommit",
    "Notes",
];

/// Prefixes of constants.
const CONSTANTS: &[&str] = &[
    "MAGIC",
    "ABI_",
    "STATUS_",
    "FAMILY_",
    "FORM_",
    "PRESENCE_",
    "QUANTITY_",
    "SHAPE_",
    "ROTATION_",
    "HOLD_",
    "MOUNTING_",
    "EXTENSION_",
];

/// `WIRELOOM_MAGIC` for `MAGIC`.
fn constants() -> Vec<String> {
    let source = std::fs::read_to_string(here().join("src/lib.rs")).expect("the source");
    let named = source.lines().filter_map(|line| line.strip_prefix("pub const ")?.split(':').next());
    let names: Vec<String> = named.map(str::to_owned).collect();
    assert!(names.iter().all(|name| CONSTANTS.iter().any(|prefix| name.starts_with(prefix))), "{names:?}");
    names
}

fn generated() -> String {
    let mut config = cbindgen::Config {
        language: cbindgen::Language::C,
        include_guard: Some("WIRELOOM_PLUGIN_H".into()),
        no_includes: true,
        sys_includes: vec!["stddef.h".into(), "stdint.h".into()],
        cpp_compat: true,
        documentation_style: cbindgen::DocumentationStyle::C99,
        style: cbindgen::Style::Both,
        usize_is_size_t: true,
        line_length: 120,
        tab_width: 4,
        header: Some(HEAD.into()),
        after_includes: Some(EXPORT.into()),
        ..cbindgen::Config::default()
    };
    for name in STRUCTS {
        config.export.include.push((*name).into());
        config.export.rename.insert((*name).into(), format!("Wireloom{name}"));
    }
    for name in constants() {
        config.export.include.push(name.clone());
        config.export.rename.insert(name.clone(), format!("WIRELOOM_{name}"));
    }
    let mut text = vec![];
    cbindgen::Builder::new()
        .with_config(config)
        .with_src(here().join("src/lib.rs"))
        .with_src(here().join("src/draft.rs"))
        .with_src(here().join("src/rod.rs"))
        .generate()
        .expect("C can say all of it")
        .write(&mut text);
    // Links of Rust's documentation have no meaning in C.
    String::from_utf8(text).expect("UTF-8").replace("[`", "`").replace("`]", "`")
}

const HEAD: &str = "\
// Plugins for Wireloom: what crosses the boundary. Made from crates/abi; do not edit.
//
// A plugin defines one symbol, WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = { ... };
// The rules (strings, memory, threads, versions) and a guide stand in crates/plugin/README.md.";

const EXPORT: &str = r#"
#if defined(__cplusplus)
#define WIRELOOM_C extern "C"
#else
#define WIRELOOM_C
#endif
#if defined(_WIN32)
#define WIRELOOM_EXPORT WIRELOOM_C __declspec(dllexport)
#else
#define WIRELOOM_EXPORT WIRELOOM_C __attribute__((visibility("default")))
#endif

// Its functions receive it.
struct WireloomKind;"#;

#[test]
fn the_header_is_current() {
    let want = generated();
    if std::env::var("WIRELOOM_HEADER").is_ok_and(|wish| wish == "write") {
        std::fs::write(header(), &want).expect("the header can be written");
    }
    let is = std::fs::read_to_string(header()).unwrap_or_default();
    assert!(is == want, "write it anew: WIRELOOM_HEADER=write cargo test -p wireloom-abi");
}

/// A C file that does not compile if the two languages disagree.
fn layout() -> String {
    let mut c = String::from("#include \"wireloom_plugin.h\"\n");
    macro_rules! same {
        ($($name:ident { $($field:ident),+ $(,)? })+) => {$(
            let name = stringify!($name);
            let (size, alignment) = (size_of::<$name>(), align_of::<$name>());
            writeln!(c, "_Static_assert(sizeof(Wireloom{name}) == {size}, \"size of {name}\");").unwrap();
            writeln!(c, "_Static_assert(_Alignof(Wireloom{name}) == {alignment}, \"alignment of {name}\");").unwrap();
            $(
                let (f, offset) = (stringify!($field), offset_of!($name, $field));
                writeln!(c, "_Static_assert(offsetof(Wireloom{name}, {f}) == {offset}, \"{name}.{f}\");").unwrap();
            )+
            let fields: &[&str] = &[$(stringify!($field)),+];
            assert_eq!(fields, fields_of(name), "fields of {name}");
        )+
        let named: Vec<&str> = vec![$(stringify!($name)),+];
        assert!(STRUCTS.iter().all(|name| *name == "Notes" || named.contains(name)), "a struct is missing");
        };
    }
    same! {
        Text { data, capacity }
        Entry { magic, size, abi_major, abi_minor, reserved, name, version, doc, kinds, get_extension }
        Kinds { size, count, stride, reserved, first }
        Kind { family, parameter_count, parameter_stride, reserved, name, doc, parameters, constraint, joint, rod }
        Parameter {
            name, doc, form, quantity, presence, minimum_excluded, minimum, maximum, default_value, choices,
            choice_count, reserved,
        }
        Value { value, given, reserved }
        Pose { position, orientation }
        ConstraintKind {
            size, stations_min, stations_max, span, create, destroy, evaluate, target, commit, output_count,
            output_stride, outputs, report,
        }
        Output { name, doc, quantity, reserved, event, reserved_last }
        ConstraintSpec {
            size, station_count, station_stride, value_count, name, stations, span, values, tangent_given, up_given,
            hold, free_axis_given, free_axis,
            rails, rail_count, reserved,
        }
        Station { branch, arc_length, diameter }
        Span { size, reserved, branch, begins, ends, diameter }
        Description {
            size, shape, needs_frames, objective, thread_safe, has_gradient, has_hessian, memory_count, memory,
            residual_count,
            node_residual_count, inequalities, scales, hold,
        }
        Hold { position, rotation, axis, rails, rail_count, reserved }
        Situation {
            size, station_count, span_count, memory_count, stations, targets, span, span_lengths, memory, progress,
            tensions,
        }
        Evaluation {
            size, reserved, energy, gradient, span_gradient, hessian, span_hessian, residuals, jacobian,
            span_jacobian, weights,
        }
        JointKind { size, reserved, create, destroy, evaluate, commit }
        Arm {
            branch, starts_here, reserved, rest, offset, curvature, segment_length, diameter, linear_density,
            axial_stiffness, shear_stiffness,
            bending_stiffness, torsion_stiffness, length, spring_bending, spring_torsion,
        }
        WireShare { from, to, share }
        JointSpec { size, arm_count, arm_stride, wire_count, name, arms, wires, values, value_count, reserved }
        JointDescription {
            size, mounting, thread_safe, has_gradient, has_hessian, reserved, memory, memory_count, reserved_too,
        }
        JointEvaluation { size, arm_count, energy, gradient, hessian, memory }
        RodKind { size, reserved, create, destroy, stretch, bend, commit }
        RodSpec {
            size, value_count, name, values, length, curvature, diameter, linear_density, axial_stiffness,
            shear_stiffness, bending_stiffness, torsion_stiffness,
        }
        RodDescription { size, has_stretch, has_bend, has_hessian, thread_safe, memory_count }
        RodResponse { size, count, energy, gradient, hessian, memory, duration }
        RodCommit { size, count, memory, dissipated, duration }
    }
    c
}

/// Fields of a struct as the source lists them.
fn fields_of(name: &str) -> Vec<&'static str> {
    let sources: [&'static str; 2] = [include_str!("../src/lib.rs"), include_str!("../src/rod.rs")];
    let begin = format!("pub struct {name} {{\n");
    let body = sources.iter().find_map(|source| source.split(&begin).nth(1)).expect("a struct of this name");
    let body = body.split("\n}").next().expect("its end");
    body.lines().filter_map(|line| line.strip_prefix("    pub ")?.split(':').next()).collect()
}

#[test]
fn c_lays_out_every_struct_as_rust_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("layout.c");
    std::fs::write(&file, layout()).expect("a file");
    for strict in [&["-std=c11"][..], &["-std=c17", "-Wpedantic"]] {
        let done = Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()))
            .args(strict)
            .args(["-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I"])
            .arg(here().join("include"))
            .arg(&file)
            .output()
            .expect("a C compiler, `cc` or what CC names: plugins may be written in C, and their header is tested");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    }
}
