//! What the gestures on the screen that edits the site read.

use crate::graph_overlay::GraphTarget;
use crate::scene_sync::SceneSync;
use client_model::Model;
use egui::{Pos2, Response, Ui};
use glam::{DVec2, DVec3};
use scene::View;

/// What a gesture reads.
pub(crate) struct GestureContext<'a> {
    pub(crate) ui: &'a Ui,
    pub(crate) response: &'a Response,
    pub(crate) model: &'a Model,
    pub(crate) scene: &'a SceneSync,
    pub(crate) view: View,
    /// What is under a pixel of the viewport.
    pub(crate) target_at: &'a dyn Fn(Pos2) -> Option<GraphTarget>,
    /// The place on the floor under a pixel of the viewport, m, map frame.
    pub(crate) floor_at: &'a dyn Fn(Pos2) -> Option<DVec3>,
    /// The physical pixel of a place on the screen.
    pub(crate) pixel: &'a dyn Fn(Pos2) -> DVec2,
    /// Longest distance of a dragged thing from the camera, m.
    pub(crate) max_distance_m: f64,
}
