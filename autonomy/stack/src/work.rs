//! The work of a job on the compute lane, as it leaves the stack: it owns what it needs.

use crate::mapping_messages::{self as plain, ComparisonTask};
use geometry::{pose_from_isometry, vec_to_plain};
use localisation::LocalisationWork;
use mapping::{Comparison, MapQualityData, MapSearchData, Relinearisation, VerificationConfig, compare};
use messages::{
    DisambiguationPlan, DisambiguationTask, JobDone, JobFailure, JobResult, MapSearchResult, MapSearchTask,
    RelocalisationResponse, RelocalisationTask,
};
use vocab::MapId;

/// Work that may run anywhere and at any time.
#[derive(Debug)]
pub struct ComputeJob {
    number: u64,
    work: Work,
}

#[derive(Debug)]
pub(crate) enum Work {
    Compare { task: ComparisonTask, comparison: Comparison, config: VerificationConfig },
    SearchMap { task: MapSearchTask, data: Box<MapSearchData> },
    Relinearise(Relinearisation),
    AssessQuality { revision: u64, data: MapQualityData },
    Localise { map: MapId, work: Box<LocalisationWork> },
}

impl ComputeJob {
    /// Of the job with this number.
    pub(crate) fn new(number: u64, work: Work) -> Self {
        Self { number, work }
    }

    /// Does the work: a pure function of what it owns. A comparison takes 5 to 25 ms. A search makes three or more comparisons for every other
    /// metre walked.
    pub fn run(self) -> JobDone {
        let result = match self.work {
            Work::Compare { task, comparison, config } => {
                JobResult::LoopClosing(Ok(task.result(&compare(&comparison, &config))))
            }
            Work::SearchMap { task, data } => {
                let found = plain::search_to_plain(data.run());
                JobResult::MapSearch(Ok(Box::new(MapSearchResult { task, found })))
            }
            Work::Relinearise(relinearisation) => JobResult::Relinearisation(match relinearisation.run() {
                Ok(poses) => Ok(poses.iter().map(pose_from_isometry).collect()),
                Err(error) => Err(JobFailure { reason: error.to_string() }),
            }),
            Work::AssessQuality { revision, data } => {
                JobResult::MapQuality(Ok(plain::quality_to_plain(revision, &data.run())))
            }
            Work::Localise { map, work } => run_localisation(map, &work),
        };
        JobDone { number: self.number, result }
    }
}

/// Does what a localisation job asks for in a map: a pure function.
fn run_localisation(map: MapId, work: &LocalisationWork) -> JobResult {
    match work {
        LocalisationWork::Relocalise(work) => {
            let plain = |one: &localisation::PoseHypothesis| messages::PoseHypothesis {
                map_from_base: pose_from_isometry(&one.map_from_base),
                fit: one.fit,
                violation_share: one.violation_share,
            };
            let hypotheses = work.run().iter().map(plain).collect();
            let task = RelocalisationTask { map, number: work.id() };
            JobResult::Relocalisation(Ok(RelocalisationResponse { task, hypotheses }))
        }
        LocalisationWork::PlanDisambiguation(work) => {
            let path = work.run().iter().map(vec_to_plain).collect();
            let task = DisambiguationTask { map, number: work.id() };
            JobResult::Disambiguation(Ok(DisambiguationPlan { task, path }))
        }
    }
}
