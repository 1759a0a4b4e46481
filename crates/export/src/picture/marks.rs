//! Symbols of joints, constraints, the tightest bend, and requirements that fail or are unresolved.

use super::colour::{INK, OVER, UNRESOLVED};
use super::layout::Panel;
use super::svg::{Svg, number, significant};
use super::view::visible;
use crate::sheet::sentence;
use crate::xml::escape;
use wireloom_core::equilibrium::{BranchResult, RequirementResult};
use wireloom_core::requirement::{Measure, Origin, Verdict};
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
    Failed,
    Unresolved,
}

impl Kind {
    /// In the order of the legend.
    pub const ALL: [Kind; 8] = [
        Kind::Connector,
        Kind::Collar,
        Kind::Handle,
        Kind::OtherConstraint,
        Kind::Joint,
        Kind::TightestBend,
        Kind::Failed,
        Kind::Unresolved,
    ];

    /// Colour of its name.
    pub fn ink(self) -> &'static str {
        match self {
            Kind::Failed => OVER,
            Kind::Unresolved => UNRESOLVED,
            _ => INK,
        }
    }

    /// Whether its name goes before those of constraints.
    pub fn is_urgent(self) -> bool {
        matches!(self, Kind::TightestBend | Kind::Failed | Kind::Unresolved)
    }

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
            Kind::Failed => "fails",
            Kind::Unresolved => "unresolved",
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
            Kind::Failed => "requirement fail",
            Kind::Unresolved => "requirement unresolved",
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
/// Requirements that are named; of more, the others have a symbol only.
const NAMED: usize = 12;

/// Symbols of an equilibrium; `open`: the requirements that fail or are unresolved, the most urgent first.
pub fn collect(step: &StepResult, open: &[&RequirementResult]) -> Marks {
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
    let bend = tightest(step).filter(|_| !open.iter().any(|line| is_tightest(step, line)));
    list.extend(bend);
    for (k, line) in open.iter().enumerate() {
        list.extend(position(step, line).map(|position| requirement(step, line, position, k)));
    }
    list.retain(|mark| visible(&mark.position));
    let half = if list.len() > MANY { 3.6 } else { 5.6 };
    Marks { list, half }
}

/// The tightest bend, at its place on its branch.
fn tightest(step: &StepResult) -> Option<Mark> {
    let bend = step.min_bend_radius.as_ref()?;
    let branch = step.branches.iter().find(|branch| branch.name == bend.branch)?;
    let position = along(branch, bend.s)?;
    let label = format!("R {}", super::svg::length(bend.value));
    Some(Mark { kind: Kind::TightestBend, position, tip: format!("tightest bend, {label}"), label, weight: URGENT })
}

/// Weight of the first of the names that go before those of constraints; the next ones have less.
const URGENT: f64 = 1e300;

/// The point of a branch at an arc length.
fn along(branch: &BranchResult, at: f64) -> Option<Vector> {
    let upper = branch.s.partition_point(|s| *s < at).min(branch.s.len().checked_sub(1)?);
    let lower = upper.saturating_sub(1);
    let span = branch.s[upper] - branch.s[lower];
    let t = if span > 0.0 { ((at - branch.s[lower]) / span).clamp(0.0, 1.0) } else { 0.0 };
    Some(branch.position[lower].lerp(&branch.position[upper], t))
}

/// Whether a requirement is about the tightest bend of this equilibrium, which needs no second symbol.
fn is_tightest(step: &StepResult, line: &RequirementResult) -> bool {
    let same = |bend: &wireloom_core::equilibrium::TightestBend| {
        line.place.branch.as_ref() == Some(&bend.branch) && line.worst == Some(bend.value)
    };
    line.measure == Measure::BendRadius && step.min_bend_radius.as_ref().is_some_and(same)
}

/// The place of a requirement in this shape: a constraint that acts, or a point of a branch (its middle, where the
/// whole of it is meant).
fn position(step: &StepResult, line: &RequirementResult) -> Option<Vector> {
    let place = &line.place;
    let constraint = step.constraints.iter().find(|constraint| place.constraint.as_ref() == Some(&constraint.name));
    if let Some(constraint) = constraint {
        return Some(constraint.position);
    }
    let branch = step.branches.iter().find(|branch| place.branch.as_ref() == Some(&branch.name))?;
    along(branch, place.s.unwrap_or(0.5 * branch.s.last()?))
}

/// The symbol of requirement `k` of those that fail or are unresolved.
fn requirement(step: &StepResult, line: &RequirementResult, position: Vector, k: usize) -> Mark {
    let kind = if line.verdict == Verdict::Fail { Kind::Failed } else { Kind::Unresolved };
    let when = line.moment.as_ref().filter(|moment| moment.step != step.name);
    let when = when.map_or_else(String::new, |moment| format!(" (in step {})", moment.step));
    // A limit of a part has the name of the part.
    let of_part = matches!(line.origin, Origin::Section | Origin::Constraint | Origin::Obstacle);
    let quantity = if of_part { format!(", {}", line.measure.title()) } else { String::new() };
    let words = format!("{}{quantity}: {}{when}", line.name, sentence(line));
    Mark {
        kind,
        position,
        tip: format!("{} {}, {words}", line.measure.title(), kind.words()),
        label: if k < NAMED { words } else { String::new() },
        weight: URGENT / (k + 2) as f64,
    }
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
        Kind::Failed | Kind::Unresolved => {
            let (r, width, ink) = (number(1.7 * half), if kind == Kind::Failed { 2.6 } else { 1.8 }, kind.ink());
            let ring = format!("<circle cx=\"{cx}\" cy=\"{cy}\" r=\"{r}\" fill=\"none\"");
            // A white rim, so that it is seen on a cable of its own colour.
            page.raw(&format!("{ring} stroke=\"#ffffff\" stroke-width=\"{}\"/>", number(width + 2.4)));
            format!("{ring} stroke=\"{ink}\" stroke-width=\"{}\"", number(width))
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
