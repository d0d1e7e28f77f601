//! What is unfolded and half typed: of no interest to anyone but the views.

use client_model::{LoopPair, Selection};
use egui::{Rect, Vec2};

/// State of the views between frames.
#[derive(Debug, Default)]
pub struct PanelState {
    /// Name typed for the map under construction.
    pub map_name: String,
    /// The client's offset from UTC, seconds: for dates.
    pub(crate) utc_offset_s: i64,
    /// Whether the shell lays real text inputs over [`Self::text_fields`]; else egui's own are drawn.
    pub(crate) outside_inputs: bool,
    /// Where text is typed in this frame.
    pub text_fields: Vec<TextField>,
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
    /// For a page that lays inputs of its own over the panels' text fields.
    pub fn for_page(utc_offset_s: i64) -> Self {
        Self { utc_offset_s, outside_inputs: true, ..Self::default() }
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

/// A place where text is typed.
#[derive(Clone, Debug, PartialEq)]
pub struct TextField {
    /// Accessible name.
    pub name: &'static str,
    /// Where, points.
    pub rect: Rect,
    /// Shown while empty.
    pub hint: String,
}
