//! Symbols of joints, constraints and the tightest bend.

use super::colour::INK;
use super::layout::Panel;
use super::svg::{Svg, number, significant};
use super::view::visible;
use crate::xml::escape;
use wireloom_core::{StepResult, Vector};

/// Meaning of a symbol.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    Joint,
    Connector,
    Collar,
    Handle,
    OtherConstraint,
    TightestBend,
}

impl Kind {
    /// In the order of the legend.
    pub const ALL: [Kind; 6] =
        [Kind::Connector, Kind::Collar, Kind::Handle, Kind::OtherConstraint, Kind::Joint, Kind::TightestBend];

    fn of_constraint(word: &str) -> Self {
        match word {
            "connector" => Kind::Connector,
            "collar" => Kind::Collar,
            "handle" => Kind::Handle,
            _ => Kind::OtherConstraint,
        }
    }

    pub fn words(self) -> &'static str {
        match self {
            Kind::Joint => "joint",
            Kind::Connector => "connector",
            Kind::Collar => "collar",
            Kind::Handle => "handle",
            Kind::OtherConstraint => "other constraint",
            Kind::TightestBend => "tightest bend",
        }
    }

    pub fn class(self) -> &'static str {
        match self {
            Kind::Joint => "joint",
            Kind::Connector => "constraint connector",
            Kind::Collar => "constraint collar",
            Kind::Handle => "constraint handle",
            Kind::OtherConstraint => "constraint other",
            Kind::TightestBend => "tightest",
        }
    }
}

/// One symbol.
pub struct Mark {
    pub kind: Kind,
    pub position: Vector,
    /// The name beside it.
    pub label: String,
    /// Text that a browser shows under the pointer.
    pub tip: String,
    /// Priority of its name where there is no room for all.
    pub weight: f64,
}

/// All symbols of a drawing, and their size.
pub struct Marks {
    pub list: Vec<Mark>,
    /// Half the width of a symbol, page units.
    pub half: f64,
}

/// Number of symbols above which they shrink.
const MANY: usize = 60;

pub fn collect(step: &StepResult) -> Marks {
    let mut list = Vec::new();
    for joint in &step.joints {
        list.push(Mark {
            kind: Kind::Joint,
            position: joint.position,
            label: joint.name.clone(),
            tip: format!("joint {}", joint.name),
            weight: 0.0,
        });
    }
    for constraint in &step.constraints {
        let (force, moment) = (constraint.force.norm(), constraint.moment.norm());
        list.push(Mark {
            kind: Kind::of_constraint(&constraint.kind),
            position: constraint.position,
            label: constraint.name.clone(),
            tip: format!(
                "{} ({}): {} N, {} N m",
                constraint.name,
                constraint.kind,
                significant(force),
                significant(moment)
            ),
            weight: if force.is_finite() { force } else { 0.0 },
        });
    }
    list.extend(tightest(step));
    list.retain(|mark| visible(&mark.position));
    let half = if list.len() > MANY { 3.6 } else { 5.6 };
    Marks { list, half }
}

/// The tightest bend, at its place on its branch.
fn tightest(step: &StepResult) -> Option<Mark> {
    let bend = step.min_bend_radius.as_ref()?;
    let branch = step.branches.iter().find(|branch| branch.name == bend.branch)?;
    let upper = branch.s.partition_point(|s| *s < bend.s).min(branch.s.len().checked_sub(1)?);
    let lower = upper.saturating_sub(1);
    let span = branch.s[upper] - branch.s[lower];
    let t = if span > 0.0 { ((bend.s - branch.s[lower]) / span).clamp(0.0, 1.0) } else { 0.0 };
    let label = format!("R {}", super::svg::length(bend.value));
    Some(Mark {
        kind: Kind::TightestBend,
        position: branch.position[lower].lerp(&branch.position[upper], t),
        tip: format!("tightest bend, {label}"),
        label,
        weight: f64::INFINITY,
    })
}

/// Draws them, the far ones first.
pub fn draw(page: &mut Svg, marks: &Marks, panel: &Panel) {
    let mut order: Vec<&Mark> = marks.list.iter().collect();
    order.sort_by(|a, b| panel.view.nearness(&a.position).total_cmp(&panel.view.nearness(&b.position)));
    page.open("class=\"marks\" stroke-linejoin=\"round\"");
    for mark in order {
        symbol(page, mark.kind, panel.place(&mark.position), marks.half, &mark.tip);
    }
    page.close();
}

/// One symbol at a place of the page.
pub fn symbol(page: &mut Svg, kind: Kind, [x, y]: [f64; 2], half: f64, tip: &str) {
    let polygon = |points: &[[f64; 2]], r: f64| {
        let corners: Vec<String> =
            points.iter().map(|[u, v]| format!("{},{}", number(x + u * r), number(y + v * r))).collect();
        format!("<polygon points=\"{}\"", corners.join(" "))
    };
    let (cx, cy) = (number(x), number(y));
    let solid = format!("fill=\"{INK}\" stroke=\"#ffffff\" stroke-width=\"1.2\"");
    let shape = match kind {
        Kind::Joint => format!("<circle cx=\"{cx}\" cy=\"{cy}\" r=\"{}\" {solid}", number(0.72 * half)),
        Kind::Connector => {
            format!("{} {solid}", polygon(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]], 0.95 * half))
        }
        Kind::Collar => format!(
            "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"{}\" fill=\"#ffffff\" stroke=\"{INK}\" stroke-width=\"{}\"",
            number(0.82 * half),
            number(0.4 * half)
        ),
        Kind::Handle => format!("{} {solid}", polygon(&[[0.0, -1.15], [1.1, 0.8], [-1.1, 0.8]], 1.05 * half)),
        Kind::OtherConstraint => {
            format!("{} {solid}", polygon(&[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]], 1.25 * half))
        }
        Kind::TightestBend => {
            let r = number(1.45 * half);
            format!(
                "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"{r}\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"1.3\" \
                 stroke-dasharray=\"3.2 2\""
            )
        }
    };
    let tag = if shape.starts_with("<polygon") { "polygon" } else { "circle" };
    page.raw(&format!("{shape} class=\"{}\"><title>{}</title></{tag}>", kind.class(), escape(tip)));
}
