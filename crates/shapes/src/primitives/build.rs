//! Kinds of primitives, and checked access to their parameters.

use crate::field::{Field, Primitive};
use wireloom_core::Parameters;
use wireloom_core::obstacle::Shape;
use wireloom_core::registry::{BuildError, Factory, Parameter, ShapeKind};

/// Kind of body that is given by its parameters alone.
pub(super) fn kind<F: Field + 'static>(
    name: &str,
    doc: &str,
    parameters: Vec<Parameter>,
    build: fn(&Parameters) -> Result<F, BuildError>,
) -> ShapeKind {
    let build: Factory<_, dyn Shape> = Box::new(move |_, parameters| Ok(Box::new(Primitive(build(parameters)?))));
    ShapeKind { name: name.into(), doc: doc.into(), parameters, build }
}

/// Length, m, that is declared with a default or as required.
///
/// # Errors
/// If it is negative or missing.
pub(super) fn length(parameters: &Parameters, name: &str) -> Result<f64, BuildError> {
    match parameters.number(name) {
        Some(length) if length >= 0.0 => Ok(length),
        Some(length) => {
            Err(BuildError::new(format!("`{name}` = {length} m is no length"), "it must be greater than 0 m").at(name))
        }
        None => Err(BuildError::new(format!("it has no `{name}`"), format!("add `{name}`, in m")).at(name)),
    }
}

/// Radius, m, of the hollow within a body of radius `radius`; 0 if there is none.
///
/// # Errors
/// If the hollow is as large as the body. `key` names the parameter that gives the body's radius.
pub(super) fn bore(parameters: &Parameters, key: &str, radius: f64) -> Result<f64, BuildError> {
    let bore = parameters.number("bore").unwrap_or(0.0);
    if bore < radius {
        return Ok(bore);
    }
    let message = format!("`bore` = {bore} m leaves nothing of a body with `{key}` = {radius} m");
    Err(BuildError::new(message, format!("give a radius of the hollow that is less than `{key}`")).at("bore"))
}
