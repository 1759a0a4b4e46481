//! Drag-step times: how long one small move of a held end takes, on the machine at hand; the minimisers side by side, a
//! harness that lies on a body, and a sweep of many points.

mod contact;
mod device;
mod minimisers;
mod monte_carlo;

pub use contact::{ContactCost, Tilting, contact};
pub use device::{OnDevice, on_device};
pub use minimisers::{Contender, minimisers};
pub use monte_carlo::{MonteCarlo, monte_carlo};

use std::time::Instant;
use wireloom_core::constraint::{ConstraintSpec, HoldWord, Limits};
use wireloom_core::joint::{Arm, ArmSpring, JointSpec};
use wireloom_core::network::{BranchPlan, ConstraintPlan, JointPlan, Place};
use wireloom_core::registry::Parameters;
use wireloom_core::rod::{Mesh, RodSpec};
use wireloom_core::rotation::{columns, frame_from};
use wireloom_core::section::{FrictionElement, SectionFriction};
use wireloom_core::steps::{Initial, Schedule};
use wireloom_core::{Conditions, Minimiser, Network, Pose, Problem, Rotation, Section, State, Status, Stop, Vector};
use wireloom_import::kbl::{Arrangement, Options};
use wireloom_models::joints::cosserat::CosseratJoint;
use wireloom_models::rods::cosserat;
use wireloom_scenario::Built;
use wireloom_solve::Control;
use wireloom_solve::minimisers::newton::Newton;
use wireloom_solve::steps::certificate::Certifier;

/// Length of a drag step, m.
const STRIDE: f64 = 0.005;

/// One measured case.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// `drag` for the single cable, `drag-harness` for the branched one, and so on.
    pub case: &'static str,
    /// Segments in all.
    pub segments: usize,
    /// Threads that share the work.
    pub threads: usize,
    /// Median time of a step out and of a step back, s.
    pub seconds_out: f64,
    /// Likewise.
    pub seconds_back: f64,
    /// Mean of the two medians, s.
    pub seconds_per_step: f64,
    /// Mean number of linear solves in a step.
    pub iterations_per_step: f64,
    /// Mean number of evaluations of the gradient in a step.
    pub evaluations_per_step: f64,
    /// Mean number of factorisations in a step.
    pub factorisations_per_step: f64,
    /// Largest relative residual after any step, recomputed.
    pub residual: f64,
    /// Steps that did not converge.
    pub failures: usize,
}

fn section(bending: f64, torsion: f64, axial: f64, density: f64) -> Section {
    Section {
        name: "cable".into(),
        diameter: 0.006,
        linear_density: density,
        axial_stiffness: axial,
        shear_stiffness: [axial / 2.6; 2],
        bending_stiffness: [bending; 2],
        torsion_stiffness: torsion,
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

fn branch(name: String, section: &Section, length: f64, segments: usize, stations: Vec<usize>) -> BranchPlan {
    let mesh = Mesh::new(vec![length / segments as f64; segments], stations);
    let spec = RodSpec { name: name.clone(), sections: section.clone().into(), mesh, curvature: Vector::zeros() };
    let (kind, rod) = ("cosserat".into(), Box::new(cosserat::rod(spec)));
    BranchPlan { name, kind, sections: section.clone().into(), rod, path: vec![], drawn: vec![] }
}

fn connector(name: &str, branch: usize, node: usize) -> ConstraintPlan {
    let words = [HoldWord::Position, HoldWord::Tangent, HoldWord::Twist];
    let spec = ConstraintSpec { name: name.into(), hold: Some(words.to_vec()), ..ConstraintSpec::default() };
    let kind = wireloom_models::constraints::connector();
    ConstraintPlan {
        name: name.into(),
        kind: kind.name.clone(),
        model: (kind.build)(&spec, &Parameters::default()).expect("a connector holds everything"),
        outputs: Vec::new(),
        stations: vec![Place::Node { branch, node }],
        span: None,
        position: None,
        tangent: None,
        orientation: None,
        mount: None,
        slide: None,
        limits: Limits::default(),
        nearest: false,
        from_start: true,
    }
}

/// A 1 m cable (EI 0.01, GJ 0.008, EA 1e4, 0.05 kg/m), clamped at both ends.
pub fn cable(segments: usize) -> Network {
    clamped(&section(0.01, 0.008, 1e4, 0.05), segments)
}

/// The same cable with wires that slip on each other: half of EI and a quarter of GJ are those of elements of friction,
/// of which some slip in a drag.
pub fn cable_with_friction(segments: usize) -> Network {
    let element = |stiffness: f64, moment: f64| FrictionElement { stiffness, moment };
    let bending = vec![element(0.003, 0.005), element(0.002, 0.02)];
    let friction = SectionFriction { bending, torsion: vec![element(0.002, 0.005)] };
    clamped(&Section { friction, ..section(0.005, 0.006, 1e4, 0.05) }, segments)
}

fn clamped(section: &Section, segments: usize) -> Network {
    Network::new(
        vec![branch("cable".into(), section, 1.0, segments, vec![0, segments])],
        vec![],
        vec![connector("a", 0, 0), connector("b", 0, segments)],
        vec![],
    )
}

/// A tree of 100 branches of 100 segments with 40 joints: a trunk of 41 branches, from whose joints 59 branches
/// leave to free ends (one or two at each joint), with a connector at either end of the trunk.
pub fn harness() -> Network {
    const JOINTS: usize = 40;
    const SEGMENTS: usize = 100;
    let trunk = section(0.02, 0.016, 2e4, 0.08);
    let side = section(0.006, 0.005, 1e4, 0.03);
    let (mut branches, mut arms) = (vec![], vec![vec![]; JOINTS]);
    let arm = |name: &str, section: &Section, starts_here, direction: Vector, length: f64| Arm {
        branch: name.into(),
        starts_here,
        rest: frame_from(&direction, &Vector::z()).expect("not along z"),
        offset: Vector::zeros(),
        section: section.clone(),
        segment_length: length / SEGMENTS as f64,
        length,
        curvature: Vector::zeros(),
        spring: ArmSpring::default(),
    };
    for k in 0..=JOINTS {
        let name = format!("trunk-{k}");
        branches.push(branch(name.clone(), &trunk, 0.1, SEGMENTS, vec![0, SEGMENTS]));
        if k > 0 {
            arms[k - 1].push((k, arm(&name, &trunk, true, Vector::x(), 0.1)));
        }
        if k < JOINTS {
            arms[k].push((k, arm(&name, &trunk, false, Vector::x(), 0.1)));
        }
    }
    for k in 0..100 - (JOINTS + 1) {
        let name = format!("side-{k}");
        let direction = Vector::new(0.5, if k < JOINTS { 1.0 } else { -1.0 }, 0.0);
        arms[k % JOINTS].push((branches.len(), arm(&name, &side, true, direction, 0.2)));
        branches.push(branch(name, &side, 0.2, SEGMENTS, vec![0, SEGMENTS]));
    }
    let joints = arms
        .into_iter()
        .enumerate()
        .map(|(k, arms)| {
            let (branches, arms): (Vec<usize>, Vec<Arm>) = arms.into_iter().unzip();
            let spec = JointSpec { name: format!("J{k}"), arms: arms.clone(), wires: vec![] };
            JointPlan {
                name: spec.name.clone(),
                kind: "cosserat".into(),
                model: Box::new(CosseratJoint::new(&spec, None).expect("no offsets")),
                arms,
                branches,
                mass: 0.0,
            }
        })
        .collect();
    Network::new(branches, joints, vec![connector("a", 0, 0), connector("b", JOINTS, SEGMENTS)], vec![])
}

/// Hangs a network by moving constraint 1 from where the rest shape has it by `shift`, then drags it out along
/// `outward` and back, `strokes` times `steps` steps of 5 mm each way, to a relative residual of 1e-8.
pub fn drag(
    case: &'static str,
    network: &Network,
    shift: Vector,
    outward: Vector,
    strokes: usize,
    steps: usize,
) -> Case {
    let stop = Stop { force_tolerance: 1e-8, max_iterations: 200 };
    let mut newton = Newton::new();
    let hung = hung(network, &mut newton, &stop, shift);
    stroke(case, hung, &mut newton, &stop, 1, outward, (strokes, steps))
}

/// Moves a constraint out and back, so many strokes of so many steps each way.
fn stroke(
    case: &'static str,
    (mut problem, mut state): (Problem<'_>, State),
    minimiser: &mut dyn Minimiser,
    stop: &Stop,
    constraint: usize,
    outward: Vector,
    (strokes, steps): (usize, usize),
) -> Case {
    let network = problem.network;
    let mut certifier = Certifier::new(network);
    let (problem, state) = (&mut problem, &mut state);
    let mut target = problem.conditions().targets[constraint];
    let mut times = [vec![], vec![]];
    let (mut iterations, mut evaluations, mut factorisations, mut residual, mut failures) = (0, 0, 0, 0.0_f64, 0);
    for _ in 0..strokes {
        for (direction, times) in [outward, -outward].iter().zip(&mut times) {
            for _ in 0..steps {
                target.position += direction * STRIDE;
                let clock = Instant::now();
                problem.set_target(constraint, target);
                let report = minimiser.minimise(problem, state, stop);
                let taken = clock.elapsed();
                let certificate = certifier.certify(problem, state, stop, report.status);
                // What a cable remembers belongs to the step, and follows from the state that was certified.
                let clock = Instant::now();
                problem.commit_rods_and_joints(state);
                times.push((taken + clock.elapsed()).as_secs_f64());
                iterations += report.iterations;
                evaluations += report.evaluations;
                factorisations += report.factorisations;
                residual = residual.max(certificate.residual);
                failures += usize::from(certificate.grade != Status::Converged);
            }
        }
    }
    let count = (2 * strokes * steps) as f64;
    let [out, back] = times.map(|mut all| {
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    });
    Case {
        case,
        segments: network.branches.iter().map(|b| b.rod.mesh().segments()).sum(),
        threads: if network.is_shared() { rayon::current_num_threads() } else { 1 },
        seconds_out: out,
        seconds_back: back,
        seconds_per_step: 0.5 * (out + back),
        iterations_per_step: iterations as f64 / count,
        evaluations_per_step: evaluations as f64 / count,
        factorisations_per_step: factorisations as f64 / count,
        residual,
        failures,
    }
}

/// The longest distance between nodes at which an installed harness is dragged, m.
const DRAG_SPACING: f64 = 0.005;

/// A connector of a harness from a KBL file, hung as it is installed, pushed back towards its cable and out again, to
/// the usual tolerance: the connector at the end of the longest branch.
///
/// # Errors
/// If the file cannot be read.
pub fn drag_installed(kbl: &str) -> Result<Case, String> {
    let built = imported(kbl, Arrangement::Installed, DRAG_SPACING, "")?;
    let (network, stop) = (&built.network, built.stop);
    let mut state = wireloom_solve::start::layout::place(network, &built.schedule);
    let mut conditions = Conditions::new(network, built.schedule.gravity, &state);
    conditions.load_factors.fill(1.0);
    conditions.active.fill(true);
    let mut problem = Problem::new(network, conditions);
    let mut newton = Newton::new();
    newton.minimise(&mut problem, &mut state, &Stop { max_iterations: 20_000, ..stop });
    let ends = network.constraints.iter().enumerate().filter_map(|(f, constraint)| match constraint.place {
        Place::Node { branch, node } if constraint.kind == "connector" => {
            let mesh = network.branches[branch].rod.mesh();
            let outward = if node == 0 { -1.0 } else { 1.0 };
            Some((mesh.length(), f, -outward * columns(&state.pose(&constraint.site).orientation)[2]))
        }
        _ => None,
    });
    let (_, constraint, back) = ends.max_by(|a, b| a.0.total_cmp(&b.0)).ok_or("the harness has no connector")?;
    Ok(stroke("drag-installed", (problem, state), &mut newton, &stop, constraint, back, (5, 5)))
}

/// A harness from a KBL file carried through its steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Installation {
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Steps carried out.
    pub steps: usize,
    /// Increments carried out.
    pub increments: usize,
    /// Increments that did not converge.
    pub failures: usize,
    /// Iterations in all.
    pub iterations: usize,
    /// All in all, s.
    pub seconds: f64,
}

/// The longest distance between nodes at which a harness is installed, m.
const INSTALL_SPACING: f64 = 0.010;

/// A harness from a KBL file brought from the board into the vehicle.
///
/// # Errors
/// If the file cannot be read.
pub fn install(kbl: &str) -> Result<Installation, String> {
    Ok(carried_out(imported(kbl, Arrangement::Assembly, INSTALL_SPACING, "")?))
}

/// A harness from a KBL file that comes to rest where it is installed, with contact among all its cables.
///
/// # Errors
/// If the file cannot be read.
pub fn rest_among_cables(kbl: &str) -> Result<Installation, String> {
    Ok(carried_out(imported(kbl, Arrangement::Installed, INSTALL_SPACING, "\n[contact]\ncables = true\n")?))
}

fn carried_out(built: Built) -> Installation {
    let nodes = built.network.branches.iter().map(|b| b.rod.mesh().nodes()).sum();
    let clock = Instant::now();
    let (mut increments, mut failures) = (0, 0);
    let run = crate::run(built, &mut |_, end| {
        increments += 1;
        failures += usize::from(end.status != Status::Converged);
        Control::Continue
    });
    let iterations =
        run.steps.iter().filter(|end| end.increment == end.increments).map(|end| end.minimiser.iterations).sum();
    Installation {
        nodes,
        steps: run.steps.len(),
        increments,
        failures,
        iterations,
        seconds: clock.elapsed().as_secs_f64(),
    }
}

/// The scenario of a KBL file, with some text after it.
fn imported(kbl: &str, arrangement: Arrangement, max_segment: f64, more: &str) -> Result<Built, String> {
    let options = Options { arrangement, max_segment, ..Options::default() };
    let imported = wireloom_import::kbl::import(kbl, &options).map_err(|error| error.to_string())?;
    let text = imported.scenario + more;
    let loaded = crate::load(&text, &crate::registry());
    loaded.map(|(_, built)| built).map_err(|faults| wireloom_scenario::render(&text, &faults))
}

/// The first branch laid along x from the origin, under gravity.
pub fn schedule() -> Schedule {
    let orientation: Rotation = frame_from(&Vector::x(), &Vector::z()).expect("not parallel");
    Schedule {
        scenario: String::new(),
        gravity: Vector::new(0.0, 0.0, -9.81),
        rotation: Default::default(),
        initial: Some(Initial { branch: 0, pose: Pose { position: Vector::zeros(), orientation } }),
        steps: vec![],
        increments: false,
        clearances: false,
        identities: Default::default(),
    }
}

/// The rest shape along x under gravity, then constraint 1 moved by `shift` in increments.
fn hung<'n>(network: &'n Network, newton: &mut Newton, stop: &Stop, shift: Vector) -> (Problem<'n>, State) {
    let schedule = schedule();
    let mut state = wireloom_solve::start::layout::place(network, &schedule);
    let conditions = Conditions::new(network, schedule.gravity, &state);
    let mut problem = Problem::new(network, conditions);
    let mut target = problem.conditions().targets[1];
    let increments = (shift.norm() / 0.01).ceil().max(1.0);
    for _ in 0..increments as usize {
        target.position += shift / increments;
        problem.set_target(1, target);
        newton.minimise(&mut problem, &mut state, stop);
    }
    (problem, state)
}

/// The cases of the benchmark, on one thread: the cable with 100, 1,000 and 10,000 segments, that of 1,000 with
/// friction within its section, and the branched harness.
///
/// # Panics
/// If the system has no thread left.
pub fn all() -> Vec<Case> {
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    alone.install(|| {
        let shift = Vector::new(-0.4, 0.0, 0.0);
        let mut cases: Vec<Case> = [(100, 40), (1_000, 20), (10_000, 4)]
            .into_iter()
            .map(|(segments, strokes)| drag("drag", &cable(segments), shift, Vector::x(), strokes, 10))
            .collect();
        cases.push(drag("drag-friction", &cable_with_friction(1_000), shift, Vector::x(), 20, 10));
        cases.push(drag("drag-harness", &harness(), Vector::new(-0.8, 0.0, 0.0), Vector::x(), 4, 10));
        cases
    })
}
