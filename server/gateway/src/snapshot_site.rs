//! The site in the snapshot: the whole of it, and the last changes for clients that know an earlier revision.

use crate::limits::FIXED;
use api::{Event, SiteAssembly, SiteChanged, SitePart, SiteParts, SiteState};
use std::collections::VecDeque;
use std::sync::Arc;

/// A change with its revision in the snapshot and its bytes.
type KeptChange = (u64, usize, Arc<Event>);

/// The site, as the core has sent it.
#[derive(Default)]
pub(crate) struct SiteFeed {
    /// None before the core has sent it.
    state: Option<Arc<SiteState>>,
    /// Revision in the snapshot of the last change.
    revision: u64,
    changes: VecDeque<KeptChange>,
    /// Sum of their bytes.
    bytes: usize,
    /// Clients that were sent this revision of the snapshot or a later one can apply the changes.
    changes_from: u64,
    parts: SiteAssembly,
    /// Whether a change came that does not apply. The site stays as it was until the whole of it comes.
    pub(crate) is_stale: bool,
}

impl SiteFeed {
    /// The site.
    pub(crate) fn state(&self) -> Option<&Arc<SiteState>> {
        self.state.as_ref()
    }

    /// Takes in a part of the whole site; `revision` is the next one of the snapshot. Returns whether it was used.
    pub(crate) fn add_part(&mut self, part: &SitePart, revision: u64) -> bool {
        let Some(state) = self.parts.add(part) else { return false };
        self.is_stale = false;
        // A core that connects again sends what clients have already.
        if self.state.as_deref() == Some(&state) {
            return false;
        }
        self.state = Some(Arc::new(state));
        self.changes.clear();
        (self.revision, self.changes_from, self.bytes) = (revision, revision, 0);
        true
    }

    /// Applies a change; `revision` is the next one of the snapshot. Returns whether it was used. One that does not apply is dropped.
    pub(crate) fn change(&mut self, changed: SiteChanged, revision: u64) -> bool {
        let is_applied = self.state.as_mut().is_some_and(|state| Arc::make_mut(state).apply(&changed));
        if !is_applied {
            self.is_stale = true;
            return false;
        }
        self.revision = revision;
        let bytes = api::encoded_bytes(&changed);
        self.bytes += bytes;
        self.changes.push_back((revision, bytes, Arc::new(Event::SiteChanged(changed))));
        while (self.changes.len() > FIXED.max_site_changes || self.bytes > FIXED.max_site_change_bytes)
            && let Some((dropped, bytes, _)) = self.changes.pop_front()
        {
            self.bytes -= bytes;
            self.changes_from = dropped;
        }
        true
    }

    /// Revision of what a client is owed that was sent `seen`, if anything.
    pub(crate) fn owed(&self, seen: u64) -> Option<u64> {
        self.state.as_ref().map(|_| self.revision).filter(|revision| *revision > seen)
    }

    /// The next change after a revision; none if the client needs the whole site.
    fn next_change(&self, seen: u64) -> Option<&KeptChange> {
        if seen < self.changes_from {
            return None;
        }
        self.changes.iter().find(|(revision, ..)| *revision > seen)
    }
}

/// What one client was sent of the site.
#[derive(Clone, Debug, Default)]
pub(crate) struct SiteCursor {
    /// Revision of the snapshot that it has.
    pub(crate) seen: u64,
    /// The whole site that is being sent, with its revision in the snapshot.
    parts: Option<(u64, SiteParts)>,
}

impl SiteCursor {
    /// The client has lost the site: the whole of it is owed again.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// The next event that it is owed.
    pub(crate) fn next(&mut self, feed: &SiteFeed) -> Option<Arc<Event>> {
        if self.parts.is_none() {
            if let Some((revision, _, event)) = feed.next_change(self.seen) {
                self.seen = *revision;
                return Some(event.clone());
            }
            self.parts = Some((feed.revision, SiteParts::new(feed.state.clone()?)));
        }
        let (revision, parts) = self.parts.as_mut()?;
        let part = parts.next_part();
        if part.is_last {
            self.seen = *revision;
            self.parts = None;
        }
        Some(Arc::new(Event::SitePart(part)))
    }
}
