//! Events of a run: exceeded limits, snap-through, slip, increments that were difficult to solve.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum EventKind {
    /// A branch is bent more tightly than its section allows; value and limit are radii, m.
    BendRadius,
    /// A branch is nearer to an obstacle than required; value and limit are distances from surface to surface, m.
    Clearance,
    /// The force on a constraint exceeds its limit; N.
    ConstraintForce,
    /// The moment on a constraint exceeds its limit; N m.
    ConstraintMoment,
    /// A span is shorter than the distance between its ends; value: that distance, m; limit: the span's length, m.
    Overstretched,
    /// The insertion force of a connector exceeds its limit; N.
    InsertionForce,
    /// Constraints hold cables nearer to each other than the sum of their radii, or a cable and a body are driven into
    /// each other where a constraint holds the cable; value and limit are distances from its centre line to the other
    /// one, or to the body, m.
    Overlap,
    /// Two cables, or two parts of one, lie in each other deeper than soft cables may; value and limit are depths, m.
    PassedThrough,
    /// An equilibrium ceased to exist or to be stable, and the harness snapped to another one; value: largest
    /// displacement of a point, m.
    Jump,
    /// The cable slips through a constraint with friction; value: the friction, N.
    Slip,
    /// The cable sticks again in a constraint with friction in which it slipped; value: the friction force, N.
    Stick,
    /// The cable ran out of a sliding constraint, which no longer acts.
    LeftRing,
    /// Another constraint or a joint stops the cable in a sliding constraint; value: the force on the stop, N.
    SlideStop,
    /// An increment did not converge and was carried out in smaller parts; value: their number.
    CutBack,
    /// An increment did not converge; value: residual, relative; limit: the tolerance.
    NotConverged,
    /// An increment ended in an equilibrium that is not stable.
    Unstable,
    /// The mesh cannot represent the prescribed turns of twist; value: number of turns that would be lost at once.
    TwistLost,
    /// The rotation between neighbouring frames of a branch is so large that its segments do not bend and twist as the
    /// cable does; value and limit are angles, rad.
    CoarseMesh,
    /// An event of a constraint's kind ([`crate::registry::Output::event`]); value: that of the output, SI.
    Reported,
}

impl EventKind {
    /// All kinds, in the order in which they are listed.
    pub const ALL: [EventKind; 19] = [
        EventKind::NotConverged,
        EventKind::TwistLost,
        EventKind::CoarseMesh,
        EventKind::Jump,
        EventKind::Unstable,
        EventKind::Overstretched,
        EventKind::Overlap,
        EventKind::PassedThrough,
        EventKind::BendRadius,
        EventKind::Clearance,
        EventKind::ConstraintForce,
        EventKind::ConstraintMoment,
        EventKind::InsertionForce,
        EventKind::Reported,
        EventKind::LeftRing,
        EventKind::SlideStop,
        EventKind::Slip,
        EventKind::Stick,
        EventKind::CutBack,
    ];

    /// The word used in results.
    pub fn word(self) -> &'static str {
        match self {
            EventKind::BendRadius => "bend-radius",
            EventKind::Clearance => "clearance",
            EventKind::ConstraintForce => "fixing-force",
            EventKind::ConstraintMoment => "fixing-moment",
            EventKind::Overstretched => "overstretched",
            EventKind::InsertionForce => "insertion-force",
            EventKind::Overlap => "overlap",
            EventKind::PassedThrough => "passed-through",
            EventKind::Jump => "jump",
            EventKind::Slip => "slip",
            EventKind::Stick => "stick",
            EventKind::LeftRing => "left-ring",
            EventKind::SlideStop => "slide-stop",
            EventKind::CutBack => "cut-back",
            EventKind::NotConverged => "not-converged",
            EventKind::Unstable => "unstable",
            EventKind::TwistLost => "twist-lost",
            EventKind::CoarseMesh => "coarse-mesh",
            EventKind::Reported => "reported",
        }
    }

    /// Short description for users.
    pub fn title(self) -> &'static str {
        match self {
            EventKind::BendRadius => "bent too tightly",
            EventKind::Clearance => "nearer than the required clearance",
            EventKind::ConstraintForce => "constraint force above its limit",
            EventKind::ConstraintMoment => "constraint moment above its limit",
            EventKind::Overstretched => "overstretched span",
            EventKind::InsertionForce => "insertion force above its limit",
            EventKind::Overlap => "held in each other",
            EventKind::PassedThrough => "cables pass through each other",
            EventKind::Jump => "snapped to another equilibrium",
            EventKind::Slip => "slipped against friction",
            EventKind::Stick => "sticks again",
            EventKind::LeftRing => "ran out of its constraint",
            EventKind::SlideStop => "sliding was stopped",
            EventKind::CutBack => "increment cut back",
            EventKind::NotConverged => "not converged",
            EventKind::Unstable => "unstable equilibrium",
            EventKind::TwistLost => "twist lost",
            EventKind::CoarseMesh => "mesh too coarse",
            EventKind::Reported => "reported by a constraint",
        }
    }

    /// Whether the event demands a correction, as opposed to information only.
    pub fn is_trouble(self) -> bool {
        !matches!(
            self,
            EventKind::Slip | EventKind::Stick | EventKind::SlideStop | EventKind::CutBack | EventKind::Reported
        )
    }

    /// SI unit of its values; empty where they have none.
    pub fn unit(self) -> &'static str {
        match self {
            EventKind::BendRadius
            | EventKind::Clearance
            | EventKind::Overstretched
            | EventKind::Overlap
            | EventKind::PassedThrough
            | EventKind::Jump => "m",
            EventKind::ConstraintForce
            | EventKind::InsertionForce
            | EventKind::Slip
            | EventKind::Stick
            | EventKind::SlideStop => "N",
            EventKind::ConstraintMoment => "N m",
            EventKind::CoarseMesh => "rad",
            _ => "",
        }
    }

    /// Whether a value is worse than another one: radii and distances should be large, everything else small.
    pub fn worse(self, value: f64, than: f64) -> bool {
        if self.is_better_large() { value < than } else { value > than }
    }

    /// What events of one kind at one part are about, from the message of one: the name of an event of a constraint's
    /// kind, with which its message begins.
    pub fn subject(self, message: &str) -> &str {
        match (self, message.split_once(':')) {
            (EventKind::Reported, Some((name, _))) => name,
            _ => "",
        }
    }

    fn is_better_large(self) -> bool {
        matches!(self, EventKind::BendRadius | EventKind::Clearance | EventKind::Overlap)
    }
}

/// Part of the harness that an event concerns; all fields empty: the whole harness.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EventPlace {
    /// Name of the constraint.
    // Key of the results file.
    #[serde(rename = "fixing")]
    pub constraint: Option<String>,
    /// Name of the obstacle.
    pub obstacle: Option<String>,
    /// Name of the branch.
    pub branch: Option<String>,
    /// Arc length on the branch, m.
    pub s: Option<f64>,
    /// Name of the other branch, where two of them meet.
    pub other_branch: Option<String>,
    /// Arc length on the other branch, m.
    pub other_s: Option<f64>,
}

impl EventPlace {
    /// A constraint.
    pub fn constraint(name: &str) -> Self {
        Self { constraint: Some(name.to_owned()), ..Self::default() }
    }

    /// A place on a branch.
    pub fn branch(name: &str, s: f64) -> Self {
        Self { branch: Some(name.to_owned()), s: Some(s), ..Self::default() }
    }
}

/// "constraint `clip-1`", "branch `trunk` at s = 310.0 mm", "harness".
impl fmt::Display for EventPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        parts.extend(self.constraint.as_ref().map(|name| format!("constraint `{name}`")));
        parts.extend(self.obstacle.as_ref().map(|name| format!("obstacle `{name}`")));
        parts.extend(self.branch.as_ref().map(|name| match self.s {
            Some(s) => format!("branch `{name}` at s = {:.1} mm", 1e3 * s),
            None => format!("branch `{name}`"),
        }));
        parts.extend(self.other_branch.as_ref().map(|name| match self.other_s {
            Some(s) => format!("branch `{name}` at s = {:.1} mm", 1e3 * s),
            None => format!("branch `{name}`"),
        }));
        f.write_str(if parts.is_empty() { "harness" } else { "" })?;
        f.write_str(&parts.join(", "))
    }
}

/// An increment of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Name of the step.
    pub step: String,
    /// Index of the step, from 0.
    pub step_index: usize,
    /// Index of the increment, from 1; 0: while the initial equilibrium was being found.
    pub increment: usize,
}

/// An event. A condition that lasts over consecutive increments is one event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Its kind.
    pub kind: EventKind,
    /// Its place; the arc length is that of the worst increment.
    pub place: EventPlace,
    /// First increment.
    pub first: Moment,
    /// Worst increment.
    pub worst: Moment,
    /// Last increment.
    pub last: Moment,
    /// Number of increments in which the condition held.
    pub increments: usize,
    /// Worst value; see [`EventKind`] for its meaning.
    pub value: Option<f64>,
    /// Limit of the value.
    pub limit: Option<f64>,
    /// One sentence for users about the worst increment, without its name.
    pub message: String,
}

impl Event {
    /// Ratio of the value to the limit, or of the limit to the value where larger is better (infinite for values ≤
    /// 0); 0 without value or limit.
    pub fn excess(&self) -> f64 {
        match (self.value, self.limit) {
            (Some(value), Some(limit)) if self.kind.is_better_large() => limit / value.max(0.0),
            (Some(value), Some(limit)) => value / limit,
            _ => 0.0,
        }
    }
}

/// Events of one kind at one part of the harness, at any arc length.
#[derive(Clone, Debug, PartialEq)]
pub struct Group<'a> {
    /// First event.
    pub first: &'a Event,
    /// Worst event.
    pub worst: &'a Event,
    /// Number of increments.
    pub increments: usize,
}

/// Groups events by kind, subject and part, in the order of [`EventKind::ALL`], and within a kind with the largest
/// excess first.
pub fn grouped(events: &[Event]) -> Vec<Group<'_>> {
    let thing = |event: &Event| EventPlace { s: None, other_s: None, ..event.place.clone() };
    let mut groups: Vec<Group> = Vec::new();
    for event in events {
        let about = |event: &Event| (event.kind, event.kind.subject(&event.message).to_owned(), thing(event));
        let same = |group: &&mut Group| about(group.first) == about(event);
        let Some(group) = groups.iter_mut().find(same) else {
            groups.push(Group { first: event, worst: event, increments: event.increments });
            continue;
        };
        group.increments += event.increments;
        if let (Some(value), Some(before)) = (event.value, group.worst.value)
            && event.kind.worse(value, before)
        {
            group.worst = event;
        }
    }
    let rank = |group: &Group<'_>| EventKind::ALL.iter().position(|kind| *kind == group.first.kind);
    groups.sort_by(|a, b| rank(a).cmp(&rank(b)).then(b.worst.excess().total_cmp(&a.worst.excess())));
    groups
}
