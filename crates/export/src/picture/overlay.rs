//! Several shapes over each other in three views, each in its own colour, with a legend.

use super::layout::{Layout, MARGIN, PAGE};
use super::panel;
use super::svg::{Svg, Text, fitted, number};
use super::view::{Scene, visible};
use crate::comparison::Case;
use crate::ending::BranchEnd;

/// Colours that people with any kind of colour vision tell apart (Okabe and Ito), the darkest first.
const COLOURS: [&str; 8] = ["#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#b8ad00"];
/// Width of a line, page units.
const WIDTH: f64 = 1.8;
/// Height of a row of the legend.
const ROW: f64 = 17.0;

/// The colour of a case; after eight they repeat.
pub(crate) fn colour(k: usize) -> &'static str {
    COLOURS[k % COLOURS.len()]
}

/// Draws all cases, those that come first over the others.
pub(crate) fn overlay(cases: &[Case], title: &str) -> String {
    let branches = || cases.iter().flat_map(|case| &case.ending.branches);
    let scene = Scene::around(branches().flat_map(|branch| &branch.position).map(|x| (*x, 0.0)));
    let layout = Layout::of(&scene);
    let mut page = Svg::page(PAGE, title);
    page.text(
        &Text { size: 22.0, weight: 700, ..Text::at(MARGIN, MARGIN + 18.0) },
        &fitted(title, 25.0, PAGE[0] - 2.0 * MARGIN),
    );
    for panel in &layout.panels {
        page.open(&format!("class=\"view\" id=\"{}\"", panel.view.name()));
        panel::draw(&mut page, panel, &layout);
        page.open(&format!("fill=\"none\" stroke-width=\"{WIDTH}\" stroke-linejoin=\"round\""));
        for (k, case) in cases.iter().enumerate().rev() {
            for branch in &case.ending.branches {
                let path = path(branch, &|x| panel.place(x));
                page.raw(&format!("<path class=\"shape\" d=\"{path}\" stroke=\"{}\"/>", colour(k)));
            }
        }
        page.close();
        page.close();
    }
    let ([x, y], [width, height]) = layout.legend;
    page.open("class=\"legend\"");
    let rows = (height / ROW) as usize;
    for (k, case) in cases.iter().enumerate().take(rows) {
        let at = y + ROW * (k as f64 + 0.5);
        let style = format!("stroke=\"{}\" stroke-width=\"3\"", colour(k));
        page.line([x, at], [x + 26.0, at], &style);
        page.text(&Text::at(x + 34.0, at + 4.0), &fitted(&case.name, 11.0, width - 34.0));
    }
    page.close();
    page.finish()
}

/// Nodes that cannot be drawn interrupt the line.
fn path(branch: &BranchEnd, place: &dyn Fn(&wireloom_core::Vector) -> [f64; 2]) -> String {
    let mut d = String::new();
    let mut open = false;
    for x in &branch.position {
        if visible(x) {
            let [u, v] = place(x);
            d += &format!("{}{} {}", if open { 'L' } else { 'M' }, number(u), number(v));
        }
        open = visible(x);
    }
    d
}
