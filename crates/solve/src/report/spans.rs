//! Spans of the harness: the cable between two places that are held, also through joints that nothing holds.

use super::Occurrence;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::f64::consts::PI;
use std::ops::Range;
use wireloom_core::constraint::Action;
use wireloom_core::network::{BranchEnd, Place};
use wireloom_core::section::softest_bending;
use wireloom_core::sections::SectionSpan;
use wireloom_core::{EventKind, EventPlace, Network, Problem, State};

/// Strain above which a span with an end that nothing holds counts as overstretched.
const LARGE_STRAIN: f64 = 5e-3;
/// Strain above which a span between held ends does: these are where they are told to be.
const ROUND_OFF: f64 = 1e-9;

/// Part of a branch in a span. From its first to its last node in the order of the span, which may run against the
/// branch.
#[derive(Clone, Copy)]
pub(crate) struct Piece {
    /// Index of the branch.
    pub branch: usize,
    /// Its first and its last node.
    pub nodes: [usize; 2],
    /// Unstressed arc lengths of these, m.
    pub s: [f64; 2],
    /// 1 + ε, ε being the strain by temperature.
    free: f64,
    /// Length of the hub between the piece before it in the span and this one, m; 0 where there is none.
    hub: f64,
}

impl Piece {
    /// Its nodes, in the order of the span.
    pub fn in_order(self) -> impl Iterator<Item = usize> {
        let [first, last] = self.nodes;
        (0..=first.abs_diff(last)).map(move |k| if first < last { first + k } else { first - k })
    }

    /// Its segments, in the order of the branch.
    pub fn segments(self) -> Range<usize> {
        let [first, last] = self.nodes;
        first.min(last)..first.max(last)
    }

    /// 1, or -1 where the span runs against the branch.
    pub fn sign(self) -> f64 {
        (self.s[1] - self.s[0]).signum()
    }

    fn length(self) -> f64 {
        (self.s[1] - self.s[0]).abs() * self.free
    }

    fn turned(self) -> Self {
        let Self { nodes: [first, last], s: [from, to], .. } = self;
        Self { nodes: [last, first], s: [to, from], ..self }
    }
}

/// Pieces in the opposite order.
fn turned(pieces: &[Piece]) -> Vec<Piece> {
    // The hub before a piece is then that behind it.
    let behind = |k: usize| pieces.get(k + 1).map_or(0.0, |piece| piece.hub);
    (0..pieces.len()).rev().map(|k| Piece { hub: behind(k), ..pieces[k].turned() }).collect()
}

/// Length without a force, with the hubs between its pieces, m.
fn length(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|piece| piece.hub + piece.length()).sum()
}

/// What is known of an end of a span.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum EndKnown {
    /// It is held in place, at one place of the cable.
    Place,
    /// It is held in place, and the cable slides there.
    Slides,
    /// Nothing.
    No,
}

/// Cable between two places; each is held, or an end or a joint that nothing holds.
pub(crate) struct CableSpan {
    /// Its pieces, in order.
    pub pieces: Vec<Piece>,
    /// Length without a force, at its temperature, with the lever arms of hubs, m.
    pub length: f64,
    /// Distance of its ends, m.
    pub chord: f64,
    /// Strain up to which it is not overstretched.
    pub tolerance: f64,
    /// What is known of the places of its ends.
    pub known: [EndKnown; 2],
    /// Whether nothing but loads and springs acts on it between its ends: no branch leaves it, no constraint supports
    /// it.
    pub alone: bool,
}

impl CableSpan {
    /// Middle of its first piece on a branch.
    pub fn place(&self, network: &Network, branch: usize) -> EventPlace {
        let own = self.pieces.iter().find(|piece| piece.branch == branch).unwrap_or(&self.pieces[0]);
        EventPlace::branch(&network.branches[own.branch].name, 0.5 * (own.s[0] + own.s[1]))
    }

    /// Whether a piece of it on a branch is between two arc lengths, m, in part at least.
    pub fn meets(&self, branch: usize, [from, to]: [f64; 2]) -> bool {
        let own = self.pieces.iter().filter(|piece| piece.branch == branch);
        own.into_iter().any(|Piece { s: [a, b], .. }| a.min(*b) < to && a.max(*b) > from)
    }

    /// Branch and arc length (m) of its ends.
    pub fn ends(&self) -> [(usize, f64); 2] {
        let (first, last) = (self.pieces[0], self.pieces[self.pieces.len() - 1]);
        [(first.branch, first.s[0]), (last.branch, last.s[1])]
    }

    /// Force above which it is not stable while it is straight, even between clamped ends, N: Rayleigh's quotient
    /// `∫ m²/EI ds / ∫ θ² ds` (Timoshenko & Gere 1961, sections 2.2 and 2.8), with the smallest EI of each section.
    ///
    /// The cable has the moment `m = cos kx − α − β s` with `k = 2π/L`, x being the length of cable before a place, s
    /// that with hubs, and L that of all cable; hubs do not bend. α and β leave the ends where and as they are clamped:
    /// `∫ m/EI dx = ∫ s m/EI dx = 0`. θ is the slope `∫ m/EI dx`. With one section and no hub this is Euler's
    /// `4 π² EI/L²`; with a part ten times as stiff over half of the length it is at most 1.09 times the exact force.
    pub fn euler(&self, network: &Network) -> f64 {
        let cable: f64 = self.pieces.iter().map(|piece| piece.length()).sum();
        let k = 2.0 * PI / cable;
        let parts: Vec<Stiff> = self.pieces.iter().flat_map(|piece| piece.parts(network)).collect();
        // Places of the cable: part, weight, x, s and ∫ s dx; beginnings of the parts and the end: x and ∫ s dx.
        let (mut places, mut ends) = (Vec::new(), vec![(0.0, 0.0)]);
        let (mut before, mut rigid, mut area) = (0.0, 0.0, 0.0);
        for (index, part) in parts.iter().enumerate() {
            rigid += part.hub;
            let area_to = |x: f64| area + (x - before) * (rigid + 0.5 * (x + before));
            let cells = (CELLS * part.length / cable).ceil().max(1.0);
            let half = 0.5 * part.length / cells;
            for cell in 0..cells as usize {
                let middle = before + (2.0 * cell as f64 + 1.0) * half;
                places.extend(GAUSS.map(|(at, weight)| {
                    let x = middle + half * at;
                    (index, half * weight, x, x + rigid, area_to(x))
                }));
            }
            let behind = before + part.length;
            (area, before) = (area_to(behind), behind);
            ends.push((before, area));
        }
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            places.iter().map(|&(index, w, x, s, _)| w * of(x, s) / parts[index].bending).sum()
        };
        let (zeroth, first, second) = (sum(&|_, _| 1.0), sum(&|_, s| s), sum(&|_, s| s * s));
        let (turn, shift) = (sum(&|x, _| (k * x).cos()), sum(&|x, s| s * (k * x).cos()));
        let determinant = zeroth * second - first * first;
        let alpha = (second * turn - first * shift) / determinant;
        let beta = (zeroth * shift - first * turn) / determinant;
        let bending = sum(&|x, s| ((k * x).cos() - alpha - beta * s).powi(2));
        // ∫ m dx, and the slope at the beginning of each part.
        let turned = |(x, area): (f64, f64)| (k * x).sin() / k - alpha * x - beta * area;
        let mut slopes = vec![0.0];
        for (part, pair) in parts.iter().zip(ends.windows(2)) {
            slopes.push(slopes[slopes.len() - 1] + (turned(pair[1]) - turned(pair[0])) / part.bending);
        }
        let of_cable = places.iter().map(|&(index, w, x, _, area)| {
            let within = (turned((x, area)) - turned(ends[index])) / parts[index].bending;
            w * (slopes[index] + within).powi(2)
        });
        let of_hubs = parts.iter().zip(&slopes).map(|(part, slope)| part.hub * slope.powi(2));
        bending / of_cable.chain(of_hubs).sum::<f64>()
    }
}

/// Part of a span with one section.
struct Stiff {
    /// Length of the hub before it, m; 0 where there is none.
    hub: f64,
    /// Length, m.
    length: f64,
    /// The smallest EI, N m².
    bending: f64,
}

impl Piece {
    /// Its parts with one section, in the order of the span.
    fn parts(self, network: &Network) -> Vec<Stiff> {
        let branch = &network.branches[self.branch];
        let s = branch.rod.mesh().arc_lengths();
        let [low, high] = if self.s[0] < self.s[1] { self.s } else { [self.s[1], self.s[0]] };
        // Where the section changes the mesh does not move along the cable.
        let place = |node: usize| s.get(node).map_or(high, |place| place.clamp(low, high));
        let part = |span: &SectionSpan| {
            let length = (place(span.segments.end) - place(span.segments.start)) * self.free;
            Stiff { hub: 0.0, length, bending: softest_bending(&span.section.bend_stiffness()) }
        };
        let mut parts: Vec<Stiff> = match branch.sections.spans() {
            [span] => vec![Stiff { length: self.length(), ..part(span) }],
            spans => spans.iter().map(part).filter(|part| part.length > 0.0).collect(),
        };
        if self.s[0] > self.s[1] {
            parts.reverse();
        }
        if let Some(first) = parts.first_mut() {
            first.hub = self.hub;
        }
        parts
    }
}

/// Number of cells of the quadrature over the cable of a span.
const CELLS: f64 = 16.0;
/// Places from −1 to 1 and weights of the quadrature of Gauss and Legendre with five places (Abramowitz & Stegun 1964,
/// table 25.4).
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// Cable between two vertices: points of the network that are held, end a cable or are joints.
struct Edge {
    vertices: [usize; 2],
    /// Lever arms between the vertices and the ends of the cable, m: at hubs.
    levers: [f64; 2],
    /// In order; none where what is held is itself an arm's end on a hub.
    pieces: Vec<Piece>,
    alone: bool,
}

impl Edge {
    fn turned(mut self) -> Self {
        self.vertices.reverse();
        self.levers.reverse();
        self.pieces = turned(&self.pieces);
        self
    }
}

/// Spans of a harness, and those of each branch.
pub(crate) struct Spans {
    pub all: Vec<CableSpan>,
    of_branch: Vec<Vec<usize>>,
    /// Strain of each branch by temperature.
    pub free_strains: Vec<f64>,
}

impl Spans {
    /// All cables between places that are held, ends and joints, and for each branch the shortest way that is most
    /// stretched between two held places through joints at which it branches.
    pub fn new(problem: &Problem<'_>, state: &State) -> Self {
        let network = problem.network;
        let (held, supported) = acted_on(problem);
        let free_strains: Vec<f64> = (0..network.branches.len()).map(|b| problem.shape(state, b).free_strain).collect();
        let edges = edges(network, state, &free_strains, &held, &supported);
        let edges = joined(network, &held, &supported, edges);
        let position = |(branch, node): (usize, usize)| state.points[network.branches[branch].points.start + node];
        let mut all = Vec::new();
        for edge in edges.iter().filter(|edge| !edge.pieces.is_empty()) {
            let (first, last) = (edge.pieces[0], edge.pieces[edge.pieces.len() - 1]);
            let [a, b] = [(first.branch, first.nodes[0]), (last.branch, last.nodes[1])];
            // The end of an arm away from its hub is not where the hub is held.
            let ends_held = [0, 1].map(|k| held[edge.vertices[k]] && edge.levers[k] == 0.0);
            let known = [(0, a), (1, b)].map(|(k, (branch, node))| match ends_held[k] {
                true if slides(network, branch, node) => EndKnown::Slides,
                true => EndKnown::Place,
                false => EndKnown::No,
            });
            all.push(CableSpan {
                pieces: edge.pieces.clone(),
                length: length(&edge.pieces),
                chord: (position(b) - position(a)).norm(),
                tolerance: if ends_held == [true; 2] { ROUND_OFF } else { LARGE_STRAIN },
                known,
                alone: edge.alone,
            });
        }
        all.extend(most_stretched(network, state, &held, &edges));
        let mut of_branch = vec![Vec::new(); network.branches.len()];
        for (index, span) in all.iter().enumerate() {
            for piece in &span.pieces {
                if of_branch[piece.branch].last() != Some(&index) {
                    of_branch[piece.branch].push(index);
                }
            }
        }
        Self { all, of_branch, free_strains }
    }

    /// Indices of the spans that a branch is part of.
    pub fn of(&self, branch: usize) -> impl Iterator<Item = usize> {
        self.of_branch[branch].iter().copied()
    }
}

/// Which points are held in place, and which ones only in some directions, or by equations, which may support a cable.
/// A spring does not count: it may be very soft.
fn acted_on(problem: &Problem<'_>) -> (Vec<bool>, Vec<bool>) {
    let network = problem.network;
    let (mut held, mut supported) = (vec![false; network.points], vec![false; network.points]);
    let active = network.constraints.iter().zip(&problem.conditions().active).filter(|(_, active)| **active);
    for (constraint, _) in active {
        let marked = match constraint.model.action() {
            Action::Prescribed(hold) if hold.position && hold.rails.is_empty() => &mut held,
            Action::Prescribed(hold) if hold.position => &mut supported,
            Action::Equations(_) | Action::PotentialAndEquations(..) => &mut supported,
            _ => continue,
        };
        for (place, site) in constraint.places.iter().zip(&constraint.stations) {
            let point = match *place {
                // The end of an arm away from its hub.
                Place::Node { branch, node } if site.local.position.norm() > 0.0 => {
                    network.branches[branch].points.start + node
                }
                _ => site.point,
            };
            marked[point] = true;
        }
        for point in constraint.span.iter().flat_map(|span| span.points.clone()) {
            marked[point] = true;
        }
    }
    (held, supported)
}

/// Whether the cable slides at a node.
fn slides(network: &Network, branch: usize, node: usize) -> bool {
    network.slides.iter().any(|slide| (slide.branch, slide.node) == (branch, node))
}

/// Cables between neighbouring vertices on a branch.
fn edges(network: &Network, state: &State, strains: &[f64], held: &[bool], supported: &[bool]) -> Vec<Edge> {
    let mut edges = Vec::new();
    for (index, branch) in network.branches.iter().enumerate() {
        let s = state.arc_lengths(network, index);
        let (first, n) = (branch.points.start, branch.rod.mesh().segments());
        // Point of the vertex at an end, and the lever arm to it.
        let mut vertex_at = |node: usize, end: BranchEnd| match end {
            BranchEnd::Joint { joint, arm } => {
                let joint = &network.joints[joint];
                let lever = joint.frame.map_or(0.0, |_| joint.arms[arm].offset.norm());
                if held[first + node] && lever > 0.0 {
                    let vertices = [first + node, joint.point];
                    edges.push(Edge { vertices, levers: [0.0, lever], pieces: Vec::new(), alone: false });
                    return (first + node, 0.0);
                }
                (joint.point, lever)
            }
            BranchEnd::Free => (first + node, 0.0),
        };
        let mut stops = vec![(0, vertex_at(0, branch.start))];
        stops.extend((1..n).filter(|node| held[first + node]).map(|node| (node, (first + node, 0.0))));
        stops.push((n, vertex_at(n, branch.end)));
        for pair in stops.windows(2) {
            let [(from, (start, lever)), (to, (end, other_lever))] = [pair[0], pair[1]];
            edges.push(Edge {
                vertices: [start, end],
                levers: [lever, other_lever],
                pieces: vec![Piece {
                    branch: index,
                    nodes: [from, to],
                    s: [s[from], s[to]],
                    free: 1.0 + strains[index],
                    hub: 0.0,
                }],
                alone: !supported[first + from + 1..first + to].contains(&true),
            });
        }
    }
    edges
}

/// Edges at each vertex.
type Incidence = BTreeMap<usize, Vec<usize>>;

fn incidence<'e>(edges: impl IntoIterator<Item = &'e Edge>) -> Incidence {
    let mut at = Incidence::new();
    for (index, edge) in edges.into_iter().enumerate() {
        for vertex in edge.vertices {
            at.entry(vertex).or_default().push(index);
        }
    }
    at
}

/// Edges that go on through joints of two arms that nothing holds, also through hubs.
fn joined(network: &Network, held: &[bool], supported: &[bool], edges: Vec<Edge>) -> Vec<Edge> {
    let mut at = incidence(&edges);
    let mut edges: Vec<Option<Edge>> = edges.into_iter().map(Some).collect();
    for joint in network.joints.iter().filter(|joint| joint.arms.len() == 2 && !held[joint.point]) {
        let (point, Some(&[a, b])) = (joint.point, at.get(&joint.point).map(Vec::as_slice)) else { continue };
        if a == b {
            continue;
        }
        let (Some(one), Some(other)) = (edges[a].take(), edges[b].take()) else { continue };
        let one = if one.vertices[1] == point { one } else { one.turned() };
        let other = if other.vertices[0] == point { other } else { other.turned() };
        // What is held is the end of an arm on the hub: the hub turns about it.
        if one.pieces.is_empty() || other.pieces.is_empty() {
            (edges[a], edges[b]) = (Some(one), Some(other));
            continue;
        }
        let hub = joint.frame.map_or(0.0, |_| (joint.arms[1].offset - joint.arms[0].offset).norm());
        let mut behind = other.pieces;
        behind[0].hub = hub;
        for index in at.entry(other.vertices[1]).or_default() {
            if *index == b {
                *index = a;
            }
        }
        edges[a] = Some(Edge {
            vertices: [one.vertices[0], other.vertices[1]],
            levers: [one.levers[0], other.levers[1]],
            alone: one.alone && other.alone && !supported[point],
            pieces: [one.pieces, behind].concat(),
        });
    }
    edges.into_iter().flatten().collect()
}

/// Of the shortest ways between two held places through joints that nothing holds, for each branch the one that bridges
/// the largest distance for its length.
fn most_stretched(network: &Network, state: &State, held: &[bool], edges: &[Edge]) -> Vec<CableSpan> {
    let mut ways = Ways::new(held, edges);
    let mut found: Vec<CableSpan> = Vec::new();
    let mut worst: Vec<Option<usize>> = vec![None; network.branches.len()];
    for source in 0..ways.vertices.len() {
        if ways.open[source] {
            continue;
        }
        ways.search(source);
        for end in source + 1..ways.vertices.len() {
            let Some((length, _)) = ways.reached[end].filter(|_| !ways.open[end]) else { continue };
            let chord = (state.points[ways.vertices[end]] - state.points[ways.vertices[source]]).norm();
            let is_worse = |b: usize| worst[b].is_none_or(|k| chord * found[k].length > found[k].chord * length);
            let branches = ways.back_from(end).flat_map(|(e, _)| &edges[e].pieces).map(|piece| piece.branch);
            let branches: Vec<usize> = branches.filter(|b| is_worse(*b)).collect();
            if branches.is_empty() {
                continue;
            }
            let way: Vec<Via> = ways.back_from(end).collect();
            // A single cable without lever arms is known already.
            if matches!(way[..], [(single, _)] if edges[single].levers == [0.0; 2]) {
                continue;
            }
            for b in branches {
                worst[b] = Some(found.len());
            }
            let mut pieces = Vec::new();
            for (edge, from) in way.iter().rev().map(|(e, from)| (&edges[*e], ways.vertices[*from])) {
                if edge.vertices[0] == from {
                    pieces.extend(&edge.pieces);
                } else {
                    pieces.extend(turned(&edge.pieces));
                }
            }
            let mut span =
                CableSpan { pieces, length, chord, tolerance: ROUND_OFF, known: [EndKnown::Place; 2], alone: false };
            let ends = [span.pieces.first(), span.pieces.last()];
            for (k, piece) in ends.into_iter().enumerate() {
                if piece.is_some_and(|piece| slides(network, piece.branch, piece.nodes[k])) {
                    span.known[k] = EndKnown::Slides;
                }
            }
            found.push(span);
        }
    }
    let mut kept = vec![false; found.len()];
    worst.into_iter().flatten().for_each(|index| kept[index] = true);
    found.into_iter().zip(kept).filter(|(_, kept)| *kept).map(|(span, _)| span).collect()
}

/// An edge of a way, and the vertex before it.
type Via = (usize, usize);

/// The shortest ways from a held vertex to others through those that nothing holds (Dijkstra 1959). Vertices are
/// numbered in the order of their points.
struct Ways {
    /// Points of the vertices.
    vertices: Vec<usize>,
    /// Whether a way may go on through each of them.
    open: Vec<bool>,
    /// The edges at each of them: length (m), number of the other vertex, and index.
    at: Vec<Vec<(f64, usize, usize)>>,
    /// Of each vertex that was reached the length of the way (m), and its last edge with the vertex before that; none
    /// at the source.
    reached: Vec<Option<(f64, Option<Via>)>>,
}

impl Ways {
    fn new(held: &[bool], edges: &[Edge]) -> Self {
        let mut vertices: Vec<usize> = edges.iter().flat_map(|edge| edge.vertices).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let number = |vertex: usize| vertices.binary_search(&vertex).expect("a vertex of an edge");
        let mut at = vec![Vec::new(); vertices.len()];
        for (index, edge) in edges.iter().enumerate() {
            let [a, b] = edge.vertices.map(number);
            let length = length(&edge.pieces) + edge.levers.iter().sum::<f64>();
            at[a].push((length, b, index));
            at[b].push((length, a, index));
        }
        let open = vertices.iter().map(|vertex| !held[*vertex]).collect();
        let reached = vec![None; vertices.len()];
        Self { vertices, open, at, reached }
    }

    /// Finds the ways from a vertex.
    fn search(&mut self, source: usize) {
        self.reached.fill(None);
        // Lengths are not negative: their bits are ordered as they are.
        let mut next = BinaryHeap::from([Reverse((0_u64, source, None))]);
        while let Some(Reverse((length, vertex, via))) = next.pop() {
            let length = f64::from_bits(length);
            if self.reached[vertex].is_some() {
                continue;
            }
            self.reached[vertex] = Some((length, via));
            if vertex == source || self.open[vertex] {
                let ahead = self.at[vertex].iter().filter(|(_, other, _)| self.reached[*other].is_none());
                next.extend(
                    ahead.map(|&(own, other, e)| Reverse(((length + own).to_bits(), other, Some((e, vertex))))),
                );
            }
        }
    }

    /// Edges of the way to a vertex, the last one first, each with the vertex before it.
    fn back_from(&self, end: usize) -> impl Iterator<Item = Via> {
        let last = move |vertex: usize| self.reached[vertex].and_then(|(_, via)| via);
        std::iter::successors(last(end), move |&(_, before)| last(before))
    }
}

/// Events of spans that are shorter than the distance they must bridge.
pub fn overstretched(network: &Network, spans: &Spans) -> Vec<Occurrence> {
    let too_short = spans.all.iter().filter(|span| span.chord > span.length * (1.0 + span.tolerance));
    let event = |span: &CableSpan| {
        let (first, last) = (span.pieces[0], span.pieces[span.pieces.len() - 1]);
        let name = |branch: usize| &network.branches[branch].name;
        let [from, to] = [first.s[0], last.s[1]];
        let to_branch =
            if first.branch == last.branch { String::new() } else { format!(" of `{}`", name(last.branch)) };
        let from_branch = if to_branch.is_empty() { String::new() } else { format!(" of `{}`", name(first.branch)) };
        let CableSpan { length, chord, .. } = *span;
        Occurrence {
            kind: EventKind::Overstretched,
            place: span.place(network, first.branch),
            value: Some(chord),
            limit: Some(length),
            message: format!(
                "between s = {from:.4} m{from_branch} and s = {to:.4} m{to_branch}, {length:.4} m of cable bridge \
                 {chord:.4} m"
            ),
        }
    };
    too_short.map(event).collect()
}
