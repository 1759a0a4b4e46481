//! Work of the solver, counted: a slower algorithm shows on any machine, however noisy its clock is.

use std::sync::{Arc, Mutex};
use wireloom::bench::{cable, cable_with_friction, drag, harness};
use wireloom::geometry::Vector;
use wireloom::harness::{Network, Problem, State};
use wireloom::parts::{BuildError, Minimiser, Report, Stop};
use wireloom::scenario::settings::Setting;
use wireloom::scenario::{Built, NoFiles};
use wireloom::{Control, Status};
use wireloom_tests::root;

/// Iterations, factorisations, and evaluations of energy and gradient.
type Work = [usize; 3];

/// What a drag of ten steps of 5 mm out and ten back, and whole runs of scenarios, take.
///
/// A row that a change has moved is printed as it is now. If the change is on purpose, replace it here, and give the
/// old and the new counts in the commit.
const PINNED: [(&str, Work); 22] = [
    // The cable of 1,000 segments and the harness of 100 branches with 100 segments each.
    ("drag", [46, 20, 86]),
    // The cable, with friction within its section.
    ("drag-friction", [48, 20, 88]),
    ("drag-harness", [49, 21, 95]),
    ("first.toml", [287, 465, 823]),
    // The other minimisers.
    ("first.toml ncg", [1316, 1342, 5487]),
    ("branches/y_cosserat.toml lbfgs", [254, 205, 568]),
    ("branches/y_cosserat.toml ncg", [255, 210, 854]),
    // Joint models.
    ("branches/y_cosserat.toml", [82, 73, 197]),
    ("branches/y_fused.toml", [88, 74, 204]),
    ("branches/y_rigid_body.toml", [233, 361, 641]),
    ("branches/sixteen_arms.toml", [86, 126, 241]),
    // Contact.
    ("contact/cable_on_plane.toml", [21, 82, 50]),
    ("contact/y_on_boxes.toml", [2183, 4612, 6607]),
    ("contact/crossed_cables.toml", [18, 13, 39]),
    ("contact/capstan.toml", [419, 1292, 1389]),
    // Sliding.
    ("analytic/ring_catenary.toml", [320, 807, 713]),
    ("analytic/ring_pulley.toml", [302, 634, 636]),
    ("analytic/ring_friction.toml", [1834, 4183, 3889]),
    ("analytic/sleeve.toml", [63, 113, 134]),
    // Buckling and twist; assembly.
    ("analytic/euler_column.toml", [6, 6, 23]),
    ("analytic/greenhill_twist.toml", [68, 87, 306]),
    ("assembly/workbench.toml", [259, 342, 619]),
];

/// Minimiser that adds up the reports of another one.
struct Counted {
    own: Box<dyn Minimiser>,
    work: Arc<Mutex<Work>>,
}

impl Minimiser for Counted {
    fn name(&self) -> &str {
        self.own.name()
    }
    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        let report = self.own.minimise(problem, state, stop);
        let spent = [report.iterations, report.factorisations, report.evaluations];
        self.work.lock().expect("no other user").iter_mut().zip(spent).for_each(|(all, one)| *all += one);
        report
    }
    fn forget(&mut self) {
        self.own.forget();
    }
    fn accepts(&self, network: &Network) -> Result<(), BuildError> {
        self.own.accepts(network)
    }
}

/// Work of a whole run of a scenario, every increment of which must converge.
fn run(path: &str, minimiser: Option<&str>) -> Work {
    let text = std::fs::read_to_string(root().join("scenarios").join(path)).expect("a scenario");
    let settings: Vec<Setting> = minimiser.map(|kind| Setting::new("minimiser.kind", kind)).into_iter().collect();
    let loaded = wireloom::load_with_settings(&text, &settings, &NoFiles, &wireloom::registry());
    let (_, built) = loaded.unwrap_or_else(|faults| panic!("{}", wireloom::scenario::render(&text, &faults)));
    let work = Arc::new(Mutex::new([0; 3]));
    let minimiser = Box::new(Counted { own: built.minimiser, work: Arc::clone(&work) });
    wireloom::run(Built { minimiser, ..built }, &mut |_, end| {
        assert_eq!(end.status, Status::Converged, "{path}");
        Control::Continue
    });
    *work.lock().expect("the run is over")
}

/// Work of the steps of `bench`.
fn dragged(network: &Network, shift: f64) -> Work {
    let case = drag("drag", network, Vector::new(shift, 0.0, 0.0), Vector::x(), 1, 10);
    assert!(case.failures == 0 && case.residual < 1e-8, "{case:?}");
    let per_step = [case.iterations_per_step, case.factorisations_per_step, case.evaluations_per_step];
    per_step.map(|mean| (20.0 * mean).round() as usize)
}

fn spent(name: &str) -> Work {
    match (name, name.split_once(' ')) {
        ("drag", _) => dragged(&cable(1_000), -0.4),
        ("drag-friction", _) => dragged(&cable_with_friction(1_000), -0.4),
        ("drag-harness", _) => dragged(&harness(), -0.8),
        (_, Some((path, minimiser))) => run(path, Some(minimiser)),
        (path, None) => run(path, None),
    }
}

#[test]
#[cfg_attr(
    not(all(target_env = "gnu", target_arch = "x86_64")),
    ignore = "sines of another library for C, or another processor, may move counts"
)]
fn the_work_of_drags_and_scenarios_is_pinned() {
    let moved: Vec<String> = PINNED
        .iter()
        .filter_map(|(name, pinned)| {
            let now = spent(name);
            (now != *pinned).then(|| format!("    ({name:?}, {now:?}), // {pinned:?} in the table"))
        })
        .collect();
    assert!(
        moved.is_empty(),
        "iterations, factorisations and evaluations have moved:\n{}\nIf that is on purpose, write them into PINNED in \
         tests/tests/work.rs, and give the old and the new ones in the commit.",
        moved.join("\n")
    );
}
