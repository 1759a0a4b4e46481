//! Symbolic part of the direct solver, computed once per graph on the CPU.
//!
//! `A = B D⁻¹ Bᵀ` in blocks of 3 × 3, by the multifrontal method (Duff and Reid 1983). Columns in a chain of the
//! elimination tree without a fork are a *task*, which one invocation eliminates in sequence; tasks of a *level* are
//! independent. A task leaves an *update* of every pair of the rows beyond it for later tasks. So the work of a task
//! does not grow with the depth of the tree; on a chain with nested dissection this is block cyclic reduction (Heller
//! 1976).
//!
//! Owner computes: every block is the sum, in a fixed order, of updates of child tasks and of products of its own task.
//! No block is written by two invocations, so a run repeats bit for bit. The work of a task is encoded as instructions
//! for the stages:
//!
//! ```text
//! factorise   children, tasks; then for every block:       A_ij + Σ U − Σ B_ik D_k⁻¹ B_jkᵀ
//!             block  flags, adds, products; add: block; product: block ik, block jk, pivot k
//! forward                                                  r_j + Σ u − Σ B_jk z_k, z = D⁻¹ y
//!             vector flags, pivot, adds, products; add: vector; product: block jk, vector k
//! backward                                                 x_j = z_j − D_j⁻¹ Σ B_ijᵀ x_i
//!             vector pivot, products; product: block ij, vector i
//! ```

use crate::order::elimination_order;

/// Flag of an instruction: the target is a pivot, which is inverted, or a vector, which is multiplied by a pivot.
pub(crate) const PIVOT: u32 = 1;
/// Flag of an instruction: the target starts from zero, because it is an update.
pub(crate) const UPDATE: u32 = 2;

/// Instructions of all tasks: those of task t are `words[starts[t]..starts[t + 1]]`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Instructions {
    /// Start of each task's instructions.
    pub starts: Vec<u32>,
    /// The encoded instructions.
    pub words: Vec<u32>,
}

impl Instructions {
    /// Instructions of a task.
    pub(crate) fn of(&self, task: usize) -> &[u32] {
        &self.words[self.starts[task] as usize..self.starts[task + 1] as usize]
    }
}

/// Symbolic elimination of a graph.
#[derive(Clone, Debug, PartialEq)]
pub struct Elimination {
    /// The vertex at each position of the elimination order.
    pub order: Vec<u32>,
    /// Rows below the diagonal of every column, increasing.
    pub rows: Vec<Vec<u32>>,
    /// Number of the first pivot; the other pivots follow, then the blocks below the diagonal, column by column.
    pub first_pivot: u32,
    /// Number of the first vector; one per column.
    pub first_vector: u32,
    /// Number of the first block below the diagonal of every column.
    pub first_block: Vec<u32>,
    /// Columns of every task.
    pub tasks: Vec<std::ops::Range<u32>>,
    /// Tasks of every level, in the order of elimination.
    pub levels: Vec<std::ops::Range<u32>>,
    /// Blocks of the matrix: pivots and those below the diagonal.
    pub matrix_blocks: std::ops::Range<u32>,
    /// End of the blocks: updates follow those of the matrix.
    pub blocks_end: u32,
    /// End of the vectors: updates follow those of the columns.
    pub vectors_end: u32,
    /// Factorisation.
    pub factor: Instructions,
    /// Forward substitution.
    pub forward: Instructions,
    /// Backward substitution.
    pub backward: Instructions,
}

impl Elimination {
    /// For a graph (sorted neighbours of each vertex), with the first numbers of blocks and vectors. Parts of at most
    /// `leaf` vertices are not dissected: small leaves give many independent tasks, `usize::MAX` the fewest operations.
    pub fn new(graph: &[Vec<u32>], leaf: usize, first_pivot: u32, first_vector: u32) -> Self {
        let order = elimination_order(graph, leaf);
        let columns = columns(graph, &order);
        let (task_of, level_of_task) = tasks(&columns);
        // Sorted by level, then by task, so that the columns of a task are consecutive.
        let mut arranged: Vec<u32> = (0..order.len() as u32).collect();
        arranged.sort_by_key(|&p| {
            let task = task_of[p as usize];
            (level_of_task[task as usize], task, p)
        });
        let mut place = vec![0; order.len()];
        for (k, &p) in arranged.iter().enumerate() {
            place[p as usize] = k as u32;
        }
        let mut rows = Vec::with_capacity(order.len());
        let mut first_block = Vec::with_capacity(order.len());
        let mut blocks = first_pivot + order.len() as u32;
        let (mut tasks, mut levels): (Vec<std::ops::Range<u32>>, Vec<std::ops::Range<u32>>) = (vec![], vec![]);
        let mut last = None;
        for (k, &p) in arranged.iter().enumerate() {
            let mut own: Vec<u32> = columns[p as usize].iter().map(|&row| place[row as usize]).collect();
            own.sort_unstable();
            first_block.push(blocks);
            blocks += own.len() as u32;
            rows.push(own);
            let (k, task) = (k as u32, task_of[p as usize]);
            let level = level_of_task[task as usize] as usize;
            if last != Some(task) {
                if level == levels.len() {
                    levels.push(tasks.len() as u32..tasks.len() as u32);
                }
                levels[level].end += 1;
                tasks.push(k..k);
                last = Some(task);
            }
            tasks.last_mut().expect("pushed above").end = k + 1;
        }
        let mut elimination = Self {
            order: arranged.iter().map(|&p| order[p as usize]).collect(),
            rows,
            first_pivot,
            first_vector,
            first_block,
            tasks,
            levels,
            matrix_blocks: first_pivot..blocks,
            blocks_end: blocks,
            vectors_end: first_vector + order.len() as u32,
            factor: Instructions::default(),
            forward: Instructions::default(),
            backward: Instructions::default(),
        };
        elimination.instruct();
        elimination
    }

    /// Number of variables.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there is nothing to eliminate.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Number of block (row, column), row ≥ column; `None` if it is not in the pattern.
    pub fn block(&self, row: u32, column: u32) -> Option<u32> {
        if row == column {
            return Some(self.first_pivot + column);
        }
        self.rows[column as usize].binary_search(&row).ok().map(|k| self.first_block[column as usize] + k as u32)
    }

    /// The root tasks: one for each connected component.
    pub fn roots(&self) -> Vec<u32> {
        (0..self.tasks.len()).filter(|&t| self.beyond(t).is_empty()).map(|t| t as u32).collect()
    }

    /// Rows beyond a task: those of its last column.
    fn beyond(&self, task: usize) -> &[u32] {
        &self.rows[self.tasks[task].end as usize - 1]
    }

    fn instruct(&mut self) {
        let mut task_of = vec![0; self.len()];
        for (t, columns) in self.tasks.iter().enumerate() {
            task_of[columns.start as usize..columns.end as usize].fill(t);
        }
        let mut children = vec![Vec::new(); self.tasks.len()];
        // First block and first vector of the update of every task.
        let mut updates = Vec::with_capacity(self.tasks.len());
        for t in 0..self.tasks.len() {
            let beyond = self.beyond(t).len() as u32;
            updates.push((self.blocks_end, self.vectors_end));
            if let Some(&row) = self.beyond(t).first() {
                children[task_of[row as usize]].push(t);
            }
            self.blocks_end += beyond * (beyond + 1) / 2;
            self.vectors_end += beyond;
        }
        // Columns with a block in each row, increasing.
        let mut columns_of = vec![Vec::new(); self.len()];
        for (k, rows) in self.rows.iter().enumerate() {
            for &row in rows {
                columns_of[row as usize].push(k as u32);
            }
        }
        let (mut factor, mut forward, mut backward) =
            (Instructions::default(), Instructions::default(), Instructions::default());
        for (t, children) in children.iter().enumerate() {
            for instructions in [&mut factor, &mut forward, &mut backward] {
                instructions.starts.push(instructions.words.len() as u32);
            }
            let columns = self.tasks[t].clone();
            let (first_update, first_vector) = updates[t];
            factor.words.push(children.len() as u32);
            factor.words.extend(children.iter().map(|&child| child as u32));
            let task = Task {
                elimination: self,
                columns_of: &columns_of,
                columns: columns.clone(),
                children,
                updates: &updates,
            };
            for j in columns.clone() {
                task.factor(&mut factor.words, j, j, self.first_pivot + j, PIVOT);
                for &i in &self.rows[j as usize] {
                    task.factor(&mut factor.words, i, j, self.block(i, j).expect("a row of the column"), 0);
                }
                task.forward(&mut forward.words, j, self.first_vector + j, PIVOT);
            }
            for (a, &i) in self.beyond(t).iter().enumerate() {
                for (b, &j) in self.beyond(t)[..=a].iter().enumerate() {
                    task.factor(&mut factor.words, i, j, first_update + triangle(a, b), UPDATE);
                }
                task.forward(&mut forward.words, i, first_vector + a as u32, UPDATE);
            }
            for j in columns.rev() {
                let rows = &self.rows[j as usize];
                backward.words.extend([self.first_vector + j, self.first_pivot + j, rows.len() as u32]);
                for (k, &i) in rows.iter().enumerate() {
                    backward.words.extend([self.first_block[j as usize] + k as u32, self.first_vector + i]);
                }
            }
        }
        for instructions in [&mut factor, &mut forward, &mut backward] {
            instructions.starts.push(instructions.words.len() as u32);
        }
        (self.factor, self.forward, self.backward) = (factor, forward, backward);
    }
}

/// Index of (a, b), b ≤ a, in a triangle stored row by row.
fn triangle(a: usize, b: usize) -> u32 {
    (a * (a + 1) / 2 + b) as u32
}

/// A task whose instructions are being written.
struct Task<'e> {
    elimination: &'e Elimination,
    columns_of: &'e [Vec<u32>],
    columns: std::ops::Range<u32>,
    children: &'e [usize],
    updates: &'e [(u32, u32)],
}

impl Task<'_> {
    /// Columns of this task with a block in row j.
    fn columns_of(&self, j: u32) -> &[u32] {
        let all = &self.columns_of[j as usize];
        let at = |column: u32| all.partition_point(|&k| k < column);
        &all[at(self.columns.start)..at(self.columns.end)]
    }

    /// Encodes block (i, j): updates of the children, and products of columns of this task.
    fn factor(&self, words: &mut Vec<u32>, i: u32, j: u32, block: u32, flags: u32) {
        let mut adds = Vec::new();
        for &child in self.children {
            let beyond = self.elimination.beyond(child);
            if let (Ok(a), Ok(b)) = (beyond.binary_search(&i), beyond.binary_search(&j)) {
                adds.push(self.updates[child].0 + triangle(a, b));
            }
        }
        let mut products = Vec::new();
        for &k in self.columns_of(j) {
            if let (Some(ik), Some(jk)) = (self.elimination.block(i, k), self.elimination.block(j, k)) {
                products.extend([ik, jk, self.elimination.first_pivot + k]);
            }
        }
        words.extend([block, flags, adds.len() as u32, products.len() as u32 / 3]);
        words.extend(adds);
        words.extend(products);
    }

    /// Encodes an entry of a right-hand side.
    fn forward(&self, words: &mut Vec<u32>, j: u32, vector: u32, flags: u32) {
        let mut adds = Vec::new();
        for &child in self.children {
            if let Ok(b) = self.elimination.beyond(child).binary_search(&j) {
                adds.push(self.updates[child].1 + b as u32);
            }
        }
        let mut products = Vec::new();
        for &k in self.columns_of(j) {
            products.extend(
                self.elimination.block(j, k).into_iter().flat_map(|jk| [jk, self.elimination.first_vector + k]),
            );
        }
        words.extend([vector, flags, self.elimination.first_pivot + j, adds.len() as u32, products.len() as u32 / 2]);
        words.extend(adds);
        words.extend(products);
    }
}

/// Rows below the diagonal of every column of the factor, as positions in the order, increasing.
fn columns(graph: &[Vec<u32>], order: &[u32]) -> Vec<Vec<u32>> {
    let mut position = vec![0; order.len()];
    for (p, &v) in order.iter().enumerate() {
        position[v as usize] = p as u32;
    }
    let mut columns: Vec<Vec<u32>> = Vec::with_capacity(order.len());
    let mut children = vec![Vec::new(); order.len()];
    for (p, &v) in order.iter().enumerate() {
        let own = graph[v as usize].iter().map(|&w| position[w as usize]);
        let left = children[p].iter().flat_map(|&child: &usize| columns[child].iter().copied());
        let mut rows: Vec<u32> = own.chain(left).filter(|&row| row as usize > p).collect();
        rows.sort_unstable();
        rows.dedup();
        if let Some(&parent) = rows.first() {
            children[parent as usize].push(p);
        }
        columns.push(rows);
    }
    columns
}

/// Task of every column, and level of every task: a column continues the task of its only child.
fn tasks(columns: &[Vec<u32>]) -> (Vec<u32>, Vec<u32>) {
    let mut children = vec![Vec::new(); columns.len()];
    for (p, rows) in columns.iter().enumerate() {
        if let Some(&parent) = rows.first() {
            children[parent as usize].push(p);
        }
    }
    let (mut task_of, mut level): (Vec<u32>, Vec<u32>) = (Vec::with_capacity(columns.len()), vec![]);
    for children in &children {
        match children.as_slice() {
            [only] => task_of.push(task_of[*only]),
            children => {
                let above = children.iter().map(|&child: &usize| level[task_of[child] as usize] + 1).max();
                task_of.push(level.len() as u32);
                level.push(above.unwrap_or(0));
            }
        }
    }
    (task_of, level)
}
