//! Checks of [`RodSegment`], one for each clause of its contract.

use super::numeric::*;
use crate::laws::rod_energy;
use fastrand::Rng;
use nalgebra::{DMatrix, DVector};
use wireloom_core::rod::{BranchHessian, Mesh, RodEnergy, RodSpec};
use wireloom_core::{BranchShape, Matrix, RodSegment, Rotation, Section, Vector};

mod order;
pub use order::{a_station_inside_changes_the_energy_to_second_order, energy_is_second_order_in_the_segment_length};

/// Makes the rod under test.
pub type Factory<'f> = dyn Fn(RodSpec) -> Box<dyn RodSegment> + 'f;

/// Relative error allowed where two ways of summing up are compared.
const ROUND_OFF: f64 = 1e-11;
/// Relative error allowed to fourth-order differences with [`STEP`].
const DIFFERENCES: f64 = 1e-7;
/// Step of the differences: rad, or segment lengths.
const STEP: f64 = 1e-3;

/// Stiffnesses all different, and so near to each other (for segments of about 0.1 m) that no effect hides in the
/// round-off of another.
pub fn section() -> Section {
    Section {
        name: "uneven".into(),
        diameter: 0.01,
        linear_density: 0.1,
        axial_stiffness: 120.0,
        shear_stiffness: [70.0, 45.0],
        bending_stiffness: [0.05, 0.08],
        torsion_stiffness: 0.03,
        coupling_stiffness: [0.0; 3],
        min_bend_radius: None,
        min_bend_radius_moving: None,
        max_tension: None,
        max_torsion: None,
        thermal_expansion: 0.0,
        thermal_curvature: Vector::zeros(),
        friction: Default::default(),
        set: None,
        laws: Default::default(),
    }
}

fn spec(mesh: &Mesh, curvature: Vector) -> RodSpec {
    RodSpec { name: "branch".into(), sections: section().into(), mesh: mesh.clone(), curvature }
}

/// Name of the shape whose first, third, … edges point against their frames.
const OVERTURNED: &str = "overturned";

/// Positions and frames of one branch.
#[derive(Clone)]
struct Shape {
    points: Vec<Vector>,
    compensation: Vec<Vector>,
    frames: Vec<Rotation>,
    free_strain: f64,
    extra: Vec<Vector>,
    rest_lengths: Vec<f64>,
    coupling_lengths: Vec<f64>,
    memory: Vec<f64>,
    duration: f64,
}

impl Shape {
    fn view(&self) -> BranchShape<'_> {
        BranchShape {
            points: &self.points,
            compensation: &self.compensation,
            frames: &self.frames,
            rest_lengths: &self.rest_lengths,
            coupling_lengths: &self.coupling_lengths,
            free_strain: self.free_strain,
            extra_curvature: &self.extra,
            memory: &self.memory,
            duration: self.duration,
        }
    }

    /// `x + h δ`, `q ∘ exp(h θ)`, entries of the direction in the order of [`gradient`].
    fn moved(&self, direction: &DVector<f64>, h: f64) -> Self {
        let part = |i: usize| Vector::new(direction[3 * i], direction[3 * i + 1], direction[3 * i + 2]) * h;
        let mut to = self.clone();
        for (i, x) in to.points.iter_mut().enumerate() {
            *x += part(i);
        }
        for (c, q) in to.frames.iter_mut().enumerate() {
            *q = turned(q, &part(self.points.len() + c));
        }
        to
    }

    fn size(&self) -> usize {
        3 * (self.points.len() + self.frames.len())
    }

    /// With rest lengths (m) that are not those of the mesh.
    fn with_lengths(&self, mesh: &Mesh, rest_lengths: Vec<f64>) -> Self {
        let mut to = Self { rest_lengths, ..self.clone() };
        mesh.couple(&to.rest_lengths, &mut to.coupling_lengths);
        to
    }

    /// The same shape run from its other end; its memory is not turned.
    fn reversed(&self) -> Self {
        let back = |v: &[Vector]| v.iter().rev().copied().collect::<Vec<_>>();
        Self {
            points: back(&self.points),
            compensation: back(&self.compensation),
            frames: self.frames.iter().rev().map(|q| q * half_turn()).collect(),
            free_strain: self.free_strain,
            extra: self.extra.iter().rev().map(reversed_curvature).collect(),
            rest_lengths: self.rest_lengths.iter().rev().copied().collect(),
            coupling_lengths: self.coupling_lengths.iter().rev().copied().collect(),
            memory: self.memory.clone(),
            duration: self.duration,
        }
    }

    /// The memory at the end of an increment that ends in this shape.
    fn committed(&self, rod: &dyn RodSegment) -> Vec<f64> {
        let mut memory = self.memory.clone();
        rod.commit(&self.view(), &mut memory);
        memory
    }
}

/// A rod in a shape.
struct Case {
    name: String,
    spec: RodSpec,
    rod: Box<dyn RodSegment>,
    shape: Shape,
    /// Frames of the increments before, for a rod that remembers.
    past: Vec<Vec<Rotation>>,
}

/// Meshes with stations at ends and inside, of uneven segments, down to a single one.
fn meshes() -> Vec<(&'static str, Mesh)> {
    let five = vec![0.1, 0.13, 0.07, 0.11, 0.09];
    let mut long = vec![0.1; 13];
    long[4..7].copy_from_slice(&[0.12, 0.09, 0.11]);
    vec![
        ("stations at both ends", Mesh::new(five.clone(), vec![0, 5])),
        ("no station", Mesh::new(five.clone(), vec![])),
        ("a station at the start", Mesh::new(five.clone(), vec![0])),
        ("a station at the end", Mesh::new(five.clone(), vec![5])),
        ("a station inside", Mesh::new(five.clone(), vec![0, 2, 5])),
        ("a station inside alone", Mesh::new(five.clone(), vec![3])),
        ("one segment between stations", Mesh::new(five.clone(), vec![0, 2, 3, 5])),
        ("stations everywhere", Mesh::new(five, vec![0, 1, 2, 3, 4, 5])),
        ("one segment, two stations", Mesh::new(vec![0.1], vec![0, 1])),
        ("one segment, one station", Mesh::new(vec![0.1], vec![1])),
        ("one segment, no station", Mesh::new(vec![0.1], vec![])),
        ("fine spans of alike and of uneven segments", Mesh::new(long, vec![0, 6, 13])),
        ("a fine span without stations", Mesh::new(vec![0.1; 7], vec![])),
    ]
}

/// Every mesh in a gentle, a wild and a nearly folded shape and one with edges against their frames, straight or curved
/// at rest, with extra curvature and free strain or without, in increments that take time or none.
fn cases(factory: &Factory<'_>) -> Vec<Case> {
    let mut rng = Rng::with_seed(1);
    let mut all = Vec::new();
    for (mesh_name, mesh) in meshes() {
        for (shape_name, turn, strain, rest) in [
            ("gentle", 0.2, 0.02, Vector::zeros()),
            ("wild", 1.8, 0.3, Vector::new(2.0, -1.5, 3.0)),
            ("turns near half a turn", 3.05, 0.1, Vector::zeros()),
            (OVERTURNED, 0.3, 0.1, Vector::zeros()),
        ] {
            let spec = spec(&mesh, rest);
            let rod = factory(spec.clone());
            let mut shape = random_shape(rod.as_ref(), &mesh, turn, strain, &mut rng);
            if shape_name == OVERTURNED {
                let edges: Vec<Vector> = (0..mesh.segments()).map(|j| shape.view().edge(j)).collect();
                for (j, edge) in edges.iter().enumerate() {
                    shape.points[j + 1] = shape.points[j] + edge * if j % 2 == 0 { -0.8 } else { 1.0 };
                }
            }
            if shape_name == "wild" {
                shape.free_strain = 0.07;
                shape.duration = 0.7;
                shape.extra = mesh.coupling_lengths.iter().map(|_| random_vector(&mut rng, 1.0)).collect();
                let moved = mesh.rest_lengths.iter().map(|l| l * (1.0 + 0.4 * (uniform(&mut rng) - 0.5))).collect();
                shape = shape.with_lengths(&mesh, moved);
            }
            let past = remember(rod.as_ref(), &mut shape, turn, &mut rng);
            all.push(Case { name: format!("{mesh_name}, {shape_name}"), spec, rod, shape, past });
        }
    }
    all
}

/// Turns by `turn` (rad) from the rest shape between all neighbouring frames, strains of about `strain`.
fn random_shape(rod: &dyn RodSegment, mesh: &Mesh, turn: f64, strain: f64, rng: &mut Rng) -> Shape {
    let mut frames = vec![random_rotation(rng)];
    for c in 0..mesh.coupling_lengths.len() {
        // From no turn at all, so that the angle is the one asked for where the rod is straight at rest.
        frames.push(frames[c] * rod.rest_rotation(c) * random_turn(rng, turn));
    }
    frames.truncate(mesh.frames());
    let mut points = vec![random_vector(rng, 0.5)];
    for (j, l) in mesh.rest_lengths.iter().enumerate() {
        let v = Vector::z() + random_vector(rng, strain);
        points.push(points[j] + frames[mesh.segment_frames[j]] * v * *l);
    }
    Shape {
        compensation: vec![Vector::zeros(); points.len()],
        points,
        frames,
        free_strain: 0.0,
        extra: Vec::new(),
        rest_lengths: mesh.rest_lengths.clone(),
        memory: rod.memory(),
        duration: 0.0,
        coupling_lengths: mesh.coupling_lengths.clone(),
    }
}

/// Gives a rod that remembers a past of two increments, such that no law changes its branch near the shape (where its
/// second derivatives may jump): from it an increment that ends anywhere near changes the same state variables. Returns
/// the frames of the past.
///
/// # Panics
/// If no such past is found.
fn remember(rod: &dyn RodSegment, shape: &mut Shape, turn: f64, rng: &mut Rng) -> Vec<Vec<Rotation>> {
    let initial = rod.memory();
    if initial.is_empty() {
        return Vec::new();
    }
    let changed = |shape: &Shape| -> Vec<bool> {
        shape.memory.iter().zip(shape.committed(rod)).map(|(before, after)| *before != after).collect()
    };
    for _ in 0..10_000 {
        let past: Vec<Vec<Rotation>> = (0..2)
            .map(|_| {
                let turned = |q: &Rotation| {
                    let angle = turn * uniform(rng);
                    q * random_turn(rng, angle)
                };
                shape.frames.iter().map(turned).collect()
            })
            .collect();
        shape.memory = initial.clone();
        for frames in &past {
            shape.memory = Shape { frames: frames.clone(), ..shape.clone() }.committed(rod);
        }
        let here = changed(shape);
        let frames = 3 * shape.points.len()..shape.size();
        let steps = frames.flat_map(|i| [-4.0 * STEP, 4.0 * STEP].map(|h| shape.moved(&unit(shape, i), h)));
        let lengths = (0..shape.coupling_lengths.len()).flat_map(|c| {
            [-0.4 * STEP, 0.4 * STEP].map(|h| {
                let mut near = shape.clone();
                near.coupling_lengths[c] += h;
                near
            })
        });
        if steps.chain(lengths).all(|near| changed(&near) == here) {
            return past;
        }
    }
    panic!("no past found from which nothing changes its branch near a shape")
}

/// The energy and the gradient `(∂E/∂x_0, …, ∂E/∂θ_0, …)`; rooms are handed over full of NaN.
fn gradient(rod: &dyn RodSegment, shape: &Shape) -> (f64, DVector<f64>) {
    let nan = Vector::repeat(f64::NAN);
    let (mut points, mut frames) = (vec![nan; shape.points.len()], vec![nan; shape.frames.len()]);
    let mut energy = rod.coupling_gradient(&shape.view(), &mut frames);
    energy += rod.segment_gradient(&shape.view(), &mut points, &mut frames);
    (energy, flat(points.iter().chain(&frames)))
}

fn forces(rod: &dyn RodSegment, shape: &Shape) -> Vec<Vector> {
    let mut forces = vec![Vector::repeat(f64::NAN); rod.mesh().segments()];
    rod.forces(&shape.view(), &mut forces);
    forces
}

fn moments(rod: &dyn RodSegment, shape: &Shape) -> Vec<Vector> {
    let mut moments = vec![Vector::repeat(f64::NAN); rod.mesh().coupling_lengths.len()];
    rod.moments(&shape.view(), &mut moments);
    moments
}

/// `C (Γ + δΓ)` for the step in this direction.
fn predicted(rod: &dyn RodSegment, shape: &Shape, direction: &DVector<f64>) -> Vec<Vector> {
    let vectors: Vec<Vector> = direction.as_slice().chunks(3).map(Vector::from_column_slice).collect();
    let (points, frames) = vectors.split_at(shape.points.len());
    let mut forces = vec![Vector::repeat(f64::NAN); rod.mesh().segments()];
    rod.predicted_forces(&shape.view(), points, frames, &mut forces);
    forces
}

/// Adds a block, and its transpose across the diagonal where it is off it.
fn add(dense: &mut DMatrix<f64>, row: usize, column: usize, block: &Matrix) {
    let mut view = dense.fixed_view_mut::<3, 3>(3 * row, 3 * column);
    view += block;
    if row != column {
        let mut view = dense.fixed_view_mut::<3, 3>(3 * column, 3 * row);
        view += block.transpose();
    }
}

/// The second derivatives of a branch in the order of [`gradient`]; rooms are handed over full of NaN.
fn hessian(rod: &dyn RodSegment, shape: &Shape, forces: Option<&[Vector]>) -> DMatrix<f64> {
    let mesh = rod.mesh();
    let mut parts = BranchHessian::new(rod);
    let nan = Matrix::repeat(f64::NAN);
    for h in &mut parts.segments {
        (h.ee, h.te, h.tt) = (nan, nan, nan);
    }
    for h in &mut parts.couplings {
        (h.aa, h.ab, h.bb) = (nan, nan, nan);
    }
    parts.pairs.fill(nan);
    rod.hessian(&shape.view(), forces, &mut parts);
    let mut dense = DMatrix::zeros(shape.size(), shape.size());
    let frame = |c: usize| mesh.nodes() + c;
    for (j, h) in parts.segments.iter().enumerate() {
        // e = x_{j+1} − x_j
        let f = frame(mesh.segment_frames[j]);
        add(&mut dense, j, j, &h.ee);
        add(&mut dense, j + 1, j + 1, &h.ee);
        add(&mut dense, j + 1, j, &-h.ee);
        add(&mut dense, f, j + 1, &h.te);
        add(&mut dense, f, j, &-h.te);
        add(&mut dense, f, f, &h.tt);
    }
    for (c, h) in parts.couplings.iter().enumerate() {
        add(&mut dense, frame(c), frame(c), &h.aa);
        add(&mut dense, frame(c), frame(c + 1), &h.ab);
        add(&mut dense, frame(c + 1), frame(c + 1), &h.bb);
    }
    for (beside, h) in mesh.beside.iter().zip(&parts.beside) {
        let j = beside.segment;
        for (k, frame_beside) in beside.neighbours().iter().enumerate() {
            if let Some(c) = frame_beside {
                add(&mut dense, frame(*c), j + 1, &h.se[k]);
                add(&mut dense, frame(*c), j, &-h.se[k]);
                add(&mut dense, frame(*c), frame(mesh.segment_frames[j]), &h.st[k]);
                add(&mut dense, frame(*c), frame(*c), &h.ss[k]);
            }
        }
        if let [Some(first), Some(second)] = beside.neighbours() {
            add(&mut dense, frame(second), frame(first), &h.s1s0);
        }
    }
    for (pair, h) in mesh.pairs.iter().zip(&parts.pairs) {
        add(&mut dense, frame(pair.frame - 1), frame(pair.frame + 1), h);
    }
    dense
}

/// Unit direction i, with positions measured in tenths of a metre so that all entries are of one size.
fn unit(shape: &Shape, i: usize) -> DVector<f64> {
    let mut direction = DVector::zeros(shape.size());
    direction[i] = if i < 3 * shape.points.len() { 0.1 } else { 1.0 };
    direction
}

fn random_direction_of(shape: &Shape, rng: &mut Rng) -> DVector<f64> {
    DVector::from_fn(shape.size(), |i, _| uniform(rng) * unit(shape, i)[i])
}

/// # Panics
/// If the mesh is not the one of the specification.
pub fn keeps_the_mesh_it_was_built_for(factory: &Factory<'_>) {
    for case in cases(factory) {
        assert_eq!(case.rod.mesh(), &case.spec.mesh, "{}", case.name);
    }
}

/// # Panics
/// If the gradient is not what differences of the energy say.
pub fn gradient_is_the_derivative_of_the_energy(factory: &Factory<'_>) {
    for Case { name, rod, shape, .. } in cases(factory) {
        let rod = rod.as_ref();
        let energy = |s: &Shape| rod.energy(&s.view()).total();
        let (_, got) = gradient(rod, &shape);
        let scale = DVector::from_fn(shape.size(), |i, _| unit(&shape, i)[i]);
        let got = got.component_mul(&scale);
        let want =
            DVector::from_fn(shape.size(), |i, _| derivative(STEP, |h| energy(&shape.moved(&unit(&shape, i), h))));
        assert_all_near(&name, &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If the Hessian is not the symmetric part of the derivative of the gradient: what `E(q ∘ exp θ)` has for second
/// derivatives. (Away from equilibrium the derivative of a body gradient is not symmetric.)
pub fn hessian_is_the_second_derivative_of_the_energy(factory: &Factory<'_>) {
    for Case { name, rod, shape, .. } in cases(factory) {
        let rod = rod.as_ref();
        let n = shape.size();
        let scale = DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| unit(&shape, i)[i]));
        let got = &scale * hessian(rod, &shape, None) * &scale;
        let columns: Vec<_> = (0..n)
            .map(|i| &scale * derivative_of_all(STEP, |h| gradient(rod, &shape.moved(&unit(&shape, i), h)).1))
            .collect();
        let want = symmetric(&DMatrix::from_columns(&columns));
        assert_matrix_near(&name, &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// Whether it says no law of stretch.
fn is_linear_in_edges(rod: &dyn RodSegment) -> bool {
    rod.constitutive().is_none_or(|laws| laws.stretch.is_none()) && rod.law().is_none_or(|law| law.laws.axial.is_none())
}

/// # Panics
/// If the stiffness of the edges is not the one in the Hessian, or, without a law of stretch, depends on the points
/// where no edge is overturned by that.
pub fn edge_stiffness_is_that_of_the_hessian_wherever_the_points_are(factory: &Factory<'_>) {
    let mut rng = Rng::with_seed(12);
    for Case { name, rod, shape, .. } in cases(factory) {
        let mut parts = BranchHessian::new(rod.as_ref());
        rod.hessian(&shape.view(), None, &mut parts);
        let mut elsewhere = shape.clone();
        elsewhere.points.iter_mut().for_each(|x| *x += Vector::from_fn(|_, _| 0.01 * uniform(&mut rng)));
        let mut stiffness = vec![Matrix::repeat(f64::NAN); rod.mesh().segments()];
        rod.edge_stiffness(&elsewhere.view(), &mut stiffness);
        let near = |stiffness: &[Matrix]| {
            for (got, h) in stiffness.iter().zip(&parts.segments) {
                assert!((got - h.ee).norm() <= 1e-12 * h.ee.norm(), "{name}: {got} N/m instead of {}", h.ee);
            }
        };
        if is_linear_in_edges(rod.as_ref()) {
            near(&stiffness);
        }
        rod.edge_stiffness(&shape.view(), &mut stiffness);
        near(&stiffness);
    }
}

/// # Panics
/// If what the rod says of its lengths is not the derivative of its energy and gradient in them: of each length alone,
/// and of all at random rates.
pub fn length_terms_are_derivatives_in_the_lengths(factory: &Factory<'_>) {
    let mut rng = Rng::with_seed(11);
    for Case { name, spec, rod, shape, .. } in cases(factory) {
        let (rod, mesh) = (rod.as_ref(), &spec.mesh);
        let (n, m) = (mesh.segments(), mesh.coupling_lengths.len());
        let terms = |shape: &Shape| {
            let (mut segments, mut couplings) = (vec![[f64::NAN; 2]; n], vec![[f64::NAN; 3]; m]);
            rod.length_terms(&shape.view(), &mut segments, &mut couplings);
            segments.into_iter().map(|[first, second]| [first, second, 0.0]).chain(couplings).collect::<Vec<_>>()
        };
        let stretched = |k: usize, h: f64| {
            let mut to = shape.clone();
            *to.rest_lengths.iter_mut().chain(&mut to.coupling_lengths).nth(k).expect("a length") += h;
            to
        };
        let energy = |shape: &Shape| rod.energy(&shape.view()).total();
        for (k, [first, second, mixed]) in terms(&shape).into_iter().enumerate() {
            let h = STEP * 0.05;
            let want = [derivative(h, |h| energy(&stretched(k, h))), derivative(h, |h| terms(&stretched(k, h))[k][0])];
            if k + 1 < n + m {
                let want = derivative(h, |h| terms(&stretched(k, h))[k + 1][0]);
                assert_near(&format!("{name}, mixed of {k}"), mixed, want, DIFFERENCES * (1.0 + want.abs()));
            }
            assert_near(&format!("{name}, ∂E of length {k}"), first, want[0], DIFFERENCES * (1.0 + want[0].abs()));
            assert_near(&format!("{name}, ∂²E of length {k}"), second, want[1], DIFFERENCES * (1.0 + want[1].abs()));
        }
        let segment_rates: Vec<f64> = (0..n).map(|_| uniform(&mut rng) - 0.5).collect();
        let coupling_rates: Vec<f64> = (0..m).map(|_| uniform(&mut rng) - 0.5).collect();
        let (mut points, mut frames) = (vec![Vector::zeros(); mesh.nodes()], vec![Vector::zeros(); mesh.frames()]);
        rod.length_mixed(&shape.view(), &segment_rates, &coupling_rates, &mut points, &mut frames);
        let got = flat(points.iter().chain(&frames));
        let want = derivative_of_all(STEP * 0.1, |h| {
            let mut to = shape.clone();
            let rates = segment_rates.iter().chain(&coupling_rates);
            for (l, rate) in to.rest_lengths.iter_mut().chain(&mut to.coupling_lengths).zip(rates) {
                *l += h * rate;
            }
            gradient(rod, &to).1
        });
        assert_all_near(&name, &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If the Hessian with the rod's own forces given differs from the one without.
pub fn own_forces_reproduce_the_hessian(factory: &Factory<'_>) {
    for Case { name, rod, shape, .. } in cases(factory) {
        let own = predicted(rod.as_ref(), &shape, &DVector::zeros(shape.size()));
        let want = hessian(rod.as_ref(), &shape, None);
        let got = hessian(rod.as_ref(), &shape, Some(&own));
        assert_matrix_near(&name, &got, &want, ROUND_OFF * (1.0 + want.amax()));
    }
}

/// # Panics
/// If `predicted_forces` is not the force before the step and its derivative along it.
pub fn predicted_forces_are_first_order_in_the_step(factory: &Factory<'_>) {
    let mut rng = Rng::with_seed(2);
    for Case { name, rod, shape, .. } in cases(factory) {
        let rod = rod.as_ref();
        let none = DVector::zeros(shape.size());
        let now = |s: &Shape| flat(&predicted(rod, s, &none));
        let step = random_direction_of(&shape, &mut rng);
        let got = flat(&predicted(rod, &shape, &step)) - now(&shape);
        let want = derivative_of_all(STEP, |h| now(&shape.moved(&step, h)));
        assert_all_near(&name, &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If a rigid motion changes the energy or the body moments, or does not turn the forces with it.
pub fn rigid_motion_changes_nothing(factory: &Factory<'_>) {
    let mut rng = Rng::with_seed(3);
    for Case { name, rod, shape, .. } in cases(factory) {
        let (turn, shift) = (random_rotation(&mut rng), random_vector(&mut rng, 2.0));
        let mut moved = shape.clone();
        moved.points.iter_mut().for_each(|x| *x = turn * *x + shift);
        moved.frames.iter_mut().for_each(|q| *q = turn * *q);
        let (energy, mut want) = gradient(rod.as_ref(), &shape);
        let (got_energy, got) = gradient(rod.as_ref(), &moved);
        for force in want.as_mut_slice().chunks_mut(3).take(shape.points.len()) {
            let turned = turn * Vector::from_column_slice(force);
            force.copy_from_slice(turned.as_slice());
        }
        assert_near(&name, got_energy, energy, ROUND_OFF * (1.0 + energy));
        assert_all_near(&name, &got, &want, 10.0 * ROUND_OFF * (1.0 + want.amax()));
    }
}

/// # Panics
/// If `−q` for `q`, which is the same frame, changes energy, gradient or second derivatives.
pub fn the_sign_of_a_quaternion_does_not_matter(factory: &Factory<'_>) {
    for Case { name, rod, shape, .. } in cases(factory) {
        let (energy, want) = gradient(rod.as_ref(), &shape);
        let want_hessian = hessian(rod.as_ref(), &shape, None);
        for c in 0..shape.frames.len() {
            let mut other = shape.clone();
            other.frames[c] = negated(&shape.frames[c]);
            let name = format!("{name}, frame {c}");
            let (got_energy, got) = gradient(rod.as_ref(), &other);
            assert_near(&name, got_energy, energy, ROUND_OFF * (1.0 + energy));
            assert_all_near(&name, &got, &want, ROUND_OFF * (1.0 + want.amax()));
            let got_hessian = hessian(rod.as_ref(), &other, None);
            assert_matrix_near(&name, &got_hessian, &want_hessian, ROUND_OFF * (1.0 + want_hessian.amax()));
        }
    }
}

/// # Panics
/// If forces, or moments about the origin (`Σ x × f + R g_θ`), do not cancel.
pub fn inner_forces_and_moments_sum_to_zero(factory: &Factory<'_>) {
    for Case { name, rod, shape, .. } in cases(factory) {
        let (_, g) = gradient(rod.as_ref(), &shape);
        let (mut force, mut moment) = (Vector::zeros(), Vector::zeros());
        for (i, f) in g.as_slice().chunks(3).map(Vector::from_column_slice).enumerate() {
            match i.checked_sub(shape.points.len()) {
                None => {
                    force += f;
                    moment += shape.points[i].cross(&f);
                }
                Some(c) => moment += shape.frames[c] * f,
            }
        }
        assert_near(&format!("{name}: force"), force.norm(), 0.0, ROUND_OFF * (1.0 + g.amax()));
        assert_near(&format!("{name}: moment"), moment.norm(), 0.0, ROUND_OFF * (1.0 + g.amax()));
    }
}

/// # Panics
/// If the branch run from its other end (frames half a turn about d1, curvature `[−κ1, κ2, κ3]`), with the same past,
/// has another energy or gradient.
pub fn running_the_branch_from_its_other_end_changes_nothing(factory: &Factory<'_>) {
    is_the_same_from_its_other_end(factory, factory);
}

/// # Panics
/// If the rods of another factory, run from the other end (frames half a turn about d1, curvature `[−κ1, κ2, κ3]`),
/// with the same past, have another energy or gradient.
pub fn is_the_same_from_its_other_end(factory: &Factory<'_>, reversing: &Factory<'_>) {
    for Case { name, spec, rod, shape, past } in cases(factory) {
        let n = spec.mesh.segments();
        let reversed = reversing(RodSpec {
            name: spec.name,
            mesh: Mesh::new(
                spec.mesh.rest_lengths.iter().rev().copied().collect(),
                spec.mesh.stations.iter().rev().map(|k| n - k).collect(),
            ),
            curvature: reversed_curvature(&spec.curvature),
            sections: spec.sections,
        });
        let (energy, want) = gradient(rod.as_ref(), &shape);
        let mut back = Shape { memory: reversed.memory(), ..shape.reversed() };
        for frames in past {
            let before = Shape { frames, ..shape.clone() }.reversed();
            back.memory = Shape { memory: back.memory, ..before }.committed(reversed.as_ref());
        }
        let (got_energy, got) = gradient(reversed.as_ref(), &back);
        let vectors: Vec<Vector> = got.as_slice().chunks(3).map(Vector::from_column_slice).collect();
        let (points, frames) = vectors.split_at(shape.points.len());
        let back: Vec<Vector> = points.iter().rev().copied().chain(frames.iter().rev().map(half_turned)).collect();
        assert_near(&name, got_energy, energy, ROUND_OFF * (1.0 + energy));
        assert_all_near(&name, &flat(&back), &want, ROUND_OFF * (1.0 + want.amax()));
    }
}

/// # Panics
/// If frames laid by `rest_rotation`, with nodes placed so that no segment bears a force, have an energy or a
/// gradient.
pub fn rest_shape_has_no_energy_and_no_gradient(factory: &Factory<'_>) {
    let mut rng = Rng::with_seed(4);
    for (name, mesh) in meshes() {
        for curvature in [Vector::zeros(), Vector::new(1.5, -2.0, 2.5)] {
            let rod = factory(spec(&mesh, curvature));
            let mut shape = random_shape(rod.as_ref(), &mesh, 0.0, 0.0, &mut rng);
            // The energy is convex in an edge: Newton.
            for _ in 0..4 {
                let forces = forces(rod.as_ref(), &shape);
                let mut parts = BranchHessian::new(rod.as_ref());
                rod.hessian(&shape.view(), None, &mut parts);
                let mut shift = Vector::zeros();
                for (j, (force, h)) in forces.iter().zip(&parts.segments).enumerate() {
                    shift -= h.ee.lu().solve(force).expect("stiff in every direction");
                    shape.points[j + 1] += shift;
                }
            }
            let (energy, g) = gradient(rod.as_ref(), &shape);
            assert_near(&format!("{name}: energy"), energy, 0.0, 1e-22);
            assert_near(&format!("{name}: gradient"), g.amax(), 0.0, 1e-11);
        }
    }
}

/// # Panics
/// If a branch with a station inside has not the bending and twisting energy of the two branches that meet there. (What
/// stations do to stretch and shear is of second order in the segments, and may differ at ends.)
pub fn bending_of_a_branch_cut_at_a_station_is_the_sum_of_its_parts(factory: &Factory<'_>) {
    let bending = |energy: RodEnergy| energy.bend + energy.twist;
    for Case { name, spec, rod, shape, .. } in cases(factory) {
        let mesh = &spec.mesh;
        let width = shape.memory.len() / mesh.coupling_lengths.len().max(1);
        for (&node, &c) in mesh.stations.iter().zip(&mesh.station_frames) {
            if node == 0 || node == mesh.segments() {
                continue;
            }
            let lower = |k: &usize| *k <= node;
            let part = |lengths: &[f64], stations: Vec<usize>, shape: Shape| {
                let mesh = Mesh::new(lengths.to_vec(), stations);
                bending(factory(RodSpec { mesh, ..spec.clone() }).energy(&shape.view()))
            };
            let (one, other) = mesh.rest_lengths.split_at(node);
            let slice = |points: std::ops::Range<usize>, frames: std::ops::Range<usize>| Shape {
                points: shape.points[points.clone()].to_vec(),
                rest_lengths: shape.rest_lengths[points.start..points.end - 1].to_vec(),
                coupling_lengths: shape.coupling_lengths[frames.start..frames.end - 1].to_vec(),
                compensation: shape.compensation[points].to_vec(),
                free_strain: shape.free_strain,
                extra: shape.extra.get(frames.start..frames.end - 1).unwrap_or_default().to_vec(),
                memory: shape.memory[width * frames.start..width * (frames.end - 1)].to_vec(),
                duration: shape.duration,
                frames: shape.frames[frames].to_vec(),
            };
            let first = part(one, mesh.stations.iter().copied().filter(lower).collect(), slice(0..node + 1, 0..c + 1));
            let second = part(
                other,
                mesh.stations.iter().filter(|k| **k >= node).map(|k| k - node).collect(),
                slice(node..mesh.nodes(), c..mesh.frames()),
            );
            let whole = bending(rod.energy(&shape.view()));
            assert_near(&format!("{name}, cut at {node}"), first + second, whole, ROUND_OFF * (1.0 + whole));
        }
    }
}

/// # Panics
/// If an effect has a negative energy, or all of them are not what `gradient` returns.
pub fn energies_by_effect_are_not_negative_and_add_up(factory: &Factory<'_>) {
    for Case { name, rod, shape, .. } in cases(factory) {
        let energy = rod.energy(&shape.view());
        for effect in [energy.stretch, energy.shear, energy.bend, energy.twist] {
            assert!(effect >= 0.0, "{name}: {energy:?}");
        }
        let total = energy.total();
        assert_near(&name, gradient(rod.as_ref(), &shape).0, total, ROUND_OFF * (1.0 + total));
    }
}

/// # Panics
/// If it says a law ([`RodSegment::law`]) of another energy.
pub fn a_law_it_says_has_its_energy(factory: &Factory<'_>) {
    for Case { name, spec, rod, shape, .. } in cases(factory) {
        let Some(law) = rod.law() else { continue };
        let (got, energy) = (rod_energy(&law, &spec.mesh, &shape.view()), rod.energy(&shape.view()).total());
        assert_near(&name, got, energy, ROUND_OFF * (1.0 + energy));
    }
}

/// # Panics
/// If `∂E/∂x_i ≠ n_{i−1} − n_i`, or if the world moments on all frames before a coupling differ from
/// `−m_c + Σ n_j × e_j` over the segments before it.
pub fn forces_and_moments_agree_with_the_gradient(factory: &Factory<'_>) {
    for Case { name, rod, shape, .. } in cases(factory) {
        let mesh = rod.mesh();
        let (_, g) = gradient(rod.as_ref(), &shape);
        let g: Vec<Vector> = g.as_slice().chunks(3).map(Vector::from_column_slice).collect();
        let (n, m) = (forces(rod.as_ref(), &shape), moments(rod.as_ref(), &shape));
        let want: Vec<Vector> = (0..mesh.nodes())
            .map(|i| {
                let before = if i > 0 { n[i - 1] } else { Vector::zeros() };
                before - n.get(i).copied().unwrap_or_default()
            })
            .collect();
        let tolerance = ROUND_OFF * (1.0 + flat(&g).amax());
        assert_all_near(&format!("{name}: forces"), &flat(&g[..mesh.nodes()]), &flat(&want), tolerance);
        let mut sum = Vector::zeros();
        for c in 0..mesh.frames() {
            sum += shape.frames[c] * g[mesh.nodes() + c];
            if let Ok(j) = mesh.segment_frames.binary_search(&c) {
                sum -= n[j].cross(&shape.view().edge(j));
            }
            if let Some(m) = m.get(c) {
                assert_near(&format!("{name}: moment at coupling {c}"), (sum + m).norm(), 0.0, 10.0 * tolerance);
            }
        }
        assert_near(&format!("{name}: all moments"), sum.norm(), 0.0, 10.0 * tolerance);
    }
}

/// # Panics
/// If positions split into `points + compensation` give another energy or gradient than whole ones.
pub fn low_order_parts_of_positions_count(factory: &Factory<'_>) {
    for Case { name, rod, shape, .. } in cases(factory) {
        let mut split = shape.clone();
        for (x, compensation) in split.points.iter_mut().zip(&mut split.compensation) {
            let high = x.map(|a| f64::from(a as f32));
            *compensation = *x - high;
            *x = high;
        }
        let (energy, want) = gradient(rod.as_ref(), &shape);
        let (got_energy, got) = gradient(rod.as_ref(), &split);
        assert_near(&name, got_energy, energy, ROUND_OFF * (1.0 + energy));
        assert_all_near(&name, &got, &want, ROUND_OFF * (1.0 + want.amax()));
    }
}

/// # Panics
/// If the same extra curvature everywhere does not do what that much more rest curvature does.
pub fn extra_curvature_shifts_the_rest_curvature(factory: &Factory<'_>) {
    let extra = Vector::new(0.7, -0.4, 1.1);
    for Case { name, spec, rod, mut shape, .. } in cases(factory) {
        shape.extra.clear();
        let curved = factory(RodSpec { curvature: spec.curvature + extra, ..spec });
        let (energy, want) = gradient(curved.as_ref(), &shape);
        let want_hessian = hessian(curved.as_ref(), &shape, None);
        shape.extra = vec![extra; rod.mesh().coupling_lengths.len()];
        let (got_energy, got) = gradient(rod.as_ref(), &shape);
        assert_near(&name, got_energy, energy, ROUND_OFF * (1.0 + energy));
        assert_all_near(&name, &got, &want, ROUND_OFF * (1.0 + want.amax()));
        let got_hessian = hessian(rod.as_ref(), &shape, None);
        assert_matrix_near(&name, &got_hessian, &want_hessian, ROUND_OFF * (1.0 + want_hessian.amax()));
    }
}

/// # Panics
/// If a straight rod that is stretched by its free strain has an energy or a gradient.
pub fn free_strain_stretches_the_rest_shape(factory: &Factory<'_>) {
    let mut rng = Rng::with_seed(6);
    for (name, mesh) in meshes() {
        let rod = factory(spec(&mesh, Vector::zeros()));
        for free_strain in [-0.02, 0.03] {
            let mut shape = random_shape(rod.as_ref(), &mesh, 0.0, 0.0, &mut rng);
            shape.free_strain = free_strain;
            let start = shape.points[0];
            shape.points.iter_mut().for_each(|x| *x = start + (*x - start) * (1.0 + free_strain));
            let (energy, g) = gradient(rod.as_ref(), &shape);
            assert_near(&format!("{name}: energy"), energy, 0.0, 1e-22);
            assert_near(&format!("{name}: gradient"), g.amax(), 0.0, 1e-11);
        }
    }
}

/// # Panics
/// If a node or frame that is not finite gives finite energies, gradients or second derivatives.
pub fn non_finite_input_gives_non_finite_output(factory: &Factory<'_>) {
    let check = |name: &str, rod: &dyn RodSegment, bad: &Shape| {
        assert!(!rod.energy(&bad.view()).total().is_finite(), "{name}: energy");
        let (energy, g) = gradient(rod, bad);
        assert!(!energy.is_finite(), "{name}: energy of the gradient");
        assert!(g.iter().any(|x| !x.is_finite()), "{name}: gradient");
    };
    for Case { name, rod, shape, .. } in cases(factory) {
        for value in [f64::NAN, f64::INFINITY] {
            let mut bad = shape.clone();
            bad.points[0].y = value;
            check(&name, rod.as_ref(), &bad);
        }
        for c in 0..shape.frames.len() {
            let mut bad = shape.clone();
            bad.frames[c].as_mut_unchecked().coords.x = f64::NAN;
            check(&name, rod.as_ref(), &bad);
            assert!(hessian(rod.as_ref(), &bad, None).iter().any(|x| !x.is_finite()), "{name}: hessian");
        }
    }
}

/// # Panics
/// If two rods of one specification, or two calls, give different bits.
pub fn same_input_gives_same_bits(factory: &Factory<'_>) {
    let bits = |v: &DVector<f64>| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for Case { name, spec, rod, shape, .. } in cases(factory) {
        let other = factory(spec);
        let (energy, first) = gradient(rod.as_ref(), &shape);
        for rod in [rod.as_ref(), other.as_ref()] {
            let (again, second) = gradient(rod, &shape);
            assert_eq!((energy.to_bits(), bits(&first)), (again.to_bits(), bits(&second)), "{name}");
        }
    }
}

/// # Panics
/// If an increment dissipates energy less than 0, if committing it again, without further time, changes a bit of the
/// memory or dissipates again, if it changes forces or moments by more than round-off, or if the memory is not as long
/// as it was.
pub fn memory_is_committed_once(factory: &Factory<'_>) {
    for Case { name, rod, mut shape, .. } in cases(factory) {
        let rod = rod.as_ref();
        assert_eq!(rod.memory().len() % shape.coupling_lengths.len().max(1), 0, "{name}: the same for each coupling");
        let (_, want) = gradient(rod, &shape);
        let (before, timeless) = (rod.energy(&shape.view()).total(), shape.duration == 0.0);
        let mut memory = shape.memory.clone();
        let dissipated = rod.commit(&shape.view(), &mut memory);
        assert!(dissipated >= 0.0, "{name}: {dissipated} J dissipated");
        assert_eq!(memory.len(), rod.memory().len(), "{name}");
        shape.memory = memory.clone();
        shape.duration = 0.0;
        let (_, got) = gradient(rod, &shape);
        assert_all_near(&name, &got, &want, ROUND_OFF * (1.0 + want.amax()));
        // What was minimised is stored or dissipated, where no time passes.
        let stored = rod.energy(&shape.view()).total();
        if timeless {
            assert_near(&name, stored + dissipated, before, ROUND_OFF * (1.0 + before));
        }
        let again = rod.commit(&shape.view(), &mut memory);
        assert_eq!((again, memory), (0.0, shape.memory), "{name}: committed twice");
    }
}
