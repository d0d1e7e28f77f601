//! The mission editor: name, expected time and route, the list of tasks, order and end, and running it.

mod dragging;
mod settings;
mod task_list;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::mission_palette::MissionPalette;
use crate::features::mission_task::{order, push_command, push_edit};
use crate::features::tabs;
use crate::message::show_message;
use crate::name_field::MAX_NAME_CHARS;
use crate::theme::{self, Weight};
use crate::{TextInput, Width, icon, screens, widgets};
use client_model::{ClientCommand, MissionEditorCommand, MissionPlan};
use egui::{Context, ScrollArea, Ui};
use site_model::{Mission, MissionId, Site, TaskOrder};
use task_list::TaskList;

/// What the editor keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct MissionEditorPanel {
    /// The name that is typed, of this mission.
    typed_name: Option<(MissionId, String)>,
    list: TaskList,
    /// On narrow windows: the palette, while it takes the place of the list.
    palette: MissionPalette,
    is_palette_open: bool,
}

impl FeaturePanel for MissionEditorPanel {
    fn update(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        let is_list_shown = cx.layout.width == Width::Wide || cx.frame.drawer_open;
        let is_shown = cx.screen() == screens::MISSIONS && is_list_shown;
        self.list.follow_keys(ctx, cx, is_shown);
    }

    fn cancel(&mut self, cx: &mut PanelContext<'_>) -> bool {
        if cx.model.missions.drag().is_some() {
            push_command(cx, MissionEditorCommand::EndDrag);
            return true;
        }
        if cx.model.missions.is_order_proposed() {
            push_command(cx, MissionEditorCommand::ProposeOrder(false));
            return true;
        }
        false
    }

    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if self.list.is_moved_by_keys() {
            show_message(ui, cx.tokens, cx.tokens.accent, icon::KEYBOARD, texts::MOVING, |_| {});
        }
    }

    fn tabs(&self) -> &'static [Tab] {
        &[tabs::MISSIONS]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let model = cx.model;
        let (Some(site), Some(plan)) = (model.site.site(), model.missions.plan()) else { return };
        let Some(mission) = model.missions.open().and_then(|open| site.mission(open)) else { return };
        // Escape ends a drag and declines an order, and stops nothing.
        cx.frame.is_escape_consumed |= model.missions.drag().is_some() || model.missions.is_order_proposed();
        self.show_head(ui, cx, mission);
        show_cost(ui, cx, plan);
        show_order(ui, cx, plan);
        if cx.layout.width == Width::Narrow {
            let button = Button::new(texts::ADD).icon(icon::PLUS).on(self.is_palette_open);
            self.is_palette_open ^= button.wide(ui).show(ui, cx.tokens).clicked();
            if self.is_palette_open {
                return self.palette.show(ui, cx);
            }
        }
        ui.with_layout(egui::Layout::bottom_up(egui::Align::Min), |ui| {
            show_run(ui, cx, mission, plan);
            ui.with_layout(egui::Layout::top_down(egui::Align::Min), |ui| {
                let area = ScrollArea::vertical().id_salt("tasks").auto_shrink([false, false]);
                area.show(ui, |ui| {
                    ui.spacing_mut().item_spacing.y = dragging::GAP;
                    show_start(ui, cx, site, plan);
                    if model.missions.drag().is_none() {
                        order::show_problems(ui, cx, site, mission);
                    }
                    self.list.show(ui, cx, site, plan);
                    settings::show(ui, cx, site, mission, plan);
                });
            });
        });
    }
}

impl MissionEditorPanel {
    /// Back to the list, the name, undo and redo.
    fn show_head(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, mission: &Mission) {
        let (model, tokens) = (cx.model, cx.tokens);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            if Button::icon_only(texts::BACK, icon::ARROW_LEFT).kind(Kind::Quiet).show(ui, tokens).clicked() {
                push_command(cx, MissionEditorCommand::Open(None));
            }
            let width = ui.available_width() - 2.0 * (theme::TOUCH + 4.0);
            ui.allocate_ui(egui::vec2(width, theme::TOUCH), |ui| self.show_name(ui, cx, mission));
            let steps = [
                (texts::UNDO, icon::ARROW_BEND_UP_LEFT, model.site.can_undo(), ClientCommand::Undo),
                (texts::REDO, icon::ARROW_BEND_UP_RIGHT, model.site.can_redo(), ClientCommand::Redo),
            ];
            for (name, sign, is_possible, command) in steps {
                let button = Button::icon_only(name, sign).kind(Kind::Quiet).enabled(is_possible);
                if button.show(ui, tokens).clicked() {
                    cx.commands.push(command);
                }
            }
        });
    }

    /// The name is taken when Enter is pressed or the field left.
    fn show_name(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, mission: &Mission) {
        let is_typed = self.typed_name.as_ref().is_some_and(|(of, _)| *of == mission.id);
        let mut name = match &self.typed_name {
            Some((_, typed)) if is_typed => typed.clone(),
            _ => mission.name.clone(),
        };
        let field = TextInput::new(("mission name", mission.id.0), texts::NAME).max_length(MAX_NAME_CHARS);
        let response = field.show(ui, cx.tokens, cx.text_inputs, &mut name);
        if response.changed {
            self.typed_name = Some((mission.id, name.clone()));
        }
        if response.submitted || response.lost_focus {
            self.typed_name = None;
            let name = name.trim().to_owned();
            if !name.is_empty() {
                push_edit(cx, cx.model.site.changing_mission(mission.id, |mission| mission.name = name));
            }
        }
    }
}

/// Expected time, length of the route, and the charge of the battery that it takes.
fn show_cost(ui: &mut Ui, cx: &mut PanelContext<'_>, plan: &MissionPlan) {
    let tokens = cx.tokens;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 16.0;
        for (name, sign, value) in [
            (texts::TIME, icon::CLOCK_COUNTDOWN, texts::time(plan.time_s)),
            (texts::ROUTE, icon::PATH, texts::route(plan.length_m)),
            (texts::CHARGE, icon::BATTERY_MEDIUM, texts::charge(plan.charge_used)),
        ] {
            let parts = [
                (sign, theme::ICON, Weight::Regular, tokens.dim),
                (value.as_str(), theme::HEAD, Weight::SemiBold, tokens.text),
            ];
            widgets::status_line(ui, name, &value, &parts);
        }
    });
}

/// What the shortest order would gain: a button that shows it, then the decision.
fn show_order(ui: &mut Ui, cx: &mut PanelContext<'_>, plan: &MissionPlan) {
    let (model, tokens) = (cx.model, cx.tokens);
    let gain = model.missions.gain().filter(|_| plan.mission.order == TaskOrder::AsListed);
    let Some(gain) = gain else { return };
    if !model.missions.is_order_proposed() {
        let text = texts::optimise(gain.saved.time_s);
        // It keeps its room during a drag, so that the list does not move under the pointer.
        let button = Button::new(&text).icon(icon::PATH).enabled(model.missions.drag().is_none());
        if button.wide(ui).show(ui, tokens).clicked() {
            push_command(cx, MissionEditorCommand::ProposeOrder(true));
        }
        return;
    }
    widgets::tinted_box(ui, tokens, tokens.accent, |ui| {
        widgets::sentence(ui, tokens, &texts::gain(gain.saved.time_s, gain.saved.length_m, gain.is_shortest));
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            let width = ((ui.available_width() - 8.0) / 2.0).floor();
            let accept = Button::new(texts::USE_ORDER).kind(Kind::Primary).slim().size(width, theme::TOUCH);
            if accept.show(ui, tokens).clicked() {
                push_edit(cx, model.missions.accepting_order(&model.site));
                push_command(cx, MissionEditorCommand::ProposeOrder(false));
            }
            let decline = Button::new(texts::KEEP_ORDER).slim().size(width, theme::TOUCH);
            if decline.show(ui, tokens).clicked() {
                push_command(cx, MissionEditorCommand::ProposeOrder(false));
            }
        });
    });
}

/// Where the route begins, and how to see it.
fn show_start(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, plan: &MissionPlan) {
    let (model, tokens) = (cx.model, cx.tokens);
    let site_map = site.settings().and_then(|settings| settings.map);
    if let Some(map) = site_map
        && model.saved_map_on_screen() != Some(map)
    {
        widgets::remark(ui, tokens, texts::OTHER_MAP);
        if Button::new(texts::VIEW_ITS_MAP).icon(icon::EYE).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::ViewMap(Some(map)));
        }
    }
    widgets::remark(ui, tokens, &settings::start_text(site, plan));
}

/// Why the mission cannot be run now, or what to know before.
fn remark_on_run(cx: &PanelContext<'_>) -> Option<String> {
    let model = cx.model;
    let plan = model.missions.plan()?;
    let runs = model.runs.status().into_iter().flat_map(|status| &status.runs);
    let running = runs.filter(|run| run.mission == plan.mission.id).count();
    let problems = plan.stops.iter().filter(|stop| stop.problem.is_some()).count();
    if !model.is_connected() {
        Some(texts::NOT_CONNECTED.to_owned())
    } else if plan.mission.tasks.is_empty() {
        Some(texts::NO_TASKS.to_owned())
    } else if model.site.unconfirmed() > 0 {
        Some(texts::UNCONFIRMED.to_owned())
    } else if running > 0 {
        Some(texts::running(running))
    } else {
        (problems > 0).then(|| texts::cannot_be_done(problems))
    }
}

/// Running the mission, from the bottom upwards. Not before the robot has the last edit, because a run keeps the mission that it began with.
fn show_run(ui: &mut Ui, cx: &mut PanelContext<'_>, mission: &Mission, plan: &MissionPlan) {
    let (model, tokens) = (cx.model, cx.tokens);
    let can_run = model.can_command() && !plan.mission.tasks.is_empty() && model.site.unconfirmed() == 0;
    // A row of known height, because it grows upwards.
    let row = egui::vec2(ui.available_width(), theme::TOUCH);
    ui.allocate_ui_with_layout(row, egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let width = ((ui.available_width() - 8.0) / 2.0).floor();
        let buttons = [
            (texts::RUN_NOW, icon::PLAY, Kind::Primary, false),
            (texts::QUEUE, icon::QUEUE, Kind::Plain, true),
        ];
        for (name, sign, kind, is_queued) in buttons {
            let button = Button::new(name).icon(sign).kind(kind).enabled(can_run).size(width, theme::TOUCH);
            if button.show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::StartMission { mission: mission.id, is_queued });
            }
        }
    });
    if let Some(remark) = remark_on_run(cx) {
        widgets::remark(ui, tokens, &remark);
    }
    ui.add_space(4.0);
}
