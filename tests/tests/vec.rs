//! `wireloom import vec`: from a file to a result.

use std::fs;
use std::path::PathBuf;
use wireloom_tests::place::Place;
use wireloom_tests::root;

/// A file of the tests of the importer.
fn file(name: &str) -> PathBuf {
    root().join("crates/import/tests").join(name)
}

/// A place with the small harness as KBL and as VEC.
fn place() -> Place {
    let place = Place::new("");
    for name in ["small.kbl", "small.vec"] {
        place.file(name, fs::read(file(name)).expect("the file"));
    }
    place
}

#[test]
fn a_vec_file_becomes_the_scenario_of_the_same_harness_as_kbl_and_runs() {
    let place = place();
    let ended = place.run(&["import", "vec", "small.vec", "-o", "s.toml", "--spacing", "5 mm"]);
    ended.says(0, &["element of the file ", "OnPointPlacement "]);
    assert!(ended.out.starts_with("wrote s.toml ("), "{ended:#?}");
    place.run(&["run", "s.toml", "--out", "o", "--quiet"]).says(0, &[]);
    place.run(&["import", "kbl", "small.kbl", "-o", "k.toml", "--spacing", "5 mm"]).says(0, &[]);
    let harness = |name: &str| -> Vec<String> {
        let text = place.text(name);
        let (begin, end) = (text.find("[[branches]]").expect("branches"), text.find("[[components]]").expect("more"));
        text[begin..end].lines().filter(|line| !line.starts_with("kbl = ")).map(str::to_owned).collect()
    };
    assert_eq!(harness("s.toml"), harness("k.toml"));
}

#[test]
fn a_file_of_the_other_format_is_refused_with_its_command() {
    let place = place();
    place
        .run(&["import", "vec", "small.kbl"])
        .says(1, &["small.kbl cannot be imported: 4:1: ", "`wireloom import kbl`"]);
    place
        .run(&["import", "kbl", "small.vec"])
        .says(1, &["small.vec cannot be imported: 3:1: ", "`wireloom import vec`"]);
    place.run(&["import", "vec", "small.vec", "--list"]).says(0, &[]);
}

#[test]
fn without_3d_geometry_a_harness_lies_on_a_board() {
    let place = place();
    let text = place.text("small.vec");
    let at = |what: &str| text.find(what).expect(what);
    let (from, to) = ("<Specification xsi:type=\"vec:BuildingBlock", "<Specification xsi:type=\"vec:Composition");
    place.file("flat.vec", [&text[..at(from)], &text[at(to)..]].concat());
    place.run(&["import", "vec", "flat.vec"]).says(1, &["no 3D geometry", "--as board"]);
    place.run(&["import", "vec", "flat.vec", "--as", "board", "-o", "b.toml"]).says(0, &[]);
    place.run(&["formboard", "flat.vec", "-o", "board"]).says(0, &[]);
    assert!(place.path("board/board.pdf").exists());
}
