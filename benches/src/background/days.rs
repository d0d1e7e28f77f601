//! Days of a site: changes in the morning, a mission, and its comparison.

use crate::comparison::{Comparison, Found, compare};
use crate::news::{News, NewsScore};
use anyhow::{Context, Result, ensure};
use benches::cast_visits::cast_visit;
use changes::{SensorView, UprightBox};
use runtime::{BaselineConfig, find_baseline, note_comparison};
use sim::{LooseObjectsConfig, SimulatedSite, SiteName};
use site_model::{EarlierVisit, LocalisationQuality, MissionId, OrientedBox, ReportPlace, RunId};
use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;
use store::{ChangedSince, RunCloudCause, RunCloudEntry, RunCloudsConfig, Store};
use tempfile::TempDir;
use uuid::Uuid;
use vocab::{BlobHash, Covariance6, MapId, Pose, Stamp, Vec3};

/// Things that stand loose on the site before the first day.
const FIRST_THINGS: usize = 12;
/// Nanoseconds of a day, and between two clouds.
const DAY_NS: i64 = 86_400_000_000_000;
const CLOUD_NS: i64 = 2_000_000_000;
const MAP: MapId = MapId(Uuid::from_u128(1));

/// What is done.
pub struct DaysPlan {
    pub site: SiteName,
    pub days: u32,
    pub changes: usize,
    pub columns: u32,
    pub people: u32,
    pub seed: u64,
    pub program: PathBuf,
}

/// A mission: a part of the round.
#[derive(Clone, Copy)]
struct Mission {
    name: &'static str,
    /// From which to which share of the round.
    part: [f64; 2],
}

/// Which mission walks on which day, again and again.
const TURNS: [Mission; 5] = [
    Mission { name: "round", part: [0.0, 1.0] },
    Mission { name: "first part", part: [0.0, 0.6] },
    Mission { name: "last part", part: [0.4, 1.0] },
    Mission { name: "first part", part: [0.0, 0.6] },
    Mission { name: "last part", part: [0.4, 1.0] },
];

/// The comparison of a day.
pub struct Row {
    site: SiteName,
    day: u32,
    mission: &'static str,
    points: usize,
    background_points: usize,
    background_runs: usize,
    pub score: NewsScore,
    pub notes: Vec<String>,
    pub seconds: f64,
    pub processor_s: f64,
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { site, day, mission, points, background_points, background_runs, score, .. } = self;
        let NewsScore { passed, named, late, repeated, wrong, .. } = score;
        write!(
            f,
            "| {site} | {day} | {mission} | {points} | {background_points} | {background_runs} | {passed} | {named} | {late} | {repeated} | {wrong} | {:.2} | {:.2} |",
            self.seconds, self.processor_s
        )
    }
}

/// A site over days.
pub struct Days<'a> {
    plan: &'a DaysPlan,
    folder: TempDir,
    store: Store,
    news: News,
}

impl<'a> Days<'a> {
    /// Before the first day.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn new(plan: &'a DaysPlan) -> Result<Self> {
        let folder = tempfile::tempdir()?;
        let store = Store::open(folder.path().join("data"))?;
        Ok(Self { plan, folder, store, news: News::default() })
    }

    /// All days; each comparison is told.
    ///
    /// # Errors
    /// When the site has no round, the disk is full, or the program fails.
    pub fn run(mut self, mut tell: impl FnMut(&Row)) -> Result<()> {
        let things = LooseObjectsConfig::default();
        let plan = self.plan;
        let mut site = SimulatedSite::new(plan.site).with_loose_objects(plan.seed, FIRST_THINGS, &things);
        for day in 0..plan.days {
            let seed = 1_000 * plan.seed + u64::from(day);
            if day > 0 {
                let changes = site.random_changes(seed, plan.changes, &things);
                site = site.with_changes(&changes);
                self.news.change(&changes);
            }
            let mission = TURNS[day as usize % TURNS.len()];
            let views = views_of(&site, mission, plan, seed)?;
            let run = RunId(Uuid::from_u128(u128::from(day) + 1));
            for (number, view) in (0..).zip(&views) {
                let utc_ns = i64::from(day) * DAY_NS + number * CLOUD_NS;
                let entry = entry(view, utc_ns);
                let xyz: Vec<[f32; 3]> = view.points.iter().map(|point| from_sensor(view, point)).collect();
                let put = self.store.put_run_cloud(run, entry, &xyz, &[], &RunCloudsConfig::default())?;
                ensure!(put.is_some(), "there is no room for clouds");
            }
            if day == 0 {
                self.news.first_run(site.loose_objects(), &views);
                note_comparison(&self.store, run, None, Vec::new(), None)?;
                continue;
            }
            tell(&self.compare(run, day, mission.name, &views)?);
        }
        Ok(())
    }

    fn compare(&mut self, run: RunId, day: u32, mission: &'static str, views: &[SensorView]) -> Result<Row> {
        let baseline = find_baseline(&self.store, run, &BaselineConfig::default())?
            .context("a run has clouds in the map")?;
        ensure!(
            matches!(baseline.before, EarlierVisit::Run(_)),
            "earlier runs have not seen enough of day {day}"
        );
        let background = self.store.dir().background();
        self.store.put_background(&background, &baseline.clouds, baseline.changes.clone())?;
        let after = self.store.dir().clouds_of_run(run);
        let out = self.folder.path().join("out");
        let Comparison { objects, seconds, processor_s } =
            compare(&self.plan.program, &background, &after, &out)?;
        std::fs::remove_dir_all(&background)?;
        let since = |found: &Found| ChangedSince {
            utc_ns: baseline.began_utc_ns,
            was: found.was.as_ref().map(oriented),
            is: found.is.as_ref().map(oriented),
        };
        note_comparison(&self.store, run, Some(&baseline), objects.iter().map(since).collect(), None)?;
        let mut notes = Vec::new();
        let score = self.news.score(&objects, views, |note| notes.push(note));
        let runs: BTreeSet<RunId> = baseline.clouds.iter().map(|(run, _)| *run).collect();
        Ok(Row {
            site: self.plan.site,
            day,
            mission,
            points: views.iter().map(|view| view.points.len()).sum(),
            background_points: baseline.clouds.iter().map(|(_, entry)| entry.points as usize).sum(),
            background_runs: runs.len(),
            score,
            notes,
            seconds,
            processor_s,
        })
    }
}

/// What a mission sees.
fn views_of(site: &SimulatedSite, mission: Mission, plan: &DaysPlan, seed: u64) -> Result<Vec<SensorView>> {
    let views = cast_visit(site, plan.columns, plan.people, seed)?.views;
    let [from, to] = mission.part.map(|share| (share * views.len() as f64).round() as usize);
    Ok(views.into_iter().take(to).skip(from).collect())
}

/// What is known of a cloud whose base is where its sensor is, with the axes of the map.
fn entry(view: &SensorView, utc_ns: i64) -> RunCloudEntry {
    let position = Vec3::new(view.sensor.x, view.sensor.y, view.sensor.z);
    RunCloudEntry {
        cloud: BlobHash([0; 32]),
        bytes: 0,
        robot_time: Stamp::from_nanos(utc_ns),
        utc_ns,
        cause: RunCloudCause::Distance,
        mission: Some(MissionId(Uuid::from_u128(2))),
        step: None,
        place: ReportPlace {
            map: Some(MAP),
            map_from_base: Pose { position, ..Pose::IDENTITY },
            covariance: Covariance6::default(),
            quality: LocalisationQuality::Good,
        },
        base_from_sensor_m: [0.0; 3],
        points: view.points.len() as u32,
    }
}

fn from_sensor(view: &SensorView, point: &[f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| (f64::from(point[axis]) - view.sensor[axis]) as f32)
}

fn oriented(place: &UprightBox) -> OrientedBox {
    let [x, y, z] = place.centre_m.into();
    OrientedBox { centre_m: Vec3::new(x, y, z), size_m: place.size_m, yaw_rad: place.yaw_rad }
}
