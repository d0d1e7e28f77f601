//! Texts of imports, by key.

use api::ImportStage;

pub(super) const STATE: &str = "Import";
pub(super) const IMPORT: &str = "Import a map";
pub(super) const IMPORT_HINT: &str = "From a survey or another program: PCD, PLY, LAS, LAZ, E57 or PTX.";
pub(super) const IMPORT_AND_ALIGN: &str = "Import and align";
pub(super) const CANCEL: &str = "Cancel import";
pub(super) const CANCEL_SHORT: &str = "Cancel";
pub(super) const RETRY_SHORT: &str = "Try again";
pub(super) const DELETE_SHORT: &str = "Delete";

pub(super) fn import_and_align_hint(map: &str) -> String {
    format!("For the same site as {map}: the import is aligned to it by what both maps show.")
}

pub(super) fn sending(file: &str) -> String {
    format!("Sending {file}")
}

pub(super) fn stage(stage: ImportStage, map: &str) -> String {
    let doing = match stage {
        ImportStage::Reading => "Reading",
        ImportStage::ComputingViewpoints => "Computing viewpoints of",
        ImportStage::Writing => "Writing",
        ImportStage::Walking => "Walking through",
        ImportStage::MakingTopomap => "Finding nodes and ways of",
    };
    format!("{doing} {map}")
}

/// Value of the progress in the accessible tree.
pub(super) fn progress(activity: &str, percent: &str) -> String {
    format!("{activity}, {percent}")
}

/// Stands for the name of a file of which no map was to be made yet.
const UNNAMED: &str = "without a name";

/// A file that waits on the robot's computer, by the name of the map that it is to become.
pub(super) fn stored(name: Option<&str>) -> String {
    format!("Uploaded file {}", name.unwrap_or(UNNAMED))
}

/// Its size, why no map was made of it (a sentence) and how long it is kept.
pub(super) fn stored_details(size: &str, problem: Option<&str>, until: Option<&str>) -> String {
    let problem = problem.map(|problem| format!("{problem} ")).unwrap_or_default();
    let kept = until.map_or_else(|| "It is kept".to_owned(), |until| format!("It is kept until {until}"));
    format!("{problem}{kept} ({size}).")
}

pub(super) fn retry(name: Option<&str>) -> String {
    format!("Try again with {}", name.unwrap_or(UNNAMED))
}

pub(super) fn delete(name: Option<&str>) -> String {
    format!("Delete file {}", name.unwrap_or(UNNAMED))
}
