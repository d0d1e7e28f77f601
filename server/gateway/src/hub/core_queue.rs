//! What waits to be sent to the core: a lane of its own for Stop motion, and one for everything else.
//!
//! Allow motion goes in the lane of Stop motion. Else a stop would overtake the permission that was given before it, which would then lift it.

use crate::limits::FIXED;
use crate::texts;
use api::{Command, GatewayMessage};
use tokio::sync::mpsc;

/// The end that is filled.
pub(crate) struct CoreQueue {
    stops: mpsc::Sender<GatewayMessage>,
    others: mpsc::Sender<GatewayMessage>,
}

/// The end that is sent.
pub(crate) struct CoreMessages {
    stops: mpsc::Receiver<GatewayMessage>,
    others: mpsc::Receiver<GatewayMessage>,
}

impl CoreQueue {
    /// An empty queue.
    pub(crate) fn new() -> (Self, CoreMessages) {
        let (stops, stops_receiver) = mpsc::channel(FIXED.max_queued_stops);
        let (others, others_receiver) = mpsc::channel(FIXED.max_queued_commands);
        (Self { stops, others }, CoreMessages { stops: stops_receiver, others: others_receiver })
    }

    /// Hands in a message. Never waits.
    ///
    /// # Errors
    /// When too many wait, one sentence.
    pub(crate) fn send(&self, message: GatewayMessage) -> Result<(), &'static str> {
        let lane = match message {
            GatewayMessage::Command { command: Command::StopMotion, .. } => &self.stops,
            // Half of the lane is kept for stops.
            GatewayMessage::Command { command: Command::AllowMotion, .. } => {
                if self.stops.capacity() <= FIXED.max_queued_stops / 2 {
                    return Err(texts::CORE_BUSY);
                }
                &self.stops
            }
            _ => &self.others,
        };
        lane.try_send(message).map_err(|_| texts::CORE_BUSY)
    }

    /// Whether there is room for anything but Stop motion.
    pub(crate) fn has_room(&self) -> bool {
        self.others.capacity() > 0
    }
}

impl CoreMessages {
    /// The next message: Stop motion before everything else. `None` once nothing more comes.
    pub(crate) async fn next(&mut self) -> Option<GatewayMessage> {
        tokio::select! {
            biased;
            Some(stop) = self.stops.recv() => Some(stop),
            other = self.others.recv() => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::{ClientId, CommandId};

    #[tokio::test]
    async fn a_stop_overtakes_all_that_waits_and_has_room_when_nothing_else_has() {
        let (queue, mut messages) = CoreQueue::new();
        let command = |command: Command| GatewayMessage::Command {
            id: CommandId(uuid::Uuid::nil()),
            by: ClientId(uuid::Uuid::nil()).into(),
            command,
        };
        while queue.has_room() {
            queue.send(command(Command::LeaveMap)).expect("there is room");
        }
        assert_eq!(queue.send(command(Command::LeaveMap)), Err(texts::CORE_BUSY));
        queue.send(command(Command::StopMotion)).expect("a lane of its own");
        assert_eq!(messages.next().await, Some(command(Command::StopMotion)));
        assert_eq!(messages.next().await, Some(command(Command::LeaveMap)));
    }

    #[tokio::test]
    async fn a_stop_does_not_overtake_the_permission_to_move_that_was_given_before_it() {
        let (queue, mut messages) = CoreQueue::new();
        let command = |command: Command| GatewayMessage::Command {
            id: CommandId(uuid::Uuid::nil()),
            by: ClientId(uuid::Uuid::nil()).into(),
            command,
        };
        for kind in [Command::LeaveMap, Command::AllowMotion, Command::StopMotion] {
            queue.send(command(kind)).expect("there is room");
        }
        for kind in [Command::AllowMotion, Command::StopMotion, Command::LeaveMap] {
            assert_eq!(messages.next().await, Some(command(kind)));
        }
        while queue.send(command(Command::AllowMotion)).is_ok() {}
        queue.send(command(Command::StopMotion)).expect("half of the lane is kept for stops");
    }
}
