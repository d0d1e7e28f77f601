//! Error messages of the commands, by key. English; each names the error, the file and the remedy.

use mapping::AlignmentError;
use std::fmt::Display;
use std::path::Path;

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
        AlignmentError::Ambiguous(count, rival) => format!(
            "{map} fits into {first} in two ways, with {count} and {rival} places recognised; walk a part on which they differ"
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

/// The core stopped without a request.
pub const CONTROL_LOOP_ENDED: &str = "the control loop ended unexpectedly";
