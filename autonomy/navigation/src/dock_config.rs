//! The marker of a dock, and parameters of its detection.

use registration::{GaussNewtonConfig, WidthSchedule};

/// The marker of a dock, in the frame of the docked base: x away from the dock, z up from the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockMarker {
    /// Distance from the middle of the docked base to the ridge, metres.
    pub ridge_m: f64,
    /// Half the width of the marker, metres.
    pub half_width_m: f64,
    /// Distance from the ridge back to the ends of the plates, metres.
    pub depth_m: f64,
    /// Lower edge of the plates above the floor, metres.
    pub bottom_m: f64,
    /// Upper edge, metres.
    pub top_m: f64,
}

impl Default for DockMarker {
    /// Plates at 30 degrees: each moves the scan's points as much by a lateral error of a centimetre as by half a centimetre along.
    fn default() -> Self {
        Self { ridge_m: 0.60, half_width_m: 0.35, depth_m: 0.202, bottom_m: 0.75, top_m: 1.10 }
    }
}

/// Parameters of [`crate::DockDetector`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DockDetectorConfig {
    /// The marker that is looked for. It is that of the simulated docks.
    pub marker: DockMarker,
    /// Margin at the lower and upper edge of the plates that is left out of the slice, metres: for an uneven floor. Chosen: a floor that rises by 2 degrees over a metre.
    pub edge_margin_m: f64,
    /// A dock is looked for within this distance of the expected place, along each axis, metres. It may have been pushed, and the robot's pose has an error. Chosen: more
    /// than a person pushes a dock by accident; the time grows with its square.
    pub search_m: f64,
    /// And within this difference of heading, radians. Chosen: a dock that is turned farther cannot be entered from its node.
    pub search_rad: f64,
    /// Step of the grid of poses that are tried, metres. Less than the distance from which the least squares converge. Chosen: the nearest pose of the grid is 2.5 cm off
    /// along each axis at most, well within the first gate of 0.12 m.
    pub step_m: f64,
    /// Step of their headings, radians. Chosen: at the end of a plate (0.4 m from the ridge), half of it moves a point by 1 cm.
    pub step_rad: f64,
    /// Points farther from the plates than this many steps of the grid add nothing to the score of a pose: half a step more than the nearest pose
    /// of the grid may be off.
    pub score_reach_steps: f64,
    /// Poses of the grid from which the least squares begin, at most. Chosen: bodies and walls may look like a marker at the step of the grid.
    pub max_starts: usize,
    /// Iteration of the least squares. It converges in about eight steps. The gate closes from four times [`Self::inlier_m`] to once: far points
    /// pull at first only.
    pub refinement: GaussNewtonConfig,
    /// Points farther from the place that is searched than the marker reaches, and this much, are left out, metres. Chosen: for the noise of a LiDAR and the steps of the
    /// grid.
    pub reach_margin_m: f64,
    /// Points of the slice that the grid is compared with, at most. More take longer and find no more. Chosen: the time of the search is in proportion to it.
    pub max_grid_points: usize,
    /// Points for the least squares, at most. Chosen: the time of the least squares is in proportion to it, and the noise averages out of fewer.
    pub max_points: usize,
    /// Points on the marker that are needed. Chosen: three for each section of both plates ([`Self::sections`]).
    pub min_points: usize,
    /// A point this near to a plate is on it, metres: three times the noise of a LiDAR.
    pub inlier_m: f64,
    /// Greatest root mean square of the distances of these points from the plates, metres. Chosen: one and a half times the noise of a LiDAR.
    pub max_residual_m: f64,
    /// Points beside a plate up to this distance belong to something of another shape, metres. Chosen: half the depth of a person.
    pub beside_m: f64,
    /// Share of the points beside the plates, of those on and beside them, from which on the shape is another one. Chosen with the 400 scenes of docs/maths/docking.md, section 5, of which at most one may be taken for a dock.
    pub max_beside_share: f64,
    /// Sections into which each plate is divided. Those without a point are hidden, or there is no plate. Chosen: a fifth of a plate is 8 cm, enough for its mean to be
    /// of several points.
    pub sections: usize,
    /// Share of the sections of each plate that must be seen, and the outermost one must be among them: ends are what walls and bodies do not have there. Chosen: three
    /// of five, so that a post or leg may hide a part.
    pub min_seen_share: f64,
    /// Greatest mean distance of the points of a section from the plate, metres. Noise averages out; what is bent or stands at another angle does not. Chosen: the mean
    /// of ten points with a noise of 1 cm is good to 3 mm.
    pub max_section_error_m: f64,
    /// Points of a section from which on its mean counts. Chosen: their mean is good to a third of the noise.
    pub min_section_points: usize,
    /// Length beyond the ends of the plates that must be free, metres. A wall goes on there. Chosen: a third of the length of a plate.
    pub beyond_m: f64,
    /// Points beyond the ends, by their share of the density on the plates, at which these are no ends. Chosen with the 400 scenes of docs/maths/docking.md, section 5.
    pub max_beyond_share: f64,
    /// Two poses farther apart than this that both look like the dock are ambiguous, metres. Chosen: three steps of the grid, and less than the width of a plate.
    pub separation_m: f64,
    /// Least standard deviation of a point's distance from its plate in the covariance, metres: few points may agree by chance. Chosen: a tenth of the noise of a LiDAR.
    pub min_noise_m: f64,
    /// Greatest standard deviation of the position found, metres. Chosen: a third of what contacts allow for, 3 cm.
    pub max_deviation_m: f64,
    /// Greatest standard deviation of the heading found, radians. Chosen: about a third of what contacts allow for, 3 degrees.
    pub max_deviation_rad: f64,
}

impl Default for DockDetectorConfig {
    fn default() -> Self {
        Self {
            marker: DockMarker::default(),
            edge_margin_m: 0.04,
            search_m: 0.5,
            search_rad: 15.0_f64.to_radians(),
            step_m: 0.05,
            step_rad: 3.0_f64.to_radians(),
            score_reach_steps: 1.5,
            max_starts: 5,
            refinement: GaussNewtonConfig {
                max_iterations: 16,
                min_step: 1e-6,
                initial_width: 4.0,
                schedule: WidthSchedule::Linear,
                relative_damping: 0.0,
                absolute_damping: 0.0,
            },
            reach_margin_m: 0.1,
            max_grid_points: 150,
            max_points: 1_500,
            min_points: 30,
            inlier_m: 0.03,
            max_residual_m: 0.015,
            beside_m: 0.15,
            max_beside_share: 0.12,
            sections: 5,
            min_seen_share: 0.6,
            max_section_error_m: 0.01,
            min_section_points: 10,
            beyond_m: 0.12,
            max_beyond_share: 0.35,
            separation_m: 0.15,
            min_noise_m: 1e-3,
            max_deviation_m: 0.01,
            max_deviation_rad: 0.02,
        }
    }
}
