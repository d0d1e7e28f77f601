//! What is wrong with a broken file, by key: the middle of [`crate::StoreError::Broken`]'s sentence. English.

/// tiles.json with a tile that does not decode.
pub(crate) const BROKEN_TILE: &str = "names a broken tile";
/// A file among tiles whose name is no hash.
pub(crate) const NO_TILE_NAME: &str = "is not named as a tile is";
/// map.json with the id of another folder.
pub(crate) const ID_OF_ANOTHER_MAP: &str = "holds the id of another map than its folder's name";
/// graph.json whose keyframes are not numbered from 0.
pub(crate) const KEYFRAMES_NOT_IN_ORDER: &str = "does not number its keyframes from 0";
/// graph.json with an invalid pose.
pub(crate) const INVALID_POSE: &str = "has a keyframe without a pose";
/// graph.g2o with an edge between keyframes that do not exist.
pub(crate) const EDGE_TO_NOWHERE: &str = "has an edge to no keyframe";
/// loops.json with a decision on keyframes that do not exist.
pub(crate) const DECISION_ON_UNKNOWN_KEYFRAMES: &str = "has decisions on keyframes that do not exist";
/// Viewpoints that the format cannot hold.
pub(crate) const VIEWPOINTS_DO_NOT_FIT: &str = "cannot hold these viewpoints";
/// A file of viewpoints that is truncated, damaged or of another version.
pub(crate) const NO_VIEWPOINT_FILE: &str = "is no file of viewpoints that this program reads";
/// A viewpoint in such a file whose indices are damaged.
pub(crate) const BROKEN_VIEWPOINT: &str = "has a viewpoint whose points cannot be understood";
