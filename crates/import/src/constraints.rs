//! Constraints of the harness in the vehicle: connectors at its ends, clips along its branches.

use super::curve::{NODE_TOLERANCE, Vector};
use super::document::{Document, Fixing, Node, Placement, Segment};
use super::findings::Findings;
use super::harness::{Constraint, Place, Role};
use super::names::Names;
use super::options::Arrangement;
use super::segments::{Incidence, Laid};
use std::collections::HashSet;

/// Largest distance, m, of a drawn fixing from the place on the curve that its assignment names. Clips stand off the
/// bundle by its radius and their foot: 1 to 25 mm in the known files; outdated assignments are off by 130 mm and more.
const FIXING_REACH: f64 = 0.050;

/// Largest distance, m, along the curve of the stated place of a fixing from the place where the fixing itself is drawn
/// that is not reported. The drawn place counts: the stated one is rounded, and older.
const FIXING_SHIFT: f64 = 0.002;

/// Largest distance, m, of a drawn connector from the end of its branch: bodies are up to 41 mm long in the known
/// files, outdated placements are off by 0.6 m.
const CONNECTOR_REACH: f64 = 0.100;

/// Cosine of the largest angle (25°) between a fixing's drawn channel and the cable for the channel to count as its
/// direction.
const ALIGNED: f64 = 0.906;

/// Smallest span between two clips, in diameters of the cable; a closer clip only guides: the cable may slide along
/// itself.
///
/// The place of a clip along a bundle is known to a millimetre at best. In a span of ten diameters an excess length of
/// 0.1 ‰, which is less, gives kilonewtons (EA of copper). No clip bears such forces, and the cable slips first.
const STIFF_SPAN: f64 = 10.0;

/// The data from which the constraints of a harness are made.
pub(super) struct Holding<'a> {
    pub document: &'a Document,
    pub laid: &'a [Laid],
    pub incidences: &'a [Vec<Incidence>],
}

impl Holding<'_> {
    /// The constraints and their names: connectors at ends, collars along branches, and further connectors such that
    /// every piece is held.
    pub fn constraints(&self, arrangement: Arrangement, findings: &mut Findings) -> (Vec<Constraint>, Names) {
        let mut names = Names::default();
        let mut held = HashSet::new();
        let mut constraints = self.connectors(&mut names, &mut held, findings);
        for (index, segment) in self.document.segments.iter().enumerate() {
            self.clips(index, segment, &mut names, &mut held, &mut constraints, findings);
        }
        self.hold_pieces(&mut names, &held, arrangement, &mut constraints, findings);
        (constraints, names)
    }

    fn connectors(&self, names: &mut Names, held: &mut HashSet<usize>, findings: &mut Findings) -> Vec<Constraint> {
        let mut constraints = Vec::new();
        for (index, node) in self.document.nodes.iter().enumerate() {
            let labels: Vec<String> =
                node.components.iter().map(|component| format!("{} {}", component.id, component.label)).collect();
            let labels = labels.join(", ");
            let end = match self.incidences[index][..] {
                // Nodes are ends of segments.
                [] => continue,
                [end] => end,
                _ => {
                    if !labels.is_empty() {
                        let item = format!("{} ({labels})", node.id);
                        findings.add_to("components sit at a joint; they hold nothing there", item);
                    }
                    continue;
                }
            };
            let Some(first) = node.components.iter().find(|component| !component.splice) else {
                if labels.is_empty() {
                    findings.add_to("ends carry no component; left free", &node.id);
                } else {
                    findings.add_to(
                        "ends carry splices (wires joined within the harness, without a counterpart); left free",
                        format!("{} ({labels})", node.id),
                    );
                }
                continue;
            };
            let others: Vec<&str> = (node.components.iter())
                .filter(|other| !other.splice && other.id != first.id)
                .map(|other| other.label.as_str())
                .collect();
            if !others.is_empty() {
                let item = format!("{} (`{}`; also {})", node.id, first.label, others.join(", "));
                findings.add_to("several connectors sit at one end; the first one holds it", item);
            }
            let off = first.placement.as_ref().map(|placement| (placement.position - node.position).norm());
            if let Some(off) = off.filter(|off| *off > CONNECTOR_REACH) {
                findings.add_to(
                    "connectors are drawn far from the ends of their branches; held where the branches end",
                    format!("`{}` ({:.0} mm)", first.label, off * 1e3),
                );
            }
            let curve = &self.laid[end.segment].curve;
            held.insert(index);
            constraints.push(Constraint {
                name: names.take(&first.label, &first.id),
                at: Place::End(index),
                role: Role::Connector,
                position: node.position,
                frame: curve.frame(if end.starts { 0.0 } else { curve.length }),
                mass: first.mass.unwrap_or(0.0),
                of: Some(first.id.clone()),
                assignment: None,
                remark: format!("{}: {labels}", node.id),
            });
        }
        constraints
    }

    fn clips(
        &self,
        index: usize,
        segment: &Segment,
        names: &mut Names,
        held: &mut HashSet<usize>,
        constraints: &mut Vec<Constraint>,
        findings: &mut Findings,
    ) {
        let laid = &self.laid[index];
        let ends: Vec<f64> = [0.0, laid.length]
            .into_iter()
            .zip(segment.ends)
            .filter(|(_, end)| held.contains(end))
            .map(|(s, _)| s)
            .collect();
        let first = constraints.len();
        // Places along the branch, in its order: a clip's neighbours decide what it may hold.
        let mut seats: Vec<Seat> =
            segment.fixings.iter().filter_map(|fixing| self.seat(segment, laid, fixing, findings)).collect();
        seats.sort_by(|a, b| a.drawn_s.total_cmp(&b.drawn_s));
        let mut clamped: Vec<f64> = ends;
        let mut taken: Vec<f64> = Vec::new();
        for seat in seats {
            let s = seat.drawn_s / laid.curve.length.max(NODE_TOLERANCE) * laid.length;
            // At a vertex only one thing can hold, and along a branch only one at a place.
            let near = |place: f64| (s - place).abs() < NODE_TOLERANCE.min(0.01 * laid.length);
            let vertex = if near(0.0) { Some(segment.ends[0]) } else { near(laid.length).then_some(segment.ends[1]) };
            if let Some(vertex) = vertex
                && !held.insert(vertex)
            {
                let item = format!("{} at {}", seat.what, self.document.nodes[vertex].id);
                findings.add_to("fixings sit at nodes that are held already; left out", item);
                continue;
            }
            if taken.iter().any(|&place| near(place)) {
                findings.add_to("fixings sit where another one does; left out", seat.what);
                continue;
            }
            taken.push(s);
            let stiff = STIFF_SPAN * laid.diameter();
            let crowded = clamped.iter().any(|&place| (s - place).abs() < stiff);
            let role = if seat.fixing.duct || crowded { Role::Guide } else { Role::Clip };
            if role == Role::Clip {
                clamped.push(s);
            } else {
                let why = if seat.fixing.duct { "a duct" } else { "near another constraint" };
                findings.add_to(
                    format!(
                        "fixings that let the cable slide along itself: ducts, and those within {STIFF_SPAN} diameters \
                         of another constraint (0.01 mm of excess length would give kilonewtons there)"
                    ),
                    format!("{} ({why})", seat.what),
                );
            }
            constraints.push(Constraint {
                name: names.take(&seat.fixing.label, &seat.fixing.id),
                at: Place::Along { branch: index, s },
                role,
                position: laid.curve.point(seat.drawn_s),
                frame: laid.curve.frame_along(seat.drawn_s, &seat.tangent),
                mass: 0.0,
                of: seat.fixing.of.clone(),
                assignment: self.document.format.is_written_back().then(|| seat.fixing.id.clone()),
                remark: format!("{}: {}", segment.id, seat.fixing.id),
            });
        }
        note_spans(segment, &constraints[first..], findings);
    }

    /// Place of a fixing on the drawn curve: the point nearest to the drawn fixing, if that is near the stated place;
    /// the stated place if the fixing is not drawn.
    pub(super) fn seat<'f>(
        &self,
        segment: &Segment,
        laid: &Laid,
        fixing: &'f Fixing,
        findings: &mut Findings,
    ) -> Option<Seat<'f>> {
        let fraction = fixing.at.fraction(laid.length);
        let what = format!("{} {} `{}`", segment.id, fixing.id, fixing.label);
        if !(-1e-9..=1.0 + 1e-9).contains(&fraction) {
            findings.add_to("fixings are placed outside their segments; left out", format!("{what} at {fraction:.6}"));
            return None;
        }
        let stated = fraction.clamp(0.0, 1.0) * laid.curve.length;
        let tangent = laid.curve.tangent(stated);
        let Some(Placement { position, axis }) = &fixing.placement else {
            return Some(Seat { fixing, what, drawn_s: stated, tangent });
        };
        let off = (position - laid.curve.point(stated)).norm();
        if off > FIXING_REACH {
            findings.add_to(
                "fixings are drawn further from their assigned places than a clip reaches; left out",
                format!("{what} ({:.0} mm)", off * 1e3),
            );
            return None;
        }
        let drawn_s = laid.curve.project(position);
        if (drawn_s - stated).abs() > FIXING_SHIFT {
            findings.add_to(
                "fixings are drawn beside the places stated for them along their segments; placed where they are drawn",
                format!("{what} ({:+.1} mm)", (drawn_s - stated) * 1e3),
            );
        }
        let tangent = laid.curve.tangent(drawn_s);
        let cosine = axis.map_or(0.0, |axis| axis.dot(&tangent));
        let aligned = axis.filter(|_| cosine.abs() >= ALIGNED).map(|axis| axis * cosine.signum());
        if axis.is_some() && aligned.is_none() {
            findings.add_to(
                "the channels of fixings do not lie along the cable as drawn; it is held along the drawn curve",
                format!("{what} ({:.0} deg)", cosine.abs().min(1.0).acos().to_degrees()),
            );
        }
        Some(Seat { fixing, what, drawn_s, tangent: aligned.unwrap_or(tangent) })
    }

    /// Holds pieces that could move or turn as a whole, each at an end (or a joint, if it has none) without a
    /// constraint.
    fn hold_pieces(
        &self,
        names: &mut Names,
        held: &HashSet<usize>,
        arrangement: Arrangement,
        constraints: &mut Vec<Constraint>,
        findings: &mut Findings,
    ) {
        let document = self.document;
        let mut holds = vec![Restraint::None; document.nodes.len()];
        for constraint in constraints.iter() {
            let node = match constraint.at {
                Place::End(vertex) | Place::Joint(vertex) => vertex,
                Place::Along { branch, .. } => document.segments[branch].ends[0],
            };
            holds[node] = holds[node].and(&Restraint::of(constraint));
        }
        let mut seen = vec![false; document.nodes.len()];
        let mut pieces = 0;
        for start in 0..document.nodes.len() {
            if seen[start] || self.incidences[start].is_empty() {
                continue;
            }
            pieces += 1;
            seen[start] = true;
            let (mut piece, mut next, mut restraint) = (vec![start], 0, Restraint::None);
            while let Some(&node) = piece.get(next) {
                next += 1;
                restraint = restraint.and(&holds[node]);
                for arm in &self.incidences[node] {
                    for end in document.segments[arm.segment].ends {
                        if !std::mem::replace(&mut seen[end], true) {
                            piece.push(end);
                        }
                    }
                }
            }
            // On a board the root of a piece is always held.
            if restraint == Restraint::Full || arrangement != Arrangement::Installed {
                continue;
            }
            let free = |node: &&usize| !held.contains(node);
            let end = piece.iter().filter(free).find(|node| self.incidences[**node].len() == 1);
            let Some(&node) = end.or_else(|| piece.iter().find(free)) else { continue };
            let Node { id, label, position, .. } = &document.nodes[node];
            findings.add_to(
                "pieces of the harness could move or turn as a whole; each is held by a connector at a node",
                id,
            );
            let Incidence { segment, starts } = self.incidences[node][0];
            let curve = &self.laid[segment].curve;
            constraints.push(Constraint {
                name: names.take(label, id),
                at: if end.is_some() { Place::End(node) } else { Place::Joint(node) },
                role: Role::Connector,
                position: *position,
                frame: curve.frame(if starts { 0.0 } else { curve.length }),
                mass: 0.0,
                of: None,
                assignment: None,
                remark: format!("{id}: nothing else holds this piece of the harness"),
            });
        }
        if pieces > 1 {
            findings.add(format!("the harness is in {pieces} pieces that are not connected"));
        }
    }
}

/// Freedoms of a rigid body that some constraints hold together.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Restraint {
    /// Nothing, or not all positions.
    None,
    /// All but rotation about this axis: a point, and a direction.
    About(Vector, Vector),
    /// Everything.
    Full,
}

impl Restraint {
    fn of(constraint: &Constraint) -> Self {
        match constraint.role {
            Role::Connector => Restraint::Full,
            Role::Clip => Restraint::About(constraint.position, constraint.frame * Vector::z()),
            Role::Guide => Restraint::None,
        }
    }

    fn and(&self, other: &Self) -> Self {
        match (*self, *other) {
            (Restraint::None, restraint) | (restraint, Restraint::None) => restraint,
            (Restraint::About(p, t), Restraint::About(q, u)) => {
                // Well above the precision of the written numbers and of the solution.
                let one_axis = t.cross(&u).norm() < 1e-3 && (q - p).cross(&t).norm() < NODE_TOLERANCE;
                if one_axis { *self } else { Restraint::Full }
            }
            _ => Restraint::Full,
        }
    }
}

/// A fixing with its place on the drawn curve.
pub(super) struct Seat<'f> {
    fixing: &'f Fixing,
    what: String,
    /// Arc length on the drawn curve, m.
    pub drawn_s: f64,
    /// Unit tangent of the cable.
    pub tangent: Vector,
}

/// Reports spans between constraints of a branch that are shorter than the distance of their ends.
fn note_spans(segment: &Segment, constraints: &[Constraint], findings: &mut Findings) {
    let mut last: Option<(&Constraint, f64)> = None;
    for constraint in constraints {
        let Place::Along { s, .. } = constraint.at else { continue };
        if let Some((before, from)) = last {
            let (span, chord) = (s - from, (constraint.position - before.position).norm());
            if chord > span + 1e-6 {
                findings.add_to(
                    "fixings are drawn further apart than the length of the cable between them; overstretched as drawn",
                    format!(
                        "{} `{}` to `{}` ({:.2} mm, cable {:.2} mm)",
                        segment.id,
                        before.name,
                        constraint.name,
                        chord * 1e3,
                        span * 1e3
                    ),
                );
            }
        }
        last = Some((constraint, s));
    }
}
