//! Ctrl-C and SIGTERM: the first asks all work to stop and to keep what is computed, the second ends the program at
//! once.

use std::sync::{Condvar, LazyLock, Mutex, PoisonError};
use wireloom::session::Monitor;

/// Monitor of all computations, except sessions of the studio.
static MONITOR: LazyLock<Monitor> = LazyLock::new(Monitor::default);
/// Wakes waiting threads; the lock is for that alone.
static COME: (Mutex<()>, Condvar) = (Mutex::new(()), Condvar::new());
/// Exit code after Ctrl-C: 128 and the number of SIGINT.
const ENDED_BY_INTERRUPT: i32 = 130;

/// From now on signals stop the computation within an iteration; before, they end the program.
pub fn listen() {
    // Where no handler can be set, Ctrl-C ends the program at once.
    let _ = ctrlc::set_handler(|| {
        if asked() {
            leave(ENDED_BY_INTERRUPT);
        }
        stop();
    });
}

/// Ends the program at once while threads still run. Exit handlers of libraries are skipped: a driver that is closed
/// while one of these threads uses it crashes the program.
pub fn leave(code: i32) -> ! {
    #[cfg(unix)]
    signal_hook::low_level::exit(code);
    #[cfg(not(unix))]
    std::process::exit(code)
}

/// Stops the computation as a signal does, within an iteration.
pub fn stop() {
    MONITOR.stop();
    let _told = COME.0.lock().unwrap_or_else(PoisonError::into_inner);
    COME.1.notify_all();
}

/// Waits for a signal to stop.
pub fn wait() {
    let waiting = COME.0.lock().unwrap_or_else(PoisonError::into_inner);
    drop(COME.1.wait_while(waiting, |()| !asked()));
}

/// Whether a signal to stop has come.
pub fn asked() -> bool {
    MONITOR.is_stopped()
}

/// The monitor that the signal stops.
pub fn monitor() -> &'static Monitor {
    &MONITOR
}
