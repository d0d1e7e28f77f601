//! Commands that the server has not answered yet.

use crate::ClientTime;
use api::{Command, GoalKind};
use vocab::CommandId;

/// One unanswered command.
#[derive(Clone, Debug, PartialEq)]
pub struct PendingCommand {
    /// Its id; sending it twice does it once.
    pub id: CommandId,
    /// What was asked.
    pub order: Command,
    /// When it was asked first.
    pub asked: ClientTime,
}

/// An order older than this is not sent again after a reconnection: the world has moved on.
const RESEND_S_MAX: f64 = 5.0;

impl PendingCommand {
    /// Whether it may be sent again on a new connection. A stop always may; driving by hand never.
    pub(crate) fn resend(&self, now: ClientTime) -> bool {
        match self.order {
            Command::StopMotion => true,
            Command::Teleoperate(_) => false,
            _ => now.since(self.asked) <= RESEND_S_MAX,
        }
    }

    /// What was asked, for a sentence such as "… was not done".
    pub(crate) fn name(&self) -> &'static str {
        match self.order {
            Command::TakeControl { .. } => "Taking control",
            Command::ReleaseControl => "Giving control back",
            Command::StartMapping(_) => "Starting to map",
            Command::ExtendMap { .. } => "Extending the map",
            Command::FinishMapping { .. } => "Saving the map",
            Command::DiscardMapping => "Discarding the map",
            Command::Teleoperate(_) => "Driving",
            Command::StartGoal { kind: GoalKind::WalkTo(_), .. } => "Walking there",
            Command::StartGoal { kind: GoalKind::Relocalise, .. } => "Looking about",
            Command::CancelGoal(_) => "Cancelling the goal",
            Command::StopMotion => "Stop motion",
            Command::AllowMotion => "Allowing motion",
            Command::AcceptLoop { .. } => "Accepting the loop",
            Command::RejectLoop { .. } => "Rejecting the loop",
            Command::ProposeLoop { .. } => "Looking for the loop",
            Command::Localise { .. } => "Using the map",
            Command::ImportMap { .. } => "Importing the map",
            Command::AlignMap { .. } => "Laying the map",
            Command::CancelImport(_) => "Ending the import",
            Command::InjectFault(_) => "The simulated trouble",
            Command::LeaveMap => "Leaving the map",
        }
    }
}
