//! What holds in a zone.

use super::change::change;
use super::effect_kind::EffectKind;
use super::texts;
use crate::feature_panel::PanelContext;
use crate::number_field::{NumberField, TypedNumber};
use crate::widgets;
use egui::Ui;
use site_model::{ObjectId, ValidationConfig, Zone, ZoneEffect};

/// Speed limit of a zone that had none, m/s: a slow walk.
const FIRST_SPEED_M_S: f64 = 0.3;
/// Factor of a zone that had none: the way round may be three times as long.
const FIRST_PENALTY: f64 = 3.0;
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
            EffectKind::SpeedLimit => ZoneEffect::SpeedLimit(FIRST_SPEED_M_S),
            EffectKind::Penalty => ZoneEffect::Penalty(FIRST_PENALTY),
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
