//! Shapes of bodies: triangle meshes out of files, and volumes that cables sweep.
//!
//! ```
//! use wireloom::harness::{Shape, ShapeFile};
//! use wireloom::geometry::Vector;
//! use wireloom::shapes::mesh::{Mesh, read};
//!
//! let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
//! let file = ShapeFile { name: "body.obj".into(), bytes: tetrahedron.into(), scale: 1.0 };
//! let body = Mesh::new(&read(&file).expect("an OBJ file"), false).expect("a closed surface");
//! assert!(body.distance(&Vector::new(0.1, 0.1, 0.1), 1.0) < 0.0, "inside");
//! ```

pub use wireloom_shapes::{mesh, swept};
