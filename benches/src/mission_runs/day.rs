//! A robot with its stack in lockstep, and what the stack publishes and commits meanwhile.

use super::site::MissionSite;
use anyhow::{Result, ensure};
use geometry::{Vector3, isometry_from_pose};
use lockstep::Lockstep;
use messages::{
    Command, CommandKind, Drive, GoalKind, GoalStatus, Input, LedgerEvent, LocalisationState, Principal,
    Publication, StackEffect,
};
use sim::{Contact, SimConfig};
use site_model::{MissionEventKind, MissionStatus, RunId, RunState, Site, TaskId, TaskStep};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{ClientId, CommandId, GoalId, Pose, Span, Stamp, Vec3};

/// Time within which a robot on its dock must be localised.
const LOCALISED_WITHIN_S: f64 = 120.0;

/// Time between two moments.
const MOMENT: Span = Span::from_millis(200);
/// Moments before a contact that are kept: three seconds.
const MOMENTS_KEPT: usize = 15;

/// The robot at an instant, by the truth, for whoever looks for the cause of a contact.
#[derive(Clone, Debug)]
pub struct Moment {
    /// The instant.
    pub at: Stamp,
    /// The base, site frame: x, y (metres) and heading (radians).
    pub place: [f64; 3],
    /// The last drive command: forward, left (m/s), turn (rad/s).
    pub drive: [f64; 3],
    /// The nearest person, if one is within 3 m, metres.
    pub person: Option<[f64; 2]>,
}

impl Moment {
    /// A line of text; times count from the contact.
    pub fn describe(&self, contact: Stamp) -> String {
        let [x, y, heading] = self.place;
        let [forward, left, turn] = self.drive;
        let person = self.person.map_or(String::new(), |[x, y]| format!(", person at {x:.2}, {y:.2}"));
        let time_s = (self.at - contact).secs_f64();
        format!(
            "  {time_s:+.1} s at {x:.2}, {y:.2}, {heading:.2} rad, driven {forward:.2}, {left:.2} m/s, {turn:.2} rad/s{person}"
        )
    }
}

/// A robot that is localised in its map.
pub struct MissionDay {
    /// The robot and its stack.
    pub lockstep: Lockstep,
    /// The newest status of missions.
    pub missions: Arc<MissionStatus>,
    /// Whether the battery is charged.
    pub is_charging: bool,
    /// The last step of each task that is in the ledger.
    pub steps: BTreeMap<TaskId, TaskStep>,
    /// By its own estimate, where the robot was at each call of an action.
    pub places_of_calls: Vec<Option<Pose>>,
    /// Contacts of the robot's body so far, each with what led to it.
    pub contacts: Vec<(Contact, Vec<Moment>)>,
    recent: VecDeque<Moment>,
    /// Notices for people, warnings and errors among them.
    pub notices: Vec<String>,
    estimate: Option<Pose>,
    drive: Drive,
    is_localised: bool,
    goals: BTreeMap<GoalId, GoalStatus>,
    commands: u128,
}

impl MissionDay {
    /// Boots the stack, gives it map and site, and waits until the robot is localised.
    ///
    /// # Errors
    /// When it is not localised in time.
    pub fn begin(config: SimConfig, mapped: &MissionSite, graph: Site) -> Result<Self> {
        let mut lockstep = Lockstep::new(config, None, false);
        lockstep.keep_map(Arc::clone(&mapped.prior_map));
        lockstep.give_site(graph);
        let mut day = Self {
            lockstep,
            missions: Arc::default(),
            is_charging: false,
            steps: BTreeMap::new(),
            places_of_calls: Vec::new(),
            contacts: Vec::new(),
            recent: VecDeque::new(),
            drive: Drive::default(),
            notices: Vec::new(),
            estimate: None,
            is_localised: false,
            goals: BTreeMap::new(),
            commands: 0,
        };
        day.command(CommandKind::Localise { map: mapped.prior_map.map, at: None });
        day.advance_until(LOCALISED_WITHIN_S, |day| day.is_localised);
        ensure!(day.is_localised, "not localised at the dock within {LOCALISED_WITHIN_S} s");
        day.advance_until(2.0, |_| false);
        Ok(day)
    }

    /// Sends a command of an operator.
    pub fn command(&mut self, kind: CommandKind) {
        self.commands += 1;
        let by = Principal::operator(ClientId(Uuid::from_u128(9)));
        let id = CommandId(Uuid::from_u128(self.commands));
        self.lockstep.give(Input::Command(Command { id, by, kind }));
    }

    /// Lets the robot go to a goal. Returns the outcome; none if there is none in time.
    pub fn go(&mut self, kind: GoalKind, max_seconds: f64) -> Option<GoalStatus> {
        let goal = GoalId(Uuid::from_u128(1_000 + self.commands));
        self.command(CommandKind::StartGoal { goal, kind });
        self.advance_until(max_seconds, |day| day.goals.get(&goal).is_some_and(GoalStatus::is_outcome));
        self.goals.get(&goal).filter(|status| status.is_outcome()).cloned()
    }

    /// Lets time pass until `is_done`, at most this long.
    pub fn advance_until(&mut self, max_seconds: f64, is_done: impl Fn(&Self) -> bool) {
        let end = self.lockstep.now() + Span::from_secs_f64(max_seconds);
        while self.lockstep.now() < end && !is_done(self) {
            self.advance(MOMENT.min(end - self.lockstep.now()));
        }
    }

    fn advance(&mut self, time: Span) {
        let until = self.lockstep.now() + time;
        let Self { lockstep, missions, is_charging, steps, places_of_calls, .. } = self;
        let Self { notices, estimate, drive, is_localised, goals, .. } = self;
        lockstep.advance(until, &mut |_, effect| match effect {
            StackEffect::Publish(Publication::Estimate(now)) => *estimate = Some(now.map_from_base),
            StackEffect::Publish(Publication::Localisation(state)) => {
                *is_localised = matches!(state, LocalisationState::Localised { degradation: None, .. });
            }
            StackEffect::Publish(Publication::Battery(battery)) => *is_charging = battery.charging,
            StackEffect::Publish(Publication::Missions(status)) => *missions = Arc::clone(status),
            StackEffect::Publish(Publication::Goal(update)) => {
                goals.insert(update.id, update.status.clone());
            }
            StackEffect::Publish(Publication::Notice(notice)) => notices.push(notice.text.clone()),
            StackEffect::Drive(now) => *drive = *now,
            StackEffect::CallAction { .. } => places_of_calls.push(*estimate),
            StackEffect::Commit { events, .. } => {
                for event in events {
                    let LedgerEvent::Mission(event) = event else { continue };
                    if let MissionEventKind::Task { task, step, .. } = &event.kind {
                        steps.insert(*task, step.clone());
                    }
                }
            }
            _ => {}
        });
        self.remember_moment();
        let contacts = self.lockstep.simulator().take_contacts();
        let recent: Vec<Moment> = self.recent.iter().cloned().collect();
        self.contacts.extend(contacts.into_iter().map(|contact| (contact, recent.clone())));
    }

    fn remember_moment(&mut self) {
        let simulator = self.lockstep.simulator();
        let Some(base) = isometry_from_pose(&simulator.truth().site_from_base) else { return };
        let (position, ahead) = (base.translation.vector, base.rotation * Vector3::x());
        let away = |at: &Vec3| (at.x - position.x).hypot(at.y - position.y);
        let people = simulator.people();
        let nearest = people.iter().filter(|at| (at.z - position.z).abs() < 1.5 && away(at) < 3.0);
        let nearest = nearest.min_by(|a, b| away(a).total_cmp(&away(b)));
        let velocity = self.drive.velocity;
        if self.recent.len() == MOMENTS_KEPT {
            self.recent.pop_front();
        }
        self.recent.push_back(Moment {
            at: self.lockstep.now(),
            place: [position.x, position.y, ahead.y.atan2(ahead.x)],
            drive: [velocity.linear.x, velocity.linear.y, velocity.angular.z],
            person: nearest.map(|at| [at.x, at.y]),
        });
    }

    /// How a run has ended, if it has.
    pub fn outcome(&self, run: RunId) -> Option<RunState> {
        self.missions.ended.iter().find(|ended| ended.run == run).map(|ended| ended.outcome)
    }
}
