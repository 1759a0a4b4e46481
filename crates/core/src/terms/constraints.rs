//! Energy, gradient and Hessian of constraints with potentials, equations or inequalities; [`crate::prescribed`]
//! eliminates those that prescribe a pose.
//!
//! An equation `c = 0` with multiplier λ and penalty ρ adds `λ c + ½ ρ c²` to the energy, an inequality `c ≤ 0`
//! adds `(μ² − λ²)/(2ρ)` with `μ = max(0, λ + ρ c)`. Either way the forces are `μ J` (with `μ = λ + ρ c`
//! for an equation), and the second derivatives `ρ JᵀJ + μ c″` where `μ` is not cut off. At each minimum the
//! solver replaces λ by μ until λ no longer changes: then `c = 0`, or `c ≤ 0 ≤ λ` and `λ c = 0` (augmented
//! Lagrangian: Bertsekas 1982).

use crate::conditions::{ConstraintState, System};
use crate::constitutive::Derivatives;
use crate::constraint::{Action, ConstraintView, Equations, Potential, Relation, Residual};
use crate::network::{AttachedConstraint, Site};
use crate::rotation::{lever_hessian, skew, turned};
use crate::terms::slope::{Contradiction, Line, Slope};
use crate::variable::{Block, Variable};
use crate::{Matrix, Pose, State, Tangent, Vector};
use nalgebra::{DMatrix, SymmetricEigen};

/// Eigenvalues above minus this fraction of the largest one do not count as negative.
const ROUND_OFF: f64 = 1e-12;

/// Force and moment of a constraint on the harness.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// At each station the force (N) and the moment about it (N m), world axes.
    pub stations: Vec<(Vector, Vector)>,
    /// Force at each node of the span, N.
    pub span: Vec<Vector>,
}

/// One equation or inequality of a constraint, evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintResidual {
    /// Index of its constraint.
    pub constraint: usize,
    /// Its index in the constraint.
    pub residual: usize,
    /// μ.
    pub mu: f64,
    /// `|c|`, or `|max(c, −λ/ρ)|` of an inequality, in units of its scale.
    pub violation: f64,
}

/// Input data of a constraint's model; see [`ConstraintView`].
#[derive(Clone, Default)]
struct Surroundings {
    stations: Vec<Pose>,
    targets: Vec<Pose>,
    span: Vec<Vector>,
    span_lengths: Vec<f64>,
    tensions: Vec<[f64; 2]>,
}

impl Surroundings {
    fn fill(&mut self, constraint: &AttachedConstraint, own: &ConstraintState, target: &Pose, state: &State) {
        self.stations.clear();
        self.stations.extend(constraint.stations.iter().map(|site| state.pose(site)));
        self.targets.clear();
        if !constraint.stations.is_empty() {
            self.targets.push(*target);
            self.targets.extend(own.beside.iter().map(|beside| target.compose(beside)));
        }
        self.span.clear();
        self.span_lengths.clear();
        let Some(span) = &constraint.span else { return };
        self.span.extend(span.sites.iter().map(|site| state.pose(site).position));
        let lengths = &state.rest_lengths[span.points.start..span.points.end - 1];
        self.span_lengths.resize(span.sites.len(), 0.0);
        for (j, l) in lengths.iter().enumerate() {
            self.span_lengths[j] += 0.5 * l;
            self.span_lengths[j + 1] += 0.5 * l;
        }
    }

    fn view<'a>(&'a self, own: &'a ConstraintState) -> ConstraintView<'a> {
        ConstraintView {
            stations: &self.stations,
            targets: &self.targets,
            span: &self.span,
            span_lengths: &self.span_lengths,
            progress: own.progress,
            memory: &own.memory,
            tensions: &self.tensions,
        }
    }

    /// Moves the stations and the span from `origin` by t along a line: vectors 2 a and 2 a + 1 are those of station a.
    fn move_along(&mut self, line: Line, origin: &Self, t: f64) {
        for (a, (pose, from)) in self.stations.iter_mut().zip(&origin.stations).enumerate() {
            pose.position = from.position + line.along(2 * a) * t;
            pose.orientation = turned(&from.orientation, &(line.along(2 * a + 1) * t));
        }
        let first = 2 * self.stations.len();
        for (k, (x, from)) in self.span.iter_mut().zip(&origin.span).enumerate() {
            *x = from + line.along(first + k) * t;
        }
    }

    /// Line along which slopes are compared here.
    fn line(&self) -> Line {
        let poses = self.stations.iter().flat_map(|pose| pose.position.iter().chain(pose.orientation.coords.iter()));
        Line::at(poses.chain(self.span.iter().flatten()))
    }

    /// Whether all its numbers are finite.
    fn is_finite(&self) -> bool {
        let pose = |pose: &Pose| finite(&pose.position) && pose.orientation.coords.iter().all(|x| x.is_finite());
        self.stations.iter().chain(&self.targets).all(pose) && self.span.iter().all(finite)
    }
}

fn finite(v: &Vector) -> bool {
    v.iter().all(|x| x.is_finite())
}

/// Derivatives of one constraint.
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

/// Workspace, refilled for every constraint.
#[derive(Default)]
struct Scratch {
    surroundings: Surroundings,
    slopes: Slopes,
    table: Vec<Matrix>,
    span_table: Vec<Matrix>,
    /// Σ μ c″ of equations beside a potential.
    curvature: [Vec<Matrix>; 2],
}

/// Resizes to `count` zeros.
fn resize_with_zeros<T: Clone>(values: &mut Vec<T>, count: usize, zero: T) {
    values.clear();
    values.resize(count, zero);
}

/// Energy of an equation or inequality, J, and μ; see the module's formulas.
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
    /// First derivatives of the energy of a constraint, and that energy, J; zero for one that prescribes.
    fn fill(
        &mut self,
        constraint: &AttachedConstraint,
        own: &ConstraintState,
        surroundings: &Surroundings,
        unit: f64,
    ) -> f64 {
        let at = surroundings.view(own);
        let (m, n) = (at.stations.len(), at.span.len());
        resize_with_zeros(&mut self.stations, 2 * m, Vector::zeros());
        resize_with_zeros(&mut self.span, n, Vector::zeros());
        let action = constraint.model.action();
        let of_potential = |own: &dyn Potential| own.gradient(&at, &mut self.stations, &mut self.span);
        let mut energy = action.potential().map_or(0.0, of_potential);
        let Some(equations) = action.equations() else { return energy };
        self.linearise(equations, &constraint.residuals, constraint.of_stations, &at);
        resize_with_zeros(&mut self.mu, self.c.len(), 0.0);
        for (r, residual) in constraint.residuals.iter().enumerate() {
            let rho = own.penalties[r] * unit / (residual.scale * residual.scale);
            let (e, mu) = augmented(residual.relation, self.c[r], own.multipliers[r], rho);
            energy += e;
            self.mu[r] = mu;
            if mu == 0.0 {
                continue;
            }
            if r < constraint.of_stations {
                for (g, j) in self.stations.iter_mut().zip(&self.rows[2 * m * r..]) {
                    *g += j * mu;
                }
            } else {
                self.span[constraint.node_of(r)] += self.span_rows[r - constraint.of_stations] * mu;
            }
        }
        energy
    }

    /// Evaluates c and J.
    fn linearise(
        &mut self,
        equations: &dyn Equations,
        residuals: &[Residual],
        of_stations: usize,
        at: &ConstraintView<'_>,
    ) {
        resize_with_zeros(&mut self.c, residuals.len(), 0.0);
        resize_with_zeros(&mut self.rows, 2 * at.stations.len() * of_stations, Vector::zeros());
        resize_with_zeros(&mut self.span_rows, residuals.len() - of_stations, Vector::zeros());
        equations.jacobian(at, &mut self.c, &mut self.rows, &mut self.span_rows);
    }
}

/// Term of the constraints with potentials, equations or inequalities; keeps its workspace.
#[derive(Default)]
pub struct ConstraintTerm {
    scratch: Scratch,
    /// ρ of a residual whose scale and penalty are 1, J.
    pub penalty_unit: f64,
    /// A constraint that has returned a non-finite number for a finite state.
    pub(crate) non_finite: Option<usize>,
}

/// Constraints that act and contribute to the energy.
fn contributing(system: System<'_>) -> impl Iterator<Item = (usize, &AttachedConstraint)> {
    system.acting().filter(|(_, constraint)| !matches!(constraint.model.action(), Action::Prescribed(_)))
}

impl ConstraintTerm {
    /// Energy of the constraints `Σ E + Σ augmented(c, λ, ρ)`, J.
    pub fn energy(&mut self, system: System<'_>, state: &State) -> f64 {
        let Self { scratch: Scratch { surroundings, slopes, .. }, penalty_unit, non_finite } = self;
        let mut energy = 0.0;
        for (c, constraint) in contributing(system) {
            let own = &system.conditions.constraints[c];
            surroundings.fill(constraint, own, &system.conditions.targets[c], state);
            let e = match constraint.model.action() {
                Action::Potential(potential) => potential.energy(&surroundings.view(own)),
                _ => slopes.fill(constraint, own, surroundings, *penalty_unit),
            };
            if !e.is_finite() && non_finite.is_none() && surroundings.is_finite() {
                *non_finite = Some(c);
            }
            energy += e;
        }
        energy
    }

    /// Adds the first derivatives of the energy, `∂E/∂(x, θ)` of potentials and `Σ μ J` of residuals, in the
    /// independent variables; returns the energy, J.
    pub fn gradient(&mut self, system: System<'_>, state: &State, gradient: &mut Tangent) -> f64 {
        let Self { scratch: Scratch { surroundings, slopes, .. }, penalty_unit, non_finite } = self;
        let mut energy = 0.0;
        for (c, constraint) in contributing(system) {
            let own = &system.conditions.constraints[c];
            surroundings.fill(constraint, own, &system.conditions.targets[c], state);
            let e = slopes.fill(constraint, own, surroundings, *penalty_unit);
            let all = || slopes.stations.iter().chain(&slopes.span);
            if (!e.is_finite() || !all().all(finite)) && non_finite.is_none() && surroundings.is_finite() {
                *non_finite = Some(c);
            }
            energy += e;
            for (site, g) in constraint.stations.iter().zip(slopes.stations.chunks_exact(2)) {
                add_slope(state, site, &g[0], &g[1], gradient);
            }
            for (site, g) in constraint.span.iter().flat_map(|span| &span.sites).zip(&slopes.span) {
                add_slope(state, site, g, &Vector::zeros(), gradient);
            }
        }
        energy
    }

    /// Adds the second derivatives of the energy at `state`, `∂²E/∂(x, θ)²` of potentials and
    /// `Σ ρ JᵀJ + μ c″` of residuals, in the independent variables: both triangles.
    ///
    /// With `convex` negative eigenvalues of the second derivatives of potentials, and of μ c″ of equations, change
    /// their sign (Dauphin and others 2014), and every station gets the translational `stiffness` (N/m).
    pub fn hessian(&mut self, system: System<'_>, state: &State, convex: Option<Convex>, blocks: &mut Vec<Block>) {
        let Self { scratch, penalty_unit, non_finite } = self;
        let Scratch { surroundings, slopes, table, span_table, curvature } = scratch;
        let unit = *penalty_unit;
        for (c, constraint) in contributing(system) {
            let own = &system.conditions.constraints[c];
            surroundings.fill(constraint, own, &system.conditions.targets[c], state);
            let (m, n) = (surroundings.stations.len(), surroundings.span.len());
            resize_with_zeros(table, 4 * m * m, Matrix::zeros());
            resize_with_zeros(span_table, n, Matrix::zeros());
            // Residuals need μ, and forces at levers contribute to the second derivatives.
            let sites = || constraint.stations.iter().chain(constraint.span.iter().flat_map(|span| &span.sites));
            if !constraint.residuals.is_empty() || sites().any(has_lever) {
                slopes.fill(constraint, own, surroundings, unit);
            } else {
                resize_with_zeros(&mut slopes.stations, 2 * m, Vector::zeros());
                resize_with_zeros(&mut slopes.span, n, Vector::zeros());
            }
            let at = surroundings.view(own);
            match constraint.model.action() {
                Action::Prescribed(_) => {}
                Action::Potential(potential) => potential.hessian(&at, table, span_table),
                Action::Equations(equations) => equations.curvature(&at, &slopes.mu, table, span_table),
                Action::PotentialAndEquations(potential, equations) => {
                    potential.hessian(&at, table, span_table);
                    let [of_stations, of_span] = curvature;
                    resize_with_zeros(of_stations, table.len(), Matrix::zeros());
                    resize_with_zeros(of_span, n, Matrix::zeros());
                    equations.curvature(&at, &slopes.mu, of_stations, of_span);
                    table.iter_mut().zip(of_stations).for_each(|(sum, more)| *sum += *more);
                    span_table.iter_mut().zip(of_span).for_each(|(sum, more)| *sum += *more);
                }
            }
            if let Some(Convex { stiffness }) = convex {
                make_convex(stiffness, table, span_table);
            }
            // Without residuals it adds nothing.
            add_penalties(constraint, own, slopes, unit, (table, span_table));
            let whole = table.iter().chain(span_table.iter()).all(|block| block.iter().all(|x| x.is_finite()));
            if !whole && non_finite.is_none() && surroundings.is_finite() {
                *non_finite = Some(c);
            }
            transform(state, &constraint.stations, &slopes.stations, table);
            for (row_site, row) in constraint.stations.iter().zip(table.chunks_exact(4 * m.max(1))) {
                let (of_point, of_frame) = row.split_at(2 * m);
                for (b, column_site) in constraint.stations.iter().enumerate() {
                    for (k, row) in variables(row_site) {
                        let of = if k == 0 { of_point } else { of_frame };
                        for (l, column) in variables(column_site) {
                            blocks.push(Block { row, column, matrix: of[2 * b + l] });
                        }
                    }
                }
            }
            let sites = constraint.span.iter().flat_map(|span| &span.sites);
            for ((site, force), h) in sites.zip(&slopes.span).zip(span_table.iter()) {
                let mut own = [*h, Matrix::zeros(), Matrix::zeros(), Matrix::zeros()];
                transform(state, std::slice::from_ref(site), &[*force, Vector::zeros()], &mut own);
                for (k, row) in variables(site) {
                    for (l, column) in variables(site) {
                        blocks.push(Block { row, column, matrix: own[2 * k + l] });
                    }
                }
            }
        }
    }

    /// First constraint (by index) whose first derivatives at `state` are not those of its energy, or of a residual
    /// that exerts a force, or whose potential, if it remembers nothing, has second derivatives that are not
    /// those of its forces.
    pub fn contradiction(&mut self, system: System<'_>, state: &State) -> Option<(usize, Derivatives, Contradiction)> {
        let Self { scratch: Scratch { surroundings, slopes, .. }, penalty_unit, .. } = self;
        contributing(system).find_map(|(c, constraint)| {
            let own = &system.conditions.constraints[c];
            surroundings.fill(constraint, own, &system.conditions.targets[c], state);
            slopes.fill(constraint, own, surroundings, *penalty_unit);
            let m = surroundings.stations.len();
            let line = surroundings.line();
            let mut moved = surroundings.clone();
            let mut at = |t: f64, value: &mut dyn FnMut(&ConstraintView<'_>) -> f64| {
                moved.move_along(line, surroundings, t);
                value(&moved.view(own))
            };
            let action = constraint.model.action();
            let of_potential = action.potential().and_then(|potential| {
                // Those of the potential alone.
                let mut stations = vec![Vector::zeros(); 2 * m];
                let mut span = vec![Vector::zeros(); surroundings.span.len()];
                potential.gradient(&surroundings.view(own), &mut stations, &mut span);
                let mut slope = Slope::default();
                stations.iter().chain(&span).enumerate().for_each(|(k, g)| slope.add(g, &line.along(k)));
                let first = slope.contradiction(|t| at(t, &mut |view| potential.energy(view)));
                if let Some(found) = first {
                    return Some((Derivatives::First, found));
                }
                if !own.memory.is_empty() {
                    return None;
                }
                let mut table = vec![Matrix::zeros(); 4 * m * m];
                let mut span_table = vec![Matrix::zeros(); span.len()];
                potential.hessian(&surroundings.view(own), &mut table, &mut span_table);
                let mut slope = Slope::default();
                for (a, row) in table.chunks_exact((2 * m).max(1)).enumerate() {
                    row.iter().enumerate().for_each(|(b, block)| slope.add(&(block * line.along(b)), &line.along(a)));
                }
                for (k, block) in (2 * m..).zip(&span_table) {
                    slope.add(&(block * line.along(k)), &line.along(k));
                }
                let second = slope.contradiction(|t| {
                    at(t, &mut |view| {
                        stations.fill(Vector::zeros());
                        span.fill(Vector::zeros());
                        potential.gradient(view, &mut stations, &mut span);
                        stations.iter().chain(&span).enumerate().map(|(k, g)| g.dot(&line.along(k))).sum()
                    })
                });
                second.map(|found| (Derivatives::Second, found))
            });
            let mut of_equations = |equations: &dyn Equations| {
                let mut values = vec![0.0; slopes.mu.len()];
                (0..values.len()).filter(|r| slopes.mu[*r] != 0.0).find_map(|r| {
                    let mut slope = Slope::default();
                    if r < constraint.of_stations {
                        let row = &slopes.rows[2 * m * r..2 * m * (r + 1)];
                        row.iter().enumerate().for_each(|(k, j)| slope.add(j, &line.along(k)));
                    } else {
                        let node = 2 * m + constraint.node_of(r);
                        slope.add(&slopes.span_rows[r - constraint.of_stations], &line.along(node));
                    }
                    slope.contradiction(|t| {
                        at(t, &mut |view| {
                            equations.residuals(view, &mut values);
                            values[r]
                        })
                    })
                })
            };
            let of_equations = |equations| of_equations(equations).map(|found| (Derivatives::First, found));
            let found = of_potential.or_else(|| action.equations().and_then(of_equations));
            found.map(|(which, found)| (c, which, found))
        })
    }

    /// Reaction of a constraint (by index) with a potential, equations or inequalities, at `state`:
    /// `−∂E/∂(x, θ)`.
    pub fn reaction(&self, system: System<'_>, c: usize, state: &State) -> Reaction {
        let (constraint, own) = (&system.network.constraints[c], &system.conditions.constraints[c]);
        let mut scratch = Scratch::default();
        scratch.surroundings.fill(constraint, own, &system.conditions.targets[c], state);
        scratch.slopes.fill(constraint, own, &scratch.surroundings, self.penalty_unit);
        let stations = scratch.surroundings.stations.iter().zip(scratch.slopes.stations.chunks_exact(2));
        Reaction {
            stations: stations.map(|(pose, g)| (-g[0], -(pose.orientation * g[1]))).collect(),
            span: scratch.slopes.span.iter().map(|g| -g).collect(),
        }
    }

    /// Names and values of the outputs of a constraint that acts ([`crate::Constraint::outputs`]), with the tensions
    /// beside its stations.
    pub fn outputs(&self, system: System<'_>, c: usize, state: &State, tensions: Vec<[f64; 2]>) -> Vec<(String, f64)> {
        let (constraint, own) = (&system.network.constraints[c], &system.conditions.constraints[c]);
        let mut surroundings = Surroundings::default();
        surroundings.fill(constraint, own, &system.conditions.targets[c], state);
        surroundings.tensions = tensions;
        constraint.model.outputs(&surroundings.view(own))
    }

    /// Every residual of the constraints that act, in order; allocates.
    pub fn residuals(&self, system: System<'_>, state: &State) -> Vec<ConstraintResidual> {
        let mut found = Vec::new();
        let mut scratch = Scratch::default();
        for (c, constraint) in contributing(system).filter(|(_, constraint)| !constraint.residuals.is_empty()) {
            let own = &system.conditions.constraints[c];
            scratch.surroundings.fill(constraint, own, &system.conditions.targets[c], state);
            scratch.slopes.fill(constraint, own, &scratch.surroundings, self.penalty_unit);
            for (r, residual) in constraint.residuals.iter().enumerate() {
                let (value, mu) = (scratch.slopes.c[r], scratch.slopes.mu[r]);
                let rho = own.penalties[r] * self.penalty_unit / (residual.scale * residual.scale);
                let excess = match residual.relation {
                    Relation::NotPositive if mu == 0.0 => own.multipliers[r] / rho,
                    _ => value.abs(),
                };
                found.push(ConstraintResidual { constraint: c, residual: r, mu, violation: excess / residual.scale });
            }
        }
        found
    }

    /// Updated memory of every constraint that acts and has one, by index, at `state`, the equilibrium that ends an
    /// increment; `tensions` are those beside the stations of a constraint.
    pub fn memories(
        &self,
        system: System<'_>,
        state: &State,
        tensions: impl Fn(&AttachedConstraint) -> Vec<[f64; 2]>,
    ) -> Vec<(usize, Vec<f64>)> {
        let mut surroundings = Surroundings::default();
        let mut memories = Vec::new();
        for (c, constraint) in system.acting() {
            let own = &system.conditions.constraints[c];
            if own.memory.is_empty() {
                continue;
            }
            surroundings.fill(constraint, own, &system.conditions.targets[c], state);
            surroundings.tensions = tensions(constraint);
            let mut memory = own.memory.clone();
            constraint.model.commit(&surroundings.view(own), &mut memory);
            memories.push((c, memory));
        }
        memories
    }
}

/// Convex model of the second derivatives, for a matrix that no shift of the rotational blocks makes positive definite:
/// a compressed strut, a penalty far from its equation, a component connected by a constraint alone.
#[derive(Clone, Copy)]
pub struct Convex {
    /// Translational stiffness added at every station, N/m.
    pub stiffness: f64,
}

/// Variables of a site: 0, its point; 1, its frame.
fn variables(site: &Site) -> impl Iterator<Item = (usize, Variable)> {
    [(0, Some(Variable::Point(site.point))), (1, site.frame.map(Variable::Frame))]
        .into_iter()
        .filter_map(|(k, variable)| variable.map(|variable| (k, variable)))
}

/// Whether the pose of a station differs from that of its point and frame.
fn has_lever(site: &Site) -> bool {
    site.local != Pose::identity()
}

/// Adds a first derivative in the pose of a station (force f, moment m), in the variables of its site: `g_x += f`,
/// `g_θ += A m + o × Rᵀ f` with the local orientation A and position o.
fn add_slope(state: &State, site: &Site, force: &Vector, moment: &Vector, gradient: &mut Tangent) {
    gradient.points[site.point] += force;
    if let Some(frame) = site.frame {
        let body_force = state.frames[frame].inverse_transform_vector(force);
        gradient.frames[frame] += site.local.orientation * moment + site.local.position.cross(&body_force);
    }
}

/// Transforms second derivatives in the poses of stations, in place, to those in the variables of their sites:
/// `δx = δX + J θ` with `J = −R [o]ₓ`, `θ_station = Aᵀ θ`. `slopes` are the first derivatives in the poses;
/// with the lever o they contribute [`lever_hessian`].
fn transform(state: &State, sites: &[Site], slopes: &[Vector], table: &mut [Matrix]) {
    let width = 2 * sites.len();
    for (k, site) in sites.iter().enumerate() {
        let Some(frame) = site.frame.filter(|_| has_lever(site)) else { continue };
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

/// Makes the second derivatives of a constraint convex and adds the translational `stiffness` (N/m) at its stations.
fn make_convex(stiffness: f64, table: &mut [Matrix], span_table: &mut [Matrix]) {
    let width = table.len().isqrt();
    without_negative_part(table, width);
    span_table.chunks_exact_mut(1).for_each(|own| without_negative_part(own, 1));
    for k in (0..width).step_by(2) {
        table[k * width + k] += Matrix::identity() * stiffness;
    }
}

/// Replaces the eigenvalues of a symmetric table of blocks, `width` of them in a row, by their absolute values.
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

/// Adds ρ JᵀJ of the equations and of the active inequalities.
fn add_penalties(
    constraint: &AttachedConstraint,
    own: &ConstraintState,
    slopes: &Slopes,
    unit: f64,
    (table, span_table): (&mut [Matrix], &mut [Matrix]),
) {
    let width = 2 * constraint.stations.len();
    for (r, residual) in constraint.residuals.iter().enumerate() {
        if residual.relation == Relation::NotPositive && slopes.mu[r] == 0.0 {
            continue;
        }
        let rho = own.penalties[r] * unit / (residual.scale * residual.scale);
        if r < constraint.of_stations {
            let row = &slopes.rows[width * r..width * (r + 1)];
            for (block, (a, b)) in table.iter_mut().zip(row.iter().flat_map(|a| row.iter().map(move |b| (a, b)))) {
                *block += a * b.transpose() * rho;
            }
        } else {
            let j = slopes.span_rows[r - constraint.of_stations];
            span_table[constraint.node_of(r)] += j * j.transpose() * rho;
        }
    }
}
