//! The tabs of the side card in which several features have sections. A tab of one feature only is defined in its folder.

use crate::feature_panel::Tab;
use crate::screens;

/// What the robot reports of itself.
pub(crate) const ROBOT: Tab = Tab { screen: screens::LIVE, name: "Robot", scrolls: true, row_spacing: 6.0 };

/// The mapping session and the saved maps.
pub(crate) const SESSION: Tab =
    Tab { screen: screens::MAP, name: "Session", scrolls: true, row_spacing: 8.0 };

/// Missions: their list, or the one that is edited.
pub(crate) const MISSIONS: Tab =
    Tab { screen: screens::MISSIONS, name: "Missions", scrolls: false, row_spacing: 8.0 };
