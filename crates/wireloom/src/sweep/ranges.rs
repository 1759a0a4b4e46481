//! Ranges of the points of a sweep that can be computed alone: whole chains.

use std::ops::Range;

/// A range of points that cannot be computed alone, because it is not made of whole chains.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} {}", self.fault(), self.help())]
pub struct NotWhole {
    /// The range that was asked for.
    pub asked: Range<usize>,
    /// Points of a chain.
    pub chain: usize,
    /// Points of the sweep.
    pub points: usize,
}

impl NotWhole {
    /// The smallest range of whole chains around what was asked for.
    pub fn right(&self) -> Range<usize> {
        let first = self.asked.start.min(self.points - 1) / self.chain * self.chain;
        let end = self.asked.end.clamp(first + 1, self.points).next_multiple_of(self.chain).min(self.points);
        first..end
    }

    /// What is wrong with it.
    pub fn fault(&self) -> String {
        let Range { start, end } = self.asked;
        if start >= end {
            format!("the range {start}..{end} has no points: its end does not count.")
        } else if end > self.points {
            format!("the range {start}..{end} ends after the last point: the sweep has the points 0..{}.", self.points)
        } else {
            format!("the range {start}..{end} cuts a chain of points that start from each other.")
        }
    }

    /// What would be right.
    pub fn help(&self) -> String {
        let (Self { chain, points, .. }, right) = (self, self.right());
        format!(
            "Ranges begin at a multiple of {chain} and end at one, or at {points}: {}..{} would be right.",
            right.start, right.end
        )
    }
}

/// The chains that a range of points is made of, by their indices.
pub(super) fn chains(asked: Range<usize>, chain: usize, points: usize) -> Result<Range<usize>, NotWhole> {
    let Range { start, end } = asked;
    let whole = start < end && end <= points && start % chain == 0 && (end % chain == 0 || end == points);
    if whole { Ok(start / chain..end.div_ceil(chain)) } else { Err(NotWhole { asked, chain, points }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_whole_chains_are_taken_and_others_told_what_would_be_right() {
        assert_eq!(chains(0..1500, 64, 1500), Ok(0..24));
        assert_eq!(chains(64..192, 64, 1500), Ok(1..3));
        assert_eq!(chains(1472..1500, 64, 1500), Ok(23..24), "the last chain is shorter");
        let right = |asked: Range<usize>| chains(asked, 64, 1500).expect_err("refused").right();
        assert_eq!(right(10..64), 0..64);
        assert_eq!(right(64..65), 64..128);
        assert_eq!(right(1400..9999), 1344..1500);
        #[expect(clippy::reversed_empty_ranges, reason = "users write them")]
        let reversed = right(200..100);
        assert_eq!((right(7..7), reversed, right(5000..6000)), (0..64, 192..256, 1472..1500));
        let words = chains(10..100, 64, 1500).expect_err("refused").to_string();
        assert!(words.contains("10..100 cuts a chain") && words.contains("0..128 would be right"), "{words}");
    }
}
