//! `drive`: joints of mechanisms, which carry everything that is mounted on their bodies.

use super::context::{Context, DrivenJoint};
use super::{Begins, StepOperation};
use crate::format::form::{Form, Keys, may, must};
use crate::format::limits::ANY;
use crate::read::entry::Entry;
use crate::read::freedoms::{quantity, shown};
use crate::read::mechanisms::values;
use crate::read::poses;
use wireloom_core::mechanism::closure::{Driven, WayFault};
use wireloom_core::mechanism::{JointKind, Mechanism};
use wireloom_core::steps::{Drive, Operation};

/// Values of a joint that differ by less are the same, rad or m; relative to large ones.
const SAME: f64 = 1e-6;

/// Joints that are driven.
pub(crate) const DRIVE: StepOperation = StepOperation {
    key: may("drive", Form::Tables(&KEYS), "values of joints of mechanisms, reached along their arcs"),
    begins: |_| Begins::Nothing,
    read,
};

/// A joint that is driven.
const KEYS: Keys = Keys {
    what: "drive",
    keys: &[
        must("joint", Form::Name, "the joint, or \"MECHANISM/JOINT\" where several have its name"),
        may(
            "to",
            Form::QuantityOrList,
            "value at the end of the step, such as \"70 deg\"; as drawn it is `drawn`, by default 0; one for each \
             freedom: of a cylindrical joint angle and length, of a universal joint two angles, of a spherical joint \
             the rotation vector, of a planar joint two lengths and the angle, of a floating joint three lengths and \
             the rotation vector",
        ),
        may(
            "at",
            Form::QuantityOrList,
            "instead: values that are passed at equal parts of the step, each with `increments` of its own and with a \
             result",
        ),
        may(
            "path",
            Form::Name,
            "instead: a CSV file with columns t and value, from the folder of the scenario; angles in rad or as in \
             value [deg], lengths in m or as in value [mm]; t from the step's beginning to its end",
        ),
    ],
};

fn read(entry: &Entry<'_>, _: Option<usize>, step: &mut Context<'_, '_>) -> Option<Operation> {
    let ways: Vec<&str> = ["to", "at", "path"].into_iter().filter(|key| entry.has(key)).collect();
    let name = entry.word("joint")?;
    let (mechanism, joint) =
        step.names.mechanism_joints.find(entry, "joint of a mechanism", name, entry.span_of("joint"))?;
    let [key] = ways[..] else {
        let message = format!("{} gives {} of `to`, `at` and `path`", entry.label, ways.len());
        entry.fault_here(message, "give one of them: the value that the joint reaches");
        return None;
    };
    let own = &step.names.mechanisms[mechanism];
    let kind = &own.joints[joint].kind;
    if kind.freedoms() == 0 || own.joints[joint].follows.is_some() {
        let why = if kind.freedoms() == 0 { "has no freedom" } else { "follows another one" };
        entry.fault_at("joint", format!("joint \"{name}\" {why}"), "drive another joint");
        return None;
    }
    if step.drives.iter().any(|other| {
        other.mechanism == mechanism && other.driven.iter().any(|d| own.freedoms_of(joint).contains(&d.freedom))
    }) {
        entry.fault_at("joint", format!("{} drives joint \"{name}\" twice", step.entry.label), "drive it once");
        return None;
    }
    if key != "to" && kind.freedoms() != 1 {
        let message = format!("joint \"{name}\" has {} freedoms", kind.freedoms());
        entry.fault_at(key, message, "give `to`, with a value for each of them");
        return None;
    }
    let first = own.freedoms_of(joint).start;
    let (through, stops): (Vec<Vec<(f64, f64)>>, usize) = match key {
        "to" => (values(entry, key, kind)?.into_iter().map(|value| vec![(1.0, value)]).collect(), 0),
        "at" => {
            let all = stops(entry, kind)?;
            let part = |k: usize| (k + 1) as f64 / all.len() as f64;
            (vec![all.iter().enumerate().map(|(k, value)| (part(k), *value)).collect()], all.len())
        }
        _ => (vec![poses::read_values(entry, key, quantity(kind, 0))?], 0),
    };
    let driven = through.into_iter().enumerate().map(|(k, through)| Driven { freedom: first + k, through });
    step.drives.push(DrivenJoint { mechanism, driven: driven.collect(), span: entry.span_of(key), stops });
    None
}

/// The values of `at`.
fn stops(entry: &Entry<'_>, kind: &JointKind) -> Option<Vec<f64>> {
    let all: Option<Vec<f64>> =
        entry.items("at").iter().map(|item| entry.reader.number("at", item, quantity(kind, 0), ANY)).collect();
    if all.as_ref().is_some_and(Vec::is_empty) {
        entry.fault_at("at", format!("`at` of {} is empty", entry.label), "give the values that are passed");
        return None;
    }
    all
}

/// Ways of the mechanisms that a step drives; `now` are the values of all of them, which go on to the step's end. Also
/// the number of equal parts of the step with a result at their ends.
pub(crate) fn ways(step: &Context<'_, '_>, now: &mut [Vec<f64>]) -> (Vec<Drive>, usize) {
    let mut drives = Vec::new();
    for (index, mechanism) in step.names.mechanisms.iter().enumerate() {
        let own = || step.drives.iter().filter(|drive| drive.mechanism == index);
        let driven: Vec<Driven> = own().flat_map(|drive| drive.driven.iter().cloned()).collect();
        let Some(first) = own().next() else { continue };
        for drive in own() {
            refuse_jump(step.entry, mechanism, drive, &now[index]);
        }
        match mechanism.way(&now[index], &driven) {
            Ok(way) => {
                now[index] = way.end().to_vec();
                drives.push(Drive { mechanism: index, way });
            }
            Err(fault) => {
                let (message, help) = words(mechanism, &driven, &now[index], fault);
                step.entry.reader.fault(first.span.clone(), message, help);
            }
        }
    }
    let stops = |k: &DrivenJoint| k.stops > 1;
    let parts = step.drives.iter().find(|drive| stops(drive)).map_or(1, |drive| drive.stops);
    if let Some(other) = step.drives.iter().find(|drive| stops(drive) && drive.stops != parts) {
        let message = format!("{} has {parts} and {} values of `at`", step.entry.label, other.stops);
        step.entry.reader.fault(other.span.clone(), message, "give the same number of them for all joints of a step");
    }
    (drives, parts)
}

/// Refuses a table that begins at another value than the joint has.
fn refuse_jump(step: &Entry<'_>, mechanism: &Mechanism, drive: &DrivenJoint, now: &[f64]) {
    for d in &drive.driven {
        let (begins, is) = (d.at(now[d.freedom], 0.0), now[d.freedom]);
        if (begins - is).abs() > SAME * is.abs().max(1.0) {
            let joint = mechanism.joint_of(d.freedom);
            let freedom = d.freedom - mechanism.freedoms_of(joint).start;
            let [begins, is] = [begins, is].map(|value| shown(&mechanism.joints[joint].kind, freedom, value));
            let name = &mechanism.joints[joint].name;
            let message = format!("the table of joint \"{name}\" begins at {begins}, and the joint stands at {is}");
            step.reader.fault(
                drive.span.clone(),
                message,
                "begin it where the step before ends; in the first step, at the value as drawn",
            );
        }
    }
}

/// What is wrong with a way, and what would be right.
fn words(mechanism: &Mechanism, driven: &[Driven], now: &[f64], fault: WayFault) -> (String, String) {
    let name = |joint: usize| &mechanism.joints[joint].name;
    let shown = |joint: usize, freedom: usize, value: f64| shown(&mechanism.joints[joint].kind, freedom, value);
    let at = |fraction: f64| {
        let first = &driven[0];
        let joint = mechanism.joint_of(first.freedom);
        let value = first.at(now[first.freedom], fraction);
        format!("\"{}\" at {}", name(joint), shown(joint, first.freedom - mechanism.freedoms_of(joint).start, value))
    };
    match fault {
        WayFault::Open { joint, fraction, missing } => (
            format!(
                "the value of joint \"{}\" of mechanism \"{}\" does not follow, with {}",
                name(joint),
                mechanism.name,
                at(fraction)
            ),
            format!(
                "{missing} more of the freedoms of its loop must be driven, or joints must have fewer of them (a link \
                 between two spherical joints turns about itself: make one of them universal); a loop at a dead point \
                 does not say which way it goes: pass through it within a step, without a value of `at` there"
            ),
        ),
        WayFault::Parted { joint, fraction, apart: (distance, angle) } => (
            format!(
                "the loop that joint \"{}\" of mechanism \"{}\" closes opens with {}; at the end of the step it would \
                 be {:.3} mm and {:.3} deg open",
                name(joint),
                mechanism.name,
                at(fraction),
                1e3 * distance,
                angle.to_degrees()
            ),
            "stop before, or drive fewer joints of the loop".to_owned(),
        ),
        WayFault::Limit { joint, freedom, fraction, value, limit } => (
            format!(
                "joint \"{}\" of mechanism \"{}\" reaches {}, beyond its limit {}, with {}",
                name(joint),
                mechanism.name,
                shown(joint, freedom, value),
                shown(joint, freedom, limit),
                at(fraction)
            ),
            "stop before, or change its `limits`".to_owned(),
        ),
    }
}
