//! Why a command that was started in another process has failed.

use crate::texts;
use std::io::{BufRead, BufReader};
use std::process::ChildStderr;

/// The last line of standard error, as a sentence.
pub fn complaint(errors: Option<ChildStderr>) -> String {
    let lines = errors.into_iter().flat_map(|errors| BufReader::new(errors).lines().map_while(Result::ok));
    let last = lines.filter_map(|line| line.strip_prefix("error: ").map(str::to_owned)).last();
    last.map_or_else(
        || texts::IMPORT_ENDED_EARLY.to_owned(),
        |sentence| format!("{}.", sentence.trim_end_matches('.')),
    )
}
