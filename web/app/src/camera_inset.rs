//! Draws the picture that the robot's camera would take where a panel left room for it, and looks for what stands in the way.

use crate::scene_sync::{SceneSync, SharedRenderer};
use crate::vector::vector;
use client_model::CameraSight;
use eframe::egui_wgpu;
use glam::DVec2;
use panels::{PanelState, SightCheck};
use scene::{CameraPose, CameraProjection, Options, View};

/// Parameters of the check of the line of sight.
#[derive(Clone, Copy, Debug)]
struct SightConfig {
    /// Radius of the line of sight at the target, m. Chosen: half a voxel of the check on the robot (`points::line_of_sight::LineOfSightConfig`).
    radius_m: f64,
    /// Things nearer to the target than this belong to it, m. Chosen: a little less than on the robot (0.3 m), which has to do with the error of its pose too.
    target_m: f64,
    /// Size of the picture in which a line of sight is looked along that is not shown, px: that of the panel.
    checked_px: [u32; 2],
}

const CONFIG: SightConfig = SightConfig { radius_m: 0.05, target_m: 0.25, checked_px: [320, 240] };

/// The picture, with what its last check was of.
#[derive(Default)]
pub(crate) struct CameraInset {
    /// The line of sight that was checked, and the points that there were then.
    checked: Option<(CameraSight, u64)>,
}

impl CameraInset {
    /// Fills the room that panels left in this frame. `main`: the view of the scene.
    pub(crate) fn show(
        &mut self,
        ctx: &egui::Context,
        panels: &mut PanelState,
        scene: &SceneSync,
        main: &View,
    ) {
        let Some(preview) = panels.camera_preview() else { return };
        let size = preview.rect.size() * ctx.pixels_per_point();
        let sight = preview.sight;
        let viewport_px = [size.x, size.y].map(|side| side.round().max(1.0) as u32);
        let view = view_of(&sight, viewport_px, main);
        let paint = egui_wgpu::Callback::new_paint_callback(preview.rect, InsetPaint { view });
        ctx.layer_painter(preview.layer).with_clip_rect(preview.clip_rect).set(preview.shape, paint);
        let points = scene.renderer.borrow().statistics().points_held;
        if self.checked != Some((sight, points)) {
            self.checked = Some((sight, points));
            panels.set_sight_check(SightCheck { sight, blocked_m: blocked_m(&sight, &view, scene) });
            ctx.request_repaint();
        }
    }
}

/// The view of the robot's camera. `main`: the view of the scene.
fn view_of(sight: &CameraSight, viewport_px: [u32; 2], main: &View) -> View {
    View {
        camera: pose_of(sight),
        viewport_px,
        options: Options {
            floor: f32::MIN,
            ceiling: f32::MAX,
            map: true,
            live_scan: false,
            overlay: false,
            grid: false,
            magnification: CameraProjection::TAN_HALF_FOV / sight.tan_half_height,
            resolution: 1.0,
            ..main.options
        },
        ..*main
    }
}

/// Whether nothing stands in a line of sight. `main`: the view of the scene.
pub(crate) fn is_free(sight: &CameraSight, main: &View, scene: &SceneSync) -> bool {
    blocked_m(sight, &view_of(sight, CONFIG.checked_px, main), scene).is_none()
}

fn pose_of(sight: &CameraSight) -> CameraPose {
    CameraPose {
        target: vector(sight.target_m),
        yaw: sight.yaw_rad,
        pitch: -sight.tilt_rad,
        distance: sight.distance_m,
    }
}

/// Distance from the camera to the first thing in the line of sight, m; `None` if that is the target. Linear in the points near the line.
fn blocked_m(sight: &CameraSight, view: &View, scene: &SceneSync) -> Option<f64> {
    let projection = CameraProjection::new(view.camera, view.viewport_px);
    let middle = DVec2::from_array(view.viewport_px.map(|side| 0.5 * f64::from(side)));
    let radius_px = CONFIG.radius_m / sight.distance_m.max(0.1) * projection.focal_px();
    let hit = scene.renderer.borrow().pick_point(view, &projection, middle, radius_px)?;
    let along_m = (hit - vector(sight.camera_m)).length();
    (along_m < sight.distance_m - CONFIG.target_m).then_some(along_m)
}

/// Paints the picture. The renderer is among egui's resources, as for the scene.
struct InsetPaint {
    view: View,
}

impl egui_wgpu::CallbackTrait for InsetPaint {
    fn prepare(
        &self,
        _device: &wgpu::Device,
        _queue: &wgpu::Queue,
        _screen: &egui_wgpu::ScreenDescriptor,
        encoder: &mut wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(renderer) = resources.get::<SharedRenderer>() {
            renderer.borrow_mut().prepare_inset(encoder, &self.view);
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
            renderer.borrow().paint_inset(pass);
        }
    }
}
