//! Harness files of other formats to scenarios.
//!
//! - [`kbl`]: KBL (*Kabelbaumliste*, VDA recommendation 4964), the list of parts, wires, topology and centre
//!   curves that harness design tools exchange.
//!
//! The road of a KBL file, which is also the order of the files in `kbl/`:
//! `document` (XML to plain values in SI) → `curve` (drawn centre lines) → `section` (stiffness rule) →
//! `harness` (branches, joints; `anatomy`: what passes through joints; `fixings`: what holds) → `write` (TOML text).

pub mod kbl;
pub mod layout;
