//! Branches of an equilibrium.

use super::kept::{WireloomResult, get};
use crate::call::{WireloomError, call};
use crate::failure::{Failure, WireloomCode};
use crate::pointers::{self, SizedStruct};
use std::ffi::c_char;
use wireloom::geometry::Vector;

/// A branch of an equilibrium. Arrays have a value, or the three components of a vector (x, y, z, world axes), for each
/// node; they and the name are valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomBranch {
    /// sizeof(WireloomBranch), set by the caller.
    pub size: usize,
    /// Name.
    pub name: *const c_char,
    /// Number of nodes.
    pub node_count: usize,
    /// Unstressed arc length, m.
    pub s: *const f64,
    /// Position of the centre line, m: 3 numbers for each node.
    pub position: *const f64,
    /// Director d1 of the cross-section: 3 numbers for each node.
    pub d1: *const f64,
    /// Director d2.
    pub d2: *const f64,
    /// Director d3, along the cable.
    pub d3: *const f64,
    /// Internal force that the part with larger s exerts on the part with smaller s, N: 3 numbers for each node.
    pub force: *const f64,
    /// Internal moment, N m: 3 numbers for each node.
    pub moment: *const f64,
    /// Bend radius, m; infinite where it is straight.
    pub bend_radius: *const f64,
    /// Diameter, m; the greatest one where the section changes.
    pub diameter: f64,
    /// Smallest bend radius allowed, m; the greatest one where the section changes; NaN: no limit.
    pub bend_radius_limit: f64,
    /// Axial stiffness EA, N, at the start.
    pub axial_stiffness: f64,
    /// Total material twist, turns.
    pub twist_turns: f64,
    /// Estimated discretisation error of positions, m; NaN: no estimate.
    pub position_error: f64,
    /// That of internal forces, N; NaN: no estimate.
    pub force_error: f64,
    /// That of internal moments, N m; NaN: no estimate.
    pub moment_error: f64,
    /// The least bend radius may be smaller by so much, m; NaN: no estimate.
    pub bend_radius_error: f64,
    /// Number of parts with a section of their own; 0 where the section does not change.
    pub section_count: usize,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomBranch {}

/// The numbers of a list of vectors, three for each.
fn numbers(list: &[Vector]) -> *const f64 {
    // Vectors are three numbers side by side.
    const { assert!(size_of::<Vector>() == 3 * size_of::<f64>() && align_of::<Vector>() == align_of::<f64>()) };
    list.as_ptr().cast()
}

/// A branch of an equilibrium, from 0, in the order of the scenario.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_branch(
    result: WireloomResult,
    step: usize,
    index: usize,
    branch: *mut WireloomBranch,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let all = &kept.step(step)?.branches;
        let own = all.get(index).ok_or_else(|| Failure::no_index("branch", index, all.len()))?;
        let [d1, d2, d3] = kept.directors(step, index);
        let estimate = own.error;
        let value = WireloomBranch {
            size: size_of::<WireloomBranch>(),
            name: kept.words.of(&own.name),
            node_count: own.s.len(),
            s: own.s.as_ptr(),
            position: numbers(&own.position),
            d1: numbers(d1),
            d2: numbers(d2),
            d3: numbers(d3),
            force: numbers(&own.force),
            moment: numbers(&own.moment),
            bend_radius: own.bend_radius.as_ptr(),
            diameter: own.diameter,
            bend_radius_limit: own.bend_radius_limit.unwrap_or(f64::NAN),
            axial_stiffness: own.axial_stiffness,
            twist_turns: own.twist_turns,
            position_error: estimate.map_or(f64::NAN, |error| error.position),
            force_error: estimate.map_or(f64::NAN, |error| error.force),
            moment_error: estimate.map_or(f64::NAN, |error| error.moment),
            bend_radius_error: estimate.and_then(|error| error.bend_radius).unwrap_or(f64::NAN),
            section_count: own.sections.len(),
        };
        pointers::fill(branch, "branch", value)
    })
}

/// A part of a branch with a section of its own.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomSection {
    /// sizeof(WireloomSection), set by the caller.
    pub size: usize,
    /// Name of the section; valid until the result is freed.
    pub name: *const c_char,
    /// Arc length where the part begins, m.
    pub from: f64,
    /// Arc length where it ends, m.
    pub to: f64,
    /// Diameter, m.
    pub diameter: f64,
    /// Smallest bend radius allowed, m; NaN: no limit.
    pub bend_radius_limit: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomSection {}

/// A part of a branch with a section of its own, from 0, in the order of arc length; a branch whose section does not
/// change has none.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_section(
    result: WireloomResult,
    step: usize,
    branch: usize,
    index: usize,
    section: *mut WireloomSection,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let all = &kept.step(step)?.branches;
        let parts = &all.get(branch).ok_or_else(|| Failure::no_index("branch", branch, all.len()))?.sections;
        let own = parts.get(index).ok_or_else(|| Failure::no_index("section", index, parts.len()))?;
        let value = WireloomSection {
            size: size_of::<WireloomSection>(),
            name: kept.words.of(&own.section),
            from: own.from,
            to: own.to,
            diameter: own.diameter,
            bend_radius_limit: own.bend_radius_limit.unwrap_or(f64::NAN),
            axial_stiffness: own.axial_stiffness,
        };
        pointers::fill(section, "section", value)
    })
}
