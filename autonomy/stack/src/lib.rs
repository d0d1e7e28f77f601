//! The whole autonomy behind one entrance: [`Stack::step`].
//!
//! The stack is a pure, single-threaded, clockless function of its inputs: the only time it knows is `at`, and the only
//! way anything reaches it is an [`Input`]. What it wants done comes out as [`StackEffect`]s. A recording of the inputs
//! therefore repeats a run bit for bit.

mod control;
mod localisation_phase;
mod loop_texts;
mod mapping_messages;
mod mapping_phase;
mod odometry_adapter;
mod prior_map;
mod sensor_monitor;
mod texts;
mod work;

pub use prior_map::encode_prior_keyframe;
pub use work::ComputeJob;

use control::{Admission, Control};
use executive::{Executive, ExecutiveConfig, Frames, Situation};
use geometry::{Isometry, isometry_from_pose, pose_from_isometry, vec_to_plain};
use localisation::{DockRegistry, InitialPose, LocalisationTransition};
use localisation_phase::{LocalisationPhase, dock_registry, plain_docks};
use mapping::Odometer;
use mapping_messages::rows;
use mapping_phase::{MapUpdate, MappingEvents, MappingPhase};
use messages::{
    BootRecord, Command, CommandKind, CorrectedScan, Estimate, ExecutiveEvent, Finding, Input, Job, JobDone,
    JobResult, Notice, PriorMap, Publication, RobotProfile, Sensor, Severity, StackEffect,
};
use odometry_adapter::{LocatedScan, OdometryAdapter, OdometryEvent};
use sensor_monitor::SensorMonitor;
use std::sync::Arc;
use vocab::{Covariance6, MapId, Span, Stamp};

/// Scans teach the terrain at most this often: people walk 0.3 m in between.
const OBSERVE_EVERY: Span = Span::from_millis(180);

/// State of the robot's autonomy.
#[derive(Debug, Default)]
pub struct Stack {
    running: Option<Box<Running>>,
    has_warned: bool,
}

/// Everything that exists once the boot record is known.
#[derive(Debug)]
struct Running {
    odometry: OdometryAdapter,
    control: Control,
    sensors: SensorMonitor,
    mapping: MappingPhase,
    localisation: LocalisationPhase,
    docks: DockRegistry,
    executive: Executive,
    jobs: u64,
    /// The job that saves a map, and which.
    saving: Option<(u64, MapId)>,
    points_used: u32,
    odometer: Odometer,
    last: Option<Box<LocatedScan>>,
    observed: Option<Stamp>,
}

impl Stack {
    /// A stack that has heard nothing yet. The first input must be [`Input::Boot`].
    pub fn new() -> Self {
        Self::default()
    }

    /// The only way in. `at` is the only clock and never decreases; effects are appended in the order to be done.
    pub fn step(&mut self, at: Stamp, input: Input, effects: &mut Vec<StackEffect>) {
        match (&mut self.running, input) {
            (running, Input::Boot(record)) => {
                let started = running.insert(Box::new(Running::boot(&record)));
                started.publish_initial_state(at, &record, effects);
            }
            (Some(running), Input::Tick) => running.tick(at, effects),
            (Some(running), Input::Sensor(sensor)) => running.sensor(at, &sensor, effects),
            (Some(running), Input::Command(command)) => running.answer_command(at, &command, effects),
            (Some(running), Input::JobDone(done)) => running.job_done(at, done, effects),
            (None, _) if !self.has_warned => {
                self.has_warned = true;
                effects.push(notice(at, Severity::Error, texts::NO_BOOT_RECORD.to_owned()));
            }
            // Nothing in the stack depends on these yet; they are part of the log's schema.
            (
                Some(_),
                Input::WallClock { .. }
                | Input::Committed { .. }
                | Input::ActionFeedback { .. }
                | Input::ActionDone { .. },
            )
            | (None, _) => {}
        }
    }

    /// What a job takes that a step has just started; none if nothing but its description is needed, or it was fetched
    /// before. Changes nothing that a later step depends on: a replay never calls this.
    pub fn take_compute_job(&mut self, job: u64) -> Option<ComputeJob> {
        let running = self.running.as_mut()?;
        running.localisation.take_compute_job(job).or_else(|| running.mapping.take_compute_job(job))
    }
}

impl Running {
    fn boot(record: &BootRecord) -> Self {
        let mut mapping = MappingPhase::new(record);
        if let Some(session) = record.start_mapping {
            // A fresh phase is idle, so this cannot be refused.
            let _ = mapping.start(session);
        }
        let mut localisation = LocalisationPhase::default();
        if let Some(last) = record.last_pose.filter(|_| record.start_mapping.is_none()) {
            localisation
                .start(last.map, isometry_from_pose(&last.map_from_base).map(InitialPose::MapFromBase));
        }
        Self {
            odometry: OdometryAdapter::new(record),
            control: Control::default(),
            sensors: SensorMonitor::default(),
            mapping,
            localisation,
            docks: dock_registry(&record.docks),
            executive: Executive::new(ExecutiveConfig::default(), &profile(record)),
            jobs: 0,
            saving: None,
            points_used: 0,
            odometer: Odometer::default(),
            last: None,
            observed: None,
        }
    }

    fn publish_initial_state(&mut self, at: Stamp, record: &BootRecord, effects: &mut Vec<StackEffect>) {
        for finding in OdometryAdapter::mounting_findings(record) {
            self.sensors.add_finding(finding);
        }
        publish(effects, Publication::Control(self.control.state().clone()));
        publish(effects, Publication::Docks(plain_docks(&self.docks)));
        self.start_jobs(effects);
        self.publish_changes(at, effects);
    }

    fn sensor(&mut self, at: Stamp, sensor: &Sensor, effects: &mut Vec<StackEffect>) {
        self.sensors.on_message(at, sensor);
        if let Sensor::Battery(battery) = sensor {
            self.docks.set_charging(battery.charging);
            publish(effects, Publication::Battery(*battery));
        }
        let mut said = Vec::new();
        self.odometry.update(sensor, &mut said);
        self.handle_odometry_events(at, said, effects);
    }

    /// Works through what odometry said.
    fn handle_odometry_events(
        &mut self,
        at: Stamp,
        said: Vec<OdometryEvent>,
        effects: &mut Vec<StackEffect>,
    ) {
        for one in said {
            match one {
                OdometryEvent::FrameReset => {
                    self.executive.surroundings().clear();
                    self.notify_executive(at, ExecutiveEvent::OdometryRestarted, effects);
                }
                OdometryEvent::Scan(located) => self.handle_scan(at, located, effects),
                OdometryEvent::Finding(finding) => {
                    self.publish_finding(at, &finding, effects);
                    self.sensors.add_finding(finding);
                }
            }
        }
    }

    fn publish_finding(&self, at: Stamp, finding: &Finding, effects: &mut Vec<StackEffect>) {
        effects.push(notice(at, finding.severity, format!("{} {}", finding.what, finding.remedy)));
    }

    fn handle_scan(&mut self, at: Stamp, located: Box<LocatedScan>, effects: &mut Vec<StackEffect>) {
        if self.mapping.is_starting() {
            self.replace_map(at, effects);
        }
        let grown = self.mapping.add(&located);
        let turn = self.localisation.update(&located, self.mapping.sensor(), &self.docks);
        self.publish_transition(at, turn, effects);
        let map_from_base = self.map_from_odom() * located.odom_from_base;
        if self.docks.update(at, self.localisation.localised_map().map(|map| (map, map_from_base))) {
            publish(effects, Publication::Docks(plain_docks(&self.docks)));
        }
        self.odometer.move_to(&located.odom_from_base.translation.vector);
        self.points_used = located.points_used;
        if !located.is_dead_reckoned && self.observed.is_none_or(|last| located.stamp - last >= OBSERVE_EVERY)
        {
            self.observed = Some(located.stamp);
            let sensor = self.mapping.sensor();
            let surroundings = self.executive.surroundings();
            surroundings.insert_scan(at, &located.odom_from_base, sensor, &located.cloud.xyz);
        }
        publish(effects, Publication::Estimate(self.estimate(&located, &map_from_base)));
        publish(
            effects,
            Publication::Scan(CorrectedScan {
                stamp: located.stamp,
                map_from_base: pose_from_isometry(&map_from_base),
                cloud: Arc::clone(&located.cloud),
            }),
        );
        match grown {
            Some(MapUpdate::Keyframe { keyframe, graph, events }) => {
                publish(effects, Publication::Keyframe(keyframe));
                effects.extend(graph.map(StackEffect::Publish));
                let events = MappingEvents { is_graph_changed: false, ..events };
                self.publish_mapping(at, events, effects);
            }
            Some(MapUpdate::Localised) => {
                let events =
                    MappingEvents { is_localised: true, is_graph_changed: true, ..MappingEvents::default() };
                self.publish_mapping(at, events, effects);
            }
            None => {}
        }
        self.start_jobs(effects);
        if let Some(quality) = self.mapping.quality(at) {
            publish(effects, Publication::Quality(quality));
        }
        self.last = Some(located);
        self.publish_changes(at, effects);
        self.report(at, effects);
    }

    /// Publishes what changed in the map under construction, and starts the next comparisons.
    fn publish_mapping(&mut self, at: Stamp, events: MappingEvents, effects: &mut Vec<StackEffect>) {
        if events.is_localised {
            self.notify_executive(at, ExecutiveEvent::MapReplaced, effects);
            effects.push(notice(at, Severity::Info, texts::LOCALISED_IN_EXTENDED_MAP.to_owned()));
        }
        for decision in events.decisions {
            publish(effects, Publication::LoopDecided(decision));
        }
        if let Some(reanchored) = events.reanchored {
            publish(effects, Publication::Reanchored(reanchored));
        }
        if events.is_graph_changed {
            effects.extend(self.mapping.graph_changes().map(StackEffect::Publish));
        }
        if let Some(text) = events.warning {
            effects.push(notice(at, Severity::Warning, text));
        }
        self.start_jobs(effects);
    }

    fn start_jobs(&mut self, effects: &mut Vec<StackEffect>) {
        self.mapping.start_jobs(&mut self.jobs, effects);
        self.localisation.start_jobs(&mut self.jobs, effects);
    }

    /// Publishes that the pose in a saved map was found or lost.
    fn publish_transition(
        &mut self,
        at: Stamp,
        transition: Option<LocalisationTransition>,
        effects: &mut Vec<StackEffect>,
    ) {
        let (severity, text) = match transition {
            Some(LocalisationTransition::PoseFound) if !self.localisation.is_localised() => {
                (Severity::Info, texts::POSE_CANDIDATE_FOUND)
            }
            Some(LocalisationTransition::PoseFound) => {
                let has_waited = self.executive.is_recovering();
                self.notify_executive(at, ExecutiveEvent::PlaceFound, effects);
                let text = match has_waited {
                    true => texts::LOCALISED_GOAL_GOES_ON,
                    false => texts::LOCALISED,
                };
                (Severity::Info, text)
            }
            Some(LocalisationTransition::PoseLost) => {
                self.notify_executive(at, ExecutiveEvent::PlaceLost, effects);
                let text = match self.executive.is_recovering() {
                    true => texts::LOCALISATION_LOST_UNDER_GOAL,
                    false => texts::LOCALISATION_LOST,
                };
                (Severity::Warning, text)
            }
            None => return,
        };
        effects.push(notice(at, severity, text.to_owned()));
    }

    /// Where odometry's frame is in the map that is in use.
    fn map_from_odom(&self) -> Isometry {
        self.localisation.map_from_odom().unwrap_or_else(|| self.mapping.map_from_odom())
    }

    fn estimate(&self, located: &LocatedScan, map_from_base: &Isometry) -> Estimate {
        Estimate {
            stamp: located.stamp,
            map_from_base: pose_from_isometry(map_from_base),
            velocity: located.velocity,
            covariance: Covariance6(rows(&self.localisation.covariance().unwrap_or(located.covariance))),
            degenerate: located.degenerate.map(|direction| direction.map(|d| vec_to_plain(&d))),
            distance: self.odometer.distance(),
        }
    }

    fn tick(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        self.localisation.tick(at, self.odometry.is_tracking());
        let predicted = self.last.as_ref().map(|last| self.odometry.predict(at, last));
        let frames = self.frames(predicted.as_deref());
        self.executive.update(at, &self.situation(frames), effects);
        if let Some(located) = predicted {
            publish(effects, Publication::Estimate(self.estimate(&located, &frames.map_from_base())));
        }
        self.save_closed_map(at, effects);
        self.publish_changes(at, effects);
        self.report(at, effects);
    }

    fn report(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        if let Some(health) = self.sensors.report(at, self.points_used) {
            publish(effects, Publication::Health(health));
        }
    }

    fn publish_changes(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        if let Some(state) = self.mapping.changed() {
            publish(effects, Publication::Mapping(state));
        }
        if let Some(state) = self.localisation.take_changed_state() {
            publish(effects, Publication::Localisation(state));
        }
        let frames = self.frames(self.last.as_deref());
        self.executive.publish_changes(at, &frames, effects);
    }

    /// With the base at its last place; at the origin before the first.
    fn frames(&self, last: Option<&LocatedScan>) -> Frames {
        Frames {
            map_from_odom: self.map_from_odom(),
            odom_from_base: last.map_or_else(Isometry::identity, |last| last.odom_from_base),
        }
    }

    /// What the executive reads, now.
    fn situation(&self, frames: Frames) -> Situation {
        Situation {
            frames,
            is_in_saved_map: !self.localisation.is_idle(),
            is_place_known: self.localisation.is_localised(),
            is_place_sought: self.localisation.is_unconfirmed(),
            exploration_hint: self.localisation.exploration_hint(),
        }
    }

    fn notify_executive(&mut self, at: Stamp, event: ExecutiveEvent, effects: &mut Vec<StackEffect>) {
        let situation = self.situation(self.frames(self.last.as_deref()));
        self.executive.handle_event(at, event, &situation, effects);
    }

    /// Another map's frame from now on: what was known of the ground is looked at anew, and goals end.
    fn replace_map(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        self.executive.surroundings().clear();
        self.notify_executive(at, ExecutiveEvent::MapReplaced, effects);
    }

    fn answer_command(&mut self, at: Stamp, command: &Command, effects: &mut Vec<StackEffect>) {
        let owner = self.control.state().owner;
        let refused = match self.control.admit(command) {
            Admission::Repeated(answer) => {
                effects.push(StackEffect::Answer { id: command.id, to: command.by.client, refused: answer });
                return;
            }
            Admission::Refused(reason) => Some(reason),
            Admission::Granted { changed } => {
                if changed {
                    publish(effects, Publication::Control(self.control.state().clone()));
                    if owner.is_some() && owner != self.control.state().owner {
                        self.notify_executive(at, ExecutiveEvent::LeaseLost, effects);
                    }
                }
                self.handle_command(at, command, effects).err()
            }
        };
        self.control.answered(command.id, refused.clone());
        effects.push(StackEffect::Answer { id: command.id, to: command.by.client, refused });
        self.publish_changes(at, effects);
    }

    fn handle_command(
        &mut self,
        at: Stamp,
        command: &Command,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        match &command.kind {
            CommandKind::TakeControl { .. } | CommandKind::ReleaseControl => Ok(()),
            CommandKind::StartMapping(session) => {
                self.mapping.start(*session)?;
                self.localisation.stop();
                Ok(())
            }
            CommandKind::ExtendMap { session, map } => {
                self.mapping.extend(*session, *map)?;
                self.localisation.stop();
                self.start_jobs(effects);
                Ok(())
            }
            CommandKind::Localise { map, at: place } => {
                if !self.mapping.is_idle() {
                    return Err(texts::MAPPING_RUNS.to_owned());
                }
                let unsound = || texts::POSE_NOT_FINITE.to_owned();
                let place =
                    place.as_ref().map(|it| isometry_from_pose(it).ok_or_else(unsound)).transpose()?;
                let walked = || {
                    self.last
                        .as_ref()
                        .and_then(|last| self.mapping.map_from_odom_of(*map, last))
                        .map(InitialPose::MapFromOdom)
                };
                self.localisation.start(*map, place.map(InitialPose::MapFromBase).or_else(walked));
                self.replace_map(at, effects);
                self.start_jobs(effects);
                Ok(())
            }
            CommandKind::LeaveMap => {
                self.localisation.stop();
                self.replace_map(at, effects);
                Ok(())
            }
            CommandKind::DiscardMapping => self.mapping.discard(),
            CommandKind::FinishMapping { map, name } => {
                let mut said = Vec::new();
                self.odometry.flush(&mut said);
                self.handle_odometry_events(at, said, effects);
                self.mapping.finish(at, *map, name)?;
                self.save_closed_map(at, effects);
                Ok(())
            }
            CommandKind::Teleoperate(velocity) => {
                let situation = self.situation(self.frames(self.last.as_deref()));
                self.executive.drive(at, *velocity, command.by.clone(), &situation, effects)
            }
            CommandKind::StartGoal { goal, kind } => {
                let situation = self.situation(self.frames(self.last.as_deref()));
                let goal = (*goal, *kind, command.by.clone());
                self.executive.start_goal(at, goal, &situation, effects)
            }
            CommandKind::CancelGoal(goal) => {
                let situation = self.situation(self.frames(self.last.as_deref()));
                self.executive.cancel_goal(at, *goal, command.by.clone(), &situation, effects);
                Ok(())
            }
            CommandKind::StopMotion => {
                let situation = self.situation(self.frames(self.last.as_deref()));
                self.executive.stop(at, command.by.clone(), &situation, effects);
                Ok(())
            }
            CommandKind::AllowMotion => {
                self.notify_executive(at, ExecutiveEvent::MotionAllowed, effects);
                Ok(())
            }
            CommandKind::AcceptLoop { .. }
            | CommandKind::RejectLoop { .. }
            | CommandKind::ProposeLoop { .. } => {
                let events = self.mapping.handle_loop_command(&command.kind)?;
                self.publish_mapping(at, events, effects);
                Ok(())
            }
        }
    }

    fn loaded(&mut self, at: Stamp, job: u64, read: Result<&PriorMap, &str>, effects: &mut Vec<StackEffect>) {
        for refused in [self.mapping.loaded(job, read), self.localisation.finish_loading(job, read)] {
            if let Err(text) = refused {
                effects.push(notice(at, Severity::Error, text));
            }
        }
    }

    /// Starts saving the map of a session that has been ended, when it is ready for it.
    fn save_closed_map(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        if let Some(finished) = self.mapping.closed(at) {
            self.saving = Some((self.jobs, finished.map));
            effects.push(StackEffect::StartJob { job: self.jobs, work: Job::SaveMap(Arc::new(finished)) });
            self.jobs += 1;
        }
    }

    fn job_done(&mut self, at: Stamp, done: JobDone, effects: &mut Vec<StackEffect>) {
        match done.result {
            JobResult::Relocalised(answer) => {
                let turn = self.localisation.finish_relocalisation(done.job, Some(&answer));
                self.publish_transition(at, turn, effects);
            }
            JobResult::DisambiguationPlanned(told) => {
                self.localisation.finish_disambiguation(done.job, Some(&told))
            }
            JobResult::LoopVerified(_) | JobResult::RevisitCompared(_) | JobResult::MapSearched(_) => {
                let events = self.mapping.complete_job(&done);
                self.publish_mapping(at, events, effects);
                self.save_closed_map(at, effects);
            }
            JobResult::MapLoaded(known) => self.loaded(at, done.job, Ok(&known), effects),
            JobResult::MapSaved { map, .. } => {
                self.mapping.saved(map, true);
                effects.push(notice(at, Severity::Info, texts::MAP_SAVED.to_owned()));
            }
            JobResult::Failed { reason } => self.job_failed(at, done.job, &reason, effects),
        }
        self.publish_changes(at, effects);
    }

    /// Tells whoever started a job that it was not done.
    fn job_failed(&mut self, at: Stamp, job: u64, reason: &str, effects: &mut Vec<StackEffect>) {
        if let Some((_, map)) = self.saving.take_if(|(saving, _)| *saving == job) {
            self.mapping.saved(map, false);
            effects.push(notice(at, Severity::Error, texts::map_not_saved(reason)));
            return;
        }
        self.localisation.finish_relocalisation(job, None);
        self.localisation.finish_disambiguation(job, None);
        self.loaded(at, job, Err(&texts::map_not_usable(reason)), effects);
        let failed = JobDone { job, result: JobResult::Failed { reason: reason.to_owned() } };
        let events = self.mapping.complete_job(&failed);
        self.publish_mapping(at, events, effects);
        self.save_closed_map(at, effects);
    }
}

/// The robot's profile, with the standing height that the recording says.
fn profile(record: &BootRecord) -> RobotProfile {
    let mut profile = record.profile.clone();
    profile.standing_height_m = record.mounting.standing_height.unwrap_or(profile.standing_height_m);
    profile
}

fn publish(effects: &mut Vec<StackEffect>, publication: Publication) {
    effects.push(StackEffect::Publish(publication));
}

fn notice(at: Stamp, severity: Severity, text: String) -> StackEffect {
    StackEffect::Publish(Publication::Notice(Notice { at, severity, text }))
}
