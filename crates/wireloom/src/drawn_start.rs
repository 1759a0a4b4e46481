//! Whether a run ends where the harness would come to rest from its drawn lines, and why not.
//!
//! A harness can have several equilibria under the same constraints: which of them it reaches depends on the way. Here
//! the constraints, gravity and loads at the end of a run act on the harness laid along its drawn lines; the
//! equilibrium from there is compared with the end of the run.

use wireloom_core::Status;
use wireloom_core::equilibrium::{DrawnStart, EndsElsewhere, OperationResult, Run, SlideResult, StepResult};
use wireloom_core::network::{AttachedConstraint, Joint};
use wireloom_core::rotation::columns;
use wireloom_core::steps::Step;
use wireloom_core::{Monitor, Registry, Vector};
use wireloom_export::ending::BranchEnd;
use wireloom_scenario::{At, Constraint, Facing, Scenario};
use wireloom_solve::steps::checkpoint::Observer;
use wireloom_solve::{Control, Progress};

/// Difference of twist that is another turn, turns.
const ANOTHER_TURN: f64 = 0.5;

/// Names in a sentence; of more, their number.
const NAMES: usize = 6;

/// Compares the end of a run of `scenario` with the equilibrium that the harness reaches under the same constraints
/// from its drawn lines. `None` where the harness starts along its drawn lines or has none, where there are no steps,
/// and where the run did not converge. `registry` is the one the scenario was read with; `monitor` can stop the search
/// for that equilibrium.
pub fn compare_with_drawn_start(
    scenario: &Scenario,
    run: &Run,
    registry: &Registry,
    monitor: &Monitor,
) -> Option<DrawnStart> {
    let apart = scenario.branches.iter().any(|branch| !branch.own_drawn.is_empty());
    let all = scenario.branches.iter().all(|branch| branch.drawn().len() >= 2);
    let end = run.steps.last().filter(|_| run.status() == Status::Converged)?;
    if !apart || !all || scenario.steps.is_empty() {
        return None;
    }
    let compared = from_drawn(scenario, run, end).and_then(|from_drawn| {
        let built = from_drawn.build(registry).map_err(|faults| {
            faults.first().map_or_else(|| "it cannot be built".to_owned(), |fault| fault.message.clone())
        })?;
        let is_spring = |own: &&AttachedConstraint| own.model.action().potential().is_some();
        if let Some(spring) = built.network.constraints.iter().find(is_spring) {
            return Err(format!(
                "constraint \"{}\" is a spring, and results do not say where it pulls to",
                spring.name
            ));
        }
        if let Some(branch) = built.network.branches.iter().find(|branch| branch.remembers()) {
            return Err(format!("branch \"{}\" keeps a set from the way there", branch.name));
        }
        let remembers = |joint: &&Joint| !joint.model.memory().is_empty();
        if let Some(joint) = built.network.joints.iter().find(remembers) {
            return Err(format!("joint \"{}\" keeps a set from the way there", joint.name));
        }
        let other = crate::run_observed(built, None, &mut Monitored(monitor));
        match (other.status(), other.steps.into_iter().next_back()) {
            (Status::Converged, Some(other)) => Ok(compare(end, &other)),
            (status, _) => Err(format!("that equilibrium was not found ({})", status.word())),
        }
    });
    Some(compared.unwrap_or_else(|why| DrawnStart { not_compared: Some(why), ..DrawnStart::default() }))
}

/// Does nothing but stop where the monitor is told to.
struct Monitored<'a>(&'a Monitor);

impl Observer for Monitored<'_> {
    fn increment(&mut self, _: &Progress, _: &StepResult, _: bool) -> Control {
        Control::Continue
    }

    fn monitor(&self) -> Monitor {
        self.0.clone()
    }
}

/// The harness at the end of a run as a scenario of one equilibrium that starts along the drawn lines; why it cannot be
/// one.
fn from_drawn(scenario: &Scenario, run: &Run, end: &StepResult) -> Result<Scenario, String> {
    let steps = &scenario.steps;
    let any = |what: fn(&Step) -> bool| steps.iter().any(what);
    let reasons = [
        (!scenario.mechanisms.is_empty(), "the harness is mounted on mechanisms"),
        (any(|step| !step.obstacle_moves.is_empty()), "obstacles move"),
        (any(|step| !step.temperatures.is_empty()), "temperatures change"),
        (any(|step| step.angular_velocity.is_some()), "the axes begin to rotate"),
    ];
    if let Some((_, why)) = reasons.into_iter().find(|(applies, _)| *applies) {
        return Err(why.to_owned());
    }
    let mut other = scenario.clone();
    for branch in &mut other.branches {
        branch.path = branch.drawn().to_vec();
    }
    other.gravity = steps.iter().rev().find_map(|step| step.gravity).unwrap_or(scenario.gravity);
    for (load, factor) in steps.iter().flat_map(|step| &step.loads) {
        other.loads[*load].factor = *factor;
    }
    let mut constraints = Vec::new();
    for held in &end.constraints {
        // The last constraint of a name is the one that acts at the end.
        let own = scenario.constraints.iter().rev().find(|own| own.name == held.name);
        let Some(own) = own else { return Err(format!("constraint \"{}\" is not of the scenario", held.name)) };
        if own.at.len() != 1 || own.span.is_some() {
            return Err(format!("constraint \"{}\" does not act at one place", own.name));
        }
        let facing = match (own.up_given, own.tangent_given) {
            (true, _) => Facing::Orientation(held.orientation),
            (false, true) => Facing::Tangent(columns(&held.orientation)[2]),
            (false, false) => own.facing,
        };
        let at = if own.nearest { closed_at(scenario, run, own).unwrap_or(own.at[0]) } else { own.at[0] };
        let position = Some(held.position);
        let acts = Constraint { position, facing, at: vec![at], nearest: false, from_start: true, ..own.clone() };
        constraints.push(acts);
    }
    (other.constraints, other.initial) = (constraints, None);
    other.steps.clear();
    other.step_spans.clear();
    other.requirements.clear();
    (other.sweep, other.optimise) = (None, None);
    Ok(other)
}

/// The place where a clip closed.
fn closed_at(scenario: &Scenario, run: &Run, own: &Constraint) -> Option<At> {
    let operations = run.steps.iter().rev().flat_map(|step| &step.operations);
    let mut closed = operations.filter_map(|operation| match operation {
        OperationResult::Clip { constraint, place, .. } if *constraint == own.name => place.clone(),
        _ => None,
    });
    let (name, s) = closed.next()?;
    let branch = scenario.branches.iter().position(|branch| branch.name == name)?;
    Some(At::Branch { branch, s })
}

fn compare(end: &StepResult, other: &StepResult) -> DrawnStart {
    let mut branches = Vec::new();
    let mut turned = Vec::new();
    for (own, from_drawn) in end.branches.iter().zip(&other.branches) {
        let line = BranchEnd::of(from_drawn);
        let apart =
            own.s.iter().zip(&own.position).map(|(s, x): (&f64, &Vector)| ((x - line.position_at(*s)).norm(), *s));
        let turns = own.twist_turns - from_drawn.twist_turns;
        if turns.abs() > ANOTHER_TURN {
            turned.push(format!("`{}` ({turns:+.1})", own.name));
        }
        let farthest = apart.max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, s)) =
            farthest.filter(|(distance, _)| *distance > own.diameter || turns.abs() > ANOTHER_TURN)
        {
            branches.push(EndsElsewhere { name: own.name.clone(), distance, s, turns });
        }
    }
    branches.sort_by(|a, b| b.distance.total_cmp(&a.distance));
    let energy = end.energy.total() - other.energy.total();
    let why = if branches.is_empty() { Vec::new() } else { reasons(end, other, energy, &turned) };
    DrawnStart { not_compared: None, branches, energy: Some(energy), why }
}

/// Why the end of a run is another equilibrium.
fn reasons(end: &StepResult, other: &StepResult, energy: f64, turned: &[String]) -> Vec<String> {
    let mut why = Vec::new();
    if !turned.is_empty() {
        why.push(format!("whole turns of twist have remained from the way there, in turns: {}", listed(turned)));
    }
    let slid: Vec<String> = (end.constraints.iter())
        .filter_map(|held| {
            let from_drawn = other.constraints.iter().find(|own| own.name == held.name)?.slide.as_ref()?;
            let SlideResult { branch, arc_length, .. } = held.slide.as_ref()?;
            let diameter = end.branches.iter().find(|own| own.name == *branch)?.diameter;
            let moved = arc_length - from_drawn.arc_length;
            (moved.abs() > diameter).then(|| format!("`{}` ({:+.0} mm)", held.name, 1e3 * moved))
        })
        .collect();
    if !slid.is_empty() {
        why.push(format!("the cable has run through guides by another length: {}", listed(&slid)));
    }
    let lower = if energy < 0.0 { "lower" } else { "higher" };
    let rest = if why.is_empty() { "both have the same twist and guides; " } else { "" };
    why.push(format!(
        "{rest}under the same constraints the harness has several equilibria, and the way decides between them: the \
         energy at the end of the run is {:.4} J {lower} than from the drawn start",
        energy.abs()
    ));
    if other.stable == Some(false) || end.stable == Some(false) {
        why.push("one of the two equilibria is not stable".to_owned());
    }
    why
}

fn listed(names: &[String]) -> String {
    match names.len().checked_sub(NAMES) {
        None | Some(0) => names.join(", "),
        Some(more) => format!("{} and {more} more", names[..NAMES].join(", ")),
    }
}
