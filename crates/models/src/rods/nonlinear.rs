//! Rods that are not linear: a linear rod on the staggered grid and, in every coupling and every segment, other laws:
//! those of its section ([`crate::coupling_law`], [`AxialLaw`]), or such as are given ([`ConstitutiveLaws`]).

use crate::coupling_law::{Bent, CouplingLaw};
use crate::kernel::BendTwist;
use crate::rods::staggered::StaggeredRod;
use crate::rods::stretched::{self, Stretched};
use std::cell::RefCell;
use wireloom_core::constitutive::{ConstitutiveLaw, ConstitutiveLaws, Derivatives, Past, Point, Response};
use wireloom_core::law::RodLaw;
use wireloom_core::rod::{BranchHessian, BranchShape, Mesh, RodEnergy, RodSegment, RodSpec};
use wireloom_core::section::AxialLaw;
use wireloom_core::terms::slope::Contradiction;
use wireloom_core::{BuildError, Matrix, Rotation, Section, Vector};

/// One branch that is not linear.
pub struct NonlinearRod {
    linear: StaggeredRod,
    /// Of its section; `None`: bending and torsion are linear, or given.
    couplings: Option<CouplingLaw>,
    /// Of its section; `None`: stretch is linear, or given.
    axial: Option<AxialLaw>,
    given: ConstitutiveLaws,
}

/// A rod of the stiffness that is linear and lasts ([`wireloom_core::Section::lasting_diagonal`],
/// [`wireloom_core::Section::linear_stretch_diagonal`]), and beside it the other laws of its section.
///
/// # Errors
/// If such a section is one of several along the branch, or couples bending and twist.
pub fn with_laws(spec: &RodSpec, linear: StaggeredRod) -> Result<Box<dyn RodSegment>, BuildError> {
    let nonlinear = |section: &&Section| !section.bends_linearly() || section.laws.axial.is_some();
    let Some(section) = spec.sections.iter().find(nonlinear) else { return Ok(Box::new(linear)) };
    if section.couples() {
        let has = section.nonlinear_keys().join(", ");
        let message = format!("its section \"{}\" has a `coupling_stiffness` beside {has}", section.name);
        return Err(BuildError::new(message, "only linear sections couple bending and twist").at("section"));
    }
    if spec.sections.only().is_none() {
        let has = section.nonlinear_keys().join(", ");
        let message = format!("its section changes along it, and \"{}\" has {has}", section.name);
        let help = "divide the branch at the change, with a joint of the model \"fused\" there";
        return Err(BuildError::new(message, help).at("sections"));
    }
    let couplings = (!section.bends_linearly()).then(|| CouplingLaw::of(section));
    let axial = section.laws.axial.clone();
    Ok(Box::new(NonlinearRod { linear, couplings, axial, given: ConstitutiveLaws::default() }))
}

/// A rod with these laws, and beside it what is linear.
pub fn with_given(linear: StaggeredRod, given: ConstitutiveLaws) -> Box<dyn RodSegment> {
    Box::new(NonlinearRod { linear, couplings: None, axial: None, given })
}

/// What is asked of given laws.
#[derive(Clone, Copy)]
struct Asked {
    energy: bool,
    gradient: bool,
    hessian: bool,
}

const NOTHING: Asked = Asked { energy: false, gradient: false, hessian: false };
const ENERGY: Asked = Asked { energy: true, ..NOTHING };
const GRADIENT: Asked = Asked { gradient: true, ..NOTHING };
const HESSIAN: Asked = Asked { hessian: true, ..NOTHING };
const ENERGY_AND_GRADIENT: Asked = Asked { energy: true, ..GRADIENT };
const DERIVATIVES: Asked = Asked { hessian: true, ..GRADIENT };
const ALL: Asked = Asked { energy: true, gradient: true, hessian: true };

/// Strains of a branch, and what a given law says of them.
#[derive(Default)]
struct Block {
    strains: Vec<Vector>,
    energy: Vec<f64>,
    gradient: Vec<Vector>,
    hessian: Vec<Matrix>,
}

impl Block {
    /// Asks a law about the strains.
    fn ask(&mut self, law: &dyn ConstitutiveLaw, past: Past<'_>, asked: Asked) {
        let n = self.strains.len();
        fn room<T: Clone>(all: &mut Vec<T>, count: usize, unwritten: T) -> Option<&mut [T]> {
            all.clear();
            all.resize(count, unwritten);
            (count > 0).then_some(all)
        }
        let count = |asked: bool| if asked { n } else { 0 };
        let mut response = Response {
            energy: room(&mut self.energy, count(asked.energy), f64::NAN),
            gradient: room(&mut self.gradient, count(asked.gradient), Vector::repeat(f64::NAN)),
            hessian: room(&mut self.hessian, count(asked.hessian), Matrix::repeat(f64::NAN)),
        };
        law.respond(&self.strains, past, &mut response);
    }

    /// What it says of a strain; what it was not asked for is no number.
    fn at(&self, k: usize) -> Point {
        Point {
            energy: self.energy.get(k).copied().unwrap_or(f64::NAN),
            gradient: self.gradient.get(k).copied().unwrap_or(Vector::repeat(f64::NAN)),
            hessian: self.hessian.get(k).copied().unwrap_or(Matrix::repeat(f64::NAN)),
        }
    }
}

thread_local! {
    /// Blocks that no call uses now.
    static BLOCKS: RefCell<Vec<Block>> = const { RefCell::new(Vec::new()) };
}

/// A block of this thread, given back in the end; `None`: no law is given.
struct Lent(Option<Block>);

impl Lent {
    /// The answers of a law, if one is given, about the strains that `measure` writes.
    fn answers(
        law: &Option<Box<dyn ConstitutiveLaw>>,
        past: Past<'_>,
        asked: Asked,
        count: usize,
        measure: impl FnOnce(&mut [Vector]),
    ) -> Self {
        Self(law.as_ref().map(|law| {
            let mut block = BLOCKS.with_borrow_mut(Vec::pop).unwrap_or_default();
            block.strains.clear();
            block.strains.resize(count, Vector::zeros());
            measure(&mut block.strains);
            block.ask(law.as_ref(), past, asked);
            block
        }))
    }

    fn strains(&self) -> &[Vector] {
        self.0.as_ref().map_or(&[], |block| &block.strains)
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        if let Some(block) = self.0.take() {
            BLOCKS.with_borrow_mut(|blocks| blocks.push(block));
        }
    }
}

/// What a law of a coupling says.
enum Coupled<'s> {
    /// That of a section.
    Section(Bent<'s>),
    /// A given one.
    Given(Point),
}

impl Coupled<'_> {
    /// (bending, twist) energy per length, J/m; that of a given law is counted as bending.
    fn energy(&self) -> (f64, f64) {
        match self {
            Self::Section(bent) => bent.energy(),
            Self::Given(point) => (point.energy, 0.0),
        }
    }

    /// Moment, N m.
    fn moment(&self) -> Vector {
        match self {
            Self::Section(bent) => bent.moment(),
            Self::Given(point) => point.gradient,
        }
    }

    /// Its derivative in the curvature, N m².
    fn tangent(&self) -> Matrix {
        match self {
            Self::Section(bent) => bent.tangent(),
            Self::Given(point) => point.hessian,
        }
    }
}

/// The past of the couplings of a branch.
fn past<'s>(shape: &BranchShape<'s>) -> Past<'s> {
    Past { memory: shape.memory, duration: shape.duration }
}

impl NonlinearRod {
    /// Number of state variables of a coupling.
    fn width(&self) -> usize {
        self.couplings.as_ref().map_or_else(|| self.given.memory(), CouplingLaw::width)
    }

    /// What a given law of bending says in this shape.
    fn ask_couplings(&self, shape: &BranchShape<'_>, asked: Asked) -> Lent {
        Lent::answers(&self.given.bend, past(shape), asked, shape.coupling_lengths.len(), |strains| {
            strains.iter_mut().enumerate().for_each(|(c, strain)| *strain = self.linear.coupling(shape, c).strain);
        })
    }

    /// What a given law of stretch says in this shape.
    fn ask_segments(&self, shape: &BranchShape<'_>, asked: Asked) -> Lent {
        Lent::answers(&self.given.stretch, Past::default(), asked, shape.rest_lengths.len(), |strains| {
            stretched::strains(&self.linear, shape, strains);
        })
    }

    /// The couplings with their laws and those of the linear rod, if they are not linear.
    fn couplings<'s>(
        &'s self,
        shape: &'s BranchShape<'_>,
        given: &'s Lent,
    ) -> impl Iterator<Item = (usize, f64, BendTwist, Coupled<'s>)> + 's {
        let lengths = || shape.coupling_lengths.iter().copied().enumerate();
        let of_section = self.couplings.iter().flat_map(move |law| {
            let width = law.width();
            lengths().map(move |(c, lambda)| {
                let coupling = self.linear.coupling(shape, c);
                let bent = law.at(coupling.strain, &shape.memory[c * width..(c + 1) * width], shape.duration);
                (c, lambda, coupling, Coupled::Section(bent))
            })
        });
        let given = given.0.iter().flat_map(move |block| {
            lengths().map(move |(c, lambda)| (c, lambda, self.linear.coupling(shape, c), Coupled::Given(block.at(c))))
        });
        of_section.chain(given)
    }

    /// The segments with their lengths and laws, if they are not linear.
    fn stretched<'s>(
        &'s self,
        shape: &'s BranchShape<'_>,
        given: &'s Lent,
    ) -> impl Iterator<Item = (f64, Stretched<'s>)> + 's {
        let of_section = self.axial.iter().flat_map(move |law| {
            stretched::all(&self.linear, shape, move |_, strain| Point {
                energy: law.energy(strain.z),
                gradient: Vector::z() * law.force(strain.z),
                hessian: Matrix::from_diagonal(&(Vector::z() * law.stiffness(strain.z))),
            })
        });
        let given = given
            .0
            .iter()
            .flat_map(move |block| stretched::all(&self.linear, shape, move |segment, _| block.at(segment)));
        of_section.chain(given).map(|own| (shape.rest_lengths[own.segment], own))
    }

    fn segment_frame(&self, segment: usize) -> usize {
        self.linear.mesh().segment_frames[segment]
    }
}

impl RodSegment for NonlinearRod {
    fn mesh(&self) -> &Mesh {
        self.linear.mesh()
    }

    fn couples_pairs(&self) -> bool {
        self.linear.couples_pairs()
    }

    fn energy(&self, shape: &BranchShape<'_>) -> RodEnergy {
        let of_stretch = self.ask_segments(shape, ENERGY);
        let of_bending = self.ask_couplings(shape, ENERGY);
        let mut energy = self.linear.energy(shape);
        for (l, own) in self.stretched(shape, &of_stretch) {
            energy.stretch += own.energy(l);
        }
        for (_, lambda, _, bent) in self.couplings(shape, &of_bending) {
            let (bend, twist) = bent.energy();
            energy.bend += lambda * bend;
            energy.twist += lambda * twist;
        }
        energy
    }

    fn coupling_gradient(&self, shape: &BranchShape<'_>, frames: &mut [Vector]) -> f64 {
        let of_bending = self.ask_couplings(shape, ENERGY_AND_GRADIENT);
        let mut energy = self.linear.coupling_gradient(shape, frames);
        for (c, lambda, coupling, bent) in self.couplings(shape, &of_bending) {
            let (bend, twist) = bent.energy();
            energy += lambda * (bend + twist);
            let (a, b) = coupling.with_moment(bent.moment()).gradient();
            frames[c] += a;
            frames[c + 1] += b;
        }
        energy
    }

    fn segment_gradient(&self, shape: &BranchShape<'_>, points: &mut [Vector], frames: &mut [Vector]) -> f64 {
        let of_stretch = self.ask_segments(shape, ENERGY_AND_GRADIENT);
        let mut energy = self.linear.segment_gradient(shape, points, frames);
        for (l, own) in self.stretched(shape, &of_stretch) {
            energy += own.energy(l);
            own.add_gradient([l, 1.0], self.segment_frame(own.segment), points, frames);
        }
        energy
    }

    /// Where forces are given, the linear rod has them in its geometric part, those of the axial law among them.
    fn hessian(&self, shape: &BranchShape<'_>, forces: Option<&[Vector]>, hessian: &mut BranchHessian) {
        let of_stretch = self.ask_segments(shape, DERIVATIVES);
        let of_bending = self.ask_couplings(shape, DERIVATIVES);
        self.linear.hessian(shape, forces, hessian);
        for (l, own) in self.stretched(shape, &of_stretch) {
            own.add_hessian(l, forces.is_none(), hessian);
        }
        for (c, _, coupling, bent) in self.couplings(shape, &of_bending) {
            let own = coupling.with_moment(bent.moment()).hessian_with(&bent.tangent());
            let all = &mut hessian.couplings[c];
            all.aa += own.aa;
            all.ab += own.ab;
            all.bb += own.bb;
        }
    }

    fn edge_stiffness(&self, shape: &BranchShape<'_>, stiffness: &mut [Matrix]) {
        let of_stretch = self.ask_segments(shape, HESSIAN);
        self.linear.edge_stiffness(shape, stiffness);
        for (l, own) in self.stretched(shape, &of_stretch) {
            stiffness[own.segment] += own.edge_stiffness(l);
        }
    }

    fn predicted_forces(&self, shape: &BranchShape<'_>, points: &[Vector], frames: &[Vector], forces: &mut [Vector]) {
        let of_stretch = self.ask_segments(shape, DERIVATIVES);
        self.linear.predicted_forces(shape, points, frames, forces);
        for (l, own) in self.stretched(shape, &of_stretch) {
            let j = own.segment;
            let theta = &frames[self.segment_frame(j)];
            forces[j] += own.predicted_force(l, &(points[j + 1] - points[j]), theta, frames);
        }
    }

    fn forces(&self, shape: &BranchShape<'_>, forces: &mut [Vector]) {
        let of_stretch = self.ask_segments(shape, GRADIENT);
        self.linear.forces(shape, forces);
        for (_, own) in self.stretched(shape, &of_stretch) {
            forces[own.segment] += own.world_force();
        }
    }

    fn moments(&self, shape: &BranchShape<'_>, moments: &mut [Vector]) {
        let of_stretch = self.ask_segments(shape, GRADIENT);
        let of_bending = self.ask_couplings(shape, GRADIENT);
        self.linear.moments(shape, moments);
        for (l, own) in self.stretched(shape, &of_stretch) {
            let Some(([first, second], at)) = own.at_neighbours(l) else { continue };
            if let Some(c) = first {
                moments[c] -= shape.frames[c] * at[0];
            }
            if let Some(c) = second {
                moments[c - 1] += shape.frames[c] * at[1];
            }
        }
        for (c, _, coupling, bent) in self.couplings(shape, &of_bending) {
            moments[c] += shape.frames[c + 1] * coupling.with_moment(bent.moment()).gradient().1;
        }
    }

    /// The part of couplings: with `κ` as 1/λ and the memory fixed, `∂(λ h)/∂λ = h − κ·m` and `κᵀ ∂²h κ/λ`.
    fn length_terms(&self, shape: &BranchShape<'_>, segments: &mut [[f64; 2]], couplings: &mut [[f64; 3]]) {
        let of_stretch = self.ask_segments(shape, ALL);
        let of_bending = self.ask_couplings(shape, ALL);
        self.linear.length_terms(shape, segments, couplings);
        for (l, own) in self.stretched(shape, &of_stretch) {
            let [first, second] = own.length_terms(l);
            segments[own.segment][0] += first;
            segments[own.segment][1] += second;
        }
        for (c, lambda, coupling, bent) in self.couplings(shape, &of_bending) {
            let (kappa, (bend, twist)) = (coupling.curvature(), bent.energy());
            couplings[c][0] += bend + twist - kappa.dot(&bent.moment());
            couplings[c][1] += kappa.dot(&(bent.tangent() * kappa)) / lambda;
        }
    }

    /// The part of couplings: with `∂m/∂λ = −∂²h κ/λ` in place of the moment.
    fn length_mixed(
        &self,
        shape: &BranchShape<'_>,
        segment_rates: &[f64],
        coupling_rates: &[f64],
        points: &mut [Vector],
        frames: &mut [Vector],
    ) {
        let of_stretch = self.ask_segments(shape, HESSIAN);
        let of_bending = self.ask_couplings(shape, HESSIAN);
        self.linear.length_mixed(shape, segment_rates, coupling_rates, points, frames);
        for (l, own) in self.stretched(shape, &of_stretch).filter(|(_, own)| segment_rates[own.segment] != 0.0) {
            let (rate, frame) = (segment_rates[own.segment], self.segment_frame(own.segment));
            own.per_length(l).add_gradient([l, rate], frame, points, frames);
        }
        for (c, lambda, coupling, bent) in
            self.couplings(shape, &of_bending).filter(|(c, ..)| coupling_rates[*c] != 0.0)
        {
            let change = bent.tangent() * coupling.curvature() / -lambda;
            let (a, b) = coupling.with_moment(change).gradient();
            frames[c] += a * coupling_rates[c];
            frames[c + 1] += b * coupling_rates[c];
        }
    }

    fn rest_rotation(&self, coupling: usize) -> Rotation {
        self.linear.rest_rotation(coupling)
    }

    /// That of a section; given laws are no coefficients.
    fn law(&self) -> Option<RodLaw> {
        if self.constitutive().is_some() {
            return None;
        }
        let mut law = self.linear.law()?;
        if let Some(CouplingLaw { curve, friction, creep }) = &self.couplings {
            law.friction = friction.clone();
            law.laws.bending = curve.clone();
            law.laws.creep = creep.clone();
        }
        law.laws.axial = self.axial.clone();
        Some(law)
    }

    fn linear_law(&self) -> Option<RodLaw> {
        if self.constitutive().is_none() {
            return self.law();
        }
        let mut law = self.linear.law()?;
        let unused = vec![0.0; self.width()];
        let at_rest = |given: &Option<Box<dyn ConstitutiveLaw>>, memory| {
            let past = Past { memory, duration: 0.0 };
            given.as_ref().map(|given| given.at(&Vector::zeros(), past).hessian.diagonal())
        };
        if let Some(stiffness) = at_rest(&self.given.stretch, &[]) {
            law.segments.iter_mut().for_each(|own| own.stiffness = stiffness);
        }
        if let Some(stiffness) = at_rest(&self.given.bend, &unused) {
            law.couplings.fill(stiffness);
        }
        Some(law)
    }

    fn constitutive(&self) -> Option<&ConstitutiveLaws> {
        let ConstitutiveLaws { stretch, bend } = &self.given;
        (stretch.is_some() || bend.is_some()).then_some(&self.given)
    }

    fn contradiction(&self, shape: &BranchShape<'_>) -> Option<(Derivatives, Contradiction)> {
        let (segments, couplings) = (self.ask_segments(shape, NOTHING), self.ask_couplings(shape, NOTHING));
        self.given.contradiction([segments.strains(), couplings.strains()], past(shape))
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0; self.mesh().coupling_lengths.len() * self.width()]
    }

    fn commit(&self, shape: &BranchShape<'_>, memory: &mut [f64]) -> f64 {
        if let Some(law) = &self.given.bend {
            let couplings = self.ask_couplings(shape, NOTHING);
            let mut dissipated = vec![0.0; couplings.strains().len()];
            law.commit(couplings.strains(), shape.duration, memory, &mut dissipated);
            return shape.coupling_lengths.iter().zip(dissipated).map(|(lambda, lost)| lambda * lost).sum();
        }
        let Some(law) = self.couplings.as_ref().filter(|law| law.width() > 0) else { return 0.0 };
        let rooms = memory.chunks_exact_mut(law.width());
        let dissipated =
            |((_, lambda, _, coupled), own): ((usize, f64, BendTwist, Coupled<'_>), &mut [f64])| match coupled {
                Coupled::Section(bent) => lambda * bent.commit(law, own),
                Coupled::Given(_) => 0.0,
            };
        self.couplings(shape, &Lent(None)).zip(rooms).map(dissipated).sum()
    }

    fn curvature_under(&self, moment: &Vector, memory: &[f64], duration: f64) -> Option<Vector> {
        let [rest, stiffness] = self.linear.bending_law();
        if let Some(law) = &self.given.bend {
            return Some(rest + law.strain_under(moment, Past { memory, duration }));
        }
        self.couplings.as_ref().map(|law| rest + law.strain_under(&stiffness, moment, memory, duration))
    }
}
