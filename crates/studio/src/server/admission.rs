//! Admission of connections, before and after they have shown the token.
//!
//! Connections that have not shown the token have a pool of their own. If it is full, the oldest of them is closed, so
//! they cannot block authenticated clients.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::AbortHandle;

/// Largest number of unauthenticated connections.
const MAX_UNAUTHENTICATED: usize = 64;

/// Counts and limits connections.
pub(super) struct Admission {
    /// Slots for authenticated connections: total number, and free ones.
    places: (u32, Arc<Semaphore>),
    /// Unauthenticated connections, oldest first.
    unauthenticated: Mutex<VecDeque<(u64, AbortHandle)>>,
    /// Number of connections so far.
    count: AtomicU64,
}

/// A connection; its slot is freed when the last reference is dropped.
pub(super) struct Peer {
    admission: Arc<Admission>,
    number: u64,
    place: Mutex<Option<OwnedSemaphorePermit>>,
}

/// No critical section panics.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Admission {
    /// With this number of slots for authenticated connections.
    pub fn new(places: u32) -> Self {
        Self {
            places: (places, Arc::new(Semaphore::new(places as usize))),
            unauthenticated: Mutex::default(),
            count: AtomicU64::new(0),
        }
    }

    /// Registers a new connection.
    pub fn register(self: &Arc<Self>) -> Arc<Peer> {
        let number = self.count.fetch_add(1, Ordering::Relaxed);
        Arc::new(Peer { admission: self.clone(), number, place: Mutex::new(None) })
    }

    /// Number of authenticated connections.
    pub fn authenticated(&self) -> usize {
        let (all, free) = &self.places;
        *all as usize - free.available_permits()
    }

    /// Waits until all authenticated connections are closed.
    pub async fn all_closed(&self) {
        let (all, free) = &self.places;
        // The semaphore is never closed.
        let _ = free.acquire_many(*all).await;
    }
}

impl Peer {
    /// Adds the connection to the unauthenticated ones; `served`: its task, which is aborted if it has to leave.
    pub fn wait_for_token(&self, served: AbortHandle) {
        let mut unauthenticated = locked(&self.admission.unauthenticated);
        unauthenticated.retain(|(_, served)| !served.is_finished());
        // It may already be authenticated or closed.
        if locked(&self.place).is_some() || served.is_finished() {
            return;
        }
        unauthenticated.push_back((self.number, served));
        if unauthenticated.len() > MAX_UNAUTHENTICATED
            && let Some((_, first)) = unauthenticated.pop_front()
        {
            first.abort();
        }
    }

    /// Marks the connection as authenticated. Returns whether there is a slot.
    pub fn authenticate(&self) -> bool {
        let authenticated = {
            let mut place = locked(&self.place);
            if place.is_none() {
                *place = self.admission.places.1.clone().try_acquire_owned().ok();
            }
            place.is_some()
        };
        if authenticated {
            locked(&self.admission.unauthenticated).retain(|(number, _)| *number != self.number);
        }
        authenticated
    }
}
