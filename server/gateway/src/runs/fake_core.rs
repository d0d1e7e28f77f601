//! Cores for the tests of archives and MCAP files of runs: one that answers from a list, and one that does not answer.

use super::stored_content::{CoreQueries, other_answer};
use api::{Query, QueryReply, StoredResult, StoredRun, StoredStep};
use site_model::{MissionId, RunId};
use std::io;
use uuid::Uuid;
use vocab::Stamp;

/// Answers with these results in pages of one, and with one attempt.
pub(super) struct FakeCore(pub(super) Vec<StoredResult>);

impl CoreQueries for FakeCore {
    fn ask(&self, query: Query) -> io::Result<QueryReply> {
        Ok(match query {
            Query::Steps { after: None, .. } => QueryReply::Steps(vec![StoredStep {
                step: 0,
                attempt: 1,
                state: "succeeded".into(),
                body: "{}".into(),
                intended: Stamp::from_nanos(1),
                done: None,
            }]),
            Query::Steps { .. } => QueryReply::Steps(Vec::new()),
            Query::Results { after, .. } => {
                let rest = self.0.iter().filter(|result| after.is_none_or(|after| result.number > after));
                QueryReply::Results(rest.take(1).cloned().collect())
            }
            _ => return Err(other_answer()),
        })
    }
}

/// A core that has ended.
pub(super) struct SilentCore;

impl CoreQueries for SilentCore {
    fn ask(&self, _: Query) -> io::Result<QueryReply> {
        Err(io::Error::other("gone"))
    }
}

/// A run in a state.
pub(super) fn run_in_state(run: RunId, state: &str) -> StoredRun {
    StoredRun {
        run,
        mission: MissionId(Uuid::from_u128(2)),
        state: state.into(),
        is_ended: state != "running",
        body: "{}".into(),
        began: Stamp::EPOCH,
        changed: Stamp::EPOCH,
    }
}
