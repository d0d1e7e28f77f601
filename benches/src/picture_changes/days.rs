//! Gauges over days: of those that begin to drift or are stuck, how soon does the history of their readings show it, and how often is something shown that is not so?
//!
//! Each gauge is visited three times a day. What it measures swings in the course of the day, and scatters. For half of the days the gauge is in order; then it drifts, is stuck, or stays in order. The
//! gauge is described once, in the first picture; every later picture is aligned with that one and read as the robot reads it, and the readings are judged as the client judges them, by those that
//! there are so far.

use super::visits::{self, GaugePoint, Visit};
use super::{PointRun, truth};
use anyhow::{Context, Result};
use gauges::GaugeReading;
use geometry::RngTree;
use readings::{ReadingsConfig, Sample, analyse};
use sim::{CameraScene, ConditionChange, Face, SimulatedQuantity};
use std::sync::Arc;

const DAY_S: f64 = 86_400.0;
const HOUR_S: f64 = 3_600.0;
/// Hours of the day at which the robot comes.
const HOURS: [u8; 3] = [6, 14, 22];
/// Standard deviation of what the gauge measures, besides its swing, as a share of its range.
const SCATTER_SHARE: f64 = 0.003;

/// What becomes of a gauge.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    InOrder,
    /// Its value moves away from the true one by this share of its range a day.
    Drifts(f64),
    /// It always shows what it showed when the days in order ended.
    Stuck,
}

const FATES: [Fate; 5] =
    [Fate::InOrder, Fate::Drifts(0.0025), Fate::Drifts(0.005), Fate::Drifts(0.01), Fate::Stuck];

impl Fate {
    fn describe(self) -> String {
        match self {
            Self::InOrder => "in order".to_owned(),
            Self::Drifts(share) => format!("drifts by {} % of its range a day", 100.0 * share),
            Self::Stuck => "stuck".to_owned(),
        }
    }
}

/// What was shown of gauges of one fate.
#[derive(Clone, Debug, Default)]
struct FateScore {
    gauges: usize,
    /// Days from the beginning of the fault to the first reading that is marked as unusual, and to a clear trend; none where it did not come.
    unusual_days: Vec<Option<f64>>,
    trend_days: Vec<Option<f64>>,
    /// Readings after the beginning, and those of them that are marked as unusual.
    readings: usize,
    unusual: usize,
}

/// The scores of all fates, and of the days before.
#[derive(Clone, Debug, Default)]
pub struct DayScores {
    fates: [FateScore; FATES.len()],
    /// Pictures, and those of which no value was read.
    pictures: usize,
    unread: usize,
}

impl DayScores {
    /// Adds those of other gauges.
    pub fn add(&mut self, other: &Self) {
        for (own, other) in self.fates.iter_mut().zip(&other.fates) {
            own.gauges += other.gauges;
            own.unusual_days.extend(&other.unusual_days);
            own.trend_days.extend(&other.trend_days);
            own.readings += other.readings;
            own.unusual += other.unusual;
        }
        self.pictures += other.pictures;
        self.unread += other.unread;
    }

    /// Tables in Markdown.
    pub fn table(&self) -> String {
        let mut text = format!("{} pictures, of {} no value was read\n\n", self.pictures, self.unread);
        text += "| gauge | series | a reading is marked as unusual | after days: median, worst | the trend is clear | after days: median, worst | readings marked |\n| --- | --- | --- | --- | --- | --- | --- |\n";
        for (fate, score) in FATES.iter().zip(&self.fates) {
            let FateScore { gauges, unusual_days, trend_days, readings, unusual } = score;
            let (marked, clear) = (days(unusual_days), days(trend_days));
            text += &format!(
                "| {} | {gauges} | {marked} | {clear} | {unusual} of {readings} ({:.1} %) |\n",
                fate.describe(),
                100.0 * *unusual as f64 / (*readings).max(1) as f64,
            );
        }
        text
    }
}

/// Number of those that came, and after how many days.
fn days(of: &[Option<f64>]) -> String {
    let mut came: Vec<f64> = of.iter().flatten().copied().collect();
    came.sort_by(f64::total_cmp);
    match (came.get(came.len() / 2), came.last()) {
        (Some(median), Some(worst)) => format!("{} of {} | {median:.1}, {worst:.1}", came.len(), of.len()),
        _ => format!("0 of {} | -", of.len()),
    }
}

/// Visits a gauge on that many days before a fault begins and on as many after it, for each fate.
///
/// # Errors
/// When a picture is no JPEG file, or the site has no such gauge.
pub fn score(run: &PointRun<'_>, days: u32) -> Result<DayScores> {
    let mut scores = DayScores::default();
    let gauge = DailyGauge::new(run, days)?;
    let begin = gauge.readings(Fate::InOrder, 0..days, &mut scores)?;
    for (index, fate) in FATES.into_iter().enumerate() {
        let mut samples = begin.clone();
        let after = gauge.readings(fate, days..2 * days, &mut scores)?;
        let of_fate = &mut scores.fates[index];
        of_fate.gauges += 1;
        let (mut unusual, mut trend) = (None, None);
        for sample in after {
            samples.push(sample);
            of_fate.readings += 1;
            let Some(found) = analyse(&samples, &ReadingsConfig::default()) else { continue };
            let after_days = sample.at_s / DAY_S - f64::from(days);
            let is_unusual = found.anomalies.last() == Some(&(samples.len() - 1));
            of_fate.unusual += usize::from(is_unusual);
            unusual = unusual.or(is_unusual.then_some(after_days));
            trend = trend.or(found.is_trend_clear.then_some(after_days));
        }
        of_fate.unusual_days.push(unusual);
        of_fate.trend_days.push(trend);
    }
    Ok(scores)
}

/// A gauge that is visited day after day.
struct DailyGauge<'a> {
    run: &'a PointRun<'a>,
    first: Visit,
    days: u32,
}

impl<'a> DailyGauge<'a> {
    fn new(run: &'a PointRun<'a>, days: u32) -> Result<Self> {
        let shown = daily(run.scene, run.point)?;
        let first = visits::visit_at(run.scene, run.point, 0, shown, 0.0)?;
        Ok(Self { run, first, days })
    }

    /// The readings of these days.
    fn readings(
        &self,
        fate: Fate,
        days: std::ops::Range<u32>,
        scores: &mut DayScores,
    ) -> Result<Vec<Sample>> {
        let PointRun { site, scene, point, .. } = *self.run;
        let [min, max] = truth::range(point);
        let usual = daily(scene, point)?;
        let tag = point.fixture.tag.clone();
        let begun_s = f64::from(self.days) * DAY_S;
        let change = match fate {
            Fate::InOrder => None,
            Fate::Drifts(share) => {
                Some(ConditionChange::GaugeDrifts { tag, per_day: share * (max - min), begun_days_ago: 0.0 })
            }
            Fate::Stuck => Some(ConditionChange::GaugeStuck { tag, value: usual.at(begun_s) }),
        };
        let changed = site.with_condition_changes(change.as_slice())?;
        let scene = CameraScene::new(Arc::new(changed));
        let shown = daily(&scene, point)?;
        let gauge = self.run.described_gauge(&self.first)?;
        let mut samples = Vec::new();
        for (day, hour) in days.flat_map(|day| HOURS.map(|hour| (day, hour))) {
            let at_s = f64::from(day) * DAY_S + f64::from(hour) * HOUR_S;
            let number = 1 + u64::from(day) * HOURS.len() as u64 + u64::from(hour / 8);
            let mut rng = RngTree::new(number).child(&point.fixture.tag).child("scatter").rng();
            let scatter = if fate == Fate::Stuck { 0.0 } else { SCATTER_SHARE * (max - min) * rng.normal() };
            let shown = SimulatedQuantity { mean: shown.mean + scatter, ..shown };
            // The simulation begins when the gauge changes.
            let seconds = if fate == Fate::InOrder { at_s } else { at_s - begun_s };
            let visit = visits::visit_at(&scene, point, number, shown, seconds)?;
            scores.pictures += 1;
            let mapping = self.run.mapping(&self.first, &visit);
            match mapping.and_then(|mapping| self.run.read(&gauge, &mapping, &visit)) {
                Some(GaugeReading::Read { value, uncertainty, .. }) => samples.push(Sample {
                    at_s,
                    day: i64::from(day),
                    hour,
                    value,
                    standard_deviation: Some(uncertainty),
                }),
                _ => scores.unread += 1,
            }
        }
        Ok(samples)
    }
}

/// What the gauge shows in a scene, with a swing in the course of a day.
fn daily(scene: &CameraScene, point: &GaugePoint) -> Result<SimulatedQuantity> {
    let fixture = scene.fixtures().iter().find(|fixture| fixture.tag == point.fixture.tag);
    match fixture.context("the gauge is on the site")?.face {
        Face::Gauge { reading, .. } => Ok(SimulatedQuantity { period_s: DAY_S, ..reading }),
        _ => anyhow::bail!("{} is no gauge", point.fixture.tag),
    }
}
