//! Tables of numbers as text, separated by commas, with the places of their lines.

use csv::{ReaderBuilder, StringRecord, Trim};
use std::ops::Range;
use wireloom_scenario::Fault;

/// A table.
pub struct Table {
    /// Names of the columns.
    pub headers: StringRecord,
    /// Place of their line, bytes.
    pub header_line: Range<usize>,
    /// Place and cells of each line that has a cell for each column.
    pub records: Vec<(Range<usize>, StringRecord)>,
    /// Faults of other lines.
    pub faults: Vec<Fault>,
}

/// A fault at a place of the text.
pub fn fault(span: Range<usize>, message: String, help: String) -> Fault {
    Fault { span, message, help }
}

/// Reads a table. Empty lines, and those that begin with `#`, are skipped.
///
/// # Errors
/// If there is no line of columns; `help` says how to write it.
pub fn read(text: &str, help: &str) -> Result<Table, Vec<Fault>> {
    let start = text.len() - text.trim_start_matches('\u{feff}').len();
    let mut reader =
        ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).flexible(true).from_reader(&text.as_bytes()[start..]);
    let line_at = |at: usize| {
        let at = (start + at).min(text.len());
        // The reader's places are before the empty lines and comments that it skips.
        let skipped = |line: &&str| line.trim().is_empty() || line.starts_with('#');
        let skip: usize = text[at..].split_inclusive('\n').take_while(skipped).map(str::len).sum();
        let begin = at + skip;
        let length = text[begin..].find('\n').unwrap_or(text.len() - begin);
        begin..begin + text[begin..begin + length].trim_end().len()
    };
    let headers = match reader.headers() {
        Ok(headers) => headers.clone(),
        Err(error) => return Err(vec![fault(line_at(0), error.to_string(), help.to_owned())]),
    };
    let (mut records, mut faults) = (Vec::new(), Vec::new());
    for record in reader.records() {
        match record {
            Ok(record) => {
                let line = line_at(record.position().map_or(0, |place| place.byte() as usize));
                if record.len() == headers.len() {
                    records.push((line, record));
                    continue;
                }
                let message = format!("this line has {} cells, the header has {}", record.len(), headers.len());
                let help = "write one cell for each column; leave it empty where nothing was measured";
                faults.push(fault(line, message, help.to_owned()));
            }
            Err(error) => {
                let at = error.position().map_or(0, |place| place.byte() as usize);
                faults.push(fault(line_at(at), error.to_string(), help.to_owned()));
            }
        }
    }
    Ok(Table { headers, header_line: line_at(0), records, faults })
}
