//! An instance in a plugin, of any family. The first error is kept as its fault; after that the plugin is not called
//! again.

use crate::buffers::Buffers;
use crate::call::{CallSite, call_plugin};
use crate::read::Message;
use std::collections::BTreeSet;
use std::ffi::{CStr, c_void};
use std::ptr::null_mut;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use wireloom_abi as abi;

/// Marks values that the plugin has not written: a NaN that arithmetic does not produce.
pub const UNWRITTEN: f64 = f64::from_bits(0x7ff8_5749_5245_4c4d);

/// Kinds with instances that lack some derivatives, each with the replacement that is used.
static NUMERIC_DERIVATIVES: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

pub fn locked(all: &Mutex<BTreeSet<String>>) -> MutexGuard<'_, BTreeSet<String>> {
    all.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Messages about kinds that lack derivatives, for all instances made in this process.
pub fn numeric_derivatives() -> Vec<String> {
    locked(&NUMERIC_DERIVATIVES).iter().cloned().collect()
}

/// Records that derivatives of a kind are `missing`.
pub fn note_numeric_derivatives(kind: &str, owner: &str, missing: &str) {
    locked(&NUMERIC_DERIVATIVES).insert(format!("kind `{kind}` of {owner} gives not all derivatives: {missing}"));
}

/// A live instance of a plugin's kind. The owner destroys the instance.
pub struct PluginInstance {
    pub site: Arc<CallSite>,
    owner: Arc<String>,
    pub instance: *mut c_void,
    lock: Option<Mutex<()>>,
    fault: OnceLock<String>,
}

impl PluginInstance {
    /// Calls `create`. The error text continues a sentence that begins with the owner.
    pub fn create(
        site: Arc<CallSite>,
        owner: Arc<String>,
        create: impl FnOnce(*mut *mut c_void, *mut abi::Text) -> i32,
    ) -> Result<Self, String> {
        let mut instance = null_mut();
        let mut message = Message::new();
        let mut text = message.text();
        match call_plugin(&site, c"create", || create(&mut instance, &mut text)) {
            abi::STATUS_OK => {}
            abi::STATUS_ERROR => return Err(format!("refuses: {}", message.words())),
            abi::STATUS_PANIC => return Err(format!("panicked in `create`: {}", message.words())),
            other => return Err(format!("returned {other} from `create`; expected 0, 1 or 2")),
        }
        if message.is_overrun() {
            return Err("wrote beyond the end of the message in `create`".into());
        }
        if instance.is_null() {
            return Err("returned success from `create` but wrote no instance".into());
        }
        Ok(Self { site, owner, instance, lock: Some(Mutex::default()), fault: OnceLock::new() })
    }

    /// Allows calls from several threads at a time.
    pub fn allow_concurrent_calls(&mut self) {
        self.lock = None;
    }

    /// The first error, if any.
    pub fn fault(&self) -> Option<String> {
        self.fault.get().cloned()
    }

    /// Keeps an error, unless there is one already.
    pub fn fail(&self, what: String) {
        let _ = self.fault.set(format!("{} {what}", self.owner));
    }

    /// Calls a function of the plugin, unless an earlier call failed. Returns whether it succeeded.
    pub fn call(&self, function: &'static CStr, call: impl FnOnce(*const c_void, *mut abi::Text) -> i32) -> bool {
        if self.fault.get().is_some() {
            return false;
        }
        let _one_at_a_time = self.lock.as_ref().map(|lock| lock.lock().unwrap_or_else(PoisonError::into_inner));
        let mut message = Message::new();
        let mut text = message.text();
        let status = call_plugin(&self.site, function, || call(self.instance, &mut text));
        let name = function.to_string_lossy();
        if message.is_overrun() {
            self.fail(format!("wrote beyond the end of the message in `{name}`"));
            return false;
        }
        match status {
            abi::STATUS_OK => return true,
            abi::STATUS_ERROR => self.fail(format!("failed in `{name}`: {}", message.words())),
            abi::STATUS_PANIC => self.fail(format!("panicked in `{name}`: {}", message.words())),
            other => self.fail(format!("returned {other} from `{name}`; expected 0, 1 or 2")),
        }
        false
    }

    /// Whether the plugin wrote to its arrays alone; if not, that is recorded as a fault.
    pub fn kept_to_its_arrays(&self, buffers: &Buffers, function: &str) -> bool {
        let Some(overrun) = buffers.overrun() else { return true };
        self.fail(format!("{overrun} (in `{function}`)"));
        false
    }

    /// Whether all numbers that a function wrote are finite; if not, that is recorded as a fault.
    pub fn finite(&self, what: &str, numbers: &[f64], function: &str) -> bool {
        let Some(at) = numbers.iter().position(|x| !x.is_finite()) else { return true };
        let which = if numbers.len() == 1 { String::new() } else { format!(", entry {at} of {}", numbers.len()) };
        let x = numbers[at];
        self.fail(if x.to_bits() == UNWRITTEN.to_bits() {
            format!("wrote no {what}{which} in `{function}`, which was requested")
        } else {
            format!("returned {x} as {what}{which}")
        });
        false
    }
}
