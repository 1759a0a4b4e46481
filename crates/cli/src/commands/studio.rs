//! `wireloom studio`: a session in the browser, a finished run in it, or the page on which one of them is opened.

mod fence;
mod finished;
mod memory;
mod redirect;
mod session;
mod start;
mod storage;

use crate::arguments::StudioArguments;
use crate::failure::{Failure, Outcome};
use crate::files::envelope;
use crate::files::load;
use crate::interrupt;
use crate::print::diagnostics;
use crate::program::now;
use memory::{Memory, Remembered};
use redirect::Redirect;
use std::io::{self, Write};
use std::net::{IpAddr, TcpListener, ToSocketAddrs};
use std::path::{Path, PathBuf};
use wireloom_studio::PAGE;
use wireloom_studio::server::{Content, Server, Site, Token};

/// Serves the page until a signal to stop.
pub fn studio(arguments: &StudioArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let what = match &arguments.what {
        Some(what) => What::Named(what),
        None => What::StartPage(std::env::current_dir().map_err(Failure::system("find the present folder"))?),
    };
    let envelope = arguments.envelope.as_deref().map(envelope::read).transpose()?;
    let mut memory = remember(&what)?;
    let known = memory.as_ref().map(|memory| memory.remembered().clone()).unwrap_or_default();
    let (listener, token) = address(arguments, &known)?;
    let address = listener.local_addr().map_err(Failure::system("listen"))?;
    if matches!(what, What::StartPage(_)) && !address.ip().is_loopback() {
        return Err(Failure::Input(format!(
            "the start page opens files of this machine, so it is not served at {address}; give a FILE or DIR, or \
             leave out --host"
        )));
    }
    if let Some(memory) = &mut memory {
        let kept = memory.change(|known| (known.port, known.opened) = (Some(address.port()), Some(now())));
        kept.map_err(Failure::io("remember the address of", what.path()))?;
    }
    let site = match &what {
        What::StartPage(folder) => start::site(folder.clone(), &arguments.allowed, address.port(), memory),
        What::Named(path) if path.is_dir() => finished::finished(path, envelope)?,
        What::Named(path) => {
            let content = Content::Live(session::of_file(path, &arguments.allowed, memory)?);
            Site { page: PAGE.to_owned(), content, envelope }
        }
    };
    let server = Server::start(listener, &arguments.host, token.clone(), site).map_err(Failure::system("serve"))?;
    let host = if address.ip().is_unspecified() { "127.0.0.1".to_owned() } else { shown(address.ip()) };
    let page = format!("http://{host}:{}/?token={}", address.port(), token.digits());
    let say = |out: &mut dyn Write| {
        if !address.ip().is_loopback() {
            writeln!(
                out,
                "WARNING: this listens at {address}: anyone who can reach this machine and knows or overhears the \
                 token (nothing is encrypted) can use the session",
            )?;
        }
        writeln!(out, "{page}")?;
        writeln!(out, "Ctrl-C ends it")?;
        out.flush()
    };
    // From now on Ctrl-C ends the session.
    interrupt::listen();
    say(out).map_err(Failure::standard_output)?;
    let mut redirect = None;
    if !arguments.no_open {
        match Redirect::to(&page).and_then(|made| made.open().map(|()| made)) {
            // Browsers are slow: it stays until the session ends.
            Ok(made) => redirect = Some(made),
            Err(error) => writeln!(out, "no browser could be opened ({error}): open that address in one")
                .and_then(|()| out.flush())
                .map_err(Failure::standard_output)?,
        }
    }
    interrupt::wait();
    let ended = server.stop();
    drop(redirect);
    if !ended {
        out.flush().map_err(Failure::standard_output)?;
        interrupt::leave(0);
    }
    Ok(Outcome::Done)
}

/// An address as part of an URL.
fn shown(address: IpAddr) -> String {
    match address {
        IpAddr::V4(address) => address.to_string(),
        IpAddr::V6(address) => format!("[{address}]"),
    }
}

/// What the page shows first.
enum What<'a> {
    /// A scenario, or the folder of a finished run.
    Named(&'a Path),
    /// What can be opened, from the folder in which the program was started.
    StartPage(PathBuf),
}

impl What<'_> {
    fn path(&self) -> &Path {
        match self {
            What::Named(path) => path,
            What::StartPage(folder) => folder,
        }
    }
}

/// The state that is kept; none where another studio has it, or where it cannot be kept.
fn remember(what: &What) -> Result<Option<Memory>, Failure> {
    let path = match what {
        // Two start pages of one folder are no fault: the first one keeps the draft.
        What::StartPage(folder) => return Ok(Memory::of_start_page(folder).unwrap_or_default()),
        What::Named(path) => path,
    };
    // Nothing is kept of a file that does not exist.
    if !path.is_dir() {
        load::open(path)?;
    }
    let (memory, lack) = session::remember(path);
    if let Some(lack) = lack {
        diagnostics::show(&lack, &mut io::stderr());
    }
    Ok(memory)
}

/// The address, by default that of the last session, so that open pages notice the new one; and the token of pages.
fn address(arguments: &StudioArguments, known: &Remembered) -> Result<(TcpListener, Token), Failure> {
    let refused = |error: io::Error| {
        Failure::Input(format!("cannot listen at {}: {error}; give another --host or --port", arguments.host))
    };
    let bind = |port: u16| {
        let places = (arguments.host.as_str(), port).to_socket_addrs()?;
        TcpListener::bind(places.collect::<Vec<_>>().as_slice())
    };
    let wanted = arguments.port.or(known.port).unwrap_or(0);
    let listener = match bind(wanted) {
        Ok(listener) => listener,
        // Another program uses it.
        Err(_) if arguments.port.is_none() => bind(0).map_err(refused)?,
        Err(error) => return Err(refused(error)),
    };
    Ok((listener, Token::random().map_err(|error| Failure::Input(format!("there are no random numbers: {error}")))?))
}
