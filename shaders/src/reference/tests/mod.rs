//! Tests of the CPU reference: derivatives, elimination, complete minimisations.

mod derivatives;
mod descent;
mod elimination;
mod harnesses;
