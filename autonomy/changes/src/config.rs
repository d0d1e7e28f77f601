//! Parameters of the detection of changes.

use crate::SizeLikelihoodConfig;
use object_identity::AssociationConfig;
use registration::MatchingConfig;

/// Parameters of [`crate::detect_changes`].
///
/// "Sensitivity" says what the recorded sessions of docs/benchmarks/changes.md showed when the value was changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangesConfig {
    /// How the visits are aligned before they are compared.
    pub alignment: AlignmentConfig,
    /// A surface of the other visit within this distance of a point is the same surface, metres, if the visits are well aligned. Chosen: three standard deviations of a pose error
    /// of 2 cm and of the noise of a LiDAR (1 cm) together, and [`Self::resolution_m`]. With 0.15 m, a thing of 0.15 m on the floor is not seen.
    pub same_surface_m: f64,
    /// The largest such distance, metres, however badly the visits are aligned: with more, no object of 0.3 m is seen.
    pub max_same_surface_m: f64,
    /// Where the surfaces of the visits are not well aligned, surfaces within this number of standard deviations of their distance are the same: that of the poses and of the noise.
    pub same_surface_deviations: f64,
    /// Standard deviation of the range of a LiDAR, metres.
    pub range_noise_m: f64,
    /// Additional distance for the resolution of the points in the clouds of runs, metres.
    pub resolution_m: f64,
    /// Points farther from the sensor than this are left out, metres, because few rays meet an object there. Chosen as a round number: with 15 m the first three seeds of
    /// docs/benchmarks/changes.md gave the same result.
    pub max_range_m: f64,
    /// Points nearer to the sensor than this are left out, metres: the robot itself. Chosen: about half the length of a legged robot.
    pub min_range_m: f64,
    /// Limits of the side of a cell of the image of a view, radians: an image of a dense sensor stays small, and the cells of a sparse one tell places apart. Chosen: 0.4
    /// degrees keeps an image below 900 x 450 cells; 3 degrees are 0.5 m at a range of 10 m.
    pub cell_rad: [f64; 2],
    /// Side of the cells in which the density of the rays of a view is measured, radians. Chosen: 4 degrees, more than the largest cell of an image, so that a cell in
    /// which there are rays has several.
    pub density_cell_rad: f64,
    /// Side of the cells in which the farthest range of the rays of a view is kept, radians. It changes nothing but the time: with 0.02, 0.03 and 0.045 rad a comparison took the same processor time to
    /// 2 %, and so it did with 0.07 rad and the farthest range of the cells around.
    pub sight_cell_rad: f64,
    /// A ray tells of places within this distance of it, metres. Chosen while [`Self::same_surface_m`] was 0.15 m, and below it: a ray beside an object that is still
    /// there then tells nothing of its points, which have a surface near them. With 0.08 and 0.2 m the first three seeds of docs/benchmarks/changes.md gave the same
    /// result.
    pub ray_reach_m: f64,
    /// The same for the rays of the visit itself, metres. Chosen: the width of the beam of a LiDAR at 15 m, and the noise. With one or one and a half mean distances between rays, if
    /// that is more, 4 of 20 boxes of the first seeds of docs/benchmarks/changes.md are joined with what stands beside them.
    pub own_ray_reach_m: f64,
    /// A ray went through a place if it ended at least this distance behind it, metres. Chosen: a pose error of 2 cm and the noise of the range are far below it. With
    /// 0.05 and 0.2 m the first three seeds of docs/benchmarks/changes.md gave the same result.
    pub free_margin_m: f64,
    /// Additional distance as a share of the range, for errors of the heading: 0.6 degrees. Chosen: an error of the heading moves a place by that angle times the range.
    pub free_margin_share: f64,
    /// Rays that have to have gone through a place. One may be a stray one. With 4 the first three seeds of docs/benchmarks/changes.md gave the same result.
    pub min_free_rays: usize,
    /// Share of the rays that passed a place or ended there that have to have gone through it. Chosen: the majority decides. With less, errors of poses make edges
    /// appear; with more, thin things that are gone are missed.
    pub min_free_share: f64,
    /// Share of the views of its own visit from which nearly all rays went through the place of a point, from which on it belonged to something that moves, such as a person.
    /// Chosen: the majority of the views decides. With 0.3 the first three seeds of docs/benchmarks/changes.md gave the same result.
    pub moving_share: f64,
    /// Side of the cells of which all points without a surface near them have changed or not together, metres. Chosen: less than half of [`Self::ray_reach_m`].
    pub candidate_cell_m: f64,
    /// Once this number of views has told of a place, no others are asked: they are a sample of all. Chosen: the time grows with it. With 32 and 64 the hall and the cast visits of
    /// docs/benchmarks/changes.md gave the same results.
    pub enough_views: usize,
    /// Points of a box of which is asked whether something passed there, at most: they are a sample of all. Chosen: the error of a share is 5 % at most (one standard deviation). With 30 and 300 the hall and the
    /// cast visits of docs/benchmarks/changes.md gave the same results.
    pub max_asked_points: usize,
    /// An object was seen from at least this number of views, or from all of a visit with fewer: who walks past is seen at a place once. And its place was looked through from as many views of the other
    /// visit: the pose of one view may be wrong.
    pub min_views: usize,
    /// Of an object that does not walk, and is twice [`Self::same_surface_m`] thick, one view with this number of rays is enough. Chosen: a box of 0.4 x 0.4 m at 6 m, seen by a LiDAR of 64 rings and 500 columns.
    pub min_rays_of_one_view: usize,
    /// The same of objects of at least [`Self::walking_height_m`]. Chosen: views are 2 m apart, and who walks slowly beside the robot, or is followed by another person, is seen at one
    /// place from two.
    pub min_views_if_walking: usize,
    /// What is less high does not walk, metres. Chosen: half the height of a person who bends down.
    pub walking_height_m: f64,
    /// A view tells whether an object was there during its own visit if at least this number of its rays met its place.
    pub min_telling_rays: usize,
    /// Largest distance between neighbouring points of an object, metres. Chosen: smaller parts of one thing are joined, and things half a metre apart are not. With 0.2
    /// and 0.4 m the first three seeds of docs/benchmarks/changes.md gave the same result.
    pub gap_m: f64,
    /// An object that stands on the ground, is lower than [`Self::walking_height_m`] and is at least [`Self::min_size_m`] thick has at least this number of changed points, and of points above the ground. A ray past an edge makes single ones. Chosen: a cube of 0.15 m at 6 m has as many above
    /// [`Self::ground_clearance_m`] in one passage of a LiDAR of 64 rings and 500 columns.
    pub min_points: usize,
    /// The same of others. Source: docs/benchmarks/changes.md, where a strip of 22 points beside an edge was named, and with 20 a person.
    pub min_points_of_others: usize,
    /// An object is at least this large along its second longest side, metres. Chosen: less than the smallest thing that is to be found, a cube of 0.15 m, and more than
    /// [`Self::same_surface_m`].
    pub min_size_m: f64,
    /// A ray tells of an object only if it meets its box at least this far from its edges, metres. Chosen: one and a half standard deviations of a pose error of 2 cm.
    pub edge_margin_m: f64,
    /// Least side of the box that rays have to meet, metres: a sheet. Chosen: less than the noise of a LiDAR.
    pub min_core_side_m: f64,
    /// Share of rays that end in a place where nothing is, or go through what is solid: noise, and edges of the box. Chosen as a round number: with 0.1 the first three seeds of
    /// docs/benchmarks/changes.md gave the same result.
    pub stray_share: f64,
    /// Logarithm of how much likelier a change must be than none. Chosen: 10,000 times, because a visit has thousands of places. With 20
    /// the first three seeds of docs/benchmarks/changes.md gave the same result.
    pub min_evidence: f64,
    /// Share of rays that end by chance in a place where nothing is, such as people who pass, and edges. Chosen as a round number, below [`Self::stray_share`]: with 0.05
    /// the first three seeds of docs/benchmarks/changes.md gave the same result.
    pub chance_share: f64,
    /// An object is not gone if as many rays ended in its place as they do by chance with less than this probability. Chosen: the usual level of 1 % of a test. A higher
    /// one calls objects unchanged that are gone.
    pub min_chance: f64,
    /// An object is gone as a whole: share of its points that may have a surface of the other visit near them, such as a wall behind it. Source: docs/maths/changes.md:
    /// of the boxes of the benchmark it was below 4 %, of parts of a truss mostly 10 to 80 %. With 0.08 and 0.3 the first three seeds of docs/benchmarks/changes.md gave
    /// the same result.
    pub max_same_share: f64,
    /// Of an object that is larger than [`Self::large_m`], the other visit looked through this share of the cells in which the object has points without a surface of the other visit near
    /// them. Chosen: a part of a building with an opening, through which rays went, had 0.23 in docs/benchmarks/changes.md; large boxes there and on simulated sites had 0.5 and more.
    pub min_known_share: f64,
    /// A side of more than this is large, metres. Chosen: a thing that was found by a few points grows by what is unknown beside it, smaller things by little.
    pub large_m: f64,
    /// Side of these cells, metres. Chosen: as [`Self::unchanged_cell_m`].
    pub known_cell_m: f64,
    /// Points of unknown places within this distance of an object belong to it, metres: parts of it that the other visit saw beside its neighbours only. Chosen: as
    /// [`Self::gap_m`].
    pub grow_m: f64,
    /// The same above and below it, metres: the rings of a LiDAR leave gaps between the parts of a thing that stands. Chosen: rings 5 degrees apart are 0.6 m apart at 7
    /// m. With 0.3 m the first three seeds of docs/benchmarks/changes.md gave the same result.
    pub grow_up_m: f64,
    /// Times that an object is grown by the points of unknown places around it. Chosen: it bounds the time, and an object cannot grow along a chain of unknown points.
    pub grow_rounds: usize,
    /// If an object has parts of what stays in its box, and it was grown by no more than this share of its points, and it stands on the ground and is at least [`Self::min_size_m`] thick, it is looked at as it was before it was grown: a few unknown points of a wall beside it
    /// make its box as high as the wall. Chosen: a part of a larger thing, such as a truss, grows by more.
    pub stray_growth_share: f64,
    /// Points less than this above the ground are not of an object, metres: the noise of a LiDAR, and floors that are not quite level. Chosen: as
    /// [`Self::same_surface_m`]. With 0.12 m the first three seeds of docs/benchmarks/changes.md gave the same result.
    pub ground_clearance_m: f64,
    /// The lower end of an object that is nearer to the ground than this stands on it, metres: points nearer to the ground than [`Self::same_surface_m`] count as ground, and
    /// rays at a slant do not go through places just above it. Chosen as a round number: with more, things on low shelves count as standing on the floor.
    pub stands_within_m: f64,
    /// The ground of an object is the most common height of the points within this distance of its sides, metres. Chosen as a round number: with less, no ring of a
    /// sparse LiDAR may be on the floor there; with more, other levels are counted.
    pub ground_reach_m: f64,
    /// The ground is looked for down to this distance below an object whose lower part may not have been seen, metres. Chosen: the height of a thing of which only the
    /// upper part was seen, less than a storey.
    pub ground_depth_m: f64,
    /// Heights are counted in bins of this size, metres. Chosen: more than the noise of a LiDAR, and less than a step.
    pub ground_bin_m: f64,
    /// A height with fewer points is no ground. Chosen: a ring of a LiDAR on the floor has more, and stray points are fewer.
    pub min_ground_points: usize,
    /// Share of the points that are looked at within [`Self::level_reach_m`] of the ground's height that are within one and a half bins of it: of the upright sides of a thing three of eleven bins are, 27 %. With 0.5 and 0.6 the hall and the
    /// cast visits of docs/benchmarks/changes.md gave the same results; with 0.45 and 0.5 a change more of 13 is found again in the map in which it is normal.
    pub min_level_share: f64,
    /// Height above and below the ground within which points say whether it is level, metres. Chosen: five bins.
    pub level_reach_m: f64,
    /// How boxes are fitted.
    pub box_fit: BoxFitConfig,
    /// How what is gone and what is new is put together to things that were moved. Source: docs/benchmarks/changes.md.
    pub association: AssociationConfig,
    /// How likely it is that two objects of these sizes are one that was moved.
    pub size_likelihood: SizeLikelihoodConfig,
    /// See [`Self::turned_size_share`], metres. Chosen: a side is seen by points that are some centimetres from each other.
    pub same_size_m: f64,
    /// The points of a thing that was turned where it stands are at most this far from the middle of what differs, metres: what reaches farther is no loose thing.
    pub turned_reach_m: f64,
    /// Largest distance between neighbouring points of such a thing, metres.
    pub turned_gap_m: f64,
    /// Each of its sides differs at most by this share before and after, or by [`Self::same_size_m`]: a side that was seen at a slant looks shorter.
    pub turned_size_share: f64,
    /// It was turned by at least this angle, radians, or shifted by at least [`Self::min_shift_m`]. Chosen: three times the error of the heading of a box that is well seen.
    pub min_turn_rad: f64,
    /// See [`Self::min_turn_rad`], metres.
    pub min_shift_m: f64,
    /// What stands on the ground is looked at up to this height above it, metres, to find such things of which no part differs. Chosen: as [`Self::turned_reach_m`]; and most people are higher.
    pub standing_height_m: f64,
    /// Points at least this far above the mean height of a floor are not of the floor, metres. Chosen: five times the noise of a LiDAR, and less than half of the height of the smallest thing that is to be found.
    pub standing_clearance_m: f64,
    /// A height is that of a floor if this share of the cells is occupied at it that is occupied at the height where most are. Chosen: a floor of which two thirds are hidden is one.
    pub level_share: f64,
    /// The fit by which is first told whether such a thing has its heading of before. Chosen: the time is in proportion to its points and headings.
    pub turned_first_fit: BoxFitConfig,
    /// The points of each visit are likelier with the heading of that visit than with that of the other one by [`Self::min_evidence`], and by this logarithm for each point on average: of a thing that is no
    /// box, many points tell a little. Source: docs/maths/changes.md, equation 10: 0.25 and more of things that were turned.
    pub min_turn_evidence_of_point: f64,
    /// Logarithm of how much likelier the points of such a thing are on the sides of a box than on a circle. Source: docs/maths/changes.md, equation 11: 8 and more of things that were turned, 2 and less of round ones.
    pub min_corner_evidence: f64,
    /// Share of the points of such a thing that are on the sides of its box. Source: docs/maths/changes.md, equation 11: 0.53 and more of things that were turned.
    pub min_side_share: f64,
    /// Share of the points at each end of an axis that are beyond its sides when they are looked for: its heading must not depend on single points. Chosen: one of fifty.
    pub turned_stray_share: f64,
    /// Its confidence: rays tell of the parts that differ, but not whether they are of one thing.
    pub turned_confidence: f64,
    /// Side of the cells of which the cloud of what has not changed has one point each, metres: enough for people to see where they are. Chosen: smaller cells make the
    /// file larger, and larger ones hide the shape of furniture.
    pub unchanged_cell_m: f64,
    /// Points that a normal of a surface needs around it. Chosen: twice the three that a plane needs.
    pub min_normal_points: f64,
}

impl Default for ChangesConfig {
    fn default() -> Self {
        Self {
            alignment: AlignmentConfig::default(),
            same_surface_m: 0.08,
            max_same_surface_m: 0.15,
            same_surface_deviations: 3.0,
            range_noise_m: 0.01,
            resolution_m: 0.01,
            max_range_m: 20.0,
            min_range_m: 0.5,
            cell_rad: [0.007, 0.052],
            density_cell_rad: 0.07,
            sight_cell_rad: 0.03,
            ray_reach_m: 0.12,
            own_ray_reach_m: 0.05,
            free_margin_m: 0.1,
            free_margin_share: 0.01,
            min_free_rays: 2,
            min_free_share: 0.5,
            moving_share: 0.5,
            candidate_cell_m: 0.05,
            enough_views: 16,
            max_asked_points: 100,
            min_views: 2,
            min_rays_of_one_view: 60,
            min_views_if_walking: 3,
            walking_height_m: 0.6,
            min_telling_rays: 10,
            gap_m: 0.3,
            min_points: 20,
            min_points_of_others: 30,
            min_size_m: 0.1,
            edge_margin_m: 0.03,
            min_core_side_m: 0.01,
            stray_share: 0.05,
            min_evidence: 9.2,
            chance_share: 0.02,
            min_chance: 0.01,
            max_same_share: 0.15,
            min_known_share: 0.3,
            large_m: 1.5,
            known_cell_m: 0.1,
            grow_m: 0.3,
            grow_up_m: 0.6,
            grow_rounds: 5,
            stray_growth_share: 0.1,
            ground_clearance_m: 0.08,
            stands_within_m: 0.4,
            ground_reach_m: 1.0,
            ground_depth_m: 1.5,
            ground_bin_m: 0.05,
            min_ground_points: 10,
            min_level_share: 0.4,
            level_reach_m: 0.25,
            box_fit: BoxFitConfig::default(),
            association: AssociationConfig::default(),
            size_likelihood: SizeLikelihoodConfig::default(),
            same_size_m: 0.075,
            turned_reach_m: 1.5,
            turned_gap_m: 0.15,
            turned_size_share: 0.15,
            min_turn_rad: 0.17,
            min_shift_m: 0.1,
            standing_height_m: 1.5,
            standing_clearance_m: 0.05,
            level_share: 0.35,
            turned_first_fit: BoxFitConfig { max_fit_points: 300, headings: 30, ..BoxFitConfig::default() },
            min_turn_evidence_of_point: 0.15,
            min_corner_evidence: 6.9,
            min_side_share: 0.45,
            turned_stray_share: 0.02,
            turned_confidence: 0.9,
            unchanged_cell_m: 0.1,
            min_normal_points: 6.0,
        }
    }
}

/// Parameters of the alignment of two visits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignmentConfig {
    /// One in this number of points is used: of the reference for its surfaces, and of a view for those that are aligned. Chosen: the time grows with the points, and the views of a visit overlap. An earlier program that aligned all
    /// points of a view found 27 of 28 cubes of 0.15 m in the cast visits of docs/benchmarks/changes.md; 26 are found.
    pub point_step: usize,
    /// One point of each cell of this size of a view is aligned, metres. Chosen: surfaces near the robot do not outweigh the others.
    pub sample_cell_m: f64,
    /// How points are matched with surfaces. Chosen: the gate is three deviations of a given position, and the noise that of a LiDAR with the error of a map.
    pub matching: MatchingConfig,
    /// Width of the matching in the first iteration. Chosen as a round number: poses that are wrong by more than three deviations still find their surfaces.
    pub initial_width: f32,
    /// Iterations at most. Chosen: it bounds the time of a view; poses of localisation are nearly right before the first.
    pub max_iterations: usize,
    /// A view of which fewer points lie on surfaces of the reference stays where it is. Chosen as a round number: with fewer, an alignment follows what has changed.
    pub min_inliers: usize,
    /// Standard deviation of the given poses, metres and radians: localisation while walking (docs/benchmarks/localisation.md).
    pub translation_m: f64,
    /// See [`Self::translation_m`].
    pub rotation_rad: f64,
    /// A view that would be moved by more than this number of them stays where it is. Chosen: an alignment that far from a pose of localisation is wrong.
    pub max_deviations: f64,
    /// Number of points that share one error and therefore count as one. Source: as in the verification of loops (docs/maths/loops.md).
    pub correlated_points: f64,
    /// Share of the largest eigenvalue of the information that noise contributes to all: along a corridor, a view stays where it is. Chosen as a round number; more moves views less along corridors.
    pub eigenvalue_shrinkage: f64,
    /// Distance at which rotations are compared with translations, metres. Chosen: most of what a view sees is that far away.
    pub lever_arm_m: f64,
    /// Side of the cells in which the remaining error is measured, metres. Chosen: a cell has surfaces in several directions, and is smaller than a room.
    pub region_m: f64,
    /// A region with fewer points on common surfaces, level or upright ones, has the error of all on such. Chosen: an error of fewer points is uncertain by more than a tenth.
    pub min_region_points: usize,
}

impl Default for AlignmentConfig {
    fn default() -> Self {
        Self {
            point_step: 3,
            sample_cell_m: 0.4,
            matching: MatchingConfig {
                gate_m: 0.15,
                noise_m: 0.02,
                use_distributions: false,
                front_facing_only: true,
                ..MatchingConfig::default()
            },
            initial_width: 2.0,
            max_iterations: 6,
            min_inliers: 200,
            translation_m: 0.05,
            rotation_rad: 0.01,
            max_deviations: 4.0,
            correlated_points: 10.0,
            eigenvalue_shrinkage: 1e-3,
            lever_arm_m: 5.0,
            region_m: 4.0,
            min_region_points: 60,
        }
    }
}

/// Parameters of [`crate::UprightBox::around`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxFitConfig {
    /// A point within this distance of a side of a box is on it, metres: the noise of a LiDAR. Chosen: two standard deviations of 1 cm.
    pub on_side_m: f64,
    /// Share of the points at each end of an axis that a box leaves out, because noise reaches beyond the sides. Chosen as a round number: more cuts into the sides, less
    /// lets single stray points move them.
    pub trimmed_share: f64,
    /// The same for heights: less, because a LiDAR sees few points of the upper end of a thing. Source: set after seeds 11 to 30 of docs/benchmarks/changes.md were
    /// looked at.
    pub trimmed_height_share: f64,
    /// Points that the fit of a box uses at most; more do not make it better. Chosen: the time of the fit is this number times [`Self::headings`].
    pub max_fit_points: usize,
    /// Headings that are tried over a quarter turn, after which the sides of a box look the same: one degree each. Finer ones are below the noise of the points. Chosen:
    /// the time of the fit is in proportion to it.
    pub headings: usize,
}

impl Default for BoxFitConfig {
    fn default() -> Self {
        Self {
            on_side_m: 0.02,
            trimmed_share: 0.01,
            trimmed_height_share: 0.002,
            max_fit_points: 2_000,
            headings: 90,
        }
    }
}
