//! The life of a mapping session: idle, loading, starting, running, closing its last loops, saving. This file holds the states and their
//! transitions; what a session does while it runs is in [`crate::running_session`].

use crate::map_loading::MapLoading;
use crate::map_name::map_name;
use crate::mapping_events::{MapUpdate, MappingEvents};
use crate::odometry_adapter::LocatedScan;
use crate::prior_map::{BaseMap, PreparedMap};
use crate::running_session::{RunningSession, RunningSessionConfig};
use crate::texts;
use crate::work::ComputeJob;
use geometry::{Isometry, isometry_from_pose};
use mapping::{LastSavedMap, LastSavedMapConfig};
use messages::{
    BootRecord, CommandKind, Job, JobFailure, MapQuality, MapSearchResult, MappingState, PlaceComparison,
    PriorMap, Publication, StackEffect,
};
use std::sync::Arc;
use vocab::{MapId, Pose, SessionId, Span, Stamp};

/// Parameters of [`MappingPhase`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct MappingConfig {
    /// Time that a finished map waits for its last comparisons, and then for its relinearisation. Walks mostly end where they began. Far longer than all
    /// comparisons that may wait take. Chosen: people wait for the map meanwhile.
    max_closing_time: Span,
}

impl Default for MappingConfig {
    fn default() -> Self {
        Self { max_closing_time: Span::from_millis(10_000) }
    }
}

/// The phase and what it needs.
#[derive(Debug)]
pub(crate) struct MappingPhase {
    config: MappingConfig,
    session_config: RunningSessionConfig,
    phase: Phase,
    /// Of the last session that has ended.
    map_from_odom: Option<Isometry>,
    /// The map that was saved last.
    last_saved: Option<LastSavedMap>,
    published: Option<MappingState>,
    /// Where the LiDAR is, base frame, metres.
    sensor: [f32; 3],
    /// Number of the next job that computes the quality. These are counted apart, so that the numbers of other jobs do not depend on them.
    quality_jobs: u64,
}

#[derive(Debug, Default)]
enum Phase {
    #[default]
    Idle,
    /// A saved map is being read.
    Loading {
        session: SessionId,
        loading: MapLoading,
    },
    Starting(SessionId, Option<Box<BaseMap>>),
    Running(RunningSession),
    /// Nothing is added any more. The last pairs are compared, then the graph is relinearised.
    Closing {
        map: MapId,
        name: String,
        since: Stamp,
        /// The job that relinearises the graph, and when it was started.
        relinearisation: Option<(u64, Stamp)>,
        session: RunningSession,
    },
    Saving {
        map: MapId,
        job: u64,
        /// Kept until the map is on disk.
        session: RunningSession,
    },
}

impl MappingPhase {
    /// For the robot of a boot record.
    pub fn new(record: &BootRecord) -> Self {
        let base_from_lidar = record.mounting.base_from_lidar.as_ref().and_then(isometry_from_pose);
        let sensor = base_from_lidar.unwrap_or_else(Isometry::identity).translation.vector.map(|c| c as f32);
        Self {
            config: MappingConfig::default(),
            session_config: RunningSessionConfig::new(record),
            phase: Phase::Idle,
            map_from_odom: None,
            last_saved: None,
            published: None,
            sensor: sensor.into(),
            quality_jobs: 0,
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

    /// Whether the next located scan begins a session, and so a new map frame.
    pub fn is_starting(&self) -> bool {
        matches!(self.phase, Phase::Starting(..))
    }

    /// Where the odometry's frame is in the map of the last session; the same frame before the first. A loop closure moves
    /// it.
    pub fn map_from_odom(&self) -> Isometry {
        let of_session = self.session().map(RunningSession::map_from_odom);
        of_session.or(self.map_from_odom).unwrap_or_else(Isometry::identity)
    }

    /// Pose of the odometry's frame in a saved map, if the robot has just made that map and has not walked far since.
    pub fn map_from_odom_of(&self, map: MapId, located: &LocatedScan) -> Option<Isometry> {
        self.last_saved.as_ref()?.map_from_odom(map, &located.covariance)
    }

    /// Begins a session at the next scan.
    pub fn start(&mut self, id: SessionId) -> Result<(), String> {
        self.begin(id, Phase::Starting(id, None))
    }

    /// Begins a session that goes on from a saved map, once that has been read.
    pub fn extend(&mut self, session: SessionId, map: MapId) -> Result<(), String> {
        if self.session_config.leave_loops_open {
            return Err(texts::EXTENDING_NEEDS_LOOPS.to_owned());
        }
        self.begin(session, Phase::Loading { session, loading: MapLoading::new(map) })
    }

    fn begin(&mut self, id: SessionId, first: Phase) -> Result<(), String> {
        let current = match &self.phase {
            Phase::Idle => {
                self.phase = first;
                return Ok(());
            }
            Phase::Loading { session, .. } | Phase::Starting(session, _) => *session,
            Phase::Running(session) => session.id(),
            Phase::Closing { .. } | Phase::Saving { .. } => return Err(texts::MAP_STILL_SAVING.to_owned()),
        };
        if current == id { Ok(()) } else { Err(texts::MAPPING_RUNS.to_owned()) }
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
        let Phase::Loading { session, loading } = self.phase else { return Ok(()) };
        let Some(read) = loading.finish(job, read) else { return Ok(()) };
        self.phase = Phase::Idle;
        let base = PreparedMap::extension(supplied, read?, self.sensor)?;
        self.phase = Phase::Starting(session, Some(base));
        Ok(())
    }

    /// Adds a located scan. If it is a waypoint, [`Self::process_waypoint`] adds that to the map.
    pub fn add(&mut self, located: &LocatedScan) {
        if let Some(last_saved) = &mut self.last_saved {
            last_saved.update(&located.odom_from_base, &located.covariance);
        }
        if self.is_starting()
            && let Phase::Starting(id, base) = std::mem::take(&mut self.phase)
        {
            let config = &self.session_config;
            self.phase = Phase::Running(RunningSession::begin(id, base, located, config, self.sensor));
        }
        if let Phase::Running(session) = &mut self.phase {
            session.add(located);
        }
    }

    /// Adds the last scan to the map, if that scan is a waypoint that was not added yet.
    pub fn process_waypoint(&mut self) -> Option<MapUpdate> {
        let Phase::Running(session) = &mut self.phase else { return None };
        session.process_waypoint(self.last_saved.as_ref())
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
        let Phase::Running(session) = &self.phase else {
            return Err(texts::NO_MAPPING.to_owned());
        };
        if session.is_searching() {
            return Err(texts::NOT_LOCALISED_IN_EXTENDED_MAP.to_owned());
        }
        if session.is_empty() {
            return Err(texts::MAP_EMPTY.to_owned());
        }
        let name = map_name(name).ok_or_else(|| texts::MAP_NEEDS_NAME.to_owned())?;
        if let Phase::Running(session) = std::mem::take(&mut self.phase) {
            self.phase = Phase::Closing { map, name, since: at, relinearisation: None, session };
        }
        Ok(())
    }

    /// Goes on with a session that was ended, if it may. Its last pairs of keyframes are compared, then its graph is relinearised, then its map is
    /// saved. Each wait is bounded. `jobs` counts all jobs of the stack.
    pub fn close(&mut self, at: Stamp, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        let Phase::Closing { since, relinearisation, session, .. } = &mut self.phase else { return };
        let is_overdue = |since: Stamp| at - since >= self.config.max_closing_time;
        match relinearisation {
            Some((job, started)) => {
                if is_overdue(*started) {
                    let job = *job;
                    self.save(job, effects);
                }
            }
            None => {
                if session.is_comparing() && !is_overdue(*since) {
                    return;
                }
                let job = *jobs;
                *jobs += 1;
                if session.finish_loops() {
                    *relinearisation = Some((job, at));
                    effects.push(StackEffect::start_job(job, Job::Relinearise(session.id())));
                } else {
                    self.save(job, effects);
                }
            }
        }
    }

    /// The graph of a session that ends was relinearised. If not, the poses stay as they were. The map is saved either way. Returns a warning.
    pub fn finish_relinearisation(
        &mut self,
        job: u64,
        result: &Result<Vec<Pose>, JobFailure>,
        effects: &mut Vec<StackEffect>,
    ) -> Option<String> {
        let Phase::Closing { relinearisation: Some((waited, _)), session, .. } = &mut self.phase else {
            return None;
        };
        if *waited != job {
            return None;
        }
        if let Ok(poses) = result {
            session.move_keyframes(poses);
        }
        self.save(job, effects);
        result.as_ref().err().map(|failure| texts::map_not_relinearised(&failure.reason))
    }

    /// Saves the map of a session that was ended, in the job with this number.
    fn save(&mut self, job: u64, effects: &mut Vec<StackEffect>) {
        let (map, name, since, session) = match std::mem::take(&mut self.phase) {
            Phase::Closing { map, name, since, session, .. } => (map, name, since, session),
            other => {
                self.phase = other;
                return;
            }
        };
        let finished = Arc::new(session.finished_map(map, name, since));
        effects.push(StackEffect::start_job(job, Job::SaveMap(finished)));
        self.phase = Phase::Saving { map, job, session };
    }

    /// The save has ended: the session is over, or goes on if its map could not be written. Returns whether a session waited for it.
    pub fn finish_saving(&mut self, job: u64, result: &Result<MapId, JobFailure>) -> bool {
        match std::mem::take(&mut self.phase) {
            // In journals up to version 4 the graph was relinearised within a step, and the save ended next.
            Phase::Saving { map, job: waited, session }
            | Phase::Closing { map, relinearisation: Some((waited, _)), session, .. }
                if waited == job =>
            {
                self.phase = Phase::Running(session);
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
        if let Phase::Loading { session, loading } = &mut self.phase {
            if let Some(job) = loading.start(jobs) {
                let work = Job::LoadMap { session: *session, map: loading.map() };
                effects.push(StackEffect::start_job(job, work));
            }
        } else if let Some(session) = self.session_with_open_graph() {
            session.start_jobs(jobs, effects);
        }
    }

    /// Starts to compute the quality of the map, if that is due. At most one such job runs at a time.
    pub fn start_quality(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        let Phase::Running(session) = &mut self.phase else { return };
        if let Some(work) = session.start_quality(at, self.quality_jobs) {
            effects.push(StackEffect::start_job(self.quality_jobs, work));
            self.quality_jobs += 1;
        }
    }

    /// The work of a search in the map that the session extends.
    pub fn take_search(&self, job: u64) -> Option<ComputeJob> {
        let Phase::Running(session) = &self.phase else { return None };
        session.take_search(job)
    }

    /// The work of a comparison; once.
    pub fn take_comparison(&mut self, job: u64) -> Option<ComputeJob> {
        self.session_with_open_graph()?.take_comparison(job)
    }

    /// A snapshot of the map for its quality.
    pub fn take_quality(&self, job: u64) -> Option<ComputeJob> {
        let Phase::Running(session) = &self.phase else { return None };
        session.take_quality(job)
    }

    /// A snapshot of the graph of a session that ends.
    pub fn take_relinearisation(&self, job: u64) -> Option<ComputeJob> {
        let Phase::Closing { relinearisation: Some((waited, _)), session, .. } = &self.phase else {
            return None;
        };
        if *waited == job { session.take_relinearisation(job) } else { None }
    }

    /// A search has ended, with or without a result. Searches of a session that has ended are ignored.
    pub fn finish_search(
        &mut self,
        job: u64,
        result: &Result<Box<MapSearchResult>, JobFailure>,
    ) -> MappingEvents {
        let Phase::Running(session) = &mut self.phase else { return MappingEvents::default() };
        session.finish_search(job, result)
    }

    /// A comparison has ended, with or without a result. Comparisons of a session that has ended are ignored.
    pub fn finish_comparison(
        &mut self,
        job: u64,
        result: &Result<PlaceComparison, JobFailure>,
    ) -> MappingEvents {
        let session = self.session_with_open_graph();
        session.map_or_else(MappingEvents::default, |session| session.finish_comparison(job, result))
    }

    /// The quality was computed, or was not. Returns it for publication, also if the graph has changed since: the next one follows. The quality of
    /// a session that has ended is ignored.
    pub fn finish_quality(&mut self, job: u64, result: Result<MapQuality, JobFailure>) -> Option<MapQuality> {
        let is_running = matches!(self.phase, Phase::Running(_));
        let was_waited_for = self.session_mut()?.end_quality(job);
        result.ok().filter(|_| was_waited_for && is_running)
    }

    /// Carries out a person's command about loops.
    ///
    /// # Errors
    /// Why it is refused, for people.
    pub fn handle_loop_command(&mut self, command: &CommandKind) -> Result<MappingEvents, String> {
        match self.session_with_open_graph() {
            Some(session) => session.handle_loop_command(command),
            None => Err(texts::NO_MAPPING_WITH_LOOPS.to_owned()),
        }
    }

    /// What changed in the graph of the running session since it was published last.
    pub fn graph_changes(&mut self) -> Option<Publication> {
        match &mut self.phase {
            Phase::Running(session) | Phase::Closing { session, .. } => session.graph_changes(),
            _ => None,
        }
    }

    /// The whole graph of the running session, if any of it was published: changes from now on apply to this one.
    pub fn whole_graph(&mut self) -> Option<Publication> {
        match &mut self.phase {
            Phase::Running(session) | Phase::Closing { session, .. } => session.whole_graph(),
            _ => None,
        }
    }

    /// The state, if it changed since it was last said.
    pub fn changed(&mut self) -> Option<MappingState> {
        let state = match &self.phase {
            Phase::Idle => MappingState::Idle,
            Phase::Loading { session, loading } => {
                MappingState::Loading { session: *session, map: loading.map() }
            }
            Phase::Starting(session, _) => MappingState::Starting { session: *session },
            Phase::Running(session) => session.state(),
            Phase::Closing { map, session, .. } | Phase::Saving { map, session, .. } => {
                MappingState::Saving { session: session.id(), map: *map }
            }
        };
        if self.published.as_ref() == Some(&state) {
            return None;
        }
        self.published = Some(state.clone());
        Some(state)
    }

    /// The session, if it has begun.
    fn session(&self) -> Option<&RunningSession> {
        match &self.phase {
            Phase::Running(session) | Phase::Closing { session, .. } | Phase::Saving { session, .. } => {
                Some(session)
            }
            Phase::Idle | Phase::Loading { .. } | Phase::Starting(..) => None,
        }
    }

    /// The session, if it has begun.
    fn session_mut(&mut self) -> Option<&mut RunningSession> {
        match &mut self.phase {
            Phase::Running(session) | Phase::Closing { session, .. } | Phase::Saving { session, .. } => {
                Some(session)
            }
            Phase::Idle | Phase::Loading { .. } | Phase::Starting(..) => None,
        }
    }

    /// The session, if there is one and its graph may still change.
    fn session_with_open_graph(&mut self) -> Option<&mut RunningSession> {
        match &mut self.phase {
            Phase::Running(session) | Phase::Closing { session, relinearisation: None, .. } => Some(session),
            _ => None,
        }
    }
}

#[cfg(test)]
#[path = "mapping_phase_tests.rs"]
mod tests;
