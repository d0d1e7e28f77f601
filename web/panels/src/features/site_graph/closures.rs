//! What closes edges for a time: blocks that the robot has made, and groups of edges that somebody holds.

use super::facts::{missing_name, name_of};
use super::texts;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::{format, icon, screens, widgets};
use client_model::{ClientCommand, Selection};
use egui::Ui;
use site_model::{Edge, EdgeBlock, MutexHold, Site};
use vocab::Stamp;

/// Lists the edges that are blocked now and the groups that are held. Nothing where there are none.
pub(crate) fn show_all(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
    let model = cx.model;
    let blocks = model.site.blocks_now(robot_now(cx));
    if !blocks.is_empty() {
        widgets::section_head(ui, cx.tokens, texts::BLOCKS_HEAD);
    }
    for block in blocks {
        show_block(ui, cx, site, block, true);
    }
    let holds = model.site.mutex_holds();
    if !holds.is_empty() {
        widgets::section_head(ui, cx.tokens, texts::HOLDS_HEAD);
    }
    for hold in holds {
        show_hold(ui, cx, site, hold);
    }
}

/// The block of an edge, and who holds its group.
pub(super) fn show_of_edge(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, edge: &Edge) {
    let model = cx.model;
    let blocks = model.site.blocks_now(robot_now(cx));
    if let Some(block) = blocks.into_iter().find(|block| block.edge == edge.id) {
        show_block(ui, cx, site, block, false);
    }
    let Some(group) = &edge.mutex_group else { return };
    match model.site.mutex_holds().into_iter().find(|hold| hold.group == *group) {
        Some(hold) => show_hold(ui, cx, site, hold),
        None => {
            let name = texts::hold_group(group);
            if Button::new(&name).icon(icon::HOURGLASS_MEDIUM).wide(ui).show(ui, cx.tokens).clicked() {
                let edit = model.site.holding_group(group, &model.operator_name());
                cx.commands.push(ClientCommand::EditSite(edit));
            }
        }
    }
}

fn robot_now(cx: &PanelContext<'_>) -> Option<Stamp> {
    cx.model.connection().clock().stamp_at(cx.model.now())
}

/// One block: which edge, until when, why, and lifting it. `is_listed`: the edge can be selected from here.
fn show_block(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, block: &EdgeBlock, is_listed: bool) {
    let tokens = cx.tokens;
    let ends = site.edge(block.edge).map_or_else(String::new, |edge| {
        texts::ends(missing_name(name_of(site, edge.from)), missing_name(name_of(site, edge.to)))
    });
    let left_s = robot_now(cx).map(|now| (block.until - now).secs_f64().max(0.0));
    let left = left_s.map(format::duration);
    widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
        let sentence = texts::blocked(&ends, left.as_deref(), block);
        let text = egui::RichText::new(&sentence).size(crate::theme::BODY).color(tokens.text);
        let response = ui.add(egui::Label::new(text).wrap());
        widgets::status_node(&response, &texts::block_of(&ends), &sentence);
        if is_listed
            && Button::new(&texts::show_edge(&ends)).icon(icon::EYE).wide(ui).show(ui, tokens).clicked()
        {
            cx.commands.push(ClientCommand::ShowScreen(screens::SITE));
            cx.commands.push(ClientCommand::Select(Some(Selection::Edge(block.edge))));
        }
        let name = texts::unblock(&ends);
        let unblock = Button::new(&name).text(texts::UNBLOCK_SHORT).icon(icon::CHECK);
        if unblock.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::EditSite(cx.model.site.unblocking(block)));
        }
    });
}

/// One group that is held: by whom, how many edges, and releasing it.
fn show_hold(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, hold: &MutexHold) {
    let tokens = cx.tokens;
    let edges = site.edges().filter(|edge| edge.mutex_group.as_deref() == Some(hold.group.as_str())).count();
    widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
        widgets::sentence(ui, tokens, &texts::held(hold, edges));
        let name = texts::release_group(&hold.group);
        let release = Button::new(&name).text(texts::RELEASE_SHORT).icon(icon::X);
        if release.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::EditSite(cx.model.site.releasing_group(&hold.group)));
        }
    });
}
