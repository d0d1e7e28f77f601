//! What holds in a zone.

use super::change::change;
use super::effect_kind::EffectKind;
use super::texts;
use crate::feature_panel::PanelContext;
use crate::features::action_form::{TypedParameters, action_title};
use crate::number_field::{NumberField, TypedNumber};
use crate::select::select;
use crate::widgets;
use egui::{Id, Ui};
use site_model::{
    ActionRequest, ObjectId, Parameter, Parameters, ValidationConfig, Zone, ZoneEffect, actions_at_places,
};

/// What is typed of an effect between frames.
#[derive(Debug, Default)]
pub(super) struct EffectFields {
    parameters: TypedParameters,
}

/// Values of an effect that a zone had not before.
struct NewEffectConfig {
    /// Speed limit, metres a second: a slow walk. Chosen: a third of the default robot's speed (0.9 m/s).
    speed_m_s: f64,
    /// Factor of the cost: another path may be three times as long. Chosen: as of ground that was never seen (`navigation::PlannerConfig`).
    penalty_factor: f64,
    /// The action on entering. Chosen: it tells people where the robot is, and needs no instrument.
    action: &'static str,
    /// Its parameter for what people are told.
    parameter: &'static str,
}

const CONFIG: NewEffectConfig =
    NewEffectConfig { speed_m_s: 0.3, penalty_factor: 3.0, action: "message", parameter: "text" };

/// Factors that people may enter.
const PENALTIES: [f64; 2] = [1.0, 100.0];

impl EffectFields {
    /// Shows the kinds, and the number or action of the present one.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        typed: &mut TypedNumber,
        zone: &Zone,
    ) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::EFFECT_HEAD);
        let kind = EffectKind::of(&zone.effect);
        let mut chosen = kind;
        for kinds in texts::EFFECTS.chunks(2) {
            widgets::choice(ui, tokens, kinds, kind, |kind| chosen = kind);
        }
        if chosen != kind {
            let effect = new_effect(chosen, zone);
            return change(cx, zone, |zone| zone.effect = effect);
        }
        widgets::remark(ui, tokens, texts::effect_remark(kind));
        let effect = match &zone.effect {
            ZoneEffect::KeepOut => None,
            ZoneEffect::SpeedLimit(speed) => {
                let range = [0.1, ValidationConfig::default().max_speed_m_s];
                number(ui, cx, typed, zone, (texts::SPEED, *speed), (0.1, 2, range))
                    .map(ZoneEffect::SpeedLimit)
            }
            ZoneEffect::Penalty(factor) => {
                number(ui, cx, typed, zone, (texts::PENALTY, *factor), (1.0, 1, PENALTIES))
                    .map(ZoneEffect::Penalty)
            }
            ZoneEffect::Action(request) => self.show_action(ui, cx, zone, request).map(ZoneEffect::Action),
        };
        if let Some(effect) = effect {
            change(cx, zone, |zone| zone.effect = effect);
        }
    }

    /// Which action, and its parameters. Returns the request once it is changed.
    fn show_action(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        zone: &Zone,
        request: &ActionRequest,
    ) -> Option<ActionRequest> {
        let owner = Id::unique(("action of zone", zone.id.0));
        self.parameters.keep_only(owner);
        let actions = actions_at_places();
        let titles: Vec<String> = actions.iter().map(|action| action.title.to_owned()).collect();
        let shown = action_title(&request.action);
        if let Some(index) = select(ui, cx.tokens, texts::ACTION, texts::ACTION, &shown, &titles) {
            // The parameters of another action have other names.
            let request =
                ActionRequest { action: actions[index].name.to_owned(), parameters: Parameters::new() };
            return Some(request);
        }
        let parameters = self.parameters.show(ui, cx, owner, request, false)?;
        Some(ActionRequest { parameters, ..request.clone() })
    }
}

/// A field for the number of an effect, with its step, digits and range. Returns another number once it is given.
fn number(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    zone: &Zone,
    (name, value): (&str, f64),
    (step, decimals, range): (f64, usize, [f64; 2]),
) -> Option<f64> {
    let object = ObjectId::Zone(zone.id);
    let field = NumberField { name, object, value: Some(value), hint: "", step, decimals, range };
    field.show(ui, cx, typed).flatten()
}

/// What an effect of this kind begins with.
fn new_effect(kind: EffectKind, zone: &Zone) -> ZoneEffect {
    match kind {
        EffectKind::KeepOut => ZoneEffect::KeepOut,
        EffectKind::SpeedLimit => ZoneEffect::SpeedLimit(CONFIG.speed_m_s),
        EffectKind::Penalty => ZoneEffect::Penalty(CONFIG.penalty_factor),
        EffectKind::Action => {
            let text = Parameter::Text(texts::entered(&zone.name));
            let parameters = Parameters::from([(CONFIG.parameter.to_owned(), text)]);
            ZoneEffect::Action(ActionRequest { action: CONFIG.action.to_owned(), parameters })
        }
    }
}
