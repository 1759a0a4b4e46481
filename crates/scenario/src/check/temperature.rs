//! Temperatures: what would have no effect, or not its whole effect, is refused.

use crate::fault::Fault;
use crate::scenario::Scenario;
use wireloom_core::{Mounting, Network};

/// Refuses temperatures of branches that none of them feels, and joints that couple a branch in a point without the
/// curvature that it has by temperature.
pub(crate) fn refuse_without_effect(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (step, span) in scenario.steps.iter().zip(&scenario.step_spans) {
        let feels = |(branch, _): &(usize, f64)| network.branches[*branch].section.feels_temperature();
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
        let bends = |b: &&usize| network.branches[**b].section.bends_with_temperature();
        if let (Mounting::Point, Some(&b)) = (joint.model.mounting(), joint.branches.iter().find(bends)) {
            let branch = &network.branches[b];
            faults.push(Fault {
                span: own.spans.of(Some("model")),
                message: format!(
                    "joint \"{}\": its model \"{}\" couples branch \"{}\" at one temperature, but section \"{}\" has a \
                     thermal curvature",
                    own.name, own.model, branch.name, branch.section.name
                ),
                help: "use model = \"fused\" or \"rigid-body\": up to these a branch has the law of its section"
                    .to_owned(),
            });
        }
    }
    faults
}
