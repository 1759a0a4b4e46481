//! The line to one instance in a plugin, whatever it is. The first thing that goes wrong is kept as its fault; from then on the plugin is not
//! called any more.

use crate::call::{CallSite, call_plugin};
use crate::read::Message;
use std::collections::BTreeSet;
use std::ffi::{CStr, c_void};
use std::ptr::null_mut;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use wireloom_abi as abi;

/// Stands where nothing was written yet: a not-a-number that arithmetic does not make.
pub const UNWRITTEN: f64 = f64::from_bits(0x7ff8_5749_5245_4c4d);

/// Kinds of which an instance was made that gives not all derivatives, with what becomes of them.
static NUMERIC_DERIVATIVES: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

pub fn locked(all: &Mutex<BTreeSet<String>>) -> MutexGuard<'_, BTreeSet<String>> {
    all.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What is said of kinds that do not give all their derivatives, of all instances that this process has made.
pub fn numeric_derivatives() -> Vec<String> {
    locked(&NUMERIC_DERIVATIVES).iter().cloned().collect()
}

/// Notes that derivatives of a kind are `missing`.
pub fn note_numeric_derivatives(kind: &str, owner: &str, missing: &str) {
    locked(&NUMERIC_DERIVATIVES).insert(format!("kind `{kind}` of {owner} gives not all derivatives: {missing}"));
}

/// A line to an instance. Whoever has it frees the instance.
pub struct PluginInstance {
    pub site: Arc<CallSite>,
    owner: Arc<String>,
    pub instance: *mut c_void,
    lock: Option<Mutex<()>>,
    fault: OnceLock<String>,
}

impl PluginInstance {
    /// To what `create` makes; what it says when it does not is an error, in words that go on from whose it is.
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
            other => return Err(format!("returned {other} from `create`; 0, 1 and 2 have a meaning")),
        }
        if instance.is_null() {
            return Err("made nothing: `create` says it is done, but wrote no instance".into());
        }
        Ok(Self { site, owner, instance, lock: Some(Mutex::default()), fault: OnceLock::new() })
    }

    /// Several threads may call at a time.
    pub fn allow_concurrent_calls(&mut self) {
        self.lock = None;
    }

    /// The first thing that went wrong.
    pub fn fault(&self) -> Option<String> {
        self.fault.get().cloned()
    }

    /// Keeps the first thing that went wrong.
    pub fn fail(&self, what: String) {
        let _ = self.fault.set(format!("{} {what}", self.owner));
    }

    /// Calls a function of the plugin unless something went wrong before; whether it did what it should.
    pub fn call(&self, function: &'static CStr, call: impl FnOnce(*const c_void, *mut abi::Text) -> i32) -> bool {
        if self.fault.get().is_some() {
            return false;
        }
        let _one_at_a_time = self.lock.as_ref().map(|lock| lock.lock().unwrap_or_else(PoisonError::into_inner));
        let mut message = Message::new();
        let mut text = message.text();
        let status = call_plugin(&self.site, function, || call(self.instance, &mut text));
        let name = function.to_string_lossy();
        match status {
            abi::STATUS_OK => return true,
            abi::STATUS_ERROR => self.fail(format!("failed in `{name}`: {}", message.words())),
            abi::STATUS_PANIC => self.fail(format!("panicked in `{name}`: {}", message.words())),
            other => self.fail(format!("returned {other} from `{name}`; 0, 1 and 2 have a meaning")),
        }
        false
    }

    /// Whether numbers are finite; if not, that is a fault.
    pub fn finite(&self, what: &str, numbers: &[f64]) -> bool {
        let Some(at) = numbers.iter().position(|x| !x.is_finite()) else { return true };
        let which = if numbers.len() == 1 { String::new() } else { format!(", entry {at} of {}", numbers.len()) };
        let x = numbers[at];
        self.fail(if x.to_bits() == UNWRITTEN.to_bits() {
            format!("wrote no {what}{which} in `evaluate`, which was asked for")
        } else {
            format!("returned {x} as {what}{which}")
        });
        false
    }
}
