//! Finds what changed between two visits.

use site_model::{OrientedBox, SceneChangeKind, ShapeDescriptor};
use std::path::{Path, PathBuf};

/// What changed between two visits, with files in the folder of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundChanges {
    /// The objects, those with most points first.
    pub objects: Vec<FoundChange>,
    /// The points of all objects, a PLY file in the frame of the map.
    pub changed: PathBuf,
    /// What both visits saw, likewise.
    pub unchanged: PathBuf,
}

/// An object that changed.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundChange {
    /// What became of it.
    pub kind: SceneChangeKind,
    /// Where it is, or was if it is gone, frame of the map.
    pub place: OrientedBox,
    /// Its points.
    pub points: u32,
    /// Probability that it changed, 0 to 1.
    pub confidence: f64,
    /// Its points, a PLY file in the frame of the map.
    pub cloud: PathBuf,
    /// Of a moved one, the probability that one thing was at both places.
    pub move_probability: Option<f64>,
    /// Its shape; none of too few points.
    pub descriptor: Option<ShapeDescriptor>,
}

/// Compares visits. An implementation must protect the core from the memory and time that this takes.
pub trait ChangeFinder: Send {
    /// Compares an earlier visit, the folder of a map or of the clouds of a run, with the clouds of a later run, and writes files into the folder `out`. Asks now and then
    /// whether to give up.
    ///
    /// # Errors
    /// One sentence with the error and its remedy.
    fn compare(
        &self,
        before: &Path,
        after: &Path,
        out: &Path,
        is_cancelled: &mut dyn FnMut() -> bool,
    ) -> Result<FoundChanges, String>;
}
