//! Settings of a scenario, as the page shows them and as a scenario has them.

use crate::frame::number;
use crate::protocol::{Form, Setting};
use serde_json::Value as Json;
use wireloom::Registry;
use wireloom::parts::Value;
use wireloom::scenario::Scenario;
use wireloom::scenario::adjust::{Adjustable, Holds, adjustable};
use wireloom::session::Refusal;

/// All settings of a scenario.
pub(super) fn all(scenario: &Scenario, registry: &Registry) -> Vec<Setting> {
    adjustable(scenario, registry).into_iter().map(setting).collect()
}

fn setting(own: Adjustable) -> Setting {
    let form = match own.holds {
        Holds::Choice(words) => Form::Choice { words },
        Holds::Number { unit, minimum, maximum } => {
            Form::Number { unit, minimum: Some(minimum), maximum: Some(maximum) }
        }
        Holds::Count(minimum) => Form::Count { minimum: number(minimum) },
        Holds::Flag => Form::Flag,
    };
    let value = own.value.map_or(Json::Null, |value| match value {
        Value::Number(x) => Json::from(x),
        Value::Count(n) => Json::from(n),
        Value::Flag(flag) => Json::from(flag),
        Value::Word(word) => Json::from(word),
        Value::Vector(v) => Json::from(vec![v.x, v.y, v.z]),
    });
    Setting { key: own.key, group: own.group, label: own.label, doc: own.doc, form, value }
}

/// Converts a setting's value from JSON.
pub(super) fn value(own: &Adjustable, given: &Json) -> Result<Value, Refusal> {
    let (value, wanted) = match &own.holds {
        Holds::Choice(words) => {
            let known: Vec<&str> = words.iter().map(|(word, _)| word.as_str()).collect();
            let word = given.as_str().filter(|word| known.contains(word));
            (word.map(|word| Value::Word(word.to_owned())), format!("one of: {}", known.join(", ")))
        }
        Holds::Number { unit, .. } => {
            let unit = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
            (given.as_f64().filter(|x| x.is_finite()).map(Value::Number), format!("a finite number{unit}"))
        }
        Holds::Count(minimum) => {
            let count = given.as_u64().and_then(|n| usize::try_from(n).ok()).filter(|n| n >= minimum);
            (count.map(Value::Count), format!("an integer of at least {minimum}"))
        }
        Holds::Flag => (given.as_bool().map(Value::Flag), "true or false".to_owned()),
    };
    value.ok_or_else(|| {
        let mut shown = given.to_string();
        shown.truncate(shown.floor_char_boundary(80));
        Refusal::new(format!("`{}` = {shown} is not a valid value", own.key), format!("give {wanted}"))
    })
}
