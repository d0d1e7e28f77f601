//! Texts for people, by key, English. The constants say what is wrong with a broken file: the middle of [`StoreError::Broken`]'s sentence.

use crate::StoreError;
use ports::error_with_causes;
use std::path::{Path, PathBuf};

/// Why the last segments of a run are pinned that did not end in order.
pub(crate) const PROGRAM_INTERRUPTED: &str = "The program was interrupted.";
/// tiles.json with a tile that does not decode.
pub(crate) const BROKEN_TILE: &str = "names a broken tile";
/// A file among tiles whose name is no hash.
pub(crate) const NO_TILE_NAME: &str = "is not named as a tile is";
/// A file among those of actions whose name is no hash.
pub(crate) const NO_BLOB_NAME: &str = "is not named by the BLAKE3 of its bytes, so nothing refers to it";
/// checksums.b3 with a line that is none.
pub(crate) const BROKEN_CHECKSUMS: &str = "has a line that is no checksum";
/// A map's folder without checksums.b3.
pub(crate) const CHECKSUMS_MISSING: &str =
    "is missing, so damage to the other files of the map cannot be found";
/// checksums.b3 without a file of its folder.
pub(crate) const CHECKSUM_LACKS_FILE: &str = "has no checksum for some of the files beside it";
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

/// A file of an action that is refused, because the disk is nearly full. A clause after the name of the file.
pub(crate) const DISK_NEARLY_FULL: &str =
    "the robot's disk is nearly full; delete maps for good or recordings";

/// A file of an action that is refused, because it is too long. A clause after the name of the file.
pub(crate) fn blob_too_long(bytes: u64, max_bytes: u64) -> String {
    format!("it has {bytes} bytes; {max_bytes} are allowed")
}

/// A ledger in whose place there is a directory.
pub(crate) const LEDGER_IS_DIRECTORY: &str = "is a directory and not a database";
/// A ledger without content.
pub(crate) const LEDGER_IS_EMPTY: &str = "is empty";
/// A database of another program.
pub(crate) const NO_LEDGER: &str = "is not a ledger of AutoInspect";
/// A ledger whose structure is damaged.
pub(crate) const LEDGER_STRUCTURE: &str = "has a damaged structure";
/// A row of the ledger that does not match its checksum.
pub(crate) const DAMAGED_ROW: &str = "has a row that does not match its checksum";
/// An audit log with a gap.
pub(crate) const AUDIT_LOG_CHANGED: &str =
    "has an audit log of which an entry was changed, removed or put in between";

/// The ledger at `path` was put aside and a new one begun with this number of `documents`. `damage` is what is wrong, if it was found just now.
pub(crate) fn ledger_begun_anew(
    path: &Path,
    damage: Option<&StoreError>,
    aside: &Path,
    documents: usize,
) -> String {
    let reason =
        damage.map_or_else(|| format!("{} was missing", path.display()), |damage| error_with_causes(damage));
    format!(
        "{reason}. The file was kept as {}, and a new one was begun with the {documents} documents of the site that could still be read. Look whether anything is missing; runs and results of before are in the old file only.",
        aside.display()
    )
}

/// The write-ahead log of the ledger is damaged; a copy of it is kept at `aside`.
pub(crate) fn wal_damaged(wal: &Path, aside: &Path) -> String {
    format!(
        "{} does not match its checksums. What was changed of the site last may be missing; look at it. A copy was kept as {}.",
        wal.display(),
        aside.display()
    )
}

/// What follows from a `place.json` that cannot be read.
pub(crate) const POSE_IS_FORGOTTEN: &str =
    "The robot has to find its pose in the map again, which takes some seconds.";
/// What follows from a `docks.json` that cannot be read.
pub(crate) const DOCKS_ARE_FORGOTTEN: &str =
    "The robot does not know its docks until it has been charged at each of them again.";

/// A file was written by a later program. `consequence` is a sentence.
pub(crate) fn file_of_later_program(error: &StoreError, consequence: &str) -> String {
    format!(
        "{}. The file is left as it is and nothing is written to it. {consequence}",
        error_with_causes(error)
    )
}

/// A file could not be read, and was put aside or could not be. `consequence` is a sentence.
pub(crate) fn file_damaged(
    error: &StoreError,
    aside: &Result<PathBuf, StoreError>,
    consequence: &str,
) -> String {
    format!("{}. {}. {consequence}", error_with_causes(error), kept_as(aside))
}

/// Where a file is that was put aside; a clause.
fn kept_as(aside: &Result<PathBuf, StoreError>) -> String {
    match aside {
        Ok(path) => format!("The file is kept as {}", path.display()),
        Err(failure) => format!("The file could not be put aside: {}", error_with_causes(failure)),
    }
}

/// A stop of motion is in a file that could not be read for this reason. It was put aside, or could not be.
pub(crate) fn stop_latch_damaged(error: &StoreError, aside: &Result<PathBuf, StoreError>) -> String {
    let reason = error_with_causes(error);
    let kept = kept_as(aside);
    format!(
        "{reason}. It says whether motion is stopped, so motion counts as stopped. {kept}. Allow motion when the robot may move."
    )
}

/// The file with a stop of motion was put aside, and none was written since.
pub(crate) fn stop_latch_lost(path: &Path) -> String {
    format!(
        "{} was damaged, and motion was not allowed since. Motion counts as stopped; allow it when the robot may move.",
        path.display()
    )
}

/// The note as which map a session was being saved cannot be read.
pub(crate) fn saving_note_damaged(error: &StoreError) -> String {
    format!(
        "{}. It says as which map an interrupted mapping session was being saved. Before you save that session, look whether its map is in the list.",
        error_with_causes(error)
    )
}

/// A session's journal is damaged from some record on.
pub(crate) fn journal_damaged(path: &Path, keyframes: usize) -> String {
    format!(
        "{} is damaged, so of this interrupted mapping session {keyframes} keyframes can be saved. The file is kept until the session is saved or discarded.",
        path.display()
    )
}

/// A session's journal cannot be read at all.
pub(crate) fn journal_unreadable(error: &StoreError) -> String {
    format!(
        "{}, so this interrupted mapping session cannot be saved. Its files are kept until it is discarded.",
        error_with_causes(error)
    )
}

/// A cloud of an interrupted session cannot be read, and was put aside.
pub(crate) fn cloud_damaged(error: &StoreError, aside: &Path) -> String {
    let name = aside.file_name().unwrap_or_default().display();
    format!(
        "{}. The map was saved without this cloud; it is kept in the map's folder as clouds/{name}.",
        error_with_causes(error)
    )
}
pub(crate) const BROKEN_RUN_CLOUD: &str = "it is no cloud of a run, or it is damaged";
