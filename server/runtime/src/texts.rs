//! Sentences for people, by key: notices, refusals and reasons of failed imports. English.

use crate::map_usage::MapUse;
use ports::SimulatedFault;
use site_model::{OutsideLimits, Reading};
use std::path::Path;
use std::time::Duration;
use vocab::{KeyframeId, MAX_SHOWN_NAME_CHARS, Span, Vec3, legible};

/// A map cannot be saved, because too much waits for the disk.
pub const DISK_TOO_SLOW_TO_SAVE: &str = "the disk is too slow; wait a minute and save again";
/// A map cannot be read, because too much waits for the disk.
pub const DISK_TOO_SLOW_TO_LOAD: &str = "the disk is too slow; wait a minute and try again";

/// The clouds of a map could not be copied into the session that extends it.
pub fn extended_map_not_whole(reason: &str) -> String {
    format!("The extended map will not be whole: {reason}. Discard it and free some disk.")
}

/// The cloud of a keyframe could not be written.
pub fn keyframe_cloud_missing(keyframe: KeyframeId, reason: &str) -> String {
    format!("The cloud of keyframe {} will be missing from the saved map: {reason}.", keyframe.0)
}

/// The core was started without an importer.
pub const NO_IMPORTER: &str = "This platform makes no maps of files.";
/// The import thread works, and one more request waits already.
pub const IMPORT_BUSY: &str = "Another map is being imported. Wait until that is done.";
/// The import thread has ended.
pub const PLATFORM_ENDING: &str = "The platform is ending.";
/// A client cancelled the import, or the core ends.
pub const IMPORT_CANCELLED: &str = "It was cancelled.";
/// The uploaded file was deleted before the import began.
pub const UPLOAD_MISSING: &str = "That file is not here any more. Send it again.";
/// The map that gives the frame was deleted.
pub const FRAME_MAP_MISSING: &str = "The map whose frame it was to have is not here any more.";
/// The map of changes was deleted.
pub const MAP_OF_CHANGES_MISSING: &str = "The map of these changes is not here any more.";
/// The clouds of a run made room for others.
pub const CLOUDS_OF_RUN_MISSING: &str = "The clouds of the run that found these changes are not here any more. Run the mission again; what it finds can be made normal.";
/// Changes that the site does not have.
pub const NO_SUCH_CHANGES: &str = "The site has none of these changes any more.";
/// Changes that no single new version can show.
pub const CHANGES_OF_SEVERAL_MAPS: &str =
    "These changes were found in different maps. Choose those of one map.";
/// The map to be aligned was deleted.
pub const ALIGNED_MAP_MISSING: &str = "The map to be aligned is not here any more.";
/// The map to be aligned is the one that gives the frame.
pub const ALIGN_ONTO_ITSELF: &str = "A map cannot be aligned with itself. Choose another map.";
/// Aligning makes a second map of the same size.
pub const NO_SPACE_FOR_COPY: &str = "There is too little room on the robot's disk for another map of this size. Delete maps for good or recordings first.";
/// A map with the same id was saved or imported before.
pub const MAP_EXISTS: &str = "The same map is here already.";
/// Name of a map whose name holds nothing to show.
pub const UNNAMED_MAP: &str = "Map";

/// A file whose import was refused because the disk is nearly full.
pub const NO_SPACE_FOR_IMPORT: &str = "There is too little room on the robot's disk for the map. Delete maps for good or recordings first, then try again.";
/// A map with the same id was deleted and is kept.
pub const MAP_IN_BIN: &str = "The same map is in the bin. Restore it there.";

/// A map that is to be renamed or deleted and does not exist.
pub const MAP_MISSING: &str = "That map is not here any more.";
/// A map that is to be restored and is not in the bin.
pub const MAP_NOT_IN_BIN: &str = "That map is not in the bin any more.";
/// A map that is to be deleted while one of the same id is in the bin.
pub const SAME_MAP_IN_BIN: &str = "The same map is in the bin already. Delete that one for good first.";
/// A map that is to be restored while one of the same id is saved.
pub const SAME_MAP_SAVED: &str = "The same map is saved already. Delete one of them for good first.";
/// The core was started without a maker of examples.
pub const NO_EXAMPLE: &str = "This platform makes no example.";
/// The objects of the example were refused for `reason`, a clause or sentence.
pub fn example_not_stored(reason: &str) -> String {
    format!(
        "The map is saved, but its topological map and missions are not: {}.",
        reason.trim_end_matches('.')
    )
}
/// Name of the example's map and site.
pub const EXAMPLE_NAME: &str = "Example hall";
/// The example is asked for during a mapping session.
pub const EXAMPLE_WHILE_MAPPING: &str =
    "The robot is mapping. Finish or discard that map first, then make the example.";
/// The example is asked for a second time.
pub const EXAMPLE_EXISTS: &str = "There is a map named Example hall already. Rename or delete it first.";
/// The example is asked for on a site in use.
pub const SITE_IS_NOT_EMPTY: &str = "This site has a topological map or missions of its own. The example needs an empty site: start the platform with a new data directory.";
/// An uploaded file that is to be deleted while it is imported.
pub const UPLOAD_IN_USE: &str = "The file is being imported. Cancel the import first.";
/// A damaged map in the bin.
pub const STAYS_IN_BIN: &str = "It stays in the bin until somebody restores it or deletes it for good.";

/// A map cannot be deleted because it is in use.
pub fn map_in_use(map_use: MapUse) -> &'static str {
    match map_use {
        MapUse::Localisation => "The robot uses this map. Leave the map first, then delete it.",
        MapUse::Extension => {
            "The mapping session extends this map. Save or discard the session first, then delete the map."
        }
        MapUse::Import => "An import uses this map. Wait until it is done or cancel it, then delete the map.",
        MapUse::InterruptedSession => {
            "An interrupted mapping session extends this map. Save or discard the session first, then delete the map."
        }
    }
}

/// A map was in the bin long enough.
pub fn map_left_bin(name: &str) -> String {
    format!("{name} was deleted for good, because it was in the bin for 7 days.")
}

/// A change of stored data failed for `reason`, a clause.
pub fn stored_data_unchanged(reason: &str) -> String {
    format!("Nothing was changed: {reason}.")
}

/// What to do about a saved map that a later program wrote.
pub const MAP_OF_LATER_PROGRAM_REMEDY: &str =
    "Update AutoInspect on the robot's computer. Nothing of the map was removed.";

/// What is wrong with a saved map for `reason`, a clause.
pub fn damaged_map_problem(reason: &str) -> String {
    format!("It cannot be read: {reason}.")
}

/// What to do about a damaged map in this folder.
pub fn damaged_map_remedy(folder: &Path) -> String {
    format!(
        "Copy the file back from a backup and restart, or delete the map: the bin keeps its folder, {}. Nothing of the map was removed.",
        folder.display()
    )
}

/// The core failed and runs again; `cause` is a clause.
pub fn core_restarted(cause: &str) -> String {
    format!("The robot's core {cause}, and was started again. The robot stood meanwhile.")
}

/// The simulated robot failed and runs again; `cause` is a clause.
pub fn robot_restarted(cause: &str) -> String {
    format!("The simulated robot {cause}, and was started again. It stands where it starts.")
}

/// A message to the gateway is longer than it accepts, bytes.
pub fn message_too_long(bytes: usize, max_bytes: usize) -> String {
    format!("a message of {bytes} bytes was not sent to the gateway, which accepts {max_bytes}")
}

/// The disk lane was full when a keyframe came.
pub fn cloud_not_written(keyframe: KeyframeId) -> String {
    format!("The disk is too slow: the cloud of keyframe {} will be missing from the saved map.", keyframe.0)
}

/// A stored file is damaged for `reason`, a clause that names it.
pub fn stored_file_damaged(reason: &str) -> String {
    format!(
        "{reason}. Nothing was removed. Copy the file back from a backup; without one, make the map again."
    )
}

/// More files are damaged than people were told of one by one.
pub fn more_files_damaged(count: usize) -> String {
    format!("{count} more stored files are damaged. The platform's log names them. Check the disk.")
}

/// Recordings may not take more of the disk, see [`store::RecordingSpace`].
pub const RECORDINGS_FILL_THEIR_SHARE: &str = "it holds all of the disk that recordings may take";

/// Whether an import made a map of a file, aligned a saved map, or made the example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImportVerb {
    Imported,
    Aligned,
    Made,
}

impl ImportVerb {
    fn participle(self) -> &'static str {
        match self {
            Self::Imported => "imported",
            Self::Aligned => "aligned",
            Self::Made => "made",
        }
    }
}

/// A map was made.
pub fn import_done(name: &str, verb: ImportVerb) -> String {
    match verb {
        ImportVerb::Imported | ImportVerb::Aligned => format!("{name} is {}.", verb.participle()),
        ImportVerb::Made => format!("{name} is ready."),
    }
}

/// A map was not made for `reason`, a sentence.
pub fn import_failed(name: &str, verb: ImportVerb, reason: &str) -> String {
    format!("{name} was not {}: {reason}", verb.participle())
}

/// Recording pauses for `reason`, a clause.
pub fn recording_paused(reason: &str) -> String {
    format!(
        "Recording has paused: {reason}. The robot goes on without it, and recording begins again once there is room; free some disk."
    )
}

/// Recording goes on after a pause.
pub fn recording_resumed(missing: u64) -> String {
    format!(
        "Recording goes on: {missing} inputs are missing in it, because the disk was full, failed or was too slow. The run can be replayed exactly up to there only."
    )
}

/// The run ended while recording had paused.
pub fn recording_ended_early(missing: u64) -> String {
    format!(
        "The last {missing} inputs of the run are missing in its recording, because the disk was full, failed or was too slow."
    )
}

/// A person stopped motion.
pub const MOTION_STOPPED: &str = "Somebody stopped motion.";
/// A goal failed.
pub const GOAL_FAILED: &str = "A goal failed.";
/// The pose in the map in use is not known any more.
pub const LOCALISATION_LOST: &str = "The robot lost its pose in the map.";
/// The run before this one was interrupted.
pub const RESTARTED: &str = "The program started again after it had been interrupted.";

/// A stop of motion, or its end, cannot be written for `reason`, a clause.
pub fn stop_not_durable(reason: &str) -> String {
    format!(
        "Whether motion is stopped cannot be written to disk: {reason}. It holds now, but a restart would forget it; free some disk. Writing is tried again."
    )
}

/// What the stack says of a run cannot be written for `reason`, a clause.
pub fn run_not_durable(reason: &str) -> String {
    format!(
        "What the robot does on its mission cannot be written to disk: {reason}. It waits with its next step; free some disk. Writing is tried again."
    )
}

/// The ledger cannot be opened or read for `reason`, a clause.
pub fn ledger_not_open(reason: &str) -> String {
    format!(
        "What people have made of the site (its graph, missions and schedules) cannot be read or changed now: {reason}. It is tried again."
    )
}

/// An edit of the site cannot be written for `reason`, a clause.
pub fn edit_not_durable(reason: &str) -> String {
    format!("Nothing was changed: {reason}. It is tried again.")
}

/// More commands come than the control loop takes.
pub const CONTROL_LOOP_BUSY: &str = "The robot is busy with other commands. Try again in a moment.";
/// Too many edits wait.
pub const LEDGER_BUSY: &str = "The robot's disk is busy with earlier changes. Try again in a moment.";
/// The core ends.
pub const CORE_ENDS: &str = "The robot's core is ending. Try again once it is back.";
/// An edit without changes.
pub const EDIT_IS_EMPTY: &str = "The edit changes nothing.";

/// An edit has too many changes.
pub fn edit_too_long(changes: usize, max: usize) -> String {
    format!("The edit changes {changes} objects, and {max} are allowed at once. Make several edits of it.")
}

/// The site has as many objects as it may.
pub fn site_full(max: usize) -> String {
    format!("The site would have more than {max} objects. Remove what is not needed first.")
}

/// `object` takes more bytes than it may.
pub fn object_too_large(object: &str, max_bytes: usize) -> String {
    format!("The {object} takes more than {} kB. Make several of it.", max_bytes >> 10)
}

/// Tiles or graph of the saved map in use cannot be read for `reason`, a clause.
pub fn map_not_shown(reason: &str) -> String {
    format!("The map in use cannot be shown: {reason}.")
}

/// A tile of the map under construction cannot be written for `reason`, a clause.
pub fn keyframe_not_shown(reason: &str) -> String {
    format!("A part of the live map cannot be shown: {reason}.")
}

/// A fault was injected into the simulation.
pub fn fault_injected(fault: SimulatedFault) -> String {
    let seconds = |span: Span| format!("{:.0} s", span.secs_f64());
    let what = match fault {
        SimulatedFault::CoverLidar(span) => format!("the LiDAR is covered for {}", seconds(span)),
        SimulatedFault::SilenceLidar(span) => format!("the LiDAR is cut off for {}", seconds(span)),
        SimulatedFault::SilenceImu(span) => format!("the IMU is cut off for {}", seconds(span)),
        SimulatedFault::SlipFeet(span) => format!("the feet slip for {}", seconds(span)),
        SimulatedFault::CarryAway => "somebody carries the robot away with its LiDAR covered".to_owned(),
        SimulatedFault::End => "all is well again".to_owned(),
    };
    format!("Simulated: {what}.")
}

/// The stack called an action although no action server is connected.
pub fn no_action_server(action: &str) -> String {
    format!("No action server offers \"{}\".", legible(action, MAX_SHOWN_NAME_CHARS))
}

/// More actions at once than the platform performs.
pub const TOO_MANY_ACTIONS: &str = "Too many actions are under way. Try again in a moment.";
/// The end of an action was asked for that is not under way.
pub const NO_SUCH_CALL: &str = "This action is not under way, so nobody knows whether it was done.";
/// A message without content.
pub const EMPTY_MESSAGE: &str = "The message is empty. Enter a text.";
/// The robot's report of an action cannot be read.
pub const ROBOT_REPORT_MALFORMED: &str =
    "The robot's report of the action cannot be read. Update the robot's program.";
/// A reading does not keep the limits of its inspection point.
pub fn outside_limits(point: &str, reading: &Reading, outside: OutsideLimits) -> String {
    let (side, limit) = match outside {
        OutsideLimits::Below(limit) => ("below", limit),
        OutsideLimits::Above(limit) => ("above", limit),
    };
    let Reading { value, unit, .. } = reading;
    let name = reading.name.replace('_', " ");
    format!("{point}: the {name} is {value:.2} {unit}, {side} the limit of {limit:.2} {unit}.")
}

/// A sentence about an inspection point.
pub fn of_point(point: &str, sentence: &str) -> String {
    format!("{point}: {sentence}")
}

/// More pairs of pictures wait than may.
pub const TOO_MANY_PICTURES_WAIT: &str = "Too many pictures wait to be compared. Try again in a minute.";
/// This platform compares no pictures.
pub const NO_PICTURE_COMPARISON: &str = "Pictures are not compared here.";

/// A gauge was to be read, and the robot gave no picture.
pub const GAUGE_WITHOUT_PICTURE: &str = "The gauge was not read, because the robot gave no picture.";
/// More pictures of gauges wait than there can be actions.
pub const TOO_MANY_GAUGES: &str = "The gauge was not read, because too many pictures wait. Take it again.";
/// A point cloud was to be gathered and no scan came.
pub const NOTHING_SCANNED: &str = "The LiDAR saw nothing, so there is no point cloud.";
/// The camera is to be aimed at a point of the map, and the robot's pose in it is not known.
pub const AIM_WITHOUT_PLACE: &str =
    "The camera cannot be aimed, because the robot's pose in the map is not known.";
/// The camera is to be aimed at a point that gives no direction.
pub const AIM_WITHOUT_DIRECTION: &str =
    "The camera cannot be aimed there, because the target is at the camera itself.";

/// Clouds of a run found no room.
pub const NO_ROOM_FOR_RUN_CLOUDS: &str = "The clouds of this run are not kept any more, because the disk or their share of it is full. Visits cannot be compared by them. Delete maps for good or recordings.";

/// Clouds of a run could not be written.
pub fn run_clouds_not_kept(reason: &str) -> String {
    format!("A cloud of this run was not kept, so visits cannot be compared by it: {reason}.")
}

/// The site has followed its map.
pub fn site_follows_map(nodes: usize, distance_m: f64) -> String {
    if nodes == 0 {
        return "The site uses the new version of its map now. No node had to move.".to_owned();
    }
    let nodes = if nodes == 1 { "1 node has".to_owned() } else { format!("{nodes} nodes have") };
    format!(
        "The site uses the new version of its map now. {nodes} moved with it, by {distance_m:.2} m at most. Undo takes that back."
    )
}

/// The site has not followed its map for `reason`, a clause or sentence.
pub fn site_does_not_follow(reason: &str) -> String {
    format!("The robot uses another version of the site's map, and the nodes did not follow: {reason}")
}

/// The map shows something between the camera and its target.
pub fn view_blocked(target: Vec3, obstacle_at_m: f64, distance_m: f64) -> String {
    let Vec3 { x, y, z } = target;
    format!(
        "The map shows something {obstacle_at_m:.1} m before the camera, but its target at x {x:.1} m, y {y:.1} m, z {z:.1} m is {distance_m:.1} m away. The picture is taken all the same. Look at it, and move the node or the target."
    )
}

/// The camera is to be aimed further to the side than its head pans.
pub fn aim_beyond_pan(turn_rad: f64) -> String {
    let side = if turn_rad > 0.0 { "left" } else { "right" };
    let degrees = turn_rad.abs().to_degrees().ceil();
    format!(
        "The camera does not reach the target: the robot has to turn at least {degrees}° to the {side} first."
    )
}

/// The camera is to be aimed further up or down than its head tilts.
pub fn aim_beyond_tilt(excess_rad: f64) -> String {
    let (side, degrees) =
        (if excess_rad > 0.0 { "high" } else { "low" }, excess_rad.abs().to_degrees().ceil());
    format!("The target is {degrees}° too {side} for the camera. Look at it from further away.")
}

/// Parameters of an action are wrong for `reason`, a clause.
pub fn wrong_parameters(reason: &dyn std::fmt::Display) -> String {
    format!(
        "The parameters of the action are not those of its schema: {}.",
        legible(&reason.to_string(), 200)
    )
}

/// What an action has gathered was not stored for `reason`, a clause.
pub fn result_not_stored(reason: &str) -> String {
    format!("What the action gathered could not be stored: {reason}.")
}

/// The gateway speaks another version of the contract.
pub fn other_version(gateway: u16, core: u16) -> String {
    format!("it speaks version {gateway} and the core {core}")
}

/// The gateway sent a message before its greeting.
pub const NO_GREETING: &str = "its first message is not a greeting";

/// Too many simulated faults wait for the robot's answer.
pub const TOO_MANY_FAULTS: &str = "Too much goes wrong at once. Try again in a moment.";
/// The connection to the robot was lost before it answered.
pub const ROBOT_NOT_ANSWERING: &str = "The robot was disconnected before it answered.";
/// The connection to the robot works again.
pub const ROBOT_RECONNECTED: &str = "The robot is connected again.";

/// The running session's journal cannot be written for `reason`, a clause.
pub fn session_not_durable(reason: &str) -> String {
    format!(
        "The mapping session cannot be written to disk: {reason}. Mapping goes on, but a crash would lose what follows; free some disk."
    )
}

/// The disk lane is full.
pub const DISK_TOO_SLOW: &str = "The disk is too slow. Wait a minute and try again.";
/// One topological map is made at a time.
pub const TOPOMAP_IS_MADE: &str = "A topological map is being made already. Wait until it is done.";
/// Neither a walked path nor a walkable floor.
pub const TOPOMAP_EMPTY: &str = "No way was found in this map. Walk the robot through the site while mapping, or check that the map shows its floor.";

/// The map cannot be read.
pub fn topomap_not_read(reason: &str) -> String {
    format!("No topological map was made, because the map cannot be read: {reason}.")
}

/// The site does not take it.
pub fn topomap_not_stored(reason: &str) -> String {
    format!("The topological map was made, but could not be stored: {reason}")
}

/// A session that is running, or was decided on before.
pub const SESSION_NOT_INTERRUPTED: &str =
    "No interrupted session waits under this id. It was saved or discarded already.";
/// A map without a name.
pub const MAP_NEEDS_NAME: &str = "The map needs a name.";

/// An interrupted session was saved as the map of this name.
pub fn session_saved(name: &str) -> String {
    format!("The interrupted mapping session is saved as {name}.")
}

/// An interrupted session was not saved for `reason`, a clause.
pub fn session_not_saved(reason: &str) -> String {
    format!("The interrupted session was not saved: {reason}. It is kept.")
}

/// An interrupted session was not discarded for `reason`, a clause.
pub fn session_not_discarded(reason: &str) -> String {
    format!("The interrupted session was not discarded: {reason}.")
}

/// What earlier programs have committed of runs could not be read for `reason`, a clause. A sentence.
pub fn runs_not_restored(reason: &str) -> String {
    format!(
        "Runs of before the restart cannot be taken up: {reason}. They are kept in the ledger. Start their missions again."
    )
}

/// Only the holder of the control lease keeps it.
pub const ONLY_THE_HOLDER_REFUSES: &str = "Somebody else has control, so only they can keep it.";
/// There is nothing to refuse.
pub const NOBODY_TAKES_OVER: &str = "Nobody asks for control any more.";

/// Somebody else asks for the control lease already.
pub fn another_takes_over(name: &str) -> String {
    format!("{name} has asked for control already. Try again in a few seconds.")
}

/// The holder of the control lease, of this name, keeps it.
pub fn take_over_refused(name: &str) -> String {
    format!("{name} keeps control. Ask them, or an admin, who can take it.")
}

/// The holder has kept the lease a moment ago.
pub fn take_over_refused_lately(name: &str, wait: Duration) -> String {
    format!("{name} has just kept control. Ask again in {:.0} s.", wait.as_secs_f32().ceil())
}

/// The holder of the control lease has had no connection for too long.
pub fn lease_expired(name: &str) -> String {
    format!("{name} has no connection any more, so control is free.")
}
