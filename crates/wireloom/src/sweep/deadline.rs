//! Time limits of points: a thread stops those that take longer.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use wireloom_core::Monitor;

/// Time between two looks at the running points.
const PAUSE: Duration = Duration::from_millis(20);

/// The running points of a sweep.
pub(super) struct Deadlines<'m> {
    limit: Option<Duration>,
    /// Stops all of them.
    whole: &'m Monitor,
    running: Mutex<Vec<Running>>,
    begun: AtomicU64,
    over: AtomicBool,
}

struct Running {
    number: u64,
    end: Instant,
    monitor: Monitor,
}

/// A running point.
pub(super) struct Deadline<'d> {
    all: &'d Deadlines<'d>,
    /// Stops it.
    pub monitor: Monitor,
    /// Its number, if it has a time limit.
    number: Option<u64>,
}

impl<'m> Deadlines<'m> {
    /// Points with this time limit, s.
    pub fn new(limit: Option<f64>, whole: &'m Monitor) -> Self {
        let limit = limit.map(Duration::from_secs_f64);
        Self { limit, whole, running: Mutex::default(), begun: AtomicU64::new(0), over: AtomicBool::new(false) }
    }

    /// Whether all points are to stop.
    pub fn is_stopped(&self) -> bool {
        self.whole.is_stopped()
    }

    /// Begins a point.
    pub fn begin(&self) -> Deadline<'_> {
        let Some(limit) = self.limit else { return Deadline { all: self, monitor: self.whole.clone(), number: None } };
        let (monitor, number) = (Monitor::default(), self.begun.fetch_add(1, Ordering::Relaxed));
        self.running().push(Running { number, end: Instant::now() + limit, monitor: monitor.clone() });
        Deadline { all: self, monitor, number: Some(number) }
    }

    /// Works, and stops the points meanwhile that take longer, or all of them if the whole is stopped.
    pub fn watch<R>(&self, work: impl FnOnce() -> R) -> R {
        if self.limit.is_none() {
            return work();
        }
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !self.over.load(Ordering::Relaxed) {
                    let now = Instant::now();
                    for running in self.running().iter() {
                        if self.is_stopped() || now >= running.end {
                            running.monitor.stop();
                        }
                    }
                    std::thread::sleep(PAUSE);
                }
            });
            // Also where the work panics, the thread has to end.
            let _over = Over(&self.over);
            work()
        })
    }

    fn running(&self) -> MutexGuard<'_, Vec<Running>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Deadline<'_> {
    fn drop(&mut self) {
        if let Some(number) = self.number {
            self.all.running().retain(|running| running.number != number);
        }
    }
}

struct Over<'o>(&'o AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
