//! The side card: the tabs of the screen, and the sections of features in the open tab.

use crate::feature_panel::{PanelContext, Tab};
use crate::features::FeaturePanels;
use crate::{Width, layout, screens, widgets};
use client_model::Screen;
use egui::{Context, ScrollArea, Ui};

/// Letters of the names of tabs that fit into one row.
const MAX_ROW_LETTERS: usize = 34;

/// Shows the card of the screen.
pub(super) fn show(ctx: &Context, panels: &mut FeaturePanels, cx: &mut PanelContext<'_>) {
    let screen = cx.screen();
    let tabs = tabs_of(panels, screen);
    let Some(first) = tabs.first() else { return };
    let (tokens, rect) = (cx.tokens, cx.layout.card);
    let is_drawer = cx.layout.width != Width::Wide;
    let name = screens::description_of(screen).side_card;
    let content = |ui: &mut Ui| {
        let mut open = cx.frame.tab_of(screen).filter(|tab| tabs.contains(tab)).unwrap_or(*first);
        if tabs.len() > 1 {
            let choices: Vec<(&str, Tab)> = tabs.iter().map(|tab| (tab.name, *tab)).collect();
            for row in rows_of(&choices) {
                widgets::choice(ui, tokens, row, open, |tab| open = tab);
            }
            cx.frame.open_tab(open);
        }
        if open.scrolls {
            let area = ScrollArea::vertical().id_salt(open.name).auto_shrink([false, false]);
            area.show(ui, |ui| show_tab(open, ui, panels, cx));
        } else {
            show_tab(open, ui, panels, cx);
        }
    };
    if is_drawer {
        layout::drawer(ctx, tokens, name, rect, content);
    } else {
        layout::card(ctx, tokens, name, rect, content);
    }
}

/// The choices in as many rows as their names need.
fn rows_of<'a>(choices: &'a [(&'a str, Tab)]) -> Vec<&'a [(&'a str, Tab)]> {
    let (mut rows, mut begin, mut letters) = (Vec::new(), 0, 0);
    for (index, (name, _)) in choices.iter().enumerate() {
        if letters + name.len() > MAX_ROW_LETTERS && index > begin {
            rows.push(&choices[begin..index]);
            (begin, letters) = (index, 0);
        }
        letters += name.len();
    }
    rows.push(&choices[begin..]);
    rows
}

/// The tabs of a screen, in the order of the panels that name them first.
fn tabs_of(panels: &mut FeaturePanels, screen: Screen) -> Vec<Tab> {
    let mut tabs: Vec<Tab> = Vec::new();
    for tab in panels.iter_mut().flat_map(|panel| panel.tabs()) {
        if tab.screen == screen && !tabs.contains(tab) {
            tabs.push(*tab);
        }
    }
    tabs
}

fn show_tab(tab: Tab, ui: &mut Ui, panels: &mut FeaturePanels, cx: &mut PanelContext<'_>) {
    ui.spacing_mut().item_spacing.y = tab.row_spacing;
    for panel in panels.iter_mut().filter(|panel| panel.tabs().contains(&tab)) {
        panel.show_section(tab, ui, cx);
    }
}
