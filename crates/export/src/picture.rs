//! `picture.svg`: the harness seen from above, from the front and from the side, on one page.
//!
//! A4 landscape, third-angle arrangement (above over front, side to the right of front), one scale for all three
//! views. Branches have their true diameter where that can be seen, and are coloured by the ratio of their curvature
//! to the limit; obstacles lie behind them, grey; nearer parts are drawn over farther ones. Each kind of constraint
//! has a symbol. Text sizes and margins are constants of the page; only the harness is scaled.

mod branches;
mod colour;
mod labels;
mod layout;
mod legend;
mod marks;
mod obstacles;
mod overlay;
mod panel;
mod spans;
mod svg;
mod view;

pub(crate) use overlay::{colour, overlay};

use crate::format::{Ended, File, Format};
use crate::local::node_count;
use std::io::{self, Write};
use svg::{Anchor, Svg, Text, fitted, length};
use wireloom_core::equilibrium::TightestBend;
use wireloom_core::obstacle::Obstacle;
use wireloom_core::{Status, StepResult};

/// Writes the picture of `step` under the headline `title` (usually the name of the scenario), and its `obstacles`,
/// which are those of the step, in the same order.
///
/// Nodes, joints and constraints whose position is not finite are omitted; the legend states their number.
///
/// # Errors
/// Those of `out`; `InvalidInput` where a branch's vectors differ in length.
pub fn write(step: &StepResult, obstacles: &[Obstacle], title: &str, out: &mut impl Write) -> io::Result<()> {
    for branch in &step.branches {
        node_count(branch)?;
    }
    out.write_all(draw(step, obstacles, title).as_bytes())
}

fn draw(step: &StepResult, obstacles: &[Obstacle], title: &str) -> String {
    let scene = view::Scene::of(step);
    let layout = layout::Layout::of(&scene);
    let marks = marks::collect(step);
    let bodies = obstacles::stand(step, obstacles, &scene);
    let mut page = Svg::page(layout::PAGE, title);
    header(&mut page, step, title);
    for panel in &layout.panels {
        page.open(&format!("class=\"view\" id=\"{}\"", panel.view.name()));
        panel::draw(&mut page, panel, &layout);
        obstacles::draw(&mut page, &bodies, panel);
        branches::draw(&mut page, step, panel);
        spans::draw(&mut page, step, panel);
        marks::draw(&mut page, &marks, panel);
        labels::draw(&mut page, step, &marks, panel);
        page.close();
    }
    legend::draw(&mut page, step, &scene, &marks, &layout);
    page.finish()
}

/// Width of bold letters, relative to plain ones.
const BOLD: f64 = 1.14;
/// Largest fraction of the line under the headline for each of its two halves.
const HALF_LINE: f64 = 0.49;

/// Headline, status of the step, and the tightest bend.
fn header(page: &mut Svg, step: &StepResult, title: &str) {
    let left = layout::MARGIN;
    let width = layout::PAGE[0] - 2.0 * left;
    let title = if title.is_empty() { "harness" } else { title };
    let headline = Text { size: 22.0, weight: 700, ..Text::at(left, left + 18.0) };
    page.text(&headline, &fitted(title, BOLD * headline.size, width));

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
                write(end, ended.surroundings.obstacles(), &title, &mut out)
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
