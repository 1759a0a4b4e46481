//! `picture.svg`: the harness seen from above, from the front and from the side, on one page.
//!
//! A4 landscape, third-angle arrangement (above over front, side to the right of front), one scale for all three
//! views. Branches have their true diameter where that can be seen, and are coloured by the ratio of their curvature
//! to the limit; where they are pulled, pressed or stretched beyond a limit, that colour covers the one of the bend.
//! Obstacles lie behind them, grey; nearer parts are drawn over farther ones. Each kind of constraint has a symbol, and
//! so have places where a requirement fails or is unresolved. Text sizes and margins are constants of the page; only
//! the harness is scaled.

mod branches;
mod colour;
mod curves;
mod labels;
mod layout;
mod legend;
mod limits;
mod marks;
mod measured;
mod obstacles;
mod overlay;
mod panel;
mod spans;
mod svg;
mod view;

pub use curves::{MeasuredCurve, write_curves};
pub use measured::{MeasuredShape, write_measured};
pub(crate) use overlay::{colour, overlay};

use crate::format::{Ended, File, Format};
use crate::local::node_count;
use crate::sheet::{capitals, open_in};
use std::io::{self, Write};
use svg::{Anchor, Svg, Text, fitted, length};
use wireloom_core::equilibrium::{RequirementResult, Run, TightestBend};
use wireloom_core::obstacle::Obstacle;
use wireloom_core::requirement::Verdict;
use wireloom_core::{Status, StepResult};

/// What a picture shows.
#[derive(Clone, Copy, Debug)]
pub struct Drawing<'a> {
    /// The equilibrium.
    pub step: &'a StepResult,
    /// The obstacles, in the order of the step.
    pub obstacles: &'a [Obstacle],
    /// The headline, usually the name of the scenario.
    pub title: &'a str,
    /// The run: its verdict and status stand beside the headline, and what fails or is unresolved is marked.
    pub run: Option<&'a Run>,
    /// Index of the step whose requirements are marked; `None`: those of all steps.
    pub of_step: Option<usize>,
}

impl<'a> Drawing<'a> {
    /// An equilibrium without requirements.
    pub fn new(step: &'a StepResult, obstacles: &'a [Obstacle], title: &'a str) -> Self {
        Self { step, obstacles, title, run: None, of_step: None }
    }

    /// The requirements that fail or are unresolved, the most urgent first.
    fn open(&self) -> Vec<&'a RequirementResult> {
        self.run.map_or_else(Vec::new, |run| open_in(run, self.of_step))
    }
}

/// Writes a picture.
///
/// Nodes, joints and constraints whose position is not finite are omitted; the legend states their number.
///
/// # Errors
/// Those of `out`; `InvalidInput` where a branch's vectors differ in length.
pub fn write(drawing: &Drawing<'_>, out: &mut impl Write) -> io::Result<()> {
    for branch in &drawing.step.branches {
        node_count(branch)?;
    }
    out.write_all(draw(drawing).as_bytes())
}

fn draw(drawing: &Drawing<'_>) -> String {
    let Drawing { step, obstacles, title, .. } = *drawing;
    let open = drawing.open();
    let scene = view::Scene::of(step);
    let layout = layout::Layout::of(&scene);
    let marks = marks::collect(step, &open);
    let limits = limits::Limits::of(&open);
    let bodies = obstacles::stand(step, obstacles, &scene);
    let mut page = Svg::page(layout::PAGE, title);
    header(&mut page, drawing);
    for panel in &layout.panels {
        page.open(&format!("class=\"view\" id=\"{}\"", panel.view.name()));
        panel::draw(&mut page, panel, &layout);
        obstacles::draw(&mut page, &bodies, panel);
        branches::draw(&mut page, step, &limits, panel);
        spans::draw(&mut page, step, panel);
        marks::draw(&mut page, &marks, panel);
        labels::draw(&mut page, step, &marks, panel);
        page.close();
    }
    legend::draw(&mut page, step, &scene, &marks, &limits, &layout);
    page.finish()
}

/// Width of bold letters, relative to plain ones.
const BOLD: f64 = 1.14;
/// Space between headline, verdict and status.
const SIGNS: f64 = 18.0;
/// Largest fraction of the line under the headline for each of its two halves.
const HALF_LINE: f64 = 0.49;

/// Headline with the verdict and the status of the run, status of the step, and the tightest bend.
fn header(page: &mut Svg, drawing: &Drawing<'_>) {
    let Drawing { step, title, run, .. } = *drawing;
    let left = layout::MARGIN;
    let width = layout::PAGE[0] - 2.0 * left;
    let title = if title.is_empty() { "harness" } else { title };
    let headline = Text { size: 22.0, weight: 700, ..Text::at(left, left + 18.0) };
    let signs = run.map_or(0.0, |run| signs(page, run, left + width, left + 18.0));
    page.text(&headline, &fitted(title, BOLD * headline.size, width - signs));

    let plain = Text { size: 13.0, fill: "#333333", ..Text::at(left, left + 42.0) };
    let half = HALF_LINE * width;
    let (before, name, after, trouble) = ending(step);
    let fill = if trouble { colour::OVER } else { plain.fill };
    page.text(&Text { fill, ..plain }, &line(&before, name, &after, half));
    let (before, name, after, trouble) = tightest(step.min_bend_radius.as_ref());
    let fill = if trouble { colour::OVER } else { plain.fill };
    let right = Text { x: left + width, fill, anchor: Anchor::End, ..plain };
    page.text(&right, &line(&before, name, &after, half));
}

/// The verdict and the status of the run, up to the right edge `x`, on the baseline `y`. Returns their width.
fn signs(page: &mut Svg, run: &Run, x: f64, y: f64) -> f64 {
    let fill = match run.verdict() {
        Verdict::Pass => colour::PASS,
        Verdict::Fail => colour::OVER,
        Verdict::Unresolved | Verdict::NotChecked => colour::UNRESOLVED,
    };
    let status = format!("run: {}", run.status().word());
    let plain = Text { size: 13.0, fill: "#333333", anchor: Anchor::End, ..Text::at(x, y) };
    let bad = run.status() != Status::Converged;
    page.text(&Text { class: "status", fill: if bad { colour::OVER } else { plain.fill }, ..plain }, &status);
    let right = svg::width(&status, plain.size) + SIGNS;
    let verdict = format!("verdict: {}", capitals(run.verdict()));
    let bold = Text { x: x - right, size: 16.0, weight: 700, fill, class: "verdict", ..plain };
    page.text(&bold, &verdict);
    right + BOLD * svg::width(&verdict, bold.size) + SIGNS
}

/// A name between words; only the name is shortened.
fn line(before: &str, name: &str, after: &str, space: f64) -> String {
    let words = svg::width(before, 13.0) + svg::width(after, 13.0);
    format!("{before}{}{after}", fitted(name, 13.0, space - words))
}

/// Status of the step: words, the step's name, words, and whether it is bad.
fn ending(step: &StepResult) -> (String, &str, String, bool) {
    let mut after = String::from("”");
    if step.increments > 1 {
        after += &format!(", increment {} of {}", step.increment, step.increments);
    }
    after += &format!("  ·  {}", step.status.word());
    match step.stable {
        Some(true) => after += "  ·  stable",
        Some(false) => after += "  ·  unstable equilibrium",
        None => {}
    }
    ("step “".into(), &step.name, after, step.status != Status::Converged || step.stable == Some(false))
}

/// The tightest bend: words, the branch's name, words, and whether it is below its limit.
fn tightest(bend: Option<&TightestBend>) -> (String, &str, String, bool) {
    let Some(TightestBend { branch, s, value, limit }) = bend else {
        return (String::new(), "", "straight everywhere".into(), false);
    };
    let over = limit.is_some_and(|limit| *value < limit);
    let verdict = match limit {
        Some(limit) if over => format!(": below the limit of {}", length(*limit)),
        Some(limit) => format!(" (limit {})", length(*limit)),
        None => " (no limit given)".into(),
    };
    (format!("tightest bend {} on ", length(*value)), branch, format!(" at s = {}{verdict}", length(*s)), over)
}

/// The format `picture.svg`.
pub struct Picture;

/// Its file.
const FILE: &str = "picture.svg";

impl Format for Picture {
    fn key(&self) -> Option<&'static str> {
        Some("picture")
    }

    fn files(&self) -> &'static [&'static str] {
        &[FILE]
    }

    fn media_type(&self) -> &'static str {
        "image/svg+xml"
    }

    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        let file = |end: &'a StepResult| {
            File::new(FILE, move |mut out| {
                let title = format!("{}: {}", ended.run.scenario, end.name);
                let obstacles = ended.surroundings.obstacles();
                write(&Drawing { run: Some(ended.run), ..Drawing::new(end, obstacles, &title) }, &mut out)
            })
        };
        ended.run.steps.last().map(file).into_iter().collect()
    }

    fn offered(&self, _: &[&str], _: bool) -> Vec<String> {
        vec![FILE.to_owned()]
    }

    fn at_hand<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        self.at_end(ended)
    }
}
