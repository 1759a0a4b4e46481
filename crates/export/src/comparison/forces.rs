//! The forces of constraints, several results side by side: which clip sees the largest one over all variants.

use super::Case;

/// The forces of a constraint.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// Name of the constraint.
    pub constraint: String,
    /// Force in the last equilibrium of each result, N; `None` where the constraint does not act.
    pub of: Vec<Option<f64>>,
    /// Index of the result with the largest one.
    pub largest: usize,
}

impl Forces {
    /// The largest one, N.
    pub fn most(&self) -> f64 {
        self.of[self.largest].unwrap_or(0.0)
    }
}

/// The forces of all constraints that act in any of the results, the largest first.
pub fn forces(cases: &[Case]) -> Vec<Forces> {
    let mut all: Vec<Forces> = Vec::new();
    let mut index = std::collections::HashMap::new();
    for (k, case) in cases.iter().enumerate() {
        for own in &case.ending.constraints {
            let at = *index.entry(own.name.as_str()).or_insert_with(|| {
                all.push(Forces { constraint: own.name.clone(), of: vec![None; cases.len()], largest: k });
                all.len() - 1
            });
            let force = own.force.norm();
            all[at].of[k] = Some(force);
            if force > all[at].most() {
                all[at].largest = k;
            }
        }
    }
    // Of equal ones the first of the scenario comes first.
    all.sort_by(|a, b| b.most().total_cmp(&a.most()));
    all
}
