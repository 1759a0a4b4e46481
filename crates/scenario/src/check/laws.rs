//! Sections and arms that are not linear: combinations that would leave their laws out are refused.

use crate::fault::Fault;
use crate::scenario::{Arm, Scenario};
use wireloom_core::law::RodLaw;
use wireloom_core::network::{Branch, Place};
use wireloom_core::section::SectionLaws;
use wireloom_core::{Mounting, Network, Section};

/// Refuses branches whose section has friction, a set, creep or curves where their rod does not say that it has them,
/// where a joint couples them, or rods with a law of their own, without, and, as what is remembered stays with the
/// material, where the mesh of one that remembers moves along the cable; arms with friction whose joint does not say
/// that it has it; constraints that slide where a section changes; and times of steps where nothing creeps.
pub(crate) fn refuse_without_effect(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let mut faults = Vec::new();
    // A law of bending that a rod has of its own may relax with time.
    let creeps = network.branches.iter().any(|branch| {
        let own = branch.rod.constitutive().is_some_and(|laws| laws.memory() > 0);
        own || branch.sections.iter().any(|section| !section.laws.creep.is_empty())
    });
    for (step, span) in
        scenario.steps.iter().zip(&scenario.step_spans).filter(|(step, _)| step.duration > 0.0 && !creeps)
    {
        let message = format!("step \"{}\" has a `duration`, and nothing creeps", step.name);
        let help = "give a section `creep`, or leave `duration` out".to_owned();
        faults.push(Fault { span: span.clone(), message, help });
    }
    // Sections that are not linear do not change along a branch.
    let of = |branch: usize| network.branches[branch].sections.at_end(true);
    let section = |branch: usize| &of(branch).name;
    let has = |branch: usize| of(branch).nonlinear_keys().join(", ");
    for (b, (own, branch)) in scenario.branches.iter().zip(&network.branches).enumerate() {
        let modelled = branch.rod.law().is_some_and(|law| models(&law, of(b)));
        if !of(b).nonlinear_keys().is_empty() && !modelled {
            let message = format!(
                "branch \"{}\": its section \"{}\" has {}, and its rod \"{}\" does not say that it models this",
                own.name,
                section(b),
                has(b),
                own.rod
            );
            let help = "use rod = \"cosserat\", or a section that is linear".to_owned();
            faults.push(Fault { span: own.spans.of(Some("rod")), message, help });
        }
    }
    for (own, joint) in scenario.joints.iter().zip(&network.joints) {
        let pairs = joint.model.law().map_or_else(Vec::new, |law| law.pairs);
        let left_out = |(a, arm): &(usize, &Arm)| {
            let friction = &arm.spring.friction;
            !friction.is_empty() && !pairs.iter().any(|pair| pair.a == *a && pair.friction == *friction)
        };
        if let Some((_, arm)) = own.arms.iter().enumerate().find(left_out) {
            let message = format!(
                "joint \"{}\": its arm \"{}\" has `friction`, and its model \"{}\" does not say that it models this",
                own.name, network.branches[arm.branch].name, own.model
            );
            let help = "use model = \"compliant-hub\", or leave `friction` out".to_owned();
            faults.push(Fault { span: own.spans.of(Some("model")), message, help });
        }
        let nonlinear = joint.branches.iter().find(|b| !network.branches[**b].bends_linearly());
        if let (Mounting::Point, Some(&b)) = (joint.model.mounting(), nonlinear) {
            let branch = &network.branches[b];
            let (whose, other) = match of(b).bends_linearly() {
                true => ("rod", format!("its rod \"{}\" has another law", branch.kind)),
                false => ("section", format!("section \"{}\" has {}", section(b), has(b))),
            };
            let message = format!(
                "joint \"{}\": its model \"{}\" couples branch \"{}\" by its linear stiffness, but {other}",
                own.name, own.model, branch.name
            );
            let help =
                format!("use model = \"fused\" or \"rigid-body\": up to these a branch has the law of its {whose}");
            faults.push(Fault { span: own.spans.of(Some("model")), message, help });
        }
    }
    for (own, constraint) in scenario.constraints.iter().zip(&network.constraints) {
        let moves = if constraint.slide.is_some() { "slide" } else { "at" };
        let Place::Node { branch, node } = constraint.place else { continue };
        if constraint.slide.is_some() && network.branches[branch].sections.changes().any(|change| change == node) {
            let message = format!(
                "constraint \"{}\" slides where the section of branch \"{}\" changes",
                own.name, network.branches[branch].name
            );
            let help = "put it beside the change, up to which it can slide, or let it hold the cable";
            faults.push(Fault { span: own.spans.of(Some("slide")), message, help: help.to_owned() });
        }
        if (constraint.slide.is_some() || constraint.nearest) && network.branches[branch].remembers() {
            let Branch { name, kind, .. } = &network.branches[branch];
            let what = match of(branch).remembers() {
                true => format!("section \"{}\" remembers: it has {}", section(branch), has(branch)),
                false => format!("rod \"{kind}\" remembers"),
            };
            let message = format!("constraint \"{}\" moves the mesh along branch \"{name}\", whose {what}", own.name);
            let help = "let it hold a fixed place of the cable, or give that branch a section and a rod that do not";
            faults.push(Fault { span: own.spans.of(Some(moves)), message, help: help.to_owned() });
        }
    }
    faults
}

/// Whether a rod has all that its section has beside linear stiffness.
fn models(law: &RodLaw, section: &Section) -> bool {
    // What yields stands with what slips.
    let laws = SectionLaws { torsion_set: None, ..section.laws.clone() };
    law.friction == section.slipping() && law.laws == laws
}
