//! How far something is that a job thinks out: it waits for one, one runs, or it has ended.

/// Of one question.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum RequestProgress {
    #[default]
    Waiting,
    /// The job's number.
    Running(u64),
    Answered,
}

impl RequestProgress {
    /// Begins with a job, if none has begun; says whether it did.
    pub fn start(&mut self, job: u64) -> bool {
        let waiting = *self == Self::Waiting;
        if waiting {
            *self = Self::Running(job);
        }
        waiting
    }

    /// Whether a job is the one.
    pub fn is_run_by(self, job: u64) -> bool {
        self == Self::Running(job)
    }
}
