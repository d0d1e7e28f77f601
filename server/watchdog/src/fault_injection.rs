//! Faults of threads for tests: a thread panics or hangs at its next heartbeat when a file with its name appears.

use std::path::PathBuf;
use std::thread;
use std::time::Duration;

/// Where tests ask for faults. Without a folder, which is the rule, nothing is looked for.
#[derive(Clone, Debug, Default)]
pub struct FaultInjection {
    folder: Option<PathBuf>,
}

impl FaultInjection {
    /// Looks for the files `panic-NAME` and `hang-NAME` in a folder at each heartbeat of a thread with that name. The thread removes the file first, so that
    /// the fault strikes once.
    pub fn from_folder(folder: Option<PathBuf>) -> Self {
        Self { folder }
    }

    /// Panics or hangs if a test asks for it.
    pub(crate) fn inject(&self, thread: &str) {
        let Some(folder) = &self.folder else { return };
        let is_asked = |fault: &str| std::fs::remove_file(folder.join(format!("{fault}-{thread}"))).is_ok();
        assert!(!is_asked("panic"), "a test asked for it");
        if is_asked("hang") {
            loop {
                thread::sleep(Duration::from_secs(3_600));
            }
        }
    }
}
