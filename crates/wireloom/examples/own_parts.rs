//! A rod, a joint and a minimiser of one's own: each is registered under a name, and scenarios choose it by that name,
//! as they choose built-in ones.
//!
//! `cargo run -p wireloom --example own_parts`
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use std::cell::Cell;
use std::rc::Rc;
use wireloom::geometry::{Matrix, Rotation, Vector};
use wireloom::harness::{Problem, State};
use wireloom::parts::kernel::BendTwist;
use wireloom::parts::rods::cosserat;
use wireloom::parts::{
    Form, JointKind, JointModel, JointShape, JointSpec, Minimiser, MinimiserKind, Mounting, Newton, Parameter,
    Quantity, Report, RodKind, Stop, Value,
};
use wireloom::{Control, Registry, Status};

/// The rod `taped`: tape makes the bundle bend harder than its section says, by a factor that the scenario may give for
/// each branch.
fn taped() -> RodKind {
    let factor = Parameter {
        name: "factor".into(),
        doc: "how many times as hard it bends".into(),
        form: Form::Number { quantity: Quantity::Dimensionless, minimum: 1.0, exclusive: false, maximum: 100.0 },
        default: Some(Value::Number(1.5)),
        required: false,
    };
    RodKind {
        name: "taped".into(),
        doc: "a Cosserat rod that tape makes stiffer in bending".into(),
        parameters: vec![factor],
        build: Box::new(|spec, values| {
            let mut spec = spec.clone();
            let factor = values.number("factor").unwrap_or(1.0);
            for section in spec.sections.iter_mut() {
                section.bending_stiffness = section.bending_stiffness.map(|ei| factor * ei);
            }
            Ok(Box::new(cosserat::rod(spec)))
        }),
    }
}

/// The joint `ball`: every pair of arms is held by the same rotational spring, whatever wires run between them.
struct Ball {
    /// Rest frames of the arms in the joint's frame.
    rest: Vec<Rotation>,
    /// N m/rad.
    stiffness: f64,
}

impl Ball {
    fn kind() -> JointKind {
        let stiffness = Parameter {
            name: "stiffness".into(),
            doc: "of the spring between each pair of arms".into(),
            form: Form::Number { quantity: Quantity::MomentPerAngle, minimum: 0.0, exclusive: true, maximum: 1e6 },
            default: None,
            required: true,
        };
        JointKind {
            name: "ball".into(),
            doc: "every pair of arms is held by the same spring".into(),
            parameters: vec![stiffness],
            build: Box::new(|spec: &JointSpec, values| {
                let rest = spec.arms.iter().map(|arm| arm.rest).collect();
                Ok(Box::new(Ball { rest, stiffness: values.number("stiffness").unwrap_or_default() }))
            }),
        }
    }

    /// For each pair of arms `E = ½ k φ²`, φ the turn of the joint's frame as arm b has it relative to that as arm a
    /// has it: the law of bending and twist at a distance of 1 m.
    fn pairs<'a>(&'a self, frames: &'a [Rotation]) -> impl Iterator<Item = (usize, usize, BendTwist)> + 'a {
        let c = Vector::repeat(self.stiffness);
        let seen = |a: usize| frames[a] * self.rest[a].inverse();
        let all = (0..frames.len()).flat_map(move |b| (0..b).map(move |a| (a, b)));
        all.map(move |(a, b)| (a, b, BendTwist::new(&seen(a), &seen(b), 1.0, &c, &Vector::zeros())))
    }
}

impl JointModel for Ball {
    fn mounting(&self) -> Mounting {
        Mounting::Point
    }

    fn energy(&self, shape: &JointShape<'_>) -> f64 {
        self.pairs(shape.frames).map(|(_, _, pair)| pair.energy(1.0)).map(|(bend, twist)| bend + twist).sum()
    }

    fn add_gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> f64 {
        for (a, b, pair) in self.pairs(shape.frames) {
            let (first, second) = pair.gradient();
            // A turn θ of the arm's own frame is one of `rest θ` of the joint's frame.
            gradient[a] += self.rest[a].inverse() * first;
            gradient[b] += self.rest[b].inverse() * second;
        }
        self.energy(shape)
    }

    fn add_hessian(&self, shape: &JointShape<'_>, hessian: &mut [Matrix]) {
        let k = shape.frames.len();
        let turned = |a: usize| self.rest[a].to_rotation_matrix().into_inner();
        for (a, b, pair) in self.pairs(shape.frames) {
            let h = pair.hessian(&Vector::repeat(self.stiffness));
            let (ra, rb) = (turned(a), turned(b));
            hessian[a * k + a] += ra.transpose() * h.aa * ra;
            hessian[b * k + b] += rb.transpose() * h.bb * rb;
            hessian[b * k + a] += rb.transpose() * h.ab.transpose() * ra;
        }
    }
}

/// The minimiser `counted`: Newton's method, whose iterations somebody counts.
struct Counted(Newton, Rc<Cell<usize>>);

impl Minimiser for Counted {
    fn name(&self) -> &str {
        "counted"
    }

    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        let report = self.0.minimise(problem, state, stop);
        self.1.set(self.1.get() + report.iterations);
        report
    }

    fn forget(&mut self) {
        self.0.forget();
    }
}

thread_local! {
    static ITERATIONS: Rc<Cell<usize>> = Rc::default();
}

fn counted() -> MinimiserKind {
    MinimiserKind {
        name: "counted".into(),
        doc: "Newton's method, counted".into(),
        parameters: vec![],
        build: Box::new(|(), _| Ok(Box::new(Counted(Newton::new(), ITERATIONS.with(Rc::clone))))),
    }
}

/// Where the joint of the harness ends, m, and the status of the run.
fn solved(text: &str, registry: &Registry) -> Result<(Vector, Status), String> {
    let (_, built) = wireloom::load(text, registry).map_err(|faults| wireloom::scenario::render(text, &faults))?;
    let run = wireloom::run(built, &mut |_, _| Control::Continue);
    let end = run.steps.last().ok_or("a run has a step")?;
    Ok((end.joints[0].position, run.status()))
}

fn main() -> Result<(), String> {
    let mut registry = wireloom::registry();
    let taken = |_| "the name is taken".to_owned();
    registry.add_rod(taped()).map_err(|kind| taken(kind.name))?;
    registry.add_joint(Ball::kind()).map_err(|kind| taken(kind.name))?;
    registry.add_minimiser(counted()).map_err(|kind| taken(kind.name))?;

    let built_in = include_str!("../../../scenarios/branches/y_cosserat.toml");
    let own = built_in
        .replace("section = \"trunk\"", "section = \"trunk\"\nrod = \"taped\"\nfactor = 2.0")
        .replace("model = \"cosserat\"", "model = \"ball\"\nstiffness = \"2 N m/rad\"")
        + "\n[minimiser]\nkind = \"counted\"\n";
    for text in [built_in, own.as_str()] {
        let (joint, status) = solved(text, &registry)?;
        let [x, y, z] = (1e3 * joint).into();
        println!("{}: the joint ends at ({x:.1}, {y:.1}, {z:.1}) mm", status.word());
    }
    println!("{} iterations", ITERATIONS.with(|count| count.get()));
    Ok(())
}
