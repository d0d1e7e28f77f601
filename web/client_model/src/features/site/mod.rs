//! The documents of the site: its graph, inspection points, missions, schedules and monitors.
//!
//! The operator's edits take effect here at once and are sent to the robot, which applies them in its own order. Edits of others are merged: those of other objects
//! never conflict. Where somebody else has changed an object first, the robot refuses the later edit; it is then taken back here, with all that was built on it.
//!
//! An edit waits until earlier ones of the same objects are answered. So none is applied to a state that the operator has not seen.

mod action_forms;
mod alert_edits;
mod asset_edits;
mod block_edits;
mod camera_sight;
mod dock_edits;
mod draft;
mod draft_edits;
mod draft_fields;
mod edit;
mod floors;
mod graph_edits;
mod group_edits;
mod inspection_edits;
mod monitor_edits;
mod new_normal;
mod pending;
mod plan_file;
mod topomap_generation;
mod zone_edits;

pub use action_forms::{ActionForms, ParameterField, ParameterKind, ParameterProblem};
pub use asset_edits::tags_of;
pub use camera_sight::CameraSight;
pub(crate) use camera_sight::yaw_of;
pub use draft::{DraftChange, DraftCommand, DraftEntry, StoredDraft};
pub use draft_fields::{FieldChange, field_changes};
pub use edit::SiteEdit;
pub use zone_edits::{drawn_area, middle_of};

use super::Feature;
use super::history::HistoryStep;
use super::selection::PointerMode;
use crate::shared::{Context, SliceChange};
use crate::{ClientCommand, ClientEffect, ClientEvent, ClientTime, texts};
use api::{
    ClientMessage, EditOutcome, EditRefusal, Severity, SiteAssembly, SiteChanged, SiteState,
    TopomapGeneration,
};
use draft::{Draft, PublishedDraft};
use pending::{PendingEdit, PendingEdits};
use site_model::{Edit, EditError, EditId, RevisionChange, Site, UndoHistory};
use std::sync::Arc;
use topomap_generation::TopomapProgress;
use uuid::Uuid;
use vocab::{CameraHead, ClientId};

/// When edits are sent.
#[derive(Clone, Copy, Debug)]
struct SiteConfig {
    /// Time before an edit is sent again that could not be applied, seconds. Chosen: the edit of somebody else that was before it has come by then.
    retry_s: f64,
    /// Edits that may wait for the robot's answer. Chosen: a quarter of what the gateway allows one client.
    max_unanswered: usize,
}

const CONFIG: SiteConfig = SiteConfig { retry_s: 1.0, max_unanswered: 32 };

/// The site with the operator's own edits.
#[derive(Clone, Debug, Default)]
pub struct SiteFeature {
    /// As the robot has it; none before it has come.
    confirmed: Option<SiteState>,
    /// With own edits that the robot has not confirmed.
    shown: Site,
    /// What is shown while the draft is on: `shown` with the draft in it.
    drafted: Site,
    draft: Draft,
    /// The draft that the robot has not confirmed.
    published: Option<PublishedDraft>,
    /// Grows with every change of what is shown.
    revision: u64,
    pending: PendingEdits,
    history: UndoHistory,
    assembly: SiteAssembly,
    /// Whether the whole site was asked for, because changes were lost.
    is_requested: bool,
    /// When refused edits are sent again.
    retry_at: Option<ClientTime>,
    /// What ids of new objects are made of.
    id_seed: Option<Uuid>,
    topomap: TopomapProgress,
    /// The floor that is shown; `None`: all.
    floor: Option<i32>,
    /// The forms of actions: those of the common camera head before the server has said which the robot has.
    action_forms: Arc<ActionForms>,
}

impl SiteFeature {
    /// The site as the operator sees it, with the draft while that is on; none before it has come.
    pub fn site(&self) -> Option<&Site> {
        self.confirmed.as_ref().map(|_| if self.draft.is_on() { &self.drafted } else { &self.shown })
    }

    /// The site as the robot has it, with the number of edits that led to it.
    pub fn confirmed(&self) -> Option<&SiteState> {
        self.confirmed.as_ref()
    }

    /// Grows with every change of [`Self::site`].
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The head of the robot's cameras, of its profile; that of the default profile before the server has said it.
    pub fn camera_head(&self) -> CameraHead {
        self.action_forms.camera_head()
    }

    /// The forms of the actions that can be asked for.
    pub fn action_forms(&self) -> &Arc<ActionForms> {
        &self.action_forms
    }

    /// Edits that the robot has not confirmed.
    pub fn unconfirmed(&self) -> usize {
        self.pending.len()
    }

    /// Ids for new objects, by a number of the caller's below a million. They are new until the next edit.
    pub fn new_id(&self, number: u32) -> Uuid {
        // The numbers are high bits, which no other id that the client draws differs in.
        let bits = self.id_seed.unwrap_or_default().as_u128() ^ (u128::from(number) + 1) << 82;
        uuid::Builder::from_random_bytes(bits.to_be_bytes()).into_uuid()
    }

    /// The making of a topological map: while it runs, and its result until it is dismissed.
    pub fn topomap_generation(&self) -> &TopomapGeneration {
        self.topomap.shown()
    }

    /// Whether there is an edit that can be undone.
    pub fn can_undo(&self) -> bool {
        self.history.can_undo()
    }

    /// Whether there is an undone edit.
    pub fn can_redo(&self) -> bool {
        self.history.can_redo()
    }

    fn edit(&mut self, wanted: &SiteEdit, cx: &mut Context<'_>) {
        if self.confirmed.is_none() {
            return cx.notify(Severity::Warning, texts::SITE_NOT_LOADED.to_owned());
        }
        if self.draft.is_on() {
            return self.edit_draft(wanted, cx);
        }
        let id = cx.shared.ids.edit();
        self.id_seed = None;
        let edit = self.edit_of(id, wanted);
        if edit.changes.is_empty() {
            return;
        }
        if api::encoded_bytes(&edit) > api::MAX_EDIT_BYTES {
            return cx.notify(Severity::Warning, texts::EDIT_TOO_LONG.to_owned());
        }
        self.apply_own(edit, cx);
    }

    /// Applies an own edit to what is shown, as a step of undo, and sends it.
    fn apply_own(&mut self, edit: Edit, cx: &mut Context<'_>) {
        match self.shown.apply(&edit, edit.id) {
            Ok(applied) => {
                let revisions = applied.revisions.clone();
                self.history.record(applied);
                cx.shared.history.add(HistoryStep::Site);
                self.add(edit, revisions, cx);
            }
            Err(error) => cx.notify(Severity::Warning, texts::edit_refused(&error.to_string())),
        }
    }

    fn edit_of(&self, id: EditId, wanted: &SiteEdit) -> Edit {
        let site = if self.draft.is_on() { &self.drafted } else { &self.shown };
        let mut changes = Vec::new();
        for object in &wanted.removed {
            for change in site.removal(id, *object).changes {
                let is_known = |known: &site_model::Change| known.object_id() == change.object_id();
                if !changes.iter().any(is_known) {
                    changes.push(change);
                }
            }
        }
        changes.extend(wanted.put.iter().flat_map(|object| site.put(id, object.clone()).changes));
        Edit { id, changes }
    }

    /// An own edit was applied to what is shown.
    fn add(&mut self, edit: Edit, revisions: Vec<RevisionChange>, cx: &mut Context<'_>) {
        self.mark_changed();
        self.pending.add(edit, revisions);
        self.send(cx);
    }

    /// Sends what may be sent now.
    fn send(&mut self, cx: &mut Context<'_>) {
        if cx.shared.connection.is_connected() && self.retry_at.is_none() {
            let edits = self.pending.take_sendable(CONFIG.max_unanswered);
            cx.effects.extend(edits.map(|edit| ClientEffect::Send(ClientMessage::Edit(edit))));
        }
    }

    /// Makes what is shown anew.
    fn rebuild(&mut self) {
        let Some(confirmed) = &self.confirmed else { return };
        self.shown = confirmed.site.clone();
        self.pending.apply_to(&mut self.shown);
        self.mark_changed();
    }

    fn on_whole(&mut self, state: SiteState, cx: &mut Context<'_>) {
        self.is_requested = false;
        let revision = state.revision;
        self.confirmed = Some(state);
        self.pending.confirm_up_to(revision);
        self.rebuild();
        self.send(cx);
    }

    fn on_changed(&mut self, changed: &SiteChanged, cx: &mut Context<'_>) {
        let Some(confirmed) = &mut self.confirmed else { return };
        if changed.revision <= confirmed.revision {
            return;
        }
        // The platform itself makes an edit when the site follows its map: every operator may undo it.
        let is_of_platform = changed.by == Some(ClientId(Uuid::nil()));
        if self.topomap.remove_awaited(changed.edit.id) || is_of_platform {
            // Its inverse refers to the site before it.
            if let Ok(applied) = confirmed.site.clone().apply(&changed.edit, changed.edit.id) {
                self.history.record(applied);
                cx.shared.history.add(HistoryStep::Site);
            }
        }
        if !confirmed.apply(changed) {
            if !std::mem::replace(&mut self.is_requested, true) {
                cx.effects.push(ClientEffect::Send(ClientMessage::RequestSite));
            }
            return;
        }
        let revision = confirmed.revision;
        self.on_published(changed.edit.id, cx);
        let is_shown_already = self.pending.confirm(changed.edit.id);
        self.pending.confirm_up_to(revision);
        let is_apart = !self.pending.touches(&changed.edit);
        if is_shown_already {
            // It was applied when it was made.
        } else if is_apart && self.shown.apply(&changed.edit, changed.edit.id).is_ok() {
            self.mark_changed();
        } else {
            self.rebuild();
        }
        self.send(cx);
    }

    fn on_done(&mut self, id: EditId, outcome: &EditOutcome, cx: &mut Context<'_>) {
        match outcome {
            EditOutcome::Applied { revision, .. } => {
                self.pending.set_applied(id, *revision);
                self.on_published(id, cx);
                if let Some(confirmed) = self.confirmed.as_ref().map(|confirmed| confirmed.revision)
                    && self.pending.confirm_up_to(confirmed)
                {
                    self.rebuild();
                }
            }
            EditOutcome::Refused(EditRefusal::Unavailable(_)) => {
                self.pending.set_unsent(id);
                self.retry_at = Some(cx.now().after(CONFIG.retry_s));
            }
            EditOutcome::Refused(EditRefusal::Rejected(reason)) => {
                self.revert_edit(id, texts::edit_rejected(reason), cx);
            }
            EditOutcome::Refused(EditRefusal::Invalid(errors)) => {
                let reason = errors.first().map_or_else(String::new, EditError::to_string);
                self.revert_edit(id, texts::edit_refused(&reason), cx);
            }
        }
        self.send(cx);
    }

    /// Reverts an edit that the robot refused, and what was built on it.
    fn revert_edit(&mut self, id: EditId, text: String, cx: &mut Context<'_>) {
        let dropped = self.pending.drop_with_dependents(id);
        if dropped.is_empty() {
            return;
        }
        for PendingEdit { edit, revisions, .. } in &dropped {
            self.history.forget(edit.id, revisions);
            self.on_reverted(edit.id);
        }
        self.rebuild();
        cx.notify(Severity::Warning, text);
    }

    /// Takes a step of the history. Returns whether there was one.
    fn step(
        &mut self,
        step: impl FnOnce(&mut UndoHistory, &mut Site, EditId) -> Result<Option<Edit>, EditError>,
        cx: &mut Context<'_>,
    ) -> bool {
        let id = cx.shared.ids.edit();
        match step(&mut self.history, &mut self.shown, id) {
            Ok(None) => false,
            Ok(Some(edit)) => {
                let change = |change: &site_model::Change| RevisionChange {
                    object: change.object_id(),
                    before: change.base(),
                    after: self.shown.revision(change.object_id()),
                };
                let revisions = edit.changes.iter().map(change).collect();
                self.add(edit, revisions, cx);
                true
            }
            // The step is given up.
            Err(error) => {
                cx.notify(Severity::Warning, texts::undo_refused(&error.to_string()));
                true
            }
        }
    }
}

impl Feature for SiteFeature {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        match event {
            api::Event::SitePart(part) => {
                if let Some(state) = self.assembly.add(part) {
                    self.on_whole(state, cx);
                }
            }
            api::Event::SiteChanged(changed) => self.on_changed(changed, cx),
            api::Event::EditDone(done) => self.on_done(done.id, &done.outcome, cx),
            api::Event::TopomapGeneration(state) => self.topomap.on_state(state),
            api::Event::Platform(platform) => {
                let head = platform.body.map(|body| body.camera_head);
                if let Some(head) = head.filter(|head| *head != self.camera_head()) {
                    let offered = self.action_forms.offered().to_vec();
                    self.action_forms = Arc::new(ActionForms::new(head, offered));
                }
            }
            api::Event::Actions(offered) => {
                self.action_forms = Arc::new(ActionForms::new(self.camera_head(), offered.clone()));
            }
            _ => {}
        }
    }

    fn on_client_event(&mut self, event: &ClientEvent, cx: &mut Context<'_>) {
        match event {
            ClientEvent::Tick => {
                let now = cx.now();
                if self.retry_at.take_if(|at| now.since(*at) >= 0.0).is_some() {
                    self.send(cx);
                }
            }
            ClientEvent::PlanFileRead { name, result } => self.on_plan_file(name, result, cx),
            _ => {}
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::EditSite(edit) => self.edit(edit, cx),
            ClientCommand::SavePlanFile => self.save_plan_file(cx),
            ClientCommand::LoadPlanFile => cx.effects.push(ClientEffect::OpenPlanFile),
            ClientCommand::GenerateTopomap(map) => {
                let edit = cx.shared.ids.edit();
                self.topomap.wait_for(edit);
                cx.send(api::Command::GenerateTopomap { map: *map, edit });
            }
            ClientCommand::MakeNormal(changes) => self.make_normal(changes, cx),
            ClientCommand::DismissTopomapResult => self.topomap.dismiss(),
            ClientCommand::UseGraphTool(Some(tool)) => {
                cx.shared.selected.enter(PointerMode::EditGraph(*tool));
            }
            ClientCommand::UseGraphTool(None) => cx.shared.selected.enter(PointerMode::Select),
            ClientCommand::SelectNodes(nodes) => cx.shared.selected.select_nodes(nodes),
            ClientCommand::Select(_) => cx.shared.selected.part(),
            ClientCommand::Draft(command) => self.on_draft_command(*command, cx),
            ClientCommand::ShowFloor(floor) => self.floor = *floor,
            _ => {}
        }
    }

    fn on_change(&mut self, change: &SliceChange, cx: &mut Context<'_>) {
        if *change == SliceChange::Connected {
            self.is_requested = false;
            self.retry_at = None;
            self.pending.set_all_unsent();
            self.send(cx);
        }
    }

    fn after_event(&mut self, cx: &mut Context<'_>) {
        if self.id_seed.is_none() {
            self.id_seed = Some(cx.shared.ids.edit().0);
        }
    }

    fn undo(&mut self, step: HistoryStep, cx: &mut Context<'_>) -> bool {
        let done = match step {
            HistoryStep::Site => self.step(UndoHistory::undo, cx),
            HistoryStep::Draft => self.step_draft(true, cx),
            _ => false,
        };
        if done {
            cx.shared.history.add_undone(step);
        }
        done
    }

    fn redo(&mut self, step: HistoryStep, cx: &mut Context<'_>) -> bool {
        let done = match step {
            HistoryStep::Site => self.step(UndoHistory::redo, cx),
            HistoryStep::Draft => self.step_draft(false, cx),
            _ => false,
        };
        if done {
            cx.shared.history.add_redone(step);
        }
        done
    }
}

#[cfg(test)]
mod draft_tests;
#[cfg(test)]
mod group_tests;
#[cfg(test)]
mod tests;
