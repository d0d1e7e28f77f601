//! A choice of one of many: a button that shows the choice and unfolds the list below itself.

use crate::button::{Button, Kind};
use crate::paint::line_at;
use crate::theme::{self, Tokens, Weight};
use egui::{Popup, PopupCloseBehavior, ScrollArea, Sense, Ui, vec2};

/// Greatest height of the list, points. A longer one scrolls.
const MAX_LIST_HEIGHT: f32 = 320.0;

/// Shows a caption, and below it the button with the choice. `name`: of the button in the accessible tree. Returns the option that was chosen now, by its index.
pub(crate) fn select(
    ui: &mut Ui,
    tokens: &Tokens,
    name: &str,
    caption: &str,
    chosen: &str,
    options: &[String],
) -> Option<usize> {
    show_caption(ui, tokens, caption);
    let width = ui.available_width();
    let button = Button::new(name).text(chosen).caret().size(width, theme::TOUCH).left().show(ui, tokens);
    let mut picked = None;
    Popup::menu(&button)
        .close_behavior(PopupCloseBehavior::CloseOnClick)
        .accessible_name(caption)
        .width(width.max(180.0))
        .show(|ui| {
            ScrollArea::vertical().max_height(MAX_LIST_HEIGHT).show(ui, |ui| {
                ui.spacing_mut().item_spacing.y = 2.0;
                for (index, option) in options.iter().enumerate() {
                    let is_chosen = option == chosen;
                    let entry = Button::new(option).kind(Kind::Quiet).on(is_chosen).wide(ui).left();
                    if ui.push_id(index, |ui| entry.show(ui, tokens)).inner.clicked() {
                        picked = Some(index);
                    }
                }
            });
        });
    picked
}

/// The caption of a control below it. It is painted only: in the accessible tree the control has this name itself.
pub(crate) fn show_caption(ui: &mut Ui, tokens: &Tokens, text: &str) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 16.0), Sense::hover());
    line_at(ui, rect.left_center(), rect.width(), text, (theme::SMALL, Weight::Regular), tokens.dim);
}
