//! Spans of the harness: the cable between two places that are held, also through joints that nothing holds.

use super::Occurrence;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::f64::consts::PI;
use wireloom_core::constraint::Action;
use wireloom_core::network::{BranchEnd, Place};
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
}

impl Piece {
    /// Its nodes, in the order of the span.
    pub fn in_order(self) -> impl Iterator<Item = usize> {
        let [first, last] = self.nodes;
        (0..=first.abs_diff(last)).map(move |k| if first < last { first + k } else { first - k })
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
pub(crate) struct Span {
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

impl Span {
    /// Middle of its first piece on a branch.
    pub fn place(&self, network: &Network, branch: usize) -> EventPlace {
        let own = self.pieces.iter().find(|piece| piece.branch == branch).unwrap_or(&self.pieces[0]);
        EventPlace::branch(&network.branches[own.branch].name, 0.5 * (own.s[0] + own.s[1]))
    }

    /// Branch and arc length (m) of its ends.
    pub fn ends(&self) -> [(usize, f64); 2] {
        let (first, last) = (self.pieces[0], self.pieces[self.pieces.len() - 1]);
        [(first.branch, first.s[0]), (last.branch, last.s[1])]
    }

    /// Force above which it is not stable while it is straight, even between clamped ends, N: Rayleigh's quotient for
    /// the shape `1 − cos(2πs/L)`, `(2π/L)² Σ EI (2/L) ∫ cos²(2πs/L) ds` with the smaller EI of each piece. With one
    /// section it is Euler's `4 π² EI/L²` (Timoshenko & Gere 1961, sections 2.2 and 2.8).
    pub fn euler(&self, network: &Network) -> f64 {
        let k = 2.0 * PI / self.length;
        // ∫ cos²(ks) ds from 0 to s.
        let integral = |s: f64| 0.5 * s + (2.0 * k * s).sin() / (4.0 * k);
        let (mut s, mut sum) = (0.0, 0.0);
        for piece in &self.pieces {
            let [one, other] = network.branches[piece.branch].section.bending_stiffness;
            let before = s;
            s += piece.length();
            sum += one.min(other) * (integral(s) - integral(before));
        }
        k * k * (2.0 / self.length) * sum
    }
}

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
        self.pieces = self.pieces.into_iter().rev().map(Piece::turned).collect();
        self
    }

    fn length(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.length()).sum()
    }

    fn other(&self, vertex: usize) -> usize {
        if self.vertices[0] == vertex { self.vertices[1] } else { self.vertices[0] }
    }
}

/// Spans of a harness, and those of each branch.
pub(crate) struct Spans {
    pub all: Vec<Span>,
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
            all.push(Span {
                pieces: edge.pieces.clone(),
                length: edge.length(),
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
            Action::Equations(_) => &mut supported,
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

/// Edges that go on through joints of two arms without lever arms that nothing holds.
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
        if one.levers[1] + other.levers[0] > 0.0 {
            (edges[a], edges[b]) = (Some(one), Some(other));
            continue;
        }
        for index in at.entry(other.vertices[1]).or_default() {
            if *index == b {
                *index = a;
            }
        }
        edges[a] = Some(Edge {
            vertices: [one.vertices[0], other.vertices[1]],
            levers: [one.levers[0], other.levers[1]],
            alone: one.alone && other.alone && !supported[point],
            pieces: [one.pieces, other.pieces].concat(),
        });
    }
    edges.into_iter().flatten().collect()
}

/// Of the shortest ways between two held places through joints that nothing holds, for each branch the one that bridges
/// the largest distance for its length.
fn most_stretched(network: &Network, state: &State, held: &[bool], edges: &[Edge]) -> Vec<Span> {
    let at = incidence(edges);
    let mut found: Vec<Span> = Vec::new();
    let mut worst: Vec<Option<usize>> = vec![None; network.branches.len()];
    for &source in at.keys().filter(|vertex| held[**vertex]) {
        let reached = shortest_ways(source, held, edges, &at);
        for (&end, &(length, _)) in reached.iter().filter(|(end, _)| held[**end] && **end > source) {
            let way = way_back(end, &reached, edges);
            let chord = (state.points[end] - state.points[source]).norm();
            let mut branches: Vec<usize> = way.iter().flat_map(|e| &edges[*e].pieces).map(|p| p.branch).collect();
            branches.retain(|b| worst[*b].is_none_or(|k: usize| chord * found[k].length > found[k].chord * length));
            // A single cable without lever arms is known already.
            let is_known = matches!(way[..], [single] if edges[single].levers == [0.0; 2]);
            if is_known || branches.is_empty() {
                continue;
            }
            for b in branches {
                worst[b] = Some(found.len());
            }
            let (mut pieces, mut vertex) = (Vec::new(), source);
            for edge in way.iter().rev().map(|e| &edges[*e]) {
                if edge.vertices[0] == vertex {
                    pieces.extend(&edge.pieces);
                } else {
                    pieces.extend(edge.pieces.iter().rev().map(|piece| piece.turned()));
                }
                vertex = edge.other(vertex);
            }
            let mut span =
                Span { pieces, length, chord, tolerance: ROUND_OFF, known: [EndKnown::Place; 2], alone: false };
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

/// Vertices reached from a held one, through those that nothing holds (Dijkstra 1959): length of the shortest way, m,
/// and its last edge.
fn shortest_ways(source: usize, held: &[bool], edges: &[Edge], at: &Incidence) -> BTreeMap<usize, (f64, usize)> {
    let mut reached = BTreeMap::new();
    // Lengths are not negative: their bits are ordered as they are.
    let mut next = BinaryHeap::from([Reverse((0_u64, source, usize::MAX))]);
    while let Some(Reverse((length, vertex, via))) = next.pop() {
        if reached.contains_key(&vertex) {
            continue;
        }
        reached.insert(vertex, (f64::from_bits(length), via));
        if vertex == source || !held[vertex] {
            for &e in &at[&vertex] {
                let on = f64::from_bits(length) + edges[e].length() + edges[e].levers.iter().sum::<f64>();
                next.push(Reverse((on.to_bits(), edges[e].other(vertex), e)));
            }
        }
    }
    reached
}

/// Edges of the way to a vertex, the last one first.
fn way_back(end: usize, reached: &BTreeMap<usize, (f64, usize)>, edges: &[Edge]) -> Vec<usize> {
    let (mut way, mut vertex) = (Vec::new(), end);
    while let Some(&(_, via)) = reached.get(&vertex).filter(|(_, via)| *via != usize::MAX) {
        way.push(via);
        vertex = edges[via].other(vertex);
    }
    way
}

/// Events of spans that are shorter than the distance they must bridge.
pub fn overstretched(problem: &Problem<'_>, state: &State) -> Vec<Occurrence> {
    let spans = Spans::new(problem, state).all.into_iter();
    let too_short = spans.filter(|span| span.chord > span.length * (1.0 + span.tolerance));
    let event = |span: Span| {
        let (first, last) = (span.pieces[0], span.pieces[span.pieces.len() - 1]);
        let name = |branch: usize| &problem.network.branches[branch].name;
        let [from, to] = [first.s[0], last.s[1]];
        let to_branch =
            if first.branch == last.branch { String::new() } else { format!(" of `{}`", name(last.branch)) };
        let from_branch = if to_branch.is_empty() { String::new() } else { format!(" of `{}`", name(first.branch)) };
        let Span { length, chord, .. } = span;
        Occurrence {
            kind: EventKind::Overstretched,
            place: span.place(problem.network, first.branch),
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
