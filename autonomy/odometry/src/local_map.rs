//! The local map around the robot and the registration of a scan with it.

use crate::event::RegistrationReport;
use crate::filter::ErrorStateFilter;
use crate::plane_thickness::{PlaneThickness, PlaneThicknessConfig};
use crate::state::State;
use geometry::{Base, Body, Isometry, Lidar, Matrix6, Transform, Vector3, Vector6};
use nalgebra::Point3;
use points::{AdaptiveVoxelConfig, Centroid, Downsampler, GaussianMap, GaussianMapConfig};
use registration::{
    GaussNewtonConfig, MatchingConfig, NormalEquations, ScanInformationConfig, WidthSchedule, gauss_newton,
    linearise_from_viewpoint, shrink_eigenvalues,
};

/// Parameters of a [`LocalMap`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalMapConfig {
    /// How the map divides space. Planes are at most as thick as it says, and thinner if the LiDAR allows it.
    pub gaussians: GaussianMapConfig,
    /// How thick planes may be.
    pub plane_thickness: PlaneThicknessConfig,
    /// Root cubes farther from the robot than this along any axis are removed, metres. Chosen as a round number: memory grows with its square, and surfaces farther away
    /// are forgotten.
    pub radius_m: f64,
    /// Distance walked between two removals, metres. Chosen: a tenth of [`Self::radius_m`]; each removal visits all cubes.
    pub removal_interval_m: f64,
    /// How points are matched when the pose is nearly right. Surfaces have sides: without them, the upper and the lower face of a stair's tread are
    /// one plane, and the robot that has seen its lower face first ends its climb too low, by up to half a tread's thickness.
    pub matching: MatchingConfig,
    /// Limits on the information of a scan.
    pub information: ScanInformationConfig,
    /// Iteration from a prediction that is good to centimetres. The prior takes the place of damping.
    pub tight: GaussNewtonConfig,
    /// Iteration from a prediction that is good to decimetres. The prior takes the place of damping. Chosen: 8 times the gate of 0.1 m reaches 0.8 m.
    pub loose: GaussNewtonConfig,
    /// Number of points of a scan that are to enter registration. The voxel size adapts to it. Chosen: the time of a scan is in proportion to it;
    /// docs/benchmarks/odometry.md has time and error.
    pub target_points: usize,
    /// How the voxel size adapts to that number from scan to scan.
    pub voxel: AdaptiveVoxelConfig,
    /// Voxel size of the points that enter the map, as a share of that of the points that enter registration. Chosen: half, so that planes of the map have four times as
    /// many points.
    pub fine_voxel_share: f32,
    /// Exponent of the adaptation of the voxel size while the map is empty, in place of that of `voxel`. Chosen twice that, because there is no scan to come that could
    /// correct it, and a few adaptations have to suffice.
    pub initial_adaptation_exponent: f32,
    /// Greatest number of adaptations for the first scan. Chosen: it bounds the time of the first scan.
    pub initial_adaptations: usize,
    /// Least ratio of the number of points to the target that ends the adaptation for the first scan. Chosen: a fifth fewer points change neither time nor accuracy much.
    pub min_target_ratio: f32,
    /// Ratio of the number of points to the target, from which the adaptation for the first scan goes on. Chosen: the inverse of [`Self::min_target_ratio`].
    pub max_target_ratio: f32,
}

impl Default for LocalMapConfig {
    fn default() -> Self {
        let tight = GaussNewtonConfig {
            max_iterations: 10,
            min_step: 2e-5,
            initial_width: 2.0,
            schedule: WidthSchedule::Halving,
            relative_damping: 0.0,
            absolute_damping: 0.0,
        };
        Self {
            gaussians: GaussianMapConfig::default(),
            plane_thickness: PlaneThicknessConfig::default(),
            radius_m: 100.0,
            removal_interval_m: 10.0,
            matching: MatchingConfig { front_facing_only: true, ..MatchingConfig::default() },
            information: ScanInformationConfig::default(),
            tight,
            loose: GaussNewtonConfig { max_iterations: 20, initial_width: 8.0, ..tight },
            target_points: 4_000,
            voxel: AdaptiveVoxelConfig::default(),
            fine_voxel_share: 0.5,
            initial_adaptation_exponent: 0.6,
            initial_adaptations: 6,
            min_target_ratio: 0.8,
            max_target_ratio: 1.25,
        }
    }
}

/// Quality of the predicted pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PriorQuality {
    /// Good to centimetres.
    Tight,
    /// Good to decimetres.
    Loose,
}

/// Result of registering a scan.
#[derive(Clone, Copy, Debug)]
pub struct ScanFit {
    /// The most probable state.
    pub state: State,
    /// Information of the scan about the pose there, `[rotation; translation]`.
    pub information: Matrix6,
    /// Standard deviation of the points about planes of the map, metres; none without planes.
    pub plane_deviation_m: Option<f64>,
    /// Figures for the pose event.
    pub report: RegistrationReport,
}

/// A downsampled scan, body frame, metres.
#[derive(Clone, Debug, Default)]
pub struct DownsampledPoints {
    /// Points for registration.
    pub coarse: Vec<[f32; 3]>,
    /// Points for the map.
    pub fine: Vec<[f32; 3]>,
    /// Position of the LiDAR, from which they were seen.
    pub viewpoint: Vector3,
}

/// The local map around the robot.
#[derive(Clone, Debug)]
pub struct LocalMap {
    config: LocalMapConfig,
    map: GaussianMap,
    plane_thickness: PlaneThickness,
    downsampler: Downsampler,
    centroids: Vec<Centroid>,
    /// Present voxel size of the downsampling, metres.
    voxel_m: f32,
    /// Position of the robot at the last removal of distant cubes, odom frame, metres.
    removed_at: Option<Vector3>,
}

impl LocalMap {
    /// An empty map.
    pub fn new(config: LocalMapConfig) -> Self {
        Self {
            config,
            map: GaussianMap::new(config.gaussians),
            plane_thickness: PlaneThickness::default(),
            downsampler: Downsampler::default(),
            centroids: Vec::new(),
            voxel_m: config.voxel.initial_m,
            removed_at: None,
        }
    }

    /// The Gaussians of the map.
    pub fn gaussians(&self) -> &GaussianMap {
        &self.map
    }

    /// The parameters of the map.
    pub fn config(&self) -> &LocalMapConfig {
        &self.config
    }

    /// Downsamples a scan (base frame, metres) into `out` (body frame), and adapts the voxel size so that about `target_points`
    /// points remain next time. `base_from_lidar` is where it was seen from.
    pub fn downsample(
        &mut self,
        xyz: &[[f32; 3]],
        target_points: usize,
        body_from_base: &Transform<Body, Base>,
        base_from_lidar: &Transform<Base, Lidar>,
        out: &mut DownsampledPoints,
    ) {
        let config = self.config;
        let is_first = self.map.is_empty();
        let (attempts, adaptation) = if is_first {
            let exponent = config.initial_adaptation_exponent;
            (config.initial_adaptations, AdaptiveVoxelConfig { exponent, ..config.voxel })
        } else {
            (1, config.voxel)
        };
        for _ in 0..attempts {
            self.downsample_once(xyz, out);
            // A scan with very few points does not predict the number of points of the next one.
            if xyz.len() < config.information.min_points {
                break;
            }
            let ratio = out.coarse.len() as f32 / target_points as f32;
            self.voxel_m = adaptation.adapt(self.voxel_m, ratio);
            if (config.min_target_ratio..config.max_target_ratio).contains(&ratio) {
                break;
            }
        }
        out.viewpoint = (*body_from_base * *base_from_lidar).isometry().translation.vector;
        let matrix = crate::sweep::matrix_of(body_from_base.isometry());
        for point in out.coarse.iter_mut().chain(&mut out.fine) {
            *point = crate::sweep::apply(&matrix, point);
        }
    }

    fn downsample_once(&mut self, xyz: &[[f32; 3]], out: &mut DownsampledPoints) {
        self.centroids.clear();
        let fine_voxel_m = self.voxel_m * self.config.fine_voxel_share;
        self.downsampler.downsample(xyz, &[], fine_voxel_m, &mut self.centroids);
        out.fine.clear();
        out.fine.extend(self.centroids.iter().map(|centroid| centroid.xyz));
        self.centroids.clear();
        self.downsampler.downsample(&out.fine, &[], self.voxel_m, &mut self.centroids);
        out.coarse.clear();
        out.coarse.extend(self.centroids.iter().map(|centroid| centroid.xyz));
    }

    /// Finds the most probable state given a scan and the prior (docs/maths/odometry.md, equations 14 and 15), starting from
    /// `start`.
    pub fn fit(
        &self,
        filter: &ErrorStateFilter,
        start: State,
        scan: &DownsampledPoints,
        prior_quality: PriorQuality,
    ) -> ScanFit {
        let mut report = RegistrationReport {
            points_used: scan.coarse.len(),
            voxel_m: self.voxel_m,
            ..RegistrationReport::default()
        };
        let (mut information, mut plane_deviation_m) = (Matrix6::zeros(), None);
        let config = match prior_quality {
            PriorQuality::Tight => &self.config.tight,
            PriorQuality::Loose => &self.config.loose,
        };
        let state = gauss_newton(start, &self.matching(), config, |state, matching| {
            let equations = linearise_from_viewpoint(
                &self.map,
                &scan.coarse,
                &state.odom_from_body,
                &scan.viewpoint,
                matching,
            );
            let gradient;
            (information, gradient) = self.trusted_part(&equations, scan);
            plane_deviation_m = equations.plane_deviation_m();
            report.matched = equations.matched;
            report.inlier_share = equations.inliers as f64 / equations.matched.max(1) as f64;
            report.iterations += 1;
            let deviation = filter.compute_pose_step(state, &information, &gradient)?;
            let next = filter.state.retract(&deviation);
            let step = geometry::se3::local(&state.odom_from_body, &next.odom_from_body).norm();
            Some((next, step))
        });
        ScanFit { state, information, plane_deviation_m, report }
    }

    /// How points are matched at the present voxel size. A leaf of the map holds up to `(leaf / voxel)²` points of a surface, and where it is not flat they
    /// count as one (docs/maths/odometry.md, equation 11).
    fn matching(&self) -> MatchingConfig {
        let voxels_per_leaf = self.config.gaussians.leaf_size_m() / f64::from(self.voxel_m);
        MatchingConfig { distribution_share: voxels_per_leaf.powi(-2).min(1.0), ..self.config.matching }
    }

    /// Information and gradient without what only noise contributes, and with correlated points counted as one.
    fn trusted_part(&self, equations: &NormalEquations, scan: &DownsampledPoints) -> (Matrix6, Vector6) {
        let config = &self.config.information;
        let squares: f64 = scan.coarse.iter().map(|p| f64::from(points::filter::norm_squared(p))).sum();
        let lever_arm_m = (squares / scan.coarse.len().max(1) as f64).sqrt().max(config.min_lever_arm_m);
        let shrunk = shrink_eigenvalues(
            &equations.information,
            &equations.gradient,
            lever_arm_m,
            config.eigenvalue_shrinkage,
        );
        let scale = 1.0 / config.correlated_points;
        (shrunk.information * scale, shrunk.gradient * scale)
    }

    /// Adapts the thickness of planes to a scan that fitted the map, whose points have this standard deviation about planes, metres.
    pub fn adapt_plane_thickness(&mut self, deviation_m: f64) {
        let (max_m, config) = (self.config.gaussians.plane_thickness_m, &self.config.plane_thickness);
        self.map.set_plane_thickness(self.plane_thickness.update(deviation_m, max_m, config));
    }

    /// Adds the fine points of a scan at a pose.
    pub fn insert(&mut self, scan: &DownsampledPoints, odom_from_body: &Isometry) {
        let rotation = odom_from_body.rotation.to_rotation_matrix();
        let translation = odom_from_body.translation.vector;
        let viewpoint = (odom_from_body * Point3::from(scan.viewpoint)).coords;
        for point in &scan.fine {
            let in_body = Vector3::new(f64::from(point[0]), f64::from(point[1]), f64::from(point[2]));
            let in_odom = rotation * in_body + translation;
            self.map.insert_from_viewpoint(in_odom.as_ref(), viewpoint.as_ref());
        }
        self.remove_distant(&translation);
    }

    /// Removes distant cubes, once in every removal interval of distance.
    fn remove_distant(&mut self, position: &Vector3) {
        let interval_m = self.config.removal_interval_m;
        if self.removed_at.is_none_or(|last| (position - last).norm() > interval_m) {
            self.removed_at = Some(*position);
            self.map.retain_within(&[position.x, position.y, position.z], self.config.radius_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::FilterConfig;
    use crate::state::ErrorVector;
    use geometry::RngTree;
    use points::Surface;

    #[test]
    fn points_that_share_a_cell_which_is_not_flat_count_as_one() {
        let mut map = LocalMap::new(LocalMapConfig::default());
        let leaf_m = map.config.gaussians.leaf_size_m();
        assert_eq!(leaf_m, 0.25);
        for (voxel_m, points) in
            [(leaf_m / 4.0, 16.0), (leaf_m / 2.0, 4.0), (leaf_m, 1.0), (2.0 * leaf_m, 1.0)]
        {
            map.voxel_m = voxel_m as f32;
            assert_eq!(map.matching().distribution_share, 1.0 / points, "{voxel_m}");
        }
    }

    /// A floor and the lower part of a wall, seen from 2 m away with a noise of 5 mm along each ray, body frame.
    fn corner(seed: u64) -> DownsampledPoints {
        let mut rng = RngTree::new(seed).child("corner").rng();
        let viewpoint = Vector3::new(0.0, 0.0, 0.6);
        let mut seen = |place: Vector3| {
            let ray = place - viewpoint;
            (place + ray.normalize() * (0.005 * rng.normal())).map(|at| at as f32).into()
        };
        let grid = |count: i32, step: f64| (0..count).map(move |index| f64::from(index) * step);
        let floor =
            grid(60, 0.05).flat_map(|x| grid(80, 0.05).map(move |y| Vector3::new(x - 1.0, y - 2.0, 0.0)));
        let wall = grid(40, 0.05).flat_map(|z| grid(80, 0.05).map(move |y| Vector3::new(2.0, y - 2.0, z)));
        let mut points: Vec<[f32; 3]> = floor.chain(wall).map(&mut seen).collect();
        // A LiDAR sees floor and wall in turn.
        points.sort_by_cached_key(|_| rng.bits());
        DownsampledPoints { coarse: points.clone(), fine: points, viewpoint }
    }

    /// Mean tilt of the floor's planes near the wall after some scans, radians, and the thickness that planes may have, metres.
    fn tilt_of_floor(config: LocalMapConfig) -> (f64, f32) {
        let start = State::at(Isometry::identity());
        let filter = ErrorStateFilter::new(FilterConfig::default(), start, &ErrorVector::repeat(1e-3));
        let mut map = LocalMap::new(config);
        for seed in 0..10 {
            let scan = corner(seed);
            if seed > 0 {
                let fit = map.fit(&filter, start, &scan, PriorQuality::Tight);
                map.adapt_plane_thickness(fit.plane_deviation_m.expect("there are planes"));
            }
            map.insert(&scan, &Isometry::identity());
        }
        let tilts = (0..80).filter_map(|index| {
            let place = [1.9, f64::from(index) * 0.05 - 2.0, 0.0];
            match map.map.find_surface_facing(&place, &[0.0, 0.0, 0.6], 0.1) {
                Some(Surface::Plane { normal, .. }) if normal[2] > 0.7 => Some(f64::from(normal[2]).acos()),
                _ => None,
            }
        });
        let tilts: Vec<f64> = tilts.collect();
        assert!(tilts.len() > 40, "{}", tilts.len());
        (tilts.iter().sum::<f64>() / tilts.len() as f64, map.map.config().plane_thickness_m)
    }

    #[test]
    fn the_foot_of_a_wall_does_not_tilt_the_floor_of_a_lidar_with_little_noise() {
        let (tilt_rad, thickness_m) = tilt_of_floor(LocalMapConfig::default());
        let fixed = PlaneThicknessConfig { min_m: f64::INFINITY, ..PlaneThicknessConfig::default() };
        let (thick_rad, most_m) =
            tilt_of_floor(LocalMapConfig { plane_thickness: fixed, ..LocalMapConfig::default() });
        assert!((0.01..0.02).contains(&thickness_m) && most_m == 0.03, "{thickness_m} {most_m}");
        assert!(tilt_rad < 0.5 * thick_rad, "{tilt_rad} {thick_rad}");
    }
}
