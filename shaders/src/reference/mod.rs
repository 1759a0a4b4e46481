//! CPU reference of every stage, one file for each of `stages/` and of `shared/`. Only tests see it: those of this
//! crate, and others with the feature `reference`. It works on the same [`Memory`] in f64, so the results of a device
//! can be compared stage by stage, also in a debugger.
//!
//! A test of a device against `wireloom_core::Problem` does not replace it. The problem has the energies and their
//! derivatives, but not the inertia of the factorisation, the shift, the condensation, the line search and the phases.
//! A device that gets one of these wrong may still converge, only more slowly. For example, a smaller increase of the
//! shift passes the conformance suite of minimisers, and fails the parity test of `wireloom-gpu`. Also, the reference
//! is tested without any device.

mod accept_step;
mod assemble_gradient;
mod assemble_matrix;
mod assemble_right_hand_side;
mod begin_line_search;
mod check_inertia;
mod check_points_inertia;
mod combine_directions;
mod condense_points;
mod evaluate_couplings;
mod evaluate_segments;
mod evaluate_springs;
mod evaluate_station_segments;
mod factorise;
mod linearise_couplings;
mod linearise_segments;
mod linearise_springs;
mod linearise_station_segments;
mod load_gradient;
mod pack_shape;
mod record_trial;
mod retract;
mod shared;
mod solve_backward;
mod solve_forward;
mod sum_partials;
mod sum_state;
mod sum_step;
#[cfg(test)]
mod tests;
mod unpack;

use crate::Stage;
use crate::memory::Memory;
use crate::plan::{Dispatch, Plan};

/// Runs a dispatch: its stage on every item of every variant in one of its phases.
pub fn run(memory: &mut Memory, dispatch: &Dispatch) {
    let range = dispatch.range;
    let stage = match dispatch.stage {
        Stage::BeginLineSearch => begin_line_search::begin_line_search,
        Stage::CombineDirections => combine_directions::combine_directions,
        Stage::Factorise => factorise::factorise,
        Stage::AssembleGradient => assemble_gradient::assemble_gradient,
        Stage::AssembleMatrix => assemble_matrix::assemble_matrix,
        Stage::AssembleRightHandSide => assemble_right_hand_side::assemble_right_hand_side,
        Stage::CheckInertia => check_inertia::check_inertia,
        Stage::CheckPointsInertia => check_points_inertia::check_points_inertia,
        Stage::AcceptStep => accept_step::accept_step,
        Stage::LineariseCouplings => linearise_couplings::linearise_couplings,
        Stage::LineariseSegments => linearise_segments::linearise_segments,
        Stage::LineariseSprings => linearise_springs::linearise_springs,
        Stage::LineariseStationSegments => linearise_station_segments::linearise_station_segments,
        Stage::LoadGradient => load_gradient::load_gradient,
        Stage::EvaluateCouplings => evaluate_couplings::evaluate_couplings,
        Stage::EvaluateSegments => evaluate_segments::evaluate_segments,
        Stage::EvaluateSprings => evaluate_springs::evaluate_springs,
        Stage::SumState => sum_state::sum_state,
        Stage::SumPartials => sum_partials::sum_partials,
        Stage::EvaluateStationSegments => evaluate_station_segments::evaluate_station_segments,
        Stage::SumStep => sum_step::sum_step,
        Stage::PackShape => pack_shape::pack_shape,
        Stage::Unpack => unpack::unpack,
        Stage::Retract => retract::retract,
        Stage::CondensePoints => condense_points::condense_points,
        Stage::SolveBackward => solve_backward::solve_backward,
        Stage::SolveForward => solve_forward::solve_forward,
        Stage::RecordTrial => record_trial::record_trial,
    };
    for variant in 0..memory.variants() {
        if range.phases >> memory.control[variant].phase & 1 == 1 {
            for item in range.first..range.first + range.count {
                stage(memory, &range, item as usize, variant);
            }
        }
    }
}

/// Runs cycles until all variants are finished, at most this many. Returns the number of cycles.
pub fn descend(memory: &mut Memory, plan: &Plan, cycles: usize) -> usize {
    use crate::layout::Phase;
    for cycle in 0..cycles {
        if memory.control.iter().all(|control| control.phase == Phase::Done as u32) {
            return cycle;
        }
        for dispatch in plan.cycle() {
            run(memory, dispatch);
        }
    }
    cycles
}
