//! C functions of a constraint kind.
//!
//! Their arguments are as the ABI demands: a pointer is null, or points to what the ABI says.

use crate::panics::catch_panics;
use crate::read::{abi_pose, parameters, pose, slice, spec};
use crate::table::Table;
use std::cell::RefCell;
use std::ffi::c_void;
use wireloom_abi as abi;
use wireloom_core::constraint::{ConstraintView, Equations, Relation, Residual};
use wireloom_core::registry::{ConstraintKind, Output};
use wireloom_core::{Action, Constraint, Hold, Matrix, Pose, Potential, RotationHold, Vector};

/// The instance behind a `*mut c_void`.
struct Instance {
    model: Box<dyn Constraint>,
    memory: Vec<f64>,
    inequalities: Vec<i32>,
    scales: Vec<f64>,
    /// Number of residuals of the stations, and of each node.
    residuals: [usize; 2],
    /// The outputs that the kind declares.
    outputs: Vec<Output>,
}

/// Scratch for poses and blocks of one call.
#[derive(Default)]
struct Scratch {
    stations: Vec<Pose>,
    targets: Vec<Pose>,
    blocks: Vec<Matrix>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

pub unsafe extern "C" fn create(
    kind: *const abi::Kind,
    said: *const abi::ConstraintSpec,
    instance: *mut *mut c_void,
    description: *mut abi::Description,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file. `kind` was made by this library, so its function table is part of a [`Table`].
    unsafe {
        catch_panics(message, || {
            let kind = &(*(*kind).constraint.cast::<Table<abi::ConstraintKind, ConstraintKind>>()).kind;
            let values = slice((*said).values, (*said).value_count as usize);
            let made = (kind.build)(&spec(&*said), &parameters(&kind.parameters, values))
                .map_err(|error| format!("{}; {}", error.message, error.help))?;
            let residuals = match made.action().equations() {
                Some(equations) => [equations.of_stations(), equations.of_each_node()],
                None => [vec![], vec![]],
            };
            let all = || residuals.iter().flatten();
            let own = Box::new(Instance {
                memory: made.memory(),
                inequalities: all().map(|c| i32::from(c.relation == Relation::NotPositive)).collect(),
                scales: all().map(|c: &Residual| c.scale).collect(),
                residuals: residuals.each_ref().map(Vec::len),
                outputs: kind.outputs.clone(),
                model: made,
            });
            *description = abi::Description {
                size: (*description).size,
                shape: match own.model.action() {
                    Action::Prescribed(_) => abi::SHAPE_PRESCRIBED,
                    Action::Potential(_) => abi::SHAPE_POTENTIAL,
                    Action::Equations(_) => abi::SHAPE_EQUATIONS,
                    Action::PotentialAndEquations(..) => abi::SHAPE_POTENTIAL_AND_EQUATIONS,
                },
                needs_frames: i32::from(own.model.needs_frame()),
                objective: i32::from(own.model.objective()),
                thread_safe: 1,
                has_gradient: 1,
                has_hessian: 1,
                memory_count: own.memory.len() as u32,
                memory: own.memory.as_ptr(),
                residual_count: own.residuals[0] as u32,
                node_residual_count: own.residuals[1] as u32,
                inequalities: own.inequalities.as_ptr(),
                scales: own.scales.as_ptr(),
                hold: match own.model.action() {
                    Action::Prescribed(hold) => abi_hold(hold),
                    _ => NO_HOLD,
                },
            };
            *instance = Box::into_raw(own).cast();
            Ok(())
        })
    }
}

const NO_HOLD: abi::Hold = abi::Hold {
    position: 0,
    rotation: abi::ROTATION_FREE,
    axis: [0.0; 3],
    rails: [[0.0; 3]; 2],
    rail_count: 0,
    reserved: 0,
};

fn abi_hold(hold: &Hold) -> abi::Hold {
    let mut plain = abi::Hold { position: i32::from(hold.position), rail_count: hold.rails.len() as u32, ..NO_HOLD };
    for (to, rail) in plain.rails.iter_mut().zip(&hold.rails) {
        *to = (*rail).into();
    }
    plain.rotation = match &hold.rotation {
        RotationHold::Free => abi::ROTATION_FREE,
        RotationHold::Tangent => abi::ROTATION_TANGENT,
        RotationHold::Twist => abi::ROTATION_TWIST,
        RotationHold::All => abi::ROTATION_ALL,
        RotationHold::Hinge(axis) => {
            plain.axis = (**axis).into();
            abi::ROTATION_HINGE
        }
    };
    plain
}

pub unsafe extern "C" fn destroy(instance: *mut c_void) {
    // SAFETY: see the top of this file; an instance is destroyed once.
    unsafe {
        catch_panics(std::ptr::null_mut(), || {
            drop(Box::from_raw(instance.cast::<Instance>()));
            Ok(())
        });
    }
}

pub unsafe extern "C" fn target(
    instance: *const c_void,
    base: *const abi::Pose,
    progress: f64,
    target: *mut abi::Pose,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file.
    unsafe {
        catch_panics(message, || {
            let own = &*instance.cast::<Instance>();
            *target = abi_pose(&own.model.target(&pose(&*base), progress));
            Ok(())
        })
    }
}

pub unsafe extern "C" fn commit(
    instance: *const c_void,
    situation: *const abi::Situation,
    memory: *mut f64,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file.
    unsafe {
        catch_panics(message, || {
            let own = &*instance.cast::<Instance>();
            let memory = match own.memory.len() {
                0 => &mut [],
                count => std::slice::from_raw_parts_mut(memory, count),
            };
            with_situation(&*situation, |at, _| own.model.commit(at, memory));
            Ok(())
        })
    }
}

pub unsafe extern "C" fn report(
    instance: *const c_void,
    situation: *const abi::Situation,
    values: *mut f64,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file.
    unsafe {
        catch_panics(message, || {
            let own = &*instance.cast::<Instance>();
            let mut found = vec![];
            with_situation(&*situation, |at, _| found = own.model.outputs(at));
            for (k, Output { name, event, .. }) in own.outputs.iter().enumerate() {
                match found.iter().find(|(other, _)| other == name) {
                    Some((_, value)) => values.add(k).write(*value),
                    // It does not happen.
                    None if *event => {}
                    None => return Err(format!("the output `{name}` has no value")),
                }
            }
            Ok(())
        })
    }
}

pub unsafe extern "C" fn evaluate(
    instance: *const c_void,
    situation: *const abi::Situation,
    evaluation: *mut abi::Evaluation,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file.
    unsafe {
        catch_panics(message, || {
            let own = &*instance.cast::<Instance>();
            let wanted = &*evaluation;
            // Weights are given if second derivatives of equations are wanted.
            let of_equations = !wanted.weights.is_null();
            let action = own.model.action();
            with_situation(&*situation, |at, blocks| {
                if let Some(potential) = action.potential() {
                    evaluate_potential(potential, at, wanted, !of_equations, blocks);
                }
                if let Some(equations) = action.equations() {
                    evaluate_equations(equations, own.residuals, at, wanted, of_equations, blocks);
                }
            });
            Ok(())
        })
    }
}

/// `second`: whether the second derivatives that are wanted are those of the potential.
///
/// # Safety
/// `wanted` is as the ABI demands.
unsafe fn evaluate_potential(
    potential: &dyn Potential,
    at: &ConstraintView<'_>,
    wanted: &abi::Evaluation,
    second: bool,
    blocks: &mut Vec<Matrix>,
) {
    let (m, k) = (at.stations.len(), at.span.len());
    // SAFETY: as the caller promises.
    unsafe {
        let energy = if wanted.gradient.is_null() {
            if wanted.energy.is_null() { None } else { Some(potential.energy(at)) }
        } else {
            Some(potential.gradient(at, vectors(wanted.gradient, 2 * m), vectors(wanted.span_gradient, k)))
        };
        if let (Some(energy), Some(to)) = (energy, wanted.energy.as_mut()) {
            *to = energy;
        }
        if second && !wanted.hessian.is_null() {
            second_derivatives(m, k, wanted, blocks, |stations, span| potential.hessian(at, stations, span));
        }
    }
}

/// # Safety
/// As for [`evaluate_potential`]; there are `r` residuals of the stations and `p` of each node.
unsafe fn evaluate_equations(
    equations: &dyn Equations,
    [r, p]: [usize; 2],
    at: &ConstraintView<'_>,
    wanted: &abi::Evaluation,
    second: bool,
    blocks: &mut Vec<Matrix>,
) {
    let (m, k) = (at.stations.len(), at.span.len());
    let all = r + k * p;
    // SAFETY: as the caller promises.
    unsafe {
        let c = output(wanted.residuals, all);
        if !wanted.jacobian.is_null() {
            let stations = vectors(wanted.jacobian, r * 2 * m);
            equations.jacobian(at, c, stations, vectors(wanted.span_jacobian, all - r));
        } else if !c.is_empty() {
            equations.residuals(at, c);
        }
        if second && !wanted.hessian.is_null() {
            let w = slice(wanted.weights, all);
            second_derivatives(m, k, wanted, blocks, |stations, span| equations.curvature(at, w, stations, span));
        }
    }
}

/// Second derivatives: copies the core's column-major blocks to C's rows.
///
/// # Safety
/// As for [`evaluate_potential`].
unsafe fn second_derivatives(
    m: usize,
    k: usize,
    wanted: &abi::Evaluation,
    blocks: &mut Vec<Matrix>,
    hessian: impl FnOnce(&mut [Matrix], &mut [Matrix]),
) {
    blocks.clear();
    blocks.resize(4 * m * m + k, Matrix::zeros());
    let (stations, span) = blocks.split_at_mut(4 * m * m);
    hessian(stations, span);
    // SAFETY: as the caller promises.
    unsafe {
        let rows = output(wanted.hessian, 36 * m * m);
        for (at, x) in rows.iter_mut().enumerate() {
            let (row, column) = (at / (6 * m), at % (6 * m));
            *x = stations[row / 3 * 2 * m + column / 3][(row % 3, column % 3)];
        }
        let rows = output(wanted.span_hessian, 9 * k);
        for (at, x) in rows.iter_mut().enumerate() {
            *x = span[at / 9][(at % 9 / 3, at % 3)];
        }
    }
}

/// The output at `first`, `count` numbers set to zero; empty if it is null.
///
/// # Safety
/// `first` is null, or points to `count` numbers.
unsafe fn output<'a>(first: *mut f64, count: usize) -> &'a mut [f64] {
    if first.is_null() || count == 0 {
        return &mut [];
    }
    // SAFETY: as the caller promises.
    let output = unsafe { std::slice::from_raw_parts_mut(first, count) };
    output.fill(0.0);
    output
}

/// The output at `first` as vectors of three numbers.
///
/// # Safety
/// As for [`output`], for `3 count` numbers.
unsafe fn vectors<'a>(first: *mut f64, count: usize) -> &'a mut [Vector] {
    // SAFETY: as the caller promises; a vector of nalgebra is exactly three numbers (`repr(C)`, `repr(transparent)`).
    let numbers = unsafe { output(first, 3 * count) };
    unsafe { std::slice::from_raw_parts_mut(numbers.as_mut_ptr().cast(), numbers.len() / 3) }
}

/// Converts the situation to types of the core and calls with it.
///
/// # Safety
/// `situation` is as the ABI demands.
unsafe fn with_situation(situation: &abi::Situation, call: impl FnOnce(&ConstraintView<'_>, &mut Vec<Matrix>)) {
    let count = situation.station_count as usize;
    let nodes = situation.span_count as usize;
    SCRATCH.with_borrow_mut(|Scratch { stations, targets, blocks }| {
        stations.clear();
        targets.clear();
        // SAFETY: as the caller promises; vectors as in `vectors`.
        let at = unsafe {
            stations.extend(slice(situation.stations, count).iter().map(pose));
            targets.extend(slice(situation.targets, count).iter().map(pose));
            ConstraintView {
                stations,
                targets,
                span: slice(situation.span.cast(), nodes),
                span_lengths: slice(situation.span_lengths, nodes),
                progress: situation.progress,
                memory: slice(situation.memory, situation.memory_count as usize),
                tensions: slice(situation.tensions.cast(), if situation.tensions.is_null() { 0 } else { count }),
            }
        };
        call(&at, blocks);
    });
}
