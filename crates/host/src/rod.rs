//! Rods that a plugin implements: its constitutive laws, on the grid of the built-in rods.

use crate::buffers::{Array, Buffers, Guarded};
use crate::call::{CallSite, call_plugin};
use crate::describe::{KindDescription, abi_value};
use crate::instance::{PluginInstance, UNWRITTEN, note_numeric_derivatives};
use crate::proxy::{DESCRIPTION_OVERRUN, HELP, c_string};
use std::cell::RefCell;
use std::ffi::{CStr, c_void};
use std::iter::repeat_n;
use std::ptr::null_mut;
use std::sync::Arc;
use wireloom_abi as abi;
use wireloom_core::constitutive::{ConstitutiveLaw, ConstitutiveLaws, ConstitutiveSpec, Past, Response};
use wireloom_core::registry::{BuildError, ConstitutiveKind, Parameters, RodKind};
use wireloom_core::{Matrix, Parameter, Vector};

/// A rod kind whose laws a plugin implements; `owner` describes the plugin in messages.
pub fn kind(described: KindDescription, functions: abi::RodKind, owner: Arc<String>) -> RodKind {
    let KindDescription { name, doc, parameters, kind, .. } = described;
    let factory = Factory { name: name.clone(), kind, functions, owner, parameters: parameters.clone() };
    let build = Box::new(move |spec: &_, values: &_| Ok(Box::new(factory.make(spec, values)?)));
    wireloom_models::rods::constitutive::kind(ConstitutiveKind { name, doc, parameters, build })
}

/// Makes laws of a kind.
struct Factory {
    name: String,
    kind: *const abi::Kind,
    functions: abi::RodKind,
    owner: Arc<String>,
    parameters: Vec<Parameter>,
}

// SAFETY: descriptors are never written to, and `create` may be called from any thread.
unsafe impl Send for Factory {}
// SAFETY: likewise.
unsafe impl Sync for Factory {}

impl Factory {
    fn make(&self, spec: &ConstitutiveSpec, values: &Parameters) -> Result<ConstitutiveLaws, BuildError> {
        let owner = &self.owner;
        let site = CallSite::new(&format!("rod `{}` ({}): {owner}", spec.name, self.name));
        let refuse = |what: String| BuildError::new(format!("{owner} {what}"), HELP);
        let name = c_string(&spec.name);
        let values: Vec<abi::Value> =
            self.parameters.iter().map(|p| abi_value(values.0.get(&p.name), &p.form)).collect();
        let section = &spec.section;
        let plain = abi::RodSpec {
            size: size_of::<abi::RodSpec>() as u32,
            value_count: values.len() as u32,
            name: name.as_ptr(),
            values: values.as_ptr(),
            length: spec.length,
            curvature: spec.curvature.into(),
            diameter: section.diameter,
            linear_density: section.linear_density,
            axial_stiffness: section.axial_stiffness,
            shear_stiffness: section.shear_stiffness,
            bending_stiffness: section.bending_stiffness,
            torsion_stiffness: section.torsion_stiffness,
        };
        // SAFETY: all-zero bytes are valid: no size and no laws.
        let mut description: Guarded<abi::RodDescription> = Guarded::new(unsafe { std::mem::zeroed() });
        description.value.size = size_of::<abi::RodDescription>() as u32;
        let create = self.functions.create.expect("descriptors without it are refused");
        // SAFETY: all arguments are as the ABI demands.
        let instance = PluginInstance::create(site, owner.clone(), |instance, text| unsafe {
            create(self.kind, &plain, instance, description.address(), text)
        });
        let mut instance = instance.map_err(refuse)?;
        if description.is_overrun() {
            return Err(refuse(DESCRIPTION_OVERRUN.into()));
        }
        let description = description.value;
        if description.thread_safe != 0 {
            instance.allow_concurrent_calls();
        }
        let numeric = description.has_hessian == 0;
        let numbers = description.memory_count;
        if numbers > MOST_NUMBERS {
            return Err(refuse(format!(
                "says that a coupling remembers {numbers} numbers; at most {MOST_NUMBERS} can be"
            )));
        }
        if numbers > 0 && (self.functions.commit.is_none() || description.has_bend == 0) {
            let what = if description.has_bend == 0 { "law of bending" } else { "function `commit`" };
            return Err(refuse(format!("has a memory of couplings, and no {what}")));
        }
        let shared = Arc::new(Shared { instance, functions: self.functions });
        let law = |has: i32, known: &'static Known, function: Option<Evaluate>, memory: u32| {
            if has == 0 {
                return Ok(None);
            }
            let word = known.function.to_string_lossy();
            let function = function.ok_or_else(|| refuse(format!("has no function `{word}`, which it describes")))?;
            let law = Law { shared: shared.clone(), known, function, numeric, memory: memory as usize };
            Ok(Some(Box::new(law) as Box<dyn ConstitutiveLaw>))
        };
        let laws = ConstitutiveLaws {
            stretch: law(description.has_stretch, &STRETCH, self.functions.stretch, 0)?,
            bend: law(description.has_bend, &BEND, self.functions.bend, numbers)?,
        };
        if laws.stretch.is_none() && laws.bend.is_none() {
            return Err(refuse(
                "has no law of stretch and none of bending: `create` must fill in the description".into(),
            ));
        }
        if numeric {
            note_numeric_derivatives(&self.name, owner, "the Hessian is taken numerically");
        }
        Ok(laws)
    }
}

/// Largest number of state variables of a coupling.
const MOST_NUMBERS: u32 = 1000;

type Evaluate =
    unsafe extern "C" fn(*const c_void, *const f64, response: *mut abi::RodResponse, message: *mut abi::Text) -> i32;

/// What is known of a law before it is called.
struct Known {
    function: &'static CStr,
    /// Names of its arrays: strains, energies, first derivatives, second derivatives.
    arrays: [&'static str; 4],
    /// Strain below which the step of differences does not shrink further.
    least: f64,
}

const STRETCH: Known =
    Known { function: c"stretch", arrays: ["strains", "energies", "forces", "Hessians"], least: 1e-6 };
const BEND: Known = Known { function: c"bend", arrays: ["curvatures", "energies", "moments", "Hessians"], least: 1e-3 };

/// Step of the differences, relative to the strain.
const STEP: f64 = 1e-3;
/// Places and weights of a central difference of fourth order, times 12 steps.
const DIFFERENCE: [(f64, f64); 4] = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];

/// An instance with both of its laws.
struct Shared {
    instance: PluginInstance,
    functions: abi::RodKind,
}

// SAFETY: `create` and `destroy` may be called from any thread; concurrent calls with the same instance are locked out
// unless the plugin allows them.
unsafe impl Send for Shared {}
// SAFETY: likewise.
unsafe impl Sync for Shared {}

impl Drop for Shared {
    fn drop(&mut self) {
        if let Some(destroy) = self.functions.destroy {
            // SAFETY: the instance belongs to this plugin, and no other reference to it exists.
            call_plugin(&self.instance.site, c"destroy", || unsafe { destroy(self.instance.instance) });
        }
    }
}

/// A law of an instance.
struct Law {
    shared: Arc<Shared>,
    known: &'static Known,
    function: Evaluate,
    /// Whether second derivatives are left to the program.
    numeric: bool,
    /// Number of state variables for each strain.
    memory: usize,
}

/// Arrays of one call, and what second derivatives by differences need.
#[derive(Default)]
struct Scratch {
    buffers: Buffers,
    moved: Vec<Vector>,
    gradient: Vec<Vector>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl Law {
    /// Calls the law. What it is asked for is finite, or all NaN.
    fn call(&self, buffers: &mut Buffers, strains: &[Vector], past: Past<'_>, response: &mut Response<'_>) {
        // A trial state of the minimiser may be no state at all: that is not the plugin's fault.
        if !are_finite(strains) || past.memory.len() != self.memory * strains.len() {
            return fill(response, f64::NAN);
        }
        let (n, [in_strains, in_energy, in_gradient, in_hessian]) = (strains.len(), self.known.arrays);
        buffers.clear();
        let input = buffers.add(in_strains, strains.iter().flat_map(|e| [e.x, e.y, e.z]));
        let room = |asked: bool, width: usize| repeat_n(UNWRITTEN, if asked { width * n } else { 0 });
        let energy = buffers.add(in_energy, room(response.energy.is_some(), 1));
        let gradient = buffers.add(in_gradient, room(response.gradient.is_some(), 3));
        let hessian = buffers.add(in_hessian, room(response.hessian.is_some(), 9));
        let memory = buffers.add("memory", past.memory.iter().copied());
        let first = buffers.address();
        // SAFETY: all arrays are in one allocation, which stays as it is during the call.
        let address = |array: Array| unsafe { first.add(buffers.offset(array)) };
        let output = |asked: bool, array: Array| if asked { address(array) } else { null_mut() };
        let mut plain = abi::RodResponse {
            size: size_of::<abi::RodResponse>() as u32,
            count: n as u32,
            energy: output(response.energy.is_some(), energy),
            gradient: output(response.gradient.is_some(), gradient),
            hessian: output(response.hessian.is_some(), hessian),
            memory: output(self.memory > 0, memory),
            duration: past.duration,
        };
        let input = address(input);
        let instance = &self.shared.instance;
        let word = self.known.function.to_str().unwrap_or_default();
        // SAFETY: all arguments are as the ABI demands.
        let call = |own, text| unsafe { (self.function)(own, input, &mut plain, text) };
        let good = instance.call(self.known.function, call)
            && instance.kept_to_its_arrays(buffers, word)
            && instance.finite(in_energy, buffers.get(energy), word)
            && instance.finite(in_gradient, buffers.get(gradient), word)
            && instance.finite(in_hessian, buffers.get(hessian), word);
        if !good {
            return fill(response, f64::NAN);
        }
        if let Some(to) = &mut response.energy {
            to.copy_from_slice(buffers.get(energy));
        }
        if let Some(to) = &mut response.gradient {
            let all = buffers.get(gradient).chunks_exact(3).map(Vector::from_column_slice);
            to.iter_mut().zip(all).for_each(|(to, own)| *to = own);
        }
        if let Some(to) = &mut response.hessian {
            let all = buffers.get(hessian).chunks_exact(9).map(Matrix::from_row_slice);
            to.iter_mut().zip(all).for_each(|(to, own)| *to = own);
        }
    }

    /// Writes second derivatives by differences of the first, for all strains at a time.
    fn differentiate(&self, scratch: &mut Scratch, strains: &[Vector], past: Past<'_>, hessians: &mut [Matrix]) {
        let Scratch { buffers, moved, gradient } = scratch;
        let step = |e: &Vector| STEP * e.norm().max(self.known.least);
        gradient.clear();
        gradient.resize(strains.len(), Vector::zeros());
        hessians.fill(Matrix::zeros());
        for axis in 0..3 {
            for (place, weight) in DIFFERENCE {
                moved.clear();
                moved.extend(strains.iter().map(|e| {
                    let mut to = *e;
                    to[axis] += place * step(e);
                    to
                }));
                let mut response = Response { energy: None, gradient: Some(gradient), hessian: None };
                self.call(buffers, moved, past, &mut response);
                for ((e, force), hessian) in strains.iter().zip(&*gradient).zip(&mut *hessians) {
                    let share = force * (0.5 * weight / (12.0 * step(e)));
                    for row in 0..3 {
                        hessian[(row, axis)] += share[row];
                        hessian[(axis, row)] += share[row];
                    }
                }
            }
        }
    }
}

/// Whether all components of all are.
fn are_finite(strains: &[Vector]) -> bool {
    strains.iter().all(|e| e.x.is_finite() && e.y.is_finite() && e.z.is_finite())
}

/// Writes one number everywhere.
fn fill(response: &mut Response<'_>, number: f64) {
    if let Some(all) = &mut response.energy {
        all.fill(number);
    }
    if let Some(all) = &mut response.gradient {
        all.fill(Vector::repeat(number));
    }
    if let Some(all) = &mut response.hessian {
        all.fill(Matrix::repeat(number));
    }
}

impl ConstitutiveLaw for Law {
    fn respond(&self, strains: &[Vector], past: Past<'_>, response: &mut Response<'_>) {
        if strains.is_empty() {
            return;
        }
        SCRATCH.with_borrow_mut(|scratch| {
            let by_differences = response.hessian.take_if(|_| self.numeric);
            if response.energy.is_some() || response.gradient.is_some() || response.hessian.is_some() {
                self.call(&mut scratch.buffers, strains, past, response);
            }
            if let Some(hessians) = by_differences {
                self.differentiate(scratch, strains, past, hessians);
                response.hessian = Some(hessians);
            }
        });
    }

    fn memory(&self) -> usize {
        self.memory
    }

    fn commit(&self, strains: &[Vector], duration: f64, memory: &mut [f64], dissipated: &mut [f64]) {
        let Some(commit) = self.shared.functions.commit.filter(|_| self.memory > 0 && !strains.is_empty()) else {
            return;
        };
        SCRATCH.with_borrow_mut(|Scratch { buffers, .. }| {
            buffers.clear();
            let input = buffers.add("curvatures", strains.iter().flat_map(|e| [e.x, e.y, e.z]));
            let numbers = buffers.add("memory", memory.iter().copied());
            let lost = buffers.add("dissipated", repeat_n(0.0, strains.len()));
            let first = buffers.address();
            // SAFETY: all arrays are in one allocation, which stays as it is during the call.
            let address = |array: Array| unsafe { first.add(buffers.offset(array)) };
            let mut committed = abi::RodCommit {
                size: size_of::<abi::RodCommit>() as u32,
                count: strains.len() as u32,
                memory: address(numbers),
                dissipated: address(lost),
                duration,
            };
            let input = address(input);
            let instance = &self.shared.instance;
            // SAFETY: all arguments are as the ABI demands.
            let call = |own, text| unsafe { commit(own, input, &mut committed, text) };
            let good = instance.call(c"commit", call)
                && instance.kept_to_its_arrays(buffers, "commit")
                && instance.finite("memory", buffers.get(numbers), "commit")
                && instance.finite("dissipated", buffers.get(lost), "commit");
            if let Some(negative) = buffers.get(lost).iter().find(|x| **x < 0.0) {
                return instance
                    .fail(format!("returned {negative} as dissipated energy in `commit`; it is never negative"));
            }
            if good {
                memory.copy_from_slice(buffers.get(numbers));
                dissipated.copy_from_slice(buffers.get(lost));
            }
        });
    }

    fn fault(&self) -> Option<String> {
        self.shared.instance.fault()
    }
}
