//! Saved maps are renamed, deleted and restored: what an entry of the list offers, the undo of a deletion, and the bin.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::tabs;
use crate::message::show_message;
use crate::theme::{self, Weight, font};
use crate::{TextInput, format, icon, widgets};
use api::{BinnedMap, Command, DamagedMap, MapSummary, Mapping};
use client_model::{ClientCommand, Model};
use egui::{CornerRadius, Ui};
use vocab::{MAX_MAP_NAME_CHARS, MapId};

/// Width of the button that deletes a map in the bin for good, with the gap before it, points.
const ICON_BUTTON_WIDTH: f32 = theme::TOUCH + 8.0;

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct MapManagementPanel {
    /// Whether the bin is open.
    is_bin_open: bool,
    /// The map in the bin that the operator is asked to confirm that it is deleted for good.
    confirm: Option<MapId>,
}

/// A map that is being renamed.
#[derive(Debug)]
pub(crate) struct Rename {
    map: MapId,
    name: String,
}

impl Rename {
    /// Whether it is this map.
    pub(crate) fn is_of(&self, map: MapId) -> bool {
        self.map == map
    }
}

impl FeaturePanel for MapManagementPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[tabs::SESSION]
    }

    fn cancel(&mut self, _cx: &mut PanelContext<'_>) -> bool {
        self.confirm.take().is_some()
    }

    /// The last deletion, with its undo.
    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let Some(deletion) = cx.model.map_management.deletion() else { return };
        let tokens = cx.tokens;
        let kept_until = cx.model.map_management.binned(deletion.map).and_then(|map| map.kept_until);
        let until = kept_until.map(|until| format::day(until, cx.utc_offset_s));
        let text = texts::deleted(&deletion.name, until.as_deref());
        show_message(ui, tokens, tokens.accent, icon::TRASH, &text, |ui| {
            let dismiss = Button::icon_only(texts::DISMISS, icon::X).kind(Kind::Quiet);
            if dismiss.show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::DismissDeletion);
            }
            let undo = Button::new(texts::UNDO).icon(icon::ARROW_COUNTER_CLOCKWISE);
            if undo.enabled(cx.model.is_connected()).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::RestoreMap(deletion.map));
            }
        });
    }

    /// The bin, if there is anything in it. Shown unless an alignment takes the place of the maps.
    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let bin = cx.model.map_management.bin();
        if bin.is_empty() || cx.model.alignment().is_some() {
            return;
        }
        ui.add_space(4.0);
        widgets::rule(ui, cx.tokens);
        let name = texts::bin(bin.len());
        let sign = if self.is_bin_open { icon::CARET_UP } else { icon::CARET_DOWN };
        let button = Button::new(texts::BIN).text(&name).icon(sign).on(self.is_bin_open);
        if button.wide(ui).show(ui, cx.tokens).clicked() {
            self.is_bin_open = !self.is_bin_open;
        }
        if self.is_bin_open {
            for map in bin {
                ui.push_id(map.id.0, |ui| self.show_binned(ui, cx, map));
            }
            widgets::remark(ui, cx.tokens, texts::BIN_HINT);
        }
    }
}

impl MapManagementPanel {
    /// A map in the bin: its name, how long it is kept, restoring it and deleting it for good.
    fn show_binned(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, map: &BinnedMap) {
        let tokens = cx.tokens;
        let kept = kept_text(map);
        let frame = egui::Frame::new().fill(tokens.raised);
        let frame = frame.corner_radius(CornerRadius::same(theme::BUTTON_RADIUS)).inner_margin(12);
        let shown = frame.show(ui, |ui| {
            ui.set_width(ui.available_width());
            let name = egui::RichText::new(&map.name).font(font(theme::BODY, Weight::Medium));
            ui.add(egui::Label::new(name.color(tokens.text)).truncate());
            widgets::remark(ui, tokens, &kept);
            if self.confirm == Some(map.id) {
                self.show_confirmation(ui, cx, map);
            } else {
                self.show_binned_actions(ui, cx, map);
            }
        });
        widgets::status_node(&shown.response, &texts::entry(&map.name), &kept);
    }

    fn show_binned_actions(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, map: &BinnedMap) {
        let tokens = cx.tokens;
        let enabled = cx.model.is_connected() && !is_pending(cx.model, map.id);
        ui.horizontal(|ui| {
            let name = texts::restore(&map.name);
            let restore = Button::new(&name).text(texts::RESTORE_SHORT).icon(icon::ARROW_COUNTER_CLOCKWISE);
            let width = ui.available_width() - ICON_BUTTON_WIDTH;
            if restore.enabled(enabled).size(width, theme::TOUCH).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::RestoreMap(map.id));
            }
            let name = texts::delete_permanently(&map.name);
            let delete = Button::icon_only(&name, icon::TRASH).kind(Kind::Danger).enabled(enabled);
            if delete.show(ui, tokens).clicked() {
                self.confirm = Some(map.id);
            }
        });
    }

    fn show_confirmation(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, map: &BinnedMap) {
        let tokens = cx.tokens;
        widgets::sentence(ui, tokens, &texts::delete_permanently_warning(&map.name));
        ui.horizontal(|ui| {
            let width = half_width(ui);
            let delete = Button::new(texts::CONFIRM_PERMANENTLY).icon(icon::TRASH).kind(Kind::Danger).slim();
            if delete.size(width, theme::TOUCH).show(ui, tokens).clicked() {
                self.confirm = None;
                cx.commands.push(ClientCommand::DeleteMapPermanently(map.id));
            }
            if Button::new(texts::KEEP).slim().size(width, theme::TOUCH).show(ui, tokens).clicked() {
                self.confirm = None;
            }
        });
    }
}

/// Renaming and deleting, below the entry of a saved map.
pub(crate) fn show_actions(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    map: &MapSummary,
    rename: &mut Option<Rename>,
) {
    let (model, tokens) = (cx.model, cx.tokens);
    let enabled = model.is_connected() && !is_pending(model, map.id);
    let reason = use_of(model, map.id);
    ui.horizontal(|ui| {
        let width = half_width(ui);
        let name = texts::rename(&map.name);
        let button = Button::new(&name).text(texts::RENAME_SHORT).icon(icon::PENCIL_SIMPLE).enabled(enabled);
        if button.size(width, theme::TOUCH).show(ui, tokens).clicked() {
            *rename = Some(Rename { map: map.id, name: map.name.clone() });
        }
        let name = texts::delete(&map.name);
        let button = Button::new(&name).text(texts::DELETE_SHORT).icon(icon::TRASH);
        let button = button.enabled(enabled && reason.is_none()).size(width, theme::TOUCH);
        if button.show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::DeleteMap(map.id));
        }
    });
    if let Some(reason) = reason {
        widgets::remark(ui, tokens, reason);
    }
}

/// The field in the place of a map's name, and its buttons. Ends the renaming when the name is given or kept.
pub(crate) fn show_rename(ui: &mut Ui, cx: &mut PanelContext<'_>, rename: &mut Option<Rename>) {
    let Some(Rename { map, name }) = rename else { return };
    cx.frame.is_escape_consumed = true;
    let tokens = cx.tokens;
    let field =
        TextInput::new(("rename", map.0), texts::NEW_NAME).max_length(MAX_MAP_NAME_CHARS as u32).take_focus();
    let mut given = field.show(ui, tokens, cx.text_inputs, name).submitted;
    let mut kept = false;
    let is_named = !name.trim().is_empty();
    ui.horizontal(|ui| {
        let width = half_width(ui);
        let save = Button::new(texts::SAVE_NAME).text(texts::SAVE_NAME_SHORT).kind(Kind::Primary);
        given |= save.enabled(is_named).size(width, theme::TOUCH).show(ui, tokens).clicked();
        let keep = Button::new(texts::KEEP_NAME).text(texts::KEEP_NAME_SHORT).size(width, theme::TOUCH);
        kept = keep.show(ui, tokens).clicked();
    });
    if given && is_named {
        let (map, name) = (*map, name.trim().to_owned());
        let is_new = cx.model.maps().get(map).is_none_or(|listed| listed.name != name);
        cx.commands.extend(is_new.then_some(ClientCommand::RenameMap { map, name }));
        kept = true;
    }
    if kept {
        *rename = None;
    }
}

/// Moves a map to the bin that cannot be read, if its folder is named as a map's is.
pub(crate) fn show_delete_damaged(ui: &mut Ui, cx: &mut PanelContext<'_>, map: &DamagedMap) {
    let Ok(id) = map.folder.parse::<MapId>() else { return };
    let enabled = cx.model.is_connected() && !is_pending(cx.model, id);
    let name = texts::delete(&map.folder);
    let button = Button::new(&name).text(texts::DELETE_DAMAGED_SHORT).icon(icon::TRASH).enabled(enabled);
    if button.wide(ui).show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::DeleteMap(id));
    }
}

/// Width of each of two buttons side by side.
fn half_width(ui: &mut Ui) -> f32 {
    let gap = 8.0;
    ui.spacing_mut().item_spacing.x = gap;
    ((ui.available_width() - gap) / 2.0).floor()
}

/// Whether a change of a map was sent and not answered.
fn is_pending(model: &Model, map: MapId) -> bool {
    model.is_pending(|command| match command {
        Command::RenameMap { map: changed, .. } => *changed == map,
        Command::DeleteMap(changed)
        | Command::RestoreMap(changed)
        | Command::DeleteMapPermanently(changed) => *changed == map,
        _ => false,
    })
}

/// Why a map cannot be deleted now, and what to do: a sentence.
fn use_of(model: &Model, map: MapId) -> Option<&'static str> {
    let extended = match *model.mapping() {
        Mapping::Loading { map, .. } | Mapping::Finding { map, .. } => Some(map),
        Mapping::Running { extends, .. } => extends,
        Mapping::Idle | Mapping::Starting { .. } | Mapping::Saving { .. } => None,
    };
    let is_interrupted =
        || model.interrupted_sessions.list().iter().any(|session| session.extends == Some(map));
    if model.localisation().map() == Some(map) {
        Some(texts::IN_USE)
    } else if extended == Some(map) {
        Some(texts::EXTENDED)
    } else {
        is_interrupted().then_some(texts::INTERRUPTED)
    }
}

/// How long a map in the bin is kept.
fn kept_text(map: &BinnedMap) -> String {
    match (&map.problem, map.time_left) {
        (Some(problem), _) => problem.clone(),
        (None, Some(left)) => texts::time_left(&format::time_left(left.secs_f64())),
        (None, None) => texts::NO_CLOCK.to_owned(),
    }
}
