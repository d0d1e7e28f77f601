//! The kinds of what holds in a zone.

use site_model::ZoneEffect;

/// What a zone does, without its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EffectKind {
    KeepOut,
    SpeedLimit,
    Penalty,
    Action,
}

impl EffectKind {
    pub(super) fn of(effect: &ZoneEffect) -> Self {
        match effect {
            ZoneEffect::KeepOut => Self::KeepOut,
            ZoneEffect::SpeedLimit(_) => Self::SpeedLimit,
            ZoneEffect::Penalty(_) => Self::Penalty,
            ZoneEffect::Action(_) => Self::Action,
        }
    }
}
