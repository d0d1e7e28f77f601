//! The screen of missions: their list, and the editor of one.

mod texts;

use super::ScreenDescription;
use crate::icon;

/// What the frame shows of it.
pub(super) const DESCRIPTION: ScreenDescription =
    ScreenDescription { name: texts::NAME, icon: icon::LIST_CHECKS, side_card: texts::SIDE_CARD };
