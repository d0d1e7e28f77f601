//! Variables: their kinds, their estimates, and how an error vector moves them.

use crate::error::FactorError;
use crate::names::{Key, VariableKind};
use geometry::{Isometry, Matrix6, Vector3, Vector6, se3, so3};
use nalgebra::{Isometry2, UnitComplex, Vector2};

/// A pose in the plane.
pub type Planar = Isometry2<f64>;

/// A variable's estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// See [`VariableKind::Planar`].
    Planar(Planar),
    /// See [`VariableKind::Pose`].
    Pose(Isometry),
    /// See [`VariableKind::Vector2`].
    Vector2(Vector2<f64>),
    /// See [`VariableKind::Vector3`].
    Vector3(Vector3),
    /// See [`VariableKind::Vector6`].
    Vector6(Vector6),
}

impl Value {
    /// The kind of this value.
    pub const fn kind(&self) -> VariableKind {
        match self {
            Self::Planar(_) => VariableKind::Planar,
            Self::Pose(_) => VariableKind::Pose,
            Self::Vector2(_) => VariableKind::Vector2,
            Self::Vector3(_) => VariableKind::Vector3,
            Self::Vector6(_) => VariableKind::Vector6,
        }
    }

    /// This value moved by an error vector of the kind's dimension (docs/maths/factors.md, equations 1 and 2). Missing components count as zero.
    #[must_use]
    pub fn retract(&self, error: &[f64]) -> Self {
        let at = |index: usize| error.get(index).copied().unwrap_or(0.0);
        match self {
            Self::Planar(pose) => Self::Planar(retract_planar(pose, [at(0), at(1), at(2)])),
            Self::Pose(pose) => {
                let mut moved = se3::retract(pose, &Vector6::from_fn(|row, _| at(row)));
                moved.rotation.renormalize_fast();
                Self::Pose(moved)
            }
            Self::Vector2(vector) => Self::Vector2(vector + Vector2::new(at(0), at(1))),
            Self::Vector3(vector) => Self::Vector3(vector + Vector3::new(at(0), at(1), at(2))),
            Self::Vector6(vector) => Self::Vector6(vector + Vector6::from_fn(|row, _| at(row))),
        }
    }

    /// The error with which [`Self::retract`] reaches `other`, in the first `dimension` components. Zero if the kinds differ.
    pub fn local(&self, other: &Self) -> Vector6 {
        let mut error = Vector6::zeros();
        match (self, other) {
            (Self::Planar(from), Self::Planar(to)) => {
                let delta = from.inverse() * to;
                error[0] = delta.translation.x;
                error[1] = delta.translation.y;
                error[2] = delta.rotation.angle();
            }
            (Self::Pose(from), Self::Pose(to)) => error = se3::local(from, to),
            (Self::Vector2(from), Self::Vector2(to)) => {
                error.fixed_rows_mut::<2>(0).copy_from(&(to - from));
            }
            (Self::Vector3(from), Self::Vector3(to)) => {
                error.fixed_rows_mut::<3>(0).copy_from(&(to - from));
            }
            (Self::Vector6(from), Self::Vector6(to)) => error = to - from,
            _ => {}
        }
        error
    }

    /// Derivative of `self.local(other)` with respect to an error that moves `other`. Only the first `dimension` rows and columns are used.
    pub fn local_jacobian(&self, other: &Self) -> Matrix6 {
        let mut jacobian = Matrix6::identity();
        match (self, other) {
            (Self::Planar(from), Self::Planar(to)) => {
                let turn = (from.rotation.inverse() * to.rotation).to_rotation_matrix();
                jacobian.fixed_view_mut::<2, 2>(0, 0).copy_from(turn.matrix());
            }
            (Self::Pose(from), Self::Pose(to)) => {
                let turn = from.rotation.inverse() * to.rotation;
                let by_turn = so3::right_jacobian_inverse(&so3::log(&turn));
                jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_turn);
                jacobian.fixed_view_mut::<3, 3>(3, 3).copy_from(turn.to_rotation_matrix().matrix());
            }
            _ => {}
        }
        jacobian
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Planar(pose) => {
                pose.translation.vector.iter().all(|v| v.is_finite())
                    && pose.rotation.re.is_finite()
                    && pose.rotation.im.is_finite()
            }
            Self::Pose(pose) => {
                pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|v| v.is_finite())
            }
            Self::Vector2(vector) => vector.iter().all(|v| v.is_finite()),
            Self::Vector3(vector) => vector.iter().all(|v| v.is_finite()),
            Self::Vector6(vector) => vector.iter().all(|v| v.is_finite()),
        }
    }
}

/// Moves a plane pose by `[x, y, yaw]` in its own frame.
fn retract_planar(pose: &Planar, [x, y, yaw]: [f64; 3]) -> Planar {
    let shift = pose.rotation * Vector2::new(x, y);
    let mut rotation = pose.rotation * UnitComplex::new(yaw);
    rotation.renormalize_fast();
    Planar::from_parts((pose.translation.vector + shift).into(), rotation)
}

/// Estimates of all variables. Keys are assigned in order and never used again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values {
    values: Vec<Value>,
}

impl Values {
    /// Adds a variable with its first estimate.
    pub fn insert(&mut self, value: Value) -> Key {
        self.values.push(value);
        Key(self.values.len() as u32 - 1)
    }

    /// Number of variables.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are no variables.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The estimate of a variable.
    pub fn get(&self, key: Key) -> Option<&Value> {
        self.values.get(key.index())
    }

    /// Replaces an estimate by one of the same kind.
    ///
    /// # Errors
    /// When there is no such variable, or it is of another kind.
    pub fn set(&mut self, key: Key, value: Value) -> Result<(), FactorError> {
        let slot = self.values.get_mut(key.index()).ok_or(FactorError::UnknownVariable { key })?;
        if slot.kind() != value.kind() {
            return Err(FactorError::Kind { key, found: slot.kind(), needed: value.kind() });
        }
        *slot = value;
        Ok(())
    }

    /// All estimates, by key.
    pub fn iter(&self) -> impl Iterator<Item = (Key, &Value)> {
        self.values.iter().enumerate().map(|(index, value)| (Key(index as u32), value))
    }

    /// Moves every variable by its part of `errors`, which are concatenated in the order of the keys.
    #[must_use]
    pub fn retract(&self, errors: &[f64]) -> Self {
        let mut rest = errors;
        let moved = self.values.iter().map(|value| {
            let (own, after) = rest.split_at(value.kind().dimension().min(rest.len()));
            rest = after;
            value.retract(own)
        });
        Self { values: moved.collect() }
    }

    /// Removes every variable from `len` on.
    pub(crate) fn truncate(&mut self, len: usize) {
        self.values.truncate(len);
    }

    /// Moves one variable.
    pub(crate) fn retract_one(&mut self, key: Key, error: &[f64]) {
        if let Some(value) = self.values.get_mut(key.index()) {
            *value = value.retract(error);
        }
    }

    fn value(&self, key: Key) -> Result<&Value, FactorError> {
        self.get(key).ok_or(FactorError::UnknownVariable { key })
    }

    /// A plane pose.
    ///
    /// # Errors
    /// When the variable is missing or of another kind. The same holds for the functions below.
    pub fn planar(&self, key: Key) -> Result<&Planar, FactorError> {
        match self.value(key)? {
            Value::Planar(pose) => Ok(pose),
            other => Err(FactorError::Kind { key, found: other.kind(), needed: VariableKind::Planar }),
        }
    }

    /// A pose. Errors as for [`Self::planar`].
    pub fn pose(&self, key: Key) -> Result<&Isometry, FactorError> {
        match self.value(key)? {
            Value::Pose(pose) => Ok(pose),
            other => Err(FactorError::Kind { key, found: other.kind(), needed: VariableKind::Pose }),
        }
    }

    /// A plane vector. Errors as for [`Self::planar`].
    pub fn vector2(&self, key: Key) -> Result<&Vector2<f64>, FactorError> {
        match self.value(key)? {
            Value::Vector2(vector) => Ok(vector),
            other => Err(FactorError::Kind { key, found: other.kind(), needed: VariableKind::Vector2 }),
        }
    }

    /// A space vector. Errors as for [`Self::planar`].
    pub fn vector3(&self, key: Key) -> Result<&Vector3, FactorError> {
        match self.value(key)? {
            Value::Vector3(vector) => Ok(vector),
            other => Err(FactorError::Kind { key, found: other.kind(), needed: VariableKind::Vector3 }),
        }
    }

    /// Six numbers. Errors as for [`Self::planar`].
    pub fn vector6(&self, key: Key) -> Result<&Vector6, FactorError> {
        match self.value(key)? {
            Value::Vector6(vector) => Ok(vector),
            other => Err(FactorError::Kind { key, found: other.kind(), needed: VariableKind::Vector6 }),
        }
    }
}
