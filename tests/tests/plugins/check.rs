//! What `plugin check` finds, and what it does not hold against a plugin that is right.

use crate::*;

/// Case of `liar.c` that is right, and more arguments of its compiler.
const RIGHT: &[(u32, &str, &[&str])] = &[
    (0, "a spring", &[]),
    (1, "a shape that bends within 20 mm", &["-DEPSILON=20e-3"]),
    (1, "a shape that bends within 1 mm", &["-DEPSILON=1e-3"]),
    (1, "a shape that bends within 0.1 mm", &["-DEPSILON=1e-4"]),
    (2, "a cone", &[]),
    (3, "a cone as an equation, with its curvature", &[]),
    (4, "a cone as an equation, and a spring beside it", &[]),
];

/// Case that is wrong, and what must be said of it.
const WRONG: &[(u32, &str, &[&str])] = &[
    (
        10,
        "a doubled gradient without a Hessian",
        &["gradient is the derivative of the energy … FAILED", "hessian is the second derivative of the energy … not"],
    ),
    (11, "a gradient that is wrong by 1 %", &["gradient is the derivative of the energy … FAILED"]),
    (12, "seven times the force after a commit", &["gradient is the derivative of the energy … FAILED"]),
    (
        13,
        "the Hessian of the energy where that of the equations is asked for",
        &["curvature is the second derivative of the residuals or nothing … FAILED"],
    ),
    (20, "a number beyond the energy", &["wrote beyond the end of the array `energy`, which has 1 numbers"]),
    (21, "a number beyond the gradient", &["wrote beyond the end of the array `gradient`, which has 6 numbers"]),
    (22, "a number beyond the Hessian", &["wrote beyond the end of the array `Hessian`, which has 36 numbers"]),
    (23, "a number beyond the memory", &["wrote beyond the end of the array `memory`, which has 1 numbers"]),
    (25, "a number beyond the description", &["wrote beyond the end of the description in `create`"]),
    (26, "a number before the Hessian", &["wrote before the beginning of the array `Hessian`"]),
    (30, "another rounding mode", &["changed the rounding mode of the processor in `evaluate`"]),
    (31, "another rounding mode as it is loaded", &["changed the rounding mode of the processor in `kinds`"]),
    (32, "an end of the process as of success", &["ended the process without a trace (_exit, exit code 0) (in `eval"]),
];

pub fn trials() -> Vec<Named> {
    let mut all = vec![];
    for (case, what, more) in RIGHT {
        all.push((format!("plugin check passes {what}"), test(move || checked(*case, more, 0, &["all tests passed"]))));
    }
    for (case, what, words) in WRONG {
        all.push((format!("plugin check finds {what}"), test(move || checked(*case, &[], 3, words))));
    }
    all
}

fn test(check: impl FnOnce() -> Checked + Send + 'static) -> Box<dyn FnOnce() -> Checked + Send> {
    Box::new(check)
}

fn checked(case: u32, more: &[&str], code: i32, words: &[&str]) -> Checked {
    let place = Place::new()?;
    let case = format!("-DCASE={case}");
    let source = root().join("tests/tests/plugins/liar.c");
    compile(&source, &place.path("libliar.so"), &[&[&*case], more].concat())?;
    let ended = place.wireloom(&["plugin", "check", "libliar.so"])?.expect(code)?;
    let said = format!("{}{}", ended.out, ended.err);
    ensure(words.iter().all(|words| said.contains(words)), &ended)
}
