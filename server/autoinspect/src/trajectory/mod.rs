//! `autoinspect trajectory compare`: compares an estimated trajectory with the ground truth.

mod align;
mod compare;
mod extrinsic;
mod load;
mod pairs;

pub use compare::{CompareArgs, run};

/// A trajectory: instants (seconds) with poses, in order of time.
pub type Track = Vec<(vocab::Stamp, geometry::Isometry)>;
