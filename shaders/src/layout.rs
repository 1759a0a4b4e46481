//! Structs that shaders and Rust share. `shared/bindings.wgsl` has the same structs; a test compares the offsets.

/// Sizes and offsets, the same for all variants. Offsets in `program` are in words (`…_program`), those in other
/// buffers in entries; an entry has one number per variant.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Offsets {
    /// Number of variants.
    pub variants: u32,
    /// Number of variables.
    pub variables: u32,
    /// Number of segments without stations.
    pub segments: u32,
    /// Number of segments with stations.
    pub station_segments: u32,
    /// Number of couplings.
    pub couplings: u32,
    /// Number of springs.
    pub springs: u32,
    /// Number of variables that can be held.
    pub holds: u32,
    /// Number of entries of `numbers`.
    pub numbers: u32,
    /// Number of chunks of a sum: each is summed up by one invocation.
    pub chunks: u32,
    /// Number of sums of chunks, which one invocation sums up.
    pub totals: u32,
    /// Type of each variable: 0 for a point, 1 for a frame.
    pub kinds_program: u32,
    /// Hold of each variable, or none.
    pub holds_program: u32,
    /// Two points and a frame of each segment without stations.
    pub segments_program: u32,
    /// Two points, a frame, and two frames or none of each segment with stations.
    pub station_segments_program: u32,
    /// Two frames of each coupling.
    pub couplings_program: u32,
    /// A point and a frame or none of each spring.
    pub springs_program: u32,
    /// Table of the derivatives that sum up to the gradient of each variable.
    pub forces_program: u32,
    /// Vector with the step of each variable in the condensation of points, or none.
    pub condensation_program: u32,
    /// Dead force and shift weight of each variable.
    pub variables_numbers: u32,
    /// Numbers of holds.
    pub holds_numbers: u32,
    /// Numbers of segments without stations.
    pub segments_numbers: u32,
    /// Numbers of segments with stations.
    pub station_segments_numbers: u32,
    /// Numbers of couplings.
    pub couplings_numbers: u32,
    /// Numbers of springs.
    pub springs_numbers: u32,
    /// Derivatives of segments without stations.
    pub segments_parts: u32,
    /// Derivatives of segments with stations.
    pub station_segments_parts: u32,
    /// Derivatives of couplings.
    pub couplings_parts: u32,
    /// Derivatives of springs.
    pub springs_parts: u32,
    /// The step of each variable; before it the solution, followed by updates of tasks.
    pub step_vectors: u32,
    /// The steepest descent of each variable in the current metric.
    pub descent_vectors: u32,
    /// The free gradient of the three slots of the state.
    pub gradient_vectors: u32,
    /// Energy of each part.
    pub energies_vectors: u32,
    /// Partial sums of chunks.
    pub partials_vectors: u32,
    /// Their sums.
    pub totals_vectors: u32,
    /// Number of negative pivots of each task.
    pub negatives_vectors: u32,
}

/// Items of a dispatch: `first..first + count`, for all variants in the given phases.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Range {
    /// First item.
    pub first: u32,
    /// Number of items.
    pub count: u32,
    /// Phases: bit p for phase p.
    pub phases: u32,
    /// Slot of the state: 0 current, 1 trial, 2 condensed.
    pub slot: u32,
    /// Start of its table in the program.
    pub table: u32,
}

impl Range {
    /// Its words, in order of declaration.
    pub fn words(&self) -> [u32; 5] {
        [self.first, self.count, self.phases, self.slot, self.table]
    }
}

/// Status of a variant, with numbers of type `R`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Control<R> {
    /// Scale of forces, N.
    pub force_scale: R,
    /// Scale of moments, N m.
    pub moment_scale: R,
    /// Tolerance of the relative residual.
    pub tolerance: R,
    /// Relative round-off of the energy.
    pub noise: R,
    /// Energy of the current state, J.
    pub energy: R,
    /// Energy of the trial state, J.
    pub trial_energy: R,
    /// Slope of the energy along the step, J.
    pub slope: R,
    /// Fraction of the step that is tried.
    pub alpha: R,
    /// Largest rotation of a frame in the whole step, rad.
    pub max_rotation: R,
    /// Shift of the frames' diagonal, N m per metre of cable.
    pub sigma: R,
    /// Relative residual of the current state.
    pub residual: R,
    /// Relative residual of the trial state.
    pub trial_residual: R,
    /// Largest rotation in the last accepted step, rad.
    pub last_rotation: R,
    /// Always 1, but unknown to the device's compiler.
    pub unit: R,
    /// Factor of the last step in this one (conjugate gradients).
    pub beta: R,
    /// Minus the slope along the steepest descent, J.
    pub product: R,
    /// Current phase; see [`Phase`].
    pub phase: u32,
    /// Final outcome; see [`Outcome`].
    pub outcome: u32,
    /// Third of `state` with the current state; the next third is the trial state, the one after it the condensed trial
    /// state.
    pub current: u32,
    /// 1 while prescribed motion is still to be carried out.
    pub moving: u32,
    /// 1 from the first state on that satisfies all holds.
    pub begun: u32,
    /// Number of accepted steps.
    pub iterations: u32,
    /// Number of factorisations.
    pub factorisations: u32,
    /// Number of evaluations of energy and gradient.
    pub evaluations: u32,
    /// Number of consecutive steps with changes below round-off only.
    pub stalled: u32,
    /// Number of steps after the tolerance was reached.
    pub polished: u32,
    /// Largest number of iterations.
    pub max_iterations: u32,
    /// Number of negative pivots of the last factorisation.
    pub negative: u32,
    /// Algorithm; see [`crate::harness::Algorithm`].
    pub algorithm: u32,
    /// Third of `state` with the previous state.
    pub previous: u32,
    /// Number of steps since the last factorisation.
    pub since: u32,
    /// Number of cycles so far.
    pub cycles: u32,
    /// Number of such consecutive steps after which the variant has stalled.
    pub patience: u32,
}

impl Offsets {
    /// Its words, in order of declaration.
    pub fn words(&self) -> [u32; 35] {
        [
            self.variants,
            self.variables,
            self.segments,
            self.station_segments,
            self.couplings,
            self.springs,
            self.holds,
            self.numbers,
            self.chunks,
            self.totals,
            self.kinds_program,
            self.holds_program,
            self.segments_program,
            self.station_segments_program,
            self.couplings_program,
            self.springs_program,
            self.forces_program,
            self.condensation_program,
            self.variables_numbers,
            self.holds_numbers,
            self.segments_numbers,
            self.station_segments_numbers,
            self.couplings_numbers,
            self.springs_numbers,
            self.segments_parts,
            self.station_segments_parts,
            self.couplings_parts,
            self.springs_parts,
            self.step_vectors,
            self.descent_vectors,
            self.gradient_vectors,
            self.energies_vectors,
            self.partials_vectors,
            self.totals_vectors,
            self.negatives_vectors,
        ]
    }
}

impl Control<f64> {
    /// Its numbers, in order of declaration.
    pub fn reals(&self) -> [f64; 16] {
        [
            self.force_scale,
            self.moment_scale,
            self.tolerance,
            self.noise,
            self.energy,
            self.trial_energy,
            self.slope,
            self.alpha,
            self.max_rotation,
            self.sigma,
            self.residual,
            self.trial_residual,
            self.last_rotation,
            self.unit,
            self.beta,
            self.product,
        ]
    }

    /// Its words, in order of declaration.
    pub fn words(&self) -> [u32; 17] {
        [
            self.phase,
            self.outcome,
            self.current,
            self.moving,
            self.begun,
            self.iterations,
            self.factorisations,
            self.evaluations,
            self.stalled,
            self.polished,
            self.max_iterations,
            self.negative,
            self.algorithm,
            self.previous,
            self.since,
            self.cycles,
            self.patience,
        ]
    }

    /// From its numbers and words.
    ///
    /// # Panics
    /// If there are too few of them.
    pub(crate) fn from_parts(reals: &[f64], words: &[u32]) -> Self {
        let (mut reals, mut words) = (reals.iter().copied(), words.iter().copied());
        let mut real = || reals.next().expect("a number for every member");
        let mut word = || words.next().expect("a word for every member");
        Self {
            force_scale: real(),
            moment_scale: real(),
            tolerance: real(),
            noise: real(),
            energy: real(),
            trial_energy: real(),
            slope: real(),
            alpha: real(),
            max_rotation: real(),
            sigma: real(),
            residual: real(),
            trial_residual: real(),
            last_rotation: real(),
            unit: real(),
            beta: real(),
            product: real(),
            phase: word(),
            outcome: word(),
            current: word(),
            moving: word(),
            begun: word(),
            iterations: word(),
            factorisations: word(),
            evaluations: word(),
            stalled: word(),
            polished: word(),
            max_iterations: word(),
            negative: word(),
            algorithm: word(),
            previous: word(),
            since: word(),
            cycles: word(),
            patience: word(),
        }
    }
}

/// Phase of a variant; stages of other phases skip it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Phase {
    /// Second derivatives at the current state.
    Linearise = 0,
    /// Another factorisation, with a larger shift.
    Refactor = 1,
    /// Solution for the step.
    Solve = 2,
    /// Evaluation of a trial state.
    Search = 3,
    /// Static condensation of its points.
    Condense = 4,
    /// Acceptance of the trial state.
    Accept = 5,
    /// Step of the gradient method.
    Descend = 6,
    /// Combination with the last step.
    Combine = 7,
    /// Finished.
    Done = 8,
}

/// Outcome of a variant, as computed on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Outcome {
    /// Not finished.
    None = 0,
    /// Residual below the tolerance.
    Converged = 1,
    /// No progress above round-off.
    Stalled = 2,
    /// Iteration limit reached.
    IterationLimit = 3,
    /// No step decreases the energy, or values are not finite.
    Failed = 4,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RECORDS, Record};
    use std::mem::{offset_of, size_of};

    fn record(real: usize, name: &str) -> &'static Record {
        RECORDS[real].iter().find(|record| record.name == name).expect("a record of this name")
    }

    /// Name and Rust offset of every member that WGSL lists.
    macro_rules! offsets {
        ($kind:ty: $($member:ident)*) => { vec![$((stringify!($member), offset_of!($kind, $member) as u32)),*] };
    }

    macro_rules! control {
        ($real:ty) => {
            offsets!(Control<$real>: force_scale moment_scale tolerance noise energy trial_energy slope alpha
                max_rotation sigma residual trial_residual last_rotation unit beta product phase outcome current moving
                begun iterations factorisations evaluations stalled
                polished max_iterations negative algorithm previous since cycles patience)
        };
    }

    #[test]
    fn structs_lie_as_in_the_shaders() {
        for (real, control) in [control!(f32), control!(f64)].into_iter().enumerate() {
            assert_eq!(record(real, "Control").members, control);
            let offsets = offsets!(Offsets: variants variables segments station_segments couplings springs holds
                numbers chunks totals kinds_program holds_program segments_program station_segments_program
                couplings_program
                springs_program
                forces_program condensation_program variables_numbers holds_numbers
                segments_numbers station_segments_numbers couplings_numbers springs_numbers segments_parts
                station_segments_parts couplings_parts springs_parts step_vectors descent_vectors gradient_vectors
                energies_vectors partials_vectors totals_vectors negatives_vectors);
            assert_eq!(record(real, "Offsets").members, offsets);
            assert_eq!(record(real, "Range").members, offsets!(Range: first count phases slot table));
            assert_eq!(record(real, "Offsets").size as usize, size_of::<Offsets>());
        }
        assert_eq!(record(0, "Control").size as usize, size_of::<Control<f32>>());
        assert_eq!(record(1, "Control").size as usize, size_of::<Control<f64>>());
    }
}
