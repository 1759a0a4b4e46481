//! What a spot watches: an obstacle that it may touch, and what its shape said last.
//!
//! Shapes are asked again only where the answer may be another one: at one state energy, forces and second derivatives need the same answer,
//! and as φ falls no faster than one goes, what was far enough away needs no second look while the spot has hardly moved. Either way the answer
//! is that which the shape would give: what is found follows from the state alone.

use crate::Vector;
use crate::obstacle::{Shape, Touch};

/// Round-off of distances, as a share of them.
const ROUND_OFF: f64 = 1e-9;

/// An obstacle that a spot may touch.
pub(super) struct Watched {
    /// Index of the obstacle.
    pub(super) obstacle: u32,
    /// Where the shape was asked last, in the axes of the obstacle, m.
    at: Vector,
    /// φ there is no less than this, m.
    least: f64,
    /// How far was looked, m; none: only φ was asked for.
    reach: Option<f64>,
    touches: Vec<Touch>,
}

impl Watched {
    /// An obstacle that is `distance` m from a place in its axes, or more.
    pub(super) fn new(obstacle: u32, at: Vector, distance: f64) -> Self {
        Self { obstacle, at, least: distance, reach: None, touches: Vec::new() }
    }

    /// Whether the obstacle is for certain as far as `reach` m from a place in its axes.
    pub(super) fn is_beyond(&self, x: &Vector, reach: f64) -> bool {
        self.least - (x - self.at).norm() > reach + ROUND_OFF * (self.least.abs() + self.at.amax())
    }

    /// See [`Shape::touches`].
    pub(super) fn touches(&mut self, shape: &dyn Shape, x: &Vector, reach: f64) -> &[Touch] {
        if self.is_beyond(x, reach) {
            return &[];
        }
        if self.reach != Some(reach) || self.at != *x {
            self.touches.clear();
            shape.touches(x, reach, &mut |touch| self.touches.push(touch));
            self.least = self.touches.iter().map(|touch| touch.distance).fold(reach, f64::min);
            (self.at, self.reach) = (*x, Some(reach));
        }
        &self.touches
    }
}
