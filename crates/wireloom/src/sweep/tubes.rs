//! The tolerance envelope of a sweep as tubes around each branch, one for each percentile and each step.
//!
//! A branch has stations at equal fractions of its length. At a station, the reference is the mean place x̄ of the
//! centre line over all points of the sweep whose step ended in an equilibrium. A point p reaches
//!
//! `r_p = |x_p − x̄| + radius of its cable`
//!
//! there; where its section changes, the greatest radius up to the stations beside it. The tube of the percentile q has
//! the least radius r for which at least q % of these points have `r_p ≤ r`. The percentiles belong to single stations:
//! a point can be within the 95 % tube at one station and outside it at another, so the share of points that are inside
//! everywhere is smaller, except for 100 %. A tube is about the end of its step; the space on the way is in the surface
//! of [`wireloom_shapes::swept`]. Between two stations it is straight: a centre line of curvature κ lies up to κ h²/8
//! beside it, where h is their distance.
//!
//! Sums go through the points in their order, so tubes are the same to the last bit on any number of threads.

use wireloom_core::equilibrium::StepResult;
use wireloom_core::steps::Schedule;
use wireloom_core::{Network, Vector};
use wireloom_export::gltf::Tube;

/// Percentiles of the tubes.
pub const PERCENTILES: [usize; 4] = [50, 90, 95, 100];
/// Distance of stations in diameters.
const APART: f64 = 2.0;
/// Fewest and most pieces between the stations of a branch.
const PIECES: [f64; 2] = [8.0, 64.0];
/// Reaches that are in memory at once: 64 MB.
const ROOM: usize = 1 << 24;

/// Centre lines of one point of a sweep, by step: coordinates of the stations of all branches, then the radii there, m.
/// Empty for steps that did not end in an equilibrium.
pub type Lines = Vec<Vec<f32>>;

/// Branches with their stations, and steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stations {
    branches: Vec<(String, usize)>,
    steps: Vec<String>,
}

impl Stations {
    /// Those of a harness.
    pub fn of(network: &Network, schedule: &Schedule) -> Self {
        let branch = |branch: &wireloom_core::network::Branch| {
            let pieces = branch.rod.mesh().length() / (APART * branch.sections.diameter());
            (branch.name.clone(), pieces.ceil().clamp(PIECES[0], PIECES[1]) as usize + 1)
        };
        let mut steps: Vec<String> = schedule.steps.iter().map(|step| step.name.clone()).collect();
        if steps.is_empty() {
            steps.push("equilibrium".to_owned());
        }
        Self { branches: network.branches.iter().map(branch).collect(), steps }
    }

    /// Number of stations of all branches.
    fn count(&self) -> usize {
        self.branches.iter().map(|(_, stations)| stations).sum()
    }

    /// The centre lines at the end of a step, as they are in [`Lines`].
    pub(super) fn at(&self, end: &StepResult) -> Vec<f32> {
        let mut line = Vec::with_capacity(4 * self.count());
        let mut radii = Vec::with_capacity(self.count());
        for (branch, (_, stations)) in end.branches.iter().zip(&self.branches) {
            let (s, x) = (&branch.s, &branch.position);
            let (first, length) = (s[0], s[s.len() - 1] - s[0]);
            let place = |k: usize| first + length * (k.min(stations - 1) as f64 / (stations - 1) as f64);
            let segment = |at: f64| s.partition_point(|s| *s <= at).clamp(1, s.len() - 1) - 1;
            for k in 0..*stations {
                // Of all cable up to the next stations: between them the tube is straight.
                let around = segment(place(k.saturating_sub(1)))..=segment(place(k + 1));
                radii.push((0.5 * around.map(|j| branch.diameter_of(j)).fold(0.0, f64::max)) as f32);
                let (at, j) = (place(k), segment(place(k)));
                let share = ((at - s[j]) / (s[j + 1] - s[j])).clamp(0.0, 1.0);
                let x = x[j] + (x[j + 1] - x[j]) * share;
                line.extend(x.iter().map(|x| *x as f32));
            }
        }
        line.extend(radii);
        line
    }

    /// The tubes around the points of these chains, which `read` gives, more than once.
    ///
    /// # Errors
    /// Those of `read`.
    pub fn tubes<E>(&self, chains: usize, read: impl Fn(usize) -> Result<Vec<Lines>, E>) -> Result<Vec<Tube>, E> {
        let (all, length) = (self.count(), 4 * self.count());
        let each = |take: &mut dyn FnMut(usize, &[f32])| {
            (0..chains).try_for_each(|chain| {
                for lines in read(chain)? {
                    let steps = lines.iter().take(self.steps.len()).enumerate();
                    steps.filter(|(_, line)| line.len() == length).for_each(|(step, line)| take(step, line));
                }
                Ok(())
            })
        };
        let (mut means, mut points) = (vec![Vector::zeros(); self.steps.len() * all], vec![0_usize; self.steps.len()]);
        each(&mut |step, line| {
            points[step] += 1;
            for (mean, x) in means[step * all..].iter_mut().zip(line[..3 * all].chunks_exact(3)) {
                *mean += place(x);
            }
        })?;
        for (k, mean) in means.iter_mut().enumerate() {
            *mean /= points[k / all].max(1) as f64;
        }
        let mut radii = vec![[0.0; PERCENTILES.len()]; means.len()];
        let most = points.iter().copied().max().unwrap_or(0).max(1);
        let at_once = (ROOM / most).max(1);
        for first in (0..means.len()).step_by(at_once) {
            let part = first..(first + at_once).min(means.len());
            let mut reaches: Vec<Vec<f32>> = part.clone().map(|_| Vec::new()).collect();
            each(&mut |step, line| {
                for k in (step * all).max(part.start)..((step + 1) * all).min(part.end) {
                    let j = k - step * all;
                    let radius = f64::from(line[3 * all + j]);
                    let reach = (place(&line[3 * j..3 * j + 3]) - means[k]).norm() + radius;
                    reaches[k - part.start].push(reach as f32);
                }
            })?;
            for (k, mut reaches) in part.zip(reaches) {
                reaches.sort_unstable_by(f32::total_cmp);
                for (radius, percent) in radii[k].iter_mut().zip(PERCENTILES) {
                    let within = (percent * reaches.len()).div_ceil(100);
                    *radius = within.checked_sub(1).map_or(0.0, |last| f64::from(reaches[last]));
                }
            }
        }
        let mut tubes = Vec::new();
        for (step, name) in self.steps.iter().enumerate().filter(|(step, _)| points[*step] > 0) {
            let mut first = step * all;
            for (branch, stations) in &self.branches {
                let own = first..first + stations;
                first = own.end;
                let of = |q: usize| (PERCENTILES[q], radii[own.clone()].iter().map(|radii| radii[q]).collect());
                tubes.push(Tube {
                    branch: branch.clone(),
                    step: name.clone(),
                    points: points[step],
                    centre: means[own.clone()].to_vec(),
                    radii: (0..PERCENTILES.len()).map(of).collect(),
                });
            }
        }
        Ok(tubes)
    }
}

fn place(x: &[f32]) -> Vector {
    Vector::new(f64::from(x[0]), f64::from(x[1]), f64::from(x[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// Stations of two branches, in two steps.
    fn stations() -> Stations {
        let branches = vec![("a".to_owned(), 2), ("b".to_owned(), 3)];
        Stations { branches, steps: vec!["one".to_owned(), "two".to_owned()] }
    }

    /// Tubes of points `k`, at (k, station, 0) mm, in chains of seven; the second step of every third is missing.
    fn tubes(count: usize) -> Vec<Tube> {
        let line = |k: usize| {
            let coordinates = (0..5).flat_map(|j| [1e-3 * k as f32, 1e-3 * j as f32, 0.0]);
            coordinates.chain([0.5e-3, 0.5e-3, 2e-3, 2e-3, 2e-3]).collect::<Vec<f32>>()
        };
        let point = |k: usize| if k.is_multiple_of(3) { vec![line(k), vec![]] } else { vec![line(k), line(k)] };
        let read = |chain: usize| Ok::<_, Infallible>((7 * chain..(7 * chain + 7).min(count)).map(point).collect());
        stations().tubes(count.div_ceil(7), read).unwrap_or_else(|never| match never {})
    }

    #[test]
    fn a_percentile_is_the_least_radius_with_that_share_of_the_points() {
        let all = tubes(100);
        let of = |step: &str, branch: &str| all.iter().find(|t| t.step == step && t.branch == branch).expect("a tube");
        let tube = of("one", "b");
        assert_eq!((tube.points, tube.centre.len()), (100, 3));
        assert!((tube.centre[1] - Vector::new(49.5e-3, 3e-3, 0.0)).norm() < 1e-8, "{:?}", tube.centre);
        // Distances from the mean 49.5 mm are 0.5, 0.5, 1.5, 1.5, ... 49.5, 49.5 mm.
        for ((percent, radii), expected) in tube.radii.iter().zip([24.5e-3, 44.5e-3, 47.5e-3, 49.5e-3]) {
            assert!(radii.iter().all(|r| (r - expected - 2e-3).abs() < 1e-7), "{percent} %: {radii:?}, not {expected}");
        }
        assert_eq!(of("two", "a").points, 66);
        assert!(of("two", "a").radii[3].1[0] < 50.1e-3, "without the radius of the other branch");
    }

    #[test]
    fn a_point_that_failed_everywhere_leaves_no_tube() {
        assert!(tubes(0).is_empty());
        assert!(tubes(1).iter().all(|tube| tube.step == "one"));
    }
}
