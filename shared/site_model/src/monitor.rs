//! Monitors: conditions that are watched, and what happens when they hold.

use crate::{MissionId, MonitorId};
use serde::{Deserialize, Serialize};
use vocab::Span;

/// A watched condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Monitor {
    /// Its id.
    pub id: MonitorId,
    /// Shown to people.
    pub name: String,
    /// Name of the signal, such as `battery.charge`.
    pub signal: String,
    /// When it holds.
    pub condition: MonitorCondition,
    /// Time for which it must hold.
    #[serde(default)]
    pub hold: Span,
    /// What happens.
    pub response: MonitorResponse,
    /// Whether it is watched.
    pub is_enabled: bool,
}

/// When a monitor's condition holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MonitorCondition {
    /// The signal is below a value.
    Below {
        /// It begins to hold below this one.
        threshold: f64,
        /// It ends above this one, which is not smaller.
        release: f64,
    },
    /// The signal is above a value.
    Above {
        /// It begins to hold above this one.
        threshold: f64,
        /// It ends below this one, which is not greater.
        release: f64,
    },
    /// The signal has not come for this time.
    Silent(Span),
}

/// What happens while a condition holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MonitorResponse {
    /// No mission begins.
    BlockMissions,
    /// A mission interrupts the one that runs.
    Interrupt {
        /// Which.
        mission: MissionId,
        /// What becomes of the interrupted one.
        afterwards: Resumption,
    },
    /// The run is paused.
    Pause,
    /// People are told.
    Notify,
    /// The run is interrupted, and the robot goes to the nearest dock that it can reach.
    GoToDock {
        /// What becomes of the interrupted run.
        afterwards: Resumption,
    },
}

/// What becomes of an interrupted run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Resumption {
    /// It goes on.
    Resume,
    /// It ends.
    Drop,
}
