//! A test of a kind, and what all tests share.

use std::time::Instant;
use wireloom::geometry::Vector;
use wireloom::parts::{Form, Parameter, Parameters, Value};
use wireloom::plugins::{floating_point_changes, numeric_derivatives};

/// Number of times that a constraint is created and destroyed.
pub const CYCLES: usize = 10_000;
/// Largest loss of memory for each, bytes: the system counts memory in pages.
const LEFT_BEHIND: f64 = 16.0;
/// Number of timed evaluations.
const TIMED: u32 = 10_000;
/// Number of concurrent threads, and evaluations of each.
const THREADS: (usize, usize) = (4, 500);

pub type Verdict = Result<String, String>;

pub type Trial<'k> = (String, Box<dyn FnOnce() -> Verdict + 'k>);

/// A value in the middle of the allowed range.
fn typical(form: &Form) -> Value {
    match form {
        Form::Number { minimum, maximum, .. } => Value::Number(match (minimum.is_finite(), maximum.is_finite()) {
            (true, true) => 0.5 * (minimum + maximum),
            (true, false) => minimum + 1.0,
            (false, true) => maximum - 1.0,
            (false, false) => 1.0,
        }),
        Form::Vector { .. } => Value::Vector(Vector::new(0.0, 0.0, 1.0)),
        Form::Count { minimum } => Value::Count(*minimum),
        Form::Flag => Value::Flag(false),
        Form::Choice(words) => Value::Word(words[0].clone()),
    }
}

/// Defaults, and typical values of required parameters; optional ones are left out.
pub fn parameters(declared: &[Parameter]) -> Parameters {
    let value = |p: &Parameter| p.default.clone().or_else(|| p.required.then(|| typical(&p.form)));
    Parameters(declared.iter().filter_map(|p| Some((p.name.clone(), value(p)?))).collect())
}

/// Whether the program computes the derivatives that a test is about, so that there is nothing to test.
pub fn is_numeric(kind: &str, test: &str) -> bool {
    let first = ["gradient_is", "jacobian_is"].iter().any(|name| test.starts_with(name));
    let second = ["hessian_is", "curvature_is"].iter().any(|name| test.starts_with(name));
    let of_kind = |words: &&String| words.starts_with(&format!("kind `{kind}` "));
    let no_first = |words: &String| words.contains("gradient and Hessian are") || words.contains("the Jacobian is");
    numeric_derivatives().iter().filter(of_kind).any(|words| second || first && no_first(words))
}

/// A test of the conformance suite by its name; one of derivatives that the program computes is left out.
pub fn conformance<'k>(kind: &str, name: &str, check: impl FnOnce() + 'k) -> Trial<'k> {
    let numeric = is_numeric(kind, name);
    let verdict = move || {
        if numeric {
            return Ok("not tested: the program computes them numerically, which is slower and less exact than \
                       derivatives of the plugin"
                .into());
        }
        check();
        Ok("ok".into())
    };
    (name.replace('_', " "), Box::new(verdict))
}

/// Whether several threads that evaluate at once, each with the arguments 0 to 6, get the same numbers as one.
pub fn threads(evaluate: impl Fn(f64) -> Vec<u64> + Sync, fault: impl FnOnce() -> Option<String>) -> Verdict {
    let (threads, times) = THREADS;
    let at = |k: usize| evaluate((k % 7) as f64);
    let want: Vec<Vec<u64>> = (0..7).map(at).collect();
    let same = std::thread::scope(|scope| {
        let all: Vec<_> = (0..threads).map(|_| scope.spawn(|| (0..times).all(|k| at(k) == want[k % 7]))).collect();
        all.into_iter().all(|thread| thread.join().unwrap_or(false))
    });
    match fault() {
        Some(fault) => Err(fault),
        None if same => Ok("ok".into()),
        None => {
            Err(format!("{threads} concurrent threads do not get the same numbers as one: leave `thread_safe` at 0"))
        }
    }
}

/// Time of an evaluation of all that `what` says.
pub fn time(evaluate: impl Fn() -> Vec<u64>, what: &str) -> Verdict {
    let clock = Instant::now();
    (0..TIMED).for_each(|_| drop(evaluate()));
    Ok(format!("{:.2} µs for all {what}", clock.elapsed().as_secs_f64() * 1e6 / f64::from(TIMED)))
}

/// Whether no call since the last of these tests changed the control of the floating-point unit.
pub fn floating_point<'k>(when: &str) -> Trial<'k> {
    let verdict = || match floating_point_changes().as_slice() {
        [] => Ok("ok".to_owned()),
        changes => Err(changes.join("\n      ")),
    };
    (format!("rounding mode and floating-point exceptions left as they are{when}"), Box::new(verdict))
}

/// Whether repeated creation, use and destruction loses memory.
pub fn leaks(cycle: impl Fn()) -> Verdict {
    (0..CYCLES / 10).for_each(|_| cycle());
    let before = memory();
    (0..CYCLES).for_each(|_| cycle());
    let (Some(before), Some(after)) = (before, memory()) else {
        return Ok("not tested: this system does not tell".into());
    };
    let each = after.saturating_sub(before) as f64 / CYCLES as f64;
    if each > LEFT_BEHIND {
        Err(format!("about {each:.0} bytes are lost with each creation and destruction"))
    } else {
        Ok("ok".into())
    }
}

/// Memory of this process, bytes, where the system tells.
fn memory() -> Option<u64> {
    let statm = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = statm.split(' ').nth(1)?.parse().ok()?;
    Some(pages * 4096)
}
