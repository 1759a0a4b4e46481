//! Statics of a result, from the numbers of the scenario and of `result.json` alone: the whole and every part are in
//! balance, constraints hold where they should, energies add up.
//!
//! What a branch exerts on a joint, with n and m what the part with larger s exerts on the part with smaller s: n and m
//! where it begins, −n and −m where it ends.

use super::outcome::{BranchOutcome, ConstraintOutcome, Outcome, StepOutcome};
use super::scene::{Branch, Constraint, Facing, Load, Place, Scene, Shape};
use std::f64::consts::TAU;
use wireloom::geometry::{Rotation, Vector};

/// Share of a part's own forces by which they may miss the balance. The solver's tolerance is a thousandth of that.
const BALANCE: f64 = 1e-3;
/// Share of the internal forces, whatever the part's own scale is, for the tolerance of the solver may be relative to
/// them.
const OF_INTERNAL: f64 = 1e-5;
/// The same of moments of the whole, where what is left at some hundred nodes adds up.
const OF_MOMENTS: f64 = 3e-5;
/// Share of EA that is round-off of strains.
const ROUND_OFF: f64 = 1e-11;
/// Share of a segment's weight that may hang at the other one of its nodes: of the discretisation.
const STATION: f64 = 71.0 / 600.0;
/// Distance from its target that a constraint may have, per length of the longest branch; and its turn, rad.
const OFF_TARGET: f64 = 1e-5;

/// A wrong statement of a result.
pub struct Wrong {
    /// Kind of fault in one or two words; shrinking keeps it.
    pub kind: &'static str,
    /// The numbers.
    pub words: String,
}

/// Collects what is wrong.
struct Bench<'a> {
    scene: &'a Scene,
    step: usize,
    end: &'a StepOutcome,
    gravity: Vector,
    wrong: Vec<Wrong>,
}

/// All that is wrong in the statics of a converged result.
pub fn statics(scene: &Scene, outcome: &Outcome) -> Vec<Wrong> {
    let mut wrong = Vec::new();
    for (step, end) in outcome.steps.iter().enumerate().filter(|(_, end)| end.status == "converged") {
        let gravity = scene.gravity_at(Some(step));
        let mut bench = Bench { scene, step, end, gravity, wrong: Vec::new() };
        bench.finite();
        if bench.wrong.is_empty() {
            bench.whole();
            bench.branches();
            bench.joints();
            bench.constraints();
            bench.obstacles();
            bench.energies();
        }
        wrong.append(&mut bench.wrong);
    }
    released(scene, outcome, &mut wrong);
    turns(scene, outcome, &mut wrong);
    wrong
}

/// A wrench about the origin.
#[derive(Clone, Copy)]
struct Wrench {
    force: Vector,
    moment: Vector,
    /// Sum of sizes.
    size: f64,
}

impl Wrench {
    fn none() -> Self {
        Self { force: Vector::zeros(), moment: Vector::zeros(), size: 0.0 }
    }

    fn add(&mut self, force: Vector, at: &Vector, moment: Vector) {
        self.force += force;
        self.moment += at.cross(&force) + moment;
        self.size += force.norm();
    }
}

impl Bench<'_> {
    fn say(&mut self, kind: &'static str, words: String) {
        self.wrong.push(Wrong { kind, words: format!("step {}: {words}", self.step) });
    }

    fn of(&self, branch: &Branch) -> &BranchOutcome {
        &self.end.branches[&format!("b{}", branch.name)]
    }

    fn exerts(&self, constraint: &Constraint) -> Option<&ConstraintOutcome> {
        self.end.constraints.get(&format!("c{}", constraint.name))
    }

    /// Whether forces act on the cables that no list tells.
    fn touches(&self) -> bool {
        !self.scene.obstacles.is_empty() || self.scene.cables.is_some()
    }

    fn finite(&mut self) {
        let odd = |b: &BranchOutcome| {
            let vectors = b.position.iter().chain(&b.d3).chain(&b.force).chain(&b.moment);
            vectors.into_iter().any(|v| !v.iter().all(|x| x.is_finite()))
        };
        if self.end.branches.values().any(odd) || !self.end.energy.total.is_finite() {
            self.say("not finite", "a number of a converged result is not finite".into());
        }
    }

    /// Position of a place, m.
    fn position(&self, place: Place) -> Vector {
        match place {
            Place::On(name, s) => {
                let b = self.of(self.scene.branch(name));
                let at = b.s.iter().enumerate().min_by(|x, y| (x.1 - s).abs().total_cmp(&(y.1 - s).abs()));
                b.position[at.map_or(0, |(node, _)| node)]
            }
            Place::Vertex(v) if self.scene.joint(v).is_some() => self.end.joints[&format!("V{v}")].position,
            Place::Vertex(v) => {
                let branch = self.scene.branches.iter().find(|b| b.ends.contains(&v)).expect("a branch");
                let x = &self.of(branch).position;
                if branch.ends[0] == v { x[0] } else { x[x.len() - 1] }
            }
        }
    }

    fn factor(&self, load: &Load) -> f64 {
        self.scene.factor_at(load, self.step)
    }

    /// Pieces of the harness that are joined: for every branch the number of its piece.
    fn pieces(&self) -> Vec<usize> {
        let branches = &self.scene.branches;
        let mut piece: Vec<usize> = (0..branches.len()).collect();
        for _ in 0..branches.len() {
            for a in 0..branches.len() {
                for b in 0..branches.len() {
                    if branches[a].ends.iter().any(|v| branches[b].ends.contains(v)) {
                        let least = piece[a].min(piece[b]);
                        (piece[a], piece[b]) = (least, least);
                    }
                }
            }
        }
        piece
    }

    fn piece_of(&self, place: Place, piece: &[usize]) -> usize {
        let index = match place {
            Place::On(name, _) => self.scene.branches.iter().position(|b| b.name == name),
            Place::Vertex(v) => self.scene.branches.iter().position(|b| b.ends.contains(&v)),
        };
        piece[index.expect("a branch")]
    }

    /// Weight, loads, reactions and what bodies push with cancel each other: for each piece of the harness, or the
    /// whole of it where bodies push.
    fn whole(&mut self) {
        let piece = self.pieces();
        let together = self.touches();
        let mut pieces = piece.clone();
        pieces.sort_unstable();
        pieces.dedup();
        if together {
            pieces.truncate(1);
        }
        for p in pieces {
            let of_piece = |q: usize| together || q == p;
            let (mut all, mut unsure, mut applied) = (Wrench::none(), 0.0, 0.0);
            // Moments are about a point of the piece: its lever arms are then those of the harness.
            let first = self.scene.branches.iter().zip(&piece).find(|(_, q)| of_piece(**q)).expect("a branch").0;
            let about = self.of(first).position[0];
            let (mut size, mut axial, mut bending) = (0.0_f64, 0.0_f64, 0.0_f64);
            for (branch, _) in self.scene.branches.iter().zip(&piece).filter(|(_, q)| of_piece(**q)) {
                let b = self.of(branch);
                size = b.position.iter().map(|x| (x - about).norm()).fold(size, f64::max);
                axial = axial.max(branch.ea);
                bending = bending.max(branch.ei[0].max(branch.ei[1]) / branch.length.powi(2));
                let weight = self.gravity * branch.density;
                for i in 0..b.s.len() - 1 {
                    let ds = b.s[i + 1] - b.s[i];
                    for node in [i, i + 1] {
                        all.add(weight * (0.5 * ds), &(b.position[node] - about), Vector::zeros());
                    }
                    // Nodes are drawn on the centre line, not where the weight hangs; at stations 1/24 of it hangs
                    // elsewhere.
                    unsure += weight.norm() * ds * b.chord(i) * ((b.d3[i + 1] - b.d3[i]).norm() / 12.0 + 1.0 / 12.0);
                }
                applied += weight.norm() * branch.length;
            }
            for joint in &self.scene.joints {
                if of_piece(self.piece_of(Place::Vertex(joint.vertex), &piece)) {
                    let weight = self.gravity * joint.mass;
                    applied += weight.norm();
                    all.add(weight, &(self.position(Place::Vertex(joint.vertex)) - about), Vector::zeros());
                    // A joint of two arms is drawn on the centre line, too.
                    let longest = self.longest_segment(joint.vertex);
                    unsure += weight.norm() * longest / 12.0;
                    for arm in &joint.arms {
                        let b = self.scene.branch(arm.branch);
                        unsure += self.gravity.norm() * b.density * b.length / b.segments as f64 * longest / 8.0;
                    }
                }
            }
            let mut moments = 0.0;
            for load in self.scene.loads.iter().filter(|l| of_piece(self.piece_of(l.at, &piece))) {
                let f = self.factor(load);
                applied += load.force.norm() * f.abs();
                moments += load.moment.norm() * f.abs();
                let at = self.position(load.at);
                all.add(load.force * f, &(at - about), load.moment * f);
                if let Place::Vertex(v) = load.at
                    && self.scene.joint(v).is_some()
                {
                    unsure += load.force.norm() * f.abs() * self.longest_segment(v) / 12.0;
                }
            }
            let mut held = 0.0;
            for constraint in self.scene.constraints.iter().filter(|f| of_piece(self.piece_of(f.at, &piece))) {
                let Some(c) = self.exerts(constraint) else { continue };
                held += c.force.norm();
                moments += c.moment.norm();
                all.add(c.force, &(c.position - about), c.moment);
            }
            for o in self.end.obstacles.values() {
                held += o.force.norm();
                all.add(o.force, &(o.position - about), o.moment);
            }
            // What bends no branch by 1e-5 of its length is nothing.
            let allowed = BALANCE * applied + OF_INTERNAL * (held + bending) + ROUND_OFF * axial;
            if all.force.norm() > allowed {
                let gap = all.force.norm();
                self.say(
                    "global force balance",
                    format!(
                        "weight, loads and reactions are out of balance by {gap:.3e} N; applied {applied:.3e} N, \
                             reactions {held:.3e} N"
                    ),
                );
            }
            // Friction pushes at the surface, a radius beside what is drawn; that is in the moments of bodies.
            let allowed = allowed * size + 1.5 * unsure + OF_MOMENTS * (moments + held * size);
            if all.moment.norm() > allowed {
                let gap = all.moment.norm();
                self.say(
                    "global moment balance",
                    format!(
                        "moments of weight, loads and reactions are out of balance by {gap:.3e} N m; allowed \
                             {allowed:.1e} N m"
                    ),
                );
            }
        }
    }

    /// Length of the longest segment of the branches that end at a vertex, m; 0 where only one does.
    fn longest_segment(&self, vertex: usize) -> f64 {
        let Some(joint) = self.scene.joint(vertex) else { return 0.0 };
        let arms = joint.arms.iter().map(|arm| self.of(self.scene.branch(arm.branch)));
        arms.flat_map(|b| (0..b.s.len() - 1).map(|i| b.chord(i))).fold(0.0, f64::max)
    }

    /// Arc lengths within a branch where constraints or loads act.
    fn stations(&self, branch: &Branch) -> Vec<f64> {
        let places = self.scene.constraints.iter().map(|f| f.at).chain(self.scene.loads.iter().map(|l| l.at));
        let on = |place: Place| match place {
            Place::On(name, s) if name == branch.name => Some(s),
            _ => None,
        };
        places.filter_map(on).collect()
    }

    /// Along every branch `n' + ρ g = 0` and `m' + x' × n = 0`.
    fn branches(&mut self) {
        if self.touches() {
            return;
        }
        let slides = |branch: &Branch| {
            self.scene
                .constraints
                .iter()
                .any(|f| f.slide.is_some() && matches!(f.at, Place::On(name, _) if name == branch.name))
        };
        let branches: Vec<&Branch> = self.scene.branches.iter().filter(|b| !slides(b)).collect();
        for branch in branches {
            let stations = self.stations(branch);
            let b = self.of(branch);
            let weight = self.gravity * branch.density;
            let soft = branch.ei[0].min(branch.ei[1]);
            let (bending, hanging) = (soft / branch.length.powi(2), weight.norm() * branch.length);
            let internal = b.force.iter().map(|f| f.norm()).fold(0.0, f64::max);
            let inner_moment = b.moment.iter().map(|f| f.norm()).fold(0.0, f64::max);
            let force = BALANCE * bending.max(hanging) + OF_INTERNAL * internal + ROUND_OFF * branch.ea;
            let (mut worst_force, mut worst_moment) = (0.0_f64, 0.0_f64);
            let near = |s: f64| stations.iter().any(|t| (t - s).abs() < 1e-7 * branch.length);
            for i in 0..b.s.len() - 1 {
                if near(b.s[i]) || near(b.s[i + 1]) {
                    continue;
                }
                let ds = b.s[i + 1] - b.s[i];
                // Beside stations a part of a segment's weight hangs at the next node.
                let gap = b.force[i + 1] - b.force[i] + weight * ds;
                let hangs = STATION * weight.norm() * ds;
                worst_force = worst_force.max(gap.norm() - 2.0 * hangs);
                let edge = b.position[i + 1] - b.position[i];
                let gap = b.moment[i + 1] - b.moment[i] + edge.cross(&((b.force[i] + b.force[i + 1]) * 0.5));
                // Nodes are drawn beside the edges by ℓ² x″/24, whether the cable bends there or shears; at joints ℓ is
                // a mean of both sides. On coarse meshes, thrice as much is left by differences across a few nodes.
                let bent = |k: usize| {
                    let (j, l) = (k.saturating_sub(1), (k + 1).min(b.s.len() - 1));
                    let sheared = (b.position[l] - b.position[k]) - (b.position[k] - b.position[j]);
                    let inner = if j < k && k < l { sheared.norm() } else { 0.0 };
                    inner.max(b.chord(i) * (b.d3[l] - b.d3[j]).norm())
                };
                let ends = [(i == 0, 0), (i + 2 == b.s.len(), 1)];
                let at_joint =
                    ends.iter().filter(|(is_end, _)| *is_end).map(|(_, k)| self.longest_segment(branch.ends[*k]));
                let at_joint: f64 = at_joint.sum();
                let drawn = internal * (bent(i) + bent(i + 1) + at_joint) / 4.0;
                worst_moment = worst_moment.max(gap.norm() - drawn - hangs * ds);
            }
            let name = branch.name;
            if worst_force > force {
                let scale = bending.max(hanging);
                self.say(
                    "force balance along a branch",
                    format!(
                        "b{name}: {worst_force:.3e} N of a segment are not balanced; its own forces are {scale:.3e} N"
                    ),
                );
            }
            let moment = (force + ROUND_OFF * branch.ea) * branch.length + OF_INTERNAL * inner_moment;
            if worst_moment > moment {
                self.say(
                    "moment balance along a branch",
                    format!("b{name}: {worst_moment:.3e} N m of a segment are not balanced; allowed {moment:.1e} N m"),
                );
            }
        }
    }

    /// Balance of each joint: arms, weight, loads and constraints.
    fn joints(&mut self) {
        if self.touches() {
            return;
        }
        for joint in &self.scene.joints {
            let at = self.end.joints[&format!("V{}", joint.vertex)].position;
            let mut all = Wrench::none();
            let (mut own, mut internal, mut moments, mut axial, mut longest) =
                (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
            let (mut drawn, mut hangs) = (0.0, 0.0);
            for arm in &joint.arms {
                let branch = self.scene.branch(arm.branch);
                let b = self.of(branch);
                let n = b.s.len() - 1;
                let (node, sign) = if branch.ends[0] == joint.vertex { (0, 1.0) } else { (n, -1.0) };
                let lever = b.position[node] - at;
                all.add(b.force[node] * sign, &lever, b.moment[node] * sign);
                let soft = branch.ei[0].max(branch.ei[1]);
                own = own.max(soft / branch.length.powi(2)).max(self.gravity.norm() * branch.density * branch.length);
                internal = internal.max(b.force[node].norm());
                moments = moments.max(b.moment[node].norm());
                axial = axial.max(branch.ea);
                longest = longest.max(branch.length);
                // Where both of its nodes are stations each takes over a part of what hangs at the other.
                let ds = if node == 0 { b.s[1] - b.s[0] } else { b.s[n] - b.s[n - 1] };
                hangs += STATION * self.gravity.norm() * branch.density * ds;
                // A joint of two arms is drawn where the centre line is.
                drawn += b.force[node].norm() * branch.length / branch.segments as f64 / 12.0;
            }
            all.add(self.gravity * joint.mass, &Vector::zeros(), Vector::zeros());
            for load in self.scene.loads.iter().filter(|l| l.at == Place::Vertex(joint.vertex)) {
                let f = self.factor(load);
                all.add(load.force * f, &Vector::zeros(), load.moment * f);
            }
            for constraint in self.scene.constraints.iter().filter(|f| f.at == Place::Vertex(joint.vertex)) {
                if let Some(c) = self.exerts(constraint) {
                    all.add(c.force, &(c.position - at), c.moment);
                }
            }
            let vertex = joint.vertex;
            let force = BALANCE * own + OF_INTERNAL * internal + ROUND_OFF * axial + hangs;
            let gap = all.force.norm();
            if gap > force {
                self.say(
                    "force balance of a joint",
                    format!("V{vertex}: {gap:.3e} N are not balanced; allowed {force:.1e} N"),
                );
            }
            let two = joint.arms.len() == 2;
            let moment = force * longest + OF_INTERNAL * moments + if two { drawn } else { 0.0 };
            let gap = all.moment.norm();
            if gap > moment {
                self.say(
                    "moment balance of a joint",
                    format!("V{vertex}: {gap:.3e} N m are not balanced; allowed {moment:.1e} N m"),
                );
            }
        }
    }

    /// Target of a constraint at the end of the step: position and orientation, if they are given.
    fn target(&self, constraint: &Constraint) -> (Option<Vector>, Facing) {
        let (mut position, mut facing) = (constraint.position, constraint.facing);
        let upto = (self.step + 1).min(self.scene.steps.len());
        for motion in self.scene.steps[..upto].iter().flat_map(|s| &s.moves).filter(|m| m.constraint == constraint.name)
        {
            position = motion.position.or(position);
            if motion.facing != Facing::Open {
                facing = motion.facing;
            }
            if let Facing::Frame(q) = facing {
                facing = Facing::Frame(q * Rotation::from_scaled_axis(Vector::z() * (TAU * motion.turns)));
            }
        }
        (position, facing)
    }

    /// Constraints hold what they hold where they are told to, and pull only along what they hold.
    fn constraints(&mut self) {
        let length = self.scene.length();
        for constraint in &self.scene.constraints {
            let Some(c) = self.exerts(constraint) else { continue };
            let c = c.clone();
            let (position, facing) = self.target(constraint);
            let name = constraint.name;
            if let (Some(k), Some(position)) = (constraint.stiffness, position) {
                let gap = (c.force + (c.position - position) * k).norm();
                if gap > 1e-4 * c.force.norm() + OFF_TARGET * k * length {
                    self.say("a spring's law", format!("c{name}: the spring's force is off its law by {gap:.3e} N"));
                }
                continue;
            }
            if let Some(position) = position {
                let mut off = c.position - position;
                if let Some(rail) = constraint.rail {
                    off -= rail * rail.dot(&off);
                }
                if off.norm() > OFF_TARGET * length {
                    let off = off.norm();
                    self.say("off its target", format!("c{name} is {off:.3e} m from where it should hold"));
                }
            }
            let off = match facing {
                Facing::Open => 0.0,
                Facing::Tangent(t) => (c.orientation * Vector::z()).angle(&t),
                Facing::Frame(q) => match constraint.free_axis {
                    None => c.orientation.angle_to(&q),
                    // Turned about the axis alone, it leaves the axis where it was.
                    Some(axis) => (c.orientation * (q.inverse() * axis)).angle(&axis),
                },
            };
            // A frame is known to the round-off of an arc cosine.
            if off > OFF_TARGET + 1e-6 {
                self.say("off its target", format!("c{name} is turned by {off:.3e} rad from how it should hold"));
            }
            let mut free = Vec::new();
            if let Some(rail) = constraint.rail {
                free.push(("along its rail", rail.dot(&c.force).abs(), c.force.norm()));
            }
            if let Some(axis) = constraint.free_axis {
                free.push(("about its hinge", axis.dot(&c.moment).abs(), c.moment.norm()));
            }
            if constraint.kind == "handle" && constraint.facing == Facing::Open && constraint.from_step.is_none() {
                free.push(("about a point", c.moment.norm(), c.force.norm() * length));
            }
            let own = self.own_force(constraint);
            for (what, value, of) in free {
                let scale = if what == "along its rail" { own } else { own * length };
                if value > BALANCE * scale + OF_INTERNAL * of {
                    self.say(
                        "pulls where it is free",
                        format!("c{name} exerts {value:.3e} (N or N m) {what}, where it holds nothing"),
                    );
                }
            }
        }
    }

    /// Force scale of what a constraint holds, N.
    fn own_force(&self, constraint: &Constraint) -> f64 {
        let own =
            |b: &Branch| (b.ei[0].max(b.ei[1]) / b.length.powi(2)).max(self.gravity.norm() * b.density * b.length);
        let touched = self.scene.branches.iter().filter(|b| match constraint.at {
            Place::On(name, _) => b.name == name,
            Place::Vertex(v) => b.ends.contains(&v),
        });
        touched.map(own).fold(0.0, f64::max)
    }

    /// Bodies push outwards, within their friction, where they are touched; nothing is inside a plane.
    fn obstacles(&mut self) {
        for (k, obstacle) in self.scene.obstacles.iter().enumerate() {
            let o = self.end.obstacles[&format!("o{k}")].clone();
            let applied: f64 = self.end.constraints.values().map(|c| c.force.norm()).sum();
            if o.contacts == 0 && o.force.norm() > 1e-9 * applied {
                let force = o.force.norm();
                self.say("force without contact", format!("o{k} exerts {force:.3e} N and touches nothing"));
            }
            if !matches!(obstacle.shape, Shape::Plane) {
                continue;
            }
            let normal = obstacle.orientation * Vector::z();
            let push = o.force.dot(&normal);
            let along = (o.force - normal * push).norm();
            if push < -1e-3 * along - 1e-6 * applied
                || along > obstacle.friction * push * 1.01 + 1e-4 * push.abs() + 1e-6 * applied
            {
                let friction = obstacle.friction;
                self.say(
                    "Coulomb's law",
                    format!(
                        "o{k} pushes with {push:.3e} N and with {along:.3e} N along it at a friction of {friction}"
                    ),
                );
            }
            for branch in &self.scene.branches {
                let b = self.of(branch);
                let radius = 0.5 * branch.diameter;
                let least =
                    b.position.iter().map(|x| (x - obstacle.position).dot(&normal)).fold(f64::INFINITY, f64::min);
                // Tolerance between contact points, and the error of drawing.
                let bend = b.d3.windows(2).map(|d| (d[1] - d[0]).norm()).fold(0.0, f64::max);
                let drawn = bend * branch.length / branch.segments as f64 / 12.0;
                if least < radius * 0.97 - drawn {
                    let depth = radius - least;
                    let name = branch.name;
                    self.say("inside a body", format!("b{name} is {depth:.3e} m inside o{k}"));
                }
            }
        }
    }

    /// The parts add up; weight and loads have the energy that the shape gives them.
    fn energies(&mut self) {
        let e = &self.end.energy;
        let parts = [e.stretch, e.shear, e.bend, e.twist, e.gravity, e.load, e.joint, e.constraint];
        let size: f64 = parts.iter().map(|x| x.abs()).sum();
        let total = e.total;
        let (sum, elastic) = (parts.iter().sum::<f64>(), [e.stretch, e.shear, e.bend, e.twist, e.joint]);
        let least = elastic.iter().copied().fold(f64::INFINITY, f64::min);
        let (mut weight, mut unsure) = (0.0, 0.0);
        for branch in &self.scene.branches {
            let b = self.of(branch);
            let g = self.gravity * branch.density;
            for i in 0..b.s.len() - 1 {
                let ds = b.s[i + 1] - b.s[i];
                weight -= 0.5 * ds * g.dot(&(b.position[i] + b.position[i + 1]));
                unsure += g.norm() * ds * b.chord(i) * (0.1 + 0.1 * (b.d3[i + 1] - b.d3[i]).norm());
            }
        }
        for joint in &self.scene.joints {
            weight -= joint.mass * self.gravity.dot(&self.position(Place::Vertex(joint.vertex)));
            unsure += joint.mass * self.gravity.norm() * self.longest_segment(joint.vertex) / 12.0;
        }
        let loads = self.scene.loads.iter().map(|l| -self.factor(l) * l.force.dot(&self.position(l.at)));
        let load: f64 = loads.sum();
        let pulls: f64 = self.scene.loads.iter().map(|l| l.force.norm()).sum();
        // What acts at a joint or a node acts beside where that is drawn.
        let chords = self.end.branches.values().flat_map(|b| (0..b.s.len() - 1).map(|i| b.chord(i)));
        let beside = chords.fold(0.0, f64::max) / 12.0;
        let (said_weight, said_load) = (e.gravity, e.load);
        if (sum - total).abs() > 1e-9 * size {
            self.say("energies", format!("the parts add up to {sum:.9e} J, total is {total:.9e} J"));
        }
        if least < -1e-12 * size {
            self.say("energies", format!("an elastic energy is {least:.3e} J"));
        }
        if (said_weight - weight).abs() > 1e-6 * size + unsure {
            self.say("energies", format!("weight has {said_weight:.6e} J, the shape says {weight:.6e} J"));
        }
        if (said_load - load).abs() > 1e-6 * size + pulls * beside {
            self.say("energies", format!("loads have {said_load:.6e} J, the shape says {load:.6e} J"));
        }
    }
}

/// Checks that energy does not rise in a step that only releases, or waits.
fn released(scene: &Scene, outcome: &Outcome, wrong: &mut Vec<Wrong>) {
    let dead_moments = scene.loads.iter().any(|l| l.moment != Vector::zeros());
    if scene.has_friction() || dead_moments {
        return;
    }
    // What strains of 1e-12 store.
    let floor: f64 = scene.branches.iter().map(|b| 1e-24 * b.ea * b.length).sum();
    for (k, pair) in outcome.steps.windows(2).enumerate() {
        let Some(step) = scene.steps.get(k + 1) else { continue };
        let quiet = step.gravity.is_none() && step.moves.is_empty() && step.loads.is_empty();
        let converged = pair.iter().all(|end| end.status == "converged");
        let [before, after] = [0, 1].map(|i| &pair[i].energy);
        let parts = [after.stretch, after.shear, after.bend, after.twist, after.gravity, after.load, after.joint];
        let size: f64 = parts.iter().map(|x| x.abs()).sum();
        // A spring that lets go takes its energy along.
        let rise = after.total - before.total;
        if quiet && converged && rise > 1e-6 * size + floor {
            let words = format!("step {}: nothing is done but letting go, and the energy rises by {rise:.3e} J", k + 1);
            wrong.push(Wrong { kind: "energy rises", words });
        }
    }
}

/// A cable between two connectors takes all turns that are asked of it: twist and writhe change by them, from step to
/// step in which nothing else is done. Looked at where the cable nowhere runs back, for there the writhe against the
/// chord (Fuller 1978) is that of the cable.
fn turns(scene: &Scene, outcome: &Outcome, wrong: &mut Vec<Wrong>) {
    for branch in scene.branches.iter().filter(|b| b.ends.iter().all(|v| scene.joint(*v).is_none())) {
        let ends = branch.ends.map(|v| {
            let holds = |f: &&Constraint| f.at == Place::Vertex(v) && f.kind == "connector" && f.from_step.is_none();
            let let_go = |f: &&Constraint| scene.steps.iter().any(|step| step.release.contains(&f.name));
            scene.constraints.iter().find(holds).filter(|f| f.free_axis.is_none() && f.rail.is_none() && !let_go(f))
        });
        let [Some(from), Some(to)] = ends else { continue };
        let name = format!("b{}", branch.name);
        for (k, pair) in outcome.steps.windows(2).enumerate() {
            let Some(step) = scene.steps.get(k + 1) else { continue };
            let plain = |m: &super::scene::Move| m.position.is_none() && m.facing == Facing::Open;
            let sliding = scene.constraints.iter().any(|f| f.slide.is_some());
            if !step.release.is_empty() || !step.moves.iter().all(plain) || sliding || pair[1].status != "converged" {
                continue;
            }
            let asked = |constraint: &Constraint| -> f64 {
                step.moves.iter().filter(|m| m.constraint == constraint.name).map(|m| m.turns).sum()
            };
            let asked = asked(to) - asked(from);
            let [Some(before), Some(after)] = [0, 1].map(|i| turned_through(&pair[i].branches[&name])) else {
                continue;
            };
            if (after - before - asked).abs() > 0.1 {
                let words =
                    format!("step {}: {asked:.3} turns were asked of {name}, and it took {:.3}", k + 1, after - before);
                wrong.push(Wrong { kind: "turns lost", words });
            }
        }
    }
}

/// Twist and writhe, in turns; `None` where the cable runs back.
fn turned_through(b: &BranchOutcome) -> Option<f64> {
    let chord = (b.position[b.position.len() - 1] - b.position[0]).try_normalize(1e-9)?;
    if b.d3.iter().any(|t| t.dot(&chord) < 0.2) {
        return None;
    }
    let area = |t: &[Vector]| {
        let (a, b) = (t[0], t[1]);
        2.0 * chord.dot(&a.cross(&b)).atan2(1.0 + chord.dot(&a) + a.dot(&b) + b.dot(&chord))
    };
    Some(b.twist_turns + b.d3.windows(2).map(area).sum::<f64>() / TAU)
}
