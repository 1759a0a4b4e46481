//! Converts a plugin's descriptors to types of the core, with checks.

use crate::error::Reason;
use crate::read;
use std::collections::BTreeSet;
use wireloom_abi as abi;
use wireloom_core::Vector;
use wireloom_core::constraint::{Attaches, SpanUse};
use wireloom_core::registry::{Form, Output, Parameter, Quantity, Value};

/// Upper limit for kinds of a plugin, parameters of a kind, choices of a parameter and stations of a constraint.
const MOST: u32 = 256;
const MOST_STATIONS: u32 = 64;

/// Checked descriptor of a kind.
pub struct KindDescription {
    /// Name in scenarios.
    pub name: String,
    /// One-line description.
    pub doc: String,
    /// Parameters.
    pub parameters: Vec<Parameter>,
    /// Its descriptor in the plugin.
    pub kind: *const abi::Kind,
    /// Its functions.
    pub functions: Functions,
}

/// Functions of a kind, by family.
pub enum Functions {
    /// A constraint kind, with its attachments and its outputs.
    Constraint(abi::ConstraintKind, Attaches, Vec<Output>),
    /// A joint model.
    Joint(abi::JointKind),
    /// A rod.
    Rod(abi::RodKind),
}

/// Reads all kinds.
///
/// # Safety
/// `kinds` and what it points to are as the ABI demands, as far as this cannot be checked.
pub unsafe fn kinds(kinds: *const abi::Kinds) -> Result<Vec<KindDescription>, Reason> {
    // SAFETY: as the caller promises; the size is the first field.
    unsafe {
        read::pointer("its list of kinds", kinds)?;
        let table: abi::Kinds = read::read_struct("list of kinds", kinds, (*kinds).size)?;
        let all = read::array("kinds", table.first, table.count, table.stride, MOST)?;
        let mut names = BTreeSet::new();
        let mut described = vec![];
        for (k, kind) in all.iter().enumerate() {
            let at = table.first.byte_add(k * table.stride as usize);
            let one = one(at, kind, &format!("kind {}", k + 1))?;
            if !names.insert(one.name.clone()) {
                return Err(Reason::Duplicate { what: format!("kind `{}`", one.name) });
            }
            described.push(one);
        }
        if described.is_empty() {
            return Err(Reason::Kinds("it has none".into()));
        }
        Ok(described)
    }
}

fn wrong(what: String, value: impl ToString, right: &str) -> Reason {
    Reason::Value { what, value: value.to_string(), right: right.to_owned() }
}

/// # Safety
/// As for [`kinds`].
unsafe fn one(at: *const abi::Kind, kind: &abi::Kind, which: &str) -> Result<KindDescription, Reason> {
    // SAFETY: as the caller promises.
    unsafe {
        let name = read::name(&format!("the name of {which}"), kind.name)?;
        let which = format!("kind `{name}`");
        let doc = read::text(&format!("the doc of {which}"), kind.doc)?;
        let what = format!("parameters of {which}");
        let declared = read::array(&what, kind.parameters, kind.parameter_count, kind.parameter_stride, MOST)?;
        let mut parameters: Vec<Parameter> = vec![];
        for (k, declared) in declared.iter().enumerate() {
            let one = parameter(declared, &format!("parameter {} of {which}", k + 1))?;
            if parameters.iter().any(|other| other.name == one.name) {
                return Err(Reason::Duplicate { what: format!("parameter `{}` of {which}", one.name) });
            }
            parameters.push(one);
        }
        let table = format!("table of functions of {which}");
        let (functions, create, destroy) = match kind.family {
            abi::FAMILY_CONSTRAINT => {
                read::pointer(&format!("the {table}"), kind.constraint)?;
                let own: abi::ConstraintKind = read::read_struct(&table, kind.constraint, (*kind.constraint).size)?;
                let functions = Functions::Constraint(own, attaches(&own, &which)?, outputs(&own, &which)?);
                (functions, own.create.is_some(), own.destroy.is_some())
            }
            abi::FAMILY_JOINT => {
                read::pointer(&format!("the {table}"), kind.joint)?;
                let own: abi::JointKind = read::read_struct(&table, kind.joint, (*kind.joint).size)?;
                (Functions::Joint(own), own.create.is_some(), own.destroy.is_some())
            }
            abi::FAMILY_ROD => {
                read::pointer(&format!("the {table}"), kind.rod)?;
                let own: abi::RodKind = read::read_struct(&table, kind.rod, (*kind.rod).size)?;
                (Functions::Rod(own), own.create.is_some(), own.destroy.is_some())
            }
            other => {
                let right = "1 is a constraint, 2 a joint model, 3 a rod";
                return Err(wrong(format!("the family of {which}"), other, right));
            }
        };
        for (there, function) in [(create, "create"), (destroy, "destroy")] {
            if !there {
                return Err(Reason::Pointer {
                    what: format!("the function `{function}` of {which}"),
                    value: "null".into(),
                });
            }
        }
        Ok(KindDescription { name, doc, parameters, kind: at, functions })
    }
}

/// Outputs of a constraint kind.
///
/// # Safety
/// As for [`kinds`].
unsafe fn outputs(functions: &abi::ConstraintKind, which: &str) -> Result<Vec<Output>, Reason> {
    let (kind, what) = (which, format!("outputs of {which}"));
    // SAFETY: as the caller promises.
    let declared =
        unsafe { read::array(&what, functions.outputs, functions.output_count, functions.output_stride, MOST) }?;
    let mut outputs: Vec<Output> = vec![];
    for (k, declared) in declared.iter().enumerate() {
        let which = format!("output {} of {which}", k + 1);
        // SAFETY: as the caller promises.
        let name = unsafe { read::name(&format!("the name of {which}"), declared.name) }?;
        let which = format!("{which} (`{name}`)");
        // SAFETY: as above.
        let doc = unsafe { read::text(&format!("the doc of {which}"), declared.doc) }?;
        let known = quantity(declared.quantity);
        let quantity =
            known.ok_or_else(|| wrong(format!("the quantity of {which}"), declared.quantity, "0 to 13 are known"))?;
        if outputs.iter().any(|other| other.name == name) {
            return Err(Reason::Duplicate { what: format!("output `{name}` of {kind}") });
        }
        outputs.push(Output { name, doc, quantity, event: declared.event != 0 });
    }
    if !outputs.is_empty() && functions.report.is_none() {
        return Err(Reason::Pointer { what: format!("the function `report` of {which}"), value: "null".into() });
    }
    Ok(outputs)
}

/// Stations and span of a constraint kind.
fn attaches(functions: &abi::ConstraintKind, which: &str) -> Result<Attaches, Reason> {
    let (least, most) = (functions.stations_min, functions.stations_max);
    if least > most || most > MOST_STATIONS {
        let right = format!("the first must not be above the second, nor that above {MOST_STATIONS}");
        return Err(wrong(format!("the number of stations of {which}"), format!("{least} to {most}"), &right));
    }
    let span = match functions.span {
        0 => SpanUse::Never,
        1 => SpanUse::Maybe,
        2 => SpanUse::Always,
        other => return Err(wrong(format!("`span` of {which}"), other, "0: never, 1: where one is given, 2: always")),
    };
    if most == 0 && span == SpanUse::Never {
        return Err(wrong(format!("the number of stations of {which}"), 0, "it needs a station or a span"));
    }
    Ok(Attaches { stations: least as usize..=most as usize, span })
}

/// # Safety
/// As for [`kinds`].
unsafe fn parameter(declared: &abi::Parameter, which: &str) -> Result<Parameter, Reason> {
    // SAFETY: as the caller promises.
    let name = unsafe { read::name(&format!("the name of {which}"), declared.name) }?;
    let which = format!("{which} (`{name}`)");
    // SAFETY: as above.
    let doc = unsafe { read::text(&format!("the doc of {which}"), declared.doc) }?;
    let quantity = || {
        quantity(declared.quantity)
            .ok_or_else(|| wrong(format!("the quantity of {which}"), declared.quantity, "0 to 13 are known"))
    };
    let form = match declared.form {
        abi::FORM_NUMBER => {
            let (minimum, maximum) = (declared.minimum, declared.maximum);
            if minimum.is_nan() || maximum.is_nan() || minimum > maximum {
                let right = "the first must not be above the second; -INFINITY and INFINITY are no bounds";
                return Err(wrong(format!("the range of {which}"), format!("{minimum} to {maximum}"), right));
            }
            Form::Number { quantity: quantity()?, minimum, exclusive: declared.minimum_excluded != 0, maximum }
        }
        abi::FORM_VECTOR => Form::Vector { quantity: quantity()? },
        abi::FORM_COUNT => Form::Count { minimum: declared.minimum.clamp(0.0, 1e15) as usize },
        abi::FORM_FLAG => Form::Flag,
        // SAFETY: as the caller promises.
        abi::FORM_CHOICE => Form::Choice(unsafe { choices(declared, &which) }?),
        other => return Err(wrong(format!("the form of {which}"), other, "1 to 5 are known")),
    };
    let default = match declared.presence {
        abi::PRESENCE_DEFAULT => Some(default(declared.default_value, &form).ok_or_else(|| {
            wrong(
                format!("the default of {which}"),
                format!("{:?}", declared.default_value),
                "it must be a value that a scenario may give",
            )
        })?),
        abi::PRESENCE_REQUIRED | abi::PRESENCE_OPTIONAL => None,
        other => {
            return Err(wrong(
                format!("the presence of {which}"),
                other,
                "0: required, 1: optional, 2: with a default",
            ));
        }
    };
    Ok(Parameter { name, doc, form, default, required: declared.presence == abi::PRESENCE_REQUIRED })
}

/// # Safety
/// As for [`kinds`].
unsafe fn choices(declared: &abi::Parameter, which: &str) -> Result<Vec<String>, Reason> {
    let count = declared.choice_count;
    if count == 0 || count > MOST {
        return Err(wrong(format!("the number of words of {which}"), count, "1 to 256 are allowed"));
    }
    read::pointer(&format!("the words of {which}"), declared.choices)?;
    // SAFETY: as the caller promises.
    (0..count as usize)
        .map(|k| unsafe { read::text(&format!("word {} of {which}", k + 1), *declared.choices.add(k)) })
        .collect()
}

/// The default value, if it is one that a scenario could give.
fn default(value: [f64; 3], form: &Form) -> Option<Value> {
    let whole = (value[0] >= 0.0 && value[0].fract() == 0.0 && value[0] <= 1e15).then_some(value[0] as usize);
    match form {
        Form::Number { minimum, exclusive, maximum, .. } => {
            let x = value[0];
            let low = x < *minimum || (*exclusive && x == *minimum);
            (x.is_finite() && !low && x <= *maximum).then_some(Value::Number(x))
        }
        Form::Vector { .. } => value.iter().all(|x| x.is_finite()).then(|| Value::Vector(Vector::from(value))),
        Form::Count { minimum } => whole.filter(|n| n >= minimum).map(Value::Count),
        Form::Flag => whole.filter(|n| *n < 2).map(|n| Value::Flag(n == 1)),
        Form::Choice(words) => words.get(whole?).cloned().map(Value::Word),
    }
}

fn quantity(plain: i32) -> Option<Quantity> {
    Some(match plain {
        abi::QUANTITY_DIMENSIONLESS => Quantity::Dimensionless,
        abi::QUANTITY_LENGTH => Quantity::Length,
        abi::QUANTITY_MASS => Quantity::Mass,
        abi::QUANTITY_LINEAR_DENSITY => Quantity::LinearDensity,
        abi::QUANTITY_FORCE => Quantity::Force,
        abi::QUANTITY_MOMENT => Quantity::Moment,
        abi::QUANTITY_FORCE_PER_LENGTH => Quantity::ForcePerLength,
        abi::QUANTITY_MOMENT_PER_ANGLE => Quantity::MomentPerAngle,
        abi::QUANTITY_BENDING_STIFFNESS => Quantity::BendingStiffness,
        abi::QUANTITY_CURVATURE => Quantity::Curvature,
        abi::QUANTITY_ANGLE => Quantity::Angle,
        abi::QUANTITY_ACCELERATION => Quantity::Acceleration,
        abi::QUANTITY_PRESSURE => Quantity::Pressure,
        abi::QUANTITY_DENSITY => Quantity::Density,
        abi::QUANTITY_VELOCITY => Quantity::Velocity,
        abi::QUANTITY_TEMPERATURE => Quantity::Temperature,
        abi::QUANTITY_THERMAL_EXPANSION => Quantity::ThermalExpansion,
        abi::QUANTITY_THERMAL_CURVATURE => Quantity::ThermalCurvature,
        abi::QUANTITY_ANGULAR_SPEED => Quantity::AngularSpeed,
        abi::QUANTITY_TIME => Quantity::Time,
        abi::QUANTITY_ENERGY => Quantity::Energy,
        abi::QUANTITY_AREA => Quantity::Area,
        _ => return None,
    })
}

/// The value of a parameter as the ABI has it.
pub fn abi_value(value: Option<&Value>, form: &Form) -> abi::Value {
    let value = value.map(|value| match (value, form) {
        (Value::Number(x), _) => [*x, 0.0, 0.0],
        (Value::Vector(v), _) => (*v).into(),
        (Value::Count(n), _) => [*n as f64, 0.0, 0.0],
        (Value::Flag(flag), _) => [f64::from(u8::from(*flag)), 0.0, 0.0],
        (Value::Word(word), Form::Choice(words)) => {
            [words.iter().position(|choice| choice == word).unwrap_or_default() as f64, 0.0, 0.0]
        }
        (Value::Word(_), _) => [0.0; 3],
    });
    abi::Value { value: value.unwrap_or_default(), given: i32::from(value.is_some()), reserved: 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::{c_char, c_void};
    use std::time::Duration;
    use wireloom_testkit::fuzz::Fuzz;

    /// Number of inputs by default.
    const FEW: u64 = 2000;
    /// Upper limit for the stated size of an array, bytes.
    const ARRAY: usize = (MOST as usize + 1) * 65536;

    /// A part of a descriptor: its size and its offset in the buffer that holds all parts. Zeros follow every array,
    /// because the length that a plugin states cannot be checked.
    struct Part {
        size: usize,
        at: usize,
    }

    const KINDS: Part = Part { size: size_of::<abi::Kinds>(), at: 0 };
    const FUNCTIONS: Part = Part { size: size_of::<abi::ConstraintKind>(), at: 64 };
    const TEXTS: Part = Part { size: 192, at: 256 };
    const CHOICES: Part = Part { size: 24, at: 8192 };
    const KIND: Part = Part { size: size_of::<abi::Kind>(), at: 16384 };
    const PARAMETER: Part = Part { size: size_of::<abi::Parameter>(), at: KIND.at + ARRAY };
    const OUTPUT: Part = Part { size: size_of::<abi::Output>(), at: PARAMETER.at + ARRAY };
    const BUFFER_SIZE: usize = OUTPUT.at + ARRAY;
    /// Order of the parts in an input.
    const PARTS: [Part; 7] = [KINDS, FUNCTIONS, TEXTS, CHOICES, KIND, PARAMETER, OUTPUT];

    /// Pointers in the buffer: offset of the pointer, offset of its target.
    const POINTERS: [(usize, usize); 16] = [
        (KINDS.at + 16, KIND.at),
        (KIND.at + 16, TEXTS.at),
        (KIND.at + 24, TEXTS.at + 8),
        (KIND.at + 32, PARAMETER.at),
        (KIND.at + 40, FUNCTIONS.at),
        (KIND.at + 48, FUNCTIONS.at),
        (KIND.at + 56, FUNCTIONS.at),
        (FUNCTIONS.at + 64, OUTPUT.at),
        (OUTPUT.at, TEXTS.at + 32),
        (OUTPUT.at + 8, TEXTS.at + 64),
        (PARAMETER.at, TEXTS.at + 32),
        (PARAMETER.at + 8, TEXTS.at + 64),
        (PARAMETER.at + 72, CHOICES.at),
        (CHOICES.at, TEXTS.at + 96),
        (CHOICES.at + 8, TEXTS.at + 128),
        (CHOICES.at + 16, TEXTS.at + 160),
    ];

    unsafe extern "C" fn create(
        _: *const abi::Kind,
        _: *const abi::ConstraintSpec,
        _: *mut *mut c_void,
        _: *mut abi::Description,
        _: *mut abi::Text,
    ) -> i32 {
        abi::STATUS_ERROR
    }

    unsafe extern "C" fn destroy(_: *mut c_void) {}

    unsafe extern "C" fn report(_: *const c_void, _: *const abi::Situation, _: *mut f64, _: *mut abi::Text) -> i32 {
        abi::STATUS_ERROR
    }

    fn bytes_of<T: Copy>(value: &T) -> &[u8] {
        // SAFETY: the structs of the ABI have no padding.
        unsafe { std::slice::from_raw_parts((&raw const *value).cast(), size_of::<T>()) }
    }

    /// A valid descriptor with one kind, one parameter and three choices; no pointer is null.
    fn good(form: i32) -> Vec<u8> {
        let kinds =
            abi::Kinds { size: KINDS.size as u32, count: 1, stride: KIND.size as u32, reserved: 0, first: dangling() };
        let functions = abi::ConstraintKind {
            size: FUNCTIONS.size as u32,
            stations_min: 1,
            stations_max: 2,
            span: 1,
            create: Some(create),
            destroy: Some(destroy),
            evaluate: None,
            target: None,
            commit: None,
            output_count: 1,
            output_stride: OUTPUT.size as u32,
            outputs: dangling(),
            report: Some(report),
        };
        let output = abi::Output {
            name: dangling(),
            doc: dangling(),
            quantity: abi::QUANTITY_FORCE,
            reserved: 0,
            event: 0,
            reserved_last: 0,
        };
        let mut texts = vec![0; TEXTS.size];
        for (line, text) in ["tie\0\0\0\0\0It ties.", "width", "How wide.", "a", "b", "c"].into_iter().enumerate() {
            texts[32 * line..][..text.len()].copy_from_slice(text.as_bytes());
        }
        let kind = abi::Kind {
            family: abi::FAMILY_CONSTRAINT,
            parameter_count: 1,
            parameter_stride: PARAMETER.size as u32,
            reserved: 0,
            name: dangling(),
            doc: dangling(),
            parameters: dangling(),
            constraint: dangling(),
            joint: dangling(),
            rod: dangling(),
        };
        let parameter = abi::Parameter {
            name: dangling(),
            doc: dangling(),
            form,
            quantity: abi::QUANTITY_LENGTH,
            presence: abi::PRESENCE_DEFAULT,
            minimum_excluded: 0,
            minimum: 0.0,
            maximum: 2.0,
            default_value: [1.0, 0.0, 0.0],
            choices: dangling(),
            choice_count: 3,
            reserved: 0,
        };
        let choices = [dangling::<c_char>(); 3];
        let parts = [bytes_of(&kinds), bytes_of(&functions), &texts, bytes_of(&choices), bytes_of(&kind)];
        [parts.concat().as_slice(), bytes_of(&parameter), bytes_of(&output)].concat()
    }

    const PLACEHOLDER: usize = 1 << 40;

    /// Placeholder for a pointer that is later replaced by its target in the buffer.
    fn dangling<T>() -> *const T {
        std::ptr::without_provenance(PLACEHOLDER)
    }

    /// Descriptors with arbitrary numbers, texts and null pointers are refused or accepted, but never cause a panic.
    /// Non-null pointers stay valid, because invalid ones cannot be detected.
    #[test]
    #[cfg_attr(not(target_pointer_width = "64"), ignore = "POINTERS are offsets of 8-byte pointers")]
    fn descriptors_never_make_the_reader_panic() {
        let inputs = std::env::var("WIRELOOM_FUZZ").ok().and_then(|text| text.parse().ok()).unwrap_or(FEW);
        let corpus: Vec<Vec<u8>> = (abi::FORM_NUMBER..=abi::FORM_CHOICE).map(good).collect();
        let mut buffer = vec![0_u64; BUFFER_SIZE / 8];
        let base = buffer.as_mut_ptr().cast::<u8>();
        let patience = Duration::from_secs(30);
        let words = ["tie", "\u{e9}", "\0"];
        let fuzz = Fuzz { name: "descriptors", corpus: &corpus, words: &words, seed: 1, inputs, patience };
        let (taken, _) = fuzz.hunt(|bytes| {
            let mut rest = bytes.to_vec();
            rest.resize(PARTS.iter().map(|part| part.size).sum(), 0);
            // SAFETY: all parts are in the buffer, which nothing else uses; non-null pointers point into it, and
            // functions are those above.
            unsafe {
                for part in PARTS {
                    base.add(part.at).copy_from_nonoverlapping(rest.as_ptr(), part.size);
                    rest.drain(..part.size);
                }
                for (at, to) in POINTERS {
                    let pointer = base.add(at).cast::<usize>();
                    // Null and invalid pointers are left as they are.
                    let lame =
                        *pointer < 4096 || !(TEXTS.at..CHOICES.at).contains(&to) && !(*pointer).is_multiple_of(8);
                    if !lame {
                        *pointer = base as usize + to;
                    }
                }
                let [create, destroy, report] =
                    [create as *const () as usize, destroy as *const () as usize, report as *const () as usize];
                for (field, function) in [(16, create), (24, destroy), (32, 0), (40, 0), (48, 0), (72, report)] {
                    let pointer = base.add(FUNCTIONS.at + field).cast::<usize>();
                    *pointer = if *pointer == 0 { 0 } else { function };
                }
                kinds(base.cast()).is_ok()
            }
        });
        assert!(taken > inputs / 10, "of {inputs} descriptors {taken} were taken");
    }
}
