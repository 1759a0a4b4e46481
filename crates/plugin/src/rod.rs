//! C functions of a rod.
//!
//! Their arguments are as the ABI demands: a pointer is null, or points to what the ABI says.

use crate::panics::catch_panics;
use crate::read::{parameters, section, slice, slice_mut, text};
use crate::table::Table;
use std::cell::RefCell;
use std::ffi::c_void;
use wireloom_abi as abi;
use wireloom_core::constitutive::{ConstitutiveLaw, ConstitutiveLaws, ConstitutiveSpec, Past, Response};
use wireloom_core::registry::ConstitutiveKind;
use wireloom_core::{Matrix, Section, Vector};

/// Scratch for strains and derivatives of one call.
#[derive(Default)]
struct Scratch {
    strains: Vec<Vector>,
    energy: Vec<f64>,
    gradient: Vec<Vector>,
    hessian: Vec<Matrix>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

pub unsafe extern "C" fn create(
    kind: *const abi::Kind,
    said: *const abi::RodSpec,
    instance: *mut *mut c_void,
    description: *mut abi::RodDescription,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file. `kind` was made by this library, so its function table is part of a [`Table`].
    unsafe {
        catch_panics(message, || {
            let kind = &(*(*kind).rod.cast::<Table<abi::RodKind, ConstitutiveKind>>()).kind;
            let values = slice((*said).values, (*said).value_count as usize);
            let own = (kind.build)(&spec(&*said), &parameters(&kind.parameters, values))
                .map_err(|error| format!("{}; {}", error.message, error.help))?;
            *description = abi::RodDescription {
                size: (*description).size,
                has_stretch: i32::from(own.stretch.is_some()),
                has_bend: i32::from(own.bend.is_some()),
                has_hessian: 1,
                thread_safe: 1,
                memory_count: own.memory() as u32,
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
            drop(Box::from_raw(instance.cast::<ConstitutiveLaws>()));
            Ok(())
        });
    }
}

pub unsafe extern "C" fn stretch(
    instance: *const c_void,
    strains: *const f64,
    response: *mut abi::RodResponse,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file.
    unsafe { catch_panics(message, || respond(&(*instance.cast::<ConstitutiveLaws>()).stretch, strains, &*response)) }
}

pub unsafe extern "C" fn bend(
    instance: *const c_void,
    strains: *const f64,
    response: *mut abi::RodResponse,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file.
    unsafe { catch_panics(message, || respond(&(*instance.cast::<ConstitutiveLaws>()).bend, strains, &*response)) }
}

pub unsafe extern "C" fn commit(
    instance: *const c_void,
    strains: *const f64,
    committed: *mut abi::RodCommit,
    message: *mut abi::Text,
) -> i32 {
    // SAFETY: see the top of this file.
    unsafe {
        catch_panics(message, || {
            let law = (*instance.cast::<ConstitutiveLaws>()).bend.as_ref().ok_or("it has no such law")?;
            let abi::RodCommit { count, memory, dissipated, duration, .. } = *committed;
            let n = count as usize;
            let strains: Vec<Vector> = read_strains(strains, n).collect();
            let memory = slice_mut(memory, n * law.memory());
            law.commit(&strains, duration, memory, slice_mut(dissipated, n));
            Ok(())
        })
    }
}

/// # Safety
/// `strains` points to so many vectors.
unsafe fn read_strains<'a>(strains: *const f64, count: usize) -> impl Iterator<Item = Vector> + 'a {
    // SAFETY: as the caller promises.
    unsafe { slice(strains.cast::<[f64; 3]>(), count) }.iter().map(|e| Vector::from(*e))
}

/// # Safety
/// `strains` and `asked` are as the ABI demands.
unsafe fn respond(
    law: &Option<Box<dyn ConstitutiveLaw>>,
    strains: *const f64,
    asked: &abi::RodResponse,
) -> Result<(), String> {
    let law = law.as_ref().ok_or("it has no such law")?;
    let n = asked.count as usize;
    SCRATCH.with_borrow_mut(|Scratch { strains: own, energy, gradient, hessian }| {
        own.clear();
        // SAFETY: as the caller promises.
        own.extend(unsafe { read_strains(strains, n) });
        let numbers = if asked.memory.is_null() { 0 } else { n * law.memory() };
        // SAFETY: as the caller promises.
        let past = Past { memory: unsafe { slice(asked.memory, numbers) }, duration: asked.duration };
        let mut response = Response {
            energy: room(energy, n, asked.energy.is_null(), f64::NAN),
            gradient: room(gradient, n, asked.gradient.is_null(), Vector::repeat(f64::NAN)),
            hessian: room(hessian, n, asked.hessian.is_null(), Matrix::repeat(f64::NAN)),
        };
        law.respond(own, past, &mut response);
        // SAFETY: as the caller promises; arrays that are not asked for are empty.
        unsafe {
            for (k, own) in energy.iter().enumerate() {
                *asked.energy.add(k) = *own;
            }
            for (k, own) in gradient.iter().flat_map(|force| force.iter()).enumerate() {
                *asked.gradient.add(k) = *own;
            }
            // Row by row: of the transpose that is column by column.
            for (k, own) in hessian.iter().enumerate() {
                for (entry, value) in own.transpose().iter().enumerate() {
                    *asked.hessian.add(9 * k + entry) = *value;
                }
            }
        }
    });
    Ok(())
}

/// Room for an output, if it is asked for.
fn room<T: Clone>(all: &mut Vec<T>, count: usize, unasked: bool, unwritten: T) -> Option<&mut [T]> {
    all.clear();
    if unasked {
        return None;
    }
    all.resize(count, unwritten);
    Some(all)
}

/// Converts the specification of a branch.
///
/// # Safety
/// `spec` is as the ABI demands.
unsafe fn spec(spec: &abi::RodSpec) -> ConstitutiveSpec {
    // SAFETY: as the caller promises.
    let name = unsafe { text(spec.name) }.unwrap_or_default();
    let stated = Section {
        diameter: spec.diameter,
        linear_density: spec.linear_density,
        axial_stiffness: spec.axial_stiffness,
        shear_stiffness: spec.shear_stiffness,
        bending_stiffness: spec.bending_stiffness,
        torsion_stiffness: spec.torsion_stiffness,
        ..section(&name)
    };
    ConstitutiveSpec { name, section: stated, length: spec.length, curvature: Vector::from(spec.curvature) }
}
