//! Imports of broken forms of a file.

use wireloom_import::kbl::{ImportError, Imported};

/// Pieces of text that break a file of either format.
const SNIPPETS: [&str; 14] = ["<", ">", "&", "\"", "0", "-", "1e300", "NaN", "inf", "n2", "s1", "w1", " ", "ä"];
/// Broken forms that are tried.
const FORMS: usize = 4000;

/// Deterministic numbers (xorshift64*, Vigna 2016).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % n
    }
}

fn finite(value: &toml::Value) -> bool {
    match value {
        toml::Value::Float(number) => number.is_finite(),
        toml::Value::Array(items) => items.iter().all(finite),
        toml::Value::Table(items) => items.values().all(finite),
        _ => true,
    }
}

/// Imports random broken forms of a file, with further snippets of its format: the numbers of those that are accepted
/// and refused.
///
/// # Panics
/// If one is accepted and is not TOML with branches and finite numbers, or refused without a place.
pub fn mutated(
    file: &str,
    seed: u64,
    more: &[&str],
    import: impl Fn(&str) -> Result<Imported, ImportError>,
) -> [usize; 2] {
    let snippets = [&SNIPPETS[..], more].concat();
    let mut random = Random(seed);
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..FORMS {
        let mut text: Vec<char> = file.chars().collect();
        for _ in 0..=random.below(3) {
            let at = random.below(text.len());
            match random.below(4) {
                0 => drop(text.drain(at..(at + 1 + random.below(40)).min(text.len()))),
                1 => text[at] = char::from(b' ' + random.below(95) as u8),
                2 => drop(text.splice(at..at, snippets[random.below(snippets.len())].chars())),
                // A number or word inside an element gives way to something else.
                _ => {
                    let Some(start) = text[at..].iter().position(|c| *c == '>').map(|i| at + i + 1) else { continue };
                    let Some(end) = text[start..].iter().position(|c| *c == '<').map(|i| start + i) else { continue };
                    drop(text.splice(start..end, snippets[random.below(snippets.len())].chars()));
                }
            }
        }
        let text: String = text.into_iter().collect();
        match import(&text) {
            Ok(imported) => {
                let scenario: toml::Table = toml::from_str(&imported.scenario).unwrap();
                assert!(scenario["branches"].as_array().is_some_and(|branches| !branches.is_empty()));
                assert!(finite(&toml::Value::Table(scenario)), "{text}");
                accepted += 1;
            }
            Err(fault) => {
                assert!(fault.to_string().starts_with(|c: char| c.is_ascii_digit()), "{fault}");
                refused += 1;
            }
        }
    }
    [accepted, refused]
}
