//! Texts of `autoinspect changes`. Those about depth images are in `changes/texts.rs`.

use std::path::Path;

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

/// Clouds of a run and a recording.
pub fn run_and_recording(run: &Path, recording: &Path) -> String {
    format!(
        "{} has the clouds of a run, and {} is a recording, whose frame is not known; give the clouds of another run, or the folder of the map",
        run.display(),
        recording.display()
    )
}

/// A run during which the robot was not localised well in that map.
pub fn no_clouds_in_map(path: &Path) -> String {
    format!(
        "{} holds no clouds that were seen while the robot was localised well in the map of the other visit; compare visits of one site with one map",
        path.display()
    )
}
