//! The mapping session's life: idle, starting, running, closing its last loops, saving.

use crate::loops::{Arrived, LoopEvents, Loops};
use crate::odometry_adapter::LocatedScan;
use crate::prior_map::DecodedPriorMap;
use crate::search::{Found, Search};
use crate::work::ComputeJob;
use geometry::{Isometry, Matrix6, Vector6, isometry_from_pose, pose_from_isometry};
use mapping::{Edge, KeyframePolicy, Odometer, ScanPose, Session, UncertainPose};
use messages::{
    BootRecord, Cloud, CommandKind, DegenerateStretch, EdgeKind, FinishedMap, GraphEdge, GraphNode, Job,
    JobDone, JobResult, Keyframe, MapQuality, MappingState, PoseGraph, PriorMap, RevisitCounts, StackEffect,
};
use points::Downsampler;
use std::sync::Arc;
use vocab::{MapId, SessionId, Span, Stamp};

/// Clouds of keyframes are averaged in voxels of this edge, metres: well below what a person can tell apart on the
/// map, and a tenth of the points of a full-resolution sweep near the robot.
const KEYFRAME_VOXEL: f32 = 0.04;
/// The end of a walk, where it comes back to its beginning, is waited for so long: far longer than all that may wait takes.
const LAST_LOOPS: Span = Span::from_millis(10_000);
/// A map that changes is judged so often, and more rarely by as much for every so many keyframes, because the cost grows with them.
const JUDGED_EVERY: Span = Span::from_millis(2_000);
const JUDGED_KEYFRAMES: usize = 500;
/// How far odometry alone is believed after a map was saved: deviation in radians, in metres, and in metres for each metre walked,
/// which may be so many. With what odometry itself doubts, it may come to so many metres.
const LEFT: (f64, f64, f64) = (0.02, 0.05, 0.01);
const LEFT_WALKED: f64 = 25.0;
const LEFT_DEVIATION: f64 = 0.4;

/// The phase and what it needs.
#[derive(Debug, Default)]
pub(crate) struct MappingPhase {
    phase: Phase,
    /// Of the last session that has ended.
    map_from_odom: Option<Isometry>,
    /// The map that was saved last.
    left: Option<Left>,
    downsampler: Downsampler,
    published: Option<MappingState>,
    /// Where the LiDAR is, base frame, metres.
    sensor: [f32; 3],
    leave_loops_open: bool,
}

/// A map that was saved while the robot was in it.
#[derive(Debug)]
struct Left {
    map: MapId,
    map_from_odom: Isometry,
    /// Since then.
    walked: Odometer,
    /// Odometry's covariance then.
    covariance: Option<Matrix6>,
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
    Starting(SessionId, Option<Box<Base>>),
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

/// What a session goes on from.
#[derive(Debug)]
struct Base {
    known: DecodedPriorMap,
    loops: Box<Loops>,
}

#[derive(Debug)]
struct Running {
    id: SessionId,
    extends: Option<MapId>,
    since: Stamp,
    session: Box<Session>,
    /// None where they are to be left open.
    loops: Option<Box<Loops>>,
    /// While the robot has not found itself in what the session goes on from.
    search: Option<Box<Search>>,
    /// When the map was judged last, and its revision then.
    judged: Option<(Stamp, u64)>,
}

/// What a scan did to the map.
pub(crate) enum MapUpdate {
    /// It became a keyframe.
    Keyframe { keyframe: Keyframe, graph: Arc<PoseGraph>, loops: LoopEvents },
    /// The robot is known to be in the map that the session goes on from.
    Found,
}

impl MappingPhase {
    /// For the robot of a boot record.
    pub fn new(record: &BootRecord) -> Self {
        let base_from_lidar = record.mounting.base_from_lidar.as_ref().and_then(isometry_from_pose);
        let sensor = base_from_lidar.unwrap_or_else(Isometry::identity).translation.vector.map(|c| c as f32);
        Self { sensor: sensor.into(), leave_loops_open: record.leave_loops_open, ..Self::default() }
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
            return Err(
                "A map cannot be extended while loops are left open. Start without that option.".to_owned()
            );
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
                Err("A map is being made already. Finish or discard it first.".to_owned())
            }
            Phase::Closing { .. } | Phase::Saving { .. } => {
                Err("The last map is still being saved. Try again in a moment.".to_owned())
            }
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
        let known = DecodedPriorMap::decode(read?)?;
        let loops = Loops::resume(session, self.sensor, &known).map_err(|error| {
            format!(
                "That map cannot be extended, because its graph cannot be solved: {error}. Begin another."
            )
        })?;
        self.phase = Phase::Starting(session, Some(Box::new(Base { known, loops: Box::new(loops) })));
        Ok(())
    }

    /// Throws the session away.
    pub fn discard(&mut self) -> Result<(), String> {
        match self.phase {
            Phase::Loading { .. } | Phase::Starting(..) | Phase::Running(_) => {
                self.end();
                Ok(())
            }
            Phase::Closing { .. } | Phase::Saving { .. } => {
                Err("The map is being saved; it can be deleted afterwards.".to_owned())
            }
            Phase::Idle => Err("No map is being made.".to_owned()),
        }
    }

    /// Ends the session; [`Self::closed`] hands its map over.
    pub fn finish(&mut self, at: Stamp, map: MapId, name: &str) -> Result<(), String> {
        let Phase::Running(Running { session, search, .. }) = &self.phase else {
            return Err("No map is being made. Start mapping first.".to_owned());
        };
        if search.is_some() {
            let text = "The robot has not found itself in that map yet, so nothing was added to it. Walk on through the known part, or discard.";
            return Err(text.to_owned());
        }
        if session.nodes().is_empty() {
            return Err("The map is still empty. Wait for the first scan.".to_owned());
        }
        let name = name.trim();
        if name.is_empty() {
            return Err("The map needs a name.".to_owned());
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
        if loops.as_ref().is_some_and(|loops| loops.is_looking()) && at - *since < LAST_LOOPS {
            return None;
        }
        if let Some(loops) = loops {
            // Trouble at the very end leaves the poses as they were; they are saved like that.
            loops.finish(session);
        }
        let map = *map;
        let finished = FinishedMap {
            map,
            name: std::mem::take(name),
            session: *id,
            extends: *extends,
            at: *since,
            distance: session.distance(),
            graph: Arc::new(graph_of(session)),
            trajectory: session.trajectory().iter().map(|(s, p)| (*s, pose_from_isometry(p))).collect(),
            degenerate: session
                .degenerate_stretches()
                .iter()
                .map(|s| DegenerateStretch { from: s.from, until: s.until, distance: s.distance })
                .collect(),
            decisions: loops.as_ref().map_or_else(Vec::new, |loops| loops.decisions().to_vec()),
            unverified: loops.as_ref().map_or(0, |loops| loops.left_out()),
            visits: loops.as_ref().map_or_else(RevisitCounts::default, |loops| loops.visits()),
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
            self.left = Some(Left {
                map,
                map_from_odom: self.map_from_odom(),
                walked: Odometer::default(),
                covariance: None,
            });
        } else if let Phase::Saving { unsaved, .. } = std::mem::take(&mut self.phase) {
            self.phase = Phase::Running(unsaved);
        }
    }

    /// No session any more; the map's frame stays until the next one begins.
    fn end(&mut self) {
        self.map_from_odom = Some(self.map_from_odom());
        self.phase = Phase::Idle;
    }

    /// Starts looking at pairs of keyframes. `jobs` counts all jobs of the stack.
    pub fn start_jobs(&mut self, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        match &mut self.phase {
            Phase::Loading { session, map, job: job @ None } => {
                let work = Job::LoadMap { session: *session, map: *map };
                effects.push(StackEffect::StartJob { job: *jobs, work });
                *job = Some(*jobs);
                *jobs += 1;
            }
            Phase::Running(Running { search: Some(search), .. }) => search.start(jobs, effects),
            _ => {
                if let Some((_, loops)) = self.closing() {
                    loops.start(jobs, effects);
                }
            }
        }
    }

    /// What a job takes; once.
    pub fn take_compute_job(&mut self, job: u64) -> Option<ComputeJob> {
        match &self.phase {
            Phase::Running(Running { search: Some(search), .. }) => search.take(job),
            _ => self.closing()?.1.take_compute_job(job),
        }
    }

    /// A pair of keyframes was looked at, or was not. What belongs to a session that has ended is ignored.
    pub fn looked_at(&mut self, done: &JobDone) -> LoopEvents {
        if let Phase::Running(running) = &mut self.phase
            && let Some(search) = &mut running.search
        {
            let sought = if let JobResult::MapSearched(sought) = &done.result { Some(sought) } else { None };
            let found = search.end(done.job, sought).is_some_and(|found| running.found(&found));
            return LoopEvents { found, changed: found, ..LoopEvents::default() };
        }
        match (self.closing(), &done.result) {
            (Some((session, loops)), JobResult::LoopVerified(found)) => {
                loops.verified(done.job, found, session)
            }
            (Some((session, loops)), JobResult::RevisitCompared(found)) => {
                loops.compared(done.job, found, session)
            }
            (Some((_, loops)), JobResult::Failed { .. }) => {
                loops.not_verified(done.job);
                LoopEvents::default()
            }
            _ => LoopEvents::default(),
        }
    }

    /// Carries out an order about loops.
    pub fn order_loop(&mut self, order: &CommandKind) -> Result<LoopEvents, String> {
        let Some((session, loops)) = self.closing() else {
            return Err("No map with loops is being made. Start mapping first.".to_owned());
        };
        match order {
            CommandKind::AcceptLoop { from, to } => loops.accept(*from, *to, session),
            CommandKind::RejectLoop { from, to } => loops.reject(*from, *to, session),
            CommandKind::ProposeLoop { from, to, guess } => {
                loops.propose(*from, *to, guess).map(|()| LoopEvents::default())
            }
            _ => Ok(LoopEvents::default()),
        }
    }

    /// How good the map is, if that is due.
    pub fn quality(&mut self, at: Stamp) -> Option<MapQuality> {
        let Phase::Running(running) = &mut self.phase else { return None };
        let (session, loops) =
            (&running.session, running.loops.as_mut().filter(|_| running.search.is_none())?);
        let every = JUDGED_EVERY * (1 + session.nodes().len() / JUDGED_KEYFRAMES) as i64;
        let revision = session.revision();
        if running.judged.is_some_and(|(last, known)| known == revision || at - last < every) {
            return None;
        }
        running.judged = Some((at, revision));
        Some(loops.quality(session))
    }

    /// The graph of the running session.
    pub fn graph(&self) -> Option<Arc<PoseGraph>> {
        match &self.phase {
            Phase::Running(Running { session, .. })
            | Phase::Closing { running: Running { session, .. }, .. } => Some(Arc::new(graph_of(session))),
            _ => None,
        }
    }

    /// The running session, if its loops are closed.
    fn closing(&mut self) -> Option<(&mut Session, &mut Loops)> {
        match &mut self.phase {
            Phase::Running(Running { session, loops: Some(loops), .. })
            | Phase::Closing { running: Running { session, loops: Some(loops), .. }, .. } => {
                Some((session, loops))
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
        if let Some(left) = &mut self.left {
            left.walked.move_to(&located.odom_from_base.translation.vector);
            left.covariance.get_or_insert(located.covariance);
        }
        if self.is_starting()
            && let Phase::Starting(id, base) = std::mem::take(&mut self.phase)
        {
            self.phase = Phase::Running(self.begun(id, base, located));
        }
        let Phase::Running(running) = &mut self.phase else { return None };
        let Running { id, session, loops, search, .. } = &mut *running;
        let waypoint = session.add_scan_pose(&ScanPose {
            stamp: located.stamp,
            odom_from_base: located.odom_from_base,
            scan_stamp: located.scan_stamp,
            odom_from_base_at_scan: located.odom_from_base_at_scan,
            covariance: located.covariance,
            guessed: located.guessed,
            degenerate: located.degenerate.iter().any(Option::is_some),
            blind: located.is_dead_reckoned,
        })?;
        let cloud = Arc::new(thinned(&mut self.downsampler, &located.cloud));
        let edge = match loops {
            Some(loops) => match loops.arrive(&waypoint, &cloud.xyz) {
                Arrived::Keyframe(edge) => edge,
                Arrived::Revisit => {
                    session.mark_revisit();
                    return None;
                }
                Arrived::Lost(number) => {
                    let search = search.as_mut()?;
                    search.arrive(number, &located.odom_from_base, &cloud.xyz, self.sensor);
                    let found = self.left.as_ref()?.place(search.map(), number, located, session)?;
                    return running.found(&found).then_some(MapUpdate::Found);
                }
            },
            None => session.edge_to(&waypoint),
        };
        let node = session.add_keyframe(&waypoint, edge);
        let keyframe = Keyframe {
            session: *id,
            id: node.id,
            stamp: node.stamp,
            map_from_keyframe: pose_from_isometry(&node.map_from_keyframe),
            cloud,
            lidar: self.sensor,
        };
        let loops = loops.as_mut().map(|loops| loops.add_keyframe(&node, edge.as_ref()));
        let graph = Arc::new(graph_of(session));
        Some(MapUpdate::Keyframe { keyframe, graph, loops: loops.unwrap_or_default() })
    }

    /// A session that begins with a located scan.
    fn begun(&self, id: SessionId, base: Option<Box<Base>>, located: &LocatedScan) -> Running {
        let (since, policy) = (located.stamp, KeyframePolicy::default());
        let Some(base) = base else {
            let session = Box::new(Session::begin(&located.odom_from_base, policy));
            let loops = (!self.leave_loops_open).then(|| Box::new(Loops::new(id, self.sensor)));
            return Running { id, extends: None, since, session, loops, search: None, judged: None };
        };
        let Base { known, loops } = *base;
        let extends = Some(known.map);
        let search = Some(Box::new(Search::new(id, &known)));
        let graph = (known.nodes, known.edges, known.loops);
        let session = Box::new(Session::resume(&located.odom_from_base, policy, graph));
        Running { id, extends, since, session, loops: Some(loops), search, judged: None }
    }

    /// Where odometry's frame is in a saved map, if the robot has just made that map and not walked far since.
    pub fn left(&self, map: MapId, located: &LocatedScan) -> Option<Isometry> {
        let left = self.left.as_ref().filter(|left| left.map == map)?;
        left.covariance(located).map(|_| left.map_from_odom)
    }

    /// The state, if it changed since it was last said.
    pub fn changed(&mut self) -> Option<MappingState> {
        let state = match &self.phase {
            Phase::Idle => MappingState::Idle,
            Phase::Loading { session, map, .. } => MappingState::Loading { session: *session, map: *map },
            Phase::Starting(session, _) => MappingState::Starting { session: *session },
            Phase::Running(Running { id, search: Some(search), .. }) => MappingState::Finding {
                session: *id,
                map: search.map(),
                distance: search.metres().round(),
                ambiguous: search.is_ambiguous(),
            },
            Phase::Running(Running { id, extends, since, session, .. }) => MappingState::Mapping {
                session: *id,
                extends: *extends,
                since: *since,
                distance: (session.distance() * 10.0).round() / 10.0,
                keyframes: session.nodes().len() as u32,
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
    /// The robot is there in what the session goes on from. Says whether that could be believed.
    fn found(&mut self, found: &Found) -> bool {
        let placed = self.loops.as_mut().is_some_and(|loops| loops.place(found, &mut self.session));
        if placed {
            self.search = None;
        }
        placed
    }
}

impl Left {
    /// Where a waypoint is in that map, if it is the one asked for and odometry can be believed for as long as was walked since.
    fn place(&self, map: MapId, number: u64, located: &LocatedScan, session: &Session) -> Option<Found> {
        if self.map != map {
            return None;
        }
        let covariance = self.covariance(located)?;
        let (keyframe, pose) = session.nearest(&(self.map_from_odom * located.odom_from_base))?;
        let keyframe_from_waypoint = UncertainPose { pose, covariance };
        Some(Found { waypoint: number, keyframe, keyframe_from_waypoint })
    }

    /// Of the base in that map, while odometry can be believed for as long as was walked since.
    fn covariance(&self, located: &LocatedScan) -> Option<Matrix6> {
        let walked = self.walked.distance();
        // Odometry that has lost its way since says so in its covariance.
        let before = self.covariance.unwrap_or_else(Matrix6::zeros);
        let grown = (located.covariance - before).diagonal();
        let [turned, moved] = [0, 3].map(|first| grown.fixed_rows::<3>(first).max().max(0.0));
        let (turn, place) = (LEFT.0, LEFT.1 + LEFT.2 * walked);
        let (turn, place) = (turn * turn + turned, place * place + moved);
        let covariance = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, place, place, place));
        let uncertain = UncertainPose { pose: Isometry::identity(), covariance };
        (walked <= LEFT_WALKED && uncertain.translation_std_m() <= LEFT_DEVIATION).then_some(covariance)
    }
}

fn thinned(downsampler: &mut Downsampler, cloud: &Cloud) -> Cloud {
    let mut centroids = Vec::new();
    // The mean that the downsampler takes beside the position serves for the intensity here.
    downsampler.downsample(&cloud.xyz, &cloud.intensity, KEYFRAME_VOXEL, &mut centroids);
    Cloud {
        xyz: centroids.iter().map(|c| c.xyz).collect(),
        intensity: if cloud.intensity.is_empty() {
            Vec::new()
        } else {
            centroids.iter().map(|c| c.attribute).collect()
        },
    }
}

fn graph_of(session: &Session) -> PoseGraph {
    PoseGraph {
        revision: session.revision(),
        nodes: session
            .nodes()
            .iter()
            .map(|node| GraphNode {
                id: node.id,
                stamp: node.stamp,
                map_from_keyframe: pose_from_isometry(&node.map_from_keyframe),
            })
            .collect(),
        edges: edges_of(session.edges(), EdgeKind::Odometry)
            .chain(edges_of(session.loops(), EdgeKind::Loop))
            .collect(),
    }
}

fn edges_of(edges: &[Edge], kind: EdgeKind) -> impl Iterator<Item = GraphEdge> {
    edges.iter().map(move |edge| GraphEdge {
        from: edge.from,
        to: edge.to,
        kind,
        from_from_to: pose_from_isometry(&edge.from_from_to),
        information: rows(&edge.information),
    })
}

/// Row-major rows of a matrix.
pub(crate) fn rows(matrix: &Matrix6) -> [[f64; 6]; 6] {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}
