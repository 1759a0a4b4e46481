//! Independently computed equilibria (two-point boundary value problems, collocation), read where they lie.
//!
//! Positions must be within [`ALLOWED`] times the error that a plain second-order scheme makes with as many segments a
//! branch, and go to the reference with the fourth power of the segment length; reactions within 1e-4 and the energy
//! within 1e-5 of the elastic energy at 160. So must every other model of joints that can stand for the one in a case.
//!
//! The rod `kirchhoff` is held to the positions of the rod without shear in the same way; the error of `mass-spring` is
//! measured.

use libtest_mimic::{Arguments, Failed, Trial};
use serde_json::Value;
use std::path::{Path, PathBuf};
use wireloom::geometry::Vector;
use wireloom::gpu::policy;
use wireloom::gpu::policy::TestDevice;
use wireloom::{Status, StepResult};

fn main() {
    let arguments = Arguments::from_args();
    let folder = wireloom_tests::shared("reference");
    let mut cases: Vec<PathBuf> = std::fs::read_dir(&folder)
        .map(|entries| entries.flatten().map(|entry| entry.path()).collect())
        .unwrap_or_default();
    cases.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    cases.sort();
    let mut trials: Vec<Trial> = cases
        .iter()
        .map(|path| {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let path = path.clone();
            Trial::test(name, move || check(&path))
        })
        .collect();
    trials.extend(cases.iter().flat_map(|path| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let (unshearable, springs) = (path.clone(), path.clone());
        [
            Trial::test(format!("{name}, kirchhoff"), move || check_unshearable(&unshearable)),
            Trial::test(format!("{name}, mass-spring"), move || check_springs(&springs)),
        ]
    }));
    for path in &cases {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(path).unwrap_or_default();
        for (model, becomes) in MODELS.into_iter().filter(|(model, _)| applies(&text, model)) {
            let path = path.clone();
            trials.push(Trial::test(format!("{name}, {model} joint"), move || {
                let text = with_joints(&std::fs::read_to_string(&path)?, becomes);
                // Next to no length, but some: the joint is softer by that than the point of the reference.
                check_text(&path, &text, model != "cosserat")
            }));
        }
    }
    let gpu = policy::device(std::env::var("WIRELOOM_GPU_TESTS").ok().as_deref());
    // What slides has no law on the GPU.
    let fixed = |path: &&PathBuf| std::fs::read_to_string(path).is_ok_and(|text| !text.contains("slide = true"));
    for path in cases.iter().filter(fixed) {
        let name = format!("{}, gpu", path.file_stem().unwrap_or_default().to_string_lossy());
        let path = path.clone();
        trials.push(match &gpu {
            TestDevice::Device(gpu) => {
                let double = gpu.info.double;
                Trial::test(name, move || check_gpu(&path, double))
            }
            TestDevice::Ignored(reason) => {
                Trial::test(format!("{name} (ignored: {reason})"), || Ok(())).with_ignored_flag(true)
            }
            TestDevice::Missing(reason) => {
                let reason = reason.clone();
                Trial::test(name, || Err(reason.into()))
            }
        });
    }
    if trials.is_empty() {
        let reason = format!("reference (ignored: no folder {})", folder.display());
        trials.push(Trial::test(reason, || Ok(())).with_ignored_flag(true));
    }
    libtest_mimic::run(&arguments, trials).exit();
}

/// Largest position error as a fraction of that of a plain second-order scheme.
const ALLOWED: f64 = 0.15;
/// Least order between 40 and 160 segments, where the error is not that of the references.
const LEAST_ORDER: f64 = 3.7;
/// Position error, m, below which the minimiser and the interpolation between nodes show.
const ROUND_OFF: f64 = 1e-9;

/// Forces and moments, N and N m, that the tolerance of the minimiser leaves.
const UNBALANCED: f64 = 3e-8;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().map(|all| all.iter().filter_map(Value::as_f64).collect()).unwrap_or_default()
}

fn vector(value: &Value) -> Vector {
    Vector::from_column_slice(&numbers(value))
}

/// The models of joints, and what makes each of them the point without compliance that the references have; a
/// `cosserat` joint is one where it has next to no length.
const MODELS: [(&str, &str); 3] = [
    ("fused", "model = \"fused\""),
    ("rigid-body", "model = \"rigid-body\""),
    ("cosserat", "model = \"cosserat\"\nlength = \"0.001 mm\""),
];

/// Whether a case has joints of another model, which this one can stand for: only rigid bodies have offsets.
fn applies(text: &str, model: &str) -> bool {
    text.contains("[[joints]]") && !text.contains("offset = ") && !text.contains(&format!("model = \"{model}\""))
}

/// A case with joints of another model.
fn with_joints(text: &str, becomes: &str) -> String {
    let line = |line: &str| if line.starts_with("model = ") { becomes.to_owned() } else { line.to_owned() };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

fn check(path: &Path) -> Result<(), Failed> {
    check_text(path, &std::fs::read_to_string(path)?, true)
}

/// `same`: the references are of this very model, so that all that is between them is the discretisation error.
fn check_text(path: &Path, text: &str, same: bool) -> Result<(), Failed> {
    let expected: Value = serde_json::from_str(&std::fs::read_to_string(path.with_extension("expected.json"))?)?;
    let bars = &expected["position_error_of_a_plain_second_order_scheme_by_segments"];
    let mut errors = Vec::new();
    for segments in [40, 80, 160] {
        let bar = bars[segments.to_string()].as_f64().ok_or("no bar")?;
        let (error, end) = solve(text, segments, &expected["branches"])?;
        if error.is_nan() || error > ALLOWED * bar {
            return Err(format!("{segments} segments: position error {error:.3e}, bar {bar:.3e}").into());
        }
        errors.push(error);
        if same {
            covered(&end, error, &expected["branches"]).map_err(|why| format!("{segments} segments: {why}"))?;
        }
        if segments == 160 {
            reactions_and_energy(&end, &expected)?;
        }
    }
    let order = (errors[0] / errors[2]).log2() / 2.0;
    if same && errors[2] > ROUND_OFF && order < LEAST_ORDER {
        return Err(format!("observed order {order:.2} from errors {errors:?}").into());
    }
    Ok(())
}

/// The minimiser `gpu` comes where `newton` comes, with the help of the CPU: the device knows the scheme of second
/// order only.
fn check_gpu(path: &Path, double: bool) -> Result<(), Failed> {
    let text = std::fs::read_to_string(path)?;
    let expected: Value = serde_json::from_str(&std::fs::read_to_string(path.with_extension("expected.json"))?)?;
    let segments = 40;
    let (error, newton) = solve(&text, segments, &expected["branches"])?;
    for (precision, _) in [("f64", double), ("f32", true)].into_iter().filter(|(_, there)| *there) {
        let kind = format!("kind = \"gpu\"\nprecision = \"{precision}\"");
        let solved = solve(&text.replace("kind = \"newton\"", &kind), segments, &expected["branches"]);
        let (own, end) = solved.map_err(|why| format!("{precision}: {}", why.message().unwrap_or_default()))?;
        if end.minimiser.kind != "gpu" || end.minimiser.force_residual > 1e-8 {
            return Err(format!("{precision}: {:?}", end.minimiser).into());
        }
        if end.minimiser.polish == 0 {
            return Err(format!("{precision}: the CPU made no iterations").into());
        }
        if (own - error).abs() > 1e-6 {
            return Err(format!("{precision}: position error {own:.3e}, with newton {error:.3e}").into());
        }
        let pairs = end.branches.iter().zip(&newton.branches).flat_map(|(a, b)| a.position.iter().zip(&b.position));
        let apart = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        if apart > 1e-7 {
            return Err(format!("{precision}: {apart:e} m from where newton comes").into());
        }
    }
    Ok(())
}

/// A case with another rod than its own, the expected positions being those of the rod without shear.
fn unshearable(path: &Path, rod: &str) -> Result<(String, Value, Value), Failed> {
    let text = std::fs::read_to_string(path)?.replace("\nlength =", &format!("\nrod = \"{rod}\"\nlength ="));
    let expected: Value = serde_json::from_str(&std::fs::read_to_string(path.with_extension("expected.json"))?)?;
    let mut branches = expected["branches"].clone();
    for (name, branch) in branches.as_object_mut().ok_or("no branches")? {
        for (k, span) in branch["spans"].as_array_mut().ok_or("no spans")?.iter_mut().enumerate() {
            span["r"] = expected["positions_of_the_unshearable_rod"][name][k].clone();
        }
    }
    Ok((text, branches, expected["position_error_of_a_plain_second_order_scheme_by_segments"].clone()))
}

/// Position errors of a case with another rod than its own, and the bars.
fn errors_without_shear(path: &Path, rod: &str) -> Result<[(f64, f64); 3], Failed> {
    let (text, branches, bars) = unshearable(path, rod)?;
    let mut found = [(0.0, 0.0); 3];
    for (segments, found) in [40, 80, 160].into_iter().zip(&mut found) {
        let bar = bars[segments.to_string()].as_f64().ok_or("no bar")?;
        *found = (solve(&text, segments, &branches)?.0, bar);
    }
    Ok(found)
}

/// The rod `kirchhoff` is nearer to the rod without shear than a plain second-order scheme of the rod with it.
fn check_unshearable(path: &Path) -> Result<(), Failed> {
    let found = errors_without_shear(path, "kirchhoff")?;
    match found.iter().find(|(error, bar)| error.is_nan() || *error > 0.5 * bar) {
        Some(_) => Err(format!("position errors and bars {found:?}").into()),
        None => Ok(()),
    }
}

/// The chain of springs goes to the same rod, but with the first power of the segment length: with 40 segments a branch
/// it is 5 to 36 mm off in cables of about a metre.
fn check_springs(path: &Path) -> Result<(), Failed> {
    let found = errors_without_shear(path, "mass-spring")?;
    let [coarse, middle, fine] = found.map(|(error, _)| error);
    let first_order = [coarse / middle, middle / fine].iter().all(|ratio| (1.6..2.2).contains(ratio));
    if first_order && (4e-3..4e-2).contains(&coarse) {
        Ok(())
    } else {
        Err(format!("position errors and bars {found:?}").into())
    }
}

/// Position error and last step of a case with so many segments a branch.
fn solve(text: &str, segments: usize, branches: &Value) -> Result<(f64, StepResult), Failed> {
    let text = text.replace("segments = 160", &format!("segments = {segments}"));
    let registry = wireloom::registry();
    let (_, built) = wireloom::load(&text, &registry).map_err(|faults| wireloom::scenario::render(&text, &faults))?;
    let mut run = wireloom::run(built, &mut |_, _| wireloom::Control::Continue);
    if run.status() != Status::Converged {
        let last = run.steps.last().map(|step| &step.minimiser);
        return Err(
            format!("{segments} segments: {:?} {:?} {:?} {last:?}", run.status(), run.notes, run.fault()).into()
        );
    }
    let end = run.steps.pop().ok_or("no step")?;
    Ok((position_error(&end, branches)?, end))
}

/// Largest distance from the expected positions; between nodes by a polynomial through six of them within a span.
fn position_error(end: &StepResult, branches: &Value) -> Result<f64, Failed> {
    let mut worst = 0.0_f64;
    for (name, branch) in branches.as_object().ok_or("no branches")? {
        let found = end.branches.iter().find(|b| b.name == *name).ok_or("a branch is missing")?;
        for span in branch["spans"].as_array().ok_or("no spans")? {
            let s = numbers(&span["s"]);
            let (first, last) = (s[0], s[s.len() - 1]);
            let inside: Vec<usize> =
                (0..found.s.len()).filter(|&i| found.s[i] > first - 1e-9 && found.s[i] < last + 1e-9).collect();
            for (s, r) in s.iter().zip(span["r"].as_array().ok_or("no positions")?) {
                let after = inside.partition_point(|&i| found.s[i] < *s);
                let start = after.saturating_sub(3).min(inside.len() - 6);
                let stencil = &inside[start..start + 6];
                let at: Vector = stencil
                    .iter()
                    .map(|&i| {
                        let others = stencil.iter().filter(|&&k| k != i);
                        let weight: f64 = others.map(|&k| (s - found.s[k]) / (found.s[i] - found.s[k])).product();
                        found.position[i] * weight
                    })
                    .sum();
                worst = worst.max((at - vector(r)).norm());
            }
        }
    }
    Ok(worst)
}

/// The estimates of the discretisation error are not below the true errors: of position, and of internal forces and
/// moments at the nodes where they are expected.
fn covered(end: &StepResult, error: f64, branches: &Value) -> Result<(), String> {
    let estimates = || end.branches.iter().filter_map(|branch| branch.error);
    let estimate = estimates().map(|e| e.position).fold(0.0, f64::max);
    if estimates().count() < end.branches.len() || estimate < error {
        return Err(format!("position error {error:.3e}, estimate {estimate:.3e}"));
    }
    for (name, branch) in branches.as_object().into_iter().flatten() {
        let Some(found) = end.branches.iter().find(|b| b.name == *name) else {
            return Err("a branch is missing".into());
        };
        for span in branch["spans"].as_array().into_iter().flatten() {
            let s = numbers(&span["s"]);
            // At its ends forces and moments may jump.
            for k in 1..s.len() - 1 {
                let Some(node) = found.s.iter().position(|node| (node - s[k]).abs() < 1e-6) else { continue };
                let (n, m) = (vector(&span["n"][k]), vector(&span["m"][k]));
                let errors = [(found.force[node] - n).norm(), (found.moment[node] - m).norm()];
                let estimates = found.error.map_or([0.0; 2], |e| [e.force, e.moment]);
                if errors.iter().zip(estimates).any(|(error, estimate)| *error > estimate + UNBALANCED) {
                    return Err(format!(
                        "{name} at {}: force and moment errors {errors:?}, estimates {estimates:?}",
                        s[k]
                    ));
                }
            }
        }
    }
    Ok(())
}

fn reactions_and_energy(end: &StepResult, expected: &Value) -> Result<(), Failed> {
    for (name, reaction) in expected["constraints"].as_object().ok_or("no constraints")? {
        let found = end.constraints.iter().find(|c| c.name == *name).ok_or("a constraint is missing")?;
        for (what, got, want) in
            [("force", found.force, vector(&reaction["force"])), ("moment", found.moment, vector(&reaction["moment"]))]
        {
            let gap = (got - want).norm();
            if gap.is_nan() || gap > 1e-4 * want.norm() {
                return Err(format!("{what} of {name}: {got:?} instead of {want:?}").into());
            }
        }
    }
    for (name, slide) in expected["sliding"].as_object().into_iter().flatten() {
        let found =
            end.constraints.iter().find(|c| c.name == *name).and_then(|c| c.slide.as_ref()).ok_or("no slide")?;
        let want = slide["contact_arclength"].as_f64().ok_or("no arc length")?;
        if (found.arc_length - want).abs() > 1e-6 * want {
            return Err(format!("the cable is at {} in {name} instead of {want}", found.arc_length).into());
        }
    }
    let want = expected["energy"]["total"].as_f64().ok_or("no energy")?;
    let elastic = expected["energy"]["elastic"].as_f64().ok_or("no energy")?;
    let got = end.energy.total();
    // Not relative to the total, in which elastic energy and gravity nearly cancel.
    let gap = (got - want).abs();
    if gap.is_nan() || gap > 1e-5 * elastic {
        return Err(format!("energy {got} instead of {want}").into());
    }
    Ok(())
}
