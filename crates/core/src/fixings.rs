//! What fixings that pull, or that set equations, add to the problem; [`crate::problem`] itself takes out what others prescribe.
//!
//! An equation `c = 0` with multiplier λ and penalty ρ adds `λ c + ½ ρ c²` to the energy, an inequality `c ≤ 0` adds
//! `(μ² − λ²)/(2ρ)` with `μ = max(0, λ + ρ c)`. Either way the forces are `μ J` (with `μ = λ + ρ c` for an equation), and the second
//! derivatives `ρ JᵀJ + μ c″` where `μ` is not cut off. At a minimum of that, λ moves to μ until nothing moves any more: then `c = 0`, or
//! `c ≤ 0 ≤ λ` with one of them 0.

use crate::constraint::{Action, Equations, Relation, Residual, Situation};
use crate::contact::ContactState;
use crate::equilibrium::PartFamily;
use crate::network::{Fixing, Site};
use crate::problem::{Conditions, Hessian, Problem, Variable, lever_hessian};
use crate::rotation::skew;
use crate::{Matrix, Network, Pose, State, Tangent, Vector};
use nalgebra::{DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};

/// First penalty, in units of (force scale × length scale) / (scale of the residual)²: far stiffer than a cable in bending, so that every
/// update of the multipliers takes three or four digits off; in a taut one it is raised.
const PENALTY: f64 = 1e4;
/// Where an update takes less than this share off a residual that is not met, its penalty is raised.
const SHRINKS: f64 = 0.25;
/// By how much.
const RAISE: f64 = 10.0;
/// Eigenvalues above minus this share of the largest are not negative.
const ROUND_OFF: f64 = 1e-12;
/// Highest penalty, in the same units: beyond it round-off rules.
const HIGHEST: f64 = 1e9;

/// What a fixing carries along from one equilibrium to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixingState {
    /// The target that the scenario gives its first station, before [`crate::Constraint::target`].
    pub base: Pose,
    /// Where its further stations were relative to the first when it began.
    pub beside: Vec<Pose>,
    /// See [`Situation::progress`].
    pub progress: f64,
    /// See [`crate::Constraint::memory`].
    pub memory: Vec<f64>,
    /// λ of each residual.
    pub multipliers: Vec<f64>,
    /// ρ of each residual, in units of (force scale × length scale) / (scale of the residual)².
    pub penalties: Vec<f64>,
}

impl FixingState {
    /// Of a fixing that begins where its stations are at `state`.
    pub fn begin(fixing: &Fixing, state: &State) -> Self {
        let base = state.pose(&fixing.site);
        Self {
            base,
            beside: fixing.stations.iter().skip(1).map(|site| base.inverse().compose(&state.pose(site))).collect(),
            progress: 0.0,
            memory: fixing.constraint.memory(),
            multipliers: vec![0.0; fixing.residuals.len()],
            penalties: vec![PENALTY; fixing.residuals.len()],
        }
    }
}

impl Conditions {
    /// How a run begins: every fixing where its stations are at `state`, nothing slides yet.
    pub fn new(network: &Network, gravity: Vector, state: &State) -> Self {
        let fixings: Vec<FixingState> = network.fixings.iter().map(|f| FixingState::begin(f, state)).collect();
        Self {
            gravity,
            load_factors: network.loads.iter().map(|load| load.factor).collect(),
            active: network.fixings.iter().map(|f| f.from_start).collect(),
            targets: network.fixings.iter().zip(&fixings).map(|(f, own)| f.constraint.target(&own.base, 0.0)).collect(),
            fixings,
            sliding: vec![crate::sliding::Sliding::Stuck; network.slides.len()],
            contact: ContactState::new(network),
        }
    }
}

/// A block of second derivatives in two independent variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// The variable of its rows.
    pub row: Variable,
    /// The variable of its columns.
    pub column: Variable,
    /// ∂²E/∂row ∂column.
    pub matrix: Matrix,
}

/// What a fixing exerts on the harness.
#[derive(Clone, Debug, PartialEq)]
pub struct Exerted {
    /// At each station the force (N) and the moment about it (N m), world axes.
    pub stations: Vec<(Vector, Vector)>,
    /// At each node of the span the force, N.
    pub span: Vec<Vector>,
}

/// The residual that is furthest from being met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unmet {
    /// Index of its fixing.
    pub fixing: usize,
    /// How far it is from being met, in units of its scale.
    pub value: f64,
}

/// What a constraint sees.
#[derive(Default)]
struct View {
    stations: Vec<Pose>,
    targets: Vec<Pose>,
    span: Vec<Vector>,
    span_lengths: Vec<f64>,
}

impl View {
    /// Looks at the surroundings of a fixing.
    fn look(&mut self, fixing: &Fixing, own: &FixingState, target: &Pose, state: &State) {
        self.stations.clear();
        self.stations.extend(fixing.stations.iter().map(|site| state.pose(site)));
        self.targets.clear();
        if !fixing.stations.is_empty() {
            self.targets.push(*target);
            self.targets.extend(own.beside.iter().map(|beside| target.compose(beside)));
        }
        self.span.clear();
        self.span_lengths.clear();
        let Some(span) = &fixing.span else { return };
        self.span.extend(span.sites.iter().map(|site| state.pose(site).position));
        let lengths = &state.rest_lengths[span.points.start..span.points.end - 1];
        self.span_lengths.resize(span.sites.len(), 0.0);
        for (j, l) in lengths.iter().enumerate() {
            self.span_lengths[j] += 0.5 * l;
            self.span_lengths[j + 1] += 0.5 * l;
        }
    }

    fn situation<'a>(&'a self, own: &'a FixingState) -> Situation<'a> {
        Situation {
            stations: &self.stations,
            targets: &self.targets,
            span: &self.span,
            span_lengths: &self.span_lengths,
            progress: own.progress,
            memory: &own.memory,
        }
    }

    /// Whether what it shows is a finite number throughout.
    fn is_finite(&self) -> bool {
        let pose = |pose: &Pose| finite(&pose.position) && pose.orientation.coords.iter().all(|x| x.is_finite());
        self.stations.iter().chain(&self.targets).all(pose) && self.span.iter().all(finite)
    }
}

fn finite(v: &Vector) -> bool {
    v.iter().all(|x| x.is_finite())
}

/// Room for derivatives, refilled for every fixing.
#[derive(Default)]
struct Slopes {
    stations: Vec<Vector>,
    span: Vec<Vector>,
    /// c, μ, and J.
    c: Vec<f64>,
    mu: Vec<f64>,
    rows: Vec<Vector>,
    span_rows: Vec<Vector>,
}

/// Scratch of a problem.
#[derive(Default)]
pub(crate) struct Room {
    view: View,
    slopes: Slopes,
    table: Vec<Matrix>,
    span_table: Vec<Matrix>,
}

/// Zeros, so many.
fn refill<T: Clone>(room: &mut Vec<T>, count: usize, zero: T) {
    room.clear();
    room.resize(count, zero);
}

/// Energy of an equation or inequality, J, and μ.
fn augmented(relation: Relation, c: f64, lambda: f64, rho: f64) -> (f64, f64) {
    let mu = lambda + rho * c;
    match relation {
        Relation::Zero => (lambda * c + 0.5 * rho * c * c, mu),
        // NaN stays NaN.
        Relation::NotPositive if mu < 0.0 => (-0.5 * lambda * lambda / rho, 0.0),
        Relation::NotPositive => (0.5 * (mu * mu - lambda * lambda) / rho, mu),
    }
}

impl Slopes {
    /// First derivatives of what a fixing adds to the energy, and the energy, J; nothing for what prescribes.
    fn fill(&mut self, fixing: &Fixing, own: &FixingState, view: &View, unit: f64) -> f64 {
        let at = view.situation(own);
        let (m, n) = (at.stations.len(), at.span.len());
        refill(&mut self.stations, 2 * m, Vector::zeros());
        refill(&mut self.span, n, Vector::zeros());
        match fixing.constraint.action() {
            Action::Prescribed(_) => 0.0,
            Action::Potential(potential) => potential.gradient(&at, &mut self.stations, &mut self.span),
            Action::Equations(equations) => {
                self.linearise(equations, &fixing.residuals, fixing.of_stations, &at);
                refill(&mut self.mu, self.c.len(), 0.0);
                let mut energy = 0.0;
                for (r, residual) in fixing.residuals.iter().enumerate() {
                    let rho = own.penalties[r] * unit / (residual.scale * residual.scale);
                    let (e, mu) = augmented(residual.relation, self.c[r], own.multipliers[r], rho);
                    energy += e;
                    self.mu[r] = mu;
                    if mu == 0.0 {
                        continue;
                    }
                    if r < fixing.of_stations {
                        for (g, j) in self.stations.iter_mut().zip(&self.rows[2 * m * r..]) {
                            *g += j * mu;
                        }
                    } else {
                        self.span[fixing.node_of(r)] += self.span_rows[r - fixing.of_stations] * mu;
                    }
                }
                energy
            }
        }
    }

    /// c and J.
    fn linearise(&mut self, equations: &dyn Equations, residuals: &[Residual], of_stations: usize, at: &Situation<'_>) {
        refill(&mut self.c, residuals.len(), 0.0);
        refill(&mut self.rows, 2 * at.stations.len() * of_stations, Vector::zeros());
        refill(&mut self.span_rows, residuals.len() - of_stations, Vector::zeros());
        equations.jacobian(at, &mut self.c, &mut self.rows, &mut self.span_rows);
    }
}

/// Whether a fixing adds to the energy.
fn pulls(fixing: &Fixing) -> bool {
    !matches!(fixing.constraint.action(), Action::Prescribed(_))
}

impl Problem<'_> {
    /// The fixings that act and add to the energy.
    fn pulling(&self) -> impl Iterator<Item = (usize, &Fixing)> {
        let active = &self.conditions.active;
        self.network.fixings.iter().enumerate().filter(move |(f, fixing)| active[*f] && pulls(fixing))
    }

    /// Energy of the fixings, J.
    pub(crate) fn fixing_energy(&mut self, state: &State) -> f64 {
        if self.pulling().next().is_none() {
            return 0.0;
        }
        let mut room = std::mem::take(&mut self.fixing_room);
        let (unit, mut energy, mut odd) = (self.penalty_unit, 0.0, None);
        for (f, fixing) in self.pulling() {
            let own = &self.conditions.fixings[f];
            room.view.look(fixing, own, &self.conditions.targets[f], state);
            let e = match fixing.constraint.action() {
                Action::Potential(potential) => potential.energy(&room.view.situation(own)),
                _ => room.slopes.fill(fixing, own, &room.view, unit),
            };
            if !e.is_finite() && odd.is_none() && room.view.is_finite() {
                odd = Some(f);
            }
            energy += e;
        }
        self.fixing_room = room;
        self.odd = self.odd.or(odd);
        energy
    }

    /// Adds the first derivatives of what fixings add to the energy, in the independent variables; returns that energy, J.
    pub(crate) fn fixing_gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        if self.pulling().next().is_none() {
            return 0.0;
        }
        let mut room = std::mem::take(&mut self.fixing_room);
        let (unit, mut energy, mut odd) = (self.penalty_unit, 0.0, None);
        for (f, fixing) in self.pulling() {
            let own = &self.conditions.fixings[f];
            room.view.look(fixing, own, &self.conditions.targets[f], state);
            let e = room.slopes.fill(fixing, own, &room.view, unit);
            let slopes = || room.slopes.stations.iter().chain(&room.slopes.span);
            if (!e.is_finite() || !slopes().all(finite)) && odd.is_none() && room.view.is_finite() {
                odd = Some(f);
            }
            energy += e;
            for (site, g) in fixing.stations.iter().zip(room.slopes.stations.chunks_exact(2)) {
                add_slope(state, site, &g[0], &g[1], gradient);
            }
            for (site, g) in fixing.span.iter().flat_map(|span| &span.sites).zip(&room.slopes.span) {
                add_slope(state, site, g, &Vector::zeros(), gradient);
            }
        }
        self.fixing_room = room;
        self.odd = self.odd.or(odd);
        energy
    }

    /// Makes the second derivatives of what fixings add convex: negative curvatures of potentials, and of μ c″ of equations, are turned over
    /// (Dauphin and others 2014), and every station gets a little stiffness against moving. `hessian` is that of `state`. Returns whether that
    /// changed anything. A matrix that is not positive definite for a fixing's sake (a strut that is pushed, a penalty far from its
    /// equation, a piece that hangs by a tie alone) becomes so by no shift of frames.
    pub fn make_convex(&mut self, state: &State, hessian: &mut Hessian) -> bool {
        if hessian.fixings.is_empty() {
            return false;
        }
        let exact = std::mem::take(&mut hessian.fixings);
        self.fixing_hessian(state, true, &mut hessian.fixings);
        exact != hessian.fixings
    }

    /// The second derivatives of what fixings add to the energy at `state`, in the independent variables: both triangles; with `convex`
    /// those of [`Self::make_convex`].
    pub fn fixing_hessian(&mut self, state: &State, convex: bool, blocks: &mut Vec<Block>) {
        blocks.clear();
        self.contact_hessian(state, convex, blocks);
        if self.pulling().next().is_none() {
            return;
        }
        let mut room = std::mem::take(&mut self.fixing_room);
        let (unit, mut odd) = (self.penalty_unit, None);
        let scales = self.scales();
        let stiffness = scales.force / scales.length;
        for (f, fixing) in self.pulling() {
            let own = &self.conditions.fixings[f];
            room.view.look(fixing, own, &self.conditions.targets[f], state);
            let Room { view, slopes, table, span_table } = &mut room;
            let (m, n) = (view.stations.len(), view.span.len());
            refill(table, 4 * m * m, Matrix::zeros());
            refill(span_table, n, Matrix::zeros());
            // Equations need μ, and forces with levers have second derivatives of their own.
            let sites = || fixing.stations.iter().chain(fixing.span.iter().flat_map(|span| &span.sites));
            if !fixing.residuals.is_empty() || sites().any(is_carried) {
                slopes.fill(fixing, own, view, unit);
            } else {
                refill(&mut slopes.stations, 2 * m, Vector::zeros());
                refill(&mut slopes.span, n, Vector::zeros());
            }
            let at = view.situation(own);
            match fixing.constraint.action() {
                Action::Prescribed(_) => {}
                Action::Potential(potential) => {
                    potential.hessian(&at, table, span_table);
                    if convex {
                        turn_over(stiffness, table, span_table);
                    }
                }
                Action::Equations(equations) => {
                    equations.curvature(&at, &slopes.mu, table, span_table);
                    if convex {
                        turn_over(stiffness, table, span_table);
                    }
                    add_penalties(fixing, own, slopes, unit, (table, span_table));
                }
            }
            let whole = table.iter().chain(span_table.iter()).all(|block| block.iter().all(|x| x.is_finite()));
            if !whole && odd.is_none() && view.is_finite() {
                odd = Some(f);
            }
            carry(state, &fixing.stations, &slopes.stations, table);
            for (row_site, row) in fixing.stations.iter().zip(table.chunks_exact(4 * m.max(1))) {
                let (of_point, of_frame) = row.split_at(2 * m);
                for (b, column_site) in fixing.stations.iter().enumerate() {
                    for (k, row) in variables(row_site) {
                        let of = if k == 0 { of_point } else { of_frame };
                        for (l, column) in variables(column_site) {
                            blocks.push(Block { row, column, matrix: of[2 * b + l] });
                        }
                    }
                }
            }
            let sites = fixing.span.iter().flat_map(|span| &span.sites);
            for ((site, force), h) in sites.zip(&slopes.span).zip(span_table.iter()) {
                let mut own = [*h, Matrix::zeros(), Matrix::zeros(), Matrix::zeros()];
                carry(state, std::slice::from_ref(site), &[*force, Vector::zeros()], &mut own);
                for (k, row) in variables(site) {
                    for (l, column) in variables(site) {
                        blocks.push(Block { row, column, matrix: own[2 * k + l] });
                    }
                }
            }
        }
        self.fixing_room = room;
        self.odd = self.odd.or(odd);
    }

    /// What a fixing that pulls or sets equations exerts on the harness at `state`.
    pub(crate) fn pull(&self, f: usize, state: &State) -> Exerted {
        let (fixing, own) = (&self.network.fixings[f], &self.conditions.fixings[f]);
        let mut room = Room::default();
        room.view.look(fixing, own, &self.conditions.targets[f], state);
        room.slopes.fill(fixing, own, &room.view, self.penalty_unit);
        let stations = room.view.stations.iter().zip(room.slopes.stations.chunks_exact(2));
        Exerted {
            stations: stations.map(|(pose, g)| (-g[0], -(pose.orientation * g[1]))).collect(),
            span: room.slopes.span.iter().map(|g| -g).collect(),
        }
    }

    /// The residual that is furthest from being met at `state`; `None` where no fixing that acts sets equations.
    pub fn unmet(&self, state: &State) -> Option<Unmet> {
        let mut worst: Option<Unmet> = None;
        self.for_residuals(state, |fixing, _, _, value| {
            // NaN counts as the furthest.
            if worst.is_none_or(|worst| value > worst.value || value.is_nan()) {
                worst = Some(Unmet { fixing, value });
            }
        });
        worst
    }

    /// Moves the multipliers to what they exert at `state`, a minimum, and raises the penalties of residuals above `tolerance` that have
    /// not shrunk since `last` (in units of their scales), which becomes what they are now.
    pub fn update_multipliers(&mut self, state: &State, tolerance: f64, last: &mut Vec<f64>) {
        let mut found = Vec::new();
        self.for_residuals(state, |fixing, r, mu, value| found.push((fixing, r, mu, value)));
        last.resize(found.len(), f64::INFINITY);
        for ((fixing, r, mu, value), last) in found.into_iter().zip(last) {
            let own = &mut self.conditions.fixings[fixing];
            own.multipliers[r] = mu;
            if value > tolerance && value > SHRINKS * *last {
                own.penalties[r] = (RAISE * own.penalties[r]).min(HIGHEST);
            }
            *last = value;
        }
    }

    /// Makes multipliers and penalties those of other conditions.
    pub fn set_multipliers(&mut self, other: &Conditions) {
        for (own, other) in self.conditions.fixings.iter_mut().zip(&other.fixings) {
            own.multipliers.clone_from(&other.multipliers);
            own.penalties.clone_from(&other.penalties);
        }
    }

    /// Every residual of the fixings that act: index of the fixing, its index, μ, and how far it is from being met: `|c|`, or
    /// `|max(c, −λ/ρ)|` for an inequality, in units of its scale.
    fn for_residuals(&self, state: &State, mut see: impl FnMut(usize, usize, f64, f64)) {
        let unit = self.penalty_unit;
        let mut room = Room::default();
        for (f, fixing) in self.pulling().filter(|(_, fixing)| !fixing.residuals.is_empty()) {
            let own = &self.conditions.fixings[f];
            room.view.look(fixing, own, &self.conditions.targets[f], state);
            room.slopes.fill(fixing, own, &room.view, unit);
            for (r, residual) in fixing.residuals.iter().enumerate() {
                let (c, mu) = (room.slopes.c[r], room.slopes.mu[r]);
                let rho = own.penalties[r] * unit / (residual.scale * residual.scale);
                let off = match residual.relation {
                    Relation::NotPositive if mu == 0.0 => own.multipliers[r] / rho,
                    _ => c.abs(),
                };
                see(f, r, mu, off / residual.scale);
            }
        }
    }

    /// Lets every fixing that acts note what it remembers from here on; called at the equilibrium an increment ends in.
    pub fn commit(&mut self, state: &State) {
        self.commit_contacts(state);
        let mut view = View::default();
        for (f, fixing) in self.network.fixings.iter().enumerate() {
            let own = &self.conditions.fixings[f];
            if !self.conditions.active[f] || own.memory.is_empty() {
                continue;
            }
            view.look(fixing, own, &self.conditions.targets[f], state);
            let mut memory = own.memory.clone();
            fixing.constraint.commit(&view.situation(own), &mut memory);
            self.conditions.fixings[f].memory = memory;
        }
    }

    /// A part (by index) of which nothing may be relied on any more, and why: it says so itself, or it is a fixing that remembers what is not
    /// finite or, with `lost`, has said what is not finite of what is since this was asked last.
    pub fn fault(&mut self, lost: bool) -> Option<(PartFamily, usize, String)> {
        for (j, joint) in self.network.joints.iter().enumerate() {
            if let Some(message) = joint.model.fault() {
                return Some((PartFamily::Joint, j, message));
            }
        }
        let acting = self.network.fixings.iter().enumerate().filter(|(f, _)| self.conditions.active[*f]);
        for (f, fixing) in acting {
            if let Some(message) = fixing.constraint.fault() {
                return Some((PartFamily::Constraint, f, message));
            }
            if self.conditions.fixings[f].memory.iter().any(|x| !x.is_finite()) {
                return Some((PartFamily::Constraint, f, "what it remembers is not a finite number".to_owned()));
            }
        }
        let odd = self.odd.take().filter(|_| lost)?;
        Some((PartFamily::Constraint, odd, "it gave a number that is not finite for a harness that is".to_owned()))
    }

    /// A fixing takes hold where its stations are at `state`, with nothing remembered.
    pub fn begin_fixing(&mut self, f: usize, state: &State) {
        let fixing = &self.network.fixings[f];
        let own = FixingState::begin(fixing, state);
        self.conditions.targets[f] = fixing.constraint.target(&own.base, own.progress);
        self.conditions.fixings[f] = own;
    }

    /// Moves the target of a fixing; see [`FixingState::base`].
    pub fn set_target(&mut self, f: usize, base: Pose) {
        let own = &mut self.conditions.fixings[f];
        own.base = base;
        self.conditions.targets[f] = self.network.fixings[f].constraint.target(&base, own.progress);
    }

    /// Sets the share of the step in which a fixing began that is done.
    pub fn set_progress(&mut self, f: usize, progress: f64) {
        let own = &mut self.conditions.fixings[f];
        own.progress = progress;
        self.conditions.targets[f] = self.network.fixings[f].constraint.target(&own.base, progress);
    }
}

/// The variables of a site: 0, its point; 1, its frame.
fn variables(site: &Site) -> impl Iterator<Item = (usize, Variable)> {
    [(0, Some(Variable::Point(site.point))), (1, site.frame.map(Variable::Frame))]
        .into_iter()
        .filter_map(|(k, variable)| variable.map(|variable| (k, variable)))
}

/// Whether a station is not simply where its point and frame are.
fn is_carried(site: &Site) -> bool {
    site.local != Pose::identity()
}

/// Adds a first derivative in the pose of a station, as one in the variables of its site.
fn add_slope(state: &State, site: &Site, force: &Vector, moment: &Vector, gradient: &mut Tangent) {
    gradient.points[site.point] += force;
    if let Some(frame) = site.frame {
        let body_force = state.frames[frame].inverse_transform_vector(force);
        gradient.frames[frame] += site.local.orientation * moment + site.local.position.cross(&body_force);
    }
}

/// Second derivatives in the poses of stations, in place as those in the variables of their sites: `δx = δX + J θ` with
/// `J = −R [o]ₓ`, `θ_station = Aᵀ θ`. `slopes` are the first derivatives in the poses.
fn carry(state: &State, sites: &[Site], slopes: &[Vector], table: &mut [Matrix]) {
    let width = 2 * sites.len();
    for (k, site) in sites.iter().enumerate() {
        let Some(frame) = site.frame.filter(|_| is_carried(site)) else { continue };
        let r = state.frames[frame].to_rotation_matrix();
        let a = *site.local.orientation.to_rotation_matrix().matrix();
        let j = -(r.matrix() * skew(&site.local.position));
        for column in 0..width {
            let (x, t) = (table[2 * k * width + column], table[(2 * k + 1) * width + column]);
            table[(2 * k + 1) * width + column] = a * t + j.transpose() * x;
        }
        for row in table.chunks_exact_mut(width) {
            row[2 * k + 1] = row[2 * k + 1] * a.transpose() + row[2 * k] * j;
        }
        table[(2 * k + 1) * width + 2 * k + 1] +=
            lever_hessian(&state.frames[frame], &slopes[2 * k], &site.local.position);
    }
}

/// Makes the second derivatives of a fixing those of [`Problem::make_convex`]: its stations get `stiffness`, N/m.
fn turn_over(stiffness: f64, table: &mut [Matrix], span_table: &mut [Matrix]) {
    let width = table.len().isqrt();
    without_negative_part(table, width);
    span_table.chunks_exact_mut(1).for_each(|own| without_negative_part(own, 1));
    for k in (0..width).step_by(2) {
        table[k * width + k] += Matrix::identity() * stiffness;
    }
}

/// Makes the eigenvalues of a symmetric table of blocks, so many of them to a row, positive.
fn without_negative_part(table: &mut [Matrix], width: usize) {
    let whole = DMatrix::from_fn(3 * width, 3 * width, |i, k| table[i / 3 * width + k / 3][(i % 3, k % 3)]);
    if whole.is_empty() || !whole.iter().all(|x| x.is_finite()) {
        return;
    }
    let modes = SymmetricEigen::new(whole);
    if modes.eigenvalues.iter().all(|e| *e >= -ROUND_OFF * modes.eigenvalues.amax()) {
        return;
    }
    let positive = modes.eigenvalues.map(f64::abs);
    let whole = &modes.eigenvectors * DMatrix::from_diagonal(&positive) * modes.eigenvectors.transpose();
    for (k, block) in table.iter_mut().enumerate() {
        block.copy_from(&whole.fixed_view::<3, 3>(3 * (k / width), 3 * (k % width)));
    }
}

/// Adds ρ JᵀJ of the equations, and of the inequalities that push.
fn add_penalties(
    fixing: &Fixing,
    own: &FixingState,
    slopes: &Slopes,
    unit: f64,
    (table, span_table): (&mut [Matrix], &mut [Matrix]),
) {
    let width = 2 * fixing.stations.len();
    for (r, residual) in fixing.residuals.iter().enumerate() {
        if residual.relation == Relation::NotPositive && slopes.mu[r] == 0.0 {
            continue;
        }
        let rho = own.penalties[r] * unit / (residual.scale * residual.scale);
        if r < fixing.of_stations {
            let row = &slopes.rows[width * r..width * (r + 1)];
            for (block, (a, b)) in table.iter_mut().zip(row.iter().flat_map(|a| row.iter().map(move |b| (a, b)))) {
                *block += a * b.transpose() * rho;
            }
        } else {
            let j = slopes.span_rows[r - fixing.of_stations];
            span_table[fixing.node_of(r)] += j * j.transpose() * rho;
        }
    }
}
