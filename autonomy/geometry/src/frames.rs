//! Rigid transforms that carry their two frames in their type.
//!
//! Used where a mistaken frame is most likely: the mounting poses of the sensors, which come from configuration files.

use crate::Isometry;
use std::fmt;
use std::marker::PhantomData;
use std::ops::Mul;

macro_rules! frames {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        $( $(#[$doc])* #[derive(Clone, Copy, Debug, PartialEq, Eq)] pub enum $name {} )*
    };
}

frames! {
    /// The robot's base: x forward, y left, z up.
    Base,
    /// The frame that the odometry estimates: the IMU, or the base of a robot without an IMU.
    Body,
    /// The LiDAR.
    Lidar,
    /// The inertial measurement unit.
    Imu,
    /// The frame whose pose an external odometry reports.
    External,
}

/// Pose of frame `Child` in frame `Parent`: `body_from_base * base_from_lidar` compiles, the reverse order does not.
pub struct Transform<Parent, Child> {
    isometry: Isometry,
    frames: PhantomData<fn(Child) -> Parent>,
}

impl<Parent, Child> Transform<Parent, Child> {
    /// Both frames coincide.
    pub fn identity() -> Self {
        Self::new(Isometry::identity())
    }

    /// States that `isometry` is the pose of `Child` in `Parent`.
    pub const fn new(isometry: Isometry) -> Self {
        Self { isometry, frames: PhantomData }
    }

    /// The transform without its frames.
    pub const fn isometry(&self) -> &Isometry {
        &self.isometry
    }

    /// Pose of `Parent` in `Child`.
    pub fn inverse(&self) -> Transform<Child, Parent> {
        Transform::new(self.isometry.inverse())
    }
}

impl<Parent, Child> Clone for Transform<Parent, Child> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<Parent, Child> Copy for Transform<Parent, Child> {}

impl<Parent, Child> fmt::Debug for Transform<Parent, Child> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.isometry.fmt(f)
    }
}

impl<Parent, Child> PartialEq for Transform<Parent, Child> {
    fn eq(&self, other: &Self) -> bool {
        self.isometry == other.isometry
    }
}

impl<A, B, C> Mul<Transform<B, C>> for Transform<A, B> {
    type Output = Transform<A, C>;
    fn mul(self, rhs: Transform<B, C>) -> Transform<A, C> {
        Transform::new(self.isometry * rhs.isometry)
    }
}
