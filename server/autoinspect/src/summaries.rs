//! What commands say about their results, and names that they give by default, by key. English. Errors and notes are in `texts`.

use api::MapSummary;
use std::path::Path;

/// A share of the memory or of a file in megabytes.
fn megabytes(bytes: u64) -> f64 {
    bytes as f64 * 1e-6
}

/// A map of which neither a name nor a file is known.
pub const MAP_NAME: &str = "Map";
/// The mission of the example.
pub const EXAMPLE_MISSION: &str = "Daily round";
/// A robot of which a recording says nothing.
pub const RECORDED_ROBOT: &str = "Recorded robot";

/// A map that was aligned with another one.
pub fn aligned_map_name(name: &str, onto: &str) -> String {
    format!("{name} on {onto}")
}

/// A scan of a keyframe in a file.
pub fn keyframe_name(keyframe: u32) -> String {
    format!("keyframe {keyframe}")
}

/// Points of inspection of the example, by the tag of their plate.
pub fn gauge_name(is_pressure: bool, tag: &str) -> String {
    format!("{} gauge {tag}", if is_pressure { "Pressure" } else { "Temperature" })
}

pub fn valve_name(tag: &str) -> String {
    format!("Valve {tag}")
}

pub fn machine_heat_name(tag: &str) -> String {
    format!("Machine {tag}, heat")
}

pub fn air_name(tag: &str) -> String {
    format!("Air at {tag}")
}

pub fn machine_radiation_name(tag: &str) -> String {
    format!("Machine {tag}, radiation")
}

/// Where a simulated recording is from.
pub fn simulated_origin(site: &str, route: &str, seed: u64) -> String {
    format!("simulated site {site}, route {route}, seed {seed}")
}

/// An account in a list.
pub fn account(name: &str, role: &str, is_enabled: bool) -> String {
    format!("{name}  {role}{}", if is_enabled { "" } else { "  (disabled)" })
}

/// A token in a list.
pub fn token(name: &str, role: &str, days: f64) -> String {
    format!("token {name}  {role}  {days:.0} days left")
}

/// How a cloud came into the frame of a map: `map`, if it was found there by itself. `origin_m`: its origin in the map.
pub fn cloud_aligned(map: Option<&Path>, count: u64, rms_m: f64, origin_m: [f64; 3]) -> String {
    let [x, y, z] = origin_m;
    let origin = format!("its origin lies at {x:.2} {y:.2} {z:.2} m");
    match map {
        Some(map) => format!(
            "found in {}: {count} places recognised, {rms_m:.3} m apart in the mean; {origin}",
            map.display()
        ),
        None => format!("aligned by {count} pairs of points, {rms_m:.3} m apart in the mean; {origin}"),
    }
}

/// A map was aligned.
pub fn map_aligned(name: &str, out: &Path, points: u64, keyframes: u64) -> String {
    format!("{name} in {}: {points} points, {keyframes} keyframes", out.display())
}

/// A recording was converted.
pub fn converted(out: &Path, messages: u64, scans: u64, bytes: u64, unreadable: u64) -> String {
    format!(
        "{}: {messages} messages, {scans} of them scans, {:.1} MB, {unreadable} unreadable messages left out",
        out.display(),
        megabytes(bytes)
    )
}

/// The example was made.
pub fn example_made(
    out: &Path,
    walk_s: f64,
    keyframes: usize,
    nodes: usize,
    edges: usize,
    inspection_points: usize,
) -> String {
    format!(
        "{}: {walk_s:.0} s walked, {keyframes} keyframes, {nodes} nodes, {edges} edges, {inspection_points} inspection points",
        out.display()
    )
}

/// How long that took.
pub fn example_times(walk_s: f64, write_s: f64, topomap_s: f64) -> String {
    format!("walked in {walk_s:.1} s, written in {write_s:.1} s, topological map in {topomap_s:.1} s")
}

/// A map was exported.
pub fn exported(out: &Path, points: u64, bytes: u64) -> String {
    format!("{}: {points} points, {:.1} MB", out.display(), megabytes(bytes))
}

/// A cloud became a map. `size_m`: of its bounds. `up`: the axis of the file that points up.
pub fn imported(name: &str, out: &Path, points: u64, scans: u64, size_m: [f32; 3], up: &str) -> String {
    let [x, y, z] = size_m;
    format!(
        "{name} in {}: {points} points of {scans} scan(s), {x:.1} x {y:.1} x {z:.1} m, {up} of the file points up",
        out.display()
    )
}

pub fn unusable_points(count: u64) -> String {
    format!("{count} points without a position were left out")
}

pub fn coordinates_shifted(offset_m: [f64; 3]) -> String {
    let [x, y, z] = offset_m;
    format!("{x:.0} {y:.0} {z:.0} m were subtracted from the coordinates")
}

pub const NO_FLOOR: &str = "no floor was found: the map can be viewed, but no robot can localise in it";

pub fn virtual_viewpoints(count: u64) -> String {
    format!("{count} virtual viewpoints")
}

/// A saved map.
pub fn map(folder: &Path, map: &MapSummary) -> String {
    format!(
        "{}: map \"{}\" ({}), {:.1} m walked, {} keyframes, {} points, {:.1} MB",
        folder.display(),
        map.name,
        map.id,
        map.distance_m,
        map.keyframes,
        map.points,
        megabytes(map.bytes)
    )
}

/// What a recording has.
pub fn recording(path: &str, format: &str, duration_s: f64) -> String {
    format!("{path}: {format}, {duration_s:.1} s")
}

pub const SENSORS: &str = "Sensors";
pub const MISSING: &str = "Missing";
pub const WARNINGS: &str = "Warnings";

/// The robot was localised along a recording. `found_after_s`: since its begin.
pub fn localised(
    out: &Path,
    scans: u64,
    localised: u64,
    found_after_s: Option<f64>,
    low_confidence: u64,
    lost: u64,
) -> String {
    let found = found_after_s.map_or_else(|| "not found".to_owned(), |s| format!("found after {s:.1} s"));
    format!(
        "{}: {localised} of {scans} scans localised, {found}, {low_confidence} with low confidence, lost {lost} time(s)",
        out.display()
    )
}

pub fn localise_times(scan_ms: f64, scan_p99_ms: f64, searching_ms: f64) -> String {
    format!("{scan_ms:.1} ms CPU a scan, 99th percentile {scan_p99_ms:.1} ms, {searching_ms:.0} ms searching")
}

/// A recording was mapped.
pub fn mapped(
    out: &Path,
    scans: u64,
    points: u64,
    distance_m: f64,
    duration_s: f64,
    keyframes: usize,
    map_points: u64,
) -> String {
    format!(
        "{}: {scans} scans with {points} points over {distance_m:.1} m and {duration_s:.1} s, {keyframes} keyframes, {map_points} points in the map",
        out.display()
    )
}

pub fn map_times(
    seconds: f64,
    times_real_time: f64,
    scan_ms: f64,
    scan_p99_ms: f64,
    memory_bytes: u64,
) -> String {
    format!(
        "{seconds:.1} s, {times_real_time:.1} times real time; {scan_ms:.2} ms a scan (99 % within {scan_p99_ms:.2} ms), at most {} MB",
        memory_bytes / 1_000_000
    )
}

pub fn loops_closed(accepted: u64, compared: u64) -> String {
    format!("{accepted} loops closed of {compared} compared")
}

pub fn degenerate_segments(count: usize, length_m: f64) -> String {
    format!("{count} degenerate segments, {length_m:.1} m in all")
}

pub fn unreadable_messages(count: u64) -> String {
    format!("{count} messages could not be read")
}

/// Maps were merged.
pub fn merged(out: &Path, keyframes: u64, points: u64) -> String {
    format!("{}: {keyframes} keyframes, {points} points", out.display())
}

/// A map that is a part of it now. `origin_m`: its origin in the first map.
pub fn joined(map: &Path, recognised: u64, loops: u64, origin_m: [f64; 3]) -> String {
    let [x, y, z] = origin_m;
    format!(
        "{}: {recognised} places recognised, {loops} loops; its origin lies at {x:.2} {y:.2} {z:.2} m",
        map.display()
    )
}

/// A graph was optimised.
pub fn optimised(poses: usize, edges: usize, chi2: f64, iterations: usize, cpu_s: f64) -> String {
    format!(
        "{poses} poses, {edges} edges: chi-squared {chi2:.6} after {iterations} iterations, {cpu_s:.3} s of CPU"
    )
}

pub fn step_times(median_ms: f64, p99_ms: f64, max_ms: f64) -> String {
    format!("a step: {median_ms:.3} ms in the median, {p99_ms:.2} ms in 99 of 100, {max_ms:.2} ms at most")
}

pub fn edge_rejected(from: u64, to: u64) -> String {
    format!("rejected: {from} to {to}")
}

/// A map was patched.
pub fn patched(out: &Path, removed: u64, added: u64, changed: u64, keyframes: u64) -> String {
    format!(
        "{}: {removed} points removed and {added} added, in {changed} of {keyframes} keyframes",
        out.display()
    )
}

/// How well a recording fits the map before and after.
pub fn fits(before: &str, after: &str) -> String {
    format!("before: {before}\nafter: {after}")
}

pub fn fit(scans: u64, localised: u64, lost: u64, fit: f64, contradicted: f64) -> String {
    format!(
        "{localised} of {scans} scans localised, lost {lost} time(s), scans fit by {fit:.3} and contradict the map by {contradicted:.3}"
    )
}

/// A recording was replayed.
pub fn replayed(inputs: u64, effects: u64, fingerprint: &str) -> String {
    format!("{inputs} inputs, {effects} effects, {fingerprint}")
}

/// A simulated walk was recorded.
pub fn recorded(out: &Path, seconds: f64, scans: u64, points: u64, distance_m: f64) -> String {
    format!("{}: {seconds:.1} s, {scans} scans with {points} points, {distance_m:.1} m walked", out.display())
}

/// What can change at a simulated site, a line for each thing. Points are in the site frame, metres.
pub fn changeable_door(hinge: [f64; 3]) -> String {
    format!("door, hinge at {}", place(hinge))
}

pub fn changeable_gauge(tag: &str, at: [f64; 3], [least, most]: [f64; 2], unit: &str) -> String {
    format!("gauge {tag}, {least} to {most} {unit}, at {}", place(at))
}

pub fn changeable_lamp(at: [f64; 3]) -> String {
    format!("lamp at {}", place(at))
}

fn place([x, y, z]: [f64; 3]) -> String {
    format!("[{x:.2}, {y:.2}, {z:.2}]")
}

/// A simulated site was written.
pub fn site_written(file: &Path) -> String {
    format!("{} and its .site.json", file.display())
}

/// A topological map.
pub fn topomap(
    nodes: usize,
    edges: usize,
    stairs: usize,
    floors: usize,
    length_m: f64,
    docks: usize,
) -> String {
    format!(
        "{nodes} nodes and {edges} edges ({stairs} of them stairs) on {floors} floors, {length_m:.1} m in all, {docks} docks"
    )
}

pub fn topomap_making(blocked: usize, pieces: usize, read_s: f64, made_s: f64) -> String {
    format!(
        "{blocked} blocked stretches, {pieces} connected pieces; read in {read_s:.2} s, made in {made_s:.2} s"
    )
}

/// Two trajectories were compared.
pub fn compared(
    pairs: usize,
    estimate_poses: usize,
    truth_length_m: f64,
    estimate_length_m: f64,
    scale: f64,
) -> String {
    format!(
        "{pairs} of {estimate_poses} poses compared over {truth_length_m:.2} m (estimate {estimate_length_m:.2} m, scale {scale:.4})"
    )
}

pub const ABSOLUTE_POSITION: &str = "absolute, position";
pub const ABSOLUTE_VERTICAL: &str = "absolute, vertical";
pub const ABSOLUTE_ORIENTATION: &str = "absolute, orientation";
pub const POSE_TO_POSE: &str = "pose to pose";

/// An error of a trajectory: one of the names above, and its unit.
pub fn trajectory_error(name: &str, unit: &str, rmse: f64, mean: f64, median: f64, max: f64) -> String {
    format!("{name:<22} rmse {rmse:.4} {unit}, mean {mean:.4}, median {median:.4}, max {max:.4}")
}

pub fn error_at_end(error_m: f64) -> String {
    format!("{:<22} {error_m:.4} m", "at the end")
}
