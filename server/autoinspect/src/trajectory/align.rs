//! The alignments of an estimate with the truth.

/// Alignment of the estimate with the truth before they are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TrajectoryAlignment {
    /// No alignment.
    None,
    /// Rotation and translation with the smallest sum of squared distances.
    Se3,
    /// Rotation, translation and scale with the smallest sum of squared distances.
    Sim3,
    /// Rotation and translation that make the first poses coincide.
    First,
}
