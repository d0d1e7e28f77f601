//! Something of an inspection that a person has to look at.

use crate::{AlertId, InspectionPointId, MissionId, OutsideLimits, RunId, SceneChangeId, TaskId, Utc};
use serde::{Deserialize, Serialize};

/// Something that a person has to look at, and what people do about it. The platform raises most alerts. The same cause at the same place is the same alert until it is closed, and a new one
/// afterwards. Only people close alerts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alert {
    /// Its id.
    pub id: AlertId,
    /// How bad it is.
    pub severity: AlertSeverity,
    /// What people have done of it.
    #[serde(default)]
    pub state: AlertState,
    /// What led to it last.
    pub cause: AlertCause,
    /// Who looks after it: the name of an account, or any text. Empty: nobody yet.
    #[serde(default)]
    pub owner: String,
    /// What is to be done, for whoever does it: text or number of a work order.
    #[serde(default)]
    pub work_order: String,
    /// What people say of it. Of one that was raised by hand: what is wrong.
    #[serde(default)]
    pub comment: String,
    /// When it was raised first.
    pub first_raised: Utc,
    /// When it was raised last.
    pub last_raised: Utc,
    /// How often it was raised.
    pub times_raised: u32,
    /// When a later result first said that its cause is gone, such as a reading that is within its limits again; none: no result has said so.
    #[serde(default)]
    pub recovered: Option<Utc>,
}

/// How bad an alert is, the worst last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlertSeverity {
    /// It is good to know.
    Information,
    /// Something is wrong.
    Warning,
    /// Something is badly wrong.
    Critical,
}

/// What people have done of an alert. Who, as the client of that person says; the revisions of the alert say whose edit it was.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlertState {
    /// Nobody has seen it yet.
    #[default]
    Open,
    /// Somebody has seen it, and something is done about it.
    Acknowledged {
        /// Who.
        by: String,
        /// When.
        at: Utc,
    },
    /// It is over.
    Closed {
        /// Who closed it.
        by: String,
        /// When.
        at: Utc,
        /// What came of it.
        remark: String,
    },
}

/// What led to an alert.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlertCause {
    /// A reading was outside its limits.
    OutsideLimits {
        /// Where.
        point: InspectionPointId,
        /// On which run.
        run: RunId,
        /// Number of the result.
        result: u64,
        /// What was read.
        reading: OutsideReading,
    },
    /// A gauge could not be read.
    GaugeNotRead {
        /// Where.
        point: InspectionPointId,
        /// On which run.
        run: RunId,
        /// Number of the result.
        result: u64,
        /// Why, one sentence.
        reason: String,
    },
    /// A task has failed, and was not tried again.
    TaskFailed {
        /// Of which mission; none if the site has it no longer.
        mission: Option<MissionId>,
        /// Which task.
        task: TaskId,
        /// On which run.
        run: RunId,
        /// Why, one sentence.
        reason: String,
    },
    /// Something changed between two visits.
    SceneChange(SceneChangeId),
    /// A person raised it.
    ByHand {
        /// Where; none: at no inspection point.
        point: Option<InspectionPointId>,
    },
}

/// A reading that does not keep a limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutsideReading {
    /// What it is, such as `temperature`.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Unit of value and limit.
    pub unit: String,
    /// The limit.
    pub outside: OutsideLimits,
}

impl AlertSeverity {
    /// Its name in JSON, such as `critical`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Information => "information",
            Self::Warning => "warning",
            Self::Critical => "critical",
        }
    }
}

impl AlertState {
    /// Its name in JSON, such as `acknowledged`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Acknowledged { .. } => "acknowledged",
            Self::Closed { .. } => "closed",
        }
    }

    /// Whether it is over.
    pub fn is_closed(&self) -> bool {
        matches!(self, Self::Closed { .. })
    }
}

impl AlertCause {
    /// Name of its kind in JSON, such as `outside_limits`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::OutsideLimits { .. } => "outside_limits",
            Self::GaugeNotRead { .. } => "gauge_not_read",
            Self::TaskFailed { .. } => "task_failed",
            Self::SceneChange(_) => "scene_change",
            Self::ByHand { .. } => "by_hand",
        }
    }

    /// The inspection point, if it is at one.
    pub fn point(&self) -> Option<InspectionPointId> {
        match self {
            Self::OutsideLimits { point, .. } | Self::GaugeNotRead { point, .. } => Some(*point),
            Self::ByHand { point } => *point,
            Self::TaskFailed { .. } | Self::SceneChange(_) => None,
        }
    }

    /// The run, if one led to it.
    pub fn run(&self) -> Option<RunId> {
        match self {
            Self::OutsideLimits { run, .. }
            | Self::GaugeNotRead { run, .. }
            | Self::TaskFailed { run, .. } => Some(*run),
            Self::SceneChange(_) | Self::ByHand { .. } => None,
        }
    }

    /// What it is and where; none of what a person raised, which is the same as nothing else.
    pub fn key(&self) -> Option<AlertKey<'_>> {
        match self {
            Self::OutsideLimits { point, reading, .. } => Some(AlertKey::Reading(*point, &reading.name)),
            Self::GaugeNotRead { point, .. } => Some(AlertKey::Gauge(*point)),
            Self::TaskFailed { task, .. } => Some(AlertKey::Task(*task)),
            Self::SceneChange(change) => Some(AlertKey::SceneChange(*change)),
            Self::ByHand { .. } => None,
        }
    }
}

/// What an alert is about, and where. Two causes with the same key are one alert until it is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlertKey<'a> {
    /// The reading of this name at an inspection point.
    Reading(InspectionPointId, &'a str),
    /// The gauge of an inspection point.
    Gauge(InspectionPointId),
    /// A task of a mission.
    Task(TaskId),
    /// A change of the scene.
    SceneChange(SceneChangeId),
}
