//! Where a robot steps back to, to see what it cannot see from beside it.
//!
//! A LiDAR sees neither the ground beside the robot nor what is low there. What a person left in the elevation map beside the robot stays until the robot looks from
//! farther away. Nav2 has the same recovery, "back up".

use geometry::Vector3;
use navigation::ElevationMap;
use vocab::Span;

/// Parameters of stepping back in front of something that seems to stand in the robot's pose or path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackUpConfig {
    /// The robot steps back when it was not allowed to make its last steps for this time, or had no path. Above the time in which a person walks past, 2 s. Chosen: half of that time
    /// more.
    pub held_time: Span,
    /// Within this distance of the robot things that it does not see may be gone, metres. Chosen: the distance from which the elevation map clears thin traces.
    pub unseen_reach_m: f64,
    /// Distance that it steps back at most, metres. Above the distance from which the elevation map clears thin traces, 2 m, and the robot is beside the trace. Chosen: a
    /// fifth more.
    pub distance_m: f64,
    /// Shorter ways back than this show nothing new, metres. Chosen: a third of [`Self::distance_m`].
    pub min_distance_m: f64,
    /// Distance around the robot in which cells are not asked, metres: it may be too near to the thing. Chosen: a little more than the radius of the footprint of the
    /// default robot, 0.38 m. Beyond it, a path has to be free.
    pub footprint_m: f64,
    /// Distance between the cells that are asked on the way, metres: a cell of the elevation map.
    pub sample_m: f64,
    /// Ground that is farther than this above or below the robot's feet ends the way back, metres: a flight of stairs is entered in line only. Below the height of a step of stairs, 0.15 m and more.
    pub level_m: f64,
    /// Time that the robot looks at most. Traces of the highest confidence are cleared in 5.5 s. Chosen: 1.5 s more.
    pub look_time: Span,
    /// Angle between the directions that are tried, radians: an eighth of a turn, so that eight of them go all round.
    pub direction_step_rad: f64,
}

impl Default for BackUpConfig {
    fn default() -> Self {
        Self {
            held_time: Span::from_millis(3_000),
            unseen_reach_m: 2.0,
            distance_m: 2.4,
            min_distance_m: 0.8,
            footprint_m: 0.45,
            sample_m: 0.1,
            level_m: 0.1,
            look_time: Span::from_millis(7_000),
            direction_step_rad: std::f64::consts::FRAC_PI_4,
        }
    }
}

/// Directions that are tried, in steps from the direction away from the pose: straight back first.
const DIRECTIONS: [f64; 8] = [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0];

/// The point to step back to from `here`, beside `goal`: the end of the longest straight line over free ground that was seen, up to [`BackUpConfig::distance_m`].
/// All in the frame of the elevation map. None if there is no room to step back.
pub(crate) fn back_up_point(
    config: &BackUpConfig,
    elevation_map: &ElevationMap,
    here: &Vector3,
    goal: &Vector3,
) -> Option<Vector3> {
    let away = here - goal;
    let away_rad = away.y.atan2(away.x);
    let mut best: Option<(f64, f64)> = None;
    for direction_rad in DIRECTIONS.map(|steps| away_rad + steps * config.direction_step_rad) {
        let free_m = free_distance_m(config, elevation_map, here, direction_rad);
        if free_m >= config.min_distance_m && best.is_none_or(|(longest_m, _)| free_m > longest_m) {
            best = Some((free_m, direction_rad));
        }
    }
    let (distance_m, direction_rad) = best?;
    let (sin, cos) = direction_rad.sin_cos();
    Some(here + Vector3::new(distance_m * cos, distance_m * sin, 0.0))
}

/// Length of the straight line from `here` over free cells with level ground that was seen, metres, up to [`BackUpConfig::distance_m`].
fn free_distance_m(
    config: &BackUpConfig,
    elevation_map: &ElevationMap,
    here: &Vector3,
    direction_rad: f64,
) -> f64 {
    let (sin, cos) = direction_rad.sin_cos();
    let samples = (config.distance_m / config.sample_m).round() as u32;
    let foot_m = here.z - elevation_map.shape().standing_height_m;
    let is_free = |distance_m: f64| {
        let cell = elevation_map.index(here.x + distance_m * cos, here.y + distance_m * sin);
        let ground_m = elevation_map.cell(cell).ground();
        elevation_map.is_free(cell)
            && ground_m.is_some_and(|ground_m| (ground_m - foot_m).abs() <= config.level_m)
    };
    let mut free_m = 0.0;
    for distance_m in (1..=samples).map(|sample| f64::from(sample) * config.sample_m) {
        if distance_m > config.footprint_m && !is_free(distance_m) {
            break;
        }
        free_m = distance_m;
    }
    free_m
}
