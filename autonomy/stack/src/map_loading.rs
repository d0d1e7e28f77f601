//! Waiting for a saved map that a job reads.

use crate::texts;
use messages::{JobFailure, PriorMap};
use std::sync::Arc;
use vocab::MapId;

/// A saved map that a phase waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapLoading {
    map: MapId,
    /// The job that reads it, once that has been started.
    job: Option<u64>,
}

impl MapLoading {
    /// Waits for a map; no job reads it yet.
    pub fn new(map: MapId) -> Self {
        Self { map, job: None }
    }

    /// The map.
    pub fn map(self) -> MapId {
        self.map
    }

    /// The number of the job that is to be started now; none if it was started before. `jobs` counts all jobs of the stack.
    pub fn start(&mut self, jobs: &mut u64) -> Option<u64> {
        if self.job.is_some() {
            return None;
        }
        self.job = Some(*jobs);
        *jobs += 1;
        self.job
    }

    /// What the job has read, or a sentence for people why the map cannot be used. None if this is not the job.
    pub fn finish(
        self,
        job: u64,
        read: &Result<Arc<PriorMap>, JobFailure>,
    ) -> Option<Result<&Arc<PriorMap>, String>> {
        (self.job == Some(job))
            .then(|| read.as_ref().map_err(|failure| texts::map_not_usable(&failure.reason)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_read_by_one_job_and_another_jobs_map_is_ignored() {
        let mut loading = MapLoading::new(MapId(uuid::Uuid::from_u128(1)));
        let failed = Err(JobFailure { reason: "no file".to_owned() });
        assert!(loading.finish(4, &failed).is_none(), "no job was started");
        let mut jobs = 4;
        assert_eq!((loading.start(&mut jobs), loading.start(&mut jobs), jobs), (Some(4), None, 5));
        assert!(loading.finish(5, &failed).is_none(), "another job");
        assert!(loading.finish(4, &failed).is_some_and(|read| read.is_err()));
    }
}
