//! A second, small image of the same scene, from another view.

use super::*;

/// Buffers and textures of the image. The points are those of the main one.
pub(super) struct Inset {
    frame_uniforms: UniformBuffer,
    draw_uniforms: UniformBuffer,
    targets: Option<RenderTargets>,
    pub(super) finished_view: Option<View>,
}

impl Inset {
    fn new(device: &wgpu::Device, pipelines: &Pipelines) -> Self {
        let uniforms = |layout, count, size: usize| UniformBuffer::new(device, layout, count, size as u64);
        Self {
            frame_uniforms: uniforms(&pipelines.frame_layout, 1, size_of::<FrameUniforms>()),
            draw_uniforms: uniforms(&pipelines.draw_layout, 64, size_of::<DrawUniforms>()),
            targets: None,
            finished_view: None,
        }
    }
}

impl Renderer {
    /// Draws the second image, if anything changed. As [`Self::prepare`].
    pub fn prepare_inset(&mut self, encoder: &mut wgpu::CommandEncoder, view: &View) {
        let inset = self.inset.take().unwrap_or_else(|| Inset::new(&self.device, &self.pipelines));
        let (inset, statistics) = (self.swap(inset), self.statistics);
        self.prepare(encoder, view);
        self.statistics = statistics;
        let inset = self.swap(inset);
        self.inset = Some(inset);
    }

    /// Copies the second image into the viewport of the caller's pass. Draws nothing before the first [`Self::prepare_inset`].
    pub fn paint_inset(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(targets) = self.inset.as_ref().and_then(|inset| inset.targets.as_ref()) {
            self.present(targets, pass);
        }
    }

    /// Draws into other buffers and textures from now on; returns those before.
    fn swap(&mut self, with: Inset) -> Inset {
        Inset {
            frame_uniforms: std::mem::replace(&mut self.frame_uniforms, with.frame_uniforms),
            draw_uniforms: std::mem::replace(&mut self.draw_uniforms, with.draw_uniforms),
            targets: std::mem::replace(&mut self.targets, with.targets),
            finished_view: std::mem::replace(&mut self.finished_view, with.finished_view),
        }
    }
}
