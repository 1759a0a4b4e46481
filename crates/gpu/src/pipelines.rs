//! Compute pipelines of a device: every stage, compiled once and kept between sessions.

use rayon::prelude::*;
use std::sync::OnceLock;
use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, BufferBindingType, ComputePipeline,
    ComputePipelineDescriptor, Device, PipelineCompilationOptions, PipelineLayoutDescriptor, ShaderModuleDescriptor,
    ShaderSource, ShaderStages,
};
use wireloom_shaders::{Access, BINDINGS, Real, Stage};

/// The binding whose offset changes from dispatch to dispatch.
pub(crate) const RANGE: &str = "range";

/// Layout and compiled stages of one precision.
pub(crate) struct Pipelines {
    /// Layout of the bind group that all stages share.
    pub layout: BindGroupLayout,
    /// One pipeline per stage, in the order of [`Stage::ALL`].
    pub stages: Vec<ComputePipeline>,
}

/// Pipelines of both precisions, each compiled at its first use.
#[derive(Default)]
pub(crate) struct Cache([OnceLock<Pipelines>; 2]);

impl Cache {
    pub(crate) fn get(&self, device: &Device, real: Real) -> &Pipelines {
        self.0[usize::from(real == Real::F64)].get_or_init(|| Pipelines::new(device, real))
    }
}

impl Pipelines {
    fn new(device: &Device, real: Real) -> Self {
        let entries: Vec<BindGroupLayoutEntry> = BINDINGS
            .iter()
            .map(|binding| BindGroupLayoutEntry {
                binding: binding.place,
                visibility: ShaderStages::COMPUTE,
                ty: BindingType::Buffer {
                    ty: match binding.access {
                        Access::Uniform => BufferBindingType::Uniform,
                        Access::Read => BufferBindingType::Storage { read_only: true },
                        Access::ReadWrite => BufferBindingType::Storage { read_only: false },
                    },
                    has_dynamic_offset: binding.name == RANGE,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: None, entries: &entries });
        let pipeline_layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        // Drivers compile them in a second or two, one after the other.
        let stages = Stage::ALL.par_iter().map(|stage| {
            let module = device.create_shader_module(ShaderModuleDescriptor {
                label: Some(stage.name()),
                source: ShaderSource::Wgsl(stage.text(real).into()),
            });
            device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: Some(stage.name()),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some("main"),
                compilation_options: PipelineCompilationOptions::default(),
                cache: None,
            })
        });
        Self { stages: stages.collect(), layout }
    }
}
