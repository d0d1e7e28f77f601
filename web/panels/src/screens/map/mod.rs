//! The screen of maps: making and viewing them.

mod texts;

use super::ScreenDescription;
use crate::icon;

/// What the frame shows of it.
pub(super) const DESCRIPTION: ScreenDescription =
    ScreenDescription { name: texts::NAME, icon: icon::MAP_TRIFOLD, side_card: texts::SIDE_CARD };
