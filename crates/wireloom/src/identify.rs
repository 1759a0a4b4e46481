//! Identification: numbers of a scenario, such as a bending stiffness, from measured points of the real harness.
//!
//! ```
//! use wireloom::identify::{Request, Wishes, identify};
//! use wireloom::scenario::NoFiles;
//! use wireloom::sensitivity::Source;
//!
//! let text = std::fs::read_to_string("../../scenarios/measured/hanging.toml")?;
//! let table = std::fs::read_to_string("../../scenarios/measured/hanging.csv")?;
//! let registry = wireloom::registry();
//! let fit = ["sections.cable.bending_stiffness".to_owned()];
//! let wishes = Wishes { fit: &fit, ..Wishes::default() };
//! let request = Request { tables: &[&table], wishes, ..Request::default() };
//! let found = identify(Source::new(&text, &NoFiles, &registry), &request).expect("it can be carried out");
//! let stiffness = &found.parameters[0];
//! println!("{:?} ± {:?} {}", stiffness.value, stiffness.deviation, stiffness.unit);
//! # assert!(found.is_complete());
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! A table has a line for each measured point: `configuration, marker, x, y, z` (m). A configuration is the end of the
//! step of that name; of a scenario with one step, that step. A marker is one of `[[markers]]`, a joint or a free end;
//! instead of it the columns `branch, s` name a place by its arc length (m). Markers may be missing in some
//! configurations, and an empty cell is a coordinate that was not measured. All tables together are one fit.
//!
//! # Method
//!
//! Every trial carries the scenario out from its beginning, on one mesh; the initial equilibrium is searched for near
//! that of the values from which the fit goes on, if it has one there. Steps are those of Gauss and Newton with the
//! derivatives of [`crate::sensitivity`], damped after Levenberg and Marquardt. Where an equilibrium has no derivatives
//! (contact changes, it is neutral) they are differences of whole runs. A trial that comes to no equilibrium makes the
//! step shorter. The loss is that of Huber: points farther than three times the noise pull with a constant force. The
//! noise of one coordinate is estimated from the residuals, unless it is given. Numbers that are positive (stiffness,
//! length, mass) are fitted by their logarithm. Before the first step, stiffness is also tried at a third, a tenth,
//! three times and ten times its start. Where there are several unknown stiffnesses or curvatures, 16 more starts give
//! each a value of its own (a stiffness within a factor of ten, a curvature within two radians over the longest branch,
//! both within two deviations of their priors), and minima are searched for from the best three: with wrong ratios of
//! stiffnesses a search may end at a minimum that is not the least one.
//!
//! Where a harness has several equilibria, the points tell which one was measured: branches without a `path` are also
//! tried with one through the points of the first measured step. If that comes nearer to the points, it is part of the
//! fitted scenario ([`Identified::drawn`]).
//!
//! # Bending curves
//!
//! A table of a bending test has the columns `load_N, deflection_mm`. The scenario describes the test: one constraint
//! is moved by the steps, in a straight line; its way is the deflection, and the force that it exerts along it the
//! load. The whole path is carried out, so sections may slip and remember, and supports are obstacles that the cable
//! touches. Loads between the increments are linear. Derivatives are differences of whole runs.
//!
//! # Priors
//!
//! Each unknown has a prior: the user's; for values that follow from the wires of a section, the rule with its
//! uncertainty; otherwise a weak one, whose deviation is a factor of ten (numbers that are not positive: one length of
//! the longest branch, or ten radians over it). Points that say anything outweigh a weak prior.
//!
//! # What is not identifiable
//!
//! An unknown is *not identifiable*, and has no [`Estimate::value`], if one of these holds. Prior knowledge does not
//! count here; smoothness does.
//!
//! - Its deviation from the points alone is more than 30 % of its value (numbers that are not positive: 3 % of the
//!   longest branch, 0.3 rad over it, 0.3 rad).
//! - It ended at a bound: without others, 10⁴ times or 10⁻⁴ of its start.
//! - Two deviations away from the fit, with the other unknowns following, the misfit grows by less than a quarter of
//!   what a normal distribution has there: to that side it is open.
//! - Another fit is as good, more than two deviations away: another minimum, or one where an unknown that is not
//!   identifiable is held one deviation (at most a factor of ten) away and the others are fitted again.
//! - There are not more coordinates than unknowns, and the noise is not given.
//!
//! Deviations are those of the linearised problem, with Student's distribution for the interval. Where the residuals of
//! points beside each other are correlated, the model misses something that noise does not explain: deviations are then
//! larger by √((1 + ρ)/(1 − ρ)).

mod answer;
mod bending;
mod drawn;
mod estimates;
mod harness;
mod least_squares;
mod points;
mod shapes;
mod statistics;
mod table;
mod unknowns;

pub use answer::{Configuration, Curve, CurveSample, FitStatus, FittedPoint, Identified, NoFit, Request};
pub use estimates::{Estimate, EstimatePrior, NOT_IDENTIFIABLE};
pub use points::{COLUMNS, MeasuredPlace, MeasuredPoint, PLACE};
pub use unknowns::{Knowledge, Unknown, Wishes};

use crate::sensitivity::Source;

/// Identifies numbers of a scenario from measured points or bending curves.
///
/// # Errors
/// Faults of the scenario or the table, a question that cannot be answered, or no equilibrium to begin with.
pub fn identify(source: Source<'_>, request: &Request<'_>) -> Result<Identified, NoFit> {
    match (request.tables, request.bending) {
        ([], []) => Err(NoFit::Question("nothing was measured: give points, or a bending curve".to_owned())),
        (_, []) => shapes::identify(source, request),
        ([], _) => bending::identify(source, request),
        _ => Err(NoFit::Question("points and bending curves are fitted one after the other".to_owned())),
    }
}
