//! Elimination tree, divided into parts that can be eliminated in parallel.
//!
//! The parent of a column is its first row below the diagonal in the factor; columns of which neither is an ancestor of
//! the other are independent. So subtrees can be eliminated in parallel, each collecting its contributions to its
//! ancestors in an update matrix of its own; these are added in a fixed order (multifrontal method: Duff and Reid 1983;
//! parts: Liu 1990). The parts depend on the pattern only, not on the number of threads.

use std::ops::Range;
use wireloom_core::Matrix;

/// Smallest number of columns of a subtree for a thread of its own: about 100 µs of work.
const SMALLEST_TASK: usize = 1024;

/// Independent subtrees, and the columns above them, which are eliminated after all of them.
#[derive(Clone)]
pub struct Part {
    /// All columns of the part, those of its children first.
    pub columns: Range<usize>,
    /// First of the columns that belong to no child.
    pub own: usize,
    /// Independent subtrees; their columns follow each other without gaps.
    pub children: Vec<Part>,
    /// Rows after the last column of the part in which it has blocks, increasing.
    pub beyond: Vec<u32>,
    /// Update matrix: contributions of the elimination to the blocks of these rows; lower triangle, row by row.
    pub updates: Vec<Matrix>,
}

impl Part {
    /// Disjoint, increasing ranges of columns that make up the part: the own columns of itself and of all descendants.
    pub fn ranges(&self) -> Vec<Range<usize>> {
        let mut ranges: Vec<Range<usize>> = self.children.iter().flat_map(Self::ranges).collect();
        if self.own < self.columns.end {
            ranges.push(self.own..self.columns.end);
        }
        ranges
    }

    /// Index in [`Self::updates`] of the block of rows `i` and `j` of [`Self::beyond`], `j` at most `i`.
    pub fn place(i: usize, j: usize) -> usize {
        i * (i + 1) / 2 + j
    }

    /// Index in [`Self::updates`] of the block (row, column).
    ///
    /// # Panics
    /// If one of them is not in `beyond`.
    pub fn update_of(beyond: &[u32], row: u32, column: u32) -> usize {
        let place = |r: u32| beyond.binary_search(&r).expect("a row beyond");
        Self::place(place(row), place(column))
    }
}

/// Elimination tree: `columns[p]` are the rows of column p that are eliminated after it, in any order.
pub struct Tree<'c> {
    columns: &'c [Vec<u32>],
    children: Vec<Vec<usize>>,
    roots: Vec<usize>,
    /// Number of columns in the subtree of each column.
    weight: Vec<usize>,
    /// Smallest number of columns of a part; more than there are, if the tree is not to be divided.
    smallest_part: usize,
    /// Columns in their new order.
    order: Vec<usize>,
}

impl<'c> Tree<'c> {
    /// Tree of the columns of a factor; divided into parts if it is `shared` among threads and large.
    pub fn new(columns: &'c [Vec<u32>], shared: bool) -> Self {
        let n = columns.len();
        let (mut children, mut roots, mut weight) = (vec![Vec::new(); n], Vec::new(), vec![1; n]);
        for (p, rows) in columns.iter().enumerate() {
            match rows.iter().min() {
                Some(&parent) => {
                    children[parent as usize].push(p);
                    weight[parent as usize] += weight[p];
                }
                None => roots.push(p),
            }
        }
        let smallest_part = if shared { SMALLEST_TASK } else { n + 1 };
        Self { columns, children, roots, weight, smallest_part, order: Vec::with_capacity(n) }
    }

    /// Equivalent order (with the same fill) in which every part is contiguous, and the parts.
    pub fn arrange(mut self) -> (Vec<usize>, Part) {
        let roots = std::mem::take(&mut self.roots);
        let mut whole = self.part(&[], &roots);
        let mut position = vec![0; self.order.len()];
        for (new, &old) in self.order.iter().enumerate() {
            position[old] = new as u32;
        }
        self.find_beyond(&mut whole, &position);
        (self.order, whole)
    }

    fn is_large(&self, v: usize) -> bool {
        self.weight[v] >= 2 * self.smallest_part
    }

    /// Part of the subtree with the columns `above` (from the top down) and their children `below`.
    fn part(&mut self, above: &[usize], below: &[usize]) -> Part {
        // Descend as long as there is exactly one large child.
        let (mut spine, mut small) = (above.to_vec(), Vec::new());
        let mut below = below.to_vec();
        let large = loop {
            let (large, rest): (Vec<usize>, Vec<usize>) = below.iter().partition(|&&v| self.is_large(v));
            small.extend(rest.into_iter().rev());
            let [v] = large[..] else { break large };
            spine.push(v);
            below.clone_from(&self.children[v]);
        };
        small.reverse();
        let start = self.order.len();
        let mut children: Vec<Part> = Vec::new();
        for v in large {
            let below = self.children[v].clone();
            children.push(self.part(&[v], &below));
        }
        // Small subtrees are combined to parts.
        let mut first = self.order.len();
        for v in small {
            self.subtree(v);
            if self.order.len() - first >= self.smallest_part {
                children.push(leaf(first..self.order.len()));
                first = self.order.len();
            }
        }
        if children.len() == 1 && children[0].children.is_empty() {
            first = children.remove(0).columns.start;
        }
        self.order.extend(spine.iter().rev());
        Part { columns: start..self.order.len(), own: first, children, beyond: vec![], updates: vec![] }
    }

    /// Appends a subtree in its original elimination order, which alternates between branches and so lets the processor
    /// overlap independent operations.
    fn subtree(&mut self, root: usize) {
        let (first, mut open) = (self.order.len(), vec![root]);
        while let Some(v) = open.pop() {
            self.order.push(v);
            open.extend_from_slice(&self.children[v]);
        }
        self.order[first..].sort_unstable();
    }

    fn find_beyond(&self, part: &mut Part, position: &[u32]) {
        let mut beyond = Vec::new();
        for child in &mut part.children {
            self.find_beyond(child, position);
            beyond.extend_from_slice(&child.beyond);
        }
        for &old in &self.order[part.own..part.columns.end] {
            beyond.extend(self.columns[old].iter().map(|&row| position[row as usize]));
        }
        beyond.retain(|&row| row as usize >= part.columns.end);
        beyond.sort_unstable();
        beyond.dedup();
        part.updates = vec![Matrix::zeros(); Part::place(beyond.len(), 0)];
        part.beyond = beyond;
    }
}

fn leaf(columns: Range<usize>) -> Part {
    Part { own: columns.start, columns, children: vec![], beyond: vec![], updates: vec![] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks all invariants of a part.
    fn check(part: &Part, columns: &[Vec<u32>], order: &[usize], position: &[u32]) {
        let mut next = part.columns.start;
        for child in &part.children {
            assert_eq!(child.columns.start, next, "children follow each other");
            next = child.columns.end;
            check(child, columns, order, position);
        }
        assert_eq!(part.own, next, "its own columns follow");
        for p in part.columns.clone() {
            for row in columns[order[p]].iter().map(|&row| position[row as usize]) {
                assert!(row as usize > p, "after what it depends on");
                let inside = part.columns.contains(&(row as usize));
                assert!(inside || part.beyond.binary_search(&row).is_ok(), "every row has a place");
                let child = part.children.iter().find(|c| c.columns.contains(&p));
                let sibling = part.children.iter().find(|c| c.columns.contains(&(row as usize)));
                assert!(
                    sibling.is_none_or(|s| child.is_some_and(|c| c.columns == s.columns)),
                    "siblings are independent"
                );
            }
        }
    }

    /// A random tree as an elimination tree: every column has a few of its ancestors as rows, its parent among them.
    fn random_columns(n: usize, straight: f64, seed: u64) -> Vec<Vec<u32>> {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut parents: Vec<Option<usize>> = vec![None; n];
        for (p, parent) in parents.iter_mut().enumerate().take(n - 1) {
            *parent = Some(if random.f64() < straight { p + 1 } else { random.usize(p + 1..n) });
        }
        parents[n / 3] = None;
        let up = |p: usize| std::iter::successors(Some(p), |&p| parents[p]).skip(1);
        let mut columns: Vec<Vec<u32>> = vec![Vec::new(); n];
        for (p, column) in columns.iter_mut().enumerate() {
            column.extend(up(p).take(1 + p % 2).map(|row| row as u32));
            column.reverse();
        }
        columns
    }

    #[test]
    fn parts_are_independent_and_complete() {
        let mut shared = 0;
        for (seed, (n, straight)) in
            [(40, 0.5), (3000, 0.9), (5000, 0.99), (20_000, 0.999), (20_000, 0.9), (9000, 1.0)].into_iter().enumerate()
        {
            let columns = random_columns(n, straight, seed as u64);
            let (order, whole) = Tree::new(&columns, true).arrange();
            let mut position = vec![u32::MAX; n];
            for (new, &old) in order.iter().enumerate() {
                position[old] = new as u32;
            }
            assert!(order.len() == n && position.iter().all(|&p| p != u32::MAX), "every column once");
            assert_eq!((whole.columns.clone(), whole.beyond.len()), (0..n, 0));
            check(&whole, &columns, &order, &position);
            let ranges = whole.ranges();
            assert_eq!(ranges.iter().map(ExactSizeIterator::len).sum::<usize>(), n);
            assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start));
            shared += usize::from(!whole.children.is_empty());
        }
        assert!(shared >= 3, "large trees are divided: {shared}");
    }
}
