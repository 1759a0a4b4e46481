//! A plan on a device: buffers, submissions, read-backs.
//!
//! The host only encodes: a submission holds many cycles in one pass, followed by one read-back of the status and the
//! state of every variant.

use crate::device::Gpu;
use crate::pipelines::RANGE;
use std::ops::Range;
use std::sync::mpsc;
use std::time::Duration;
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferBinding, BufferDescriptor,
    BufferSize, BufferUsages, CommandEncoder, CommandEncoderDescriptor, ComputePassDescriptor, MapMode, PollType,
};
use wireloom_shaders::memory::{self, Memory};
use wireloom_shaders::plan::{Dispatch, Plan};
use wireloom_shaders::{Access, BINDINGS, Real, Stage};

/// Time limit for a submission; a longer one means that the device hangs.
const TIMEOUT: Duration = Duration::from_secs(120);
/// Alignment of the dispatches' ranges in their buffer: the largest that WebGPU allows a device to require.
const RANGE_STRIDE: usize = 256;

/// An encoded dispatch.
struct EncodedDispatch {
    stage: usize,
    offset: u32,
    workgroups: [u32; 3],
}

/// Reason why a session could not be created.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the harness needs a buffer of {required_limits} bytes (`{buffer}`), and the device allows {allowed}")]
pub struct TooLarge {
    /// Name of the buffer.
    pub buffer: &'static str,
    /// Its size, bytes.
    pub required_limits: u64,
    /// The largest allowed size, bytes.
    pub allowed: u64,
}

/// A plan with its buffers on a device.
pub struct Session {
    real: Real,
    /// In the order of [`BINDINGS`]; none for the ranges.
    buffers: Vec<(&'static str, Buffer)>,
    group: BindGroup,
    cycle: Vec<EncodedDispatch>,
    publish: EncodedDispatch,
    /// Byte range in `vectors` of the packed states.
    shapes: Range<u64>,
    read_back: Buffer,
}

impl Session {
    /// Creates buffers for a plan and the variants of `memory`, and uploads their contents.
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(gpu: &Gpu, real: Real, plan: &Plan, memory: &Memory) -> Result<Self, TooLarge> {
        let device = &gpu.device;
        let allowed = gpu.info.largest_buffer;
        let buffer = |name: &'static str, size: usize, usage: BufferUsages| {
            let size = size as u64;
            if size > allowed {
                return Err(TooLarge { buffer: name, required_limits: size, allowed });
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
        let publish = encoded(&plan.pack_shape());
        let mut buffers = Vec::new();
        for binding in BINDINGS {
            let kind = match binding.access {
                Access::Uniform => BufferUsages::UNIFORM,
                Access::Read | Access::ReadWrite => BufferUsages::STORAGE | BufferUsages::COPY_SRC,
            };
            // Buffers written only by stages start with zeros, as every buffer does.
            let made = match memory::Buffer::named(binding.name) {
                Some(memory::Buffer::Parts) => buffer(binding.name, memory.parts.len() * real.bytes(), kind)?,
                Some(memory::Buffer::Blocks) => buffer(binding.name, memory.blocks.len() * real.bytes(), kind)?,
                Some(memory::Buffer::Vectors) => buffer(binding.name, memory.vectors.len() * real.bytes(), kind)?,
                filled => {
                    let bytes = filled.map_or_else(|| ranges.clone(), |which| memory.bytes(which, real));
                    let made = buffer(binding.name, bytes.len(), kind)?;
                    gpu.queue.write_buffer(&made, 0, &bytes);
                    made
                }
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
        let size = |required_limits: &str| {
            buffers.iter().find(|(name, _)| *name == required_limits).map_or(0, |(_, b)| b.size())
        };
        let shapes = memory.shape_bytes(real);
        let shapes = shapes.start as u64..shapes.end as u64;
        let read_back = device.create_buffer(&BufferDescriptor {
            label: Some("read back"),
            size: size("control") + (shapes.end - shapes.start),
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Self { real, buffers, group, cycle, publish, shapes, read_back })
    }

    fn buffer(&self, name: &str) -> &Buffer {
        let found = self.buffers.iter().find(|(own, _)| *own == name);
        &found.expect("every binding has a buffer").1
    }

    /// Uploads data that changes from increment to increment.
    pub fn upload(&self, gpu: &Gpu, memory: &Memory) {
        for which in memory::Buffer::CHANGING {
            gpu.queue.write_buffer(self.buffer(which.name()), 0, &memory.bytes(which, self.real));
        }
    }

    /// Uploads all data that stages read.
    pub fn upload_all(&self, gpu: &Gpu, memory: &Memory) {
        for which in memory::Buffer::ALL {
            gpu.queue.write_buffer(self.buffer(which.name()), 0, &memory.bytes(which, self.real));
        }
    }

    /// Runs a number of cycles in one submission, and reads back the status and the state of all variants. Returns
    /// whether it succeeded; if not, [`Gpu::failure`] gives the reason.
    pub fn run(&self, gpu: &Gpu, cycles: usize, memory: &mut Memory) -> bool {
        let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor { label: None });
        for _ in 0..cycles {
            self.encode(gpu, &mut encoder, &self.cycle);
        }
        self.encode(gpu, &mut encoder, std::slice::from_ref(&self.publish));
        let [control, vectors] = ["control", "vectors"].map(|name| self.buffer(name));
        let shapes = self.shapes.end - self.shapes.start;
        encoder.copy_buffer_to_buffer(control, 0, &self.read_back, 0, control.size());
        encoder.copy_buffer_to_buffer(vectors, self.shapes.start, &self.read_back, control.size(), shapes);
        gpu.queue.submit([encoder.finish()]);
        read(gpu, &self.read_back, |bytes| {
            let (control, shapes) = bytes.split_at(control.size() as usize);
            memory.load(memory::Buffer::Control, self.real, control);
            memory.load_shapes(self.real, shapes);
        })
    }

    fn encode(&self, gpu: &Gpu, encoder: &mut CommandEncoder, dispatches: &[EncodedDispatch]) {
        let pipelines = gpu.pipelines.get(&gpu.device, self.real);
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor { label: None, timestamp_writes: None });
        for EncodedDispatch { stage, offset, workgroups: [x, y, z] } in dispatches {
            pass.set_pipeline(&pipelines.stages[*stage]);
            pass.set_bind_group(0, &self.group, &[*offset]);
            pass.dispatch_workgroups(*x, *y, *z);
        }
    }

    /// Runs one dispatch of the cycle and reads back all buffers that stages write: for tests. Returns whether it
    /// succeeded.
    pub fn step(&self, gpu: &Gpu, dispatch: usize, memory: &mut Memory) -> bool {
        let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor { label: None });
        self.encode(gpu, &mut encoder, &self.cycle[dispatch..=dispatch]);
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

/// Waits for the submission and passes the copied bytes to `take`.
fn read(gpu: &Gpu, buffer: &Buffer, take: impl FnOnce(&[u8])) -> bool {
    let (tell, told) = mpsc::channel();
    buffer.map_async(MapMode::Read, .., move |done| {
        // The receiver is gone if waiting failed.
        let _ = tell.send(done);
    });
    if let Err(error) = gpu.device.poll(PollType::Wait { submission_index: None, timeout: Some(TIMEOUT) }) {
        gpu.fail(format!("the device does not answer: {error}"));
    }
    // Another waiting thread may be notified first.
    match told.recv_timeout(TIMEOUT) {
        Ok(Ok(())) => match buffer.get_mapped_range(..) {
            Ok(range) => take(&range),
            Err(error) => gpu.fail(format!("what the device computed cannot be read: {error}")),
        },
        Ok(Err(error)) => gpu.fail(format!("what the device computed cannot be read: {error}")),
        Err(_) => gpu.fail("what the device computed never arrived".to_owned()),
    }
    buffer.unmap();
    gpu.failure().is_none()
}
