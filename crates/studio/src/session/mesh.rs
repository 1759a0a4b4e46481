//! Where the mesh of a snapshot comes from: the scenario, or trial runs for its accuracy.

use std::rc::Rc;
use wireloom::mesh::Adaptation;
use wireloom::session::DrivenHarness;

/// Where the mesh of a snapshot comes from.
#[derive(Clone)]
pub(super) enum Mesh {
    /// From the scenario.
    Given,
    /// Trial runs are looking for it; the steps of the snapshot are one of them.
    Adapting(Box<Adaptation>),
    /// From trial runs: what was done.
    Settled(Rc<str>),
}

impl Mesh {
    /// The mesh of a harness that has just been loaded.
    pub fn of(harness: &DrivenHarness) -> Self {
        Adaptation::new(&harness.scenario, &harness.network).map_or(Self::Given, |own| Self::Adapting(Box::new(own)))
    }

    /// What is being done, in words.
    pub fn progress(&self) -> Option<String> {
        match self {
            Self::Adapting(adaptation) => Some(adaptation.progress()),
            Self::Given | Self::Settled(_) => None,
        }
    }

    /// Note for the engineer.
    pub fn note(&self) -> Option<String> {
        match self {
            Self::Given => None,
            Self::Adapting(adaptation) => Some(format!("{}: the mesh is not the final one", adaptation.progress())),
            Self::Settled(note) => Some(note.to_string()),
        }
    }

    /// Ends the trial runs: the present mesh stays, as it is.
    pub fn stop(&mut self) {
        if let Some(progress) = self.progress() {
            let note = format!("{progress}: stopped, so the mesh may be too coarse; any setting begins them again");
            *self = Self::Settled(note.into());
        }
    }
}
