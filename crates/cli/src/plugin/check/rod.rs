//! Tests of rods.

use super::trial::{CYCLES, Trial, Verdict, conformance, floating_point, leaks, parameters, threads, time};
use wireloom::geometry::{Matrix, Vector};
use wireloom::harness::Mesh;
use wireloom::parts::{ConstitutiveLaw, ConstitutiveLaws, Past, Response, RodKind, RodSegment, RodSpec};
use wireloom::testing::conformance::constitutive::CHECKS;
use wireloom::testing::conformance::rod::section;

/// Segments of the branch for timing and invalid input.
const SEGMENTS: usize = 100;

/// Tests of a rod, by name.
pub fn trials(kind: &RodKind) -> Vec<Trial<'_>> {
    let values = parameters(&kind.parameters);
    let make = move |spec: RodSpec| (kind.build)(&spec, &values).map_err(|error| error.message);
    let what = "creation with typical values".to_owned();
    let mut all: Vec<Trial<'_>> = vec![];
    match make(branch()) {
        Ok(first) => all.push((what, Box::new(move || Ok(has(first.as_ref()))))),
        Err(why) => {
            all.push((what, Box::new(move || Err(why))));
            return all;
        }
    }
    let make = move |spec: RodSpec| make(spec).unwrap_or_else(|why| panic!("{why}"));
    for (name, check) in CHECKS {
        let make = make.clone();
        all.push(conformance(&kind.name, name, move || check(&make)));
    }
    let maker = make.clone();
    all.push(("no crash with strains from nothing to far beyond any cable".into(), Box::new(move || extremes(&maker))));
    let maker = make.clone();
    all.push(("same numbers on several threads".into(), Box::new(move || same_on_threads(maker(branch()).as_ref()))));
    let maker = make.clone();
    all.push((
        format!("no loss of memory, {CYCLES} times"),
        Box::new(move || leaks(|| drop(answers(maker(branch()).as_ref(), 0.1)))),
    ));
    let evaluate = move || {
        let rod = make(branch());
        time(|| answers(rod.as_ref(), 0.01), &format!("energies and derivatives of {SEGMENTS} segments"))
    };
    all.push(("time of an evaluation".into(), Box::new(evaluate)));
    all.push(floating_point(""));
    all
}

fn branch() -> RodSpec {
    let mesh = Mesh::new(vec![0.01; SEGMENTS], vec![0, SEGMENTS]);
    RodSpec { name: "trial".into(), sections: section().into(), mesh, curvature: Vector::zeros() }
}

fn laws(rod: &dyn RodSegment) -> &ConstitutiveLaws {
    rod.constitutive().expect("a rod of a plugin has laws of its own")
}

fn has(rod: &dyn RodSegment) -> String {
    let has = match (laws(rod).stretch.is_some(), laws(rod).bend.is_some()) {
        (true, true) => "ok: laws of stretch and of bending",
        (true, false) => "ok: a law of stretch; it bends as its section",
        (false, _) => "ok: a law of bending; it stretches as its section",
    };
    match laws(rod).memory() {
        0 => has.into(),
        numbers => format!("{has}; a coupling remembers {numbers} numbers"),
    }
}

/// All answers of a law for strains of about this size, with the memory at first and that after these strains.
fn answer(law: &dyn ConstitutiveLaw, size: f64) -> Vec<u64> {
    let strain = |k: usize| Vector::new(1.0, -0.3 * k as f64, 0.7) * (size / (1.0 + k as f64));
    let strains: Vec<Vector> = (0..SEGMENTS).map(strain).collect();
    let (mut energy, mut gradient) = (vec![0.0; SEGMENTS], vec![Vector::zeros(); SEGMENTS]);
    let (mut hessian, mut dissipated) = (vec![Matrix::zeros(); SEGMENTS], vec![0.0; SEGMENTS]);
    let mut memory = vec![0.0; SEGMENTS * law.memory()];
    let mut all = vec![];
    for _ in 0..1 + usize::from(!memory.is_empty()) {
        let (of_energy, of_gradient, of_hessian) = (Some(&mut energy[..]), Some(&mut gradient[..]), &mut hessian[..]);
        let mut response = Response { energy: of_energy, gradient: of_gradient, hessian: Some(of_hessian) };
        law.respond(&strains, Past { memory: &memory, duration: 1.0 }, &mut response);
        dissipated.fill(0.0);
        law.commit(&strains, 1.0, &mut memory, &mut dissipated);
        let numbers = energy.iter().chain(gradient.iter().flatten()).chain(hessian.iter().flatten());
        all.extend(numbers.chain(&memory).chain(&dissipated).map(|x| x.to_bits()));
    }
    all
}

/// All answers of all laws, for strains of about `x` and curvatures of about 100 `x` (1/m).
fn answers(rod: &dyn RodSegment, x: f64) -> Vec<u64> {
    let ConstitutiveLaws { stretch, bend } = laws(rod);
    let laws = [(stretch, x), (bend, 100.0 * x)];
    laws.into_iter().flat_map(|(law, size)| law.iter().flat_map(move |law| answer(law.as_ref(), size))).collect()
}

/// A minimiser tries strains that no cable bears: 10, and curvatures of 1000 1/m.
fn extremes(make: &dyn Fn(RodSpec) -> Box<dyn RodSegment>) -> Verdict {
    for x in [0.0, f64::MIN_POSITIVE, 1e-200, 1e-12, 1.0, 10.0, -10.0] {
        let rod = make(branch());
        answers(rod.as_ref(), x);
        if let Some(fault) = laws(rod.as_ref()).fault() {
            return Err(format!("at strains of about {x} and curvatures of about {} 1/m: {fault}", 100.0 * x));
        }
    }
    Ok("ok".into())
}

fn same_on_threads(rod: &dyn RodSegment) -> Verdict {
    threads(|k| answers(rod, 0.01 * k), || laws(rod).fault())
}
