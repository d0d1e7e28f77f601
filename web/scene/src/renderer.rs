//! The renderer: it holds the content of the scene. `renderer/frame.rs` draws a frame of it.

mod frame;
mod inset;

use crate::level_of_detail::{LevelOfDetailConfig, SelectedTile, TileCandidate, select_tiles};
use crate::overlay::{Marker, Overlay, OverlayConfig, Polyline};
use crate::overlay_instances::{LineInstance, MarkerInstance};
use crate::picking::{
    Hit, PickCone, PickOptions, PickTarget, nearest_loop, nearest_point, nearest_target, resolve_pick,
};
use crate::pipelines::{OverlayPipelines, Pipelines};
use crate::point_columns::{ColumnsConfig, PointColumns};
use crate::pose_graph::{LoopEdge, PoseNode};
use crate::projection::CameraProjection;
use crate::render_targets::{RenderTargets, attachment};
use crate::robot::{self, RobotState};
use crate::tiles::{AnchorId, PointBlock, TileId, TilePoints, WHOLE_MAP};
use crate::uniforms::{DRAW_STRIDE, DrawUniforms, FrameUniforms, PointSizeConfig, unit_range};
use crate::vertex_buffer::buffer_with;
use crate::view::{ColourBy, Palette, View};
use glam::{DAffine3, DQuat, DVec2, DVec3, Vec4};
use std::collections::BTreeMap;

/// Parameters of the renderer's algorithms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct RendererConfig {
    /// How tiles are chosen.
    level_of_detail: LevelOfDetailConfig,
    /// How large points are drawn.
    point_size: PointSizeConfig,
    /// How lines, markers and the robot are drawn.
    overlay: OverlayConfig,
    /// Whether the fill passes read 16 pixels to each side at every pixel, whatever points are near. Tests compare with it.
    reads_all_around: bool,
}

/// Draws the scene and finds the thing under a pixel.
pub struct Renderer {
    config: RendererConfig,
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipelines: Pipelines,
    /// Compiled for the first image that has an overlay.
    overlay_pipelines: Option<OverlayPipelines>,
    /// Whether the next image may be drawn without the overlay.
    overlay_deferred: bool,
    frame_uniforms: UniformBuffer,
    draw_uniforms: UniformBuffer,
    targets: Option<RenderTargets>,
    tiles: BTreeMap<TileId, Tile>,
    anchors: BTreeMap<AnchorId, DAffine3>,
    live: Option<(Tile, DAffine3)>,
    /// Scans that are compared, the older first.
    compared: [Option<(Tile, DAffine3)>; 2],
    /// Objects that changed between two visits: of the earlier one, and of the later one.
    changed: [Option<Tile>; 2],
    robot_mesh: wgpu::Buffer,
    robot_mesh_vertices: u32,
    overlay: Overlay,
    lines: InstanceBuffer,
    markers: InstanceBuffer,
    /// Colours with which the instances were built; none when they are out of date.
    overlay_palette: Option<Palette>,
    /// The view of the finished image; none when the scene has changed since.
    finished_view: Option<View>,
    statistics: FrameStatistics,
    /// A second image of the same scene; none before one was drawn.
    inset: Option<inset::Inset>,
}

/// Counts of the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameStatistics {
    /// Points drawn, the current scan included.
    pub points: u32,
    /// Tiles drawn.
    pub tiles: u32,
    /// Points of all tiles, drawn or not.
    pub points_held: u64,
}

struct Tile {
    points: TilePoints,
    buffer: wgpu::Buffer,
}

/// A uniform buffer with its bind group.
struct UniformBuffer {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// A vertex buffer of instances that is rewritten as a whole.
struct InstanceBuffer {
    buffer: wgpu::Buffer,
    count: u32,
}

/// A draw call of the first pass.
struct DrawCall<'a> {
    uniforms: DrawUniforms,
    vertices: &'a wgpu::Buffer,
    count: u32,
    is_mesh: bool,
    /// Largest radius of its points, px.
    max_radius_px: f32,
}

impl Renderer {
    /// - `device`, `queue`: handles, kept until the renderer is dropped. After a lost device, make a new renderer.
    /// - `target_format`: format of the pass that [`Self::paint`] draws into. Colours are gamma-encoded; they are decoded for an sRGB
    ///   format, which encodes them again.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, target_format: wgpu::TextureFormat) -> Self {
        let pipelines = Pipelines::new(device, target_format);
        let mesh = robot::mesh();
        let robot_mesh = buffer_with(device, queue, "scene: robot", bytemuck::cast_slice(&mesh));
        Self {
            config: RendererConfig::default(),
            frame_uniforms: UniformBuffer::new(
                device,
                &pipelines.frame_layout,
                1,
                size_of::<FrameUniforms>() as u64,
            ),
            draw_uniforms: UniformBuffer::new(
                device,
                &pipelines.draw_layout,
                64,
                size_of::<DrawUniforms>() as u64,
            ),
            targets: None,
            tiles: BTreeMap::new(),
            anchors: BTreeMap::from([(WHOLE_MAP, DAffine3::IDENTITY)]),
            live: None,
            compared: [None, None],
            changed: [None, None],
            robot_mesh,
            robot_mesh_vertices: mesh.len() as u32,
            overlay: Overlay::default(),
            lines: InstanceBuffer::new::<LineInstance>(device, queue, &[]),
            markers: InstanceBuffer::new::<MarkerInstance>(device, queue, &[]),
            overlay_palette: None,
            finished_view: None,
            statistics: FrameStatistics::default(),
            inset: None,
            overlay_pipelines: None,
            overlay_deferred: false,
            pipelines,
            device: device.clone(),
            queue: queue.clone(),
        }
    }

    /// Draws the next image without robot, grid, lines and markers, because compiling their pipelines takes as long as those of the points.
    /// The image after it has all of them; [`Self::needs_redraw`] asks for it.
    pub fn defer_overlay(&mut self) {
        self.overlay_deferred = true;
    }

    /// Uploads a tile's points to the GPU and replaces those it had. They are drawn once the anchor has a pose. A block without
    /// points or with an invalid lattice only removes the old points.
    pub fn upload_tile(&mut self, id: TileId, anchor: AnchorId, block: &PointBlock) {
        self.remove_tile(id);
        if let Some(tile) = self.make_tile(anchor, block) {
            self.tiles.insert(id, tile);
            self.invalidate();
        }
    }

    /// Removes a tile, if it exists.
    pub fn remove_tile(&mut self, id: TileId) {
        if self.tiles.remove(&id).is_some() {
            self.invalidate();
        }
    }

    /// Removes all tiles and anchors.
    pub fn clear_tiles(&mut self) {
        self.tiles.clear();
        self.anchors.retain(|anchor, _| *anchor == WHOLE_MAP);
        self.invalidate();
    }

    /// Sets the pose of an anchor (m, map frame; a unit quaternion) without uploading its points again. A pose that is not finite is
    /// ignored.
    pub fn set_anchor(&mut self, anchor: AnchorId, position: DVec3, orientation: DQuat) {
        let pose = DAffine3::from_rotation_translation(orientation, position);
        if pose.is_finite() && self.anchors.insert(anchor, pose) != Some(pose) {
            self.invalidate();
        }
    }

    /// Shows a scan at the pose of its frame in the map, or none.
    pub fn set_live_scan(&mut self, scan: Option<(&PointBlock, DVec3, DQuat)>) {
        self.live = scan.and_then(|scan| self.place_scan(scan));
        self.invalidate();
    }

    /// Shows two scans in the colours of [`Palette::pair`], each at the pose of its frame in the map, or one or none of them.
    pub fn set_compared(&mut self, scans: [Option<(&PointBlock, DVec3, DQuat)>; 2]) {
        self.compared = scans.map(|scan| scan.and_then(|scan| self.place_scan(scan)));
        self.invalidate();
    }

    /// Shows the objects that were there on the earlier visit only, and on the later one only, map frame, in the colours of [`Palette::changed`].
    pub fn set_changed(&mut self, objects: [Option<&PointBlock>; 2]) {
        self.changed = objects.map(|block| block.and_then(|block| self.make_tile(WHOLE_MAP, block)));
        self.invalidate();
    }

    fn place_scan(
        &self,
        (block, position, orientation): (&PointBlock, DVec3, DQuat),
    ) -> Option<(Tile, DAffine3)> {
        let pose = DAffine3::from_rotation_translation(orientation, position);
        let tile = self.make_tile(WHOLE_MAP, block).filter(|_| pose.is_finite())?;
        Some((tile, pose))
    }

    /// Sets the path that the robot has walked, m, map frame.
    pub fn set_trajectory(&mut self, points: &[DVec3]) {
        self.change_overlay(|overlay| points.clone_into(&mut overlay.trajectory));
    }

    /// Sets the pose graph: its nodes, and the two ends of each edge (m, map frame).
    pub fn set_graph(&mut self, nodes: &[PoseNode], edges: &[[DVec3; 2]]) {
        self.change_overlay(|overlay| {
            nodes.clone_into(&mut overlay.nodes);
            edges.clone_into(&mut overlay.edges);
        });
    }

    /// Sets the loops of the graph, apart from its other edges.
    pub fn set_loops(&mut self, loops: &[LoopEdge]) {
        let finite = |edge: &&LoopEdge| edge.ends.iter().all(|end| end.is_finite());
        self.change_overlay(|overlay| overlay.loops = loops.iter().filter(finite).copied().collect());
    }

    /// Highlights two nodes (the older first) and the loop between them, or none.
    pub fn select_pair(&mut self, pair: Option<[u32; 2]>) {
        if self.overlay.pair != pair {
            self.change_overlay(|overlay| overlay.pair = pair);
        }
    }

    /// Selects a node, or none.
    pub fn select_node(&mut self, number: Option<u32>) {
        if self.overlay.selected_node != number {
            self.change_overlay(|overlay| overlay.selected_node = number);
        }
    }

    /// Shows the robot, or none.
    pub fn set_robot(&mut self, robot: Option<RobotState>) {
        if self.overlay.robot != robot {
            self.change_overlay(|overlay| overlay.robot = robot);
        }
    }

    /// Sets the robot's goal and the path to it (m, map frame); none and empty without a goal.
    pub fn set_goal(&mut self, goal: Option<DVec3>, path: &[DVec3]) {
        if self.overlay.goal != goal || self.overlay.path != path {
            self.change_overlay(|overlay| {
                overlay.goal = goal;
                path.clone_into(&mut overlay.path);
            });
        }
    }

    /// Replaces the caller's additional lines and markers.
    pub fn set_annotations(&mut self, lines: Vec<Polyline>, markers: Vec<Marker>) {
        if self.overlay.lines != lines || self.overlay.markers != markers {
            self.change_overlay(|overlay| {
                overlay.lines = lines;
                overlay.markers = markers;
            });
        }
    }

    /// Counts of the last frame.
    pub fn statistics(&self) -> FrameStatistics {
        self.statistics
    }

    /// Whether the scene itself changed since it was last drawn.
    pub fn changed(&self) -> bool {
        self.finished_view.is_none()
    }

    /// Whether [`Self::prepare`] would draw anything new for this view.
    pub fn needs_redraw(&self, view: &View) -> bool {
        self.finished_view != Some(*view)
    }

    /// Draws the scene into its own texture, if anything changed. Call it before the pass of [`Self::paint`] begins.
    pub fn prepare(&mut self, encoder: &mut wgpu::CommandEncoder, view: &View) {
        if !self.needs_redraw(view) {
            return;
        }
        let requested = *view;
        let view = view.as_drawn(self.device.limits().max_texture_dimension_2d);
        let size = view.viewport_px;
        if self.targets.as_ref().is_none_or(|targets| targets.size != size) {
            self.targets = Some(RenderTargets::new(&self.device, size, &self.pipelines.target_layouts));
        }
        self.rebuild_overlay(&view.palette);
        let projection = CameraProjection::new(view.camera, size).magnified(view.options.magnification);
        let points_only = std::mem::take(&mut self.overlay_deferred) && self.overlay_pipelines.is_none();
        if !points_only && self.overlay_pipelines.is_none() {
            self.overlay_pipelines = Some(OverlayPipelines::new(&self.device, &self.pipelines));
        }
        self.draw(encoder, &view, &projection);
        self.finished_view = (!points_only).then_some(requested);
    }

    /// Copies the image into the viewport of the caller's pass. Draws nothing before the first [`Self::prepare`].
    pub fn paint(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(targets) = &self.targets {
            self.present(targets, pass);
        }
    }

    fn present(&self, targets: &RenderTargets, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipelines.present);
        pass.set_bind_group(0, &targets.finished_group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Finds the thing under a pixel (from the top left corner of the viewport, y down) of a view.
    pub fn pick(&self, view: &View, pixel: DVec2, options: &PickOptions) -> Option<Hit> {
        let projection = CameraProjection::new(view.camera, view.viewport_px);
        let target = nearest_target(&self.pick_targets(), &projection, pixel, options.target_px);
        let line = nearest_loop(&self.overlay.loops, &projection, pixel, options.line_px);
        resolve_pick(target, line, options.marker_px)
            .or_else(|| self.pick_point(view, &projection, pixel, options.point_px).map(Hit::Point))
    }

    /// The nearest drawn point under a pixel (m, map frame). Robot, nodes and markers do not hide it.
    pub fn pick_point(
        &self,
        view: &View,
        projection: &CameraProjection,
        pixel: DVec2,
        point_radius_px: f64,
    ) -> Option<DVec3> {
        let height_range = [view.options.floor, view.options.ceiling].map(f64::from);
        let cone = PickCone {
            ray: projection.ray(pixel),
            slope: point_radius_px / projection.focal_px(),
            height_range,
        };
        let tiles = self.tiles.values().filter(|_| view.options.map);
        let tiles = tiles.filter_map(|t| Some((&t.points, self.anchors.get(&t.points.anchor)?)));
        let compared = self.compared.iter().flatten().map(|(tile, pose)| (&tile.points, pose));
        let live =
            self.live.iter().filter(|_| view.options.live_scan).map(|(tile, pose)| (&tile.points, pose));
        let mut best: Option<(f64, DVec3)> = None;
        for (points, map_from_anchor) in tiles.chain(live).chain(compared) {
            let limit = best.map_or(f64::INFINITY, |(along, _)| along);
            best = nearest_point(points, map_from_anchor, &cone, limit).or(best);
        }
        best.map(|(_, position)| position)
    }

    /// Lets the fill passes read 16 pixels to each side at every pixel.
    #[cfg(test)]
    pub(crate) fn read_all_around(&mut self) {
        self.config.reads_all_around = true;
    }

    /// The points of all tiles between two corners, m, map frame, in columns. Linear in the points of the tiles that reach there.
    pub fn columns(&self, config: ColumnsConfig, corners: [DVec2; 2]) -> PointColumns {
        let [min, max] = corners;
        let overlaps = |centre: DVec3, reach: f64| {
            let (low, high) = (centre.truncate() - reach, centre.truncate() + reach);
            low.cmple(max).all() && high.cmpge(min).all()
        };
        PointColumns::new(config, corners, |visit| {
            for tile in self.tiles.values() {
                let points = &tile.points;
                let Some(pose) = self.anchors.get(&points.anchor) else { continue };
                if overlaps(pose.transform_point3(points.centre), points.radius) {
                    points.visit_blocks(pose, &overlaps, visit);
                }
            }
        })
    }

    fn pick_targets(&self) -> Vec<PickTarget> {
        let overlay = &self.overlay;
        let robot = overlay.robot.iter().map(|r| PickTarget { hit: Hit::Robot, position: r.position });
        let nodes = overlay
            .nodes
            .iter()
            .map(|node| PickTarget { hit: Hit::Node(node.number), position: node.position });
        let markers = overlay.markers.iter().filter_map(|marker| {
            Some(PickTarget { hit: Hit::Marker(marker.id?), position: marker.position })
        });
        robot.chain(markers).chain(nodes).collect()
    }

    /// Marks the finished image as out of date.
    fn invalidate(&mut self) {
        self.finished_view = None;
        if let Some(inset) = &mut self.inset {
            inset.finished_view = None;
        }
    }

    fn change_overlay(&mut self, with: impl FnOnce(&mut Overlay)) {
        with(&mut self.overlay);
        self.overlay_palette = None;
        self.invalidate();
    }

    fn make_tile(&self, anchor: AnchorId, block: &PointBlock) -> Option<Tile> {
        let points = TilePoints::new(anchor, block)?;
        let buffer =
            buffer_with(&self.device, &self.queue, "scene: tile", bytemuck::cast_slice(&points.points));
        Some(Tile { points, buffer })
    }

    fn rebuild_overlay(&mut self, palette: &Palette) {
        if self.overlay_palette == Some(*palette) {
            return;
        }
        let (lines, markers) = self.overlay.build(&self.config.overlay, palette);
        self.lines = InstanceBuffer::new(&self.device, &self.queue, &lines);
        self.markers = InstanceBuffer::new(&self.device, &self.queue, &markers);
        self.overlay_palette = Some(*palette);
    }
}
