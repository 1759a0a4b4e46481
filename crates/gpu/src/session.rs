//! A plan on a device: buffers, submissions, read-backs.
//!
//! The host only copies and encodes: what threads packed for their variants goes to the device as it is, a submission
//! holds many cycles in one pass, followed by one read-back of the status and the state of every variant.

use crate::device::Gpu;
use crate::pipelines::RANGE;
use rayon::prelude::*;
use std::sync::mpsc;
use std::time::Duration;
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferBinding, BufferDescriptor,
    BufferSize, BufferUsages, CommandEncoder, CommandEncoderDescriptor, ComputePassDescriptor,
    ComputePassTimestampWrites, Features, MapMode, PollType, QuerySetDescriptor, QueryType,
};
use wireloom_shaders::memory::{self, Memory};
use wireloom_shaders::plan::{Dispatch, Plan};
use wireloom_shaders::{Access, BINDINGS, Real, Stage};

/// Time limit for a submission; a longer one means that the device hangs.
const TIMEOUT: Duration = Duration::from_secs(120);
/// Alignment of the dispatches' ranges in their buffer: the largest that WebGPU allows a device to require.
const RANGE_STRIDE: usize = 256;
/// Number of variants that one thread copies to the device's buffer: ranges of a mapping begin at multiples of 8 bytes.
const TOGETHER: usize = 64;

/// An encoded dispatch.
struct EncodedDispatch {
    stage: usize,
    offset: u32,
    workgroups: [u32; 3],
}

/// Reason why a session could not be created.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the harness needs a buffer of {required} bytes (`{buffer}`), and the device allows {allowed}")]
pub struct TooLarge {
    /// Name of the buffer.
    pub buffer: &'static str,
    /// Its size, bytes.
    pub required: u64,
    /// The largest allowed size, bytes.
    pub allowed: u64,
}

/// A plan with its buffers on a device.
pub struct Session {
    real: Real,
    /// In the order of [`BINDINGS`]; none for the ranges.
    buffers: Vec<(&'static str, Buffer)>,
    group: BindGroup,
    unpack: EncodedDispatch,
    cycle: Vec<EncodedDispatch>,
    pack_shape: EncodedDispatch,
    /// Where the host writes what it uploads.
    staging: Buffer,
    /// Bytes of a variant's upload, and of its state.
    upload_bytes: usize,
    shape_bytes: usize,
    read_back: Buffer,
}

impl Session {
    /// Creates buffers for a plan and the variants of `memory`.
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(gpu: &Gpu, real: Real, plan: &Plan, memory: &Memory) -> Result<Self, TooLarge> {
        let device = &gpu.device;
        let allowed = gpu.info.largest_buffer;
        let buffer = |name: &'static str, size: usize, usage: BufferUsages| {
            let size = size as u64;
            if size > allowed {
                return Err(TooLarge { buffer: name, required: size, allowed });
            }
            Ok(device.create_buffer(&BufferDescriptor {
                label: Some(name),
                size: size.max(16).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT),
                usage: usage | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }))
        };
        let mut ranges = Vec::new();
        let mut encoded = |dispatch: &Dispatch| {
            let offset = ranges.len() as u32;
            ranges.extend(dispatch.range.words().iter().flat_map(|word| word.to_le_bytes()));
            ranges.resize(ranges.len().next_multiple_of(RANGE_STRIDE), 0);
            EncodedDispatch {
                stage: Stage::ALL.iter().position(|stage| *stage == dispatch.stage).expect("all stages are listed"),
                offset,
                workgroups: dispatch.workgroups(memory.variants() as u32),
            }
        };
        let cycle = plan.cycle().iter().map(&mut encoded).collect();
        let (unpack, pack_shape) = (encoded(&plan.unpack()), encoded(&plan.pack_shape()));
        let mut buffers = Vec::new();
        for binding in BINDINGS {
            let kind = match binding.access {
                Access::Uniform => BufferUsages::UNIFORM,
                Access::Read | Access::ReadWrite => BufferUsages::STORAGE | BufferUsages::COPY_SRC,
            };
            // Buffers start with zeros; the host writes only what is the same for all variants.
            let numbers = |numbers: &[f64]| buffer(binding.name, numbers.len() * real.bytes(), kind);
            let written = |bytes: Vec<u8>| {
                let made = buffer(binding.name, bytes.len(), kind)?;
                gpu.queue.write_buffer(&made, 0, &bytes);
                Ok(made)
            };
            let made = match memory::Buffer::named(binding.name) {
                Some(memory::Buffer::Numbers) => numbers(&memory.numbers)?,
                Some(memory::Buffer::State) => numbers(&memory.state)?,
                Some(memory::Buffer::Parts) => numbers(&memory.parts)?,
                Some(memory::Buffer::Blocks) => numbers(&memory.blocks)?,
                Some(memory::Buffer::Vectors) => numbers(&memory.vectors)?,
                Some(memory::Buffer::Transfer) => numbers(&memory.transfer)?,
                Some(which) => written(memory.bytes(which, real))?,
                None => written(ranges.clone())?,
            };
            buffers.push((binding.name, made));
        }
        let pipelines = gpu.pipelines.get(&gpu.device, real);
        let entries: Vec<BindGroupEntry<'_>> = BINDINGS
            .iter()
            .zip(&buffers)
            .map(|(binding, (name, buffer))| BindGroupEntry {
                binding: binding.place,
                resource: if *name == RANGE {
                    BindingResource::Buffer(BufferBinding {
                        buffer,
                        offset: 0,
                        size: BufferSize::new(RANGE_STRIDE as u64),
                    })
                } else {
                    buffer.as_entire_binding()
                },
            })
            .collect();
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &pipelines.layout,
            entries: &entries,
        });
        let bytes = |count: u32| count as usize * real.bytes();
        let (upload_bytes, shape_bytes) = (bytes(plan.upload_length()), bytes(plan.shape_length()));
        let host = |label: &str, size: u64, usage: BufferUsages| {
            device.create_buffer(&BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let size = |name: &str| buffers.iter().find(|(own, _)| *own == name).map_or(0, |(_, buffer)| buffer.size());
        let staging = host("staging", size("transfer"), BufferUsages::MAP_WRITE | BufferUsages::COPY_SRC);
        let shapes = (memory.variants() * shape_bytes) as u64;
        let read_back = host("read back", size("control") + shapes, BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        Ok(Self { real, buffers, group, unpack, cycle, pack_shape, staging, upload_bytes, shape_bytes, read_back })
    }

    fn buffer(&self, name: &str) -> &Buffer {
        let found = self.buffers.iter().find(|(own, _)| *own == name);
        &found.expect("every binding has a buffer").1
    }

    /// Uploads the status of all variants, and what [`memory::pack`] gave for the first ones. Returns whether it
    /// succeeded; if not, [`Gpu::failure`] gives the reason.
    ///
    /// # Panics
    /// If one of them is longer or shorter than the plan says, or there are more than variants.
    pub fn upload(&self, gpu: &Gpu, memory: &Memory, packed: &[&[u8]]) -> bool {
        let length = self.upload_bytes;
        let written = mapped(gpu, &self.staging, MapMode::Write) && {
            packed.par_chunks(TOGETHER).enumerate().for_each(|(k, some)| {
                let first = k * TOGETHER * length;
                match self.staging.get_mapped_range_mut(first as u64..(first + some.len() * length) as u64) {
                    Ok(mut view) => {
                        for (own, at) in some.iter().zip((0..).step_by(length)) {
                            view.slice(at..at + length).copy_from_slice(own);
                        }
                    }
                    Err(error) => gpu.fail(format!("the device takes no data: {error}")),
                }
            });
            gpu.failure().is_none()
        };
        self.staging.unmap();
        let control = memory.bytes(memory::Buffer::Control, self.real);
        gpu.queue.write_buffer(self.buffer(memory::Buffer::Control.name()), 0, &control);
        let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor { label: None });
        let bytes = (packed.len() * length) as u64;
        encoder.copy_buffer_to_buffer(&self.staging, 0, self.buffer(memory::Buffer::Transfer.name()), 0, bytes);
        self.encode(gpu, &mut encoder, std::slice::from_ref(&self.unpack), None);
        gpu.queue.submit([encoder.finish()]);
        written
    }

    /// Uploads all data that stages read.
    pub fn upload_all(&self, gpu: &Gpu, memory: &Memory) {
        for which in memory::Buffer::ALL {
            gpu.queue.write_buffer(self.buffer(which.name()), 0, &memory.bytes(which, self.real));
        }
    }

    /// Runs a number of cycles in one submission, and reads back the status of all variants and the states of the first
    /// ones, each for [`memory::unpack_shape`]. `None`: [`Gpu::failure`] gives the reason.
    pub fn run(&self, gpu: &Gpu, cycles: usize, memory: &mut Memory, variants: usize) -> Option<Vec<Vec<u8>>> {
        let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor { label: None });
        for _ in 0..cycles {
            self.encode(gpu, &mut encoder, &self.cycle, None);
        }
        self.encode(gpu, &mut encoder, std::slice::from_ref(&self.pack_shape), None);
        let [control, transfer] = ["control", "transfer"].map(|name| self.buffer(name));
        let shapes = variants * self.shape_bytes;
        encoder.copy_buffer_to_buffer(control, 0, &self.read_back, 0, control.size());
        encoder.copy_buffer_to_buffer(transfer, 0, &self.read_back, control.size(), shapes as u64);
        gpu.queue.submit([encoder.finish()]);
        let mut found = Vec::new();
        let read = read(gpu, &self.read_back, |bytes| {
            let (control, rest) = bytes.split_at(control.size() as usize);
            memory.load(memory::Buffer::Control, self.real, control);
            found = rest[..shapes].par_chunks_exact(self.shape_bytes).map(<[u8]>::to_vec).collect();
        });
        read.then_some(found)
    }

    /// Encodes dispatches as one pass, whose begin and end may be timed.
    fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        dispatches: &[EncodedDispatch],
        timestamp_writes: Option<ComputePassTimestampWrites<'_>>,
    ) {
        let pipelines = gpu.pipelines.get(&gpu.device, self.real);
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor { label: None, timestamp_writes });
        for EncodedDispatch { stage, offset, workgroups: [x, y, z] } in dispatches {
            pass.set_pipeline(&pipelines.stages[*stage]);
            pass.set_bind_group(0, &self.group, &[*offset]);
            pass.dispatch_workgroups(*x, *y, *z);
        }
    }

    /// Runs one cycle and returns the time of each dispatch, s, by the device's clock; `None` if it has no such clock,
    /// or failed ([`Gpu::failure`] gives the reason). For benchmarks.
    pub fn time_cycle(&self, gpu: &Gpu) -> Option<Vec<(Stage, f64)>> {
        /// Largest number of times of a query set.
        const TIMES: usize = 4096;
        let device = &gpu.device;
        let count = 2 * self.cycle.len() as u32;
        if !device.features().contains(Features::TIMESTAMP_QUERY) || count as usize > TIMES {
            return None;
        }
        let times = device.create_query_set(&QuerySetDescriptor { label: None, ty: QueryType::Timestamp, count });
        let buffer = |usage| {
            let size = u64::from(count) * 8;
            device.create_buffer(&BufferDescriptor { label: Some("times"), size, usage, mapped_at_creation: false })
        };
        let resolved = buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC);
        let read_back = buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor { label: None });
        for (first, dispatch) in (0..).step_by(2).zip(&self.cycle) {
            let writes = ComputePassTimestampWrites {
                query_set: &times,
                beginning_of_pass_write_index: Some(first),
                end_of_pass_write_index: Some(first + 1),
            };
            self.encode(gpu, &mut encoder, std::slice::from_ref(dispatch), Some(writes));
        }
        encoder.resolve_query_set(&times, 0..count, &resolved, 0);
        encoder.copy_buffer_to_buffer(&resolved, 0, &read_back, 0, resolved.size());
        gpu.queue.submit([encoder.finish()]);
        let tick = f64::from(gpu.queue.get_timestamp_period()) * 1e-9;
        let mut found = Vec::new();
        let succeeded = read(gpu, &read_back, |bytes| {
            let ticks = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().expect("eight bytes"));
            for (dispatch, both) in self.cycle.iter().zip(bytes.chunks_exact(16)) {
                let (begin, end) = both.split_at(8);
                found.push((Stage::ALL[dispatch.stage], ticks(end).saturating_sub(ticks(begin)) as f64 * tick));
            }
        });
        succeeded.then_some(found)
    }

    /// Runs one dispatch of the cycle and reads back all buffers that stages write: for tests. Returns whether it
    /// succeeded.
    pub fn step(&self, gpu: &Gpu, dispatch: usize, memory: &mut Memory) -> bool {
        let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor { label: None });
        self.encode(gpu, &mut encoder, &self.cycle[dispatch..=dispatch], None);
        gpu.queue.submit([encoder.finish()]);
        let written = BINDINGS.iter().filter(|binding| binding.access == Access::ReadWrite);
        written.filter_map(|binding| memory::Buffer::named(binding.name)).all(|which| {
            let from = self.buffer(which.name());
            let to = gpu.device.create_buffer(&BufferDescriptor {
                label: Some("read back"),
                size: from.size(),
                usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor { label: None });
            encoder.copy_buffer_to_buffer(from, 0, &to, 0, from.size());
            gpu.queue.submit([encoder.finish()]);
            read(gpu, &to, |bytes| memory.load(which, self.real, bytes))
        })
    }
}

/// Waits for the submission and passes the copied bytes to `take`. Returns whether it succeeded.
fn read(gpu: &Gpu, buffer: &Buffer, take: impl FnOnce(&[u8])) -> bool {
    if mapped(gpu, buffer, MapMode::Read) {
        match buffer.get_mapped_range(..) {
            Ok(range) => take(&range),
            Err(error) => gpu.fail(format!("what the device computed cannot be read: {error}")),
        }
    }
    buffer.unmap();
    gpu.failure().is_none()
}

/// Waits until the host has access to a buffer. Returns whether it has.
fn mapped(gpu: &Gpu, buffer: &Buffer, mode: MapMode) -> bool {
    let (tell, told) = mpsc::channel();
    buffer.map_async(mode, .., move |done| {
        // The receiver is gone if waiting failed.
        let _ = tell.send(done);
    });
    if let Err(error) = gpu.device.poll(PollType::Wait { submission_index: None, timeout: Some(TIMEOUT) }) {
        gpu.fail(format!("the device does not answer: {error}"));
    }
    // Another waiting thread may be notified first.
    match told.recv_timeout(TIMEOUT) {
        Ok(Ok(())) => {}
        Ok(Err(error)) => gpu.fail(format!("the host has no access to a buffer of the device: {error}")),
        Err(_) => gpu.fail("the device does not hand over a buffer".to_owned()),
    }
    gpu.failure().is_none()
}
