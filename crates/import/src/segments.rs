//! Centre line, length, wires and coverings of every segment.

use super::curve::{Curve, Fit, NODE_TOLERANCE};
use super::document::{Document, Segment, Wire};
use super::findings::Findings;
use super::section::{Makeup, Types};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use wireloom_scenario::bundle::{Bundle, PACKING};

/// A segment with its centre line and its make-up.
pub(super) struct Laid {
    pub curve: Curve,
    /// How the curves of the file agree with the nodes.
    pub fit: Fit,
    pub length: f64,
    /// Its parts with different coverings, in the order of arc length; at least one.
    pub parts: Vec<Part>,
}

/// Part of a segment with the same coverings all along.
pub(super) struct Part {
    pub makeup: Makeup,
    pub bundle: Bundle,
    /// Where it begins and ends, m.
    pub range: [f64; 2],
}

impl Part {
    pub fn length(&self) -> f64 {
        self.range[1] - self.range[0]
    }
}

impl Laid {
    /// The bundle at its start, or at its end.
    pub fn at_end(&self, starts: bool) -> &Bundle {
        &self.parts[if starts { 0 } else { self.parts.len() - 1 }].bundle
    }

    /// The greatest diameter, m.
    pub fn diameter(&self) -> f64 {
        self.parts.iter().map(|part| part.bundle.diameter).fold(0.0, f64::max)
    }

    /// The greatest of the smallest bend radii, m.
    pub fn min_bend_radius(&self) -> f64 {
        self.parts.iter().map(|part| part.bundle.min_bend_radius).fold(0.0, f64::max)
    }

    /// Mass per length, kg/m.
    pub fn linear_density(&self) -> f64 {
        match self.parts.as_slice() {
            [part] => part.bundle.linear_density,
            parts => parts.iter().map(|part| part.bundle.linear_density * part.length()).sum::<f64>() / self.length,
        }
    }
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
                coverings: Vec::new(),
                bend_radius: segment.bend_radius.map(Makeup::micrometres),
                moving_bend_radius: moving.map(Makeup::micrometres),
            };
            let parts = covered_parts(segment, length, types, findings);
            let part = |(coverings, range): (Vec<usize>, [f64; 2])| {
                let makeup = Makeup { coverings, ..makeup.clone() };
                Part { bundle: types.bundle(&makeup), makeup, range }
            };
            let parts: Vec<Part> = parts.into_iter().map(part).collect();
            let narrow: BTreeSet<usize> = parts.iter().flat_map(|part| narrower(part, types)).collect();
            for kind in narrow {
                let wires = parts[0].bundle.wires_diameter * 1e3;
                findings.add_to(
                    "tubes are narrower inside than all wires together that run through them; taken as wide as \
                     these",
                    format!("{} `{}` ({wires:.1} mm of wires)", segment.id, types.coverings[kind].name),
                );
            }
            let parts = without_short_ones(segment, parts, findings);
            let circle = |&(kind, count): &(usize, usize)| {
                count as f64 * 0.25 * PI * types.wires[kind].of_rule.diameter().powi(2)
            };
            let copper_and_insulation: f64 = parts[0].makeup.wires.iter().map(circle).sum();
            if !segment.wires.is_empty() && segment.area.is_some_and(|area| area < copper_and_insulation) {
                findings.add_to(
                    "cross-sections are drawn smaller than their wires together; diameters are taken from the wires \
                     everywhere",
                    &segment.id,
                );
            }
            Laid { curve, fit, length, parts }
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

/// Types of the coverings of each part of a segment of this length (m), tapes and other wraps before tubes, and where
/// the part begins and ends, m.
fn covered_parts(
    segment: &Segment,
    length: f64,
    types: &mut Types,
    findings: &mut Findings,
) -> Vec<(Vec<usize>, [f64; 2])> {
    // Digits of the file end at 10⁻⁶.
    const SAME: f64 = 1e-5;
    let mut all: Vec<(usize, [f64; 2])> = Vec::new();
    for covering in &segment.coverings {
        let (a, b) = (covering.from.fraction(length), covering.to.fraction(length));
        if a.min(b) < -SAME || a.max(b) > 1.0 + SAME {
            findings.add_to(
                "coverings reach beyond their segments; cut there",
                format!("{} `{}`", segment.id, covering.id),
            );
        }
        let Some(kind) = types.covering(covering, findings) else { continue };
        all.push((kind, [a.min(b).clamp(0.0, 1.0), a.max(b).clamp(0.0, 1.0)]));
    }
    let mut kinds: Vec<usize> = Vec::new();
    all.iter().for_each(|(kind, _)| {
        if !kinds.contains(kind) {
            kinds.push(*kind)
        }
    });
    kinds.sort_by_key(|kind| !types.coverings[*kind].of_rule.wrap);
    let mut places: Vec<f64> =
        all.iter().flat_map(|(_, range)| *range).filter(|f| (SAME..1.0 - SAME).contains(f)).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|b, a| *b - *a <= SAME);
    let mut parts: Vec<(Vec<usize>, [f64; 2])> = Vec::new();
    for ends in [0.0].into_iter().chain(places).chain([1.0]).collect::<Vec<f64>>().windows(2) {
        let middle = 0.5 * (ends[0] + ends[1]);
        let covers = |kind: &usize| all.iter().any(|(own, [from, to])| own == kind && (*from..*to).contains(&middle));
        let here: Vec<usize> = kinds.iter().copied().filter(covers).collect();
        match parts.last_mut() {
            Some((before, range)) if *before == here => range[1] = ends[1] * length,
            _ => parts.push((here, [ends[0] * length, ends[1] * length])),
        }
    }
    parts
}

/// The tubes of a part that its wires do not fit into.
fn narrower(part: &Part, types: &Types) -> Vec<usize> {
    let narrow = |kind: &usize| {
        types.coverings[*kind].of_rule.inner_diameter.is_some_and(|inner| inner < part.bundle.wires_diameter)
    };
    part.makeup.coverings.iter().copied().filter(narrow).collect()
}

/// Parts that are shorter than they, or what is beside them, are thick, are counted with the longer part beside them:
/// so short a piece of cable is no rod.
fn without_short_ones(segment: &Segment, mut parts: Vec<Part>, findings: &mut Findings) -> Vec<Part> {
    let beside = |k: usize, parts: &[Part]| [k.checked_sub(1), (k + 1 < parts.len()).then_some(k + 1)];
    loop {
        let is_short = |k: &usize| {
            let around = beside(*k, &parts).into_iter().flatten().chain([*k]);
            parts[*k].length() < around.map(|near| parts[near].bundle.diameter).fold(0.0, f64::max)
        };
        let short = (0..parts.len()).filter(is_short);
        let shortest = short.min_by(|a, b| parts[*a].length().total_cmp(&parts[*b].length()));
        let Some(k) = shortest.filter(|_| parts.len() > 1) else { return parts };
        let longer = beside(k, &parts).into_iter().flatten();
        let Some(into) = longer.max_by(|a, b| parts[*a].length().total_cmp(&parts[*b].length())) else { return parts };
        findings.add_to(
            "parts of segments with other coverings are shorter than they are thick; counted with what is beside them",
            format!("{} ({:.1} mm)", segment.id, parts[k].length() * 1e3),
        );
        let [from, to] = parts[k].range;
        let range = &mut parts[into].range;
        *range = [range[0].min(from), range[1].max(to)];
        parts.remove(k);
        // What it divided may be alike.
        parts.dedup_by(|after, before| {
            let alike = after.makeup == before.makeup;
            if alike {
                before.range[1] = after.range[1];
            }
            alike
        });
    }
}
