//! The client's own files.

use crate::support::Gateway;

const WASM: &str = "/pkg/client-0123456789abcdef_bg.wasm";

async fn gateway_with_page() -> Gateway {
    let gateway = Gateway::start().await;
    gateway.write("static/index.html", b"<!doctype html>");
    gateway.write(&format!("static{WASM}"), b"plain");
    gateway.write(&format!("static{WASM}.br"), b"brotli");
    gateway.write(&format!("static{WASM}.gz"), b"gzip");
    gateway.write("static/pkg/manifest.json", b"{}");
    gateway.write("static/.hidden", b"secret");
    gateway.write("secret", b"secret");
    gateway
}

#[tokio::test]
async fn the_page_is_asked_for_each_time_and_the_bundle_never_again() {
    let gateway = gateway_with_page().await;
    for path in ["/", "/index.html", "/?a=b"] {
        let page = gateway.get(path, &[]).await;
        assert_eq!((page.status, &page.body[..]), (200, &b"<!doctype html>"[..]));
        assert_eq!(page.header("content-type"), "text/html; charset=utf-8");
        assert_eq!(page.header("cache-control"), "no-cache");
        let condition = format!("if-none-match: {}", page.header("etag"));
        assert_eq!(gateway.get(path, &[&condition]).await.status, 304);
        gateway.write("static/index.html", b"<!doctype html>");
    }
    let page = gateway.get("/", &[]).await;
    gateway.write("static/index.html", b"<!doctype html><p>");
    let condition = format!("if-none-match: {}", page.header("etag"));
    assert_eq!(gateway.get("/", &[&condition]).await.status, 200, "changed");

    let bundle = gateway.get(WASM, &[]).await;
    assert_eq!(bundle.header("cache-control"), "public, max-age=31536000, immutable");
    assert_eq!(bundle.header("content-type"), "application/wasm");
    assert_eq!(gateway.get("/pkg/manifest.json", &[]).await.header("cache-control"), "no-cache");
}

#[tokio::test]
async fn the_smallest_form_that_the_browser_takes() {
    let gateway = gateway_with_page().await;
    for (accepts, encoding, body) in [
        ("gzip, deflate, br, zstd", "br", "brotli"),
        ("gzip, deflate", "gzip", "gzip"),
        ("br;q=0, gzip;q=0.5", "gzip", "gzip"),
        ("identity", "", "plain"),
    ] {
        let reply = gateway.get(WASM, &[&format!("accept-encoding: {accepts}")]).await;
        assert_eq!(
            (reply.header("content-encoding"), &reply.body[..]),
            (encoding, body.as_bytes()),
            "{accepts}"
        );
        assert_eq!(reply.header("content-type"), "application/wasm", "of what is inside");
        assert_eq!(reply.header("vary"), "accept-encoding");
    }
    let tags = [gateway.get(WASM, &["accept-encoding: br"]).await, gateway.get(WASM, &[]).await];
    assert_ne!(tags[0].header("etag"), tags[1].header("etag"), "a validator for each form");
}

#[tokio::test]
async fn no_path_leads_out() {
    let gateway = gateway_with_page().await;
    for path in [
        "/../secret",
        "/pkg/../../secret",
        "/%2e%2e/secret",
        "/..%2fsecret",
        "/pkg/..%5c..%5csecret",
        "//secret",
        "/./../secret",
        "/.hidden",
        "/pkg/",
        "/pkg",
        "/pkg//manifest.json",
        "/index.html/",
        "/index.html/x",
        "/%00",
        "/nothing.js",
    ] {
        gateway.get(path, &[]).await.expect_problem(404);
    }
    let long = format!("/{}", "a".repeat(5000));
    gateway.get(&long, &[]).await.expect_problem(404);
}
