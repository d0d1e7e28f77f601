//! Objects that stand loose on a site, and their changes between two visits.

use crate::shape::{Material, Shape, Solid};
use geometry::{Rotation, Vector3};

/// A box that stands on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LooseObject {
    /// Middle of its bottom, site frame, metres.
    pub foot: Vector3,
    /// Length, width and height, metres.
    pub size_m: [f64; 3],
    /// Heading of its length, radians.
    pub yaw_rad: f64,
    /// Its surface.
    pub material: Material,
}

/// A change of a site between two visits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectChange {
    /// An object was put.
    Put(LooseObject),
    /// An object was taken away.
    Taken(LooseObject),
    /// An object stands elsewhere.
    Moved {
        /// Before.
        from: LooseObject,
        /// After.
        to: LooseObject,
    },
    /// An object was turned where it stands.
    Turned {
        /// Before.
        from: LooseObject,
        /// After.
        to: LooseObject,
    },
}

impl LooseObject {
    /// Half of the diagonal of its footprint, metres.
    pub(crate) fn reach_m(&self) -> f64 {
        self.size_m[0].hypot(self.size_m[1]) / 2.0
    }

    /// Its solid.
    pub(super) fn solid(&self) -> Solid {
        let [length, width, height] = self.size_m;
        let shape = Shape::OrientedBox {
            center: self.middle(),
            half: Vector3::new(length, width, height) / 2.0,
            site_from_box: Rotation::from_euler_angles(0.0, 0.0, self.yaw_rad),
        };
        Solid { shape, material: self.material }
    }

    /// Its middle, site frame, metres.
    pub fn middle(&self) -> Vector3 {
        self.foot + Vector3::z() * (self.size_m[2] / 2.0)
    }
}
