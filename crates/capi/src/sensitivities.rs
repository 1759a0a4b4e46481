//! Derivatives of results by numbers of a scenario.

use crate::call::{WireloomError, call};
use crate::cancel::{self, WireloomCancel};
use crate::failure::{Failure, WireloomCode};
use crate::pointers::{self, SizedStruct};
use crate::scenario::{WireloomScenario, source};
use crate::words::Words;
use crate::{handles, worker};
use std::ffi::c_char;
use std::sync::Arc;
use wireloom::sensitivity::{NoAnswer, Question, Sensitivities, Source, Study};

/// What the handle is called.
const WHAT: &str = "sensitivities";

/// Derivatives at the end of a step.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomSensitivities {
    /// 0: none.
    pub id: u64,
}

/// What is asked. Names and lists may be null, with a count of 0.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomQuestion {
    /// sizeof(WireloomQuestion), set by the caller.
    pub size: usize,
    /// Outputs, such as "force.plug-B" or the name of a requirement; none: all requirements.
    pub of: *const *const c_char,
    /// Number of outputs.
    pub of_count: usize,
    /// Keys with numbers, such as "branches.left.length"; none: those that the scenario's sweep varies.
    pub by: *const *const c_char,
    /// Number of keys.
    pub by_count: usize,
    /// Name of the step at whose end; null: the last one.
    pub step: *const c_char,
    /// Cancels the work; {0}: nothing does.
    pub cancel: WireloomCancel,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomQuestion {}

/// An answer as a whole. Its text is valid until the sensitivities are freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomAnswer {
    /// sizeof(WireloomAnswer), set by the caller.
    pub size: usize,
    /// Name of the step.
    pub step: *const c_char,
    /// Number of the increment, from 1.
    pub increment: usize,
    /// 1 if friction or parts that remember have a history, which is kept as it is.
    pub keeps_history: i32,
    /// Number of parameters, in the order of the question.
    pub parameter_count: usize,
    /// Number of outputs.
    pub output_count: usize,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomAnswer {}

/// A parameter. Its texts are valid until the sensitivities are freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomParameter {
    /// sizeof(WireloomParameter), set by the caller.
    pub size: usize,
    /// Its key.
    pub key: *const c_char,
    /// Its value, SI.
    pub value: f64,
    /// SI unit; empty for pure numbers.
    pub unit: *const c_char,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomParameter {}

/// An output. Its texts are valid until the sensitivities are freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomOutput {
    /// sizeof(WireloomOutput), set by the caller.
    pub size: usize,
    /// Its name.
    pub name: *const c_char,
    /// SI unit; empty for pure numbers.
    pub unit: *const c_char,
    /// Its value; NaN: none.
    pub value: f64,
    /// A remark; null: none.
    pub remark: *const c_char,
    /// Standard deviation by the tolerances of the scenario's sweep; NaN: none.
    pub deviation: f64,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomOutput {}

/// A derivative, SI. Its text is valid until the sensitivities are freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomDerivative {
    /// sizeof(WireloomDerivative), set by the caller.
    pub size: usize,
    /// Its value; NaN where it is not differentiable.
    pub value: f64,
    /// Where it is not: the derivative towards smaller values of the parameter; NaN: not known.
    pub towards_smaller: f64,
    /// That towards larger values; NaN: not known.
    pub towards_larger: f64,
    /// Why there is no derivative; null where there is one.
    pub reason: *const c_char,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomDerivative {}

/// What the handle stands for.
struct Kept {
    found: Sensitivities,
    words: Words,
}

fn get(sensitivities: WireloomSensitivities) -> Result<Arc<Kept>, Failure> {
    handles::get(sensitivities.id, WHAT)
}

/// Carries a scenario out up to the end of a step, and differentiates outputs there by numbers of the scenario.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_sensitivities_new(
    scenario: WireloomScenario,
    question: *const WireloomQuestion,
    sensitivities: *mut WireloomSensitivities,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let source = source(scenario)?;
        pointers::place(sensitivities, "sensitivities")?;
        let asked = pointers::given(question, "question")?;
        let asked = asked.ok_or_else(|| Failure::new(WireloomCode::NullPointer, "`question` is null", "ask one"))?;
        let of = pointers::texts(asked.of, asked.of_count, "of")?;
        let by = pointers::texts(asked.by, asked.by_count, "by")?;
        let step = pointers::text_if_given(asked.step, "step")?;
        let monitor = cancel::monitor(asked.cancel)?;
        let found = worker::computed(|| {
            let registry = wireloom::registry();
            source.refuse_plugins().map_err(|faults| Failure::refused(&source.text, &faults))?;
            let study = Source { monitor, ..Source::new(&source.text, &source.files, &registry) };
            let question = Question { of: &of, by: &by, step };
            Study::new(study).and_then(|mut study| study.answer(&question)).map_err(|none| match none {
                NoAnswer::Faults(faults) => Failure::refused(&source.text, &faults),
                NoAnswer::Part(fault) => Failure::new(WireloomCode::Part, fault.to_string(), ""),
                NoAnswer::Question(words) => Failure::not_found(words, ""),
                NoAnswer::Stopped => Failure::new(WireloomCode::Cancelled, "it was cancelled", ""),
                none => Failure::new(WireloomCode::NoAnswer, none.to_string(), ""),
            })
        })?;
        let id = handles::new(Kept { found, words: Words::default() });
        pointers::put(sensitivities, "sensitivities", WireloomSensitivities { id })
    })
}

/// An answer as a whole.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_sensitivities_get(
    sensitivities: WireloomSensitivities,
    answer: *mut WireloomAnswer,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(sensitivities)?;
        let value = WireloomAnswer {
            size: size_of::<WireloomAnswer>(),
            step: kept.words.of(&kept.found.step),
            increment: kept.found.increment,
            keeps_history: kept.found.keeps_history.into(),
            parameter_count: kept.found.parameters.len(),
            output_count: kept.found.outputs.len(),
        };
        pointers::fill(answer, "answer", value)
    })
}

/// A parameter, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_sensitivities_parameter(
    sensitivities: WireloomSensitivities,
    index: usize,
    parameter: *mut WireloomParameter,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(sensitivities)?;
        let all = &kept.found.parameters;
        let own = all.get(index).ok_or_else(|| Failure::no_index("parameter", index, all.len()))?;
        let value = WireloomParameter {
            size: size_of::<WireloomParameter>(),
            key: kept.words.of(&own.key),
            value: own.value,
            unit: kept.words.of(&own.unit),
        };
        pointers::fill(parameter, "parameter", value)
    })
}

/// An output, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_sensitivities_output(
    sensitivities: WireloomSensitivities,
    index: usize,
    output: *mut WireloomOutput,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(sensitivities)?;
        let all = &kept.found.outputs;
        let own = all.get(index).ok_or_else(|| Failure::no_index("output", index, all.len()))?;
        let value = WireloomOutput {
            size: size_of::<WireloomOutput>(),
            name: kept.words.of(&own.name),
            unit: kept.words.of(&own.unit),
            value: own.value.unwrap_or(f64::NAN),
            remark: kept.words.of_option(own.remark.as_deref()),
            deviation: own.spread.as_ref().map_or(f64::NAN, |spread| spread.deviation),
        };
        pointers::fill(output, "output", value)
    })
}

/// The derivative of an output by a parameter, both from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_sensitivities_derivative(
    sensitivities: WireloomSensitivities,
    output: usize,
    parameter: usize,
    derivative: *mut WireloomDerivative,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(sensitivities)?;
        let all = &kept.found.outputs;
        let by = &all.get(output).ok_or_else(|| Failure::no_index("output", output, all.len()))?.by;
        let own = by.get(parameter).ok_or_else(|| Failure::no_index("parameter", parameter, by.len()))?;
        let [smaller, larger] = own.sides.map(|side| side.unwrap_or(f64::NAN));
        let value = WireloomDerivative {
            size: size_of::<WireloomDerivative>(),
            value: own.value.unwrap_or(f64::NAN),
            towards_smaller: smaller,
            towards_larger: larger,
            reason: kept.words.of_option(own.reason.as_deref()),
        };
        pointers::fill(derivative, "derivative", value)
    })
}

/// Frees sensitivities.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_sensitivities_free(sensitivities: WireloomSensitivities) -> WireloomCode {
    call(std::ptr::null_mut(), || handles::free::<Kept>(sensitivities.id, WHAT))
}
