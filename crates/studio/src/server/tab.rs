//! One tab: a WebSocket between a page and the session.

use super::door::Visitor;
use super::live::{Live, Refusal, refused};
use super::state::{House, ended};
use crate::exports;
use crate::protocol::{Notice, Request, Scene};
use crate::{Feed, Studio, Told};
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade, close_code};
use axum::extract::{Extension, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::Instant;

/// A request is no longer than this, bytes: none that a page makes is a tenth of it.
const LONGEST: usize = 64 << 10;
/// Requests a second that are read: twice what a page sends that drags on a fast screen. Whoever sends more is read later.
const RATE: f64 = 240.0;
/// So many may come at once.
const BURST: f64 = 240.0;
/// Messages that are no requests; behind them the connection is closed.
const STRIKES: u32 = 8;
/// What a page has not taken after so long it will never take.
const PATIENCE: Duration = Duration::from_secs(10);
/// Words of a refusal are cut off here, bytes: they may repeat what was sent.
const WORDS: usize = 400;

/// `GET /socket`.
pub async fn open(
    State(house): State<Arc<House>>,
    Extension(visitor): Extension<Arc<Visitor>>,
    upgrade: WebSocketUpgrade,
) -> Response {
    if house.site.live().is_none() {
        return (StatusCode::NOT_FOUND, "there is no session behind this page\n").into_response();
    }
    upgrade.max_message_size(LONGEST).max_frame_size(LONGEST).on_upgrade(async move |socket| {
        if let Some(live) = house.site.live() {
            serve(socket, &house, live).await;
        }
        drop(visitor);
    })
}

/// A tab's place in the session, given back whatever becomes of the connection.
struct Seat {
    studio: Arc<Studio>,
    tab: u32,
    feed: Feed,
}

impl Seat {
    fn take(studio: Arc<Studio>, wake: &Arc<Notify>) -> Self {
        let awake = wake.clone();
        let (tab, feed) = studio.attach(Box::new(move || awake.notify_one()));
        wake.notify_one();
        Self { studio, tab, feed }
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.studio.detach(self.tab);
    }
}

/// Why a connection ends.
enum End {
    /// The page has gone, or takes nothing any more.
    Gone,
    /// The page is told why.
    Told(u16, &'static str),
}

async fn serve(mut socket: WebSocket, house: &Arc<House>, live: &Live) {
    let Err(end) = talk(&mut socket, house, live).await;
    if let End::Told(code, reason) = end {
        let farewell = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
        let _ = tokio::time::timeout(PATIENCE, socket.send(farewell)).await;
    }
}

/// Carries requests to the session and what it tells to the page, until one of them ends.
async fn talk(socket: &mut WebSocket, house: &Arc<House>, live: &Live) -> Result<std::convert::Infallible, End> {
    let mut ending = house.ending.clone();
    let (mut studio, mut offer) = (live.studio(), live.offer());
    let wake = Arc::new(Notify::new());
    let mut seat = Seat::take(studio.borrow_and_update().clone(), &wake);
    let (mut bucket, mut strikes) = (Bucket::new(), 0);
    if offer.borrow_and_update().is_some() {
        offer.mark_changed();
    }
    loop {
        tokio::select! {
            message = socket.recv() => {
                let message = message.and_then(Result::ok).ok_or(End::Gone)?;
                bucket.take().await;
                match heard(message, &seat, house.clone()).await? {
                    Heard::Done => {}
                    Heard::Refused(refusal) => say(socket, &refusal.into()).await?,
                    Heard::Malformed(refusal) if strikes < STRIKES => {
                        strikes += 1;
                        say(socket, &refusal.into()).await?;
                    }
                    Heard::Malformed(_) => return Err(End::Told(close_code::POLICY, "too many messages that are no requests")),
                }
            }
            () = wake.notified() => {
                match seat.feed.take() {
                    Some(Told::Notice(Notice::Scene(scene))) => {
                        let exports = exports::names(&scene);
                        say(socket, &Notice::Scene(Scene { exports, ..scene })).await?;
                    }
                    Some(Told::Notice(notice)) => say(socket, &notice).await?,
                    Some(Told::Frame(frame)) => send(socket, Message::Binary(frame.to_vec().into())).await?,
                    None => continue,
                }
                // One at a time, so that what the page says is heard between them.
                wake.notify_one();
            }
            _ = studio.changed() => seat = Seat::take(studio.borrow_and_update().clone(), &wake),
            _ = offer.changed() => {
                let written = offer.borrow_and_update().as_ref().map(|offer| offer.written.clone());
                say(socket, &Notice::Draft { written }).await?;
            }
            () = ended(&mut ending) => return Err(End::Told(close_code::AWAY, "the server ends")),
        }
    }
}

/// What came of a message.
enum Heard {
    Done,
    /// A request that cannot be fulfilled.
    Refused(Refusal),
    /// No request at all.
    Malformed(Refusal),
}

/// Hands a request on.
async fn heard(message: Message, seat: &Seat, house: Arc<House>) -> Result<Heard, End> {
    let text = match message {
        Message::Text(text) => text,
        Message::Ping(_) | Message::Pong(_) => return Ok(Heard::Done),
        Message::Close(_) => return Err(End::Gone),
        Message::Binary(_) => {
            return Ok(Heard::Malformed(refused("bytes are no request", "requests are JSON, as text")));
        }
    };
    match serde_json::from_str(&text) {
        Ok(Request::Draft { take }) => {
            // Another session is opened: that takes a while.
            let decided = tokio::task::spawn_blocking(move || house.site.live().map(|live| live.decide(take)));
            Ok(match decided.await {
                Ok(Some(Err(refusal))) => Heard::Refused(refusal),
                Ok(_) => Heard::Done,
                Err(_) => Heard::Refused(refused("the draft cannot be taken up", "see what the program prints")),
            })
        }
        Ok(request) => {
            seat.studio.ask(seat.tab, request);
            Ok(Heard::Done)
        }
        Err(error) => {
            let mut words = error.to_string();
            words.truncate(words.floor_char_boundary(WORDS));
            Ok(Heard::Malformed(refused(
                &format!("this is no request: {words}"),
                "reload the page: it is of another version",
            )))
        }
    }
}

/// Tells the page something.
async fn say(socket: &mut WebSocket, notice: &Notice) -> Result<(), End> {
    let text = serde_json::to_string(notice).map_err(|_| End::Gone)?;
    send(socket, Message::Text(text.into())).await
}

async fn send(socket: &mut WebSocket, message: Message) -> Result<(), End> {
    match tokio::time::timeout(PATIENCE, socket.send(message)).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) | Err(_) => Err(End::Gone),
    }
}

/// Lets through what is within the rate, and makes the rest wait: meanwhile nothing is read, so the sender has to wait, too.
struct Bucket {
    tokens: f64,
    filled: Instant,
}

impl Bucket {
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
