//! Constraints that a plugin implements.
//!
//! The first error is kept as the constraint's fault. After that the plugin is not called again, and all values are
//! NaN.

use crate::buffers::{Array, Buffers, Guarded};
use crate::call::{CallSite, call_plugin, floating_point_changes};
use crate::describe::{KindDescription, abi_value};
use crate::instance::{PluginInstance, UNWRITTEN, locked, note_numeric_derivatives, numeric_derivatives};
use crate::read::Message;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ffi::{CStr, CString, c_void};
use std::iter::repeat_n;
use std::ptr::{null, null_mut};
use std::sync::{Arc, Mutex};
use wireloom_abi as abi;
use wireloom_abi::draft::Notes;
use wireloom_core::constraint::{Attaches, ConstraintSpec, ConstraintView, Equations, HoldWord, Relation, Residual};
use wireloom_core::registry::{BuildError, ConstraintKind, Output, Parameters};
use wireloom_core::{Action, Constraint, Hold, Matrix, Pose, Potential, RotationHold, Vector, numeric};

/// Upper limit for the numbers in the memory of a part and for the residuals of a constraint.
const MOST: u32 = 4096;
/// What is wrong with a `create` that writes too much.
pub const DESCRIPTION_OVERRUN: &str = "wrote beyond the end of the description in `create`";
pub const HELP: &str = "`wireloom plugin check` on the file tells more; its author can fix it";

/// Notes of plugins on their constraints.
static NOTES: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
/// Upper limit for the notes of a constraint.
const MOST_NOTES: u32 = 16;

/// Notes for the engineer on all constraints of plugins in this process: the plugins' own notes, missing derivatives,
/// and changes of the floating-point unit.
pub fn notes() -> Vec<String> {
    locked(&NOTES).iter().cloned().chain(numeric_derivatives()).chain(floating_point_changes()).collect()
}

/// A constraint kind that a plugin implements; `owner` describes the plugin in messages.
pub fn kind(
    described: KindDescription,
    (functions, attaches, outputs): (abi::ConstraintKind, Attaches, Vec<Output>),
    owner: Arc<String>,
    notes: Option<Notes>,
) -> ConstraintKind {
    let KindDescription { name, doc, parameters, kind, .. } = described;
    let parameters_of = parameters.clone();
    let factory = Factory {
        name: name.clone(),
        kind,
        functions,
        owner,
        parameters: parameters_of,
        outputs: outputs.clone(),
        notes,
    };
    ConstraintKind {
        name,
        doc,
        attaches,
        parameters,
        outputs,
        build: Box::new(move |spec, values| Ok(Box::new(factory.make(spec, values)?))),
    }
}

/// Makes constraints of a kind.
struct Factory {
    name: String,
    kind: *const abi::Kind,
    functions: abi::ConstraintKind,
    owner: Arc<String>,
    parameters: Vec<wireloom_core::Parameter>,
    outputs: Vec<Output>,
    notes: Option<Notes>,
}

// SAFETY: descriptors are never written to, and `create` may be called from any thread.
unsafe impl Send for Factory {}
// SAFETY: likewise.
unsafe impl Sync for Factory {}

impl Factory {
    fn make(&self, spec: &ConstraintSpec, values: &Parameters) -> Result<Proxy, BuildError> {
        let owner = &self.owner;
        let site = CallSite::new(&format!("constraint `{}` ({}): {owner}", spec.name, self.name));
        let refuse = |what: String| BuildError::new(format!("{owner} {what}"), HELP);
        let name = c_string(&spec.name);
        let branches: Vec<Option<CString>> =
            spec.stations.iter().map(|station| station.place.as_ref().map(|(branch, _)| c_string(branch))).collect();
        let stations: Vec<abi::Station> = spec
            .stations
            .iter()
            .zip(&branches)
            .map(|(station, branch)| abi::Station {
                branch: branch.as_ref().map_or(null(), |branch| branch.as_ptr()),
                arc_length: station.place.as_ref().map_or(0.0, |(_, s)| *s),
                diameter: station.diameter,
            })
            .collect();
        let span_branch = spec.span.as_ref().map(|span| c_string(&span.branch)).unwrap_or_default();
        let span = spec.span.as_ref().map(|span| abi::Span {
            size: size_of::<abi::Span>() as u32,
            reserved: 0,
            branch: span_branch.as_ptr(),
            begins: span.range.0,
            ends: span.range.1,
            diameter: span.diameter,
        });
        let values: Vec<abi::Value> =
            self.parameters.iter().map(|p| abi_value(values.0.get(&p.name), &p.form)).collect();
        let mut rails = [[0.0; 3]; 2];
        for (to, rail) in rails.iter_mut().zip(&spec.rails) {
            *to = (*rail).into();
        }
        let plain = abi::ConstraintSpec {
            size: size_of::<abi::ConstraintSpec>() as u32,
            station_count: stations.len() as u32,
            station_stride: size_of::<abi::Station>() as u32,
            value_count: values.len() as u32,
            name: name.as_ptr(),
            stations: stations.as_ptr(),
            span: span.as_ref().map_or(null(), |span| span),
            values: values.as_ptr(),
            tangent_given: i32::from(spec.tangent_given),
            up_given: i32::from(spec.up_given),
            hold: spec.hold.iter().flatten().map(|word| abi_hold(*word)).fold(0, |all, bit| all | bit),
            free_axis_given: i32::from(spec.free_axis.is_some()),
            free_axis: spec.free_axis.map_or([0.0; 3], |axis| (*axis).into()),
            rails,
            rail_count: spec.rails.len().min(2) as u32,
            reserved: 0,
        };
        // SAFETY: all-zero bytes are valid: no size, no shape, no numbers and null pointers.
        let mut description: Guarded<abi::Description> = Guarded::new(unsafe { std::mem::zeroed() });
        description.value.size = size_of::<abi::Description>() as u32;
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
        let mut proxy = Proxy {
            instance,
            functions: self.functions,
            description,
            stations: spec.stations.len(),
            hold: Hold { position: false, rails: vec![], rotation: RotationHold::Free },
            memory: vec![],
            residuals: [vec![], vec![]],
            outputs: self.outputs.clone(),
        };
        if description.thread_safe != 0 {
            proxy.instance.allow_concurrent_calls();
        }
        proxy.validate(&self.functions).map_err(refuse)?;
        self.collect_notes(spec, &proxy);
        let missing = match (description.has_gradient != 0, description.has_hessian != 0, description.shape) {
            (_, _, abi::SHAPE_PRESCRIBED) | (true, true, _) => return Ok(proxy),
            (false, _, abi::SHAPE_EQUATIONS) => "the Jacobian is taken numerically, second derivatives are left out",
            (true, false, abi::SHAPE_EQUATIONS) => "second derivatives are left out",
            (false, _, abi::SHAPE_POTENTIAL_AND_EQUATIONS) => {
                "gradient, Hessian and Jacobian are taken numerically, second derivatives of residuals are left out"
            }
            (true, false, abi::SHAPE_POTENTIAL_AND_EQUATIONS) => {
                "the Hessian is taken numerically, second derivatives of residuals are left out"
            }
            (false, ..) => "gradient and Hessian are taken numerically",
            (true, false, _) => "the Hessian is taken numerically",
        };
        note_numeric_derivatives(&self.name, owner, missing);
        Ok(proxy)
    }
}

impl Factory {
    /// Collects the plugin's notes on the constraint.
    fn collect_notes(&self, spec: &ConstraintSpec, proxy: &Proxy) {
        let Some(note) = self.notes.and_then(|notes| notes.note) else { return };
        let kind = c_string(&self.name);
        for index in 0..MOST_NOTES {
            let mut message = Message::new();
            let mut text = message.text();
            // SAFETY: all arguments are as the ABI demands.
            let status = call_plugin(&proxy.instance.site, c"note", || unsafe {
                note(kind.as_ptr(), proxy.instance.instance, index, &mut text)
            });
            if status != abi::STATUS_OK {
                return;
            }
            locked(&NOTES).insert(format!("constraint `{}` ({}): {}", spec.name, self.name, message.words()));
        }
    }
}

pub fn c_string(words: &str) -> CString {
    CString::new(words.replace('\0', "")).unwrap_or_default()
}

fn abi_hold(word: HoldWord) -> i32 {
    match word {
        HoldWord::Position => abi::HOLD_POSITION,
        HoldWord::Tangent => abi::HOLD_TANGENT,
        HoldWord::Twist => abi::HOLD_TWIST,
    }
}

/// A constraint that a plugin implements.
struct Proxy {
    instance: PluginInstance,
    functions: abi::ConstraintKind,
    description: abi::Description,
    stations: usize,
    hold: Hold,
    memory: Vec<f64>,
    residuals: [Vec<Residual>; 2],
    outputs: Vec<Output>,
}

// SAFETY: `create` and `destroy` may be called from any thread; concurrent calls with the same instance are locked out
// unless the plugin allows them. Pointers of the description are read only while the proxy is made.
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

/// Outputs that `evaluate` is to compute.
type Evaluation = abi::Evaluation;

const NOTHING: Evaluation = Evaluation {
    size: size_of::<Evaluation>() as u32,
    reserved: 0,
    energy: null_mut(),
    gradient: null_mut(),
    span_gradient: null_mut(),
    hessian: null_mut(),
    span_hessian: null_mut(),
    residuals: null_mut(),
    jacobian: null_mut(),
    span_jacobian: null_mut(),
    weights: null(),
};

/// An output of `evaluate`.
#[derive(Clone, Copy)]
enum Part {
    Energy,
    Gradient,
    SpanGradient,
    Hessian,
    SpanHessian,
    Residuals,
    Jacobian,
    SpanJacobian,
}

impl Part {
    /// Name in messages.
    fn word(self) -> &'static str {
        match self {
            Self::Energy => "energy",
            Self::Gradient => "gradient",
            Self::SpanGradient => "gradient of the span",
            Self::Hessian => "Hessian",
            Self::SpanHessian => "Hessian of the span",
            Self::Residuals => "residuals",
            Self::Jacobian => "Jacobian",
            Self::SpanJacobian => "Jacobian of the span",
        }
    }

    /// Its place among the outputs.
    fn of(self, evaluation: &mut Evaluation) -> &mut *mut f64 {
        match self {
            Self::Energy => &mut evaluation.energy,
            Self::Gradient => &mut evaluation.gradient,
            Self::SpanGradient => &mut evaluation.span_gradient,
            Self::Hessian => &mut evaluation.hessian,
            Self::SpanHessian => &mut evaluation.span_hessian,
            Self::Residuals => &mut evaluation.residuals,
            Self::Jacobian => &mut evaluation.jacobian,
            Self::SpanJacobian => &mut evaluation.span_jacobian,
        }
    }
}

thread_local! {
    /// Arrays of one call.
    static BUFFERS: RefCell<Buffers> = RefCell::default();
}

impl Proxy {
    /// Checks the description that `create` wrote.
    fn validate(&mut self, functions: &abi::ConstraintKind) -> Result<(), String> {
        let said = self.description;
        if !(abi::SHAPE_PRESCRIBED..=abi::SHAPE_POTENTIAL_AND_EQUATIONS).contains(&said.shape) {
            return Err(match said.shape {
                0 => "wrote no shape: `create` must fill in the description".into(),
                other => format!("has shape {other}; 1 to 4 are known"),
            });
        }
        if said.shape == abi::SHAPE_PRESCRIBED {
            if self.stations != 1 {
                return Err(format!("prescribes freedoms of {} stations; only one station is allowed", self.stations));
            }
            self.hold = hold(&said.hold)?;
        } else if functions.evaluate.is_none() {
            return Err("has no function `evaluate`".into());
        }
        self.memory = memory(said.memory, said.memory_count)?;
        if [abi::SHAPE_EQUATIONS, abi::SHAPE_POTENTIAL_AND_EQUATIONS].contains(&said.shape) {
            let all = said.residual_count.saturating_add(said.node_residual_count);
            if all == 0 {
                return Err("has no residuals: equations need at least one".into());
            }
            let scales = numbers(said.scales, all, "residuals", 1.0)?;
            if let Some(scale) = scales.iter().find(|scale| !(scale.is_finite() && **scale > 0.0)) {
                return Err(format!("scales a residual by {scale}; a scale must be positive"));
            }
            let relation = |k: usize| {
                // SAFETY: null, or one entry per residual.
                let inequality = !said.inequalities.is_null() && unsafe { *said.inequalities.add(k) } != 0;
                if inequality { Relation::NotPositive } else { Relation::Zero }
            };
            let residual = |(k, scale): (usize, &f64)| Residual { relation: relation(k), scale: *scale };
            let mut all: Vec<Residual> = scales.iter().enumerate().map(residual).collect();
            let of_each_node = all.split_off(said.residual_count as usize);
            self.residuals = [all, of_each_node];
        }
        Ok(())
    }

    /// Calls `function` with the situation as the ABI has it and with further `arrays`, whose addresses it is given.
    /// Then `take` receives these arrays, and says whether they are good. Returns whether all went well.
    fn with_situation<const N: usize>(
        &self,
        at: &ConstraintView<'_>,
        function: &'static CStr,
        arrays: impl FnOnce(&mut Buffers) -> [Array; N],
        call: impl FnOnce(*const c_void, &abi::Situation, [*mut f64; N], *mut abi::Text) -> i32,
        take: impl FnOnce([&[f64]; N]) -> bool,
    ) -> bool {
        BUFFERS.with_borrow_mut(|buffers| {
            buffers.clear();
            let stations = buffers.add("stations", at.stations.iter().flat_map(pose_numbers));
            let targets = buffers.add("targets", at.targets.iter().flat_map(pose_numbers));
            let span = buffers.add("span", at.span.iter().flat_map(|x| [x.x, x.y, x.z]));
            let span_lengths = buffers.add("span_lengths", at.span_lengths.iter().copied());
            let memory = buffers.add("memory", at.memory.iter().copied());
            let tensions = buffers.add("tensions", at.tensions.iter().copied().flatten());
            let arrays = arrays(buffers);
            let first = buffers.address();
            // SAFETY: all arrays are in one allocation, which stays as it is during the call.
            let address = |array: Array| unsafe { first.add(buffers.offset(array)) };
            let situation = abi::Situation {
                size: size_of::<abi::Situation>() as u32,
                station_count: at.stations.len() as u32,
                span_count: at.span.len() as u32,
                memory_count: at.memory.len() as u32,
                // A pose is seven numbers.
                stations: address(stations).cast(),
                targets: address(targets).cast(),
                span: address(span),
                span_lengths: address(span_lengths),
                memory: address(memory),
                progress: at.progress,
                tensions: if at.tensions.is_empty() { null() } else { address(tensions) },
            };
            let addresses = arrays.map(address);
            self.instance.call(function, |own, text| call(own, &situation, addresses, text))
                && self.instance.kept_to_its_arrays(buffers, &function.to_string_lossy())
                && take(arrays.map(|array| buffers.get(array)))
        })
    }

    /// Evaluates these parts, of so many numbers each; `take` receives them if all are finite. Returns whether they
    /// are.
    fn evaluate<const N: usize>(
        &self,
        at: &ConstraintView<'_>,
        wanted: [(Part, usize); N],
        weights: &[f64],
        take: impl FnOnce([&[f64]; N]),
    ) -> bool {
        let evaluate = self.functions.evaluate.expect("checked when the proxy was made");
        let mut evaluation = NOTHING;
        let arrays = |buffers: &mut Buffers| {
            wanted.map(|(part, numbers)| buffers.add(part.word(), repeat_n(UNWRITTEN, numbers)))
        };
        let call = |own, situation: &abi::Situation, addresses: [*mut f64; N], text| {
            for ((part, _), address) in wanted.iter().zip(addresses) {
                *part.of(&mut evaluation) = address;
            }
            if !weights.is_empty() {
                evaluation.weights = weights.as_ptr();
            }
            // SAFETY: all arguments are as the ABI demands.
            unsafe { evaluate(own, situation, &mut evaluation, text) }
        };
        self.with_situation(at, c"evaluate", arrays, call, |arrays| {
            let finite = wanted
                .iter()
                .zip(arrays)
                .all(|((part, _), numbers)| self.instance.finite(part.word(), numbers, "evaluate"));
            if finite {
                take(arrays);
            }
            finite
        })
    }

    fn energy_alone(&self, at: &ConstraintView<'_>) -> f64 {
        let mut energy = f64::NAN;
        self.evaluate(at, [(Part::Energy, 1)], &[], |[found]| energy = found[0]);
        energy
    }

    fn residuals_alone(&self, at: &ConstraintView<'_>, c: &mut [f64]) {
        let wanted = [(Part::Residuals, c.len())];
        c.fill(f64::NAN);
        self.evaluate(at, wanted, &[], |[found]| c.copy_from_slice(found));
    }

    /// Copies second derivatives from the plugin's rows to the core's blocks.
    fn second_derivatives(&self, at: &ConstraintView<'_>, w: &[f64], stations: &mut [Matrix], span: &mut [Matrix]) {
        let (m, k) = (at.stations.len(), at.span.len());
        stations.fill(Matrix::repeat(f64::NAN));
        span.fill(Matrix::repeat(f64::NAN));
        let wanted = [(Part::Hessian, 36 * m * m), (Part::SpanHessian, 9 * k)];
        self.evaluate(at, wanted, w, |[of_stations, of_span]| {
            for (at, x) in of_stations.iter().enumerate() {
                let (row, column) = (at / (6 * m), at % (6 * m));
                stations[row / 3 * 2 * m + column / 3][(row % 3, column % 3)] = *x;
            }
            for (at, x) in of_span.iter().enumerate() {
                span[at / 9][(at % 9 / 3, at % 3)] = *x;
            }
        });
    }
}

impl Constraint for Proxy {
    fn action(&self) -> Action<'_> {
        match self.description.shape {
            abi::SHAPE_PRESCRIBED => Action::Prescribed(&self.hold),
            abi::SHAPE_POTENTIAL => Action::Potential(self),
            abi::SHAPE_EQUATIONS => Action::Equations(self),
            _ => Action::PotentialAndEquations(self, self),
        }
    }

    fn needs_frame(&self) -> bool {
        match self.description.shape {
            abi::SHAPE_PRESCRIBED => self.hold.rotation != RotationHold::Free,
            _ => self.description.needs_frames != 0,
        }
    }

    fn objective(&self) -> bool {
        self.description.objective != 0
    }

    fn target(&self, base: &Pose, progress: f64) -> Pose {
        let Some(target) = self.functions.target else { return *base };
        let base = abi_pose(base);
        let mut to = Guarded::new(abi::Pose { position: [UNWRITTEN; 3], orientation: [UNWRITTEN; 4] });
        let address = to.address();
        // SAFETY: all arguments are as the ABI demands.
        let done = self.instance.call(c"target", |own, text| unsafe { target(own, &base, progress, address, text) });
        if to.is_overrun() {
            self.instance.fail("wrote beyond the end of the target's pose (in `target`)".to_owned());
        }
        let to = to.value;
        let q = to.orientation;
        let [w, x, y, z] = q;
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        if done
            && self.instance.finite("target's position", &to.position, "target")
            && self.instance.finite("target's orientation", &q, "target")
        {
            if (norm - 1.0).abs() < 1e-6 {
                return pose(to.position, q);
            }
            self.instance.fail(format!(
                "returned a target with orientation [{w}, {x}, {y}, {z}], of length {norm} instead of 1"
            ));
        }
        pose(base.position, base.orientation)
    }

    fn memory(&self) -> Vec<f64> {
        self.memory.clone()
    }

    fn commit(&self, at: &ConstraintView<'_>, memory: &mut [f64]) {
        let Some(commit) = self.functions.commit else { return };
        let before = memory.to_vec();
        self.with_situation(
            at,
            c"commit",
            |buffers| [buffers.add("memory", before)],
            // SAFETY: all arguments are as the ABI demands; there are as many numbers as in the memory.
            |own, situation, [to], text| unsafe { commit(own, situation, to, text) },
            |[found]| {
                let finite = self.instance.finite("memory", found, "commit");
                if finite {
                    memory.copy_from_slice(found);
                }
                finite
            },
        );
    }

    fn outputs(&self, at: &ConstraintView<'_>) -> Vec<(String, f64)> {
        let Some(report) = self.functions.report.filter(|_| !self.outputs.is_empty()) else { return Vec::new() };
        let mut values = vec![];
        let done = self.with_situation(
            at,
            c"report",
            |buffers| [buffers.add("values", repeat_n(UNWRITTEN, self.outputs.len()))],
            // SAFETY: all arguments are as the ABI demands; there is one value for each output.
            |own, situation, [to], text| unsafe { report(own, situation, to, text) },
            |[found]| {
                values.extend_from_slice(found);
                true
            },
        );
        let happens = |(output, value): &(&Output, f64)| !(output.event && value.is_nan());
        let known: Vec<(&Output, f64)> = self.outputs.iter().zip(values).filter(happens).collect();
        if let Some((Output { name, .. }, value)) = known.iter().find(|(_, value)| done && !value.is_finite()) {
            self.instance.fail(if value.to_bits() == UNWRITTEN.to_bits() {
                format!("wrote no value of the output `{name}` in `report`")
            } else {
                format!("returned {value} as output `{name}`")
            });
        }
        if self.instance.fault().is_some() {
            return Vec::new();
        }
        known.into_iter().map(|(output, value)| (output.name.clone(), value)).collect()
    }

    fn fault(&self) -> Option<String> {
        self.instance.fault()
    }
}

impl Potential for Proxy {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        self.energy_alone(at)
    }

    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], span: &mut [Vector]) -> f64 {
        if self.description.has_gradient == 0 {
            numeric::gradient(at, &|at| self.energy_alone(at), stations, span);
            return self.energy_alone(at);
        }
        let wanted = [(Part::Energy, 1), (Part::Gradient, 3 * stations.len()), (Part::SpanGradient, 3 * span.len())];
        let mut energy = f64::NAN;
        stations.fill(Vector::repeat(f64::NAN));
        span.fill(Vector::repeat(f64::NAN));
        self.evaluate(at, wanted, &[], |[of_energy, of_stations, of_span]| {
            energy = of_energy[0];
            copy_vectors(of_stations, stations);
            copy_vectors(of_span, span);
        });
        energy
    }

    fn hessian(&self, at: &ConstraintView<'_>, stations: &mut [Matrix], span: &mut [Matrix]) {
        match (self.description.has_gradient != 0, self.description.has_hessian != 0) {
            (_, true) => self.second_derivatives(at, &[], stations, span),
            (false, false) => numeric::hessian_of_energy(at, &|at| self.energy_alone(at), stations, span),
            (true, false) => {
                let gradient = |at: &ConstraintView<'_>, stations: &mut [Vector], span: &mut [Vector]| {
                    Potential::gradient(self, at, stations, span);
                };
                numeric::hessian(at, &gradient, stations, span);
            }
        }
    }
}

impl Equations for Proxy {
    fn of_stations(&self) -> Vec<Residual> {
        self.residuals[0].clone()
    }

    fn of_each_node(&self) -> Vec<Residual> {
        self.residuals[1].clone()
    }

    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]) {
        self.residuals_alone(at, c);
    }

    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], stations: &mut [Vector], span: &mut [Vector]) {
        if self.description.has_gradient == 0 {
            numeric::jacobian(
                at,
                self.residuals[0].len(),
                &|at, c| self.residuals_alone(at, c),
                c.len(),
                stations,
                span,
            );
            self.residuals_alone(at, c);
            return;
        }
        let wanted =
            [(Part::Residuals, c.len()), (Part::Jacobian, 3 * stations.len()), (Part::SpanJacobian, 3 * span.len())];
        c.fill(f64::NAN);
        stations.fill(Vector::repeat(f64::NAN));
        span.fill(Vector::repeat(f64::NAN));
        self.evaluate(at, wanted, &[], |[residuals, of_stations, of_span]| {
            c.copy_from_slice(residuals);
            copy_vectors(of_stations, stations);
            copy_vectors(of_span, span);
        });
    }

    /// Without second derivatives from the plugin the Gauss-Newton approximation remains.
    fn curvature(&self, at: &ConstraintView<'_>, w: &[f64], stations: &mut [Matrix], span: &mut [Matrix]) {
        if self.description.has_hessian != 0 {
            self.second_derivatives(at, w, stations, span);
        }
    }
}

/// Copies numbers, three for each vector.
fn copy_vectors(numbers: &[f64], to: &mut [Vector]) {
    for (to, from) in to.iter_mut().zip(numbers.chunks_exact(3)) {
        *to = Vector::from_column_slice(from);
    }
}

/// A pose as the ABI has it: position, then `w, x, y, z`.
fn pose_numbers(pose: &Pose) -> [f64; 7] {
    let (x, q) = (&pose.position, &pose.orientation);
    [x.x, x.y, x.z, q.w, q.i, q.j, q.k]
}

fn abi_pose(pose: &Pose) -> abi::Pose {
    let q = &pose.orientation;
    abi::Pose { position: pose.position.into(), orientation: [q.w, q.i, q.j, q.k] }
}

fn pose(position: [f64; 3], [w, x, y, z]: [f64; 4]) -> Pose {
    let q = nalgebra::Quaternion::new(w, x, y, z);
    Pose { position: Vector::from(position), orientation: nalgebra::Unit::new_unchecked(q) }
}

/// Copies the initial memory of a part.
pub fn memory(first: *const f64, count: u32) -> Result<Vec<f64>, String> {
    let memory = numbers(first, count, "memory", 0.0)?;
    if memory.iter().any(|x| !x.is_finite()) {
        return Err(format!("starts with a memory that is not finite: {memory:?}"));
    }
    Ok(memory)
}

/// Copies `count` numbers of the plugin, or repeats `otherwise` if it gives none.
fn numbers(first: *const f64, count: u32, what: &str, otherwise: f64) -> Result<Vec<f64>, String> {
    if count > MOST {
        return Err(format!("says it has {count} numbers of {what}; at most {MOST} are allowed"));
    }
    if first.is_null() || count == 0 {
        return Ok(vec![otherwise; count as usize]);
    }
    if !first.is_aligned() || (first as usize) < 4096 {
        return Err(format!("has its {what} at {first:p}, which is not a valid address"));
    }
    // SAFETY: the plugin states this count.
    Ok(unsafe { std::slice::from_raw_parts(first, count as usize) }.to_vec())
}

/// Converts the prescribed freedoms.
fn hold(said: &abi::Hold) -> Result<Hold, String> {
    let one = |what: &str, v: &[f64; 3]| {
        let v = Vector::from(*v);
        if (v.norm() - 1.0).abs() < 1e-9 {
            Ok(v)
        } else {
            Err(format!("has {what} of length {} instead of 1", v.norm()))
        }
    };
    let rotation = match said.rotation {
        abi::ROTATION_FREE => RotationHold::Free,
        abi::ROTATION_TANGENT => RotationHold::Tangent,
        abi::ROTATION_TWIST => RotationHold::Twist,
        abi::ROTATION_ALL => RotationHold::All,
        abi::ROTATION_HINGE => RotationHold::Hinge(nalgebra::Unit::new_unchecked(one("a hinge's axis", &said.axis)?)),
        other => return Err(format!("holds rotations in way {other}; 0 to 4 are known")),
    };
    if said.rail_count > 2 {
        return Err(format!("has {} rails; at most two are allowed", said.rail_count));
    }
    let rails: Vec<Vector> =
        said.rails.iter().take(said.rail_count as usize).map(|rail| one("a rail", rail)).collect::<Result<_, _>>()?;
    if let [a, b] = rails.as_slice()
        && a.dot(b).abs() > 1e-9
    {
        return Err("has two rails that are not at right angles".into());
    }
    if said.position == 0 && rotation == RotationHold::Free {
        return Err("prescribes nothing: neither position nor rotation".into());
    }
    Ok(Hold { position: said.position != 0, rails, rotation })
}
