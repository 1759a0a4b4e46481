//! Outputs of a harness at one equilibrium.

use super::answer::NoAnswer;
use wireloom_core::equilibrium::{Outcome, Run, StepResult};
use wireloom_core::network::Branch;
use wireloom_core::requirement::{Measure, Origin, RequirementResult};
use wireloom_core::{EventPlace, Moment, Network};
use wireloom_export::ending::Ending;
use wireloom_export::table::{Cell, Computed, Header};
use wireloom_scenario::Scenario;
use wireloom_scenario::fault::did_you_mean;
use wireloom_scenario::sweep::When;
use wireloom_solve::steps::interactive::Ended;
use wireloom_solve::steps::nearby::Nearby;

/// Round-off of an output relative to the size of the quantity in the harness.
const ROUND_OFF: f64 = 1e-12;
/// Number of rounding errors of the strains that add up in a force.
const ROUNDINGS: f64 = 20.0;
/// Difference of two values that are the same, relative to them.
const SAME: f64 = 1e-6;

/// Outputs of a harness at one equilibrium.
pub(super) struct Catalogue {
    header: Header,
    /// Names of the columns that belong to one equilibrium.
    columns: Vec<String>,
    requirements: Vec<String>,
    /// Columns that hold a value of the path.
    of_path: Vec<String>,
}

/// Values of all outputs at an equilibrium.
pub(super) struct Measured {
    columns: Vec<(String, f64)>,
    requirements: Vec<RequirementResult>,
    pub near: Nearby,
}

impl Measured {
    /// Value of an output; `None` where there is none.
    pub fn value(&self, name: &str) -> Option<f64> {
        let worst = self.requirements.iter().find(|line| line.name == name).map(|line| line.worst);
        let column = || self.columns.iter().find(|(column, _)| column == name).map(|(_, value)| *value);
        worst.unwrap_or_else(column).filter(|value| value.is_finite())
    }

    /// Place of the worst value of a requirement.
    pub fn place(&self, name: &str) -> Option<&EventPlace> {
        self.requirements.iter().find(|line| line.name == name).map(|line| &line.place)
    }

    /// Whether two places are not the same, up to half a segment: a place may move with the harness.
    pub fn is_elsewhere(&self, one: &EventPlace, other: &EventPlace) -> bool {
        let apart = |branch: &Option<String>, a: Option<f64>, b: Option<f64>| match (branch, a, b) {
            (Some(branch), Some(a), Some(b)) => (a - b).abs() > 0.5 * self.segment(branch),
            _ => a != b,
        };
        let parts = |place: &EventPlace| EventPlace { s: None, other_s: None, ..place.clone() };
        parts(one) != parts(other)
            || apart(&one.branch, one.s, other.s)
            || apart(&one.other_branch, one.other_s, other.other_s)
    }

    /// Mean length of the segments of a branch, m.
    fn segment(&self, branch: &str) -> f64 {
        let own = self.near.end.branches.iter().find(|own| own.name == branch);
        own.map_or(0.0, |own| own.s[own.s.len() - 1] / (own.s.len() - 1) as f64)
    }
}

impl Catalogue {
    pub fn new(scenario: &Scenario, network: &Network) -> Self {
        let outputs = scenario.sweep.as_ref().map_or(&[][..], |sweep| &sweep.outputs);
        let header = crate::sweep::header_of(Vec::new(), outputs, network);
        let of_path = |name: &String| {
            let worst = outputs.iter().filter(|output| matches!(output.at, When::Min | When::Max));
            let worst = worst.flat_map(crate::sweep::outputs::columns).any(|column| column == *name);
            worst
                || name.starts_with("min_")
                || name.starts_with("max_")
                || matches!(&name[..], "iterations" | "polish")
        };
        let (of_path, mut columns): (Vec<String>, Vec<String>) = header.numbers().into_iter().partition(of_path);
        let markers = network.markers.iter().map(|marker| &marker.name);
        for name in markers.chain(network.joints.iter().map(|joint| &joint.name)) {
            columns.extend(["x", "y", "z"].map(|axis| format!("position_{axis}.{name}")));
        }
        let requirements = network.requirements.iter().map(|requirement| requirement.name.clone()).collect();
        Self { header, columns, requirements, of_path }
    }

    pub fn is_requirement(&self, name: &str) -> bool {
        self.requirements.iter().any(|own| own == name)
    }

    /// Refuses a name that is no output.
    pub fn check(&self, name: &str) -> Result<(), NoAnswer> {
        let own = |all: &[String]| all.iter().any(|own| own == name);
        if own(&self.requirements) || own(&self.columns) {
            return Ok(());
        }
        let why = if own(&self.of_path) {
            format!("`{name}` is of the whole run, not of one equilibrium")
        } else {
            let known = self.requirements.iter().chain(&self.columns).map(String::as_str);
            format!("there is no output `{name}`: {}", did_you_mean(name, known))
        };
        Err(NoAnswer::Question(why))
    }

    /// The outputs that are asked for.
    pub fn names(&self, of: &[String], here: &Measured) -> Result<Vec<String>, NoAnswer> {
        if !of.is_empty() {
            return Ok(of.to_vec());
        }
        let lines = here.requirements.iter().filter(|line| line.worst.is_some() && line.origin != Origin::Always);
        let names: Vec<String> = lines.map(|line| line.name.clone()).collect();
        if names.is_empty() {
            let message = "no requirement has a value at the end of this step: name the outputs to differentiate";
            return Err(NoAnswer::Question(message.to_owned()));
        }
        Ok(names)
    }

    /// Values of all outputs.
    pub fn measured(&self, scenario: &Scenario, network: &Network, near: Nearby) -> Measured {
        let outputs = scenario.sweep.as_ref().map_or(&[][..], |sweep| &sweep.outputs);
        let values = outputs.iter().flat_map(|output| {
            let (columns, values) = (
                crate::sweep::outputs::columns(output).len(),
                crate::sweep::outputs::values(&output.measured, network, &near.end),
            );
            if values.len() == columns { values } else { vec![f64::NAN; columns] }
        });
        let computed = Computed { outputs: values.collect(), ..Computed::default() };
        let end = &near.end;
        let places = end.markers.iter().map(|marker| (&marker.name, marker.position));
        let places: Vec<(String, f64)> = places
            .chain(end.joints.iter().map(|joint| (&joint.name, joint.position)))
            .flat_map(|(name, x)| ["x", "y", "z"].iter().zip([x.x, x.y, x.z]).map(move |(axis, x)| (axis, name, x)))
            .map(|(axis, name, x)| (format!("position_{axis}.{name}"), x))
            .collect();
        let row = Ending::of(&alone(end)).map(|ending| self.header.row(Vec::<Cell>::new(), &ending, computed));
        let numbers = row.map_or_else(Vec::new, |row| row.numbers);
        let numbers = self.header.numbers().into_iter().zip(numbers.into_iter().map(|x| x.unwrap_or(f64::NAN)));
        let columns = numbers.chain(places).collect();
        Measured { columns, requirements: near.requirements.clone(), near }
    }

    /// Remark on an output: its value is not the worst of the run, or it has none.
    pub fn remark(&self, name: &str, ended: &Ended, here: &Measured) -> Option<String> {
        let k = ended.requirements.iter().position(|line| line.name == name)?;
        let line = &ended.requirements[k];
        if line.measure == Measure::InsertionForce {
            return Some("it is the largest force on the way, not a value of one equilibrium".to_owned());
        }
        let (worst, moment) = (line.worst?, line.moment.as_ref()?);
        let words = wireloom_export::sheet::value(line.measure, worst);
        if (&moment.step, moment.increment) != (&ended.end.name, ended.end.increment) {
            let same = here.value(name).is_some_and(|value| (value - worst).abs() <= SAME * worst.abs());
            let Moment { step, increment, .. } = moment;
            return (!same).then(|| format!("its worst value, {words}, is in step `{step}`, increment {increment}"));
        }
        if ended.on_the_way.get(k) == Some(&true) {
            return Some(format!("its worst value, {words}, is on the way through this increment"));
        }
        // Two places are alike up to the accuracy of the run.
        let elsewhere = here.place(name).is_some_and(|place| here.is_elsewhere(place, &line.place));
        elsewhere.then(|| format!("its worst value, {words}, is also at {}", line.place))
    }
}

/// A run that has this end only.
fn alone(end: &StepResult) -> Run {
    Run {
        scenario: String::new(),
        outcome: Outcome::Graded(end.status),
        notes: Vec::new(),
        events: Vec::new(),
        steps: vec![end.clone()],
        clearances: Vec::new(),
        requirements: Vec::new(),
        plugins: Vec::new(),
        identities: Default::default(),
        drawn_start: None,
        sensitivities: Vec::new(),
    }
}

/// An output that is asked for.
pub(super) struct Asked {
    pub name: String,
    pub unit: &'static str,
    pub value: Option<f64>,
    /// Round-off of its value.
    pub noise: f64,
}

impl Asked {
    pub fn new(name: &str, here: &Measured, network: &Network) -> Self {
        let requirement = here.requirements.iter().find(|line| line.name == name);
        let unit = requirement.map_or_else(|| unit_of(name), |line| line.measure.unit());
        let value = here.value(name);
        let noise = noise(unit, &here.near.end, network).max(ROUND_OFF * value.unwrap_or(0.0).abs());
        Self { name: name.to_owned(), unit, value, noise }
    }
}

/// Round-off of a quantity with this unit. The strains of a cable are exact to some rounding errors ε, so its forces to
/// ε EA, its moments to ε EA ℓ with segments of length ℓ, and over a length L its turns to ε EA ℓ L/EI or L/GJ.
fn noise(unit: &str, end: &StepResult, network: &Network) -> f64 {
    let of_branch = |branch: &Branch| {
        let mesh = branch.rod.mesh();
        let length = mesh.length();
        let stiffest = branch.sections.iter().map(wireloom_core::Section::greatest_axial_stiffness).fold(0.0, f64::max);
        let force = ROUNDINGS * f64::EPSILON * stiffest;
        let moment = force * length / mesh.segments() as f64;
        let softest =
            branch.sections.iter().map(|section| section.principal_axes().1.min()).fold(f64::INFINITY, f64::min);
        let turn = moment * length / softest;
        match unit {
            "N" => force,
            "N m" => moment,
            "m" => length * turn.max(ROUND_OFF),
            _ => turn.max(ROUND_OFF),
        }
    };
    let e = &end.energy;
    let energies = [e.stretch, e.shear, e.bend, e.twist, e.gravity, e.load, e.joint, e.constraint];
    match unit {
        "J" => ROUND_OFF * energies.iter().map(|e| e.abs()).sum::<f64>(),
        _ => network.branches.iter().map(of_branch).fold(0.0, f64::max),
    }
}

/// SI unit of a column.
fn unit_of(column: &str) -> &'static str {
    let quantity = column.split('.').next().unwrap_or_default();
    let quantity = ["_w", "_x", "_y", "_z"].iter().fold(quantity, |word, axis| word.strip_suffix(axis).unwrap_or(word));
    match quantity {
        "energy" => "J",
        "force" | "tension" | "contact_force" => "N",
        "moment" => "N m",
        "position" | "bend_radius" | "slack" | "clearance" => "m",
        "angle" => "rad",
        "turns" | "twist_turns" => "turns",
        _ => "",
    }
}
