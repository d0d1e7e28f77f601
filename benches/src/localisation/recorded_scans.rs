//! Recorded scans with known poses: the even ones make the map, and the odd ones are localised in it, each on its own.

use anyhow::{Context, Result};
use benches::{POSITION_TOLERANCE_M, ROTATION_TOLERANCE_RAD, thread_ms};
use geometry::{Isometry, Rng, RngTree, Rotation, Vector3, so3};
use localisation::{
    AcceptanceConfig, GlobalLocaliser, LocalisationMap, PoseHypothesis, RelocalisationResult,
};
use mapping::KeyframeDescriptor;
use nalgebra::{Matrix3, Rotation3, Translation3};
use std::path::Path;
use std::sync::Arc;

/// Greatest horizontal error of a pose prior, metres.
const PRIOR_POSITION_ERROR_M: f64 = 1.0;
/// Greatest heading error of a pose prior, radians.
const PRIOR_HEADING_ERROR_RAD: f64 = 0.35;
/// Number of pose priors for each scan.
const PRIORS_PER_SCAN: usize = 5;

/// Counts of the results.
#[derive(Default)]
struct Outcome {
    /// Numbers of right and wrong poses that were accepted from one scan.
    accepted: [usize; 2],
    /// Numbers of right and wrong poses of low confidence: the best hypothesis does not fit well, but no other fits nearly as well. The robot
    /// accepts it with a pose prior, or once further scans confirm it.
    low_confidence: [usize; 2],
    ambiguous: usize,
    nowhere: usize,
    /// Errors of the right poses, metres and radians.
    errors: Vec<(f64, f64)>,
    times: Vec<f64>,
}

/// Localises the odd scans of a folder with `Scans/*.pcd` and `optimized_poses.txt` in a map of the even ones, without and with a pose prior.
pub fn run(folder: &Path) -> Result<()> {
    let scans = read(folder)?;
    let sensor = [0.0; 3];
    let of = |(pose, xyz): &(Isometry, Vec<[f32; 3]>)| {
        (*pose, KeyframeDescriptor::of_cloud(xyz, &pose.rotation, sensor))
    };
    let map = Arc::new(LocalisationMap::new(scans.iter().step_by(2).map(of).collect()));
    let localiser = GlobalLocaliser::new(map);
    localiser.prepare_search();
    let mut rng = RngTree::new(1).child("told").rng();
    let (mut global, mut with_prior) = (Outcome::default(), Outcome::default());
    for (truth, place) in scans.iter().skip(1).step_by(2).map(of) {
        let before = thread_ms();
        let found = localiser.find_poses(&place, &truth.rotation, None);
        global.count(&found, &truth, thread_ms() - before);
        for _ in 0..PRIORS_PER_SCAN {
            let prior = draw_prior(&truth, &mut rng);
            let before = thread_ms();
            let found = localiser.find_poses_near(&place, &[prior]);
            with_prior.count(&found, &truth, thread_ms() - before);
        }
    }
    println!(
        "{:<10}{:>8}{:>8}{:>8}{:>13}{:>13}{:>11}{:>9}{:>9}{:>10}{:>9}{:>11}",
        "prior",
        "scans",
        "right",
        "WRONG",
        "low, right",
        "low, WRONG",
        "ambiguous",
        "nowhere",
        "RMSE m",
        "worst m",
        "degrees",
        "median ms"
    );
    global.print("none");
    with_prior.print("1 m, 20°");
    Ok(())
}

impl Outcome {
    fn count(&mut self, found: &[PoseHypothesis], truth: &Isometry, ms: f64) {
        self.times.push(ms);
        let (one, places) = match AcceptanceConfig::default().classify(found) {
            RelocalisationResult::Unique(one) => (one, &mut self.accepted),
            RelocalisationResult::LowConfidence(one) => (one, &mut self.low_confidence),
            RelocalisationResult::Ambiguous(_) => {
                self.ambiguous += 1;
                return;
            }
            RelocalisationResult::NotFound => {
                self.nowhere += 1;
                return;
            }
        };
        let off = truth.inverse() * one.map_from_base;
        let error = (off.translation.vector.norm(), so3::log(&off.rotation).norm());
        let right = error.0 <= POSITION_TOLERANCE_M && error.1 <= ROTATION_TOLERANCE_RAD;
        places[usize::from(!right)] += 1;
        if right {
            self.errors.push(error);
        }
    }

    fn print(mut self, prior: &str) {
        let mean = |of: fn(&(f64, f64)) -> f64| {
            let squares: f64 = self.errors.iter().map(|error| of(error).powi(2)).sum();
            (squares / self.errors.len() as f64).sqrt()
        };
        let worst = self.errors.iter().map(|error| error.0).fold(0.0, f64::max);
        let (metres, degrees) = (mean(|error| error.0), mean(|error| error.1).to_degrees());
        self.times.sort_by(f64::total_cmp);
        let median = self.times.get(self.times.len() / 2).copied().unwrap_or(f64::NAN);
        println!(
            "{prior:<10}{:>8}{:>8}{:>8}{:>13}{:>13}{:>11}{:>9}{metres:>9.3}{worst:>10.3}{degrees:>9.2}{median:>11.1}",
            self.times.len(),
            self.accepted[0],
            self.accepted[1],
            self.low_confidence[0],
            self.low_confidence[1],
            self.ambiguous,
            self.nowhere
        );
    }
}

/// A pose prior near the truth, with the error of an operator's estimate.
fn draw_prior(truth: &Isometry, rng: &mut Rng) -> Isometry {
    let (away, toward) =
        (PRIOR_POSITION_ERROR_M * rng.uniform().sqrt(), rng.range(0.0, std::f64::consts::TAU));
    let at = truth.translation.vector + Vector3::new(away * toward.cos(), away * toward.sin(), 0.0);
    let turn = so3::exp(&(Vector3::z() * rng.range(-PRIOR_HEADING_ERROR_RAD, PRIOR_HEADING_ERROR_RAD)));
    Isometry::from_parts(Translation3::from(at), turn * truth.rotation)
}

/// Scans with their poses, in order; poses are rows of 3 x 4 matrices.
fn read(folder: &Path) -> Result<Vec<(Isometry, Vec<[f32; 3]>)>> {
    let poses = folder.join("optimized_poses.txt");
    let poses =
        std::fs::read_to_string(&poses).with_context(|| format!("cannot read {}", poses.display()))?;
    let mut scans = Vec::new();
    for (number, line) in poses.lines().enumerate() {
        let path = folder.join(format!("Scans/{number:06}.pcd"));
        if !path.exists() {
            break;
        }
        let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let table = formats::pcd::read(&bytes).with_context(|| path.display().to_string())?;
        scans.push((
            pose(line).with_context(|| format!("line {} is no pose", number + 1))?,
            table.positions()?,
        ));
    }
    Ok(scans)
}

fn pose(line: &str) -> Option<Isometry> {
    let numbers: Vec<f64> = line.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let row = |row: usize| numbers.get(4 * row..4 * row + 4);
    let (x, y, z) = (row(0)?, row(1)?, row(2)?);
    let rotation =
        Matrix3::from_rows(&[x, y, z].map(|row| nalgebra::RowVector3::new(row[0], row[1], row[2])));
    let rotation = Rotation::from_rotation_matrix(&Rotation3::from_matrix(&rotation));
    Some(Isometry::from_parts(Translation3::new(x[3], y[3], z[3]), rotation))
}
