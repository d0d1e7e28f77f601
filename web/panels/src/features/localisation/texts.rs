//! Texts of localisation, by key.

use api::{DegradationReason, Localisation};

pub(super) const LOCALISATION: &str = "Localisation";
pub(super) const POSITION: &str = "Position";
pub(super) const POSITION_HINT: &str = "Accuracy is one standard deviation of the horizontal position";
pub(super) const NO_POSITION: &str = "No position yet";
pub(super) const LAST_POSITION: &str = "Last position";
pub(super) const RELOCALISING: &str = "Relocalising";
pub(super) const POSITION_UNCERTAIN: &str = "Position uncertain";
pub(super) const POSITION_UNCERTAIN_SHORT: &str = "Uncertain";
pub(super) const FEW_LANDMARKS: &str = "Few landmarks";
pub(super) const LOCALISED: &str = "Localised";
pub(super) const USE_SHORT: &str = "Use this map";
pub(super) const USE_HINT: &str = "The robot localises itself in this map and plans its paths in it.";
pub(super) const LEAVE_SHORT: &str = "Leave this map";
pub(super) const SET_POSE: &str = "Set the pose";
pub(super) const SET_POSE_HINT: &str =
    "Press the floor where the robot stands and drag in the direction it faces.";
pub(super) const CANCEL: &str = "Cancel";
pub(super) const RELOCALISE: &str = "Relocalise";
pub(super) const RELOCALISE_HINT: &str =
    "Walks a few metres at a time, over free floor, until the robot is localised.";

pub(super) fn use_map(map: &str) -> String {
    format!("Use {map}")
}

pub(super) fn leave_map(map: &str) -> String {
    format!("Leave {map}")
}

/// The state of localisation in a saved map.
pub(super) fn state(localisation: &Localisation) -> String {
    match localisation {
        Localisation::Idle => "In no map".to_owned(),
        Localisation::Loading { .. } => "Loading the map".to_owned(),
        Localisation::Relocalising { hypotheses: 0, .. } => "Relocalising".to_owned(),
        Localisation::Relocalising { hypotheses: 1, .. } => "Relocalising: checking one pose".to_owned(),
        Localisation::Relocalising { hypotheses, .. } => {
            format!("Relocalising: {hypotheses} poses are possible, the robot has to move")
        }
        Localisation::Localised { degradation: None, .. } => "Localised".to_owned(),
        Localisation::Localised { degradation: Some(reason), .. } => degradation(*reason).to_owned(),
    }
}

fn degradation(reason: DegradationReason) -> &'static str {
    match reason {
        DegradationReason::MapMismatch => "Uncertain: the scans contradict the map",
        DegradationReason::PoseUncertain => "Uncertain: nothing has confirmed the pose for a while",
        DegradationReason::LidarBlind => "Uncertain: the LiDAR sees nothing",
        DegradationReason::Unmapped => "Outside the mapped area",
        DegradationReason::Unconfirmed => "Checking for places that look alike",
    }
}
