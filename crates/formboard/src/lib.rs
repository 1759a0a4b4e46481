//! The harness flat on a formboard: layout, pegs, drawings.
//!
//! [`lay`] turns a harness into a [`Board`]: every branch with its true length, at the angles between them that fit
//! into a plane, such that no branches cross or come nearer to each other than their radii and a gap allow.
//!
//! ```
//! use wireloom_formboard::{Arm, Branch, Harness, Joint, Options, Rotation, Vector, Vertex, lay};
//!
//! let vertex = |name: &str| Vertex { name: name.to_owned(), part: None };
//! let branch = |name: &str, ends: [usize; 2], length: f64| Branch {
//!     name: name.to_owned(),
//!     ends,
//!     length,
//!     diameter: 0.008,
//!     min_bend_radius: None,
//!     linear_density: 0.1,
//!     clips: Vec::new(),
//! };
//! // Three arms of a fork; each branch begins at the fork, vertex 0, and leaves it along its d3.
//! let along = |x: f64, y: f64| Rotation::face_towards(&Vector::new(x, y, 0.0), &Vector::z());
//! let arms = [along(-1.0, 0.0), along(1.0, 0.5), along(1.0, -0.5)];
//! let harness = Harness {
//!     vertices: ["J", "A", "B", "C"].map(vertex).to_vec(),
//!     branches: vec![branch("a", [0, 1], 0.6), branch("b", [0, 2], 0.4), branch("c", [0, 3], 0.3)],
//!     joints: vec![Joint {
//!         vertex: 0,
//!         arms: arms.iter().enumerate().map(|(branch, &orientation)| Arm { branch, orientation }).collect(),
//!     }],
//!     roots: vec![1],
//! };
//! let board = lay(&harness, &Options::default()).expect("it fits on a board of its own size");
//! assert!((board.lines[1].end() - board.lines[1].start).norm() - 0.4 < 1e-12);
//! ```
//!
//! | file | contents |
//! | --- | --- |
//! | `unfold` | the start of the layout: straight branches, no crossings, trunk straight |
//! | `clearance` | what may be how near to what |
//! | `tree`, `search` | the layout as a tree that is turned branch by branch; the objective and its minimisation |
//! | `layout` | pieces, loops, boards of a given size |
//! | `flat` | joints flattened, frames of the branches on the board |
//! | `pegs` | what holds the harness |
//! | `drawing` | SVG, DXF and PDF |
//!
//! **Objective.** Clearance and the size of a given board are kept in any case. Then: trunk straight (the longest way
//! through the harness; it turns only on a board that is shorter), few bends (none, unless such a board asks for them),
//! little area, angles between branches near the drawn ones. Directions are multiples of 5°.
//!
//! **Clearance.** Two centre lines are at least the sum of their radii and the gap apart, D in short. At a fork they
//! cannot be: places may be nearer whose way along the harness is at most [`Board::zone`] times D, 8 if the search
//! finds such a layout. Two arms of a vertex make 15° or more, with very many arms half of what they have evenly.
//! Centre lines never cross.
//!
//! **Loops** are cut open: the branch that closes one is laid from its first vertex, and ends free.

mod board;
mod clearance;
#[cfg(feature = "drawings")]
pub mod drawing;
mod flat;
mod harness;
mod layout;
mod line;
mod pegs;
mod search;
mod tree;
mod unfold;

pub use board::{Board, Cut, Error, Note, Options, SHEET, lay};
pub use harness::{Arm, Branch, Clip, Harness, Joint, Place, Vertex};
pub use line::{Line, Point};
pub use pegs::{Holds, Peg};

/// A vector, m.
pub type Vector = nalgebra::Vector3<f64>;
/// A frame: columns d1, d2, d3.
pub type Rotation = nalgebra::UnitQuaternion<f64>;
