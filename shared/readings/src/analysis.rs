//! Readings as the sum of a line, an offset of the hour, and a residual; which residuals are too great.

use crate::hours::{HOURS, offsets_by_hour};
use crate::robust::{median, median_absolute_deviation, robust_deviation};
use crate::trend::{Trend, line_through, theil_sen_slope};

/// Parameters of [`analyse`].
#[derive(Clone, Debug, PartialEq)]
pub struct ReadingsConfig {
    /// Pairs of readings whose slopes are computed at most. Chosen: those of 450 readings. More make the slope hardly more exact, and time and memory
    /// grow with them.
    pub max_pairs: usize,
    /// Readings from which on there is a trend and anomalies. Chosen: the deviation of fewer is known to about half of itself only.
    pub min_samples: usize,
    /// Days on which there is a reading at an hour of the day, from which on the hour has an offset. Chosen: a week; the offset then has a standard error of
    /// half the deviation of one reading.
    pub min_days_of_hour: usize,
    /// A reading is an anomaly if its residual is more than this number of robust standard deviations. 3.5 is what Iglewicz and Hoaglin (How to Detect and
    /// Handle Outliers, 1993) recommend: 1 of 2,000 readings with normal errors is beyond it.
    pub anomaly_deviations: f64,
    /// A trend is clear if its slope is more than this number of standard errors. Chosen: 1 of 370 series without a trend is beyond it, if errors are normal and
    /// independent.
    pub clear_trend_errors: f64,
}

impl Default for ReadingsConfig {
    fn default() -> Self {
        Self {
            max_pairs: 100_000,
            min_samples: 8,
            min_days_of_hour: 7,
            anomaly_deviations: 3.5,
            clear_trend_errors: 3.0,
        }
    }
}

/// Times that line and offsets are fitted, each to what the other leaves. The second time corrects a line that leant on a daily cycle whose hours were not
/// spread evenly.
const ROUNDS: usize = 2;

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When it was made, seconds, on any clock.
    pub at_s: f64,
    /// Number of the day at the site.
    pub day: i64,
    /// Hour of the day at the site, 0 to 23.
    pub hour: u8,
    /// Its value. One that is not finite is left out.
    pub value: f64,
    /// Its standard deviation, if the instrument gives one. A residual within it times [`ReadingsConfig::anomaly_deviations`] is no anomaly.
    pub standard_deviation: Option<f64>,
}

/// What readings have in common, and which do not fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis {
    /// Readings with a finite value.
    pub count: usize,
    /// Smallest and greatest value.
    pub range: [f64; 2],
    /// The median.
    pub median: f64,
    /// The median absolute deviation from it.
    pub median_absolute_deviation: f64,
    /// The line that they follow; none with fewer than [`ReadingsConfig::min_samples`] readings, or without two times.
    pub trend: Option<Trend>,
    /// Whether the slope of the line is clear.
    pub is_trend_clear: bool,
    /// What is added to the line at each hour of the day; none for an hour with too few days.
    pub hour_offsets: [Option<f64>; HOURS],
    /// Robust standard deviation of what line and offsets leave.
    pub deviation: f64,
    /// The readings that do not fit, by their places in the list.
    pub anomalies: Vec<usize>,
}

impl Analysis {
    /// The value that is expected at a time, seconds, at an hour of the day. None without a trend.
    pub fn expected(&self, at_s: f64, hour: u8) -> Option<f64> {
        let offset = self.hour_offsets.get(usize::from(hour)).copied().flatten();
        Some(self.trend?.at(at_s) + offset.unwrap_or(0.0))
    }
}

/// Analyses readings of one thing in one unit, in any order. None without a finite value.
///
/// The cost is that of [`theil_sen_slope`] twice, and otherwise linear in the number of readings.
pub fn analyse(samples: &[Sample], config: &ReadingsConfig) -> Option<Analysis> {
    let is_whole = |sample: &Sample| sample.value.is_finite() && sample.at_s.is_finite();
    let places: Vec<usize> = (0..samples.len()).filter(|place| is_whole(&samples[*place])).collect();
    let used: Vec<Sample> = places.iter().map(|place| samples[*place]).collect();
    let values: Vec<f64> = used.iter().map(|sample| sample.value).collect();
    let least = values.iter().copied().min_by(f64::total_cmp)?;
    let greatest = values.iter().copied().max_by(f64::total_cmp)?;
    let mut analysis = Analysis {
        count: used.len(),
        range: [least, greatest],
        median: median(&values)?,
        median_absolute_deviation: median_absolute_deviation(&values)?,
        trend: None,
        is_trend_clear: false,
        hour_offsets: [None; HOURS],
        deviation: robust_deviation(&values)?,
        anomalies: Vec::new(),
    };
    if used.len() >= config.min_samples {
        fit(&used, config, &mut analysis);
        let anomalies = places.iter().zip(&used).filter(|(_, sample)| is_anomaly(sample, config, &analysis));
        analysis.anomalies = anomalies.map(|(place, _)| *place).collect();
    }
    Some(analysis)
}

/// Fits line and offsets in turn. Leaves the analysis as it is without two times.
fn fit(samples: &[Sample], config: &ReadingsConfig, analysis: &mut Analysis) {
    for _ in 0..ROUNDS {
        let offset = |sample: &Sample| analysis.hour_offsets[usize::from(sample.hour) % HOURS].unwrap_or(0.0);
        let levels: Vec<[f64; 2]> =
            samples.iter().map(|sample| [sample.at_s, sample.value - offset(sample)]).collect();
        let Some(per_s) = theil_sen_slope(&levels, config.max_pairs) else { return };
        let Some(line) = line_through(&levels, per_s, 0.0) else { return };
        let residual = |sample: &Sample| sample.value - line.at(sample.at_s);
        let residuals: Vec<(i64, u8, f64)> =
            samples.iter().map(|sample| (sample.day, sample.hour % 24, residual(sample))).collect();
        analysis.hour_offsets = offsets_by_hour(&residuals, config.min_days_of_hour);
        analysis.trend = Some(line);
        let left: Vec<f64> = samples.iter().filter_map(|sample| residual_of(sample, analysis)).collect();
        analysis.deviation = robust_deviation(&left).unwrap_or(0.0);
        analysis.trend = line_through(&levels, per_s, analysis.deviation);
    }
    let trend = analysis.trend.unwrap_or_default();
    analysis.is_trend_clear = trend.per_s.abs() > config.clear_trend_errors * trend.standard_error_per_s;
}

/// What line and offset leave of a reading.
fn residual_of(sample: &Sample, analysis: &Analysis) -> Option<f64> {
    Some(sample.value - analysis.expected(sample.at_s, sample.hour)?)
}

fn is_anomaly(sample: &Sample, config: &ReadingsConfig, analysis: &Analysis) -> bool {
    let own = sample.standard_deviation.filter(|deviation| deviation.is_finite()).unwrap_or(0.0);
    let limit = config.anomaly_deviations * analysis.deviation.max(own);
    residual_of(sample, analysis).is_some_and(|residual| residual.abs() > limit)
}
