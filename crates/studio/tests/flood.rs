//! A hostile client: thousands of malformed messages, many connections at a time. A test program of its own, because it
//! measures memory and threads of the process.

mod common;

use common::{MemoryBackend, Served};
use tungstenite::Message;
use wireloom_studio::protocol::Notice;

const CLIENTS: usize = 50;
const MESSAGES: usize = 10_000;
/// Number of malformed messages after which a connection is closed.
const PATIENCE: usize = 9;
/// Allowed growth of the process, bytes: a server that kept all messages (10,000 of up to 60 kB) would grow by about
/// 100 MB; allocators keep some memory.
const GROWTH: u64 = 32 << 20;

/// Malformed messages of all kinds.
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

/// Sends malformed messages over one connection after another, until the server closes each.
fn flood(served: &Served, client: usize) {
    let mut random = fastrand::Rng::with_seed(client as u64);
    for connection in 0..MESSAGES.div_ceil(CLIENTS * PATIENCE) {
        let mut tab = loop {
            // The slot of the previous connection may not be free yet.
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

/// Memory of the process, bytes.
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("its memory");
    1024 * line.trim().trim_end_matches(" kB").parse::<u64>().expect("a number")
}

/// Number of threads of the server.
fn threads() -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux");
    let name = |task: std::io::Result<std::fs::DirEntry>| std::fs::read_to_string(task.ok()?.path().join("comm")).ok();
    tasks.filter_map(name).filter(|name| name.starts_with("studio-server")).count()
}

#[cfg(target_os = "linux")]
#[test]
fn ten_thousand_malformed_messages_of_fifty_clients_do_no_harm() {
    let served = Served::new(MemoryBackend::default());
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
    // Once in advance, so that the allocator has its memory.
    round();
    let before = memory();
    round();
    let after = memory();
    assert!(after < before + GROWTH, "{before} bytes before, {after} after");
    // A correct client is still served.
    good.ask(&wireloom_studio::protocol::Request::Save);
    let text = good.until(|notice| if let Notice::Saved { text, .. } = notice { Some(text) } else { None });
    assert!(wireloom::load(&text, &wireloom::registry()).is_ok());
    // A message that is too long closes the connection; so does an invalid frame.
    let mut long = served.tab();
    let _ = long.0.send(Message::Text("x".repeat(9 << 20).into()));
    assert_ne!(long.end(), 1001);
    drop((long, good));
    while served.server.connections() > 0 {
        std::thread::yield_now();
    }
    assert!(threads() > 0);
    assert!(served.server.stop(), "nothing is left");
    assert_eq!(threads(), 0, "its threads have gone");
}
