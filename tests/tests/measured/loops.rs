//! Loops of three electric cables: a cable is identified from two of its loops, and the third one is computed.

use libtest_mimic::Failed;
use rayon::prelude::*;
use std::fmt::Write;
use std::path::Path;
use std::sync::LazyLock;
use wireloom::geometry::Vector;
use wireloom::identify::{FitStatus, Request, Wishes, identify};
use wireloom::result::StepResult;
use wireloom::scenario::NoFiles;
use wireloom::sensitivity::Source;
use wireloom::{Control, Status};
use wireloom_tests::shared;

/// Length of a cable, m.
const LENGTH: f64 = 1.5;
/// Number of pieces of a cable, each with a rest curvature of its own.
const PIECES: usize = 10;
/// Measured points of a piece: they are 30 mm apart.
const POINTS: usize = 5;
/// Deviation of the rest curvatures of neighbouring pieces, 1/m: a cable that was kept on a coil is bent by some 1/m.
const SMOOTH: f64 = 5.0;

/// Name, mass per length (kg/m), start of the bending stiffness (N m²), largest mean distance of a loop that was not
/// used (m).
pub type Cable = (&'static str, f64, f64, f64);

/// The measured loops of one cable are 1 to 12 mm apart in the mean: they were laid anew, and the cables have a set.
/// A loop can hardly be met better than the mean of the two others does: 1.3 to 2.6 mm (white), 5.0 to 6.6 mm (red),
/// 8.7, 9.5 and 2.9 mm (black). Of the black cable the first two loops are so far from the others that they are not
/// asked for; the page shows them.
///
/// Reached: 1.8, 1.7 and 3.1 mm (white), 6.9, 5.9 and 5.7 mm (red), 3.2 mm (black, the last loop).
pub const CABLES: [Cable; 3] =
    [("white", 0.087 / 5.0, 1e-4, 3.5e-3), ("black", 0.081 / 2.98, 1e-3, 7e-3), ("red", 0.043 / 2.0, 1e-3, 7e-3)];

/// A loop that was computed from what two others say.
pub struct Met {
    /// Index of the loop.
    pub other: usize,
    /// Its equilibrium.
    pub end: StepResult,
    /// Measured and computed points.
    pub points: Vec<[Vector; 2]>,
    /// Mean distance, m.
    pub mean: f64,
    /// Fitted bending stiffness, N m².
    pub stiffness: f64,
    /// What is wrong with the fit or the equilibrium.
    pub doubt: Option<String>,
}

/// All loops of all cables.
pub static ALL: LazyLock<Vec<Result<Met, String>>> = LazyLock::new(|| {
    let all: Vec<(usize, usize)> =
        (0..CABLES.len()).flat_map(|cable| (0..3).map(move |other| (cable, other))).collect();
    let met = |(cable, other): (usize, usize)| {
        other_loop(cable, other).map_err(|failed| failed.message().unwrap_or("it failed").to_owned())
    };
    all.into_par_iter().map(met).collect()
});

/// Whether a loop is met as closely as it should.
pub fn check(cable: usize, other: usize) -> Result<(), Failed> {
    let met = ALL[3 * cable + other].as_ref().map_err(Clone::clone)?;
    if let Some(doubt) = &met.doubt {
        return Err(doubt.clone().into());
    }
    let (largest, mean) = (CABLES[cable].3, met.mean);
    if mean <= largest { Ok(()) } else { Err(format!("{:.2} mm > {:.2} mm", 1e3 * mean, 1e3 * largest).into()) }
}

/// Points of a loop, x and z upwards, m.
fn points(cable: &str, k: usize) -> Result<Vec<[f64; 2]>, Failed> {
    let text = std::fs::read_to_string(shared("data/measured/loops").join(Path::new(&format!("{cable}{k}.csv"))))?;
    let point = |line: &str| {
        let (x, z) = line.split_once(',').ok_or("two columns")?;
        Ok([x.trim().parse::<f64>()?, -z.trim().parse::<f64>()?])
    };
    text.lines().skip(1).map(point).collect()
}

/// The cable in pieces, drawn as its first loop: so it hangs in one plane, without twist, as it was measured.
fn scenario((cable, density, stiffness, _): Cable) -> Result<String, Failed> {
    let mut text = format!(
        "schema = 1\nname = \"{cable}\"\n[sections.cable]\ndiameter = \"5 mm\"\nlinear_density = {density:?}\n\
         axial_stiffness = 1e4\nbending_stiffness = {stiffness:?}\ntorsion_stiffness = {:?}\n",
        0.8 * stiffness
    );
    let length = LENGTH / PIECES as f64;
    let drawn = points(cable, 0)?;
    for k in 0..PIECES {
        let from = if k == 0 { "A".to_owned() } else { format!("J{k}") };
        let to = if k + 1 == PIECES { "B".to_owned() } else { format!("J{}", k + 1) };
        let path: Vec<[f64; 3]> = drawn[k * POINTS..=(k + 1) * POINTS].iter().map(|[x, z]| [*x, 0.0, *z]).collect();
        writeln!(
            text,
            "[[branches]]\nname = \"p{k}\"\nfrom = \"{from}\"\nto = \"{to}\"\nsection = \
             \"cable\"\nlength = {length:?}\n\
             segments = {}\ncurvature = [0.0, 0.0, 0.0]\npath = {path:?}",
            2 * POINTS
        )?;
        if k > 0 {
            let before = k - 1;
            writeln!(
                text,
                "[[joints]]\nname = \"J{k}\"\nmodel = \"fused\"\narms = [{{ branch = \"p{before}\", \
                 direction = [-1, 0, \
                 0], up = [0, 0, 1] }}, {{ branch = \"p{k}\", direction = [1, 0, 0], up = [0, 0, 1] }}]"
            )?;
        }
    }
    for k in 1..PIECES * POINTS {
        let (piece, s) = ((k - 1) / POINTS, ((k - 1) % POINTS + 1) as f64 * length / POINTS as f64);
        writeln!(text, "[[markers]]\nname = \"m{k}\"\nat = {{ branch = \"p{piece}\", s = {s:.6} }}")?;
    }
    let end = |k: usize| points(cable, k).map(|points| points[points.len() - 1]);
    for (name, [x, z]) in [("A", [0.0; 2]), ("B", end(0)?)] {
        writeln!(
            text,
            "[[constraints]]\nname = \"{name}\"\nkind = \"connector\"\nat = {{ end = \"{name}\" }}\nposition = [{x:?}, \
             0, {z:?}]\ntangent = [1, 0, 0]\nup = [0, 0, 1]"
        )?;
    }
    for k in 0..3 {
        let [x, z] = end(k)?;
        writeln!(
            text,
            "[[steps]]\nname = \"loop {k}\"\nincrements = 1\n[[steps.move]]\nconstraint = \"B\"\nposition = [{x:?}, 0, \
             {z:?}]"
        )?;
    }
    Ok(text)
}

/// Table of the points of some loops.
fn table(cable: Cable, used: impl Fn(usize) -> bool) -> Result<String, Failed> {
    let mut table = "configuration,marker,x,y,z\n".to_owned();
    for k in (0..3).filter(|k| used(*k)) {
        for (i, [x, z]) in points(cable.0, k)?.into_iter().enumerate().skip(1).take(PIECES * POINTS - 1) {
            // How far out of the plane was not measured.
            writeln!(table, "loop {k},m{i},{x:?},,{z:?}")?;
        }
    }
    Ok(table)
}

/// A cable without rest curvature, of which only the bending stiffness was identified, from all its loops: the scenario
/// and the stiffness.
pub fn plain(index: usize) -> Result<(String, f64), Failed> {
    let cable = CABLES[index];
    let (text, table) = (scenario(cable)?, table(cable, |_| true)?);
    let fit = ["sections.cable.bending_stiffness".to_owned()];
    let registry = wireloom::registry();
    let wishes = Wishes { fit: &fit, ..Wishes::default() };
    let request = Request { tables: &[&table], wishes, ..Request::default() };
    let found = identify(Source::new(&text, &NoFiles, &registry), &request)?;
    Ok((found.text, found.parameters[0].ended_at))
}

/// Identifies a cable from two loops, and computes the other one.
fn other_loop(index: usize, other: usize) -> Result<Met, Failed> {
    let cable = CABLES[index];
    let text = scenario(cable)?;
    let table = table(cable, |k| k != other)?;
    let curvatures: Vec<String> = (0..PIECES).map(|k| format!("branches.p{k}.curvature.1")).collect();
    let fit: Vec<String> =
        ["sections.cable.bending_stiffness".to_owned()].into_iter().chain(curvatures.clone()).collect();
    let smooth = [(curvatures, SMOOTH)];
    let registry = wireloom::registry();
    let wishes = Wishes { fit: &fit, smooth: &smooth, ..Wishes::default() };
    let request = Request { tables: &[&table], wishes, ..Request::default() };
    let found = identify(Source::new(&text, &NoFiles, &registry), &request)?;
    let (_, built) = wireloom::load(&found.text, &registry).map_err(|faults| format!("{faults:?}"))?;
    let run = wireloom::run(built, &mut |_, _| Control::Continue);
    let computed = run.steps.iter().find(|step| step.name == format!("loop {other}")).ok_or("it came to its end")?;
    let doubt = if found.status != FitStatus::Converged {
        Some(found.status.words().to_owned())
    } else if !found.repeatable {
        Some("the fitted scenario comes to other equilibria".to_owned())
    } else if computed.status != Status::Converged || computed.stable != Some(true) {
        Some(format!("{:?}, stable: {:?}", computed.status, computed.stable))
    } else {
        None
    };
    let measured = points(cable.0, other)?;
    // Both ends are held where they were measured.
    let pair = |(k, [x, z]): (usize, &[f64; 2])| [Vector::new(*x, 0.0, *z), computed.markers[k].position];
    let points: Vec<[Vector; 2]> = measured[1..PIECES * POINTS].iter().enumerate().map(pair).collect();
    let mean = points.iter().map(|[one, other]| (one - other).norm()).sum::<f64>() / points.len() as f64;
    let (end, stiffness) = (computed.clone(), found.parameters[0].ended_at);
    Ok(Met { doubt, other, end, points, mean, stiffness })
}
