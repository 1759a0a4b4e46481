//! Computed positions of the measured points as a function of the unknowns.

use super::least_squares::{Computed, Model, Stopped};
use super::points::MeasuredPoint;
use super::unknowns::{Unknown, with_values};
use crate::sensitivity::{NoAnswer, Source, Study};
use nalgebra::{DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use wireloom_core::{StepResult, Vector};
use wireloom_scenario::{Fault, Scenario};
use wireloom_solve::steps::checkpoint::Checkpoint;

/// Step of differences between runs, in units of the unknowns: positions of runs agree to about 1e-7 of the length.
const STEP: f64 = 1e-3;

/// What the work was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Scenarios that were carried out.
    pub solves: usize,
    /// Those among them that came to no equilibrium at one of the measured steps, or were refused.
    pub failed: usize,
    /// Derivatives of one configuration by one unknown.
    pub derivatives: usize,
    /// Those among them that came from differences of runs, because the equilibrium has none.
    pub by_runs: usize,
    /// Those among them that could not be computed, and count as zero.
    pub none: usize,
}

/// A harness with unknowns.
pub struct Harness<'a> {
    /// The scenario; every unknown is written out in its text.
    pub source: Source<'a>,
    /// The scenario whose mesh is kept.
    pub mesh: &'a Scenario,
    /// The unknowns.
    pub unknowns: &'a [Unknown],
    /// The points.
    pub points: &'a [MeasuredPoint],
    /// The work so far.
    pub work: Work,
    /// Why the first derivative that came from differences of runs did.
    pub by_runs_because: Option<String>,
    /// Text and initial equilibrium of the last values from which the fit goes on. Other values are tried from near
    /// there: where a harness has several equilibria, a search from the layout may end in any of them.
    pub reference: Option<Rc<(String, Checkpoint)>>,
    /// Why the last scenario came to no equilibrium.
    pub failure: Option<String>,
}

impl Harness<'_> {
    /// The scenario's text with other values of the unknowns; comments stay.
    ///
    /// # Errors
    /// If a value cannot be written.
    pub fn text(&self, theta: &DVector<f64>) -> Result<String, String> {
        with_values(&self.source.text, self.unknowns, theta, self.source.registry)
    }

    /// The steps that were measured.
    pub fn steps(&self) -> BTreeSet<usize> {
        self.points.iter().map(|point| point.step).collect()
    }

    /// Carries out the scenario up to the last measured step. `None`: it came to no equilibrium there.
    fn study<'t>(&mut self, text: &'t str) -> Result<Option<Study<'t>>, Stopped>
    where
        Self: 't,
    {
        let Source { files, registry, monitor, .. } = self.source.clone();
        self.work.solves += 1;
        let last = self.points.iter().map(|point| point.step).max().unwrap_or(0);
        // The lifetimes of files and registry are longer than that of the text.
        let source = Source { text: text.into(), files, registry, monitor };
        let begun = Study::on_mesh_of(source.clone(), self.mesh).map(|mut study| {
            if let Some((text, start)) = self.reference.as_deref() {
                let other = Study::on_mesh_of(Source { text: text.into(), ..source }, self.mesh);
                other.iter().for_each(|other| study.start_near(other.network(), start));
            }
            study
        });
        let carried = begun.and_then(|mut study| study.run_to(last).map(|()| study));
        match carried {
            Ok(study) => Ok(Some(study)),
            Err(NoAnswer::Stopped) => Err(Stopped),
            Err(reason) => {
                self.work.failed += 1;
                self.failure = Some(match reason {
                    NoAnswer::Faults(faults) => {
                        faults.first().map_or_else(String::new, |Fault { message, .. }| message.clone())
                    }
                    other => other.to_string(),
                });
                Ok(None)
            }
        }
    }

    /// The equilibria at the end of each step up to the last measured one. `None`: there is none.
    ///
    /// # Errors
    /// If it was stopped.
    pub fn ends(&mut self, theta: &DVector<f64>) -> Result<Option<Vec<StepResult>>, Stopped> {
        let Ok(text) = self.text(theta) else { return Ok(None) };
        let study = self.study(&text)?;
        Ok(study.map(|study| study.ends()[1..].iter().map(|ended| ended.end.clone()).collect()))
    }

    /// Computed minus measured coordinates. A run balances forces to its tolerance, which may leave soft cables some
    /// micrometres off: too much for differences. So the positions are those of the nearby equilibrium that is balanced
    /// to round-off, where there is one.
    fn residuals(&self, study: &mut Study<'_>) -> DVector<f64> {
        let mut positions: Vec<Vector> = Vec::with_capacity(self.points.len());
        for point in self.points {
            positions.push(position(&study.ends()[point.step + 1].end, &point.marker));
        }
        for step in self.steps() {
            let outputs = self.outputs(step);
            let increments = study.steps()[step].increments;
            let Ok(balanced) = study.derivatives((step, increments), &outputs, &[]) else { continue };
            for (point, position) in self.points.iter().zip(&mut positions).filter(|(point, _)| point.step == step) {
                for (k, name) in names(point) {
                    let output = balanced.outputs.iter().find(|output| output.name == name);
                    position[k] = output.and_then(|output| output.value).unwrap_or(position[k]);
                }
            }
        }
        let of_point = |(point, computed): (&MeasuredPoint, &Vector)| point.residuals(computed).collect::<Vec<f64>>();
        DVector::from_vec(self.points.iter().zip(&positions).flat_map(of_point).collect())
    }

    /// Names of the coordinates that were measured in a step.
    fn outputs(&self, step: usize) -> Vec<String> {
        let here = self.points.iter().filter(|point| point.step == step);
        let all: BTreeSet<String> = here.flat_map(names).map(|(_, name)| name).collect();
        all.into_iter().collect()
    }

    /// Derivatives of the residuals by θ.
    fn jacobian(
        &mut self,
        study: &mut Study<'_>,
        theta: &DVector<f64>,
        residuals: &DVector<f64>,
    ) -> Result<DMatrix<f64>, Stopped> {
        let mut jacobian = DMatrix::zeros(residuals.len(), self.unknowns.len());
        let mut missing = BTreeSet::new();
        for step in self.steps() {
            self.work.derivatives += self.unknowns.len();
            for (j, reason) in self.derivatives(study, step, theta, &mut jacobian)? {
                missing.insert((j, step));
                self.by_runs_because.get_or_insert(reason);
            }
        }
        self.work.by_runs += missing.len();
        let unknowns: BTreeSet<usize> = missing.iter().map(|(j, _)| *j).collect();
        for j in unknowns {
            let steps: BTreeSet<usize> = missing.iter().filter(|(own, _)| *own == j).map(|(_, step)| *step).collect();
            let Some(column) = self.difference(theta, j, residuals)? else {
                self.work.none += steps.len();
                continue;
            };
            for (i, point) in rows(self.points).filter(|(_, point)| steps.contains(&point.step)) {
                (i..i + point.coordinates()).for_each(|i| jacobian[(i, j)] = column[i]);
            }
        }
        Ok(jacobian)
    }

    /// Derivatives at the end of one step, from equilibria near it. Returns the unknowns for which there are none, and
    /// why.
    fn derivatives(
        &self,
        study: &mut Study<'_>,
        step: usize,
        theta: &DVector<f64>,
        jacobian: &mut DMatrix<f64>,
    ) -> Result<BTreeMap<usize, String>, Stopped> {
        let outputs = self.outputs(step);
        let keys: Vec<String> = self.unknowns.iter().map(|unknown| unknown.key.clone()).collect();
        let increments = study.steps()[step].increments;
        let found =
            study.parameters(&keys).and_then(|parameters| study.derivatives((step, increments), &outputs, &parameters));
        let found = match found {
            Ok(found) => found,
            Err(NoAnswer::Stopped) => return Err(Stopped),
            Err(reason) => return Ok((0..self.unknowns.len()).map(|j| (j, reason.to_string())).collect()),
        };
        let mut missing = BTreeMap::new();
        for (first, point) in rows(self.points).filter(|(_, point)| point.step == step) {
            for (i, (_, name)) in names(point).enumerate() {
                let Some(output) = found.outputs.iter().find(|output| output.name == name) else { continue };
                for (j, derivative) in output.by.iter().enumerate() {
                    match derivative.value {
                        Some(value) => jacobian[(first + i, j)] = value * self.unknowns[j].slope(theta[j]),
                        None => {
                            missing.entry(j).or_insert_with(|| derivative.reason.clone().unwrap_or_default());
                        }
                    }
                }
            }
        }
        Ok(missing)
    }

    /// Difference of runs by an unknown; to one side where there is no equilibrium on the other. `None`: on neither.
    fn difference(
        &mut self,
        theta: &DVector<f64>,
        j: usize,
        residuals: &DVector<f64>,
    ) -> Result<Option<DVector<f64>>, Stopped> {
        let mut at = |h: f64| {
            let mut theta = theta.clone();
            theta[j] += h;
            let Ok(text) = self.text(&theta) else { return Ok(None) };
            let study = self.study(&text)?;
            Ok(study.map(|mut study| self.residuals(&mut study)))
        };
        Ok(match (at(-STEP)?, at(STEP)?) {
            (Some(below), Some(above)) => Some((above - below) / (2.0 * STEP)),
            (Some(below), None) => Some((residuals - below) / STEP),
            (None, Some(above)) => Some((above - residuals) / STEP),
            (None, None) => None,
        })
    }
}

impl Model for Harness<'_> {
    type Reference = Option<Rc<(String, Checkpoint)>>;

    fn reference(&self) -> Self::Reference {
        self.reference.clone()
    }

    fn set_reference(&mut self, reference: Self::Reference) {
        self.reference = reference;
    }

    fn compute(
        &mut self,
        theta: &DVector<f64>,
        wanted: &mut dyn FnMut(&DVector<f64>) -> bool,
    ) -> Result<Computed, Stopped> {
        let Ok(text) = self.text(theta) else { return Ok(None) };
        let Some(mut study) = self.study(&text)? else { return Ok(None) };
        let residuals = self.residuals(&mut study);
        if !residuals.iter().all(|residual| residual.is_finite()) {
            return Ok(None);
        }
        let jacobian = if wanted(&residuals) {
            self.reference = Some(Rc::new((text.clone(), study.ends()[0].checkpoint.clone())));
            Some(self.jacobian(&mut study, theta, &residuals)?)
        } else {
            None
        };
        Ok(Some((residuals, jacobian)))
    }
}

/// The points with the index of their first residual.
pub fn rows(points: &[MeasuredPoint]) -> impl Iterator<Item = (usize, &MeasuredPoint)> {
    points.iter().scan(0, |next, point| {
        let first = *next;
        *next += point.coordinates();
        Some((first, point))
    })
}

/// The coordinates of a point that were measured, each with its name as an output.
fn names(point: &MeasuredPoint) -> impl Iterator<Item = (usize, String)> {
    let axes = ["x", "y", "z"].into_iter().zip(point.position).enumerate();
    let measured = axes.filter(|(_, (_, measured))| measured.is_some());
    measured.map(|(k, (axis, _))| (k, format!("position_{axis}.{}", point.marker)))
}

/// Computed position of a marker or a joint; not a number where there is none.
pub fn position(end: &StepResult, name: &str) -> Vector {
    let marker = end.markers.iter().find(|marker| marker.name == name).map(|marker| marker.position);
    let joint = || end.joints.iter().find(|joint| joint.name == name).map(|joint| joint.position);
    marker.or_else(joint).unwrap_or_else(|| Vector::repeat(f64::NAN))
}
