//! Buffers of the stages, in f64: converted to bytes for a device, and used directly by the CPU reference.
//!
//! The number of a variant in an entry is at `entry * variants + variant`. See [`crate::layout::Offsets`] for the
//! entries.

use crate::Real;
use crate::harness::{Harness, Shape, Stop, Variable};
use crate::layout::{Control, Offsets, Phase};
use crate::plan::{Plan, sizes};
use nalgebra::{Matrix3, Quaternion, Vector3};

/// Vector in space.
pub type Vector = Vector3<f64>;
/// Matrix in space.
pub type Matrix = Matrix3<f64>;
/// Quaternion; coordinates x, y, z, w.
pub type Rotation = Quaternion<f64>;

/// A buffer, bound to the binding of the same name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Buffer {
    /// Sizes and offsets.
    Offsets,
    /// Look-up tables and instructions.
    Program,
    /// Numbers that change between variants and increments.
    Numbers,
    /// States of every variant.
    State,
    /// Derivatives of the parts.
    Parts,
    /// Blocks of the matrix, its factor and updates.
    Blocks,
    /// Vectors.
    Vectors,
    /// Status of every variant.
    Control,
    /// What is uploaded or read back, variant by variant.
    Transfer,
}

impl Buffer {
    /// All buffers.
    pub const ALL: [Self; 9] = [
        Self::Offsets,
        Self::Program,
        Self::Numbers,
        Self::State,
        Self::Parts,
        Self::Blocks,
        Self::Vectors,
        Self::Control,
        Self::Transfer,
    ];

    /// The buffer of the binding of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|buffer| buffer.name() == name)
    }

    /// Name of the binding.
    pub fn name(self) -> &'static str {
        match self {
            Self::Offsets => "offsets",
            Self::Program => "program",
            Self::Numbers => "numbers",
            Self::State => "state",
            Self::Parts => "parts",
            Self::Blocks => "blocks",
            Self::Vectors => "vectors",
            Self::Control => "control",
            Self::Transfer => "transfer",
        }
    }
}

/// The harness has another topology than the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the harness has other links than the one that the plan was made for")]
pub struct TopologyMismatch;

/// Buffers of all variants; see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    /// Sizes and offsets.
    pub offsets: Offsets,
    /// Look-up tables and instructions.
    pub program: Vec<u32>,
    /// Parameters, dead forces and holds.
    pub numbers: Vec<f64>,
    /// Values and compensations of three states.
    pub state: Vec<f64>,
    /// Derivatives of the parts.
    pub parts: Vec<f64>,
    /// Blocks of the matrix, its factor and updates.
    pub blocks: Vec<f64>,
    /// Solution and updates, steps, gradients, energies, sums.
    pub vectors: Vec<f64>,
    /// Status of every variant.
    pub control: Vec<Control<f64>>,
    /// What is uploaded or read back, variant by variant; see [`pack`] and [`unpack_shape`].
    pub transfer: Vec<f64>,
}

/// Relative round-off of the energy, because such sums lose about two digits; and the number of consecutive steps
/// allowed without further progress. In f64 there are digits left, so further steps may help; in f32 there are not.
fn round_off(real: Real) -> (f64, u32) {
    match real {
        Real::F32 => (1e-6, 1),
        Real::F64 => (1e-14, 4),
    }
}

impl Memory {
    /// Allocates buffers for a number of variants, all finished.
    pub fn new(plan: &Plan, variants: usize) -> Self {
        let zeros = |entries: u32| vec![0.0; entries as usize * variants];
        let done = Control { phase: Phase::Done as u32, ..Control::default() };
        Self {
            offsets: Offsets { variants: variants as u32, ..plan.offsets },
            program: plan.program.clone(),
            numbers: zeros(plan.offsets.numbers),
            state: zeros(3 * sizes::STATE * plan.offsets.variables),
            parts: zeros(plan.parts),
            blocks: zeros(9 * plan.condensation.blocks_end),
            vectors: zeros(plan.vectors),
            control: vec![done; variants],
            transfer: zeros(plan.upload_length()),
        }
    }

    /// Number of variants.
    pub fn variants(&self) -> usize {
        self.control.len()
    }

    /// Writes parameters and conditions of a variant.
    ///
    /// # Errors
    /// If the topology differs from that of the plan.
    pub fn set_harness(&mut self, plan: &Plan, variant: usize, harness: &Harness) -> Result<(), TopologyMismatch> {
        let variants = self.variants();
        let mut places = self.numbers[variant..].iter_mut().step_by(variants);
        numbers(plan, harness, |numbers| numbers.iter().zip(&mut places).for_each(|(x, place)| *place = *x))
    }

    /// Writes the state of a variant.
    pub fn set_shape(&mut self, plan: &Plan, variant: usize, shape: &Shape) {
        let first = self.state_entry(0, 0, variant);
        let state = plan.variables.iter().flat_map(|variable| offset(variable, shape));
        for (entry, x) in state.enumerate() {
            let at = self.at(first + entry, variant);
            self.state[at] = x;
        }
    }

    /// State of a variant.
    pub fn shape(&self, plan: &Plan, variant: usize) -> Shape {
        let first = self.state_entry(0, 0, variant);
        shape(plan, |entry| self.state[self.at(first + entry, variant)])
    }

    /// Starts a variant. If its holds move ([`Harness::moves`]), the first step includes the motion; otherwise held
    /// variables are set directly.
    pub fn begin(&mut self, variant: usize, stop: &Stop, real: Real, moving: bool) {
        let (noise, patience) = round_off(real);
        self.control[variant] = Control {
            force_scale: stop.force_scale,
            moment_scale: stop.moment_scale,
            tolerance: stop.tolerance,
            noise,
            patience,
            unit: 1.0,
            phase: if moving { Phase::Linearise } else { Phase::Search } as u32,
            current: self.control[variant].current,
            moving: u32::from(moving),
            max_iterations: stop.max_iterations,
            algorithm: stop.algorithm as u32,
            ..Control::default()
        };
    }

    /// Contents of a buffer as a device has them.
    pub fn bytes(&self, buffer: Buffer, real: Real) -> Vec<u8> {
        let mut bytes = Vec::new();
        match buffer {
            Buffer::Offsets => {
                for word in self.offsets.words() {
                    bytes.extend(word.to_le_bytes());
                }
            }
            Buffer::Program => bytes.extend(self.program.iter().flat_map(|word| word.to_le_bytes())),
            Buffer::Numbers => put(&mut bytes, &self.numbers, real),
            Buffer::State if real == Real::F32 => put(&mut bytes, &self.rounded_state(), real),
            Buffer::State => put(&mut bytes, &self.state, real),
            Buffer::Parts => put(&mut bytes, &self.parts, real),
            Buffer::Blocks => put(&mut bytes, &self.blocks, real),
            Buffer::Vectors => put(&mut bytes, &self.vectors, real),
            Buffer::Control => {
                for control in &self.control {
                    put(&mut bytes, &control.reals(), real);
                    bytes.extend(control.words().iter().flat_map(|word| word.to_le_bytes()));
                    bytes.resize(bytes.len().next_multiple_of(real.bytes()), 0);
                }
            }
            Buffer::Transfer => put(&mut bytes, &self.transfer, real),
        }
        bytes
    }

    /// Reads the contents of a buffer from a device; buffers that no stage writes are not changed.
    ///
    /// # Panics
    /// If there are too few bytes.
    pub fn load(&mut self, buffer: Buffer, real: Real, bytes: &[u8]) {
        match buffer {
            Buffer::Offsets | Buffer::Program => {}
            Buffer::Numbers => get(bytes, &mut self.numbers, real),
            Buffer::Transfer => get(bytes, &mut self.transfer, real),
            Buffer::State => get(bytes, &mut self.state, real),
            Buffer::Parts => get(bytes, &mut self.parts, real),
            Buffer::Blocks => get(bytes, &mut self.blocks, real),
            Buffer::Vectors => get(bytes, &mut self.vectors, real),
            Buffer::Control => {
                let size = bytes.len() / self.control.len().max(1);
                for (control, own) in self.control.iter_mut().zip(bytes.chunks_exact(size.max(1))) {
                    let mut reals = control.reals();
                    get(own, &mut reals, real);
                    let words = own[reals.len() * real.bytes()..].chunks_exact(4);
                    let words: Vec<u32> =
                        words.map(|word| u32::from_le_bytes(word.try_into().expect("four bytes"))).collect();
                    *control = Control::from_parts(&reals, &words);
                }
            }
        }
    }

    /// The state for f32: what a position cannot represent is moved to its compensation.
    fn rounded_state(&self) -> Vec<f64> {
        let mut state = self.state.clone();
        let (variants, size) = (self.variants(), sizes::STATE as usize);
        for entry in 0..state.len() / variants.max(1) {
            let (variable, k) = (entry / size % self.offsets.variables as usize, entry % size);
            let kind = self.program[self.offsets.kinds_program as usize + variable];
            if kind == 0 && k < 3 {
                for variant in 0..variants {
                    let own = entry * variants + variant;
                    let compensation = (entry + 4) * variants + variant;
                    (state[own], state[compensation]) = rounded(state[own], state[compensation]);
                }
            }
        }
        state
    }
}

/// Bytes to upload for a variant, of which [`Plan::unpack`] makes its numbers and its state.
///
/// # Errors
/// If the topology differs from that of the plan.
pub fn pack(plan: &Plan, harness: &Harness, shape: &Shape, real: Real) -> Result<Vec<u8>, TopologyMismatch> {
    let mut bytes = Vec::with_capacity(plan.upload_length() as usize * real.bytes());
    let mut put = |numbers: &[f64]| {
        for x in numbers {
            match real {
                Real::F32 => bytes.extend_from_slice(&(*x as f32).to_le_bytes()),
                Real::F64 => bytes.extend_from_slice(&x.to_le_bytes()),
            }
        }
    };
    numbers(plan, harness, &mut put)?;
    for variable in &plan.variables {
        let mut own = offset(variable, shape);
        if real == Real::F32 && matches!(variable, Variable::Point(_)) {
            (0..3).for_each(|k| (own[k], own[4 + k]) = rounded(own[k], own[4 + k]));
        }
        put(&own);
    }
    Ok(bytes)
}

/// The state of a variant from the bytes that [`Plan::pack_shape`] made of it.
///
/// # Panics
/// If there are too few bytes.
pub fn unpack_shape(plan: &Plan, bytes: &[u8], real: Real) -> Shape {
    let mut state = vec![0.0; plan.shape_length() as usize];
    get(bytes, &mut state, real);
    shape(plan, |entry| state[entry])
}

/// A state whose values and compensations are these, entry by entry.
fn shape(plan: &Plan, state: impl Fn(usize) -> f64) -> Shape {
    let zeros = vec![[0.0; 3]; plan.of_point.len()];
    let mut shape = Shape { points: zeros.clone(), compensation: zeros, frames: vec![[0.0; 4]; plan.of_frame.len()] };
    for (k, variable) in plan.variables.iter().enumerate() {
        let first = k * sizes::STATE as usize;
        match variable {
            Variable::Point(i) => {
                shape.points[*i as usize] = [0, 1, 2].map(|k| state(first + k));
                shape.compensation[*i as usize] = [4, 5, 6].map(|k| state(first + k));
            }
            Variable::Frame(c) => shape.frames[*c as usize] = [0, 1, 2, 3].map(|k| state(first + k)),
        }
    }
    shape
}

/// A position and its compensation for f32: what the position cannot represent is moved to the compensation.
fn rounded(x: f64, compensation: f64) -> (f64, f64) {
    let rounded = f64::from(x as f32);
    (rounded, compensation + (x - rounded))
}

/// Puts out the numbers of a harness, entry by entry.
fn numbers(plan: &Plan, harness: &Harness, mut put: impl FnMut(&[f64])) -> Result<(), TopologyMismatch> {
    if harness.topology() != plan.topology {
        return Err(TopologyMismatch);
    }
    for variable in &plan.variables {
        let (dead, weight) = match variable {
            Variable::Point(i) => (harness.dead[*i as usize], 0.0),
            Variable::Frame(c) => ([0.0; 3], harness.weights[*c as usize]),
        };
        put(&dead);
        put(&[weight]);
    }
    for hold in &harness.holds {
        put(hold.basis.as_flattened());
        put(&[f64::from(hold.count)]);
        match hold.variable {
            Variable::Point(_) => {
                let target = hold.target.map(split_f32);
                put(&target.map(|[x, _]| x));
                put(&[0, 1, 2].map(|k| target[k][1]));
            }
            Variable::Frame(_) => {
                put(&hold.target);
                put(&[0.0; 3]);
            }
        }
        put(&hold.motion);
    }
    for s in &harness.segments {
        put(&s.stiffness);
        let [length, rest] = split_f32(s.length);
        put(&[length, rest, s.inversion_stiffness]);
    }
    for s in &harness.station_segments {
        put(&s.stiffness);
        let [length, rest] = split_f32(s.length);
        put(&[length, rest, s.inversion_stiffness]);
        for end in &s.ends {
            let station = end.station;
            put(&station.map_or([0.0; 4], |station| station.rest));
            put(&station.map_or([0.0; 3], |station| station.offset));
            put(&[station.map_or(0.0, |station| station.blend)]);
        }
    }
    for c in &harness.couplings {
        put(&c.stiffness);
        put(&[c.length]);
        put(&c.rest_curvature);
        put(&c.a.rest);
        put(&c.b.rest);
    }
    for s in &harness.springs {
        put(&s.rest);
        put(&s.offset);
        put(&[s.stiffness, s.tangent_stiffness, s.frame_stiffness]);
        put(&s.position);
        put(&s.orientation);
        put(&s.force);
    }
    Ok(())
}

/// Splits a number into its f32 part and the rest: exact in f64, and twice the digits in f32.
fn split_f32(x: f64) -> [f64; 2] {
    let held = f64::from(x as f32);
    [held, x - held]
}

/// Value and compensation of a variable.
fn offset(variable: &Variable, shape: &Shape) -> [f64; sizes::STATE as usize] {
    match variable {
        Variable::Point(i) => {
            let ([x, y, z], [dx, dy, dz]) = (shape.points[*i as usize], shape.compensation[*i as usize]);
            [x, y, z, 0.0, dx, dy, dz]
        }
        Variable::Frame(c) => {
            let [x, y, z, w] = shape.frames[*c as usize];
            [x, y, z, w, 0.0, 0.0, 0.0]
        }
    }
}

fn put(bytes: &mut Vec<u8>, numbers: &[f64], real: Real) {
    let first = bytes.len();
    bytes.resize(first + numbers.len() * real.bytes(), 0);
    let buffer = &mut bytes[first..];
    match real {
        Real::F32 => {
            for (to, x) in buffer.chunks_exact_mut(4).zip(numbers) {
                to.copy_from_slice(&(*x as f32).to_le_bytes());
            }
        }
        Real::F64 => {
            for (to, x) in buffer.chunks_exact_mut(8).zip(numbers) {
                to.copy_from_slice(&x.to_le_bytes());
            }
        }
    }
}

fn get(bytes: &[u8], numbers: &mut [f64], real: Real) {
    assert!(bytes.len() >= numbers.len() * real.bytes(), "too few bytes");
    match real {
        Real::F32 => {
            for (x, bytes) in numbers.iter_mut().zip(bytes.chunks_exact(4)) {
                *x = f64::from(f32::from_le_bytes(bytes.try_into().expect("four bytes")));
            }
        }
        Real::F64 => {
            for (x, bytes) in numbers.iter_mut().zip(bytes.chunks_exact(8)) {
                *x = f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
            }
        }
    }
}

/// Access to entries of a variant, as in `shared/bindings.wgsl`.
impl Memory {
    pub(crate) fn at(&self, entry: usize, variant: usize) -> usize {
        entry * self.control.len() + variant
    }

    pub(crate) fn state_entry(&self, variable: usize, slot: u32, variant: usize) -> usize {
        let own = (self.control[variant].current + slot) % 3;
        (own as usize * self.offsets.variables as usize + variable) * sizes::STATE as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BINDINGS;

    #[test]
    fn every_binding_but_the_range_has_its_buffer() {
        for binding in BINDINGS.iter().filter(|binding| binding.name != "range") {
            assert_eq!(Buffer::named(binding.name).map(Buffer::name), Some(binding.name));
        }
        assert_eq!(BINDINGS.len(), Buffer::ALL.len() + 1);
    }
}
