//! What the gateway refuses or does itself is told to the core, for the audit log.

use crate::access::{welcomed_with, with_access};
use crate::support::{Gateway, TestCore, lease};
use api::{AuditNote, ClientMessage, Command, CredentialId};
use vocab::CommandId;

fn credential(secret: &str) -> CredentialId {
    CredentialId(*blake3::hash(secret.as_bytes()).as_bytes())
}

/// The note of this request, with the sentence that says why it was refused.
async fn refused(core: &mut TestCore, request: &str) -> (AuditNote, String) {
    core.note(|note| note.refused.clone().filter(|_| note.request == request).map(|why| (note.clone(), why)))
        .await
}

async fn get_as(gateway: &Gateway, path: &str, headers: &[&str], status: u16) {
    assert_eq!(gateway.get(path, headers).await.status, status);
}

#[tokio::test]
async fn a_privilege_that_is_refused_is_noted_with_who_and_from_where() {
    let (gateway, mut core) = with_access().await;
    get_as(&gateway, api::paths::AUDIT_PATH, &["authorization: Bearer viewer"], 403).await;
    let (note, reason) = refused(&mut core, "GET /api/v1/audit").await;
    assert_eq!(note.by.credential, Some(credential("viewer")));
    assert_eq!(note.by.address, Some([127, 0, 0, 1].into()));
    assert!(reason.contains("admin") && reason.contains("viewer"), "{reason}");
    let mut socket = welcomed_with(&gateway, "viewer", lease(1)).await;
    let id = CommandId(uuid::Uuid::from_u128(1));
    socket.send(&ClientMessage::Command { id, command: Command::LeaveMap }).await;
    let (note, _) = refused(&mut core, "LeaveMap").await;
    assert_eq!(note.by.credential, Some(credential("viewer")));
    gateway.stop().await;
}

#[tokio::test]
async fn foreign_names_and_origins_and_secrets_that_are_not_valid_are_noted() {
    let (gateway, mut core) = with_access().await;
    let reply = gateway.get(api::paths::HEALTH_PATH, &["host: evil.example"]).await;
    assert!(matches!(reply.status, 400 | 421), "{}", reply.status);
    refused(&mut core, "a request under another name of the server").await;
    let foreign = ["authorization: Bearer operator", "origin: http://evil.example", "content-length: 0"];
    assert_eq!(gateway.request("POST", api::paths::STOP_PATH, &foreign).await.status, 403);
    let (note, _) = refused(&mut core, "POST /api/v1/stop").await;
    assert_eq!(note.by.credential, Some(credential("operator")));
    for (secret, path, request) in [
        ("revoked", api::paths::MAPS_PATH, "GET /api/v1/maps"),
        ("forged", api::paths::SITE_PATH, "GET /api/v1/site"),
    ] {
        get_as(&gateway, path, &[&format!("authorization: Bearer {secret}")], 401).await;
        let (note, reason) = refused(&mut core, request).await;
        assert_eq!(note.by.credential, Some(credential(secret)), "the core knows whose it was");
        assert!(reason.contains("not valid"), "{reason}");
    }
    gateway.stop().await;
}

#[tokio::test]
async fn an_edit_that_the_gateway_refuses_is_noted() {
    let (gateway, mut core) = with_access().await;
    let headers = ["authorization: Bearer operator", "content-type: application/json", "content-length: 2"];
    assert_eq!(gateway.send("POST", api::paths::SITE_EDITS_PATH, &headers, b"[]").await.status, 400);
    let (note, _) = refused(&mut core, "POST /api/v1/site/edits").await;
    assert_eq!(note.by.credential, Some(credential("operator")));
    gateway.stop().await;
}

#[tokio::test]
async fn an_upload_is_noted_with_who_sent_it() {
    let (gateway, mut core) = with_access().await;
    let path = "/api/v1/uploads/11111111-0000-4000-8000-000000000001";
    let headers = ["authorization: Bearer operator", "content-length: 4"];
    assert_eq!(gateway.send("PUT", path, &headers, b"VERS").await.status, 201);
    let note = core.note(|note| note.request.starts_with("PUT").then(|| note.clone())).await;
    assert_eq!((note.request, note.refused), (format!("PUT {path}"), None));
    assert_eq!(note.by.credential, Some(credential("operator")));
    gateway.stop().await;
}

#[tokio::test]
async fn a_thousand_refusals_that_are_equal_are_few_notes() {
    let (gateway, mut core) = with_access().await;
    for _ in 0..1_000 {
        get_as(&gateway, api::paths::ACCOUNTS_PATH, &["authorization: Bearer viewer"], 403).await;
    }
    get_as(&gateway, api::paths::TOKENS_PATH, &["authorization: Bearer viewer"], 403).await;
    let mut notes = 0;
    let mut counted = |note: &AuditNote| {
        notes += usize::from(note.request == "GET /api/v1/accounts");
        (note.request == "GET /api/v1/tokens").then_some(())
    };
    core.note(&mut counted).await;
    assert_eq!(notes, 1);
    gateway.stop().await;
}
