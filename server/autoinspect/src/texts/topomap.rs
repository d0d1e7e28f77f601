//! Texts of `autoinspect topomap`.

use std::path::Path;

/// A file for a topological map with an unknown ending.
pub fn unknown_topomap_format(out: &Path) -> String {
    format!("the ending of {} says no format; use .json, .yaml or .geojson, or --format", out.display())
}

/// A topological map was made; `what` describes it.
pub fn topomap_made(map: &Path, what: &str) -> String {
    format!("{}: {what}", map.display())
}
