//! A mission from the dock and back to it, scored by the truth.

use super::day::MissionDay;
use super::site::{InspectionTarget, MISSION, MissionSite};
use anyhow::{Context, Result};
use geometry::{Vector3, isometry_from_pose};
use lockstep::CalledAction;
use messages::CommandKind;
use serde::{Deserialize, Serialize};
use sim::{ContactWith, SimConfig, Simulator, Start};
use site_model::{MissionCommandKind, RunId, RunState, StartMode, TaskFailure, TaskStep};
use std::sync::Arc;
use uuid::Uuid;
use vocab::Pose;

/// Longest time for a mission, robot time.
const TIME_LIMIT_S: f64 = 2_400.0;
const RUN: RunId = RunId(Uuid::from_u128(2));

/// A picture, by the truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureScore {
    /// Distance of the robot from the node, metres.
    pub position_m: f64,
    /// Difference of heading from the node, radians.
    pub heading_rad: f64,
    /// Distance of the target from the picture's centre as a share of the picture, along the axis on which it is greater. None where the head cannot point there.
    pub off_centre: Option<f64>,
}

impl PictureScore {
    /// The same, infinite where the head cannot point there.
    pub fn off_centre_or_infinite(&self) -> f64 {
        self.off_centre.unwrap_or(f64::INFINITY)
    }
}

/// What became of a mission.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct MissionScore {
    /// None if it did not end in time.
    pub outcome: Option<RunState>,
    /// Number of tasks.
    pub tasks: usize,
    /// Those that were done.
    pub done: usize,
    /// Why others failed.
    pub failures: Vec<TaskFailure>,
    /// Each call of an action.
    pub pictures: Vec<PictureScore>,
    /// Contacts with solids.
    pub solids_touched: usize,
    /// People whom the robot touched by its own motion.
    pub people_touched: usize,
    /// People who walked into the robot.
    pub people_walked_into_it: usize,
    /// Position (m) and heading (rad) from the docked pose at the end; none if the robot is not charged there.
    pub docked: Option<(f64, f64)>,
    /// Robot time, seconds.
    pub duration_s: f64,
    /// A line for each contact, failure and block, for whoever looks for causes.
    pub details: Vec<String>,
}

impl MissionScore {
    /// Tasks that were neither done nor failed with a reason.
    pub fn without_reason(&self) -> usize {
        self.tasks.saturating_sub(self.done + self.failures.len())
    }
}

/// Runs a mission of `tasks` pictures. The seed decides its targets, the noise of all sensors and the people.
///
/// # Errors
/// When the robot is not localised on its dock, or a pose of the simulation is none.
pub fn run_mission(
    mapped: &MissionSite,
    seed: u64,
    tasks: usize,
    columns: u32,
    people: u32,
) -> Result<MissionScore> {
    let dock = mapped.site.docks().first().context("the site has no dock")?;
    let config = SimConfig {
        lidar_columns: columns,
        people,
        start: Some(Start { position: dock.position, yaw: dock.yaw }),
        ..SimConfig::new(Arc::clone(&mapped.site), seed)
    };
    let planned = mapped.with_mission(seed, tasks)?;
    let mut day = MissionDay::begin(config, mapped, planned.graph)?;
    let begun = day.lockstep.now();
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Queue };
    day.command(CommandKind::Mission(start));
    day.advance_until(TIME_LIMIT_S, |day| day.outcome(RUN).is_some());
    let mut score = MissionScore {
        outcome: day.outcome(RUN),
        tasks: planned.targets.len(),
        docked: docked_error(day.lockstep.simulator()).filter(|_| day.is_charging),
        duration_s: (day.lockstep.now() - begun).secs_f64(),
        ..MissionScore::default()
    };
    score.add_steps(&day);
    score.add_contacts(&day);
    for (call, estimate) in day.lockstep.calls().iter().zip(&day.places_of_calls) {
        score.pictures.push(picture_score(call, estimate.as_ref(), &planned.targets)?);
    }
    for block in day.lockstep.site().edge_blocks() {
        score.details.push(format!("blocked {} times: {:?}: {}", block.failures, block.edge, block.reason));
    }
    score.details.extend(day.notices.iter().map(|text| format!("notice: {text}")));
    Ok(score)
}

/// Position (m) and heading (rad) of the robot from the nearest docked pose, by the truth.
pub fn docked_error(simulator: &Simulator) -> Option<(f64, f64)> {
    let truth = isometry_from_pose(&simulator.truth().site_from_base)?;
    let ahead = truth.rotation * Vector3::x();
    let errors = simulator.site().docks().iter().map(|dock| {
        let off_m = (truth.translation.vector - geometry::vec_from_plain(dock.position)).xy().norm();
        let turned = ahead.y.atan2(ahead.x) - dock.yaw;
        (off_m, turned.sin().atan2(turned.cos()).abs())
    });
    errors.min_by(|(a, _), (b, _)| a.total_cmp(b))
}

impl MissionScore {
    fn add_steps(&mut self, day: &MissionDay) {
        for (task, step) in &day.steps {
            match step {
                TaskStep::Succeeded { .. } => self.done += 1,
                TaskStep::Failed(failure) => self.failures.push(failure.clone()),
                _ => {}
            }
            if !matches!(step, TaskStep::Succeeded { .. }) {
                self.details.push(format!("{task:?}: {step:?}"));
            }
        }
    }

    fn add_contacts(&mut self, day: &MissionDay) {
        for (contact, before) in &day.contacts {
            match contact.with {
                ContactWith::Solid => self.solids_touched += 1,
                ContactWith::Person(_) if contact.is_by_robot => self.people_touched += 1,
                ContactWith::Person(_) => self.people_walked_into_it += 1,
            }
            self.details.push(format!("{contact:?}"));
            self.details.extend(before.iter().map(|moment| moment.describe(contact.at)));
        }
    }
}

/// What the benchmark reads of an action's parameters.
#[derive(Deserialize)]
struct PhotoParameters {
    target_m: [f64; 3],
    zoom: f64,
}

/// Scores the picture that the robot takes: aimed by its own estimate, from its true pose.
fn picture_score(
    call: &CalledAction,
    estimate: Option<&Pose>,
    targets: &[InspectionTarget],
) -> Result<PictureScore> {
    let parameters: PhotoParameters = serde_json::from_str(&call.parameters)?;
    let asked_m = Vector3::from(parameters.target_m);
    let distances = targets.iter().map(|target| ((target.map_m - asked_m).norm(), target));
    let (_, target) = distances.min_by(|(a, _), (b, _)| a.total_cmp(b)).context("the mission has targets")?;
    let truth = isometry_from_pose(&call.truth.site_from_base).context("the truth is a pose")?;
    let error = target.site_from_node.inverse() * truth;
    let ahead = error.rotation * Vector3::x();
    Ok(PictureScore {
        position_m: error.translation.vector.xy().norm(),
        heading_rad: ahead.y.atan2(ahead.x).abs(),
        off_centre: estimate.and_then(isometry_from_pose).and_then(|map_from_base| {
            sim::off_centre(&truth, &map_from_base, &asked_m, &target.site_m, parameters.zoom)
        }),
    })
}
