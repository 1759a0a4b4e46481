//! Scales of forces and moments for the residuals, branch by branch.
//!
//! A harness may join a cable of EI = 10⁶ N m² to a wire of 10⁻⁶ N m²: a force that is negligible for one is
//! the whole weight of the other. So each branch has scales of its own, with L its length and Λ the longest branch of
//! its connected component:
//!
//! ```text
//! F = max(ρ g L, EI/Λ², push),   M = max(ρ g L², EI/Λ, push Λ, moment of a load)
//! ```
//!
//! Dead forces are not included: near a limit point the load nearly cancels the elastic forces, and the small
//! difference decides.

use crate::conditions::System;
use crate::load::LoadAction;
use crate::network::{Branch, NodeRange};
use crate::rod::BranchShape;
use crate::{Matrix, Network, Rotation, Section, Tangent, Vector};

/// Number of rounding errors below which residuals are round-off: about ten terms are summed at a node.
const ROUNDINGS: f64 = 10.0;

/// Changes of the energy below this fraction of the sum of its parts are round-off.
pub(crate) const ENERGY_NOISE: f64 = 1e-14;

/// Scales of the whole harness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// N: the largest of the weights of the branches and joints, the loads, the contact forces, and EI/L²
    /// with the stiffest section and the longest branch.
    pub force: f64,
    /// N m: the force scale times the longest branch, or the largest moment of a load.
    pub moment: f64,
    /// m: the longest branch.
    pub length: f64,
}

/// Scales of a branch or a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalScale {
    /// F, N.
    pub force: f64,
    /// M, N m.
    pub moment: f64,
    /// Λ, m: the longest branch of the connected component.
    pub length: f64,
    /// Force (N) and moment (N m) below which a residual is round-off.
    pub round_off: [f64; 2],
}

/// Scales of the branches from their stiffness alone.
pub(crate) fn rigidity(network: &Network) -> Vec<LocalScale> {
    let (piece, pieces) = network.pieces();
    let mut longest = vec![0.0_f64; pieces];
    for (branch, &p) in network.branches.iter().zip(&piece) {
        longest[p] = longest[p].max(branch.rod.mesh().length());
    }
    let scale = |(branch, &p): (&Branch, &usize)| {
        let (length, bending) = (longest[p], stiffest(branch));
        let round_off = round_off(branch, bending);
        LocalScale { force: bending / (length * length), moment: bending / length, length, round_off }
    };
    let mut scales: Vec<LocalScale> = network.branches.iter().zip(&piece).map(scale).collect();
    // The springs of compliant hubs may be stiffer than any rod.
    for joint in network.joints.iter().filter(|joint| joint.frame.is_some()) {
        for pair in joint.model.law().into_iter().flat_map(|law| law.pairs) {
            for &branch in [pair.a, pair.b].iter().filter_map(|&arm| joint.branches.get(arm)) {
                let stiffness = (pair.stiffness + pair.friction.diagonal()).max();
                scales[branch].round_off[1] += ROUNDINGS * f64::EPSILON * stiffness / pair.length;
            }
        }
    }
    scales
}

/// Force (N) and moment (N m) caused by rounding errors of the strains of a rod, `ε K` and `ε (K ℓ + C/λ)` with K
/// = ℓ ∂²E/∂e², times [`ROUNDINGS`]; where an axial law is stiffer than at rest, with that.
fn round_off(branch: &Branch, bending: f64) -> [f64; 2] {
    let rod = &*branch.rod;
    let mesh = rod.mesh();
    let s = mesh.arc_lengths();
    let points: Vec<Vector> = s.iter().map(|s| Vector::z() * *s).collect();
    let shape = BranchShape {
        compensation: &vec![Vector::zeros(); points.len()],
        points: &points,
        frames: &vec![Rotation::identity(); mesh.frames()],
        rest_lengths: &mesh.rest_lengths,
        coupling_lengths: &mesh.coupling_lengths,
        free_strain: 0.0,
        extra_curvature: &[],
        memory: &rod.memory(),
        duration: 0.0,
    };
    let mut stiffness = vec![Matrix::zeros(); mesh.segments()];
    rod.edge_stiffness(&shape, &mut stiffness);
    let stretch = |(k, l): (&Matrix, &f64)| k.diagonal().amax() * l;
    let of_laws = branch.sections.iter().filter(|section| section.laws.axial.is_some());
    let of_law = of_laws.map(Section::greatest_axial_stiffness).fold(0.0, f64::max);
    let stretch = stiffness.iter().zip(&mesh.rest_lengths).map(stretch).fold(of_law, f64::max);
    let longest = mesh.rest_lengths.iter().copied().fold(0.0, f64::max);
    let shortest = mesh.coupling_lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let force = ROUNDINGS * f64::EPSILON * stretch;
    [force, force * longest + ROUNDINGS * f64::EPSILON * bending / shortest]
}

/// The greatest bending or torsion stiffness of a branch, N m².
fn stiffest(branch: &Branch) -> f64 {
    branch.sections.iter().map(|section| section.sticking_diagonal().max()).fold(0.0, f64::max)
}

/// The greatest mass per length of a branch, kg/m.
fn densest(branch: &Branch) -> f64 {
    branch.sections.iter().map(|section| section.linear_density).fold(0.0, f64::max)
}

/// Scales of the branches and joints under conditions.
#[derive(Default)]
pub struct LocalScales {
    pub(crate) branches: Vec<LocalScale>,
    pub(crate) joints: Vec<LocalScale>,
}

impl LocalScales {
    /// Updates the scales; allocates the first time only. `pushes` gives contact forces by branch, N, `moments` those
    /// of loads by frame, N m.
    pub(crate) fn find(
        &mut self,
        network: &Network,
        rigidity: &[LocalScale],
        gravity: f64,
        pushes: impl Iterator<Item = (usize, f64)>,
        moments: impl Iterator<Item = (usize, f64)>,
    ) {
        self.branches.clear();
        self.branches.extend_from_slice(rigidity);
        for (scale, branch) in self.branches.iter_mut().zip(&network.branches) {
            let length = branch.rod.mesh().length();
            let weight = gravity * densest(branch) * length;
            scale.force = scale.force.max(weight);
            scale.moment = scale.moment.max(weight * length);
        }
        for (b, push) in pushes {
            let scale = &mut self.branches[b];
            scale.force = scale.force.max(push);
            scale.moment = scale.moment.max(push * scale.length);
        }
        for (frame, moment) in moments {
            let on_branch = network.branches.iter().position(|branch| branch.frames.contains(&frame));
            let at_joint = network.joints.iter().filter(|joint| joint.frame == Some(frame));
            for b in on_branch.into_iter().chain(at_joint.flat_map(|joint| joint.branches.iter().copied())) {
                self.branches[b].moment = self.branches[b].moment.max(moment);
            }
        }
        self.joints.clear();
        // The scale of a joint is that of its softest arm; the rounding errors of all arms add up.
        self.joints.extend(network.joints.iter().map(|joint| {
            let arms = || joint.branches.iter().map(|&b| &self.branches[b]);
            let least = |value: fn(&LocalScale) -> f64| arms().map(value).fold(f64::INFINITY, f64::min);
            let force: f64 = arms().map(|arm| arm.round_off[0]).sum();
            let levers: f64 = joint.arms.iter().zip(arms()).map(|(a, arm)| a.offset.norm() * arm.round_off[0]).sum();
            let moment: f64 = arms().map(|arm| arm.round_off[1]).sum();
            LocalScale {
                force: least(|arm| arm.force),
                moment: least(|arm| arm.moment),
                length: joint.branches.first().map_or(0.0, |&b| rigidity[b].length),
                round_off: [force, moment + levers],
            }
        }));
    }
}

impl Scales {
    /// Scales of the whole harness.
    pub fn of(system: System<'_>) -> Self {
        let System { network, conditions } = system;
        let g = conditions.gravity.norm();
        let (mut force, mut length, mut stiffness, mut moment) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
        for branch in &network.branches {
            let l = branch.rod.mesh().length();
            force = force.max(g * densest(branch) * l);
            length = length.max(l);
            stiffness = stiffness.max(stiffest(branch));
        }
        for joint in &network.joints {
            force = force.max(g * joint.mass);
        }
        for (load, factor) in network.loads.iter().zip(&conditions.load_factors) {
            match &load.action {
                LoadAction::At { load, .. } => {
                    let [own, turning] = load.largest();
                    force = force.max(own * factor.abs());
                    moment = moment.max(turning * factor.abs());
                }
                LoadAction::Along { spans, load } => {
                    let of = |span: &NodeRange| {
                        let branch = &network.branches[span.branch];
                        let lengths = &branch.rod.mesh().rest_lengths[span.nodes.start..span.nodes.end - 1];
                        load.largest(branch.sections.diameter()) * lengths.iter().sum::<f64>()
                    };
                    force = spans.iter().map(|span| of(span) * factor.abs()).fold(force, f64::max);
                }
            }
        }
        force = force.max(stiffness / (length * length));
        force = conditions.contact.records.iter().map(|record| record.multiplier).fold(force, f64::max);
        Scales { force, moment: moment.max(force * length), length }
    }
}

impl LocalScales {
    /// Least force and moment scales of all branches and joints, and the longest branch: for methods that use a single
    /// scale.
    pub fn least(&self) -> Scales {
        let all = || self.branches.iter().chain(&self.joints);
        let least = |value: fn(&LocalScale) -> f64| all().map(value).fold(f64::INFINITY, f64::min);
        let length = self.branches.iter().map(|scale| scale.length).fold(0.0, f64::max);
        Scales { force: least(|scale| scale.force), moment: least(|scale| scale.moment), length }
    }

    /// Largest free force relative to the force scale of its branch, or moment relative to its moment scale, of the
    /// part above round-off; NaN if any entry is.
    pub fn residual(&self, network: &Network, free: &Tangent) -> f64 {
        self.largest(network, free, |value, scale, round_off| (value - round_off).max(0.0) / scale)
    }

    /// [`Self::residual`] including round-off.
    pub fn whole_residual(&self, network: &Network, free: &Tangent) -> f64 {
        self.largest(network, free, |value, scale, _| value / scale)
    }

    fn largest(&self, network: &Network, free: &Tangent, relative: impl Fn(f64, f64, f64) -> f64) -> f64 {
        let relative = |value: f64, scale: f64, round_off: f64| {
            // `max` would drop it.
            if value.is_nan() { value } else { relative(value, scale, round_off) }
        };
        let of = |scale: &LocalScale, points: &[Vector], frames: &[Vector]| {
            let norm = |all: &[Vector]| all.iter().map(Vector::norm_squared).fold(0.0, nan_max).sqrt();
            let [force, moment] = scale.round_off;
            nan_max(relative(norm(points), scale.force, force), relative(norm(frames), scale.moment, moment))
        };
        let mut worst = 0.0;
        for (branch, scale) in network.branches.iter().zip(&self.branches) {
            worst = nan_max(worst, of(scale, &free.points[branch.points.clone()], &free.frames[branch.frames.clone()]));
        }
        for (joint, scale) in network.joints.iter().zip(&self.joints) {
            let frames = joint.frame.map_or(0..0, |c| c..c + 1);
            worst = nan_max(worst, of(scale, &free.points[joint.point..][..1], &free.frames[frames]));
        }
        for (site, g) in network.slides.iter().zip(&free.slides) {
            let scale = &self.branches[site.branch];
            worst = nan_max(worst, relative(g.abs(), scale.force, scale.round_off[0]));
        }
        worst
    }
}

/// Maximum that keeps NaN.
pub fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}
