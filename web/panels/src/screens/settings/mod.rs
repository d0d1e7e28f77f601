//! The screen of settings: site, robot, data.

mod texts;

use super::ScreenDescription;
use crate::icon;

/// What the frame shows of it.
pub(super) const DESCRIPTION: ScreenDescription =
    ScreenDescription { name: texts::NAME, icon: icon::GEAR, side_card: texts::SIDE_CARD };
