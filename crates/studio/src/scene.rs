//! A harness for display: names, diameters, meshes of obstacles. Frames have the positions.

use crate::frame::number;
use crate::protocol::{Branch, Constraint, Joint, MechanismJoint, Obstacle, Scene, SectionPart};
use wireloom::harness;
use wireloom::harness::{Network, Obstacle as Body, Place, Schedule};
use wireloom::parts::{Action, RotationHold};
use wireloom::result::{Identified, Identities, Identity, Measure, Part, Requirement, SectionResult};

/// Half-size at which unbounded obstacles are drawn, m.
pub(crate) const DRAWN: f64 = 10.0;

/// The scene of a network, not live, without settings, exports, notes and envelope.
pub fn of(schedule: &Schedule, program: &str, network: &Network) -> Scene {
    let identities = &schedule.identities;
    Scene {
        name: schedule.scenario.clone(),
        program: program.to_owned(),
        run: 0,
        live: false,
        gravity: schedule.gravity.into(),
        branches: (0..network.branches.len()).map(|b| branch(network, identities, b)).collect(),
        joints: network.joints.iter().map(joint).collect(),
        constraints: network.constraints.iter().map(|own| constraint(network, identities, own)).collect(),
        obstacles: network.obstacles.iter().map(obstacle).collect(),
        mechanism_joints: mechanism_joints(network),
        settings: Vec::new(),
        notes: Vec::new(),
        exports: Vec::new(),
        envelope: false,
    }
}

fn branch(network: &Network, identities: &Identities, index: usize) -> Branch {
    let branch = &network.branches[index];
    let mesh = branch.rod.mesh();
    let part = |SectionResult { section, to, diameter, bend_radius_limit: own, .. }| SectionPart {
        section,
        to,
        diameter,
        bend_radius_limit: bend_radius_limit(network, index, own),
    };
    Branch {
        name: branch.name.clone(),
        diameter: branch.sections.diameter(),
        bend_radius_limit: bend_radius_limit(network, index, branch.sections.bend_radius_limit()),
        sections: branch.sections.results(&mesh.arc_lengths()).into_iter().map(part).collect(),
        nodes: number(mesh.nodes()),
        length: mesh.length(),
        identity: identities.find(Identified::Branch, &branch.name).map(Identity::to_string),
        drawn: branch.drawn.iter().flat_map(|point| point.iter().map(|x| *x as f32)).collect(),
    }
}

/// The largest bend radius that is always required of a whole branch, or of its section, m.
fn bend_radius_limit(network: &Network, branch: usize, of_section: Option<f64>) -> Option<f64> {
    let always = |own: &&Requirement| {
        own.measure == Measure::BendRadius && own.steps.is_none() && own.of.contains(&Part::whole(branch))
    };
    let limits = network.requirements.iter().filter(always).filter_map(|own| own.min);
    limits.chain(of_section).reduce(f64::max)
}

fn joint(joint: &harness::Joint) -> Joint {
    let branches = joint.arms.iter().map(|arm| arm.branch.clone()).collect();
    Joint { name: joint.name.clone(), model: joint.kind.clone(), branches }
}

fn constraint(network: &Network, identities: &Identities, constraint: &harness::AttachedConstraint) -> Constraint {
    let place = match constraint.place {
        Place::Node { branch, node } if constraint.span.is_none() => {
            let branch = &network.branches[branch];
            Some((branch.name.clone(), branch.rod.mesh().arc_lengths()[node]))
        }
        Place::Node { .. } | Place::Joint(_) => None,
    };
    let (moves, turns) = match constraint.model.action() {
        Action::Prescribed(hold) => (hold.position, hold.rotation != RotationHold::Free),
        _ => (true, constraint.site.frame.is_some()),
    };
    Constraint {
        name: constraint.name.clone(),
        kind: constraint.kind.clone(),
        identity: identities.find(Identified::Constraint, &constraint.name).map(Identity::to_string),
        place,
        moves,
        turns,
        by_hand: false,
    }
}

/// Joints of mechanisms with one freedom, in the order of their values in frames.
pub fn mechanism_joints(network: &Network) -> Vec<MechanismJoint> {
    let all = network.mechanisms.iter().flat_map(|own| own.joints.iter().map(|joint| (&own.name, joint)));
    let with_one = all.filter(|(_, joint)| joint.kind.freedoms() == 1);
    let joint = |(mechanism, joint): (&String, &harness::MechanismJoint)| MechanismJoint {
        name: format!("{mechanism}/{}", joint.name),
        is_length: joint.kind.is_length(0),
        limits: joint.limits.first().copied().filter(|limits| limits.iter().all(|limit| limit.is_finite())),
        can_be_driven: joint.follows.is_none(),
    };
    with_one.map(joint).collect()
}

/// An obstacle in its own frame; an unbounded one is cut off.
fn obstacle(body: &Body) -> Obstacle {
    let surface = body.shape.surface(DRAWN);
    Obstacle {
        name: body.name.clone(),
        corners: surface.corners.iter().flat_map(|corner| corner.iter().map(|x| *x as f32)).collect(),
        triangles: surface.triangles.into_iter().flatten().collect(),
    }
}
