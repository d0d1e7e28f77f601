//! Who is let in: the whole privilege table as nobody, with each role, and with sessions that have expired, were revoked or are forged; and what stands before it.

use crate::samples;
use crate::support::{Gateway, TestCore, TestSocket, lease};
use api::access::{AccessState, Endpoint, Grant, HttpMethod, account_privilege, command_privilege};
use api::access::{AccountReply, AccountRequest, Secret};
use api::{
    ClientMessage, CommandOutcome, CoreMessage, CredentialId, EditOutcome, EditRefusal, Event,
    GatewayMessage, LeaseToken, Role, ServerMessage,
};
use site_model::{Asset, AssetId, Change, Edit, EditId, Object};
use vocab::{CommandId, Stamp};

/// Who tries, and the role that comes of it.
pub const SECRETS: [(&str, Option<Role>); 7] = [
    ("", None),
    ("viewer", Some(Role::Viewer)),
    ("operator", Some(Role::Operator)),
    ("admin", Some(Role::Admin)),
    ("expired", None),
    ("revoked", None),
    ("forged", None),
];

pub fn grant(secret: &str, role: Role, expires: Stamp) -> Grant {
    let credential = CredentialId(*blake3::hash(secret.as_bytes()).as_bytes());
    Grant { credential, account: secret.to_owned(), role, expires }
}

fn state(with_revoked: bool) -> AccessState {
    let mut grants: Vec<_> =
        Role::ALL.into_iter().map(|role| grant(role.name(), role, Stamp::from_nanos(i64::MAX))).collect();
    grants.push(grant("expired", Role::Admin, Stamp::from_nanos(1)));
    if with_revoked {
        grants.push(grant("revoked", Role::Admin, Stamp::from_nanos(i64::MAX)));
    }
    AccessState { needs_first_admin: false, grants }
}

/// A gateway with sign-ins, and a core that has said who may come in. What it says first has one admin more than what it says last.
pub async fn with_access() -> (Gateway, TestCore) {
    with_limited_access(gateway::Limits::default()).await
}

/// The same with other limits.
pub async fn with_limited_access(limits: gateway::Limits) -> (Gateway, TestCore) {
    let gateway = Gateway::start_limited_with_sign_in(limits).await;
    let mut core = gateway.core().await;
    core.send(&CoreMessage::Access(state(true))).await;
    core.send(&CoreMessage::Access(state(false))).await;
    // Once it has this, it has both.
    core.publish(Event::Maps(Vec::new())).await;
    loop {
        if gateway.get(api::paths::MAPS_PATH, &["authorization: Bearer viewer"]).await.status == 200 {
            return (gateway, core);
        }
    }
}

/// A path of this endpoint with everything filled in.
pub fn path(endpoint: Endpoint) -> String {
    let id = "11111111-0000-4000-8000-000000000001";
    let hash = "ab".repeat(32);
    endpoint
        .path()
        .replace("{kind}", "asset")
        .replace("{hash}", &hash)
        .replace("{account}", "ada")
        .replace("{id}", if endpoint == Endpoint::RevokeToken { &hash } else { id })
        .replace("{run}", id)
        .replace("{session}", id)
        .replace("{keyframe}", "1")
}

#[tokio::test]
async fn every_endpoint_answers_each_role_as_the_privilege_table_says() {
    let (gateway, core) = with_access().await;
    // Without a core nothing waits for an answer. Who may come in stays known.
    drop(core);
    for &endpoint in Endpoint::ALL {
        for (secret, role) in SECRETS {
            for header in
                [format!("authorization: Bearer {secret}"), format!("cookie: autoinspect-session={secret}")]
            {
                let method = endpoint.method().to_string();
                let headers = ["content-length: 0", &header];
                let count = if secret.is_empty() { 1 } else { 2 };
                let reply = gateway.request(&method, &path(endpoint), &headers[..count]).await;
                let place = format!("{method} {} as {secret:?}", endpoint.path());
                match (endpoint.privilege().admits(role), role) {
                    // Whoever gets as far as the handler may be refused there for another reason.
                    (true, _) => assert!(!matches!(reply.status, 401 | 403), "{place}: {}", reply.status),
                    (false, Some(_)) => assert_eq!(reply.status, 403, "{place}"),
                    (false, None) => assert_eq!(reply.status, 401, "{place}"),
                }
                if endpoint.method() == HttpMethod::Get && reply.status == 401 {
                    reply.expect_problem(401);
                }
            }
        }
    }
    gateway.stop().await;
}

async fn welcomed(gateway: &Gateway, secret: &str) -> TestSocket {
    welcomed_with(gateway, secret, lease(1)).await
}

/// A client's control socket with this session.
pub async fn welcomed_with(gateway: &Gateway, secret: &str, lease: LeaseToken) -> TestSocket {
    let header = ("cookie", format!("autoinspect-session={secret}"));
    let mut socket = gateway.socket_with(api::CONTROL_PATH, (header.0, &header.1)).await.expect("let in");
    socket.send(&ClientMessage::Hello { version: api::VERSION, lease }).await;
    assert!(matches!(socket.message().await, ServerMessage::Welcome { .. }));
    socket
}

fn put_asset() -> Change {
    let asset =
        Asset { id: AssetId(uuid::Uuid::from_u128(5)), name: "Pump".into(), tags: Default::default() };
    Change::Put { base: None, object: Object::Asset(asset) }
}

#[tokio::test]
async fn every_command_and_edit_on_the_socket_is_answered_as_the_privilege_table_says() {
    let (gateway, mut core) = with_access().await;
    for role in Role::ALL {
        let mut socket = welcomed(&gateway, role.name()).await;
        for (number, command) in (1..).zip(samples::commands()) {
            let id = CommandId(uuid::Uuid::from_u128(number));
            let is_admitted = command_privilege(&command).admits(Some(role));
            socket.send(&ClientMessage::Command { id, command: command.clone() }).await;
            if is_admitted {
                let GatewayMessage::Command { id: forwarded, by, command: same } = core.command().await
                else {
                    panic!("{role}: {command:?} was not forwarded")
                };
                assert_eq!((forwarded, same), (id, command));
                assert_eq!(by.credential, Some(grant(role.name(), role, Stamp::EPOCH).credential));
                let event = Event::CommandDone { id, outcome: CommandOutcome::Accepted };
                core.send(&CoreMessage::Event { to: Some(by.client), event }).await;
            }
            let outcome = socket
                .find(|event| match event {
                    Event::CommandDone { id: done, outcome } => (*done == id).then(|| outcome.clone()),
                    _ => None,
                })
                .await;
            assert_eq!(outcome == CommandOutcome::Accepted, is_admitted, "{role}: {outcome:?}");
        }
        let edit = Edit { id: EditId(uuid::Uuid::from_u128(9)), changes: vec![put_asset()] };
        socket.send(&ClientMessage::Edit(edit.clone())).await;
        if role == Role::Viewer {
            let refused = |event: &Event| match event {
                Event::EditDone(done) => Some(done.outcome.clone()),
                _ => None,
            };
            let outcome = socket.find(refused).await;
            assert!(matches!(outcome, EditOutcome::Refused(EditRefusal::Rejected(_))), "{outcome:?}");
        } else {
            let GatewayMessage::Edit { edit: forwarded, .. } = core.command().await else {
                panic!("{role}: the edit was not forwarded")
            };
            assert_eq!(forwarded, edit);
        }
    }
    gateway.stop().await;
}

#[tokio::test]
async fn sockets_of_a_session_that_ends_are_closed() {
    let (gateway, mut core) = with_access().await;
    for secret in ["", "expired", "revoked", "forged"] {
        let header = format!("autoinspect-session={secret}");
        for path in [api::CONTROL_PATH, api::STREAM_PATH] {
            let refused = gateway.socket_with(path, ("cookie", &header)).await.err();
            assert_eq!(refused, Some(401), "{path} as {secret:?}");
        }
    }
    let mut admin = welcomed(&gateway, "admin").await;
    let mut operator = welcomed(&gateway, "operator").await;
    let mut viewer = welcomed(&gateway, "viewer").await;
    // One is revoked, one has another role; the third stays.
    let grants = vec![
        grant("operator", Role::Viewer, Stamp::from_nanos(i64::MAX)),
        grant("viewer", Role::Viewer, Stamp::from_nanos(i64::MAX)),
    ];
    core.send(&CoreMessage::Access(AccessState { needs_first_admin: false, grants })).await;
    admin.ended().await;
    operator.ended().await;
    viewer.send(&ClientMessage::Ping { token: 7 }).await;
    while !matches!(viewer.message().await, ServerMessage::Pong { token: 7, .. }) {}
    gateway.stop().await;
}

#[tokio::test]
async fn a_sign_in_sets_a_cookie_that_scripts_do_not_see() {
    let (gateway, mut core) = with_access().await;
    let body = br#"{"account": "ada", "password": "correct horse battery"}"#;
    let length = format!("content-length: {}", body.len());
    let headers = [length.as_str()];
    let core_side = async {
        let GatewayMessage::Account { number, by, request } = core.command().await else { panic!("another") };
        assert_eq!(account_privilege(&request), api::Privilege::Anyone);
        let password = Secret::new("correct horse battery");
        assert_eq!(request, AccountRequest::SignIn { account: "ada".into(), password });
        assert_eq!(by.address, Some([127, 0, 0, 1].into()));
        let (secret, expires) = (Secret::new("5ec7e7"), Stamp::from_nanos(i64::MAX));
        let reply = AccountReply::SignedIn { secret, account: "ada".into(), role: Role::Admin, expires };
        core.send(&CoreMessage::AccountReply { number, result: Ok(reply) }).await;
    };
    let (reply, ()) = tokio::join!(gateway.send("POST", api::paths::SESSION_PATH, &headers, body), core_side);
    assert_eq!(reply.status, 200);
    let cookie = reply.header("set-cookie");
    assert!(cookie.starts_with("autoinspect-session=5ec7e7; Path=/; HttpOnly; SameSite=Strict;"), "{cookie}");
    assert_eq!((&reply.json()["account"], &reply.json()["role"]), (&"ada".into(), &"admin".into()));
    assert!(!String::from_utf8_lossy(&reply.body).contains("5ec7e7"), "the secret is in the cookie only");
    gateway.stop().await;
}

#[tokio::test]
async fn other_hosts_and_other_sites_are_refused() {
    let gateway = Gateway::start().await;
    let port = gateway.address.port();
    let reply_to = |head: String| {
        let address = gateway.address;
        async move {
            use tokio::io::{AsyncReadExt, AsyncWriteExt};
            let mut stream = tokio::net::TcpStream::connect(address).await.expect("a connection");
            stream.write_all(head.as_bytes()).await.expect("written");
            let mut bytes = Vec::new();
            stream.read_to_end(&mut bytes).await.expect("read");
            crate::support::Reply::parse(&bytes)
        }
    };
    let get = |host: &str| format!("GET /api/v1/session HTTP/1.1\r\n{host}connection: close\r\n\r\n");
    for host in ["localhost", &format!("127.0.0.1:{port}"), "[::1]"] {
        assert_eq!(reply_to(get(&format!("host: {host}\r\n"))).await.status, 200, "{host}");
    }
    for host in ["host: evil.example\r\n", "host: 192.0.2.1\r\n", "host: localhost.evil.example\r\n"] {
        reply_to(get(host)).await.expect_problem(421);
    }
    let page = format!("GET / HTTP/1.1\r\nhost: evil.example:{port}\r\nconnection: close\r\n\r\n");
    assert_eq!(reply_to(page).await.status, 421, "the page too");
    let two = get("host: localhost\r\nhost: evil.example\r\n");
    assert!(matches!(reply_to(two).await.status, 400 | 421));

    let restore = api::paths::RESTORE_MAP_PATH.replace("{id}", "11111111-0000-4000-8000-000000000001");
    for header in [
        "origin: http://evil.example",
        "origin: null",
        "sec-fetch-site: cross-site",
        "sec-fetch-site: same-site",
    ] {
        gateway.request("POST", &restore, &[header, "content-length: 0"]).await.expect_problem(403);
    }
    let own = format!("origin: http://{}", gateway.address);
    assert_eq!(gateway.request("POST", &restore, &[&own, "content-length: 0"]).await.status, 503);
    gateway.stop().await;
}

#[tokio::test]
async fn a_demonstration_does_not_listen_on_a_network() {
    let (folder, (on_ready, _ready)) =
        (tempfile::tempdir().expect("a folder"), tokio::sync::oneshot::channel());
    let config = gateway::GatewayConfig {
        listen: ([0, 0, 0, 0], 0).into(),
        core_socket: folder.path().join("core.sock"),
        data_dir: folder.path().join("data"),
        static_dir: folder.path().join("static"),
        access: gateway::AccessConfig { is_demo: true, ..gateway::AccessConfig::default() },
        tls: gateway::TlsConfig::None,
        on_ready: Some(on_ready),
        heartbeat: None,
        restart: None,
    };
    let refused = gateway::serve(config, std::future::pending()).await;
    assert!(matches!(refused, Err(gateway::GatewayError::DemoOnNetwork { .. })), "{refused:?}");
}

#[tokio::test]
async fn a_cookie_that_was_planted_beside_the_own_one_counts_as_none() {
    let (gateway, _core) = with_access().await;
    let both = "cookie: autoinspect-session=viewer; autoinspect-session=admin";
    assert_eq!(gateway.get(api::paths::MAPS_PATH, &[both]).await.status, 401);
    let other = gateway.get(api::paths::ACCOUNTS_PATH, &["cookie: autoinspect-session=viewer"]).await;
    other.expect_problem(403);
    assert!(other.json()["detail"].as_str().is_some_and(|detail| detail.contains("admin")));
    gateway.stop().await;
}
