//! What happened on the way that an engineer must know: limits passed, snaps, slips, increments that were hard to find.

use serde::{Deserialize, Serialize};
use std::fmt;

/// What kind of thing happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum EventKind {
    /// A branch is bent more tightly than its section allows; value and limit are radii, m.
    BendRadius,
    /// A branch is nearer to an obstacle than asked for; value and limit are distances from surface to surface, m.
    Clearance,
    /// A constraint takes more force than it can; N.
    ConstraintForce,
    /// A constraint takes more moment than it can; N m.
    ConstraintMoment,
    /// A span is shorter than the distance it must bridge; value: that distance, m; limit: the span's length, m.
    Overstretched,
    /// Pushing a connector home takes more force than allowed; N.
    InsertionForce,
    /// Constraints hold cables nearer to each other than they are thick; value and limit are distances between centre lines, m.
    Overlap,
    /// An equilibrium ceased to exist or to be stable, and the harness snapped to another one; value: the farthest that
    /// any point moved, m.
    Jump,
    /// The cable slips through a constraint with friction; value: the friction, N.
    Slip,
    /// The cable sticks again in a constraint with friction in which it slipped; value: what friction holds, N.
    Stick,
    /// The cable ran out of a constraint it slides in: that no longer acts.
    LeftRing,
    /// The cable cannot run on through a constraint: another one or a joint has come up against it; value: what that takes, N.
    SlideStop,
    /// An increment did not converge and was carried out in smaller parts; value: into how many.
    CutBack,
    /// An increment did not converge; value: residual, relative; limit: the tolerance.
    NotConverged,
    /// An increment ended in an equilibrium that is not stable.
    Unstable,
    /// Turns of twist that were asked for cannot be held by the mesh; value: how many would be lost at once.
    TwistLost,
    /// Neighbouring frames of a branch are turned so far against each other that its segments do not bend and twist as the cable does;
    /// value and limit are turns, rad.
    CoarseMesh,
}

impl EventKind {
    /// All kinds, in the order in which they are listed.
    pub const ALL: [EventKind; 17] = [
        EventKind::NotConverged,
        EventKind::TwistLost,
        EventKind::CoarseMesh,
        EventKind::Jump,
        EventKind::Unstable,
        EventKind::Overstretched,
        EventKind::Overlap,
        EventKind::BendRadius,
        EventKind::Clearance,
        EventKind::ConstraintForce,
        EventKind::ConstraintMoment,
        EventKind::InsertionForce,
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
        }
    }

    /// The kind in a few words for people.
    pub fn title(self) -> &'static str {
        match self {
            EventKind::BendRadius => "bent too tightly",
            EventKind::Clearance => "nearer than the required clearance",
            EventKind::ConstraintForce => "constraint force above its limit",
            EventKind::ConstraintMoment => "constraint moment above its limit",
            EventKind::Overstretched => "overstretched span",
            EventKind::InsertionForce => "insertion force above its limit",
            EventKind::Overlap => "cables held in each other",
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
        }
    }

    /// Whether the engineer must do something about it, or need only know.
    pub fn is_trouble(self) -> bool {
        !matches!(self, EventKind::Slip | EventKind::Stick | EventKind::SlideStop | EventKind::CutBack)
    }

    /// SI unit of its values; empty where they have none.
    pub fn unit(self) -> &'static str {
        match self {
            EventKind::BendRadius
            | EventKind::Clearance
            | EventKind::Overstretched
            | EventKind::Overlap
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

    fn is_better_large(self) -> bool {
        matches!(self, EventKind::BendRadius | EventKind::Clearance | EventKind::Overlap)
    }
}

/// What it happened to; all empty: to the harness as a whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EventPlace {
    /// Name of the constraint.
    // The name of the key in results.
    #[serde(rename = "fixing")]
    pub constraint: Option<String>,
    /// Name of the obstacle.
    pub obstacle: Option<String>,
    /// Name of the branch.
    pub branch: Option<String>,
    /// Arc length on the branch, m.
    pub s: Option<f64>,
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

/// "constraint `clip-1`", "branch `trunk` at s = 0.31 m", "harness".
impl fmt::Display for EventPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        parts.extend(self.constraint.as_ref().map(|name| format!("constraint `{name}`")));
        parts.extend(self.obstacle.as_ref().map(|name| format!("obstacle `{name}`")));
        parts.extend(self.branch.as_ref().map(|name| match self.s {
            Some(s) => format!("branch `{name}` at s = {s:.4} m"),
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
    /// Which step, from 0.
    pub step_index: usize,
    /// Which increment of it, from 1; 0: while the start was found.
    pub increment: usize,
}

/// Something that happened. What goes on over increments that follow each other is one event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// What.
    pub kind: EventKind,
    /// To what; its arc length is that of the worst increment.
    pub place: EventPlace,
    /// The increment in which it began.
    pub first: Moment,
    /// The increment in which it was worst.
    pub worst: Moment,
    /// The last increment in which it was so.
    pub last: Moment,
    /// In how many increments it was so.
    pub increments: usize,
    /// The worst value; see [`EventKind`] for what it is.
    pub value: Option<f64>,
    /// What it should not pass.
    pub limit: Option<f64>,
    /// One sentence for people, of the worst increment, without its name.
    pub message: String,
}

impl Event {
    /// How many times the limit its value is, or the limit its value where more is better (without end where that is 0 or less); 0 where there is none.
    pub fn excess(&self) -> f64 {
        match (self.value, self.limit) {
            (Some(value), Some(limit)) if self.kind.is_better_large() => limit / value.max(0.0),
            (Some(value), Some(limit)) => value / limit,
            _ => 0.0,
        }
    }
}

/// Events of one kind at one thing, at whatever arc length.
#[derive(Clone, Debug, PartialEq)]
pub struct Group<'a> {
    /// The first.
    pub first: &'a Event,
    /// The worst.
    pub worst: &'a Event,
    /// In how many increments.
    pub increments: usize,
}

/// Events by kind and thing, in the order of [`EventKind::ALL`], what is furthest beyond its limit first: what people want to read.
pub fn grouped(events: &[Event]) -> Vec<Group<'_>> {
    let thing = |event: &Event| EventPlace { s: None, ..event.place.clone() };
    let mut groups: Vec<Group> = Vec::new();
    for event in events {
        let same = |group: &&mut Group| group.first.kind == event.kind && thing(group.first) == thing(event);
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
