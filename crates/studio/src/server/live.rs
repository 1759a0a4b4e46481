//! The session behind the page, and its draft: what hands did and nobody has saved is kept while it goes, and offered when the next session of
//! the same scenario begins.

use crate::Studio;
use crate::protocol::Notice;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::watch;

/// What a server cannot do itself: files, and opening scenarios.
pub trait Backend: Send + Sync {
    /// Keeps the draft beside what is known of the scenario; none: there is nothing to be kept any more.
    fn keep(&self, draft: Option<&str>);

    /// Opens a session with the text of a draft.
    ///
    /// # Errors
    /// Why the text cannot be used, in words.
    fn open(&self, draft: &str) -> Result<Studio, String>;

    /// The file of this name, of what a session has come to; `None` where there is none.
    fn export(&self, studio: &Studio, name: &str) -> Option<Vec<u8>>;
}

/// A draft from an earlier session.
#[derive(Clone, Debug)]
pub struct DraftOffer {
    /// Its text.
    pub text: String,
    /// When it was kept (RFC 3339).
    pub written: String,
}

/// A session and its draft.
pub struct Live {
    studio: watch::Sender<Arc<Studio>>,
    offer: watch::Sender<Option<DraftOffer>>,
    /// The draft as it was kept last.
    kept: Mutex<Option<Arc<str>>>,
    backend: Box<dyn Backend>,
}

impl Live {
    /// A session; `offer`: what an earlier one has left.
    pub fn new(studio: Studio, offer: Option<DraftOffer>, backend: Box<dyn Backend>) -> Self {
        Self {
            studio: watch::Sender::new(Arc::new(studio)),
            offer: watch::Sender::new(offer),
            kept: Mutex::new(None),
            backend,
        }
    }

    /// The session, now and whenever another one takes its place.
    pub(super) fn studio(&self) -> watch::Receiver<Arc<Studio>> {
        self.studio.subscribe()
    }

    /// The session as it is now.
    pub fn now(&self) -> Arc<Studio> {
        self.studio.borrow().clone()
    }

    /// The offer, now and when it has been taken up, discarded or overtaken.
    pub(super) fn offer(&self) -> watch::Receiver<Option<DraftOffer>> {
        self.offer.subscribe()
    }

    /// Takes up the draft that is offered, or discards it.
    ///
    /// # Errors
    /// What a page is told where there is none any more, or where it cannot be used.
    pub(super) fn decide_draft(&self, take: bool) -> Result<(), Refusal> {
        // Held to the end: another tab that decides at the same time comes too late.
        let mut kept = self.kept();
        let Some(offer) = self.offer.borrow().clone() else {
            return Err(refused("there is no draft any more", "another page has decided about it"));
        };
        if take {
            let studio = self.backend.open(&offer.text).map_err(|message| {
                refused(
                    &format!("the draft cannot be taken up: {message}"),
                    "it stays where it is; discard it to be rid of it",
                )
            })?;
            self.studio.send_replace(Arc::new(studio)).close();
            *kept = Some(offer.text.into());
        } else {
            self.backend.keep(None);
        }
        self.offer.send_replace(None);
        Ok(())
    }

    /// The file of this name; `None` where there is none.
    pub(super) fn export(&self, name: &str) -> Option<Vec<u8>> {
        self.backend.export(&self.now(), name)
    }

    /// Keeps the draft, if there is something new in it.
    pub(super) fn keep(&self) {
        let mut kept = self.kept();
        let draft = self.now().draft();
        if *kept == draft {
            return;
        }
        self.backend.keep(draft.as_deref());
        *kept = draft;
        // What is kept now has taken the place of what was.
        self.offer.send_if_modified(|offer| offer.take().is_some());
    }

    fn kept(&self) -> MutexGuard<'_, Option<Arc<str>>> {
        // Nothing that holds it leaves it half changed.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends the session: nothing more is computed.
    pub(super) fn close(&self) {
        self.now().close();
    }

    /// Waits until its thread has come to its end, but no longer than that. Returns whether it has.
    pub(super) fn has_ended(&self, timeout: Duration) -> bool {
        self.now().has_ended(timeout)
    }
}

/// What cannot be done, and what would be right.
pub(super) struct Refusal {
    message: String,
    help: String,
}

/// A refusal.
pub(super) fn refused(message: &str, help: &str) -> Refusal {
    Refusal { message: message.to_owned(), help: help.to_owned() }
}

impl From<Refusal> for Notice {
    fn from(Refusal { message, help }: Refusal) -> Self {
        Self::Refused { message, help }
    }
}
