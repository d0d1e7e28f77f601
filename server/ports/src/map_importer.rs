//! What makes a map of a point cloud of somebody else's.

use api::ImportStage;
use std::ops::ControlFlow;
use std::path::Path;
use vocab::Vec3;

/// Makes maps of files. Whoever implements this sees to it that neither a file nor its size can harm the core.
pub trait MapImporter: Send {
    /// Makes a map called `name` of `file` in the folder `out`, with its tiles in `out/tiles`, laid into the frame of the map in the folder
    /// `frame` if there is one. Says how far it is, 0 to 1 in each stage, and is told whether to go on.
    ///
    /// # Errors
    /// One sentence: what is wrong and what to do.
    fn import(
        &self,
        file: &Path,
        name: &str,
        frame: Option<&Path>,
        out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String>;

    /// Makes a map called `name` in the folder `out` of the first of two maps' folders, laid into the frame of the second: by points picked in
    /// both, that of the first one first (metres), or, where there are none, by what both look like. Otherwise as [`Self::import`].
    ///
    /// # Errors
    /// As for [`Self::import`].
    fn align(
        &self,
        maps: [&Path; 2],
        pairs: &[[Vec3; 2]],
        name: &str,
        out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String>;
}
