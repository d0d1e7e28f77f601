//! When actions of an edge are performed.

use site_model::{ActionRequest, Edge};

/// When an action is performed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum EdgeActionTime {
    Enter,
    During,
    Leave,
}

impl EdgeActionTime {
    /// The actions of an edge.
    pub(super) fn actions(self, edge: &Edge) -> &Vec<ActionRequest> {
        match self {
            Self::Enter => &edge.on_enter,
            Self::During => &edge.during,
            Self::Leave => &edge.on_leave,
        }
    }

    /// Gives an edge other ones.
    pub(super) fn put(self, edge: &mut Edge, list: Vec<ActionRequest>) {
        match self {
            Self::Enter => edge.on_enter = list,
            Self::During => edge.during = list,
            Self::Leave => edge.on_leave = list,
        }
    }
}
