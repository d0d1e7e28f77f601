//! A mapping session as the stack wires it: scans go in, jobs of loop closing, map search and quality go out, and what they find is
//! published. The algorithms are in `mapping`. [`crate::mapping_phase`] says when the session begins and ends.

use crate::loop_texts;
use crate::mapping_events::{MapUpdate, MappingEvents, decisions_to_plain};
use crate::mapping_messages::{self as plain, ComparisonTask};
use crate::odometry_adapter::LocatedScan;
use crate::prior_map::BaseMap;
use crate::quality_schedule::QualitySchedule;
use crate::texts;
use crate::work::{ComputeJob, Work};
use geometry::{Isometry, Matrix6, isometry_from_pose, pose_from_isometry};
use mapping::{
    AddedWaypoint, GraphPublisher, KeyframePolicy, LastSavedMap, LoopClosing, LoopClosingConfig, LoopEvents,
    MapSearch, MapSearchFix, OptimiserConfig, PoseGraph, ScanPose, Session, SessionConfig, Waypoint,
};
use messages::{
    BootRecord, Cloud, CommandKind, DegenerateSegment, FinishedMap, Job, JobFailure, Keyframe,
    MapSearchOutcome, MapSearchResult, MapSearchTask, MappingState, PlaceComparison, Publication, Reanchored,
    RevisitCounts, StackEffect,
};
use points::Downsampler;
use std::sync::Arc;
use vocab::{KeyframeId, MapId, Pose, SessionId, Stamp};

/// Parameters of a [`RunningSession`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RunningSessionConfig {
    /// When a scan becomes a keyframe; of the robot's profile.
    pub keyframes: KeyframePolicy,
    /// Edge of the voxels in which clouds of keyframes are averaged, metres. Well below what a person can distinguish on the map, and a tenth of the
    /// points of a full-resolution sweep near the robot. Chosen for this reason; smaller ones take more memory and disk.
    pub keyframe_voxel_m: f32,
    /// Whether no loops are closed. It is that of the boot record.
    pub leave_loops_open: bool,
}

impl RunningSessionConfig {
    /// For the robot of a boot record.
    pub fn new(record: &BootRecord) -> Self {
        let keyframes = KeyframePolicy {
            distance_m: record.profile.keyframe_distance_m,
            rotation_rad: record.profile.keyframe_rotation_rad,
        };
        Self { keyframes, keyframe_voxel_m: 0.04, leave_loops_open: record.leave_loops_open }
    }
}

/// A scan that is a waypoint.
#[derive(Debug)]
struct WaypointScan {
    waypoint: Waypoint,
    odom_from_base: Isometry,
    /// Covariance of `odom_from_base`, `[rotation; translation]`.
    covariance: Matrix6,
    /// Motion-corrected points, base frame, metres.
    cloud: Arc<Cloud>,
}

/// The session that scans are added to.
#[derive(Debug)]
pub(crate) struct RunningSession {
    id: SessionId,
    extends: Option<MapId>,
    since: Stamp,
    keyframe_voxel_m: f32,
    /// Where the LiDAR is, base frame, metres.
    sensor: [f32; 3],
    session: Box<Session>,
    /// None where loops are left open.
    loops: Option<Box<LoopClosing>>,
    /// While the robot is not localised in the map that the session extends.
    search: Option<(MapId, Box<MapSearch>)>,
    downsampler: Downsampler,
    /// The last scan, if it is a waypoint that is not in the map yet.
    waypoint: Option<Box<WaypointScan>>,
    /// What was published of the graph.
    graph_publisher: GraphPublisher,
    quality: QualitySchedule,
}

impl RunningSession {
    /// A session that begins with a located scan, seen from `sensor` (base frame, metres); in the map `base` if it extends one.
    pub fn begin(
        id: SessionId,
        base: Option<Box<BaseMap>>,
        located: &LocatedScan,
        config: &RunningSessionConfig,
        sensor: [f32; 3],
    ) -> Self {
        let (extends, graph, loops, search) = match base.map(|base| *base) {
            Some(BaseMap { map, graph, loops, search }) => {
                (Some(map), graph, Some(loops), Some((map, search)))
            }
            None if config.leave_loops_open => (None, PoseGraph::default(), None, None),
            None => {
                let loops = Box::new(LoopClosing::new(LoopClosingConfig::default(), sensor));
                (None, PoseGraph::new(OptimiserConfig::default()), Some(loops), None)
            }
        };
        let session_config = SessionConfig::new(config.keyframes);
        Self {
            id,
            extends,
            since: located.stamp,
            keyframe_voxel_m: config.keyframe_voxel_m,
            sensor,
            session: Box::new(Session::begin(&located.odom_from_base, session_config, graph)),
            loops,
            search,
            downsampler: Downsampler::default(),
            waypoint: None,
            graph_publisher: GraphPublisher::default(),
            quality: QualitySchedule::default(),
        }
    }

    /// The session's name in messages.
    pub fn id(&self) -> SessionId {
        self.id
    }

    /// Pose of the odometry's frame in the session's map.
    pub fn map_from_odom(&self) -> Isometry {
        *self.session.map_from_odom()
    }

    /// Whether the robot is not localised yet in the map that the session extends.
    pub fn is_searching(&self) -> bool {
        self.search.is_some()
    }

    /// Whether there is no keyframe yet.
    pub fn is_empty(&self) -> bool {
        self.session.graph().nodes().is_empty()
    }

    /// Adds a located scan to the trajectory. If it is a waypoint, [`Self::process_waypoint`] adds it to the map. That must be called before anything else
    /// of the session, because a waypoint is numbered and placed by those before it.
    pub fn add(&mut self, located: &LocatedScan) {
        let waypoint = self.session.add_scan_pose(&ScanPose {
            stamp: located.stamp,
            odom_from_base: located.odom_from_base,
            scan_stamp: located.scan_stamp,
            odom_from_base_at_scan: located.odom_from_base_at_scan,
            covariance: located.covariance,
            covariance_inflation: located.covariance_inflation,
            is_degenerate: located.degenerate.iter().any(Option::is_some),
            is_gravity_measured: located.is_gravity_measured,
            is_dead_reckoned: located.is_dead_reckoned,
        });
        self.waypoint = waypoint.map(|waypoint| {
            Box::new(WaypointScan {
                waypoint,
                odom_from_base: located.odom_from_base,
                covariance: located.covariance,
                cloud: Arc::clone(&located.cloud),
            })
        });
    }

    /// Adds the last scan to the map, if it is a waypoint that was not added yet. `last_saved` is the map that was saved last.
    pub fn process_waypoint(&mut self, last_saved: Option<&LastSavedMap>) -> Option<MapUpdate> {
        let scan = self.waypoint.take()?;
        let cloud = thinned(&mut self.downsampler, &scan.cloud, self.keyframe_voxel_m);
        let Some(loops) = &mut self.loops else {
            let id = self.session.add_keyframe(&scan.waypoint).id;
            return Some(self.keyframe(id, cloud, MappingEvents::default()));
        };
        let (added, events) = loops.add_waypoint(&mut self.session, &scan.waypoint, &cloud.xyz);
        let events = MappingEvents::new(self.id, &events, loops);
        match added {
            AddedWaypoint::Keyframe(id) => Some(self.keyframe(id, cloud, events)),
            AddedWaypoint::Revisit => Some(MapUpdate::NoKeyframe(events)),
            AddedWaypoint::Unlocalised(number) => {
                let is_localised = self.search_on(number, &scan, &cloud, last_saved);
                let events = MappingEvents { is_localised, is_graph_changed: is_localised, ..events };
                Some(MapUpdate::NoKeyframe(events))
            }
        }
    }

    /// Adds a waypoint with its thinned cloud to the search in the map that the session extends. Returns whether the map that was saved last gives the
    /// pose at once.
    fn search_on(
        &mut self,
        number: u64,
        scan: &WaypointScan,
        cloud: &Cloud,
        last_saved: Option<&LastSavedMap>,
    ) -> bool {
        let Some((map, search)) = &mut self.search else { return false };
        let (pose, covariance) = (&scan.odom_from_base, &scan.covariance);
        search.add_waypoint(number, pose, &cloud.xyz, self.sensor);
        let fix =
            last_saved.and_then(|last| last.locate(*map, number, pose, covariance, self.session.graph()));
        fix.is_some_and(|fix| self.localise(&fix))
    }

    /// A new keyframe, as it is published.
    fn keyframe(&mut self, id: KeyframeId, cloud: Cloud, events: MappingEvents) -> MapUpdate {
        let node = self.session.graph().nodes().last();
        let keyframe = Keyframe {
            session: self.id,
            id,
            stamp: node.map_or(Stamp::EPOCH, |node| node.stamp),
            map_from_keyframe: node
                .map_or(Pose::IDENTITY, |node| pose_from_isometry(&node.map_from_keyframe)),
            cloud: Arc::new(cloud),
            lidar: self.sensor,
        };
        MapUpdate::Keyframe { keyframe, graph: self.graph_changes(), events }
    }

    /// Sets the robot's pose in the map that the session extends. Returns whether it was plausible.
    fn localise(&mut self, fix: &MapSearchFix) -> bool {
        let is_localised =
            self.loops.as_mut().is_some_and(|loops| loops.localise_in_map(fix, &mut self.session));
        if is_localised {
            self.search = None;
        }
        is_localised
    }

    /// Starts the search in the map that the session extends, or comparisons. `jobs` counts all jobs of the stack.
    pub fn start_jobs(&mut self, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        if let Some((map, search)) = &mut self.search {
            if let Some(job) = search.start(jobs) {
                let work = Job::SearchMap(search_task(self.id, *map, search));
                effects.push(StackEffect::start_job(job, work));
            }
            return;
        }
        let Some(loops) = &mut self.loops else { return };
        for (job, queued) in loops.start(jobs) {
            let work = ComparisonTask::new(self.id, &queued).job();
            effects.push(StackEffect::start_job(job, work));
        }
    }

    /// The work of a search in the map that the session extends.
    pub fn take_search(&self, job: u64) -> Option<ComputeJob> {
        let (map, search) = self.search.as_ref()?;
        let (task, data) = (search_task(self.id, *map, search), Box::new(search.data(job)?));
        Some(ComputeJob::new(job, Work::SearchMap { task, data }))
    }

    /// A search has ended, with or without a result.
    pub fn finish_search(
        &mut self,
        job: u64,
        result: &Result<Box<MapSearchResult>, JobFailure>,
    ) -> MappingEvents {
        let Some((_, search)) = &mut self.search else { return MappingEvents::default() };
        let found = result.as_ref().ok().map(|result| &result.found);
        let is_ambiguous = found.and_then(|found| match found {
            MapSearchOutcome::Found { .. } => None,
            other => Some(matches!(other, MapSearchOutcome::Ambiguous(..))),
        });
        let fix = search.end(job, is_ambiguous).then(|| found.and_then(plain::fix_from_plain)).flatten();
        let is_localised = fix.is_some_and(|fix| self.localise(&fix));
        MappingEvents { is_localised, is_graph_changed: is_localised, ..MappingEvents::default() }
    }

    /// The work of a comparison; once.
    pub fn take_comparison(&mut self, job: u64) -> Option<ComputeJob> {
        let loops = self.loops.as_mut()?;
        let (queued, comparison) = loops.take_comparison(job)?;
        let (task, config) = (ComparisonTask::new(self.id, &queued), loops.config().verification);
        Some(ComputeJob::new(job, Work::Compare { task, comparison, config }))
    }

    /// A comparison has ended, with or without a result.
    pub fn finish_comparison(
        &mut self,
        job: u64,
        result: &Result<PlaceComparison, JobFailure>,
    ) -> MappingEvents {
        let Self { id, session, loops: Some(loops), .. } = self else { return MappingEvents::default() };
        let mut reanchored = None;
        let events = match result {
            Ok(PlaceComparison::Loop(found)) => plain::verified_from_plain(found).map(|result| {
                let pair = (found.task.from, found.task.to);
                loops.complete_pair(job, pair, &result, session)
            }),
            Ok(PlaceComparison::Revisit(found)) => plain::compared_from_plain(found).map(|result| {
                let revisit = (found.task.waypoint, found.task.keyframe);
                let events = loops.complete_revisit(job, revisit, &result, session);
                reanchored = events.reanchored.map(|event| Reanchored {
                    session: *id,
                    stamp: event.stamp,
                    keyframe: event.keyframe,
                    keyframe_from_base: found.keyframe_from_base,
                    information: found.information,
                });
                events
            }),
            Err(_) => {
                loops.fail_comparison(job);
                Some(LoopEvents::default())
            }
        };
        let events = events.unwrap_or_else(|| {
            loops.ignore_comparison(job);
            LoopEvents::default()
        });
        MappingEvents { reanchored, ..MappingEvents::new(*id, &events, loops) }
    }

    /// Whether comparisons are still running or waiting.
    pub fn is_comparing(&self) -> bool {
        self.loops.as_ref().is_some_and(|loops| loops.is_comparing())
    }

    /// Carries out a person's command about loops.
    ///
    /// # Errors
    /// Why it is refused, for people.
    pub fn handle_loop_command(&mut self, command: &CommandKind) -> Result<MappingEvents, String> {
        let Self { id, session, loops: Some(loops), .. } = self else {
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
        Ok(MappingEvents::new(*id, &events, loops))
    }

    /// The job that computes the quality of the map, if that is due; it gets this number. Not while a waypoint is about to change the map.
    pub fn start_quality(&mut self, at: Stamp, job: u64) -> Option<Job> {
        if self.loops.is_none() || self.search.is_some() || self.waypoint.is_some() {
            return None;
        }
        let graph = self.session.graph();
        let is_due = self.quality.start(at, job, graph.nodes().len(), graph.revision());
        is_due.then_some(Job::AssessQuality(self.id))
    }

    /// A snapshot of the map for its quality.
    pub fn take_quality(&self, job: u64) -> Option<ComputeJob> {
        let loops = self.loops.as_ref().filter(|_| self.quality.is_running(job))?;
        let (revision, data) = (self.session.graph().revision(), loops.quality_data(&self.session));
        Some(ComputeJob::new(job, Work::AssessQuality { revision, data }))
    }

    /// The job that computes the quality has ended. Returns whether it was this one.
    pub fn end_quality(&mut self, job: u64) -> bool {
        self.quality.end(job)
    }

    /// The session ends: pending comparisons are dropped. Returns whether a relinearisation of the graph would make the poses better.
    pub fn finish_loops(&mut self) -> bool {
        self.loops.as_mut().is_some_and(|loops| loops.finish(&self.session))
    }

    /// A snapshot of the graph, for its relinearisation.
    pub fn take_relinearisation(&self, job: u64) -> Option<ComputeJob> {
        let work = self.session.graph().relinearisation()?;
        Some(ComputeJob::new(job, Work::Relinearise(work)))
    }

    /// Takes over relinearised poses of all keyframes, if they are sound.
    pub fn move_keyframes(&mut self, poses: &[Pose]) {
        let count = self.session.graph().nodes().len();
        if let Some(poses) = plain::relinearised_from_plain(poses, count) {
            self.session.move_keyframes(&poses);
        }
    }

    /// The map as it is saved. The session was ended `at` this time.
    pub fn finished_map(&self, map: MapId, name: String, at: Stamp) -> FinishedMap {
        let Self { id, extends, session, loops, .. } = self;
        FinishedMap {
            map,
            name,
            session: *id,
            extends: *extends,
            at,
            distance_m: session.distance_m(),
            graph: Arc::new(plain::graph_to_plain(session)),
            trajectory: session.trajectory().iter().map(|(s, p)| (*s, pose_from_isometry(p))).collect(),
            degenerate: session
                .degenerate_segments()
                .iter()
                .map(|s| DegenerateSegment { from: s.from, until: s.until, distance_m: s.distance_m })
                .collect(),
            decisions: loops.as_ref().map_or_else(Vec::new, |loops| decisions_to_plain(*id, loops)),
            unverified: loops.as_ref().map_or(0, |loops| loops.skipped()),
            revisits: loops.as_ref().map_or_else(RevisitCounts::default, |loops| {
                let mapping::RevisitCounts { compared, confirmed } = loops.revisits();
                RevisitCounts { compared, confirmed }
            }),
        }
    }

    /// What changed in the graph since it was published last; at first all of it.
    pub fn graph_changes(&mut self) -> Option<Publication> {
        let changes = self.graph_publisher.update(self.session.graph())?;
        Some(match changes.base_revision {
            0 => {
                Publication::Graph { session: self.id, graph: Arc::new(plain::graph_to_plain(&self.session)) }
            }
            _ => Publication::GraphDelta(Arc::new(plain::changes_to_plain(self.id, &changes))),
        })
    }

    /// The whole graph, if any of it was published: changes from now on apply to this one.
    pub fn whole_graph(&mut self) -> Option<Publication> {
        self.graph_publisher.forget_published().then(|| self.graph_changes())?
    }

    /// The state of the session while it runs.
    pub fn state(&self) -> MappingState {
        match &self.search {
            Some((map, search)) => MappingState::Finding {
                session: self.id,
                map: *map,
                distance_m: search.distance_m().round(),
                ambiguous: search.is_ambiguous(),
            },
            None => MappingState::Mapping {
                session: self.id,
                extends: self.extends,
                since: self.since,
                distance_m: (self.session.distance_m() * 10.0).round() / 10.0,
                keyframes: self.session.graph().nodes().len() as u32,
                on_known_ground: self.session.is_revisiting(),
            },
        }
    }
}

fn search_task(session: SessionId, map: MapId, search: &MapSearch) -> MapSearchTask {
    MapSearchTask { session, map, waypoint: search.newest_waypoint() }
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

#[cfg(test)]
#[path = "running_session_tests.rs"]
mod tests;
