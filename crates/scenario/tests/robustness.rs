//! No input makes the reader panic, and every fault lies within the text.

mod common;

use wireloom_scenario::parse;

const HARNESS: &str = include_str!("harness.toml");

fn survives(text: &str) {
    if let Err(faults) = parse(text, &common::registry()) {
        assert!(!faults.is_empty());
        for fault in faults {
            assert!(fault.span.start <= fault.span.end && fault.span.end <= text.len(), "{fault:?}");
            assert!(!fault.message.is_empty() && !fault.help.is_empty(), "{fault:?}");
            let (line, column) = fault.position(text);
            assert!(line >= 1 && column >= 1);
        }
    }
}

#[test]
fn truncated_files() {
    for end in (0..HARNESS.len()).filter(|end| HARNESS.is_char_boundary(*end)) {
        survives(&HARNESS[..end]);
    }
}

#[test]
fn files_with_a_line_missing_or_twice() {
    let lines: Vec<&str> = HARNESS.lines().collect();
    for k in 0..lines.len() {
        survives(&[&lines[..k], &lines[k + 1..]].concat().join("\n"));
        survives(&[&lines[..=k], &lines[k..]].concat().join("\n"));
    }
}

#[test]
fn files_with_a_value_of_another_type_or_size() {
    let values = [
        "0",
        "-1",
        "1e308",
        "-1e-308",
        "inf",
        "nan",
        "true",
        "\"\"",
        "\"J\"",
        "\"1e300 km\"",
        "[]",
        "[[]]",
        "{}",
        "[0, 0, 0]",
        "[1e200, 1, 1]",
        "[1, 0, 0, 0]",
        "[{}]",
        "{ end = \"A\" }",
        "1979-05-27",
        "99999999999999999999",
        "0x1F",
        "\"µ²/\"",
    ];
    let lines: Vec<&str> = HARNESS.lines().collect();
    for (k, line) in lines.iter().enumerate() {
        let Some((key, _)) = line.split_once(" = ") else { continue };
        for value in values {
            let changed = format!("{key} = {value}");
            survives(&[&lines[..k], &[changed.as_str()], &lines[k + 1..]].concat().join("\n"));
        }
    }
}

#[test]
fn files_with_numbers_exchanged() {
    let numbers: Vec<(usize, &str)> = HARNESS.match_indices(|c: char| c.is_ascii_digit()).collect();
    for (at, _) in numbers {
        for digit in ["0", "9", "-", "e9", "_"] {
            survives(&format!("{}{digit}{}", &HARNESS[..at], &HARNESS[at + 1..]));
        }
    }
}

/// Pieces of the file in a random order, from a fixed sequence of pseudo-random numbers (xorshift).
#[test]
fn shuffled_files() {
    let pieces: Vec<&str> = HARNESS.split_inclusive(['\n', ' ', ',', '=']).collect();
    let mut x = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = |n: usize| {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        (x % n as u64) as usize
    };
    for _ in 0..500 {
        let mut shuffled = pieces.clone();
        for _ in 0..1 + random(4) {
            let (a, b) = (random(shuffled.len()), random(shuffled.len()));
            shuffled.swap(a, b);
        }
        survives(&shuffled.concat());
    }
}

#[test]
fn deep_nesting() {
    survives(&format!("a = {}", "[".repeat(100_000)));
    survives(&format!("a = {}", "{a=".repeat(100_000)));
    survives(&"[a.".repeat(10_000));
}
