//! Linear system of a Newton step: fill, factorisation, and assembly against differences of the gradient.

use super::helpers::{assembled, check_assembled, dense, perturbed, plan, registry};
use nalgebra::DVector;
use std::collections::BTreeSet;
use wireloom_core::conditions::{Conditions, RotatingAxes};
use wireloom_core::constraint::ConstraintSpec;
use wireloom_core::network::{NodeRange, Place};
use wireloom_core::variable::Variable;
use wireloom_core::{Action, Constraint, ConstraintView, Matrix, Network, Parameters, Potential, Value, Vector};
use wireloom_solve::linear::matrix::BlockMatrix;
use wireloom_solve::linear::symbolic::Structure;
use wireloom_testkit::conformance::networks::{cable, ring, sized_y_harness, y_harness};
use wireloom_testkit::constraints::{Link, Sight, Strut};

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
            let beside = mesh.beside.iter().filter(|b| b.segment == j).flat_map(|b| b.neighbours()).flatten();
            clique.extend(beside.map(|c| frame(q + c)));
            cliques.push(clique);
        }
        cliques.extend((1..mesh.frames()).map(|c| vec![frame(q + c - 1), frame(q + c)]));
        cliques.extend(mesh.pairs.iter().map(|pair| vec![frame(q + pair.frame - 1), frame(q + pair.frame + 1)]));
    }
    cliques.extend(network.joints.iter().map(|j| j.coupled_frames.iter().map(|&c| frame(c)).collect()));
    let mut pairs = BTreeSet::new();
    for clique in cliques {
        let places: BTreeSet<u32> = clique.into_iter().filter_map(|v| structure.position(v)).collect();
        pairs.extend(places.iter().flat_map(|&a| places.iter().filter(move |&&b| a < b).map(move |&b| (a, b))));
    }
    pairs.len()
}

/// Pairs of couplings of a network.
fn pairs(network: &Network) -> usize {
    network.branches.iter().map(|branch| branch.rod.mesh().pairs.len()).sum()
}

/// A pair couples a frame with the second next one, past a node: the node then becomes a neighbour of one more frame.
#[test]
fn a_cable_is_factorised_with_one_block_of_fill_a_pair() {
    let sample = cable(&registry(), 50);
    let structure = Structure::new(&sample.network, &[]);
    let fill = structure.pattern.rows.len() - coupled_pairs(&sample.network, &structure);
    assert!(fill <= pairs(&sample.network), "{fill} blocks of fill");
}

#[test]
fn a_tree_is_factorised_with_one_block_of_fill_a_pair() {
    for kind in registry().joints() {
        for segments in [20, 40] {
            let sample = y_harness(&registry(), &kind.name, segments);
            let structure = Structure::new(&sample.network, &[]);
            let fill = structure.pattern.rows.len() - coupled_pairs(&sample.network, &structure);
            assert!(fill <= pairs(&sample.network), "{}: {fill} blocks of fill", kind.name);
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
    check_assembled("compliant, offsets", &sized_y_harness(&registry, "compliant-hub", 3, 0.04));
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

/// At 3,000 rad/s the pull of the rotation stiffens as much as EA.
#[test]
fn the_pull_of_axes_that_rotate_is_in_the_assembled_matrix() {
    for (kind, size) in [("rigid-body", 0.04), ("compliant-hub", 0.04), ("cosserat", 0.0)] {
        let mut sample = sized_y_harness(&registry(), kind, 3, size);
        sample.conditions.rotation =
            RotatingAxes { point: Vector::new(0.1, -0.2, 0.3), velocity: Vector::new(1200.0, -1800.0, 2000.0) };
        check_assembled(kind, &sample);
    }
}

/// Stations on one hub with and without levers, on one variable and far apart, and a span that begins at the hub.
#[test]
fn constraints_of_several_stations_are_in_the_assembled_matrix() {
    for (kind, size) in [("rigid-body", 0.04), ("compliant-hub", 0.04), ("cosserat", 0.0)] {
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
