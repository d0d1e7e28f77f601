//! Two keyframes' scans laid over each other: which, where, and how far their points have come.

use crate::{ClientEffect, LoopInitialGuess, LoopPair, LoopPick, Model, Selection};
use api::Anchor;
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;
use vocab::{KeyframeId, Pose, Quat, SessionId, Vec3};

/// How the scans of a selected loop are laid over each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScanOverlay {
    /// As the comparison of the two found them.
    #[default]
    Found,
    /// Where the graph has them now.
    Graph,
    /// Not at all: the map is shown.
    Off,
}

/// Two scans laid over each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanComparison {
    /// Whose scans.
    pub pair: LoopPair,
    /// Where the older keyframe is.
    pub map_from_from: Pose,
    /// Where the newer one is put.
    pub map_from_to: Pose,
}

/// How far the points of a scan have come.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CloudState {
    /// Being fetched.
    Loading,
    /// Here.
    Ready,
    /// Could not be had; a sentence for the person.
    Failed(String),
}

/// The scans that are wanted now.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clouds(BTreeMap<(SessionId, KeyframeId), CloudState>);

impl Clouds {
    pub(crate) fn get(&self, session: SessionId, keyframe: KeyframeId) -> Option<&CloudState> {
        self.0.get(&(session, keyframe))
    }

    /// A fetch ended; what is no longer wanted is ignored.
    pub(crate) fn arrive(&mut self, session: SessionId, keyframe: KeyframeId, result: Result<(), String>) {
        if let Some(state) = self.0.get_mut(&(session, keyframe)) {
            *state = result.map_or_else(CloudState::Failed, |()| CloudState::Ready);
        }
    }

    /// Fetches what is wanted and not here, and forgets the rest.
    fn want(&mut self, wanted: &[(SessionId, KeyframeId)], effects: &mut Vec<ClientEffect>) {
        self.0.retain(|key, _| wanted.contains(key));
        for &(session, keyframe) in wanted {
            self.0.entry((session, keyframe)).or_insert_with(|| {
                effects.push(ClientEffect::FetchCloud { session, keyframe });
                CloudState::Loading
            });
        }
    }
}

impl Model {
    /// The two scans to lay over each other now: those of the loop that is selected, or of the two keyframes chosen for
    /// a new one. `None` when there are none, they shall not be shown, or a saved map is on show.
    pub fn scan_comparison(&self) -> Option<ScanComparison> {
        if self.saved.is_some() {
            return None;
        }
        let (pair, from_from_to) = match (self.loop_pick, self.selection) {
            (Some(LoopPick::Both(pair)), _) => (pair, self.guess(pair, self.loop_guess)?),
            (None, Some(Selection::Loop(pair))) => (pair, self.overlaid(pair)?),
            _ => return None,
        };
        let map_from_from = self.live.map_from_anchor(Anchor::Keyframe(pair.from))?;
        Some(ScanComparison { pair, map_from_from, map_from_to: compose(&map_from_from, &from_from_to) })
    }

    /// Pose of the newer keyframe in the older one as it is guessed; `None` when the graph does not hold both.
    pub fn guess(&self, pair: LoopPair, guess: LoopInitialGuess) -> Option<Pose> {
        let pose = |keyframe| self.live.map_from_anchor(Anchor::Keyframe(keyframe));
        let from_from_to = relative(&pose(pair.from)?, &pose(pair.to)?);
        Some(match guess {
            LoopInitialGuess::Graph => from_from_to,
            LoopInitialGuess::SamePlace => Pose { position: Vec3::default(), ..from_from_to },
        })
    }

    /// How far the scan of a keyframe of the map being made has come; `None` while nobody wants it.
    pub fn cloud(&self, keyframe: KeyframeId) -> Option<&CloudState> {
        self.clouds.get(self.live.graph.session?, keyframe)
    }

    fn overlaid(&self, pair: LoopPair) -> Option<Pose> {
        match self.overlay {
            ScanOverlay::Off => None,
            ScanOverlay::Graph => self.guess(pair, LoopInitialGuess::Graph),
            ScanOverlay::Found => match self.loops.get(pair) {
                Some(decision) if fitted(decision) => Some(decision.from_from_to),
                Some(decision) => Some(decision.guess),
                None => self.guess(pair, LoopInitialGuess::Graph),
            },
        }
    }

    /// Sees to it that the scans to be shown are fetched.
    pub(crate) fn follow_comparison(&mut self, effects: &mut Vec<ClientEffect>) {
        let wanted = match (self.scan_comparison(), self.live.graph.session) {
            (Some(ScanComparison { pair, .. }), Some(session)) => {
                vec![(session, pair.from), (session, pair.to)]
            }
            _ => Vec::new(),
        };
        self.clouds.want(&wanted, effects);
    }
}

/// Whether the two clouds were fitted together at all, rightly or not.
pub fn fitted(decision: &api::LoopDecision) -> bool {
    decision.overlap.iter().any(|share| *share > 0.0)
}

/// How far the comparison moved the newer keyframe from its guess: metres, radians.
pub fn shift(decision: &api::LoopDecision) -> (f64, f64) {
    let moved = relative(&decision.guess, &decision.from_from_to);
    let [x, y, z] = moved.position.to_array();
    let turned = 2.0 * rotation(&moved).w.abs().clamp(0.0, 1.0).acos();
    (DVec3::new(x, y, z).length(), turned)
}

/// `a_from_c` of `a_from_b` and `b_from_c`.
fn compose(a_from_b: &Pose, b_from_c: &Pose) -> Pose {
    let turn = rotation(a_from_b);
    let position = translation(a_from_b) + turn * translation(b_from_c);
    pose(position, turn * rotation(b_from_c))
}

/// `a_from_b` of `map_from_a` and `map_from_b`.
fn relative(map_from_a: &Pose, map_from_b: &Pose) -> Pose {
    let turn = rotation(map_from_a).inverse();
    pose(turn * (translation(map_from_b) - translation(map_from_a)), turn * rotation(map_from_b))
}

fn translation(pose: &Pose) -> DVec3 {
    DVec3::from_array(pose.position.to_array())
}

/// A rotation whatever was sent: one that is none turns nothing.
fn rotation(pose: &Pose) -> DQuat {
    let q = pose.orientation;
    let rotation = DQuat::from_xyzw(q.x, q.y, q.z, q.w);
    if rotation.is_finite() && rotation.length_squared() > 0.0 {
        rotation.normalize()
    } else {
        DQuat::IDENTITY
    }
}

fn pose(position: DVec3, turn: DQuat) -> Pose {
    let orientation = Quat { w: turn.w, x: turn.x, y: turn.y, z: turn.z };
    Pose { position: Vec3::from(position.to_array()), orientation }
}
