//! The draft of the site in the slice: where edits go while it is on, publishing, and what is shown.

use super::draft::{DraftCommand, DraftEntry, PublishedDraft, StoredDraft};
use super::{SiteEdit, SiteFeature};
use crate::features::history::HistoryStep;
use crate::shared::Context;
use crate::{ClientEffect, texts};
use api::Severity;
use site_model::EditId;

impl SiteFeature {
    /// Whether edits go into a draft.
    pub fn is_draft(&self) -> bool {
        self.draft.is_on()
    }

    /// What the draft changes of the site, in the order of the ids.
    pub fn draft_entries(&self) -> impl Iterator<Item = DraftEntry<'_>> {
        self.draft.entries(&self.shown)
    }

    /// The site without the draft.
    pub fn published_site(&self) -> &site_model::Site {
        &self.shown
    }

    pub(crate) fn restore_draft(&mut self, stored: StoredDraft) {
        self.draft = super::draft::Draft::from_stored(stored);
        self.mark_changed();
    }

    /// What is shown has changed.
    pub(super) fn mark_changed(&mut self) {
        self.revision += 1;
        if self.draft.is_on() {
            self.drafted = self.draft.applied_to(&self.shown);
        }
    }

    /// An edit goes into the draft.
    pub(super) fn edit_draft(&mut self, wanted: &SiteEdit, cx: &mut Context<'_>) {
        let id = cx.shared.ids.edit();
        self.id_seed = None;
        let edit = self.edit_of(id, wanted);
        match self.drafted.check(&edit) {
            Ok(()) => {
                let is_new = self.draft.add(&edit, &self.shown);
                self.on_draft_changed(is_new, cx);
            }
            Err(error) => cx.notify(Severity::Warning, texts::edit_refused(&error.to_string())),
        }
    }

    pub(super) fn on_draft_command(&mut self, command: DraftCommand, cx: &mut Context<'_>) {
        match command {
            DraftCommand::Begin => {
                self.draft.set_on(true);
                self.on_draft_changed(false, cx);
            }
            DraftCommand::Publish => self.publish(cx),
            DraftCommand::Discard => {
                let is_step = self.draft_entries().next().is_some() && self.draft.discard();
                self.draft.set_on(false);
                self.on_draft_changed(is_step, cx);
            }
            DraftCommand::Resolve { object, keep_mine } => {
                let is_step = self.draft.resolve(object, keep_mine, &self.shown);
                self.on_draft_changed(is_step, cx);
            }
        }
    }

    /// Makes one edit of the draft, which is one step of undo.
    fn publish(&mut self, cx: &mut Context<'_>) {
        if self.confirmed.is_none() {
            return cx.notify(Severity::Warning, texts::SITE_NOT_LOADED.to_owned());
        }
        if self.draft_entries().any(|entry| entry.is_conflict) {
            return cx.notify(Severity::Warning, texts::DRAFT_CONFLICTS.to_owned());
        }
        let edit = self.draft.edit(cx.shared.ids.edit(), &self.shown);
        if api::encoded_bytes(&edit) > api::MAX_EDIT_BYTES {
            return cx.notify(Severity::Warning, texts::EDIT_TOO_LONG.to_owned());
        }
        let changes = self.draft.take_published();
        cx.shared.history.forget_drafts();
        if edit.changes.is_empty() {
            return self.on_draft_changed(false, cx);
        }
        // It is kept in storage until the robot has it.
        self.published = Some(PublishedDraft { edit: edit.id, changes });
        self.apply_own(edit, cx);
    }

    /// The robot has an edit: if it was a draft, nothing of it is needed any more.
    pub(super) fn on_published(&mut self, edit: EditId, cx: &mut Context<'_>) {
        if self.published.take_if(|published| published.edit == edit).is_some() {
            self.save_draft(cx);
        }
    }

    /// The robot has refused an edit: if it was a draft, work on it goes on.
    pub(super) fn on_reverted(&mut self, edit: EditId) {
        if let Some(published) = self.published.take_if(|published| published.edit == edit) {
            self.draft.restore(published.changes);
        }
    }

    /// Takes a step of the draft back, or makes it again. Returns whether there was one.
    pub(super) fn step_draft(&mut self, is_undo: bool, cx: &mut Context<'_>) -> bool {
        let done = if is_undo { self.draft.undo() } else { self.draft.redo() };
        if done {
            self.on_draft_changed(false, cx);
        }
        done
    }

    fn on_draft_changed(&mut self, is_step: bool, cx: &mut Context<'_>) {
        if is_step {
            cx.shared.history.add(HistoryStep::Draft);
        }
        self.mark_changed();
        self.save_draft(cx);
    }

    fn save_draft(&self, cx: &mut Context<'_>) {
        cx.effects.push(ClientEffect::SaveDraft(self.draft.to_stored()));
    }
}
