//! Waits for a command that was started in another process.

use crate::texts;
use std::process::{Child, ExitStatus};
use std::thread;
use std::time::Duration;

/// Waits until the child has ended, or ends it. Asks once in each `poll_period` whether to give up.
///
/// # Errors
/// One sentence: it was given up, or what became of it is not known.
pub fn wait(
    child: &mut Child,
    poll_period: Duration,
    is_cancelled: &mut dyn FnMut() -> bool,
) -> Result<ExitStatus, String> {
    loop {
        if let Some(status) = child.try_wait().map_err(|error| texts::import_outcome_unknown(&error))? {
            return Ok(status);
        }
        if is_cancelled() {
            // The child may have ended by itself in the meantime.
            let _ = child.kill();
            let _ = child.wait();
            return Err(texts::IMPORT_CANCELLED.to_owned());
        }
        thread::sleep(poll_period);
    }
}
