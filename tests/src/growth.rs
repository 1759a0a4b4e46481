//! Growth of the time of some work with the size of its input.

use std::time::{Duration, Instant};

/// Measurements of a size, of which the shortest counts.
const TIMES: usize = 2;
/// Systems count the time of a thread in ticks of some milliseconds.
const LONG_ENOUGH: Duration = Duration::from_millis(200);
/// At four times the size it may take so many times as long: 4 is linear, 16 quadratic.
const MOST: f64 = 9.0;

/// Refuses work whose time grows like the square of its size. `prepare` makes what `work` is given.
///
/// # Panics
/// If it takes longer.
pub fn no_square<T>(name: &str, n: usize, prepare: impl Fn(usize) -> T, work: impl Fn(&T)) {
    let times = [n, 2 * n, 4 * n].map(|size| {
        let given = prepare(size);
        (0..TIMES).map(|_| spent(|| work(&given))).min().unwrap_or_default()
    });
    let [once, _, four] = times.map(|time| time.as_secs_f64());
    assert!(four <= MOST * once, "{name} takes longer and longer: {times:?} at {n}, {}, {}", 2 * n, 4 * n);
}

/// Mean time of this thread for some work, over [`LONG_ENOUGH`]. Other work of the machine does not count where the
/// system can tell.
fn spent(work: impl Fn()) -> Duration {
    let (from, begun, mut calls) = (on_processor(), Instant::now(), 0);
    while begun.elapsed() < LONG_ENOUGH {
        work();
        calls += 1;
    }
    let all = match (from, on_processor()) {
        (Some(from), Some(to)) => to - from,
        _ => begun.elapsed(),
    };
    all / calls
}

/// Time that this thread has been on a processor (Linux).
fn on_processor() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(Duration::from_nanos(text.split_whitespace().next()?.parse().ok()?))
}
