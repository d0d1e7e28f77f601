//! The instant of a picture, apart from the simulation: rendering takes a quarter of a second, and the simulation goes on meanwhile.

use super::{CameraConfig, CameraImage, CameraScene, ThermalImage};
use crate::people::People;
use geometry::{Isometry, Rng, RngTree};
use vocab::CameraAim;

/// Where the robot and the people are at one instant, for pictures of it. They can be rendered on any thread.
#[derive(Clone, Debug)]
pub struct CameraSnapshot {
    pub(crate) cameras: CameraConfig,
    pub(crate) people: People,
    /// True pose of the base.
    pub(crate) site_from_base: Isometry,
    /// Time since the start of the simulation, for gauges, seconds.
    pub(crate) seconds: f64,
    pub(crate) rng: Rng,
}

impl CameraSnapshot {
    /// The instant of a robot that stands somewhere, alone on its site, without a simulation. `site_from_base`: its true pose; `seconds`: time for gauges; `seed`: of the noise.
    pub fn alone(site_from_base: Isometry, seconds: f64, seed: u64) -> Self {
        let rng = RngTree::new(seed).child("picture").rng();
        Self { cameras: CameraConfig::default(), people: People::default(), site_from_base, seconds, rng }
    }

    /// Renders a picture. The head goes to the nearest aim that it can take.
    pub fn picture(&mut self, scene: &CameraScene, aim: &CameraAim) -> CameraImage {
        let aim = self.cameras.clamped(aim);
        let intrinsics = self.cameras.intrinsics(aim.zoom);
        let site_from_camera = self.site_from_camera(&aim);
        scene.picture(&self.people, &site_from_camera, &intrinsics, self.seconds, &mut self.rng)
    }

    /// Renders a picture of temperatures, as [`Self::picture`]. It has no zoom.
    pub fn thermal_picture(&mut self, scene: &CameraScene, aim: &CameraAim) -> ThermalImage {
        let intrinsics = self.cameras.thermal_intrinsics();
        let site_from_camera = self.site_from_camera(&self.cameras.clamped(aim));
        scene.thermal_picture(&self.people, &site_from_camera, &intrinsics, self.seconds, &mut self.rng)
    }

    fn site_from_camera(&self, aim: &CameraAim) -> Isometry {
        self.site_from_base * self.cameras.base_from_camera(aim)
    }
}
