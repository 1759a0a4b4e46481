//! Frame, grid, numbers and names of the axes of one view.

use super::layout::{Layout, Panel, round_below};
use super::svg::{Anchor, Svg, Text};

/// Least distance between two lines of the grid, page units.
const GRID: f64 = 62.0;
const AXES: [&str; 3] = ["x", "y", "z"];

pub fn draw(page: &mut Svg, panel: &Panel, layout: &Layout) {
    let ([x, y], [w, h]) = (panel.corner, panel.size);
    let unit = layout.unit;
    let step = grid_step(layout);
    page.rect([x, y], [w, h], "fill=\"#ffffff\" stroke=\"#8c8c8c\" stroke-width=\"0.8\"");
    let number = |value: f64| {
        let decimals = (-(step / unit.metres).log10().floor()).clamp(0.0, 12.0) as usize;
        let text = format!("{:.decimals$}", value / unit.metres);
        if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') { "0".into() } else { text }
    };
    let line = "stroke=\"#e4e4e4\" stroke-width=\"0.7\"";
    for (at, value) in grid(panel.centre[0], w, panel.scale, step) {
        page.line([x + at, y], [x + at, y + h], line);
        let place = Text { size: 9.5, fill: "#555555", anchor: Anchor::Middle, ..Text::at(x + at, y + h + 12.0) };
        page.text(&place, &number(value));
    }
    for (at, value) in grid(panel.centre[1], h, panel.scale, step) {
        let at = y + h - at;
        page.line([x, at], [x + w, at], line);
        let place = Text { size: 9.5, fill: "#555555", anchor: Anchor::End, ..Text::at(x - 5.0, at + 3.3) };
        page.text(&place, &number(value));
    }
    let [a, b] = panel.view.axes();
    let axis = |i: usize| format!("{} [{}]", AXES[i], unit.name);
    page.text(&Text { anchor: Anchor::Middle, ..Text::at(x + 0.5 * w, y + h + 26.0) }, &axis(a));
    page.text(&Text { anchor: Anchor::Middle, upright: true, ..Text::at(x - 40.0, y + 0.5 * h) }, &axis(b));
    page.text(&Text { size: 12.0, weight: 700, ..Text::at(x, y - 6.0) }, panel.view.caption());
}

/// Distance of the grid's lines, m: a round number.
fn grid_step(layout: &Layout) -> f64 {
    let least = GRID / layout.scale;
    let below = round_below(least);
    // The next round number above: 1 → 2 → 5 → 10.
    [1.0, 2.0, 2.5, 5.0].into_iter().map(|f| round_below(below * f)).find(|s| *s >= least).unwrap_or(10.0 * below)
}

/// Lines of the grid: distance from the lower end (page units), coordinate (m).
fn grid(centre: f64, extent: f64, scale: f64, step: f64) -> Vec<(f64, f64)> {
    let low = centre - 0.5 * extent / scale;
    let first = (low / step).ceil();
    let count = (extent / (scale * step)).ceil() as usize;
    (0..=count)
        .map(|i| (first + i as f64) * step)
        .map(|value| ((value - low) * scale, value))
        .filter(|(at, _)| (0.0..=extent).contains(at))
        .collect()
}
