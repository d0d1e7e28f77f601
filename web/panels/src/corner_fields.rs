//! The corners of an area as numbers, so that keys and fingers move them as drags do.

use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::icon;
use crate::number_field::{NumberField, TypedNumber};
use crate::texts;
use egui::Ui;
use site_model::ObjectId;

/// Coordinates that people may enter, m.
const RANGE_M: [f64; 2] = [-100_000.0, 100_000.0];
/// Fewest corners of an area.
const MIN_CORNERS: usize = 3;

/// Shows two fields for each corner of an area of `object`, and what adds or removes one. Returns the corners once they are changed.
pub(crate) fn show(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    object: ObjectId,
    corners_m: &[[f64; 2]],
) -> Option<Vec<[f64; 2]>> {
    let tokens = cx.tokens;
    let mut corners = corners_m.to_vec();
    for (index, corner) in corners_m.iter().enumerate() {
        for axis in [0, 1] {
            let name = texts::coordinate(index + 1, axis);
            let value = Some(corner[axis]);
            let field =
                NumberField { name: &name, object, value, hint: "", step: 0.1, decimals: 2, range: RANGE_M };
            if let Some(value) = field.show(ui, cx, typed).flatten() {
                corners[index][axis] = value;
            }
        }
        let name = texts::remove_corner(index + 1);
        let button = Button::new(&name).icon(icon::X).kind(Kind::Quiet).wide(ui);
        if button.enabled(corners_m.len() > MIN_CORNERS).show(ui, tokens).clicked() {
            corners.remove(index);
        }
    }
    if Button::new(texts::ADD_CORNER).icon(icon::PLUS).wide(ui).show(ui, tokens).clicked()
        && let (Some(first), Some(last)) = (corners.first().copied(), corners.last().copied())
    {
        // In the middle of the last side, from where it is moved.
        corners.push([0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1])]);
    }
    (corners != corners_m).then_some(corners)
}
