//! Obstacles in one view: flat shapes with an outline, behind the cables, clipped at the frame.
//!
//! Corners are rounded to a raster that is coarsened until the visible side has a few thousand triangles, so that an
//! obstacle of millions of triangles needs little space.

use super::layout::Panel;
use super::svg::{Svg, number};
use super::view::{Scene, visible};
use crate::xml::escape;
use std::collections::{BTreeMap, BTreeSet};
use wireloom_core::obstacle::{Obstacle, Surface};
use wireloom_core::{StepResult, Vector};

/// Largest number of triangles that are drawn of an obstacle.
const MANY: usize = 3000;
/// The finest raster, page units.
const FINEST: f64 = 0.5;
/// Size of an unbounded obstacle, in units of the largest distance of the scene from the origin.
const BEYOND: f64 = 8.0;

/// An obstacle at its pose.
pub struct Body<'a> {
    name: &'a str,
    surface: Surface,
}

/// The obstacles of a step, in world axes.
pub fn stand<'a>(step: &StepResult, obstacles: &'a [Obstacle], scene: &Scene) -> Vec<Body<'a>> {
    let reach = scene.low.iter().chain(&scene.high).fold(0.0, |reach: f64, c| reach.max(c.abs()));
    let body = |(obstacle, now): (&'a Obstacle, &wireloom_core::equilibrium::ObstacleResult)| {
        let pose = now.pose;
        let mut surface = obstacle.shape.surface(BEYOND * (reach + pose.position.norm()));
        surface.corners.iter_mut().for_each(|x| *x = pose.position + pose.orientation * *x);
        Body { name: &obstacle.name, surface }
    };
    obstacles.iter().zip(&step.obstacles).map(body).collect()
}

/// Draws them, the far ones first.
pub fn draw(page: &mut Svg, bodies: &[Body<'_>], panel: &Panel) {
    if bodies.is_empty() {
        return;
    }
    let nearness = |body: &Body<'_>| {
        let corners = &body.surface.corners;
        corners.iter().map(|x| panel.view.nearness(x)).sum::<f64>() / corners.len() as f64
    };
    let mut sorted: Vec<&Body<'_>> = bodies.iter().collect();
    sorted.sort_by(|a, b| nearness(a).total_cmp(&nearness(b)));
    let ([x, y], [w, h], view) = (panel.corner.map(number), panel.size.map(number), panel.view.name());
    page.raw(&format!(
        "<clipPath id=\"frame-{view}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>"
    ));
    page.open(&format!("class=\"obstacles\" clip-path=\"url(#frame-{view})\" stroke-linejoin=\"round\""));
    for body in sorted {
        let (fill, outline) = seen(&body.surface, panel);
        page.open("class=\"obstacle\"");
        page.raw(&format!("<title>{}</title>", escape(body.name)));
        page.raw(&format!("<path d=\"{fill}\" fill=\"#e8ecf0\" fill-opacity=\"0.8\"/>"));
        page.raw(&format!("<path d=\"{outline}\" fill=\"none\" stroke=\"#9aa5b1\" stroke-width=\"0.9\"/>"));
        page.close();
    }
    page.close();
}

/// A point of the raster.
type Cell = [i64; 2];

/// The visible side of a surface, filled, and its outlines.
fn seen(surface: &Surface, panel: &Panel) -> (String, String) {
    let places: Vec<Option<[f64; 2]>> =
        surface.corners.iter().map(|x: &Vector| visible(x).then(|| panel.place(x))).collect();
    let mut cell = FINEST;
    loop {
        let (faces, edges) = on_raster(surface, &places, panel, cell);
        if faces.len() <= MANY || cell > panel.size[0] {
            let at = |c: &Cell| format!("{} {}", number(c[0] as f64 * cell), number(c[1] as f64 * cell));
            let fill: String = faces.iter().map(|[a, b, c]| format!("M{}L{}L{}Z", at(a), at(b), at(c))).collect();
            let outline = edges.iter().map(|[a, b]| format!("M{}L{}", at(a), at(b))).collect();
            return (fill, outline);
        }
        cell *= 2.0;
    }
}

/// The triangles that face the eye, each once; edges of only one of them; edges of triangles that are seen edge-on.
fn on_raster(
    surface: &Surface,
    places: &[Option<[f64; 2]>],
    panel: &Panel,
    cell: f64,
) -> (BTreeSet<[Cell; 3]>, BTreeSet<[Cell; 2]>) {
    let snap = |place: [f64; 2]| place.map(|c| (c / cell).round() as i64);
    let beside = |cells: &[Cell; 3]| {
        (0..2).any(|i| {
            let all = cells.map(|c| c[i] as f64 * cell);
            all.iter().all(|c| *c < panel.corner[i]) || all.iter().all(|c| *c > panel.corner[i] + panel.size[i])
        })
    };
    let (mut faces, mut flat) = (BTreeSet::new(), BTreeSet::new());
    for t in &surface.triangles {
        let [Some(a), Some(b), Some(c)] = t.map(|k| places[k as usize]) else { continue };
        let mut cells = [a, b, c].map(snap);
        if beside(&cells) {
            continue;
        }
        // The second axis of the page points down, which reverses the sense of rotation.
        let [[ax, ay], [bx, by], [cx, cy]] = cells.map(|c| c.map(|c| c as f64));
        let turn = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        if turn == 0.0 {
            let longest = [[cells[0], cells[1]], [cells[1], cells[2]], [cells[2], cells[0]]];
            flat.extend(longest.into_iter().filter(|[a, b]| a != b).map(|[a, b]| if a < b { [a, b] } else { [b, a] }));
        } else if turn < 0.0 {
            let first = (0..3).min_by_key(|k| cells[*k]).unwrap_or(0);
            cells.rotate_left(first);
            faces.insert(cells);
        }
    }
    let mut count: BTreeMap<[Cell; 2], usize> = BTreeMap::new();
    for [a, b, c] in &faces {
        for [a, b] in [[*a, *b], [*b, *c], [*c, *a]] {
            *count.entry(if a < b { [a, b] } else { [b, a] }).or_default() += 1;
        }
    }
    let mut edges: BTreeSet<[Cell; 2]> = count.iter().filter(|(_, n)| **n == 1).map(|(edge, _)| *edge).collect();
    // A triangle seen edge-on is a line, unless a face covers it.
    edges.extend(flat.into_iter().filter(|edge| count.get(edge) != Some(&2)));
    (faces, edges)
}
