//! The sentences of `autoinspect make-normal`.

use std::path::Path;

/// A file without changes.
pub fn no_changes(path: &Path) -> String {
    format!("{} has no changes; give a file with the objects that are to be normal", path.display())
}

/// Changes that are normal now.
pub fn accepted(count: usize) -> String {
    match count {
        1 => "1 change is normal now".to_owned(),
        count => format!("{count} changes are normal now"),
    }
}

/// How well views fit a map.
pub fn fit(views: u64, fit: f64, contradicted: f64) -> String {
    format!("{views} views fit by {fit:.3} and contradict the map by {contradicted:.3}")
}
