//! Saves results when a plugin crashes or hangs: this process becomes another program (`exec`), which saves them.

use crate::call::{self, Watchdog};
use std::ffi::{CStr, CString, OsString, c_char};
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicPtr, Ordering};
use std::time::Duration;

/// Program and arguments, prepared in advance: a signal handler must not allocate.
struct CrashHandler {
    program: CString,
    arguments: Vec<CString>,
}

static HANDLER: AtomicPtr<CrashHandler> = AtomicPtr::new(null_mut());

fn handler() -> Option<&'static CrashHandler> {
    // SAFETY: null, or leaked by `install_crash_handler`.
    unsafe { HANDLER.load(Ordering::Acquire).as_ref() }
}

fn c_string(words: &std::ffi::OsStr) -> CString {
    CString::new(words.as_encoded_bytes().to_vec()).unwrap_or_default()
}

/// First words of what happened where a call took too long.
pub const LATE: &str = "did not return within";

/// Installs the crash handler: if a plugin crashes, ends the process, or takes longer than `limit` for one call, this
/// process becomes `program` with these arguments and three more: owner of the function, name of the function, and what
/// happened. A later call replaces program and arguments, but not the limit.
pub fn install_crash_handler(program: &Path, arguments: &[OsString], limit: Duration) {
    let handler = CrashHandler {
        program: c_string(program.as_os_str()),
        arguments: arguments.iter().map(|a| c_string(a)).collect(),
    };
    // The earlier handler is leaked: another thread may be reading it.
    if !HANDLER.swap(Box::into_raw(Box::new(handler)), Ordering::AcqRel).is_null() {
        return;
    }
    #[cfg(unix)]
    signals::listen();
    let pause = limit / 8;
    // The thread must start before a library's own initialisation can block the system's loader.
    let (started, begun) = std::sync::mpsc::channel();
    let watch = move || {
        let took = CString::new(format!("{LATE} {} s", limit.as_secs_f64())).unwrap_or_default();
        let mut watch = Watchdog::default();
        let _ = started.send(());
        loop {
            std::thread::sleep(pause);
            if let Some((site, function)) = watch.overdue(limit) {
                exec_handler(site.words().as_ptr(), function.as_ptr(), took.as_ptr());
            }
        }
    };
    // If the thread cannot be started, calls are not watched.
    if std::thread::Builder::new().name("plugin watch".into()).spawn(watch).is_ok() {
        let _ = begun.recv();
    }
}

/// Largest number of arguments of a handler.
const ARGUMENTS: usize = 16;

/// Replaces this process by the handler's program. Does not allocate where `exec` exists.
#[cfg(unix)]
fn exec_handler(site: *const c_char, function: *const c_char, happened: *const c_char) {
    let Some(handler) = handler() else { return };
    let mut all = [null::<c_char>(); ARGUMENTS + 5];
    let own = handler.arguments.iter().take(ARGUMENTS).map(|a| a.as_ptr());
    let words = std::iter::once(handler.program.as_ptr()).chain(own).chain([site, function, happened]);
    for (to, word) in all.iter_mut().zip(words) {
        *to = word;
    }
    // SAFETY: all are strings that end with a zero, and the list ends with a null.
    unsafe { libc::execv(handler.program.as_ptr(), all.as_ptr()) };
}

#[cfg(not(unix))]
fn exec_handler(site: *const c_char, function: *const c_char, happened: *const c_char) {
    let Some(handler) = handler() else { return };
    // SAFETY: all are strings that end with a zero.
    let words = [site, function, happened].map(|word| unsafe { CStr::from_ptr(word) });
    let words =
        handler.arguments.iter().map(CString::as_c_str).chain(words).map(|word| word.to_string_lossy().into_owned());
    let ended = std::process::Command::new(handler.program.to_string_lossy().as_ref()).args(words).status();
    std::process::exit(ended.ok().and_then(|status| status.code()).unwrap_or(3));
}

#[cfg(unix)]
mod signals {
    use super::{CStr, call, exec_handler};
    use std::ffi::c_int;
    use std::sync::OnceLock;

    const SIGNALS: [(c_int, &CStr); 5] = [
        (libc::SIGSEGV, c"crashed: invalid memory access (SIGSEGV)"),
        (libc::SIGBUS, c"crashed: access to unmapped memory (SIGBUS)"),
        (libc::SIGILL, c"crashed: an illegal instruction (SIGILL)"),
        (libc::SIGFPE, c"crashed: an arithmetic fault (SIGFPE)"),
        (libc::SIGABRT, c"aborted the process (SIGABRT)"),
    ];

    /// Signal handlers that were installed before; they receive signals raised outside of plugins.
    static PREVIOUS: OnceLock<[libc::sigaction; SIGNALS.len()]> = OnceLock::new();

    /// Installs handlers for the signals and the exit that end a process.
    pub fn listen() {
        PREVIOUS.get_or_init(|| {
            SIGNALS.map(|(signal, _)| {
                // SAFETY: plain structs of C, for which zeroes are valid; the handler is one for `SA_SIGINFO`.
                unsafe {
                    let mut before: libc::sigaction = std::mem::zeroed();
                    let mut action: libc::sigaction = std::mem::zeroed();
                    action.sa_sigaction = crashed as *const () as usize;
                    action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK | libc::SA_NODEFER;
                    libc::sigemptyset(&mut action.sa_mask);
                    libc::sigaction(signal, &action, &mut before);
                    before
                }
            })
        });
        // SAFETY: `ended` is a function without arguments.
        unsafe { libc::atexit(ended) };
    }

    extern "C" fn crashed(signal: c_int, _: *mut libc::siginfo_t, _: *mut libc::c_void) {
        let at = call::current_call();
        let found = SIGNALS.iter().position(|(watched, _)| *watched == signal);
        let (Some(which), Some(before)) = (found, PREVIOUS.get()) else { return };
        if !at.site.is_null() {
            exec_handler(at.site, at.function, SIGNALS[which].1.as_ptr());
        }
        // Not raised in a plugin, or no handler: restore the previous signal handler, which runs as the instruction is
        // retried.
        // SAFETY: `before` was returned by the system.
        unsafe {
            libc::sigaction(signal, &before[which], std::ptr::null_mut());
            if signal == libc::SIGABRT {
                libc::raise(signal);
            }
        }
    }

    extern "C" fn ended() {
        let at = call::current_call();
        if !at.site.is_null() {
            exec_handler(at.site, at.function, c"ended the process (exit)".as_ptr());
        }
    }
}
