//! The web server of the studio. It serves browsers on this machine that know the token:
//!
//! | address | what |
//! | --- | --- |
//! | `/?token=…` | the page |
//! | `/socket?token=…` | WebSocket of a session ([`crate::protocol`]) |
//! | `/export/NAME?token=…` | a file that a run would write |
//! | `/surroundings/NAME?token=…` | takes a file with the surface of an obstacle |
//!
//! All input is treated as hostile. Without the token, or with a wrong `Host` or `Origin` (a page of another site in
//! the user's browser), a client gets no information. Connections, message sizes, rates and send queues are bounded.

mod admission;
mod guard;
mod live;
mod socket;
mod start;
mod state;
mod surroundings;
mod tab;
mod token;

pub use live::{Backend, DraftOffer, Live};
pub use state::{Content, Exports, Site, Start, Starter, not_opened};
pub use token::Token;

use admission::{Admission, Peer};
use axum::Router;
use axum::extract::{Extension, Path, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
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

/// Largest number of authenticated connections: several tabs with a few connections each.
const MAX_CONNECTIONS: u32 = 64;
/// Time limit for the head of a request, also on an idle connection.
const HEAD_TIMEOUT: Duration = Duration::from_secs(4);
/// Largest head of a request, bytes.
const MAX_HEAD: usize = 16 << 10;
/// Time for pages to receive the end of the session; the rest is dropped.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_millis(1500);
/// Interval for saving the draft, if it has changed.
const DRAFT_INTERVAL: Duration = Duration::from_secs(2);

/// Time for tasks that still run; then they are left to the end of the process.
const RUNTIME_TIMEOUT: Duration = Duration::from_millis(300);

/// A running server.
pub struct Server {
    runtime: Runtime,
    state: Arc<ServerState>,
    ending: watch::Sender<bool>,
    address: SocketAddr,
}

impl Server {
    /// Serves `site` to clients of `listener` that know `token`. `host`: the name to which the listener was bound.
    ///
    /// # Errors
    /// Errors of the system: no threads, or an unusable listener.
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
        let state = Arc::new(ServerState { first: site, token, host: host.to_owned(), admission, ending: seen });
        let listener = {
            let _within = runtime.enter();
            tokio::net::TcpListener::from_std(listener)?
        };
        runtime.spawn(accept(listener, state.clone()));
        if state.live().is_some() || state.start().is_some() {
            runtime.spawn(keep_drafts(state.clone()));
        }
        Ok(Self { runtime, state, ending, address })
    }

    /// The address it listens on.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Number of authenticated connections.
    pub fn connections(&self) -> usize {
        self.state.admission.authenticated()
    }

    /// Stops the server: accepts no more connections, notifies the pages, stops the computation, saves the draft. Takes
    /// at most two seconds. Returns whether everything has ended; otherwise a thread still runs, which may be within a
    /// driver or a plugin.
    #[must_use]
    pub fn stop(self) -> bool {
        let Self { runtime, state, ending, .. } = self;
        let _ = ending.send(true);
        if let Some(live) = state.live() {
            live.close();
        }
        let began = Instant::now();
        runtime.block_on(async {
            let _ = tokio::time::timeout(SHUTDOWN_TIMEOUT, state.admission.all_closed()).await;
        });
        let ended = state.live().is_none_or(|live| {
            let ended = live.has_ended(SHUTDOWN_TIMEOUT.saturating_sub(began.elapsed()));
            live.keep();
            ended
        });
        runtime.shutdown_timeout(RUNTIME_TIMEOUT);
        ended
    }
}

/// Accepts connections until shutdown.
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
            // The peer has already gone, or too many files are open: retry a little later.
            Err(_) => tokio::time::sleep(Duration::from_millis(20)).await,
        }
    }
}

/// Saves the draft at intervals, until shutdown.
async fn keep_drafts(state: Arc<ServerState>) {
    let mut ending = state.ending.clone();
    loop {
        tokio::select! {
            () = tokio::time::sleep(DRAFT_INTERVAL) => {}
            () = ended(&mut ending) => return,
        }
        let state = state.clone();
        // File access may be slow.
        let _ = tokio::task::spawn_blocking(move || state.live().map(Live::keep)).await;
    }
}

/// Serves one connection.
async fn connection(stream: TcpStream, state: Arc<ServerState>, peer: Arc<Peer>) {
    // Send small messages at once instead of waiting for acknowledgements.
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
        // A connection closed by the peer is not an error.
        _ = connection.as_mut() => {}
        () = ended(&mut ending) => {
            connection.as_mut().graceful_shutdown();
            let _ = connection.await;
        }
    }
}

/// Routes of the server.
fn routes(state: Arc<ServerState>, peer: Arc<Peer>) -> Router {
    Router::new()
        .route("/", get(page))
        .route("/socket", get(tab::open))
        .route("/export/{*name}", get(export))
        .route("/envelope", get(envelope))
        .route("/surroundings/{name}", post(surroundings::store))
        .layer(axum::middleware::from_fn_with_state(state.clone(), guard::guard))
        .layer(Extension(peer))
        .with_state(state)
}

async fn page(State(state): State<Arc<ServerState>>) -> Response {
    let kind = (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8"));
    // The page itself states its content security policy.
    let policy = (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static("frame-ancestors 'none'"));
    ([kind, policy], state.site().page.clone()).into_response()
}

async fn envelope(State(state): State<Arc<ServerState>>) -> Response {
    match &state.site().envelope {
        Some(bytes) => (file_headers("envelope"), bytes.clone()).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no envelope\n").into_response(),
    }
}

async fn export(State(state): State<Arc<ServerState>>, Path(name): Path<String>) -> Response {
    let wanted = name.clone();
    let made = tokio::task::spawn_blocking(move || state.site().export(&wanted)).await;
    match made {
        Ok(Some(bytes)) => (file_headers(&name), bytes).into_response(),
        Ok(None) => (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the file could not be made\n").into_response(),
    }
}

/// Headers of a file that is saved, and never shown as a page of this server.
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
