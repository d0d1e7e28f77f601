//! What is unfolded and half typed: of no interest to anyone but the views.

use crate::TextInputs;
use client_model::{LoopPair, Selection};
use egui::Vec2;

/// State of the views between frames.
#[derive(Debug, Default)]
pub struct PanelState {
    /// Name typed for the map under construction.
    pub map_name: String,
    /// The client's offset from UTC, seconds: for dates.
    pub(crate) utc_offset_s: i64,
    /// The bridge to the page's text inputs.
    pub text_inputs: TextInputs,
    /// Below 1100 px: whether the right card is out.
    pub(crate) drawer_open: bool,
    /// Below 700 px: whether the tools are out.
    pub(crate) tools_open: bool,
    /// Whether the keyboard shortcuts are on show.
    pub(crate) help_open: bool,
    /// Which part of the Map panel is on show.
    pub(crate) map_part: MapPart,
    /// What was selected in the last frame: when a loop gets selected, its evidence is brought forth.
    pub(crate) selection: Option<Selection>,
    /// The loop that the list was scrolled to last.
    pub(crate) listed_loop: Option<LoopPair>,
    /// Whether the person is asked if the map shall really be discarded.
    pub(crate) confirm_discard: bool,
    /// Where the stick is, -1 to 1 both ways, while it is held.
    pub(crate) stick: Option<Vec2>,
    /// Name typed for a view to remember.
    pub(crate) bookmark_name: String,
}

impl PanelState {
    /// For a page that lays its own inputs over the text fields.
    pub fn for_page(utc_offset_s: i64) -> Self {
        Self { utc_offset_s, text_inputs: TextInputs::new(true), ..Self::default() }
    }
}

/// Parts of the Map panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum MapPart {
    /// Making a map, and the maps that were made.
    #[default]
    Session,
    /// Its loops.
    Loops,
}
