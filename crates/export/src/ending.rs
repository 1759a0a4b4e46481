//! The last equilibrium of a run and its sheet, as far as runs are compared: from a run ([`Ending::of`]) or from its
//! `result.json` ([`crate::json::read`]).

use crate::curve::Curve;
use wireloom_core::equilibrium::{
    BranchResult, ConstraintResult, Energy, OperationResult, RequirementResult, Run, SlideResult, StepResult,
};
use wireloom_core::requirement::{Verdict, with_distinct_names};
use wireloom_core::rotation::columns;
use wireloom_core::{EventKind, Status, Vector};

/// The last equilibrium of a run, with the events and the work of all steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Ending {
    /// Name of the scenario.
    pub scenario: String,
    /// Word for the status of the run.
    pub status: String,
    /// Whether the run converged.
    pub converged: bool,
    /// Verdict on the harness over the whole run.
    pub verdict: Verdict,
    /// The sheet of the whole run, with distinct names.
    pub requirements: Vec<RequirementResult>,
    /// Whether the equilibrium is stable; `None` where it was not determined.
    pub stable: Option<bool>,
    /// Branches, in the order of the scenario.
    pub branches: Vec<BranchEnd>,
    /// Constraints that act.
    pub constraints: Vec<ConstraintEnd>,
    /// Places where clips closed and grasps took hold, over all steps.
    pub closed: Vec<Closed>,
    /// Energy by effect, J.
    pub energy: Energy,
    /// Number of events of each kind.
    pub events: Vec<(EventKind, usize)>,
    /// Iterations over all steps.
    pub iterations: usize,
    /// Iterations among them that another minimiser made to finish.
    pub polish: usize,
    /// Factorisations over all steps.
    pub factorisations: usize,
    /// Time over all steps, s.
    pub seconds: f64,
    /// Kind of the minimiser.
    pub minimiser: String,
}

/// A branch in the last equilibrium; vectors have one entry for each node.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchEnd {
    /// Name.
    pub name: String,
    /// Arc length, m.
    pub s: Vec<f64>,
    /// Position, m, world.
    pub position: Vec<Vector>,
    /// Tangent d3.
    pub tangent: Vec<Vector>,
    /// Bend radius, m; infinite where straight.
    pub bend_radius: Vec<f64>,
    /// Total material twist, turns.
    pub twist_turns: f64,
}

/// A constraint in the last equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstraintEnd {
    /// Name.
    pub name: String,
    /// Held point, m.
    pub position: Vector,
    /// Force on the harness, N, world.
    pub force: Vector,
    /// Moment on the harness about the held point, N m, world.
    pub moment: Vector,
    /// Branch and arc length (m) at the constraint, where the cable slides through it.
    pub slide: Option<(String, f64)>,
    /// Outputs of its kind: names and values, SI.
    pub outputs: Vec<(String, f64)>,
}

/// Place on the cable where a constraint closed.
#[derive(Clone, Debug, PartialEq)]
pub struct Closed {
    /// Name of the constraint.
    pub constraint: String,
    /// Branch and arc length, m; none at a joint.
    pub place: Option<(String, f64)>,
}

impl Ending {
    /// Of a run; `None` where nothing was computed.
    pub fn of(run: &Run) -> Option<Self> {
        let end = run.steps.last()?;
        let mut way = Way::default();
        for step in &run.steps {
            way.add(&step.name, step.increment, Work::of(step), step.operations.iter().filter_map(Closed::of));
        }
        let (work, closed) = way.sums();
        Some(Self {
            scenario: run.scenario.clone(),
            status: run.status().word().to_owned(),
            converged: run.status() == Status::Converged,
            verdict: run.verdict(),
            requirements: with_distinct_names(&run.requirements),
            stable: end.stable,
            branches: end.branches.iter().map(BranchEnd::of).collect(),
            constraints: end.constraints.iter().map(ConstraintEnd::of).collect(),
            closed,
            energy: end.energy,
            events: count(run.events.iter().map(|event| event.kind)),
            iterations: work.iterations,
            polish: work.polish,
            factorisations: work.factorisations,
            seconds: work.seconds,
            minimiser: end.minimiser.kind.clone(),
        })
    }

    /// The tightest bend of all branches: branch, arc length (m) and radius (m).
    pub fn tightest(&self) -> Option<(&str, f64, f64)> {
        let bends = self.branches.iter().filter_map(|branch| {
            let (s, radius) = branch.tightest()?;
            Some((branch.name.as_str(), s, radius))
        });
        bends.min_by(|a, b| a.2.total_cmp(&b.2))
    }
}

/// Number of events of each kind, in the order of [`EventKind::ALL`].
pub(crate) fn count(kinds: impl Iterator<Item = EventKind> + Clone) -> Vec<(EventKind, usize)> {
    let counted = EventKind::ALL.into_iter().map(|kind| (kind, kinds.clone().filter(|other| *other == kind).count()));
    counted.filter(|(_, n)| *n > 0).collect()
}

impl BranchEnd {
    /// Of a result.
    pub fn of(branch: &BranchResult) -> Self {
        Self {
            name: branch.name.clone(),
            s: branch.s.clone(),
            position: branch.position.clone(),
            tangent: branch.frame.iter().map(|frame| columns(frame)[2]).collect(),
            bend_radius: branch.bend_radius.clone(),
            twist_turns: branch.twist_turns,
        }
    }

    /// Position (m) at an arc length (m), between nodes on the cubic through positions and tangents.
    pub fn position_at(&self, s: f64) -> Vector {
        self.curve().map_or(Vector::repeat(f64::NAN), |curve| curve.at(s / curve.length()))
    }

    /// The centre line; `None` where there is none.
    pub(crate) fn curve(&self) -> Option<Curve<'_>> {
        Curve::of(&self.s, &self.position, &self.tangent)
    }

    /// Arc length and radius (m) of its tightest bend; none where it is straight.
    pub fn tightest(&self) -> Option<(f64, f64)> {
        let bends = self.s.iter().copied().zip(self.bend_radius.iter().copied());
        bends.filter(|(_, radius)| radius.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

impl ConstraintEnd {
    fn of(constraint: &ConstraintResult) -> Self {
        let slide = |slide: &SlideResult| (slide.branch.clone(), slide.arc_length);
        Self {
            name: constraint.name.clone(),
            position: constraint.position,
            force: constraint.force,
            moment: constraint.moment,
            slide: constraint.slide.as_ref().map(slide),
            outputs: constraint.outputs.clone(),
        }
    }
}

impl Closed {
    /// That of a grasp or a clip; `None` for other operations.
    pub(crate) fn of(operation: &OperationResult) -> Option<Self> {
        match operation {
            OperationResult::Grasp { constraint, place } | OperationResult::Clip { constraint, place, .. } => {
                Some(Self { constraint: constraint.clone(), place: place.clone() })
            }
            OperationResult::Carry { .. } | OperationResult::Mate { .. } => None,
        }
    }
}

/// Work of the minimiser.
#[derive(Clone, Copy, Default)]
pub(crate) struct Work {
    pub iterations: usize,
    pub polish: usize,
    pub factorisations: usize,
    pub seconds: f64,
}

impl Work {
    fn of(step: &StepResult) -> Self {
        let m = &step.minimiser;
        Self { iterations: m.iterations, polish: m.polish, factorisations: m.factorisations, seconds: m.seconds }
    }

    fn add(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.polish += other.polish;
        self.factorisations += other.factorisations;
        self.seconds += other.seconds;
    }
}

/// Sums over the steps of a run, in their order. A step may be there with each of its increments
/// (`increments = true`): its work is that of the last one, since work is counted from the beginning of the step, and
/// so are its operations.
#[derive(Default)]
pub(crate) struct Way {
    done: Work,
    /// Name, increment and work of the step that may go on.
    last: Option<(String, usize, Work)>,
    closed: Vec<Closed>,
}

impl Way {
    /// Takes the next step, or the next increment of the same one.
    pub fn add(&mut self, name: &str, increment: usize, work: Work, closed: impl Iterator<Item = Closed>) {
        for closed in closed {
            match self.closed.iter_mut().find(|known| known.constraint == closed.constraint) {
                Some(known) => *known = closed,
                None => self.closed.push(closed),
            }
        }
        if let Some((before, at, work)) = self.last.take()
            && !(before == name && increment > at)
        {
            self.done.add(work);
        }
        self.last = Some((name.to_owned(), increment, work));
    }

    /// The work of all steps, and what closed in them.
    pub fn sums(mut self) -> (Work, Vec<Closed>) {
        if let Some((_, _, work)) = self.last {
            self.done.add(work);
        }
        (self.done, self.closed)
    }
}
