//! Contact and friction in the Newton step: derivatives, collision detection, and the active set.

use super::helpers::{check_assembled, largest_free_force, perturbed, registry};
use wireloom_core::conditions::Conditions;
use wireloom_core::obstacle::{Obstacle, Shape, Surface, Touch};
use wireloom_core::{Matrix, Pose, Problem, State, Tangent, Vector};
use wireloom_solve::contact::multipliers::{ContactHistory, update_contacts};
use wireloom_solve::minimisers::condensation::Condensation;
use wireloom_testkit::conformance::networks::{Sample, Sketch, ring};
use wireloom_testkit::conformance::numeric::{random_rotation, random_turn, random_vector};

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
    sample.network.obstacles.push(Obstacle {
        name,
        kind,
        shape,
        pose,
        mount: None,
        friction: 0.0,
        min_clearance: None,
        max_contact_force: None,
    });
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
        branch.sections.iter_mut().for_each(|section| section.diameter = 0.05);
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
        branch.sections.iter_mut().for_each(|section| section.diameter = diameter);
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
    sample
        .network
        .branches
        .iter_mut()
        .for_each(|branch| branch.sections.iter_mut().for_each(|own| own.axial_stiffness = 1.0));
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
        let mut sample = with_friction(0.02, false, moved);
        // On chords: x″ of arcs is fixed in the world until the next update.
        sample.conditions.contact.crossings.clear();
        let (mut problem, state) = (sample.problem(), perturbed(&sample));
        let (mut rng, mut turned) = (fastrand::Rng::with_seed(11), state.clone());
        let (turn, shift) = (random_rotation(&mut rng), random_vector(&mut rng, 0.3));
        turned.points.iter_mut().for_each(|x| *x = turn * *x + shift);
        turned.frames.iter_mut().for_each(|q| *q = turn * *q);
        let (here, there) = (contact_energy(&mut problem, &state), contact_energy(&mut problem, &turned));
        assert!((here - there).abs() < 1e-12 * here.abs(), "{here} J, turned {there} J");
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
        sample.network.branches[0].sections.iter_mut().for_each(|section| section.diameter = 0.02);
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
