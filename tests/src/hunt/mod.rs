//! Search for wrong results with random harnesses, which are checked by their scenario and `result.json` alone.
//!
//! Of every harness that is called converged: the whole of it and every part are in balance, constraints are where they
//! should be, friction obeys Coulomb, energies add up ([`balance`]); minimisers with a tight tolerance find nothing
//! better from there; what is called stable comes back when it is disturbed; and the same harness turned, shifted,
//! larger, smaller, with branches reversed, beside another harness, or on another mesh has the same shape, or another
//! one that is as good ([`check`]). Faulty scenes are reduced ([`shrink`]).

pub mod balance;
pub mod check;
pub mod compare;
pub mod generate;
pub mod outcome;
pub mod scene;
pub mod shrink;
pub mod variants;
