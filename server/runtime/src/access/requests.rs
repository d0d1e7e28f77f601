//! Requests about accounts and tokens.

use super::directory::text_of;
use super::sessions::{Result, refused};
use super::{AccessMode, AccessWorker, audit_texts, texts};
use crate::clock::CalendarTime;
use accounts::{AccountName, credential_id, new_secret, verify};
use api::access::{
    AccountChange, AccountRefusal, AccountRefusalKind, AccountReply, AccountRequest, AccountSummary,
    MAX_TOKEN_DAYS, Secret, TokenSummary, account_privilege,
};
use api::{Caller, CredentialId, Privilege, Role};
use messages::Principal;
use store::{Accounts, AuditEntry, LedgerWriter, StoreError, StoredAccount, StoredCredential};
use vocab::{Span, Stamp};

const DAY: Span = Span::from_millis(24 * 3_600_000);

/// A change of accounts, for the ledger.
type Write = Box<dyn Fn(&LedgerWriter<'_>, Stamp) -> std::result::Result<(), StoreError> + Send>;

impl AccessWorker {
    /// Carries out a request, if whoever asks may ask it.
    pub(super) fn handle(&mut self, by: &Caller, request: AccountRequest) -> Result<AccountReply> {
        if self.directory.mode() == AccessMode::Demo {
            return refused(AccountRefusalKind::Conflict, texts::NO_ACCOUNTS_IN_DEMO);
        }
        match request {
            AccountRequest::SignIn { account, password } => self.sign_in(by, &account, &password),
            AccountRequest::MakeFirstAdmin(first) => self.make_first_admin(by, &first),
            request => {
                let principal = self.admit(by, account_privilege(&request))?;
                self.handle_for(by, &principal, request)
            }
        }
    }

    fn admit(&self, by: &Caller, privilege: Privilege) -> Result<Principal> {
        let kind = match self.directory.principal(by) {
            Ok(_) => AccountRefusalKind::Forbidden,
            Err(_) => AccountRefusalKind::NotSignedIn,
        };
        self.directory.admit(by, privilege).map_err(|reason| AccountRefusal { kind, reason })
    }

    fn handle_for(
        &mut self,
        by: &Caller,
        principal: &Principal,
        request: AccountRequest,
    ) -> Result<AccountReply> {
        let now = CalendarTime::read().utc;
        let (command, write): (String, Write) = match request {
            // Handled by the caller.
            AccountRequest::SignIn { .. } | AccountRequest::MakeFirstAdmin(_) => {
                return Ok(AccountReply::Done);
            }
            AccountRequest::ListAccounts => return Ok(AccountReply::Accounts(self.account_list())),
            AccountRequest::ListTokens => return Ok(AccountReply::Tokens(self.token_list(now))),
            AccountRequest::SignOut => {
                let ended = self.ended(now, |id, _| Some(id) == by.credential);
                ("sign out".to_owned(), put_credentials(ended))
            }
            AccountRequest::ChangeOwnPassword { current, new } => {
                self.change_own_password(by, principal, &current, &new, now)?
            }
            AccountRequest::AddAccount { account, role, password } => {
                self.add_account(&account, role, &password, now)?
            }
            AccountRequest::ChangeAccount { account, change } => {
                self.change_account(&account, change, now)?
            }
            AccountRequest::RemoveAccount { account } => self.remove_account(&account)?,
            AccountRequest::AddToken { name, role, days } => {
                return self.add_token(by, principal, &name, role, days, now);
            }
            AccountRequest::RevokeToken(token) => {
                let ended = self.ended(now, |id, credential| id == token && credential.token_role.is_some());
                let Some((_, credential)) = ended.first() else {
                    return refused(AccountRefusalKind::NotFound, texts::NO_TOKEN);
                };
                (audit_texts::end_token(&credential.owner), put_credentials(ended))
            }
        };
        self.write_with_audit(by, principal, command, write)?;
        Ok(AccountReply::Done)
    }

    fn write_with_audit(
        &self,
        by: &Caller,
        principal: &Principal,
        command: String,
        write: Write,
    ) -> Result<()> {
        let outcome = audit_texts::DONE.to_owned();
        let entry = AuditEntry { by: Some(principal.clone()), address: by.address, command, outcome };
        self.write(move |writer, at| {
            write(writer, at)?;
            writer.put_audit_entry(&entry, at)
        })
    }

    fn account(&self, account: &str) -> Result<(AccountName, StoredAccount)> {
        let name = account.parse::<AccountName>().ok();
        let found = name.and_then(|name| {
            let stored = self.directory.with_accounts(|all| all.accounts.get(name.as_str()).cloned())?;
            Some((name, stored))
        });
        found.map_or_else(|| refused(AccountRefusalKind::NotFound, texts::NO_ACCOUNT), Ok)
    }

    /// The sessions and tokens that `is_meant` names and that have not ended, ended now.
    fn ended(
        &self,
        now: Stamp,
        is_meant: impl Fn(CredentialId, &StoredCredential) -> bool,
    ) -> Vec<(CredentialId, StoredCredential)> {
        self.directory.with_accounts(|accounts| {
            let open = accounts.credentials.iter().filter(|(_, credential)| credential.ended.is_none());
            open.filter(|(id, credential)| is_meant(**id, credential))
                .map(|(id, credential)| (*id, StoredCredential { ended: Some(now), ..credential.clone() }))
                .collect()
        })
    }

    fn ended_sessions_of(&self, name: &AccountName, now: Stamp) -> Vec<(CredentialId, StoredCredential)> {
        self.ended(now, |_, credential| credential.token_role.is_none() && credential.owner == name.as_str())
    }

    fn change_own_password(
        &mut self,
        by: &Caller,
        principal: &Principal,
        current: &Secret,
        new: &Secret,
        now: Stamp,
    ) -> Result<(String, Write)> {
        let (name, account) = self.account(principal.account.as_deref().unwrap_or_default())?;
        if !verify(current.reveal(), Some(&account.password), &self.config.passwords) {
            return refused(AccountRefusalKind::Forbidden, texts::WRONG_CURRENT_PASSWORD);
        }
        let (_, password) = self.new_password(name.as_str(), new)?;
        let mut sessions = self.ended_sessions_of(&name, now);
        sessions.retain(|(id, _)| Some(*id) != by.credential);
        let changed = StoredAccount { password, changed: now, ..account };
        Ok((audit_texts::CHANGE_OWN_PASSWORD.to_owned(), put_both(name, changed, sessions)))
    }

    fn add_account(
        &self,
        account: &str,
        role: Role,
        password: &Secret,
        now: Stamp,
    ) -> Result<(String, Write)> {
        let (name, password) = self.new_password(account, password)?;
        let (is_taken, count) = self.directory.with_accounts(|accounts| {
            (accounts.accounts.contains_key(name.as_str()), accounts.accounts.len())
        });
        if is_taken {
            return refused(AccountRefusalKind::Conflict, texts::account_exists(name.as_str()));
        }
        if count >= self.config.max_accounts {
            return refused(AccountRefusalKind::Conflict, texts::too_many_accounts(self.config.max_accounts));
        }
        let account = StoredAccount { role, password, is_enabled: true, created: now, changed: now };
        Ok((audit_texts::add_account(&name, &role), put_both(name, account, Vec::new())))
    }

    fn change_account(&self, account: &str, change: AccountChange, now: Stamp) -> Result<(String, Write)> {
        let (name, account) = self.account(account)?;
        let mut changed = StoredAccount { changed: now, ..account.clone() };
        let mut sessions = self.ended_sessions_of(&name, now);
        let command = match change {
            AccountChange::Role(role) => {
                changed.role = role;
                sessions.clear();
                audit_texts::change_account(&name, &role)
            }
            AccountChange::Password(password) => {
                changed.password = self.new_password(name.as_str(), &password)?.1;
                audit_texts::reset_password(&name)
            }
            AccountChange::IsEnabled(is_enabled) => {
                changed.is_enabled = is_enabled;
                audit_texts::enable_account(&name, is_enabled)
            }
            AccountChange::EndSessions => audit_texts::end_sessions(&name),
        };
        if is_admin(&account) && !is_admin(&changed) {
            self.check_other_admin(&name)?;
        }
        Ok((command, put_both(name, changed, sessions)))
    }

    fn remove_account(&self, account: &str) -> Result<(String, Write)> {
        let (name, account) = self.account(account)?;
        if is_admin(&account) {
            self.check_other_admin(&name)?;
        }
        let command = audit_texts::remove_account(&name);
        Ok((command, Box::new(move |writer, _| writer.remove_account(name.as_str()))))
    }

    /// Fails if nobody else is an admin: there must be one who can make others.
    fn check_other_admin(&self, name: &AccountName) -> Result<()> {
        let has_other = self.directory.with_accounts(|accounts| {
            accounts.accounts.iter().any(|(other, account)| other != name.as_str() && is_admin(account))
        });
        if has_other { Ok(()) } else { refused(AccountRefusalKind::Conflict, texts::LAST_ADMIN) }
    }

    fn add_token(
        &self,
        by: &Caller,
        principal: &Principal,
        name: &str,
        role: Role,
        days: u32,
        now: Stamp,
    ) -> Result<AccountReply> {
        let name: String = vocab::legible(name.trim(), self.config.max_token_name_chars);
        if name.is_empty() || !(1..=MAX_TOKEN_DAYS).contains(&days) {
            return refused(AccountRefusalKind::Invalid, texts::token_not_acceptable(MAX_TOKEN_DAYS));
        }
        if self.token_list(now).len() >= self.config.max_accounts {
            return refused(AccountRefusalKind::Conflict, texts::too_many_accounts(self.config.max_accounts));
        }
        let unavailable = |error: accounts::RandomError| AccountRefusal {
            kind: AccountRefusalKind::Unavailable,
            reason: texts::accounts_not_written(&error.to_string()),
        };
        let secret = new_secret().map_err(unavailable)?;
        let id = credential_id(secret.reveal());
        let token = StoredCredential {
            owner: name.clone(),
            token_role: Some(role),
            created: now,
            used: now,
            expires: now + Span::from_nanos(DAY.nanos() * i64::from(days)),
            ended: None,
            address: text_of(by.address),
        };
        let summary = token_summary(id, &token, None);
        let command = audit_texts::add_token(&name, &role, days);
        self.write_with_audit(by, principal, command, put_credentials(vec![(id, token)]))?;
        Ok(AccountReply::Token { secret, token: summary })
    }

    fn account_list(&self) -> Vec<AccountSummary> {
        let accounts = self.directory.with_accounts(Accounts::clone);
        let now = CalendarTime::read().utc;
        let summary = |(name, account): (&String, &StoredAccount)| {
            let sessions = accounts
                .credentials
                .iter()
                .filter(|(_, credential)| credential.token_role.is_none() && credential.owner == *name);
            let last_used = sessions.clone().filter_map(|(id, _)| self.directory.last_used(*id)).max();
            let is_open =
                |credential: &StoredCredential| credential.ended.is_none() && now < credential.expires;
            AccountSummary {
                account: name.clone(),
                role: account.role,
                is_enabled: account.is_enabled,
                sessions: sessions.filter(|(_, credential)| is_open(credential)).count() as u32,
                created: account.created,
                last_used,
            }
        };
        accounts.accounts.iter().map(summary).collect()
    }

    fn token_list(&self, now: Stamp) -> Vec<TokenSummary> {
        let accounts = self.directory.with_accounts(Accounts::clone);
        let is_valid = |credential: &StoredCredential| credential.ended.is_none() && now < credential.expires;
        let tokens = accounts.credentials.iter().filter(|(_, credential)| is_valid(credential));
        tokens
            .filter(|(_, credential)| credential.token_role.is_some())
            .map(|(id, credential)| {
                let used = self.directory.last_used(*id).filter(|used| *used > credential.created);
                token_summary(*id, credential, used)
            })
            .collect()
    }
}

fn is_admin(account: &StoredAccount) -> bool {
    account.role == Role::Admin && account.is_enabled
}

fn token_summary(id: CredentialId, token: &StoredCredential, last_used: Option<Stamp>) -> TokenSummary {
    TokenSummary {
        id,
        name: token.owner.clone(),
        role: token.token_role.unwrap_or(Role::Viewer),
        created: token.created,
        expires: token.expires,
        last_used,
    }
}

fn put_credentials(credentials: Vec<(CredentialId, StoredCredential)>) -> Write {
    Box::new(move |writer, _| {
        credentials.iter().try_for_each(|(id, credential)| writer.put_credential(*id, credential))
    })
}

fn put_both(
    name: AccountName,
    account: StoredAccount,
    credentials: Vec<(CredentialId, StoredCredential)>,
) -> Write {
    Box::new(move |writer, _| {
        writer.put_account(name.as_str(), &account)?;
        credentials.iter().try_for_each(|(id, credential)| writer.put_credential(*id, credential))
    })
}
