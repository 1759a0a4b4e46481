//! Distance cache: the last answer of an obstacle's shape near a contact point.
//!
//! A shape is asked again only where its answer may differ: at one state energy, forces and second derivatives need the
//! same answer, and as φ falls no faster than the point moves, what was far enough away needs no second query while
//! the point has hardly moved. Either way the answer is the one that the shape would give: it depends on the state
//! alone.

use crate::Vector;
use crate::obstacle::{Shape, Touch};

/// Round-off of distances, as a fraction of them.
const ROUND_OFF: f64 = 1e-9;

/// Distance of an obstacle that a contact point may touch.
pub(super) struct CachedDistance {
    /// Index of the obstacle.
    pub(super) obstacle: u32,
    /// Position of the last query, in the axes of the obstacle, m.
    at: Vector,
    /// Lower bound of φ there, m.
    least: f64,
    /// Reach of the last query, m; none: of φ only.
    reach: Option<f64>,
    touches: Vec<Touch>,
}

impl CachedDistance {
    /// Obstacle that is at least `distance` m from a place in its axes.
    pub(super) fn new(obstacle: u32, at: Vector, distance: f64) -> Self {
        Self { obstacle, at, least: distance, reach: None, touches: Vec::new() }
    }

    /// Whether the obstacle is certainly farther than `reach` m from a place in its axes.
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
