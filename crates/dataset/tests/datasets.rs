//! Datasets of rows that are made up: complete or not, damaged, of other sweeps.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use wireloom::export::table::{Cell, Layout, Row, Table, read};
use wireloom::harness::Network;
use wireloom::result::Library;
use wireloom::scenario::NoFiles;
use wireloom::sweep::tubes::Stations;
use wireloom::sweep::{Points, header};
use wireloom_dataset::{Dataset, Error, Manifest, Origin};

const POINTS: usize = 1500;

fn text(seed: usize) -> String {
    let first = fs::read_to_string("../../scenarios/first.toml").expect("the scenario");
    format!(
        "{first}\n[sweep]\nmethod = \"random\"\nsamples = {POINTS}\nseed = {seed}\n[sweep.vary]\n\
         \"branches.trunk.length\" = {{ from = \"590 mm\", to = \"610 mm\" }}\n"
    )
}

/// Works with the points of a sweep with this seed, and its harness.
fn with<T>(seed: usize, work: impl FnOnce(&Points<'_>, &Network) -> T) -> T {
    let (text, registry) = (text(seed), wireloom::registry());
    let (scenario, built) = wireloom::load(&text, &registry).expect("no faults");
    let sweep = scenario.sweep.as_ref().expect("a sweep");
    let points = Points {
        text: &text,
        files: &NoFiles,
        minimiser: None,
        registry: &registry,
        batch: None,
        sweep,
        header: header(sweep, &built.network),
        stations: Stations::of(&built.network, &built.schedule),
    };
    work(&points, &built.network)
}

fn manifest(points: &Points<'_>, network: &Network, columns: Option<&[String]>) -> Result<Manifest, Error> {
    manifest_of("wireloom 1.0", &[], points, network, columns)
}

fn manifest_of(
    program: &str,
    plugins: &[Library],
    points: &Points<'_>,
    network: &Network,
    columns: Option<&[String]>,
) -> Result<Manifest, Error> {
    let texts = [("first.toml".to_owned(), points.text.to_owned())];
    let notes = points.notes(program, "first", "first.toml", &[]);
    let origin = Origin { program, minimiser: None, texts: &texts, hashed: &[], plugins, notes };
    Manifest::of(origin, "first", points, network, columns)
}

/// Rows of some points, chain by chain. Every hundredth has no result.
fn rows(points: &Points<'_>, range: Range<usize>) -> Vec<Vec<Row>> {
    let row = |k: usize| {
        let values = vec![Cell::Number(k as f64 / 3.0)];
        let mut row = points.header.without_result(values, "converged", None);
        if k.is_multiple_of(100) {
            (row.status, row.message) = ("refused".to_owned(), Some(format!("too long\tby {}", k % 3)));
        } else {
            row.numbers.iter_mut().enumerate().for_each(|(n, number)| *number = Some((k * 31 + n) as f64 / 7.0));
        }
        row
    };
    points.chains_of(range).expect("whole chains").map(|chain| points.points_of(chain).map(row).collect()).collect()
}

fn write(dataset: &Dataset, points: &Points<'_>, range: Range<usize>) -> bool {
    let rows = rows(points, range.clone());
    !dataset.write(&range, &points.header, &rows).expect("written").known
}

fn folder() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().join("set").display().to_string();
    (folder, place)
}

fn parts(place: &str) -> Vec<PathBuf> {
    let mut names: Vec<PathBuf> = fs::read_dir(Path::new(place).join("parts"))
        .expect("parts")
        .map(|entry| entry.expect("a part").path())
        .collect();
    names.sort_unstable();
    names
}

fn table(place: &str) -> Table {
    read(fs::read(Path::new(place).join("points.parquet")).expect("a table")).expect("a sound table")
}

/// A dataset with all points, in two parts.
fn complete(points: &Points<'_>, network: &Network, place: &str) -> Dataset {
    let dataset = Dataset::begin(place, manifest(points, network, None).expect("a manifest")).expect("begun");
    assert!(write(&dataset, points, 0..640) && write(&dataset, points, 640..POINTS));
    dataset
}

#[test]
fn parts_of_any_size_in_any_order_and_twice_become_one_sorted_table() {
    with(1, |points, network| {
        let ((_one, first), (_other, second)) = (folder(), folder());
        let ordered = complete(points, network, &first);
        let begin = || Dataset::begin(&second, manifest(points, network, None).expect("a manifest")).expect("begun");
        let mixed = begin();
        assert!(write(&mixed, points, 1472..POINTS) && write(&mixed, points, 0..64));
        assert_eq!(mixed.missing().expect("listed"), vec![64..1472]);
        // Ranges that overlap, and one that is computed twice.
        assert!(write(&begin(), points, 512..1472) && write(&mixed, points, 64..640));
        let part = parts(&second)[1].clone();
        let before = fs::metadata(&part).and_then(|meta| meta.modified()).expect("a time");
        assert!(!write(&mixed, points, 64..640), "it is there already");
        assert_eq!(before, fs::metadata(&part).and_then(|meta| meta.modified()).expect("a time"), "it stays");
        let compacted = [&ordered, &mixed].map(|dataset| dataset.compact(&|_| ()).expect("compacted"));
        assert_eq!(compacted.map(|table| table.rows), [POINTS; 2]);
        let bytes = [&first, &second].map(|place| fs::read(format!("{place}/points.parquet")).expect("a table"));
        assert!(bytes[0] == bytes[1], "the way the points were divided shows");
        let all: Vec<Row> = rows(points, 0..POINTS).concat();
        assert_eq!(table(&first).columns, Layout::new(&points.header).table(0, &all).columns);
        let status = mixed.status().expect("read");
        assert!((status.done, status.compacted, status.is_complete()) == (POINTS, true, true), "{status:?}");
        let failed = &status.failed[0];
        assert_eq!((failed.status.as_str(), failed.reasons.len()), ("refused", 3));
        assert_eq!(failed.reasons[0].0, "too long by 0", "a line of a note has no tabs in a reason");
    });
}

#[test]
fn what_is_missing_is_named_and_nothing_is_compacted() {
    with(1, |points, network| {
        let (_folder, place) = folder();
        let dataset = Dataset::begin(&place, manifest(points, network, None).expect("a manifest")).expect("begun");
        assert_eq!(dataset.pieces(&dataset.missing().expect("listed"), 1000), vec![0..1024, 1024..POINTS]);
        write(&dataset, points, 64..128);
        let error = dataset.compact(&|_| ()).expect_err("points are missing").to_string();
        assert!(error.contains("no part has the points 0..64, 128..1500; compute them"), "{error}");
        assert!(!Path::new(&place).join("points.parquet").exists());
        let status = dataset.status().expect("read");
        assert_eq!((status.done, status.missing), (64, vec![0..64, 128..POINTS]));
        let (_empty, nowhere) = folder();
        let error = Dataset::open(&nowhere).err().expect("there is none").to_string();
        assert!(error.contains("has no sweep.json: give the folder"), "{error}");
        assert!(!Path::new(&nowhere).exists(), "looking makes no folder");
    });
}

#[test]
fn damage_anywhere_in_a_part_is_reported_with_the_range_to_compute_again() {
    with(1, |points, network| {
        let (_folder, place) = folder();
        let dataset = complete(points, network, &place);
        let part = parts(&place)[0].clone();
        let sound = fs::read(&part).expect("a part");
        dataset.compact(&|_| ()).expect("sound");
        let whole = fs::read(format!("{place}/points.parquet")).expect("a table");
        let mut random = fastrand::Rng::with_seed(1);
        let mut noticed = 0;
        for k in 0..300 {
            let mut bytes = sound.clone();
            if k % 10 == 0 {
                bytes.truncate(random.usize(..bytes.len()));
            } else {
                // The footer is small; it gets its share.
                let end = bytes.len();
                let at = if k % 2 == 0 { random.usize(..end) } else { random.usize(end - 8000..end) };
                bytes[at] ^= 1 << random.u32(..8);
            }
            fs::write(&part, bytes).expect("written");
            let _ = dataset.status().expect("status tells of damage");
            match dataset.compact(&|_| ()) {
                Err(Error::Damaged { range, .. }) => {
                    assert_eq!(range, 0..640);
                    noticed += 1;
                }
                Err(other) => panic!("{other}"),
                // The footer also has what no reader of rows looks at, such as least and greatest values.
                Ok(_) => assert!(fs::read(format!("{place}/points.parquet")).expect("a table") == whole),
            }
        }
        assert!(noticed > 150, "{noticed} of 300");
        fs::remove_file(&part).expect("removed");
        assert_eq!(dataset.missing().expect("listed"), vec![0..640]);
        assert!(write(&dataset, points, 0..640) && fs::read(&part).expect("a part") == sound);
        dataset.compact(&|_| ()).expect("sound again");
        let all: Vec<Row> = rows(points, 0..POINTS).concat();
        assert_eq!(table(&place).columns, Layout::new(&points.header).table(0, &all).columns);
    });
}

#[test]
fn another_sweep_or_version_finds_no_place_beside_it_and_the_difference_is_named() {
    let (_folder, place) = folder();
    with(1, |points, network| drop(complete(points, network, &place)));
    let (_other, elsewhere) = folder();
    let refused = |made: Manifest| Dataset::begin(&place, made).err().expect("refused").to_string();
    with(2, |points, network| {
        let words = refused(manifest(points, network, None).expect("a manifest"));
        assert!(words.contains("their scenario has another text; give another folder"), "{words}");
        drop(complete(points, network, &elsewhere));
    });
    with(1, |points, network| {
        let words = refused(manifest_of("wireloom 1.1", &[], points, network, None).expect("a manifest"));
        assert!(words.contains("they are of wireloom 1.0, this is wireloom 1.1"), "{words}");
        let columns = ["force".to_owned()];
        let words = refused(manifest(points, network, Some(&columns)).expect("a manifest"));
        assert!(words.contains("they have the columns all, not point, status, message, force"), "{words}");
        let library = |file: &str, hash: &str| Library {
            name: "tie".into(),
            version: "1".into(),
            file: file.into(),
            hash: hash.into(),
        };
        let of = |file, hash| {
            manifest_of("wireloom 1.0", &[library(file, hash)], points, network, None).expect("a manifest").hash
        };
        assert!(of("/a/tie.so", "1") == of("/b/tie.so", "1") && of("/a/tie.so", "1") != of("/a/tie.so", "2"));
        // A part of the other sweep: by its own name, and by one of this sweep.
        let dataset = Dataset::open(&place).expect("opened");
        let (own, theirs) = (parts(&place)[0].clone(), parts(&elsewhere)[0].clone());
        let foreign = own.with_file_name(theirs.file_name().expect("a name"));
        fs::copy(&theirs, &foreign).expect("copied");
        assert_eq!(dataset.status().expect("read").foreign.len(), 1);
        let words = dataset.compact(&|_| ()).expect_err("refused").to_string();
        assert!(words.contains("has 1 that are no parts of this sweep"), "{words}");
        fs::rename(&foreign, &own).expect("renamed");
        let words = dataset.compact(&|_| ()).expect_err("refused").to_string();
        assert!(words.contains("it is a part of another sweep") && words.contains("points 0..640 again"), "{words}");
        fs::write(Path::new(&place).join("sweep.json"), "{\"format\":2}").expect("written");
        let words = Dataset::open(&place).err().expect("refused").to_string();
        assert!(words.contains("its sweep.json cannot be read"), "{words}");
    });
}

#[test]
fn chosen_columns_come_in_the_order_of_the_table_and_unknown_ones_are_refused() {
    with(1, |points, network| {
        let (_folder, place) = folder();
        let names = ["force", "branches.trunk.length", "status", "margin"].map(str::to_owned);
        let made = manifest(points, network, Some(&names)).expect("a manifest");
        let dataset = Dataset::begin(&place, made).expect("begun");
        write(&dataset, points, 0..POINTS);
        assert_eq!(dataset.compact(&|_| ()).expect("compacted").columns, 6);
        let table = table(&place);
        let found: Vec<&str> = table.columns.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(found, ["point", "branches.trunk.length", "status", "margin", "message", "force"]);
        assert_eq!(wireloom::export::table::statistics::keys(&table), ["branches.trunk.length"]);
        let words = manifest(points, network, Some(&["forces".to_owned()])).expect_err("refused").to_string();
        assert!(words.contains("there is no column `forces`; did you mean `force`?"), "{words}");
    });
}

#[test]
fn places_that_are_none_are_refused_with_what_would_be_right() {
    with(1, |points, network| {
        let (folder, _) = folder();
        let file = folder.path().join("file");
        fs::write(&file, "").expect("written");
        let begin = |place: &str| {
            let made = manifest(points, network, None).expect("a manifest");
            Dataset::begin(place, made).err().expect("refused").to_string()
        };
        let words = begin(&file.join("below").display().to_string());
        assert!(words.contains("cannot make the folder"), "{words}");
        let words = begin("ftp://somewhere/else");
        assert!(
            words.contains("ftp://somewhere/else cannot be written to") && words.contains("give a folder"),
            "{words}"
        );
        if cfg!(not(feature = "cloud")) {
            let words = begin("s3://bucket/sweep");
            assert!(words.contains("without s3:// and other clouds") && words.contains("--features cloud"), "{words}");
        }
    });
}
