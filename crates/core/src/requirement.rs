//! Requirements: limits on quantities of a harness, and the sheet that says whether a run keeps them.
//!
//! A [`Requirement`] is data, with names resolved to indices of the network. `wireloom_solve` checks each of them at
//! every increment. A [`RequirementResult`] is one line of the sheet. The verdict says whether the harness is
//! acceptable; the [`Status`](crate::Status) of a run says how well its equations are solved.

use crate::event::{EventPlace, Moment};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Depth to which two cables may lie in each other, as a fraction of the diameter of the thinner one: bundles are soft
/// and not quite round, and their diameters are known to a tenth (see the library of the crate `scenario`).
pub const SOFT: f64 = 0.1;

/// Quantity that a requirement limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Measure {
    /// Bend radius of a branch, m.
    BendRadius,
    /// Axial force of a branch where it is pulled, N.
    Tension,
    /// Axial force of a branch where it is pressed, N; positive.
    Compression,
    /// Axial strain of a branch: axial force over EA.
    Strain,
    /// Twist of a branch beyond that at rest, without its sign, rad/m.
    Torsion,
    /// Total material twist of a branch, without its sign, turns.
    Turns,
    /// Force of a constraint on the harness, N.
    Force,
    /// Moment of a constraint on the harness, N m.
    Moment,
    /// Force that pushes a connector home, N.
    InsertionForce,
    /// Sum of the sizes of the contact forces of an obstacle on the cables, N.
    ContactForce,
    /// Distance between two surfaces, m; negative where they overlap. Of a constraint: from the surface of the cable at
    /// the held point.
    Clearance,
    /// Unstressed length of a part of a branch less the distance of its ends, m.
    Slack,
    /// Distance of the centre line from the drawn one, m.
    Deviation,
    /// Distance that a span bridges over its unstressed length.
    Reach,
    /// Depth to which two cables lie in each other, or to which the centre line of a held cable is driven into a body,
    /// m.
    Overlap,
    /// Axial force with which a span that is straight and touches nothing is pressed, N.
    Buckling,
}

impl Measure {
    /// All measures.
    pub const ALL: [Measure; 16] = [
        Measure::BendRadius,
        Measure::Tension,
        Measure::Compression,
        Measure::Strain,
        Measure::Torsion,
        Measure::Turns,
        Measure::Force,
        Measure::Moment,
        Measure::InsertionForce,
        Measure::ContactForce,
        Measure::Clearance,
        Measure::Slack,
        Measure::Deviation,
        Measure::Reach,
        Measure::Overlap,
        Measure::Buckling,
    ];

    /// Word used in scenarios and results.
    pub fn word(self) -> &'static str {
        match self {
            Measure::BendRadius => "bend_radius",
            Measure::Tension => "tension",
            Measure::Compression => "compression",
            Measure::Strain => "strain",
            Measure::Torsion => "torsion",
            Measure::Turns => "turns",
            Measure::Force => "force",
            Measure::Moment => "moment",
            Measure::InsertionForce => "insertion_force",
            Measure::ContactForce => "contact_force",
            Measure::Clearance => "clearance",
            Measure::Slack => "slack",
            Measure::Deviation => "deviation",
            Measure::Reach => "reach",
            Measure::Overlap => "overlap",
            Measure::Buckling => "buckling",
        }
    }

    /// Name for users.
    pub fn title(self) -> &'static str {
        match self {
            Measure::BendRadius => "bend radius",
            Measure::InsertionForce => "insertion force",
            Measure::ContactForce => "contact force",
            other => other.word(),
        }
    }

    /// SI unit; empty for a pure number.
    pub fn unit(self) -> &'static str {
        match self {
            Measure::BendRadius | Measure::Clearance | Measure::Slack | Measure::Deviation | Measure::Overlap => "m",
            Measure::Tension
            | Measure::Compression
            | Measure::Force
            | Measure::InsertionForce
            | Measure::ContactForce
            | Measure::Buckling => "N",
            Measure::Moment => "N m",
            Measure::Torsion => "rad/m",
            Measure::Turns => "turns",
            Measure::Strain | Measure::Reach => "",
        }
    }
}

/// Importance of a requirement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Severity {
    /// The harness is not acceptable where it fails.
    #[default]
    Must,
    /// It is reported, and decides nothing.
    Should,
}

impl Severity {
    /// Both.
    pub const ALL: [Severity; 2] = [Severity::Must, Severity::Should];

    /// Word used in scenarios and results.
    pub fn word(self) -> &'static str {
        match self {
            Severity::Must => "must",
            Severity::Should => "should",
        }
    }
}

/// Whether a requirement is kept. The order is that of the sheet: the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Verdict {
    /// It is not kept.
    Fail,
    /// It cannot be decided: the discretisation error reaches over the limit, or the run has not come to its end.
    Unresolved,
    /// Nothing was there to check it on.
    NotChecked,
    /// It is kept in every increment.
    Pass,
}

impl Verdict {
    /// All verdicts.
    pub const ALL: [Verdict; 4] = [Verdict::Fail, Verdict::Unresolved, Verdict::NotChecked, Verdict::Pass];

    /// Word used in results.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Fail => "fail",
            Verdict::Unresolved => "unresolved",
            Verdict::NotChecked => "not checked",
            Verdict::Pass => "pass",
        }
    }
}

/// Where a requirement comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Origin {
    /// An entry of `[[requirements]]`.
    Scenario,
    /// A limit of a section.
    Section,
    /// A limit of a constraint or of its type.
    Constraint,
    /// A limit of an obstacle.
    Obstacle,
    /// What holds for every harness.
    Always,
}

impl Origin {
    /// All origins.
    pub const ALL: [Origin; 5] =
        [Origin::Scenario, Origin::Section, Origin::Constraint, Origin::Obstacle, Origin::Always];

    /// Word used in results.
    pub fn word(self) -> &'static str {
        match self {
            Origin::Scenario => "scenario",
            Origin::Section => "section",
            Origin::Constraint => "constraint",
            Origin::Obstacle => "obstacle",
            Origin::Always => "always",
        }
    }
}

/// Side of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Bound {
    /// The value must not be smaller.
    Min,
    /// The value must not be larger.
    Max,
}

impl Bound {
    /// Both.
    pub const ALL: [Bound; 2] = [Bound::Min, Bound::Max];

    /// Word used in scenarios and results.
    pub fn word(self) -> &'static str {
        match self {
            Bound::Min => "min",
            Bound::Max => "max",
        }
    }

    /// Distance of a value from its limit, in the unit of both; negative beyond it.
    pub fn gap(self, value: f64, limit: f64) -> f64 {
        match self {
            Bound::Min => value - limit,
            Bound::Max => limit - value,
        }
    }

    /// The gap relative to the limit; `None` for a limit of 0.
    pub fn margin(self, value: f64, limit: f64) -> Option<f64> {
        (limit != 0.0).then(|| self.gap(value, limit) / limit.abs())
    }
}

/// Motion of a branch in which a requirement counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Motion {
    /// In motion and at rest.
    #[default]
    Any,
    /// At the end of an increment in which it moved.
    Moving,
    /// At the end of an increment in which it did not move, and at the end of each step.
    Rest,
}

impl Motion {
    /// All values.
    pub const ALL: [Motion; 3] = [Motion::Any, Motion::Moving, Motion::Rest];

    /// Word used in scenarios.
    pub fn word(self) -> &'static str {
        match self {
            Motion::Any => "any",
            Motion::Moving => "moving",
            Motion::Rest => "rest",
        }
    }
}

/// Part of a harness that a requirement is about, by index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// A branch between two unstressed arc lengths, m.
    Branch {
        /// Its index.
        branch: usize,
        /// Arc length where the part begins.
        from: f64,
        /// Arc length where it ends; infinite: the end of the branch.
        to: f64,
    },
    /// A constraint.
    Constraint(usize),
    /// An obstacle.
    Obstacle(usize),
}

impl Part {
    /// A whole branch.
    pub fn whole(branch: usize) -> Self {
        Part::Branch { branch, from: 0.0, to: f64::INFINITY }
    }
}

/// A requirement: the measure of each of its parts (of each pair, for clearances and contact forces between two) keeps
/// its limits at every increment of its steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirement {
    /// Name.
    pub name: String,
    /// Where it comes from.
    pub origin: Origin,
    /// What it limits.
    pub measure: Measure,
    /// The parts.
    pub of: Vec<Part>,
    /// The other parts of the pairs; empty where the measure needs one part only.
    pub against: Vec<Part>,
    /// Least value, in the unit of the measure.
    pub min: Option<f64>,
    /// Greatest value.
    pub max: Option<f64>,
    /// Indices of the steps in which it counts; `None`: all.
    pub steps: Option<Vec<usize>>,
    /// Motion in which it counts.
    pub motion: Motion,
    /// Importance.
    pub severity: Severity,
    /// Reason for users, such as a standard.
    pub because: Option<String>,
}

/// Named material point, whose position every result reports.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// Name.
    pub name: String,
    /// Index of the branch.
    pub branch: usize,
    /// Unstressed arc length on it, m.
    pub s: f64,
}

/// A line of the sheet: a requirement, its worst value over all increments, and whether it is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct RequirementResult {
    /// Name.
    pub name: String,
    /// Where it comes from.
    pub origin: Origin,
    /// What it limits.
    pub measure: Measure,
    /// Importance.
    pub severity: Severity,
    /// Reason for users.
    pub because: Option<String>,
    /// Whether it is kept.
    pub verdict: Verdict,
    /// Why it is unresolved or not checked; or what the worst value leaves out.
    pub reason: Option<String>,
    /// The value nearest to its limit, or farthest beyond it, in the unit of the measure; `None` where nothing was
    /// checked.
    pub worst: Option<f64>,
    /// Its limit.
    pub limit: f64,
    /// Side of that limit.
    pub bound: Bound,
    /// Estimate of the discretisation error of the worst value, in its unit; `None` where there is none.
    pub error: Option<f64>,
    /// Increment of the worst value.
    pub moment: Option<Moment>,
    /// Place of the worst value.
    pub place: EventPlace,
}

impl RequirementResult {
    /// Distance of the worst value from its limit relative to the limit; negative where it fails, and infinite where
    /// the value is infinite or not a number. `None` where nothing was checked, or the limit is 0.
    pub fn margin(&self) -> Option<f64> {
        let margin = self.bound.margin(self.worst?, self.limit)?;
        // What is not a number is beyond any limit.
        Some(if margin.is_nan() { f64::NEG_INFINITY } else { margin })
    }
}

/// Requirement that is not kept at the end of an increment, with its worst place in one part of the harness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Violation {
    /// Name of the requirement.
    pub name: String,
    /// What it limits.
    pub measure: Measure,
    /// Importance.
    pub severity: Severity,
    /// The value farthest beyond the limit, in the unit of the measure.
    pub value: f64,
    /// Its limit.
    pub limit: f64,
    /// Side of that limit.
    pub bound: Bound,
    /// Place of the value.
    pub place: EventPlace,
}

/// Names by which requirements are told apart, from their own names, origins and measures. Those of the file are
/// unique. The limits of a section, a constraint or an obstacle have its name: where others have it, too, the measure
/// follows in brackets, with a number where even that is not enough.
pub fn distinct_names(all: &[(&str, Origin, Measure)]) -> Vec<String> {
    let mut shared: BTreeMap<&str, usize> = BTreeMap::new();
    all.iter().for_each(|(name, ..)| *shared.entry(name).or_default() += 1);
    let of_file = all.iter().filter(|(_, origin, _)| *origin == Origin::Scenario).map(|(name, ..)| (*name).to_owned());
    let mut taken: BTreeSet<String> = of_file.collect();
    let distinct = |&(name, origin, measure): &(&str, Origin, Measure)| {
        if origin == Origin::Scenario || shared[name] == 1 {
            return name.to_owned();
        }
        let numbered = |n: usize| match n {
            1 => format!("{name} ({})", measure.title()),
            n => format!("{name} ({} {n})", measure.title()),
        };
        let free = (1..).map(numbered).find(|name| taken.insert(name.clone()));
        free.expect("a number that is not taken")
    };
    all.iter().map(distinct).collect()
}

/// A sheet with distinct names ([`distinct_names`]), for readers that look lines up by name.
pub fn with_distinct_names(sheet: &[RequirementResult]) -> Vec<RequirementResult> {
    let own: Vec<(&str, Origin, Measure)> =
        sheet.iter().map(|line| (line.name.as_str(), line.origin, line.measure)).collect();
    let lines = sheet.iter().zip(distinct_names(&own));
    lines.map(|(line, name)| RequirementResult { name, ..line.clone() }).collect()
}

/// Order of the sheet: requirements that must be kept first, by verdict, then by margin, the least first.
pub fn by_urgency(a: &RequirementResult, b: &RequirementResult) -> std::cmp::Ordering {
    let margin = |line: &RequirementResult| line.margin().unwrap_or(0.0);
    let failed = |line: &RequirementResult| line.verdict != Verdict::Pass;
    // What fails comes before what passes, whatever its severity.
    failed(b)
        .cmp(&failed(a))
        .then(a.severity.cmp(&b.severity))
        .then(a.verdict.cmp(&b.verdict))
        .then(margin(a).total_cmp(&margin(b)))
}

/// Verdict on a harness: that of the worst requirement that must be kept. A requirement of the scenario that could not
/// be checked is unresolved, and so is an empty sheet; a limit of a part that never came into question decides nothing.
pub fn verdict(sheet: &[RequirementResult]) -> Verdict {
    let musts = sheet.iter().filter(|line| line.severity == Severity::Must);
    let verdicts = musts.map(|line| match (line.verdict, line.origin) {
        (Verdict::NotChecked, Origin::Scenario) => Verdict::Unresolved,
        (Verdict::NotChecked, _) => Verdict::Pass,
        (verdict, _) => verdict,
    });
    if sheet.is_empty() { Verdict::Unresolved } else { verdicts.min().unwrap_or(Verdict::Pass) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(verdict: Verdict, severity: Severity, origin: Origin, worst: f64) -> RequirementResult {
        RequirementResult {
            name: "bend".into(),
            origin,
            measure: Measure::BendRadius,
            severity,
            because: None,
            verdict,
            reason: None,
            worst: Some(worst),
            limit: 0.05,
            bound: Bound::Min,
            error: None,
            moment: None,
            place: EventPlace::default(),
        }
    }

    #[test]
    fn the_verdict_is_that_of_the_worst_must() {
        use {Origin::*, Severity::*, Verdict::*};
        let of = |lines: &[(Verdict, Severity, Origin)]| {
            let sheet: Vec<_> = lines.iter().map(|(v, s, o)| line(*v, *s, *o, 0.1)).collect();
            verdict(&sheet)
        };
        assert_eq!(of(&[]), Unresolved);
        assert_eq!(of(&[(Pass, Must, Scenario), (Fail, Should, Scenario)]), Pass);
        assert_eq!(of(&[(Unresolved, Must, Scenario), (Fail, Must, Section)]), Fail);
        assert_eq!(of(&[(Unresolved, Must, Scenario), (Pass, Must, Section)]), Unresolved);
        assert_eq!(of(&[(NotChecked, Must, Scenario), (Pass, Must, Section)]), Unresolved);
        assert_eq!(of(&[(NotChecked, Must, Constraint), (Pass, Must, Section)]), Pass);
    }

    #[test]
    fn no_two_requirements_have_the_same_distinct_name() {
        use {Measure::*, Origin::*};
        let all = [
            ("T", Scenario, Tension),
            ("T", Section, BendRadius),
            ("T", Section, BendRadius),
            ("T", Section, Tension),
            ("clip", Constraint, Force),
            ("U", Section, Tension),
            ("U (tension)", Scenario, Tension),
            ("U", Section, Torsion),
        ];
        let names = [
            "T",
            "T (bend radius)",
            "T (bend radius 2)",
            "T (tension)",
            "clip",
            "U (tension 2)",
            "U (tension)",
            "U (torsion)",
        ];
        assert_eq!(distinct_names(&all), names);
    }

    #[test]
    fn the_sheet_begins_with_what_fails_most() {
        use {Severity::*, Verdict::*};
        let order = [
            line(Fail, Must, Origin::Scenario, 0.01),
            line(Fail, Must, Origin::Scenario, 0.04),
            line(Unresolved, Must, Origin::Scenario, 0.051),
            line(Fail, Should, Origin::Scenario, 0.01),
            line(Pass, Must, Origin::Scenario, 0.06),
            line(Pass, Should, Origin::Scenario, 0.055),
        ];
        assert!(order.windows(2).all(|pair| by_urgency(&pair[0], &pair[1]).is_lt()), "{order:?}");
        assert_eq!(order[1].margin().map(|margin| (1e3 * margin).round()), Some(-200.0));
        assert_eq!(RequirementResult { limit: 0.0, ..order[0].clone() }.margin(), None);
    }
}
