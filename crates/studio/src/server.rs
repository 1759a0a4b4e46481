//! The server behind the page. It speaks to browsers on this machine, and to those only that know the token:
//!
//! | address | what |
//! | --- | --- |
//! | `/?token=…` | the page |
//! | `/socket?token=…` | WebSocket of a session ([`crate::protocol`]) |
//! | `/export/NAME?token=…` | a file that a run would write |
//!
//! Whatever comes in is taken for hostile: who has not got the token learns nothing, whose `Host` or `Origin` is another one neither (a page of
//! another site that a browser was led to); connections, sizes and rates are bounded, and what waits to be sent is.

mod admission;
mod guard;
mod live;
mod state;
mod tab;
mod token;

pub use live::{Backend, DraftOffer, Live};
pub use state::{Content, Exports, Site};
pub use token::Token;

use admission::{Admission, Peer};
use axum::Router;
use axum::extract::{Extension, Path, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use state::{ServerState, ended};
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::net::TcpStream;
use tokio::runtime::Runtime;
use tokio::sync::watch;

/// Connections at a time that have shown the token: some tabs with the handful that a browser opens for each.
const MAX_CONNECTIONS: u32 = 64;
/// A request's head must have come after so long, or a browser ask for something again.
const HEAD_TIMEOUT: Duration = Duration::from_secs(4);
/// A request's head is no longer than this, bytes.
const MAX_HEAD: usize = 16 << 10;
/// Pages are told that the server ends; what they have not taken after so long is dropped.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_millis(1500);
/// A draft is kept so often, if there is something new in it.
const DRAFT_INTERVAL: Duration = Duration::from_secs(2);

/// What then still runs is left to the end of the process.
const RUNTIME_TIMEOUT: Duration = Duration::from_millis(300);

/// A running server.
pub struct Server {
    runtime: Runtime,
    state: Arc<ServerState>,
    ending: watch::Sender<bool>,
    address: SocketAddr,
}

impl Server {
    /// Serves `site` to whom comes to `listener` and knows `token`. `host`: by which name the listener was bound.
    ///
    /// # Errors
    /// Those of the system: no threads, or a listener that cannot be used.
    pub fn start(listener: TcpListener, host: &str, token: Token, site: Site) -> io::Result<Self> {
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .thread_name("studio-server")
            .enable_io()
            .enable_time()
            .build()?;
        let (ending, seen) = watch::channel(false);
        let admission = Arc::new(Admission::new(MAX_CONNECTIONS));
        let state = Arc::new(ServerState { site, token, host: host.to_owned(), admission, ending: seen });
        let listener = {
            let _within = runtime.enter();
            tokio::net::TcpListener::from_std(listener)?
        };
        runtime.spawn(accept(listener, state.clone()));
        if state.site.live().is_some() {
            runtime.spawn(keep_drafts(state.clone()));
        }
        Ok(Self { runtime, state, ending, address })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// How many connections there are that have shown the token.
    pub fn connections(&self) -> usize {
        self.state.admission.authenticated()
    }

    /// Ends it: takes no more connections, tells the pages, stops what is computed, keeps the draft. Takes two seconds at most. Returns whether
    /// everything that it did has come to its end: where not, a thread still runs, which may be within a driver or a plugin.
    #[must_use]
    pub fn stop(self) -> bool {
        let Self { runtime, state, ending, .. } = self;
        let _ = ending.send(true);
        if let Some(live) = state.site.live() {
            live.close();
        }
        let began = Instant::now();
        runtime.block_on(async {
            let _ = tokio::time::timeout(SHUTDOWN_TIMEOUT, state.admission.all_closed()).await;
        });
        let ended = state.site.live().is_none_or(|live| {
            let ended = live.has_ended(SHUTDOWN_TIMEOUT.saturating_sub(began.elapsed()));
            live.keep();
            ended
        });
        runtime.shutdown_timeout(RUNTIME_TIMEOUT);
        ended
    }
}

/// Takes connections until all is to end.
async fn accept(listener: tokio::net::TcpListener, state: Arc<ServerState>) {
    let mut ending = state.ending.clone();
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = ended(&mut ending) => return,
        };
        match accepted {
            Ok((stream, _)) => {
                let peer = state.admission.register();
                let served = tokio::spawn(connection(stream, state.clone(), peer.clone()));
                peer.wait_for_token(served.abort_handle());
            }
            // The peer has gone already, or there are too many open files: others may have better luck, a little later.
            Err(_) => tokio::time::sleep(Duration::from_millis(20)).await,
        }
    }
}

/// Keeps the draft now and then, until all is to end.
async fn keep_drafts(state: Arc<ServerState>) {
    let mut ending = state.ending.clone();
    loop {
        tokio::select! {
            () = tokio::time::sleep(DRAFT_INTERVAL) => {}
            () = ended(&mut ending) => return,
        }
        let state = state.clone();
        // Files may be slow.
        let _ = tokio::task::spawn_blocking(move || state.site.live().map(Live::keep)).await;
    }
}

/// Serves one connection.
async fn connection(stream: TcpStream, state: Arc<ServerState>, peer: Arc<Peer>) {
    // Small messages go at once, or each would wait for the answer to the one before.
    let _ = stream.set_nodelay(true);
    let mut ending = state.ending.clone();
    let service = TowerToHyperService::new(routes(state, peer));
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .max_buf_size(MAX_HEAD)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    let mut connection = std::pin::pin!(connection);
    tokio::select! {
        // A peer that breaks off is no fault of ours.
        _ = connection.as_mut() => {}
        () = ended(&mut ending) => {
            connection.as_mut().graceful_shutdown();
            let _ = connection.await;
        }
    }
}

/// What answers to what.
fn routes(state: Arc<ServerState>, peer: Arc<Peer>) -> Router {
    Router::new()
        .route("/", get(page))
        .route("/socket", get(tab::open))
        .route("/export/{*name}", get(export))
        .layer(axum::middleware::from_fn_with_state(state.clone(), guard::guard))
        .layer(Extension(peer))
        .with_state(state)
}

async fn page(State(state): State<Arc<ServerState>>) -> Response {
    let kind = (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8"));
    // What scripts, styles and connections it may have says the page itself.
    let policy = (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static("frame-ancestors 'none'"));
    ([kind, policy], state.site.page.clone()).into_response()
}

async fn export(State(state): State<Arc<ServerState>>, Path(name): Path<String>) -> Response {
    let wanted = name.clone();
    let made = tokio::task::spawn_blocking(move || state.site.export(&wanted)).await;
    match made {
        Ok(Some(bytes)) => (file_headers(&name), bytes).into_response(),
        Ok(None) => (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the file could not be made\n").into_response(),
    }
}

/// A file is to be saved, never shown as a page of this server.
fn file_headers(name: &str) -> [(HeaderName, HeaderValue); 3] {
    let last = name.rsplit('/').next().unwrap_or_default();
    let plain: String =
        last.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    let kind = wireloom::export::catalogue::media_type(&plain);
    let disposition = HeaderValue::try_from(format!("attachment; filename=\"{plain}\""));
    [
        (header::CONTENT_TYPE, HeaderValue::from_static(kind)),
        (header::CONTENT_DISPOSITION, disposition.unwrap_or(HeaderValue::from_static("attachment"))),
        (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static("sandbox; default-src 'none'")),
    ]
}
