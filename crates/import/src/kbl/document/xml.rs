//! The XML of a file, with a record of the elements that are read.

use crate::kbl::error::ImportError;
use roxmltree::NodeId;
use std::cell::Cell;
use std::collections::HashMap;
use std::ops::Deref;
use wireloom_scenario::Places;

/// Largest number of namespaces: good files have one or two, and each makes all elements within it slower to read.
const NAMESPACES: usize = 100;

/// A node of the XML. What [`children`] finds is recorded as read.
#[derive(Clone, Copy)]
pub struct Xml<'a, 'i> {
    node: roxmltree::Node<'a, 'i>,
    read: &'a Read,
}

/// What is known of the nodes of a file beside their XML.
pub struct Read {
    /// Whether they are read, by index.
    nodes: Vec<Cell<bool>>,
    /// The whole text of elements in which comments or processing instructions divide it.
    divided: HashMap<NodeId, String>,
}

impl Read {
    /// Of a file of which nothing is read yet.
    pub fn nothing_of(file: &roxmltree::Document) -> Self {
        let divides = |node: roxmltree::Node| node.is_comment() || node.is_pi();
        let whole = |node: roxmltree::Node| {
            node.children().filter(|part| part.is_text()).filter_map(|part| part.text()).collect()
        };
        let divided = file
            .root()
            .descendants()
            .filter(|node| node.is_element() && node.children().any(divides))
            .map(|node| (node.id(), whole(node)))
            .collect();
        Self { nodes: file.root().descendants().map(|_| Cell::new(false)).collect(), divided }
    }
}

impl<'a, 'i> Xml<'a, 'i> {
    /// The root element.
    pub fn root(file: &'a roxmltree::Document<'i>, read: &'a Read) -> Self {
        Self { node: file.root_element(), read }
    }

    fn with(self, node: roxmltree::Node<'a, 'i>) -> Self {
        Self { node, ..self }
    }

    /// Its name, without a prefix.
    pub fn name(self) -> &'a str {
        self.node.tag_name().name()
    }

    pub fn parent(self) -> Option<Self> {
        self.node.parent().map(|node| self.with(node))
    }

    /// Itself, and all around it.
    pub fn ancestors(self) -> impl Iterator<Item = Self> + Clone + use<'a, 'i> {
        self.node.ancestors().map(move |node| self.with(node))
    }

    /// Itself, and what it stands in, below the harness and the container.
    pub fn around(self) -> impl Iterator<Item = Self> + Clone + use<'a, 'i> {
        self.ancestors().take_while(|node| !["Harness", "KBL_container"].contains(&node.name()))
    }

    /// The elements in it.
    pub fn elements(self) -> impl Iterator<Item = Self> + Clone + use<'a, 'i> {
        self.node.children().filter(roxmltree::Node::is_element).map(move |node| self.with(node))
    }

    /// Itself, and all elements within it, in the order of the file.
    pub fn descendants(self) -> impl Iterator<Item = Self> + Clone + use<'a, 'i> {
        self.node.descendants().filter(roxmltree::Node::is_element).map(move |node| self.with(node))
    }

    pub fn is_read(self) -> bool {
        self.read.nodes[self.node.id().get_usize()].get()
    }
}

impl<'a, 'i> Deref for Xml<'a, 'i> {
    type Target = roxmltree::Node<'a, 'i>;

    fn deref(&self) -> &Self::Target {
        &self.node
    }
}

/// The XML of a KBL file.
pub fn xml(text: &str) -> Result<roxmltree::Document<'_>, ImportError> {
    if let Some((at, _)) = text.match_indices("xmlns").nth(NAMESPACES) {
        let (line, column) = place(&Places::of(text), at);
        return Err(ImportError::Xml { line, column, fault: format!("it declares more than {NAMESPACES} namespaces") });
    }
    let xml = roxmltree::Document::parse(text).map_err(|fault| {
        let at = fault.pos();
        ImportError::Xml { line: at.row, column: at.col, fault: fault.to_string() }
    })?;
    let root = xml.root_element();
    if root.tag_name().name() != "KBL_container" {
        let at = xml.text_pos_at(root.range().start);
        let found = root.tag_name().name().to_owned();
        return Err(ImportError::NotKbl { line: at.row, column: at.col, found });
    }
    Ok(xml)
}

pub fn position(node: Xml) -> (u32, u32) {
    let at = node.document().text_pos_at(node.range().start);
    (at.row, at.col)
}

/// Line and column of a byte, for errors.
pub fn place(places: &Places<'_>, at: usize) -> (u32, u32) {
    let (line, column) = places.position(at);
    (line as u32, column as u32)
}

/// The elements of a name in a node.
pub fn children<'a, 'i>(node: Xml<'a, 'i>, name: &'static str) -> impl Iterator<Item = Xml<'a, 'i>> + use<'a, 'i> {
    let found = node.elements().filter(move |child| child.name() == name);
    found.inspect(|child| child.read.nodes[child.id().get_usize()].set(true))
}

pub fn child<'a, 'i>(node: Xml<'a, 'i>, name: &'static str) -> Option<Xml<'a, 'i>> {
    children(node, name).next()
}

/// Trimmed text of an element; `None` if it is empty or `/NULL`, as some exporters write.
pub fn text<'a>(node: Xml<'a, '_>) -> Option<&'a str> {
    let whole = node.read.divided.get(&node.id()).map(String::as_str);
    whole.or_else(|| node.text()).map(str::trim).filter(|text| !text.is_empty() && *text != "/NULL")
}

pub fn child_text<'a>(node: Xml<'a, '_>, name: &'static str) -> Option<&'a str> {
    child(node, name).and_then(text)
}

/// The words of all elements of a name in a node.
pub fn words<'a, 'i>(node: Xml<'a, 'i>, name: &'static str) -> impl Iterator<Item = &'a str> + use<'a, 'i> {
    children(node, name).filter_map(text).flat_map(str::split_whitespace)
}

/// Element name and id, for findings and errors.
pub fn title(node: Xml) -> String {
    match node.attribute("id") {
        Some(id) => format!("{} `{id}`", node.name()),
        None => format!("{} (without id)", node.name()),
    }
}

pub fn is_occurrence(node: &Xml) -> bool {
    node.name().ends_with("_occurrence")
}

/// Occurrences of parts, by the ids of these.
pub fn occurrences<'a, 'i>(root: Xml<'a, 'i>) -> HashMap<&'a str, Vec<Xml<'a, 'i>>> {
    let mut of: HashMap<&str, Vec<Xml>> = HashMap::new();
    for node in root.descendants().filter(is_occurrence) {
        if let Some(part) = child_text(node, "Part") {
            of.entry(part).or_default().push(node);
        }
    }
    of
}
