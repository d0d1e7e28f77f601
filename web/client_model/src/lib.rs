//! State of the operator's client as a reducer: events and commands in, effects out. No egui, no sockets, no clock.
//!
//! [`Model::handle_event`] is the only way in. Views read the model and emit [`ClientCommand`]s. The shell turns sockets, timers and
//! finished downloads into [`ClientEvent`]s and carries out the [`ClientEffect`]s. Time comes in as [`ClientTime`], randomness as the
//! seed of [`Ids`], so every behaviour of the client can be tested without a browser.
//!
//! The model is composed of slices, one for each feature: see `features/mod.rs`, which says how to add one.

mod command;
mod effect;
mod event;
mod features;
mod ids;
mod model;
mod shared;
mod shared_reducers;
mod texts;
mod time;

#[cfg(test)]
mod testing;

pub use command::ClientCommand;
pub use effect::{CameraMove, ClientEffect, Socket};
pub use event::ClientEvent;
pub use features::Model;
pub use features::account::{AccountAction, AccountFeature};
pub use features::alignment::{AlignmentDraft, AlignmentFeature};
pub use features::changes_view::{ChangesView, ShownChanges};
pub use features::connection::{Connection, ReconnectingSocket, ServerClock, SocketState, Throughput};
pub use features::control::ControlLease;
pub use features::driving::Driving;
pub use features::example::ExampleFeature;
pub use features::goals::{GoalOutcome, Goals};
pub use features::history::{EditResult, LoopEdit, ValueHistory};
pub use features::imports::{Imports, Upload};
pub use features::interrupted_sessions::InterruptedSessions;
pub use features::localisation::LocalisationFeature;
pub use features::loops::{
    CloudState, LoopCounts, LoopDecisions, LoopInitialGuess, LoopPair, LoopPick, LoopProposal, Loops,
    ScanComparison, ScanOverlay, correction_of, is_registered,
};
pub use features::map_management::{MapDeletion, MapManagement};
pub use features::map_view::{Loading, MapView, TilePlanConfig, TileSet, TileState, Viewpoint};
pub use features::mapping::MappingFeature;
pub use features::maps::SavedMaps;
pub use features::missions::{
    DraggedTasks, EndProblem, MissionEditor, MissionEditorCommand, MissionPlan, NewTask, OrderGain,
    PlanStart, PlannedEnd, PlannedStop, StopProblem, TaskDrag, constraints_against_list, move_tasks,
    put_in_order, request_of, users_of_mission,
};
pub use features::notices::{NoticeId, Notices, ShownNotice};
pub use features::platform::PlatformFeature;
pub use features::point_history::{
    HistorySpan, PairAlignment, PointHistory, PointHistoryCommand, PointResult, ReadingSeries,
    ResultJudgement, SeriesValue,
};
pub use features::quality::QualityFeature;
pub use features::robot::{RobotTelemetry, position_sigma_m};
pub use features::runs::{
    PastRun, ResultFileKind, RunContent, RunEstimate, RunQuery, Runs, StoredAttempt, StoredPage,
    StoredResult, StoredResultDetails, StoredRun, StoredSlot, StoredSlotDetails, estimate_run,
};
pub use features::schedule::{
    ChangeScope, DaySegment, Occurrence, OccurrenceState, ScheduleFeature, SchedulePlan, ScheduleSelection,
    ShownSpan, conflicts_of, expected_durations, first_slot, lay_out_week, plan_schedules, week_of,
};
pub use features::selection::{GraphTool, PointerMode, Selection};
pub use features::site::{
    ActionForms, CameraSight, DraftChange, DraftCommand, DraftEntry, FieldChange, ParameterField,
    ParameterKind, ParameterProblem, SiteEdit, SiteFeature, StoredDraft, drawn_area, field_changes,
    middle_of, tags_of,
};
pub use features::trajectory::Trajectory;
pub use features::view_settings::{Bookmark, CameraPose, ColourBy, Screen, Theme, ViewFeature, ViewSettings};
pub use ids::Ids;
pub use time::{Aged, ClientTime};
