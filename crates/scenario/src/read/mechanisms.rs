//! Reads mechanisms: joints and the bodies that they name, or a URDF file.

mod urdf;

use super::entry::Entry;
use super::freedoms::{quantity, shown};
use super::names::{Names, register};
use super::places::facing;
use crate::format::limits::ANY;
use crate::scenario::Facing;
use crate::span::Span;
use wireloom_core::mechanism::{JointKind, Mechanism, MechanismFault, MechanismJoint, Mount};
use wireloom_core::{Pose, Rotation, Vector};

/// Name of the body that does not move.
const GROUND: &str = "ground";

/// Bodies and joints, with the place of each joint in the scenario.
struct Parts {
    bodies: Vec<String>,
    joints: Vec<MechanismJoint>,
    spans: Vec<Span>,
}

/// A mechanism; its bodies and joints get their names. Nothing if it is faulty.
pub(crate) fn mechanism<'a>(entry: &Entry<'a>, names: &mut Names<'a>) {
    let before = entry.reader.fault_count();
    let index = names.mechanisms.len();
    let name = entry.word("name").filter(|name| register(entry, "mechanism", &mut names.mechanism_names, name, index));
    let parts = if entry.has("urdf") { from_urdf(entry) } else { from_joints(entry) };
    let sound = entry.reader.fault_count() == before;
    let (true, Some(name), Some(parts)) = (sound, name, parts) else { return faulty(names) };
    match Mechanism::new(name.to_owned(), parts.bodies.clone(), parts.joints.clone()) {
        Ok(mechanism) => {
            for (body, own) in mechanism.bodies.iter().enumerate().skip(1) {
                names.bodies.add(name, own, Mount { mechanism: index, body });
            }
            for (joint, own) in mechanism.joints.iter().enumerate() {
                names.mechanism_joints.add(name, &own.name, (index, joint));
            }
            names.mechanisms.push(mechanism);
        }
        Err(fault) => {
            faulty(names);
            refuse(entry, &parts, &fault);
        }
    }
}

fn faulty(names: &mut Names<'_>) {
    names.broken = true;
    (names.bodies.incomplete, names.mechanism_joints.incomplete) = (true, true);
}

fn refuse(entry: &Entry<'_>, parts: &Parts, fault: &MechanismFault) {
    let joint = |k: usize| (parts.spans[k].clone(), &parts.joints[k].name);
    let (span, message, help) = match fault {
        MechanismFault::Loose(body) => (
            entry.span.clone(),
            format!("no chain of joints connects body \"{}\" of {} with the ground", parts.bodies[*body], entry.label),
            "add the joint that carries it, with \"ground\" or a body that is connected",
        ),
        MechanismFault::Itself(k) => {
            let (span, name) = joint(*k);
            (span, format!("joint \"{name}\" connects a body with itself"), "name two bodies in `between`")
        }
        MechanismFault::Follows(k) => {
            let (span, name) = joint(*k);
            (span, format!("joint \"{name}\" cannot follow another one"), "drive it instead")
        }
        MechanismFault::Parallel(k) => {
            let (span, name) = joint(*k);
            let help = "give a `second_axis` across the first one, or kind = \"revolute\"";
            (span, format!("both axes of joint \"{name}\" are parallel"), help)
        }
    };
    entry.reader.fault(span, message, help);
}

/// Joints of the scenario, and the bodies that they name.
fn from_joints(entry: &Entry<'_>) -> Option<Parts> {
    if let Some(key) = ["position", "tangent", "up", "orientation"].into_iter().find(|key| entry.has(key)) {
        let help = "joints are given in world coordinates; leave it out";
        entry.fault_at(key, format!("{} has `{key}` but no `urdf`", entry.label), help);
    }
    let entries = entry.entries("joints");
    if entry.has("joints") && entries.is_empty() {
        entry.fault_at("joints", format!("{} has no joints", entry.label), "give at least one [[mechanisms.joints]]");
    }
    let mut parts = Parts { bodies: vec![GROUND.to_owned()], joints: Vec::new(), spans: Vec::new() };
    let mut whole = true;
    for entry in &entries {
        let own = joint(entry, &mut parts.bodies);
        if let Some(other) = own.as_ref().and_then(|own| parts.joints.iter().find(|other| other.name == own.name)) {
            let message = format!("there is another joint of the name \"{}\" in this mechanism", other.name);
            entry.fault_at("name", message, "give this one a name of its own");
        }
        whole &= own.is_some();
        parts.joints.extend(own);
        parts.spans.push(entry.span.clone());
    }
    (whole && !entries.is_empty()).then_some(parts)
}

fn joint(entry: &Entry<'_>, bodies: &mut Vec<String>) -> Option<MechanismJoint> {
    let name = entry.word("name");
    let word = entry.choice("kind");
    let between = entry.names("between");
    let count = entry.items("between").len();
    if entry.has("between") && count != 2 {
        let message = format!("{} connects {count} bodies", entry.label);
        entry.fault_at("between", message, "name two bodies, such as [\"ground\", \"door\"]");
    }
    let mut index = |name: &str| {
        bodies.iter().position(|body| body == name).unwrap_or_else(|| {
            bodies.push(name.to_owned());
            bodies.len() - 1
        })
    };
    let ends: Vec<usize> = between.iter().map(|(name, _)| index(name)).collect();
    let origin = entry.vector("origin").unwrap_or_default();
    let kind = kind(entry, word?)?;
    let limits = limits(entry, &kind);
    let [a, b] = ends[..] else { return None };
    Some(MechanismJoint { name: name?.to_owned(), kind, bodies: [a, b], origin, limits, follows: None })
}

/// The kind of a joint, with its axes; refuses those that it lacks, and those that it does not have.
fn kind(entry: &Entry<'_>, word: &str) -> Option<JointKind> {
    let needs: &[&str] = match word {
        "revolute" | "prismatic" | "cylindrical" => &["axis"],
        "screw" => &["axis", "pitch"],
        "universal" => &["axis", "second_axis"],
        _ => &[],
    };
    for key in ["axis", "second_axis", "pitch"] {
        if needs.contains(&key) && !entry.has(key) {
            let doc = entry.keys.get(key).map_or("", |key| key.doc);
            entry.missing(key, doc);
        } else if !needs.contains(&key) && entry.has(key) {
            let message = format!("{} has `{key}`, which a {word} joint does not have", entry.label);
            entry.fault_at(key, message, "leave it out, or choose another `kind`");
        }
    }
    let (axis, second, pitch) = (entry.direction("axis"), entry.direction("second_axis"), entry.number("pitch"));
    Some(match word {
        "revolute" => JointKind::Revolute(axis?),
        "prismatic" => JointKind::Prismatic(axis?),
        "cylindrical" => JointKind::Cylindrical(axis?),
        "screw" => JointKind::Screw(axis?, pitch?),
        "universal" => JointKind::Universal([axis?, second?]),
        "spherical" => JointKind::Spherical,
        _ => JointKind::Fixed,
    })
}

fn limits(entry: &Entry<'_>, kind: &JointKind) -> Option<[f64; 2]> {
    if !entry.has("limits") {
        return None;
    }
    let values = entry.values("limits");
    if kind.freedoms() != 1 {
        let message = format!("{} has `limits` and {} freedoms", entry.label, kind.freedoms());
        entry.fault_at("limits", message, "limits are those of a joint with one freedom: leave them out");
        return None;
    }
    let [low, high] = values else {
        let message = format!("{} has {} limits", entry.label, values.len());
        entry.fault_at("limits", message, "give the smallest and the largest value, such as [\"0 deg\", \"80 deg\"]");
        return None;
    };
    let [low, high] = [low, high].map(|node| entry.reader.number("limits", node, quantity(kind, 0), ANY));
    let (low, high) = (low?, high?);
    if low > high {
        let [low, high] = [low, high].map(|value| shown(kind, value));
        let message = format!("the limits of {} are {low} and {high}", entry.label);
        entry.fault_at("limits", message, "give the smaller one first");
        return None;
    }
    Some([low, high])
}

/// The joints of a URDF file, placed in the world.
fn from_urdf(entry: &Entry<'_>) -> Option<Parts> {
    if entry.has("joints") {
        let message = format!("{} has `joints` beside `urdf`", entry.label);
        entry.fault_at("joints", message, "leave one of them out");
    }
    let orientation = match facing(entry) {
        Facing::Left => Rotation::identity(),
        Facing::Orientation(orientation) => orientation,
        Facing::Tangent(_) => {
            let message = format!("{} has a tangent alone", entry.label);
            entry.fault_at("tangent", message, "add `up`, or leave both out for the world's axes");
            return None;
        }
    };
    let base = Pose { position: entry.vector("position").unwrap_or_default(), orientation };
    let path = entry.word("urdf")?;
    let span = entry.span_of("urdf");
    let text = entry.reader.file(path, span.clone())?;
    match urdf::read(&text, &base) {
        Ok((bodies, joints)) => {
            let spans = vec![span; joints.len()];
            Some(Parts { bodies, joints, spans })
        }
        Err(faults) => {
            for fault in faults {
                entry.reader.fault(span.clone(), format!("{path}:{}", fault.message), fault.help);
            }
            None
        }
    }
}

/// Refuses a mount whose body turns the world direction of a freedom.
pub(crate) fn refuse_turning(entry: &Entry<'_>, mount: Mount, directions: &[(&str, Vector)], names: &Names<'_>) {
    let mechanism = &names.mechanisms[mount.mechanism];
    for (key, direction) in directions {
        if !mechanism.keeps(mount.body, direction) {
            let message = format!(
                "`{key}` of {} is a direction of the world, and body \"{}\" may turn it",
                entry.label, mechanism.bodies[mount.body]
            );
            let help =
                "leave it out, mount it on no body, or choose a direction along the axes of the joints that turn it";
            entry.fault_at(key, message, help);
        }
    }
}

/// The body that an entry is mounted on, if any.
pub(crate) fn mount(entry: &Entry<'_>, names: &Names<'_>) -> Option<Mount> {
    entry.keys.get("mount")?;
    let name = entry.word("mount")?;
    names.bodies.find(entry, "body", name, entry.span_of("mount"))
}

/// The values that a list, or one number, gives to the freedoms of a joint.
pub(crate) fn values(entry: &Entry<'_>, key: &str, kind: &JointKind) -> Option<Vec<f64>> {
    let items = entry.items(key);
    if items.len() != kind.freedoms() {
        let message = format!("`{key}` of {} gives {} values", entry.label, items.len());
        entry.fault_at(key, message, format!("give one for each freedom of the joint: {}", kind.freedoms()));
        return None;
    }
    items
        .iter()
        .enumerate()
        .map(|(freedom, item)| entry.reader.number(key, item, quantity(kind, freedom), ANY))
        .collect()
}
