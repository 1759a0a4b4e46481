//! State that all connections of a server share.

use super::admission::Admission;
use super::live::{Live, Refusal, refused};
use super::token::Token;
use crate::protocol::{Contents, ImportFile, NotOpened, Notice, Opening, Request, StartPage};
use crate::session::{MAX_FILE, MAX_TEXT, text_faults};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use tokio::sync::watch;
use wireloom::scenario::Fault;

/// Creates the exported file of a name, if it exists.
pub type Exports = Box<dyn Fn(&str) -> Option<Vec<u8>> + Send + Sync>;

/// Content of a server.
pub struct Site {
    /// The page.
    pub page: String,
    /// Live session, finished run, or the start page.
    pub content: Content,
    /// Tolerance envelope for the page ([`crate::envelope`]).
    pub envelope: Option<Vec<u8>>,
}

/// Source of a page's data.
pub enum Content {
    /// A session.
    Live(Live),
    /// A finished run and its exported files.
    Finished(Exports),
    /// Nothing yet.
    Start(Start),
}

impl Site {
    pub(super) fn live(&self) -> Option<&Live> {
        match &self.content {
            Content::Live(live) => Some(live),
            Content::Finished(_) | Content::Start(_) => None,
        }
    }

    pub(super) fn export(&self, name: &str) -> Option<Vec<u8>> {
        match &self.content {
            Content::Live(live) => live.export(name),
            Content::Finished(exports) => exports(name),
            Content::Start(_) => None,
        }
    }
}

/// Operations of the start page that the server leaves to the program.
pub trait Starter: Send + Sync {
    /// What can be opened now.
    fn page(&self) -> StartPage;

    /// The modules and variants of a file.
    ///
    /// # Errors
    /// Why it cannot be imported.
    fn contents(&self, file: &ImportFile) -> Result<Contents, NotOpened>;

    /// Opens a session or a finished run.
    ///
    /// # Errors
    /// Why that cannot be opened.
    fn open(&self, what: Opening) -> Result<Site, NotOpened>;

    /// Opens a session with a draft that the page offers.
    ///
    /// # Errors
    /// Why it cannot be opened.
    fn restore(&self, number: u32) -> Result<Site, NotOpened>;

    /// Deletes such a draft.
    fn discard(&self, number: u32);
}

/// Says that nothing was opened, and which faults a text has.
pub fn not_opened(message: impl Into<String>, help: &str, text: &str, faults: &[Fault]) -> NotOpened {
    NotOpened { message: message.into(), help: help.to_owned(), faults: text_faults(text, faults) }
}

/// A start page, and the one session or finished run that is opened on it. From then on the server is as one that was
/// started with it, and opens nothing more.
pub struct Start {
    starter: Box<dyn Starter>,
    opened: OnceLock<Box<Site>>,
    /// Becomes true when something was opened.
    has_opened: watch::Sender<bool>,
    /// One page opens at a time.
    opening: Mutex<()>,
}

impl Start {
    /// A start page.
    pub fn new(starter: Box<dyn Starter>) -> Self {
        Self { starter, opened: OnceLock::new(), has_opened: watch::Sender::new(false), opening: Mutex::new(()) }
    }

    /// What was opened.
    pub(super) fn opened(&self) -> Option<&Site> {
        self.opened.get().map(|site| &**site)
    }

    /// Opens, unless another page has done so.
    fn open(&self, open: impl FnOnce(&dyn Starter) -> Result<Site, NotOpened>) -> Result<(), NotOpened> {
        let _alone = self.opening.lock().unwrap_or_else(PoisonError::into_inner);
        if self.opened.get().is_some() {
            // This page shows that in a moment.
            return Ok(());
        }
        let site = open(&*self.starter)?;
        // Nobody else sets it: that is locked.
        let _ = self.opened.set(Box::new(site));
        self.has_opened.send_replace(true);
        Ok(())
    }

    /// Refuses texts that are too long.
    fn check(request: &Request) -> Result<(), NotOpened> {
        let (length, most) = match request {
            Request::Open { what: Opening::Text { text, .. } } => (text.len(), MAX_TEXT),
            Request::Open { what: Opening::Kbl { file: ImportFile::Text { text, .. }, .. } }
            | Request::Contents { file: ImportFile::Text { text, .. } } => (text.len(), MAX_FILE),
            _ => return Ok(()),
        };
        if length <= most {
            return Ok(());
        }
        let message = format!("the file has {length} bytes; a page can give at most {most}");
        Err(not_opened(message, "open it by its path", "", &[]))
    }

    /// Whether something was opened, now and later.
    pub(super) fn has_opened(&self) -> watch::Receiver<bool> {
        self.has_opened.subscribe()
    }

    /// What can be opened.
    pub(super) fn page(&self) -> StartPage {
        self.starter.page()
    }

    /// Answers a request of a page; nothing where a session was opened.
    pub(super) fn answer(&self, request: Request) -> Result<Option<Notice>, Refusal> {
        if let Err(too_long) = Self::check(&request) {
            return Ok(Some(Notice::NotOpened(too_long)));
        }
        let done = match request {
            Request::Open { what } => self.open(|starter| starter.open(what)).map(|()| None),
            Request::Draft { number, take: true } => self.open(|starter| starter.restore(number)).map(|()| None),
            Request::Draft { number, take: false } => {
                self.starter.discard(number);
                Ok(Some(Notice::StartPage(self.starter.page())))
            }
            Request::Contents { file } => self.starter.contents(&file).map(|found| Some(Notice::Contents(found))),
            _ => return Err(refused("there is no session yet", "open a scenario on the start page first")),
        };
        Ok(done.unwrap_or_else(|not_opened| Some(Notice::NotOpened(not_opened))))
    }
}

/// State shared by all requests.
pub(super) struct ServerState {
    /// What the server was started with.
    pub first: Site,
    pub token: Token,
    /// The host name that was bound, if it is not a name of this machine.
    pub host: String,
    pub admission: Arc<Admission>,
    /// Becomes true at shutdown.
    pub ending: watch::Receiver<bool>,
}

impl ServerState {
    /// What is served: what was opened on the start page, if that is so.
    pub fn site(&self) -> &Site {
        self.start().and_then(Start::opened).unwrap_or(&self.first)
    }

    /// The session, if there is one.
    pub fn live(&self) -> Option<&Live> {
        self.site().live()
    }

    /// The start page, if the server was started with it.
    pub fn start(&self) -> Option<&Start> {
        match &self.first.content {
            Content::Start(start) => Some(start),
            Content::Live(_) | Content::Finished(_) => None,
        }
    }
}

/// Waits for shutdown.
pub(super) async fn ended(ending: &mut watch::Receiver<bool>) {
    // A dropped sender also means shutdown.
    drop(ending.wait_for(|ending| *ending).await);
}
