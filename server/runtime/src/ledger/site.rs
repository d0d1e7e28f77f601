//! The site and the ledger that holds it. An edit is applied to the site in memory, written, and then published and answered.

use super::alerts::{AlertsConfig, edit_of_result, edit_of_step};
use super::reading_limits::PointReport;
use super::{EditRequest, LedgerConfig, LedgerWrite, SiteWork, refusal_reason};
use crate::access::audit_texts;
use crate::clock::{CalendarTime, RobotClock};
use crate::mailbox::Mailbox;
use crate::state_publisher::StatePublisher;
use crate::texts;
use api::{
    CoreMessage, EditDone, EditOutcome, EditRefusal, Event, MAX_EDIT_CHANGES, MAX_OBJECT_BYTES,
    MAX_SITE_OBJECTS, Query, QueryReply, SiteChanged, SiteState,
};
use crossbeam_channel::Sender;
use messages::{Input, LedgerEvent, Principal, Severity, SiteSnapshot, SiteWrite};
use ports::error_with_causes;
use site_model::{Change, Edit, EditId, Site};
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::{EditRecord, Ledger, LedgerWriter, Store, StoreError};
use uuid::Uuid;
use vocab::{ClientId, Stamp};

/// The ledger with the site that it holds. Both are of the same state whenever no transaction is under way.
pub struct SiteKeeper {
    store: Arc<Store>,
    /// None while the ledger cannot be opened.
    open: Option<OpenLedger>,
    /// Why it could not be opened last, a clause.
    problem: String,
    /// When it is tried again.
    retry_at: Instant,
    retry_period: Duration,
    /// Entries of the audit log that are kept.
    audit_entries: u64,
    state_publisher: Arc<StatePublisher>,
    /// What the stack has to know of the site and of earlier runs. Bounded: the ledger waits while it is full.
    inputs: Sender<Input>,
    /// Whether the stack was told what earlier programs have committed.
    are_missions_restored: bool,
    mailbox: Arc<Mailbox>,
    clock: Arc<RobotClock>,
}

struct OpenLedger {
    ledger: Ledger,
    state: SiteState,
}

/// What an edit did, or why nothing.
struct Applied {
    id: EditId,
    outcome: EditOutcome,
    /// What all clients are told.
    changed: Option<SiteChanged>,
}

impl SiteKeeper {
    /// Opens the ledger and publishes the site. If it cannot be opened, that is tried again when somebody needs it.
    pub fn open(
        store: Arc<Store>,
        state_publisher: Arc<StatePublisher>,
        inputs: Sender<Input>,
        mailbox: Arc<Mailbox>,
        clock: Arc<RobotClock>,
        config: LedgerConfig,
    ) -> Self {
        let mut keeper = Self {
            store,
            open: None,
            problem: String::new(),
            retry_at: Instant::now(),
            retry_period: config.retry_period,
            audit_entries: config.audit_entries,
            state_publisher,
            inputs,
            are_missions_restored: false,
            mailbox,
            clock,
        };
        if let Err(reason) = keeper.opened() {
            keeper.store.note_problem(texts::ledger_not_open(&reason));
        }
        keeper
    }

    /// The open ledger.
    ///
    /// # Errors
    /// Why it cannot be opened, a clause.
    fn opened(&mut self) -> Result<&mut OpenLedger, String> {
        if self.open.is_none() {
            if Instant::now() < self.retry_at {
                return Err(self.problem.clone());
            }
            match self.store.open_ledger() {
                Ok((mut ledger, state)) => {
                    ledger.keep_audit_entries(self.audit_entries);
                    self.state_publisher.publish_site(&state);
                    self.send_to_stack(&ledger, &state);
                    self.open = Some(OpenLedger { ledger, state });
                }
                Err(error) => {
                    self.problem = error_with_causes(&error);
                    self.retry_at = Instant::now() + self.retry_period;
                    tracing::error!("{}", texts::ledger_not_open(&self.problem));
                }
            }
        }
        self.open.as_mut().ok_or_else(|| self.problem.clone())
    }

    /// Gives the stack the site, and once what it needs of earlier runs. Events that cannot be read are told to people: runs are not taken up then.
    fn send_to_stack(&mut self, ledger: &Ledger, state: &SiteState) {
        if !std::mem::replace(&mut self.are_missions_restored, true) {
            match ledger.events_for_restart() {
                // The control loop may have ended already, here and below.
                Ok(events) => drop(self.inputs.send(Input::MissionsRestored(events))),
                Err(error) => {
                    let reason = texts::runs_not_restored(&error_with_causes(&error));
                    tracing::error!("{reason}");
                    self.mailbox.notice(self.clock.now(), Severity::Error, reason);
                }
            }
        }
        let objects = state.site.objects().cloned().collect();
        let snapshot = SiteSnapshot { objects, removed: state.site.removed().collect() };
        let _ = self.inputs.send(Input::Site(Box::new(snapshot)));
    }

    /// The ledger has failed. It is opened again when it is needed, which also repairs what a damaged file needs.
    fn close(&mut self, error: &StoreError) -> String {
        self.open = None;
        self.problem = error_with_causes(error);
        self.problem.clone()
    }

    /// Tells people what opening the ledger has found.
    fn report_problems(&self) {
        for problem in self.store.take_problems() {
            tracing::error!("{problem}");
            self.mailbox.notice(self.clock.now(), Severity::Error, problem);
        }
    }

    /// Applies edits in their order, in one transaction.
    pub fn apply(&mut self, edits: Vec<EditRequest>) {
        if edits.is_empty() {
            return;
        }
        let at = CalendarTime::read_of_schedules().utc;
        let applied = self.transaction(|writer, state| {
            edits
                .iter()
                .map(|EditRequest { by, edit, .. }| apply_edit(writer, state, Some(by), edit, at))
                .collect()
        });
        let applied = applied.unwrap_or_else(|reason| {
            let refusal = EditRefusal::Unavailable(texts::edit_not_durable(&reason));
            let refused = |EditRequest { edit, .. }: &EditRequest| Applied {
                id: edit.id,
                outcome: EditOutcome::Refused(refusal.clone()),
                changed: None,
            };
            edits.iter().map(refused).collect::<Vec<_>>()
        });
        for (Applied { id, outcome, changed }, EditRequest { by, address, .. }) in
            applied.into_iter().zip(edits)
        {
            if let (EditOutcome::Refused(refusal), Some(audit)) = (&outcome, self.state_publisher.audit()) {
                audit.refuse(Some(by.clone()), address, audit_texts::EDIT, &refusal_reason(refusal.clone()));
            }
            self.publish(changed);
            self.answer_edit(by.client, id, outcome);
        }
    }

    /// Makes an edit of the site as it is, and applies it.
    pub fn apply_work(&mut self, work: SiteWork) {
        let SiteWork { by, make, done } = work;
        let at = CalendarTime::read_of_schedules().utc;
        let applied = self.transaction(|writer, state| {
            let edit = make(&state.site);
            if edit.changes.is_empty() {
                let outcome = EditOutcome::Applied { revision: state.revision, changes: Vec::new() };
                return Ok(Applied { id: edit.id, outcome, changed: None });
            }
            apply_edit(writer, state, Some(&by), &edit, at)
        });
        match applied {
            Ok(Applied { outcome, changed, .. }) => {
                self.publish(changed);
                done(outcome);
            }
            Err(reason) => {
                let refusal = EditRefusal::Unavailable(texts::edit_not_durable(&reason));
                done(EditOutcome::Refused(refusal));
            }
        }
    }

    /// Writes what the stack wants to be durable.
    ///
    /// # Errors
    /// Why it is not, a clause.
    pub fn write_events(&mut self, events: &[&LedgerEvent]) -> Result<(), String> {
        if events.is_empty() {
            return Ok(());
        }
        let at = CalendarTime::read_of_schedules().utc;
        let (changes, results) = self.transaction(|writer, state| {
            let (mut changes, mut results) = (Vec::new(), Vec::new());
            for event in events {
                match event {
                    LedgerEvent::Site(write) => changes.extend(apply_write(writer, state, write, at)?),
                    event => {
                        let stored = writer.put_event(event, at)?;
                        let (site, config) = (&state.site, AlertsConfig::default());
                        let edit = match (&stored, event) {
                            (Some(result), _) => Some(edit_of_result(site, result, &config)),
                            (None, LedgerEvent::Step(step)) => Some(edit_of_step(site, step, at, &config)),
                            _ => None,
                        };
                        if let Some(edit) = edit.filter(|edit| !edit.changes.is_empty()) {
                            changes.extend(apply_own(writer, state, &edit, at)?);
                        }
                        results.extend(stored);
                    }
                }
            }
            Ok((changes, results))
        })?;
        changes.into_iter().for_each(|changed| self.publish(Some(changed)));
        for result in results {
            let site = self.open.as_ref().map(|open| &open.state.site);
            let report = site.and_then(|site| PointReport::of(&result, site));
            for text in report.iter().flat_map(PointReport::warnings) {
                self.mailbox.notice(self.clock.now(), Severity::Warning, text);
            }
            // Whoever hears of a result finds it in the ledger, and its files on the disk.
            self.state_publisher.publish(Event::ResultStored(result));
        }
        Ok(())
    }

    /// Writes something that is not of the site.
    ///
    /// # Errors
    /// Why it is not durable, a clause.
    pub fn write(&mut self, mut write: LedgerWrite) -> Result<(), String> {
        let at = CalendarTime::read_of_schedules().utc;
        self.transaction(|writer, _| write(writer, at))
    }

    /// Does something with the site in a transaction. If it fails, ledger and site are as before.
    fn transaction<T>(
        &mut self,
        work: impl FnOnce(&LedgerWriter<'_>, &mut SiteState) -> Result<T, StoreError>,
    ) -> Result<T, String> {
        let opened = self.opened();
        let written = match opened {
            Ok(OpenLedger { ledger, state }) => ledger.write(|writer| work(writer, state)),
            Err(reason) => return Err(reason),
        };
        self.report_problems();
        // The site in memory may be ahead of the one on the disk.
        written.map_err(|error| self.close(&error))
    }

    fn publish(&self, changed: Option<SiteChanged>) {
        let Some(changed) = changed else { return };
        // The control loop may have ended already.
        let _ = self.inputs.send(Input::SiteEdited(Box::new(changed.edit.clone())));
        if !self.state_publisher.publish_site_change(changed)
            && let Some(open) = &self.open
        {
            self.state_publisher.publish_site(&open.state);
        }
    }

    fn answer_edit(&self, to: ClientId, id: EditId, outcome: EditOutcome) {
        let event = Event::EditDone(EditDone { id, outcome });
        self.state_publisher.push(CoreMessage::Event { to: Some(to), event });
    }

    /// Lets somebody read the ledger and the site.
    pub fn read(&mut self, read: impl FnOnce(Result<(&Ledger, &Site), String>)) {
        match self.opened() {
            Ok(OpenLedger { ledger, state }) => read(Ok((ledger, &state.site))),
            Err(reason) => read(Err(reason)),
        }
    }

    /// Answers a question of the gateway.
    pub fn answer(&mut self, number: u64, query: Query) {
        let result = match self.opened() {
            Ok(open) => reply(&open.ledger, query).map_err(|error| error_with_causes(&error)),
            Err(reason) => Err(reason),
        };
        let result = result.map_err(|reason| texts::ledger_not_open(&reason));
        self.state_publisher.push(CoreMessage::Reply { number, result });
    }
}

fn reply(ledger: &Ledger, query: Query) -> Result<QueryReply, StoreError> {
    match query {
        Query::Revisions { object, before, limit } => {
            ledger.revisions(object, before, limit).map(QueryReply::Revisions)
        }
        Query::Runs { filter, before, limit } => ledger.runs(&filter, before, limit).map(QueryReply::Runs),
        Query::Run(run) => ledger.run(run).map(|run| QueryReply::Runs(run.into_iter().collect())),
        Query::Steps { run, after, limit } => ledger.steps(run, after, limit).map(QueryReply::Steps),
        Query::Results { run, after, limit } => ledger.results(run, after, limit).map(QueryReply::Results),
        Query::PointResults { point, before, limit } => {
            ledger.point_results(point, before, limit).map(QueryReply::Results)
        }
        // It goes to the thread that compares pictures.
        Query::PictureComparison { .. } => Ok(QueryReply::Results(Vec::new())),
        Query::Slots { before, limit } => ledger.slots(before, limit).map(QueryReply::Slots),
        Query::Audit { before, containing, limit } => {
            ledger.audit(before, &containing, limit).map(QueryReply::Audit)
        }
    }
}

/// Applies an edit of a client, unless it was applied before.
fn apply_edit(
    writer: &LedgerWriter<'_>,
    state: &mut SiteState,
    by: Option<&Principal>,
    edit: &Edit,
    at: Stamp,
) -> Result<Applied, StoreError> {
    let refused =
        |refusal| Ok(Applied { id: edit.id, outcome: EditOutcome::Refused(refusal), changed: None });
    if let Some((revision, changes)) = writer.applied_edit(edit.id)? {
        let outcome = EditOutcome::Applied { revision, changes };
        return Ok(Applied { id: edit.id, outcome, changed: None });
    }
    if let Some(reason) = too_large(state, edit) {
        return refused(EditRefusal::Rejected(reason));
    }
    let errors: Vec<_> = state.site.edit_errors(edit).collect();
    if !errors.is_empty() {
        return refused(EditRefusal::Invalid(errors));
    }
    let changes = match state.site.apply(edit, edit.id) {
        Ok(applied) => applied.revisions,
        Err(error) => return refused(EditRefusal::Invalid(vec![error])),
    };
    state.revision += 1;
    let revision = state.revision;
    writer.put_edit(&EditRecord { revision, edit, changes: &changes, by, at })?;
    let changed = SiteChanged { revision, by: by.map(|by| by.client), edit: edit.clone() };
    let outcome = EditOutcome::Applied { revision, changes };
    Ok(Applied { id: edit.id, outcome, changed: Some(changed) })
}

/// Why an edit is beyond the limits, one sentence.
fn too_large(state: &SiteState, edit: &Edit) -> Option<String> {
    if edit.changes.is_empty() {
        return Some(texts::EDIT_IS_EMPTY.to_owned());
    }
    if edit.changes.len() > MAX_EDIT_CHANGES {
        return Some(texts::edit_too_long(edit.changes.len(), MAX_EDIT_CHANGES));
    }
    let is_new = |change: &&Change| change.base().is_none();
    let objects = state.site.objects().len() + edit.changes.iter().filter(is_new).count();
    if objects > MAX_SITE_OBJECTS {
        return Some(texts::site_full(MAX_SITE_OBJECTS));
    }
    edit.changes.iter().find_map(|change| match change {
        Change::Put { object, .. } if api::encoded_bytes(object) > MAX_OBJECT_BYTES => {
            Some(texts::object_too_large(&object.id().to_string(), MAX_OBJECT_BYTES))
        }
        _ => None,
    })
}

/// Applies what the robot itself changes. Objects that the site cannot hold are left out.
fn apply_write(
    writer: &LedgerWriter<'_>,
    state: &mut SiteState,
    write: &SiteWrite,
    at: Stamp,
) -> Result<Option<SiteChanged>, StoreError> {
    let site = &state.site;
    let put = write
        .put
        .iter()
        .map(|object| Some(Change::Put { base: site.revision(object.id()), object: object.clone() }));
    let removed = write
        .removed
        .iter()
        .map(|object| Some(Change::Remove { base: site.revision(*object)?, object: *object }));
    let changes: Vec<_> = put.chain(removed).flatten().collect();
    if changes.is_empty() {
        return Ok(None);
    }
    // Differs from all others: no two edits of the robot have the same revision and time.
    let id = EditId(Uuid::from_u64_pair(at.nanos() as u64, state.revision + 1));
    apply_own(writer, state, &Edit { id, changes }, at)
}

/// Applies an edit of the platform itself, unless it was applied before.
fn apply_own(
    writer: &LedgerWriter<'_>,
    state: &mut SiteState,
    edit: &Edit,
    at: Stamp,
) -> Result<Option<SiteChanged>, StoreError> {
    let applied = apply_edit(writer, state, None, edit, at)?;
    if let EditOutcome::Refused(refusal) = &applied.outcome {
        tracing::error!("the robot's change of the site was not applied: {refusal:?}");
    }
    Ok(applied.changed)
}
