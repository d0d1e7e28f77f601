//! Moving the robot by hand, stopping it, and picking the goal of a walk.

mod teleoperation;

use super::Feature;
use crate::features::selection::PointerMode;
use crate::shared::Context;
use crate::{ClientCommand, ClientEvent};
use api::Motion;
use teleoperation::Teleoperation;
use vocab::Twist;

/// Driving by hand.
#[derive(Clone, Debug, Default)]
pub struct Driving {
    teleoperation: Teleoperation,
}

impl Driving {
    /// The velocity that the operator commands by hand.
    pub(crate) fn velocity(&self) -> Option<Twist> {
        self.teleoperation.velocity()
    }
}

impl Feature for Driving {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        if let api::Event::Motion(motion) = event
            && !matches!(motion, Motion::Idle | Motion::Teleoperated)
        {
            cx.shared.selected.leave(PointerMode::PickGoal);
        }
    }

    fn on_client_event(&mut self, event: &ClientEvent, cx: &mut Context<'_>) {
        if matches!(event, ClientEvent::Tick)
            && let Some(velocity) = self.teleoperation.take_due(cx.now())
        {
            teleoperate(velocity, cx);
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            // Needs no control lease, and ends driving by hand.
            ClientCommand::StopMotion => {
                self.teleoperation.set_velocity(cx.now(), None);
                cx.shared.selected.leave(PointerMode::PickGoal);
                cx.send(api::Command::StopMotion);
            }
            ClientCommand::AllowMotion => cx.send_in_control(api::Command::AllowMotion),
            ClientCommand::SetVelocity(velocity) => {
                if let Some(velocity) = self.teleoperation.set_velocity(cx.now(), *velocity) {
                    teleoperate(velocity, cx);
                }
            }
            ClientCommand::PickGoal(true) => cx.shared.selected.enter(PointerMode::PickGoal),
            ClientCommand::PickGoal(false) => cx.shared.selected.enter(PointerMode::Select),
            _ => {}
        }
    }
}

fn teleoperate(velocity: Twist, cx: &mut Context<'_>) {
    if cx.shared.connection.is_connected() {
        cx.take_free_control();
        // Ten a second, each outdated after half a second: not kept for a reconnection.
        cx.send_once(api::Command::Teleoperate(velocity));
    }
}

#[cfg(test)]
mod tests;
