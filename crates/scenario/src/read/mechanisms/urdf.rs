//! Joints and links of a URDF file, the description of robots (<https://wiki.ros.org/urdf/XML>): a tree of links, each
//! joint with its origin in the frame of its parent link.
//!
//! The file gives its joints at 0; the scenario may draw it with other values. Masses and transmissions are not read,
//! shapes of links only where the scenario asks for them ([`shapes`]).

mod file;
pub(super) mod shapes;

use crate::read::freedoms::{UNLIMITED, quantity};
use file::{File, UrdfFault, child};
use nalgebra::Unit;
use roxmltree::{Document, Node};
use shapes::LinkShape;
use wireloom_core::mechanism::{JointKind, MechanismJoint};
use wireloom_core::rotation::orthogonal;
use wireloom_core::{Pose, Quantity, Rotation, Vector};

/// A joint as the file gives it.
struct Given<'f> {
    node: Node<'f, 'f>,
    name: &'f str,
    parent: &'f str,
    child: &'f str,
    /// In the frame of the parent.
    origin: Pose,
}

impl Given<'_> {
    fn has_one_freedom(&self) -> bool {
        self.node.attribute("type").is_some_and(|kind| ["revolute", "continuous", "prismatic"].contains(&kind))
    }
}

/// What a file describes, in world coordinates.
pub(super) struct Robot {
    /// Names of the links, the root first.
    pub links: Vec<String>,
    pub joints: Vec<MechanismJoint>,
    pub shapes: Vec<LinkShape>,
}

/// Values of a joint as drawn, where the scenario gives them.
type Drawn<'d> = &'d dyn Fn(&str, &JointKind) -> Option<Vec<f64>>;

/// Reads the file at `path`, with the root at `base` and the joints as drawn; `shapes`: the element of the links'
/// shapes that are wanted, if any.
pub(super) fn read(
    text: &str,
    path: &str,
    base: &Pose,
    shapes: Option<&str>,
    drawn: Drawn<'_>,
) -> Result<Robot, Vec<UrdfFault>> {
    let document = Document::parse(text).map_err(|error| {
        let (at, help) = (error.pos(), "a URDF file is XML with the element <robot>; write out xacro files first");
        vec![UrdfFault { message: format!("{}: {error}", at.row), help: help.into() }]
    })?;
    let mut file = File { document: &document, path, faults: Vec::new() };
    let read = file.read(base, shapes, drawn);
    match read {
        Some(read) if file.faults.is_empty() => Ok(read),
        _ => Err(file.faults),
    }
}

impl<'f> File<'f> {
    fn read(&mut self, base: &Pose, shapes: Option<&str>, drawn: Drawn<'_>) -> Option<Robot> {
        let robot = self.document.root_element();
        if robot.tag_name().name() != "robot" {
            self.fault(robot, format!("<{}> is not <robot>", robot.tag_name().name()), "give a URDF file");
            return None;
        }
        let elements = |tag: &'static str| robot.children().filter(move |node| node.has_tag_name(tag));
        let mut links: Vec<&'f str> = Vec::new();
        let mut nodes = Vec::new();
        for link in elements("link") {
            let Some(name) = self.attribute(link, "name") else { continue };
            if links.contains(&name) {
                self.fault(link, format!("there are two links \"{name}\""), "give each a name of its own");
            }
            links.push(name);
            nodes.push((name, link));
        }
        let mut given: Vec<Given<'f>> = Vec::new();
        for joint in elements("joint") {
            let Some(joint) = self.given(joint, &links) else { continue };
            if given.iter().any(|other| other.name == joint.name) {
                self.fault(
                    joint.node,
                    format!("there are two joints \"{}\"", joint.name),
                    "give each a name of its own",
                );
            }
            if let Some(other) = given.iter().find(|other| other.child == joint.child) {
                let message = format!("link \"{}\" is the child of joint \"{}\" too", joint.child, other.name);
                self.fault(joint.node, message, "a URDF file is a tree: each link is the child of one joint at most");
            }
            given.push(joint);
        }
        if given.is_empty() && self.faults.is_empty() {
            self.fault(robot, "there are no joints", "a mechanism has at least one");
        }
        if !self.faults.is_empty() {
            return None;
        }
        let roots: Vec<&'f str> =
            links.iter().copied().filter(|link| given.iter().all(|joint| joint.child != *link)).collect();
        let root = match roots[..] {
            [root] => root,
            [] => {
                self.fault(robot, "there is no root: every link is the child of a joint", "leave one joint out");
                return None;
            }
            [_, other, ..] => {
                self.fault(robot, format!("link \"{other}\" is the child of no joint"), "one link alone is the root");
                return None;
            }
        };
        links.sort_by_key(|link| *link != root);
        let kinds: Vec<JointKind> = given.iter().filter_map(|own| self.kind(own)).collect();
        if kinds.len() < given.len() {
            return None;
        }
        let follows: Vec<_> = given.iter().map(|own| self.follows(own, &given)).collect();
        let values = values(&given, &kinds, &follows, drawn);
        let mut frames: Vec<Option<Pose>> = vec![None; links.len()];
        frames[0] = Some(*base);
        let at = |link: &str| links.iter().position(|other| *other == link);
        let mut joints: Vec<Option<MechanismJoint>> = vec![None; given.len()];
        // Links from the root outwards; a joint may come before that of its parent.
        while let Some(k) =
            (0..given.len()).find(|k| joints[*k].is_none() && at(given[*k].parent).is_some_and(|p| frames[p].is_some()))
        {
            let own = &given[k];
            let bodies = [at(own.parent)?, at(own.child)?];
            let at_zero = frames[bodies[0]]?.compose(&own.origin);
            let mut joint = MechanismJoint {
                name: own.name.to_owned(),
                kind: turned(&kinds[k], &at_zero.orientation),
                bodies,
                origin: at_zero.position,
                drawn: vec![0.0; kinds[k].freedoms()],
                limits: self.limits(own, &kinds[k]),
                follows: follows[k].map(|(of, factor, _)| (of, factor)),
            };
            let frame = joint.motion(&values[k]).compose(&at_zero);
            frames[bodies[1]] = Some(frame);
            (joint.origin, joint.drawn) = (frame.position, values[k].clone());
            joints[k] = Some(joint);
        }
        let Some(joints) = joints.into_iter().collect() else {
            self.fault(robot, "some joints form a ring that hangs on no root", "a URDF file is a tree");
            return None;
        };
        let shapes = match shapes {
            Some(element) => nodes
                .into_iter()
                .flat_map(|(name, node)| Some(self.shapes(node, element, at(name)?, &frames[at(name)?]?)))
                .flatten()
                .collect(),
            None => Vec::new(),
        };
        Some(Robot { links: links.into_iter().map(str::to_owned).collect(), joints, shapes })
    }

    fn given(&mut self, node: Node<'f, 'f>, links: &[&'f str]) -> Option<Given<'f>> {
        let name = self.attribute(node, "name");
        let mut link = |tag: &'static str| {
            let Some(element) = child(node, tag) else {
                self.fault(node, format!("<joint> has no <{tag}>"), "add it, with the name of a link");
                return None;
            };
            let link = self.attribute(element, "link")?;
            if !links.contains(&link) {
                self.fault(element, format!("there is no link \"{link}\""), "give the name of a <link> of the file");
                return None;
            }
            Some(link)
        };
        let (parent, child_link) = (link("parent"), link("child"));
        let origin = self.origin(node)?;
        Some(Given { node, name: name?, parent: parent?, child: child_link?, origin })
    }

    /// Kind of a joint, with its axis in the frame of the joint.
    fn kind(&mut self, own: &Given<'f>) -> Option<JointKind> {
        let axis = match child(own.node, "axis") {
            None => Vector::x(),
            Some(element) => self.vector(element, "xyz", Quantity::Dimensionless)?.unwrap_or_else(Vector::x),
        };
        let mut axis = || {
            let unit = Unit::try_new(axis, 1e-12);
            if unit.is_none() {
                self.fault(own.node, "the axis is zero", "give a direction, such as xyz=\"0 0 1\"");
            }
            unit
        };
        match own.node.attribute("type").unwrap_or_default() {
            "fixed" => Some(JointKind::Fixed),
            "revolute" | "continuous" => axis().map(JointKind::Revolute),
            "prismatic" => axis().map(JointKind::Prismatic),
            "planar" => axis().map(|normal| {
                // The format says nothing of directions in the plane: for the usual normal z they are x and y.
                let first = Unit::new_normalize(orthogonal(&normal));
                JointKind::Planar([first, Unit::new_normalize(normal.cross(&first))])
            }),
            "floating" => Some(JointKind::Floating(Rotation::identity())),
            other => {
                let message = format!("joint \"{}\" has the type \"{other}\"", own.name);
                let help = "fixed, revolute, continuous, prismatic, planar and floating joints are known; give others \
                            as [[mechanisms.joints]]";
                self.fault(own.node, message, help);
                None
            }
        }
    }

    /// Limits of its freedoms: those of one; a continuous joint has none.
    fn limits(&mut self, own: &Given<'f>, kind: &JointKind) -> Vec<[f64; 2]> {
        let none = vec![UNLIMITED; kind.freedoms()];
        let limit = match child(own.node, "limit") {
            Some(limit) if kind.freedoms() == 1 && own.node.attribute("type") != Some("continuous") => limit,
            _ => return none,
        };
        let [low, high] = ["lower", "upper"].map(|name| self.number(limit, name, quantity(kind, 0)));
        let (Some(low), Some(high)) = (low, high) else { return none };
        // Left out, they are 0, says the format.
        let (low, high) = (low.unwrap_or(0.0), high.unwrap_or(0.0));
        if low > high {
            self.fault(limit, format!("lower=\"{low}\" is above upper=\"{high}\""), "give the smaller one as `lower`");
        }
        vec![[low, high]]
    }

    /// The joint that it follows, the factor and the offset.
    fn follows(&mut self, own: &Given<'f>, given: &[Given<'f>]) -> Option<(usize, f64, f64)> {
        let mimic = child(own.node, "mimic")?;
        let name = self.attribute(mimic, "joint")?;
        let (factor, offset) = (
            self.number(mimic, "multiplier", Quantity::Dimensionless)?,
            self.number(mimic, "offset", Quantity::Dimensionless)?,
        );
        let of = given.iter().position(|other| other.name == name);
        let leads = |of: usize| given[of].has_one_freedom() && child(given[of].node, "mimic").is_none();
        if !own.has_one_freedom() || !of.is_some_and(leads) {
            let message = format!("joint \"{}\" mimics in a way that is not known here", own.name);
            let help = "a joint with one freedom may follow one that has one too and follows no other one";
            self.fault(mimic, message, help);
            return None;
        }
        Some((of?, factor.unwrap_or(1.0), offset.unwrap_or(0.0)))
    }
}

/// Values of all joints as drawn: those of the scenario, else 0; a joint that follows has what follows from the other
/// one.
fn values(
    given: &[Given<'_>],
    kinds: &[JointKind],
    follows: &[Option<(usize, f64, f64)>],
    drawn: Drawn<'_>,
) -> Vec<Vec<f64>> {
    let own = |((own, kind), follows): ((&Given<'_>, &JointKind), &Option<_>)| {
        let chosen = if follows.is_some() { None } else { drawn(own.name, kind) };
        chosen.unwrap_or_else(|| vec![0.0; kind.freedoms()])
    };
    let mut values: Vec<Vec<f64>> = given.iter().zip(kinds).zip(follows).map(own).collect();
    for (k, follows) in follows.iter().enumerate() {
        if let Some((of, factor, offset)) = *follows {
            values[k] = vec![factor * values[of][0] + offset];
        }
    }
    values
}

/// A kind with its axes turned.
fn turned(kind: &JointKind, by: &Rotation) -> JointKind {
    match kind {
        JointKind::Revolute(axis) => JointKind::Revolute(by * axis),
        JointKind::Prismatic(axis) => JointKind::Prismatic(by * axis),
        JointKind::Planar([first, second]) => JointKind::Planar([by * first, by * second]),
        JointKind::Floating(axes) => JointKind::Floating(by * axes),
        other => *other,
    }
}
