//! `picture.svg`: the harness seen from above, from the front and from the side, on one page.
//!
//! A4 landscape, third-angle arrangement (above over front, side to the right of front), one scale for all
//! three views. Branches have their true diameter where that can be seen, and are coloured by how near their
//! bend comes to the limit; what is nearer is drawn over what is farther. Fixings carry a symbol for each kind.
//! Text sizes and margins are constants of the page; only the harness is scaled.

mod branches;
mod colour;
mod labels;
mod layout;
mod legend;
mod marks;
mod panel;
mod svg;
mod view;

use crate::local::node_count;
use std::io::{self, Write};
use wireloom_core::StepResult;
use wireloom_core::equilibrium::TightestBend;

/// Writes the picture of `step` under the headline `title` (usually the name of the scenario).
///
/// Nodes, joints and fixings whose position is not a finite number are left out; the legend says how many.
///
/// # Errors
/// Those of `out`; `InvalidInput` where a branch's vectors differ in length.
pub fn write(step: &StepResult, title: &str, out: &mut impl Write) -> io::Result<()> {
    for branch in &step.branches {
        node_count(branch)?;
    }
    out.write_all(draw(step, title).as_bytes())
}

fn draw(step: &StepResult, title: &str) -> String {
    let scene = view::Scene::of(step);
    let layout = layout::Layout::of(&scene);
    let marks = marks::collect(step);
    let mut page = svg::Svg::page(layout::PAGE, title);
    header(&mut page, step, title);
    for panel in &layout.panels {
        page.open(&format!("class=\"view\" id=\"{}\"", panel.view.name()));
        panel::draw(&mut page, panel, &layout);
        branches::draw(&mut page, step, panel);
        marks::draw(&mut page, &marks, panel);
        labels::draw(&mut page, step, &marks, panel);
        page.close();
    }
    legend::draw(&mut page, step, &scene, &marks, &layout);
    page.finish()
}

/// Headline, how the step ended, and the tightest bend.
fn header(page: &mut svg::Svg, step: &StepResult, title: &str) {
    use svg::{Anchor, Text};
    let left = layout::MARGIN;
    let width = layout::PAGE[0] - 2.0 * left;
    let title = if title.is_empty() { "harness" } else { title };
    page.text(&Text { size: 22.0, weight: 700, ..Text::at(left, left + 18.0) }, &svg::fitted(title, 22.0, width));

    let mut line = format!("step “{}”", svg::fitted(&step.name, 13.0, 0.4 * width));
    if step.increments > 1 || step.increment < step.increments {
        line += &format!(", increment {} of {}", step.increment, step.increments);
    }
    line += &format!("  ·  {}", step.status.word());
    match step.stable {
        Some(true) => line += "  ·  stable",
        Some(false) => line += "  ·  unstable equilibrium",
        None => {}
    }
    let trouble = step.status != wireloom_core::Status::Converged || step.stable == Some(false);
    let fill = if trouble { colour::OVER } else { "#333333" };
    page.text(&Text { size: 13.0, fill, ..Text::at(left, left + 42.0) }, &line);

    let (line, over) = tightest(step.min_bend_radius.as_ref());
    let fill = if over { colour::OVER } else { "#333333" };
    let place = Text { size: 13.0, fill, anchor: Anchor::End, ..Text::at(left + width, left + 42.0) };
    page.text(&place, &svg::fitted(&line, 13.0, 0.55 * width));
}

/// The tightest bend in words, and whether it is below its limit.
fn tightest(bend: Option<&TightestBend>) -> (String, bool) {
    let Some(TightestBend { branch, s, value, limit }) = bend else {
        return ("straight everywhere".into(), false);
    };
    let mut line = format!("tightest bend {} on {branch} at s = {}", svg::length(*value), svg::length(*s));
    let over = limit.is_some_and(|limit| *value < limit);
    match limit {
        Some(limit) if over => line += &format!(": below the limit of {}", svg::length(*limit)),
        Some(limit) => line += &format!(" (limit {})", svg::length(*limit)),
        None => line += " (no limit given)",
    }
    (line, over)
}
