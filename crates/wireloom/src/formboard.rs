//! The harness of a scenario on a formboard: its layout, its drawings, and a scenario of the harness built flat.
//!
//! ```
//! use wireloom::formboard::{Wishes, drawing, formboard};
//! use wireloom::scenario::NoFiles;
//!
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?;
//! let registry = wireloom::registry();
//! let made = formboard(&text, &NoFiles, &registry, &Wishes::default()).expect("it fits on a board of its own size");
//! assert_eq!(made.board.lines.len(), made.harness.branches.len());
//! let mut picture = Vec::new();
//! drawing::svg(&made.drawing(&[]), &mut picture)?;
//! // Flat, at rest, and held by pegs alone.
//! wireloom::load(&made.scenario, &registry).expect("a scenario without faults");
//! # Ok::<(), std::io::Error>(())
//! ```

pub use wireloom_formboard::{
    Board, Cut, Error, Harness, Holds, Line, Note, Options, Peg, Place, Point, SHEET, drawing,
};

use drawing::{Drawing, Table};
use std::collections::{HashMap, HashSet};
use wireloom_core::load::LoadAction;
use wireloom_core::{Registry, Rotation, Vector};
use wireloom_formboard::{Arm, Branch, Clip, Joint, Vertex, lay};
use wireloom_scenario::flat::{Flat, FlatBranch, FlatJoint, FlatLoad, Held, Hold, on_board};
use wireloom_scenario::record::{self, Attachment};
use wireloom_scenario::{At, Fault, Files, Load, Scenario, SectionPart};

/// Wishes for a formboard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wishes {
    /// Size of the board, and distances on it.
    pub board: Options,
    /// Which part of the angles and bends of the board the harness keeps when it is taken off, 0 to 1: 1 if it is built
    /// there and at rest, 0 if it keeps those of the scenario.
    pub memory: f64,
}

impl Default for Wishes {
    fn default() -> Self {
        Self { board: Options::default(), memory: 1.0 }
    }
}

/// A formboard.
#[derive(Clone, Debug)]
pub struct Formboard {
    /// Name of the scenario.
    pub name: String,
    /// The harness, as it is laid.
    pub harness: Harness,
    /// The board.
    pub board: Board,
    /// A scenario of the harness on the board.
    pub scenario: String,
    /// What users should know: of the board, and of what its scenario leaves out.
    pub notes: Vec<Note>,
}

/// A formboard that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum NoFormboard {
    /// The scenario has faults, or parts that cannot be laid flat.
    #[error("the scenario has {} faults", .0.len())]
    Faults(Vec<Fault>),
    /// The harness cannot be laid.
    #[error(transparent)]
    Board(#[from] Error),
    /// The memory is none.
    #[error("the memory must be between 0 (as in the scenario) and 1 (as on the board), not {found}")]
    Memory {
        /// As given.
        found: f64,
    },
}

impl Formboard {
    /// For the writers of [`drawing`].
    pub fn drawing<'a>(&'a self, tables: &'a [Table]) -> Drawing<'a> {
        Drawing { title: &self.name, harness: &self.harness, board: &self.board, tables }
    }
}

/// Lays the harness of a scenario on a board; `files`: the files that the text names.
///
/// # Errors
/// See [`NoFormboard`].
pub fn formboard(
    text: &str,
    files: &dyn Files,
    registry: &Registry,
    wishes: &Wishes,
) -> Result<Formboard, NoFormboard> {
    if !(0.0..=1.0).contains(&wishes.memory) {
        return Err(NoFormboard::Memory { found: wishes.memory });
    }
    let (scenario, _) = crate::load_with_files(text, files, registry).map_err(NoFormboard::Faults)?;
    let offsets = offsets(&scenario);
    if !offsets.is_empty() {
        return Err(NoFormboard::Faults(offsets));
    }
    let harness = harness_of(&scenario);
    let board = lay(&harness, &wishes.board)?;
    let flat = Flattened { scenario: &scenario, harness: &harness, board: &board, memory: wishes.memory };
    let (loads, lost) = flat.loads();
    let (scenario_text, left_out) =
        on_board(text, &flat.flat(loads)).map_err(|fault| NoFormboard::Faults(vec![fault]))?;
    let mut notes = board.notes.clone();
    let mut note = |what: &str, items: Vec<String>| {
        if !items.is_empty() {
            notes.push(Note { what: what.to_owned(), items });
        }
    };
    note("the scenario on the board leaves out", left_out.iter().map(|key| format!("`{key}`")).collect());
    note("loads that are no weights are left out", lost);
    Ok(Formboard { name: scenario.name.clone(), harness, board, scenario: scenario_text, notes })
}

/// Joints with a body: the layout takes joints for points.
fn offsets(scenario: &Scenario) -> Vec<Fault> {
    let bodies = scenario.joints.iter().filter(|joint| joint.arms.iter().any(|arm| arm.offset != Vector::zeros()));
    let fault = |joint: &wireloom_scenario::Joint| Fault {
        span: joint.spans.of(Some("offset")),
        message: format!("joint \"{}\" has arms with `offset`; a formboard takes joints for points", joint.name),
        help: "leave `offset` out, and add it to the lengths of the branches".to_owned(),
    };
    bodies.map(fault).collect()
}

/// The harness for the layout.
fn harness_of(scenario: &Scenario) -> Harness {
    let mut index: HashMap<&str, usize> = HashMap::new();
    let mut vertices: Vec<Vertex> = Vec::new();
    for name in scenario.branches.iter().flat_map(|branch| &branch.vertices) {
        index.entry(name).or_insert_with(|| {
            vertices.push(Vertex { name: name.clone(), part: None });
            vertices.len() - 1
        });
    }
    let mut branches: Vec<Branch> = scenario
        .branches
        .iter()
        .map(|branch| {
            let sections = branch.section_spans();
            let own = || sections.iter().map(|span| &scenario.sections[span.section]);
            let mass =
                |span: &SectionPart| scenario.sections[span.section].linear_density * (span.range[1] - span.range[0]);
            Branch {
                name: branch.name.clone(),
                ends: [0, 1].map(|end| index[branch.vertices[end].as_str()]),
                length: branch.length,
                diameter: scenario.diameter(branch),
                min_bend_radius: own().filter_map(|section| section.min_bend_radius).reduce(f64::max),
                linear_density: sections.iter().map(mass).sum::<f64>() / branch.length,
                clips: Vec::new(),
            }
        })
        .collect();
    let joints = scenario.joints.iter().map(|joint| {
        let arms = joint.arms.iter().map(|arm| Arm { branch: arm.branch, orientation: arm.rest });
        Joint { vertex: index[joint.name.as_str()], arms: arms.collect() }
    });
    let joints: Vec<Joint> = joints.collect();
    // The first constraint at a place gives its name: later ones are other steps of the same installation.
    for constraint in &scenario.constraints {
        for place in constraint.at.iter().copied() {
            let At::Branch { branch, s } = place else { continue };
            let own = &mut branches[branch];
            let end = [0.0, own.length].iter().position(|&end| s == end);
            match end {
                Some(end) => {
                    let vertex = own.ends[end];
                    let free = joints.iter().all(|joint| joint.vertex != vertex);
                    if free && constraint.kind == "connector" && vertices[vertex].part.is_none() {
                        vertices[vertex].part = Some(constraint.name.clone());
                    }
                }
                None if constraint.kind == "collar" && own.clips.iter().all(|clip| (clip.s - s).abs() > 1e-6) => {
                    own.clips.push(Clip { name: constraint.name.clone(), s });
                }
                None => {}
            }
        }
    }
    let roots = roots(&vertices, &branches);
    Harness { vertices, branches, joints, roots }
}

/// Ends, those with a connector on the heaviest branch first: there most of the wires end.
fn roots(vertices: &[Vertex], branches: &[Branch]) -> Vec<usize> {
    let mut arms: Vec<Vec<usize>> = vec![Vec::new(); vertices.len()];
    for (k, branch) in branches.iter().enumerate() {
        branch.ends.iter().for_each(|&end| arms[end].push(k));
    }
    let mut ends: Vec<usize> = (0..vertices.len()).filter(|&vertex| arms[vertex].len() == 1).collect();
    let weight = |vertex: usize| branches[arms[vertex][0]].linear_density;
    ends.sort_by(|&a, &b| {
        let connector = |vertex: usize| vertices[vertex].part.is_some();
        connector(b).cmp(&connector(a)).then(weight(b).total_cmp(&weight(a)))
    });
    ends
}

/// A scenario on its board.
struct Flattened<'a> {
    scenario: &'a Scenario,
    harness: &'a Harness,
    board: &'a Board,
    memory: f64,
}

impl Flattened<'_> {
    /// What is written.
    fn flat(&self, loads: Vec<FlatLoad>) -> Flat {
        let gravity = self.scenario.gravity.norm();
        Flat {
            name: format!("{}, on the board", self.scenario.name),
            gravity: [0.0, 0.0, if gravity > 0.0 { -gravity } else { 0.0 }],
            branches: (0..self.harness.branches.len()).map(|k| self.branch(k)).collect(),
            joints: self.joints(),
            loads,
            held: self.held(),
            markers: self.board.cuts.is_empty(),
        }
    }

    fn is_cut(&self, branch: usize) -> bool {
        self.board.cuts.iter().any(|cut| cut.branch == branch)
    }

    /// Name of the vertex where a branch ends on the board: one that is cut has an end of its own.
    fn end(&self, branch: usize) -> String {
        let own = &self.harness.branches[branch];
        let name = &self.harness.vertices[own.ends[1]].name;
        if !self.is_cut(branch) {
            return name.clone();
        }
        let mut cut = format!("{name} ({})", own.name);
        while self.harness.vertices.iter().any(|vertex| vertex.name == cut) {
            cut.push('\'');
        }
        cut
    }

    fn branch(&self, k: usize) -> FlatBranch {
        let curvature =
            self.board.curvature(k) * self.memory + self.scenario.branches[k].curvature * (1.0 - self.memory);
        FlatBranch {
            name: self.harness.branches[k].name.clone(),
            to: self.end(k),
            path: self.board.path(k).iter().map(|p| [p.x, p.y, 0.0]).collect(),
            // Round-off of the frames is no curvature.
            curvature: curvature.map(|x| if x.abs() < 1e-9 { 0.0 } else { x }).into(),
        }
    }

    /// Whether an arm of a joint is there on the board.
    fn stays(&self, joint: &Joint, arm: &Arm) -> bool {
        !self.is_cut(arm.branch) || self.harness.branches[arm.branch].ends[0] == joint.vertex
    }

    /// Whether a joint is one on the board: one whose other arms are cut is an end there.
    fn is_joint(&self, joint: &Joint) -> bool {
        joint.arms.iter().filter(|arm| self.stays(joint, arm)).count() > 1
    }

    fn joints(&self) -> Vec<FlatJoint> {
        let rest = self.board.rest(self.harness, self.memory);
        let all = self.harness.joints.iter().zip(rest).filter(|(joint, _)| self.is_joint(joint));
        let all = all.map(|(joint, rest)| {
            let arms = joint.arms.iter().zip(rest).filter(|(arm, _)| self.stays(joint, arm));
            let named =
                |(arm, rest): (&Arm, Rotation)| (self.harness.branches[arm.branch].name.clone(), quaternion(&rest));
            FlatJoint { name: self.harness.vertices[joint.vertex].name.clone(), arms: arms.map(named).collect() }
        });
        all.collect()
    }

    /// Pegs, and at the root of each piece a support that holds the whole pose.
    fn held(&self) -> Vec<Held> {
        let joints = self.harness.joints.iter().filter(|joint| self.is_joint(joint));
        let joints: HashSet<usize> = joints.map(|joint| joint.vertex).collect();
        let roots: HashSet<usize> = self.board.roots.iter().copied().collect();
        let held = |peg: &Peg| {
            let (at, how) = match peg.at {
                Place::Vertex(vertex) => {
                    let name = self.harness.vertices[vertex].name.clone();
                    let is_joint = joints.contains(&vertex);
                    let at = if is_joint { Attachment::Joint(name) } else { Attachment::End(name) };
                    let how = match roots.contains(&vertex) {
                        false => Hold::Spring(Peg::STIFFNESS),
                        true if is_joint => Hold::Position,
                        true => self.pose(vertex),
                    };
                    (at, how)
                }
                Place::Cut(branch) => (Attachment::End(self.end(branch)), Hold::Spring(Peg::STIFFNESS)),
                Place::Along { branch, s } => {
                    let name = self.harness.branches[branch].name.clone();
                    (Attachment::Branch(name, s), Hold::Spring(Peg::STIFFNESS))
                }
            };
            // What holds the whole pose is no peg.
            let root = matches!(how, Hold::Position | Hold::Pose(..));
            let name = if root { format!("root, {}", peg.name) } else { peg.name.clone() };
            Held { name, at, position: [peg.position.x, peg.position.y, 0.0], how }
        };
        self.board.pegs.iter().map(held).collect()
    }

    /// The pose of the only branch at an end.
    fn pose(&self, vertex: usize) -> Hold {
        let found = self.harness.branches.iter().enumerate().find_map(|(k, branch)| {
            let end = branch.ends.iter().position(|&end| end == vertex)?;
            (end == 0 || !self.is_cut(k)).then(|| self.board.frame(k, if end == 0 { 0.0 } else { branch.length }))
        });
        let frame = found.unwrap_or_default();
        Hold::Pose((frame * Vector::z()).into(), (frame * Vector::x()).into())
    }

    /// Loads that stay: weights, which pull as gravity does; and the names of the others.
    fn loads(&self) -> (Vec<FlatLoad>, Vec<String>) {
        let (mut weights, mut others) = (Vec::new(), Vec::new());
        let down = self.scenario.gravity.try_normalize(0.0);
        for load in &self.scenario.loads {
            let force = match &load.action {
                LoadAction::At { load, .. } => load.dead_force(),
                LoadAction::Along { load, .. } => load.dead_force(),
            };
            let force = load.action.without_potential().is_none().then_some(force);
            let pull = force.zip(down).and_then(|(force, down)| {
                let pull = force.dot(&down);
                ((force - down * pull).norm() <= 1e-9 * force.norm() && load.factor * pull > 0.0).then_some(pull)
            });
            match pull {
                Some(pull) => {
                    weights.push(FlatLoad { name: load.name.clone(), at: self.moved(load), force: [0.0, 0.0, -pull] });
                }
                None => others.push(format!("`{}`", load.name)),
            }
        }
        (weights, others)
    }

    /// Where a load at a joint acts that is an end on the board.
    fn moved(&self, load: &Load) -> Option<Attachment> {
        let LoadAction::At { place: At::Joint(joint), .. } = load.action else { return None };
        let joint = &self.harness.joints[joint];
        (!self.is_joint(joint)).then(|| Attachment::End(self.harness.vertices[joint.vertex].name.clone()))
    }
}

/// `[w, x, y, z]` with w ≥ 0.
fn quaternion(q: &Rotation) -> [f64; 4] {
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [q.w, q.i, q.j, q.k].map(|c| sign * c)
}

/// Types of wires with the length that the harness needs of each, from the `wires` of sections; a row in the end names
/// the sections that have none.
///
/// # Errors
/// If the text is not TOML.
pub fn wire_types(text: &str, scenario: &Scenario) -> Result<Table, Fault> {
    let sections = record::value_at(text, "sections")?;
    let mut table = Table::new("Wires by type", &["type", ">wires, at most", ">length in all [m]"]);
    let mut types: Vec<(String, u64, f64)> = Vec::new();
    let mut bare: Vec<&str> = Vec::new();
    let spans = scenario.branches.iter().flat_map(wireloom_scenario::Branch::section_spans);
    for SectionPart { section, range: [from, to] } in spans {
        let section = &scenario.sections[section].name;
        let wires = sections.get(section).and_then(|own| own.get("wires")).and_then(|wires| wires.as_array());
        let Some(wires) = wires else {
            if !bare.contains(&section.as_str()) {
                bare.push(section);
            }
            continue;
        };
        let mut here: HashMap<&str, u64> = HashMap::new();
        for wire in wires {
            let name = wire.get("type").and_then(|own| own.as_str()).unwrap_or_default();
            *here.entry(name).or_default() += wire.get("count").and_then(|own| own.as_u64()).unwrap_or(1);
        }
        for (name, count) in here {
            let known = types.iter_mut().find(|(own, ..)| own == name);
            let length = count as f64 * (to - from);
            match known {
                Some((_, most, sum)) => (*most, *sum) = ((*most).max(count), *sum + length),
                None => types.push((name.to_owned(), count, length)),
            }
        }
    }
    types.sort_by(|a, b| a.0.cmp(&b.0));
    for (name, most, length) in types {
        table.rows.push(vec![name, most.to_string(), format!("{length:.2}")]);
    }
    if !bare.is_empty() {
        table.rows.push(vec![format!("sections without `wires`: {}", bare.join(", ")), String::new(), String::new()]);
    }
    Ok(table)
}
