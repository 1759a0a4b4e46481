//! A mesh by accuracy: fine where the harness bends tightly, coarse where it is straight, and the same verdicts for
//! any.

use wireloom::result::{Measure, RequirementResult, Verdict};
use wireloom::session::{IncrementObserver, Monitor};
use wireloom::{Built, Control, Run, Status};

/// Runs a scenario on the mesh of its accuracy.
fn run(text: &str) -> (Run, usize) {
    let registry = wireloom::registry();
    let (scenario, built) = wireloom::load(text, &registry).unwrap_or_else(|faults| panic!("{faults:?}"));
    let meshed = wireloom::mesh::by_accuracy(scenario, built, &registry, &Monitor::default());
    let (_, built) = meshed.unwrap_or_else(|faults| panic!("{faults:?}"));
    let segments = segments(&built);
    let run = wireloom::run_observed(built, None, &mut IncrementObserver(&mut |_, _| Control::Continue));
    assert_eq!(run.status(), Status::Converged);
    (run, segments)
}

fn segments(built: &Built) -> usize {
    built.network.branches.iter().map(|branch| branch.rod.mesh().segments()).sum()
}

/// A long cable that is clamped askew at its start: it bends tightly within centimetres, and hangs loosely after them.
fn askew(division: &str) -> String {
    format!(
        "schema = 1\nname = \"askew\"\n{division}\n[sections.s]\ndiameter = \"4 mm\"\nlinear_density = \"40 g/m\"\n\
         axial_stiffness = 1e4\nbending_stiffness = 1e-4\ntorsion_stiffness = 1e-4\nmin_bend_radius = \"20 mm\"\n\
         [[branches]]\nname = \"cable\"\nfrom = \"A\"\nto = \"B\"\nsection = \"s\"\nlength = 1.2\nDIVISION\n\
         [[constraints]]\nname = \"a\"\nkind = \"connector\"\nat = {{ end = \"A\" }}\nposition = [0, 0, 0]\n\
         tangent = [-1, 0, 0.2]\nup = [0, 1, 0]\n\
         [[constraints]]\nname = \"b\"\nkind = \"connector\"\nat = {{ end = \"B\" }}\nposition = [1, 0, 0]\n\
         tangent = [1, 0, 0.8]\nup = [0, 1, 0]\n"
    )
}

fn by_accuracy(accuracy: &str) -> String {
    askew(&format!("[mesh]\naccuracy = \"{accuracy}\"")).replace("DIVISION\n", "")
}

fn bend(run: &Run) -> &RequirementResult {
    run.requirements.iter().find(|line| line.measure == Measure::BendRadius).expect("the section has a limit")
}

#[test]
fn the_mesh_reaches_its_accuracy_and_says_so() {
    let radius = |run: &Run| bend(run).worst.expect("it bends");
    let uniform = |n: usize| run(&askew("").replace("DIVISION", &format!("segments = {n}"))).0;
    let fine = radius(&uniform(4000));
    for (accuracy, ratio) in [("2 %", 0.02), ("0.5 %", 0.005)] {
        let (run, segments) = run(&by_accuracy(accuracy));
        let error = (radius(&run) / fine - 1.0).abs();
        assert!(error <= ratio, "{accuracy}: off by {error} with {segments} segments");
        let estimate = bend(&run).error.expect("an estimate") / radius(&run);
        assert!(error <= estimate && estimate <= 1.5 * ratio, "{accuracy}: {error}, estimated {estimate}");
        // A uniform mesh with a quarter of the segments is not as good.
        let coarse = (radius(&uniform(segments / 4)) / fine - 1.0).abs();
        assert!(coarse > error, "{accuracy}: {error} with {segments} segments, {coarse} with a quarter of them");
        assert!(run.notes.iter().any(|note| note.contains("mesh for an accuracy")), "{:?}", run.notes);
    }
}

#[test]
fn a_coarse_mesh_leaves_a_verdict_unresolved_that_a_fine_one_gives() {
    let (coarse, _) = run(&askew("").replace("DIVISION", "segments = 24").replace("20 mm", "10 mm"));
    let (fine, _) = run(&by_accuracy("1 %").replace("20 mm", "10 mm"));
    assert_ne!(bend(&coarse).verdict, Verdict::Pass, "{:?}", bend(&coarse));
    assert_eq!(bend(&fine).verdict, Verdict::Fail, "{:?}", bend(&fine));
}
