//! Everything that is compiled once: shaders, layouts, pipelines.

use crate::lines::{Mark, Segment};
use crate::robot::Vertex;
use crate::shaders;
use crate::targets::{DEPTH_FORMAT, FORMAT};
use crate::uniforms::{Globals, Piece};
use std::collections::BTreeMap;
use wgpu::{BindGroupLayout, RenderPipeline, ShaderStages, VertexFormat, VertexStepMode};

/// What every picture needs, and the layouts of what pipelines read.
pub(crate) struct Pipelines {
    pub(crate) globals_layout: BindGroupLayout,
    pub(crate) piece_layout: BindGroupLayout,
    pub(crate) picture_layout: BindGroupLayout,
    pub(crate) present_layout: BindGroupLayout,
    pub(crate) points: RenderPipeline,
    pub(crate) rows: RenderPipeline,
    pub(crate) columns: RenderPipeline,
    pub(crate) shade: RenderPipeline,
    pub(crate) present: RenderPipeline,
}

/// What is drawn among and over the points.
pub(crate) struct Figures {
    pub(crate) solids: RenderPipeline,
    pub(crate) grid: RenderPipeline,
    pub(crate) lines: RenderPipeline,
    pub(crate) marks: RenderPipeline,
}

impl Pipelines {
    /// `target_format`: of the pass that [`crate::Renderer::paint`] draws into.
    pub(crate) fn new(device: &wgpu::Device, target_format: wgpu::TextureFormat) -> Self {
        let globals_layout = layout(device, "scene: globals", &[uniform::<Globals>(0, false)]);
        let piece_layout = layout(device, "scene: piece", &[uniform::<Piece>(0, true)]);
        let picture_layout = layout(device, "scene: picture", &[texture(0, false), texture(1, false)]);
        let present_layout = layout(device, "scene: present", &[texture(0, true), sampler(1)]);
        let maker = Maker::new(device, &["points", "fill", "shade", "present"]);
        let piece = [&globals_layout, &piece_layout];
        let picture = [&globals_layout, &picture_layout];
        let full = |entry| Draw { vertex: "vs_fill", fragment: entry, ..Draw::new("fill", &picture) };
        let present_entry = if target_format.is_srgb() { "fs_present_srgb" } else { "fs_present" };
        Self {
            points: maker.make(&Draw {
                vertex: "vs_points",
                fragment: "fs_points",
                buffer: Some((8, VertexStepMode::Vertex, &[VertexFormat::Uint16x4])),
                topology: wgpu::PrimitiveTopology::PointList,
                depth: true,
                ..Draw::new("points", &piece)
            }),
            rows: maker.make(&full("fs_rows")),
            columns: maker.make(&full("fs_columns")),
            shade: maker.make(&Draw {
                vertex: "vs_shade",
                fragment: "fs_shade",
                targets: &[FORMAT],
                ..Draw::new("shade", &picture)
            }),
            present: maker.make(&Draw {
                vertex: "vs_present",
                fragment: present_entry,
                targets: &[target_format],
                ..Draw::new("present", &[&present_layout])
            }),
            globals_layout,
            piece_layout,
            picture_layout,
            present_layout,
        }
    }
}

impl Figures {
    /// For pictures whose points `pipelines` draws.
    pub(crate) fn new(device: &wgpu::Device, pipelines: &Pipelines) -> Self {
        let maker = Maker::new(device, &["solids", "overlay"]);
        let piece = [&pipelines.globals_layout, &pipelines.piece_layout];
        let picture = [&pipelines.globals_layout, &pipelines.picture_layout];
        let overlay = Draw { blend: true, ..Draw::new("overlay", &picture) };
        Self {
            solids: maker.make(&Draw {
                vertex: "vs_solids",
                fragment: "fs_solids",
                buffer: Some((
                    size_of::<Vertex>(),
                    VertexStepMode::Vertex,
                    &[VertexFormat::Float32x3, VertexFormat::Float32x3, VertexFormat::Unorm8x4],
                )),
                depth: true,
                ..Draw::new("solids", &piece)
            }),
            grid: maker.make(&Draw { vertex: "vs_grid", fragment: "fs_grid", targets: &[FORMAT], ..overlay }),
            lines: maker.make(&Draw {
                vertex: "vs_lines",
                fragment: "fs_lines",
                buffer: Some((
                    size_of::<Segment>(),
                    VertexStepMode::Instance,
                    &[
                        VertexFormat::Float32x3,
                        VertexFormat::Float32x3,
                        VertexFormat::Unorm8x4,
                        VertexFormat::Float32x4,
                    ],
                )),
                targets: &[FORMAT],
                ..overlay
            }),
            marks: maker.make(&Draw {
                vertex: "vs_marks",
                fragment: "fs_marks",
                buffer: Some((
                    size_of::<Mark>(),
                    VertexStepMode::Instance,
                    &[
                        VertexFormat::Float32x3,
                        VertexFormat::Float32x3,
                        VertexFormat::Unorm8x4,
                        VertexFormat::Unorm8x4,
                        VertexFormat::Float32x4,
                        VertexFormat::Float32,
                    ],
                )),
                targets: &[FORMAT],
                ..overlay
            }),
        }
    }
}

/// What sets one pipeline apart.
#[derive(Clone, Copy)]
struct Draw<'a> {
    shader: &'static str,
    vertex: &'static str,
    fragment: &'static str,
    layouts: &'a [&'a BindGroupLayout],
    /// Stride, step and the attributes in the order of their locations, without gaps.
    buffer: Option<(usize, VertexStepMode, &'a [VertexFormat])>,
    topology: wgpu::PrimitiveTopology,
    targets: &'a [wgpu::TextureFormat],
    /// Whether the z buffer is tested and written.
    depth: bool,
    /// Whether colours are premultiplied and laid over what is there.
    blend: bool,
}

impl<'a> Draw<'a> {
    fn new(shader: &'static str, layouts: &'a [&'a BindGroupLayout]) -> Self {
        Self {
            shader,
            vertex: "",
            fragment: "",
            layouts,
            buffer: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
            targets: &[FORMAT, FORMAT],
            depth: false,
            blend: false,
        }
    }
}

struct Maker<'a> {
    device: &'a wgpu::Device,
    modules: BTreeMap<&'static str, wgpu::ShaderModule>,
}

impl<'a> Maker<'a> {
    fn new(device: &'a wgpu::Device, shaders: &[&str]) -> Self {
        let wanted = shaders::sources().into_iter().filter(|(name, _)| shaders.contains(name));
        let modules = wanted.map(|(name, source)| {
            let descriptor = wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            };
            (name, device.create_shader_module(descriptor))
        });
        Self { device, modules: modules.collect() }
    }

    fn make(&self, draw: &Draw) -> RenderPipeline {
        let module = &self.modules[draw.shader];
        let layouts: Vec<_> = draw.layouts.iter().map(|layout| Some(*layout)).collect();
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(draw.fragment),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let attributes = draw.buffer.map(|(_, _, formats)| attributes(formats)).unwrap_or_default();
        let buffers: Vec<_> = draw
            .buffer
            .iter()
            .map(|(stride, step_mode, _)| {
                Some(wgpu::VertexBufferLayout {
                    array_stride: *stride as u64,
                    step_mode: *step_mode,
                    attributes: &attributes,
                })
            })
            .collect();
        let blend = draw.blend.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING);
        let targets: Vec<_> = draw
            .targets
            .iter()
            .map(|format| {
                Some(wgpu::ColorTargetState { format: *format, blend, write_mask: wgpu::ColorWrites::ALL })
            })
            .collect();
        let depth_stencil = draw.depth.then(|| wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            // 1 is at the near plane and 0 at infinity, where floats are densest.
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        });
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(draw.fragment),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(draw.vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &buffers,
            },
            primitive: wgpu::PrimitiveState { topology: draw.topology, ..wgpu::PrimitiveState::default() },
            depth_stencil,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(draw.fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

fn attributes(formats: &[VertexFormat]) -> Vec<wgpu::VertexAttribute> {
    let mut offset = 0;
    (0..)
        .zip(formats)
        .map(|(shader_location, format)| {
            let attribute = wgpu::VertexAttribute { format: *format, offset, shader_location };
            offset += format.size();
            attribute
        })
        .collect()
}

fn layout(device: &wgpu::Device, label: &str, entries: &[wgpu::BindGroupLayoutEntry]) -> BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
}

fn uniform<T>(binding: u32, has_dynamic_offset: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: wgpu::BufferSize::new(size_of::<T>() as u64),
        },
        count: None,
    }
}

fn texture(binding: u32, filterable: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

fn sampler(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    }
}
