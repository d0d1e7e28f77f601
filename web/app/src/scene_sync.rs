//! The model on the scene: what the client knows becomes what the renderer draws, sent only when it changed.

use api::Quality;
use client_model::{ColourBy, LoopPair, LoopPick, MapView, Model, ScanComparison, Selection, ViewSettings};
use glam::{DQuat, DVec3};
use map_codec::PointChunk;
use panels::theme::Tokens;
use scene::{
    AnchorId, CameraPose, LoopEdge, LoopState, Marker, Node, Options, Palette, PointBlock, Polyline,
    Renderer, RobotState, Shape, TileId, View, WHOLE_MAP,
};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use vocab::{KeyframeId, MapId, Pose, Vec3};

/// Height of the base above the floor when the robot stands, metres: for colours and the ceiling only.
pub(crate) const BASE_HEIGHT_M: f64 = 0.5;
/// The ground under the robot counts as another one only when it differs by this much: a gait bounces.
const GROUND_STEP_M: f64 = 0.4;
/// Heights over the ground at the two ends of the colour ramp, metres.
const RAMP_M: [f64; 2] = [-0.2, 4.0];
/// Points drawn in one picture: a laptop without a graphics card of its own keeps up with these.
const POINT_BUDGET: u32 = 1_500_000;
/// Points of a keyframe's scan are averaged in cells of this edge, metres.
const CLOUD_SPACING_M: f32 = 0.04;
/// A sign of a place on the floor stands this high over it, metres, so that the floor does not cover it.
const SIGN_HEIGHT_M: f64 = 0.5;
/// Keyframes known better than the first are not coloured at all, those known worse than the second all the way: metres. The
/// second is where the robot names a place to walk again.
const SURE_M: f32 = 0.03;
const UNSURE_M: f32 = 0.3;
/// Older than this, seconds, the robot is drawn as one whose place is not known.
const ROBOT_STALE_S: f64 = 3.0;

/// The renderer, in the hands of scene and paint callback.
pub(crate) type SharedRenderer = Rc<RefCell<Renderer>>;

/// The renderer and what it was told last.
pub(crate) struct SceneSync {
    /// Shared with the paint callback, which finds it among egui's callback resources.
    pub(crate) renderer: SharedRenderer,
    told: SyncedRevisions,
    ground: f64,
    /// Scans of the keyframes that are compared.
    clouds: BTreeMap<KeyframeId, PointChunk>,
}

/// Revisions of what the renderer holds.
#[derive(Default, PartialEq)]
struct SyncedRevisions {
    map: Option<MapId>,
    graph: Option<u64>,
    graph_shown: bool,
    /// How well each keyframe is known.
    deviations: Vec<f32>,
    loops: Option<u64>,
    compared: Option<ScanComparison>,
    clouds: usize,
    track: Option<u64>,
    scan: bool,
}

impl SceneSync {
    pub(crate) fn new(renderer: Renderer) -> Self {
        Self {
            renderer: Rc::new(RefCell::new(renderer)),
            told: SyncedRevisions::default(),
            ground: -BASE_HEIGHT_M,
            clouds: BTreeMap::new(),
        }
    }

    /// Height of the ground at the robot, or at the start of the saved map on show; metres, map frame.
    pub(crate) fn ground(&self) -> f64 {
        self.ground
    }

    /// Puts a decoded tile on the scene.
    pub(crate) fn add_tile(
        &self,
        hash: api::TileHash,
        chunk: &PointChunk,
        entry: &api::TileEntry,
        map: &MapView,
    ) {
        let (anchor, stamp) = match entry.anchor {
            api::Anchor::Map => (WHOLE_MAP, 0.0),
            api::Anchor::Keyframe(id) => {
                let node = map.graph.nodes.iter().find(|node| node.id == id);
                (AnchorId(u64::from(id.0)), node.map_or(0.0, |node| node.stamp.secs_f64()))
            }
        };
        self.renderer.borrow_mut().upload_tile(tile_id(hash), anchor, &block(chunk, entry.spacing, stamp));
    }

    /// Keeps the scan of a keyframe for as long as it is compared.
    pub(crate) fn insert_keyframe_scan(&mut self, keyframe: KeyframeId, chunk: PointChunk) {
        self.clouds.insert(keyframe, chunk);
    }

    /// Takes a tile off the scene.
    pub(crate) fn remove_tile(&self, hash: api::TileHash) {
        self.renderer.borrow_mut().remove_tile(tile_id(hash));
    }

    /// Shows a scan from the pose of its base in the map.
    pub(crate) fn set_live_scan(&mut self, chunk: &PointChunk, map_from_base: &Pose) {
        let (position, orientation) = glam_pose(map_from_base);
        self.renderer.borrow_mut().set_live_scan(Some((&block(chunk, 0.0, 0.0), position, orientation)));
        self.told.scan = true;
    }

    /// Clears the scene when another map is to be seen. Before anything of that map comes: what is cleared away does not come again.
    pub(crate) fn switch_map(&mut self, model: &Model) {
        if self.told.map != model.viewed_map() {
            let mut renderer = self.renderer.borrow_mut();
            renderer.clear_tiles();
            renderer.set_live_scan(None);
            renderer.set_compared([None, None]);
            self.told = SyncedRevisions { map: model.viewed_map(), ..SyncedRevisions::default() };
        }
    }

    /// Tells the renderer what changed in the model, and from where to where a person drags who shows where the robot stands.
    pub(crate) fn follow(&mut self, model: &Model, placing: Option<[DVec3; 2]>) {
        self.switch_map(model);
        let shown = model.displayed_map();
        let mut renderer = self.renderer.borrow_mut();
        let live = model.viewed_map().is_none();
        // Who is to choose keyframes has to see them.
        // And who picks points, what they lie on.
        let graph_shown =
            (model.view_settings().graph || model.loop_pick().is_some()) && model.alignment().is_none();
        // Saved maps do not say how well they are known.
        let nothing = Quality::default();
        let quality = if live { model.quality() } else { &nothing };
        let graph_changed = self.told.graph != Some(shown.graph_revision)
            || self.told.graph_shown != graph_shown
            || self.told.deviations != quality.deviations;
        if graph_changed {
            set_graph(&mut renderer, shown, graph_shown, quality);
            self.told.graph = Some(shown.graph_revision);
            self.told.graph_shown = graph_shown;
            quality.deviations.clone_into(&mut self.told.deviations);
        }
        if graph_changed || self.told.loops != Some(model.loops.revision()) {
            let loops = if graph_shown { loop_edges(model) } else { Vec::new() };
            renderer.set_loops(&loops);
            self.told.loops = Some(model.loops.revision());
        }
        renderer.select_pair(pair_in_focus(model).map(|pair| [pair.from.0, pair.to.0]));
        if self.told.track != Some(model.trajectory_revision()) {
            let way: Vec<DVec3> = if live { model.trajectory().map(vector).collect() } else { Vec::new() };
            renderer.set_trajectory(&way);
            self.told.track = Some(model.trajectory_revision());
        }
        let colours = palette(model.view_settings());
        let places = model.quality().places.iter().filter(|_| live);
        let arrow = placing.map(|way| arrow(way, model));
        let (lines, heads): (Vec<_>, Vec<_>) = arrow.into_iter().unzip();
        let docks = model.docks().map(|map_from_base| dock(map_from_base, &colours));
        let picked = model.alignment().zip(model.viewed_map());
        let picked = picked.map(|(align, viewed)| align.picked_in(viewed)).unwrap_or_default();
        let picked = picked.into_iter().map(|at| picked_sign(vector(at), &colours));
        let signs = places.map(|place| lacking(place, &colours)).chain(docks).chain(picked).chain(heads);
        renderer.set_annotations(lines, signs.collect());
        renderer.set_robot(if live && model.has_pose_in_map() { robot(model) } else { None });
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
            | api::Motion::Looking { goal: Some(goal) }
                if live =>
            {
                renderer.set_goal(Some(vector(*goal)), &[]);
            }
            _ => renderer.set_goal(None, &[]),
        }
        drop(renderer);
        self.compare(model);
        self.find_ground(model);
    }

    /// Lays scans over each other as the model wants them.
    fn compare(&mut self, model: &Model) {
        let wanted = model.scan_comparison();
        self.clouds.retain(|id, _| wanted.is_some_and(|it| *id == it.pair.from || *id == it.pair.to));
        if self.told.compared == wanted && self.told.clouds == self.clouds.len() {
            return;
        }
        (self.told.compared, self.told.clouds) = (wanted, self.clouds.len());
        let placed = |keyframe: KeyframeId, pose: &Pose| {
            let (position, orientation) = glam_pose(pose);
            Some((block(self.clouds.get(&keyframe)?, CLOUD_SPACING_M, 0.0), position, orientation))
        };
        let scans = match &wanted {
            Some(it) => [placed(it.pair.from, &it.map_from_from), placed(it.pair.to, &it.map_from_to)],
            None => [None, None],
        };
        let scans = scans.each_ref().map(|scan| scan.as_ref().map(|(block, at, turn)| (block, *at, *turn)));
        self.renderer.borrow_mut().set_compared(scans);
    }

    fn find_ground(&mut self, model: &Model) {
        let base = match (&model.robot.estimate, model.viewed_map()) {
            (Some(estimate), None) => Some(estimate.value.map_from_base.position.z),
            _ => model.displayed_map().graph.nodes.first().map(|node| node.map_from_keyframe.position.z),
        };
        if let Some(base) = base
            && (base - BASE_HEIGHT_M - self.ground).abs() > GROUND_STEP_M
        {
            self.ground = base - BASE_HEIGHT_M;
        }
    }

    /// How the picture shall look.
    pub(crate) fn view(
        &self,
        model: &Model,
        camera: CameraPose,
        viewport_px: [u32; 2],
        pixels_per_point: f32,
    ) -> View {
        let settings = model.view_settings();
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
                height_range: RAMP_M.map(|height| (self.ground + height) as f32),
                age_range,
                ceiling: if settings.cut_ceiling {
                    self.ground as f32 + settings.ceiling_m
                } else {
                    f32::MAX
                },
                point_size: settings.point_size,
                point_budget: POINT_BUDGET,
                // The map steps back once there is something to see in its place.
                map: self.told.clouds < 2,
                live_scan: model.viewed_map().is_none() && model.has_pose_in_map() && self.told.clouds < 2,
                ..Options::default()
            },
            palette: palette(settings),
        }
    }
}

/// The sign of a place that is worth a walk.
fn lacking(place: &api::SurveyTarget, palette: &Palette) -> Marker {
    Marker {
        id: None,
        position: vector(place.at) + DVec3::Z * SIGN_HEIGHT_M,
        ahead: DVec3::ZERO,
        shape: Shape::Ring,
        radius: 11.0,
        fill: palette.loop_open,
        rim: palette.loop_open,
    }
}

/// The sign of a dock, on the floor.
fn dock(map_from_base: &Pose, palette: &Palette) -> Marker {
    Marker {
        id: None,
        position: vector(map_from_base.position) - DVec3::Z * (BASE_HEIGHT_M - SIGN_HEIGHT_M / 4.0),
        ahead: DVec3::ZERO,
        shape: Shape::Square,
        radius: 9.0,
        fill: palette.accent,
        rim: palette.node,
    }
}

/// The sign of a point that two maps share.
fn picked_sign(position: DVec3, palette: &Palette) -> Marker {
    Marker {
        id: None,
        position,
        ahead: DVec3::ZERO,
        shape: Shape::Diamond,
        radius: 9.0,
        fill: palette.loop_open,
        rim: palette.outline,
    }
}

/// Where the robot stands and looks, as a person shows it.
fn arrow([from, to]: [DVec3; 2], model: &Model) -> (Polyline, Marker) {
    let accent = Tokens::of(model.view_settings().theme).accent;
    let colour = [accent.r(), accent.g(), accent.b(), 255];
    let ends = [from, to].map(|end| end + DVec3::Z * SIGN_HEIGHT_M);
    let line = Polyline { points: ends.to_vec(), colour, width: 4.0, dash: 0.0 };
    let head = Marker {
        id: None,
        position: ends[1],
        ahead: to - from,
        shape: Shape::Arrow,
        radius: 14.0,
        fill: colour,
        rim: colour,
    };
    (line, head)
}

fn set_graph(renderer: &mut Renderer, shown: &MapView, visible: bool, quality: &Quality) {
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
            .map_from_anchor(api::Anchor::Keyframe(id))
            .map(|map_from_keyframe| vector(map_from_keyframe.position))
    };
    let nodes: Vec<Node> = shown
        .graph
        .nodes
        .iter()
        .map(|node| Node {
            number: node.id.0,
            position: vector(node.map_from_keyframe.position),
            uncertainty: quality.deviation_of(node.id).map_or(0.0, uncertainty),
        })
        .collect();
    let edges: Vec<[DVec3; 2]> =
        shown.graph.edges.iter().filter_map(|&(a, b)| Some([position_of(a)?, position_of(b)?])).collect();
    renderer.set_graph(&nodes, &edges);
}

/// How much of the uncertain colour a node takes, from one standard deviation in metres: each tenfold step looks alike.
fn uncertainty(deviation: f32) -> f32 {
    (deviation / SURE_M).log10() / (UNSURE_M / SURE_M).log10()
}

/// Every loop that is known: closed ones of the graph, others as they were decided.
fn loop_edges(model: &Model) -> Vec<LoopEdge> {
    let shown = model.displayed_map();
    let edge = |from: KeyframeId, to: KeyframeId, state| {
        let place = |id| Some(vector(shown.map_from_anchor(api::Anchor::Keyframe(id))?.position));
        Some(LoopEdge { nodes: [from.0, to.0], ends: [place(from)?, place(to)?], state })
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

/// The two keyframes that a person looks at together.
fn pair_in_focus(model: &Model) -> Option<LoopPair> {
    match (model.loop_pick(), model.selection()) {
        (Some(LoopPick::Both(pair)), _) | (None, Some(Selection::Loop(pair))) => Some(pair),
        _ => None,
    }
}

fn robot(model: &Model) -> Option<RobotState> {
    let estimate = model.robot.estimate.as_ref()?;
    let (position, orientation) = glam_pose(&estimate.value.map_from_base);
    let fresh = model.data_age_s().is_some_and(|age| age < ROBOT_STALE_S);
    Some(RobotState {
        position,
        orientation,
        ok: fresh && !model.is_stopped(),
        selected: model.selection() == Some(Selection::Robot),
        accuracy: panels::words::position_sigma_m(&estimate.value),
    })
}

/// Names are random: the first eight bytes differ for all tiles of a map.
fn tile_id(hash: api::TileHash) -> TileId {
    let [a, b, c, d, e, f, g, h, ..] = hash.0;
    TileId(u64::from_le_bytes([a, b, c, d, e, f, g, h]))
}

fn block(chunk: &PointChunk, spacing: f32, stamp: f64) -> PointBlock<'_> {
    let points = bytemuck::cast_slice(&chunk.points);
    PointBlock { origin: chunk.origin, step: chunk.step, spacing, stamp, points }
}

/// A plain vector as the renderer wants it.
pub(crate) fn vector(plain: Vec3) -> DVec3 {
    DVec3::from_array(plain.to_array())
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

/// The scene's colours, from the one table of tokens.
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
        trajectory: with(panels::theme::mix(tokens.robot, tokens.text, 0.2), 150),
        accent: solid(tokens.accent),
        robot: solid(tokens.robot),
        bad: solid(tokens.bad),
    }
}
