//! Who controls the robot: one client at a time holds the control lease.

use crate::ClientTime;
use api::{Control, ControlRequest};
use vocab::ClientId;

/// The control lease as the server last reported it.
#[derive(Clone, Debug, Default)]
pub struct ControlLease {
    control: Control,
    /// When the server reported it.
    received: ClientTime,
}

impl ControlLease {
    /// The client that holds the lease.
    pub fn owner(&self) -> Option<ClientId> {
        self.control.owner
    }

    /// Name of the holder, for people.
    pub fn holder_name(&self) -> &str {
        &self.control.name
    }

    /// Somebody who asks for the lease, which another client has.
    pub fn request(&self) -> Option<&ControlRequest> {
        self.control.request.as_ref()
    }

    /// Time in which the holder can refuse that, s.
    pub(crate) fn refusal_left_s(&self, now: ClientTime) -> f64 {
        let left = self.request().map_or(0.0, |request| f64::from(request.seconds_left));
        (left - (now.0 - self.received.0)).max(0.0)
    }

    pub(crate) fn set(&mut self, control: Control, now: ClientTime) {
        self.control = control;
        self.received = now;
    }
}

#[cfg(test)]
mod tests;
