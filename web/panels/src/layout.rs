//! Layout of the window: the scene fills it, cards float over the scene.

use crate::theme::{self, GAP, Tokens};
use egui::{Id, Order, Pos2, Rect, Ui, pos2, vec2};

/// Width of the tools, with the gap beside them, points.
const TOOLS_WIDTH: f32 = 76.0;

/// Class of the window's width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// 1100 points or more: all cards are shown.
    Wide,
    /// 700 or more: the right card is a drawer.
    Medium,
    /// Less: the rail is a bar at the bottom and cards are sheets.
    Narrow,
}

/// Positions of the cards in a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Class of the window's width.
    pub width: Width,
    /// The top bar.
    pub top: Rect,
    /// The rail, or the bar at the bottom.
    pub rail: Rect,
    /// The right card, drawer or sheet.
    pub card: Rect,
    /// Left upper corner of the tools.
    pub tools: Pos2,
    /// Left lower corner of the drive card.
    pub drive: Pos2,
    /// The part of the scene that no card covers for long.
    pub free: Rect,
}

impl Layout {
    /// For a window of this position and size.
    pub fn of(window: Rect) -> Self {
        let width = match window.width() {
            w if w >= 1100.0 => Width::Wide,
            w if w >= 700.0 => Width::Medium,
            _ => Width::Narrow,
        };
        let gap = if width == Width::Narrow { 8.0 } else { GAP };
        let inner = window.shrink(gap);
        let top = Rect::from_min_size(inner.min, vec2(inner.width(), theme::TOP_BAR));
        let below_top = top.bottom() + gap;
        if width == Width::Narrow {
            let bar = Rect::from_min_max(pos2(inner.left(), inner.bottom() - 56.0), inner.max);
            let sheet_top = below_top.max(bar.top() - gap - 440.0);
            let card =
                Rect::from_min_max(pos2(inner.left(), sheet_top), pos2(inner.right(), bar.top() - gap));
            return Self {
                width,
                top,
                rail: bar,
                card,
                tools: pos2(inner.left(), below_top),
                drive: pos2(inner.left(), bar.top() - gap),
                free: Rect::from_min_max(pos2(inner.left(), below_top), pos2(inner.right(), bar.top() - gap)),
            };
        }
        let rail = Rect::from_min_max(
            pos2(inner.left(), below_top),
            pos2(inner.left() + theme::RAIL, inner.bottom()),
        );
        let card = Rect::from_min_max(pos2(inner.right() - theme::CARD_WIDTH, below_top), inner.max);
        let left = rail.right() + gap;
        let right = if width == Width::Wide { card.left() - gap } else { inner.right() };
        Self {
            width,
            top,
            rail,
            card,
            tools: pos2(left, below_top),
            drive: pos2(left, inner.bottom()),
            free: Rect::from_min_max(pos2(left, below_top), pos2(right, inner.bottom())),
        }
    }

    /// A card beside the tools. Narrow windows have none.
    pub(crate) fn left_card(&self) -> Rect {
        let left = self.tools.x + TOOLS_WIDTH;
        Rect::from_min_max(pos2(left, self.tools.y), pos2(left + theme::LEFT_CARD_WIDTH, self.drive.y))
    }

    /// The part of the scene beside the tools, the drawer and the card at the left.
    pub(crate) fn free_beside(&self, is_drawer_open: bool, is_left_card_shown: bool) -> Rect {
        let left_card = if is_left_card_shown { theme::LEFT_CARD_WIDTH + GAP } else { 0.0 };
        let tools_width = if self.width == Width::Narrow { 68.0 } else { TOOLS_WIDTH } + left_card;
        let is_beside_drawer = self.width == Width::Medium && is_drawer_open;
        let right = if is_beside_drawer { self.card.left() - GAP } else { self.free.right() };
        Rect::from_min_max(
            pos2(self.free.left() + tools_width, self.free.top()),
            pos2(right, self.free.bottom()),
        )
    }
}

/// A card of fixed place and size. Its content is clipped to it.
pub(crate) fn card<R>(
    ctx: &egui::Context,
    tokens: &Tokens,
    name: &str,
    rect: Rect,
    content: impl FnOnce(&mut Ui) -> R,
) -> R {
    card_in(ctx, tokens, name, (Order::Middle, rect), content)
}

/// A card as of [`card`] that lies over other cards, whichever of them was touched last.
pub(crate) fn drawer<R>(
    ctx: &egui::Context,
    tokens: &Tokens,
    name: &str,
    rect: Rect,
    content: impl FnOnce(&mut Ui) -> R,
) -> R {
    card_in(ctx, tokens, name, (Order::Foreground, rect), content)
}

fn card_in<R>(
    ctx: &egui::Context,
    tokens: &Tokens,
    name: &str,
    (order, rect): (Order, Rect),
    content: impl FnOnce(&mut Ui) -> R,
) -> R {
    area(name, order)
        .fixed_pos(rect.min)
        .show(ctx, |ui| {
            theme::card(tokens)
                .show(ui, |ui| {
                    let inside = rect.size()
                        - egui::Vec2::splat(2.0 * (f32::from(theme::PADDING) + tokens.line_width));
                    ui.set_min_size(inside);
                    ui.set_max_size(inside);
                    content(ui)
                })
                .inner
        })
        .inner
}

/// A card as large as its content. Its corner `pivot` is at `at`.
pub(crate) fn hung_card<R>(
    ctx: &egui::Context,
    tokens: &Tokens,
    name: &str,
    at: Pos2,
    pivot: egui::Align2,
    content: impl FnOnce(&mut Ui) -> R,
) -> R {
    area(name, Order::Middle)
        .pivot(pivot)
        .fixed_pos(at)
        .show(ctx, |ui| theme::card(tokens).inner_margin(8).show(ui, content).inner)
        .inner
}

/// A separate layer: the scene below it gets no clicks.
pub(crate) fn area(name: &str, order: Order) -> egui::Area {
    egui::Area::new(Id::unique(name))
        .accessible_name(name)
        .role(egui::Role::Group)
        .order(order)
        .movable(false)
        .constrain(false)
        .fade_in(false)
        .interactable(true)
}

#[cfg(test)]
mod tests;
