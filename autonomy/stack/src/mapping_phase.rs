//! The mapping session's life: idle, starting, running, closing its last loops, saving.

use crate::localising::Located;
use crate::loops::{Arrived, Loops, News};
use crate::work::Work;
use geometry::{Isometry, Matrix6, isometry_from_pose, pose_from_isometry};
use mapping::{Edge, KeyframePolicy, ScanPose, Session};
use messages::{
    BootRecord, Cloud, DegenerateStretch, EdgeKind, Effect, FinishedMap, GraphEdge, GraphNode, JobDone,
    JobResult, Keyframe, MappingState, Order, PoseGraph, VisitCounts,
};
use points::Downsampler;
use std::sync::Arc;
use vocab::{MapId, SessionId, Span, Stamp};

/// Clouds of keyframes are averaged in voxels of this edge, metres: well below what a person can tell apart on the
/// map, and a tenth of the points of a full-resolution sweep near the robot.
const KEYFRAME_VOXEL: f32 = 0.04;
/// The end of a walk, where it comes back to its beginning, is waited for so long: far longer than all that may wait takes.
const LAST_LOOPS: Span = Span::from_millis(10_000);

/// The phase and what it needs.
#[derive(Debug, Default)]
pub(crate) struct MappingPhase {
    phase: Phase,
    /// Of the last session that has ended.
    map_from_odom: Option<Isometry>,
    downsampler: Downsampler,
    published: Option<MappingState>,
    /// Where the LiDAR is, base frame, metres.
    sensor: [f32; 3],
    leave_loops_open: bool,
}

#[derive(Debug, Default)]
enum Phase {
    #[default]
    Idle,
    Starting(SessionId),
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

#[derive(Debug)]
struct Running {
    id: SessionId,
    since: Stamp,
    session: Box<Session>,
    /// None where they are to be left open.
    loops: Option<Box<Loops>>,
}

/// What a scan did to the map.
pub(crate) struct Grown {
    pub keyframe: Keyframe,
    pub graph: Arc<PoseGraph>,
    pub loops: News,
}

impl MappingPhase {
    /// For the robot of a boot record.
    pub fn new(record: &BootRecord) -> Self {
        let base_from_lidar = record.mounting.base_from_lidar.as_ref().and_then(isometry_from_pose);
        let sensor = base_from_lidar.unwrap_or_else(Isometry::identity).translation.vector.map(|c| c as f32);
        Self { sensor: sensor.into(), leave_loops_open: record.leave_loops_open, ..Self::default() }
    }

    /// Where the odometry's frame is in the map of the last session; the same frame before the first. A loop closure moves
    /// it.
    pub fn map_from_odom(&self) -> Isometry {
        let running = match &self.phase {
            Phase::Running(running)
            | Phase::Closing { running, .. }
            | Phase::Saving { unsaved: running, .. } => Some(running),
            Phase::Idle | Phase::Starting(_) => None,
        };
        let of_running = running.map(|running| *running.session.map_from_odom());
        of_running.or(self.map_from_odom).unwrap_or_else(Isometry::identity)
    }

    /// Begins a session at the next scan.
    pub fn start(&mut self, id: SessionId) -> Result<(), String> {
        match &self.phase {
            Phase::Idle => {
                self.phase = Phase::Starting(id);
                Ok(())
            }
            Phase::Starting(running) | Phase::Running(Running { id: running, .. }) if *running == id => {
                Ok(())
            }
            Phase::Starting(_) | Phase::Running(_) => {
                Err("A map is being made already. Finish or discard it first.".to_owned())
            }
            Phase::Closing { .. } | Phase::Saving { .. } => {
                Err("The last map is still being saved. Try again in a moment.".to_owned())
            }
        }
    }

    /// Throws the session away.
    pub fn discard(&mut self) -> Result<(), String> {
        match self.phase {
            Phase::Starting(_) | Phase::Running(_) => {
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
        let Phase::Running(Running { session, .. }) = &self.phase else {
            return Err("No map is being made. Start mapping first.".to_owned());
        };
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
        let Running { id, session, loops, .. } = running;
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
            visits: loops.as_ref().map_or_else(VisitCounts::default, |loops| loops.visits()),
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
    pub fn start_jobs(&mut self, jobs: &mut u64, effects: &mut Vec<Effect>) {
        if let Some((_, loops)) = self.closing() {
            loops.start(jobs, effects);
        }
    }

    /// What a job takes; once.
    pub fn take_work(&mut self, job: u64) -> Option<Work> {
        self.closing()?.1.take_work(job)
    }

    /// A pair of keyframes was looked at, or was not. What belongs to a session that has ended is ignored.
    pub fn looked_at(&mut self, done: &JobDone) -> News {
        match (self.closing(), &done.result) {
            (Some((session, loops)), JobResult::LoopVerified(found)) => {
                loops.verified(done.job, found, session)
            }
            (Some((session, loops)), JobResult::VisitCompared(found)) => {
                loops.compared(done.job, found, session)
            }
            (Some((_, loops)), JobResult::LoopNotVerified) => {
                loops.not_verified(done.job);
                News::default()
            }
            _ => News::default(),
        }
    }

    /// Carries out an order about loops.
    pub fn order_loop(&mut self, order: &Order) -> Result<News, String> {
        let Some((session, loops)) = self.closing() else {
            return Err("No map with loops is being made. Start mapping first.".to_owned());
        };
        match order {
            Order::AcceptLoop { from, to } => loops.accept(*from, *to, session),
            Order::RejectLoop { from, to } => loops.reject(*from, *to, session),
            Order::ProposeLoop { from, to, guess } => {
                loops.propose(*from, *to, guess).map(|()| News::default())
            }
            _ => Ok(News::default()),
        }
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
        matches!(self.phase, Phase::Starting(_))
    }

    /// Adds a located scan.
    pub fn add(&mut self, located: &Located) -> Option<Grown> {
        if let Phase::Starting(id) = self.phase {
            let session = Box::new(Session::begin(&located.odom_from_base, KeyframePolicy::default()));
            let loops = (!self.leave_loops_open).then(|| Box::new(Loops::new(id, self.sensor)));
            self.phase = Phase::Running(Running { id, since: located.stamp, session, loops });
        }
        let Phase::Running(Running { id, session, loops, .. }) = &mut self.phase else { return None };
        let waypoint = session.follow(&ScanPose {
            stamp: located.stamp,
            odom_from_base: located.odom_from_base,
            scan_stamp: located.scan_stamp,
            odom_from_base_at_scan: located.odom_from_base_at_scan,
            covariance: located.covariance,
            degenerate: located.degenerate.iter().any(Option::is_some),
        })?;
        let cloud = Arc::new(thinned(&mut self.downsampler, &located.cloud));
        let edge = match loops {
            Some(loops) => match loops.arrive(&waypoint, &cloud.xyz) {
                Arrived::Keyframe(edge) => edge,
                Arrived::Visit => {
                    session.visit();
                    return None;
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
        Some(Grown { keyframe, graph: Arc::new(graph_of(session)), loops: loops.unwrap_or_default() })
    }

    /// The state, if it changed since it was last said.
    pub fn changed(&mut self) -> Option<MappingState> {
        let state = match &self.phase {
            Phase::Idle => MappingState::Idle,
            Phase::Starting(session) => MappingState::Starting { session: *session },
            Phase::Running(Running { id, since, session, .. }) => MappingState::Mapping {
                session: *id,
                since: *since,
                distance: (session.distance() * 10.0).round() / 10.0,
                keyframes: session.nodes().len() as u32,
                on_known_ground: session.is_visiting(),
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

fn thinned(downsampler: &mut Downsampler, cloud: &Cloud) -> Cloud {
    let mut centroids = Vec::new();
    // The mean that the downsampler takes beside the position serves for the intensity here.
    downsampler.centroids(&cloud.xyz, &cloud.intensity, KEYFRAME_VOXEL, &mut centroids);
    Cloud {
        xyz: centroids.iter().map(|c| c.xyz).collect(),
        intensity: if cloud.intensity.is_empty() {
            Vec::new()
        } else {
            centroids.iter().map(|c| c.time).collect()
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
