//! Colours. With a limit: blue, pale blue, orange, red, and dark red beyond it; safe for the common kinds of colour
//! blindness (blue–orange axis). Pieces beyond the limit have a black rim as well, for prints in grey. Without a
//! limit: greys. Pieces that are pulled, pressed or stretched beyond a limit are magenta with a black rim, however they
//! are bent: they are often straight.

use super::limits::Limits;
use wireloom_core::equilibrium::BranchResult;

/// Beyond the limit.
pub const OVER: &str = "#8b0019";
/// Pulled, pressed or stretched beyond a limit.
pub const STRAINED: &str = "#c2149a";
/// A requirement that is neither kept nor broken.
pub const UNRESOLVED: &str = "#8a5200";
/// All requirements are kept.
pub const PASS: &str = "#14632b";
/// Ink of symbols and names.
pub const INK: &str = "#1a1a1a";
/// Grey of the bend `diameter / radius = NEUTRAL_FULL` and beyond: a radius of five diameters.
pub const NEUTRAL_FULL: f64 = 0.2;

/// Steps of a scale: few enough to merge neighbours into one path, too many to be seen.
pub const STEPS: u16 = 24;

const LIMITED: [(f64, [u8; 3]); 5] = [
    (0.0, [0x1f, 0x5a, 0xa6]),
    (0.35, [0x5f, 0xa8, 0xd8]),
    (0.6, [0xf2, 0xc1, 0x4e]),
    (0.8, [0xee, 0x85, 0x2a]),
    (1.0, [0xd6, 0x2f, 0x1f]),
];
const NEUTRAL: [(f64, [u8; 3]); 2] = [(0.0, [0xb4, 0xb4, 0xb4]), (1.0, [0x30, 0x30, 0x30])];

/// Colour of a piece of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// Bend radius limit / bend radius, in steps of the scale.
    Limited(u16),
    /// Bend radius below the limit.
    Over,
    /// Pulled, pressed or stretched beyond a limit.
    Strained,
    /// Diameter / bend radius, in steps of the scale.
    Neutral(u16),
}

impl Paint {
    /// For the segment between nodes `j` and `j + 1`: the worse of its two ends.
    pub fn of(branch: &BranchResult, j: usize, limits: &Limits) -> Self {
        if limits.are_exceeded(branch, j) || limits.are_exceeded(branch, j + 1) {
            return Paint::Strained;
        }
        let curvature = |i: usize| 1.0 / branch.bend_radius[i];
        let use_of_limit = |i: usize| branch.bend_radius_limit_at(i).map(|limit| limit * curvature(i));
        let bend = |i: usize| branch.diameter_at(i) * curvature(i);
        let step = |share: f64| (share.clamp(0.0, 1.0) * f64::from(STEPS)).round() as u16;
        match [j, j + 1].into_iter().filter_map(use_of_limit).reduce(f64::max) {
            Some(share) if share > 1.0 => Paint::Over,
            Some(share) => Paint::Limited(step(share)),
            None => Paint::Neutral(step(bend(j).max(bend(j + 1)) / NEUTRAL_FULL)),
        }
    }

    /// Whether it is beyond a limit.
    pub fn is_beyond(self) -> bool {
        matches!(self, Paint::Over | Paint::Strained)
    }

    /// As `#rrggbb`.
    pub fn hex(self) -> String {
        let share = |step: u16| f64::from(step) / f64::from(STEPS);
        match self {
            Paint::Over => OVER.into(),
            Paint::Strained => STRAINED.into(),
            Paint::Limited(step) => between(&LIMITED, share(step)),
            Paint::Neutral(step) => between(&NEUTRAL, share(step)),
        }
    }
}

fn between(stops: &[(f64, [u8; 3])], t: f64) -> String {
    let upper = stops.iter().position(|(at, _)| *at >= t).unwrap_or(stops.len() - 1).max(1);
    let ((t0, a), (t1, b)) = (stops[upper - 1], stops[upper]);
    let u = (t - t0) / (t1 - t0);
    let [r, g, b] = [0, 1, 2].map(|i| (f64::from(a[i]) * (1.0 - u) + f64::from(b[i]) * u).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_ends_and_stops() {
        assert_eq!(Paint::Limited(0).hex(), "#1f5aa6");
        assert_eq!(Paint::Limited(STEPS).hex(), "#d62f1f");
        assert_eq!(Paint::Neutral(0).hex(), "#b4b4b4");
        assert_eq!(Paint::Neutral(STEPS).hex(), "#303030");
    }
}
