//! What page and server say to each other. Text frames of the WebSocket are JSON: [`Request`] towards the server, [`Notice`] towards the
//! page; binary frames are shapes ([`crate::frame`]). `web/src/protocol.ts` is made from these types by a test.
//!
//! Lengths m, forces N, moments N m, times s; orientations `[w, x, y, z]`. Frames are numbered from 0, the balanced start; every
//! increment has one. Hands take hold where a step has ended, so that what they do can be written as further steps.

use serde::{Deserialize, Serialize};
#[cfg(test)]
use ts_rs::TS;

/// What a page asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "do", rename_all = "snake_case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// A constraint begins where the cable is now: a hand, a pin or a clip. The tab that asked holds it (see `target`) if it is a handle.
    Hold {
        /// Branch.
        branch: String,
        /// Arc length, m; the nearest node is taken.
        s: f64,
        /// What begins there.
        how: Holding,
    },
    /// Brings a constraint somewhere. Only the newest target counts; those of one drag (until `drop`) are increments of one step.
    Target {
        /// Name of the constraint.
        constraint: String,
        /// Where to, m.
        position: Option<[f64; 3]>,
        /// How it is to stand, `[w, x, y, z]`: columns d1, d2, d3.
        orientation: Option<[f64; 4]>,
    },
    /// Ends a drag: the step is complete, the constraint stays where it is.
    Drop {
        /// Name of the constraint.
        constraint: String,
    },
    /// A constraint lets go.
    Release {
        /// Name of the constraint.
        constraint: String,
    },
    /// A constraint holds position, tangent and twist where they are from now on.
    Pin {
        /// Name of the constraint.
        constraint: String,
    },
    /// Takes back what was done last.
    Undo,
    /// Does it again.
    Redo,
    /// Goes back to the end of the step that this frame belongs to; what came after is taken off the timeline (`undo` brings it back).
    Go {
        /// Number of the frame.
        frame: u32,
    },
    /// Puts another value in the place of what the scenario says: a joint model, a rod, the minimiser, a number of a section.
    Set {
        /// The key, such as `joints.J.model`: one of the scene's settings.
        key: String,
        /// Its value, as a scenario would have it: a number in SI units, a word, true or false.
        #[cfg_attr(test, ts(type = "unknown"))]
        value: serde_json::Value,
    },
    /// Stops what is being computed: the rest of the scenario's steps stay undone.
    Stop,
    /// Asks for frames that this page has not got.
    Frames {
        /// First.
        from: u32,
        /// One behind the last; the server sends so many at most as it sees fit.
        to: u32,
    },
    /// Asks for the scenario as it is now, steps of hands included.
    Save,
    /// Takes up what an earlier session has left unsaved, or discards it.
    Draft {
        /// Whether to take it up.
        take: bool,
    },
}

/// What may begin to hold a cable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub enum Holding {
    /// A hand: it holds the point.
    Handle,
    /// It holds position, tangent and twist.
    Pin,
    /// A clip: it holds position and tangent.
    Collar,
}

/// What a server tells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "is", rename_all = "snake_case", rename_all_fields = "snake_case")]
pub enum Notice {
    /// The harness: sent first, and whenever it has become another one. Frames of another `run` no longer count.
    Scene(Scene),
    /// How far the timeline reaches; a page drops the frames it has beyond it.
    Timeline(Timeline),
    /// How the session stands.
    Session(Session),
    /// A request could not be fulfilled.
    Refused {
        /// What is wrong.
        message: String,
        /// What would be right.
        help: String,
    },
    /// There is a draft: what an earlier session has left unsaved.
    Draft {
        /// When it was kept (RFC 3339); none: there is no draft any more.
        written: Option<String>,
    },
    /// The scenario as it is now.
    Saved {
        /// A name for the file.
        name: String,
        /// Its text.
        text: String,
    },
}

/// A harness and all that is about it, but for where it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Scene {
    /// Name of the scenario.
    pub name: String,
    /// Name and version of the program.
    pub program: String,
    /// Whether there is a solver behind it; else it is a finished run.
    pub live: bool,
    /// Number of the run: frames of an earlier scene still count while it stays the same, as when a hand takes hold.
    pub run: u32,
    /// Gravity, m/s².
    pub gravity: [f64; 3],
    /// Branches, in the order of the frames.
    pub branches: Vec<Branch>,
    /// Joints, in the order of the frames.
    pub joints: Vec<Joint>,
    /// Constraints: those that ever act. Frames name those that act at the time.
    pub constraints: Vec<Constraint>,
    /// Bodies, in the order of the frames.
    pub obstacles: Vec<Obstacle>,
    /// What may be set, in the order in which it is to be shown.
    pub settings: Vec<Setting>,
    /// What an engineer should know about this harness.
    pub notes: Vec<String>,
    /// Files that can be had under `export/`: `result.json`, `picture.svg` and the like.
    pub exports: Vec<String>,
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
    /// Least bend radius allowed, m.
    pub bend_radius_limit: Option<f64>,
    /// Number of nodes.
    pub nodes: u32,
    /// Unstressed length, m.
    pub length: f64,
}

/// A joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Joint {
    /// Name of the vertex.
    pub name: String,
    /// Model.
    pub model: String,
    /// Names of its branches.
    pub branches: Vec<String>,
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
    /// Branch, and arc length (m) along it; none at a joint or along a span.
    pub place: Option<(String, f64)>,
    /// Whether it can be brought somewhere.
    pub moves: bool,
    /// Whether it can be turned.
    pub turns: bool,
    /// Whether hands began it in this session.
    pub by_hand: bool,
}

/// A body, in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Obstacle {
    /// Name.
    pub name: String,
    /// Corners, m: x, y, z of one after the other.
    pub corners: Vec<f32>,
    /// Triangles: three corners each, counter-clockwise from outside.
    pub triangles: Vec<u32>,
}

/// Something that may be set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Setting {
    /// Key, for `set`.
    pub key: String,
    /// What it belongs to: "joint J", "section trunk", "minimiser".
    pub group: String,
    /// What it is called: "model", "bending_stiffness".
    pub label: String,
    /// One line: what it is for.
    pub doc: String,
    /// What it holds.
    pub form: Form,
    /// Its value; null: not given.
    #[cfg_attr(test, ts(type = "unknown"))]
    pub value: serde_json::Value,
}

/// What a setting holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "is", rename_all = "snake_case", rename_all_fields = "snake_case")]
pub enum Form {
    /// One of these words.
    Choice {
        /// The words, each with one line on what it is for.
        words: Vec<(String, String)>,
    },
    /// A number.
    Number {
        /// SI unit; empty for pure numbers.
        unit: String,
        /// Least value.
        minimum: Option<f64>,
        /// Greatest value.
        maximum: Option<f64>,
    },
    /// A whole number of at least so many.
    Count {
        /// Least value.
        minimum: u32,
    },
    /// true or false.
    Flag,
}

/// The increments there are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Timeline {
    /// Number of frames.
    pub frames: u32,
    /// Steps, in order; in a session the first is the start, of one frame.
    pub steps: Vec<TimelineStep>,
    /// What happened, by frame.
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
    /// Number of frames it is to have; more may come while a hand drags.
    pub planned: u32,
    /// Whether hands did it in this session.
    pub by_hand: bool,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Event {
    /// Number of the frame where it began.
    pub frame: u32,
    /// Its kind, as results call it.
    pub kind: String,
    /// What happened, in words.
    pub message: String,
    /// Where, m.
    pub position: Option<[f64; 3]>,
}

/// How a session stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Session {
    /// What is being computed: "the start", "step plug B"; none: it waits for hands.
    pub busy: Option<String>,
    /// What `undo` would take back.
    pub undo: Option<String>,
    /// What `redo` would do again.
    pub redo: Option<String>,
    /// Constraints that are held by a tab, and the number of that tab.
    pub held: Vec<(String, u32)>,
    /// The number of the tab that this is sent to.
    pub you: u32,
    /// How many tabs there are.
    pub tabs: u32,
    /// Equilibria a second, over the last second of a drag.
    pub rate: f64,
    /// Whether there is something that `save` has not given out yet.
    pub unsaved: bool,
}
