//! The things of the scene that have names: robot, goal, docks, picked points, keyframes.

use crate::scene_sync::{BASE_HEIGHT_M, vector};
use client_model::{Model, Selection};
use glam::DVec3;
use panels::{LabelKind, SceneLabel};
use vocab::KeyframeId;

/// Keyframes that are elements of the accessible tree: the nearest ones; more would drown everything else.
const KEYFRAME_LABELS_MAX: usize = 24;

/// Place on the screen, points, and depth, metres.
type Spot = (egui::Pos2, f64);

/// Labels of what is in the picture, the most important first. `place` says where a point of the map is in it.
pub(crate) fn scene_labels(model: &Model, place: impl Fn(DVec3) -> Option<Spot>) -> Vec<SceneLabel> {
    let mut labels = Vec::new();
    if model.viewed_map().is_none() && model.has_pose_in_map() {
        robot_labels(model, &place, &mut labels);
    }
    if model.viewed_map().is_none() {
        worth_a_walk(model, &place, &mut labels);
    }
    dock_labels(model, &place, &mut labels);
    picked_labels(model, &place, &mut labels);
    // Nothing shall be in the way of who shows where the robot stands, or picks points.
    let pointing = model.is_picking_pose() || model.alignment().is_some();
    if (model.view_settings().graph || model.loop_pick().is_some()) && !pointing {
        keyframe_labels(model, &place, &mut labels);
    }
    labels
}

/// The robot, and where it goes.
fn robot_labels(model: &Model, place: &impl Fn(DVec3) -> Option<Spot>, labels: &mut Vec<SceneLabel>) {
    let live = |at: DVec3| place(at).map(|(at, _)| at);
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

/// Places that the map lacks.
fn worth_a_walk(model: &Model, place: &impl Fn(DVec3) -> Option<Spot>, labels: &mut Vec<SceneLabel>) {
    for (number, lacking) in (1..).zip(&model.quality().places) {
        let Some((at, _)) = place(vector(lacking.at)) else { continue };
        let name = format!("Place {number} worth a walk, in the scene");
        let tag = panels::words::why_walk(lacking.why);
        labels.push(SceneLabel { kind: LabelKind::WorthAWalk, name, tag, at, selected: false, small: false });
    }
}

/// Where the robot was charged.
fn dock_labels(model: &Model, place: &impl Fn(DVec3) -> Option<Spot>, labels: &mut Vec<SceneLabel>) {
    for (number, dock) in (1..).zip(model.docks()) {
        let Some((at, _)) = place(vector(dock.position) - DVec3::Z * BASE_HEIGHT_M) else { continue };
        let (kind, name) = (LabelKind::Dock, format!("Dock {number} in the scene"));
        labels.push(SceneLabel { kind, name, tag: "Dock".to_owned(), at, selected: false, small: false });
    }
}

/// Points that are to lie on each other when one map is laid onto the other.
fn picked_labels(model: &Model, place: &impl Fn(DVec3) -> Option<Spot>, labels: &mut Vec<SceneLabel>) {
    let (Some(align), Some(viewed)) = (model.alignment(), model.viewed_map()) else { return };
    for (number, picked) in (1..).zip(align.picked_in(viewed)) {
        let Some((at, _)) = place(vector(picked)) else { continue };
        let (kind, name, tag) = (LabelKind::Picked, format!("Picked point {number}"), number.to_string());
        labels.push(SceneLabel { kind, name, tag, at, selected: false, small: false });
    }
}

/// The name of a keyframe, and how well it is known while the map is made.
fn selected_tag(model: &Model, id: KeyframeId) -> String {
    let known = model.quality().deviation_of(id).filter(|_| model.viewed_map().is_none());
    match known.map(|deviation| panels::words::accuracy(f64::from(deviation).max(1e-3))) {
        Some(known) => format!("Keyframe {} · known to {known}", id.0),
        None => format!("Keyframe {}", id.0),
    }
}

/// The keyframes nearest to the eye.
fn keyframe_labels(model: &Model, place: &impl Fn(DVec3) -> Option<Spot>, labels: &mut Vec<SceneLabel>) {
    let mut seen: Vec<(f64, SceneLabel)> = Vec::new();
    for node in &model.displayed_map().graph.nodes {
        let Some((at, depth)) = place(vector(node.map_from_keyframe.position)) else { continue };
        let selected = model.selection() == Some(Selection::Keyframe(node.id));
        let name = format!("Keyframe {}", node.id.0);
        let tag = if selected { selected_tag(model, node.id) } else { String::new() };
        let kind = LabelKind::Selectable(Selection::Keyframe(node.id));
        let order = if selected { f64::NEG_INFINITY } else { depth };
        seen.push((order, SceneLabel { kind, name, tag, at, selected, small: true }));
    }
    seen.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    labels.extend(seen.into_iter().take(KEYFRAME_LABELS_MAX).map(|(_, label)| label));
}
