//! The work of a job on the compute lane, as it leaves the stack: it owns what it needs.

use crate::localisation_phase::run_work;
use crate::mapping_messages::{self as plain, ComparisonTask};
use geometry::pose_from_isometry;
use localisation::LocalisationWork;
use mapping::{Comparison, MapQualityData, MapSearchData, Relinearisation, VerificationConfig, compare};
use messages::{JobDone, JobFailure, JobResult, MapSearchResult, MapSearchTask};
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
            Work::Localise { map, work } => run_work(map, &work),
        };
        JobDone { number: self.number, result }
    }
}
