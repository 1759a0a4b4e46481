//! `wireloom studio` and `run --page`, as the program.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use wireloom_tests::{program, root};

/// A studio that runs, and the address it printed.
struct Studio {
    child: Child,
    address: String,
}

impl Studio {
    fn of(what: &Path, state: &Path) -> Self {
        Self::by(Command::new(program()).args(["studio", "--no-open"]).arg(what).env("XDG_STATE_HOME", state))
    }

    fn by(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
        let mut lines = BufReader::new(child.stdout.take().expect("piped")).lines();
        let address = lines.find_map(|line| line.ok().filter(|line| line.starts_with("http://"))).expect("an address");
        // Later output would break a closed pipe.
        std::thread::spawn(move || lines.for_each(drop));
        Self { child, address }
    }

    /// Answer to a request for a path.
    fn get(&self, path: &str) -> String {
        Self::get_by(&self.address, path)
    }

    fn get_by(address: &str, path: &str) -> String {
        let (host, query) = address["http://".len()..].split_once("/?").expect("a query");
        let mut stream = TcpStream::connect(host).expect("it listens");
        let request = format!("GET {path}?{query} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).expect("taken");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// Ctrl-C; its exit code.
    fn end(mut self) -> Option<i32> {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().is_ok_and(|status| status.success()));
        self.child.wait().expect("it ends").code()
    }
}

fn scenario() -> std::path::PathBuf {
    root().join("scenarios/first.toml")
}

#[test]
fn a_studio_comes_back_where_it_was_with_another_token_and_ends_with_ctrl_c() {
    let state = tempfile::tempdir().expect("a folder");
    let studio = Studio::of(&scenario(), state.path());
    assert!(studio.address.starts_with("http://127.0.0.1:") && studio.address.contains("/?token="));
    let page = studio.get("/");
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("id=\"replay\">null</script>"));
    assert!(studio.get("/export/..%2f..%2fCargo.toml").starts_with("HTTP/1.1 404"));
    let address = studio.address.clone();
    assert_eq!(studio.end(), Some(0));
    let again = Studio::of(&scenario(), state.path());
    let port = |address: &str| address.split("/?").next().map(str::to_owned);
    assert_eq!(port(&again.address), port(&address), "pages that are still open learn that there is another session");
    assert_ne!(again.address, address, "the token is a new one");
    assert!(Studio::get_by(&address, "/").starts_with("HTTP/1.1 403"), "the old one opens nothing");
    // A second one of the same scenario at the same time has an address of its own.
    let beside = Studio::of(&scenario(), state.path());
    assert_ne!(port(&beside.address), port(&address));
    assert_eq!((beside.end(), again.end()), (Some(0), Some(0)));
}

/// Command lines of programs can be seen by every user of a machine: what opens the browser is given a file instead,
/// that only its user can read.
#[cfg(target_os = "linux")]
#[test]
fn the_token_stands_in_no_command_line() {
    use std::os::unix::fs::PermissionsExt;
    let place = tempfile::tempdir().expect("a folder");
    let (opener, seen) = (place.path().join("xdg-open"), place.path().join("seen"));
    std::fs::write(&opener, format!("#!/bin/sh\necho \"$@\" > '{0}.new' && mv '{0}.new' '{0}'\n", seen.display()))
        .expect("written");
    std::fs::set_permissions(&opener, std::fs::Permissions::from_mode(0o755)).expect("allowed");
    let path = std::env::var("PATH").expect("a path");
    let studio = Studio::by(
        Command::new(program())
            .arg("studio")
            .arg(scenario())
            .env("PATH", format!("{}:{path}", place.path().display()))
            .env("XDG_STATE_HOME", place.path()),
    );
    let began = std::time::Instant::now();
    while !seen.exists() {
        assert!(began.elapsed().as_secs() < 60, "nothing was opened");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let said = std::fs::read_to_string(&seen).expect("readable");
    let (_, token) = studio.address.split_once("token=").expect("a token");
    assert!(!said.contains(token) && !said.contains("http"), "{said}");
    let file = Path::new(said.trim_end());
    let mode = |path: &Path| path.metadata().expect("there").permissions().mode() & 0o777;
    assert_eq!((mode(file), mode(file.parent().expect("a folder"))), (0o600, 0o700));
    let page = std::fs::read_to_string(file).expect("readable");
    assert!(page.contains(&format!("url={}\"", studio.address)), "{page}");
    assert_eq!(studio.end(), Some(0));
    assert!(!file.exists(), "it goes with the session");
}

#[test]
fn a_finished_run_is_a_page_from_its_folder_and_as_a_file() {
    let place = tempfile::tempdir().expect("a folder");
    let (out, file) = (place.path().join("out"), place.path().join("page.html"));
    let ran = Command::new(program())
        .arg("run")
        .arg(scenario())
        .arg("--out")
        .arg(&out)
        .arg("--page")
        .arg(&file)
        .output()
        .expect("it runs");
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    assert!(String::from_utf8_lossy(&ran.stdout).contains("page.html"));
    let page = std::fs::read_to_string(&file).expect("written");
    assert!(!page.contains("id=\"replay\">null") && page.contains("id=\"replay\">\"H4sI"), "gzip in base64");
    let studio = Studio::of(&out, place.path());
    let served = studio.get("/");
    assert!(served.contains("id=\"replay\">\"H4sI"));
    assert!(studio.get("/export/result.json").contains("\"schema\":1"));
    assert!(studio.get("/export/.wireloom/scene").starts_with("HTTP/1.1 404"));
    assert!(studio.get("/socket").starts_with("HTTP/1.1 4"), "there is no session behind it");
    assert_eq!(studio.end(), Some(0));
}

/// The start page opens any file of its user.
#[test]
fn the_start_page_is_for_this_machine_alone() {
    let place = tempfile::tempdir().expect("a folder");
    let start = |more: &[&str]| {
        let mut command = Command::new(program());
        command.args(["studio", "--no-open"]).args(more).current_dir(place.path()).env("XDG_STATE_HOME", place.path());
        command
    };
    let studio = Studio::by(&mut start(&[]));
    let page = studio.get("/");
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("id=\"replay\">null</script>"));
    assert!(studio.get("/export/result.json").starts_with("HTTP/1.1 404"), "there is no session yet");
    assert_eq!(studio.end(), Some(0));
    for (more, why) in [(&["--host", "0.0.0.0"][..], "give a FILE or DIR"), (&["--envelope", "."], "FILE|DIR")] {
        let out = start(more).output().expect("it ends");
        let words = String::from_utf8_lossy(&out.stderr);
        assert!(!out.status.success() && words.contains(why), "{more:?}: {words}");
    }
}

#[test]
fn what_cannot_be_shown_is_refused_in_words() {
    let place = tempfile::tempdir().expect("a folder");
    let refused = |what: &Path| {
        let out = Command::new(program())
            .args(["studio", "--no-open"])
            .arg(what)
            .env("XDG_STATE_HOME", place.path())
            .output()
            .expect("it runs");
        (out.status.code(), String::from_utf8_lossy(&out.stderr).into_owned())
    };
    let (code, words) = refused(&place.path().join("nothing.toml"));
    assert!(code == Some(3) && words.contains("nothing.toml"), "{words}");
    let bad = place.path().join("bad.toml");
    std::fs::write(&bad, "schema = 1\nname = 7\n").expect("written");
    let (code, words) = refused(&bad);
    assert!(code == Some(1) && words.contains("bad.toml:2:"), "{words}");
    std::fs::write(place.path().join("result.json"), "{}").expect("written");
    let (code, words) = refused(place.path());
    assert!(code == Some(1) && words.contains("no result of this version"), "{words}");
}
