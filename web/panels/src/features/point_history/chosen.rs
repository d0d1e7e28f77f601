//! The chosen result and the one that it is compared with, small, in the side card.

use super::compare::{Comparison, show_keep, show_steps};
use super::side::{Side, sides};
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::features::runs::{CommonAxes, outside, paint_file, reading, reading_name, viewable};
use crate::paint::focus_ring;
use crate::widgets::{self, fact_with_note};
use crate::{icon, theme};
use client_model::PointResult;
use egui::{Id, Role, Sense, Ui, WidgetInfo, vec2};
use missions::SiteZone;

/// Height of a small picture, points.
const PICTURE_HEIGHT: f32 = 112.0;
/// Distance of the two small pictures, points.
const PICTURE_GAP: f32 = 8.0;

/// Shows both results. A press on a picture opens the comparison.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, zone: &SiteZone, comparison: &mut Comparison) {
    let tokens = cx.tokens;
    let model = cx.model;
    let sides = sides(model);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        show_steps(ui, cx);
        show_keep(ui, cx);
    });
    let panes: Vec<_> = sides.iter().flatten().filter_map(|side| side.pane(cx, zone)).collect();
    let axes = CommonAxes::of(cx, &panes);
    if !panes.is_empty() {
        let width = 0.5 * (ui.available_width() - PICTURE_GAP);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = PICTURE_GAP;
            for side in sides.iter().flatten() {
                if show_picture(ui, cx, side, zone, axes, width) {
                    comparison.open();
                }
            }
        });
        let compare = Button::new(texts::COMPARE).icon(icon::SQUARE_HALF).kind(Kind::Primary);
        if compare.wide(ui).show(ui, tokens).clicked() {
            comparison.open();
        }
    }
    for side in sides.iter().flatten() {
        widgets::sentence(ui, tokens, &side.caption(cx, zone));
        widgets::remark(ui, tokens, &side.facts(cx, zone));
        show_readings(ui, cx, side.result);
    }
    if let Some(later) = &sides[1]
        && let Some(sentence) = texts::compared(later.result)
    {
        if later.result.changes() > 0 {
            widgets::tinted_box(ui, tokens, tokens.warn, |ui| widgets::sentence(ui, tokens, &sentence));
        } else {
            widgets::remark(ui, tokens, &sentence);
        }
    }
    let [earlier, later] = &sides;
    if let (None, Some(_)) = (earlier, later) {
        widgets::remark(ui, tokens, texts::NOTHING_BEFORE);
    }
}

/// A small picture or spectrum. Returns whether it was pressed.
fn show_picture(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    side: &Side<'_>,
    zone: &SiteZone,
    axes: CommonAxes,
    width: f32,
) -> bool {
    let (rect, _) = ui.allocate_exact_size(vec2(width, PICTURE_HEIGHT), Sense::hover());
    let Some((file, kind)) = side.result.report.as_ref().and_then(viewable) else { return false };
    let response = ui.interact(rect, Id::unique(("small picture", side.letter)), Sense::click());
    let name = texts::small_picture(side.letter, zone.to_local(side.result.at));
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    if ui.is_rect_visible(rect) {
        let tokens = cx.tokens;
        paint_file(ui, cx, (file.blob, kind), axes, rect);
        let border = if response.hovered() { tokens.accent } else { tokens.line };
        let radius = f32::from(theme::BUTTON_RADIUS);
        ui.painter().rect_stroke(rect, radius, (tokens.line_width, border), egui::StrokeKind::Inside);
        if response.has_focus() {
            focus_ring(ui, rect, tokens);
        }
    }
    response.on_hover_cursor(egui::CursorIcon::ZoomIn).clicked()
}

/// The readings of a result, with what is wrong with them.
fn show_readings(ui: &mut Ui, cx: &PanelContext<'_>, result: &PointResult) {
    let history = &cx.model.point_history;
    for found in result.report.iter().flat_map(|report| &report.readings) {
        let is_it =
            |series: &&client_model::ReadingSeries| series.name == found.name && series.unit == found.unit;
        let series = history.series().iter().find(is_it);
        let value = series.and_then(|series| series.value_of(result.number));
        let note = match value {
            Some(value) if value.outside.is_some() => {
                value.outside.map(|of| (outside(of, &found.unit), cx.tokens.bad))
            }
            Some(value) if value.is_anomaly => Some((texts::UNUSUAL.to_lowercase(), cx.tokens.warn)),
            _ => None,
        };
        let note = note.as_ref().map(|(note, colour)| (note.as_str(), *colour));
        fact_with_note(ui, cx.tokens, &reading_name(&found.name), &reading(found), note);
    }
}
