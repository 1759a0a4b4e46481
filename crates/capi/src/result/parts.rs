//! Constraints, joints, bodies and markers of an equilibrium.

use super::kept::{WireloomResult, get};
use crate::call::{WireloomError, call};
use crate::failure::{Failure, WireloomCode};
use crate::pointers::{self, SizedStruct};
use std::ffi::c_char;
use wireloom::geometry::Rotation;
use wireloom::session::drag::quaternion;

/// A constraint that acts: connector, clip, handle. Its texts are valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomConstraint {
    /// sizeof(WireloomConstraint), set by the caller.
    pub size: usize,
    /// Name.
    pub name: *const c_char,
    /// Kind.
    pub kind: *const c_char,
    /// Held point, m.
    pub position: [f64; 3],
    /// Frame at the held point: unit quaternion w, x, y, z.
    pub orientation: [f64; 4],
    /// Force on the harness, N, world axes.
    pub force: [f64; 3],
    /// Moment on the harness about the held point, N m, world axes.
    pub moment: [f64; 3],
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomConstraint {}

/// A joint, or a marker, which has no orientation of its own (1, 0, 0, 0). Its name is valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomPlace {
    /// sizeof(WireloomPlace), set by the caller.
    pub size: usize,
    /// Name.
    pub name: *const c_char,
    /// Position, m.
    pub position: [f64; 3],
    /// Orientation: unit quaternion w, x, y, z.
    pub orientation: [f64; 4],
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomPlace {}

/// A body of the surroundings, and what it does to the harness. Its name is valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomBodyState {
    /// sizeof(WireloomBodyState), set by the caller.
    pub size: usize,
    /// Name.
    pub name: *const c_char,
    /// Position, m.
    pub position: [f64; 3],
    /// Orientation: unit quaternion w, x, y, z.
    pub orientation: [f64; 4],
    /// Force on the harness, N, world axes.
    pub force: [f64; 3],
    /// Moment on the harness about the position of the body, N m, world axes.
    pub moment: [f64; 3],
    /// Sum of the sizes of its contact forces, N.
    pub contact_force: f64,
    /// Number of contact points with a force.
    pub contact_count: usize,
    /// Largest depth of a contact point in the body, m.
    pub depth: f64,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomBodyState {}

fn of<'a, T>(all: &'a [T], index: usize, what: &str) -> Result<&'a T, Failure> {
    all.get(index).ok_or_else(|| Failure::no_index(what, index, all.len()))
}

/// A constraint that acts, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_constraint(
    result: WireloomResult,
    step: usize,
    index: usize,
    constraint: *mut WireloomConstraint,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let own = of(&kept.step(step)?.constraints, index, "constraint")?;
        let value = WireloomConstraint {
            size: size_of::<WireloomConstraint>(),
            name: kept.words.of(&own.name),
            kind: kept.words.of(&own.kind),
            position: own.position.into(),
            orientation: quaternion(&own.orientation),
            force: own.force.into(),
            moment: own.moment.into(),
        };
        pointers::fill(constraint, "constraint", value)
    })
}

/// A joint, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_joint(
    result: WireloomResult,
    step: usize,
    index: usize,
    joint: *mut WireloomPlace,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let own = of(&kept.step(step)?.joints, index, "joint")?;
        let value = WireloomPlace {
            size: size_of::<WireloomPlace>(),
            name: kept.words.of(&own.name),
            position: own.position.into(),
            orientation: quaternion(&own.orientation),
        };
        pointers::fill(joint, "joint", value)
    })
}

/// A marker, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_marker(
    result: WireloomResult,
    step: usize,
    index: usize,
    marker: *mut WireloomPlace,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let own = of(&kept.step(step)?.markers, index, "marker")?;
        let value = WireloomPlace {
            size: size_of::<WireloomPlace>(),
            name: kept.words.of(&own.name),
            position: own.position.into(),
            orientation: quaternion(&Rotation::identity()),
        };
        pointers::fill(marker, "marker", value)
    })
}

/// A body, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_body(
    result: WireloomResult,
    step: usize,
    index: usize,
    body: *mut WireloomBodyState,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let own = of(&kept.step(step)?.obstacles, index, "body")?;
        let value = WireloomBodyState {
            size: size_of::<WireloomBodyState>(),
            name: kept.words.of(&own.name),
            position: own.pose.position.into(),
            orientation: quaternion(&own.pose.orientation),
            force: own.force.into(),
            moment: own.moment.into(),
            contact_force: own.contact_force,
            contact_count: own.contacts,
            depth: own.depth,
        };
        pointers::fill(body, "body", value)
    })
}
