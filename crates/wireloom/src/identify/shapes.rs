//! Fits of measured points.

use super::answer::{Configuration, FittedPoint, Identified, NoFit, Request};
use super::drawn;
use super::estimates::{Fit, problem};
use super::harness::{self, Harness, position, rows};
use super::least_squares::{self, Minimum, Points, Start, Stopped};
use super::points::{self, MeasuredPlace, MeasuredPoint};
use super::unknowns;
use crate::sensitivity::{Source, Study};
use wireloom_core::{Network, Status, StepResult, Vector};
use wireloom_scenario::record::{self, Attachment};
use wireloom_scenario::{Built, Fault, Scenario};
use wireloom_solve::steps::steps_of;

/// Accuracy of computed positions, relative to the length of all branches.
const ACCURACY: f64 = 1e-7;
/// Distance of points of the same equilibrium, in units of the accuracy of computed positions.
const SAME: f64 = 1e3;
/// Sum of the distances of the points from a drawn start, relative to that from the scenario's own, below which they
/// are other equilibria.
const NEARER: f64 = 0.9;

/// Identifies numbers of a scenario from measured points.
pub fn identify(source: Source<'_>, request: &Request<'_>) -> Result<Identified, NoFit> {
    let loaded = crate::load_with_files(&source.text, source.files, source.registry).map_err(NoFit::Faults)?;
    let points = read_points(request, &loaded.0, &loaded.1)?;
    let text = with_places(&source.text, &points).map_err(|fault| NoFit::Faults(vec![fault]))?;
    let first = Study::new(Source { text: text.into(), ..source.clone() }).map_err(NoFit::from)?;
    let scenario = first.scenario();
    let (unknowns, text) =
        unknowns::unknowns(first.text(), scenario, source.registry, request.wishes).map_err(NoFit::Question)?;
    let smooth = unknowns::smoothness(&unknowns, request.wishes.smooth).map_err(NoFit::Question)?;
    let coordinates: usize = points.iter().map(MeasuredPoint::coordinates).sum();
    if coordinates < unknowns.len() {
        let counts = format!("{coordinates} measured coordinates for {} parameters", unknowns.len());
        return Err(NoFit::Question(format!("{counts}: measure more points, or fit fewer parameters")));
    }
    let total: f64 = scenario.branches.iter().map(|branch| branch.length).sum();
    let ranges = rows(&points).map(|(first, point)| first..first + point.coordinates()).collect();
    let data = Points { ranges, noise: request.noise, least_noise: ACCURACY * total };
    let fit = Fit {
        problem: problem(&unknowns, data, &smooth),
        chains: chains(first.network(), &points),
        unknowns: &unknowns,
        smooth,
    };
    let through_points = drawn::drawn(&text, scenario, &first.network().markers, &points, source.registry);
    let source = Source { text: text.into(), ..source };
    let mut harness = Harness {
        source,
        mesh: scenario,
        unknowns: &unknowns,
        points: &points,
        work: harness::Work::default(),
        by_runs_because: None,
        reference: None,
        failure: None,
    };
    let begun = begin(&fit, &mut harness, through_points);
    let (starts, drawn) = begun.map_err(|Stopped| NoFit::Stopped)?;
    let minimum = least_squares::minimise(&fit.problem, &starts, &mut harness).map_err(|Stopped| NoFit::Stopped)?;
    let Some(mut minimum) = minimum else {
        let reason = harness.failure.unwrap_or_default();
        return Err(NoFit::NoStart { reason, solves: harness.work.solves });
    };
    let names: Vec<String> = first.steps().iter().map(|step| step.name.clone()).collect();
    let shapes = Shapes { fit, points: &points };
    let found = shapes.answer(&mut minimum, &mut harness, &scenario.name, &names)?;
    Ok(Identified { drawn, given_noise: request.noise, ..found })
}

/// Reads the points, with what the scenario has.
fn read_points(request: &Request<'_>, scenario: &Scenario, built: &Built) -> Result<Vec<MeasuredPoint>, NoFit> {
    request.check_noise()?;
    let network = &built.network;
    let steps: Vec<String> = steps_of(&built.schedule).iter().map(|step| step.name.clone()).collect();
    let markers = network.markers.iter().map(|marker| marker.name.clone());
    let markers: Vec<String> = markers.chain(network.joints.iter().map(|joint| joint.name.clone())).collect();
    let vertices = scenario.branches.iter().flat_map(|branch| branch.vertices.iter());
    let ends: Vec<String> = vertices.filter(|name| !markers.contains(name)).cloned().collect();
    let branches: Vec<(String, f64)> =
        scenario.branches.iter().map(|branch| (branch.name.clone(), branch.length)).collect();
    let held = network.constraints.iter().filter_map(|constraint| constraint.position).map(|x| x.norm());
    let reach = branches.iter().map(|(_, length)| length).sum::<f64>() + held.fold(0.0, f64::max);
    let names = points::Names { steps: &steps, markers: &markers, ends: &ends, branches: &branches, reach };
    let mut all = Vec::new();
    for (k, table) in request.tables.iter().enumerate() {
        all.extend(points::read(table, names).map_err(|faults| NoFit::Table(k, faults))?);
    }
    Ok(all)
}

/// The text with a marker at each measured place that has none.
fn with_places(text: &str, points: &[MeasuredPoint]) -> Result<String, Fault> {
    let mut further: Vec<(String, Attachment)> = Vec::new();
    for point in points {
        let at = match &point.place {
            MeasuredPlace::Named => continue,
            MeasuredPlace::End => Attachment::End(point.marker.clone()),
            MeasuredPlace::Along(branch, s) => Attachment::Branch(branch.clone(), *s),
        };
        if further.iter().all(|(name, _)| *name != point.marker) {
            further.push((point.marker.clone(), at));
        }
    }
    if further.is_empty() { Ok(text.to_owned()) } else { record::with_markers(text, &further) }
}

/// The starts of the fit, and the branches that are drawn through the points: the harness gets their text if one of
/// the starts comes nearer to the points from it.
fn begin(
    fit: &Fit<'_>,
    harness: &mut Harness<'_>,
    through_points: Option<(String, Vec<String>)>,
) -> Result<(Vec<Start>, Vec<String>), Stopped> {
    let own = least_squares::starts(&fit.problem, &fit.start(), harness)?;
    let Some((text, names)) = through_points else { return Ok((own, Vec::new())) };
    let undrawn = std::mem::replace(&mut harness.source.text, text.into());
    let drawn = least_squares::starts(&fit.problem, &fit.start(), harness)?;
    let nearest = |starts: &[Start]| starts.iter().map(|start| start.distance).fold(f64::INFINITY, f64::min);
    if nearest(&drawn) < NEARER * nearest(&own) {
        return Ok((drawn, names));
    }
    harness.source.text = undrawn;
    Ok((own, Vec::new()))
}

/// Points that lie beside each other on one branch in one configuration, in order.
fn chains(network: &Network, points: &[MeasuredPoint]) -> Vec<Vec<usize>> {
    let mut placed: Vec<(&str, usize, f64, usize)> = Vec::new();
    for (k, point) in points.iter().enumerate() {
        if let Some(marker) = network.markers.iter().find(|marker| marker.name == point.marker) {
            placed.push((&point.configuration, marker.branch, marker.s, k));
        }
    }
    placed.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    let together = placed.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    together.map(|chain| chain.iter().map(|(.., k)| *k).collect()).collect()
}

/// A fit of points.
struct Shapes<'f> {
    fit: Fit<'f>,
    points: &'f [MeasuredPoint],
}

impl Shapes<'_> {
    fn answer(
        &self,
        at: &mut Minimum,
        harness: &mut Harness<'_>,
        scenario: &str,
        steps: &[String],
    ) -> Result<Identified, NoFit> {
        let (statistics, parameters) = self.fit.estimates(at, harness);
        // A monitor that has stopped the fit would stop this one, too; what was computed is not lost.
        harness.source.monitor = wireloom_core::Monitor::default();
        let ends = harness.ends(&at.theta).map_err(|Stopped| NoFit::Stopped)?.unwrap_or_default();
        // Users carry the fitted scenario out from its beginning.
        harness.reference = None;
        let anew = harness.ends(&at.theta).map_err(|Stopped| NoFit::Stopped)?.unwrap_or_default();
        let same = at.scale.max(SAME * self.fit.problem.points.least_noise);
        let comes_again = |point: &MeasuredPoint| {
            let [one, other] = [&ends, &anew].map(|all| all.get(point.step).map(|end| position(end, &point.marker)));
            one.zip(other).is_some_and(|(one, other)| (one - other).norm() <= same)
        };
        let configurations = self.configurations(at, &ends, steps);
        let settled = configurations.iter().all(|own| own.status == Status::Converged.word());
        let text = harness.text(&at.theta).map_err(NoFit::Question)?;
        let work = harness.work;
        Ok(Identified {
            repeatable: self.points.iter().all(comes_again),
            configurations,
            ends,
            solves: work.solves,
            failed_solves: work.failed,
            derivatives: work.derivatives,
            derivatives_by_runs: work.by_runs,
            by_runs_because: harness.by_runs_because.clone(),
            derivatives_missing: work.none,
            ..Identified::of(scenario, at, &statistics, parameters, settled, text)
        })
    }

    fn configurations(&self, at: &Minimum, ends: &[StepResult], steps: &[String]) -> Vec<Configuration> {
        let mut all: Vec<Configuration> = Vec::new();
        for (k, point) in self.points.iter().enumerate() {
            let end = ends.get(point.step);
            let found = all.iter().position(|own| own.name == point.configuration);
            let own = found.unwrap_or_else(|| {
                all.push(Configuration {
                    name: point.configuration.clone(),
                    step: steps[point.step].clone(),
                    status: end.map_or(Status::Interrupted, |end| end.status).word(),
                    mean_distance: 0.0,
                    rms_distance: 0.0,
                    largest_distance: 0.0,
                    points: Vec::new(),
                });
                all.len() - 1
            });
            let mut computed = end.map_or_else(|| Vector::repeat(f64::NAN), |end| position(end, &point.marker));
            let mut rest = self.fit.problem.points.ranges[k].clone();
            for (axis, measured) in point.position.iter().enumerate() {
                let Some(measured) = measured else { continue };
                computed[axis] = measured + rest.next().map_or(0.0, |i| at.residuals[i]);
            }
            all[own].points.push(FittedPoint {
                marker: point.marker.clone(),
                measured: point.position,
                computed: [computed.x, computed.y, computed.z],
                distance: self.fit.problem.points.distance(k, &at.residuals),
                weight: self.fit.problem.points.weight(k, &at.residuals, at.scale),
            });
        }
        for own in &mut all {
            let n = own.points.len() as f64;
            let distances = || own.points.iter().map(|point| point.distance);
            (own.mean_distance, own.rms_distance, own.largest_distance) = (
                distances().sum::<f64>() / n,
                (distances().map(|d| d * d).sum::<f64>() / n).sqrt(),
                distances().fold(0.0, f64::max),
            );
        }
        all
    }
}
