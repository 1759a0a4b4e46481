//! Computations in threads of their own, because a thread of the host may have a small stack.

use crate::failure::{Failure, WireloomCode, words};
use std::thread::{self, Builder, ScopedJoinHandle};

/// Stack of a computing thread, bytes: that of a main thread.
const STACK: usize = 8 << 20;

/// How computing threads are made.
pub fn builder() -> Builder {
    Builder::new().name("wireloom".to_owned()).stack_size(STACK)
}

/// A thread that the system refused.
pub fn no_thread(error: &std::io::Error) -> Failure {
    Failure::new(WireloomCode::System, format!("no thread to compute in: {error}"), "end other threads")
}

/// Work in a thread of its own, while the calling one waits.
pub fn computed<T: Send>(work: impl FnOnce() -> Result<T, Failure> + Send) -> Result<T, Failure> {
    attended(work, || ())
}

/// The same, while the calling thread does something else.
pub fn attended<T: Send>(
    work: impl FnOnce() -> Result<T, Failure> + Send,
    meanwhile: impl FnOnce(),
) -> Result<T, Failure> {
    let joined = |thread: ScopedJoinHandle<'_, Result<T, Failure>>| {
        meanwhile();
        thread.join().unwrap_or_else(|panic| Err(Failure::internal(words(&*panic))))
    };
    thread::scope(|scope| builder().spawn_scoped(scope, work).map_err(|error| no_thread(&error)).and_then(joined))
}
