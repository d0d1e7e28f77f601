//! Passes changes of the model to the renderer of the 3D scene.

use crate::change_clouds::LatticeCloud;
use crate::change_overlay;
use crate::graph_overlay::{GraphOverlay, GraphTarget};
use crate::graph_preview::GraphPreview;
use crate::mission_overlay::MissionOverlay;
use crate::vector::vector;
use crate::zone_overlay;
use api::Quality;
use client_model::{ColourBy, LoopPair, LoopPick, MapView, Model, ScanComparison, Selection, ViewSettings};
use glam::{DQuat, DVec3};
use map_codec::PointChunk;
use panels::theme::Tokens;
use scene::{
    AnchorId, CameraPose, LoopEdge, LoopState, Marker, MarkerShape, Options, Palette, PointBlock, Polyline,
    PoseNode, Renderer, RobotState, TileId, View, WHOLE_MAP,
};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use vocab::{KeyframeId, MapId, Pose};

/// Parameters of [`SceneSync`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct SceneSyncConfig {
    /// Smallest change of height that counts as another floor, m. The base moves up and down by less while the robot walks. Chosen: two steps of stairs.
    min_ground_step_m: f64,
    /// Heights above the ground at the two ends of the colour map, m. Chosen: from below the floor to above the ceiling of most rooms.
    colour_heights_m: [f64; 2],
    /// Largest number of points in one image. A laptop without a graphics card draws them in time. It is that of [`Options`].
    point_budget: u32,
    /// Distance between points of a keyframe's scan, m: each is the mean of a cell with this edge. Source: the clouds of keyframes, of which `autonomy/stack` makes one
    /// point for each such voxel.
    keyframe_scan_spacing_m: f32,
    /// Height of a marker above its position on the ground, m, so that the ground does not hide it. Chosen: about the height of the robot's body.
    marker_height_m: f64,
    /// Standard deviation up to which a keyframe has the colour of a certain one, m. Chosen: less is not visible in a picture of the map.
    certain_deviation_m: f32,
    /// Standard deviation from which a keyframe has the colour of an uncertain one, m. From this value on the platform suggests to survey
    /// the area again.
    uncertain_deviation_m: f32,
    /// Depth under the lowest node of a floor to which points are drawn while the floor alone is shown, m. Chosen: two steps of stairs.
    below_floor_m: f64,
    /// Age of the last state from which the robot is drawn as one of unknown position, s. Chosen: three times the age up to which data counts as live, 1 s.
    max_robot_age_s: f64,
}

impl Default for SceneSyncConfig {
    fn default() -> Self {
        Self {
            min_ground_step_m: 0.4,
            colour_heights_m: [-0.2, 4.0],
            point_budget: Options::default().point_budget,
            keyframe_scan_spacing_m: 0.04,
            marker_height_m: 0.5,
            certain_deviation_m: 0.03,
            uncertain_deviation_m: 0.3,
            below_floor_m: 0.4,
            max_robot_age_s: 3.0,
        }
    }
}

/// The renderer, shared with the paint callback.
pub(crate) type SharedRenderer = Rc<RefCell<Renderer>>;

/// Keeps the renderer's content equal to the model's.
pub(crate) struct SceneSync {
    /// Also stored in egui's callback resources, for the paint callback.
    pub(crate) renderer: SharedRenderer,
    config: SceneSyncConfig,
    synced: SyncedRevisions,
    ground: f64,
    /// Scans of the keyframes that are compared.
    keyframe_scans: BTreeMap<KeyframeId, PointChunk>,
    /// The topological map as it was drawn last.
    graph_overlay: GraphOverlay,
}

/// Revisions of the renderer's content.
#[derive(Default, PartialEq)]
struct SyncedRevisions {
    map: Option<MapId>,
    graph: Option<u64>,
    graph_visible: bool,
    /// Standard deviation of each keyframe, m.
    deviations: Vec<f32>,
    loops: Option<u64>,
    compared: Option<ScanComparison>,
    compared_scans: usize,
    trajectory: Option<u64>,
}

impl SceneSync {
    /// Synchronises an empty renderer.
    pub(crate) fn new(renderer: Renderer) -> Self {
        Self {
            renderer: Rc::new(RefCell::new(renderer)),
            config: SceneSyncConfig::default(),
            synced: SyncedRevisions::default(),
            ground: 0.0,
            keyframe_scans: BTreeMap::new(),
            graph_overlay: GraphOverlay::default(),
        }
    }

    /// Height of the ground at the robot, or at the first keyframe of the saved map on show; m, map frame.
    pub(crate) fn ground(&self) -> f64 {
        self.ground
    }

    /// Adds a decoded tile.
    pub(crate) fn insert_tile(
        &self,
        hash: api::TileHash,
        chunk: &PointChunk,
        entry: &api::TileEntry,
        map: &MapView,
    ) {
        let (anchor, stamp) = match entry.anchor {
            api::TileAnchor::Map => (WHOLE_MAP, 0.0),
            api::TileAnchor::Keyframe(id) => {
                let node = map.graph.nodes.iter().find(|node| node.id == id);
                (AnchorId(u64::from(id.0)), node.map_or(0.0, |node| node.stamp.secs_f64()))
            }
        };
        self.renderer.borrow_mut().upload_tile(tile_id(hash), anchor, &block(chunk, entry.spacing_m, stamp));
    }

    /// Adds the scan of a keyframe; it is kept as long as it is compared.
    pub(crate) fn insert_keyframe_scan(&mut self, keyframe: KeyframeId, chunk: PointChunk) {
        self.keyframe_scans.insert(keyframe, chunk);
    }

    /// Removes a tile.
    pub(crate) fn remove_tile(&self, hash: api::TileHash) {
        self.renderer.borrow_mut().remove_tile(tile_id(hash));
    }

    /// Replaces the live scan. `map_from_base`: pose of the base when it was measured.
    pub(crate) fn set_live_scan(&mut self, chunk: &PointChunk, map_from_base: &Pose) {
        let (position, orientation) = glam_pose(map_from_base);
        self.renderer.borrow_mut().set_live_scan(Some((&block(chunk, 0.0, 0.0), position, orientation)));
    }

    /// Replaces the objects of the earlier and of the later visit.
    pub(crate) fn set_changed(&self, clouds: &[Option<LatticeCloud>; 2]) {
        let blocks = clouds.each_ref().map(|cloud| cloud.as_ref().map(LatticeCloud::block));
        self.renderer.borrow_mut().set_changed(blocks.each_ref().map(Option::as_ref));
    }

    /// Clears the scene when another map is displayed. This comes before the first tile of that map, because a removed tile is not sent
    /// again.
    pub(crate) fn switch_map(&mut self, model: &Model) {
        if self.synced.map != model.viewed_map() {
            let mut renderer = self.renderer.borrow_mut();
            renderer.clear_tiles();
            renderer.set_live_scan(None);
            renderer.set_compared([None, None]);
            self.synced = SyncedRevisions { map: model.viewed_map(), ..SyncedRevisions::default() };
        }
    }

    /// What the marker of a [`scene::Hit`] is for.
    pub(crate) fn marker_target(&self, marker: u64) -> Option<GraphTarget> {
        self.graph_overlay.target(marker)
    }

    /// Passes changes of the model to the renderer. `dragged_pose`: the robot's position and a point in its heading that an operator
    /// drags. `preview`: what an operator drags of the topological map.
    pub(crate) fn update(&mut self, model: &Model, dragged_pose: Option<[DVec3; 2]>, preview: &GraphPreview) {
        self.switch_map(model);
        let shown = model.displayed_map();
        let mut renderer = self.renderer.borrow_mut();
        let live = model.viewed_map().is_none();
        // The graph is visible while keyframes are picked, and hidden while points are picked on the surfaces behind it.
        let graph_visible =
            (model.view_settings().graph || model.loop_pick().is_some()) && model.alignment().is_none();
        let graph_visible = graph_visible && !panels::is_graph_covered(model);
        // The virtual viewpoints of an imported map are no path and would hide the map.
        let graph_visible = graph_visible && model.has_pose_graph();
        // Saved maps have no quality values.
        let no_quality = Quality::default();
        let quality = if live { model.quality() } else { &no_quality };
        let graph_changed = self.synced.graph != Some(shown.graph_revision)
            || self.synced.graph_visible != graph_visible
            || self.synced.deviations != quality.deviations_m;
        if graph_changed {
            set_graph(&self.config, &mut renderer, shown, graph_visible, quality);
            self.synced.graph = Some(shown.graph_revision);
            self.synced.graph_visible = graph_visible;
            quality.deviations_m.clone_into(&mut self.synced.deviations);
        }
        if graph_changed || self.synced.loops != Some(model.loops.revision()) {
            let loops = if graph_visible { loop_edges(model) } else { Vec::new() };
            renderer.set_loops(&loops);
            self.synced.loops = Some(model.loops.revision());
        }
        renderer.select_pair(highlighted_pair(model).map(|pair| [pair.from.0, pair.to.0]));
        if self.synced.trajectory != Some(model.trajectory_revision()) {
            let trajectory: Vec<DVec3> =
                if live { model.trajectory().map(vector).collect() } else { Vec::new() };
            renderer.set_trajectory(&trajectory);
            self.synced.trajectory = Some(model.trajectory_revision());
        }
        let colours = palette(model.view_settings());
        let marker_height = self.config.marker_height_m;
        let targets = model.quality().targets.iter().filter(|_| live);
        let arrow = dragged_pose.map(|ends| pose_arrow(ends, model, self.config.marker_height_m));
        let (mut lines, arrow_heads): (Vec<_>, Vec<_>) = arrow.into_iter().unzip();
        self.graph_overlay = GraphOverlay::of(model, preview);
        zone_overlay::add(&mut self.graph_overlay, model, preview);
        lines.extend(self.graph_overlay.lines.iter().cloned());
        let mission = MissionOverlay::of(model);
        lines.extend(mission.lines);
        change_overlay::add(model, &mut lines);
        let above_floor_m = model.platform.standing_height_m() - marker_height / 4.0;
        let docks = model.docks().map(|map_from_base| dock_marker(map_from_base, &colours, above_floor_m));
        let picked = model.alignment().zip(model.viewed_map());
        let picked = picked.map(|(align, viewed)| align.points_in(viewed)).unwrap_or_default();
        let picked = picked.into_iter().map(|at| picked_point_marker(vector(at), &colours));
        let markers = targets
            .map(|target| survey_marker(target, &colours, marker_height))
            .chain(docks)
            .chain(picked)
            .chain(self.graph_overlay.markers.iter().copied())
            .chain(mission.markers)
            .chain(arrow_heads);
        renderer.set_annotations(lines, markers.collect());
        renderer.set_robot(if live && model.has_pose_in_map() {
            robot_state(&self.config, model)
        } else {
            None
        });
        renderer.select_node(match model.selection() {
            Some(Selection::Keyframe(id)) => Some(id.0),
            _ => None,
        });
        match model.motion() {
            api::Motion::Walking { goal, path, .. } if live => {
                let path: Vec<DVec3> = path.iter().copied().map(vector).collect();
                renderer.set_goal(Some(vector(*goal)), &path);
            }
            api::Motion::Blocked { goal, .. }
            | api::Motion::Waiting { goal }
            | api::Motion::Relocalising { goal: Some(goal) }
                if live =>
            {
                renderer.set_goal(Some(vector(*goal)), &[]);
            }
            _ => renderer.set_goal(None, &[]),
        }
        drop(renderer);
        self.update_comparison(model);
    }

    /// Passes the scans that are compared to the renderer.
    fn update_comparison(&mut self, model: &Model) {
        let comparison = model.scan_comparison();
        self.keyframe_scans
            .retain(|id, _| comparison.is_some_and(|it| *id == it.pair.from || *id == it.pair.to));
        if self.synced.compared == comparison && self.synced.compared_scans == self.keyframe_scans.len() {
            return;
        }
        (self.synced.compared, self.synced.compared_scans) = (comparison, self.keyframe_scans.len());
        let placed = |keyframe: KeyframeId, pose: &Pose| {
            let (position, orientation) = glam_pose(pose);
            Some((
                block(self.keyframe_scans.get(&keyframe)?, self.config.keyframe_scan_spacing_m, 0.0),
                position,
                orientation,
            ))
        };
        let scans = match &comparison {
            Some(it) => [placed(it.pair.from, &it.map_from_from), placed(it.pair.to, &it.map_from_to)],
            None => [None, None],
        };
        let scans = scans.each_ref().map(|scan| scan.as_ref().map(|(block, at, turn)| (block, *at, *turn)));
        self.renderer.borrow_mut().set_compared(scans);
    }

    /// Height above which points are hidden, m, map frame; the largest number if the ceiling is shown.
    pub(crate) fn ceiling(&self, settings: &ViewSettings) -> f32 {
        if settings.cut_ceiling { self.ground as f32 + settings.ceiling_m } else { f32::MAX }
    }

    /// Updates the height of the ground. An empty map has its origin where the base stands.
    pub(crate) fn update_ground(&mut self, model: &Model) {
        let base = match (&model.robot.estimate, model.viewed_map()) {
            (Some(estimate), None) => Some(estimate.value.map_from_base.position.z),
            _ => model.displayed_map().graph.nodes.first().map(|node| node.map_from_keyframe.position.z),
        };
        let ground = base.unwrap_or(0.0) - model.platform.standing_height_m();
        if (ground - self.ground).abs() > self.config.min_ground_step_m {
            self.ground = ground;
        }
    }

    /// The view of a frame.
    pub(crate) fn view(
        &self,
        model: &Model,
        camera: CameraPose,
        viewport_px: [u32; 2],
        pixels_per_point: f32,
    ) -> View {
        let settings = model.view_settings();
        // Where one floor alone is shown, its points are.
        let of_floor = model.site.shown_heights_m().filter(|_| model.is_site_on_screen());
        let below_floor_m = self.config.below_floor_m;
        let standing_height_m = model.platform.standing_height_m();
        let stamps = &model.displayed_map().graph.nodes;
        let age_range = match (stamps.first(), stamps.last()) {
            (Some(first), Some(last)) => [first.stamp.secs_f64(), last.stamp.secs_f64()],
            _ => [0.0, 1.0],
        };
        View {
            camera,
            viewport_px,
            pixels_per_point,
            options: Options {
                colour_by: colour_by(settings.colour),
                colour_map: colour_map(settings),
                height_range: self.config.colour_heights_m.map(|height| (self.ground + height) as f32),
                age_range,
                floor: of_floor.map_or(f32::MIN, |[low, _]| (low - standing_height_m - below_floor_m) as f32),
                ceiling: of_floor.map_or_else(
                    || self.ceiling(settings),
                    |[_, high]| (high - standing_height_m) as f32 + settings.ceiling_m,
                ),
                point_size: settings.point_size,
                point_budget: self.config.point_budget,
                // Only the two scans that are compared are drawn, without the map.
                map: self.synced.compared_scans < 2,
                live_scan: model.viewed_map().is_none()
                    && model.has_pose_in_map()
                    && self.synced.compared_scans < 2,
                wipe: model.changes_view.shown().wipe(),
                ..Options::default()
            },
            palette: palette(settings),
        }
    }
}

/// The marker of a survey target.
fn survey_marker(place: &api::SurveyTarget, palette: &Palette, height: f64) -> Marker {
    Marker {
        id: None,
        position: vector(place.at) + DVec3::Z * height,
        ahead: DVec3::ZERO,
        shape: MarkerShape::Ring,
        radius: 11.0,
        fill: palette.loop_open,
        rim: palette.loop_open,
    }
}

/// The marker of a dock, near the ground. `above_m`: height of the base of a robot on the dock over the marker.
fn dock_marker(map_from_base: &Pose, palette: &Palette, above_m: f64) -> Marker {
    Marker {
        id: None,
        position: vector(map_from_base.position) - DVec3::Z * above_m,
        ahead: DVec3::ZERO,
        shape: MarkerShape::Square,
        radius: 9.0,
        fill: palette.accent,
        rim: palette.node,
    }
}

/// The marker of a point that was picked in two maps.
fn picked_point_marker(position: DVec3, palette: &Palette) -> Marker {
    Marker {
        id: None,
        position,
        ahead: DVec3::ZERO,
        shape: MarkerShape::Diamond,
        radius: 9.0,
        fill: palette.loop_open,
        rim: palette.outline,
    }
}

/// Line and arrow head of the robot's pose that an operator drags.
fn pose_arrow([from, to]: [DVec3; 2], model: &Model, height: f64) -> (Polyline, Marker) {
    let accent = Tokens::of(model.view_settings().theme).accent;
    let colour = [accent.r(), accent.g(), accent.b(), 255];
    let ends = [from, to].map(|end| end + DVec3::Z * height);
    let line = Polyline { points: ends.to_vec(), colour, width: 4.0, dash: 0.0 };
    let head = Marker {
        id: None,
        position: ends[1],
        ahead: to - from,
        shape: MarkerShape::Arrow,
        radius: 14.0,
        fill: colour,
        rim: colour,
    };
    (line, head)
}

fn set_graph(
    config: &SceneSyncConfig,
    renderer: &mut Renderer,
    shown: &MapView,
    visible: bool,
    quality: &Quality,
) {
    for node in &shown.graph.nodes {
        let (position, orientation) = glam_pose(&node.map_from_keyframe);
        renderer.set_anchor(AnchorId(u64::from(node.id.0)), position, orientation);
    }
    if !visible {
        renderer.set_graph(&[], &[]);
        return;
    }
    let position_of = |id| {
        shown
            .map_from_anchor(api::TileAnchor::Keyframe(id))
            .map(|map_from_keyframe| vector(map_from_keyframe.position))
    };
    let nodes: Vec<PoseNode> = shown
        .graph
        .nodes
        .iter()
        .map(|node| PoseNode {
            number: node.id.0,
            position: vector(node.map_from_keyframe.position),
            uncertainty: quality
                .deviation_of(node.id)
                .map_or(0.0, |deviation| uncertainty(config, deviation)),
        })
        .collect();
    let edges: Vec<[DVec3; 2]> =
        shown.graph.edges.iter().filter_map(|&(a, b)| Some([position_of(a)?, position_of(b)?])).collect();
    renderer.set_graph(&nodes, &edges);
}

/// Share of the uncertain colour of a node, from its standard deviation (m), on a logarithmic scale.
fn uncertainty(config: &SceneSyncConfig, deviation: f32) -> f32 {
    let certain = config.certain_deviation_m;
    (deviation / certain).log10() / (config.uncertain_deviation_m / certain).log10()
}

/// All loops: accepted ones from the graph, others with the state of their latest decision.
fn loop_edges(model: &Model) -> Vec<LoopEdge> {
    let shown = model.displayed_map();
    let edge = |from: KeyframeId, to: KeyframeId, state| {
        let position_of = |id| Some(vector(shown.map_from_anchor(api::TileAnchor::Keyframe(id))?.position));
        Some(LoopEdge { nodes: [from.0, to.0], ends: [position_of(from)?, position_of(to)?], state })
    };
    let closed = shown.graph.loops.iter().filter_map(|&(from, to)| edge(from, to, LoopState::Closed));
    let decided = model.loops.latest().filter(|_| model.viewed_map().is_none());
    let others = decided.filter_map(|decision| {
        let state = match decision.verdict {
            api::LoopVerdict::Accepted => return None,
            api::LoopVerdict::Held => LoopState::Open,
            api::LoopVerdict::Rejected | api::LoopVerdict::Dropped => LoopState::Rejected,
        };
        edge(decision.from, decision.to, state)
    });
    closed.chain(others).collect()
}

/// The two keyframes that are compared or picked.
fn highlighted_pair(model: &Model) -> Option<LoopPair> {
    match (model.loop_pick(), model.selection()) {
        (Some(LoopPick::Both(pair)), _) | (None, Some(Selection::Loop(pair))) => Some(pair),
        _ => None,
    }
}

fn robot_state(config: &SceneSyncConfig, model: &Model) -> Option<RobotState> {
    let estimate = model.robot.estimate.as_ref()?;
    let (position, orientation) = glam_pose(&estimate.value.map_from_base);
    let fresh = model.data_age_s().is_some_and(|age| age < config.max_robot_age_s);
    Some(RobotState {
        position,
        orientation,
        ok: fresh && !model.is_stopped(),
        selected: model.selection() == Some(Selection::Robot),
        accuracy: client_model::position_sigma_m(&estimate.value),
        standing_height_m: model.platform.standing_height_m(),
    })
}

/// The first eight bytes of the hash. Hashes are random, so these differ for all tiles of a map.
fn tile_id(hash: api::TileHash) -> TileId {
    let [a, b, c, d, e, f, g, h, ..] = hash.0;
    TileId(u64::from_le_bytes([a, b, c, d, e, f, g, h]))
}

fn block(chunk: &PointChunk, spacing: f32, stamp: f64) -> PointBlock<'_> {
    let points = bytemuck::cast_slice(&chunk.points);
    PointBlock { origin: chunk.origin, step: chunk.step, spacing, stamp, points }
}

fn glam_pose(pose: &Pose) -> (DVec3, DQuat) {
    let q = pose.orientation;
    (vector(pose.position), DQuat::from_xyzw(q.x, q.y, q.z, q.w))
}

fn colour_by(colour: ColourBy) -> scene::ColourBy {
    match colour {
        ColourBy::Height => scene::ColourBy::Height,
        ColourBy::Intensity => scene::ColourBy::Intensity,
        ColourBy::Age => scene::ColourBy::Age,
        ColourBy::Plain => scene::ColourBy::Plain,
    }
}

fn colour_map(settings: &ViewSettings) -> scene::ColourMap {
    if Tokens::of(settings.theme).dark { scene::ColourMap::Muted } else { scene::ColourMap::MutedLight }
}

/// The scene's colours, from the theme's table of tokens.
fn palette(settings: &ViewSettings) -> Palette {
    let tokens = Tokens::of(settings.theme);
    let solid = |colour: egui::Color32| [colour.r(), colour.g(), colour.b(), 255];
    let with = |colour: egui::Color32, opacity: u8| [colour.r(), colour.g(), colour.b(), opacity];
    let lifted = panels::theme::mix(tokens.ground, tokens.raised, 0.7);
    Palette {
        ground_top: solid(if tokens.dark { tokens.ground } else { lifted }),
        ground_bottom: solid(if tokens.dark { lifted } else { tokens.ground }),
        plain: solid(tokens.dim),
        live: with(tokens.accent, 90),
        grid: with(tokens.dim, 60),
        node: solid(if tokens.dark { tokens.text } else { tokens.card }),
        outline: solid(if tokens.dark { tokens.ground } else { tokens.text }),
        uncertain: solid(tokens.warn),
        edge: with(panels::theme::mix(tokens.accent, tokens.text, 0.35), 170),
        loop_closed: solid(tokens.closed),
        loop_open: solid(tokens.warn),
        loop_rejected: with(tokens.dim, if tokens.dark { 130 } else { 190 }),
        pair: [solid(tokens.older), solid(tokens.newer)],
        changed: change_overlay::COLOURS,
        trajectory: with(panels::theme::mix(tokens.robot, tokens.text, 0.2), 150),
        accent: solid(tokens.accent),
        robot: solid(tokens.robot),
        bad: solid(tokens.bad),
    }
}
