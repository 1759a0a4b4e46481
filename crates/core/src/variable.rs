//! Independent variables of the energy, and blocks of second derivatives in them.

use crate::Matrix;

/// An independent variable: three numbers of a [`crate::Tangent`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Variable {
    /// Position of a point.
    Point(usize),
    /// Rotation of a frame.
    Frame(usize),
}

/// A block of second derivatives in two independent variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// The variable of its rows.
    pub row: Variable,
    /// The variable of its columns.
    pub column: Variable,
    /// ∂²E/∂row ∂column.
    pub matrix: Matrix,
}
