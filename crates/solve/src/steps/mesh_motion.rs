//! Motion of the mesh along its cable: places the stations of constraints that begin, and releases constraints that the
//! cable has run out of.

use super::driver::Driver;
use crate::report::{Occurrence, result};
use crate::steps::clips;
use wireloom_core::terms::sliding::SlideStop;
use wireloom_core::{EventKind, EventPlace};

/// Arc lengths that differ by less than this fraction of the branch are the same.
const SAME_PLACE: f64 = 1e-12;
/// Change of a branch's twist (turns) by a motion of its mesh that counts as a lost turn: interpolation changes it by
/// little.
const LOST_TURN: f64 = 0.5;

impl Driver<'_, '_> {
    /// Releases the constraints that the cable has run out of. Returns whether there was one.
    pub(super) fn release_run_out(&mut self) -> bool {
        let network = self.problem.network;
        let mut released = false;
        for (k, site) in network.slides.iter().enumerate() {
            if self.problem.slide_stop(k, &self.certifier.gradient) == Some(SlideStop::End) {
                self.problem.change(|c| c.active[site.constraint] = false);
                let s = self.state.arc_lengths(network, site.branch);
                let knots: Vec<_> =
                    self.problem.system().knots(site.branch).into_iter().map(|node| (node, s[node])).collect();
                self.move_mesh(site.branch, &knots);
                released = true;
                let constraint = &network.constraints[site.constraint].name;
                let branch = &network.branches[site.branch].name;
                self.log.raise(Occurrence {
                    kind: EventKind::LeftRing,
                    place: EventPlace {
                        constraint: Some(constraint.clone()),
                        ..EventPlace::branch(branch, s[site.node])
                    },
                    value: None,
                    limit: None,
                    message: "the cable ran out of it over its end: it no longer acts".into(),
                });
            }
        }
        released
    }

    /// Places the stations of constraints that begin at the arc lengths they were given, or at the nearest ones, where
    /// the mesh has moved along the cable since it was built. Returns remarks.
    pub(super) fn place_stations(&mut self, added: &[usize]) -> Vec<String> {
        let network = self.problem.network;
        let mut notes = Vec::new();
        for (b, _) in network.branches.iter().enumerate().filter(|(_, branch)| branch.mesh_moves) {
            let s = self.state.arc_lengths(network, b);
            let mut knots: Vec<_> = self.problem.system().knots(b).into_iter().map(|node| (node, s[node])).collect();
            // The scenario ensures that a constraint that closes at the nearest place has a seat.
            let seat = |f: usize| self.problem.conditions().given_position(network, f).unwrap_or_default();
            notes.extend(clips::place_stations(network, &self.state, b, added, seat, &mut knots));
            if knots.iter().any(|&(node, to)| (to - s[node]).abs() > SAME_PLACE * s[s.len() - 1]) {
                let moved = self.move_mesh(b, &knots);
                debug_assert!(moved, "arc lengths increase: {knots:?}");
            }
        }
        notes
    }

    /// Moves the mesh of a branch along it; see [`wireloom_core::Network::move_mesh`].
    fn move_mesh(&mut self, branch: usize, knots: &[(usize, f64)]) -> bool {
        let network = self.problem.network;
        let before = result::twist_turns(self.state.branch(network, branch).frames);
        let moved = network.move_mesh(branch, knots, &mut self.state);
        let lost = before - result::twist_turns(self.state.branch(network, branch).frames);
        if lost.abs() > LOST_TURN {
            self.log.raise(Occurrence {
                kind: EventKind::TwistLost,
                place: EventPlace { branch: Some(network.branches[branch].name.clone()), ..EventPlace::default() },
                value: Some(lost.abs().round()),
                limit: None,
                message: "its mesh, moved along the cable, does not hold the twist any more: more segments may".into(),
            });
        }
        moved
    }
}
