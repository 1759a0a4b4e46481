//! One tab: a WebSocket between a page and the session.

use super::admission::Peer;
use super::live::{DraftOffer, Live, Refusal, refused};
use super::socket::{Asked, Disconnect, RateLimiter, SEND_TIMEOUT, read, send, send_answer, send_notice};
use super::start;
use super::state::{Content, ServerState, ended};
use crate::exports;
use crate::protocol::{Notice, OfferedDraft, Request, Scene};
use crate::session::{MAX_FILE, MAX_TEXT};
use crate::{Studio, Subscription, TabMessage};
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade, close_code};
use axum::extract::{Extension, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use std::convert::Infallible;
use std::sync::Arc;
use tokio::sync::Notify;

/// Largest request, bytes: the largest text of a scenario, in which every character may be escaped.
const MAX_MESSAGE: usize = 2 * MAX_TEXT;
/// The same where pages may give files to be imported, whose texts are longer.
const MAX_FILE_MESSAGE: usize = 2 * MAX_FILE;

/// `GET /socket`.
pub async fn open(
    State(state): State<Arc<ServerState>>,
    Extension(peer): Extension<Arc<Peer>>,
    upgrade: WebSocketUpgrade,
) -> Response {
    let most = match &state.site().content {
        Content::Live(_) => MAX_MESSAGE,
        // A page that waits for what is opened learns that it is a finished run.
        Content::Start(_) | Content::Finished(_) if state.start().is_some() => MAX_FILE_MESSAGE,
        Content::Start(_) | Content::Finished(_) => {
            return (StatusCode::NOT_FOUND, "there is no session behind this page\n").into_response();
        }
    };
    upgrade.max_message_size(most).max_frame_size(most).on_upgrade(async move |socket| {
        serve(socket, &state).await;
        drop(peer);
    })
}

/// Attachment of a tab to the session, released when the connection ends.
struct TabHandle {
    studio: Arc<Studio>,
    tab: u32,
    subscription: Subscription,
}

impl TabHandle {
    fn take(studio: Arc<Studio>, wake: &Arc<Notify>) -> Self {
        let awake = wake.clone();
        let (tab, subscription) = studio.attach(Box::new(move || awake.notify_one()));
        wake.notify_one();
        Self { studio, tab, subscription }
    }
}

impl Drop for TabHandle {
    fn drop(&mut self) {
        self.studio.detach(self.tab);
    }
}

async fn serve(mut socket: WebSocket, state: &Arc<ServerState>) {
    let Err(end) = relay(&mut socket, state).await;
    if let Disconnect::Closed(code, reason) = end {
        let farewell = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
        let _ = tokio::time::timeout(SEND_TIMEOUT, socket.send(farewell)).await;
    }
}

/// Relays requests and messages until the connection ends.
async fn relay(socket: &mut WebSocket, state: &Arc<ServerState>) -> Result<Infallible, Disconnect> {
    let mut limiter = RateLimiter::new();
    let site = match state.start() {
        Some(start) => start::relay(socket, state, start, &mut limiter).await?,
        None => state.site(),
    };
    if let Some(live) = site.live() {
        return relay_session(socket, state, live, &mut limiter).await;
    }
    send_notice(socket, &Notice::Replay).await?;
    Err(Disconnect::Closed(close_code::NORMAL, "this is a finished run"))
}

/// Relays requests and messages of a session.
async fn relay_session(
    socket: &mut WebSocket,
    state: &Arc<ServerState>,
    live: &Live,
    limiter: &mut RateLimiter,
) -> Result<Infallible, Disconnect> {
    let mut ending = state.ending.clone();
    let (mut studio, mut offers) = (live.studio(), live.offers());
    let wake = Arc::new(Notify::new());
    let mut tab_handle = TabHandle::take(studio.borrow_and_update().clone(), &wake);
    let mut malformed = 0;
    for notice in live.first() {
        send_notice(socket, notice).await?;
    }
    if !offers.borrow_and_update().is_empty() {
        offers.mark_changed();
    }
    loop {
        tokio::select! {
            message = socket.recv() => {
                let message = message.and_then(Result::ok).ok_or(Disconnect::Gone)?;
                limiter.take().await;
                let answer = match read(message, &mut malformed)? {
                    Asked::Request(request) => handle_request(request, &tab_handle, state.clone()).await,
                    Asked::Malformed(refusal) => Err(refusal),
                    Asked::Nothing => continue,
                };
                send_answer(socket, answer).await?;
            }
            () = wake.notified() => {
                match tab_handle.subscription.take() {
                    Some(TabMessage::Notice(Notice::Scene(scene))) => {
                        let exports = exports::names(&scene);
                        let envelope = state.site().envelope.is_some();
                        send_notice(socket, &Notice::Scene(Scene { exports, envelope, ..scene })).await?;
                    }
                    Some(TabMessage::Notice(notice)) => send_notice(socket, &notice).await?,
                    Some(TabMessage::Frame(frame)) => send(socket, Message::Binary(frame.to_vec().into())).await?,
                    None => continue,
                }
                // One message at a time, so that requests are read in between.
                wake.notify_one();
            }
            _ = studio.changed() => tab_handle = TabHandle::take(studio.borrow_and_update().clone(), &wake),
            _ = offers.changed() => {
                let offered = |(number, offer): &(u32, DraftOffer)| {
                    OfferedDraft { number: *number, written: offer.written.clone() }
                };
                let drafts = offers.borrow_and_update().iter().map(offered).collect();
                send_notice(socket, &Notice::Drafts { drafts }).await?;
            }
            () = ended(&mut ending) => return Err(Disconnect::Closed(close_code::AWAY, "the server ends")),
        }
    }
}

/// Handles a request to a session; returns what is answered at once.
async fn handle_request(
    request: Request,
    tab_handle: &TabHandle,
    state: Arc<ServerState>,
) -> Result<Option<Notice>, Refusal> {
    match request {
        Request::Draft { number, take } => {
            // Opening another session takes a while.
            let decided = tokio::task::spawn_blocking(move || state.live().map(|live| live.decide_draft(number, take)));
            match decided.await {
                Ok(Some(Err(refusal))) => Err(refusal),
                Ok(_) => Ok(None),
                Err(_) => Err(refused("the draft cannot be used", "see what the program prints")),
            }
        }
        Request::Check { text, number } => {
            // Beside the solver, which may be busy. A plugin may fail.
            let studio = tab_handle.studio.clone();
            let checked = tokio::task::spawn_blocking(move || studio.check(&text, number)).await;
            checked.map(Some).map_err(|_| refused("the text could not be checked", "see what the program prints"))
        }
        Request::Open { .. } | Request::Contents { .. } => {
            Err(refused("a session opens no other scenario", "start another `wireloom studio` for it"))
        }
        request => {
            tab_handle.studio.submit(tab_handle.tab, request);
            Ok(None)
        }
    }
}
