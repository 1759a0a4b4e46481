//! Calls into plugins, with a record of what each thread is calling.
//!
//! What cannot be caught within a process is handled as it ends: a watchdog detects calls that take too long, and on
//! systems with signals and `exec` crashes are detected too. Either way this process becomes another program, which
//! saves the results ([`crate::install_crash_handler`]).

use crate::floating_point::FloatingPoint;
use crate::supervision;
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::ffi::{CStr, CString};
use std::ptr::null;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Owner of the called functions, as text: plugin, file, constraint.
pub struct CallSite(CString);

impl CallSite {
    /// A call site with this text.
    pub fn new(words: &str) -> Arc<Self> {
        Arc::new(Self(CString::new(words.replace('\0', "")).unwrap_or_default()))
    }

    /// The text.
    pub fn words(&self) -> &CStr {
        &self.0
    }
}

/// The call state of a thread.
struct Slot {
    /// Odd while the thread is inside a plugin; incremented at every call and every return.
    sequence: AtomicU64,
    /// Where another process reads it, if one supervises this one.
    shared: Option<supervision::Slot>,
    /// The current or the last call.
    place: Mutex<Option<(Arc<CallSite>, &'static CStr)>>,
}

/// All threads that have called a plugin.
static SLOTS: Mutex<Vec<Weak<Slot>>> = Mutex::new(Vec::new());

/// The current call as a signal handler may read it: null while the thread is not inside a plugin.
#[derive(Clone, Copy)]
pub struct CurrentCall {
    /// Text of the call site, zero-terminated.
    pub site: *const std::ffi::c_char,
    /// Name of the function.
    pub function: *const std::ffi::c_char,
}

const NO_CALL: CurrentCall = CurrentCall { site: null(), function: null() };

thread_local! {
    static CURRENT: Cell<CurrentCall> = const { Cell::new(NO_CALL) };
    static SLOT: RefCell<Option<Arc<Slot>>> = const { RefCell::new(None) };
}

/// The current call of this thread.
pub fn current_call() -> CurrentCall {
    CURRENT.get()
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Calls that changed the control of the floating-point unit.
static CHANGES: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// Calls of plugins in this process that changed the control of the floating-point unit, since the last call of this
/// function: a message each. It was restored after each of them.
pub fn floating_point_changes() -> Vec<String> {
    std::mem::take(&mut *lock(&CHANGES)).into_iter().collect()
}

/// Calls a function of a plugin. The control of the floating-point unit is the same after the call.
pub fn call_plugin<R>(site: &Arc<CallSite>, function: &'static CStr, call: impl FnOnce() -> R) -> R {
    let slot = SLOT.with_borrow_mut(|slot| {
        slot.get_or_insert_with(|| {
            let slot = Arc::new(Slot {
                sequence: AtomicU64::new(0),
                shared: supervision::next_slot(),
                place: Mutex::new(None),
            });
            lock(&SLOTS).push(Arc::downgrade(&slot));
            slot
        })
        .clone()
    });
    {
        let mut place = lock(&slot.place);
        if !place.as_ref().is_some_and(|(is, at)| Arc::ptr_eq(is, site) && std::ptr::eq(*at, function)) {
            *place = Some((site.clone(), function));
            if let Some(shared) = &slot.shared {
                shared.name(site.words(), function);
            }
        }
    }
    CURRENT.set(CurrentCall { site: site.words().as_ptr(), function: function.as_ptr() });
    let count = || {
        let before = slot.sequence.fetch_add(1, Ordering::Release);
        if let Some(shared) = &slot.shared {
            shared.count(before + 1);
        }
    };
    count();
    let control = FloatingPoint::now();
    let result = call();
    if let Some(changed) = control.changed(FloatingPoint::now()) {
        control.restore();
        let (site, function) = (site.words().to_string_lossy(), function.to_string_lossy());
        let effect = "the program restored it after the call";
        lock(&CHANGES).insert(format!("{site} changed the {changed} of the processor in `{function}`: {effect}"));
    }
    count();
    CURRENT.set(NO_CALL);
    result
}

/// Watches from another thread for calls that do not return.
#[derive(Default)]
pub struct Watchdog {
    seen: Vec<(Weak<Slot>, u64, Instant)>,
}

impl Watchdog {
    /// Site and function of a call that has run for at least `limit`. Poll it: a call is timed from the first poll that
    /// sees it.
    pub fn overdue(&mut self, limit: Duration) -> Option<(Arc<CallSite>, &'static CStr)> {
        let slots: Vec<Arc<Slot>> = lock(&SLOTS).iter().filter_map(Weak::upgrade).collect();
        self.seen.retain(|(slot, ..)| slot.strong_count() > 0);
        for slot in slots {
            let sequence = slot.sequence.load(Ordering::Acquire);
            let known = self.seen.iter_mut().find(|(known, ..)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(&slot)));
            match known {
                None => self.seen.push((Arc::downgrade(&slot), sequence, Instant::now())),
                Some((_, last, since)) if *last != sequence => (*last, *since) = (sequence, Instant::now()),
                Some((_, _, since)) if sequence % 2 == 1 && since.elapsed() >= limit => {
                    return lock(&slot.place).clone();
                }
                Some(_) => {}
            }
        }
        None
    }
}
