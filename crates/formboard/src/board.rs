//! The harness on its board.

use crate::flat::{frames, leaves_at, planes};
use crate::harness::Harness;
use crate::layout::{Graph, lay_out, lay_out_within};
use crate::line::{Line, Point};
use crate::pegs::{Peg, pegs};
use crate::tree::Strand;
use crate::{Rotation, Vector};
use nalgebra::Matrix3;

/// Width and height of a sheet A0 on its side, m.
pub const SHEET: [f64; 2] = [1.189, 0.841];

/// Least bend radius of a branch that has no limit, in diameters.
const BEND_RADIUS: f64 = 4.0;

/// Wishes for a board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Distance between the surfaces of branches beside each other, m.
    pub gap: f64,
    /// Distance of the harness from the edges of the board, m.
    pub margin: f64,
    /// Width and height, m; `None`: as many sheets A0 as the harness needs with a straight trunk.
    pub board: Option<[f64; 2]>,
}

impl Default for Options {
    fn default() -> Self {
        Self { gap: 0.005, margin: 0.05, board: None }
    }
}

/// A board that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The harness is larger.
    #[error(
        "the harness does not fit on a board of {} with a margin of {:.0} mm; with straight branches it needs {}, and \
         no layout with bends was found for this one", size(.board), .margin * 1e3, size(.needed)
    )]
    TooSmall {
        /// Width and height of the board, m.
        board: [f64; 2],
        /// Width and height that it needs with straight branches, m.
        needed: [f64; 2],
        /// m.
        margin: f64,
    },
    /// There are no branches.
    #[error("the harness has no branches")]
    Empty,
    /// A distance is none.
    #[error("the {what} of the board must be {right}, not {found} m")]
    Distance {
        /// Which one.
        what: &'static str,
        /// As given, m.
        found: f64,
        /// What would be right.
        right: &'static str,
    },
}

fn size(size: &[f64; 2]) -> String {
    // Rounded up: a board of the size that is named is large enough.
    let [width, height] = size.map(|x| (x * 1e3 - 1e-6).ceil());
    format!("{width:.0} mm x {height:.0} mm")
}

/// Something that users should know of a board, and what it concerns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// One sentence.
    pub what: String,
    /// Names, and numbers beside them; empty if `what` is complete.
    pub items: Vec<String>,
}

/// A branch that closes a loop, and is cut at its second end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Index of the branch.
    pub branch: usize,
    /// Index of the vertex from which it is cut.
    pub from: usize,
}

/// The harness on its board. Positions are from the lower left corner of the board, which lies in the plane of x and y.
#[derive(Clone, Debug, PartialEq)]
pub struct Board {
    /// Width and height, m.
    pub size: [f64; 2],
    /// The margin, m.
    pub margin: f64,
    /// Numbers of sheets A0 beside and above each other, if they make the board.
    pub sheets: Option<[usize; 2]>,
    /// Centre lines, in the order and sense of the branches.
    pub lines: Vec<Line>,
    /// Places of the vertices.
    pub points: Vec<Point>,
    /// Loops that are cut open.
    pub cuts: Vec<Cut>,
    /// A vertex of each piece, from which frames are carried outward.
    pub roots: Vec<usize>,
    /// Branches of trunks, by index.
    pub trunk: Vec<usize>,
    /// What holds the harness.
    pub pegs: Vec<Peg>,
    /// Frame of every branch at its first end: d3 along its line, z upwards from the board.
    pub frames: Vec<Rotation>,
    /// Frame of every arm of every joint.
    pub arms: Vec<Vec<Rotation>>,
    /// Two places may be nearer to each other than their radii and the gap if the way between them along the harness is
    /// at most this number times that distance.
    pub zone: f64,
    /// What users should know.
    pub notes: Vec<Note>,
}

/// Lays a harness on a board.
///
/// # Errors
/// If it is larger than the board, empty, or the options are no distances.
///
/// # Panics
/// If an index of the harness is none.
pub fn lay(harness: &Harness, options: &Options) -> Result<Board, Error> {
    let distance = |what, found: f64, least: f64, right| {
        let good = found.is_finite() && found >= least;
        if good { Ok(()) } else { Err(Error::Distance { what, found, right }) }
    };
    distance("gap", options.gap, 0.0, "0 or more")?;
    distance("margin", options.margin, 0.0, "0 or more")?;
    for (what, found) in options.board.iter().flat_map(|[width, height]| [("width", *width), ("height", *height)]) {
        distance(what, found, f64::MIN_POSITIVE, "above 0")?;
    }
    if harness.branches.is_empty() {
        return Err(Error::Empty);
    }
    // Planes follow the ways from the roots. Loops do not matter to them: any way will do.
    let planes = planes(harness, &harness.ways(&[]));
    let strands = harness.branches.iter().map(|branch| Strand {
        ends: branch.ends,
        length: branch.length,
        radius: 0.5 * branch.diameter,
        bend: bend_limit(branch),
    });
    let graph =
        Graph { vertices: harness.vertices.len(), strands: strands.collect(), leaves_at: leaves_at(harness, &planes) };
    let inner = |board: [f64; 2]| board.map(|x| x - 2.0 * options.margin);
    let outer = |size: [f64; 2]| size.map(|x| x + 2.0 * options.margin);
    let straight = lay_out(&graph, options.gap);
    let fits = |board: [f64; 2]| straight.size.iter().zip(inner(board)).all(|(own, room)| *own <= room);
    let layout = match options.board.filter(|board| !fits(*board)) {
        None => straight,
        Some(board) => {
            let room = Some(inner(board)).filter(|room| room.iter().all(|x| *x > 0.0));
            let found = room.and_then(|room| lay_out_within(&graph, options.gap, room));
            found.ok_or(Error::TooSmall { board, needed: outer(straight.size), margin: options.margin })?
        }
    };

    let ways = harness.ways(&layout.cut);
    let needed = outer(layout.size);
    let columns_rows = |k: usize| (needed[k] / SHEET[k]).ceil().max(1.0) as usize;
    let sheets = options.board.is_none().then(|| [columns_rows(0), columns_rows(1)]);
    let size = options.board.unwrap_or_else(|| std::array::from_fn(|k| columns_rows(k) as f64 * SHEET[k]));
    // In the middle of the board.
    let shift = Point::new(0.5 * (size[0] - layout.size[0]), 0.5 * (size[1] - layout.size[1]));
    let lines: Vec<Line> = layout.lines.iter().map(|line| Line { start: line.start + shift, ..*line }).collect();
    let mut points = vec![Point::zeros(); harness.vertices.len()];
    for (k, (branch, line)) in harness.branches.iter().zip(&lines).enumerate() {
        points[branch.ends[0]] = line.start;
        if !layout.cut.contains(&k) {
            points[branch.ends[1]] = line.end();
        }
    }
    let frames = frames(harness, &ways, &planes, &lines, &layout.cut);
    let pegs = pegs(harness, &lines, &points, &layout.cut);
    let cuts = layout.cut.iter().map(|&branch| Cut { branch, from: harness.branches[branch].ends[1] }).collect();
    let mut board = Board {
        size,
        margin: options.margin,
        sheets,
        lines,
        points,
        cuts,
        roots: ways.order.iter().copied().filter(|vertex| ways.before[*vertex].is_none()).collect(),
        trunk: layout.trunk,
        pegs,
        frames: frames.branches,
        arms: frames.arms,
        zone: layout.zone,
        notes: Vec::new(),
    };
    board.note(harness, layout.straight);
    Ok(board)
}

/// The rotation R that brings frames D nearest to others B: it maximises `Σ tr(Bᵀ R D)`, so it is that of the polar
/// decomposition of `Σ B Dᵀ` (Kabsch 1976).
fn fitted(pairs: impl Iterator<Item = (Rotation, Rotation)>) -> Rotation {
    let matrix = |q: Rotation| q.to_rotation_matrix().into_inner();
    let sum: Matrix3<f64> = pairs.map(|(own, flat)| matrix(flat) * matrix(own).transpose()).sum();
    let svd = sum.svd(true, true);
    let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return Rotation::identity() };
    let mut last = Matrix3::identity();
    last[(2, 2)] = (u * v).determinant().signum();
    Rotation::from_matrix(&(u * last * v))
}

/// The least bend radius of a branch, m.
fn bend_limit(branch: &crate::Branch) -> f64 {
    branch.min_bend_radius.unwrap_or(BEND_RADIUS * branch.diameter)
}

impl Board {
    fn note(&mut self, harness: &Harness, straight: bool) {
        let mut add = |what: String, items: Vec<String>| self.notes.push(Note { what, items });
        let name = |branch: usize| format!("`{}`", harness.branches[branch].name);
        if !self.cuts.is_empty() {
            let item = |cut: &Cut| format!("{} from `{}`", name(cut.branch), harness.vertices[cut.from].name);
            let what = "branches close loops and are cut open at one end";
            add(what.to_owned(), self.cuts.iter().map(item).collect());
        }
        let bent = (0..self.lines.len()).filter(|&k| self.lines[k].curvature != 0.0);
        let item = |k: usize| format!("{} (radius {:.0} mm)", name(k), 1e3 / self.lines[k].curvature.abs());
        let bent: Vec<String> = bent.map(item).collect();
        if !bent.is_empty() {
            add("branches are bent, because the board is too small for straight ones".to_owned(), bent);
        }
        if !straight {
            add("the trunk is not straight".to_owned(), Vec::new());
        }
        if self.zone > 8.5 {
            let what = format!(
                "branches are dense: beside forks they come nearer than their radii and the gap up to {:.0} times this \
                 distance along the harness, instead of 8 times",
                self.zone
            );
            add(what, Vec::new());
        }
    }

    /// Rest curvature of a branch in its own frame, 1/m: about d1, d2 and d3.
    pub fn curvature(&self, branch: usize) -> Vector {
        self.frames[branch].inverse() * Vector::z() * self.lines[branch].curvature
    }

    /// The frame of a branch at an arc length.
    pub fn frame(&self, branch: usize, s: f64) -> Rotation {
        let turn = self.lines[branch].curvature * s;
        Rotation::from_axis_angle(&Vector::z_axis(), turn) * self.frames[branch]
    }

    /// Frames of the arms of every joint at rest, for a harness that keeps the part `memory` (0 to 1) of the angles of
    /// the board, and else those that `harness` has: each turns by this part from one to the other.
    pub fn rest(&self, harness: &Harness, memory: f64) -> Vec<Vec<Rotation>> {
        let of_joint = |(joint, flat): (&crate::Joint, &Vec<Rotation>)| {
            let both = || joint.arms.iter().map(|arm| arm.orientation).zip(flat.iter().copied());
            let turn = fitted(both());
            let between = |(own, flat): (Rotation, Rotation)| {
                if memory == 1.0 { flat } else { (turn * own).try_slerp(&flat, memory, 1e-9).unwrap_or(flat) }
            };
            both().map(between).collect()
        };
        harness.joints.iter().zip(&self.arms).map(of_joint).collect()
    }

    /// Points of a centre line, from its first to its second end: two, if it is straight; of a bent one so many that
    /// none is further than 3° of the bend from the next.
    pub fn path(&self, branch: usize) -> Vec<Point> {
        let line = &self.lines[branch];
        let turn = (line.curvature * line.length).abs().to_degrees();
        let parts = (turn / 3.0).ceil().max(1.0) as usize;
        (0..=parts).map(|k| line.at(line.length * k as f64 / parts as f64)).collect()
    }

    /// The board turned about its corner, then moved; size and margin stay.
    #[must_use]
    pub fn moved(mut self, turn: f64, by: Point) -> Self {
        let (rotation, about_z) = (nalgebra::Rotation2::new(turn), Rotation::from_axis_angle(&Vector::z_axis(), turn));
        for line in &mut self.lines {
            line.start = rotation * line.start + by;
            line.direction += turn;
        }
        let pegs = self.pegs.iter_mut().map(|peg| &mut peg.position);
        pegs.chain(&mut self.points).for_each(|p| *p = rotation * *p + by);
        let arms = self.arms.iter_mut().flatten();
        arms.chain(&mut self.frames).for_each(|frame| *frame = about_z * *frame);
        self
    }
}
