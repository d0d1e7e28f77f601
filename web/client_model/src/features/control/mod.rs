//! Who controls the robot: one client at a time holds the control lease.

use api::Control;
use vocab::ClientId;

/// The control lease as the server last reported it.
#[derive(Clone, Debug, Default)]
pub struct ControlLease {
    control: Control,
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

    pub(crate) fn set(&mut self, control: Control) {
        self.control = control;
    }
}

#[cfg(test)]
mod tests;
