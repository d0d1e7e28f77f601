//! Ages of what the robot reported.

use crate::testing::*;
use api::ServerMessage;
use vocab::Stamp;

#[test]
fn ages_count_from_the_robots_clock_and_from_arrival() {
    let mut client = TestClient::connected();
    let robot_now = Stamp::from_secs_f64(5000.0);
    client.server(ServerMessage::Pong { token: 1, now: robot_now });
    client.event(api::Event::Estimate(estimate_at(4998.0, 0.0)));
    let age = client.model.data_age_s().unwrap();
    assert!((age - 2.0).abs() < 1e-6, "made 2 s ago by the robot's clock: {age}");
    client.wait(3.0);
    let age = client.model.data_age_s().unwrap();
    assert!((age - 5.0).abs() < 1e-6, "{age}");
}
