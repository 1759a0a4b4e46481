//! Three-point bending of a cable that was built up layer by layer.

use libtest_mimic::Failed;
use std::sync::LazyLock;
use wireloom::identify::{FitStatus, Request, Wishes, identify};
use wireloom::scenario::NoFiles;
use wireloom::sensitivity::Source;
use wireloom_tests::{root, shared};

/// A test: words, sample, runs, diameter, span, radius of the supports, stroke (mm), EI at the start, what it
/// remembers, whether its curves should be met.
type Case = (&'static str, u32, &'static [u32], [f64; 4], f64, Layers, bool);

/// What a section remembers.
#[derive(Clone, Copy, PartialEq)]
pub enum Layers {
    /// Nothing.
    Linear,
    /// Layers that slip: one element of friction.
    Slip,
    /// Bends beyond a limit are permanent.
    Yield,
}

/// Of sample 5 the two runs are 20 % apart, so no curve is within 10 % of both.
const CASES: [Case; 8] = [
    ("one wire, linear", 1, &[1, 2], [0.8, 12.8, 2.0, 4.0], 5e-6, Layers::Linear, false),
    ("one wire that yields", 1, &[1, 2], [0.8, 12.8, 2.0, 4.0], 5e-6, Layers::Yield, true),
    ("6 wires, braid, insulation: run 1", 5, &[1], [3.6, 57.6, 5.0, 12.0], 2.5e-4, Layers::Slip, true),
    ("6 wires, braid, insulation: run 2", 5, &[2], [3.6, 57.6, 5.0, 12.0], 2.5e-4, Layers::Slip, true),
    ("6 wires, braid, insulation: both runs", 5, &[1, 2], [3.6, 57.6, 5.0, 12.0], 2.5e-4, Layers::Slip, false),
    ("with the outer braid: run 1", 6, &[1], [4.8, 76.8, 5.0, 12.0], 2.5e-4, Layers::Slip, true),
    ("with the outer braid: both runs", 6, &[1, 2], [4.8, 76.8, 5.0, 12.0], 2.5e-4, Layers::Slip, true),
    ("with the outer braid, linear", 6, &[1, 2], [4.8, 76.8, 5.0, 12.0], 4e-4, Layers::Linear, false),
];
/// Largest difference of curves that are met, relative to the load.
const LARGEST: f64 = 0.1;

/// A fitted test.
pub struct Fitted {
    /// Words.
    pub words: &'static str,
    /// Number of the sample.
    pub sample: u32,
    /// Runs, and the differences of their curves relative to the load.
    pub curves: Vec<(u32, f64)>,
    /// Bending stiffness, N m²: value, deviation.
    pub stiffness: (f64, Option<f64>),
    /// Whether the curves should be met.
    pub should: bool,
}

/// All tests.
pub static ALL: LazyLock<Vec<Result<Fitted, String>>> = LazyLock::new(|| {
    CASES
        .iter()
        .map(|case| fitted(*case).map_err(|failed| failed.message().unwrap_or("it failed").to_owned()))
        .collect()
});

/// Names of the tests.
pub fn names() -> impl Iterator<Item = (usize, String)> {
    CASES.iter().enumerate().map(|(k, case)| (k, format!("sample {}, {}", case.1, case.0)))
}

/// Whether the curves are met as closely as they should.
pub fn check(k: usize) -> Result<(), Failed> {
    let fitted = ALL[k].as_ref().map_err(Clone::clone)?;
    let worst = fitted.curves.iter().map(|(_, relative)| *relative).fold(0.0, f64::max);
    let met = worst <= LARGEST;
    if met == fitted.should { Ok(()) } else { Err(format!("{:.1} % of the load", 1e2 * worst).into()) }
}

fn fitted((words, sample, runs, size, start, layers, should): Case) -> Result<Fitted, Failed> {
    let text = scenario(size, start, layers)?;
    let read = |run: &u32| {
        std::fs::read_to_string(shared("data/measured/bending").join(format!("sample{sample}_run{run}.csv")))
    };
    let tables: Vec<String> = runs.iter().map(read).collect::<Result<_, _>>()?;
    let tables: Vec<&str> = tables.iter().map(String::as_str).collect();
    let more: &[&str] = match layers {
        Layers::Linear => &[],
        Layers::Slip => &["friction.slip_moment", "friction.stiff_ratio"],
        Layers::Yield => &["set.yield_curvature", "set.hardening"],
    };
    let fit: Vec<String> =
        ["bending_stiffness"].iter().chain(more).map(|key| format!("sections.cable.{key}")).collect();
    let registry = wireloom::registry();
    let wishes = Wishes { fit: &fit, ..Wishes::default() };
    let request = Request { bending: &tables, wishes, ..Request::default() };
    let found = identify(Source::new(&text, &NoFiles, &registry), &request)?;
    if found.status != FitStatus::Converged {
        return Err(format!("{} after {} iterations", found.status.words(), found.iterations).into());
    }
    let curves = runs.iter().zip(&found.curves).map(|(run, curve)| (*run, curve.relative)).collect();
    let own = &found.parameters[0];
    Ok(Fitted { words, sample, curves, stiffness: (own.ended_at, own.deviation), should })
}

/// The test of the repository with another size (diameter, span, radius of the supports, stroke, mm).
fn scenario([diameter, span, radius, stroke]: [f64; 4], start: f64, layers: Layers) -> Result<String, Failed> {
    let text = std::fs::read_to_string(root().join("scenarios/measured/three_point_bending.toml"))?;
    let text = match layers {
        Layers::Slip => text,
        other => text
            .lines()
            .map(|line| match (line.starts_with("friction = "), other) {
                (true, Layers::Yield) => "set = { yield_curvature = \"40 1/m\", hardening = 0.3 }\n".to_owned(),
                (true, _) => String::new(),
                (false, _) => format!("{line}\n"),
            })
            .collect(),
    };
    // A node lies above each support, and the ends do not slip off it.
    let segment = span / 48.0;
    let half = 0.5 * span + segment * (0.5 * span.max(2.0 * stroke) / segment / 1.5).ceil();
    let axis = -(radius + 0.5 * diameter);
    let mm = |key: &str, value: f64| (key.to_owned(), 1e-3 * value);
    let values = [
        mm("sections.cable.diameter", diameter),
        ("sections.cable.bending_stiffness".to_owned(), start),
        mm("branches.cable.length", 2.0 * half),
        mm("branches.cable.max_segment", segment),
        mm("constraints.nose.at.s", half),
        mm("obstacles.left.position.0", -0.5 * span),
        mm("obstacles.right.position.0", 0.5 * span),
        mm("obstacles.left.position.2", axis),
        mm("obstacles.right.position.2", axis),
        mm("obstacles.left.radius", radius),
        mm("obstacles.right.radius", radius),
        mm("steps.bend.move.nose.position.2", -stroke),
    ];
    let registry = wireloom::registry();
    values.into_iter().try_fold(text, |text, (key, value)| {
        let value = wireloom::parts::Value::Number(value);
        wireloom::scenario::record::with_value(&text, &key, &value, &registry)
            .map_err(|fault| format!("{key}: {}", fault.message).into())
    })
}
