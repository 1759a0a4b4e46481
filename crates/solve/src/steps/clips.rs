//! Arc lengths of the stations of constraints that begin: as given by the scenario, or nearest to their seats.

use wireloom_core::network::Place;
use wireloom_core::{Network, State, Vector};

/// Least distance of a clip that closes from the constraints beside it, in diameters.
const SPACING: f64 = 1.0;
/// Least distance as a fraction of the cable between these constraints, if that is shorter.
const SPACING_FRACTION: f64 = 0.1;
/// Distances (m) that differ by less than this are the same.
const SAME: f64 = 1e-9;
/// Newton steps to the zero of a parabola from within a segment of it.
const NEWTON: usize = 4;

/// Sets the arc lengths of those knots (increasing nodes, and their arc lengths at `state`, m) of a branch that
/// constraints of `added` bring: first the given ones, then the nearest ones. All stay between the constraints that act
/// already, and in the same section. `seat`: where a constraint closes. Returns remarks on those that these limited.
pub(crate) fn place_stations(
    network: &Network,
    state: &State,
    branch: usize,
    added: &[usize],
    seat: impl Fn(usize) -> Vector,
    knots: &mut [(usize, f64)],
) -> Vec<String> {
    let mut notes = Vec::new();
    let own = &network.branches[branch];
    let built = own.rod.mesh().arc_lengths();
    let begins =
        |node: usize| added.iter().copied().find(|&f| network.constraints[f].place == Place::Node { branch, node });
    let begun: Vec<Option<usize>> = knots.iter().map(|knot| begins(knot.0)).collect();
    let is_nearest = |f: usize| network.constraints[f].nearest;
    // Constraints with a given place ignore those without.
    for given in [true, false] {
        for k in 1..knots.len() - 1 {
            let Some(f) = begun[k].filter(|&f| is_nearest(f) != given) else { continue };
            let standing = |other: &usize| begun[*other].is_none_or(|f| !given && !is_nearest(f));
            let placed = |other: &usize| standing(other) || begun[*other].is_some_and(|f| is_nearest(f) != given);
            let before = (0..k).rev().find(placed).map_or(0.0, |other| knots[other].1);
            let next = (k + 1..knots.len()).find(standing).unwrap_or(knots.len() - 1);
            let (after, between) = (knots[next].1, (next - k) as f64);
            let fraction = SPACING_FRACTION * (after - before) / between;
            if given {
                let wanted = built[knots[k].0];
                let free = before < wanted && wanted < after;
                knots[k].1 = if free { wanted } else { wanted.clamp(before + fraction, after - between * fraction) };
                if !free {
                    notes.push(format!(
                        "constraint `{}` begins at s = {:.4} m of branch `{}`, not at {wanted:.4} m: what acts \
                         already has come past that",
                        network.constraints[f].name, knots[k].1, own.name
                    ));
                }
            } else {
                let spacing = fraction.min(SPACING * own.sections.of(knots[k].0).diameter);
                let range = [before + spacing, after - between * spacing];
                let (here, note) = nearest_place((network, state), (f, &seat(f)), branch, range);
                knots[k].1 = here;
                notes.extend(note);
            }
        }
    }
    notes
}

/// Arc length in `[low, high]` at which the cable is nearest to the seat of constraint `f`, and a remark if it is
/// nearer outside.
fn nearest_place(
    (network, state): (&Network, &State),
    (f, seat): (usize, &Vector),
    branch: usize,
    [low, high]: [f64; 2],
) -> (f64, Option<String>) {
    let constraint = &network.constraints[f];
    let own = &network.branches[branch];
    let points: Vec<Vector> = own.points.clone().map(|i| state.points[i] + state.compensation[i]).collect();
    let s = state.arc_lengths(network, branch);
    let frame = |local: &usize| state.frames[own.frames.start + local];
    let tangents: Vec<Vector> = own.rod.mesh().segment_frames.iter().map(|k| frame(k) * Vector::z()).collect();
    let foot = |low: f64, high: f64| {
        let (at, distance) = nearest(&s, &points, seat, low, high);
        (foot_point(&s, &points, &tangents, seat, at).clamp(low, high), distance)
    };
    let (here, distance) = foot(low, high);
    let (there, least) = foot(s[0], s[s.len() - 1]);
    let note = (least < distance - SAME).then(|| {
        format!(
            "clip `{}` closes at s = {here:.4} m of branch `{}`, between what is fixed on either side of it; at \
             s = {there:.4} m the cable is nearer to its seat",
            constraint.name, own.name
        )
    });
    (here, note)
}

/// Arc length in `[low, high]` at which the polygon through `points` at arc lengths `s` is nearest to `seat`, and its
/// distance, m.
fn nearest(s: &[f64], points: &[Vector], seat: &Vector, low: f64, high: f64) -> (f64, f64) {
    let edges = s.windows(2).zip(points.windows(2)).filter(|(s, _)| s[1] >= low && s[0] <= high);
    let candidates = edges.map(|(s, p)| {
        let (edge, length) = (p[1] - p[0], s[1] - s[0]);
        let fraction = edge.dot(&(seat - p[0])) / edge.norm_squared().max(f64::MIN_POSITIVE);
        let fraction = fraction.clamp((low - s[0]).max(0.0) / length, ((high - s[0]) / length).min(1.0));
        (s[0] + fraction * length, (p[0] + edge * fraction - seat).norm())
    });
    candidates.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.5 * (low + high), f64::INFINITY))
}

/// Arc length near `at` at which `seat − x` is square to the tangent of the cable; `at` if there is none within a
/// segment. The polygon alone would miss it by the distance of the seat times half the angle between two edges. At the
/// middle of a segment the tangent is known, and `g = (seat − x)·t` does not feel that the middle of the edge lies
/// beside the cable: g is the parabola through three middles.
fn foot_point(s: &[f64], points: &[Vector], tangents: &[Vector], seat: &Vector, at: f64) -> f64 {
    let n = tangents.len();
    if n < 3 {
        return at;
    }
    let segment = s.partition_point(|node| *node <= at).clamp(1, n) - 1;
    let first = segment.saturating_sub(1).min(n - 3);
    let m = [0, 1, 2].map(|k| 0.5 * (s[first + k] + s[first + k + 1]));
    let g = [0, 1, 2].map(|k| {
        let j = first + k;
        (seat - (points[j] + points[j + 1]) * 0.5).dot(&tangents[j])
    });
    let slopes = [0, 1].map(|k| (g[k + 1] - g[k]) / (m[k + 1] - m[k]));
    let bend = (slopes[1] - slopes[0]) / (m[2] - m[0]);
    let mut foot = at;
    for _ in 0..NEWTON {
        let value = g[0] + slopes[0] * (foot - m[0]) + bend * (foot - m[0]) * (foot - m[1]);
        foot -= value / (slopes[0] + bend * (2.0 * foot - m[0] - m[1]));
    }
    if (foot - at).abs() <= s[segment + 1] - s[segment] { foot } else { at }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seat 0.1 m outside an arc of radius 0.2 m; the angle decides, whatever the mesh. The polygon alone was off by
    /// half a segment.
    #[test]
    fn a_clip_closes_at_the_foot_on_the_cable_not_on_the_polygon() {
        let (radius, angle) = (0.2, 1.234);
        let on = |r: f64, angle: f64| Vector::new(r * f64::sin(angle), 0.0, r * f64::cos(angle));
        let seat = on(0.3, angle);
        let error = |n: usize| {
            let s: Vec<f64> = (0..=n).map(|i| 0.5 * i as f64 / n as f64).collect();
            let points: Vec<Vector> = s.iter().map(|s| on(radius, s / radius)).collect();
            let middle = |j: usize| (j as f64 + 0.5) * 0.5 / n as f64 / radius;
            let tangents: Vec<Vector> = (0..n).map(|j| Vector::new(middle(j).cos(), 0.0, -middle(j).sin())).collect();
            let (at, _) = nearest(&s, &points, &seat, 0.0, 0.5);
            (foot_point(&s, &points, &tangents, &seat, at) - radius * angle).abs()
        };
        let (coarse, fine) = (error(10), error(40));
        assert!(coarse < 1e-3 && fine < coarse / 30.0, "{coarse:e} {fine:e}");
    }

    #[test]
    fn the_nearest_place_on_a_bent_polygon() {
        let points = [Vector::zeros(), Vector::x(), Vector::new(1.0, 1.0, 0.0)];
        let s = [0.0, 2.0, 3.0];
        let (at, distance) = nearest(&s, &points, &Vector::new(0.25, 0.5, 0.0), 0.0, 3.0);
        assert!((at - 0.5).abs() < 1e-15 && (distance - 0.5).abs() < 1e-15);
        let (at, distance) = nearest(&s, &points, &Vector::new(0.25, 0.5, 0.0), 2.25, 2.75);
        assert!((at - 2.5).abs() < 1e-15 && (distance - 0.75).abs() < 1e-15);
        let (at, _) = nearest(&s, &points, &Vector::new(5.0, 5.0, 0.0), 0.1, 2.9);
        assert!((at - 2.9).abs() < 1e-15);
    }
}
