//! The harness as a graph of branches, joints and constraints, and their indices in a [`crate::State`].

use crate::constitutive::Past;
use crate::constraint::{Constraint, Limits, Residual, Slide};
use crate::joint::{Arm, Continuation, JointModel, Mounting};
use crate::load::LoadAction;
use crate::mechanism::{Mechanism, Mount};
use crate::obstacle::{ContactSettings, Obstacle};
use crate::quantity::Output;
use crate::requirement::{Marker, Requirement, distinct_names};
use crate::rod::RodSegment;
use crate::{Pose, Rotation, Section, Sections, Vector};
use rayon::prelude::*;
use std::ops::Range;

/// Connection of one end of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BranchEnd {
    /// A free end, with a station.
    Free,
    /// A joint.
    Joint {
        /// Index of the joint.
        joint: usize,
        /// Index of the arm.
        arm: usize,
    },
}

/// Input for a branch of a network.
pub struct BranchPlan {
    /// Name.
    pub name: String,
    /// Kind of its rod, as scenarios name it.
    pub kind: String,
    /// Its section, or those of its spans; where two spans meet its mesh has a station.
    pub sections: Sections,
    /// The rod.
    pub rod: Box<dyn RodSegment>,
    /// Centre line along which it is laid at first, from start to end, world coordinates, m; empty if none is given.
    pub path: Vec<Vector>,
    /// Drawn centre line, with which results are compared, likewise; empty if none is drawn.
    pub drawn: Vec<Vector>,
}

/// Input for a joint of a network.
pub struct JointPlan {
    /// Name of the vertex.
    pub name: String,
    /// Kind of its model, as scenarios name it.
    pub kind: String,
    /// Its model.
    pub model: Box<dyn JointModel>,
    /// The arms; `starts_here` tells which end of the branch is attached.
    pub arms: Vec<Arm>,
    /// Index of each arm's branch.
    pub branches: Vec<usize>,
    /// Mass, kg.
    pub mass: f64,
}

/// Place where a constraint or load attaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Node of a branch.
    Node {
        /// Index of the branch.
        branch: usize,
        /// Index of the node.
        node: usize,
    },
    /// A joint.
    Joint(usize),
}

/// Consecutive nodes of a branch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeRange {
    /// Index of the branch.
    pub branch: usize,
    /// The nodes.
    pub nodes: Range<usize>,
}

/// Span of a constraint in a network.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Index of the branch.
    pub branch: usize,
    /// Indices of its nodes in the state's points.
    pub points: Range<usize>,
    /// The independent site of each node: at a joint it is another point.
    pub sites: Vec<Site>,
}

/// Input for a constraint of a network.
pub struct ConstraintPlan {
    /// Name.
    pub name: String,
    /// Kind, as scenarios name it.
    pub kind: String,
    /// The model.
    pub model: Box<dyn Constraint>,
    /// Outputs that its kind declares.
    pub outputs: Vec<Output>,
    /// Its stations.
    pub stations: Vec<Place>,
    /// The nodes of a branch along which it acts.
    pub span: Option<NodeRange>,
    /// Target position; `None`: its position when it begins to act.
    pub position: Option<Vector>,
    /// Target tangent.
    pub tangent: Option<Vector>,
    /// Target orientation.
    pub orientation: Option<Rotation>,
    /// Body of a mechanism that carries it.
    pub mount: Option<Mount>,
    /// Sliding of the cable through it; `None` if it does not slide.
    pub slide: Option<Slide>,
    /// Load limits.
    pub limits: Limits,
    /// Whether it attaches to the point of the cable nearest to its position when it begins to act; until then its
    /// place is provisional.
    pub nearest: bool,
    /// Whether it acts from the start of the run (otherwise a step adds it).
    pub from_start: bool,
}

/// Input for a load of a network.
#[derive(Clone, Debug)]
pub struct LoadPlan {
    /// Name.
    pub name: String,
    /// What it exerts, and where.
    pub action: LoadAction<Place, NodeRange>,
    /// Factor at the start of the run.
    pub factor: f64,
}

/// Branch of a network.
pub struct Branch {
    /// Name.
    pub name: String,
    /// Kind of its rod.
    pub kind: String,
    /// Its section, or those of its spans.
    pub sections: Sections,
    /// The rod.
    pub rod: Box<dyn RodSegment>,
    /// Centre line at the start; see [`BranchPlan::path`].
    pub path: Vec<Vector>,
    /// Drawn centre line; see [`BranchPlan::drawn`].
    pub drawn: Vec<Vector>,
    /// Indices of its nodes in the state's points.
    pub points: Range<usize>,
    /// Indices of its row of frames in the state's frames.
    pub frames: Range<usize>,
    /// Connection of its start.
    pub start: BranchEnd,
    /// Connection of its end.
    pub end: BranchEnd,
    /// Whether its mesh may move along the cable: a constraint slides on it, or attaches to its nearest point.
    pub mesh_moves: bool,
}

impl Branch {
    /// Axial strain of a segment under a tension (N), and the derivative of the tension in it (N).
    pub fn strain_under(&self, segment: usize, tension: f64) -> (f64, f64) {
        match self.rod.constitutive().and_then(|laws| laws.stretch.as_deref()) {
            Some(law) => {
                let strain = law.strain_under(&(Vector::z() * tension), Past::default());
                // Under an axial force alone: the compliance along d3.
                let compliance =
                    law.at(&strain, Past::default()).hessian.try_inverse().map_or(f64::NAN, |inverse| inverse.m33);
                (strain.z, compliance.recip())
            }
            None => {
                let section = self.sections.of(segment);
                (section.strain(tension), section.stiffness_at(tension))
            }
        }
    }

    /// Its mass, kg.
    pub fn mass(&self) -> f64 {
        let lengths = self.rod.mesh().rest_lengths.iter().enumerate();
        lengths.map(|(j, length)| self.sections.of(j).linear_density * length).sum()
    }

    /// Radius of each segment, m.
    pub fn radii(&self) -> Vec<f64> {
        (0..self.rod.mesh().segments()).map(|segment| 0.5 * self.sections.of(segment).diameter).collect()
    }

    /// Whether it has an axial law of its own in place of EA.
    pub fn has_axial_law(&self) -> bool {
        self.sections.iter().any(|section| section.laws.axial.is_some())
            || self.rod.constitutive().is_some_and(|laws| laws.stretch.is_some())
    }

    /// Whether its moment is EI κ in bending.
    pub fn bends_linearly(&self) -> bool {
        self.sections.iter().all(Section::bends_linearly) && !self.has_own_bending()
    }

    /// Whether its twist follows from its moment by C alone.
    pub fn twists_linearly(&self) -> bool {
        self.sections.iter().all(Section::twists_linearly) && !self.has_own_bending()
    }

    /// Whether it keeps a set: something in its section or in the laws of its rod slips, yields or relaxes.
    pub fn remembers(&self) -> bool {
        !self.rod.memory().is_empty()
    }

    fn has_own_bending(&self) -> bool {
        self.rod.constitutive().is_some_and(|laws| laws.bend.is_some())
    }

    /// Index of the frame of a segment in the state's frames.
    pub(crate) fn segment_frame(&self, segment: usize) -> usize {
        self.frames.start + self.rod.mesh().segment_frames[segment]
    }
}

/// Joint of a network.
pub struct Joint {
    /// Name of the vertex.
    pub name: String,
    /// Kind of its model.
    pub kind: String,
    /// Its model.
    pub model: Box<dyn JointModel>,
    /// The arms.
    pub arms: Vec<Arm>,
    /// Index of each arm's branch.
    pub branches: Vec<usize>,
    /// Mass, kg.
    pub mass: f64,
    /// Index of its point in the state.
    pub point: usize,
    /// Index of its frame in the state, if it has one.
    pub frame: Option<usize>,
    /// Frames coupled by the joint's energy, one for each arm: with [`Mounting::Point`] that of its segment at the
    /// joint, with [`Mounting::Stations`] and [`Mounting::CompliantHub`] that of its end; empty on a rigid hub.
    pub arm_frames: Vec<usize>,
    /// Frames that its energy depends on: those of the arms, then that of a compliant hub, or those of the second
    /// segments where the model continues the rods ([`JointModel::continue_rods`]).
    pub coupled_frames: Vec<usize>,
}

impl Joint {
    /// Length by which an arm adds to the weight of the hub's frame in a shifted Hessian, m: its offset and, on a
    /// compliant hub, which is part of no coupling of the arm, half a segment.
    pub fn lever(&self, arm: &Arm) -> f64 {
        let compliant = self.model.mounting() == Mounting::CompliantHub;
        let own = if compliant { 0.5 * arm.segment_length } else { 0.0 };
        own + arm.offset.norm()
    }
}

/// Site of a constraint or load: a pose that depends on independent variables of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Index of the point.
    pub point: usize,
    /// Index of the frame, if there is one.
    pub frame: Option<usize>,
    /// Pose of the station relative to that point and frame; the identity except on hubs.
    pub local: Pose,
}

/// Constraint of a network.
pub struct AttachedConstraint {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: String,
    /// The model.
    pub model: Box<dyn Constraint>,
    /// Outputs that its kind declares.
    pub outputs: Vec<Output>,
    /// Place of its first station, or of the first node of its span.
    pub place: Place,
    /// Site of that place in the state.
    pub site: Site,
    /// Places of all its stations.
    pub places: Vec<Place>,
    /// Sites of all its stations in the state.
    pub stations: Vec<Site>,
    /// The span along which it acts.
    pub span: Option<Span>,
    /// Its equations and inequalities: those of its stations, then those of its span, node by node.
    pub residuals: Vec<Residual>,
    /// Number of residuals of its stations.
    pub of_stations: usize,
    /// Target position, if given; that of what is mounted on a body as the mechanism is drawn, as all of its pose.
    pub position: Option<Vector>,
    /// Target tangent, if given.
    pub tangent: Option<Vector>,
    /// Target orientation, if given.
    pub orientation: Option<Rotation>,
    /// Body of a mechanism that carries it.
    pub mount: Option<Mount>,
    /// Sliding of the cable through it; `None` if it does not slide.
    pub slide: Option<Slide>,
    /// Load limits.
    pub limits: Limits,
    /// Whether it attaches to the point of the cable nearest to its position when it begins to act; until then its
    /// place is provisional.
    pub nearest: bool,
    /// Whether it acts from the start of the run.
    pub from_start: bool,
}

impl AttachedConstraint {
    /// Node of the span to which a residual belongs; `residual` is not one of the stations.
    pub(crate) fn node_of(&self, residual: usize) -> usize {
        let nodes = self.span.as_ref().map_or(1, |span| span.sites.len());
        (residual - self.of_stations) / ((self.residuals.len() - self.of_stations) / nodes)
    }
}

/// Site of a sliding constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlideSite {
    /// Index of the constraint.
    pub constraint: usize,
    /// Index of the branch.
    pub branch: usize,
    /// Node that stays at the constraint.
    pub node: usize,
    /// Coefficient of Coulomb friction.
    pub friction: f64,
}

/// Load of a network.
#[derive(Clone, Debug)]
pub struct Load {
    /// Name.
    pub name: String,
    /// What it exerts, and where.
    pub action: LoadAction<LoadSite, NodeRange>,
    /// Factor at the start of the run.
    pub factor: f64,
}

/// Site of a load at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadSite {
    /// Site where its moment acts, and that a follower turns with.
    pub site: Site,
    /// Index of the point that a dead force acts on: a node of the branch, even if it is tied to a joint.
    pub point: usize,
}

impl Load {
    /// Why it has no potential; `None` if it has one. At a joint without a frame its dead force alone acts.
    pub fn without_potential(&self) -> Option<&str> {
        match &self.action {
            LoadAction::At { place, .. } if place.site.frame.is_none() => None,
            action => action.without_potential(),
        }
    }
}

/// Tie: a dependent point, and on rigid hubs frame, of the state that follows a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tie {
    /// The end node of a branch.
    pub point: usize,
    /// The end station's frame, if the joint is a rigid hub.
    pub frame: Option<usize>,
    /// The joint's point.
    pub hub_point: usize,
    /// The joint's frame, if it is a hub.
    pub hub_frame: Option<usize>,
    /// Position of the end in the hub's frame, m.
    pub offset: Vector,
    /// Frame of the end in the hub's frame.
    pub rest: Rotation,
}

/// A whole harness.
///
/// Indices in a state: `points` holds the nodes of all branches, one branch after the other, then one point for each
/// joint; `frames` holds the rows of frames of all branches, then one frame for each joint that is a hub. The end nodes
/// (and on rigid hubs the end stations) of arms are tied to their joint.
pub struct Network {
    /// Unique number of the network in the process, by which workspaces recognise it.
    pub id: u64,
    /// Branches.
    pub branches: Vec<Branch>,
    /// Joints.
    pub joints: Vec<Joint>,
    /// Constraints of the whole scenario, whether they act from the start or are added later.
    pub constraints: Vec<AttachedConstraint>,
    /// Sites of the sliding constraints.
    pub slides: Vec<SlideSite>,
    /// Loads.
    pub loads: Vec<Load>,
    /// Points and frames that follow the joints.
    pub ties: Vec<Tie>,
    /// Whether the axes rotate at some time ([`crate::conditions::RotatingAxes`]).
    pub rotates: bool,
    /// Obstacles.
    pub obstacles: Vec<Obstacle>,
    /// Settings of contact.
    pub contact: ContactSettings,
    /// Mechanisms.
    pub mechanisms: Vec<Mechanism>,
    /// What is required of the harness.
    pub requirements: Vec<Requirement>,
    /// Markers.
    pub markers: Vec<Marker>,
    /// Number of points of a state.
    pub points: usize,
    /// Number of frames of a state.
    pub frames: usize,
}

/// Distance along the harness, in sums of both radii, below which two parts of it are neighbours, whose contact and
/// clearance are not considered: a cable whose bend radius is not less than its own radius does not touch itself there.
pub const APART: f64 = 2.5;

/// Number of points above which the evaluation of branches is worth another thread.
pub(crate) const WORTHWHILE: usize = 1024;

/// Number that is unique in the process, among networks and patterns of contact.
pub(crate) fn next_id() -> u64 {
    static NEXT: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
    NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed)
}

/// Joints within `reach` (m) of one, itself included, with their distances.
fn within_reach(neighbours: &[Vec<(usize, f64)>], joint: usize, reach: f64) -> Vec<(usize, f64)> {
    let mut near = vec![(joint, 0.0)];
    let mut next = 0;
    while let Some(&(at, travelled)) = near.get(next) {
        next += 1;
        for &(other, length) in &neighbours[at] {
            let distance = travelled + length;
            match near.iter_mut().find(|(known, _)| *known == other) {
                Some(known) if known.1 <= distance => {}
                Some(known) => known.1 = distance,
                None if distance < reach => near.push((other, distance)),
                None => {}
            }
        }
    }
    near
}

impl Network {
    /// Diameter of the cable at a place, m; at a joint that of the thickest arm.
    pub fn diameter_at(&self, place: Place) -> f64 {
        match place {
            Place::Node { branch, node } => {
                let [before, after] = self.branches[branch].sections.beside(node);
                before.diameter.max(after.diameter)
            }
            Place::Joint(joint) => self.joints[joint].arms.iter().map(|arm| arm.section.diameter).fold(0.0, f64::max),
        }
    }

    /// Radius of the cable along a segment of a branch, m.
    #[inline]
    pub fn radius(&self, branch: usize, segment: usize) -> f64 {
        0.5 * self.branches[branch].sections.of(segment).diameter
    }

    /// Names of its requirements, each another one ([`distinct_names`]).
    pub fn requirement_names(&self) -> Vec<String> {
        let own = self.requirements.iter().map(|own| (own.name.as_str(), own.origin, own.measure));
        distinct_names(&own.collect::<Vec<_>>())
    }

    /// For each joint the joints within `reach` (m) along the harness, with their distances; itself included, at 0.
    pub fn near_joints(&self, reach: f64) -> Vec<Vec<(usize, f64)>> {
        let mut neighbours: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.joints.len()];
        for branch in &self.branches {
            if let (BranchEnd::Joint { joint: a, .. }, BranchEnd::Joint { joint: b, .. }) = (branch.start, branch.end) {
                let length = branch.rod.mesh().length();
                neighbours[a].push((b, length));
                neighbours[b].push((a, length));
            }
        }
        (0..neighbours.len()).map(|joint| within_reach(&neighbours, joint, reach)).collect()
    }

    /// Network of these parts.
    ///
    /// # Panics
    /// If indices of the plans do not exist, a constraint has neither station nor span, a place that needs a frame is
    /// not a station, or the mesh of a rod has a station at a [`Mounting::Point`] joint or none at a free end or
    /// another joint. The check of the scenario excludes all of these.
    pub fn new(
        branches: Vec<BranchPlan>,
        joints: Vec<JointPlan>,
        constraints: Vec<ConstraintPlan>,
        loads: Vec<LoadPlan>,
    ) -> Self {
        let (mut points, mut frames) = (0, 0);
        let mut branches: Vec<Branch> = branches
            .into_iter()
            .map(|plan| {
                let mesh = plan.rod.mesh();
                let branch = Branch {
                    points: points..points + mesh.nodes(),
                    frames: frames..frames + mesh.frames(),
                    start: BranchEnd::Free,
                    end: BranchEnd::Free,
                    name: plan.name,
                    sections: plan.sections,
                    kind: plan.kind,
                    rod: plan.rod,
                    path: plan.path,
                    drawn: plan.drawn,
                    mesh_moves: false,
                };
                points = branch.points.end;
                frames = branch.frames.end;
                branch
            })
            .collect();
        let mut ties = Vec::new();
        let mut placed = Vec::new();
        for (index, mut plan) in joints.into_iter().enumerate() {
            let mounting = plan.model.mounting();
            let (hub, rigid) = (mounting.is_hub(), mounting == Mounting::Pose);
            let point = points;
            points += 1;
            let frame = hub.then_some(frames);
            frames += usize::from(hub);
            let (mut arm_frames, mut second_frames, mut continuations) = (Vec::new(), Vec::new(), Vec::new());
            for (a, (arm, &b)) in plan.arms.iter().zip(&plan.branches).enumerate() {
                let branch = &mut branches[b];
                let end = BranchEnd::Joint { joint: index, arm: a };
                let mesh = branch.rod.mesh();
                let (node, segment) = if arm.starts_here { (0, 0) } else { (mesh.segments(), mesh.segments() - 1) };
                if arm.starts_here {
                    branch.start = end;
                } else {
                    branch.end = end;
                }
                let station = mesh.station_frame(node);
                let fits = station.is_some() == (mounting != Mounting::Point);
                assert!(fits, "branch {}: stations do not fit joint {}", branch.name, plan.name);
                ties.push(Tie {
                    point: branch.points.start + node,
                    frame: station.filter(|_| rigid).map(|c| branch.frames.start + c),
                    hub_point: point,
                    hub_frame: frame,
                    offset: if hub { arm.offset } else { Vector::zeros() },
                    rest: arm.rest,
                });
                if !rigid {
                    arm_frames.push(branch.frames.start + station.unwrap_or(mesh.segment_frames[segment]));
                }
                if mounting == Mounting::Point && branch.rod.couples_pairs() && mesh.is_fine(segment) {
                    let (second, coupling) = if arm.starts_here { (1, 0) } else { (segment - 1, mesh.frames() - 2) };
                    second_frames.push(branch.frames.start + mesh.segment_frames[second]);
                    let variation = branch.rod.linear_law().map_or(0.0, |law| law.variation);
                    continuations.push(Some(Continuation { length: mesh.coupling_lengths[coupling], variation }));
                } else {
                    continuations.push(None);
                }
            }
            let mut coupled_frames = arm_frames.clone();
            coupled_frames.extend(frame.filter(|_| !rigid));
            if plan.model.continue_rods(&continuations) {
                assert_eq!(second_frames.len(), arm_frames.len(), "joint {} continues rods that end", plan.name);
                coupled_frames.extend(second_frames);
            }
            placed.push(Joint {
                name: plan.name,
                kind: plan.kind,
                model: plan.model,
                arms: plan.arms,
                branches: plan.branches,
                mass: plan.mass,
                point,
                frame,
                arm_frames,
                coupled_frames,
            });
        }
        let mut network = Self {
            id: next_id(),
            branches,
            joints: placed,
            constraints: Vec::new(),
            slides: Vec::new(),
            loads: Vec::new(),
            ties,
            rotates: false,
            obstacles: Vec::new(),
            contact: ContactSettings::default(),
            mechanisms: Vec::new(),
            requirements: Vec::new(),
            markers: Vec::new(),
            points,
            frames,
        };
        for plan in constraints {
            network.add_constraint(plan);
        }
        let placed = |plan: LoadPlan| Load {
            name: plan.name,
            action: plan.action.map(|place| network.load_site(*place), NodeRange::clone),
            factor: plan.factor,
        };
        network.loads = loads.into_iter().map(placed).collect();
        network
    }

    /// Site of a load at a place.
    pub fn load_site(&self, place: Place) -> LoadSite {
        let point = match place {
            Place::Joint(j) => self.joints[j].point,
            Place::Node { branch, node } => self.branches[branch].points.start + node,
        };
        LoadSite { site: self.site(place), point }
    }

    /// Adds a constraint.
    ///
    /// # Panics
    /// If its indices do not exist, or it has neither station nor span.
    pub fn add_constraint(&mut self, plan: ConstraintPlan) {
        let span = plan.span.map(|NodeRange { branch, nodes }| {
            let start = self.branches[branch].points.start;
            let sites = nodes.clone().map(|node| self.site(Place::Node { branch, node })).collect();
            Span { branch, points: start + nodes.start..start + nodes.end, sites }
        });
        let begin = |span: &Span| Place::Node {
            branch: span.branch,
            node: span.points.start - self.branches[span.branch].points.start,
        };
        let place = plan.stations.first().copied().or_else(|| span.as_ref().map(begin));
        let place = place.expect("a constraint has a station or a span");
        let (mut residuals, mut of_stations) = (Vec::new(), 0);
        if let Some(equations) = plan.model.action().equations() {
            residuals = equations.of_stations();
            of_stations = residuals.len();
            let nodes = span.iter().flat_map(|span| &span.sites);
            residuals.extend(nodes.flat_map(|_| equations.of_each_node()));
        }
        let constraint = AttachedConstraint {
            place,
            site: self.site(place),
            stations: plan.stations.iter().map(|&place| self.site(place)).collect(),
            places: plan.stations,
            span,
            residuals,
            of_stations,
            name: plan.name,
            kind: plan.kind,
            model: plan.model,
            outputs: plan.outputs,
            position: plan.position,
            tangent: plan.tangent,
            orientation: plan.orientation,
            mount: plan.mount,
            slide: plan.slide,
            limits: plan.limits,
            nearest: plan.nearest,
            from_start: plan.from_start,
        };
        if let (Some(slide), Place::Node { branch, node }) = (constraint.slide, place) {
            self.branches[branch].mesh_moves = true;
            self.slides.push(SlideSite { constraint: self.constraints.len(), branch, node, friction: slide.friction });
        }
        if let (true, Place::Node { branch, .. }) = (constraint.nearest, place) {
            self.branches[branch].mesh_moves = true;
        }
        self.constraints.push(constraint);
    }

    /// Site of a place: the independent point and frame on which its pose depends. The end of an arm on a hub, also on
    /// a compliant one, is a place on the hub.
    pub fn site(&self, place: Place) -> Site {
        match place {
            Place::Joint(j) => {
                Site { point: self.joints[j].point, frame: self.joints[j].frame, local: Pose::identity() }
            }
            Place::Node { branch, node } => {
                let b = &self.branches[branch];
                let end = match node {
                    0 => b.start,
                    _ if node == b.rod.mesh().segments() => b.end,
                    _ => BranchEnd::Free,
                };
                match end {
                    BranchEnd::Joint { joint, arm } => {
                        let joint = &self.joints[joint];
                        let at = |arm: &Arm| Pose { position: arm.offset, orientation: arm.rest };
                        let local = joint.frame.map_or_else(Pose::identity, |_| at(&joint.arms[arm]));
                        Site { point: joint.point, frame: joint.frame, local }
                    }
                    BranchEnd::Free => Site {
                        point: b.points.start + node,
                        frame: b.rod.mesh().station_frame(node).map(|c| b.frames.start + c),
                        local: Pose::identity(),
                    },
                }
            }
        }
    }

    /// Whether obstacles or cables rub where they touch.
    pub fn has_rough_contact(&self) -> bool {
        self.contact.friction > 0.0 || self.obstacles.iter().any(|obstacle| obstacle.friction > 0.0)
    }

    /// Whether the harness is large enough to evaluate its branches on several threads.
    pub fn is_shared(&self) -> bool {
        self.points >= 2 * WORTHWHILE
    }

    /// Calls `work` with every branch, its index and its own entry of `workspaces`; on several threads for large
    /// harnesses, so the result must not depend on the order.
    pub fn for_branches<R: Send>(&self, workspaces: &mut [R], work: impl Fn(usize, &Branch, &mut R) + Sync) {
        if self.is_shared() {
            let pairs = self.branches.par_iter().zip(workspaces);
            pairs.enumerate().for_each(|(b, (branch, workspace))| work(b, branch, workspace));
        } else {
            let pairs = self.branches.iter().zip(workspaces);
            pairs.enumerate().for_each(|(b, (branch, workspace))| work(b, branch, workspace));
        }
    }

    /// What `work` makes of each number below `count`, in their order; on several threads for large harnesses, so that
    /// one result must not depend on another.
    pub fn map<R: Send>(&self, count: usize, work: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
        if self.is_shared() { (0..count).into_par_iter().map(work).collect() } else { (0..count).map(work).collect() }
    }

    /// A load without a potential, and why it has none. Minimisers that need an energy refuse it.
    pub fn load_without_potential(&self) -> Option<(&Load, &str)> {
        self.loads.iter().find_map(|load| Some((load, load.without_potential()?)))
    }

    /// Connected components of the harness: the index of each branch's component, and the number of components.
    pub fn pieces(&self) -> (Vec<usize>, usize) {
        let mut piece = vec![usize::MAX; self.branches.len()];
        let mut count = 0;
        for first in 0..self.branches.len() {
            if piece[first] != usize::MAX {
                continue;
            }
            let mut open = vec![first];
            piece[first] = count;
            while let Some(b) = open.pop() {
                for end in [self.branches[b].start, self.branches[b].end] {
                    if let BranchEnd::Joint { joint, .. } = end {
                        for &other in &self.joints[joint].branches {
                            if piece[other] == usize::MAX {
                                piece[other] = count;
                                open.push(other);
                            }
                        }
                    }
                }
            }
            count += 1;
        }
        (piece, count)
    }
}
