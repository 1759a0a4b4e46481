//! Monitor of a running computation: progress and interruption from other threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

/// Handle to interrupt a computation and to read its progress, from any thread; clones share the same data. Results do
/// not depend on it, except for [`crate::Status::Interrupted`].
#[derive(Clone, Debug, Default)]
pub struct Monitor(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    stopped: AtomicBool,
    iterations: AtomicU64,
    /// The bits of an f64.
    residual: AtomicU64,
}

impl Monitor {
    /// Requests the computation to stop: it ends within an iteration with [`crate::Status::Interrupted`].
    pub fn stop(&self) {
        self.0.stopped.store(true, Relaxed);
    }

    /// Withdraws the request of [`Self::stop`].
    pub fn go_on(&self) {
        self.0.stopped.store(false, Relaxed);
    }

    /// Whether a stop was requested. Long loops check this.
    pub fn is_stopped(&self) -> bool {
        self.0.stopped.load(Relaxed)
    }

    /// Counts an iteration of a minimiser that began at this relative residual. Returns whether a stop was requested.
    pub fn iterate(&self, residual: f64) -> bool {
        self.0.iterations.fetch_add(1, Relaxed);
        self.0.residual.store(residual.to_bits(), Relaxed);
        self.is_stopped()
    }

    /// Number of minimiser iterations so far, and the relative residual before the last one.
    pub fn seen(&self) -> (u64, f64) {
        (self.0.iterations.load(Relaxed), f64::from_bits(self.0.residual.load(Relaxed)))
    }
}

#[cfg(test)]
mod tests {
    use super::Monitor;

    #[test]
    fn clones_of_a_monitor_see_the_same() {
        let (one, other) = (Monitor::default(), Monitor::default());
        let same = one.clone();
        assert!(!same.iterate(0.5) && !same.iterate(0.25));
        assert_eq!((one.seen(), other.seen()), ((2, 0.25), (0, 0.0)));
        one.stop();
        assert!(same.iterate(0.125) && !other.is_stopped());
        same.go_on();
        assert!(!one.is_stopped());
    }
}
