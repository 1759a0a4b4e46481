//! Held against reality: loops of three electric cables in a vertical plane, and bending tests, measured by others
//! (`../shared/data/measured/README.md` names the sources). With `WIRELOOM_REALITY=write` the page
//! `scenarios/measured/reality.md` is written.

#[path = "measured/bending.rs"]
mod bending;
#[path = "measured/loops.rs"]
mod loops;
#[path = "measured/page.rs"]
mod page;
#[path = "measured/twist.rs"]
mod twist;

use libtest_mimic::{Arguments, Failed, Trial};
use loops::CABLES;
use wireloom_tests::shared;

/// Difference of a computed twist from the measured one, relative to it.
const TWIST: f64 = 0.1;

fn main() {
    let folder = shared("data/measured");
    let trials = if folder.is_dir() {
        let all = (0..CABLES.len()).flat_map(|cable| (0..3).map(move |other| (cable, other)));
        let asked = all.filter(|(cable, other)| CABLES[*cable].0 != "black" || *other == 2);
        let of_loop = |(cable, other): (usize, usize)| {
            Trial::test(format!("{} loop {other}", CABLES[cable].0), move || loops::check(cable, other))
        };
        let of_twist = |cable: usize| Trial::test(format!("{} twist", CABLES[cable].0), move || comes_near(cable));
        let of_bending = |(k, name): (usize, String)| Trial::test(name, move || bending::check(k));
        let trials = asked.map(of_loop).chain((0..CABLES.len()).map(of_twist)).chain(bending::names().map(of_bending));
        trials.chain([Trial::test("page", page::page)]).collect()
    } else {
        let reason = format!("measured (ignored: no folder {})", folder.display());
        vec![Trial::test(reason, || Ok(())).with_ignored_flag(true)]
    };
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}

/// Whether a torsion stiffness brings the snap near to the measured twist.
fn comes_near(cable: usize) -> Result<(), Failed> {
    let measured = twist::MEASURED[cable];
    match twist::ALL_TWISTS[cable].fitted {
        Some((_, twist)) if (twist / measured - 1.0).abs() <= TWIST => Ok(()),
        other => Err(format!("{other:?} degrees, {measured} were measured").into()),
    }
}
