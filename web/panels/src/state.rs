//! What the panels keep between frames: what is unfolded, and text that is not submitted yet. A field for each feature that keeps something.

use crate::TextInputs;
use crate::features::loops::LoopsPanel;
use crate::features::mapping::MappingPanel;
use crate::features::view_settings::ViewTools;
use crate::map_card::MapCard;
use egui::Vec2;

/// State of the panels between frames.
#[derive(Debug, Default)]
pub struct PanelState {
    /// The client's offset from UTC, seconds: for dates.
    pub(crate) utc_offset_s: i64,
    /// The bridge to the page's text inputs.
    pub text_inputs: TextInputs,
    /// Below 1100 px: whether the right card is out.
    pub(crate) drawer_open: bool,
    /// Whether the keyboard shortcuts are on show.
    pub(crate) help_open: bool,
    /// Where the stick is, -1 to 1 both ways, while it is held.
    pub(crate) stick: Option<Vec2>,
    /// The right card on the Map screen.
    pub(crate) map_card: MapCard,
    /// Mapping.
    pub(crate) mapping: MappingPanel,
    /// Loops of the map under construction.
    pub(crate) loops: LoopsPanel,
    /// The view tools.
    pub(crate) view_settings: ViewTools,
}

impl PanelState {
    /// For a page that lays its own inputs over the text fields.
    pub fn for_page(utc_offset_s: i64) -> Self {
        Self { utc_offset_s, text_inputs: TextInputs::new(true), ..Self::default() }
    }
}
