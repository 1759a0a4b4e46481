//! Latency of a drag: from a target to its frame, over loopback, as for a page.

use crate::frame;
use crate::protocol::{Constraint, Notice, Request, Scene};
use crate::server::{Backend, Content, Live, Server, Site, Token};
use crate::{SessionInput, Studio, open};
use std::fmt::Write;
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::time::Instant;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};
use wireloom::geometry::{Rotation, Vector};
use wireloom::import::kbl::{Arrangement, Options, import};
use wireloom::scenario::{NoFiles, render};
use wireloom::session::Refusal;

/// Distance of successive targets, m.
const TARGET_SPACING: f64 = 0.005;
/// Targets per stroke, and as many back.
const TARGETS_PER_STROKE: usize = 10;
/// Number of strokes out and back.
const STROKES: usize = 4;
/// Largest distance between nodes of an imported harness, m.
const SPACING: f64 = 0.010;
/// A frame has reached its target within this distance, m.
const POSITION_TOLERANCE: f64 = 1e-9;

/// Measurement of a constraint dragged to and fro.
#[derive(Clone, Debug, PartialEq)]
pub struct Drag {
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Number of targets.
    pub targets: usize,
    /// Median time from sending a target to receiving its frame, s.
    pub seconds: f64,
    /// Longest such time, s.
    pub slowest: f64,
    /// Targets per second; each is sent after the frame of the previous one.
    pub per_second: f64,
    /// Number of frames that did not converge.
    pub failures: usize,
}

/// A cable of 1 m between two connectors, with this number of segments; one end is dragged.
///
/// # Errors
/// A message on failure.
pub fn cable(segments: usize) -> Result<Drag, String> {
    let mut text = String::from("schema = 1\nname = \"cable\"\n");
    text += "sections.cable = { diameter = 0.006, linear_density = 0.05, axial_stiffness = 1e4, \
             bending_stiffness = 0.01, torsion_stiffness = 0.008 }\n";
    let branch = format!("from = \"A\", to = \"B\", section = \"cable\", length = 1.0, segments = {segments}");
    let _ = writeln!(text, "branches = [{{ name = \"cable\", {branch} }}]\nconstraints = [");
    for (end, x) in [("A", 0.0), ("B", 0.6)] {
        let at = format!("at = {{ end = \"{end}\" }}, position = [{x}, 0, 0], tangent = [1, 0, 0], up = [0, 0, 1]");
        let _ = writeln!(text, "  {{ name = \"plug-{end}\", kind = \"connector\", {at} }},");
    }
    drag(&(text + "]\n"))
}

/// A harness from a KBL file as installed; the connector at the end of its longest branch is dragged.
///
/// # Errors
/// A message about the file or on failure.
pub fn harness(kbl: &str) -> Result<Drag, String> {
    let options = Options { arrangement: Arrangement::Installed, max_segment: SPACING, ..Options::default() };
    drag(&import(kbl, &options).map_err(|error| error.to_string())?.scenario)
}

/// A backend without storage.
struct NoBackend;

impl Backend for NoBackend {
    fn keep(&self, _: Option<&str>) {}
    fn discard(&self, _: &str) {}
    fn open(&self, _: &str) -> Result<Studio, String> {
        Err("no draft is stored".to_owned())
    }

    fn store_beside(&self, _: &str, _: &[u8]) -> Result<String, Refusal> {
        Err(Refusal::new("no file is stored", ""))
    }

    fn changed_outside(&self) -> Option<String> {
        None
    }

    fn export(&self, _: &Studio, _: &str) -> Option<Vec<u8>> {
        None
    }
}

/// Drags the connector at the end of the longest branch of a scenario towards its cable and back.
fn drag(text: &str) -> Result<Drag, String> {
    let opened = SessionInput {
        text: text.to_owned(),
        name: "bench.toml".to_owned(),
        files: Arc::new(NoFiles),
        registry: wireloom::registry(),
        unsaved: false,
        storage: None,
    };
    let studio = open(opened).map_err(|faults| render(text, &faults))?;
    let token = Token::random()?;
    let listener = TcpListener::bind("127.0.0.1:0").map_err(|error| error.to_string())?;
    let content = Content::Live(Live::new(studio, Vec::new(), Box::new(NoBackend)));
    let site = Site { page: String::new(), content, envelope: None };
    let server = Server::start(listener, "127.0.0.1", token.clone(), site).map_err(|error| error.to_string())?;
    let address = format!("ws://{}/socket?token={}", server.address(), token.digits());
    let measured = connect(&address).map_err(|error| error.to_string()).and_then(|mut page| page.drag());
    // Tasks that still run end with the process.
    let _ = server.stop();
    measured
}

fn connect(address: &str) -> tungstenite::Result<Client> {
    let (socket, _) = tungstenite::connect(address)?;
    if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
        stream.set_nodelay(true)?;
    }
    Ok(Client { socket, scene: None })
}

/// The client.
struct Client {
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    scene: Option<Scene>,
}

impl Client {
    fn send(&mut self, request: &Request) -> Result<(), String> {
        let text = serde_json::to_string(request).map_err(|error| error.to_string())?;
        self.socket.send(Message::Text(text.into())).map_err(|error| error.to_string())
    }

    /// The next message; scenes are stored.
    fn receive(&mut self) -> Result<Received, String> {
        loop {
            match self.socket.read().map_err(|error| error.to_string())? {
                Message::Binary(bytes) => return Ok(Received::Frame(bytes.to_vec())),
                Message::Text(text) => match serde_json::from_str(&text).map_err(|error| error.to_string())? {
                    Notice::Scene(scene) => self.scene = Some(scene),
                    Notice::Session(session) => return Ok(Received::Session { busy: session.busy.is_some() }),
                    Notice::Refused { message, help } => return Err(format!("{message}: {help}")),
                    _ => {}
                },
                _ => {}
            }
        }
    }

    fn drag(&mut self) -> Result<Drag, String> {
        // The start and the steps of the scenario; the last message is a frame, or that nothing is computed any more.
        let (mut last, mut rests) = (None, false);
        while !rests || last.is_none() {
            match self.receive()? {
                Received::Frame(bytes) => last = Some(frame::header(&bytes).ok_or("invalid frame")?),
                Received::Session { busy } => rests = !busy,
            }
        }
        let header = last.ok_or("no frame")?;
        let scene = self.scene.clone().ok_or("no scene")?;
        let constraint = longest_branch_connector(&scene).ok_or("the harness has no connector")?.clone();
        let at = header.constraints.iter().find(|other| other.name == constraint.name).ok_or("it is not active")?.at;
        let [w, i, j, k] = at.orientation;
        let d3 = Rotation::new_unchecked([i, j, k, w].into()) * Vector::z();
        let from_end = constraint.place.as_ref().is_none_or(|(_, s)| *s > 0.0);
        let inward = if from_end { -d3 } else { d3 };
        let start = Vector::from(at.position);
        let out = 1..=TARGETS_PER_STROKE;
        let stroke: Vec<usize> = out.chain((0..TARGETS_PER_STROKE).rev()).collect();
        let (mut times, mut failures) = (Vec::new(), 0);
        let clock = Instant::now();
        for step in std::iter::repeat_n(stroke, STROKES).flatten() {
            let target = start + inward * (TARGET_SPACING * step as f64);
            let own = Instant::now();
            failures += usize::from(!self.drag_to(&constraint.name, target)?);
            times.push(own.elapsed().as_secs_f64());
        }
        let seconds = clock.elapsed().as_secs_f64();
        times.sort_by(f64::total_cmp);
        Ok(Drag {
            nodes: scene.branches.iter().map(|branch| branch.nodes as usize).sum(),
            targets: times.len(),
            seconds: times[times.len() / 2],
            slowest: times[times.len() - 1],
            per_second: times.len() as f64 / seconds,
            failures,
        })
    }

    /// Moves a constraint and waits for its frame; returns whether that frame converged.
    fn drag_to(&mut self, constraint: &str, target: Vector) -> Result<bool, String> {
        self.send(&Request::Target {
            constraint: constraint.to_owned(),
            position: Some(target.into()),
            orientation: None,
        })?;
        loop {
            let Received::Frame(bytes) = self.receive()? else { continue };
            let header = frame::header(&bytes).ok_or("invalid frame")?;
            let at =
                header.constraints.iter().find(|other| other.name == constraint).ok_or("it is no longer active")?.at;
            if (Vector::from(at.position) - target).norm() < POSITION_TOLERANCE {
                return Ok(header.status == "converged");
            }
        }
    }
}

/// Messages that the benchmark uses.
enum Received {
    Frame(Vec<u8>),
    Session { busy: bool },
}

/// The connector at the end of the longest branch that has one.
fn longest_branch_connector(scene: &Scene) -> Option<&Constraint> {
    let length = |constraint: &Constraint| {
        let branch = &constraint.place.as_ref()?.0;
        scene.branches.iter().find(|other| other.name == *branch).map(|branch| branch.length)
    };
    let connectors = scene.constraints.iter().filter(|constraint| constraint.kind == "connector" && constraint.moves);
    connectors
        .filter_map(|constraint| Some((length(constraint)?, constraint)))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, f)| f)
}
