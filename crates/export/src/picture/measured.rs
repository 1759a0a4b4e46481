//! Measured points over the shapes that were computed for them, in three views, one colour for each configuration.

use super::layout::{Layout, MARGIN, PAGE};
use super::overlay::colour;
use super::panel;
use super::svg::{Svg, Text, fitted, number};
use super::view::{Scene, visible};
use std::io::{self, Write};
use wireloom_core::{StepResult, Vector};

/// Width of a computed centre line, page units.
const WIDTH: f64 = 1.4;
/// Radius of a measured point.
const RADIUS: f64 = 2.6;
/// Height of a row of the legend.
const ROW: f64 = 17.0;

/// A configuration: its equilibrium, and points that were measured in it.
#[derive(Clone, Debug)]
pub struct MeasuredShape<'a> {
    /// Words of the legend.
    pub words: String,
    /// The equilibrium.
    pub step: &'a StepResult,
    /// Measured and computed position of each point.
    pub points: Vec<[Vector; 2]>,
}

/// Writes a picture of measured and computed shapes: circles and lines, with a thin line between each measured point
/// and where it was computed.
///
/// # Errors
/// Those of `out`.
pub fn write_measured(shapes: &[MeasuredShape<'_>], title: &str, out: &mut impl Write) -> io::Result<()> {
    out.write_all(draw(shapes, title).as_bytes())
}

fn draw(shapes: &[MeasuredShape<'_>], title: &str) -> String {
    let branches = shapes.iter().flat_map(|shape| &shape.step.branches).flat_map(|branch| &branch.position);
    let points = shapes.iter().flat_map(|shape| shape.points.iter().flatten());
    let scene = Scene::around(branches.chain(points).map(|x| (*x, 0.0)));
    let layout = Layout::of(&scene);
    let mut page = Svg::page(PAGE, title);
    let headline = Text { size: 22.0, weight: 700, ..Text::at(MARGIN, MARGIN + 18.0) };
    page.text(&headline, &fitted(title, 25.0, PAGE[0] - 2.0 * MARGIN));
    for panel in &layout.panels {
        page.open(&format!("class=\"view\" id=\"{}\"", panel.view.name()));
        panel::draw(&mut page, panel, &layout);
        for (k, shape) in shapes.iter().enumerate().rev() {
            let stroke = colour(k);
            page.open(&format!("fill=\"none\" stroke=\"{stroke}\" stroke-width=\"{WIDTH}\" stroke-linejoin=\"round\""));
            for branch in &shape.step.branches {
                let seen = branch.position.iter().filter(|x| visible(x));
                let place = |x: &Vector| panel.place(x).map(number).join(",");
                let line: Vec<String> = seen.map(place).collect();
                page.raw(&format!("<polyline class=\"computed\" points=\"{}\"/>", line.join(" ")));
            }
            for [measured, computed] in shape.points.iter().filter(|pair| pair.iter().all(visible)) {
                let ([x, y], [u, v]) = (panel.place(measured), panel.place(computed));
                page.line([x, y], [u, v], "stroke-width=\"0.6\"");
                let (x, y) = (number(x), number(y));
                page.raw(&format!(
                    "<circle class=\"measured\" cx=\"{x}\" cy=\"{y}\" r=\"{RADIUS}\" stroke-width=\"0.9\"/>"
                ));
            }
            page.close();
        }
        page.close();
    }
    let ([x, y], [width, height]) = layout.legend;
    page.open("class=\"legend\"");
    let rows = shapes.iter().map(|shape| shape.words.as_str()).chain(["line: computed; circle: measured"]);
    for (k, words) in rows.enumerate().take((height / ROW) as usize) {
        let at = y + ROW * (k as f64 + 0.5);
        if k < shapes.len() {
            page.line([x, at], [x + 26.0, at], &format!("stroke=\"{}\" stroke-width=\"3\"", colour(k)));
        }
        page.text(&Text::at(x + 34.0, at + 4.0), &fitted(words, 11.0, width - 34.0));
    }
    page.close();
    page.finish()
}
