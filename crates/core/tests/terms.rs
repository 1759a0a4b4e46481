//! Every term of the energy evaluated alone, on a Y harness with a second cable across its trunk: the gradient against
//! central differences of the energy, the second derivatives against central differences of the gradient, and the sum
//! of the terms against the problem.
//!
//! Tolerances: with the step [`STEP`] and lengths of about 50 mm, differences of fourth order have a truncation error
//! of `(STEP/50 mm)⁴ = 1e-16`, and the rounding errors of energies and forces, divided by the step, are up to 2e-9 of
//! the largest entry of the same unit; the bound is ten times as large. The step is so small that no contact,
//! inequality or friction changes its state within it.

use fastrand::Rng;
use nalgebra::{DMatrix, DVector};
use wireloom_core::conditions::{Against, Conditions, ContactPoint, ContactRecord, Partner, Sliding, System};
use wireloom_core::constraint::Limits;
use wireloom_core::equilibrium::Energy;
use wireloom_core::load::LoadAction;
use wireloom_core::network::{ConstraintPlan, Load, NodeRange, Place};
use wireloom_core::registry::MinimiserKind;
use wireloom_core::rod::BranchHessian;
use wireloom_core::rotation::{frame_from, skew, turned};
use wireloom_core::terms::constraints::ConstraintTerm;
use wireloom_core::terms::contact::{Contact, ContactTerm};
use wireloom_core::terms::friction::FrictionTerm;
use wireloom_core::terms::gravity;
use wireloom_core::terms::joints::JointTerm;
use wireloom_core::terms::loads::LoadTerm;
use wireloom_core::terms::rods::RodTerm;
use wireloom_core::terms::sliding::{SlideHessian, SlidingTerm};
use wireloom_core::variable::{Block, Variable};
use wireloom_core::{
    Constraint, Matrix, Minimiser, Network, Problem, Registry, Report, Rotation, State, Status, Stop, Tangent, Vector,
};
use wireloom_scenario::Division;
use wireloom_testkit::conformance::networks::cut_cable;
use wireloom_testkit::conformance::numeric::{
    assert_matrix_near, assert_near, derivative, derivative_of_all, random_turn, random_vector, symmetric,
};
use wireloom_testkit::constraints::{Floor, Link, Sight, Strut};

/// Step of the differences, m or rad.
const STEP: f64 = 5e-6;
/// Bound of the errors of differences, relative to the largest entry of the same unit.
const TOLERANCE: f64 = 2e-8;
/// Bound of the error of a sum in another order, relative to the sum of the absolute values.
const ROUND_OFF: f64 = 1e-13;

/// A trunk with two arms, one of them drawn towards the joint and running through a ring; another cable crosses the
/// trunk and overlaps it by 2 mm, and so does a ball by 3 mm.
const SCENARIO: &str = r#"
schema = 1
name = "terms"
gravity = [0.5, -1, -9.81]

[contact]
cables = true
friction = 0.3

[sections.cable]
diameter = "20 mm"
linear_density = "120 g/m"
axial_stiffness = 2.0e4
bending_stiffness = 0.012
torsion_stiffness = 0.009

[[branches]]
name = "trunk"
from = "A"
to = "J"
section = "cable"
length = 0.4
segments = 6
path = [[-0.4, 0, 0], [0, 0, 0]]

[[branches]]
name = "left"
from = "J"
to = "B"
section = "cable"
length = 0.36
segments = 4
path = [[0, 0, 0], [0.288, 0.216, 0]]

[[branches]]
name = "right"
from = "C"
to = "J"
section = "cable"
length = 0.36
segments = 5
path = [[0.288, -0.216, 0], [0, 0, 0]]

[[branches]]
name = "across"
from = "D"
to = "E"
section = "cable"
length = 0.4
segments = 6
path = [[-0.23, -0.2, 0.018], [-0.23, 0.2, 0.018]]

[[joints]]
name = "J"
model = "MODEL"
bending_stiffness = [0.3, 0.5]
torsion_stiffness = 0.2
arms = [
  { branch = "trunk", direction = [-1, 0, 0], up = [0, 0, 1] },
  { branch = "left", direction = [0.8, 0.6, 0], up = [0, 0, 1] },
  { branch = "right", direction = [0.8, -0.6, 0], up = [0, 0, 1] },
]

[[constraints]]
name = "plug A"
kind = "connector"
at = { end = "A" }
position = [-0.4, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]

[[constraints]]
name = "plug D"
kind = "connector"
at = { end = "D" }
position = [-0.23, -0.2, 0.018]
tangent = [0, 1, 0]
up = [0, 0, 1]

[[constraints]]
name = "spring"
kind = "handle"
at = { end = "B" }
position = [0.29, 0.21, 0.004]
tangent = [1, 0, 0]
up = [0, 0, 1]
stiffness = 500
angular_stiffness = 2

[[constraints]]
name = "ring"
kind = "handle"
at = { branch = "right", s = 0.144 }
position = [0.17, -0.13, 0]
slide = true
friction = 0.5

[[loads]]
name = "pull"
at = { end = "E" }
force = [0.3, 0.4, -2]

[[loads]]
name = "turn"
at = { end = "E" }
force = [0, 0, 0]
moment = [0.1, -0.2, 0.05]

[[obstacles]]
name = "ball"
shape = "sphere"
radius = 0.1
position = [-0.33, 0, -0.107]
friction = 0.3
"#;

/// Index of the branch that crosses the trunk.
const ACROSS: usize = 3;
/// Index of the constraint `spring`.
const SPRING: usize = 2;

/// Scenarios need a minimiser; the terms do not.
struct NoMinimiser;

impl Minimiser for NoMinimiser {
    fn name(&self) -> &str {
        "none"
    }
    fn minimise(&mut self, _: &mut Problem<'_>, _: &mut State, _: &Stop) -> Report {
        Report::begun(Status::Failed)
    }
    fn forget(&mut self) {}
}

/// The built-in models and shapes.
fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    wireloom_shapes::register(&mut registry, None);
    let minimiser = MinimiserKind {
        name: "newton".into(),
        doc: String::new(),
        parameters: vec![],
        build: Box::new(|(), _| Ok(Box::new(NoMinimiser))),
    };
    assert!(registry.add_minimiser(minimiser).is_ok());
    registry
}

/// The network of the scenario with this model of the joint.
fn network(model: &str) -> Network {
    let registry = registry();
    let text = SCENARIO.replace("MODEL", model);
    let built = wireloom_scenario::build_with_settings(&text, &[], &wireloom_scenario::NoFiles, &registry);
    built.unwrap_or_else(|faults| panic!("{faults:?}")).1.network
}

/// The drawn shape.
fn drawn(network: &Network) -> State {
    let mut state = State::origin(network);
    for branch in &network.branches {
        let [from, to] = branch.path[..] else { panic!("{} is straight", branch.name) };
        let s = branch.rod.mesh().arc_lengths();
        let length = branch.rod.mesh().length();
        for (x, s) in state.points[branch.points.clone()].iter_mut().zip(s) {
            *x = from + (to - from) * (s / length);
        }
        state.frames[branch.frames.clone()].fill(frame_from(&(to - from), &Vector::z()).expect("not parallel"));
    }
    network.follow_ties(&mut state);
    state
}

/// The drawn shape with random displacements of up to 1 mm and rotations of 0.1 rad, so that no entry vanishes by
/// symmetry.
fn shaken(network: &Network) -> State {
    let mut rng = Rng::with_seed(5);
    let mut state = drawn(network);
    state.points.iter_mut().for_each(|x| *x += random_vector(&mut rng, 1e-3));
    state.frames.iter_mut().for_each(|q| *q *= random_turn(&mut rng, 0.1));
    network.follow_ties(&mut state);
    state
}

/// Conditions of a network with its initial targets.
fn conditions(network: &Network) -> Conditions {
    Conditions::new(network, Vector::new(0.5, -1.0, -9.81), &drawn(network))
}

/// All points and frames of a state, tied ones included.
fn all_variables(network: &Network) -> Vec<Variable> {
    (0..network.points).map(Variable::Point).chain((0..network.frames).map(Variable::Frame)).collect()
}

/// The points and frames that follow no joint.
fn independent_variables(network: &Network) -> Vec<Variable> {
    let tied = |v: &Variable| match *v {
        Variable::Point(i) => network.ties.iter().any(|tie| tie.point == i),
        Variable::Frame(c) => network.ties.iter().any(|tie| tie.frame == Some(c)),
    };
    all_variables(network).into_iter().filter(|v| !tied(v)).collect()
}

/// A copy of a state in which component `k` of a variable has changed by `h`; the tied points and frames follow if
/// `ties`.
fn moved(network: &Network, state: &State, v: Variable, k: usize, h: f64, ties: bool) -> State {
    let mut trial = state.clone();
    match v {
        Variable::Point(i) => trial.points[i][k] += h,
        Variable::Frame(c) => trial.frames[c] = turned(&state.frames[c], &(Vector::ith(k, 1.0) * h)),
    }
    if ties {
        network.follow_ties(&mut trial);
    }
    trial
}

/// The entries of a tangent in these variables.
fn entries(tangent: &Tangent, variables: &[Variable]) -> DVector<f64> {
    let vectors = variables.iter().map(|v| match *v {
        Variable::Point(i) => tangent.points[i],
        Variable::Frame(c) => tangent.frames[c],
    });
    DVector::from_vec(vectors.flat_map(|v| [v.x, v.y, v.z]).collect())
}

/// Number of components of points among the variables, which come before those of frames.
fn forces(variables: &[Variable]) -> usize {
    3 * variables.iter().filter(|v| matches!(v, Variable::Point(_))).count()
}

/// A term of the energy in the variables of a state.
trait Term {
    /// Whether it is evaluated in all variables, or else in the independent ones.
    const ALL: bool;
    fn energy(&mut self, state: &State) -> f64;
    /// Adds the first derivatives; returns the energy.
    fn gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64;
    /// Second derivatives in these variables; both triangles.
    fn hessian(&mut self, state: &State, variables: &[Variable]) -> DMatrix<f64>;
}

/// Checks the derivatives of a term at a state.
#[track_caller]
fn check<T: Term>(name: &str, network: &Network, state: &State, term: &mut T) {
    let variables = if T::ALL { all_variables(network) } else { independent_variables(network) };
    let points = forces(&variables);
    let gradient = |term: &mut T, state: &State| {
        let mut gradient = Tangent::zeros(network);
        let energy = term.gradient(state, &mut gradient);
        let again = term.energy(state);
        assert_near(&format!("{name}: energy"), energy, again, ROUND_OFF * again.abs());
        if !T::ALL {
            network.pull_back(state, &mut gradient);
        }
        entries(&gradient, &variables)
    };
    let got = gradient(term, state);
    let steps = |i: usize, h: f64| moved(network, state, variables[i / 3], i % 3, h, !T::ALL);
    let want = DVector::from_fn(got.len(), |i, _| derivative(STEP, |h| term.energy(&steps(i, h))));
    let largest = |v: &DVector<f64>| [v.rows(0, points).amax(), v.rows(points, v.len() - points).amax()];
    let scales = largest(&want);
    assert!(scales[0] > 0.0 || scales[1] > 0.0, "{name}: nothing acts");
    for i in 0..got.len() {
        let tolerance = TOLERANCE * scales[usize::from(i >= points)];
        assert_near(&format!("{name}: gradient, entry {i}"), got[i], want[i], tolerance);
    }
    let columns: Vec<_> = (0..got.len()).map(|i| derivative_of_all(STEP, |h| gradient(term, &steps(i, h)))).collect();
    let want = symmetric(&DMatrix::from_columns(&columns));
    let got = term.hessian(state, &variables);
    let rest = got.nrows() - points;
    for (rows, columns) in [((0, points), (0, points)), ((points, rest), (0, points)), ((points, rest), (points, rest))]
    {
        let part = |m: &DMatrix<f64>| m.view((rows.0, columns.0), (rows.1, columns.1)).into_owned();
        let want = part(&want);
        let name = format!("{name}: second derivatives from ({}, {})", rows.0, columns.0);
        assert_matrix_near(&name, &part(&got), &want, TOLERANCE * want.amax().max(1e-6));
    }
    assert_matrix_near(&format!("{name}: symmetry"), &got, &got.transpose(), TOLERANCE * got.amax());
}

/// Dense matrix of blocks in these variables.
fn dense(blocks: &[Block], variables: &[Variable]) -> DMatrix<f64> {
    let index = |v: Variable| variables.iter().position(|other| *other == v).expect("a variable of the term");
    let mut dense = DMatrix::zeros(3 * variables.len(), 3 * variables.len());
    for block in blocks {
        let mut place = dense.fixed_view_mut::<3, 3>(3 * index(block.row), 3 * index(block.column));
        place += block.matrix;
    }
    dense
}

/// Adds a block below or on the diagonal, and its transpose above.
fn add(blocks: &mut Vec<Block>, row: Variable, column: Variable, matrix: Matrix) {
    blocks.push(Block { row, column, matrix });
    if row != column {
        blocks.push(Block { row: column, column: row, matrix: matrix.transpose() });
    }
}

struct Rods<'n>(System<'n>, RodTerm);

impl Term for Rods<'_> {
    const ALL: bool = true;
    fn energy(&mut self, state: &State) -> f64 {
        let mut energy = Energy::default();
        self.1.energy(self.0, state, &mut energy);
        energy.total()
    }
    fn gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        self.1.gradient(self.0, state, gradient)
    }
    fn hessian(&mut self, state: &State, variables: &[Variable]) -> DMatrix<f64> {
        let Self(system, term) = self;
        let network = system.network;
        let mut parts: Vec<_> = network.branches.iter().map(|b| BranchHessian::new(b.rod.as_ref())).collect();
        term.hessian(*system, state, None, &mut parts);
        let mut blocks = Vec::new();
        for (branch, part) in network.branches.iter().zip(&parts) {
            let mesh = branch.rod.mesh();
            let point = |i: usize| Variable::Point(branch.points.start + i);
            let frame = |c: usize| Variable::Frame(branch.frames.start + c);
            for (j, h) in part.segments.iter().enumerate() {
                let (a, b, q) = (point(j), point(j + 1), frame(mesh.segment_frames[j]));
                add(&mut blocks, a, a, h.ee);
                add(&mut blocks, b, b, h.ee);
                add(&mut blocks, b, a, -h.ee);
                add(&mut blocks, q, a, -h.te);
                add(&mut blocks, q, b, h.te);
                add(&mut blocks, q, q, h.tt);
            }
            for (beside, h) in mesh.beside.iter().zip(&part.beside) {
                let j = beside.segment;
                let neighbours = beside.neighbours();
                for (k, own) in neighbours.iter().enumerate().filter_map(|(k, c)| Some((k, frame((*c)?)))) {
                    add(&mut blocks, own, point(j), -h.se[k]);
                    add(&mut blocks, own, point(j + 1), h.se[k]);
                    add(&mut blocks, own, frame(mesh.segment_frames[j]), h.st[k]);
                    add(&mut blocks, own, own, h.ss[k]);
                }
                if let [Some(first), Some(second)] = neighbours {
                    add(&mut blocks, frame(second), frame(first), h.s1s0);
                }
            }
            for (c, h) in part.couplings.iter().enumerate() {
                add(&mut blocks, frame(c), frame(c), h.aa);
                add(&mut blocks, frame(c), frame(c + 1), h.ab);
                add(&mut blocks, frame(c + 1), frame(c + 1), h.bb);
            }
            for (pair, h) in mesh.pairs.iter().zip(&part.pairs) {
                add(&mut blocks, frame(pair.frame - 1), frame(pair.frame + 1), *h);
            }
        }
        dense(&blocks, variables)
    }
}

#[test]
fn rods() {
    let network = network("cosserat");
    let (state, conditions) = (shaken(&network), conditions(&network));
    let system = System { network: &network, conditions: &conditions };
    let mut rods = Rods(system, RodTerm::new(&network));
    check("rods", &network, &state, &mut rods);
    rods.1.hold_drawn_shape(system, &state);
    rods.1.set_drawn_fraction(system, 0.5);
    check("rods with added rest curvature", &network, &state, &mut rods);
}

struct Joints<'n>(System<'n>, JointTerm);

impl Term for Joints<'_> {
    const ALL: bool = true;
    fn energy(&mut self, state: &State) -> f64 {
        self.1.energy(self.0, state)
    }
    fn gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        let mut energy = 0.0;
        self.1.gradient(self.0, state, gradient, &mut energy);
        energy
    }
    fn hessian(&mut self, state: &State, variables: &[Variable]) -> DMatrix<f64> {
        let Self(system, term) = self;
        let joints = &system.network.joints;
        let mut tables: Vec<_> = joints.iter().map(|j| vec![Matrix::zeros(); j.coupled_frames.len().pow(2)]).collect();
        term.hessian(*system, state, &mut tables);
        let mut blocks = Vec::new();
        for (joint, table) in joints.iter().zip(&tables) {
            for (a, &row) in joint.coupled_frames.iter().enumerate() {
                for (b, &column) in joint.coupled_frames[..=a].iter().enumerate() {
                    let h = table[a * joint.coupled_frames.len() + b];
                    add(&mut blocks, Variable::Frame(row), Variable::Frame(column), h);
                }
            }
        }
        dense(&blocks, variables)
    }
}

#[test]
fn joints() {
    for model in ["cosserat", "compliant-hub"] {
        let network = network(model);
        let conditions = conditions(&network);
        let system = System { network: &network, conditions: &conditions };
        check(model, &network, &shaken(&network), &mut Joints(system, JointTerm::new(&network)));
    }
}

/// A joint through which all wires run has the variation of curvature around it, in the frames of four segments.
#[test]
fn joints_that_rods_run_through() {
    let sample = cut_cable(&registry(), "cosserat", 16);
    let network = &sample.network;
    assert_eq!(network.joints[0].coupled_frames.len(), 4, "not continued");
    let mut rng = Rng::with_seed(6);
    let mut state = sample.state.clone();
    state.frames.iter_mut().for_each(|q| *q *= random_turn(&mut rng, 0.1));
    network.follow_ties(&mut state);
    let conditions = Conditions::new(network, Vector::zeros(), &state);
    let system = System { network, conditions: &conditions };
    check("joints", network, &state, &mut Joints(system, JointTerm::new(network)));
}

struct Constraints<'a>(System<'a>, ConstraintTerm);

impl Term for Constraints<'_> {
    const ALL: bool = false;
    fn energy(&mut self, state: &State) -> f64 {
        self.1.energy(self.0, state)
    }
    fn gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        self.1.gradient(self.0, state, gradient)
    }
    fn hessian(&mut self, state: &State, variables: &[Variable]) -> DMatrix<f64> {
        let mut blocks = Vec::new();
        self.1.hessian(self.0, state, None, &mut blocks);
        dense(&blocks, variables)
    }
}

fn plan(model: Box<dyn Constraint>, stations: Vec<Place>, span: Option<NodeRange>) -> ConstraintPlan {
    ConstraintPlan {
        name: String::new(),
        kind: String::new(),
        model,
        outputs: Vec::new(),
        stations,
        span,
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

/// Each constraint alone, on a joint without frame and on a hub, where stations and nodes have levers.
#[test]
fn constraints() {
    for model in ["cosserat", "rigid-body", "compliant-hub"] {
        let mut network = network(model);
        let end = |branch: usize, last: bool, network: &Network| Place::Node {
            branch,
            node: if last { network.branches[branch].rod.mesh().segments() } else { 0 },
        };
        // The end of the left arm at the joint, the start of the trunk, the end of the cable across it.
        let (near, start, across) = (end(1, false, &network), end(0, false, &network), end(ACROSS, true, &network));
        let near = if model == "cosserat" { end(1, true, &network) } else { near };
        let strut = Strut { rest: 0.01, stiffness: 70.0 };
        network.add_constraint(plan(Box::new(strut), vec![near, start], None));
        network.add_constraint(plan(Box::new(Link(0.3)), vec![start, near], None));
        network.add_constraint(plan(Box::new(Sight), vec![near, across], None));
        // Nodes above and below the floor; the first one is at the joint.
        let span = NodeRange { branch: 1, nodes: 0..5 };
        network.add_constraint(plan(Box::new(Floor(2e-4)), vec![], Some(span)));
        let state = shaken(&network);
        let first = SPRING + 2;
        let named = ["spring", "strut", "equation", "equation with frames and inequality", "inequality of a span"];
        for (name, c) in named.into_iter().zip([SPRING, first, first + 1, first + 2, first + 3]) {
            let mut conditions = conditions(&network);
            conditions.active.iter_mut().enumerate().for_each(|(k, active)| *active = k == c);
            let own = &mut conditions.constraints[c];
            // The floor has no multipliers, so that only some of its inequalities are active.
            own.multipliers.fill(if c == first + 3 { 0.0 } else { 3.0 });
            own.penalties.fill(5.0);
            let mut term = ConstraintTerm::default();
            term.penalty_unit = 1.0;
            let system = System { network: &network, conditions: &conditions };
            let name = format!("{name}, {model}");
            if c == first + 3 {
                let active = term.residuals(system, &state).iter().filter(|r| r.mu > 0.0).count();
                assert!((1..5).contains(&active), "{name}: {active} of 5 are active");
            }
            check(&name, &network, &state, &mut Constraints(system, term));
        }
    }
}

struct Contacts<'a>(System<'a>, ContactTerm);

impl Term for Contacts<'_> {
    const ALL: bool = false;
    fn energy(&mut self, state: &State) -> f64 {
        self.1.energy(self.0, state)
    }
    fn gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        self.1.gradient(self.0, state, gradient)
    }
    fn hessian(&mut self, state: &State, variables: &[Variable]) -> DMatrix<f64> {
        let mut blocks = Vec::new();
        self.1.hessian(self.0, state, false, &mut blocks);
        dense(&blocks, variables)
    }
}

/// Records of the contacts at a state with at least a fifth of the largest force: so all stick, or all slip.
fn records(network: &Network, conditions: &Conditions, state: &State) -> Vec<ContactRecord> {
    let mut problem = Problem::new(network, conditions.clone());
    problem.update_held(state);
    problem.find_contacts(state);
    let found = problem.contact().found();
    let largest = found.iter().map(|contact| contact.force).fold(0.0, f64::max);
    let record = |contact: &Contact| {
        let anchor = problem.friction_anchor(state, contact);
        let (point, partner, multiplier) = (contact.point, contact.partner, 0.7 * contact.force);
        ContactRecord { point, partner, multiplier, penalty: 1.5, anchor }
    };
    let mut records: Vec<_> = found.iter().filter(|c| c.force > 0.2 * largest).map(record).collect();
    records.sort_by_key(|record| (record.point, record.partner));
    records
}

/// The network with the ball alone, or with contact between cables alone.
fn with_contact(cables: bool) -> Network {
    let mut network = network("cosserat");
    network.contact.cables = cables;
    if cables {
        network.obstacles.clear();
    }
    network
}

#[test]
fn contact() {
    for (name, cables) in [("contact with an obstacle", false), ("contact between cables", true)] {
        let network = with_contact(cables);
        let state = shaken(&network);
        let mut conditions = conditions(&network);
        for multipliers in [false, true] {
            if multipliers {
                conditions.contact.records = records(&network, &conditions, &state);
                assert!(conditions.contact.records.len() > 2, "{name}: {}", conditions.contact.records.len());
            }
            let system = System { network: &network, conditions: &conditions };
            let mut term = ContactTerm::new(&network, &conditions);
            term.update_held(system);
            check(&format!("{name}, multipliers: {multipliers}"), &network, &state, &mut Contacts(system, term));
        }
        // Contact places that follow along bent segments, but for those at the end of their range.
        let mut problem = Problem::new(&network, conditions.clone());
        problem.find_contacts(&state);
        problem.update_bends(&state);
        problem.update_crossings(&state);
        conditions.contact.clone_from(&problem.conditions().contact);
        let points = problem.contact().points().to_vec();
        let following = |record: &ContactRecord| {
            let follows = match record.partner {
                Partner::Obstacle { obstacle, .. } => Against::Obstacle(obstacle as usize),
                Partner::Cable { branch, .. } => Against::Branch(branch as usize),
            };
            ContactPoint { fraction: 0.45, follows: Some(follows), ..points[record.point as usize] }
        };
        conditions.contact.extra = conditions.contact.records.iter().map(following).collect();
        conditions.contact.records.clear();
        let system = System { network: &network, conditions: &conditions };
        let mut term = ContactTerm::new(&network, &conditions);
        term.energy(system, &state);
        let follow = |c: &&Contact| c.fraction != 0.45 && c.point as usize >= term.own_points() && c.force > 0.0;
        assert!(term.found().iter().filter(follow).count() > 2, "{:?}", term.found());
        check(&format!("{name}, followed"), &network, &state, &mut Contacts(system, term));
    }
}

struct Friction<'a>(System<'a>, ContactTerm, FrictionTerm);

impl Term for Friction<'_> {
    const ALL: bool = false;
    fn energy(&mut self, state: &State) -> f64 {
        self.2.energy(&self.1, self.0, state)
    }
    fn gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        self.2.gradient(&self.1, self.0, state, gradient)
    }
    fn hessian(&mut self, state: &State, variables: &[Variable]) -> DMatrix<f64> {
        let mut blocks = Vec::new();
        self.2.hessian(&self.1, self.0, state, false, &mut blocks);
        dense(&blocks, variables)
    }
}

/// Anchors of one state, evaluated at a state so near that all contact points stick, and so far that all slip.
#[test]
fn friction() {
    for (name, cables) in [("friction on an obstacle", false), ("friction between cables", true)] {
        let mut network = with_contact(cables);
        // Springs no stiffer than contact: the step of the differences is then small against the elastic displacement.
        network
            .branches
            .iter_mut()
            .for_each(|branch| branch.sections.iter_mut().for_each(|own| own.axial_stiffness = 1.0));
        let before = shaken(&network);
        let mut conditions = conditions(&network);
        conditions.contact.friction = true;
        conditions.contact.records = records(&network, &conditions, &before);
        assert!(conditions.contact.records.iter().all(|record| record.anchor.is_some()));
        let system = System { network: &network, conditions: &conditions };
        for (motion, sticks) in [(1e-5, true), (2e-2, false)] {
            let (mut rng, mut step) = (Rng::with_seed(3), Tangent::zeros(&network));
            step.points.iter_mut().for_each(|x| *x = random_vector(&mut rng, motion));
            step.frames.iter_mut().for_each(|q| *q = random_vector(&mut rng, motion));
            let mut state = before.clone();
            network.retract(&before, &step, 1.0, &mut state);
            let mut contact = ContactTerm::new(&network, &conditions);
            contact.energy(system, &before);
            let contacts = contact.found().to_vec();
            let mut term = Friction(system, contact, FrictionTerm::default());
            term.energy(&state);
            // At most `f N`, which slip reaches.
            for record in &conditions.contact.records {
                let own = contacts.iter().find(|c| (c.point, c.partner) == (record.point, record.partner));
                let normal = record.anchor.expect("friction").force;
                let force = term.2.force_on(own.expect("a contact")).norm() / (0.3 * normal);
                assert_eq!(force < 1.0 - 1e-9, sticks, "{name}: {force} of the largest force");
            }
            check(&format!("{name}, sticks: {sticks}"), &network, &state, &mut term);
        }
    }
}

/// Dead forces and weight are linear in the points; moments have generalised forces, but no energy.
#[test]
fn loads_and_gravity() {
    let network = network("cosserat");
    let (state, conditions) = (shaken(&network), conditions(&network));
    let system = System { network: &network, conditions: &conditions };
    let mut loads = LoadTerm::new(&network);
    loads.update(system);
    let mut gradient = Tangent::zeros(&network);
    let (mut energy, mut magnitude) = (0.0, 0.0);
    loads.force_gradient(&state, &mut gradient, &mut energy, &mut magnitude);
    assert_near("energy of dead forces", energy, loads.energy_with_weight(&state), ROUND_OFF * magnitude);
    let moving = |state: &State| {
        let mut energy = 0.0;
        gravity::moving_weights(system, state, |point, force| energy -= force.dot(&state.points[point]));
        energy
    };
    gravity::moving_weights(system, &state, |point, force| gradient.points[point] -= force);
    let largest = gradient.points.iter().map(Vector::amax).fold(0.0, f64::max);
    for i in 0..network.points {
        for k in 0..3 {
            let at = |h: f64| moved(&network, &state, Variable::Point(i), k, h, false);
            let want = derivative(1e-3, |h| loads.energy_with_weight(&at(h)) + moving(&at(h)));
            assert_near(&format!("dead force on point {i}, {k}"), gradient.points[i][k], want, 1e-10 * largest);
        }
    }
    // The weight of the whole harness, and the forces of the loads.
    let density = wireloom_core::network::Branch::mass;
    let weight = conditions.gravity * network.branches.iter().map(density).sum::<f64>();
    let force = |load: &Load| match &load.action {
        LoadAction::At { load, .. } => load.dead_force(),
        LoadAction::Along { .. } => panic!("loads of this harness act at places"),
    };
    let pull: Vector = network.loads.iter().map(force).sum();
    let sum: Vector = gradient.points.iter().sum();
    assert!(
        (sum + weight + pull).norm() < ROUND_OFF * magnitude.max(weight.norm()),
        "{sum} N, {weight} N and {pull} N"
    );
    assert_near("energy of loads", loads.energy(system, &state), -pull.dot(&end_point(&network, &state)), ROUND_OFF);

    // ∂/∂θ of −(R exp(θ))ᵀ M is −[Rᵀ M]ₓ: antisymmetric.
    let (frame, size) = loads.moments().next().expect("a dead moment");
    let of = |state: &State| {
        let mut gradient = Tangent::zeros(&network);
        loads.add_without_potential(state, &mut gradient);
        gradient
    };
    let of_moments = network.loads.iter().map(|load| match &load.action {
        LoadAction::At { load, .. } => load.on(&Rotation::identity())[1],
        LoadAction::Along { .. } => panic!("loads of this harness act at places"),
    });
    let moment = of_moments.sum::<Vector>();
    assert_eq!(size, moment.norm());
    let m = state.frames[frame].inverse_transform_vector(&moment);
    assert_eq!(of(&state).frames[frame], -m);
    for k in 0..3 {
        let at = |h: f64| of(&moved(&network, &state, Variable::Frame(frame), k, h, false)).frames[frame];
        let want = derivative_of_all(1e-3, |h| DVector::from_iterator(3, at(h).iter().copied()));
        let column = skew(&m).column(k) * -1.0;
        assert!((0..3).all(|i| (column[i] - want[i]).abs() < 1e-10 * m.norm()), "{column} and {want}");
        let mut step = Tangent::zeros(&network);
        step.frames[frame][k] = 1.0;
        let work = loads.work_without_potential(&state, &step, 2.0);
        assert_near("work of the moment", work, 2.0 * m[k], ROUND_OFF * m.norm());
    }
}

/// The loaded end of the cable across.
fn end_point(network: &Network, state: &State) -> Vector {
    state.points[network.branches[ACROSS].points.end - 1]
}

/// ∂E/∂s of rods and weight as the mesh moves along the cable, and the second derivatives with s.
#[test]
fn sliding() {
    let network = network("cosserat");
    let (state, mut conditions) = (shaken(&network), conditions(&network));
    let friction = 0.3;
    conditions.sliding[0] = Sliding::Running { force: friction };
    let system = System { network: &network, conditions: &conditions };
    let (rods, mut sliding) = (RodTerm::new(&network), SlidingTerm::default());
    sliding.update(system);
    assert_eq!((sliding.acting(), sliding.is_idle()), (vec![0], false));
    let mut step = Tangent::zeros(&network);
    step.slides[0] = 1.0;
    let along = |state: &State, ds: f64| {
        let mut trial = state.clone();
        sliding.retract(system, state, &step, ds, &mut trial);
        trial
    };
    let energy = |state: &State| {
        let mut energy = Energy::default();
        rods.energy(system, state, &mut energy);
        gravity::moving_weights(system, state, |point, force| energy.gravity -= force.dot(&state.points[point]));
        energy.total() + friction * sliding.arc_length(system, 0, state)
    };
    let slope = |state: &State| {
        let (mut term, mut gradient) = (SlidingTerm::default(), Tangent::zeros(&network));
        term.update(system);
        let work = term.gradient(system, &rods, state, &mut gradient);
        assert_near("work of friction", work, friction * term.arc_length(system, 0, state), ROUND_OFF);
        gradient.slides[0]
    };
    let got = slope(&state);
    let want = derivative(STEP, |ds| energy(&along(&state, ds)));
    assert_near("∂E/∂s", got, want, TOLERANCE * want.abs());
    let mut hessian = SlideHessian::default();
    let mut gradient = Tangent::zeros(&network);
    let mut term = SlidingTerm::default();
    term.update(system);
    term.gradient(system, &rods, &state, &mut gradient);
    term.hessian(system, &rods, &state, &gradient, &mut hessian);
    assert_eq!(hessian.running, [0]);
    let want = derivative(STEP, |ds| slope(&along(&state, ds)));
    assert_near("∂²E/∂s²", hessian.own[0], want, TOLERANCE * want.abs());
    let variables = independent_variables(&network);
    let got = entries(&hessian.mixed[0], &variables);
    let steps = |i: usize, h: f64| moved(&network, &state, variables[i / 3], i % 3, h, true);
    let want = DVector::from_fn(got.len(), |i, _| derivative(STEP, |h| slope(&steps(i, h))));
    let points = forces(&variables);
    let scales = [want.rows(0, points).amax(), want.rows(points, want.len() - points).amax()];
    for i in 0..got.len() {
        let tolerance = TOLERANCE * scales[usize::from(i >= points)];
        assert_near(&format!("∂²E/∂s∂x, entry {i}"), got[i], want[i], tolerance);
    }
}

/// The problem's energy and gradient are the sums over the terms.
#[test]
fn the_problem_is_the_sum_of_its_terms() {
    for model in ["cosserat", "rigid-body", "compliant-hub"] {
        let network = network(model);
        let (before, mut conditions) = (drawn(&network), conditions(&network));
        conditions.contact.friction = true;
        conditions.contact.records = records(&network, &conditions, &before);
        conditions.sliding[0] = Sliding::Running { force: 0.3 };
        let (state, system) = (shaken(&network), System { network: &network, conditions: &conditions });
        let mut problem = Problem::new(&network, conditions.clone());
        problem.update_held(&state);

        let mut rods = RodTerm::new(&network);
        let mut joints = JointTerm::new(&network);
        let mut loads = LoadTerm::new(&network);
        loads.update(system);
        let mut contact = ContactTerm::new(&network, &conditions);
        contact.update_held(system);
        let mut friction = FrictionTerm::default();
        let mut constraints = ConstraintTerm::default();
        let scales = problem.scales();
        constraints.penalty_unit = scales.force * scales.length;
        let mut sliding = SlidingTerm::default();
        sliding.update(system);

        // The parts by effect.
        let mut elastic = Energy::default();
        rods.energy(system, &state, &mut elastic);
        let mut gravity = loads.energy_with_weight(&state) - loads.energy(system, &state);
        gravity::moving_weights(system, &state, |point, force| gravity -= force.dot(&state.points[point]));
        let energy = problem.energy(&state);
        let parts = [
            ("rods", elastic.total(), energy.stretch + energy.shear + energy.bend + energy.twist),
            ("joints", joints.energy(system, &state), energy.joint),
            ("loads", loads.energy(system, &state), energy.load),
            ("gravity", gravity, energy.gravity),
            (
                "constraints, contact and friction",
                constraints.energy(system, &state)
                    + contact.energy(system, &state)
                    + friction.energy(&contact, system, &state),
                energy.constraint,
            ),
        ];
        for (name, alone, whole) in parts {
            assert!(alone != 0.0 || (name, model) == ("joints", "rigid-body"), "{name}: nothing acts");
            assert_near(&format!("energy of {name}, {model}"), whole, alone, ROUND_OFF * alone.abs());
        }

        // The gradient; the work of friction at the sliding constraint belongs to its energy.
        let mut sum = Tangent::zeros(&network);
        let mut magnitude = 0.0;
        let mut total = rods.gradient(system, &state, &mut sum);
        let mut add = |term: &mut dyn FnMut(&mut Tangent) -> f64| {
            let mut own = Tangent::zeros(&network);
            let energy = term(&mut own);
            sum.add_scaled(1.0, &own);
            magnitude += energy.abs();
            energy
        };
        let mut dead = 0.0;
        total += add(&mut |own| {
            loads.force_gradient(&state, own, &mut dead, &mut 0.0);
            loads.add_without_potential(&state, own);
            gravity::moving_weights(system, &state, |point, force| {
                own.points[point] -= force;
                dead -= force.dot(&state.points[point]);
            });
            dead
        });
        total += add(&mut |own| sliding.gradient(system, &rods, &state, own));
        total += add(&mut |own| {
            let mut energy = 0.0;
            joints.gradient(system, &state, own, &mut energy);
            energy
        });
        total += add(&mut |own| contact.gradient(system, &state, own));
        total += add(&mut |own| friction.gradient(&contact, system, &state, own));
        total += add(&mut |own| constraints.gradient(system, &state, own));
        network.pull_back(&state, &mut sum);
        let mut whole = Tangent::zeros(&network);
        let energy = problem.gradient(&state, &mut whole);
        assert_near(&format!("energy, {model}"), energy, total, ROUND_OFF * (total.abs() + magnitude));
        let largest = |vectors: &[Vector]| vectors.iter().map(Vector::amax).fold(0.0, f64::max);
        for (name, whole, sum) in [("force", &whole.points, &sum.points), ("moment", &whole.frames, &sum.frames)] {
            let off = whole.iter().zip(sum).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
            assert!(off <= ROUND_OFF * largest(whole), "{name}, {model}: {off:e} of {:e}", largest(whole));
        }
        assert_near("∂E/∂s", whole.slides[0], sum.slides[0], ROUND_OFF * sum.slides[0].abs());
    }
}

#[test]
fn contact_points_of_a_graded_mesh_leave_no_gap_on_its_long_segments() {
    let registry = registry();
    let text = SCENARIO.replace("MODEL", "fused");
    let mut scenario = wireloom_scenario::parse(&text, &registry).unwrap_or_else(|faults| panic!("{faults:?}"));
    // 2 mm at the plug, 100 mm at the joint.
    scenario.branches[0].division = Division::ByAccuracy { longest: 0.1 };
    scenario.branches[0].sizes = vec![[0.0, 0.005], [0.5, 0.005], [0.6, 0.25], [1.0, 0.25]];
    let network = scenario.build(&registry).unwrap_or_else(|faults| panic!("{faults:?}")).network;
    let trunk = &network.branches[0];
    let longest = trunk.rod.mesh().rest_lengths.iter().copied().fold(0.0, f64::max);
    let shortest = trunk.rod.mesh().rest_lengths.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(longest > 10.0 * shortest, "{shortest} to {longest} m: not graded");
    let term = ContactTerm::new(&network, &conditions(&network));
    let state = drawn(&network);
    let places: Vec<f64> =
        term.points().iter().filter(|p| p.branch == 0).map(|p| p.arc_length(&network, &state)).collect();
    let widest = places.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let radius = 0.5 * trunk.sections.diameter();
    assert!(widest <= 1.5 * radius * (1.0 + 1e-9), "{widest} m between contact points of radius {radius} m");
}
