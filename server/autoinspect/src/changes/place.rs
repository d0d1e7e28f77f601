//! A box in the result of `autoinspect changes`.

use changes::UprightBox;
use geometry::Isometry;
use serde::{Deserialize, Serialize};
use site_model::OrientedBox;
use vocab::Vec3;

/// A box that stands upright.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Place {
    pub centre_m: [f64; 3],
    pub size_m: [f64; 3],
    pub yaw_rad: f64,
}

impl Place {
    /// A box in the frame of the results. Its size and heading stay those of its own frame, in which it stands upright.
    pub(super) fn new(place: &UprightBox, frame_from_boxes: &Isometry) -> Self {
        let centre_m = frame_from_boxes * nalgebra::Point3::from(place.centre_m);
        Self { centre_m: centre_m.coords.into(), size_m: place.size_m, yaw_rad: place.yaw_rad }
    }

    pub(super) fn of_box(place: &OrientedBox) -> Self {
        Self { centre_m: place.centre_m.to_array(), size_m: place.size_m, yaw_rad: place.yaw_rad }
    }

    /// The same box.
    pub fn oriented_box(&self) -> OrientedBox {
        let [x, y, z] = self.centre_m;
        OrientedBox { centre_m: Vec3::new(x, y, z), size_m: self.size_m, yaw_rad: self.yaw_rad }
    }

    /// The same box.
    pub(super) fn upright_box(&self) -> UprightBox {
        UprightBox { centre_m: self.centre_m.into(), size_m: self.size_m, yaw_rad: self.yaw_rad }
    }
}
