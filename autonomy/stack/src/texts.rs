//! Sentences for people, by key: notices and refusals of the stack. Those about loops are in `loop_texts`.

pub(crate) const NO_BOOT_RECORD: &str =
    "The log does not begin with a boot record, so nothing in it can be used.";
pub(crate) const VIEWER_REFUSED: &str = "This account may only watch, and stop motion.";
/// Name of a holder of the lease who gave none.
pub(crate) const UNNAMED_OPERATOR: &str = "Operator";

pub(crate) const POSE_CANDIDATE_FOUND: &str =
    "The robot has found a pose in the map that fits, and checks whether another one fits as well.";
pub(crate) const LOCALISED: &str = "The robot is localised in the map.";
pub(crate) const LOCALISED_GOAL_GOES_ON: &str = "The robot is localised in the map, and goes on to its goal.";
pub(crate) const LOCALISATION_LOST: &str = "The robot has lost its pose in the map, and relocalises.";
pub(crate) const LOCALISATION_LOST_UNDER_GOAL: &str =
    "The robot has lost its pose in the map. It has stopped, relocalises, and then goes on to its goal.";
pub(crate) const POSE_NOT_FINITE: &str =
    "That pose cannot be used: its numbers are not finite. Set it again.";
pub(crate) const PRIOR_MAP_INCONSISTENT: &str =
    "That map cannot be used, because its keyframes, edges and clouds do not belong together. Make it again.";

pub(crate) const LOCALISED_IN_EXTENDED_MAP: &str =
    "The robot is localised in the map that it extends; new parts are added from now on.";
pub(crate) const NOT_LOCALISED_IN_EXTENDED_MAP: &str = "The robot is not localised in that map yet, so nothing was added to it. Walk on through the known part, or discard.";
pub(crate) const EXTENDING_NEEDS_LOOPS: &str =
    "A map cannot be extended while loops are left open. Start without that option.";
pub(crate) const MAPPING_RUNS: &str = "A map is being made. Finish or discard it first.";
pub(crate) const MAP_STILL_SAVING: &str = "The last map is still being saved. Try again in a moment.";
pub(crate) const MAP_SAVING_CANNOT_DISCARD: &str = "The map is being saved; it can be deleted afterwards.";
pub(crate) const NO_MAPPING: &str = "No map is being made. Start mapping first.";
pub(crate) const NO_MAPPING_WITH_LOOPS: &str = "No map with loops is being made. Start mapping first.";
pub(crate) const MAP_EMPTY: &str = "The map is still empty. Wait for the first scan.";
pub(crate) const MAP_NEEDS_NAME: &str = "The map needs a name.";
pub(crate) const LOOP_GUESS_NOT_FINITE: &str = "That guess is not a pose. Place the keyframe again.";
pub(crate) const MAP_SAVED: &str = "The map is saved.";

pub(crate) const MOUNTING_REMEDY: &str = "Correct its position and orientation in the robot's description.";
pub(crate) const SILENT_SENSOR_REMEDY: &str =
    "Check its cable, power and driver; mapping goes on with the other sensors.";

/// The robot is not in a dock for `reason`, a sentence.
pub(crate) fn not_docked(dock: &str, reason: &str) -> String {
    format!("The robot is not in dock \"{dock}\". {reason}")
}

/// The robot is charged in a dock that was moved.
pub(crate) fn dock_is_elsewhere(dock: &str, moved_m: f64, turned_rad: f64) -> String {
    format!(
        "Dock \"{dock}\" stands {:.0} cm and {:.0}° from its place on the map. Move its node there, or put the dock back.",
        100.0 * moved_m,
        turned_rad.to_degrees()
    )
}

/// Another client holds the control lease.
pub(crate) fn control_held_by(name: &str) -> String {
    format!("{name} is in control. Take control first; the change of hands is recorded.")
}

/// Saving failed for `reason`, a clause.
pub(crate) fn map_not_saved(reason: &str) -> String {
    format!("The map was not saved: {reason}. The session goes on; try again.")
}

/// The graph of a finished map was not relinearised for `reason`, a clause.
pub(crate) fn map_not_relinearised(reason: &str) -> String {
    format!("The poses of the map were not improved once more before it is saved: {reason}.")
}

/// Reading a saved map failed for `reason`, a clause.
pub(crate) fn map_not_usable(reason: &str) -> String {
    format!("The map cannot be used: {reason}.")
}

/// The pose graph of a saved map cannot be solved.
pub(crate) fn map_not_extendable(error: &dyn std::fmt::Display) -> String {
    format!("That map cannot be extended, because its graph cannot be solved: {error}. Begin another.")
}

/// The boot record's pose of a sensor is not finite.
pub(crate) fn mounting_not_finite(sensor: &str) -> String {
    format!("The mounting of the {sensor} is not a pose, so it is taken to be at the base.")
}

/// A sensor has sent nothing for this time, seconds.
pub(crate) fn sensor_silent(sensor: &str, seconds: f64) -> String {
    format!("The {sensor} has been silent for {seconds:.0} s.")
}

/// A command of missions or a goal on the topological map before the site is known.
pub(crate) const NO_SITE: &str = "The site has not been read yet. Try again in a moment.";
/// A goal on the topological map with the id of another one.
pub(crate) const GOAL_KNOWN: &str = "A goal with this id was started before. Ask for it with a new id.";
/// A goal on the topological map while the pose in its map is not known.
pub(crate) const NOT_LOCALISED_IN_SITE: &str = "The robot is not localised in the map of the site. Choose \"Use this map\" on that map, and wait until it is localised.";
/// A run waits.
pub(crate) const RUN_WAITS_FOR_PLACE: &str = "A mission waits until the robot is localised in the map of the site. Choose \"Use this map\" on that map, or show the robot where it stands.";
/// An action of an edge that was cancelled by whoever offers it.
pub(crate) const ACTION_CANCELLED: &str = "The program that offers the action has cancelled it.";
/// An action of an edge that nobody offers.
pub(crate) const ACTION_UNAVAILABLE: &str = "No program offers this action now.";
/// Somebody stopped motion or drove while the body turned.
pub(crate) const MOTION_TAKEN_WHILE_TURNING: &str =
    "Motion was stopped, or somebody drove, while the body turned for the camera. Redo the task.";
/// There was no room.
pub(crate) const TURN_BLOCKED: &str =
    "The body could not turn towards the target of the camera, because something stood beside the robot.";

/// The camera needs another heading of the body, and that cannot turn.
pub(crate) fn body_not_turned(turn_rad: f64) -> String {
    let (degrees, side) = (turn_rad.abs().to_degrees(), if turn_rad < 0.0 { "right" } else { "left" });
    format!(
        "The camera does not pan to the target, and the body could not turn by {degrees:.0}° to the {side}."
    )
}

/// An action of an edge has failed for `reason`, a sentence, and the robot goes on.
pub(crate) fn edge_action_failed(action: &str, reason: &str) -> String {
    format!("The action {action} of an edge failed, and the robot goes on: {reason}")
}
