//! Which object that was seen at one place is one that was seen at another: descriptors of the shape of an object from its points, whichever way it is turned, and the correspondence of
//! two sets of objects.
//!
//! - [`ObjectDescriptor`]: points to a short vector. [`GeometricDescriptor`] counts shapes; [`PointNetwork`] has learned what to count (`network`).
//! - [`PairModel`]: how much more likely the descriptors and sizes of two objects are if they are one thing.
//! - [`associate`]: the best assignment of all objects at once, each pair with its probability; [`pairs_by_clusters`]: K-means, as in LiSTA.
//!
//! The method is in docs/maths/object-identity.md. Everything is a pure function: the same input gives the same bits.

mod assignment;
mod clustering;
mod descriptor;
#[cfg(test)]
mod descriptor_tests;
mod extents;
mod geometric;
mod network;
mod pair_model;
mod sample;

pub use assignment::{Association, associate};
pub use clustering::pairs_by_clusters;
pub use descriptor::{Descriptor, ObjectDescriptor};
pub use geometric::{GeometricDescriptor, GeometricDescriptorConfig};
pub use network::{NetworkFileError, PointNetwork, TrainingConfig, ViewFeatures, train};
pub use pair_model::{AssociationConfig, ObjectShape, PairModel, sorted_size_difference};
