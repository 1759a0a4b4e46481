//! Messages between a page and the server.

use super::live::{Refusal, refused};
use crate::protocol::{Notice, Request};
use axum::extract::ws::{Message, WebSocket, close_code};
use std::time::Duration;
use tokio::time::Instant;

/// Number of malformed messages after which the connection is closed.
const MAX_MALFORMED: u32 = 8;
/// Time limit for sending a message.
pub(super) const SEND_TIMEOUT: Duration = Duration::from_secs(10);
/// Largest rate of requests per second: twice that of a drag on a fast screen. Faster clients are read later.
const RATE: f64 = 240.0;
/// Largest burst of requests.
const BURST: f64 = 240.0;
/// Refusals are truncated to this length, bytes: they may repeat the request.
const MAX_REFUSAL: usize = 400;

/// Reason for the end of a connection.
pub(super) enum Disconnect {
    /// The page has gone, or does not receive any more.
    Gone,
    /// Closed by the server, with code and reason.
    Closed(u16, &'static str),
}

/// What is in a message.
pub(super) enum Asked {
    /// A request.
    Request(Request),
    /// Something else, and what is answered.
    Malformed(Refusal),
    /// Nothing: it keeps the connection alive.
    Nothing,
}

/// Reads a message. `malformed`: the number of messages so far that were no requests.
///
/// # Errors
/// If the page closes the connection, or has sent too many malformed messages.
pub(super) fn read(message: Message, malformed: &mut u32) -> Result<Asked, Disconnect> {
    let refusal = match message {
        Message::Text(text) => match serde_json::from_str(&text) {
            Ok(request) => return Ok(Asked::Request(request)),
            Err(error) => {
                let mut words = error.to_string();
                words.truncate(words.floor_char_boundary(MAX_REFUSAL));
                refused(&format!("not a valid request: {words}"), "reload the page: its version differs")
            }
        },
        Message::Ping(_) | Message::Pong(_) => return Ok(Asked::Nothing),
        Message::Close(_) => return Err(Disconnect::Gone),
        Message::Binary(_) => refused("binary messages are not requests", "requests are JSON text"),
    };
    if *malformed >= MAX_MALFORMED {
        return Err(Disconnect::Closed(close_code::POLICY, "too many malformed messages"));
    }
    *malformed += 1;
    Ok(Asked::Malformed(refusal))
}

/// Sends a notice.
pub(super) async fn send_notice(socket: &mut WebSocket, notice: &Notice) -> Result<(), Disconnect> {
    let text = serde_json::to_string(notice).map_err(|_| Disconnect::Gone)?;
    send(socket, Message::Text(text.into())).await
}

pub(super) async fn send(socket: &mut WebSocket, message: Message) -> Result<(), Disconnect> {
    match tokio::time::timeout(SEND_TIMEOUT, socket.send(message)).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) | Err(_) => Err(Disconnect::Gone),
    }
}

/// Sends what is answered to a request.
pub(super) async fn send_answer(
    socket: &mut WebSocket,
    answer: Result<Option<Notice>, Refusal>,
) -> Result<(), Disconnect> {
    match answer {
        Ok(None) => Ok(()),
        Ok(Some(notice)) => send_notice(socket, &notice).await,
        Err(refusal) => send_notice(socket, &refusal.into()).await,
    }
}

/// Rate limiter (token bucket). While it waits nothing is read, so that the sender has to wait too.
pub(super) struct RateLimiter {
    tokens: f64,
    filled: Instant,
}

impl RateLimiter {
    pub(super) fn new() -> Self {
        Self { tokens: BURST, filled: Instant::now() }
    }

    pub(super) async fn take(&mut self) {
        let now = Instant::now();
        self.tokens = (self.tokens + RATE * (now - self.filled).as_secs_f64()).min(BURST);
        self.filled = now;
        self.tokens -= 1.0;
        if self.tokens < 0.0 {
            tokio::time::sleep(Duration::from_secs_f64(-self.tokens / RATE)).await;
        }
    }
}
