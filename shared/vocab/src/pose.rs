//! Plain vectors and poses in f64, metres and radians, for storage and transport.

use serde::{Deserialize, Serialize};

/// Three numbers. The field or variable states unit and frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "x, y and z need no description")]
pub struct Vec3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

impl Vec3 {
    /// From components.
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    /// As `[x, y, z]`.
    pub const fn to_array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }

    /// Whether no component is NaN or infinite.
    pub fn is_finite(self) -> bool {
        self.to_array().iter().all(|c| c.is_finite())
    }
}

impl From<[f64; 3]> for Vec3 {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

/// A unit quaternion, Hamilton convention, rotating child coordinates into the parent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the components of a quaternion need no description")]
pub struct Quat {
    pub w: f64,
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

impl Quat {
    /// No rotation.
    pub const IDENTITY: Self = Self { w: 1.0, x: 0.0, y: 0.0, z: 0.0 };
}

impl Default for Quat {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// Pose of a child frame in its parent. The variable's name states both: `map_from_base`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Origin of the child in the parent, metres.
    pub position: Vec3,
    /// Rotation of the child in the parent.
    pub orientation: Quat,
}

impl Pose {
    /// The pose of a child that coincides with its parent.
    pub const IDENTITY: Self = Self { position: Vec3::new(0.0, 0.0, 0.0), orientation: Quat::IDENTITY };
}

/// Velocity of a frame in its own coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Metres per second.
    pub linear: Vec3,
    /// Radians per second.
    pub angular: Vec3,
}

/// Covariance of a pose error, row major, order `[rotation (rad); translation (m)]`, perturbation on the
/// right: `parent_from_child * exp(error)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Covariance6(pub [[f64; 6]; 6]);

/// An axis-aligned box; empty while any `min` exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aabb {
    /// Least corner, metres.
    pub min: [f32; 3],
    /// Greatest corner, metres.
    pub max: [f32; 3],
}

impl Aabb {
    /// The empty box.
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// Extends the box to contain a point.
    pub fn include(&mut self, point: [f32; 3]) {
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(point[axis]);
            self.max[axis] = self.max[axis].max(point[axis]);
        }
    }
}

impl Default for Aabb {
    fn default() -> Self {
        Self::EMPTY
    }
}
