//! Optima against closed forms and independent scans, the runs they take beside a method without gradients, and what
//! has none.

use std::cell::RefCell;
use wireloom::optimise::{Ending, Kind, Optimisation, Search};
use wireloom::result::{Measure, Verdict};
use wireloom::scenario::{NoFiles, Setting};
use wireloom::sensitivity::Source;
use wireloom::{Control, Run, Status};
use wireloom_tests::cables::{branch, connector, connector_along, section};
use wireloom_tests::root;

/// Error of an optimum: it keeps a margin of 0.1 % and 0.02 % from its limits beside the discretisation error, and is
/// exact to 0.01 %; limits act on lengths and forces with factors about 1.
const EXACT: f64 = 3e-3;

fn scenario(name: &str) -> String {
    std::fs::read_to_string(root().join("scenarios/optimise").join(name)).expect("a scenario of the repository")
}

fn search(text: &str) -> Optimisation {
    let registry = wireloom::registry();
    let search = Search::new(Source::new(text, &NoFiles, &registry)).expect("an optimisation without faults");
    search.run(&mut |_| {}).expect("its choices can be written")
}

/// A run with other values, which knows nothing of optimisation.
fn ran(text: &str, settings: &[Setting]) -> Run {
    let registry = wireloom::registry();
    let (_, built) = wireloom::load_with_settings(text, settings, &NoFiles, &registry).expect("no faults");
    wireloom::run(built, &mut |_, _| Control::Continue)
}

fn numbers(found: &Optimisation) -> Vec<f64> {
    let optimum = found.optimum.as_ref().expect("a design that keeps all requirements");
    optimum.values.iter().map(|value| value.parse().expect("a number")).collect()
}

/// What every optimum owes: a fresh run of its text that passes, and an objective that no other design in the table
/// with the margin asked for has beaten.
#[track_caller]
fn holds(found: &Optimisation) {
    assert_eq!(found.ending, Ending::Converged);
    let optimum = found.optimum.as_ref().expect("an optimum");
    let certificate = optimum.certificate.as_ref().expect("a fresh run");
    assert_eq!((certificate.status(), certificate.verdict()), (Status::Converged, Verdict::Pass));
    let again = ran(&optimum.text, &[]);
    assert_eq!((again.status(), again.verdict()), (Status::Converged, Verdict::Pass));
    let kept = found.designs.iter().filter(|design| design.verdict.as_deref() == Some("pass"));
    let kept = kept.filter(|design| design.margin.is_some_and(|margin| margin >= 1e-3));
    let best = kept.filter_map(|design| design.objective).fold(f64::INFINITY, f64::min);
    assert!(best >= optimum.objective * (1.0 - 1e-4), "{best}");
    assert_eq!(found.counts.runs, found.designs.len());
}

/// The smallest value of a key, up to 1e-5 of it, with which all requirements are kept; `kept` keeps them.
fn least(text: &str, key: &str, mut fails: f64, mut kept: f64) -> f64 {
    let passes = |value: f64| ran(text, &[Setting::number(key, value)]).verdict() == Verdict::Pass;
    assert!(passes(kept) && !passes(fails));
    while kept - fails > 1e-5 * kept {
        let middle = 0.5 * (fails + kept);
        *(if passes(middle) { &mut kept } else { &mut fails }) = middle;
    }
    kept
}

/// Integral over the first quarter turn (Simpson).
fn quarter(f: impl Fn(f64) -> f64) -> f64 {
    const N: usize = 2000;
    let h = std::f64::consts::FRAC_PI_2 / N as f64;
    let weight = |k: usize| if k == 0 || k == N { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
    (0..=N).map(|k| weight(k) * f(k as f64 * h)).sum::<f64>() * h / 3.0
}

/// An elastic line that turns back, and is pulled, has the curvature `κ² = 1/R² − 2 p sin θ` at the angle θ from its
/// plug, where the bend is tightest, with the force p EI in its middle (Love, section 262). p follows from the distance
/// of the plugs, `D = 2 ∫ sin θ / κ dθ`, and the length is `2 ∫ dθ / κ`.
#[test]
fn the_shortest_cable_is_the_elastic_line_at_its_bend_limit() {
    let (r, d) = (0.05, 0.115);
    let curvature = |p: f64, angle: f64| (1.0 / (r * r) - 2.0 * p * angle.sin()).sqrt();
    let (mut low, mut high) = (0.0, 0.4999 / (r * r));
    for _ in 0..60 {
        let p = 0.5 * (low + high);
        let distance = 2.0 * quarter(|angle| angle.sin() / curvature(p, angle));
        *(if distance < d { &mut low } else { &mut high }) = p;
    }
    let length = 2.0 * quarter(|angle| 1.0 / curvature(low, angle));

    let text = scenario("shortest_cable.toml");
    let found = search(&text);
    holds(&found);
    let optimum = numbers(&found)[0];
    assert!((optimum - length).abs() <= EXACT * length, "{optimum}, {length}");
    // Two quarters of a circle and a straight are the shortest of all curves with this bend radius (Dubins).
    assert!(optimum > std::f64::consts::PI * r + d - 2.0 * r);
    let scanned = least(&text, "branches.cable.length", 0.165, 0.19);
    assert!((optimum - scanned).abs() <= EXACT * length, "{optimum}, {scanned}");
    assert!(optimum >= scanned - 1e-5 * length, "no shorter cable keeps its limit");
    // The author's comments stay, and so does the unit.
    let optimum = found.optimum.expect("an optimum").text;
    assert!(optimum.contains("# generous; what can be saved?") && optimum.contains(" mm\" # generous"), "{optimum}");
}

#[test]
fn the_place_of_a_clip_is_that_of_a_scan() {
    let text = scenario("clip_place.toml");
    let found = search(&text);
    holds(&found);
    let keys = ["constraints.clip.position.0", "constraints.clip.position.2"];
    let force = |at: [f64; 2]| {
        let settings = [Setting::number(keys[0], at[0]), Setting::number(keys[1], at[1])];
        let run = ran(&text, &settings);
        let line = run.requirements.iter().find(|line| line.name == "pull on the clip").expect("its line");
        if run.status() == Status::Converged { line.worst.expect("a force") } else { f64::INFINITY }
    };
    let optimum = found.optimum.as_ref().expect("an optimum").objective;
    let at = numbers(&found);
    // No place of the whole panel is better, by a grid of 21 × 31 places; nor one nearby, in any of 16 directions.
    let grid = (0..21 * 31).map(|n| [0.3 + 0.01 * f64::from(n % 21), -0.15 + 0.01 * f64::from(n / 21)]);
    let around = (0..64).map(|n| {
        let (angle, distance) = (f64::from(n % 16) * std::f64::consts::TAU / 16.0, 2e-4 * 4.0_f64.powi(n / 16));
        [at[0] + distance * angle.cos(), at[1] + distance * angle.sin()]
    });
    let best = grid.chain(around).map(force).fold(f64::INFINITY, f64::min);
    assert!(optimum <= best * (1.0 + EXACT), "{optimum}, {best}");
    // The value is that of a run.
    assert!((force([at[0], at[1]]) - optimum).abs() <= 1e-9 * optimum);
}

/// Relative margins of all requirements in a run, less their errors.
fn margins(run: &Run) -> Vec<f64> {
    let margin = |line: &wireloom::result::RequirementResult| {
        let (worst, scale) = (line.worst.unwrap_or(f64::INFINITY), line.limit.abs());
        let gap = line.bound.gap(worst, line.limit) - line.error.unwrap_or(0.0);
        // Curves that are nearly straight have any margin.
        (gap / if scale > 0.0 { scale } else { 1.0 }).min(10.0)
    };
    run.requirements.iter().map(margin).collect()
}

/// The same design by COBYLA (Powell 1994), which takes no derivatives: least value, and number of runs.
fn without_gradients(text: &str, keys: &[&str], start: &[f64], ranges: &[[f64; 2]], accuracy: f64) -> (f64, usize) {
    let runs = RefCell::new(0);
    let last: RefCell<Option<(Vec<f64>, Vec<f64>)>> = RefCell::new(None);
    let best = RefCell::new(f64::INFINITY);
    let at = |u: &[f64]| -> Vec<f64> {
        let scaled = u.iter().zip(ranges);
        scaled.map(|(u, [from, to])| from + u.clamp(0.0, 1.0) * (to - from)).collect()
    };
    let kept = |u: &[f64]| -> Vec<f64> {
        if let Some((known, kept)) = &*last.borrow()
            && known == u
        {
            return kept.clone();
        }
        let values = at(u);
        let settings: Vec<Setting> = keys.iter().zip(&values).map(|(key, x)| Setting::number(*key, *x)).collect();
        let run = ran(text, &settings);
        *runs.borrow_mut() += 1;
        let kept = if run.status() == Status::Converged { margins(&run) } else { vec![-1.0; run.requirements.len()] };
        if run.verdict() == Verdict::Pass {
            let length: f64 = values.iter().sum();
            best.replace_with(|best| best.min(length));
        }
        *last.borrow_mut() = Some((u.to_vec(), kept.clone()));
        kept
    };
    let from: Vec<f64> = start.iter().zip(ranges).map(|(x, [from, to])| (x - from) / (to - from)).collect();
    let count = kept(&from).len();
    // The objective is asked for first: it makes the run.
    let objective = |u: &[f64], _: &mut ()| {
        kept(u);
        at(u).iter().sum::<f64>()
    };
    let kept = &kept;
    let constraints: Vec<_> = (0..count).map(|k| move |u: &[f64], _: &mut ()| kept(u)[k]).collect();
    let tolerances = cobyla::StopTols { xtol_rel: accuracy, ..cobyla::StopTols::default() };
    let bounds = vec![(0.0, 1.0); keys.len()];
    let begin = cobyla::RhoBeg::All(0.2);
    let ended = cobyla::minimize(objective, &from, &bounds, &constraints, (), 2000, begin, Some(tolerances));
    assert!(ended.is_ok(), "COBYLA ends at its tolerance");
    (best.into_inner(), runs.into_inner())
}

/// Smallest sum of the distances to three places (Weiszfeld).
fn steiner(places: [[f64; 2]; 3]) -> f64 {
    let mut at = [0.38, 0.0];
    let distance = |at: [f64; 2], p: &[f64; 2]| (at[0] - p[0]).hypot(at[1] - p[1]);
    for _ in 0..10_000 {
        let weights = places.map(|p| 1.0 / distance(at, &p));
        let sum: f64 = weights.iter().sum();
        let mean = |axis: usize| places.iter().zip(weights).map(|(p, w)| w * p[axis]).sum::<f64>() / sum;
        at = [mean(0), mean(1)];
    }
    places.iter().map(|p| distance(at, p)).sum()
}

#[test]
fn the_branch_off_is_that_of_a_method_without_gradients_in_fewer_runs() {
    let text = scenario("branch_off.toml");
    let found = search(&text);
    holds(&found);
    let optimum = found.optimum.as_ref().expect("an optimum").objective;
    // Cables cannot be shorter than straight lines, but for their stretch of 1e-4 and less.
    assert!(optimum > steiner([[0.0, 0.0], [0.6, 0.22], [0.55, -0.25]]) * (1.0 - 1e-3));
    let keys = ["branches.trunk.length", "branches.left.length", "branches.right.length"];
    let ranges = [[0.1, 0.5], [0.2, 0.7], [0.2, 0.7]];
    let (best, runs) = without_gradients(&text, &keys, &[0.35, 0.4, 0.4], &ranges, 1e-4);
    assert!(optimum <= best * (1.0 + EXACT), "{optimum}, {best}");
    // Times 2.9 as this is written.
    assert!(5 * found.counts.runs <= 2 * runs, "{} and {runs} runs", found.counts.runs);
}

#[test]
fn the_shortest_door_loop_is_that_of_a_scan() {
    let text = scenario("door_loop.toml");
    let found = search(&text);
    holds(&found);
    let optimum = numbers(&found)[0];
    let scanned = least(&text, "branches.loop.length", 0.9 * optimum, 1.02 * optimum);
    assert!((optimum - scanned).abs() <= EXACT * scanned, "{optimum}, {scanned}");
}

#[test]
fn the_best_of_all_choices_is_found() {
    let thin = "[sections.thin]\ndiameter = \"5 mm\"\nlinear_density = \"50 g/m\"\naxial_stiffness = \"20 kN\"\n\
                bending_stiffness = \"0.01 N m^2\"\ntorsion_stiffness = \"0.008 N m^2\"\nmin_bend_radius = \"40 mm\"\n\
                [[branches]]";
    let text = scenario("shortest_cable.toml").replace("[[branches]]", thin);
    let text = format!("{text}\"branches.cable.section\" = {{ values = [\"cable\", \"thin\"] }}\n");
    let found = search(&text);
    holds(&found);
    let optimum = found.optimum.expect("an optimum");
    assert_eq!(optimum.values[1], "thin", "its bends may be tighter");
    assert!(optimum.text.contains("section = \"thin\""));
    assert_eq!(found.designs.iter().filter(|design| design.kind == Kind::Start).count(), 8, "4 of each");
}

/// A cable that bridges 0.8 m.
fn bridge(minimise: &str, rest: &str) -> String {
    [
        "schema = 1\nname = \"bridge\"\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 1.0, 40),
        &connector("plug-A", "A", [0.0; 3]),
        &connector("plug-B", "B", [0.8, 0.0, 0.0]),
        &format!("[optimise]\nminimise = \"{minimise}\"\n"),
        rest,
    ]
    .concat()
}

/// The shortest cable is as long as its span: a step lands on that limit, where a test without room fails by round-off.
#[test]
fn a_search_that_ends_at_the_reach_of_a_span_converges() {
    let pull = "[[requirements]]\nname = \"pull\"\nquantity = \"force\"\nof = { constraint = \"plug-A\" }\nmax = 500\n";
    let found = search(&bridge(
        "length",
        &format!("[optimise.vary]\n\"branches.cable.length\" = {{ from = 0.7, to = 1.2 }}\n{pull}"),
    ));
    holds(&found);
    let length = numbers(&found)[0];
    assert!((0.8..0.801).contains(&length), "{length} m");
}

/// The worst margin is the least one of the sheet, also that of a requirement that holds for every harness.
#[test]
fn the_worst_margin_is_the_least_of_the_sheet() {
    let clip = "[[constraints]]\nname = \"clip\"\nkind = \"collar\"\nat = { branch = \"cable\", s = 0.4 }\n\
                position = [0.34, 0, -0.05]\nhold = [\"position\"]\n\
                [[requirements]]\nname = \"pull\"\nquantity = \"force\"\nof = { constraint = \"plug-A\" }\nmax = 500\n\
                [optimise.vary]\n\"constraints.clip.position.0\" = { from = 0.25, to = 0.38 }\n";
    let found = search(&bridge("worst margin", clip));
    assert_eq!(found.ending, Ending::Converged);
    let optimum = found.optimum.as_ref().expect("an optimum");
    let run = optimum.certificate.as_ref().expect("a fresh run");
    let margins = run.requirements.iter().filter(|line| line.limit != 0.0).filter_map(|line| {
        let error = line.error.unwrap_or(0.0) / line.limit.abs();
        Some(line.margin()? - error)
    });
    let least = margins.fold(f64::INFINITY, f64::min);
    assert!((-optimum.objective - least).abs() < 1e-3, "{} and {least}", -optimum.objective);
    // Both spans as long as they can be: (x² + 0.05²)/0.4² = ((0.8 − x)² + 0.05²)/0.6².
    let x = numbers(&found)[0];
    let share = |x: f64, length: f64| (x * x + 0.0025).sqrt() / length;
    assert!((share(x, 0.4) - share(0.8 - x, 0.6)).abs() < 2e-3, "{x} m");
}

#[test]
fn what_cannot_be_kept_is_said() {
    let text = scenario("shortest_cable.toml").replace("min_bend_radius = \"50 mm\"", "min_bend_radius = \"500 mm\"");
    let found = search(&text);
    assert_eq!(found.ending, Ending::Infeasible);
    assert!(found.optimum.is_none());
    assert!(found.designs.iter().all(|design| design.verdict.as_deref() != Some("pass")));
}

#[test]
fn what_is_stopped_keeps_the_best_design() {
    let text = scenario("shortest_cable.toml");
    let registry = wireloom::registry();
    let source = Source::new(&text, &NoFiles, &registry);
    let monitor = source.monitor.clone();
    let mut shown = 0;
    let found = Search::new(source).expect("no faults").run(&mut |_| {
        shown += 1;
        if shown == 2 {
            monitor.stop();
        }
    });
    let found = found.expect("nothing is chosen");
    assert_eq!((found.ending, shown, found.designs.len()), (Ending::Stopped, 2, 2));
    let optimum = found.optimum.expect("the start keeps its requirements");
    assert!(optimum.certificate.is_none());
    assert_eq!(ran(&optimum.text, &[]).verdict(), Verdict::Pass);
}

/// A cable from a plug, beside which a load pulls at its middle; what hangs on behind that is straight.
fn cantilever(minimise: &str, more: &str) -> String {
    [
        "schema = 1\nname = \"cantilever\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 1.0, 20),
        &connector_along("plug-A", "A", [0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        "[[loads]]\nname = \"pull\"\nat = { branch = \"cable\", s = 0.5 }\nforce = [0, 0, -0.1]\n",
        "[optimise.vary]\n\"branches.cable.length\" = { from = 0.8, to = 1.2 }\n",
        &format!("[optimise]\nminimise = \"{minimise}\"\n"),
        more,
    ]
    .concat()
}

/// Its value was left out of the constraints, as it is not finite: the margin was that of another requirement.
#[test]
fn a_straight_cable_fails_a_greatest_bend_radius() {
    let bent = "[[requirements]]\nname = \"bent\"\nquantity = \"bend_radius\"\nmax = 1.0\n\
                of = { branch = \"cable\", from = 0.6 }\n";
    let found = search(&cantilever("length", bent));
    assert_eq!((found.ending, found.optimum.is_none()), (Ending::Infeasible, true));
    for design in &found.designs {
        assert_eq!((design.verdict.as_deref(), design.margin), (Some("fail"), Some(f64::NEG_INFINITY)));
        assert!(design.tightest.as_ref().is_some_and(|line| line.starts_with("bent")), "{design:?}");
    }
    // It has no value that could be minimised.
    let found = search(&cantilever("bent", bent));
    assert_eq!((found.ending, found.counts.failed), (Ending::NoStart, found.counts.runs));
}

/// The section's limit has the name of the section: its radius was minimised beside the tension of the same name.
#[test]
fn of_two_requirements_of_one_name_that_of_the_file_is_minimised() {
    let pull = "[[requirements]]\nname = \"cable\"\nquantity = \"tension\"\nmax = \"50 N\"\n";
    let text = cantilever("cable", pull).replace("[sections.cable]\n", "[sections.cable]\nmin_bend_radius = 0.05\n");
    let found = search(&text);
    let optimum = found.optimum.expect("a design that keeps all requirements");
    let run = optimum.certificate.expect("a fresh run");
    let of_name: Vec<_> = run.requirements.iter().filter(|line| line.name == "cable").collect();
    assert_eq!(of_name.iter().map(|line| line.measure).collect::<Vec<_>>(), [Measure::Tension, Measure::BendRadius]);
    let (tension, radius) = (of_name[0].worst.expect("a tension"), of_name[1].worst.expect("a radius"));
    assert!((optimum.objective - tension).abs() <= 1e-6 * tension.abs(), "{} {tension} {radius}", optimum.objective);
}
