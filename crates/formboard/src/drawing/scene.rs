//! What is drawn, in mm from the lower left corner of the board.

use super::Drawing;
use super::table::millimetres;
use crate::line::{Line, Point, unit};
use crate::{Holds, Peg, Place, SHEET};
use std::f64::consts::PI;

/// Layers, from below to above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layer {
    Board,
    Sheets,
    Cables,
    Clips,
    Pegs,
    Ends,
    Forks,
    Dimensions,
    Labels,
}

impl Layer {
    pub const ALL: [Layer; 9] = [
        Layer::Board,
        Layer::Sheets,
        Layer::Cables,
        Layer::Clips,
        Layer::Pegs,
        Layer::Ends,
        Layer::Forks,
        Layer::Dimensions,
        Layer::Labels,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Layer::Board => "board",
            Layer::Sheets => "sheets",
            Layer::Cables => "cables",
            Layer::Clips => "clips",
            Layer::Pegs => "pegs",
            Layer::Ends => "ends",
            Layer::Forks => "forks",
            Layer::Dimensions => "dimensions",
            Layer::Labels => "labels",
        }
    }

    /// Whether it shows the board alone, and nothing of the harness.
    pub fn is_background(self) -> bool {
        matches!(self, Layer::Board | Layer::Sheets)
    }

    /// Red, green, blue.
    pub fn colour(self) -> [u8; 3] {
        match self {
            Layer::Board => [0, 0, 0],
            Layer::Sheets => [190, 190, 190],
            Layer::Cables => [70, 90, 110],
            Layer::Clips => [0, 130, 60],
            Layer::Pegs => [200, 110, 0],
            Layer::Ends => [20, 60, 200],
            Layer::Forks => [160, 0, 120],
            Layer::Dimensions => [110, 110, 110],
            Layer::Labels => [0, 0, 0],
        }
    }
}

/// Where a text stands beside its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Left,
    Middle,
    Right,
}

impl Anchor {
    /// Where a text of this width begins and ends along its line, from its point.
    pub fn reach(self, width: f64) -> [f64; 2] {
        match self {
            Anchor::Left => [0.0, width],
            Anchor::Middle => [-0.5 * width, 0.5 * width],
            Anchor::Right => [-width, 0.0],
        }
    }
}

/// A part of the drawing.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    /// A centre line with a width.
    Cable {
        line: Line,
        width: f64,
    },
    Segment(Point, Point),
    Circle {
        centre: Point,
        radius: f64,
    },
    /// A closed line.
    Polygon(Vec<Point>),
    /// `turn`: rad.
    Text {
        at: Point,
        height: f64,
        turn: f64,
        anchor: Anchor,
        text: String,
    },
    /// Distance of two points, drawn beside them.
    Dimension {
        from: Point,
        to: Point,
        beside: f64,
        height: f64,
        text: String,
    },
}

/// Parts of a dimension, or of another shape made of simpler ones.
impl Shape {
    /// Lines and text of a dimension; nothing of other shapes.
    pub fn dimension_parts(&self) -> Vec<Shape> {
        let Shape::Dimension { from, to, beside, height, text } = self else { return Vec::new() };
        let along = (to - from).try_normalize(1e-9).unwrap_or_else(Point::x);
        let across = Point::new(-along.y, along.x);
        let (a, b) = (from + across * *beside, to + across * *beside);
        let over = across * (beside + 0.3 * height.copysign(*beside));
        let tick = (along + across) * (0.3 * height);
        let mut turn = along.y.atan2(along.x);
        // Readable from below and from the right.
        if !(-0.5 * PI + 1e-6..=0.5 * PI + 1e-6).contains(&turn) {
            turn += PI;
        }
        let up = Point::new(-turn.sin(), turn.cos());
        let middle = (a + b) * 0.5 + up * (0.25 * height);
        vec![
            Shape::Segment(*from, from + over),
            Shape::Segment(*to, to + over),
            Shape::Segment(a, b),
            Shape::Segment(a - tick, a + tick),
            Shape::Segment(b - tick, b + tick),
            Shape::Text { at: middle, height: *height, turn, anchor: Anchor::Middle, text: text.clone() },
        ]
    }
}

/// Heights of texts, mm.
const LABEL: f64 = 4.0;
const LEAST_LABEL: f64 = 1.5;
/// Radius of a peg, mm.
const PEG: f64 = 2.5;
/// Size of the symbol of a connector, mm.
const CONNECTOR: [f64; 2] = [16.0, 10.0];
/// Distance of a dimension line from the surface of its cable, mm.
const BESIDE: f64 = 4.0;

/// The drawing.
pub(crate) fn scene(drawing: &Drawing<'_>) -> Vec<(Layer, Shape)> {
    let (board, harness) = (drawing.board, drawing.harness);
    let mm = |p: Point| p * 1e3;
    let mut all = Vec::new();
    let [width, height] = board.size.map(|x| x * 1e3);
    let corner = Point::new;
    all.push((
        Layer::Board,
        Shape::Polygon(vec![corner(0.0, 0.0), corner(width, 0.0), corner(width, height), corner(0.0, height)]),
    ));
    if let Some([columns, rows]) = board.sheets {
        for k in 1..columns {
            let x = k as f64 * SHEET[0] * 1e3;
            all.push((Layer::Sheets, Shape::Segment(corner(x, 0.0), corner(x, height))));
        }
        for k in 1..rows {
            let y = k as f64 * SHEET[1] * 1e3;
            all.push((Layer::Sheets, Shape::Segment(corner(0.0, y), corner(width, y))));
        }
    }
    for (branch, line) in harness.branches.iter().zip(&board.lines) {
        let own = Line {
            start: mm(line.start),
            direction: line.direction,
            curvature: line.curvature * 1e-3,
            length: line.length * 1e3,
        };
        let radius = 500.0 * branch.diameter;
        all.push((Layer::Cables, Shape::Cable { line: own, width: 2.0 * radius }));
        let text_height = (own.length / 8.0).clamp(LEAST_LABEL, LABEL);
        let text = format!("{}  {}", branch.name, millimetres(line.length));
        if line.curvature == 0.0 {
            let beside = radius + BESIDE * text_height / LABEL;
            let (from, to, height) = (own.start, own.end(), text_height);
            all.push((Layer::Dimensions, Shape::Dimension { from, to, beside, height, text }));
        } else {
            let middle = 0.5 * own.length;
            let direction = own.direction_at(middle);
            let at = own.at(middle) + unit(direction + 0.5 * PI) * (radius + 0.5 * text_height);
            let text = format!("{text} R{}", millimetres(1.0 / line.curvature.abs()));
            let turn = if direction.cos() < 0.0 { direction + PI } else { direction };
            let anchor = Anchor::Middle;
            all.push((Layer::Dimensions, Shape::Text { at, height: text_height, turn, anchor, text }));
        }
        for clip in &branch.clips {
            let (centre, along) = (own.at(clip.s * 1e3), unit(own.direction_at(clip.s * 1e3)));
            all.push((Layer::Clips, Shape::Polygon(rectangle(centre, along, [6.0, 2.0 * radius + 6.0]))));
            let at = centre - Point::new(-along.y, along.x) * (radius + 4.0 + LABEL);
            all.push((Layer::Labels, label(at, Anchor::Middle, &clip.name)));
        }
    }
    for peg in &board.pegs {
        let centre = mm(peg.position);
        all.push((Layer::Pegs, Shape::Circle { centre, radius: PEG }));
        mark(drawing, peg, centre, &mut all);
    }
    let end = Point::new(0.0, height);
    let size = format!(
        "{}: board {} mm x {} mm, 1:1, {} branches, {:.2} m of cable",
        drawing.title,
        millimetres(board.size[0]),
        millimetres(board.size[1]),
        harness.branches.len(),
        harness.branches.iter().map(|branch| branch.length).sum::<f64>()
    );
    let at = end + Point::new(5.0, 5.0);
    all.push((Layer::Board, Shape::Text { at, height: 8.0, turn: 0.0, anchor: Anchor::Left, text: size }));
    all.sort_by_key(|(layer, _)| Layer::ALL.iter().position(|other| other == layer));
    all
}

/// Symbol and name of an end or a fork.
fn mark(drawing: &Drawing<'_>, peg: &Peg, centre: Point, all: &mut Vec<(Layer, Shape)>) {
    let harness = drawing.harness;
    match (peg.holds, peg.at) {
        (Holds::Joint, Place::Vertex(vertex)) => {
            all.push((Layer::Forks, Shape::Circle { centre, radius: 2.0 * PEG }));
            let at = centre + Point::new(1.5 * PEG, 1.5 * PEG);
            all.push((Layer::Labels, label(at, Anchor::Left, &harness.vertices[vertex].name)));
        }
        (Holds::End, Place::Vertex(vertex)) => {
            let found = harness.branches.iter().position(|branch| branch.ends.contains(&vertex));
            let Some(branch) = found else { return };
            let line = &drawing.board.lines[branch];
            let outward = if harness.branches[branch].ends[1] == vertex && line_ends(drawing, branch, centre) {
                line.direction_at(line.length)
            } else {
                line.direction + PI
            };
            end(all, centre, outward, harness.vertices[vertex].part.is_some(), harness.vertices[vertex].label());
        }
        (Holds::End, Place::Cut(branch)) => {
            let line = &drawing.board.lines[branch];
            let name = format!("{} (cut)", harness.branches[branch].name);
            end(all, centre, line.direction_at(line.length), false, &name);
        }
        _ => {}
    }
}

/// Whether a branch ends at a point, mm.
fn line_ends(drawing: &Drawing<'_>, branch: usize, at: Point) -> bool {
    (drawing.board.lines[branch].end() * 1e3 - at).norm() < 1e-3
}

fn end(all: &mut Vec<(Layer, Shape)>, centre: Point, outward: f64, connector: bool, name: &str) {
    let along = unit(outward);
    let [length, width] = if connector { CONNECTOR } else { [4.0, 4.0] };
    all.push((Layer::Ends, Shape::Polygon(rectangle(centre + along * (0.5 * length), along, [length, width]))));
    let at = centre + along * (length + 2.0) - Point::new(0.0, 0.35 * LABEL);
    let anchor = if along.x < -0.2 {
        Anchor::Right
    } else if along.x > 0.2 {
        Anchor::Left
    } else {
        Anchor::Middle
    };
    let at = at + Point::new(0.0, if anchor == Anchor::Middle { along.y * 0.5 * LABEL } else { 0.0 });
    all.push((Layer::Labels, label(at, anchor, name)));
}

fn label(at: Point, anchor: Anchor, text: &str) -> Shape {
    Shape::Text { at, height: LABEL, turn: 0.0, anchor, text: text.to_owned() }
}

/// A rectangle of length and width about a point.
fn rectangle(centre: Point, along: Point, [length, width]: [f64; 2]) -> Vec<Point> {
    let (a, b) = (along * (0.5 * length), Point::new(-along.y, along.x) * (0.5 * width));
    vec![centre - a - b, centre + a - b, centre + a + b, centre - a + b]
}
