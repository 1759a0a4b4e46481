//! The thread that solves, and what stands between it and those who ask: requests in, of which only the newest target of a constraint waits; news
//! out, of which every tab gets the newest.

mod broadcast;

use crate::protocol::{Notice, Request};
use crate::session::{Session, SessionInput};
use broadcast::Broadcast;
pub use broadcast::TabMessage;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;
use wireloom::core::obstacle::Obstacle;
use wireloom::core::{Monitor, Run};
use wireloom::scenario::Fault;

/// Requests that wait at most: a page has a handful on the way.
const MAX_QUEUED: usize = 256;

/// A harness in the studio: a thread of its own carries it, until it is closed or dropped.
pub struct Studio {
    shared: Arc<Shared>,
    /// Nothing is ever sent: it is cut off when the thread, and all that it had, has gone.
    thread: Mutex<mpsc::Receiver<Infallible>>,
}

/// What a tab is to be told; whoever has it asks it.
pub struct Subscription {
    shared: Arc<Shared>,
    tab: u32,
}

/// What `run` would have made of it so far.
pub struct Outcome {
    /// Ends of steps, and that of the newest increment.
    pub run: Run,
    /// Bodies about the harness.
    pub obstacles: Arc<Vec<Obstacle>>,
}

/// A request that waits.
enum Queued {
    Request(u32, Request),
    Detached(u32),
}

/// Between those who ask and the thread.
struct Shared {
    queue: Mutex<VecDeque<Queued>>,
    /// Something waits, or it is all over.
    queue_changed: Condvar,
    broadcast: Mutex<Broadcast>,
    /// Stops what is being computed.
    monitor: Monitor,
    /// Whether the start is being computed.
    finding_start: AtomicBool,
    stop: AtomicBool,
    closed: AtomicBool,
}

/// Nothing that is kept under a lock is left half done by a panic.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Reads a scenario and begins to carry it out, on a thread of its own.
///
/// # Errors
/// All faults of the text.
pub fn open(opened: SessionInput) -> Result<Studio, Vec<Fault>> {
    let shared = Arc::new(Shared {
        queue: Mutex::default(),
        queue_changed: Condvar::new(),
        broadcast: Mutex::new(Broadcast::new()),
        monitor: Monitor::default(),
        finding_start: AtomicBool::new(false),
        stop: AtomicBool::new(false),
        closed: AtomicBool::new(false),
    });
    let (told, requested) = mpsc::channel();
    let text = opened.text.len();
    let own = shared.clone();
    let (ends, thread) = mpsc::channel();
    let work = move || {
        // What is made later goes before it.
        let _ends = ends;
        let mut session = match Session::open(opened, own.monitor.clone()) {
            Ok(session) => session,
            Err(faults) => return told.send(Err(faults)).unwrap_or_default(),
        };
        own.publish(&mut session);
        if told.send(Ok(())).is_ok() {
            own.work(&mut session);
        }
    };
    let broken = |message: String| {
        let help = "this is a fault of the program, not of the scenario".to_owned();
        vec![Fault { span: text..text, message, help }]
    };
    let spawned = thread::Builder::new().name("studio".to_owned()).spawn(work);
    spawned.map_err(|error| broken(format!("no thread to work on: {error}")))?;
    requested.recv().unwrap_or_else(|_| Err(broken("the scenario could not be read".to_owned())))?;
    Ok(Studio { shared, thread: Mutex::new(thread) })
}

impl Studio {
    /// A tab more; `wake` is called, from any thread, when there is something to take.
    pub fn attach(&self, wake: Box<dyn Fn() + Send + Sync>) -> (u32, Subscription) {
        let tab = locked(&self.shared.broadcast).attach(wake);
        (tab, Subscription { shared: self.shared.clone(), tab })
    }

    /// A tab less: what it held may be taken by others.
    pub fn detach(&self, tab: u32) {
        if locked(&self.shared.broadcast).detach(tab) {
            locked(&self.shared.queue).push_back(Queued::Detached(tab));
            self.shared.queue_changed.notify_all();
        }
    }

    /// A tab asks for something. Of targets of a constraint only the newest waits.
    pub fn submit(&self, tab: u32, request: Request) {
        if let Request::Frames { from, to } = request {
            return locked(&self.shared.broadcast).send_frames(tab, from, to);
        }
        let mut queue = locked(&self.shared.queue);
        match &request {
            Request::Stop => self.shared.stop(),
            // They lead to another start.
            Request::Set { .. } | Request::Undo | Request::Redo
                if self.shared.finding_start.load(Ordering::Relaxed) =>
            {
                self.shared.monitor.stop();
            }
            _ => {}
        }
        if queue.len() >= MAX_QUEUED {
            drop(queue);
            let message = "too many requests wait already".to_owned();
            let refused = Notice::Refused { message, help: "wait until some are done".to_owned() };
            return locked(&self.shared.broadcast).notify(Some(tab), refused);
        }
        if let Request::Target { constraint, .. } = &request {
            let targets = queue.iter_mut().rev().map_while(|queue| match queue {
                Queued::Request(by, Request::Target { constraint, .. }) => Some((*by, constraint.clone())),
                _ => None,
            });
            let behind = targets.enumerate().find(|(_, before)| *before == (tab, constraint.clone())).map(|(k, _)| k);
            if let Some(behind) = behind {
                let place = queue.len() - 1 - behind;
                queue.remove(place);
            }
        }
        queue.push_back(Queued::Request(tab, request));
        self.shared.queue_changed.notify_all();
    }

    /// The scenario as it was when a step ended last, where it has not been saved.
    pub fn draft(&self) -> Option<Arc<str>> {
        let broadcast = locked(&self.shared.broadcast);
        broadcast.text.clone().filter(|_| broadcast.unsaved)
    }

    /// The scenario as it was when a step ended last, saved or not.
    pub fn text(&self) -> Option<Arc<str>> {
        locked(&self.shared.broadcast).text.clone()
    }

    /// The run so far; `None` while the start is being found.
    pub fn result(&self) -> Option<Outcome> {
        let record = locked(&self.shared.broadcast).record.clone()?;
        let run = Run {
            scenario: record.scenario,
            status: record.status,
            notes: record.notes,
            events: record.events,
            steps: record.ends.iter().map(|end| (**end).clone()).collect(),
            clearances: Vec::new(),
            fault: None,
            plugins: Vec::new(),
        };
        Some(Outcome { run, obstacles: record.obstacles })
    }

    /// Ends the thread and stops what it computes; it need not have ended when this returns.
    pub fn close(&self) {
        self.shared.closed.store(true, Ordering::Relaxed);
        self.shared.stop();
        drop(locked(&self.shared.queue));
        self.shared.queue_changed.notify_all();
    }

    /// Waits until the thread has come to its end, but no longer than that. Returns whether it has.
    pub fn has_ended(&self, timeout: Duration) -> bool {
        locked(&self.thread).recv_timeout(timeout) == Err(mpsc::RecvTimeoutError::Disconnected)
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        self.close();
    }
}

impl Subscription {
    /// What comes next; `None`: nothing yet.
    pub fn take(&self) -> Option<TabMessage> {
        locked(&self.shared.broadcast).take(self.tab)
    }
}

impl Shared {
    fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Relaxed)
    }

    /// Does what is asked for, and computes in between, until it is closed.
    fn work(&self, session: &mut Session) {
        while !self.is_closed() {
            let next = if session.must_finish() && session.has_work() { None } else { self.next(session) };
            let done = catch_unwind(AssertUnwindSafe(|| match next {
                Some(Queued::Request(tab, request)) => session.handle(tab, request),
                Some(Queued::Detached(tab)) => session.detach(tab),
                None => session.work(),
            }));
            if self.stop.swap(false, Ordering::Relaxed) {
                session.stop();
            }
            if let Err(panic) = done {
                let message = panic.downcast_ref::<String>().map(String::as_str);
                let message = message.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic");
                // If that panics too, the session stands as it did.
                let _ = catch_unwind(AssertUnwindSafe(|| session.recover(message)));
            }
            self.publish(session);
        }
    }

    /// Nothing more is computed until what waits has been looked at.
    fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
        self.monitor.stop();
    }

    /// The next request; waits for one where there is nothing to be computed.
    fn next(&self, session: &Session) -> Option<Queued> {
        let mut queue = locked(&self.queue);
        while !session.has_work() && queue.is_empty() && !self.is_closed() {
            queue = self.queue_changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
        // Under the lock, so that whoever asks for something now knows what he stops.
        if !self.stop.load(Ordering::Relaxed) {
            self.monitor.go_on();
        }
        self.finding_start.store(queue.is_empty() && session.is_finding_start(), Ordering::Relaxed);
        queue.pop_front()
    }

    fn publish(&self, session: &mut Session) {
        let wakes = locked(&self.broadcast).publish(session);
        wakes.iter().for_each(|wake| wake());
    }
}
