//! Panels of features, a folder each with its texts. Folders have the names of the slices in `client_model`.

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
