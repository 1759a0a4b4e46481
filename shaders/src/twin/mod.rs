//! The CPU twin of every stage: one file for each of `stages/` and of `shared/`, to be laid beside it. They work on the same
//! [`Memory`] in f64, so what a device computes can be compared stage by stage, and stepped through in a debugger.

mod begin_search;
mod combine;
mod factorise;
mod gather_gradient;
mod gather_matrix;
mod gather_right_hand_side;
mod inspect;
mod inspect_points;
mod judge;
mod linearise_couplings;
mod linearise_segments;
mod linearise_springs;
mod linearise_station_segments;
mod load_gradient;
mod measure_couplings;
mod measure_segments;
mod measure_springs;
mod measure_state;
mod measure_station_segments;
mod measure_step;
mod publish;
mod retract;
mod settle;
mod shared;
mod solve_backward;
mod solve_forward;
mod weigh;

use crate::Stage;
use crate::memory::Memory;
use crate::plan::{Dispatch, Plan};

/// One dispatch: its stage over every item of every variant that is in one of its phases.
pub fn run(memory: &mut Memory, dispatch: &Dispatch) {
    let range = dispatch.range;
    let twin = match dispatch.stage {
        Stage::BeginSearch => begin_search::begin_search,
        Stage::Combine => combine::combine,
        Stage::Factorise => factorise::factorise,
        Stage::GatherGradient => gather_gradient::gather_gradient,
        Stage::GatherMatrix => gather_matrix::gather_matrix,
        Stage::GatherRightHandSide => gather_right_hand_side::gather_right_hand_side,
        Stage::Inspect => inspect::inspect,
        Stage::InspectPoints => inspect_points::inspect_points,
        Stage::Judge => judge::judge,
        Stage::LineariseCouplings => linearise_couplings::linearise_couplings,
        Stage::LineariseSegments => linearise_segments::linearise_segments,
        Stage::LineariseSprings => linearise_springs::linearise_springs,
        Stage::LineariseStationSegments => linearise_station_segments::linearise_station_segments,
        Stage::LoadGradient => load_gradient::load_gradient,
        Stage::MeasureCouplings => measure_couplings::measure_couplings,
        Stage::MeasureSegments => measure_segments::measure_segments,
        Stage::MeasureSprings => measure_springs::measure_springs,
        Stage::MeasureState => measure_state::measure_state,
        Stage::MeasureStationSegments => measure_station_segments::measure_station_segments,
        Stage::MeasureStep => measure_step::measure_step,
        Stage::Publish => publish::publish,
        Stage::Retract => retract::retract,
        Stage::Settle => settle::settle,
        Stage::SolveBackward => solve_backward::solve_backward,
        Stage::SolveForward => solve_forward::solve_forward,
        Stage::Weigh => weigh::weigh,
    };
    for variant in 0..memory.variants() {
        if range.phases >> memory.control[variant].phase & 1 == 1 {
            for item in range.first..range.first + range.count {
                twin(memory, &range, item as usize, variant);
            }
        }
    }
}

/// Cycles until every variant is done, at most so many. Returns how many.
pub fn descend(memory: &mut Memory, plan: &Plan, cycles: usize) -> usize {
    use crate::places::Phase;
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
