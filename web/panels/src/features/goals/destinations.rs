//! Sending the robot to a dock or a node of the topological map, and out of its dock.

use super::texts;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::features::mission_task::nodes;
use crate::icon;
use crate::select::select;
use client_model::{ClientCommand, Model};
use egui::Ui;
use site_model::{NodeId, Site};

/// Whether this client may send the robot somewhere now.
fn may_send(model: &Model) -> bool {
    model.is_connected() && !model.is_stopped() && !model.is_controlled_by_other()
}

/// Docks first, then nodes by name.
fn destinations(site: &Site) -> Vec<(String, ClientCommand)> {
    let is_of_dock = |node| site.docks().any(|dock| dock.node == node);
    let docks = site.docks().map(|dock| (dock.name.clone(), ClientCommand::GoToDock(dock.id)));
    let others = nodes(site).into_iter().filter(|node| !is_of_dock(node.id));
    docks.chain(others.map(|node| (node.name.clone(), ClientCommand::GoToNode(node.id)))).collect()
}

/// The choice of a destination on the screen of the robot. Nothing without a topological map, or while the robot cannot be sent.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    let Some(site) = model.site.site().filter(|_| may_send(model) && model.viewed_map().is_none()) else {
        return;
    };
    if model.runs.route().docked.is_some() {
        let leave = Button::new(texts::LEAVE_DOCK).icon(icon::BATTERY_CHARGING).wide(ui);
        if leave.show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::LeaveDock);
        }
    }
    let (names, commands): (Vec<String>, Vec<ClientCommand>) = destinations(site).into_iter().unzip();
    if names.is_empty() {
        return;
    }
    let chosen = select(ui, tokens, texts::GO_TO, texts::GO_TO, texts::CHOOSE_DESTINATION, &names);
    cx.commands.extend(chosen.and_then(|index| commands.into_iter().nth(index)));
}

/// The button that sends the robot to a node that is selected, or into the dock that stands there.
pub(crate) fn show_send_button(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, node: NodeId) {
    let dock = site.docks().find(|dock| dock.node == node);
    let (name, command) = match dock {
        Some(dock) => (texts::SEND_TO_DOCK, ClientCommand::GoToDock(dock.id)),
        None => (texts::SEND_TO_NODE, ClientCommand::GoToNode(node)),
    };
    let send = Button::new(name).icon(icon::NAVIGATION_ARROW).enabled(may_send(cx.model)).wide(ui);
    if send.show(ui, cx.tokens).clicked() {
        cx.commands.push(command);
    }
}
