//! What makes a map of a point cloud of somebody else's.

use api::ImportStage;
use std::ops::ControlFlow;
use std::path::Path;

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
}
