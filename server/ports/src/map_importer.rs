//! Makes maps of imported point clouds.

use api::ImportStage;
use site_model::SceneChange;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use vocab::Vec3;

/// Makes maps of imported files. An implementation must protect the core from broken and very large files.
pub trait MapImporter: Send {
    /// Makes a map called `name` of `file` in the folder `out`, with its tiles in `out/tiles`. If `frame` is given, the map gets the frame of the map in that
    /// folder. `progress` is called with the stage and its share done, 0 to 1, and decides whether to continue.
    ///
    /// # Errors
    /// One sentence with the error and its remedy.
    fn import(
        &self,
        file: &Path,
        name: &str,
        frame: Option<&Path>,
        out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String>;

    /// Makes a map called `name` in the folder `out`: the first of two maps (folders) in the frame of the second. The alignment is computed from points picked in
    /// both (metres; the first map's point first), or found by place recognition if there are no pairs. Otherwise as [`Self::import`].
    ///
    /// # Errors
    /// The errors of [`Self::import`].
    fn align(
        &self,
        maps: [&Path; 2],
        pairs: &[[Vec3; 2]],
        name: &str,
        out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String>;

    /// Makes a new version, called `name`, of the map in the folder `map`, in which these changes are normal. The folders `after` have the clouds of the runs that found them.
    /// Otherwise as [`Self::import`].
    ///
    /// # Errors
    /// The errors of [`Self::import`].
    fn make_normal(
        &self,
        map: &Path,
        after: &[PathBuf],
        changes: &[SceneChange],
        name: &str,
        out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String>;
}
