//! The life of a mapping session: idle, loading, starting, running, closing its last loops, saving. The algorithms are in `mapping`; this file
//! hands them scans, starts their jobs, and publishes what they find.

use crate::loop_texts;
use crate::mapping_messages as plain;
use crate::odometry_adapter::LocatedScan;
use crate::prior_map::DecodedPriorMap;
use crate::texts;
use crate::work::ComputeJob;
use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use mapping::{
    AddedWaypoint, GraphPublisher, KeyframePolicy, LastSavedMap, LastSavedMapConfig, LoopClosing,
    LoopClosingConfig, LoopEvents, MapSearch, MapSearchConfig, MapSearchFix, OptimiserConfig, PoseGraph,
    ScanPose, Session, SessionConfig,
};
use messages::{
    BootRecord, Cloud, CommandKind, DegenerateStretch, FinishedMap, Job, JobDone, JobResult, Keyframe,
    LoopDecision, MapQuality, MapSearchOutcome, MapSearchTask, MappingState, PriorMap, Publication,
    Reanchored, RevisitCounts, StackEffect,
};
use points::Downsampler;
use std::sync::Arc;
use vocab::{KeyframeId, MapId, SessionId, Span, Stamp};

/// Parameters of a mapping session.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MappingConfig {
    /// Edge of the voxels in which clouds of keyframes are averaged, metres. Well below what a person can tell apart on the map, and a tenth of the
    /// points of a full-resolution sweep near the robot.
    keyframe_voxel_m: f32,
    /// Time that a finished map waits for its last comparisons. Walks mostly end where they began. Far longer than all comparisons that may wait
    /// take.
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
    /// Nothing is added any more; the last pairs are being looked at.
    Closing {
        map: MapId,
        name: String,
        since: Stamp,
        running: Running,
    },
    Saving {
        map: MapId,
        /// Kept until the map is on disk.
        unsaved: Running,
    },
}

/// The finished map that a session extends.
#[derive(Debug)]
struct BaseMap {
    map: MapId,
    graph: PoseGraph,
    loops: Box<LoopClosing>,
    search: Box<MapSearch>,
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
    /// When the quality was computed last, and the revision of the graph then.
    last_quality: Option<(Stamp, u64)>,
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
            Phase::Running(running)
            | Phase::Closing { running, .. }
            | Phase::Saving { unsaved: running, .. } => Some(running),
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

    /// The saved map has been read, or could not be. Maps that nobody waits for are ignored.
    ///
    /// # Errors
    /// Why there is no session then.
    pub fn loaded(&mut self, job: u64, read: Result<&PriorMap, &str>) -> Result<(), String> {
        let Phase::Loading { session, job: Some(waited), .. } = self.phase else { return Ok(()) };
        if waited != job {
            return Ok(());
        }
        self.phase = Phase::Idle;
        let prior = DecodedPriorMap::decode(read?)?;
        let search = MapSearch::new(MapSearchConfig::default(), prior.matcher());
        let DecodedPriorMap { map, nodes, keyframes, edges, loops } = prior;
        let graph = PoseGraph::resume(nodes, edges, loops, OptimiserConfig::default());
        let mut graph = graph.map_err(|error| texts::map_not_extendable(&error))?;
        let loops = LoopClosing::resume(LoopClosingConfig::default(), self.sensor, &keyframes, &mut graph);
        let (loops, search) = (Box::new(loops), Box::new(search));
        self.phase = Phase::Starting(session, Some(Box::new(BaseMap { map, graph, loops, search })));
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

    /// Ends the session; [`Self::closed`] hands its map over.
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
            self.phase = Phase::Closing { map, name, since: at, running };
        }
        Ok(())
    }

    /// The map of a session that was ended, once its last pairs of keyframes have been looked at or it is too long ago; it has
    /// to be saved.
    pub fn closed(&mut self, at: Stamp) -> Option<FinishedMap> {
        let Phase::Closing { map, name, since, running } = &mut self.phase else { return None };
        let Running { id, extends, session, loops, .. } = running;
        if loops.as_ref().is_some_and(|loops| loops.is_comparing())
            && at - *since < self.config.max_closing_time
        {
            return None;
        }
        if let Some(loops) = loops {
            // A failure at the very end leaves the poses as they were. They are saved like that.
            loops.finish(session);
        }
        let map = *map;
        let finished = FinishedMap {
            map,
            name: std::mem::take(name),
            session: *id,
            extends: *extends,
            at: *since,
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
        if let Phase::Closing { running: unsaved, .. } = std::mem::take(&mut self.phase) {
            self.phase = Phase::Saving { map, unsaved };
        }
        Some(finished)
    }

    /// The save has ended: the session is over, or goes on if its map could not be written.
    pub fn saved(&mut self, map: MapId, written: bool) {
        if !matches!(&self.phase, Phase::Saving { map: saving, .. } if *saving == map) {
            return;
        }
        if written {
            self.end();
            self.last_saved =
                Some(LastSavedMap::new(LastSavedMapConfig::default(), map, self.map_from_odom()));
        } else if let Phase::Saving { unsaved, .. } = std::mem::take(&mut self.phase) {
            self.phase = Phase::Running(unsaved);
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
                effects.push(StackEffect::StartJob { job: *jobs, work });
                *job = Some(*jobs);
                *jobs += 1;
            }
            Phase::Running(Running { id, search: Some((map, search)), .. }) => {
                if let Some(job) = search.start(jobs) {
                    let work = Job::SearchMap(search_task(*id, *map, search));
                    effects.push(StackEffect::StartJob { job, work });
                }
            }
            _ => {
                if let Some((id, _, loops)) = self.loop_closing() {
                    for (job, queued) in loops.start(jobs) {
                        let work = plain::comparison_job(id, &queued);
                        effects.push(StackEffect::StartJob { job, work });
                    }
                }
            }
        }
    }

    /// The data of a job; once.
    pub fn take_compute_job(&mut self, job: u64) -> Option<ComputeJob> {
        if let Phase::Running(Running { id, search: Some((map, search)), .. }) = &self.phase {
            return search.data(job).map(|data| ComputeJob::search(search_task(*id, *map, search), data));
        }
        let (id, _, loops) = self.loop_closing()?;
        let (queued, comparison) = loops.take_comparison(job)?;
        Some(ComputeJob::comparison(id, &queued, comparison, loops.config().verification))
    }

    /// A comparison or search has ended, with or without a result. Jobs of a session that has ended are ignored.
    pub fn complete_job(&mut self, done: &JobDone) -> MappingEvents {
        if let Phase::Running(running) = &mut self.phase
            && let Some((_, search)) = &mut running.search
        {
            let found = match &done.result {
                JobResult::MapSearched(result) => Some(&result.found),
                _ => None,
            };
            let is_ambiguous = found.and_then(|found| match found {
                MapSearchOutcome::Found { .. } => None,
                other => Some(matches!(other, MapSearchOutcome::Ambiguous(..))),
            });
            let fix =
                search.end(done.job, is_ambiguous).then(|| found.and_then(plain::fix_from_plain)).flatten();
            let is_localised = fix.is_some_and(|fix| running.localise(&fix));
            return MappingEvents {
                is_localised,
                is_graph_changed: is_localised,
                ..MappingEvents::default()
            };
        }
        let Some((id, session, loops)) = self.loop_closing() else { return MappingEvents::default() };
        let mut reanchored = None;
        let events = match &done.result {
            JobResult::LoopVerified(found) => match plain::verified_from_plain(found) {
                Some(result) => {
                    let pair = (found.task.from, found.task.to);
                    loops.complete_pair(done.job, pair, &result, session)
                }
                None => {
                    loops.ignore_comparison(done.job);
                    LoopEvents::default()
                }
            },
            JobResult::RevisitCompared(found) => match plain::compared_from_plain(found) {
                Some(result) => {
                    let revisit = (found.task.waypoint, found.task.keyframe);
                    let events = loops.complete_revisit(done.job, revisit, &result, session);
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
                    loops.ignore_comparison(done.job);
                    LoopEvents::default()
                }
            },
            JobResult::Failed { .. } => {
                loops.fail_comparison(done.job);
                LoopEvents::default()
            }
            _ => LoopEvents::default(),
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

    /// The quality of the map, if it is due.
    pub fn quality(&mut self, at: Stamp) -> Option<MapQuality> {
        let Phase::Running(running) = &mut self.phase else { return None };
        let (session, loops) =
            (&running.session, running.loops.as_mut().filter(|_| running.search.is_none())?);
        let graph = session.graph();
        let config = &self.config;
        let period = config.quality_period * (1 + graph.nodes().len() / config.quality_keyframes) as i64;
        let revision = graph.revision();
        if running.last_quality.is_some_and(|(last, known)| known == revision || at - last < period) {
            return None;
        }
        running.last_quality = Some((at, revision));
        Some(plain::quality_to_plain(loops.quality(session)))
    }

    /// What changed in the graph of the running session since it was published last.
    pub fn graph_changes(&mut self) -> Option<Publication> {
        match &mut self.phase {
            Phase::Running(running) | Phase::Closing { running, .. } => running.graph_changes(),
            _ => None,
        }
    }

    /// The running session and its loop closing, if there is one.
    fn loop_closing(&mut self) -> Option<(SessionId, &mut Session, &mut LoopClosing)> {
        match &mut self.phase {
            Phase::Running(Running { id, session, loops: Some(loops), .. })
            | Phase::Closing { running: Running { id, session, loops: Some(loops), .. }, .. } => {
                Some((*id, session, loops))
            }
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
            Phase::Saving { map, unsaved } => MappingState::Saving { session: unsaved.id, map: *map },
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
            0 => Publication::Graph(Arc::new(plain::graph_to_plain(&self.session))),
            _ => Publication::GraphDelta(Arc::new(plain::changes_to_plain(&changes))),
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
                .map_or(vocab::Pose::IDENTITY, |node| pose_from_isometry(&node.map_from_keyframe)),
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
