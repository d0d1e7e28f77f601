//! Describes the gauge of an inspection point: four marks in one of its photos, and the values at the ends of the scale. From then on the robot reads its needle in each photo.
//!
//! | part | where |
//! | --- | --- |
//! | the draft: what is marked and entered, and the dial that follows from it | `gauge_draft.rs` |
//! | the card with the photo and the form | here |

use super::gauge_draft::{GaugeDraft, MARKS};
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::features::runs::{
    CommonAxes, Pane, PictureView, follow, paint_ground, paint_pane, place_of_px, px_at, viewable,
};
use crate::number_field::{NumberField, TypedNumber};
use crate::paint::focus_ring;
use crate::result_files::ResultFile;
use crate::select::select;
use crate::theme::{self, GAP, Weight};
use crate::{Width, icon, layout, screens, widgets};
use client_model::{ClientCommand, PointResult, ResultFileKind};
use egui::{
    Align, Color32, Context, EventFilter, Id, Key, Layout, Order, Pos2, Rect, Role, Sense, Stroke, Ui,
    UiBuilder, WidgetInfo, pos2, vec2,
};
use site_model::{GaugeDial, InspectionPoint, ObjectId};

/// Width of the form, points.
const FORM_WIDTH: f32 = 320.0;
/// Height of the form below the photo on narrow windows, points.
const FORM_HEIGHT: f32 = 420.0;
/// Side of the square in which a mark is grabbed, points: a finger.
const GRAB: f32 = 36.0;
/// Pixels by which an arrow key moves a mark. With Shift it is ten times that.
const KEY_STEP_PX: f64 = 1.0;
/// Values that people may enter.
const VALUE_RANGE: [f64; 2] = [-1e9, 1e9];

/// What the editor keeps between frames.
#[derive(Debug, Default)]
pub(super) struct GaugeEditor {
    draft: Option<GaugeDraft>,
    view: PictureView,
    typed: TypedNumber,
}

/// The part of the side card: what became of the gauge in the chosen photo, and the button that opens the editor.
pub(super) fn show_section(ui: &mut Ui, cx: &mut PanelContext<'_>, editor: &mut GaugeEditor) {
    let model = cx.model;
    let history = &model.point_history;
    let (Some(point), Some(later)) = (history.point(), history.later()) else { return };
    let Some(point) = model.site.site().and_then(|site| site.inspection_point(point)) else { return };
    if !shows_gauge(later) {
        return;
    }
    widgets::section_head(ui, cx.tokens, texts::GAUGE_HEAD);
    if let Some(problem) = later.report.as_ref().and_then(|report| report.gauge.as_ref()?.problem.as_ref()) {
        widgets::tinted_box(ui, cx.tokens, cx.tokens.warn, |ui| {
            widgets::sentence(ui, cx.tokens, problem);
        });
    }
    let (name, remark) = match &point.gauge {
        Some(dial) => (texts::CHANGE_GAUGE, texts::gauge(dial)),
        None => (texts::DESCRIBE_GAUGE, texts::NO_GAUGE.to_owned()),
    };
    if Button::new(name).icon(icon::PENCIL_SIMPLE).wide(ui).show(ui, cx.tokens).clicked() {
        editor.open(cx, point, later);
    }
    widgets::remark(ui, cx.tokens, &remark);
}

/// Whether a result has a photo: gauges are read in nothing else.
fn shows_gauge(result: &PointResult) -> bool {
    let file = result.report.as_ref().and_then(viewable);
    result.kind == "photo" && file.is_some_and(|(_, kind)| kind == ResultFileKind::Picture)
}

impl GaugeEditor {
    /// Opens it with the photo in which the gauge was described, or with the chosen one.
    fn open(&mut self, cx: &mut PanelContext<'_>, point: &InspectionPoint, result: &PointResult) {
        let Some(report) = &result.report else { return };
        let Some((file, _)) = viewable(report) else { return };
        let size_px = report.camera.as_ref().map(|camera| camera.size_px);
        let described_in = |result: &&PointResult| {
            let files = result.report.iter().flat_map(|report| &report.files);
            point.gauge.as_ref().is_some_and(|dial| files.into_iter().any(|file| file.blob == dial.picture))
        };
        let known = cx.model.point_history.results().iter().find(described_in);
        let known = known.and_then(|result| viewable(result.report.as_ref()?)).map(|(file, _)| file);
        self.draft = Some(match (known, &point.gauge) {
            (Some(file), Some(dial)) => GaugeDraft::of(point.id, file, dial),
            (_, dial) => GaugeDraft::new(point.id, file, size_px, dial.as_ref()),
        });
        self.view = PictureView::default();
        self.typed = TypedNumber::default();
    }

    /// Closes it. Returns whether it was open.
    pub(super) fn close(&mut self) -> bool {
        self.draft.take().is_some()
    }

    /// Takes keys from the frame while it is open.
    pub(super) fn update(&mut self, cx: &mut PanelContext<'_>) {
        let is_same = |draft: &GaugeDraft| cx.model.point_history.point() == Some(draft.point);
        if cx.screen() != screens::RUNS || !self.draft.as_ref().is_some_and(is_same) {
            self.draft = None;
        }
        cx.frame.is_covered |= self.draft.is_some();
    }

    /// Shows it over everything but the top bar.
    pub(super) fn show(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        let Some(mut draft) = self.draft.take() else { return };
        // Whether or not Escape has just closed it, it was meant for that.
        cx.frame.is_escape_consumed = true;
        let window = ctx.content_rect();
        let min = pos2(window.left() + GAP, cx.layout.top.bottom() + GAP);
        let rect = Rect::from_min_max(min, window.max - vec2(GAP, GAP));
        let mut is_open = true;
        layout::area(texts::GAUGE_CARD, Order::Foreground).fixed_pos(rect.min).show(ctx, |ui| {
            theme::card(cx.tokens).fill(cx.tokens.card.to_opaque()).show(ui, |ui| {
                let frame = egui::Vec2::splat(2.0 * (f32::from(theme::PADDING) + cx.tokens.line_width));
                ui.set_min_size(rect.size() - frame);
                ui.set_max_size(rect.size() - frame);
                is_open = self.show_content(ui, cx, &mut draft);
            });
        });
        self.draft = is_open.then_some(draft);
    }

    /// Returns whether it stays open.
    fn show_content(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, draft: &mut GaugeDraft) -> bool {
        let is_closed = show_head(ui, cx, draft);
        let room = ui.available_rect_before_wrap();
        let (picture, form) = match cx.layout.width {
            Width::Narrow => room.split_top_bottom_at_y(room.bottom() - FORM_HEIGHT.min(0.6 * room.height())),
            _ => room.split_left_right_at_x(room.right() - FORM_WIDTH),
        };
        self.show_picture(ui, cx, draft, picture.shrink2(vec2(0.0, 4.0)));
        let mut form_ui = ui.new_child(UiBuilder::new().max_rect(form.shrink2(vec2(12.0, 4.0))));
        let is_done = egui::ScrollArea::vertical()
            .id_salt("form of a gauge")
            .show(&mut form_ui, |ui| self.show_form(ui, cx, draft))
            .inner;
        !is_closed && !is_done
    }

    /// The photo with the marks. A press sets the mark that is missing next.
    fn show_picture(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, draft: &mut GaugeDraft, rect: Rect) {
        let pane = Pane {
            file: draft.file.clone(),
            kind: ResultFileKind::Picture,
            caption: String::new(),
            needle: None,
            aligned: None,
            changes: None,
        };
        let response = ui.interact(rect, ui.scope_id().with("photo of a gauge"), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, texts::GAUGE_PHOTO));
        paint_ground(ui, cx, rect);
        follow(ui, cx, &pane, rect, &response, &mut self.view);
        paint_pane(ui, cx, &pane, rect, CommonAxes::default(), &self.view, None);
        let ResultFile::Picture(texture) = cx.files.get(pane.file.blob, pane.kind) else { return };
        let size = texture.size_vec2();
        let size_px = *draft.size_px.get_or_insert([size.x as u32, size.y as u32]);
        let shown = self.view.picture_rect(rect, size);
        paint_scale_arc(ui, cx, draft, |px| place_of_px(px, shown, size_px), rect);
        for index in 0..MARKS.len() {
            if let Some(px) = draft.mark(index) {
                let moved = show_mark(ui, cx, index, px, (shown, size_px), rect);
                if let Some(px) = moved {
                    draft.set_mark(index, px);
                }
            }
        }
        let pressed = response.interact_pointer_pos().filter(|_| response.clicked());
        if let (Some(at), Some(next)) = (pressed, draft.next_mark()) {
            draft.set_mark(next, px_at(at, shown, size_px));
        }
    }

    /// What is entered, and the buttons. Returns whether the editor is done.
    fn show_form(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, draft: &mut GaugeDraft) -> bool {
        let tokens = cx.tokens;
        ui.spacing_mut().item_spacing.y = 8.0;
        widgets::tinted_box(ui, tokens, tokens.accent, |ui| {
            widgets::sentence(ui, tokens, texts::mark_hint(draft.next_mark()));
        });
        let again = Button::new(texts::MARK_AGAIN).icon(icon::ARROW_COUNTER_CLOCKWISE);
        if again.enabled(draft.mark(0).is_some()).wide(ui).show(ui, tokens).clicked() {
            draft.clear_marks();
        }
        widgets::choice(ui, tokens, &texts::TURNS, draft.is_full_turn, |chosen| draft.is_full_turn = chosen);
        // Of a scale with two ends, the middle says which way it goes.
        if draft.is_full_turn {
            widgets::choice(ui, tokens, &texts::DIRECTIONS, draft.direction, |chosen| {
                draft.direction = chosen
            });
        }
        for (index, name) in texts::VALUES.into_iter().enumerate() {
            let (object, value) = (ObjectId::InspectionPoint(draft.point), draft.range[index]);
            let field =
                NumberField { name, object, value, hint: "", step: 1.0, decimals: 2, range: VALUE_RANGE };
            if let Some(value) = field.show(ui, cx, &mut self.typed) {
                draft.range[index] = value;
            }
        }
        let mut units: Vec<String> = texts::UNITS.iter().map(|unit| (*unit).to_owned()).collect();
        if !draft.unit.is_empty() && !units.contains(&draft.unit) {
            units.insert(0, draft.unit.clone());
        }
        let shown = if draft.unit.is_empty() { texts::CHOOSE_UNIT } else { &draft.unit };
        if let Some(index) = select(ui, tokens, texts::UNIT, texts::UNIT, shown, &units) {
            draft.unit.clone_from(&units[index]);
        }
        let dial = draft.dial();
        if let Err(missing) = &dial {
            widgets::remark(ui, tokens, &texts::missing(missing));
        }
        let save = Button::new(texts::SAVE_GAUGE).icon(icon::CHECK).kind(Kind::Primary).enabled(dial.is_ok());
        if save.wide(ui).show(ui, tokens).clicked()
            && let Ok(dial) = dial
        {
            put(cx, draft, Some(dial));
            return true;
        }
        widgets::remark(ui, tokens, texts::GAUGE_REMARK);
        let site = cx.model.site.site();
        let has_gauge = site.and_then(|site| site.inspection_point(draft.point)?.gauge.as_ref()).is_some();
        let remove = Button::new(texts::REMOVE_GAUGE).icon(icon::TRASH).kind(Kind::Danger);
        if has_gauge && remove.wide(ui).show(ui, tokens).clicked() {
            put(cx, draft, None);
            return true;
        }
        false
    }
}

/// Puts the description into the site: one edit, which can be undone.
fn put(cx: &mut PanelContext<'_>, draft: &GaugeDraft, dial: Option<GaugeDial>) {
    let edit = cx.model.site.changing_inspection_point(draft.point, |point| point.gauge = dial);
    cx.commands.push(ClientCommand::EditSite(edit));
}

/// The name of the point, and the button that closes. Returns whether that was pressed.
fn show_head(ui: &mut Ui, cx: &PanelContext<'_>, draft: &GaugeDraft) -> bool {
    let tokens = cx.tokens;
    let site = cx.model.site.site();
    let point = site.and_then(|site| site.inspection_point(draft.point));
    let title = texts::gauge_of(point.map_or(texts::DELETED_POINT, |point| &point.name));
    let mut is_closed = false;
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let close = Button::icon_only(texts::CLOSE_GAUGE, icon::X).kind(Kind::Quiet);
            is_closed = close.show(ui, tokens).clicked();
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let part = (title.as_str(), theme::LARGE, Weight::SemiBold, tokens.text);
                widgets::status_line(ui, texts::GAUGE_HEAD, &title, &[part]);
            });
        });
    });
    is_closed
}

/// A mark that is dragged, or moved by arrow keys. Returns where it is now, if it has moved.
fn show_mark(
    ui: &Ui,
    cx: &PanelContext<'_>,
    index: usize,
    px: [f64; 2],
    (shown, size_px): (Rect, [u32; 2]),
    clip: Rect,
) -> Option<[f64; 2]> {
    let at = place_of_px(px, shown, size_px);
    let grab = Rect::from_center_size(at, egui::Vec2::splat(GRAB));
    let response = ui.interact(grab, Id::unique(("mark of a gauge", index)), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, MARKS[index]));
    response.ctx.accesskit_node_builder(response.id, |node| node.set_value(texts::pixels(px)));
    paint_mark(ui, index, at, clip);
    if response.has_focus() {
        focus_ring(ui, grab, cx.tokens);
    }
    let dragged = response.interact_pointer_pos().filter(|_| response.dragged());
    let moved = dragged.map(|at| px_at(at, shown, size_px)).or_else(|| moved_by_keys(ui, &response, px));
    response.on_hover_cursor(egui::CursorIcon::Grab);
    moved
}

/// Where arrow keys move a mark that has the focus.
fn moved_by_keys(ui: &Ui, response: &egui::Response, px: [f64; 2]) -> Option<[f64; 2]> {
    if !response.has_focus() {
        return None;
    }
    let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    let step = ui.input(|input| {
        let pressed = |key| f64::from(input.num_presses(key) as u32);
        let factor = if input.modifiers.shift { 10.0 } else { 1.0 };
        [
            factor * (pressed(Key::ArrowRight) - pressed(Key::ArrowLeft)),
            factor * (pressed(Key::ArrowDown) - pressed(Key::ArrowUp)),
        ]
    });
    (step != [0.0; 2]).then(|| [px[0] + KEY_STEP_PX * step[0], px[1] + KEY_STEP_PX * step[1]])
}

/// A cross in a ring, with the name of the mark, legible on every colour.
fn paint_mark(ui: &Ui, index: usize, at: Pos2, clip: Rect) {
    let painter = ui.painter_at(clip);
    let (dark, light) = (Color32::from_black_alpha(200), Color32::WHITE);
    for (width, colour) in [(4.0, dark), (1.5, light)] {
        painter.circle_stroke(at, 9.0, Stroke::new(width, colour));
        for arm in [vec2(9.0, 0.0), vec2(0.0, 9.0)] {
            painter.line_segment([at - arm, at + arm], Stroke::new(width, colour));
        }
    }
    let label = texts::SHORT_MARKS[index];
    let galley =
        painter.layout_no_wrap(label.to_owned(), theme::font(theme::SMALL, Weight::Medium), Color32::WHITE);
    let place = Rect::from_min_size(at + vec2(14.0, -0.5 * galley.size().y), galley.size());
    painter.rect_filled(place.expand2(vec2(6.0, 3.0)), 4.0, Color32::from_black_alpha(190));
    painter.galley(place.min, galley, Color32::WHITE);
}

/// The scale from its lower to its upper end, so that people see what their marks mean.
fn paint_scale_arc(
    ui: &Ui,
    cx: &PanelContext<'_>,
    draft: &GaugeDraft,
    place: impl Fn([f64; 2]) -> Pos2,
    clip: Rect,
) {
    let arc: Vec<Pos2> = draft.arc_px().into_iter().map(place).collect();
    for (width, colour) in [(5.0, Color32::from_black_alpha(170)), (2.5, cx.tokens.accent)] {
        ui.painter_at(clip).line(arc.clone(), Stroke::new(width, colour));
    }
}
