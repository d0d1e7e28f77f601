//! Names of variables and factors, and the kinds of variables. Everything else in the crate refers to them, errors included.

use std::fmt;

/// Identifies a variable: its index in [`Values`](crate::Values).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(pub u32);

impl Key {
    /// As an index.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Kind of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableKind {
    /// SE(2), error `[x; y; yaw]` in its own frame: `(t + R v, R exp(w))`.
    Planar,
    /// SE(3), error `[rotation; translation]` in its own frame: `(R exp(w), t + R v)`.
    Pose,
    /// A vector in the plane: landmark.
    Vector2,
    /// A vector in space: velocity, landmark, gravity.
    Vector3,
    /// Six numbers: gyroscope and accelerometer bias.
    Vector6,
}

impl VariableKind {
    /// Length of the error vector.
    pub const fn dimension(self) -> usize {
        match self {
            Self::Vector2 => 2,
            Self::Planar | Self::Vector3 => 3,
            Self::Pose | Self::Vector6 => 6,
        }
    }
}

/// Identifies a factor: its index in the graph. A removed factor's id is not used again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FactorId(pub u32);

impl FactorId {
    /// As an index.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for FactorId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
