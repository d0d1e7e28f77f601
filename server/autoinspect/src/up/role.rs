//! The processes of the platform.

/// A process of the platform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProcessRole {
    SimulatedRobot,
    Core,
    Gateway,
}

impl ProcessRole {
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::SimulatedRobot => "simulated robot",
            Self::Core => "core",
            Self::Gateway => "gateway",
        }
    }
}
