//! What an import has found, for pages: each place of a finding as a part of the scenario that was made, where it is
//! one.

use crate::frame::number;
use crate::protocol::{self, FindingItem, Place, Used};
use serde_json::Value as Json;
use std::collections::HashMap;
use wireloom::import::kbl::{ElementPlace, Imported};
use wireloom::scenario::record::as_json;

/// The findings and the use of the file `name`.
pub fn of(imported: &Imported, name: &str) -> protocol::Imported {
    let parts = Parts::of(imported);
    let item = |words: &String| FindingItem { words: words.clone(), place: parts.named_in(words) };
    let findings = imported.findings.iter();
    let used = |own: &wireloom::import::kbl::Usage| Used {
        kind: own.kind.clone(),
        total: number(own.total),
        used: number(own.used),
        kept: number(own.kept),
        left_out: number(own.left_out),
        not_read: number(own.not_read),
    };
    protocol::Imported {
        name: name.to_owned(),
        findings: findings
            .map(|own| protocol::Finding {
                what: own.what.clone(),
                items: own.items.iter().map(item).collect(),
                place: if own.items.is_empty() { parts.quoted_in(&own.what) } else { None },
            })
            .collect(),
        usage: imported.usage.iter().map(used).collect(),
    }
}

/// Places of the parts of a scenario.
#[derive(Default)]
struct Parts {
    /// Of constraints, by the XML ids of what they come from.
    constraint_ids: HashMap<String, Place>,
    /// Of branches, by the XML ids of what they come from.
    branch_ids: HashMap<String, Place>,
    /// Of constraints, vertices, branches, by name.
    names: HashMap<String, Place>,
    /// Of components at vertices, by name.
    components: HashMap<String, Place>,
    /// Of elements of the file, by XML id.
    elements: HashMap<String, Place>,
}

impl Parts {
    fn of(imported: &Imported) -> Self {
        let json = as_json(&imported.scenario).unwrap_or_default();
        let mut parts = Self::default();
        let mut vertices: HashMap<&str, Place> = HashMap::new();
        let mut branches: HashMap<&str, Place> = HashMap::new();
        for entry in list(&json, "branches") {
            let Some(name) = text(entry, "name") else { continue };
            let at = |s| Place { branch: Some(name.to_owned()), s, ..Place::default() };
            let ends = [("from", Some(0.0)), ("to", entry.get("length").and_then(Json::as_f64))];
            for (end, s) in ends {
                if let Some(vertex) = text(entry, end) {
                    vertices.entry(vertex).or_insert_with(|| at(s));
                }
            }
            branches.insert(name, at(None));
            parts.branch_ids.extend(text(entry, "kbl").map(|id| (id.to_owned(), at(None))));
        }
        // Steps add constraints by several operations.
        let operations = list(&json, "steps").filter_map(Json::as_object).flat_map(|step| step.values());
        let added = operations.filter_map(Json::as_array).flatten();
        let mut constraints = HashMap::new();
        for entry in list(&json, "constraints").chain(added) {
            let (Some(name), Some(at)) = (text(entry, "name"), entry.get("at")) else { continue };
            let branch = text(at, "branch").and_then(|branch| branches.get(branch));
            let s = at.get("s").and_then(Json::as_f64);
            let along = branch.map(|place| Place { s, ..place.clone() });
            let end = text(at, "end").and_then(|vertex| vertices.get(vertex).cloned());
            let place = Place { constraint: Some(name.to_owned()), ..along.or(end).unwrap_or_default() };
            parts.constraint_ids.extend(text(entry, "kbl").map(|id| (id.to_owned(), place.clone())));
            constraints.insert(name, place);
        }
        for entry in list(&json, "components") {
            let at = text(entry, "vertex").and_then(|vertex| vertices.get(vertex));
            parts.components.extend(text(entry, "name").zip(at).map(|(name, at)| (name.to_owned(), at.clone())));
        }
        let element = |place: &ElementPlace| match place {
            ElementPlace::Vertex(name) => vertices.get(name.as_str()).cloned(),
            ElementPlace::Branch(name) => branches.get(name.as_str()).cloned(),
        };
        let places = imported.places.iter();
        parts.elements = places.filter_map(|(id, place)| Some((id.clone(), element(place)?))).collect();
        // Constraints go before vertices, these before branches.
        let named = branches.into_iter().chain(vertices).chain(constraints);
        parts.names = named.map(|(name, place)| (name.to_owned(), place)).collect();
        parts
    }

    /// The place of the element whose XML id stands in backticks: "Tube `id_3`: …".
    fn quoted_in(&self, text: &str) -> Option<Place> {
        text.split('`').skip(1).step_by(2).find_map(|id| self.elements.get(id)).cloned()
    }

    /// The part that an item of a finding names, or the place of the element. Findings have names in backticks, XML ids
    /// as words, and in parentheses what is at a node: `s1 f1 `clip-1` (175 mm)`, `n5 (spliceS S1)`.
    fn named_in(&self, item: &str) -> Option<Place> {
        let quoted = || item.split('`').skip(1).step_by(2);
        let words = |text: &str| -> Vec<String> {
            let parts = text.split(|c: char| c.is_whitespace() || "(),;".contains(c));
            parts.filter(|word| !word.is_empty()).map(str::to_owned).collect()
        };
        let bare: Vec<String> = item.split('`').step_by(2).flat_map(words).collect();
        let find = |known: &HashMap<String, Place>| bare.iter().find_map(|word| known.get(word)).cloned();
        let inside = || item.split_once('(').and_then(|(_, rest)| rest.rsplit_once(')')).map(|(inside, _)| inside);
        let branch = find(&self.branch_ids);
        // Where its branch is named too, another part may have the same label.
        let fits = |place: &&Place| branch.as_ref().is_none_or(|branch| branch.branch == place.branch);
        // A name behind the id of something else is its label: `id_7 `plug A`` is a plug that was left out.
        let is_name = branch.is_some() || item.starts_with('`') || item.contains("(`");
        find(&self.constraint_ids)
            .or_else(|| quoted().filter(|_| is_name).filter_map(|name| self.names.get(name)).find(fits).cloned())
            .or_else(|| branch.clone())
            .or_else(|| words(inside()?).iter().find_map(|word| self.component(word)).cloned())
            .or_else(|| find(&self.elements))
            .or_else(|| self.quoted_in(item))
    }

    /// The component of a label, unless there are several: their names then have numbers.
    fn component(&self, label: &str) -> Option<&Place> {
        self.components.get(label).filter(|_| !self.components.contains_key(&format!("{label}-2")))
    }
}

fn list<'a>(entry: &'a Json, key: &str) -> impl Iterator<Item = &'a Json> {
    entry.get(key).and_then(Json::as_array).into_iter().flatten()
}

fn text<'a>(entry: &'a Json, key: &str) -> Option<&'a str> {
    entry.get(key)?.as_str()
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom::import::kbl::{Finding, Options, Source, import};

    const SMALL: &str = include_str!("../../import/tests/small.kbl");

    fn small(options: Options) -> protocol::Imported {
        let file = Some(Source { name: "small.kbl".to_owned(), sha256: "0".repeat(64) });
        of(&import(SMALL, &Options { file, ..options }).expect("KBL"), "small.kbl")
    }

    fn place<'a>(imported: &'a protocol::Imported, what: &str) -> &'a FindingItem {
        let finding = imported.findings.iter().find(|finding| finding.what.starts_with(what));
        &finding.unwrap_or_else(|| panic!("no {what}: {:?}", imported.findings)).items[0]
    }

    #[test]
    fn findings_of_segments_and_ends_name_the_branch() {
        let imported = small(Options::default());
        let stale = place(&imported, "stale centre curves").place.clone().expect("segment s3");
        assert_eq!((stale.branch.as_deref(), stale.s), (Some("right"), None));
        let splice = place(&imported, "ends carry splices").place.clone().expect("splice S1 at node S");
        assert_eq!((splice.branch.as_deref(), splice.s), (Some("stub"), Some(0.03)));
        let free = place(&imported, "ends carry no component").place.clone().expect("node n4");
        assert_eq!((free.branch.as_deref(), free.s), (Some("right"), Some(0.25)), "an XML id alone");
        let unread = place(&imported, "parts of elements that are not read");
        assert_eq!((unread.words.as_str(), &unread.place), ("1 Bend_radius", &None));
        let segments = imported.usage.iter().find(|own| own.kind == "Segment").expect("segments");
        assert_eq!((segments.total, segments.used), (4, 4));
    }

    /// They led nowhere.
    #[test]
    fn findings_that_have_xml_ids_alone_lead_to_the_place_of_the_element() {
        let file = Some(Source { name: "small.kbl".to_owned(), sha256: "0".repeat(64) });
        let made = import(SMALL, &Options { file, ..Options::default() }).expect("KBL");
        let items = ["w1", "tape1", "n3", "Wire_protection_occurrence `tape1`", "1 Bend_radius", "none"];
        let items = items.map(str::to_owned).to_vec();
        let sentence = "Wire_protection_occurrence `tape1`: it is impossible; left out".to_owned();
        let findings = vec![Finding { what: "found".to_owned(), items }, Finding { what: sentence, items: Vec::new() }];
        let found = of(&Imported { findings, ..made }, "small.kbl");
        let branch = |place: &Option<Place>| place.as_ref().and_then(|place| place.branch.clone());
        let branches: Vec<_> = found.findings[0].items.iter().map(|item| branch(&item.place)).collect();
        let trunk = Some("trunk".to_owned());
        assert_eq!(branches[..2], [trunk.clone(), trunk.clone()], "{:?}", found.findings);
        assert!(branches[2].is_some() && found.findings[0].items[2].place.as_ref().is_some_and(|at| at.s.is_some()));
        assert_eq!(branches[3..], [trunk.clone(), None, None], "{:?}", found.findings);
        assert_eq!(branch(&found.findings[1].place), trunk);
    }

    #[test]
    fn findings_of_clips_name_the_clip_also_where_a_step_adds_it() {
        for arrangement in [wireloom::import::kbl::Arrangement::Installed, wireloom::import::kbl::Arrangement::Assembly]
        {
            let file = Some(Source { name: "small.kbl".to_owned(), sha256: "0".repeat(64) });
            let made = import(SMALL, &Options { arrangement, file, ..Options::default() }).expect("KBL");
            let items = ["s1 f1 `clip-1` (a duct)", "`plug A` (670 mm)", "s2 f9 `clip-1` (134 mm)", "id_7 `plug A`"];
            let items = items.map(str::to_owned).to_vec();
            let findings = vec![Finding { what: "found".to_owned(), items }];
            let found = of(&Imported { findings, ..made }, "small.kbl");
            let [clip, plug, other] = [0, 1, 2].map(|k| found.findings[0].items[k].place.clone().expect("a part"));
            assert_eq!((clip.constraint.as_deref(), clip.branch.as_deref()), (Some("clip-1"), Some("trunk")));
            assert!(clip.s.is_some_and(|s| (s - 0.15395).abs() < 1e-3), "{clip:?}");
            assert_eq!((plug.constraint.as_deref(), plug.branch.as_deref()), (Some("plug A"), Some("trunk")));
            assert_eq!(found.findings[0].items[3].place, None, "another plug of that name");
            assert_eq!((other.constraint, other.branch.as_deref()), (None, Some("left")), "{arrangement:?}");
        }
    }
}
