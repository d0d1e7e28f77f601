//! The tabs of the side card in which several features have sections. A tab of one feature only is defined in its folder.

use crate::feature_panel::Tab;
use crate::{screens, texts};

/// What the robot reports of itself.
pub(crate) const ROBOT: Tab =
    Tab { screen: screens::LIVE, name: texts::ROBOT_TAB, scrolls: true, row_spacing: 6.0 };

/// The mapping session and the saved maps.
pub(crate) const SESSION: Tab =
    Tab { screen: screens::MAP, name: texts::SESSION_TAB, scrolls: true, row_spacing: 8.0 };

/// Missions: their list, or the one that is edited.
pub(crate) const MISSIONS: Tab =
    Tab { screen: screens::MISSIONS, name: texts::MISSIONS_TAB, scrolls: false, row_spacing: 8.0 };
