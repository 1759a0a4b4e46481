//! The solver thread and its queues: requests to it, with only the newest target of each constraint; messages from it,
//! with only the newest state for every tab.

mod broadcast;

use crate::protocol::{Notice, Request};
use crate::session::{Known, Session, SessionInput, text_faults};
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
use wireloom::Run;
use wireloom::harness::Obstacle;
use wireloom::result::Outcome as RunOutcome;
use wireloom::scenario::Fault;
use wireloom::session::{Monitor, Refusal};

/// Largest number of queued requests; a page has only a few in flight.
const MAX_QUEUED: usize = 256;
/// Largest number of queued texts, which may be long.
const MAX_TEXTS: usize = 4;

/// A harness in the studio. A thread of its own computes until the studio is closed or dropped.
pub struct Studio {
    shared: Arc<Shared>,
    known: Arc<Known>,
    /// Nothing is ever sent: the channel is closed when the thread has ended and dropped everything it owned.
    thread: Mutex<mpsc::Receiver<Infallible>>,
}

/// Messages for one tab.
pub struct Subscription {
    shared: Arc<Shared>,
    tab: u32,
}

/// The run so far, as `run` would return it.
pub struct Outcome {
    /// Results at the ends of steps, and of the newest increment.
    pub run: Run,
    /// Obstacles of the harness.
    pub obstacles: Arc<Vec<Obstacle>>,
}

/// A queued request.
enum Queued {
    Request(u32, Request),
    Detached(u32),
}

/// State shared by the thread and its clients.
struct Shared {
    queue: Mutex<VecDeque<Queued>>,
    /// Signals a change of the queue, or the end.
    queue_changed: Condvar,
    broadcast: Mutex<Broadcast>,
    /// Stops the current computation.
    monitor: Monitor,
    /// Whether the initial equilibrium is being computed.
    finding_start: AtomicBool,
    stop: AtomicBool,
    closed: AtomicBool,
}

/// Locks even after a panic: no critical section leaves its data half changed.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Reads a scenario and starts to carry it out on a thread of its own.
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
        // Declared first, so dropped last.
        let _ends = ends;
        let mut session = match Session::open(opened, own.monitor.clone()) {
            Ok(session) => session,
            Err(faults) => return told.send(Err(faults)).unwrap_or_default(),
        };
        own.publish(&mut session);
        if told.send(Ok(session.known())).is_ok() {
            own.work(&mut session);
        }
    };
    let broken = |message: String| {
        let help = "this is an error of the program, not of the scenario".to_owned();
        vec![Fault { span: text..text, message, help }]
    };
    let spawned = thread::Builder::new().name("studio".to_owned()).spawn(work);
    spawned.map_err(|error| broken(format!("no thread to work on: {error}")))?;
    let known = requested.recv().unwrap_or_else(|_| Err(broken("the scenario could not be read".to_owned())))?;
    Ok(Studio { shared, known, thread: Mutex::new(thread) })
}

impl Studio {
    /// Adds a tab; `wake` is called, from any thread, when there are messages.
    pub fn attach(&self, wake: Box<dyn Fn() + Send + Sync>) -> (u32, Subscription) {
        let tab = locked(&self.shared.broadcast).attach(wake);
        (tab, Subscription { shared: self.shared.clone(), tab })
    }

    /// Removes a tab and releases the constraints that it holds.
    pub fn detach(&self, tab: u32) {
        if locked(&self.shared.broadcast).detach(tab) {
            locked(&self.shared.queue).push_back(Queued::Detached(tab));
            self.shared.queue_changed.notify_all();
        }
    }

    /// Queues a request of a tab. Only the newest target of a constraint is kept.
    pub fn submit(&self, tab: u32, request: Request) {
        if let Request::Frames { from, to } = request {
            return locked(&self.shared.broadcast).send_frames(tab, from, to);
        }
        let mut queue = locked(&self.shared.queue);
        match &request {
            Request::Stop => self.shared.stop(),
            // These requests restart the run. Edits wait: one that is refused must leave the run as it is.
            Request::Set { .. } | Request::Undo | Request::Redo
                if self.shared.finding_start.load(Ordering::Relaxed) =>
            {
                self.shared.monitor.stop();
            }
            _ => {}
        }
        let text = |queued: &Queued| matches!(queued, Queued::Request(_, Request::Apply { .. }));
        let crowded =
            matches!(request, Request::Apply { .. }) && queue.iter().filter(|own| text(own)).count() >= MAX_TEXTS;
        if queue.len() >= MAX_QUEUED || crowded {
            drop(queue);
            let message = "too many requests are waiting".to_owned();
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

    /// Checks a text, on the thread of the caller.
    pub(crate) fn check(&self, text: &str, number: u32) -> Notice {
        Notice::Checked { number: Some(number), faults: text_faults(text, &self.known.check(text)) }
    }

    /// Whether the surface in a file has borders, on the thread of the caller.
    ///
    /// # Errors
    /// Why it can be no obstacle.
    pub(crate) fn has_borders(&self, name: &str, bytes: Vec<u8>) -> Result<bool, Refusal> {
        self.known.has_borders(name, bytes)
    }

    /// Sends a notice to every tab.
    pub(crate) fn tell(&self, notice: Notice) {
        locked(&self.shared.broadcast).notify(None, notice);
    }

    /// The scenario after the last completed step, if it has unsaved changes.
    pub fn draft(&self) -> Option<Arc<str>> {
        let broadcast = locked(&self.shared.broadcast);
        broadcast.text.clone().filter(|_| broadcast.unsaved)
    }

    /// The scenario after the last completed step.
    pub fn text(&self) -> Option<Arc<str>> {
        locked(&self.shared.broadcast).text.clone()
    }

    /// The run so far; `None` until the initial equilibrium is found.
    pub fn result(&self) -> Option<Outcome> {
        let record = locked(&self.shared.broadcast).record.clone()?;
        let run = Run {
            scenario: record.scenario,
            outcome: RunOutcome::Graded(record.status),
            notes: record.notes,
            events: record.events,
            steps: record.ends.iter().map(|end| (**end).clone()).collect(),
            clearances: Vec::new(),
            requirements: record.requirements.to_vec(),
            plugins: Vec::new(),
            identities: record.identities,
            drawn_start: None,
            sensitivities: Vec::new(),
        };
        Some(Outcome { run, obstacles: record.obstacles })
    }

    /// Stops the computation and ends the thread. Returns at once; the thread may still be running.
    pub fn close(&self) {
        self.shared.closed.store(true, Ordering::Relaxed);
        self.shared.stop();
        drop(locked(&self.shared.queue));
        self.shared.queue_changed.notify_all();
    }

    /// Waits for the thread to end, up to `timeout`. Returns whether it has ended.
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
    /// The next message; `None` if there is none.
    pub fn take(&self) -> Option<TabMessage> {
        locked(&self.shared.broadcast).take(self.tab)
    }
}

impl Shared {
    fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Relaxed)
    }

    /// Handles requests and computes in between, until the studio is closed.
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
                // If this panics too, the session stays unchanged.
                let _ = catch_unwind(AssertUnwindSafe(|| session.recover(message)));
            }
            self.publish(session);
        }
    }

    /// Stops computing until the queue has been handled.
    fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
        self.monitor.stop();
    }

    /// The next request; waits for one if there is nothing to compute.
    fn next(&self, session: &Session) -> Option<Queued> {
        let mut queue = locked(&self.queue);
        while !session.has_work() && queue.is_empty() && !self.is_closed() {
            queue = self.queue_changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
        // Under the lock, so that a request made now refers to a defined computation.
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
