//! The harness as a graph of branches, joints and constraints, and where each has its place in a [`crate::State`].

use crate::constraint::{Action, Constraint, Limits, Residual, Slide};
use crate::joint::{Arm, JointModel, Mounting};
use crate::obstacle::{ContactSettings, Obstacle};
use crate::rod::RodSegment;
use crate::{Pose, Rotation, Section, Vector};
use rayon::prelude::*;
use std::ops::Range;

/// What hangs at one end of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BranchEnd {
    /// Nothing: a free end with a station.
    Free,
    /// A joint, by index, and which of its arms this is.
    Joint {
        /// Index of the joint.
        joint: usize,
        /// Index of the arm.
        arm: usize,
    },
}

/// A branch before it has its place in the network.
pub struct BranchPlan {
    /// Name.
    pub name: String,
    /// Section.
    pub section: Section,
    /// The rod.
    pub rod: Box<dyn RodSegment>,
    /// Drawn centre line, from start to end, world coordinates, m; empty where none is drawn.
    pub path: Vec<Vector>,
}

/// A joint before it has its place in the network.
pub struct JointPlan {
    /// Name of the vertex.
    pub name: String,
    /// Kind of its model, as scenarios name it.
    pub kind: String,
    /// Its model.
    pub model: Box<dyn JointModel>,
    /// The arms; `starts_here` says at which end of its branch.
    pub arms: Vec<Arm>,
    /// Index of each arm's branch.
    pub branches: Vec<usize>,
    /// Mass, kg.
    pub mass: f64,
}

/// Where something attaches.
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

/// Some nodes of a branch, one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeRange {
    /// Index of the branch.
    pub branch: usize,
    /// The nodes.
    pub nodes: Range<usize>,
}

/// A span in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Index of the branch.
    pub branch: usize,
    /// Its nodes in the state's points.
    pub points: Range<usize>,
    /// What carries each of them: at a joint it is another point.
    pub sites: Vec<Site>,
}

/// A constraint before it has its place in the network.
pub struct ConstraintPlan {
    /// Name.
    pub name: String,
    /// Kind, as scenarios name it.
    pub kind: String,
    /// The model.
    pub model: Box<dyn Constraint>,
    /// Its stations.
    pub stations: Vec<Place>,
    /// The nodes of a branch along which it acts.
    pub span: Option<NodeRange>,
    /// Position it holds; left out: where it is when it begins.
    pub position: Option<Vector>,
    /// Tangent it holds.
    pub tangent: Option<Vector>,
    /// Whole orientation it holds.
    pub orientation: Option<Rotation>,
    /// Whether, and how, the cable runs through it.
    pub slide: Option<Slide>,
    /// What it bears.
    pub limits: Limits,
    /// Whether it closes where the cable is nearest to its position when it begins; its place is a provisional one until then.
    pub nearest: bool,
    /// Whether it acts from the beginning (or is added by a step).
    pub from_start: bool,
}

/// A dead load before it has its place in the network.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadPlan {
    /// Name.
    pub name: String,
    /// Where it acts.
    pub place: Place,
    /// Force, N, world axes.
    pub force: Vector,
    /// Moment, N m, world axes.
    pub moment: Vector,
    /// Factor at the beginning.
    pub factor: f64,
}

/// A branch in its place.
pub struct Branch {
    /// Name.
    pub name: String,
    /// Section.
    pub section: Section,
    /// The rod.
    pub rod: Box<dyn RodSegment>,
    /// Drawn centre line; see [`BranchPlan::path`].
    pub path: Vec<Vector>,
    /// Its nodes in the state's points.
    pub points: Range<usize>,
    /// Its row of frames in the state's frames.
    pub frames: Range<usize>,
    /// What hangs at its start.
    pub start: BranchEnd,
    /// What hangs at its end.
    pub end: BranchEnd,
    /// Whether its mesh may move along it, for a constraint slides on it or finds its place there.
    pub mesh_moves: bool,
}

impl Branch {
    /// Where the frame of a segment is in the state's frames.
    pub(crate) fn segment_frame(&self, segment: usize) -> usize {
        self.frames.start + self.rod.mesh().segment_frames[segment]
    }
}

/// A joint in its place.
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
    /// Its point in the state.
    pub point: usize,
    /// Its frame in the state, where it has one.
    pub frame: Option<usize>,
    /// What the joint's energy couples, one frame for each arm: with [`Mounting::Point`] that of its segment at the joint, with
    /// [`Mounting::Stations`] that of its end; none on a hub.
    pub arm_frames: Vec<usize>,
}

/// The place of a constraint or load in the state: a pose carried by independent variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Index of the point.
    pub point: usize,
    /// Index of the frame, where there is one.
    pub frame: Option<usize>,
    /// Pose of the station in that point and frame; identity but on hubs.
    pub local: Pose,
}

/// A constraint in its place.
pub struct AttachedConstraint {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: String,
    /// The model.
    pub model: Box<dyn Constraint>,
    /// Where it acts, as the scenario says: its first station, or where its span begins.
    pub place: Place,
    /// Where that is in the state.
    pub site: Site,
    /// All its stations, as the scenario says.
    pub places: Vec<Place>,
    /// Where they are in the state.
    pub stations: Vec<Site>,
    /// The nodes along which it acts.
    pub span: Option<Span>,
    /// Its equations and inequalities: so many of its stations, then those of its span, node by node.
    pub residuals: Vec<Residual>,
    /// How many of them are of its stations.
    pub of_stations: usize,
    /// Position it holds, where given.
    pub position: Option<Vector>,
    /// Tangent it holds, where given.
    pub tangent: Option<Vector>,
    /// Orientation it holds, where given.
    pub orientation: Option<Rotation>,
    /// Whether, and how, the cable runs through it.
    pub slide: Option<Slide>,
    /// What it bears.
    pub limits: Limits,
    /// Whether it closes where the cable is nearest to its position when it begins; its place is a provisional one until then.
    pub nearest: bool,
    /// Whether it acts from the beginning.
    pub from_start: bool,
}

impl AttachedConstraint {
    /// The node of the span to which a residual belongs that is none of the stations.
    pub(crate) fn node_of(&self, residual: usize) -> usize {
        let nodes = self.span.as_ref().map_or(1, |span| span.sites.len());
        (residual - self.of_stations) / ((self.residuals.len() - self.of_stations) / nodes)
    }
}

/// Where the cable runs through a constraint.
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

/// A dead load in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Name.
    pub name: String,
    /// Where its moment acts.
    pub site: Site,
    /// The point its force acts on: a branch's own node, even where that rides on a joint.
    pub point: usize,
    /// Force, N, world axes.
    pub force: Vector,
    /// Moment, N m, world axes.
    pub moment: Vector,
    /// Factor at the beginning.
    pub factor: f64,
}

/// A point or frame of the state that is not independent: it rides on a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tie {
    /// The end node of a branch.
    pub point: usize,
    /// The end station's frame, where the joint is a hub.
    pub frame: Option<usize>,
    /// The joint's point.
    pub hub_point: usize,
    /// The joint's frame, where it is a hub.
    pub hub_frame: Option<usize>,
    /// Where the end sits in the hub's frame, m.
    pub offset: Vector,
    /// Frame of the end in the hub's frame.
    pub rest: Rotation,
}

/// A whole harness.
///
/// Places in a state: `points` holds the nodes of all branches, one branch after the other, then one
/// point for each joint; `frames` holds the rows of frames of all branches, then one frame for each joint
/// that is a hub. The end nodes (and on hubs the end stations) of arms are tied to their joint.
pub struct Network {
    /// Different for every network of a process: workspaces know by it what they were made for.
    pub id: u64,
    /// Branches.
    pub branches: Vec<Branch>,
    /// Joints.
    pub joints: Vec<Joint>,
    /// Constraints of the whole scenario, whether they act from the start or are added later.
    pub constraints: Vec<AttachedConstraint>,
    /// The constraints that the cable runs through.
    pub slides: Vec<SlideSite>,
    /// Dead loads.
    pub loads: Vec<Load>,
    /// What rides on the joints.
    pub ties: Vec<Tie>,
    /// Bodies about the harness.
    pub obstacles: Vec<Obstacle>,
    /// How cables meet them, and each other.
    pub contact: ContactSettings,
    /// Number of points of a state.
    pub points: usize,
    /// Number of frames of a state.
    pub frames: usize,
}

/// Points of branches from which on their evaluation is worth another thread.
pub(crate) const WORTHWHILE: usize = 1024;

/// A number that no other network, and no pattern of contact, has in this process.
pub(crate) fn next_id() -> u64 {
    static NEXT: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
    NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed)
}

impl Network {
    /// Gives every part its place.
    ///
    /// # Panics
    /// If indices of the plans do not exist, a constraint has neither station nor span, a place that needs a frame is no station, or the mesh of a
    /// rod has a station at a [`Mounting::Point`] joint or none at a free end or another joint: what the scenario's
    /// check has excluded.
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
                    section: plan.section,
                    rod: plan.rod,
                    path: plan.path,
                    mesh_moves: false,
                };
                points = branch.points.end;
                frames = branch.frames.end;
                branch
            })
            .collect();
        let mut ties = Vec::new();
        let mut placed = Vec::new();
        for (index, plan) in joints.into_iter().enumerate() {
            let mounting = plan.model.mounting();
            let hub = mounting == Mounting::Pose;
            let point = points;
            points += 1;
            let frame = hub.then_some(frames);
            frames += usize::from(hub);
            let mut arm_frames = Vec::new();
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
                    frame: station.filter(|_| hub).map(|c| branch.frames.start + c),
                    hub_point: point,
                    hub_frame: frame,
                    offset: if hub { arm.offset } else { Vector::zeros() },
                    rest: arm.rest,
                });
                if !hub {
                    arm_frames.push(branch.frames.start + station.unwrap_or(mesh.segment_frames[segment]));
                }
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
            obstacles: Vec::new(),
            contact: ContactSettings::default(),
            points,
            frames,
        };
        for plan in constraints {
            network.add_constraint(plan);
        }
        network.loads = loads
            .into_iter()
            .map(|plan| Load {
                site: network.site(plan.place),
                point: match plan.place {
                    Place::Joint(j) => network.joints[j].point,
                    Place::Node { branch, node } => network.branches[branch].points.start + node,
                },
                name: plan.name,
                force: plan.force,
                moment: plan.moment,
                factor: plan.factor,
            })
            .collect();
        network
    }

    /// Gives a constraint its place.
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
        if let Action::Equations(equations) = plan.model.action() {
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
            position: plan.position,
            tangent: plan.tangent,
            orientation: plan.orientation,
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

    /// The independent point and frame that carry a place.
    pub fn site(&self, place: Place) -> Site {
        match place {
            Place::Joint(j) => {
                Site { point: self.joints[j].point, frame: self.joints[j].frame, local: Pose::identity() }
            }
            Place::Node { branch, node } => {
                let b = &self.branches[branch];
                let point = b.points.start + node;
                match self.ties.iter().find(|tie| tie.point == point) {
                    Some(tie) => Site {
                        point: tie.hub_point,
                        frame: tie.hub_frame,
                        local: Pose {
                            position: tie.offset,
                            orientation: if tie.hub_frame.is_some() { tie.rest } else { Rotation::identity() },
                        },
                    },
                    None => Site {
                        point,
                        frame: b.rod.mesh().station_frame(node).map(|c| b.frames.start + c),
                        local: Pose::identity(),
                    },
                }
            }
        }
    }

    /// Whether the harness is so large that several threads share the work on its branches.
    pub fn is_shared(&self) -> bool {
        self.points >= 2 * WORTHWHILE
    }

    /// Does something with every branch, its index and its own entry of `rooms`; on several threads where that pays, so nothing may
    /// depend on the order.
    pub fn for_branches<R: Send>(&self, rooms: &mut [R], work: impl Fn(usize, &Branch, &mut R) + Sync) {
        if self.is_shared() {
            let pairs = self.branches.par_iter().zip(rooms);
            pairs.enumerate().for_each(|(b, (branch, room))| work(b, branch, room));
        } else {
            let pairs = self.branches.iter().zip(rooms);
            pairs.enumerate().for_each(|(b, (branch, room))| work(b, branch, room));
        }
    }

    /// A load with a dead moment, which has no potential: minimisers that go by the energy alone decline it.
    pub fn dead_moment(&self) -> Option<&Load> {
        self.loads.iter().find(|load| load.site.frame.is_some() && load.moment != Vector::zeros())
    }

    /// Connected pieces of the harness: for each branch the number of its piece, and how many there are.
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
