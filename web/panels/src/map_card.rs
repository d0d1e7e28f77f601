//! The right card on the Map screen: a choice of its parts, and which features each part shows.
//!
//! A new part is a variant of [`MapPart`], a line in [`MapPart::ALL`] and a line in [`MapPart::show`].

use crate::features::{alignment, loops, mapping, maps};
use crate::theme::Tokens;
use crate::{PanelState, sensors, widgets};
use api::Mapping;
use client_model::{ClientCommand, Model, Screen, Selection};
use egui::{ScrollArea, Ui};

/// Texts of the card, by key.
mod texts {
    pub(super) const SESSION: &str = "Session";
    pub(super) const LOOPS: &str = "Loops";
    pub(super) const SENSORS: &str = "Sensors";
}

/// What the card keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct MapCard {
    /// The part that is shown.
    pub(crate) part: MapPart,
    /// What was selected in the last frame. A newly selected loop opens its evidence.
    last_selection: Option<Selection>,
}

/// Parts of the card.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum MapPart {
    /// The mapping session and the saved maps.
    #[default]
    Session,
    /// Loops of the map under construction.
    Loops,
}

impl MapPart {
    const ALL: [(&'static str, Self); 2] = [(texts::SESSION, Self::Session), (texts::LOOPS, Self::Loops)];

    fn show(
        self,
        ui: &mut Ui,
        model: &Model,
        tokens: &Tokens,
        state: &mut PanelState,
        out: &mut Vec<ClientCommand>,
    ) {
        match self {
            Self::Session => show_session(ui, model, tokens, state, out),
            Self::Loops => loops::show(ui, model, tokens, &mut state.loops, out),
        }
    }
}

/// The card: the choice of its parts, and the chosen one.
pub(crate) fn show(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    let shown = state.map_card.part;
    widgets::choice(ui, tokens, &MapPart::ALL, shown, |part| state.map_card.part = part);
    state.map_card.part.show(ui, model, tokens, state, out);
}

/// Opens the evidence of a loop that was selected since the last frame.
pub(crate) fn follow_selection(model: &Model, state: &mut PanelState, out: &mut Vec<ClientCommand>) {
    let selection = model.selection();
    let last = std::mem::replace(&mut state.map_card.last_selection, selection);
    if selection != last && matches!(selection, Some(Selection::Loop(_))) {
        state.map_card.part = MapPart::Loops;
        state.drawer_open = true;
        if model.view.screen() != Screen::Map {
            out.push(ClientCommand::ShowScreen(Screen::Map));
        }
    }
}

/// The mapping session, the sensors while it lasts, and the saved maps. An alignment takes the place of the saved maps, and of the whole
/// card while nothing is mapped.
fn show_session(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    let is_idle = *model.mapping() == Mapping::Idle;
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 8.0;
        if let (true, Some(alignment)) = (is_idle, model.alignment()) {
            alignment::show(ui, model, tokens, alignment, out);
            return;
        }
        mapping::show(ui, model, tokens, &mut state.mapping, &mut state.text_inputs, out);
        if !is_idle {
            show_sensors(ui, model, tokens);
        }
        ui.add_space(4.0);
        widgets::rule(ui, tokens);
        match model.alignment() {
            Some(alignment) => alignment::show(ui, model, tokens, alignment, out),
            None => maps::show(ui, model, tokens, state.utc_offset_s, out),
        }
    });
}

fn show_sensors(ui: &mut Ui, model: &Model, tokens: &Tokens) {
    let Some(health) = &model.robot.health else { return };
    sensors::findings(ui, &health.value, tokens);
    ui.add_space(4.0);
    widgets::rule(ui, tokens);
    widgets::head(ui, tokens, texts::SENSORS);
    sensors::list(ui, model, tokens);
}
