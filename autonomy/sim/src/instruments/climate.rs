//! The air of a site: warmer under the ceiling and beside warm machines, with a slow swing over the day, and one amount of water everywhere.

use crate::camera::{Face, Fixture, air_celsius};
use geometry::{Rng, Vector3};
use std::f64::consts::TAU;

/// Share of a machine's excess temperature that the air beside it has.
const HEATED_SHARE: f64 = 0.06;
/// How far a machine heats the air, metres: standard deviation of a bell.
const HEATED_M: f64 = 1.5;
/// The temperature swings by this over a day, kelvin.
const SWING_K: f64 = 1.2;
/// Period of that swing, seconds.
const DAY_S: f64 = 86_400.0;
/// Water in the air, grams a cubic metre: 46 % at 20 degrees.
const WATER_G_PER_M3: f64 = 8.0;
/// Standard deviation of a measured temperature, kelvin (SHT35).
const TEMPERATURE_NOISE_K: f64 = 0.1;
/// Standard deviation of a measured relative humidity, percent (SHT35).
const HUMIDITY_NOISE_PERCENT: f64 = 0.8;

/// Temperature and humidity of the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirReading {
    /// Degrees Celsius.
    pub celsius: f64,
    /// Relative humidity, percent.
    pub humidity_percent: f64,
}

/// The air of a site.
#[derive(Clone, Debug)]
pub(super) struct Climate {
    /// Place and temperature of warm machines, site frame, metres, degrees Celsius.
    machines: Vec<(Vector3, f64)>,
}

impl Climate {
    pub(super) fn new(fixtures: &[Fixture]) -> Self {
        let machines = fixtures.iter().filter_map(|fixture| match fixture.face {
            Face::Warm { celsius } => Some((fixture.site_from_plate.translation.vector, celsius)),
            _ => None,
        });
        Self { machines: machines.collect() }
    }

    /// The true state of the air at a point, site frame, metres. `seconds`: time since the start of the simulation.
    pub(super) fn at(&self, point: &Vector3, seconds: f64) -> AirReading {
        let still = f64::from(air_celsius([0, 1, 2].map(|axis| point[axis] as f32)));
        let still = still + SWING_K * (TAU * seconds / DAY_S).sin();
        let heated = self.machines.iter().map(|(place, celsius)| {
            let bell = (-0.5 * (point - place).norm_squared() / (HEATED_M * HEATED_M)).exp();
            HEATED_SHARE * (celsius - still) * bell
        });
        let celsius = still + heated.sum::<f64>();
        AirReading { celsius, humidity_percent: (100.0 * WATER_G_PER_M3 / saturated(celsius)).min(100.0) }
    }

    pub(super) fn measure(&self, point: &Vector3, seconds: f64, rng: &mut Rng) -> AirReading {
        let truth = self.at(point, seconds);
        let humidity = truth.humidity_percent + HUMIDITY_NOISE_PERCENT * rng.normal();
        AirReading {
            celsius: truth.celsius + TEMPERATURE_NOISE_K * rng.normal(),
            humidity_percent: humidity.clamp(0.0, 100.0),
        }
    }
}

/// Water that air of this temperature can hold, grams a cubic metre (Magnus' formula and the law of ideal gases).
fn saturated(celsius: f64) -> f64 {
    let pascal = 611.2 * (17.62 * celsius / (243.12 + celsius)).exp();
    // 18.015 g/mol of water, gas constant 8.314 J/(mol K).
    pascal * 18.015 / (8.314 * (celsius + 273.15))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    #[test]
    fn air_is_warmer_and_drier_beside_a_machine_and_under_the_ceiling() {
        let machine = (Vector3::new(3.0, 0.0, 1.0), 80.0);
        let climate = Climate { machines: vec![machine] };
        let far = climate.at(&Vector3::new(30.0, 0.0, 1.0), 0.0);
        let beside = climate.at(&Vector3::new(3.0, 0.5, 1.0), 0.0);
        let above = climate.at(&Vector3::new(30.0, 0.0, 5.0), 0.0);
        assert!((far.celsius - 20.4).abs() < 0.01 && (far.humidity_percent - 45.0).abs() < 2.0, "{far:?}");
        assert!(beside.celsius - far.celsius > 3.0 && beside.humidity_percent < far.humidity_percent - 5.0);
        assert!(above.celsius - far.celsius > 1.5 && above.humidity_percent < far.humidity_percent);
        let afternoon = climate.at(&Vector3::new(30.0, 0.0, 1.0), 21_600.0);
        assert!((afternoon.celsius - far.celsius - 1.2).abs() < 0.01);
    }

    #[test]
    fn measurements_scatter_round_the_truth() {
        let climate = Climate { machines: Vec::new() };
        let (point, mut rng) = (Vector3::zeros(), RngTree::new(1).rng());
        let measured: Vec<f64> =
            (0..4000).map(|_| climate.measure(&point, 0.0, &mut rng).celsius - 20.0).collect();
        let mean = measured.iter().sum::<f64>() / 4000.0;
        let deviation = (measured.iter().map(|m| m * m).sum::<f64>() / 4000.0).sqrt();
        assert!(mean.abs() < 0.01 && (deviation - 0.1).abs() < 0.01, "{mean} {deviation}");
    }
}
