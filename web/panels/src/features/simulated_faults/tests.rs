//! Which robots offer faults, and what their buttons emit.

use crate::test_support::{TestClient, click};
use api::{Event, Platform, SimulatedFault};
use client_model::ClientCommand;
use egui_kittest::kittest::Queryable;
use vocab::Span;

#[test]
fn faults_are_offered_with_simulated_robots_only() {
    let platform = |site: Option<&str>| {
        Event::Platform(Platform { site: site.map(str::to_owned), ..Platform::default() })
    };
    let harness = TestClient::connected().event(platform(None)).shown(1440.0, 1800.0);
    assert!(harness.query_by_label("Carry the robot away").is_none());
    let mut harness = TestClient::connected().event(platform(Some("b1"))).shown(1440.0, 1800.0);
    click(&mut harness, "Cover the LiDAR for 20 s");
    let fault = SimulatedFault::CoverLidar(Span::from_millis(20_000));
    assert!(harness.state().emitted(&ClientCommand::InjectFault(fault)));
}
