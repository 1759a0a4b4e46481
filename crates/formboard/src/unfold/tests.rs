use super::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn edge(a: usize, b: usize, length: f64, leaves_at: [f64; 2]) -> Edge {
    Edge { ends: [a, b], length, leaves_at }
}

/// Lengths of the edges that do not close loops are true.
fn true_lengths(layout: &Unfolded, edges: &[Edge]) {
    for (i, edge) in edges.iter().enumerate().filter(|(i, _)| !layout.closing.contains(i)) {
        let drawn = (layout.points[edge.ends[1]] - layout.points[edge.ends[0]]).norm();
        assert!((drawn - edge.length).abs() <= 1e-9 * edge.length.max(1.0), "edge {i}: {drawn} {}", edge.length);
    }
}

/// Counter-clockwise order of the edges about every vertex is the wanted one.
fn order_kept(layout: &Unfolded, vertices: usize, edges: &[Edge]) {
    for v in 0..vertices {
        let mut arms: Vec<(f64, f64)> = (edges.iter())
            .filter_map(|edge| {
                let end = edge.ends.iter().position(|&end| end == v)?;
                let d = layout.points[edge.ends[1 - end]] - layout.points[v];
                Some((edge.leaves_at[end].rem_euclid(TAU), d.y.atan2(d.x)))
            })
            .collect();
        arms.sort_by(|a, b| a.0.total_cmp(&b.0));
        let k = arms.len();
        let round: f64 = (0..k).map(|i| (arms[(i + 1) % k].1 - arms[i].1).rem_euclid(TAU)).sum();
        assert!(k < 3 || (round - TAU).abs() < 1e-6, "vertex {v}: {arms:?}");
    }
}

#[test]
fn wanted_directions_are_met_where_there_is_room() {
    // A cross with a trunk that is bent by 30° where it is drawn: the trunk straight, the arms spread evenly on
    // their sides.
    let (right, up) = (0.0, PI / 2.0);
    let edges = [
        edge(0, 1, 2.0, [right, PI]),
        edge(1, 2, 2.0, [-PI / 6.0, PI]),
        edge(1, 3, 0.5, [up, -up]),
        edge(1, 4, 0.5, [-up, up]),
        edge(3, 5, 0.4, [up / 2.0, PI]),
    ];
    let layout = unfold(6, &edges, Turning::Daylight);
    true_lengths(&layout, &edges);
    assert_eq!((crossings(&layout.points, &edges).len(), layout.closing.len()), (0, 0));
    let at = |v: usize| layout.points[v];
    assert!((at(0) - at(2)).norm() > 4.0 - 1e-9 && at(0).y.abs() < 1e-9 && at(1).norm() < 1e-9);
    let between = |a: Point, b: Point| a.perp(&b).atan2(a.dot(&b)).to_degrees();
    // From the arm on (at −30°) it is 120° of 210° to the arm above, and 60° of 150° to the one below.
    assert!((between(at(2) - at(1), at(3) - at(1)) - 180.0 * 120.0 / 210.0).abs() < 1e-6);
    assert!((between(at(2) - at(1), at(4) - at(1)) + 180.0 * 60.0 / 150.0).abs() < 1e-6);
    // And at vertex 3 the angle is as drawn: from −90° to 45°.
    assert!((between(at(1) - at(3), at(5) - at(3)) - 135.0).abs() < 1e-6);
}

#[test]
fn arms_that_would_cross_where_they_are_drawn_are_spread() {
    // Two long arms that lean towards each other on one side of a short trunk.
    let edges = [
        edge(0, 1, 3.0, [0.0, PI]),
        edge(1, 2, 0.2, [0.0, PI]),
        edge(2, 3, 3.0, [0.0, PI]),
        edge(1, 4, 2.0, [PI / 4.0, -PI / 2.0]),
        edge(2, 5, 2.0, [0.75 * PI, -PI / 2.0]),
    ];
    let layout = unfold(6, &edges, Turning::Daylight);
    true_lengths(&layout, &edges);
    order_kept(&layout, 6, &edges);
    assert!(crossings(&layout.points, &edges).is_empty());
    let along = layout.points[3] - layout.points[0];
    assert!((along.norm() - 6.2).abs() < 1e-9, "the trunk is straight: {along}");
}

#[test]
fn loops_are_opened_at_their_longest_edge_and_pieces_are_told_apart() {
    let edges = [
        edge(0, 1, 1.0, [0.0, PI]),
        edge(1, 2, 1.0, [1.0, PI]),
        edge(2, 0, 1.5, [2.0, 3.0]),
        edge(3, 4, 1.0, [0.0, 0.0]),
    ];
    let layout = unfold(6, &edges, Turning::Daylight);
    true_lengths(&layout, &edges);
    assert_eq!(layout.closing, [2]);
    let pieces: Vec<&[usize]> = layout.pieces.iter().map(|piece| &piece.vertices[..]).collect();
    assert_eq!(pieces, [&[0, 1, 2][..], &[3, 4], &[5]]);
}

/// Pairs of edges without a common vertex that touch or cross, by a sweep along x.
fn crossings(points: &[Point], edges: &[Edge]) -> Vec<[usize; 2]> {
    let mut along: Vec<(f64, f64, usize)> = edges
        .iter()
        .enumerate()
        .map(|(k, edge)| {
            let [a, b] = edge.ends.map(|end| points[end].x);
            (a.min(b), a.max(b), k)
        })
        .collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found = Vec::new();
    for (k, &(_, right, i)) in along.iter().enumerate() {
        for &(_, _, j) in along[k + 1..].iter().take_while(|(left, ..)| *left <= right) {
            let (first, second) = (&edges[i], &edges[j]);
            let apart = !first.ends.iter().any(|end| second.ends.contains(end));
            if apart && meet(first.ends.map(|end| points[end]), second.ends.map(|end| points[end])) {
                found.push([i.min(j), i.max(j)]);
            }
        }
    }
    found.sort_unstable();
    found
}

/// Whether two straight lines, ends included, have a point in common.
fn meet([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let side = |p: Point, q: Point, r: Point| (q - p).perp(&(r - p));
    let within = |p: Point, q: Point, r: Point| {
        r.zip_map(&p.inf(&q), |x, low| x - low).min() >= 0.0 && (p.sup(&q) - r).min() >= 0.0
    };
    let (s1, s2, s3, s4) = (side(c, d, a), side(c, d, b), side(a, b, c), side(a, b, d));
    let crosses =
        (s1 > 0.0) != (s2 > 0.0) && (s3 > 0.0) != (s4 > 0.0) && s1 != 0.0 && s2 != 0.0 && s3 != 0.0 && s4 != 0.0;
    crosses
        || s1 == 0.0 && within(c, d, a)
        || s2 == 0.0 && within(c, d, b)
        || s3 == 0.0 && within(a, b, c)
        || s4 == 0.0 && within(a, b, d)
}

#[test]
fn lines_that_touch_or_cross_meet() {
    let p = |x: f64, y: f64| Point::new(x, y);
    let flat = [p(0.0, 0.0), p(2.0, 0.0)];
    assert!(meet(flat, [p(1.0, -1.0), p(1.0, 1.0)]));
    assert!(meet(flat, [p(1.0, 0.0), p(1.0, 1.0)]));
    assert!(meet(flat, [p(1.0, 0.0), p(5.0, 0.0)]));
    assert!(!meet(flat, [p(3.0, 0.0), p(5.0, 0.0)]));
    assert!(!meet(flat, [p(1.0, 0.1), p(1.0, 1.0)]));
    assert!(!meet(flat, [p(3.0, -1.0), p(3.0, 1.0)]));
}

/// A tree on up to 60 vertices: each vertex but the first hangs on an earlier one. `near` makes long chains.
fn trees() -> impl Strategy<Value = Vec<Edge>> {
    let one = (any::<prop::sample::Index>(), 0.001..2.0_f64, 0.0..TAU, 0.0..TAU, any::<bool>());
    prop::collection::vec(one, 1..60).prop_map(|list| {
        let edges = list.iter().enumerate().map(|(i, (parent, length, a, b, near))| {
            let from = if *near { i } else { parent.index(i + 1) };
            edge(from, i + 1, *length, [*a, *b])
        });
        edges.collect()
    })
}

proptest! {
    // The same cases every time.
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(1), cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn trees_unfold_with_true_lengths_and_without_crossings(edges in trees()) {
        let vertices = edges.len() + 1;
        let layout = unfold(vertices, &edges, Turning::Daylight);
        true_lengths(&layout, &edges);
        order_kept(&layout, vertices, &edges);
        prop_assert!(layout.closing.is_empty());
        prop_assert_eq!(crossings(&layout.points, &edges), Vec::<[usize; 2]>::new());
        // Nor do edges of one vertex lie upon one another.
        for (i, a) in edges.iter().enumerate() {
            for b in &edges[i + 1..] {
                if let Some(&v) = a.ends.iter().find(|end| b.ends.contains(end)) {
                    let other = |e: &Edge| if e.ends[0] == v { e.ends[1] } else { e.ends[0] };
                    let out = |e: &Edge| layout.points[other(e)] - layout.points[v];
                    let (x, y) = (out(a), out(b));
                    prop_assert!(x.perp(&y).atan2(x.dot(&y)).abs() > 1e-4);
                }
            }
        }
    }

    #[test]
    fn any_graph_unfolds(
        edges in trees(),
        more in prop::collection::vec((any::<prop::sample::Index>(), any::<prop::sample::Index>()), 0..5),
    ) {
        let vertices = edges.len() + 3;
        let mut edges = edges;
        for (a, b) in more {
            let (a, b) = (a.index(vertices), b.index(vertices));
            if a != b {
                edges.push(edge(a, b, 0.7, [1.0, 2.0]));
            }
        }
        let layout = unfold(vertices, &edges, Turning::Daylight);
        true_lengths(&layout, &edges);
        prop_assert!(layout.points.iter().all(|p| p.x.is_finite() && p.y.is_finite()));
    }
}
