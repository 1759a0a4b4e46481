//! A hostile client: thousands of messages that are none, many connections at a time. It stands alone, for it looks at the memory and the
//! threads of the process.

mod common;

use common::{Drawer, Served};
use tungstenite::Message;
use wireloom_studio::protocol::Notice;

const CLIENTS: usize = 50;
const MESSAGES: usize = 10_000;
/// Messages that are no requests after which a connection is closed.
const PATIENCE: usize = 9;
/// What the process may have more afterwards, bytes: a server that kept what it was sent (10,000 messages of up to 60 kB) would have some 100 MB more;
/// allocators keep some of what they gave out.
const GROWTH: u64 = 32 << 20;

/// What is no request, of all sorts.
fn malformed(k: usize, random: &mut fastrand::Rng) -> Message {
    let text = |text: &str| Message::Text(text.to_owned().into());
    match k % 12 {
        0 => text(""),
        1 => text("{"),
        2 => text("null"),
        3 => text(r#"{"do":"fly"}"#),
        4 => text(r#"{"do":"go","frame":-1}"#),
        5 => text(r#"{"do":"go","frame":1e99}"#),
        6 => text(r#"{"do":"target","constraint":7,"position":["NaN",null,{}]}"#),
        7 => text(r#"{"do":"go","frame":1,"more":true}"#),
        8 => text(&"[".repeat(random.usize(1..60_000))),
        9 => text(&format!("{{\"do\":\"release\",\"constraint\":\"{}", "ä".repeat(random.usize(1..30_000)))),
        10 => Message::Binary((0..random.usize(0..60_000)).map(|_| random.u8(..)).collect::<Vec<u8>>().into()),
        _ => text(&(0..random.usize(0..200)).map(|_| random.char(..)).collect::<String>()),
    }
}

/// Sends its share, connection after connection: as many as it takes until the server ends each of them.
fn flood(served: &Served, client: usize) {
    let mut random = fastrand::Rng::with_seed(client as u64);
    for connection in 0..MESSAGES.div_ceil(CLIENTS * PATIENCE) {
        let mut tab = loop {
            // The place of the connection before may not have been given back yet.
            match served.connect(&served.query(), None) {
                Ok(tab) => break tab,
                Err(_) => std::thread::yield_now(),
            }
        };
        for k in 0..PATIENCE {
            tab.0.send(malformed(client + connection + k, &mut random)).expect("taken");
        }
        assert_eq!(tab.end(), 1008, "sent away");
    }
}

/// Bytes of memory that the process has.
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("its memory");
    1024 * line.trim().trim_end_matches(" kB").parse::<u64>().expect("a number")
}

/// Threads of the server.
fn threads() -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux");
    let name = |task: std::io::Result<std::fs::DirEntry>| std::fs::read_to_string(task.ok()?.path().join("comm")).ok();
    tasks.filter_map(name).filter(|name| name.starts_with("studio-server")).count()
}

#[cfg(target_os = "linux")]
#[test]
fn ten_thousand_malformed_messages_of_fifty_clients_do_no_harm() {
    let served = Served::new(None, Drawer::default());
    let mut good = served.tab();
    good.rest();
    let round = || {
        std::thread::scope(|scope| {
            for client in 0..CLIENTS {
                let served = &served;
                scope.spawn(move || flood(served, client));
            }
        });
    };
    // Once for the allocator to have what it needs.
    round();
    let before = memory();
    round();
    let after = memory();
    assert!(after < before + GROWTH, "{before} bytes before, {after} after");
    // Who behaves is still heard.
    good.ask(&wireloom_studio::protocol::Request::Save);
    let text = good.until(|notice| if let Notice::Saved { text, .. } = notice { Some(text) } else { None });
    assert!(wireloom::load(&text, &wireloom::registry()).is_ok());
    // A message that is too long ends the connection; so does a frame that is none.
    let mut long = served.tab();
    let _ = long.0.send(Message::Text("x".repeat(70_000).into()));
    assert_ne!(long.end(), 1001);
    drop((long, good));
    while served.server.connections() > 0 {
        std::thread::yield_now();
    }
    assert!(threads() > 0);
    assert!(served.server.stop(), "nothing is left");
    assert_eq!(threads(), 0, "its threads have gone");
}
