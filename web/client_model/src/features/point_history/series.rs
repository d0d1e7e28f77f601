//! Readings over time, and the judgement of each result by them.

use super::results::PointResult;
use missions::{SiteZone, day_number};
use readings::{Analysis, ReadingsConfig, Sample, analyse};
use site_model::{OutsideLimits, ReadingLimits, Utc};

/// What series were computed for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SeriesBasis {
    /// Revision of the results.
    pub(super) results: u64,
    /// Number of the results.
    pub(super) count: usize,
    pub(super) limits: Option<ReadingLimits>,
    /// Name of the time zone.
    pub(super) zone: String,
    /// Counts the computations.
    pub(super) revision: u64,
}

/// How a result is judged, the least remarkable first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum ResultJudgement {
    /// It has no reading that could be judged.
    #[default]
    NotJudged,
    /// Its readings keep the limits of the point and fit the others.
    Usual,
    /// A reading does not fit the others.
    Unusual,
    /// A reading does not keep the limits of the point.
    OutsideLimits,
}

/// One reading of a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeriesValue {
    /// Number of the result.
    pub result: u64,
    /// When it was stored.
    pub at: Utc,
    /// Its value.
    pub value: f64,
    /// Its standard deviation, if that is known.
    pub standard_deviation: Option<f64>,
    /// Number of the day at the site.
    pub day: i64,
    /// Hour of the day at the site.
    pub hour: u8,
    /// The limit that it does not keep.
    pub outside: Option<OutsideLimits>,
    /// Whether it does not fit the others.
    pub is_anomaly: bool,
}

/// Readings of one name and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadingSeries {
    /// What is measured, such as `temperature`.
    pub name: String,
    /// The unit.
    pub unit: String,
    /// The readings, the oldest first.
    pub values: Vec<SeriesValue>,
    /// What they have in common. Its clock begins at the first reading.
    pub analysis: Option<Analysis>,
    /// The limits of the point, if they are of this unit.
    pub limits: Option<ReadingLimits>,
}

impl ReadingSeries {
    /// Value of the trend at an instant, without the offset of the hour; none without a trend.
    pub fn trend_at(&self, at: Utc) -> Option<f64> {
        Some(self.analysis.as_ref()?.trend?.at(self.seconds(at)))
    }

    /// The reading of a result, by its number; the first one if it has several of this name.
    pub fn value_of(&self, result: u64) -> Option<&SeriesValue> {
        let first = self.values.partition_point(|value| value.result < result);
        self.values.get(first).filter(|value| value.result == result)
    }

    /// Number of readings that are unusual within the limits, and of those outside the limits.
    pub fn remarkable(&self) -> [usize; 2] {
        let count = |is: fn(&&SeriesValue) -> bool| self.values.iter().filter(is).count();
        [count(|value| value.is_anomaly && value.outside.is_none()), count(|value| value.outside.is_some())]
    }

    /// Seconds since the first reading.
    fn seconds(&self, at: Utc) -> f64 {
        let first = self.values.first().map_or(at.0, |value| value.at.0);
        at.0.saturating_sub(first) as f64 * 1e-9
    }

    /// Judges each reading by limits and by the others.
    fn judge(&mut self) {
        let sample = |of: &SeriesValue| {
            let SeriesValue { value, day, hour, standard_deviation, at, .. } = *of;
            Sample { at_s: self.seconds(at), day, hour, value, standard_deviation }
        };
        let samples: Vec<Sample> = self.values.iter().map(sample).collect();
        self.analysis = analyse(&samples, &ReadingsConfig::default());
        for index in self.analysis.iter().flat_map(|analysis| &analysis.anomalies) {
            self.values[*index].is_anomaly = true;
        }
    }
}

/// The series of all readings, and the judgement of each result. Series of the newest result come first, in its order.
pub(super) fn analyse_results(
    results: &[PointResult],
    limits: Option<&ReadingLimits>,
    zone: &SiteZone,
) -> (Vec<ReadingSeries>, Vec<(u64, ResultJudgement)>) {
    let mut series: Vec<ReadingSeries> = Vec::new();
    for result in results.iter().rev() {
        let local = zone.to_local(result.at);
        let (day, hour) = (day_number(local.date), local.time.hour);
        for reading in result.report.iter().flat_map(|report| &report.readings) {
            let is_it = |known: &ReadingSeries| known.name == reading.name && known.unit == reading.unit;
            let place = series.iter().position(is_it).unwrap_or_else(|| {
                let (name, unit) = (reading.name.clone(), reading.unit.clone());
                let limits = limits.filter(|limits| limits.unit == unit).cloned();
                series.push(ReadingSeries { name, unit, values: Vec::new(), analysis: None, limits });
                series.len() - 1
            });
            series[place].values.push(SeriesValue {
                result: result.number,
                at: result.at,
                value: reading.value,
                standard_deviation: reading.standard_deviation,
                day,
                hour,
                outside: limits.and_then(|limits| limits.outside(reading)),
                is_anomaly: false,
            });
        }
    }
    let mut judgements: Vec<(u64, ResultJudgement)> =
        results.iter().map(|result| (result.number, ResultJudgement::default())).collect();
    for of_one in &mut series {
        of_one.values.reverse();
        of_one.judge();
        let is_judged =
            of_one.limits.is_some() || of_one.analysis.as_ref().is_some_and(|it| it.trend.is_some());
        for value in &of_one.values {
            let judgement = match (value.outside, value.is_anomaly) {
                (Some(_), _) => ResultJudgement::OutsideLimits,
                (None, true) => ResultJudgement::Unusual,
                (None, false) if is_judged => ResultJudgement::Usual,
                (None, false) => ResultJudgement::NotJudged,
            };
            let place = judgements.binary_search_by_key(&value.result, |(number, _)| *number);
            if let Ok(place) = place {
                judgements[place].1 = judgements[place].1.max(judgement);
            }
        }
    }
    (series, judgements)
}
