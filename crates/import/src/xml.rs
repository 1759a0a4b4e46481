//! The XML of a file, with a record of the elements that are read.

use super::error::ImportError;
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
    /// Whether the class of an element is its `xsi:type`.
    typed: bool,
}

/// Namespace of the attribute `type` that gives the class of an element.
const INSTANCE: &str = "http://www.w3.org/2001/XMLSchema-instance";

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
        Self { nodes: file.root().descendants().map(|_| Cell::new(false)).collect(), divided, typed: false }
    }

    /// Likewise, of a file whose elements have classes beside their names.
    pub fn with_classes(file: &roxmltree::Document) -> Self {
        Self { typed: true, ..Self::nothing_of(file) }
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

    /// Its class: the one that it states, if the format has classes, or else its name.
    pub fn class(self) -> &'a str {
        let stated = || self.node.attribute((INSTANCE, "type")).filter(|_| self.read.typed);
        stated().map_or(self.name(), |class| class.rsplit(':').next().unwrap_or(class))
    }

    /// Its class, and its name where that differs: a `Component` may say that it is a `PartOccurrence`.
    pub fn kinds(self) -> impl Iterator<Item = &'a str> {
        let (class, name) = (self.class(), self.name());
        std::iter::once(class).chain(Some(name).filter(|name| *name != class))
    }

    pub fn parent(self) -> Option<Self> {
        self.node.parent().map(|node| self.with(node))
    }

    /// Itself, and all around it.
    pub fn ancestors(self) -> impl Iterator<Item = Self> + Clone + use<'a, 'i> {
        self.node.ancestors().map(move |node| self.with(node))
    }

    /// The elements in it.
    pub fn elements(self) -> impl Iterator<Item = Self> + Clone + use<'a, 'i> {
        self.node.children().filter(roxmltree::Node::is_element).map(move |node| self.with(node))
    }

    /// Itself, and all elements within it, in the order of the file.
    pub fn descendants(self) -> impl Iterator<Item = Self> + Clone + use<'a, 'i> {
        self.node.descendants().filter(roxmltree::Node::is_element).map(move |node| self.with(node))
    }

    /// Itself, recorded as read.
    pub fn seen(self) -> Self {
        self.read.nodes[self.node.id().get_usize()].set(true);
        self
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

/// The XML of a file with this root element.
pub fn xml<'t>(text: &'t str, format: &'static Root) -> Result<roxmltree::Document<'t>, ImportError> {
    if let Some((at, _)) = text.match_indices("xmlns").nth(NAMESPACES) {
        let (line, column) = place(&Places::of(text), at);
        return Err(ImportError::Xml { line, column, fault: format!("it declares more than {NAMESPACES} namespaces") });
    }
    let xml = roxmltree::Document::parse(text).map_err(|fault| {
        let at = fault.pos();
        ImportError::Xml { line: at.row, column: at.col, fault: fault.to_string() }
    })?;
    let root = xml.root_element();
    let found = root.tag_name().name();
    if found == format.element {
        return Ok(xml);
    }
    let at = xml.text_pos_at(root.range().start);
    let other = ROOTS.iter().find(|other| other.element == found);
    let help = other.map(|other| format!("; `wireloom import {}` reads {} files", other.command, other.format));
    Err(ImportError::Root {
        line: at.row,
        column: at.col,
        found: found.to_owned(),
        format: format.format,
        expected: format.element,
        help: help.unwrap_or_default(),
    })
}

/// The root element of a format.
pub struct Root {
    pub format: &'static str,
    pub element: &'static str,
    /// Name of the format on the command line.
    command: &'static str,
}

pub const KBL: Root = Root { format: "KBL", element: "KBL_container", command: "kbl" };
pub const VEC: Root = Root { format: "VEC", element: "VecContent", command: "vec" };
const ROOTS: [Root; 2] = [KBL, VEC];

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
    found.map(Xml::seen)
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

/// Class and id of an element, for findings and errors.
pub fn title(node: Xml) -> String {
    match node.attribute("id") {
        Some(id) => format!("{} `{id}`", node.class()),
        None => format!("{} (without id)", node.class()),
    }
}

/// The elements by their ids, which differ.
pub fn ids<'a, 'i>(root: Xml<'a, 'i>) -> Result<HashMap<&'a str, Xml<'a, 'i>>, ImportError> {
    let mut ids: HashMap<&str, Xml> = HashMap::new();
    for node in root.descendants() {
        if let Some(id) = node.attribute("id")
            && let Some(first) = ids.insert(id, node)
        {
            let ((line, column), (first_line, _)) = (position(node), position(first));
            return Err(ImportError::DuplicateId { line, column, id: id.to_owned(), first_line });
        }
    }
    Ok(ids)
}

/// The id of an element that others refer to.
pub fn id(node: Xml) -> Result<String, ImportError> {
    node.attribute("id").map(str::to_owned).ok_or_else(|| missing(node, "id", "every node and segment needs one"))
}

pub fn missing(node: Xml, what: &str, right: &str) -> ImportError {
    missing_at(position(node), node, what, right)
}

pub fn missing_at((line, column): (u32, u32), node: Xml, what: &str, right: &str) -> ImportError {
    ImportError::Missing { line, column, element: title(node), missing: what.to_owned(), right: right.to_owned() }
}

/// The number in an element: finite, no larger than `largest` in size.
pub fn number(node: Xml, largest: f64) -> Result<f64, ImportError> {
    let found = text(node).unwrap_or_default();
    match found.parse::<f64>() {
        Ok(value) if value.is_finite() && value.abs() <= largest => Ok(value),
        _ => {
            let (line, column) = position(node);
            let element = node.name().to_owned();
            let expected = format!("a finite decimal number of size {largest:e} or less");
            Err(ImportError::Number { line, column, element, found: found.to_owned(), expected })
        }
    }
}
