//! Sections with friction or a set: combinations that would leave it out are refused.

use crate::fault::Fault;
use crate::scenario::Scenario;
use wireloom_core::network::Place;
use wireloom_core::{Mounting, Network};

/// Refuses branches whose section has friction or a set where their rod does not model it, where a joint couples them
/// without it, and where their mesh moves along the cable, as what is remembered stays with the material.
pub(crate) fn refuse_without_effect(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let mut faults = Vec::new();
    let remembers = |branch: usize| network.branches[branch].section.remembers();
    let section = |branch: usize| &network.branches[branch].section.name;
    for (b, (own, branch)) in scenario.branches.iter().zip(&network.branches).enumerate() {
        if remembers(b) && branch.rod.memory().is_empty() {
            let message = format!(
                "branch \"{}\": its rod \"{}\" has no friction or set, but its section \"{}\" has",
                own.name,
                own.rod,
                section(b)
            );
            let help = "use rod = \"cosserat\", or a section without `friction` and `set`".to_owned();
            faults.push(Fault { span: own.spans.of(Some("rod")), message, help });
        }
    }
    for (own, joint) in scenario.joints.iter().zip(&network.joints) {
        let remembering = joint.branches.iter().find(|b| remembers(**b));
        if let (Mounting::Point, Some(&b)) = (joint.model.mounting(), remembering) {
            let message = format!(
                "joint \"{}\": its model \"{}\" couples branch \"{}\" elastically, but section \"{}\" has friction \
                 or a set",
                own.name,
                own.model,
                network.branches[b].name,
                section(b)
            );
            let help =
                "use model = \"fused\" or \"rigid-body\": up to these a branch has the law of its section".to_owned();
            faults.push(Fault { span: own.spans.of(Some("model")), message, help });
        }
    }
    for (own, constraint) in scenario.constraints.iter().zip(&network.constraints) {
        let moves = if constraint.slide.is_some() { "slide" } else { "at" };
        let Place::Node { branch, .. } = constraint.place else { continue };
        if (constraint.slide.is_some() || constraint.nearest) && remembers(branch) {
            let message = format!(
                "constraint \"{}\" moves the mesh along branch \"{}\", whose section \"{}\" has friction or a set",
                own.name,
                network.branches[branch].name,
                section(branch)
            );
            let help =
                "let it hold a fixed place of the cable, or give that branch a section without `friction` and `set`";
            faults.push(Fault { span: own.spans.of(Some(moves)), message, help: help.to_owned() });
        }
    }
    faults
}
