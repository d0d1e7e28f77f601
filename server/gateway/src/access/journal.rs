//! What the gateway refuses or does itself, for the audit log of the core.
//!
//! Requests that are equal in account, address, request and outcome are counted: the first is told within a second, and further ones as one entry after
//! [`JournalConfig::period`]. Those who have signed in and those who have not are counted apart, so that a flood by strangers hides nobody else. Beyond
//! [`JournalConfig::max_kinds`] kinds the rest of each is one kind without an address.

use super::{Identity, texts};
use accounts::{RepeatConfig, Repeats};
use api::{AuditNote, Caller, MAX_AUDIT_NOTES};
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Parameters of the [`AccessJournal`].
#[derive(Clone, Copy, Debug)]
struct JournalConfig {
    /// Time for which equal requests are counted before they are told again. Chosen: a client that asks again and again makes 144 entries a day.
    period: Duration,
    /// Kinds that are told apart, of those who have signed in and of others each. Chosen: more than people at one site try at a time; a flood makes 18,000 entries a day then.
    max_kinds: usize,
}

const CONFIG: JournalConfig = JournalConfig { period: Duration::from_secs(600), max_kinds: 64 };

/// What makes requests equal.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    account: Option<String>,
    address: Option<IpAddr>,
    request: String,
    refused: Option<String>,
}

/// Counts what the core has to be told.
pub(crate) struct AccessJournal {
    /// Of those who have not signed in, and of those who have.
    kinds: Mutex<[Repeats<Kind, Caller>; 2]>,
}

impl Default for AccessJournal {
    fn default() -> Self {
        let repeats = || Repeats::new(RepeatConfig { period: CONFIG.period, max_kinds: CONFIG.max_kinds });
        Self { kinds: Mutex::new([repeats(), repeats()]) }
    }
}

impl AccessJournal {
    /// A request was refused, with this sentence.
    pub(crate) fn refused(&self, by: &Identity, request: impl Into<String>, reason: impl Into<String>) {
        self.note(by, request.into(), Some(reason.into()));
    }

    /// A request was done without the core.
    pub(crate) fn done(&self, by: &Identity, request: impl Into<String>) {
        self.note(by, request.into(), None);
    }

    fn note(&self, by: &Identity, request: String, refused: Option<String>) {
        let mut kinds = self.kinds.lock().unwrap_or_else(PoisonError::into_inner);
        let repeats = &mut kinds[usize::from(by.role.is_some())];
        let kind = Kind { account: by.account.clone(), address: by.caller.address, request, refused };
        if !repeats.note(kind, by.caller, 1) {
            let rest = Caller { credential: None, address: None, ..by.caller };
            let (request, refused) =
                (texts::OTHER_REQUESTS.to_owned(), Some(texts::TOO_MANY_KINDS.to_owned()));
            repeats.note_always(Kind { account: None, address: None, request, refused }, rest, 1);
        }
    }

    /// Takes what the core has to be told now.
    pub(crate) fn take_due(&self, now: Instant) -> Vec<AuditNote> {
        let mut kinds = self.kinds.lock().unwrap_or_else(PoisonError::into_inner);
        let due = kinds.iter_mut().flat_map(|repeats| repeats.take_due(now, MAX_AUDIT_NOTES / 2));
        due.map(|due| AuditNote {
            by: due.last,
            request: due.kind.request,
            refused: due.kind.refused,
            count: due.count,
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use api::Role;

    fn somebody(last: u8, account: Option<&str>) -> Identity {
        let account = account.map(str::to_owned);
        let role = account.as_ref().map(|_| Role::Viewer);
        Identity { account, role, ..Identity::nobody(None, [192, 0, 2, last].into()) }
    }

    #[test]
    fn a_flood_by_strangers_is_a_few_entries_and_hides_nobody_who_has_signed_in() {
        let (journal, now) = (AccessJournal::default(), Instant::now());
        for round in 0..100 {
            for last in 0..=255 {
                journal.refused(&somebody(last, None), "GET /api/v1/audit", "Sign in.");
            }
            if round == 50 {
                journal.refused(&somebody(1, Some("ada")), "GET /api/v1/audit", "Ask an admin.");
            }
        }
        let told = journal.take_due(now);
        assert_eq!(told.len(), CONFIG.max_kinds + 2);
        assert_eq!(told.iter().map(|note| note.count).sum::<u32>(), 100 * 256 + 1);
        assert!(told.iter().any(|note| note.refused.as_deref() == Some("Ask an admin.")));
        assert!(journal.take_due(now).is_empty());
    }
}
