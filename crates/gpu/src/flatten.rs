//! Conversion of a problem to the description of the shaders. Parts attached to a hub state their position on it, so
//! that only independent variables remain.

use nalgebra::{Quaternion, Unit, Vector4};
use wireloom_core::constraint::{Action, RotationHold};
use wireloom_core::law::TurningLaw;
use wireloom_core::network::Site;
use wireloom_core::registry::BuildError;
use wireloom_core::section::SectionLaws;
use wireloom_core::variable::Variable as CoreVariable;
use wireloom_core::{Matrix, Mounting, Network, Pose, Problem, Rotation, State, Tangent, Vector};
use wireloom_shaders::harness::{
    CarriedFrame, Coupling, End, Harness, Hold, Segment, Shape, Spring, Station, StationSegment, Variable,
};

/// Mapping between a network and the description, and the variables that can be held.
pub struct Flattening {
    /// Index in the state of each independent point.
    points: Vec<usize>,
    /// Index in the state of each independent frame.
    frames: Vec<usize>,
    /// Carrier of each point of the state.
    carriers: Vec<PointCarrier>,
    /// Carrier of each frame of the state.
    turned: Vec<CarriedFrame>,
    /// Rest length around each independent frame, m.
    weights: Vec<f64>,
    /// Variables that can be held.
    candidates: Vec<Variable>,
}

/// Carrier of a point of the state.
#[derive(Clone, Copy)]
struct PointCarrier {
    /// The independent point.
    point: u32,
    /// Frame of a hub, and the point's position in it, m.
    lever: Option<(u32, Vector)>,
}

/// Checks that the shaders have a law for every part of a network.
///
/// # Errors
/// The first part without one, by name.
pub fn accepts(network: &Network) -> Result<(), BuildError> {
    let refused = |what: String| {
        let help = "use minimiser.kind = \"newton\", which supports every part";
        Err(BuildError::new(format!("{what} has no law on the GPU"), help).at("kind"))
    };
    for branch in &network.branches {
        match branch.rod.law() {
            None => return refused(format!("the rod of branch `{}`", branch.name)),
            Some(law) if !law.friction.is_empty() => {
                return refused(format!("what slips or yields in the section of branch `{}`", branch.name));
            }
            Some(law) if law.laws != SectionLaws::default() => {
                return refused(format!("a curve or creep in the section of branch `{}`", branch.name));
            }
            Some(_) => {}
        }
    }
    for joint in &network.joints {
        match joint.model.law() {
            None => return refused(format!("joint `{}` ({})", joint.name, joint.kind)),
            Some(law) if law.pairs.iter().any(|pair| !pair.friction.is_empty()) => {
                return refused(format!("what slips at the arms of joint `{}`", joint.name));
            }
            Some(_) => {}
        }
        // A station of the shaders has one frame, which carries its offset, too.
        if joint.model.mounting() == Mounting::CompliantHub
            && joint.arms.iter().any(|arm| arm.offset != Vector::zeros())
        {
            return refused(format!("joint `{}` ({}), whose arms have offsets,", joint.name, joint.kind));
        }
    }
    for constraint in &network.constraints {
        let named = |what: &str| refused(format!("constraint `{}` ({}){what}", constraint.name, constraint.kind));
        if constraint.slide.is_some() || constraint.nearest {
            return named(", through which the cable runs,");
        }
        match constraint.model.action() {
            Action::Equations(_) | Action::PotentialAndEquations(..) => return named(", which sets equations,"),
            Action::Potential(_) if constraint.model.law().is_none() => return named(""),
            Action::Prescribed(hold) => match hold.rotation {
                RotationHold::Twist => return named(", which holds the twist and leaves the tangent free,"),
                RotationHold::Hinge(_) => return named(", which is a hinge,"),
                RotationHold::Free | RotationHold::Tangent | RotationHold::All => {}
            },
            Action::Potential(_) => {}
        }
    }
    if network.contact.cables {
        return refused("contact of cables with one another".to_owned());
    }
    if let Some(obstacle) = network.obstacles.first() {
        return refused(format!("contact with body `{}`", obstacle.name));
    }
    if network.rotates {
        return refused("axes that rotate".to_owned());
    }
    if let Some(branch) = network.branches.iter().find(|own| own.sections.at_end(true).thermal_expansion != 0.0) {
        return refused(format!("branch `{}`, which expands with the temperature,", branch.name));
    }
    match network.load_without_potential() {
        Some((load, why)) => refused(format!("load `{}`, which {why},", load.name)),
        None => Ok(()),
    }
}

impl Flattening {
    /// For a network that [`accepts`] admits.
    pub fn new(network: &Network) -> Self {
        let tied_points: Vec<usize> = network.ties.iter().map(|tie| tie.point).collect();
        let tied_frames: Vec<usize> = network.ties.iter().filter_map(|tie| tie.frame).collect();
        let points = untied(network.points, tied_points);
        let frames = untied(network.frames, tied_frames);
        let mut carriers = vec![PointCarrier { point: u32::MAX, lever: None }; network.points];
        let mut turned = vec![CarriedFrame { frame: u32::MAX, rest: numbers(&Rotation::identity()) }; network.frames];
        for (k, &point) in points.iter().enumerate() {
            carriers[point].point = k as u32;
        }
        for (k, &frame) in frames.iter().enumerate() {
            turned[frame].frame = k as u32;
        }
        for tie in &network.ties {
            let lever = tie.hub_frame.map(|hub| (turned[hub].frame, tie.offset));
            carriers[tie.point] = PointCarrier { point: carriers[tie.hub_point].point, lever };
            if let (Some((frame, _)), Some(own)) = (lever, tie.frame) {
                turned[own] = CarriedFrame { frame, rest: numbers(&tie.rest) };
            }
        }
        let mut flattening = Self { points, frames, carriers, turned, weights: vec![], candidates: vec![] };
        flattening.weights = flattening.weights_of(network);
        flattening.candidates = flattening.candidates_of(network);
        flattening
    }

    /// Weights of the shift, as in `solve`: half of the couplings of a frame, half of its segment, and levers of a hub.
    fn weights_of(&self, network: &Network) -> Vec<f64> {
        let mut weights = vec![0.0; self.frames.len()];
        for branch in &network.branches {
            let mesh = branch.rod.mesh();
            let mut add = |c: usize, length: f64| {
                weights[self.turned[branch.frames.start + c].frame as usize] += 0.5 * length;
            };
            for (c, lambda) in mesh.coupling_lengths.iter().enumerate() {
                add(c, *lambda);
                add(c + 1, *lambda);
            }
            for (j, c) in mesh.segment_frames.iter().enumerate() {
                add(*c, mesh.rest_lengths[j]);
            }
        }
        for joint in &network.joints {
            for (hub, arm) in joint.frame.into_iter().flat_map(|hub| joint.arms.iter().map(move |arm| (hub, arm))) {
                weights[self.turned[hub].frame as usize] += joint.lever(arm);
            }
        }
        weights
    }

    fn candidates_of(&self, network: &Network) -> Vec<Variable> {
        let mut candidates = vec![];
        for constraint in &network.constraints {
            let Action::Prescribed(hold) = constraint.model.action() else { continue };
            if hold.position {
                candidates.push(self.variable(CoreVariable::Point(constraint.site.point)));
            }
            if let (Some(frame), true) = (constraint.site.frame, hold.rotation != RotationHold::Free) {
                candidates.push(self.variable(CoreVariable::Frame(frame)));
            }
        }
        candidates.sort_unstable();
        candidates.dedup();
        candidates
    }

    fn variable(&self, whole: CoreVariable) -> Variable {
        match whole {
            CoreVariable::Point(i) => Variable::Point(self.carriers[i].point),
            CoreVariable::Frame(c) => Variable::Frame(self.turned[c].frame),
        }
    }

    /// The harness of a problem under its conditions. The problem's held directions must be those at `state`.
    pub fn harness(&self, problem: &Problem<'_>, state: &State) -> Harness {
        let mut harness = Harness {
            points: self.points.len(),
            frames: self.frames.len(),
            dead: vec![[0.0; 3]; self.points.len()],
            weights: self.weights.clone(),
            ..Harness::default()
        };
        self.add_branches(problem, state, &mut harness);
        self.add_joints(problem.network, &mut harness);
        self.add_forces(problem, &mut harness);
        self.add_springs(problem, &mut harness);
        self.add_holds(problem, state, &mut harness);
        harness
    }

    fn add_branches(&self, problem: &Problem<'_>, state: &State, harness: &mut Harness) {
        for branch in &problem.network.branches {
            let law = branch.rod.law().expect("accepted");
            let mesh = branch.rod.mesh();
            let frame = |c: usize| self.turned[branch.frames.start + c];
            let last = mesh.frames() - 1;
            let mut beside = mesh.beside.iter().peekable();
            for (j, segment) in law.segments.iter().enumerate() {
                let node = branch.points.start + j;
                let own = frame(mesh.segment_frames[j]).frame;
                let length = state.rest_lengths[node];
                let (stiffness, inversion_stiffness) = (segment.stiffness.into(), segment.overturned);
                let stations = beside.next_if(|b| b.segment == j).map(|b| b.stations);
                let Some(stations) = stations else {
                    let (a, b) = (self.carriers[node].point, self.carriers[node + 1].point);
                    harness.segments.push(Segment { a, b, frame: own, length, stiffness, inversion_stiffness });
                    continue;
                };
                let end = |k: usize| {
                    let carrier = self.carriers[node + k];
                    let station = stations[k].map(|c| {
                        let CarriedFrame { frame, rest } = frame(c);
                        let offset = carrier.lever.map_or_else(Vector::zeros, |(_, offset)| offset).into();
                        let blend = law.blends[usize::from(c != 0 && c != last)];
                        Station { frame, rest, offset, blend }
                    });
                    End { point: carrier.point, station }
                };
                let ends = [end(0), end(1)];
                harness.station_segments.push(StationSegment {
                    ends,
                    frame: own,
                    length,
                    stiffness,
                    inversion_stiffness,
                });
            }
            for (c, stiffness) in law.couplings.iter().enumerate() {
                let whole = branch.frames.start + c;
                let extra = problem.extra_curvature().get(whole).copied().unwrap_or_default();
                let rest = law.curvature + extra;
                let axes = law.axes.get(c).copied().unwrap_or_else(Rotation::identity);
                let turned = |frame: CarriedFrame| match law.axes.get(c) {
                    Some(axes) => CarriedFrame { rest: numbers(&(rotation(frame.rest) * axes)), ..frame },
                    None => frame,
                };
                harness.couplings.push(Coupling {
                    a: turned(frame(c)),
                    b: turned(frame(c + 1)),
                    length: state.coupling_lengths[whole],
                    stiffness: (*stiffness).into(),
                    rest_curvature: axes.inverse_transform_vector(&rest).into(),
                });
            }
        }
    }

    fn add_joints(&self, network: &Network, harness: &mut Harness) {
        for joint in &network.joints {
            for pair in joint.model.law().expect("accepted").pairs {
                let turned = |arm: usize, rest: &Rotation| CarriedFrame {
                    frame: self.turned[joint.coupled_frames[arm]].frame,
                    rest: numbers(rest),
                };
                harness.couplings.push(Coupling {
                    a: turned(pair.a, &pair.alpha),
                    b: turned(pair.b, &pair.beta),
                    length: pair.length,
                    stiffness: pair.stiffness.into(),
                    rest_curvature: pair.curvature.into(),
                });
            }
        }
    }

    /// Dead forces; one that acts on a lever of a hub becomes a spring without stiffness.
    fn add_forces(&self, problem: &Problem<'_>, harness: &mut Harness) {
        for (carrier, force) in self.carriers.iter().zip(problem.dead_forces()) {
            match carrier.lever {
                Some((frame, offset)) if offset != Vector::zeros() => {
                    let site = Site { point: 0, frame: None, local: Pose::identity() };
                    let spring = self.spring(&site, &Pose::identity());
                    let (offset, force) = (offset.into(), (*force).into());
                    harness.springs.push(Spring { point: carrier.point, frame: Some(frame), offset, force, ..spring });
                }
                _ => {
                    let sum = Vector::from(harness.dead[carrier.point as usize]) + force;
                    harness.dead[carrier.point as usize] = sum.into();
                }
            }
        }
    }

    /// A spring without stiffness between a site and a target.
    fn spring(&self, site: &Site, target: &Pose) -> Spring {
        Spring {
            point: self.carriers[site.point].point,
            frame: site.frame.map(|c| self.turned[c].frame),
            rest: numbers(&site.local.orientation),
            offset: site.local.position.into(),
            stiffness: 0.0,
            tangent_stiffness: 0.0,
            frame_stiffness: 0.0,
            position: target.position.into(),
            orientation: numbers(&target.orientation),
            force: [0.0; 3],
        }
    }

    /// All springs: an inactive one has no stiffness, so that the topology stays the same.
    fn add_springs(&self, problem: &Problem<'_>, harness: &mut Harness) {
        let conditions = problem.conditions();
        for (f, constraint) in problem.network.constraints.iter().enumerate() {
            let Some(law) = constraint.model.law() else { continue };
            let mut spring = self.spring(&constraint.site, &conditions.targets[f]);
            if conditions.active[f] {
                spring.stiffness = law.stiffness;
                match law.turning {
                    TurningLaw::None => {}
                    TurningLaw::Tangent(k) => spring.tangent_stiffness = k,
                    TurningLaw::Frame(k) => spring.frame_stiffness = k,
                }
            }
            harness.springs.push(spring);
        }
    }

    fn add_holds(&self, problem: &Problem<'_>, state: &State, harness: &mut Harness) {
        let mut placed = state.clone();
        problem.place_held(&mut placed);
        let mut motion = Tangent::zeros(problem.network);
        problem.motion(state, &mut motion);
        for &variable in &self.candidates {
            let held = problem.held().iter().find(|held| self.variable(held.variable) == variable);
            let (target, motion) = match variable {
                Variable::Point(k) => {
                    let i = self.points[k as usize];
                    let x = placed.points[i];
                    ([x.x, x.y, x.z, 0.0], motion.points[i])
                }
                Variable::Frame(k) => {
                    let c = self.frames[k as usize];
                    (numbers(&placed.frames[c]), motion.frames[c])
                }
            };
            let basis = held.map_or_else(Matrix::identity, |held| held.basis);
            harness.holds.push(Hold {
                variable,
                basis: [0, 1, 2].map(|k| basis.column(k).into_owned().into()),
                count: held.map_or(0, |held| held.count as u32),
                target,
                motion: motion.into(),
            });
        }
    }

    /// The independent variables of a state.
    pub fn shape(&self, state: &State) -> Shape {
        Shape {
            points: self.points.iter().map(|&i| state.points[i].into()).collect(),
            compensation: self.points.iter().map(|&i| state.compensation[i].into()).collect(),
            frames: self.frames.iter().map(|&c| numbers(&state.frames[c])).collect(),
        }
    }

    /// Writes independent variables back to a state, and follows ties. The compensation from f32 is large for f64, and
    /// some code (weights, for example) ignores it: as much as possible is moved to the positions.
    pub fn write_back(&self, shape: &Shape, network: &Network, state: &mut State) {
        for ((&i, x), compensation) in self.points.iter().zip(&shape.points).zip(&shape.compensation) {
            let (x, compensation) = (Vector::from(*x), Vector::from(*compensation));
            state.points[i] = x + compensation;
            state.compensation[i] = compensation - (state.points[i] - x);
        }
        for (&c, q) in self.frames.iter().zip(&shape.frames) {
            state.frames[c] = Unit::new_normalize(Quaternion::from(Vector4::from(*q)));
        }
        network.follow_ties(state);
    }
}

/// Components x, y, z, w.
fn numbers(q: &Rotation) -> [f64; 4] {
    [q.i, q.j, q.k, q.w]
}

/// The rotation with these numbers.
fn rotation([i, j, k, w]: [f64; 4]) -> Rotation {
    Rotation::new_unchecked(Quaternion::new(w, i, j, k))
}

/// The indices of `0..count` that are not tied.
fn untied(count: usize, mut tied: Vec<usize>) -> Vec<usize> {
    tied.sort_unstable();
    (0..count).filter(|k| tied.binary_search(k).is_err()).collect()
}
