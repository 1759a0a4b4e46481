//! Provisional places of clips that close at the nearest place of a branch.

use crate::attachment::At;
use crate::scenario::{Branch, Constraint, Load, SectionPart};
use wireloom_core::Vector;

/// Attachments closer than this fraction of the branch leave no room for another one between them.
const CROWDED: f64 = 0.02;

/// Gives clips that close at the nearest place a provisional one, apart from everything else on the branch: at the
/// place of their seat along the drawn path, or along the known points of the branch, or else in the middle of the
/// longest free span. Their order along the branch remains.
pub(crate) fn place_nearest(constraints: &mut [Constraint], loads: &[Load], branches: &[Branch]) {
    let on = |at: At| if let At::Branch { branch, s } = at { Some((branch, s)) } else { None };
    let placed =
        constraints.iter().filter(|c| !c.nearest).flat_map(|c| c.places()).chain(loads.iter().flat_map(Load::places));
    let mut taken: Vec<(usize, f64)> = placed.filter_map(on).collect();
    let seats = constraints.iter().filter(|c| !c.nearest);
    let seats: Vec<((usize, f64), Vector)> = seats.filter_map(|c| Some((on(c.place())?, c.position?))).collect();
    for constraint in constraints.iter_mut().filter(|c| c.nearest) {
        let At::Branch { branch, .. } = constraint.place() else { continue };
        let Some(own) = branches.get(branch) else { continue };
        let mut places: Vec<f64> = taken.iter().filter(|(b, _)| *b == branch).map(|(_, s)| *s).collect();
        places.extend([0.0, own.length]);
        places.sort_by(f64::total_cmp);
        let mut known = drawn(own);
        if known.is_empty() {
            known.extend(seats.iter().filter(|((b, _), _)| *b == branch).map(|((_, s), seat)| (*s, *seat)));
            known.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let guess = constraint.position.and_then(|seat| nearest_on(&known, &seat, own.length));
        let free = |s: &f64| places.iter().all(|place| (place - s).abs() > CROWDED * own.length);
        let s = guess.filter(free).or_else(|| {
            let longest = places.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
            Some(0.5 * (longest[0] + longest[1]))
        });
        let s = beside_changes(&own.section_spans(), own.length, s.unwrap_or(0.5 * own.length));
        constraint.at = vec![At::Branch { branch, s }];
        taken.push((branch, s));
    }
}

/// The place itself, or one apart from where the section changes on a branch of this length (m), on the same side.
fn beside_changes(spans: &[SectionPart], length: f64, s: f64) -> f64 {
    let Some(own) = spans.iter().find(|span| s <= span.range[1]) else { return s };
    let [from, to] = own.range;
    let apart = (CROWDED * length).min(0.25 * (to - from));
    let (first, last) = (spans[0].range[0], spans[spans.len() - 1].range[1]);
    let low = if from > first { from + apart } else { from };
    let high = if to < last { to - apart } else { to };
    s.clamp(low, high)
}

/// Arc lengths (m) and points of a branch's drawn path, scaled to the length of the branch.
fn drawn(branch: &Branch) -> Vec<(f64, Vector)> {
    let mut along = 0.0;
    let mut points: Vec<(f64, Vector)> = Vec::new();
    for point in &branch.path {
        along += points.last().map_or(0.0, |(_, last)| (point - last).norm());
        points.push((along, *point));
    }
    points.iter().map(|(s, point)| (s * branch.length / along, *point)).collect()
}

/// Arc length (m) at which a branch is nearest to `seat`, by straight lines between its `known` arc lengths and
/// points; beyond the first or the last of them, as far along as that point is from the seat. `None` if two places
/// remain, or none.
fn nearest_on(known: &[(f64, Vector)], seat: &Vector, length: f64) -> Option<f64> {
    let inner = known.windows(2).map(|pair| {
        let ((from, a), (to, b)) = (pair[0], pair[1]);
        let edge = b - a;
        let share = (edge.dot(&(seat - a)) / edge.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (from + (to - from) * share, (a + edge * share - seat).norm())
    });
    let best = inner.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(s, _)| s);
    let (first, last) = (known.first()?, known.last()?);
    let beyond = |(s, point): &(f64, Vector), sign: f64| s + sign * (point - seat).norm();
    let (before, after) = (beyond(first, -1.0), beyond(last, 1.0));
    match best {
        Some(s) if s > first.0 && s < last.0 => Some(s),
        Some(s) if s <= first.0 => Some(if before > 0.0 { before } else { s }),
        Some(s) => Some(if after < length { after } else { s }),
        None => match (before > 0.0, after < length) {
            (true, false) => Some(before),
            (false, true) => Some(after),
            _ => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seat_is_on_the_line_between_what_is_known_or_as_far_beyond() {
        let at = |x: f64| Vector::new(x, 0.1, 0.0);
        let known = [(0.0, Vector::zeros()), (0.8, Vector::new(0.5, 0.0, 0.0))];
        let near = |known: &[(f64, Vector)], seat| nearest_on(known, &seat, 1.0);
        assert!((near(&known, at(0.25)).unwrap() - 0.4).abs() < 1e-12);
        let beyond = 0.8 + 0.02_f64.sqrt();
        assert!((near(&known, at(0.6)).unwrap() - beyond).abs() < 1e-12);
        assert_eq!(near(&known[..1], Vector::new(0.3, 0.0, 0.0)), Some(0.3));
        assert_eq!(near(&[(0.5, Vector::zeros())], Vector::new(0.3, 0.0, 0.0)), None);
        assert_eq!(near(&[], at(0.0)), None);
    }

    /// A clip that closes near a change of section stays on its side of it, and near it.
    #[test]
    fn a_provisional_place_is_apart_from_a_change_of_section_on_its_side() {
        let place = |s| beside_changes(&[(0, [0.0, 0.2]), (1, [0.2, 0.5]), (0, [0.5, 1.0])].map(span), 1.0, s);
        let near = |s: f64, expected: f64| assert!((place(s) - expected).abs() < 1e-12, "{} at {s}", place(s));
        for (s, expected) in [(0.19, 0.18), (0.201, 0.22), (0.4, 0.4), (0.499, 0.48), (0.501, 0.52), (0.005, 0.005)] {
            near(s, expected);
        }
        assert!((beside_changes(&[span((0, [0.0, 0.01])), span((1, [0.01, 1.0]))], 1.0, 0.009) - 0.0075).abs() < 1e-12);
    }

    fn span((section, range): (usize, [f64; 2])) -> SectionPart {
        SectionPart { section, range }
    }
}
