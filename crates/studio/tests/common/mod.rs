//! A server with a session, and its clients.
#![allow(dead_code, reason = "each of the tests uses some of it")]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};
use wireloom::scenario::NoFiles;
use wireloom::session::Refusal;
use wireloom_studio::exports::{self, ExportInfo};
use wireloom_studio::protocol::{Notice, Request};
use wireloom_studio::server::{Backend, Content, DraftOffer, Live, Server, Site, Token};
use wireloom_studio::{SessionInput, Studio, open};

/// A cable between two connectors.
pub const TEXT: &str = r#"
schema = 1
name = "cable"
[sections.cable]
diameter = "6 mm"
linear_density = "50 g/m"
axial_stiffness = 1e4
bending_stiffness = 0.01
torsion_stiffness = 0.008
[[branches]]
name = "cable"
from = "A"
to = "B"
section = "cable"
length = "1 m"
segments = 40
[[constraints]]
name = "plug-A"
kind = "connector"
at = { end = "A" }
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[constraints]]
name = "plug-B"
kind = "connector"
at = { end = "B" }
position = ["600 mm", 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
"#;

pub fn session(text: &str, unsaved: bool) -> Result<Studio, String> {
    let (text, name) = (text.to_owned(), "cable.toml".to_owned());
    let opened =
        SessionInput { text, name, files: Arc::new(NoFiles), registry: wireloom::registry(), unsaved, storage: None };
    open(opened).map_err(|faults| faults[0].message.clone())
}

/// Stores the draft of the session and those of earlier ones in memory.
#[derive(Clone, Default)]
pub struct MemoryBackend(pub Arc<Mutex<Option<String>>>, pub Arc<Mutex<Vec<String>>>);

impl Backend for MemoryBackend {
    fn keep(&self, draft: Option<&str>) {
        *self.0.lock().expect("not poisoned") = draft.map(str::to_owned);
    }

    fn discard(&self, draft: &str) {
        self.1.lock().expect("not poisoned").retain(|own| own != draft);
    }

    fn open(&self, draft: &str) -> Result<Studio, String> {
        session(draft, true)
    }

    fn store_beside(&self, name: &str, bytes: &[u8]) -> Result<String, Refusal> {
        Ok(format!("{}-{name}", bytes.len()))
    }

    fn changed_outside(&self) -> Option<String> {
        None
    }

    fn export(&self, studio: &Studio, name: &str) -> Option<Vec<u8>> {
        let outcome = studio.result()?;
        let (scenario, _) = wireloom::load(TEXT, &wireloom::registry()).ok()?;
        let provenance = wireloom::export::provenance("wireloom", &scenario, &[], &[], &[]);
        let made = ExportInfo {
            provenance: &provenance,
            texts: &[],
            program: "wireloom",
            machine: "a machine",
            written: "today",
        };
        exports::make(&outcome.run, &outcome.obstacles, name, &made)
    }
}

pub struct Served {
    pub server: Server,
    pub address: SocketAddr,
    pub token: String,
}

impl Served {
    /// It offers the drafts of earlier sessions that the backend has.
    pub fn new(backend: MemoryBackend) -> Self {
        let texts = backend.1.lock().expect("not poisoned").clone();
        let offer = |text| DraftOffer { text, written: "2026-11-21T20:00:00Z".into() };
        let offers = texts.into_iter().map(offer).collect();
        let live = Live::new(session(TEXT, false).expect("no faults"), offers, Box::new(backend));
        let (page, content) = ("<html>page</html>".to_owned(), Content::Live(live));
        Self::of(Site { page, content, envelope: None })
    }

    pub fn of(site: Site) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let token = Token::random().expect("random numbers");
        let digits = token.digits().to_owned();
        let server = Server::start(listener, "127.0.0.1", token, site).expect("started");
        Self { address: server.address(), server, token: digits }
    }

    /// The response to a request with these header lines.
    pub fn get(&self, path: &str, lines: &[&str]) -> String {
        let mut stream = TcpStream::connect(self.address).expect("it listens");
        let head = format!("GET {path} HTTP/1.1\r\n{}\r\nConnection: close\r\n\r\n", lines.join("\r\n"));
        stream.write_all(head.as_bytes()).expect("taken");
        let mut answer = Vec::new();
        // A server that resets the connection has sent everything.
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// The response to a file that a page sends.
    pub fn post_own(&self, path: &str, content: &[u8]) -> String {
        let mut stream = TcpStream::connect(self.address).expect("it listens");
        let host = self.address;
        let length = content.len();
        let head = format!(
            "POST {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Length: {length}\r\n\
             Connection: close\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).expect("taken");
        // A server that refuses it does not read it to the end.
        let _ = stream.write_all(content);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// A request as browsers send it.
    pub fn get_own(&self, path: &str) -> String {
        self.get(path, &[&format!("Host: {}", self.address)])
    }

    pub fn query(&self) -> String {
        format!("token={}", self.token)
    }

    /// A page's connection, or the status with which it was refused.
    pub fn connect(&self, query: &str, origin: Option<&str>) -> Result<Tab, u16> {
        let mut request = format!("ws://{}/socket?{query}", self.address).into_client_request().expect("a request");
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().expect("a value"));
        }
        let stream = TcpStream::connect(self.address).expect("it listens");
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Tab(socket)),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(answer.status().as_u16())
            }
            Err(_) => Err(0),
        }
    }

    pub fn tab(&self) -> Tab {
        self.connect(&self.query(), Some(&format!("http://{}", self.address))).expect("let in")
    }
}

pub struct Tab(pub WebSocket<TcpStream>);

impl Tab {
    pub fn ask(&mut self, request: &Request) {
        let text = serde_json::to_string(request).expect("JSON");
        self.0.send(Message::Text(text.into())).expect("taken");
    }

    /// The next notice for which a function returns a value; frames and other notices are skipped.
    pub fn until<T>(&mut self, wanted: impl Fn(Notice) -> Option<T>) -> T {
        loop {
            if let Message::Text(text) = self.0.read().expect("the server speaks") {
                let notice = serde_json::from_str(&text).expect("a notice");
                if let Some(found) = wanted(notice) {
                    return found;
                }
            }
        }
    }

    /// Waits until nothing is being computed.
    pub fn rest(&mut self) {
        self.until(|notice| match notice {
            Notice::Session(session) if session.busy.is_none() => Some(()),
            _ => None,
        });
    }

    /// Code with which the server closes the connection; 0 if it was reset.
    pub fn end(&mut self) -> u16 {
        loop {
            match self.0.read() {
                Ok(Message::Close(frame)) => return frame.map_or(0, |frame| frame.code.into()),
                Ok(_) => {}
                Err(_) => return 0,
            }
        }
    }
}
