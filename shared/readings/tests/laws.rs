//! Laws of the statistics, over random readings, and readings with something planted.

use proptest::prelude::*;
use readings::{Analysis, ReadingsConfig, Sample, analyse, median, robust_deviation};

const HOUR_S: f64 = 3_600.0;
const DAY_S: f64 = 86_400.0;

/// Two readings a day, at 11:00 and 15:00.
fn twice_a_day(values: impl IntoIterator<Item = f64>) -> Vec<Sample> {
    let sample = |(index, value): (usize, f64)| {
        let (day, hour) = ((index / 2) as i64, if index % 2 == 0 { 11 } else { 15 });
        let at_s = day as f64 * DAY_S + f64::from(hour) * HOUR_S;
        Sample { at_s, day, hour, value, standard_deviation: None }
    };
    values.into_iter().enumerate().map(sample).collect()
}

fn analysed(samples: &[Sample]) -> Analysis {
    analyse(samples, &ReadingsConfig::default()).expect("there are readings")
}

/// Noise that is the same in each run: uniform in -0.5 to 0.5.
fn noise(index: usize) -> f64 {
    let mixed = (index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (mixed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
}

fn near(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= 1e-9 * scale.max(1e-9)
}

fn values() -> impl Strategy<Value = Vec<f64>> {
    // Whole numbers are shifted and scaled by powers of two without an error.
    prop::collection::vec((-1_000..1_000).prop_map(f64::from), 8..120)
}

proptest! {
    #[test]
    fn a_shift_of_all_readings_shifts_the_line_and_nothing_else(values in values(), shift in -4_096..4_096) {
        let shift = f64::from(shift);
        let before = analysed(&twice_a_day(values.clone()));
        let after = analysed(&twice_a_day(values.iter().map(|value| value + shift)));
        prop_assert_eq!(after.median, before.median + shift);
        prop_assert_eq!(after.median_absolute_deviation, before.median_absolute_deviation);
        let (a, b) = (before.trend.unwrap(), after.trend.unwrap());
        prop_assert!(near(a.per_s, b.per_s, a.per_s.abs()));
        prop_assert!(near(a.value + shift, b.value, 1e4));
        prop_assert!(near(before.deviation, after.deviation, 1e3));
    }

    #[test]
    fn a_scale_of_all_readings_scales_everything(values in values(), power in -8_i32..8) {
        let scale = 2_f64.powi(power);
        let before = analysed(&twice_a_day(values.clone()));
        let after = analysed(&twice_a_day(values.iter().map(|value| value * scale)));
        prop_assert_eq!(after.median, before.median * scale);
        prop_assert_eq!(after.deviation, before.deviation * scale);
        prop_assert_eq!(after.trend.unwrap().per_s, before.trend.unwrap().per_s * scale);
        prop_assert_eq!(after.hour_offsets, before.hour_offsets.map(|offset| Some(offset? * scale)));
        prop_assert_eq!(after.anomalies, before.anomalies);
    }

    #[test]
    fn one_outlier_moves_nothing_out_of_the_range_of_the_others(place in 0_usize..60, size in 1e3..1e12_f64) {
        let calm = |index: usize| 20.0 + noise(index);
        let before = analysed(&twice_a_day((0..60).map(calm)));
        let after = analysed(&twice_a_day((0..60).map(|index| calm(index) + if index == place { size } else { 0.0 })));
        prop_assert!((after.median - before.median).abs() < 0.1);
        prop_assert!((after.deviation - before.deviation).abs() < 0.1);
        let (a, b) = (before.trend.unwrap(), after.trend.unwrap());
        prop_assert!((a.per_s - b.per_s).abs() < a.standard_error_per_s);
        prop_assert!((a.value - b.value).abs() < 0.1);
        prop_assert_eq!(after.anomalies, vec![place]);
    }

    #[test]
    fn the_order_of_the_readings_changes_nothing_while_all_pairs_are_taken(values in values()) {
        let samples = twice_a_day(values);
        let mut turned = samples.clone();
        turned.reverse();
        let (a, b) = (analysed(&samples), analysed(&turned));
        let line = |found: &Analysis| found.trend.map(|trend| [trend.per_s, trend.at_s, trend.value]);
        prop_assert_eq!(line(&a), line(&b));
        prop_assert_eq!(a.hour_offsets, b.hour_offsets);
        prop_assert_eq!(a.anomalies.len(), b.anomalies.len());
    }
}

#[test]
fn a_planted_drift_is_found_and_a_calm_reading_has_none() {
    let drift_per_day = 0.05;
    let drifting =
        analysed(&twice_a_day((0..120).map(|at| 5.0 + drift_per_day * at as f64 / 2.0 + noise(at))));
    let trend = drifting.trend.unwrap();
    assert!((trend.per_s * DAY_S - drift_per_day).abs() < 0.01, "{}", trend.per_s * DAY_S);
    assert!(drifting.is_trend_clear && drifting.anomalies.is_empty(), "{:?}", drifting.anomalies);
    let calm = analysed(&twice_a_day((0..120).map(|at| 5.0 + noise(at))));
    assert!(!calm.is_trend_clear, "{:?}", calm.trend);
}

#[test]
fn a_daily_cycle_is_no_anomaly_and_what_leaves_it_is_one() {
    // 12 °C at 11:00 and 24 °C at 15:00. Once the afternoon is as cool as the morning.
    let cycle = |at: usize| if at.is_multiple_of(2) { 12.0 } else { 24.0 };
    let planted = 61;
    let value = |at: usize| cycle(if at == planted { 0 } else { at }) + noise(at);
    let found = analysed(&twice_a_day((0..120).map(value)));
    assert_eq!(found.anomalies, [planted]);
    let difference = found.hour_offsets[15].unwrap() - found.hour_offsets[11].unwrap();
    assert!((difference - 12.0).abs() < 0.3, "{difference}");
    assert!(found.deviation < 0.6, "{}", found.deviation);
    assert!((found.expected(0.0, 15).unwrap() - 24.0).abs() < 0.4);
    // Five days are too few for offsets: both hours belong to the spread.
    let few = analysed(&twice_a_day((0..10).map(value)));
    assert_eq!(few.hour_offsets, [None; 24]);
    assert!(few.anomalies.is_empty());
}

#[test]
fn an_instrument_that_is_unsure_raises_no_alarm() {
    let mut samples = twice_a_day((0..40).map(|at| 1.0 + 0.1 * noise(at)));
    samples[20].value = 3.0;
    assert_eq!(analysed(&samples).anomalies, [20]);
    samples[20].standard_deviation = Some(1.0);
    assert!(analysed(&samples).anomalies.is_empty());
}

#[test]
fn few_readings_and_readings_that_are_no_numbers_are_told_apart_from_calm_ones() {
    assert_eq!(analyse(&[], &ReadingsConfig::default()), None);
    let mut samples = twice_a_day([1.0, 2.0, 9.0]);
    samples.push(Sample { value: f64::NAN, ..samples[0] });
    let few = analysed(&samples);
    assert_eq!((few.count, few.median, few.trend, few.anomalies.len()), (3, 2.0, None, 0));
    assert_eq!(few.range, [1.0, 9.0]);
    let one_time: Vec<Sample> = (0..10).map(|_| samples[0]).collect();
    assert_eq!(analysed(&one_time).trend, None, "all of one instant");
}

#[test]
fn a_reading_that_stood_still_and_moved_once_is_seen() {
    let found = analysed(&twice_a_day((0..40).map(|at| if at == 39 { 4.1 } else { 4.0 })));
    assert_eq!(found.anomalies, [39]);
    assert_eq!(robust_deviation(&[4.0; 40]), Some(0.0));
    assert_eq!(median(&[4.0; 40]), Some(4.0));
}

#[test]
fn thousands_of_readings_are_analysed_with_a_bounded_number_of_pairs() {
    let samples = twice_a_day((0..5_000).map(|at| 0.001 * at as f64 + noise(at)));
    let began = std::time::Instant::now();
    let found = analysed(&samples);
    println!("5,000 readings: {:.1} ms", began.elapsed().as_secs_f64() * 1e3);
    assert!((found.trend.unwrap().per_s * DAY_S - 0.002).abs() < 1e-4);
}
