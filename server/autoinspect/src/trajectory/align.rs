//! Alignment of an estimate with the truth before they are compared.

/// Alignment of the estimate with the truth before they are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Alignment {
    /// None.
    None,
    /// Rotation and translation with the least sum of squared distances.
    Se3,
    /// Rotation, translation and scale.
    Sim3,
    /// Rotation and translation that make the first poses coincide.
    First,
}
