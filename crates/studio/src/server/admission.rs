//! Who stands at the door, and who has been let in.
//!
//! A connection that has not shown the token is a stranger's. Strangers have places of their own, and where too many wait the one that came
//! first is sent away: so they keep nobody out.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::AbortHandle;

/// Strangers at a time.
const MAX_UNAUTHENTICATED: usize = 64;

/// The door.
pub(super) struct Admission {
    /// Places within, in all and free.
    places: (u32, Arc<Semaphore>),
    /// Strangers, in the order in which they came.
    unauthenticated: Mutex<VecDeque<(u64, AbortHandle)>>,
    /// Visitors so far.
    count: AtomicU64,
}

/// A connection; its place is given back when the last who holds it has gone.
pub(super) struct Peer {
    admission: Arc<Admission>,
    number: u64,
    place: Mutex<Option<OwnedSemaphorePermit>>,
}

/// Nobody panics who holds it.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Admission {
    /// With so many places within.
    pub fn new(places: u32) -> Self {
        Self {
            places: (places, Arc::new(Semaphore::new(places as usize))),
            unauthenticated: Mutex::default(),
            count: AtomicU64::new(0),
        }
    }

    /// Somebody comes.
    pub fn register(self: &Arc<Self>) -> Arc<Peer> {
        let number = self.count.fetch_add(1, Ordering::Relaxed);
        Arc::new(Peer { admission: self.clone(), number, place: Mutex::new(None) })
    }

    /// How many have been let in.
    pub fn authenticated(&self) -> usize {
        let (all, free) = &self.places;
        *all as usize - free.available_permits()
    }

    /// Waits until all have gone that were let in.
    pub async fn all_closed(&self) {
        let (all, free) = &self.places;
        // It is never closed.
        let _ = free.acquire_many(*all).await;
    }
}

impl Peer {
    /// Waits at the door; `served`: what serves him, and ends when he is sent away.
    pub fn wait_for_token(&self, served: AbortHandle) {
        let mut unauthenticated = locked(&self.admission.unauthenticated);
        unauthenticated.retain(|(_, served)| !served.is_finished());
        // He may have been let in, or have gone, already.
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

    /// Has shown the token. Returns whether there is a place for him.
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
