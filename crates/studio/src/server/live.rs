//! The session behind the page, and its draft: unsaved changes are stored at intervals and offered to later sessions of
//! the same scenario, beside those of other sessions that nobody has restored or discarded.

use crate::Studio;
use crate::protocol::{Notice, StoredMesh};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::watch;

/// Operations that the server leaves to the program: files, and opening scenarios.
pub trait Backend: Send + Sync {
    /// Stores the draft of this session in place of the one before; `None` deletes that.
    fn keep(&self, draft: Option<&str>);

    /// Deletes the draft of an earlier session with this text.
    fn discard(&self, draft: &str);

    /// Opens a session with the text of a draft.
    ///
    /// # Errors
    /// Message why the text cannot be used.
    fn open(&self, draft: &str) -> Result<Studio, String>;

    /// Whether the drafts of earlier sessions are still some of this scenario: not since that was saved under another
    /// name.
    fn still_offers(&self) -> bool {
        true
    }

    /// Stores a file beside the scenario's. Returns its name there: another one where a different file has that name.
    ///
    /// # Errors
    /// If the scenario has no file, the name is none of a file, or the system refuses.
    fn store_beside(&self, name: &str, bytes: &[u8]) -> Result<String, wireloom::session::Refusal>;

    /// Name of the scenario's file, if another program has changed it since the last call.
    fn changed_outside(&self) -> Option<String>;

    /// The exported file of this name for the current state; `None` if there is none.
    fn export(&self, studio: &Studio, name: &str) -> Option<Vec<u8>>;
}

/// A draft of an earlier session.
#[derive(Clone, Debug, PartialEq)]
pub struct DraftOffer {
    /// Its text.
    pub text: String,
    /// Time of storage (RFC 3339).
    pub written: String,
}

/// A session and its draft.
pub struct Live {
    studio: watch::Sender<Arc<Studio>>,
    /// Drafts of earlier sessions, with their numbers.
    offers: watch::Sender<Vec<(u32, DraftOffer)>>,
    /// The draft of this session as last stored.
    kept: Mutex<Option<Arc<str>>>,
    backend: Box<dyn Backend>,
    /// What every page is told when it connects.
    first: Vec<Notice>,
}

impl Live {
    /// A session; `offers`: the drafts of earlier ones.
    pub fn new(studio: Studio, offers: Vec<DraftOffer>, backend: Box<dyn Backend>) -> Self {
        Self {
            studio: watch::Sender::new(Arc::new(studio)),
            offers: watch::Sender::new((0..).zip(offers).collect()),
            kept: Mutex::new(None),
            backend,
            first: Vec::new(),
        }
    }

    /// The same, of which every page is told this when it connects.
    #[must_use]
    pub fn telling(mut self, first: Vec<Notice>) -> Self {
        self.first = first;
        self
    }

    /// What a page is told when it connects.
    pub(super) fn first(&self) -> &[Notice] {
        &self.first
    }

    /// The current session, and any that replaces it.
    pub(super) fn studio(&self) -> watch::Receiver<Arc<Studio>> {
        self.studio.subscribe()
    }

    /// The current session.
    pub fn now(&self) -> Arc<Studio> {
        self.studio.borrow().clone()
    }

    /// The offered drafts: each until it is accepted or discarded, all until the scenario is saved under another name.
    pub(super) fn offers(&self) -> watch::Receiver<Vec<(u32, DraftOffer)>> {
        self.offers.subscribe()
    }

    /// Accepts or discards an offered draft.
    ///
    /// # Errors
    /// If there is no such draft any more, if it cannot be used, or if it would replace unsaved changes.
    pub(super) fn decide_draft(&self, number: u32, take: bool) -> Result<(), Refusal> {
        // Locked to the end: another tab's decision comes too late.
        let mut kept = self.kept();
        self.withdraw_if_old();
        let offer = self.offers.borrow().iter().find(|(own, _)| *own == number).map(|(_, offer)| offer.clone());
        let Some(offer) = offer else {
            let help = "another page has accepted or discarded it, or the scenario was saved under another name";
            return Err(refused("there is no draft any more", help));
        };
        if take {
            if self.now().draft().is_some() {
                let message = "this session has unsaved changes, which the draft would replace";
                return Err(refused(message, "save them first; the draft is kept until it is restored or discarded"));
            }
            let studio = self.backend.open(&offer.text).map_err(|message| {
                refused(&format!("the draft cannot be used: {message}"), "it is kept until it is discarded")
            })?;
            self.studio.send_replace(Arc::new(studio)).close();
            // From now on it is the draft of this session.
            self.backend.keep(Some(&offer.text));
            *kept = Some(offer.text.as_str().into());
        }
        self.backend.discard(&offer.text);
        self.offers.send_modify(|offers| offers.retain(|(own, _)| *own != number));
        Ok(())
    }

    /// The exported file of this name; `None` if there is none.
    pub(super) fn export(&self, name: &str) -> Option<Vec<u8>> {
        self.backend.export(&self.now(), name)
    }

    /// Stores a file with the surface of an obstacle beside the scenario's, if it is one.
    ///
    /// # Errors
    /// Why it is none, or cannot be stored.
    pub(super) fn store_mesh(&self, name: &str, bytes: Vec<u8>) -> Result<StoredMesh, wireloom::session::Refusal> {
        let open = self.now().has_borders(name, bytes.clone())?;
        Ok(StoredMesh { file: self.backend.store_beside(name, &bytes)?, open })
    }

    /// Stores the draft, if it has changed; tells the pages if another program has changed the file.
    pub(super) fn keep(&self) {
        if let Some(name) = self.backend.changed_outside() {
            self.now().tell(Notice::Outside { name });
        }
        let mut kept = self.kept();
        self.withdraw_if_old();
        let draft = self.now().draft();
        if *kept == draft {
            return;
        }
        self.backend.keep(draft.as_deref());
        *kept = draft;
    }

    /// Offers no drafts any more if they are none of this scenario any more.
    fn withdraw_if_old(&self) {
        if !self.backend.still_offers() {
            self.offers.send_if_modified(|offers| !std::mem::take(offers).is_empty());
        }
    }

    fn kept(&self) -> MutexGuard<'_, Option<Arc<str>>> {
        // No critical section leaves it half changed.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends the session: stops computing.
    pub(super) fn close(&self) {
        self.now().close();
    }

    /// Waits for its thread to end, up to `timeout`. Returns whether it has ended.
    pub(super) fn has_ended(&self, timeout: Duration) -> bool {
        self.now().has_ended(timeout)
    }
}

/// A refused request: message and help.
pub(super) struct Refusal {
    message: String,
    help: String,
}

/// Makes a refusal.
pub(super) fn refused(message: &str, help: &str) -> Refusal {
    Refusal { message: message.to_owned(), help: help.to_owned() }
}

impl From<Refusal> for Notice {
    fn from(Refusal { message, help }: Refusal) -> Self {
        Self::Refused { message, help }
    }
}
