//! The life of a mapping session: idle, loading, starting, running, closing its last loops, saving. The algorithms are in `mapping`; this file
//! hands them scans, starts their jobs, and publishes what they find.

use crate::loop_texts;
use crate::mapping_messages::{self as plain, ComparisonTask};
use crate::odometry_adapter::LocatedScan;
use crate::prior_map::{BaseMap, PreparedMap};
use crate::texts;
use crate::work::{ComputeJob, Work};
use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use mapping::{
    AddedWaypoint, GraphPublisher, KeyframePolicy, LastSavedMap, LastSavedMapConfig, LoopClosing,
    LoopClosingConfig, LoopEvents, MapSearch, MapSearchFix, OptimiserConfig, PoseGraph, ScanPose, Session,
    SessionConfig,
};
use messages::{
    BootRecord, Cloud, CommandKind, DegenerateStretch, FinishedMap, Job, JobFailure, Keyframe, LoopDecision,
    MapQuality, MapSearchOutcome, MapSearchResult, MapSearchTask, MappingState, PlaceComparison, PriorMap,
    Publication, Reanchored, RevisitCounts, StackEffect,
};
use points::Downsampler;
use std::sync::Arc;
use vocab::{KeyframeId, MapId, Pose, SessionId, Span, Stamp};

/// Parameters of a mapping session.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MappingConfig {
    /// Edge of the voxels in which clouds of keyframes are averaged, metres. Well below what a person can tell apart on the map, and a tenth of the
    /// points of a full-resolution sweep near the robot.
    keyframe_voxel_m: f32,
    /// Time that a finished map waits for its last comparisons, and then for its relinearisation. Walks mostly end where they began. Far longer than all
    /// comparisons that may wait take.
    max_closing_time: Span,
    /// Time between two computations of the quality of a map that changes.
    quality_period: Span,
    /// The period grows by itself each time the graph has grown by this number of keyframes, because the cost grows with them.
    quality_keyframes: usize,
}

impl Default for MappingConfig {
    fn default() -> Self {
        Self {
            keyframe_voxel_m: 0.04,
            max_closing_time: Span::from_millis(10_000),
            quality_period: Span::from_millis(2_000),
            quality_keyframes: 500,
        }
    }
}

/// The phase and what it needs.
#[derive(Debug, Default)]
pub(crate) struct MappingPhase {
    config: MappingConfig,
    phase: Phase,
    /// Of the last session that has ended.
    map_from_odom: Option<Isometry>,
    /// The map that was saved last.
    last_saved: Option<LastSavedMap>,
    downsampler: Downsampler,
    published: Option<MappingState>,
    /// Where the LiDAR is, base frame, metres.
    sensor: [f32; 3],
    keyframe_policy: KeyframePolicy,
    leave_loops_open: bool,
    /// Number of the next job that computes the quality. These are counted apart, so that the numbers of other jobs do not depend on them.
    quality_jobs: u64,
}

#[derive(Debug, Default)]
enum Phase {
    #[default]
    Idle,
    /// A saved map is being read; the job is none until it has started.
    Loading {
        session: SessionId,
        map: MapId,
        job: Option<u64>,
    },
    Starting(SessionId, Option<Box<BaseMap>>),
    Running(Running),
    /// Nothing is added any more. The last pairs are compared, then the graph is relinearised.
    Closing {
        map: MapId,
        name: String,
        since: Stamp,
        /// The job that relinearises the graph, and when it was started.
        relinearisation: Option<(u64, Stamp)>,
        running: Running,
    },
    Saving {
        map: MapId,
        job: u64,
        /// Kept until the map is on disk.
        running: Running,
    },
}

#[derive(Debug)]
struct Running {
    id: SessionId,
    extends: Option<MapId>,
    since: Stamp,
    session: Box<Session>,
    /// None where loops are left open.
    loops: Option<Box<LoopClosing>>,
    /// While the robot is not localised in the map that the session extends.
    search: Option<(MapId, Box<MapSearch>)>,
    /// What was published of the graph.
    graph_publisher: GraphPublisher,
    /// When the last computation of the quality was started, and the revision of the graph then.
    last_quality: Option<(Stamp, u64)>,
    /// The job that computes it.
    quality_job: Option<u64>,
}

/// What a scan changed in the map.
pub(crate) enum MapUpdate {
    /// It became a keyframe.
    Keyframe { keyframe: Keyframe, graph: Option<Publication>, events: MappingEvents },
    /// The robot was localised in the map that the session extends.
    Localised,
}

/// What to publish.
#[derive(Debug, Default)]
pub(crate) struct MappingEvents {
    /// New decisions about loops.
    pub decisions: Vec<LoopDecision>,
    /// The robot's pose was confirmed on known ground.
    pub reanchored: Option<Reanchored>,
    /// Whether edges or poses of the graph changed.
    pub is_graph_changed: bool,
    /// Whether the robot was localised in the map that the session extends.
    pub is_localised: bool,
    /// Why loops are not closed any more; said once.
    pub warning: Option<String>,
}

impl MappingPhase {
    /// For the robot of a boot record.
    pub fn new(record: &BootRecord) -> Self {
        let base_from_lidar = record.mounting.base_from_lidar.as_ref().and_then(isometry_from_pose);
        let sensor = base_from_lidar.unwrap_or_else(Isometry::identity).translation.vector.map(|c| c as f32);
        let keyframe_policy = KeyframePolicy {
            distance_m: record.profile.keyframe_distance_m,
            rotation_rad: record.profile.keyframe_rotation_rad,
        };
        Self {
            sensor: sensor.into(),
            keyframe_policy,
            leave_loops_open: record.leave_loops_open,
            ..Self::default()
        }
    }

    /// Where the LiDAR is, base frame, metres.
    pub fn sensor(&self) -> [f32; 3] {
        self.sensor
    }

    /// Whether there is no session, nor one being saved.
    pub fn is_idle(&self) -> bool {
        matches!(self.phase, Phase::Idle)
    }

    /// Where the odometry's frame is in the map of the last session; the same frame before the first. A loop closure moves
    /// it.
    pub fn map_from_odom(&self) -> Isometry {
        let running = match &self.phase {
            Phase::Running(running) | Phase::Closing { running, .. } | Phase::Saving { running, .. } => {
                Some(running)
            }
            Phase::Idle | Phase::Loading { .. } | Phase::Starting(..) => None,
        };
        let of_running = running.map(|running| *running.session.map_from_odom());
        of_running.or(self.map_from_odom).unwrap_or_else(Isometry::identity)
    }

    /// Begins a session at the next scan.
    pub fn start(&mut self, id: SessionId) -> Result<(), String> {
        self.begin(id, Phase::Starting(id, None))
    }

    /// Begins a session that goes on from a saved map, once that has been read.
    pub fn extend(&mut self, session: SessionId, map: MapId) -> Result<(), String> {
        if self.leave_loops_open {
            return Err(texts::EXTENDING_NEEDS_LOOPS.to_owned());
        }
        self.begin(session, Phase::Loading { session, map, job: None })
    }

    fn begin(&mut self, id: SessionId, first: Phase) -> Result<(), String> {
        match &self.phase {
            Phase::Idle => {
                self.phase = first;
                Ok(())
            }
            Phase::Loading { session: running, .. }
            | Phase::Starting(running, _)
            | Phase::Running(Running { id: running, .. })
                if *running == id =>
            {
                Ok(())
            }
            Phase::Loading { .. } | Phase::Starting(..) | Phase::Running(_) => {
                Err(texts::MAPPING_RUNS.to_owned())
            }
            Phase::Closing { .. } | Phase::Saving { .. } => Err(texts::MAP_STILL_SAVING.to_owned()),
        }
    }

    /// The saved map has been read, or could not be; `supplied` may be its prepared form. Maps that nobody waits for are ignored.
    ///
    /// # Errors
    /// Why there is no session then.
    pub fn finish_loading(
        &mut self,
        job: u64,
        read: &Result<Arc<PriorMap>, JobFailure>,
        supplied: Option<PreparedMap>,
    ) -> Result<(), String> {
        let Phase::Loading { session, job: Some(waited), .. } = self.phase else { return Ok(()) };
        if waited != job {
            return Ok(());
        }
        self.phase = Phase::Idle;
        let read = read.as_ref().map_err(|failure| texts::map_not_usable(&failure.reason))?;
        let base = PreparedMap::extension(supplied, read, self.sensor)?;
        self.phase = Phase::Starting(session, Some(base));
        Ok(())
    }

    /// Throws the session away.
    pub fn discard(&mut self) -> Result<(), String> {
        match self.phase {
            Phase::Loading { .. } | Phase::Starting(..) | Phase::Running(_) => {
                self.end();
                Ok(())
            }
            Phase::Closing { .. } | Phase::Saving { .. } => Err(texts::MAP_SAVING_CANNOT_DISCARD.to_owned()),
            Phase::Idle => Err(texts::NO_MAPPING.to_owned()),
        }
    }

    /// Ends the session; [`Self::close`] goes on with it.
    pub fn finish(&mut self, at: Stamp, map: MapId, name: &str) -> Result<(), String> {
        let Phase::Running(Running { session, search, .. }) = &self.phase else {
            return Err(texts::NO_MAPPING.to_owned());
        };
        if search.is_some() {
            return Err(texts::NOT_LOCALISED_IN_EXTENDED_MAP.to_owned());
        }
        if session.graph().nodes().is_empty() {
            return Err(texts::MAP_EMPTY.to_owned());
        }
        let name = name.trim();
        if name.is_empty() {
            return Err(texts::MAP_NEEDS_NAME.to_owned());
        }
        let name = name.chars().take(120).collect();
        if let Phase::Running(running) = std::mem::take(&mut self.phase) {
            self.phase = Phase::Closing { map, name, since: at, relinearisation: None, running };
        }
        Ok(())
    }

    /// Goes on with a session that was ended, if it may. Its last pairs of keyframes are compared, then its graph is relinearised, then its map is
    /// saved. Each wait is bounded. `jobs` counts all jobs of the stack.
    pub fn close(&mut self, at: Stamp, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        let Phase::Closing { since, relinearisation, running, .. } = &mut self.phase else { return };
        let is_overdue = |since: Stamp| at - since >= self.config.max_closing_time;
        match relinearisation {
            Some((job, started)) => {
                if is_overdue(*started) {
                    let job = *job;
                    self.save(job, effects);
                }
            }
            None => {
                let Running { id, session, loops, .. } = running;
                if loops.as_ref().is_some_and(|loops| loops.is_comparing()) && !is_overdue(*since) {
                    return;
                }
                let job = *jobs;
                *jobs += 1;
                if loops.as_mut().is_some_and(|loops| loops.finish(session)) {
                    *relinearisation = Some((job, at));
                    effects.push(StackEffect::start_job(job, Job::Relinearise(*id)));
                } else {
                    self.save(job, effects);
                }
            }
        }
    }

    /// A snapshot of the graph of a session that ends.
    pub fn take_relinearisation(&self, job: u64) -> Option<ComputeJob> {
        let Phase::Closing { relinearisation: Some((waited, _)), running, .. } = &self.phase else {
            return None;
        };
        let work = running.session.graph().relinearisation().filter(|_| *waited == job)?;
        Some(ComputeJob::new(job, Work::Relinearise(work)))
    }

    /// The graph of a session that ends was relinearised. If not, the poses stay as they were. The map is saved either way. Returns a warning.
    pub fn finish_relinearisation(
        &mut self,
        job: u64,
        result: &Result<Vec<Pose>, JobFailure>,
        effects: &mut Vec<StackEffect>,
    ) -> Option<String> {
        let Phase::Closing { relinearisation: Some((waited, _)), running, .. } = &mut self.phase else {
            return None;
        };
        if *waited != job {
            return None;
        }
        let session = &mut running.session;
        let count = session.graph().nodes().len();
        let poses = result.as_ref().ok().and_then(|poses| plain::relinearised_from_plain(poses, count));
        if let Some(poses) = poses {
            session.move_keyframes(&poses);
        }
        self.save(job, effects);
        result.as_ref().err().map(|failure| texts::map_not_relinearised(&failure.reason))
    }

    /// Saves the map of a session that was ended, in the job with this number.
    fn save(&mut self, job: u64, effects: &mut Vec<StackEffect>) {
        let (map, name, since, running) = match std::mem::take(&mut self.phase) {
            Phase::Closing { map, name, since, running, .. } => (map, name, since, running),
            other => {
                self.phase = other;
                return;
            }
        };
        let Running { id, extends, session, loops, .. } = &running;
        let finished = FinishedMap {
            map,
            name,
            session: *id,
            extends: *extends,
            at: since,
            distance: session.distance_m(),
            graph: Arc::new(plain::graph_to_plain(session)),
            trajectory: session.trajectory().iter().map(|(s, p)| (*s, pose_from_isometry(p))).collect(),
            degenerate: session
                .degenerate_segments()
                .iter()
                .map(|s| DegenerateStretch { from: s.from, until: s.until, distance: s.distance_m })
                .collect(),
            decisions: loops.as_ref().map_or_else(Vec::new, |loops| decisions_to_plain(*id, loops)),
            unverified: loops.as_ref().map_or(0, |loops| loops.skipped()),
            revisits: loops.as_ref().map_or_else(RevisitCounts::default, |loops| {
                let mapping::RevisitCounts { compared, confirmed } = loops.revisits();
                RevisitCounts { compared, confirmed }
            }),
        };
        effects.push(StackEffect::start_job(job, Job::SaveMap(Arc::new(finished))));
        self.phase = Phase::Saving { map, job, running };
    }

    /// The save has ended: the session is over, or goes on if its map could not be written. Returns whether a session waited for it.
    pub fn finish_saving(&mut self, job: u64, result: &Result<MapId, JobFailure>) -> bool {
        match std::mem::take(&mut self.phase) {
            // In journals up to version 4 the graph was relinearised within a step, and the save ended next.
            Phase::Saving { map, job: waited, running }
            | Phase::Closing { map, relinearisation: Some((waited, _)), running, .. }
                if waited == job =>
            {
                self.phase = Phase::Running(running);
                if result.is_ok() {
                    self.end();
                    self.last_saved =
                        Some(LastSavedMap::new(LastSavedMapConfig::default(), map, self.map_from_odom()));
                }
                true
            }
            other => {
                self.phase = other;
                false
            }
        }
    }

    /// No session any more; the map's frame stays until the next one begins.
    fn end(&mut self) {
        self.map_from_odom = Some(self.map_from_odom());
        self.phase = Phase::Idle;
    }

    /// Starts jobs that are due. `jobs` counts all jobs of the stack.
    pub fn start_jobs(&mut self, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        match &mut self.phase {
            Phase::Loading { session, map, job: job @ None } => {
                let work = Job::LoadMap { session: *session, map: *map };
                effects.push(StackEffect::start_job(*jobs, work));
                *job = Some(*jobs);
                *jobs += 1;
            }
            Phase::Running(Running { id, search: Some((map, search)), .. }) => {
                if let Some(job) = search.start(jobs) {
                    let work = Job::SearchMap(search_task(*id, *map, search));
                    effects.push(StackEffect::start_job(job, work));
                }
            }
            _ => {
                if let Some((id, _, loops)) = self.loop_closing() {
                    for (job, queued) in loops.start(jobs) {
                        let work = ComparisonTask::new(id, &queued).job();
                        effects.push(StackEffect::start_job(job, work));
                    }
                }
            }
        }
    }

    /// The work of a search in the map that the session extends.
    pub fn take_search(&mut self, job: u64) -> Option<ComputeJob> {
        let Phase::Running(Running { id, search: Some((map, search)), .. }) = &self.phase else {
            return None;
        };
        let (task, data) = (search_task(*id, *map, search), Box::new(search.data(job)?));
        Some(ComputeJob::new(job, Work::SearchMap { task, data }))
    }

    /// The work of a comparison; once.
    pub fn take_comparison(&mut self, job: u64) -> Option<ComputeJob> {
        let (id, _, loops) = self.loop_closing()?;
        let (queued, comparison) = loops.take_comparison(job)?;
        let (task, config) = (ComparisonTask::new(id, &queued), loops.config().verification);
        Some(ComputeJob::new(job, Work::Compare { task, comparison, config }))
    }

    /// A search has ended, with or without a result. Searches of a session that has ended are ignored.
    pub fn finish_search(
        &mut self,
        job: u64,
        result: &Result<Box<MapSearchResult>, JobFailure>,
    ) -> MappingEvents {
        let Phase::Running(running) = &mut self.phase else { return MappingEvents::default() };
        let Some((_, search)) = &mut running.search else { return MappingEvents::default() };
        let found = result.as_ref().ok().map(|result| &result.found);
        let is_ambiguous = found.and_then(|found| match found {
            MapSearchOutcome::Found { .. } => None,
            other => Some(matches!(other, MapSearchOutcome::Ambiguous(..))),
        });
        let fix = search.end(job, is_ambiguous).then(|| found.and_then(plain::fix_from_plain)).flatten();
        let is_localised = fix.is_some_and(|fix| running.localise(&fix));
        MappingEvents { is_localised, is_graph_changed: is_localised, ..MappingEvents::default() }
    }

    /// A comparison has ended, with or without a result. Comparisons of a session that has ended are ignored.
    pub fn finish_comparison(
        &mut self,
        job: u64,
        result: &Result<PlaceComparison, JobFailure>,
    ) -> MappingEvents {
        let Some((id, session, loops)) = self.loop_closing() else { return MappingEvents::default() };
        let mut reanchored = None;
        let events = match result {
            Ok(PlaceComparison::Loop(found)) => match plain::verified_from_plain(found) {
                Some(result) => {
                    let pair = (found.task.from, found.task.to);
                    loops.complete_pair(job, pair, &result, session)
                }
                None => {
                    loops.ignore_comparison(job);
                    LoopEvents::default()
                }
            },
            Ok(PlaceComparison::Revisit(found)) => match plain::compared_from_plain(found) {
                Some(result) => {
                    let revisit = (found.task.waypoint, found.task.keyframe);
                    let events = loops.complete_revisit(job, revisit, &result, session);
                    reanchored = events.reanchored.map(|event| Reanchored {
                        session: id,
                        stamp: event.stamp,
                        keyframe: event.keyframe,
                        keyframe_from_base: found.keyframe_from_base,
                        information: found.information,
                    });
                    events
                }
                None => {
                    loops.ignore_comparison(job);
                    LoopEvents::default()
                }
            },
            Err(_) => {
                loops.fail_comparison(job);
                LoopEvents::default()
            }
        };
        MappingEvents { reanchored, ..events_to_plain(id, &events, loops) }
    }

    /// Carries out a person's command about loops.
    pub fn handle_loop_command(&mut self, command: &CommandKind) -> Result<MappingEvents, String> {
        let Some((id, session, loops)) = self.loop_closing() else {
            return Err(texts::NO_MAPPING_WITH_LOOPS.to_owned());
        };
        let events = match command {
            CommandKind::AcceptLoop { from, to } => loops.accept(*from, *to, session),
            CommandKind::RejectLoop { from, to } => loops.reject(*from, *to, session),
            CommandKind::ProposeLoop { from, to, guess } => {
                let Some(guess) = isometry_from_pose(guess) else {
                    return Err(texts::LOOP_GUESS_NOT_FINITE.to_owned());
                };
                let proposed = loops.propose(*from, *to, &guess, session);
                proposed.map_err(|error| loop_texts::proposal_refusal(&error))?;
                return Ok(MappingEvents::default());
            }
            _ => return Ok(MappingEvents::default()),
        };
        let events = events.map_err(|error| loop_texts::refusal(&error))?;
        Ok(events_to_plain(id, &events, loops))
    }

    /// Starts to compute the quality of the map, if that is due. At most one such job runs at a time.
    pub fn start_quality(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        let Phase::Running(running) = &mut self.phase else { return };
        if running.loops.is_none() || running.search.is_some() || running.quality_job.is_some() {
            return;
        }
        let (graph, config) = (running.session.graph(), &self.config);
        let period = config.quality_period * (1 + graph.nodes().len() / config.quality_keyframes) as i64;
        let revision = graph.revision();
        if running.last_quality.is_some_and(|(last, known)| known == revision || at - last < period) {
            return;
        }
        running.last_quality = Some((at, revision));
        running.quality_job = Some(self.quality_jobs);
        effects.push(StackEffect::start_job(self.quality_jobs, Job::AssessQuality(running.id)));
        self.quality_jobs += 1;
    }

    /// A snapshot of the map for its quality.
    pub fn take_quality(&self, job: u64) -> Option<ComputeJob> {
        let Phase::Running(Running { session, loops: Some(loops), quality_job, .. }) = &self.phase else {
            return None;
        };
        let work = || Work::AssessQuality {
            revision: session.graph().revision(),
            data: loops.quality_data(session),
        };
        (*quality_job == Some(job)).then(|| ComputeJob::new(job, work()))
    }

    /// The quality was computed, or was not. Returns it for publication, also if the graph has changed since: the next one follows. The quality of
    /// a session that has ended is ignored.
    pub fn finish_quality(&mut self, job: u64, result: Result<MapQuality, JobFailure>) -> Option<MapQuality> {
        let is_running = matches!(self.phase, Phase::Running(_));
        let quality_job = &mut self.running_mut()?.quality_job;
        quality_job.take_if(|running| *running == job)?;
        result.ok().filter(|_| is_running)
    }

    /// What changed in the graph of the running session since it was published last.
    pub fn graph_changes(&mut self) -> Option<Publication> {
        match &mut self.phase {
            Phase::Running(running) | Phase::Closing { running, .. } => running.graph_changes(),
            _ => None,
        }
    }

    /// The whole graph of the running session, if any of it was published: changes from now on apply to this one.
    pub fn whole_graph(&mut self) -> Option<Publication> {
        match &mut self.phase {
            Phase::Running(running) | Phase::Closing { running, .. } => {
                running.graph_publisher.forget_published().then(|| running.graph_changes())?
            }
            _ => None,
        }
    }

    /// The session, if it has begun.
    fn running_mut(&mut self) -> Option<&mut Running> {
        match &mut self.phase {
            Phase::Running(running) | Phase::Closing { running, .. } | Phase::Saving { running, .. } => {
                Some(running)
            }
            Phase::Idle | Phase::Loading { .. } | Phase::Starting(..) => None,
        }
    }

    /// The running session and its loop closing, if there is one and its graph may still change.
    fn loop_closing(&mut self) -> Option<(SessionId, &mut Session, &mut LoopClosing)> {
        match &mut self.phase {
            Phase::Running(Running { id, session, loops: Some(loops), .. })
            | Phase::Closing {
                running: Running { id, session, loops: Some(loops), .. },
                relinearisation: None,
                ..
            } => Some((*id, session, loops)),
            _ => None,
        }
    }

    /// Whether the next located scan begins a session, and so a new map frame.
    pub fn is_starting(&self) -> bool {
        matches!(self.phase, Phase::Starting(..))
    }

    /// Adds a located scan.
    pub fn add(&mut self, located: &LocatedScan) -> Option<MapUpdate> {
        if let Some(last_saved) = &mut self.last_saved {
            last_saved.update(&located.odom_from_base, &located.covariance);
        }
        if self.is_starting()
            && let Phase::Starting(id, base) = std::mem::take(&mut self.phase)
        {
            self.phase = Phase::Running(self.begin_session(id, base, located));
        }
        let Phase::Running(running) = &mut self.phase else { return None };
        let Running { id: session_id, session, loops, search, .. } = &mut *running;
        let waypoint = session.add_scan_pose(&ScanPose {
            stamp: located.stamp,
            odom_from_base: located.odom_from_base,
            scan_stamp: located.scan_stamp,
            odom_from_base_at_scan: located.odom_from_base_at_scan,
            covariance: located.covariance,
            covariance_inflation: located.covariance_inflation,
            is_degenerate: located.degenerate.iter().any(Option::is_some),
            is_dead_reckoned: located.is_dead_reckoned,
        })?;
        let cloud = thinned(&mut self.downsampler, &located.cloud, self.config.keyframe_voxel_m);
        let Some(loops) = loops else {
            let id = session.add_keyframe(&waypoint).id;
            return Some(running.keyframe(id, cloud, self.sensor, MappingEvents::default()));
        };
        let (added, events) = loops.add_waypoint(session, &waypoint, &cloud.xyz);
        match added {
            AddedWaypoint::Keyframe(id) => {
                let events = events_to_plain(*session_id, &events, loops);
                Some(running.keyframe(id, cloud, self.sensor, events))
            }
            AddedWaypoint::Revisit => None,
            AddedWaypoint::Unlocalised(number) => {
                let (map, search) = search.as_mut()?;
                search.add_waypoint(number, &located.odom_from_base, &cloud.xyz, self.sensor);
                let (pose, covariance) = (&located.odom_from_base, &located.covariance);
                let fix =
                    self.last_saved.as_ref()?.locate(*map, number, pose, covariance, session.graph())?;
                running.localise(&fix).then_some(MapUpdate::Localised)
            }
        }
    }

    /// A session that begins with a located scan.
    fn begin_session(&self, id: SessionId, base: Option<Box<BaseMap>>, located: &LocatedScan) -> Running {
        let config = SessionConfig { keyframes: self.keyframe_policy, ..SessionConfig::default() };
        let (pose, since) = (&located.odom_from_base, located.stamp);
        let Some(base) = base else {
            let graph = match self.leave_loops_open {
                true => PoseGraph::default(),
                false => PoseGraph::new(OptimiserConfig::default()),
            };
            let session = Box::new(Session::begin(pose, config, graph));
            let closing = || Box::new(LoopClosing::new(LoopClosingConfig::default(), self.sensor));
            let loops = (!self.leave_loops_open).then(closing);
            return Running {
                id,
                extends: None,
                since,
                session,
                loops,
                search: None,
                graph_publisher: GraphPublisher::default(),
                last_quality: None,
                quality_job: None,
            };
        };
        let BaseMap { map, graph, loops, search } = *base;
        let session = Box::new(Session::begin(pose, config, graph));
        let (loops, search) = (Some(loops), Some((map, search)));
        Running {
            id,
            extends: Some(map),
            since,
            session,
            loops,
            search,
            graph_publisher: GraphPublisher::default(),
            last_quality: None,
            quality_job: None,
        }
    }

    /// Pose of the odometry's frame in a saved map, if the robot has just made that map and has not walked far since.
    pub fn map_from_odom_of(&self, map: MapId, located: &LocatedScan) -> Option<Isometry> {
        self.last_saved.as_ref()?.map_from_odom(map, &located.covariance)
    }

    /// The state, if it changed since it was last said.
    pub fn changed(&mut self) -> Option<MappingState> {
        let state = match &self.phase {
            Phase::Idle => MappingState::Idle,
            Phase::Loading { session, map, .. } => MappingState::Loading { session: *session, map: *map },
            Phase::Starting(session, _) => MappingState::Starting { session: *session },
            Phase::Running(Running { id, search: Some((map, search)), .. }) => MappingState::Finding {
                session: *id,
                map: *map,
                distance: search.distance_m().round(),
                ambiguous: search.is_ambiguous(),
            },
            Phase::Running(Running { id, extends, since, session, .. }) => MappingState::Mapping {
                session: *id,
                extends: *extends,
                since: *since,
                distance: (session.distance_m() * 10.0).round() / 10.0,
                keyframes: session.graph().nodes().len() as u32,
                on_known_ground: session.is_revisiting(),
            },
            Phase::Closing { map, running, .. } => MappingState::Saving { session: running.id, map: *map },
            Phase::Saving { map, running, .. } => MappingState::Saving { session: running.id, map: *map },
        };
        if self.published.as_ref() == Some(&state) {
            return None;
        }
        self.published = Some(state.clone());
        Some(state)
    }
}

impl Running {
    /// Sets the robot's pose in the map that the session extends. Returns whether it was plausible.
    fn localise(&mut self, fix: &MapSearchFix) -> bool {
        let is_localised =
            self.loops.as_mut().is_some_and(|loops| loops.localise_in_map(fix, &mut self.session));
        if is_localised {
            self.search = None;
        }
        is_localised
    }

    /// What changed in the graph since it was published last; at first all of it.
    fn graph_changes(&mut self) -> Option<Publication> {
        let changes = self.graph_publisher.update(self.session.graph())?;
        Some(match changes.base_revision {
            0 => {
                Publication::Graph { session: self.id, graph: Arc::new(plain::graph_to_plain(&self.session)) }
            }
            _ => Publication::GraphDelta(Arc::new(plain::changes_to_plain(self.id, &changes))),
        })
    }

    /// A new keyframe, as it is published.
    fn keyframe(
        &mut self,
        id: KeyframeId,
        cloud: Cloud,
        lidar: [f32; 3],
        events: MappingEvents,
    ) -> MapUpdate {
        let node = self.session.graph().nodes().last();
        let keyframe = Keyframe {
            session: self.id,
            id,
            stamp: node.map_or(Stamp::EPOCH, |node| node.stamp),
            map_from_keyframe: node
                .map_or(Pose::IDENTITY, |node| pose_from_isometry(&node.map_from_keyframe)),
            cloud: Arc::new(cloud),
            lidar,
        };
        MapUpdate::Keyframe { keyframe, graph: self.graph_changes(), events }
    }
}

fn search_task(session: SessionId, map: MapId, search: &MapSearch) -> MapSearchTask {
    MapSearchTask { session, map, waypoint: search.newest_waypoint() }
}

fn decisions_to_plain(id: SessionId, loops: &LoopClosing) -> Vec<LoopDecision> {
    let config = &loops.config().verification;
    loops.decisions().iter().map(|record| plain::decision_to_plain(id, record, config)).collect()
}

fn events_to_plain(id: SessionId, events: &LoopEvents, loops: &LoopClosing) -> MappingEvents {
    let config = &loops.config().verification;
    let decision = |record| plain::decision_to_plain(id, record, config);
    MappingEvents {
        decisions: events.decisions.iter().map(decision).collect(),
        is_graph_changed: events.is_graph_changed,
        warning: events.failure.as_ref().map(loop_texts::graph_failed),
        ..MappingEvents::default()
    }
}

fn thinned(downsampler: &mut Downsampler, cloud: &Cloud, voxel_m: f32) -> Cloud {
    let mut centroids = Vec::new();
    downsampler.downsample(&cloud.xyz, &cloud.intensity, voxel_m, &mut centroids);
    Cloud {
        xyz: centroids.iter().map(|c| c.xyz).collect(),
        intensity: if cloud.intensity.is_empty() {
            Vec::new()
        } else {
            centroids.iter().map(|c| c.attribute).collect()
        },
    }
}
