//! Render targets: the textures between the passes, sized to the viewport.

/// Format of colour and of packed depth: every browser can draw into it and read it.
pub(crate) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A colour texture and a packed depth texture.
pub(crate) struct ColourDepthTarget {
    pub(crate) colour: wgpu::TextureView,
    pub(crate) depth: wgpu::TextureView,
    /// Bindings of both for a pass that reads them.
    pub(crate) group: wgpu::BindGroup,
}

/// Edge of a block of pixels, px: `BLOCK` of common.wgsl.
const BLOCK_PX: u32 = 8;

/// A radius for each block of pixels, in the form of the packed depth's fourth byte.
pub(crate) struct RadiusTarget {
    pub(crate) view: wgpu::TextureView,
    /// Its binding for a pass that reads it.
    pub(crate) group: wgpu::BindGroup,
}

/// How passes bind what they read.
pub(crate) struct TargetLayouts {
    /// Colour and packed depth.
    pub(crate) colour_depth: wgpu::BindGroupLayout,
    /// A [`RadiusTarget`].
    pub(crate) radius: wgpu::BindGroupLayout,
    /// The finished image.
    pub(crate) present: wgpu::BindGroupLayout,
}

/// All textures for one viewport size.
pub(crate) struct RenderTargets {
    pub(crate) size: [u32; 2],
    /// Points and meshes; after the fill passes the filled image.
    pub(crate) scene: ColourDepthTarget,
    /// The packed depth of `scene` as what the largest radius of every block is read from.
    pub(crate) radius_group: wgpu::BindGroup,
    /// The largest radius of the points in every block.
    pub(crate) block: RadiusTarget,
    /// The largest radius of the points that reach every block.
    pub(crate) reach: RadiusTarget,
    /// The image between the two fill passes.
    pub(crate) rows: ColourDepthTarget,
    /// Depth buffer of the first pass.
    pub(crate) z: wgpu::TextureView,
    /// The finished image.
    pub(crate) finished: wgpu::TextureView,
    pub(crate) finished_group: wgpu::BindGroup,
}

impl RenderTargets {
    pub(crate) fn new(device: &wgpu::Device, size: [u32; 2], layouts: &TargetLayouts) -> Self {
        let finished = texture(device, "scene: finished", size, FORMAT);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let finished_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene: finished"),
            layout: &layouts.present,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&finished) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&sampler) },
            ],
        });
        let scene = ColourDepthTarget::new(device, size, &layouts.colour_depth);
        let blocks = size.map(|px| px.div_ceil(BLOCK_PX));
        Self {
            size,
            radius_group: radius_group(device, &layouts.radius, &scene.depth),
            scene,
            block: RadiusTarget::new(device, blocks, &layouts.radius),
            reach: RadiusTarget::new(device, blocks, &layouts.radius),
            rows: ColourDepthTarget::new(device, size, &layouts.colour_depth),
            z: texture(device, "scene: z", size, DEPTH_FORMAT),
            finished,
            finished_group,
        }
    }
}

impl ColourDepthTarget {
    fn new(device: &wgpu::Device, size: [u32; 2], layout: &wgpu::BindGroupLayout) -> Self {
        let colour = texture(device, "scene: colour", size, FORMAT);
        let depth = texture(device, "scene: packed depth", size, FORMAT);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene: colour and depth"),
            layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&colour) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&depth) },
            ],
        });
        Self { colour, depth, group }
    }

    /// Attachments of a pass that draws into both; `clear` empties them first.
    pub(crate) fn attachments(&self, clear: bool) -> [Option<wgpu::RenderPassColorAttachment<'_>>; 2] {
        // Three full bytes mean an empty pixel; the fourth is a radius of 0.
        let nothing = wgpu::Color { r: 1.0, g: 1.0, b: 1.0, a: 0.0 };
        [(&self.colour, wgpu::Color::TRANSPARENT), (&self.depth, nothing)].map(|(view, colour)| {
            let load = if clear { wgpu::LoadOp::Clear(colour) } else { wgpu::LoadOp::Load };
            Some(attachment(view, load))
        })
    }
}

impl RadiusTarget {
    fn new(device: &wgpu::Device, size: [u32; 2], layout: &wgpu::BindGroupLayout) -> Self {
        let view = texture(device, "scene: radius", size, FORMAT);
        let group = radius_group(device, layout, &view);
        Self { view, group }
    }
}

fn radius_group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    view: &wgpu::TextureView,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("scene: radius"),
        layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(view) }],
    })
}

/// A colour attachment whose result is stored.
pub(crate) fn attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
    }
}

fn texture(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
