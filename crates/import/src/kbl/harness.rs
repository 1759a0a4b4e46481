//! What the file says, turned into branches, sections, joints and constraints.

use super::curve::{Curve, Fit, NODE_TOLERANCE, Vector};
use super::document::{Document, Segment};
use super::section::{Bundle, Covering, WIRE_FILL, Wire};
use super::{Findings, Options};
use nalgebra::UnitQuaternion;
use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;

/// How far, m, a fixing may be drawn from the place on the curve that its assignment names. Clips stand off the bundle by its radius
/// and their foot: 1 to 25 mm in the files at hand; assignments that are out of date are off by 130 mm and more.
const FIXING_REACH: f64 = 0.050;

/// Longest label that serves as a name; a longer one gives way to the XML id.
const LONGEST_NAME: usize = 32;

/// What a scenario is written from. SI throughout.
pub(super) struct Harness {
    pub name: String,
    pub sections: Vec<Section>,
    pub branches: Vec<Branch>,
    pub joints: Vec<Joint>,
    pub constraints: Vec<Constraint>,
}

pub(super) struct Section {
    pub name: String,
    pub bundle: Bundle,
    pub remark: String,
}

pub(super) struct Branch {
    pub name: String,
    pub from: String,
    pub to: String,
    /// Index of the section.
    pub section: usize,
    /// m.
    pub length: f64,
    /// Drawn centre line from `from` to `to`, m; empty where both ends are drawn at one point.
    pub path: Vec<Vector>,
    pub remark: String,
}

pub(super) struct Joint {
    pub name: String,
    pub arms: Vec<Arm>,
    pub shares: Vec<Share>,
}

pub(super) struct Arm {
    pub branch: String,
    /// Frame of the branch (columns d1, d2, d3; d3 `from → to`) in world axes.
    pub orientation: UnitQuaternion<f64>,
}

/// Wires that two arms of a joint have in common.
pub(super) struct Share {
    /// Index of the arm of whose stiffness `share` is a fraction.
    pub first: usize,
    pub second: usize,
    pub share: f64,
    pub wires: usize,
}

pub(super) enum Place {
    End(String),
    Along { branch: String, s: f64 },
}

pub(super) struct Constraint {
    pub name: String,
    pub at: Place,
    pub position: Vector,
    pub frame: UnitQuaternion<f64>,
    pub remark: String,
}

/// Gives out names, each once.
#[derive(Default)]
struct Names {
    taken: HashSet<String>,
}

impl Names {
    /// The label, or the id where the label is long or has control characters; numbered where it is taken.
    fn take(&mut self, label: &str, id: &str) -> String {
        let fits = !label.is_empty() && label.chars().count() <= LONGEST_NAME && !label.chars().any(char::is_control);
        let name = if fits { label } else { id };
        let unique = std::iter::once(name.to_owned())
            .chain((2..).map(|i| format!("{name}-{i}")))
            .find(|candidate| !self.taken.contains(candidate))
            .unwrap_or_default();
        self.taken.insert(unique.clone());
        unique
    }
}

/// A branch while the harness is being put together.
struct Laid {
    curve: Curve,
    length: f64,
    bundle: Bundle,
}

/// Which arm of a vertex: a segment, and whether it starts there.
#[derive(Clone, Copy)]
struct Incidence {
    segment: usize,
    starts: bool,
}

/// Decides everything the document leaves open, and reports each decision that a user may wish to know.
pub(super) fn assemble(document: &Document, options: &Options, findings: &mut Findings) -> Harness {
    let wires: Vec<Wire> = document
        .wires
        .iter()
        .map(|wire| Wire::new(wire.copper_area, wire.outside_diameter, wire.linear_density, wire.bend_radius))
        .collect();
    let mut incidences: Vec<Vec<Incidence>> = document.nodes.iter().map(|_| Vec::new()).collect();
    for (index, segment) in document.segments.iter().enumerate() {
        incidences[segment.ends[0]].push(Incidence { segment: index, starts: true });
        incidences[segment.ends[1]].push(Incidence { segment: index, starts: false });
    }
    let laid = lay_all(document, &wires, findings);

    let mut names = Names::default();
    let vertices: Vec<String> = document.nodes.iter().map(|node| names.take(&node.label, &node.id)).collect();
    let mut names = Names::default();
    let branch_names: Vec<String> =
        document.segments.iter().map(|segment| names.take(&segment.label, &segment.id)).collect();

    let (sections, section_of) = sections(document, &laid);
    let branches = document
        .segments
        .iter()
        .enumerate()
        .map(|(index, segment)| {
            let apart = (document.nodes[segment.ends[0]].position - document.nodes[segment.ends[1]].position).norm();
            let coincide = apart < 1e-9 && laid[index].curve.length < 1e-9;
            if coincide {
                findings
                    .add(format!("{}: both ends are drawn at one point and there is no curve; no path", segment.id));
            }
            Branch {
                name: branch_names[index].clone(),
                from: vertices[segment.ends[0]].clone(),
                to: vertices[segment.ends[1]].clone(),
                section: section_of[index],
                length: laid[index].length,
                path: if coincide { Vec::new() } else { laid[index].curve.path(options.max_segment) },
                remark: format!("{}: {}", segment.id, segment.label),
            }
        })
        .collect();

    let mut joints = Vec::new();
    for (node, arms) in incidences.iter().enumerate().filter(|(_, arms)| arms.len() >= 2) {
        let shares = shares(document, &wires, &laid, node, arms, findings);
        let arms = arms
            .iter()
            .map(|arm| {
                let curve = &laid[arm.segment].curve;
                let s = if arm.starts { 0.0 } else { curve.length };
                Arm { branch: branch_names[arm.segment].clone(), orientation: curve.frame(s) }
            })
            .collect();
        joints.push(Joint { name: vertices[node].clone(), arms, shares });
    }
    let constraints = constraints(document, &laid, &incidences, &vertices, &branch_names, findings);
    note_pieces(document, &incidences, &constraints, &vertices, &branch_names, findings);
    let name = options.name.as_ref().or(document.name.as_ref()).cloned().unwrap_or_else(|| "harness".to_owned());
    Harness { name, sections, branches, joints, constraints }
}

/// Centre line, length and section of every segment.
fn lay_all(document: &Document, wires: &[Wire], findings: &mut Findings) -> Vec<Laid> {
    let (mut unwired, mut absent, mut tight) = (Vec::new(), Vec::new(), Vec::new());
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
            if fit == Fit::Absent {
                absent.push(segment.id.clone());
            }
            let length = stated.unwrap_or_else(|| {
                findings.add(format!(
                    "{}: no usable Virtual_length or Physical_length; the length of the drawn line is taken",
                    segment.id
                ));
                // Nodes at one point and no curve: something that is at least a length.
                curve.length.max(NODE_TOLERANCE)
            });
            note_length(segment, (to - from).norm(), length, &curve, &fit, findings);
            if matches!(fit, Fit::Meets { .. } | Fit::Cut { .. }) && stated.is_some() {
                arcs += curve.length;
                lengths += length;
            }
            let covering = covering(segment, length, findings);
            let through: Vec<Wire> = if segment.wires.is_empty() {
                unwired.push(segment.id.clone());
                stand_in(segment.area)
            } else {
                segment.wires.iter().map(|&wire| wires[wire]).collect()
            };
            let bundle = Bundle::new(&through, &covering);
            let copper_and_insulation: f64 = through.iter().map(|wire| 0.25 * PI * wire.outside_diameter.powi(2)).sum();
            if !segment.wires.is_empty() && segment.area.is_some_and(|area| area < copper_and_insulation) {
                tight.push(segment.id.clone());
            }
            Laid { curve, length, bundle }
        })
        .collect();
    findings.add_list(|n| format!("{n} segment(s) without usable centre curve; straight from node to node"), &absent);
    findings.add_list(
        |n| format!("no wires are routed through {n} segment(s); wires of 0.5 mm² that fill the drawn area are taken"),
        &unwired,
    );
    findings.add_list(
        |n| {
            format!(
                "the cross-section drawn for {n} segment(s) is smaller than their wires together; \
                 diameters are taken from the wires everywhere"
            )
        },
        &tight,
    );
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
        Fit::Cut { before, after } => findings.add(format!(
            "{id}: its centre curve is that of a longer run and does not end at the nodes; the {:.1} mm between the nodes are \
             cut out of it, {:.1} mm before and {:.1} mm after are left off",
            curve.length * 1e3,
            before * 1e3,
            after * 1e3
        )),
        Fit::Stale { miss } => findings.add(format!(
            "{id}: its centre curve is stale, it misses the nodes by {:.1} mm and holds no piece that fits between \
             them; straight from node to node",
            miss * 1e3
        )),
        Fit::Meets { .. } | Fit::Absent => {}
    }
}

/// Lengths that do not go with each other or with what is drawn: beyond 1 % and the tolerance.
fn note_length(segment: &Segment, chord: f64, length: f64, curve: &Curve, fit: &Fit, findings: &mut Findings) {
    let id = &segment.id;
    let differ = |a: f64, b: f64| (a - b).abs() > NODE_TOLERANCE.max(0.01 * b);
    if let (Some(physical), Some(drawn)) = (segment.physical_length, segment.virtual_length)
        && differ(physical, drawn)
    {
        findings.add(format!(
            "{id}: Physical_length {:.1} mm (taken) and Virtual_length {:.1} mm differ",
            physical * 1e3,
            drawn * 1e3
        ));
    }
    if matches!(fit, Fit::Meets { .. }) && differ(curve.length, length) {
        findings.add(format!(
            "{id}: the drawn curve is {:.1} mm long, the branch {:.1} mm",
            curve.length * 1e3,
            length * 1e3
        ));
    }
    if chord > length * (1.0 + 1e-6) + 1e-6 {
        findings.add(format!(
            "{id}: the branch is {:.2} mm long, its nodes are drawn {:.2} mm apart: overstretched as drawn",
            length * 1e3,
            chord * 1e3
        ));
    }
}

/// Wires of 0.5 mm² (1.6 mm outside) that fill a cross-section, where nothing is known of the real ones.
fn stand_in(area: Option<f64>) -> Vec<Wire> {
    const DIAMETER: f64 = 1.6e-3;
    let one = 0.25 * PI * DIAMETER * DIAMETER;
    let count = (area.unwrap_or(one) * WIRE_FILL / one).round().clamp(1.0, 1000.0) as usize;
    vec![Wire::new(Some(0.5e-6), Some(DIAMETER), None, None); count]
}

/// What covers a segment of this length, spread over it.
fn covering(segment: &Segment, length: f64, findings: &mut Findings) -> Covering {
    let mut all = Covering::default();
    let mut taped: Vec<(f64, f64)> = Vec::new();
    for covering in &segment.coverings {
        let (a, b) = (covering.from.fraction(length), covering.to.fraction(length));
        let (low, high) = (a.min(b).clamp(0.0, 1.0), a.max(b).clamp(0.0, 1.0));
        // Digits of the file end at 10⁻⁶.
        if a.min(b) < -1e-5 || a.max(b) > 1.0 + 1e-5 {
            findings.add(format!("{}: covering `{}` reaches beyond the segment; cut there", segment.id, covering.id));
        }
        all.linear_density += (high - low) * covering.linear_density.unwrap_or(0.0);
        all.outside_diameter = all.outside_diameter.max(covering.outside_diameter.unwrap_or(0.0));
        if covering.tape {
            taped.push((low, high));
        } else {
            findings.add(format!(
                "`{}` counts with its mass and diameter; its own stiffness is not known and left out",
                covering.label
            ));
        }
    }
    // Length of the union of the taped intervals.
    taped.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut reached = 0.0_f64;
    for (low, high) in taped {
        all.taped += (high - low.max(reached)).max(0.0);
        reached = reached.max(high);
    }
    all
}

/// Rounded to four digits: the rule is not better than that, and equal make-ups become one section.
fn rounded(bundle: &Bundle) -> [String; 6] {
    [
        bundle.diameter,
        bundle.linear_density,
        bundle.axial_stiffness,
        bundle.bending_stiffness,
        bundle.torsion_stiffness,
        bundle.min_bend_radius,
    ]
    .map(|value| format!("{value:.3e}"))
}

fn sections(document: &Document, laid: &[Laid]) -> (Vec<Section>, Vec<usize>) {
    let mut sections: Vec<Section> = Vec::new();
    let mut known: HashMap<[String; 6], usize> = HashMap::new();
    let mut names = Names::default();
    let section_of = document
        .segments
        .iter()
        .zip(laid)
        .map(|(segment, laid)| {
            *known.entry(rounded(&laid.bundle)).or_insert_with(|| {
                let count = segment.wires.len();
                let plain = if count == 1 { "wire" } else { "wires" };
                let copper: f64 = segment.wires.iter().filter_map(|&wire| document.wires[wire].copper_area).sum();
                let mut remark = format!("{count} {plain}, {:.2} mm² copper", copper * 1e6);
                let mut labels: Vec<&str> = segment.coverings.iter().map(|covering| covering.label.as_str()).collect();
                labels.dedup();
                if !labels.is_empty() {
                    remark = format!("{remark}; {}", labels.join(", "));
                }
                remark = format!("{remark}; bundle factor {:.3}", laid.bundle.factor);
                let name = names.take(&format!("{count}-{plain}"), "wires");
                sections.push(Section { name, bundle: laid.bundle, remark });
                sections.len() - 1
            })
        })
        .collect();
    (sections, section_of)
}

/// The pairs of arms that share wires.
///
/// `C_ab = min(K_a, K_b) Σ_{wires in a and b} EI`: the arm with the smaller bundle factor K is named first, and
/// its share is `Σ_{common} EI / Σ_{a} EI`. A wire found in k > 2 arms gives each of its pairs 1/(k − 1).
/// Empty where the wires of some arm are not known.
fn shares(
    document: &Document,
    wires: &[Wire],
    laid: &[Laid],
    node: usize,
    arms: &[Incidence],
    findings: &mut Findings,
) -> Vec<Share> {
    let id = &document.nodes[node].id;
    let through: Vec<&Vec<usize>> = arms.iter().map(|arm| &document.segments[arm.segment].wires).collect();
    if through.iter().any(|wires| wires.is_empty()) {
        findings
            .add(format!("{id}: an arm of this joint has no routed wires; what its arms share is left to the default"));
        return Vec::new();
    }
    let mut arms_of: HashMap<usize, usize> = HashMap::new();
    for wire in through.iter().flat_map(|wires| wires.iter()) {
        *arms_of.entry(*wire).or_default() += 1;
    }
    let mut of_node = |what: &str, wanted: fn(usize) -> bool| {
        let mut found: Vec<usize> = arms_of.iter().filter(|(_, arms)| wanted(**arms)).map(|(wire, _)| *wire).collect();
        found.sort_unstable();
        let ids: Vec<String> = found.into_iter().map(|wire| document.wires[wire].id.clone()).collect();
        findings.add_list(|n| format!("{id}: {n} wire(s) {what}"), &ids);
    };
    of_node("end inside this joint, where nothing is said to hold them", |arms| arms == 1);
    of_node("run through more than two arms of this joint; divided evenly among the pairs", |arms| arms > 2);

    let mut shares = Vec::new();
    for a in 0..arms.len() {
        let mut alone = true;
        for b in 0..arms.len() {
            let common: Vec<usize> = through[a].iter().filter(|wire| through[b].contains(wire)).copied().collect();
            if a == b || common.is_empty() {
                continue;
            }
            alone = false;
            let factors = [a, b].map(|arm| laid[arms[arm].segment].bundle.factor);
            // Once for each pair, from the arm with the smaller factor (the earlier one where they are equal).
            if factors[0] > factors[1] || (factors[0] == factors[1] && a > b) {
                continue;
            }
            let passing: f64 =
                common.iter().map(|&wire| wires[wire].bending_stiffness() / (arms_of[&wire] - 1) as f64).sum();
            let all: f64 = through[a].iter().map(|&wire| wires[wire].bending_stiffness()).sum();
            shares.push(Share { first: a, second: b, share: (passing / all).min(1.0), wires: common.len() });
        }
        if alone {
            findings.add(format!(
                "{id}: no wire passes from {} to another arm of this joint; it hangs there as on a hinge",
                document.segments[arms[a].segment].id
            ));
        }
    }
    shares
}

/// Connectors at ends, collars along branches.
fn constraints(
    document: &Document,
    laid: &[Laid],
    incidences: &[Vec<Incidence>],
    vertices: &[String],
    branch_names: &[String],
    findings: &mut Findings,
) -> Vec<Constraint> {
    let mut constraints = Vec::new();
    let mut names = Names::default();
    let mut held: HashSet<usize> = HashSet::new();
    let (mut splices, mut bare) = (Vec::new(), Vec::new());
    for (index, node) in document.nodes.iter().enumerate() {
        let labels: Vec<String> =
            node.components.iter().map(|component| format!("{} {}", component.id, component.label)).collect();
        match incidences[index][..] {
            [] => findings.add(format!("{}: no segment ends at this node; left out", node.id)),
            [end] => {
                let Some(first) = node.components.iter().find(|component| !component.splice) else {
                    if labels.is_empty() {
                        bare.push(node.id.clone());
                    } else {
                        splices.push(format!("{} ({})", node.id, labels.join(", ")));
                    }
                    continue;
                };
                let curve = &laid[end.segment].curve;
                held.insert(index);
                constraints.push(Constraint {
                    name: names.take(&first.label, &first.id),
                    at: Place::End(vertices[index].clone()),
                    position: node.position,
                    frame: curve.frame(if end.starts { 0.0 } else { curve.length }),
                    remark: format!("{}: {}", node.id, labels.join(", ")),
                });
            }
            _ if labels.is_empty() => {}
            _ => findings.add(format!(
                "{}: components sit at this joint ({}); they hold nothing here",
                node.id,
                labels.join(", ")
            )),
        }
    }
    findings.add_list(|n| format!("{n} end(s) carry splices, which plug into nothing; left free"), &splices);
    findings.add_list(|n| format!("{n} end(s) carry no component; left free"), &bare);
    for (index, segment) in document.segments.iter().enumerate() {
        collars(
            document,
            segment,
            &laid[index],
            &branch_names[index],
            &mut names,
            &mut held,
            &mut constraints,
            findings,
        );
    }
    constraints
}

#[expect(clippy::too_many_arguments, reason = "one loop body of `constraints`, which it shares its locals with")]
fn collars(
    document: &Document,
    segment: &Segment,
    laid: &Laid,
    branch: &str,
    names: &mut Names,
    held: &mut HashSet<usize>,
    constraints: &mut Vec<Constraint>,
    findings: &mut Findings,
) {
    let mut taken: Vec<f64> = Vec::new();
    for fixing in &segment.fixings {
        let fraction = fixing.at.fraction(laid.length);
        let what = format!("{}: fixing {} `{}`", segment.id, fixing.id, fixing.label);
        if !(-1e-9..=1.0 + 1e-9).contains(&fraction) {
            findings.add(format!("{what} is placed at {fraction:.6} of the segment, which is outside it; left out"));
            continue;
        }
        let fraction = fraction.clamp(0.0, 1.0);
        let (s, drawn_s) = (fraction * laid.length, fraction * laid.curve.length);
        let position = laid.curve.point(drawn_s);
        if let Some(drawn) = fixing.drawn {
            let off = (drawn - position).norm();
            if off > FIXING_REACH {
                findings.add(format!(
                    "{what} is drawn {:.0} mm from the place it is assigned to, further than a clip reaches; left out",
                    off * 1e3
                ));
                continue;
            }
        }
        // At a vertex only one thing can hold, and along a branch only one at a place.
        let near = |place: f64| (s - place).abs() < NODE_TOLERANCE.min(0.01 * laid.length);
        let vertex = if near(0.0) { Some(segment.ends[0]) } else { near(laid.length).then_some(segment.ends[1]) };
        if let Some(vertex) = vertex
            && !held.insert(vertex)
        {
            findings.add(format!("{what} sits at node {}, which is held already; left out", document.nodes[vertex].id));
            continue;
        }
        if taken.iter().any(|&place| near(place)) {
            findings.add(format!("{what} sits where another fixing does; left out"));
            continue;
        }
        taken.push(s);
        constraints.push(Constraint {
            name: names.take(&fixing.label, &fixing.id),
            at: Place::Along { branch: branch.to_owned(), s },
            position,
            frame: laid.curve.frame(drawn_s),
            remark: format!("{}: {}", segment.id, fixing.id),
        });
    }
}

/// Connected pieces, and those that nothing holds.
fn note_pieces(
    document: &Document,
    incidences: &[Vec<Incidence>],
    constraints: &[Constraint],
    vertices: &[String],
    branch_names: &[String],
    findings: &mut Findings,
) {
    let holds = |node: usize| {
        constraints.iter().any(|constraint| match &constraint.at {
            Place::End(vertex) => *vertex == vertices[node],
            Place::Along { branch, .. } => incidences[node].iter().any(|arm| branch_names[arm.segment] == *branch),
        })
    };
    let mut seen = vec![false; document.nodes.len()];
    let mut pieces = 0;
    for start in 0..document.nodes.len() {
        if seen[start] || incidences[start].is_empty() {
            continue;
        }
        pieces += 1;
        seen[start] = true;
        let (mut open, mut held) = (vec![start], false);
        while let Some(node) = open.pop() {
            held |= holds(node);
            for arm in &incidences[node] {
                for end in document.segments[arm.segment].ends {
                    if !std::mem::replace(&mut seen[end], true) {
                        open.push(end);
                    }
                }
            }
        }
        if !held {
            findings.add(format!(
                "nothing holds the piece of the harness with node {}; add a constraint before running it",
                document.nodes[start].id
            ));
        }
    }
    if pieces > 1 {
        findings.add(format!("the harness is in {pieces} pieces that are not connected"));
    }
}
