//! Gradients of a design: derivatives of equilibria where they exist, differences of further runs where they do not.

use super::evaluation::{Evaluation, Line, smooth};
use super::{Kind, NoOptimum, Search};
use crate::sensitivity::{NoAnswer, Output, Parameter};
use nalgebra::DVector;
use std::collections::BTreeSet;
use wireloom_scenario::Setting;

/// Constraints that are kept by more than this (relative to their limits) are not in the model.
const FAR: f64 = 0.95;
/// Difference of the worst value and of that at the end of its increment, relative to it, up to which it is the same.
const SAME: f64 = 1e-3;
/// Step of differences of runs, as a fraction of the range.
const STEP: f64 = 1e-3;
/// Step of differences of lengths and masses, as a fraction of the range.
const LENGTH_STEP: f64 = 1e-4;

impl<'a> Search<'a> {
    /// Finds the gradients of a design; with `by_runs` of further runs alone.
    ///
    /// # Errors
    /// If it was stopped.
    pub(super) fn differentiate(&mut self, design: &mut Evaluation<'a>, by_runs: bool) -> Result<(), NoOptimum> {
        design.smooth_gradient = Some(self.smooth_gradient(design));
        let n = self.ranges.len();
        let asked: Vec<bool> = design.lines.iter().map(|line| self.is_in_model(line)).collect();
        // Of each line in the model the derivatives by the variables, as far as they are known.
        let mut known: Vec<Vec<Option<f64>>> = vec![vec![None; n]; design.lines.len()];
        if !by_runs {
            self.at_equilibria(design, &asked, &mut known)?;
        }
        for k in 0..n {
            let missing = |(asked, known): (&bool, &Vec<Option<f64>>)| *asked && known[k].is_none();
            if asked.iter().zip(&known).any(missing) {
                self.by_a_run(design, k, &asked, &mut known)?;
            }
        }
        for ((line, asked), known) in design.lines.iter_mut().zip(asked).zip(known) {
            // A requirement that is not checked beside the design, or a run that fails there, has no slope.
            let gradient = || DVector::from_iterator(n, known.iter().map(|slope| slope.unwrap_or(0.0)));
            line.gradient = asked.then(gradient);
        }
        Ok(())
    }

    fn is_in_model(&self, line: &Line) -> bool {
        let minimised = || {
            let lines = std::slice::from_ref(line);
            self.optimise.terms.iter().any(|term| super::evaluation::counted(lines, &term.of).next().is_some())
        };
        line.must && line.kept < FAR || minimised()
    }

    /// Gradient of lengths and masses, which need no equilibrium.
    fn smooth_gradient(&self, design: &Evaluation<'_>) -> DVector<f64> {
        let slope = |(k, range): (usize, &super::Range)| {
            let h = LENGTH_STEP * (range.to - range.from);
            let at = |value: f64| {
                let setting = [Setting::number(&range.key, value)];
                let loaded = crate::load_with_settings(&design.text, &setting, self.files, self.registry).ok()?;
                Some(smooth(&self.optimise, &loaded.1.network))
            };
            let value = design.values[k];
            // At the end of a range that the format does not exceed, to one side.
            let [below, above] = [at(value - h), at(value + h)];
            let (one, other) =
                (below.map_or((design.smooth, 0.0), |x| (x, h)), above.map_or((design.smooth, 0.0), |x| (x, h)));
            let wide = one.1 + other.1;
            if wide > 0.0 { (other.0 - one.0) / wide * (range.to - range.from) } else { 0.0 }
        };
        DVector::from_iterator(self.ranges.len(), self.ranges.iter().enumerate().map(slope))
    }

    /// Derivatives of the equilibria in which requirements are at their worst.
    fn at_equilibria(
        &mut self,
        design: &mut Evaluation<'a>,
        asked: &[bool],
        known: &mut [Vec<Option<f64>>],
    ) -> Result<(), NoOptimum> {
        let keys: Vec<String> = self.ranges.iter().map(|range| range.key.clone()).collect();
        let Ok(parameters) = design.study.parameters(&keys) else { return Ok(()) };
        let moments: BTreeSet<(usize, usize)> = design
            .lines
            .iter()
            .zip(asked)
            .filter(|(_, asked)| **asked)
            .map(|(line, _)| (line.step, line.increment))
            .collect();
        for moment in moments {
            let here = |(k, line): (usize, &Line)| (asked[k] && (line.step, line.increment) == moment).then_some(k);
            let lines: Vec<usize> = design.lines.iter().enumerate().filter_map(here).collect();
            let all = &design.study.network().requirements;
            let names: Vec<String> = lines.iter().map(|k| all[design.lines[*k].requirement].name.clone()).collect();
            let found = match design.study.derivatives(moment, &names, &parameters) {
                Ok(found) => found,
                Err(NoAnswer::Stopped) => return Err(NoOptimum::Stopped),
                // Further runs tell then.
                Err(_) => continue,
            };
            self.counts.gradients += 1;
            self.keeps_history |= found.keeps_history;
            for (k, output) in lines.into_iter().zip(&found.outputs) {
                let line = &design.lines[k];
                // A worst value on the way through an increment is not that of the equilibrium at its end.
                let same = output.value.is_some_and(|value| (value - line.worst).abs() <= SAME * line.worst.abs());
                if same {
                    for (slot, slope) in known[k].iter_mut().zip(self.slopes(output, &parameters)) {
                        *slot = slope;
                    }
                }
            }
        }
        Ok(())
    }

    /// Derivatives of an output by the scaled variables; at a kink the mean of both sides.
    fn slopes(&self, output: &Output, parameters: &[Parameter]) -> Vec<Option<f64>> {
        let slope = |k: usize| {
            let range = &self.ranges[k];
            let derivative = output.by.get(k)?;
            let value = derivative.value.or(match derivative.sides {
                [Some(below), Some(above)] => Some(0.5 * (below + above)),
                _ => None,
            })?;
            Some(value * (range.to - range.from))
        };
        (0..parameters.len()).map(slope).collect()
    }

    /// The derivatives by a variable that are still missing, from a run with another value.
    fn by_a_run(
        &mut self,
        design: &Evaluation<'a>,
        k: usize,
        asked: &[bool],
        known: &mut [Vec<Option<f64>>],
    ) -> Result<(), NoOptimum> {
        let inwards = if design.at[k] < 0.5 { STEP } else { -STEP };
        let mut found = None;
        for step in [inwards, -inwards] {
            let mut at = design.at.clone();
            at[k] += step;
            if found.is_none() && (0.0..=1.0).contains(&at[k]) {
                found = self.evaluate(&design.text, &at, Kind::Difference)?;
            }
        }
        let Some(beside) = found else { return Ok(()) };
        let step = beside.at[k] - design.at[k];
        for ((line, asked), known) in design.lines.iter().zip(asked).zip(known) {
            let other = beside.lines.iter().find(|other| other.is_of(line));
            if let (true, None, Some(other)) = (*asked, known[k], other) {
                // From or to a straight cable there is no slope.
                known[k] = Some((other.worst - line.worst) / step).filter(|slope| slope.is_finite());
            }
        }
        Ok(())
    }
}
