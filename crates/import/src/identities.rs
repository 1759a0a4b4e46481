//! Identities of the parts of the scenario, components that do not act, and wires with what they connect.

use super::document::{Document, End, Listed, ListedPlace, Location, Wiring};
use super::harness::Constraint;
use super::names::Names;
use std::collections::{HashMap, HashSet};
use wireloom_core::identity::{Component, Connection, Identities, Identity, WireEnd};

/// What is kept of a file though it does not act.
pub(super) struct Kept {
    /// Identity of each constraint.
    pub constraints: Vec<Identity>,
    /// Components and connections.
    pub identities: Identities,
    /// XML ids of the occurrences that act as constraints.
    pub acting: HashSet<String>,
}

/// Names of the scenario by XML id.
struct Known<'a> {
    vertices: HashMap<&'a str, &'a str>,
    /// Names and lengths, m.
    branches: HashMap<&'a str, (&'a str, f64)>,
    /// Connectors and other components.
    components: HashMap<&'a str, String>,
}

/// Names everything that the file lists; `names` are those of the constraints, `branches` names and lengths, m.
pub(super) fn keep(
    document: &Document,
    constraints: &[Constraint],
    mut names: Names,
    vertices: &[String],
    branches: &[(String, f64)],
) -> Kept {
    let of: HashMap<&str, usize> =
        constraints.iter().enumerate().filter_map(|(k, own)| Some((own.of.as_deref()?, k))).collect();
    let constraint_of = |listed: &Listed| listed.ids.iter().find_map(|id| of.get(id.as_str()).copied());
    let mut known = Known {
        vertices: (document.nodes.iter().zip(vertices)).map(|(node, name)| (node.id.as_str(), name.as_str())).collect(),
        branches: (document.segments.iter().zip(branches))
            .map(|(segment, (name, length))| (segment.id.as_str(), (name.as_str(), *length)))
            .collect(),
        components: HashMap::new(),
    };
    let mut kept = Kept {
        constraints: vec![Identity::default(); constraints.len()],
        identities: Identities::default(),
        acting: HashSet::new(),
    };
    // First all names, as components refer to each other.
    let mut own = Vec::new();
    for listed in &document.listed {
        let name = match constraint_of(listed) {
            Some(k) => {
                kept.constraints[k] = listed.identity.clone();
                kept.acting.insert(listed.id.clone());
                constraints[k].name.clone()
            }
            None => {
                let name = names.take(&listed.label, &listed.id);
                own.push((listed, name.clone()));
                name
            }
        };
        known.components.extend(listed.ids.iter().map(|id| (id.as_str(), name.clone())));
        known.components.insert(listed.id.as_str(), name);
    }
    for (listed, name) in own {
        kept.identities.components.extend(known.components_of(listed, name, &mut names));
    }
    let mut names = Names::default();
    kept.identities.connections = document.wiring.iter().map(|wiring| known.connection(wiring, &mut names)).collect();
    kept
}

impl Known<'_> {
    /// A component for each place of an occurrence; one without a place has one, too.
    fn components_of(&self, listed: &Listed, name: String, names: &mut Names) -> Vec<Component> {
        let bare = Component {
            name: name.clone(),
            kind: Some(listed.kind.clone()),
            identity: listed.identity.clone(),
            connector: None,
            cavity: None,
            vertex: None,
            branch: None,
            from: None,
            to: None,
        };
        let mut all = Vec::new();
        for place in &listed.places {
            let Some(mut placed) = self.placed(bare.clone(), place) else { continue };
            if !all.is_empty() {
                placed.name = names.unique(&name);
            }
            all.push(placed);
        }
        if all.is_empty() {
            all.push(bare);
        }
        all
    }

    /// The component at a place; `None` if the place is not in the scenario.
    fn placed(&self, component: Component, place: &ListedPlace) -> Option<Component> {
        match place {
            ListedPlace::Node(id) => {
                let vertex = Some((*self.vertices.get(id.as_str())?).to_owned());
                Some(Component { vertex, ..component })
            }
            ListedPlace::Segment { id, from, to } => {
                let (branch, length) = *self.branches.get(id.as_str())?;
                let at = |location: Option<Location>| {
                    let s = location?.fraction(length) * length;
                    (0.0..=length * (1.0 + 1e-9)).contains(&s).then(|| s.min(length))
                };
                let [from, to] = [at(*from), at(*to)];
                // Some files give the ends of a covering in the other order.
                let turned = from.zip(to).is_some_and(|(from, to)| to < from);
                let (from, to) = if turned { (to, from) } else { (from, to) };
                Some(Component { branch: Some(branch.to_owned()), from, to, ..component })
            }
            ListedPlace::In { component: id, cavity } => {
                let connector = Some(self.components.get(id.as_str())?.clone());
                Some(Component { connector, cavity: cavity.clone(), ..component })
            }
        }
    }

    fn connection(&self, wiring: &Wiring, names: &mut Names) -> Connection {
        let clean = |text: &str| !text.is_empty() && !text.chars().any(char::is_control);
        let name = names.unique(if clean(&wiring.label) { &wiring.label } else { "" });
        let run = wiring.segments.iter().filter_map(|id| self.branches.get(id.as_str()));
        let length = run.clone().map(|(_, length)| length).sum();
        Connection {
            name,
            signal: wiring.signal.clone(),
            identity: wiring.identity.clone(),
            wire: wiring.number.clone(),
            ends: wiring.ends.iter().map(|end| self.end(end)).collect(),
            branches: run.map(|(name, _)| (*name).to_owned()).collect(),
            length,
        }
    }

    fn end(&self, end: &End) -> WireEnd {
        let connector = end.within.iter().find_map(|id| self.components.get(id.as_str()).cloned());
        let End { cavity, terminal, seal, .. } = end;
        // A cavity has a meaning in its connector only.
        let cavity = cavity.clone().filter(|_| connector.is_some());
        WireEnd { connector, cavity, terminal: terminal.clone(), seal: seal.clone() }
    }
}
