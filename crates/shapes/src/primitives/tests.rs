use wireloom_core::obstacle::{Shape, ShapeSpec};
use wireloom_core::{Parameters, Registry, Value, Vector};

fn registry() -> Registry {
    let mut registry = Registry::default();
    crate::register(&mut registry, None);
    registry
}

/// A primitive with these lengths, m; the rest by default.
fn made(kind: &str, lengths: &[(&str, f64)], vectors: &[(&str, [f64; 3])]) -> Box<dyn Shape> {
    let registry = registry();
    let kind = registry.shape(kind).expect("a kind");
    let mut parameters = Parameters::default();
    for parameter in &kind.parameters {
        parameters.0.extend(parameter.default.clone().map(|value| (parameter.name.clone(), value)));
    }
    parameters.0.extend(lengths.iter().map(|(name, length)| (name.to_string(), Value::Number(*length))));
    parameters.0.extend(vectors.iter().map(|(name, vector)| (name.to_string(), Value::Vector(Vector::from(*vector)))));
    (kind.build)(&ShapeSpec::default(), &parameters).expect("sound parameters")
}

fn tube() -> Box<dyn Shape> {
    made("cylinder", &[("radius", 0.2), ("bore", 0.15), ("length", 0.5)], &[])
}

wireloom_testkit::shape_conformance!(plane, || made(
    "plane",
    &[],
    &[("point", [0.1, -0.2, 0.05]), ("normal", [1.0, 2.0, -3.0])]
));
wireloom_testkit::shape_conformance!(box_, || made("box", &[], &[("size", [0.3, 0.2, 0.5])]));
wireloom_testkit::shape_conformance!(cylinder, || made("cylinder", &[("radius", 0.2), ("length", 0.5)], &[]));
wireloom_testkit::shape_conformance!(a_tube, tube);
wireloom_testkit::shape_conformance!(capsule, || made("capsule", &[("radius", 0.1), ("length", 0.4)], &[]));
wireloom_testkit::shape_conformance!(capsule_shell, || made(
    "capsule",
    &[("radius", 0.1), ("length", 0.4), ("bore", 0.06)],
    &[]
));
wireloom_testkit::shape_conformance!(sphere, || made("sphere", &[("radius", 0.25)], &[]));
wireloom_testkit::shape_conformance!(sphere_shell, || made("sphere", &[("radius", 0.25), ("bore", 0.15)], &[]));
wireloom_testkit::shape_conformance!(torus, || made("torus", &[("ring_radius", 0.3), ("radius", 0.1)], &[]));
wireloom_testkit::shape_conformance!(torus_shell, || made(
    "torus",
    &[("ring_radius", 0.3), ("radius", 0.1), ("bore", 0.06)],
    &[]
));

/// A body of triangles on the surface of a primitive has its distance, to the sagitta of its chords: r (1 − cos π/64) ≈
/// 0.0012 r.
#[test]
fn primitives_agree_with_meshes_of_their_surfaces() {
    let primitives: [(Box<dyn Shape>, f64); 7] = [
        (made("box", &[], &[("size", [0.3, 0.2, 0.5])]), 1e-12),
        (made("cylinder", &[("radius", 0.2), ("length", 0.5)], &[]), 3e-4),
        (tube(), 3e-4),
        (made("capsule", &[("radius", 0.1), ("length", 0.4)], &[]), 3e-4),
        (made("sphere", &[("radius", 0.25)], &[]), 6e-4),
        (made("sphere", &[("radius", 0.25), ("bore", 0.15)], &[]), 6e-4),
        (made("torus", &[("ring_radius", 0.3), ("radius", 0.1)], &[]), 1e-3),
    ];
    let mut rng = fastrand::Rng::with_seed(5);
    for (k, (primitive, tolerance)) in primitives.iter().enumerate() {
        let mesh = crate::mesh::Mesh::new(&primitive.surface(1.0), false).expect("a closed surface");
        for _ in 0..500 {
            let x = Vector::from_fn(|_, _| 1.2 * (rng.f64() - 0.5));
            let [exact, by_triangles] =
                [primitive.as_ref(), &mesh as &dyn Shape].map(|shape| shape.distance(&x, f64::INFINITY));
            assert!((exact - by_triangles).abs() < *tolerance, "{k}: {exact} and {by_triangles} at {x:?}");
        }
    }
}

/// Distances that can be read off a drawing.
#[test]
fn distances_are_those_of_the_drawing() {
    let cases: [(Box<dyn Shape>, [f64; 3], f64); 8] = [
        (made("box", &[], &[("size", [2.0, 2.0, 2.0])]), [4.0, 5.0, 1.0 + 12.0], 13.0),
        (made("box", &[], &[("size", [2.0, 2.0, 2.0])]), [0.0, 0.9, 0.0], -0.1),
        (made("cylinder", &[("radius", 1.0), ("length", 2.0)], &[]), [4.0, 0.0, 5.0], 5.0),
        (tube(), [0.1, 0.0, 0.0], 0.05),
        (tube(), [0.0, 0.0, 0.45], 0.25),
        (made("capsule", &[("radius", 0.5), ("length", 2.0)], &[]), [3.0, 0.0, 5.0], 4.5),
        (made("torus", &[("ring_radius", 3.0), ("radius", 1.0)], &[]), [0.0, 0.0, 4.0], 4.0),
        (made("torus", &[("ring_radius", 3.0), ("radius", 1.0), ("bore", 0.5)], &[]), [0.0, 3.25, 0.0], 0.25),
    ];
    for (k, (shape, x, expected)) in cases.iter().enumerate() {
        let found = shape.distance(&Vector::from(*x), f64::INFINITY);
        assert!((found - expected).abs() < 1e-12, "case {k}: {found}, not {expected}");
    }
}

#[test]
fn what_is_no_body_is_refused() {
    let registry = registry();
    let refused = |kind: &str, lengths: &[(&str, f64)]| {
        let values = lengths.iter().map(|(name, length)| (name.to_string(), Value::Number(*length))).collect();
        let kind = registry.shape(kind).expect("a kind");
        (kind.build)(&ShapeSpec::default(), &Parameters(values)).err().expect("it is refused").message
    };
    assert_eq!(
        refused("torus", &[("ring_radius", 0.1), ("radius", 0.2)]),
        "`radius` = 0.2 m leaves no opening in a ring with `ring_radius` = 0.1 m"
    );
    assert_eq!(
        refused("cylinder", &[("radius", 0.1), ("length", 0.2), ("bore", 0.1)]),
        "`bore` = 0.1 m leaves nothing of a body with `radius` = 0.1 m"
    );
    assert_eq!(refused("mesh", &[]), "it is a mesh, and has no `mesh`");
}
