//! Recorded scans with known poses: every second one makes the map, and the others are looked for in it, each by itself.

use anyhow::{Context, Result};
use benches::thread_ms;
use geometry::{Isometry, Rng, RngTree, Rotation, Vector3, so3};
use localisation::{
    AcceptanceConfig, GlobalLocaliser, LocalisationMap, PoseHypothesis, RelocalisationResult,
};
use mapping::KeyframeDescriptor;
use nalgebra::{Matrix3, Rotation3, Translation3};
use std::path::Path;
use std::sync::Arc;

/// A place counts as found within this: metres and radians.
const RIGHT: (f64, f64) = (0.2, 0.052);
/// Whoever tells a place is so far off at most: metres and radians.
const TOLD: (f64, f64) = (1.0, 0.35);
/// Where it is told, each scan is looked for so many times.
const TIMES: usize = 5;

/// What became of some scans.
#[derive(Default)]
struct Outcome {
    /// Told from one scan, right and wrong.
    alone: [usize; 2],
    /// Where nothing fits well, but nothing else nearly so: believed where somebody told it, else once it was found again as the robot moves.
    faint: [usize; 2],
    ambiguous: usize,
    nowhere: usize,
    /// Of the right ones: metres and radians.
    errors: Vec<(f64, f64)>,
    times: Vec<f64>,
}

/// Looks for the odd scans of a folder with `Scans/*.pcd` and `optimized_poses.txt` among the even ones, told nothing and told about where.
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
    let (mut nothing, mut told) = (Outcome::default(), Outcome::default());
    for (truth, place) in scans.iter().skip(1).step_by(2).map(of) {
        let before = thread_ms();
        let found = localiser.find_poses(&place, &truth.rotation, None);
        nothing.count(&found, &truth, thread_ms() - before);
        for _ in 0..TIMES {
            let start = about(&truth, &mut rng);
            let before = thread_ms();
            let found = localiser.find_poses_near(&place, &[start]);
            told.count(&found, &truth, thread_ms() - before);
        }
    }
    println!(
        "{:<10}{:>8}{:>8}{:>8}{:>13}{:>13}{:>11}{:>9}{:>9}{:>10}{:>9}{:>11}",
        "told",
        "scans",
        "right",
        "WRONG",
        "faint, right",
        "faint, WRONG",
        "ambiguous",
        "nowhere",
        "RMSE m",
        "worst m",
        "degrees",
        "median ms"
    );
    nothing.print("nothing");
    told.print("1 m, 20°");
    Ok(())
}

impl Outcome {
    fn count(&mut self, found: &[PoseHypothesis], truth: &Isometry, ms: f64) {
        self.times.push(ms);
        let (one, places) = match AcceptanceConfig::default().classify(found) {
            RelocalisationResult::Unique(one) => (one, &mut self.alone),
            RelocalisationResult::LowConfidence(one) => (one, &mut self.faint),
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
        let right = error.0 <= RIGHT.0 && error.1 <= RIGHT.1;
        places[usize::from(!right)] += 1;
        if right {
            self.errors.push(error);
        }
    }

    fn print(mut self, told: &str) {
        let mean = |of: fn(&(f64, f64)) -> f64| {
            let squares: f64 = self.errors.iter().map(|error| of(error).powi(2)).sum();
            (squares / self.errors.len() as f64).sqrt()
        };
        let worst = self.errors.iter().map(|error| error.0).fold(0.0, f64::max);
        let (metres, degrees) = (mean(|error| error.0), mean(|error| error.1).to_degrees());
        self.times.sort_by(f64::total_cmp);
        let median = self.times.get(self.times.len() / 2).copied().unwrap_or(f64::NAN);
        println!(
            "{told:<10}{:>8}{:>8}{:>8}{:>13}{:>13}{:>11}{:>9}{metres:>9.3}{worst:>10.3}{degrees:>9.2}{median:>11.1}",
            self.times.len(),
            self.alone[0],
            self.alone[1],
            self.faint[0],
            self.faint[1],
            self.ambiguous,
            self.nowhere
        );
    }
}

/// Somewhere near, as a person would tell it.
fn about(truth: &Isometry, rng: &mut Rng) -> Isometry {
    let (away, toward) = (TOLD.0 * rng.uniform().sqrt(), rng.range(0.0, std::f64::consts::TAU));
    let at = truth.translation.vector + Vector3::new(away * toward.cos(), away * toward.sin(), 0.0);
    let turn = so3::exp(&(Vector3::z() * rng.range(-TOLD.1, TOLD.1)));
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
