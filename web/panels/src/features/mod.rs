//! The panels of features, a folder each: panel, texts by key, tests. A folder has the name of its slice in `client_model`. Only
//! `scene_labels` has no slice: it labels what several features show in the scene.
//!
//! # A new panel
//!
//! 1. A folder here, and its line in the list below.
//! 2. One line where it is shown: in a card (`map_card`, `live`) or in the panel of another feature.
//! 3. If it keeps something between frames: a struct in its folder, and its field in [`PanelState`](crate::PanelState).

pub(crate) mod alignment;
pub(crate) mod goals;
pub(crate) mod imports;
pub(crate) mod localisation;
pub(crate) mod loops;
pub(crate) mod mapping;
pub(crate) mod maps;
pub(crate) mod notices;
pub(crate) mod quality;
pub(crate) mod scene_labels;
pub(crate) mod view_settings;
