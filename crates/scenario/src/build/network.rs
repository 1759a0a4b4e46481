//! From a checked scenario to a network and a schedule.

use super::mesh::Layout;
use super::notes;
use super::requirements;
use crate::attachment::{At, Stretch};
use crate::fault::Fault;
use crate::scenario::{Constraint, Facing, Joint, Load, Scenario};
use crate::span::Spans;
use nalgebra::Unit;
use wireloom_core::constraint::{Action, ConstraintSpec, RotationHold, SpanSpec, StationSpec};
use wireloom_core::joint::{JointSpec, Mounting};
use wireloom_core::law::TurningLaw;
use wireloom_core::load::{Axes, LoadAction};
use wireloom_core::network::{AttachedConstraint, BranchPlan, ConstraintPlan, JointPlan, LoadPlan};
use wireloom_core::registry::{BuildError, Factory, Parameters};
use wireloom_core::rod::{Mesh, RodSpec};
use wireloom_core::steps::Schedule;
use wireloom_core::{Arm, JointModel, Minimiser, Network, Registry, RodSegment, Stop};

/// The network, the schedule and the minimiser of a run.
pub struct Built {
    /// The harness.
    pub network: Network,
    /// The harness with fewer segments, if it has so many that a start is found faster on a coarse mesh first.
    pub coarse: Option<Network>,
    /// The steps.
    pub schedule: Schedule,
    /// Finds equilibria.
    pub minimiser: Box<dyn Minimiser>,
    /// Its stopping criteria.
    pub stop: Stop,
    /// Notes for the user; each begins with its subject.
    pub notes: Vec<String>,
    /// Values of sections by the rule, a line for each, if there are too many of them for the notes.
    pub sections: Vec<String>,
}

/// Number of points from which on the start is computed on a coarse mesh first.
const LARGE: usize = 2000;

/// Number of segments of the mesh in one of the coarse mesh.
const COARSER: usize = 4;

/// Largest number of sections by rule that have a note each; for more there is one note.
const FEW_SECTIONS: usize = 6;

impl Scenario {
    /// Builds the parts with the factories of `registry`, which must be the one the scenario was parsed with.
    ///
    /// # Errors
    /// The refusals of the factories, each at its place in the file.
    pub fn build(&self, registry: &Registry) -> Result<Built, Vec<Fault>> {
        let mut faults = Vec::new();
        let layout = Layout::new(self, 1);
        let models = self.joint_models(&layout, registry, &mut faults);
        let constraints = self.constraint_plans(&layout, registry, &mut faults);
        let minimiser = self.minimiser(registry, &mut faults);
        let (Some(models), Some(minimiser)) = (models, minimiser) else { return Err(faults) };
        let branches = self.branch_plans(&layout, &models, registry, &mut faults);
        if !faults.is_empty() {
            return Err(faults);
        }
        let mut sections = self.notes_on_sections();
        let mut notes = if sections.len() <= FEW_SECTIONS {
            std::mem::take(&mut sections)
        } else {
            vec![format!(
                "{} sections follow from their wires by rule; `wireloom check` lists their values and bounds",
                sections.len()
            )]
        };
        if !self.unmatched.is_empty() {
            notes.push(format!(
                "catalogue: it has no entry for {} part number{} of constraints: {}",
                self.unmatched.len(),
                if self.unmatched.len() == 1 { "" } else { "s" },
                self.unmatched.join(", ")
            ));
        }
        notes.extend(self.file_notes.iter().cloned());
        notes.extend(self.notes(&models));
        notes.extend(self.obstacles.iter().flat_map(|body| body.notes.iter().cloned()));
        let joints = self.joint_plans(models);
        let mut network = self.among_obstacles(Network::new(branches, joints, constraints, self.load_plans(&layout)));
        notes.extend(network.constraints.iter().flat_map(notes_of_constraint));
        notes.extend(network.loads.iter().filter_map(note_on_load));
        network.requirements = requirements::requirements(self, &network);
        network.markers.clone_from(&self.markers);
        self.refuse_turns_without_effect(&network, &mut faults);
        if !faults.is_empty() {
            return Err(faults);
        }
        minimiser
            .accepts(&network)
            .map_err(|refusal| vec![refused(refusal, "the minimiser", &self.minimiser.spans)])?;
        let coarse = self.coarse(&network, registry);
        let schedule = Schedule {
            scenario: self.name.clone(),
            gravity: self.gravity,
            rotation: self.rotation,
            initial: self.initial,
            steps: self.steps.clone(),
            increments: self.output.increments,
            clearances: self.output.clearance,
            identities: self.identities.clone().into(),
        };
        Ok(Built { network, coarse, schedule, minimiser, stop: self.minimiser.stop, notes, sections })
    }

    /// Refuses turns about the tangent of a constraint that leaves the twist free: they would have no effect.
    fn refuse_turns_without_effect(&self, network: &Network, faults: &mut Vec<Fault>) {
        for step in &self.steps {
            for motion in step.moves.iter().filter(|motion| motion.track.spin != 0.0) {
                for carried in &motion.carried {
                    let constraint = &network.constraints[carried.constraint].model;
                    let free = match constraint.action() {
                        Action::Prescribed(hold) => matches!(hold.rotation, RotationHold::Free | RotationHold::Tangent),
                        Action::Potential(_) => {
                            constraint.law().is_some_and(|law| !matches!(law.turning, TurningLaw::Frame(_)))
                        }
                        Action::Equations(_) | Action::PotentialAndEquations(..) => false,
                    };
                    if free {
                        let constraint = &self.constraints[carried.constraint];
                        let message = format!(
                            "makes {} turns in step \"{}\", but leaves the twist free",
                            motion.track.spin, step.name
                        );
                        let help = "hold the twist: with a connector, a collar with twist = \"held\", or a handle with \
                                    `tangent` and `up`";
                        let label = format!("constraint \"{}\"", constraint.name);
                        faults.push(refused(BuildError::new(message, help).at("kind"), &label, &constraint.spans));
                    }
                }
            }
        }
    }

    /// The harness with fewer segments; `None` if that makes little difference, or if the mesh moves along the cable.
    fn coarse(&self, fine: &Network, registry: &Registry) -> Option<Network> {
        if fine.points < LARGE || fine.branches.iter().any(|branch| branch.mesh_moves) {
            return None;
        }
        let layout = Layout::new(self, COARSER);
        // The factories have accepted the same parts on the fine mesh.
        let mut faults = Vec::new();
        let models = self.joint_models(&layout, registry, &mut faults)?;
        let constraints = self.constraint_plans(&layout, registry, &mut faults);
        let branches = self.branch_plans(&layout, &models, registry, &mut faults);
        if !faults.is_empty() {
            return None;
        }
        let network = Network::new(branches, self.joint_plans(models), constraints, self.load_plans(&layout));
        let network = self.among_obstacles(network);
        (2 * network.points <= fine.points).then_some(network)
    }

    /// The harness with its obstacles, mechanisms and settings of contact.
    fn among_obstacles(&self, network: Network) -> Network {
        let obstacles = self.obstacles.iter().map(|body| body.obstacle.clone()).collect();
        let mechanisms = self.mechanisms.clone();
        Network { obstacles, contact: self.contact, mechanisms, rotates: self.rotates(), ..network }
    }

    /// Joint models with their specifications; `None` if one could not be built.
    fn joint_models(
        &self,
        layout: &Layout,
        registry: &Registry,
        faults: &mut Vec<Fault>,
    ) -> Option<Vec<(JointSpec, Box<dyn JointModel>)>> {
        let model = |joint: &Joint| {
            let spec = self.joint_spec(joint, layout);
            let kind = registry.joint(&joint.model).map(|kind| &kind.build);
            let label = format!("joint \"{}\"", joint.name);
            let model = made(kind, &spec, &joint.parameters, &label, &joint.spans, faults)?;
            Some((spec, model))
        };
        let models: Vec<Option<_>> = self.joints.iter().map(model).collect();
        models.into_iter().collect()
    }

    fn joint_spec(&self, joint: &Joint, layout: &Layout) -> JointSpec {
        let arms = joint.arms.iter().map(|arm| {
            let branch = &self.branches[arm.branch];
            let lengths = &layout.branches[arm.branch].rest_lengths;
            Arm {
                branch: branch.name.clone(),
                starts_here: arm.starts_here,
                rest: arm.rest,
                offset: arm.offset,
                spring: arm.spring.clone(),
                section: self.sections[branch.end_section(arm.starts_here)].clone(),
                curvature: branch.curvature,
                length: branch.length,
                segment_length: if arm.starts_here { lengths[0] } else { lengths[lengths.len() - 1] },
            }
        });
        JointSpec { name: joint.name.clone(), arms: arms.collect(), wires: joint.wires.clone() }
    }

    /// Rods on meshes with stations at both ends (except ends that meet others in a point), at attachments, and where
    /// sections change.
    fn branch_plans(
        &self,
        layout: &Layout,
        models: &[(JointSpec, Box<dyn JointModel>)],
        registry: &Registry,
        faults: &mut Vec<Fault>,
    ) -> Vec<BranchPlan> {
        // Whether a branch meets others in a point at its start, and at its end.
        let mut in_a_point = vec![[false; 2]; self.branches.len()];
        for (joint, (_, model)) in self.joints.iter().zip(models) {
            if model.mounting() == Mounting::Point {
                joint.arms.iter().for_each(|arm| in_a_point[arm.branch][usize::from(!arm.starts_here)] = true);
            }
        }
        let mut plans = Vec::new();
        for (index, branch) in self.branches.iter().enumerate() {
            let rest_lengths = layout.branches[index].rest_lengths.clone();
            let mut stations = layout.stations[index].clone();
            for (node, in_a_point) in [0, rest_lengths.len()].into_iter().zip(in_a_point[index]) {
                if in_a_point {
                    stations.remove(&node);
                } else {
                    stations.insert(node);
                }
            }
            let sections = layout.sections(self, index);
            let mesh = Mesh::new(rest_lengths, stations.into_iter().collect());
            let (name, curvature) = (branch.name.clone(), branch.curvature);
            let spec = RodSpec { name, sections: sections.clone(), mesh, curvature };
            let kind = registry.rod(&branch.rod).map(|kind| &kind.build);
            let label = format!("branch \"{}\"", branch.name);
            let rod: Option<Box<dyn RodSegment>> = made(kind, &spec, &branch.parameters, &label, &branch.spans, faults);
            let (name, kind) = (branch.name.clone(), branch.rod.clone());
            let (path, drawn) = (branch.path.clone(), branch.drawn().to_vec());
            plans.extend(rod.map(|rod| BranchPlan { name, kind, sections, rod, path, drawn }));
        }
        plans
    }

    fn joint_plans(&self, models: Vec<(JointSpec, Box<dyn JointModel>)>) -> Vec<JointPlan> {
        let plan = |(joint, (spec, model)): (&Joint, (JointSpec, Box<dyn JointModel>))| JointPlan {
            name: joint.name.clone(),
            kind: joint.model.clone(),
            model,
            arms: spec.arms,
            branches: joint.arms.iter().map(|arm| arm.branch).collect(),
            mass: joint.mass,
        };
        self.joints.iter().zip(models).map(plan).collect()
    }

    fn constraint_plans(&self, layout: &Layout, registry: &Registry, faults: &mut Vec<Fault>) -> Vec<ConstraintPlan> {
        let mut plans = Vec::new();
        for constraint in &self.constraints {
            let kind = registry.constraint(&constraint.kind).map(|kind| &kind.build);
            let label = format!("constraint \"{}\"", constraint.name);
            let spec = self.constraint_spec(constraint);
            let built = made(kind, &spec, &constraint.parameters, &label, &constraint.spans, faults);
            plans.extend(built.map(|built| ConstraintPlan {
                name: constraint.name.clone(),
                kind: constraint.called.clone(),
                model: built,
                outputs: registry.constraint(&constraint.kind).map_or_else(Vec::new, |kind| kind.outputs.clone()),
                stations: constraint.at.iter().map(|&at| layout.place(at)).collect(),
                span: constraint.span.as_ref().map(|span| layout.span(span)),
                position: constraint.position,
                tangent: if let Facing::Tangent(tangent) = constraint.facing { Some(tangent) } else { None },
                orientation: if let Facing::Orientation(frame) = constraint.facing { Some(frame) } else { None },
                mount: constraint.mount,
                slide: constraint.slide,
                limits: constraint.limits,
                nearest: constraint.nearest,
                from_start: constraint.from_start,
            }));
        }
        plans
    }

    fn constraint_spec(&self, constraint: &Constraint) -> ConstraintSpec {
        let station = |at: &At| match at {
            At::Branch { branch, s } => {
                let own = &self.branches[*branch];
                let place = Some((own.name.clone(), *s));
                StationSpec { place, diameter: self.diameter_within(own, [*s, *s]) }
            }
            At::Joint(joint) => {
                let end = |arm: &crate::scenario::Arm| self.branches[arm.branch].end_section(arm.starts_here);
                let arms = self.joints[*joint].arms.iter().map(|arm| self.sections[end(arm)].diameter);
                StationSpec { place: None, diameter: arms.fold(0.0, f64::max) }
            }
        };
        let span = |span: &Stretch| SpanSpec {
            branch: self.branches[span.branch].name.clone(),
            range: (span.from, span.to),
            diameter: self.diameter_within(&self.branches[span.branch], [span.from, span.to]),
        };
        ConstraintSpec {
            name: constraint.name.clone(),
            stations: constraint.at.iter().map(station).collect(),
            span: constraint.span.as_ref().map(span),
            tangent_given: constraint.tangent_given,
            up_given: constraint.up_given,
            hold: constraint.hold.clone(),
            free_axis: constraint.free_axis.map(Unit::new_unchecked),
            rails: constraint.rails.clone(),
        }
    }

    fn load_plans(&self, layout: &Layout) -> Vec<LoadPlan> {
        let plan = |load: &Load| LoadPlan {
            name: load.name.clone(),
            action: load.action.map(|&at| layout.place(at), |span| layout.span(span)),
            factor: load.factor,
        };
        self.loads.iter().map(plan).collect()
    }

    fn minimiser(&self, registry: &Registry, faults: &mut Vec<Fault>) -> Option<Box<dyn Minimiser>> {
        let chosen = &self.minimiser;
        let kind = registry.minimiser(&chosen.kind).map(|kind| &kind.build);
        made(kind, &(), &chosen.parameters, "the minimiser", &chosen.spans, faults)
    }

    fn notes(&self, models: &[(JointSpec, Box<dyn JointModel>)]) -> Vec<String> {
        let of_joint = |(spec, model): &(JointSpec, Box<dyn JointModel>)| {
            let name = spec.name.clone();
            model.notes().into_iter().map(move |note| format!("joint \"{name}\": {note}"))
        };
        models.iter().flat_map(of_joint).collect()
    }

    fn notes_on_sections(&self) -> Vec<String> {
        self.by_rule.iter().map(|by_rule| notes::note(by_rule, &self.sections[by_rule.section])).collect()
    }
}

/// The notes of a constraint's model.
fn notes_of_constraint(constraint: &AttachedConstraint) -> impl Iterator<Item = String> {
    constraint.model.notes().into_iter().map(|note| format!("constraint \"{}\": {note}", constraint.name))
}

/// What a user of a follower or a flow must know of its equilibria.
fn note_on_load(load: &wireloom_core::network::Load) -> Option<String> {
    if matches!(&load.action, LoadAction::At { load, .. } if load.axes() == Axes::World) {
        return None;
    }
    let why = load.without_potential()?;
    Some(format!(
        "load \"{}\" {why}, which has no potential: an equilibrium under it is no minimum of an energy, and whether it \
         is stable is told only where it certainly diverges",
        load.name
    ))
}

/// Calls a factory; `None`, with a fault at the key that it names, if it refuses.
fn made<S, T: ?Sized>(
    factory: Option<&Factory<S, T>>,
    spec: &S,
    parameters: &Parameters,
    label: &str,
    spans: &Spans,
    faults: &mut Vec<Fault>,
) -> Option<Box<T>> {
    let built = match factory {
        Some(factory) => factory(spec, parameters),
        None => {
            Err(BuildError::new("its kind is not in this registry", "build with the registry that parsed the scenario"))
        }
    };
    built.map_err(|error| faults.push(refused(error, label, spans))).ok()
}

/// A refusal, at the key it names.
fn refused(error: BuildError, label: &str, spans: &Spans) -> Fault {
    Fault { span: spans.of(error.key.as_deref()), message: format!("{label}: {}", error.message), help: error.help }
}
