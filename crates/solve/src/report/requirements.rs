//! Values of requirements at one equilibrium.

use super::clearance::{self, CablePart, Cables};
use super::deviation;
use super::discretisation::NodalErrors;
use super::driven::{self, Driven};
use super::lines;
use super::part::{self, Local, PartOfBranch};
use super::result;
use super::sheet::Found;
use super::spans::{CableSpan, EndKnown, Piece, Spans};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use wireloom_core::conditions::Against;
use wireloom_core::equilibrium::{BranchResult, ConstraintResult, OperationResult};
use wireloom_core::network::{Place, Span};
use wireloom_core::requirement::{Measure, Motion, Part, Requirement};
use wireloom_core::section::softest_bending;
use wireloom_core::{EventPlace, Network, Pose, Problem, Section, State, Vector};

/// Distance, in radii, within which surfaces that press on each other are in touch.
const IN_TOUCH: f64 = 0.025;
/// Ratio of the length of a span to the distance of its ends up to which it is nearly straight.
const STRAIGHT: f64 = 1.02;
/// Factor on Euler's load that no nearly straight span reaches after it has buckled; also room for short, stiff spans,
/// whose mesh is coarse.
const BUCKLED: f64 = 1.1;
/// Distance of arc lengths at which they are the same, as a fraction of the length of the branch.
const SAME_PLACE: f64 = 1e-9;
/// Distance that a branch moves in an increment in which it is not at rest, as a fraction of its diameter.
const MOVING: f64 = 0.01;

/// Results of branches, constraints and operations.
type Results<'a> = (&'a [BranchResult], &'a [ConstraintResult], &'a [OperationResult]);

/// An equilibrium, as far as requirements are about it.
pub(crate) struct Equilibrium<'a> {
    pub network: &'a Network,
    /// Results of all branches.
    pub branches: &'a [BranchResult],
    /// Estimated errors of these results.
    pub errors: &'a [NodalErrors],
    /// Constraints and bodies that are driven into each other; `None`: the way here is not known.
    pub driven: Option<&'a [Driven]>,
    /// Constraints that act, with their indices.
    pub constraints: BTreeMap<usize, &'a ConstraintResult>,
    pub operations: &'a [OperationResult],
    /// Sum of the sizes of contact forces, N, by branch and what it touches.
    pub contact_forces: BTreeMap<(usize, Against), f64>,
    /// Errors of the contact forces on each branch, as a fraction of them.
    contact_errors: Vec<f64>,
    /// Distance that each branch has moved in the increment, m.
    pub moved: Vec<f64>,
    /// Whether this is the end of a step.
    pub ends_step: bool,
    /// Index of the step; `None` before the first one.
    pub step: Option<usize>,
    /// Spans between held places.
    pub spans: &'a Spans,
    /// Of each span the error of its reach, and its pressure along the chord where that may buckle it.
    of_spans: Vec<(f64, Option<Found>)>,
    /// The cables, for distances between them and from obstacles.
    pub cables: &'a Cables<'a>,
    /// Poses of the obstacles.
    pub poses: Vec<Pose>,
    /// Twist of each branch at rest, at its temperature, rad/m.
    rest_twists: Vec<f64>,
}

impl<'a> Equilibrium<'a> {
    /// The equilibrium at `state`, with its results; `began`: the state at the beginning of the increment.
    pub fn new<'n: 'a>(
        problem: &mut Problem<'n>,
        (state, began): (&State, &State),
        (branches, constraints, operations): Results<'a>,
        (cables, spans): (&'a Cables<'a>, &'a Spans),
        (errors, driven): (&'a [NodalErrors], Option<&'a [Driven]>),
        (step, ends_step): (Option<usize>, bool),
    ) -> Self {
        let network = problem.network;
        let contact_forces = problem.contact_forces(state);
        let contact_errors = match contact_forces.is_empty() {
            true => vec![0.0; branches.len()],
            false => contact_errors(network, branches, spans, &problem.touching_points(state)),
        };
        let active = (0..network.constraints.len()).filter(|f| problem.conditions().active[*f]);
        let constraints = active.zip(constraints).collect();
        let moved = network.branches.iter().map(|branch| {
            let points = branch.points.clone();
            let moves = points.map(|k| (state.points[k] - began.points[k]).norm());
            moves.fold(0.0, f64::max)
        });
        // Where the section twists linearly the twist follows from the moment.
        let rest_twists = (0..network.branches.len()).map(|b| {
            if network.branches[b].twists_linearly() {
                return 0.0;
            }
            let at_rest = network.branches[b].rod.linear_law().map_or(0.0, |law| law.curvature.z);
            at_rest + problem.shape(state, b).extra_curvature.first().map_or(0.0, |extra| extra.z)
        });
        let rest_twists = rest_twists.collect();
        let moved = moved.collect();
        let mut equilibrium = Self {
            network,
            branches,
            errors,
            driven,
            constraints,
            operations,
            contact_forces,
            contact_errors,
            moved,
            ends_step,
            step,
            spans,
            of_spans: Vec::new(),
            cables,
            poses: problem.conditions().contact.poses.clone(),
            rest_twists,
        };
        let values = |span| (equilibrium.reach_error(span), equilibrium.pressed(span));
        equilibrium.of_spans = equilibrium.spans.all.iter().map(values).collect();
        equilibrium
    }

    /// The values of a requirement at all its places; empty where it does not count.
    pub fn values(&self, requirement: &Requirement) -> Vec<Found> {
        let mut found = Vec::new();
        let in_steps = |steps: &Vec<usize>| self.step.is_some_and(|step| steps.contains(&step));
        if requirement.steps.as_ref().is_none_or(in_steps) {
            for part in requirement.of.iter().filter(|part| self.counts(requirement.motion, part)) {
                self.add(requirement, part, &mut found);
            }
        }
        found
    }

    /// Whether the motion of a part is the one in which a requirement counts.
    fn counts(&self, motion: Motion, part: &Part) -> bool {
        let Part::Branch { branch, .. } = *part else { return true };
        let moves = self.moved[branch] > MOVING * self.network.branches[branch].sections.thinnest();
        match motion {
            Motion::Any => true,
            Motion::Moving => moves,
            Motion::Rest => !moves || self.ends_step,
        }
    }

    fn add(&self, requirement: &Requirement, part: &Part, found: &mut Vec<Found>) {
        match *part {
            Part::Branch { branch, from, to } => self.add_branch(requirement, branch, (from, to), found),
            Part::Constraint(f) => self.add_constraint(requirement, f, found),
            Part::Obstacle(o) if requirement.measure == Measure::ContactForce => {
                let forces = (0..self.branches.len()).map(|b| (b, self.contact_force(b, Against::Obstacle(o))));
                // Where most of it acts.
                let most = forces.clone().max_by(|a, b| a.1.total_cmp(&b.1));
                let branch = most.filter(|most| most.1 > 0.0).map(|most| self.branches[most.0].name.clone());
                let obstacle = Some(self.network.obstacles[o].name.clone());
                let place = EventPlace { obstacle, branch, ..EventPlace::default() };
                let error = forces.clone().map(|(b, force)| self.contact_error(b, force)).sum();
                found.push(Found { error: Some(error), ..at(forces.map(|(_, force)| force).sum(), place) });
            }
            Part::Obstacle(_) if requirement.measure == Measure::Clearance => {
                let branches = (0..self.branches.len()).map(CablePart::whole);
                found.extend(branches.filter_map(|branch| self.clearance(branch, part)));
            }
            Part::Obstacle(_) => {}
        }
    }

    fn add_constraint(&self, requirement: &Requirement, f: usize, found: &mut Vec<Found>) {
        let name = &self.network.constraints[f].name;
        let place = || EventPlace::constraint(name);
        if requirement.measure == Measure::InsertionForce {
            for operation in self.operations {
                if let OperationResult::Mate { constraint, insertion_force: Some(force), .. } = operation
                    && constraint == name
                {
                    let error = Some(self.at_constraint(f, |errors| &errors.force));
                    found.push(Found { error, ..at(*force, place()) });
                }
            }
            return;
        }
        let Some(result) = self.constraints.get(&f) else { return };
        match requirement.measure {
            Measure::Force => {
                let error = Some(self.at_constraint(f, |errors| &errors.force));
                found.push(Found { error, ..at(result.largest_force(), place()) });
            }
            Measure::Moment => {
                let error = Some(self.at_constraint(f, |errors| &errors.moment));
                found.push(Found { error, ..at(result.largest_moment(), place()) });
            }
            Measure::Clearance => {
                let radius = 0.5 * self.network.diameter_at(self.network.constraints[f].place);
                for part in &requirement.against {
                    let Part::Obstacle(o) = *part else { continue };
                    let obstacle = &self.network.obstacles[o];
                    let value = clearance::of_held_point(obstacle, &self.poses[o], &result.position, radius);
                    found.push(at(value, EventPlace { obstacle: Some(obstacle.name.clone()), ..place() }));
                }
            }
            Measure::Overlap => {
                let Some(all) = self.driven.filter(|_| driven::holds_a_place(&self.network.constraints[f])) else {
                    return;
                };
                for driven in all.iter().filter(|driven| driven.constraint == f) {
                    let obstacle = Some(self.network.obstacles[driven.obstacle].name.clone());
                    let found_here = at(driven.depth, EventPlace { obstacle, ..place() });
                    found.push(Found { limit: Some(driven.allowed), error: Some(0.0), ..found_here });
                }
                // No other body is driven into it.
                let radius = 0.5 * self.network.diameter_at(self.network.constraints[f].place);
                found.push(Found { limit: Some(radius), error: Some(0.0), ..at(0.0, EventPlace::default()) });
            }
            _ => {}
        }
    }

    /// Error of the position of a branch at an arc length, m.
    fn position_error(&self, branch: usize, s: f64) -> f64 {
        let segments = segments_at(&self.branches[branch].s, s);
        let nodes = *segments.start()..=segments.end() + 1;
        self.errors[branch].position[nodes].iter().copied().fold(0.0, f64::max)
    }

    /// Error of the line through the nodes of a branch at an arc length, m: that of their positions, and the height of
    /// the centre line over the chord between them, `ℓ²/(8 R)`.
    fn line_error(&self, branch: usize, s: f64) -> f64 {
        let own = &self.branches[branch];
        let height = |segment: usize| {
            let length = own.s[segment + 1] - own.s[segment];
            length * length / (8.0 * own.bend_radius[segment].min(own.bend_radius[segment + 1]))
        };
        self.position_error(branch, s) + segments_at(&own.s, s).map(height).fold(0.0, f64::max)
    }

    /// Sum of the errors of the positions of the ends of a span that are not held, m.
    fn ends_error(&self, span: &CableSpan) -> f64 {
        let error = |((branch, s), known): ((usize, f64), EndKnown)| match known {
            EndKnown::Place => 0.0,
            // Where the ring is on the cable is as uncertain as where the cable is.
            EndKnown::Slides => self.errors[branch].position.iter().copied().fold(0.0, f64::max),
            EndKnown::No => self.position_error(branch, s),
        };
        span.ends().into_iter().zip(span.known).map(error).sum()
    }

    /// Error of the distance that a span bridges over its length: that of its ends. The true value is no larger than
    /// one and the largest strain: a chord is no longer than its cable.
    fn reach_error(&self, span: &CableSpan) -> f64 {
        let strain = |piece: &Piece| {
            let (b, own) = (piece.branch, &self.branches[piece.branch]);
            let tension = |i: usize| {
                let d3 = own.frame[i] * Vector::z();
                let tensions = part::forces_around(own, i).map(|force| force.dot(&d3));
                tensions[0].max(tensions[1]) + self.errors[b].force[i]
            };
            let most = piece.in_order().map(tension).fold(0.0, f64::max);
            let strain = |i: usize| self.network.branches[b].strain_under(i, most).0;
            piece.segments().map(strain).fold(0.0, f64::max)
        };
        let strain = span.pieces.iter().map(strain).fold(0.0, f64::max);
        (self.ends_error(span) / span.length).min((1.0 + strain - span.chord / span.length).max(0.0))
    }

    /// Error of the reaction of a constraint: the sum of those of the internal forces (moments) around it.
    fn at_constraint(&self, f: usize, errors: impl Fn(&NodalErrors) -> &Vec<f64>) -> f64 {
        let constraint = &self.network.constraints[f];
        let of_node = |branch: usize, node: usize| {
            let inner = node > 0 && node + 1 < self.branches[branch].s.len();
            errors(&self.errors[branch])[node] * if inner { 2.0 } else { 1.0 }
        };
        let of_place = |place: &Place| match *place {
            Place::Node { branch, node } => of_node(branch, node),
            Place::Joint(joint) => {
                let joint = &self.network.joints[joint];
                let arms = joint.arms.iter().zip(&joint.branches);
                let end = |branch: usize| self.branches[branch].s.len() - 1;
                arms.map(|(arm, &b)| of_node(b, if arm.starts_here { 0 } else { end(b) })).sum()
            }
        };
        let of_span = |span: &Span| {
            let first = self.network.branches[span.branch].points.start;
            of_node(span.branch, span.points.start - first) + of_node(span.branch, span.points.end - 1 - first)
        };
        let of_places: f64 = constraint.places.iter().map(of_place).sum();
        of_places + constraint.span.iter().map(of_span).sum::<f64>()
    }

    /// Share of the error of curvature or torsion of a node that a place has, by this stiffness: where the section
    /// changes, a node has the error of the softer side, and that of the moment is the same on both.
    fn share_of_error(&self, b: usize, place: &Local, stiffness: fn(&Section) -> f64) -> f64 {
        let sections = &self.network.branches[b].sections;
        if place.fraction > 0.0 || !sections.changes().any(|node| node == place.node) {
            return 1.0;
        }
        let [before, after] = sections.beside(place.node).map(stiffness);
        before.min(after) / stiffness(sections.of(place.segment))
    }

    fn add_branch(&self, requirement: &Requirement, b: usize, (from, to): (f64, f64), found: &mut Vec<Found>) {
        let (branch, own) = (&self.branches[b], &self.network.branches[b]);
        let errors = &self.errors[b];
        // Only the least and the greatest value, as computed or with their errors, can be the worst. `widened`: values
        // between nodes may be beyond those at them; at the ends of a part there are no nodes.
        let places = |widened: bool,
                      found: &mut Vec<Found>,
                      value: &dyn Fn(&Local) -> f64,
                      error: &dyn Fn(&Local) -> f64| {
            let part = PartOfBranch::new(branch, from, to);
            let all: Vec<(&Local, f64, f64)> = part
                .values(value)
                .map(|(place, value, between)| {
                    let between = if widened || place.fraction > 0.0 { between } else { 0.0 };
                    (place, value, error(place) + between)
                })
                .collect();
            let least = |sign: f64, doubt: f64| {
                let score = |k: usize| sign * all[k].1 - doubt * all[k].2;
                (0..all.len()).min_by(|a, b| score(*a).total_cmp(&score(*b)))
            };
            let mut ends = [(1.0, 0.0), (1.0, 1.0), (-1.0, 0.0), (-1.0, 1.0)].map(|(sign, doubt)| least(sign, doubt));
            ends.sort();
            let mut last_found = None;
            for k in ends.into_iter().flatten() {
                if last_found.replace(k) != Some(k) {
                    let (place, value, error) = all[k];
                    found.push(Found { error: Some(error), ..at(value, EventPlace::branch(&branch.name, place.s)) });
                }
            }
        };
        let force = &|place: &Local| place.error(|i| errors.force[i]);
        let torsion = &|place: &Local| {
            let share = self.share_of_error(b, place, |section| section.torsion_stiffness);
            place.error(|i| errors.torsion[i] * share)
        };
        match requirement.measure {
            Measure::BendRadius => {
                let error = |place: &Local| {
                    let share = self.share_of_error(b, place, |section| softest_bending(&section.sticking_stiffness()));
                    place.error(|i| errors.curvature[i] * share + errors.between[i])
                };
                let mut bends = Vec::new();
                places(false, &mut bends, &|place| 1.0 / place.bend_radius, &error);
                if let Some((node, s, bend)) = requirement.max.and_then(|_| part::straightest(branch, from, to)) {
                    let error = errors.curvature[node].max(errors.curvature[node + 1]);
                    bends.push(Found { error: Some(error), ..at(bend, EventPlace::branch(&branch.name, s)) });
                }
                found.extend(bends.into_iter().map(|bend| {
                    let radius = 1.0 / bend.value;
                    let error = radius_error(requirement, radius, bend.error.unwrap_or(0.0));
                    Found { value: radius, error: Some(error), ..bend }
                }));
            }
            Measure::Tension => places(true, found, &Local::tension, force),
            Measure::Compression => places(true, found, &|place| -place.tension(), force),
            Measure::Strain => {
                let error = |place: &Local| force(place) / own.strain_under(place.segment, place.tension()).1;
                places(true, found, &|place| own.strain_under(place.segment, place.tension()).0, &error);
            }
            Measure::Torsion if own.twists_linearly() => {
                let section = |place: &Local| own.sections.of(place.segment);
                let moment = |place: &Local| place.frame.inverse_transform_vector(&place.moment);
                places(true, found, &|place| section(place).curvature_under(&moment(place)).z.abs(), torsion);
            }
            Measure::Torsion => places(true, found, &|place| self.twist(b, place.node).abs(), torsion),
            Measure::Deviation => {
                let distance = |place: &Local| deviation::distance_from(&own.drawn, &place.position);
                places(false, found, &distance, &|place| place.error(|i| errors.position[i]));
            }
            Measure::Turns => {
                let place = EventPlace { branch: Some(branch.name.clone()), ..EventPlace::default() };
                // The integral of the error of the twist.
                let pairs = branch.s.windows(2).zip(errors.twist.windows(2));
                let turned: f64 = pairs.map(|(s, e)| 0.5 * (e[0] + e[1]) * (s[1] - s[0])).sum();
                found.push(Found { error: Some(turned / TAU), ..at(branch.twist_turns.abs(), place) });
            }
            Measure::Slack => {
                let (from, to) = (from.max(branch.s[0]), to.min(branch.s[branch.s.len() - 1]));
                let between = result::position_at(branch, to) - result::position_at(branch, from);
                let error = [from, to].map(|s| self.position_error(b, s)).iter().sum();
                let place = EventPlace::branch(&branch.name, 0.5 * (from + to));
                let length = (to - from) * (1.0 + self.spans.free_strains[b]);
                found.push(Found { error: Some(error), ..at(length - between.norm(), place) });
            }
            Measure::Reach => {
                for k in self.spans.of(b) {
                    let (span, error) = (&self.spans.all[k], Some(self.of_spans[k].0));
                    if !span.meets(b, [from, to]) {
                        continue;
                    }
                    let place = span.place(self.network, b);
                    let limit = Some(requirement.max.unwrap_or(1.0) + span.tolerance);
                    found.push(Found { limit, error, ..at(span.chord / span.length, place) });
                }
            }
            Measure::Buckling => found.extend(self.spans.of(b).filter_map(|k| self.of_spans[k].1.clone())),
            Measure::Clearance => {
                let part = CablePart { branch: b, from, to };
                found.extend(requirement.against.iter().filter_map(|other| self.clearance(part, other)));
            }
            Measure::Overlap => {
                for overlap in self.cables.overlaps().iter().filter(|overlap| overlap.branches[0] == b) {
                    let place = EventPlace {
                        other_branch: Some(self.branches[overlap.branches[1]].name.clone()),
                        other_s: Some(overlap.s[1]),
                        ..EventPlace::branch(&branch.name, overlap.s[0])
                    };
                    found.push(Found { limit: Some(overlap.allowed), ..at(overlap.depth, place) });
                }
                // Cables that do not touch lie in each other by nothing.
                found.push(at(0.0, EventPlace::default()));
            }
            Measure::ContactForce => {
                for part in &requirement.against {
                    let place = EventPlace { branch: Some(branch.name.clone()), ..EventPlace::default() };
                    let (touched, place) = match *part {
                        Part::Obstacle(o) => {
                            let obstacle = Some(self.network.obstacles[o].name.clone());
                            (Against::Obstacle(o), EventPlace { obstacle, ..place })
                        }
                        Part::Branch { branch: other, .. } => {
                            let other_branch = Some(self.branches[other].name.clone());
                            (Against::Branch(other), EventPlace { other_branch, ..place })
                        }
                        Part::Constraint(_) => continue,
                    };
                    let force = self.contact_force(b, touched);
                    found.push(Found { error: Some(self.contact_error(b, force)), ..at(force, place) });
                }
            }
            _ => {}
        }
    }

    /// Clearance of a part of a branch from an obstacle, or from a part of another branch (or of the same one, where
    /// they have nothing in common); `None` where there is nothing to measure.
    /// What touches is held apart by the contact, whatever the error of its position: there is none then.
    fn clearance(&self, part: CablePart, from: &Part) -> Option<Found> {
        let name = &self.branches[part.branch].name;
        match *from {
            Part::Obstacle(o) => {
                let obstacle = &self.network.obstacles[o];
                let lines::Place { distance, s, .. } =
                    self.cables.clearance_from_obstacle(part, obstacle, &self.poses[o]);
                let obstacle = Some(obstacle.name.clone());
                let radius = self.cables.radius_at(part.branch, s);
                let touches =
                    self.contact_force(part.branch, Against::Obstacle(o)) > 0.0 && distance.abs() <= IN_TOUCH * radius;
                let error = (!touches).then(|| self.line_error(part.branch, s));
                let place = EventPlace { obstacle, ..EventPlace::branch(name, s) };
                Some(Found { error, ..at(if touches { in_touch(distance, radius) } else { distance }, place) })
            }
            Part::Branch { branch, from, to } => {
                let other = CablePart { branch, from, to };
                let shared = branch == part.branch && from < part.to && part.from < to;
                let pair = self.cables.clearance_from_branch(part, other).filter(|_| !shared)?;
                let place = EventPlace {
                    other_branch: Some(self.branches[branch].name.clone()),
                    other_s: Some(pair.s[1]),
                    ..EventPlace::branch(name, pair.s[0])
                };
                let own = [(part.branch, pair.s[0]), (branch, pair.s[1])];
                let radii = own.map(|(b, s)| self.cables.radius_at(b, s)).iter().sum::<f64>();
                // Cables that lie side by side touch on their chords.
                let beside: f64 = own.map(|(b, s)| self.cables.beside(b, s)).iter().sum();
                let touches = (self.contact_force(part.branch, Against::Branch(branch)) > 0.0
                    || self.contact_force(branch, Against::Branch(part.branch)) > 0.0)
                    && pair.distance.abs() <= IN_TOUCH * radii + beside;
                let error = (!touches).then(|| own.map(|(b, s)| self.line_error(b, s)).iter().sum());
                let distance = if touches { 0.0 } else { pair.distance };
                Some(Found { error, ..at(distance, place) })
            }
            Part::Constraint(_) => None,
        }
    }

    /// Twist per length at a node beyond that at rest, rad/m, from the frames beside it.
    fn twist(&self, b: usize, node: usize) -> f64 {
        let branch = &self.branches[b];
        let (before, after) = (node.saturating_sub(1), (node + 1).min(branch.s.len() - 1));
        let turned = (branch.frame[before].inverse() * branch.frame[after]).scaled_axis().z;
        turned / (branch.s[after] - branch.s[before]) - self.rest_twists[b]
    }

    /// Force with which a straight span is pressed along its chord, N, and that above which it is not stable even
    /// between clamped ends. A span that has buckled bears at most 1 % more while it is nearly straight (Timoshenko &
    /// Gere 1961, section 2.7). None where something supports the span from the side.
    fn pressed(&self, span: &CableSpan) -> Option<Found> {
        let touches = |piece: &Piece| self.contact_forces.keys().any(|(touching, _)| *touching == piece.branch);
        if !span.alone || span.pieces.iter().any(touches) {
            return None;
        }
        // Nodes in order, each with the force of the cable before it on that behind it.
        let nodes = |piece: &Piece| {
            let (piece, branch) = (*piece, &self.branches[piece.branch]);
            let [first, last] = piece.nodes;
            // Of both sides of a node those within the piece.
            let sides = move |i: usize| {
                let [before, after] = if first < last { [0, 1] } else { [1, 0] };
                let forces = part::forces_around(branch, i);
                let within = [(i != first).then_some(before), (i != last).then_some(after)];
                within.into_iter().flatten().map(move |side| forces[side])
            };
            let signed =
                move |i: usize| sides(i).map(move |force| (piece.branch, i, branch.position[i], -piece.sign() * force));
            piece.in_order().flat_map(signed)
        };
        let nodes: Vec<_> = span.pieces.iter().flat_map(nodes).collect();
        let way: f64 = nodes.windows(2).map(|pair| (pair[1].2 - pair[0].2).norm()).sum();
        if way > STRAIGHT * span.chord {
            return None;
        }
        // By so much the whole span is pressed along its chord.
        let along = (nodes[nodes.len() - 1].2 - nodes[0].2).try_normalize(0.0).unwrap_or_default();
        let pressed = nodes.iter().map(|(branch, i, _, force)| (*branch, *i, force.dot(&along)));
        let limit = Some(BUCKLED * span.euler(self.network));
        pressed.min_by(|a, b| a.2.total_cmp(&b.2)).map(|(branch, i, force)| {
            let place = EventPlace::branch(&self.branches[branch].name, self.branches[branch].s[i]);
            // The chord turns as its ends move.
            let turned = self.ends_error(span) / span.chord * part::forces_around(&self.branches[branch], i)[0].norm();
            Found { limit, error: Some(self.errors[branch].force[i] + turned), ..at(force, place) }
        })
    }

    /// Error of a contact force on a branch, N.
    fn contact_error(&self, branch: usize, force: f64) -> f64 {
        force * self.contact_errors[branch].min(1.0)
    }

    /// Sum of the sizes of the contact forces on a branch, N.
    fn contact_force(&self, branch: usize, touched: Against) -> f64 {
        self.contact_forces.get(&(branch, touched)).copied().unwrap_or(0.0)
    }
}

/// Errors of the contact forces on each branch, as a fraction of them; `touching` marks the points in contact.
///
/// A cable touches a body at its nodes and some points between them: where it begins to touch is known to a segment of
/// length h on either side, of the length L of the branch, which is 2 h/L. A body that presses a span of length l
/// between supports bends a mesh of l/h segments, with an error below (3 h/l)²: found with clamped spans of 4 to 16
/// segments that are pressed at a node. A cable that is bent round a body with the radius R has the curvature of its
/// chords, with an error of (h/R)². The larger one of these two counts.
fn contact_errors(network: &Network, branches: &[BranchResult], spans: &Spans, touching: &[bool]) -> Vec<f64> {
    let touches = |branch: usize, segment: usize| {
        let point = network.branches[branch].points.start + segment;
        touching[point] && touching[point + 1]
    };
    let lengths = |branch: usize| &network.branches[branch].rod.mesh().rest_lengths;
    let longest = |lengths: &[f64]| lengths.iter().copied().fold(0.0, f64::max);
    // The larger error of each branch, as a ratio of lengths.
    let mut ratios = vec![0.0_f64; branches.len()];
    for (b, (ratio, result)) in ratios.iter_mut().zip(branches).enumerate() {
        for segment in (0..lengths(b).len()).filter(|segment| touches(b, *segment)) {
            let radius = result.bend_radius[segment].min(result.bend_radius[segment + 1]);
            *ratio = ratio.max(lengths(b)[segment] / radius);
        }
    }
    for span in &spans.all {
        for piece in &span.pieces {
            let [one, other] = piece.nodes;
            let segments = one.min(other)..one.max(other);
            if segments.clone().any(|segment| touches(piece.branch, segment)) {
                let ratio = &mut ratios[piece.branch];
                *ratio = ratio.max(3.0 * longest(&lengths(piece.branch)[segments]) / span.length);
            }
        }
    }
    let error =
        |(b, ratio): (usize, f64)| 2.0 * longest(lengths(b)) / network.branches[b].rod.mesh().length() + ratio.powi(2);
    ratios.into_iter().enumerate().map(error).collect()
}

/// The distance of a body from a cable of this radius that touches it, m: that they lie in each other as far as contact
/// allows is no overlap.
fn in_touch(distance: f64, radius: f64) -> f64 {
    if (-IN_TOUCH * radius..0.0).contains(&distance) { 0.0 } else { distance }
}

fn at(value: f64, place: EventPlace) -> Found {
    Found { value, error: None, limit: None, place }
}

/// Segments between these nodes at an arc length: at a node those on both sides of it.
fn segments_at(nodes: &[f64], s: f64) -> RangeInclusive<usize> {
    let (last, near) = (nodes.len() - 2, SAME_PLACE * nodes[nodes.len() - 1]);
    let first = nodes.partition_point(|node| *node < s - near).saturating_sub(1);
    let behind = nodes.partition_point(|node| *node <= s + near).saturating_sub(1);
    first.min(last)..=behind.min(last)
}

/// Error of a bend radius R (m) whose curvature has the error e (1/m): by so much the true one may be smaller, and
/// where it has a greatest value larger, infinitely where the cable may be straight.
fn radius_error(requirement: &Requirement, radius: f64, e: f64) -> f64 {
    if !radius.is_finite() {
        return 0.0;
    }
    let below = radius - 1.0 / (1.0 / radius + e);
    let above = 1.0 / (1.0 / radius - e).max(0.0) - radius;
    if requirement.max.is_some() { above.max(below) } else { below }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The segment behind a node may be the longer one: the cable is farther from its chord.
    #[test]
    fn a_node_is_in_the_segments_on_both_sides_of_it() {
        let nodes = [0.0, 0.1, 0.2, 0.5];
        for (s, segments) in [
            (0.0, 0..=0),
            (0.05, 0..=0),
            (0.1, 0..=1),
            (0.2 - 1e-13, 1..=2),
            (0.2 + 1e-13, 1..=2),
            (0.3, 2..=2),
            (0.5, 2..=2),
        ] {
            assert_eq!(segments_at(&nodes, s), segments, "{s}");
        }
    }
}
