//! What may be changed about an estimate before it is compared with the truth.

/// What may be changed about the estimate before it is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Alignment {
    /// Nothing.
    None,
    /// Moved and turned, to the least sum of squared distances.
    Se3,
    /// Moved, turned and scaled.
    Sim3,
    /// Moved and turned so that the first poses coincide.
    First,
}
