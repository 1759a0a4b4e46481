//! The branches of one view: pieces of one colour, the far ones first.

use super::colour::{INK, Paint};
use super::layout::Panel;
use super::limits::Limits;
use super::svg::{Svg, number};
use super::view::{radius, visible};
use wireloom_core::StepResult;
use wireloom_core::equilibrium::BranchResult;

/// Thinnest line, page units: 0.4 mm on paper.
pub const THINNEST: f64 = 1.6;
/// A piece ends after this many page units, so that it has one depth.
const LONGEST_PIECE: f64 = 24.0;
/// Nodes nearer to the last one drawn than this are skipped: 0.1 mm on paper.
const SHORTEST_EDGE: f64 = 0.4;
/// White rim on either side, which shows the nearer of two crossing branches.
const RIM: f64 = 0.9;

struct Piece {
    nearness: f64,
    width: f64,
    paint: Paint,
    points: Vec<[f64; 2]>,
}

pub fn draw(page: &mut Svg, step: &StepResult, limits: &Limits, panel: &Panel) {
    let mut pieces = Vec::new();
    for branch in &step.branches {
        cut(branch, limits, panel, &mut pieces);
    }
    pieces.sort_by(|a, b| a.nearness.total_cmp(&b.nearness));
    page.open("class=\"branches\" fill=\"none\" stroke-linejoin=\"round\"");
    for piece in &pieces {
        let path = path(&piece.points);
        let (rim, width) = (number(piece.width + 2.0 * RIM), number(piece.width));
        let ink = if piece.paint.is_beyond() { INK } else { "#ffffff" };
        page.raw(&format!("<path d=\"{path}\" stroke=\"{ink}\" stroke-width=\"{rim}\"/>"));
        let hex = piece.paint.hex();
        let cap = "stroke-linecap=\"round\"";
        page.raw(&format!("<path class=\"piece\" d=\"{path}\" stroke=\"{hex}\" stroke-width=\"{width}\" {cap}/>"));
    }
    page.close();
}

/// Line width of a cable with this diameter (m), page units.
pub fn line_width(diameter: f64, scale: f64) -> f64 {
    (2.0 * radius(diameter) * scale).max(THINNEST)
}

/// Cuts a branch where its colour changes, where a piece becomes long, and where a node cannot be drawn.
fn cut(branch: &BranchResult, limits: &Limits, panel: &Panel, pieces: &mut Vec<Piece>) {
    let last = branch.position.len().saturating_sub(1);
    let mut open: Option<Run> = None;
    for j in 0..last {
        let [a, b] = [&branch.position[j], &branch.position[j + 1]];
        if !visible(a) || !visible(b) {
            pieces.extend(open.take().map(Run::finish));
            continue;
        }
        let paint = Paint::of(branch, j, limits);
        let width = line_width(branch.diameter_at(j).min(branch.diameter_at(j + 1)), panel.scale);
        let goes_on = |run: &Run| run.paint == paint && run.width == width && run.length <= LONGEST_PIECE;
        if !open.as_ref().is_some_and(goes_on) {
            pieces.extend(open.take().map(Run::finish));
        }
        let nearness = panel.view.nearness(a);
        let run = open.get_or_insert_with(|| Run::start(panel.place(a), nearness, (paint, width)));
        run.go_to(panel.place(b), panel.view.nearness(b));
    }
    pieces.extend(open.take().map(Run::finish));
}

/// A piece that is not complete.
struct Run {
    paint: Paint,
    width: f64,
    points: Vec<[f64; 2]>,
    /// The last node, where it was too near to be drawn.
    pending: Option<[f64; 2]>,
    length: f64,
    nearness: f64,
    nodes: f64,
}

impl Run {
    fn start(at: [f64; 2], nearness: f64, (paint, width): (Paint, f64)) -> Self {
        Self { paint, width, points: vec![at], pending: None, length: 0.0, nearness, nodes: 1.0 }
    }

    fn go_to(&mut self, to: [f64; 2], nearness: f64) {
        let from = self.points[self.points.len() - 1];
        let edge = (to[0] - from[0]).hypot(to[1] - from[1]);
        if edge < SHORTEST_EDGE {
            self.pending = Some(to);
        } else {
            self.pending = None;
            self.points.push(to);
            self.length += edge;
        }
        self.nearness += nearness;
        self.nodes += 1.0;
    }

    fn finish(mut self) -> Piece {
        self.points.extend(self.pending);
        Piece { nearness: self.nearness / self.nodes, width: self.width, paint: self.paint, points: self.points }
    }
}

fn path(points: &[[f64; 2]]) -> String {
    let mut d = String::new();
    for (i, [x, y]) in points.iter().enumerate() {
        d.push(if i == 0 { 'M' } else { 'L' });
        d += &number(*x);
        d.push(' ');
        d += &number(*y);
    }
    d
}
