//! The order of the energy of a rod in the segment length, at the frames and nodes of a helix.

use super::{Factory, Shape, section, spec};
use wireloom_core::rod::Mesh;
use wireloom_core::rotation::skew;
use wireloom_core::{Rotation, Vector};

/// A piece of a helix of constant strain `Γ` and curvature `κ`, `n` segments.
fn helix(mesh: &Mesh) -> Shape {
    let (k, v) = (Vector::new(0.9, -1.3, 2.0), Vector::new(0.03, -0.02, 1.05));
    let frame = |s: f64| Rotation::from_scaled_axis(k * s);
    // x(s) = ∫ exp(σ [κ]ₓ) v dσ = (s I + (1 − cos ωs)/ω² [κ]ₓ + (ωs − sin ωs)/ω³ [κ]ₓ²) v
    let point = |s: f64| {
        let w = k.norm();
        let (a, b) = ((1.0 - (w * s).cos()) / (w * w), (w * s - (w * s).sin()) / (w * w * w));
        v * s + k.cross(&v) * a + skew(&k) * k.cross(&v) * b
    };
    let s = mesh.arc_lengths();
    let mut frames = vec![Rotation::identity(); mesh.frames()];
    for (j, &c) in mesh.segment_frames.iter().enumerate() {
        frames[c] = frame(0.5 * (s[j] + s[j + 1]));
    }
    for (&node, &c) in mesh.stations.iter().zip(&mesh.station_frames) {
        frames[c] = frame(s[node]);
    }
    Shape {
        points: s.iter().map(|&s| point(s)).collect(),
        compensation: vec![Vector::zeros(); s.len()],
        frames,
        free_strain: 0.0,
        extra: vec![],
        rest_lengths: mesh.rest_lengths.clone(),
        memory: Vec::new(),
        duration: 0.0,
        coupling_lengths: mesh.coupling_lengths.clone(),
    }
}

/// The energy of [`helix`] (length 1) on `n` segments with these stations.
fn helix_energy(factory: &Factory<'_>, n: usize, stations: Vec<usize>) -> f64 {
    let mesh = Mesh::new(vec![1.0 / n as f64; n], stations);
    let rod = factory(spec(&mesh, Vector::new(0.2, 0.1, -0.3)));
    rod.energy(&helix(&mesh).view()).total()
}

/// # Panics
/// If halving the segments of a helix does not quarter the error of its energy `½ L (Γᵀ C Γ + (κ−κ°)ᵀ C (κ−κ°))`.
pub fn energy_is_second_order_in_the_segment_length(factory: &Factory<'_>) {
    let section = section();
    let (gamma, strain) = (Vector::new(0.03, -0.02, 0.05), Vector::new(0.7, -1.4, 2.3));
    let exact = 0.5 * gamma.dot(&section.stretch_diagonal().component_mul(&gamma))
        + 0.5 * strain.dot(&(section.bend_stiffness() * strain));
    let errors = [16, 32, 64].map(|n| (helix_energy(factory, n, vec![0, n]) - exact).abs());
    assert!(errors[0] < 0.02 * exact, "16 segments are off by {:e} of {exact:e}", errors[0]);
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.35 * pair[0] + 1e-9 * exact, "errors {errors:?} of {exact:e}");
    }
}

/// # Panics
/// If a station inside changes the energy of a helix by more than the square of the segment length.
pub fn a_station_inside_changes_the_energy_to_second_order(factory: &Factory<'_>) {
    let changes = [16, 32, 64]
        .map(|n| (helix_energy(factory, n, vec![0, n / 4, n]) - helix_energy(factory, n, vec![0, n])).abs());
    for pair in changes.windows(2) {
        assert!(pair[1] < 0.35 * pair[0] + 1e-9, "changes {changes:?}");
    }
}
