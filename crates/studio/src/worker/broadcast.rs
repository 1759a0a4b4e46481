//! Published state of a session, and the pending messages of every tab.

use crate::protocol::{self, Document, Notice, Scene, Sheet, Timeline};
use crate::session::{Changes, Frame, Record, Session};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Largest number of frames sent for one request; the page then asks again.
const MAX_FRAMES_PER_REQUEST: usize = 64;
/// Largest number of pending notices of a tab; the oldest are dropped.
const MAX_PENDING_NOTICES: usize = 32;
/// Averaging window of the frame rate.
const RATE_WINDOW: Duration = Duration::from_secs(1);

/// Called when there are messages.
type Wake = Arc<dyn Fn() + Send + Sync>;

/// A message for a tab.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one at a time is passed on, and none is kept")]
pub enum TabMessage {
    /// A notice as JSON.
    Notice(Notice),
    /// An encoded frame.
    Frame(Arc<[u8]>),
}

/// Published state of a session.
pub(super) struct Broadcast {
    scene: Option<Arc<Scene>>,
    timeline: Option<Arc<Timeline>>,
    sheet: Option<Arc<Sheet>>,
    document: Option<Arc<Document>>,
    busy: Option<String>,
    labels: [Option<String>; 2],
    held: Vec<(String, u32)>,
    pub unsaved: bool,
    frames: Vec<Option<Frame>>,
    /// Arrival times of frames within the last second.
    frame_times: VecDeque<Instant>,
    tabs: BTreeMap<u32, Tab>,
    last_tab: u32,
    pub text: Option<Arc<str>>,
    pub record: Option<Record>,
}

/// Pending messages of a tab.
struct Tab {
    wake: Wake,
    scene: bool,
    /// Frames from this number on are no longer valid.
    truncate_at: Option<usize>,
    timeline: bool,
    sheet: bool,
    document: bool,
    session: bool,
    notices: VecDeque<Notice>,
    /// Whether to send the newest frame.
    live: bool,
    /// Numbers of requested frames.
    requested: VecDeque<usize>,
}

impl Tab {
    fn notify(&mut self, notice: Notice) {
        if self.notices.len() >= MAX_PENDING_NOTICES {
            self.notices.pop_front();
        }
        self.notices.push_back(notice);
    }
}

impl Broadcast {
    pub fn new() -> Self {
        Self {
            scene: None,
            timeline: None,
            sheet: None,
            document: None,
            busy: None,
            labels: [None, None],
            held: Vec::new(),
            unsaved: false,
            frames: Vec::new(),
            frame_times: VecDeque::new(),
            tabs: BTreeMap::new(),
            last_tab: 0,
            text: None,
            record: None,
        }
    }

    pub fn attach(&mut self, wake: Box<dyn Fn() + Send + Sync>) -> u32 {
        self.last_tab += 1;
        let tab = Tab {
            wake: wake.into(),
            scene: true,
            truncate_at: None,
            timeline: true,
            sheet: true,
            document: true,
            session: true,
            notices: VecDeque::new(),
            live: true,
            requested: VecDeque::new(),
        };
        self.tabs.insert(self.last_tab, tab);
        self.update_all(|tab| tab.session = true);
        self.last_tab
    }

    /// Returns whether the tab existed.
    pub fn detach(&mut self, tab: u32) -> bool {
        let there = self.tabs.remove(&tab).is_some();
        self.update_all(|tab| tab.session = true);
        there
    }

    pub fn notify(&mut self, to: Option<u32>, notice: Notice) {
        for (_, tab) in self.tabs.iter_mut().filter(|(number, _)| to.is_none_or(|to| to == **number)) {
            tab.notify(notice.clone());
            (tab.wake)();
        }
    }

    /// Sends these frames to a tab, as far as they exist. Replaces an earlier request of the tab.
    pub fn send_frames(&mut self, tab: u32, from: u32, to: u32) {
        let frames = &self.frames;
        let Some(tab) = self.tabs.get_mut(&tab) else { return };
        let there = (from as usize..(to as usize).min(frames.len())).filter(|k| frames[*k].is_some());
        tab.requested = there.take(MAX_FRAMES_PER_REQUEST).collect();
        if !tab.requested.is_empty() {
            (tab.wake)();
        }
    }

    fn update_all(&mut self, mut change: impl FnMut(&mut Tab)) {
        for tab in self.tabs.values_mut() {
            change(tab);
            (tab.wake)();
        }
    }

    /// Publishes the changes of a session; returns the tabs to wake.
    pub fn publish(&mut self, session: &mut Session) -> Vec<Wake> {
        let Changes { scene, timeline, from, thinned, edited, document, said: notices } = session.take_changes();
        let known = self.frames.len();
        if scene {
            self.scene = Some(Arc::new(session.scene()));
        }
        if timeline {
            self.timeline = Some(Arc::new(session.timeline()));
        }
        let mut new_sheet = false;
        if scene || timeline || from.is_some() {
            let sheet = session.sheet();
            new_sheet = self.sheet.as_ref().is_none_or(|before| **before != sheet);
            self.sheet = Some(Arc::new(sheet));
        }
        if let Some(from) = from {
            self.frames.truncate(from);
            self.frames.extend(session.frames_from(from));
            let now = Instant::now();
            self.frame_times.push_back(now);
            self.frame_times.retain(|then| now - *then <= RATE_WINDOW);
            self.record = Some(session.record()).filter(|record| !record.ends.is_empty());
        }
        if thinned {
            self.frames = session.frames_from(0);
        }
        let (labels, held, busy, unsaved) = (session.undo_labels(), session.held(), session.busy(), session.unsaved());
        let mut document = document;
        if edited || self.text.is_none() {
            self.text = session.text().ok().map(Arc::from);
            document = session.changed_document().or(document);
        }
        let new_document = document.is_some();
        self.document = document.map(Arc::new).or(self.document.take());
        let changed = (&labels, &held, &busy, unsaved) != (&self.labels, &self.held, &self.busy, self.unsaved);
        (self.labels, self.held, self.busy, self.unsaved) = (labels, held, busy, unsaved);
        let changed = scene || timeline || from.is_some() || changed || new_document || !notices.is_empty();
        for tab in self.tabs.values_mut() {
            tab.scene |= scene;
            tab.timeline |= timeline;
            tab.sheet |= new_sheet;
            tab.document |= new_document;
            tab.session |= changed || from.is_some();
            if let Some(from) = from {
                if from < known {
                    tab.truncate_at = Some(tab.truncate_at.map_or(from, |before| before.min(from)));
                }
                tab.live = true;
                tab.requested.retain(|k| *k < from);
            }
        }
        for (to, notice) in notices {
            for (_, tab) in self.tabs.iter_mut().filter(|(number, _)| to.is_none_or(|to| to == **number)) {
                tab.notify(notice.clone());
            }
        }
        if changed { self.tabs.values().map(|tab| tab.wake.clone()).collect() } else { Vec::new() }
    }

    /// The next message of a tab, in this order: harness, truncation of the timeline, timeline, sheet, text, session,
    /// notices, newest frame, requested frames.
    pub fn take(&mut self, number: u32) -> Option<TabMessage> {
        let count = self.tabs.len();
        let tab = self.tabs.get_mut(&number)?;
        if std::mem::take(&mut tab.scene)
            && let Some(scene) = &self.scene
        {
            return Some(TabMessage::Notice(Notice::Scene((**scene).clone())));
        }
        if let (Some(truncate_at), Some(timeline)) = (tab.truncate_at.take(), &self.timeline) {
            return Some(TabMessage::Notice(Notice::Timeline(truncated(timeline, truncate_at))));
        }
        if std::mem::take(&mut tab.timeline)
            && let Some(timeline) = &self.timeline
        {
            return Some(TabMessage::Notice(Notice::Timeline((**timeline).clone())));
        }
        if std::mem::take(&mut tab.sheet)
            && let Some(sheet) = &self.sheet
        {
            return Some(TabMessage::Notice(Notice::Sheet((**sheet).clone())));
        }
        if std::mem::take(&mut tab.document)
            && let Some(document) = &self.document
        {
            return Some(TabMessage::Notice(Notice::Document((**document).clone())));
        }
        if std::mem::take(&mut tab.session) {
            let now = Instant::now();
            let rate = self.frame_times.iter().filter(|then| now - **then <= RATE_WINDOW).count() as f64;
            let [undo, redo] = self.labels.clone();
            return Some(TabMessage::Notice(Notice::Session(protocol::Session {
                busy: self.busy.clone(),
                undo,
                redo,
                held: self.held.clone(),
                you: number,
                tabs: u32::try_from(count).unwrap_or(u32::MAX),
                rate,
                unsaved: self.unsaved,
            })));
        }
        if let Some(notice) = tab.notices.pop_front() {
            return Some(TabMessage::Notice(notice));
        }
        if std::mem::take(&mut tab.live)
            && let Some(Some(frame)) = self.frames.last()
        {
            return Some(TabMessage::Frame(frame.clone()));
        }
        while let Some(k) = tab.requested.pop_front() {
            if let Some(Some(frame)) = self.frames.get(k) {
                return Some(TabMessage::Frame(frame.clone()));
            }
        }
        None
    }
}

/// The timeline truncated to this number of frames.
fn truncated(timeline: &Timeline, frames: usize) -> Timeline {
    let frames = u32::try_from(frames).unwrap_or(u32::MAX).min(timeline.frames);
    let mut truncate_at = Timeline { frames, ..timeline.clone() };
    truncate_at.steps.retain(|step| step.first < frames);
    if let Some(last) = truncate_at.steps.last_mut() {
        last.frames = last.frames.min(frames - last.first);
    }
    truncate_at.events.retain(|event| event.frame < frames);
    truncate_at
}
