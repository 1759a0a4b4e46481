//! The header for C++ refuses classes with functions that it could not call.

use super::{Checked, Named, Place, compile_cpp, named};
use wireloom_tests::root;

/// Cases of `callable.cpp`, and what the compiler says; 0 is right.
const CASES: [(u32, &[&str]); 12] = [
    (0, &[]),
    (1, &["`evaluate` of this class", "(const WireloomSituation &at, WireloomEvaluation &out) const`"]),
    (2, &["`target` of this class", "(const WireloomPose &base, double progress, WireloomPose &to) const`"]),
    (3, &["`commit` of this class", "`void commit(const WireloomSituation &at, double *memory) const`"]),
    (4, &["`report` of this class", "`void report(const WireloomSituation &at, double *values) const`"]),
    (5, &["`evaluate` of this class", "(const double *frames, WireloomJointEvaluation &out) const`"]),
    (6, &["`commit` of this class", "`void commit(const double *frames, double *memory) const`"]),
    (7, &["`bend` of this class", "`void bend(const double *strains, WireloomRodResponse &out) const`"]),
    (8, &["remove `final` from this class"]),
    (9, &["`stretch` of this class", "`void stretch(const double *strains, WireloomRodResponse &out) const`"]),
    (10, &["this class has no law: declare `stretch`, `bend` or both"]),
    (11, &["`commit` of this class", "`void commit(const double *strains, WireloomRodCommit &committed) const`"]),
];

pub fn trials() -> Vec<Named> {
    vec![named("C++: a function that is private, not const or has other arguments is refused", refused)]
}

fn refused() -> Checked {
    let (place, source) = (Place::new()?, root().join("tests/tests/plugins/callable.cpp"));
    for (case, words) in CASES {
        let compiled = compile_cpp(&source, &place.path("libcallable.so"), &[&format!("-DCASE={case}")]);
        let said = compiled.err().map(|failed| failed.message().unwrap_or_default().to_owned());
        let told = said.as_deref().map_or(words.is_empty(), |said| {
            let asserted = !words.is_empty() && said.contains("static assertion failed");
            asserted && words.iter().all(|word| said.contains(word))
        });
        if !told {
            return Err(format!("case {case}: {said:?}").into());
        }
    }
    Ok(())
}
