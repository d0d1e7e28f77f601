//! What an operator with an empty site begins with: a map of the own site, or the example.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::layout::{self, Width};
use crate::theme::{self, Tokens, Weight, font};
use crate::{format, icon, screens, widgets};
use api::{ImportStage, Mapping};
use client_model::{ClientCommand, MissionEditorCommand, Model};
use egui::{Align2, Context, Order, Ui, vec2};
use vocab::MapId;

/// The simulated site of which the example is.
const EXAMPLE_SITE: &str = "b1";
/// Greatest width of the card, points.
const MAX_WIDTH: f32 = 620.0;
/// Distance between the two choices, points.
const COLUMN_GAP: f32 = 16.0;

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct ExamplePanel {
    /// Whether the operator wants to see the scene instead.
    is_dismissed: bool,
}

impl FeaturePanel for ExamplePanel {
    /// Shows the example once it is there: its mission, and the robot in its map.
    fn update(&mut self, _ctx: &Context, cx: &mut PanelContext<'_>) {
        if let Some(map) = cx.model.example.ready() {
            enter(cx, map);
        }
    }

    fn show_card(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        let model = cx.model;
        if cx.screen() != screens::LIVE || cx.is_covered_by_sheet() {
            return;
        }
        let progress = model.example.progress();
        if progress.is_none() && (self.is_dismissed || !is_empty(model)) {
            return;
        }
        // On windows without room for both it lies over the drive card.
        let order = if cx.layout.width == Width::Narrow { Order::Foreground } else { Order::Middle };
        let free = cx.layout.free_beside(cx.frame.drawer_open, false);
        let area = layout::area(texts::HEAD, order);
        area.pivot(Align2::CENTER_CENTER).fixed_pos(free.center()).show(ctx, |ui| {
            theme::card(cx.tokens).inner_margin(20).show(ui, |ui| {
                ui.set_width(MAX_WIDTH.min(free.width() - 48.0));
                ui.spacing_mut().item_spacing.y = 8.0;
                match progress {
                    Some((stage, share)) => show_progress(ui, cx, stage, share),
                    None => self.show_choices(ui, cx),
                }
            });
        });
    }
}

impl ExamplePanel {
    fn show_choices(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        title(ui, tokens, texts::HEAD);
        widgets::sentence(ui, tokens, texts::EMPTY);
        if let Some(reason) = cx.model.example.failure() {
            widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
                widgets::sentence(ui, tokens, &texts::failed(reason));
            });
        }
        ui.add_space(4.0);
        if cx.layout.width == Width::Narrow {
            show_example_choice(ui, cx);
            ui.add_space(8.0);
            show_own_choice(ui, cx);
        } else {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = COLUMN_GAP;
                let width = ((ui.available_width() - COLUMN_GAP) / 2.0).floor();
                for show in [show_example_choice, show_own_choice] {
                    ui.allocate_ui(vec2(width, 0.0), |ui| {
                        ui.vertical(|ui| {
                            ui.set_width(width);
                            show(ui, cx);
                        });
                    });
                }
            });
        }
        ui.add_space(4.0);
        if Button::new(texts::DISMISS).kind(Kind::Quiet).show(ui, tokens).clicked() {
            self.is_dismissed = true;
        }
    }
}

/// The example: what it is, and where it cannot be walked.
fn show_example_choice(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    let is_free = model.is_connected() && !model.example.is_asked_for();
    let button = Button::new(texts::EXPLORE).icon(icon::CUBE).kind(Kind::Primary).enabled(is_free);
    if button.wide(ui).show(ui, tokens).clicked() {
        let time_zone = if cx.clock.zone.is_empty() { "UTC".to_owned() } else { cx.clock.zone.clone() };
        cx.commands.push(ClientCommand::MakeExample { time_zone });
    }
    widgets::remark(ui, tokens, texts::EXPLORE_HINT);
    if !is_robot_in_example(model) {
        widgets::remark(ui, tokens, texts::LOOKING_ONLY);
    }
}

fn show_own_choice(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let button = Button::new(texts::MAP_OWN).icon(icon::MAP_TRIFOLD);
    if button.wide(ui).show(ui, cx.tokens).clicked() {
        // On windows without room for its card beside the scene, that opens too.
        cx.frame.drawer_open = true;
        cx.commands.push(ClientCommand::ShowScreen(screens::MAP));
    }
    widgets::remark(ui, cx.tokens, texts::MAP_OWN_HINT);
}

fn show_progress(ui: &mut Ui, cx: &mut PanelContext<'_>, stage: ImportStage, share: f32) {
    let tokens = cx.tokens;
    title(ui, tokens, texts::MAKING);
    let share = overall_share(stage, share);
    let (activity, percent) = (texts::stage(stage), format::share(share));
    let shown = ui.horizontal(|ui| {
        widgets::sentence(ui, tokens, activity);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            widgets::remark(ui, tokens, &percent);
        });
    });
    widgets::status_node(&shown.response, texts::STATE, &texts::progress(activity, &percent));
    widgets::progress_bar(ui, tokens, share);
    ui.add_space(4.0);
    if Button::new(texts::CANCEL).icon(icon::X).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::CancelExample);
    }
}

fn title(ui: &mut Ui, tokens: &Tokens, text: &str) {
    let text = egui::RichText::new(text).font(font(theme::LARGE, Weight::SemiBold));
    let response = ui.label(text.color(tokens.text));
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_role(egui::Role::Heading));
}

/// Share of the whole work that is done. The walk takes nearly all of the time.
fn overall_share(stage: ImportStage, share: f32) -> f32 {
    let (from, to) = match stage {
        ImportStage::Walking => (0.0, 0.9),
        ImportStage::Writing => (0.9, 0.96),
        ImportStage::MakingTopomap => (0.96, 1.0),
        ImportStage::Reading | ImportStage::ComputingViewpoints => (0.0, 0.0),
    };
    from + (to - from) * share.clamp(0.0, 1.0)
}

/// Whether nothing was made here yet: no map, no mission, and nothing that would become one.
fn is_empty(model: &Model) -> bool {
    let has_no_maps = model.maps().list().is_some_and(<[_]>::is_empty) && model.maps().damaged().is_empty();
    let has_no_plans = model
        .site
        .site()
        .is_some_and(|site| site.nodes().next().is_none() && site.missions().next().is_none());
    let is_at_work = *model.mapping() != Mapping::Idle || !model.interrupted_sessions.list().is_empty();
    has_no_maps && has_no_plans && !is_at_work
}

/// Whether the robot is a simulated one in the hall of the example.
fn is_robot_in_example(model: &Model) -> bool {
    model.platform.report().and_then(|report| report.site.as_deref()) == Some(EXAMPLE_SITE)
}

/// Goes to the mission of the example. The platform has let the robot find its place in the map unless somebody controls it: then that is asked here.
fn enter(cx: &mut PanelContext<'_>, map: MapId) {
    let model = cx.model;
    cx.commands.push(ClientCommand::DismissExample);
    if !is_robot_in_example(model) {
        cx.commands.push(ClientCommand::ViewMap(Some(map)));
    } else if model.has_control() && model.localisation().map() != Some(map) {
        cx.commands.push(ClientCommand::UseMap(map));
    }
    cx.commands.push(ClientCommand::ShowScreen(screens::MISSIONS));
    let mission = model.site.site().and_then(|site| site.missions().next()).map(|mission| mission.id);
    cx.commands.push(ClientCommand::MissionEditor(MissionEditorCommand::Open(mission)));
    cx.frame.drawer_open = true;
}
