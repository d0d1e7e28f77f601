//! The thread that performs actions.

use super::aim::{AimFailure, PictureParameters, aim, sight_line};
use super::own_action::{
    Capture, MESSAGE, MessageParameters, OWN_ACTIONS, OwnAction, OwnActionKind, POINT_CLOUD, TimedParameters,
    WAIT,
};
use super::{ActionConfig, ActionInbox, ActionRequest, SightChecker, failed};
use crate::clock::{CalendarTime, RobotClock};
use crate::gauges::{GaugeAnswer, GaugePicture, GaugeQueue};
use crate::mailbox::Mailbox;
use crate::state_publisher::StatePublisher;
use crate::texts;
use api::{Event, OfferedAction};
use crossbeam_channel::{Receiver, Sender, select};
use messages::{ActionOutcome, CorrectedScan, Input, RegisteredAction, Severity};
use ports::{
    ActionCall, ActionEnd, ActionEvent, ActionFile, ActionRegistration, ActionServer, ReadGauge,
    error_with_causes,
};
use serde::de::DeserializeOwned;
use site_model::{
    ACTION_CATALOGUE, ActionReport, GaugeDial, GaugeReport, LineOfSight, MAX_MESSAGE_CHARS, Parameters,
    ReportFile, ReportTime, describe_action,
};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use store::{BlobError, BlobsConfig, Store};
use vocab::{ActionCallId, BlobHash, CameraHead, Span, Stamp, Vec3, legible};
use watchdog::{BEAT_PERIOD, Heartbeat};

/// A point cloud in a file.
const CLOUD_NAME: &str = "cloud.pcd";
const CLOUD_MEDIA_TYPE: &str = "application/vnd.pcd";

/// Performs actions.
pub struct ActionWorker {
    pub config: ActionConfig,
    pub blobs: BlobsConfig,
    pub store: Arc<Store>,
    /// Performs the robot's actions, if it has any.
    pub robot: Option<Arc<dyn ActionServer>>,
    /// The head of the robot's cameras.
    pub camera_head: CameraHead,
    /// The LiDAR in the base, metres.
    pub base_from_lidar_m: Vec3,
    pub inbox: ActionInbox,
    /// Ends and feedback, for the stack.
    pub results: Sender<Input>,
    pub mailbox: Arc<Mailbox>,
    pub state_publisher: Arc<StatePublisher>,
    pub clock: Arc<RobotClock>,
    pub open: OpenActions,
    pub sight: SightChecker,
    /// Reads gauges in pictures; none reads none.
    pub gauges: Option<GaugeQueue>,
}

/// Actions that are under way.
#[derive(Default)]
pub struct OpenActions {
    /// Those of the robot, with what its camera is aimed at.
    robot: BTreeMap<ActionCallId, Target>,
    own: BTreeMap<ActionCallId, OwnAction>,
    /// Reports of those whose picture is stored and whose gauge is being read.
    reading: BTreeMap<ActionCallId, ActionReport>,
    /// When the last feedback of each was passed on.
    feedback_at: BTreeMap<ActionCallId, Stamp>,
}

impl OpenActions {
    fn contains(&self, call: ActionCallId) -> bool {
        self.robot.contains_key(&call) || self.own.contains_key(&call) || self.reading.contains_key(&call)
    }

    fn len(&self) -> usize {
        self.robot.len() + self.own.len() + self.reading.len()
    }
}

/// What a camera is aimed at, if it is aimed at something.
#[derive(Clone, Debug, Default)]
struct Target {
    /// Metres, map frame.
    target_m: Option<Vec3>,
    line_of_sight: Option<LineOfSight>,
    /// The gauge that is read in the picture.
    gauge: Option<GaugeDial>,
}

/// How a call was begun.
enum ActionStart {
    /// It goes on.
    Open,
    /// It is done already.
    Done(ActionOutcome),
}

impl ActionWorker {
    /// Works until the control loop ends.
    pub fn run(mut self, heartbeat: &Heartbeat) {
        let silent = crossbeam_channel::never();
        let events: Receiver<ActionEvent> = self.robot.as_ref().map_or(silent, |robot| robot.events());
        let (requests, scans) = (self.inbox.requests.clone(), self.inbox.scans.clone());
        let silent = crossbeam_channel::never();
        let gauges: Receiver<GaugeAnswer> =
            self.gauges.as_ref().map_or(silent, |gauges| gauges.answers.clone());
        // The control loop may have ended.
        let offered = self.offered();
        let registered = offered.iter().map(|action| RegisteredAction {
            name: action.name.clone(),
            is_idempotent: action.is_idempotent,
            expected: action.expected,
        });
        let _ = self.results.send(Input::ActionsRegistered(registered.collect()));
        self.state_publisher.publish(Event::Actions(offered));
        loop {
            heartbeat.beat();
            let wait = if self.open.own.is_empty() { BEAT_PERIOD } else { self.config.poll_period };
            select! {
                recv(requests) -> request => match request {
                    Ok(ActionRequest::Call { call, action, parameters }) => self.call(call, &action, &parameters),
                    Ok(ActionRequest::Cancel(call)) => self.cancel(call),
                    Err(_) => return self.end_all(),
                },
                recv(events) -> event => if let Ok(event) = event {
                    self.handle_event(event);
                },
                recv(scans) -> scan => if let Ok(scan) = scan {
                    self.add_scan(&scan);
                },
                recv(gauges) -> answer => match answer {
                    Ok((call, read)) => self.end_reading(call, read),
                    // The core ends.
                    Err(_) => return self.end_all(),
                },
                default(wait) => {}
            }
            self.end_own_actions();
            // While nobody waits for an action.
            if self.open.len() == 0
                && let Some(map) = self.inbox.places.map().filter(|_| self.robot.is_some())
            {
                self.sight.prepare(map);
            }
        }
    }

    /// The actions that can be asked for: the robot's, those of the core itself, and docking, which tasks of missions do without a call.
    fn offered(&self) -> Vec<OfferedAction> {
        let robots = self.robot.iter().flat_map(|robot| robot.actions());
        // One that the robot offers too is the robot's.
        let mut all: Vec<OfferedAction> = robots.map(offered_by_robot).collect();
        let docking = ACTION_CATALOGUE.iter().filter(|action| action.moves_robot);
        for action in OWN_ACTIONS.into_iter().filter_map(describe_action).chain(docking) {
            if all.iter().all(|known| known.name != action.name) {
                all.push(OfferedAction {
                    name: action.name.to_owned(),
                    title: action.title.to_owned(),
                    parameter_schema: action.parameter_schema(&self.camera_head),
                    expected: Span::from_secs_f64(action.expected_time_s(&Parameters::new())),
                    expected_energy_j: action.expected_energy_j(&Parameters::new()).round() as u32,
                    is_idempotent: action.is_idempotent,
                });
            }
        }
        all
    }

    fn call(&mut self, call: ActionCallId, action: &str, parameters: &str) {
        // A call that is repeated is the same one.
        if self.open.contains(call) {
            return;
        }
        let begun = if self.open.len() >= self.config.max_open {
            Err(texts::TOO_MANY_ACTIONS.to_owned())
        } else if let Some(robot) = self.robot.clone().filter(|robot| offers(&**robot, action)) {
            self.call_robot(&*robot, call, action, parameters)
        } else {
            self.begin_own(call, action, parameters)
        };
        match begun {
            Ok(ActionStart::Open) => {}
            Ok(ActionStart::Done(outcome)) => self.end(call, outcome),
            Err(reason) => self.end(call, ActionOutcome::Failed { reason }),
        }
    }

    /// Begins an action of the robot. Its camera is aimed here, by the robot's own estimate.
    fn call_robot(
        &mut self,
        robot: &dyn ActionServer,
        call: ActionCallId,
        action: &str,
        parameters: &str,
    ) -> Result<ActionStart, String> {
        let (mut parameters, mut target) = (parameters.to_owned(), Target::default());
        if takes_pictures(action) {
            let head = self.camera_head;
            let asked: PictureParameters = parse(&parameters)?;
            let place = self.inbox.places.at(self.clock.now());
            let aim = match aim(&self.config.aim, &head, &asked, place.as_ref()) {
                Ok(aim) => aim,
                Err(AimFailure::BeyondPan { turn_rad }) if asked.target_m.is_some() => {
                    return Ok(ActionStart::Done(ActionOutcome::NeedsTurn { turn_rad }));
                }
                Err(failure) => return Err(failure.sentence()),
            };
            let line = sight_line(&head, &asked, place.as_ref());
            target.line_of_sight = line.and_then(|(map, ends)| self.sight.check(map, ends));
            target.target_m = asked.target_m.map(Vec3::from);
            target.gauge = asked.gauge;
            self.report_obstacle(call, &target);
            // Plain numbers always become JSON.
            parameters = serde_json::to_string(&aim).unwrap_or_default();
        }
        // Before the robot answers, which may be at once.
        self.open.robot.insert(call, target);
        let started = robot.start(ActionCall { id: call, action: action.to_owned(), parameters });
        started.map(|()| ActionStart::Open).inspect_err(|_| {
            self.open.robot.remove(&call);
        })
    }

    /// Tells people that something stands between the camera and its target. The picture is taken all the same: it shows what stands there.
    fn report_obstacle(&self, call: ActionCallId, target: &Target) {
        let Some(LineOfSight { distance_m, obstacle_at_m: Some(at_m) }) = target.line_of_sight else {
            return;
        };
        let text = texts::view_blocked(target.target_m.unwrap_or_default(), at_m, distance_m);
        // It is left out while the control loop is busy; the result says it too.
        let _ = self.results.try_send(Input::ActionFeedback { call, progress: None, text: text.clone() });
        self.mailbox.notice(self.clock.now(), Severity::Warning, text);
    }

    fn begin_own(
        &mut self,
        call: ActionCallId,
        action: &str,
        parameters: &str,
    ) -> Result<ActionStart, String> {
        let default_s = describe_action(action).and_then(|known| known.duration).map_or(0.0, |(_, s)| s);
        let now = self.clock.now();
        let (kind, max_s) = match action {
            MESSAGE => {
                return self
                    .publish_message(&parse::<MessageParameters>(parameters)?.text)
                    .map(ActionStart::Done);
            }
            WAIT => (OwnActionKind::Wait, self.config.max_wait_s),
            POINT_CLOUD => (OwnActionKind::Capture(Capture::default()), self.config.max_capture_s),
            other => return Err(texts::no_action_server(other)),
        };
        let ends = now + parse::<TimedParameters>(parameters)?.duration(default_s, max_s);
        if let OwnActionKind::Capture(_) = kind {
            self.inbox.open_captures.fetch_add(1, Ordering::Relaxed);
        }
        self.open.own.insert(call, OwnAction { began: now, ends, kind });
        Ok(ActionStart::Open)
    }

    /// Publishes a notice for all people.
    fn publish_message(&self, text: &str) -> Result<ActionOutcome, String> {
        let text = legible(text.trim(), MAX_MESSAGE_CHARS as usize);
        if text.is_empty() {
            return Err(texts::EMPTY_MESSAGE.to_owned());
        }
        self.mailbox.notice(self.clock.now(), Severity::Info, text);
        Ok(self.succeeded(self.new_report()))
    }

    fn cancel(&mut self, call: ActionCallId) {
        if let Some(own) = self.open.own.remove(&call) {
            self.close(&own);
            self.end(call, ActionOutcome::Cancelled);
        } else if self.open.robot.contains_key(&call) {
            // It ends when the robot says so, or when the connection to it is lost.
            if let Some(robot) = &self.robot {
                robot.cancel(call);
            }
        } else if self.open.reading.contains_key(&call) {
            // It is done already but for the reading, and ends by itself in a moment.
        } else {
            self.end(call, ActionOutcome::Failed { reason: texts::NO_SUCH_CALL.to_owned() });
        }
    }

    /// The control loop has ended: nobody waits for anything.
    fn end_all(&mut self) {
        if let Some(robot) = &self.robot {
            self.open.robot.keys().for_each(|call| robot.cancel(*call));
        }
    }

    fn handle_event(&mut self, event: ActionEvent) {
        match event {
            ActionEvent::Feedback { call, progress, text } => {
                if self.open.robot.contains_key(&call) {
                    self.feedback(call, progress, text);
                }
            }
            ActionEvent::Ended { call, end } => {
                let Some(target) = self.open.robot.remove(&call) else { return };
                match end {
                    ActionEnd::Succeeded { report, files } => match self.complete(&report, &files, &target) {
                        Ok(report) => self.read_gauge(call, report, target.gauge),
                        Err(failed) => self.end(call, failed),
                    },
                    ActionEnd::Failed { reason } => self.end(call, ActionOutcome::Failed { reason }),
                    ActionEnd::Cancelled => self.end(call, ActionOutcome::Cancelled),
                }
            }
        }
    }

    /// Adds to the robot's report what the robot does not know, and stores its files. Fails with the end of the action.
    fn complete(
        &self,
        report: &str,
        files: &[ActionFile],
        target: &Target,
    ) -> Result<ActionReport, ActionOutcome> {
        let report: Result<ActionReport, _> = serde_json::from_str(report);
        let Ok(mut report) = report else {
            return Err(ActionOutcome::Failed { reason: texts::ROBOT_REPORT_MALFORMED.to_owned() });
        };
        report.at = self.time_at(report.at.robot_time);
        report.place = self.inbox.places.at(report.at.robot_time);
        if let Some(camera) = &mut report.camera {
            (camera.target_m, camera.line_of_sight) = (target.target_m, target.line_of_sight);
        }
        report.files.clear();
        for file in files {
            match self.store.put_blob(&file.bytes, &self.blobs) {
                Ok(blob) => {
                    let bytes = file.bytes.len() as u64;
                    report.files.push(report_file(&file.name, &file.media_type, blob, bytes));
                }
                Err(error) => return Err(not_stored(&error)),
            }
        }
        Ok(report)
    }

    /// Ends an action that has succeeded, once the gauge in its picture was read, if there is one. The picture counts whether or not that is possible.
    fn read_gauge(&mut self, call: ActionCallId, mut report: ActionReport, gauge: Option<GaugeDial>) {
        let is_picture = |file: &&ReportFile| file.media_type.starts_with("image/");
        let picture = report.files.iter().find(is_picture).map(|file| file.blob);
        if let (Some(gauges), Some(dial)) = (&self.gauges, gauge) {
            let handed_in = picture.ok_or(texts::GAUGE_WITHOUT_PICTURE).and_then(|picture| {
                let waiting = GaugePicture { call, picture, dial };
                gauges.pictures.try_send(waiting).map_err(|_| texts::TOO_MANY_GAUGES)
            });
            let Err(problem) = handed_in else {
                self.open.reading.insert(call, report);
                return;
            };
            report.gauge = Some(GaugeReport { problem: Some(problem.to_owned()), ..GaugeReport::default() });
        }
        let outcome = self.succeeded(report);
        self.end(call, outcome);
    }

    /// Ends an action with what was read in its picture, or with a sentence why nothing was.
    fn end_reading(&mut self, call: ActionCallId, read: Result<ReadGauge, String>) {
        let Some(mut report) = self.open.reading.remove(&call) else { return };
        let read = read.unwrap_or_else(|problem| ReadGauge {
            reading: None,
            report: GaugeReport { problem: Some(problem), ..GaugeReport::default() },
        });
        report.readings.extend(read.reading);
        report.gauge = Some(read.report);
        let outcome = self.succeeded(report);
        self.end(call, outcome);
    }

    fn add_scan(&mut self, scan: &CorrectedScan) {
        for action in self.open.own.values_mut() {
            if let OwnActionKind::Capture(capture) = &mut action.kind
                && scan.stamp >= action.began
            {
                capture.add(scan, self.config.max_cloud_points);
            }
        }
    }

    /// Ends actions of the core itself whose time is over, and says how far the others are.
    fn end_own_actions(&mut self) {
        let now = self.clock.now();
        let is_over = |action: &OwnAction| now >= action.ends;
        let over: Vec<ActionCallId> =
            self.open.own.iter().filter(|(_, action)| is_over(action)).map(|(call, _)| *call).collect();
        for call in over {
            let Some(action) = self.open.own.remove(&call) else { continue };
            self.close(&action);
            let outcome = match action.kind {
                OwnActionKind::Wait => self.succeeded(self.new_report()),
                OwnActionKind::Capture(capture) => self.store_cloud(&capture),
            };
            self.end(call, outcome);
        }
        let progress = |(call, action): (&ActionCallId, &OwnAction)| (*call, action.progress(now));
        let open: Vec<(ActionCallId, f32)> = self.open.own.iter().map(progress).collect();
        for (call, progress) in open {
            self.feedback(call, Some(progress), String::new());
        }
    }

    fn close(&self, action: &OwnAction) {
        if let OwnActionKind::Capture(_) = action.kind {
            self.inbox.open_captures.fetch_sub(1, Ordering::Relaxed);
        }
    }

    fn store_cloud(&self, capture: &Capture) -> ActionOutcome {
        let Some((stamp, map_from_first)) = capture.first.filter(|_| !capture.xyz.is_empty()) else {
            return ActionOutcome::Failed { reason: texts::NOTHING_SCANNED.to_owned() };
        };
        let Vec3 { x, y, z } = self.base_from_lidar_m;
        let viewpoint = [x as f32, y as f32, z as f32];
        match self.store.put_cloud_blob(viewpoint, &capture.xyz, &capture.intensity, &self.blobs) {
            Err(error) => not_stored(&error),
            Ok((blob, bytes)) => {
                // The cloud is in the frame of the base at its first scan.
                let place = self.inbox.places.at(stamp).map(|place| site_model::ReportPlace {
                    map_from_base: geometry::pose_from_isometry(&map_from_first),
                    ..place
                });
                let files = vec![report_file(CLOUD_NAME, CLOUD_MEDIA_TYPE, blob, bytes)];
                self.succeeded(ActionReport {
                    at: self.time_at(stamp),
                    place,
                    files,
                    ..ActionReport::default()
                })
            }
        }
    }

    /// A report of now.
    fn new_report(&self) -> ActionReport {
        let now = self.clock.now();
        ActionReport { at: self.time_at(now), place: self.inbox.places.at(now), ..ActionReport::default() }
    }

    /// An instant of the robot's clock on the calendar.
    fn time_at(&self, robot_time: Stamp) -> ReportTime {
        let CalendarTime { utc, is_synchronised } = CalendarTime::read_of_schedules();
        let age_ns = (self.clock.now() - robot_time).nanos().max(0);
        ReportTime { robot_time, utc_ns: utc.nanos().saturating_sub(age_ns), is_synchronised }
    }

    fn succeeded(&self, report: ActionReport) -> ActionOutcome {
        // Plain data always becomes JSON.
        ActionOutcome::Succeeded { result: serde_json::to_string(&report).unwrap_or_default() }
    }

    fn feedback(&mut self, call: ActionCallId, progress: Option<f32>, text: String) {
        let now = self.clock.now();
        let last = self.open.feedback_at.entry(call).or_insert(now);
        if now - *last < self.config.feedback_period {
            return;
        }
        *last = now;
        // It is left out while the control loop is busy.
        let _ = self.results.try_send(Input::ActionFeedback { call, progress, text });
    }

    fn end(&mut self, call: ActionCallId, outcome: ActionOutcome) {
        self.open.feedback_at.remove(&call);
        let done = match outcome {
            ActionOutcome::Failed { reason } => {
                tracing::info!("the action {call} failed: {reason}");
                failed(call, reason)
            }
            outcome => Input::ActionDone { call, outcome },
        };
        // The control loop may have ended; then nobody waits for it.
        let _ = self.results.send(done);
    }
}

fn offered_by_robot(action: ActionRegistration) -> OfferedAction {
    let ActionRegistration { name, title, parameter_schema, expected, expected_energy_j, is_idempotent } =
        action;
    OfferedAction { name, title, parameter_schema, expected, expected_energy_j, is_idempotent }
}

fn offers(robot: &dyn ActionServer, action: &str) -> bool {
    robot.actions().iter().any(|offered| offered.name == action)
}

/// Whether the camera is aimed for an action: its parameters have a target then.
fn takes_pictures(action: &str) -> bool {
    matches!(action, "photo" | "thermal_photo")
}

fn parse<T: DeserializeOwned>(parameters: &str) -> Result<T, String> {
    serde_json::from_str(parameters).map_err(|error| texts::wrong_parameters(&error))
}

fn report_file(name: &str, media_type: &str, blob: BlobHash, bytes: u64) -> ReportFile {
    ReportFile { name: name.to_owned(), media_type: media_type.to_owned(), blob, bytes }
}

fn not_stored(error: &BlobError) -> ActionOutcome {
    ActionOutcome::Failed { reason: texts::result_not_stored(&error_with_causes(error)) }
}
