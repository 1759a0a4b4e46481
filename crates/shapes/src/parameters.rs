//! Declared parameters of shapes.

use wireloom_core::registry::{Form, Parameter};
use wireloom_core::{Quantity, Value};

/// A length above zero that must be given.
pub(crate) fn length(name: &str, doc: &str) -> Parameter {
    let form = Form::Number { quantity: Quantity::Length, minimum: 0.0, exclusive: true, maximum: f64::INFINITY };
    Parameter { name: name.into(), doc: doc.into(), form, default: None, required: true }
}

/// Radius of the hollow within.
pub(crate) fn bore(doc: &str) -> Parameter {
    let form = Form::Number { quantity: Quantity::Length, minimum: 0.0, exclusive: false, maximum: f64::INFINITY };
    Parameter { name: "bore".into(), doc: doc.into(), form, default: Some(Value::Number(0.0)), required: false }
}

/// Three numbers that must be given, or have a default.
pub(crate) fn vector(name: &str, doc: &str, quantity: Quantity, default: Option<wireloom_core::Vector>) -> Parameter {
    Parameter {
        name: name.into(),
        doc: doc.into(),
        form: Form::Vector { quantity },
        required: default.is_none(),
        default: default.map(Value::Vector),
    }
}

/// true or false; false where it is left out.
pub(crate) fn flag(name: &str, doc: &str) -> Parameter {
    Parameter {
        name: name.into(),
        doc: doc.into(),
        form: Form::Flag,
        default: Some(Value::Flag(false)),
        required: false,
    }
}
