//! The scans of two keyframes laid over each other: at which poses, and the state of their downloads.

use super::scan_overlay::ScanOverlay;
use super::{LoopInitialGuess, LoopPair};
use crate::ClientEffect;
use crate::features::map_view::MapView;
use api::{LoopDecision, TileAnchor};
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;
use vocab::{KeyframeId, Pose, Quat, SessionId, Vec3};

/// Two scans and their poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanComparison {
    /// The two keyframes.
    pub pair: LoopPair,
    /// Pose of the older keyframe.
    pub map_from_from: Pose,
    /// Pose at which the newer one is drawn.
    pub map_from_to: Pose,
}

impl ScanComparison {
    /// The older keyframe at its pose in the graph, the newer one relative to it; `None` if the graph lacks the older one.
    pub(crate) fn of(map: &MapView, pair: LoopPair, from_from_to: &Pose) -> Option<Self> {
        let map_from_from = map.map_from_anchor(TileAnchor::Keyframe(pair.from))?;
        Some(Self { pair, map_from_from, map_from_to: compose(&map_from_from, from_from_to) })
    }
}

/// State of the download of a keyframe's scan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CloudState {
    /// Being fetched.
    Loading,
    /// Here.
    Ready,
    /// The download failed; a sentence for the operator.
    Failed(String),
}

/// The keyframe scans that are wanted now.
#[derive(Clone, Debug, Default)]
pub(crate) struct KeyframeClouds(BTreeMap<(SessionId, KeyframeId), CloudState>);

impl KeyframeClouds {
    pub(crate) fn get(&self, session: SessionId, keyframe: KeyframeId) -> Option<&CloudState> {
        self.0.get(&(session, keyframe))
    }

    /// A download ended. A scan that is no longer wanted is ignored.
    pub(crate) fn on_fetched(
        &mut self,
        session: SessionId,
        keyframe: KeyframeId,
        result: Result<(), String>,
    ) {
        if let Some(state) = self.0.get_mut(&(session, keyframe)) {
            *state = result.map_or_else(CloudState::Failed, |()| CloudState::Ready);
        }
    }

    /// Fetches wanted scans that are not here and forgets all others.
    pub(crate) fn request(&mut self, wanted: &[(SessionId, KeyframeId)], effects: &mut Vec<ClientEffect>) {
        self.0.retain(|key, _| wanted.contains(key));
        for &(session, keyframe) in wanted {
            self.0.entry((session, keyframe)).or_insert_with(|| {
                effects.push(ClientEffect::FetchCloud { session, keyframe });
                CloudState::Loading
            });
        }
    }
}

/// `from_from_to` of a pair as it is guessed before a registration; `None` if the graph lacks one of the two.
pub(crate) fn initial_guess(map: &MapView, pair: LoopPair, guess: LoopInitialGuess) -> Option<Pose> {
    let pose = |keyframe| map.map_from_anchor(TileAnchor::Keyframe(keyframe));
    let from_from_to = relative(&pose(pair.from)?, &pose(pair.to)?);
    Some(match guess {
        LoopInitialGuess::Graph => from_from_to,
        LoopInitialGuess::SamePosition => Pose { position: Vec3::default(), ..from_from_to },
    })
}

/// `from_from_to` at which the scans of a decided pair are drawn; `None` if they are not.
pub(crate) fn overlaid(
    map: &MapView,
    pair: LoopPair,
    overlay: ScanOverlay,
    decision: Option<&LoopDecision>,
) -> Option<Pose> {
    match (overlay, decision) {
        (ScanOverlay::Off, _) => None,
        (ScanOverlay::Registered, Some(decision)) if is_registered(decision) => Some(decision.from_from_to),
        (ScanOverlay::Registered, Some(decision)) => Some(decision.guess),
        (ScanOverlay::Graph, _) | (ScanOverlay::Registered, None) => {
            initial_guess(map, pair, LoopInitialGuess::Graph)
        }
    }
}

/// Whether the registration of the two clouds gave a result, right or wrong.
pub fn is_registered(decision: &LoopDecision) -> bool {
    decision.overlap.iter().any(|share| *share > 0.0)
}

/// How far the registration moved the newer keyframe from its initial guess: metres, radians.
pub fn correction_of(decision: &LoopDecision) -> (f64, f64) {
    let correction = relative(&decision.guess, &decision.from_from_to);
    let [x, y, z] = correction.position.to_array();
    let angle_rad = 2.0 * rotation(&correction).w.abs().clamp(0.0, 1.0).acos();
    (DVec3::new(x, y, z).length(), angle_rad)
}

/// `a_from_c` of `a_from_b` and `b_from_c`.
fn compose(a_from_b: &Pose, b_from_c: &Pose) -> Pose {
    let a_from_b_rotation = rotation(a_from_b);
    let position = translation(a_from_b) + a_from_b_rotation * translation(b_from_c);
    pose(position, a_from_b_rotation * rotation(b_from_c))
}

/// `a_from_b` of `map_from_a` and `map_from_b`.
fn relative(map_from_a: &Pose, map_from_b: &Pose) -> Pose {
    let a_from_map_rotation = rotation(map_from_a).inverse();
    pose(
        a_from_map_rotation * (translation(map_from_b) - translation(map_from_a)),
        a_from_map_rotation * rotation(map_from_b),
    )
}

fn translation(pose: &Pose) -> DVec3 {
    DVec3::from_array(pose.position.to_array())
}

/// The rotation of a pose; the identity if the server sent an invalid quaternion.
fn rotation(pose: &Pose) -> DQuat {
    let q = pose.orientation;
    let rotation = DQuat::from_xyzw(q.x, q.y, q.z, q.w);
    if rotation.is_finite() && rotation.length_squared() > 0.0 {
        rotation.normalize()
    } else {
        DQuat::IDENTITY
    }
}

fn pose(position: DVec3, rotation: DQuat) -> Pose {
    let orientation = Quat { w: rotation.w, x: rotation.x, y: rotation.y, z: rotation.z };
    Pose { position: Vec3::from(position.to_array()), orientation }
}
