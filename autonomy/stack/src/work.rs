//! ComputeJob that is too long for a step, as it leaves the stack.

use crate::localisation_phase::run_work;
use crate::mapping_messages as plain;
use localisation::LocalisationWork;
use mapping::{Comparison, MapSearchData, QueuedComparison, VerificationConfig, compare};
use messages::{Job, JobResult, MapSearchResult, MapSearchTask};
use vocab::{MapId, SessionId};

/// What a job takes, owned: may run anywhere and at any time. Its result goes back as `Input::JobDone`.
#[derive(Debug)]
pub struct ComputeJob(Kind);

#[derive(Debug)]
enum Kind {
    Compare { description: Job, comparison: Comparison, config: VerificationConfig },
    SearchMap { task: MapSearchTask, data: Box<MapSearchData> },
    Localise { map: MapId, work: Box<LocalisationWork> },
}

impl ComputeJob {
    pub(crate) fn comparison(
        session: SessionId,
        queued: &QueuedComparison,
        comparison: Comparison,
        config: VerificationConfig,
    ) -> Self {
        Self(Kind::Compare { description: plain::comparison_job(session, queued), comparison, config })
    }

    pub(crate) fn search(task: MapSearchTask, data: MapSearchData) -> Self {
        Self(Kind::SearchMap { task, data: Box::new(data) })
    }

    pub(crate) fn localise(map: MapId, work: LocalisationWork) -> Self {
        Self(Kind::Localise { map, work: Box::new(work) })
    }

    /// Does the work: a pure function of what it owns. 5 to 25 ms for a comparison; a search makes three or more for
    /// every other metre walked.
    pub fn run(self) -> JobResult {
        match self.0 {
            Kind::Compare { description, comparison, config } => {
                let result = compare(&comparison, &config);
                match &description {
                    Job::VerifyLoop(task) => {
                        JobResult::LoopVerified(Box::new(plain::verified_to_plain(task, &result)))
                    }
                    Job::CompareRevisit(task) => {
                        JobResult::RevisitCompared(Box::new(plain::compared_to_plain(task, &result)))
                    }
                    other => JobResult::Failed { reason: format!("{other:?} is no comparison") },
                }
            }
            Kind::Localise { map, work } => run_work(map, &work),
            Kind::SearchMap { task, data } => {
                JobResult::MapSearched(MapSearchResult { task, found: plain::search_to_plain(data.run()) })
            }
        }
    }
}
