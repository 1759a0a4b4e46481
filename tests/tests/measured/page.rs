//! The page `reality.md`: figures of everything that is held against measurements, and pictures.

use super::loops::{self, CABLES};
use super::{bending, twist};
use libtest_mimic::Failed;
use std::fmt::Write;
use wireloom::export::picture::{MeasuredShape, write_measured};
use wireloom_tests::root;

/// Differences of numbers that count as none, relative and absolute: another system's mathematics library.
const SAME: (f64, f64) = (0.03, 0.11);

/// Writes the page and its pictures (`WIRELOOM_REALITY=write`), or compares its figures with those that are computed.
pub fn page() -> Result<(), Failed> {
    let folder = root().join("scenarios/measured");
    let text = text()?;
    if std::env::var_os("WIRELOOM_REALITY").is_some_and(|value| value == "write") {
        std::fs::write(folder.join("reality.md"), &text)?;
        for (k, cable) in CABLES.iter().enumerate() {
            let met: Vec<&'static loops::Met> = loops::ALL[3 * k..3 * k + 3].iter().flatten().collect();
            let shape = |met: &&'static loops::Met| MeasuredShape {
                words: format!("loop {}: mean distance {:.1} mm", met.other, 1e3 * met.mean),
                step: &met.end,
                points: met.points.clone(),
            };
            let shapes: Vec<MeasuredShape<'_>> = met.iter().map(shape).collect();
            let title = format!("{} cable: each loop computed from the two others", cable.0);
            let mut svg = Vec::new();
            write_measured(&shapes, &title, &mut svg)?;
            std::fs::write(folder.join(format!("reality-{}.svg", cable.0)), svg)?;
        }
        return Ok(());
    }
    let written = std::fs::read_to_string(folder.join("reality.md"))?;
    let number = |word: &str| word.trim_matches(['%', '|', ',', ';', ':', '(', ')', '.']).parse::<f64>();
    let same = |one: &str, other: &str| match (number(one), number(other)) {
        (Ok(one), Ok(other)) => (one - other).abs() <= (SAME.0 * one.abs()).max(SAME.1),
        _ => one == other,
    };
    let (old, new): (Vec<&str>, Vec<&str>) = (written.split_whitespace().collect(), text.split_whitespace().collect());
    let differs = old.iter().zip(&new).find(|(old, new)| !same(old, new));
    match differs {
        Some((old, new)) => Err(format!("reality.md says `{old}`, not `{new}`: cargo xtask reality").into()),
        None if old.len() != new.len() => Err("reality.md has other words: cargo xtask reality".into()),
        None => Ok(()),
    }
}

fn text() -> Result<String, Failed> {
    let mut page = HEAD.to_owned();
    for (k, cable) in CABLES.iter().enumerate() {
        let mut row = format!("| {} |", cable.0);
        for met in &loops::ALL[3 * k..3 * k + 3] {
            let met = met.as_ref().map_err(Clone::clone)?;
            let missed = if met.mean > cable.3 { " missed" } else { "" };
            let doubt = met.doubt.as_ref().map_or(String::new(), |doubt| format!(" ( {doubt} )"));
            write!(row, " {:.1}{missed}{doubt} |", 1e3 * met.mean)?;
        }
        let all = loops::ALL[3 * k..3 * k + 3].iter().flatten().map(|met| 1e4 * met.stiffness);
        let (least, most) = all.fold((f64::INFINITY, 0.0_f64), |(least, most), x| (least.min(x), most.max(x)));
        writeln!(page, "{row} {:.1} | {least:.1} to {most:.1} |", 1e3 * cable.3)?;
    }
    page += TWIST;
    for (k, cable) in CABLES.iter().enumerate() {
        let own = &twist::ALL_TWISTS[k];
        let solid = own.solid.map_or("none up to 1800".to_owned(), |twist| format!("{twist:.0}"));
        let fitted = own.fitted.map_or("none".to_owned(), |(ratio, twist)| format!("{ratio:.1} ( {twist:.0} )"));
        writeln!(page, "| {} | {} | {solid} | {fitted} |", cable.0, twist::MEASURED[k])?;
    }
    page += BENDING;
    for own in bending::ALL.iter() {
        let own = own.as_ref().map_err(Clone::clone)?;
        let curves: Vec<String> =
            own.curves.iter().map(|(run, rms)| format!("run {run}: {:.1} %", 1e2 * rms)).collect();
        let (value, deviation) = own.stiffness;
        let deviation = deviation.map_or("not identifiable".to_owned(), |own| format!("± {:.3}", 1e4 * own));
        let met = if own.should { "met" } else { "missed" };
        let curves = curves.join(", ");
        writeln!(page, "| {} | {} | {:.3} {deviation} | {curves} | {met} |", own.sample, own.words, 1e4 * value)?;
    }
    Ok(page)
}

const HEAD: &str = "\
# Held against reality

This page is written by `cargo xtask reality`; a test compares its figures with those that are computed. The measured
data are not part of the project: sources and licences stand with each table.

## Loops of three electric cables

Cables of 1.5 m, clamped at both ends, lie in a vertical plane; 51 points of each were measured (github
qj25/adapteddlo_muj at 6ed3708, MIT licence, (c) 2024 qjchen). A cable is a bending stiffness and a rest curvature in
ten pieces, with a smooth prior. Both are identified from two of its three loops; the third loop is computed. Figures
are mean distances of points of the same arc length, in mm, of the loop that was not used.

![white](reality-white.svg)
![black](reality-black.svg)
![red](reality-red.svg)

| cable | loop 0 | loop 1 | loop 2 | aim | EI, 1e-4 N m² |
| --- | --- | --- | --- | --- | --- |
";

const TWIST: &str = "
The loops of one cable are 1 to 12 mm apart: they were laid anew, and the cables have a set. What is missed is missed
because these loops differ from the two others by more than the aim.

## Twist at which a loop snaps

One end of a loop is turned until the loop leaves its shape with a snap; before, it swings out of its plane little by
little. The cable is straight at rest, with one bending stiffness for all its loops. The torsion stiffness was not
measured, so this is no prediction: one column is for a round solid wire (GJ/EI = 0.77), the last one has the ratio that
comes near to the measured twist, with the twist that is computed for it. A ratio above 1 is more than a solid wire has:
of the black and the red cable, which have sets, the measured twist is not explained.

| cable | measured, degrees | computed with GJ/EI = 0.77 | GJ/EI that comes near ( twist ) |
| --- | --- | --- | --- |
";

const BENDING: &str = "
## Three-point bending, layer by layer

Loads over deflections of a medical cable (github ekremekc/pulsevad-optimal at 7605b45, GPL-3.0, folder
mechanical_optimization/data/3pointbending/hm3), identified with the scenario `three_point_bending.toml` in the size of
each sample. Differences are root mean squares relative to those of the load, up to a deflection of 12 mm (sample 1: 4
mm, beyond it the wire runs over the supports with jumps). The aim is 10 % for each curve. Runs of sample 5 are 20 %
apart: no curve is within 10 % of both.

| sample | section | EI, 1e-4 N m² | difference | aim |
| --- | --- | --- | --- | --- |
";
