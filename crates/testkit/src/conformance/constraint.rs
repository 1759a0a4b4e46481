//! Checks of [`Constraint`], [`Potential`] and [`Equations`], one for each clause of their contracts.

use super::numeric::*;
use crate::laws::spring_energy;
use fastrand::Rng;
use nalgebra::{DMatrix, DVector};
use wireloom_core::{
    Action, Constraint, ConstraintView, Equations, Hold, Matrix, Pose, Potential, Residual, Rotation, RotationHold,
    Vector,
};

/// Makes the constraint under test.
pub type Factory<'f> = dyn Fn() -> Box<dyn Constraint> + 'f;

/// A constraint under test, and what it attaches to.
pub struct Subject<'f> {
    factory: Box<Factory<'f>>,
    stations: usize,
    nodes: usize,
}

impl<'f> Subject<'f> {
    /// Of constraints that attach to so many stations, and act along a span of so many nodes (0: no span).
    pub fn new(factory: impl Fn() -> Box<dyn Constraint> + 'f, stations: usize, nodes: usize) -> Self {
        Self { factory: Box::new(factory), stations, nodes }
    }

    fn make(&self) -> Box<dyn Constraint> {
        (self.factory)()
    }
}

/// A check; it panics where the constraint fails it.
pub type Check = fn(&Subject<'_>);

const ROUND_OFF: f64 = 1e-12;
const DIFFERENCES: f64 = 1e-8;

fn potential(constraint: &dyn Constraint) -> &dyn Potential {
    match constraint.action() {
        Action::Potential(potential) | Action::PotentialAndEquations(potential, _) => potential,
        Action::Prescribed(hold) => panic!("prescribes {hold:?} instead of pulling"),
        Action::Equations(_) => panic!("sets equations instead of pulling"),
    }
}

fn hold(constraint: &dyn Constraint) -> &Hold {
    match constraint.action() {
        Action::Prescribed(hold) => hold,
        Action::Potential(_) => panic!("pulls instead of prescribing"),
        Action::Equations(_) | Action::PotentialAndEquations(..) => panic!("sets equations instead of prescribing"),
    }
}

fn equations(constraint: &dyn Constraint) -> &dyn Equations {
    match constraint.action() {
        Action::Equations(equations) | Action::PotentialAndEquations(_, equations) => equations,
        Action::Prescribed(hold) => panic!("prescribes {hold:?} instead of setting equations"),
        Action::Potential(_) => panic!("pulls instead of setting equations"),
    }
}

/// Owned data of a [`ConstraintView`].
#[derive(Clone)]
struct Scene {
    stations: Vec<Pose>,
    targets: Vec<Pose>,
    span: Vec<Vector>,
    span_lengths: Vec<f64>,
    progress: f64,
    memory: Vec<f64>,
    tensions: Vec<[f64; 2]>,
}

impl Scene {
    fn at(&self) -> ConstraintView<'_> {
        ConstraintView {
            stations: &self.stations,
            targets: &self.targets,
            span: &self.span,
            span_lengths: &self.span_lengths,
            progress: self.progress,
            memory: &self.memory,
            tensions: &[],
        }
    }

    /// At the equilibrium that ends an increment.
    fn at_end(&self) -> ConstraintView<'_> {
        ConstraintView { tensions: &self.tensions, ..self.at() }
    }

    /// Number of degrees of freedom.
    fn freedoms(&self) -> usize {
        6 * self.stations.len() + 3 * self.span.len()
    }

    /// With freedom `i` moved by `h`.
    fn moved(&self, i: usize, h: f64) -> Self {
        let mut to = self.clone();
        let mut step = Vector::zeros();
        step[i % 3] = h;
        let of_stations = 6 * self.stations.len();
        if i >= of_stations {
            to.span[(i - of_stations) / 3] += step;
        } else if i % 6 < 3 {
            to.stations[i / 6].position += step;
        } else {
            let orientation = &mut to.stations[i / 6].orientation;
            *orientation = turned(orientation, &step);
        }
        to
    }

    /// After a rigid motion of everything.
    fn carried(&self, motion: &Pose) -> Self {
        let mut to = self.clone();
        to.stations.iter_mut().chain(&mut to.targets).for_each(|pose| *pose = motion.compose(pose));
        to.span.iter_mut().for_each(|x| *x = motion.position + motion.orientation * *x);
        to
    }
}

/// Stations and targets that are apart and turned by little and by much, nodes of a span somewhere among them.
fn scenes(subject: &Subject<'_>, constraint: &dyn Constraint) -> Vec<Scene> {
    let mut rng = Rng::with_seed(21);
    let mut all = Vec::new();
    for (apart, turn) in [(1e-3, 1e-3), (0.1, 0.3), (1.0, 1.5), (0.3, 2.9)] {
        for _ in 0..5 {
            let mut scene = Scene {
                stations: vec![],
                targets: vec![],
                span: (0..subject.nodes).map(|_| random_vector(&mut rng, 1.0)).collect(),
                span_lengths: (0..subject.nodes).map(|_| 0.01 + 0.01 * rng.f64()).collect(),
                progress: rng.f64(),
                memory: constraint.memory(),
                tensions: (0..subject.stations).map(|_| [uniform(&mut rng), uniform(&mut rng)]).collect(),
            };
            for _ in 0..subject.stations {
                let target = Pose { position: random_vector(&mut rng, 1.0), orientation: random_rotation(&mut rng) };
                let local = Pose { position: random_vector(&mut rng, apart), orientation: random_turn(&mut rng, turn) };
                scene.stations.push(target.compose(&local));
                scene.targets.push(target);
            }
            all.push(scene);
        }
    }
    all
}

/// The scenes, and of a constraint that remembers each of them once more, with what is remembered of those before it.
fn scenes_with_memories(subject: &Subject<'_>, constraint: &dyn Constraint) -> Vec<Scene> {
    let mut all = scenes(subject, constraint);
    let mut memory = constraint.memory();
    if memory.is_empty() {
        return all;
    }
    for k in 0..all.len() {
        let scene = Scene { memory: memory.clone(), ..all[k].clone() };
        constraint.commit(&scene.at_end(), &mut memory);
        all.push(scene);
    }
    all
}

/// First derivatives in all freedoms, and the energy.
fn gradient(potential: &dyn Potential, scene: &Scene) -> (DVector<f64>, f64) {
    let mut stations = vec![Vector::zeros(); 2 * scene.stations.len()];
    let mut span = vec![Vector::zeros(); scene.span.len()];
    let energy = potential.gradient(&scene.at(), &mut stations, &mut span);
    (flat(stations.iter().chain(&span)), energy)
}

/// Room for second derivatives, and all of them as one matrix.
fn second_derivatives(scene: &Scene, fill: impl FnOnce(&mut [Matrix], &mut [Matrix])) -> DMatrix<f64> {
    let (width, nodes) = (2 * scene.stations.len(), scene.span.len());
    let mut stations = vec![Matrix::zeros(); width * width];
    let mut span = vec![Matrix::zeros(); nodes];
    fill(&mut stations, &mut span);
    let mut whole = DMatrix::zeros(scene.freedoms(), scene.freedoms());
    for (k, block) in stations.iter().enumerate() {
        whole.fixed_view_mut::<3, 3>(3 * (k / width), 3 * (k % width)).copy_from(block);
    }
    for (k, block) in span.iter().enumerate() {
        whole.fixed_view_mut::<3, 3>(3 * (width + k), 3 * (width + k)).copy_from(block);
    }
    whole
}

fn hessian(potential: &dyn Potential, scene: &Scene) -> DMatrix<f64> {
    second_derivatives(scene, |stations, span| potential.hessian(&scene.at(), stations, span))
}

/// The residuals of stations and of all nodes.
fn declared(equations: &dyn Equations, scene: &Scene) -> Vec<Residual> {
    let mut all = equations.of_stations();
    all.extend(scene.span.iter().flat_map(|_| equations.of_each_node()));
    all
}

fn residuals(equations: &dyn Equations, scene: &Scene) -> DVector<f64> {
    let mut c = vec![0.0; declared(equations, scene).len()];
    equations.residuals(&scene.at(), &mut c);
    DVector::from_vec(c)
}

/// J, one row for each residual, and c.
fn jacobian(equations: &dyn Equations, scene: &Scene) -> (DMatrix<f64>, DVector<f64>) {
    let (width, all) = (2 * scene.stations.len(), declared(equations, scene).len());
    let of_stations = equations.of_stations().len();
    let mut c = vec![0.0; all];
    let mut stations = vec![Vector::zeros(); width * of_stations];
    let mut span = vec![Vector::zeros(); all - of_stations];
    equations.jacobian(&scene.at(), &mut c, &mut stations, &mut span);
    let mut whole = DMatrix::zeros(all, scene.freedoms());
    for (k, j) in stations.iter().enumerate() {
        whole.fixed_view_mut::<1, 3>(k / width, 3 * (k % width)).copy_from(&j.transpose());
    }
    let per_node = span.len() / scene.span.len().max(1);
    for (k, j) in span.iter().enumerate() {
        whole.fixed_view_mut::<1, 3>(of_stations + k, 3 * (width + k / per_node)).copy_from(&j.transpose());
    }
    (whole, DVector::from_vec(c))
}

/// Turns the parts of first derivatives that are vectors of the world: all but those of rotations, which are of the
/// body.
fn along(motion: &Rotation, scene: &Scene, g: &DVector<f64>) -> DVector<f64> {
    let mut g = g.clone();
    for k in 0..g.len() / 3 {
        if k >= 2 * scene.stations.len() || k % 2 == 0 {
            let v: Vector = g.fixed_rows::<3>(3 * k).into_owned();
            g.fixed_rows_mut::<3>(3 * k).copy_from(&(motion * v));
        }
    }
    g
}

/// # Panics
/// If the constraint acts in another way.
pub fn is_a_potential(subject: &Subject<'_>) {
    potential(subject.make().as_ref());
}

/// # Panics
/// If it says a law ([`Constraint::law`]) of another energy.
pub fn a_law_it_says_has_its_energy(subject: &Subject<'_>) {
    let constraint = subject.make();
    let Some(law) = constraint.law() else { return };
    let potential = potential(constraint.as_ref());
    for scene in scenes(subject, constraint.as_ref()) {
        let got = spring_energy(&law, &scene.stations[0], &scene.targets[0]);
        let energy = potential.energy(&scene.at());
        assert_near("energy", got, energy, ROUND_OFF * (1.0 + energy));
    }
}

/// # Panics
/// If the constraint acts in another way.
pub fn sets_equations(subject: &Subject<'_>) {
    equations(subject.make().as_ref());
}

/// # Panics
/// If the gradient is not what differences of the energy say, or comes with another energy.
pub fn gradient_is_the_derivative_of_the_energy(subject: &Subject<'_>) {
    let constraint = subject.make();
    let potential = potential(constraint.as_ref());
    for scene in scenes_with_memories(subject, constraint.as_ref()) {
        let (got, energy) = gradient(potential, &scene);
        let want = agreeing(&column(&got), DIFFERENCES, |step| {
            let slope = |i| derivative(step, |h| potential.energy(&scene.moved(i, h).at()));
            DMatrix::from_fn(scene.freedoms(), 1, |i, _| slope(i))
        });
        assert_all_near("gradient", &got, &want.column(0).into_owned(), DIFFERENCES * (1.0 + want.amax()));
        assert_near("energy", energy, potential.energy(&scene.at()), ROUND_OFF * (1.0 + energy.abs()));
    }
}

/// # Panics
/// If the Hessian is not the symmetric part of the derivative of the gradient, or nodes of the span are coupled.
pub fn hessian_is_the_second_derivative_of_the_energy(subject: &Subject<'_>) {
    let constraint = subject.make();
    let potential = potential(constraint.as_ref());
    for scene in scenes_with_memories(subject, constraint.as_ref()) {
        let got = hessian(potential, &scene);
        let want = agreeing(&got, DIFFERENCES, |step| {
            let slopes = |i| derivative_of_all(step, |h| gradient(potential, &scene.moved(i, h)).0);
            symmetric(&DMatrix::from_columns(&(0..scene.freedoms()).map(slopes).collect::<Vec<_>>()))
        });
        assert_matrix_near("hessian", &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If the constraint is said to be objective, and energy or body moments change, or forces do not turn along, when
/// everything undergoes the same rigid motion.
pub fn moving_everything_together_changes_nothing(subject: &Subject<'_>) {
    let constraint = subject.make();
    let potential = potential(constraint.as_ref());
    let mut rng = Rng::with_seed(22);
    if !constraint.objective() {
        return;
    }
    for scene in scenes(subject, constraint.as_ref()) {
        let motion = Pose { position: random_vector(&mut rng, 1.0), orientation: random_rotation(&mut rng) };
        let (want, energy) = gradient(potential, &scene);
        let want = along(&motion.orientation, &scene, &want);
        let (got, moved) = gradient(potential, &scene.carried(&motion));
        assert_near("energy", moved, energy, ROUND_OFF * (1.0 + energy.abs()));
        assert_all_near("gradient", &got, &want, 1e-11 * (1.0 + want.amax()));
    }
}

/// # Panics
/// If `−q` for `q`, which is the same frame, at a station or its target changes energy, gradient or Hessian.
pub fn the_sign_of_a_quaternion_does_not_matter(subject: &Subject<'_>) {
    let constraint = subject.make();
    let potential = potential(constraint.as_ref());
    for scene in scenes(subject, constraint.as_ref()) {
        let ((want, energy), want_hessian) = (gradient(potential, &scene), hessian(potential, &scene));
        for other in signs(&scene) {
            let (got, other_energy) = gradient(potential, &other);
            assert_near("energy", other_energy, energy, ROUND_OFF * (1.0 + energy.abs()));
            assert_all_near("gradient", &got, &want, 1e-11 * (1.0 + want.amax()));
            let tolerance = 1e-11 * (1.0 + want_hessian.amax());
            assert_matrix_near("hessian", &hessian(potential, &other), &want_hessian, tolerance);
        }
    }
}

/// The same frames by other quaternions: each station and each target for itself, and all of them.
fn signs(scene: &Scene) -> Vec<Scene> {
    let m = scene.stations.len();
    let flipped = |which: &dyn Fn(usize) -> bool| {
        let mut other = scene.clone();
        for (k, pose) in other.stations.iter_mut().chain(&mut other.targets).enumerate() {
            if which(k) {
                pose.orientation = negated(&pose.orientation);
            }
        }
        other
    };
    (0..2 * m).map(|one| flipped(&|k| k == one)).chain([flipped(&|_| true)]).collect()
}

/// # Panics
/// If there is an energy, force or moment at the targets.
pub fn at_the_target_there_is_no_energy_and_no_force(subject: &Subject<'_>) {
    let constraint = subject.make();
    let potential = potential(constraint.as_ref());
    for mut scene in scenes(subject, constraint.as_ref()) {
        scene.stations.clone_from(&scene.targets);
        let scale = hessian(potential, &scene).amax();
        let (g, energy) = gradient(potential, &scene);
        assert_near("energy", energy, 0.0, 1e-29 * scale);
        assert_near("gradient", g.amax(), 0.0, 1e-15 * scale);
    }
}

/// # Panics
/// If an energy is negative, at however small a distance from the target.
pub fn energy_is_not_negative(subject: &Subject<'_>) {
    let constraint = subject.make();
    let potential = potential(constraint.as_ref());
    let mut rng = Rng::with_seed(23);
    for scene in scenes(subject, constraint.as_ref()) {
        let (mut near, mut there) = (scene.clone(), scene.clone());
        there.stations.clone_from(&scene.targets);
        near.stations.clone_from(&scene.targets);
        near.stations.iter_mut().for_each(|pose| pose.orientation *= random_turn(&mut rng, 1e-8));
        for scene in [&scene, &near, &there] {
            let energy = potential.energy(&scene.at());
            assert!(energy >= 0.0, "{energy:e}");
        }
    }
}

/// # Panics
/// If a constraint says it needs no frame but exerts moments.
pub fn without_need_of_a_frame_there_is_no_moment(subject: &Subject<'_>) {
    let constraint = subject.make();
    if constraint.needs_frame() {
        return;
    }
    let of_frames = |scene: &Scene, i: usize| i < 6 * scene.stations.len() && i % 6 >= 3;
    for scene in scenes(subject, constraint.as_ref()) {
        let of_potential = |potential: &dyn Potential| {
            let mut rows = hessian(potential, &scene).insert_row(0, 0.0);
            rows.row_mut(0).copy_from(&gradient(potential, &scene).0.transpose());
            rows
        };
        let action = constraint.action();
        let of_equations = action.equations().map(|equations| jacobian(equations, &scene).0);
        for rows in action.potential().map(of_potential).into_iter().chain(of_equations) {
            for i in (0..scene.freedoms()).filter(|i| of_frames(&scene, *i)) {
                assert_eq!(rows.column(i).amax(), 0.0, "derivatives in rotations");
            }
        }
    }
}

/// # Panics
/// If a position that is not finite gives a finite energy or gradient.
pub fn non_finite_input_gives_non_finite_output(subject: &Subject<'_>) {
    let constraint = subject.make();
    let potential = potential(constraint.as_ref());
    for mut scene in scenes(subject, constraint.as_ref()) {
        scene.stations[0].position.z = f64::NAN;
        let (g, energy) = gradient(potential, &scene);
        assert!(!energy.is_finite(), "energy");
        assert!(g.iter().any(|x| !x.is_finite()), "gradient");
    }
}

/// # Panics
/// If two constraints of one specification, or two calls, give different bits.
pub fn same_input_gives_same_bits(subject: &Subject<'_>) {
    let (one, other) = (subject.make(), subject.make());
    let bits = |constraint: &dyn Constraint, scene: &Scene| -> Vec<u64> {
        let (action, mut numbers) = (constraint.action(), vec![]);
        if let Some(potential) = action.potential() {
            let (g, energy) = gradient(potential, scene);
            numbers.extend(g.iter().chain(hessian(potential, scene).iter()).copied().chain([energy]));
        }
        if let Some(equations) = action.equations() {
            let (j, c) = jacobian(equations, scene);
            numbers.extend(j.iter().chain(residuals(equations, scene).iter()).chain(c.iter()).copied());
        }
        let target = scene.targets.first().map(|base| constraint.target(base, scene.progress));
        let mut memory = scene.memory.clone();
        constraint.commit(&scene.at_end(), &mut memory);
        let of_target = target.iter().flat_map(|t| t.position.iter().chain(t.orientation.coords.iter()).copied());
        numbers.iter().copied().chain(of_target).chain(memory.iter().copied()).map(f64::to_bits).collect()
    };
    for scene in scenes(subject, one.as_ref()) {
        let first = bits(one.as_ref(), &scene);
        assert_eq!(first, bits(one.as_ref(), &scene), "the same constraint");
        assert_eq!(first, bits(other.as_ref(), &scene), "another one of the same specification");
    }
}

/// # Panics
/// If what is remembered changes its length, or what is not finite is remembered, over five increments.
pub fn what_is_remembered_keeps_its_length_and_is_finite(subject: &Subject<'_>) {
    let constraint = subject.make();
    let mut memory = constraint.memory();
    assert_eq!(memory.len(), subject.make().memory().len(), "length of what two of them remember");
    for mut scene in scenes(subject, constraint.as_ref()).into_iter().take(5) {
        scene.memory.clone_from(&memory);
        constraint.commit(&scene.at_end(), &mut memory);
        assert!(memory.iter().all(|x| x.is_finite()), "{memory:?}");
    }
}

/// # Panics
/// If the target at no progress is not a pose, or not the same for the same.
pub fn targets_are_poses(subject: &Subject<'_>) {
    let constraint = subject.make();
    for scene in scenes(subject, constraint.as_ref()) {
        for base in &scene.targets {
            let pose = constraint.target(base, scene.progress);
            assert!(pose.position.iter().all(|x| x.is_finite()), "{pose:?}");
            assert_near("length of the quaternion", pose.orientation.norm(), 1.0, 1e-12);
        }
    }
}

/// # Panics
/// If a residual is measured by what is no positive number, or there is none.
pub fn every_residual_has_a_scale(subject: &Subject<'_>) {
    let constraint = subject.make();
    let equations = equations(constraint.as_ref());
    for scene in scenes(subject, constraint.as_ref()).iter().take(1) {
        let all = declared(equations, scene);
        assert!(!all.is_empty(), "no residuals");
        assert!(all.iter().all(|r| r.scale > 0.0 && r.scale.is_finite()), "{all:?}");
    }
}

/// # Panics
/// If J is not what differences of c say (which includes that a node's residuals depend on nothing else), or comes with
/// another c.
pub fn jacobian_is_the_derivative_of_the_residuals(subject: &Subject<'_>) {
    let constraint = subject.make();
    let equations = equations(constraint.as_ref());
    for scene in scenes_with_memories(subject, constraint.as_ref()) {
        let (got, c) = jacobian(equations, &scene);
        let want = agreeing(&got, DIFFERENCES, |step| {
            let slopes = |i| derivative_of_all(step, |h| residuals(equations, &scene.moved(i, h)));
            DMatrix::from_columns(&(0..scene.freedoms()).map(slopes).collect::<Vec<_>>())
        });
        assert_matrix_near("jacobian", &got, &want, DIFFERENCES * (1.0 + want.amax()));
        assert_all_near("residuals", &c, &residuals(equations, &scene), ROUND_OFF * (1.0 + c.amax()));
    }
}

/// # Panics
/// If there are second derivatives, and they are not those of Σ w c.
pub fn curvature_is_the_second_derivative_of_the_residuals_or_nothing(subject: &Subject<'_>) {
    let constraint = subject.make();
    let equations = equations(constraint.as_ref());
    let mut rng = Rng::with_seed(24);
    for scene in scenes_with_memories(subject, constraint.as_ref()) {
        let w: Vec<f64> = declared(equations, &scene).iter().map(|_| uniform(&mut rng)).collect();
        let got = second_derivatives(&scene, |stations, span| equations.curvature(&scene.at(), &w, stations, span));
        if got.amax() == 0.0 {
            continue;
        }
        let weighted = |scene: &Scene| jacobian(equations, scene).0.tr_mul(&DVector::from_column_slice(&w));
        let want = agreeing(&got, DIFFERENCES, |step| {
            let slopes = |i| derivative_of_all(step, |h| weighted(&scene.moved(i, h)));
            symmetric(&DMatrix::from_columns(&(0..scene.freedoms()).map(slopes).collect::<Vec<_>>()))
        });
        assert_matrix_near("curvature", &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If the constraint is said to be objective, and residuals change, or their derivatives do not turn along, when
/// everything undergoes the same rigid motion.
pub fn moving_everything_together_changes_no_residual(subject: &Subject<'_>) {
    let constraint = subject.make();
    let equations = equations(constraint.as_ref());
    let mut rng = Rng::with_seed(25);
    if !constraint.objective() {
        return;
    }
    for scene in scenes(subject, constraint.as_ref()) {
        let motion = Pose { position: random_vector(&mut rng, 1.0), orientation: random_rotation(&mut rng) };
        let ((j, c), (j2, c2)) = (jacobian(equations, &scene), jacobian(equations, &scene.carried(&motion)));
        for (row, row2) in j.row_iter().zip(j2.row_iter()) {
            let want = along(&motion.orientation, &scene, &row.transpose());
            assert_all_near("jacobian", &row2.transpose(), &want, 1e-11 * (1.0 + want.amax()));
        }
        assert_all_near("residuals", &c2, &c, 1e-11 * (1.0 + c.amax()));
    }
}

/// # Panics
/// If `−q` for `q`, which is the same frame, at a station or its target changes residuals or their derivatives.
pub fn the_sign_of_a_quaternion_changes_no_residual(subject: &Subject<'_>) {
    let constraint = subject.make();
    let equations = equations(constraint.as_ref());
    for scene in scenes(subject, constraint.as_ref()) {
        let (j, c) = jacobian(equations, &scene);
        for other in signs(&scene) {
            let (j2, c2) = jacobian(equations, &other);
            assert_all_near("residuals", &c2, &c, 1e-11 * (1.0 + c.amax()));
            assert_matrix_near("jacobian", &j2, &j, 1e-11 * (1.0 + j.amax()));
        }
    }
}

/// # Panics
/// If the constraint acts in another way.
pub fn prescribes_freedoms(subject: &Subject<'_>) {
    let constraint = subject.make();
    let hold = hold(constraint.as_ref());
    assert!(hold.position || hold.rotation != RotationHold::Free, "{hold:?} holds nothing");
}

/// # Panics
/// If rails and held directions are not an orthonormal basis of space where the position is held, or a held
/// direction exists where it is not.
pub fn rails_and_held_directions_span_space(subject: &Subject<'_>) {
    let constraint = subject.make();
    let hold = hold(constraint.as_ref());
    let held = hold.held_directions();
    if !hold.position {
        assert!(held.is_empty(), "{hold:?} holds {held:?}");
        return;
    }
    let all: Vec<Vector> = hold.rails.iter().copied().chain(held).collect();
    assert_eq!(all.len(), 3, "{all:?}");
    for (i, a) in all.iter().enumerate() {
        for (k, b) in all.iter().enumerate() {
            assert_near("product of directions", a.dot(b), f64::from(u8::from(i == k)), 1e-14);
        }
    }
}

/// # Panics
/// If the constraint asks for a frame without holding a rotation, or the other way round.
pub fn needs_a_frame_exactly_if_it_holds_a_rotation(subject: &Subject<'_>) {
    let constraint = subject.make();
    let hold = hold(constraint.as_ref());
    assert_eq!(constraint.needs_frame(), hold.rotation != RotationHold::Free, "{hold:?}");
    if let RotationHold::Hinge(axis) = hold.rotation {
        assert_near("length of the hinge's axis", axis.norm(), 1.0, 1e-14);
    }
}

/// # Panics
/// If two constraints of one specification, or two questions, get different answers.
pub fn describes_the_same_hold_every_time(subject: &Subject<'_>) {
    let (one, other) = (subject.make(), subject.make());
    assert_eq!(hold(one.as_ref()), hold(one.as_ref()));
    assert_eq!(hold(one.as_ref()), hold(other.as_ref()));
}

crate::constraint_checks! { potential, listed_checks POTENTIAL, }
crate::constraint_checks! { equations, listed_checks EQUATIONS, }
crate::constraint_checks! { potential_and_equations, listed_checks POTENTIAL_AND_EQUATIONS, }
crate::constraint_checks! { prescribed, listed_checks PRESCRIBED, }

/// The checks for the way in which a constraint acts, each with its name.
pub fn checks(subject: &Subject<'_>) -> &'static [(&'static str, Check)] {
    match subject.make().action() {
        Action::Prescribed(_) => PRESCRIBED,
        Action::Potential(_) => POTENTIAL,
        Action::Equations(_) => EQUATIONS,
        Action::PotentialAndEquations(..) => POTENTIAL_AND_EQUATIONS,
    }
}
