//! Which of the runs that have ended are listed.

use site_model::RunState;

/// Which runs are listed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Filter {
    #[default]
    All,
    Succeeded,
    Problems,
}

impl Filter {
    /// Whether a run of this outcome is listed.
    pub(super) fn lets_through(self, outcome: RunState) -> bool {
        match self {
            Self::All => true,
            Self::Succeeded => outcome == RunState::Succeeded,
            Self::Problems => outcome != RunState::Succeeded,
        }
    }
}
