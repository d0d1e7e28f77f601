//! Error messages and notes of the commands, by key. English; an error names what is wrong, the file and the remedy.

use crate::limited_command::LimitedCommand;
use mapping::AlignmentError;
use std::fmt::Display;
use std::path::Path;
use std::time::Duration;

/// A file or folder that cannot be written.
pub fn cannot_write(path: &Path, error: &dyn Display) -> String {
    format!("{} cannot be written: {error}", path.display())
}

/// A folder that cannot be created.
pub fn cannot_create(path: &Path, error: &dyn Display) -> String {
    format!("{} cannot be made: {error}", path.display())
}

/// An input of an unknown format.
pub fn unreadable_input(path: &Path, error: &dyn Display) -> String {
    format!("{}: {error}", path.display())
}

/// A cloud without points.
pub fn no_points(path: &Path) -> String {
    format!("{} holds no points", path.display())
}

/// The folder for the results has other files.
pub fn folder_in_use(out: &Path) -> String {
    format!("{} holds other things; choose an empty folder or one of an earlier map", out.display())
}

/// The folder for the results is an input.
pub fn result_is_input(out: &Path) -> String {
    format!("{} is one of the maps; choose another folder for the result", out.display())
}

/// A folder without map.json.
pub fn no_map(folder: &Path, error: &dyn Display) -> String {
    format!(
        "{} holds no map ({error} for its map.json); give a folder that `autoinspect map --out` wrote",
        folder.display()
    )
}

/// A file for a topological map with an unknown ending.
pub fn unknown_topomap_format(out: &Path) -> String {
    format!("the ending of {} says no format; use .json, .yaml or .geojson, or --format", out.display())
}

/// A topological map was made; `what` describes it.
pub fn topomap_made(map: &Path, what: &str) -> String {
    format!("{}: {what}", map.display())
}

/// An argument that is no pose on a dock.
pub const DOCK_EXPECTED: &str = "expected X,Y,Z,HEADING: metres and degrees, such as 0,0,0,90";
/// An argument that is no length of a robot.
pub const ROBOT_LENGTH_EXPECTED: &str = "expected a length of more than 0 and at most 10 metres";

/// A map with missing cloud files.
pub fn missing_clouds(map: &Path) -> String {
    format!("{} has no clouds for some of its keyframes; make the map again", map.display())
}

/// No scan of the recordings was localised.
pub fn robot_not_found(map: &Path) -> String {
    format!("the robot was not found in {}", map.display())
}

/// A recording that gave no map.
pub fn no_map_made(reason: &str) -> String {
    format!("no map was made: {reason}")
}

/// The default reason of [`no_map_made`].
pub const NO_USABLE_MESSAGE: &str = "no message could be used";

/// A cloud in which too few scans of the map were recognised.
pub fn too_few_scans_recognised(map: &Path, recognised: usize) -> String {
    format!(
        "only {recognised} places of {} were recognised in the cloud; align it by points picked in both (--pair)",
        map.display()
    )
}

/// A cloud whose alignment is ambiguous.
pub fn ambiguous_alignment(map: &Path, recognised: usize, other: usize) -> String {
    format!(
        "the cloud fits into {} in two ways, with {recognised} and {other} places recognised; align it by points picked in both (--pair)",
        map.display()
    )
}

/// Point pairs that do not determine an alignment.
pub const TOO_FEW_PAIRS: &str = "two --pair or more are needed, of points that are not above each other";

/// Point pairs with an impossible result.
pub fn pairs_too_far(distance_km: f64) -> String {
    format!("the pairs place the cloud farther away than {distance_km:.0} km; check their coordinates")
}

/// Point pairs that no alignment fits.
pub fn pairs_contradict(rms_m: f64) -> String {
    format!(
        "the pairs contradict each other: after the best alignment they are {rms_m:.2} m apart in the mean; check their order, and --up"
    )
}

/// A point pair that cannot be parsed.
pub const INVALID_PAIR: &str =
    "a point and the same one in the other map are expected, like 12,3.5,0=1.2,4,0";

/// Two maps that cannot be merged.
pub fn alignment_error(error: &AlignmentError, map: &Path, first: &Path) -> String {
    let (map, first) = (map.display(), first.display());
    match error {
        AlignmentError::TooFew(0) => {
            format!("nothing of {map} was recognised in {first}; are they of the same site?")
        }
        AlignmentError::TooFew(count) => format!(
            "only {count} places of {map} were recognised in {first}, or all in one spot; walk some 15 m of the known part on the next round"
        ),
        AlignmentError::Ambiguous(count, runner_up) => format!(
            "{map} fits into {first} in two ways, with {count} and {runner_up} places recognised; walk a part on which they differ"
        ),
    }
}

/// A new version of a map that was removed because it is worse.
pub fn version_is_worse(reason: &str) -> String {
    format!("the new version is worse and was not kept: {reason}")
}

/// An export file without a known ending.
pub fn unknown_format(out: &Path) -> String {
    format!(
        "{} does not say its format; end it in .ply, .pcd, .las, .laz, .e57 or .png, or give --format",
        out.display()
    )
}

/// A picture without a pixel.
pub const EMPTY_PICTURE: &str =
    "no point of the map is within these heights; widen --heights or --above-robot";

/// A pose graph that the solver rejects.
pub fn cannot_optimise(graph: &Path, reason: &dyn Display) -> String {
    format!("{} cannot be optimised: {reason}", graph.display())
}

/// A site without this route.
pub fn no_such_route(site: &dyn Display, route: &str, routes: &[&str]) -> String {
    if routes.is_empty() {
        return format!("{site} has no routes; write one into its .site.json");
    }
    format!("{site} has no route '{route}'; it has {}", routes.join(", "))
}

/// A fault that cannot be parsed.
pub fn invalid_fault(text: &str) -> String {
    format!(
        "'{text}' is no fault; write blind-lidar@60-80, silent-lidar@…, silent-imu@… or leg-slip@30-40:0.2,0,0"
    )
}

/// A trajectory without poses.
pub fn no_poses(path: &Path) -> String {
    format!("{} holds no poses with their times", path.display())
}

/// A line of a KITTI file that is not a pose.
pub fn invalid_kitti_line(path: &Path, line: usize) -> String {
    format!("{} line {line}: twelve numbers of a pose expected", path.display())
}

/// A recording without ground truth.
pub fn no_truth(path: &Path) -> String {
    format!("{} does not say where the robot really was", path.display())
}

/// Trajectories that share too few instants.
pub fn too_few_common_instants(count: usize) -> String {
    format!(
        "the two trajectories share {count} instants, too few to compare; check --offset and that both are of the same run"
    )
}

/// Positions that do not determine an alignment.
pub const COLLINEAR_POSITIONS: &str =
    "all positions lie on one line, so they cannot be aligned; use --align first";

/// A frame that cannot be parsed.
pub fn invalid_frame(text: &str) -> String {
    format!("'{text}' is not a frame; write X,Y,Z,QX,QY,QZ,QW (metres, quaternion)")
}

/// A recording whose scans have no poses.
pub fn no_poses_in(path: &Path) -> String {
    format!(
        "{} holds no poses (nav_msgs/Odometry) at the times of its scans; make a map of it with `autoinspect map` and give the map's folder",
        path.display()
    )
}

/// Two visits without a difference.
pub const NOTHING_CHANGED: &str = "nothing has changed where both visits have looked";

/// An object that changed. Lengths in metres.
pub fn changed_object(kind: &str, centre_m: [f64; 3], size_m: [f64; 3], from_m: Option<[f64; 3]>) -> String {
    let place = |[x, y, z]: [f64; 3]| format!("{x:.2}, {y:.2}, {z:.2} m");
    let [length, width, height] = size_m;
    let from = from_m.map(|from| format!(", from {}", place(from))).unwrap_or_default();
    format!("{kind} at {}, {length:.2} x {width:.2} x {height:.2} m{from}", place(centre_m))
}

/// A self filter whose corners are not in order.
pub const SELF_FILTER_IS_NO_BOX: &str =
    "self_filter is no box; give min_m and max_m with three numbers each, the first smaller than the second";

/// A camera head with numbers that no camera has.
pub const CAMERA_HEAD_IS_NONE: &str = "camera_head has numbers that no camera has; give a pan of 0 to 180 degrees, tilts from -90 to 90 degrees with the lower one first, a zoom of at least 1 and a field of view below 180 degrees";

/// An entry of a robot's profile that has to be positive.
pub fn robot_entry_not_positive(entry: &str, value: f64) -> String {
    format!("{entry} of the robot is {value}; give a number greater than 0")
}

/// A quaternion that is not a rotation.
pub const INVALID_QUATERNION: &str = "a frame's quaternion is zero or not finite";

/// The given folder does not contain the browser client.
pub fn no_client_in(folder: &Path) -> String {
    format!("{} holds no index.html", folder.display())
}

/// The browser client was not found.
pub const NO_CLIENT: &str = "the browser client was not found; say where it is with --static FOLDER";

/// A process of the platform that the system could not start.
pub fn cannot_start(role: &str, error: &dyn Display) -> String {
    format!("the {role} could not be started: {error}")
}

/// A process of the platform that rejected its arguments.
pub fn cannot_run_as_asked(role: &str) -> String {
    format!("the {role} cannot run as asked")
}

/// The core was given a simulated robot by its site.
pub const SIMULATED_ROBOT_IS_A_PROCESS: &str = "the core reaches a simulated robot by its socket; give --robot socket:PATH of `autoinspect simulated-robot --socket PATH`";
/// The simulated robot was given another robot.
pub const ONLY_SITES_ARE_SIMULATED: &str = "only --robot sim:SITE can be simulated";
/// The simulation stopped without a request.
pub const SIMULATION_ENDED: &str = "the simulation ended unexpectedly";
/// Another robot answers at the robot's socket: its clock and its place may have changed. A clause after "the core".
pub const ROBOT_RESTARTED: &str = "began anew because the robot was started again";

/// No robot answers at its socket, for a reason that is a clause about the robot.
pub fn robot_not_connected(socket: &Path, reason: &dyn Display) -> String {
    format!("the robot at {} could not be connected: {reason}", socket.display())
}

// Arguments.

/// A word that is not a number.
pub fn not_a_number(text: &str) -> String {
    format!("'{text}' is not a number")
}
pub const NUMBER_EXPECTED: &str = "a number is expected";
pub const SHARE_EXPECTED: &str = "a number from 0 to 1 is expected";
pub const POSITIVE_EXPECTED: &str = "it must be greater than 0";
pub const METRES_EXPECTED: &str = "a number of metres is expected";
pub const POSITIVE_METRES_EXPECTED: &str = "give 0 or more metres";
pub const PIXEL_SIZE_EXPECTED: &str = "give 0.001 to 100 metres";
pub const HEIGHTS_EXPECTED: &str = "give two heights in metres, the lower first, such as 0.2,2.5";
pub const SPACING_EXPECTED: &str = "0.5 to 20 m are possible";
pub const FIELD_OF_VIEW_EXPECTED: &str = "two angles are expected, the lower first, like -16,15";
pub const POSE_EXPECTED: &str = "X,Y,Z,YAW is expected: metres and degrees";
pub const FINITE_EXPECTED: &str = "finite numbers are expected";
pub const ROBOT_EXPECTED: &str = "a robot is sim:SITE or replay:FILE";

// Pose graphs: reasons for `cannot_optimise` and the like.

/// A graph without vertices and edges.
pub const GRAPH_EMPTY: &str = "it holds no poses";
/// An edge of a map whose measured pose is invalid.
pub const MAP_EDGE_NO_POSE: &str = "an edge of its graph is no pose";
/// The measured pose of an edge is invalid: a reason for [`edge_refused`].
pub const EDGE_NO_POSE: &str = "its pose is none";

/// A vertex whose pose is no rotation and translation.
pub fn vertex_no_pose(vertex: u64) -> String {
    format!("the pose of vertex {vertex} is none")
}

/// A vertex with numbers that are not finite.
pub fn vertex_not_finite(vertex: u64) -> String {
    format!("the pose of vertex {vertex} is not finite")
}

/// Two vertices of one number.
pub fn vertex_twice(vertex: u64) -> String {
    format!("vertex {vertex} is there twice")
}

/// An edge to a vertex that is not in the file.
pub fn vertex_missing(vertex: u64) -> String {
    format!("an edge names vertex {vertex}, which is missing")
}

/// A vertex that cannot be held fixed.
pub fn vertex_refused(vertex: u64, reason: &dyn Display) -> String {
    format!("vertex {vertex}: {reason}")
}

/// An edge that is no measurement.
pub fn edge_refused(from: u64, to: u64, reason: &dyn Display) -> String {
    format!("edge {from} to {to}: {reason}")
}

/// A vertex with too few edges.
pub fn vertex_undetermined(vertex: u64) -> String {
    format!("its edges do not determine vertex {vertex}; connect it to the others")
}

/// A vertex in a part of the graph without a fixed pose.
pub fn vertex_disconnected(vertex: u64) -> String {
    format!("no chain of edges connects vertex {vertex} to the first or a fixed one")
}

/// A vertex whose edges give no finite residual.
pub fn vertex_edge_not_finite(vertex: u64) -> String {
    format!("an edge of vertex {vertex} is not finite")
}

// Versions of a map: reasons for `version_is_worse`.

/// Tracking is lost more often.
pub fn loses_more(after: u64, before: u64) -> String {
    format!("in it the robot loses its place {after} time(s), {before} before")
}

/// Fewer scans are localised, percent.
pub fn localises_less(after: f64, before: f64) -> String {
    format!("in it the robot is localised after {after:.1} % of the scans, {before:.1} % before")
}

/// Scans fit less, 0 to 1.
pub fn fits_less(after: f64, before: f64) -> String {
    format!("scans fit it by {after:.3}, {before:.3} before")
}

/// More points of scans lie in free space, 0 to 1.
pub fn contradicts_more(after: f64, before: f64) -> String {
    format!("scans contradict it by {after:.3}, {before:.3} before")
}

// The platform.

/// It runs and can be opened at this address.
pub fn platform_running(address: &str) -> String {
    format!("AutoInspect is running: {address}")
}

/// How it is stopped.
pub fn platform_data(data: &Path) -> String {
    format!("data in {}; stop with Ctrl-C", data.display())
}

/// A process failed and is started again after this pause; `cause` is a clause.
pub fn process_restarts(role: &str, cause: &str, pause: Duration) -> String {
    let pause = match pause.is_zero() {
        true => String::new(),
        false => format!(" in {:.1} s", pause.as_secs_f64()),
    };
    format!("the {role} {cause} and is started again{pause}")
}

/// A process ends because one of its threads failed; `cause` is a clause.
pub fn process_failed(cause: &str) -> String {
    format!("this process {cause}")
}

/// Clauses after the name of a process: why it was started again.
pub const PANICKED: &str = "panicked";
pub fn did_not_answer(limit: Duration) -> String {
    format!("did not answer for {} s", limit.as_secs())
}
pub fn was_killed(signal: i32) -> String {
    format!("was killed (signal {signal})")
}
pub fn ended_with_code(code: i32) -> String {
    format!("ended (exit code {code})")
}

/// A process that does not end in time.
pub fn process_killed(role: &str) -> String {
    format!("the {role} does not stop and is killed")
}

// Limits of imports.

/// An argument that is no time.
pub const MINUTES_EXPECTED: &str = "expected a number of minutes, at least 0.01";

/// The name of what runs within limits, and what to do when it reaches one.
fn limited_command(command: LimitedCommand) -> (&'static str, &'static str) {
    match command {
        LimitedCommand::Import => (
            "the import",
            "thin the survey to a point every 2 or 3 cm in the program that made it, or cut it into parts; ",
        ),
        LimitedCommand::Align => ("the alignment", ""),
    }
}

/// It needed more memory than its limit.
pub fn out_of_memory(command: LimitedCommand, limit_mb: u64) -> String {
    let (name, remedy) = limited_command(command);
    format!(
        "{name} needs more than {limit_mb} MB of memory, its limit; {remedy}on a computer with more memory, --max-memory raises the limit"
    )
}

/// It needed more processor time than its limit.
pub fn out_of_time(command: LimitedCommand, limit_minutes: f64) -> String {
    let (name, remedy) = limited_command(command);
    format!(
        "{name} needs more than {limit_minutes} minutes of processor time, its limit; {remedy}--max-minutes raises the limit"
    )
}

/// It ended in another way than by a limit.
pub fn limited_command_ended(command: LimitedCommand, status: &dyn Display) -> String {
    let (name, _) = limited_command(command);
    let remedy = match command {
        LimitedCommand::Import => {
            "the file is damaged in a way that this program does not expect; export it again"
        }
        LimitedCommand::Align => "a map is damaged in a way that this program does not expect; make it again",
    };
    format!("{name} ended before it was done ({status}): {remedy}")
}

// Imports in another process: sentences for clients.

/// An import needed more memory than its limit.
pub const IMPORT_OUT_OF_MEMORY: &str = "It needs more memory than an import may take. Thin the survey to a point every 2 or 3 cm, or cut it into parts.";
/// An import needed more processor time than its limit.
pub const IMPORT_OUT_OF_TIME: &str = "It needs more time than an import may take. Thin the survey to a point every 2 or 3 cm, or cut it into parts.";
/// The same of an alignment.
pub const ALIGN_OUT_OF_MEMORY: &str = "It needs more memory than an alignment may take on the robot. Align the map on another computer with autoinspect align --max-memory.";
pub const ALIGN_OUT_OF_TIME: &str =
    "It needs more time than an alignment may take on the robot. Pick points in both maps, which takes less.";

/// A client cancelled it.
pub const IMPORT_CANCELLED: &str = "It was cancelled.";
/// It ended without an error message.
pub const IMPORT_ENDED_EARLY: &str =
    "The import ended before it was done: the file may be too large for this computer.";
/// Names of the two maps of an alignment in its errors.
pub const ALIGNED_MAP: &str = "the map";
pub const OTHER_MAP: &str = "the other map";

/// The process did not start.
pub fn import_not_started(error: &dyn Display) -> String {
    format!("The import cannot be started: {error}.")
}

/// The system does not say how the process ended.
pub fn import_outcome_unknown(error: &dyn Display) -> String {
    format!("What became of the import is not known: {error}.")
}

/// The folder of the example, in errors.
pub const EXAMPLE_FOLDER: &str = "the folder of the example";
/// The topological map of the example has no nodes.
pub const EXAMPLE_HAS_NO_NODES: &str = "the walk of the example made no nodes; give it more minutes";
/// No plate is seen from a node of the example.
pub const EXAMPLE_SEES_NOTHING: &str =
    "nothing to inspect is seen from the nodes of the example; give its walk more minutes";

/// A demonstration needs no sign-in, so it is not for a network.
pub fn demo_on_network(listen: &dyn Display) -> String {
    format!(
        "with --demo nobody signs in, so the server cannot listen on {listen}, which others can reach. Leave --demo out, or use --listen 127.0.0.1:8080"
    )
}

/// There is an admin, or the core has not run yet.
pub const NO_FIRST_ADMIN_LINK: &str = "there is no link for a first admin: there is an admin already, or the platform has not run yet. \"autoinspect account list\" shows the accounts";

/// While there is no admin: how to make the first one.
pub fn make_first_admin(link: &str) -> String {
    format!("nobody can sign in yet. This address makes the first admin, once: {link}")
}

/// How people make their browsers trust the robot's own certificate authority.
pub fn trust_authority(address: &str, fingerprint: &str) -> String {
    format!(
        "browsers warn until they trust the robot's own certificate authority. {address}/trust.html explains how; its SHA-256 fingerprint is {fingerprint}"
    )
}

/// There is no certificate authority of the robot's own.
pub const NO_AUTHORITY: &str = "the robot has no certificate authority of its own yet. \"autoinspect up --tls auto\" makes it at its first start";

/// There is an account of this name.
pub fn account_exists(account: &str) -> String {
    format!(
        "there is an account {account} already. \"autoinspect account reset {account}\" sets a new password"
    )
}

/// There is no account of this name.
pub fn no_account(account: &str) -> String {
    format!("there is no account {account}. \"autoinspect account list\" shows those that there are")
}

/// There is no valid token of this name.
pub fn no_token(name: &str) -> String {
    format!("there is no valid token {name}. \"autoinspect account list\" shows those that there are")
}

/// Asks for a password at a terminal.
pub fn password_prompt(account: &str) -> String {
    format!("New password of {account}: ")
}

/// A data directory without a ledger.
pub fn no_ledger(path: &Path) -> String {
    format!("there is no ledger at {}. Give the data directory of a platform that has run", path.display())
}

/// Every row of the ledger is whole, and its audit log has this number of entries.
pub fn ledger_is_whole(entries: u64, last: &str) -> String {
    format!("the ledger is whole; its audit log has {entries} entries, the last with the checksum {last}")
}
