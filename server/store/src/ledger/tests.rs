//! What is written is there when the ledger is opened again, and no damage loses it unnoticed.

use super::schema::AUDIT;
use super::*;
use crate::Store;
use crate::stored_data_check::StoredDataReport;
use api::{CredentialId, Role, RunFilter, StoredSlot};
use messages::{FiringRecord, LedgerEvent, Principal, ResultRecord, RunRecord, StepRecord};
use rusqlite::types::Value;
use site_model::{
    Asset, AssetId, Change, Edit, EditId, InspectionPointId, MissionEvent, MissionEventKind, MissionId,
    MonitorId, Object, ObjectId, Revision, RevisionChange, RunId, RunState, ScheduleId,
};
use std::ops::ControlFlow;
use uuid::Uuid;
use vocab::{ClientId, Stamp};

const AT: Stamp = Stamp::from_nanos(1_800_000_000_000_000_000);
const RUN: RunId = RunId(Uuid::from_u128(50));

fn asset_id(number: u128) -> ObjectId {
    ObjectId::Asset(AssetId(Uuid::from_u128(number)))
}

fn asset(number: u128, name: &str) -> Object {
    Object::Asset(Asset {
        id: AssetId(Uuid::from_u128(number)),
        name: name.to_owned(),
        tags: Default::default(),
    })
}

fn edit_id(number: u128) -> EditId {
    EditId(Uuid::from_u128(number))
}

fn me() -> Principal {
    Principal::operator(ClientId(Uuid::from_u128(7)))
}

/// Applies an edit to the site and writes it.
fn edit(
    ledger: &mut Ledger,
    state: &mut SiteState,
    number: u128,
    changes: Vec<Change>,
) -> Vec<RevisionChange> {
    let edit = Edit { id: edit_id(number), changes };
    let changes = state.site.apply(&edit, edit.id).expect("of this state").revisions;
    state.revision += 1;
    let me = me();
    let record =
        EditRecord { revision: state.revision, edit: &edit, changes: &changes, by: Some(&me), at: AT };
    ledger.write(|writer| writer.put_edit(&record)).expect("written");
    changes
}

/// Three edits: two objects put, one changed, one removed.
fn fill(ledger: &mut Ledger, state: &mut SiteState) {
    let put = |base: Option<u64>, object| Change::Put { base: base.map(Revision), object };
    edit(ledger, state, 1, vec![put(None, asset(1, "Pump 1")), put(None, asset(2, "Pump 2"))]);
    edit(ledger, state, 2, vec![put(Some(1), asset(1, "Pump 1, east"))]);
    edit(ledger, state, 3, vec![Change::Remove { base: Revision(1), object: asset_id(2) }]);
}

/// A data directory with a ledger that was closed properly.
fn filled() -> (tempfile::TempDir, SiteState) {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, mut state) = store.open_ledger().expect("opens");
    fill(&mut ledger, &mut state);
    let firing = FiringRecord {
        schedule: ScheduleId(Uuid::from_u128(70)),
        due_utc_ns: AT.nanos(),
        run: None,
        outcome: "missed".to_owned(),
        body: "{}".to_owned(),
    };
    ledger.write(|writer| writer.put_event(&LedgerEvent::Firing(firing), AT)).expect("written");
    let (account, session) = (account(), session());
    ledger.write(|writer| writer.put_account("ada", &account)).expect("written");
    ledger.write(|writer| writer.put_credential(CredentialId([7; 32]), &session)).expect("written");
    ledger.write(|writer| writer.put_picture_comparison(1, "{}", AT)).expect("written");
    (dir, state)
}

fn account() -> StoredAccount {
    let password = "$argon2id$".to_owned();
    StoredAccount { role: Role::Admin, password, is_enabled: true, created: AT, changed: AT }
}

fn session() -> StoredCredential {
    StoredCredential {
        owner: "ada".to_owned(),
        token_role: None,
        created: AT,
        used: AT,
        expires: AT,
        ended: None,
        address: Some("192.0.2.1".to_owned()),
    }
}

#[test]
fn accounts_are_read_by_others_when_they_change() {
    let (dir, _) = filled();
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, _) = store.open_ledger().expect("opens");
    let mut reader = AccountReader::new(&store.dir().ledger());
    let accounts = reader.read_if_changed().expect("readable").expect("new");
    assert_eq!(accounts.accounts.get("ada"), Some(&account()));
    assert_eq!(accounts.credentials.get(&CredentialId([7; 32])), Some(&session()));
    assert_eq!(reader.read_if_changed().expect("readable"), None, "nothing has changed");
    ledger.write(|writer| writer.remove_account("ada")).expect("written");
    assert_eq!(reader.read_if_changed().expect("readable"), Some(Accounts::default()));
}

#[test]
fn an_entry_of_the_audit_log_that_was_changed_is_found() {
    let (dir, _) = filled();
    let path = dir.path().join("ledger.db");
    let verified = verify_ledger(&path).expect("whole");
    assert!(verified.first == 1 && verified.last >= 3 && verified.checksum.is_some());
    // Whoever changes a row can compute its checksum anew, but not those of all that follow.
    let connection = Connection::open(&path).expect("opens");
    let rows = AUDIT.read(&connection, "WHERE seq = 2", [], |row| Some(row.to_vec())).expect("readable");
    let mut row = rows.into_iter().next().expect("an entry");
    row[3] = Value::from("nothing at all".to_owned());
    AUDIT.put(&connection, &row).expect("written");
    drop(connection);
    assert!(verify_ledger(&path).is_err());
}

/// Adds this number of entries, of which 100 are kept, each in a transaction of its own.
fn log_of_100(path: &Path, added: u64) {
    let mut ledger = Ledger::open_beside_core(path).expect("opens");
    ledger.keep_audit_entries(100);
    for number in 0..added {
        let (command, outcome) = (format!("command {number}"), "accepted".to_owned());
        let entry = AuditEntry { by: None, address: None, command, outcome };
        ledger.write(|writer| writer.put_audit_entry(&entry, AT)).expect("written");
    }
}

#[test]
fn a_log_that_was_cut_is_bounded_and_its_chain_holds() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("ledger.db");
    log_of_100(&path, 99);
    assert_eq!(verify_ledger(&path).expect("whole").first, 1, "nothing is removed yet");
    for _ in 0..5 {
        log_of_100(&path, 150);
        let VerifiedAudit { first, last, .. } = verify_ledger(&path).expect("the chain holds");
        assert!(first > 1 && (100..=102).contains(&(last + 1 - first)), "{first} to {last}");
    }
    let ledger = Ledger::open_beside_core(&path).expect("opens");
    let told = ledger.audit(None, "remove old entries", 10).expect("readable");
    assert!(told[0].outcome.starts_with("done up to entry "), "{told:?}");
}

#[test]
fn entries_that_others_have_removed_at_the_beginning_are_missed() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("ledger.db");
    log_of_100(&path, 50);
    let connection = Connection::open(&path).expect("opens");
    connection.execute("DELETE FROM audit WHERE seq <= 10", []).expect("deleted");
    assert!(verify_ledger(&path).is_err(), "nothing says that they were removed");
    log_of_100(&path, 150);
    verify_ledger(&path).expect("what the platform has removed includes them");
    let first = verify_ledger(&path).expect("whole").first;
    connection.execute("DELETE FROM audit WHERE seq = ?1", [first as i64]).expect("deleted");
    assert!(verify_ledger(&path).is_err(), "one more than the platform has removed");
}

#[test]
fn the_audit_log_is_searched_in_all_that_people_see_of_it() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, _) = store.open_ledger().expect("opens");
    // The id of the client has the letters of the account in it.
    let client = ClientId(Uuid::from_u128(0xada));
    let by =
        |account: &str| Some(Principal { client, account: Some(account.to_owned()), role: Role::Operator });
    let entries = [
        (by("ada"), "StopMotion", "accepted"),
        (by("bob"), "Localise", "refused: another holds control"),
        (None, "sign in as ada", "refused"),
        (by("bob"), "LeaveMap", "accepted"),
    ];
    for (by, command, outcome) in entries {
        let address = Some([192, 0, 2, if command == "LeaveMap" { 8 } else { 7 }].into());
        let entry = AuditEntry { by, address, command: command.to_owned(), outcome: outcome.to_owned() };
        ledger.write(|writer| writer.put_audit_entry(&entry, AT)).expect("written");
    }
    let found = |before, containing: &str, limit| -> Vec<String> {
        let entries = ledger.audit(before, containing, limit).expect("readable");
        entries.into_iter().map(|entry| entry.command).collect()
    };
    assert_eq!(found(None, "", 100), ["LeaveMap", "sign in as ada", "Localise", "StopMotion"]);
    assert_eq!(found(None, "ADA", 100), ["sign in as ada", "StopMotion"]);
    assert_eq!(found(None, "192.0.2.8", 100), ["LeaveMap"]);
    assert_eq!(found(None, "another holds", 100), ["Localise"]);
    assert_eq!(found(None, "%", 100), [""; 0], "no pattern, but text");
    assert_eq!(found(Some(3), "", 1), ["Localise"]);
}

struct Found(Vec<String>);

impl StoredDataReport for Found {
    fn on_damage(&mut self, error: StoreError) {
        self.0.push(ports::error_with_causes(&error));
    }
    fn on_read(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn damage(store: &Store) -> Vec<String> {
    let mut found = Found(Vec::new());
    assert!(store.check_ledger(&mut found).is_continue());
    found.0
}

#[test]
fn the_site_is_as_it_was_and_every_revision_is_kept() {
    let (dir, state) = filled();
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, read) = store.open_ledger().expect("opens");
    assert_eq!(read, state);
    assert_eq!(read.site.removed().collect::<Vec<_>>(), [(asset_id(2), Revision(2))]);
    assert_eq!(store.take_problems(), [""; 0]);
    assert_eq!(damage(&store), [""; 0]);

    let revisions = ledger.revisions(asset_id(1), None, 100).expect("read");
    let names: Vec<_> = revisions.iter().map(|it| (it.revision.0, it.object.clone())).collect();
    assert_eq!(names, [(2, Some(asset(1, "Pump 1, east"))), (1, Some(asset(1, "Pump 1")))]);
    assert!(
        revisions[0].author.as_ref().is_some_and(|author| author.contains("00000007"))
            && revisions[0].at == AT
    );
    let removed = ledger.revisions(asset_id(2), None, 1).expect("read");
    assert_eq!((removed.len(), removed[0].revision.0, &removed[0].object), (1, 2, &None));
    assert_eq!(ledger.revisions(asset_id(2), Some(Revision(2)), 9).expect("read").len(), 1);

    // The answer to an edit that comes again.
    let answer = ledger.write(|writer| writer.applied_edit(edit_id(2))).expect("read");
    let change = RevisionChange { object: asset_id(1), before: Some(Revision(1)), after: Some(Revision(2)) };
    assert_eq!(answer, Some((2, vec![change])));
    assert_eq!(ledger.write(|writer| writer.applied_edit(edit_id(9))).expect("read"), None);
}

#[test]
fn a_transaction_that_fails_leaves_nothing() {
    let (dir, state) = filled();
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, _) = store.open_ledger().expect("opens");
    let failed: Result<(), _> = ledger.write(|writer| {
        writer.put_event(&run("running", false), AT)?;
        Err(StoreError::LedgerRow { path: dir.path().to_owned() })
    });
    assert!(failed.is_err());
    assert_eq!(ledger.runs(&RunFilter::default(), None, 9).expect("read"), []);
    assert_eq!(ledger.site().expect("read"), state);
}

fn run(state: &str, is_ended: bool) -> LedgerEvent {
    LedgerEvent::Run(RunRecord {
        run: RUN,
        mission: MissionId(Uuid::from_u128(60)),
        state: state.to_owned(),
        is_ended,
        body: "{}".to_owned(),
    })
}

fn step(step: u32, attempt: u32, is_done: bool) -> LedgerEvent {
    let state = if is_done { "succeeded" } else { "intended" }.to_owned();
    LedgerEvent::Step(StepRecord { run: RUN, step, attempt, state, is_done, body: "{}".to_owned() })
}

#[test]
fn runs_steps_results_and_firings_are_read_as_they_were_written() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, _) = store.open_ledger().expect("opens");
    let result = |kind: &str, blob| {
        let (kind, body) = (kind.to_owned(), "{}".to_owned());
        LedgerEvent::Result(ResultRecord { run: RUN, step: 0, attempt: 1, kind, blob, body })
    };
    let point = InspectionPointId(Uuid::from_u128(60));
    let at_point = || {
        let (kind, body) = ("photo".to_owned(), format!(r#"{{"inspection_point":"{point}"}}"#));
        LedgerEvent::Result(ResultRecord { run: RUN, step: 1, attempt: 1, kind, blob: None, body })
    };
    let schedule = ScheduleId(Uuid::from_u128(70));
    let firing = |outcome: &str| {
        let (outcome, body) = (outcome.to_owned(), "{}".to_owned());
        LedgerEvent::Firing(FiringRecord { schedule, due_utc_ns: AT.nanos(), run: Some(RUN), outcome, body })
    };
    let later = Stamp::from_nanos(AT.nanos() + 5);
    let events =
        [run("running", false), step(0, 0, false), step(0, 0, true), step(0, 1, false), firing("began")];
    ledger
        .write(|writer| {
            events.iter().try_for_each(|event| writer.put_event(event, AT).map(drop))?;
            writer.put_event(&step(0, 1, true), later)?;
            writer.put_event(&step(1, 0, false), later)?;
            writer.put_event(&result("photo", Some([7; 32])), later)?;
            writer.put_event(&result("reading", None), later)?;
            writer.put_event(&at_point(), later)?;
            writer.put_event(&at_point(), later)?;
            // A slot is used once.
            writer.put_event(&firing("missed"), later)
        })
        .expect("written");
    drop(ledger);

    let (mut ledger, _) = store.open_ledger().expect("opens");
    let unfinished = ledger.unfinished_runs().expect("read");
    let [UnfinishedRun { run: unfinished, steps }] = &unfinished[..] else { panic!("{unfinished:?}") };
    assert_eq!((unfinished.run, unfinished.state.as_str(), unfinished.began), (RUN, "running", AT));
    let steps: Vec<_> = steps.iter().map(|it| (it.step, it.attempt, it.intended, it.done)).collect();
    assert_eq!(steps, [(0, 0, AT, Some(AT)), (0, 1, AT, Some(later)), (1, 0, later, None)]);
    assert_eq!(ledger.steps(RUN, Some((0, 0)), 1).expect("read").len(), 1);
    let results = ledger.results(RUN, None, 9).expect("read");
    let kinds: Vec<_> = results.iter().map(|it| (it.number, it.kind.as_str(), it.blob)).collect();
    assert_eq!(kinds[..2], [(1, "photo", Some([7; 32])), (2, "reading", None)]);
    let slots = ledger.slots(None, 9).expect("read");
    let (outcome, body) = ("began".to_owned(), "{}".to_owned());
    assert_eq!(slots, [StoredSlot { schedule, due: AT, run: Some(RUN), outcome, body }]);
    assert_eq!(ledger.slots(Some((AT, schedule)), 9).expect("read"), []);
    assert_eq!(ledger.slots(Some((later, schedule)), 9).expect("read"), slots);
    let at_point = ledger.point_results(point, None, 9).expect("read");
    assert_eq!(at_point.iter().map(|it| (it.number, it.run)).collect::<Vec<_>>(), [(4, RUN), (3, RUN)]);
    assert_eq!(ledger.point_results(point, Some(4), 1).expect("read"), at_point[1..]);
    assert_eq!(ledger.results(RUN, Some(2), 9).expect("read").len(), 2);

    ledger.write(|writer| writer.put_event(&run("succeeded", true), later)).expect("written");
    assert_eq!(ledger.unfinished_runs().expect("read"), []);
    let runs = ledger.runs(&RunFilter::default(), None, 9).expect("read");
    assert_eq!((runs.len(), runs[0].is_ended, runs[0].began, runs[0].changed), (1, true, AT, later));
    assert_eq!(ledger.runs(&RunFilter::default(), Some(RUN), 9).expect("read"), []);
    assert_eq!(ledger.run(RUN).expect("read").as_ref(), runs.first());
    let found = |filter: RunFilter| ledger.runs(&filter, None, 9).expect("read").len();
    let mission = Some(runs[0].mission);
    let all = RunFilter { mission, state: Some(RunState::Succeeded), from: Some(AT), to: Some(later) };
    assert_eq!(found(all), 1);
    assert_eq!(found(RunFilter { mission: Some(MissionId(Uuid::from_u128(1))), ..all }), 0);
    assert_eq!(found(RunFilter { state: Some(RunState::Failed), ..all }), 0);
    assert_eq!(found(RunFilter { from: Some(later), ..all }), 0);
    assert_eq!(found(RunFilter { to: Some(AT), ..all }), 0);

    let event = |kind| MissionEvent { utc: None, command: None, kind };
    let ended = event(MissionEventKind::RunEnded { run: RUN, outcome: RunState::Succeeded });
    let released =
        event(MissionEventKind::MonitorChanged { monitor: MonitorId(Uuid::from_u128(80)), holds: false });
    for event in [&ended, &released] {
        let event = LedgerEvent::Mission(event.clone());
        ledger.write(|writer| writer.put_event(&event, AT)).expect("written");
    }
    assert_eq!(ledger.mission_events(0, 9).expect("read"), [(1, ended), (2, released.clone())]);
    assert_eq!(ledger.mission_events(1, 9).expect("read"), [(2, released)]);
    drop(ledger);
    assert_eq!(damage(&store), [""; 0]);
}

#[test]
fn a_changed_or_removed_entry_of_the_audit_log_is_noticed() {
    let (dir, _) = filled();
    let store = Store::open(dir.path()).expect("opens");
    let change = |sql: &str| {
        let connection = Connection::open(store.dir().ledger()).expect("opens");
        assert_eq!(connection.execute(sql, []).expect("changed"), 1);
    };
    change("DELETE FROM audit WHERE seq = 2");
    assert!(damage(&store)[0].contains("audit log"), "{:?}", damage(&store));
    change("UPDATE audit SET outcome = 'refused' WHERE seq = 1");
    assert!(damage(&store)[0].contains("ledger.db has a row that does not match its checksum"));
}

/// The result of opening a damaged file: the site, and whether people were told of the file.
fn reopen(dir: &Path) -> (SiteState, bool) {
    let store = Store::open(dir).expect("opens");
    let (_, state) = store.open_ledger().expect("opens, if need be anew");
    let is_reported = store.take_problems().iter().any(|text| text.contains("ledger.db"));
    (state, is_reported || !damage(&store).is_empty())
}

#[test]
fn a_damaged_ledger_is_kept_and_a_new_one_begins_with_what_can_be_read() {
    let (template, state) = filled();
    let whole = fs::read(template.path().join("ledger.db")).expect("read");
    let cuts = [0, 1, 100, 4_096, whole.len() / 2, whole.len() - 1];
    let cut = cuts.map(|length| whole[..length].to_vec());
    let zeroed = vec![0; whole.len()];
    for damaged in cut.into_iter().chain([zeroed]) {
        let dir = tempfile::tempdir().expect("temporary directory");
        fs::write(dir.path().join("ledger.db"), &damaged).expect("written");
        let (_, is_reported) = reopen(dir.path());
        assert!(is_reported, "{} bytes", damaged.len());
        let aside = dir.path().join("ledger.db.damaged");
        // Without the last byte, only what is known of a picture is damaged, and the file is used on.
        let is_used = damaged.len() + 1 == whole.len();
        assert_eq!(aside.exists(), !is_used, "{} bytes", damaged.len());
        let kept = if is_used { dir.path().join("ledger.db") } else { aside };
        assert!(fs::read(kept).expect("kept") == damaged, "{} bytes", damaged.len());
        // The new ledger that was begun in its place is whole.
        assert!(is_used || !reopen(dir.path()).1);
    }
    let dir = tempfile::tempdir().expect("temporary directory");
    fs::create_dir(dir.path().join("ledger.db")).expect("made");
    assert!(reopen(dir.path()).1 && dir.path().join("ledger.db.damaged").is_dir());

    // A wrong bit damages at most the object in whose row it is. It is reported, unless the site is read as it was.
    let (mut lost, mut unreported) = (0, 0);
    for number in 0..400 {
        let bit = number * 7_919 * 8 % (whole.len() * 8) + number % 8;
        let mut damaged = whole.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let dir = tempfile::tempdir().expect("temporary directory");
        fs::write(dir.path().join("ledger.db"), &damaged).expect("written");
        let (read, is_reported) = reopen(dir.path());
        assert!(is_reported || read == state, "bit {bit} changes the site and nobody is told");
        lost += usize::from(read.site.objects().len() < state.site.objects().len());
        unreported += usize::from(!is_reported);
        let aside = fs::read(dir.path().join("ledger.db.damaged"))
            .or_else(|_| fs::read(dir.path().join("ledger.db")));
        assert!(aside.expect("kept") == damaged, "bit {bit}: the file was changed");
    }
    assert!(lost < 20 && unreported > 100, "{lost} lost an object, {unreported} changed nothing");
}

#[test]
fn an_object_with_a_wrong_bit_is_taken_from_its_revisions() {
    let (dir, state) = filled();
    let connection = Connection::open(dir.path().join("ledger.db")).expect("opens");
    let wrong = "UPDATE documents SET body = replace(body, 'east', 'west')";
    assert_eq!(connection.execute(wrong, []).expect("changed"), 2);
    drop(connection);
    let (read, is_reported) = reopen(dir.path());
    assert!(is_reported);
    assert_eq!(read.site, state.site, "no object is lost, not even the mark of a removed one");
}

#[test]
fn what_sqlite_keeps_beside_a_damaged_ledger_is_kept_with_it() {
    let (dir, state) = filled();
    let path = dir.path().join("ledger.db");
    // As after a kill: the last edit is in the WAL only.
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, mut newer) = store.open_ledger().expect("opens");
    let put = Change::Put { base: None, object: asset(3, "Pump 3") };
    edit(&mut ledger, &mut newer, 4, vec![put]);
    let [database, wal] =
        [path.clone(), dir.path().join("ledger.db-wal")].map(|file| fs::read(file).expect("read"));
    drop(ledger);
    drop(store);

    let killed = tempfile::tempdir().expect("temporary directory");
    let write = |name: &str, bytes: &[u8]| fs::write(killed.path().join(name), bytes).expect("written");
    write("ledger.db", &database);
    write("ledger.db-wal", &wal);
    assert_eq!(reopen(killed.path()), (newer.clone(), false));

    // The WAL must not be taken for that of the new file.
    write("ledger.db", b"nonsense");
    write("ledger.db-wal", &wal);
    let (read, is_reported) = reopen(killed.path());
    assert!(is_reported && read.site.objects().len() == 0, "{read:?}");
    assert!(fs::read(killed.path().join("ledger.db.damaged-wal")).expect("kept") == wal);

    // A killed program that had put the file aside and not begun a new one.
    fs::rename(&path, dir.path().join("ledger.db.damaged")).expect("renamed");
    let (read, is_reported) = reopen(dir.path());
    assert!(is_reported && read.site.objects().len() > state.site.objects().len());
}

#[test]
fn a_long_log_is_moved_into_the_database_and_cut_to_nothing() {
    let (dir, mut state) = filled();
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, _) = store.open_ledger().expect("opens");
    let length = || fs::metadata(dir.path().join("ledger.db-wal")).map_or(0, |about| about.len());
    let (mut longest, mut is_cut) = (0, false);
    for number in 4..400 {
        let put = Change::Put { base: None, object: asset(number, &"Pump ".repeat(8_000)) };
        edit(&mut ledger, &mut state, number, vec![put]);
        is_cut |= length() < longest;
        longest = longest.max(length());
    }
    assert!(is_cut && longest < 2 * CONFIG.max_log_bytes, "{is_cut}, {longest} bytes");
    // Somebody who reads keeps it from being cut, and keeps nobody waiting.
    let reader = open_for_reading(&dir.path().join("ledger.db")).expect("opens");
    reader.execute_batch("BEGIN; SELECT count(*) FROM sqlite_schema;").expect("reads");
    let count: i64 =
        reader.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0)).expect("reads");
    assert!(count > 0);
    ledger.begin_log_anew(0);
    let put = Change::Put { base: None, object: asset(400, "Pump") };
    edit(&mut ledger, &mut state, 400, vec![put]);
    assert!(length() > 0);
    reader.execute_batch("COMMIT").expect("ends");
    ledger.begin_log_anew(0);
    assert_eq!(length(), 0);
    assert_eq!(ledger.site().expect("reads"), state);
}

/// As [`filled`], with the files that a killed program leaves.
fn killed() -> (Vec<u8>, Vec<u8>, SiteState) {
    let (dir, mut state) = filled();
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, _) = store.open_ledger().expect("opens");
    for number in 4..12 {
        let put = Change::Put { base: None, object: asset(number, "Pump") };
        edit(&mut ledger, &mut state, number, vec![put]);
    }
    let [database, wal] =
        ["ledger.db", "ledger.db-wal"].map(|name| fs::read(dir.path().join(name)).expect("read"));
    (database, wal, state)
}

#[test]
fn a_wrong_bit_in_what_a_killed_program_has_left_is_told() {
    let (database, wal, state) = killed();
    let open = |wal: &[u8]| {
        let dir = tempfile::tempdir().expect("temporary directory");
        fs::write(dir.path().join("ledger.db"), &database).expect("written");
        fs::write(dir.path().join("ledger.db-wal"), wal).expect("written");
        let (read, is_reported) = reopen(dir.path());
        (read, is_reported, dir)
    };
    let (read, is_reported, _) = open(&wal);
    assert_eq!((read, is_reported), (state.clone(), false));
    let mut lost = 0;
    for number in 0..300 {
        let bit = number * 104_729 % (wal.len() * 8);
        let mut damaged = wal.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let (read, is_reported, dir) = open(&damaged);
        assert!(is_reported || read == state, "bit {bit} of {}", wal.len() * 8);
        lost += usize::from(read != state);
        if is_reported {
            assert!(fs::read(dir.path().join("ledger.db-wal.damaged")).expect("kept") == damaged);
        }
    }
    assert!(lost > 100, "{lost}: the bits are in what counts");
    // Cut at the end of a frame, it is that of a program that was killed earlier.
    let page = 4_096 + 24;
    let (read, is_reported, _) = open(&wal[..32 + (wal.len() - 32) / page / 2 * page]);
    assert!(!is_reported && read.revision < state.revision && read.revision >= 3);
}

#[test]
fn a_transaction_that_a_kill_has_left_in_a_journal_is_undone() {
    let (dir, state) = filled();
    let path = dir.path().join("ledger.db");
    let connection = Connection::open(&path).expect("opens");
    connection.pragma_update(None, "journal_mode", "DELETE").expect("settable");
    connection.execute_batch("BEGIN; UPDATE edits SET author = 'half of a transaction'").expect("begun");
    connection.cache_flush().expect("written");
    let killed = tempfile::tempdir().expect("temporary directory");
    for file in ["ledger.db", "ledger.db-journal"] {
        fs::copy(dir.path().join(file), killed.path().join(file)).expect("copied");
    }
    let (reopened, is_damaged) = reopen(killed.path());
    assert_eq!((reopened, is_damaged), (state, false));
}

#[test]
fn a_ledger_of_a_later_program_is_left_as_it_is() {
    let (dir, _) = filled();
    let path = dir.path().join("ledger.db");
    let connection = Connection::open(&path).expect("opens");
    connection.pragma_update(None, "user_version", 99).expect("changed");
    drop(connection);
    let before = fs::read(&path).expect("read");
    let store = Store::open(dir.path()).expect("opens");
    let error = store.open_ledger().expect_err("of a later program");
    assert!(matches!(error, StoreError::LaterVersion { version: 99, .. }), "{error:?}");
    assert!(error.to_string().contains("update AutoInspect"), "{error}");
    assert_eq!(damage(&store), [""; 0]);
    assert!(fs::read(&path).expect("read") == before && !dir.path().join("ledger.db.damaged").exists());
}

/// A row that is whole and means nothing here is no damage: nothing may be put aside.
#[test]
fn a_kind_of_object_of_a_later_program_is_not_taken_for_damage() {
    let (dir, _) = filled();
    let store = Store::open(dir.path()).expect("opens");
    let (mut ledger, _) = store.open_ledger().expect("opens");
    let id = Uuid::from_u128(9).to_string();
    let texts = ["lift", &id].map(|text| Value::from(text.to_owned()));
    let [kind, id] = texts;
    let values = [kind, id, Value::from(1), Value::from("{}".to_owned()), Value::Null, Value::from(0)];
    ledger
        .write(|writer| {
            schema::DOCUMENTS.put(writer.transaction, &values).map_err(|fault| writer.error(fault))
        })
        .expect("written");
    drop(ledger);
    let error = store.open_ledger().expect_err("of a later program");
    assert!(matches!(error, StoreError::LedgerRow { .. }), "{error:?}");
    assert!(!dir.path().join("ledger.db.damaged").exists());
}

#[test]
fn an_interrupted_beginning_is_begun_again() {
    let dir = tempfile::tempdir().expect("temporary directory");
    fs::write(dir.path().join("ledger.db.part"), b"half").expect("written");
    assert_eq!(reopen(dir.path()), (SiteState::default(), false));
    assert!(!dir.path().join("ledger.db.part").exists());
}
