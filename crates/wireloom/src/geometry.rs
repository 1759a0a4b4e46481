//! Vectors, rotations and poses: positions in m, frames as unit quaternions whose column d3 is along the cable.
//!
//! ```
//! use wireloom::geometry::{Pose, Vector, columns, frame_from};
//!
//! let orientation = frame_from(&Vector::x(), &Vector::z()).expect("not parallel");
//! let plug = Pose { position: Vector::new(0.1, 0.0, 0.0), orientation };
//! let [_, _, tangent] = columns(&plug.orientation);
//! assert!((tangent - Vector::x()).norm() < 1e-12);
//! ```

pub use wireloom_core::rotation::{columns, frame_from, orthogonal, shortest};
pub use wireloom_core::{Matrix, Pose, Rotation, Vector};
