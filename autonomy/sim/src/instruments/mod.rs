//! Instruments of the simulated robot besides LiDAR and cameras, read on request: temperature and humidity of the air, and a gamma spectrometer.
//!
//! - `climate`: the air of a site;
//! - `gamma`: sources, the spectrum that a detector counts, and its background;
//! - `shielding`: how much of the solids of a site a ray of gamma passes;
//! - `poisson`: random counts.

mod climate;
mod gamma;
mod poisson;
mod shielding;

pub use climate::AirReading;
pub use gamma::{GammaConfig, GammaField, GammaLine, GammaSource, Nuclide};

use crate::camera::CameraScene;
use crate::site::SimulatedSite;
use climate::Climate;
use geometry::{Isometry, Rng};
use std::sync::Arc;

/// What the instruments sense of a site. It never changes; all readings share it.
#[derive(Clone, Debug)]
pub struct InstrumentEnvironment {
    site: Arc<SimulatedSite>,
    climate: Climate,
    gamma: GammaField,
}

impl InstrumentEnvironment {
    /// Warm machines heat the air, and some of them are contaminated. The same site gets the same.
    pub fn new(scene: &CameraScene) -> Self {
        let fixtures = scene.fixtures();
        Self {
            site: Arc::clone(scene.site()),
            climate: Climate::new(fixtures),
            gamma: GammaField::of_fixtures(fixtures),
        }
    }

    /// The gamma sources of the site.
    pub fn gamma(&self) -> &GammaField {
        &self.gamma
    }
}

/// Where the robot is at one instant, for readings of its instruments. They can be made on any thread.
#[derive(Clone, Debug)]
pub struct InstrumentSnapshot {
    /// True pose of the base.
    pub(crate) site_from_base: Isometry,
    /// Time since the start of the simulation, seconds.
    pub(crate) seconds: f64,
    pub(crate) rng: Rng,
}

impl InstrumentSnapshot {
    /// Temperature and humidity of the air at the robot.
    pub fn air(&mut self, surroundings: &InstrumentEnvironment) -> AirReading {
        surroundings.climate.measure(&self.site_from_base.translation.vector, self.seconds, &mut self.rng)
    }

    /// Adds the events of some seconds to a spectrum, which has one number for each channel.
    pub fn count_gamma(&mut self, surroundings: &InstrumentEnvironment, seconds: f64, counts: &mut [u32]) {
        let field = &surroundings.gamma;
        let detector = field.config().detector_in_site(&self.site_from_base);
        let rates = field.rates(surroundings.site.bvh(), &detector);
        for (count, rate) in counts.iter_mut().zip(rates) {
            // A channel has 32 bits, as those of spectrometers have.
            let events = poisson::draw(rate * seconds.max(0.0), &mut self.rng);
            *count = count.saturating_add(u32::try_from(events).unwrap_or(u32::MAX));
        }
    }
}
