//! Protocol between page and server. Text frames of the WebSocket are JSON: [`Request`] to the server, [`Notice`] to
//! the page. Binary frames are shapes ([`crate::frame`]). A test generates `web/src/protocol.ts` from these types.
//!
//! Lengths m, forces N, moments N m, times s; orientations `[w, x, y, z]`. Frames are numbered from 0, the initial
//! equilibrium; every increment has one. Operations start at the end of a step, so that they can be recorded as further
//! steps.

mod start;

pub use start::{
    Arranged, Contents, Example, Finding, FindingItem, ImportFile, Imported, Module, NotOpened, OfferedDraft, Opening,
    Recent, StartPage, Used,
};

use serde::{Deserialize, Serialize};
#[cfg(test)]
use ts_rs::TS;

/// Requests of a page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "do", rename_all = "snake_case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// Adds a constraint at the current pose: a handle, a pin or a clip. The tab then holds a handle (see `target`).
    Hold {
        /// Name of the branch.
        branch: String,
        /// Arc length, m; the nearest node is taken.
        s: f64,
        /// Kind of the new constraint.
        how: Holding,
    },
    /// Moves a constraint. Only the newest target counts; the targets of one drag (until `drop`) are increments of one
    /// step.
    Target {
        /// Name of the constraint.
        constraint: String,
        /// Target position, m.
        position: Option<[f64; 3]>,
        /// Target orientation, `[w, x, y, z]`: columns d1, d2, d3.
        orientation: Option<[f64; 4]>,
    },
    /// Ends a drag: the step is complete, the constraint stays where it is.
    Drop {
        /// Name of the constraint.
        constraint: String,
    },
    /// Releases a constraint.
    Release {
        /// Name of the constraint.
        constraint: String,
    },
    /// Fixes position, tangent and twist of a constraint at their current values.
    Pin {
        /// Name of the constraint.
        constraint: String,
    },
    /// Drives a joint of a mechanism to a value, in a step of its own.
    Drive {
        /// Name of the joint in the scene.
        joint: String,
        /// Its value, rad or m.
        value: f64,
    },
    /// Asks what it does to the requirements to move a constraint from where it is.
    Sensitivities {
        /// Name of the constraint.
        constraint: String,
    },
    /// Undoes the last operation.
    Undo,
    /// Redoes the operation that was undone last.
    Redo,
    /// Goes back to the end of the step of this frame; later steps are removed from the timeline (`undo` restores
    /// them).
    Go {
        /// Number of the frame.
        frame: u32,
    },
    /// Changes a setting of the scenario: a joint model, a rod, the minimiser, a number of a section.
    Set {
        /// The key of one of the scene's settings, such as `joints.J.model`.
        key: String,
        /// The value as in a scenario: a number in SI units, a word, true or false.
        #[cfg_attr(test, ts(type = "unknown"))]
        value: serde_json::Value,
    },
    /// Stops the computation: the remaining steps of the scenario are not computed.
    Stop,
    /// Requests frames that this page does not have.
    Frames {
        /// First.
        from: u32,
        /// One beyond the last; the server may send fewer.
        to: u32,
    },
    /// Requests a copy of the current scenario, including recorded steps.
    Save,
    /// Writes the current scenario into its file, or into another one of the same folder, which then is its file.
    Store {
        /// Name of the other file; none: its own.
        name: Option<String>,
        /// Whether to replace what another program has written there.
        replace: bool,
    },
    /// Reads the scenario's file anew, in place of the current text.
    Reload,
    /// Changes the scenario.
    Edit {
        /// The change.
        edit: Edit,
    },
    /// Replaces the text of the scenario.
    Apply {
        /// The new text.
        text: String,
        /// Version of the document that it was made from.
        base: u32,
    },
    /// Checks a text, without a change of the session.
    Check {
        /// The text.
        text: String,
        /// A number for the answer.
        number: u32,
    },
    /// Accepts or discards a draft of an earlier session.
    Draft {
        /// Its number.
        number: u32,
        /// Whether to accept it.
        take: bool,
    },
    /// Opens a session; only from the start page, as long as there is none.
    Open {
        /// The scenario.
        what: Opening,
    },
    /// Asks for the modules and variants of a KBL file; only from the start page.
    Contents {
        /// The file.
        file: ImportFile,
    },
}

/// A change of the scenario's text, which the session then carries out anew from the first step that differs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "is", rename_all = "snake_case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub enum Edit {
    /// Gives a key another value.
    Put {
        /// Path to the key, such as `branches.trunk.length`.
        key: String,
        /// The value as the file shall have it: a number in SI units, a string with a unit, a list.
        #[cfg_attr(test, ts(type = "unknown"))]
        value: serde_json::Value,
    },
    /// Removes a key.
    Remove {
        /// Path to the key.
        key: String,
    },
    /// Adds an entry to a list.
    Add {
        /// The list.
        list: List,
        /// The entry, as the file shall have it.
        #[cfg_attr(test, ts(type = "unknown"))]
        entry: serde_json::Value,
    },
    /// Renames a part, everywhere.
    Rename {
        /// Kind of the part.
        part: PartKind,
        /// Its name.
        name: String,
        /// Its new name.
        to: String,
    },
    /// Deletes a part, with what is of no use without it.
    Delete {
        /// Kind of the part.
        part: PartKind,
        /// Its name.
        name: String,
    },
    /// Moves and turns an obstacle.
    Move {
        /// Its name.
        obstacle: String,
        /// Its pose in some frame.
        from: Placed,
        /// Where it shall be instead in that frame.
        to: Placed,
    },
    /// Deletes several parts as one command.
    DeleteAll {
        /// Kinds and names of the parts.
        parts: Vec<(PartKind, String)>,
    },
    /// Splits a branch into two that meet in a joint.
    Split {
        /// Name of the branch.
        branch: String,
        /// Arc length of the joint, m.
        s: f64,
    },
    /// Adds a branch with a free end.
    Branch {
        /// Its name.
        name: String,
        /// Where it begins.
        from: Start,
        /// Name of its section.
        section: String,
        /// Its length as the file shall have it.
        #[cfg_attr(test, ts(type = "unknown"))]
        length: serde_json::Value,
    },
}

/// A pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Placed {
    /// Position, m.
    pub position: [f64; 3],
    /// Orientation `[w, x, y, z]`.
    pub orientation: [f64; 4],
}

/// A list of the scenario to which entries can be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub enum List {
    /// Constraints that act from the start.
    Constraints,
    /// Obstacles.
    Obstacles,
    /// Requirements.
    Requirements,
}

/// Answer to a file with a surface that a page has sent to `surroundings/NAME`: it can be the `mesh` of an obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct StoredMesh {
    /// Its name beside the scenario's file.
    pub file: String,
    /// Whether its surface has borders, so that the obstacle needs `open = true`.
    pub open: bool,
}

/// A kind of parts that a page renames and deletes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub enum PartKind {
    /// A branch.
    Branch,
    /// A constraint.
    Constraint,
    /// An obstacle.
    Obstacle,
    /// A requirement.
    Requirement,
}

/// Where a new branch begins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub enum Start {
    /// At a joint.
    Joint(String),
    /// At a free end, which becomes a joint.
    End(String),
    /// At a point of a branch, which is split there.
    Point {
        /// Name of the branch.
        branch: String,
        /// Arc length, m.
        s: f64,
    },
}

/// Kind of a constraint that a page adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub enum Holding {
    /// Handle: holds the point.
    Handle,
    /// Pin: holds position, tangent and twist.
    Pin,
    /// Clip: holds position and tangent.
    Collar,
}

/// Notices of the server.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "is", rename_all = "snake_case", rename_all_fields = "snake_case")]
pub enum Notice {
    /// The harness: sent first, and after every change of it. Frames of another `run` are invalid.
    Scene(Scene),
    /// The current timeline; a page drops frames beyond it.
    Timeline(Timeline),
    /// The sheet of requirements so far.
    Sheet(Sheet),
    /// What it does to the requirements to move a constraint.
    Sensitivities(Sensitivities),
    /// State of the session.
    Session(Session),
    /// A request could not be fulfilled.
    Refused {
        /// The reason.
        message: String,
        /// A hint.
        help: String,
    },
    /// Drafts of earlier sessions; none if there is no such draft any more.
    Drafts {
        /// The drafts, the newest first.
        drafts: Vec<OfferedDraft>,
    },
    /// A copy of the current scenario.
    Saved {
        /// Name for the file.
        name: String,
        /// Its text.
        text: String,
    },
    /// The text of the scenario: sent first, and after every change of it.
    Document(Document),
    /// The answer to `check`, and the faults of a text that was to be applied.
    Checked {
        /// Number of the check; none: of a text that was to be applied.
        number: Option<u32>,
        /// Its faults; none if it is valid.
        faults: Vec<TextFault>,
    },
    /// The current scenario has been written into its file.
    Stored {
        /// Name of the file.
        name: String,
    },
    /// The current scenario was not written, because that would replace what is there.
    Conflict {
        /// Name of the file.
        name: String,
        /// Whether it is the scenario's own file, which another program has changed; otherwise there is another file of
        /// the name wanted.
        own: bool,
    },
    /// Another program has changed the scenario's file.
    Outside {
        /// Name of the file.
        name: String,
    },
    /// There is no session yet: what can be opened.
    StartPage(StartPage),
    /// Modules and variants of a KBL file.
    Contents(Contents),
    /// Nothing was opened.
    NotOpened(NotOpened),
    /// A finished run was opened: the page is to be loaded anew.
    Replay,
    /// The session's scenario was imported: what was found.
    Imported(Imported),
}

/// The text of a scenario, and what a page needs to edit it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Document {
    /// Version: grows with every change of the text.
    pub version: u32,
    /// Name of the file.
    pub name: String,
    /// Whether the session can write into that file.
    pub can_store: bool,
    /// Whether there is no such file yet: saving asks for its name.
    pub is_new: bool,
    /// The text.
    pub text: String,
    /// The same as JSON, with every value as it is written.
    #[cfg_attr(test, ts(type = "Record<string, unknown>"))]
    pub entries: serde_json::Value,
    /// Kinds of constraints, each with a one-line description.
    pub constraint_kinds: Vec<(String, String)>,
    /// Words of the quantities that a requirement may limit.
    pub quantities: Vec<String>,
}

/// A fault of a text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct TextFault {
    /// Where it begins: UTF-16 code units from the beginning of the text.
    pub from: u32,
    /// Where it ends.
    pub to: u32,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// The fault, with the offending value.
    pub message: String,
    /// What would be right.
    pub help: String,
}

/// A harness and its surroundings, without positions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Scene {
    /// Name of the scenario.
    pub name: String,
    /// Name and version of the program.
    pub program: String,
    /// Whether there is a solver; otherwise this is a finished run.
    pub live: bool,
    /// Number of the run. While it stays the same, frames of an earlier scene remain valid, for example after a grab.
    pub run: u32,
    /// Gravity, m/s².
    pub gravity: [f64; 3],
    /// Branches, in the order of the frames.
    pub branches: Vec<Branch>,
    /// Joints, in the order of the frames.
    pub joints: Vec<Joint>,
    /// All constraints. Frames name the active ones.
    pub constraints: Vec<Constraint>,
    /// Obstacles, in the order of the frames.
    pub obstacles: Vec<Obstacle>,
    /// Joints of mechanisms with one freedom, in the order of the frames.
    pub mechanism_joints: Vec<MechanismJoint>,
    /// Settings, in display order.
    pub settings: Vec<Setting>,
    /// Notes for the engineer.
    pub notes: Vec<String>,
    /// Names of files under `export/`: `result.json`, `picture.svg` and others.
    pub exports: Vec<String>,
    /// Whether there is a tolerance envelope, at `envelope` ([`crate::envelope`]).
    pub envelope: bool,
}

/// A branch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Branch {
    /// Name.
    pub name: String,
    /// Diameter, m.
    pub diameter: f64,
    /// Smallest allowed bend radius, m.
    pub bend_radius_limit: Option<f64>,
    /// Its parts with sections of their own, in the order of arc length; empty where its section does not change.
    /// Diameter and limit above are then the greatest ones.
    pub sections: Vec<SectionPart>,
    /// Number of nodes.
    pub nodes: u32,
    /// Unstressed length, m.
    pub length: f64,
    /// Part number, description, supplier and colour in words.
    pub identity: Option<String>,
    /// Drawn centre line, m: x, y, z of each point; empty where none is drawn.
    pub drawn: Vec<f32>,
}

/// A part of a branch with a section of its own; it begins where the one before it ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct SectionPart {
    /// Name of the section.
    pub section: String,
    /// Arc length where it ends, m.
    pub to: f64,
    /// Diameter, m.
    pub diameter: f64,
    /// Smallest allowed bend radius, m.
    pub bend_radius_limit: Option<f64>,
}

/// A joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Joint {
    /// Name of the vertex.
    pub name: String,
    /// Name of its model.
    pub model: String,
    /// Names of its branches.
    pub branches: Vec<String>,
}

/// A joint of a mechanism with one freedom.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct MechanismJoint {
    /// Its name: `MECHANISM/JOINT`.
    pub name: String,
    /// Whether its value is a length (m) and not an angle (rad).
    pub is_length: bool,
    /// Its smallest and largest value.
    pub limits: Option<[f64; 2]>,
    /// Whether it can be driven: it follows no other joint.
    pub can_be_driven: bool,
}

/// A constraint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Constraint {
    /// Name.
    pub name: String,
    /// Kind: `connector`, `collar`, `handle` or another one.
    pub kind: String,
    /// Part number, description, supplier and colour in words.
    pub identity: Option<String>,
    /// Branch, and arc length (m) along it; none for a constraint at a joint or along a span.
    pub place: Option<(String, f64)>,
    /// Whether it can be moved.
    pub moves: bool,
    /// Whether it can be rotated.
    pub turns: bool,
    /// Whether it was added interactively in this session.
    pub by_hand: bool,
}

/// An obstacle, in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Obstacle {
    /// Name.
    pub name: String,
    /// Corners, m: x, y, z of each.
    pub corners: Vec<f32>,
    /// Triangles: three corners each, counter-clockwise from outside.
    pub triangles: Vec<u32>,
}

/// A setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Setting {
    /// Key, for `set`.
    pub key: String,
    /// Its group: "joint J", "section trunk", "minimiser".
    pub group: String,
    /// Its label: "model", "bending_stiffness".
    pub label: String,
    /// One-line description.
    pub doc: String,
    /// Form of its value.
    pub form: Form,
    /// Its value; null if not given.
    #[cfg_attr(test, ts(type = "unknown"))]
    pub value: serde_json::Value,
}

/// Form of a setting's value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "is", rename_all = "snake_case", rename_all_fields = "snake_case")]
pub enum Form {
    /// One of several words.
    Choice {
        /// The words, each with a one-line description.
        words: Vec<(String, String)>,
    },
    /// A number.
    Number {
        /// SI unit; empty if dimensionless.
        unit: String,
        /// Smallest value.
        minimum: Option<f64>,
        /// Largest value.
        maximum: Option<f64>,
    },
    /// An integer with a lower limit.
    Count {
        /// Smallest value.
        minimum: u32,
    },
    /// True or false.
    Flag,
}

/// The timeline of steps and increments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Timeline {
    /// Number of frames.
    pub frames: u32,
    /// Steps, in order; in a session the first is the start, with one frame.
    pub steps: Vec<TimelineStep>,
    /// Events, by frame.
    pub events: Vec<Event>,
}

/// A step of the timeline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct TimelineStep {
    /// Name.
    pub name: String,
    /// Number of its first frame.
    pub first: u32,
    /// Number of frames so far.
    pub frames: u32,
    /// Planned number of frames; a drag may add more.
    pub planned: u32,
    /// Whether it was recorded interactively in this session.
    pub by_hand: bool,
}

/// An event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Event {
    /// Number of its first frame.
    pub frame: u32,
    /// Its kind, as in results.
    pub kind: String,
    /// Description.
    pub message: String,
    /// Position, m.
    pub position: Option<[f64; 3]>,
}

/// The sheet of requirements: whether the harness is acceptable. The status of the solver is another thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Sheet {
    /// Verdict on the harness: `pass`, `fail` or `unresolved`.
    pub verdict: String,
    /// Status of the solver: `converged`, `stalled`, `iteration-limit`...
    pub status: String,
    /// Number of steps whose end has been computed.
    pub done: u32,
    /// Number of all steps. While some are missing, nothing passes.
    pub steps: u32,
    /// Its lines, the worst first.
    pub lines: Vec<SheetLine>,
}

/// A line of the sheet: a requirement, and its worst value over all increments so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct SheetLine {
    /// Name.
    pub name: String,
    /// Measure, as in results: `bend_radius`, `tension`, `reach`...
    pub measure: String,
    /// SI unit of worst, limit and error; empty for a pure number.
    pub unit: String,
    /// `must` or `should`.
    pub severity: String,
    /// Origin: `scenario`, `section`, `constraint`, `obstacle` or `always`.
    pub origin: String,
    /// Reason for users, such as a standard.
    pub because: Option<String>,
    /// `pass`, `fail`, `unresolved` or `not checked`.
    pub verdict: String,
    /// Why it is unresolved or not checked.
    pub reason: Option<String>,
    /// The value nearest to its limit, or farthest beyond it.
    pub worst: Option<f64>,
    /// Its limit.
    pub limit: f64,
    /// Side of that limit: `min` or `max`.
    pub bound: String,
    /// Distance from the limit relative to it; negative beyond it. None for a limit of 0.
    pub margin: Option<f64>,
    /// Estimate of the discretisation error of the worst value.
    pub error: Option<f64>,
    /// Step of the worst value.
    pub step: Option<String>,
    /// Its increment, from 1; 0: the start.
    pub increment: Option<u32>,
    /// Number of its frame.
    pub frame: Option<u32>,
    /// Place of the worst value.
    pub place: Place,
}

/// What it does to the requirements to move a constraint from where it is; everything else stays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Sensitivities {
    /// Name of the constraint.
    pub constraint: String,
    /// Why there is none.
    pub reason: Option<String>,
    /// Whether friction, slip, or parts that remember have a history, which is kept as it is.
    pub keeps_history: bool,
    /// The requirements that have a value now, in the order of the sheet.
    pub lines: Vec<SensitivityLine>,
}

/// A requirement, and what it does to its value now to move a constraint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct SensitivityLine {
    /// Name.
    pub name: String,
    /// Measure, as in results: `bend_radius`, `tension`, `reach`...
    pub measure: String,
    /// SI unit of value and limit; empty for a pure number.
    pub unit: String,
    /// Its value now.
    pub value: f64,
    /// Its limit.
    pub limit: f64,
    /// Side of that limit: `min` or `max`.
    pub bound: String,
    /// Place of the value.
    pub place: Place,
    /// Derivatives by the place along x, y, z, unit over m: towards smaller and larger coordinates; null where unknown.
    pub by: [[Option<f64>; 2]; 3],
    /// Why those to both sides differ, or are unknown.
    pub reasons: [Option<String>; 3],
}

/// Place in a harness: the parts that apply.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Place {
    /// Name of the constraint.
    pub constraint: Option<String>,
    /// Name of the obstacle.
    pub obstacle: Option<String>,
    /// Name of the branch.
    pub branch: Option<String>,
    /// Arc length on it, m.
    pub s: Option<f64>,
    /// Name of the other branch, where two of them meet.
    pub other_branch: Option<String>,
    /// Arc length on that, m.
    pub other_s: Option<f64>,
}

/// State of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Session {
    /// Current computation: "the start", "step plug B"; none if idle.
    pub busy: Option<String>,
    /// Label of the next undo.
    pub undo: Option<String>,
    /// Label of the next redo.
    pub redo: Option<String>,
    /// Constraints that are held, each with the number of its tab.
    pub held: Vec<(String, u32)>,
    /// Number of the receiving tab.
    pub you: u32,
    /// Number of tabs.
    pub tabs: u32,
    /// Equilibria per second, over the last second of a drag.
    pub rate: f64,
    /// Whether there are unsaved changes.
    pub unsaved: bool,
}
