//! How the time of something grows with the size of what it is given.

use std::time::{Duration, Instant};

/// Measurements of a size, of which the shortest counts.
const TIMES: usize = 2;
/// At four times the size it may take so many times as long: 4 is linear, 16 quadratic.
const MOST: f64 = 9.0;

/// Refuses work whose time grows like the square of its size. `prepare` makes what `work` is given.
///
/// # Panics
/// Where it takes longer.
pub fn no_square<T>(name: &str, n: usize, prepare: impl Fn(usize) -> T, work: impl Fn(&T)) {
    let times = [n, 2 * n, 4 * n].map(|size| {
        let given = prepare(size);
        (0..TIMES).map(|_| spent(|| work(&given))).min().unwrap_or_default()
    });
    let [once, _, four] = times.map(|time| time.as_secs_f64());
    assert!(four <= MOST * once, "{name} takes longer and longer: {times:?} at {n}, {}, {}", 2 * n, 4 * n);
}

/// What this thread spends on something: other work of the machine does not count where the system tells.
fn spent(work: impl FnOnce()) -> Duration {
    let begun = (on_processor(), Instant::now());
    work();
    match (begun.0, on_processor()) {
        (Some(from), Some(to)) => to - from,
        _ => begun.1.elapsed(),
    }
}

/// How long this thread has been on a processor (Linux).
fn on_processor() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(Duration::from_nanos(text.split_whitespace().next()?.parse().ok()?))
}
