//! Draws one frame: its draw calls and its passes.

use super::*;
use crate::view::Options;

impl Renderer {
    /// Encodes all passes of the finished image.
    pub(super) fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        projection: &CameraProjection,
    ) {
        let candidates = if view.options.map { self.tile_candidates() } else { Vec::new() };
        let budget = view.options.point_budget;
        let selected = select_tiles(&self.config.level_of_detail, &candidates, projection, budget);
        let draw_calls = self.draw_calls(&selected, view, projection);
        let points = draw_calls.iter().filter(|call| !call.is_mesh).map(|call| call.count).sum();
        let sizes = &self.config.point_size;
        let max_radius_px =
            draw_calls.iter().map(|call| call.max_radius_px).fold(sizes.min_radius_px, f32::max);
        let frame_uniforms = FrameUniforms::new(sizes, view, projection, max_radius_px);
        self.queue.write_buffer(&self.frame_uniforms.buffer, 0, bytemuck::bytes_of(&frame_uniforms));
        let points_held = self.tiles.values().map(|tile| tile.points.points.len() as u64).sum();
        let uniforms: Vec<DrawUniforms> = draw_calls.iter().map(|call| call.uniforms).collect();
        let grown =
            self.draw_uniforms.write_draws(&self.device, &self.queue, &self.pipelines.draw_layout, &uniforms);
        let buffer = grown.as_ref().unwrap_or(&self.draw_uniforms);
        if let Some(targets) = &self.targets {
            self.draw_surfaces(encoder, targets, buffer, &draw_calls);
            self.find_reach(encoder, targets);
            self.fill(encoder, targets);
            self.finish(encoder, targets, &view.options);
        }
        if let Some(grown) = grown {
            self.draw_uniforms = grown;
        }
        self.statistics = FrameStatistics { points, tiles: selected.len() as u32, points_held };
    }

    /// Tiles whose anchor has a pose.
    fn tile_candidates(&self) -> Vec<TileCandidate> {
        let placed = self.tiles.iter().filter_map(|(id, tile)| {
            let map_from_anchor = self.anchors.get(&tile.points.anchor)?;
            Some(TileCandidate {
                tile: *id,
                anchor: tile.points.anchor,
                centre: map_from_anchor.transform_point3(tile.points.centre),
                radius: tile.points.radius,
                spacing: tile.points.spacing,
                points: tile.points.points.len() as u32,
            })
        });
        placed.collect()
    }

    /// The draw calls of the first pass.
    fn draw_calls(
        &self,
        selected: &[SelectedTile],
        view: &View,
        projection: &CameraProjection,
    ) -> Vec<DrawCall<'_>> {
        let sizes = &self.config.point_size;
        let scan_spacing = sizes.scan_spacing_m;
        let tiles = selected.iter().filter_map(|selected| {
            let tile = self.tiles.get(&selected.tile)?;
            Some(tile.draw_call(
                sizes,
                self.anchors.get(&tile.points.anchor)?,
                selected.spacing,
                Vec4::ZERO,
                view,
                projection,
            ))
        });
        let live = self.live.iter().filter(|_| view.options.live_scan).map(|(tile, map_from_base)| {
            tile.draw_call(
                sizes,
                map_from_base,
                scan_spacing,
                unit_range(view.palette.live),
                view,
                projection,
            )
        });
        let compared = self.compared.iter().zip(view.palette.pair).filter_map(|(compared, colour)| {
            let (tile, map_from_scan) = compared.as_ref()?;
            Some(tile.draw_call(sizes, map_from_scan, scan_spacing, unit_range(colour), view, projection))
        });
        let changed = self.changed.iter().zip(view.palette.changed).zip([-1.0, 1.0]);
        let changed = changed.filter_map(|((tile, colour), side)| {
            let (tile, tint) = (tile.as_ref()?, unit_range(colour));
            let mut call = tile.draw_call(sizes, &DAffine3::IDENTITY, scan_spacing, tint, view, projection);
            call.uniforms.kind.z =
                view.options.wipe.map_or(0.0, |share| side * (1.0 + share.clamp(0.0, 1.0)));
            Some(call)
        });
        let robot = self.overlay.robot.filter(|robot| {
            self.overlay_pipelines.is_some()
                && robot.is_finite()
                && self.config.overlay.is_mesh_visible(robot, view, projection)
        });
        let robot = robot.map(|robot| {
            let colour = if robot.ok { view.palette.robot } else { view.palette.bad };
            let relative = DAffine3::from_scale_rotation_translation(
                DVec3::splat(robot.scale()),
                robot.orientation,
                robot.position - projection.camera_position(),
            );
            DrawCall {
                uniforms: DrawUniforms {
                    relative_from_local: glam::Mat4::from(relative.as_affine3a()),
                    kind: Vec4::ZERO,
                    tint: unit_range(colour),
                },
                vertices: &self.robot_mesh,
                count: self.robot_mesh_vertices,
                is_mesh: true,
                max_radius_px: 0.0,
            }
        });
        tiles.chain(live).chain(compared).chain(changed).chain(robot).collect()
    }

    /// Draws points as single pixels and meshes as triangles, into colour and packed depth.
    fn draw_surfaces(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &RenderTargets,
        uniforms: &UniformBuffer,
        draw_calls: &[DrawCall],
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene: surfaces"),
            color_attachments: &targets.scene.attachments(true),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.z,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.frame_uniforms.group, &[]);
        for (offset, draw_call) in (0..).step_by(DRAW_STRIDE as usize).zip(draw_calls) {
            let meshes = self
                .overlay_pipelines
                .as_ref()
                .map(|overlay_pipelines| &overlay_pipelines.meshes)
                .filter(|_| draw_call.is_mesh);
            pass.set_pipeline(meshes.unwrap_or(&self.pipelines.points));
            pass.set_bind_group(1, &uniforms.group, &[offset]);
            pass.set_vertex_buffer(0, draw_call.vertices.slice(..));
            pass.draw(0..draw_call.count, 0..1);
        }
    }

    /// Finds how many pixels to each side the fill passes read in each block of pixels.
    fn find_reach(&self, encoder: &mut wgpu::CommandEncoder, targets: &RenderTargets) {
        let steps = [
            (&targets.radius_group, &targets.block, &self.pipelines.block),
            (&targets.block.group, &targets.reach, &self.pipelines.reach),
        ];
        for (from, to, pipeline) in steps {
            // The largest radius that a byte holds, 15.9 pixels.
            let clear = wgpu::LoadOp::Clear(wgpu::Color::WHITE);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("scene: reach"),
                color_attachments: &[Some(attachment(&to.view, clear))],
                ..wgpu::RenderPassDescriptor::default()
            });
            if self.config.reads_all_around {
                continue;
            }
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &self.frame_uniforms.group, &[]);
            pass.set_bind_group(1, from, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// Grows the points along rows, then along columns. The result is in the first target again.
    fn fill(&self, encoder: &mut wgpu::CommandEncoder, targets: &RenderTargets) {
        let steps = [
            (&targets.scene, &targets.rows, &self.pipelines.rows),
            (&targets.rows, &targets.scene, &self.pipelines.columns),
        ];
        for (from, to, pipeline) in steps {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("scene: fill"),
                color_attachments: &to.attachments(true),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &self.frame_uniforms.group, &[]);
            pass.set_bind_group(1, &from.group, &[]);
            pass.set_bind_group(2, &targets.reach.group, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// Draws background and shading, then grid, lines and markers on top.
    fn finish(&self, encoder: &mut wgpu::CommandEncoder, targets: &RenderTargets, options: &Options) {
        let clear = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene: finish"),
            color_attachments: &[Some(attachment(&targets.finished, clear))],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.frame_uniforms.group, &[]);
        pass.set_bind_group(1, &targets.scene.group, &[]);
        pass.set_pipeline(&self.pipelines.shade);
        pass.draw(0..3, 0..1);
        let Some(OverlayPipelines { grid: grid_pipeline, lines, markers, .. }) = &self.overlay_pipelines
        else {
            return;
        };
        if options.grid {
            pass.set_pipeline(grid_pipeline);
            pass.draw(0..6, 0..1);
        }
        for (instances, pipeline) in [(&self.lines, lines), (&self.markers, markers)] {
            if options.overlay && instances.count > 0 {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, instances.buffer.slice(..));
                pass.draw(0..6, 0..instances.count);
            }
        }
    }
}

impl Tile {
    fn draw_call(
        &self,
        sizes: &PointSizeConfig,
        map_from_anchor: &DAffine3,
        spacing: f32,
        tint: Vec4,
        view: &View,
        projection: &CameraProjection,
    ) -> DrawCall<'_> {
        let [oldest, newest] = view.options.age_range;
        let age = match view.options.colour_by {
            ColourBy::Age => ((self.points.stamp - oldest) / (newest - oldest).max(1e-3)).clamp(0.0, 1.0),
            ColourBy::Height | ColourBy::Intensity | ColourBy::Plain => 0.0,
        };
        let centre = map_from_anchor.transform_point3(self.points.centre);
        let nearest = projection.depth(centre) - self.points.radius;
        DrawCall {
            max_radius_px: sizes.radius_px(view, projection, spacing, nearest),
            uniforms: DrawUniforms {
                relative_from_local: self
                    .points
                    .relative_from_lattice(map_from_anchor, projection.camera_position()),
                kind: Vec4::new(sizes.grown_half_spacing(spacing), age as f32, 0.0, 1.0),
                tint,
            },
            vertices: &self.buffer,
            count: self.points.points.len() as u32,
            is_mesh: false,
        }
    }
}

impl UniformBuffer {
    /// A buffer for `count` entries; a shader reads `size` bytes of one entry.
    pub(super) fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, count: u64, size: u64) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("scene: uniforms"),
            size: count * size.next_multiple_of(DRAW_STRIDE),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene: uniforms"),
            layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &buffer,
                    offset: 0,
                    size: wgpu::BufferSize::new(size),
                }),
            }],
        });
        Self { buffer, group }
    }

    /// Writes the uniforms of all draw calls; returns a larger buffer with them when this one is too small.
    fn write_draws(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
        uniforms: &[DrawUniforms],
    ) -> Option<Self> {
        let mut bytes = vec![0; uniforms.len() * DRAW_STRIDE as usize];
        for (slot, uniforms) in bytes.chunks_exact_mut(DRAW_STRIDE as usize).zip(uniforms) {
            slot[..size_of::<DrawUniforms>()].copy_from_slice(bytemuck::bytes_of(uniforms));
        }
        let grown = (self.buffer.size() < bytes.len() as u64).then(|| {
            let count = (uniforms.len() as u64).next_power_of_two();
            Self::new(device, layout, count, size_of::<DrawUniforms>() as u64)
        });
        queue.write_buffer(&grown.as_ref().unwrap_or(self).buffer, 0, &bytes);
        grown
    }
}

impl InstanceBuffer {
    pub(super) fn new<T: bytemuck::Pod>(device: &wgpu::Device, queue: &wgpu::Queue, instances: &[T]) -> Self {
        let buffer = buffer_with(device, queue, "scene: overlay", bytemuck::cast_slice(instances));
        Self { buffer, count: instances.len() as u32 }
    }
}
