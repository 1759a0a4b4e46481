//! Detection of cables that pass through themselves, by the change of their linking number.
//!
//! Twist and writhe of a cable between two ends add up to its linking number. It changes only with the turns of the
//! ends, unless the cable passes through itself or around one of its ends, which changes it by two turns (Călugăreanu
//! 1961, White 1969, Fuller 1971). Beyond its ends the cable is assumed to be straight.

use crate::report::Occurrence;
use crate::report::result::twist_turns;
use crate::report::twist_loss::{Side, holds_twist};
use std::f64::consts::TAU;
use wireloom_core::problem::Problem;
use wireloom_core::rotation::{columns, twist_angle};
use wireloom_core::{EventKind, EventPlace, Rotation, State, Vector};

/// Length of the straight extensions beyond the ends, in lengths of the cable.
const BEYOND: f64 = 1e3;

/// Turn (rad) of a branch's direction at an end above which it is not checked: its straight extension has changed, too.
const FAR: f64 = 1.0;

/// Events of branches that passed through themselves between two states in which no end turned by half a turn or more.
pub(crate) fn self_passing(problem: &Problem<'_>, before: &State, after: &State) -> Vec<Occurrence> {
    let mut occurrences = Vec::new();
    for (b, branch) in problem.network.branches.iter().enumerate() {
        let (old, new) = (before.branch(problem.network, b), after.branch(problem.network, b));
        let ends = [0, new.frames.len() - 1];
        let is_held = |(c, start)| holds_twist(problem, Side { branch: b, c, start });
        if ![(0, true), (ends[1].saturating_sub(1), false)].into_iter().all(is_held) {
            continue;
        }
        let direction = |frames: &[Rotation], c: usize| columns(&frames[c])[2];
        if ends.iter().any(|&c| direction(old.frames, c).angle(&direction(new.frames, c)) > FAR) {
            continue;
        }
        let turned = |c: usize| twist_angle(&(old.frames[c].inverse() * new.frames[c])) / TAU;
        let given = turned(ends[1]) - turned(ends[0]);
        let link = |points: &[Vector], frames| twist_turns(frames) + writhe(points);
        let lost = given - (link(new.points, new.frames) - link(old.points, old.frames));
        let turns = 2.0 * (0.5 * lost).round().abs();
        if turns > 0.0 {
            occurrences.push(Occurrence {
                kind: EventKind::TwistLost,
                place: EventPlace { branch: Some(branch.name.clone()), ..EventPlace::default() },
                value: Some(turns),
                limit: None,
                message: format!(
                    "{turns} turns of twist have gone: the cable passed through itself or around its end; with \
                     contact.cables it does not pass through itself"
                ),
            });
        }
    }
    occurrences
}

/// Writhe of a polygon with straight extensions: the sum over pairs of edges of the solid angle of the directions from
/// which they appear to cross, over 2π (Klenin and Langowski 2000, method 1a).
fn writhe(points: &[Vector]) -> f64 {
    let n = points.len();
    let length: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let beyond = |end: &Vector, inner: &Vector| end + (end - inner).normalize() * (BEYOND * length);
    let mut all = Vec::with_capacity(n + 2);
    all.push(beyond(&points[0], &points[1]));
    all.extend_from_slice(points);
    all.push(beyond(&points[n - 1], &points[n - 2]));
    let mut sum = 0.0;
    for i in 0..=n {
        for j in i + 2..=n {
            sum += crossing([&all[i], &all[i + 1]], [&all[j], &all[j + 1]]);
        }
    }
    sum / TAU
}

/// Solid angle of the directions from which edge `a` appears to cross edge `b`, with the sign of the crossing.
fn crossing(a: [&Vector; 2], b: [&Vector; 2]) -> f64 {
    let [r13, r14, r23, r24] = [b[0] - a[0], b[1] - a[0], b[0] - a[1], b[1] - a[1]];
    let sign = (b[1] - b[0]).cross(&(a[1] - a[0])).dot(&r13);
    let normals = [r13.cross(&r14), r14.cross(&r24), r24.cross(&r23), r23.cross(&r13)].map(|v| v.try_normalize(0.0));
    let [Some(n1), Some(n2), Some(n3), Some(n4)] = normals else { return 0.0 };
    let angle = |p: &Vector, q: &Vector| p.dot(q).clamp(-1.0, 1.0).asin();
    let sum = angle(&n1, &n2) + angle(&n2, &n3) + angle(&n3, &n4) + angle(&n4, &n1);
    if sign == 0.0 { 0.0 } else { sum * sign.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One turn of a helix of pitch angle β: 1 − sin β (Fuller 1971), and minus that if it is left-handed.
    #[test]
    fn a_helix_has_the_writhe_of_its_pitch() {
        for (sense, rise) in [(1.0_f64, 0.2_f64), (-1.0, 0.5)] {
            let turns = 40.0;
            let point = |k: usize| {
                let angle = TAU * k as f64 / 60.0;
                Vector::new(angle.cos(), sense * angle.sin(), rise * angle)
            };
            let points: Vec<Vector> = (0..=60 * turns as usize).map(point).collect();
            let exact = sense * (1.0 - rise / (1.0 + rise * rise).sqrt());
            let found = writhe(&points) / turns;
            assert!((found - exact).abs() < 0.02, "{sense} {rise}: {found}, {exact}");
        }
    }

    /// Two nearly flat loops that differ in their crossing: their writhes differ by 2 and add up to 0.
    #[test]
    fn passing_through_itself_takes_two_turns() {
        let flat = |height: f64| -> Vec<Vector> {
            (0..=60)
                .map(|k| {
                    let t = (k as f64 / 60.0 - 0.5) * 0.75 * TAU;
                    Vector::new(1.5 * t - 3.0 * t.sin(), -3.0 * t.cos(), height * t)
                })
                .collect()
        };
        let (over, under) = (writhe(&flat(1e-4)), writhe(&flat(-1e-4)));
        assert!((over - under).abs() > 1.99 && (over + under).abs() < 1e-9, "{over} {under}");
    }
}
