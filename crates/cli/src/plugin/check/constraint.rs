//! Tests of constraints.

use super::trial::{CYCLES, Trial, Verdict, conformance, floating_point, leaks, parameters, threads, time};
use wireloom::geometry::{Matrix, Pose, Vector};
use wireloom::parts::{
    Action, Constraint, ConstraintKind, ConstraintSpec, ConstraintView, Form, Parameters, SpanSpec, SpanUse,
    StationSpec, Value,
};
use wireloom::testing::conformance::constraint::{Subject, checks};

/// Nodes of the span of a tested constraint.
const NODES: usize = 5;

/// Tests of a kind, by name.
pub fn trials(kind: &ConstraintKind) -> Vec<Trial<'_>> {
    let stations = (*kind.attaches.stations.start())
        .max(usize::from(kind.attaches.span != SpanUse::Always))
        .min(*kind.attaches.stations.end());
    let nodes = if kind.attaches.span == SpanUse::Never { 0 } else { NODES };
    let values = parameters(&kind.parameters);
    let mut all: Vec<Trial<'_>> = vec![];
    let what = "creation with typical values".to_owned();
    match made(kind, &values, stations, nodes) {
        Ok(first) => all.push((what, Box::new(move || Ok(acts(first.as_ref()).into())))),
        Err(why) => {
            all.push((what, Box::new(move || Err(why))));
            return all;
        }
    }
    // It was built once, so it can be built again.
    let make = move || made(kind, &values, stations, nodes).unwrap_or_else(|why| panic!("{why}"));
    let subject = Subject::new(make.clone(), stations, nodes);
    let listed: &'static [_] = checks(&subject);
    let subject = std::rc::Rc::new(subject);
    for (name, check) in listed {
        let subject = subject.clone();
        all.push(conformance(&kind.name, name, move || check(&subject)));
    }
    let maker = make.clone();
    all.push((
        "no crash with input that is not finite or extreme".into(),
        Box::new(move || extreme_input(&maker, stations, nodes)),
    ));
    all.push((
        "creation or refusal with all extreme parameters".into(),
        Box::new(move || extreme_parameters(kind, stations, nodes)),
    ));
    let maker = make.clone();
    all.push((
        "same numbers on several threads".into(),
        Box::new(move || same_on_threads(maker().as_ref(), stations, nodes)),
    ));
    let maker = make.clone();
    all.push((
        format!("no loss of memory, {CYCLES} times"),
        Box::new(move || leaks(|| drop(evaluate(maker().as_ref(), stations, nodes, 0.01)))),
    ));
    let evaluation = move || {
        let constraint = make();
        time(|| evaluate(constraint.as_ref(), stations, nodes, 0.01), "values and derivatives")
    };
    all.push(("time of an evaluation".into(), Box::new(evaluation)));
    all.push(floating_point(""));
    all
}

fn acts(constraint: &dyn Constraint) -> &'static str {
    match constraint.action() {
        Action::Prescribed(_) => "ok: prescribes",
        Action::Potential(_) => "ok: a potential",
        Action::Equations(_) => "ok: equations",
        Action::PotentialAndEquations(..) => "ok: a potential and equations",
    }
}

fn made(
    kind: &ConstraintKind,
    values: &Parameters,
    stations: usize,
    nodes: usize,
) -> Result<Box<dyn Constraint>, String> {
    let spec = ConstraintSpec {
        name: "trial".into(),
        stations: (0..stations)
            .map(|k| StationSpec { place: Some(("branch".into(), 0.1 * k as f64)), diameter: 0.01 })
            .collect(),
        span: (nodes > 0).then(|| SpanSpec { branch: "branch".into(), range: (0.0, 0.1), diameter: 0.01 }),
        tangent_given: true,
        up_given: true,
        ..ConstraintSpec::default()
    };
    (kind.build)(&spec, values).map_err(|error| error.message)
}

/// All values of a constraint with stations and nodes at these coordinates.
fn evaluate(constraint: &dyn Constraint, stations: usize, nodes: usize, x: f64) -> Vec<u64> {
    let pose = |k: usize, x: f64| Pose { position: Vector::new(x, 0.1 * k as f64, x), ..Pose::identity() };
    let at: Vec<Pose> = (0..stations).map(|k| pose(k, x)).collect();
    let targets: Vec<Pose> = (0..stations).map(|k| constraint.target(&pose(k, 0.02), 0.5)).collect();
    let span: Vec<Vector> = (0..nodes).map(|k| Vector::new(0.05 * k as f64, x, -x)).collect();
    let memory = constraint.memory();
    let lengths = vec![0.01; nodes];
    let at = ConstraintView {
        stations: &at,
        targets: &targets,
        span: &span,
        span_lengths: &lengths,
        progress: 0.5,
        memory: &memory,
        tensions: &[],
    };
    let mut remembered = memory.clone();
    let tensions = vec![[1.0, 2.0]; stations];
    let at_end = ConstraintView { tensions: &tensions, ..at };
    let outputs = constraint.outputs(&at_end);
    constraint.commit(&at_end, &mut remembered);
    let mut numbers: Vec<f64> = remembered.into_iter().chain(outputs.into_iter().map(|(_, value)| value)).collect();
    let second = |numbers: &mut Vec<f64>, fill: &dyn Fn(&mut [Matrix], &mut [Matrix])| {
        let mut blocks = vec![Matrix::zeros(); 4 * stations * stations];
        let mut of_span = vec![Matrix::zeros(); nodes];
        fill(&mut blocks, &mut of_span);
        numbers.extend(blocks.iter().chain(&of_span).flat_map(|block| block.iter().copied().collect::<Vec<_>>()));
    };
    let action = constraint.action();
    if let Some(potential) = action.potential() {
        let mut gradient = vec![Vector::zeros(); 2 * stations];
        let mut along = vec![Vector::zeros(); nodes];
        numbers.push(potential.energy(&at));
        numbers.push(potential.gradient(&at, &mut gradient, &mut along));
        numbers.extend(gradient.iter().chain(&along).flat_map(|v| [v.x, v.y, v.z]));
        second(&mut numbers, &|blocks, of_span| potential.hessian(&at, blocks, of_span));
    }
    if let Some(equations) = action.equations() {
        let (r, p) = (equations.of_stations().len(), equations.of_each_node().len());
        let mut c = vec![0.0; r + p * nodes];
        let mut jacobian = vec![Vector::zeros(); r * 2 * stations];
        let mut along = vec![Vector::zeros(); p * nodes];
        equations.residuals(&at, &mut c);
        equations.jacobian(&at, &mut c, &mut jacobian, &mut along);
        numbers.extend(jacobian.iter().chain(&along).flat_map(|v| [v.x, v.y, v.z]));
        second(&mut numbers, &|blocks, of_span| equations.curvature(&at, &c, blocks, of_span));
        numbers.extend(c);
    }
    numbers.iter().map(|x| x.to_bits()).collect()
}

type Make<'m> = dyn Fn() -> Box<dyn Constraint> + 'm;

/// Invalid positions must not crash the program, nor panic; they may be refused.
fn extreme_input(make: &Make<'_>, stations: usize, nodes: usize) -> Verdict {
    for x in [0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 1e200, -1e30, f64::MIN_POSITIVE] {
        let constraint = make();
        evaluate(constraint.as_ref(), stations, nodes, x);
        if let Some(fault) = constraint.fault().filter(|fault| fault.contains("panicked")) {
            return Err(format!("at {x}: {fault}"));
        }
        if let (Some(fault), true) = (constraint.fault(), x.abs() < 1e-3) {
            return Err(format!("at {x}: {fault}"));
        }
    }
    Ok("ok".into())
}

/// The ends of all ranges, one parameter after the other.
fn extreme_parameters(kind: &ConstraintKind, stations: usize, nodes: usize) -> Verdict {
    let mut tried = 0;
    for parameter in &kind.parameters {
        let ends = match &parameter.form {
            Form::Number { minimum, exclusive, maximum, .. } => {
                let low = if *exclusive { minimum + minimum.abs().max(1.0) * 1e-12 } else { *minimum };
                vec![Value::Number(low.max(-1e12)), Value::Number(maximum.min(1e12))]
            }
            Form::Vector { .. } => vec![Value::Vector(Vector::zeros()), Value::Vector(Vector::repeat(1e12))],
            Form::Count { minimum } => vec![Value::Count(*minimum), Value::Count(minimum + 1000)],
            Form::Flag => vec![Value::Flag(true)],
            Form::Choice(words) => words.iter().cloned().map(Value::Word).collect(),
        };
        for end in ends {
            let mut values = parameters(&kind.parameters);
            values.0.insert(parameter.name.clone(), end.clone());
            tried += 1;
            let fault = match made(kind, &values, stations, nodes) {
                Ok(constraint) => {
                    evaluate(constraint.as_ref(), stations, nodes, 0.1);
                    constraint.fault()
                }
                Err(message) => Some(message).filter(|message| message.contains("panicked")),
            };
            if let Some(fault) = fault {
                return Err(format!("with {} = {end:?}: {fault}", parameter.name));
            }
        }
    }
    Ok(format!("ok ({tried} values)"))
}

fn same_on_threads(constraint: &dyn Constraint, stations: usize, nodes: usize) -> Verdict {
    threads(|k| evaluate(constraint, stations, nodes, 0.01 * k), || constraint.fault())
}
