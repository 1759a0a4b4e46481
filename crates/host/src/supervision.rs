//! Record of the calls of this process for another one that supervises it: it says which plugin ended the process where
//! nothing in the process can (`_exit`, damaged memory).
//!
//! The record is a file of [`SLOTS`] slots in memory that both share: a slot for each thread that calls plugins. In
//! each are a counter, odd while the thread is inside a plugin, and the texts of the current or last call.

use std::ffi::CStr;
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicPtr, AtomicU64, AtomicUsize, Ordering};

/// Number of slots; further threads are not recorded.
const SLOTS: usize = 64;
/// Bytes of the counter, of the text of the call site and of the name of the function, each text with its zero.
const PARTS: [usize; 3] = [8, 888, 128];
/// Bytes of a slot.
const SLOT: usize = PARTS[0] + PARTS[1] + PARTS[2];

/// The record of this process; null without a supervisor.
static RECORD: AtomicPtr<u8> = AtomicPtr::new(std::ptr::null_mut());
/// Number of slots in use.
static USED: AtomicUsize = AtomicUsize::new(0);

/// The slot of a thread.
pub struct Slot(*mut u8);

// SAFETY: one thread writes to a slot, and the memory stays mapped as long as the process.
unsafe impl Send for Slot {}
// SAFETY: likewise.
unsafe impl Sync for Slot {}

/// Slot of a new thread, where there is a supervisor.
pub fn next_slot() -> Option<Slot> {
    let record = RECORD.load(Ordering::Acquire);
    let free = || Some(USED.fetch_add(1, Ordering::Relaxed)).filter(|used| *used < SLOTS);
    // SAFETY: the record has that many slots.
    if record.is_null() { None } else { free().map(|used| Slot(unsafe { record.add(used * SLOT) })) }
}

impl Slot {
    /// The next call is one of this function.
    pub fn name(&self, site: &CStr, function: &CStr) {
        let mut to = PARTS[0];
        for (text, room) in [(site, PARTS[1]), (function, PARTS[2])] {
            let bytes = &text.to_bytes()[..text.to_bytes().len().min(room - 1)];
            // SAFETY: text and zero fit into this part of the slot.
            unsafe {
                std::ptr::copy_nonoverlapping(bytes.as_ptr(), self.0.add(to), bytes.len());
                self.0.add(to + bytes.len()).write(0);
            }
            to += room;
        }
    }

    /// The counter: odd while the thread is inside a plugin.
    pub fn count(&self, calls: u64) {
        // SAFETY: a slot begins with its counter, at a multiple of eight bytes.
        unsafe { AtomicU64::from_ptr(self.0.cast()) }.store(calls, Ordering::Release);
    }
}

/// Records the calls of this process in the file that its supervisor made with [`begin_record`].
///
/// # Errors
/// If the system refuses.
#[cfg(unix)]
pub fn record_calls(file: &Path) -> io::Result<()> {
    use std::os::fd::AsRawFd;
    let file = std::fs::File::options().read(true).write(true).open(file)?;
    let (write, size) = (libc::PROT_READ | libc::PROT_WRITE, SLOTS * SLOT);
    // SAFETY: the file has this size, and the system chooses the place.
    let record = unsafe { libc::mmap(std::ptr::null_mut(), size, write, libc::MAP_SHARED, file.as_raw_fd(), 0) };
    if record == libc::MAP_FAILED {
        return Err(io::Error::last_os_error());
    }
    RECORD.store(record.cast(), Ordering::Release);
    Ok(())
}

/// A call in a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedCall {
    /// Counter of the calls of its thread: odd while it runs.
    pub count: u64,
    /// Owner of the function, as text: plugin, file, constraint.
    pub site: String,
    /// Name of the function.
    pub function: String,
}

impl RecordedCall {
    /// Whether it runs.
    pub fn runs(&self) -> bool {
        self.count % 2 == 1
    }
}

/// Makes an empty record.
///
/// # Errors
/// If the file cannot be written.
pub fn begin_record(file: &Path) -> io::Result<()> {
    std::fs::write(file, vec![0; SLOTS * SLOT])
}

/// The current or last call of each thread of a record: first those that run, then by the number of calls.
///
/// # Errors
/// If the file cannot be read.
pub fn recorded_calls(file: &Path) -> io::Result<Vec<RecordedCall>> {
    let bytes = std::fs::read(file)?;
    let text = |bytes: &[u8]| {
        let text = CStr::from_bytes_until_nul(bytes).unwrap_or_default();
        text.to_string_lossy().into_owned()
    };
    let call = |slot: &[u8]| {
        let (count, texts) = slot.split_at(PARTS[0]);
        let (site, function) = texts.split_at(PARTS[1]);
        let count = u64::from_ne_bytes(count.try_into().unwrap_or_default());
        RecordedCall { count, site: text(site), function: text(function) }
    };
    let mut calls: Vec<RecordedCall> = bytes.chunks_exact(SLOT).map(call).filter(|call| call.count > 0).collect();
    calls.sort_by_key(|call| (!call.runs(), std::cmp::Reverse(call.count)));
    Ok(calls)
}
