//! The harness flat on a formboard, held by pegs.

use super::curve::Vector;
use super::findings::Findings;
use super::harness::{Harness, Place};
use super::tree::Tree;
use nalgebra::UnitQuaternion;
use std::collections::HashSet;
use wireloom_formboard as formboard;
use wireloom_formboard::{Options, Point};

/// Distance, m, of the board below the lowest point of the installed harness.
const BELOW: f64 = 0.3;

/// The flat harness.
pub(super) struct Board {
    flat: formboard::Board,
    /// Height of the board, m.
    height: f64,
    pub pegs: Vec<Peg>,
    /// Frames of the arms of every joint at rest.
    pub arms: Vec<Vec<UnitQuaternion<f64>>>,
    /// Positions of the vertices, m.
    pub points: Vec<Vector>,
}

/// Elastic support of a place of the harness on the board.
pub(super) struct Peg {
    pub name: String,
    pub at: Place,
    /// m.
    pub position: Vector,
}

impl Peg {
    /// N/m.
    pub const STIFFNESS: f64 = formboard::Peg::STIFFNESS;
}

/// The harness on the board, which lies below the vehicle, turned about the vertical to be as near as possible to the
/// installed harness.
pub(super) fn lay(harness: &Harness, tree: &Tree, memory: f64, findings: &mut Findings) -> Board {
    let own = of(harness, tree);
    let laid = formboard::lay(&own, &Options::default());
    // A board of its own size holds every harness, and an import without branches is refused before.
    let flat = laid.unwrap_or_else(|fault| unreachable!("{fault}"));
    note(harness, &flat, findings);
    let (turn, by) = beside_the_vehicle(harness, tree, &flat.points);
    let flat = flat.moved(turn, by);
    let lowest = tree.order.iter().map(|&v| harness.vertices[v].position.z).fold(f64::INFINITY, f64::min);
    let height = lowest - BELOW;
    let raised = |p: &Point| Vector::new(p.x, p.y, height);
    let points = flat.points.iter().map(raised).collect();
    let mut is_joint = vec![false; harness.vertices.len()];
    harness.joints.iter().for_each(|joint| is_joint[joint.vertex] = true);
    let roots: HashSet<usize> = tree.roots.iter().copied().collect();
    let held = |vertex: usize| !roots.contains(&vertex);
    let pegs = flat.pegs.iter().filter_map(|peg| {
        let at = match peg.at {
            formboard::Place::Vertex(vertex) if is_joint[vertex] => held(vertex).then_some(Place::Joint(vertex))?,
            formboard::Place::Vertex(vertex) => held(vertex).then_some(Place::End(vertex))?,
            formboard::Place::Along { branch, s } if !closes(&flat, branch) => Place::Along { branch, s },
            // What closes a loop hangs between its ends.
            formboard::Place::Along { .. } | formboard::Place::Cut(_) => return None,
        };
        Some(Peg { name: peg.name.clone(), at, position: raised(&peg.position) })
    });
    let (pegs, arms) = (pegs.collect(), flat.rest(&own, memory));
    Board { flat, height, pegs, arms, points }
}

fn closes(flat: &formboard::Board, branch: usize) -> bool {
    flat.cuts.iter().any(|cut| cut.branch == branch)
}

impl Board {
    /// Centre line of a branch. A branch that closes a loop runs straight between its ends.
    pub fn path(&self, harness: &Harness, branch: usize) -> Vec<Vector> {
        if closes(&self.flat, branch) {
            return harness.branches[branch].ends.map(|end| self.points[end]).to_vec();
        }
        self.flat.path(branch).iter().map(|p| Vector::new(p.x, p.y, self.height)).collect()
    }

    /// Frame of a branch at one of its ends: d3 `from → to`.
    pub fn frame(&self, harness: &Harness, branch: usize, vertex: usize) -> UnitQuaternion<f64> {
        let own = &harness.branches[branch];
        self.flat.frame(branch, if own.ends[0] == vertex { 0.0 } else { own.length })
    }
}

/// The harness for the layout.
fn of(harness: &Harness, tree: &Tree) -> formboard::Harness {
    let vertices = harness.vertices.iter().map(|v| formboard::Vertex { name: v.name.clone(), part: None });
    let branches = harness.branches.iter().map(|branch| formboard::Branch {
        name: branch.name.clone(),
        ends: branch.ends,
        length: branch.length,
        diameter: branch.diameter,
        min_bend_radius: Some(branch.min_bend_radius),
        linear_density: branch.linear_density,
        clips: Vec::new(),
    });
    let joints = harness.joints.iter().map(|joint| {
        let arms = joint.arms.iter().map(|arm| formboard::Arm { branch: arm.branch, orientation: arm.orientation });
        formboard::Joint { vertex: joint.vertex, arms: arms.collect() }
    });
    let (vertices, joints) = (vertices.collect(), joints.collect());
    let mut flat = formboard::Harness { vertices, branches: branches.collect(), joints, roots: tree.roots.clone() };
    for constraint in &harness.constraints {
        if let Place::Along { branch, s } = constraint.at {
            flat.branches[branch].clips.push(formboard::Clip { name: constraint.name.clone(), s });
        }
    }
    flat
}

fn note(harness: &Harness, flat: &formboard::Board, findings: &mut Findings) {
    for cut in &flat.cuts {
        let branch = &harness.branches[cut.branch];
        let apart = (flat.points[branch.ends[0]] - flat.points[branch.ends[1]]).norm();
        let what = if apart > branch.length {
            "branches close loops and cannot lie flat with their lengths; they start overstretched from end to end"
        } else {
            "branches close loops; on the board they lie slack between their ends"
        };
        findings.add_to(what, format!("`{}` ({:.0} mm over {:.0} mm)", branch.name, branch.length * 1e3, apart * 1e3));
    }
    for note in flat.notes.iter().skip(usize::from(!flat.cuts.is_empty())) {
        if note.items.is_empty() {
            findings.add(note.what.clone());
        }
        note.items.iter().for_each(|item| findings.add_to(note.what.clone(), item.clone()));
    }
}

/// The turn and the shift of the flat points to the least sum of squared horizontal distances from the installed
/// vertices (Kabsch 1976, in two dimensions: the angle is that of `Σ conj(p_i) q_i`).
fn beside_the_vehicle(harness: &Harness, tree: &Tree, flat: &[Point]) -> (f64, Point) {
    let count = tree.order.len().max(1) as f64;
    let installed = |vertex: usize| harness.vertices[vertex].position.xy();
    let centre = tree.order.iter().map(|&v| flat[v]).sum::<Point>() / count;
    let target = tree.order.iter().map(|&v| installed(v)).sum::<Point>() / count;
    let (mut cosine, mut sine) = (0.0, 0.0);
    for &v in &tree.order {
        let (p, q) = (flat[v] - centre, installed(v) - target);
        cosine += p.dot(&q);
        sine += p.perp(&q);
    }
    let turn = sine.atan2(cosine);
    (turn, target - nalgebra::Rotation2::new(turn) * centre)
}
