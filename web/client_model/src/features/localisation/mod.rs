//! Localisation in a saved map: using and leaving it, and setting the pose by hand.

use super::Feature;
use crate::ClientCommand;
use crate::features::selection::PointerMode;
use crate::shared::{Context, SliceChange};
use api::Localisation;
use vocab::Pose;

/// State of localisation as the robot last reported it.
#[derive(Clone, Debug, Default)]
pub struct LocalisationFeature {
    localisation: Localisation,
    /// Whether the robot has been localised in that map since this client is connected.
    was_localised: bool,
}

impl LocalisationFeature {
    pub(crate) fn state(&self) -> Localisation {
        self.localisation
    }

    /// Whether the robot's pose is in the frame of the map in use.
    pub(crate) fn has_pose(&self) -> bool {
        self.was_localised || self.localisation == Localisation::Idle
    }

    fn update(&mut self, after: Localisation, cx: &mut Context<'_>) {
        let before = std::mem::replace(&mut self.localisation, after);
        let same_map = before.map() == after.map();
        let is_localised = |state| matches!(state, Localisation::Localised { .. });
        self.was_localised = is_localised(after) || (self.was_localised && same_map);
        if !same_map || (is_localised(after) && !is_localised(before)) {
            cx.changes.push(SliceChange::FrameChanged);
        }
    }

    /// The operator showed the robot's pose in the map on the screen.
    fn set_pose(&self, map_from_base: Pose, cx: &mut Context<'_>) {
        cx.shared.selected.leave(PointerMode::PickPose);
        if let Some(map) = cx.shared.map_views.viewed().or(self.localisation.map()) {
            cx.send_in_control(api::Command::Localise { map, at: Some(map_from_base) });
            cx.view_map(None);
        }
    }
}

impl Feature for LocalisationFeature {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        if let api::Event::Localisation(localisation) = event {
            self.update(*localisation, cx);
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::UseMap(map) => {
                cx.send_in_control(api::Command::Localise { map: *map, at: None });
            }
            ClientCommand::LeaveMap => cx.send_in_control(api::Command::LeaveMap),
            ClientCommand::PickPose(true) => cx.shared.selected.enter(PointerMode::PickPose),
            ClientCommand::PickPose(false) => cx.shared.selected.enter(PointerMode::Select),
            ClientCommand::SetPose(map_from_base) => self.set_pose(*map_from_base, cx),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
