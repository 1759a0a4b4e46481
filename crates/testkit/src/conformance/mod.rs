//! Conformance suites of the traits of the core: one macro line runs a whole suite as tests.
//!
//! ```ignore
//! wireloom_testkit::rod_conformance!(my_rod, |spec| Box::new(MyRod::new(spec)));
//! ```
//!
//! A suite is a module of tests, one for each clause of the trait's contract and named after it. The checks
//! panic with the case, the entry and both numbers; they draw from a fixed seed, so they repeat.

pub mod constitutive;
pub mod constraint;
pub mod joint;
mod load;
pub mod minimiser;
pub mod networks;
pub mod numeric;
pub mod rod;
pub mod shape;

pub use load::{line_load, point_load};

/// A module `$name` with one test for each named check, called with `$arguments`.
#[doc(hidden)]
#[macro_export]
macro_rules! conformance_suite {
    ($name:ident, $family:ident, ($first:expr), $($check:ident)+) => {
        mod $name {
            #[allow(unused_imports, reason = "the factory may name what its file names")]
            use super::*;
            $(#[test]
            fn $check() {
                $crate::conformance::$family::$check(&$first);
            })+
        }
    };
    ($name:ident, $family:ident, ($first:expr, $second:expr), $($check:ident)+) => {
        mod $name {
            #[allow(unused_imports, reason = "the factory may name what its file names")]
            use super::*;
            $(#[test]
            fn $check() {
                $crate::conformance::$family::$check(&$first, &$second);
            })+
        }
    };
}

/// Holds a rod against the contract of [`wireloom_core::RodSegment`]: `rod_conformance!(name, factory)` with
/// `factory: Fn(RodSpec) -> Box<dyn RodSegment>`.
#[macro_export]
macro_rules! rod_conformance {
    ($name:ident, $factory:expr) => {
        $crate::handed_rod_conformance!($name, $factory, running_the_branch_from_its_other_end_changes_nothing);
    };
}

/// [`rod_conformance`] for a rod that is another one from its other end, and further checks. That the same cable run
/// from its other end has the same energy is for [`rod::is_the_same_from_its_other_end`].
#[macro_export]
macro_rules! handed_rod_conformance {
    ($name:ident, $factory:expr $(, $further:ident)*) => {
        $crate::conformance_suite!(
            $name, rod, ($factory),
            keeps_the_mesh_it_was_built_for
            gradient_is_the_derivative_of_the_energy
            hessian_is_the_second_derivative_of_the_energy
            edge_stiffness_is_that_of_the_hessian_wherever_the_points_are
            length_terms_are_derivatives_in_the_lengths
            own_forces_reproduce_the_hessian
            predicted_forces_are_first_order_in_the_step
            rigid_motion_changes_nothing
            the_sign_of_a_quaternion_does_not_matter
            inner_forces_and_moments_sum_to_zero
            rest_shape_has_no_energy_and_no_gradient
            bending_of_a_branch_cut_at_a_station_is_the_sum_of_its_parts
            energies_by_effect_are_not_negative_and_add_up
            a_law_it_says_has_its_energy
            forces_and_moments_agree_with_the_gradient
            low_order_parts_of_positions_count
            extra_curvature_shifts_the_rest_curvature
            free_strain_stretches_the_rest_shape
            non_finite_input_gives_non_finite_output
            same_input_gives_same_bits
            memory_is_committed_once
            $($further)*
        );
    };
}

/// Holds a rod with the stiffnesses of its section, shear among them, to second order in the segment length:
/// `rod_order_conformance!(name, factory)` with the factory of [`rod_conformance`]. Frames and nodes are those of a
/// helix; a rod whose stiffnesses belong to the mesh is measured at its own equilibria.
#[macro_export]
macro_rules! rod_order_conformance {
    ($name:ident, $factory:expr) => {
        $crate::conformance_suite!(
            $name, rod, ($factory),
            energy_is_second_order_in_the_segment_length
            a_station_inside_changes_the_energy_to_second_order
        );
    };
}

/// The checks of rods with constitutive laws of their own, handed to another macro behind what it is to have first.
#[doc(hidden)]
#[macro_export]
macro_rules! constitutive_checks {
    ($then:ident $($before:tt)*) => {
        $crate::$then! { $($before)*
            forces_are_the_derivative_of_the_energy
            hessian_is_the_derivative_of_the_forces
            a_run_finds_no_derivatives_wrong
            there_is_no_energy_at_rest_and_nowhere_less
            the_sign_of_the_first_component_changes_nothing
            stretch_is_convex
            a_block_is_answered_as_each_of_its_strains
            an_increment_is_remembered_once
            rigid_motion_changes_nothing
            the_sign_of_a_quaternion_does_not_matter
            inner_forces_and_moments_sum_to_zero
            running_the_branch_from_its_other_end_changes_nothing
            rest_shape_has_no_energy_and_no_gradient
            energies_by_effect_are_not_negative_and_add_up
            forces_and_moments_agree_with_the_gradient
            extra_curvature_shifts_the_rest_curvature
            free_strain_stretches_the_rest_shape
            non_finite_input_gives_non_finite_output
            same_input_gives_same_bits
        }
    };
}

/// Holds a rod with constitutive laws of its own against the contract of
/// [`wireloom_core::constitutive::ConstitutiveLaw`]: `constitutive_conformance!(name, factory)` with the factory of
/// [`rod_conformance`]. Its differences adapt to laws that bend within a thousandth of a strain.
#[macro_export]
macro_rules! constitutive_conformance {
    ($name:ident, $factory:expr) => {
        $crate::constitutive_checks! { conformance_suite $name, constitutive, ($factory), }
    };
}

/// The checks of joints, handed to another macro behind what it is to have first.
#[doc(hidden)]
#[macro_export]
macro_rules! joint_checks {
    ($then:ident $($before:tt)*) => {
        $crate::$then! { $($before)*
            hubs_have_no_energy
            gradient_is_the_derivative_of_the_energy
            hessian_is_the_second_derivative_of_the_energy
            gradient_and_hessian_are_added_to_what_is_there
            a_common_rotation_changes_nothing
            the_sign_of_a_quaternion_does_not_matter
            rest_directions_have_no_energy_and_no_gradient
            energy_is_not_negative_and_the_one_of_the_gradient
            a_law_it_says_has_its_energy
            the_order_of_the_arms_does_not_matter
            running_a_branch_from_its_other_end_changes_nothing
            non_finite_input_gives_non_finite_output
            same_input_gives_same_bits
            memory_is_committed_once
        }
    };
}

/// Holds a joint against the contract of [`wireloom_core::JointModel`]: `joint_conformance!(name, factory)` with
/// `factory: Fn(JointSpec) -> Box<dyn JointModel>`.
#[macro_export]
macro_rules! joint_conformance {
    ($name:ident, $factory:expr) => {
        $crate::joint_checks! { conformance_suite $name, joint, ($crate::conformance::joint::Subject::new($factory)), }
    };
}

/// The checks of one of the ways in which constraints act, handed to another macro behind what it is to have first.
#[doc(hidden)]
#[macro_export]
macro_rules! constraint_checks {
    (potential, $then:ident $($before:tt)*) => {
        $crate::$then! { $($before)*
            is_a_potential
            a_law_it_says_has_its_energy
            gradient_is_the_derivative_of_the_energy
            hessian_is_the_second_derivative_of_the_energy
            moving_everything_together_changes_nothing
            the_sign_of_a_quaternion_does_not_matter
            without_need_of_a_frame_there_is_no_moment
            what_is_remembered_keeps_its_length_and_is_finite
            targets_are_poses
            same_input_gives_same_bits
        }
    };
    (equations, $then:ident $($before:tt)*) => {
        $crate::$then! { $($before)*
            sets_equations
            every_residual_has_a_scale
            jacobian_is_the_derivative_of_the_residuals
            curvature_is_the_second_derivative_of_the_residuals_or_nothing
            moving_everything_together_changes_no_residual
            the_sign_of_a_quaternion_changes_no_residual
            without_need_of_a_frame_there_is_no_moment
            what_is_remembered_keeps_its_length_and_is_finite
            targets_are_poses
            same_input_gives_same_bits
        }
    };
    (potential_and_equations, $then:ident $($before:tt)*) => {
        $crate::constraint_checks! { potential, $then $($before)*
            sets_equations
            every_residual_has_a_scale
            jacobian_is_the_derivative_of_the_residuals
            curvature_is_the_second_derivative_of_the_residuals_or_nothing
            moving_everything_together_changes_no_residual
            the_sign_of_a_quaternion_changes_no_residual
        }
    };
    (prescribed, $then:ident $($before:tt)*) => {
        $crate::$then! { $($before)*
            prescribes_freedoms
            rails_and_held_directions_span_space
            needs_a_frame_exactly_if_it_holds_a_rotation
            describes_the_same_hold_every_time
            targets_are_poses
            same_input_gives_same_bits
        }
    };
}

/// A list of checks with their names, for those who learn only while they run what they check.
#[doc(hidden)]
#[macro_export]
macro_rules! listed_checks {
    ($name:ident, $($check:ident)+) => {
        #[doc = concat!("The checks, by name.")]
        pub const $name: &[(&str, Check)] = &[$((stringify!($check), $check)),+];
    };
}

/// Holds a constraint that is a potential against the contract of [`wireloom_core::Potential`]:
/// `potential_conformance!(name, factory, stations, nodes)` with `factory: Fn() -> Box<dyn Constraint>`, the number of
/// its stations, and of nodes of a span to try it on (0: it acts along none). `potential_conformance!(name, factory)`
/// is for springs that pull one station to its target, and holds them to that, too.
#[macro_export]
macro_rules! potential_conformance {
    ($name:ident, $factory:expr) => {
        $crate::constraint_checks! { potential, conformance_suite $name, constraint,
            ($crate::conformance::constraint::Subject::new($factory, 1, 0)),
            at_the_target_there_is_no_energy_and_no_force
            energy_is_not_negative
            non_finite_input_gives_non_finite_output
        }
    };
    ($name:ident, $factory:expr, $stations:expr, $nodes:expr) => {
        $crate::constraint_checks! { potential, conformance_suite $name, constraint,
            ($crate::conformance::constraint::Subject::new($factory, $stations, $nodes)),
        }
    };
}

/// Holds a constraint that sets equations against the contract of [`wireloom_core::Equations`]:
/// `equations_conformance!(name, factory, stations, nodes)`; see [`potential_conformance`].
#[macro_export]
macro_rules! equations_conformance {
    ($name:ident, $factory:expr, $stations:expr, $nodes:expr) => {
        $crate::constraint_checks! { equations, conformance_suite $name, constraint,
            ($crate::conformance::constraint::Subject::new($factory, $stations, $nodes)),
        }
    };
}

/// Holds a constraint that is a potential and sets equations against both contracts:
/// `potential_and_equations_conformance!(name, factory, stations, nodes)`; see [`potential_conformance`].
#[macro_export]
macro_rules! potential_and_equations_conformance {
    ($name:ident, $factory:expr, $stations:expr, $nodes:expr) => {
        $crate::constraint_checks! { potential_and_equations, conformance_suite $name, constraint,
            ($crate::conformance::constraint::Subject::new($factory, $stations, $nodes)),
        }
    };
}

/// Holds a constraint that prescribes freedoms against the contract of [`wireloom_core::Constraint`]:
/// `constraint_conformance!(name, factory)` with `factory: Fn() -> Box<dyn Constraint>`.
#[macro_export]
macro_rules! constraint_conformance {
    ($name:ident, $factory:expr) => {
        $crate::constraint_checks! { prescribed, conformance_suite $name, constraint,
            ($crate::conformance::constraint::Subject::new($factory, 1, 0)),
        }
    };
}

/// Holds a load at a place against the contract of [`wireloom_core::load::PointLoad`]:
/// `point_load_conformance!(name, factory)` with `factory: Fn(&Rotation) -> Box<dyn PointLoad>`, which makes it in a
/// world that is turned by the rotation: directions of the world are turned by it, those of the cable's frame are as
/// they are.
#[macro_export]
macro_rules! point_load_conformance {
    ($name:ident, $factory:expr) => {
        $crate::load_checks! { conformance_suite $name, point_load, ($factory), }
    };
}

/// Holds a load along a cable against the contract of [`wireloom_core::load::LineLoad`]:
/// `line_load_conformance!(name, factory)` with `factory: Fn(&Rotation) -> Box<dyn LineLoad>`; see
/// [`point_load_conformance`].
#[macro_export]
macro_rules! line_load_conformance {
    ($name:ident, $factory:expr) => {
        $crate::load_checks! { conformance_suite $name, line_load, ($factory), }
    };
}

/// The checks of loads, handed to another macro behind what it is to have first.
#[doc(hidden)]
#[macro_export]
macro_rules! load_checks {
    ($then:ident $($before:tt)*) => {
        $crate::$then! { $($before)*
            derivative_is_that_of_force_and_moment
            turning_world_and_cable_turns_what_it_exerts
            with_a_potential_it_exerts_its_dead_force_alone
            it_is_never_larger_than_it_says
            it_depends_on_the_frame_alone
        }
    };
}

/// Holds a minimiser against the contract of [`wireloom_core::Minimiser`]:
/// `minimiser_conformance!(name, factory, registry)` with `factory: Fn() -> Box<dyn Minimiser>` and
/// `registry: Fn() -> Registry`, which knows the rod `cosserat`, the constraint `connector` and any joints.
#[macro_export]
macro_rules! minimiser_conformance {
    ($name:ident, $factory:expr, $registry:expr) => {
        $crate::conformance_suite!(
            $name, minimiser, ($factory, $registry),
            carries_a_clamped_cable_whose_end_is_moved
            carries_every_joint_of_the_registry
            carries_a_closed_ring
            never_raises_the_energy
            comes_down_from_a_crumpled_start
            repeats_to_the_last_bit
            stops_at_the_iteration_limit
            is_interrupted_when_stopped
            fails_on_a_start_that_is_not_finite
            goes_from_network_to_network
            forgets_when_told
        );
    };
}

/// Holds a shape against the contract of [`wireloom_core::obstacle::Shape`]: `shape_conformance!(name, factory)` with
/// `factory: Fn() -> Box<dyn Shape>`.
#[macro_export]
macro_rules! shape_conformance {
    ($name:ident, $factory:expr) => {
        $crate::conformance_suite!(
            $name, shape, ($factory),
            normals_are_unit_vectors_along_which_nothing_bends
            normals_are_the_derivative_of_the_distance
            curvature_is_the_derivative_of_the_normal
            the_distance_is_that_of_the_nearest_touch
            parts_come_in_order_and_within_reach
            the_distance_grows_no_faster_than_the_way
            the_surface_is_where_the_distance_is_zero_and_faces_outward
            ways_cross_where_the_sign_changes
            a_point_that_is_nowhere_touches_nothing
            same_input_gives_same_bits
        );
    };
}
