//! A device against one core of the processor beside it: drag steps of one cable, and the tolerance study in batches.

use super::monte_carlo::{MonteCarlo, monte_carlo};
use super::{Case, cable, hung, stroke};
use wireloom_core::registry::Parameters;
use wireloom_core::{Minimiser, Monitor, Problem, Stop, Vector};
use wireloom_gpu::{DeviceInfo, SharedDevice};
use wireloom_solve::minimisers::newton::Newton;

/// Timings of a device and of the processor for the same work.
#[derive(Clone, Debug, PartialEq)]
pub struct OnDevice {
    /// The device.
    pub device: DeviceInfo,
    /// Drag steps of cables of 1,000 and 10,000 segments: on the device, and by `newton` on one core.
    pub drags: Vec<(Case, Case)>,
    /// The tolerance study on the device.
    pub batch: MonteCarlo,
    /// The same by `newton` on one core, of a hundredth of the points.
    pub one_core: MonteCarlo,
}

impl OnDevice {
    /// Points in a second on the device to those on one core.
    pub fn batch_ratio(&self) -> f64 {
        let rate = |all: &MonteCarlo| all.points as f64 / all.seconds;
        rate(&self.batch) / rate(&self.one_core)
    }
}

/// Measures a device, with so many points of the tolerance study.
///
/// # Errors
/// Why there is no such device, and what would be right.
///
/// # Panics
/// If the system has no thread left.
pub fn on_device(wish: Option<&str>, points: usize) -> Result<OnDevice, String> {
    let devices = SharedDevice::for_single_runs(wish);
    let device = devices.get().map_err(|error| format!("{error}\n{}", error.help()))?.info.clone();
    let registry = crate::registry_on(devices.clone(), &Monitor::default());
    let build = &registry.minimiser("gpu").expect("a built-in kind").build;
    let mut gpu = build(&(), &Parameters::default()).map_err(|error| format!("{error}\n{}", error.help))?;
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let drags = [(1_000, 4), (10_000, 1)].map(|(segments, strokes)| drag(gpu.as_mut(), &alone, segments, strokes));
    let many = devices.for_batches();
    let batch =
        monte_carlo(points, Some("gpu"), Some(many.batch()), &crate::registry_on(many.clone(), &Monitor::default()));
    let one_core = alone.install(|| monte_carlo(points.div_ceil(100), None, None, &registry));
    Ok(OnDevice { device, drags: drags.into(), batch, one_core })
}

/// The same steps on the device and on one core.
fn drag(gpu: &mut dyn Minimiser, alone: &rayon::ThreadPool, segments: usize, strokes: usize) -> (Case, Case) {
    let stop = Stop { force_tolerance: 1e-8, max_iterations: 200 };
    let network = cable(segments);
    let mut newton = Newton::new();
    let (start, state) = hung(&network, &mut newton, &stop, Vector::new(-0.4, 0.0, 0.0));
    let conditions = start.conditions().clone();
    let run = |minimiser: &mut dyn Minimiser| {
        let problem = Problem::new(&network, conditions.clone());
        stroke("drag", (problem, state.clone()), minimiser, &stop, 1, Vector::x(), (strokes, 10))
    };
    (run(gpu), alone.install(|| run(&mut Newton::new())))
}
