//! Ctrl-C and SIGTERM: the first asks all work to stop and to keep what is computed, the second ends the program at once.

use std::sync::{Condvar, LazyLock, Mutex, PoisonError};
use wireloom::core::Monitor;

/// Of everything that this program computes, but for sessions of the studio.
static MONITOR: LazyLock<Monitor> = LazyLock::new(Monitor::default);
/// Wakes who waits for it; the lock is for that alone.
static COME: (Mutex<()>, Condvar) = (Mutex::new(()), Condvar::new());
/// What shells report of a program ended by Ctrl-C: 128 and the number of SIGINT.
const ENDED_BY_INTERRUPT: i32 = 130;

/// From now on signals to end are heeded within an iteration; before, they end the program.
pub fn listen() {
    // Where no handler can be set, Ctrl-C ends the program as it does any other.
    let _ = ctrlc::set_handler(|| {
        if asked() {
            leave(ENDED_BY_INTERRUPT);
        }
        MONITOR.stop();
        let _told = COME.0.lock().unwrap_or_else(PoisonError::into_inner);
        COME.1.notify_all();
    });
}

/// Ends the program at once while threads still run. What libraries have to be done at an end is left out: a driver that is taken
/// apart while one of these threads is within it brings the whole program down.
pub fn leave(code: i32) -> ! {
    #[cfg(unix)]
    signal_hook::low_level::exit(code);
    #[cfg(not(unix))]
    std::process::exit(code)
}

/// Waits until somebody asks to stop.
pub fn wait() {
    let waiting = COME.0.lock().unwrap_or_else(PoisonError::into_inner);
    drop(COME.1.wait_while(waiting, |()| !asked()));
}

/// Whether somebody has asked to stop.
pub fn asked() -> bool {
    MONITOR.is_stopped()
}

/// What stops with it.
pub fn monitor() -> &'static Monitor {
    &MONITOR
}
