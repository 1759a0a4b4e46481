//! Judges a scene: everything that can be found wrong with what the program claims of it.

use super::balance;
use super::compare::{apart, moved};
use super::outcome::{EventOutcome, Outcome, Ran, StepOutcome, run, run_keeping};
use super::scene::{Minimiser, Scene, Step};
use super::variants::{self, Variant};
use wireloom::geometry::{Rotation, Vector};

/// Shapes nearer to each other are the same: share of the longest branch.
const SAME: f64 = 1e-3;
/// Distance that a converged shape may move when it is solved more tightly, as a fraction of its size.
const STAYS: f64 = 1e-4;
/// Fractions of gravity by which a stable shape is disturbed. It must come back from the smallest one at least.
const NUDGES: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// Energies are equal: share of what is stored in the harness, and of what is measured from the origin of the world.
const EQUAL: f64 = 1e-7;
const ROUND_OFF: f64 = 1e-12;
/// Turn of neighbouring segments (rad) from which on their moment falls: no wonder if nothing converges then.
const SLIPS: f64 = 1.8;
/// As two meshes agree, or a half of that with twice as many segments.
const MESH: f64 = 0.05;

/// Fault with its scene.
#[derive(Clone)]
pub struct Fault {
    /// In a few words: what shrinking keeps.
    pub kind: &'static str,
    /// Change of the scene under test; empty: none.
    pub said: &'static str,
    /// The numbers.
    pub words: String,
    /// The scene that shows it.
    pub scene: Scene,
}

/// Result of checking a scene.
#[derive(Default)]
pub struct Checked {
    /// Called converged.
    pub converged: bool,
    /// Not converged, and told that a mesh is too coarse for it.
    pub too_coarse: bool,
    /// Called stable.
    pub stable: bool,
    /// Refused before it ran.
    pub refused: Option<String>,
    /// Changes that led to another equilibrium that is as good.
    pub others: Vec<&'static str>,
    /// Changes that should say the same and did not converge.
    pub lost: Vec<&'static str>,
    /// Faults.
    pub faults: Vec<Fault>,
}

impl Checked {
    fn wrong(&mut self, kind: &'static str, words: String, scene: &Scene) {
        self.faults.push(Fault { kind, said: "", words, scene: scene.clone() });
    }

    /// Takes over what was found wrong with the scene said otherwise.
    fn add(&mut self, said: &'static str, found: Checked) {
        self.faults.extend(found.faults.into_iter().map(|fault| Fault { said, ..fault }));
        self.lost.extend(found.lost);
    }
}

/// Judges a scene by everything there is; with `quick` by what a single run tells.
pub fn check(scene: &Scene, quick: bool) -> Checked {
    let mut checked = Checked::default();
    let mut scene = scene.clone();
    if scene.steps.is_empty() {
        scene.steps.push(Step { increments: 1, ..Step::default() });
    }
    let Some(outcome) = alone(&scene, &mut checked) else { return checked };
    let end = &outcome.steps[outcome.steps.len() - 1];
    checked.converged = true;
    checked.stable = end.stable == Some(true);
    if quick || !checked.faults.is_empty() {
        return checked;
    }
    stays(&scene, end, &mut checked);
    if checked.stable {
        comes_back(&scene, end, &mut checked);
    }
    if checked.faults.is_empty() {
        said_otherwise(&scene, end, &mut checked);
    }
    checked
}

/// Runs a scene; its outcome, if it is called converged and has as many steps as were asked for, with what its numbers
/// show to be wrong.
fn alone(scene: &Scene, checked: &mut Checked) -> Option<Outcome> {
    let outcome = match run(scene) {
        Ran::Refused(why) => {
            checked.refused = Some(why);
            return None;
        }
        Ran::Panicked(words) => {
            checked.wrong("panic", words, scene);
            return None;
        }
        Ran::Ended(outcome) => *outcome,
    };
    if outcome.status == "converged" {
        let odd = outcome.steps.iter().find(|s| s.status != "converged");
        if let Some(odd) = odd {
            checked.wrong("status", format!("the run is converged, a step of it {}", odd.status), scene);
            return None;
        }
        if outcome.steps.len() != scene.steps.len() {
            checked.wrong("status", "the run is converged and a step is missing".into(), scene);
            return None;
        }
    }
    for wrong in balance::statics(scene, &outcome) {
        checked.wrong(wrong.kind, wrong.words, scene);
    }
    let converged = outcome.status == "converged";
    let slips = |event: &EventOutcome| event.kind == "coarse-mesh" && event.value.is_some_and(|turn| turn > SLIPS);
    let told = |event: &EventOutcome| event.kind == "twist-lost" || slips(event);
    checked.too_coarse = !converged && outcome.events.iter().any(told);
    converged.then_some(outcome)
}

/// From where it ended, minimisers with a tight tolerance find nothing better.
fn stays(scene: &Scene, end: &StepOutcome, checked: &mut Checked) {
    let mut waiting = scene.clone();
    waiting.steps.push(Step { increments: 1, ..Step::default() });
    let (_, resumed) = run_keeping(&waiting, scene.steps.len(), None);
    let Some(resumed) = resumed else { return };
    for (kind, iterations) in [("newton", 200), ("lbfgs", 300)] {
        let minimiser = Minimiser { kind, tolerance: 1e-10, iterations };
        let tight = Scene { minimiser: Some(minimiser), ..waiting.clone() };
        let (ran, _) = run_keeping(&tight, usize::MAX, Some(resumed.clone()));
        let outcome = match ran {
            Ran::Ended(outcome) => outcome,
            Ran::Panicked(words) => {
                checked.wrong("panic", format!("{kind} goes on from where it ended: {words}"), scene);
                continue;
            }
            Ran::Refused(_) => continue,
        };
        let Some(after) = outcome.steps.last().filter(|_| outcome.status == "converged") else {
            checked.lost.push("tight");
            continue;
        };
        let distance = moved(scene, end, after);
        // Friction has memory: the shape may move while it waits.
        let allowed = if scene.has_friction() { 10.0 * STAYS } else { STAYS };
        let neutral = end.stable != Some(true);
        if distance > allowed && !neutral {
            let words = format!(
                "{kind} with a tolerance of 1e-10 goes on from the converged shape by {distance:.2e} of the length"
            );
            checked.wrong("not converged", words, scene);
            return;
        }
    }
}

/// A stable shape comes back when gravity is disturbed for a moment.
fn comes_back(scene: &Scene, end: &StepOutcome, checked: &mut Checked) {
    let mut last = String::new();
    for share in NUDGES {
        let nudged = variants::nudged(scene, share);
        let Some(outcome) = run(&nudged).converged() else {
            checked.lost.push("nudged");
            return;
        };
        let after = &outcome.steps[outcome.steps.len() - 1];
        let distance = moved(scene, end, after);
        if distance < if scene.has_friction() { 50.0 * SAME } else { SAME } {
            return;
        }
        let gain = end.energy.total - after.energy.total;
        let e = &end.energy;
        let elastic = e.stretch + e.shear + e.bend + e.twist + e.joint + e.constraint.abs();
        if gain.abs() <= EQUAL * elastic + ROUND_OFF * (e.gravity.abs() + e.load.abs()) {
            checked.others.push("drifts at the same energy");
            return;
        }
        last = format!(
            "gravity is off by {share:.0e} for a moment: the shape ends {distance:.2e} of the length from where it was \
             called stable, {gain:.2e} J lower"
        );
    }
    if !scene.has_friction() {
        checked.wrong("not stable", last, scene);
    }
}

/// The same harness, said otherwise, has the same shape. Where it has not, both must be equilibria.
fn said_otherwise(scene: &Scene, end: &StepOutcome, checked: &mut Checked) {
    let turn = Rotation::from_scaled_axis(Vector::new(0.7, -1.1, 0.4));
    let half: Vec<usize> = scene.branches.iter().map(|b| b.name).filter(|name| name % 2 == 0).collect();
    let variants = [
        variants::moved(scene, turn, Vector::new(0.3, -0.2, 0.7)),
        variants::scaled(scene, 1e-5, 1e-3),
        variants::scaled(scene, 1e3, 1e5),
        variants::reversed(scene, half),
        variants::with_stranger(scene),
        variants::minimised(scene, Minimiser { kind: "lbfgs", tolerance: 1e-8, iterations: 300 }),
    ];
    for variant in variants {
        same(scene, end, &variant, checked);
    }
    meshes(scene, end, checked);
}

/// One way to say it.
fn same(scene: &Scene, end: &StepOutcome, variant: &Variant, checked: &mut Checked) {
    let mut own = Checked::default();
    let outcome = alone(&variant.scene, &mut own);
    // Lengths and forces of the other scale may be beyond what is plausible.
    // Dead moments have no potential: minimisers of an energy refuse them.
    let dead_moments = scene.loads.iter().any(|load| load.moment != Vector::zeros());
    let foreseen = variant.scale != 1.0 || (dead_moments && variant.scene.minimiser.is_some());
    if let (Some(why), false) = (own.refused.take(), foreseen) {
        own.wrong("refused", why, &variant.scene);
    }
    let clean = own.faults.is_empty();
    checked.add(variant.what, own);
    if !clean {
        return;
    }
    let Some(outcome) = outcome else {
        checked.lost.push(variant.what);
        return;
    };
    let other = &outcome.steps[outcome.steps.len() - 1];
    let distance = apart(scene, end, variant, other);
    if distance <= SAME {
        let differ = matches!((end.stable, other.stable), (Some(a), Some(b)) if a != b);
        if differ && distance < 1e-6 {
            let words = format!("{}: the same shape is stable {:?} and {:?}", variant.what, end.stable, other.stable);
            checked.wrong("stability differs", words, scene);
        }
        return;
    }
    checked.others.push(variant.what);
    if other.stable == Some(true) {
        let mut own = Checked::default();
        stays(&variant.scene, other, &mut own);
        if own.faults.is_empty() {
            comes_back(&variant.scene, other, &mut own);
        }
        checked.add(variant.what, own);
    }
}

/// With twice as many segments, and again, the shape changes less and less.
fn meshes(scene: &Scene, end: &StepOutcome, checked: &mut Checked) {
    let [two, four] = [2, 4].map(|times| variants::refined(scene, times));
    let ends = [&two, &four].map(|variant| {
        let mut own = Checked::default();
        let outcome = alone(&variant.scene, &mut own);
        checked.add(variant.what, own);
        outcome.and_then(|mut outcome| outcome.steps.pop())
    });
    let [Some(finer), Some(finest)] = ends else {
        checked.lost.push("finer");
        return;
    };
    let first = apart(scene, end, &two, &finer);
    let second = apart(&two.scene, &finer, &four, &finest);
    // First order would be a half; where a mesh has not yet begun to converge nothing can be said.
    if first < MESH && second > SAME && second > 0.75 * first {
        checked.others.push("finer");
    }
}
