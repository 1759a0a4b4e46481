//! Centre line, length, wires and coverings of every segment.

use super::curve::{Curve, Fit, NODE_TOLERANCE};
use super::document::{Document, Segment, Wire};
use super::findings::Findings;
use super::section::{Makeup, Types, WHOLE};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use wireloom_scenario::bundle::{Bundle, PACKING};

/// A segment with its centre line and its make-up.
pub(super) struct Laid {
    pub curve: Curve,
    /// How the curves of the file agree with the nodes.
    pub fit: Fit,
    pub length: f64,
    pub makeup: Makeup,
    pub bundle: Bundle,
}

/// An arm of a vertex: a segment, and whether it starts there.
#[derive(Clone, Copy)]
pub(super) struct Incidence {
    pub segment: usize,
    pub starts: bool,
}

/// Centre line, length and make-up of every segment; `wires` are the types of the document's wires.
pub(super) fn lay_all(document: &Document, types: &mut Types, wires: &[usize], findings: &mut Findings) -> Vec<Laid> {
    let (mut arcs, mut lengths) = (0.0, 0.0);
    let laid = document
        .segments
        .iter()
        .map(|segment| {
            let [from, to] = segment.ends.map(|end| document.nodes[end].position);
            let stated = segment.physical_length.or(segment.virtual_length);
            let drawn = segment.virtual_length.or(segment.physical_length);
            let (curve, fit) = Curve::lay(&segment.curves, from, to, drawn);
            note_fit(segment, &curve, &fit, findings);
            if fit == Fit::Absent && document.drawn {
                findings.add_to("segments without usable centre curve; straight from node to node", &segment.id);
            }
            let length = stated.unwrap_or_else(|| {
                let [built, drawn] = document.format.lengths();
                findings.add_to(
                    format!("no usable {drawn} or {built}; the length of the drawn line is taken"),
                    &segment.id,
                );
                // Nodes at one point and no curve: the length must be above zero.
                curve.length.max(NODE_TOLERANCE)
            });
            note_length(document, segment, (to - from).norm(), length, &curve, &fit, findings);
            if matches!(fit, Fit::Meets { .. } | Fit::Cut { .. }) && stated.is_some() {
                arcs += curve.length;
                lengths += length;
            }
            let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
            if segment.wires.is_empty() {
                findings.add_to(
                    "no wires are routed through segments; wires of 0.5 mm² that fill the drawn area are taken",
                    &segment.id,
                );
                let (kind, count) = stand_in(segment.area, types, findings);
                counts.insert(kind, count);
            }
            for &wire in &segment.wires {
                *counts.entry(wires[wire]).or_default() += 1;
            }
            let wires = counts.into_iter().collect();
            let moving = segment.wires.iter().filter_map(|&wire| document.wires[wire].moving_bend_radius);
            let moving = moving.chain(segment.moving_bend_radius).max_by(f64::total_cmp);
            let makeup = Makeup {
                wires,
                coverings: coverings(segment, length, types, findings),
                bend_radius: segment.bend_radius.map(Makeup::micrometres),
                moving_bend_radius: moving.map(Makeup::micrometres),
            };
            let bundle = types.bundle(&makeup);
            for (kind, _) in &makeup.coverings {
                let tube = &types.coverings[*kind];
                if tube.of_rule.inner_diameter.is_some_and(|inner| inner < bundle.wires_diameter) {
                    findings.add_to(
                        "tubes are narrower inside than all wires together that run through them; taken as wide as \
                         these",
                        format!("{} `{}` ({:.1} mm of wires)", segment.id, tube.name, bundle.wires_diameter * 1e3),
                    );
                }
            }
            let circle = |&(kind, count): &(usize, usize)| {
                count as f64 * 0.25 * PI * types.wires[kind].of_rule.diameter().powi(2)
            };
            let copper_and_insulation: f64 = makeup.wires.iter().map(circle).sum();
            if !segment.wires.is_empty() && segment.area.is_some_and(|area| area < copper_and_insulation) {
                findings.add_to(
                    "cross-sections are drawn smaller than their wires together; diameters are taken from the wires \
                     everywhere",
                    &segment.id,
                );
            }
            Laid { curve, fit, length, makeup, bundle }
        })
        .collect();
    if lengths > 0.0 && !(0.5..2.0).contains(&(arcs / lengths)) {
        findings.add(format!(
            "drawn curves are {:.3} times as long as the stated lengths: coordinates are read as millimetres, \
             which this file may not mean",
            arcs / lengths
        ));
    }
    laid
}

fn note_fit(segment: &Segment, curve: &Curve, fit: &Fit, findings: &mut Findings) {
    let id = &segment.id;
    match fit {
        Fit::Cut { before, after } => findings.add_to(
            "centre curves are those of longer runs and do not end at the nodes; the piece between the nodes is cut \
             out, and the rest is ignored",
            format!("{id} ({:.1} mm, off {:.1} and {:.1} mm)", curve.length * 1e3, before * 1e3, after * 1e3),
        ),
        Fit::Stale { miss } => findings.add_to(
            "stale centre curves, which miss their nodes and contain no piece that fits between them; straight from \
             node to node",
            format!("{id} (by {:.1} mm)", miss * 1e3),
        ),
        Fit::Meets { .. } | Fit::Absent => {}
    }
}

/// Reports lengths that differ from each other or from the drawing by more than 1 % and the tolerance.
fn note_length(
    document: &Document,
    segment: &Segment,
    chord: f64,
    length: f64,
    curve: &Curve,
    fit: &Fit,
    findings: &mut Findings,
) {
    let id = &segment.id;
    let differ = |a: f64, b: f64| (a - b).abs() > NODE_TOLERANCE.max(0.01 * b);
    if let (Some(physical), Some(drawn)) = (segment.physical_length, segment.virtual_length)
        && differ(physical, drawn)
    {
        let [of_built, of_drawn] = document.format.lengths();
        findings.add_to(
            format!("{of_built} (taken) and {of_drawn} differ"),
            format!("{id} ({:.1} and {:.1} mm)", physical * 1e3, drawn * 1e3),
        );
    }
    if matches!(fit, Fit::Meets { .. }) && differ(curve.length, length) {
        findings.add_to(
            "branches are not as long as their drawn curves",
            format!("{id} ({:.1} mm, curve {:.1} mm)", length * 1e3, curve.length * 1e3),
        );
    }
    if document.drawn && chord > length * (1.0 + 1e-6) + 1e-6 {
        findings.add_to(
            "branches are shorter than their nodes are drawn apart; overstretched as drawn",
            format!("{id} ({:.2} mm, nodes {:.2} mm)", length * 1e3, chord * 1e3),
        );
    }
}

/// Wires of 0.5 mm² (outer diameter 1.6 mm) that fill a cross-section whose real wires are unknown: type and count.
fn stand_in(area: Option<f64>, types: &mut Types, findings: &mut Findings) -> (usize, usize) {
    const DIAMETER: f64 = 1.6e-3;
    let (id, copper_area, outside_diameter) = (String::new(), Some(0.5e-6), Some(DIAMETER));
    let wire = Wire { copper_area, outside_diameter, ..Wire::unknown(id) };
    let one = 0.25 * PI * DIAMETER * DIAMETER;
    let count = (area.unwrap_or(one) * PACKING / one).round().clamp(1.0, 1000.0) as usize;
    (types.wire(&wire, findings), count)
}

/// The coverings of a segment of this length: types, tapes and other wraps before tubes, with the covered part of its
/// length.
fn coverings(segment: &Segment, length: f64, types: &mut Types, findings: &mut Findings) -> Vec<(usize, u32)> {
    let mut covered: Vec<(usize, Vec<(f64, f64)>)> = Vec::new();
    for covering in &segment.coverings {
        let (a, b) = (covering.from.fraction(length), covering.to.fraction(length));
        let (low, high) = (a.min(b).clamp(0.0, 1.0), a.max(b).clamp(0.0, 1.0));
        // Digits of the file end at 10⁻⁶.
        if a.min(b) < -1e-5 || a.max(b) > 1.0 + 1e-5 {
            findings.add_to(
                "coverings reach beyond their segments; cut there",
                format!("{} `{}`", segment.id, covering.id),
            );
        }
        let Some(kind) = types.covering(covering, findings) else { continue };
        match covered.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, parts)) => parts.push((low, high)),
            None => covered.push((kind, vec![(low, high)])),
        }
    }
    covered.sort_by_key(|(kind, _)| !types.coverings[*kind].of_rule.wrap);
    let parts = covered.into_iter().map(|(kind, parts)| (kind, (union(parts) * f64::from(WHOLE)).round() as u32));
    parts.filter(|(_, parts)| *parts > 0).collect()
}

/// Length of the union of intervals.
fn union(mut parts: Vec<(f64, f64)>) -> f64 {
    parts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut reached, mut sum) = (0.0_f64, 0.0);
    for (low, high) in parts {
        sum += (high - low.max(reached)).max(0.0);
        reached = reached.max(high);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::union;

    #[test]
    fn parts_that_overlap_count_once() {
        assert_eq!(union(vec![(0.5, 0.75), (0.0, 0.25), (0.125, 0.375), (0.5, 0.625)]), 0.625);
        assert_eq!(union(vec![]), 0.0);
    }
}
