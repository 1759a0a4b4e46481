//! Events of a run, and its requirements with their verdicts.

use super::kept::{Kept, WireloomResult, get};
use super::{WireloomVerdict, verdict};
use crate::call::{WireloomError, call};
use crate::failure::{Failure, WireloomCode};
use crate::pointers::{self, SizedStruct};
use std::ffi::c_char;
use wireloom::result::{EventPlace, Moment, Severity};

/// A part of the harness. Its texts are valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomWhere {
    /// The place in words, such as "branch `trunk` at s = 310.0 mm".
    pub words: *const c_char,
    /// Name of the constraint; null: none.
    pub constraint: *const c_char,
    /// Name of the body; null: none.
    pub body: *const c_char,
    /// Name of the branch; null: none.
    pub branch: *const c_char,
    /// Arc length on the branch, m; NaN: none.
    pub s: f64,
    /// Name of the other branch, where two meet; null: none.
    pub other_branch: *const c_char,
    /// Arc length on the other branch, m; NaN: none.
    pub other_s: f64,
}

/// An increment of a run. Its text is valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomMoment {
    /// Name of the step; null: no increment.
    pub step: *const c_char,
    /// Index of the step, from 0.
    pub step_index: usize,
    /// Number of the increment, from 1; 0: while the initial equilibrium was being found.
    pub increment: usize,
}

/// An event: a condition over consecutive increments. Its texts are valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomEvent {
    /// sizeof(WireloomEvent), set by the caller.
    pub size: usize,
    /// Kind, such as "bend-radius" or "jump".
    pub kind: *const c_char,
    /// One sentence about the worst increment.
    pub message: *const c_char,
    /// Place.
    pub place: WireloomWhere,
    /// First increment.
    pub first: WireloomMoment,
    /// Worst increment.
    pub worst: WireloomMoment,
    /// Last increment.
    pub last: WireloomMoment,
    /// Number of increments.
    pub increment_count: usize,
    /// Worst value, in `unit`; NaN: none.
    pub value: f64,
    /// Its limit; NaN: none.
    pub limit: f64,
    /// SI unit of both; empty where there is none.
    pub unit: *const c_char,
    /// 1 if it demands a correction, 0 if it is information only.
    pub is_trouble: i32,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomEvent {}

/// A requirement with its verdict. Its texts are valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomRequirement {
    /// sizeof(WireloomRequirement), set by the caller.
    pub size: usize,
    /// Name.
    pub name: *const c_char,
    /// What it limits, such as "bend_radius".
    pub quantity: *const c_char,
    /// SI unit; empty for a pure number.
    pub unit: *const c_char,
    /// 1 if the harness is not acceptable where it fails, 0 if it is only reported.
    pub is_must: i32,
    /// Verdict.
    pub verdict: WireloomVerdict,
    /// Worst value over all increments; NaN: nothing was checked.
    pub worst: f64,
    /// Limit.
    pub limit: f64,
    /// 1 if the value must not be smaller than the limit, 0 if it must not be larger.
    pub is_minimum: i32,
    /// Distance of the worst value from the limit, relative to it; negative where it fails; NaN: none.
    pub margin: f64,
    /// Estimated discretisation error of the worst value; NaN: none.
    pub error: f64,
    /// Increment of the worst value.
    pub moment: WireloomMoment,
    /// Place of the worst value.
    pub place: WireloomWhere,
    /// Where it comes from: "scenario", "section", "constraint", "obstacle" or "always".
    pub origin: *const c_char,
    /// Why the scenario asks for it; null: not said.
    pub because: *const c_char,
    /// Why it is unresolved or not checked, or what the worst value leaves out; null: nothing to say.
    pub reason: *const c_char,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomRequirement {}

impl Kept {
    fn place(&self, own: &EventPlace) -> WireloomWhere {
        WireloomWhere {
            words: self.words.of(&own.to_string()),
            constraint: self.words.of_option(own.constraint.as_deref()),
            body: self.words.of_option(own.obstacle.as_deref()),
            branch: self.words.of_option(own.branch.as_deref()),
            s: own.s.unwrap_or(f64::NAN),
            other_branch: self.words.of_option(own.other_branch.as_deref()),
            other_s: own.other_s.unwrap_or(f64::NAN),
        }
    }

    fn moment(&self, own: Option<&Moment>) -> WireloomMoment {
        WireloomMoment {
            step: self.words.of_option(own.map(|own| own.step.as_str())),
            step_index: own.map_or(0, |own| own.step_index),
            increment: own.map_or(0, |own| own.increment),
        }
    }
}

/// An event, from 0, in the order in which they began.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_event(
    result: WireloomResult,
    index: usize,
    event: *mut WireloomEvent,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let all = &kept.run.events;
        let own = all.get(index).ok_or_else(|| Failure::no_index("event", index, all.len()))?;
        let value = WireloomEvent {
            size: size_of::<WireloomEvent>(),
            kind: kept.words.of(own.kind.word()),
            message: kept.words.of(&own.message),
            place: kept.place(&own.place),
            first: kept.moment(Some(&own.first)),
            worst: kept.moment(Some(&own.worst)),
            last: kept.moment(Some(&own.last)),
            increment_count: own.increments,
            value: own.value.unwrap_or(f64::NAN),
            limit: own.limit.unwrap_or(f64::NAN),
            unit: kept.words.of(own.kind.unit()),
            is_trouble: own.kind.is_trouble().into(),
        };
        pointers::fill(event, "event", value)
    })
}

/// A requirement, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_requirement(
    result: WireloomResult,
    index: usize,
    requirement: *mut WireloomRequirement,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let all = &kept.run.requirements;
        let own = all.get(index).ok_or_else(|| Failure::no_index("requirement", index, all.len()))?;
        let value = WireloomRequirement {
            size: size_of::<WireloomRequirement>(),
            name: kept.words.of(&own.name),
            quantity: kept.words.of(own.measure.word()),
            unit: kept.words.of(own.measure.unit()),
            is_must: (own.severity == Severity::Must).into(),
            verdict: verdict(own.verdict),
            worst: own.worst.unwrap_or(f64::NAN),
            limit: own.limit,
            is_minimum: (own.bound == wireloom::result::Bound::Min).into(),
            margin: own.margin().unwrap_or(f64::NAN),
            error: own.error.unwrap_or(f64::NAN),
            moment: kept.moment(own.moment.as_ref()),
            place: kept.place(&own.place),
            origin: kept.words.of(own.origin.word()),
            because: kept.words.of_option(own.because.as_deref()),
            reason: kept.words.of_option(own.reason.as_deref()),
        };
        pointers::fill(requirement, "requirement", value)
    })
}
