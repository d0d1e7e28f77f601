//! The ledger's writer is killed at random moments. What it had acknowledged is there when the ledger is opened again, whole transactions only, and the audit log's chain holds.
//!
//! The writer is this test's own program, started again. It tells of each commit in a pipe. A kill keeps what the system has in memory, so this shows that nothing is
//! acknowledged before its commit; what a power cut leaves is up to `synchronous=FULL` and the disk.

#![allow(clippy::print_stdout, reason = "what was tried is for people")]

use geometry::{Rng, RngTree};
use messages::{FiringRecord, LedgerEvent, Principal};
use site_model::{Asset, AssetId, Change, Edit, EditId, Object, ScheduleId};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use store::{AuditEntry, EditRecord, Ledger, Store, StoredAccount, verify_ledger};
use uuid::Uuid;
use vocab::{ClientId, Stamp};

/// Folder of the ledger that the writer is to fill.
const FOLDER: &str = "AUTOINSPECT_LEDGER_KILLS_FOLDER";

/// Kills in one data directory, so that reading all of it stays short.
const KILLS_OF_FOLDER: usize = 25;

/// Longest wait for the first commit of a writer.
const PATIENCE: Duration = Duration::from_secs(60);

/// What a kill waits for.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// This time after the writer was started: perhaps while it opens the ledger.
    AfterStart(Duration),
    /// This time after it has told of this number of commits.
    AfterCommits(u64, Duration),
}

impl Moment {
    fn draw(rng: &mut Rng) -> Self {
        if rng.uniform() < 0.3 {
            Self::AfterStart(Duration::from_secs_f64(rng.range(0.0, 0.06)))
        } else {
            Self::AfterCommits(rng.bits() % 30, Duration::from_secs_f64(rng.range(0.0, 0.004)))
        }
    }
}

fn at(number: u64) -> Stamp {
    Stamp::from_nanos(1_800_000_000_000_000_000 + number as i64)
}

fn asset(number: u64) -> Asset {
    let id = AssetId(Uuid::from_u128(number.into()));
    Asset { id, name: format!("Pump {number}"), tags: Default::default() }
}

fn account(number: u64) -> StoredAccount {
    let password = format!("$argon2id${number}");
    StoredAccount {
        role: api::Role::Viewer,
        password,
        is_enabled: true,
        created: at(number),
        changed: at(number),
    }
}

fn firing(number: u64) -> FiringRecord {
    FiringRecord {
        schedule: ScheduleId(Uuid::from_u128(7)),
        due_utc_ns: at(number).nanos(),
        run: None,
        outcome: format!("missed {number}"),
        body: "{}".to_owned(),
    }
}

/// The kind of row that a transaction has beside its entry of the audit log.
fn kind(number: u64) -> u64 {
    number % 3
}

/// Commits transactions for ever, and tells of each. The first number is one more than that of the last entry of the audit log.
#[test]
#[ignore = "the program that the other tests kill"]
fn writer() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let store = Store::open(Path::new(&folder)).expect("opens");
    let (mut ledger, mut state) = store.open_ledger().expect("opens");
    let last = ledger.audit(None, "", 1).expect("readable").first().map_or(0, |entry| entry.number);
    let mut told = std::io::stderr();
    let me = Principal::operator(ClientId(Uuid::from_u128(7)));
    for number in last + 1.. {
        let entry = AuditEntry {
            by: Some(me.clone()),
            address: None,
            command: format!("write {number}"),
            outcome: "done".to_owned(),
        };
        let put = Change::Put { base: None, object: Object::Asset(asset(number)) };
        let edit = Edit { id: EditId(Uuid::from_u128(number.into())), changes: vec![put] };
        let changes = match kind(number) {
            0 => {
                state.revision += 1;
                state.site.apply(&edit, edit.id).expect("of this state").revisions
            }
            _ => Vec::new(),
        };
        ledger
            .write(|writer| {
                match kind(number) {
                    0 => {
                        let revision = state.revision;
                        // It makes an entry of the audit log of its own.
                        let record = EditRecord {
                            revision,
                            edit: &edit,
                            changes: &changes,
                            by: Some(&me),
                            at: at(number),
                        };
                        return writer.put_edit(&record);
                    }
                    1 => writer.put_account(&format!("a{number}"), &account(number))?,
                    _ => drop(writer.put_event(&LedgerEvent::Firing(firing(number)), at(number))?),
                }
                writer.put_audit_entry(&entry, at(number))
            })
            .expect("written");
        told.write_all(format!("{number}\n").as_bytes()).expect("the parent reads");
    }
}

/// Runs a writer until its moment. Returns the last commit that it told of.
fn kill_writer(folder: &Path, moment: Moment) -> Option<u64> {
    let mut child = Command::new(std::env::current_exe().expect("known"))
        .args(["--exact", "writer", "--ignored", "--nocapture"])
        .env(FOLDER, folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    let start = Instant::now();
    let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
    let mut last = None;
    let mut read = |commits: u64| {
        for _ in 0..commits {
            let Some(line) = lines.next() else { return false };
            let line = line.expect("readable");
            match line.parse() {
                Ok(number) => last = Some(number),
                Err(_) => panic!("the writer failed: {line}"),
            }
        }
        true
    };
    let wait = match moment {
        Moment::AfterStart(wait) => wait,
        Moment::AfterCommits(commits, wait) => {
            assert!(read(commits + 1) && start.elapsed() < PATIENCE, "the writer ended by itself");
            wait
        }
    };
    // The moment itself is a time: what is tested is that it may be any.
    std::thread::sleep(wait);
    child.kill().expect("killed");
    child.wait().expect("reaped");
    // What it told before its end is in the pipe. A line that was cut was not told.
    while let Some(Ok(line)) = lines.next() {
        last = line.parse().ok().or(last);
    }
    last
}

/// All entries of the audit log, the oldest first.
fn audit(ledger: &Ledger) -> Vec<api::StoredAudit> {
    let (mut entries, mut before) = (Vec::new(), None);
    loop {
        let page = ledger.audit(before, "", api::MAX_PAGE).expect("readable");
        let Some(last) = page.last() else { break };
        before = Some(last.number);
        entries.extend(page);
    }
    entries.reverse();
    entries
}

/// Opens the ledger as the core does, and compares all of it with what was told. Returns the number of its transactions.
fn check(folder: &Path, told: u64) -> u64 {
    let store = Store::open(folder).expect("opens");
    let (mut ledger, state) = store.open_ledger().expect("opens");
    assert_eq!(store.take_problems(), Vec::<String>::new());
    let entries = audit(&ledger);
    let count = entries.len() as u64;
    assert!(count >= told, "{told} commits were acknowledged, and {count} are there");
    assert!(count <= told + 1, "{count} are there, but one at most was not acknowledged after {told}");
    for (number, entry) in (1..).zip(&entries) {
        assert_eq!((entry.number, entry.at), (number, at(number)));
        assert!(kind(number) == 0 || entry.command == format!("write {number}"), "{entry:?}");
    }
    let of_kind = |wanted: u64| (1..=count).filter(move |number| kind(*number) == wanted);
    let assets: Vec<Object> = of_kind(0).map(|number| Object::Asset(asset(number))).collect();
    assert_eq!(state.revision, assets.len() as u64);
    for object in &assets {
        assert_eq!(state.site.get(object.id()).map(|stored| &stored.object), Some(object));
    }
    assert_eq!(state.site.objects().len(), assets.len());
    let accounts = ledger.write(|writer| writer.accounts()).expect("readable").accounts;
    let expected: Vec<_> = of_kind(1).map(|number| (format!("a{number}"), account(number))).collect();
    assert_eq!(accounts, expected.into_iter().collect());
    let (mut slots, mut before) = (Vec::new(), None);
    loop {
        let page = ledger.slots(before, api::MAX_PAGE).expect("readable");
        let Some(last) = page.last() else { break };
        before = Some((last.due, last.schedule));
        slots.extend(page.into_iter().map(|slot| (slot.due, slot.outcome)));
    }
    slots.reverse();
    assert_eq!(slots, of_kind(2).map(|number| (at(number), firing(number).outcome)).collect::<Vec<_>>());
    drop(ledger);
    assert_eq!(verify_ledger(&ledger_of(folder)).expect("the chain holds").last, count);
    count
}

fn ledger_of(folder: &Path) -> PathBuf {
    ports::DataDir::new(folder).ledger()
}

fn kill_repeatedly(kills: usize) {
    let seeds = RngTree::new(1).child("ledger kills");
    let (mut folder, mut told, mut total, mut unacknowledged) = (None, 0, 0, 0);
    for case in 0..kills {
        if case % KILLS_OF_FOLDER == 0 {
            total += told;
            (folder, told) = (Some(tempfile::tempdir().expect("a folder")), 0);
        }
        let folder: &tempfile::TempDir = folder.as_ref().expect("the first case makes one");
        let moment = Moment::draw(&mut seeds.child(&case.to_string()).rng());
        told = kill_writer(folder.path(), moment).unwrap_or(told);
        let found = check(folder.path(), told);
        unacknowledged += found - told;
        told = found;
    }
    total += told;
    println!(
        "{kills} kills, {total} transactions, all whole; {unacknowledged} of them were not acknowledged yet"
    );
    assert!(total > kills as u64, "the writers were killed too early to show anything");
}

#[test]
fn kills_lose_no_acknowledged_row() {
    kill_repeatedly(20);
}

mod nightly {
    #[test]
    fn a_thousand_kills_lose_no_acknowledged_row() {
        super::kill_repeatedly(1_000);
    }
}
