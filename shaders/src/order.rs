//! Elimination order of the variables: nested dissection (George 1973) down to leaves, minimum degree within them.
//!
//! A separator is a level of a breadth-first search, so graphs with loops are allowed. The level is chosen that
//! minimises the sequential work: its own size plus twice the logarithm of the largest remaining part.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Elimination order of the vertices of a graph (neighbours of each vertex). Parts of at most `leaf` vertices are not
/// dissected: a small leaf gives many independent tasks, `usize::MAX` the fewest operations.
pub(crate) fn elimination_order(graph: &[Vec<u32>], leaf: usize) -> Vec<u32> {
    let mut pieces = Pieces { graph, part: vec![0; graph.len()], next: 1 };
    let all: Vec<u32> = (0..graph.len() as u32).collect();
    let mut open = pieces.connected(&all);
    let mut reversed = Vec::with_capacity(graph.len());
    while let Some(piece) = open.pop() {
        let separator = if piece.len() > leaf { pieces.separator(&piece) } else { None };
        let Some(separator) = separator else {
            reversed.extend(pieces.minimum_degree(&piece).into_iter().rev());
            pieces.eliminate(&piece);
            continue;
        };
        reversed.extend(separator.iter().rev());
        pieces.eliminate(&separator);
        let rest: Vec<u32> = piece.into_iter().filter(|v| pieces.part[*v as usize] != ELIMINATED).collect();
        open.extend(pieces.connected(&rest));
    }
    reversed.reverse();
    reversed
}

/// Part of a vertex that has been ordered.
const ELIMINATED: u32 = u32::MAX;

/// The parts of a graph that remain.
struct Pieces<'g> {
    graph: &'g [Vec<u32>],
    /// The part of each vertex.
    part: Vec<u32>,
    next: u32,
}

impl Pieces<'_> {
    fn eliminate(&mut self, vertices: &[u32]) {
        for &v in vertices {
            self.part[v as usize] = ELIMINATED;
        }
    }

    /// Connected components of a set of vertices without other neighbours; each becomes a part.
    fn connected(&mut self, vertices: &[u32]) -> Vec<Vec<u32>> {
        let old: Vec<u32> = vertices.iter().map(|&v| self.part[v as usize]).collect();
        let mut found = Vec::new();
        for (&v, part) in vertices.iter().zip(old) {
            if self.part[v as usize] != part {
                continue;
            }
            let own = self.next;
            self.next += 1;
            self.part[v as usize] = own;
            let mut piece = vec![v];
            let mut k = 0;
            while k < piece.len() {
                for &next in &self.graph[piece[k] as usize] {
                    if self.part[next as usize] == part {
                        self.part[next as usize] = own;
                        piece.push(next);
                    }
                }
                k += 1;
            }
            piece.sort_unstable();
            found.push(piece);
        }
        found
    }

    /// Vertices of the part of `start` in breadth-first order, and the start of each level.
    fn levels(&self, start: u32) -> (Vec<u32>, Vec<usize>) {
        let part = self.part[start as usize];
        let mut seen = std::collections::HashSet::from([start]);
        let (mut order, mut starts) = (vec![start], vec![0]);
        let mut first = 0;
        while first < order.len() {
            let end = order.len();
            starts.push(end);
            for k in first..end {
                for &next in &self.graph[order[k] as usize] {
                    if self.part[next as usize] == part && seen.insert(next) {
                        order.push(next);
                    }
                }
            }
            first = end;
        }
        (order, starts)
    }

    /// The best separator of a part; `None` if the part is too dense.
    fn separator(&self, piece: &[u32]) -> Option<Vec<u32>> {
        let mut end = piece[0];
        for _ in 0..2 {
            end = *self.levels(end).0.last()?;
        }
        let (order, starts) = self.levels(end);
        let levels = starts.len() - 1;
        let place: std::collections::HashMap<u32, usize> = order.iter().enumerate().map(|(k, &v)| (v, k)).collect();
        // Largest connected component beyond each level, by joining levels from the last one on.
        let mut parent: Vec<usize> = (0..order.len()).collect();
        let mut weight = vec![1_usize; order.len()];
        let mut beyond = vec![0; levels + 1];
        let mut largest = 0;
        for level in (0..levels).rev() {
            beyond[level] = largest;
            for (k, &v) in (starts[level]..).zip(&order[starts[level]..starts[level + 1]]) {
                largest = largest.max(1);
                for next in &self.graph[v as usize] {
                    if let Some(&other) = place.get(next).filter(|&&other| other >= starts[level]) {
                        let (a, b) = (root(&mut parent, k), root(&mut parent, other));
                        if a != b {
                            parent[a] = b;
                            weight[b] += weight[a];
                            largest = largest.max(weight[b]);
                        }
                    }
                }
            }
        }
        let cost = |level: &usize| {
            let piece = starts[*level].max(beyond[*level]);
            (starts[level + 1] - starts[*level]) as f64 + 2.0 * (piece as f64).log2()
        };
        let best = (1..levels.saturating_sub(1)).min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
        // Vertices without neighbours beyond the level do not belong to the separator.
        let cut = starts[best + 1];
        let touches = |v: &u32| self.graph[*v as usize].iter().any(|next| place.get(next).is_some_and(|&k| k >= cut));
        Some(order[starts[best]..cut].iter().copied().filter(touches).collect())
    }

    /// Minimum-degree order (Tinney and Walker 1967) of a part, ties by number.
    fn minimum_degree(&self, piece: &[u32]) -> Vec<u32> {
        let local = |v: u32| piece.binary_search(&v).ok().map(|k| k as u32);
        let mut graph: Vec<Vec<u32>> =
            piece.iter().map(|&v| self.graph[v as usize].iter().filter_map(|&next| local(next)).collect()).collect();
        let mut heap: BinaryHeap<_> = graph.iter().enumerate().map(|(v, n)| Reverse((n.len(), v))).collect();
        let mut gone = vec![false; piece.len()];
        let mut order = Vec::with_capacity(piece.len());
        while let Some(Reverse((degree, v))) = heap.pop() {
            if gone[v] || degree != graph[v].len() {
                continue;
            }
            gone[v] = true;
            let clique = std::mem::take(&mut graph[v]);
            for &a in &clique {
                let neighbours = &mut graph[a as usize];
                neighbours.retain(|&b| b as usize != v);
                for &b in clique.iter().filter(|&&b| b != a) {
                    if let Err(place) = neighbours.binary_search(&b) {
                        neighbours.insert(place, b);
                    }
                }
                heap.push(Reverse((neighbours.len(), a as usize)));
            }
            order.push(piece[v]);
        }
        order
    }
}

fn root(parent: &mut [usize], mut k: usize) -> usize {
    while parent[k] != k {
        parent[k] = parent[parent[k]];
        k = parent[k];
    }
    k
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_cut_in_the_middle() {
        let n = 1000_u32;
        let graph: Vec<Vec<u32>> = (0..n).map(|v| (0..n).filter(|w| w.abs_diff(v) == 1).collect()).collect();
        let order = elimination_order(&graph, 1);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..n).collect::<Vec<u32>>());
        assert!((400..600).contains(order.last().unwrap()), "{:?}", order.last());
    }

    #[test]
    fn a_hub_is_cut_out_first() {
        // Sixteen arms of twenty vertices.
        let mut graph = vec![vec![]; 321];
        for arm in 0..16_u32 {
            for k in 0..20 {
                let own = 1 + 20 * arm + k;
                let next = if k == 0 { 0 } else { own - 1 };
                graph[own as usize].push(next);
                graph[next as usize].push(own);
            }
        }
        graph.iter_mut().for_each(|neighbours| neighbours.sort_unstable());
        assert_eq!(*elimination_order(&graph, 1).last().unwrap(), 0);
    }
}
