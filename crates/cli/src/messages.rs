//! Messages between a sweep and the processes that compute its chains of points ([`crate::commands`]: `sweep` starts
//! them with the subcommand `sweep-process`).
//!
//! Requests are lines of JSON on the process's standard input; the process ends with it. Messages are lines of JSON on
//! its standard output, after a mark: plugins may print other lines.

use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use wireloom::sweep::tubes::Lines;
use wireloom::sweep::{Chain, Row, Without, Work};

/// Mark of lines that are messages.
const MARK: &str = "@wireloom ";

/// A chain to be computed.
#[derive(Serialize, Deserialize)]
pub struct Request {
    /// Its index.
    pub chain: usize,
    /// Points of it that are not computed.
    pub without: Without,
}

/// What a process tells.
#[derive(Serialize, Deserialize)]
pub enum Message {
    /// It has read the scenario; hash of everything that the points depend on.
    Ready(String),
    /// It works on a point.
    Work(Work),
    /// A chain that is done ([`Computed::encode`]).
    Chain(String),
    /// A plugin has ended the process.
    Fault {
        /// Whether that was because a call did not return.
        late: bool,
        /// Plugin, function, and what happened.
        reason: String,
    },
}

impl Message {
    /// Writes a message.
    pub fn send(&self, out: &mut dyn Write) -> io::Result<()> {
        // A plugin may have begun a line.
        writeln!(out, "\n{MARK}{}", serde_json::to_string(self)?)?;
        out.flush()
    }

    /// The message in a line; `None`: it is something else.
    pub fn read(line: &str) -> Option<Self> {
        serde_json::from_str(line.strip_prefix(MARK)?).ok()
    }
}

/// Cells of a swept space: place and values of each block.
pub type Blocks = Vec<([i32; 3], Vec<f32>)>;

/// A chain that was computed, as it is stored.
#[derive(Serialize, Deserialize)]
pub struct Computed {
    /// Its rows.
    pub rows: Vec<Row>,
    /// Space that the harness sweeps at its points, if the sweep asks for it; `Some(None)`: it takes too much memory.
    pub swept: Option<Option<Blocks>>,
    /// Centre lines of each of its points, if the sweep asks for the space swept.
    pub lines: Vec<Lines>,
}

impl Computed {
    /// A chain.
    pub fn of(chain: Chain) -> Self {
        let blocks = |(place, phi): ([i32; 3], &[f32])| (place, phi.to_vec());
        let swept = chain.swept.map(|swept| Some(swept.ok()?.blocks().into_iter().map(blocks).collect()));
        Self { rows: chain.rows, swept, lines: chain.lines }
    }

    /// As text: postcard, in hexadecimal. JSON has no infinite numbers.
    pub fn encode(&self) -> io::Result<String> {
        let bytes = postcard::to_stdvec(self).map_err(io::Error::other)?;
        let digit = |half: u8| char::from(DIGITS[usize::from(half)]);
        Ok(bytes.iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 15)]).collect())
    }

    /// From this text; `None`: it is damaged.
    pub fn decode(text: &str) -> Option<Self> {
        let half = |digit: u8| DIGITS.iter().position(|known| *known == digit);
        let byte = |pair: &[u8]| u8::try_from(16 * half(pair[0])? + half(*pair.get(1)?)?).ok();
        let bytes = text.as_bytes().chunks(2).map(byte).collect::<Option<Vec<u8>>>()?;
        postcard::from_bytes(&bytes).ok()
    }
}

/// Hexadecimal digits.
const DIGITS: &[u8; 16] = b"0123456789abcdef";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_read_as_it_was_written_and_other_lines_are_no_messages() {
        let row = Row {
            values: vec![],
            status: "converged".to_owned(),
            message: Some("größer\n".to_owned()),
            stable: Some(true),
            events: String::new(),
            verdict: None,
            sheet: vec![],
            numbers: vec![Some(f64::INFINITY), None, Some(-0.0), Some(0.1 + 0.2)],
        };
        let swept = Some(Some(vec![([-1, 0, 7], vec![0.5, f32::MIN_POSITIVE])]));
        let chain = Computed { rows: vec![row], swept, lines: vec![vec![vec![0.25, -1.5]]] };
        let mut line = vec![];
        Message::Chain(chain.encode().expect("text")).send(&mut line).expect("room");
        let line = String::from_utf8(line).expect("text");
        let Some(Message::Chain(text)) = Message::read(line.trim()) else { panic!("{line}") };
        let read = Computed::decode(&text).expect("a chain");
        assert!(read.rows == chain.rows && read.swept == chain.swept && read.lines == chain.lines);
        assert!(Computed::decode(&text[1..]).is_none());
        assert!(Message::read("the plugin says hello").is_none());
    }
}
