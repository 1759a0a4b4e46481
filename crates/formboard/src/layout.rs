//! The layout of a harness: centre lines on a board, of true length.

use crate::clearance::Rules;
use crate::line::{Line, Point};
use crate::search::{Limits, STEP, search};
use crate::tree::{Strand, Tree};
use crate::unfold::{Edge, Turning, unfold};
use std::f64::consts::{PI, TAU};

/// Zones of forks that are tried, one after the other.
const ZONES: [f64; 3] = [8.0, 12.0, 18.0];

/// Least angle between arms, rad.
const ANGLE: f64 = PI / 12.0;

/// Distance between pieces that are not connected, m, beside radii and gap.
const PIECES: f64 = 0.05;

/// What is laid.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    pub vertices: usize,
    pub strands: Vec<Strand>,
    /// As [`Edge::leaves_at`].
    pub leaves_at: Vec<[f64; 2]>,
}

/// What the layout must keep to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    /// Distance between the surfaces of branches, m.
    pub gap: f64,
    /// Largest width and height, m.
    pub board: Option<[f64; 2]>,
}

/// Centre lines on a board.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// In the order and the sense of the strands, from the lower left corner of the box around all of them.
    pub lines: Vec<Line>,
    /// Strands that close loops: they are laid from their first vertex, and end beside their second one.
    pub cut: Vec<usize>,
    /// Strands of trunks.
    pub trunk: Vec<usize>,
    /// Width and height, m.
    pub size: [f64; 2],
    /// Two places may be nearer than their radii and the gap demand if the way between them is at most so many times
    /// this distance.
    pub zone: f64,
    /// Whether the trunks are straight.
    pub straight: bool,
}

/// The layout of a graph, or the least size that was found for it without a limit, if the board is too small.
pub(crate) fn lay_out(graph: &Graph, room: &Room) -> Result<Layout, [f64; 2]> {
    let (graph, cut) = opened(graph);
    let edges = edges(&graph);
    let towards_drawn = unfold(graph.vertices, &edges, Turning::Daylight);
    let closed = vec![false; graph.strands.len()];
    let mut laid: Vec<Laid> = Vec::new();
    let mut fits = true;
    for piece in towards_drawn.pieces.iter().filter(|piece| piece.vertices.len() > 1) {
        let start = Tree::new(piece, &graph.strands, &closed, &towards_drawn.points);
        let wedges = || {
            let all = unfold(graph.vertices, &edges, Turning::Wedges);
            Tree::new(piece, &graph.strands, &closed, &all.points)
        };
        let on_board = room.board.map(|_| lay_piece(&start, wedges, room));
        laid.push(match on_board {
            Some(Some(found)) => found,
            own => {
                fits &= own.is_none();
                let free = Room { board: None, ..*room };
                lay_piece(&start, wedges, &free).unwrap_or_else(|| in_wedges(wedges(), room.gap))
            }
        });
    }
    let layout = together(&graph, laid, cut, room);
    let [width, height] = layout.size;
    fits &= room.board.is_none_or(|[w, h]| width <= w && height <= h);
    if fits { Ok(layout) } else { Err(layout.size) }
}

/// A graph without loops: every strand that closes one ends at a vertex of its own instead of its second one.
fn opened(graph: &Graph) -> (Graph, Vec<usize>) {
    let closing = unfold(graph.vertices, &edges(graph), Turning::Wedges).closing;
    let mut graph = graph.clone();
    for &strand in &closing {
        graph.strands[strand].ends[1] = graph.vertices;
        graph.vertices += 1;
    }
    (graph, closing)
}

fn edges(graph: &Graph) -> Vec<Edge> {
    let both = graph.strands.iter().zip(&graph.leaves_at);
    both.map(|(strand, &leaves_at)| Edge { ends: strand.ends, length: strand.length, leaves_at }).collect()
}

struct Laid {
    tree: Tree,
    zone: f64,
}

/// A piece: with the narrowest zones around forks that the search finds a layout for.
fn lay_piece(start: &Tree, wedges: impl Fn() -> Tree, room: &Room) -> Option<Laid> {
    let limits = |zone: f64, angle: f64| Limits { rules: Rules { gap: room.gap, zone, angle }, board: room.board };
    let mut rounded = start.clone();
    rounded.straighten();
    rounded.round_directions(STEP);
    let tried = ZONES.iter().enumerate().find_map(|(k, &zone)| {
        let tree = search(&rounded, &limits(zone, ANGLE), k as u64)?;
        Some(Laid { tree, zone })
    });
    // A board is filled from the side of a straight trunk, or not at all.
    tried.or_else(|| {
        if room.board.is_some() {
            return None;
        }
        let wedges = in_wedges(wedges(), room.gap);
        let tree = search(&wedges.tree, &limits(wedges.zone, angle_of(&wedges.tree)), 0)?;
        Some(Laid { tree, zone: wedges.zone })
    })
}

fn leaves(tree: &Tree) -> f64 {
    let outer = tree.limbs.iter().enumerate().filter(|(k, limb)| limb.last == k + 1).count();
    (outer + 1) as f64
}

/// The least angle between arms in wedges.
fn angle_of(tree: &Tree) -> f64 {
    ANGLE.min(TAU / leaves(tree) * (1.0 - 1e-9))
}

/// A piece in wedges of equal angle per leaf. It keeps the rules by construction (`Turning::Wedges`), with zones that
/// grow with the number n of leaves: places with a distance D are at most `D / sin(π/n)` apart along the harness.
fn in_wedges(tree: Tree, gap: f64) -> Laid {
    let zone = ZONES[0].max((1.0 + 1e-9) / (PI / leaves(&tree)).sin());
    debug_assert!(tree.breaches(&Rules { gap, zone, angle: angle_of(&tree) }).is_empty());
    Laid { tree, zone }
}

/// All pieces, one below the other.
fn together(graph: &Graph, laid: Vec<Laid>, cut: Vec<usize>, room: &Room) -> Layout {
    let none = Line { start: Point::zeros(), direction: 0.0, curvature: 0.0, length: 0.0 };
    let mut layout = Layout {
        lines: vec![none; graph.strands.len()],
        cut,
        trunk: Vec::new(),
        size: [0.0; 2],
        zone: laid.iter().map(|own| own.zone).fold(ZONES[0], f64::max),
        straight: true,
    };
    let mut floor = 0.0;
    for (k, Laid { mut tree, .. }) in laid.into_iter().enumerate() {
        let [low, high] = tree.extent();
        if k > 0 {
            floor -= PIECES + room.gap;
        }
        tree.shift(Point::new(-low.x, floor - high.y));
        floor -= high.y - low.y;
        layout.size = [layout.size[0].max(high.x - low.x), -floor];
        let heading = tree.heading();
        for (index, limb) in tree.limbs.iter().enumerate() {
            layout.lines[limb.branch] = tree.line(index);
            if limb.trunk {
                layout.trunk.push(limb.branch);
                let along = limb.line.end() - limb.line.start;
                layout.straight &= along.perp(&heading).abs() <= 1e-6 * along.norm() && limb.line.curvature == 0.0;
            }
        }
    }
    for line in &mut layout.lines {
        line.start.y -= floor;
    }
    layout
}

#[cfg(test)]
mod tests;
