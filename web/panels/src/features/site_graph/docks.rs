//! Docks: the list of them, and the dock of the node that is selected with its name and its approach.

use super::facts::{missing_name, name_of};
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::name_field::NameField;
use crate::select::select;
use crate::{icon, widgets};
use client_model::{ClientCommand, Selection};
use egui::Ui;
use site_model::{Dock, Node, ObjectId, Site};

/// Lists the docks; a press selects the node on the dock.
pub(super) fn show_list(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
    if site.docks().next().is_none() {
        return;
    }
    widgets::section_head(ui, cx.tokens, texts::DOCKS_HEAD);
    for dock in site.docks() {
        let row = texts::dock_row(&dock.name, missing_name(name_of(site, dock.node)));
        let name = texts::dock(&dock.name);
        let button = Button::new(&name).text(&row).icon(icon::BATTERY_CHARGING).kind(Kind::Quiet);
        if button.wide(ui).left().show(ui, cx.tokens).clicked() {
            cx.commands.push(ClientCommand::Select(Some(Selection::Node(dock.node))));
        }
    }
}

/// Whether the robot charges at a node: making it a dock, the dock's name and approach, and no dock again.
pub(super) fn show_of_node(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    name: &mut NameField,
    site: &Site,
    node: &Node,
) {
    let tokens = cx.tokens;
    if let Some(dock) = site.docks().find(|dock| dock.node == node.id || dock.approach == node.id) {
        return show_dock(ui, cx, name, site, dock, dock.node == node.id);
    }
    let button = Button::new(texts::MAKE_DOCK).icon(icon::BATTERY_CHARGING).hint(texts::MAKE_DOCK_HINT);
    if button.wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::EditSite(cx.model.site.making_dock(node.id)));
    }
}

fn show_dock(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    name: &mut NameField,
    site: &Site,
    dock: &Dock,
    is_on_it: bool,
) {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, texts::DOCK_HEAD);
    widgets::remark(ui, tokens, &texts::of_dock(&dock.name, is_on_it));
    if let Some(name) = name.show(ui, cx, &texts::DOCK_NAME_FIELD, ObjectId::Dock(dock.id), &dock.name) {
        cx.commands.push(ClientCommand::EditSite(cx.model.site.renaming_dock(dock.id, name)));
    }
    let nodes = cx.model.site.dock_approaches(dock);
    let names: Vec<String> = nodes.iter().map(|node| missing_name(name_of(site, *node)).to_owned()).collect();
    let shown = missing_name(name_of(site, dock.approach));
    if let Some(index) = select(ui, tokens, texts::APPROACH, texts::APPROACH, shown, &names) {
        let edit = cx.model.site.moving_dock_approach(dock, nodes[index]);
        if !edit.put.is_empty() {
            cx.commands.push(ClientCommand::EditSite(edit));
        }
    }
    widgets::remark(ui, tokens, texts::APPROACH_REMARK);
    if is_on_it && Button::new(texts::UNMAKE_DOCK).icon(icon::X).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::EditSite(cx.model.site.unmaking_dock(dock.node)));
    }
}
