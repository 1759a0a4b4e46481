//! Plugins: which are trusted, how they are loaded, checked and made, and what happens when one crashes.

pub mod check;
pub mod crash;
pub mod describe;
pub mod fault;
pub mod load;
pub mod new;
pub mod supervise;
pub mod supervised;
pub mod trust;
