//! Encrypted connections: with the robot's own certificate authority, with files that change, and what is answered without encryption.

use crate::support::{Gateway, Reply, soon};
use gateway::{Limits, TlsConfig};
use rcgen::{CertificateParams, KeyPair};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

/// A client that trusts the certificate in this file, and nothing else.
fn connector(trusted: &Path) -> TlsConnector {
    let mut roots = RootCertStore::empty();
    roots.add(CertificateDer::from_pem_file(trusted).expect("a certificate")).expect("trusted");
    let builder = ClientConfig::builder_with_provider(Arc::new(default_provider()));
    let builder = builder.with_safe_default_protocol_versions().expect("versions");
    TlsConnector::from(Arc::new(builder.with_root_certificates(roots).with_no_client_auth()))
}

/// The answer to a request over TLS, to the server under this name; the error if there is no trust.
async fn get(gateway: &Gateway, trusted: &Path, name: &str, path: &str) -> std::io::Result<Reply> {
    let stream = TcpStream::connect(gateway.address).await?;
    let name = ServerName::try_from(name.to_owned()).expect("a name");
    let mut stream = soon("a handshake", connector(trusted).connect(name.clone(), stream)).await?;
    let head = format!("GET {path} HTTP/1.1\r\nhost: {}\r\nconnection: close\r\n\r\n", name.to_str());
    stream.write_all(head.as_bytes()).await?;
    let mut bytes = Vec::new();
    // Some peers close without a last word; what came is what counts.
    let _ = soon("a reply", stream.read_to_end(&mut bytes)).await;
    Ok(Reply::parse(&bytes))
}

#[tokio::test]
async fn a_browser_that_trusts_the_robots_own_authority_reaches_it_by_name_and_by_address() {
    let folder = tempfile::tempdir().expect("a folder");
    let own = TlsConfig::Own(folder.path().join("tls"));
    let gateway = Gateway::start_with_tls(own, Limits::default()).await;
    let authority = folder.path().join("tls/authority.pem");
    for name in ["localhost", "127.0.0.1"] {
        let reply = get(&gateway, &authority, name, api::paths::SESSION_PATH).await.expect("trusted");
        assert_eq!((reply.status, &reply.json()["is_demo"]), (200, &true.into()), "{name}");
        assert_eq!(reply.header("strict-transport-security"), "", "a new authority would lock people out");
    }
    let fingerprint = gateway::authority_fingerprint(&folder.path().join("tls")).expect("made");
    let answer = get(&gateway, &authority, "localhost", api::paths::AUTHORITY_PATH).await.expect("trusted");
    assert_eq!(answer.json()["sha256"], fingerprint.as_str());
    let code = get(&gateway, &authority, "localhost", api::paths::TRUST_CODE_PATH).await.expect("trusted");
    assert_eq!((code.status, code.header("content-type")), (200, "image/svg+xml"));
    // Nobody gets a certificate of a name that is not this server's.
    assert!(get(&gateway, &authority, "evil.example", "/").await.is_err());
    gateway.stop().await;
}

#[tokio::test]
async fn plain_http_beside_tls_leads_to_https_and_says_nothing_of_the_robot() {
    let folder = tempfile::tempdir().expect("a folder");
    let gateway = Gateway::start_with_tls(TlsConfig::Own(folder.path().to_owned()), Limits::default()).await;
    gateway.write("static/trust.html", b"how to trust");
    let page = gateway.get("/people.html?a=b", &[]).await;
    let https = format!("https://{}/people.html?a=b", gateway.address);
    assert_eq!((page.status, page.header("location")), (308, https.as_str()));
    gateway.get(api::paths::MAPS_PATH, &[]).await.expect_problem(403);
    gateway.request("POST", api::paths::SESSION_PATH, &["content-length: 0"]).await.expect_problem(403);
    assert_eq!(gateway.get("/trust.html", &[]).await.body, b"how to trust");
    let certificate = gateway.get(api::paths::AUTHORITY_CERTIFICATE_PATH, &[]).await;
    let stored = fs::read(folder.path().join("authority.pem")).expect("a certificate");
    assert_eq!((certificate.status, certificate.body), (200, stored));
    gateway.stop().await;
}

#[tokio::test]
async fn without_an_authority_of_its_own_a_server_says_that_there_is_none() {
    let gateway = Gateway::start().await;
    for path in
        [api::paths::AUTHORITY_PATH, api::paths::AUTHORITY_CERTIFICATE_PATH, api::paths::TRUST_CODE_PATH]
    {
        gateway.get(path, &[]).await.expect_problem(404);
    }
    gateway.stop().await;
}

#[tokio::test]
async fn a_client_that_says_nothing_is_sent_away() {
    let folder = tempfile::tempdir().expect("a folder");
    let limits = Limits { header_timeout: Duration::from_millis(300), ..Limits::default() };
    let gateway = Gateway::start_with_tls(TlsConfig::Own(folder.path().to_owned()), limits).await;
    let mut silent = TcpStream::connect(gateway.address).await.expect("a connection");
    let mut nothing = Vec::new();
    let read = soon("an end", silent.read_to_end(&mut nothing)).await;
    assert!(read.is_err() || nothing.is_empty());
    // A handshake that ends in the middle.
    let mut half = TcpStream::connect(gateway.address).await.expect("a connection");
    half.write_all(&[22, 3, 1, 2, 0, 1]).await.expect("written");
    let _ = soon("an end", half.read_to_end(&mut nothing)).await;
    gateway.stop().await;
}

/// Writes a certificate for `localhost`, signed by its own key.
fn write_certificate(folder: &Path) {
    let key = KeyPair::generate().expect("a key");
    let params = CertificateParams::new(vec!["localhost".to_owned()]).expect("a name");
    let certificate = params.self_signed(&key).expect("a certificate");
    fs::write(folder.join("key.pem"), key.serialize_pem()).expect("written");
    fs::write(folder.join("certificate.pem"), certificate.pem()).expect("written");
}

#[tokio::test]
async fn a_certificate_from_a_file_is_served_and_a_wrong_key_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    write_certificate(folder.path());
    let files = || TlsConfig::Files {
        certificates: folder.path().join("certificate.pem"),
        key: folder.path().join("key.pem"),
    };
    let gateway = Gateway::start_with_tls(files(), Limits::default()).await;
    let trusted = folder.path().join("certificate.pem");
    let reply = get(&gateway, &trusted, "localhost", api::paths::SESSION_PATH).await.expect("trusted");
    assert_eq!((reply.status, reply.header("strict-transport-security")), (200, "max-age=31536000"));
    gateway.stop().await;
    fs::write(folder.path().join("key.pem"), KeyPair::generate().expect("a key").serialize_pem())
        .expect("written");
    let (on_ready, _ready) = tokio::sync::oneshot::channel();
    let config = gateway::GatewayConfig {
        listen: ([127, 0, 0, 1], 0).into(),
        core_socket: folder.path().join("core.sock"),
        data_dir: folder.path().join("data"),
        static_dir: folder.path().join("static"),
        access: gateway::AccessConfig::default(),
        tls: files(),
        on_ready: Some(on_ready),
        heartbeat: None,
        restart: None,
    };
    let refused = gateway::serve(config, std::future::pending()).await;
    assert!(matches!(refused, Err(gateway::GatewayError::Tls(_))), "{refused:?}");
}
