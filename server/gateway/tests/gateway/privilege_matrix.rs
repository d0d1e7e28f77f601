//! Events and replays: who is told what, and what a session, a lease or a message is worth when it is presented again. `access` has the endpoints, commands and edits.

use crate::access::{SECRETS, grant, path, welcomed_with, with_access, with_limited_access};
use crate::samples;
use crate::support::{Gateway, TestCore, TestSocket, lease};
use api::access::{AccessState, Endpoint, command_privilege, event_privilege};
use api::{
    Battery, ClientMessage, CommandOutcome, CoreMessage, Event, GatewayMessage, Role, ScanFrame,
    ServerMessage, StreamRequest,
};
use gateway::socket_client;
use tokio_tungstenite::tungstenite::Message;
use vocab::{CommandId, Pose, Stamp};

/// A socket of each role.
async fn one_of_each(gateway: &Gateway) -> Vec<(Role, TestSocket)> {
    let mut sockets = Vec::new();
    for role in Role::ALL {
        sockets.push((role, welcomed_with(gateway, role.name(), lease(1)).await));
    }
    sockets
}

/// Whether this socket gets an event before the one that marks its end.
async fn gets(socket: &mut TestSocket, wanted: &Event, marker: f32) -> bool {
    let mut found = false;
    loop {
        let (_, event) = socket.event().await;
        match &event {
            Event::Battery(Battery { charge, .. }) if *charge == marker => return found,
            event => found |= event == wanted,
        }
    }
}

/// Sends what marks the end of the events before it.
async fn mark(core: &mut TestCore, to: Option<vocab::ClientId>, marker: f32) {
    let event = Event::Battery(Battery { charge: marker, ..Battery::default() });
    core.send(&CoreMessage::Event { to, event }).await;
}

#[tokio::test]
async fn every_event_reaches_whom_the_privilege_table_names() {
    let (gateway, mut core) = with_access().await;
    let mut sockets = one_of_each(&gateway).await;
    for (number, event) in (1_u16..).zip(samples::events()) {
        // Higher than any charge, so that it is none of the samples.
        let marker = 1_000.0 + f32::from(number);
        for (role, socket) in &mut sockets {
            let client = socket_client(lease(1), Some(role.name()));
            core.send(&CoreMessage::Event { to: Some(client), event: event.clone() }).await;
            mark(&mut core, Some(client), marker).await;
            let is_told = gets(socket, &event, marker).await;
            assert_eq!(is_told, event_privilege(&event).admits(Some(*role)), "{role}: {event:?}");
        }
    }
    gateway.stop().await;
}

#[tokio::test]
async fn what_all_are_told_reaches_every_role_and_nobody_without_one() {
    let (gateway, mut core) = with_access().await;
    let mut sockets = one_of_each(&gateway).await;
    for (secret, role) in SECRETS {
        for path in [api::CONTROL_PATH, api::STREAM_PATH] {
            let opened =
                gateway.socket_with(path, ("cookie", &format!("autoinspect-session={secret}"))).await;
            assert_eq!(opened.err(), if role.is_some() { None } else { Some(401) }, "{path} as {secret:?}");
        }
    }
    let notice = api::Notice { at: Stamp::EPOCH, severity: api::Severity::Info, text: "Look.".to_owned() };
    let event = Event::Notice(notice);
    core.publish(event.clone()).await;
    mark(&mut core, None, 1_000.0).await;
    for (role, socket) in &mut sockets {
        assert!(gets(socket, &event, 1_000.0).await, "{role}");
    }
    // Scans go over a socket of their own.
    for role in Role::ALL {
        let header = format!("autoinspect-session={}", role.name());
        let mut stream = gateway.socket_with(api::STREAM_PATH, ("cookie", &header)).await.expect("let in");
        stream.send(&StreamRequest::Open { version: api::VERSION, max_hz: 10.0 }).await;
        core.listeners((3, 1)).await;
        let scan = CoreMessage::Scan { stamp: Stamp::EPOCH, map_from_base: Pose::IDENTITY, points: vec![1] };
        core.send(&scan).await;
        assert!(stream.next::<ScanFrame>().await.is_some(), "{role}");
        drop(stream);
        core.listeners((3, 0)).await;
    }
    gateway.stop().await;
}

/// The core says that only the viewer is signed in: operator and admin have signed out.
async fn sign_out_all_but_the_viewer(gateway: &Gateway, core: &mut TestCore) {
    let grants = vec![grant("viewer", Role::Viewer, Stamp::from_nanos(i64::MAX))];
    core.send(&CoreMessage::Access(AccessState { needs_first_admin: false, grants })).await;
    while gateway.get(api::paths::MAPS_PATH, &["authorization: Bearer admin"]).await.status != 401 {}
}

#[tokio::test]
async fn a_session_that_is_presented_again_after_its_end_is_nobody_everywhere() {
    let (gateway, mut core) = with_access().await;
    let mut ended = welcomed_with(&gateway, "operator", lease(1)).await;
    sign_out_all_but_the_viewer(&gateway, &mut core).await;
    ended.ended().await;
    for secret in ["operator", "admin"] {
        let cookie = format!("autoinspect-session={secret}");
        for path in [api::CONTROL_PATH, api::STREAM_PATH] {
            assert_eq!(gateway.socket_with(path, ("cookie", &cookie)).await.err(), Some(401), "{path}");
        }
    }
    // Without a core nothing waits for an answer. Who may come in stays known.
    drop(core);
    for &endpoint in Endpoint::ALL {
        for header in ["authorization: Bearer operator", "cookie: autoinspect-session=admin"] {
            let method = endpoint.method().to_string();
            let reply = gateway.request(&method, &path(endpoint), &["content-length: 0", header]).await;
            let is_refused = reply.status == 401;
            // The handlers of those that are for anyone have reasons of their own.
            assert_eq!(
                is_refused,
                !endpoint.privilege().admits(None),
                "{method} {}: {reply:?}",
                endpoint.path()
            );
        }
    }
    gateway.stop().await;
}

/// The frame in which an admin gave a command, as it was read on the way.
fn captured(id: CommandId, command: &api::Command) -> Message {
    Message::Binary(api::encode(&ClientMessage::Command { id, command: command.clone() }).into())
}

#[tokio::test]
async fn a_captured_command_that_another_one_sends_is_theirs_and_does_what_their_role_may() {
    // All commands of a role are sent at once.
    let limits = gateway::Limits { commands_per_second: 1_000.0, ..gateway::Limits::default() };
    let (gateway, mut core) = with_limited_access(limits).await;
    for (role, mut socket) in one_of_each(&gateway).await {
        for (number, command) in (1..).zip(samples::commands()) {
            let id = CommandId(uuid::Uuid::from_u128(number));
            // Twice: the core knows by its id that it has done it already.
            for _ in 0..2 {
                socket.send_raw(captured(id, &command)).await;
                let is_admitted = command_privilege(&command).admits(Some(role));
                if is_admitted {
                    let GatewayMessage::Command { id: forwarded, by, .. } = core.command().await else {
                        panic!("{role}: {command:?} was not forwarded")
                    };
                    assert_eq!(forwarded, id, "the id is kept, so that a repetition is seen as one");
                    assert_eq!(by.client, socket_client(lease(1), Some(role.name())));
                    assert_eq!(by.credential, Some(grant(role.name(), role, Stamp::EPOCH).credential));
                    let event = Event::CommandDone { id, outcome: CommandOutcome::Accepted };
                    core.send(&CoreMessage::Event { to: Some(by.client), event }).await;
                }
                let outcome = socket
                    .find(|event| match event {
                        Event::CommandDone { id: done, outcome } if *done == id => Some(outcome.clone()),
                        _ => None,
                    })
                    .await;
                assert_eq!(outcome == CommandOutcome::Accepted, is_admitted, "{role}: {command:?}");
            }
        }
    }
    gateway.stop().await;
}

#[tokio::test]
async fn a_lease_that_is_presented_again_is_the_same_client_for_its_own_account_only() {
    let (gateway, mut core) = with_access().await;
    let client_of = async |secret: &str| {
        let header = format!("autoinspect-session={secret}");
        let mut socket = gateway.socket_with(api::CONTROL_PATH, ("cookie", &header)).await.expect("let in");
        socket.send(&ClientMessage::Hello { version: api::VERSION, lease: lease(1) }).await;
        match socket.message().await {
            ServerMessage::Welcome { you, .. } => you.client,
            other => panic!("not welcomed but {other:?}"),
        }
    };
    let holder = client_of("operator").await;
    assert_eq!(client_of("operator").await, holder, "its own account goes on after a new connection");
    assert_ne!(client_of("viewer").await, holder);
    sign_out_all_but_the_viewer(&gateway, &mut core).await;
    assert_ne!(client_of("viewer").await, holder, "also once the holder has signed out");
    gateway.stop().await;
}
