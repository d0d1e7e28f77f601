//! Beginning of sessions: sign-ins and the first admin.

use super::directory::text_of;
use super::{AccessWorker, audit_texts, texts};
use crate::clock::CalendarTime;
use accounts::{AccountName, check_password, credential_id, hash, new_secret, verify};
use api::access::{AccountRefusal, AccountRefusalKind, AccountReply, FirstAdmin, Secret};
use api::{Caller, Role};
use messages::Principal;
use std::time::Instant;
use store::{AuditEntry, StoredAccount, StoredCredential};
use vocab::ClientId;

pub(super) type Result<T> = std::result::Result<T, AccountRefusal>;

pub(super) fn refused<T>(kind: AccountRefusalKind, reason: impl Into<String>) -> Result<T> {
    Err(AccountRefusal { kind, reason: reason.into() })
}

impl AccessWorker {
    /// Begins a session of an account, if the password is right. A name that does not exist takes as long as a wrong password.
    pub(super) fn sign_in(&mut self, by: &Caller, account: &str, password: &Secret) -> Result<AccountReply> {
        let name = account.parse::<AccountName>().ok();
        let text = name.as_ref().map_or("", AccountName::as_str);
        let is_known = name.is_some() && self.directory.is_known(text, by);
        let now = Instant::now();
        if let Some(wait) = self.throttle.wait(by.address, text, is_known, now) {
            self.failures.0 += 1;
            self.note_failure(by, name.as_ref());
            return refused(AccountRefusalKind::Busy, texts::too_many_failures(wait));
        }
        let stored = self.directory.with_accounts(|accounts| accounts.accounts.get(text).cloned());
        let stored = stored.filter(|account| account.is_enabled);
        let is_right = password.reveal().len() <= self.config.passwords.max_bytes
            && verify(
                password.reveal(),
                stored.as_ref().map(|stored| stored.password.as_str()),
                &self.config.passwords,
            );
        match (stored, &name) {
            (Some(stored), Some(name)) if is_right => self.begin_session(by, name, stored.role, None),
            _ => {
                self.throttle.failed(by.address, text, is_known, now);
                self.failures.0 += 1;
                tracing::warn!(address = ?by.address, "a sign-in failed");
                self.note_failure(by, name.as_ref());
                refused(AccountRefusalKind::NotSignedIn, texts::WRONG_PASSWORD)
            }
        }
    }

    fn note_failure(&mut self, by: &Caller, name: Option<&AccountName>) {
        if self.failures.1.is_some_and(|noted| noted.elapsed() < self.config.failure_note_period) {
            return;
        }
        let more = std::mem::take(&mut self.failures.0) - 1;
        self.failures.1 = Some(Instant::now());
        // A name that is none may be a password in the wrong field.
        let command =
            name.map_or_else(|| audit_texts::SIGN_IN.to_owned(), |name| audit_texts::sign_in_as(name));
        let outcome = audit_texts::refused_and_before(more);
        let entry = AuditEntry { by: None, address: by.address, command, outcome };
        if let Err(refusal) = self.write(move |writer, at| writer.put_audit_entry(&entry, at)) {
            tracing::warn!("{}", refusal.reason);
        }
    }

    /// Notes failures that had no entry of their own.
    pub(super) fn note_failures(&mut self) {
        let (count, noted) = self.failures;
        if count == 0 || noted.is_some_and(|noted| noted.elapsed() < self.config.failure_note_period) {
            return;
        }
        self.failures = (0, Some(Instant::now()));
        let outcome = audit_texts::refused_times(count);
        let entry = AuditEntry { by: None, address: None, command: audit_texts::SIGN_IN.to_owned(), outcome };
        if let Err(refusal) = self.write(move |writer, at| writer.put_audit_entry(&entry, at)) {
            tracing::warn!("{}", refusal.reason);
        }
    }

    /// Makes the first admin, and begins a session. The link works once.
    pub(super) fn make_first_admin(&mut self, by: &Caller, first: &FirstAdmin) -> Result<AccountReply> {
        let now = Instant::now();
        if let Some(wait) = self.throttle.wait(by.address, "", false, now) {
            return refused(AccountRefusalKind::Busy, texts::too_many_failures(wait));
        }
        if !self.link.is_of_link(&first.link) {
            self.throttle.failed(by.address, "", false, now);
            return refused(AccountRefusalKind::Forbidden, texts::WRONG_LINK);
        }
        let (name, password) = self.new_password(&first.account, &first.password)?;
        let at = CalendarTime::read().utc;
        let account =
            StoredAccount { role: Role::Admin, password, is_enabled: true, created: at, changed: at };
        self.begin_session(by, &name, Role::Admin, Some(account))
    }

    /// A name and a hashed password.
    pub(super) fn new_password(&self, account: &str, password: &Secret) -> Result<(AccountName, String)> {
        let invalid = |error: String| AccountRefusal {
            kind: AccountRefusalKind::Invalid,
            reason: texts::not_acceptable(&error),
        };
        let name: AccountName =
            account.parse().map_err(|error: accounts::NameError| invalid(error.to_string()))?;
        let config = &self.config.passwords;
        check_password(&name, password.reveal(), config).map_err(|error| invalid(error.to_string()))?;
        let hashed = hash(password.reveal(), config).map_err(|error| invalid(error.to_string()))?;
        Ok((name, hashed))
    }

    /// Begins a session, after its account was made where it is new. Beyond the limit the sessions that were used least lately end.
    fn begin_session(
        &mut self,
        by: &Caller,
        name: &AccountName,
        role: Role,
        new: Option<StoredAccount>,
    ) -> Result<AccountReply> {
        let unavailable = |reason: String| AccountRefusal { kind: AccountRefusalKind::Unavailable, reason };
        let secret =
            new_secret().map_err(|error| unavailable(texts::accounts_not_written(&error.to_string())))?;
        let id = credential_id(secret.reveal());
        let created = CalendarTime::read().utc;
        let expires = created + self.config.max_session;
        let address = text_of(by.address);
        let session = StoredCredential {
            owner: name.to_string(),
            token_role: None,
            created,
            used: created,
            expires,
            ended: None,
            address,
        };
        let surplus = self.surplus_sessions(name, by, created);
        let principal = principal(by.client, name.as_str(), role);
        let command =
            if new.is_some() { audit_texts::make_first_admin(name) } else { audit_texts::SIGN_IN.to_owned() };
        let entry = AuditEntry {
            by: Some(principal),
            address: by.address,
            command,
            outcome: audit_texts::DONE.to_owned(),
        };
        let owner = name.to_string();
        self.write(move |writer, at| {
            if let Some(account) = &new {
                writer.put_account(&owner, account)?;
            }
            writer.put_credential(id, &session)?;
            surplus.iter().try_for_each(|(id, ended)| writer.put_credential(*id, ended))?;
            writer.put_audit_entry(&entry, at)
        })?;
        Ok(AccountReply::SignedIn { secret, account: name.to_string(), role, expires })
    }

    /// Sessions of an account that end because a further one begins: the browser's own old one, and those beyond the limit.
    fn surplus_sessions(
        &self,
        name: &AccountName,
        by: &Caller,
        now: vocab::Stamp,
    ) -> Vec<(api::CredentialId, StoredCredential)> {
        self.directory.with_accounts(|accounts| {
            let of_account = accounts.credentials.iter().filter(|(_, credential)| {
                credential.token_role.is_none()
                    && credential.owner == name.as_str()
                    && credential.ended.is_none()
            });
            let mut open: Vec<_> = of_account.collect();
            open.sort_by_key(|(id, credential)| (Some(**id) != by.credential, credential.used));
            let is_own = open.first().is_some_and(|(id, _)| Some(**id) == by.credential);
            let count = (open.len() + 1).saturating_sub(self.config.max_sessions).max(usize::from(is_own));
            let ended = |(id, credential): &(&api::CredentialId, &StoredCredential)| {
                (**id, StoredCredential { ended: Some(now), ..(*credential).clone() })
            };
            open.iter().take(count).map(ended).collect()
        })
    }
}

/// Somebody who has signed in.
fn principal(client: ClientId, account: &str, role: Role) -> Principal {
    Principal { client, account: Some(account.to_owned()), role }
}
