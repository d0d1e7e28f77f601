//! `autoinspect trajectory compare`: how far an estimated trajectory is from the truth.

mod align;
mod compare;
mod extrinsic;
mod load;
mod pairs;

pub use compare::{CompareArgs, run};

/// A trajectory: instants (seconds) with poses, in order of time.
pub type Track = Vec<(vocab::Stamp, geometry::Isometry)>;
