//! Connects all parts of the autonomy behind one function: [`Stack::step`].
//!
//! The stack is a pure, single-threaded, clockless function of its inputs. Its only time is `at`, and everything enters it as an [`Input`]. It
//! returns [`StackEffect`]s, which the caller executes. A recording of the inputs therefore repeats a run bit for bit.

mod commits;
mod control;
mod localisation_phase;
mod loop_texts;
mod map_loading;
mod map_name;
mod mapping_events;
mod mapping_messages;
mod mapping_phase;
mod mission_phase;
mod odometry_adapter;
mod prior_map;
mod quality_schedule;
mod running_session;
mod sensor_monitor;
#[cfg(test)]
mod testing;
mod texts;
mod waiting_answers;
mod work;

pub use map_name::map_name;
pub use prior_map::{MapPreparation, PreparedMap, encode_prior_keyframe};
pub use work::ComputeJob;

use commits::Commits;
use control::{Admission, ControlArbiter};
use executive::{Executive, ExecutiveConfig, Frames, Situation};
use geometry::{Isometry, isometry_from_pose, pose_from_isometry, vec_to_plain};
use localisation::{DockRegistry, InitialPose, LocalisationTransition};
use localisation_phase::{LocalisationPhase, dock_registry, plain_docks};
use mapping::Odometer;
use mapping_events::{MapUpdate, MappingEvents};
use mapping_messages::rows;
use mapping_phase::MappingPhase;
use messages::{
    BootRecord, Command, CommandKind, CorrectedScan, Estimate, ExecutiveEvent, Finding, Input, JobDone,
    JobId, JobOwner, JobResult, LedgerEvent, Notice, Publication, RobotProfile, Sensor, Severity,
    StackEffect, StopLatch,
};
use mission_phase::{MissionPhase, goal_request};
use odometry_adapter::{LocatedScan, OdometryAdapter, OdometryEvent};
use sensor_monitor::SensorMonitor;
use std::sync::Arc;
use vocab::{ClientId, CommandId, Covariance6, Span, Stamp};

/// Parameters of the [`Stack`] itself. The parts have their own.
#[derive(Clone, Copy, Debug, PartialEq)]
struct StackConfig {
    /// Shortest time between two scans that are inserted into the elevation map. A person walks 0.3 m in it. Chosen: every second sweep at 10 Hz, which halves the time
    /// that the map costs.
    elevation_map_period: Span,
}

impl Default for StackConfig {
    fn default() -> Self {
        Self { elevation_map_period: Span::from_millis(180) }
    }
}

/// State of the robot's autonomy.
#[derive(Debug, Default)]
pub struct Stack {
    running: Option<Box<Running>>,
    has_warned: bool,
}

/// State after the boot record.
#[derive(Debug)]
struct Running {
    config: StackConfig,
    odometry: OdometryAdapter,
    control: ControlArbiter,
    commits: Commits,
    sensors: SensorMonitor,
    mapping: MappingPhase,
    localisation: LocalisationPhase,
    docks: DockRegistry,
    executive: Executive,
    missions: MissionPhase,
    /// Number of the next job.
    jobs: u64,
    /// A saved map that the next step may get.
    prepared_map: Option<PreparedMap>,
    points_used: u32,
    odometer: Odometer,
    /// The last located scan.
    last: Option<Box<LocatedScan>>,
    /// Stamp of the last scan that was inserted into the elevation map.
    last_in_elevation_map: Option<Stamp>,
}

impl Stack {
    /// A stack before its first input, which must be [`Input::Boot`].
    pub fn new() -> Self {
        Self::default()
    }

    /// Handles one input. `at` is the only clock and never decreases. Effects are appended in the order in which they must be executed.
    pub fn step(&mut self, at: Stamp, input: Input, effects: &mut Vec<StackEffect>) {
        if let Some(running) = &mut self.running {
            running.process_waypoint(at, effects);
        }
        match (&mut self.running, input) {
            (running, Input::Boot(record)) => {
                let started = running.insert(Box::new(Running::boot(&record)));
                started.publish_initial_state(at, &record, effects);
            }
            (Some(running), Input::Tick) => running.tick(at, effects),
            (Some(running), Input::Sensor(sensor)) => running.sensor(at, &sensor, effects),
            (Some(running), Input::Command(command)) => running.answer_command(at, &command, effects),
            (Some(running), Input::JobDone(done)) => running.job_done(at, done, effects),
            (Some(running), Input::GraphRequested) => {
                effects.extend(running.mapping.whole_graph().map(StackEffect::Publish));
            }
            (Some(running), Input::Committed { seq }) => running.committed(at, seq, effects),
            (None, _) if !self.has_warned => {
                self.has_warned = true;
                effects.push(notice(at, Severity::Error, texts::NO_BOOT_RECORD.to_owned()));
            }
            (Some(running), input) => running.mission_input(at, input, effects),
            (None, _) => {}
        }
        if let Some(running) = &mut self.running {
            running.settle_missions(at, effects);
        }
    }

    /// How the map that a job reads is to be prepared; none if it reads none.
    pub fn map_preparation(&self, job: JobId) -> Option<MapPreparation> {
        let sensor = self.running.as_ref()?.mapping.sensor();
        match job.owner {
            JobOwner::MapExtension => Some(MapPreparation::Extension { sensor }),
            JobOwner::Localisation => Some(MapPreparation::Localisation),
            _ => None,
        }
    }

    /// Hands over the prepared form of a map, before the step that gets the map. That step is shorter then, and its effects are the same: a replay
    /// never calls this.
    pub fn supply_prepared_map(&mut self, prepared: PreparedMap) {
        if let Some(running) = &mut self.running {
            running.prepared_map = Some(prepared);
        }
    }

    /// What a job takes that a step has just started; none if nothing but its description is needed, or it was fetched
    /// before. Changes nothing that a later step depends on: a replay never calls this.
    pub fn take_compute_job(&mut self, job: JobId) -> Option<ComputeJob> {
        let Running { mapping, localisation, .. } = &mut **self.running.as_mut()?;
        match job.owner {
            JobOwner::LoopClosing => mapping.take_comparison(job.number),
            JobOwner::MapSearch => mapping.take_search(job.number),
            JobOwner::Relinearisation => mapping.take_relinearisation(job.number),
            JobOwner::MapQuality => mapping.take_quality(job.number),
            JobOwner::Relocalisation | JobOwner::Disambiguation => localisation.take_compute_job(job.number),
            JobOwner::MapSaving | JobOwner::MapExtension | JobOwner::Localisation => None,
        }
    }
}

impl Running {
    fn boot(record: &BootRecord) -> Self {
        let mut mapping = MappingPhase::new(record);
        if let Some(session) = record.start_mapping {
            // A new phase is idle, so this is not refused.
            let _ = mapping.start(session);
        }
        let mut localisation = LocalisationPhase::default();
        if let Some(last) = record.last_pose.filter(|_| record.start_mapping.is_none()) {
            localisation
                .start(last.map, isometry_from_pose(&last.map_from_base).map(InitialPose::MapFromBase));
        }
        let mut executive = {
            let profile = profile(record);
            Executive::new(ExecutiveConfig::new(&profile), &profile)
        };
        if let Some(latch) = &record.stop_latch {
            executive.restore_stop(latch.by.as_ref().map(|by| by.client));
        }
        Self {
            config: StackConfig::default(),
            odometry: OdometryAdapter::new(record),
            control: ControlArbiter::default(),
            commits: Commits::default(),
            sensors: SensorMonitor::default(),
            mapping,
            localisation,
            docks: dock_registry(&record.docks),
            executive,
            missions: MissionPhase::default(),
            jobs: 0,
            prepared_map: None,
            points_used: 0,
            odometer: Odometer::default(),
            last: None,
            last_in_elevation_map: None,
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
            self.mission_battery(at, *battery, effects);
        }
        let mut events = Vec::new();
        self.odometry.update(sensor, &mut events);
        self.handle_odometry_events(at, events, effects);
    }

    /// Handles events of the odometry in their order.
    fn handle_odometry_events(
        &mut self,
        at: Stamp,
        events: Vec<OdometryEvent>,
        effects: &mut Vec<StackEffect>,
    ) {
        for event in events {
            match event {
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
        // One input may have several scans. The waypoint of the previous one is added before this one is handled.
        self.process_waypoint(at, effects);
        if self.mapping.is_starting() {
            self.replace_map(at, effects);
        }
        self.mapping.add(&located);
        let transition = self.localisation.update(&located, self.mapping.sensor(), &self.docks);
        self.publish_transition(at, transition, effects);
        let map_from_base = self.map_from_odom() * located.odom_from_base;
        if self.docks.update(at, self.localisation.localised_map().map(|map| (map, map_from_base))) {
            publish(effects, Publication::Docks(plain_docks(&self.docks)));
        }
        self.odometer.move_to(&located.odom_from_base.translation.vector);
        self.points_used = located.points_used;
        if !located.is_dead_reckoned {
            self.executive.observe_scan(at, &located.odom_from_base, &located.cloud.xyz);
        }
        let period = self.config.elevation_map_period;
        let is_due = self.last_in_elevation_map.is_none_or(|last| located.stamp - last >= period);
        if !located.is_dead_reckoned && is_due {
            self.last_in_elevation_map = Some(located.stamp);
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
        self.start_jobs(effects);
        self.mapping.start_quality(at, effects);
        self.last = Some(located);
        self.publish_changes(at, effects);
        self.report(at, effects);
    }

    /// Adds the last scan to the map, if that scan is a waypoint. This takes as long as locating the scan. It is done with the next input, before that
    /// is handled, so that no input waits for both. Nothing happens in between, so the map is the same as if it were done at once.
    fn process_waypoint(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        match self.mapping.process_waypoint() {
            Some(MapUpdate::Keyframe { keyframe, graph, events }) => {
                publish(effects, Publication::Keyframe(keyframe));
                effects.extend(graph.map(StackEffect::Publish));
                let events = MappingEvents { is_graph_changed: false, ..events };
                self.publish_mapping(at, events, effects);
            }
            Some(MapUpdate::NoKeyframe(events)) => self.publish_mapping(at, events, effects),
            None => return,
        }
        self.publish_changes(at, effects);
    }

    /// Publishes the changes of the map under construction, and starts the next comparisons.
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
                self.notify_executive(at, ExecutiveEvent::PoseFound, effects);
                let text = match has_waited {
                    true => texts::LOCALISED_GOAL_GOES_ON,
                    false => texts::LOCALISED,
                };
                (Severity::Info, text)
            }
            Some(LocalisationTransition::PoseLost) => {
                self.notify_executive(at, ExecutiveEvent::PoseLost, effects);
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

    /// Pose of the odometry's frame in the map in use.
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
            distance_m: self.odometer.distance(),
        }
    }

    fn tick(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        self.localisation.tick(at, self.odometry.is_tracking());
        let predicted = self.last.as_ref().map(|last| self.odometry.predict(at, last));
        let frames = self.frames(predicted.as_deref());
        self.executive.update(at, &self.situation(frames), effects);
        // A leg of a route that has ended now has not to be taken for the next one.
        self.handle_goal_events(at, effects);
        if let Some(located) = predicted {
            publish(effects, Publication::Estimate(self.estimate(&located, &frames.map_from_base())));
        }
        self.mapping.close(at, &mut self.jobs, effects);
        self.tick_missions(at, &frames, effects);
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

    /// Frames with the base at its last pose. Before the first scan it is at the origin.
    fn frames(&self, last: Option<&LocatedScan>) -> Frames {
        Frames {
            map_from_odom: self.map_from_odom(),
            odom_from_base: last.map_or_else(Isometry::identity, |last| last.odom_from_base),
        }
    }

    /// Present state of localisation, as the executive reads it.
    fn situation(&self, frames: Frames) -> Situation {
        Situation {
            frames,
            is_in_saved_map: !self.localisation.is_idle(),
            is_localised: self.localisation.is_localised(),
            is_pose_unconfirmed: self.localisation.is_unconfirmed(),
            exploration_hint: self.localisation.exploration_hint(),
        }
    }

    fn notify_executive(&mut self, at: Stamp, event: ExecutiveEvent, effects: &mut Vec<StackEffect>) {
        let situation = self.situation(self.frames(self.last.as_deref()));
        self.executive.handle_event(at, event, &situation, effects);
    }

    /// The map frame is another one from now on: clears the elevation map, and ends goals.
    fn replace_map(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        self.executive.surroundings().clear();
        self.notify_executive(at, ExecutiveEvent::MapReplaced, effects);
    }

    /// Answers a command after it was executed.
    fn answer(
        &mut self,
        id: CommandId,
        to: ClientId,
        refused: Option<String>,
        effects: &mut Vec<StackEffect>,
    ) {
        self.control.keep_answer(id, refused.clone());
        effects.push(StackEffect::Answer { id, to, refused });
    }

    /// What commands changed is durable: they are answered.
    fn committed(&mut self, at: Stamp, seq: u64, effects: &mut Vec<StackEffect>) {
        for (id, client) in self.commits.end(seq) {
            self.answer(id, client, None, effects);
        }
        self.missions_committed(at, seq, effects);
    }

    fn answer_command(&mut self, at: Stamp, command: &Command, effects: &mut Vec<StackEffect>) {
        if self.commits.is_waiting(command.id) || self.missions.is_waiting(command.id) {
            return;
        }
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
        match (refused, latch_change(command)) {
            // The runner answers it.
            (None, None) if matches!(command.kind, CommandKind::Mission(_)) => {}
            (None, Some(event)) => effects.push(self.commits.begin(command, event)),
            (refused, _) => self.answer(command.id, command.by.client, refused, effects),
        }
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
            CommandKind::Localise { map, at: given } => {
                if !self.mapping.is_idle() {
                    return Err(texts::MAPPING_RUNS.to_owned());
                }
                let not_finite = || texts::POSE_NOT_FINITE.to_owned();
                let map_from_base =
                    given.as_ref().map(|pose| isometry_from_pose(pose).ok_or_else(not_finite)).transpose()?;
                let from_mapping = || {
                    self.last
                        .as_ref()
                        .and_then(|last| self.mapping.map_from_odom_of(*map, last))
                        .map(InitialPose::MapFromOdom)
                };
                let initial_pose = map_from_base.map(InitialPose::MapFromBase).or_else(from_mapping);
                self.localisation.start(*map, initial_pose);
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
                let mut events = Vec::new();
                self.odometry.flush(&mut events);
                self.handle_odometry_events(at, events, effects);
                self.process_waypoint(at, effects);
                self.mapping.finish(at, *map, name)?;
                self.mapping.close(at, &mut self.jobs, effects);
                Ok(())
            }
            CommandKind::Teleoperate(velocity) => {
                let situation = self.situation(self.frames(self.last.as_deref()));
                self.executive.drive(at, *velocity, command.by.clone(), &situation, effects)
            }
            CommandKind::StartGoal { goal, kind } => {
                let goal = (*goal, *kind, command.by.clone());
                match goal_request(*kind) {
                    Some(request) => self.start_route(at, goal, request, effects),
                    None => {
                        let situation = self.situation(self.frames(self.last.as_deref()));
                        self.executive.start_goal(at, goal, &situation, effects)
                    }
                }
            }
            CommandKind::CancelGoal(goal) => {
                let situation = self.situation(self.frames(self.last.as_deref()));
                self.executive.cancel_goal(at, *goal, command.by.clone(), &situation, effects);
                Ok(())
            }
            CommandKind::Mission(kind) => self.mission_command(at, command, *kind, effects),
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

    /// Hands the result of a job to its owner.
    fn job_done(&mut self, at: Stamp, done: JobDone, effects: &mut Vec<StackEffect>) {
        let JobDone { number, result } = done;
        match result {
            JobResult::MapSaving(result) => {
                if self.mapping.finish_saving(number, &result) {
                    effects.push(match &result {
                        Ok(_) => notice(at, Severity::Info, texts::MAP_SAVED.to_owned()),
                        Err(failure) => notice(at, Severity::Error, texts::map_not_saved(&failure.reason)),
                    });
                }
            }
            JobResult::MapExtension(read) => {
                let supplied = self.prepared_map.take();
                let refused = self.mapping.finish_loading(number, &read, supplied).err();
                effects.extend(refused.map(|text| notice(at, Severity::Error, text)));
            }
            JobResult::LoopClosing(result) => {
                let events = self.mapping.finish_comparison(number, &result);
                self.publish_mapping(at, events, effects);
                self.mapping.close(at, &mut self.jobs, effects);
            }
            JobResult::MapSearch(result) => {
                let events = self.mapping.finish_search(number, &result);
                self.publish_mapping(at, events, effects);
            }
            JobResult::Relinearisation(result) => {
                let warning = self.mapping.finish_relinearisation(number, &result, effects);
                effects.extend(warning.map(|text| notice(at, Severity::Warning, text)));
            }
            JobResult::MapQuality(result) => {
                let quality = self.mapping.finish_quality(number, result);
                effects.extend(quality.map(|quality| StackEffect::Publish(Publication::Quality(quality))));
            }
            JobResult::Localisation(read) => {
                let supplied = self.prepared_map.take();
                let refused = self.localisation.finish_loading(number, &read, supplied).err();
                effects.extend(refused.map(|text| notice(at, Severity::Error, text)));
            }
            JobResult::Relocalisation(answer) => {
                let transition = self.localisation.finish_relocalisation(number, &answer);
                self.publish_transition(at, transition, effects);
            }
            JobResult::Disambiguation(plan) => self.localisation.finish_disambiguation(number, &plan),
        }
        self.publish_changes(at, effects);
    }
}

/// What a command changes that must survive a restart of the program.
fn latch_change(command: &Command) -> Option<LedgerEvent> {
    match command.kind {
        CommandKind::StopMotion => {
            Some(LedgerEvent::StopLatch(Some(StopLatch { by: Some(command.by.clone()) })))
        }
        CommandKind::AllowMotion => Some(LedgerEvent::StopLatch(None)),
        _ => None,
    }
}

/// The robot's profile, with the standing height of the recording if it has one.
fn profile(record: &BootRecord) -> RobotProfile {
    let mut profile = record.profile.clone();
    profile.standing_height_m = record.mounting.standing_height_m.unwrap_or(profile.standing_height_m);
    profile
}

fn publish(effects: &mut Vec<StackEffect>, publication: Publication) {
    effects.push(StackEffect::Publish(publication));
}

fn notice(at: Stamp, severity: Severity, text: String) -> StackEffect {
    StackEffect::Publish(Publication::Notice(Notice { at, severity, text }))
}
