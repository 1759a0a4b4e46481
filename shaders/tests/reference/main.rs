//! The twins: their derivatives, the elimination, whole descents.

mod derivatives;
mod descent;
mod elimination;
mod harnesses;
