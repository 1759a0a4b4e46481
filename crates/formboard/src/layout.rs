//! The layout of a harness: centre lines on a board, of true length.

use crate::clearance::Rules;
use crate::line::{Line, Point};
use crate::search::{Limits, STEP, search};
use crate::tree::{Strand, Tree};
use crate::unfold::{self, Edge, Turning, unfold};
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

/// The layout of a graph on a board of its own size. `gap`: distance between the surfaces of branches, m.
pub(crate) fn lay_out(graph: &Graph, gap: f64) -> Layout {
    Opened::of(graph).laid(gap, |piece| Some(piece.free(gap))).unwrap_or_else(|| unreachable!("every piece is laid"))
}

/// The layout of a graph within a width and height, m; `None` if none is found.
pub(crate) fn lay_out_within(graph: &Graph, gap: f64, board: [f64; 2]) -> Option<Layout> {
    let layout = Opened::of(graph).laid(gap, |piece| piece.within(gap, board))?;
    layout.size.iter().zip(board).all(|(own, room)| *own <= room).then_some(layout)
}

/// A graph without loops: every strand that closes one ends at a vertex of its own instead of its second one.
struct Opened {
    graph: Graph,
    edges: Vec<Edge>,
    cut: Vec<usize>,
}

impl Opened {
    fn of(graph: &Graph) -> Self {
        let cut = unfold(graph.vertices, &edges(graph), Turning::Wedges).closing;
        let mut graph = graph.clone();
        for &strand in &cut {
            graph.strands[strand].ends[1] = graph.vertices;
            graph.vertices += 1;
        }
        Self { edges: edges(&graph), graph, cut }
    }

    /// All pieces as `lay` lays them; `None` if it does not lay one.
    fn laid(self, gap: f64, lay: impl Fn(&Piece<'_>) -> Option<Laid>) -> Option<Layout> {
        let towards_drawn = unfold(self.graph.vertices, &self.edges, Turning::Daylight);
        let laid = towards_drawn.pieces.iter().filter(|piece| piece.vertices.len() > 1).map(|piece| {
            let start = Tree::new(piece, &self.graph.strands, &towards_drawn.points);
            lay(&Piece { opened: &self, piece, start })
        });
        let laid: Vec<Laid> = laid.collect::<Option<_>>()?;
        Some(together(&self.graph, laid, self.cut, gap))
    }
}

fn edges(graph: &Graph) -> Vec<Edge> {
    let both = graph.strands.iter().zip(&graph.leaves_at);
    both.map(|(strand, &leaves_at)| Edge { ends: strand.ends, length: strand.length, leaves_at }).collect()
}

struct Laid {
    tree: Tree,
    zone: f64,
}

/// A connected piece of a graph.
struct Piece<'a> {
    opened: &'a Opened,
    piece: &'a unfold::Piece,
    /// Near its drawn angles.
    start: Tree,
}

impl Piece<'_> {
    /// With the narrowest zones around forks that the search finds a layout for; in wedges if it finds none.
    fn free(&self, gap: f64) -> Laid {
        self.searched(gap, None).unwrap_or_else(|| {
            let wedges = self.in_wedges(gap);
            let limits = Limits { rules: Rules { gap, zone: wedges.zone, angle: angle_of(&wedges.tree) }, board: None };
            search(&wedges.tree, &limits, 0).map_or(wedges, |tree| Laid { tree, zone: limits.rules.zone })
        })
    }

    /// A board is filled from the side of a straight trunk, or not at all.
    fn within(&self, gap: f64, board: [f64; 2]) -> Option<Laid> {
        self.searched(gap, Some(board))
    }

    fn searched(&self, gap: f64, board: Option<[f64; 2]>) -> Option<Laid> {
        let mut rounded = self.start.clone();
        rounded.straighten();
        rounded.round_directions(STEP);
        ZONES.iter().enumerate().find_map(|(k, &zone)| {
            let tree = search(&rounded, &Limits { rules: Rules { gap, zone, angle: ANGLE }, board }, k as u64)?;
            Some(Laid { tree, zone })
        })
    }

    /// The piece in wedges of equal angle per leaf. It keeps the rules by construction (`Turning::Wedges`), with zones
    /// that grow with the number n of leaves: places with a distance D are at most `D / sin(π/n)` apart along the
    /// harness.
    fn in_wedges(&self, gap: f64) -> Laid {
        let Opened { graph, edges, .. } = self.opened;
        let tree = Tree::new(self.piece, &graph.strands, &unfold(graph.vertices, edges, Turning::Wedges).points);
        let zone = ZONES[0].max((1.0 + 1e-9) / (PI / leaves(&tree)).sin());
        debug_assert!(tree.breaches(&Rules { gap, zone, angle: angle_of(&tree) }).is_empty());
        Laid { tree, zone }
    }
}

fn leaves(tree: &Tree) -> f64 {
    let outer = tree.limbs.iter().enumerate().filter(|(k, limb)| limb.last == k + 1).count();
    (outer + 1) as f64
}

/// The least angle between arms in wedges.
fn angle_of(tree: &Tree) -> f64 {
    ANGLE.min(TAU / leaves(tree) * (1.0 - 1e-9))
}

/// All pieces, one below the other.
fn together(graph: &Graph, laid: Vec<Laid>, cut: Vec<usize>, gap: f64) -> Layout {
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
            floor -= PIECES + gap;
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
