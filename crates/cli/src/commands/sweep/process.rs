//! `wireloom sweep-process`: a process that computes chains of points for a sweep with plugins.

use super::job::Job;
use crate::arguments::ProcessArguments;
use crate::failure::{Failure, Outcome};
use crate::interrupt;
use crate::messages::{Computed, Message, Request};
use crate::plugin::crash;
use std::cell::RefCell;
use std::io::{self, BufRead, Write};
use std::sync::mpsc::{Receiver, channel};
use std::thread;

/// Computes the chains that standard input asks for, until it ends.
pub fn compute(arguments: &ProcessArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let job = Job::read(&arguments.file, arguments.minimiser.as_deref(), &arguments.allowed)?;
    crash::prepare_for_sweep(wireloom::scenario::plugins(&job.loaded.texts[0].1).time_limit);
    let points = job.points();
    let out = RefCell::new(out);
    let send = |message: Message| message.send(&mut *out.borrow_mut()).map_err(Failure::standard_output);
    send(Message::Ready(job.origin.hash()))?;
    for Request { chain, without } in requests()? {
        // Where a message cannot be sent, standard input has ended, too.
        let watched = |work| drop(send(Message::Work(work)));
        let Some(computed) = points.chain_without(chain, &without, interrupt::monitor(), &watched) else { break };
        send(Message::Chain(Computed::of(computed).encode().map_err(Failure::standard_output)?))?;
    }
    Ok(Outcome::Done)
}

/// The requests of standard input. As it ends, because the sweep is over or was killed, this process ends at once.
fn requests() -> Result<Receiver<Request>, Failure> {
    let (sender, receiver) = channel();
    let read = move || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            let Ok(request) = serde_json::from_str(&line) else { break };
            if sender.send(request).is_err() {
                break;
            }
        }
        interrupt::leave(0);
    };
    thread::Builder::new()
        .name("requests".to_owned())
        .spawn(read)
        .map_err(|source| Failure::Io { what: "cannot start a thread".to_owned(), source })?;
    Ok(receiver)
}
