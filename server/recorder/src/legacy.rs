//! Reads journals of earlier programs: versions 3 to 14 of `messages::Input`, which programs up to November 2026 wrote.
//!
//! It holds frozen copies of the types that have changed since, with their conversions to the present types. Unchanged types are those of
//! `messages`. Before the layout of one of them changes, copy it to this file. Recordings in `tests/fixtures` and the bytes in
//! `tests/journal_layout_v4.txt` to `tests/journal_layout_v14.txt` test this. The types of the site are in `legacy_site`.

use messages::{
    ActionOutcome, BootRecord, Command, CommandKind, ComparedRevisit, DisambiguationPlan, GoalKind, Input,
    JobDone, JobFailure, JobResult, MapSearchResult, Mounting, PlaceComparison, PoseInMap, Principal,
    PriorMap, RelocalisationResponse, RobotProfile, Sensor, Sources, SpeedLimits, StopLatch, VerifiedLoop,
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vocab::{
    Aabb, ActionCallId, ClientId, CommandId, GoalId, KeyframeId, MapId, Pose, SessionId, Span, Twist, Vec3,
};

/// Name of the schema of version 14. Its entries are as those of version 15, in which the cause of a run may be an account.
pub(crate) const INPUT_SCHEMA_V14: &str = "autoinspect.Input.v14";

/// Name of the schema of version 13. Its entries are as those of version 14, but for changes of the scene, which did not say of which thing they were.
pub(crate) const INPUT_SCHEMA_V13: &str = "autoinspect.Input.v13";

/// Name of the schema of version 12. Its entries are as those of version 13, in which tasks of missions also dock.
pub(crate) const INPUT_SCHEMA_V12: &str = "autoinspect.Input.v12";

/// Name of the schema of version 11. Its entries are as those of version 12, in which a site also has changes of the scene.
pub(crate) const INPUT_SCHEMA_V11: &str = "autoinspect.Input.v11";

/// Name of the schema of version 10. Its entries are as those of version 11, but for the boot record, whose robot profile says nothing of the camera's head.
pub(crate) const INPUT_SCHEMA_V10: &str = "autoinspect.Input.v10";

/// The bytes of the boot record in an entry of version 6 to 10; `None` for all other entries, which are as those of version 11.
pub(crate) fn boot_record_v10(entry: &[u8]) -> Option<&[u8]> {
    // The boot is the first variant.
    entry.split_first().and_then(|(variant, record)| (*variant == 0).then_some(record))
}

/// `messages::BootRecord`, versions 6 to 10.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct BootRecordV10 {
    profile: RobotProfileV10,
    mounting: Mounting,
    sources: Sources,
    start_mapping: Option<SessionId>,
    leave_loops_open: bool,
    last_pose: Option<PoseInMap>,
    docks: Arc<[PoseInMap]>,
    stop_latch: Option<StopLatch>,
}

/// `messages::RobotProfile`, versions 4 to 10: without the camera's head.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct RobotProfileV10 {
    name: String,
    footprint_radius_m: f64,
    clearance_height_m: f64,
    standing_height_m: f64,
    step_height_m: f64,
    autonomous_limits: SpeedLimits,
    manual_limits: SpeedLimits,
    manual_watchdog: Span,
    self_filter: Option<Aabb>,
    keyframe_distance_m: f64,
    keyframe_rotation_rad: f64,
}

impl From<BootRecordV10> for BootRecord {
    fn from(record: BootRecordV10) -> Self {
        Self {
            profile: record.profile.into(),
            mounting: record.mounting,
            sources: record.sources,
            start_mapping: record.start_mapping,
            leave_loops_open: record.leave_loops_open,
            last_pose: record.last_pose,
            docks: record.docks,
            stop_latch: record.stop_latch,
        }
    }
}

impl From<RobotProfileV10> for RobotProfile {
    /// The camera's head is that of the default profile, by which the client aimed for every robot then.
    fn from(profile: RobotProfileV10) -> Self {
        Self {
            name: profile.name,
            footprint_radius_m: profile.footprint_radius_m,
            clearance_height_m: profile.clearance_height_m,
            standing_height_m: profile.standing_height_m,
            step_height_m: profile.step_height_m,
            autonomous_limits: profile.autonomous_limits,
            manual_limits: profile.manual_limits,
            manual_watchdog: profile.manual_watchdog,
            self_filter: profile.self_filter,
            keyframe_distance_m: profile.keyframe_distance_m,
            keyframe_rotation_rad: profile.keyframe_rotation_rad,
            ..Self::default()
        }
    }
}

/// Name of the schema of version 9. Its entries are as those of version 10, in which a site also has holds of edges, and runs have actions on the way.
pub(crate) const INPUT_SCHEMA_V9: &str = "autoinspect.Input.v9";

/// Name of the schema of version 8. Its entries are as those of version 9, in which an action may also end because the body has to turn first.
pub(crate) const INPUT_SCHEMA_V8: &str = "autoinspect.Input.v8";

/// Name of the schema of version 7. Its entries are as those of version 8, which has further ones: of the site, of missions and of registered actions.
pub(crate) const INPUT_SCHEMA_V7: &str = "autoinspect.Input.v7";

/// Name of the schema of version 6. Its entries are as those of version 7, beside which sweeps may be range images, which programs of version 6 do not know.
pub(crate) const INPUT_SCHEMA_V6: &str = "autoinspect.Input.v6";

/// Name of the schema of version 5.
pub(crate) const INPUT_SCHEMA_V5: &str = "autoinspect.Input.v5";

/// `messages::Input`, version 5: the boot record says nothing of a stop of motion.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum InputV5 {
    Boot(Box<BootRecordV5>),
    Tick,
    Sensor(Sensor),
    Command(Command),
    JobDone(JobDone),
    WallClock { utc_ns: i64, synchronised: bool },
    Committed { seq: u64 },
    ActionFeedback { call: ActionCallId, progress: Option<f32>, text: String },
    ActionDone { call: ActionCallId, outcome: ActionOutcome },
    GraphRequested,
}

/// `messages::BootRecord`, versions 4 and 5.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct BootRecordV5 {
    profile: RobotProfileV10,
    mounting: Mounting,
    sources: Sources,
    start_mapping: Option<SessionId>,
    leave_loops_open: bool,
    last_pose: Option<PoseInMap>,
    docks: Arc<[PoseInMap]>,
}

impl From<InputV5> for Input {
    fn from(input: InputV5) -> Self {
        match input {
            InputV5::Boot(record) => Self::Boot(Box::new((*record).into())),
            InputV5::Tick => Self::Tick,
            InputV5::Sensor(sensor) => Self::Sensor(sensor),
            InputV5::Command(command) => Self::Command(command),
            InputV5::JobDone(done) => Self::JobDone(done),
            InputV5::WallClock { utc_ns, synchronised } => Self::WallClock { utc_ns, synchronised },
            InputV5::Committed { seq } => Self::Committed { seq },
            InputV5::ActionFeedback { call, progress, text } => Self::ActionFeedback { call, progress, text },
            InputV5::ActionDone { call, outcome } => Self::ActionDone { call, outcome },
            InputV5::GraphRequested => Self::GraphRequested,
        }
    }
}

impl From<BootRecordV5> for BootRecord {
    fn from(record: BootRecordV5) -> Self {
        Self {
            profile: record.profile.into(),
            mounting: record.mounting,
            sources: record.sources,
            start_mapping: record.start_mapping,
            leave_loops_open: record.leave_loops_open,
            last_pose: record.last_pose,
            docks: record.docks,
            stop_latch: None,
        }
    }
}

/// Name of the schema of version 4.
pub(crate) const INPUT_SCHEMA_V4: &str = "autoinspect.Input.v4";

/// `messages::Input`, version 4: results of jobs without their owners.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum InputV4 {
    Boot(Box<BootRecordV5>),
    Tick,
    Sensor(Sensor),
    Command(Command),
    JobDone(JobDoneV4),
    WallClock { utc_ns: i64, synchronised: bool },
    Committed { seq: u64 },
    ActionFeedback { call: ActionCallId, progress: Option<f32>, text: String },
    ActionDone { call: ActionCallId, outcome: ActionOutcome },
}

/// `messages::JobDone`, version 4.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct JobDoneV4 {
    job: u64,
    result: JobResultV4,
}

/// `messages::JobResult`, version 4: a failure does not say whose it is.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum JobResultV4 {
    MapSaved { map: MapId, bytes: u64 },
    LoopVerified(Box<VerifiedLoop>),
    RevisitCompared(Box<ComparedRevisit>),
    MapLoaded(Arc<PriorMap>),
    MapSearched(MapSearchResult),
    Relocalised(Box<RelocalisationResponse>),
    DisambiguationPlanned(DisambiguationPlan),
    Failed { reason: String },
}

impl From<InputV4> for Input {
    fn from(input: InputV4) -> Self {
        match input {
            InputV4::Boot(record) => Self::Boot(Box::new((*record).into())),
            InputV4::Tick => Self::Tick,
            InputV4::Sensor(sensor) => Self::Sensor(sensor),
            InputV4::Command(command) => Self::Command(command),
            InputV4::JobDone(done) => Self::JobDone(JobDone { number: done.job, result: done.result.into() }),
            InputV4::WallClock { utc_ns, synchronised } => Self::WallClock { utc_ns, synchronised },
            InputV4::Committed { seq } => Self::Committed { seq },
            InputV4::ActionFeedback { call, progress, text } => Self::ActionFeedback { call, progress, text },
            InputV4::ActionDone { call, outcome } => Self::ActionDone { call, outcome },
        }
    }
}

impl From<JobResultV4> for JobResult {
    /// Two owners have to be assumed. A map that was read is taken for localisation's, which read maps more often than sessions that extended one.
    /// A failure is taken for a comparison's, of which there were most.
    fn from(result: JobResultV4) -> Self {
        match result {
            JobResultV4::MapSaved { map, .. } => Self::MapSaving(Ok(map)),
            JobResultV4::LoopVerified(found) => Self::LoopClosing(Ok(PlaceComparison::Loop(found))),
            JobResultV4::RevisitCompared(found) => Self::LoopClosing(Ok(PlaceComparison::Revisit(found))),
            JobResultV4::MapLoaded(map) => Self::Localisation(Ok(map)),
            JobResultV4::MapSearched(found) => Self::MapSearch(Ok(Box::new(found))),
            JobResultV4::Relocalised(found) => Self::Relocalisation(Ok(*found)),
            JobResultV4::DisambiguationPlanned(plan) => Self::Disambiguation(Ok(plan)),
            JobResultV4::Failed { reason } => Self::LoopClosing(Err(JobFailure { reason })),
        }
    }
}

/// Name of the schema of version 3.
pub(crate) const INPUT_SCHEMA_V3: &str = "autoinspect.Input.v3";

/// `messages::Input`, version 3.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum InputV3 {
    Boot(Box<BootRecordV3>),
    Tick,
    Sensor(Sensor),
    Command(CommandV3),
    JobDone(JobDoneV3),
}

/// `messages::BootRecord`, version 3: without a robot profile.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct BootRecordV3 {
    robot: String,
    mounting: Mounting,
    sources: Sources,
    start_mapping: Option<SessionId>,
    leave_loops_open: bool,
    last_pose: Option<PoseInMap>,
    docks: Arc<[PoseInMap]>,
}

/// `messages::Command`, version 3: its client has no role.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct CommandV3 {
    id: CommandId,
    by: ClientId,
    kind: CommandKindV3,
}

/// `messages::CommandKind`, version 3: walks and relocalisation were commands without a goal id.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum CommandKindV3 {
    TakeControl { name: String },
    ReleaseControl,
    StartMapping(SessionId),
    FinishMapping { map: MapId, name: String },
    DiscardMapping,
    Teleoperate(Twist),
    WalkTo(Vec3),
    StopMotion,
    AllowMotion,
    AcceptLoop { from: KeyframeId, to: KeyframeId },
    RejectLoop { from: KeyframeId, to: KeyframeId },
    ProposeLoop { from: KeyframeId, to: KeyframeId, guess: Pose },
    ExtendMap { session: SessionId, map: MapId },
    Localise { map: MapId, at: Option<Pose> },
    LeaveMap,
    LookAbout,
}

/// `messages::JobDone`, version 3.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct JobDoneV3 {
    job: u64,
    result: JobResultV3,
}

/// `messages::JobResult`, version 3: three kinds of failure.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum JobResultV3 {
    MapSaved { map: MapId, bytes: u64 },
    LoopVerified(Box<VerifiedLoop>),
    VisitCompared(Box<ComparedRevisit>),
    LoopNotVerified,
    MapNotSaved { map: MapId, reason: String },
    MapLoaded(Arc<PriorMap>),
    MapNotLoaded { map: MapId, reason: String },
    PlaceSought(MapSearchResult),
    Relocalised(Box<RelocalisationResponse>),
    DisambiguationPlanned(DisambiguationPlan),
}

impl From<InputV3> for Input {
    fn from(input: InputV3) -> Self {
        match input {
            InputV3::Boot(record) => Self::Boot(Box::new((*record).into())),
            InputV3::Tick => Self::Tick,
            InputV3::Sensor(sensor) => Self::Sensor(sensor),
            InputV3::Command(command) => Self::Command(command.into()),
            InputV3::JobDone(done) => Self::JobDone(JobDone { number: done.job, result: done.result.into() }),
        }
    }
}

impl From<BootRecordV3> for BootRecord {
    /// Uses the default profile, which equals the values that were compiled in then.
    fn from(record: BootRecordV3) -> Self {
        Self {
            profile: RobotProfile { name: record.robot, ..RobotProfile::default() },
            mounting: record.mounting,
            sources: record.sources,
            start_mapping: record.start_mapping,
            leave_loops_open: record.leave_loops_open,
            last_pose: record.last_pose,
            docks: record.docks,
            stop_latch: None,
        }
    }
}

impl From<CommandV3> for Command {
    fn from(command: CommandV3) -> Self {
        // Version 3 had no goal ids, so the goal takes the command's id.
        let goal = GoalId(command.id.0);
        let kind = match command.kind {
            CommandKindV3::TakeControl { name } => CommandKind::TakeControl { name },
            CommandKindV3::ReleaseControl => CommandKind::ReleaseControl,
            CommandKindV3::StartMapping(session) => CommandKind::StartMapping(session),
            CommandKindV3::FinishMapping { map, name } => CommandKind::FinishMapping { map, name },
            CommandKindV3::DiscardMapping => CommandKind::DiscardMapping,
            CommandKindV3::Teleoperate(velocity) => CommandKind::Teleoperate(velocity),
            CommandKindV3::WalkTo(point) => CommandKind::StartGoal { goal, kind: GoalKind::WalkTo(point) },
            CommandKindV3::StopMotion => CommandKind::StopMotion,
            CommandKindV3::AllowMotion => CommandKind::AllowMotion,
            CommandKindV3::AcceptLoop { from, to } => CommandKind::AcceptLoop { from, to },
            CommandKindV3::RejectLoop { from, to } => CommandKind::RejectLoop { from, to },
            CommandKindV3::ProposeLoop { from, to, guess } => CommandKind::ProposeLoop { from, to, guess },
            CommandKindV3::ExtendMap { session, map } => CommandKind::ExtendMap { session, map },
            CommandKindV3::Localise { map, at } => CommandKind::Localise { map, at },
            CommandKindV3::LeaveMap => CommandKind::LeaveMap,
            CommandKindV3::LookAbout => CommandKind::StartGoal { goal, kind: GoalKind::Relocalise },
        };
        Self { id: command.id, by: Principal::operator(command.by), kind }
    }
}

impl From<JobResultV3> for JobResult {
    fn from(result: JobResultV3) -> Self {
        match result {
            JobResultV3::MapSaved { map, bytes } => JobResultV4::MapSaved { map, bytes }.into(),
            JobResultV3::LoopVerified(found) => JobResultV4::LoopVerified(found).into(),
            JobResultV3::VisitCompared(found) => JobResultV4::RevisitCompared(found).into(),
            JobResultV3::LoopNotVerified => {
                JobResultV4::Failed { reason: messages::texts::NO_TIME_FOR_JOB.to_owned() }.into()
            }
            JobResultV3::MapNotSaved { reason, .. } => Self::MapSaving(Err(JobFailure { reason })),
            JobResultV3::MapNotLoaded { reason, .. } => Self::Localisation(Err(JobFailure { reason })),
            JobResultV3::MapLoaded(map) => JobResultV4::MapLoaded(map).into(),
            JobResultV3::PlaceSought(found) => JobResultV4::MapSearched(found).into(),
            JobResultV3::Relocalised(found) => JobResultV4::Relocalised(found).into(),
            JobResultV3::DisambiguationPlanned(plan) => JobResultV4::DisambiguationPlanned(plan).into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::legacy_site::{SiteEntryV13, take_site_entry_v13};
    use messages::DisambiguationTask;
    use uuid::Uuid;

    /// Encodes in version 3 and decodes into the present types.
    fn read(input: &InputV3) -> Input {
        let bytes = postcard::to_stdvec(input).unwrap_or_default();
        match postcard::from_bytes::<InputV3>(&bytes) {
            Ok(input) => input.into(),
            Err(error) => panic!("{error}"),
        }
    }

    #[test]
    fn the_layout_of_version_3_is_frozen() {
        let kind = CommandKindV3::WalkTo(Vec3::new(1.0, 0.0, 0.0));
        let (id, by) = (CommandId(Uuid::from_u128(7)), ClientId(Uuid::from_u128(8)));
        let bytes = postcard::to_stdvec(&InputV3::Command(CommandV3 { id, by, kind })).unwrap_or_default();
        // Variant 3, two ids of 16 bytes with their length before them, variant 6, three numbers.
        assert_eq!((bytes[0], bytes[1], bytes[17], bytes[18], bytes[34], bytes[35]), (3, 16, 7, 16, 8, 6));
        assert_eq!(bytes.len(), 1 + 17 + 17 + 1 + 24);
        let looked = InputV3::Command(CommandV3 { id, by, kind: CommandKindV3::LookAbout });
        assert_eq!(postcard::to_stdvec(&looked).unwrap_or_default().last(), Some(&15));
        let task = DisambiguationTask { map: MapId(Uuid::from_u128(3)), number: 0 };
        let apart = JobResultV3::DisambiguationPlanned(DisambiguationPlan { task, path: Vec::new() });
        assert_eq!(postcard::to_stdvec(&apart).unwrap_or_default().first(), Some(&9));
    }

    #[test]
    fn walks_become_goals_and_the_three_failures_become_one() {
        let (id, by) = (CommandId(Uuid::from_u128(7)), ClientId(Uuid::from_u128(8)));
        let point = Vec3::new(1.0, 2.0, 3.0);
        let walk = InputV3::Command(CommandV3 { id, by, kind: CommandKindV3::WalkTo(point) });
        let goal = GoalId(Uuid::from_u128(7));
        let kind = CommandKind::StartGoal { goal, kind: GoalKind::WalkTo(point) };
        assert_eq!(read(&walk), Input::Command(Command { id, by: Principal::operator(by), kind }));
        let result = JobResultV3::MapNotSaved { map: MapId(Uuid::from_u128(3)), reason: "why".to_owned() };
        let failed = JobResult::MapSaving(Err(JobFailure { reason: "why".to_owned() }));
        let done = Input::JobDone(JobDone { number: 4, result: failed });
        assert_eq!(read(&InputV3::JobDone(JobDoneV3 { job: 4, result })), done);
        let boot = BootRecordV3 {
            robot: "Rex".to_owned(),
            mounting: Mounting::default(),
            sources: Sources::default(),
            start_mapping: None,
            leave_loops_open: true,
            last_pose: None,
            docks: Arc::default(),
        };
        let Input::Boot(record) = read(&InputV3::Boot(Box::new(boot))) else { panic!("no boot record") };
        assert_eq!((record.profile.name.as_str(), record.leave_loops_open), ("Rex", true));
    }

    /// Reads a list of inputs in hexadecimal digits after the name of their schema. Each must be written again as it was.
    fn read_lines<T: Serialize + Into<Input>>(
        text: &str,
        schema: &str,
        take: impl Fn(&[u8]) -> Result<(T, &[u8]), postcard::Error>,
    ) -> Vec<Input> {
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some(schema));
        let mut read = Vec::new();
        for line in lines {
            let digits = line.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).unwrap_or_default());
            let bytes: Vec<u8> = digits.filter_map(|pair| u8::from_str_radix(pair, 16).ok()).collect();
            assert_eq!(bytes.len() * 2, line.len());
            let (input, rest) = match take(&bytes) {
                Ok(read) => read,
                Err(error) => panic!("{line}: {error}"),
            };
            assert_eq!((postcard::to_stdvec(&input).as_ref(), rest.len()), (Ok(&bytes), 0));
            read.push(input.into());
        }
        read
    }

    /// An entry of version 6 to 10, as it was written.
    #[derive(Debug)]
    enum EntryV10 {
        Boot(BootRecordV10),
        Other(Input),
    }

    impl Serialize for EntryV10 {
        fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            match self {
                Self::Boot(record) => serializer.serialize_newtype_variant("Input", 0, "Boot", record),
                Self::Other(input) => input.serialize(serializer),
            }
        }
    }

    fn read_entry_v10(bytes: &[u8]) -> Result<(EntryV10, &[u8]), postcard::Error> {
        match boot_record_v10(bytes) {
            Some(record) => {
                postcard::take_from_bytes(record).map(|(record, rest)| (EntryV10::Boot(record), rest))
            }
            None => postcard::take_from_bytes(bytes).map(|(input, rest)| (EntryV10::Other(input), rest)),
        }
    }

    impl From<EntryV10> for Input {
        fn from(entry: EntryV10) -> Self {
            match entry {
                EntryV10::Boot(record) => Self::Boot(Box::new(record.into())),
                EntryV10::Other(input) => input,
            }
        }
    }

    /// An entry of version 11 to 13, as it was written.
    #[derive(Debug)]
    enum EntryV13 {
        Site(SiteEntryV13),
        Other(Input),
    }

    impl Serialize for EntryV13 {
        fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            match self {
                Self::Site(entry) => entry.serialize(serializer),
                Self::Other(input) => input.serialize(serializer),
            }
        }
    }

    impl From<EntryV13> for Input {
        fn from(entry: EntryV13) -> Self {
            match entry {
                EntryV13::Site(entry) => entry.into(),
                EntryV13::Other(input) => input,
            }
        }
    }

    fn read_entry_v13(bytes: &[u8]) -> Result<(EntryV13, &[u8]), postcard::Error> {
        match take_site_entry_v13(bytes) {
            Some(entry) => entry.map(|(entry, rest)| (EntryV13::Site(entry), rest)),
            None => postcard::take_from_bytes(bytes).map(|(input, rest)| (EntryV13::Other(input), rest)),
        }
    }

    #[test]
    fn the_bytes_of_version_14_are_read_as_they_were_written() {
        let text = include_str!("../tests/journal_layout_v14.txt");
        let read = read_lines(text, INPUT_SCHEMA_V14, |bytes| postcard::take_from_bytes::<Input>(bytes));
        assert_eq!(read.len(), text.lines().count() - 1);
    }

    #[test]
    fn the_bytes_of_versions_11_to_13_are_read_as_they_were_written() {
        for (text, schema) in [
            (include_str!("../tests/journal_layout_v13.txt"), INPUT_SCHEMA_V13),
            (include_str!("../tests/journal_layout_v12.txt"), INPUT_SCHEMA_V12),
            (include_str!("../tests/journal_layout_v11.txt"), INPUT_SCHEMA_V11),
        ] {
            let read = read_lines(text, schema, read_entry_v13);
            assert_eq!(read.len(), text.lines().count() - 1, "{schema}");
        }
    }

    #[test]
    fn the_bytes_of_versions_6_to_10_are_read_as_they_were_written() {
        for (text, schema) in [
            (include_str!("../tests/journal_layout_v10.txt"), INPUT_SCHEMA_V10),
            (include_str!("../tests/journal_layout_v9.txt"), INPUT_SCHEMA_V9),
            (include_str!("../tests/journal_layout_v8.txt"), INPUT_SCHEMA_V8),
            (include_str!("../tests/journal_layout_v7.txt"), INPUT_SCHEMA_V7),
            (include_str!("../tests/journal_layout_v6.txt"), INPUT_SCHEMA_V6),
        ] {
            let read = read_lines(text, schema, read_entry_v10);
            let Input::Boot(record) = &read[0] else { panic!("no boot record") };
            assert_eq!(
                (record.profile.name.as_str(), record.stop_latch.is_some()),
                ("Rex", true),
                "{schema}"
            );
            assert_eq!(record.profile.camera_head, vocab::CameraHead::COMMON, "{schema}");
            assert_eq!(read.len(), text.lines().count() - 1, "{schema}");
        }
    }

    #[test]
    fn the_bytes_of_version_5_are_read_as_they_were_written() {
        let read = read_lines(include_str!("../tests/journal_layout_v5.txt"), INPUT_SCHEMA_V5, |bytes| {
            postcard::take_from_bytes::<InputV5>(bytes)
        });
        let Input::Boot(record) = &read[0] else { panic!("no boot record") };
        assert_eq!((record.profile.name.as_str(), record.docks.len()), ("Rex", 1));
        assert_eq!(record.stop_latch, None);
        let commands = read.iter().filter(|input| matches!(input, Input::Command(_))).count();
        assert_eq!((read.len(), commands), (31, 17));
        let owner = messages::JobOwner::LoopClosing;
        let failed = messages::JobId { owner, number: 301 }.failed("why");
        assert!(read.contains(&Input::JobDone(failed)));
        assert_eq!(read.last(), Some(&Input::GraphRequested));
    }

    /// The bytes that the program of November 2026 wrote of every input but sensors.
    #[test]
    fn the_bytes_of_version_4_are_read_as_they_were_written() {
        let read = read_lines(include_str!("../tests/journal_layout_v4.txt"), INPUT_SCHEMA_V4, |bytes| {
            postcard::take_from_bytes::<InputV4>(bytes)
        });
        assert!(matches!(&read[0], Input::Boot(record) if record.profile.name == "Rex"));
        let commands = read.iter().filter(|input| matches!(input, Input::Command(_))).count();
        assert_eq!((read.len(), commands), (27, 17));
        let saved = JobResult::MapSaving(Ok(MapId(Uuid::from_u128(1))));
        assert!(read.contains(&Input::JobDone(JobDone { number: 300, result: saved })));
        let failed = JobResult::LoopClosing(Err(JobFailure { reason: "why".to_owned() }));
        assert!(read.contains(&Input::JobDone(JobDone { number: 301, result: failed })));
        assert!(read.contains(&Input::WallClock { utc_ns: 1_700_000_000_000_000_000, synchronised: true }));
        let cancelled =
            Input::ActionDone { call: ActionCallId(Uuid::from_u128(8)), outcome: ActionOutcome::Cancelled };
        assert_eq!(read.last(), Some(&cancelled));
    }
}
