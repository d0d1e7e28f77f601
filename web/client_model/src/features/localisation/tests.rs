//! Setting the pose by hand, and whose frame the pose is in.

use crate::testing::*;
use crate::*;
use api::{Command, Control};
use uuid::Uuid;
use vocab::{MapId, Pose, Vec3};

#[test]
fn who_shows_where_the_robot_stands_means_the_map_that_is_looked_at() {
    let mut client = TestClient::connected();
    client.event(api::Event::Control(Control { owner: Some(ME), name: String::new(), request: None }));
    let map = MapId(Uuid::from_u128(7));
    let place = Pose { position: Vec3::new(3.0, 4.0, 0.5), ..Pose::IDENTITY };
    client.command(ClientCommand::ViewMap(Some(map)));
    client.command(ClientCommand::PickGoal(true));
    client.command(ClientCommand::PickPose(true));
    assert!(client.model.is_picking_pose() && !client.model.is_picking_goal());
    client.take_effects();
    client.command(ClientCommand::SetPose(place));
    assert_eq!(client.take_commands(), [Command::Localise { map, at: Some(place) }]);
    assert_eq!((client.model.is_picking_pose(), client.model.viewed_map()), (false, None));
    client.event(api::Event::Localisation(api::Localisation::Localised { map, degradation: None }));
    client.command(ClientCommand::PickPose(true));
    client.command(ClientCommand::PickGoal(true));
    assert!(client.model.is_picking_goal() && !client.model.is_picking_pose());
}
