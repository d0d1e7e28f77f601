//! Names of saved maps in sentences of all features.

use crate::texts;
use client_model::Model;
use vocab::MapId;

/// Name of a saved map, for a sentence.
pub(crate) fn map_name(model: &Model, map: MapId) -> &str {
    let known = model.maps().list().into_iter().flatten().find(|summary| summary.id == map);
    known.map_or(texts::UNKNOWN_MAP, |summary| &summary.name)
}
