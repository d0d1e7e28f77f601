//! The cameras of the simulated robot: pictures of its site in visible light and of its temperatures.
//!
//! Both cameras sit on one head that pans and tilts. Pictures are ray-cast from the solids of the site and its people, with lamps, shadows, textures,
//! noise and exposure. A picture is taken from the true pose, and aimed by whoever asks. Plates on the walls give the cameras something to read: labels, gauges whose
//! needle is a value, and warm machines ([`Fixture`]). The LiDAR does not see them, because they are flat.
//!
//! - `optics`: the head, the pinhole model and zoom;
//! - `fixtures`, `faces`: what hangs on walls, and how it looks;
//! - `lamps`: where light comes from;
//! - `surfaces`: colour and temperature of what a ray hits;
//! - `render`: rays of a whole picture;
//! - `exposure`: from light to bytes;
//! - `snapshot`: the instant of a picture, which is rendered later.

mod exposure;
pub(crate) mod faces;
mod fixtures;
mod lamps;
mod optics;
mod render;
mod snapshot;
mod surfaces;
mod thermal;

pub use fixtures::{Face, Fixture, SimulatedQuantity};
pub use optics::{CameraConfig, Intrinsics, off_centre};
pub use snapshot::CameraSnapshot;
pub(crate) use surfaces::air_celsius;
pub use thermal::ThermalImage;

use crate::people::People;
use crate::site::SimulatedSite;
use geometry::{Isometry, Rng};
use lamps::{Lamps, Sun};
use std::sync::Arc;

/// A picture in visible light.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CameraImage {
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// sRGB, three bytes a pixel, row by row from the top left.
    pub rgb: Vec<u8>,
}

/// What both cameras see of a site, apart from its people: prepared once, shared by all pictures.
#[derive(Clone, Debug)]
pub struct CameraScene {
    site: Arc<SimulatedSite>,
    lamps: Lamps,
    fixtures: Vec<Fixture>,
    /// The numbers on each fixture.
    scale_numbers: Vec<Vec<faces::ScaleNumber>>,
}

impl CameraScene {
    /// Finds the lamps of a site, and hangs fixtures on the walls along its first route. The same site gets the same.
    pub fn new(site: Arc<SimulatedSite>) -> Self {
        let fixtures = fixtures::placed(&site);
        let scale_numbers = fixtures.iter().map(faces::scale_numbers).collect();
        Self { lamps: Lamps::of(&site), fixtures, scale_numbers, site }
    }

    /// The fixtures, in the order of the route.
    pub fn fixtures(&self) -> &[Fixture] {
        &self.fixtures
    }

    /// The same scene in other light. `level`: what the light of a lamp is multiplied with, by its place in the site frame, metres. `sun`: light of the sun relative to
    /// that of the lamps, and the direction to it, a unit vector; without effect under a roof.
    pub fn relit(&self, level: impl Fn([f32; 3]) -> f32, (strength, to_sun): (f32, [f32; 3])) -> Self {
        Self { lamps: self.lamps.relit(level, Sun { strength, to_sun }), ..self.clone() }
    }

    /// The same scene with another value on the gauge of that tag. None if there is no such gauge.
    pub fn with_reading(&self, tag: &str, value: SimulatedQuantity) -> Option<Self> {
        let mut scene = self.clone();
        let fixture = scene.fixtures.iter_mut().find(|fixture| fixture.tag == tag)?;
        let Face::Gauge { reading, .. } = &mut fixture.face else { return None };
        *reading = value;
        Some(scene)
    }

    /// The site.
    pub(crate) fn site(&self) -> &Arc<SimulatedSite> {
        &self.site
    }

    /// Takes a picture. `site_from_camera`: pose of the camera, x right, y down, z ahead. `seconds`: time since the start of the simulation, for gauges.
    pub(crate) fn picture(
        &self,
        people: &People,
        site_from_camera: &Isometry,
        intrinsics: &Intrinsics,
        seconds: f64,
        rng: &mut Rng,
    ) -> CameraImage {
        let grain = rng.bits() as u32;
        let view = render::CameraView { scene: self, people, site_from_camera, intrinsics, seconds, grain };
        let light = view.light();
        exposure::expose(&light, intrinsics, rng)
    }

    /// Takes a picture of temperatures, as [`Self::picture`].
    pub(crate) fn thermal_picture(
        &self,
        people: &People,
        site_from_camera: &Isometry,
        intrinsics: &Intrinsics,
        seconds: f64,
        rng: &mut Rng,
    ) -> ThermalImage {
        let view =
            render::CameraView { scene: self, people, site_from_camera, intrinsics, seconds, grain: 0 };
        thermal::measure(&view, rng)
    }
}
