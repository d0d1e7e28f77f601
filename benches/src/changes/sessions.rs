//! Makes two sessions of one hall that differ by boxes: boxes are put into recorded scans by casting the recorded rays against them, so that occlusion is right.

use anyhow::{Context, Result, ensure};
use changes::{SensorView, UprightBox, Visit};
use formats::tum;
use geometry::{Isometry, Matrix3, Rng, RngTree, Vector3, isometry_from_pose};
use messages::Sensor;
use nalgebra::{Point3, UnitQuaternion};
use recorder::{Recording, TopicSelection};
use std::collections::BTreeMap;
use std::path::Path;

/// Share of the points of each scan that a session keeps: another random part for each seed.
const KEPT_SHARE: f64 = 0.75;
/// Noise of the range of a ray that meets a box, metres.
const RANGE_NOISE_M: f64 = 0.012;
/// Scans of a session.
const SCANS: usize = 35;
/// A box meets at least this number of rays of the session in which it stands.
const MIN_POINTS: usize = 80;
/// Least number of rays of the session in which a box does not stand that go through its place: what nobody looked at cannot be compared.
const MIN_RAYS_THROUGH: usize = 40;
/// Distance of boxes from what was recorded, from the sensor and from each other, metres.
const CLEAR_M: f64 = 0.15;
const FROM_SENSOR_M: f64 = 0.6;
const APART_M: f64 = 0.8;
/// Places that are tried for a box.
const TRIALS: usize = 20_000;

/// A box that stands in one session or both. Sizes are metres, the length at least the width.
#[derive(Clone, Copy, Debug)]
pub struct Inserted {
    pub place: UprightBox,
    /// Rays that ended at it, in the session before and in the one after.
    pub points: [usize; 2],
}

/// What became of an inserted box.
#[derive(Clone, Copy, Debug)]
pub enum Truth {
    Appeared(Inserted),
    Removed(Inserted),
    Moved { from: Inserted, to: Inserted },
    Unchanged(Inserted),
}

/// Two sessions and the boxes in them.
pub struct Sessions {
    pub before: Visit,
    pub after: Visit,
    pub truth: Vec<Truth>,
}

/// The scans of a recording as views, with the poses of a trajectory of the LiDAR, in a frame with the floor at height 0.
///
/// # Errors
/// When the files cannot be read.
pub fn read_views(bag: &Path, trajectory: &Path) -> Result<Vec<SensorView>> {
    let text = std::fs::read_to_string(trajectory).with_context(|| trajectory.display().to_string())?;
    let poses: BTreeMap<i64, Isometry> = tum::read(&text)?
        .into_iter()
        .filter_map(|(stamp, pose)| Some((stamp.nanos() / 1_000_000, isometry_from_pose(&pose)?)))
        .collect();
    let recording = Recording::open(bag, &TopicSelection::default())?;
    let mut views = Vec::new();
    for message in recording.inputs() {
        let Sensor::Scan(scan) = message?.1 else { continue };
        let at_ms = scan.stamp.nanos() / 1_000_000;
        let near = poses.range(at_ms - 2..=at_ms + 2).next();
        let Some((_, map_from_lidar)) = near else { continue };
        let in_map = |point: &[f32; 3]| map_from_lidar * Point3::from(point.map(f64::from));
        let points = scan.xyz.iter().map(|point| in_map(point).coords.map(|at| at as f32).into()).collect();
        views.push(SensorView { sensor: map_from_lidar.translation.vector, points });
    }
    ensure!(views.len() >= 2 * SCANS, "{}: only {} scans have a pose", bag.display(), views.len());
    let level = level_from_map(&views);
    for view in &mut views {
        view.sensor = (level * Point3::from(view.sensor)).coords;
        for point in &mut view.points {
            *point = (level * Point3::from(point.map(f64::from))).coords.map(|at| at as f32).into();
        }
    }
    Ok(views)
}

/// The transform that makes the floor level and puts it at height 0: the most common height below the sensor, then the plane through the points near it.
fn level_from_map(views: &[SensorView]) -> Isometry {
    let mut level = Isometry::identity();
    for reach_m in [0.3, 0.15, 0.08, 0.08] {
        let below: Vec<Vector3> = views
            .iter()
            .flat_map(|view| view.points.iter().step_by(5).map(move |point| (view, point)))
            .map(|(view, point)| {
                (level * Point3::from(view.sensor), level * Point3::from(point.map(f64::from)))
            })
            .filter(|(sensor, point)| point.z < sensor.z - 0.3 && (point - sensor).norm() < 8.0)
            .map(|(_, point)| point.coords)
            .collect();
        let mut counts: BTreeMap<i64, usize> = BTreeMap::new();
        for point in &below {
            *counts.entry((point.z / reach_m).floor() as i64).or_default() += 1;
        }
        let Some((bin, _)) = counts.into_iter().max_by_key(|(_, count)| *count) else { break };
        let floor_m = (bin as f64 + 0.5) * reach_m;
        let on: Vec<&Vector3> = below.iter().filter(|point| (point.z - floor_m).abs() < reach_m).collect();
        let mean = on.iter().copied().sum::<Vector3>() / on.len() as f64;
        let spread: Matrix3 = on.iter().map(|point| (*point - mean) * (*point - mean).transpose()).sum();
        let eigen = spread.symmetric_eigen();
        let normal: Vector3 = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
        let up = normal * normal.z.signum();
        let turn = UnitQuaternion::rotation_between(&up, &Vector3::z()).unwrap_or_default();
        let turned = turn * mean;
        level = Isometry::from_parts(Vector3::new(0.0, 0.0, -turned.z).into(), turn) * level;
    }
    level
}

/// Makes the sessions of a seed: two boxes that are unchanged, two that appeared, two that were removed and one that was moved.
///
/// # Errors
/// When no place is found for a box.
pub fn make(views: &[SensorView], seed: u64) -> Result<Sessions> {
    let tree = RngTree::new(seed).child("boxes");
    let mut rng = tree.rng();
    let mut start = |low: usize, high: usize| low + (rng.uniform() * (high - low + 1) as f64) as usize;
    let (first, second) = (start(20, 29), start(56, views.len().saturating_sub(SCANS).max(56)));
    let mut sides =
        [first, second].map(|from| Side::new(&views[from..(from + SCANS).min(views.len())], &tree, from));
    if rng.uniform() < 0.5 {
        sides.swap(0, 1);
    }
    let mut placing = Placing { sides: &sides, rng, placed: Vec::new() };
    let mut standing: [Vec<UprightBox>; 2] = [Vec::new(), Vec::new()];
    let mut plans = Vec::new();
    for (kind, stands) in
        [("unchanged", [true, true]), ("appeared", [false, true]), ("removed", [true, false])]
    {
        for _ in 0..2 {
            let size_m = placing.size_m();
            plans.push((kind, vec![(placing.place(size_m, stands)?, stands)]));
        }
    }
    let size_m = placing.size_m();
    let from = (placing.place(size_m, [true, false])?, [true, false]);
    let to = (placing.place(size_m, [false, true])?, [false, true]);
    plans.push(("moved", vec![from, to]));
    for (place, stands) in plans.iter().flat_map(|(_, boxes)| boxes) {
        for side in 0..2 {
            if stands[side] {
                standing[side].push(*place);
            }
        }
    }
    let visits =
        [0, 1].map(|side| sides[side].with_boxes(&standing[side], &tree.child(["before", "after"][side])));
    let inserted = |place: UprightBox| Inserted {
        place,
        points: [0, 1].map(|side| {
            let position = standing[side].iter().position(|other| *other == place);
            position.map_or(0, |position| visits[side].1[position])
        }),
    };
    let truth = plans
        .iter()
        .map(|(kind, boxes)| match (*kind, boxes.as_slice()) {
            ("unchanged", [(place, _)]) => Truth::Unchanged(inserted(*place)),
            ("appeared", [(place, _)]) => Truth::Appeared(inserted(*place)),
            ("removed", [(place, _)]) => Truth::Removed(inserted(*place)),
            (_, boxes) => Truth::Moved { from: inserted(boxes[0].0), to: inserted(boxes[1].0) },
        })
        .collect();
    let [(before, _), (after, _)] = visits;
    Ok(Sessions { before, after, truth })
}

/// The recorded part of a session.
struct Side {
    views: Vec<SensorView>,
}

impl Side {
    /// A random part of the points of these views.
    fn new(views: &[SensorView], tree: &RngTree, from: usize) -> Self {
        let mut rng = tree.child(&format!("points {from}")).rng();
        let part = |view: &SensorView| SensorView {
            sensor: view.sensor,
            points: view.points.iter().filter(|_| rng.uniform() < KEPT_SHARE).copied().collect(),
        };
        Self { views: views.iter().map(part).collect() }
    }

    /// The session with boxes, and the number of rays that ended at each.
    fn with_boxes(&self, boxes: &[UprightBox], tree: &RngTree) -> (Visit, Vec<usize>) {
        let mut rng = tree.rng();
        let mut counts = vec![0; boxes.len()];
        let mut views = self.views.clone();
        for view in &mut views {
            for point in &mut view.points {
                let offset = Vector3::from(point.map(f64::from)) - view.sensor;
                let range_m = offset.norm();
                let met = (0..boxes.len())
                    .filter_map(|number| {
                        Some((enters_m(&boxes[number], &view.sensor, &(offset / range_m))?, number))
                    })
                    .filter(|(at_m, _)| *at_m < range_m)
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                if let Some((at_m, number)) = met {
                    counts[number] += 1;
                    let at_m = at_m + RANGE_NOISE_M * rng.normal();
                    *point = (view.sensor + offset / range_m * at_m).map(|at| at as f32).into();
                }
            }
        }
        (Visit { views }, counts)
    }

    /// Number of rays that meet a box.
    fn rays_at(&self, place: &UprightBox) -> usize {
        self.with_boxes(&[*place], &RngTree::new(0)).1[0]
    }

    /// Whether a box stands free of all that was recorded, and not at the sensor.
    fn is_clear(&self, place: &UprightBox) -> bool {
        let is_met =
            |point: &[f32; 3]| point[2] > 0.1 && place.holds(&Vector3::from(point.map(f64::from)), CLEAR_M);
        self.views
            .iter()
            .all(|view| !place.holds(&view.sensor, FROM_SENSOR_M) && !view.points.iter().any(is_met))
    }
}

/// Chooses places for boxes.
struct Placing<'a> {
    sides: &'a [Side; 2],
    rng: Rng,
    placed: Vec<UprightBox>,
}

impl Placing<'_> {
    /// A size, metres: the length is at least the width.
    fn size_m(&mut self) -> [f64; 3] {
        let (a, b) = (self.rng.range(0.25, 1.0), self.rng.range(0.25, 1.0));
        [a.max(b), a.min(b), self.rng.range(0.25, 1.6)]
    }

    /// A place on the floor for a box of this size that stands in these sessions.
    fn place(&mut self, size_m: [f64; 3], stands: [bool; 2]) -> Result<UprightBox> {
        for _ in 0..TRIALS {
            let side = &self.sides[usize::from(self.rng.uniform() < 0.5)];
            let view = &side.views[(self.rng.uniform() * side.views.len() as f64) as usize];
            let (range_m, heading) = (self.rng.range(1.0, 10.0), self.rng.range(0.0, std::f64::consts::TAU));
            let centre_m = Vector3::new(
                view.sensor.x + range_m * heading.cos(),
                view.sensor.y + range_m * heading.sin(),
                size_m[2] / 2.0,
            );
            let yaw_rad = self.rng.range(0.0, std::f64::consts::PI);
            let place = UprightBox { centre_m, size_m, yaw_rad };
            let reach_m = |place: &UprightBox| place.size_m[0].hypot(place.size_m[1]) / 2.0;
            let is_apart = self.placed.iter().all(|other| {
                (other.centre_m - centre_m).xy().norm() > reach_m(other) + reach_m(&place) + APART_M
            });
            if !is_apart || !self.sides.iter().all(|side| side.is_clear(&place)) {
                continue;
            }
            let is_seen = (0..2).all(|side| {
                let least = if stands[side] { MIN_POINTS } else { MIN_RAYS_THROUGH };
                self.sides[side].rays_at(&place) >= least
            });
            if is_seen {
                self.placed.push(place);
                return Ok(place);
            }
        }
        anyhow::bail!("no place for a box of {size_m:?}")
    }
}

/// Distance at which a ray from `start` along a unit `direction` enters a box, metres; none if it misses it.
fn enters_m(place: &UprightBox, start: &Vector3, direction: &Vector3) -> Option<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -place.yaw_rad);
    let (from, along) = (turn * (start - place.centre_m), turn * direction);
    let half = place.size_m.map(|side| side / 2.0);
    let (mut enters, mut leaves) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let inverse = 1.0 / along[axis];
        let (a, b) = ((-half[axis] - from[axis]) * inverse, (half[axis] - from[axis]) * inverse);
        enters = enters.max(a.min(b));
        leaves = leaves.min(a.max(b));
    }
    (enters < leaves).then_some(enters)
}
