//! The screen of the robot as it is now.

mod texts;

use super::ScreenDescription;
use crate::icon;

/// What the frame shows of it.
pub(super) const DESCRIPTION: ScreenDescription =
    ScreenDescription { name: texts::NAME, icon: icon::BROADCAST, side_card: texts::SIDE_CARD };
