//! Files of clients.

use crate::support::Gateway;
use gateway::Limits;
use std::time::Duration;
use uuid::Uuid;

fn path(number: u128) -> String {
    api::paths::UPLOAD_PATH.replace("{id}", &Uuid::from_u128(number).to_string())
}

#[tokio::test]
async fn a_file_is_kept_whole_under_its_id_once() {
    let gateway = Gateway::start().await;
    let content: Vec<u8> = (0..300_000_u32).map(|i| (i * 7) as u8).collect();
    let length = format!("content-length: {}", content.len());
    assert_eq!(gateway.send("PUT", &path(1), &[&length], &content).await.status, 201);
    let kept = gateway.folder.path().join("data/uploads").join(Uuid::from_u128(1).to_string());
    assert!(std::fs::read(kept).expect("kept") == content);
    gateway.send("PUT", &path(1), &[&length], &content).await.expect_problem(409);
}

#[tokio::test]
async fn what_is_not_all_there_leaves_nothing() {
    let limits = Limits { write_stall: Duration::from_millis(50), ..Limits::default() };
    let gateway = Gateway::start_with(limits).await;
    gateway.send("PUT", &path(1), &["content-length: 100"], &[1; 99]).await.expect_problem(408);
    let uploads = gateway.folder.path().join("data/uploads");
    assert_eq!(std::fs::read_dir(uploads).expect("readable").count(), 0);
}

#[tokio::test]
async fn what_cannot_be_kept_is_refused_before_it_is_sent() {
    let gateway = Gateway::start().await;
    gateway.send("PUT", &path(1), &["transfer-encoding: chunked"], b"0\r\n\r\n").await.expect_problem(411);
    gateway.send("PUT", &path(1), &["content-length: 99999999999999"], b"").await.expect_problem(413);
    let foreign = ["content-length: 3", "origin: http://evil.example"];
    gateway.send("PUT", &path(1), &foreign, b"abc").await.expect_problem(403);
    gateway
        .send("PUT", "/api/v1/uploads/..%2fmaps", &["content-length: 3"], b"abc")
        .await
        .expect_problem(400);
    for number in 0..4 {
        assert_eq!(gateway.send("PUT", &path(number), &["content-length: 3"], b"abc").await.status, 201);
    }
    let refused = gateway.send("PUT", &path(9), &["content-length: 3"], b"abc").await;
    refused.expect_problem(409);
    let detail = refused.json()["detail"].to_string();
    assert!(detail.contains("4 files") && detail.contains("DELETE /api/v1/uploads/{id}"), "{detail}");
}

#[tokio::test]
async fn files_may_not_take_more_than_their_quota_together() {
    let gateway = Gateway::start_with(Limits { uploads_bytes: 10, ..Limits::default() }).await;
    assert_eq!(gateway.send("PUT", &path(1), &["content-length: 6"], b"points").await.status, 201);
    let refused = gateway.send("PUT", &path(2), &["content-length: 6"], b"points").await;
    refused.expect_problem(409);
    assert!(refused.json()["detail"].to_string().contains("GiB"), "{refused:?}");
    assert_eq!(gateway.send("PUT", &path(3), &["content-length: 4"], b"more").await.status, 201);
}
