//! One request over HTTP at a time.

use anyhow::{Context, Result, ensure};
use std::io::{Read, Write};
use std::net::TcpStream;

/// The bytes of the answer to a GET, head and body. A connection is opened for each, as `curl` does.
///
/// # Errors
/// When the server cannot be reached, or does not answer with status 200.
pub(crate) fn get(port: u16, path: &str) -> Result<Vec<u8>> {
    let mut connection = TcpStream::connect(("127.0.0.1", port)).context("the platform cannot be reached")?;
    write!(connection, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n")?;
    let mut answer = Vec::new();
    connection.read_to_end(&mut answer)?;
    let head = String::from_utf8_lossy(&answer[..answer.len().min(300)]).into_owned();
    ensure!(head.starts_with("HTTP/1.1 200"), "{path}: {head}");
    Ok(answer)
}
