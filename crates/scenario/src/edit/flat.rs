//! Writes the text of a scenario anew for the harness on a formboard: other rest shapes, other constraints, no steps.

use super::record::{Attachment, document, inline, list, number, on_lines, place_of};
use super::structure::entries;
use crate::fault::Fault;
use toml_edit::{Array, ArrayOfTables, Item, Table, TableLike, Value};

/// What the harness is on the board.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flat {
    /// Name of the scenario.
    pub name: String,
    /// Gravity, m/s².
    pub gravity: [f64; 3],
    /// The branches.
    pub branches: Vec<FlatBranch>,
    /// The joints; others are left out.
    pub joints: Vec<FlatJoint>,
    /// The loads; others are left out.
    pub loads: Vec<FlatLoad>,
    /// What holds the harness.
    pub held: Vec<Held>,
    /// Whether markers stay.
    pub markers: bool,
}

/// A branch on the board.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatBranch {
    /// Its name.
    pub name: String,
    /// The vertex where it ends.
    pub to: String,
    /// Its centre line, m.
    pub path: Vec<[f64; 3]>,
    /// Rest curvature about d1, d2, d3, 1/m.
    pub curvature: [f64; 3],
}

/// A joint on the board.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatJoint {
    /// Its name.
    pub name: String,
    /// Branches of its arms, and their frames at rest as quaternions `[w, x, y, z]`.
    pub arms: Vec<(String, [f64; 4])>,
}

/// A load on the board.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatLoad {
    /// Its name.
    pub name: String,
    /// Where it acts, if not where it did.
    pub at: Option<Attachment>,
    /// Its force, N, or along a span its force per length, N/m.
    pub force: [f64; 3],
}

/// A support.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Its name.
    pub name: String,
    /// What it holds.
    pub at: Attachment,
    /// m.
    pub position: [f64; 3],
    /// How it holds.
    pub how: Hold,
}

/// How a support holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// The position, by a spring of this stiffness, N/m.
    Spring(f64),
    /// The position.
    Position,
    /// The whole pose: d3 and d1.
    Pose([f64; 3], [f64; 3]),
}

/// Keys of the scenario that describe the harness itself, and how it is computed. The others belong to its
/// surroundings, its installation, or studies of them; so do the drawn lines of branches.
const KEPT: [&str; 15] = [
    "schema",
    "name",
    "gravity",
    "sections",
    "materials",
    "wires",
    "coverings",
    "fixings",
    "library",
    "branches",
    "joints",
    "mesh",
    "loads",
    "minimiser",
    "plugins",
];

/// The text of the harness on the board, and the keys of `text` that are left out.
///
/// # Errors
/// If the text is not TOML.
pub fn on_board(text: &str, flat: &Flat) -> Result<(String, Vec<String>), Fault> {
    let mut document = document(text)?;
    let root = document.as_table_mut();
    let stays = |key: &str| KEPT.contains(&key) || key == "markers" && flat.markers;
    let left_out: Vec<String> = root.iter().map(|(key, _)| key.to_owned()).filter(|key| !stays(key)).collect();
    left_out.iter().for_each(|key| drop(root.remove(key)));
    root["name"] = toml_edit::value(flat.name.as_str());
    root["gravity"] = Item::Value(list(&flat.gravity));
    each(root, "branches", |entry, name| {
        let Some(own) = flat.branches.iter().find(|own| own.name == name) else { return true };
        entry.remove("drawn");
        entry.insert("to", toml_edit::value(own.to.as_str()));
        entry.insert("path", Item::Value(Value::Array(own.path.iter().map(|p| list(p)).collect())));
        if own.curvature == [0.0; 3] {
            entry.remove("curvature");
        } else {
            entry.insert("curvature", Item::Value(list(&own.curvature)));
        }
        true
    });
    each(root, "joints", |entry, name| {
        let Some(own) = flat.joints.iter().find(|own| own.name == name) else { return false };
        // Arms as sub-tables would stand behind keys that are written later.
        entry.remove("arms");
        entry.insert("arms", Item::Value(Value::Array(arms(own))));
        let has = |value: Option<&Value>| {
            let name = value.and_then(Value::as_str);
            own.arms.iter().any(|(branch, _)| Some(branch.as_str()) == name)
        };
        retain(entry, "wires", &mut |wires| {
            let between = wires.get("between").and_then(Item::as_array);
            between.is_none_or(|between| has(between.get(0)) && has(between.get(1)))
        });
        true
    });
    each(root, "loads", |entry, name| {
        let Some(own) = flat.loads.iter().find(|own| own.name == name) else { return false };
        let key = if entry.contains_key("span") { "force_per_length" } else { "force" };
        entry.insert(key, Item::Value(list(&own.force)));
        if let Some(at) = &own.at {
            entry.remove("at");
            entry.insert("at", Item::Value(Value::InlineTable(place_of(at))));
        }
        true
    });
    let mut constraints = ArrayOfTables::new();
    flat.held.iter().for_each(|held| constraints.push(support(held)));
    root.insert("constraints", Item::ArrayOfTables(constraints));
    Ok((document.to_string(), left_out))
}

/// Shows every entry of a list of tables with its name; those for which `keep` says no are removed.
fn each(root: &mut Table, key: &str, mut keep: impl FnMut(&mut dyn TableLike, &str) -> bool) {
    let mut kept = Vec::new();
    for entry in entries::list(root, key) {
        let name = entries::word(entry, "name").unwrap_or_default().to_owned();
        kept.push(keep(entry, &name));
    }
    let mut kept = kept.into_iter();
    retain(root, key, &mut |_| kept.next().unwrap_or(true));
}

/// Keeps some of the entries of a list; without any, the list goes.
fn retain(table: &mut dyn TableLike, key: &str, keep: &mut dyn FnMut(&dyn TableLike) -> bool) {
    entries::retain(table, key, keep);
    if entries::list(table, key).is_empty() {
        table.remove(key);
    }
}

fn arms(joint: &FlatJoint) -> Array {
    let arm = |(branch, frame): &(String, [f64; 4])| {
        Value::InlineTable(inline([("branch", branch.as_str().into()), ("orientation", list(frame))]))
    };
    on_lines(joint.arms.iter().map(arm))
}

fn support(held: &Held) -> Table {
    let mut table = Table::new();
    table["name"] = toml_edit::value(held.name.as_str());
    table["kind"] = toml_edit::value(if let Hold::Pose(..) = held.how { "connector" } else { "handle" });
    table["at"] = Item::Value(Value::InlineTable(place_of(&held.at)));
    table["position"] = Item::Value(list(&held.position));
    match held.how {
        Hold::Position => {}
        Hold::Spring(stiffness) => table["stiffness"] = Item::Value(number(stiffness)),
        Hold::Pose(tangent, up) => {
            table["tangent"] = Item::Value(list(&tangent));
            table["up"] = Item::Value(list(&up));
        }
    }
    table.decor_mut().set_prefix("\n");
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# A comment.\nschema = 1\nbranches = [{ name = \"a\", from = \"A\", to = \"J\", length = 1, \
                        drawn = [[0, 0, 0], [1, 0, 0]] }]\n\
                        joints = [{ name = \"J\", arms = [], wires = [{ between = [\"a\", \"b\"], share = 1 }] }]\n\
                        [[constraints]]\nname = \"c\"\n[[steps]]\nname = \"s\"\n[[loads]]\nname = \"l\"\n";

    #[test]
    fn what_the_board_does_not_have_is_named_and_comments_stay() {
        let flat = Flat {
            name: "flat".into(),
            branches: vec![FlatBranch {
                name: "a".into(),
                to: "J".into(),
                path: vec![[0.0; 3], [1.0, 0.0, 0.0]],
                curvature: [0.0, 0.5, 0.0],
            }],
            joints: vec![FlatJoint { name: "J".into(), arms: vec![("a".into(), [1.0, 0.0, 0.0, 0.0])] }],
            held: vec![Held {
                name: "peg".into(),
                at: Attachment::End("A".into()),
                position: [0.0; 3],
                how: Hold::Spring(2000.0),
            }],
            ..Flat::default()
        };
        let (text, left_out) = on_board(TEXT, &flat).expect("TOML");
        assert_eq!(left_out, ["constraints", "steps"]);
        assert!(text.starts_with("# A comment.\n"), "{text}");
        let table: toml::Table = toml::from_str(&text).expect("TOML");
        assert_eq!(table["constraints"].as_array().map(Vec::len), Some(1));
        assert_eq!(table["constraints"][0]["stiffness"].as_integer(), Some(2000));
        assert_eq!(table["branches"][0]["curvature"][1].as_float(), Some(0.5));
        // Drawn lines are those of the vehicle.
        assert!(table["branches"][0].get("drawn").is_none(), "{text}");
        assert_eq!(table["joints"][0]["arms"][0]["branch"].as_str(), Some("a"));
        // An arm that is no more shares no wires, and the load is not among those that stay.
        assert!(table["joints"][0].get("wires").is_none() && !table.contains_key("loads"), "{text}");
    }

    #[test]
    fn what_is_not_toml_is_refused() {
        assert!(on_board("branches = [", &Flat::default()).is_err());
    }
}
