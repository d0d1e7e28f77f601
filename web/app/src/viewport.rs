//! The viewport: gestures move the camera, clicks select things or set a goal.

use crate::gesture_context::GestureContext;
use crate::graph_clicks::GraphClick;
use crate::graph_gestures::GraphGestures;
use crate::graph_overlay::GraphTarget;
use crate::scene_sync::{SceneSync, SharedRenderer};
use crate::vector::vector;
use crate::{browser, scene_labels, texts};
use client_model::{Bookmark, CameraMove, ClientCommand, LoopPair, Model, Selection, ViewSettings};
use eframe::egui_wgpu;
use egui::{PointerButton, Response, Sense, Ui};
use glam::{DVec2, DVec3, Vec3};
use panels::SceneLabel;
use scene::{
    Camera, CameraPose, CameraProjection, FramePacer, FreeArea, Hit, PickOptions, SceneCameraConfig, View,
};
use std::collections::BTreeMap;
use std::time::Duration;
use vocab::MapId;

/// Parameters of [`Viewport`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ViewportConfig {
    /// Height of the camera's target above the ground while it follows the robot, m: the height of the robot's body.
    followed_height_m: f64,
    /// Distance from the pointer within which robot, nodes and markers are picked, logical px: half of a touch target of 44. Chosen for fingers.
    target_reach_px: f64,
    /// Radius of drawn nodes and markers, logical px. Within it they precede the lines of loops when picking. Chosen: between a node (8 px) and one that is selected (11
    /// px).
    marker_radius_px: f64,
    /// Distance from the pointer within which the line of a loop is picked, logical px. Chosen: less than that of markers, because lines lie close to each other.
    line_reach_px: f64,
    /// Distance from the pointer within which a point of the map is picked, logical px. Chosen: gaps between points of a near surface are smaller.
    point_reach_px: f64,
    /// Zoom for each logical pixel of scrolling (natural logarithm of the factor). A notch of a wheel is about 50 px, so five notches double
    /// the scale. Chosen for that: 250 px give 0.7, the logarithm of two.
    zoom_per_px: f64,
    /// Shortest camera distance to a loop, m. Chosen: both keyframes and some metres of their scans are in the picture.
    min_loop_distance_m: f64,
    /// Camera distance to a loop, in lengths of the loop. Chosen: the loop fills less than half of the picture, so that its surroundings are seen.
    loop_distance_ratio: f64,
    /// Lowest pitch of the camera over a loop, rad: scans are compared from above. Chosen: 52 degrees; lower ones show walls instead of the plan.
    min_loop_pitch_rad: f64,
    /// Longest camera distance after moving to the robot or to a point, m. Chosen: the room around it is in the picture.
    max_robot_distance_m: f64,
    /// Shortest camera distance to the robot while the camera follows it, m: nearer, the camera would be within its body, which is 1 m long.
    min_robot_distance_m: f64,
    /// Longest distance of a goal from the camera, beyond the camera's distance to its target, m. A click farther away counts as accidental. Chosen: farther than people
    /// see where they click.
    max_goal_distance_m: f64,
    /// Share of the camera's distance that a double click leaves. Chosen: half, so that two double clicks are a quarter.
    double_click_ratio: f64,
    /// Shortest camera distance after a double click, m. Chosen: nearer, gaps between points open.
    min_double_click_distance_m: f64,
    /// Longest distance of the ground point to which zooming goes where the pointer is over no point of the map, in camera distances. Chosen: near the horizon, a zoom
    /// would move the camera far otherwise.
    max_ground_focus_ratio: f64,
}

impl Default for ViewportConfig {
    fn default() -> Self {
        Self {
            followed_height_m: 0.3,
            target_reach_px: 22.0,
            marker_radius_px: 10.0,
            line_reach_px: 7.0,
            point_reach_px: 6.0,
            zoom_per_px: 0.0028,
            min_loop_distance_m: 14.0,
            loop_distance_ratio: 2.5,
            min_loop_pitch_rad: 0.9,
            max_robot_distance_m: 25.0,
            min_robot_distance_m: 1.2,
            max_goal_distance_m: 80.0,
            double_click_ratio: 0.5,
            min_double_click_distance_m: 1.0,
            max_ground_focus_ratio: 2.0,
        }
    }
}

/// The camera and its gestures.
pub(crate) struct Viewport {
    config: ViewportConfig,
    camera: Camera,
    /// Whether the camera has been moved to the robot once.
    centred_on_robot: bool,
    /// The view that was drawn last, perhaps at a lower quality than requested.
    view: Option<View>,
    frame_pacer: FramePacer,
    /// The robot's pose that an operator drags: the pressed point of the ground and the point under the pointer, m, map frame.
    dragged_pose: Option<[DVec3; 2]>,
    /// What an operator drags of the topological map.
    graph: GraphGestures,
    /// The part of the viewport that no card covers.
    free_area: Option<FreeArea>,
    /// The displayed saved map.
    viewed: Option<MapId>,
    /// The last camera pose in each saved map that was displayed before.
    last_poses: BTreeMap<MapId, CameraPose>,
}

impl Viewport {
    /// `frame_pacer`: starts with the quality of the first images.
    pub(crate) fn new(config: ViewportConfig, frame_pacer: FramePacer) -> Self {
        Self {
            config,
            camera: Camera::new(SceneCameraConfig::default(), first_pose()),
            centred_on_robot: false,
            view: None,
            frame_pacer,
            dragged_pose: None,
            graph: GraphGestures::default(),
            free_area: None,
            viewed: None,
            last_poses: BTreeMap::new(),
        }
    }

    /// Time from a frame to the next one that only shows what the robot sends.
    pub(crate) fn stream_interval(&self) -> Duration {
        Duration::from_secs_f64(self.frame_pacer.stream_interval_s())
    }

    /// The view that was drawn last.
    pub(crate) fn view(&self) -> Option<View> {
        self.view
    }

    /// The viewpoint, for the selection of tiles to fetch.
    pub(crate) fn viewpoint(&self) -> Option<client_model::Viewpoint> {
        self.view.map(|view| viewpoint_of(view.camera, view.viewport_px))
    }

    /// The robot's position and a point in its heading that an operator drags, m, map frame.
    pub(crate) fn dragged_pose(&self) -> Option<[DVec3; 2]> {
        self.dragged_pose
    }

    /// What an operator drags of the topological map.
    pub(crate) fn graph(&self) -> &GraphGestures {
        &self.graph
    }

    /// Draws the scene and handles its gestures. Maps are fitted into `free`, the part of the window that no card covers.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        model: &Model,
        scene: &SceneSync,
        free: egui::Rect,
        out: &mut Vec<ClientCommand>,
    ) {
        let rect = ui.max_rect();
        let response = ui.interact(rect, ui.scope_id().with("scene"), Sense::click_and_drag());
        ui.ctx().accesskit_node_builder(response.id, |node| {
            node.set_role(egui::Role::Canvas);
            node.set_label(texts::SCENE);
        });
        self.free_area = Some(free_area(ui.ctx(), rect, free));
        self.switch_map(model);
        self.follow_robot(model, scene);
        if model.is_picking_pose() {
            self.drag_robot_pose(ui, &response, model, scene, out);
        } else {
            self.dragged_pose = None;
            if !self.edit_by_drag(ui, &response, model, scene, out) {
                self.gestures(ui, &response, model, scene, out);
            }
        }
        let seconds = f64::from(ui.input(|input| input.stable_dt)).min(0.1);
        if self.camera.is_flying() {
            if browser::reduced_motion() {
                self.camera.finish_flight();
            } else {
                self.camera.advance(seconds);
            }
            ui.ctx().request_repaint();
        }
        let pixels_per_point = ui.ctx().pixels_per_point();
        let viewport_px =
            [rect.width(), rect.height()].map(|side| (side * pixels_per_point).round().max(1.0) as u32);
        let requested = scene.view(model, self.camera.pose(), viewport_px, pixels_per_point);
        let view = self.paced_view(ui.ctx(), requested, scene);
        ui.painter().add(egui_wgpu::Callback::new_paint_callback(rect, ScenePaint { view }));
        self.clicks(&response, model, scene, out);
    }

    /// The view to draw for a requested one. While things move it has the quality that the machine draws in time; at rest, a higher one.
    fn paced_view(&mut self, ctx: &egui::Context, requested: View, scene: &SceneSync) -> View {
        let now = browser::now_ms() * 1e-3;
        let (view, refine_in) = self.frame_pacer.next_view(now, &requested, &scene.renderer.borrow());
        if let Some(seconds) = refine_in {
            ctx.request_repaint_after(Duration::from_secs_f64(seconds));
        }
        self.view = Some(view);
        view
    }

    /// Labels of the scene, the most important first.
    pub(crate) fn labels(&self, model: &Model) -> Vec<SceneLabel> {
        let Some(view) = self.view else { return Vec::new() };
        let projection = CameraProjection::new(view.camera, view.viewport_px);
        let project = |at: DVec3| {
            let (pixel, depth) = projection.project(at)?;
            let inside = pixel.cmpge(DVec2::ZERO).all()
                && pixel.x <= f64::from(view.viewport_px[0])
                && pixel.y <= f64::from(view.viewport_px[1]);
            let point = pixel / f64::from(view.pixels_per_point);
            inside.then_some((egui::pos2(point.x as f32, point.y as f32), depth))
        };
        scene_labels::scene_labels(model, self.graph.preview(), project)
    }

    /// Moves the camera. Returns the view settings if this changed them.
    pub(crate) fn move_camera(
        &mut self,
        to: &CameraMove,
        model: &Model,
        scene: &SceneSync,
    ) -> Option<ViewSettings> {
        let pose = self.camera.pose();
        match to {
            CameraMove::Fit => {
                // Going back to a map while points are picked in two maps restores the last view of it.
                self.switch_map(model);
                let last_pose = model.viewed_map().and_then(|map| self.last_poses.remove(&map));
                if let Some(pose) = last_pose.filter(|_| model.alignment().is_some()) {
                    self.camera.jump_to(pose);
                } else if let Some(fit) = self.pose_fitting_map(pose, model, scene) {
                    self.camera.fly_to(fit);
                }
            }
            CameraMove::Top => {
                let quarter = 0.5 * std::f64::consts::PI;
                let from_above = CameraPose { pitch: quarter, yaw: quarter, ..pose };
                let fit = self.pose_fitting_map(from_above, model, scene);
                self.camera.fly_to(fit.unwrap_or(from_above));
            }
            CameraMove::Robot => {
                if let Some(target) = robot_target(model) {
                    self.camera.fly_to(CameraPose {
                        target,
                        distance: pose.distance.min(self.config.max_robot_distance_m),
                        ..pose
                    });
                }
            }
            CameraMove::Loop(pair) => {
                if let Some([a, b]) = ends(model, *pair) {
                    let distance = (self.config.loop_distance_ratio * a.distance(b))
                        .max(self.config.min_loop_distance_m);
                    let pitch = pose.pitch.max(self.config.min_loop_pitch_rad);
                    self.camera.fly_to(CameraPose { target: a.midpoint(b), distance, pitch, ..pose });
                }
            }
            CameraMove::Point(at) => self.camera.fly_to(CameraPose {
                target: vector(*at),
                distance: pose.distance.min(self.config.max_robot_distance_m),
                ..pose
            }),
            CameraMove::Bookmark(Bookmark { camera, .. }) => self.camera.fly_to(CameraPose {
                target: DVec3::from_array(camera.target),
                distance: camera.distance,
                yaw: camera.yaw,
                pitch: camera.pitch,
            }),
            CameraMove::SaveBookmark(name) => {
                let mut settings = model.view_settings().clone();
                let camera = client_model::CameraPose {
                    target: pose.target.to_array(),
                    distance: pose.distance,
                    yaw: pose.yaw,
                    pitch: pose.pitch,
                };
                settings.bookmarks.retain(|bookmark| bookmark.name != *name);
                settings.bookmarks.push(Bookmark { name: name.clone(), camera });
                return Some(settings);
            }
        }
        None
    }

    /// The pose with the direction of another that shows the whole displayed map in the free area, up to the height above which points are hidden. All tiles count,
    /// loaded or not.
    fn pose_fitting_map(
        &self,
        direction: CameraPose,
        model: &Model,
        scene: &SceneSync,
    ) -> Option<CameraPose> {
        let view = self.view?;
        let bounds = model.displayed_map().robust_bounds()?;
        let [min, max] = [bounds.min, bounds.max].map(|corner| Vec3::from_array(corner).as_dvec3());
        let ceiling = f64::from(scene.ceiling(model.view_settings()));
        let max = max.with_z(max.z.min(ceiling).max(min.z));
        Some(Camera::new(SceneCameraConfig::default(), direction).pose_fitting(
            min,
            max,
            view.viewport_px,
            self.free_area.unwrap_or_else(|| FreeArea::whole(view.viewport_px)),
        ))
    }

    /// Stores the camera pose of the map that was displayed until now.
    fn switch_map(&mut self, model: &Model) {
        let viewed = model.viewed_map();
        if self.viewed != viewed {
            let before = std::mem::replace(&mut self.viewed, viewed);
            if model.alignment().is_none() {
                self.last_poses.clear();
            }
            self.last_poses.extend(before.map(|before| (before, self.camera.pose())));
        }
    }

    fn follow_robot(&mut self, model: &Model, scene: &SceneSync) {
        if model.viewed_map().is_some() {
            return;
        }
        let Some(target) = robot_target(model) else { return };
        if !self.centred_on_robot {
            self.centred_on_robot = true;
            self.camera.jump_to(CameraPose { target, ..self.camera.pose() });
        } else if model.view_settings().follow && !self.camera.is_flying() {
            let height = scene.ground() + self.config.followed_height_m;
            self.camera.jump_to(CameraPose { target: target.with_z(height), ..self.camera.pose() });
        }
    }

    fn gestures(
        &mut self,
        ui: &Ui,
        response: &Response,
        model: &Model,
        scene: &SceneSync,
        out: &mut Vec<ClientCommand>,
    ) {
        let height = f64::from(response.rect.height());
        let mut pan = DVec2::ZERO;
        if let Some(touch) = ui
            .input(egui::InputState::multi_touch)
            .filter(|_| response.contains_pointer() || response.dragged())
        {
            pan = DVec2::new(f64::from(touch.translation_delta.x), f64::from(touch.translation_delta.y));
            self.zoom(f64::from(touch.zoom_delta), touch.center_pos, response, model, scene);
        } else if response.dragged() {
            let drag = response.drag_delta();
            let drag = DVec2::new(f64::from(drag.x), f64::from(drag.y));
            let shift = ui.input(|input| input.modifiers.shift);
            if response.dragged_by(PointerButton::Primary) && !shift {
                self.camera.orbit(drag);
            } else {
                pan = drag;
            }
        }
        if pan != DVec2::ZERO {
            self.camera.pan(pan, height);
            stop_following(model, out);
        }
        // A label in front of the scene does not take the wheel, a card does.
        let over_scene = |at: &egui::Pos2| ui.ctx().layer_id_at(*at) == Some(response.layer_id);
        if response.contains_pointer()
            && let Some(at) = ui.input(|input| input.pointer.hover_pos()).filter(over_scene)
        {
            let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            let factor = (f64::from(scroll) * self.config.zoom_per_px).exp() * f64::from(pinch);
            if factor != 1.0 {
                self.zoom(factor, at, response, model, scene);
            }
        }
    }

    /// A press sets the robot's position, the drag from there its heading. A click without a drag keeps the estimated heading.
    fn drag_robot_pose(
        &mut self,
        ui: &Ui,
        response: &Response,
        model: &Model,
        scene: &SceneSync,
        out: &mut Vec<ClientCommand>,
    ) {
        let Some(view) = self.view else { return };
        let (pressed, pointer) =
            ui.input(|input| (input.pointer.press_origin(), input.pointer.interact_pos()));
        let dragging = response.dragged_by(PointerButton::Primary);
        if let (true, Some(from), Some(to)) = (dragging, pressed, pointer) {
            let ground = |at| self.ground_at(&view, pixel(at, response, &view), scene);
            let from = self.dragged_pose.map(|[from, _]| from).or_else(|| ground(from));
            let projection = CameraProjection::new(view.camera, view.viewport_px);
            self.dragged_pose = from.and_then(|from| {
                let to = projection.ray(pixel(to, response, &view)).at_height(from.z)?;
                Some([from, to])
            });
        }
        let dragged = if response.drag_stopped_by(PointerButton::Primary) {
            self.dragged_pose.take().map(|[from, to]| (from, (to - from).y.atan2((to - from).x)))
        } else if response.clicked_by(PointerButton::Primary) {
            let at = response.interact_pointer_pos();
            let ground = at.and_then(|at| self.ground_at(&view, pixel(at, response, &view), scene));
            ground.map(|from| (from, estimated_yaw(model)))
        } else {
            None
        };
        if let Some((from, yaw)) = dragged {
            let (sin, cos) = (0.5 * yaw).sin_cos();
            let position =
                vocab::Vec3::new(from.x, from.y, scene.ground() + model.platform.standing_height_m());
            let orientation = vocab::Quat { x: 0.0, y: 0.0, z: sin, w: cos };
            out.push(ClientCommand::SetPose(vocab::Pose { position, orientation }));
        }
    }

    /// On the screen that edits the site, drags edit it: see [`GraphGestures`]. Returns whether one is under way.
    fn edit_by_drag(
        &mut self,
        ui: &Ui,
        response: &Response,
        model: &Model,
        scene: &SceneSync,
        out: &mut Vec<ClientCommand>,
    ) -> bool {
        let Some(view) = self.view.filter(|_| panels::is_editing_graph(model)) else {
            self.graph.cancel();
            return false;
        };
        // The gestures ask this viewport for places meanwhile.
        let mut gestures = std::mem::take(&mut self.graph);
        let options = self.pick_options(&view);
        let pixel = |at| pixel(at, response, &view);
        let target_at = |at| match scene.renderer.borrow().pick(&view, pixel(at), &options)? {
            Hit::Marker(marker) => scene.marker_target(marker),
            _ => None,
        };
        let max_distance_m = self.config.max_goal_distance_m + view.camera.distance;
        let floor_at = |at| self.ground_at(&view, pixel(at), scene);
        let (target_at, floor_at, pixel) = (&target_at, &floor_at, &pixel);
        let cx =
            GestureContext { ui, response, model, scene, view, target_at, floor_at, pixel, max_distance_m };
        let is_dragging = gestures.update(&cx, out);
        self.graph = gestures;
        is_dragging
    }

    fn pick_options(&self, view: &View) -> PickOptions {
        let scale = f64::from(view.pixels_per_point);
        PickOptions {
            target_px: self.config.target_reach_px * scale,
            marker_px: self.config.marker_radius_px * scale,
            line_px: self.config.line_reach_px * scale,
            point_px: self.config.point_reach_px * scale,
        }
    }

    /// Zooms to the point of the map under the pointer, or to the ground there if there is none. While the camera follows the robot, zooms to
    /// the robot.
    fn zoom(&mut self, factor: f64, at: egui::Pos2, response: &Response, model: &Model, scene: &SceneSync) {
        let pose = self.camera.pose();
        let view = self.view.filter(|_| !model.view_settings().follow || model.viewed_map().is_some());
        let Some(view) = view else {
            let nearest = (pose.distance / self.config.min_robot_distance_m).max(1.0);
            self.camera.zoom(factor.min(nearest), pose.target);
            return;
        };
        let projection = CameraProjection::new(view.camera, view.viewport_px);
        let at = pixel(at, response, &view);
        let reach = self.config.point_reach_px * f64::from(view.pixels_per_point);
        if let Some(point) = scene.renderer.borrow().pick_point(&view, &projection, at, reach) {
            // The target goes to the surface, so that the shortest camera distance is one to the surface.
            self.camera.move_target_to_depth_of(point);
            self.camera.zoom(factor, point);
            return;
        }
        let max_distance = self.config.max_ground_focus_ratio * pose.distance;
        let ground = projection.ray(at).at_height(pose.target.z);
        let focus = ground.filter(|ground| ground.distance(pose.target) < max_distance);
        self.camera.zoom(factor, focus.unwrap_or(pose.target));
    }

    fn clicks(
        &mut self,
        response: &Response,
        model: &Model,
        scene: &SceneSync,
        out: &mut Vec<ClientCommand>,
    ) {
        let (Some(view), Some(at)) = (self.view, response.interact_pointer_pos()) else { return };
        if !response.clicked_by(PointerButton::Primary) || model.is_picking_pose() {
            return;
        }
        let at = pixel(at, response, &view);
        let scale = f64::from(view.pixels_per_point);
        if model.is_picking_goal() {
            match self.ground_at(&view, at, scene) {
                Some(goal) => out.push(ClientCommand::WalkTo(vocab::Vec3::from(goal.to_array()))),
                None => out.push(ClientCommand::PickGoal(false)),
            }
            return;
        }
        if model.alignment().is_some_and(|align| align.reference.is_some()) {
            let projection = CameraProjection::new(view.camera, view.viewport_px);
            let point = scene.renderer.borrow().pick_point(
                &view,
                &projection,
                at,
                self.config.point_reach_px * scale,
            );
            // The second click of a double click would pick in the other map.
            let point = point.filter(|_| !response.double_clicked());
            out.extend(
                point.map(|point| ClientCommand::AddAlignmentPoint(vocab::Vec3::from(point.to_array()))),
            );
            return;
        }
        let hit = scene.renderer.borrow().pick(&view, at, &self.pick_options(&view));
        let marked = hit.and_then(|hit| match hit {
            Hit::Marker(marker) => scene.marker_target(marker),
            _ => None,
        });
        let marked = match marked {
            Some(GraphTarget::Object(selection)) => Some(selection),
            Some(GraphTarget::Heading(node)) => Some(Selection::Node(node)),
            Some(GraphTarget::ZoneCorner(zone, _) | GraphTarget::ZoneSide(zone, _)) => {
                Some(Selection::Zone(zone))
            }
            None => None,
        };
        if let Some(tool) = panels::graph_tool(&response.ctx, model) {
            let projection = CameraProjection::new(view.camera, view.viewport_px);
            let reach = self.config.point_reach_px * scale;
            let click = GraphClick {
                hit: marked,
                floor: self.ground_at(&view, at, scene),
                point: scene.renderer.borrow().pick_point(&view, &projection, at, reach),
            };
            return click.edit(tool, model, scene, &view, out);
        }
        if response.double_clicked() {
            if let Some(Hit::Point(target)) = hit {
                stop_following(model, out);
                let pose = self.camera.pose();
                let distance = (self.config.double_click_ratio * pose.distance)
                    .max(self.config.min_double_click_distance_m.min(pose.distance));
                self.camera.fly_to(CameraPose { target, distance, ..pose });
            }
            return;
        }
        out.push(ClientCommand::Select(match hit {
            Some(Hit::Robot) => Some(Selection::Robot),
            Some(Hit::Node(number)) => Some(Selection::Keyframe(vocab::KeyframeId(number))),
            Some(Hit::Loop([from, to])) => {
                Some(Selection::Loop(LoopPair::of(vocab::KeyframeId(from), vocab::KeyframeId(to))))
            }
            Some(Hit::Marker(_)) => marked,
            Some(Hit::Point(_)) | None => None,
        }));
    }

    /// The position under a pixel, m, map frame: a point of the map, else a point of the robot's ground plane.
    fn ground_at(&self, view: &View, pixel: DVec2, scene: &SceneSync) -> Option<DVec3> {
        let projection = CameraProjection::new(view.camera, view.viewport_px);
        let reach = self.config.point_reach_px * f64::from(view.pixels_per_point);
        let point = scene.renderer.borrow().pick_point(view, &projection, pixel, reach);
        let plane = || projection.ray(pixel).at_height(scene.ground());
        point.or_else(plane).filter(|goal| {
            goal.distance(projection.camera_position())
                < self.config.max_goal_distance_m + view.camera.distance
        })
    }
}

/// Positions of the two keyframes of a loop, m, map frame; `None` while they are unknown.
fn ends(model: &Model, pair: LoopPair) -> Option<[DVec3; 2]> {
    let pose_of = |id| model.displayed_map().map_from_anchor(api::TileAnchor::Keyframe(id));
    Some([vector(pose_of(pair.from)?.position), vector(pose_of(pair.to)?.position)])
}

/// The viewpoint of the first image, once the robot's pose is known: its tiles are fetched before there is a graphics device.
pub(crate) fn first_viewpoint(model: &Model) -> Option<client_model::Viewpoint> {
    let camera = CameraPose { target: robot_target(model)?, ..first_pose() };
    Some(viewpoint_of(camera, browser::window_px()))
}

fn first_pose() -> CameraPose {
    CameraPose { pitch: 0.75, distance: 22.0, ..CameraPose::default() }
}

fn viewpoint_of(camera: CameraPose, viewport_px: [u32; 2]) -> client_model::Viewpoint {
    let projection = CameraProjection::new(camera, viewport_px);
    let [width, height] = viewport_px.map(f64::from);
    let corner_tan = CameraProjection::TAN_HALF_FOV * (width / height).hypot(1.0);
    client_model::Viewpoint {
        position: projection.camera_position().to_array(),
        forward: camera.forward().as_vec3().to_array(),
        focal_px: projection.focal_px() as f32,
        corner_cos: (1.0 / corner_tan.hypot(1.0)) as f32,
    }
}

fn robot_target(model: &Model) -> Option<DVec3> {
    let estimate = model.robot.estimate.as_ref()?;
    Some(vector(estimate.value.map_from_base.position)).filter(|at| at.is_finite())
}

/// Estimated heading of the robot, rad from the map's x axis.
fn estimated_yaw(model: &Model) -> f64 {
    let q = model.robot.estimate.as_ref().map(|estimate| estimate.value.map_from_base.orientation);
    q.map_or(0.0, |q| (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z)))
}

fn stop_following(model: &Model, out: &mut Vec<ClientCommand>) {
    if model.view_settings().follow && model.viewed_map().is_none() {
        out.push(ClientCommand::EditView(ViewSettings { follow: false, ..model.view_settings().clone() }));
    }
}

/// The part `free` of the viewport at `rect`, physical px.
fn free_area(ctx: &egui::Context, rect: egui::Rect, free: egui::Rect) -> FreeArea {
    let px = |at: egui::Pos2| {
        let from_corner = (at - rect.min) * ctx.pixels_per_point();
        DVec2::new(f64::from(from_corner.x), f64::from(from_corner.y))
    };
    FreeArea { min_px: px(free.min), max_px: px(free.max) }
}

/// Physical pixels from the viewport's top left corner.
fn pixel(at: egui::Pos2, response: &Response, view: &View) -> DVec2 {
    let from_corner = at - response.rect.min;
    DVec2::new(f64::from(from_corner.x), f64::from(from_corner.y)) * f64::from(view.pixels_per_point)
}

/// Paints the scene into egui's image. Callbacks must be `Send`. The renderer is not, so it is stored among egui's resources.
struct ScenePaint {
    view: View,
}

impl egui_wgpu::CallbackTrait for ScenePaint {
    fn prepare(
        &self,
        _device: &wgpu::Device,
        _queue: &wgpu::Queue,
        _screen: &egui_wgpu::ScreenDescriptor,
        encoder: &mut wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(renderer) = resources.get::<SharedRenderer>() {
            renderer.borrow_mut().prepare(encoder, &self.view);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &egui_wgpu::CallbackResources,
    ) {
        if let Some(renderer) = resources.get::<SharedRenderer>() {
            renderer.borrow().paint(pass);
        }
    }
}
