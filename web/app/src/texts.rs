//! Texts of transfers, decoding and the page for the operator, by key. Messages of the browser's log stand where they are logged.

use vocab::KeyframeId;

/// Accessible name of the 3D view.
pub(crate) const SCENE: &str = "Map in 3D";

pub(crate) const NO_PAGE: &str = "there is no page";
pub(crate) const SERVER_SILENT: &str =
    "The robot's server does not answer. Check the network, then try again.";
pub(crate) const DOCUMENT_UNREADABLE: &str =
    "The server sent a document this page cannot read. Reload the page.";
pub(crate) const FILE_UNREADABLE: &str = "This page cannot show the file. Open it in a tab of its own.";
pub(crate) const UPLOAD_UNSUPPORTED: &str = "This browser cannot send files.";
pub(crate) const UPLOAD_INCOMPLETE: &str =
    "The robot's server did not take all of it. Check the network, then try again.";

pub(crate) const PLAN_FILE_TOO_LONG: &str = "it is longer than any plan";
pub(crate) const PLAN_FILE_NO_TEXT: &str = "the browser could not read it as text";

/// A file of missions and schedules that cannot be read. `reason` is a sentence without its full stop.
pub(crate) fn plan_file_unreadable(name: &str, reason: &str) -> String {
    format!("{name} is no file of missions and schedules that this page can read: {reason}.")
}

/// A response without an explanation, with its HTTP status.
pub(crate) fn server_error(status: u16) -> String {
    format!("The robot's server answered with error {status}. Try again.")
}

pub(crate) fn scan_unreadable(keyframe: KeyframeId) -> String {
    format!("The scan of keyframe {} cannot be read. Reload the page.", keyframe.0)
}
