//! The twist of an end at which a loop snaps out of its shape.

use super::loops::{CABLES, plain};
use rayon::prelude::*;
use std::sync::LazyLock;
use wireloom::Control;

/// Measured twist, degrees (white, black, red).
pub const MEASURED: [f64; 3] = [975.0, 482.0, 450.0];
/// GJ/EI of a round solid wire with a Poisson ratio of 0.3.
pub const SOLID: f64 = 1.0 / 1.3;
/// Twist of an increment, degrees: 1 to 2 % of what was measured.
const INCREMENT: f64 = 10.0;
/// Largest twist, turns.
const TURNS: f64 = 5.0;
/// Difference from the measured twist that is near, relative to it.
const NEAR: f64 = 0.04;
/// Largest number of ratios that are tried.
const TRIALS: usize = 5;
/// Change of the largest distance from the plane in an increment that is a snap, m.
const SNAP: f64 = 0.02;

/// Twists of a cable.
pub struct Twists {
    /// With [`SOLID`], degrees; `None`: it does not snap up to the largest twist.
    pub solid: Option<f64>,
    /// GJ/EI with which it snaps near the measured twist, and the twist there, degrees.
    pub fitted: Option<(f64, f64)>,
}

/// All cables, each straight at rest, with the bending stiffness of all its loops.
pub static ALL_TWISTS: LazyLock<Vec<Twists>> =
    LazyLock::new(|| (0..CABLES.len()).into_par_iter().map(twists).collect());

fn twists(cable: usize) -> Twists {
    let Ok((text, stiffness)) = plain(cable) else { return Twists { solid: None, fitted: None } };
    let at = |ratio: f64| snaps(&text, ratio * stiffness);
    let solid = at(SOLID);
    // The twist goes nearly with EI/GJ.
    let mut fitted = solid.map(|twist| (SOLID, twist));
    for _ in 0..TRIALS {
        let Some((ratio, twist)) = fitted else { break };
        if (twist / MEASURED[cable] - 1.0).abs() <= NEAR {
            break;
        }
        let ratio = ratio * twist / MEASURED[cable];
        fitted = at(ratio).map(|twist| (ratio, twist));
    }
    Twists { solid, fitted }
}

/// Twist at which a scenario's loop snaps, degrees.
fn snaps(text: &str, torsion: f64) -> Option<f64> {
    let (harness, _) = text.split_once("[[steps]]")?;
    let harness = harness
        .lines()
        .map(|line| match line.starts_with("torsion_stiffness") {
            true => format!("torsion_stiffness = {torsion:?}\n"),
            false => format!("{line}\n"),
        })
        .collect::<String>();
    let increments = (360.0 * TURNS / INCREMENT) as usize;
    let steps = format!(
        "[[steps]]\nname = \"twist\"\nincrements = {increments}\n\
         [[steps.move]]\nconstraint = \"B\"\nturns = {TURNS:?}\n"
    );
    let (_, built) = wireloom::load(&(harness + &steps), &wireloom::registry()).ok()?;
    let (mut before, mut snapped) = (0.0, None);
    wireloom::run(built, &mut |progress, end| {
        let off = end.branches.iter().flat_map(|branch| &branch.position).map(|x| x.y.abs()).fold(0.0, f64::max);
        let moved: f64 = off - before;
        if moved.abs() > SNAP || end.stable == Some(false) {
            snapped = Some(INCREMENT * (progress.increment - 1) as f64);
            return Control::Stop;
        }
        before = off;
        Control::Continue
    });
    snapped
}
