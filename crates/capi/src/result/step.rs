//! Equilibria of a result.

use super::kept::{WireloomResult, get};
use super::{WireloomStatus, status};
use crate::call::{WireloomError, call};
use crate::failure::{Failure, WireloomCode};
use crate::pointers::{self, SizedStruct};
use std::ffi::c_char;
use wireloom::scenario::fault::did_you_mean;

/// Energy by effect, J.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomEnergy {
    /// The sum.
    pub total: f64,
    /// Stretch of the branches.
    pub stretch: f64,
    /// Shear of the branches.
    pub shear: f64,
    /// Bending of the branches.
    pub bend: f64,
    /// Twist of the branches.
    pub twist: f64,
    /// Gravity.
    pub gravity: f64,
    /// Dead forces.
    pub load: f64,
    /// Joints.
    pub joint: f64,
    /// Constraints, contact and friction.
    pub constraint: f64,
}

/// The equilibrium at the end of an increment. Its texts are valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomStep {
    /// sizeof(WireloomStep), set by the caller.
    pub size: usize,
    /// Name of the step.
    pub name: *const c_char,
    /// Number of the increment, from 1; 0: the initial equilibrium.
    pub increment: usize,
    /// Increments of the step.
    pub increment_count: usize,
    /// How well its equations are solved.
    pub status: WireloomStatus,
    /// Whether the equilibrium is stable: 1, 0, or -1 where that cannot be decided.
    pub stable: i32,
    /// Its energy.
    pub energy: WireloomEnergy,
    /// Name of the branch with the critical bend: the one nearest to its limit, or of least radius; null: all straight.
    pub bend_branch: *const c_char,
    /// Arc length of that bend, m; NaN: all straight.
    pub bend_s: f64,
    /// Its radius, m; infinite: all straight.
    pub bend_radius: f64,
    /// Smallest radius allowed there, m; NaN: no limit.
    pub bend_radius_limit: f64,
    /// Branches.
    pub branch_count: usize,
    /// Constraints that act.
    pub constraint_count: usize,
    /// Joints.
    pub joint_count: usize,
    /// Bodies of the surroundings.
    pub body_count: usize,
    /// Markers.
    pub marker_count: usize,
    /// Kind of the minimiser.
    pub minimiser: *const c_char,
    /// Its iterations, over all increments of the step so far.
    pub iterations: usize,
    /// Its factorisations.
    pub factorisations: usize,
    /// Its time, s.
    pub seconds: f64,
    /// Largest residual force or moment, relative to its scale.
    pub force_residual: f64,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomStep {}

/// One of the equilibria, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_step(
    result: WireloomResult,
    index: usize,
    step: *mut WireloomStep,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let own = kept.step(index)?;
        let (energy, bend) = (own.energy, own.min_bend_radius.as_ref());
        let value = WireloomStep {
            size: size_of::<WireloomStep>(),
            name: kept.words.of(&own.name),
            increment: own.increment,
            increment_count: own.increments,
            status: status(own.status),
            stable: own.stable.map_or(-1, i32::from),
            energy: WireloomEnergy {
                total: energy.total(),
                stretch: energy.stretch,
                shear: energy.shear,
                bend: energy.bend,
                twist: energy.twist,
                gravity: energy.gravity,
                load: energy.load,
                joint: energy.joint,
                constraint: energy.constraint,
            },
            bend_branch: kept.words.of_option(bend.map(|bend| bend.branch.as_str())),
            bend_s: bend.map_or(f64::NAN, |bend| bend.s),
            bend_radius: bend.map_or(f64::INFINITY, |bend| bend.value),
            bend_radius_limit: bend.and_then(|bend| bend.limit).unwrap_or(f64::NAN),
            branch_count: own.branches.len(),
            constraint_count: own.constraints.len(),
            joint_count: own.joints.len(),
            body_count: own.obstacles.len(),
            marker_count: own.markers.len(),
            minimiser: kept.words.of(&own.minimiser.kind),
            iterations: own.minimiser.iterations,
            factorisations: own.minimiser.factorisations,
            seconds: own.minimiser.seconds,
            force_residual: own.minimiser.force_residual,
        };
        pointers::fill(step, "step", value)
    })
}

/// Families of named parts, for wireloom_result_find.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireloomFamily {
    /// Branches.
    Branch = 1,
    /// Constraints that act.
    Constraint = 2,
    /// Joints.
    Joint = 3,
    /// Bodies of the surroundings.
    Body = 4,
    /// Markers.
    Marker = 5,
}

/// Index of a part of an equilibrium by its name; `family`: a WireloomFamily.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_find(
    result: WireloomResult,
    step: usize,
    family: u32,
    name: *const c_char,
    index: *mut usize,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let own = kept.step(step)?;
        let name = pointers::text(name, "name")?;
        let families = [
            WireloomFamily::Branch,
            WireloomFamily::Constraint,
            WireloomFamily::Joint,
            WireloomFamily::Body,
            WireloomFamily::Marker,
        ];
        let (what, names): (&str, Vec<&str>) = match families.into_iter().find(|known| *known as u32 == family) {
            Some(WireloomFamily::Branch) => ("branch", own.branches.iter().map(|part| &*part.name).collect()),
            Some(WireloomFamily::Constraint) => {
                ("acting constraint", own.constraints.iter().map(|part| &*part.name).collect())
            }
            Some(WireloomFamily::Joint) => ("joint", own.joints.iter().map(|part| &*part.name).collect()),
            Some(WireloomFamily::Body) => ("body", own.obstacles.iter().map(|part| &*part.name).collect()),
            Some(WireloomFamily::Marker) => ("marker", own.markers.iter().map(|part| &*part.name).collect()),
            None => return Err(Failure::value(format!("{family} is no WireloomFamily"), "give one of its values")),
        };
        let found = names.iter().position(|known| *known == name);
        let none = || Failure::not_found(format!("there is no {what} \"{name}\""), did_you_mean(name, names.clone()));
        pointers::put(index, "index", found.ok_or_else(none)?)
    })
}
