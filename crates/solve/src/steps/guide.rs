//! Equilibria of a run on one mesh, near which those of the same run on another mesh are searched for.
//!
//! Nested iteration in every increment (Brandt 1977): the way from one increment to the next takes many iterations on
//! any mesh. Where it was gone on another one, a few remain. Which equilibrium is reached is then up to the other run,
//! so this is for trial runs, which ask how fine a mesh has to be.

use crate::start::prolongation::{Places, has_history};
use std::collections::BTreeMap;
use std::sync::Arc;
use wireloom_core::equilibrium::StepResult;
use wireloom_core::{Moment, Network, State};

/// Equilibria at the ends of increments. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Guide {
    places: Arc<Places>,
    /// By the name of the step and the number of the increment.
    ends: BTreeMap<(String, usize), Arc<State>>,
}

impl Guide {
    /// A guide without equilibria, to be filled by a run of this harness; `None` if its states have a history.
    pub fn new(network: &Network) -> Option<Self> {
        let places = || Places::of(network, &State::origin(network));
        (!has_history(network)).then(|| Self { places: Arc::new(places()), ends: BTreeMap::new() })
    }

    /// Takes the end of an increment.
    pub fn add(&mut self, end: &StepResult, state: &State) {
        self.ends.insert((end.name.clone(), end.increment), Arc::new(state.clone()));
    }

    /// The equilibrium at this moment, on the mesh of `network`.
    pub(crate) fn near(&self, moment: &Moment, network: &Network) -> Option<State> {
        let end = self.ends.get(&(moment.step.clone(), moment.increment))?;
        Some(self.places.prolonged(end, network))
    }
}
