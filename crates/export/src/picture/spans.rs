//! Lines between the stations of a constraint, and spans along which constraints act.

use super::branches::line_width;
use super::colour::INK;
use super::layout::Panel;
use super::svg::{Svg, number};
use super::view::visible;
use crate::xml::escape;
use wireloom_core::equilibrium::{BranchResult, ConstraintResult};
use wireloom_core::{StepResult, Vector};

/// Width of a span beyond that of its branch, page units.
const RIM: f64 = 3.0;

pub fn draw(page: &mut Svg, step: &StepResult, panel: &Panel) {
    if step.constraints.iter().all(|constraint| constraint.stations.is_empty() && constraint.span.is_none()) {
        return;
    }
    page.open("class=\"reach\" fill=\"none\" stroke-linecap=\"round\"");
    for constraint in &step.constraints {
        let tie: Vec<Vector> = constraint.stations.iter().map(|station| station.position).collect();
        let style = format!("stroke=\"{INK}\" stroke-width=\"1.6\" stroke-dasharray=\"1.5 3\"");
        polyline(page, constraint, "tie", &tie, &style, panel);
        let of_span = constraint.span.as_ref().and_then(|span| {
            let branch = step.branches.iter().find(|branch| branch.name == span.branch)?;
            Some((branch, along(branch, span.range)))
        });
        if let Some((branch, points)) = of_span {
            let width = number(line_width(branch.diameter, panel.scale) + RIM);
            let style = format!("stroke=\"{INK}\" stroke-opacity=\"0.25\" stroke-width=\"{width}\"");
            polyline(page, constraint, "span", &points, &style, panel);
        }
    }
    page.close();
}

/// The nodes of a branch within a range of arc lengths.
fn along(branch: &BranchResult, (from, to): (f64, f64)) -> Vec<Vector> {
    let nodes = branch.s.iter().zip(&branch.position);
    nodes.filter(|(s, _)| (from..=to).contains(*s)).map(|(_, x)| *x).collect()
}

fn polyline(page: &mut Svg, constraint: &ConstraintResult, class: &str, points: &[Vector], style: &str, panel: &Panel) {
    let places: Vec<String> = points
        .iter()
        .filter(|x| visible(x))
        .map(|x| panel.place(x))
        .map(|[x, y]| format!("{},{}", number(x), number(y)))
        .collect();
    if places.len() > 1 {
        let title = escape(&constraint.name);
        let places = places.join(" ");
        page.raw(&format!("<polyline class=\"{class}\" points=\"{places}\" {style}><title>{title}</title></polyline>"));
    }
}
