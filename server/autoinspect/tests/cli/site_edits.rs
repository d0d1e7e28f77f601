//! Edits of the site through the whole program: nothing acknowledged is lost, many clients agree, the documented requests work.

use crate::core_process::{CoreProcess, RobotProcess};
use crate::fake_gateway::{CLIENT, CommandSender, FakeGateway, PATIENCE, until};
use crate::missions::{MISSION, RUN, localised, missions, put, request, site as mission_site};
use crate::operator::Operator;
use crate::platform::RunningPlatform;
use api::{
    ClientMessage, CoreMessage, EditDone, EditOutcome, Event, GatewayMessage, SiteAssembly, SiteState,
};
use client_model::{
    ClientCommand, ClientEffect, ClientEvent, ClientTime, Ids, Model, SiteEdit, Socket, ViewSettings,
};
use geometry::{Rng, RngTree};
use site_model::{
    Asset, AssetId, Change, Edit, EditId, MissionCommandKind, Object, ObjectId, Parameter, RunState, Site,
    StartMode, TaskStatus,
};
use std::collections::BTreeSet;
use std::io;
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::Command;
use std::sync::Barrier;
use std::thread;
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};
use uuid::Uuid;

fn asset(number: u128, name: &str) -> Object {
    Object::Asset(Asset { id: asset_id(number), name: name.to_owned(), tags: Default::default() })
}

fn asset_id(number: u128) -> AssetId {
    AssetId(Uuid::from_u128(number))
}

fn name_of(site: &Site, number: u128) -> Option<&str> {
    site.get(ObjectId::Asset(asset_id(number)))?.object.name()
}

/// The site that a core sends to a gateway that connects.
fn site_of(gateway: &mut FakeGateway) -> SiteState {
    let mut assembly = SiteAssembly::default();
    gateway.event(|event| match event {
        Event::SitePart(part) => assembly.add(part),
        _ => None,
    })
}

/// Kills of the core while edits are being written. Each is made of a few objects, so that a half-written one would show.
const KILLS: u64 = 5;

#[test]
fn edits_that_were_acknowledged_survive_kills_and_none_is_there_by_half() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let robot = RobotProcess::start(dir.path(), &["--lidar-columns", "50", "--people", "0"]);
    let mut rng = RngTree::new(1).child("kills").rng();
    // Names that the objects must have at least, and those that were sent.
    let (mut acknowledged, mut sent) = (0, 0);
    for _ in 0..KILLS {
        let core = CoreProcess::start_with(dir.path(), &robot);
        let mut gateway = FakeGateway::connect(&core.socket);
        let mut state = site_of(&mut gateway);
        let names: Vec<_> = (0..3).filter_map(|number| name_of(&state.site, number)).collect();
        let names: Vec<u64> = names.iter().map(|name| name.parse().expect("a number")).collect();
        assert!(names.iter().all(|name| *name == names[0]), "an edit is there by half: {names:?}");
        let stored = names.first().copied().unwrap_or(0);
        assert!((acknowledged..=sent).contains(&stored), "{stored} is not from {acknowledged} to {sent}");
        let revision = state.revision;
        assert_eq!(revision, stored, "one edit, one revision");

        // Edits one after the other without waiting; another thread kills the core meanwhile.
        let mut writer = gateway.another_sender();
        let edits = 40 + (rng.uniform() * 200.0) as u64;
        (acknowledged, sent) = (stored, stored);
        for _ in 0..edits {
            sent += 1;
            let changes = (0..3).map(|number| {
                let object = asset(number, &sent.to_string());
                Change::Put { base: state.site.revision(object.id()), object }
            });
            let edit = Edit { id: EditId(Uuid::from_u128(sent.into())), changes: changes.collect() };
            state.site.apply(&edit, edit.id).expect("of this state");
            writer.send(&GatewayMessage::Edit { by: CLIENT.into(), edit });
        }
        let until = stored + 1 + (rng.uniform() * (edits - 1) as f64) as u64;
        let mut core = Some(core);
        // After the kill, the answers that were on their way are read too.
        while let Some(message) = gateway.next_message() {
            let CoreMessage::Event { event: Event::EditDone(EditDone { id, outcome }), .. } = message else {
                continue;
            };
            assert!(matches!(outcome, EditOutcome::Applied { .. }), "{outcome:?}");
            acknowledged = id.0.as_u128() as u64;
            if acknowledged == until
                && let Some(core) = core.take()
            {
                core.kill();
            }
        }
        assert!(acknowledged >= until);
    }
}

/// A client with its socket, which works like the page.
struct Client {
    model: Model,
    socket: WebSocket<TcpStream>,
    started: Instant,
    effects: Vec<ClientEffect>,
    edits_sent: u64,
}

impl Client {
    fn connect(address: SocketAddr, number: u128) -> Self {
        let stream = TcpStream::connect(address).expect("a connection");
        stream.set_nodelay(true).expect("settable");
        let url = format!("ws://{address}{}", api::CONTROL_PATH);
        let (socket, _) = tungstenite::client(url, stream).expect("a WebSocket");
        socket.get_ref().set_read_timeout(Some(Duration::from_millis(2))).expect("settable");
        let lease = api::LeaseToken(Uuid::from_u128(number));
        let model = Model::new(lease, Ids::new(number << 64), ViewSettings::default(), ClientTime(0.0));
        let mut client = Self { model, socket, started: Instant::now(), effects: Vec::new(), edits_sent: 0 };
        client.on(ClientEvent::SocketOpened(Socket::Control));
        client.work_until("the site has come", |client| client.model.site.site().is_some());
        client
    }

    fn on(&mut self, event: ClientEvent) {
        let now = ClientTime(self.started.elapsed().as_secs_f64());
        self.model.handle_event(now, event, &mut self.effects);
        for effect in std::mem::take(&mut self.effects) {
            if let ClientEffect::Send(message) = effect {
                self.edits_sent += u64::from(matches!(message, ClientMessage::Edit(_)));
                self.socket.write(Message::Binary(api::encode(&message).into())).expect("written");
            }
        }
        self.socket.flush().expect("written");
    }

    /// Reads what has come, and lets time pass.
    fn work(&mut self) {
        match self.socket.read() {
            Ok(Message::Binary(bytes)) => {
                let message = api::decode(&bytes).expect("a message");
                self.on(ClientEvent::Server { message, bytes: bytes.len() });
            }
            Ok(_) => {}
            Err(tungstenite::Error::Io(error)) if error.kind() == io::ErrorKind::WouldBlock => {
                self.on(ClientEvent::Tick);
            }
            Err(error) => panic!("the socket broke: {error}"),
        }
    }

    fn work_until(&mut self, what: &str, condition: impl Fn(&Self) -> bool) {
        let started = Instant::now();
        while !condition(self) {
            assert!(started.elapsed() < PATIENCE, "did not happen within the limit: {what}");
            self.work();
        }
    }

    fn put(&mut self, number: u128, name: &str) {
        let edit = SiteEdit { put: vec![asset(number, name)], removed: Vec::new() };
        self.on(ClientEvent::Command(ClientCommand::EditSite(edit)));
    }

    /// An edit as people make them: of objects of its own, and of some that all change.
    fn edit(&mut self, client: u128, number: u64, rng: &mut Rng) {
        let mut draw = |count: f64| (rng.uniform() * count) as u128;
        let (own, shared) = (1_000 + 100 * client + draw(20.0), draw(5.0));
        match draw(10.0) {
            0 | 1 => self.put(shared, &format!("{client}-{number}")),
            2 => {
                let removed = vec![ObjectId::Asset(asset_id(own))];
                let edit = SiteEdit { put: Vec::new(), removed };
                self.on(ClientEvent::Command(ClientCommand::EditSite(edit)));
            }
            3 => self.on(ClientEvent::Command(ClientCommand::Undo)),
            _ => self.put(own, &format!("{client}-{number}")),
        }
    }

    fn confirmed(&self) -> &SiteState {
        self.model.site.confirmed().expect("it has come")
    }
}

/// Number of clients, and of edits that each makes in a second.
const CLIENTS: u128 = 10;
const EDITS_PER_S: u32 = 20;

/// Starts a mission of waits at the two ends of a short walk, long enough for all edits. Returns the number of its tasks.
fn start_mission(operator: &mut Operator, edit_seconds: u32) -> usize {
    let ends = localised(operator);
    let wait = || request("wait", "duration_s", Parameter::Number(1.0));
    // A task takes 2 s at least: the robot lives twice as fast as the clock.
    let tasks = 3 + edit_seconds as usize / 2;
    put(operator, mission_site(ends, (0..tasks).map(|_| wait()).collect()));
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Now };
    operator.command(api::Command::Mission(start));
    tasks
}

/// Follows the mission to its end. Returns its tasks when it was last shown, and its outcome.
fn follow_mission(operator: &mut Operator) -> (Vec<TaskStatus>, RunState) {
    let mut tasks = Vec::new();
    let started = Instant::now();
    loop {
        assert!(started.elapsed() < 3 * PATIENCE, "the mission did not end: {tasks:#?}");
        let status = operator.event(missions);
        if let Some(ended) = status.ended.iter().find(|ended| ended.run == RUN) {
            return (tasks, ended.outcome);
        }
        if let Some(run) = status.runs.into_iter().find(|run| run.run == RUN) {
            assert!(run.question.is_none(), "{run:?}");
            tasks = run.tasks;
        }
    }
}

#[test]
fn ten_clients_that_edit_at_once_disturb_no_mission_end_with_the_same_site_and_undo_their_own_last_edit() {
    edit_with_ten_clients(3);
}

mod nightly {
    #[test]
    fn ten_clients_edit_for_a_minute_while_a_mission_runs() {
        super::edit_with_ten_clients(60);
    }
}

/// Ten clients edit one site for this time, and undo their own last edit, while a mission runs.
#[expect(clippy::print_stdout, reason = "figures of a test")]
fn edit_with_ten_clients(edit_seconds: u32) {
    let dir = tempfile::tempdir().expect("temporary directory");
    let platform = RunningPlatform::start_with_robot(dir.path(), &["--lidar-columns", "400", "--speed", "2"]);
    let address = platform.address();
    let mut operator = Operator::connect(address);
    let tasks = start_mission(&mut operator, edit_seconds);
    let mission = thread::spawn(move || follow_mission(&mut operator));
    let edits = edit_seconds * EDITS_PER_S;
    let barrier = Barrier::new(CLIENTS as usize);
    let (states, sent, still_runs) = thread::scope(|scope| {
        let threads: Vec<_> = (1..=CLIENTS)
            .map(|number| {
                let barrier = &barrier;
                scope.spawn(move || {
                    let mut client = Client::connect(address, number);
                    let mut rng = RngTree::new(2).child(&number.to_string()).rng();
                    barrier.wait();
                    let began = Instant::now();
                    for count in 0..edits {
                        client.edit(number, count.into(), &mut rng);
                        while began.elapsed() < (count + 1) * Duration::from_secs(1) / EDITS_PER_S {
                            client.work();
                        }
                    }
                    // Two edits of one object of its own, of which the second is undone.
                    client.put(10 * number, "kept");
                    client.put(10 * number, "undone");
                    client.on(ClientEvent::Command(ClientCommand::Undo));
                    let all = |client: &Client| {
                        let site = &client.confirmed().site;
                        let is_kept = |number| name_of(site, 10 * number) == Some("kept");
                        client.model.site.unconfirmed() == 0 && (1..=CLIENTS).all(is_kept)
                    };
                    client.work_until("all edits are confirmed", all);
                    // Until everybody is done, the others' last edits come too.
                    barrier.wait();
                    client
                })
            })
            .collect();
        let clients: Vec<_> = threads.into_iter().map(|thread| thread.join().expect("no panic")).collect();
        let still_runs = !mission.is_finished();
        let newest = clients.iter().map(|client| client.confirmed().revision).max().expect("clients");
        let finish = |mut client: Client| {
            client.work_until("the last change", |client| client.confirmed().revision == newest);
            assert_eq!(client.model.site.site(), Some(&client.confirmed().site), "it shows what is");
            (client.confirmed().clone(), client.edits_sent)
        };
        let (states, sent): (Vec<SiteState>, Vec<u64>) = clients.into_iter().map(finish).unzip();
        (states, sent, still_runs)
    });
    let sent: u64 = sent.into_iter().sum();
    assert!(states.iter().all(|state| *state == states[0]), "the sites differ");
    for number in 1..=CLIENTS {
        assert_eq!(name_of(&states[0].site, 10 * number), Some("kept"), "of client {number}");
    }
    println!(
        "{CLIENTS} clients sent {sent} edits in {edit_seconds} s; {} were applied, {} objects",
        states[0].revision,
        states[0].site.objects().len()
    );
    // Few are refused, because few objects are shared.
    assert!(states[0].revision * 10 > sent * 7, "{} of {sent}", states[0].revision);
    let (shown, outcome) = mission.join().expect("no panic");
    let repeated = shown.iter().filter(|task| task.attempt > 1 || task.failure.is_some()).count();
    println!("the mission of {tasks} tasks ended as {outcome:?}; {repeated} tasks needed a second attempt");
    assert!(still_runs, "the mission ended before the edits");
    assert_eq!((outcome, repeated, shown.len()), (RunState::Succeeded, 0, tasks), "{shown:#?}");
    drop(platform);
    // Equal on the disk, too.
    let store = store::Store::open(dir.path().join("data")).expect("opens");
    let (_, stored) = store.open_ledger().expect("opens");
    assert_eq!(stored, states[0]);
}

/// The pages of the interface. Their examples follow each other, each page on a robot of its own whose site is empty.
const PAGES: [&str; 4] = [
    include_str!("../../../../docs/api/site.md"),
    include_str!("../../../../docs/api/missions.md"),
    include_str!("../../../../docs/api/scene-changes.md"),
    include_str!("../../../../docs/api/alerts.md"),
];

/// A page whose robot is localised in a map of its own.
const SESSION: &str = include_str!("../../../../docs/api/mission-session.md");

#[test]
fn the_examples_of_the_pages_of_the_interface_work() {
    if Command::new("curl").arg("--version").output().is_err() {
        eprintln!("skipped: there is no curl");
        return;
    }
    for page in PAGES {
        let dir = tempfile::tempdir().expect("temporary directory");
        let platform = RunningPlatform::start_with_robot(dir.path(), &["--lidar-columns", "50"]);
        check_examples(page, &platform);
    }
    let dir = tempfile::tempdir().expect("temporary directory");
    let platform = RunningPlatform::start_with_robot(dir.path(), &["--lidar-columns", "400", "--speed", "2"]);
    let mut operator = Operator::connect(platform.address());
    localised(&mut operator);
    // Whoever runs the examples takes control.
    operator.command(api::Command::ReleaseControl);
    check_examples(SESSION, &platform);
}

fn check_examples(page: &str, platform: &RunningPlatform) {
    let examples = page.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap_or_default());
    let answers = page.split("```json\n").skip(1).map(|rest| rest.split("```").next().unwrap_or_default());
    let mut ran = 0;
    for (example, answer) in examples.zip(answers) {
        let output = until("the site has come", || {
            let output = Command::new("bash")
                .args(["-euo", "pipefail", "-c", example])
                .env("ROBOT", format!("http://{}", platform.address()))
                .output()
                .expect("bash runs");
            let is_early = String::from_utf8_lossy(&output.stdout).contains("has not sent the documents");
            (!is_early).then_some(output)
        });
        let said = String::from_utf8_lossy(&output.stdout);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{example}\n{said}\n{complaint}");
        if std::env::var_os("AUTOINSPECT_PRINT_EXAMPLES").is_some() {
            eprintln!("$ {example}{said}\n");
        }
        // Some requests have no answer but that they are done.
        let said = if said.is_empty() { "null".into() } else { said };
        let said: serde_json::Value =
            serde_json::from_str(&said).unwrap_or_else(|error| panic!("{example}\n{said}\n{error}"));
        let expected: serde_json::Value =
            serde_json::from_str(answer).unwrap_or_else(|error| panic!("{answer}\n{error}"));
        assert_like(&expected, &said, example);
        ran += 1;
    }
    assert!(ran >= 6, "only {ran} examples");
}

/// Fails unless the answer is the documented one. `"…"` stands for anything.
fn assert_like(expected: &serde_json::Value, said: &serde_json::Value, place: &str) {
    use serde_json::Value;
    match (expected, said) {
        (Value::String(text), _) if text == "…" => {}
        (Value::Object(expected), Value::Object(said)) => {
            let keys = |map: &serde_json::Map<String, Value>| map.keys().cloned().collect::<BTreeSet<_>>();
            assert_eq!(keys(expected), keys(said), "{place}");
            expected
                .iter()
                .for_each(|(key, value)| assert_like(value, &said[key], &format!("{place}: {key}")));
        }
        (Value::Array(expected), Value::Array(said)) => {
            assert_eq!(expected.len(), said.len(), "{place}");
            expected.iter().zip(said).for_each(|(expected, said)| assert_like(expected, said, place));
        }
        _ => assert_eq!(expected, said, "{place}"),
    }
}

/// A data directory of a program without a ledger gets one; see also `stored_data`.
#[test]
fn a_damaged_ledger_is_kept_and_people_are_told() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let ledger = dir.path().join("ledger.db");
    std::fs::write(&ledger, b"nonsense").expect("written");
    let robot = RobotProcess::start(dir.path(), &["--lidar-columns", "50", "--people", "0"]);
    let core = CoreProcess::start_with(dir.path(), &robot);
    let mut gateway = FakeGateway::connect(&core.socket);
    gateway.notice("ledger.db.damaged");
    assert_eq!(std::fs::read(dir.path().join("ledger.db.damaged")).expect("kept"), b"nonsense");
    assert!(is_database(&ledger));
    drop(core);
}

fn is_database(path: &Path) -> bool {
    std::fs::read(path).is_ok_and(|bytes| bytes.starts_with(b"SQLite format 3\0"))
}
