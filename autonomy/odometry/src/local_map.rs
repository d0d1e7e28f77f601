//! The map around the robot, and where a scan lies in it.

use crate::config::OdometryConfig;
use crate::event::RegistrationReport;
use crate::filter::ErrorStateFilter;
use crate::state::State;
use geometry::{Isometry, Matrix6, Vector3, Vector6};
use points::{Centroid, Downsampler, GaussianMap};
use registration::{MatchingConfig, NormalEquations, linearise, shrink_eigenvalues};

/// Fewer points than this say nothing.
pub const MIN_POINTS: usize = 60;
/// Gauss-Newton steps at most.
const MAX_ITERATIONS: usize = 10;
/// A step this small ends the iteration: metres and radians.
const RESTING: f64 = 2e-5;
/// Share of the strongest direction's information that noise alone can fake in a blind one.
const APPARENT_GRIP: f64 = 1e-3;
/// A plane this near is taken without looking further, metres.
const GATE: f32 = 0.1;
/// Width of the robust kernel, standard deviations.
const KERNEL: f32 = 3.0;

/// How good the predicted pose is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PriorQuality {
    /// To centimetres.
    Close,
    /// To decimetres.
    Loose,
}

/// Result of fitting a scan.
#[derive(Clone, Copy, Debug)]
pub struct ScanFit {
    /// Best state.
    pub state: State,
    /// What the scan says about the pose there.
    pub information: Matrix6,
    /// For people.
    pub report: RegistrationReport,
}

/// A thinned scan: for registration, and finer for the map.
#[derive(Clone, Debug, Default)]
pub struct DownsampledScan {
    /// Body frame, metres.
    pub coarse: Vec<[f32; 3]>,
    /// Body frame, metres.
    pub fine: Vec<[f32; 3]>,
}

/// The map around the robot.
#[derive(Clone, Debug)]
pub struct LocalMap {
    map: GaussianMap,
    downsampler: Downsampler,
    centroids: Vec<Centroid>,
    /// Edge of the voxels that thin a scan, metres.
    voxel: f32,
    noise: f32,
    correlation: f64,
    radius: f64,
    /// Where parts far away were last forgotten.
    forgotten_at: Option<Vector3>,
}

impl LocalMap {
    /// An empty one.
    pub fn new(config: &OdometryConfig) -> Self {
        Self {
            map: GaussianMap::new(config.map),
            downsampler: Downsampler::default(),
            centroids: Vec::new(),
            voxel: 0.3,
            noise: config.noise.lidar as f32,
            correlation: config.noise.lidar_correlation,
            radius: config.map_radius,
            forgotten_at: None,
        }
    }

    /// The Gaussians.
    pub fn gaussians(&self) -> &GaussianMap {
        &self.map
    }

    /// How points are matched once the pose is nearly right.
    pub fn matching(&self) -> MatchingConfig {
        MatchingConfig {
            gate_m: GATE,
            kernel_width: KERNEL,
            noise_m: self.noise,
            use_distributions: true,
            front_facing_only: false,
        }
    }

    /// Thins a scan (base frame) and turns it into the body frame; adapts the voxel size
    /// so that about `wanted` points remain next time.
    pub fn downsample(
        &mut self,
        xyz: &[[f32; 3]],
        wanted: usize,
        body_from_base: &Isometry,
        out: &mut DownsampledScan,
    ) {
        let first = self.map.is_empty();
        for _ in 0..if first { 6 } else { 1 } {
            self.downsample_once(xyz, out);
            // A blind scan says nothing about the next one.
            if xyz.len() < MIN_POINTS {
                break;
            }
            let ratio = out.coarse.len() as f32 / wanted as f32;
            // Points on surfaces: halving the edge quadruples them, less where they are sparse.
            self.voxel = (self.voxel * ratio.powf(if first { 0.6 } else { 0.3 })).clamp(0.05, 2.0);
            if (0.8..1.25).contains(&ratio) {
                break;
            }
        }
        let matrix = crate::sweep::matrix_of(body_from_base);
        for point in out.coarse.iter_mut().chain(&mut out.fine) {
            *point = crate::sweep::apply(&matrix, point);
        }
    }

    fn downsample_once(&mut self, xyz: &[[f32; 3]], out: &mut DownsampledScan) {
        self.centroids.clear();
        self.downsampler.downsample(xyz, &[], self.voxel * 0.5, &mut self.centroids);
        out.fine.clear();
        out.fine.extend(self.centroids.iter().map(|centroid| centroid.xyz));
        self.centroids.clear();
        self.downsampler.downsample(&out.fine, &[], self.voxel, &mut self.centroids);
        out.coarse.clear();
        out.coarse.extend(self.centroids.iter().map(|centroid| centroid.xyz));
    }

    /// Finds the state that a scan and the prior agree on. `start` is where to begin.
    pub fn fit(
        &self,
        filter: &ErrorStateFilter,
        start: State,
        downsampled: &DownsampledScan,
        prior_quality: PriorQuality,
    ) -> ScanFit {
        let mut state = start;
        let mut report = RegistrationReport {
            points_used: downsampled.coarse.len(),
            voxel: self.voxel,
            ..RegistrationReport::default()
        };
        let mut information = Matrix6::zeros();
        let mut widen: f32 = match prior_quality {
            PriorQuality::Close => 2.0,
            PriorQuality::Loose => 8.0,
        };
        let iterations = match prior_quality {
            PriorQuality::Close => MAX_ITERATIONS,
            PriorQuality::Loose => 2 * MAX_ITERATIONS,
        };
        for _ in 0..iterations {
            let options =
                MatchingConfig { gate_m: GATE * widen, kernel_width: KERNEL * widen, ..self.matching() };
            let at = linearise(&self.map, &downsampled.coarse, &state.odom_from_body, &options);
            let (share, gradient);
            (share, information, gradient) = self.regularise(&at, downsampled);
            report.matched = at.matched;
            report.inlier_share = share;
            report.iterations += 1;
            let Some(deviation) = filter.compute_pose_step(&state, &information, &gradient) else { break };
            let next = filter.state.retract(&deviation);
            let moved = geometry::se3::local(&state.odom_from_body, &next.odom_from_body).norm();
            state = next;
            let wide = widen > 1.0;
            widen = (widen * 0.5).max(1.0);
            if moved < RESTING && !wide {
                break;
            }
        }
        ScanFit { state, information, report }
    }

    /// Share of inliers, and normal equations with the noise's grip taken off and neighbours' common errors counted.
    fn regularise(&self, at: &NormalEquations, downsampled: &DownsampledScan) -> (f64, Matrix6, Vector6) {
        let squares: f64 =
            downsampled.coarse.iter().map(|p| f64::from(points::filter::norm_squared(p))).sum();
        let arm = (squares / downsampled.coarse.len().max(1) as f64).sqrt().max(0.5);
        let conditioned = shrink_eigenvalues(&at.information, &at.gradient, arm, APPARENT_GRIP);
        let scale = 1.0 / self.correlation;
        let share = at.inliers as f64 / at.matched.max(1) as f64;
        (share, conditioned.information * scale, conditioned.gradient * scale)
    }

    /// Adds a thinned scan at a pose.
    pub fn insert(&mut self, downsampled: &DownsampledScan, odom_from_body: &Isometry) {
        let rotation = odom_from_body.rotation.to_rotation_matrix();
        let translation = odom_from_body.translation.vector;
        for point in &downsampled.fine {
            let in_body = Vector3::new(f64::from(point[0]), f64::from(point[1]), f64::from(point[2]));
            let in_odom = rotation * in_body + translation;
            self.map.insert(&[in_odom.x, in_odom.y, in_odom.z]);
        }
        self.discard_far(&translation);
    }

    /// Every 10 m, forgets what is out of reach.
    fn discard_far(&mut self, position: &Vector3) {
        let due = self.forgotten_at.is_none_or(|last| (position - last).norm() > 10.0);
        if due {
            self.forgotten_at = Some(*position);
            self.map.retain_within(&[position.x, position.y, position.z], self.radius);
        }
    }
}
