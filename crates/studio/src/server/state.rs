//! State that all connections of a server share.

use super::admission::Admission;
use super::live::Live;
use super::token::Token;
use std::sync::Arc;
use tokio::sync::watch;

/// Creates the exported file of a name, if it exists.
pub type Exports = Box<dyn Fn(&str) -> Option<Vec<u8>> + Send + Sync>;

/// Content of a server.
pub struct Site {
    /// The page.
    pub page: String,
    /// Live session or finished run.
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
}

impl Site {
    pub(super) fn live(&self) -> Option<&Live> {
        match &self.content {
            Content::Live(live) => Some(live),
            Content::Finished(_) => None,
        }
    }

    pub(super) fn export(&self, name: &str) -> Option<Vec<u8>> {
        match &self.content {
            Content::Live(live) => live.export(name),
            Content::Finished(exports) => exports(name),
        }
    }
}

/// State shared by all requests.
pub(super) struct ServerState {
    pub site: Site,
    pub token: Token,
    /// The host name that was bound, if it is not a name of this machine.
    pub host: String,
    pub admission: Arc<Admission>,
    /// Becomes true at shutdown.
    pub ending: watch::Receiver<bool>,
}

/// Waits for shutdown.
pub(super) async fn ended(ending: &mut watch::Receiver<bool>) {
    // A dropped sender also means shutdown.
    drop(ending.wait_for(|ending| *ending).await);
}
