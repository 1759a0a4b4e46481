//! Parts of the elimination tree that can be worked on at the same time.
//!
//! In the factor the parent of a column is its first row below the diagonal; columns of which neither is an ancestor of the other
//! have nothing to do with each other. So subtrees can be eliminated side by side, each adding what it does to its ancestors in a room
//! of its own; the rooms are emptied in a fixed order (the multifrontal method: Duff and Reid 1983; parts: Liu 1990).
//! The parts depend on the pattern alone, never on how many threads there are.

use std::ops::Range;
use wireloom_core::Matrix;

/// Columns from which on it is worth the while to hand a subtree to another thread: some 100 µs.
const WORTHWHILE: usize = 1024;

/// Subtrees, and the columns above them that come when all of them are eliminated.
pub struct Part {
    /// All its columns, those of its children first.
    pub columns: Range<usize>,
    /// First of its own columns: those of no child.
    pub own: usize,
    /// Independent of each other; their columns follow each other without gaps.
    pub children: Vec<Part>,
    /// Rows after its last column in which it has blocks, increasing.
    pub beyond: Vec<u32>,
    /// What its elimination adds to the blocks of these rows: lower triangle, row by row.
    pub updates: Vec<Matrix>,
}

impl Part {
    /// Disjoint ranges of columns that make up the whole, increasing: the own ones of every part.
    pub fn ranges(&self) -> Vec<Range<usize>> {
        let mut ranges: Vec<Range<usize>> = self.children.iter().flat_map(Self::ranges).collect();
        if self.own < self.columns.end {
            ranges.push(self.own..self.columns.end);
        }
        ranges
    }

    /// Where in [`Self::updates`] the block of two rows is, `j` at most `i`.
    pub fn place(i: usize, j: usize) -> usize {
        i * (i + 1) / 2 + j
    }

    /// Where in [`Self::updates`] the block of two rows beyond is.
    ///
    /// # Panics
    /// If one of them is not.
    pub fn update_of(beyond: &[u32], row: u32, column: u32) -> usize {
        let place = |r: u32| beyond.binary_search(&r).expect("a row beyond");
        Self::place(place(row), place(column))
    }
}

/// An elimination tree: `columns[p]` are the rows of column p that are eliminated after it, in any order.
pub struct Tree<'c> {
    columns: &'c [Vec<u32>],
    children: Vec<Vec<usize>>,
    roots: Vec<usize>,
    /// Columns in the subtree.
    weight: Vec<usize>,
    /// Columns that make a part; more than there are where everything is to be one.
    worthwhile: usize,
    /// Columns in their new order.
    order: Vec<usize>,
}

impl<'c> Tree<'c> {
    /// Of the columns of a factor, which is divided where it may be `shared` among threads and is large.
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
        let worthwhile = if shared { WORTHWHILE } else { n + 1 };
        Self { columns, children, roots, weight, worthwhile, order: Vec::with_capacity(n) }
    }

    /// An order that causes the same fill and keeps every part together, and the parts.
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

    fn heavy(&self, v: usize) -> bool {
        self.weight[v] >= 2 * self.worthwhile
    }

    /// The part of what hangs below `above` (from the top down), which has the children `below`.
    fn part(&mut self, above: &[usize], below: &[usize]) -> Part {
        // From the top down as long as all that is heavy is one column after the other.
        let (mut spine, mut light) = (above.to_vec(), Vec::new());
        let mut below = below.to_vec();
        let heavy = loop {
            let (heavy, rest): (Vec<usize>, Vec<usize>) = below.iter().partition(|&&v| self.heavy(v));
            light.extend(rest.into_iter().rev());
            let [v] = heavy[..] else { break heavy };
            spine.push(v);
            below.clone_from(&self.children[v]);
        };
        light.reverse();
        let start = self.order.len();
        let mut children: Vec<Part> = Vec::new();
        for v in heavy {
            let below = self.children[v].clone();
            children.push(self.part(&[v], &below));
        }
        // What is not worth a thread of its own is taken together.
        let mut first = self.order.len();
        for v in light {
            self.subtree(v);
            if self.order.len() - first >= self.worthwhile {
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

    /// Takes a subtree in the order of the elimination: that goes from branch to branch, so the processor, too, has several things to do
    /// at the same time.
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

    /// Everything a part promises.
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
