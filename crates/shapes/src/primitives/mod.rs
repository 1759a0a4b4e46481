//! Planes, boxes, cylinders, capsules, spheres and tori, each in axes of its own with its middle at the origin.

mod cuboid;
mod cylinder;
mod plane;
mod revolution;
mod round;
#[cfg(test)]
mod tests;

use crate::field::{Field, Primitive};
use wireloom_core::Parameters;
use wireloom_core::obstacle::Shape;
use wireloom_core::registry::{BuildError, Parameter, ShapeKind};

/// All kinds of primitives.
pub fn kinds() -> Vec<ShapeKind> {
    vec![plane::plane(), cuboid::cuboid(), cylinder::cylinder(), round::capsule(), round::sphere(), round::torus()]
}

/// A kind whose bodies are given by their parameters alone.
fn kind<F: Field + 'static>(
    name: &str,
    doc: &str,
    parameters: Vec<Parameter>,
    build: fn(&Parameters) -> Result<F, BuildError>,
) -> ShapeKind {
    let build: wireloom_core::registry::Factory<_, dyn Shape> =
        Box::new(move |_, parameters| Ok(Box::new(Primitive(build(parameters)?))));
    ShapeKind { name: name.into(), doc: doc.into(), parameters, build }
}

/// A length that is declared with a default or as required.
fn length(parameters: &Parameters, name: &str) -> Result<f64, BuildError> {
    match parameters.number(name) {
        Some(length) if length >= 0.0 => Ok(length),
        Some(length) => {
            Err(BuildError::new(format!("`{name}` = {length} m is no length"), "it must be greater than 0 m").at(name))
        }
        None => Err(BuildError::new(format!("it has no `{name}`"), format!("add `{name}`, in m")).at(name)),
    }
}

/// Radius of the hollow within a body of some radius; 0: it has none.
fn bore(parameters: &Parameters, key: &str, radius: f64) -> Result<f64, BuildError> {
    let bore = parameters.number("bore").unwrap_or(0.0);
    if bore < radius {
        return Ok(bore);
    }
    let message = format!("`bore` = {bore} m leaves nothing of a body with `{key}` = {radius} m");
    Err(BuildError::new(message, format!("give a radius of the hollow that is less than `{key}`")).at("bore"))
}
