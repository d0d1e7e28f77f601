//! The command `compare`: reads two trajectories, pairs their poses, aligns and compares them.

use super::align::TrajectoryAlignment;
use super::extrinsic::{Extrinsic, parse_frame};
use super::load::load;
use super::pairs::{Matching, Pair, pair};
use crate::failure::Failure;
use crate::{output, summaries, texts};
use clap::Args;
use geometry::{Isometry, Similarity, umeyama};
use serde::Serialize;
use std::path::PathBuf;
use vocab::Span;

/// Compare an estimated trajectory with the ground truth.
#[derive(Args, Debug)]
#[command(after_help = "EXAMPLES:
  autoinspect trajectory compare truth.tum m/trajectory.tum
  autoinspect trajectory compare b1.mcap m/trajectory.tum --json
  autoinspect trajectory compare poses.txt m/trajectory.tum        KITTI poses, times.txt beside them
  autoinspect trajectory compare mocap_imu.tum m/trajectory.tum --extrinsic lidar_imu.json")]
pub struct CompareArgs {
    /// The truth: a TUM file, a KITTI file of poses, or a recording with a topic of ground truth.
    truth: PathBuf,
    /// The estimate: a TUM file.
    estimate: PathBuf,
    /// Seconds added to the estimate's stamps to get the truth's [default: the extrinsic file's, else 0].
    #[arg(long, allow_hyphen_values = true)]
    offset: Option<f64>,
    /// Alignment of the estimate with the truth before they are compared.
    #[arg(long, value_enum, default_value_t = TrajectoryAlignment::Se3)]
    align: TrajectoryAlignment,
    /// Matching of instants.
    #[arg(long = "match", value_enum, default_value_t = Matching::Interpolate)]
    matching: Matching,
    /// Longest gap in the truth that is interpolated, or greatest difference of nearest stamps, seconds
    /// [default: 0.5 and 0.01].
    #[arg(long)]
    max_gap: Option<f64>,
    /// Compare at this frame, given in the estimated one: X,Y,Z,QX,QY,QZ,QW.
    #[arg(long, allow_hyphen_values = true, conflicts_with = "extrinsic")]
    at_frame: Option<String>,
    /// Compare at the IMU of this calibration file (JSON with T_lidar_imu and perhaps time_offset_s).
    #[arg(long)]
    extrinsic: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Statistics of a set of errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorStatistics {
    pub rmse: f64,
    pub mean: f64,
    pub median: f64,
    pub max: f64,
}

/// The result of a comparison.
#[derive(Clone, Debug, Serialize)]
pub struct TrajectoryComparison {
    /// Number of compared poses.
    pub pairs: usize,
    /// Number of poses of the estimate.
    pub estimate_poses: usize,
    /// Path length of the truth over the pairs, metres.
    pub truth_length_m: f64,
    /// Path length of the estimate over the pairs, metres.
    pub estimate_length_m: f64,
    /// Absolute error of positions, metres.
    pub ape_m: ErrorStatistics,
    /// Absolute error of positions along z, metres.
    pub ape_vertical_m: ErrorStatistics,
    /// Absolute error of orientations, degrees.
    pub ape_deg: ErrorStatistics,
    /// Relative error: of the motion from each pair to the next, metres.
    pub rpe_m: ErrorStatistics,
    /// Relative error of the rotation, degrees.
    pub rpe_deg: ErrorStatistics,
    /// Distance between the last positions, metres.
    pub end_m: f64,
    /// Scale that was applied.
    pub scale: f64,
}

/// Runs `autoinspect trajectory compare`.
pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    let comparison = compare(args)?;
    output::print_human(args.json, &describe(&comparison));
    output::print_json(args.json, &comparison)
}

fn compare(args: &CompareArgs) -> Result<TrajectoryComparison, Failure> {
    let extrinsic = args.extrinsic.as_deref().map(Extrinsic::read).transpose()?;
    let frame = match (&args.at_frame, &extrinsic) {
        (Some(text), _) => parse_frame(text)?,
        (None, Some(extrinsic)) => extrinsic.estimated_from_known()?,
        (None, None) => Isometry::identity(),
    };
    let offset = args.offset.or(extrinsic.and_then(|extrinsic| extrinsic.time_offset_s)).unwrap_or(0.0);
    let max_gap = args.max_gap.unwrap_or(match args.matching {
        Matching::Interpolate => 0.5,
        Matching::Nearest => 0.01,
    });
    let truth = load(&args.truth)?;
    let estimate: Vec<_> =
        load(&args.estimate)?.into_iter().map(|(stamp, pose)| (stamp, pose * frame)).collect();
    let seconds = Span::from_secs_f64;
    let pairs = pair(&truth, &estimate, seconds(offset), args.matching, seconds(max_gap));
    if pairs.len() < 2 {
        return Err(Failure::usage(texts::too_few_common_instants(pairs.len())));
    }
    let similarity = align(&pairs, args.align)?;
    Ok(TrajectoryComparison { estimate_poses: estimate.len(), ..measure(&pairs, &similarity) })
}

fn align(pairs: &[Pair], alignment: TrajectoryAlignment) -> Result<Similarity, Failure> {
    let positions = || {
        pairs
            .iter()
            .map(|pair| (pair.truth.translation.vector, pair.estimate.translation.vector))
            .collect::<Vec<_>>()
    };
    let found = match alignment {
        TrajectoryAlignment::None => Some(Similarity::identity()),
        TrajectoryAlignment::First => {
            Some(Similarity { scale: 1.0, truth_from_estimate: pairs[0].truth * pairs[0].estimate.inverse() })
        }
        TrajectoryAlignment::Se3 => umeyama(&positions(), false),
        TrajectoryAlignment::Sim3 => umeyama(&positions(), true),
    };
    found.ok_or_else(|| Failure::usage(texts::COLLINEAR_POSITIONS))
}

fn measure(pairs: &[Pair], similarity: &Similarity) -> TrajectoryComparison {
    let aligned: Vec<Pair> =
        pairs.iter().map(|pair| Pair { estimate: similarity.apply(&pair.estimate), ..*pair }).collect();
    let absolute: Vec<Isometry> = aligned.iter().map(|pair| pair.truth.inv_mul(&pair.estimate)).collect();
    let offsets: Vec<_> =
        aligned.iter().map(|pair| pair.estimate.translation.vector - pair.truth.translation.vector).collect();
    let relative: Vec<Isometry> = aligned
        .windows(2)
        .map(|two| two[0].truth.inv_mul(&two[1].truth).inv_mul(&two[0].estimate.inv_mul(&two[1].estimate)))
        .collect();
    let length = |pick: fn(&Pair) -> &Isometry| -> f64 {
        let step =
            |two: &[Pair]| (pick(&two[1]).translation.vector - pick(&two[0]).translation.vector).norm();
        aligned.windows(2).map(step).sum()
    };
    let metres = |errors: &[Isometry]| figures(errors.iter().map(|error| error.translation.vector.norm()));
    let degrees =
        |errors: &[Isometry]| figures(errors.iter().map(|error| error.rotation.angle().to_degrees()));
    TrajectoryComparison {
        pairs: pairs.len(),
        estimate_poses: pairs.len(),
        truth_length_m: length(|pair| &pair.truth),
        estimate_length_m: length(|pair| &pair.estimate),
        ape_m: metres(&absolute),
        ape_vertical_m: figures(offsets.iter().map(|offset| offset.z.abs())),
        ape_deg: degrees(&absolute),
        rpe_m: metres(&relative),
        rpe_deg: degrees(&relative),
        end_m: offsets.last().map_or(0.0, |offset| offset.norm()),
        scale: similarity.scale,
    }
}

/// Statistics of errors; zeros without errors.
fn figures(errors: impl Iterator<Item = f64>) -> ErrorStatistics {
    let mut errors: Vec<f64> = errors.collect();
    errors.sort_by(f64::total_cmp);
    let (count, middle) = (errors.len().max(1) as f64, errors.len() / 2);
    let median = match errors.len() {
        0 => 0.0,
        length if length % 2 == 1 => errors[middle],
        _ => 0.5 * (errors[middle - 1] + errors[middle]),
    };
    ErrorStatistics {
        rmse: (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt(),
        mean: errors.iter().sum::<f64>() / count,
        median,
        max: errors.last().copied().unwrap_or(0.0),
    }
}

fn describe(comparison: &TrajectoryComparison) -> String {
    let line = |name: &str, unit: &str, figures: &ErrorStatistics| {
        let ErrorStatistics { rmse, mean, median, max } = *figures;
        summaries::trajectory_error(name, unit, rmse, mean, median, max)
    };
    [
        summaries::compared(
            comparison.pairs,
            comparison.estimate_poses,
            comparison.truth_length_m,
            comparison.estimate_length_m,
            comparison.scale,
        ),
        line(summaries::ABSOLUTE_POSITION, "m", &comparison.ape_m),
        line(summaries::ABSOLUTE_VERTICAL, "m", &comparison.ape_vertical_m),
        line(summaries::ABSOLUTE_ORIENTATION, "deg", &comparison.ape_deg),
        line(summaries::POSE_TO_POSE, "m", &comparison.rpe_m),
        line(summaries::POSE_TO_POSE, "deg", &comparison.rpe_deg),
        summaries::error_at_end(comparison.end_m),
    ]
    .join("\n")
}

#[cfg(test)]
#[path = "compare_tests.rs"]
mod tests;
