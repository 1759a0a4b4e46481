//! Symbolic factorisation: non-zero blocks of the Hessian and of its factor, and the elimination order.

use crate::linear::elimination_tree::{Part, Tree};
use std::cell::RefCell;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use wireloom_core::Network;
use wireloom_core::constraint::Action;
use wireloom_core::variable::Variable;

/// First value of a position that marks a tie: at `TIED + t` the point or frame has no variable of its own but follows
/// a joint by tie t of the network.
pub const TIED: u32 = 1 << 31;

/// Position of what is not a variable: frames, and points that are no anchors, in [`Structure::of_points`].
const ABSENT: u32 = u32::MAX;

/// Structures that each thread keeps: those of the Hessian, of its points, and of both on a coarse mesh.
const KEPT: usize = 4;

/// Most variables of a structure that is kept.
const LARGEST_KEPT: usize = 1 << 14;

thread_local! {
    /// The graphs ordered last, with their structures, the newest first. The minimiser and the certificate need the
    /// same one, and so do the points of a sweep.
    static ORDERED: RefCell<VecDeque<(Graph, Structure)>> = const { RefCell::new(VecDeque::new()) };
}

/// Variables in their natural order, and which of them the energy couples.
#[derive(PartialEq)]
struct Graph {
    variables: Vec<Variable>,
    /// Number of every point and frame; see [`TIED`].
    of_point: Vec<u32>,
    of_frame: Vec<u32>,
    coupled: Coupled,
    /// [`Network::is_shared`].
    shared: bool,
}

/// Sets of variables that the energy couples with each other, by their numbers: of a segment, of a joint, and so on.
#[derive(Default, PartialEq)]
struct Coupled {
    /// Members of all sets, one set after the other; a set may name a variable twice.
    members: Vec<u32>,
    /// Where each set ends.
    ends: Vec<usize>,
}

impl Coupled {
    /// Ends a set: all members since the last one.
    fn end_set(&mut self) {
        self.ends.push(self.members.len());
    }

    /// For each of `count` variables the variables coupled to it, increasing.
    fn neighbours(&self, count: usize) -> Vec<Vec<u32>> {
        let mut graph = vec![Vec::new(); count];
        let mut first = 0;
        for &end in &self.ends {
            let set = &self.members[first..end];
            for &a in set {
                graph[a as usize].extend(set.iter().copied().filter(|&b| b != a));
            }
            first = end;
        }
        for neighbours in &mut graph {
            neighbours.sort_unstable();
            neighbours.dedup();
        }
        graph
    }
}

/// Pattern of the factor: for each column, in elimination order, the rows below the diagonal.
#[derive(Clone)]
pub struct Pattern {
    /// `rows[starts[p]..starts[p + 1]]` are the rows of column p, increasing.
    pub starts: Vec<u32>,
    /// Rows below the diagonal.
    pub rows: Vec<u32>,
}

impl Pattern {
    /// Index of the block (row, column), row after column in elimination order.
    ///
    /// # Panics
    /// If the pattern has no such block.
    pub fn slot(&self, row: u32, column: u32) -> usize {
        self.find(row, column).expect("a block of the pattern")
    }

    /// Index of the block (row, column), if the pattern contains it.
    pub fn find(&self, row: u32, column: u32) -> Option<usize> {
        let (start, end) = (self.starts[column as usize] as usize, self.starts[column as usize + 1] as usize);
        self.rows[start..end].binary_search(&row).ok().map(|place| start + place)
    }
}

/// Variables in elimination order, and the pattern of their factor.
#[derive(Clone)]
pub struct Structure {
    /// Variables in elimination order.
    pub variables: Vec<Variable>,
    /// Position in elimination order of every point; see [`TIED`]. In [`Self::of_points`] a tied point has the position
    /// of its joint.
    pub of_point: Vec<u32>,
    /// Position in elimination order of every frame; see [`TIED`].
    pub of_frame: Vec<u32>,
    /// Pattern of the factor.
    pub pattern: Pattern,
    /// Parts of the elimination tree that can be eliminated in parallel.
    pub parts: Part,
}

impl Structure {
    /// Structure of a network's Hessian; each entry of `touching` lists variables that contact couples.
    pub fn new(network: &Network, touching: &[Vec<Variable>]) -> Self {
        // Natural numbering: along the branches, joints last.
        let mut variables = Vec::new();
        let (mut of_point, mut of_frame) = (vec![0; network.points], vec![0; network.frames]);
        for (t, tie) in network.ties.iter().enumerate() {
            of_point[tie.point] = TIED + t as u32;
            if let Some(frame) = tie.frame {
                of_frame[frame] = TIED + t as u32;
            }
        }
        for branch in &network.branches {
            let mesh = branch.rod.mesh();
            for node in 0..mesh.nodes() {
                let point = branch.points.start + node;
                if of_point[point] < TIED {
                    variables.push(Variable::Point(point));
                }
                let station = mesh.station_frame(node);
                let segment = mesh.segment_frames.get(node).copied();
                for frame in [station, segment].into_iter().flatten().map(|c| branch.frames.start + c) {
                    if of_frame[frame] < TIED {
                        variables.push(Variable::Frame(frame));
                    }
                }
            }
        }
        for joint in &network.joints {
            variables.push(Variable::Point(joint.point));
            variables.extend(joint.frame.map(Variable::Frame));
        }
        number(&variables, &mut of_point, &mut of_frame);
        let coupled = coupled(network, touching, &of_point, &of_frame);
        Self::of(Graph { variables, of_point, of_frame, coupled, shared: network.is_shared() })
    }

    /// Structure of the second derivatives with respect to the points that are `anchors`; those that follow each other
    /// along a branch are coupled. `touching` as in [`Self::new`].
    pub fn of_points(network: &Network, touching: &[Vec<Variable>], anchors: &[bool]) -> Self {
        let mut own = anchors.to_vec();
        for tie in &network.ties {
            own[tie.point] = false;
        }
        let points = own.iter().enumerate().filter(|(_, own)| **own);
        let variables: Vec<Variable> = points.map(|(i, _)| Variable::Point(i)).collect();
        let mut of_point = vec![ABSENT; network.points];
        number(&variables, &mut of_point, &mut []);
        for tie in &network.ties {
            of_point[tie.point] = of_point[tie.hub_point];
        }
        let mut coupled = Coupled::default();
        for branch in &network.branches {
            let places = of_point[branch.points.clone()].iter().copied();
            let places: Vec<u32> = places.filter(|place| *place != ABSENT).collect();
            for pair in places.array_windows::<2>() {
                coupled.members.extend(pair);
                coupled.end_set();
            }
        }
        for constraint in &network.constraints {
            if matches!(constraint.model.action(), Action::Prescribed(_)) {
                continue;
            }
            coupled.members.extend(constraint.stations.iter().map(|site| of_point[site.point]));
            coupled.end_set();
        }
        for touching in touching {
            let points =
                touching.iter().filter_map(|v| if let Variable::Point(i) = v { Some(of_point[*i]) } else { None });
            coupled.members.extend(points);
            coupled.end_set();
        }
        let of_frame = vec![ABSENT; network.frames];
        let mut structure = Self::of(Graph { variables, of_point, of_frame, coupled, shared: network.is_shared() });
        for tie in &network.ties {
            structure.of_point[tie.point] = structure.of_point[tie.hub_point];
        }
        structure
    }

    /// Structure of a graph; one that this thread has found lately is not sought again.
    fn of(graph: Graph) -> Self {
        if graph.variables.len() > LARGEST_KEPT {
            return Self::ordered(&graph);
        }
        ORDERED.with_borrow_mut(|kept| {
            let (graph, structure) = match kept.iter().position(|(known, _)| *known == graph) {
                Some(k) => kept.remove(k).expect("it was found there"),
                None => {
                    let structure = Self::ordered(&graph);
                    (graph, structure)
                }
            };
            kept.push_front((graph, structure.clone()));
            kept.truncate(KEPT);
            structure
        })
    }

    /// Finds the elimination order and the pattern of the factor.
    fn ordered(graph: &Graph) -> Self {
        let Graph { variables, of_point, of_frame, coupled, shared } = graph;
        let (mut of_point, mut of_frame) = (of_point.clone(), of_frame.clone());
        let (order, cliques) = minimum_degree(coupled.neighbours(variables.len()));
        let position = positions(&order);
        let columns: Vec<Vec<u32>> =
            cliques.iter().map(|clique| clique.iter().map(|&v| position[v as usize]).collect()).collect();
        let (arranged, parts) = Tree::new(&columns, *shared).arrange();
        let order: Vec<u32> = arranged.iter().map(|&p| order[p]).collect();
        let position = positions(&order);
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for p in arranged {
            let first = rows.len();
            rows.extend(cliques[p].iter().map(|&v| position[v as usize]));
            rows[first..].sort_unstable();
            starts.push(rows.len() as u32);
        }
        let variables: Vec<Variable> = order.iter().map(|&v| variables[v as usize]).collect();
        number(&variables, &mut of_point, &mut of_frame);
        Self { variables, of_point, of_frame, pattern: Pattern { starts, rows }, parts }
    }

    /// Number of block rows.
    pub fn len(&self) -> usize {
        self.variables.len()
    }

    /// Whether there are no variables.
    pub fn is_empty(&self) -> bool {
        self.variables.is_empty()
    }

    /// Position in elimination order of a point or frame; `None` if it has no variable of its own here.
    pub fn position(&self, variable: Variable) -> Option<u32> {
        let position = match variable {
            Variable::Point(i) => self.of_point[i],
            Variable::Frame(c) => self.of_frame[c],
        };
        (position < TIED).then_some(position)
    }
}

/// Stores the position of every variable in an order.
fn number(order: &[Variable], of_point: &mut [u32], of_frame: &mut [u32]) {
    for (p, variable) in order.iter().enumerate() {
        match variable {
            Variable::Point(i) => of_point[*i] = p as u32,
            Variable::Frame(c) => of_frame[*c] = p as u32,
        }
    }
}

/// The variables that each part of the energy couples.
fn coupled(network: &Network, touching: &[Vec<Variable>], of_point: &[u32], of_frame: &[u32]) -> Coupled {
    let mut all = Coupled::default();
    let point = |i: usize, all: &mut Coupled| match of_point[i] {
        own if own < TIED => all.members.push(own),
        tied => {
            let tie = &network.ties[(tied - TIED) as usize];
            all.members.push(of_point[tie.hub_point]);
            all.members.extend(tie.hub_frame.map(|c| of_frame[c]));
        }
    };
    let frame = |c: usize, all: &mut Coupled| match of_frame[c] {
        own if own < TIED => all.members.push(own),
        tied => all.members.extend(network.ties[(tied - TIED) as usize].hub_frame.map(|c| of_frame[c])),
    };
    for branch in &network.branches {
        let mesh = branch.rod.mesh();
        for (j, f) in mesh.segment_frames.iter().enumerate() {
            point(branch.points.start + j, &mut all);
            point(branch.points.start + j + 1, &mut all);
            frame(branch.frames.start + f, &mut all);
            all.end_set();
        }
        for beside in &mesh.beside {
            point(branch.points.start + beside.segment, &mut all);
            point(branch.points.start + beside.segment + 1, &mut all);
            let segment = mesh.segment_frames[beside.segment];
            for c in beside.neighbours().into_iter().flatten().chain([segment]) {
                frame(branch.frames.start + c, &mut all);
            }
            all.end_set();
        }
        for pair in mesh.pairs.iter().filter(|_| branch.rod.couples_pairs()) {
            frame(branch.frames.start + pair.frame - 1, &mut all);
            frame(branch.frames.start + pair.frame + 1, &mut all);
            all.end_set();
        }
        for c in 0..mesh.coupling_lengths.len() {
            frame(branch.frames.start + c, &mut all);
            frame(branch.frames.start + c + 1, &mut all);
            all.end_set();
        }
    }
    for joint in &network.joints {
        for &c in &joint.coupled_frames {
            frame(c, &mut all);
        }
        all.end_set();
    }
    for constraint in &network.constraints {
        if matches!(constraint.model.action(), Action::Prescribed(_)) {
            continue;
        }
        for site in &constraint.stations {
            point(site.point, &mut all);
            if let Some(c) = site.frame {
                frame(c, &mut all);
            }
        }
        all.end_set();
    }
    for touching in touching {
        for variable in touching {
            match *variable {
                Variable::Point(i) => point(i, &mut all),
                Variable::Frame(c) => frame(c, &mut all),
            }
        }
        all.end_set();
    }
    all
}

/// Position of every vertex in an order.
fn positions(order: &[u32]) -> Vec<u32> {
    let mut position = vec![0; order.len()];
    for (p, &v) in order.iter().enumerate() {
        position[v as usize] = p as u32;
    }
    position
}

/// Breadth-first search from `start`: vertices in order, each with its predecessor.
fn breadth_first(graph: &[Vec<u32>], start: u32, found: &mut [bool]) -> Vec<(u32, u32)> {
    let (mut order, mut open) = (Vec::new(), VecDeque::from([(start, start)]));
    found[start as usize] = true;
    while let Some((v, from)) = open.pop_front() {
        order.push((v, from));
        for &next in &graph[v as usize] {
            if !std::mem::replace(&mut found[next as usize], true) {
                open.push_back((next, v));
            }
        }
    }
    order
}

/// Distance of every vertex from the centroid of its connected component: the vertex whose removal leaves no part of a
/// spanning tree with more than half of the vertices (Jordan 1869).
fn centroid_distance(graph: &[Vec<u32>]) -> Vec<u32> {
    let n = graph.len();
    let mut distance = vec![0; n];
    let (mut found, mut weight) = (vec![false; n], vec![1; n]);
    for start in 0..n as u32 {
        if found[start as usize] {
            continue;
        }
        let component = breadth_first(graph, start, &mut found);
        for &(v, from) in component.iter().rev().filter(|(v, from)| v != from) {
            weight[from as usize] += weight[v as usize];
        }
        // The last vertex with at least half of the weight: all of these lie on one path from the start.
        let centroid = component.iter().rev().find(|(v, _)| 2 * weight[*v as usize] >= component.len());
        let centroid = centroid.expect("the start holds all").0;
        for (v, _) in &component {
            found[*v as usize] = false;
        }
        for (v, from) in breadth_first(graph, centroid, &mut found) {
            distance[v as usize] = if v == from { 0 } else { distance[from as usize] + 1 };
        }
    }
    distance
}

/// Elimination order by minimum degree (Tinney and Walker 1967), and the neighbours of each vertex at its elimination.
/// On trees of chains it causes no fill. Equal degrees are ordered by decreasing distance from the centroid, then by
/// number: the elimination tree then has its root at the centroid, and its branches can be eliminated in parallel.
fn minimum_degree(mut graph: Vec<Vec<u32>>) -> (Vec<u32>, Vec<Vec<u32>>) {
    let n = graph.len();
    let inward: Vec<Reverse<u32>> = centroid_distance(&graph).into_iter().map(Reverse).collect();
    let mut heap: BinaryHeap<_> =
        graph.iter().enumerate().map(|(v, neighbours)| Reverse((neighbours.len(), inward[v], v as u32))).collect();
    let mut eliminated = vec![false; n];
    let (mut order, mut columns) = (Vec::with_capacity(n), Vec::with_capacity(n));
    while let Some(Reverse((degree, _, v))) = heap.pop() {
        if eliminated[v as usize] || degree != graph[v as usize].len() {
            continue;
        }
        eliminated[v as usize] = true;
        let clique = std::mem::take(&mut graph[v as usize]);
        for &a in &clique {
            let neighbours = &mut graph[a as usize];
            neighbours.retain(|&b| b != v);
            for &b in clique.iter().filter(|&&b| b != a) {
                if let Err(place) = neighbours.binary_search(&b) {
                    neighbours.insert(place, b);
                }
            }
            heap.push(Reverse((neighbours.len(), inward[a as usize], a)));
        }
        order.push(v);
        columns.push(clique);
    }
    (order, columns)
}
