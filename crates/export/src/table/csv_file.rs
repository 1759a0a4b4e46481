//! Tables as CSV files.

use super::{Column, Table};
use std::io::{self, Write};

/// Writes the rows of a table as CSV, after the names of its columns where `heading` says so. Null is an empty field;
/// numbers are written so that they are read back bit for bit.
///
/// # Errors
/// Those of `out`.
pub fn write_csv(table: &Table, heading: bool, out: &mut impl Write) -> io::Result<()> {
    let mut file = csv::Writer::from_writer(out);
    if heading {
        file.write_record(table.columns.iter().map(|(name, _)| name))?;
    }
    for row in 0..table.rows() {
        file.write_record(table.columns.iter().map(|(_, column)| field(column, row)))?;
    }
    file.flush()
}

fn field(column: &Column, row: usize) -> String {
    let text = match column {
        Column::Counts(entries) => entries[row].map(|x| x.to_string()),
        Column::Numbers(entries) => entries[row].map(|x| format!("{x:?}")),
        Column::Words(entries) => entries[row].clone(),
        Column::Flags(entries) => entries[row].map(|x| x.to_string()),
    };
    text.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_with_commas_and_missing_numbers_are_read_back() {
        let columns = vec![
            ("fails".to_owned(), Column::Words(vec![Some("bend, \"loop\"".into()), None])),
            ("margin".to_owned(), Column::Numbers(vec![None, Some(-0.1)])),
        ];
        let mut out = Vec::new();
        let table = Table { columns, notes: vec![] };
        write_csv(&table, true, &mut out).expect("written");
        write_csv(&table, false, &mut out).expect("written");
        let rows = "\"bend, \"\"loop\"\"\",\n,-0.1\n";
        assert_eq!(String::from_utf8(out).expect("text"), format!("fails,margin\n{rows}{rows}"));
    }
}
