//! The scenarios of this repository: all converge, and those with a closed form agree with it, with any minimiser and
//! with the rod `kirchhoff`, too.
//!
//! Beside `scenarios/analytic/NAME.toml` (and those of `assembly` and `mechanisms`) stands `NAME.expected.toml`, a
//! list of `[[check]]`:
//! `step` names the step (its last increment counts), `why` says what is expected, `tolerance` is the largest distance
//! from `value` (default 0).
//!
//! | kind | keys |
//! | --- | --- |
//! | `position` | `branch`, `s` of a node, `value`, m |
//! | `reaction-force`, `reaction-moment` | `constraint`, `value`, N or N m; `part = "z"`: the component along z alone |
//! | `energy` | `part` (`total`, `bend`, …), `value`, J |
//! | `twist` | `branch`, `value`, turns |
//! | `set` | `branch`, `s` of a node, `value`: curvature about d1, d2 and twist that remain without a moment, 1/m |
//! | `dissipated` | `branch`, `value`: by the friction within its section since the start, J |
//! | `set`, `dissipated` | `joint`, `branch`, `value`: likewise of the arm there, rad and J |
//! | `stable` | `value`: what the flag says, true, false or "neutral" |
//! | `unstable` | `branch`, `s`, `value`, m: flagged so, or the node is off its balance by more than `tolerance` |
//! | `same-shape` | `branch` is `as = { branch, from }` at every node (see below) |
//! | `operation` | `constraint` mated, clipped, grasped or carried; `part`: `force` (N), `s`, `reach` (m); `value` |
//! | `slide` | the cable in `constraint`: `part` is `s` (m) or `force` (along the cable, N), `value` |
//! | `motion` | the cable in `constraint`: `value` is `free`, `stick`, `slip` or `stopped` |
//! | `same-reaction` | `constraint` exerts what `as = { constraint }` does |
//!
//! `same-shape` counts nodes from the branch's end if `reversed`, leaves its two ends out if `inner`, and compares its
//! coordinates times `scale` plus `shift`.

use libtest_mimic::{Arguments, Failed, Trial};
use std::path::{Path, PathBuf};
use toml::Value;
use wireloom::geometry::Vector;
use wireloom::result::{ArmFriction, BranchResult, ConstraintResult, FrictionResult, OperationResult, SlideResult};
use wireloom::{Run, Status, StepResult};
use wireloom_testkit::closed_forms;
use wireloom_tests::cables::{self, connector, section};

fn main() {
    let arguments = Arguments::from_args();
    let scenarios = wireloom_tests::root().join("scenarios");
    let mut trials = vec![];
    for path in ["analytic", "assembly", "mechanisms"].iter().flat_map(|folder| files(&scenarios.join(folder))) {
        let plain = path.clone();
        trials.push(Trial::test(name(&path), move || analytic(&plain, Swap::default())));
        for minimiser in ["lbfgs", "ncg"] {
            let (path, trial) = (path.clone(), format!("{}, {minimiser}", name(&path)));
            let swap = Swap { minimiser: Some(minimiser), ..Swap::default() };
            let by_energy = move || match without_potential(&path)? {
                true => declined(&path, swap),
                false => analytic(&path, swap),
            };
            trials.push(Trial::test(trial, by_energy));
        }
        // What is expected there is the closed form of a rod without shear, or has a tolerance that shear is within.
        let swap = Swap { rod: Some("kirchhoff"), ..Swap::default() };
        trials.push(Trial::test(format!("{}, kirchhoff", name(&path)), move || analytic(&path, swap)));
    }
    for path in files(&scenarios.join("branches")).into_iter().chain([scenarios.join("first.toml")]) {
        trials.push(Trial::test(name(&path), move || converged(&path, Swap::default()).map(|_| ())));
    }
    trials.push(Trial::test("expected values are those of the closed forms", values_of_closed_forms));
    trials.push(Trial::test("order: cantilever, against the closed form", order_of_the_cantilever));
    trials.push(Trial::test("order: sag between clamps", order_of_the_sag));
    trials.push(Trial::test("order: hook with rest curvature", order_of_the_hook));
    trials.push(Trial::test("moments beside a joint with two arms are those of the cable", moments_beside_a_joint));
    trials.push(Trial::test("a cable that hangs straight converges on every mesh", straight_on_every_mesh));
    for case in hard_cases() {
        trials.push(Trial::test(format!("error: {}", case.name), move || within_its_estimate(&case)));
    }
    libtest_mimic::run(&arguments, trials).exit();
}

/// The scenarios of a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut found: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    found.retain(|path| {
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        file.ends_with(".toml") && !file.ends_with(".expected.toml")
    });
    found.sort();
    assert!(!found.is_empty(), "{} is empty", folder.display());
    found
}

/// `analytic/catenary`.
fn name(path: &Path) -> String {
    let scenarios = wireloom_tests::root().join("scenarios");
    path.strip_prefix(scenarios).unwrap_or(path).with_extension("").display().to_string()
}

/// The files beside a scenario.
struct Beside<'a>(&'a Path);

impl wireloom::scenario::Files for Beside<'_> {
    fn read(&self, path: &str) -> Result<String, String> {
        std::fs::read_to_string(self.0.with_file_name(path)).map_err(|e| e.to_string())
    }
}

/// Tolerances are made for Newton's method, whose last step goes far below the balance asked for; by gradients one
/// comes just below it.
const SLACK: f64 = 20.0;

/// Kinds in place of those of a scenario.
#[derive(Clone, Copy, Default)]
struct Swap {
    rod: Option<&'static str>,
    minimiser: Option<&'static str>,
}

fn converged(path: &Path, swap: Swap) -> Result<Run, Failed> {
    text_converged(&std::fs::read_to_string(path)?, &Beside(path), swap)
}

fn text_converged(text: &str, files: &dyn wireloom::scenario::Files, swap: Swap) -> Result<Run, Failed> {
    let registry = wireloom::registry();
    let shown = |faults: Vec<wireloom::scenario::Fault>| wireloom::scenario::render(text, &faults);
    let mut scenario = wireloom::scenario::parse_with_files(text, files, &registry).map_err(shown)?;
    if let Some(rod) = swap.rod {
        scenario.branches.iter_mut().for_each(|branch| branch.rod = rod.into());
    }
    if let Some(minimiser) = swap.minimiser {
        scenario.minimiser.kind = minimiser.into();
    }
    let built = scenario.build(&registry).map_err(shown)?;
    let run = wireloom::run(built, &mut |_, _| wireloom::Control::Continue);
    if run.status() == Status::Converged && !run.steps.is_empty() {
        Ok(run)
    } else {
        let steps: Vec<_> = run.steps.iter().map(|step| (&step.name, step.status)).collect();
        Err(format!("{:?} {steps:?} {:?}", run.status(), run.notes).into())
    }
}

/// Whether a scenario has a load without a potential.
fn without_potential(path: &Path) -> Result<bool, Failed> {
    let scenario = std::fs::read_to_string(path)?.parse::<toml::Table>()?;
    let loads = scenario.get("loads").and_then(Value::as_array);
    let without = |load: &Value| ["moment", "follows", "flow"].iter().any(|key| load.get(key).is_some());
    Ok(loads.is_some_and(|loads| loads.iter().any(without)))
}

/// Minimisers that follow gradients name the parts that they cannot handle.
fn declined(path: &Path, swap: Swap) -> Result<(), Failed> {
    match converged(path, swap) {
        Err(fault) if fault.message().is_some_and(|said| said.contains("which has no potential")) => Ok(()),
        Err(fault) => Err(fault),
        Ok(_) => Err("accepted".into()),
    }
}

// ---- against expected values ------------------------------------------------------------------------------------

fn expected(path: &Path) -> Result<Vec<Value>, Failed> {
    let file = path.with_extension("expected.toml");
    let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    let checks = text.parse::<toml::Table>()?.remove("check").ok_or("no checks")?;
    Ok(checks.try_into()?)
}

fn analytic(path: &Path, swap: Swap) -> Result<(), Failed> {
    let run = converged(path, swap)?;
    let mut wrong = vec![];
    for check in &expected(path)? {
        let (step, kind) = (word(check, "step")?, word(check, "kind")?);
        let end = run.steps.iter().rfind(|s| s.name == step).ok_or_else(|| format!("no step `{step}`"))?;
        if let Some(fault) = fault(end, kind, check, if swap.minimiser.is_some() { SLACK } else { 1.0 })? {
            wrong.push(format!("`{step}`: {kind} ({}): {fault}", word(check, "why")?));
        }
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n").into()) }
}

fn word<'a>(check: &'a Value, key: &str) -> Result<&'a str, Failed> {
    check.get(key).and_then(Value::as_str).ok_or_else(|| format!("no `{key}` in {check:?}").into())
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// A number or a list of them.
fn numbers(check: &Value, key: &str) -> Option<Vec<f64>> {
    let value = check.get(key)?;
    value.as_array().map_or_else(|| number(value).map(|x| vec![x]), |all| all.iter().map(number).collect())
}

fn branch<'a>(end: &'a StepResult, name: &str) -> Result<&'a BranchResult, Failed> {
    end.branches.iter().find(|b| b.name == name).ok_or_else(|| format!("no branch `{name}`").into())
}

fn constraint<'a>(end: &'a StepResult, name: &str) -> Result<&'a ConstraintResult, Failed> {
    end.constraints.iter().find(|c| c.name == name).ok_or_else(|| format!("no constraint `{name}`").into())
}

/// Position of the node at arc length `s`.
fn node(branch: &BranchResult, s: f64) -> Result<Vector, Failed> {
    let near = branch.s.iter().position(|at| (at - s).abs() < 1e-9);
    near.map(|i| branch.position[i]).ok_or_else(|| format!("no node of `{}` at s = {s}", branch.name).into())
}

/// Whether a distance is larger than it may be, or no number.
fn beyond(distance: f64, tolerance: f64) -> bool {
    distance.is_nan() || distance > tolerance
}

/// Fault of the end of a step, if any.
fn fault(end: &StepResult, kind: &str, check: &Value, slack: f64) -> Result<Option<String>, Failed> {
    let tolerance = slack * check.get("tolerance").and_then(number).unwrap_or(0.0);
    let found: Vec<f64> = match kind {
        "stable" => {
            // What is neither stable nor unstable is no value of TOML.
            let wanted = match check.get("value") {
                Some(Value::String(word)) if word == "neutral" => None,
                value => Some(value.and_then(Value::as_bool).ok_or("no `value`")?),
            };
            return Ok((end.stable != wanted).then(|| format!("{:?} instead of {wanted:?}", end.stable)));
        }
        "unstable" => {
            let s = check.get("s").and_then(number).ok_or("no `s`")?;
            let balanced = Vector::from_column_slice(&numbers(check, "value").ok_or("no `value`")?);
            let left = (node(branch(end, word(check, "branch")?)?, s)? - balanced).norm();
            let seen = end.stable == Some(false) || left > tolerance;
            return Ok((!seen).then(|| format!("said to be {:?}, {left:.1e} off balance", end.stable)));
        }
        "same-shape" | "same-reaction" => {
            let difference = if kind == "same-shape" { shapes(end, check)? } else { reactions(end, check)? };
            return Ok(beyond(difference, tolerance).then(|| format!("{difference:.3e} apart")));
        }
        "position" => {
            let s = check.get("s").and_then(number).ok_or("no `s`")?;
            node(branch(end, word(check, "branch")?)?, s)?.as_slice().into()
        }
        "reaction-force" | "reaction-moment" => {
            let constraint = constraint(end, word(check, "constraint")?)?;
            let all = if kind == "reaction-force" { constraint.force } else { constraint.moment };
            match check.get("part").and_then(Value::as_str) {
                None => all.as_slice().into(),
                Some(part) => vec![all["xyz".find(part).ok_or("`part` is x, y or z")?]],
            }
        }
        "motion" => {
            let (found, wanted) = (slide(end, check)?.motion.word(), word(check, "value")?);
            return Ok((found != wanted).then(|| format!("{found} instead of {wanted}")));
        }
        "slide" => {
            let slide = slide(end, check)?;
            vec![if word(check, "part")? == "s" { slide.arc_length } else { slide.axial_force }]
        }
        "energy" => {
            let energy = &end.energy;
            vec![match check.get("part").and_then(Value::as_str) {
                None | Some("total") => energy.total(),
                Some("bend") => energy.bend,
                Some("twist") => energy.twist,
                Some("stretch") => energy.stretch,
                Some("joint") => energy.joint,
                Some(other) => return Err(format!("no part `{other}` of the energy").into()),
            }]
        }
        "operation" => vec![operation(end, word(check, "constraint")?, word(check, "part")?)?],
        "twist" => vec![branch(end, word(check, "branch")?)?.twist_turns],
        "set" if check.get("joint").is_some() => arm(end, check)?.set.as_slice().into(),
        "dissipated" if check.get("joint").is_some() => vec![arm(end, check)?.dissipated_in_all],
        "set" => {
            let (branch, s) = (branch(end, word(check, "branch")?)?, check.get("s").and_then(number).ok_or("no `s`")?);
            let i = branch.s.iter().position(|node| (node - s).abs() < 1e-9).ok_or("no node there")?;
            friction(branch)?.set[i].as_slice().into()
        }
        "dissipated" => vec![friction(branch(end, word(check, "branch")?)?)?.dissipated_in_all],
        other => return Err(format!("no kind of check `{other}`").into()),
    };
    let wanted = numbers(check, "value").ok_or("no `value`")?;
    if wanted.len() != found.len() {
        return Err(format!("`value` has {} numbers, not {}", wanted.len(), found.len()).into());
    }
    let distance = wanted.iter().zip(&found).map(|(w, f)| (w - f).powi(2)).sum::<f64>().sqrt();
    Ok(beyond(distance, tolerance).then(|| format!("{found:?} instead of {wanted:?}, {distance:.3e} off")))
}

/// Friction within the section of a branch.
fn friction(branch: &BranchResult) -> Result<&FrictionResult, Failed> {
    branch.friction.as_ref().ok_or_else(|| format!("`{}` has no friction", branch.name).into())
}

/// What slips at an arm of a joint.
fn arm<'a>(end: &'a StepResult, check: &Value) -> Result<&'a ArmFriction, Failed> {
    let (joint, branch) = (word(check, "joint")?, word(check, "branch")?);
    let found = end.joints.iter().find(|own| own.name == joint).ok_or_else(|| format!("no joint `{joint}`"))?;
    found.friction.iter().find(|own| own.branch == branch).ok_or_else(|| format!("`{branch}` does not slip").into())
}

/// Slide of the cable in a constraint that it runs through.
fn slide<'a>(end: &'a StepResult, check: &Value) -> Result<&'a SlideResult, Failed> {
    let name = word(check, "constraint")?;
    constraint(end, name)?.slide.as_ref().ok_or_else(|| format!("nothing runs through `{name}`").into())
}

/// Result of the operation on a constraint.
fn operation(end: &StepResult, name: &str, part: &str) -> Result<f64, Failed> {
    let found = end.operations.iter().find_map(|operation| match (operation, part) {
        (OperationResult::Carry { constraints, force }, "force") => (constraints[0] == name).then_some(*force),
        (OperationResult::Mate { constraint, insertion_force, .. }, "force") if constraint == name => *insertion_force,
        (OperationResult::Clip { constraint, reach, .. }, "reach") => (constraint == name).then_some(*reach),
        (OperationResult::Clip { constraint, place, .. } | OperationResult::Grasp { constraint, place }, "s") => {
            place.as_ref().filter(|_| constraint == name).map(|place| place.1)
        }
        _ => None,
    });
    found.ok_or_else(|| format!("no operation on `{name}` with a `{part}`: {:?}", end.operations).into())
}

/// Largest distance of a branch's nodes from where another one says.
fn shapes(end: &StepResult, check: &Value) -> Result<f64, Failed> {
    let model = check.get("as").ok_or("no `as`")?;
    let (this, other) = (branch(end, word(check, "branch")?)?, branch(end, word(model, "branch")?)?);
    let from = model.get("from").and_then(number).unwrap_or(0.0);
    let reversed = check.get("reversed").and_then(Value::as_bool).unwrap_or(false);
    let triple = |key, default| {
        numbers(check, key).map_or(Vector::repeat(default), |numbers| Vector::from_column_slice(&numbers))
    };
    let (scale, shift) = (triple("scale", 1.0), triple("shift", 0.0));
    let mut worst = 0.0_f64;
    let inner = usize::from(check.get("inner").and_then(Value::as_bool).unwrap_or(false));
    let last = this.s.len() - inner;
    for (s, position) in this.s[inner..last].iter().zip(&this.position[inner..last]) {
        let place = from + if reversed { this.s[this.s.len() - 1] - s } else { *s };
        worst = worst.max((position.component_mul(&scale) + shift - node(other, place)?).norm());
    }
    Ok(worst)
}

/// Largest difference of two constraints' force and moment.
fn reactions(end: &StepResult, check: &Value) -> Result<f64, Failed> {
    let model = check.get("as").ok_or("no `as`")?;
    let (this, other) = (constraint(end, word(check, "constraint")?)?, constraint(end, word(model, "constraint")?)?);
    Ok((this.force - other.force).norm().max((this.moment - other.moment).norm()))
}

// ---- expected values against closed forms -----------------------------------------------------------------------

/// The numbers in the files are written out for readers; here they are held against the formulas.
fn values_of_closed_forms() -> Result<(), Failed> {
    let analytic = wireloom_tests::root().join("scenarios/analytic");
    let value = |file: &str, step: &str, kind: &str, key: &str, at: &str| -> Result<Vec<f64>, Failed> {
        let checks = expected(&analytic.join(file))?;
        let is = |check: &&Value| {
            let place = check.get(key).map(|v| v.as_str().map_or_else(|| format!("{:?}", number(v)), str::to_owned));
            word(check, "step").is_ok_and(|s| s == step)
                && word(check, "kind").is_ok_and(|k| k == kind)
                && place.is_some_and(|p| p == at)
        };
        let check = checks.iter().find(is).ok_or_else(|| format!("{file}: no such check: {step}, {kind}, {at}"))?;
        numbers(check, "value").ok_or_else(|| "no value".into())
    };
    let mut pairs: Vec<(String, Vec<f64>, Vec<f64>)> = vec![];
    for load in [0.5, 1.0, 2.0, 5.0, 10.0] {
        let (step, tip) = (format!("PL2/EI = {load}"), closed_forms::cantilever_tip_load(load));
        let written = value("cantilever_tip_load.toml", &step, "position", "branch", "rod")?;
        pairs.push((step, written, vec![1.0 - tip.shortening, 0.0, -tip.deflection]));
    }
    let circle = |s, moment| {
        let [x, z] = closed_forms::pure_bending(moment, 1.0, s);
        vec![x, 0.0, z]
    };
    let full = 2.0 * std::f64::consts::PI;
    let file = "pure_bending_circle.toml";
    pairs.push((
        "half circle".into(),
        value(file, "half circle", "position", "s", "Some(1.0)")?,
        circle(1.0, 0.5 * full),
    ));
    pairs.push(("circle".into(), value(file, "full circle", "position", "s", "Some(0.5)")?, circle(0.5, full)));
    let turns = closed_forms::greenhill_critical_angle(0.01, 0.008) / full;
    let below = value("greenhill_twist.toml", "one percent below", "twist", "branch", "cable")?;
    pairs.push(("Greenhill".into(), below, vec![0.99 * turns]));
    let mut operator = closed_forms::FrictionOperator::new(0.01, &[[0.02, 0.01], [0.01, 0.03]]);
    for (step, angle) in
        [("turned", Some(90.0)), ("let go", None), ("turned back", Some(-60.0)), ("let go again", None)]
    {
        match angle {
            Some(angle) => _ = operator.bend(f64::to_radians(angle) / 0.5),
            None => _ = operator.let_go(),
        }
        let (dissipated, set) = (0.5 * operator.dissipated(), operator.clone().let_go());
        let file = "friction_set.toml";
        pairs.push((step.into(), value(file, step, "set", "branch", "cable")?, vec![0.0, set, 0.0]));
        pairs.push((step.into(), value(file, step, "dissipated", "branch", "cable")?, vec![dissipated]));
    }
    let mut operator = closed_forms::FrictionOperator::new(0.06, &[[0.2, 0.01], [0.1, 0.01]]);
    for (step, angle) in [("bent", Some(90.0)), ("let go", None), ("bent back", Some(-60.0)), ("let go again", None)] {
        let file = "arm_friction.toml";
        match angle {
            Some(angle) => {
                let moment =
                    closed_forms::arm_in_series(&mut operator, 0.5 / 0.012 + 1.0 / 5.0, f64::to_radians(angle));
                let written = value(file, step, "reaction-moment", "constraint", "wall")?;
                pairs.push((step.into(), written, vec![0.0, moment, 0.0]));
            }
            None => _ = operator.let_go(),
        }
        let (dissipated, set) = (operator.dissipated(), closed_forms::arm_angle(operator.clone().let_go()));
        pairs.push((step.into(), value(file, step, "set", "joint", "J")?, vec![0.0, set, 0.0]));
        pairs.push((step.into(), value(file, step, "dissipated", "joint", "J")?, vec![dissipated]));
    }
    // EI = 0.02, of which 0.9 yield at 2 1/m.
    let mut operator = closed_forms::FrictionOperator::new(0.002, &[[0.018, 0.036]]);
    operator.bend(std::f64::consts::PI / 0.5);
    let written = value("springback.toml", "let go", "set", "branch", "wire")?;
    pairs.push(("springback".into(), written, vec![0.0, operator.let_go(), 0.0]));
    let chain = closed_forms::catenary(0.8, 1.0);
    let [x, depth] = closed_forms::catenary_point(&chain, 0.25);
    pairs.push((
        "sag".into(),
        value("catenary.toml", "hang", "position", "s", "Some(0.5)")?,
        vec![0.4, 0.0, -chain.sag],
    ));
    pairs.push((
        "quarter".into(),
        value("catenary.toml", "hang", "position", "s", "Some(0.25)")?,
        vec![0.4 - x, 0.0, -depth],
    ));
    let even = closed_forms::ring_right_angle([10.0, 10.0], 0.001);
    let free_end = value("ring_pulley.toml", "equilibrium", "position", "s", "Some(0.6)")?;
    let slid = 0.3 + even.excess[0];
    pairs.push(("ring, end".into(), free_end, vec![even.offset[1], 0.0, slid + even.excess[1] - 0.6]));
    pairs.push(("ring, s".into(), value("ring_pulley.toml", "equilibrium", "slide", "part", "s")?, vec![slid]));
    for (step, pull, x) in [("it runs down", 5.0, 0.3), ("pull it up", 20.0, 0.35)] {
        let turn = closed_forms::ring_right_angle([pull, 10.0], 0.001);
        let found = value("ring_friction.toml", step, "slide", "part", "s")?;
        pairs.push((step.into(), found, vec![x + turn.excess[0]]));
        pairs.push(("friction".into(), vec![turn.friction], vec![0.5]));
        let free_end = value("ring_friction.toml", step, "position", "s", "Some(0.6)")?;
        pairs.push((step.into(), free_end, vec![turn.offset[1], 0.0, x + turn.excess[0] + turn.excess[1] - 0.6]));
    }
    let first = closed_forms::chain_through_a_ring([0.4, 0.6], 1.1);
    let chains = [closed_forms::catenary(0.4, first), closed_forms::catenary(0.6, 1.1 - first)];
    pairs.push(("ring, chain".into(), value("ring_catenary.toml", "hang", "slide", "part", "s")?, vec![first]));
    let ring = value("ring_catenary.toml", "hang", "reaction-force", "constraint", "ring")?;
    let pull = 0.981 * (chains[0].parameter - chains[1].parameter);
    pairs.push(("ring, chain's pull".into(), ring, vec![pull, 0.0, 0.981 * 0.55]));
    let tip = closed_forms::cantilever_tip_load(1.0);
    let sleeve = |kind, at| value("sleeve.toml", "load", kind, "constraint", at);
    pairs.push(("sleeve, push".into(), sleeve("reaction-force", "plug-A")?, vec![-tip.slope.sin(), 0.0, 0.0]));
    pairs.push(("sleeve".into(), sleeve("reaction-force", "sleeve")?, vec![tip.slope.sin(), 0.0, 1.0]));
    let weight = 0.1 * 9.81;
    pairs.push((
        "pull".into(),
        value("catenary.toml", "hang", "reaction-force", "constraint", "right")?,
        vec![weight * chain.parameter, 0.0, 0.5 * weight],
    ));
    let column = value("euler_column.toml", "one percent below", "reaction-force", "constraint", "foot")?;
    pairs.push(("Euler".into(), column, vec![0.99 * closed_forms::euler_clamped(1.0, 1.0), 0.0, 0.0]));
    let wrong: Vec<_> =
        pairs.iter().filter(|(_, a, b)| a.iter().zip(b).any(|(a, b)| beyond((a - b).abs(), 1e-8))).collect();
    if wrong.is_empty() { Ok(()) } else { Err(format!("{wrong:#?}").into()) }
}

// ---- order of convergence ---------------------------------------------------------------------------------------

/// A cable of 1 m with so many segments, plugged at its start; `then` is the rest of the file.
fn cable(segments: usize, gravity: f64, curvature: f64, then: &str) -> String {
    [
        &*format!("schema = 1\ngravity = [0, 0, {gravity}]\n[minimiser]\nforce_tolerance = 1e-8\n"),
        &section("cable").replace("axial_stiffness = 1e4", "axial_stiffness = 1e5"),
        &cables::branch("cable", ["A", "B"], "cable", 1.0, segments),
        &format!("curvature = [0, {curvature}, 0]\n"),
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
        then,
    ]
    .concat()
}

/// Segments of the meshes: three to be judged, two finer ones to tell where they go.
const MESHES: [usize; 5] = [20, 40, 80, 160, 320];

/// Positions at the nodes that all meshes have in common, on the first so many meshes.
fn curves(meshes: usize, text: impl Fn(usize) -> String) -> Result<Vec<Vec<Vector>>, Failed> {
    let curve = |&segments: &usize| {
        let run = text_converged(&text(segments), &wireloom::scenario::NoFiles, Swap::default())
            .map_err(|e| format!("{segments} segments: {e:?}"))?;
        let end = run.steps.last().ok_or("no step")?;
        Ok(end.branches[0].position.iter().step_by(segments / MESHES[0]).copied().collect())
    };
    MESHES[..meshes].iter().map(curve).collect()
}

/// `errors` at h, h/2, h/4: both observed orders between 3.7 and 4.5.
fn fourth_order(errors: &[f64]) -> Result<(), Failed> {
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    if orders.len() == 2 && orders.iter().all(|order| (3.7..=4.5).contains(order)) {
        Ok(())
    } else {
        Err(format!("observed orders {orders:.3?} from errors {errors:?}").into())
    }
}

/// Largest distance of the three coarse curves from the limit `(16 f(h/2) − f(h))/15` of the two fine ones
/// (Richardson). The largest over the curve, not that of one point: at the middle of a cable and at a free tip the
/// parts of the error that come from the ends and from between them nearly cancel on coarse meshes.
fn errors(curves: &[Vec<Vector>]) -> Vec<f64> {
    let [.., before, finest] = curves else { unreachable!("several meshes") };
    let distance = |curve: &Vec<Vector>| {
        let limit = finest.iter().zip(before).map(|(fine, coarse)| (fine * 16.0 - coarse) / 15.0);
        limit.zip(curve).map(|(limit, point)| (point - limit).norm()).fold(0.0, f64::max)
    };
    curves[..3].iter().map(distance).collect()
}

/// A cantilever under `P L²/EI = 5`, and its tip; stretch and shear are 1e-6 of it.
fn order_of_the_cantilever() -> Result<(), Failed> {
    let text = |segments| {
        let load = "[[loads]]\nname = \"tip\"\nat = { end = \"B\" }\nforce = [0, 0, -0.05]\n";
        cable(segments, 0.0, 0.0, load)
    };
    let found = curves(5, text)?;
    let exact = closed_forms::cantilever_tip_load(5.0);
    let exact = Vector::new(1.0 - exact.shortening, 0.0, -exact.deflection);
    let error = (found[4][MESHES[0]] - exact).norm();
    if error > 1e-6 {
        return Err(format!("the finest mesh misses the closed form by {error:e} m").into());
    }
    fourth_order(&errors(&found))
}

/// A cable between clamps 0.6 m apart.
fn order_of_the_sag() -> Result<(), Failed> {
    let plug = "[[constraints]]\nname = \"plug-B\"\nkind = \"connector\"\nat = { end = \"B\" }\n\
                position = [0.6, 0, 0]\n\
                tangent = [1, 0, 0]\nup = [0, 0, 1]\n";
    fourth_order(&errors(&curves(5, |segments| cable(segments, -9.81, 0.0, plug))?))
}

/// A hook of radius 0.3 m that hangs from one end.
fn order_of_the_hook() -> Result<(), Failed> {
    fourth_order(&errors(&curves(5, |segments| cable(segments, -9.81, 1.0 / 0.3, ""))?))
}

/// The variation of curvature to the joint's coupling was missing at the nodes beside it: 0.9 % of the moment. The
/// frames of these nodes were those half-way between the frames around them: 7e-4 rad off.
fn moments_beside_a_joint() -> Result<(), Failed> {
    let run = converged(&wireloom_tests::root().join("scenarios/analytic/two_arm_joint.toml"), Swap::default())?;
    let end = run.steps.last().ok_or("no step")?;
    let [plain, left, right] = &end.branches[..] else { return Err("other branches".into()) };
    let joint = left.moment.len() - 1;
    let largest = plain.moment.iter().map(Vector::norm).fold(0.0, f64::max);
    for (k, moment) in plain.moment.iter().enumerate() {
        let own = if k <= joint { left.moment[k] } else { right.moment[k - joint] };
        if (own - moment).norm() > 1e-5 * largest {
            return Err(format!("node {k}: {own:?}, not {moment:?}").into());
        }
        let frame = if k <= joint { left.frame[k] } else { right.frame[k - joint] };
        let turned = frame.angle_to(&plain.frame[k]);
        if turned > 1e-5 {
            return Err(format!("node {k}: turned by {turned} rad").into());
        }
    }
    Ok(())
}

/// It turns freely about itself. With 44 or 59 segments the last pivot of its matrix was exactly zero: the matrix
/// counted as positive definite, and the step was not a number.
fn straight_on_every_mesh() -> Result<(), Failed> {
    let text = std::fs::read_to_string(wireloom_tests::root().join("scenarios/analytic/braking.toml"))?;
    let pieces = "segments = 20";
    assert!(text.contains(pieces), "another mesh");
    for segments in 20..80 {
        let own = text.replace(pieces, &format!("segments = {segments}"));
        text_converged(&own, &wireloom::scenario::NoFiles, Swap::default())
            .map_err(|error| format!("{segments} segments: {error:?}"))?;
    }
    Ok(())
}

// ---- error and its estimate -------------------------------------------------------------------------------------

/// A cable on which a scheme or the estimate of its error once failed.
struct Hard {
    name: &'static str,
    text: String,
    /// Largest error with 40 segments, m: 1.5 times what was found.
    most: f64,
    /// Least order from 40 to 160 segments. Near a clamp a heavy or a thin cable bends within two segments of 25 mm.
    order: f64,
}

/// Cables of 1 m with `{n}` segments, clamped at A.
fn hard_cases() -> Vec<Hard> {
    let text = |stiffness: &str, density: f64, rest: &str, curvature: &str| {
        let section = format!(
            "[sections.cable]\ndiameter = \"8 mm\"\nlinear_density = {density}\naxial_stiffness = 2e4\n\
             shear_stiffness = [8000, 8000]\n{stiffness}\n"
        );
        let branch = cables::branch("cable", ["A", "B"], "cable", 1.0, 77).replace("= 77", "= {n}");
        let start = "schema = 1\n[minimiser]\nforce_tolerance = 1e-9\n";
        [start, &section, &branch, curvature, rest].concat()
    };
    let clamp = |along: &str, up: &str| {
        format!(
            "[[constraints]]\nname = \"a\"\nkind = \"connector\"\nat = {{ end = \"A\" }}\nposition = [0, 0, 0]\n\
                 tangent = {along}\nup = {up}\n"
        )
    };
    let flat = clamp("[1, 0, 0]", "[0, 0, 1]");
    let plug = "[[constraints]]\nname = \"b\"\nkind = \"connector\"\nat = { end = \"B\" }\n";
    let at_middle = |more: &str| {
        format!("[[constraints]]\nname = \"c\"\nkind = \"collar\"\nat = {{ branch = \"cable\", s = 0.5 }}\n{more}\n")
    };
    let step = |moves: &str| format!("[[steps]]\nname = \"move\"\nincrements = 20\n{moves}");
    let to = |constraint: &str, pose: &str| format!("[[steps.move]]\nconstraint = \"{constraint}\"\n{pose}\n");
    let bent = to("b", "position = [0.7, 0.35, -0.1]\ntangent = [0.2, 0.9, 0.3]");
    let round = "bending_stiffness = 0.03\ntorsion_stiffness = 0.025";
    let clip = [&*flat, plug, &at_middle("hold = [\"position\", \"tangent\", \"twist\"]")].concat();
    let ring = [&*flat, plug, &at_middle("hold = [\"position\"]\nslide = true")].concat();
    let moved = to("c", "position = [0.42, 0.05, 0.08]");
    let turned = to("c", "position = [0.42, 0.05, 0.08]\ntangent = [0.8, 0.5, -0.3]\nturns = 0.2");
    let ribbon = "bending_stiffness = [0.02, 0.0008]\ntorsion_stiffness = 0.0015";
    let pulled = step(&to("b", "position = [0.88, 0.05, 0]"));
    let spun = "[[steps]]\nname = \"spin\"\nincrements = 20\nmove = [{ constraint = \"b\", turns = 0.3 }]\n";
    // 95 % of the weight under which a clamped column buckles (Greenhill 1881).
    let column = 0.12 * 9.81 / (7.8373 * 0.95);
    let column = format!("bending_stiffness = {column}\ntorsion_stiffness = 0.12");
    let upright = clamp("[0, 0, 1]", "[1, 0, 0]");
    let heavy = "bending_stiffness = 0.002\ntorsion_stiffness = 0.0015";
    let initial = "[initial]\nbranch = \"cable\"\nposition = [0, 0, 0]\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n";
    let connectors = ["A", "B"]
        .map(|end| format!("[[constraints]]\nname = \"{end}\"\nkind = \"connector\"\nat = {{ end = \"{end}\" }}\n"));
    let connectors = connectors.concat();
    let flow = "[[loads]]\nname = \"wind\"\nspan = { branch = \"cable\" }\nflow = { velocity = [5, 20, 3] }\n";
    let rotating = text(round, 0.12, &[&*flat, plug].concat(), "").replacen(
        "schema = 1\n",
        "schema = 1\nrotation = { point = [0.4, 0, 0], axis = [0, 0, 1], speed = \"200 rpm\" }\n",
        1,
    );
    let case = |name, text: String, most, order| Hard { name, text, most, order };
    vec![
        case(
            "a clip within",
            text(round, 0.12, &[&*clip, &step(&[&*bent, &turned].concat())].concat(), ""),
            1.5e-5,
            3.9,
        ),
        case("a ring within", text(round, 0.12, &[&*ring, &step(&[&*bent, &moved].concat())].concat(), ""), 4e-6, 3.7),
        case("a ribbon, spun", text(ribbon, 0.12, &[&*flat, plug, &pulled, spun].concat(), ""), 7e-4, 3.1),
        case("a heavy cable", text(heavy, 0.5, &[&*flat, plug, &pulled].concat(), ""), 3e-4, 3.2),
        case(
            "a bent cable, held where it is",
            text(round, 0.12, &[initial, &connectors].concat(), "curvature = [0, 3, 0]\n"),
            1.3e-6,
            3.7,
        ),
        case("a cable in a flow", text(round, 0.12, &[&*flat, plug, flow].concat(), ""), 9e-6, 3.3),
        case("a cable in axes that rotate", rotating, 3.5e-6, 3.5),
        case("a column, almost buckled", text(&column, 0.12, &upright, "curvature = [0.02, 0, 0]\n"), 5e-7, 3.7),
    ]
}

/// The error of positions is within the estimate that is stated, on coarse and on fine meshes, and falls as it should.
/// The limit is a mesh of 640 segments.
fn within_its_estimate(case: &Hard) -> Result<(), Failed> {
    let end = |segments: usize| {
        let text = case.text.replace("{n}", &segments.to_string());
        let run = text_converged(&text, &wireloom::scenario::NoFiles, Swap::default())
            .map_err(|e| format!("{segments} segments: {e:?}"))?;
        let branch = run.steps.into_iter().next_back().ok_or("no step")?.branches.swap_remove(0);
        let nodes = branch.position.iter().step_by(segments / MESHES[0]).copied().collect::<Vec<Vector>>();
        Ok::<_, Failed>((nodes, branch.error.ok_or("no estimate")?.position))
    };
    let (limit, _) = end(640)?;
    let mut errors = vec![];
    for segments in [20, 40, 80, 160] {
        let (nodes, estimate) = end(segments)?;
        let error = nodes.iter().zip(&limit).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        if error > estimate {
            return Err(format!("{segments} segments: {error:e} m, estimated as {estimate:e} m").into());
        }
        errors.push(error);
    }
    let order = (errors[1] / errors[3]).log2() / 2.0;
    let kept = errors[1] <= case.most && order >= case.order;
    if kept { Ok(()) } else { Err(format!("order {order:.2}, errors {errors:?}").into()) }
}
