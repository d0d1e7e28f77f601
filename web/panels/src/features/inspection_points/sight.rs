//! The picture that the camera would take of an inspection point, and what stands in the way.

use super::texts;
use crate::camera_preview::CameraPreview;
use crate::feature_panel::PanelContext;
use crate::theme;
use crate::widgets;
use egui::{CornerRadius, Sense, Shape, Stroke, StrokeKind, Ui, Vec2, vec2};
use site_model::InspectionPoint;

/// Height of the picture over its width.
const ASPECT: f32 = 0.75;
/// Half the size of the cross in its middle, points, and the gap around the middle.
const CROSS: [f32; 2] = [14.0, 4.0];

/// Leaves room for the picture, with a cross in its middle, and says what is known of the line of sight.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, point: &InspectionPoint) {
    let Some(sight) = cx.model.site.camera_sight(point) else { return };
    let tokens = cx.tokens;
    let width = ui.available_width();
    let (rect, response) = ui.allocate_exact_size(vec2(width, ASPECT * width), Sense::hover());
    let radius = CornerRadius::same(theme::BUTTON_RADIUS);
    let painter = ui.painter();
    painter.rect_filled(rect, radius, tokens.ground);
    // Whoever draws the scene replaces this shape by the picture.
    let shape = painter.add(Shape::Noop);
    let inside = rect.shrink(tokens.line_width);
    let clip_rect = ui.clip_rect();
    let layer = ui.layer_id();
    cx.frame.camera_preview = Some(CameraPreview { rect: inside, clip_rect, layer, shape, sight });
    let middle = rect.center();
    for (colour, width) in [(tokens.ground, 4.0), (tokens.accent, 2.0)] {
        for ahead in [Vec2::X, -Vec2::X, Vec2::Y, -Vec2::Y] {
            let ends = [middle + ahead * CROSS[1], middle + ahead * CROSS[0]];
            painter.line_segment(ends, Stroke::new(width, colour));
        }
    }
    painter.rect_stroke(rect, radius, tokens.border(), StrokeKind::Inside);
    let check = cx.frame.sight_check.filter(|check| check.sight == sight);
    let (sentence, is_clear) = match check.map(|check| check.blocked_m) {
        _ if !sight.is_tilt_possible => (texts::TILT_IMPOSSIBLE.to_owned(), false),
        Some(Some(blocked_m)) => (texts::blocked(blocked_m), false),
        Some(None) => (texts::clear(sight.distance_m), true),
        None => (texts::UNCHECKED.to_owned(), true),
    };
    widgets::status_node(&response, texts::SIGHT, &sentence);
    let colour = if is_clear { tokens.good } else { tokens.bad };
    widgets::tinted_box(ui, tokens, colour, |ui| widgets::sentence(ui, tokens, &sentence));
}
