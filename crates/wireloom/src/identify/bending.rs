//! Bending curves: the load of a test over its deflection, measured and computed.

use super::answer::{Curve, CurveSample, Identified, NoFit, Request};
use super::estimates::{Fit, problem};
use super::least_squares::{self, Computed, Model, Points, Stopped};
use super::table::{self, fault};
use super::unknowns::{self, Unknown, with_values};
use crate::sensitivity::{NoAnswer, Source, Study};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;
use std::ops::Range;
use wireloom_core::{StepResult, Vector};
use wireloom_scenario::{Fault, Scenario};

/// Step of differences between runs, in units of the unknowns: loads of runs agree to about 1e-6 of them.
const STEP: f64 = 1e-3;
/// Accuracy of computed loads, relative to the largest one.
const ACCURACY: f64 = 1e-5;
/// Way back of the deflection, relative to the stroke, that is noise.
const WAY_BACK: f64 = 0.01;
/// Help where the form of a table is wrong.
const HELP: &str = "write the line `load_N,deflection_mm`, then one line for each sample";

/// Measured deflection (m) and load (N).
type Sample = [f64; 2];

/// Reads a table with the columns `load_N, deflection_mm`.
///
/// # Errors
/// All faults, with their places in the text.
fn read(text: &str) -> Result<Vec<Sample>, Vec<Fault>> {
    let table = table::read(text, HELP)?;
    let mut faults = table.faults;
    let column = |name: &str| table.headers.iter().position(|own| own == name);
    let (Some(load), Some(deflection), 2) = (column("load_N"), column("deflection_mm"), table.headers.len()) else {
        let found: Vec<&str> = table.headers.iter().collect();
        let message = format!("the columns are `{}`, not `load_N,deflection_mm`", found.join(","));
        return Err(vec![fault(table.header_line, message, HELP.to_owned())]);
    };
    let mut samples: Vec<(Sample, Range<usize>)> = Vec::new();
    for (line, record) in &table.records {
        let cell = |k: usize| record.get(k).and_then(|cell| cell.parse::<f64>().ok()).filter(|x| x.is_finite());
        match (cell(deflection), cell(load)) {
            (Some(deflection), Some(load)) => samples.push(([1e-3 * deflection, load], line.clone())),
            _ => {
                let message = format!("`{}` are not two finite numbers", record.iter().collect::<Vec<_>>().join(","));
                faults.push(fault(line.clone(), message, "write a load in N and a deflection in mm".to_owned()));
            }
        }
    }
    if samples.is_empty() && faults.is_empty() {
        faults.push(fault(table.header_line, "the table has no samples".to_owned(), HELP.to_owned()));
    }
    let stroke = samples.iter().map(|([deflection, _], _)| *deflection).fold(0.0, f64::max);
    let mut reached = f64::NEG_INFINITY;
    for ([deflection, _], line) in &samples {
        reached = reached.max(*deflection);
        if *deflection < reached - WAY_BACK * stroke {
            let message = format!("the deflection goes back to {} mm from {} mm", 1e3 * deflection, 1e3 * reached);
            let help = "cut the table before the way back: a curve goes one way";
            faults.push(fault(line.clone(), message, help.to_owned()));
            break;
        }
    }
    if faults.is_empty() { Ok(samples.into_iter().map(|(sample, _)| sample).collect()) } else { Err(faults) }
}

/// What pushes in a test.
#[derive(Clone, Debug)]
struct Indenter {
    /// Index of its constraint.
    constraint: usize,
    /// Where it is at the start, m.
    from: Vector,
    /// Direction in which it goes.
    along: Vector,
    /// How far, m.
    stroke: f64,
}

/// The constraint that the steps move, and how far it goes.
fn indenter(study: &mut Study<'_>) -> Result<Indenter, NoFit> {
    let moved: BTreeSet<usize> = study
        .steps()
        .iter()
        .flat_map(|step| &step.moves)
        .flat_map(|own| own.carried.iter().map(|carried| carried.constraint))
        .collect();
    let names: Vec<String> = moved.iter().map(|k| study.network().constraints[*k].name.clone()).collect();
    let &[constraint] = moved.into_iter().collect::<Vec<_>>().as_slice() else {
        let which = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        return Err(NoFit::Question(format!(
            "in a bending test one constraint is moved, whose force is the load: here {which}"
        )));
    };
    let path = study.whole_path().map_err(|reason| match reason {
        NoAnswer::Stopped => NoFit::Stopped,
        NoAnswer::NotConverged { .. } => NoFit::NoStart { reason: reason.to_string(), solves: 1 },
        other => other.into(),
    })?;
    let name = &names[0];
    let at = |end: Option<&StepResult>| end.and_then(|end| place(end, name)).map(|(position, _)| position);
    let (Some(from), Some(to)) = (at(path.first()), at(path.last())) else {
        return Err(NoFit::Question(format!("`{name}` must hold the cable from the start to the end of the test")));
    };
    let stroke = (to - from).norm();
    if stroke == 0.0 {
        return Err(NoFit::Question(format!("`{name}` ends where it begins: there is no deflection")));
    }
    Ok(Indenter { constraint, from, along: (to - from) / stroke, stroke })
}

/// Held point and force of a constraint.
fn place(end: &StepResult, name: &str) -> Option<(Vector, Vector)> {
    end.constraints.iter().find(|own| own.name == name).map(|own| (own.position, own.force))
}

/// A test with unknowns.
struct Rig<'a> {
    source: Source<'a>,
    mesh: &'a Scenario,
    unknowns: &'a [Unknown],
    indenter: Indenter,
    name: String,
    samples: Vec<Sample>,
    /// Runs, and those among them that came to no equilibrium or were refused.
    solves: usize,
    failed: usize,
    derivatives: usize,
    missing: usize,
    failure: String,
}

impl Rig<'_> {
    /// Deflection and load at the start and the end of each increment. `None`: it did not come to the end.
    fn curve(&mut self, theta: &DVector<f64>) -> Result<Option<Vec<[f64; 2]>>, Stopped> {
        let Source { files, registry, monitor, .. } = self.source.clone();
        let Ok(text) = with_values(&self.source.text, self.unknowns, theta, registry) else { return Ok(None) };
        self.solves += 1;
        let source = Source { text: text.into(), files, registry, monitor };
        let path = Study::on_mesh_of(source, self.mesh).and_then(|mut study| study.whole_path());
        let path = match path {
            Ok(path) => path,
            Err(NoAnswer::Stopped) => return Err(Stopped),
            Err(reason) => {
                self.failed += 1;
                self.failure = reason.to_string();
                return Ok(None);
            }
        };
        let Indenter { from, along, .. } = &self.indenter;
        let sample = |end: &StepResult| {
            place(end, &self.name).map(|(position, force)| [(position - from).dot(along), force.dot(along)])
        };
        Ok(path.iter().map(sample).collect())
    }

    /// Computed less measured loads, N.
    fn residuals(&mut self, theta: &DVector<f64>) -> Result<Option<DVector<f64>>, Stopped> {
        let Some(curve) = self.curve(theta)? else { return Ok(None) };
        let loads = self.samples.iter().map(|[deflection, load]| load_at(&curve, *deflection) - load);
        Ok(Some(DVector::from_iterator(self.samples.len(), loads)))
    }

    fn column(&mut self, theta: &DVector<f64>, j: usize, here: &DVector<f64>) -> Result<Option<DVector<f64>>, Stopped> {
        let mut at = |h: f64| {
            let mut theta = theta.clone();
            theta[j] += h;
            self.residuals(&theta)
        };
        Ok(match (at(-STEP)?, at(STEP)?) {
            (Some(below), Some(above)) => Some((above - below) / (2.0 * STEP)),
            (Some(below), None) => Some((here - below) / STEP),
            (None, Some(above)) => Some((above - here) / STEP),
            (None, None) => None,
        })
    }
}

impl Model for Rig<'_> {
    type Reference = ();

    fn reference(&self) {}

    fn set_reference(&mut self, (): ()) {}

    fn compute(
        &mut self,
        theta: &DVector<f64>,
        wanted: &mut dyn FnMut(&DVector<f64>) -> bool,
    ) -> Result<Computed, Stopped> {
        let Some(residuals) = self.residuals(theta)? else { return Ok(None) };
        if !residuals.iter().all(|residual| residual.is_finite()) {
            return Ok(None);
        }
        if !wanted(&residuals) {
            return Ok(Some((residuals, None)));
        }
        let mut jacobian = DMatrix::zeros(residuals.len(), self.unknowns.len());
        for j in 0..self.unknowns.len() {
            self.derivatives += 1;
            match self.column(theta, j, &residuals)? {
                Some(column) => jacobian.set_column(j, &column),
                None => self.missing += 1,
            }
        }
        Ok(Some((residuals, Some(jacobian))))
    }
}

/// Load at a deflection, linear between the increments; that of the start before it.
fn load_at(curve: &[[f64; 2]], deflection: f64) -> f64 {
    let k = curve.iter().position(|own| own[0] >= deflection).unwrap_or(curve.len() - 1);
    if k == 0 {
        return curve[0][1];
    }
    let ([d0, f0], [d1, f1]) = (curve[k - 1], curve[k]);
    if d1 > d0 { f0 + (f1 - f0) * (deflection - d0) / (d1 - d0) } else { f1 }
}

/// Identifies numbers of a scenario from bending curves.
pub fn identify(source: Source<'_>, request: &Request<'_>) -> Result<Identified, NoFit> {
    request.check_noise()?;
    let mut first = Study::new(source.clone()).map_err(NoFit::from)?;
    let (unknowns, text) =
        unknowns::unknowns(&source.text, first.scenario(), source.registry, request.wishes).map_err(NoFit::Question)?;
    let smooth = unknowns::smoothness(&unknowns, request.wishes.smooth).map_err(NoFit::Question)?;
    let tables = request.bending.iter().enumerate();
    let tables: Vec<Vec<Sample>> =
        tables.map(|(k, table)| read(table).map_err(|faults| NoFit::Table(k, faults))).collect::<Result<_, _>>()?;
    let indenter = indenter(&mut first)?;
    let within = |own: &&Sample| own[0] <= indenter.stroke;
    let samples: Vec<Vec<Sample>> = tables.iter().map(|all| all.iter().filter(within).copied().collect()).collect();
    let all: Vec<Sample> = samples.concat();
    if all.len() < unknowns.len() {
        let within = format!("{} samples up to {:.3} mm", all.len(), 1e3 * indenter.stroke);
        return Err(NoFit::Question(format!("{within} for {} parameters: measure more", unknowns.len())));
    }
    let largest = all.iter().map(|[_, load]| load.abs()).fold(0.0, f64::max);
    let data = Points {
        ranges: (0..all.len()).map(|k| k..k + 1).collect(),
        noise: request.noise,
        least_noise: ACCURACY * largest,
    };
    let ends: Vec<usize> = samples.iter().scan(0, |end, own| Some(std::mem::replace(end, *end + own.len()))).collect();
    let chains = ends.iter().zip(&samples).map(|(start, own)| (*start..start + own.len()).collect());
    let fit = Fit { problem: problem(&unknowns, data, &smooth), chains: chains.collect(), unknowns: &unknowns, smooth };
    let mut rig = Rig {
        source: Source { text: text.into(), ..source },
        mesh: first.scenario(),
        unknowns: &unknowns,
        name: first.network().constraints[indenter.constraint].name.clone(),
        indenter,
        samples: all,
        solves: 0,
        failed: 0,
        derivatives: 0,
        missing: 0,
        failure: String::new(),
    };
    let minimum = least_squares::starts(&fit.problem, &fit.start(), &mut rig)
        .and_then(|starts| least_squares::minimise(&fit.problem, &starts, &mut rig))
        .map_err(|Stopped| NoFit::Stopped)?;
    let Some(mut at) = minimum else { return Err(NoFit::NoStart { reason: rig.failure, solves: rig.solves }) };
    let (statistics, parameters) = fit.estimates(&mut at, &mut rig);
    // A monitor that has stopped the fit would stop this one, too; what was computed is not lost.
    rig.source.monitor = wireloom_core::Monitor::default();
    let computed = rig.curve(&at.theta).map_err(|Stopped| NoFit::Stopped)?.unwrap_or_default();
    let curve = |(k, (start, own)): (usize, (usize, &Vec<Sample>))| {
        let sample = |(i, [deflection, measured]): (usize, &Sample)| CurveSample {
            deflection: *deflection,
            measured: *measured,
            computed: measured + at.residuals[start + i],
            weight: fit.problem.points.weight(start + i, &at.residuals, at.scale),
        };
        let samples: Vec<CurveSample> = own.iter().enumerate().map(sample).collect();
        let mean = |of: &dyn Fn(&CurveSample) -> f64| {
            (samples.iter().map(|own| of(own).powi(2)).sum::<f64>() / samples.len() as f64).sqrt()
        };
        let rms = mean(&|own| own.computed - own.measured);
        let relative = rms / mean(&|own| own.measured);
        let beyond = tables[k].len() - own.len();
        Curve { table: k, beyond, rms, relative, samples, computed: computed.clone() }
    };
    let curves: Vec<Curve> = ends.into_iter().zip(&samples).enumerate().map(curve).collect();
    let text = with_values(&rig.source.text, &unknowns, &at.theta, rig.source.registry).map_err(NoFit::Question)?;
    let settled = !computed.is_empty();
    Ok(Identified {
        curves,
        given_noise: request.noise,
        solves: rig.solves,
        failed_solves: rig.failed,
        derivatives: rig.derivatives,
        derivatives_by_runs: rig.derivatives,
        derivatives_missing: rig.missing,
        ..Identified::of(&first.scenario().name, &at, &statistics, parameters, settled, text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_loads_are_read_and_their_faults_have_lines() {
        let samples = read("deflection_mm,load_N\n0,0.1\n# contact\n1.5,2\n").expect("no faults");
        assert_eq!(samples, [[0.0, 0.1], [1.5e-3, 2.0]]);
        let says = |text: &str, line: usize, words: &str| {
            let faults = read(text).expect_err("a fault");
            let found = faults.iter().any(|fault| fault.position(text).0 == line && fault.message.contains(words));
            assert!(found, "{faults:?}");
        };
        says("load,deflection\n1,2\n", 1, "the columns are `load,deflection`");
        says("load_N,deflection_mm\n1,2\n1,two\n", 3, "not two finite numbers");
        says("load_N,deflection_mm\n1,2\n1\n", 3, "this line has 1 cells");
        says("load_N,deflection_mm\n1,2\n2,3\n1,2\n", 4, "goes back to 2 mm from 3 mm");
        says("load_N,deflection_mm\n", 1, "no samples");
    }

    #[test]
    fn loads_between_increments_are_linear() {
        let curve = [[0.0, 0.5], [1.0, 2.5], [2.0, 3.5]];
        let loads = [-1.0, 0.0, 0.5, 1.0, 1.25, 2.0].map(|deflection| load_at(&curve, deflection));
        assert_eq!(loads, [0.5, 0.5, 1.5, 2.5, 2.75, 3.5]);
    }
}
