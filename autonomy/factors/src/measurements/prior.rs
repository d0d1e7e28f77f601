//! Prior factors: variables that are known beforehand.

use crate::error::FactorError;
use crate::factor::{Factor, Linearised};
use crate::information::Whitening;
use crate::names::{Key, VariableKind};
use crate::texts;
use crate::value::{Planar, Value, Values};
use geometry::{Isometry, Matrix3, Matrix6};
use nalgebra::{SMatrix, SVector, Vector3};

/// A pose known beforehand. Residual `[Log(R); t]` of `known⁻¹ · pose`.
#[derive(Clone, Debug)]
pub struct Prior {
    key: [Key; 1],
    known: Isometry,
    whitening: Whitening<6>,
}

impl Prior {
    /// `information` belongs to the error `[rotation; translation]` in the frame of the known pose.
    ///
    /// # Errors
    /// When the pose is not finite, or the information is not the inverse of a covariance.
    pub fn new(key: Key, known: &Isometry, information: &Matrix6) -> Result<Self, FactorError> {
        if !Value::Pose(*known).is_finite() {
            return Err(FactorError::NotFinite { what: texts::KNOWN_POSE });
        }
        Ok(Self { key: [key], known: *known, whitening: Whitening::from_information(information)? })
    }
}

impl Factor for Prior {
    fn keys(&self) -> &[Key] {
        &self.key
    }

    fn kinds(&self) -> &[VariableKind] {
        &[VariableKind::Pose]
    }

    fn rows(&self) -> usize {
        6
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let (known, pose) = (Value::Pose(self.known), Value::Pose(*values.pose(self.key[0])?));
        let (residual, jacobian) = (known.local(&pose), known.local_jacobian(&pose));
        out.set_jacobian(0, &(self.whitening.matrix() * jacobian));
        out.set_residual(&(self.whitening.matrix() * residual));
        Ok(())
    }

    fn anchor(&self) -> Option<Value> {
        Some(Value::Pose(self.known))
    }
}

/// A pose in the plane known beforehand. Residual `[x; y; yaw]` of `known⁻¹ · pose`.
#[derive(Clone, Debug)]
pub struct PlanarPrior {
    key: [Key; 1],
    known: Planar,
    whitening: Whitening<3>,
}

impl PlanarPrior {
    /// `information` belongs to the error `[x; y; yaw]` in the frame of the known pose.
    ///
    /// # Errors
    /// When the pose is not finite, or the information is not the inverse of a covariance.
    pub fn new(key: Key, known: &Planar, information: &Matrix3) -> Result<Self, FactorError> {
        if !Value::Planar(*known).is_finite() {
            return Err(FactorError::NotFinite { what: texts::KNOWN_POSE });
        }
        Ok(Self { key: [key], known: *known, whitening: Whitening::from_information(information)? })
    }
}

impl Factor for PlanarPrior {
    fn keys(&self) -> &[Key] {
        &self.key
    }

    fn kinds(&self) -> &[VariableKind] {
        &[VariableKind::Planar]
    }

    fn rows(&self) -> usize {
        3
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let (known, pose) = (Value::Planar(self.known), Value::Planar(*values.planar(self.key[0])?));
        let residual: Vector3<f64> = known.local(&pose).fixed_rows::<3>(0).into_owned();
        let jacobian: Matrix3 = known.local_jacobian(&pose).fixed_view::<3, 3>(0, 0).into_owned();
        out.set_jacobian(0, &(self.whitening.matrix() * jacobian));
        out.set_residual(&(self.whitening.matrix() * residual));
        Ok(())
    }

    fn anchor(&self) -> Option<Value> {
        Some(Value::Planar(self.known))
    }
}

/// A vector known beforehand. Residual `vector - known`. `N` is 2, 3 or 6.
#[derive(Clone, Debug)]
pub struct VectorPrior<const N: usize> {
    key: [Key; 1],
    kind: [VariableKind; 1],
    known: SVector<f64, N>,
    whitening: Whitening<N>,
}

impl VectorPrior<2> {
    /// A prior on a plane vector.
    ///
    /// # Errors
    /// When the vector is not finite, or the information is not the inverse of a covariance.
    pub fn plane(
        key: Key,
        known: &SVector<f64, 2>,
        information: &SMatrix<f64, 2, 2>,
    ) -> Result<Self, FactorError> {
        Self::new(key, VariableKind::Vector2, known, information)
    }
}

impl VectorPrior<3> {
    /// A prior on a space vector. Errors as for [`VectorPrior::plane`].
    pub fn space(key: Key, known: &SVector<f64, 3>, information: &Matrix3) -> Result<Self, FactorError> {
        Self::new(key, VariableKind::Vector3, known, information)
    }
}

impl VectorPrior<6> {
    /// A prior on six numbers. Errors as for [`VectorPrior::plane`].
    pub fn six(key: Key, known: &SVector<f64, 6>, information: &Matrix6) -> Result<Self, FactorError> {
        Self::new(key, VariableKind::Vector6, known, information)
    }
}

impl<const N: usize> VectorPrior<N> {
    fn new(
        key: Key,
        kind: VariableKind,
        known: &SVector<f64, N>,
        information: &SMatrix<f64, N, N>,
    ) -> Result<Self, FactorError> {
        if !known.iter().all(|component| component.is_finite()) {
            return Err(FactorError::NotFinite { what: texts::KNOWN_VECTOR });
        }
        let whitening = Whitening::from_information(information)?;
        Ok(Self { key: [key], kind: [kind], known: *known, whitening })
    }
}

impl<const N: usize> Factor for VectorPrior<N> {
    fn keys(&self) -> &[Key] {
        &self.key
    }

    fn kinds(&self) -> &[VariableKind] {
        &self.kind
    }

    fn rows(&self) -> usize {
        N
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let mut residual = -self.known;
        let components: &[f64] = match self.kind[0] {
            VariableKind::Vector2 => values.vector2(self.key[0])?.as_slice(),
            VariableKind::Vector3 => values.vector3(self.key[0])?.as_slice(),
            _ => values.vector6(self.key[0])?.as_slice(),
        };
        for (entry, component) in residual.iter_mut().zip(components) {
            *entry += component;
        }
        out.set_jacobian(0, self.whitening.matrix());
        out.set_residual(&(self.whitening.matrix() * residual));
        Ok(())
    }
}
