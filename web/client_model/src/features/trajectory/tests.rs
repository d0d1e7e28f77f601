//! The travelled path: corrections of the graph, changes of the frame.

use crate::testing::*;
use api::{Graph, GraphNode};
use uuid::Uuid;
use vocab::{KeyframeId, MapId, Pose, Stamp, Vec3};

#[test]
fn what_was_walked_before_the_robot_found_itself_in_a_map_is_forgotten() {
    let mut client = TestClient::connected();
    let map = MapId(Uuid::from_u128(3));
    let points = |client: &TestClient| client.model.trajectory().count();
    for step in 0..10 {
        client.event(api::Event::Estimate(estimate_at(f64::from(step), f64::from(step))));
    }
    client.event(api::Event::Localisation(api::Localisation::Relocalising { map, hypotheses: 2 }));
    assert!(!client.model.has_pose_in_map(), "it is drawn nowhere");
    client.event(api::Event::Estimate(estimate_at(10.0, 10.0)));
    client.event(api::Event::Localisation(api::Localisation::Localised { map, degradation: None }));
    assert_eq!(points(&client), 0);
    for step in 11..15 {
        client.event(api::Event::Estimate(estimate_at(f64::from(step), f64::from(step))));
    }
    let walked = points(&client);
    let degradation = Some(api::DegradationReason::LidarBlind);
    client.event(api::Event::Localisation(api::Localisation::Localised { map, degradation }));
    assert!(walked > 2 && points(&client) == walked, "a degraded pose forgets nothing");
    client.event(api::Event::Localisation(api::Localisation::Relocalising { map, hypotheses: 0 }));
    assert!(client.model.has_pose_in_map(), "where it was last is better than nothing");
    client.event(api::Event::Localisation(api::Localisation::Loading { map: MapId(Uuid::from_u128(4)) }));
    assert!(!client.model.has_pose_in_map());
}

#[test]
fn the_trajectory_follows_corrections_of_the_graph() {
    let mut client = TestClient::connected();
    for step in 0..30 {
        client.event(api::Event::Estimate(estimate_at(f64::from(step), f64::from(step))));
    }
    let moved = Pose { position: Vec3::new(19.0, 5.0, 0.0), ..Pose::IDENTITY };
    let node = GraphNode { id: KeyframeId(0), stamp: Stamp::from_secs_f64(19.5), map_from_keyframe: moved };
    client.event(api::Event::Graph(Graph { nodes: vec![node], ..Graph::default() }));
    let trajectory: Vec<Vec3> = client.model.trajectory().collect();
    assert_eq!(trajectory.len(), 11, "the keyframe, then what was seen since");
    assert_eq!((trajectory[0].y, trajectory[1].x), (5.0, 20.0));
}
