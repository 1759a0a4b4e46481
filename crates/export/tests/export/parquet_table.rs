//! The table of a sweep.

use crate::samples::{run, y_harness};
use std::io;
use wireloom_core::requirement::Verdict;
use wireloom_export::ending::Ending;
use wireloom_export::report::{Points, write_points};
use wireloom_export::table::{Cell, Column, Computed, Header, Layout, REFUSED, Table, Writer, read};

fn table(points: usize) -> Table {
    let ending = Ending::of(&run("y", vec![y_harness()])).unwrap();
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<String>>();
    let constraints: Vec<String> =
        ending.constraints.iter().map(|constraint| constraint.name.clone()).chain(["gone".into()]).collect();
    let header = Header {
        keys: vec![("branches.left.length".into(), true), ("joints.J.model".into(), false)],
        branches: names(&["trunk"]),
        constraints,
        outputs: names(&["slack.sag", "tension.pull"]),
    };
    let row = |k: usize| {
        let values = vec![if k == 1 { Cell::Number(1.0 / 3.0) } else { Cell::Empty }, Cell::Word(format!("model {k}"))];
        if k % 3 == 2 {
            header.without_result(values, REFUSED, Some("too short".into()))
        } else {
            let outputs = vec![0.25, f64::NAN];
            header.row(
                values,
                &ending,
                Computed { outputs, verdict: Some((Verdict::Pass, &[])), ..Computed::default() },
            )
        }
    };
    let rows: Vec<_> = (0..points).map(row).collect();
    Table { notes: vec![("program".into(), "wireloom".into())], ..Layout::new(&header).table(0, &rows) }
}

/// In two pieces.
fn write(table: &Table, out: &mut Vec<u8>) -> io::Result<()> {
    let mut file = Writer::begin(table, out)?;
    for rows in [0..table.rows() / 2, table.rows() / 2..table.rows()] {
        let part = |column: &Column| match column {
            Column::Counts(entries) => Column::Counts(entries[rows.clone()].to_vec()),
            Column::Numbers(entries) => Column::Numbers(entries[rows.clone()].to_vec()),
            Column::Words(entries) => Column::Words(entries[rows.clone()].to_vec()),
            Column::Flags(entries) => Column::Flags(entries[rows.clone()].to_vec()),
        };
        let columns = table.columns.iter().map(|(name, column)| (name.clone(), part(column))).collect();
        file.append(&Table { columns, notes: vec![] })?;
    }
    file.finish()
}

#[test]
fn comes_back_bit_for_bit_with_its_nulls() {
    let table = table(7);
    let mut bytes = Vec::new();
    write(&table, &mut bytes).unwrap();
    let back = read(bytes.clone()).unwrap();
    assert_eq!(back, table);
    let Some(Column::Numbers(lengths)) = back.column("branches.left.length") else { panic!("a column of numbers") };
    assert_eq!(lengths[..3], [None, Some(1.0 / 3.0), None]);
    let Some(Column::Numbers(forces)) = back.column("force.gone") else { panic!("a column of numbers") };
    assert!(forces.iter().all(Option::is_none));
    assert_eq!(
        back.column("slack.sag"),
        Some(&Column::Numbers([Some(0.25), Some(0.25), None].repeat(3)[..7].to_vec()))
    );
    assert_eq!(back.column("tension.pull"), Some(&Column::Numbers(vec![None; 7])));
    let Some(Column::Words(words)) = back.column("message") else { panic!("a column of texts") };
    assert_eq!((words[0].as_deref(), words[2].as_deref()), (None, Some("too short")));
    let mut again = Vec::new();
    write(&back, &mut again).unwrap();
    assert_eq!(bytes, again);
}

#[test]
fn large_ones_are_written_in_pieces() {
    let numbers: Vec<Option<f64>> = (0..200_000).map(|k| (k % 7 > 0).then_some(f64::from(k))).collect();
    let table = Table { columns: vec![("x".into(), Column::Numbers(numbers))], notes: vec![] };
    let mut bytes = Vec::new();
    write(&table, &mut bytes).unwrap();
    assert_eq!(read(bytes).unwrap().columns, table.columns);
}

#[test]
fn what_is_no_table_is_refused() {
    let mut bytes = Vec::new();
    write(&table(3), &mut bytes).unwrap();
    for length in [0, 4, bytes.len() / 2, bytes.len() - 1] {
        assert!(read(bytes[..length].to_vec()).is_err(), "{length}");
    }
}

#[test]
fn the_report_shows_how_results_respond() {
    let numbers = |of: fn(f64) -> f64| Column::Numbers((0..50).map(|k| Some(of(f64::from(k)))).collect());
    let columns = vec![
        ("point".to_owned(), Column::Counts((0..50).map(Some).collect())),
        ("<key>".to_owned(), numbers(|k| 0.1 * k)),
        ("same".to_owned(), numbers(|_| 1.0)),
        ("status".to_owned(), Column::Words(vec![Some("converged".into()); 50])),
        ("max_force".to_owned(), numbers(|k| 5.0 + 2.0 * k)),
        ("min_bend_radius".to_owned(), numbers(|k| if k > 10.0 { f64::INFINITY } else { k })),
        ("energy.total".to_owned(), numbers(|_| 7.0)),
        ("force.plug".to_owned(), numbers(|k| k)),
        ("slack.left arm".to_owned(), numbers(|k| 0.1 - 1e-3 * k)),
    ];
    let table = Table { columns, notes: vec![("wireloom.text".into(), "schema = 1 # <text>".into())] };
    let points = Points { title: "a & b", table: &table, file: "s.toml", program: "wireloom", written: "today" };
    let mut bytes = Vec::new();
    write_points(&points, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.contains("a &amp; b: 50 points") && text.contains("&lt;text&gt;"));
    // From 5 N to 103 N over the whole range of the key, all of it explained by the key.
    assert!(text.contains("+9.800e1") && text.contains("explains 100.0 %"), "{text}");
    // Four results vary, each with a histogram and a response to the one key that does; what was asked for comes first.
    assert_eq!(text.matches("<svg").count(), 8);
    let [whole, asked, part] = ["<summary>max_force [N]", "<summary>slack.left arm [m]", "<summary>force.plug [N]"]
        .map(|summary| text.find(summary).unwrap_or_else(|| panic!("no {summary}")));
    assert!(whole < asked && asked < part);
    assert!(!text.contains("NaN") && !text.contains("<key>"));
}
