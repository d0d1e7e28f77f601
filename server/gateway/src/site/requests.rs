//! Edits and questions on their way to the core, and who waits for the answers over HTTP.

use crate::limits::FIXED;
use crate::texts;
use api::{EditDone, EditOutcome, QueryReply};
use site_model::{Edit, EditId};
use std::collections::{BTreeMap, BTreeSet};
use tokio::sync::oneshot;

type Reply = Result<QueryReply, String>;

/// What the core has not answered.
#[derive(Default)]
pub(crate) struct SiteRequests {
    /// Edits that came over HTTP.
    edits: BTreeMap<EditId, oneshot::Sender<EditOutcome>>,
    /// Large edits of all clients.
    large: BTreeSet<EditId>,
    /// Questions by their number.
    queries: BTreeMap<u64, oneshot::Sender<Reply>>,
    queries_made: u64,
}

impl SiteRequests {
    /// The core is lost: those who wait learn it from their end of the channel.
    pub(crate) fn clear(&mut self) {
        self.edits.clear();
        self.large.clear();
        self.queries.clear();
    }

    /// Counts an edit that is about to be forwarded.
    ///
    /// # Errors
    /// When it is large and too many of these are under way.
    pub(crate) fn admit(&mut self, edit: &Edit) -> Result<(), &'static str> {
        if api::encoded_bytes(edit) > FIXED.large_edit_bytes {
            if self.large.len() >= FIXED.max_large_edits && !self.large.contains(&edit.id) {
                return Err(texts::CORE_BUSY);
            }
            self.large.insert(edit.id);
        }
        Ok(())
    }

    /// A handler waits for the answer to this edit.
    ///
    /// # Errors
    /// When too many wait.
    pub(crate) fn wait_for_edit(
        &mut self,
        id: EditId,
    ) -> Result<oneshot::Receiver<EditOutcome>, &'static str> {
        self.edits.retain(|_, waiting| !waiting.is_closed());
        if self.edits.len() >= FIXED.max_http_commands {
            return Err(texts::CORE_BUSY);
        }
        let (sender, receiver) = oneshot::channel();
        self.edits.insert(id, sender);
        Ok(receiver)
    }

    /// A handler waits for the answer to a question. Returns its number too.
    ///
    /// # Errors
    /// When too many wait.
    pub(crate) fn wait_for_reply(&mut self) -> Result<(u64, oneshot::Receiver<Reply>), &'static str> {
        self.queries.retain(|_, waiting| !waiting.is_closed());
        if self.queries.len() >= FIXED.max_http_commands {
            return Err(texts::CORE_BUSY);
        }
        self.queries_made += 1;
        let (sender, receiver) = oneshot::channel();
        self.queries.insert(self.queries_made, sender);
        Ok((self.queries_made, receiver))
    }

    /// The core has answered an edit. Returns whether a handler waited for it.
    pub(crate) fn edit_done(&mut self, done: &EditDone) -> bool {
        self.large.remove(&done.id);
        let waiting = self.edits.remove(&done.id);
        // Whoever waited may have gone.
        waiting.map(|waiting| waiting.send(done.outcome.clone()).ok()).is_some()
    }

    /// The core has answered a question.
    pub(crate) fn reply(&mut self, number: u64, reply: Reply) {
        if let Some(waiting) = self.queries.remove(&number) {
            waiting.send(reply).ok();
        }
    }
}
