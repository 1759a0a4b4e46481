//! From a large scene in which something is wrong to a small one in which the same is wrong.

use super::check::{Fault, check};
use super::scene::{Facing, Place, Scene};
use super::variants::without_arm;
use std::time::{Duration, Instant};
use wireloom::geometry::Vector;

/// The smallest scene that is found in a limited time in which the same kind of thing is wrong.
pub fn shrink(fault: &Fault, quick: bool, time: Duration) -> Fault {
    let clock = Instant::now();
    let mut best = fault.clone();
    loop {
        let mut smaller = None;
        for candidate in candidates(&best.scene) {
            if clock.elapsed() > time {
                return best;
            }
            let found =
                check(&candidate, quick).faults.into_iter().find(|f| f.kind == best.kind && f.said == best.said);
            if found.is_some() {
                smaller = found.map(|f| Fault { scene: candidate, ..f });
                break;
            }
        }
        match smaller {
            Some(fault) => best = fault,
            None => return best,
        }
    }
}

/// Simpler scenes, the simplest first.
fn candidates(scene: &Scene) -> Vec<Scene> {
    let mut all = Vec::new();
    let mut with = |change: &dyn Fn(&mut Scene)| {
        let mut s = scene.clone();
        change(&mut s);
        if s.text() != scene.text() {
            all.push(s);
        }
    };
    for k in 0..scene.branches.len() {
        with(&|s| drop_branch(s, k));
    }
    with(&|s| s.cables = None);
    for k in 0..scene.obstacles.len() {
        with(&|s| {
            s.obstacles.remove(k);
        });
    }
    for k in (0..scene.steps.len()).rev() {
        with(&|s| drop_step(s, k));
        with(&|s| s.steps[k].moves.clear());
        for m in 0..scene.steps[k].moves.len() {
            with(&|s| {
                s.steps[k].moves.remove(m);
            });
        }
        with(&|s| s.steps[k].release.clear());
        with(&|s| s.steps[k].loads.clear());
        with(&|s| s.steps[k].gravity = None);
        with(&|s| s.steps[k].increments = 1);
    }
    for k in 0..scene.constraints.len() {
        with(&|s| {
            let name = s.constraints[k].name;
            drop_constraint(s, name);
        });
        with(&|s| s.constraints[k].slide = s.constraints[k].slide.map(|_| 0.0));
        with(&|s| s.constraints[k].rail = None);
        with(&|s| s.constraints[k].free_axis = None);
        with(&|s| s.constraints[k].stiffness = None);
    }
    for k in 0..scene.loads.len() {
        with(&|s| {
            let load = s.loads.remove(k);
            s.steps.iter_mut().for_each(|step| step.loads.retain(|(name, _)| *name != load.name));
        });
    }
    for k in 0..scene.joints.len() {
        with(&|s| s.joints[k].mass = 0.0);
        with(&|s| s.joints[k].wires.clear());
        with(&|s| s.joints[k].arms.iter_mut().for_each(|arm| arm.offset = Vector::zeros()));
        with(&|s| s.joints[k].model = "fused");
    }
    for k in 0..scene.branches.len() {
        with(&|s| s.branches[k].curvature = Vector::zeros());
        with(&|s| s.branches[k].ga = None);
        with(&|s| s.branches[k].ei = [s.branches[k].ei[0]; 2]);
        with(&|s| s.branches[k].rod = "cosserat");
        with(&|s| s.branches[k].segments = s.branches[k].segments.div_ceil(2));
        with(&|s| s.branches[k].diameter = 0.006);
    }
    with(&|s| s.gravity = Vector::new(0.0, 0.0, -9.81));
    with(&round);
    all
}

/// Numbers of two digits.
fn round(s: &mut Scene) {
    let near = |x: f64| format!("{x:.1e}").parse().unwrap_or(x);
    for b in &mut s.branches {
        (b.length, b.diameter, b.density, b.ea, b.gj) =
            (near(b.length), near(b.diameter), near(b.density), near(b.ea), near(b.gj));
        b.ei = b.ei.map(near);
        b.ga = b.ga.map(|ga| ga.map(near));
        b.curvature = b.curvature.map(near);
    }
    for f in &mut s.constraints {
        f.position = f.position.map(|x| x.map(near));
        f.stiffness = f.stiffness.map(near);
        if let Place::On(branch, at) = f.at {
            f.at = Place::On(branch, near(at));
        }
        if let Facing::Tangent(t) = f.facing {
            f.facing = Facing::Tangent(t.map(near).normalize());
        }
    }
    for l in &mut s.loads {
        (l.force, l.moment) = (l.force.map(near), l.moment.map(near));
        if let Place::On(branch, at) = l.at {
            l.at = Place::On(branch, near(at));
        }
    }
    for m in s.steps.iter_mut().flat_map(|step| &mut step.moves) {
        (m.position, m.turns) = (m.position.map(|x| x.map(near)), near(m.turns));
    }
    s.joints.iter_mut().for_each(|j| j.mass = near(j.mass));
}

fn drop_step(s: &mut Scene, k: usize) {
    s.steps.remove(k);
    let gone: Vec<usize> = s.constraints.iter().filter(|f| f.from_step == Some(k)).map(|f| f.name).collect();
    gone.into_iter().for_each(|name| drop_constraint(s, name));
    for f in &mut s.constraints {
        f.from_step = f.from_step.map(|step| step - usize::from(step > k));
    }
}

fn drop_constraint(s: &mut Scene, name: usize) {
    s.constraints.retain(|f| f.name != name);
    for step in &mut s.steps {
        step.moves.retain(|m| m.constraint != name);
        step.release.retain(|n| *n != name);
    }
}

/// Without a branch; ends that nothing is left of go with it, joints of one arm become ends.
fn drop_branch(s: &mut Scene, k: usize) {
    let branch = s.branches.remove(k);
    let gone = |place: Place, s: &Scene| match place {
        Place::On(name, _) => name == branch.name,
        Place::Vertex(v) => !s.branches.iter().any(|b| b.ends.contains(&v)),
    };
    let constraints: Vec<usize> = s.constraints.iter().filter(|f| gone(f.at, s)).map(|f| f.name).collect();
    constraints.into_iter().for_each(|name| drop_constraint(s, name));
    let loads: Vec<usize> = s.loads.iter().filter(|l| gone(l.at, s)).map(|l| l.name).collect();
    s.loads.retain(|l| !loads.contains(&l.name));
    s.steps.iter_mut().for_each(|step| step.loads.retain(|(name, _)| !loads.contains(name)));
    for joint in s.joints.iter_mut().filter(|j| branch.ends.contains(&j.vertex)) {
        joint.arms = without_arm(&joint.arms, branch.name);
        joint.wires.clear();
    }
    s.joints.retain(|j| j.arms.len() > 1);
}
