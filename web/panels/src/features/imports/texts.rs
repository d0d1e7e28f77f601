//! Texts of imports, by key.

use api::ImportStage;

pub(super) const STATE: &str = "Import";
pub(super) const IMPORT: &str = "Import a map";
pub(super) const IMPORT_HINT: &str = "From a survey or another program: PCD, PLY, LAS, LAZ, E57 or PTX.";
pub(super) const IMPORT_AND_ALIGN: &str = "Import and align";
pub(super) const CANCEL: &str = "Cancel import";
pub(super) const CANCEL_SHORT: &str = "Cancel";

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
    };
    format!("{doing} {map}")
}

/// Value of the progress in the accessible tree.
pub(super) fn progress(activity: &str, percent: &str) -> String {
    format!("{activity}, {percent}")
}
