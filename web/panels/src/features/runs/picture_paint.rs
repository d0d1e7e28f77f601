//! What is drawn of a picture: the picture itself, temperatures that are read in it, and their scale.

use super::texts;
use crate::theme::{self, Tokens, Weight, font};
use crate::thermal::{self, Scale};
use egui::{Align2, Color32, Rect, Ui, pos2, vec2};

/// A picture, of which the part within `clip` is seen.
pub(super) fn paint_picture(ui: &Ui, texture: egui::TextureId, picture: Rect, clip: Rect) {
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter_at(clip).image(texture, picture, whole, Color32::WHITE);
}

/// A sentence in the middle of a place.
pub(crate) fn show_note(ui: &Ui, tokens: &Tokens, rect: Rect, sentence: &str) {
    let room = (rect.width() - 48.0).max(80.0);
    let galley =
        ui.painter().layout(sentence.to_owned(), font(theme::BODY, Weight::Regular), tokens.dim, room);
    ui.painter().galley(rect.center() - 0.5 * galley.size(), galley, tokens.dim);
}

/// A cross with a temperature beside it, legible on every colour.
pub(super) fn paint_marker(ui: &Ui, clip: Rect, at: egui::Pos2, text: &str) {
    let painter = ui.painter_at(clip);
    for (width, colour) in [(4.0, Color32::from_black_alpha(200)), (1.5, Color32::WHITE)] {
        painter.line_segment([at - vec2(8.0, 0.0), at + vec2(8.0, 0.0)], (width, colour));
        painter.line_segment([at - vec2(0.0, 8.0), at + vec2(0.0, 8.0)], (width, colour));
    }
    let galley = painter.layout_no_wrap(text.to_owned(), font(theme::SMALL, Weight::Medium), Color32::WHITE);
    let is_right = at.x + galley.size().x + 30.0 < clip.right();
    let left = if is_right { at.x + 14.0 } else { at.x - galley.size().x - 14.0 };
    let label = Rect::from_min_size(pos2(left, at.y - 0.5 * galley.size().y), galley.size());
    painter.rect_filled(label.expand2(vec2(6.0, 3.0)), 4.0, Color32::from_black_alpha(190));
    painter.galley(label.min, galley, Color32::WHITE);
}

/// The axis and the tip of a needle, as rings, so that people see the needle itself between them.
pub(super) fn paint_needle(ui: &Ui, tokens: &Tokens, clip: Rect, ends: [egui::Pos2; 2]) {
    let painter = ui.painter_at(clip);
    for (at, radius) in ends.into_iter().zip([5.0, 8.0]) {
        for (width, colour) in [(4.0, Color32::from_black_alpha(200)), (2.0, tokens.accent)] {
            painter.circle_stroke(at, radius, (width, colour));
        }
    }
}

/// The colours with their temperatures, and a mark at the one that is read.
pub(super) fn paint_scale(ui: &Ui, tokens: &Tokens, rect: Rect, scale: Scale, read: Option<f64>) {
    let painter = ui.painter();
    let bar = rect.with_max_x(rect.left() + 14.0);
    let rows = bar.height().max(1.0) as usize;
    for row in 0..rows {
        let share = 1.0 - row as f64 / rows as f64;
        let y = bar.top() + row as f32;
        let line = Rect::from_min_max(pos2(bar.left(), y), pos2(bar.right(), y + 1.5));
        painter.rect_filled(line, 0.0, thermal::colour(share));
    }
    let y_of = |celsius: f64| {
        let share = (celsius - scale.lowest) / (scale.highest - scale.lowest).max(f64::EPSILON);
        bar.bottom() - share.clamp(0.0, 1.0) as f32 * bar.height()
    };
    let small = font(theme::SMALL, Weight::Regular);
    for part in 0..=4 {
        let celsius = scale.lowest + f64::from(part) * 0.25 * (scale.highest - scale.lowest);
        let at = pos2(bar.right() + 6.0, y_of(celsius));
        painter.text(at, Align2::LEFT_CENTER, texts::celsius(celsius), small.clone(), tokens.dim);
    }
    if let Some(celsius) = read {
        let y = y_of(celsius);
        let mark = [pos2(bar.left() - 3.0, y), pos2(bar.right() + 3.0, y)];
        painter.line_segment(mark, (2.0, tokens.text));
    }
}
