//! Table of functions of a kind together with the kind.

/// Functions of a kind as the ABI has them, followed by the kind itself, which the program does not see.
///
/// A pointer to `functions` is a pointer to the whole table, because `functions` comes first.
#[repr(C)]
pub struct Table<F, K> {
    /// Functions that the program calls.
    pub functions: F,
    /// The kind whose functions they are.
    pub kind: K,
}
