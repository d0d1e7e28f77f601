//! Labels of the scene: robot, goal, docks, picked points, keyframes.

use crate::scene_sync::{BASE_HEIGHT_M, vector};
use client_model::{Model, Selection};
use glam::DVec3;
use panels::{LabelKind, SceneLabel};
use vocab::KeyframeId;

/// Number of keyframes in the accessible tree: the nearest ones. More would hide everything else from a screen reader.
const MAX_KEYFRAME_LABELS: usize = 24;

/// Position on the screen (points) and depth (m).
type ScreenPosition = (egui::Pos2, f64);

/// Labels of what is in the image, the most important first. `project`: from a point of the map to the screen, if it is in the image.
pub(crate) fn scene_labels(
    model: &Model,
    project: impl Fn(DVec3) -> Option<ScreenPosition>,
) -> Vec<SceneLabel> {
    let mut labels = Vec::new();
    if model.viewed_map().is_none() && model.has_pose_in_map() {
        robot_labels(model, &project, &mut labels);
    }
    if model.viewed_map().is_none() {
        survey_labels(model, &project, &mut labels);
    }
    dock_labels(model, &project, &mut labels);
    picked_labels(model, &project, &mut labels);
    // Keyframes would be in the way of the robot's pose or the points that are picked.
    let picking = model.is_picking_pose() || model.alignment().is_some();
    if (model.view_settings().graph || model.loop_pick().is_some()) && model.has_pose_graph() && !picking {
        keyframe_labels(model, &project, &mut labels);
    }
    labels
}

/// The robot and its goal.
fn robot_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    let live = |at: DVec3| project(at).map(|(at, _)| at);
    if let Some(estimate) = &model.robot.estimate
        && let Some(at) = live(vector(estimate.value.map_from_base.position))
    {
        let v = estimate.value.velocity.linear;
        labels.push(SceneLabel {
            kind: LabelKind::Selectable(Selection::Robot),
            name: "Robot in the scene".to_owned(),
            tag: format!("Robot · {:.1} m/s", v.x.hypot(v.y)),
            at,
            selected: model.selection() == Some(Selection::Robot),
            small: false,
        });
    }
    if let api::Motion::Walking { goal, remaining, .. } = model.motion()
        && let Some(at) = live(vector(*goal))
    {
        let tag = format!("Goal · {}", panels::words::distance(*remaining));
        let name = "Goal".to_owned();
        labels.push(SceneLabel { kind: LabelKind::Goal, name, tag, at, selected: false, small: false });
    }
}

/// Places to survey.
fn survey_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    for (number, target) in (1..).zip(&model.quality().places) {
        let Some((at, _)) = project(vector(target.at)) else { continue };
        let name = format!("Place {number} worth a walk, in the scene");
        let tag = panels::words::why_walk(target.why);
        labels.push(SceneLabel { kind: LabelKind::WorthAWalk, name, tag, at, selected: false, small: false });
    }
}

/// Docks.
fn dock_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    for (number, dock) in (1..).zip(model.docks()) {
        let Some((at, _)) = project(vector(dock.position) - DVec3::Z * BASE_HEIGHT_M) else { continue };
        let (kind, name) = (LabelKind::Dock, format!("Dock {number} in the scene"));
        labels.push(SceneLabel { kind, name, tag: "Dock".to_owned(), at, selected: false, small: false });
    }
}

/// Points that were picked to align two maps.
fn picked_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    let (Some(align), Some(viewed)) = (model.alignment(), model.viewed_map()) else { return };
    for (number, picked) in (1..).zip(align.points_in(viewed)) {
        let Some((at, _)) = project(vector(picked)) else { continue };
        let (kind, name, tag) = (LabelKind::Picked, format!("Picked point {number}"), number.to_string());
        labels.push(SceneLabel { kind, name, tag, at, selected: false, small: false });
    }
}

/// Name of a keyframe and, while mapping, its accuracy.
fn selected_tag(model: &Model, id: KeyframeId) -> String {
    let deviation = model.quality().deviation_of(id).filter(|_| model.viewed_map().is_none());
    match deviation.map(|deviation| panels::words::accuracy(f64::from(deviation).max(1e-3))) {
        Some(known) => format!("Keyframe {} · known to {known}", id.0),
        None => format!("Keyframe {}", id.0),
    }
}

/// The keyframes nearest to the camera.
fn keyframe_labels(
    model: &Model,
    project: &impl Fn(DVec3) -> Option<ScreenPosition>,
    labels: &mut Vec<SceneLabel>,
) {
    let mut candidates: Vec<(f64, SceneLabel)> = Vec::new();
    for node in &model.displayed_map().graph.nodes {
        let Some((at, depth)) = project(vector(node.map_from_keyframe.position)) else { continue };
        let selected = model.selection() == Some(Selection::Keyframe(node.id));
        let name = format!("Keyframe {}", node.id.0);
        let tag = if selected { selected_tag(model, node.id) } else { String::new() };
        let kind = LabelKind::Selectable(Selection::Keyframe(node.id));
        let order = if selected { f64::NEG_INFINITY } else { depth };
        candidates.push((order, SceneLabel { kind, name, tag, at, selected, small: true }));
    }
    candidates.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    labels.extend(candidates.into_iter().take(MAX_KEYFRAME_LABELS).map(|(_, label)| label));
}
