//! Commands that the server has not answered yet.

use crate::ClientTime;
use api::Order;
use vocab::CommandId;

/// One unanswered command.
#[derive(Clone, Debug, PartialEq)]
pub struct PendingCommand {
    /// Its id; sending it twice does it once.
    pub id: CommandId,
    /// What was asked.
    pub order: Order,
    /// When it was asked first.
    pub asked: ClientTime,
}

/// An order older than this is not sent again after a reconnection: the world has moved on.
const RESEND_S_MAX: f64 = 5.0;

impl PendingCommand {
    /// Whether it may be sent again on a new connection. A stop always may; driving by hand never.
    pub(crate) fn resend(&self, now: ClientTime) -> bool {
        match self.order {
            Order::StopMotion => true,
            Order::Teleoperate(_) => false,
            _ => now.since(self.asked) <= RESEND_S_MAX,
        }
    }

    /// What was asked, for a sentence such as "… was not done".
    pub(crate) fn name(&self) -> &'static str {
        match self.order {
            Order::TakeControl { .. } => "Taking control",
            Order::ReleaseControl => "Giving control back",
            Order::StartMapping(_) => "Starting to map",
            Order::ExtendMap { .. } => "Extending the map",
            Order::FinishMapping { .. } => "Saving the map",
            Order::DiscardMapping => "Discarding the map",
            Order::Teleoperate(_) => "Driving",
            Order::WalkTo(_) => "Walking there",
            Order::StopMotion => "Stop motion",
            Order::AllowMotion => "Allowing motion",
            Order::AcceptLoop { .. } => "Accepting the loop",
            Order::RejectLoop { .. } => "Rejecting the loop",
            Order::ProposeLoop { .. } => "Looking for the loop",
            Order::Localise { .. } => "Using the map",
            Order::ImportMap { .. } => "Importing the map",
            Order::AlignMap { .. } => "Laying the map",
            Order::CancelImport(_) => "Ending the import",
            Order::Cause(_) => "The simulated trouble",
            Order::LookAbout => "Looking about",
            Order::LeaveMap => "Leaving the map",
        }
    }
}
