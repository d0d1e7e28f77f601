//! Parameters of the generation of topological maps.

use navigation::ElevationMapConfig;

/// Parameters of [`crate::generate`] and [`crate::FloorBuilder`].
///
/// "Sensitivity" says what `cargo xtask bench topomap` showed when the value was changed (docs/benchmarks/topomap.md).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TopomapConfig {
    /// Edge of the cells in which one point of the clouds is kept, metres. Chosen: the noise of a LiDAR (2 cm) and the error of a map (1 cm) stay within
    /// a cell. It divides the edges of ground columns and layers.
    pub voxel_m: f64,
    /// Points farther than this from their keyframe are left out, metres. Chosen: keyframes are a metre apart, so that the ground along the walk is
    /// seen from nearer than this many times. Sensitivity: with 30 m, b1 has 63 nodes instead of 57.
    pub max_range_m: f64,
    /// Of eight neighbouring columns, how many must have ground. Fewer than for virtual viewpoints, so that doorways (0.9 m, four columns) keep theirs. Chosen: half of
    /// them.
    pub min_ground_neighbours: usize,
    /// A column without ground gets that of its neighbours if at least this number of the eight have ground at one height. LiDARs see the floor in
    /// rings, which leaves holes. Five: edges of platforms, where three have ground, do not grow.
    pub min_hole_neighbours: usize,
    /// Number of points that make an obstacle. One or two are noise: the edges of objects, or a person of whom most points were removed. Sensitivity: with 12, b1 has 52
    /// nodes instead of 57.
    pub min_obstacle_points: usize,
    /// Number of points that block a walked path. Where the robot has walked, what it meets later was put there, or is what is left of a person in the
    /// clouds; a closed door or a box has hundreds of points. Sensitivity: with 3, people cut generated:11 into 8 pieces.
    pub min_blocking_points: usize,
    /// What was seen for less than this time does not block a walked path, seconds. People stand for some seconds. What stays is seen for at least the time in which
    /// the robot walks [`Self::max_range_m`] towards it: 13 s at 0.9 m/s.
    pub lasting_s: f64,
    /// Half the width of the body as a share of the radius of the robot's turning circle. Default: 0.25 m of 0.38 m, robots of the proportions of Spot and
    /// ANYmal. Where the robot has walked, this much room is enough, because it has passed there; elsewhere there has to be the radius. Chosen for those robots.
    pub half_width_share: f64,
    /// Half the width that the feet need as a share of the same radius: the ground is checked this far to both sides. Default: 0.18 m of 0.38 m. Chosen for the same
    /// robots.
    pub half_stance_share: f64,
    /// Longest distance without known ground along an edge, metres: a hole in the data, shorter than any opening that a robot falls into. Chosen: the width of a door
    /// sill or a shadow.
    pub max_ground_gap_m: f64,
    /// Distance between the places of a line at which the ground is looked up, metres: half a column. Chosen: every column is met twice.
    pub line_step_m: f64,
    /// Distance before and behind a place of a line within which the highest ground counts, metres: a robot steps over the edge of a tread. Chosen: the depth of a tread.
    pub tread_m: f64,
    /// Greatest difference of height between the ground at the end of a line and that end, metres; more is another floor. Chosen: two steps of stairs.
    pub max_line_end_height_m: f64,
    /// A line follows the walked path if all of it is within this distance of samples of the path, metres. Chosen: less than the radius of a robot.
    pub walked_within_m: f64,
    /// Columns to each side of an obstacle in which the ground below it is searched: walls of half a metre.
    pub obstacle_ground_columns: i32,
    /// Greatest width of a corridor to either side, metres: room to walk round a person, as the default of [`site_model::Corridor`].
    pub max_corridor_m: f64,
    /// Distance between the samples of the walked path, metres. Chosen: less than the depth of a tread; smaller values cost time.
    pub sample_m: f64,
    /// Poses of the path that are farther apart than this belong to different walks, metres: a walk ended, or the robot was carried. Chosen: more than a robot walks
    /// between two poses, which are some ten a second, with lost ones.
    pub path_gap_m: f64,
    /// A path within this distance of a walked one is the same path, metres. It has to stay below 3 m, the distance within which every walked metre has an
    /// edge. Sensitivity: with 1 m, paths back along the same aisle become paths of their own. With 2 m, the path at b1 is 2.94 m from an edge at worst; with 1.2 m there
    /// are 69 nodes instead of 75.
    pub merge_distance_m: f64,
    /// Greatest difference in height of a sample and the place that it belongs to, metres. Chosen: three steps of stairs, less than a storey.
    pub same_height_m: f64,
    /// Two samples nearer to each other than this are one place, metres. Chosen: half a column.
    pub same_place_m: f64,
    /// Difference in height from which on two places are on different floors, metres: less than the lowest storey. Its default is that of
    /// [`ElevationMapConfig`].
    pub floor_separation_m: f64,
    /// Slope from which on ground is stairs: 20 degrees. EN ISO 14122-1 recommends ramps up to 20 degrees, and stairs from 20 to 45 degrees.
    pub min_stairs_slope: f64,
    /// Length over which the slope is measured, metres: three treads.
    pub stairs_window_m: f64,
    /// Least height of stairs, metres: two steps. Lower ones are walked over. Chosen: steps of 0.17 m.
    pub min_stairs_rise_m: f64,
    /// Distance of the nodes of stairs from the first and the last step, metres: half the length of a robot, so that it stands on level ground.
    pub stairs_margin_m: f64,
    /// Level ground between stairs that is no longer than this is a landing, and no floor of its own, metres. Chosen: landings of buildings are shorter, floors longer.
    pub max_landing_m: f64,
    /// Greatest distance between neighbouring nodes, metres. Chosen: the reference system has 37 nodes at B1. Sensitivity: the number of nodes on
    /// straight paths is inverse to it. With 14 m instead of 10 m, b1 has 66 nodes instead of 75.
    pub node_spacing_m: f64,
    /// Greatest distance of an edge from the path that it stands for, metres. A bend that departs more gets a node. Chosen: less than the width of a corridor to each
    /// side, 1 m. Sensitivity: with 1.2 m, b1 has 70 nodes instead of 75.
    pub max_deviation_m: f64,
    /// A part of a path that departs less from its straight line has no bend, metres, and is halved where the line is not free. Chosen: the edge of a cell of points.
    pub min_bend_m: f64,
    /// Nodes nearer to each other than this become one where all edges stay free, metres. Chosen: a fifth of [`Self::node_spacing_m`].
    pub node_merge_m: f64,
    /// Paths round an obstacle that are shorter than this in all are not kept as a loop, metres. Chosen: round a machine of 2 m by 2 m. Sensitivity: with 12 m, b1 has
    /// the same map.
    pub min_loop_m: f64,
    /// Dead ends shorter than this are dropped, metres: the robot turned round there. Chosen: less than the 3 m within which every walked metre has an edge.
    pub min_dead_end_m: f64,
    /// Distance between a dock and its approach node, metres. Its default is that of new docks.
    pub dock_approach_m: f64,
    /// A path within this distance of a dock ends at the dock, metres. Chosen: about the radius of a robot.
    pub dock_radius_m: f64,
    /// The approach of a dock is joined to a path within this distance, metres. Chosen: docks stand at the side of rooms and corridors, and less than this from a path.
    pub dock_reach_m: f64,
    /// In surveys: every place is within this distance of a node, over the floor, metres. Chosen as a round number: less makes more nodes, more leaves places far from
    /// all edges.
    pub survey_cover_m: f64,
    /// In surveys: connected floor smaller than this is left out, square metres. Chosen: a small room; less are tops of machines.
    pub min_survey_piece_m2: f64,
    /// In surveys: the middle of the robot can be where at least this number of the eight columns around have ground: the feet need it to both sides. One may be a hole
    /// in the data. Chosen: all but one.
    pub min_survey_ground_neighbours: usize,
    /// In surveys: a piece of floor of which this share has nothing above and lower floor around is a ceiling. That of roofs, see [`mapping::ground_surface::GroundConfig::roof_share`].
    pub ceiling_share: f64,
    /// In surveys: how much lower that floor is at least, metres: less than a storey, more than a step. Chosen as for roofs
    /// ([`mapping::ground_surface::GroundConfig::storey_layers`]).
    pub min_ceiling_height_m: f64,
    /// In surveys: how far from the middle of a ceiling that floor may be, metres. Where a wall hides the floor below a ceiling, the floor before the wall counts. Chosen: half the width of a
    /// common hall.
    pub ceiling_reach_m: f64,
    /// In surveys: a connection is left out if the kept connections join its ends at no more than this factor of its cost (greedy spanner; Althöfer and
    /// others, 1993). Chosen: with less, more edges run side by side; with more, routes are longer.
    pub max_survey_detour: f64,
    /// In surveys: paths keep this distance from obstacles where there is room, metres. Chosen: twice the radius of a robot.
    pub survey_inflation_m: f64,
    /// In surveys: factor by which floor nearer to obstacles costs more. Chosen: a detour of three times the length is preferred.
    pub survey_tight_cost: f64,
    /// In surveys: largest shift by which a path is moved to the middle of a passage, metres: half the diagonal of a column.
    pub max_survey_shift_m: f64,
    /// In surveys: the room to both sides of a place is measured along this distance before and behind it, metres. Together half a column, so that only
    /// obstacles beside the place count.
    pub survey_room_half_length_m: f64,
    /// Tolerances of the nodes.
    pub tolerances: NodeToleranceConfig,
}

/// Tolerances of generated nodes: how near the robot has to come to each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeToleranceConfig {
    /// Where the robot passes by, metres; less where the corridor is narrower. Chosen: a little less than the distance at which a robot passes by (0.35 m,
    /// `executive::PoseWalkConfig`).
    pub waypoint_m: f64,
    /// Smallest one of a waypoint, metres. Chosen: the error of localisation with a margin.
    pub min_waypoint_m: f64,
    /// At the ends of stairs, metres. Chosen: at the tolerance along a flight in docs/maths/navigation.md, section 5.
    pub portal_m: f64,
    /// Heading at the ends of stairs, radians: 10 degrees. Chosen: as there.
    pub portal_rad: f64,
    /// On a dock, metres. Chosen: what contacts allow for.
    pub dock_m: f64,
}

impl Default for NodeToleranceConfig {
    fn default() -> Self {
        Self { waypoint_m: 0.3, min_waypoint_m: 0.1, portal_m: 0.2, portal_rad: 0.175, dock_m: 0.03 }
    }
}

impl Default for TopomapConfig {
    fn default() -> Self {
        Self {
            voxel_m: 0.05,
            max_range_m: 12.0,
            min_ground_neighbours: 4,
            min_hole_neighbours: 5,
            min_obstacle_points: 3,
            min_blocking_points: 12,
            lasting_s: 10.0,
            half_width_share: 0.25 / 0.38,
            half_stance_share: 0.18 / 0.38,
            max_ground_gap_m: 0.3,
            line_step_m: 0.1,
            tread_m: 0.3,
            max_line_end_height_m: 0.4,
            walked_within_m: 0.3,
            obstacle_ground_columns: 2,
            max_corridor_m: 1.0,
            sample_m: 0.25,
            path_gap_m: 1.5,
            merge_distance_m: 1.5,
            same_height_m: 0.5,
            same_place_m: 0.1,
            floor_separation_m: f64::from(ElevationMapConfig::default().floor_separation_m),
            min_stairs_slope: 0.36,
            stairs_window_m: 0.8,
            min_stairs_rise_m: 0.34,
            stairs_margin_m: 0.5,
            max_landing_m: 5.0,
            node_spacing_m: 12.0,
            max_deviation_m: 0.8,
            min_bend_m: 0.05,
            node_merge_m: 2.5,
            min_loop_m: 8.0,
            min_dead_end_m: 2.5,
            dock_approach_m: site_model::Dock::APPROACH_M,
            dock_radius_m: 0.4,
            dock_reach_m: 5.0,
            survey_cover_m: 4.0,
            min_survey_piece_m2: 10.0,
            min_survey_ground_neighbours: 7,
            ceiling_share: 0.7,
            min_ceiling_height_m: 1.5,
            ceiling_reach_m: 10.0,
            max_survey_detour: 1.6,
            survey_inflation_m: 0.8,
            survey_tight_cost: 3.0,
            max_survey_shift_m: 0.15,
            survey_room_half_length_m: 0.05,
            tolerances: NodeToleranceConfig::default(),
        }
    }
}
