//! Two results large, over everything but the top bar: side by side, with a divider between them, or in turn at the same place.

use super::alignment::AlignedView;
use super::side::{Side, sides};
use super::strip::{self, Strip, ask, asked_step, holds_arrows, pressed_step};
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::features::runs::{
    CommonAxes, Pane, PictureView, difference, follow, halves, paint_ground, paint_pane, show_caption,
    show_note, show_pane, split_caption,
};
use crate::theme::{self, GAP, Weight};
use crate::{icon, layout, screens, widgets};
use client_model::PointHistoryCommand;
use egui::{
    Align, Color32, Context, Id, Layout, Order, Rect, Sense, Stroke, Ui, UiBuilder, WidgetInfo, pos2, vec2,
};
use missions::SiteZone;
use std::time::Duration;

/// Where the time line is shown.
const STRIP: &str = "large";
/// Time for which each of two pictures is shown while they blink, seconds. Chosen: there and back in a second; a change is seen as a jump, and nothing
/// flashes more than three times a second (WCAG 2.3.1).
const BLINK_S: f64 = 0.5;
/// Share of the width by which an arrow key moves the divider.
const DIVIDER_STEP: f32 = 0.02;
/// Width of the part of the divider that is dragged, points.
const GRIP_WIDTH: f32 = 44.0;
/// Height of the line of facts below a picture, points.
const FACTS_HEIGHT: f32 = 24.0;
/// Height of the time line with the gap above it, points.
const STRIP_HEIGHT: f32 = 74.0;
/// Width of the choice of the view, points.
const MODES_WIDTH: f32 = 360.0;

/// How two pictures are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum CompareMode {
    #[default]
    SideBySide,
    /// One left of a divider, the other right of it.
    Wipe,
    /// One after the other at the same place.
    Blink,
}

/// The views, with their names.
const MODES: [(&str, CompareMode); 3] = [
    (texts::SIDE_BY_SIDE, CompareMode::SideBySide),
    (texts::WIPE, CompareMode::Wipe),
    (texts::BLINK, CompareMode::Blink),
];

/// What the comparison keeps between frames.
#[derive(Debug, Default)]
pub(super) struct Comparison {
    is_open: bool,
    mode: CompareMode,
    view: PictureView,
    divider: Divider,
    aligned: AlignedView,
    blink: Blink,
    strip: Strip,
}

/// Where the divider is.
#[derive(Debug)]
struct Divider {
    /// Share of the width, 0 to 1.
    share: f32,
}

impl Default for Divider {
    fn default() -> Self {
        Self { share: 0.5 }
    }
}

/// Which of two pictures is shown.
#[derive(Debug, Default)]
struct Blink {
    /// Whether the later one is.
    is_later: bool,
    /// Whether an operator has stopped or started it; none: as the system asks.
    is_running: Option<bool>,
    /// Time of the page at which it changes, seconds.
    next_s: f64,
}

impl Comparison {
    /// Opens it.
    pub(super) fn open(&mut self) {
        self.is_open = true;
        self.view = PictureView::default();
    }

    /// Closes it. Returns whether it was open.
    pub(super) fn close(&mut self) -> bool {
        std::mem::take(&mut self.is_open)
    }

    /// Takes keys from the frame while it is open.
    pub(super) fn update(&mut self, cx: &mut PanelContext<'_>) {
        self.is_open &= cx.screen() == screens::RUNS && cx.model.point_history.later().is_some();
        cx.frame.is_covered |= self.is_open;
    }

    /// Shows it.
    pub(super) fn show(&mut self, ctx: &Context, cx: &mut PanelContext<'_>, zone: &SiteZone) {
        if !self.is_open {
            return;
        }
        // Whether or not Escape has just closed it, it was meant for that.
        cx.frame.is_escape_consumed = true;
        let window = ctx.content_rect();
        let min = pos2(window.left() + GAP, cx.layout.top.bottom() + GAP);
        let rect = Rect::from_min_max(min, window.max - vec2(GAP, GAP));
        layout::area(texts::CARD, Order::Foreground).fixed_pos(rect.min).show(ctx, |ui| {
            theme::card(cx.tokens).fill(cx.tokens.card.to_opaque()).show(ui, |ui| {
                let inside =
                    rect.size() - egui::Vec2::splat(2.0 * (f32::from(theme::PADDING) + cx.tokens.line_width));
                ui.set_min_size(inside);
                ui.set_max_size(inside);
                self.show_content(ui, cx, zone);
            });
        });
    }

    fn show_content(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, zone: &SiteZone) {
        let sides = sides(cx.model);
        self.show_head(ui, cx);
        self.show_modes(ui, cx);
        let height = (ui.available_height() - FACTS_HEIGHT - STRIP_HEIGHT - 12.0).max(80.0);
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
        let mut panes: [Option<Pane>; 2] = sides.each_ref().map(|side| side.as_ref()?.pane(cx, zone));
        self.aligned.apply(cx, &mut panes);
        let axes = CommonAxes::of(cx, panes.iter().flatten());
        match (self.mode, panes) {
            (CompareMode::Wipe, [Some(a), Some(b)]) => self.show_wipe(ui, cx, [&a, &b], rect, axes),
            (CompareMode::Blink, [Some(a), Some(b)]) => self.show_blink(ui, cx, [&a, &b], rect, axes),
            (_, panes) => self.show_beside(ui, cx, (&sides, &panes), rect, axes),
        }
        show_facts(ui, cx, &sides, zone);
        ui.add_space(4.0);
        self.strip.show(ui, cx, zone, STRIP);
        // Arrow keys move the divider of a wipe, and else choose the next result. Divider and time line read them themselves while they have the focus.
        let is_read = [divider_id(), strip::id_of(STRIP)]
            .contains(&ui.memory(|memory| memory.focused()).unwrap_or(Id::NULL));
        let step = if is_read { 0 } else { pressed_step(ui) };
        match self.mode {
            CompareMode::Wipe => self.divider.step(step),
            CompareMode::SideBySide | CompareMode::Blink if step != 0 => {
                ask(cx, PointHistoryCommand::Step(step))
            }
            CompareMode::SideBySide | CompareMode::Blink => {}
        }
    }

    /// The name of the point, and the buttons that go on and close.
    fn show_head(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        let history = &cx.model.point_history;
        let site = cx.model.site.site();
        let point = history.point().and_then(|point| site?.inspection_point(point));
        let title = point.map_or(texts::DELETED_POINT, |point| &point.name);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if Button::icon_only(texts::CLOSE, icon::X).kind(Kind::Quiet).show(ui, tokens).clicked() {
                    self.is_open = false;
                }
                let whole = Button::icon_only(texts::WHOLE, icon::CORNERS_OUT).kind(Kind::Quiet);
                if whole.enabled(self.view != PictureView::default()).show(ui, tokens).clicked() {
                    self.view = PictureView::default();
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    show_steps(ui, cx);
                    let part = (title, theme::LARGE, Weight::SemiBold, tokens.text);
                    widgets::status_line(ui, texts::POINT, title, &[part]);
                });
            });
        });
    }

    /// The choice of the view, and what belongs to it.
    fn show_modes(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            ui.scope(|ui| {
                ui.set_max_width(MODES_WIDTH.min(ui.available_width()));
                widgets::choice(ui, tokens, &MODES, self.mode, |mode| self.mode = mode);
            });
            show_keep(ui, cx);
            self.aligned.show(ui, cx);
            if self.mode != CompareMode::Blink {
                return;
            }
            let is_running = self.blink.is_running(cx.is_motion_reduced);
            let (name, sign) = if is_running {
                (texts::STOP_BLINKING, icon::PAUSE)
            } else {
                (texts::BLINK_AGAIN, icon::PLAY)
            };
            if Button::new(name).icon(sign).slim().show(ui, tokens).clicked() {
                self.blink.is_running = Some(!is_running);
            }
            let swap = Button::new(texts::SWAP).icon(icon::ARROWS_DOWN_UP).slim();
            if swap.show(ui, tokens).clicked() {
                self.blink.is_running = Some(false);
                self.blink.is_later = !self.blink.is_later;
            }
        });
    }

    fn show_beside(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        (sides, panes): (&[Option<Side<'_>>; 2], &[Option<Pane>; 2]),
        rect: Rect,
        axes: CommonAxes,
    ) {
        // A single result takes all of the place.
        if let ([None, Some(_)], [_, Some(pane)]) = (sides, panes) {
            return show_pane(ui, cx, pane, rect, axes, &mut self.view);
        }
        for ((side, pane), place) in sides.iter().zip(panes).zip(halves(rect, cx.layout.width)) {
            match (side, pane) {
                (_, Some(pane)) => show_pane(ui, cx, pane, place, axes, &mut self.view),
                (Some(_), None) => show_note(ui, cx.tokens, place, texts::NO_PICTURE),
                (None, None) => show_note(ui, cx.tokens, place, texts::NOTHING_BEFORE),
            }
        }
    }

    fn show_wipe(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        [a, b]: [&Pane; 2],
        place: Rect,
        axes: CommonAxes,
    ) {
        let (line, rect) = split_caption(place);
        let (left_line, right_line) = line.split_left_right_at_fraction(0.5);
        show_caption(ui, cx, left_line, &a.caption);
        show_caption(ui, cx, right_line, &b.caption);
        let response = ui.interact(rect, ui.scope_id().with("wiped pictures"), Sense::click_and_drag());
        paint_ground(ui, cx, rect);
        follow(ui, cx, b, rect, &response, &mut self.view);
        let x = self.divider.show(ui, rect);
        for (pane, part) in [(a, rect.with_max_x(x)), (b, rect.with_min_x(x))] {
            let mut clipped = ui.new_child(UiBuilder::new().max_rect(rect));
            clipped.set_clip_rect(part.intersect(ui.clip_rect()));
            let pointer = response.hover_pos().filter(|at| part.contains(*at));
            paint_pane(&clipped, cx, pane, rect, axes, &self.view, pointer);
        }
        paint_divider(ui, rect, x);
    }

    fn show_blink(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        panes: [&Pane; 2],
        place: Rect,
        axes: CommonAxes,
    ) {
        self.blink.go_on(ui, cx.is_motion_reduced);
        let pane = panes[usize::from(self.blink.is_later)];
        let (line, rect) = split_caption(place);
        show_caption(ui, cx, line, &pane.caption);
        let response = ui.interact(rect, ui.scope_id().with("blinking pictures"), Sense::click_and_drag());
        widgets::status_node(&response, texts::SHOWN, &pane.caption);
        paint_ground(ui, cx, rect);
        follow(ui, cx, pane, rect, &response, &mut self.view);
        paint_pane(ui, cx, pane, rect, axes, &self.view, response.hover_pos());
    }
}

impl Divider {
    /// Moves it by a number of steps to the right.
    fn step(&mut self, steps: i64) {
        self.share = (self.share + steps as f32 * DIVIDER_STEP).clamp(0.0, 1.0);
    }

    /// Lets drags and keys move it. Returns where it is.
    fn show(&mut self, ui: &Ui, rect: Rect) -> f32 {
        let x = rect.left() + self.share * rect.width();
        let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(GRIP_WIDTH, rect.height()));
        let response = ui.interact(grip, divider_id(), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::slider(true, f64::from(100.0 * self.share), texts::DIVIDER));
        response.ctx.accesskit_node_builder(response.id, |node| {
            node.set_min_numeric_value(0.0);
            node.set_max_numeric_value(100.0);
            node.set_value(texts::divider(self.share));
        });
        let keys = if holds_arrows(ui, &response) { pressed_step(ui) } else { 0 };
        self.step(keys + asked_step(ui, &response));
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            self.share = ((pointer.x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
        }
        response.on_hover_cursor(egui::CursorIcon::ResizeHorizontal);
        rect.left() + self.share * rect.width()
    }
}

impl Blink {
    fn is_running(&self, is_motion_reduced: bool) -> bool {
        self.is_running.unwrap_or(!is_motion_reduced)
    }

    /// Changes the picture when it is time, and asks for the frame in which it changes next.
    fn go_on(&mut self, ui: &Ui, is_motion_reduced: bool) {
        if !self.is_running(is_motion_reduced) {
            return;
        }
        let now_s = ui.input(|input| input.time);
        if now_s >= self.next_s {
            self.is_later = !self.is_later;
            self.next_s = now_s + BLINK_S;
        }
        ui.ctx().request_repaint_after(Duration::from_secs_f64((self.next_s - now_s).max(0.0)));
    }
}

/// Id of the divider in the focus.
fn divider_id() -> Id {
    Id::unique("divider of pictures")
}

/// The line between both pictures, legible on every colour.
fn paint_divider(ui: &Ui, rect: Rect, x: f32) {
    for (width, colour) in [(5.0, Color32::from_black_alpha(160)), (2.0, Color32::WHITE)] {
        let line = [pos2(x, rect.top()), pos2(x, rect.bottom())];
        ui.painter_at(rect).line_segment(line, Stroke::new(width, colour));
    }
    ui.painter_at(rect).circle(
        pos2(x, rect.center().y),
        11.0,
        Color32::WHITE,
        Stroke::new(2.0, Color32::from_black_alpha(160)),
    );
}

/// Run and pose of both results, and what differs in how they were taken.
fn show_facts(ui: &mut Ui, cx: &PanelContext<'_>, sides: &[Option<Side<'_>>; 2], zone: &SiteZone) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), FACTS_HEIGHT), Sense::hover());
    let mut facts: Vec<String> =
        sides.iter().flatten().map(|side| texts::facts_of_side(side.letter, &side.facts(cx, zone))).collect();
    let reports = sides.each_ref().map(|side| side.as_ref()?.result.report.as_ref());
    if let [Some(before), Some(now)] = reports {
        facts.extend(difference(before, now));
    }
    let style = (theme::SMALL, Weight::Regular);
    crate::paint::line_at(ui, rect.left_center(), rect.width(), &facts.join(" · "), style, cx.tokens.dim);
}

/// The buttons that choose the result before and after.
pub(super) fn show_steps(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    for (name, sign, step) in [(texts::PREVIOUS, icon::CARET_LEFT, -1), (texts::NEXT, icon::CARET_RIGHT, 1)] {
        let button = Button::icon_only(name, sign).enabled(cx.model.point_history.can_step(step));
        if button.show(ui, cx.tokens).clicked() {
            ask(cx, PointHistoryCommand::Step(step));
        }
    }
}

/// The switch that keeps the chosen result as the one with which others are compared.
pub(super) fn show_keep(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let history = &cx.model.point_history;
    let Some(later) = history.later().map(|later| later.number) else { return };
    let is_kept = history.kept().is_some();
    let name = if is_kept { texts::LET_GO } else { texts::KEEP };
    if Button::new(name).icon(icon::LOCK).on(is_kept).slim().show(ui, cx.tokens).clicked() {
        ask(cx, PointHistoryCommand::Keep((!is_kept).then_some(later)));
    }
}
