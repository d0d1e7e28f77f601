//! Panels of features, a folder each with its texts. Folders have the names of the slices in `client_model`.

pub(crate) mod goals;
