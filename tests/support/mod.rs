//! Shared code of the tests: the program under test, a real browser, and waiting for conditions.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub mod chromium;
pub mod devtools;
pub mod effort;
pub mod operator;
pub mod page;
pub mod picture;
pub mod program;
pub mod server;

/// The repository's root folder.
pub fn workspace_root() -> PathBuf {
    // Cargo sets this variable when it runs the tests. The path from compile time is wrong if two clones share a target folder.
    let manifest =
        std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    Path::new(&manifest).parent().unwrap().to_owned()
}

/// Source files below a folder, in order, without files that contain only tests.
pub fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if name != "tests" && name != "benches" && name != "examples" {
                files.extend(rust_files(&path));
            }
        } else if name.ends_with(".rs") && !name.ends_with("tests.rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// Waits from this length on are printed, so that the log of a test says what it spends its time on.
const PRINTED_WAIT: Duration = Duration::from_secs(2);

/// Polls `condition` until it gives a value, and prints long waits. Fails after `limit` with a message that contains `what`.
#[track_caller]
pub fn wait_for<T>(what: &str, limit: Duration, mut condition: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(value) = condition() {
            if started.elapsed() >= PRINTED_WAIT {
                println!("waited {:.1} s for {what}", started.elapsed().as_secs_f64());
            }
            return value;
        }
        assert!(started.elapsed() < limit, "waited {} s for {what}, which did not happen", limit.as_secs());
        std::thread::sleep(Duration::from_millis(40));
    }
}
