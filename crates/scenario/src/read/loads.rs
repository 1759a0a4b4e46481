//! Reads loads.

use super::entry::Entry;
use super::names::{Names, register};
use super::places::{attachment, stretch};
use crate::attachment::{At, Stretch};
use crate::scenario::Load;
use std::sync::Arc;
use wireloom_core::Vector;
use wireloom_core::load::{Dead, DeadLine, Flow, Follower, FollowerLine, LineLoad, LoadAction, PointLoad};

/// Density of air at 20 °C, kg/m³.
const AIR: f64 = 1.2;
/// Drag coefficient of a smooth cylinder at Reynolds numbers from 10³ to 2·10⁵ (Hoerner 1965, Fluid-Dynamic Drag).
const CYLINDER: f64 = 1.2;

/// A load. `None` if it has no name of its own; marks the names as broken if it attaches to nothing.
pub(crate) fn load<'a>(entry: &Entry<'a>, names: &mut Names<'a>) -> Option<Load> {
    let index = names.loads.len();
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, &mut names.loads, name, index));
    let factor = entry.number("factor").unwrap_or(1.0);
    if entry.has("at") && entry.has("span") {
        let help = "forces act `at` a place, forces per length and flows along a `span`: make two loads of them";
        entry.fault_at("span", format!("{} has `at` and `span`", entry.label), help);
    }
    let follows = entry.flag("follows").unwrap_or(false);
    let (at_place, along) = (at_place(entry, follows, names), along(entry, follows, names));
    let action = if entry.has("span") { along } else { at_place };
    names.broken |= name.is_none() || action.is_none();
    let nowhere = || LoadAction::Along { spans: Vec::new(), load: Arc::new(DeadLine(Vector::zeros())) };
    let action = action.unwrap_or_else(nowhere);
    Some(Load { name: name?.to_owned(), action, factor, spans: entry.spans() })
}

/// Force and moment at a place.
fn at_place(entry: &Entry<'_>, follows: bool, names: &Names<'_>) -> Option<LoadAction<At, Stretch>> {
    let place = entry.entry("at").and_then(|at| attachment(&at, names, false)).map(|place| place.0);
    let force = entry.vector("force").unwrap_or_default();
    let moment = entry.vector("moment").unwrap_or_default();
    if entry.has("at") && !entry.has("force") && !entry.has("moment") {
        let message = format!("{} has neither `force` nor `moment`", entry.label);
        entry.fault_here(message, "give one of them, such as force = [0, 0, -2] in N");
    }
    let load: Arc<dyn PointLoad> =
        if follows { Arc::new(Follower { force, moment }) } else { Arc::new(Dead { force, moment }) };
    place.map(|place| LoadAction::At { place, load })
}

/// Force per length or flow along parts of branches.
fn along(entry: &Entry<'_>, follows: bool, names: &Names<'_>) -> Option<LoadAction<At, Stretch>> {
    let given = entry.one_or_more("span");
    let spans: Vec<Stretch> = given.iter().filter_map(|span| stretch(span, names)).collect();
    let (force, flow) = (entry.vector("force_per_length"), entry.entry("flow").map(|flow| read_flow(&flow)));
    for key in ["force", "moment"].into_iter().filter(|key| entry.has("span") && entry.has(key)) {
        let message = format!("{} has `{key}` and a `span`", entry.label);
        entry.fault_at(key, message, "give a `force_per_length` along the span, or `at` for a place");
    }
    match (entry.has("span"), entry.has("force_per_length"), entry.has("flow")) {
        (true, false, false) => {
            let message = format!("{} has neither `force_per_length` nor `flow`", entry.label);
            entry.fault_at("span", message, "give one of them, such as flow = { velocity = [20, 0, 0] } in m/s");
        }
        (true, true, true) => {
            let message = format!("{} has `force_per_length` and `flow`", entry.label);
            entry.fault_at("flow", message, "make two loads of them");
        }
        (true, false, true) if follows => {
            let message = format!("{} is a flow, which does not turn with the cable", entry.label);
            entry.fault_at("follows", message, "leave `follows` out: the drag depends on the direction of the cable");
        }
        _ => {}
    }
    let load: Arc<dyn LineLoad> = match (force, flow) {
        (Some(force), _) if follows => Arc::new(FollowerLine(force)),
        (Some(force), _) => Arc::new(DeadLine(force)),
        (None, flow) => Arc::new(flow??),
    };
    (spans.len() == given.len()).then_some(LoadAction::Along { spans, load })
}

fn read_flow(entry: &Entry<'_>) -> Option<Flow> {
    let velocity = entry.vector("velocity");
    let (density, coefficient) = (entry.number("density"), entry.number("drag_coefficient"));
    let drag = 0.5 * density.unwrap_or(AIR) * coefficient.unwrap_or(CYLINDER);
    Some(Flow { velocity: velocity?, drag })
}
