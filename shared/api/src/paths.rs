//! Paths of the HTTP interface.

/// WebSocket for state and commands.
pub const CONTROL_PATH: &str = "/api/v1/control";
/// WebSocket for live scans.
pub const STREAM_PATH: &str = "/api/v1/stream";
/// GET: [`crate::MapSummary`] of every saved map, newest first, in pages.
pub const MAPS_PATH: &str = "/api/v1/maps";
/// With the map's id in place of `{id}`. GET: its [`crate::MapSummary`]. PATCH: a JSON object with its new `name`. DELETE: moves it to the bin.
pub const MAP_PATH: &str = "/api/v1/maps/{id}";
/// GET: [`crate::BinnedMap`] of every deleted map, the last deleted first, in pages.
pub const BIN_PATH: &str = "/api/v1/maps/bin";
/// DELETE with the map's id in place of `{id}`: deletes a map in the bin for good.
pub const BINNED_MAP_PATH: &str = "/api/v1/maps/bin/{id}";
/// POST with the map's id in place of `{id}`: moves a map back from the bin.
pub const RESTORE_MAP_PATH: &str = "/api/v1/maps/bin/{id}/restore";
/// GET: [`crate::DamagedMap`] of every saved map that cannot be read, in pages.
pub const DAMAGED_MAPS_PATH: &str = "/api/v1/damaged-maps";
/// GET with the map's id in place of `{id}`: its [`crate::TileList`], whole or a page of it.
pub const MAP_TILES_PATH: &str = "/api/v1/maps/{id}/tiles";
/// GET with the map's id in place of `{id}`: its pose graph, a [`crate::Graph`].
pub const MAP_GRAPH_PATH: &str = "/api/v1/maps/{id}/graph";
/// GET with the hash in place of `{hash}`: the bytes of a tile, immutable.
pub const TILE_PATH: &str = "/api/v1/tiles/{hash}";
/// GET with the hash in place of `{hash}`: a file that an action has gathered, such as a picture, immutable. Parts of it by `Range`.
pub const BLOB_PATH: &str = "/api/v1/blobs/{hash}";
/// GET with a mapping session's id in place of `{session}` and a keyframe's number in place of `{keyframe}`: the whole scan of that
/// keyframe in its own frame, encoded as a tile is, immutable; there while the session lasts.
pub const CLOUD_PATH: &str = "/api/v1/sessions/{session}/clouds/{keyframe}";
/// GET: [`crate::StoredUpload`] of every uploaded file that no map was made of yet, the oldest first.
pub const UPLOADS_PATH: &str = "/api/v1/uploads";
/// With an upload's id in place of `{id}`. PUT: a file, to be made a map of with [`crate::Command::ImportMap`]. DELETE: deletes the file.
pub const UPLOAD_PATH: &str = "/api/v1/uploads/{id}";
/// GET: the documents of the site, how many there are and what is wrong with them.
pub const SITE_PATH: &str = "/api/v1/site";
/// With a kind of object in place of `{kind}`. GET: a page of the objects of this kind. POST: makes one.
pub const SITE_KIND_PATH: &str = "/api/v1/site/{kind}";
/// With a kind of object and an object's id. GET, PUT, PATCH, DELETE: the object.
pub const SITE_OBJECT_PATH: &str = "/api/v1/site/{kind}/{id}";
/// With a kind of object and an object's id. GET: a page of the states that the object has had.
pub const SITE_REVISIONS_PATH: &str = "/api/v1/site/{kind}/{id}/revisions";
/// POST: a [`site_model::Edit`], which changes several objects together.
pub const SITE_EDITS_PATH: &str = "/api/v1/site/edits";
/// POST: makes a site to try. GET: how far that is. DELETE: cancels it.
pub const EXAMPLE_PATH: &str = "/api/v1/example";
/// GET: a page of the runs of missions, the newest first. POST: runs a mission.
pub const RUNS_PATH: &str = "/api/v1/runs";
/// GET: the runs that have not ended, and where the robot is on the topological map.
pub const CURRENT_RUNS_PATH: &str = "/api/v1/runs/current";
/// POST, with a run's id in place of `{run}`: pause, resume, cancel, abort, skip or redo a task, answer a question.
pub const RUN_COMMANDS_PATH: &str = "/api/v1/runs/{run}/commands";
/// GET, with a run's id in place of `{run}`: a page of the attempts of its tasks.
pub const RUN_STEPS_PATH: &str = "/api/v1/runs/{run}/steps";
/// GET, with a run's id in place of `{run}`: a page of its results.
pub const RUN_RESULTS_PATH: &str = "/api/v1/runs/{run}/results";
/// GET, with a run's id in place of `{run}`: a page of the clouds that the robot saw on it.
pub const RUN_CLOUDS_PATH: &str = "/api/v1/runs/{run}/clouds";
/// GET, with a run's id and the hash of a cloud: its file.
pub const RUN_CLOUD_PATH: &str = "/api/v1/runs/{run}/clouds/{hash}";
/// GET, with a run's id in place of `{run}`: all of it with its files, a ZIP archive.
pub const RUN_DOWNLOAD_PATH: &str = "/api/v1/runs/{run}/download";
/// GET, with a run's id in place of `{run}`: its results as an MCAP file.
pub const RUN_MCAP_PATH: &str = "/api/v1/runs/{run}/mcap";
/// GET, with a run's id in place of `{run}`: a report of it for people, HTML.
pub const RUN_REPORT_PATH: &str = "/api/v1/runs/{run}/report";
/// GET: a report of all runs that were asked for in a time, HTML.
pub const REPORT_PATH: &str = "/api/v1/report";
/// GET, with an inspection point's id in place of `{id}`: a page of its results in all runs, the newest first.
pub const POINT_RESULTS_PATH: &str = "/api/v1/inspection-points/{id}/results";
/// GET, with the numbers of two results as `before` and `after`: how their pictures are aligned, and what has changed between them.
pub const PICTURE_COMPARISON_PATH: &str = "/api/v1/picture-comparison";
/// GET: a page of the slots of schedules that were decided, those due last first.
pub const SLOTS_PATH: &str = "/api/v1/slots";
/// GET: a page of the changes of the scene, the last found first. One of them is read and edited as an object of the site.
pub const SCENE_CHANGES_PATH: &str = "/api/v1/scene-changes";
/// GET: a page of the alerts of inspection, those raised last first; as CSV with `format=csv`. One of them is read and edited as an object of the site.
pub const ALERTS_PATH: &str = "/api/v1/alerts";
/// POST: makes a version of a map in which changes of the scene are normal. GET: how far that is.
pub const NORMAL_CHANGES_PATH: &str = "/api/v1/scene-changes/normal";
/// GET: 200 while core and gateway are connected, 503 otherwise.
pub const HEALTH_PATH: &str = "/api/v1/health";
/// GET: the description of this interface, OpenAPI 3.1.
pub const DESCRIPTION_PATH: &str = "/api/v1/openapi.json";
/// GET: who asks, and whether people have to sign in. POST: signs in. DELETE: signs out.
pub const SESSION_PATH: &str = "/api/v1/session";
/// PUT: changes the password of whoever asks.
pub const OWN_PASSWORD_PATH: &str = "/api/v1/session/password";
/// POST: makes the first admin, with the secret of the link that the robot's console shows.
pub const FIRST_ADMIN_PATH: &str = "/api/v1/first-admin";
/// GET: all accounts. POST: makes one.
pub const ACCOUNTS_PATH: &str = "/api/v1/accounts";
/// With an account's name in place of `{account}`. PATCH: changes it. DELETE: removes it.
pub const ACCOUNT_PATH: &str = "/api/v1/accounts/{account}";
/// GET: a page of the audit log, the newest first; as CSV with `format=csv`.
pub const AUDIT_PATH: &str = "/api/v1/audit";
/// GET: all tokens of programs. POST: makes one.
pub const TOKENS_PATH: &str = "/api/v1/tokens";
/// DELETE, with a token's id in place of `{id}`: ends it.
pub const TOKEN_PATH: &str = "/api/v1/tokens/{id}";
/// The certificate authority of the robot's own.
pub const AUTHORITY_PATH: &str = "/api/v1/authority";
/// Its certificate.
pub const AUTHORITY_CERTIFICATE_PATH: &str = "/api/v1/authority/certificate";
/// A QR code of the address of the page that explains how to trust it.
pub const TRUST_CODE_PATH: &str = "/api/v1/authority/qr";
/// Stop motion.
pub const STOP_PATH: &str = "/api/v1/stop";
