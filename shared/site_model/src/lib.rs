//! The documents of a site that people edit: its topological map, inspection points, missions, schedules and monitors; and what the
//! robot reports for them to decide on: blocked edges, changes of the scene and alerts.
//!
//! A [`Site`] is a set of [`Object`]s. Each object has an id that never changes and a revision of its own. People and programs change a site by
//! [`Edit`]s: lists of objects to put and to remove, each with the revision that it replaces. An edit is applied as a whole or not at all, and applying it
//! returns its inverse. Edits of different objects never conflict. The robot and the browser use this code, so that the browser can
//! check and undo an edit without asking the robot.
//!
//! What was done is recorded as [`MissionEvent`]s, which a run and its results can be rebuilt from.
//!
//! An edit may leave a site that cannot be used yet, such as a task without its node. [`Site::problems`] lists all such problems at once.

mod action;
mod action_catalogue;
mod action_report;
mod alert;
mod compare;
mod dock_action;
mod edit;
mod finite;
mod gauge;
mod ids;
mod mission;
mod mission_status;
mod monitor;
mod mutex_hold;
mod object;
mod object_history;
mod order_cycle;
mod parameters;
mod physical_object;
mod picture_comparison;
mod plan_file;
mod problem;
mod route_action;
mod run;
mod run_event;
mod scene_change;
mod schedule;
mod settings;
mod site;
mod thermal_scale;
mod topological_map;
mod undo;
mod utc;
mod validation;

pub use action::ActionRequest;
pub use action_catalogue::{
    ACTION_CATALOGUE, ActionDescription, MAX_MESSAGE_CHARS, TARGET_PARAMETER, actions_at_places,
    describe_action,
};
pub use action_report::{
    ActionReport, CameraReport, GammaSpectrum, LineOfSight, LocalisationQuality, Reading, ReportFile,
    ReportPlace, ReportTime,
};
pub use alert::{Alert, AlertCause, AlertKey, AlertSeverity, AlertState, OutsideReading};
pub use compare::{MergeConflict, Merged, diff, merge};
pub use dock_action::{CHARGE_PARAMETER, DOCK_PARAMETER, DockAction};
pub use edit::{Applied, Change, Edit, EditError, RevisionChange};
pub use gauge::{DialDirection, GAUGE_PARAMETER, GAUGE_READING, GaugeDial, GaugeDialError, GaugeReport};
pub use ids::{
    AlertId, AssetId, DockId, EdgeId, EditId, InspectionPointId, MissionId, MonitorId, MutexHoldId, NodeId,
    ObjectId, ObjectKind, PhysicalObjectId, RunId, SceneChangeId, ScheduleId, TaskId, ZoneId,
};
pub use mission::{AskDefault, FailurePolicy, FailureStep, Mission, MissionEnd, Task, TaskOrder, TaskPlace};
pub use mission_status::{
    EndedRun, MAX_ENDED_RUNS, MissionStatus, RouteProgress, RouteStatus, RouteWait, RunStatus, TaskStatus,
};
pub use monitor::{Monitor, MonitorCondition, MonitorResponse, Resumption};
pub use mutex_hold::MutexHold;
pub use object::{Object, Revision, Versioned};
pub use object_history::{ObjectStay, changes_of_versions, object_history, record_stay};
pub use order_cycle::find_order_cycle;
pub use parameters::{Parameter, Parameters};
pub use physical_object::{PhysicalObject, ShapeDescriptor};
pub use picture_comparison::{AlignedPictures, PictureChange, PictureComparison, PictureComparisonOutcome};
pub use plan_file::{PLAN_FILE_VERSION, PlanFile, PlanFileError};
pub use problem::{ProblemKind, ProblemSeverity, SiteProblem};
pub use route_action::{EdgeStage, RouteActionEnd, RouteActionPlace, RouteActionStep};
pub use run::{
    EndPlace, MissionCommand, MissionCommandKind, PlannedTask, QuestionAnswer, RunCause, RunPlan, RunState,
    StartMode, TaskState,
};
pub use run_event::{
    MissionEvent, MissionEventKind, ReachFailure, RunChangeReason, SkipReason, SlotDecision, TaskFailure,
    TaskStep,
};
pub use scene_change::{
    EarlierVisit, Movement, OrientedBox, ReviewState, SceneChange, SceneChangeClouds, SceneChangeKind,
};
pub use schedule::{
    LocalDate, LocalDateTime, LocalTime, MissedSlots, OverlapPolicy, Recurrence, Schedule, Weekday, Weekdays,
};
pub use settings::SiteSettings;
pub use site::Site;
pub use thermal_scale::ThermalScale;
pub use topological_map::{
    Anchor, Asset, Corridor, Dock, Edge, EdgeBlock, EdgeCost, EdgeFailStep, InspectionPoint, Node, NodeKind,
    OutsideLimits, PoseTolerance, ReadingLimits, TravelDirection, Traversal, Zone, ZoneEffect,
};
pub use undo::UndoHistory;
pub use utc::Utc;
pub use validation::ValidationConfig;

#[cfg(test)]
mod tests;
