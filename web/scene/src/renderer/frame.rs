//! One frame: what is drawn, in which passes.

use super::*;

impl Renderer {
    /// All passes that end in the finished picture.
    pub(super) fn draw(&mut self, encoder: &mut wgpu::CommandEncoder, view: &View, eye: &Eye) {
        let candidates = if view.options.map { self.candidates() } else { Vec::new() };
        let chosen = choose(&candidates, eye, view.options.point_budget);
        let items = self.items(&chosen, view, eye);
        let points = items.iter().filter(|item| !item.solid).map(|item| item.count).sum();
        let radius_max = items.iter().map(|item| item.radius).fold(RADIUS_MIN_PX, f32::max);
        let globals = Globals::new(view, eye, radius_max);
        self.queue.write_buffer(&self.globals.buffer, 0, bytemuck::bytes_of(&globals));
        let points_held = self.tiles.values().map(|tile| tile.cloud.points.len() as u64).sum();
        let pieces: Vec<Piece> = items.iter().map(|item| item.piece).collect();
        let grown =
            self.pieces.write_pieces(&self.device, &self.queue, &self.pipelines.piece_layout, &pieces);
        let pieces = grown.as_ref().unwrap_or(&self.pieces);
        if let Some(targets) = &self.targets {
            self.draw_surfaces(encoder, targets, pieces, &items);
            self.fill(encoder, targets);
            self.finish(encoder, targets, view.options.grid);
        }
        if let Some(grown) = grown {
            self.pieces = grown;
        }
        self.drawn = Drawn { points, tiles: chosen.len() as u32, points_held };
    }

    /// Tiles whose anchor has a pose.
    fn candidates(&self) -> Vec<Candidate> {
        let placed = self.tiles.iter().filter_map(|(id, tile)| {
            let map_from_anchor = self.anchors.get(&tile.cloud.anchor)?;
            Some(Candidate {
                tile: *id,
                anchor: tile.cloud.anchor,
                centre: map_from_anchor.transform_point3(tile.cloud.centre),
                radius: tile.cloud.radius,
                spacing: tile.cloud.spacing,
                points: tile.cloud.points.len() as u32,
            })
        });
        placed.collect()
    }

    /// Everything of the first pass.
    fn items(&self, chosen: &[Chosen], view: &View, eye: &Eye) -> Vec<Item<'_>> {
        let tiles = chosen.iter().filter_map(|chosen| {
            let tile = self.tiles.get(&chosen.tile)?;
            Some(tile.item(self.anchors.get(&tile.cloud.anchor)?, chosen.spacing, Vec4::ZERO, view, eye))
        });
        let live = self.live.iter().filter(|_| view.options.live_scan).map(|(tile, map_from_base)| {
            // A scan's rings are far apart; its points are drawn a little larger than a dot, not as a surface.
            tile.item(map_from_base, LIVE_SPACING, unit_range(view.palette.live), view, eye)
        });
        let compared = self.compared.iter().zip(view.palette.pair).filter_map(|(compared, colour)| {
            let (tile, map_from_scan) = compared.as_ref()?;
            Some(tile.item(map_from_scan, LIVE_SPACING, unit_range(colour), view, eye))
        });
        let robot =
            self.overlay.robot.filter(|robot| self.figures.is_some() && robot.is_finite()).map(|robot| {
                let colour = if robot.ok { view.palette.robot } else { view.palette.bad };
                let relative =
                    DAffine3::from_rotation_translation(robot.orientation, robot.position - eye.position());
                Item {
                    piece: Piece {
                        relative_from_local: glam::Mat4::from(relative.as_affine3a()),
                        kind: Vec4::ZERO,
                        tint: unit_range(colour),
                    },
                    vertices: &self.robot_model,
                    count: self.robot_corners,
                    solid: true,
                    radius: 0.0,
                }
            });
        tiles.chain(live).chain(compared).chain(robot).collect()
    }

    /// Points as single pixels and models as triangles, into colour and packed depth.
    fn draw_surfaces(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        pieces: &Uniform,
        items: &[Item],
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
        pass.set_bind_group(0, &self.globals.group, &[]);
        for (offset, item) in (0..).step_by(PIECE_STRIDE as usize).zip(items) {
            let solids = self.figures.as_ref().map(|figures| &figures.solids).filter(|_| item.solid);
            pass.set_pipeline(solids.unwrap_or(&self.pipelines.points));
            pass.set_bind_group(1, &pieces.group, &[offset]);
            pass.set_vertex_buffer(0, item.vertices.slice(..));
            pass.draw(0..item.count, 0..1);
        }
    }

    /// Grows the points along rows, then along columns; the result is back in the first picture.
    fn fill(&self, encoder: &mut wgpu::CommandEncoder, targets: &Targets) {
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
            pass.set_bind_group(0, &self.globals.group, &[]);
            pass.set_bind_group(1, &from.group, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// Background and shading, then grid, lines and markers on top.
    fn finish(&self, encoder: &mut wgpu::CommandEncoder, targets: &Targets, grid: bool) {
        let clear = wgpu::LoadOp::Clear(wgpu::Color::BLACK);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene: finish"),
            color_attachments: &[Some(attachment(&targets.finished, clear))],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.globals.group, &[]);
        pass.set_bind_group(1, &targets.scene.group, &[]);
        pass.set_pipeline(&self.pipelines.shade);
        pass.draw(0..3, 0..1);
        let Some(Figures { grid: grid_pipeline, lines, marks, .. }) = &self.figures else { return };
        if grid {
            pass.set_pipeline(grid_pipeline);
            pass.draw(0..6, 0..1);
        }
        for (instances, pipeline) in [(&self.segments, lines), (&self.marks, marks)] {
            if instances.count > 0 {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, instances.buffer.slice(..));
                pass.draw(0..6, 0..instances.count);
            }
        }
    }
}

/// Size of the points of a scan, metres.
const LIVE_SPACING: f32 = 0.035;

impl Tile {
    fn item(&self, map_from_anchor: &DAffine3, spacing: f32, tint: Vec4, view: &View, eye: &Eye) -> Item<'_> {
        let [oldest, newest] = view.options.age_range;
        let age = match view.options.colour_by {
            ColourBy::Age => ((self.cloud.stamp - oldest) / (newest - oldest).max(1e-3)).clamp(0.0, 1.0),
            ColourBy::Height | ColourBy::Intensity | ColourBy::Plain => 0.0,
        };
        let centre = map_from_anchor.transform_point3(self.cloud.centre);
        let nearest = eye.depth(centre) - self.cloud.radius;
        Item {
            radius: radius_px(view, eye, spacing, nearest),
            piece: Piece {
                relative_from_local: self.cloud.relative_from_lattice(map_from_anchor, eye.position()),
                kind: Vec4::new(grown_half_spacing(spacing), age as f32, 0.0, 1.0),
                tint,
            },
            vertices: &self.buffer,
            count: self.cloud.points.len() as u32,
            solid: false,
        }
    }
}

impl Uniform {
    /// Room for `count` entries, of which a shader sees `size` bytes at a time.
    pub(super) fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, count: u64, size: u64) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("scene: uniforms"),
            size: count * size.next_multiple_of(PIECE_STRIDE),
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

    /// Writes all pieces; returns a larger buffer that holds them when this one is too small.
    fn write_pieces(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
        pieces: &[Piece],
    ) -> Option<Self> {
        let mut bytes = vec![0; pieces.len() * PIECE_STRIDE as usize];
        for (slot, piece) in bytes.chunks_exact_mut(PIECE_STRIDE as usize).zip(pieces) {
            slot[..size_of::<Piece>()].copy_from_slice(bytemuck::bytes_of(piece));
        }
        let grown = (self.buffer.size() < bytes.len() as u64).then(|| {
            let count = (pieces.len() as u64).next_power_of_two();
            Self::new(device, layout, count, size_of::<Piece>() as u64)
        });
        queue.write_buffer(&grown.as_ref().unwrap_or(self).buffer, 0, &bytes);
        grown
    }
}

impl Instances {
    pub(super) fn new<T: bytemuck::Pod>(device: &wgpu::Device, queue: &wgpu::Queue, instances: &[T]) -> Self {
        let buffer = buffer_with(device, queue, "scene: overlay", bytemuck::cast_slice(instances));
        Self { buffer, count: instances.len() as u32 }
    }
}

/// A vertex buffer that holds `bytes` (a multiple of four of them).
pub(super) fn buffer_with(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &str,
    bytes: &[u8],
) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: (bytes.len() as u64).max(4),
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&buffer, 0, bytes);
    buffer
}
