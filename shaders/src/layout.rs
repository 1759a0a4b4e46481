//! The structs that shaders and Rust share. Their twins in WGSL are in `shared/bindings.wgsl`; a test compares the offsets.

/// Sizes and places, the same for all variants. Places in `program` are counted in words (`…_program`), those in the other buffers in
/// entries, of which each variant has one number.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Offsets {
    /// Number of variants.
    pub variants: u32,
    /// Number of variables.
    pub variables: u32,
    /// Number of segments away from stations.
    pub segments: u32,
    /// Number of segments beside stations.
    pub station_segments: u32,
    /// Number of couplings.
    pub couplings: u32,
    /// Number of springs.
    pub springs: u32,
    /// Number of variables that may be held.
    pub holds: u32,
    /// Number of chunks in which sums are taken.
    pub chunks: u32,
    /// Of each variable 0, a point, or 1, a frame.
    pub kinds_program: u32,
    /// Of each variable its place among those that may be held, or none.
    pub holds_program: u32,
    /// Two points and a frame of each segment.
    pub segments_program: u32,
    /// Two points, a frame and two frames or none of each segment beside stations.
    pub station_segments_program: u32,
    /// Two frames of each coupling.
    pub couplings_program: u32,
    /// A point and a frame or none of each spring.
    pub springs_program: u32,
    /// Of each variable where its sources begin (and end), then the sources: what its gradient is the sum of.
    pub forces_program: u32,
    /// Of each variable the vector with its step where the points alone are settled, or none.
    pub condensation_program: u32,
    /// Of each variable its dead force and the weight of its shift.
    pub variables_numbers: u32,
    /// Numbers of holds.
    pub holds_numbers: u32,
    /// Numbers of segments.
    pub segments_numbers: u32,
    /// Numbers of segments beside stations.
    pub station_segments_numbers: u32,
    /// Numbers of couplings.
    pub couplings_numbers: u32,
    /// Numbers of springs.
    pub springs_numbers: u32,
    /// Derivatives of segments.
    pub segments_parts: u32,
    /// Derivatives of segments beside stations.
    pub station_segments_parts: u32,
    /// Derivatives of couplings.
    pub couplings_parts: u32,
    /// Derivatives of springs.
    pub springs_parts: u32,
    /// The step of each variable; before it the solution, then what tasks leave for those after them.
    pub step_vectors: u32,
    /// The steepest descent of each variable in the metric at hand.
    pub descent_vectors: u32,
    /// The free gradient, of the state at hand and on trial.
    pub gradient_vectors: u32,
    /// Energy of each part.
    pub energies_vectors: u32,
    /// Sums over chunks.
    pub partials_vectors: u32,
    /// Negative pivots of each task.
    pub negatives_vectors: u32,
    /// Value and carry of every variable, as they are read back.
    pub shape_vectors: u32,
}

/// Which items a dispatch works on: `first..first + count`, of every variant in one of its phases; and where.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Range {
    /// The first.
    pub first: u32,
    /// How many.
    pub count: u32,
    /// The phases: bit p for phase p.
    pub phases: u32,
    /// The slot of the state: 0, that at hand; 1, on trial; 2, settled.
    pub slot: u32,
    /// Where in the program its table begins.
    pub table: u32,
}

impl Range {
    /// Its words, in order.
    pub fn words(&self) -> [u32; 5] {
        [self.first, self.count, self.phases, self.slot, self.table]
    }
}

/// Where a variant stands, in numbers of type `R`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Control<R> {
    /// N.
    pub force_scale: R,
    /// N m.
    pub moment_scale: R,
    /// Largest relative residual of an equilibrium.
    pub tolerance: R,
    /// Share of the energy that is round-off.
    pub noise: R,
    /// Energy of the state at hand, J.
    pub energy: R,
    /// Energy of the state on trial, J.
    pub trial_energy: R,
    /// Slope of the energy along the step, J.
    pub slope: R,
    /// Share of the step that is tried.
    pub alpha: R,
    /// Largest turn of a frame in the whole step, rad.
    pub max_rotation: R,
    /// Shift of the frames' diagonal, N m per metre of cable.
    pub sigma: R,
    /// Relative residual of the state at hand.
    pub residual: R,
    /// Of the state on trial.
    pub trial_residual: R,
    /// Largest turn in the last step taken, rad.
    pub last_rotation: R,
    /// 1, which no compiler of a device can know.
    pub unit: R,
    /// Share of the last step in this one.
    pub beta: R,
    /// Minus the slope along the steepest descent, J.
    pub product: R,
    /// What comes next; see [`Phase`].
    pub phase: u32,
    /// How it ended; see [`Outcome`].
    pub outcome: u32,
    /// Which third of `state` is the state at hand; the next one is on trial, the one after that the same with its points settled.
    pub current: u32,
    /// 1 as long as prescribed motion is still to be carried out.
    pub moving: u32,
    /// 1 from the first state on that is where its holds want it.
    pub begun: u32,
    /// Steps taken.
    pub iterations: u32,
    /// Matrices factorised.
    pub factorisations: u32,
    /// Energies and gradients evaluated.
    pub evaluations: u32,
    /// Steps in a row that brought nothing but round-off.
    pub stalled: u32,
    /// Steps taken since the forces are in balance.
    pub polished: u32,
    /// Iterations allowed.
    pub max_iterations: u32,
    /// Negative pivots of the last factorisation.
    pub negative: u32,
    /// See [`crate::harness::Algorithm`].
    pub algorithm: u32,
    /// Which third of `state` the state before this one was.
    pub previous: u32,
    /// Steps since the last factorisation.
    pub since: u32,
    /// Cycles it took part in.
    pub cycles: u32,
    /// Steps in a row without progress but for round-off after which it is called stalled.
    pub patience: u32,
}

impl Offsets {
    /// Its words, in order.
    pub fn words(&self) -> [u32; 33] {
        [
            self.variants,
            self.variables,
            self.segments,
            self.station_segments,
            self.couplings,
            self.springs,
            self.holds,
            self.chunks,
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
            self.negatives_vectors,
            self.shape_vectors,
        ]
    }
}

impl Control<f64> {
    /// Its numbers, in order.
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

    /// Its words, in order.
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

/// What a variant is waiting for; the stages of other phases leave it alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Phase {
    /// Second derivatives at the state at hand.
    Linearise = 0,
    /// Another factorisation of them, with a larger shift.
    Refactor = 1,
    /// The step.
    Solve = 2,
    /// A state on trial.
    Search = 3,
    /// Its points in balance.
    Condense = 4,
    /// A word on the state on trial.
    Accept = 5,
    /// The step of the gradient method.
    Descend = 6,
    /// What it has of the last one.
    Combine = 7,
    /// Nothing.
    Done = 8,
}

/// How a variant ended, in its own view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Outcome {
    /// It has not.
    None = 0,
    /// Residual below the tolerance.
    Converged = 1,
    /// No progress but round-off.
    Stalled = 2,
    /// The iterations were used up.
    IterationLimit = 3,
    /// No step lowers the energy, or numbers ceased to be finite.
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

    /// Every member named in WGSL, with its offset in Rust.
    macro_rules! offsets {
        ($kind:ty: $($member:ident)*) => { vec![$((stringify!($member), offset_of!($kind, $member) as u32)),*] };
    }

    macro_rules! control {
        ($real:ty) => {
            offsets!(Control<$real>: force_scale moment_scale tolerance noise energy trial_energy slope alpha max_rotation sigma
                residual trial_residual last_rotation unit beta product phase outcome current moving begun iterations factorisations evaluations stalled
                polished max_iterations negative algorithm previous since cycles patience)
        };
    }

    #[test]
    fn structs_lie_as_in_the_shaders() {
        for (real, control) in [control!(f32), control!(f64)].into_iter().enumerate() {
            assert_eq!(record(real, "Control").members, control);
            let offsets = offsets!(Offsets: variants variables segments station_segments couplings springs holds chunks kinds_program holds_program segments_program station_segments_program couplings_program springs_program
                forces_program condensation_program variables_numbers holds_numbers
                segments_numbers station_segments_numbers couplings_numbers springs_numbers segments_parts station_segments_parts
                couplings_parts springs_parts step_vectors descent_vectors gradient_vectors energies_vectors partials_vectors negatives_vectors shape_vectors);
            assert_eq!(record(real, "Offsets").members, offsets);
            assert_eq!(record(real, "Range").members, offsets!(Range: first count phases slot table));
            assert_eq!(record(real, "Offsets").size as usize, size_of::<Offsets>());
        }
        assert_eq!(record(0, "Control").size as usize, size_of::<Control<f32>>());
        assert_eq!(record(1, "Control").size as usize, size_of::<Control<f64>>());
    }
}
