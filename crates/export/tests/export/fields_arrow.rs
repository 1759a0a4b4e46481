//! Node fields beside `result.json`.

use crate::samples::{among_obstacles, run, y_harness};
use arrow_array::Array;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type};
use arrow_ipc::reader::FileReader;
use std::io::{Cursor, Error, ErrorKind};
use wireloom_core::equilibrium::{FrictionResult, Run};
use wireloom_export::ending::Ending;
use wireloom_export::fields;
use wireloom_export::json::{self, Opened, Provenance};

/// Two steps; one branch has friction.
fn sample() -> Run {
    let mut second = y_harness();
    second.name = "pull".into();
    second.branches[0].position[1].x = f64::NAN;
    let set = second.branches[1].position.clone();
    second.branches[1].friction = Some(FrictionResult { set, dissipated: 0.1, dissipated_in_all: 0.1 / 3.0 });
    run("y", vec![y_harness(), second])
}

/// `result.json` without fields, and `fields.arrow`.
fn written(run: &Run) -> (Vec<u8>, Vec<u8>) {
    let (mut light, mut arrow) = (vec![], vec![]);
    json::write_without_fields(run, &Provenance::default(), &mut light).expect("written");
    fields::write(run, &mut arrow).expect("written");
    (light, arrow)
}

fn whole(run: &Run) -> Vec<u8> {
    let mut text = vec![];
    json::write(run, &Provenance::default(), &mut text).expect("written");
    text
}

/// The same run, by both readers and by the lazy one.
fn read(light: &[u8], arrow: &[u8]) -> Result<[Run; 2], Error> {
    let eager = json::read_run_with(light, || Ok(Cursor::new(arrow)))?;
    json::read_with(light, || Ok(Cursor::new(arrow)))?;
    let mut opened = Opened::open(Cursor::new(light), || Ok(Cursor::new(arrow)))?;
    let mut lazy = opened.run.clone();
    for k in (0..opened.len()).rev() {
        lazy.steps.insert(0, opened.step(k)?.expect("a step"));
    }
    assert!(opened.step(lazy.steps.len())?.is_none());
    Ok([eager, lazy])
}

#[test]
fn results_in_two_files_are_those_of_one() {
    for run in [sample(), among_obstacles(), Run { steps: vec![], ..sample() }] {
        let (light, arrow) = written(&run);
        let expected = whole(&run);
        let by_text = json::read_run(expected.as_slice()).expect("a result");
        for read in read(&light, &arrow).expect("a result") {
            // Not a number is unequal to itself, so the texts are compared.
            assert_eq!(format!("{read:?}"), format!("{by_text:?}"));
        }
        let end = json::read_with(light.as_slice(), || Ok(Cursor::new(&arrow))).expect("a result");
        assert_eq!(format!("{end:?}"), format!("{:?}", json::read(expected.as_slice()).expect("a result")));
        assert_eq!(end.is_some(), Ending::of(&run).is_some());
        if !run.steps.is_empty() {
            assert!(light.len() < expected.len() / 2, "{} of {}", light.len(), expected.len());
        }
        // A result of one file is opened, too, and then no other one is asked for.
        let none = || Err(Error::from(ErrorKind::NotFound));
        let mut opened = Opened::open(Cursor::new(&expected), none).expect("a result");
        assert!(!opened.has_fields_apart() && opened.len() == run.steps.len());
        let steps: Vec<_> = (0..opened.len()).filter_map(|k| opened.step(k).expect("a step")).collect();
        assert_eq!(format!("{steps:?}"), format!("{:?}", by_text.steps));
    }
}

/// Other programs find the columns that the documentation names, with the numbers of the result.
#[test]
fn the_table_has_a_row_for_each_node() {
    let run = sample();
    let (_, arrow) = written(&run);
    let reader = FileReader::try_new(Cursor::new(arrow), None).expect("an Arrow file");
    let schema = reader.schema();
    let names: Vec<&str> = schema.fields().iter().map(|field| field.name().as_str()).collect();
    let expected =
        ["step", "increment", "branch", "s", "position", "d3", "d1", "force", "moment", "bend_radius", "set"];
    assert_eq!(names, expected);
    assert_eq!(schema.field(7).metadata()["unit"], "N");
    let batches: Vec<_> = reader.collect::<Result<_, _>>().expect("batches");
    assert_eq!(batches.len(), 2);
    for (batch, step) in batches.iter().zip(&run.steps) {
        let rows = step.branches.iter().flat_map(|branch| (0..branch.s.len()).map(move |k| (branch, k)));
        let words = |column: usize, row: usize| {
            let names = batch.column(column).as_dictionary::<Int32Type>();
            names.values().as_string::<i32>().value(names.keys().value(row) as usize).to_owned()
        };
        let mut count = 0;
        for (row, (branch, k)) in rows.enumerate() {
            assert_eq!((words(0, row), words(2, row)), (step.name.clone(), branch.name.clone()));
            assert_eq!(batch.column(3).as_primitive::<Float64Type>().value(row), branch.s[k]);
            let force = batch.column(7).as_fixed_size_list().value(row);
            assert_eq!(force.as_primitive::<Float64Type>().values(), branch.force[k].as_slice());
            assert_eq!(batch.column(10).is_null(row), branch.friction.is_none());
            count += 1;
        }
        assert_eq!(batch.num_rows(), count);
    }
    let without = Run { steps: vec![y_harness()], ..run };
    let reader = FileReader::try_new(Cursor::new(written(&without).1), None).expect("an Arrow file");
    assert!(reader.schema().field_with_name("set").is_err());
}

#[test]
fn fields_of_another_run_and_damaged_ones_are_refused() {
    let run = sample();
    let (light, arrow) = written(&run);
    let refusal = |light: &[u8], arrow: &[u8]| read(light, arrow).expect_err("no result").to_string();
    // A run that differs in one bit, as one after a small change of the scenario may.
    let mut other = run.clone();
    let x = &mut other.steps[1].branches[0].moment[2].x;
    *x = f64::from_bits(x.to_bits() ^ 1);
    assert_eq!(
        refusal(&light, &written(&other).1),
        "fields.arrow: equilibrium 2 is not the one of result.json, or it is damaged"
    );
    let one = Run { steps: vec![y_harness()], ..run.clone() };
    let said = refusal(&light, &written(&one).1);
    assert_eq!(said, "fields.arrow has 1 equilibria, result.json has 2: they are of different runs");
    // Without the other file, and where it is missing.
    let said = json::read_run(light.as_slice()).expect_err("no fields").to_string();
    assert_eq!(said, "the fields of its nodes are in `fields.arrow`, which was not given");
    let missing = json::read_run_with(light.as_slice(), || Err::<Cursor<Vec<u8>>, _>(ErrorKind::NotFound.into()));
    assert_eq!(missing.expect_err("no fields").kind(), ErrorKind::NotFound);
    // Every length, and every byte that belongs to an equilibrium.
    for length in 0..arrow.len() {
        assert!(read(&light, &arrow[..length]).is_err(), "{length} bytes");
    }
    let [right, _] = read(&light, &arrow).expect("a result").map(|run| format!("{run:?}"));
    for k in 0..arrow.len() {
        let mut changed = arrow.clone();
        changed[k] ^= 1 << (k % 8);
        // In what is beside the equilibria, a change may do no harm.
        if let Ok([eager, lazy]) = read(&light, &changed) {
            assert!(format!("{eager:?}") == right && format!("{lazy:?}") == right, "byte {k}");
        }
    }
}

#[test]
fn what_does_not_fit_in_the_text_is_named() {
    let (light, arrow) = written(&sample());
    let text = String::from_utf8(light).expect("text");
    let said = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        read(text.replacen(from, to, 1).as_bytes(), &arrow).expect_err("no result").to_string()
    };
    assert_eq!(
        said("\"fields\":\"fields.arrow\"", "\"fields\":\"../fields.arrow\""),
        "fields: \"../fields.arrow\" is no file of fields, which is \"fields.arrow\""
    );
    assert_eq!(said("\"fields\":\"fields.arrow\",", ""), "missing field `fields`, beside `fields_sha256` of steps");
    let nodes = sample().steps[0].branches[0].s.len();
    let key = format!("\"nodes\":{nodes},");
    assert_eq!(said(&key, ""), "steps[0].branches.trunk: missing field `s`");
    assert_eq!(
        said(&key, &format!("{key}\"s\":[],")),
        "steps[0].branches.trunk: both `nodes`, for lists in another file, and the list `s`"
    );
    let wrong = format!("\"nodes\":{},", nodes + 1);
    assert!(said(&key, &wrong).contains("equilibrium 1 is not the one of result.json"));
}
