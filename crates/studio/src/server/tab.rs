//! One tab: a WebSocket between a page and the session.

use super::admission::Peer;
use super::live::{Live, Refusal, refused};
use super::state::{ServerState, ended};
use crate::exports;
use crate::protocol::{Notice, Request, Scene};
use crate::session::MAX_TEXT;
use crate::{Studio, Subscription, TabMessage};
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade, close_code};
use axum::extract::{Extension, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::Instant;

/// Largest request, bytes: the largest text of a scenario, in which every character may be escaped.
const MAX_MESSAGE: usize = 2 * MAX_TEXT;
/// Largest rate of requests per second: twice that of a drag on a fast screen. Faster clients are read later.
const RATE: f64 = 240.0;
/// Largest burst of requests.
const BURST: f64 = 240.0;
/// Number of malformed messages after which the connection is closed.
const MAX_MALFORMED: u32 = 8;
/// Time limit for sending a message.
const SEND_TIMEOUT: Duration = Duration::from_secs(10);
/// Refusals are truncated to this length, bytes: they may repeat the request.
const MAX_REFUSAL: usize = 400;

/// `GET /socket`.
pub async fn open(
    State(state): State<Arc<ServerState>>,
    Extension(peer): Extension<Arc<Peer>>,
    upgrade: WebSocketUpgrade,
) -> Response {
    if state.site.live().is_none() {
        return (StatusCode::NOT_FOUND, "there is no session behind this page\n").into_response();
    }
    upgrade.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE).on_upgrade(async move |socket| {
        if let Some(live) = state.site.live() {
            serve(socket, &state, live).await;
        }
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

/// Reason for the end of a connection.
enum Disconnect {
    /// The page has gone, or does not receive any more.
    Gone,
    /// Closed by the server, with code and reason.
    Closed(u16, &'static str),
}

async fn serve(mut socket: WebSocket, state: &Arc<ServerState>, live: &Live) {
    let Err(end) = relay(&mut socket, state, live).await;
    if let Disconnect::Closed(code, reason) = end {
        let farewell = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
        let _ = tokio::time::timeout(SEND_TIMEOUT, socket.send(farewell)).await;
    }
}

/// Relays requests and messages until the connection ends.
async fn relay(
    socket: &mut WebSocket,
    state: &Arc<ServerState>,
    live: &Live,
) -> Result<std::convert::Infallible, Disconnect> {
    let mut ending = state.ending.clone();
    let (mut studio, mut offer) = (live.studio(), live.offer());
    let wake = Arc::new(Notify::new());
    let mut tab_handle = TabHandle::take(studio.borrow_and_update().clone(), &wake);
    let (mut limiter, mut malformed) = (RateLimiter::new(), 0);
    if offer.borrow_and_update().is_some() {
        offer.mark_changed();
    }
    loop {
        tokio::select! {
            message = socket.recv() => {
                let message = message.and_then(Result::ok).ok_or(Disconnect::Gone)?;
                limiter.take().await;
                match handle_message(message, &tab_handle, state.clone()).await? {
                    Handled::Done => {}
                    Handled::Answered(notice) => send_notice(socket, &notice).await?,
                    Handled::Refused(refusal) => send_notice(socket, &refusal.into()).await?,
                    Handled::Malformed(refusal) if malformed < MAX_MALFORMED => {
                        malformed += 1;
                        send_notice(socket, &refusal.into()).await?;
                    }
                    Handled::Malformed(_) => {
                        return Err(Disconnect::Closed(close_code::POLICY, "too many malformed messages"));
                    }
                }
            }
            () = wake.notified() => {
                match tab_handle.subscription.take() {
                    Some(TabMessage::Notice(Notice::Scene(scene))) => {
                        let exports = exports::names(&scene);
                        let envelope = state.site.envelope.is_some();
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
            _ = offer.changed() => {
                let written = offer.borrow_and_update().as_ref().map(|offer| offer.written.clone());
                send_notice(socket, &Notice::Draft { written }).await?;
            }
            () = ended(&mut ending) => return Err(Disconnect::Closed(close_code::AWAY, "the server ends")),
        }
    }
}

/// Result of a message.
#[expect(clippy::large_enum_variant, reason = "one at a time is passed on, and none is kept")]
enum Handled {
    Done,
    /// A request that is answered at once.
    Answered(Notice),
    /// A valid request that cannot be fulfilled.
    Refused(Refusal),
    /// Not a valid request.
    Malformed(Refusal),
}

/// Handles a message.
async fn handle_message(
    message: Message,
    tab_handle: &TabHandle,
    state: Arc<ServerState>,
) -> Result<Handled, Disconnect> {
    let text = match message {
        Message::Text(text) => text,
        Message::Ping(_) | Message::Pong(_) => return Ok(Handled::Done),
        Message::Close(_) => return Err(Disconnect::Gone),
        Message::Binary(_) => {
            return Ok(Handled::Malformed(refused("binary messages are not requests", "requests are JSON text")));
        }
    };
    match serde_json::from_str(&text) {
        Ok(Request::Draft { take }) => {
            // Opening another session takes a while.
            let decided = tokio::task::spawn_blocking(move || state.site.live().map(|live| live.decide_draft(take)));
            Ok(match decided.await {
                Ok(Some(Err(refusal))) => Handled::Refused(refusal),
                Ok(_) => Handled::Done,
                Err(_) => Handled::Refused(refused("the draft cannot be used", "see what the program prints")),
            })
        }
        Ok(Request::Check { text, number }) => {
            // Beside the solver, which may be busy. A plugin may fail.
            let studio = tab_handle.studio.clone();
            let checked = tokio::task::spawn_blocking(move || studio.check(&text, number)).await;
            Ok(checked.map_or_else(
                |_| Handled::Refused(refused("the text could not be checked", "see what the program prints")),
                Handled::Answered,
            ))
        }
        Ok(request) => {
            tab_handle.studio.submit(tab_handle.tab, request);
            Ok(Handled::Done)
        }
        Err(error) => {
            let mut words = error.to_string();
            words.truncate(words.floor_char_boundary(MAX_REFUSAL));
            Ok(Handled::Malformed(refused(
                &format!("not a valid request: {words}"),
                "reload the page: its version differs",
            )))
        }
    }
}

/// Sends a notice.
async fn send_notice(socket: &mut WebSocket, notice: &Notice) -> Result<(), Disconnect> {
    let text = serde_json::to_string(notice).map_err(|_| Disconnect::Gone)?;
    send(socket, Message::Text(text.into())).await
}

async fn send(socket: &mut WebSocket, message: Message) -> Result<(), Disconnect> {
    match tokio::time::timeout(SEND_TIMEOUT, socket.send(message)).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) | Err(_) => Err(Disconnect::Gone),
    }
}

/// Rate limiter (token bucket). While it waits nothing is read, so that the sender has to wait too.
struct RateLimiter {
    tokens: f64,
    filled: Instant,
}

impl RateLimiter {
    fn new() -> Self {
        Self { tokens: BURST, filled: Instant::now() }
    }

    async fn take(&mut self) {
        let now = Instant::now();
        self.tokens = (self.tokens + RATE * (now - self.filled).as_secs_f64()).min(BURST);
        self.filled = now;
        self.tokens -= 1.0;
        if self.tokens < 0.0 {
            tokio::time::sleep(Duration::from_secs_f64(-self.tokens / RATE)).await;
        }
    }
}
