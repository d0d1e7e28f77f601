//! The report of the robot's computer, the body that it tells, and faults of a simulated robot.

use super::*;
use crate::testing::*;
use api::{Command, SimulatedFault};

#[test]
fn the_body_is_unknown_until_the_robot_has_told_it() {
    let mut client = TestClient::connected();
    assert_eq!(client.model.platform.body(), None);
    assert_eq!(client.model.platform.manual_limits(), None);
    assert_eq!(client.model.platform.standing_height_m(), DEFAULT_STANDING_HEIGHT_M);
    let body = RobotBody {
        footprint_radius_m: 0.3,
        clearance_height_m: 0.8,
        standing_height_m: 0.42,
        step_height_m: 0.2,
        camera_head: vocab::CameraHead::COMMON,
    };
    let limits = SpeedLimits { forward_m_s: 1.1, sideways_m_s: 0.4, turn_rad_s: 0.8 };
    client.event(api::Event::Platform(Platform {
        robot: "Walker".into(),
        body: Some(body),
        manual_limits: Some(limits),
        ..Platform::default()
    }));
    assert_eq!(client.model.platform.report().map(|report| report.robot.as_str()), Some("Walker"));
    assert_eq!(client.model.platform.standing_height_m(), 0.42);
    assert_eq!(client.model.platform.manual_limits(), Some(limits));
}

#[test]
fn a_fault_is_asked_of_the_server() {
    let mut client = TestClient::connected();
    client.command(ClientCommand::InjectFault(SimulatedFault::CarryAway));
    assert_eq!(client.take_commands(), [Command::InjectFault(SimulatedFault::CarryAway)]);
}
