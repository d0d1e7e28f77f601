//! Mapping: starting a session, its progress, and finishing, saving or discarding it.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::{quality, tabs};
use crate::map_name::map_name;
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets::{self, fact};
use crate::{TextInput, format, icon};
use api::{Command, Mapping};
use client_model::ClientCommand;
use egui::{Ui, vec2};
use vocab::{MapId, Stamp};

/// Parameters of the panel.
struct MappingPanelConfig {
    /// Distance through mapped ground after which the robot is usually localised, metres. The bar is full at this distance. Chosen: the first search comes after 12 m,
    /// and the next ones every 2 m (docs/maths/loops.md, section 9).
    localising_distance_m: f64,
}

const CONFIG: MappingPanelConfig = MappingPanelConfig { localising_distance_m: 15.0 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct MappingPanel {
    /// Name typed for the map under construction.
    pub(crate) map_name: String,
    /// Whether the operator is asked to confirm that the map is discarded.
    confirm_discard: bool,
}

/// What a running session has made so far.
struct Progress {
    since: Stamp,
    distance_m: f64,
    keyframes: u32,
    on_known_ground: bool,
}

impl FeaturePanel for MappingPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[tabs::SESSION]
    }

    /// Shown unless an alignment takes the whole tab while nothing is mapped.
    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if *cx.model.mapping() != Mapping::Idle || cx.model.alignment().is_none() {
            show_session(ui, cx, self);
        }
    }
}

/// The session in its state.
fn show_session(ui: &mut Ui, cx: &mut PanelContext<'_>, panel: &mut MappingPanel) {
    let (model, tokens) = (cx.model, cx.tokens);
    if !matches!(model.mapping(), Mapping::Running { .. }) {
        panel.confirm_discard = false;
    }
    match *model.mapping() {
        Mapping::Idle => show_idle(ui, cx),
        Mapping::Starting { .. } => show_starting(ui, cx),
        Mapping::Loading { map, .. } => show_loading(ui, cx, map),
        Mapping::Finding { map, distance_m, ambiguous, .. } => {
            let map = map_name(model, map);
            let hint = if ambiguous {
                texts::ambiguous_hint(map)
            } else {
                texts::localising_hint(map, CONFIG.localising_distance_m)
            };
            show_localising(ui, cx, &hint, distance_m);
        }
        Mapping::Running { extends, since, distance_m, keyframes, on_known_ground, .. } => {
            let progress = Progress { since, distance_m, keyframes, on_known_ground };
            show_progress(ui, cx, &progress);
            if let Some(map) = extends {
                fact(ui, tokens, texts::EXTENDS, map_name(model, map));
            }
            quality::show_figures(ui, cx);
            ui.spacing_mut().item_spacing.y = 8.0;
            ui.add_space(4.0);
            if panel.confirm_discard {
                show_discard_confirmation(ui, cx, panel);
            } else {
                show_finish(ui, cx, panel);
            }
            // Below the buttons: the list grows and shrinks by itself, and must not move "Discard" to where "Finish and save" was.
            quality::show_targets(ui, cx);
        }
        Mapping::Saving { .. } => show_saving(ui, tokens),
    }
}

fn show_idle(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    widgets::head(ui, tokens, texts::HEAD);
    let is_first = model.maps().list().is_some_and(<[_]>::is_empty);
    widgets::remark(ui, tokens, if is_first { texts::FIRST_MAP_HINT } else { texts::MAP_HINT });
    let is_pending = model.is_pending(|command| matches!(command, Command::StartMapping(_)));
    let name = if is_pending { texts::START_PENDING } else { texts::START };
    let enabled = model.can_command() && !is_pending;
    let start = Button::new(name).icon(icon::PLAY).kind(Kind::Primary).enabled(enabled).wide(ui);
    if start.show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::StartMapping);
    }
    if model.is_controlled_by_other() {
        let sentence = texts::control_needed_to_map(model.control().holder_name());
        widgets::remark(ui, tokens, &sentence);
    }
}

fn show_starting(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let tokens = cx.tokens;
    show_state(ui, tokens, texts::STARTING);
    widgets::tinted_box(ui, tokens, tokens.accent, |ui| {
        widgets::sentence(ui, tokens, texts::STARTING_HINT);
    });
    show_cancel(ui, cx);
}

fn show_loading(ui: &mut Ui, cx: &mut PanelContext<'_>, map: MapId) {
    let tokens = cx.tokens;
    show_state(ui, tokens, texts::LOADING);
    show_endless_bar(ui);
    widgets::remark(ui, tokens, &texts::loading_hint(map_name(cx.model, map)));
    show_cancel(ui, cx);
}

/// The robot is localised in the map that it is going to extend.
fn show_localising(ui: &mut Ui, cx: &mut PanelContext<'_>, hint: &str, distance_m: f64) {
    let tokens = cx.tokens;
    show_state(ui, tokens, texts::LOCALISING);
    widgets::tinted_box(ui, tokens, tokens.accent, |ui| widgets::sentence(ui, tokens, hint));
    let share = (distance_m / CONFIG.localising_distance_m).min(1.0) as f32;
    ui.add(egui::ProgressBar::new(share).desired_height(6.0).corner_radius(3));
    fact(ui, tokens, texts::LOCALISING_DISTANCE, &format::distance(distance_m));
    show_cancel(ui, cx);
}

fn show_saving(ui: &mut Ui, tokens: &Tokens) {
    show_state(ui, tokens, texts::SAVING);
    show_endless_bar(ui);
    widgets::remark(ui, tokens, texts::SAVING_HINT);
}

fn show_state(ui: &mut Ui, tokens: &Tokens, state: &str) {
    let text = egui::RichText::new(state).font(font(theme::HEAD, Weight::SemiBold)).color(tokens.text);
    let response = ui.label(text);
    widgets::status_node(&response, texts::STATE, state);
}

/// A moving bar, for work of unknown length.
fn show_endless_bar(ui: &mut Ui) {
    ui.add(egui::ProgressBar::new(1.0).animate(true).desired_height(6.0).corner_radius(3));
}

fn show_cancel(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    if Button::new(texts::CANCEL).wide(ui).show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::DiscardMapping);
    }
}

fn show_progress(ui: &mut Ui, cx: &PanelContext<'_>, progress: &Progress) {
    let (model, tokens) = (cx.model, cx.tokens);
    let elapsed_s = model.connection().clock().age_of(progress.since, model.now()).unwrap_or(0.0);
    ui.horizontal(|ui| {
        let (dot, _) = ui.allocate_exact_size(vec2(10.0, 20.0), egui::Sense::hover());
        ui.painter().circle_filled(dot.center(), 5.0, tokens.good);
        show_state(ui, tokens, texts::RUNNING);
    });
    ui.spacing_mut().item_spacing.y = 4.0;
    fact(ui, tokens, texts::ELAPSED, &format::elapsed(elapsed_s));
    fact(ui, tokens, texts::DISTANCE, &format::distance(progress.distance_m));
    fact(ui, tokens, texts::KEYFRAMES, &format::count(u64::from(progress.keyframes)));
    fact(ui, tokens, texts::GROUND, texts::ground(progress.on_known_ground));
    fact(ui, tokens, texts::POINTS, &format::points(model.live_map().tiles.points()));
}

/// The name of the map, saving it, and discarding it.
fn show_finish(ui: &mut Ui, cx: &mut PanelContext<'_>, panel: &mut MappingPanel) {
    let (model, tokens) = (cx.model, cx.tokens);
    let default_name = match *model.mapping() {
        Mapping::Running { extends: Some(map), .. } => map_name(model, map).to_owned(),
        _ => texts::default_map_name(model.maps().len() + 1),
    };
    ui.label(egui::RichText::new(texts::MAP_NAME).size(theme::SMALL).color(tokens.dim));
    let input = TextInput::new(texts::MAP_NAME, texts::MAP_NAME).hint(&default_name);
    input.show(ui, tokens, cx.text_inputs, &mut panel.map_name);
    let is_pending = model.is_pending(|command| matches!(command, Command::FinishMapping { .. }));
    let save = Button::new(texts::FINISH).icon(icon::FLOPPY_DISK).kind(Kind::Primary);
    if save.enabled(model.can_command() && !is_pending).wide(ui).show(ui, tokens).clicked() {
        let typed = std::mem::take(&mut panel.map_name);
        let name = if typed.trim().is_empty() { default_name } else { typed.trim().to_owned() };
        cx.commands.push(ClientCommand::FinishMapping { name });
    }
    let discard = Button::new(texts::DISCARD).text(texts::DISCARD_SHORT).icon(icon::TRASH).wide(ui);
    if discard.enabled(model.can_command()).show(ui, tokens).clicked() {
        panel.confirm_discard = true;
    }
    if model.is_controlled_by_other() {
        let sentence = texts::control_needed_to_finish(model.control().holder_name());
        widgets::remark(ui, tokens, &sentence);
    }
}

fn show_discard_confirmation(ui: &mut Ui, cx: &mut PanelContext<'_>, panel: &mut MappingPanel) {
    let tokens = cx.tokens;
    widgets::tinted_box(ui, tokens, tokens.bad, |ui| widgets::sentence(ui, tokens, texts::DISCARD_WARNING));
    let discard = Button::new(texts::CONFIRM_DISCARD).icon(icon::TRASH).kind(Kind::Danger);
    if discard.enabled(cx.model.can_command()).wide(ui).show(ui, tokens).clicked() {
        panel.confirm_discard = false;
        cx.commands.push(ClientCommand::DiscardMapping);
    }
    if Button::new(texts::KEEP_MAPPING).wide(ui).show(ui, tokens).clicked() {
        panel.confirm_discard = false;
    }
}
