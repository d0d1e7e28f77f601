//! Adding a loop by hand: two keyframes are chosen, then proposed to the robot.

use super::LoopPair;
use crate::ClientTime;
use vocab::KeyframeId;

/// How far adding a loop by hand has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopPick {
    /// The first keyframe is to be chosen.
    First,
    /// The second keyframe is to be chosen; this is the first one.
    Second(KeyframeId),
    /// Both are chosen and can be proposed.
    Both(LoopPair),
}

impl LoopPick {
    /// Takes the next keyframe. The first one again is taken back; a third one begins anew.
    pub(crate) fn choose(self, keyframe: KeyframeId) -> Self {
        match self {
            Self::Second(first) if first == keyframe => Self::First,
            Self::Second(first) => Self::Both(LoopPair::of(first, keyframe)),
            Self::First | Self::Both(_) => Self::Second(keyframe),
        }
    }
}

/// Initial guess of the pose of the newer keyframe, from which the registration of the two scans starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoopInitialGuess {
    /// Its pose in the graph: right while the map has not drifted.
    #[default]
    Graph,
    /// The position of the older keyframe with the heading of the graph: for a map that has drifted.
    SamePosition,
}

/// A pair that was proposed and is being compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopProposal {
    /// The two keyframes.
    pub pair: LoopPair,
    /// When it was proposed.
    pub asked: ClientTime,
}
