//! Joint models that a plugin implements.

use crate::buffers::{Array, Buffers, Guarded};
use crate::call::{CallSite, call_plugin};
use crate::describe::{KindDescription, abi_value};
use crate::instance::{PluginInstance, UNWRITTEN, note_numeric_derivatives};
use crate::proxy::{DESCRIPTION_OVERRUN, HELP, c_string, memory};
use std::cell::RefCell;
use std::ffi::CString;
use std::iter::repeat_n;
use std::ptr::null_mut;
use std::sync::Arc;
use wireloom_abi as abi;
use wireloom_core::joint::{Arm, JointModel, JointShape, JointSpec, Mounting};
use wireloom_core::registry::{BuildError, JointKind, Parameters};
use wireloom_core::{Matrix, Parameter, Rotation, Vector, numeric};

/// A joint kind that a plugin implements; `owner` describes the plugin in messages.
pub fn kind(described: KindDescription, functions: abi::JointKind, owner: Arc<String>) -> JointKind {
    let KindDescription { name, doc, parameters, kind, .. } = described;
    let factory = Factory { name: name.clone(), kind, functions, owner, parameters: parameters.clone() };
    JointKind { name, doc, parameters, build: Box::new(move |spec, values| Ok(Box::new(factory.make(spec, values)?))) }
}

/// Makes joint models of a kind.
struct Factory {
    name: String,
    kind: *const abi::Kind,
    functions: abi::JointKind,
    owner: Arc<String>,
    parameters: Vec<Parameter>,
}

// SAFETY: descriptors are never written to, and `create` may be called from any thread.
unsafe impl Send for Factory {}
// SAFETY: likewise.
unsafe impl Sync for Factory {}

impl Factory {
    fn make(&self, spec: &JointSpec, values: &Parameters) -> Result<Proxy, BuildError> {
        let owner = &self.owner;
        let site = CallSite::new(&format!("joint `{}` ({}): {owner}", spec.name, self.name));
        let refuse = |what: String| BuildError::new(format!("{owner} {what}"), HELP);
        let name = c_string(&spec.name);
        let branches: Vec<CString> = spec.arms.iter().map(|arm| c_string(&arm.branch)).collect();
        let arms: Vec<abi::Arm> = spec.arms.iter().zip(&branches).map(|(arm, name)| abi_arm(arm, name)).collect();
        let wires: Vec<abi::WireShare> = spec
            .wires
            .iter()
            .map(|wire| abi::WireShare { from: wire.from as u32, to: wire.to as u32, share: wire.fraction })
            .collect();
        let values: Vec<abi::Value> =
            self.parameters.iter().map(|p| abi_value(values.0.get(&p.name), &p.form)).collect();
        let plain = abi::JointSpec {
            size: size_of::<abi::JointSpec>() as u32,
            arm_count: arms.len() as u32,
            arm_stride: size_of::<abi::Arm>() as u32,
            wire_count: wires.len() as u32,
            name: name.as_ptr(),
            arms: arms.as_ptr(),
            wires: wires.as_ptr(),
            values: values.as_ptr(),
            value_count: values.len() as u32,
            reserved: 0,
        };
        // SAFETY: all-zero bytes are valid: no size, no mounting and no derivatives.
        let mut description: Guarded<abi::JointDescription> = Guarded::new(unsafe { std::mem::zeroed() });
        description.value.size = size_of::<abi::JointDescription>() as u32;
        let create = self.functions.create.expect("descriptors without it are refused");
        // SAFETY: all arguments are as the ABI demands.
        let instance = PluginInstance::create(site, owner.clone(), |instance, text| unsafe {
            create(self.kind, &plain, instance, description.address(), text)
        });
        let instance = instance.map_err(refuse)?;
        if description.is_overrun() {
            return Err(refuse(DESCRIPTION_OVERRUN.into()));
        }
        let description = description.value;
        let memory = memory(description.memory, description.memory_count).map_err(refuse)?;
        let note = spec.note_on_coupling();
        let mut proxy = Proxy { instance, functions: self.functions, description, memory, note };
        if description.thread_safe != 0 {
            proxy.instance.allow_concurrent_calls();
        }
        match description.mounting {
            abi::MOUNTING_POSE => return Ok(proxy),
            abi::MOUNTING_POINT | abi::MOUNTING_STATIONS | abi::MOUNTING_COMPLIANT_HUB => {
                if self.functions.evaluate.is_none() {
                    return Err(refuse("has no function `evaluate`".into()));
                }
            }
            0 => return Err(refuse("wrote no mounting: `create` must fill in the description".into())),
            other => return Err(refuse(format!("has mounting {other}; 1 to 4 are known"))),
        }
        match (description.has_gradient != 0, description.has_hessian != 0) {
            (true, true) => {}
            (true, false) => note_numeric_derivatives(&self.name, owner, "the Hessian is taken numerically"),
            (false, _) => note_numeric_derivatives(&self.name, owner, "gradient and Hessian are taken numerically"),
        }
        Ok(proxy)
    }
}

fn abi_arm(arm: &Arm, branch: &CString) -> abi::Arm {
    abi::Arm {
        branch: branch.as_ptr(),
        starts_here: i32::from(arm.starts_here),
        reserved: 0,
        rest: abi_quaternion(&arm.rest),
        offset: arm.offset.into(),
        curvature: arm.curvature.into(),
        segment_length: arm.segment_length,
        length: arm.length,
        diameter: arm.section.diameter,
        linear_density: arm.section.linear_density,
        axial_stiffness: arm.section.axial_stiffness,
        shear_stiffness: arm.section.shear_stiffness,
        bending_stiffness: arm.section.bending_stiffness,
        torsion_stiffness: arm.section.torsion_stiffness,
        spring_bending: arm.spring.bending.unwrap_or_default(),
        spring_torsion: arm.spring.torsion.unwrap_or_default(),
    }
}

fn abi_quaternion(q: &Rotation) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// A joint model that a plugin implements.
struct Proxy {
    instance: PluginInstance,
    functions: abi::JointKind,
    description: abi::JointDescription,
    memory: Vec<f64>,
    /// What it is not told.
    note: Option<String>,
}

// SAFETY: `create` and `destroy` may be called from any thread; concurrent calls with the same instance are locked out
// unless the plugin allows them.
unsafe impl Send for Proxy {}
// SAFETY: likewise.
unsafe impl Sync for Proxy {}

impl Drop for Proxy {
    fn drop(&mut self) {
        if let Some(destroy) = self.functions.destroy {
            // SAFETY: the instance belongs to this plugin, and no other reference to it exists.
            call_plugin(&self.instance.site, c"destroy", || unsafe { destroy(self.instance.instance) });
        }
    }
}

thread_local! {
    /// Arrays of one call.
    static BUFFERS: RefCell<Buffers> = RefCell::default();
}

/// Output that `evaluate` is to compute.
#[derive(Clone, Copy, PartialEq)]
enum Output {
    Energy,
    Gradient,
    Hessian,
}

impl Proxy {
    /// Evaluates; `take` receives the requested derivatives. Returns the energy, J. All values are finite, or all NaN.
    fn evaluate(&self, shape: &JointShape<'_>, asked: Output, take: impl FnOnce(&[f64])) -> f64 {
        let JointShape { frames, memory } = *shape;
        let evaluate = self.functions.evaluate.expect("checked when the proxy was made");
        BUFFERS.with_borrow_mut(|buffers| {
            let n = 3 * frames.len();
            let (derivatives, wanted) = match asked {
                Output::Energy => (0, ["energy", "nothing"]),
                Output::Gradient => (n, ["energy", "gradient"]),
                Output::Hessian => (n * n, ["nothing", "Hessian"]),
            };
            buffers.clear();
            let turns = buffers.add("frames", frames.iter().flat_map(abi_quaternion));
            let energy = buffers.add(wanted[0], repeat_n(UNWRITTEN, usize::from(asked != Output::Hessian)));
            let numbers = buffers.add(wanted[1], repeat_n(UNWRITTEN, derivatives));
            let remembered = buffers.add("memory", memory.iter().copied());
            let first = buffers.address();
            // SAFETY: all arrays are in one allocation, which stays as it is during the call.
            let address = |array: Array| unsafe { first.add(buffers.offset(array)) };
            let output = |wanted: bool, array: Array| if wanted { address(array) } else { null_mut() };
            let mut evaluation = abi::JointEvaluation {
                size: size_of::<abi::JointEvaluation>() as u32,
                arm_count: frames.len() as u32,
                energy: output(asked != Output::Hessian, energy),
                gradient: output(asked == Output::Gradient, numbers),
                hessian: output(asked == Output::Hessian, numbers),
                memory: output(!memory.is_empty(), remembered),
            };
            let turns = address(turns);
            // SAFETY: all arguments are as the ABI demands.
            let call = |own, text| unsafe { evaluate(own, turns, &mut evaluation, text) };
            let good = self.instance.call(c"evaluate", call)
                && self.instance.kept_to_its_arrays(buffers, "evaluate")
                && self.instance.finite("energy", buffers.get(energy), "evaluate")
                && self.instance.finite(wanted[1], buffers.get(numbers), "evaluate");
            if good {
                take(buffers.get(numbers));
                buffers.get(energy).first().copied().unwrap_or(0.0)
            } else {
                take(&vec![f64::NAN; derivatives]);
                f64::NAN
            }
        })
    }

    /// Gradient of the energy, of a plugin that gives it.
    fn gradient(&self, shape: &JointShape<'_>, slopes: &mut [Vector]) {
        self.evaluate(shape, Output::Gradient, |g| {
            slopes.iter_mut().zip(g.chunks_exact(3)).for_each(|(to, theta)| *to = Vector::from_row_slice(theta));
        });
    }
}

impl JointModel for Proxy {
    fn notes(&self) -> Vec<String> {
        self.note.iter().cloned().collect()
    }

    fn mounting(&self) -> Mounting {
        match self.description.mounting {
            abi::MOUNTING_POSE => Mounting::Pose,
            abi::MOUNTING_STATIONS => Mounting::Stations,
            abi::MOUNTING_COMPLIANT_HUB => Mounting::CompliantHub,
            _ => Mounting::Point,
        }
    }

    fn energy(&self, shape: &JointShape<'_>) -> f64 {
        if self.mounting() == Mounting::Pose { 0.0 } else { self.evaluate(shape, Output::Energy, |_| {}) }
    }

    fn add_gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> f64 {
        if self.mounting() == Mounting::Pose {
            return 0.0;
        }
        if self.description.has_gradient == 0 {
            let mut slopes = vec![Vector::zeros(); shape.frames.len()];
            numeric::gradient_of_frames(shape, &|shape| JointModel::energy(self, shape), &mut slopes);
            gradient.iter_mut().zip(slopes).for_each(|(to, slope)| *to += slope);
            return self.evaluate(shape, Output::Energy, |_| {});
        }
        self.evaluate(shape, Output::Gradient, |g| {
            for (to, theta) in gradient.iter_mut().zip(g.chunks_exact(3)) {
                *to += Vector::from_row_slice(theta);
            }
        })
    }

    fn add_hessian(&self, shape: &JointShape<'_>, hessian: &mut [Matrix]) {
        let k = shape.frames.len();
        if self.mounting() == Mounting::Pose {
            return;
        }
        if self.description.has_hessian == 0 {
            if self.description.has_gradient == 0 {
                numeric::add_hessian_of_energy_of_frames(shape, &|shape| JointModel::energy(self, shape), hessian);
            } else {
                numeric::add_hessian_of_frames(shape, &|shape, slopes| self.gradient(shape, slopes), hessian);
            }
            return;
        }
        self.evaluate(shape, Output::Hessian, |rows| {
            for a in 0..k {
                for b in 0..=a {
                    hessian[a * k + b] += Matrix::from_fn(|i, j| rows[(3 * a + i) * 3 * k + 3 * b + j]);
                }
            }
        });
    }

    fn memory(&self) -> Vec<f64> {
        self.memory.clone()
    }

    fn commit(&self, shape: &JointShape<'_>, memory: &mut [f64], _: &mut [f64]) {
        let Some(commit) = self.functions.commit.filter(|_| !memory.is_empty()) else { return };
        BUFFERS.with_borrow_mut(|buffers| {
            buffers.clear();
            let turns = buffers.add("frames", shape.frames.iter().flat_map(abi_quaternion));
            let numbers = buffers.add("memory", memory.iter().copied());
            let first = buffers.address();
            // SAFETY: all arrays are in one allocation, which stays as it is during the call.
            let address = |array: Array| unsafe { first.add(buffers.offset(array)) };
            let (turns, to) = (address(turns), address(numbers));
            // SAFETY: all arguments are as the ABI demands; there are as many numbers as in the memory.
            let call = |own, text| unsafe { commit(own, turns, to, text) };
            let good = self.instance.call(c"commit", call)
                && self.instance.kept_to_its_arrays(buffers, "commit")
                && self.instance.finite("memory", buffers.get(numbers), "commit");
            if good {
                memory.copy_from_slice(buffers.get(numbers));
            }
        });
    }

    fn fault(&self) -> Option<String> {
        self.instance.fault()
    }
}
