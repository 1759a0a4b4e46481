//! C functions of a joint model.
//!
//! Their arguments are as the ABI demands: a pointer is null, or points to what the ABI says.

use crate::panics::catch_panics;
use crate::read::{frame, parameters, section, slice, text};
use crate::table::Table;
use std::cell::RefCell;
use std::ffi::c_void;
use wireloom_abi as abi;
use wireloom_core::joint::{Arm, ArmSpring, JointModel, JointShape, JointSpec, Mounting, WireShare};
use wireloom_core::registry::JointKind;
use wireloom_core::{Matrix, Rotation, Section, Vector};

/// Scratch for frames, gradients and blocks of one call.
#[derive(Default)]
struct Scratch {
    frames: Vec<Rotation>,
    gradient: Vec<Vector>,
    blocks: Vec<Matrix>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// The instance behind a `*mut c_void`.
struct Instance {
    model: Box<dyn JointModel>,
    memory: Vec<f64>,
    arms: usize,
}

impl Instance {
    /// Number of frames that it is called with.
    fn frames(&self) -> usize {
        self.arms + usize::from(self.model.mounting() == Mounting::CompliantHub)
    }
}

pub unsafe extern "C" fn create(
    kind: *const abi::Kind,
    said: *const abi::JointSpec,
    instance: *mut *mut c_void,
    description: *mut abi::JointDescription,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file. `kind` was made by this library, so its function table is part of a [`Table`].
    unsafe {
        catch_panics(message, || {
            let kind = &(*(*kind).joint.cast::<Table<abi::JointKind, JointKind>>()).kind;
            let values = slice((*said).values, (*said).value_count as usize);
            let made = (kind.build)(&spec(&*said), &parameters(&kind.parameters, values))
                .map_err(|error| format!("{}; {}", error.message, error.help))?;
            let arms = (*said).arm_count as usize;
            let own = Box::new(Instance { memory: made.memory(), model: made, arms });
            *description = abi::JointDescription {
                size: (*description).size,
                mounting: match own.model.mounting() {
                    Mounting::Point => abi::MOUNTING_POINT,
                    Mounting::Stations => abi::MOUNTING_STATIONS,
                    Mounting::Pose => abi::MOUNTING_POSE,
                    Mounting::CompliantHub => abi::MOUNTING_COMPLIANT_HUB,
                },
                thread_safe: 1,
                has_gradient: 1,
                has_hessian: 1,
                reserved: 0,
                memory: own.memory.as_ptr(),
                memory_count: own.memory.len() as u32,
                reserved_too: 0,
            };
            *instance = Box::into_raw(own).cast();
            Ok(())
        })
    }
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

pub unsafe extern "C" fn evaluate(
    instance: *const c_void,
    frames: *const f64,
    evaluation: *mut abi::JointEvaluation,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file.
    unsafe {
        catch_panics(message, || {
            let Instance { model, memory, .. } = &*instance.cast::<Instance>();
            let wanted = &*evaluation;
            let k = wanted.arm_count as usize;
            SCRATCH.with_borrow_mut(|Scratch { frames: own, gradient, blocks }| {
                own.clear();
                own.extend(slice(frames.cast::<[f64; 4]>(), k).iter().map(frame));
                let shape = JointShape { frames: own, memory: slice(wanted.memory, memory.len()) };
                let mut energy = None;
                if !wanted.gradient.is_null() {
                    gradient.clear();
                    gradient.resize(k, Vector::zeros());
                    energy = Some(model.add_gradient(&shape, gradient));
                    for (a, theta) in gradient.iter().enumerate() {
                        for i in 0..3 {
                            *wanted.gradient.add(3 * a + i) = theta[i];
                        }
                    }
                }
                if let Some(to) = wanted.energy.as_mut() {
                    *to = energy.unwrap_or_else(|| model.energy(&shape));
                }
                if !wanted.hessian.is_null() {
                    blocks.clear();
                    blocks.resize(k * k, Matrix::zeros());
                    model.add_hessian(&shape, blocks);
                    // The model writes the lower triangle of blocks only.
                    for row in 0..3 * k {
                        for column in 0..3 * k {
                            let (a, b) = (row / 3, column / 3);
                            *wanted.hessian.add(row * 3 * k + column) = if b <= a {
                                blocks[a * k + b][(row % 3, column % 3)]
                            } else {
                                blocks[b * k + a][(column % 3, row % 3)]
                            };
                        }
                    }
                }
            });
            Ok(())
        })
    }
}

pub unsafe extern "C" fn commit(
    instance: *const c_void,
    frames: *const f64,
    memory: *mut f64,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file.
    unsafe {
        catch_panics(message, || {
            let own = &*instance.cast::<Instance>();
            if own.memory.is_empty() {
                return Ok(());
            }
            let frames: Vec<Rotation> = slice(frames.cast::<[f64; 4]>(), own.frames()).iter().map(frame).collect();
            let to = std::slice::from_raw_parts_mut(memory, own.memory.len());
            let before = to.to_vec();
            // What it dissipates is not part of the interface.
            let mut dissipated = vec![0.0; own.arms];
            own.model.commit(&JointShape { frames: &frames, memory: &before }, to, &mut dissipated);
            Ok(())
        })
    }
}

/// Converts the specification of a joint.
///
/// # Safety
/// `spec` is as the ABI demands.
unsafe fn spec(spec: &abi::JointSpec) -> JointSpec {
    // SAFETY: `spec` points to data as the ABI demands.
    unsafe {
        let arms = (0..spec.arm_count as usize).map(|a| {
            let arm = &*spec.arms.byte_add(a * spec.arm_stride as usize);
            let branch = text(arm.branch).unwrap_or_default();
            Arm {
                starts_here: arm.starts_here != 0,
                rest: frame(&arm.rest),
                offset: Vector::from(arm.offset),
                section: Section {
                    diameter: arm.diameter,
                    linear_density: arm.linear_density,
                    axial_stiffness: arm.axial_stiffness,
                    shear_stiffness: arm.shear_stiffness,
                    bending_stiffness: arm.bending_stiffness,
                    torsion_stiffness: arm.torsion_stiffness,
                    ..section(&branch)
                },
                segment_length: arm.segment_length,
                length: arm.length,
                curvature: Vector::from(arm.curvature),
                spring: ArmSpring {
                    bending: Some(arm.spring_bending).filter(|k| *k != [0.0; 2]),
                    torsion: Some(arm.spring_torsion).filter(|k| *k != 0.0),
                    friction: Default::default(),
                },
                branch,
            }
        });
        let share =
            |wire: &abi::WireShare| WireShare { from: wire.from as usize, to: wire.to as usize, fraction: wire.share };
        JointSpec {
            name: text(spec.name).unwrap_or_default(),
            arms: arms.collect(),
            wires: slice(spec.wires, spec.wire_count as usize).iter().map(share).collect(),
        }
    }
}
