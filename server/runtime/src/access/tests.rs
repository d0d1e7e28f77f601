//! Accounts from the first admin to revocation, with a ledger on the disk.

use super::*;
use crate::ledger::{LedgerConfig, LedgerQueue, LedgerWorker, SiteKeeper};
use crate::mailbox::Mailbox;
use crate::state_publisher::StatePublisher;
use accounts::credential_id;
use api::access::{
    AccountChange, AccountRefusalKind, AccountReply, AccountRequest, FirstAdmin, Secret, command_privilege,
};
use api::{Caller, Command, CredentialId, Role};
use std::net::IpAddr;
use std::path::Path;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use store::Store;
use uuid::Uuid;
use vocab::{ClientId, MapId};
use watchdog::Watchdog;

const PASSWORD: &str = "correct horse battery";
const OTHER_PASSWORD: &str = "many rivers to cross";

/// A ledger with its thread, and the worker under test, which the test itself drives.
struct Bench {
    dir: tempfile::TempDir,
    worker: AccessWorker,
    directory: Arc<AccessDirectory>,
    queue: Option<LedgerQueue>,
    ledger: Option<JoinHandle<()>>,
}

impl Bench {
    fn new() -> Self {
        let passwords = PasswordConfig { memory_kib: 64, passes: 1, ..PasswordConfig::default() };
        Self::with(AccountsConfig { passwords, ..AccountsConfig::default() }, AccessMode::SignIn)
    }

    fn with(config: AccountsConfig, mode: AccessMode) -> Self {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Arc::new(Store::open(dir.path()).expect("opens"));
        let (mailbox, state_publisher, clock) =
            (Arc::<Mailbox>::default(), Arc::<StatePublisher>::default(), Arc::default());
        let (inputs, taken) = crossbeam_channel::unbounded();
        // Nobody reads them.
        drop(taken);
        let site = SiteKeeper::open(
            Arc::clone(&store),
            Arc::clone(&state_publisher),
            inputs.clone(),
            Arc::clone(&mailbox),
            Arc::clone(&clock),
            LedgerConfig { retry_period: Duration::ZERO, ..LedgerConfig::default() },
        );
        let (queue, inbox) = LedgerQueue::new(LedgerConfig::default());
        let directory = Arc::new(AccessDirectory::new(mode));
        let accounts = Arc::new(AccountInbox::new(config, Arc::clone(&directory)));
        let mut worker = AccessWorker::new(
            config,
            Arc::clone(&directory),
            accounts,
            Arc::clone(&inbox),
            Arc::clone(&state_publisher),
            &store,
        );
        let ledger = LedgerWorker { store, inbox, site, inputs, mailbox, clock };
        let ledger = Watchdog::default()
            .spawn("ledger", Duration::from_secs(60), move |beat| ledger.run(beat))
            .expect("a thread");
        worker.refresh();
        Self { dir, worker, directory, queue: Some(queue), ledger: Some(ledger) }
    }

    fn ask(&mut self, by: &Caller, request: AccountRequest) -> Result<AccountReply, AccountRefusalKind> {
        let result = self.worker.handle(by, request);
        self.worker.refresh();
        result.map_err(|refusal| {
            assert!(refusal.reason.ends_with('.'), "a sentence: {refusal:?}");
            refusal.kind
        })
    }

    /// Makes the first admin, and returns who signed in.
    fn first_admin(&mut self) -> Caller {
        let link = link(self.dir.path()).expect("a link");
        let first = FirstAdmin { link, account: "ada".into(), password: Secret::new(PASSWORD) };
        let reply = self.ask(&stranger(1), AccountRequest::MakeFirstAdmin(first)).expect("made");
        caller(1, &reply)
    }

    fn sign_in(&mut self, by: &Caller, account: &str, password: &str) -> Result<Caller, AccountRefusalKind> {
        let request = AccountRequest::SignIn { account: account.into(), password: Secret::new(password) };
        self.ask(by, request).map(|reply| Caller { address: by.address, ..caller(9, &reply) })
    }

    fn role(&self, by: &Caller) -> Option<Role> {
        self.directory.principal(by).ok().map(|principal| principal.role)
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        drop(self.queue.take());
        self.ledger.take().expect("a thread").join().expect("ends");
    }
}

fn link(dir: &Path) -> Option<Secret> {
    let text = std::fs::read_to_string(ports::DataDir::new(dir).first_admin_link()).ok()?;
    Some(Secret::new(text.trim()))
}

fn address(last: u8) -> Option<IpAddr> {
    Some([192, 0, 2, last].into())
}

fn stranger(last: u8) -> Caller {
    Caller { address: address(last), ..ClientId(Uuid::from_u128(last.into())).into() }
}

/// Who has the session or token of this answer.
fn caller(last: u8, reply: &AccountReply) -> Caller {
    let (AccountReply::SignedIn { secret, .. } | AccountReply::Token { secret, .. }) = reply else {
        panic!("no secret in {reply:?}")
    };
    Caller { credential: Some(credential_id(secret.reveal())), ..stranger(last) }
}

fn add(account: &str, role: Role) -> AccountRequest {
    AccountRequest::AddAccount { account: account.into(), role, password: Secret::new(OTHER_PASSWORD) }
}

#[test]
fn the_link_makes_the_first_admin_once() {
    let mut bench = Bench::new();
    let old = link(bench.dir.path()).expect("a link");
    let wrong = FirstAdmin { link: Secret::new("0"), account: "eve".into(), password: Secret::new(PASSWORD) };
    let refused = bench.ask(&stranger(1), AccountRequest::MakeFirstAdmin(wrong));
    assert_eq!(refused, Err(AccountRefusalKind::Forbidden));
    let ada = bench.first_admin();
    assert_eq!(bench.role(&ada), Some(Role::Admin));
    assert_eq!(link(bench.dir.path()), None, "it has done its work");
    let again = FirstAdmin { link: old, account: "eve".into(), password: Secret::new(PASSWORD) };
    let refused = bench.ask(&stranger(2), AccountRequest::MakeFirstAdmin(again));
    assert_eq!(refused, Err(AccountRefusalKind::Forbidden));
}

#[test]
fn an_account_signs_in_and_its_session_ends_when_it_is_changed() {
    let mut bench = Bench::new();
    let ada = bench.first_admin();
    bench.ask(&ada, add("bob", Role::Operator)).expect("made");
    assert_eq!(bench.ask(&ada, add("Bob", Role::Viewer)), Err(AccountRefusalKind::Conflict));
    assert_eq!(
        bench.sign_in(&stranger(2), "bob", "wrong horse battery"),
        Err(AccountRefusalKind::NotSignedIn)
    );
    let bob = bench.sign_in(&stranger(2), "BOB", OTHER_PASSWORD).expect("signed in");
    assert_eq!(bench.role(&bob), Some(Role::Operator));
    assert_eq!(bench.ask(&bob, add("eve", Role::Admin)), Err(AccountRefusalKind::Forbidden));

    let change = |change| AccountRequest::ChangeAccount { account: "bob".into(), change };
    bench.ask(&ada, change(AccountChange::Role(Role::Viewer))).expect("changed");
    assert_eq!(bench.role(&bob), Some(Role::Viewer), "at once");
    bench.ask(&ada, change(AccountChange::IsEnabled(false))).expect("changed");
    assert_eq!(bench.role(&bob), None);
    assert_eq!(bench.sign_in(&stranger(2), "bob", OTHER_PASSWORD), Err(AccountRefusalKind::NotSignedIn));
    bench.ask(&ada, change(AccountChange::IsEnabled(true))).expect("changed");
    assert_eq!(bench.role(&bob), None, "a session that has ended stays ended");
    let bob = bench.sign_in(&bob, "bob", OTHER_PASSWORD).expect("signed in");
    bench.ask(&bob, AccountRequest::SignOut).expect("signed out");
    assert_eq!(bench.role(&bob), None);
    bench.ask(&ada, AccountRequest::RemoveAccount { account: "bob".into() }).expect("removed");
    assert_eq!(bench.sign_in(&stranger(2), "bob", OTHER_PASSWORD), Err(AccountRefusalKind::NotSignedIn));
}

#[test]
fn there_is_always_an_admin() {
    let mut bench = Bench::new();
    let ada = bench.first_admin();
    let remove = AccountRequest::RemoveAccount { account: "ada".into() };
    let change = |change| AccountRequest::ChangeAccount { account: "ada".into(), change };
    let demote = change(AccountChange::Role(Role::Operator));
    let disable = change(AccountChange::IsEnabled(false));
    for request in [&remove, &demote, &disable] {
        assert_eq!(bench.ask(&ada, request.clone()), Err(AccountRefusalKind::Conflict));
    }
    bench.ask(&ada, add("bob", Role::Admin)).expect("made");
    bench.ask(&ada, remove).expect("there is another one");
    assert_eq!(bench.role(&ada), None);
}

#[test]
fn a_new_password_ends_the_other_sessions() {
    let mut bench = Bench::new();
    let ada = bench.first_admin();
    let other = bench.sign_in(&stranger(3), "ada", PASSWORD).expect("signed in");
    let change = |current: &str| AccountRequest::ChangeOwnPassword {
        current: Secret::new(current),
        new: Secret::new(OTHER_PASSWORD),
    };
    assert_eq!(bench.ask(&ada, change("wrong horse battery")), Err(AccountRefusalKind::Forbidden));
    bench.ask(&ada, change(PASSWORD)).expect("changed");
    assert_eq!((bench.role(&ada), bench.role(&other)), (Some(Role::Admin), None));
    assert!(bench.sign_in(&stranger(3), "ada", PASSWORD).is_err());
    assert!(bench.sign_in(&stranger(3), "ada", OTHER_PASSWORD).is_ok());
}

#[test]
fn a_browser_that_signs_in_again_gets_a_new_session_and_loses_the_old_one() {
    let mut bench = Bench::new();
    let first = bench.first_admin();
    let second = bench.sign_in(&first, "ada", PASSWORD).expect("signed in");
    assert_ne!(first.credential, second.credential, "a session that was planted is worth nothing");
    assert_eq!((bench.role(&first), bench.role(&second)), (None, Some(Role::Admin)));
}

#[test]
fn a_token_does_what_its_role_may_until_it_ends() {
    let mut bench = Bench::new();
    let ada = bench.first_admin();
    let token = |name: &str, days| AccountRequest::AddToken { name: name.into(), role: Role::Viewer, days };
    for (name, days) in [("", 1), ("x", 0), ("x", 367)] {
        assert_eq!(bench.ask(&ada, token(name, days)), Err(AccountRefusalKind::Invalid));
    }
    let reply = bench.ask(&ada, token("historian", 90)).expect("made");
    let AccountReply::Token { token: summary, .. } = &reply else { panic!("{reply:?}") };
    let program = caller(4, &reply);
    let principal = bench.directory.principal(&program).expect("valid");
    assert_eq!((principal.account.as_deref(), principal.role), (Some("token:historian"), Role::Viewer));
    let delete = command_privilege(&Command::DeleteMap(MapId(Uuid::nil())));
    assert!(bench.directory.admit(&program, command_privilege(&Command::StopMotion)).is_ok());
    assert!(bench.directory.admit(&program, delete).is_err());
    bench.ask(&ada, AccountRequest::RevokeToken(summary.id)).expect("ended");
    assert_eq!(bench.role(&program), None);
    let again = bench.ask(&ada, AccountRequest::RevokeToken(summary.id));
    assert_eq!(again, Err(AccountRefusalKind::NotFound));
}

#[test]
fn forged_and_expired_sessions_are_nobody() {
    let config = AccountsConfig { session_idle: Span::ZERO, ..Bench::new().worker.config };
    let mut bench = Bench::with(config, AccessMode::SignIn);
    let ada = bench.first_admin();
    assert_eq!(bench.role(&ada), None, "it was idle for too long");
    let forged = Caller { credential: Some(CredentialId([7; 32])), ..stranger(1) };
    assert_eq!((bench.role(&forged), bench.role(&stranger(1))), (None, None));
    assert_eq!(bench.ask(&forged, AccountRequest::ListAccounts), Err(AccountRefusalKind::NotSignedIn));
}

#[test]
fn guessing_locks_strangers_out_and_not_the_owner() {
    let mut bench = Bench::new();
    let ada = bench.first_admin();
    let mut refusals = Vec::new();
    for guess in 0..12 {
        refusals
            .push(bench.sign_in(&stranger(100 + guess), "ada", "wrong horse battery").expect_err("wrong"));
    }
    assert_eq!(refusals[0], AccountRefusalKind::NotSignedIn);
    assert_eq!(refusals[11], AccountRefusalKind::Busy, "strangers together have too many failures");
    let from_elsewhere = Caller { address: address(200), ..ada };
    assert!(bench.sign_in(&from_elsewhere, "ada", PASSWORD).is_ok(), "the browser is known");
    let without_cookie = Caller { credential: None, ..ada };
    assert!(bench.sign_in(&without_cookie, "ada", PASSWORD).is_ok(), "the address is known");
}

#[test]
fn a_change_on_the_console_is_noticed() {
    let mut bench = Bench::new();
    let ada = bench.first_admin();
    let mut console =
        store::Ledger::open_beside_core(&ports::DataDir::new(bench.dir.path()).ledger()).expect("opens");
    console.write(|writer| writer.remove_account("ada")).expect("written");
    assert_eq!(bench.role(&ada), Some(Role::Admin), "nobody has looked yet");
    bench.worker.refresh();
    assert_eq!(bench.role(&ada), None);
    assert!(link(bench.dir.path()).is_some(), "there is no admin any more");
}

#[test]
fn nobody_signs_in_to_a_demonstration() {
    let mut bench = Bench::with(AccountsConfig::default(), AccessMode::Demo);
    assert_eq!(bench.role(&stranger(1)), Some(Role::Admin));
    assert_eq!(link(bench.dir.path()), None);
    assert_eq!(bench.sign_in(&stranger(1), "ada", PASSWORD), Err(AccountRefusalKind::Conflict));
}

#[test]
fn a_flood_of_strangers_leaves_room_for_those_who_are_known() {
    let mut bench = Bench::new();
    let ada = bench.first_admin();
    let config = bench.worker.config;
    let inbox = AccountInbox::new(config, Arc::clone(&bench.directory));
    let sign_in = || AccountRequest::SignIn { account: "ada".into(), password: Secret::new(PASSWORD) };
    let accepted = (10..200).filter(|last| inbox.ask(0, stranger(*last), sign_in()).is_ok()).count();
    assert_eq!(accepted, config.max_strangers);
    assert!(inbox.ask(7, ada, sign_in()).is_ok());
    let first = inbox.next(Duration::ZERO).expect("open").expect("waits");
    assert_eq!(first.number, 7, "it goes first");
}
