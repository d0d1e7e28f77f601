//! Texts of assets, by key.

use crate::name_field::NameFieldTexts;
use site_model::Asset;

pub(super) const TAB: &str = "Assets";
pub(super) const HEAD: &str = "Assets";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const ADD: &str = "New asset";
pub(super) const EMPTY: &str = "There are no assets yet. An asset is a thing that is inspected, such as a pump; several inspection points may look at it.";
pub(super) const FIND: &str = "Find an asset";
pub(super) const FIND_HINT: &str = "Name or tag";
pub(super) const NAME_FIELD: NameFieldTexts =
    NameFieldTexts { field: "Asset name", rename: "Rename asset", rename_short: "Rename" };
pub(super) const POINTS: &str = "Looked at by:";
pub(super) const NO_POINTS: &str =
    "No inspection point looks at it yet. Choose it in the form of an inspection point.";
pub(super) const DELETE_SHORT: &str = "Delete";

pub(super) fn asset(name: &str) -> String {
    format!("Asset {name}")
}

/// `Pump 3 · 2 points · cooling water, hall 4`.
pub(super) fn row(asset: &Asset, points: usize) -> String {
    let points = match points {
        0 => "no point".to_owned(),
        1 => "1 point".to_owned(),
        points => format!("{points} points"),
    };
    let tags: Vec<&str> = asset.tags.iter().map(String::as_str).collect();
    let tags = if tags.is_empty() { String::new() } else { format!(" · {}", tags.join(", ")) };
    format!("{} · {points}{tags}", asset.name)
}

pub(super) fn select_point(name: &str) -> String {
    format!("Select inspection point {name}")
}

pub(super) fn delete(name: &str) -> String {
    format!("Delete asset {name}")
}
