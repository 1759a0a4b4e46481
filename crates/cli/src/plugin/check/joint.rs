//! Tests of joint models.

use super::trial::{CYCLES, THREADS, TIMED, Trial, Verdict, floating_point, is_numeric, leaks, parameters};
use std::time::Instant;
use wireloom::geometry::{Matrix, Rotation, Vector, frame_from};
use wireloom::harness::Section;
use wireloom::parts::{Arm, ArmSpring, JointKind, JointModel, JointShape, JointSpec, Mounting};
use wireloom::testing::conformance::joint::{CHECKS, Subject};

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
        let (make, numeric) = (make.clone(), is_numeric(&kind.name, name));
        all.push((
            name.replace('_', " "),
            Box::new(move || {
                if numeric {
                    return Ok("not tested: the program computes them numerically, \
                               which is slower and less exact than derivatives of the plugin"
                        .into());
                }
                let subject = Subject::new(make);
                check(&if differences { subject.with_round_off(OF_DIFFERENCES) } else { subject });
                Ok("ok".into())
            }),
        ));
    }
    let maker = make.clone();
    all.push(("no crash with input that is not finite".into(), Box::new(move || invalid_input(&maker))));
    let maker = make.clone();
    all.push(("same numbers on several threads".into(), Box::new(move || threads(maker(spec()).as_ref()))));
    let maker = make.clone();
    all.push((
        format!("no loss of memory, {CYCLES} times"),
        Box::new(move || leaks(|| drop(evaluate(maker(spec()).as_ref(), 0.1)))),
    ));
    all.push(("time of an evaluation".into(), Box::new(move || time(make(spec()).as_ref()))));
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
            section: Section {
                name: "cable".into(),
                diameter: 0.006,
                linear_density: 0.05,
                axial_stiffness: 1e4,
                shear_stiffness: [4e3; 2],
                bending_stiffness: [0.01; 2],
                torsion_stiffness: 0.008,
                min_bend_radius: None,
                min_bend_radius_moving: None,
                max_tension: None,
                max_torsion: None,
                thermal_expansion: 0.0,
                thermal_curvature: Vector::zeros(),
                friction: Default::default(),
                set: None,
                laws: Default::default(),
            },
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

fn threads(joint: &dyn JointModel) -> Verdict {
    let (threads, times) = THREADS;
    let turn = |k: usize| 0.1 * (k % 7) as f64;
    let want: Vec<Vec<u64>> = (0..7).map(|k| evaluate(joint, turn(k))).collect();
    let same = std::thread::scope(|scope| {
        let all: Vec<_> =
            (0..threads).map(|_| scope.spawn(|| (0..times).all(|k| evaluate(joint, turn(k)) == want[k % 7]))).collect();
        all.into_iter().all(|thread| thread.join().unwrap_or(false))
    });
    match joint.fault() {
        Some(fault) => Err(fault),
        None if same => Ok("ok".into()),
        None => {
            Err(format!("{threads} concurrent threads do not get the same numbers as one: leave `thread_safe` at 0"))
        }
    }
}

fn time(joint: &dyn JointModel) -> Verdict {
    let clock = Instant::now();
    (0..TIMED).for_each(|_| drop(evaluate(joint, 0.1)));
    Ok(format!(
        "{:.2} µs for all values and derivatives of {ARMS} arms",
        clock.elapsed().as_secs_f64() * 1e6 / f64::from(TIMED)
    ))
}
