//! Parameters of the elevation map, and the slices of height in which a cell keeps what it holds.

use crate::cell_index::floor;

/// Height slices that a [`crate::Cell`] keeps, one bit each.
pub(crate) const MAX_SLICES: i64 = 16;

/// Parameters of [`crate::ElevationMap`]. The values were tuned on the simulated sites with people walking about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElevationMapConfig {
    /// Least obstacle confidence at which a cell counts as an obstacle. Source: tuned as above: one sighting makes an obstacle, and it outlasts one contradicting
    /// sighting.
    pub obstacle_min: i8,
    /// Highest obstacle confidence that a cell keeps, so that people who leave are forgotten within seconds. Source: tuned as above: four sightings.
    pub obstacle_max: i8,
    /// Obstacle confidence that one sighting adds. A contradicting sighting takes 1. Source: tuned as above.
    pub obstacle_increment: i8,
    /// Height of a slice, metres. A cell keeps in which slices above its ground an obstacle was seen. Chosen: 16 slices, the bits of a cell, then hold two metres.
    pub slice_height_m: f64,
    /// Obstacles that appear thinner than this from the robot are not cleared by rays, radians: the beams of a LiDAR are up to 2 degrees apart. Chosen a little larger
    /// than that, 2.3 degrees.
    pub min_clearable_angle_rad: f64,
    /// Thin obstacles at least `thin_cleared_from_m` away are cleared by every scan whose number is a multiple of this. People who walk past at 4 m leave traces of one or two slices, with the
    /// highest confidence. Here a trace goes after 5.5 s, sooner than a walk gives up before a blocked path, and a thing that one scan in 15 hits stays. Sensitivity: with 8,
    /// traces outlast that wait.
    pub thin_cleared_scans: u32,
    /// Distance from which thin obstacles are cleared so, metres: the robot needs 1 m to stop. A rope that is forgotten from there is seen again on the way to it, unless it
    /// stays between two beams. Sensitivity: with 0, a robot that stands in front of a rope forgets it; with 4, corridors stay blocked by traces.
    pub thin_cleared_from_m: f64,
    /// Height that is assumed for an obstacle which was seen in one slice only, metres. Source: tuned as above: it stands for a bar or a cable.
    pub single_slice_height_m: f64,
    /// Height that is assumed instead while the confidence is below `trace_confidence`, metres: people who walk past leave such traces. It decides from how far they are
    /// cleared, here 6 m, as far as a route is planned at once. Sensitivity: with 0.12 m, 3 m, traces across a corridor kept robots from going on until somebody helped them.
    pub trace_height_m: f64,
    /// Obstacle confidence below which an obstacle may be the trace of a person who walked past. Chosen: fewer than three sightings.
    pub trace_confidence: i8,
    /// A point less than this above the lowest beam may hang in the air, metres: its foot would be below the field of view. Chosen: the noise of the lowest beam's height
    /// and a tread that is not level.
    pub footless_margin_m: f64,
    /// Growth of that margin with the distance from the robot, metres for each metre. Chosen: a tilt of the robot by 2.3 degrees.
    pub footless_margin_slope: f64,
    /// Steepest slope of ground, metres for each metre: steep stairs. Chosen: 42 degrees, about the steepest stairs that robots climb.
    pub max_slope: f64,
    /// Ground that is higher than a step must have a neighbour one step lower within this number of cells: the depth of a tread. Chosen: treads are 0.25 to 0.3 m deep.
    pub tread_cells: i32,
    /// Points lower than this share of a step above the known ground of their cell are of the ground, and hide nothing that stands behind them. Chosen: half; ground rises
    /// within a cell, and things that are obstacles are higher than a step.
    pub ground_share_of_step: f64,
    /// Rays of one scan that are tested against obstacles at most, to bound the cost of a scan. Chosen: about half of a full sweep of an XT-32 (64,000 rays).
    pub max_rays: usize,
    /// Scans in a period; an obstacle that no scan has seen in this period or the one before is not in view. Chosen: half a second; a thin thing that every tenth scan hits is
    /// in view.
    pub scans_per_period: u32,
    /// Slices below the robot's feet in which points are kept: 24 slices of 0.125 m are 3 m. Chosen: as [`Self::max_depth_m`].
    pub slices_below_feet: i64,
    /// A ground height that differs by more than this from the known one belongs to another floor, metres. Chosen: less than a storey, more than the steps that a robot
    /// climbs at once.
    pub floor_separation_m: f32,
    /// Depth below the robot's feet down to which points are used, metres. Chosen: a storey, down to which a robot at the head of stairs sees.
    pub max_depth_m: f32,
    /// Points nearer to the LiDAR than the robot's radius plus this are the robot itself, metres. Chosen: a cell of the map.
    pub self_margin_m: f64,
}

impl Default for ElevationMapConfig {
    fn default() -> Self {
        Self {
            obstacle_min: 2,
            obstacle_max: 12,
            obstacle_increment: 3,
            slice_height_m: 0.125,
            min_clearable_angle_rad: 0.04,
            thin_cleared_scans: 5,
            thin_cleared_from_m: 2.0,
            single_slice_height_m: 0.03,
            trace_height_m: 0.25,
            trace_confidence: 7,
            footless_margin_m: 0.12,
            footless_margin_slope: 0.04,
            max_slope: 0.9,
            tread_cells: 3,
            ground_share_of_step: 0.5,
            max_rays: 30_000,
            scans_per_period: 5,
            slices_below_feet: 24,
            floor_separation_m: 1.2,
            max_depth_m: 3.0,
            self_margin_m: 0.1,
        }
    }
}

impl ElevationMapConfig {
    /// The slice that holds a height, counted from height zero.
    pub(crate) fn slice(&self, height: f32) -> i64 {
        i64::from(floor(f64::from(height) / self.slice_height_m))
    }

    /// Number of slices from the one that holds the ground up to `height` above the ground.
    pub(crate) fn slices_up_to(&self, ground: f32, height: f32) -> i64 {
        (f64::from(ground + height) / self.slice_height_m).ceil() as i64 - self.slice(ground)
    }

    /// The slices below `height` above the ground, as bits.
    pub(crate) fn low_slices(&self, ground: f32, height: f32) -> u16 {
        !(u16::MAX << self.slices_up_to(ground, height).clamp(0, MAX_SLICES - 1))
    }
}
