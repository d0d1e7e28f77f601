//! The screen of the site: its topological map, edited.

mod texts;

use super::ScreenDescription;
use crate::icon;

/// What the frame shows of it.
pub(super) const DESCRIPTION: ScreenDescription =
    ScreenDescription { name: texts::NAME, icon: icon::GRAPH, side_card: texts::SIDE_CARD };
