//! Shaders, layouts and pipelines, which are compiled once.

use crate::overlay_instances::{LineInstance, MarkerInstance};
use crate::render_targets::{DEPTH_FORMAT, FORMAT, TargetLayouts};
use crate::robot::Vertex;
use crate::shaders;
use crate::uniforms::{DrawUniforms, FrameUniforms};
use std::collections::BTreeMap;
use wgpu::{BindGroupLayout, RenderPipeline, ShaderStages, VertexFormat, VertexStepMode};

/// Pipelines that every image needs, and the layouts of the pipelines' bindings.
pub(crate) struct Pipelines {
    pub(crate) frame_layout: BindGroupLayout,
    pub(crate) draw_layout: BindGroupLayout,
    pub(crate) target_layouts: TargetLayouts,
    pub(crate) points: RenderPipeline,
    pub(crate) block: RenderPipeline,
    pub(crate) reach: RenderPipeline,
    pub(crate) rows: RenderPipeline,
    pub(crate) columns: RenderPipeline,
    pub(crate) shade: RenderPipeline,
    pub(crate) present: RenderPipeline,
}

/// Pipelines of the robot's mesh and of the overlay.
pub(crate) struct OverlayPipelines {
    pub(crate) meshes: RenderPipeline,
    pub(crate) grid: RenderPipeline,
    pub(crate) lines: RenderPipeline,
    pub(crate) markers: RenderPipeline,
}

impl Pipelines {
    /// `target_format`: format of the pass that [`crate::Renderer::paint`] draws into.
    pub(crate) fn new(device: &wgpu::Device, target_format: wgpu::TextureFormat) -> Self {
        let frame_layout = layout(device, "scene: frame", &[uniform::<FrameUniforms>(0, false)]);
        let draw_layout = layout(device, "scene: draw", &[uniform::<DrawUniforms>(0, true)]);
        let target_layouts = TargetLayouts {
            colour_depth: layout(device, "scene: colour and depth", &[texture(0, false), texture(1, false)]),
            radius: layout(device, "scene: radius", &[texture(0, false)]),
            present: layout(device, "scene: present", &[texture(0, true), sampler(1)]),
        };
        let builder = PipelineBuilder::new(device, &["points", "reach", "fill", "shade", "present"]);
        let draw = [&frame_layout, &draw_layout];
        let colour_depth = [&frame_layout, &target_layouts.colour_depth];
        let radius = [&frame_layout, &target_layouts.radius];
        let reach = |entry| PipelineParameters {
            vertex: "vs_reach",
            fragment: entry,
            targets: &[FORMAT],
            ..PipelineParameters::new("reach", &radius)
        };
        let filled = [&frame_layout, &target_layouts.colour_depth, &target_layouts.radius];
        let full = |entry| PipelineParameters {
            vertex: "vs_fill",
            fragment: entry,
            ..PipelineParameters::new("fill", &filled)
        };
        let present_entry = if target_format.is_srgb() { "fs_present_srgb" } else { "fs_present" };
        Self {
            points: builder.make(&PipelineParameters {
                vertex: "vs_points",
                fragment: "fs_points",
                buffer: Some((8, VertexStepMode::Vertex, &[VertexFormat::Uint16x4])),
                topology: wgpu::PrimitiveTopology::PointList,
                depth: true,
                ..PipelineParameters::new("points", &draw)
            }),
            block: builder.make(&reach("fs_block")),
            reach: builder.make(&reach("fs_reach")),
            rows: builder.make(&full("fs_rows")),
            columns: builder.make(&full("fs_columns")),
            shade: builder.make(&PipelineParameters {
                vertex: "vs_shade",
                fragment: "fs_shade",
                targets: &[FORMAT],
                ..PipelineParameters::new("shade", &colour_depth)
            }),
            present: builder.make(&PipelineParameters {
                vertex: "vs_present",
                fragment: present_entry,
                targets: &[target_format],
                ..PipelineParameters::new("present", &[&target_layouts.present])
            }),
            frame_layout,
            draw_layout,
            target_layouts,
        }
    }
}

impl OverlayPipelines {
    /// Pipelines for the images whose points `pipelines` draws.
    pub(crate) fn new(device: &wgpu::Device, pipelines: &Pipelines) -> Self {
        let builder = PipelineBuilder::new(device, &["meshes", "overlay"]);
        let draw = [&pipelines.frame_layout, &pipelines.draw_layout];
        let colour_depth = [&pipelines.frame_layout, &pipelines.target_layouts.colour_depth];
        let overlay = PipelineParameters { blend: true, ..PipelineParameters::new("overlay", &colour_depth) };
        Self {
            meshes: builder.make(&PipelineParameters {
                vertex: "vs_meshes",
                fragment: "fs_meshes",
                buffer: Some((
                    size_of::<Vertex>(),
                    VertexStepMode::Vertex,
                    &[VertexFormat::Float32x3, VertexFormat::Float32x3, VertexFormat::Unorm8x4],
                )),
                depth: true,
                ..PipelineParameters::new("meshes", &draw)
            }),
            grid: builder.make(&PipelineParameters {
                vertex: "vs_grid",
                fragment: "fs_grid",
                targets: &[FORMAT],
                ..overlay
            }),
            lines: builder.make(&PipelineParameters {
                vertex: "vs_lines",
                fragment: "fs_lines",
                buffer: Some((
                    size_of::<LineInstance>(),
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
            markers: builder.make(&PipelineParameters {
                vertex: "vs_markers",
                fragment: "fs_markers",
                buffer: Some((
                    size_of::<MarkerInstance>(),
                    VertexStepMode::Instance,
                    &[
                        VertexFormat::Float32x3,
                        VertexFormat::Float32x3,
                        VertexFormat::Unorm8x4,
                        VertexFormat::Unorm8x4,
                        VertexFormat::Float32x4,
                        VertexFormat::Float32x3,
                    ],
                )),
                targets: &[FORMAT],
                ..overlay
            }),
        }
    }
}

/// The parameters in which pipelines differ.
#[derive(Clone, Copy)]
struct PipelineParameters<'a> {
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
    /// Whether colours are premultiplied and blended over the target.
    blend: bool,
}

impl<'a> PipelineParameters<'a> {
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

struct PipelineBuilder<'a> {
    device: &'a wgpu::Device,
    modules: BTreeMap<&'static str, wgpu::ShaderModule>,
}

impl<'a> PipelineBuilder<'a> {
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

    fn make(&self, parameters: &PipelineParameters) -> RenderPipeline {
        let module = &self.modules[parameters.shader];
        let layouts: Vec<_> = parameters.layouts.iter().map(|layout| Some(*layout)).collect();
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(parameters.fragment),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let attributes = parameters.buffer.map(|(_, _, formats)| attributes(formats)).unwrap_or_default();
        let buffers: Vec<_> = parameters
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
        let blend = parameters.blend.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING);
        let targets: Vec<_> = parameters
            .targets
            .iter()
            .map(|format| {
                Some(wgpu::ColorTargetState { format: *format, blend, write_mask: wgpu::ColorWrites::ALL })
            })
            .collect();
        let depth_stencil = parameters.depth.then(|| wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            // Reversed depth: 1 at the near plane and 0 at infinity, where floats are densest.
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        });
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(parameters.fragment),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(parameters.vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &buffers,
            },
            primitive: wgpu::PrimitiveState {
                topology: parameters.topology,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(parameters.fragment),
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
