//! Asks the gateway whether it and the core are connected.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

const PATIENCE: Duration = Duration::from_millis(500);

/// Whether the gateway at this address reports that core and gateway are connected.
pub fn is_healthy(address: SocketAddr) -> bool {
    status(address).is_ok_and(|line| line.starts_with("HTTP/1.1 200"))
}

/// First bytes of the response.
fn status(address: SocketAddr) -> std::io::Result<String> {
    let mut stream = TcpStream::connect_timeout(&address, PATIENCE)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    write!(
        stream,
        "GET {} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n",
        api::paths::HEALTH_PATH
    )?;
    let mut start = [0; 12];
    stream.read_exact(&mut start)?;
    Ok(String::from_utf8_lossy(&start).into_owned())
}
