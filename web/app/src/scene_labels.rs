//! Labels of the scene: robot, goal, docks, picked points, keyframes.

use crate::graph_preview::GraphPreview;
use crate::mission_overlay;
use crate::vector::vector;
use crate::zone_overlay;
use client_model::{Model, Selection, middle_of};
use glam::DVec3;
use panels::SceneLabel;
use vocab::Pose;

/// Parameters of the labels in the scene.
struct SceneLabelConfig {
    /// Largest number of keyframes in the accessible tree. More would bury the other controls for users of a screen reader. Chosen: a list that is heard in a minute or
    /// two.
    max_keyframes: usize,
    /// Largest number of nodes and inspection points with a name in the scene. More would hide each other. Chosen: names of 100 x 14 px then cover a twentieth of a
    /// screen of 1920 x 1080.
    max_nodes: usize,
}

const CONFIG: SceneLabelConfig = SceneLabelConfig { max_keyframes: 24, max_nodes: 60 };

/// Radius of the smallest ring round the robot, and the height of its sensor over the base, m.
const ROBOT_EXTENT_M: [f64; 2] = [0.62, 0.22];

/// Position on the screen (points) and depth (m).
type ScreenPosition = (egui::Pos2, f64);

/// Labels of the things in the image, the most important first. `preview`: what an operator drags. `project` maps a point of the map to the screen, if it is in the image.
pub(crate) fn scene_labels(
    model: &Model,
    preview: &GraphPreview,
    project: impl Fn(DVec3) -> Option<ScreenPosition>,
) -> Vec<SceneLabel> {
    let mut labels = Vec::new();
    if model.viewed_map().is_none() && model.has_pose_in_map() {
        robot_labels(model, &project, &mut labels);
    }
    if model.viewed_map().is_none() {
        survey_labels(model, &project, &mut labels);
    }
    mission_overlay::stop_labels(model, &project, &mut labels);
    dock_labels(model, &project, &mut labels);
    alignment_labels(model, &project, &mut labels);
    node_labels(model, preview, &project, &mut labels);
    zone_labels(model, preview, &project, &mut labels);
    // Keyframes would hide the robot's pose or the points that are picked.
    let picking = model.is_picking_pose() || model.alignment().is_some() || panels::is_graph_covered(model);
    if (model.view_settings().graph || model.loop_pick().is_some()) && model.has_pose_graph() && !picking {
        keyframe_labels(model, &project, &mut labels);
    }
    labels
}

/// Labels of the robot and its goal.
fn robot_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    if let Some(estimate) = &model.robot.estimate
        && let Some(body) = robot_on_screen(model, &estimate.value.map_from_base, project)
    {
        let v = estimate.value.velocity.linear;
        let is_selected = model.selection() == Some(Selection::Robot);
        labels.push(SceneLabel::robot(body, v.x.hypot(v.y), is_selected));
    }
    if let api::Motion::Walking { goal, remaining_m, .. } = model.motion()
        && let Some((at, _)) = project(vector(*goal))
    {
        labels.push(SceneLabel::goal(at, *remaining_m));
    }
}

/// The rectangle round the robot on the screen, points, with the point of its base in the middle. None if that point is not in the image.
fn robot_on_screen(
    model: &Model,
    map_from_base: &Pose,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
) -> Option<egui::Rect> {
    let base = vector(map_from_base.position);
    let (middle, _) = project(base)?;
    let [radius, top] = ROBOT_EXTENT_M;
    let corners = (0..8).map(|bits| {
        let side = |bit: i32| if bits & bit == 0 { radius } else { -radius };
        let z = if bits & 4 == 0 { top } else { -model.platform.standing_height_m() };
        base + DVec3::new(side(1), side(2), z)
    });
    let mut half = egui::Vec2::ZERO;
    for (corner, _) in corners.filter_map(project) {
        half = half.max((corner - middle).abs());
    }
    Some(egui::Rect::from_center_size(middle, 2.0 * half))
}

/// Labels of the survey targets.
fn survey_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    for (number, target) in (1..).zip(&model.quality().targets) {
        if let Some((at, _)) = project(vector(target.at)) {
            labels.push(SceneLabel::survey_target(at, number, target.why));
        }
    }
}

/// Labels of the docks.
fn dock_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    for (number, dock) in (1..).zip(model.docks()) {
        if let Some((at, _)) = project(vector(dock.position) - DVec3::Z * model.platform.standing_height_m())
        {
            labels.push(SceneLabel::dock(at, number));
        }
    }
}

/// Labels of the points that were picked to align two maps.
fn alignment_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    let (Some(alignment), Some(viewed)) = (model.alignment(), model.viewed_map()) else { return };
    for (number, point) in (1..).zip(alignment.points_in(viewed)) {
        if let Some((at, _)) = project(vector(point)) {
            labels.push(SceneLabel::alignment_point(at, number));
        }
    }
}

/// Names of the nodes of the topological map and of the inspection points nearest to the camera, and of the selected one.
fn node_labels(
    model: &Model,
    preview: &GraphPreview,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    if !model.is_site_on_screen() {
        return;
    }
    let stops = mission_overlay::stop_nodes(model);
    let mut candidates: Vec<(f64, SceneLabel)> = Vec::new();
    let selected = model.selected_nodes();
    for node in model.site.shown_nodes() {
        let dragged = preview.nodes.get(&node.id).copied();
        let base = dragged.unwrap_or_else(|| vector(node.map_from_node.position));
        let floor = base - DVec3::Z * model.platform.standing_height_m();
        let Some((at, depth_m)) = project(floor) else { continue };
        let is_selected = selected.contains(&node.id);
        let order = if is_selected { f64::NEG_INFINITY } else { depth_m };
        let label = SceneLabel::node(at, node.id, &node.name, is_selected);
        candidates.push((order, if stops.contains(&node.id) { label.without_tag() } else { label }));
    }
    for point in model.site.inspection_points().into_iter().filter(|point| model.site.is_point_shown(point)) {
        let Some((at, depth_m)) = project(vector(point.target_m)) else { continue };
        let is_selected = model.selection() == Some(Selection::InspectionPoint(point.id));
        let order = if is_selected { f64::NEG_INFINITY } else { depth_m };
        candidates.push((order, SceneLabel::inspection_point(at, point.id, &point.name, is_selected)));
    }
    candidates.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    labels.extend(candidates.into_iter().take(CONFIG.max_nodes).map(|(_, label)| label));
}

/// Names of the zones, with what holds in them. `preview`: what an operator drags.
fn zone_labels(
    model: &Model,
    preview: &GraphPreview,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    if !model.is_site_on_screen() {
        return;
    }
    for zone in model.site.zones().into_iter().filter(|zone| model.site.is_zone_shown(zone)) {
        let dragged = preview.zone.as_ref().filter(|dragged| dragged.zone == Some(zone.id));
        let [x, y] = middle_of(dragged.map_or(&zone.corners_m, |dragged| &dragged.corners_m));
        let middle = DVec3::new(x, y, zone_overlay::floor_m(model, zone));
        if let Some((at, _)) = project(middle) {
            let is_selected = model.selection() == Some(Selection::Zone(zone.id));
            labels.push(SceneLabel::zone(at, zone, is_selected));
        }
    }
}

/// Labels of the keyframes nearest to the camera and of the selected one. While mapping, its tag shows its standard deviation.
fn keyframe_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    let is_live = model.viewed_map().is_none();
    let mut candidates: Vec<(f64, SceneLabel)> = Vec::new();
    for node in &model.displayed_map().graph.nodes {
        let Some((at, depth_m)) = project(vector(node.map_from_keyframe.position)) else { continue };
        let is_selected = model.selection() == Some(Selection::Keyframe(node.id));
        let sigma_m = model.quality().deviation_of(node.id).filter(|_| is_live).map(f64::from);
        let order = if is_selected { f64::NEG_INFINITY } else { depth_m };
        candidates.push((order, SceneLabel::keyframe(at, node.id, sigma_m, is_selected)));
    }
    candidates.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    labels.extend(candidates.into_iter().take(CONFIG.max_keyframes).map(|(_, label)| label));
}
