//! The cameras of the simulated robot: pictures of its site in visible light and of its temperatures.
//!
//! Both cameras sit on one head that pans and tilts. Pictures are ray-cast from the solids of the site and its people, with lamps, shadows, textures,
//! noise and exposure. A picture is taken from the true pose, and aimed by whoever asks. Plates on the walls give the cameras something to read: labels, gauges whose
//! needle is a value, and warm machines ([`Fixture`]). The LiDAR does not see them, because they are flat.
//!
//! - `optics`: the head, the pinhole model and zoom;
//! - `fixtures`, `faces`: what hangs on walls, and how it looks;
//! - `out_of_order`, `leaks`: what is not in its usual condition;
//! - `lamps`: where light comes from;
//! - `surfaces`: colour and temperature of what a ray hits;
//! - `render`: rays of a whole picture;
//! - `exposure`: from light to bytes;
//! - `snapshot`: the instant of a picture, which is rendered later.

mod exposure;
pub(crate) mod faces;
mod fixtures;
mod lamps;
mod leaks;
mod optics;
mod out_of_order;
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
use crate::site::{ConditionChange, Leak, SimulatedSite};
use geometry::{Isometry, Rng};
use lamps::{Lamps, Sun};
use std::sync::Arc;
use vocab::Vec3;

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
    leaks: Vec<Leak>,
}

impl CameraScene {
    /// Finds the lamps of a site, and hangs fixtures on the walls along its first route. The same site gets the same, in whatever condition it is.
    pub fn new(site: Arc<SimulatedSite>) -> Self {
        let fixtures = out_of_order::changed(fixtures::placed(site.usual()), &site);
        let scale_numbers = fixtures.iter().map(faces::scale_numbers).collect();
        let mut scene =
            Self { lamps: Lamps::of(site.usual()), fixtures, scale_numbers, leaks: Vec::new(), site };
        for change in scene.site.condition_changes() {
            match change {
                ConditionChange::Leak(leak) => scene.leaks.push(*leak),
                ConditionChange::LampOut { lamp } => {
                    scene.lamps = scene.lamps.without(lamp.to_array().map(|c| c as f32));
                }
                _ => {}
            }
        }
        scene
    }

    /// Where the lamps are that give light, site frame, metres to a tenth of a millimetre, in a fixed order.
    pub fn lamps(&self) -> Vec<Vec3> {
        let wide = |position: [f32; 3]| position.map(|c| (f64::from(c) * 1e4).round() / 1e4);
        self.lamps.positions().into_iter().map(wide).map(|[x, y, z]| Vec3::new(x, y, z)).collect()
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

    /// The light of each pixel before it is exposed, without people and at the start of the simulation.
    #[cfg(test)]
    pub(crate) fn light(&self, site_from_camera: &Isometry, intrinsics: &Intrinsics) -> Vec<[f32; 3]> {
        let people = &People::default();
        render::CameraView { scene: self, people, site_from_camera, intrinsics, seconds: 0.0, grain: 1 }
            .light()
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
