//! Looking for the robot's place in a saved map that a session goes on from.
//!
//! Nothing is known of where the robot is but that it stands upright somewhere in that map. What it walks past is kept, and every
//! other metre looked up as a whole, see [`mapping::MapMatcher`]; that takes a job. It is told only where enough of it is recognised, and
//! nowhere else as well.

use crate::loops::plain;
use crate::prior_map::DecodedPriorMap;
use crate::work::{ComputeJob, Seek};
use geometry::{Isometry, isometry_from_pose};
use mapping::{KeyframeDescriptor, MapMatcher, UncertainPose, VerificationConfig};
use messages::{Job, MapSearchOutcome, MapSearchResult, MapSearchTask, StackEffect};
use points::Downsampler;
use std::collections::VecDeque;
use vocab::{KeyframeId, MapId, SessionId};

/// The place is looked for after so many metres, and again after so many more: less is hardly ever enough to be recognised.
const FIRST: f64 = 12.0;
const AGAIN: f64 = 2.0;
/// Waypoints looked up at most, the newest: a metre and 40 kB each.
const KEPT: usize = 60;

/// A search that goes on until the place is found.
#[derive(Debug)]
pub(crate) struct Search {
    session: SessionId,
    map: MapId,
    chart: MapMatcher,
    /// Waypoints in odometry's frame, the first of them by number.
    walked: VecDeque<(Isometry, KeyframeDescriptor)>,
    first: u64,
    /// Metres walked, and after how many the place is looked for again.
    metres: f64,
    next: f64,
    running: Option<u64>,
    ambiguous: bool,
    downsampler: Downsampler,
}

/// Where a waypoint was.
#[derive(Debug)]
pub(crate) struct Found {
    pub waypoint: u64,
    pub keyframe: KeyframeId,
    pub keyframe_from_waypoint: UncertainPose,
}

impl Search {
    /// In a saved map.
    pub fn new(session: SessionId, known: &DecodedPriorMap) -> Self {
        Self {
            session,
            map: known.map,
            chart: known.chart(),
            walked: VecDeque::new(),
            first: 0,
            metres: 0.0,
            next: FIRST,
            running: None,
            ambiguous: false,
            downsampler: Downsampler::default(),
        }
    }

    /// The saved map.
    pub fn map(&self) -> MapId {
        self.map
    }

    /// Metres walked while looking.
    pub fn metres(&self) -> f64 {
        self.metres
    }

    /// Whether what was seen so far fits in two ways.
    pub fn is_ambiguous(&self) -> bool {
        self.ambiguous
    }

    /// Takes in the next waypoint with its cloud (base frame, metres), seen from `sensor` (base frame).
    pub fn arrive(&mut self, number: u64, pose: &Isometry, xyz: &[[f32; 3]], sensor: [f32; 3]) {
        if let Some((last, _)) = self.walked.back() {
            self.metres += (pose.translation.vector - last.translation.vector).norm();
        }
        let place = KeyframeDescriptor::new(xyz, &pose.rotation, sensor, &mut self.downsampler);
        self.walked.push_back((*pose, place));
        if self.walked.len() > KEPT {
            self.walked.pop_front();
        }
        self.first = (number + 1).saturating_sub(self.walked.len() as u64);
    }

    /// Starts a job, if it is time for one. `jobs` counts all jobs of the stack.
    pub fn start(&mut self, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        if self.running.is_some() || self.metres < self.next {
            return;
        }
        self.next = self.metres + AGAIN;
        effects.push(StackEffect::StartJob { job: *jobs, work: Job::SearchMap(self.task()) });
        self.running = Some(*jobs);
        *jobs += 1;
    }

    /// What a job takes.
    pub fn take(&self, job: u64) -> Option<ComputeJob> {
        (self.running == Some(job)).then(|| {
            let mut walked = MapMatcher::default();
            for (pose, place) in &self.walked {
                walked.push_place(pose, place.clone());
            }
            let (chart, gates) = (self.chart.clone(), VerificationConfig::default());
            ComputeJob::seek(Seek { task: self.task(), chart, walked, first: self.first, gates })
        })
    }

    /// A job has ended, with or without a result. Jobs of other searches are ignored.
    pub fn end(&mut self, job: u64, sought: Option<&MapSearchResult>) -> Option<Found> {
        if self.running != Some(job) {
            return None;
        }
        self.running = None;
        match sought?.found {
            MapSearchOutcome::Found { keyframe, waypoint, keyframe_from_base, information, .. } => {
                let pose = isometry_from_pose(&keyframe_from_base)?;
                let keyframe_from_waypoint =
                    UncertainPose::from_information(pose, &plain::from_rows(&information));
                Some(Found { waypoint, keyframe, keyframe_from_waypoint })
            }
            other => {
                self.ambiguous = matches!(other, MapSearchOutcome::Ambiguous(..));
                None
            }
        }
    }

    fn task(&self) -> MapSearchTask {
        let waypoint = (self.first + self.walked.len() as u64).saturating_sub(1);
        MapSearchTask { session: self.session, map: self.map, waypoint }
    }
}
