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
}

impl Buffer {
    /// All buffers.
    pub const ALL: [Self; 8] = [
        Self::Offsets,
        Self::Program,
        Self::Numbers,
        Self::State,
        Self::Parts,
        Self::Blocks,
        Self::Vectors,
        Self::Control,
    ];

    /// Buffers that change between increments; the others depend on the plan only.
    pub const CHANGING: [Self; 3] = [Self::Numbers, Self::State, Self::Control];

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
}

/// Motion (m or rad) below which a hold is at rest.
const MIN_MOTION: f64 = 1e-14;

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
            numbers: zeros(plan.numbers),
            state: zeros(3 * sizes::STATE * plan.offsets.variables),
            parts: zeros(plan.parts),
            blocks: zeros(9 * plan.condensation.blocks_end),
            vectors: zeros(plan.vectors),
            control: vec![done; variants],
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
        let own = numbers(plan, harness)?;
        self.scatter(variant, &[own], |memory| &mut memory.numbers);
        Ok(())
    }

    /// Writes the state of a variant.
    pub fn set_shape(&mut self, plan: &Plan, variant: usize, shape: &Shape) {
        let own = offsets(plan, shape);
        let first = self.state_entry(0, 0, variant) * self.variants();
        self.scatter(variant, &[own], |memory| &mut memory.state[first..]);
    }

    /// Writes parameters and state of many variants: [`Self::set_harness`] and [`Self::set_shape`] for the k-th variant
    /// from the k-th pair.
    ///
    /// # Errors
    /// If a topology differs from that of the plan.
    ///
    /// # Panics
    /// If there are more pairs than variants.
    pub fn set_all(&mut self, plan: &Plan, all: &[(&Harness, &Shape)]) -> Result<(), TopologyMismatch> {
        assert!(all.len() <= self.variants(), "no more than variants");
        self.control[..all.len()].iter_mut().for_each(|control| control.current = 0);
        for (first, some) in (0..).step_by(TILE).zip(all.chunks(TILE)) {
            let own: Vec<Vec<f64>> =
                some.iter().map(|(harness, _)| numbers(plan, harness)).collect::<Result<_, _>>()?;
            self.scatter(first, &own, |memory| &mut memory.numbers);
            let own: Vec<Vec<f64>> = some.iter().map(|(_, shape)| offsets(plan, shape)).collect();
            self.scatter(first, &own, |memory| &mut memory.state);
        }
        Ok(())
    }

    /// Writes the entries of consecutive variants.
    fn scatter(&mut self, first: usize, own: &[Vec<f64>], buffer: impl FnOnce(&mut Self) -> &mut [f64]) {
        let variants = self.variants();
        for (entry, row) in buffer(self).chunks_exact_mut(variants).take(own[0].len()).enumerate() {
            for (x, own) in row[first..].iter_mut().zip(own) {
                *x = own[entry];
            }
        }
    }

    /// The bytes of [`Buffer::Vectors`] to which [`Plan::pack_shape`] writes the states.
    pub fn shape_bytes(&self, real: Real) -> std::ops::Range<usize> {
        let entries = self.offsets.shape_vectors..self.offsets.shape_vectors + sizes::STATE * self.offsets.variables;
        let size = self.variants() * real.bytes();
        entries.start as usize * size..entries.end as usize * size
    }

    /// Reads the states of all variants from the bytes at [`Self::shape_bytes`]; call after [`Self::load`] of
    /// [`Buffer::Control`].
    ///
    /// # Panics
    /// If there are too few bytes.
    pub fn load_shapes(&mut self, real: Real, bytes: &[u8]) {
        let (variants, entries) = (self.variants(), sizes::STATE as usize * self.offsets.variables as usize);
        let mut shapes = vec![0.0; entries * variants];
        get(bytes, &mut shapes, real);
        let firsts: Vec<usize> = (0..variants).map(|variant| self.state_entry(0, 0, variant)).collect();
        for (entry, row) in shapes.chunks_exact(variants.max(1)).enumerate() {
            for (variant, (x, first)) in row.iter().zip(&firsts).enumerate() {
                self.state[(first + entry) * variants + variant] = *x;
            }
        }
    }

    /// State of a variant.
    pub fn shape(&self, plan: &Plan, variant: usize) -> Shape {
        let zeros = vec![[0.0; 3]; plan.of_point.len()];
        let mut shape =
            Shape { points: zeros.clone(), compensation: zeros, frames: vec![[0.0; 4]; plan.of_frame.len()] };
        for (k, variable) in plan.variables.iter().enumerate() {
            let entry = self.state_entry(k, 0, variant);
            match variable {
                Variable::Point(i) => {
                    shape.points[*i as usize] = self.value3(entry, variant).into();
                    shape.compensation[*i as usize] = self.compensation3(entry, variant).into();
                }
                Variable::Frame(c) => shape.frames[*c as usize] = self.value4(entry, variant).coords.into(),
            }
        }
        shape
    }

    /// Starts a variant. If its holds move, the first step includes the motion; otherwise held variables are set
    /// directly.
    pub fn begin(&mut self, variant: usize, stop: &Stop, real: Real) {
        let moving = (0..self.offsets.holds as usize).any(|k| {
            let entry = self.offsets.holds_numbers as usize + sizes::HOLD as usize * k + 17;
            self.number3(entry, variant).amax() > MIN_MOTION
        });
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
        }
        bytes
    }

    /// Reads the contents of a buffer from a device; buffers that no stage writes are not changed.
    ///
    /// # Panics
    /// If there are too few bytes.
    pub fn load(&mut self, buffer: Buffer, real: Real, bytes: &[u8]) {
        match buffer {
            Buffer::Offsets | Buffer::Program | Buffer::Numbers => {}
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
                    let rounded = f64::from(state[own] as f32);
                    state[compensation] += state[own] - rounded;
                    state[own] = rounded;
                }
            }
        }
        state
    }
}

/// Number of variants that are packed together: a few cache lines.
const TILE: usize = 32;

/// Numbers of a harness, entry by entry.
fn numbers(plan: &Plan, harness: &Harness) -> Result<Vec<f64>, TopologyMismatch> {
    if harness.topology() != plan.topology {
        return Err(TopologyMismatch);
    }
    let mut all = Vec::with_capacity(plan.numbers as usize);
    for variable in &plan.variables {
        let (dead, weight) = match variable {
            Variable::Point(i) => (harness.dead[*i as usize], 0.0),
            Variable::Frame(c) => ([0.0; 3], harness.weights[*c as usize]),
        };
        all.extend(dead);
        all.push(weight);
    }
    for hold in &harness.holds {
        all.extend(hold.basis.as_flattened());
        all.push(f64::from(hold.count));
        match hold.variable {
            Variable::Point(_) => {
                let target = hold.target.map(split_f32);
                all.extend(target.map(|[x, _]| x));
                all.extend(target[..3].iter().map(|[_, rest]| rest));
            }
            Variable::Frame(_) => {
                all.extend(hold.target);
                all.extend([0.0; 3]);
            }
        }
        all.extend(hold.motion);
    }
    for s in &harness.segments {
        all.extend(s.stiffness);
        let [length, rest] = split_f32(s.length);
        all.extend([length, rest, s.inversion_stiffness]);
    }
    for s in &harness.station_segments {
        all.extend(s.stiffness);
        let [length, rest] = split_f32(s.length);
        all.extend([length, rest, s.inversion_stiffness]);
        for end in &s.ends {
            let station = end.station;
            all.extend(station.map_or([0.0; 4], |station| station.rest));
            all.extend(station.map_or([0.0; 3], |station| station.offset));
            all.push(station.map_or(0.0, |station| station.blend));
        }
    }
    for c in &harness.couplings {
        all.extend(c.stiffness);
        all.push(c.length);
        all.extend(c.rest_curvature);
        all.extend(c.a.rest);
        all.extend(c.b.rest);
    }
    for s in &harness.springs {
        all.extend(s.rest);
        all.extend(s.offset);
        all.extend([s.stiffness, s.tangent_stiffness, s.frame_stiffness]);
        all.extend(s.position);
        all.extend(s.orientation);
        all.extend(s.force);
    }
    debug_assert_eq!(all.len(), plan.numbers as usize);
    Ok(all)
}

/// Splits a number into its f32 part and the rest: exact in f64, and twice the digits in f32.
fn split_f32(x: f64) -> [f64; 2] {
    let held = f64::from(x as f32);
    [held, x - held]
}

/// Value and compensation of every variable, entry by entry.
fn offsets(plan: &Plan, shape: &Shape) -> Vec<f64> {
    let mut all = Vec::with_capacity(sizes::STATE as usize * plan.len());
    for variable in &plan.variables {
        match variable {
            Variable::Point(i) => {
                all.extend(shape.points[*i as usize]);
                all.push(0.0);
                all.extend(shape.compensation[*i as usize]);
            }
            Variable::Frame(c) => {
                all.extend(shape.frames[*c as usize]);
                all.extend([0.0; 3]);
            }
        }
    }
    all
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

    pub(crate) fn number(&self, entry: usize, variant: usize) -> f64 {
        self.numbers[self.at(entry, variant)]
    }

    pub(crate) fn number3(&self, entry: usize, variant: usize) -> Vector {
        Vector::from_fn(|i, _| self.number(entry + i, variant))
    }

    pub(crate) fn state_entry(&self, variable: usize, slot: u32, variant: usize) -> usize {
        let own = (self.control[variant].current + slot) % 3;
        (own as usize * self.offsets.variables as usize + variable) * sizes::STATE as usize
    }

    pub(crate) fn value3(&self, entry: usize, variant: usize) -> Vector {
        Vector::from_fn(|i, _| self.state[self.at(entry + i, variant)])
    }

    pub(crate) fn value4(&self, entry: usize, variant: usize) -> Rotation {
        Quaternion::from([0, 1, 2, 3].map(|i| self.state[self.at(entry + i, variant)]))
    }

    pub(crate) fn compensation3(&self, entry: usize, variant: usize) -> Vector {
        self.value3(entry + 4, variant)
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
