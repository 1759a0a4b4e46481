//! Writes steps and values into the text of a scenario, and keeps the author's comments and layout.

use super::key_path::{self, NAMES, Part};
use crate::fault::Fault;
use crate::format::form::Keys;
use crate::format::keys;
use crate::operations::{ADD, CARRY, DRIVE, GRASP, MOVE, StepOperation};
use crate::read::reader;
use crate::span::Span;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Formatted, InlineTable, Item, Table, Value};
use wireloom_core::{Registry, Rotation, Vector};

/// A step to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written {
    /// Name.
    pub name: String,
    /// Constraints that are released.
    pub release: Vec<String>,
    /// Constraints that begin.
    pub begins: Vec<Begins>,
    /// A motion; each of its places is an increment.
    pub way: Option<Way>,
    /// A motion of an obstacle.
    pub body: Option<BodyMotion>,
    /// A motion of a joint of a mechanism.
    pub drive: Option<JointMotion>,
}

/// The motion of a joint of a mechanism to a value.
#[derive(Clone, Debug, PartialEq)]
pub struct JointMotion {
    /// The joint, as `MECHANISM/JOINT`.
    pub joint: String,
    /// Value at its end, rad or m.
    pub to: f64,
    /// Increments.
    pub increments: usize,
}

/// The motion of an obstacle to a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMotion {
    /// Name of the obstacle.
    pub obstacle: String,
    /// Position at its end, m.
    pub position: [f64; 3],
    /// Orientation at its end: a quaternion `[w, x, y, z]` of any length but zero.
    pub orientation: [f64; 4],
    /// Increments.
    pub increments: usize,
}

/// A constraint that begins where the cable is.
#[derive(Clone, Debug, PartialEq)]
pub struct Begins {
    /// Name.
    pub name: String,
    /// Kind; `None`: a grasp.
    pub kind: Option<String>,
    /// Place that it attaches to.
    pub at: Attachment,
}

/// A place that something attaches to, by name.
#[derive(Clone, Debug, PartialEq)]
pub enum Attachment {
    /// To a branch, at an unstressed arc length, m.
    Branch(String, f64),
    /// To a joint.
    Joint(String),
    /// To a free end.
    End(String),
}

/// The motion of a constraint, through places at equal fractions of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Name of the constraint.
    pub constraint: String,
    /// Places that it passes.
    pub places: Vec<Passed>,
}

/// A place that a motion passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passed {
    /// Position, m.
    pub position: [f64; 3],
    /// Direction or frame; either all places of a motion have one, or none.
    pub turn: Option<Turned>,
}

/// Direction or frame, as a file gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turned {
    /// Direction of d3, of any length but zero.
    Tangent([f64; 3]),
    /// Quaternion `[w, x, y, z]`, of any length but zero.
    Orientation([f64; 4]),
}

impl Turned {
    /// The turn that the reader makes of it; `None` if it is zero.
    pub fn turn(&self) -> Option<wireloom_core::steps::Turn> {
        use wireloom_core::steps::Turn;
        match self {
            Turned::Tangent(d) => reader::normalised(Vector::from(*d)).map(|d| Turn::Tangent(*d)),
            Turned::Orientation(q) => rotation(*q).map(Turn::Orientation),
        }
    }
}

/// The rotation of a quaternion `[w, x, y, z]` of any length but zero.
pub fn rotation(q: [f64; 4]) -> Option<Rotation> {
    reader::rotation(q)
}

/// The text with its first `kept` steps, followed by further ones.
///
/// # Errors
/// If the text is not TOML.
pub fn with_steps(text: &str, kept: usize, further: &[Written]) -> Result<String, Fault> {
    let mut document = document(text)?;
    let item = document.as_table_mut().entry("steps").or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    if let Item::Value(Value::Array(list)) = item {
        while list.len() > kept {
            list.remove(list.len() - 1);
        }
        list.extend(further.iter().map(|step| Value::InlineTable(table_of(step).into_inline_table())));
    } else if let Item::ArrayOfTables(tables) = item {
        while tables.len() > kept {
            tables.remove(tables.len() - 1);
        }
        for step in further {
            let mut table = table_of(step);
            table.decor_mut().set_prefix("\n");
            tables.push(table);
        }
    }
    let empty = match item {
        Item::ArrayOfTables(tables) => tables.is_empty(),
        Item::Value(Value::Array(list)) => list.is_empty(),
        _ => false,
    };
    if empty {
        document.as_table_mut().remove("steps");
    }
    Ok(document.to_string())
}

/// The text with further markers.
///
/// # Errors
/// If the text is not TOML.
pub fn with_markers(text: &str, further: &[(String, Attachment)]) -> Result<String, Fault> {
    let mut document = document(text)?;
    let item = document.as_table_mut().entry("markers").or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    for (name, at) in further {
        let mut own = Table::new();
        own["name"] = toml_edit::value(name.as_str());
        own["at"] = toml_edit::value(place_of(at));
        match item {
            Item::Value(Value::Array(list)) => list.push(own.into_inline_table()),
            Item::ArrayOfTables(tables) => tables.push(own),
            _ => {}
        }
    }
    Ok(document.to_string())
}

/// The text with another value of a key; `key` as in [`crate::settings`].
///
/// # Errors
/// If the text is not TOML, or there is no such key; the place is that in the text, or its end.
pub fn with_value(text: &str, key: &str, value: &wireloom_core::Value, registry: &Registry) -> Result<String, Fault> {
    put(text, key, &written(value), registry)
}

/// The text with another value of a key, of any form; `key` as in [`crate::settings`]. Numbers of the JSON value that
/// are whole become integers of TOML, lists and objects become inline ones.
///
/// # Errors
/// Those of [`with_value`]; null, which TOML does not have.
pub fn with_json(text: &str, key: &str, value: &serde_json::Value, registry: &Registry) -> Result<String, Fault> {
    let value = of_json(value).ok_or_else(|| Fault {
        span: text.len()..text.len(),
        message: format!("the value of `{key}` has a part that is nothing, or a whole number of more than 64 bits"),
        help: "give numbers, strings, true or false, lists and tables of them".to_owned(),
    })?;
    put(text, key, &value, registry)
}

/// The text as JSON, with every value as it is written.
///
/// # Errors
/// If the text is not TOML.
pub fn as_json(text: &str) -> Result<serde_json::Value, Fault> {
    // Its errors have places.
    document(text)?;
    toml::from_str(text).map_err(|error| Fault {
        span: text.len()..text.len(),
        message: format!("this is not TOML: {}", error.message()),
        help: "see https://toml.io".to_owned(),
    })
}

/// The value of a key in the text, as JSON; `key` as in [`crate::settings`], without `*`. Files that the text includes
/// are not searched.
///
/// # Errors
/// If the text is not TOML, or there is no such key; the place is that in the text, or its end.
pub fn value_at(text: &str, key: &str) -> Result<serde_json::Value, Fault> {
    let end = text.len()..text.len();
    let mut value = as_json(text)?;
    for part in key_path::parts(key, 0).map_err(|fault| Fault { span: end.clone(), ..fault })? {
        let found = match &mut value {
            serde_json::Value::Object(table) => table.get_mut(&part.name),
            serde_json::Value::Array(list) => index_of(list, &part.name).and_then(|k| list.get_mut(k)),
            _ => None,
        };
        value = found.ok_or_else(|| unknown(key, &part, end.clone()))?.take();
    }
    Ok(value)
}

fn put(text: &str, key: &str, value: &Value, registry: &Registry) -> Result<String, Fault> {
    let mut document = document(text)?;
    let end = text.len();
    let parts = key_path::parts(key, 0).map_err(|fault| Fault { span: end..end, ..fault })?;
    let put = Put { key, registry, end: end..end };
    put.put_in_table(document.as_table_mut(), Some(&keys::SCENARIO), &parts, value)?;
    Ok(document.to_string())
}

pub(super) fn document(text: &str) -> Result<DocumentMut, Fault> {
    text.parse::<DocumentMut>().map_err(|error| Fault {
        span: error.span().unwrap_or(text.len()..text.len()),
        message: format!("this is not TOML: {}", error.message()),
        help: "see https://toml.io".to_owned(),
    })
}

// ---- steps --------------------------------------------------------------------------------------------------------

fn table_of(step: &Written) -> Table {
    let mut table = Table::new();
    table["name"] = toml_edit::value(step.name.as_str());
    let of_way = step.way.as_ref().map(|way| way.places.len());
    let of_body = step.body.as_ref().map(|body| body.increments);
    let increments = of_way.or(of_body).or(step.drive.as_ref().map(|drive| drive.increments)).unwrap_or(1);
    table["increments"] = toml_edit::value(i64::try_from(increments).unwrap_or(i64::MAX));
    if !step.release.is_empty() {
        table["release"] = toml_edit::value(step.release.iter().map(String::as_str).collect::<Array>());
    }
    for begins in &step.begins {
        let mut own = Table::new();
        own["name"] = toml_edit::value(begins.name.as_str());
        if let Some(kind) = &begins.kind {
            own["kind"] = toml_edit::value(kind.as_str());
        }
        own["at"] = toml_edit::value(place_of(&begins.at));
        push(&mut table, if begins.kind.is_some() { &ADD } else { &GRASP }, own);
    }
    if let Some(BodyMotion { obstacle, position, orientation, .. }) = &step.body {
        let mut own = Table::new();
        own["obstacle"] = toml_edit::value(obstacle.as_str());
        own["position"] = toml_edit::value(list(position));
        own["orientation"] = toml_edit::value(list(orientation));
        push(&mut table, &MOVE, own);
    }
    if let Some(JointMotion { joint, to, .. }) = &step.drive {
        let mut own = Table::new();
        own["joint"] = toml_edit::value(joint.as_str());
        own["to"] = toml_edit::value(number(*to));
        push(&mut table, &DRIVE, own);
    }
    match &step.way {
        Some(way) => write_way(way, &mut table),
        None if step.body.is_some() || step.drive.is_some() => {}
        None if step.release.is_empty() && step.begins.is_empty() => table["wait"] = toml_edit::value(true),
        None => {}
    }
    table
}

fn push(step: &mut Table, operation: &StepOperation, own: Table) {
    let item = step.entry(operation.key.name).or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    if let Item::ArrayOfTables(tables) = item {
        tables.push(own);
    }
}

pub(super) fn place_of(at: &Attachment) -> InlineTable {
    match at {
        Attachment::Branch(branch, s) => inline([("branch", branch.as_str().into()), ("s", number(*s))]),
        Attachment::Joint(joint) => inline([("joint", joint.as_str().into())]),
        Attachment::End(end) => inline([("end", end.as_str().into())]),
    }
}

/// Writes a `move` through points, or, if it turns, a `carry` through keyframes.
fn write_way(way: &Way, step: &mut Table) {
    let mut own = Table::new();
    let Some((last, before)) = way.places.split_last() else { return };
    if way.places.iter().all(|place| place.turn.is_none()) {
        own["constraint"] = toml_edit::value(way.constraint.as_str());
        if !before.is_empty() {
            own["via"] = toml_edit::value(on_lines(before.iter().map(|place| list(&place.position))));
        }
        own["position"] = toml_edit::value(list(&last.position));
        push(step, &MOVE, own);
        return;
    }
    own["what"] = toml_edit::value([way.constraint.as_str()].into_iter().collect::<Array>());
    let keyframe = |(k, place): (usize, &Passed)| {
        let at = (k + 1) as f64 / way.places.len() as f64;
        let mut frame = inline([("at", number(at)), ("position", list(&place.position))]);
        match place.turn {
            Some(Turned::Tangent(d)) => frame.insert("tangent", list(&d)),
            Some(Turned::Orientation(q)) => frame.insert("orientation", list(&q)),
            None => None,
        };
        Value::InlineTable(frame)
    };
    own["keyframes"] = toml_edit::value(on_lines(way.places.iter().enumerate().map(keyframe)));
    push(step, &CARRY, own);
}

pub(super) fn inline<const N: usize>(entries: [(&str, Value); N]) -> InlineTable {
    entries.into_iter().collect()
}

pub(super) fn list(numbers: &[f64]) -> Value {
    Value::Array(numbers.iter().map(|x| number(*x)).collect())
}

/// A number; an integer without a decimal point.
pub(super) fn number(x: f64) -> Value {
    if x == x.trunc() && x.abs() < 1e6 && !(x == 0.0 && x.is_sign_negative()) {
        return Value::Integer(Formatted::new(x as i64));
    }
    Value::Float(Formatted::new(x))
}

/// A list with one line for every entry.
pub(super) fn on_lines(values: impl Iterator<Item = Value>) -> Array {
    let mut array: Array = values.collect();
    for value in array.iter_mut() {
        value.decor_mut().set_prefix("\n  ");
    }
    array.set_trailing_comma(true);
    array.set_trailing("\n");
    array
}

// ---- values -------------------------------------------------------------------------------------------------------

fn written(value: &wireloom_core::Value) -> Value {
    use wireloom_core::Value as Given;
    match value {
        Given::Number(x) => Value::Float(Formatted::new(*x)),
        Given::Vector(v) => list(&[v.x, v.y, v.z]),
        Given::Count(n) => Value::Integer(Formatted::new(i64::try_from(*n).unwrap_or(i64::MAX))),
        Given::Flag(flag) => Value::from(*flag),
        Given::Word(word) => Value::from(word.as_str()),
    }
}

/// A value of TOML; `None` for null, which TOML does not have, and for too large whole numbers.
pub(super) fn of_json(value: &serde_json::Value) -> Option<Value> {
    use serde_json::Value as Json;
    Some(match value {
        Json::Null => return None,
        Json::Bool(flag) => Value::from(*flag),
        Json::Number(x) => match x.as_i64() {
            Some(whole) => Value::Integer(Formatted::new(whole)),
            None if x.is_u64() => return None,
            None => Value::Float(Formatted::new(x.as_f64()?)),
        },
        Json::String(word) => Value::from(word.as_str()),
        Json::Array(list) => Value::Array(list.iter().map(of_json).collect::<Option<Array>>()?),
        Json::Object(table) => {
            let entry = |(key, value): (&String, &Json)| Some((key.clone(), of_json(value)?));
            Value::InlineTable(table.iter().map(entry).collect::<Option<InlineTable>>()?)
        }
    })
}

fn unknown(key: &str, part: &Part, place: Span) -> Fault {
    Fault {
        span: place,
        message: format!("`{key}` names no key: there is no `{}`", part.name),
        help: match part.name.parse::<usize>() {
            Ok(_) => "entries of a list count from 0, such as constraints.clip.position.2".to_owned(),
            Err(_) => "write the path to a key with dots, such as branches.left.length".to_owned(),
        },
    }
}

/// Writes a value at the path of its key.
struct Put<'r> {
    key: &'r str,
    registry: &'r Registry,
    end: Span,
}

impl Put<'_> {
    fn put_in_table(
        &self,
        table: &mut dyn toml_edit::TableLike,
        keys: Option<&'static Keys>,
        parts: &[Part],
        value: &Value,
    ) -> Result<(), Fault> {
        let [part, rest @ ..] = parts else { return Ok(()) };
        let name = part.name.as_str();
        if rest.is_empty() {
            for stale in key_path::stale(keys, name, value.as_str(), self.registry) {
                table.remove(&stale);
            }
            match table.get_mut(name) {
                // The rest of its line remains.
                Some(Item::Value(old)) => {
                    let decor = old.decor().clone();
                    *old = value.clone();
                    *old.decor_mut() = decor;
                }
                Some(item) => *item = Item::Value(value.clone()),
                None => {
                    table.insert(name, Item::Value(value.clone()));
                }
            }
            return Ok(());
        }
        let (below, makes) = key_path::below(keys, name);
        if !table.contains_key(name) && makes {
            table.insert(name, Item::Table(Table::new()));
        }
        let item = table.get_mut(name).ok_or_else(|| self.unknown(part))?;
        self.put_behind(item, below, rest, value)
    }

    fn put_behind(
        &self,
        item: &mut Item,
        keys: Option<&'static Keys>,
        parts: &[Part],
        value: &Value,
    ) -> Result<(), Fault> {
        let [part, rest @ ..] = parts else { return Ok(()) };
        match item {
            Item::ArrayOfTables(tables) => {
                let names: Vec<Option<String>> = tables.iter().map(|table| name_of(table)).collect();
                let k = entry_of(&names, &part.name).ok_or_else(|| self.unknown(part))?;
                let table = tables.get_mut(k).ok_or_else(|| self.unknown(part))?;
                self.put_in_table(table, keys, rest, value)
            }
            Item::Value(Value::Array(list)) => {
                let names: Vec<Option<String>> =
                    list.iter().map(|entry| entry.as_inline_table().and_then(|table| name_of(table))).collect();
                let k = entry_of(&names, &part.name).ok_or_else(|| self.unknown(part))?;
                match (list.get_mut(k), rest) {
                    (Some(Value::InlineTable(table)), [_, ..]) => self.put_in_table(table, keys, rest, value),
                    // A component of a vector.
                    (Some(old), []) => {
                        let decor = old.decor().clone();
                        *old = value.clone();
                        *old.decor_mut() = decor;
                        Ok(())
                    }
                    _ => Err(self.unknown(part)),
                }
            }
            other => match other.as_table_like_mut() {
                Some(table) => self.put_in_table(table, keys, parts, value),
                None => Err(self.unknown(part)),
            },
        }
    }

    fn unknown(&self, part: &Part) -> Fault {
        unknown(self.key, part, self.end.clone())
    }
}

/// Name of an entry of a list.
pub(super) fn name_of(table: &dyn toml_edit::TableLike) -> Option<String> {
    NAMES.iter().find_map(|key| Some(table.get(key)?.as_str()?.to_owned()))
}

/// Index of the entry with this name or number.
pub(super) fn entry_of(names: &[Option<String>], name: &str) -> Option<usize> {
    let named = names.iter().position(|own| own.as_deref() == Some(name));
    named.or_else(|| name.parse().ok().filter(|k| *k < names.len()))
}

/// The same of a list of JSON.
pub(super) fn index_of(list: &[serde_json::Value], name: &str) -> Option<usize> {
    let of = |entry: &serde_json::Value| NAMES.iter().find_map(|key| Some(entry.get(*key)?.as_str()?.to_owned()));
    entry_of(&list.iter().map(of).collect::<Vec<_>>(), name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# A harness.\nschema = 1\n\n[sections.cable] # of two wires\ndiameter = \"8 mm\" # measured\n\
        bending_stiffness = 0.012\n\n[[joints]]\nname = \"J\"\nmodel = \"fused\" # glued\n\n\
        [[steps]] # first\nname = \"one\"\nincrements = 2\n[[steps.add]]\nname = \"plug-B\"\n\n\
        [[steps]]\nname = \"two\"\n\n[minimiser]\nkind = \"newton\"\n";

    #[test]
    fn steps_are_cut_off_and_written_behind_the_others() {
        let drag = |turn| Written {
            name: "drag plug-B".into(),
            way: Some(Way {
                constraint: "plug-B".into(),
                places: vec![
                    Passed { position: [0.1, 0.0, 1.0 / 3.0], turn },
                    Passed { position: [0.5, -2.0, 1e-9], turn },
                ],
            }),
            ..Written::default()
        };
        let hold = Written {
            name: "take hold".into(),
            release: vec!["x".into()],
            begins: vec![
                Begins { name: "hand 1".into(), kind: None, at: Attachment::Branch("trunk".into(), 0.25) },
                Begins { name: "pin 1".into(), kind: Some("connector".into()), at: Attachment::Joint("J".into()) },
            ],
            ..Written::default()
        };
        let body = BodyMotion {
            obstacle: "flap".into(),
            position: [0.0, 0.5, 0.0],
            orientation: [1.0, 0.0, 0.5, 0.0],
            increments: 3,
        };
        let opened = Written { name: "open".into(), body: Some(body), ..Written::default() };
        let turned = drag(Some(Turned::Orientation([1.0, 0.0, 0.0, 0.5])));
        let text = with_steps(TEXT, 1, &[hold, drag(None), turned, opened]).expect("TOML");
        let expected = r#"# A harness.
schema = 1

[sections.cable] # of two wires
diameter = "8 mm" # measured
bending_stiffness = 0.012

[[joints]]
name = "J"
model = "fused" # glued

[[steps]] # first
name = "one"
increments = 2
[[steps.add]]
name = "plug-B"

[[steps]]
name = "take hold"
increments = 1
release = ["x"]

[[steps.grasp]]
name = "hand 1"
at = { branch = "trunk", s = 0.25 }

[[steps.add]]
name = "pin 1"
kind = "connector"
at = { joint = "J" }

[[steps]]
name = "drag plug-B"
increments = 2

[[steps.move]]
constraint = "plug-B"
via = [
  [0.1, 0, 0.3333333333333333],
]
position = [0.5, -2, 0.000000001]

[[steps]]
name = "drag plug-B"
increments = 2

[[steps.carry]]
what = ["plug-B"]
keyframes = [
  { at = 0.5, position = [0.1, 0, 0.3333333333333333], orientation = [1, 0, 0, 0.5] },
  { at = 1, position = [0.5, -2, 0.000000001], orientation = [1, 0, 0, 0.5] },
]

[[steps]]
name = "open"
increments = 3

[[steps.move]]
obstacle = "flap"
position = [0, 0.5, 0]
orientation = [1, 0, 0.5, 0]

[minimiser]
kind = "newton"
"#;
        assert_eq!(text, expected);
        assert_eq!(with_steps(TEXT, 2, &[]).as_deref(), Ok(TEXT));
        assert!(!with_steps(TEXT, 0, &[]).expect("TOML").contains("steps"));
    }

    #[test]
    fn values_take_the_place_of_others_and_leave_what_stands_beside_them() {
        let registry = Registry::default();
        let number = wireloom_core::Value::Number(0.02);
        let text = with_value(TEXT, "sections.cable.diameter", &number, &registry).expect("a key");
        assert!(text.contains("diameter = 0.02 # measured"), "{text}");
        let word = wireloom_core::Value::Word("cosserat".into());
        let text = with_value(&text, "joints.J.model", &word, &registry).expect("a key");
        assert!(text.contains("model = \"cosserat\" # glued"), "{text}");
        let text = with_value(&text, "minimiser.max_iterations", &wireloom_core::Value::Count(7), &registry);
        assert!(text.as_ref().is_ok_and(|text| text.ends_with("kind = \"newton\"\nmax_iterations = 7\n")), "{text:?}");
        for key in ["joints.K.model", "nothing.there", "sections.cable.diameter.x", "", "a..b"] {
            assert!(with_value(TEXT, key, &number, &registry).is_err(), "{key}");
        }
    }

    #[test]
    fn values_of_any_form_are_written_and_read_back() {
        use serde_json::json;
        let registry = Registry::default();
        let mut text = TEXT.to_owned();
        for (key, value) in [
            ("sections.cable.bending_stiffness", json!([0.012, 1])),
            ("sections.cable.bending_stiffness.1", json!(2.5)),
            ("joints.J.arms", json!([{ "branch": "a", "direction": [1, 0, 0.5] }])),
            ("joints.J.arms.a.direction", json!([0, 0, 1])),
            ("steps.one.add.plug-B.kind", json!("a \"quoted\" word")),
            ("steps.1.wait", json!(true)),
        ] {
            text = with_json(&text, key, &value, &registry).unwrap_or_else(|fault| panic!("{key}: {fault:?}"));
            assert_eq!(value_at(&text, key), Ok(value), "{key}");
        }
        assert!(text.contains("bending_stiffness = [0.012, 2.5]") && text.contains("# of two wires"), "{text}");
        assert_eq!(value_at(&text, "steps.two.name"), Ok(json!("two")));
        for key in ["joints.K", "sections.cable.diameter.x", "steps.2", "", "a..b"] {
            assert!(value_at(&text, key).is_err(), "{key}");
        }
        for value in [json!(null), json!([1, null]), json!(u64::MAX)] {
            assert!(with_json(TEXT, "joints.J.model", &value, &registry).is_err(), "{value}");
        }
    }
}
