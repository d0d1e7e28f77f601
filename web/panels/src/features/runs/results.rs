//! Results of a task under its row, in the run under way and in ended ones: pictures, spectra, readings and files.

use super::lightbox::{Lightbox, open_blob};
use super::pane::CommonAxes;
use super::result_view::ResultView;
use super::{spectrum, texts};
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::paint::focus_ring;
use crate::result_files::ResultFile;
use crate::widgets::{self, fact_with_note};
use crate::{icon, theme};
use client_model::{ClientCommand, PointHistoryCommand, ResultFileKind, StoredResult};
use egui::{Color32, Id, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use site_model::{ActionReport, InspectionPointId, MissionId, RunId};
use vocab::BlobHash;

/// Height of a picture in the list, points.
const PICTURE_HEIGHT: f32 = 168.0;
/// Height of a spectrum in the list, points.
const SPECTRUM_HEIGHT: f32 = 96.0;

/// The task to which results belong.
pub(super) struct TaskOfRun<'a> {
    pub(super) run: RunId,
    pub(super) mission: MissionId,
    /// Name of its place.
    pub(super) title: &'a str,
    /// What was done.
    pub(super) action: &'a str,
}

/// Shows results of a task.
pub(super) fn show_results<'a>(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    task: &TaskOfRun<'_>,
    results: impl Iterator<Item = &'a StoredResult>,
    lightbox: &mut Lightbox,
) {
    for result in results {
        let result_view = ResultView::of(task.title, task.action, result);
        if let Some(result_view) = &result_view
            && show_exhibit(ui, cx, result_view)
        {
            lightbox.look_at(task.run, task.mission, result.number);
        }
        if let Some(report) = result.report() {
            show_report(ui, cx, task.title, result, &report, result_view.as_ref());
        }
        if let Some(point) = result.details.inspection_point {
            show_history_button(ui, cx, task.title, result, point);
        }
    }
}

/// The button that leads to all results at an inspection point.
fn show_history_button(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    title: &str,
    result: &StoredResult,
    point: InspectionPointId,
) {
    let name = texts::point_history(title);
    let button = Button::new(&name).text(texts::POINT_HISTORY).icon(icon::CLOCK).kind(Kind::Quiet).left();
    let button = button.wide(ui);
    if ui.push_id(("history", result.number), |ui| button.show(ui, cx.tokens)).inner.clicked() {
        cx.commands.push(ClientCommand::PointHistory(PointHistoryCommand::Open(point)));
        cx.commands.push(ClientCommand::PointHistory(PointHistoryCommand::Choose(result.number)));
    }
}

/// A picture or a spectrum over the width of the card. Returns whether it was pressed.
fn show_exhibit(ui: &mut Ui, cx: &mut PanelContext<'_>, result_view: &ResultView) -> bool {
    let tokens = cx.tokens;
    let height = if result_view.kind == ResultFileKind::Spectrum { SPECTRUM_HEIGHT } else { PICTURE_HEIGHT };
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    let response = ui.interact(rect, Id::unique(("result_view", result_view.result.number)), Sense::click());
    let name = texts::show_file(&result_view.file.name, &result_view.title);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    if ui.is_rect_visible(rect) {
        let radius = f32::from(theme::BUTTON_RADIUS);
        paint_file(ui, cx, (result_view.file.blob, result_view.kind), CommonAxes::default(), rect);
        let border = if response.hovered() { tokens.accent } else { tokens.line };
        ui.painter().rect_stroke(rect, radius, (tokens.line_width, border), egui::StrokeKind::Inside);
        if response.has_focus() {
            focus_ring(ui, rect, tokens);
        }
    }
    response.on_hover_cursor(egui::CursorIcon::ZoomIn).clicked()
}

/// Paints a picture or a spectrum small, so that it fills a place. `axes`: what it shares with others.
pub(crate) fn paint_file(
    ui: &Ui,
    cx: &mut PanelContext<'_>,
    (blob, kind): (BlobHash, ResultFileKind),
    axes: CommonAxes,
    rect: Rect,
) {
    let (tokens, radius) = (cx.tokens, f32::from(theme::BUTTON_RADIUS));
    ui.painter().rect_filled(rect, radius, tokens.raised);
    match cx.files.get(blob, kind) {
        ResultFile::Loading => {}
        ResultFile::Failed(sentence) => {
            let room = (rect.width() - 24.0).max(40.0);
            let small = theme::font(theme::SMALL, theme::Weight::Regular);
            let galley = ui.painter().layout(sentence.clone(), small, tokens.dim, room);
            ui.painter().galley(rect.center() - 0.5 * galley.size(), galley, tokens.dim);
        }
        ResultFile::Picture(texture) => paint_cropped(ui, texture.id(), texture.size_vec2(), rect, radius),
        ResultFile::Thermal(picture) => {
            let scale = axes.scale_of(picture);
            let texture = picture.texture(ui.ctx(), scale);
            paint_cropped(ui, texture.id(), texture.size_vec2(), rect, radius);
        }
        ResultFile::Spectrum(found) => spectrum::paint_small(ui, tokens, rect, found),
    }
}

/// The middle of a picture, so that it fills a place.
fn paint_cropped(ui: &Ui, texture: egui::TextureId, size: egui::Vec2, rect: Rect, radius: f32) {
    let share = rect.size() / (size * (rect.size() / size).max_elem());
    let uv = Rect::from_center_size(pos2(0.5, 0.5), share);
    let image = egui::epaint::RectShape::filled(rect, radius, Color32::WHITE).with_texture(texture, uv);
    ui.painter().add(image);
}

/// Readings with their units, and files that are not drawn, each of which opens in a tab of its own.
fn show_report(
    ui: &mut Ui,
    cx: &PanelContext<'_>,
    title: &str,
    result: &StoredResult,
    report: &ActionReport,
    result_view: Option<&ResultView>,
) {
    let (tokens, site) = (cx.tokens, cx.model.site.site());
    for reading in &report.readings {
        let point = result.details.inspection_point.and_then(|point| site?.inspection_point(point));
        let outside = point.and_then(|point| point.limits.as_ref()?.outside(reading));
        let note = outside.map(|outside| texts::outside(outside, &reading.unit));
        let note = note.as_deref().map(|note| (note, tokens.bad));
        fact_with_note(ui, tokens, &texts::reading_name(&reading.name), &texts::reading(reading), note);
    }
    if let Some(problem) = report.gauge.as_ref().and_then(|gauge| gauge.problem.as_ref()) {
        widgets::remark(ui, tokens, problem);
    }
    // What is drawn is opened from there.
    for file in report.files.iter().filter(|_| result_view.is_none()) {
        let name = texts::open_file(&file.name, title);
        let text = texts::file(&file.name, file.bytes);
        let button = Button::new(&name).text(&text).icon(icon::EYE).left().wide(ui);
        if ui.push_id((result.number, &file.name), |ui| button.show(ui, tokens)).inner.clicked() {
            open_blob(ui, file);
        }
    }
}
