//! Judges a scene: everything that can be found wrong with what the program claims of it.

use super::balance;
use super::compare::{apart, moved};
use super::outcome::{EventOutcome, Outcome, Ran, StepOutcome, run, run_keeping};
use super::scene::{Minimiser, Scene, Step};
use super::variants::{self, Variant};
use wireloom::geometry::{Rotation, Vector};

/// Shapes nearer to each other are the same: share of the longest branch.
const SAME: f64 = 1e-3;
/// What a converged shape may still move by when it is solved for more tightly.
const SETTLED: f64 = 1e-4;
/// Shares of gravity by which a stable shape is disturbed. It must come back from the smallest one at least.
const NUDGES: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// Energies are equal: share of what is stored in the harness, and of what is measured from the origin of the world.
const EQUAL: f64 = 1e-7;
const ROUND_OFF: f64 = 1e-12;
/// Turn of neighbouring segments (rad) from which on their moment falls: no wonder if nothing converges then.
const SLIPS: f64 = 1.8;
/// As two meshes agree, or a half of that with twice as many segments.
const MESH: f64 = 0.05;

/// What is wrong, and with which scene.
#[derive(Clone)]
pub struct Fault {
    /// In a few words: what shrinking keeps.
    pub kind: &'static str,
    /// What was done to the scene that was judged; empty: nothing.
    pub said: &'static str,
    /// The numbers.
    pub words: String,
    /// The scene that shows it.
    pub scene: Scene,
}

/// What came of judging a scene.
#[derive(Default)]
pub struct Judged {
    /// Called converged.
    pub converged: bool,
    /// Not converged, and told that a mesh is too coarse for it.
    pub too_coarse: bool,
    /// Called stable.
    pub stable: bool,
    /// Refused before it ran.
    pub refused: Option<String>,
    /// How often another equilibrium was found that is as good, by what was changed.
    pub others: Vec<&'static str>,
    /// How often something that says the same did not converge.
    pub lost: Vec<&'static str>,
    /// What is wrong.
    pub faults: Vec<Fault>,
}

impl Judged {
    fn wrong(&mut self, kind: &'static str, words: String, scene: &Scene) {
        self.faults.push(Fault { kind, said: "", words, scene: scene.clone() });
    }

    /// Takes over what was found wrong with the scene said otherwise.
    fn add(&mut self, said: &'static str, found: Judged) {
        self.faults.extend(found.faults.into_iter().map(|fault| Fault { said, ..fault }));
        self.lost.extend(found.lost);
    }
}

/// Judges a scene by everything there is; with `quick` by what a single run tells.
pub fn judge(scene: &Scene, quick: bool) -> Judged {
    let mut judged = Judged::default();
    let mut scene = scene.clone();
    if scene.steps.is_empty() {
        scene.steps.push(Step { increments: 1, ..Step::default() });
    }
    let Some(outcome) = alone(&scene, &mut judged) else { return judged };
    let end = &outcome.steps[outcome.steps.len() - 1];
    judged.converged = true;
    judged.stable = end.stable == Some(true);
    if quick || !judged.faults.is_empty() {
        return judged;
    }
    settles(&scene, end, &mut judged);
    if judged.stable {
        comes_back(&scene, end, &mut judged);
    }
    if judged.faults.is_empty() {
        said_otherwise(&scene, end, &mut judged);
    }
    judged
}

/// Runs a scene; its outcome, if it is called converged and has as many steps as were asked for, with what its numbers show to be wrong.
fn alone(scene: &Scene, judged: &mut Judged) -> Option<Outcome> {
    let outcome = match run(scene) {
        Ran::Refused(why) => {
            judged.refused = Some(why);
            return None;
        }
        Ran::Panicked(words) => {
            judged.wrong("panic", words, scene);
            return None;
        }
        Ran::Ended(outcome) => *outcome,
    };
    if outcome.status == "converged" {
        let odd = outcome.steps.iter().find(|s| s.status != "converged");
        if let Some(odd) = odd {
            judged.wrong("status", format!("the run is converged, a step of it {}", odd.status), scene);
            return None;
        }
        if outcome.steps.len() != scene.steps.len() {
            judged.wrong("status", "the run is converged and a step is missing".into(), scene);
            return None;
        }
    }
    for wrong in balance::statics(scene, &outcome) {
        judged.wrong(wrong.kind, wrong.words, scene);
    }
    let converged = outcome.status == "converged";
    let slips = |event: &EventOutcome| event.kind == "coarse-mesh" && event.value.is_some_and(|turn| turn > SLIPS);
    let told = |event: &EventOutcome| event.kind == "twist-lost" || slips(event);
    judged.too_coarse = !converged && outcome.events.iter().any(told);
    converged.then_some(outcome)
}

/// From where it ended, minimisers with a tight tolerance find nothing better.
fn settles(scene: &Scene, end: &StepOutcome, judged: &mut Judged) {
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
                judged.wrong("panic", format!("{kind} goes on from where it ended: {words}"), scene);
                continue;
            }
            Ran::Refused(_) => continue,
        };
        let Some(after) = outcome.steps.last().filter(|_| outcome.status == "converged") else {
            judged.lost.push("tight");
            continue;
        };
        let distance = moved(scene, end, after);
        // Friction remembers: waiting may let it settle anew.
        let allowed = if scene.rubs() { 10.0 * SETTLED } else { SETTLED };
        let neutral = end.stable != Some(true);
        if distance > allowed && !neutral {
            let words = format!(
                "{kind} with a tolerance of 1e-10 goes on from the converged shape by {distance:.2e} of the length"
            );
            judged.wrong("not settled", words, scene);
            return;
        }
    }
}

/// A stable shape comes back when gravity is disturbed for a moment.
fn comes_back(scene: &Scene, end: &StepOutcome, judged: &mut Judged) {
    let mut last = String::new();
    for share in NUDGES {
        let nudged = variants::nudged(scene, share);
        let Some(outcome) = run(&nudged).converged() else {
            judged.lost.push("nudged");
            return;
        };
        let after = &outcome.steps[outcome.steps.len() - 1];
        let distance = moved(scene, end, after);
        if distance < if scene.rubs() { 50.0 * SAME } else { SAME } {
            return;
        }
        let gain = end.energy.total - after.energy.total;
        let e = &end.energy;
        let elastic = e.stretch + e.shear + e.bend + e.twist + e.joint + e.constraint.abs();
        if gain.abs() <= EQUAL * elastic + ROUND_OFF * (e.gravity.abs() + e.load.abs()) {
            judged.others.push("drifts at the same energy");
            return;
        }
        last = format!(
            "gravity is off by {share:.0e} for a moment: the shape ends {distance:.2e} of the length from where it was called stable, {gain:.2e} J lower"
        );
    }
    if !scene.rubs() {
        judged.wrong("not stable", last, scene);
    }
}

/// The same harness, said otherwise, has the same shape. Where it has not, both must be equilibria.
fn said_otherwise(scene: &Scene, end: &StepOutcome, judged: &mut Judged) {
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
        same(scene, end, &variant, judged);
    }
    meshes(scene, end, judged);
}

/// One way to say it.
fn same(scene: &Scene, end: &StepOutcome, variant: &Variant, judged: &mut Judged) {
    let mut own = Judged::default();
    let outcome = alone(&variant.scene, &mut own);
    // Lengths and forces of the other scale may be beyond what is plausible.
    // Dead moments have no potential: minimisers of an energy refuse them.
    let dead_moments = scene.loads.iter().any(|load| load.moment != Vector::zeros());
    let foreseen = variant.scale != 1.0 || (dead_moments && variant.scene.minimiser.is_some());
    if let (Some(why), false) = (own.refused.take(), foreseen) {
        own.wrong("refused", why, &variant.scene);
    }
    let clean = own.faults.is_empty();
    judged.add(variant.what, own);
    if !clean {
        return;
    }
    let Some(outcome) = outcome else {
        judged.lost.push(variant.what);
        return;
    };
    let other = &outcome.steps[outcome.steps.len() - 1];
    let distance = apart(scene, end, variant, other);
    if distance <= SAME {
        let differ = matches!((end.stable, other.stable), (Some(a), Some(b)) if a != b);
        if differ && distance < 1e-6 {
            let words = format!("{}: the same shape is stable {:?} and {:?}", variant.what, end.stable, other.stable);
            judged.wrong("stability differs", words, scene);
        }
        return;
    }
    judged.others.push(variant.what);
    if other.stable == Some(true) {
        let mut own = Judged::default();
        settles(&variant.scene, other, &mut own);
        if own.faults.is_empty() {
            comes_back(&variant.scene, other, &mut own);
        }
        judged.add(variant.what, own);
    }
}

/// With twice as many segments, and again, the shape changes less and less.
fn meshes(scene: &Scene, end: &StepOutcome, judged: &mut Judged) {
    let [two, four] = [2, 4].map(|times| variants::refined(scene, times));
    let ends = [&two, &four].map(|variant| {
        let mut own = Judged::default();
        let outcome = alone(&variant.scene, &mut own);
        judged.add(variant.what, own);
        outcome.and_then(|mut outcome| outcome.steps.pop())
    });
    let [Some(finer), Some(finest)] = ends else {
        judged.lost.push("finer");
        return;
    };
    let first = apart(scene, end, &two, &finer);
    let second = apart(&two.scene, &finer, &four, &finest);
    // First order would be a half; where a mesh has not yet begun to converge nothing can be said.
    if first < MESH && second > SAME && second > 0.75 * first {
        judged.others.push("finer");
    }
}
