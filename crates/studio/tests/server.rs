//! Admission, messages between tabs, drafts, exports and shutdown.

mod common;

use common::{MemoryBackend, Served, TEXT, Tab};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use wireloom_studio::protocol::{Contents, Holding, ImportFile, NotOpened, Notice, Opening, Request, StartPage};
use wireloom_studio::server::{Content, Live, Server, Site, Start, Starter, Token, not_opened};

fn served() -> Served {
    Served::new(MemoryBackend::default())
}

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or_default()
}

#[test]
fn only_who_knows_the_token_is_let_in() {
    let served = served();
    let own = format!("/?{}", served.query());
    let answer = served.get_own(&own);
    assert_eq!(status(&answer), "200", "{answer}");
    assert!(answer.ends_with("<html>page</html>"));
    let lower = answer.to_lowercase();
    for header in [
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "cache-control: no-store",
        "content-security-policy: frame-ancestors 'none'",
    ] {
        assert!(lower.contains(header), "{header} in {answer}");
    }
    let short = &own[..own.len() - 1];
    for path in ["/", "/?token=", "/?token=0", short, "/socket", "/export/result.json", "/nothing"] {
        let answer = served.get_own(path);
        assert_eq!(status(&answer), "403", "{path}");
        assert!(!answer.contains(&served.token));
    }
    // A name that was made to resolve to this machine, and a page of another site.
    assert_eq!(status(&served.get(&own, &["Host: evil.example:80"])), "403");
    assert_eq!(status(&served.get(&own, &["Accept: */*"])), "403", "no name at all");
    let host = format!("Host: {}", served.address);
    assert_eq!(status(&served.get(&own, &[&host, "Origin: http://evil.example"])), "403");
    assert_eq!(served.connect(&served.query(), Some("http://evil.example")).err(), Some(403));
    assert_eq!(served.connect(&served.query(), Some("null")).err(), Some(403));
    assert_eq!(served.connect("token=0", None).err(), Some(403));
    assert_eq!(served.connect("", None).err(), Some(403));
    assert!(served.connect(&served.query(), None).is_ok(), "a program of its own says no Origin");
    assert!(served.server.stop(), "nothing is left");
}

#[test]
fn files_with_surfaces_are_stored_and_what_is_none_is_refused_with_its_reason() {
    let served = served();
    let post = |name: &str, content: &str| {
        served.post_own(&format!("/surroundings/{name}?{}", served.query()), content.as_bytes())
    };
    let corners = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"].map(|corner| format!("v {corner}\n")).concat();
    let closed = format!("{corners}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    let stored = post("wedge.obj", &closed);
    assert_eq!(status(&stored), "200", "{stored}");
    assert!(stored.ends_with(&format!("{{\"file\":\"{}-wedge.obj\",\"open\":false}}", closed.len())), "{stored}");
    let sheet = post("a%20sheet.obj", &format!("{corners}f 1 3 2\n"));
    assert!(sheet.contains("a sheet.obj\",\"open\":true"), "{sheet}");
    for (name, content, says) in [
        ("wedge.png", "", "is of no known format"),
        ("wedge.stl", "solid", "cannot be read as STL"),
        ("wedge.glb", "glTF", "cannot be read as glTF"),
    ] {
        let refused = post(name, content);
        assert_eq!(status(&refused), "422", "{refused}");
        assert!(refused.contains(says), "{refused}");
    }
    let stranger = served.post_own("/surroundings/wedge.obj?token=0", closed.as_bytes());
    assert_eq!(status(&stranger), "403", "{stranger}");
    assert!(served.server.stop(), "nothing is left");
}

#[test]
fn exports_are_those_of_the_session_and_no_other_files() {
    let served = served();
    let mut tab = served.tab();
    let exports = tab.until(|notice| if let Notice::Scene(scene) = notice { Some(scene.exports) } else { None });
    tab.rest();
    for name in &exports {
        let answer = served.get_own(&format!("/export/{name}?{}", served.query()));
        assert_eq!(status(&answer), "200", "{name}");
        assert!(answer.contains("attachment; filename="), "{name}");
    }
    assert!(exports.contains(&"csv/cable.csv".to_owned()) && exports.contains(&"result.json".to_owned()));
    let elsewhere = [
        "../Cargo.toml",
        "..%2fCargo.toml",
        "%2e%2e/%2e%2e/etc/passwd",
        "/etc/passwd",
        "csv/../result.json",
        "csv/..%2f..%2fCargo.toml",
        "result.json%00.svg",
        "",
        "csv/",
    ];
    for name in elsewhere {
        let answer = served.get_own(&format!("/export/{name}?{}", served.query()));
        assert_eq!(status(&answer), "404", "{name}: {answer}");
    }
    assert!(served.server.stop(), "nothing is left");
}

#[test]
fn tabs_see_the_same_and_a_closed_one_frees_what_it_held() {
    let served = served();
    let (mut one, mut other) = (served.tab(), served.tab());
    one.rest();
    one.ask(&Request::Hold { branch: "cable".into(), s: 0.5, how: Holding::Handle });
    let held = |notice| match notice {
        Notice::Session(session) if !session.held.is_empty() => Some((session.held, session.you)),
        _ => None,
    };
    let (held_by_one, me) = one.until(held);
    assert_eq!(held_by_one[0].1, me);
    let (seen, you) = other.until(held);
    assert_eq!(seen, held_by_one);
    assert_ne!(me, you);
    // A constraint held by one tab cannot be moved by another.
    let constraint = held_by_one[0].0.clone();
    other.ask(&Request::Target { constraint, position: Some([0.3, 0.0, 0.0]), orientation: None });
    other.until(|notice| matches!(notice, Notice::Refused { .. }).then_some(()));
    drop(one);
    other.until(|notice| match notice {
        Notice::Session(session) if session.held.is_empty() && session.tabs == 1 => Some(()),
        _ => None,
    });
    assert!(served.server.stop(), "nothing is left");
}

/// Drags a plug, and waits until the text has it.
fn drag(tab: &mut Tab) {
    tab.ask(&Request::Target { constraint: "plug-B".into(), position: Some([0.62, 0.0, 0.0]), orientation: None });
    tab.ask(&Request::Drop { constraint: "plug-B".into() });
    tab.until(|notice| match notice {
        // A drag in progress is not part of a step yet.
        Notice::Session(session) if session.unsaved && session.busy.is_none() && session.held.is_empty() => Some(()),
        _ => None,
    });
}

#[test]
fn pages_are_told_of_the_end_and_the_draft_is_kept() {
    let backend = MemoryBackend::default();
    let served = Served::new(backend.clone());
    let (mut tab, mut other) = (served.tab(), served.tab());
    tab.rest();
    drag(&mut tab);
    // A client that never sends and does not read.
    let _mute = TcpStream::connect(served.address).expect("it listens");
    assert!(served.server.stop(), "nothing is left");
    assert_eq!((tab.end(), other.end()), (1001, 1001));
    let draft = backend.0.lock().expect("not poisoned").clone().expect("a draft");
    assert!(draft.contains("[[steps]]") && wireloom::load(&draft, &wireloom::registry()).is_ok(), "{draft}");
}

/// Number and time of the drafts that are offered.
fn drafts(notice: Notice) -> Option<Vec<u32>> {
    let Notice::Drafts { drafts } = notice else { return None };
    Some(drafts.iter().map(|draft| draft.number).collect())
}

#[test]
fn drafts_are_offered_and_each_is_taken_up_or_discarded() {
    let backend = MemoryBackend::default();
    let text = TEXT.replace("1 m", "1.25 m");
    let earlier = || backend.1.lock().expect("not poisoned").clone();
    *backend.1.lock().expect("not poisoned") = vec!["schema = ".into(), text.clone(), "third".into()];
    let served = Served::new(backend.clone());
    let mut tab = served.tab();
    assert_eq!(tab.until(drafts), [0, 1, 2]);
    tab.ask(&Request::Draft { number: 0, take: true });
    tab.until(|notice| matches!(notice, Notice::Refused { .. }).then_some(()));
    tab.ask(&Request::Draft { number: 0, take: false });
    assert_eq!(tab.until(drafts), [1, 2]);
    assert_eq!(earlier(), [text.clone(), "third".to_owned()]);
    tab.ask(&Request::Draft { number: 1, take: true });
    let length = tab.until(|notice| match notice {
        Notice::Scene(scene) if (scene.branches[0].length - 1.0).abs() > 1e-9 => Some(scene.branches[0].length),
        _ => None,
    });
    assert!((length - 1.25).abs() < 1e-9);
    // That is the session for other tabs too, and for later ones.
    tab.ask(&Request::Draft { number: 1, take: false });
    tab.until(|notice| matches!(notice, Notice::Refused { .. }).then_some(()));
    assert!(served.server.stop(), "nothing is left");
    assert_eq!(*backend.0.lock().expect("not poisoned"), Some(text), "it is that of this session now");
    assert_eq!(earlier(), ["third"]);
}

/// Until somebody had answered the offered draft, that of the session was not kept.
#[test]
fn a_session_keeps_its_draft_beside_those_that_nobody_has_answered() {
    let backend = MemoryBackend::default();
    *backend.1.lock().expect("not poisoned") = vec![TEXT.replace("1 m", "1.25 m")];
    let served = Served::new(backend.clone());
    let mut tab = served.tab();
    tab.rest();
    drag(&mut tab);
    // It replaces no changes.
    tab.ask(&Request::Draft { number: 0, take: true });
    let why = tab.until(|notice| if let Notice::Refused { message, .. } = notice { Some(message) } else { None });
    assert!(why.contains("unsaved changes"), "{why}");
    assert!(served.server.stop(), "nothing is left");
    let kept = backend.0.lock().expect("not poisoned").clone();
    assert!(kept.is_some_and(|draft| draft.contains("[[steps]]")));
    assert_eq!(backend.1.lock().expect("not poisoned").len(), 1, "and that stays");
}

#[test]
fn more_connections_than_places_are_sent_away_and_places_come_back() {
    let served = served();
    let mut tabs: Vec<_> = (0..64).map(|_| served.tab()).collect();
    assert_eq!(served.server.connections(), 64);
    assert!(served.connect(&served.query(), None).is_err());
    tabs.truncate(63);
    while served.server.connections() > 63 {
        std::thread::yield_now();
    }
    assert!(served.connect(&served.query(), None).is_ok());
    drop(tabs);
    assert!(served.server.stop(), "nothing is left");
}

/// Unauthenticated connections, however many, do not block authenticated ones. They are closed after a few seconds,
/// whether they send nothing, an incomplete request, or wrong ones repeatedly.
#[test]
fn idle_connections_without_the_token_keep_nobody_out() {
    let served = served();
    let stranger = |words: &str| {
        let mut stream = TcpStream::connect(served.address).expect("it listens");
        stream.write_all(words.as_bytes()).expect("taken");
        stream
    };
    let mut unauthenticated: Vec<TcpStream> = (0..100).map(|_| stranger("")).collect();
    unauthenticated.extend((0..100).map(|_| stranger("GET /?token=")));
    unauthenticated.extend((0..100).map(|_| stranger("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")));
    let began = Instant::now();
    let mut tabs: Vec<_> = (0..64).map(|_| served.tab()).collect();
    assert_eq!(served.server.connections(), 64);
    assert_eq!(status(&served.get_own("/")), "403", "strangers are still answered");
    for mut stream in unauthenticated {
        stream.set_read_timeout(Some(Duration::from_secs(30))).expect("a time");
        let mut answer = Vec::new();
        // A reset is as good as an orderly end; only a timeout is an error.
        if let Err(error) = stream.read_to_end(&mut answer) {
            assert_eq!(error.kind(), std::io::ErrorKind::ConnectionReset, "still there after {:?}", began.elapsed());
        }
    }
    // A silent page stays connected.
    tabs[0].ask(&Request::Save);
    tabs[0].until(|notice| matches!(notice, Notice::Saved { .. }).then_some(()));
    assert!(served.server.stop(), "nothing is left");
}

/// A server that ends does not leave its solver running, which may be within a driver that the process then unloads.
#[test]
fn a_server_that_ends_within_an_increment_leaves_no_thread_behind() {
    let endless = format!("{TEXT}\n[minimiser]\nkind = \"ncg\"\npreconditioner = \"none\"\nmax_iterations = 1000000\n");
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let token = Token::random().expect("random numbers");
    let studio = common::session(&endless.replace("segments = 40", "segments = 1000"), false).expect("no faults");
    let live = Live::new(studio, vec![], Box::new(MemoryBackend::default()));
    let site = Site { page: String::new(), content: Content::Live(live), envelope: None };
    let server = Server::start(listener, "127.0.0.1", token, site).expect("started");
    std::thread::sleep(Duration::from_millis(300));
    assert!(server.stop(), "the solver has ended");
}

#[test]
fn every_target_of_a_hand_has_its_picture() {
    let drag = wireloom_studio::bench::cable(100).expect("dragged");
    assert_eq!((drag.nodes, drag.targets, drag.failures), (101, 80, 0));
}

/// Opens the example "cable" alone, and counts that.
#[derive(Clone, Default)]
struct OneExample(Arc<Mutex<usize>>);

impl Starter for OneExample {
    fn page(&self) -> StartPage {
        let (recent, examples) = (Vec::new(), Vec::new());
        StartPage {
            program: "wireloom".into(),
            folder: "/".into(),
            recent,
            examples,
            drafts: vec![],
            largest_import: 1,
        }
    }

    fn contents(&self, _: &ImportFile) -> Result<Contents, NotOpened> {
        Ok(Contents { name: "h.kbl".into(), modules: Vec::new(), variants: Vec::new() })
    }

    fn open(&self, what: Opening) -> Result<Site, NotOpened> {
        if what != (Opening::Example { name: "cable".into() }) {
            return Err(not_opened("there is no such example", "", "", &[]));
        }
        *self.0.lock().expect("not poisoned") += 1;
        let live = Live::new(common::session(TEXT, false).expect("no faults"), vec![], Box::<MemoryBackend>::default());
        Ok(Site { page: "<html>page</html>".into(), content: Content::Live(live), envelope: None })
    }

    fn restore(&self, _: u32) -> Result<Site, NotOpened> {
        Err(not_opened("there is no draft", "", "", &[]))
    }

    fn discard(&self, _: u32) {}
}

fn start_page(starter: &OneExample) -> Served {
    let content = Content::Start(Start::new(Box::new(starter.clone())));
    Served::of(Site { page: "<html>page</html>".into(), content, envelope: None })
}

fn example(name: &str) -> Request {
    Request::Open { what: Opening::Example { name: name.into() } }
}

#[test]
fn one_page_opens_a_session_and_all_pages_are_in_it() {
    let starter = OneExample::default();
    let served = start_page(&starter);
    let (mut one, mut other) = (served.tab(), served.tab());
    for tab in [&mut one, &mut other] {
        tab.until(|notice| matches!(notice, Notice::StartPage(_)).then_some(()));
    }
    let file = ImportFile::Path { path: "h.kbl".into() };
    one.ask(&Request::Contents { file });
    one.until(|notice| matches!(notice, Notice::Contents(_)).then_some(()));
    one.ask(&example("none"));
    let why = one.until(|notice| if let Notice::NotOpened(why) = notice { Some(why.message) } else { None });
    assert_eq!(why, "there is no such example");
    one.ask(&Request::Undo);
    let why = one.until(|notice| if let Notice::Refused { message, .. } = notice { Some(message) } else { None });
    assert_eq!(why, "there is no session yet");
    assert_eq!(status(&served.get_own(&format!("/export/result.json?{}", served.query()))), "404");
    one.ask(&example("cable"));
    other.ask(&example("cable"));
    one.rest();
    other.rest();
    let mut late = served.tab();
    late.until(|notice| matches!(notice, Notice::Scene(_)).then_some(()));
    assert_eq!(*starter.0.lock().expect("not poisoned"), 1, "it is opened once");
    assert_eq!(status(&served.get_own(&format!("/export/result.json?{}", served.query()))), "200");
    assert!(served.server.stop(), "nothing is left");
}

/// A page without a session was read as fast as it sent.
#[test]
fn the_start_page_answers_no_faster_than_a_session() {
    let served = start_page(&OneExample::default());
    let mut tab = served.tab();
    tab.until(|notice| matches!(notice, Notice::StartPage(_)).then_some(()));
    let began = Instant::now();
    // 240 at once and 240 a second.
    for _ in 0..480 {
        tab.ask(&Request::Undo);
    }
    for _ in 0..480 {
        tab.until(|notice| matches!(notice, Notice::Refused { .. }).then_some(()));
    }
    assert!(began.elapsed() > Duration::from_millis(900), "{:?}", began.elapsed());
    assert!(served.server.stop(), "nothing is left");
}

/// Who is let into a session would have read any file of the machine.
#[test]
fn in_a_session_no_page_opens_files() {
    let (shared, begun) = (served(), start_page(&OneExample::default()));
    let mut first = begun.tab();
    first.ask(&example("cable"));
    first.rest();
    for served in [shared, begun] {
        let mut tab = served.tab();
        tab.rest();
        let path = || "/etc/passwd".to_owned();
        let requests = [
            Request::Open { what: Opening::Path { path: path() } },
            Request::Contents { file: ImportFile::Path { path: path() } },
        ];
        for request in requests {
            tab.ask(&request);
            let why = tab.until(|notice| match notice {
                Notice::Refused { message, .. } => Some(message),
                Notice::Contents(_) | Notice::NotOpened(_) => panic!("it was read"),
                _ => None,
            });
            assert_eq!(why, "a session opens no other scenario");
        }
        assert!(served.server.stop(), "nothing is left");
    }
}

#[test]
fn files_that_are_too_large_for_a_page_are_refused_in_words() {
    let served = start_page(&OneExample::default());
    let mut tab = served.tab();
    let text = "x".repeat((16 << 20) + 1);
    tab.ask(&Request::Contents { file: ImportFile::Text { name: "h.kbl".into(), text: text.clone() } });
    tab.ask(&Request::Open { what: Opening::Text { name: "h.toml".into(), text } });
    for most in ["16777216", "4194304"] {
        let why = tab.until(|notice| if let Notice::NotOpened(why) = notice { Some(why) } else { None });
        assert!(why.message.contains(most) && why.help.contains("path"), "{why:?}");
    }
    assert!(served.server.stop(), "nothing is left");
}
