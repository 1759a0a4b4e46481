//! Event log of a run.

use super::sheet::{Found, Here, Sheet};
use super::violations::violations;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wireloom_core::equilibrium::{Clearance, Run, Violation};
use wireloom_core::requirement::Requirement;
use wireloom_core::{Event, EventKind, EventPlace, Moment, Network};

/// Occurrence of an event in the present increment.
#[derive(Clone, Debug, PartialEq)]
pub struct Occurrence {
    /// Kind.
    pub kind: EventKind,
    /// Place.
    pub place: EventPlace,
    /// See [`Event::value`].
    pub value: Option<f64>,
    /// See [`Event::limit`].
    pub limit: Option<f64>,
    /// See [`Event::message`].
    pub message: String,
}

/// Events so far. Occurrences in successive increments are one event.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EventLog {
    events: Vec<Event>,
    now: Moment,
    /// Increments so far.
    count: usize,
    /// Least clearances so far.
    pub(super) clearances: Vec<Clearance>,
    /// Worst values of the requirements so far.
    pub(crate) sheet: Sheet,
    /// Requirements that are not kept at the end of the present increment.
    violations: Vec<Violation>,
    /// By kind, and by part of the harness with the subject: the last event of that kind there, and the increment of
    /// its last occurrence.
    latest: BTreeMap<(EventKind, String), (usize, usize)>,
}

impl EventLog {
    /// Events so far, in the order in which they began.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Present increment.
    pub(crate) fn now(&self) -> &Moment {
        &self.now
    }

    /// Begins an increment.
    pub fn begin(&mut self, now: Moment) {
        self.count += 1;
        self.now = now;
        self.violations.clear();
    }

    /// Requirements that are not kept at the end of the present increment.
    pub(crate) fn violations(&self) -> &[Violation] {
        &self.violations
    }

    /// Adds to the sheet what was found for each requirement; see [`Sheet::add`].
    pub(crate) fn check(&mut self, requirements: &[Requirement], found: Vec<Vec<Found>>, here: Here) {
        if here != Here::OnTheWay {
            self.violations = violations(requirements, &found);
        }
        self.sheet.add(requirements, found, &self.now, here);
    }

    /// Adds an occurrence to the event that it continues, or begins an event.
    pub fn raise(&mut self, occurrence: Occurrence) {
        let part = part(&occurrence.place) + occurrence.kind.subject(&occurrence.message);
        let (now, count) = (&self.now, self.count);
        let entry = self.latest.entry((occurrence.kind, part)).or_insert((self.events.len(), count));
        if entry.1 + 1 < count {
            *entry = (self.events.len(), count);
        }
        let Some(event) = self.events.get_mut(entry.0) else {
            self.events.push(Event {
                kind: occurrence.kind,
                place: occurrence.place,
                first: now.clone(),
                worst: now.clone(),
                last: now.clone(),
                increments: 1,
                value: occurrence.value,
                limit: occurrence.limit,
                message: occurrence.message,
            });
            return;
        };
        if entry.1 < count {
            event.increments += 1;
            event.last.clone_from(now);
        }
        entry.1 = count;
        if let (Some(value), Some(before)) = (occurrence.value, event.value)
            && occurrence.kind.worse(value, before)
        {
            event.worst.clone_from(now);
            event.place = occurrence.place;
            (event.value, event.limit, event.message) = (occurrence.value, occurrence.limit, occurrence.message);
        }
    }

    /// Whether an event of this kind occurred there in the previous increment.
    pub(super) fn was_present(&self, kind: EventKind, place: &EventPlace) -> bool {
        self.latest.get(&(kind, part(place))).is_some_and(|(_, seen)| seen + 1 == self.count)
    }

    /// Moves events, clearances and the sheet of a network into the result of a run, whose status is known.
    pub fn write_to(self, network: &Network, run: &mut Run) {
        run.requirements = self.sheet.lines(network, run.status());
        (run.events, run.clearances) = (self.events, self.clearances);
    }
}

/// Part of the harness at a place, without its arc length.
fn part(place: &EventPlace) -> String {
    EventPlace { s: None, other_s: None, ..place.clone() }.to_string()
}
