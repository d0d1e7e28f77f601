//! The control socket: state out, commands in.

use crate::app::App;
use crate::hub::ControlSeat;
use crate::limits::RateLimit;
use crate::outbox::Answer;
use crate::snapshot::Cursor;
use crate::socket::{Closing, Incoming, Outgoing, farewell};
use crate::wire::ServerMessageRef;
use api::{ClientMessage, Command, CommandOutcome, Event};
use axum::extract::ws::WebSocket;
use futures_util::StreamExt;
use std::sync::Arc;
use std::time::Instant;
use vocab::{ClientId, CommandId};

/// Shown to clients in the welcome.
const PROGRAM: &str = concat!("autoinspect ", env!("CARGO_PKG_VERSION"));

/// Serves one control socket to its end.
pub(crate) async fn serve(socket: WebSocket, app: Arc<App>) {
    let (mut sink, stream) = socket.split();
    let mut incoming = Incoming::new(stream, app.limits.silence);
    let closing = tokio::select! {
        closing = converse(&mut sink, &mut incoming, &app) => closing,
        () = app.shutdown() => Closing::Shutdown,
    };
    let last_word = match &closing {
        Closing::Refused(reason) => Some(api::encode(&ServerMessageRef::Refused { reason })),
        _ => None,
    };
    farewell(sink, incoming, closing, last_word).await;
}

async fn converse(sink: &mut Outgoing, incoming: &mut Incoming, app: &Arc<App>) -> Closing {
    let client = match greeting(incoming).await {
        Ok(client) => client,
        Err(closing) => return closing,
    };
    let Some(seat) = ControlSeat::claim(&app.hub, client) else {
        let clients = app.limits.clients;
        return Closing::Refused(format!(
            "The server already has {clients} clients. Close one, then reload."
        ));
    };
    tokio::select! {
        closing = write_events(sink, &seat, app) => closing,
        closing = listen(incoming, &seat, app) => closing,
        () = seat.outbox.overflowed() => {
            Closing::Refused("This client asks faster than it reads the answers. Reload the page.".to_owned())
        }
    }
}

/// The client's id, from its hello.
async fn greeting(incoming: &mut Incoming) -> Result<ClientId, Closing> {
    match incoming.message().await? {
        ClientMessage::Hello { version: api::VERSION, client } => Ok(client),
        ClientMessage::Hello { version, .. } => Err(Closing::wrong_version(version)),
        _ => Err(Closing::Refused("A client says hello first.".to_owned())),
    }
}

/// Writes the welcome, the snapshot and every change, newest values only, until the connection fails.
async fn write_events(sink: &mut Outgoing, seat: &ControlSeat, app: &App) -> Closing {
    let mut changes = seat.changes();
    let mut cursor = Cursor::default();
    let mut sequence = 0;
    let welcome = ServerMessageRef::Welcome { version: api::VERSION, program: PROGRAM };
    if let Err(closing) = sink_message(sink, &welcome).await {
        return closing;
    }
    loop {
        // Marked as seen before looking, so that no change falls between looking and waiting.
        changes.mark_unchanged();
        loop {
            // Answers to this client first, they are few; then state.
            let next = seat.outbox.next().or_else(|| seat.next_event(&mut cursor).map(Answer::Event));
            let sent = match next {
                Some(Answer::Pong(token)) => {
                    let pong = ServerMessageRef::Pong { token, now: app.hub.robot_now() };
                    sink_message(sink, &pong).await
                }
                Some(Answer::Event(event)) => {
                    sequence += 1;
                    sink_message(sink, &ServerMessageRef::Event { sequence, event: &event }).await
                }
                None => break,
            };
            if let Err(closing) = sent {
                return closing;
            }
        }
        tokio::select! {
            changed = changes.changed() => if changed.is_err() { return Closing::Shutdown },
            () = seat.outbox.filled() => {}
        }
    }
}

async fn sink_message(sink: &mut Outgoing, message: &ServerMessageRef<'_>) -> Result<(), Closing> {
    crate::socket::send(sink, api::encode(message)).await
}

/// Reads commands and pings until the client leaves or falls silent.
async fn listen(incoming: &mut Incoming, seat: &ControlSeat, app: &App) -> Closing {
    let mut gate = Gate::new(app.limits.commands_per_second);
    loop {
        match incoming.message().await {
            Ok(ClientMessage::Ping { token }) => seat.outbox.pong(token),
            Ok(ClientMessage::Command { id, command }) => handle_command(seat, &mut gate, id, command),
            Ok(ClientMessage::Hello { .. }) => {
                return Closing::Refused("A client says hello only once.".to_owned());
            }
            Err(closing) => return closing,
        }
    }
}

fn handle_command(seat: &ControlSeat, gate: &mut Gate, id: CommandId, command: Command) {
    let forwarded = gate.check(&command).and_then(|()| seat.forward(id, command));
    if let Err(reason) = forwarded {
        let outcome = CommandOutcome::Refused(reason.to_owned());
        seat.outbox.answer(Arc::new(Event::CommandDone { id, outcome }));
    }
}

/// Rate limits of one client. Orders to stop have their own, so that no flood of others can hold one back.
struct Gate {
    stops: RateLimit,
    others: RateLimit,
}

impl Gate {
    fn new(per_second: f64) -> Self {
        let now = Instant::now();
        Self { stops: RateLimit::new(per_second, now), others: RateLimit::new(per_second, now) }
    }

    fn check(&mut self, command: &Command) -> Result<(), &'static str> {
        let limit = if *command == Command::StopMotion { &mut self.stops } else { &mut self.others };
        let too_fast = "This client sends commands too fast. Wait a second, then try again.";
        if limit.allow(Instant::now()) { Ok(()) } else { Err(too_fast) }
    }
}
