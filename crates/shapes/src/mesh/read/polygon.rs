//! Polygons of mesh files.

/// Triangles of a convex polygon, all with its first corner.
pub(super) fn fan(polygon: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    polygon.windows(2).skip(1).map(|pair| [polygon[0], pair[0], pair[1]])
}
