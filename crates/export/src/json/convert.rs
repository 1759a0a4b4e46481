//! From and to the results of `wireloom-core`.

use super::document::{
    ArmFriction, Branch, BranchError, Clearance, Constraint, Deviation, DeviationCause, Document, Energy, Event, Fault,
    Friction, Increment, Joint, Marker, Minimiser, Obstacle, Operation, Place, Plugin, Requirement, SectionPart, Sheet,
    Slide, Span, Station, Step, TightestBend, Violation,
};
use super::provenance::Provenance;
use super::values::{Entries, FieldsFile, Number, Schema, Vector3, Word, quaternion, rotation, vector, written};
use crate::fields::BranchFields;
use wireloom_core::requirement::Measure;
use wireloom_core::rotation::{columns, frame_from};
use wireloom_core::sections::SectionResult;
use wireloom_core::{Pose, Rotation, Status, Vector, equilibrium as core};

/// Why something that has the form of a result cannot be one.
type Refusal = String;

impl<S> Document<S> {
    /// All but the steps of `run`, which are given; `fields`: where their node fields are, if in another file.
    pub fn of(run: &core::Run, provenance: &Provenance, fields: Option<FieldsFile>, steps: S) -> Self {
        Self {
            schema: Schema,
            scenario: run.scenario.clone(),
            status: Word(run.status()),
            verdict: Word(run.verdict()),
            requirements: run.requirements.iter().map(Requirement::of).collect(),
            provenance: provenance.clone(),
            notes: run.notes.clone(),
            plugins: run.plugins.iter().map(Plugin::of).collect(),
            identities: (*run.identities).clone(),
            events: run.events.iter().map(Event::of).collect(),
            fields,
            steps,
            clearance: run.clearances.iter().map(Clearance::of).collect(),
            drawn_start: run.drawn_start.clone(),
            sensitivities: run.sensitivities.clone(),
            fault: run.fault().map(Fault::of),
        }
    }

    /// The run, with its steps made of those read.
    pub fn run(self, steps: impl FnOnce(S) -> Vec<core::StepResult>) -> Result<core::Run, Refusal> {
        let outcome = match (self.status.0, self.fault) {
            (status, None) => core::Outcome::Graded(status),
            (Status::Failed, Some(fault)) => core::Outcome::Fault(fault.fault()?),
            (other, Some(_)) => return Err(format!("its status is {}, beside a fault: expected failed", other.word())),
        };
        Ok(core::Run {
            scenario: self.scenario,
            outcome,
            notes: self.notes,
            events: self.events.into_iter().map(Event::event).collect(),
            steps: steps(self.steps),
            clearances: self.clearance.into_iter().map(Clearance::clearance).collect::<Result<_, _>>()?,
            requirements: self.requirements.into_iter().map(Requirement::result).collect(),
            plugins: self.plugins.into_iter().map(Plugin::library).collect(),
            identities: self.identities.into(),
            drawn_start: self.drawn_start,
            sensitivities: self.sensitivities,
        })
    }
}

impl Sheet {
    /// The sheet of a run.
    pub fn of(run: &core::Run) -> Self {
        Self {
            schema: Schema,
            scenario: run.scenario.clone(),
            status: Word(run.status()),
            verdict: Word(run.verdict()),
            requirements: run.requirements.iter().map(Requirement::of).collect(),
        }
    }
}

impl Plugin {
    fn of(library: &core::Library) -> Self {
        let core::Library { name, version, file, hash } = library.clone();
        Self { name, version, file, hash }
    }

    fn library(self) -> core::Library {
        let Self { name, version, file, hash } = self;
        core::Library { name, version, file, hash }
    }
}

impl Event {
    fn of(event: &core::Event) -> Self {
        Self {
            kind: Word(event.kind),
            place: Place::of_event(&event.place),
            first: Increment::of(&event.first),
            worst: Increment::of(&event.worst),
            last: Increment::of(&event.last),
            increments: event.increments,
            value: event.value.map(Number),
            limit: event.limit.map(Number),
            message: event.message.clone(),
        }
    }

    fn event(self) -> core::Event {
        core::Event {
            kind: self.kind.0,
            place: self.place.place(),
            first: self.first.moment(),
            worst: self.worst.moment(),
            last: self.last.moment(),
            increments: self.increments,
            value: self.value.map(number),
            limit: self.limit.map(number),
            message: self.message,
        }
    }
}

impl Requirement {
    pub fn of(line: &core::RequirementResult) -> Self {
        Self {
            name: line.name.clone(),
            quantity: Word(line.measure),
            severity: Word(line.severity),
            verdict: Word(line.verdict),
            worst: line.worst.map(Number),
            limit: Number(line.limit),
            bound: Word(line.bound),
            margin: line.margin().map(Number),
            error: line.error.map(Number),
            step: line.moment.as_ref().map(|moment| moment.step.clone()),
            step_index: line.moment.as_ref().map(|moment| moment.step_index),
            increment: line.moment.as_ref().map(|moment| moment.increment),
            place: Place::of(&line.place),
            origin: Word(line.origin),
            because: line.because.clone(),
            reason: line.reason.clone(),
        }
    }

    pub fn result(self) -> core::RequirementResult {
        let moment = self.step.zip(self.step_index).zip(self.increment);
        // What has a moment was checked: null is then a value that no JSON number is, not the lack of one.
        let worst = self.worst.or(moment.as_ref().map(|_| Number(f64::NAN)));
        core::RequirementResult {
            name: self.name,
            origin: self.origin.0,
            measure: self.quantity.0,
            severity: self.severity.0,
            because: self.because,
            verdict: self.verdict.0,
            reason: self.reason,
            worst: worst.map(|worst| value_of(self.quantity.0, worst)),
            limit: self.limit.0,
            bound: self.bound.0,
            error: self.error.map(number),
            moment: moment.map(|((step, step_index), increment)| core::Moment { step, step_index, increment }),
            place: self.place.place(),
        }
    }
}

/// A value of a measure as it was read: the only one that is infinite is the bend radius of a straight cable.
fn value_of(measure: Measure, Number(value): Number) -> f64 {
    if value.is_nan() && measure == Measure::BendRadius { f64::INFINITY } else { value }
}

impl Place {
    fn of(place: &core::EventPlace) -> Self {
        let core::EventPlace { constraint, obstacle, branch, s, other_branch, other_s } = place.clone();
        let (s, other_s) = (s.map(Number), other_s.map(Number));
        Self { fixing: None, constraint, obstacle, branch, s, other_branch, other_s }
    }

    fn of_event(place: &core::EventPlace) -> Self {
        let place = Self::of(place);
        Self { fixing: place.constraint, constraint: None, ..place }
    }

    fn place(self) -> core::EventPlace {
        let Self { fixing, constraint, obstacle, branch, s, other_branch, other_s } = self;
        let (constraint, s, other_s) = (fixing.or(constraint), s.map(number), other_s.map(number));
        core::EventPlace { constraint, obstacle, branch, s, other_branch, other_s }
    }
}

impl Violation {
    fn of(violation: &core::Violation) -> Self {
        Self {
            name: violation.name.clone(),
            quantity: Word(violation.measure),
            severity: Word(violation.severity),
            value: Number(violation.value),
            limit: Number(violation.limit),
            bound: Word(violation.bound),
            place: Place::of(&violation.place),
        }
    }

    fn violation(self) -> core::Violation {
        core::Violation {
            name: self.name,
            measure: self.quantity.0,
            severity: self.severity.0,
            value: value_of(self.quantity.0, self.value),
            limit: self.limit.0,
            bound: self.bound.0,
            place: self.place.place(),
        }
    }
}

impl Increment {
    fn of(moment: &core::Moment) -> Self {
        Self { step: moment.step.clone(), step_index: moment.step_index, increment: moment.increment }
    }

    fn moment(self) -> core::Moment {
        core::Moment { step: self.step, step_index: self.step_index, increment: self.increment }
    }
}

impl Step {
    /// `apart`: the checksum of its node fields, where they are in another file.
    pub fn of(step: &core::StepResult, apart: Option<&str>) -> Self {
        let branch = |branch: &core::BranchResult| match apart {
            Some(_) => Branch::without_lists(branch),
            None => Branch::of(branch),
        };
        let slide = |constraint: &core::ConstraintResult| {
            constraint.slide.as_ref().map(|slide| (constraint.name.clone(), Slide::of(slide)))
        };
        Self {
            name: step.name.clone(),
            increment: step.increment,
            increments: step.increments,
            status: Word(step.status),
            fields_sha256: apart.map(str::to_owned),
            branches: step.branches.iter().map(|own| (own.name.clone(), branch(own))).collect(),
            joints: step.joints.iter().map(|joint| (joint.name.clone(), Joint::of(joint))).collect(),
            constraints: step.constraints.iter().map(|held| (held.name.clone(), Constraint::of(held))).collect(),
            obstacles: step.obstacles.iter().map(|body| (body.name.clone(), Obstacle::of(body))).collect(),
            mechanisms: step.mechanisms.iter().map(|own| (own.name.clone(), joint_values(own))).collect(),
            markers: step.markers.iter().map(|marker| (marker.name.clone(), Marker::of(marker))).collect(),
            sliding: step.constraints.iter().filter_map(slide).collect(),
            operations: step.operations.iter().map(Operation::of).collect(),
            energy: Energy::of(&step.energy),
            min_bend_radius: step.min_bend_radius.as_ref().map(TightestBend::of),
            violations: step.violations.iter().map(Violation::of).collect(),
            stable: step.stable,
            minimiser: Minimiser::of(&step.minimiser),
        }
    }

    /// The equilibrium; without lists where they are in another file.
    pub fn result(self) -> Result<core::StepResult, Refusal> {
        let mut slides = self.sliding;
        let constraint = |(name, constraint): (String, Constraint)| {
            let slide = slides.0.iter().position(|(sliding, _)| *sliding == name);
            let slide = slide.map(|k| slides.0.swap_remove(k).1.result());
            constraint.result(name, slide)
        };
        let constraints = self.constraints.0.into_iter().map(constraint).collect();
        unknown_slide(&slides)?;
        let branches = self.branches.0.into_iter().map(|(name, branch)| branch.result(name));
        Ok(core::StepResult {
            name: self.name,
            increment: self.increment,
            increments: self.increments,
            status: self.status.0,
            branches: branches.collect::<Result<_, _>>()?,
            joints: self.joints.0.into_iter().map(|(name, joint)| joint.result(name)).collect(),
            constraints,
            obstacles: self.obstacles.0.into_iter().map(|(name, obstacle)| obstacle.result(name)).collect(),
            mechanisms: self.mechanisms.0.into_iter().map(mechanism).collect(),
            markers: self.markers.0.into_iter().map(|(name, marker)| marker.result(name)).collect(),
            operations: self.operations.into_iter().map(Operation::result).collect(),
            energy: self.energy.energy(),
            min_bend_radius: self.min_bend_radius.map(TightestBend::bend),
            violations: self.violations.into_iter().map(Violation::violation).collect(),
            stable: self.stable,
            minimiser: self.minimiser.result(),
        })
    }
}

fn joint_values(mechanism: &core::MechanismResult) -> Entries<Vec<Number>> {
    let joint = |(name, values): &(String, Vec<f64>)| (name.clone(), values.iter().copied().map(Number).collect());
    mechanism.joints.iter().map(joint).collect()
}

fn mechanism((name, joints): (String, Entries<Vec<Number>>)) -> core::MechanismResult {
    let joint = |(name, values): (String, Vec<Number>)| (name, values.into_iter().map(|value| value.0).collect());
    core::MechanismResult { name, joints: joints.0.into_iter().map(joint).collect() }
}

/// Refuses a slide through a constraint that is not there.
fn unknown_slide(left: &Entries<Slide>) -> Result<(), Refusal> {
    match left.0.first() {
        Some((name, _)) => Err(format!("`sliding` names \"{name}\", which is not among `constraints`")),
        None => Ok(()),
    }
}

/// Node fields of an equilibrium that are in another file: number of nodes of each branch, and checksum.
#[cfg_attr(not(feature = "arrow"), expect(dead_code, reason = "only the reader of that file needs them"))]
pub struct Apart {
    pub nodes: Vec<usize>,
    pub hash: String,
}

impl<V> Step<V> {
    /// What is known here of lists that are in another file.
    pub fn apart(&self) -> Result<Option<Apart>, Refusal> {
        let nodes = self.branches.0.iter().filter_map(|(_, branch)| branch.nodes).collect::<Vec<_>>();
        match &self.fields_sha256 {
            Some(hash) if nodes.len() == self.branches.0.len() => Ok(Some(Apart { nodes, hash: hash.clone() })),
            None if nodes.is_empty() => Ok(None),
            Some(_) => Err("missing field `nodes` of a branch, beside `fields_sha256`".to_owned()),
            None => Err("missing field `fields_sha256`, beside `nodes`".to_owned()),
        }
    }
}

impl Branch<Vec<Vector3>> {
    fn of(branch: &core::BranchResult) -> Self {
        let column = |k: usize| Some(branch.frame.iter().map(|frame| written(&columns(frame)[k])).collect());
        let mut all = Self {
            nodes: None,
            strain: branch.strain.as_deref().map(numbers_of),
            s: Some(numbers_of(&branch.s)),
            position: Some(vectors_of(&branch.position)),
            d3: column(2),
            d1: column(0),
            force: Some(vectors_of(&branch.force)),
            moment: Some(vectors_of(&branch.moment)),
            bend_radius: Some(numbers_of(&branch.bend_radius)),
            ..Self::without_lists(branch)
        };
        if let (Some(own), Some(friction)) = (&mut all.friction, &branch.friction) {
            own.set = Some(vectors_of(&friction.set));
        }
        all
    }

    /// With the number of nodes in place of the lists, which are in another file.
    fn without_lists(branch: &core::BranchResult) -> Self {
        Self {
            diameter: Number(branch.diameter),
            bend_radius_limit: branch.bend_radius_limit.map(Number),
            axial_stiffness: Number(branch.axial_stiffness),
            sections: branch.sections.iter().map(SectionPart::of).collect(),
            nodes: Some(branch.s.len()),
            strain: None,
            s: None,
            position: None,
            d3: None,
            d1: None,
            force: None,
            moment: None,
            bend_radius: None,
            twist_turns: Number(branch.twist_turns),
            error: branch.error.as_ref().map(BranchError::of),
            deviation: branch.deviation.as_ref().map(Deviation::of),
            friction: branch.friction.as_ref().map(Friction::without_set),
        }
    }

    fn result(self, name: String) -> Result<core::BranchResult, Refusal> {
        let (d1, force, moment) = (listed(self.d1), listed(self.force), listed(self.moment));
        let (s, position, d3) = (listed(self.s), listed(self.position), listed(self.d3));
        let bend_radius = listed(self.bend_radius);
        let friction = self.friction.map(Friction::friction);
        let set = friction.as_ref().map_or(s.len(), |friction| friction.set.len());
        let strain = self.strain.as_ref().map_or(s.len(), Vec::len);
        let lengths = [position.len(), d3.len(), d1.len(), force.len(), moment.len(), bend_radius.len(), set, strain];
        same_lengths(&name, s.len(), &lengths)?;
        Ok(core::BranchResult {
            name,
            diameter: self.diameter.0,
            bend_radius_limit: self.bend_radius_limit.map(number),
            axial_stiffness: self.axial_stiffness.0,
            sections: self.sections.into_iter().map(SectionPart::part).collect(),
            strain: self.strain.map(numbers),
            s: numbers(s),
            position: vectors(position),
            frame: frames(vectors(d3), vectors(d1)),
            force: vectors(force),
            moment: vectors(moment),
            bend_radius: radii(bend_radius),
            sides: Vec::new(),
            twist_turns: self.twist_turns.0,
            error: self.error.map(BranchError::error),
            deviation: self.deviation.map(Deviation::deviation),
            friction,
        })
    }
}

impl SectionPart {
    fn of(part: &SectionResult) -> Self {
        Self {
            section: part.section.clone(),
            from: Number(part.from),
            to: Number(part.to),
            diameter: Number(part.diameter),
            bend_radius_limit: part.bend_radius_limit.map(Number),
            axial_stiffness: Number(part.axial_stiffness),
        }
    }

    fn part(self) -> SectionResult {
        SectionResult {
            section: self.section,
            from: self.from.0,
            to: self.to.0,
            diameter: self.diameter.0,
            bend_radius_limit: self.bend_radius_limit.map(number),
            axial_stiffness: self.axial_stiffness.0,
        }
    }
}

impl Deviation {
    fn of(deviation: &core::Deviation) -> Self {
        let core::Deviation { median, max, s, cause } = deviation;
        let cause = cause.clone().map(|cause| match cause {
            core::DeviationCause::HeldElsewhere { constraint } => DeviationCause::HeldElsewhere { constraint },
            core::DeviationCause::FewConstraints { between, free_length, room } => {
                DeviationCause::FewConstraints { between, free_length: Number(free_length), room: Number(room) }
            }
            core::DeviationCause::FreeEnd { from, free_length } => {
                DeviationCause::FreeEnd { from, free_length: Number(free_length) }
            }
        });
        Self { median: Number(*median), max: Number(*max), s: Number(*s), cause }
    }

    fn deviation(self) -> core::Deviation {
        let cause = self.cause.map(|cause| match cause {
            DeviationCause::HeldElsewhere { constraint } => core::DeviationCause::HeldElsewhere { constraint },
            DeviationCause::FewConstraints { between, free_length, room } => {
                core::DeviationCause::FewConstraints { between, free_length: free_length.0, room: room.0 }
            }
            DeviationCause::FreeEnd { from, free_length } => {
                core::DeviationCause::FreeEnd { from, free_length: free_length.0 }
            }
        });
        core::Deviation { median: self.median.0, max: self.max.0, s: self.s.0, cause }
    }
}

/// A list that may be in another file, and is then empty here.
pub fn listed<T>(list: Option<Vec<T>>) -> Vec<T> {
    list.unwrap_or_default()
}

fn frames(d3: Vec<Vector>, d1: Vec<Vector>) -> Vec<Rotation> {
    // Where a failure has left no numbers there is no frame either.
    d3.into_iter().zip(d1).map(|(d3, d1)| frame_from(&d3, &d1).unwrap_or_else(Rotation::identity)).collect()
}

/// Puts node fields, which were in another file, into an equilibrium.
pub fn fill(step: &mut core::StepResult, fields: Vec<BranchFields>) {
    for (branch, own) in step.branches.iter_mut().zip(fields) {
        branch.s = own.s;
        branch.position = own.position;
        branch.frame = frames(own.d3, own.d1);
        branch.force = own.force;
        branch.moment = own.moment;
        branch.bend_radius = own.bend_radius;
        branch.strain = own.strain;
        if let Some(friction) = &mut branch.friction {
            friction.set = own.set.unwrap_or_default();
        }
    }
}

impl Friction {
    fn without_set(friction: &core::FrictionResult) -> Self {
        let core::FrictionResult { set: _, dissipated, dissipated_in_all } = friction;
        Self { set: None, dissipated: Number(*dissipated), dissipated_in_all: Number(*dissipated_in_all) }
    }

    fn friction(self) -> core::FrictionResult {
        core::FrictionResult {
            set: vectors(listed(self.set)),
            dissipated: self.dissipated.0,
            dissipated_in_all: self.dissipated_in_all.0,
        }
    }
}

impl BranchError {
    fn of(error: &core::BranchError) -> Self {
        let core::BranchError { position, force, moment, bend_radius, order } = *error;
        Self {
            position: Number(position),
            force: Number(force),
            moment: Number(moment),
            bend_radius: bend_radius.map(Number),
            order,
        }
    }

    fn error(self) -> core::BranchError {
        core::BranchError {
            position: self.position.0,
            force: self.force.0,
            moment: self.moment.0,
            bend_radius: self.bend_radius.map(number),
            order: self.order,
        }
    }
}

/// Refuses a branch whose lists differ in length from that of `s`.
pub fn same_lengths(name: &str, s: usize, others: &[usize]) -> Result<(), Refusal> {
    if others.iter().all(|length| *length == s) {
        return Ok(());
    }
    Err(format!("the lists of branch \"{name}\" differ in length"))
}

impl Joint {
    fn of(joint: &core::JointResult) -> Self {
        let core::JointResult { name: _, position, orientation, friction } = joint;
        let of_arm = |own: &core::ArmFriction| (own.branch.clone(), ArmFriction::of(own));
        Self {
            position: written(position),
            orientation: quaternion(orientation),
            friction: friction.iter().map(of_arm).collect(),
        }
    }

    fn result(self, name: String) -> core::JointResult {
        core::JointResult {
            name,
            position: vector(self.position),
            orientation: rotation(self.orientation),
            friction: self.friction.0.into_iter().map(|(branch, own)| own.friction(branch)).collect(),
        }
    }
}

impl ArmFriction {
    fn of(friction: &core::ArmFriction) -> Self {
        let core::ArmFriction { branch: _, starts_here, set, dissipated, dissipated_in_all } = friction;
        Self {
            starts_here: *starts_here,
            set: written(set),
            dissipated: Number(*dissipated),
            dissipated_in_all: Number(*dissipated_in_all),
        }
    }

    fn friction(self, branch: String) -> core::ArmFriction {
        core::ArmFriction {
            branch,
            starts_here: self.starts_here,
            set: vector(self.set),
            dissipated: self.dissipated.0,
            dissipated_in_all: self.dissipated_in_all.0,
        }
    }
}

impl Constraint {
    fn of(constraint: &core::ConstraintResult) -> Self {
        Self {
            kind: constraint.kind.clone(),
            position: written(&constraint.position),
            orientation: quaternion(&constraint.orientation),
            force: written(&constraint.force),
            moment: written(&constraint.moment),
            stations: constraint.stations.iter().map(Station::of).collect(),
            span: constraint.span.as_ref().map(Span::of),
            outputs: constraint.outputs.iter().map(|(name, value)| (name.clone(), Number(*value))).collect(),
        }
    }

    fn result(self, name: String, slide: Option<core::SlideResult>) -> core::ConstraintResult {
        core::ConstraintResult {
            name,
            kind: self.kind,
            position: vector(self.position),
            orientation: rotation(self.orientation),
            force: vector(self.force),
            moment: vector(self.moment),
            stations: self.stations.into_iter().map(Station::result).collect(),
            span: self.span.map(Span::result),
            slide,
            outputs: outputs(self.outputs),
        }
    }
}

impl Station {
    fn of(station: &core::StationResult) -> Self {
        Self { position: written(&station.position), force: written(&station.force), moment: written(&station.moment) }
    }

    fn result(self) -> core::StationResult {
        core::StationResult { position: vector(self.position), force: vector(self.force), moment: vector(self.moment) }
    }
}

impl Span {
    fn of(span: &core::SpanResult) -> Self {
        Self {
            branch: span.branch.clone(),
            from: Number(span.range.0),
            to: Number(span.range.1),
            force: written(&span.force),
            largest: written(&span.largest),
            largest_at: Number(span.largest_at),
        }
    }

    fn result(self) -> core::SpanResult {
        core::SpanResult {
            branch: self.branch,
            range: (self.from.0, self.to.0),
            force: vector(self.force),
            largest: vector(self.largest),
            largest_at: self.largest_at.0,
        }
    }
}

impl Obstacle {
    fn of(obstacle: &core::ObstacleResult) -> Self {
        Self {
            position: written(&obstacle.pose.position),
            orientation: quaternion(&obstacle.pose.orientation),
            force: written(&obstacle.force),
            moment: written(&obstacle.moment),
            contact_force: Number(obstacle.contact_force),
            contacts: obstacle.contacts,
            depth: Number(obstacle.depth),
        }
    }

    fn result(self, name: String) -> core::ObstacleResult {
        core::ObstacleResult {
            name,
            pose: Pose { position: vector(self.position), orientation: rotation(self.orientation) },
            force: vector(self.force),
            moment: vector(self.moment),
            contact_force: self.contact_force.0,
            contacts: self.contacts,
            depth: self.depth.0,
        }
    }
}

impl Marker {
    fn of(marker: &core::MarkerResult) -> Self {
        Self { position: written(&marker.position) }
    }

    fn result(self, name: String) -> core::MarkerResult {
        core::MarkerResult { name, position: vector(self.position) }
    }
}

impl Slide {
    fn of(slide: &core::SlideResult) -> Self {
        Self {
            branch: slide.branch.clone(),
            contact_arclength: Number(slide.arc_length),
            axial_force: Number(slide.axial_force),
            motion: Word(slide.motion),
        }
    }

    fn result(self) -> core::SlideResult {
        core::SlideResult {
            branch: self.branch,
            arc_length: self.contact_arclength.0,
            axial_force: self.axial_force.0,
            motion: self.motion.0,
        }
    }
}

impl Operation {
    fn of(operation: &core::OperationResult) -> Self {
        let apart = |place: &Option<(String, f64)>| place.clone().map(|(branch, s)| (branch, Number(s))).unzip();
        match operation {
            core::OperationResult::Grasp { constraint, place } => {
                let (branch, s) = apart(place);
                Self::Grasp { constraint: constraint.clone(), branch, s }
            }
            core::OperationResult::Carry { constraints, force } => {
                Self::Carry { constraints: constraints.clone(), force: Number(*force) }
            }
            core::OperationResult::Mate { constraint, insertion_force, own, limit } => Self::Mate {
                constraint: constraint.clone(),
                insertion_force: insertion_force.map(Number),
                own: own.map(Number),
                limit: limit.map(Number),
            },
            core::OperationResult::Clip { constraint, place, reach } => {
                let (branch, s) = apart(place);
                Self::Clip { constraint: constraint.clone(), branch, s, reach: Number(*reach) }
            }
        }
    }

    pub fn result(self) -> core::OperationResult {
        let place = |branch: Option<String>, s: Option<Number>| branch.zip(s.map(number));
        match self {
            Self::Grasp { constraint, branch, s } => {
                core::OperationResult::Grasp { constraint, place: place(branch, s) }
            }
            Self::Carry { constraints, force } => core::OperationResult::Carry { constraints, force: force.0 },
            Self::Mate { constraint, insertion_force, own, limit } => core::OperationResult::Mate {
                constraint,
                insertion_force: insertion_force.map(number),
                own: own.map(number),
                limit: limit.map(number),
            },
            Self::Clip { constraint, branch, s, reach } => {
                core::OperationResult::Clip { constraint, place: place(branch, s), reach: reach.0 }
            }
        }
    }
}

impl Energy {
    fn of(energy: &core::Energy) -> Self {
        Self {
            total: Number(energy.total()),
            stretch: Number(energy.stretch),
            shear: Number(energy.shear),
            bend: Number(energy.bend),
            twist: Number(energy.twist),
            gravity: Number(energy.gravity),
            load: Number(energy.load),
            joint: Number(energy.joint),
            constraint: Number(energy.constraint),
        }
    }

    /// By effect; the total is their sum.
    pub fn energy(&self) -> core::Energy {
        core::Energy {
            stretch: self.stretch.0,
            shear: self.shear.0,
            bend: self.bend.0,
            twist: self.twist.0,
            gravity: self.gravity.0,
            load: self.load.0,
            joint: self.joint.0,
            constraint: self.constraint.0,
        }
    }
}

impl TightestBend {
    fn of(bend: &core::TightestBend) -> Self {
        Self {
            branch: bend.branch.clone(),
            s: Number(bend.s),
            value: Number(bend.value),
            limit: bend.limit.map(Number),
        }
    }

    fn bend(self) -> core::TightestBend {
        core::TightestBend { branch: self.branch, s: self.s.0, value: self.value.0, limit: self.limit.map(number) }
    }
}

impl Minimiser {
    fn of(minimiser: &core::MinimiserResult) -> Self {
        Self {
            kind: minimiser.kind.clone(),
            device: minimiser.device.clone(),
            iterations: minimiser.iterations,
            polish: minimiser.polish,
            factorisations: minimiser.factorisations,
            seconds: Number(minimiser.seconds),
            force_residual: Number(minimiser.force_residual),
            shape_error: minimiser.shape_error.map(Number),
            constraint_residual: minimiser.constraint_residual.map(Number),
        }
    }

    pub fn result(self) -> core::MinimiserResult {
        core::MinimiserResult {
            kind: self.kind,
            device: self.device,
            iterations: self.iterations,
            polish: self.polish,
            factorisations: self.factorisations,
            seconds: self.seconds.0,
            force_residual: self.force_residual.0,
            shape_error: self.shape_error.map(number),
            constraint_residual: self.constraint_residual.map(number),
        }
    }
}

impl Clearance {
    fn of(clearance: &core::Clearance) -> Self {
        let (obstacle, other) = match &clearance.from {
            core::ClearanceFrom::Obstacle(name) => (Some(name.clone()), None),
            core::ClearanceFrom::Branch { name, s } => (None, Some((name.clone(), Number(*s)))),
        };
        let (other, other_s) = other.unzip();
        Self {
            branch: clearance.branch.clone(),
            s: Number(clearance.s),
            position: written(&clearance.position),
            obstacle,
            other,
            other_s,
            distance: Number(clearance.distance),
            required: clearance.required.map(Number),
            at: Increment::of(&clearance.moment),
        }
    }

    fn clearance(self) -> Result<core::Clearance, Refusal> {
        let from = match (self.obstacle, self.other) {
            (Some(name), None) => core::ClearanceFrom::Obstacle(name),
            (None, Some(name)) => core::ClearanceFrom::Branch { name, s: self.other_s.map_or(f64::NAN, number) },
            _ => {
                return Err(format!("`clearance` of branch \"{}\" needs one of `obstacle` and `other`", self.branch));
            }
        };
        Ok(core::Clearance {
            branch: self.branch,
            from,
            distance: self.distance.0,
            s: self.s.0,
            position: vector(self.position),
            required: self.required.map(number),
            moment: self.at.moment(),
        })
    }
}

impl Fault {
    fn of(fault: &core::PartFault) -> Self {
        let core::PartFault { family, name, kind, step, increment, message } = fault.clone();
        let named = |which: core::PartFamily| (family == which).then(|| name.clone());
        let (constraint, joint) = (named(core::PartFamily::Constraint), named(core::PartFamily::Joint));
        let (rod, minimiser) = (named(core::PartFamily::Rod), named(core::PartFamily::Minimiser));
        Self { constraint, joint, rod, minimiser, kind, step, increment, message }
    }

    fn fault(self) -> Result<core::PartFault, Refusal> {
        let Self { constraint, joint, rod, minimiser, kind, step, increment, message } = self;
        let (family, name) = match (constraint, joint, rod, minimiser) {
            (Some(name), None, None, None) => (core::PartFamily::Constraint, name),
            (None, Some(name), None, None) => (core::PartFamily::Joint, name),
            (None, None, Some(name), None) => (core::PartFamily::Rod, name),
            (None, None, None, Some(name)) => (core::PartFamily::Minimiser, name),
            _ => return Err("`fault` needs one of `constraint`, `joint`, `rod` and `minimiser`".to_owned()),
        };
        Ok(core::PartFault { family, name, kind, step, increment, message })
    }
}

/// Outputs of a constraint as they were read.
pub fn outputs(entries: Entries<Number>) -> Vec<(String, f64)> {
    entries.0.into_iter().map(|(name, value)| (name, value.0)).collect()
}

fn number(number: Number) -> f64 {
    number.0
}

fn numbers_of(list: &[f64]) -> Vec<Number> {
    list.iter().copied().map(Number).collect()
}

fn vectors_of(list: &[Vector]) -> Vec<Vector3> {
    list.iter().map(written).collect()
}

/// Numbers as they were read.
pub fn numbers(list: Vec<Number>) -> Vec<f64> {
    list.into_iter().map(number).collect()
}

/// Vectors as they were read.
pub fn vectors(list: Vec<Vector3>) -> Vec<Vector> {
    list.into_iter().map(vector).collect()
}

/// Bend radii as they were read: infinite where they are null.
pub fn radii(list: Vec<Number>) -> Vec<f64> {
    list.into_iter().map(|Number(radius)| if radius.is_nan() { f64::INFINITY } else { radius }).collect()
}
