//! Places of edits over HTTP that are being read. Whoever sends slowly holds places of the own account only.
//!
//! What is read stays in memory, so there are few places, in two lanes: short edits never wait for long ones. An account has a part of the places of each lane; what it
//! sends beyond that waits for its own requests.

use crate::limits::FIXED;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::{AcquireError, OwnedSemaphorePermit, Semaphore};

/// The places.
pub(crate) struct EditPlaces {
    short: Lane,
    long: Lane,
}

impl Default for EditPlaces {
    fn default() -> Self {
        Self {
            short: Lane::new(FIXED.max_short_edits_at_a_time, FIXED.max_short_edits_of_account),
            long: Lane::new(FIXED.max_long_edits_at_a_time, 1),
        }
    }
}

impl EditPlaces {
    /// Waits for a place for an edit of this account. `length` is what the request says of its length, bytes; without it the edit counts as long.
    ///
    /// # Errors
    /// When the gateway ends.
    pub(crate) async fn claim(
        &self,
        account: Option<&str>,
        length: Option<u64>,
    ) -> Result<EditPlace, AcquireError> {
        let is_short = length.is_some_and(|length| length <= FIXED.max_short_edit_bytes);
        let lane = if is_short { &self.short } else { &self.long };
        // The account's own first, so that those who wait for it hold no place of others.
        let _of_account = lane.of(account).acquire_owned().await?;
        let _of_all = Arc::clone(&lane.all).acquire_owned().await?;
        Ok(EditPlace { _of_account, _of_all })
    }
}

/// Places of edits of about the same length.
struct Lane {
    all: Arc<Semaphore>,
    most_of_account: usize,
    accounts: Mutex<BTreeMap<Option<String>, Arc<Semaphore>>>,
}

impl Lane {
    fn new(most: usize, most_of_account: usize) -> Self {
        Self { all: Arc::new(Semaphore::new(most)), most_of_account, accounts: Mutex::default() }
    }

    fn of(&self, account: Option<&str>) -> Arc<Semaphore> {
        let mut accounts = self.accounts.lock().unwrap_or_else(PoisonError::into_inner);
        accounts.retain(|_, places| Arc::strong_count(places) > 1);
        let places = accounts
            .entry(account.map(str::to_owned))
            .or_insert_with(|| Arc::new(Semaphore::new(self.most_of_account)));
        Arc::clone(places)
    }
}

/// A place. It is given back when it is dropped.
pub(crate) struct EditPlace {
    _of_account: OwnedSemaphorePermit,
    _of_all: OwnedSemaphorePermit,
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::FutureExt;

    /// A place, if there is one now.
    fn now(places: &EditPlaces, account: &str, length: Option<u64>) -> Option<EditPlace> {
        places.claim(Some(account), length).now_or_never()?.ok()
    }

    #[tokio::test]
    async fn an_account_that_sends_slowly_holds_its_own_places_only() {
        let places = EditPlaces::default();
        for length in [None, Some(1)] {
            let mut held = Vec::new();
            while let Some(place) = now(&places, "slow", length) {
                held.push(place);
            }
            assert!(!held.is_empty());
            assert!(now(&places, "ada", length).is_some() && now(&places, "ada", Some(1)).is_some());
            held.clear();
            assert!(now(&places, "slow", length).is_some(), "places are given back");
        }
        assert!(places.long.accounts.lock().expect("no panic").len() <= 2, "little is kept of accounts");
    }
}
