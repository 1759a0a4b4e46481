//! Calls into plugins: where a thread is, for the case that it does not come back.
//!
//! What cannot be caught inside a process is caught as it ends: a watchdog sees calls that take too long, and where the system has signals and
//! `exec`, a crash is seen too. In both cases this process becomes another program, which saves what there is ([`crate::stand_by`]).

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString};
use std::ptr::null;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Whose functions are called, in words: plugin, file, constraint.
pub struct Site(CString);

impl Site {
    /// In these words.
    pub fn new(words: &str) -> Arc<Self> {
        Arc::new(Self(CString::new(words.replace('\0', "")).unwrap_or_default()))
    }

    /// The words.
    pub fn words(&self) -> &CStr {
        &self.0
    }
}

/// Where a thread is.
struct Slot {
    /// Odd while it is inside a plugin; goes up with every call and every return.
    sequence: AtomicU64,
    /// Where it is, or was last.
    place: Mutex<Option<(Arc<Site>, &'static CStr)>>,
}

/// All threads that ever called a plugin.
static SLOTS: Mutex<Vec<Weak<Slot>>> = Mutex::new(Vec::new());

/// What a signal handler may look at: null while the thread is not inside a plugin.
#[derive(Clone, Copy)]
pub struct Inside {
    /// Words of the site, zero at the end.
    pub site: *const std::ffi::c_char,
    /// Name of the function.
    pub function: *const std::ffi::c_char,
}

const NOWHERE: Inside = Inside { site: null(), function: null() };

thread_local! {
    static INSIDE: Cell<Inside> = const { Cell::new(NOWHERE) };
    static SLOT: RefCell<Option<Arc<Slot>>> = const { RefCell::new(None) };
}

/// Where this thread is.
pub fn inside() -> Inside {
    INSIDE.get()
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Calls a function of a plugin.
pub fn into_plugin<R>(site: &Arc<Site>, function: &'static CStr, call: impl FnOnce() -> R) -> R {
    let slot = SLOT.with_borrow_mut(|slot| {
        slot.get_or_insert_with(|| {
            let slot = Arc::new(Slot { sequence: AtomicU64::new(0), place: Mutex::new(None) });
            lock(&SLOTS).push(Arc::downgrade(&slot));
            slot
        })
        .clone()
    });
    {
        let mut place = lock(&slot.place);
        if !place.as_ref().is_some_and(|(is, at)| Arc::ptr_eq(is, site) && std::ptr::eq(*at, function)) {
            *place = Some((site.clone(), function));
        }
    }
    INSIDE.set(Inside { site: site.words().as_ptr(), function: function.as_ptr() });
    slot.sequence.fetch_add(1, Ordering::Release);
    let result = call();
    slot.sequence.fetch_add(1, Ordering::Release);
    INSIDE.set(NOWHERE);
    result
}

/// Calls that have not come back, seen from outside.
#[derive(Default)]
pub struct Watch {
    seen: Vec<(Weak<Slot>, u64, Instant)>,
}

impl Watch {
    /// The site and function of a call that began at least `limit` before. To be asked again and again: a call counts from when it was seen first.
    pub fn overdue(&mut self, limit: Duration) -> Option<(Arc<Site>, &'static CStr)> {
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
