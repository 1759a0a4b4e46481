//! From the document to the harness: branches, sections, joints and constraints.

use super::anatomy;
use super::constraints::Holding;
use super::document::Document;
use super::error::ImportError;
use super::findings::Findings;
use super::harness::{Arm, Branch, Constraint, Harness, Joint, Place, Role, Section, SectionPart, Vertex};
use super::identities;
use super::names::Names;
use super::options::Options;
use super::section::{Makeup, Types};
use super::segments::{Incidence, Laid, Part, lay_all};
use super::unit::Quantity;
use std::collections::{HashMap, HashSet};
use wireloom_scenario::MAX_SEGMENTS;

/// Decides everything that the document leaves open, and reports the decisions that matter to a user. Also returns the
/// XML ids of the occurrences that act as constraints.
///
/// # Errors
/// If the harness is larger than a scenario may be.
pub(super) fn convert(
    document: &Document,
    options: &Options,
    findings: &mut Findings,
) -> Result<(Harness, HashSet<String>), ImportError> {
    let mut types = Types::new();
    let wires: Vec<usize> = document.wires.iter().map(|wire| types.wire(wire, findings)).collect();
    let mut incidences: Vec<Vec<Incidence>> = document.nodes.iter().map(|_| Vec::new()).collect();
    for (index, segment) in document.segments.iter().enumerate() {
        incidences[segment.ends[0]].push(Incidence { segment: index, starts: true });
        incidences[segment.ends[1]].push(Incidence { segment: index, starts: false });
    }
    let laid = lay_all(document, &mut types, &wires, findings);
    refuse_too_large(document, &laid, options)?;

    let mut names = Names::default();
    let vertices: Vec<String> = document.nodes.iter().map(|node| names.take(&node.label, &node.id)).collect();
    let mut names = Names::default();
    let branch_names: Vec<String> =
        document.segments.iter().map(|segment| names.take(&segment.label, &segment.id)).collect();

    let (sections, section_of) = sections(document, &laid);
    let mut branches: Vec<Branch> = document
        .segments
        .iter()
        .enumerate()
        .map(|(index, segment)| {
            let apart = (document.nodes[segment.ends[0]].position - document.nodes[segment.ends[1]].position).norm();
            let coincide = apart < 1e-9 && laid[index].curve.length < 1e-9;
            if coincide {
                findings.add_to("both ends are drawn at one point and there is no curve; no path", &segment.id);
            }
            let (section, parts) = main_section(&laid[index], &section_of[index]);
            Branch {
                name: branch_names[index].clone(),
                segment: document.format.is_written_back().then(|| segment.id.clone()),
                ends: segment.ends,
                section,
                parts,
                length: laid[index].length,
                tolerance: segment.tolerance,
                linear_density: laid[index].linear_density(),
                diameter: laid[index].diameter(),
                min_bend_radius: laid[index].min_bend_radius(),
                path: if coincide { Vec::new() } else { laid[index].curve.path(options.max_segment) },
                remark: format!("{}: {}", segment.id, segment.label),
            }
        })
        .collect();

    let stiffness: Vec<f64> = wires.iter().map(|&kind| types.wires[kind].of_rule.bending_stiffness().taken).collect();
    let mut joints = Vec::new();
    for (node, arms) in incidences.iter().enumerate().filter(|(_, arms)| arms.len() >= 2) {
        let wires = anatomy::common_wires(document, &stiffness, &laid, node, arms, findings);
        let arms = arms
            .iter()
            .map(|arm| {
                let curve = &laid[arm.segment].curve;
                let s = if arm.starts { 0.0 } else { curve.length };
                Arm { branch: arm.segment, orientation: curve.frame(s) }
            })
            .collect();
        joints.push(Joint { vertex: node, arms, wires });
    }
    let holding = Holding { document, laid: &laid, incidences: &incidences };
    let (constraints, names) = holding.constraints(options.arrangement, findings);
    end_apart(&mut branches, &laid, &constraints);
    let named: Vec<(String, f64)> = branch_names.iter().cloned().zip(laid.iter().map(|laid| laid.length)).collect();
    let kept = identities::keep(document, &constraints, names, &vertices, &named);
    let name = options.name.as_ref().or(document.name.as_ref()).cloned().unwrap_or_else(|| "harness".to_owned());
    let vertices = vertices.into_iter().zip(&document.nodes);
    let vertices = vertices.map(|(name, node)| Vertex { name, position: node.position }).collect();
    let harness = Harness {
        name,
        vertices,
        types,
        sections,
        branches,
        joints,
        constraints,
        identities: kept.constraints,
        listed: kept.identities,
    };
    Ok((harness, kept.acting))
}

/// Refuses a harness that has more segments than a scenario may, or a branch that is longer.
fn refuse_too_large(document: &Document, laid: &[Laid], options: &Options) -> Result<(), ImportError> {
    let [_, longest] = Quantity::Length.range();
    let segments: f64 = laid.iter().map(|laid| (laid.length / options.max_segment).ceil()).sum();
    let (longest_of, length) = laid
        .iter()
        .zip(&document.segments)
        .map(|(laid, segment)| (segment.id.as_str(), laid.length))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or_default();
    if segments > MAX_SEGMENTS as f64 || length > longest {
        let id = longest_of.to_owned();
        return Err(ImportError::TooLarge { id, length, max_segment: options.max_segment, segments });
    }
    Ok(())
}

/// The sections, and the index of that of each part of each segment.
fn sections(document: &Document, laid: &[Laid]) -> (Vec<Section>, Vec<Vec<usize>>) {
    let mut sections: Vec<Section> = Vec::new();
    let mut known: HashMap<&Makeup, usize> = HashMap::new();
    let mut names = Names::default();
    let mut section_of = vec![Vec::new(); laid.len()];
    for ((segment, laid), indices) in document.segments.iter().zip(laid).zip(&mut section_of) {
        for Part { makeup, bundle, .. } in &laid.parts {
            indices.push(*known.entry(makeup).or_insert_with(|| {
                let count = bundle.wires;
                let plain = if count == 1 { "wire" } else { "wires" };
                let areas = segment.wires.iter().filter_map(|&wire| document.wires[wire].copper_area);
                // The sum of no numbers would be -0.
                let copper = areas.fold(0.0, |sum, area| sum + area);
                let remark = match segment.wires[..] {
                    [] => format!("{count} {plain}, though the file routes none here"),
                    _ => format!("{count} {plain}, {:.2} mm² copper", copper * 1e6),
                };
                let name = names.take(&format!("{count}-{plain}"), "wires");
                sections.push(Section { name, makeup: makeup.clone(), remark });
                sections.len() - 1
            }));
        }
    }
    (sections, section_of)
}

/// Lets parts within a branch end at least half of a diameter away from what holds it, or at it: no segment between
/// both is then so short. A cable slides through a guide only up to the end of a part, so that is never at one.
fn end_apart(branches: &mut [Branch], laid: &[Laid], constraints: &[Constraint]) {
    for constraint in constraints {
        let Place::Along { branch, s } = constraint.at else { continue };
        let parts = &laid[branch].parts;
        for pair in parts.windows(2) {
            let end = pair[0].range[1];
            let near = 0.5 * pair[0].bundle.diameter.max(pair[1].bundle.diameter);
            if (end - s).abs() >= near {
                continue;
            }
            let place = match constraint.role {
                Role::Guide if end < s => s - near,
                Role::Guide => s + near,
                Role::Connector | Role::Clip => s,
            };
            // Both parts keep the greater part of their length.
            let fits = place > 0.5 * (pair[0].range[0] + end) && place < 0.5 * (end + pair[1].range[1]);
            for own in branches[branch].parts.iter_mut().flat_map(|part| &mut part.range).filter(|_| fits) {
                if *own == end {
                    *own = place;
                }
            }
        }
    }
}

/// The section that most of a segment has, and the parts that have another one; `of_parts`: that of each part.
fn main_section(laid: &Laid, of_parts: &[usize]) -> (usize, Vec<SectionPart>) {
    let parts = || laid.parts.iter().zip(of_parts.iter().copied());
    let length =
        |section: usize| parts().filter(|(_, own)| *own == section).map(|(part, _)| part.length()).sum::<f64>();
    let main = of_parts.iter().copied().max_by(|a, b| length(*a).total_cmp(&length(*b)).then(b.cmp(a)));
    let main = main.unwrap_or_default();
    let others = parts().filter(|(_, section)| *section != main);
    (main, others.map(|(part, section)| SectionPart { section, range: part.range }).collect())
}
