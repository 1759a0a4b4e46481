//! The elements of a URDF file, and what is wrong with them.

use crate::format::limits::ANY;
use roxmltree::{Document, Node};
use std::borrow::Cow;
use wireloom_core::{Pose, Quantity, Rotation, Vector};

/// A fault of the file, with its line.
pub struct UrdfFault {
    pub message: String,
    pub help: Cow<'static, str>,
}

/// A file that is being read.
pub struct File<'f> {
    pub document: &'f Document<'f>,
    /// Path of the file, from the folder of the scenario.
    pub path: &'f str,
    pub faults: Vec<UrdfFault>,
}

impl<'f> File<'f> {
    pub fn fault(&mut self, node: Node<'_, '_>, message: impl Into<String>, help: impl Into<Cow<'static, str>>) {
        let row = self.document.text_pos_at(node.range().start).row;
        self.faults.push(UrdfFault { message: format!("{row}: {}", message.into()), help: help.into() });
    }

    pub fn attribute(&mut self, node: Node<'f, 'f>, name: &str) -> Option<&'f str> {
        let value = node.attribute(name).filter(|value| !value.is_empty());
        if value.is_none() {
            let message = format!("<{}> has no `{name}`", node.tag_name().name());
            self.fault(node, message, "add the attribute");
        }
        value
    }

    /// Its `<origin>`: the identity if it is left out.
    pub fn origin(&mut self, node: Node<'f, 'f>) -> Option<Pose> {
        let Some(element) = child(node, "origin") else { return Some(Pose::identity()) };
        let position = self.vector(element, "xyz", Quantity::Length)?.unwrap_or_default();
        let angles = self.vector(element, "rpy", Quantity::Angle)?.unwrap_or_default();
        // Fixed axes: roll about x, then pitch about y, then yaw about z.
        Some(Pose { position, orientation: Rotation::from_euler_angles(angles.x, angles.y, angles.z) })
    }

    /// Three numbers of an attribute; `Some(None)` if it is left out.
    pub fn vector(&mut self, node: Node<'f, 'f>, name: &str, quantity: Quantity) -> Option<Option<Vector>> {
        let Some(text) = node.attribute(name) else { return Some(None) };
        let numbers: Vec<f64> = text.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN)).collect();
        let [x, y, z] = numbers[..] else {
            let help = "write three numbers, such as \"0 0 0.1\"";
            self.fault(node, format!("{name}=\"{text}\" is not three numbers"), help);
            return None;
        };
        let within = numbers.iter().all(|x| self.within(node, (name, text), *x, quantity));
        within.then_some(Some(Vector::new(x, y, z)))
    }

    pub fn number(&mut self, node: Node<'f, 'f>, name: &str, quantity: Quantity) -> Option<Option<f64>> {
        let Some(text) = node.attribute(name) else { return Some(None) };
        let number = text.trim().parse().unwrap_or(f64::NAN);
        self.within(node, (name, text), number, quantity).then_some(Some(number))
    }

    /// Whether a number of an attribute is one that its quantity can have.
    pub fn within(&mut self, node: Node<'f, 'f>, (name, text): (&str, &str), x: f64, quantity: Quantity) -> bool {
        let limits = ANY.of(quantity);
        let within = (limits.minimum..=limits.maximum).contains(&x);
        if !within {
            let what = if x.is_nan() { "has what is not a number" } else { "is out of range" };
            let help = format!("write numbers {}", limits.words(quantity));
            self.fault(node, format!("{name}=\"{text}\" {what}"), help);
        }
        within
    }
}

/// The first element of this name in a node.
pub fn child<'f>(node: Node<'f, 'f>, tag: &str) -> Option<Node<'f, 'f>> {
    node.children().find(|child| child.has_tag_name(tag))
}
