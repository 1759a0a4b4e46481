use super::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The way along the harness between any two vertices, m; loops are cut.
fn ways(vertices: usize, graph: &Graph, cut: &[usize]) -> Vec<Vec<f64>> {
    let mut way = vec![vec![f64::INFINITY; vertices]; vertices];
    (0..vertices).for_each(|v| way[v][v] = 0.0);
    for (k, strand) in graph.strands.iter().enumerate().filter(|(k, _)| !cut.contains(k)) {
        let [a, b] = strand.ends;
        way[a][b] = graph.strands[k].length;
        way[b][a] = way[a][b];
    }
    // Floyd and Warshall.
    for via in 0..vertices {
        for a in 0..vertices {
            for b in 0..vertices {
                way[a][b] = way[a][b].min(way[a][via] + way[via][b]);
            }
        }
    }
    way
}

/// Whether two straight pieces have a point in common, by the sides on which their ends lie.
fn meet([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let side = |p: Point, q: Point, r: Point| (q - p).perp(&(r - p)) > 0.0;
    side(c, d, a) != side(c, d, b) && side(a, b, c) != side(a, b, d)
}

/// Checks a layout from scratch, by samples: it knows nothing of the search and its formulas.
fn holds(graph: &Graph, layout: &Layout, gap: f64) {
    let vertices = graph.vertices;
    let way = ways(vertices, graph, &layout.cut);
    let n = graph.strands.len();
    let ends = |k: usize| {
        let [a, b] = graph.strands[k].ends;
        [a, if layout.cut.contains(&k) { usize::MAX } else { b }]
    };
    // Every vertex is one point, and lengths are true: an arc is as long as its angle times its radius.
    let mut points: Vec<Option<Point>> = vec![None; vertices];
    for (k, line) in layout.lines.iter().enumerate() {
        let strand = &graph.strands[k];
        assert!((line.length / strand.length - 1.0).abs() < 1e-9);
        if line.curvature == 0.0 {
            assert!(((line.end() - line.start).norm() / strand.length - 1.0).abs() < 1e-9);
        } else {
            let (radius, turn) = (1.0 / line.curvature.abs(), (line.curvature * line.length).abs());
            assert!(radius >= strand.bend * (1.0 - 1e-9), "branch {k}: {radius} below {}", strand.bend);
            let chord = 2.0 * radius * (0.5 * turn).sin();
            assert!(((line.end() - line.start).norm() - chord).abs() < 1e-9 * strand.length);
        }
        for (end, place) in ends(k).into_iter().zip([line.start, line.end()]) {
            if end != usize::MAX {
                let known = points[end].get_or_insert(place);
                assert!((*known - place).norm() < 1e-9, "vertex {end}: {known} {place}");
            }
        }
        for p in [line.start, line.end(), line.at(0.5 * line.length)] {
            let inside = |x: f64, size: f64| x >= -1e-9 && x <= size + 1e-9;
            assert!(inside(p.x, layout.size[0]) && inside(p.y, layout.size[1]), "{p} {:?}", layout.size);
        }
    }
    let samples = |k: usize| -> Vec<(f64, Point)> {
        let line = &layout.lines[k];
        (0..=40).map(|i| line.length * f64::from(i) / 40.0).map(|s| (s, line.at(s))).collect()
    };
    let all: Vec<Vec<(f64, Point)>> = (0..n).map(samples).collect();
    for a in 0..n {
        for b in a + 1..n {
            let distance = graph.strands[a].radius + graph.strands[b].radius + gap;
            let common = ends(a).into_iter().any(|end| end != usize::MAX && ends(b).contains(&end));
            for &(s, p) in &all[a] {
                for &(t, q) in &all[b] {
                    let mut between = f64::INFINITY;
                    for (i, x) in ends(a).into_iter().enumerate().filter(|(_, x)| *x != usize::MAX) {
                        for (j, y) in ends(b).into_iter().enumerate().filter(|(_, y)| *y != usize::MAX) {
                            let own = if i == 0 { s } else { graph.strands[a].length - s };
                            let other = if j == 0 { t } else { graph.strands[b].length - t };
                            between = between.min(own + way[x][y] + other);
                        }
                    }
                    let apart = (p - q).norm();
                    assert!(
                        between <= layout.zone * distance * (1.0 + 1e-9) || apart >= distance * (1.0 - 1e-6),
                        "branches {a} at {s} and {b} at {t} are {apart} apart instead of {distance}"
                    );
                }
            }
            if !common {
                let pieces = |k: usize| all[k].windows(2).map(|w| [w[0].1, w[1].1]).collect::<Vec<_>>();
                let (first, second) = (pieces(a), pieces(b));
                let cross = first.iter().any(|&one| second.iter().any(|&other| meet(one, other)));
                assert!(!cross, "branches {a} and {b} cross");
            }
        }
    }
}

/// A tree on up to 40 vertices: each vertex but the first hangs on an earlier one. `near` makes long chains.
fn trees() -> impl Strategy<Value = Graph> {
    let one = (any::<prop::sample::Index>(), 0.01..1.5_f64, 0.001..0.02_f64, 0.0..TAU, 0.0..TAU, any::<bool>());
    prop::collection::vec(one, 1..40).prop_map(|list| {
        let mut graph = Graph { vertices: list.len() + 1, strands: Vec::new(), leaves_at: Vec::new() };
        for (i, (parent, length, diameter, a, b, near)) in list.into_iter().enumerate() {
            let from = if near { i } else { parent.index(i + 1) };
            let radius = 0.5 * diameter;
            graph.strands.push(Strand { ends: [from, i + 1], length, radius, bend: 8.0 * radius });
            graph.leaves_at.push([a, b]);
        }
        graph
    })
}

/// A trunk of pieces of 0.5 m, with an arm of 0.3 m to either side at each vertex.
fn comb(pieces: usize) -> Graph {
    let mut graph = Graph { vertices: 3 * pieces + 1, strands: Vec::new(), leaves_at: Vec::new() };
    let mut add = |a: usize, b: usize, length: f64, leaves: [f64; 2]| {
        graph.strands.push(Strand { ends: [a, b], length, radius: 0.005, bend: 0.04 });
        graph.leaves_at.push(leaves);
    };
    for k in 0..pieces {
        add(k, k + 1, 0.5, [0.0, PI]);
        add(k, pieces + 1 + 2 * k, 0.3, [0.5 * PI, 0.0]);
        add(k, pieces + 2 + 2 * k, 0.3, [-0.5 * PI, 0.0]);
    }
    graph
}

const GAP: f64 = 0.005;

proptest! {
    // The same cases every time.
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(1), cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn trees_are_laid_with_true_lengths_and_without_overlaps(graph in trees()) {
        let layout = lay_out(&graph, GAP);
        prop_assert!(layout.cut.is_empty());
        prop_assert!(layout.lines.iter().all(|line| line.curvature == 0.0));
        holds(&graph, &layout, GAP);
        prop_assert_eq!(layout.lines, lay_out(&graph, GAP).lines);
    }
}

#[test]
fn the_trunk_is_straight_and_arms_stand_as_drawn_where_there_is_room() {
    let graph = comb(6);
    let layout = lay_out(&graph, GAP);
    holds(&graph, &layout, GAP);
    assert!(layout.straight && layout.zone == 8.0);
    // From the first arm to the end of the trunk: 6 pieces and the longest start.
    assert!(layout.size[0] < 6.0 * 0.5 + 0.3 + 0.02, "{:?}", layout.size);
    assert!(layout.size[1] < 0.65, "{:?}", layout.size);
}

#[test]
fn a_short_board_bends_the_trunk_within_the_limits_and_a_tiny_one_is_refused() {
    let graph = comb(8);
    let layout = lay_out_within(&graph, GAP, [2.6, 1.6]).expect("it fits when it is folded");
    holds(&graph, &layout, GAP);
    assert!(!layout.straight && layout.size[0] <= 2.6 && layout.size[1] <= 1.6, "{:?}", layout.size);
    assert!(lay_out_within(&graph, GAP, [0.3, 0.2]).is_none());
    assert!(lay_out(&graph, GAP).size[0] > 3.9);
}

#[test]
fn loops_are_cut_at_their_longest_branch_and_pieces_lie_apart() {
    let strand = |a: usize, b: usize, length: f64| Strand { ends: [a, b], length, radius: 0.004, bend: 0.03 };
    let strands = vec![strand(0, 1, 0.5), strand(1, 2, 0.5), strand(2, 0, 0.7), strand(3, 4, 0.4)];
    let graph = Graph { vertices: 5, leaves_at: vec![[0.0, 1.0]; 4], strands };
    let layout = lay_out(&graph, GAP);
    assert_eq!(layout.cut, [2]);
    holds(&graph, &layout, GAP);
}

#[test]
fn a_star_of_very_many_arms_keeps_its_rules_with_a_zone_that_is_told() {
    let arms = 48;
    let strands = (0..arms).map(|k| Strand { ends: [0, k + 1], length: 1.0, radius: 0.002, bend: 0.02 }).collect();
    let leaves_at = (0..arms).map(|k| [TAU * k as f64 / arms as f64, 0.0]).collect();
    let graph = Graph { vertices: arms + 1, strands, leaves_at };
    let layout = lay_out(&graph, GAP);
    holds(&graph, &layout, GAP);
    // 7.5° between arms: distance D at D/(2 sin 3.75°) from the fork, which is a way of 15.3 D from arm to arm.
    assert!(layout.zone > 15.2 && layout.zone < 15.4, "{}", layout.zone);
}
