//! The thread `accounts`: reads the ledger for changes, publishes who may use the platform, and carries out requests. Hashing takes 50 ms and more, so it has the
//! lowest priority, and nothing waits for it but those who sign in.

use super::first_admin::FirstAdminLink;
use super::inbox::{AccountInbox, Closed, WaitingAccountRequest};
use super::{AccessDirectory, AccessMode, AccountsConfig};
use super::{audit_texts, texts};
use crate::clock::CalendarTime;
use crate::ledger::{LedgerInbox, LedgerWork};
use crate::state_publisher::StatePublisher;
use accounts::SignInThrottle;
use api::CoreMessage;
use api::access::{AccessState, AccountRefusal, AccountRefusalKind, AccountRequest};
use ports::error_with_causes;
use std::sync::Arc;
use std::time::Instant;
use store::{AccountReader, LedgerWriter, Store, StoreError};
use vocab::Stamp;
use watchdog::Heartbeat;

/// The thread.
pub struct AccessWorker {
    pub(super) config: AccountsConfig,
    pub(super) directory: Arc<AccessDirectory>,
    pub(super) throttle: SignInThrottle,
    inbox: Arc<AccountInbox>,
    ledger: Arc<LedgerInbox>,
    state_publisher: Arc<StatePublisher>,
    reader: AccountReader,
    pub(super) link: FirstAdminLink,
    published: Option<AccessState>,
    /// Failed attempts to sign in of which the audit log has no entry yet, and since when.
    pub(super) failures: (u32, Option<Instant>),
    /// When long-ended sessions are looked for next.
    cleaned: Option<Instant>,
}

impl AccessWorker {
    /// Reads accounts from the ledger of this store.
    pub fn new(
        config: AccountsConfig,
        directory: Arc<AccessDirectory>,
        inbox: Arc<AccountInbox>,
        ledger: Arc<LedgerInbox>,
        state_publisher: Arc<StatePublisher>,
        store: &Store,
    ) -> Self {
        Self {
            config,
            directory,
            throttle: SignInThrottle::new(config.throttle),
            inbox,
            ledger,
            state_publisher,
            reader: AccountReader::new(&store.dir().ledger()),
            link: FirstAdminLink::new(store.dir().first_admin_link()),
            published: None,
            failures: (0, None),
            cleaned: None,
        }
    }

    /// Works until the queue is closed.
    pub fn run(mut self, heartbeat: &Heartbeat) {
        // On Linux this is the priority of this thread only. If the system refuses, passwords are hashed with normal priority.
        let _ = rustix::process::nice(10);
        loop {
            self.refresh();
            heartbeat.beat();
            if let Some(audit) = self.state_publisher.audit() {
                audit.flush(Instant::now());
            }
            match self.inbox.next(self.config.poll_period) {
                Ok(Some(WaitingAccountRequest { number, by, request })) => {
                    let asked = audit_texts::request(&request);
                    // Failed sign-ins have entries of their own.
                    let is_sign_in = matches!(request, AccountRequest::SignIn { .. });
                    let result = self.handle(&by, request);
                    if let (Err(refusal), false, Some(audit)) =
                        (&result, is_sign_in, self.state_publisher.audit())
                    {
                        let principal = self.directory.principal(&by).ok();
                        audit.refuse(principal, by.address, &asked, &refusal.reason);
                    }
                    // Whoever has signed in may use the answer at once.
                    self.refresh();
                    self.state_publisher.push(CoreMessage::AccountReply { number, result });
                }
                Ok(None) => self.keep_house(),
                Err(Closed) => return,
            }
        }
    }

    /// Publishes who may use the platform, if that has changed.
    pub(super) fn refresh(&mut self) {
        match self.reader.read_if_changed() {
            Ok(Some(accounts)) => self.directory.set_accounts(accounts),
            Ok(None) => {}
            // What was read last stays: a disk that fails locks nobody out.
            Err(error) => tracing::error!("{}", texts::accounts_not_read(&error_with_causes(&error))),
        }
        let state = self.directory.refresh(self.config.session_idle, CalendarTime::read().utc);
        if self.published.as_ref() != Some(&state) {
            if let Err(error) = self.link.set(state.needs_first_admin) {
                tracing::error!("{}", texts::first_admin_link_not_written(&error));
            }
            self.published = Some(state.clone());
            self.state_publisher.publish_access(state);
        }
    }

    /// Notes in the ledger what was used, and removes what ended long ago.
    fn keep_house(&mut self) {
        if self.directory.mode() == AccessMode::Demo {
            return;
        }
        self.note_failures();
        let mut rows = self.directory.uses_to_note(self.config.note_period);
        let mut removed = Vec::new();
        if self.cleaned.is_none_or(|cleaned| cleaned.elapsed() >= self.config.cleaning_period) {
            self.cleaned = Some(Instant::now());
            let now = CalendarTime::read().utc;
            let is_old = |at: Stamp| now - at >= self.config.known_browser;
            removed = self.directory.with_accounts(|accounts| {
                let old = accounts
                    .credentials
                    .iter()
                    .filter(|(_, credential)| is_old(credential.ended.unwrap_or(credential.expires)));
                old.map(|(id, _)| *id).collect()
            });
        }
        if rows.is_empty() && removed.is_empty() {
            return;
        }
        let written = self.write(move |writer, _| {
            rows.drain(..).try_for_each(|(id, credential)| writer.put_credential(id, &credential))?;
            removed.drain(..).try_for_each(|id| writer.remove_credential(id))
        });
        if let Err(refusal) = written {
            tracing::warn!("{}", refusal.reason);
        }
    }

    /// Writes to the ledger, and waits until it is durable.
    ///
    /// # Errors
    /// When it is not.
    pub(super) fn write(
        &self,
        write: impl FnMut(&LedgerWriter<'_>, Stamp) -> Result<(), StoreError> + Send + 'static,
    ) -> Result<(), AccountRefusal> {
        let (done, written) = crossbeam_channel::bounded(1);
        let failed = |reason: &str| AccountRefusal {
            kind: AccountRefusalKind::Unavailable,
            reason: texts::accounts_not_written(reason),
        };
        self.ledger.write(LedgerWork { write: Box::new(write), done }).map_err(failed)?;
        match written.recv_timeout(self.config.write_timeout) {
            Ok(Ok(())) => Ok(()),
            Ok(Err(reason)) => Err(failed(&reason)),
            Err(_) => Err(failed(crate::texts::LEDGER_BUSY)),
        }
    }
}
