//! Actions of the robot at the other end of the socket: calls go out as requests, and what becomes of them comes back among the measurements.
//!
//! A call that is under way when the connection is lost has failed: nobody knows whether it was done. The robot forgets it too.

use crate::current_connection::{CurrentConnection, NotConnected};
use crate::protocol::{RobotIdentity, RobotRequest};
use crate::texts;
use crossbeam_channel::{Receiver, Sender};
use ports::{
    ActionCall, ActionEnd, ActionEvent, ActionRegistration, ActionServer, MAX_ACTION_PARAMETER_BYTES,
    MAX_ACTION_RESULT_BYTES, MAX_OPEN_ACTIONS,
};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use vocab::ActionCallId;

/// Parameters of [`RobotActions`].
#[derive(Clone, Copy, Debug)]
struct RobotActionsConfig {
    /// Feedback that may wait for whoever called. More is left out. Chosen: four of each of the calls that may be open.
    max_waiting_feedback: usize,
}

const CONFIG: RobotActionsConfig = RobotActionsConfig { max_waiting_feedback: 4 * MAX_OPEN_ACTIONS };

/// The robot's actions, for the core.
pub(crate) struct RobotActions {
    actions: Vec<ActionRegistration>,
    connection: Arc<CurrentConnection>,
    open: Mutex<BTreeSet<ActionCallId>>,
    sender: Sender<ActionEvent>,
    events: Receiver<ActionEvent>,
}

impl RobotActions {
    pub(crate) fn new(identity: &RobotIdentity, connection: Arc<CurrentConnection>) -> Self {
        // A call is begun only if no more than the feedback waits, so that there is room for the ends of all calls.
        let (sender, events) = crossbeam_channel::bounded(CONFIG.max_waiting_feedback + MAX_OPEN_ACTIONS);
        Self { actions: identity.actions.clone(), connection, open: Mutex::default(), sender, events }
    }

    fn open(&self) -> MutexGuard<'_, BTreeSet<ActionCallId>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Passes on what the robot says of a call. What it says of others is left out.
    pub(crate) fn receive(&self, event: ActionEvent) {
        match event {
            ActionEvent::Feedback { call, .. } => {
                if self.open().contains(&call) && self.sender.len() < CONFIG.max_waiting_feedback {
                    self.post(event);
                }
            }
            ActionEvent::Ended { call, end } => {
                if self.open().remove(&call) {
                    self.post(ActionEvent::Ended { call, end: within_limits(end) });
                }
            }
        }
    }

    /// The connection was lost.
    pub(crate) fn fail_all(&self) {
        for call in std::mem::take(&mut *self.open()) {
            let end = ActionEnd::Failed { reason: texts::ROBOT_LOST_IN_ACTION.to_owned() };
            self.post(ActionEvent::Ended { call, end });
        }
    }

    fn post(&self, event: ActionEvent) {
        // There is room, and this holds the receiving end too.
        let _ = self.sender.try_send(event);
    }
}

/// A result that is too large is none.
fn within_limits(end: ActionEnd) -> ActionEnd {
    let bytes = match &end {
        ActionEnd::Succeeded { report, files } => {
            report.len() + files.iter().map(|file| file.bytes.len()).sum::<usize>()
        }
        ActionEnd::Failed { .. } | ActionEnd::Cancelled => 0,
    };
    if bytes > MAX_ACTION_RESULT_BYTES {
        return ActionEnd::Failed { reason: texts::result_too_large(bytes, MAX_ACTION_RESULT_BYTES) };
    }
    end
}

impl ActionServer for RobotActions {
    fn actions(&self) -> Vec<ActionRegistration> {
        self.actions.clone()
    }

    fn start(&self, call: ActionCall) -> Result<(), String> {
        if call.parameters.len() > MAX_ACTION_PARAMETER_BYTES {
            return Err(texts::PARAMETERS_TOO_LONG.to_owned());
        }
        let id = call.id;
        {
            let mut open = self.open();
            if open.len() >= MAX_OPEN_ACTIONS || self.sender.len() > CONFIG.max_waiting_feedback {
                return Err(texts::TOO_MANY_ACTIONS.to_owned());
            }
            // Before the request, whose answer may come at once.
            open.insert(id);
        }
        self.connection.send(&RobotRequest::StartAction(call)).map_err(|NotConnected| {
            self.open().remove(&id);
            texts::ROBOT_NOT_CONNECTED.to_owned()
        })
    }

    fn cancel(&self, call: ActionCallId) {
        if self.open().contains(&call) {
            // Without a connection the call has failed.
            let _ = self.connection.send(&RobotRequest::CancelAction(call));
        }
    }

    fn events(&self) -> Receiver<ActionEvent> {
        self.events.clone()
    }
}

#[cfg(test)]
#[path = "robot_actions_tests.rs"]
mod tests;
