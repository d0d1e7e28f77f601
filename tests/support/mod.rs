//! What the tests stand on: the program under test, a real browser, and waiting without guessing.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub mod chromium;
pub mod devtools;
pub mod page;
pub mod picture;
pub mod program;
pub mod server;

/// The repository's root folder.
pub fn workspace_root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// Recordings and files that are not part of the repository; `None`, with a line that says so, where they are absent.
pub fn shared_data(below: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("AUTOINSPECT_DATA")
        .map_or_else(|| workspace_root().join("../shared/data"), PathBuf::from)
        .join(below);
    if !folder.exists() {
        println!("skipped: no test data at {} (AUTOINSPECT_DATA names its folder)", folder.display());
        return None;
    }
    Some(folder)
}

/// Polls `condition` until it gives a value, and fails, naming `what`, when `limit` has passed without.
#[track_caller]
pub fn wait_for<T>(what: &str, limit: Duration, mut condition: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(value) = condition() {
            return value;
        }
        assert!(started.elapsed() < limit, "waited {} s in vain for {what}", limit.as_secs());
        std::thread::sleep(Duration::from_millis(40));
    }
}
