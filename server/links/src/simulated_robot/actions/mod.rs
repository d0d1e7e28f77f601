//! Actions of the simulated robot. The simulation's thread takes snapshots of the instants that matter and goes on; pictures are rendered and readings are made
//! on another thread.

mod picture;
mod worker;

use crate::stoppable_thread::{StoppableThread, Stopped};
use crate::texts;
use crossbeam_channel::{Receiver, Sender, TryRecvError};
use ports::{ActionCall, ActionEnd, ActionEvent, ActionRegistration, MAX_OPEN_ACTIONS};
use serde::Deserialize;
use sim::{CameraConfig, Simulator};
use site_model::describe_action;
use std::collections::BTreeMap;
use std::io;
use vocab::{ActionCallId, CameraAim, CameraHead, Span, Stamp};
use worker::{ActionJob, FinishedAction, Instrument, PictureKind, Worker};

/// Limits of the actions of a simulated robot.
#[derive(Clone, Copy, Debug)]
struct SimulatedActionConfig {
    /// Actions that may be under way at a time. It is that of all action servers.
    max_open: usize,
    /// Jobs that may wait for the other thread. Readings that find the queue full are made a little later. Chosen: two of each open action.
    max_queued_jobs: usize,
    /// Time between two readings of an instrument, on the robot's clock. Chosen: instruments give a reading a second.
    sample_period: Span,
    /// Longest time of a measurement. Chosen: an hour, longer than any measurement on a round.
    max_duration: Span,
    /// An aim that differs by more than this from what the head can take is refused, radians and steps of zoom. Chosen: above the rounding of a double.
    aim_tolerance: f64,
}

const CONFIG: SimulatedActionConfig = SimulatedActionConfig {
    max_open: MAX_OPEN_ACTIONS,
    max_queued_jobs: 32,
    sample_period: Span::from_millis(1_000),
    max_duration: Span::from_millis(3_600_000),
    aim_tolerance: 1e-6,
};

/// The actions that a simulated robot performs, by their names in the catalogue.
const PHOTO: &str = "photo";
const THERMAL_PHOTO: &str = "thermal_photo";
const TEMPERATURE_HUMIDITY: &str = "temperature_humidity";
const GAMMA_SPECTRUM: &str = "gamma_spectrum";

/// What a robot with this camera head says of its actions.
pub(super) fn registrations(head: &CameraHead) -> Vec<ActionRegistration> {
    let names = [PHOTO, THERMAL_PHOTO, TEMPERATURE_HUMIDITY, GAMMA_SPECTRUM];
    let described = names.into_iter().filter_map(describe_action);
    let registration = |action: &site_model::ActionDescription| ActionRegistration {
        name: action.name.to_owned(),
        title: action.title.to_owned(),
        parameter_schema: action.parameter_schema(head),
        expected: Span::from_secs_f64(action.expected_time_s(&site_model::Parameters::new())),
        expected_energy_j: action.expected_energy_j(&site_model::Parameters::new()).round() as u32,
        is_idempotent: action.is_idempotent,
    };
    described.map(registration).collect()
}

/// The simulation's end of all actions.
pub(super) struct ActionRunner {
    cameras: CameraConfig,
    open: BTreeMap<ActionCallId, OpenAction>,
    /// What the core is to be told.
    events: Vec<ActionEvent>,
    jobs: Sender<ActionJob>,
    finished: Receiver<FinishedAction>,
    _thread: StoppableThread,
}

/// An action that has not ended.
enum OpenAction {
    /// The other thread ends it.
    Ending,
    /// An instrument measures.
    Measuring(Measurement),
}

/// An instrument measures for a time.
#[derive(Clone, Copy)]
struct Measurement {
    instrument: Instrument,
    began: Stamp,
    ends: Stamp,
    /// Until when readings were made.
    sampled: Stamp,
}

/// Parameters of an action that takes a time.
#[derive(Deserialize)]
struct TimedParameters {
    duration_s: Option<f64>,
}

impl ActionRunner {
    pub(super) fn spawn(simulator: &Simulator) -> io::Result<Self> {
        let (jobs, waiting) = crossbeam_channel::bounded(CONFIG.max_queued_jobs);
        // Every open action ends once.
        let (finished_sender, finished) = crossbeam_channel::unbounded();
        let worker = Worker::new(simulator.site(), *simulator.cameras());
        let thread = StoppableThread::start("robot-actions", move |stop| {
            worker.run(&waiting, &finished_sender, &stop);
        })?;
        let cameras = *simulator.cameras();
        Ok(Self { cameras, open: BTreeMap::new(), events: Vec::new(), jobs, finished, _thread: thread })
    }

    /// Begins an action. One that is under way already goes on.
    pub(super) fn start(&mut self, call: ActionCall, simulator: &mut Simulator) {
        if self.open.contains_key(&call.id) {
            return;
        }
        let begun = match call.action.as_str() {
            _ if self.open.len() >= CONFIG.max_open => Err(texts::TOO_MANY_ACTIONS.to_owned()),
            PHOTO => self.begin_picture(&call, PictureKind::Photo, simulator),
            THERMAL_PHOTO => self.begin_picture(&call, PictureKind::Thermal, simulator),
            TEMPERATURE_HUMIDITY => begin_measurement(&call, Instrument::Air, simulator.now()),
            GAMMA_SPECTRUM => begin_measurement(&call, Instrument::Gamma, simulator.now()),
            other => Err(texts::no_such_action(other)),
        };
        match begun {
            Ok(action) => drop(self.open.insert(call.id, action)),
            Err(reason) => self.end(call.id, ActionEnd::Failed { reason }),
        }
    }

    fn begin_picture(
        &self,
        call: &ActionCall,
        kind: PictureKind,
        simulator: &mut Simulator,
    ) -> Result<OpenAction, String> {
        let asked: CameraAim =
            serde_json::from_str(&call.parameters).map_err(|error| texts::wrong_parameters(&error))?;
        let aim = self.cameras.clamped(&asked);
        let differences = [aim.pan_rad - asked.pan_rad, aim.tilt_rad - asked.tilt_rad, aim.zoom - asked.zoom];
        if differences.iter().any(|difference| difference.abs() > CONFIG.aim_tolerance) {
            return Err(texts::OUT_OF_REACH.to_owned());
        }
        let (snapshot, at) = (simulator.camera_snapshot(), simulator.now());
        let job = ActionJob::Picture { call: call.id, kind, aim, snapshot: Box::new(snapshot), at };
        self.jobs.try_send(job).map_err(|_| texts::TOO_MANY_ACTIONS.to_owned())?;
        Ok(OpenAction::Ending)
    }

    /// Ends an action before it is done. What the other thread still finds is left out.
    pub(super) fn cancel(&mut self, call: ActionCallId) {
        let end = match self.open.remove(&call) {
            Some(_) => ActionEnd::Cancelled,
            None => ActionEnd::Failed { reason: texts::NO_SUCH_CALL.to_owned() },
        };
        self.end(call, end);
    }

    /// Ends all actions and tells nobody.
    pub(super) fn forget_all(&mut self) {
        self.open.clear();
        self.events.clear();
    }

    /// Lets instruments measure, and collects what is done. To be called after each step of the simulation.
    pub(super) fn advance(&mut self, simulator: &mut Simulator) -> Result<(), Stopped> {
        let now = simulator.now();
        let Self { open, events, jobs, .. } = self;
        for (call, action) in open.iter_mut() {
            let OpenAction::Measuring(measurement) = action else { continue };
            let due = (measurement.sampled + CONFIG.sample_period).min(measurement.ends);
            if now < due {
                continue;
            }
            let job = ActionJob::Sample {
                call: *call,
                instrument: measurement.instrument,
                snapshot: simulator.instrument_snapshot(),
                seconds: (due - measurement.sampled).secs_f64(),
                ends: (due == measurement.ends).then_some(due),
            };
            // A full queue is tried again after the next step.
            if jobs.try_send(job).is_err() {
                continue;
            }
            measurement.sampled = due;
            events.push(measurement.feedback(*call));
            if due == measurement.ends {
                *action = OpenAction::Ending;
            }
        }
        loop {
            match self.finished.try_recv() {
                Ok(FinishedAction { call, end }) => {
                    if self.open.remove(&call).is_some() {
                        self.end(call, end);
                    }
                }
                Err(TryRecvError::Empty) => return Ok(()),
                // Its thread has panicked. The process ends and is started again.
                Err(TryRecvError::Disconnected) => return Err(Stopped),
            }
        }
    }

    /// What the core is to be told since the last call.
    pub(super) fn take_events(&mut self) -> Vec<ActionEvent> {
        std::mem::take(&mut self.events)
    }

    fn end(&mut self, call: ActionCallId, end: ActionEnd) {
        self.events.push(ActionEvent::Ended { call, end });
    }
}

impl Measurement {
    fn feedback(&self, call: ActionCallId) -> ActionEvent {
        let (done, total) = ((self.sampled - self.began).secs_f64(), (self.ends - self.began).secs_f64());
        let text = texts::measuring(done, total);
        ActionEvent::Feedback { call, progress: Some((done / total) as f32), text }
    }
}

fn begin_measurement(call: &ActionCall, instrument: Instrument, now: Stamp) -> Result<OpenAction, String> {
    let asked: TimedParameters =
        serde_json::from_str(&call.parameters).map_err(|error| texts::wrong_parameters(&error))?;
    let default_s = describe_action(&call.action).and_then(|action| action.duration);
    let seconds = asked.duration_s.or(default_s.map(|(_, seconds)| seconds)).unwrap_or(1.0);
    // Not a number is the shortest time.
    let duration = Span::from_secs_f64(seconds.clamp(0.01, CONFIG.max_duration.secs_f64()));
    Ok(OpenAction::Measuring(Measurement { instrument, began: now, ends: now + duration, sampled: now }))
}
