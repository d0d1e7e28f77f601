//! What holds in a zone.

use super::change::change;
use super::effect_kind::EffectKind;
use super::texts;
use crate::feature_panel::PanelContext;
use crate::number_field::{NumberField, TypedNumber};
use crate::widgets;
use egui::Ui;
use site_model::{ObjectId, ValidationConfig, Zone, ZoneEffect};

/// Values of an effect that a zone had not before.
struct NewEffectConfig {
    /// Speed limit, metres a second: a slow walk. Chosen: a third of the default robot's speed (0.9 m/s).
    speed_m_s: f64,
    /// Factor of the cost: another path may be three times as long. Chosen: as of ground that was never seen (`navigation::PlannerConfig`).
    penalty_factor: f64,
}

const CONFIG: NewEffectConfig = NewEffectConfig { speed_m_s: 0.3, penalty_factor: 3.0 };

/// Factors that people may enter.
const PENALTIES: [f64; 2] = [1.0, 100.0];

/// Shows the kinds, and the number of the present one.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, typed: &mut TypedNumber, zone: &Zone) {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, texts::EFFECT_HEAD);
    let kind = EffectKind::of(&zone.effect);
    let mut chosen = kind;
    widgets::choice(ui, tokens, &texts::EFFECTS, kind, |kind| chosen = kind);
    if chosen != kind {
        let effect = match chosen {
            EffectKind::SpeedLimit => ZoneEffect::SpeedLimit(CONFIG.speed_m_s),
            EffectKind::Penalty => ZoneEffect::Penalty(CONFIG.penalty_factor),
            EffectKind::KeepOut | EffectKind::Action => ZoneEffect::KeepOut,
        };
        return change(cx, zone, |zone| zone.effect = effect);
    }
    widgets::remark(ui, tokens, texts::effect_remark(kind));
    let object = ObjectId::Zone(zone.id);
    match zone.effect {
        ZoneEffect::SpeedLimit(speed) => {
            let range = [0.1, ValidationConfig::default().max_speed_m_s];
            let field = NumberField {
                name: texts::SPEED,
                object,
                value: Some(speed),
                hint: "",
                step: 0.1,
                decimals: 2,
                range,
            };
            if let Some(speed) = field.show(ui, cx, typed).flatten() {
                change(cx, zone, |zone| zone.effect = ZoneEffect::SpeedLimit(speed));
            }
        }
        ZoneEffect::Penalty(factor) => {
            let field = NumberField {
                name: texts::PENALTY,
                object,
                value: Some(factor),
                hint: "",
                step: 1.0,
                decimals: 1,
                range: PENALTIES,
            };
            if let Some(factor) = field.show(ui, cx, typed).flatten() {
                change(cx, zone, |zone| zone.effect = ZoneEffect::Penalty(factor));
            }
        }
        ZoneEffect::KeepOut | ZoneEffect::Action(_) => {}
    }
}
