//! How thick a plane of the local map may be, by the noise of the LiDAR that is used.
//!
//! A cube of half a metre on the border between a floor and a wall holds the floor and the foot of the wall. With a thickness of several times the noise it is one plane, tilted by
//! centiradians, and scans that see other parts of it are pulled up and tilted. With a thickness of less than the noise, hardly any cube is a plane. So the thickness follows the noise, which is
//! measured: the deviation of registered points from planes (docs/maths/odometry.md, equation 13a).

/// Parameters of a [`PlaneThickness`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneThicknessConfig {
    /// Thickness as a multiple of the deviation of points from planes. Chosen: two standard deviations; docs/benchmarks/sites.md has others.
    pub deviations: f64,
    /// Least thickness, metres. Chosen: as [`registration::MatchingConfig::noise_m`]; floors and walls are not flatter.
    pub min_m: f64,
    /// Share of the latest scan in the running mean of the deviation. Chosen: two seconds at 10 Hz, so that one scan decides nothing.
    pub learning_rate: f64,
}

impl Default for PlaneThicknessConfig {
    fn default() -> Self {
        Self { deviations: 2.0, min_m: 0.01, learning_rate: 0.05 }
    }
}

/// The thickness of planes, from the deviations of scans that fitted the map.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlaneThickness {
    /// Running mean of the deviation, metres; none before the first scan.
    deviation_m: Option<f64>,
}

impl PlaneThickness {
    /// The thickness after a scan whose points deviate this much from planes, metres: at most `max_m`, which is also that of a sensor of which nothing is known.
    pub fn update(&mut self, deviation_m: f64, max_m: f32, config: &PlaneThicknessConfig) -> f32 {
        let mean_m = self
            .deviation_m
            .map_or(deviation_m, |mean_m| mean_m + config.learning_rate * (deviation_m - mean_m));
        self.deviation_m = Some(mean_m);
        ((config.deviations * mean_m).max(config.min_m) as f32).min(max_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thickness_follows_the_noise_between_its_bounds() {
        let config = PlaneThicknessConfig::default();
        let after = |deviations_m: &[f64]| {
            let mut thickness = PlaneThickness::default();
            deviations_m.iter().fold(f32::NAN, |_, deviation_m| thickness.update(*deviation_m, 0.03, &config))
        };
        assert_eq!(after(&[0.007]), 0.014);
        assert_eq!(after(&[0.0]), 0.01);
        assert_eq!(after(&[0.04]), 0.03);
        let after_a_peak = after(&[0.007, 0.012]);
        assert!((0.0144..0.0146).contains(&after_a_peak), "{after_a_peak}");
        let long_after_a_peak = after(&[vec![0.012], vec![0.007; 100]].concat());
        assert!((0.014..0.0141).contains(&long_after_a_peak), "{long_after_a_peak}");
    }
}
