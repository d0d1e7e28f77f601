//! The picture that the robot's camera would take: the panel leaves room for it, and whoever draws the scene fills it.

use client_model::CameraSight;
use egui::layers::ShapeIdx;
use egui::{LayerId, Rect};

/// Room for the picture in this frame.
#[derive(Clone, Copy, Debug)]
pub struct CameraPreview {
    /// Where, points.
    pub rect: Rect,
    /// The part of it that is visible, points.
    pub clip_rect: Rect,
    /// The layer of the panel.
    pub layer: LayerId,
    /// The shape in that layer to be replaced by the picture.
    pub shape: ShapeIdx,
    /// From where to where.
    pub sight: CameraSight,
}

/// What is known of the line of sight of a preview.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SightCheck {
    /// Of which.
    pub sight: CameraSight,
    /// Distance from the camera to the first thing in the way, m; `None`: nothing is.
    pub blocked_m: Option<f64>,
}
