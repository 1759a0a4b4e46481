//! Cancelling of computations, from any thread.

use crate::call::{WireloomError, call};
use crate::failure::{Failure, WireloomCode};
use crate::{handles, pointers};
use wireloom::session::Monitor;

/// What the handle is called.
const WHAT: &str = "cancel handle";

/// A handle that cancels the computations which were given it, from any thread.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomCancel {
    /// 0: none; what is given it cannot be cancelled.
    pub id: u64,
}

/// The monitor of a handle; one of its own for none.
pub fn monitor(cancel: WireloomCancel) -> Result<Monitor, Failure> {
    if cancel.id == 0 { Ok(Monitor::default()) } else { Ok((*handles::get::<Monitor>(cancel.id, WHAT)?).clone()) }
}

/// Makes a cancel handle.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_cancel_new(cancel: *mut WireloomCancel, error: *mut WireloomError) -> WireloomCode {
    call(error, || {
        pointers::place(cancel, "cancel")?;
        pointers::put(cancel, "cancel", WireloomCancel { id: handles::new(Monitor::default()) })
    })
}

/// Cancels what is computed with this handle, now and later. It ends within an iteration: a run with a result whose
/// status is WIRELOOM_STATUS_INTERRUPTED, everything else with WIRELOOM_CODE_CANCELLED.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_cancel_request(cancel: WireloomCancel, error: *mut WireloomError) -> WireloomCode {
    call(error, || {
        handles::get::<Monitor>(cancel.id, WHAT)?.stop();
        Ok(())
    })
}

/// Takes the request back, so that the handle can be used again.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_cancel_reset(cancel: WireloomCancel, error: *mut WireloomError) -> WireloomCode {
    call(error, || {
        handles::get::<Monitor>(cancel.id, WHAT)?.go_on();
        Ok(())
    })
}

/// Frees a cancel handle; what uses it goes on.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_cancel_free(cancel: WireloomCancel) -> WireloomCode {
    call(std::ptr::null_mut(), || handles::free::<Monitor>(cancel.id, WHAT))
}
