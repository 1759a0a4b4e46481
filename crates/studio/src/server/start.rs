//! A tab of the start page, until something is opened there.

use super::live::Refusal;
use super::socket::{Asked, Disconnect, RateLimiter, read, send_answer};
use super::state::{ServerState, Site, Start, ended, not_opened};
use crate::protocol::Notice;
use axum::extract::ws::{WebSocket, close_code};
use std::sync::Arc;

/// Relays requests until a session is opened; returns its site.
pub(super) async fn relay<'a>(
    socket: &mut WebSocket,
    state: &'a Arc<ServerState>,
    start: &'a Start,
    limiter: &mut RateLimiter,
) -> Result<&'a Site, Disconnect> {
    let mut ending = state.ending.clone();
    let mut has_opened = start.has_opened();
    let mut malformed = 0;
    if start.opened().is_none() {
        let page = answer(state, |start| Ok(Some(Notice::StartPage(start.page())))).await;
        send_answer(socket, page).await?;
    }
    loop {
        if let Some(site) = start.opened() {
            return Ok(site);
        }
        tokio::select! {
            message = socket.recv() => {
                let message = message.and_then(Result::ok).ok_or(Disconnect::Gone)?;
                limiter.take().await;
                let answered = match read(message, &mut malformed)? {
                    Asked::Request(request) => answer(state, |start| start.answer(request)).await,
                    Asked::Malformed(refusal) => Err(refusal),
                    Asked::Nothing => continue,
                };
                send_answer(socket, answered).await?;
            }
            _ = has_opened.changed() => {}
            () = ended(&mut ending) => return Err(Disconnect::Closed(close_code::AWAY, "the server ends")),
        }
    }
}

type Answer = Result<Option<Notice>, Refusal>;

/// What the start page answers, on a thread that may wait: files are read, and a harness may be large.
async fn answer(state: &Arc<ServerState>, make: impl FnOnce(&Start) -> Answer + Send + 'static) -> Answer {
    let state = state.clone();
    let made = tokio::task::spawn_blocking(move || state.start().map_or(Ok(None), make)).await;
    made.unwrap_or_else(|_| {
        let help = "this is an error of the program: see what it prints";
        Ok(Some(Notice::NotOpened(not_opened("it could not be opened", help, "", &[]))))
    })
}
