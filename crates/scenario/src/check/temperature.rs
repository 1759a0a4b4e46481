//! Temperatures: what would have no effect, or not its whole effect, is refused.

use crate::fault::Fault;
use crate::scenario::Scenario;
use wireloom_core::{Mounting, Network, Section};

/// Refuses branches that change with the temperature in two ways, temperatures of branches that none of them feels, and
/// joints that couple a branch in a point without the curvature that it has by temperature.
pub(crate) fn refuse_without_effect(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (own, branch) in scenario.branches.iter().zip(&network.branches) {
        let first = branch.sections.at_end(true);
        let expands = |section: &Section| (section.thermal_expansion, section.thermal_curvature);
        if let Some(other) = branch.sections.iter().find(|other| expands(other) != expands(first)) {
            faults.push(Fault {
                span: own.spans.of(Some("sections")),
                message: format!(
                    "branch \"{}\": its sections \"{}\" and \"{}\" expand or bend differently with the temperature",
                    own.name, first.name, other.name
                ),
                help: "give them the same `thermal_expansion` and `thermal_curvature`, or divide the branch there, \
                       with a joint of the model \"fused\""
                    .to_owned(),
            });
        }
    }
    for (step, span) in scenario.steps.iter().zip(&scenario.step_spans) {
        let feels = |(branch, _): &(usize, f64)| network.branches[*branch].sections.at_end(true).feels_temperature();
        if !step.temperatures.is_empty() && !step.temperatures.iter().any(feels) {
            faults.push(Fault {
                span: span.clone(),
                message: format!("step \"{}\" gives temperatures to branches that do not feel them", step.name),
                help: "give their sections `thermal_expansion`, such as \"17 ppm/K\" for copper, or leave \
                       `temperature` out"
                    .to_owned(),
            });
        }
    }
    for (own, joint) in scenario.joints.iter().zip(&network.joints) {
        let bends = |b: &&usize| network.branches[**b].sections.at_end(true).bends_with_temperature();
        if let (Mounting::Point, Some(&b)) = (joint.model.mounting(), joint.branches.iter().find(bends)) {
            let branch = &network.branches[b];
            faults.push(Fault {
                span: own.spans.of(Some("model")),
                message: format!(
                    "joint \"{}\": its model \"{}\" couples branch \"{}\" at one temperature, but section \"{}\" has a \
                     thermal curvature",
                    own.name,
                    own.model,
                    branch.name,
                    branch.sections.at_end(true).name
                ),
                help: "use model = \"fused\" or \"rigid-body\": up to these a branch has the law of its section"
                    .to_owned(),
            });
        }
    }
    faults
}
