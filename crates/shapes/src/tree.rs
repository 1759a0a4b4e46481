//! Adapter of `parry`: trees of boxes, and triangles. Points go in and numbers come out; none of its types is seen
//! outside.

use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector as Point;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhLeafCost, BvhNode, TraversalAction};
use parry3d_f64::query::details::local_ray_intersection_with_triangle;
use parry3d_f64::query::{PointQueryWithLocation, Ray};
use parry3d_f64::shape::{Triangle, TrianglePointLocation};
use wireloom_core::Vector;

fn point(x: &Vector) -> Point {
    Point::new(x.x, x.y, x.z)
}

fn vector(x: &Point) -> Vector {
    Vector::new(x.x, x.y, x.z)
}

/// Least and greatest coordinates.
pub(crate) type Corners = [Vector; 2];

/// Boxes by number, found by where they are.
pub(crate) struct Tree(Bvh);

/// Result of a search in a box, with its cost.
pub(crate) struct Found<T> {
    pub cost: f64,
    pub what: T,
}

impl<T> BvhLeafCost for Found<T> {
    fn cost(&self) -> f64 {
        self.cost
    }
}

impl Tree {
    /// Boxes of these numbers.
    pub fn of(boxes: impl Iterator<Item = (usize, Corners)>) -> Self {
        let boxes = boxes.map(|(k, [low, high])| (k, Aabb::new(point(&low), point(&high))));
        Self(Bvh::from_iter(BvhBuildStrategy::Binned, boxes))
    }

    /// Box about all of them.
    pub fn corners(&self) -> Corners {
        let all = self.0.root_aabb();
        [vector(&all.mins), vector(&all.maxs)]
    }

    /// Nearest item to `x` that is nearer than `reach`. `look` searches a box for an item nearer than the best so far;
    /// the cost is the distance.
    pub fn nearest<T>(&self, x: &Vector, reach: f64, look: impl Fn(u32, f64) -> Option<Found<T>>) -> Option<Found<T>> {
        let x = point(x);
        let to_box = |node: &BvhNode, _| distance_to_box(&x, &node.mins(), &node.maxs());
        self.0.find_best(reach, to_box, look).map(|(_, found)| found)
    }

    /// All boxes that are nearer than `reach` to `x`.
    pub fn within(&self, x: &Vector, reach: f64, mut see: impl FnMut(u32)) {
        let x = point(x);
        self.0.traverse(|node| {
            if distance_to_box(&x, &node.mins(), &node.maxs()) >= reach {
                return TraversalAction::Prune;
            }
            if let Some(number) = node.leaf_data() {
                see(number);
            }
            TraversalAction::Continue
        });
    }

    /// First item that a straight path meets, before this fraction of it. `look` searches a box for an item met before
    /// the best so far; the cost is the fraction.
    pub fn first_hit<T>(
        &self,
        from: &Vector,
        way: &Vector,
        before: f64,
        look: impl Fn(u32, f64) -> Option<Found<T>>,
    ) -> Option<Found<T>> {
        let ray = Ray::new(point(from), point(way));
        self.0.find_best(before, |node, best| node.cast_ray(&ray, best), look).map(|(_, found)| found)
    }
}

fn distance_to_box(x: &Point, low: &Point, high: &Point) -> f64 {
    (*low - *x).max(*x - *high).max(Point::ZERO).length()
}

/// Feature of a triangle that a point is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feature {
    /// Within it.
    Face,
    /// On the edge from this corner to the next one.
    Edge(usize),
    /// At this corner.
    Corner(usize),
}

/// The place of a triangle that is nearest to `x`.
pub(crate) fn nearest_of_triangle(x: &Vector, [a, b, c]: &[Vector; 3]) -> (Vector, Feature) {
    let triangle = Triangle::new(point(a), point(b), point(c));
    let (place, location) = triangle.project_local_point_and_get_location(point(x), false);
    let feature = match location {
        TrianglePointLocation::OnVertex(k) => Feature::Corner(k as usize),
        TrianglePointLocation::OnEdge(k, _) => Feature::Edge(k as usize),
        TrianglePointLocation::OnFace(..) | TrianglePointLocation::OnSolid => Feature::Face,
    };
    (vector(&place.point), feature)
}

/// Fraction of a straight path at which it passes through a triangle, from either side; it may be beyond its end.
pub(crate) fn hit_of_triangle(from: &Vector, way: &Vector, [a, b, c]: &[Vector; 3]) -> Option<f64> {
    let ray = Ray::new(point(from), point(way));
    local_ray_intersection_with_triangle(point(a), point(b), point(c), &ray).map(|(hit, _)| hit.time_of_impact)
}
