//! Samples of accounts, sessions and tokens.

use super::{CLIENT, NOW, name};
use api::access::*;
use api::{Caller, CredentialId};
use std::net::{IpAddr, Ipv4Addr};

pub const CREDENTIAL: CredentialId = CredentialId([7; 32]);

pub fn caller() -> Caller {
    let address = Some(IpAddr::V4(Ipv4Addr::new(192, 0, 2, 1)));
    Caller { client: CLIENT, credential: Some(CREDENTIAL), address }
}

pub fn you() -> ClientIdentity {
    ClientIdentity { client: CLIENT, account: Some(name()), role: Role::Operator, is_demo: true }
}

fn secret() -> Secret {
    Secret::new("secret")
}

pub fn state() -> AccessState {
    let grant = |role| Grant { credential: CREDENTIAL, account: name(), role, expires: NOW };
    AccessState { needs_first_admin: true, grants: Role::ALL.map(grant).to_vec() }
}

pub fn requests() -> Vec<AccountRequest> {
    let account = name;
    let change = |change| AccountRequest::ChangeAccount { account: name(), change };
    vec![
        AccountRequest::SignIn { account: account(), password: secret() },
        AccountRequest::SignOut,
        AccountRequest::MakeFirstAdmin(FirstAdmin { link: secret(), account: account(), password: secret() }),
        AccountRequest::ChangeOwnPassword { current: secret(), new: secret() },
        AccountRequest::ListAccounts,
        AccountRequest::AddAccount { account: account(), role: Role::Operator, password: secret() },
        change(AccountChange::Role(Role::Admin)),
        change(AccountChange::Password(secret())),
        change(AccountChange::IsEnabled(false)),
        change(AccountChange::EndSessions),
        AccountRequest::RemoveAccount { account: account() },
        AccountRequest::ListTokens,
        AccountRequest::AddToken { name: name(), role: Role::Viewer, days: 90 },
        AccountRequest::RevokeToken(CREDENTIAL),
    ]
}

pub fn results() -> Vec<Result<AccountReply, AccountRefusal>> {
    let role = Role::Operator;
    let account = AccountSummary {
        account: name(),
        role,
        is_enabled: true,
        sessions: 2,
        created: NOW,
        last_used: Some(NOW),
    };
    let token =
        TokenSummary { id: CREDENTIAL, name: name(), role, created: NOW, expires: NOW, last_used: Some(NOW) };
    let kinds = [
        AccountRefusalKind::NotSignedIn,
        AccountRefusalKind::Forbidden,
        AccountRefusalKind::NotFound,
        AccountRefusalKind::Conflict,
        AccountRefusalKind::Invalid,
        AccountRefusalKind::Busy,
        AccountRefusalKind::Unavailable,
    ];
    let replies = [
        AccountReply::Done,
        AccountReply::SignedIn { secret: secret(), account: name(), role, expires: NOW },
        AccountReply::Accounts(vec![account]),
        AccountReply::Tokens(vec![token.clone()]),
        AccountReply::Token { secret: secret(), token },
    ];
    let refusals = kinds.map(|kind| AccountRefusal { kind, reason: name() });
    replies.into_iter().map(Ok).chain(refusals.into_iter().map(Err)).collect()
}
