//! Differences between the last equilibria of several runs, and their causes.
//!
//! Branches are compared at equal fractions of their arc length, on any meshes: between nodes a shape is the cubic
//! through positions and tangents, so that the corners of a coarse mesh do not count. Runs that converged, whose
//! branches all lie within a tolerance of each other with the same twist, and whose constraints bear the same forces,
//! have ended in the same equilibrium. For the others, [`Comparison::parts`] lists the parts of the harness with more
//! than one shape, and [`Group::reasons`] possible causes.

mod convergence;
mod forces;
pub(crate) mod shape;

pub use convergence::{Trend, convergence};
pub use forces::{Forces, forces};

use crate::ending::{ConstraintEnd, Ending};
use shape::Gap;
use std::fmt;
use wireloom_core::Vector;

/// A larger difference of twist (turns) was put in during the steps; a smaller one comes from another shape.
const TURNS: f64 = 0.5;
/// The same where the shapes are the same: then it is no other shape.
const SAME_TURNS: f64 = 0.02;
/// Largest difference of the forces (moments) of constraints in one equilibrium, as a fraction of the largest one: that
/// of coarse meshes.
const SAME_FORCES: f64 = 0.1;
/// The same of the energy, as a fraction of the sizes of its parts.
const SAME_ENERGY: f64 = 0.05;
/// Forces (N), moments (N m) and energies (J) that do not matter.
const NEGLIGIBLE: [f64; 3] = [1e-3, 1e-5, 1e-6];
/// Ends of branches that are nearer to each other than this many tolerances are joined.
const MEET: f64 = 2.0;

/// A run and a name that distinguishes it from the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Name.
    pub name: String,
    /// Its last equilibrium.
    pub ending: Ending,
}

/// Comparison of several runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Shapes nearer to each other than this are the same, m.
    pub tolerance: f64,
    /// Index of the case that the others are compared with.
    pub reference: usize,
    /// Difference of each case from the reference.
    pub differences: Vec<Difference>,
    /// Cases that ended in the same equilibrium; that of the reference first, then by energy.
    pub groups: Vec<Group>,
    /// Parts of the harness with more than one shape, in descending order of distance.
    pub parts: Vec<Part>,
}

/// Difference from the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Branches that both have, in the order of the reference.
    pub branches: Vec<BranchDifference>,
    /// Constraints that act in both, in the order of the reference.
    pub constraints: Vec<ConstraintDifference>,
    /// Branches and constraints that only one of the two has.
    pub unmatched: Vec<String>,
    /// Total energy above that of the reference, J.
    pub energy: f64,
}

/// A branch compared with that of the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchDifference {
    /// Name.
    pub name: String,
    /// Largest distance, m.
    pub largest: f64,
    /// Its place: arc length of the reference, m.
    pub s: f64,
    /// Mean distance along the branch, m.
    pub mean: f64,
    /// Length of the reference's branch, m.
    pub length: f64,
    /// Tightest bend radius, of the reference and here, m; infinite where straight.
    pub bend_radius: [f64; 2],
    /// Twist, of the reference and here, turns.
    pub twist_turns: [f64; 2],
}

/// A constraint compared with that of the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstraintDifference {
    /// Name.
    pub name: String,
    /// Length of the difference of the forces, N.
    pub force: f64,
    /// Length of the difference of the moments, N m.
    pub moment: f64,
    /// Distance of the held points, m.
    pub position: f64,
    /// Outputs of its kind that both have: name, and value above that of the reference, SI.
    pub outputs: Vec<(String, f64)>,
}

/// Cases that ended in the same equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Indices of the cases; the first one stands for all.
    pub cases: Vec<usize>,
    /// Causes of the difference from the reference; of the reference itself, that it did not converge.
    pub reasons: Vec<Reason>,
}

/// A part of the harness with more than one shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Names of its branches, which are connected.
    pub branches: Vec<String>,
    /// Its shapes, that of the reference first.
    pub ways: Vec<Way>,
}

/// A shape of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Indices of the cases.
    pub cases: Vec<usize>,
    /// Branch, arc length (m) and distance (m) of the point that is farthest from the first shape; none for that
    /// itself.
    pub farthest: Option<(String, f64, f64)>,
}

/// Cause of a difference from the reference.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// The run or the reference did not converge.
    NotConverged {
        /// Whether it is the reference that did not converge.
        reference: bool,
        /// Word for the status.
        status: String,
    },
    /// The run or the reference ended in an unstable equilibrium.
    Unstable {
        /// Whether it is the reference.
        reference: bool,
    },
    /// Branches or constraints are not those of the reference.
    OtherHarness {
        /// Names that only one of the two has.
        unmatched: Vec<String>,
    },
    /// A constraint holds another place than that of the reference.
    HeldElsewhere {
        /// Name of the constraint.
        constraint: String,
        /// Distance, m.
        distance: f64,
    },
    /// A constraint closed at another arc length of the cable, or the cable slides through it there.
    OtherPlace {
        /// Name of the constraint.
        constraint: String,
        /// Branch and arc length (m), of the reference and here; none at a joint.
        places: [Option<(String, f64)>; 2],
    },
    /// The twist of a branch differs.
    Twist {
        /// Name of the branch.
        branch: String,
        /// Of the reference and here, turns.
        turns: [f64; 2],
    },
    /// In the same shape a constraint bears another force or moment.
    Bears {
        /// Name of the constraint.
        constraint: String,
        /// "N" or "N m".
        unit: &'static str,
        /// Size of the difference.
        difference: f64,
    },
    /// In the same shape the energy is another one.
    Energy {
        /// Above that of the reference, J.
        difference: f64,
    },
    /// No other difference: both are equilibria of the same harness.
    Multistable {
        /// Whether both are known to be stable.
        stable: bool,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let whose = |reference: &bool| if *reference { "the reference" } else { "it" };
        match self {
            Self::NotConverged { reference, status } => {
                write!(f, "{} did not converge ({status}): this is no equilibrium", whose(reference))
            }
            Self::Unstable { reference } => {
                write!(f, "{} is not stable: a real harness would leave this equilibrium", whose(reference))
            }
            Self::OtherHarness { unmatched } => write!(f, "only one of the two has {}", some(unmatched)),
            Self::HeldElsewhere { constraint, distance } => {
                write!(f, "constraint {constraint} holds {:.1} mm from its place in the reference", 1e3 * distance)
            }
            Self::OtherPlace { constraint, places: [reference, here] } => {
                let place = |place: &Option<(String, f64)>| match place {
                    Some((branch, s)) => format!("s = {:.1} mm of {branch}", 1e3 * s),
                    None => "a joint".to_owned(),
                };
                write!(f, "constraint {constraint} is at {}, in the reference at {}", place(here), place(reference))
            }
            Self::Twist { branch, turns: [reference, here] } => {
                write!(f, "branch {branch} is twisted by {here:.2} turns, in the reference by {reference:.2}")
            }
            Self::Bears { constraint, unit, difference } => {
                write!(
                    f,
                    "in the same shape constraint {constraint} bears a load that differs by {difference:.3} {unit}"
                )
            }
            Self::Energy { difference } => {
                write!(f, "in the same shape its energy differs by {:+.3} mJ", 1e3 * difference)
            }
            Self::Multistable { stable: true } => f.write_str(
                "both are stable, with the same constraints and turns of twist: \
                     which one is reached depends on the steps before",
            ),
            Self::Multistable { stable: false } => f.write_str(
                "both have the same constraints and turns of twist (whether they are stable was not determined): \
                 which one is reached depends on the steps before",
            ),
        }
    }
}

/// The first few of many.
fn some(names: &[String]) -> String {
    const SHOWN: usize = 4;
    let more = names.len().saturating_sub(SHOWN);
    let shown = names[..names.len().min(SHOWN)].join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}

impl Comparison {
    /// Compares; `reference`: index of the case that the others are compared with, or none for the first one of the
    /// largest group that converged. Shapes nearer to each other than `tolerance` (m) are the same.
    ///
    /// # Panics
    /// Where there are no cases.
    pub fn of(cases: &[Case], reference: Option<usize>, tolerance: f64) -> Self {
        let mut gaps = Gaps::new(cases);
        let all: Vec<usize> = (0..cases.len()).collect();
        let converged = |k: usize| cases[k].ending.converged;
        let alike = alike(&all, |a, b| {
            let equilibria = converged(a) && converged(b);
            equilibria
                && gaps.largest(a, b) <= tolerance
                && same_shape(&cases[a].ending, &cases[b].ending, tolerance).is_empty()
        });
        let reference = reference.unwrap_or_else(|| {
            let largest = alike.iter().rev().max_by_key(|group| (converged(group[0]), group.len()));
            largest.expect("at least one case")[0]
        });
        let differences: Vec<Difference> =
            cases.iter().map(|case| difference(&cases[reference].ending, &case.ending)).collect();
        let mut groups: Vec<Group> = alike
            .into_iter()
            .map(|mut members| {
                if let Some(k) = members.iter().position(|member| *member == reference) {
                    members.swap(0, k);
                }
                let reasons = reasons(cases, reference, members[0], &differences[members[0]], tolerance);
                Group { cases: members, reasons }
            })
            .collect();
        groups.sort_by(|a, b| {
            let energy = |group: &Group| differences[group.cases[0]].energy;
            (a.cases[0] != reference).cmp(&(b.cases[0] != reference)).then(energy(a).total_cmp(&energy(b)))
        });
        let parts = parts(cases, reference, tolerance, &mut gaps);
        Self { tolerance, reference, differences, groups, parts }
    }
}

impl Difference {
    /// The branch that is farthest away.
    pub fn farthest(&self) -> Option<&BranchDifference> {
        self.branches.iter().max_by(|a, b| a.largest.total_cmp(&b.largest))
    }

    /// Mean distance over all branches, by length, m.
    pub fn mean(&self) -> f64 {
        let length: f64 = self.branches.iter().map(|branch| branch.length).sum();
        self.branches.iter().map(|branch| branch.mean * branch.length).sum::<f64>() / length
    }

    /// The constraint with the largest difference of force.
    pub fn hardest(&self) -> Option<&ConstraintDifference> {
        self.constraints.iter().max_by(|a, b| a.force.total_cmp(&b.force))
    }
}

/// Distances of branches of every pair of cases, computed once.
struct Gaps<'a> {
    cases: &'a [Case],
    known: std::collections::BTreeMap<(usize, usize), Vec<(String, Gap)>>,
}

impl<'a> Gaps<'a> {
    fn new(cases: &'a [Case]) -> Self {
        Self { cases, known: std::collections::BTreeMap::new() }
    }

    /// Gaps of all branches that both have, by name; arc lengths are those of the first.
    fn between(&mut self, a: usize, b: usize) -> &[(String, Gap)] {
        let cases = self.cases;
        self.known.entry((a, b)).or_insert_with(|| {
            let [first, second] = [a, b].map(|k| &cases[k].ending.branches);
            let gap = |branch: &crate::ending::BranchEnd| {
                let other = second.iter().find(|other| other.name == branch.name)?;
                Some((branch.name.clone(), shape::gap(branch, other)))
            };
            first.iter().filter_map(gap).collect()
        })
    }

    fn of_branch(&mut self, a: usize, b: usize, name: &str) -> Option<Gap> {
        self.between(a, b).iter().find(|(other, _)| other == name).map(|(_, gap)| *gap)
    }

    /// Largest gap of all branches; infinite where one has a branch that the other lacks.
    fn largest(&mut self, a: usize, b: usize) -> f64 {
        let branches = self.cases[a].ending.branches.len().max(self.cases[b].ending.branches.len());
        let gaps = self.between(a, b);
        if gaps.len() < branches {
            return f64::INFINITY;
        }
        gaps.iter().fold(0.0, |largest, (_, gap)| if gap.largest > largest { gap.largest } else { largest })
    }
}

/// Puts each into the first group whose first member it equals.
fn alike(all: &[usize], mut same: impl FnMut(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &k in all {
        match groups.iter_mut().find(|group| same(group[0], k)) {
            Some(group) => group.push(k),
            None => groups.push(vec![k]),
        }
    }
    groups
}

fn difference(reference: &Ending, here: &Ending) -> Difference {
    let mut unmatched = Vec::new();
    let mut branches = Vec::new();
    for branch in &reference.branches {
        let Some(other) = here.branches.iter().find(|other| other.name == branch.name) else {
            unmatched.push(branch.name.clone());
            continue;
        };
        let Gap { largest, fraction, mean } = shape::gap(branch, other);
        let length = branch.s.last().copied().unwrap_or(0.0);
        branches.push(BranchDifference {
            name: branch.name.clone(),
            largest,
            s: fraction * length,
            mean,
            length,
            bend_radius: [branch, other].map(|branch| branch.tightest().map_or(f64::INFINITY, |(_, radius)| radius)),
            twist_turns: [branch.twist_turns, other.twist_turns],
        });
    }
    let known = |name: &str| reference.branches.iter().any(|branch| branch.name == name);
    unmatched.extend(here.branches.iter().filter(|branch| !known(&branch.name)).map(|branch| branch.name.clone()));
    let mut constraints = Vec::new();
    for constraint in &reference.constraints {
        let Some(other) = here.constraints.iter().find(|other| other.name == constraint.name) else {
            unmatched.push(constraint.name.clone());
            continue;
        };
        let between = |part: fn(&ConstraintEnd) -> Vector| (part(other) - part(constraint)).norm();
        constraints.push(ConstraintDifference {
            name: constraint.name.clone(),
            force: between(|constraint| constraint.force),
            moment: between(|constraint| constraint.moment),
            position: between(|constraint| constraint.position),
            outputs: constraint
                .outputs
                .iter()
                .filter_map(|(name, before)| {
                    let (_, now) = other.outputs.iter().find(|(same, _)| same == name)?;
                    Some((name.clone(), now - before))
                })
                .collect(),
        });
    }
    let known = |name: &str| reference.constraints.iter().any(|constraint| constraint.name == name);
    unmatched.extend(
        here.constraints.iter().filter(|constraint| !known(&constraint.name)).map(|constraint| constraint.name.clone()),
    );
    Difference { branches, constraints, unmatched, energy: here.energy.total() - reference.energy.total() }
}

/// Causes of the difference of `here` from the reference.
fn reasons(cases: &[Case], reference: usize, here: usize, difference: &Difference, tolerance: f64) -> Vec<Reason> {
    let endings = [reference, here].map(|k| &cases[k].ending);
    let mut reasons = Vec::new();
    if reference == here {
        if !endings[0].converged {
            reasons.push(Reason::NotConverged { reference: false, status: endings[0].status.clone() });
        }
        return reasons;
    }
    for (ending, reference) in endings.into_iter().zip([true, false]) {
        if !ending.converged {
            reasons.push(Reason::NotConverged { reference, status: ending.status.clone() });
        } else if ending.stable == Some(false) {
            reasons.push(Reason::Unstable { reference });
        }
    }
    if !difference.unmatched.is_empty() {
        reasons.push(Reason::OtherHarness { unmatched: difference.unmatched.clone() });
    }
    let moved = difference.constraints.iter().filter(|constraint| constraint.position > tolerance);
    reasons.extend(moved.map(|f| Reason::HeldElsewhere { constraint: f.name.clone(), distance: f.position }));
    let [known, found] = endings.map(places);
    for (constraint, place) in found {
        let Some((_, before)) = known.iter().find(|(name, _)| *name == constraint) else { continue };
        let same = match (before, &place) {
            (Some((a, s)), Some((b, t))) => a == b && (s - t).abs() <= tolerance,
            (None, None) => true,
            _ => false,
        };
        if !same {
            reasons.push(Reason::OtherPlace { constraint, places: [before.clone(), place] });
        }
    }
    if difference.unmatched.is_empty() && difference.farthest().is_none_or(|branch| branch.largest <= tolerance) {
        reasons.extend(same_shape(endings[0], endings[1], tolerance));
    } else {
        reasons.extend(twists(&difference.branches, TURNS));
    }
    if reasons.is_empty() {
        reasons.push(Reason::Multistable { stable: endings.iter().all(|ending| ending.stable == Some(true)) });
    }
    reasons
}

/// Branches whose twist differs by more than this, turns.
fn twists(branches: &[BranchDifference], turns: f64) -> impl Iterator<Item = Reason> {
    let twisted = branches.iter().filter(move |own| (own.twist_turns[1] - own.twist_turns[0]).abs() > turns);
    twisted.map(|own| Reason::Twist { branch: own.name.clone(), turns: own.twist_turns })
}

/// What differs between two equilibria of the same shape; nothing: they are the same.
fn same_shape(one: &Ending, other: &Ending, tolerance: f64) -> Vec<Reason> {
    let Difference { branches, constraints, energy, .. } = difference(one, other);
    let mut reasons: Vec<Reason> = twists(&branches, SAME_TURNS).collect();
    let largest = |of: fn(&ConstraintEnd) -> Vector| {
        one.constraints.iter().chain(&other.constraints).fold(0.0, |most: f64, own| most.max(of(own).norm()))
    };
    let (force, moment) = (largest(|own| own.force), largest(|own| own.moment));
    let [no_force, no_moment, no_energy] = NEGLIGIBLE;
    let allowed = (SAME_FORCES * force + no_force, SAME_FORCES * moment + tolerance * force + no_moment);
    for own in &constraints {
        let bears = |unit, difference| Reason::Bears { constraint: own.name.clone(), unit, difference };
        if own.force > allowed.0 {
            reasons.push(bears("N", own.force));
        } else if own.moment > allowed.1 {
            reasons.push(bears("N m", own.moment));
        }
    }
    let sizes = |of: &wireloom_core::equilibrium::Energy| {
        let all = [of.stretch, of.shear, of.bend, of.twist, of.gravity, of.load, of.joint, of.constraint];
        all.iter().map(|part| part.abs()).sum::<f64>()
    };
    if energy.abs() > SAME_ENERGY * sizes(&one.energy).max(sizes(&other.energy)) + tolerance * force + no_energy {
        reasons.push(Reason::Energy { difference: energy });
    }
    reasons
}

/// Places on the cable of constraints that could choose theirs.
fn places(ending: &Ending) -> Vec<(String, Option<(String, f64)>)> {
    let slides = ending.constraints.iter().filter(|constraint| constraint.slide.is_some());
    let slides = slides.map(|constraint| (constraint.name.clone(), constraint.slide.clone()));
    let acts =
        |name: &str| ending.constraints.iter().any(|constraint| constraint.name == name && constraint.slide.is_none());
    let closed = ending.closed.iter().filter(|closed| acts(&closed.constraint));
    slides.chain(closed.map(|closed| (closed.constraint.clone(), closed.place.clone()))).collect()
}

/// Connected branches with the same grouping of cases are one part.
fn parts(cases: &[Case], reference: usize, tolerance: f64, gaps: &mut Gaps<'_>) -> Vec<Part> {
    let mut order: Vec<usize> = (0..cases.len()).filter(|k| *k != reference).collect();
    order.insert(0, reference);
    let mut found: Vec<(Vec<String>, Vec<Vec<usize>>)> = Vec::new();
    for branch in &cases[reference].ending.branches {
        let name = &branch.name;
        let present: Vec<usize> =
            order.iter().copied().filter(|k| cases[*k].ending.branches.iter().any(|b| b.name == *name)).collect();
        let ways = alike(&present, |a, b| gaps.of_branch(a, b, name).is_some_and(|gap| gap.largest <= tolerance));
        if ways.len() < 2 {
            continue;
        }
        // It may connect parts that were separate before.
        let touches = |other: &(Vec<String>, Vec<Vec<usize>>)| {
            other.1 == ways && other.0.iter().any(|other| meet(cases, reference, name, other, tolerance))
        };
        let (joined, apart) = found.into_iter().partition(|other| touches(other));
        found = apart;
        let joined: Vec<(Vec<String>, _)> = joined;
        let mut branches: Vec<String> = joined.into_iter().flat_map(|(branches, _)| branches).collect();
        branches.push(name.clone());
        found.push((branches, ways));
    }
    let mut parts: Vec<Part> = found
        .into_iter()
        .map(|(branches, ways)| {
            let first = ways[0][0];
            let ways = ways.into_iter().map(|members| {
                let distances = branches.iter().filter_map(|name| {
                    let gap = gaps.of_branch(first, members[0], name)?;
                    let length = length(cases, first, name);
                    Some((name.clone(), gap.fraction * length, gap.largest))
                });
                let farthest = distances.max_by(|a, b| a.2.total_cmp(&b.2)).filter(|_| members[0] != first);
                Way { cases: members, farthest }
            });
            Part { ways: ways.collect(), branches }
        })
        .collect();
    let reach =
        |part: &Part| part.ways.iter().filter_map(|way| way.farthest.as_ref()).fold(0.0, |r: f64, f| r.max(f.2));
    parts.sort_by(|a, b| reach(b).total_cmp(&reach(a)));
    parts
}

fn length(cases: &[Case], k: usize, name: &str) -> f64 {
    let branch = cases[k].ending.branches.iter().find(|branch| branch.name == name);
    branch.and_then(|branch| branch.s.last().copied()).unwrap_or(0.0)
}

/// Whether two branches have an end in common.
fn meet(cases: &[Case], k: usize, a: &str, b: &str, tolerance: f64) -> bool {
    let ends = |name: &str| {
        let branch = cases[k].ending.branches.iter().find(|branch| branch.name == name);
        branch.map_or(vec![], |branch| {
            branch.position.first().into_iter().chain(branch.position.last()).copied().collect()
        })
    };
    let (first, second): (Vec<Vector>, Vec<Vector>) = (ends(a), ends(b));
    first.iter().any(|x| second.iter().any(|y| (x - y).norm() <= MEET * tolerance))
}
