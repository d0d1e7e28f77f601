//! Attacks by somebody on the network, each with what has to come of it. `cargo xtask test security` runs them, and those of `access`.

use crate::access::{welcomed_with, with_access};
use crate::support::{client_id, lease};
use api::{ClientMessage, Command, Control, Event, GatewayMessage, LeaseToken};
use std::time::{Duration, Instant};
use vocab::CommandId;

fn stop(number: u128) -> ClientMessage {
    ClientMessage::Command { id: CommandId(uuid::Uuid::from_u128(number)), command: Command::StopMotion }
}

/// Who the core is told has pressed Stop.
async fn client_that_stops(core: &mut crate::support::Core) -> vocab::ClientId {
    loop {
        if let GatewayMessage::Command { by, command: Command::StopMotion, .. } = core.command().await {
            return by.client;
        }
    }
}

#[tokio::test]
async fn an_id_that_was_heard_gives_nobody_the_lease() {
    let (gateway, mut core) = with_access().await;
    let mut holder = welcomed_with(&gateway, "admin", lease(1)).await;
    holder.send(&stop(1)).await;
    let owner = client_that_stops(&mut core).await;
    core.publish(Event::Control(Control { owner: Some(owner), name: "ada".into() })).await;
    // Everybody hears the id of the holder; the thief presents it as its own secret.
    let mut thief = welcomed_with(&gateway, "operator", lease(2)).await;
    let heard = thief
        .find(|event| match event {
            Event::Control(control) => control.owner,
            _ => None,
        })
        .await;
    assert_eq!(heard, owner);
    let mut thief = welcomed_with(&gateway, "operator", LeaseToken(heard.0)).await;
    thief.send(&stop(2)).await;
    assert_ne!(client_that_stops(&mut core).await, owner);
    gateway.stop().await;
}

#[tokio::test]
async fn a_stolen_secret_is_worth_nothing_without_the_account() {
    let (gateway, mut core) = with_access().await;
    let mut clients = Vec::new();
    for secret in ["admin", "operator"] {
        let mut socket = welcomed_with(&gateway, secret, lease(1)).await;
        socket.send(&stop(clients.len() as u128)).await;
        clients.push(client_that_stops(&mut core).await);
    }
    assert_ne!(clients[0], clients[1]);
    assert!(!clients.contains(&client_id(1)), "and without any account it is another one still");
    gateway.stop().await;
}

#[tokio::test]
async fn a_flood_of_one_account_does_not_delay_the_stop_of_another() {
    let (gateway, mut core) = with_access().await;
    let mut flooding = Vec::new();
    for number in 0..8 {
        let mut socket = welcomed_with(&gateway, "operator", lease(100 + number)).await;
        flooding.push(tokio::spawn(async move {
            for id in 0.. {
                let id = CommandId(uuid::Uuid::from_u64_pair(number as u64, id));
                socket.send(&ClientMessage::Command { id, command: Command::LeaveMap }).await;
            }
        }));
    }
    let mut viewer = welcomed_with(&gateway, "viewer", lease(1)).await;
    for number in 0..10 {
        let pressed = Instant::now();
        viewer.send(&stop(1_000 + number)).await;
        client_that_stops(&mut core).await;
        let took = pressed.elapsed();
        assert!(took < Duration::from_millis(200), "it took {took:?}");
    }
    flooding.into_iter().for_each(|task| task.abort());
    gateway.stop().await;
}
