//! Conversion from C structs to types of the core.

use nalgebra::{Quaternion, Unit};
use std::ffi::{CStr, c_char};
use wireloom_abi as abi;
use wireloom_core::constraint::{ConstraintSpec, HoldWord, SpanSpec, StationSpec};
use wireloom_core::registry::Form;
use wireloom_core::{Parameter, Parameters, Pose, Rotation, Section, Value, Vector};

/// The array as a slice; empty if there is none.
///
/// # Safety
/// `first` is null, or points to `count` elements that outlive `'a`.
pub unsafe fn slice<'a, T>(first: *const T, count: usize) -> &'a [T] {
    if first.is_null() || count == 0 {
        return &[];
    }
    // SAFETY: as the caller promises.
    unsafe { std::slice::from_raw_parts(first, count) }
}

/// As [`slice`], to be written to.
///
/// # Safety
/// As for [`slice`]; nothing else refers to the elements meanwhile.
pub unsafe fn slice_mut<'a, T>(first: *mut T, count: usize) -> &'a mut [T] {
    if first.is_null() || count == 0 {
        return &mut [];
    }
    // SAFETY: as the caller promises.
    unsafe { std::slice::from_raw_parts_mut(first, count) }
}

/// The text as a string; `None` if it is null.
///
/// # Safety
/// `text` is null, or zero-terminated.
pub unsafe fn text(text: *const c_char) -> Option<String> {
    if text.is_null() {
        return None;
    }
    // SAFETY: as the caller promises.
    Some(unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
}

/// A pose.
pub fn pose(pose: &abi::Pose) -> Pose {
    Pose { position: Vector::from(pose.position), orientation: frame(&pose.orientation) }
}

/// A frame.
pub fn frame([w, x, y, z]: &[f64; 4]) -> Rotation {
    Unit::new_unchecked(Quaternion::new(*w, *x, *y, *z))
}

/// A pose as the ABI has it.
pub fn abi_pose(pose: &Pose) -> abi::Pose {
    let q = &pose.orientation;
    abi::Pose { position: pose.position.into(), orientation: [q.w, q.i, q.j, q.k] }
}

/// A section of this name without any stiffness, limits or laws.
pub fn section(name: &str) -> Section {
    Section {
        name: name.to_owned(),
        diameter: 0.0,
        linear_density: 0.0,
        axial_stiffness: 0.0,
        shear_stiffness: [0.0; 2],
        bending_stiffness: [0.0; 2],
        torsion_stiffness: 0.0,
        coupling_stiffness: [0.0; 3],
        min_bend_radius: None,
        min_bend_radius_moving: None,
        max_tension: None,
        max_torsion: None,
        thermal_expansion: 0.0,
        thermal_curvature: Vector::zeros(),
        friction: Default::default(),
        set: None,
        laws: Default::default(),
    }
}

/// Converts the specification of a constraint.
///
/// # Safety
/// `spec` is as the ABI demands.
pub unsafe fn spec(spec: &abi::ConstraintSpec) -> ConstraintSpec {
    let word = |bit, word| (spec.hold & bit != 0).then_some(word);
    let hold = [
        word(abi::HOLD_POSITION, HoldWord::Position),
        word(abi::HOLD_TANGENT, HoldWord::Tangent),
        word(abi::HOLD_TWIST, HoldWord::Twist),
    ];
    let rails = spec.rails.iter().take(spec.rail_count as usize);
    // SAFETY: `spec` points to data as the ABI demands.
    unsafe {
        let stations = slice(spec.stations, spec.station_count as usize).iter().map(|station| StationSpec {
            place: text(station.branch).map(|branch| (branch, station.arc_length)),
            diameter: station.diameter,
        });
        ConstraintSpec {
            name: text(spec.name).unwrap_or_default(),
            stations: stations.collect(),
            span: spec.span.as_ref().map(|span| SpanSpec {
                branch: text(span.branch).unwrap_or_default(),
                range: (span.begins, span.ends),
                diameter: span.diameter,
            }),
            tangent_given: spec.tangent_given != 0,
            up_given: spec.up_given != 0,
            hold: (spec.hold != 0).then(|| hold.into_iter().flatten().collect()),
            free_axis: (spec.free_axis_given != 0).then(|| Unit::new_unchecked(Vector::from(spec.free_axis))),
            rails: rails.map(|rail| Vector::from(*rail)).collect(),
        }
    }
}

/// The values of declared parameters, in the order of declaration.
pub fn parameters(declared: &[Parameter], values: &[abi::Value]) -> Parameters {
    let given = declared.iter().zip(values).filter(|(_, value)| value.given != 0);
    let one = |parameter: &Parameter, value: &[f64; 3]| match &parameter.form {
        Form::Number { .. } => Some(Value::Number(value[0])),
        Form::Vector { .. } => Some(Value::Vector(Vector::from(*value))),
        Form::Count { .. } => Some(Value::Count(value[0] as usize)),
        Form::Flag => Some(Value::Flag(value[0] != 0.0)),
        Form::Choice(text) => text.get(value[0] as usize).cloned().map(Value::Word),
    };
    Parameters(
        given.filter_map(|(parameter, value)| Some((parameter.name.clone(), one(parameter, &value.value)?))).collect(),
    )
}
