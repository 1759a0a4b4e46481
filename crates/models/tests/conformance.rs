//! The built-in kinds, as the registry makes them, under the conformance suites.

use nalgebra::Unit;
use wireloom_core::constitutive::{ConstitutiveLaw, ConstitutiveLaws, Past, Point, Response};
use wireloom_core::constraint::{Constraint, ConstraintSpec, HoldWord};
use wireloom_core::curve::Curve;
use wireloom_core::joint::{JointModel, JointSpec};
use wireloom_core::rod::{BranchShape, Mesh, RodSegment, RodSpec};
use wireloom_core::section::{AxialLaw, CreepElement, FrictionElement, SectionCreep, SectionFriction, SectionLaws};
use wireloom_core::sections::SectionSpan;
use wireloom_core::{Matrix, Parameters, Registry, Rotation, Section, Sections, Value, Vector};
use wireloom_testkit::conformance::rod::{is_the_same_from_its_other_end, section};
use wireloom_testkit::{
    constitutive_conformance, constraint_conformance, handed_rod_conformance, joint_conformance, potential_conformance,
    rod_conformance, rod_order_conformance,
};

fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    registry
}

fn rod(kind: &'static str) -> impl Fn(RodSpec) -> Box<dyn RodSegment> {
    let registry = registry();
    move |spec| (registry.rod(kind).unwrap().build)(&spec, &Parameters::default()).unwrap()
}

/// With its section changed.
fn with(mut spec: RodSpec, change: impl Fn(&mut Section)) -> RodSpec {
    spec.sections.iter_mut().for_each(change);
    spec
}

/// A rod of which each part between stations has a section of its own, softer where it is longer: the same from either
/// end.
fn rod_of_parts(kind: &'static str) -> impl Fn(RodSpec) -> Box<dyn RodSegment> {
    let made = rod(kind);
    move |spec| {
        let (mesh, section) = (&spec.mesh, spec.sections.of(0));
        let inner = mesh.stations.iter().copied().filter(|node| (1..mesh.segments()).contains(node));
        let ends: Vec<usize> = [0].into_iter().chain(inner).chain([mesh.segments()]).collect();
        let part = |ends: &[usize]| {
            let factor = 0.1 / (0.1 + mesh.rest_lengths[ends[0]..ends[1]].iter().sum::<f64>());
            let section = Section {
                axial_stiffness: factor * section.axial_stiffness,
                shear_stiffness: section.shear_stiffness.map(|stiffness| factor * stiffness),
                bending_stiffness: section.bending_stiffness.map(|stiffness| factor * stiffness),
                torsion_stiffness: factor * section.torsion_stiffness,
                ..section.clone()
            };
            SectionSpan { section, segments: ends[0]..ends[1] }
        };
        let sections = Sections::new(ends.windows(2).map(part).collect());
        made(RodSpec { sections, ..spec })
    }
}

/// Bending and twist of its section are coupled.
fn coupled_rod(spec: RodSpec) -> Box<dyn RodSegment> {
    rod("cosserat")(with(spec, |section| section.coupling_stiffness = [0.02, -0.01, 0.025]))
}

/// The same of branches that are run from their other end.
fn reversed_coupled_rod(spec: RodSpec) -> Box<dyn RodSegment> {
    rod("cosserat")(with(spec, |section| section.coupling_stiffness = [-0.02, 0.01, 0.025]))
}

/// Elements that slip early and late, some of them in every shape of the suite.
fn rod_with_friction(kind: &'static str) -> impl Fn(RodSpec) -> Box<dyn RodSegment> {
    let element = |stiffness: f64, moment: f64| FrictionElement { stiffness, moment };
    let bending = vec![element(0.03, 0.02), element(0.05, 0.4)];
    let friction = SectionFriction { bending, torsion: vec![element(0.02, 0.1)] };
    let made = rod(kind);
    move |spec| made(with(spec, |section| section.friction = friction.clone()))
}

/// With these laws in its section.
fn rod_with_laws(kind: &'static str, laws: SectionLaws) -> impl Fn(RodSpec) -> Box<dyn RodSegment> {
    let made = rod(kind);
    move |spec| made(with(spec, |section| section.laws = laws.clone()))
}

/// Curves with so many points that differences do not see the kinks of their slopes: a softening one of bending, whose
/// slope falls to a third, and an axial one that is stiffer by half at a strain of 2. The suite's shapes stay within.
fn curves() -> SectionLaws {
    let bending: Vec<[f64; 2]> =
        (1..=6000).map(|k| 0.02 * f64::from(k)).map(|x| [x, 2.0 * (x / 40.0).asinh()]).collect();
    let strains = (-10_000..=10_000).filter(|k| *k != 0).map(|k| 2.5e-4 * f64::from(k));
    let axial: Vec<[f64; 2]> = strains.map(|x| [x, 360.0 * (x / 3.0).sinh()]).filter(|[x, _]| *x > -1.0).collect();
    let axial = Some(AxialLaw::through(&axial, None));
    SectionLaws { bending: Some(Curve::new(&bending, None)), axial, ..SectionLaws::default() }
}

/// Elements that are slow and fast beside the duration of increments.
fn creeping() -> SectionLaws {
    let element = |stiffness: f64, time: f64| CreepElement { stiffness, time };
    let creep =
        SectionCreep { bending: vec![element(0.03, 0.2), element(0.05, 3.0)], torsion: vec![element(0.02, 1.0)] };
    SectionLaws { creep, ..SectionLaws::default() }
}

/// `W = K (√(1 + 2 q/K) − 1)` with `q = ½ eᵀ C e`: an energy that softens, of strains that are coupled by C.
struct Softening {
    c: Matrix,
    /// K, J/m.
    limit: f64,
}

impl ConstitutiveLaw for Softening {
    fn respond(&self, strains: &[Vector], _: Past<'_>, response: &mut Response<'_>) {
        response.each(strains, |_, e| {
            let force = self.c * e;
            let root = (1.0 + e.dot(&force) / self.limit).sqrt();
            Point {
                // Without cancellation near 0.
                energy: e.dot(&force) / (root + 1.0),
                gradient: force / root,
                hessian: self.c / root - force * force.transpose() / (self.limit * root.powi(3)),
            }
        });
    }
}

/// About each axis a spring c beside one that slips, of stiffness k, where its moment reaches y; z is what has slipped.
/// `V = ½ c e² + ½ k (e − z′)² + y |z′ − z|`.
struct Slipping {
    c: Vector,
    k: f64,
    y: f64,
}

impl Slipping {
    /// Moment of the spring that slips.
    fn sticks(&self, e: f64, z: f64) -> f64 {
        (self.k * (e - z)).clamp(-self.y, self.y)
    }

    fn at(&self, e: &Vector, z: &[f64]) -> Point {
        let mut point = Point::default();
        for axis in 0..3 {
            let (e, z, c) = (e[axis], z[axis], self.c[axis]);
            let moment = self.sticks(e, z);
            let slipped = e - moment / self.k - z;
            let slips = moment.abs() == self.y;
            point.energy +=
                0.5 * (c * e * e + moment * moment / self.k) + if slips { self.y * slipped.abs() } else { 0.0 };
            point.gradient[axis] = c * e + moment;
            point.hessian[(axis, axis)] = if slips { c } else { c + self.k };
        }
        point
    }
}

impl ConstitutiveLaw for Slipping {
    fn respond(&self, strains: &[Vector], past: Past<'_>, response: &mut Response<'_>) {
        response.each(strains, |k, e| self.at(e, past.of(k, 3).memory));
    }

    fn memory(&self) -> usize {
        3
    }

    fn commit(&self, strains: &[Vector], _: f64, memory: &mut [f64], dissipated: &mut [f64]) {
        for ((e, z), lost) in strains.iter().zip(memory.chunks_exact_mut(3)).zip(dissipated) {
            for axis in 0..3 {
                let moment = self.sticks(e[axis], z[axis]);
                if moment.abs() == self.y {
                    let slipped = e[axis] - moment / self.k;
                    *lost += self.y * (slipped - z[axis]).abs();
                    z[axis] = slipped;
                }
            }
        }
    }
}

fn rod_with_a_given_memory(spec: RodSpec) -> Box<dyn RodSegment> {
    let law = Slipping { c: spec.sections.of(0).bend_diagonal(), k: 0.04, y: 0.05 };
    wireloom_models::rods::constitutive::rod(spec, ConstitutiveLaws { stretch: None, bend: Some(Box::new(law)) })
}

/// Laws whose second and third components are coupled: these keep their signs where a branch is run from its other end.
/// With `linear`, those of the section.
fn given_laws(section: &Section, linear: bool) -> ConstitutiveLaws {
    let law = |c: Vector, limit: f64| -> Option<Box<dyn ConstitutiveLaw>> {
        let mut c = Matrix::from_diagonal(&c);
        if !linear {
            c.m23 = 0.4 * (c.m22 * c.m33).sqrt();
            c.m32 = c.m23;
        }
        Some(Box::new(Softening { c, limit: if linear { 1e30 } else { limit } }))
    };
    ConstitutiveLaws { stretch: law(section.stretch_diagonal(), 200.0), bend: law(section.bend_diagonal(), 150.0) }
}

fn rod_with_given_laws(spec: RodSpec) -> Box<dyn RodSegment> {
    let laws = given_laws(spec.sections.of(0), false);
    wireloom_models::rods::constitutive::rod(spec, laws)
}

/// With a law of stretch alone: it bends and twists as its section does, to fourth order.
fn rod_with_given_stretch(spec: RodSpec) -> Box<dyn RodSegment> {
    let laws = ConstitutiveLaws { bend: None, ..given_laws(spec.sections.of(0), false) };
    wireloom_models::rods::constitutive::rod(spec, laws)
}

fn rod_with_linear_given_laws(spec: RodSpec) -> Box<dyn RodSegment> {
    let laws = given_laws(spec.sections.of(0), true);
    wireloom_models::rods::constitutive::rod(spec, laws)
}

/// Bends of more than 1 1/m and twists of more than 1.5 rad/m are permanent.
fn rod_that_yields(kind: &'static str) -> impl Fn(RodSpec) -> Box<dyn RodSegment> {
    let made = rod(kind);
    let set = Some(FrictionElement { stiffness: 0.04, moment: 0.04 });
    let laws =
        SectionLaws { torsion_set: Some(FrictionElement { stiffness: 0.02, moment: 0.03 }), ..SectionLaws::default() };
    move |spec| made(with(spec, |section| (section.set, section.laws) = (set, laws.clone())))
}

fn joint(kind: &'static str) -> impl Fn(JointSpec) -> Box<dyn JointModel> {
    joint_of(kind, &[])
}

fn joint_of(kind: &'static str, values: &[(&'static str, Value)]) -> impl Fn(JointSpec) -> Box<dyn JointModel> {
    let registry = registry();
    let values = Parameters(values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect());
    move |spec| (registry.joint(kind).unwrap().build)(&spec, &values).unwrap()
}

fn hub_without_friction() -> impl Fn(JointSpec) -> Box<dyn JointModel> {
    let made = joint("compliant-hub");
    move |mut spec| {
        spec.arms.iter_mut().for_each(|arm| arm.spring.friction = SectionFriction::default());
        made(spec)
    }
}

fn constraint(
    kind: &'static str,
    spec: ConstraintSpec,
    values: &[(&'static str, Value)],
) -> impl Fn() -> Box<dyn Constraint> {
    let registry = registry();
    let values = Parameters(values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect());
    move || (registry.constraint(kind).unwrap().build)(&spec, &values).unwrap()
}

/// As where a scenario says nothing.
fn plain() -> ConstraintSpec {
    ConstraintSpec::default()
}

fn directed(up_given: bool) -> ConstraintSpec {
    ConstraintSpec { tangent_given: true, up_given, ..plain() }
}

fn on_rails(rails: &[[f64; 3]]) -> ConstraintSpec {
    ConstraintSpec { rails: rails.iter().map(|r| Vector::from(*r)).collect(), ..plain() }
}

fn hinged() -> ConstraintSpec {
    ConstraintSpec { free_axis: Some(Unit::new_normalize(Vector::new(1.0, 2.0, -1.0))), ..plain() }
}

fn holding(words: &[HoldWord]) -> ConstraintSpec {
    ConstraintSpec { hold: Some(words.to_vec()), ..plain() }
}

/// N/m and, where it turns too, N m/rad.
fn springs(angular: Option<f64>) -> Vec<(&'static str, Value)> {
    let mut values = vec![("stiffness", Value::Number(35.0))];
    values.extend(angular.map(|k| ("angular_stiffness", Value::Number(k))));
    values
}

rod_conformance!(given_laws_of_stretch_and_bending, rod_with_given_laws);
rod_conformance!(given_law_of_stretch, rod_with_given_stretch);
constitutive_conformance!(given_laws_by_themselves, rod_with_given_laws);
rod_conformance!(given_law_that_remembers, rod_with_a_given_memory);
constitutive_conformance!(given_law_that_remembers_by_itself, rod_with_a_given_memory);
rod_order_conformance!(given_laws_that_are_linear, rod_with_linear_given_laws);
rod_conformance!(cosserat_rod, rod("cosserat"));
rod_order_conformance!(cosserat_rod_order, rod("cosserat"));
rod_conformance!(kirchhoff_rod, rod("kirchhoff"));
rod_conformance!(mass_spring_chain, rod("mass-spring"));
rod_conformance!(cosserat_rod_of_parts, rod_of_parts("cosserat"));
rod_conformance!(kirchhoff_rod_of_parts, rod_of_parts("kirchhoff"));
rod_conformance!(mass_spring_chain_of_parts, rod_of_parts("mass-spring"));
handed_rod_conformance!(coupled_cosserat_rod, coupled_rod);
rod_conformance!(cosserat_rod_with_friction, rod_with_friction("cosserat"));
rod_conformance!(kirchhoff_rod_with_friction, rod_with_friction("kirchhoff"));
rod_conformance!(cosserat_rod_that_yields, rod_that_yields("cosserat"));
rod_conformance!(cosserat_rod_with_curves, rod_with_laws("cosserat", curves()));
rod_conformance!(kirchhoff_rod_with_curves, rod_with_laws("kirchhoff", curves()));
rod_conformance!(cosserat_rod_that_creeps, rod_with_laws("cosserat", creeping()));

#[test]
fn a_coupled_rod_is_the_same_from_its_other_end() {
    is_the_same_from_its_other_end(&coupled_rod, &reversed_coupled_rod);
}

/// Rods without shear have the same energy to the last bit for any shear stiffness of the section.
#[test]
fn rods_without_shear_do_not_look_at_the_shear_stiffness() {
    let mesh = Mesh::new(vec![0.1, 0.13, 0.07], vec![0, 3]);
    let points: Vec<Vector> = [0.0, 0.1, 0.22, 0.3].map(|x| Vector::new(x, 0.1 * x * x, 0.02)).to_vec();
    let turns = [0.0, 0.1, 0.25, 0.3, 0.2].map(|a| Rotation::from_euler_angles(a, 1.5 - a, 0.5 * a)).to_vec();
    let energy = |kind: &'static str, shear: f64| {
        let mut section = section();
        section.shear_stiffness = [shear; 2];
        let spec = RodSpec {
            name: "branch".into(),
            sections: section.into(),
            mesh: mesh.clone(),
            curvature: Vector::new(0.3, 0.0, 0.1),
        };
        let carry = vec![Vector::zeros(); points.len()];
        let shape = BranchShape {
            points: &points,
            compensation: &carry,
            frames: &turns,
            rest_lengths: &mesh.rest_lengths,
            coupling_lengths: &mesh.coupling_lengths,
            free_strain: 0.0,
            extra_curvature: &[],
            memory: &[],
            duration: 0.0,
        };
        rod(kind)(spec).energy(&shape).total()
    };
    for kind in ["kirchhoff", "mass-spring"] {
        assert_eq!(energy(kind, 1e3).to_bits(), energy(kind, 1e5).to_bits(), "{kind}");
    }
    assert!(energy("cosserat", 1e3) < energy("cosserat", 1e5));
}

joint_conformance!(cosserat_joint, joint("cosserat"));
joint_conformance!(long_cosserat_joint, joint_of("cosserat", &[("length", Value::Number(0.3))]));
joint_conformance!(rigid_body_joint, joint("rigid-body"));
joint_conformance!(fused_joint, joint("fused"));
joint_conformance!(compliant_hub_with_friction, joint("compliant-hub"));
joint_conformance!(compliant_hub, hub_without_friction());

constraint_conformance!(connector, constraint("connector", plain(), &[]));
constraint_conformance!(hinge, constraint("connector", hinged(), &[]));
constraint_conformance!(connector_on_a_rail, constraint("connector", on_rails(&[[0.0, 3.0, 4.0]]), &[]));
constraint_conformance!(
    connector_on_a_plane,
    constraint("connector", on_rails(&[[1.0, 1.0, 0.0], [0.0, 1.0, -2.0]]), &[])
);
constraint_conformance!(twist_alone, constraint("connector", holding(&[HoldWord::Twist]), &[]));
constraint_conformance!(collar, constraint("collar", plain(), &[]));
constraint_conformance!(collar_with_twist, constraint("collar", plain(), &[("twist", Value::Word("held".into()))]));
constraint_conformance!(handle, constraint("handle", plain(), &[]));
constraint_conformance!(handle_with_tangent, constraint("handle", directed(false), &[]));
constraint_conformance!(handle_with_frame, constraint("handle", directed(true), &[]));

potential_conformance!(springy_handle, constraint("handle", plain(), &springs(None)));
potential_conformance!(springy_handle_with_tangent, constraint("handle", directed(false), &springs(Some(0.4))));
potential_conformance!(springy_handle_with_frame, constraint("handle", directed(true), &springs(Some(0.4))));
