//! Asks the gateway whether it and the core are connected.

use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::time::Duration;

/// Parameters of [`is_healthy`].
#[derive(Clone, Copy, Debug)]
struct HealthCheckConfig {
    /// Longest time to connect, and to wait for the answer. Chosen: the gateway is on the same computer and answers from memory.
    timeout: Duration,
}

const CONFIG: HealthCheckConfig = HealthCheckConfig { timeout: Duration::from_millis(500) };

/// Whether the gateway at this address reports that core and gateway are connected.
pub fn is_healthy(address: SocketAddr) -> bool {
    status(address).is_ok_and(|line| line.starts_with("HTTP/1.1 200"))
}

/// First bytes of the response.
fn status(address: SocketAddr) -> std::io::Result<String> {
    let mut stream = TcpStream::connect_timeout(&address, CONFIG.timeout)?;
    stream.set_read_timeout(Some(CONFIG.timeout))?;
    write!(
        stream,
        "GET {} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n",
        api::paths::HEALTH_PATH
    )?;
    let mut start = [0; 12];
    stream.read_exact(&mut start)?;
    Ok(String::from_utf8_lossy(&start).into_owned())
}

/// The address for a program on this computer.
pub fn reachable(address: SocketAddr) -> SocketAddr {
    if address.ip().is_unspecified() {
        SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), address.port())
    } else {
        address
    }
}
