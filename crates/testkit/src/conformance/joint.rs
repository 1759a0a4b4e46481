//! Checks of [`JointModel`], one for each clause of its contract.

use super::numeric::*;
use crate::laws::joint_energy;
use fastrand::Rng;
use nalgebra::{DMatrix, DVector};
use wireloom_core::joint::{JointShape, JointSpec, WireShare};
use wireloom_core::rotation::{frame_from, orthogonal};
use wireloom_core::section::{FrictionElement, SectionFriction};
use wireloom_core::{Arm, ArmSpring, JointModel, Matrix, Mounting, Rotation, Section, Vector};

/// Makes the joint under test.
pub type Factory<'f> = dyn Fn(JointSpec) -> Box<dyn JointModel> + 'f;

/// A joint model under test.
pub struct Subject<'f> {
    factory: Box<Factory<'f>>,
    most_arms: usize,
    round_off: f64,
}

impl<'f> Subject<'f> {
    /// Joints of up to 16 arms.
    pub fn new(factory: impl Fn(JointSpec) -> Box<dyn JointModel> + 'f) -> Self {
        Self { factory: Box::new(factory), most_arms: 16, round_off: ROUND_OFF }
    }

    /// The same with at most so many arms, for models that take long.
    #[must_use]
    pub fn with_arms_up_to(self, most_arms: usize) -> Self {
        Self { most_arms, ..self }
    }

    /// The same with this round-off of derivatives, relative to them, for those that are differences.
    #[must_use]
    pub fn with_round_off(self, round_off: f64) -> Self {
        Self { round_off, ..self }
    }

    fn make(&self, spec: JointSpec) -> Box<dyn JointModel> {
        (self.factory)(spec)
    }
}

const ROUND_OFF: f64 = 1e-11;
const DIFFERENCES: f64 = 1e-7;
/// Round-off of a gradient by differences at a limit beyond which something slips: there they see both sides.
const ACROSS_A_LIMIT: f64 = 1e-3;
/// Turn within which no law changes its branch, rad: further than differences reach.
const NEAR: f64 = 4e-3;

/// A joint with its arms in some directions.
struct Case {
    name: String,
    spec: JointSpec,
    joint: Box<dyn JointModel>,
    /// Those of the arms, then that of a compliant hub.
    frames: Vec<Rotation>,
    /// Frames of the increments before, for a joint that remembers, and what it remembers of them.
    past: Vec<Vec<Rotation>>,
    memory: Vec<f64>,
}

fn at<'a>(frames: &'a [Rotation], memory: &'a [f64]) -> JointShape<'a> {
    JointShape { frames, memory }
}

/// The memory at the end of an increment that ends with these frames, and the energy dissipated in it, J.
fn committed(joint: &dyn JointModel, frames: &[Rotation], memory: &[f64]) -> (Vec<f64>, f64) {
    let (mut after, mut dissipated) = (memory.to_vec(), vec![0.0; frames.len()]);
    joint.commit(&at(frames, memory), &mut after, &mut dissipated);
    assert!(dissipated.iter().all(|own| *own >= 0.0), "{dissipated:?} J dissipated");
    (after, dissipated.iter().sum())
}

/// The memory after increments that ended with these frames.
fn remembered(joint: &dyn JointModel, past: &[Vec<Rotation>]) -> Vec<f64> {
    past.iter().fold(joint.memory(), |memory, frames| committed(joint, frames, &memory).0)
}

/// Frames of two increments before, for a joint that remembers, such that no law changes its branch near these frames
/// (where its second derivatives may jump): an increment that ends anywhere near changes the same state variables.
///
/// # Panics
/// If none are found.
fn past(joint: &dyn JointModel, now: &[Rotation], turn: f64, rng: &mut Rng) -> Vec<Vec<Rotation>> {
    if joint.memory().is_empty() {
        return Vec::new();
    }
    for _ in 0..10_000 {
        let mut turned = |q: &Rotation| {
            let angle = turn * uniform(rng);
            q * random_turn(rng, angle)
        };
        let past: Vec<Vec<Rotation>> = (0..2).map(|_| now.iter().map(&mut turned).collect()).collect();
        let memory = remembered(joint, &past);
        let changed = |frames: &[Rotation]| -> Vec<bool> {
            let after = committed(joint, frames, &memory).0;
            memory.iter().zip(after).map(|(before, after)| *before != after).collect()
        };
        let here = changed(now);
        let mut near = (0..3 * now.len()).flat_map(|i| [-NEAR, NEAR].map(|h| moved(now, i, h)));
        if near.all(|frames| changed(&frames) == here) {
            return past;
        }
    }
    panic!("no past found from which nothing changes its branch near the frames")
}

/// The frames of all arms turned, and of the joint if it is a compliant hub.
fn frames(
    joint: &dyn JointModel,
    spec: &JointSpec,
    hub: &Rotation,
    mut turn: impl FnMut() -> Rotation,
) -> Vec<Rotation> {
    let arms = spec.arms.iter().map(|arm| hub * arm.rest * turn());
    arms.chain((joint.mounting() == Mounting::CompliantHub).then_some(*hub)).collect()
}

/// An arm's section, uneven and different for each.
fn section(rng: &mut Rng) -> Section {
    let b = 0.02 * (1.0 + rng.f64());
    Section { bending_stiffness: [b, 1.5 * b], torsion_stiffness: 0.7 * b, ..super::rod::section() }
}

/// What slips beside an arm's spring: limits of 0.1 rad and 0.5 rad in bending and of 0.2 rad in torsion.
fn friction() -> SectionFriction {
    let element = |[stiffness, moment]: [f64; 2]| FrictionElement { stiffness, moment };
    SectionFriction { bending: [[0.5, 0.05], [0.2, 0.1]].map(element).to_vec(), torsion: vec![element([0.3, 0.06])] }
}

/// `k` arms in random directions; with `folded` the first two leave in the same direction; `curvature` is about how
/// much their branches are bent and twisted at rest, 1/m.
fn spec(k: usize, folded: bool, wired: bool, curvature: f64, rng: &mut Rng) -> JointSpec {
    let mut first = Vector::x();
    let arms = (0..k)
        .map(|a| {
            let mut direction = *random_direction(rng);
            if a == 0 {
                first = direction;
            } else if a == 1 && folded {
                direction = first;
            }
            let up = orthogonal(&direction);
            let roll = Rotation::from_axis_angle(&Vector::z_axis(), 3.0 * uniform(rng));
            let out = frame_from(&direction, &up).expect("orthogonal") * roll;
            let starts_here = rng.bool();
            Arm {
                branch: format!("arm {a}"),
                starts_here,
                rest: if starts_here { out } else { out * half_turn() },
                offset: Vector::zeros(),
                section: section(rng),
                segment_length: 0.05 * (1.0 + rng.f64()),
                length: 1.0,
                curvature: random_vector(rng, curvature),
                spring: ArmSpring {
                    bending: Some([0.2 * (1.0 + rng.f64()), 0.3 * (1.0 + rng.f64())]),
                    torsion: Some(0.1 * (1.0 + rng.f64())),
                    friction: friction(),
                },
            }
        })
        .collect();
    let mut wires = Vec::new();
    if wired {
        for from in 0..k {
            // Every other pair, and the neighbours always.
            for to in (from + 1..k).filter(|to| to - from == 1 || (to + from) % 2 == 0) {
                wires.push(WireShare { from, to, fraction: (0.5 + 0.4 * rng.f64()) / k as f64 });
            }
        }
    }
    JointSpec { name: "joint".into(), arms, wires }
}

/// 2 to 16 arms, folded or not, with wires or without, at turns from small to large, straight or curved at rest.
fn cases(subject: &Subject<'_>) -> Vec<Case> {
    let mut rng = Rng::with_seed(11);
    let mut all = Vec::new();
    for k in [2, 3, 4, 7, 16].into_iter().filter(|k| *k <= subject.most_arms) {
        for folded in [false, true] {
            for wired in [false, true] {
                for (turn, curvature) in [(0.1, 0.0), (1.0, 3.0), (2.5, 0.0)] {
                    let spec = spec(k, folded, wired, curvature, &mut rng);
                    let common = random_rotation(&mut rng);
                    let joint = subject.make(spec.clone());
                    let frames = frames(joint.as_ref(), &spec, &common, || random_turn(&mut rng, turn));
                    let name = format!(
                        "{k} arms{}{}, turns of {turn}",
                        if folded { ", folded" } else { "" },
                        if wired { ", wired" } else { "" }
                    );
                    let past = past(joint.as_ref(), &frames, turn, &mut rng);
                    all.push(Case { name, memory: remembered(joint.as_ref(), &past), joint, spec, frames, past });
                }
            }
        }
    }
    all
}

/// Energy and gradient.
fn gradient(joint: &dyn JointModel, shape: &JointShape<'_>) -> (f64, DVector<f64>) {
    let mut all = vec![Vector::zeros(); shape.frames.len()];
    let energy = joint.add_gradient(shape, &mut all);
    (energy, flat(&all))
}

/// The whole Hessian, from the blocks on and below the diagonal.
fn hessian(joint: &dyn JointModel, shape: &JointShape<'_>) -> DMatrix<f64> {
    let k = shape.frames.len();
    let mut table = vec![Matrix::zeros(); k * k];
    joint.add_hessian(shape, &mut table);
    DMatrix::from_fn(3 * k, 3 * k, |row, column| {
        let (a, b) = (row / 3, column / 3);
        if a >= b { table[a * k + b][(row % 3, column % 3)] } else { table[b * k + a][(column % 3, row % 3)] }
    })
}

fn moved(frames: &[Rotation], i: usize, h: f64) -> Vec<Rotation> {
    let mut to = frames.to_vec();
    let mut theta = Vector::zeros();
    theta[i % 3] = h;
    to[i / 3] = turned(&to[i / 3], &theta);
    to
}

/// # Panics
/// If a joint that carries its arms rigidly has an energy, a gradient or second derivatives.
pub fn hubs_have_no_energy(subject: &Subject<'_>) {
    for Case { name, joint, frames, memory, .. } in cases(subject) {
        if joint.mounting() == Mounting::Pose {
            let (energy, g) = gradient(joint.as_ref(), &at(&frames, &memory));
            let all = [
                joint.energy(&at(&frames, &memory)),
                energy,
                g.amax(),
                hessian(joint.as_ref(), &at(&frames, &memory)).amax(),
            ];
            assert_eq!(all, [0.0; 4], "{name}");
        }
    }
}

/// # Panics
/// If the gradient is not what differences of the energy say.
pub fn gradient_is_the_derivative_of_the_energy(subject: &Subject<'_>) {
    for Case { name, joint, frames, memory, .. } in cases(subject) {
        let (_, got) = gradient(joint.as_ref(), &at(&frames, &memory));
        let want = agreeing(&column(&got), DIFFERENCES, |step| {
            let slope = |i| derivative(step, |h| joint.energy(&at(&moved(&frames, i, h), &memory)));
            DMatrix::from_fn(3 * frames.len(), 1, |i, _| slope(i))
        });
        assert_all_near(&name, &got, &want.column(0).into_owned(), DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If the Hessian is not the symmetric part of the derivative of the gradient.
pub fn hessian_is_the_second_derivative_of_the_energy(subject: &Subject<'_>) {
    for Case { name, joint, frames, memory, .. } in cases(subject) {
        let got = hessian(joint.as_ref(), &at(&frames, &memory));
        let want = agreeing(&got, DIFFERENCES, |step| {
            let slopes =
                |i| derivative_of_all(step, |h| gradient(joint.as_ref(), &at(&moved(&frames, i, h), &memory)).1);
            symmetric(&DMatrix::from_columns(&(0..3 * frames.len()).map(slopes).collect::<Vec<_>>()))
        });
        assert_matrix_near(&name, &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If calls overwrite what stands in the rooms they are given.
pub fn gradient_and_hessian_are_added_to_what_is_there(subject: &Subject<'_>) {
    for Case { name, joint, frames, memory, .. } in cases(subject) {
        let k = frames.len();
        let (mut once, mut twice) = (vec![Vector::zeros(); k], vec![Vector::zeros(); k]);
        joint.add_gradient(&at(&frames, &memory), &mut once);
        joint.add_gradient(&at(&frames, &memory), &mut twice);
        joint.add_gradient(&at(&frames, &memory), &mut twice);
        let want = flat(&once) * 2.0;
        assert_all_near(&name, &flat(&twice), &want, subject.round_off * (1.0 + want.amax()));
        let (mut once, mut twice) = (vec![Matrix::zeros(); k * k], vec![Matrix::zeros(); k * k]);
        joint.add_hessian(&at(&frames, &memory), &mut once);
        joint.add_hessian(&at(&frames, &memory), &mut twice);
        joint.add_hessian(&at(&frames, &memory), &mut twice);
        for (once, twice) in once.iter().zip(&twice) {
            assert_near(&name, (once * 2.0 - twice).amax(), 0.0, subject.round_off * (1.0 + once.amax()));
        }
    }
}

/// # Panics
/// If turning all arms together changes energy or gradient.
pub fn a_common_rotation_changes_nothing(subject: &Subject<'_>) {
    let mut rng = Rng::with_seed(12);
    for Case { name, joint, frames, memory, .. } in cases(subject) {
        let common = random_rotation(&mut rng);
        let turned: Vec<_> = frames.iter().map(|q| common * q).collect();
        let (energy, want) = gradient(joint.as_ref(), &at(&frames, &memory));
        let (got_energy, got) = gradient(joint.as_ref(), &at(&turned, &memory));
        assert_near(&name, got_energy, energy, subject.round_off * (1.0 + energy));
        assert_all_near(&name, &got, &want, subject.round_off * (1.0 + want.amax()));
        let moment = frames
            .iter()
            .zip(want.as_slice().chunks(3))
            .fold(Vector::zeros(), |sum, (q, g)| sum + q * Vector::from_column_slice(g));
        assert_near(&format!("{name}: sum of moments"), moment.norm(), 0.0, subject.round_off * (1.0 + want.amax()));
    }
}

/// # Panics
/// If the joint has an energy or gradient where all arms, straight at rest, have their rest directions, beyond what
/// a turn by round-off has.
pub fn rest_directions_have_no_energy_and_no_gradient(subject: &Subject<'_>) {
    /// Rad.
    const ROUND_OFF: f64 = 8.0 * f64::EPSILON;
    let mut rng = Rng::with_seed(13);
    for Case { name, mut spec, .. } in cases(subject) {
        spec.arms.iter_mut().for_each(|arm| arm.curvature = Vector::zeros());
        let common = random_rotation(&mut rng);
        let joint = subject.make(spec.clone());
        let frames = frames(joint.as_ref(), &spec, &common, Rotation::identity);
        let (memory, joint) = (joint.memory(), joint.as_ref());
        let (energy, g) = gradient(joint, &at(&frames, &memory));
        let stiffness = hessian(joint, &at(&frames, &memory)).amax();
        assert_near(&format!("{name}: energy"), energy, 0.0, 1e-26 + stiffness * ROUND_OFF * ROUND_OFF);
        assert_near(&format!("{name}: gradient"), g.amax(), 0.0, 1e-13 + stiffness * ROUND_OFF);
    }
}

/// # Panics
/// If the energy is negative or `add_gradient` returns another.
pub fn energy_is_not_negative_and_the_one_of_the_gradient(subject: &Subject<'_>) {
    for Case { name, joint, frames, memory, .. } in cases(subject) {
        let energy = joint.energy(&at(&frames, &memory));
        assert!(energy >= 0.0, "{name}: {energy:e}");
        assert_near(
            &name,
            gradient(joint.as_ref(), &at(&frames, &memory)).0,
            energy,
            subject.round_off * (1.0 + energy),
        );
    }
}

/// # Panics
/// If it says a law ([`JointModel::law`]) of another energy.
pub fn a_law_it_says_has_its_energy(subject: &Subject<'_>) {
    for Case { name, joint, frames, memory, .. } in cases(subject) {
        let Some(law) = joint.law() else { continue };
        let (got, energy) = (joint_energy(&law, &at(&frames, &memory)), joint.energy(&at(&frames, &memory)));
        assert_near(&name, got, energy, subject.round_off * (1.0 + energy));
    }
}

/// # Panics
/// If naming the arms in the opposite order changes energy or gradient.
pub fn the_order_of_the_arms_does_not_matter(subject: &Subject<'_>) {
    for Case { name, mut spec, joint, mut frames, mut past, memory } in cases(subject) {
        let (energy, want) = gradient(joint.as_ref(), &at(&frames, &memory));
        let k = spec.arms.len();
        // A wire share is of the stiffness of the arm it comes from; name it from there still.
        for wire in &mut spec.wires {
            (wire.from, wire.to) = (k - 1 - wire.from, k - 1 - wire.to);
        }
        spec.arms.reverse();
        frames[..k].reverse();
        past.iter_mut().for_each(|frames| frames[..k].reverse());
        let other = subject.make(spec);
        let memory = remembered(other.as_ref(), &past);
        let (got_energy, got) = gradient(other.as_ref(), &at(&frames, &memory));
        let mut vectors: Vec<Vector> = got.as_slice().chunks(3).map(Vector::from_column_slice).collect();
        vectors[..k].reverse();
        assert_near(&name, got_energy, energy, 1e-9 * (1.0 + energy));
        assert_all_near(&name, &flat(&vectors), &want, 1e-9 * (1.0 + want.amax()));
    }
}

/// # Panics
/// If running one branch from its other end (rest and frame half a turn about d1, curvature `[−κ1, κ2, κ3]`), with the
/// same past, changes the energy, or does not turn the gradient with its frame.
pub fn running_a_branch_from_its_other_end_changes_nothing(subject: &Subject<'_>) {
    for Case { name, spec, joint, frames, past, memory } in cases(subject) {
        let (energy, want) = gradient(joint.as_ref(), &at(&frames, &memory));
        for a in 0..spec.arms.len() {
            let (mut spec, mut frames, mut past) = (spec.clone(), frames.clone(), past.clone());
            spec.arms[a].starts_here ^= true;
            spec.arms[a].rest *= half_turn();
            spec.arms[a].curvature = reversed_curvature(&spec.arms[a].curvature);
            frames[a] *= half_turn();
            past.iter_mut().for_each(|frames| frames[a] *= half_turn());
            let other = subject.make(spec);
            let memory = remembered(other.as_ref(), &past);
            let (got_energy, mut got) = gradient(other.as_ref(), &at(&frames, &memory));
            got[3 * a + 1] *= -1.0;
            got[3 * a + 2] *= -1.0;
            let name = format!("{name}: arm {a}");
            assert_near(&name, got_energy, energy, subject.round_off * (1.0 + energy));
            assert_all_near(&name, &got, &want, subject.round_off * (1.0 + want.amax()));
        }
    }
}

/// # Panics
/// If `−q` for `q`, which is the same frame, of an arm or of its rest direction changes energy, gradient or Hessian.
pub fn the_sign_of_a_quaternion_does_not_matter(subject: &Subject<'_>) {
    for Case { name, spec, joint, frames, memory, .. } in cases(subject) {
        let (energy, want) = gradient(joint.as_ref(), &at(&frames, &memory));
        let want_hessian = hessian(joint.as_ref(), &at(&frames, &memory));
        for a in 0..frames.len() {
            let (mut spec, mut negative) = (spec.clone(), frames.clone());
            // Behind the arms stands a compliant hub, whose own rest frame is not given.
            spec.arms.get_mut(a).into_iter().for_each(|arm| arm.rest = negated(&arm.rest));
            negative[a] = negated(&frames[a]);
            let other = subject.make(spec);
            for (what, joint, frames) in [("frame", &joint, &negative), ("rest", &other, &frames)] {
                let name = format!("{name}: {what} of arm {a}");
                let (got_energy, got) = gradient(joint.as_ref(), &at(frames, &memory));
                assert_near(&name, got_energy, energy, subject.round_off * (1.0 + energy));
                assert_all_near(&name, &got, &want, subject.round_off * (1.0 + want.amax()));
                let tolerance = subject.round_off * (1.0 + want_hessian.amax());
                assert_matrix_near(&name, &hessian(joint.as_ref(), &at(frames, &memory)), &want_hessian, tolerance);
            }
        }
    }
}

/// # Panics
/// If a frame that is not finite gives a finite energy or gradient.
pub fn non_finite_input_gives_non_finite_output(subject: &Subject<'_>) {
    for Case { name, joint, frames, memory, .. } in cases(subject) {
        if joint.mounting() == Mounting::Pose {
            continue;
        }
        for a in 0..frames.len() {
            let mut bad = frames.clone();
            bad[a].as_mut_unchecked().coords.y = f64::NAN;
            let (energy, g) = gradient(joint.as_ref(), &at(&bad, &memory));
            assert!(
                !energy.is_finite() && !joint.energy(&at(&bad, &memory)).is_finite(),
                "{name}: arm {a}: {energy:e}"
            );
            assert!(g.iter().any(|x| !x.is_finite()), "{name}: arm {a}: gradient");
        }
    }
}

/// # Panics
/// If two joints of one specification, or two calls, give different bits.
pub fn same_input_gives_same_bits(subject: &Subject<'_>) {
    let bits =
        |(energy, v): (f64, DVector<f64>)| -> Vec<u64> { v.iter().chain([&energy]).map(|x| x.to_bits()).collect() };
    for Case { name, spec, joint, frames, memory, .. } in cases(subject) {
        let other = subject.make(spec);
        let first = bits(gradient(joint.as_ref(), &at(&frames, &memory)));
        assert_eq!(first, bits(gradient(joint.as_ref(), &at(&frames, &memory))), "{name}: second call");
        assert_eq!(first, bits(gradient(other.as_ref(), &at(&frames, &memory))), "{name}: second joint");
    }
}

/// # Panics
/// If an increment dissipates energy less than 0, if committing it again changes a bit of the memory or dissipates
/// again, if it changes the gradient by more than round-off, if the memory is not as long as it was, or if what was
/// minimised is not what is then stored and dissipated.
pub fn memory_is_committed_once(subject: &Subject<'_>) {
    for Case { name, joint, frames, memory, .. } in cases(subject) {
        let (before, want) = gradient(joint.as_ref(), &at(&frames, &memory));
        let (memory, dissipated) = committed(joint.as_ref(), &frames, &memory);
        assert_eq!(memory.len(), joint.memory().len(), "{name}");
        let (stored, got) = gradient(joint.as_ref(), &at(&frames, &memory));
        let tolerance = if subject.round_off > ROUND_OFF { ACROSS_A_LIMIT } else { subject.round_off };
        assert_all_near(&name, &got, &want, tolerance * (1.0 + want.amax()));
        // A joint may not know what it dissipates.
        if dissipated > 0.0 {
            assert_near(&name, stored + dissipated, before, subject.round_off * (1.0 + before));
        }
        assert_eq!(committed(joint.as_ref(), &frames, &memory), (memory, 0.0), "{name}: committed twice");
    }
}

/// A check of [`joint_conformance`](crate::joint_conformance).
pub type Check = fn(&Subject<'_>);

crate::joint_checks! { listed_checks CHECKS, }
