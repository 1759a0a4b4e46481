//! What the text of a STEP file shows without being read: whether it is one, and whether it is whole.

use crate::error::StepError;

const BEGIN: &[u8] = b"ISO-10303-21";
const END: &[u8] = b"END-ISO-10303-21";
/// Characters of the file in a message.
const SHOWN: usize = 40;

/// Refuses what is no STEP file, and one without its end.
pub(crate) fn check(bytes: &[u8]) -> Result<(), StepError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii();
    if text.is_empty() {
        return Err(StepError::Empty);
    }
    // Comments may stand before it.
    let begins = text.starts_with(BEGIN) || text.starts_with(b"/*") && first(text, BEGIN).is_some();
    if !begins {
        let begin = &text[..text.len().min(SHOWN)];
        return Err(StepError::NotStep { found: shown(begin.split(|byte| *byte == b'\n').next().unwrap_or_default()) });
    }
    if !text.windows(END.len()).rev().any(|window| window == END) {
        let last = text.rsplit(|byte| *byte == b'\n').next().unwrap_or_default();
        let last = &last[last.len().saturating_sub(SHOWN)..];
        return Err(StepError::Truncated { line: line(bytes, bytes.trim_ascii_end().len()), found: shown(last) });
    }
    Ok(())
}

/// Line of a context of shapes that says no unit of length.
pub(crate) fn line_of_units(bytes: &[u8]) -> usize {
    let words: [&[u8]; 3] = [b"GLOBAL_UNIT_ASSIGNED_CONTEXT", b"GEOMETRIC_REPRESENTATION_CONTEXT", b"DATA;"];
    words.iter().find_map(|word| first(bytes, word)).map_or(1, |at| line(bytes, at))
}

fn first(bytes: &[u8], word: &[u8]) -> Option<usize> {
    bytes.windows(word.len()).position(|window| window == word)
}

/// Line of a place, from 1.
fn line(bytes: &[u8], at: usize) -> usize {
    bytes[..at].iter().filter(|byte| **byte == b'\n').count() + 1
}

fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).chars().map(|c| if c.is_control() { '.' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        {
            let error = check(text.as_bytes()).expect_err("a refusal");
            format!("line {}: {error}", error.line().unwrap_or_default())
        }
    }

    #[test]
    fn what_is_no_whole_step_file_is_refused_with_its_line() {
        assert_eq!(refusal(" \n"), "line 1: the file is empty");
        let other = "solid part\nendsolid part\n";
        assert_eq!(refusal(other), "line 1: it is no STEP file: it begins with `solid part`, not with `ISO-10303-21;`");
        let cut = "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1 = PRODUCT(\n";
        assert_eq!(refusal(cut), "line 5: it is cut off: it ends with `#1 = PRODUCT(`, not with `END-ISO-10303-21;`");
        let whole = "/* by hand */\nISO-10303-21;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n";
        assert!(check(whole.as_bytes()).is_ok());
        assert_eq!(line_of_units(whole.as_bytes()), 3);
    }

    #[test]
    fn any_bytes_are_refused_without_a_panic() {
        for bytes in [&b"\xef\xbb\xbf"[..], b"\xff\xfe\x00", b"/*", b"/* ISO-10303-21", b"ISO-10303-21"] {
            assert!(check(bytes).is_err());
        }
    }
}
