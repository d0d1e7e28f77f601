//! Gamma sources and the spectrum that a scintillation counter of 2 by 2 inches (NaI) has of them.
//!
//! Each line of a source gives a peak and the Compton continuum below it. Their rates fall with the square of the distance and with what solids take on the way. What is
//! scattered on the way is left out, so a shielded source is only weaker. Background: natural gamma with the lines of potassium and thallium.

use super::shielding::optical_depth;
use crate::bvh::Bvh;
use crate::camera::{Face, Fixture};
use geometry::{Isometry, Vector3};
use nalgebra::Point3;
use std::f64::consts::{PI, TAU};

/// Energy for which the numbers of the detector are given, keV: the line of caesium.
const REFERENCE_KEV: f64 = 661.7;
/// Energy of an electron at rest, keV.
const ELECTRON_KEV: f64 = 511.0;
/// Gamma below this is absorbed before it reaches the crystal, keV.
const THRESHOLD_KEV: f64 = 30.0;
/// A source sits this far out of its plate, metres.
const SOURCE_OUT_M: f64 = 0.01;
/// The detector comes no nearer to a source than this, metres.
const MIN_DISTANCE_M: f64 = 0.05;
/// Full width of a peak at half of its height in standard deviations.
const FULL_WIDTH: f64 = 2.354_82;
/// Of three warm machines one is contaminated with the first of these, and one with the second, becquerel.
const ACTIVITIES: [(Nuclide, f64); 2] = [(Nuclide::Caesium137, 8e6), (Nuclide::Cobalt60, 2e6)];

/// A line of gamma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GammaLine {
    /// Its energy, keV.
    pub kev: f64,
    /// Photons of it for each decay.
    pub photons: f64,
}

/// What decays in a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nuclide {
    /// Of spent fuel.
    Caesium137,
    /// Of steel that was in a neutron flux.
    Cobalt60,
}

impl Nuclide {
    /// Its strong lines (ENSDF).
    pub fn lines(self) -> &'static [GammaLine] {
        match self {
            Self::Caesium137 => &[GammaLine { kev: 661.7, photons: 0.851 }],
            Self::Cobalt60 => {
                &[GammaLine { kev: 1173.2, photons: 0.9985 }, GammaLine { kev: 1332.5, photons: 0.9998 }]
            }
        }
    }
}

/// A point-like source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GammaSource {
    /// Site frame, metres.
    pub position_m: Vector3,
    /// What decays.
    pub nuclide: Nuclide,
    /// Decays a second.
    pub activity_bq: f64,
}

/// The detector and the natural background. Values: a NaI crystal of 2 by 2 inches (Knoll, *Radiation Detection and Measurement*).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GammaConfig {
    /// Channels of a spectrum. Chosen: the usual number of spectrometers with such crystals.
    pub channels: usize,
    /// Width of a channel, keV. The first one begins at 0. Chosen: the spectrum ends at 3 MeV, above the highest line of the background.
    pub channel_kev: f64,
    /// Middle of the crystal, metres, frame of the base. Chosen: on the back of the robot.
    pub base_from_detector_m: [f64; 3],
    /// Area that a source sees, square metres. Source: the crystal from the front, a circle of 2 inches.
    pub area_m2: f64,
    /// Attenuation of the crystal at 662 keV times its length. Source: the crystal and Knoll's book.
    pub crystal_depth: f64,
    /// Share of the events at 662 keV that are in the peak. It falls with the energy. Source: the crystal and Knoll's book.
    pub peak_share: f64,
    /// Full width at half maximum of the peak at 662 keV, as a share of its energy. Source: the crystal and Knoll's book.
    pub resolution: f64,
    /// Events a second of the natural background, without its lines. Chosen: the order of magnitude of such a crystal indoors.
    pub background_per_s: f64,
    /// Its lines: energy, keV, and events a second in the peak. Source of the energies: potassium 40 and thallium 208. The rates are chosen.
    pub background_lines: [(f64, f64); 2],
    /// The background falls by a factor of e over this energy, keV. Chosen: most of the background is below 500 keV.
    pub background_kev: f64,
}

impl Default for GammaConfig {
    fn default() -> Self {
        Self {
            channels: 1024,
            channel_kev: 3.0,
            base_from_detector_m: [0.1, 0.0, 0.2],
            area_m2: 2.03e-3,
            crystal_depth: 1.43,
            peak_share: 0.4,
            resolution: 0.07,
            background_per_s: 110.0,
            background_lines: [(1460.8, 2.2), (2614.5, 0.7)],
            background_kev: 280.0,
        }
    }
}

impl GammaConfig {
    /// Where the crystal is, site frame, metres.
    pub(super) fn detector_in_site(&self, site_from_base: &Isometry) -> Vector3 {
        (site_from_base * Point3::from(Vector3::from(self.base_from_detector_m))).coords
    }

    /// Adds a peak of `per_s` events a second.
    fn add_peak(&self, kev: f64, per_s: f64, rates: &mut [f64]) {
        // Light of a scintillator scatters with the root of the energy.
        let deviation = self.resolution * (REFERENCE_KEV * kev).sqrt() / FULL_WIDTH;
        for (channel, rate) in rates.iter_mut().enumerate() {
            let offset = (self.middle_kev(channel) - kev) / deviation;
            *rate += per_s * self.channel_kev * (-0.5 * offset * offset).exp() / (deviation * TAU.sqrt());
        }
    }

    /// Adds the peak and the continuum of `photons_per_s` that reach the crystal.
    fn add_line(&self, kev: f64, photons_per_s: f64, rates: &mut [f64]) {
        let events = photons_per_s * (1.0 - (-self.crystal_depth * (REFERENCE_KEV / kev).sqrt()).exp());
        let in_peak = self.peak_share * (REFERENCE_KEV / kev).powf(0.85).min(2.0);
        self.add_peak(kev, events * in_peak, rates);
        // Energy of an electron that is hit head-on.
        let edge = kev * 2.0 * kev / (ELECTRON_KEV + 2.0 * kev);
        let per_channel = events * (1.0 - in_peak) * self.channel_kev / (edge - THRESHOLD_KEV);
        for (channel, rate) in rates.iter_mut().enumerate() {
            if (THRESHOLD_KEV..edge).contains(&self.middle_kev(channel)) {
                *rate += per_channel;
            }
        }
    }

    fn middle_kev(&self, channel: usize) -> f64 {
        (channel as f64 + 0.5) * self.channel_kev
    }
}

/// The sources of a site, and the detector that counts them.
#[derive(Clone, Debug, Default)]
pub struct GammaField {
    config: GammaConfig,
    sources: Vec<GammaSource>,
}

impl GammaField {
    /// These sources.
    pub fn new(config: GammaConfig, sources: Vec<GammaSource>) -> Self {
        Self { config, sources }
    }

    /// Contaminated warm machines.
    pub(super) fn of_fixtures(fixtures: &[Fixture]) -> Self {
        let machines = fixtures.iter().filter(|fixture| matches!(fixture.face, Face::Warm { .. }));
        let sources = machines.enumerate().filter_map(|(number, machine)| {
            let (nuclide, activity_bq) = *ACTIVITIES.get(number % 3)?;
            let outward = machine.site_from_plate.rotation * Vector3::z();
            let position_m = machine.site_from_plate.translation.vector + outward * SOURCE_OUT_M;
            Some(GammaSource { position_m, nuclide, activity_bq })
        });
        Self::new(GammaConfig::default(), sources.collect())
    }

    /// The detector.
    pub fn config(&self) -> &GammaConfig {
        &self.config
    }

    /// The sources.
    pub fn sources(&self) -> &[GammaSource] {
        &self.sources
    }

    /// Events a second in each channel with the detector at this point, site frame, metres, among these solids.
    pub fn rates(&self, bvh: &Bvh, detector: &Vector3) -> Vec<f64> {
        let config = &self.config;
        let mut rates = vec![0.0; config.channels];
        for source in &self.sources {
            let distance = (detector - source.position_m).norm().max(MIN_DISTANCE_M);
            let share = config.area_m2 / (4.0 * PI * distance * distance);
            for line in source.nuclide.lines() {
                let passes = (-optical_depth(bvh, &source.position_m, detector, line.kev)).exp();
                config.add_line(line.kev, source.activity_bq * line.photons * share * passes, &mut rates);
            }
        }
        let scale = config.background_per_s * config.channel_kev / config.background_kev;
        for (channel, rate) in rates.iter_mut().enumerate() {
            let kev = config.middle_kev(channel);
            if kev >= THRESHOLD_KEV {
                *rate += scale * (-(kev - THRESHOLD_KEV) / config.background_kev).exp();
            }
        }
        for (kev, per_s) in config.background_lines {
            config.add_peak(kev, per_s, &mut rates);
        }
        rates
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Material, Shape, Solid};

    /// Rates without background, of a source of caesium at the origin.
    fn caesium_rates(solids: &[Solid], detector: Vector3) -> Vec<f64> {
        let source =
            GammaSource { position_m: Vector3::zeros(), nuclide: Nuclide::Caesium137, activity_bq: 1e6 };
        let config = GammaConfig {
            background_per_s: 0.0,
            background_lines: [(1.0, 0.0); 2],
            ..GammaConfig::default()
        };
        GammaField::new(config, vec![source]).rates(&Bvh::new(solids), &detector)
    }

    fn total(rates: &[f64]) -> f64 {
        rates.iter().sum()
    }

    #[test]
    fn the_rate_falls_with_the_square_of_the_distance_and_is_that_of_the_geometry() {
        let near = total(&caesium_rates(&[], Vector3::new(1.0, 0.0, 0.0)));
        let far = total(&caesium_rates(&[], Vector3::new(0.0, 4.0, 0.0)));
        // The air takes 0.94 % a metre.
        assert!((near / far / 16.0 - (0.0094_f64 * 3.0).exp()).abs() < 1e-6, "{near} {far}");
        // 1e6/s, 0.851 photons, 20.3 cm² of a sphere of 1 m, three quarters interact.
        let expected = 1e6 * 0.851 * 2.03e-3 / (4.0 * PI) * (1.0 - (-1.43_f64).exp()) * (-0.0094_f64).exp();
        assert!((near / expected - 1.0).abs() < 0.01, "{near} {expected}");
    }

    #[test]
    fn a_wall_of_concrete_shields_as_its_attenuation_says() {
        let wall = Solid {
            shape: Shape::AlignedBox { min: Vector3::new(0.5, -2.0, -2.0), max: Vector3::new(0.7, 2.0, 2.0) },
            material: Material::Concrete,
        };
        let free = total(&caesium_rates(&[], Vector3::new(2.0, 0.0, 0.0)));
        let shielded = total(&caesium_rates(&[wall], Vector3::new(2.0, 0.0, 0.0)));
        let beside = total(&caesium_rates(&[wall], Vector3::new(-2.0, 0.0, 0.0)));
        assert!(((free / shielded).ln() - 0.2 * 17.5).abs() < 1e-6, "{free} {shielded}");
        assert!((beside - free).abs() < 1e-9);
    }

    #[test]
    fn the_peak_has_its_energy_and_its_width() {
        let rates = caesium_rates(&[], Vector3::new(1.0, 0.0, 0.0));
        let peak: Vec<(f64, f64)> = rates
            .iter()
            .enumerate()
            .map(|(channel, rate)| ((channel as f64 + 0.5) * 3.0, *rate))
            .filter(|(kev, _)| (560.0..780.0).contains(kev))
            .collect();
        let top = peak.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert!((top.0 - 661.7).abs() < 3.0);
        let above_half = peak.iter().filter(|(_, rate)| *rate > 0.5 * top.1).count() as f64 * 3.0;
        assert!((above_half - 0.07 * 661.7).abs() < 4.0, "{above_half} keV wide");
        // The continuum ends at 477 keV, where nothing is until the peak.
        let at = |kev: f64| rates[(kev / 3.0) as usize];
        assert!(at(440.0) > 20.0 * at(520.0), "{} {}", at(440.0), at(520.0));
    }
}
