//! What messages, sockets and time do to the connection.

use super::{Ping, SocketState};
use crate::features::commands::expired_sentence;
use crate::shared::{Context, SliceChange};
use crate::{ClientEffect, ClientEvent, Socket, texts};
use api::{ClientIdentity, ClientMessage, ServerMessage, Severity, StreamRequest};

/// A message on the control socket. Returns its event if that follows the last one.
pub(crate) fn on_message<'m>(
    message: &'m ServerMessage,
    bytes: usize,
    cx: &mut Context<'_>,
) -> Option<&'m api::Event> {
    let now = cx.now();
    let connection = &mut cx.shared.connection;
    connection.control.on_received(now);
    connection.throughput.add(now, bytes);
    match message {
        ServerMessage::Welcome { version, program, you } => on_welcome(*version, program, you, cx),
        ServerMessage::Refused { reason } => connection.control.refuse(reason.clone()),
        ServerMessage::Pong { token, now: server_now } => {
            if let Some(ping) = connection.ping
                && *token == ping.token
            {
                connection.clock.update(ping.sent, now, *server_now);
                cx.show_notices();
            }
        }
        ServerMessage::Event { sequence, event } => {
            if *sequence == connection.sequence + 1 {
                connection.sequence = *sequence;
                return Some(event);
            }
            if *sequence > connection.sequence {
                // An event is missing. A new connection starts with a snapshot.
                drop_link(Socket::Control, cx);
            }
        }
    }
    None
}

fn on_welcome(version: u16, program: &str, you: &ClientIdentity, cx: &mut Context<'_>) {
    let now = cx.now();
    let connection = &mut cx.shared.connection;
    if version != api::VERSION {
        connection.control.refuse(texts::version_mismatch(version, api::VERSION));
        return;
    }
    cx.shared.you = Some(you.clone());
    let connection = &mut cx.shared.connection;
    program.clone_into(&mut connection.program);
    connection.sequence = 0;
    connection.clock.forget();
    connection.control.on_welcome(now);
    cx.shared.notices.forget_received();
    ping(cx);
    let mut expired = Vec::new();
    let again = cx.shared.commands.resend(now, |command| expired.push(expired_sentence(command)));
    cx.effects.extend(again.into_iter().map(|(id, command)| ClientEffect::command(id, command)));
    for sentence in expired {
        cx.notify(Severity::Warning, sentence);
    }
    cx.changes.push(SliceChange::Connected);
}

pub(crate) fn on_client_event(event: &ClientEvent, cx: &mut Context<'_>) {
    let now = cx.now();
    let connection = &mut cx.shared.connection;
    match event {
        ClientEvent::SocketOpened(Socket::Control) => {
            let hello = ClientMessage::Hello { version: api::VERSION, lease: cx.shared.lease };
            cx.effects.push(ClientEffect::Send(hello));
        }
        ClientEvent::SocketOpened(Socket::Stream) => {
            let max_hz = connection.config.scan_rate_hz;
            cx.effects.push(ClientEffect::SendStream(StreamRequest::Open { version: api::VERSION, max_hz }));
            // The stream has no welcome message.
            connection.stream.on_welcome(now);
        }
        ClientEvent::SocketClosed { socket, jitter } => connection.on_closed(*socket, now, *jitter),
        ClientEvent::DecodeFailed { socket } => {
            if *socket == Socket::Control {
                cx.notify(Severity::Error, texts::MESSAGE_UNREADABLE.to_owned());
            }
            drop_link(*socket, cx);
        }
        ClientEvent::Scan { bytes, .. } => {
            connection.stream.on_received(now);
            connection.throughput.add(now, *bytes);
        }
        ClientEvent::TileReady { bytes, .. } => connection.throughput.add(now, *bytes),
        ClientEvent::Tick => on_tick(cx),
        _ => {}
    }
}

/// Opens sockets that wait for their next attempt.
pub(crate) fn reconnect(cx: &mut Context<'_>) {
    let now = cx.now();
    for socket in [Socket::Control, Socket::Stream] {
        let link = cx.shared.connection.link_mut(socket);
        if matches!(link.state(), SocketState::Lost { .. }) {
            link.on_opening(now);
            cx.effects.push(ClientEffect::OpenSocket(socket));
        }
    }
}

fn on_tick(cx: &mut Context<'_>) {
    let now = cx.now();
    let connection = &mut cx.shared.connection;
    connection.throughput.expire(now);
    let elapsed_s = now.since(std::mem::replace(&mut connection.last_tick, now));
    if elapsed_s > connection.config.min_stall_s {
        connection.control.discount_stall(elapsed_s);
        connection.stream.discount_stall(elapsed_s);
    }
    for socket in [Socket::Control, Socket::Stream] {
        let link = connection.link_mut(socket);
        if link.is_retry_due(now) {
            link.on_opening(now);
            cx.effects.push(ClientEffect::OpenSocket(socket));
        }
        // Only the control socket is pinged: no scans come while a saved map is viewed.
        let idle_stream = socket == Socket::Stream && link.is_connected();
        if link.is_dead(now) && !idle_stream {
            cx.effects.push(ClientEffect::CloseSocket(socket));
            connection.on_closed(socket, now, NO_JITTER);
        }
    }
    let due = connection.ping.is_none_or(|ping| now.since(ping.sent) >= connection.config.ping_period_s);
    if connection.is_connected() && due {
        ping(cx);
    }
}

/// The middle of the jitter's range, for links that this client closes itself.
const NO_JITTER: f64 = 0.5;

fn drop_link(socket: Socket, cx: &mut Context<'_>) {
    cx.effects.push(ClientEffect::CloseSocket(socket));
    let now = cx.now();
    cx.shared.connection.on_closed(socket, now, NO_JITTER);
}

fn ping(cx: &mut Context<'_>) {
    let now = cx.now();
    let connection = &mut cx.shared.connection;
    connection.pings += 1;
    connection.ping = Some(Ping { token: connection.pings, sent: now });
    cx.effects.push(ClientEffect::Send(ClientMessage::Ping { token: connection.pings }));
}
