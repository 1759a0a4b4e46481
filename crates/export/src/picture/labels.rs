//! Names beside symbols: placed one after the other where they cover least, omitted where there is no room.

use super::layout::Panel;
use super::marks::{Kind, Mark, Marks};
use super::svg::{Svg, Text, fitted, width};
use super::view::visible;
use wireloom_core::StepResult;

/// Largest number of symbols that all have names.
pub const ALL_NAMED: usize = 40;
/// Number of constraints with names otherwise: those with the largest forces.
pub const NAMED_OF_MANY: usize = 12;

const SIZE: f64 = 10.5;
/// A name is cut to this width.
const WIDEST: f64 = 170.0;
/// Distances from the symbol that are tried, page units beyond its edge.
const DISTANCES: [f64; 4] = [4.0, 14.0, 28.0, 46.0];
/// Directions that are tried, in order of preference.
const DIRECTIONS: [[f64; 2]; 8] =
    [[1.0, -0.6], [-1.0, -0.6], [1.0, 0.6], [-1.0, 0.6], [0.0, -1.0], [0.0, 1.0], [1.0, 0.0], [-1.0, 0.0]];
/// Side of a cell of the raster of branches.
const CELL: f64 = 4.0;

type Box = [f64; 4];

/// Marks with names, in the order in which they are placed.
pub fn chosen(marks: &Marks) -> Vec<&Mark> {
    let mut named: Vec<&Mark> = marks.list.iter().filter(|mark| !mark.label.is_empty()).collect();
    named.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    if named.len() > ALL_NAMED {
        named.retain(|mark| mark.kind != Kind::Joint);
        let urgent = named.iter().filter(|mark| mark.kind.is_urgent()).count();
        named.truncate(NAMED_OF_MANY + urgent);
    }
    named
}

pub fn draw(page: &mut Svg, step: &StepResult, marks: &Marks, panel: &Panel) {
    let half = marks.half + 1.0;
    let symbols: Vec<Box> = marks
        .list
        .iter()
        .map(|mark| panel.place(&mark.position))
        .map(|[x, y]| [x - half, y - half, x + half, y + half])
        .collect();
    let mut ground = Ground { panel, half, raster: Raster::of(step, panel), symbols, names: Vec::new() };
    let mut placed = Vec::new();
    for mark in chosen(marks) {
        let at = panel.place(&mark.position);
        let widest = if mark.kind.is_urgent() { 2.0 * WIDEST } else { WIDEST };
        let text = fitted(&mark.label, SIZE, widest);
        let size = [width(&text, SIZE) + 2.0, SIZE + 1.0];
        if let Some((place, far)) = ground.find(at, size) {
            ground.names.push(place);
            placed.push((at, place, text, far, mark.kind.ink()));
        }
    }
    page.open("class=\"labels\"");
    for (at, place, ..) in placed.iter().filter(|(_, _, _, far, _)| *far) {
        page.line(*at, nearest(*at, place), "class=\"leader\" stroke=\"#555555\" stroke-width=\"0.6\"");
    }
    for (_, [x0, y0, x1, y1], text, _, fill) in &placed {
        page.rect([*x0, *y0], [x1 - x0, y1 - y0], "fill=\"#ffffff\" fill-opacity=\"0.72\"");
        page.text(&Text { size: SIZE, fill, class: "label", ..Text::at(x0 + 1.0, y1 - 2.6) }, text);
    }
    page.close();
}

/// Obstructions for a new name.
struct Ground<'a> {
    panel: &'a Panel,
    /// Half the width of a symbol, with its rim.
    half: f64,
    raster: Raster,
    symbols: Vec<Box>,
    /// Names that are placed.
    names: Vec<Box>,
}

impl Ground<'_> {
    /// The place that covers least: no other names and symbols, and as few branches as possible. Also whether it is
    /// so far away that it needs a line to its symbol.
    fn find(&self, at: [f64; 2], size: [f64; 2]) -> Option<(Box, bool)> {
        let mut best: Option<(f64, Box, bool)> = None;
        for (i, distance) in DISTANCES.into_iter().enumerate() {
            for (j, direction) in DIRECTIONS.into_iter().enumerate() {
                let place = beside(at, self.half + distance, size, direction);
                let taken = self.names.iter().chain(&self.symbols).any(|other| overlap(&place, other));
                if taken || !inside(&place, self.panel) {
                    continue;
                }
                let crossed = if i > 0 { self.crossed(at, nearest(at, &place)) } else { 0.0 };
                let cost = self.raster.covered(&place) + 2.2 * i as f64 + 0.1 * j as f64 + 4.0 * crossed;
                if best.as_ref().is_none_or(|(least, _, _)| cost < *least) {
                    best = Some((cost, place, i > 0));
                }
            }
        }
        best.map(|(_, place, far)| (place, far))
    }

    /// Names and foreign symbols that a line from a symbol to its name would cross, by samples.
    fn crossed(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let inside = |b: &&Box, [x, y]: [f64; 2]| b[0] < x && x < b[2] && b[1] < y && y < b[3];
        let samples = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]
            .map(|t| [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
        let others = self.names.iter().chain(self.symbols.iter().filter(|b| !inside(b, from)));
        others.filter(|b| samples.iter().any(|p| inside(b, *p))).count() as f64
    }
}

/// The point of a box nearest to `at`.
fn nearest(at: [f64; 2], [x0, y0, x1, y1]: &Box) -> [f64; 2] {
    [at[0].clamp(*x0, *x1), at[1].clamp(*y0, *y1)]
}

/// The box of a text whose nearest edge or corner lies in `direction` at `distance`.
fn beside(at: [f64; 2], distance: f64, [w, h]: [f64; 2], [u, v]: [f64; 2]) -> Box {
    let centre = [at[0] + u * distance + 0.5 * w * u.signum() * f64::from(u != 0.0), at[1] + v * (distance + 0.5 * h)];
    [centre[0] - 0.5 * w, centre[1] - 0.5 * h, centre[0] + 0.5 * w, centre[1] + 0.5 * h]
}

fn inside(b: &Box, panel: &Panel) -> bool {
    let ([x, y], [w, h]) = (panel.corner, panel.size);
    b[0] >= x + 2.0 && b[1] >= y + 2.0 && b[2] <= x + w - 2.0 && b[3] <= y + h - 2.0
}

fn overlap(a: &Box, b: &Box) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Cells of a view that branches cover.
struct Raster {
    corner: [f64; 2],
    columns: usize,
    rows: usize,
    filled: Vec<bool>,
}

impl Raster {
    fn of(step: &StepResult, panel: &Panel) -> Self {
        let [columns, rows] = panel.size.map(|side| (side / CELL).ceil() as usize + 1);
        let mut raster = Self { corner: panel.corner, columns, rows, filled: vec![false; columns * rows] };
        for branch in &step.branches {
            for edge in branch.position.windows(2).filter(|edge| edge.iter().all(visible)) {
                let [a, b] = [panel.place(&edge[0]), panel.place(&edge[1])];
                let samples = ((b[0] - a[0]).hypot(b[1] - a[1]) / CELL).ceil().max(1.0) as usize;
                for k in 0..=samples {
                    let t = k as f64 / samples as f64;
                    raster.fill([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
                }
            }
        }
        raster
    }

    fn fill(&mut self, [x, y]: [f64; 2]) {
        let (i, j) = self.cell([x, y]);
        self.filled[j * self.columns + i] = true;
    }

    fn cell(&self, [x, y]: [f64; 2]) -> (usize, usize) {
        let index = |value: f64, last: usize| ((value / CELL).max(0.0) as usize).min(last);
        (index(x - self.corner[0], self.columns - 1), index(y - self.corner[1], self.rows - 1))
    }

    /// Filled cells under a box.
    fn covered(&self, b: &Box) -> f64 {
        let ((i0, j0), (i1, j1)) = (self.cell([b[0], b[1]]), self.cell([b[2], b[3]]));
        let mut count = 0.0;
        for j in j0..=j1 {
            count += self.filled[j * self.columns + i0..=j * self.columns + i1].iter().filter(|f| **f).count() as f64;
        }
        count
    }
}
