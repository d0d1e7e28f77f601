//! The screen of runs: the one under way, the queue, and those that have ended.

mod texts;

use super::ScreenDescription;
use crate::icon;

/// What the frame shows of it.
pub(super) const DESCRIPTION: ScreenDescription =
    ScreenDescription { name: texts::NAME, icon: icon::PLAY, side_card: texts::SIDE_CARD };
