//! Inputs made from good ones by small random changes, for whatever reads bytes: it may refuse them, but never panic on
//! one, nor think it over for long. Equal seeds give equal inputs, and each is made by itself: a failure names the
//! number of its input.

use fastrand::Rng;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

/// Numbers that break things, as text has them.
const NUMBERS: [&str; 22] = [
    "0",
    "-1",
    "1",
    "2",
    "255",
    "65536",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "1e9",
    "1e-9",
    "1e16",
    "1e154",
    "1e308",
    "-1e308",
    "1e-320",
    "1e999",
    "nan",
    "inf",
    "0.1",
    "-0",
];
/// Numbers that break things, as bytes have them.
const WHOLE: [u64; 12] = [
    0,
    1,
    2,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    0x7ff0_0000_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0xffff_ffff_ffff_ffff,
];
/// No input becomes longer than this, bytes.
const LONGEST: usize = 1 << 17;

/// Inputs to try a reader with.
#[derive(Clone, Copy, Debug)]
pub struct Fuzz<'c> {
    /// Name of the reader under test, for messages.
    pub name: &'c str,
    /// Good inputs; at least one.
    pub corpus: &'c [Vec<u8>],
    /// Words of the format, to be put in anywhere.
    pub words: &'c [&'c str],
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of inputs.
    pub inputs: u64,
    /// No input may take longer.
    pub patience: Duration,
}

impl Fuzz<'_> {
    /// Input number `k`.
    ///
    /// # Panics
    /// If the corpus is empty.
    pub fn input(&self, k: u64) -> Vec<u8> {
        let mut rng = Rng::with_seed(self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ k);
        let mut bytes = self.corpus[rng.usize(..self.corpus.len())].clone();
        // The first inputs are the good ones; most of the others differ from them in little.
        if k < self.corpus.len() as u64 {
            return self.corpus[k as usize].clone();
        }
        let most = [1, 2, 4, 12][rng.usize(..4)];
        for _ in 0..=rng.usize(..most) {
            self.change(&mut bytes, &mut rng);
            bytes.truncate(LONGEST);
        }
        bytes
    }

    fn change(&self, bytes: &mut Vec<u8>, rng: &mut Rng) {
        let at = rng.usize(..=bytes.len());
        let some = |rng: &mut Rng, left: usize| {
            let most = [1, 4, 16, 256][rng.usize(..4)];
            rng.usize(..=left.min(most))
        };
        match rng.u8(..10) {
            0 if at < bytes.len() => bytes[at] ^= 1 << rng.u8(..8),
            1 if at < bytes.len() => bytes[at] = rng.u8(..),
            2 => {
                let end = at + some(rng, bytes.len() - at);
                bytes.drain(at..end);
            }
            3 => {
                // What is there, again, once or very often.
                let piece = bytes[at..at + some(rng, bytes.len() - at)].to_vec();
                let times = if rng.u8(..8) == 0 { rng.usize(..2000) } else { 1 };
                bytes.splice(at..at, piece.repeat(times).into_iter().take(LONGEST));
            }
            4 => {
                let other = &self.corpus[rng.usize(..self.corpus.len())];
                let from = rng.usize(..=other.len());
                let piece = other[from..from + some(rng, other.len() - from)].to_vec();
                bytes.splice(at..at, piece);
            }
            5 if !self.words.is_empty() => {
                let word = self.words[rng.usize(..self.words.len())];
                bytes.splice(at..at, word.bytes());
            }
            6 => {
                let size = [1, 2, 4, 8][rng.usize(..4)].min(bytes.len() - at);
                let mut whole = WHOLE[rng.usize(..WHOLE.len())].to_le_bytes();
                if rng.bool() {
                    whole[..size].reverse();
                }
                bytes[at..at + size].copy_from_slice(&whole[..size]);
            }
            7 => {
                // A line elsewhere.
                let start = bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |k| k + 1);
                let end = bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |k| at + k + 1);
                let line: Vec<u8> =
                    if rng.bool() { bytes.drain(start..end).collect() } else { bytes[start..end].to_vec() };
                let to = rng.usize(..=bytes.len());
                let to = bytes[..to].iter().rposition(|b| *b == b'\n').map_or(0, |k| k + 1);
                bytes.splice(to..to, line);
            }
            _ => {
                // The next number becomes another one.
                let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|k| at + k) else { return };
                let part = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'e' | b'E' | b'-' | b'+');
                let end = bytes[start..].iter().position(|b| !part(b)).map_or(bytes.len(), |k| start + k);
                bytes.splice(start..end, NUMBERS[rng.usize(..NUMBERS.len())].bytes());
            }
        }
    }

    /// Gives every input to a reader, which says whether it took it. Returns how many it took, and the longest time.
    ///
    /// # Panics
    /// If the reader panics or takes longer than it may; the message has the number of the input and its text.
    pub fn hunt(&self, mut reads: impl FnMut(&[u8]) -> bool) -> (u64, Duration) {
        let (mut taken, mut slowest) = (0, Duration::ZERO);
        for k in 0..self.inputs {
            let bytes = self.input(k);
            let begun = Instant::now();
            let read = catch_unwind(AssertUnwindSafe(|| reads(&bytes)));
            let time = begun.elapsed();
            slowest = slowest.max(time);
            let said = || String::from_utf8_lossy(&bytes[..bytes.len().min(6000)]).into_owned();
            assert!(time <= self.patience, "{}: input {k} of seed {} took {time:?}:\n{}", self.name, self.seed, said());
            match read {
                Ok(read) => taken += u64::from(read),
                Err(_) => panic!("{}: input {k} of seed {} made it panic:\n{}", self.name, self.seed, said()),
            }
        }
        (taken, slowest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fuzz<'c>(corpus: &'c [Vec<u8>], inputs: u64) -> Fuzz<'c> {
        Fuzz { name: "a reader", corpus, words: &["word"], seed: 1, inputs, patience: Duration::from_secs(60) }
    }

    #[test]
    fn equal_seeds_give_equal_inputs_that_differ_from_each_other() {
        let corpus = [b"a = 1.5\nb = [2, 3]\n".to_vec(), b"c = 4\n".to_vec()];
        let all = |seed| (0..200).map(|k| Fuzz { seed, ..fuzz(&corpus, 0) }.input(k)).collect::<Vec<_>>();
        assert_eq!(all(1), all(1));
        assert_ne!(all(1), all(2));
        assert_eq!(all(1)[..2], corpus);
        let different: std::collections::HashSet<_> = all(1).into_iter().collect();
        assert!(different.len() > 150, "{} of 200 differ", different.len());
    }

    #[test]
    #[should_panic(expected = "made it panic")]
    fn a_reader_that_panics_is_found() {
        let corpus = [b"length = 1.5\n".to_vec()];
        fuzz(&corpus, 5000).hunt(|bytes| {
            assert!(!bytes.windows(5).any(|w| w == b"1e308"), "too much");
            true
        });
    }
}
