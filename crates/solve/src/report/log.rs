//! The log of events of a run.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wireloom_core::equilibrium::{Clearance, Run};
use wireloom_core::{Event, EventKind, EventPlace, Moment};

/// Something that happened in the increment at hand.
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

/// Events so far. An occurrence that goes on from one increment to the next is one event.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EventLog {
    events: Vec<Event>,
    now: Moment,
    /// Increments so far.
    count: usize,
    /// The least so far.
    pub(super) clearances: Vec<Clearance>,
    /// By kind and thing the last event of that kind there, and the increment in which it was seen last.
    latest: BTreeMap<(EventKind, String), (usize, usize)>,
}

impl EventLog {
    /// Events so far, in the order in which they began.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Increment that was begun last.
    pub(super) fn now(&self) -> &Moment {
        &self.now
    }

    /// Begins an increment.
    pub fn begin(&mut self, now: Moment) {
        self.count += 1;
        self.now = now;
    }

    /// Adds an occurrence to the event that goes on, or begins one.
    pub fn raise(&mut self, what: Occurrence) {
        let thing = thing(&what.place);
        let (now, count) = (&self.now, self.count);
        let entry = self.latest.entry((what.kind, thing)).or_insert((self.events.len(), count));
        if entry.1 + 1 < count {
            *entry = (self.events.len(), count);
        }
        let Some(event) = self.events.get_mut(entry.0) else {
            self.events.push(Event {
                kind: what.kind,
                place: what.place,
                first: now.clone(),
                worst: now.clone(),
                last: now.clone(),
                increments: 1,
                value: what.value,
                limit: what.limit,
                message: what.message,
            });
            return;
        };
        if entry.1 < count {
            event.increments += 1;
            event.last.clone_from(now);
        }
        entry.1 = count;
        if let (Some(value), Some(before)) = (what.value, event.value)
            && what.kind.worse(value, before)
        {
            event.worst.clone_from(now);
            (event.place, event.value, event.limit, event.message) = (what.place, what.value, what.limit, what.message);
        }
    }

    /// Whether an event of this kind was there in the increment before this one.
    pub(super) fn went_on(&self, kind: EventKind, place: &EventPlace) -> bool {
        self.latest.get(&(kind, thing(place))).is_some_and(|(_, seen)| seen + 1 == self.count)
    }

    /// Hands events and clearances to a run that ends.
    pub fn tell(self, run: &mut Run) {
        (run.events, run.clearances) = (self.events, self.clearances);
    }
}

/// The part of the harness that an event is about, at any arc length.
fn thing(place: &EventPlace) -> String {
    EventPlace { s: None, ..place.clone() }.to_string()
}
