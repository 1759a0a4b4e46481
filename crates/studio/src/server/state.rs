//! State that all connections of a server share.

use super::admission::Admission;
use super::live::Live;
use super::token::Token;
use std::sync::Arc;
use tokio::sync::watch;

/// Makes the file of a name, where there is one.
pub type Exports = Box<dyn Fn(&str) -> Option<Vec<u8>> + Send + Sync>;

/// What is served.
pub struct Site {
    /// The page.
    pub page: String,
    /// What is behind it.
    pub content: Content,
}

/// What is behind a page.
pub enum Content {
    /// A session.
    Live(Live),
    /// A run that has come to its end, and its files.
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

/// What requests see.
pub(super) struct ServerState {
    pub site: Site,
    pub token: Token,
    /// The name by which browsers know the server, where it has another one than those of this machine.
    pub host: String,
    pub admission: Arc<Admission>,
    /// Becomes true when all is to end.
    pub ending: watch::Receiver<bool>,
}

/// Waits until all is to end.
pub(super) async fn ended(ending: &mut watch::Receiver<bool>) {
    // Whoever would say so has gone: that is an end, too.
    drop(ending.wait_for(|ending| *ending).await);
}
