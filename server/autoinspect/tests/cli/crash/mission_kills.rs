//! The core is killed at random moments of missions. Each goes on where it was, each task has one result of record, and an action that cannot be repeated without
//! harm is asked about and never repeated.

use super::client::{CoreClient, CoreState};
use super::options::CrashOptions;
use super::report::{CaseReport, CrashReport};
use super::target::START_LIMIT;
use crate::core_process::{CoreProcess, RobotProcess};
use crate::fake_gateway::FakeGateway;
use crate::missions::{MISSION, localised, put, request, site, task_id};
use api::Command;
use geometry::{Rng, RngTree};
use site_model::{
    MissionCommandKind, Parameter, QuestionAnswer, RunId, RunState, RunStatus, StartMode, TaskFailure,
    TaskId, TaskState,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use store::Store;
use uuid::Uuid;

/// Tasks of the mission. Every second one is a message, which cannot be repeated without harm; the others wait.
const TASKS: u128 = 6;
/// Scans of a standing robot are thinned. With fewer columns, what is left is too little to find its place in a map of three keyframes.
const ROBOT: [&str; 6] = ["--lidar-columns", "600", "--people", "0", "--speed", "2"];
/// A run takes about this long on the computer's clock: the robot's is twice as fast.
const RUN_TIME: Duration = Duration::from_millis(10_000);

fn message_of(task: u128) -> String {
    format!("This is message {task}.")
}

/// The moment of a kill.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// After some time.
    Time(Duration),
    /// When the state of a run or a task has changed this many times.
    Change(u32),
    /// When the next message is there: its task may not be recorded as done.
    Message,
}

impl Moment {
    fn draw(rng: &mut Rng) -> Self {
        let (kind, share) = (rng.uniform(), rng.uniform());
        match kind {
            kind if kind < 0.4 => Self::Time(RUN_TIME.mul_f64(share)),
            kind if kind < 0.7 => Self::Change(1 + (share * 8.0) as u32),
            _ => Self::Message,
        }
    }
}

/// What is known of the run under way, over all cores.
#[derive(Default)]
struct KnownRun {
    /// Tasks that were shown as done.
    done: BTreeSet<TaskId>,
    /// Messages that were there, with their number.
    messages: BTreeMap<String, u32>,
    /// Tasks that a person wanted to be done again.
    repeated: BTreeMap<TaskId, u32>,
    /// Tasks that a person has left out.
    skipped: BTreeSet<TaskId>,
}

/// Missions on one data directory, one after the other.
struct MissionChain {
    dir: PathBuf,
    robot: RobotProcess,
    core: Option<CoreProcess>,
    client: CoreClient,
    runs: u128,
    run: KnownRun,
    /// Notices of the present client that were counted.
    counted: usize,
    questions: u32,
}

/// Runs the kills, and fails if a mission did not go on rightly.
pub fn kill_missions() {
    let options = CrashOptions::from_environment();
    let mut report = CrashReport::new(&options, "missions");
    let seeds = RngTree::new(options.seed).child("missions");
    let dir = tempfile::Builder::new().prefix("crash-").tempdir().expect("temporary directory");
    let mut chain = MissionChain::set_up(dir.path());
    let mut is_broken = false;
    for case in 0..options.mission_kills {
        let mut rng = seeds.child(&case.to_string()).rng();
        let mut row = CaseReport { case, ..CaseReport::default() };
        row.failure = chain.run_case(&mut rng, &mut row).err();
        is_broken = row.failure.is_some();
        report.add(&row);
        if is_broken {
            break;
        }
    }
    if !is_broken && let Err(failure) = chain.check_ledger() {
        let what = "the ledger".to_owned();
        report.add(&CaseReport {
            case: options.mission_kills,
            what,
            failure: Some(failure),
            ..CaseReport::default()
        });
    }
    report.finish();
}

impl MissionChain {
    fn set_up(dir: &Path) -> Self {
        let data = dir.join("data");
        let robot = RobotProcess::start(&data, &ROBOT);
        let core = CoreProcess::start_with(&data, &robot);
        let mut gateway = FakeGateway::connect(&core.socket);
        let ends = localised(&mut gateway);
        let requests = (0..TASKS).map(|task| match task % 2 {
            0 => request("wait", "duration_s", Parameter::Number(1.0)),
            _ => request("message", "text", Parameter::Text(message_of(task))),
        });
        put(&mut gateway, site(ends, requests.collect()));
        core.kill();
        let core = CoreProcess::start_with(&data, &robot);
        let client = CoreClient::connect(&core.socket).or_else(|| connect(&core));
        let client = client.expect("the core listens");
        Self {
            dir: data,
            robot,
            core: Some(core),
            client,
            runs: 0,
            run: KnownRun::default(),
            counted: 0,
            questions: 0,
        }
    }

    fn run_id(&self) -> RunId {
        RunId(Uuid::from_u128(1_000 + self.runs))
    }

    /// One kill, the next start, and all checks.
    fn run_case(&mut self, rng: &mut Rng, row: &mut CaseReport) -> Result<(), String> {
        self.begin_run_if_none()?;
        let moment = Moment::draw(rng);
        row.what = format!("core at {moment:?}");
        self.wait_for(moment)?;
        let before = self.shown();
        row.what = format!("core at {moment:?}: {before}");
        self.kill_and_start(row)?;
        self.check_goes_on()?;
        if self.is_ended() { self.check_ended() } else { self.answer(rng) }
    }

    fn begin_run_if_none(&mut self) -> Result<(), String> {
        if self.runs > 0 && !self.is_ended() {
            return Ok(());
        }
        if self.runs > 0 {
            self.check_ended()?;
        }
        self.runs += 1;
        self.run = KnownRun::default();
        let (run, mission, mode) = (self.run_id(), MISSION, StartMode::Queue);
        self.client.command(Command::Mission(MissionCommandKind::Start { run, mission, mode }))
    }

    /// Waits for the moment of a kill, or the end of the run.
    fn wait_for(&mut self, moment: Moment) -> Result<(), String> {
        let run = self.run_id();
        let (started, mut changes, mut last) = (Instant::now(), 0, None);
        let notices = self.client.state.notices.len();
        self.client.until("the moment of the kill", |state| {
            let now = run_of(state, run).map(|run| (run.state, states(run)));
            if now != last {
                (changes, last) = (changes + 1, now);
            }
            let is_now = match moment {
                Moment::Time(time) => started.elapsed() >= time,
                Moment::Change(wanted) => changes > wanted,
                Moment::Message => state.notices.iter().skip(notices).any(|text| is_message(text)),
            };
            // People answer a question after the next start.
            is_now || has_ended(state, run) || run_of(state, run).is_some_and(|run| run.question.is_some())
        })
    }

    fn kill_and_start(&mut self, row: &mut CaseReport) -> Result<(), String> {
        let core = self.core.take().ok_or("there is no core")?;
        core.kill();
        let started = Instant::now();
        let core = CoreProcess::start_with(&self.dir, &self.robot);
        let client = connect(&core).ok_or("the core did not start")?;
        row.start = Some(started.elapsed());
        self.core = Some(core);
        // What the killed core had sent is read to its end.
        let state = std::mem::replace(&mut self.client, client).read_to_end();
        self.learn(&state);
        self.counted = 0;
        if started.elapsed() > START_LIMIT {
            return Err(format!("the start took {:.1} s", started.elapsed().as_secs_f64()));
        }
        self.client.until("the state of missions", |state| state.missions.is_some())
    }

    /// Takes what a core has shown.
    fn learn(&mut self, state: &CoreState) {
        for text in state.notices.iter().skip(self.counted).filter(|text| is_message(text)) {
            *self.run.messages.entry(text.clone()).or_default() += 1;
        }
        self.counted = state.notices.len();
        let tasks = run_of(state, self.run_id()).into_iter().flat_map(|run| &run.tasks);
        self.run.done.extend(tasks.filter(|task| task.state == TaskState::Succeeded).map(|task| task.task));
    }

    /// Waits until the run goes on, asks, or has ended, with all that was done.
    fn check_goes_on(&mut self) -> Result<(), String> {
        let run = self.run_id();
        let goes_on = |run: &RunStatus| {
            matches!(run.state, RunState::Running | RunState::Ending) || run.question.is_some()
        };
        let is_going = |state: &CoreState| has_ended(state, run) || run_of(state, run).is_some_and(goes_on);
        let outcome = self.client.until("the run goes on", is_going);
        outcome.map_err(|error| {
            let CoreState { localisation, motion, notices, .. } = &self.client.state;
            format!("{error}; {}; {localisation:?}; {motion:?}; {notices:?}", self.shown())
        })?;
        let Some(status) = run_of(&self.client.state, run) else { return Ok(()) };
        let undone = status
            .tasks
            .iter()
            .find(|task| self.run.done.contains(&task.task) && task.state != TaskState::Succeeded);
        match undone {
            Some(task) => Err(format!("a task was done and is not any more: {task:?}")),
            None => Ok(()),
        }
    }

    /// A person answers the question of the run, if there is one.
    fn answer(&mut self, rng: &mut Rng) -> Result<(), String> {
        let run = self.run_id();
        let Some(status) = run_of(&self.client.state, run).cloned() else { return Ok(()) };
        let Some(task) = status.question else { return Ok(()) };
        self.questions += 1;
        let asked = status.tasks.iter().find(|known| known.task == task);
        let is_right = asked.is_some_and(|task| {
            task.action.as_deref() == Some("message") && task.failure == Some(TaskFailure::OutcomeUnknown)
        });
        if !is_right {
            return Err(format!("a question about {asked:?}"));
        }
        let answer = if rng.uniform() < 0.5 { QuestionAnswer::TryAgain } else { QuestionAnswer::Skip };
        match answer {
            QuestionAnswer::TryAgain => *self.run.repeated.entry(task).or_default() += 1,
            _ => drop(self.run.skipped.insert(task)),
        }
        self.client.command(Command::Mission(MissionCommandKind::Answer(run, task, answer)))?;
        self.client.until("the question is closed", |state| {
            has_ended(state, run) || run_of(state, run).is_some_and(|run| run.question.is_none())
        })
    }

    /// Checks the run that has ended: it was done to its end, and no message was sent more often than people wanted.
    fn check_ended(&mut self) -> Result<(), String> {
        let state = self.client.state.clone();
        self.learn(&state);
        let run = self.run_id();
        let ended = state.missions.iter().flat_map(|missions| &missions.ended).find(|ended| ended.run == run);
        let wanted =
            if self.run.skipped.is_empty() { RunState::Succeeded } else { RunState::PartiallySucceeded };
        if ended.map(|ended| ended.outcome) != Some(wanted) {
            let last = state.last_run.iter().filter(|last| last.run == run).flat_map(|last| &last.tasks);
            let others: Vec<_> = last.filter(|task| task.state != TaskState::Succeeded).collect();
            let notices = &state.notices;
            return Err(format!("the run ended as {ended:?} and not as {wanted:?}; {others:?}; {notices:?}"));
        }
        for task in (1..TASKS).step_by(2) {
            let times = self.run.messages.get(&message_of(task)).copied().unwrap_or(0);
            let allowed = 1 + self.run.repeated.get(&task_id(task)).copied().unwrap_or(0);
            if times > allowed {
                return Err(format!("message {task} was sent {times} times, and people wanted {allowed}"));
            }
        }
        Ok(())
    }

    fn is_ended(&self) -> bool {
        has_ended(&self.client.state, self.run_id())
    }

    /// State of the run, for the report.
    fn shown(&self) -> String {
        match run_of(&self.client.state, self.run_id()) {
            Some(run) => {
                let at = run.tasks.iter().position(|task| !task.state.is_outcome());
                let state = at.map(|at| run.tasks[at].state);
                format!("run {:?}, task {at:?} {state:?}", run.state)
            }
            None => "the run has ended".to_owned(),
        }
    }

    /// Ends the last run, and checks what is in the ledger of all of them.
    fn check_ledger(mut self) -> Result<(), String> {
        let run = self.run_id();
        while !self.is_ended() {
            self.client.until("the end of the last run", |state| {
                has_ended(state, run) || run_of(state, run).is_some_and(|run| run.question.is_some())
            })?;
            self.answer(&mut RngTree::new(0).rng())?;
        }
        self.check_ended()?;
        self.core.take().ok_or("there is no core")?.stop();
        let failed = |error: store::StoreError| error.to_string();
        let (ledger, _) = Store::open(&self.dir).and_then(|store| store.open_ledger()).map_err(failed)?;
        for number in 1..=self.runs {
            let run = RunId(Uuid::from_u128(1_000 + number));
            let succeeded: Vec<u32> = ledger
                .steps(run, None, 999)
                .map_err(failed)?
                .into_iter()
                .filter(|step| step.state == "succeeded")
                .map(|step| step.step)
                .collect();
            let results: Vec<u32> = ledger
                .results(run, None, 999)
                .map_err(failed)?
                .into_iter()
                .map(|result| result.step)
                .collect();
            let once: BTreeSet<u32> = results.iter().copied().collect();
            if results != succeeded || once.len() != results.len() {
                return Err(format!(
                    "run {number}: steps {succeeded:?} succeeded, and steps {results:?} have results"
                ));
            }
        }
        eprintln!("{} runs, {} questions", self.runs, self.questions);
        Ok(())
    }
}

/// Connects to a core that starts.
fn connect(core: &CoreProcess) -> Option<CoreClient> {
    let started = Instant::now();
    while started.elapsed() < 4 * START_LIMIT {
        if let Some(client) = CoreClient::connect(&core.socket) {
            return Some(client);
        }
        // A pause between checks, so that they leave the CPU to the core.
        std::thread::sleep(Duration::from_millis(2));
    }
    None
}

fn is_message(text: &str) -> bool {
    (0..TASKS).any(|task| text == message_of(task))
}

fn run_of(state: &CoreState, run: RunId) -> Option<&RunStatus> {
    state.missions.as_ref()?.runs.iter().find(|known| known.run == run)
}

fn has_ended(state: &CoreState, run: RunId) -> bool {
    state.missions.iter().flat_map(|missions| &missions.ended).any(|ended| ended.run == run)
}

fn states(run: &RunStatus) -> Vec<TaskState> {
    run.tasks.iter().map(|task| task.state).collect()
}
