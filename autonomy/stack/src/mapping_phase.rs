//! The mapping session's life: idle, starting, running, saving.

use crate::localising::Located;
use geometry::{Isometry, Matrix6, pose_from_isometry};
use mapping::{KeyframePolicy, ScanPose, Session};
use messages::{
    Cloud, DegenerateStretch, EdgeKind, FinishedMap, GraphEdge, GraphNode, Keyframe, MappingState, PoseGraph,
};
use points::Downsampler;
use std::sync::Arc;
use vocab::{MapId, SessionId, Stamp};

/// Clouds of keyframes are averaged in voxels of this edge, metres: well below what a person can tell apart on the
/// map, and a tenth of the points of a full-resolution sweep near the robot.
const KEYFRAME_VOXEL: f32 = 0.04;

/// The phase and what it needs.
#[derive(Debug, Default)]
pub(crate) struct MappingPhase {
    phase: Phase,
    map_from_odom: Option<Isometry>,
    downsampler: Downsampler,
    published: Option<MappingState>,
}

#[derive(Debug, Default)]
enum Phase {
    #[default]
    Idle,
    Starting(SessionId),
    Running(Running),
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
}

/// What a scan did to the map.
pub(crate) struct Grown {
    pub keyframe: Keyframe,
    pub graph: Arc<PoseGraph>,
}

impl MappingPhase {
    /// Where the odometry's frame is in the map of the last session; the same frame before the first.
    pub fn map_from_odom(&self) -> Isometry {
        self.map_from_odom.unwrap_or_else(Isometry::identity)
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
            Phase::Saving { .. } => {
                Err("The last map is still being saved. Try again in a moment.".to_owned())
            }
        }
    }

    /// Throws the session away.
    pub fn discard(&mut self) -> Result<(), String> {
        match self.phase {
            Phase::Starting(_) | Phase::Running(_) => {
                self.phase = Phase::Idle;
                Ok(())
            }
            Phase::Saving { .. } => Err("The map is being saved; it can be deleted afterwards.".to_owned()),
            Phase::Idle => Err("No map is being made.".to_owned()),
        }
    }

    /// Ends the session; what comes back has to be saved.
    pub fn finish(&mut self, at: Stamp, map: MapId, name: &str) -> Result<FinishedMap, String> {
        let Phase::Running(Running { id, session, .. }) = &self.phase else {
            return Err("No map is being made. Start mapping first.".to_owned());
        };
        if session.nodes().is_empty() {
            return Err("The map is still empty. Wait for the first scan.".to_owned());
        }
        let name = name.trim();
        if name.is_empty() {
            return Err("The map needs a name.".to_owned());
        }
        let finished = FinishedMap {
            map,
            name: name.chars().take(120).collect(),
            session: *id,
            at,
            distance: session.distance(),
            graph: Arc::new(graph_of(session)),
            trajectory: session.trajectory().iter().map(|(s, p)| (*s, pose_from_isometry(p))).collect(),
            degenerate: session
                .degenerate_stretches()
                .iter()
                .map(|s| DegenerateStretch { from: s.from, until: s.until, distance: s.distance })
                .collect(),
        };
        if let Phase::Running(unsaved) = std::mem::take(&mut self.phase) {
            self.phase = Phase::Saving { map, unsaved };
        }
        Ok(finished)
    }

    /// The save has ended: the session is over, or goes on if its map could not be written.
    pub fn saved(&mut self, map: MapId, written: bool) {
        if !matches!(&self.phase, Phase::Saving { map: saving, .. } if *saving == map) {
            return;
        }
        if let Phase::Saving { unsaved, .. } = std::mem::take(&mut self.phase)
            && !written
        {
            self.phase = Phase::Running(unsaved);
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
            self.map_from_odom = Some(*session.map_from_odom());
            self.phase = Phase::Running(Running { id, since: located.stamp, session });
        }
        let Phase::Running(Running { id, session, .. }) = &mut self.phase else { return None };
        let node = session.add_scan(&ScanPose {
            stamp: located.stamp,
            odom_from_base: located.odom_from_base,
            scan_stamp: located.scan_stamp,
            odom_from_base_at_scan: located.odom_from_base_at_scan,
            covariance: located.covariance,
            degenerate: located.degenerate.iter().any(Option::is_some),
        })?;
        let keyframe = Keyframe {
            session: *id,
            id: node.id,
            stamp: node.stamp,
            map_from_keyframe: pose_from_isometry(&node.map_from_keyframe),
            cloud: Arc::new(thinned(&mut self.downsampler, &located.cloud)),
        };
        Some(Grown { keyframe, graph: Arc::new(graph_of(session)) })
    }

    /// The state, if it changed since it was last said.
    pub fn changed(&mut self) -> Option<MappingState> {
        let state = match &self.phase {
            Phase::Idle => MappingState::Idle,
            Phase::Starting(session) => MappingState::Starting { session: *session },
            Phase::Running(Running { id, since, session }) => MappingState::Mapping {
                session: *id,
                since: *since,
                distance: (session.distance() * 10.0).round() / 10.0,
                keyframes: session.nodes().len() as u32,
            },
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
        edges: session
            .edges()
            .iter()
            .map(|edge| GraphEdge {
                from: edge.from,
                to: edge.to,
                kind: EdgeKind::Odometry,
                from_from_to: pose_from_isometry(&edge.from_from_to),
                information: rows(&edge.information),
            })
            .collect(),
    }
}

/// Row-major rows of a matrix.
pub(crate) fn rows(matrix: &Matrix6) -> [[f64; 6]; 6] {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}
