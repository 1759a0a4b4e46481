//! The elements of a file: by their ids, with the units of their values, and with what is done with each.

use super::error::ImportError;
use super::findings::Findings;
use super::options::Selection;
use super::unit::{Quantity, Unit};
use super::usage::{Element, Use};
use super::xml::{Xml, child, child_text, ids, missing_at, number, place, position, text, title};
use roxmltree::NodeId;
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap, HashSet};
use wireloom_scenario::Places;

/// Names of a format: the parts of a value.
pub(super) struct Names {
    pub value: &'static str,
    pub unit: &'static str,
    /// Element of a segment.
    pub segment: &'static str,
}

/// The elements of a file.
pub(super) struct Elements<'a, 'i, 'f> {
    names: Names,
    pub ids: HashMap<&'a str, Xml<'a, 'i>>,
    /// Those that are known.
    pub units: HashMap<&'a str, Unit>,
    /// Broken references are findings, of which there may be very many.
    places: Places<'a>,
    /// Elements on which the computation depends: those that a reference has led to.
    pub used: RefCell<HashSet<NodeId>>,
    /// Elements that are kept, though they do not act.
    pub kept: HashSet<NodeId>,
    /// Elements of other modules than the chosen ones, beside those that modules name.
    pub left_out: HashSet<NodeId>,
    pub findings: &'f mut Findings,
}

impl<'a, 'i, 'f> Elements<'a, 'i, 'f> {
    /// Those of a text with this root.
    pub fn of(text: &'a str, root: Xml<'a, 'i>, names: Names, findings: &'f mut Findings) -> Result<Self, ImportError> {
        Ok(Self {
            names,
            ids: ids(root)?,
            units: HashMap::new(),
            places: Places::of(text),
            used: RefCell::default(),
            kept: HashSet::new(),
            left_out: HashSet::new(),
            findings,
        })
    }

    /// Notes that the computation depends on an element.
    pub fn mark(&self, node: Xml<'a, 'i>) {
        self.used.borrow_mut().insert(node.id());
    }

    /// The element that a child refers to, whatever it is.
    pub fn target(&self, node: Xml<'a, 'i>, name: &'static str) -> Option<Xml<'a, 'i>> {
        child_text(node, name).and_then(|reference| self.ids.get(reference).copied())
    }

    /// Notes that an element is kept, though it does not act.
    pub fn keep(&mut self, node: Xml<'a, 'i>) {
        self.kept.insert(node.id());
    }

    /// The unit in a child.
    pub fn unit(&self, node: Xml<'a, 'i>) -> Option<Unit> {
        let id = child_text(node, self.names.unit)?;
        let unit = self.units.get(id).copied()?;
        self.ids.get(id).into_iter().for_each(|unit| self.mark(*unit));
        Some(unit)
    }

    /// The element that `holder` refers to, on which the computation then depends; a fault of the reference is an error
    /// for the caller to return or report.
    pub fn follow(&self, holder: Xml<'a, 'i>, found: &str, expected: &[&str]) -> Result<Xml<'a, 'i>, ImportError> {
        let target = self.resolve(holder, found, expected)?;
        self.mark(target);
        Ok(target)
    }

    /// Likewise, where the computation does not depend on it yet.
    pub fn resolve(&self, holder: Xml<'a, 'i>, found: &str, expected: &[&str]) -> Result<Xml<'a, 'i>, ImportError> {
        let target = self.ids.get(found).copied();
        if let Some(target) = target.filter(|target| target.kinds().any(|kind| expected.contains(&kind))) {
            return Ok(target);
        }
        let (line, column) = place(&self.places, holder.range().start);
        let actual = match target {
            Some(target) => format!("it is that of a `{}`", target.class()),
            None => "nothing has it".to_owned(),
        };
        Err(ImportError::Reference { line, column, found: found.to_owned(), expected: expected.join("` or `"), actual })
    }

    /// Follows the reference in a child; a broken or missing one is an error.
    pub fn required(
        &self,
        node: Xml<'a, 'i>,
        name: &'static str,
        expected: &[&str],
        right: &str,
    ) -> Result<Xml<'a, 'i>, ImportError> {
        let at = || place(&self.places, node.range().start);
        let holder = child(node, name).ok_or_else(|| missing_at(at(), node, name, right))?;
        self.follow(holder, text(holder).unwrap_or_default(), expected)
    }

    /// Follows the reference in a child; a broken one is reported, with its consequence `then`.
    pub fn optional(
        &mut self,
        node: Xml<'a, 'i>,
        name: &'static str,
        expected: &[&str],
        then: &str,
    ) -> Option<Xml<'a, 'i>> {
        match self.required(node, name, expected, "it should refer to one") {
            Ok(target) => Some(target),
            Err(fault) => {
                self.findings.add(format!("{}: {fault}; {then}", title(node)));
                None
            }
        }
    }

    /// The value of a child in SI; reported and left out if its unit is unknown or of another quantity, or if the
    /// value is impossible.
    pub fn value(
        &mut self,
        node: Xml<'a, 'i>,
        name: &'static str,
        quantity: Quantity,
    ) -> Result<Option<f64>, ImportError> {
        self.value_within(node, name, quantity, quantity.range())
    }

    /// Likewise, with other limits.
    pub fn value_within(
        &mut self,
        node: Xml<'a, 'i>,
        name: &'static str,
        quantity: Quantity,
        [least, greatest]: [f64; 2],
    ) -> Result<Option<f64>, ImportError> {
        match child(node, name) {
            Some(holder) => self.amount(node, holder, quantity, [least, greatest]),
            None => Ok(None),
        }
    }

    /// The value in SI that stands in a child of a node.
    pub fn amount(
        &mut self,
        node: Xml<'a, 'i>,
        holder: Xml<'a, 'i>,
        quantity: Quantity,
        [least, greatest]: [f64; 2],
    ) -> Result<Option<f64>, ImportError> {
        let name = holder.name();
        let Some(amount) = child(holder, self.names.value) else {
            self.findings.add(format!("{}: {name} has no {}; left out", title(node), self.names.value));
            return Ok(None);
        };
        let amount = number(amount, f64::MAX)?;
        let unit_id = child_text(holder, self.names.unit).unwrap_or_default();
        let fault = match self.unit(holder) {
            Some(unit) if unit.quantity == quantity => {
                let value = amount * unit.size;
                if (least..=greatest).contains(&value) {
                    return Ok(Some(value));
                }
                format!("{name} is {amount}, which is impossible")
            }
            Some(unit) => {
                format!("{name} is {amount} of unit `{unit_id}`, a {}, not a {}", unit.quantity.word(), quantity.word())
            }
            None => {
                let (line, _) = place(&self.places, holder.range().start);
                format!("{name} is {amount} of the unknown unit `{unit_id}` (line {line})")
            }
        };
        self.findings.add(format!("{}: {fault}; left out", title(node)));
        Ok(None)
    }

    /// Quantity of the unit in a child.
    pub fn unit_of(&self, node: Xml<'a, 'i>, name: &'static str) -> Option<Quantity> {
        let unit = child(node, name).and_then(|holder| child_text(holder, self.names.unit))?;
        self.units.get(unit).map(|unit| unit.quantity)
    }

    /// Mass per length of a piece, kg/m; `None`, and reported, if it is impossible.
    pub fn per_length(&mut self, piece: Xml<'a, 'i>, mass: f64, length: f64) -> Option<f64> {
        let [least, greatest] = Quantity::MassPerLength.range();
        let density = mass / length;
        if (least..=greatest).contains(&density) {
            return Some(density);
        }
        self.findings.add(format!("{}: {mass} kg on a length of {length} m is impossible; left out", title(piece)));
        None
    }

    /// The segments of the harness: all of them, or those with wires of the chosen modules.
    pub fn of_harness(
        &mut self,
        root: Xml<'a, 'i>,
        mut segments: Vec<Xml<'a, 'i>>,
        selection: &Selection,
        with_wires: impl Iterator<Item = &'a str>,
    ) -> Result<Vec<Xml<'a, 'i>>, ImportError> {
        if segments.is_empty() {
            let (line, column) = position(root);
            return Err(ImportError::NoSegments { line, column, element: self.names.segment });
        }
        if *selection == Selection::All {
            return Ok(segments);
        }
        let with_wires: HashSet<&str> = with_wires.collect();
        for empty in segments.extract_if(.., |own| own.attribute("id").is_some_and(|id| !with_wires.contains(id))) {
            self.left_out.insert(empty.id());
            let id = empty.attribute("id").unwrap_or_default();
            self.findings.add_to("segments have no wires of the chosen modules; left out", id);
        }
        if segments.is_empty() { Err(ImportError::NoWires) } else { Ok(segments) }
    }

    /// The use that is made of each of these elements; parts of elements in use that are not read are reported.
    /// `left_out`: whether one belongs to other modules only; `needs`: whether it needs what it refers to.
    pub fn uses(
        &mut self,
        nodes: &[Xml<'a, 'i>],
        left_out: impl Fn(Xml<'a, 'i>) -> bool,
        needs: impl Fn(Xml<'a, 'i>) -> bool,
    ) -> Vec<Element> {
        let mut uses: Vec<Use> = nodes.iter().map(|node| self.usage(*node, &left_out)).collect();
        self.spread(nodes, &mut uses, needs);
        self.note_unread(nodes, &uses);
        let element = |(node, usage): (&Xml, Use)| {
            let id = node.attribute("id").unwrap_or_default().to_owned();
            Element { kind: node.class().to_owned(), id, usage }
        };
        nodes.iter().zip(uses).map(element).collect()
    }

    fn usage(&self, node: Xml<'a, 'i>, left_out: impl Fn(Xml<'a, 'i>) -> bool) -> Use {
        let used = self.used.borrow();
        let any = |set: &HashSet<NodeId>| node.descendants().any(|inner| set.contains(&inner.id()));
        match () {
            () if any(&used) => Use::Used,
            () if any(&self.kept) => Use::Kept,
            () if self.left_out.contains(&node.id()) || left_out(node) => Use::LeftOut,
            () => Use::NotRead,
        }
    }

    /// What only elements that are left out refer to is left out with them: nodes, points, part numbers.
    fn spread(&self, nodes: &[Xml<'a, 'i>], uses: &mut [Use], needs: impl Fn(Xml<'a, 'i>) -> bool) {
        let index: HashMap<NodeId, usize> = nodes.iter().enumerate().map(|(k, node)| (node.id(), k)).collect();
        let element_of = |node: &Xml| node.ancestors().find_map(|around| index.get(&around.id()).copied());
        let mut references: Vec<HashSet<usize>> = vec![HashSet::new(); nodes.len()];
        let mut referring = vec![0_usize; nodes.len()];
        for (k, node) in nodes.iter().enumerate().filter(|(_, node)| needs(**node)) {
            let leaves = node.descendants().filter_map(text);
            let targets = leaves.flat_map(str::split_whitespace).filter_map(|word| self.ids.get(word));
            for target in targets.filter_map(element_of) {
                if target != k && uses[target] == Use::NotRead && references[k].insert(target) {
                    referring[target] += 1;
                }
            }
        }
        let mut open: Vec<usize> = (0..nodes.len()).filter(|k| uses[*k] == Use::LeftOut).collect();
        while let Some(k) = open.pop() {
            for &target in &references[k] {
                referring[target] -= 1;
                if referring[target] == 0 {
                    uses[target] = Use::LeftOut;
                    open.push(target);
                }
            }
        }
    }

    /// Reports the parts of elements in use that nothing has read, and nothing within them either.
    fn note_unread(&mut self, nodes: &[Xml<'a, 'i>], uses: &[Use]) {
        let mut unread: BTreeMap<&str, usize> = BTreeMap::new();
        let in_use = |usage: &Use| matches!(usage, Use::Used | Use::Kept);
        for (element, _) in nodes.iter().zip(uses).filter(|(_, usage)| in_use(usage)) {
            let mut reached: HashSet<NodeId> = HashSet::from([element.id()]);
            for inner in element.descendants() {
                let id = inner.id();
                if inner.is_read() || self.kept.contains(&id) || self.used.borrow().contains(&id) {
                    for around in inner.ancestors() {
                        if !reached.insert(around.id()) {
                            break;
                        }
                    }
                }
            }
            for inner in element.descendants().filter(|inner| !reached.contains(&inner.id())) {
                // What stands in a part that is not read is told with it.
                if inner.parent().is_some_and(|around| reached.contains(&around.id())) {
                    *unread.entry(inner.class()).or_default() += 1;
                }
            }
        }
        for (name, count) in unread {
            self.findings.add_to("parts of elements that are not read", format!("{count} {name}"));
        }
    }
}

/// Parts that modules control.
#[derive(Default)]
pub(super) struct Chosen<'a> {
    /// Ids of the parts of the chosen modules.
    pub present: HashSet<&'a str>,
    /// Ids of the parts of all others.
    pub left_out: HashSet<&'a str>,
}

impl<'a> Chosen<'a> {
    /// Whether a part is left out: one of other modules only. What no module controls is in every car. A part within
    /// another one, such as a core of a cable, goes with it; a wire goes with its connection, too.
    pub fn leaves_out(&self, part: Xml<'a, '_>, connection: Option<Xml<'a, '_>>) -> bool {
        let around = part.ancestors().chain(connection);
        let ids: Vec<&str> = around.filter_map(|node| node.attribute("id")).collect();
        !ids.iter().any(|id| self.present.contains(id)) && ids.iter().any(|id| self.left_out.contains(id))
    }
}
