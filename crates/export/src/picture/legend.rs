//! The legend: colours, symbols, scale, number of omitted parts, and forces of the constraints.

use super::branches::{THINNEST, line_width};
use super::colour::{INK, NEUTRAL_FULL, OVER, Paint, STEPS, STRAINED};
use super::labels;
use super::layout::{Layout, round_below};
use super::limits::Limits;
use super::marks::{Kind, Marks, symbol};
use super::svg::{Anchor, Svg, Text, fitted, length, significant};
use super::view::Scene;
use wireloom_core::StepResult;
use wireloom_core::equilibrium::BranchResult;

/// A colour bar.
const BAR: [f64; 2] = [170.0, 11.0];
/// Width of the legend proper; where the corner is twice as wide, the table stands to the right of it.
const COLUMN: f64 = 250.0;
/// Right edges of the columns of the table.
const TABLE: [f64; 3] = [122.0, 172.0, 236.0];
/// Height of a row of the table.
const ROW: f64 = 14.0;
/// Largest number of constraints in the table.
const ROWS: usize = 16;

/// Whether some part of a branch may bend as tightly as it will.
fn is_unlimited(branch: &BranchResult) -> bool {
    branch.bend_radius_limit.is_none() || branch.sections.iter().any(|part| part.bend_radius_limit.is_none())
}

pub fn draw(page: &mut Svg, step: &StepResult, scene: &Scene, marks: &Marks, limits: &Limits, layout: &Layout) {
    let ([x, top], [width, height]) = layout.legend;
    let mut y = top;
    page.open("class=\"legend\"");
    if step.branches.iter().any(|branch| branch.bend_radius_limit.is_some()) {
        y = limited_bar(page, x, y);
    }
    if step.branches.iter().any(is_unlimited) {
        y = neutral_bar(page, x, y);
    }
    if limits.show(&step.branches) {
        let style = format!("fill=\"{STRAINED}\" stroke=\"{INK}\" stroke-width=\"1.3\"");
        page.rect([x, y], [26.0, BAR[1]], &style);
        page.text(&Text { size: 10.5, ..Text::at(x + 34.0, y + 9.5) }, "pulled or pressed beyond its limit");
        y += 22.0;
    }
    y = symbols(page, x, y, marks);
    y = scale_bar(page, x, y, layout);
    for line in remarks(step, scene, marks, layout) {
        y += 13.0;
        page.text(&Text { size: 9.5, fill: "#555555", ..Text::at(x, y) }, &line);
    }
    let corner = if width >= 2.0 * COLUMN { [x + COLUMN, top] } else { [x, y + 14.0] };
    reactions(page, step, corner, top + height);
    page.close();
}

/// Forces of the constraints, the largest first, as far as there is room above `bottom`.
fn reactions(page: &mut Svg, step: &StepResult, [x, y]: [f64; 2], bottom: f64) {
    let room = (((bottom - y) / ROW).max(0.0) as usize).saturating_sub(1).min(ROWS);
    let mut constraints: Vec<(&str, f64, f64)> =
        step.constraints.iter().map(|c| (c.name.as_str(), c.force.norm(), c.moment.norm())).collect();
    constraints.sort_by(|a, b| b.1.total_cmp(&a.1));
    if constraints.is_empty() || room < 3 {
        return;
    }
    let listed = if constraints.len() > room { room - 1 } else { constraints.len() };
    let mut row = |i: usize, name: &str, force: &str, moment: &str, weight: u32| {
        let base = Text { size: 10.0, weight, ..Text::at(x, y + 9.0 + ROW * i as f64) };
        page.text(&base, &fitted(name, 10.0, TABLE[0]));
        if !force.is_empty() {
            page.text(&Text { x: x + TABLE[1], anchor: Anchor::End, ..base }, force);
            page.text(&Text { x: x + TABLE[2], anchor: Anchor::End, ..base }, moment);
        }
    };
    row(0, "constraint", "N", "N m", 700);
    for (i, (name, force, moment)) in constraints[..listed].iter().enumerate() {
        row(i + 1, name, &significant(*force), &significant(*moment), 400);
    }
    if listed < constraints.len() {
        row(listed + 1, &format!("and {} more", constraints.len() - listed), "", "", 400);
    }
    let style = "stroke=\"#8c8c8c\" stroke-width=\"0.8\"";
    page.line([x, y + 12.5], [x + TABLE[2], y + 12.5], style);
}

fn limited_bar(page: &mut Svg, x: f64, y: f64) -> f64 {
    page.text(&Text { size: 10.5, ..Text::at(x, y + 9.0) }, "bend radius limit / bend radius");
    gradient(page, [x, y + 14.0], Paint::Limited);
    page.rect(
        [x + BAR[0] + 6.0, y + 14.0],
        [26.0, BAR[1]],
        &format!("fill=\"{OVER}\" stroke=\"{INK}\" stroke-width=\"1.3\""),
    );
    let place = |at: f64, anchor| Text { size: 9.5, anchor, ..Text::at(at, y + 14.0 + BAR[1] + 11.0) };
    page.text(&place(x, Anchor::Start), "0 straight");
    page.text(&place(x + 0.5 * BAR[0], Anchor::Middle), "0.5");
    page.text(&place(x + BAR[0], Anchor::End), "1 limit");
    page.text(&place(x + BAR[0] + 6.0, Anchor::Start), "too tight");
    y + 46.0
}

fn neutral_bar(page: &mut Svg, x: f64, y: f64) -> f64 {
    page.text(&Text { size: 10.5, ..Text::at(x, y + 9.0) }, "no limit given: diameter / bend radius");
    gradient(page, [x, y + 14.0], Paint::Neutral);
    let place = |at: f64, anchor| Text { size: 9.5, anchor, ..Text::at(at, y + 14.0 + BAR[1] + 11.0) };
    page.text(&place(x, Anchor::Start), "0 straight");
    page.text(&place(x + BAR[0], Anchor::End), &format!("{NEUTRAL_FULL} and more"));
    y + 46.0
}

fn gradient(page: &mut Svg, [x, y]: [f64; 2], paint: fn(u16) -> Paint) {
    let width = BAR[0] / f64::from(STEPS + 1);
    for step in 0..=STEPS {
        let style = format!("fill=\"{}\"", paint(step).hex());
        // Each cell reaches under the next one, or renderers show hairlines between them.
        let reach = if step == STEPS { width } else { width + 0.8 };
        page.rect([x + f64::from(step) * width, y], [reach, BAR[1]], &style);
    }
}

/// The symbols that occur, two columns of them.
fn symbols(page: &mut Svg, x: f64, y: f64, marks: &Marks) -> f64 {
    let present: Vec<Kind> =
        Kind::ALL.into_iter().filter(|kind| marks.list.iter().any(|mark| mark.kind == *kind)).collect();
    for (i, kind) in present.iter().enumerate() {
        let at = [x + 9.0 + 112.0 * (i % 2) as f64, y + 9.0 + 17.0 * (i / 2) as f64];
        // Rings around a place are wider than symbols at one.
        symbol(page, *kind, at, if kind.is_urgent() { 4.0 } else { 5.2 }, kind.words());
        page.text(&Text { size: 10.5, ..Text::at(at[0] + 13.0, at[1] + 3.7) }, kind.words());
    }
    y + 17.0 * present.len().div_ceil(2) as f64 + 6.0
}

fn scale_bar(page: &mut Svg, x: f64, y: f64, layout: &Layout) -> f64 {
    let metres = round_below(150.0 / layout.scale);
    let (a, b) = (x + 1.0, x + 1.0 + metres * layout.scale);
    let style = format!("stroke=\"{INK}\" stroke-width=\"1.4\"");
    let level = y + 10.0;
    page.line([a, level], [b, level], &style);
    page.line([a, level - 4.0], [a, level + 4.0], &style);
    page.line([b, level - 4.0], [b, level + 4.0], &style);
    let value = metres / layout.unit.metres;
    let text = format!("{} {}", (value * 1e9).round() / 1e9, layout.unit.name);
    page.text(&Text { size: 10.5, class: "scale", ..Text::at(b + 8.0, level + 3.7) }, &text);
    y + 18.0
}

fn remarks(step: &StepResult, scene: &Scene, marks: &Marks, layout: &Layout) -> Vec<String> {
    let mut lines = Vec::new();
    let thin = step.branches.iter().any(|branch| line_width(branch.diameter, layout.scale) <= THINNEST);
    lines.push(if thin {
        format!("lines: true diameter, at least {}", length(THINNEST / layout.scale))
    } else {
        "lines: true diameter".into()
    });
    if marks.list.len() > labels::ALL_NAMED {
        lines.push(format!("named: the {} constraints with the largest forces", labels::NAMED_OF_MANY));
    }
    if scene.hidden > 0 {
        lines.push(format!("{} points without a finite position omitted", scene.hidden));
    }
    lines
}
