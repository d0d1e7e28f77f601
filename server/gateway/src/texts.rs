//! Sentences of the gateway for people, by key: refusals of commands, reasons of closed sockets, and details of HTTP errors. English.

/// Characters of a client's text that a sentence shows, at most.
const MAX_SHOWN_CHARS: usize = 100;

/// Name of a place in an archive whose object the site no longer has.
pub(crate) const UNNAMED_PLACE: &str = "place";

// The core.

/// Before the first connection to the core.
pub(crate) const CORE_NOT_REACHED: &str = "The robot's core has not been reached yet.";
/// A command that the core had not answered when its connection ended.
pub(crate) const CORE_LOST_BEFORE_ANSWER: &str = "The robot's core went away before it answered. Look at what the robot does before you repeat the command.";
/// A command while the core is not connected.
pub(crate) const CORE_LOST: &str =
    "The server has lost the robot's core, so nothing was done. It reconnects by itself; try again.";

/// Reasons why a file of a certificate or its key is not used; clauses after its name.
pub(crate) const NO_CERTIFICATE: &str = "it holds no certificate";
pub(crate) const OTHER_KEY: &str = "it is not the key of the certificate";

/// A connection beyond the limit.
pub(crate) const NO_PLACE_FOR_CONNECTION: &str = "Too many connections are open. Close some, then try again.";
/// A request over a reserved connection that is not for one.
pub(crate) const TOO_MANY_CONNECTIONS: &str = "Too many connections are open, and the last ones are kept for signing in and for stopping motion. Close some, then try again.";

/// Why there is no core; `reason` is a clause after "The robot's core".
pub(crate) fn core_fault(reason: impl std::fmt::Display) -> String {
    format!("The robot's core {reason}.")
}

/// Clauses for [`core_fault`].
pub(crate) const CORE_SENDS_NO_HELLO: &str = "sends no hello";
pub(crate) fn core_not_reachable(error: &dyn std::fmt::Display) -> String {
    format!("cannot be reached: {error}")
}
pub(crate) fn core_broke_connection(error: &dyn std::fmt::Display) -> String {
    format!("broke the connection: {error}")
}
pub(crate) fn core_sent_no_message(error: &dyn std::fmt::Display) -> String {
    format!("sent bytes that are no message: {error}")
}
pub(crate) fn core_version(core: u16, server: u16) -> String {
    format!(
        "speaks version {core} of the contract and this server version {server}: start both from the same program"
    )
}

/// The gateway failed and runs again; `cause` is a clause.
pub(crate) fn server_restarted(cause: &str) -> String {
    format!("The server for browsers {cause}, and was started again. The robot's core went on meanwhile.")
}

// Sockets.

pub(crate) const CONNECTION_CLOSING: &str = "This connection is closing.";
/// The queue to the core or the client's share of it is full.
pub(crate) const CORE_BUSY: &str =
    "The robot has not answered earlier commands yet. Wait for it, then try again.";
pub(crate) const COMMANDS_TOO_FAST: &str =
    "This client sends commands too fast. Wait a second, then try again.";
pub(crate) const ANSWERS_NOT_READ: &str =
    "This client asks faster than it reads the answers. Reload the page.";
pub(crate) const NO_HELLO: &str = "A client says hello first.";
pub(crate) const SECOND_HELLO: &str = "A client says hello only once.";
pub(crate) const MESSAGE_NOT_BINARY: &str = "Messages are binary (postcard), not text.";
pub(crate) const TOO_MANY_STREAMS: &str = "too many streams";
pub(crate) const STREAM_NOT_OPENED: &str = "a stream is opened first";
pub(crate) const UNKNOWN_FRAME: &str = "a frame was acknowledged that was never sent";
/// Reason in a close frame: no message for too long.
pub(crate) const CLOSED_FOR_SILENCE: &str = "nothing was heard for too long";
/// Reason in a close frame: the gateway ends.
pub(crate) const CLOSED_BY_SHUTDOWN: &str = "the server stops";

pub(crate) fn too_many_clients(max_clients: usize) -> String {
    format!("The server already has {max_clients} clients. Close one, then reload.")
}
/// An account has taken its share of the clients.
pub(crate) fn too_many_clients_of_account(most: usize) -> String {
    format!("Your account already has {most} clients. Close one, then reload.")
}
pub(crate) fn wrong_version(client: u16, server: u16) -> String {
    format!(
        "This client speaks version {client} of the contract and the server version {server}. Reload the page to get the client that fits."
    )
}
pub(crate) fn message_not_understood(error: impl std::fmt::Display) -> String {
    format!("Not understood: {error}. Reload to get the client that fits.")
}

// HTTP.

pub(crate) const MAPS_NOT_LISTED: &str =
    "The robot's core has not sent its list of maps yet. Try again in a moment.";
pub(crate) const MAP_ID_MALFORMED: &str = "A map is named by a UUID. GET /api/v1/maps lists them.";
pub(crate) const TILE_HASH_MALFORMED: &str = "A tile is named by 64 hexadecimal digits.";
pub(crate) const BLOB_HASH_MALFORMED: &str = "A file of an action is named by 64 hexadecimal digits.";
pub(crate) const KEYFRAME_MALFORMED: &str = "A session is named by a UUID, a keyframe by its number from 0.";
pub(crate) const FILES_ARE_READ_ONLY: &str = "Files can only be read (GET, HEAD).";
pub(crate) const PAGE_NOT_INSTALLED: &str =
    "The page is not installed with this server. Start the server with its folder of static files.";
pub(crate) const PATH_IS_WEBSOCKET: &str = "This path is a WebSocket. Connect to it with one (version 13).";
pub(crate) const FOREIGN_ORIGIN: &str =
    "Only pages from this server may connect. Open the client at the server's own address.";
pub(crate) const FILE_NOT_READ: &str = "The server could not read the file from its disk.";

pub(crate) const DOCUMENT_TOO_LONG: &str = "The document is too long. A name has up to 120 characters.";
pub(crate) const RENAME_MALFORMED: &str = "Send a JSON object with the new name: {\"name\": \"Pump hall\"}.";
pub(crate) const COMMAND_NOT_ANSWERED: &str = "The robot has not answered yet; its disk is busy. It may still be done: ask for the list again in a minute.";

pub(crate) fn not_in_bin(map: impl std::fmt::Display) -> String {
    format!("There is no map {map} in the bin. GET /api/v1/maps/bin lists them.")
}
pub(crate) fn no_map(map: impl std::fmt::Display) -> String {
    format!("There is no map {map}. GET /api/v1/maps lists them.")
}
pub(crate) fn page_malformed(max_entries: usize) -> String {
    format!(
        "A page is chosen by ?limit=1 to {max_entries} and ?after=, the id of the last entry that was read."
    )
}
pub(crate) fn page_gone(after: &str) -> String {
    let after = vocab::legible(after, MAX_SHOWN_CHARS);
    format!("There is no {after} in the list any more. Begin with its first page.")
}
pub(crate) fn no_tile(hash: &str) -> String {
    format!("There is no tile {hash}. Ask for the list of tiles anew.")
}
pub(crate) const NO_RUN_CLOUD: &str =
    "There is no such cloud of this run. It may have made room for those of later runs.";
pub(crate) fn no_blob(hash: &str) -> String {
    format!("There is no file {hash}. Ask for the result of the action anew.")
}
pub(crate) fn no_such_part(bytes: u64) -> String {
    format!("The file has no such part. It has {bytes} bytes; ask for a range within them.")
}
pub(crate) fn no_keyframe_scan(keyframe: u32) -> String {
    format!(
        "The scan of keyframe {keyframe} is not kept: scans of keyframes are there while their map is being made."
    )
}
pub(crate) fn no_path(path: &str) -> String {
    format!("There is no {path}. See /api/v1/openapi.json.")
}
pub(crate) fn no_file(path: &str) -> String {
    format!("There is no file {path}.")
}
pub(crate) fn method_not_allowed(path: &str, method: impl std::fmt::Display) -> String {
    format!("{path} cannot be asked with {method}. See /api/v1/openapi.json.")
}

// The site.

pub(crate) const SITE_NOT_READ: &str = "The robot's core has not sent the documents of the site yet. Try again in a moment; the notices say what keeps it.";
pub(crate) const CHANGES_NOT_NORMAL: &str =
    "These changes cannot become normal together, so nothing was begun; each wrong one is named.";
pub(crate) const NO_SUCH_CHANGE: &str = "The site has no such change. GET /api/v1/scene-changes lists them.";
pub(crate) const CHANGE_OF_OTHER_MAP: &str =
    "This change is of another map than the first one. Make a version of one map at a time.";

/// Too few or too many changes at once.
pub(crate) fn number_of_changes(most: usize) -> String {
    format!("Name 1 to {most} changes.")
}

pub(crate) const OBJECT_ID_MALFORMED: &str = "An object is named by a UUID.";
pub(crate) const RUN_ID_MALFORMED: &str = "A run is named by a UUID. GET /api/v1/runs lists them.";
pub(crate) const POINT_ID_MALFORMED: &str =
    "An inspection point is named by a UUID. GET /api/v1/site/inspection-points lists them.";
pub(crate) const BEFORE_NO_RUN: &str = "before is not the id of a run";
pub(crate) const BEFORE_NO_NUMBER: &str = "before is not a number";
pub(crate) const BEFORE_NO_SLOT: &str = "before is not the next of a page";
pub(crate) const AFTER_NO_NUMBER: &str = "after is not a number";
pub(crate) const AFTER_NO_CHANGE: &str = "after is not the next of a page";
pub(crate) const AFTER_NO_ALERT: &str = "after is not the next of a page";
pub(crate) const AFTER_NO_STEP: &str = "after is not a step and an attempt, such as 3.1";
pub(crate) const DOWNLOADS_BUSY: &str =
    "Other runs or reports are being downloaded. Wait until one of them is complete.";
pub(crate) const DOWNLOAD_STALLED: &str = "the client has read nothing for too long";
pub(crate) const SETTINGS_ID_MALFORMED: &str = "The settings of the site are at /api/v1/site/settings/main.";
pub(crate) const IF_MATCH_MALFORMED: &str =
    "If-Match holds the entity tag of one revision, such as \"3\", or *.";
pub(crate) const IF_MATCH_MISSING: &str = "Say which revision you change: send its entity tag (the ETag of a GET) as If-Match, so that nobody's change is lost.";
pub(crate) const IDEMPOTENCY_KEY_MALFORMED: &str = "An Idempotency-Key is a UUID that the client makes.";
pub(crate) const SITE_DOCUMENT_MALFORMED: &str =
    "The document cannot be understood; each wrong field is named.";
pub(crate) const SITE_DOCUMENT_TOO_LONG: &str =
    "The document is too long. An object has up to 1 MB of JSON, an edit up to 16 MB.";
pub(crate) const EDIT_TOO_SLOW: &str = "The edit has not come within 30 s. Send it again in smaller parts.";
pub(crate) const DOCUMENT_NOT_OBJECT: &str = "Send a JSON object.";
pub(crate) const OTHER_ID: &str =
    "This is the id of another object than the path names. Leave it out, or send the same.";
pub(crate) const UNKNOWN_FIELD: &str = "There is no such field. Look for a mistake in its name.";
pub(crate) const OBJECT_UNUSABLE: &str =
    "The object could not be used, so nothing was changed; each wrong field is named.";
pub(crate) fn wrong_parameter(action: &str, error: &impl std::fmt::Display) -> String {
    format!("The action {action} cannot have these parameters: {error}.")
}
/// A refused edit over the socket: which object, and the first problem.
pub(crate) fn object_with_wrong_parameter(object: &str, pointer: &str, detail: &str) -> String {
    format!("{object} was not changed, because of {pointer}. {detail}")
}
pub(crate) const EDIT_DOES_NOT_FIT: &str =
    "The edit does not fit the site, so nothing was changed; each wrong change is named.";

pub(crate) fn no_kind(name: &str) -> String {
    format!(
        "There is no kind of object \"{name}\". There are settings, nodes, edges, edge-blocks, zones, docks, assets, inspection-points, missions, schedules and monitors."
    )
}
pub(crate) fn no_object(object: impl std::fmt::Display, kind: &str) -> String {
    format!("There is no {object}. GET /api/v1/site/{kind} lists them.")
}
/// Somebody else has changed or removed an object.
pub(crate) fn object_changed(object: impl std::fmt::Display, is_there: bool) -> String {
    if is_there {
        format!(
            "The {object} was changed by somebody else, or is there already. Look at it, and send your change with its entity tag."
        )
    } else {
        format!("The {object} was removed by somebody else. Send it without If-Match to make it again.")
    }
}
pub(crate) fn no_run(run: impl std::fmt::Display) -> String {
    format!("There is no run {run}. GET /api/v1/runs lists them.")
}
pub(crate) fn run_document_malformed(reason: &str) -> String {
    format!("The document cannot be understood: {reason}. /api/v1/openapi.json describes it.")
}

/// A query of a list; `reason` is a clause.
pub(crate) fn query_malformed(reason: &str) -> String {
    format!("The parameters after the ? cannot be understood: {reason}.")
}

// Uploads.

pub(crate) const UPLOAD_ID_MALFORMED: &str = "An upload is named by a UUID that the client makes.";
pub(crate) const UPLOAD_BUSY: &str = "Another file is being sent. Wait until it is here.";
pub(crate) const UPLOAD_EXISTS: &str = "A file of this id is here already. Make a new one.";
pub(crate) const LENGTH_MISSING: &str = "The length of the file is missing: send the Content-Length header.";
pub(crate) const DISK_TOO_FULL: &str = "There is too little room on the robot's disk for this file. Delete maps for good, uploaded files or recordings first.";
pub(crate) const FILE_NOT_WRITTEN: &str = "The server could not write the file to its disk.";
pub(crate) const UPLOAD_INCOMPLETE: &str = "The file is incomplete. Send it again.";
pub(crate) const UPLOAD_STALLED: &str = "No bytes came for too long. Send the file again.";

pub(crate) fn upload_too_large(max_gib: u64) -> String {
    format!("The file is larger than {max_gib} GiB. Thin it first, or import it on the robot's computer.")
}
pub(crate) fn too_many_uploads(waiting: usize) -> String {
    format!("{waiting} files wait to be imported already. {FREE_UPLOADS}")
}
pub(crate) fn uploads_too_large(waiting_bytes: u64, max_bytes: u64) -> String {
    let [waiting, max] = [waiting_bytes, max_bytes].map(|bytes| bytes as f64 / f64::from(1 << 30));
    format!(
        "Files that wait to be imported take {waiting:.1} GiB, and with this one they would take more than the {max:.1} GiB that they may. {FREE_UPLOADS}"
    )
}
const FREE_UPLOADS: &str = "Import or delete one of them first: GET /api/v1/uploads lists them, DELETE /api/v1/uploads/{id} deletes one, and so does the page below the saved maps.";
pub(crate) fn no_upload(upload: impl std::fmt::Display) -> String {
    format!("There is no uploaded file {upload}. GET /api/v1/uploads lists them.")
}

/// A pair of results that is not given.
pub const PAIR_MALFORMED: &str = "Give the numbers of two results: before and after.";
/// A pair of results whose photos cannot be compared.
pub const NO_SUCH_PAIR: &str = "The two results are no photos of one inspection point.";
