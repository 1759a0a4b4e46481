//! The built-in loads against the contracts of their traits.

use wireloom_core::load::{Dead, DeadLine, Flow, Follower, FollowerLine};
use wireloom_core::{Rotation, Vector};
use wireloom_testkit::{line_load_conformance, point_load_conformance};

const FORCE: Vector = Vector::new(1.0, 2.0, -3.0);
const MOMENT: Vector = Vector::new(0.3, -0.1, 0.2);

point_load_conformance!(dead_force, |turn: &Rotation| Box::new(Dead { force: turn * FORCE, moment: Vector::zeros() }));
point_load_conformance!(dead_moment, |turn: &Rotation| Box::new(Dead { force: turn * FORCE, moment: turn * MOMENT }));
point_load_conformance!(follower, |_: &Rotation| Box::new(Follower { force: FORCE, moment: MOMENT }));
line_load_conformance!(dead_line, |turn: &Rotation| Box::new(DeadLine(turn * FORCE)));
line_load_conformance!(follower_line, |_: &Rotation| Box::new(FollowerLine(FORCE)));
line_load_conformance!(flow, |turn: &Rotation| Box::new(Flow { velocity: turn * (FORCE * 2.0), drag: 0.7 }));
