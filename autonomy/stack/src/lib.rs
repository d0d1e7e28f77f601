//! The whole autonomy behind one entrance: [`Stack::step`].
//!
//! The stack is a pure, single-threaded, clockless function of its inputs: the only time it knows is `at`, and the only
//! way anything reaches it is an [`Input`]. What it wants done comes out as [`StackEffect`]s. A recording of the inputs
//! therefore repeats a run bit for bit.

mod control;
mod health;
mod localisation_phase;
mod loop_texts;
mod mapping_messages;
mod mapping_phase;
mod motion;
mod odometry_adapter;
mod prior_map;
mod work;

pub use prior_map::encode_prior_keyframe;
pub use work::ComputeJob;

use control::{Admission, Control};
use geometry::{Isometry, isometry_from_pose, pose_from_isometry, vec_from_plain, vec_to_plain};
use health::Watch;
use localisation::{DockRegistry, ExplorationHint, InitialPose, LocalisationTransition};
use localisation_phase::{LocalisationPhase, dock_registry, plain_docks};
use mapping::Odometer;
use mapping_messages::rows;
use mapping_phase::{MapUpdate, MappingEvents, MappingPhase};
use messages::{
    BootRecord, Command, CommandKind, CorrectedScan, Estimate, Finding, GoalKind, Input, Job, JobDone,
    JobResult, Notice, PriorMap, Publication, Sensor, Severity, StackEffect,
};
use motion::{Frames, Motion};
use odometry_adapter::{LocatedScan, OdometryAdapter, OdometryEvent};
use std::sync::Arc;
use vocab::{Covariance6, MapId, Span, Stamp};

/// Scans teach the terrain at most this often: people walk 0.3 m in between.
const OBSERVE_EVERY: Span = Span::from_millis(180);

/// State of the robot's autonomy.
#[derive(Debug, Default)]
pub struct Stack {
    running: Option<Box<Running>>,
    complained: bool,
}

/// Everything that exists once the boot record is known.
#[derive(Debug)]
struct Running {
    odometry: OdometryAdapter,
    control: Control,
    watch: Watch,
    mapping: MappingPhase,
    localisation: LocalisationPhase,
    docks: DockRegistry,
    motion: Motion,
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
                started.greet(&record, effects);
            }
            (Some(running), Input::Tick) => running.tick(at, effects),
            (Some(running), Input::Sensor(sensor)) => running.sensor(at, &sensor, effects),
            (Some(running), Input::Command(command)) => running.command(at, &command, effects),
            (Some(running), Input::JobDone(done)) => running.job_done(at, done, effects),
            (None, _) if !self.complained => {
                self.complained = true;
                let text =
                    "The log does not begin with a boot record, so nothing in it can be used.".to_owned();
                effects.push(notice(at, Severity::Error, text));
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
        if let Some(last) = record.last_place.filter(|_| record.start_mapping.is_none()) {
            localisation
                .begin(last.map, isometry_from_pose(&last.map_from_base).map(InitialPose::MapFromBase));
        }
        Self {
            odometry: OdometryAdapter::new(record),
            control: Control::default(),
            watch: Watch::default(),
            mapping,
            localisation,
            docks: dock_registry(&record.docks),
            motion: Motion::new(record.mounting.standing_height),
            jobs: 0,
            saving: None,
            points_used: 0,
            odometer: Odometer::default(),
            last: None,
            observed: None,
        }
    }

    fn greet(&mut self, record: &BootRecord, effects: &mut Vec<StackEffect>) {
        for finding in OdometryAdapter::mounting_findings(record) {
            self.watch.found(finding);
        }
        publish(effects, Publication::Control(self.control.state().clone()));
        publish(effects, Publication::Docks(plain_docks(&self.docks)));
        self.start_jobs(effects);
        self.publish_changes(effects);
    }

    fn sensor(&mut self, at: Stamp, sensor: &Sensor, effects: &mut Vec<StackEffect>) {
        self.watch.heard(at, sensor);
        if let Sensor::Battery(battery) = sensor {
            self.docks.set_charging(battery.charging);
            publish(effects, Publication::Battery(*battery));
        }
        let mut said = Vec::new();
        self.odometry.hear(sensor, &mut said);
        self.digest(at, said, effects);
    }

    /// Works through what odometry said.
    fn digest(&mut self, at: Stamp, said: Vec<OdometryEvent>, effects: &mut Vec<StackEffect>) {
        for one in said {
            match one {
                OdometryEvent::FrameReset => {
                    // In a saved map, goals mean what they meant.
                    let drive = match self.localisation.is_idle() {
                        true => self.motion.forget_map(),
                        false => self.motion.begin_anew(at),
                    };
                    effects.extend(drive.map(StackEffect::Drive));
                }
                OdometryEvent::Scan(located) => self.located(at, located, effects),
                OdometryEvent::Finding(finding) => {
                    self.tell(at, &finding, effects);
                    self.watch.found(finding);
                }
            }
        }
    }

    fn tell(&self, at: Stamp, finding: &Finding, effects: &mut Vec<StackEffect>) {
        effects.push(notice(at, finding.severity, format!("{} {}", finding.what, finding.remedy)));
    }

    fn located(&mut self, at: Stamp, located: Box<LocatedScan>, effects: &mut Vec<StackEffect>) {
        if self.mapping.is_starting() {
            effects.extend(self.motion.forget_map().map(StackEffect::Drive));
        }
        let grown = self.mapping.add(&located);
        let turn = self.localisation.add(&located, self.mapping.sensor(), &self.docks);
        self.publish_transition(at, turn, effects);
        let map_from_base = self.map_from_odom() * located.odom_from_base;
        if self.docks.update(at, self.localisation.sure_of().map(|map| (map, map_from_base))) {
            publish(effects, Publication::Docks(plain_docks(&self.docks)));
        }
        self.odometer.move_to(&located.odom_from_base.translation.vector);
        self.points_used = located.points_used;
        if !located.is_dead_reckoned && self.observed.is_none_or(|last| located.stamp - last >= OBSERVE_EVERY)
        {
            self.observed = Some(located.stamp);
            self.motion.observe(at, &located.odom_from_base, self.mapping.sensor(), &located.cloud.xyz);
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
                publish(effects, Publication::Graph(graph));
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
        self.publish_changes(effects);
        self.report(at, effects);
    }

    /// Publishes what changed in the map under construction, and starts the next comparisons.
    fn publish_mapping(&mut self, at: Stamp, events: MappingEvents, effects: &mut Vec<StackEffect>) {
        if events.is_localised {
            effects.extend(self.motion.forget_goal().map(StackEffect::Drive));
            let text = "The robot has found itself in the map; what is new is added to it.".to_owned();
            effects.push(notice(at, Severity::Info, text));
        }
        for decision in events.decisions {
            publish(effects, Publication::LoopDecided(decision));
        }
        if let Some(reanchored) = events.reanchored {
            publish(effects, Publication::Reanchored(reanchored));
        }
        if let Some(graph) = self.mapping.graph().filter(|_| events.is_graph_changed) {
            publish(effects, Publication::Graph(graph));
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

    /// Says that the place in a saved map is known, or not any more.
    fn publish_transition(
        &mut self,
        at: Stamp,
        turn: Option<LocalisationTransition>,
        effects: &mut Vec<StackEffect>,
    ) {
        let (drive, severity, text) = match turn {
            Some(LocalisationTransition::PoseFound) if !self.localisation.knows() => {
                let text =
                    "The robot has found a place in the map that fits, and looks whether others fit as well.";
                (None, Severity::Info, text)
            }
            Some(LocalisationTransition::PoseFound)
                if self.motion.go_on(at, &self.frames(self.last.as_deref())) =>
            {
                let text = "The robot knows where it is in the map, and goes on.";
                (None, Severity::Info, text)
            }
            Some(LocalisationTransition::PoseFound) => {
                // Where the robot went before means nothing now.
                (self.motion.forget_goal(), Severity::Info, "The robot knows where it is in the map.")
            }
            Some(LocalisationTransition::PoseLost) => {
                let drive = self.motion.lose_place(at);
                let text = match drive {
                    Some(_) => {
                        "The robot has lost its place in the map. It has stopped, looks about, and goes on once it knows."
                    }
                    None => "The robot has lost its place in the map, and looks for itself.",
                };
                (drive, Severity::Warning, text)
            }
            None => return,
        };
        effects.extend(drive.map(StackEffect::Drive));
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
        self.localisation.tick(at, self.odometry.is_underway());
        let predicted = self.last.as_ref().map(|last| self.odometry.predict(at, last));
        let frames = self.frames(predicted.as_deref());
        // Odometry may have begun anew without the place having been lost, and the place may have been in doubt when it was found.
        if self.localisation.knows() && !self.motion.go_on(at, &frames) {
            effects.extend(self.motion.end_look().map(StackEffect::Drive));
        }
        if let Some(drive) = self.motion.tick(at, &frames, &self.localisation.exploration_hint()) {
            effects.push(StackEffect::Drive(drive));
        }
        if let Some(located) = predicted {
            publish(effects, Publication::Estimate(self.estimate(&located, &frames.map_from_base())));
        }
        self.save_closed_map(at, effects);
        self.publish_changes(effects);
        self.report(at, effects);
    }

    fn report(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        if let Some(health) = self.watch.report(at, self.points_used) {
            publish(effects, Publication::Health(health));
        }
    }

    fn publish_changes(&mut self, effects: &mut Vec<StackEffect>) {
        if let Some(state) = self.mapping.changed() {
            publish(effects, Publication::Mapping(state));
        }
        if let Some(state) = self.localisation.changed() {
            publish(effects, Publication::Localisation(state));
        }
        let frames = self.frames(self.last.as_deref());
        if let Some(state) = self.motion.changed(&frames) {
            publish(effects, Publication::Motion(state));
        }
    }

    /// With the base at its last place; at the origin before the first.
    fn frames(&self, last: Option<&LocatedScan>) -> Frames {
        Frames {
            map_from_odom: self.map_from_odom(),
            odom_from_base: last.map_or_else(Isometry::identity, |last| last.odom_from_base),
        }
    }

    fn command(&mut self, at: Stamp, command: &Command, effects: &mut Vec<StackEffect>) {
        let refused = match self.control.admit(command) {
            Admission::Repeated(answer) => {
                effects.push(StackEffect::Answer { id: command.id, to: command.by.client, refused: answer });
                return;
            }
            Admission::Refused(reason) => Some(reason),
            Admission::Granted { changed } => {
                if changed {
                    publish(effects, Publication::Control(self.control.state().clone()));
                }
                self.obey(at, command, effects).err()
            }
        };
        self.control.answered(command.id, refused.clone());
        effects.push(StackEffect::Answer { id: command.id, to: command.by.client, refused });
        self.publish_changes(effects);
    }

    fn obey(&mut self, at: Stamp, command: &Command, effects: &mut Vec<StackEffect>) -> Result<(), String> {
        match &command.kind {
            CommandKind::TakeControl { .. } | CommandKind::ReleaseControl => Ok(()),
            CommandKind::StartMapping(session) => {
                self.mapping.start(*session)?;
                self.localisation.leave();
                Ok(())
            }
            CommandKind::ExtendMap { session, map } => {
                self.mapping.extend(*session, *map)?;
                self.localisation.leave();
                self.start_jobs(effects);
                Ok(())
            }
            CommandKind::Localise { map, at: place } => {
                if !self.mapping.is_idle() {
                    return Err("A map is being made. Finish or discard it first.".to_owned());
                }
                let unsound = || "That place is no pose: its numbers are not finite.".to_owned();
                let place =
                    place.as_ref().map(|it| isometry_from_pose(it).ok_or_else(unsound)).transpose()?;
                let walked = || self.last.as_ref().and_then(|last| self.mapping.map_from_odom_of(*map, last)).map(InitialPose::MapFromOdom);
                self.localisation.begin(*map, place.map(InitialPose::MapFromBase).or_else(walked));
                effects.extend(self.motion.forget_map().map(StackEffect::Drive));
                self.start_jobs(effects);
                Ok(())
            }
            CommandKind::LeaveMap => {
                self.localisation.leave();
                effects.extend(self.motion.forget_map().map(StackEffect::Drive));
                Ok(())
            }
            CommandKind::DiscardMapping => self.mapping.discard(),
            CommandKind::FinishMapping { map, name } => {
                let mut said = Vec::new();
                self.odometry.flush(&mut said);
                self.digest(at, said, effects);
                self.mapping.finish(at, *map, name)?;
                self.save_closed_map(at, effects);
                Ok(())
            }
            CommandKind::Teleoperate(velocity) => self.motion.teleoperate(at, *velocity),
            CommandKind::StartGoal { kind: GoalKind::WalkTo(_), .. } if self.localisation.is_looking() => {
                Err("The robot does not know yet where it is in the map. Wait until it does, or drive it by hand.".to_owned())
            }
            CommandKind::StartGoal { kind: GoalKind::WalkTo(goal), .. } => {
                let frames = self.frames(self.last.as_deref());
                self.motion.walk_to(at, &frames, vec_from_plain(*goal))
            }
            CommandKind::StartGoal { kind: GoalKind::Relocalise, .. } if !self.localisation.is_looking() => {
                Err("The robot looks for its place in no map. Choose \"Use this map\" on a saved one first.".to_owned())
            }
            CommandKind::StartGoal { kind: GoalKind::Relocalise, .. } => self.motion.look_about(at),
            CommandKind::CancelGoal(_) => {
                effects.extend(self.motion.forget_goal().map(StackEffect::Drive));
                Ok(())
            }
            CommandKind::StopMotion => {
                self.motion.stop(Some(command.by.client));
                // At once, not at the next tick.
                let frames = self.frames(self.last.as_deref());
                effects.extend(self.motion.tick(at, &frames, &ExplorationHint::default()).map(StackEffect::Drive));
                Ok(())
            }
            CommandKind::AllowMotion => {
                self.motion.allow();
                Ok(())
            }
            CommandKind::AcceptLoop { .. } | CommandKind::RejectLoop { .. } | CommandKind::ProposeLoop { .. } => {
                let events = self.mapping.handle_loop_command(&command.kind)?;
                self.publish_mapping(at, events, effects);
                Ok(())
            }
        }
    }

    fn loaded(&mut self, at: Stamp, job: u64, read: Result<&PriorMap, &str>, effects: &mut Vec<StackEffect>) {
        for refused in [self.mapping.loaded(job, read), self.localisation.loaded(job, read)] {
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
                let turn = self.localisation.answered(done.job, Some(&answer));
                self.publish_transition(at, turn, effects);
            }
            JobResult::DisambiguationPlanned(told) => {
                self.localisation.disambiguation_planned(done.job, Some(&told))
            }
            JobResult::LoopVerified(_) | JobResult::RevisitCompared(_) | JobResult::MapSearched(_) => {
                let events = self.mapping.complete_job(&done);
                self.publish_mapping(at, events, effects);
                self.save_closed_map(at, effects);
            }
            JobResult::MapLoaded(known) => self.loaded(at, done.job, Ok(&known), effects),
            JobResult::MapSaved { map, .. } => {
                self.mapping.saved(map, true);
                effects.push(notice(at, Severity::Info, "The map is saved.".to_owned()));
            }
            JobResult::Failed { reason } => self.job_failed(at, done.job, &reason, effects),
        }
        self.publish_changes(effects);
    }

    /// Tells whoever started a job that it was not done.
    fn job_failed(&mut self, at: Stamp, job: u64, reason: &str, effects: &mut Vec<StackEffect>) {
        if let Some((_, map)) = self.saving.take_if(|(saving, _)| *saving == job) {
            self.mapping.saved(map, false);
            let text = format!("The map was not saved: {reason}. The session goes on; try again.");
            effects.push(notice(at, Severity::Error, text));
            return;
        }
        self.localisation.answered(job, None);
        self.localisation.disambiguation_planned(job, None);
        self.loaded(at, job, Err(&format!("The map cannot be used: {reason}.")), effects);
        let failed = JobDone { job, result: JobResult::Failed { reason: reason.to_owned() } };
        let events = self.mapping.complete_job(&failed);
        self.publish_mapping(at, events, effects);
        self.save_closed_map(at, effects);
    }
}

fn publish(effects: &mut Vec<StackEffect>, publication: Publication) {
    effects.push(StackEffect::Publish(publication));
}

fn notice(at: Stamp, severity: Severity, text: String) -> StackEffect {
    StackEffect::Publish(Publication::Notice(Notice { at, severity, text }))
}
