//! The connection to the server: two sockets, its clock, bytes that come in, the order of its events. What changes it is in `reducer`.

mod clock;
mod link;
pub(crate) mod reducer;
mod throughput;

pub use clock::ServerClock;
pub use link::{ReconnectingSocket, SocketState};
pub use throughput::Throughput;

use crate::{ClientTime, Socket};
use link::LinkConfig;

/// When the connection is checked, and what it asks for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConnectionConfig {
    /// Time between two pings, seconds. The link counts as dead after three of them without any message. Chosen: a lost link is noticed in 6 s. Less costs messages, more
    /// lets people look at an old picture for longer.
    pub(crate) ping_period_s: f64,
    /// Ticks farther apart than this mean that the page itself stood still: a slow machine, a hidden tab, a tablet that slept. Seconds. Chosen: ticks come every 50 ms,
    /// or once a second in hidden tabs.
    pub(crate) min_stall_s: f64,
    /// Live scans asked for, hertz. Chosen: that of most LiDARs.
    pub(crate) scan_rate_hz: f32,
}

impl Default for ConnectionConfig {
    fn default() -> Self {
        Self { ping_period_s: 2.0, min_stall_s: 1.0, scan_rate_hz: 10.0 }
    }
}

/// A ping that was sent.
#[derive(Clone, Copy, Debug)]
struct Ping {
    token: u64,
    sent: ClientTime,
}

/// Both sockets with what is known of the server.
#[derive(Debug)]
pub struct Connection {
    control: ReconnectingSocket,
    stream: ReconnectingSocket,
    throughput: Throughput,
    clock: ServerClock,
    program: String,
    /// Number of the last event, counted by the server from 1 for each connection.
    sequence: u64,
    /// The last ping on this connection.
    ping: Option<Ping>,
    pings: u64,
    last_tick: ClientTime,
    config: ConnectionConfig,
}

impl Connection {
    pub(crate) fn new(now: ClientTime) -> Self {
        let config = LinkConfig::default();
        Self {
            control: ReconnectingSocket::new(now, config),
            stream: ReconnectingSocket::new(now, config),
            throughput: Throughput::default(),
            clock: ServerClock::default(),
            program: String::new(),
            sequence: 0,
            ping: None,
            pings: 0,
            last_tick: now,
            config: ConnectionConfig::default(),
        }
    }

    /// Whether state and commands flow.
    pub fn is_connected(&self) -> bool {
        self.control.is_connected()
    }

    /// State of the control socket.
    pub fn state(&self) -> &SocketState {
        self.control.state()
    }

    /// Since when there has been no connection; also while one is being opened again.
    pub fn lost_since(&self) -> Option<ClientTime> {
        self.control.lost_since()
    }

    /// The server's clock.
    pub fn clock(&self) -> &ServerClock {
        &self.clock
    }

    /// Bytes that come in over both sockets and by downloads.
    pub fn throughput(&self) -> &Throughput {
        &self.throughput
    }

    /// Version of the server's program; empty before the first connection.
    pub fn program(&self) -> &str {
        &self.program
    }

    fn link_mut(&mut self, socket: Socket) -> &mut ReconnectingSocket {
        match socket {
            Socket::Control => &mut self.control,
            Socket::Stream => &mut self.stream,
        }
    }

    fn on_closed(&mut self, socket: Socket, now: ClientTime, jitter: f64) {
        self.link_mut(socket).on_closed(now, jitter);
        if socket == Socket::Control {
            self.ping = None;
        }
    }
}

#[cfg(test)]
mod tests;
