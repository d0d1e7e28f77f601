//! Names of saved maps in sentences of all features.

use client_model::Model;
use vocab::MapId;

/// Stands for the name of a map that is not in the list.
const UNKNOWN_MAP: &str = "the map";

/// Name of a saved map, for a sentence.
pub(crate) fn map_name(model: &Model, map: MapId) -> &str {
    let known = model.maps().list().into_iter().flatten().find(|summary| summary.id == map);
    known.map_or(UNKNOWN_MAP, |summary| &summary.name)
}
