//! Distance cache: the last query of an obstacle's shape near a contact point.
//!
//! The shape is queried again only if the result may differ: energy, forces and second derivatives at one state use the
//! same query, and since φ decreases by no more than the motion of the point, a distant obstacle needs no new query
//! after small motions. The result always equals that of a new query, so it depends on the state alone.

use crate::Vector;
use crate::obstacle::{Shape, Touch};

/// Round-off of distances, as a fraction of them.
const ROUND_OFF: f64 = 1e-9;

/// Cached distance of an obstacle from a contact point.
pub(super) struct CachedDistance {
    /// Index of the obstacle.
    pub(super) obstacle: u32,
    /// Position of the last query, in the axes of the obstacle, m.
    at: Vector,
    /// Lower bound of φ there, m.
    least: f64,
    /// Reach of the last query, m; `None` after a query of φ only.
    reach: Option<f64>,
    touches: Vec<Touch>,
}

impl CachedDistance {
    /// Cache of an obstacle at a distance of at least `distance` (m) from `at`, in its axes.
    pub(super) fn new(obstacle: u32, at: Vector, distance: f64) -> Self {
        Self { obstacle, at, least: distance, reach: None, touches: Vec::new() }
    }

    /// Whether the obstacle is certainly farther than `reach` (m) from `x`, in its axes.
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
