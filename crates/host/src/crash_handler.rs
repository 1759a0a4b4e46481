//! A call that never comes back must not take with it what was computed: this process becomes another program, which saves it.

use crate::call::{self, Watchdog};
use std::ffi::{CStr, CString, OsString, c_char};
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicPtr, Ordering};
use std::time::Duration;

/// Program and arguments, ready for a moment in which nothing may be allocated.
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

/// From now on a plugin that crashes, ends the process, or takes more than `limit` for one call makes this process become `program` with these
/// arguments and three more: whose function it was, which function, and what happened. The last call counts, but for the limit, which is that of the
/// first.
pub fn install_crash_handler(program: &Path, arguments: &[OsString], limit: Duration) {
    let handler = CrashHandler {
        program: c_string(program.as_os_str()),
        arguments: arguments.iter().map(|a| c_string(a)).collect(),
    };
    // The one before it stays: another thread may be reading it.
    if !HANDLER.swap(Box::into_raw(Box::new(handler)), Ordering::AcqRel).is_null() {
        return;
    }
    #[cfg(unix)]
    signals::listen();
    let pause = limit / 8;
    // What a thread needs of the system's loader it must have before a library's own start holds the loader up.
    let (started, begun) = std::sync::mpsc::channel();
    let watch = move || {
        let took = CString::new(format!("did not come back within {} s", limit.as_secs_f64())).unwrap_or_default();
        let mut watch = Watchdog::default();
        let _ = started.send(());
        loop {
            std::thread::sleep(pause);
            if let Some((site, function)) = watch.overdue(limit) {
                exec_handler(site.words().as_ptr(), function.as_ptr(), took.as_ptr());
            }
        }
    };
    // A thread that cannot be had leaves calls unwatched, nothing worse.
    if std::thread::Builder::new().name("plugin watch".into()).spawn(watch).is_ok() {
        let _ = begun.recv();
    }
}

/// Most arguments of an heir.
const ARGUMENTS: usize = 16;

/// Becomes the heir. Allocates nothing where there is `exec`.
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
        (libc::SIGSEGV, c"crashed: it touched memory that is not its own (SIGSEGV)"),
        (libc::SIGBUS, c"crashed: it touched memory that is not there (SIGBUS)"),
        (libc::SIGILL, c"crashed: an illegal instruction (SIGILL)"),
        (libc::SIGFPE, c"crashed: an arithmetic fault (SIGFPE)"),
        (libc::SIGABRT, c"aborted the process (SIGABRT)"),
    ];

    /// What was in place before, and gets what happens outside of plugins.
    static PREVIOUS: OnceLock<[libc::sigaction; SIGNALS.len()]> = OnceLock::new();

    /// Takes over what ends a process, where it is inside a plugin.
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
        // Not a plugin's doing, or nobody to hand over to: what was there before gets it, as the instruction is tried again.
        // SAFETY: `before` is what the system gave us.
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
