//! Tests of joint models.

use super::trial::{CYCLES, Trial, Verdict, conformance, floating_point, is_numeric, leaks, parameters, threads, time};
use wireloom::geometry::{Matrix, Rotation, Vector, frame_from};
use wireloom::parts::{Arm, ArmSpring, JointKind, JointModel, JointShape, JointSpec, Mounting};
use wireloom::testing::conformance::joint::{CHECKS, Subject};
use wireloom::testing::conformance::rod::section;

/// Arms of the joint for timing and invalid input.
const ARMS: usize = 3;

/// Round-off of a gradient that is differences of the energy, relative to it.
const OF_DIFFERENCES: f64 = 1e-8;

/// Tests of a joint model, by name.
pub fn trials(kind: &JointKind) -> Vec<Trial<'_>> {
    let values = parameters(&kind.parameters);
    let make = move |spec: JointSpec| (kind.build)(&spec, &values).map_err(|error| error.message);
    let what = "creation with typical values".to_owned();
    let mut all: Vec<Trial<'_>> = vec![];
    match make(spec()) {
        Ok(first) => all.push((what, Box::new(move || Ok(hangs(first.as_ref()).into())))),
        Err(why) => {
            all.push((what, Box::new(move || Err(why))));
            return all;
        }
    }
    let make = move |spec: JointSpec| make(spec).unwrap_or_else(|why| panic!("{why}"));
    let differences = is_numeric(&kind.name, "gradient_is_the_derivative_of_the_energy");
    for (name, check) in CHECKS {
        let make = make.clone();
        all.push(conformance(&kind.name, name, move || {
            let subject = Subject::new(make);
            check(&if differences { subject.with_round_off(OF_DIFFERENCES) } else { subject });
        }));
    }
    let maker = make.clone();
    all.push(("no crash with input that is not finite".into(), Box::new(move || invalid_input(&maker))));
    let maker = make.clone();
    all.push(("same numbers on several threads".into(), Box::new(move || same_on_threads(maker(spec()).as_ref()))));
    let maker = make.clone();
    all.push((
        format!("no loss of memory, {CYCLES} times"),
        Box::new(move || leaks(|| drop(evaluate(maker(spec()).as_ref(), 0.1)))),
    ));
    let evaluation = move || {
        let joint = make(spec());
        time(|| evaluate(joint.as_ref(), 0.1), &format!("values and derivatives of {ARMS} arms"))
    };
    all.push(("time of an evaluation".into(), Box::new(evaluation)));
    all.push(floating_point(""));
    all
}

fn hangs(joint: &dyn JointModel) -> &'static str {
    match joint.mounting() {
        Mounting::Point => "ok: the arms share a point",
        Mounting::Stations => "ok: the arms share a point, their ends have frames",
        Mounting::Pose => "ok: a hub",
        Mounting::CompliantHub => "ok: a hub, the ends of the arms have frames",
    }
}

/// Three arms, 120 degrees apart.
fn spec() -> JointSpec {
    let arm = |a: usize| {
        let angle = std::f64::consts::TAU * a as f64 / ARMS as f64;
        let direction = Vector::new(angle.cos(), angle.sin(), 0.0);
        Arm {
            branch: format!("arm {a}"),
            starts_here: true,
            rest: frame_from(&direction, &Vector::z()).expect("not along z"),
            offset: Vector::zeros(),
            section: section(),
            segment_length: 0.01,
            length: 1.0,
            curvature: Vector::zeros(),
            spring: ArmSpring { bending: Some([0.3, 0.5]), torsion: Some(0.2), ..ArmSpring::default() },
        }
    };
    JointSpec { name: "trial".into(), arms: (0..ARMS).map(arm).collect(), wires: vec![] }
}

/// All values, with the arms turned by about `x` rad.
fn evaluate(joint: &dyn JointModel, x: f64) -> Vec<u64> {
    let turned =
        |(a, arm): (usize, &Arm)| arm.rest * Rotation::from_scaled_axis(Vector::new(x, 0.3 * x * a as f64, -x));
    let hub = (joint.mounting() == Mounting::CompliantHub).then(Rotation::identity);
    let frames: Vec<Rotation> = spec().arms.iter().enumerate().map(turned).chain(hub).collect();
    let mut gradient = vec![Vector::zeros(); frames.len()];
    let mut hessian = vec![Matrix::zeros(); frames.len() * frames.len()];
    let shape = JointShape { frames: &frames, memory: &joint.memory() };
    let mut numbers = vec![joint.energy(&shape), joint.add_gradient(&shape, &mut gradient)];
    joint.add_hessian(&shape, &mut hessian);
    numbers.extend(gradient.iter().flat_map(|v| [v.x, v.y, v.z]));
    numbers.extend(hessian.iter().flat_map(|block| block.iter().copied().collect::<Vec<_>>()));
    numbers.iter().map(|x| x.to_bits()).collect()
}

/// Invalid rotations must not crash the program, nor panic.
fn invalid_input(make: &dyn Fn(JointSpec) -> Box<dyn JointModel>) -> Verdict {
    for x in [0.0, f64::NAN, f64::INFINITY, 1e-200, 3.0] {
        let joint = make(spec());
        evaluate(joint.as_ref(), x);
        if let Some(fault) = joint.fault().filter(|fault| x.is_finite() || fault.contains("panicked")) {
            return Err(format!("turned by {x}: {fault}"));
        }
    }
    Ok("ok".into())
}

fn same_on_threads(joint: &dyn JointModel) -> Verdict {
    threads(|k| evaluate(joint, 0.1 * k), || joint.fault())
}
