//! The same thing at one place and another: its identity over many visits, and its shape.

use crate::PhysicalObjectId;
use serde::{Deserialize, Serialize};

/// Which thing a change is of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhysicalObject {
    /// The thing. All changes with this id are of it.
    pub id: PhysicalObjectId,
    /// Probability that it is the thing of the earlier changes with this id, and of a moved one that it is the thing at both places, 0 to 1: things of one make cannot be told apart.
    pub probability: f64,
}

/// The shape of an object as a short vector, by which it is known again (docs/maths/object-identity.md).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShapeDescriptor {
    /// Name of the method with its version. Only descriptors of one name can be compared.
    pub name: String,
    /// Its components, as multiples of 1/127.
    pub values: Vec<i8>,
}
