//! Descriptors of kinds as C reads them. They are leaked: the library is never unloaded.

use crate::table::Table;
use crate::{constraint, joint, rod};
use std::ffi::{CString, c_char};
use std::ptr::null;
use wireloom_abi as abi;
use wireloom_core::constraint::SpanUse;
use wireloom_core::registry::{ConstitutiveKind, ConstraintKind, Form, JointKind, Parameter, Quantity, Value};

/// The list of all kinds of a plugin.
pub fn kinds(
    constraints: Vec<ConstraintKind>,
    joints: Vec<JointKind>,
    rods: Vec<ConstitutiveKind>,
) -> &'static abi::Kinds {
    let joints = joints.into_iter().map(joint_kind);
    let kinds: Vec<abi::Kind> =
        constraints.into_iter().map(constraint_kind).chain(joints).chain(rods.into_iter().map(rod_kind)).collect();
    leak(abi::Kinds {
        size: size_of::<abi::Kinds>() as u32,
        count: kinds.len() as u32,
        stride: size_of::<abi::Kind>() as u32,
        reserved: 0,
        first: kinds.leak().as_ptr(),
    })
}

fn constraint_kind(kind: ConstraintKind) -> abi::Kind {
    let outputs = kind.outputs.iter().map(|output| abi::Output {
        name: text(&output.name),
        doc: text(&output.doc),
        quantity: abi_quantity(output.quantity),
        reserved: 0,
        event: i32::from(output.event),
        reserved_last: 0,
    });
    let outputs: &[abi::Output] = outputs.collect::<Vec<_>>().leak();
    let described = described(abi::FAMILY_CONSTRAINT, &kind.name, &kind.doc, &kind.parameters);
    let functions = abi::ConstraintKind {
        size: size_of::<abi::ConstraintKind>() as u32,
        stations_min: *kind.attaches.stations.start() as u32,
        stations_max: *kind.attaches.stations.end() as u32,
        span: match kind.attaches.span {
            SpanUse::Never => 0,
            SpanUse::Maybe => 1,
            SpanUse::Always => 2,
        },
        create: Some(constraint::create),
        destroy: Some(constraint::destroy),
        evaluate: Some(constraint::evaluate),
        target: Some(constraint::target),
        commit: Some(constraint::commit),
        output_count: outputs.len() as u32,
        output_stride: size_of::<abi::Output>() as u32,
        outputs: outputs.as_ptr(),
        report: Some(constraint::report),
    };
    abi::Kind { constraint: &raw const leak(Table { functions, kind }).functions, ..described }
}

fn joint_kind(kind: JointKind) -> abi::Kind {
    let described = described(abi::FAMILY_JOINT, &kind.name, &kind.doc, &kind.parameters);
    let functions = abi::JointKind {
        size: size_of::<abi::JointKind>() as u32,
        reserved: 0,
        create: Some(joint::create),
        destroy: Some(joint::destroy),
        evaluate: Some(joint::evaluate),
        commit: Some(joint::commit),
    };
    abi::Kind { joint: &raw const leak(Table { functions, kind }).functions, ..described }
}

fn rod_kind(kind: ConstitutiveKind) -> abi::Kind {
    let described = described(abi::FAMILY_ROD, &kind.name, &kind.doc, &kind.parameters);
    let functions = abi::RodKind {
        size: size_of::<abi::RodKind>() as u32,
        reserved: 0,
        create: Some(rod::create),
        destroy: Some(rod::destroy),
        stretch: Some(rod::stretch),
        bend: Some(rod::bend),
        commit: Some(rod::commit),
    };
    abi::Kind { rod: &raw const leak(Table { functions, kind }).functions, ..described }
}

/// Descriptor of a kind without its functions.
fn described(family: i32, name: &str, doc: &str, parameters: &[Parameter]) -> abi::Kind {
    let parameters: Vec<abi::Parameter> = parameters.iter().map(parameter).collect();
    abi::Kind {
        family,
        parameter_count: parameters.len() as u32,
        parameter_stride: size_of::<abi::Parameter>() as u32,
        reserved: 0,
        name: text(name),
        doc: text(doc),
        parameters: parameters.leak().as_ptr(),
        constraint: null(),
        joint: null(),
        rod: null(),
    }
}

fn parameter(parameter: &Parameter) -> abi::Parameter {
    let mut described = abi::Parameter {
        name: text(&parameter.name),
        doc: text(&parameter.doc),
        form: 0,
        quantity: abi::QUANTITY_DIMENSIONLESS,
        presence: match (&parameter.default, parameter.required) {
            (Some(_), _) => abi::PRESENCE_DEFAULT,
            (None, true) => abi::PRESENCE_REQUIRED,
            (None, false) => abi::PRESENCE_OPTIONAL,
        },
        minimum_excluded: 0,
        minimum: f64::NEG_INFINITY,
        maximum: f64::INFINITY,
        default_value: [0.0; 3],
        choices: null(),
        choice_count: 0,
        reserved: 0,
    };
    match &parameter.form {
        Form::Number { quantity, minimum, exclusive, maximum } => {
            described.form = abi::FORM_NUMBER;
            described.quantity = abi_quantity(*quantity);
            (described.minimum, described.maximum) = (*minimum, *maximum);
            described.minimum_excluded = i32::from(*exclusive);
        }
        Form::Vector { quantity } => {
            described.form = abi::FORM_VECTOR;
            described.quantity = abi_quantity(*quantity);
        }
        Form::Count { minimum } => {
            described.form = abi::FORM_COUNT;
            described.minimum = *minimum as f64;
        }
        Form::Flag => described.form = abi::FORM_FLAG,
        Form::Choice(choices) => {
            described.form = abi::FORM_CHOICE;
            described.choice_count = choices.len() as u32;
            let choices: Vec<*const c_char> = choices.iter().map(|word| text(word)).collect();
            described.choices = choices.leak().as_ptr();
        }
    }
    described.default_value = match (&parameter.default, &parameter.form) {
        (Some(Value::Number(x)), _) => [*x, 0.0, 0.0],
        (Some(Value::Vector(v)), _) => (*v).into(),
        (Some(Value::Count(n)), _) => [*n as f64, 0.0, 0.0],
        (Some(Value::Flag(flag)), _) => [f64::from(u8::from(*flag)), 0.0, 0.0],
        (Some(Value::Word(word)), Form::Choice(choices)) => {
            // The program refuses an index beyond the last choice.
            [choices.iter().position(|choice| choice == word).unwrap_or(choices.len()) as f64, 0.0, 0.0]
        }
        _ => [0.0; 3],
    };
    described
}

fn abi_quantity(quantity: Quantity) -> i32 {
    match quantity {
        Quantity::Dimensionless => abi::QUANTITY_DIMENSIONLESS,
        Quantity::Length => abi::QUANTITY_LENGTH,
        Quantity::Mass => abi::QUANTITY_MASS,
        Quantity::LinearDensity => abi::QUANTITY_LINEAR_DENSITY,
        Quantity::Force => abi::QUANTITY_FORCE,
        Quantity::Moment => abi::QUANTITY_MOMENT,
        Quantity::ForcePerLength => abi::QUANTITY_FORCE_PER_LENGTH,
        Quantity::MomentPerAngle => abi::QUANTITY_MOMENT_PER_ANGLE,
        Quantity::BendingStiffness => abi::QUANTITY_BENDING_STIFFNESS,
        Quantity::Curvature => abi::QUANTITY_CURVATURE,
        Quantity::Angle => abi::QUANTITY_ANGLE,
        Quantity::Acceleration => abi::QUANTITY_ACCELERATION,
        Quantity::Pressure => abi::QUANTITY_PRESSURE,
        Quantity::Density => abi::QUANTITY_DENSITY,
        Quantity::Velocity => abi::QUANTITY_VELOCITY,
        Quantity::Temperature => abi::QUANTITY_TEMPERATURE,
        Quantity::ThermalExpansion => abi::QUANTITY_THERMAL_EXPANSION,
        Quantity::ThermalCurvature => abi::QUANTITY_THERMAL_CURVATURE,
        Quantity::AngularSpeed => abi::QUANTITY_ANGULAR_SPEED,
        Quantity::Time => abi::QUANTITY_TIME,
        Quantity::Energy => abi::QUANTITY_ENERGY,
        Quantity::Area => abi::QUANTITY_AREA,
    }
}

fn text(text: &str) -> *const c_char {
    let until_zero = text.split('\0').next().unwrap_or_default();
    CString::new(until_zero).unwrap_or_default().into_raw()
}

fn leak<T>(value: T) -> &'static T {
    Box::leak(Box::new(value))
}
