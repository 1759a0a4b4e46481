//! Ctrl-C: the first asks a run to stop after the increment at hand, the second ends the program at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};

static ASKED: AtomicBool = AtomicBool::new(false);
/// Wakes who waits for it; the lock is for that alone.
static COME: (Mutex<()>, Condvar) = (Mutex::new(()), Condvar::new());
/// What shells report of a program ended by Ctrl-C: 128 and the number of SIGINT.
const ENDED_BY_INTERRUPT: i32 = 130;

/// From now on signals to end are heeded at the next increment.
pub fn listen() {
    // Where no handler can be set, Ctrl-C ends the program as it does any other.
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(ENDED_BY_INTERRUPT);
        }
        let _told = COME.0.lock().unwrap_or_else(PoisonError::into_inner);
        COME.1.notify_all();
    });
}

/// Waits until somebody asks to stop.
pub fn wait() {
    let waiting = COME.0.lock().unwrap_or_else(PoisonError::into_inner);
    drop(COME.1.wait_while(waiting, |()| !asked()));
}

/// Whether somebody has asked to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
