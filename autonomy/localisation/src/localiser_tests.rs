use super::*;
use crate::localisation_map::LocalisationMap;
use crate::testing::{at, room_keyframe, rooms, rooms_keyframes};
use vocab::Span;

/// A robot that stands in the site of [`rooms`]. Its odometry frame is the map frame.
struct Robot {
    localiser: Localiser,
    pose: Isometry,
    points: Vec<[f32; 3]>,
    millis: i64,
    docks: Vec<Isometry>,
    jobs: u64,
}

impl Robot {
    fn new(x: f64, y: f64, yaw: f64, initial_pose: Option<InitialPose>) -> Self {
        let map = Arc::new(LocalisationMap::new(rooms_keyframes()));
        let mut localiser = Localiser::new(LocaliserConfig::default());
        localiser.start(Arc::new(GlobalLocaliser::new(map)), initial_pose);
        let points = room_keyframe(&rooms(), x, y, yaw).1.points().collect();
        Self { localiser, pose: at(x, y, yaw), points, millis: 0, docks: Vec::new(), jobs: 0 }
    }

    fn scan(&mut self) -> Option<LocalisationTransition> {
        self.scan_as(false)
    }

    fn scan_as(&mut self, is_dead_reckoned: bool) -> Option<LocalisationTransition> {
        self.millis += 100;
        let scan = OdometryScan {
            stamp: Stamp::EPOCH + Span::from_millis(self.millis),
            odom_from_base: self.pose,
            covariance: Matrix6::identity() * 1e-6,
            is_dead_reckoned,
            points: &self.points,
            sensor: [0.0; 3],
        };
        self.localiser.update(&scan, &self.docks)
    }

    /// Starts the pending relocalisation request. Returns its job, or `None` if no request is pending.
    fn start_job(&mut self) -> Option<u64> {
        self.jobs += 1;
        self.localiser.start_relocalisation(self.jobs).map(|_| self.jobs)
    }

    /// Runs the pending relocalisation request.
    fn relocalise(&mut self) -> Option<LocalisationTransition> {
        let Some(job) = self.start_job() else { panic!("no request is pending") };
        let Some(LocalisationWork::Relocalise(work)) = self.localiser.work(job) else {
            panic!("the job needs nothing")
        };
        self.localiser.finish_relocalisation(job, Some(&work.run()))
    }

    fn hypotheses(&self) -> usize {
        match self.localiser.state() {
            LocaliserState::Relocalising { hypotheses } => hypotheses,
            other => panic!("{other:?}"),
        }
    }

    /// Inserts scans until a transition, ten at most.
    fn scan_until_transition(&mut self) -> Option<LocalisationTransition> {
        (0..10).find_map(|_| self.scan())
    }

    fn is_localised_at(&self, pose: &Isometry) -> bool {
        self.localiser.map_from_odom().is_some_and(|map_from_odom| {
            let error = pose.inverse() * (map_from_odom * self.pose);
            error.translation.vector.norm() < 0.05 && error.rotation.angle() < 0.02
        })
    }
}

const FOUND: Option<LocalisationTransition> = Some(LocalisationTransition::PoseFound);

fn pose(map_from_base: Isometry, fit: f64) -> PoseHypothesis {
    PoseHypothesis { map_from_base, fit, violation_share: 0.0 }
}

#[test]
fn a_robot_at_a_unique_place_is_localised_and_confirmed() {
    let mut robot = Robot::new(37.2, 0.2, 0.4, None);
    assert_eq!(robot.localiser.state(), LocaliserState::Relocalising { hypotheses: 0 });
    assert_eq!(robot.scan(), None);
    assert_eq!(robot.relocalise(), None);
    assert_eq!(robot.hypotheses(), 1);
    assert_eq!(robot.scan_until_transition(), FOUND);
    assert_eq!(robot.localiser.state(), LocaliserState::Localised { degradation: None });
    assert!(robot.localiser.is_confirmed() && robot.is_localised_at(&at(37.2, 0.2, 0.4)));
    assert!(robot.localiser.covariance().is_some());
    robot.localiser.stop();
    assert_eq!((robot.localiser.state(), robot.scan()), (LocaliserState::Idle, None));
}

#[test]
fn a_robot_in_one_of_two_equal_rooms_keeps_several_hypotheses_and_asks_for_a_path() {
    let mut robot = Robot::new(5.0, 6.0, 0.4, None);
    robot.scan();
    robot.relocalise();
    assert!(robot.hypotheses() >= 2);
    assert_eq!(robot.scan_until_transition(), None);
    let hint = robot.localiser.exploration_hint();
    assert!(robot.hypotheses() >= 2 && hint.hypotheses == robot.hypotheses());
    assert!(robot.localiser.exploration_hint().path.is_none(), "the path must not be planned yet");
    let Some(id) = robot.localiser.start_disambiguation(50) else { panic!("no path was requested") };
    let Some(LocalisationWork::PlanDisambiguation(work)) = robot.localiser.work(50) else {
        panic!("the job needs nothing")
    };
    assert_eq!(work.id(), id);
    robot.localiser.finish_disambiguation(50, Some(work.run()));
    let path = robot.localiser.exploration_hint().path;
    assert!(path.is_some_and(|path| !path.is_empty()));
}

#[test]
fn a_given_pose_is_unconfirmed_until_a_search_of_the_whole_map() {
    let mut robot = Robot::new(37.2, 0.2, 0.4, Some(InitialPose::MapFromBase(at(37.5, 0.0, 0.5))));
    robot.scan();
    robot.relocalise();
    assert_eq!(robot.scan_until_transition(), FOUND);
    let unconfirmed = LocaliserState::Localised { degradation: Some(DegradationReason::Unconfirmed) };
    assert_eq!((robot.localiser.state(), robot.localiser.is_confirmed()), (unconfirmed, false));
    robot.scan();
    assert_eq!(robot.relocalise(), None);
    assert_eq!(robot.localiser.state(), LocaliserState::Localised { degradation: None });
    assert!(robot.localiser.is_confirmed());
    robot.scan();
    assert_eq!(robot.start_job(), None, "the next check is due after two metres");
}

#[test]
fn a_pose_given_for_the_odometry_frame_is_applied_to_the_base() {
    // The odometry frame is shifted by 20 cm from the map frame.
    let initial = InitialPose::MapFromOdom(Isometry::translation(0.2, 0.0, 0.0));
    let mut robot = Robot::new(37.2, 0.2, 0.4, Some(initial));
    robot.scan();
    robot.relocalise();
    assert_eq!(robot.scan_until_transition(), FOUND);
    assert!(robot.is_localised_at(&at(37.2, 0.2, 0.4)));
}

#[test]
fn a_pose_that_fits_better_contradicts_the_tracked_one_and_both_become_hypotheses() {
    let truth = at(37.2, 0.2, 0.4);
    let mut robot = Robot::new(37.2, 0.2, 0.4, Some(InitialPose::MapFromBase(truth)));
    robot.scan();
    robot.relocalise();
    assert_eq!(robot.scan_until_transition(), FOUND);
    robot.scan();
    let Some(job) = robot.start_job() else { panic!("no check of the unconfirmed pose was requested") };
    let found = [pose(at(12.0, 0.0, 0.0), 0.99), pose(truth, 0.5)];
    assert_eq!(
        robot.localiser.finish_relocalisation(job + 1, Some(&found)),
        None,
        "the result of another job must be ignored"
    );
    let lost = robot.localiser.finish_relocalisation(job, Some(&found));
    assert_eq!((lost, robot.hypotheses()), (Some(LocalisationTransition::PoseLost), 2));
}

#[test]
fn a_robot_without_hypotheses_requests_relocalisation_again_after_two_seconds() {
    let mut robot = Robot::new(37.2, 0.2, 0.4, None);
    robot.scan();
    let Some(job) = robot.start_job() else { panic!("it does not know its pose") };
    robot.localiser.finish_relocalisation(job, Some(&[]));
    for _ in 0..19 {
        robot.scan();
        assert_eq!(robot.start_job(), None);
    }
    robot.scan();
    assert!(robot.start_job().is_some());
}

#[test]
fn a_dead_reckoned_scan_does_not_request_relocalisation() {
    let mut robot = Robot::new(37.2, 0.2, 0.4, None);
    robot.scan_as(true);
    assert_eq!(robot.start_job(), None);
    robot.scan();
    assert!(robot.start_job().is_some());
}

#[test]
fn a_charged_robot_tries_the_docks_once() {
    let mut robot = Robot::new(5.0, 6.0, 0.4, None);
    robot.docks = vec![at(25.3, 6.2, 0.3)];
    robot.scan();
    robot.relocalise();
    assert_eq!(robot.hypotheses(), 1, "the dock must decide between the rooms");
    assert_eq!(robot.scan_until_transition(), FOUND);
    assert!(robot.is_localised_at(&at(25.0, 6.0, 0.4)) && !robot.localiser.is_confirmed());

    let mut robot = Robot::new(5.0, 6.0, 0.4, None);
    robot.docks = vec![at(-5.0, 0.0, 0.0)];
    robot.scan();
    let Some(job) = robot.start_job() else { panic!("it does not know its pose") };
    robot.localiser.finish_relocalisation(job, Some(&[]));
    robot.scan();
    assert_eq!(robot.start_job(), None, "the docks have been tried");
}

#[test]
fn without_scans_or_odometry_the_pose_degrades() {
    let mut robot = Robot::new(37.2, 0.2, 0.4, None);
    robot.scan();
    robot.relocalise();
    assert_eq!(robot.scan_until_transition(), FOUND);
    robot.scan();
    let latest = Stamp::EPOCH + Span::from_millis(robot.millis);
    let blind = LocaliserState::Localised { degradation: Some(DegradationReason::LidarBlind) };
    robot.localiser.tick(latest + Span::from_millis(800), true);
    assert_eq!(robot.localiser.state(), LocaliserState::Localised { degradation: None });
    robot.localiser.tick(latest + Span::from_millis(801), true);
    assert_eq!(robot.localiser.state(), blind);
    robot.scan();
    robot.localiser.tick(latest, false);
    assert_eq!(robot.localiser.state(), blind);
}

#[test]
fn only_a_new_initial_pose_starts_relocalisation_again() {
    let mut robot = Robot::new(37.2, 0.2, 0.4, None);
    robot.scan();
    robot.relocalise();
    assert_eq!(robot.scan_until_transition(), FOUND);
    robot.localiser.set_initial_pose(None);
    assert!(robot.localiser.map_from_odom().is_some());
    robot.localiser.set_initial_pose(Some(InitialPose::MapFromBase(at(37.2, 0.0, 0.4))));
    assert_eq!((robot.hypotheses(), robot.localiser.map_from_odom()), (0, None));
}
