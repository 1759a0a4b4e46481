//! What is laid on the board.

use crate::Rotation;

/// A harness. SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Harness {
    /// Where branches meet or end.
    pub vertices: Vec<Vertex>,
    /// The branches.
    pub branches: Vec<Branch>,
    /// A joint for every vertex with several branches.
    pub joints: Vec<Joint>,
    /// Vertices from which frames are carried outward, the preferred ones first. A piece without any of them has its
    /// first vertex.
    pub roots: Vec<usize>,
}

/// A vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Vertex {
    /// Its name.
    pub name: String,
    /// What is mounted there: a connector.
    pub part: Option<String>,
}

impl Vertex {
    /// What is written beside it.
    pub fn label(&self) -> &str {
        self.part.as_deref().unwrap_or(&self.name)
    }
}

/// A branch.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Its name.
    pub name: String,
    /// Indices of the vertices where it begins and ends; two different ones.
    pub ends: [usize; 2],
    /// m; above zero.
    pub length: f64,
    /// m.
    pub diameter: f64,
    /// m; `None`: four diameters.
    pub min_bend_radius: Option<f64>,
    /// kg/m.
    pub linear_density: f64,
    /// What is mounted along it.
    pub clips: Vec<Clip>,
}

/// A clip or another fixing along a branch.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Its name.
    pub name: String,
    /// Arc length, m.
    pub s: f64,
}

/// A joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Index of its vertex.
    pub vertex: usize,
    /// All branches that end there.
    pub arms: Vec<Arm>,
}

/// An arm of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    /// Index of the branch.
    pub branch: usize,
    /// Frame of the branch there (d3 from its first to its second vertex), in axes that are the same for all arms.
    pub orientation: Rotation,
}

/// A place on the harness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// A vertex, by index.
    Vertex(usize),
    /// The second end of a branch that closes a loop and is cut there, by index of the branch.
    Cut(usize),
    /// A place along a branch, by index, at an arc length, m.
    Along {
        /// The branch.
        branch: usize,
        /// m.
        s: f64,
    },
}

/// Ways through the harness from a root of each piece to all its vertices, in branches.
pub(crate) struct Ways {
    /// Vertices, each after the one before it.
    pub order: Vec<usize>,
    /// Branch and vertex by which each vertex is reached; `None` for roots.
    pub before: Vec<Option<(usize, usize)>>,
}

impl Harness {
    /// The ways through branches that are not `cut`.
    pub(crate) fn ways(&self, cut: &[usize]) -> Ways {
        let n = self.vertices.len();
        let mut at: Vec<Vec<usize>> = vec![Vec::new(); n];
        for (k, branch) in self.branches.iter().enumerate().filter(|(k, _)| !cut.contains(k)) {
            branch.ends.iter().for_each(|&end| at[end].push(k));
        }
        let mut ways = Ways { order: Vec::new(), before: vec![None; n] };
        let mut seen = vec![false; n];
        for root in self.roots.iter().copied().chain(0..n) {
            if std::mem::replace(&mut seen[root], true) {
                continue;
            }
            let mut next = ways.order.len();
            ways.order.push(root);
            while let Some(&vertex) = ways.order.get(next) {
                next += 1;
                for &k in &at[vertex] {
                    let [a, b] = self.branches[k].ends;
                    let other = if a == vertex { b } else { a };
                    if !std::mem::replace(&mut seen[other], true) {
                        ways.before[other] = Some((k, vertex));
                        ways.order.push(other);
                    }
                }
            }
        }
        ways
    }
}
