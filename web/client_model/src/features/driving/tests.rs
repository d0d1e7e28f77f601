//! Driving by hand and walking to a point.

use crate::testing::*;
use crate::*;
use api::{Command, Control, Motion};
use vocab::{Twist, Vec3};

#[test]
fn driving_repeats_ten_times_a_second_and_ends_with_one_zero() {
    let mut client = TestClient::connected();
    client.event(api::Event::Control(Control { owner: Some(ME), name: String::new(), request: None }));
    let ahead = Twist { linear: Vec3::new(0.9, 0.0, 0.0), ..Twist::default() };
    for _ in 0..100 {
        client.command(ClientCommand::SetVelocity(Some(ahead)));
        client.wait(0.01);
    }
    let commands = client.take_commands();
    assert!((9..=11).contains(&commands.len()), "{} commands in a second", commands.len());
    client.command(ClientCommand::SetVelocity(None));
    client.command(ClientCommand::SetVelocity(None));
    client.wait(1.0);
    assert_eq!(client.take_commands(), [Command::Teleoperate(Twist::default())]);
}

#[test]
fn a_walk_ends_the_picking_of_its_goal() {
    let mut client = TestClient::connected();
    client.command(ClientCommand::PickGoal(true));
    client.command(ClientCommand::WalkTo(Vec3::new(1.0, 2.0, 0.0)));
    assert!(!client.model.is_picking_goal());
    client.command(ClientCommand::PickGoal(true));
    let walking = Motion::Walking { goal: Vec3::default(), path: Vec::new(), remaining_m: 3.0 };
    client.event(api::Event::Motion(walking));
    assert!(!client.model.is_picking_goal(), "somebody else sent it");
}
