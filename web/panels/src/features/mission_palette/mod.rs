//! The palette of the mission editor: inspection points, actions and nodes, to be dragged into the list of tasks or added to it.

#[cfg(test)]
mod tests;
mod texts;

use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::features::mission_task::row::{Mark, TaskRow};
use crate::features::mission_task::{self, push_edit};
use crate::theme;
use crate::{TextInput, TextInputKind, Width, icon, layout, screens, widgets};
use client_model::{ClientCommand, DraggedTasks, MissionEditorCommand, NewTask, TaskDrag};
use egui::{Context, Id, ScrollArea, Ui};
use site_model::{ACTION_CATALOGUE, Site};
use std::collections::BTreeSet;

/// What the palette keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct MissionPalette {
    search: String,
}

impl FeaturePanel for MissionPalette {
    /// A card at the left while a mission is open and its list in sight. On a narrow window the editor shows the palette in its sheet.
    fn show_card(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        if cx.frame.is_left_card_shown {
            layout::card(ctx, cx.tokens, texts::CARD, cx.layout.left_card(), |ui| {
                widgets::head(ui, cx.tokens, texts::HEAD);
                self.show(ui, cx);
            });
        }
    }

    fn update(&mut self, _ctx: &Context, cx: &mut PanelContext<'_>) {
        let is_list_shown = cx.layout.width == Width::Wide || cx.frame.drawer_open;
        let is_open = cx.screen() == screens::MISSIONS && cx.model.missions.open().is_some();
        cx.frame.is_left_card_shown = is_open && is_list_shown && cx.layout.width != Width::Narrow;
    }
}

impl MissionPalette {
    /// Shows the search and all entries that it finds.
    pub(crate) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        let Some(site) = cx.model.site.site() else { return };
        ui.spacing_mut().item_spacing.y = 6.0;
        let search = TextInput::new(texts::SEARCH, texts::SEARCH).hint(texts::SEARCH_HINT);
        search.kind(TextInputKind::Search).show(ui, tokens, cx.text_inputs, &mut self.search);
        ScrollArea::vertical().id_salt(texts::CARD).auto_shrink([false, false]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 6.0;
            widgets::remark(ui, tokens, texts::HINT);
            let points = mission_task::inspection_points(site);
            if points.is_empty() {
                widgets::remark(ui, tokens, texts::NO_POINTS);
            }
            let points = points.iter().map(|point| NewTask::InspectionPoint(point.id));
            let mut is_found = self.show_group(ui, cx, site, texts::POINTS, points.collect());
            let actions = ACTION_CATALOGUE.iter().map(|action| NewTask::Action(action.name));
            is_found |= self.show_group(ui, cx, site, texts::ACTIONS, actions.collect());
            let nodes = mission_task::nodes(site);
            let nodes = nodes.iter().map(|node| NewTask::Node(node.id));
            is_found |= self.show_group(ui, cx, site, texts::NODES, nodes.collect());
            if !is_found {
                widgets::remark(ui, tokens, texts::NOTHING);
            }
        });
    }

    /// Shows the entries of a group that the search finds. Returns whether there are any.
    fn show_group(
        &self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        head: &str,
        entries: Vec<NewTask>,
    ) -> bool {
        let wanted = self.search.trim().to_lowercase();
        let found: Vec<(NewTask, String, String)> = entries
            .into_iter()
            .map(|new| {
                let (title, note) = mission_task::entry_texts(site, new);
                (new, title, note)
            })
            .filter(|(_, title, note)| [title, note].iter().any(|text| text.to_lowercase().contains(&wanted)))
            .collect();
        if found.is_empty() {
            return false;
        }
        ui.add_space(4.0);
        widgets::head(ui, cx.tokens, head);
        for (new, title, note) in &found {
            show_entry(ui, cx, site, *new, (title, note));
        }
        true
    }
}

fn show_entry(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    site: &Site,
    new: NewTask,
    (title, note): (&str, &str),
) {
    let (model, tokens) = (cx.model, cx.tokens);
    let sign = match new {
        NewTask::InspectionPoint(id) => {
            let point = site.inspection_point(id);
            mission_task::icon_of(point.map(|point| point.request.action.as_str()))
        }
        NewTask::Node(_) => icon::MAP_PIN,
        NewTask::Action(name) => mission_task::icon_of(Some(name)),
    };
    let name = texts::add(new, title);
    let row = TaskRow {
        name: &name,
        handle_name: None,
        mark: Mark::Icon(sign),
        title,
        // A visit goes without saying in a list of nodes.
        note: (if matches!(new, NewTask::Node(_)) { "" } else { note }, tokens.dim),
        value: "",
        edge: tokens.line,
        is_selected: None,
        is_target: false,
    };
    let response = row.show(ui, tokens, Id::unique(("palette", new)), theme::TOUCH);
    if response.drag_started() {
        let drag = TaskDrag { what: DraggedTasks::New(new), index: None };
        cx.commands.push(ClientCommand::MissionEditor(MissionEditorCommand::Drag(drag)));
    } else if response.body.clicked() {
        let (task, edit) = model.missions.adding(new, &model.site);
        push_edit(cx, edit);
        let selected = task.map(|task| BTreeSet::from([task]));
        let select = selected.map(|tasks| ClientCommand::MissionEditor(MissionEditorCommand::Select(tasks)));
        cx.commands.extend(select);
    }
}
