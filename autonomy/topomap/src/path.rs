//! The path that the robot has walked: split into walks, sampled evenly, with its flights of stairs.

use crate::TopomapConfig;
use crate::floor::TimedPosition;
use geometry::{Isometry, Vector3};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use vocab::Stamp;

/// Edge of the squares by which samples are looked up, metres.
const SAMPLE_BLOCK_M: f64 = 1.0;

/// A place on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// Position of the feet, metres, map frame.
    pub feet: Vector3,
    /// Heading of the robot, radians.
    pub yaw: f64,
}

/// The next place of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PathStep {
    /// Walked straight from the last place.
    Walk(Sample),
    /// The near end of stairs, walked straight from the last place.
    StairsBegin(Sample),
    /// The far end of stairs that began at the last place. `is_backward`: the robot looked the way it came from.
    StairsEnd { sample: Sample, is_backward: bool },
}

/// All walks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Path {
    /// One after the other, without their stairs.
    pub walks: Vec<Vec<PathStep>>,
    /// All samples, those on stairs too, by squares.
    blocks: BTreeMap<(i32, i32), Vec<Vector3>>,
    /// All samples in order.
    pub positions: Vec<TimedPosition>,
}

impl Path {
    /// The path of a base whose feet are `standing_height_m` below it. Linear in the poses.
    pub fn new(map_from_base: &[(Stamp, Isometry)], standing_height_m: f64, config: &TopomapConfig) -> Self {
        let mut path = Self::default();
        for walk in split(map_from_base, config.path_gap_m) {
            let samples = sample(walk, standing_height_m, config.sample_m);
            for (stamp, sample) in &samples {
                path.blocks.entry(block(&sample.feet)).or_default().push(sample.feet);
                path.positions.push(TimedPosition { feet: sample.feet, stamp: *stamp });
            }
            let samples: Vec<Sample> = samples.into_iter().map(|(_, sample)| sample).collect();
            let flights = flights(&samples, config);
            path.walks.push(steps(&samples, &flights, config));
        }
        path
    }

    /// Whether a sample is within a distance of a place.
    pub fn is_near(&self, at: &Vector3, within_m: f64) -> bool {
        let ((x, y), reach) = (block(at), (within_m / SAMPLE_BLOCK_M).ceil() as i32);
        (x - reach..=x + reach).any(|x| {
            (y - reach..=y + reach).any(|y| {
                self.blocks
                    .get(&(x, y))
                    .is_some_and(|samples| samples.iter().any(|feet| (feet - at).norm() <= within_m))
            })
        })
    }
}

fn block(at: &Vector3) -> (i32, i32) {
    ((at.x / SAMPLE_BLOCK_M).floor() as i32, (at.y / SAMPLE_BLOCK_M).floor() as i32)
}

/// The walks of a path: between two of them the robot was carried, or the map was made of several sessions.
fn split(poses: &[(Stamp, Isometry)], gap_m: f64) -> Vec<&[(Stamp, Isometry)]> {
    let offset = |a: &Isometry, b: &Isometry| (a.translation.vector - b.translation.vector).norm();
    poses.chunk_by(|(_, a), (_, b)| offset(a, b) <= gap_m).collect()
}

/// Samples at a distance of `spacing_m` along a walk; the last pose too.
fn sample(walk: &[(Stamp, Isometry)], standing_height_m: f64, spacing_m: f64) -> Vec<(Stamp, Sample)> {
    let to_sample = |pose: &Isometry| Sample {
        feet: pose.translation.vector - Vector3::z() * standing_height_m,
        yaw: pose.rotation.euler_angles().2,
    };
    let mut samples: Vec<(Stamp, Sample)> = Vec::new();
    for (stamp, pose) in walk {
        let next = to_sample(pose);
        let Some((_, last)) = samples.last().copied() else {
            samples.push((*stamp, next));
            continue;
        };
        let distance_m = (next.feet - last.feet).norm();
        let count = (distance_m / spacing_m) as usize;
        for number in 1..=count {
            let share = number as f64 * spacing_m / distance_m;
            samples.push((*stamp, Sample { feet: last.feet.lerp(&next.feet, share), yaw: next.yaw }));
        }
    }
    if let (Some((stamp, pose)), Some((_, last))) = (walk.last(), samples.last())
        && (to_sample(pose).feet - last.feet).norm() > spacing_m / 2.0
    {
        samples.push((*stamp, to_sample(pose)));
    }
    samples
}

/// Runs of samples on stairs.
fn flights(samples: &[Sample], config: &TopomapConfig) -> Vec<RangeInclusive<usize>> {
    let reach = (config.stairs_window_m / 2.0 / config.sample_m).round().max(1.0) as usize;
    let is_steep = |index: usize| {
        let (a, b) = (index.saturating_sub(reach), (index + reach).min(samples.len() - 1));
        let span = samples[b].feet - samples[a].feet;
        // A robot that turns in place says nothing of the slope.
        let level_m = span.xy().norm();
        level_m > config.stairs_window_m / 4.0 && span.z.abs() > config.min_stairs_slope * level_m
    };
    let mut runs: Vec<RangeInclusive<usize>> = Vec::new();
    for index in (0..samples.len()).filter(|index| is_steep(*index)) {
        match runs.last_mut() {
            Some(run) if index <= run.end() + reach => *run = *run.start()..=index,
            _ => runs.push(index..=index),
        }
    }
    runs.retain(|run| {
        let rise_m = samples[*run.end()].feet.z - samples[*run.start()].feet.z;
        rise_m.abs() >= config.min_stairs_rise_m - config.min_stairs_slope * config.sample_m
    });
    runs
}

/// The steps of a walk: each flight of stairs from a place before it to a place behind it.
fn steps(samples: &[Sample], flights: &[RangeInclusive<usize>], config: &TopomapConfig) -> Vec<PathStep> {
    let margin = (config.stairs_margin_m / config.sample_m).round() as usize;
    let mut steps = Vec::new();
    let mut next = 0;
    for (number, flight) in flights.iter().enumerate() {
        let begin = flight.start().saturating_sub(margin).max(next);
        // Between two flights both margins have to find room.
        let limit = flights
            .get(number + 1)
            .map_or(samples.len() - 1, |after| usize::midpoint(*flight.end(), *after.start()));
        let end = (flight.end() + margin).min(limit);
        steps.extend(samples[next..begin.max(next)].iter().copied().map(PathStep::Walk));
        let (first, last) = (samples[begin], samples[end]);
        let forward = (last.feet - first.feet).xy();
        let middle = samples[usize::midpoint(begin, end)].yaw;
        let is_backward = forward.x * middle.cos() + forward.y * middle.sin() < 0.0;
        steps.push(PathStep::StairsBegin(first));
        steps.push(PathStep::StairsEnd { sample: last, is_backward });
        next = end + 1;
    }
    steps.extend(samples[next.min(samples.len())..].iter().copied().map(PathStep::Walk));
    steps
}

/// A path that nobody walked, over these places of the feet, with its flights of stairs.
pub(crate) fn virtual_walk(feet: &[Vector3], config: &TopomapConfig) -> Vec<PathStep> {
    let yaw = |index: usize| {
        let (a, b) = (feet[index.saturating_sub(1)], feet[(index + 1).min(feet.len() - 1)]);
        (b.y - a.y).atan2(b.x - a.x)
    };
    let samples: Vec<Sample> =
        (0..feet.len()).map(|index| Sample { feet: feet[index], yaw: yaw(index) }).collect();
    let flights = flights(&samples, config);
    steps(&samples, &flights, config)
}
