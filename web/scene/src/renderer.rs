//! The renderer: what it holds, how it changes, and how a frame is made of it.

mod frame;

use crate::eye::Eye;
use crate::lines::{Mark, Segment};
use crate::loops::LoopEdge;
use crate::overlay::{Marker, Node, Overlay, Polyline};
use crate::pick::{Cone, Hit, PickOptions, Sign, meant, nearest_loop, nearest_point, nearest_sign};
use crate::pipelines::{Figures, Pipelines};
use crate::robot::{self, RobotState};
use crate::select::{Candidate, Chosen, choose};
use crate::targets::{Targets, attachment};
use crate::tiles::{AnchorId, Cloud, PointBlock, TileId, WHOLE_MAP};
use crate::uniforms::{
    Globals, PIECE_STRIDE, Piece, RADIUS_MIN_PX, grown_half_spacing, radius_px, unit_range,
};
use crate::view::{ColourBy, Palette, View};
use frame::buffer_with;
use glam::{DAffine3, DQuat, DVec2, DVec3, Vec4};
use std::collections::BTreeMap;

/// Draws the scene and answers what is under a pixel.
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipelines: Pipelines,
    /// Made when they are first drawn.
    figures: Option<Figures>,
    /// Whether the next picture may do without them.
    hurried: bool,
    globals: Uniform,
    pieces: Uniform,
    targets: Option<Targets>,
    tiles: BTreeMap<TileId, Tile>,
    anchors: BTreeMap<AnchorId, DAffine3>,
    live: Option<(Tile, DAffine3)>,
    /// Scans laid over each other, the older first.
    compared: [Option<(Tile, DAffine3)>; 2],
    robot_model: wgpu::Buffer,
    robot_corners: u32,
    overlay: Overlay,
    segments: Instances,
    marks: Instances,
    /// Colours with which segments and marks were built; none when they are out of date.
    overlay_palette: Option<Palette>,
    /// The view of the finished picture; none when the scene has changed since.
    finished_view: Option<View>,
    drawn: Drawn,
}

/// What the last frame drew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    /// Points, the current scan included.
    pub points: u32,
    /// Tiles.
    pub tiles: u32,
    /// Points of all tiles, drawn or not.
    pub points_held: u64,
}

struct Tile {
    cloud: Cloud,
    buffer: wgpu::Buffer,
}

/// A uniform buffer with its bind group.
struct Uniform {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// A vertex buffer of instances that is rewritten as a whole.
struct Instances {
    buffer: wgpu::Buffer,
    count: u32,
}

/// One thing of the first pass.
struct Item<'a> {
    piece: Piece,
    vertices: &'a wgpu::Buffer,
    count: u32,
    solid: bool,
    /// Greatest radius of its points, pixels.
    radius: f32,
}

impl Renderer {
    /// - `device`, `queue`: kept (they are handles) until the renderer is dropped; after a loss make a new renderer.
    /// - `target_format`: of the pass that [`Self::paint`] draws into. Colours are gamma-encoded; a format that
    ///   encodes by itself gets them decoded.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, target_format: wgpu::TextureFormat) -> Self {
        let pipelines = Pipelines::new(device, target_format);
        let model = robot::model();
        let robot_model = buffer_with(device, queue, "scene: robot", bytemuck::cast_slice(&model));
        Self {
            globals: Uniform::new(device, &pipelines.globals_layout, 1, size_of::<Globals>() as u64),
            pieces: Uniform::new(device, &pipelines.piece_layout, 64, size_of::<Piece>() as u64),
            targets: None,
            tiles: BTreeMap::new(),
            anchors: BTreeMap::from([(WHOLE_MAP, DAffine3::IDENTITY)]),
            live: None,
            compared: [None, None],
            robot_model,
            robot_corners: model.len() as u32,
            overlay: Overlay::default(),
            segments: Instances::new::<Segment>(device, queue, &[]),
            marks: Instances::new::<Mark>(device, queue, &[]),
            overlay_palette: None,
            finished_view: None,
            drawn: Drawn::default(),
            figures: None,
            hurried: false,
            pipelines,
            device: device.clone(),
            queue: queue.clone(),
        }
    }

    /// Lets the next picture show points alone, without robot, grid, lines and markers; all of it is in the one after, which
    /// [`Self::needs_redraw`] asks for. Compiling for them takes as long as for the points.
    pub fn hurry(&mut self) {
        self.hurried = true;
    }

    /// Puts a tile's points on the GPU, in place of those it had; they are drawn once the anchor has a pose. A block
    /// without points or with a broken lattice only removes the old one.
    pub fn upload_tile(&mut self, id: TileId, anchor: AnchorId, block: &PointBlock) {
        self.remove_tile(id);
        if let Some(tile) = self.make_tile(anchor, block) {
            self.tiles.insert(id, tile);
            self.touch();
        }
    }

    /// Whether a tile is there.
    pub fn has_tile(&self, id: TileId) -> bool {
        self.tiles.contains_key(&id)
    }

    /// Removes a tile, if it is there.
    pub fn remove_tile(&mut self, id: TileId) {
        if self.tiles.remove(&id).is_some() {
            self.touch();
        }
    }

    /// Removes all tiles and anchors.
    pub fn clear_tiles(&mut self) {
        self.tiles.clear();
        self.anchors.retain(|anchor, _| *anchor == WHOLE_MAP);
        self.touch();
    }

    /// Places an anchor in the map (metres; a unit quaternion). Costs no upload, however many points hang from it. A pose
    /// that is not finite is ignored.
    pub fn set_anchor(&mut self, anchor: AnchorId, position: DVec3, orientation: DQuat) {
        let pose = DAffine3::from_rotation_translation(orientation, position);
        if pose.is_finite() && self.anchors.insert(anchor, pose) != Some(pose) {
            self.touch();
        }
    }

    /// Shows a scan from a pose of its frame in the map, or none.
    pub fn set_live_scan(&mut self, scan: Option<(&PointBlock, DVec3, DQuat)>) {
        self.live = scan.and_then(|scan| self.place_scan(scan));
        self.touch();
    }

    /// Shows two scans in the colours of [`Palette::pair`], each from a pose of its frame in the map, or one or none of them.
    pub fn set_compared(&mut self, scans: [Option<(&PointBlock, DVec3, DQuat)>; 2]) {
        self.compared = scans.map(|scan| scan.and_then(|scan| self.place_scan(scan)));
        self.touch();
    }

    fn place_scan(
        &self,
        (block, position, orientation): (&PointBlock, DVec3, DQuat),
    ) -> Option<(Tile, DAffine3)> {
        let pose = DAffine3::from_rotation_translation(orientation, position);
        let tile = self.make_tile(WHOLE_MAP, block).filter(|_| pose.is_finite())?;
        Some((tile, pose))
    }

    /// The way the robot came, metres, map frame.
    pub fn set_trajectory(&mut self, points: &[DVec3]) {
        self.change_overlay(|overlay| points.clone_into(&mut overlay.trajectory));
    }

    /// The pose graph: its nodes, and the two ends of each edge, metres, map frame.
    pub fn set_graph(&mut self, nodes: &[Node], edges: &[[DVec3; 2]]) {
        self.change_overlay(|overlay| {
            nodes.clone_into(&mut overlay.nodes);
            edges.clone_into(&mut overlay.edges);
        });
    }

    /// The loops of the graph, apart from its other edges.
    pub fn set_loops(&mut self, loops: &[LoopEdge]) {
        let finite = |edge: &&LoopEdge| edge.ends.iter().all(|end| end.is_finite());
        self.change_overlay(|overlay| overlay.loops = loops.iter().filter(finite).copied().collect());
    }

    /// Lets two nodes stand out together with the loop between them, the older first; or none.
    pub fn select_pair(&mut self, pair: Option<[u32; 2]>) {
        if self.overlay.pair != pair {
            self.change_overlay(|overlay| overlay.pair = pair);
        }
    }

    /// Marks a node as selected, or none.
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

    /// Where the robot is going and the way there (metres, map frame); none and empty when it is not.
    pub fn set_goal(&mut self, goal: Option<DVec3>, path: &[DVec3]) {
        if self.overlay.goal != goal || self.overlay.path != path {
            self.change_overlay(|overlay| {
                overlay.goal = goal;
                path.clone_into(&mut overlay.path);
            });
        }
    }

    /// Lines and markers of the caller's own, in place of the last ones.
    pub fn set_annotations(&mut self, lines: Vec<Polyline>, markers: Vec<Marker>) {
        if self.overlay.lines != lines || self.overlay.markers != markers {
            self.change_overlay(|overlay| {
                overlay.lines = lines;
                overlay.markers = markers;
            });
        }
    }

    /// The box around all tiles, metres, map frame; none without tiles.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let balls = self.tiles.values().filter_map(|tile| {
            let centre = self.anchors.get(&tile.cloud.anchor)?.transform_point3(tile.cloud.centre);
            Some((centre - tile.cloud.radius, centre + tile.cloud.radius))
        });
        balls.reduce(|(min, max), (low, high)| (min.min(low), max.max(high)))
    }

    /// What the last frame drew.
    pub fn drawn(&self) -> Drawn {
        self.drawn
    }

    /// Whether the scene itself changed since it was last drawn.
    pub fn changed(&self) -> bool {
        self.finished_view.is_none()
    }

    /// Whether [`Self::prepare`] would draw anything new for this view.
    pub fn needs_redraw(&self, view: &View) -> bool {
        self.finished_view != Some(*view)
    }

    /// Draws the scene into its own picture, if anything changed. Call before the pass that paints it begins.
    pub fn prepare(&mut self, encoder: &mut wgpu::CommandEncoder, view: &View) {
        if !self.needs_redraw(view) {
            return;
        }
        let asked = *view;
        let view = view.as_drawn(self.device.limits().max_texture_dimension_2d);
        let size = view.viewport_px;
        if self.targets.as_ref().is_none_or(|targets| targets.size != size) {
            let layouts = (&self.pipelines.picture_layout, &self.pipelines.present_layout);
            self.targets = Some(Targets::new(&self.device, size, layouts.0, layouts.1));
        }
        self.rebuild_overlay(&view.palette);
        let eye = Eye::new(view.camera, size);
        let points_alone = std::mem::take(&mut self.hurried) && self.figures.is_none();
        if !points_alone && self.figures.is_none() {
            self.figures = Some(Figures::new(&self.device, &self.pipelines));
        }
        self.draw(encoder, &view, &eye);
        self.finished_view = (!points_alone).then_some(asked);
    }

    /// Copies the picture into the viewport of the caller's pass. Draws nothing before the first [`Self::prepare`].
    pub fn paint(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(targets) = &self.targets {
            pass.set_pipeline(&self.pipelines.present);
            pass.set_bind_group(0, &targets.finished_group, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// What is under a pixel (from the top left corner of the viewport, y down) of a view.
    pub fn pick(&self, view: &View, pixel: DVec2, options: &PickOptions) -> Option<Hit> {
        let eye = Eye::new(view.camera, view.viewport_px);
        let sign = nearest_sign(&self.signs(), &eye, pixel, options.sign_px);
        let line = nearest_loop(&self.overlay.loops, &eye, pixel, options.line_px);
        meant(sign, line, options.disc_px)
            .or_else(|| self.pick_point(view, &eye, pixel, options.point_px).map(Hit::Point))
    }

    /// The nearest drawn point under a pixel, metres, map frame, passing over signs.
    pub fn pick_point(&self, view: &View, eye: &Eye, pixel: DVec2, radius_px: f64) -> Option<DVec3> {
        let heights = [view.options.floor, view.options.ceiling].map(f64::from);
        let cone = Cone { ray: eye.ray(pixel), slope: radius_px / eye.focal_px(), heights };
        let tiles = self.tiles.values().filter(|_| view.options.map);
        let tiles = tiles.filter_map(|t| Some((&t.cloud, self.anchors.get(&t.cloud.anchor)?)));
        let compared = self.compared.iter().flatten().map(|(tile, pose)| (&tile.cloud, pose));
        let live =
            self.live.iter().filter(|_| view.options.live_scan).map(|(tile, pose)| (&tile.cloud, pose));
        let mut best: Option<(f64, DVec3)> = None;
        for (cloud, map_from_anchor) in tiles.chain(live).chain(compared) {
            let limit = best.map_or(f64::INFINITY, |(along, _)| along);
            best = nearest_point(cloud, map_from_anchor, &cone, limit).or(best);
        }
        best.map(|(_, position)| position)
    }

    fn signs(&self) -> Vec<Sign> {
        let overlay = &self.overlay;
        let robot = overlay.robot.iter().map(|r| Sign { hit: Hit::Robot, position: r.position });
        let nodes =
            overlay.nodes.iter().map(|node| Sign { hit: Hit::Node(node.number), position: node.position });
        let markers = overlay
            .markers
            .iter()
            .filter_map(|marker| Some(Sign { hit: Hit::Marker(marker.id?), position: marker.position }));
        robot.chain(markers).chain(nodes).collect()
    }

    /// The finished picture is out of date.
    fn touch(&mut self) {
        self.finished_view = None;
    }

    fn change_overlay(&mut self, with: impl FnOnce(&mut Overlay)) {
        with(&mut self.overlay);
        self.overlay_palette = None;
        self.touch();
    }

    fn make_tile(&self, anchor: AnchorId, block: &PointBlock) -> Option<Tile> {
        let cloud = Cloud::new(anchor, block)?;
        let buffer =
            buffer_with(&self.device, &self.queue, "scene: tile", bytemuck::cast_slice(&cloud.points));
        Some(Tile { cloud, buffer })
    }

    fn rebuild_overlay(&mut self, palette: &Palette) {
        if self.overlay_palette == Some(*palette) {
            return;
        }
        let (segments, marks) = self.overlay.build(palette);
        self.segments = Instances::new(&self.device, &self.queue, &segments);
        self.marks = Instances::new(&self.device, &self.queue, &marks);
        self.overlay_palette = Some(*palette);
    }
}
