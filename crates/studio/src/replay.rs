//! A finished run for pages: scene, timeline and frames without a solver, and a self-contained page with them.

use crate::frame::{self, Header, number};
use crate::protocol::{Event, Scene, Sheet, Timeline, TimelineStep};
use crate::sheet;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use std::io::Write;
use wireloom::result::{EventPlace, Moment};
use wireloom::{Run, StepResult, result};

/// Limit for the nodes of all frames, bytes: enough for 350 increments of a harness of 4,000 nodes. Their page has
/// about 90 MB; browsers become slow beyond that.
const MAX_BYTES: usize = 64 << 20;

/// A finished run.
#[derive(Clone, Debug)]
pub struct Replay {
    scene: Scene,
    timeline: Timeline,
    sheet: Sheet,
    frames: Vec<Vec<u8>>,
}

/// Records a run, increment by increment. Of very long runs it keeps the ends of steps, and increments at regular
/// intervals between them.
pub struct Recorder {
    scene: Scene,
    steps: Vec<RecordedStep>,
    bytes: usize,
    limit: usize,
    /// Increments within steps are kept if their number is a multiple of this.
    stride: u32,
    /// Work of the current step so far.
    before: Option<StepResult>,
}

/// A recorded step.
struct RecordedStep {
    name: String,
    frames: Vec<RecordedFrame>,
}

/// A frame without its final number.
struct RecordedFrame {
    header: Header,
    nodes: Vec<u8>,
}

impl Recorder {
    /// For a run of the harness in `scene`.
    pub fn new(scene: Scene) -> Self {
        Self { scene, steps: Vec::new(), bytes: 0, limit: MAX_BYTES, stride: 1, before: None }
    }

    /// Records the end of an increment, in order.
    pub fn record(&mut self, end: &StepResult) {
        let header = Header::of(0, end, self.before.as_ref());
        let begins = self.before.as_ref().is_none_or(|last| last.name != end.name || last.increment >= end.increment);
        if begins {
            self.steps.push(RecordedStep { name: end.name.clone(), frames: Vec::new() });
        }
        let nodes = frame::nodes(&end.branches, &[]);
        self.bytes += nodes.len();
        if let Some(step) = self.steps.last_mut() {
            // The previous last frame did not end the step.
            let passed = step.frames.pop_if(|frame_record| !frame_record.header.increment.is_multiple_of(self.stride));
            self.bytes -= passed.map_or(0, |frame_record| frame_record.nodes.len());
            step.frames.push(RecordedFrame { header, nodes });
        }
        // Only the work of the previous increment is needed.
        self.before = Some(StepResult {
            branches: Vec::new(),
            joints: Vec::new(),
            constraints: Vec::new(),
            obstacles: Vec::new(),
            ..end.clone()
        });
        while self.bytes > self.limit && self.thin_frames() {}
    }

    /// Drops every second increment that does not end a step. Returns whether this may help.
    fn thin_frames(&mut self) -> bool {
        self.stride = self.stride.saturating_mul(2);
        let before = self.bytes;
        for step in &mut self.steps {
            let last = step.frames.last().map_or(0, |frame_record| frame_record.header.increment);
            step.frames.retain(|frame_record| {
                let keep =
                    frame_record.header.increment == last || frame_record.header.increment.is_multiple_of(self.stride);
                self.bytes -= if keep { 0 } else { frame_record.nodes.len() };
                keep
            });
        }
        self.bytes < before || self.stride < 1 << 16
    }

    /// The finished run.
    pub fn finish(self, run: &Run) -> Replay {
        let mut scene = self.scene;
        scene.notes = run.notes.clone();
        let (mut steps, mut first) = (Vec::new(), 0);
        for step in &self.steps {
            let frames = number(step.frames.len());
            steps.push(TimelineStep { name: step.name.clone(), first, frames, planned: frames, by_hand: false });
            first += frames;
        }
        let frame = |moment: &Moment| Some(find(moment, &self.steps)?.0);
        let sheet = sheet::sheet(&run.requirements, run.status(), (steps.len(), steps.len()), frame);
        let events = run.events.iter().filter_map(|event| timeline_event(event, &self.steps, &scene)).collect();
        let all = self.steps.into_iter().flat_map(|step| step.frames);
        let encoded = |(k, mut frame_record): (usize, RecordedFrame)| {
            frame_record.header.frame = number(k);
            frame_record.header.encode(&frame_record.nodes)
        };
        let frames = all.enumerate().map(encoded).collect();
        Replay { scene, timeline: Timeline { frames: first, steps, events }, sheet, frames }
    }
}

/// An event of the timeline; `None` if its step has no frames.
fn timeline_event(event: &result::Event, steps: &[RecordedStep], scene: &Scene) -> Option<Event> {
    let (number, _) = find(&event.first, steps)?;
    let (_, worst) = find(&event.worst, steps)?;
    let message = format!("{}: {}", event.place, event.message);
    Some(Event {
        frame: number,
        kind: event.kind.word().to_owned(),
        message,
        position: place(&event.place, worst, scene),
    })
}

/// Number and record of an increment's frame, or of the next frame that was kept.
fn find<'a>(moment: &Moment, steps: &'a [RecordedStep]) -> Option<(u32, &'a RecordedFrame)> {
    let step = steps.get(moment.step_index)?;
    let before: usize = steps[..moment.step_index].iter().map(|step| step.frames.len()).sum();
    let increment = number(moment.increment);
    let within = step.frames.iter().position(|frame_record| frame_record.header.increment >= increment)?;
    Some((number(before + within), &step.frames[within]))
}

/// Position of an event, m.
fn place(place: &EventPlace, frame_record: &RecordedFrame, scene: &Scene) -> Option<[f64; 3]> {
    if let Some(constraint) = &place.constraint {
        return frame_record
            .header
            .constraints
            .iter()
            .find(|other| other.name == *constraint)
            .map(|constraint| constraint.at.position);
    }
    let branch = scene.branches.iter().position(|branch| Some(&branch.name) == place.branch.as_ref())?;
    let first: u32 = scene.branches[..branch].iter().map(|branch| branch.nodes).sum();
    let all = frame::floats(&frame_record.nodes)?;
    let nodes = all.get(first as usize..)?.get(..scene.branches[branch].nodes as usize)?;
    let s = place.s? as f32;
    let nearest = nodes.iter().min_by(|a, b| (a[ARC_LENGTH] - s).abs().total_cmp(&(b[ARC_LENGTH] - s).abs()))?;
    Some([nearest[0], nearest[1], nearest[2]].map(f64::from))
}

/// Index of the arc length among a node's numbers.
const ARC_LENGTH: usize = 6;

#[derive(Serialize)]
struct Head<'a> {
    scene: &'a Scene,
    timeline: &'a Timeline,
    sheet: &'a Sheet,
}

impl Replay {
    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The timeline.
    pub fn timeline(&self) -> &Timeline {
        &self.timeline
    }

    /// The sheet of requirements.
    pub fn sheet(&self) -> &Sheet {
        &self.sheet
    }

    /// The frames.
    pub fn frames(&self) -> &[Vec<u8>] {
        &self.frames
    }

    /// A self-contained HTML page, from the studio's page `page` ([`crate::PAGE`]). Its data is a base64 string of
    /// gzip:
    ///
    /// | bytes | what |
    /// | --- | --- |
    /// | 4 | length n of the head, a multiple of 4 |
    /// | n | `{"scene": …, "timeline": …, "sheet": …}`, padded with spaces |
    /// | for every frame: 4 | its length m, a multiple of 4 |
    /// | m | the frame |
    ///
    /// Base64 has no characters with a meaning in HTML, so names in a scenario cannot become markup.
    pub fn page(&self, page: &str) -> String {
        let head = Head { scene: &self.scene, timeline: &self.timeline, sheet: &self.sheet };
        let mut head = serde_json::to_vec(&head).expect("strings, numbers and lists of them");
        head.resize(head.len().next_multiple_of(4), b' ');
        let mut packed = GzEncoder::new(Vec::new(), Compression::default());
        for part in std::iter::once(&head).chain(&self.frames) {
            let length = number(part.len()).to_le_bytes();
            packed.write_all(&length).and_then(|()| packed.write_all(part)).expect("memory takes all");
        }
        let packed = packed.finish().expect("memory takes all");
        page.replacen(EMPTY, &format!("{OPEN}\"{}\"{CLOSE}", STANDARD.encode(packed)), 1)
    }
}

/// Element of a page that contains a run.
const OPEN: &str = "<script type=\"application/json\" id=\"replay\">";
const CLOSE: &str = "</script>";
/// The same element without a run.
const EMPTY: &str = "<script type=\"application/json\" id=\"replay\">null</script>";

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom::Control;

    /// A cable whose end moves out in 64 increments and back in 8.
    const TEXT: &str = r#"
        schema = 1
        name = "cable"
        branches = [{ name = "cable", from = "A", to = "B", section = "cable", length = 1.0, segments = 10 }]
        steps = [
            { name = "out", increments = 64, move = [{ constraint = "B", position = [0.7, 0, 0] }] },
            { name = "back", increments = 8, move = [{ constraint = "B", position = [0.6, 0, 0] }] },
        ]

        [sections.cable]
        diameter = 0.006
        linear_density = 0.05
        axial_stiffness = 1e4
        bending_stiffness = 0.01
        torsion_stiffness = 0.008

        [[constraints]]
        name = "A"
        kind = "connector"
        at = { end = "A" }
        position = [0, 0, 0]
        tangent = [1, 0, 0]
        up = [0, 0, 1]

        [[constraints]]
        name = "B"
        kind = "connector"
        at = { end = "B" }
        position = [0.6, 0, 0]
        tangent = [1, 0, 0]
        up = [0, 0, 1]
    "#;

    #[test]
    fn long_runs_are_thinned_evenly_and_ends_of_steps_stay() {
        let (_, built) = wireloom::load(TEXT, &wireloom::registry()).expect("no faults");
        let scene = crate::scene::of(&built.schedule, "wireloom", &built.network);
        let limit = 20 * 11 * 4 * frame::FLOATS;
        let mut recorder = Recorder { limit, ..Recorder::new(scene) };
        let run = wireloom::run(built, &mut |_, end| {
            recorder.record(end);
            Control::Continue
        });
        assert!(recorder.bytes <= limit);
        let frame_record = |step: &RecordedStep| {
            step.frames.iter().map(|frame_record| frame_record.header.increment).collect::<Vec<_>>()
        };
        assert_eq!(frame_record(&recorder.steps[0]), (1..=16).map(|k| 4 * k).collect::<Vec<_>>());
        // Frames are dropped when the limit is reached, not before.
        assert!(frame_record(&recorder.steps[1]).ends_with(&[8]) && frame_record(&recorder.steps[1]).contains(&4));
        let replay = recorder.finish(&run);
        assert_eq!(replay.timeline.frames as usize, replay.frames.len());
        let last = replay.timeline.steps.last().expect("two steps");
        assert_eq!(last.first + last.frames, replay.timeline.frames);
    }
}
