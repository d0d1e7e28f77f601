//! The control socket: sends state to a client and receives its commands.

use crate::access::Identity;
use crate::access::texts::{self as access_texts, SIGN_IN_FIRST, role_refused};
use crate::app::App;
use crate::hub::ControlSeat;
use crate::limits::RateLimit;
use crate::outbox::OutboxItem;
use crate::snapshot::Cursor;
use crate::socket::{Closing, Incoming, Outgoing, close};
use crate::texts;
use crate::wire::ServerMessageRef;
use api::access::{event_privilege, message_privilege};
use api::{
    ClientIdentity, ClientMessage, Command, CommandOutcome, EditDone, EditOutcome, EditRefusal, Event,
    LeaseToken, Role,
};
use axum::extract::ws::WebSocket;
use futures_util::StreamExt;
use site_model::Edit;
use std::sync::Arc;
use std::time::Instant;
use vocab::CommandId;

/// Shown to clients in the welcome.
const PROGRAM: &str = concat!("autoinspect ", env!("CARGO_PKG_VERSION"));

/// Serves one control socket to its end.
pub(crate) async fn serve(socket: WebSocket, app: Arc<App>, identity: Identity) {
    let (mut sink, stream) = socket.split();
    let mut incoming = Incoming::new(stream, app.limits.silence);
    let closing = tokio::select! {
        closing = converse(&mut sink, &mut incoming, &app, &identity) => closing,
        () = app.hub.access.revoked(&identity) => Closing::SignedOut,
        () = app.shutdown() => Closing::Shutdown,
    };
    let last_message = match &closing {
        Closing::Refused(reason) => Some(api::encode(&ServerMessageRef::Refused { reason })),
        _ => None,
    };
    close(sink, incoming, closing, last_message).await;
}

async fn converse(
    sink: &mut Outgoing,
    incoming: &mut Incoming,
    app: &Arc<App>,
    identity: &Identity,
) -> Closing {
    let greeted = match tokio::time::timeout(app.limits.silence, app.greeting.acquire()).await {
        Ok(_turn) => greeting(incoming).await,
        Err(_) => Err(Closing::Silent),
    };
    let caller = match greeted {
        Ok(lease) => identity.at_socket(lease),
        Err(closing) => return closing,
    };
    let seat = match ControlSeat::claim(&app.hub, caller, identity.account.as_deref()) {
        Ok(seat) => seat,
        Err(reason) => {
            app.hub.access.journal.refused(identity, access_texts::CONTROL_PLACE, reason.clone());
            return Closing::Refused(reason);
        }
    };
    let you = you(&seat, identity, app);
    tokio::select! {
        closing = write_events(sink, &seat, app, &you) => closing,
        closing = listen(incoming, &seat, app, identity) => closing,
        () = seat.outbox.overflowed() => {
            Closing::Refused(texts::ANSWERS_NOT_READ.to_owned())
        }
    }
}

/// Who a client is, for itself.
fn you(seat: &ControlSeat, identity: &Identity, app: &App) -> ClientIdentity {
    ClientIdentity {
        client: seat.client(),
        account: identity.account.clone(),
        // Nobody else is let in.
        role: identity.role.unwrap_or(Role::Viewer),
        is_demo: app.hub.access.is_demo,
    }
}

/// The client's secret, from its hello.
async fn greeting(incoming: &mut Incoming) -> Result<LeaseToken, Closing> {
    match incoming.message().await? {
        ClientMessage::Hello { version: api::VERSION, lease } => Ok(lease),
        ClientMessage::Hello { version, .. } => Err(Closing::wrong_version(version)),
        _ => Err(Closing::Refused(texts::NO_HELLO.to_owned())),
    }
}

/// Writes the welcome, the snapshot and every change, newest values only, until the connection fails.
async fn write_events(sink: &mut Outgoing, seat: &ControlSeat, app: &App, you: &ClientIdentity) -> Closing {
    let mut changes = seat.changes();
    let mut cursor = Cursor::default();
    let mut sequence = 0;
    let welcome = ServerMessageRef::Welcome { version: api::VERSION, program: PROGRAM, you };
    if let Err(closing) = sink_message(sink, &welcome).await {
        return closing;
    }
    loop {
        // Marked as seen before the events are read, so that no change is lost between reading and waiting.
        changes.mark_unchanged();
        loop {
            if seat.outbox.take_graph_request(Instant::now()) {
                cursor.forget_graph();
            }
            if seat.outbox.take_site_request(Instant::now()) {
                cursor.forget_site();
            }
            // Answers to this client come before state; they are few.
            let next = seat.outbox.next().or_else(|| seat.next_event(&mut cursor).map(OutboxItem::Event));
            let sent = match next {
                Some(OutboxItem::Pong(token)) => {
                    let pong = ServerMessageRef::Pong { token, now: app.hub.robot_now() };
                    sink_message(sink, &pong).await
                }
                // Nobody is told what the privilege table keeps from them.
                Some(OutboxItem::Event(event)) if !event_privilege(&event).admits(Some(you.role)) => continue,
                Some(OutboxItem::Event(event)) => {
                    sequence += 1;
                    sink_message(sink, &ServerMessageRef::Event { sequence, event: &event }).await
                }
                None => break,
            };
            if let Err(closing) = sent {
                return closing;
            }
        }
        let request_due = seat.outbox.request_due(Instant::now());
        tokio::select! {
            changed = changes.changed() => if changed.is_err() { return Closing::Shutdown },
            () = seat.outbox.filled() => {}
            () = sleep_until(request_due) => {}
        }
    }
}

/// Waits for an instant, or for ever.
async fn sleep_until(instant: Option<Instant>) {
    match instant {
        Some(instant) => tokio::time::sleep_until(instant.into()).await,
        None => std::future::pending().await,
    }
}

async fn sink_message(sink: &mut Outgoing, message: &ServerMessageRef<'_>) -> Result<(), Closing> {
    crate::socket::send(sink, api::encode(message)).await
}

/// Reads commands and pings until the client leaves or falls silent.
async fn listen(incoming: &mut Incoming, seat: &ControlSeat, app: &App, identity: &Identity) -> Closing {
    let mut rates = CommandRates::new(app.limits.commands_per_second);
    let journal = &app.hub.access.journal;
    loop {
        let message = incoming.message().await;
        app.hub.access.note_used(identity);
        if let Ok(message) = &message
            && let Err(reason) = check(message, identity)
        {
            journal.refused(identity, name_of(message), reason.clone());
            refuse(seat, message, reason);
            continue;
        }
        match message {
            Ok(ClientMessage::Ping { token }) => seat.outbox.pong(token),
            Ok(ClientMessage::RequestGraph) => seat.outbox.request_graph(),
            Ok(ClientMessage::RequestSite) => seat.outbox.request_site(),
            Ok(ClientMessage::Edit(edit)) => {
                if let Some(reason) = handle_edit(seat, &mut rates, edit) {
                    journal.refused(identity, access_texts::EDIT, reason);
                }
            }
            Ok(ClientMessage::Command { id, command }) => {
                let name = command_name(&command);
                if let Some(reason) = handle_command(seat, &mut rates, id, command) {
                    journal.refused(identity, name, reason);
                }
            }
            Ok(ClientMessage::Hello { .. }) => {
                return Closing::Refused(texts::SECOND_HELLO.to_owned());
            }
            Err(closing) => return closing,
        }
    }
}

/// Asks the privilege table. The core asks it again.
///
/// # Errors
/// Why the message is refused, one sentence.
fn check(message: &ClientMessage, identity: &Identity) -> Result<(), String> {
    let privilege = message_privilege(message);
    match identity.role {
        role if privilege.admits(role) => Ok(()),
        Some(role) => Err(role_refused(role, privilege)),
        None => Err(SIGN_IN_FIRST.to_owned()),
    }
}

/// Answers a message that was refused, if it is of a kind that is answered.
fn refuse(seat: &ControlSeat, message: &ClientMessage, reason: String) {
    let event = match message {
        ClientMessage::Command { id, .. } => {
            Event::CommandDone { id: *id, outcome: CommandOutcome::Refused(reason) }
        }
        ClientMessage::Edit(edit) => {
            let outcome = EditOutcome::Refused(EditRefusal::Rejected(reason));
            Event::EditDone(EditDone { id: edit.id, outcome })
        }
        ClientMessage::Hello { .. }
        | ClientMessage::Ping { .. }
        | ClientMessage::RequestGraph
        | ClientMessage::RequestSite => return,
    };
    seat.outbox.answer(Arc::new(event));
}

/// What the audit log calls a message.
fn name_of(message: &ClientMessage) -> String {
    match message {
        ClientMessage::Command { command, .. } => command_name(command),
        ClientMessage::Edit(_) => access_texts::EDIT.to_owned(),
        message => first_word(message),
    }
}

/// What the audit log calls a command, without its values: those that differ in these only are counted together.
fn command_name(command: &Command) -> String {
    match command {
        Command::Mission(command) => format!("Mission {}", first_word(command)),
        command => first_word(command),
    }
}

/// The name of a variant.
fn first_word(value: &impl std::fmt::Debug) -> String {
    let is_of_name = |letter: &char| letter.is_alphanumeric();
    format!("{value:?}").chars().take_while(is_of_name).collect()
}

/// Forwards a command. Returns why it was refused here, if it was.
fn handle_command(
    seat: &ControlSeat,
    rates: &mut CommandRates,
    id: CommandId,
    command: Command,
) -> Option<String> {
    let forwarded = rates.check(&command).and_then(|()| seat.forward(id, command));
    let reason = forwarded.err()?.to_owned();
    let outcome = CommandOutcome::Refused(reason.clone());
    seat.outbox.answer(Arc::new(Event::CommandDone { id, outcome }));
    Some(reason)
}

/// Forwards an edit. Returns why it was refused here, if it was.
fn handle_edit(seat: &ControlSeat, rates: &mut CommandRates, edit: Edit) -> Option<String> {
    let id = edit.id;
    let is_allowed = rates.edits.allow(Instant::now());
    let refusal = if !is_allowed {
        Some(EditRefusal::Unavailable(texts::COMMANDS_TOO_FAST.to_owned()))
    } else if let Some(reason) = seat.refusal(&edit) {
        Some(EditRefusal::Rejected(reason))
    } else {
        seat.forward_edit(edit).err().map(|reason| EditRefusal::Unavailable(reason.to_owned()))
    };
    let refusal = refusal?;
    let reason = match &refusal {
        EditRefusal::Unavailable(reason) | EditRefusal::Rejected(reason) => reason.clone(),
        EditRefusal::Invalid(errors) => errors.first().map_or_else(String::new, ToString::to_string),
    };
    let outcome = EditOutcome::Refused(refusal);
    seat.outbox.answer(Arc::new(Event::EditDone(EditDone { id, outcome })));
    Some(reason)
}

/// Rate limits of one client. Stop motion has a limit of its own, so that other commands cannot delay it.
struct CommandRates {
    stops: RateLimit,
    edits: RateLimit,
    others: RateLimit,
}

impl CommandRates {
    fn new(per_second: f64) -> Self {
        let now = Instant::now();
        let limit = || RateLimit::new(per_second, now);
        Self { stops: limit(), edits: limit(), others: limit() }
    }

    fn check(&mut self, command: &Command) -> Result<(), &'static str> {
        let limit = if *command == Command::StopMotion { &mut self.stops } else { &mut self.others };
        if limit.allow(Instant::now()) { Ok(()) } else { Err(texts::COMMANDS_TOO_FAST) }
    }
}
