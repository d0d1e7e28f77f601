//! The screen of schedules: when missions run.

mod texts;

use super::ScreenDescription;
use crate::icon;

/// What the frame shows of it.
pub(super) const DESCRIPTION: ScreenDescription =
    ScreenDescription { name: texts::NAME, icon: icon::CALENDAR_DOTS, side_card: texts::SIDE_CARD };
