//! Progress of a request that a job answers. The request waits for its job, then the job runs, then the job has ended.

/// Progress of one request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum RequestProgress {
    /// No job has been started.
    #[default]
    Pending,
    /// This job runs.
    Running(u64),
    /// The job has ended, with an answer or without one.
    Done,
}

impl RequestProgress {
    /// Starts with this job. Returns false if one was started before.
    pub fn start(&mut self, job: u64) -> bool {
        let pending = *self == Self::Pending;
        if pending {
            *self = Self::Running(job);
        }
        pending
    }

    /// Whether this job runs.
    pub fn is_running(self, job: u64) -> bool {
        self == Self::Running(job)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_started_once_and_belongs_to_one_job() {
        let mut progress = RequestProgress::default();
        assert!(!progress.is_running(3));
        assert!(progress.start(3) && !progress.start(4));
        assert!(progress.is_running(3) && !progress.is_running(4));
        progress = RequestProgress::Done;
        assert!(!progress.start(5) && !progress.is_running(3));
    }
}
