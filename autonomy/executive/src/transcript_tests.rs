//! Transcripts: every file in `transcripts/` holds commands (lines that begin with `>`) and the executive's reactions. After an intended change,
//! `UPDATE_EXPECT=1 cargo test -p executive` rewrites them and `docs/executive.md`.
//!
//! The robot stands in a room of 8 by 8 metres and moves exactly as commanded. Distances and repeated drive commands are not printed.

use crate::tests::{Rig, operator, post, room};
use crate::*;
use expect_test::{ExpectFile, expect_file};
use geometry::Vector3;
use messages::{
    Approach, Drive, ExecutiveEvent, GoalAttempt, GoalFailure, GoalKind, GoalProgress, GoalStatus, PoseGoal,
    Publication, StackEffect, WaitReason,
};
use site_model::NodeId;
use std::collections::BTreeSet;
use std::fmt::Write;
use uuid::Uuid;
use vocab::{GoalId, LegId, Pose, Stamp, Twist, Vec3};

/// Every scenario: its commands and its file.
fn scenarios() -> Vec<(&'static str, ExpectFile)> {
    macro_rules! files {
        ($($name:literal),* $(,)?) => {
            vec![$((include_str!(concat!("transcripts/", $name, ".txt")), expect_file![concat!("transcripts/", $name, ".txt")])),*]
        };
    }
    files![
        "walk_and_arrive",
        "walk_replaced_and_cancelled",
        "stop_and_allow",
        "stop_kept_over_a_restart",
        "drive_by_hand",
        "lease",
        "pose_lost_and_found",
        "pose_not_found",
        "path_blocked",
        "odometry_restarts",
        "map_replaced",
        "relocalise",
        "route",
        "route_taken_while_it_waits",
        "route_pose_lost",
        "refused",
    ]
}

#[test]
fn transcripts_equal_their_files_and_take_every_row_of_the_table() {
    let mut taken = BTreeSet::new();
    for (text, file) in scenarios() {
        let mut player = Player::new();
        let mut played = String::new();
        for line in text.lines() {
            if line.starts_with('#') {
                let _ = writeln!(played, "{line}");
            } else if let Some(command) = line.strip_prefix("> ") {
                let _ = writeln!(played, "{line}");
                played.push_str(&player.play(command));
            }
        }
        file.assert_eq(&played);
        taken.extend(player.rig.executive.taken);
    }
    let missing: Vec<_> = (0..TABLE.len()).filter(|row| !taken.contains(row)).map(|row| TABLE[row]).collect();
    assert!(missing.is_empty(), "rows that no transcript takes: {missing:#?}");
}

#[test]
fn the_committed_page_equals_the_table() {
    expect_file!["../../../docs/executive.md"].assert_eq(&to_markdown());
}

#[test]
fn a_stop_works_in_every_state_and_no_row_hides_a_later_one() {
    use messages::ExecutiveState::{Executing, Idle, ManualDriving, Recovering, Stopped};
    assert!(
        Stopped < ManualDriving && ManualDriving < Recovering && Recovering < Executing && Executing < Idle
    );
    for state in [Stopped, ManualDriving, Recovering, Executing, Idle] {
        let row = TABLE.iter().find(|row| row.from == state && row.event == ExecutiveEvent::StopRequested);
        assert!(row.is_some_and(|row| row.to == Stopped && row.guard == Guard::Always), "{state:?}");
    }
    for (number, row) in TABLE.iter().enumerate() {
        let same = |other: &&Transition| other.from == row.from && other.event == row.event;
        let earlier = TABLE[..number].iter().filter(same);
        assert!(
            earlier.clone().all(|other| other.guard != Guard::Always && other.guard != row.guard),
            "an earlier row hides {row:?}"
        );
    }
}

#[test]
fn a_goal_that_is_requested_twice_starts_once() {
    let mut player = Player::new();
    assert!(player.play("goal 1 walk 2 0").contains("accepted"));
    assert_eq!(player.play("goal 1 walk 2 0"), "");
    player.play("run 10");
    assert_eq!(player.play("goal 1 walk 2 0"), "", "the goal must not start again after its end");
}

/// Plays commands and prints changes.
struct Player {
    rig: Rig,
    moves: bool,
    progress: Option<GoalProgress>,
}

impl Player {
    /// A robot that has scanned the room for a second.
    fn new() -> Self {
        let mut rig = Rig::new();
        rig.run(1.0, &|_| true);
        rig.now = Stamp::EPOCH;
        rig.effects.clear();
        rig.executive.surroundings().insert_scan(rig.now, &geometry::Isometry::identity(), [0.0; 3], &room());
        Self { rig, moves: false, progress: None }
    }

    fn play(&mut self, command: &str) -> String {
        let words: Vec<&str> = command.split(' ').collect();
        let number =
            |index: usize| words.get(index).and_then(|word| word.parse::<f64>().ok()).unwrap_or_default();
        let id = |index: usize| Uuid::from_u128(number(index) as u128);
        let mut out = String::new();
        let Rig { executive, situation, now, effects, .. } = &mut self.rig;
        let refused = match words[0] {
            "goal" => {
                let kind = match words[2] {
                    "walk" => GoalKind::WalkTo(Vec3::new(number(3), number(4), -0.5)),
                    "node" => GoalKind::GoToNode(NodeId(id(3))),
                    _ => GoalKind::Relocalise,
                };
                executive.start_goal(*now, (GoalId(id(1)), kind, operator(1)), situation, effects).err()
            }
            // A leg of the running goal to a point, which the robot passes.
            "leg" => {
                let position = Vec3::new(number(2), number(3), 0.0);
                let map_from_goal = Pose { position, ..Pose::IDENTITY };
                let pose = PoseGoal {
                    map_from_goal,
                    tolerance: None,
                    max_speed_m_s: None,
                    approach: Approach::Path,
                };
                let leg = RouteLeg { id: LegId(id(1)), pose, dock: None };
                let goal = executive.goal().unwrap_or(GoalId(Uuid::nil()));
                let begun = executive.begin_leg(*now, goal, leg, situation, effects);
                begun.err().map(|reason| format!("{reason:?}"))
            }
            "leg-ends" => {
                executive.end_leg(LegId(id(1)), effects);
                None
            }
            "waited" => {
                let time = vocab::Span::from_secs_f64(number(2));
                executive.add_attempt(GoalId(id(1)), &GoalAttempt::WaitedForPath(time));
                None
            }
            "blocked-edge" => {
                let waits_for = Some(WaitReason::FreePath);
                executive.set_remainder(GoalId(id(1)), RouteRemainder { beyond_leg_m: None, waits_for });
                None
            }
            "route-ends" => {
                let outcome = if words[2] == "reached" { Ok(()) } else { Err(GoalFailure::NoRoute) };
                executive.end_route(*now, GoalId(id(1)), outcome, situation, effects);
                None
            }
            "cancel" => {
                executive.cancel_goal(*now, GoalId(id(1)), operator(1), situation, effects);
                None
            }
            "started-stopped" => {
                executive.restore_stop(Some(operator(2).client));
                None
            }
            "stop" => {
                executive.stop(*now, operator(2), situation, effects);
                None
            }
            "drive" => {
                let velocity = Twist { linear: Vec3::new(0.3, 0.0, 0.0), angular: Vec3::default() };
                executive.drive(*now, velocity, operator(1), situation, effects).err()
            }
            "run" => {
                for _ in 0..(number(1) * 20.0).round() as u32 {
                    self.rig.step(&|_| true);
                    self.print(&mut out);
                }
                return out;
            }
            "map" => {
                situation.is_in_saved_map = words[1] == "saved";
                situation.is_localised = situation.is_in_saved_map;
                situation.is_pose_unconfirmed = false;
                None
            }
            "sight" => {
                self.rig.points = if words[1] == "none" { Vec::new() } else { room() };
                None
            }
            "wall" => {
                // A row of posts through the room.
                let posts = (-40..=40_i8).map(|y| Vector3::new(number(1), 0.1 * f64::from(y), 0.0));
                let posts: Vec<_> = posts.flat_map(|position| post(&position)).collect();
                self.rig.points.extend(posts);
                None
            }
            "pose" => {
                match words[1] {
                    "lost" => self.rig.lose_pose(),
                    _ => self.rig.find_pose(),
                }
                None
            }
            event => {
                let event = match event {
                    "allow" => ExecutiveEvent::MotionAllowed,
                    "lease-lost" => ExecutiveEvent::LeaseLost,
                    "odometry-restarts" => ExecutiveEvent::OdometryRestarted,
                    "map-replaced" => ExecutiveEvent::MapReplaced,
                    other => panic!("no such command: {other}"),
                };
                self.rig.fire(event);
                None
            }
        };
        if let Some(reason) = refused {
            let _ = writeln!(out, "  refused: {reason}");
        }
        let Rig { executive, situation, now, effects, .. } = &mut self.rig;
        executive.publish_changes(*now, &situation.frames, effects);
        self.print(&mut out);
        out
    }

    fn print(&mut self, out: &mut String) {
        let seconds = (self.rig.now - Stamp::EPOCH).secs_f64();
        for event in self.rig.executive.take_events() {
            if let GoalEvent::LegEnded(leg, outcome) = event {
                let _ = writeln!(out, "  {seconds:.2} leg {} {outcome:?}", leg.0.as_u128());
            }
        }
        for effect in std::mem::take(&mut self.rig.effects) {
            let line = match effect {
                StackEffect::Drive(drive) => {
                    let moves = drive != Drive::default();
                    if std::mem::replace(&mut self.moves, moves) == moves {
                        continue;
                    }
                    if moves { "moves".to_owned() } else { "stands".to_owned() }
                }
                StackEffect::Publish(Publication::Executive(status)) => {
                    format!("{:?} because of {:?}", status.state, status.cause)
                }
                StackEffect::Publish(Publication::Goal(update)) => {
                    let Some(status) = self.status(&update.status) else { continue };
                    format!("goal {} {status}", update.id.0.as_u128())
                }
                _ => continue,
            };
            let _ = writeln!(out, "  {seconds:.2} {line}");
        }
    }

    /// A goal's status without numbers that differ between steps. `None` if nothing else has changed.
    fn status(&mut self, status: &GoalStatus) -> Option<String> {
        Some(match status {
            GoalStatus::Accepted => {
                self.progress = None;
                "accepted".to_owned()
            }
            GoalStatus::Running(progress) => {
                let before = self.progress.replace(*progress);
                if before.is_some_and(|before| before.waits_for == progress.waits_for) {
                    return None;
                }
                match progress.waits_for {
                    Some(reason) => format!("running, waits for {reason:?}"),
                    None => "running".to_owned(),
                }
            }
            GoalStatus::Succeeded(_) => "succeeded".to_owned(),
            GoalStatus::Failed { reason, tried } => {
                let tried: Vec<_> = tried.iter().map(|attempt| format!("{attempt:?}")).collect();
                format!("failed: {reason:?}; tried {}", tried.join(", "))
            }
            GoalStatus::Cancelled { by, cause } => {
                format!("cancelled by {}: {cause:?}", by.client.0.as_u128())
            }
        })
    }
}
