//! Conformance suite of the minimiser `newton`, and tests of the linear system, the certificate and static
//! condensation.

use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;
use wireloom_core::conditions::Conditions;
use wireloom_core::constraint::{ConstraintSpec, Limits};
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::network::{ConstraintPlan, NodeRange, Place};
use wireloom_core::obstacle::{Obstacle, Shape, Surface, Touch};
use wireloom_core::problem::Hessian;
use wireloom_core::status::Status;
use wireloom_core::variable::Variable;
use wireloom_core::{
    Action, Constraint, ConstraintView, Matrix, Network, Parameters, Pose, Potential, Problem, Registry, State,
    Tangent, Value, Vector,
};
use wireloom_solve::contact::multipliers::{ContactHistory, update_constraints, update_contacts};
use wireloom_solve::linear::assembly::Assembly;
use wireloom_solve::linear::matrix::BlockMatrix;
use wireloom_solve::linear::symbolic::Structure;
use wireloom_solve::minimisers::condensation::Condensation;
use wireloom_solve::minimisers::newton::Newton;
use wireloom_solve::report::result::branch;
use wireloom_solve::steps::certificate::Certifier;
use wireloom_testkit::conformance::networks::{Sample, Sketch, cable, cut_cable, ring, sized_y_harness, y_harness};
use wireloom_testkit::conformance::numeric::{
    assert_matrix_near, random_rotation, random_turn, random_vector, symmetric,
};
use wireloom_testkit::constraints::{Link, Sight, Strut};
use wireloom_testkit::minimiser_conformance;

fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    registry
}

minimiser_conformance!(newton, || Box::new(Newton::new()), registry);

/// Equilibrium with the far end of the cable moved in, to the limit of round-off, and its energy (J).
fn hung(sample: &Sample) -> (State, f64) {
    let mut problem = sample.problem();
    let mut state = sample.state.clone();
    let mut newton = Newton::new();
    for x in [0.95, 0.9, 0.85, 0.8] {
        let mut target = sample.conditions.targets[1];
        target.position = Vector::new(x, 0.02, 0.05);
        problem.set_target(1, target);
        newton.minimise(&mut problem, &mut state, &Stop { force_tolerance: 1e-12, max_iterations: 100 });
    }
    let energy = problem.energy(&state).total();
    (state, energy)
}

/// Largest distance between the nodes of one branch and those of its two halves.
fn apart(whole: &Sample, a: &State, halves: &Sample, b: &State) -> f64 {
    let nodes = |sample: &Sample, state: &State| -> Vec<Vector> {
        let branches = &sample.network.branches;
        let skip = |i: usize| usize::from(i > 0);
        branches.iter().enumerate().flat_map(|(i, b)| state.points[b.points.clone()][skip(i)..].to_vec()).collect()
    };
    nodes(whole, a).iter().zip(&nodes(halves, b)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn a_two_arm_joint_with_all_wires_running_through_is_the_plain_rod() {
    let registry = registry();
    let (whole, halves) = (cable(&registry, 40), cut_cable(&registry, "cosserat", 40));
    let ((a, energy_a), (b, energy_b)) = (hung(&whole), hung(&halves));
    assert!((energy_a - energy_b).abs() <= 1e-12 * energy_a.abs(), "{energy_a:e} J and {energy_b:e} J");
    let apart = apart(&whole, &a, &halves, &b);
    assert!(apart <= 1e-12, "{apart:e} m apart");
}

#[test]
fn a_fused_two_arm_joint_changes_the_shape_to_second_order_only() {
    let registry = registry();
    let distances = [20, 40, 80].map(|n| {
        let (whole, halves) = (cable(&registry, n), cut_cable(&registry, "fused", n));
        apart(&whole, &hung(&whole).0, &halves, &hung(&halves).0)
    });
    assert!(distances[0] < 2e-3, "{distances:?}");
    for pair in distances.windows(2) {
        assert!(pair[1] < 0.4 * pair[0], "{distances:?}");
    }
}

#[test]
fn a_ring_is_the_same_wherever_a_through_joint_closes_it() {
    // The last side in one piece and in two, joined so that all wires run through.
    let registry = registry();
    let solved = [1, 2].map(|cut| {
        let sample = ring(&registry, "cosserat", 12, cut);
        let mut state = sample.state.clone();
        let stop = Stop { force_tolerance: 1e-9, max_iterations: 200 };
        let report = Newton::new().minimise(&mut sample.problem(), &mut state, &stop);
        assert_eq!(report.status, Status::Converged, "{report:?}");
        (sample, state)
    });
    for corner in 0..3 {
        let [one, two] = [0, 1].map(|k| solved[k].1.points[solved[k].0.network.joints[corner].point]);
        assert!((one - two).norm() < 1e-8, "corner {corner}: {one} and {two}");
    }
}

#[test]
fn a_false_claim_of_convergence_does_not_pass() {
    let sample = cable(&registry(), 20);
    let mut problem = sample.problem();
    let stop = Stop::default();
    let mut certifier = Certifier::new(&sample.network);
    let mut claim = |problem: &mut Problem<'_>, state: &State| {
        let certificate = certifier.certify(problem, state, &stop, Status::Converged);
        (certificate.status, certificate.residual, certificate.violation)
    };
    // No force balances the weight of a straight cable.
    let (status, residual, violation) = claim(&mut problem, &sample.state);
    assert!(status == Status::Failed && residual > stop.force_tolerance && violation == 0.0, "{status:?} {residual:e}");
    let mut state = sample.state.clone();
    Newton::new().minimise(&mut problem, &mut state, &stop);
    assert_eq!(claim(&mut problem, &state).0, Status::Converged);
    // In balance, but off its target.
    let mut target = sample.conditions.targets[1];
    target.position.x += 1e-6;
    problem.set_target(1, target);
    let (status, residual, violation) = claim(&mut problem, &state);
    assert!(
        status == Status::Failed && residual <= stop.force_tolerance && violation > 5e-7,
        "{status:?} {residual:e}"
    );
    problem.set_target(1, sample.conditions.targets[1]);
    state.points[9].y = f64::NAN;
    assert_eq!(claim(&mut problem, &state).0, Status::Failed);
}

/// Number of pairs of variables coupled by an energy: non-zero blocks of the Hessian below its diagonal.
fn coupled_pairs(network: &Network, structure: &Structure) -> usize {
    let tie = |point: usize| network.ties.iter().find(|t| t.point == point);
    let point = |i: usize| -> Vec<Variable> {
        match tie(i) {
            None => vec![Variable::Point(i)],
            Some(t) => [Variable::Point(t.hub_point)].into_iter().chain(t.hub_frame.map(Variable::Frame)).collect(),
        }
    };
    let frame = |c: usize| -> Variable {
        let tied = network.ties.iter().find(|t| t.frame == Some(c));
        Variable::Frame(tied.and_then(|t| t.hub_frame).unwrap_or(c))
    };
    let mut cliques: Vec<Vec<Variable>> = Vec::new();
    for branch in &network.branches {
        let mesh = branch.rod.mesh();
        let (x, q) = (branch.points.start, branch.frames.start);
        for (j, f) in mesh.segment_frames.iter().enumerate() {
            let mut clique = [point(x + j), point(x + j + 1), vec![frame(q + f)]].concat();
            let beside = mesh.beside.iter().filter(|b| b.segment == j).flat_map(|b| b.stations).flatten();
            clique.extend(beside.map(|c| frame(q + c)));
            cliques.push(clique);
        }
        cliques.extend((1..mesh.frames()).map(|c| vec![frame(q + c - 1), frame(q + c)]));
    }
    cliques.extend(network.joints.iter().map(|j| j.arm_frames.iter().map(|&c| frame(c)).collect()));
    let mut pairs = BTreeSet::new();
    for clique in cliques {
        let places: BTreeSet<u32> = clique.into_iter().filter_map(|v| structure.position(v)).collect();
        pairs.extend(places.iter().flat_map(|&a| places.iter().filter(move |&&b| a < b).map(move |&b| (a, b))));
    }
    pairs.len()
}

#[test]
fn a_cable_is_factorised_without_fill() {
    let sample = cable(&registry(), 50);
    let structure = Structure::new(&sample.network, &[]);
    assert_eq!(structure.pattern.rows.len(), coupled_pairs(&sample.network, &structure));
}

#[test]
fn a_tree_is_factorised_without_fill() {
    for kind in registry().joints() {
        for segments in [20, 40] {
            let sample = y_harness(&registry(), &kind.name, segments);
            let structure = Structure::new(&sample.network, &[]);
            let fill = structure.pattern.rows.len() - coupled_pairs(&sample.network, &structure);
            assert_eq!(fill, 0, "{}", kind.name);
        }
    }
}

#[test]
fn the_factor_grows_linearly_with_the_segments() {
    for kind in registry().joints() {
        for closed in [false, true] {
            let blocks = [30, 60, 90].map(|n| {
                let registry = registry();
                let sample = match closed {
                    false => y_harness(&registry, &kind.name, n),
                    true => ring(&registry, &kind.name, n, 1),
                };
                Structure::new(&sample.network, &[]).pattern.rows.len()
            });
            let growth = [blocks[1] - blocks[0], blocks[2] - blocks[1]];
            // On a ring the order varies by a few blocks.
            assert!(growth[0].abs_diff(growth[1]) <= growth[0] / 50, "{}: {blocks:?}", kind.name);
        }
    }
}

/// State with random displacements, so that no entry vanishes by symmetry.
fn perturbed(sample: &Sample) -> State {
    let mut rng = fastrand::Rng::with_seed(5);
    let mut state = sample.state.clone();
    let common = random_rotation(&mut rng);
    for x in &mut state.points {
        *x = common * (*x + random_vector(&mut rng, 1e-3));
    }
    for q in &mut state.frames {
        *q = common * *q * random_turn(&mut rng, 0.2);
    }
    sample.network.follow_ties(&mut state);
    state
}

/// Dense copy of an assembled matrix, in elimination order.
fn dense(matrix: &BlockMatrix) -> DMatrix<f64> {
    let s = &matrix.structure;
    let mut dense = DMatrix::zeros(3 * s.len(), 3 * s.len());
    for p in 0..s.len() {
        dense.fixed_view_mut::<3, 3>(3 * p, 3 * p).copy_from(&matrix.diagonal[p]);
        for slot in s.pattern.starts[p] as usize..s.pattern.starts[p + 1] as usize {
            let row = 3 * s.pattern.rows[slot] as usize;
            dense.fixed_view_mut::<3, 3>(row, 3 * p).copy_from(&matrix.below[slot]);
            dense.fixed_view_mut::<3, 3>(3 * p, row).copy_from(&matrix.below[slot].transpose());
        }
    }
    dense
}

#[test]
fn the_factor_of_a_loop_solves_as_a_dense_matrix_does() {
    for kind in registry().joints() {
        let sample = ring(&registry(), &kind.name, 4, 1);
        let (mut matrix, mut rhs) = assembled(&sample, &perturbed(&sample));
        let dense = dense(&matrix);
        let b = DVector::from_vec(rhs.iter().flatten().copied().collect());
        let want = dense.clone().lu().solve(&b).expect("regular");
        let negative = matrix.factorise();
        matrix.solve(&mut rhs);
        let got = DVector::from_vec(rhs.iter().flatten().copied().collect());
        let error = (&got - &want).amax() / want.amax();
        assert!(error < 1e-9, "{}: {error:e}", kind.name);
        let below_zero = dense.symmetric_eigenvalues().iter().filter(|x| **x < 0.0).count();
        assert_eq!(negative, below_zero, "{}: inertia", kind.name);
    }
}

/// Matrix assembled at a state, without a shift, and its right-hand side.
fn assembled(sample: &Sample, state: &State) -> (BlockMatrix, Vec<Vector>) {
    let mut problem = sample.problem();
    let mut gradient = Tangent::zeros(&sample.network);
    problem.update_held(state);
    problem.gradient(state, &mut gradient);
    let mut hessian = Hessian::new(&sample.network);
    problem.hessian(state, None, &mut hessian);
    let mut matrix = BlockMatrix::new(Structure::new(&sample.network, &[]), &sample.network);
    Assembly::new(&sample.network, &matrix.structure).run(&mut matrix, &sample.network, state, &hessian);
    matrix.eliminate_prescribed(&problem);
    let mut rhs = vec![Vector::zeros(); matrix.structure.len()];
    matrix.right_hand_side(&problem, &gradient, None, &mut rhs);
    (matrix, rhs)
}

/// A u, block by block.
fn times(matrix: &BlockMatrix, u: &[Vector]) -> Vec<Vector> {
    let pattern = &matrix.structure.pattern;
    let mut product: Vec<Vector> = matrix.diagonal.iter().zip(u).map(|(a, u)| a * u).collect();
    for p in 0..u.len() {
        for slot in pattern.starts[p] as usize..pattern.starts[p + 1] as usize {
            let (a, row) = (&matrix.below[slot], pattern.rows[slot] as usize);
            product[row] += a * u[p];
            product[p] += a.tr_mul(&u[row]);
        }
    }
    product
}

#[test]
fn a_large_harness_is_assembled_and_factorised_in_parts_whatever_the_number_of_threads() {
    for kind in registry().joints() {
        let sample = ring(&registry(), &kind.name, 900, 3);
        assert!(sample.network.is_shared());
        let state = perturbed(&sample);
        let solve = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| {
                let ((mut matrix, rhs), whole) = (assembled(&sample, &state), assembled(&sample, &state).0);
                assert!(matrix.structure.parts.ranges().len() > 2, "{}: in parts", kind.name);
                let mut solution = rhs.clone();
                let negative = matrix.factorise();
                matrix.solve(&mut solution);
                let back = times(&whole, &solution);
                let largest = |all: &[Vector]| all.iter().map(Vector::amax).fold(0.0, f64::max);
                let scale = largest(&whole.diagonal.iter().zip(&solution).map(|(a, u)| a * u).collect::<Vec<_>>());
                let miss = back.iter().zip(&rhs).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
                // Backward stable, up to the growth of pivots without exchanges.
                assert!(miss < 1e-9 * scale, "{}: {miss:e} of {scale:e}", kind.name);
                (negative, solution)
            })
        };
        let alone = solve(1);
        assert!(alone == solve(2) && alone == solve(5), "{}: the same to the last bit", kind.name);
    }
}

/// Compares the assembled matrix with symmetrised differences of the gradient, in the independent variables.
fn check_assembled(name: &str, sample: &Sample) {
    let network = &sample.network;
    let mut problem = sample.problem();
    let state = perturbed(sample);
    let mut gradient = Tangent::zeros(network);
    problem.gradient(&state, &mut gradient);
    let mut hessian = Hessian::new(network);
    problem.hessian(&state, None, &mut hessian);
    let mut matrix = BlockMatrix::new(Structure::new(network, problem.contact_pattern().1), network);
    Assembly::new(network, &matrix.structure).run(&mut matrix, network, &state, &hessian);
    let (got, variables) = (dense(&matrix), matrix.structure.variables.clone());
    let (h, mut trial) = (1e-5, state.clone());
    let columns: Vec<_> = (0..3 * variables.len())
        .map(|i| {
            let mut step = Tangent::zeros(network);
            match variables[i / 3] {
                Variable::Point(p) => step.points[p][i % 3] = 1.0,
                Variable::Frame(c) => step.frames[c][i % 3] = 1.0,
            }
            let mut at = |alpha: f64| {
                network.retract(&state, &step, alpha, &mut trial);
                problem.gradient(&trial, &mut gradient);
                let entries = variables.iter().flat_map(|v| match v {
                    Variable::Point(p) => gradient.points[*p].iter().copied(),
                    Variable::Frame(c) => gradient.frames[*c].iter().copied(),
                });
                DVector::from_vec(entries.collect())
            };
            (at(h) - at(-h)) / (2.0 * h)
        })
        .collect();
    let want = symmetric(&DMatrix::from_columns(&columns));
    // Positions in tenths of a millimetre: their stiffness is then no larger than that of turns.
    let scale = DVector::from_fn(got.nrows(), |i, _| match variables[i / 3] {
        Variable::Point(_) => 1e-4,
        Variable::Frame(_) => 1.0,
    });
    let scale = DMatrix::from_diagonal(&scale);
    let want = &scale * want * &scale;
    assert_matrix_near(name, &(&scale * got * &scale), &want, 1e-7 * want.amax());
}

/// Ball about the origin.
struct Ball(f64);

impl Shape for Ball {
    fn distance(&self, x: &Vector, _: f64) -> f64 {
        x.norm() - self.0
    }
    fn touches(&self, x: &Vector, reach: f64, see: &mut dyn FnMut(Touch)) {
        let (distance, normal) = (x.norm() - self.0, x.normalize());
        if distance < reach {
            let curvature = (Matrix::identity() - normal * normal.transpose()) / x.norm();
            see(Touch { distance, normal, curvature, part: 0 });
        }
    }
    fn crossing(&self, _: &Vector, _: &Vector) -> Option<f64> {
        None
    }
    fn surface(&self, _: f64) -> Surface {
        Surface::default()
    }
}

/// Half space below z = 0.
struct Floor;

impl Shape for Floor {
    fn distance(&self, x: &Vector, _: f64) -> f64 {
        x.z
    }
    fn touches(&self, x: &Vector, reach: f64, see: &mut dyn FnMut(Touch)) {
        if x.z < reach {
            see(Touch { distance: x.z, normal: Vector::z(), curvature: Matrix::zeros(), part: 0 });
        }
    }
    fn crossing(&self, from: &Vector, to: &Vector) -> Option<f64> {
        (from.z * to.z < 0.0).then(|| from.z / (from.z - to.z))
    }
    fn surface(&self, _: f64) -> Surface {
        Surface::default()
    }
}

/// Sample with an obstacle.
fn with_obstacle(mut sample: Sample, shape: impl Shape + 'static, pose: Pose) -> Sample {
    let (name, kind) = ("body".into(), "body".into());
    let shape = std::sync::Arc::new(shape);
    sample.network.obstacles.push(Obstacle { name, kind, shape, pose, friction: 0.0, min_clearance: None });
    sample.conditions = Conditions::new(&sample.network, sample.conditions.gravity, &sample.state);
    sample
}

/// Sample with a ball of this radius at the mean of its points.
fn with_ball(sample: Sample, state: &State, radius: f64) -> Sample {
    let middle: Vector = state.points.iter().sum::<Vector>() / state.points.len() as f64;
    let turned = wireloom_core::Rotation::from_euler_angles(0.3, -0.4, 0.5);
    with_obstacle(sample, Ball(radius), Pose { position: middle, orientation: turned })
}

#[test]
fn contact_with_an_obstacle_has_the_second_derivatives_of_its_energy() {
    for kind in registry().joints() {
        let sample = ring(&registry(), &kind.name, 4, 1);
        let state = perturbed(&sample);
        let sample = with_ball(sample, &state, 0.25);
        let mut problem = sample.problem();
        assert!(problem.obstacle_loads(&state)[0].points > 3, "{}", kind.name);
        check_assembled(&kind.name, &sample);
    }
}

/// Two crossing cables, thick enough for contact points of one to touch segments of the other, also at a corner; the
/// lower one may be two arms of a hub.
fn crossed(offset: f64, hub: bool) -> Sample {
    let mut sketch = Sketch::default();
    let upper = ([offset, -0.2, 0.03], [offset, 0.25, 0.01], [None, None]);
    let lower = if hub {
        let joint = Some(sketch.joint("rigid-body", Vector::zeros()));
        vec![([-0.2, 0.0, 0.0], [-0.02, 0.0, 0.0], [None, joint]), ([0.02, 0.0, 0.0], [0.2, 0.0, 0.0], [joint, None])]
    } else {
        vec![([-0.2, 0.0, 0.0], [0.2, 0.0, 0.0], [None, None])]
    };
    for (from, to, joints) in lower.into_iter().chain([upper]) {
        let branch = sketch.branch(Vector::from(from), Vector::from(to), 6, joints, false);
        if joints[0].is_none() {
            sketch.clamp(branch, true);
        }
    }
    let mut sample = sketch.build(&registry());
    sample.network.contact.cables = true;
    for branch in &mut sample.network.branches {
        branch.section.diameter = 0.05;
    }
    sample
}

#[test]
fn cables_that_touch_have_the_second_derivatives_of_their_energy() {
    for offset in [0.0, 0.02] {
        let sample = crossed(offset, false);
        let (mut problem, state) = (sample.problem(), perturbed(&sample));
        assert!(problem.contact_violation(&state).is_some_and(|violation| violation > 100.0), "they touch");
        check_assembled("crossed cables", &sample);
    }
}

/// A multiplier that is large for its penalty acts at larger distances than those at which approaching pairs are
/// coupled. Its block was missing once, which caused a panic.
#[test]
fn contact_forces_at_a_distance_have_their_block_in_the_matrix() {
    let mut sketch = Sketch::default();
    let lines = [
        ([-0.2, 0.0, 0.0], [0.2, 0.0, 0.0]),
        ([0.0, -0.2, 0.03], [0.0, 0.25, 0.01]),
        ([0.0, 0.0, 5.0], [0.4, 0.0, 5.0]),
    ];
    for (from, to) in lines {
        let branch = sketch.branch(Vector::from(from), Vector::from(to), 6, [None, None], false);
        sketch.clamp(branch, true);
    }
    let mut sample = sketch.build(&registry());
    sample.network.contact.cables = true;
    // With a thick cable far away the broad phase finds pairs farther apart than twice the diameter of these two.
    for (branch, diameter) in sample.network.branches.iter_mut().zip([0.01, 0.01, 0.1]) {
        branch.section.diameter = diameter;
    }
    let upper = sample.network.branches[1].points.clone();
    let mut touching = sample.state.clone();
    touching.points[upper.clone()].iter_mut().for_each(|x| x.z -= 0.012);
    let mut problem = sample.problem();
    update_contacts(&mut problem, &touching, &mut ContactHistory::default());
    let mut conditions = problem.conditions().clone();
    assert!(!conditions.contact.records.is_empty(), "they touch");
    for record in &mut conditions.contact.records {
        record.multiplier *= 20.0;
    }
    sample.conditions = conditions;
    sample.state.points[upper].iter_mut().for_each(|x| x.z += 0.005);
    check_assembled("force at a distance", &sample);
}

/// Collision detection once checked contact points only: one cable could pass through the other between two of them.
#[test]
fn a_cable_does_not_pass_through_another_one_between_their_contact_points() {
    let sample = crossed(0.0167, false);
    let upper = sample.network.branches[1].points.clone();
    let at = |z: f64| {
        let mut state = sample.state.clone();
        // Halfway between contact points of either cable.
        state.points[upper.clone()].iter_mut().for_each(|x| *x = Vector::new(x.x, x.y + 0.0125, z));
        state
    };
    let mut problem = sample.problem();
    let fraction = problem.collision_free_fraction(&at(0.004), &at(-0.004), None);
    assert!((fraction - 0.45).abs() < 1e-9, "nine tenths of the motion up to contact, not {fraction}");
    assert_eq!(problem.collision_free_fraction(&at(0.004), &at(0.001), None), 1.0);
}

/// Crossing cables with friction anchors set before the motion to the state of [`perturbed`]: by little, so that all
/// stick, or so far that all slip.
fn with_friction(offset: f64, hub: bool, moved: f64) -> Sample {
    let mut sample = crossed(offset, hub);
    sample.network.contact.friction = 0.3;
    // Friction no stiffer than contact: sticking contacts then stick for all differences.
    sample.network.branches.iter_mut().for_each(|branch| branch.section.axial_stiffness = 1.0);
    let (mut rng, mut step) = (fastrand::Rng::with_seed(3), Tangent::zeros(&sample.network));
    for (x, q) in step.points.iter_mut().zip(&mut step.frames) {
        *x = random_vector(&mut rng, moved);
        *q = random_vector(&mut rng, 10.0 * moved);
    }
    let (to, mut from) = (perturbed(&sample), sample.state.clone());
    sample.network.retract(&to, &step, -1.0, &mut from);
    sample.network.follow_ties(&mut from);
    let mut problem = sample.problem();
    problem.enable_friction();
    update_contacts(&mut problem, &from, &mut ContactHistory::default());
    sample.conditions = problem.conditions().clone();
    assert!(
        sample.conditions.contact.records.iter().filter(|record| record.anchor.is_some()).count() > 3,
        "friction acts"
    );
    sample
}

/// The energy of contact alone.
fn contact_energy(problem: &mut Problem<'_>, state: &State) -> f64 {
    problem.energy(state).constraint
}

#[test]
fn cables_with_friction_have_the_derivatives_of_their_energy() {
    for (offset, hub) in [(0.0, false), (0.02, false), (0.04, true)] {
        for moved in [3e-5, 1e-2] {
            let name = format!("offset {offset}, hub {hub}, moved {moved}");
            let sample = with_friction(offset, hub, moved);
            check_assembled(&name, &sample);
            let (mut problem, state) = (sample.problem(), perturbed(&sample));
            let smooth = crossed(offset, hub);
            let mut smooth = Problem::new(&smooth.network, sample.conditions.clone());
            // Contribution of friction, and its derivative along a random direction.
            let (mut rng, mut step) = (fastrand::Rng::with_seed(9), Tangent::zeros(&sample.network));
            for v in step.points.iter_mut().chain(&mut step.frames) {
                *v = random_vector(&mut rng, 1.0);
            }
            let mut trial = state.clone();
            let mut along = |problem: &mut Problem<'_>| {
                let mut gradient = Tangent::zeros(&sample.network);
                problem.gradient(&state, &mut gradient);
                let mut at = |alpha: f64| {
                    sample.network.retract(&state, &step, alpha, &mut trial);
                    contact_energy(problem, &trial)
                };
                let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                let pairs = |a: &[Vector], b: &[Vector]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
                (slope, pairs(&gradient.points, &step.points) + pairs(&gradient.frames, &step.frames))
            };
            let (rough, even) = (along(&mut problem), along(&mut smooth));
            let (want, got) = (rough.0 - even.0, rough.1 - even.1);
            assert!((want - got).abs() < 1e-5 * want.abs(), "{name}: {got} J by the gradient, {want} J by differences");
        }
    }
}

/// A rigid motion of cables with friction keeps their energy, so that the forces and moments between them have no
/// resultant.
#[test]
fn friction_between_cables_is_invariant_under_rigid_motion() {
    for moved in [3e-5, 1e-2] {
        let sample = with_friction(0.02, false, moved);
        let (mut problem, state) = (sample.problem(), perturbed(&sample));
        let (mut rng, mut turned) = (fastrand::Rng::with_seed(11), state.clone());
        let (turn, shift) = (random_rotation(&mut rng), random_vector(&mut rng, 0.3));
        turned.points.iter_mut().for_each(|x| *x = turn * *x + shift);
        turned.frames.iter_mut().for_each(|q| *q = turn * *q);
        let (here, there) = (contact_energy(&mut problem, &state), contact_energy(&mut problem, &turned));
        assert!((here - there).abs() < 1e-12 * here.abs(), "{here} J, turned {there} J");
    }
}

/// Largest residual force on a free point.
fn largest_free_force(gradient: &Tangent, problem: &Problem<'_>) -> f64 {
    let mut free = gradient.clone();
    problem.free_part(&mut free);
    free.points.iter().map(|force| force.norm()).fold(0.0, f64::max)
}

#[test]
fn condensed_points_are_in_balance_and_condensation_is_undone_exactly() {
    for kind in registry().joints() {
        let sample = ring(&registry(), &kind.name, 4, 1);
        let mut problem = sample.problem();
        let mut state = perturbed(&sample);
        problem.update_held(&state);
        problem.place_held(&mut state);
        let (before, mut gradient) = (state.clone(), Tangent::zeros(&sample.network));
        let energy = problem.gradient(&state, &mut gradient);
        let force = largest_free_force(&gradient, &problem);
        let mut condensation = Condensation::new(&problem);
        assert!(
            !condensation.condense(&mut problem, &mut state, &gradient, 2.0 * force),
            "{}: nothing to do",
            kind.name
        );
        assert!(condensation.condense(&mut problem, &mut state, &gradient, 0.0), "{}", kind.name);
        let condensed = problem.gradient(&state, &mut gradient);
        let rest = largest_free_force(&gradient, &problem);
        assert!(condensed < energy, "{}: {condensed} J after {energy} J", kind.name);
        assert!(rest < 1e-9 * force, "{}: {rest:e} N of {force:e} N are left", kind.name);
        assert_eq!(state.frames, before.frames);
        condensation.undo(&mut state);
        assert_eq!(state, before);
    }
}

/// At fixed frames, and with a plane obstacle, the model of contact is exact: one condensation finds the contacts.
#[test]
fn contacts_with_a_plane_that_close_and_open_are_found_by_one_condensation() {
    let mut rng = fastrand::Rng::with_seed(3);
    for height in [0.0, 0.0005, 0.001] {
        let mut sketch = Sketch::default();
        let branch = sketch.branch(Vector::new(-0.2, 0.0, 0.0), Vector::new(0.2, 0.0, 0.0), 24, [None, None], false);
        sketch.clamp(branch, true);
        sketch.clamp(branch, false);
        let mut sample = sketch.build(&registry());
        sample.network.branches[0].section.diameter = 0.02;
        let mut state = sample.state.clone();
        let pose = Pose { position: Vector::new(0.0, 0.0, height - 0.01), ..Pose::identity() };
        let sample = with_obstacle(sample, Floor, pose);
        for x in &mut state.points {
            x.z += 4e-3 * (rng.f64() - 0.5);
        }
        for q in &mut state.frames {
            *q *= random_turn(&mut rng, 0.02);
        }
        let (mut problem, mut gradient) = (sample.problem(), Tangent::zeros(&sample.network));
        problem.update_held(&state);
        problem.place_held(&mut state);
        problem.gradient(&state, &mut gradient);
        let (force, touched) = (largest_free_force(&gradient, &problem), problem.obstacle_loads(&state)[0].points);
        let mut condensation = Condensation::new(&problem);
        assert!(condensation.condense(&mut problem, &mut state, &gradient, 0.0));
        problem.gradient(&state, &mut gradient);
        let (rest, touching) = (largest_free_force(&gradient, &problem), problem.obstacle_loads(&state)[0].points);
        assert!(touching != touched && touching > 0, "{touched} touched, {touching} do");
        assert!(rest < 1e-9 * force, "{rest:e} N of {force:e} N are left");
    }
}

#[test]
fn the_assembled_matrix_is_the_second_derivative_of_the_energy() {
    let registry = registry();
    for kind in registry.joints() {
        check_assembled(&format!("{}, Y", kind.name), &y_harness(&registry, &kind.name, 3));
        check_assembled(&format!("{}, ring", kind.name), &ring(&registry, &kind.name, 3, 1));
    }
}

#[test]
fn levers_and_springs_are_in_the_assembled_matrix() {
    let registry = registry();
    let mut sample = sized_y_harness(&registry, "rigid-body", 3, 0.04);
    check_assembled("offsets", &sample);
    let spec = ConstraintSpec { tangent_given: true, up_given: true, ..ConstraintSpec::default() };
    let values = [("stiffness", 500.0), ("angular_stiffness", 2.0)];
    let values = Parameters(values.map(|(name, value)| (name.into(), Value::Number(value))).into());
    let handle = registry.constraint("handle").unwrap();
    // One spring at an end, one at an arm's station on the hub.
    for end in [0, 1] {
        sample.network.constraints[end].model = (handle.build)(&spec, &values).unwrap();
    }
    sample.network.constraints[1].stations = vec![sample.network.site(Place::Node { branch: 1, node: 0 })];
    check_assembled("offsets and springs", &sample);
}

/// Stations on one hub with and without levers, on one variable and far apart, and a span that begins at the hub.
#[test]
fn constraints_of_several_stations_are_in_the_assembled_matrix() {
    for (kind, size) in [("rigid-body", 0.04), ("cosserat", 0.0)] {
        let mut sample = sized_y_harness(&registry(), kind, 3, size);
        let place = |branch, node| Place::Node { branch, node };
        let hub = size > 0.0;
        // A joint without a frame has no stations.
        let near = if hub { [place(0, 3), place(1, 0)] } else { [place(1, 3), place(2, 3)] };
        let pairs = [near, [place(2, 3), place(0, 0)], [near[0], place(2, 3)]];
        let kinds: [Box<dyn Constraint>; 3] =
            [Box::new(Strut { rest: 0.01, stiffness: 70.0 }), Box::new(Link(0.3)), Box::new(Sight)];
        for (kind, pair) in kinds.into_iter().zip(pairs) {
            sample.network.add_constraint(plan(kind, pair.into(), None));
        }
        sample.network.add_constraint(plan(Box::new(Bowl), vec![], Some(NodeRange { branch: 1, nodes: 0..3 })));
        sample.conditions = Conditions::new(&sample.network, Vector::new(0.0, 0.0, -9.81), &sample.state);
        // Non-zero multipliers, and penalties of the size of the other terms.
        for own in &mut sample.conditions.constraints {
            own.multipliers.fill(0.7);
            own.penalties.fill(5.0);
        }
        check_assembled(kind, &sample);
    }
}

/// Newton steps on a cable with a link between two of its nodes, after a small motion of its end: near the solution
/// each step squares the residual at fixed multipliers and penalty, and the next update of the multipliers satisfies
/// the link.
#[test]
fn newton_keeps_its_order_through_equations() {
    let mut sample = cable(&registry(), 60);
    let nodes = [15, 45].map(|node| Place::Node { branch: 0, node });
    sample.network.add_constraint(plan(Box::new(Link(0.35)), nodes.into(), None));
    sample.conditions = Conditions::new(&sample.network, Vector::new(0.0, 0.0, -9.81), &sample.state);
    let (mut problem, mut state, mut newton) = (sample.problem(), sample.state.clone(), Newton::new());
    let (stop, mut last) = (Stop { force_tolerance: 1e-10, max_iterations: 500 }, Vec::new());
    let violation = |problem: &Problem<'_>, state: &State| problem.worst_residual(state).expect("a link").violation;
    for x in [0.95, 0.9, 0.85, 0.8] {
        let mut target = problem.conditions().targets[1];
        target.position = Vector::new(x, 0.02, 0.05);
        problem.set_target(1, target);
        last.clear();
        for _ in 0..20 {
            newton.minimise(&mut problem, &mut state, &stop);
            update_constraints(&mut problem, &state, 1e-10, &mut last);
        }
        assert!(violation(&problem, &state) < 1e-10, "{:e}", violation(&problem, &state));
    }
    let mut target = problem.conditions().targets[1];
    target.position.x -= 0.002;
    problem.set_target(1, target);
    let one = Stop { force_tolerance: 0.0, max_iterations: 1 };
    let residuals: Vec<f64> = (0..8).map(|_| newton.minimise(&mut problem, &mut state, &one).residual).collect();
    let near = residuals.iter().position(|r| *r < 1e-2).expect("near the solution");
    let solved = residuals.iter().position(|r| *r < 1e-9).expect("solved");
    assert!(residuals[near + 1] <= residuals[near].powi(2) && solved - near <= 3, "{residuals:?}");
    update_constraints(&mut problem, &state, 1e-10, &mut last);
    newton.minimise(&mut problem, &mut state, &stop);
    assert!(violation(&problem, &state) < 1e-7, "{:e}", violation(&problem, &state));
}

fn plan(model: Box<dyn Constraint>, stations: Vec<Place>, span: Option<NodeRange>) -> ConstraintPlan {
    ConstraintPlan {
        name: String::new(),
        kind: String::new(),
        model,
        stations,
        span,
        position: None,
        tangent: None,
        orientation: None,
        slide: None,
        limits: Limits::default(),
        nearest: false,
        from_start: true,
    }
}

/// `½ k |x|⁴` for every node of a span.
struct Bowl;

impl Constraint for Bowl {
    fn action(&self) -> Action<'_> {
        Action::Potential(self)
    }
    fn objective(&self) -> bool {
        false
    }
}

impl Potential for Bowl {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        at.span.iter().map(|x| x.norm_squared().powi(2)).sum::<f64>() * 2.5
    }
    fn gradient(&self, at: &ConstraintView<'_>, _: &mut [Vector], span: &mut [Vector]) -> f64 {
        span.iter_mut().zip(at.span).for_each(|(g, x)| *g = x * (10.0 * x.norm_squared()));
        self.energy(at)
    }
    fn hessian(&self, at: &ConstraintView<'_>, _: &mut [Matrix], span: &mut [Matrix]) {
        for (h, x) in span.iter_mut().zip(at.span) {
            *h = Matrix::identity() * (10.0 * x.norm_squared()) + x * x.transpose() * 20.0;
        }
    }
}

#[test]
fn the_moment_at_a_clamped_end_is_the_reaction_of_the_clamp() {
    let sample = cable(&registry(), 20);
    let (state, _) = hung(&sample);
    let mut problem = sample.problem();
    problem.update_held(&state);
    let mut gradient = Tangent::zeros(&sample.network);
    problem.gradient(&state, &mut gradient);
    let branch = branch(&problem, 0, &state, &vec![false; sample.network.points]);
    for (constraint, inner) in [(0, -branch.moment[0]), (1, branch.moment[20])] {
        let reaction = problem.reaction(constraint, &state, &gradient).1;
        let off = (inner - reaction).norm();
        assert!(off <= 1e-9 * reaction.norm(), "clamp {constraint}: {inner} and {reaction}, N m");
    }
}
