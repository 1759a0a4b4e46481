//! Reads mechanisms: joints and the bodies that they name, or a URDF file.

mod urdf;

use super::entry::Entry;
use super::freedoms::{UNLIMITED, quantity, shown};
use super::kinds::Chosen;
use super::names::{Names, register};
use super::obstacles::{Cables, Placed, body};
use super::places::facing;
use super::reader::Node;
use crate::fault::did_you_mean;
use crate::format::keys::mechanisms::LINK_SHAPES;
use crate::format::limits::ANY;
use crate::scenario::{Body, Facing};
use crate::span::Span;
use nalgebra::Unit;
use std::collections::BTreeMap;
use toml::de::DeValue;
use urdf::shapes::{LinkForm, LinkShape};
use wildmatch::WildMatch;
use wireloom_core::mechanism::{JointKind, Mechanism, MechanismFault, MechanismJoint, Mount};
use wireloom_core::obstacle::ShapeFile;
use wireloom_core::{Parameters, Pose, Rotation, Value, Vector};

/// Name of the body that does not move.
const GROUND: &str = "ground";
/// Sine of the angle below which directions are parallel.
const PARALLEL: f64 = 1e-3;

/// Bodies and joints, with the place of each joint in the scenario.
struct Parts {
    bodies: Vec<String>,
    joints: Vec<MechanismJoint>,
    spans: Vec<Span>,
    shapes: Vec<LinkShape>,
}

/// A mechanism; its bodies and joints get their names. Nothing if it is faulty. Returns the shapes of its links that
/// are obstacles.
pub(crate) fn mechanism<'a>(entry: &Entry<'a>, cables: Cables, names: &mut Names<'a>) -> Vec<Body> {
    let before = entry.reader.fault_count();
    let index = names.mechanisms.len();
    let name = entry.word("name").filter(|name| register(entry, "mechanism", &mut names.mechanism_names, name, index));
    let parts = if entry.has("urdf") { from_urdf(entry) } else { from_joints(entry) };
    let sound = entry.reader.fault_count() == before;
    let (true, Some(name), Some(parts)) = (sound, name, parts) else {
        faulty(names);
        return Vec::new();
    };
    match Mechanism::new(name.to_owned(), parts.bodies.clone(), parts.joints.clone()) {
        Ok(mechanism) => {
            for (body, own) in mechanism.bodies.iter().enumerate().skip(1) {
                names.bodies.add(name, own, Mount { mechanism: index, body });
            }
            for (joint, own) in mechanism.joints.iter().enumerate() {
                names.mechanism_joints.add(name, &own.name, (index, joint));
            }
            names.mechanisms.push(mechanism);
            link_shapes(entry, name, parts, cables, names)
        }
        Err(fault) => {
            faulty(names);
            refuse(entry, &parts, &fault);
            Vec::new()
        }
    }
}

/// The shapes of the links as obstacles that are mounted on them.
fn link_shapes<'a>(
    entry: &Entry<'a>,
    mechanism: &str,
    parts: Parts,
    cables: Cables,
    names: &mut Names<'a>,
) -> Vec<Body> {
    let Parts { bodies, shapes, .. } = parts;
    let patterns = entry.names("without");
    for (pattern, span) in &patterns {
        if !bodies.iter().any(|body| WildMatch::new(pattern).matches(body)) {
            let help = format!("there are {}", bodies.join(", "));
            entry.reader.fault(span.clone(), format!("no link has a name like \"{pattern}\""), help);
            names.broken = true;
        }
    }
    let without = |body: &str| patterns.iter().any(|(pattern, _)| WildMatch::new(pattern).matches(body));
    let (path, open) = (entry.word("urdf").unwrap_or_default(), entry.flag("open").unwrap_or(false));
    if let Some(element) = entry.text("obstacles").filter(|_| shapes.is_empty()) {
        let others = if element == LINK_SHAPES[0] { LINK_SHAPES[1] } else { LINK_SHAPES[0] };
        names.file_notes.push(format!(
            "mechanism \"{mechanism}\": no link of {path} has a <{element}> shape, so none is an obstacle; if the \
             links have <{others}> shapes, write obstacles = \"{others}\""
        ));
    }
    let mut found = Vec::new();
    for shape in shapes.into_iter().filter(|shape| !without(&bodies[shape.link])) {
        let link = &bodies[shape.link];
        let first = format!("{mechanism}/{link}");
        let mut all = std::iter::once(first.clone()).chain((2..).map(|count: usize| format!("{first} {count}")));
        let name = all.find(|name| !names.obstacles.contains_key(name.as_str())).unwrap_or(first);
        let (kind, parameters, file) = match shape.form {
            LinkForm::Solid { kind, parameters } => (kind, parameters, None),
            LinkForm::Mesh { path: name, scale } => {
                let Some(bytes) = entry.reader.bytes(&name, entry.span_of("urdf")) else {
                    names.broken = true;
                    continue;
                };
                let parameters = Parameters(BTreeMap::from([("open".to_owned(), Value::Flag(open))]));
                ("mesh", parameters, Some(ShapeFile { name, bytes, scale }))
            }
        };
        let index = names.obstacles.len();
        names.obstacles.insert(name.clone().into(), index);
        let mount = Mount { mechanism: names.mechanisms.len() - 1, body: shape.link };
        names.mounted_obstacles.insert(index);
        let label = format!("{path}:{}: link \"{link}\"", shape.row);
        let placed = Placed { name, label: label.clone(), pose: shape.pose, mount: Some(mount) };
        let chosen = Chosen { name: kind.to_owned(), kind: kind.to_owned(), parameters };
        match body(entry, chosen, file, placed, cables) {
            Ok(body) => found.push(body),
            Err(error) => {
                entry.reader.fault(entry.span_of("urdf"), format!("{label}: {}", error.message), error.help);
                names.broken = true;
            }
        }
    }
    found
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
    let world = "joints are given in world coordinates; leave it out";
    for (key, help) in [
        ("position", world),
        ("tangent", world),
        ("up", world),
        ("orientation", world),
        ("drawn", "leave it out, and give each joint its own `drawn`"),
        ("obstacles", "leave it out, and give each shape as [[obstacles]] with `mount`"),
    ] {
        if entry.has(key) {
            entry.fault_at(key, format!("{} has `{key}` but no `urdf`", entry.label), help);
        }
    }
    let entries = entry.entries("joints");
    if entry.has("joints") && entries.is_empty() {
        entry.fault_at("joints", format!("{} has no joints", entry.label), "give at least one [[mechanisms.joints]]");
    }
    let mut parts =
        Parts { bodies: vec![GROUND.to_owned()], joints: Vec::new(), spans: Vec::new(), shapes: Vec::new() };
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
    let drawn = if entry.has("drawn") { values(entry, "drawn", &kind)? } else { vec![0.0; kind.freedoms()] };
    let [a, b] = ends[..] else { return None };
    let (name, limits) = (name?.to_owned(), limits?);
    let joint = MechanismJoint { name, kind, bodies: [a, b], origin, drawn, limits, follows: None };
    let help =
        if entry.has("drawn") { WITHIN } else { "add `drawn`, with a value within its limits: the default is 0" };
    refuse_beyond(entry, "drawn", &joint, help);
    Some(joint)
}

/// The kind of a joint, with its axes; refuses those that it lacks, and those that it does not have.
fn kind(entry: &Entry<'_>, word: &str) -> Option<JointKind> {
    let needs: &[&str] = match word {
        "revolute" | "prismatic" | "cylindrical" => &["axis"],
        "screw" => &["axis", "pitch"],
        "universal" | "planar" => &["axis", "second_axis"],
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
        "planar" => {
            let (normal, second) = (axis?, second?);
            let Some(first) = Unit::try_new(second.into_inner() - normal.scale(normal.dot(&second)), PARALLEL) else {
                let message = format!("both axes of {} are parallel", entry.label);
                entry.fault_at("second_axis", message, "give a direction across the normal `axis`");
                return None;
            };
            JointKind::Planar([first, Unit::new_normalize(normal.cross(&first))])
        }
        "floating" => JointKind::Floating(Rotation::identity()),
        _ => JointKind::Fixed,
    })
}

/// Limits of every freedom.
fn limits(entry: &Entry<'_>, kind: &JointKind) -> Option<Vec<[f64; 2]>> {
    let freedoms = kind.freedoms();
    if !entry.has("limits") {
        return Some(vec![UNLIMITED; freedoms]);
    }
    let given = entry.values("limits");
    if freedoms == 1 {
        return Some(vec![pair(entry, given, kind, 0)?]);
    }
    let lists: Vec<&[Node<'_>]> = given
        .iter()
        .filter_map(|node| if let DeValue::Array(list) = node.get_ref() { Some(list.as_ref()) } else { None })
        .collect();
    if freedoms == 0 || lists.len() != freedoms || lists.len() != given.len() {
        let message = format!("`limits` of {} are not those of {freedoms} freedoms", entry.label);
        let help = "give a list with a smallest and a largest value for each freedom, such as \
                    [[\"-90 deg\", \"90 deg\"], [\"0 mm\", \"50 mm\"]], with [] where there are none";
        entry.fault_at("limits", message, if freedoms == 0 { "leave them out" } else { help });
        return None;
    }
    let of = |(freedom, list): (usize, &&[Node<'_>])| {
        if list.is_empty() { Some(UNLIMITED) } else { pair(entry, list, kind, freedom) }
    };
    lists.iter().enumerate().map(of).collect()
}

/// What is right for a joint that is drawn beyond its limits.
const WITHIN: &str = "draw it within its limits";

/// Refuses values as drawn, 0 by default, that are beyond the limits of their joint.
fn refuse_beyond(entry: &Entry<'_>, key: &str, joint: &MechanismJoint, help: &str) {
    for (freedom, (value, [low, high])) in joint.drawn.iter().zip(&joint.limits).enumerate() {
        if !(low..=high).contains(&value) {
            let [value, low, high] = [value, low, high].map(|value| shown(&joint.kind, freedom, *value));
            let message = format!("joint \"{}\" is drawn at {value}, and its limits are {low} and {high}", joint.name);
            entry.fault_at(key, message, help);
        }
    }
}

/// Smallest and largest value of a freedom.
fn pair(entry: &Entry<'_>, given: &[Node<'_>], kind: &JointKind, freedom: usize) -> Option<[f64; 2]> {
    let [low, high] = given else {
        let message = format!("{} has {} limits", entry.label, given.len());
        entry.fault_at("limits", message, "give the smallest and the largest value, such as [\"0 deg\", \"80 deg\"]");
        return None;
    };
    let [low, high] = [low, high].map(|node| entry.reader.number("limits", node, quantity(kind, freedom), ANY));
    let (low, high) = (low?, high?);
    if low > high {
        let [low, high] = [low, high].map(|value| shown(kind, freedom, value));
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
    let mut given: BTreeMap<&str, Entry<'_>> = BTreeMap::new();
    for own in entry.entries("drawn") {
        let Some(joint) = own.word("joint") else { continue };
        if given.contains_key(joint) {
            own.fault_at("joint", format!("joint \"{joint}\" has two values as drawn"), "give one");
        } else {
            given.insert(joint, own);
        }
    }
    let drawn = |joint: &str, kind: &JointKind| given.get(joint).and_then(|own| values(own, "value", kind));
    match urdf::read(&text, path, &base, entry.choice("obstacles"), &drawn) {
        Ok(urdf::Robot { links, joints, shapes }) => {
            for (name, own) in &given {
                match joints.iter().find(|joint| joint.name == *name) {
                    Some(joint) if joint.follows.is_none() => refuse_beyond(own, "value", joint, WITHIN),
                    Some(_) => own.fault_at("joint", format!("joint \"{name}\" follows another one"), "leave it out"),
                    None => {
                        let help = did_you_mean(name, joints.iter().map(|joint| joint.name.as_str()));
                        own.fault_at("joint", format!("{path} has no joint \"{name}\""), help);
                    }
                }
            }
            for joint in joints.iter().filter(|joint| !given.contains_key(joint.name.as_str())) {
                let help = match joint.follows {
                    Some(_) => "draw the joint that it follows so that both are within their limits",
                    None => "give it a value within its limits in `drawn`: the default is 0",
                };
                refuse_beyond(entry, "drawn", joint, help);
            }
            let spans = vec![span; joints.len()];
            Some(Parts { bodies: links, joints, spans, shapes })
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
