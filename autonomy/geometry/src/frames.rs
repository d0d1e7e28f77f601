//! Rigid transforms whose type says which frame they are in and which they place.

use crate::{Isometry, Vector3};
use std::fmt;
use std::marker::PhantomData;
use std::ops::Mul;

macro_rules! frames {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        $( $(#[$doc])* #[derive(Clone, Copy, Debug, PartialEq, Eq)] pub enum $name {} )*
    };
}

frames! {
    /// The map of a session: z up, origin where it began.
    Map,
    /// Smooth but drifting frame of an odometry.
    Odom,
    /// The robot's body: x forward, y left, z up.
    Base,
    /// The LiDAR.
    Lidar,
    /// The inertial unit.
    Imu,
}

/// Where frame `Child` is, seen from frame `Parent`. `map_from_base * base_from_lidar` compiles, the reverse does not.
pub struct Transform<Parent, Child> {
    iso: Isometry,
    frames: PhantomData<fn(Child) -> Parent>,
}

impl<Parent, Child> Transform<Parent, Child> {
    /// The frames coincide.
    pub fn identity() -> Self {
        Self::new(Isometry::identity())
    }

    /// Declares that `iso` places `Child` in `Parent`.
    pub const fn new(iso: Isometry) -> Self {
        Self { iso, frames: PhantomData }
    }

    /// Without frames.
    pub const fn isometry(&self) -> &Isometry {
        &self.iso
    }

    /// The other way round.
    pub fn inverse(&self) -> Transform<Child, Parent> {
        Transform::new(self.iso.inverse())
    }

    /// A point of `Child` in `Parent`, metres.
    pub fn point(&self, point_in_child: &Vector3) -> Vector3 {
        self.iso.rotation * point_in_child + self.iso.translation.vector
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
        self.iso.fmt(f)
    }
}

impl<Parent, Child> PartialEq for Transform<Parent, Child> {
    fn eq(&self, other: &Self) -> bool {
        self.iso == other.iso
    }
}

impl<A, B, C> Mul<Transform<B, C>> for Transform<A, B> {
    type Output = Transform<A, C>;
    fn mul(self, rhs: Transform<B, C>) -> Transform<A, C> {
        Transform::new(self.iso * rhs.iso)
    }
}
