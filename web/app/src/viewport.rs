//! The scene on the screen: gestures move the camera, clicks select or say where to walk.

use crate::stage::{BASE_HEIGHT_M, SharedRenderer, Stage, vector};
use crate::{browser, labels};
use client_model::{Bookmark, CameraMove, ClientCommand, LoopPair, Model, Selection, ViewSettings};
use eframe::egui_wgpu;
use egui::{PointerButton, Response, Sense, Ui};
use glam::{DVec2, DVec3, Vec3};
use panels::SceneLabel;
use scene::{Camera, CameraPose, Eye, Hit, Pace, PickOptions, View};
use std::collections::BTreeMap;
use std::time::Duration;
use vocab::MapId;

/// The camera looks at the robot's body, a little above the ground, metres.
const LOOK_HEIGHT_M: f64 = 0.3;
/// How far from the pointer a sign still counts, points: half a fingertip.
const SIGN_REACH: f64 = 22.0;
/// How far from the pointer a point of the map still counts, points.
const POINT_REACH: f64 = 6.0;
/// How large signs are drawn, points: there they come before the lines of loops.
const SIGN_DISC: f64 = 10.0;
/// How far from the pointer the line of a loop still counts, points.
const LINE_REACH: f64 = 7.0;
/// A wheel's notch of about 50 points doubles the scale in five.
const ZOOM_PER_POINT: f64 = 0.0028;
/// How near the camera goes to a loop at least, metres, and in lengths of the loop.
const LOOP_VIEW_M: f64 = 14.0;
const LOOP_VIEW_LENGTHS: f64 = 2.5;
/// How far the camera looks down at a loop at least, radians: scans are compared from above.
const LOOP_PITCH: f64 = 0.9;
/// A walk goal is offered at most this far away, metres: farther clicks are slips.
const WALK_M_MAX: f64 = 80.0;

/// The camera and what is between it and the person.
pub(crate) struct Viewport {
    camera: Camera,
    placed: bool,
    /// What was drawn last, perhaps coarser than wanted.
    view: Option<View>,
    pace: Pace,
    /// Where a person who shows where the robot stands pressed the ground, and where the pointer is, map frame.
    placing: Option<[DVec3; 2]>,
    /// The saved map on show, and from where those shown before were looked at last.
    viewed: Option<MapId>,
    left: BTreeMap<MapId, CameraPose>,
}

impl Viewport {
    /// `pace` is how much is drawn at first.
    pub(crate) fn new(pace: Pace) -> Self {
        Self {
            camera: Camera::new(first_pose()),
            placed: false,
            view: None,
            pace,
            placing: None,
            viewed: None,
            left: BTreeMap::new(),
        }
    }

    /// From where the map is looked at, for the choice of tiles.
    pub(crate) fn eye(&self) -> Option<client_model::Viewpoint> {
        self.view.map(|view| eye_of(view.camera, view.viewport_px))
    }

    /// From where to where a person drags who shows where the robot stands, map frame, metres.
    pub(crate) fn placing(&self) -> Option<[DVec3; 2]> {
        self.placing
    }

    /// Draws the scene and takes what is done to it.
    pub(crate) fn show(&mut self, ui: &mut Ui, model: &Model, stage: &Stage, out: &mut Vec<ClientCommand>) {
        let rect = ui.max_rect();
        let response = ui.interact(rect, ui.scope_id().with("scene"), Sense::click_and_drag());
        ui.ctx().accesskit_node_builder(response.id, |node| {
            node.set_role(egui::Role::Canvas);
            node.set_label("Map in 3D");
        });
        self.change_map(model);
        self.follow_robot(model, stage);
        if model.is_picking_pose() {
            self.place_robot(ui, &response, model, stage, out);
        } else {
            self.placing = None;
            self.gestures(ui, &response, model, out);
        }
        let seconds = f64::from(ui.input(|input| input.stable_dt)).min(0.1);
        if self.camera.flying() {
            self.camera.advance(if browser::reduced_motion() { scene::FLIGHT_SECONDS } else { seconds });
            ui.ctx().request_repaint();
        }
        let pixels_per_point = ui.ctx().pixels_per_point();
        let viewport_px =
            [rect.width(), rect.height()].map(|side| (side * pixels_per_point).round().max(1.0) as u32);
        let wanted = stage.view(model, self.camera.pose(), viewport_px, pixels_per_point);
        let view = self.paced(ui.ctx(), wanted, stage);
        ui.painter().add(egui_wgpu::Callback::new_paint_callback(rect, ScenePaint { view }));
        self.clicks(&response, model, stage, out);
    }

    /// The view to draw for the one that is wanted: as much as the machine can do while things move, more once
    /// they rest.
    fn paced(&mut self, ctx: &egui::Context, wanted: View, stage: &Stage) -> View {
        let now = browser::now_ms() * 1e-3;
        let (view, refine_in) = self.pace.view(now, &wanted, &stage.renderer.borrow());
        if let Some(seconds) = refine_in {
            ctx.request_repaint_after(Duration::from_secs_f64(seconds));
        }
        self.view = Some(view);
        view
    }

    /// The things of the scene that have names, the most important first.
    pub(crate) fn labels(&self, model: &Model) -> Vec<SceneLabel> {
        let Some(view) = self.view else { return Vec::new() };
        let eye = Eye::new(view.camera, view.viewport_px);
        let place = |at: DVec3| {
            let (pixel, depth) = eye.project(at)?;
            let inside = pixel.cmpge(DVec2::ZERO).all()
                && pixel.x <= f64::from(view.viewport_px[0])
                && pixel.y <= f64::from(view.viewport_px[1]);
            let point = pixel / f64::from(view.pixels_per_point);
            inside.then_some((egui::pos2(point.x as f32, point.y as f32), depth))
        };
        labels::of(model, place)
    }

    /// Carries out a movement of the camera. Returns settings that changed by it.
    pub(crate) fn go(&mut self, to: &CameraMove, model: &Model) -> Option<ViewSettings> {
        let pose = self.camera.pose();
        match to {
            CameraMove::Fit => {
                // Who goes to and fro between two maps to pick points goes on where they were.
                self.change_map(model);
                let left = model.viewed_map().and_then(|map| self.left.remove(&map));
                if let Some(pose) = left.filter(|_| model.alignment().is_some()) {
                    self.camera.jump_to(pose);
                } else if let Some(fit) = self.fitting(model) {
                    self.camera.fly_to(fit);
                }
            }
            CameraMove::Top => {
                let fit = self.fitting(model).unwrap_or(pose);
                let pitch = 0.5 * std::f64::consts::PI;
                self.camera.fly_to(CameraPose { pitch, yaw: 0.5 * std::f64::consts::PI, ..fit });
            }
            CameraMove::Robot => {
                if let Some(target) = robot_target(model) {
                    self.camera.fly_to(CameraPose { target, distance: pose.distance.min(25.0), ..pose });
                }
            }
            CameraMove::Loop(pair) => {
                if let Some([a, b]) = ends(model, *pair) {
                    let distance = (LOOP_VIEW_LENGTHS * a.distance(b)).max(LOOP_VIEW_M);
                    let pitch = pose.pitch.max(LOOP_PITCH);
                    self.camera.fly_to(CameraPose { target: a.midpoint(b), distance, pitch, ..pose });
                }
            }
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

    /// The pose from which the whole map on show is seen; of its list of tiles, whether they are here or not.
    fn fitting(&self, model: &Model) -> Option<CameraPose> {
        let view = self.view?;
        let bounds = model.displayed_map().bounds()?;
        let [min, max] = [bounds.min, bounds.max].map(|corner| Vec3::from_array(corner).as_dvec3());
        Some(self.camera.fitting(min, max, view.viewport_px))
    }

    /// Remembers from where the map was looked at that is not on show any more.
    fn change_map(&mut self, model: &Model) {
        let now = model.viewed_map();
        if self.viewed != now {
            let before = std::mem::replace(&mut self.viewed, now);
            if model.alignment().is_none() {
                self.left.clear();
            }
            self.left.extend(before.map(|before| (before, self.camera.pose())));
        }
    }

    fn follow_robot(&mut self, model: &Model, stage: &Stage) {
        if model.viewed_map().is_some() {
            return;
        }
        let Some(target) = robot_target(model) else { return };
        if !self.placed {
            self.placed = true;
            self.camera.jump_to(CameraPose { target, ..self.camera.pose() });
        } else if model.view_settings().follow && !self.camera.flying() {
            let height = stage.ground() + LOOK_HEIGHT_M;
            self.camera.jump_to(CameraPose { target: target.with_z(height), ..self.camera.pose() });
        }
    }

    fn gestures(&mut self, ui: &Ui, response: &Response, model: &Model, out: &mut Vec<ClientCommand>) {
        let height = f64::from(response.rect.height());
        let mut pan = DVec2::ZERO;
        if let Some(touch) = ui
            .input(egui::InputState::multi_touch)
            .filter(|_| response.contains_pointer() || response.dragged())
        {
            pan = DVec2::new(f64::from(touch.translation_delta.x), f64::from(touch.translation_delta.y));
            self.zoom(f64::from(touch.zoom_delta), touch.center_pos, response, model);
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
        if response.hovered()
            && let Some(at) = response.hover_pos()
        {
            let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            let factor = (f64::from(scroll) * ZOOM_PER_POINT).exp() * f64::from(pinch);
            if factor != 1.0 {
                self.zoom(factor, at, response, model);
            }
        }
    }

    /// A press says where the robot stands, the way from there to the release where it looks. Without a way it looks where it is thought
    /// to look now.
    fn place_robot(
        &mut self,
        ui: &Ui,
        response: &Response,
        model: &Model,
        stage: &Stage,
        out: &mut Vec<ClientCommand>,
    ) {
        let Some(view) = self.view else { return };
        let (pressed, pointer) =
            ui.input(|input| (input.pointer.press_origin(), input.pointer.interact_pos()));
        let dragged = response.dragged_by(PointerButton::Primary);
        if let (true, Some(from), Some(to)) = (dragged, pressed, pointer) {
            let ground = |at| self.ground_at(&view, pixel(at, response, &view), stage);
            let from = self.placing.map(|[from, _]| from).or_else(|| ground(from));
            let eye = Eye::new(view.camera, view.viewport_px);
            self.placing = from.and_then(|from| {
                let to = eye.ray(pixel(to, response, &view)).at_height(from.z)?;
                Some([from, to])
            });
        }
        let shown = if response.drag_stopped_by(PointerButton::Primary) {
            self.placing.take().map(|[from, to]| (from, (to - from).y.atan2((to - from).x)))
        } else if response.clicked_by(PointerButton::Primary) {
            let at = response.interact_pointer_pos();
            let ground = at.and_then(|at| self.ground_at(&view, pixel(at, response, &view), stage));
            ground.map(|from| (from, yaw_now(model)))
        } else {
            None
        };
        if let Some((from, yaw)) = shown {
            let (sin, cos) = (0.5 * yaw).sin_cos();
            let position = vocab::Vec3::new(from.x, from.y, stage.ground() + BASE_HEIGHT_M);
            let orientation = vocab::Quat { x: 0.0, y: 0.0, z: sin, w: cos };
            out.push(ClientCommand::SetPose(vocab::Pose { position, orientation }));
        }
    }

    /// Zooms about what is under the pointer, or about the robot while following it.
    fn zoom(&mut self, factor: f64, at: egui::Pos2, response: &Response, model: &Model) {
        let pose = self.camera.pose();
        let focus = self
            .view
            .filter(|_| !model.view_settings().follow || model.viewed_map().is_some())
            .and_then(|view| {
                let eye = Eye::new(view.camera, view.viewport_px);
                let ground = eye.ray(pixel(at, response, &view)).at_height(pose.target.z)?;
                (ground.distance(pose.target) < 2.0 * pose.distance).then_some(ground)
            })
            .unwrap_or(pose.target);
        self.camera.zoom(factor, focus);
    }

    fn clicks(&mut self, response: &Response, model: &Model, stage: &Stage, out: &mut Vec<ClientCommand>) {
        let (Some(view), Some(at)) = (self.view, response.interact_pointer_pos()) else { return };
        if !response.clicked_by(PointerButton::Primary) || model.is_picking_pose() {
            return;
        }
        let at = pixel(at, response, &view);
        let scale = f64::from(view.pixels_per_point);
        if model.is_picking_goal() {
            match self.ground_at(&view, at, stage) {
                Some(goal) => out.push(ClientCommand::WalkTo(vocab::Vec3::from(goal.to_array()))),
                None => out.push(ClientCommand::PickGoal(false)),
            }
            return;
        }
        if model.alignment().is_some_and(|align| align.onto.is_some()) {
            let eye = Eye::new(view.camera, view.viewport_px);
            let point = stage.renderer.borrow().pick_point(&view, &eye, at, POINT_REACH * scale);
            // The second click of two would pick in the other map.
            let point = point.filter(|_| !response.double_clicked());
            out.extend(
                point.map(|point| ClientCommand::AddAlignmentPoint(vocab::Vec3::from(point.to_array()))),
            );
            return;
        }
        let reach = PickOptions {
            sign_px: SIGN_REACH * scale,
            disc_px: SIGN_DISC * scale,
            line_px: LINE_REACH * scale,
            point_px: POINT_REACH * scale,
        };
        let hit = stage.renderer.borrow().pick(&view, at, &reach);
        if response.double_clicked() {
            if let Some(Hit::Point(target)) = hit {
                stop_following(model, out);
                let pose = self.camera.pose();
                self.camera.fly_to(CameraPose { target, distance: (0.5 * pose.distance).max(3.0), ..pose });
            }
            return;
        }
        out.push(ClientCommand::Select(match hit {
            Some(Hit::Robot) => Some(Selection::Robot),
            Some(Hit::Node(number)) => Some(Selection::Keyframe(vocab::KeyframeId(number))),
            Some(Hit::Loop([from, to])) => {
                Some(Selection::Loop(LoopPair::of(vocab::KeyframeId(from), vocab::KeyframeId(to))))
            }
            Some(Hit::Marker(_) | Hit::Point(_)) | None => None,
        }));
    }

    /// The place under a pixel: a point of the map there, else the ground plane of the robot.
    fn ground_at(&self, view: &View, pixel: DVec2, stage: &Stage) -> Option<DVec3> {
        let eye = Eye::new(view.camera, view.viewport_px);
        let reach = POINT_REACH * f64::from(view.pixels_per_point);
        let point = stage.renderer.borrow().pick_point(view, &eye, pixel, reach);
        let plane = || eye.ray(pixel).at_height(stage.ground());
        point.or_else(plane).filter(|goal| goal.distance(eye.position()) < WALK_M_MAX + view.camera.distance)
    }
}

/// Where the two keyframes of a loop are, metres, map frame; none while they are not known.
fn ends(model: &Model, pair: LoopPair) -> Option<[DVec3; 2]> {
    let place = |id| model.displayed_map().map_from_anchor(api::Anchor::Keyframe(id));
    Some([vector(place(pair.from)?.position), vector(place(pair.to)?.position)])
}

/// From where the first picture is drawn, once it is known where the robot is: for fetching what it will show while there is
/// nothing yet to draw it with.
pub(crate) fn first_eye(model: &Model) -> Option<client_model::Viewpoint> {
    let camera = CameraPose { target: robot_target(model)?, ..first_pose() };
    Some(eye_of(camera, browser::window_px()))
}

fn first_pose() -> CameraPose {
    CameraPose { pitch: 0.75, distance: 22.0, ..CameraPose::default() }
}

fn eye_of(camera: CameraPose, viewport_px: [u32; 2]) -> client_model::Viewpoint {
    let eye = Eye::new(camera, viewport_px);
    let [width, height] = viewport_px.map(f64::from);
    let corner_tan = Eye::TAN_HALF_FOV * (width / height).hypot(1.0);
    client_model::Viewpoint {
        position: eye.position().to_array(),
        forward: camera.forward().as_vec3().to_array(),
        focal_px: eye.focal_px() as f32,
        corner_cos: (1.0 / corner_tan.hypot(1.0)) as f32,
    }
}

fn robot_target(model: &Model) -> Option<DVec3> {
    let estimate = model.robot.estimate.as_ref()?;
    Some(vector(estimate.value.map_from_base.position)).filter(|at| at.is_finite())
}

/// Where the robot is thought to look, radians from the map's x axis.
fn yaw_now(model: &Model) -> f64 {
    let q = model.robot.estimate.as_ref().map(|estimate| estimate.value.map_from_base.orientation);
    q.map_or(0.0, |q| (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z)))
}

fn stop_following(model: &Model, out: &mut Vec<ClientCommand>) {
    if model.view_settings().follow && model.viewed_map().is_none() {
        out.push(ClientCommand::EditView(ViewSettings { follow: false, ..model.view_settings().clone() }));
    }
}

/// Physical pixels from the scene's left upper corner.
fn pixel(at: egui::Pos2, response: &Response, view: &View) -> DVec2 {
    let from_corner = at - response.rect.min;
    DVec2::new(f64::from(from_corner.x), f64::from(from_corner.y)) * f64::from(view.pixels_per_point)
}

/// The scene in egui's picture. Callbacks must be `Send`, which the renderer is not: it is found among the resources.
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
