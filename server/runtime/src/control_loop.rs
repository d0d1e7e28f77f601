//! The control loop: everything that can happen becomes one ordered stream of inputs, each recorded and then stepped.
//!
//! Inputs are ordered by arrival. Ticks lie on a 20 Hz grid of the robot's own clock, so that they too follow from
//! what arrives. The loop reads the computer's clock only when the link has been silent for [`ControlLoopConfig::silence_timeout`], to go on
//! ticking: a robot whose sensors have died must still be told to stop.

use crate::actions::ActionQueue;
use crate::clock::{CalendarTime, RobotClock};
use crate::incidents::Incident;
use crate::jobs::{FinishedJob, Jobs};
use crate::lease_arbiter::{DueCommand, LeaseArbiter};
use crate::ledger::LedgerQueue;
use crate::mailbox::Mailbox;
use crate::map_usage::MapUsage;
use crate::node_following::NodeFollower;
use crate::recording::RecorderQueue;
use crate::run_clouds::RunCloudQueue;
use crate::scene_changes::SceneChangeQueue;
use crate::session_journal::SessionJournalQueue;
use crate::state_publisher::StatePublisher;
use crate::texts;
use crossbeam_channel::{Receiver, select};
use messages::{
    BootRecord, Command, CommandKind, Input, JobDone, MAX_TICK_GAP, PoseInMap, Publication, Severity,
    StackEffect, TICK_PERIOD,
};
use ports::{Arrival, RobotEvent, RobotLink, SimulatedFault};
use stack::Stack;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::StoredStopLatch;
use vocab::{ClientId, CommandId, Span, Stamp};
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of the control loop, on this computer's clock.
#[derive(Clone, Copy, Debug)]
struct ControlLoopConfig {
    /// After this time without an arrival the loop ticks by itself. Chosen: twice [`messages::DRIVE_LIFETIME`], so the robot has stopped by itself. With half of it, the clock
    /// of the loop ran seconds ahead of a simulated robot on a busy computer, and its scans came late.
    silence_timeout: Duration,
    /// Time between two readings of the calendar time. Chosen: schedules are by the minute.
    wall_clock_period: Duration,
    /// Requests for simulated faults that may wait for the robot's answer. Further ones are refused. Chosen: people inject them one by one.
    max_unanswered_faults: usize,
}

const CONFIG: ControlLoopConfig = ControlLoopConfig {
    silence_timeout: Duration::from_millis(1_000),
    wall_clock_period: Duration::from_secs(1),
    max_unanswered_faults: 16,
};

/// What the thread of a link is called in reports.
const LINK_THREAD: &str = "robot-link";

/// A request that the control loop handles.
pub enum LoopRequest {
    /// Of a client, for the stack.
    Command(Command),
    /// Of a client, for the link of a simulated robot.
    InjectFault {
        /// Made by the client.
        id: CommandId,
        /// Who asks.
        by: ClientId,
        /// The fault.
        fault: SimulatedFault,
    },
    /// Of the publisher: its pose graph is not the stack's.
    WholeGraph,
}

/// What the control loop listens to.
pub struct InputSources {
    /// From the robot.
    pub arrivals: Receiver<Arrival>,
    /// Stop motion and Allow motion, from clients, in their order. They go before everything else of theirs.
    pub stops: Receiver<Command>,
    /// From clients and the publisher. Bounded.
    pub commands: Receiver<LoopRequest>,
    /// From the threads of both job lanes.
    pub finished: Receiver<FinishedJob>,
    /// From the ledger: commits that are durable, the site and its edits.
    pub ledger: Receiver<Input>,
    /// Ends and feedback of actions.
    pub actions: Receiver<Input>,
    /// Disconnected when it is time to end.
    pub stop: Receiver<()>,
}

/// What the control loop speaks to.
pub struct ControlLoop {
    pub link: Box<dyn RobotLink>,
    pub recorder: RecorderQueue,
    pub jobs: Jobs,
    pub mailbox: Arc<Mailbox>,
    pub state_publisher: Arc<StatePublisher>,
    pub lease: Arc<LeaseArbiter>,
    pub clock: Arc<RobotClock>,
    pub stack: Stack,
    /// Where the robot was before it was switched off, if it was localised then.
    pub last_pose: Option<PoseInMap>,
    pub docks: Vec<PoseInMap>,
    /// What the disk says of a stop of motion.
    pub stop_latch: StoredStopLatch,
    pub ledger: LedgerQueue,
    pub session_journal: SessionJournalQueue,
    pub actions: ActionQueue,
    pub node_follower: NodeFollower,
    pub run_clouds: RunCloudQueue,
    pub scene_changes: SceneChangeQueue,
    /// Which maps are in use.
    pub map_usage: Arc<MapUsage>,
    /// Results of jobs that failed at once. The next turn of the loop feeds all of them, so they are never more than one turn starts.
    pub refused_jobs: Vec<JobDone>,
    /// Sentences for people about what the start found on the disk.
    pub problems: Vec<String>,
}

impl ControlLoop {
    /// Runs until told to stop. Returns the loop's parts by dropping them: the link stops its robot.
    pub fn run(self, sources: &InputSources, heartbeat: &Heartbeat) {
        // The robot's clock begins with its first arrival; nothing can be stepped without an instant.
        let first = loop {
            heartbeat.beat();
            select! {
                recv(sources.arrivals) -> arrival => match arrival {
                    Ok(arrival) => break arrival,
                    Err(_) => return heartbeat.report_end_of(LINK_THREAD),
                },
                recv(sources.stop) -> _ => return,
                default(BEAT_PERIOD) => {}
            }
        };
        let mut running = Running {
            now: first.at,
            next_tick: first.at,
            wall_clock_read: None,
            replies: VecDeque::new(),
            effects: Vec::new(),
            unanswered_faults: BTreeMap::new(),
            has_link_ended: false,
            parts: self,
        };
        let docks = std::mem::take(&mut running.parts.docks).into();
        let StoredStopLatch { latch: stop_latch, problem } = running.parts.stop_latch.clone();
        for text in problem.into_iter().chain(std::mem::take(&mut running.parts.problems)) {
            running.parts.mailbox.notice(running.now, Severity::Error, text);
        }
        let last_pose = running.parts.last_pose;
        let boot = BootRecord { last_pose, docks, stop_latch, ..running.parts.link.boot() };
        running.feed(Input::Boot(Box::new(boot)));
        running.arrival(first);
        running.run(sources, heartbeat);
    }
}

struct Running {
    parts: ControlLoop,
    /// Instant of the last input.
    now: Stamp,
    next_tick: Stamp,
    /// When the calendar time was read last, on this computer's monotonic clock.
    wall_clock_read: Option<Instant>,
    /// Inputs that answer effects of the last step.
    replies: VecDeque<Input>,
    /// Kept for its memory.
    effects: Vec<StackEffect>,
    /// Simulated faults that the robot was asked for, by the client's number.
    unanswered_faults: BTreeMap<CommandId, (ClientId, SimulatedFault)>,
    /// Whether the link has said that nothing more comes.
    has_link_ended: bool,
}

impl Running {
    fn run(&mut self, sources: &InputSources, heartbeat: &Heartbeat) {
        let silent = crossbeam_channel::never();
        let mut arrivals = &sources.arrivals;
        loop {
            heartbeat.beat();
            self.read_wall_clock();
            // Not at once in the step that started them: a stack that starts a refused job anew must not keep the loop from its robot.
            for done in std::mem::take(&mut self.parts.refused_jobs) {
                self.feed(Input::JobDone(done));
            }
            let now = self.parts.clock.now();
            if let Some(due) = self.parts.lease.due(now, Instant::now()) {
                self.feed_due(due);
            }
            sources.stops.try_iter().for_each(|stop| self.feed(Input::Command(stop)));
            let heard = Instant::now();
            select! {
                recv(sources.stops) -> stop => if let Ok(stop) = stop {
                    self.feed(Input::Command(stop));
                },
                recv(arrivals) -> arrival => match arrival {
                    Ok(arrival) => self.arrival(arrival),
                    // Commands and jobs go on, and so does time.
                    Err(_) => {
                        if !self.has_link_ended {
                            heartbeat.report_end_of(LINK_THREAD);
                        }
                        arrivals = &silent;
                    }
                },
                recv(sources.commands) -> request => match request {
                    Ok(LoopRequest::Command(command)) => {
                        // Edits are applied before commands, so that a command finds the objects of an edit that was answered.
                        sources.ledger.try_iter().for_each(|input| self.feed(input));
                        self.feed(Input::Command(command));
                    }
                    Ok(LoopRequest::InjectFault { id, by, fault }) => self.inject_fault(id, by, fault),
                    Ok(LoopRequest::WholeGraph) => self.feed(Input::GraphRequested),
                    Err(_) => {}
                },
                recv(sources.finished) -> finished => if let Ok(FinishedJob { done, prepared }) = finished {
                    if let Some(prepared) = prepared {
                        self.parts.stack.supply_prepared_map(prepared);
                    }
                    self.feed(Input::JobDone(done));
                },
                recv(sources.ledger) -> input => if let Ok(input) = input {
                    self.feed(input);
                },
                recv(sources.actions) -> input => if let Ok(input) = input {
                    self.feed(input);
                },
                recv(sources.stop) -> _ => return,
                default(CONFIG.silence_timeout) => self.tick_until(self.now + span(heard.elapsed())),
            }
        }
    }

    /// Gives the stack a command of the lease's arbiter, with an entry in the audit log if a person asked for it.
    fn feed_due(&mut self, due: DueCommand) {
        let DueCommand { command, caller } = due;
        if let (Some(audit), Some(caller), CommandKind::TakeControl { name }) =
            (self.parts.state_publisher.audit(), caller, &command.kind)
        {
            let take = api::Command::TakeControl { name: name.clone() };
            audit.begin(command.id, &command.by, &caller, &take);
        }
        self.feed(Input::Command(command));
    }

    /// Gives the stack the calendar time, if that is due.
    fn read_wall_clock(&mut self) {
        let now = Instant::now();
        if self.wall_clock_read.is_none_or(|read| now - read >= CONFIG.wall_clock_period) {
            self.wall_clock_read = Some(now);
            self.feed(wall_clock());
        }
    }

    fn arrival(&mut self, arrival: Arrival) {
        self.tick_until(arrival.at);
        match arrival.event {
            RobotEvent::Sensor(sensor) => self.feed(Input::Sensor(sensor)),
            RobotEvent::Clock => {}
            RobotEvent::FaultAnswered { id, refused } => self.fault_answered(id, refused),
            RobotEvent::Disconnected(why) => {
                self.parts.mailbox.notice(self.now, Severity::Warning, why);
                self.refuse_unanswered_faults();
            }
            RobotEvent::Reconnected => {
                let text = texts::ROBOT_RECONNECTED.to_owned();
                self.parts.mailbox.notice(self.now, Severity::Info, text);
            }
            RobotEvent::Ended(why) => {
                self.has_link_ended = true;
                self.parts.mailbox.notice(self.now, Severity::Info, why);
            }
        }
    }

    /// Brings the clock to `at` (or leaves it, if `at` is past) with all ticks that lie on the way.
    fn tick_until(&mut self, at: Stamp) {
        if at - self.next_tick > MAX_TICK_GAP {
            self.next_tick = at;
        }
        while self.next_tick <= at {
            self.now = self.now.max(self.next_tick);
            self.next_tick += TICK_PERIOD;
            self.feed(Input::Tick);
        }
        self.now = self.now.max(at);
    }

    /// Asks the robot for a simulated fault.
    fn inject_fault(&mut self, id: CommandId, by: ClientId, fault: SimulatedFault) {
        let asked = if self.unanswered_faults.len() < CONFIG.max_unanswered_faults {
            self.parts.link.inject_fault(id, fault)
        } else {
            Err(texts::TOO_MANY_FAULTS.to_owned())
        };
        match asked {
            Ok(()) => drop(self.unanswered_faults.insert(id, (by, fault))),
            Err(reason) => self.parts.state_publisher.answer(id, by, Some(reason)),
        }
    }

    /// Passes the robot's answer on. A fault that was injected is published, so that nobody takes it for a real one.
    fn fault_answered(&mut self, id: CommandId, refused: Option<String>) {
        let Some((by, fault)) = self.unanswered_faults.remove(&id) else {
            return;
        };
        if refused.is_none() {
            let severity = Severity::Info;
            let text = texts::fault_injected(fault);
            self.parts.recorder.report(Incident { at: self.now, text: text.clone() });
            self.parts.mailbox.notice(self.now, severity, text);
        }
        self.parts.state_publisher.answer(id, by, refused);
    }

    fn refuse_unanswered_faults(&mut self) {
        for (id, (by, _)) in std::mem::take(&mut self.unanswered_faults) {
            self.parts.state_publisher.answer(id, by, Some(texts::ROBOT_NOT_ANSWERING.to_owned()));
        }
    }

    /// Records one input, steps the stack with it, and does what the stack wants done.
    fn feed(&mut self, input: Input) {
        self.step(input);
        while let Some(reply) = self.replies.pop_front() {
            self.step(reply);
        }
    }

    fn step(&mut self, input: Input) {
        self.parts.clock.set(self.now);
        self.parts.recorder.record(self.now, &input);
        self.parts.stack.step(self.now, input, &mut self.effects);
        // Before their jobs are handed in, so that no map is deleted that one of them reads.
        for effect in &self.effects {
            if let StackEffect::Publish(publication) = effect {
                self.parts.map_usage.update(publication);
            }
        }
        for effect in self.effects.drain(..) {
            self.replies.extend(self.parts.execute(effect));
        }
    }
}

impl ControlLoop {
    /// Does what the stack wants done. Returns the input that answers it, if it is answered at once.
    fn execute(&mut self, effect: StackEffect) -> Option<Input> {
        match effect {
            StackEffect::Drive(drive) => self.link.drive(drive),
            StackEffect::StartJob { job, work } => {
                self.refused_jobs.extend(self.jobs.start_for(&mut self.stack, job, work));
            }
            StackEffect::Publish(publication) => {
                if let Publication::Keyframe(keyframe) = &publication {
                    self.jobs.write_cloud(keyframe.clone());
                }
                self.session_journal.record(&publication);
                self.actions.watch(&publication);
                self.node_follower.watch(&publication);
                self.run_clouds.watch(&publication);
                self.scene_changes.watch(&publication);
                self.recorder.watch(self.clock.now(), &publication);
                self.mailbox.post(publication);
            }
            StackEffect::Answer { id, to, refused } => self.state_publisher.answer(id, to, refused),
            StackEffect::Commit { seq, events } => return self.ledger.commit(seq, events),
            StackEffect::CallAction { call, action, parameters } => {
                return self.actions.call(call, action, parameters);
            }
            StackEffect::CancelAction(call) => self.actions.cancel(call),
        }
        None
    }
}

/// The calendar time as the computer has it.
fn wall_clock() -> Input {
    let CalendarTime { utc, is_synchronised } = CalendarTime::read_of_schedules();
    Input::WallClock { utc_ns: utc.nanos(), synchronised: is_synchronised }
}

fn span(duration: Duration) -> Span {
    Span::from_nanos(i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX))
}
