//! The format in words: meaning, value and notation of every key, and the kinds of the registry. Derived from the
//! tables of keys and from the registry.

use super::form::{Family, Form, Key, Keys, Need};
use super::keys;
use super::kinds::{self, KindInfo};
use super::limits::{ANY, Bound, MAX_COUNT};
use super::units;
use crate::fault::nearest;
use wireloom_core::registry;
use wireloom_core::{Parameter, Quantity, Registry, Value};

/// A key of a scenario, or a parameter of a kind, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explained {
    /// Paths at which it may stand: `branches.length`. Names and numbers of entries are omitted.
    pub places: Vec<String>,
    /// The kind that has it, as a scenario chooses it: `kind = "lbfgs"`; `None` if all kinds have it.
    pub of: Option<String>,
    /// Its meaning.
    pub doc: String,
    /// Its value: `a length, from 1e-10 to 100000 m`.
    pub holds: String,
    /// Whether it must be given.
    pub need: String,
    /// Its default, if it has one.
    pub default: Option<String>,
    /// Example: lines of TOML.
    pub example: String,
}

/// A kind of the registry, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Model {
    /// Its name.
    pub name: String,
    /// Its purpose.
    pub doc: String,
    /// Its parameters.
    pub parameters: Vec<Explained>,
}

/// All kinds of one family, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Models {
    /// Word for one of them: `rod`.
    pub what: &'static str,
    /// Path of the key that chooses one: `branches.rod`.
    pub key: &'static str,
    /// The kind that is used if the key is left out.
    pub default: Option<&'static str>,
    /// The kinds, by name.
    pub models: Vec<Model>,
}

/// All kinds of a registry.
pub fn models(registry: &Registry) -> Vec<Models> {
    let families = [
        ("branches.rod", &keys::BRANCH),
        ("joints.model", &keys::JOINT),
        ("constraints.kind", &keys::CONSTRAINT),
        ("minimiser.kind", &keys::MINIMISER),
        ("obstacles.shape", &keys::OBSTACLE),
    ];
    let of = |(key, table): (&'static str, &'static Keys)| {
        let (word, family, default) = table.kind()?;
        let place = key.strip_suffix(word).unwrap_or(key).trim_end_matches('.');
        let model = |kind: &KindInfo<'_>| Model {
            name: kind.name.to_owned(),
            doc: kind.doc.to_owned(),
            parameters: kind.parameters.iter().map(|p| parameter(place, place, word, kind.name, p)).collect(),
        };
        let models = kinds::all(registry, family).iter().map(model).collect();
        Some(Models { what: family.word(), key, default, models })
    };
    families.into_iter().filter_map(of).collect()
}

/// All meanings of a key, such as `length`, `branches.length` or `branches.left.length`, or of the name of a kind.
///
/// # Errors
/// A suggestion, if there is no such key.
pub fn explain(key: &str, registry: &Registry) -> Result<Vec<Explained>, String> {
    let mut all = Vec::new();
    walk(&keys::SCENARIO, &[], registry, &mut all);
    let asked: Vec<&str> = key.trim().split('.').collect();
    let mut found: Vec<Explained> = Vec::new();
    for (steps, explained) in &all {
        if !(0..steps.len()).any(|from| means(&asked, &steps[from..])) {
            continue;
        }
        let same = |other: &&mut Explained| {
            Explained { places: vec![], example: String::new(), ..(*other).clone() }
                == Explained { places: vec![], example: String::new(), ..explained.clone() }
        };
        match found.iter_mut().find(same) {
            Some(known) => known.places.extend(explained.places.iter().cloned()),
            None => found.push(explained.clone()),
        }
    }
    if !found.is_empty() {
        return Ok(found);
    }
    let names = all.iter().filter_map(|(steps, _)| steps.last().map(|step| step.name.as_str()));
    let near = asked.last().and_then(|last| nearest(last, names));
    Err(near.map_or_else(
        || {
            let known: Vec<&str> = keys::SCENARIO.keys.iter().map(|key| key.name).collect();
            format!("a scenario has: {}", known.join(", "))
        },
        |near| format!("did you mean `{near}`?"),
    ))
}

/// A key on the path to another one.
#[derive(Clone, Debug)]
struct Step {
    name: String,
    /// Whether an entry of it may be named in between.
    many: bool,
}

/// Whether a path, with or without names of entries, leads along these keys.
fn means(asked: &[&str], steps: &[Step]) -> bool {
    match (asked, steps) {
        ([], []) => true,
        ([first, rest @ ..], [step, further @ ..]) if *first == step.name => {
            let named = step.many && !further.is_empty() && !rest.is_empty();
            means(rest, further) || (named && means(&rest[1..], further))
        }
        _ => false,
    }
}

/// All keys below a table of keys, each with its path.
fn walk(table: &'static Keys, way: &[(Step, Form)], registry: &Registry, all: &mut Vec<(Vec<Step>, Explained)>) {
    let steps = |last: &str, many: bool| -> Vec<Step> {
        way.iter().map(|(step, _)| step.clone()).chain([Step { name: last.to_owned(), many }]).collect()
    };
    let place = way.iter().map(|(step, _)| step.name.as_str()).collect::<Vec<_>>().join(".");
    let header = header(way);
    for key in table.keys {
        let (inner, many) = match key.form {
            Form::Table(inner) => (Some(inner), false),
            Form::Tables(inner) | Form::OneOrMoreTables(inner) | Form::Named(inner) | Form::NamesOrTables(inner) => {
                (Some(inner), true)
            }
            _ => (None, false),
        };
        let step = Step { name: key.name.to_owned(), many };
        all.push((steps(key.name, many), of_key(&place, &header, key, way)));
        if let Some(inner) = inner {
            let way: Vec<(Step, Form)> = way.iter().cloned().chain([(step, key.form)]).collect();
            walk(inner, &way, registry, all);
        }
    }
    if let Some((word, family, _)) = table.kind() {
        for kind in kinds::all(registry, family) {
            // The kind itself, by its name, and its parameters.
            let holds = format!("one of the kinds of {}", family.word());
            all.push((
                steps(kind.name, false),
                Explained {
                    places: vec![joined(&place, word)],
                    of: Some(chosen(word, kind.name)),
                    doc: kind.doc.to_owned(),
                    holds,
                    need: String::new(),
                    default: None,
                    example: with_header(&header, &chosen(word, kind.name)),
                },
            ));
            for parameter in kind.parameters {
                let explained = self::parameter(&place, &header, word, kind.name, parameter);
                all.push((steps(&parameter.name, false), explained));
            }
        }
    }
}

/// `[[steps.add]]`, or nothing at the top.
fn header(way: &[(Step, Form)]) -> String {
    let Some((_, last)) = way.last() else { return String::new() };
    let mut path: Vec<String> = Vec::new();
    for (step, form) in way {
        path.push(step.name.clone());
        if let Form::Named(_) = form {
            path.push("NAME".into());
        }
    }
    let path = path.join(".");
    match last {
        Form::Tables(_) | Form::OneOrMoreTables(_) | Form::NamesOrTables(_) => format!("[[{path}]]"),
        _ => format!("[{path}]"),
    }
}

fn with_header(header: &str, line: &str) -> String {
    if header.is_empty() { line.to_owned() } else { format!("{header}\n{line}") }
}

fn joined(place: &str, name: &str) -> String {
    if place.is_empty() { name.to_owned() } else { format!("{place}.{name}") }
}

fn chosen(key: &str, kind: &str) -> String {
    format!("{key} = \"{kind}\"")
}

fn of_key(place: &str, before: &str, key: &'static Key, way: &[(Step, Form)]) -> Explained {
    let (doc, default) = match key.doc.split_once("; default ") {
        Some((doc, default)) => (doc, Some(default.to_owned())),
        None => (key.doc, None),
    };
    let need = match key.need {
        Need::Must => "must be given".to_owned(),
        Need::May => "may be left out".to_owned(),
        Need::Unless(others) => format!("must be given, unless `{}` is", others.join("` or `")),
        Need::With(other) => format!("may be left out; goes with `{other}`"),
    };
    let example = match key.form {
        Form::Table(inner) | Form::Tables(inner) | Form::OneOrMoreTables(inner) | Form::Named(inner) => {
            let step = Step { name: key.name.to_owned(), many: true };
            let inside: Vec<(Step, Form)> = way.iter().cloned().chain([(step, key.form)]).collect();
            let needed = inner.keys.iter().filter(|key| key.need == Need::Must);
            let lines = needed.map(|key| format!("\n{} = {}", key.name, value(&key.form)));
            header(&inside) + &lines.collect::<String>()
        }
        _ => with_header(before, &format!("{} = {}", key.name, value(&key.form))),
    };
    Explained {
        places: vec![joined(place, key.name)],
        of: None,
        doc: doc.to_owned(),
        holds: holds(&key.form),
        need,
        default,
        example,
    }
}

fn parameter(place: &str, before: &str, word: &str, kind: &str, parameter: &Parameter) -> Explained {
    let must = parameter.required && parameter.default.is_none();
    let (holds, example) = match &parameter.form {
        registry::Form::Number { quantity, minimum, exclusive, maximum } => {
            let bound = Bound { minimum: *minimum, exclusive: *exclusive, maximum: *maximum };
            (number(*quantity, bound), a_number(*quantity, bound))
        }
        registry::Form::Vector { quantity } => (three(*quantity), vector(*quantity)),
        registry::Form::Count { minimum } => (count(*minimum, MAX_COUNT), minimum.to_string()),
        registry::Form::Flag => ("true or false".to_owned(), "true".to_owned()),
        registry::Form::Choice(words) => {
            (format!("one of {}", quoted(words)), words.first().map(|word| format!("{word:?}")).unwrap_or_default())
        }
    };
    let default = parameter.default.as_ref().map(written);
    let example = default.clone().unwrap_or(example);
    let before = if before.starts_with('[') || before.is_empty() { before.to_owned() } else { format!("[{before}]") };
    let lines = format!("{}\n{} = {example}", chosen(word, kind), parameter.name);
    Explained {
        places: vec![joined(place, &parameter.name)],
        of: Some(chosen(word, kind)),
        doc: parameter.doc.clone(),
        holds,
        need: if must { "must be given" } else { "may be left out" }.to_owned(),
        default,
        example: with_header(&before, &lines),
    }
}

/// A value as TOML, in SI units.
fn written(value: &Value) -> String {
    match value {
        Value::Number(x) => format!("{x}"),
        Value::Vector(v) => format!("[{}, {}, {}]", v.x, v.y, v.z),
        Value::Count(n) => n.to_string(),
        Value::Flag(flag) => flag.to_string(),
        Value::Word(word) => format!("{word:?}"),
    }
}

fn holds(form: &Form) -> String {
    match *form {
        Form::Version => "1".into(),
        Form::Name => "a name".into(),
        Form::Names => "a list of names".into(),
        Form::Kind(family, _) => format!("name of a {}: see `wireloom models`", family.word()),
        Form::Number(quantity, bound) => number(quantity, bound),
        Form::OneOrTwo(quantity, bound) => format!("{}, or two in a list", number(quantity, bound)),
        Form::Vector(quantity) => three(quantity),
        Form::Direction => "three numbers, a direction of any length".into(),
        Form::Orientation => "four numbers, a quaternion [w, x, y, z] of any length".into(),
        Form::Points(least) => format!("a list of points, at least {least}, each {}", three(Quantity::Length)),
        Form::Curve([x, y], least) => {
            let [x, y] = [x, y].map(|quantity| number(quantity, ANY));
            format!("a list of points, at least {least}, each a pair of {x}, and {y}")
        }
        Form::Directions => "a list of one or two directions".into(),
        Form::Count(minimum, maximum) => count(minimum, maximum),
        Form::Flag => "true or false".into(),
        Form::Choice(words) => format!("one of {}", quoted(words)),
        Form::Words(words) => format!("some of {}", quoted(words)),
        Form::Quantity => "a number of any quantity, in SI units or with its unit".into(),
        Form::QuantityOrList => "a number of any quantity, in SI units or with its unit, or a list of them".into(),
        Form::Values => "a list of values".into(),
        Form::Conditions => "keys, each by its path in quotes, with a value or a list of values".into(),
        Form::Table(inner) => format!("a table: {}", names(inner)),
        Form::Tables(inner) => format!("a list of tables, each with: {}", names(inner)),
        Form::OneOrMoreTables(inner) => format!("a table or a list of them, each with: {}", names(inner)),
        Form::Named(inner) => format!("tables by name, each with: {}", names(inner)),
        Form::NamesOrTables(inner) => format!("a name, a table or a list of them, with: {}", names(inner)),
    }
}

fn quoted<S: AsRef<str>>(words: &[S]) -> String {
    words.iter().map(|word| format!("{:?}", word.as_ref())).collect::<Vec<_>>().join(", ")
}

fn names(table: &Keys) -> String {
    table.keys.iter().map(|key| key.name).collect::<Vec<_>>().join(", ")
}

fn number(quantity: Quantity, bound: Bound) -> String {
    format!("{}, {}", units::words(quantity).name, bound.of(quantity).words(quantity))
}

fn three(quantity: Quantity) -> String {
    format!("three numbers, each {}", ANY.of(quantity).words(quantity))
}

fn count(minimum: usize, maximum: usize) -> String {
    format!("a whole number, from {minimum} to {maximum}")
}

fn vector(quantity: Quantity) -> String {
    let one = units::words(quantity).example;
    format!("[0, 0, {one}]")
}

/// Example of a number. Quantities with units have wide limits, in which their own example lies.
fn a_number(quantity: Quantity, bound: Bound) -> String {
    let Bound { minimum, maximum, .. } = bound.of(quantity);
    match quantity {
        Quantity::Dimensionless => 0.5_f64.clamp(minimum, maximum).to_string(),
        _ => units::words(quantity).example.to_owned(),
    }
}

/// Example of a value.
fn value(form: &Form) -> String {
    match *form {
        Form::Version => "1".into(),
        Form::Name => "\"NAME\"".into(),
        Form::Names => "[\"NAME\"]".into(),
        Form::Kind(family, default) => match (default, family) {
            (Some(default), _) => format!("{default:?}"),
            (None, Family::Constraint) => "\"connector\"".into(),
            (None, _) => "\"NAME\"".into(),
        },
        Form::Number(quantity, bound) | Form::OneOrTwo(quantity, bound) => a_number(quantity, bound),
        Form::Vector(quantity) => vector(quantity),
        Form::Direction => "[1, 0, 0]".into(),
        Form::Orientation => "[1, 0, 0, 0]".into(),
        Form::Points(_) => "[[0, 0, 0], [0.2, 0, 0.05]]".into(),
        Form::Curve(quantities, least) => {
            let number = |k: usize, unit: &str| if unit.is_empty() { k.to_string() } else { format!("\"{k} {unit}\"") };
            let point = |k: usize| quantities.map(|quantity| number(k, units::words(quantity).unit));
            let points: Vec<String> = (1..=least).map(|k| format!("[{}]", point(k).join(", "))).collect();
            format!("[{}]", points.join(", "))
        }
        Form::Directions => "[[1, 0, 0]]".into(),
        Form::Count(minimum, _) => minimum.max(1).to_string(),
        Form::Flag => "true".into(),
        Form::Choice(words) => format!("{:?}", words.first().copied().unwrap_or_default()),
        Form::Quantity => "\"5 mm\"".into(),
        Form::QuantityOrList => "\"30 deg\"".into(),
        Form::Values => "[1, 2, 3]".into(),
        Form::Conditions => "{ \"joints.J.model\" = \"cosserat\" }".into(),
        Form::Words(words) => format!("[{:?}]", words.first().copied().unwrap_or_default()),
        Form::Table(inner) => inline(inner),
        Form::Tables(inner) | Form::OneOrMoreTables(inner) | Form::NamesOrTables(inner) => {
            format!("[{}]", inline(inner))
        }
        Form::Named(inner) => format!("{{ NAME = {} }}", inline(inner)),
    }
}

/// A table in one line, with its required keys.
fn inline(table: &Keys) -> String {
    let needed = table.keys.iter().filter(|key| key.need == Need::Must);
    let pairs: Vec<String> = needed.map(|key| format!("{} = {}", key.name, value(&key.form))).collect();
    if pairs.is_empty() { "{}".into() } else { format!("{{ {} }}", pairs.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(name: &str) -> registry::MinimiserKind {
        let memory = Parameter {
            name: "memory".into(),
            doc: "how many steps it remembers".into(),
            form: registry::Form::Count { minimum: 1 },
            default: Some(Value::Count(8)),
            required: false,
        };
        registry::MinimiserKind {
            name: name.into(),
            doc: "goes downhill".into(),
            parameters: vec![memory],
            build: Box::new(|(), _| Err(registry::BuildError::new("not here", ""))),
        }
    }

    fn known() -> Registry {
        let mut registry = Registry::default();
        assert!(registry.add_minimiser(kind("walker")).is_ok());
        registry
    }

    fn one(key: &str) -> Explained {
        let mut found = explain(key, &known()).unwrap();
        assert_eq!(found.len(), 1, "{found:?}");
        found.remove(0)
    }

    #[test]
    fn a_key_has_meaning_unit_need_and_example() {
        let length = one("branches.length");
        assert_eq!(length.holds, "a length, from 1e-10 to 100000 m");
        assert_eq!((length.doc.as_str(), length.need.as_str()), ("unstressed length", "must be given"));
        assert_eq!(length.example, "[[branches]]\nlength = \"600 mm\"");
        assert_eq!(one("branches.left.length"), length);
        let tolerance = one("force_tolerance");
        assert_eq!(
            (tolerance.places, tolerance.default.as_deref()),
            (vec!["minimiser.force_tolerance".into()], Some("1e-6"))
        );
    }

    #[test]
    fn entries_of_tables_may_be_named_or_not() {
        let one_way = one("sections.diameter");
        assert_eq!(one_way, one("sections.trunk.diameter"));
        assert!(one_way.example.starts_with("[sections.NAME]\ndiameter = "), "{}", one_way.example);
        assert!(explain("branches.left.right.length", &known()).is_err());
    }

    #[test]
    fn what_stands_in_several_places_is_said_once() {
        let pull_out = explain("pull_out_force", &known()).unwrap();
        assert!(pull_out.iter().any(|e| e.places.contains(&"constraints.pull_out_force".to_owned())
            && e.places.contains(&"steps.add.pull_out_force".to_owned())));
    }

    #[test]
    fn kinds_and_their_parameters_are_explained() {
        let memory = one("minimiser.memory");
        assert_eq!((memory.of.as_deref(), memory.default.as_deref()), (Some("kind = \"walker\""), Some("8")));
        assert_eq!(memory.example, "[minimiser]\nkind = \"walker\"\nmemory = 8");
        assert_eq!(one("walker").doc, "goes downhill");
        let all = models(&known());
        let minimisers = all.iter().find(|models| models.key == "minimiser.kind").unwrap();
        assert_eq!((minimisers.what, minimisers.default), ("minimiser", Some("newton")));
        assert_eq!(minimisers.models[0].parameters, vec![memory]);
    }

    #[test]
    fn what_is_not_there_has_a_near_neighbour() {
        assert_eq!(explain("branches.lenght", &known()), Err("did you mean `length`?".into()));
        assert!(explain("qqqqqq", &known()).unwrap_err().starts_with("a scenario has: schema, name, gravity"));
    }

    /// The example of a tolerance up to 0.01 was 0.5.
    #[test]
    fn the_example_of_a_number_is_within_its_limits() {
        assert_eq!(one("force_tolerance").example, "[minimiser]\nforce_tolerance = 0.01");
    }

    /// Every example is TOML, and no key is without a word.
    #[test]
    fn every_key_is_explained_and_every_example_can_be_read() {
        let mut all = Vec::new();
        walk(&keys::SCENARIO, &[], &known(), &mut all);
        assert!(all.len() > 150, "{} keys", all.len());
        for (_, explained) in all {
            assert!(!explained.doc.is_empty() && !explained.holds.is_empty(), "{explained:?}");
            let read = explained.example.parse::<toml::Table>();
            assert!(read.is_ok(), "{:?}: {read:?}", explained.example);
        }
    }
}
