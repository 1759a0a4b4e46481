//! Clips that close where the cable is nearest to their seat.

use wireloom_core::network::Place;
use wireloom_core::{Network, State, Vector};

/// Length that stays between a clip that closes and what holds the cable beside it, in diameters.
const ROOM: f64 = 1.0;
/// The same as a share of the cable between those, where that is shorter.
const ROOM_SHARE: f64 = 0.1;
/// Distances (m) that differ by less than this are the same.
const SAME: f64 = 1e-9;

/// Gives knot `k`, the station of fixing `f`, the arc length at which the cable is nearest to the seat of `f`, between the knots beside it.
/// Returns a remark where the cable is nearer beyond those.
pub(crate) fn close_on_nearest(
    network: &Network,
    state: &State,
    f: usize,
    knots: &mut [(usize, f64)],
    k: usize,
) -> Option<String> {
    let fixing = &network.fixings[f];
    let (Place::Node { branch, .. }, Some(seat)) = (fixing.place, fixing.position) else { return None };
    let own = &network.branches[branch];
    let points: Vec<Vector> = own.points.clone().map(|i| state.points[i] + state.carry[i]).collect();
    let s = state.arc_lengths(network, branch);
    let (before, after) = (knots[k - 1].1, knots[k + 1].1);
    let room = (ROOM * own.section.diameter).min(ROOM_SHARE * (after - before));
    let (here, distance) = nearest(&s, &points, &seat, before + room, after - room);
    let (there, least) = nearest(&s, &points, &seat, s[0], s[s.len() - 1]);
    knots[k].1 = here;
    (least < distance - SAME).then(|| {
        format!(
            "clip `{}` closes at s = {here:.4} m of branch `{}`, between the fixings beside it; at s = {there:.4} m the cable is nearer to its seat",
            fixing.name, own.name
        )
    })
}

/// Arc length in `[low, high]` at which the polygon through `points` at arc lengths `s` is nearest to `seat`, and its distance, m.
fn nearest(s: &[f64], points: &[Vector], seat: &Vector, low: f64, high: f64) -> (f64, f64) {
    let edges = s.windows(2).zip(points.windows(2)).filter(|(s, _)| s[1] >= low && s[0] <= high);
    let candidates = edges.map(|(s, p)| {
        let (edge, length) = (p[1] - p[0], s[1] - s[0]);
        let share = edge.dot(&(seat - p[0])) / edge.norm_squared().max(f64::MIN_POSITIVE);
        let share = share.clamp((low - s[0]).max(0.0) / length, ((high - s[0]) / length).min(1.0));
        (s[0] + share * length, (p[0] + edge * share - seat).norm())
    });
    candidates.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.5 * (low + high), f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_on_a_bent_polygon() {
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
