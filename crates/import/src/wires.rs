//! What the readers of all formats do with wires.

use super::document::{Segment, Wire};
use super::findings::Findings;
use std::f64::consts::PI;

/// kg/m³.
const COPPER: f64 = 8960.0;

/// Reports what the part of a wire, `part`, cannot weigh, and what it does not give; `core`: its mass is a share in
/// that of its cable, with jacket and filler.
pub(super) fn checked(mut wire: Wire, part: &str, core: bool, findings: &mut Findings) -> Wire {
    let whole = wire.outside_diameter.filter(|_| !core);
    let solid = whole.map(|diameter| COPPER * 0.25 * PI * diameter.powi(2));
    if let Some((density, solid)) = wire.linear_density.zip(solid).filter(|(density, solid)| density > solid) {
        findings.add(format!(
            "{part}: its mass is {:.1} g/m, and solid copper of its outside diameter would have {:.1} g/m; left out",
            1e3 * density,
            1e3 * solid
        ));
        wire.linear_density = None;
    }
    let values = [
        ("copper area", wire.copper_area),
        ("outside diameter", wire.outside_diameter),
        ("mass per length", wire.linear_density),
        ("bend radius", wire.bend_radius),
    ];
    let lacking: Vec<&str> = values.iter().filter(|(_, value)| value.is_none()).map(|(name, _)| *name).collect();
    if !lacking.is_empty() {
        findings.add_to(format!("wires without usable {}; estimated", lacking.join(", ")), part);
    }
    wire
}

/// Runs wires of one id through segments, all by index; each counts once in a segment.
pub(super) fn run(segments: &mut [Segment], run: &[usize], wires: &[usize], id: &str, findings: &mut Findings) {
    let meet = |a: usize, b: usize| segments[a].ends.iter().any(|end| segments[b].ends.contains(end));
    if run.windows(2).any(|pair| !meet(pair[0], pair[1])) {
        findings.add_to("wires run through segments that do not follow on one another; counted where they are", id);
    }
    for &segment in run {
        for &wire in wires {
            if !segments[segment].wires.contains(&wire) {
                segments[segment].wires.push(wire);
            }
        }
    }
}
