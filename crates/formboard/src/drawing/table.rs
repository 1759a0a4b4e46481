//! Tables beside the drawing.

use crate::{Board, Harness, Holds, Place, Point};

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its headline.
    pub title: String,
    /// Titles of the columns; those of numbers, which stand on the right, begin with `>`.
    pub columns: Vec<String>,
    /// The rows, with an entry for each column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(title: &str, columns: &[&str]) -> Self {
        let columns = columns.iter().map(|&column| column.to_owned()).collect();
        Self { title: title.to_owned(), columns, rows: Vec::new() }
    }
}

/// mm, to a tenth.
pub(crate) fn millimetres(x: f64) -> String {
    format!("{:.1}", x * 1e3)
}

/// What the harness has beside branches: ends, forks and clips, with their places on the board.
pub fn parts(harness: &Harness, board: &Board) -> Table {
    let mut table = Table::new("Parts", &["part", "kind", "at", ">x [mm]", ">y [mm]"]);
    let mut row = |name: &str, kind: &str, at: String, place: Point| {
        let [x, y] = [place.x, place.y].map(millimetres);
        table.rows.push(vec![name.to_owned(), kind.to_owned(), at, x, y]);
    };
    for peg in &board.pegs {
        match (peg.holds, peg.at) {
            (Holds::End | Holds::Joint, Place::Vertex(vertex)) => {
                let own = &harness.vertices[vertex];
                let kind = if peg.holds == Holds::End { "end" } else { "fork" };
                row(own.label(), kind, own.name.clone(), peg.position);
            }
            (_, Place::Cut(branch)) => {
                row(&harness.branches[branch].name, "end, cut", harness.branches[branch].name.clone(), peg.position);
            }
            _ => {}
        }
    }
    for (branch, line) in harness.branches.iter().zip(&board.lines) {
        for clip in &branch.clips {
            row(&clip.name, "fixing", format!("{}, {} mm", branch.name, millimetres(clip.s)), line.at(clip.s));
        }
    }
    table
}

/// The branches, with lengths.
pub fn branches(harness: &Harness, board: &Board) -> Table {
    let columns = ["branch", "from", "to", ">length [mm]", ">diameter [mm]", ">bend radius [mm]"];
    let mut table = Table::new("Branches", &columns);
    for (branch, line) in harness.branches.iter().zip(&board.lines) {
        let [from, to] = branch.ends.map(|end| harness.vertices[end].name.clone());
        let bend = if line.curvature == 0.0 { String::new() } else { millimetres(1.0 / line.curvature.abs()) };
        let [length, diameter] = [branch.length, branch.diameter].map(millimetres);
        table.rows.push(vec![branch.name.clone(), from, to, length, diameter, bend]);
    }
    table
}
