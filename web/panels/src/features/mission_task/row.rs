//! A row that can be dragged: of the list of tasks, or of the palette.

use crate::icon;
use crate::paint::{focus_ring, icon_at, line_at};
use crate::theme::{self, Tokens, Weight, font};
use egui::{
    Align2, Color32, CornerRadius, Id, Rect, Response, Role, Sense, Shape, Stroke, StrokeKind, Ui,
    WidgetInfo, pos2, vec2,
};

/// Width of the handle at the left, points.
const HANDLE_WIDTH: f32 = 32.0;
/// Side of the disc with the number, or of the icon, points.
const DISC: f32 = 26.0;

/// What a row shows.
pub(crate) struct TaskRow<'a> {
    /// Accessible name of the row.
    pub(crate) name: &'a str,
    /// Accessible name of its handle; `None`: the handle is for pointers only.
    pub(crate) handle_name: Option<&'a str>,
    /// Its number in a coloured disc, or an icon.
    pub(crate) mark: Mark<'a>,
    /// First line.
    pub(crate) title: &'a str,
    /// Second line, with its colour.
    pub(crate) note: (&'a str, Color32),
    /// At the right.
    pub(crate) value: &'a str,
    /// Colour of its left edge.
    pub(crate) edge: Color32,
    /// Whether it is selected; `None`: it cannot be.
    pub(crate) is_selected: Option<bool>,
    /// Whether it is the place to which something is dragged.
    pub(crate) is_target: bool,
}

/// What stands before the title.
pub(crate) enum Mark<'a> {
    /// A number in a disc of this colour.
    Number(usize, Color32),
    /// An icon.
    Icon(&'a str),
}

/// What happened to a row.
pub(crate) struct RowResponse {
    /// The row without its handle.
    pub(crate) body: Response,
    /// The handle.
    pub(crate) handle: Response,
}

impl RowResponse {
    /// Whether a drag of it begins.
    pub(crate) fn drag_started(&self) -> bool {
        self.body.drag_started() || self.handle.drag_started()
    }
}

impl TaskRow<'_> {
    /// Shows the row over the available width. With a mouse it can be dragged everywhere; with fingers by its handle, because a finger on the row scrolls the list.
    pub(crate) fn show(&self, ui: &mut Ui, tokens: &Tokens, id: Id, height: f32) -> RowResponse {
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
        let [handle_rect, body_rect] = split(rect);
        let has_touch = ui.input(|input| input.has_touch_screen());
        let body_sense = if has_touch { Sense::click() } else { Sense::click_and_drag() };
        let handle_sense = if self.handle_name.is_some() { Sense::click_and_drag() } else { Sense::DRAG };
        let body = ui.interact(body_rect, id.with("row"), body_sense);
        let handle = ui.interact(handle_rect, id.with("handle"), handle_sense);
        body.widget_info(|| match self.is_selected {
            Some(is_selected) => WidgetInfo::selected(Role::Button, true, is_selected, self.name),
            None => WidgetInfo::labeled(Role::Button, true, self.name),
        });
        if let Some(name) = self.handle_name {
            handle.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
        }
        if handle.hovered() || (!has_touch && body.hovered() && ui.input(|input| input.pointer.any_down())) {
            ui.set_cursor_icon(egui::CursorIcon::Grab);
        }
        if ui.is_rect_visible(rect) {
            self.paint(ui, tokens, rect, body.hovered() || handle.hovered());
            for (response, rect) in [(&body, rect), (&handle, handle_rect)] {
                if response.has_focus() {
                    focus_ring(ui, rect.shrink(2.0), tokens);
                }
            }
        }
        RowResponse { body, handle }
    }

    /// Draws the row in `rect`.
    pub(crate) fn paint(&self, ui: &Ui, tokens: &Tokens, rect: Rect, is_hovered: bool) {
        let fill = match (self.is_selected, self.is_target) {
            (Some(true), _) | (_, true) => tokens.selected(),
            _ if is_hovered => tokens.hovered(tokens.raised),
            _ => tokens.raised,
        };
        let painter = ui.painter();
        painter.rect_filled(rect, CornerRadius::same(theme::BUTTON_RADIUS), fill);
        if self.is_target {
            let stroke = Stroke::new(1.5, tokens.accent);
            let inner = rect.shrink(1.0);
            let corners = [
                inner.left_top(),
                inner.right_top(),
                inner.right_bottom(),
                inner.left_bottom(),
                inner.left_top(),
            ];
            painter.extend(Shape::dashed_line(&corners, stroke, 6.0, 4.0));
        } else {
            painter.rect_stroke(
                rect,
                CornerRadius::same(theme::BUTTON_RADIUS),
                tokens.border(),
                StrokeKind::Inside,
            );
            let edge = Rect::from_min_size(rect.min, vec2(4.0, rect.height()));
            let left =
                CornerRadius { nw: theme::BUTTON_RADIUS, sw: theme::BUTTON_RADIUS, ..CornerRadius::ZERO };
            painter.rect_filled(edge, left, self.edge);
        }
        let middle = rect.center().y;
        icon_at(
            ui,
            pos2(rect.left() + 0.5 * HANDLE_WIDTH + 2.0, middle),
            icon::DOTS_SIX_VERTICAL,
            theme::ICON,
            tokens.dim,
        );
        let mark = pos2(rect.left() + HANDLE_WIDTH + 0.5 * DISC + 2.0, middle);
        match self.mark {
            Mark::Icon(sign) => icon_at(ui, mark, sign, theme::ICON, tokens.accent),
            Mark::Number(number, colour) => {
                painter.circle_filled(mark, 0.5 * DISC, colour);
                let text = font(theme::SMALL, Weight::SemiBold);
                painter.text(mark, Align2::CENTER_CENTER, number.to_string(), text, tokens.ground);
            }
        }
        let right = pos2(rect.right() - 12.0, middle);
        let value = painter.text(
            right,
            Align2::RIGHT_CENTER,
            self.value,
            font(theme::SMALL, Weight::Regular),
            tokens.dim,
        );
        let left = mark.x + 0.5 * DISC + 10.0;
        let width = value.left() - 8.0 - left;
        let has_note = !self.note.0.is_empty();
        let title_y = if has_note { middle - 9.0 } else { middle };
        line_at(ui, pos2(left, title_y), width, self.title, (theme::BODY, Weight::Medium), tokens.text);
        if has_note {
            line_at(
                ui,
                pos2(left, middle + 9.0),
                width,
                self.note.0,
                (theme::SMALL, Weight::Regular),
                self.note.1,
            );
        }
    }
}

/// The handle and the rest.
fn split(rect: Rect) -> [Rect; 2] {
    let at = rect.left() + HANDLE_WIDTH;
    [
        Rect::from_min_max(rect.min, pos2(at, rect.bottom())),
        Rect::from_min_max(pos2(at, rect.top()), rect.max),
    ]
}
