//! Jobs: work that is too long for a step. The stack describes a job in [`crate::StackEffect::StartJob`], the shell runs it, and its result comes back
//! as `Input::JobDone`.
//!
//! Each kind of result has its owner, the part of the stack that waits for it. So a result cannot be handed to another part.

use crate::texts;
use crate::{
    ComparedRevisit, DisambiguationPlan, DisambiguationTask, FinishedMap, LoopTask, MapQuality,
    MapSearchResult, MapSearchTask, PriorMap, RelocalisationResponse, RelocalisationTask, RevisitTask,
    StackEffect, VerifiedLoop,
};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vocab::{MapId, Pose, SessionId};

/// The part of the stack that waits for the result of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum JobOwner {
    /// The saving of a finished map.
    MapSaving,
    /// A mapping session that extends a saved map.
    MapExtension,
    /// Loop closing of a mapping session.
    LoopClosing,
    /// The search for the robot in the map that a session extends.
    MapSearch,
    /// The end of a mapping session, which makes the poses as good as the graph allows.
    Relinearisation,
    /// The quality of the map under construction.
    MapQuality,
    /// Localisation in a saved map.
    Localisation,
    /// Relocalisation in that map.
    Relocalisation,
    /// Disambiguation of the poses that relocalisation found.
    Disambiguation,
}

/// Names a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct JobId {
    /// Who waits for its result.
    pub owner: JobOwner,
    /// Unique among the jobs of the owner.
    pub number: u64,
}

/// What a job is to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Job {
    /// Write a finished map as an immutable version.
    SaveMap(Arc<FinishedMap>),
    /// Check whether two keyframes saw the same place. The stack keeps the data of the job until the shell fetches it with
    /// `Stack::take_compute_job`. A replay never fetches it, because the result is in the log.
    VerifyLoop(LoopTask),
    /// Compare what is seen now with an old keyframe; as for [`Self::VerifyLoop`].
    CompareRevisit(RevisitTask),
    /// Read a saved map that a session extends, and make its clouds the first ones of the session.
    LoadMap {
        /// The session.
        session: SessionId,
        /// The saved map.
        map: MapId,
    },
    /// Search the robot's pose in that map; as for [`Self::VerifyLoop`].
    SearchMap(MapSearchTask),
    /// Solve the pose graph of a session that ends, with every factor linearised again; as for [`Self::VerifyLoop`].
    Relinearise(SessionId),
    /// Compute the quality of the map of a session; as for [`Self::VerifyLoop`].
    AssessQuality(SessionId),
    /// Read a saved map to localise in.
    ReadMap(MapId),
    /// Find the poses in that map at which a scan may have been taken; as for [`Self::VerifyLoop`].
    Relocalise(RelocalisationTask),
    /// Plan a path on which those poses can be distinguished; as for [`Self::VerifyLoop`].
    PlanDisambiguation(DisambiguationTask),
}

/// A job that has ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JobDone {
    /// Its number, see [`JobId`].
    pub number: u64,
    /// Its result, which also says who waits for it.
    pub result: JobResult,
}

/// The result of a job, by its owner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the variants are those of `JobOwner`")]
pub enum JobResult {
    MapSaving(Result<MapId, JobFailure>),
    MapExtension(Result<Arc<PriorMap>, JobFailure>),
    LoopClosing(Result<PlaceComparison, JobFailure>),
    MapSearch(Result<Box<MapSearchResult>, JobFailure>),
    /// Pose of every keyframe in the map, in the order of their ids.
    Relinearisation(Result<Vec<Pose>, JobFailure>),
    MapQuality(Result<MapQuality, JobFailure>),
    Localisation(Result<Arc<PriorMap>, JobFailure>),
    Relocalisation(Result<RelocalisationResponse, JobFailure>),
    Disambiguation(Result<DisambiguationPlan, JobFailure>),
}

/// A job was not done, or not to its end.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JobFailure {
    /// Why, and what to do: the rest of a sentence that begins with what was wanted, without a full stop.
    pub reason: String,
}

/// The result of a comparison for loop closing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum PlaceComparison {
    /// Of two keyframes.
    Loop(Box<VerifiedLoop>),
    /// Of a revisit with an old keyframe.
    Revisit(Box<ComparedRevisit>),
}

impl Job {
    /// Who waits for its result.
    pub fn owner(&self) -> JobOwner {
        match self {
            Self::SaveMap(_) => JobOwner::MapSaving,
            Self::LoadMap { .. } => JobOwner::MapExtension,
            Self::VerifyLoop(_) | Self::CompareRevisit(_) => JobOwner::LoopClosing,
            Self::SearchMap(_) => JobOwner::MapSearch,
            Self::Relinearise(_) => JobOwner::Relinearisation,
            Self::AssessQuality(_) => JobOwner::MapQuality,
            Self::ReadMap(_) => JobOwner::Localisation,
            Self::Relocalise(_) => JobOwner::Relocalisation,
            Self::PlanDisambiguation(_) => JobOwner::Disambiguation,
        }
    }
}

impl JobId {
    /// The job has ended without a result.
    pub fn failed(self, reason: impl Into<String>) -> JobDone {
        let failure = JobFailure { reason: reason.into() };
        let result = match self.owner {
            JobOwner::MapSaving => JobResult::MapSaving(Err(failure)),
            JobOwner::MapExtension => JobResult::MapExtension(Err(failure)),
            JobOwner::LoopClosing => JobResult::LoopClosing(Err(failure)),
            JobOwner::MapSearch => JobResult::MapSearch(Err(failure)),
            JobOwner::Relinearisation => JobResult::Relinearisation(Err(failure)),
            JobOwner::MapQuality => JobResult::MapQuality(Err(failure)),
            JobOwner::Localisation => JobResult::Localisation(Err(failure)),
            JobOwner::Relocalisation => JobResult::Relocalisation(Err(failure)),
            JobOwner::Disambiguation => JobResult::Disambiguation(Err(failure)),
        };
        JobDone { number: self.number, result }
    }

    /// The job has read a saved map. A job whose owner waits for no map has failed.
    pub fn map_read(self, map: Arc<PriorMap>) -> JobDone {
        let result = match self.owner {
            JobOwner::MapExtension => JobResult::MapExtension(Ok(map)),
            JobOwner::Localisation => JobResult::Localisation(Ok(map)),
            _ => return self.failed(texts::NOBODY_WAITS_FOR_MAP),
        };
        JobDone { number: self.number, result }
    }

    /// There was no time for the job, or its input is not wanted any more.
    pub fn not_done(self) -> JobDone {
        self.failed(texts::NO_TIME_FOR_JOB)
    }
}

impl JobResult {
    /// Who waits for it.
    pub fn owner(&self) -> JobOwner {
        match self {
            Self::MapSaving(_) => JobOwner::MapSaving,
            Self::MapExtension(_) => JobOwner::MapExtension,
            Self::LoopClosing(_) => JobOwner::LoopClosing,
            Self::MapSearch(_) => JobOwner::MapSearch,
            Self::Relinearisation(_) => JobOwner::Relinearisation,
            Self::MapQuality(_) => JobOwner::MapQuality,
            Self::Localisation(_) => JobOwner::Localisation,
            Self::Relocalisation(_) => JobOwner::Relocalisation,
            Self::Disambiguation(_) => JobOwner::Disambiguation,
        }
    }
}

impl StackEffect {
    /// Starts a job with the next of its owner's numbers.
    pub fn start_job(number: u64, work: Job) -> Self {
        Self::StartJob { job: JobId { owner: work.owner(), number }, work }
    }
}

impl JobDone {
    /// Which job it was.
    pub fn id(&self) -> JobId {
        JobId { owner: self.result.owner(), number: self.number }
    }
}
