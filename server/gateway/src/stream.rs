//! The stream socket: sends the latest scan whenever the client can take one.

use crate::access::Identity;
use crate::app::App;
use crate::hub::{LiveScan, StreamSeat};
use crate::pacer::{Pacer, PacerConfig, Permission};
use crate::socket::{Closing, Incoming, Outgoing, close, send};
use crate::texts;
use crate::wire::ScanFrameRef;
use api::StreamRequest;
use axum::extract::ws::{Message, WebSocket};
use futures_util::{SinkExt, StreamExt};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::{Notify, watch};

/// Serves one stream socket to its end.
pub(crate) async fn serve(socket: WebSocket, app: Arc<App>, identity: Identity) {
    let (mut sink, stream) = socket.split();
    let mut incoming = Incoming::new(stream, app.limits.silence);
    let closing = tokio::select! {
        closing = converse(&mut sink, &mut incoming, &app) => closing,
        () = app.hub.access.revoked(&identity) => Closing::SignedOut,
        () = app.shutdown() => Closing::Shutdown,
    };
    close(sink, incoming, closing, None).await;
}

async fn converse(sink: &mut Outgoing, incoming: &mut Incoming, app: &Arc<App>) -> Closing {
    let Some(seat) = StreamSeat::claim(&app.hub) else {
        return Closing::Refused(texts::TOO_MANY_STREAMS.to_owned());
    };
    let flow = Flow::default();
    tokio::select! {
        closing = write_scans(sink, app.hub.scans(), &flow, app) => closing,
        closing = read_requests(incoming, seat, &flow) => closing,
    }
}

/// Flow control, shared by the two directions.
struct Flow {
    pacer: Mutex<Pacer>,
    requested: Notify,
}

impl Default for Flow {
    fn default() -> Self {
        Self { pacer: Mutex::new(Pacer::new(PacerConfig::default())), requested: Notify::new() }
    }
}

impl Flow {
    fn pacer(&self) -> MutexGuard<'_, Pacer> {
        self.pacer.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads requests and acknowledgements until the client leaves or falls silent.
async fn read_requests(incoming: &mut Incoming, mut seat: StreamSeat, flow: &Flow) -> Closing {
    let mut is_open = false;
    loop {
        match incoming.message().await {
            Ok(StreamRequest::Open { version: api::VERSION, max_hz }) => {
                is_open = true;
                let wants_scans = {
                    let mut pacer = flow.pacer();
                    pacer.set_rate(max_hz);
                    pacer.wants_scans()
                };
                seat.set_wants_scans(wants_scans);
            }
            Ok(StreamRequest::Open { version, .. }) => return Closing::wrong_version(version),
            Ok(StreamRequest::Acknowledge { .. }) if !is_open => {
                return Closing::Refused(texts::STREAM_NOT_OPENED.to_owned());
            }
            Ok(StreamRequest::Acknowledge { sequence }) => {
                if flow.pacer().acknowledged(sequence, Instant::now()).is_err() {
                    return Closing::Refused(texts::UNKNOWN_FRAME.to_owned());
                }
            }
            Err(closing) => return closing,
        }
        flow.requested.notify_one();
    }
}

/// Sends the latest scan whenever the pacer permits, until the connection fails.
async fn write_scans(
    sink: &mut Outgoing,
    mut scans: watch::Receiver<Option<Arc<LiveScan>>>,
    flow: &Flow,
    app: &App,
) -> Closing {
    // Browsers answer pings by themselves, so a paused stream is not taken for a broken one.
    let mut ping = tokio::time::interval((app.limits.silence / 3).max(Duration::from_millis(1)));
    loop {
        let permission = flow.pacer().permission(Instant::now());
        let sent = tokio::select! {
            _ = ping.tick() => sink.send(Message::Ping(Vec::new().into())).await.map_err(|_| Closing::Gone),
            () = flow.requested.notified() => Ok(()),
            () = sleep_until(permission) => Ok(()),
            changed = scans.changed(), if permission == Permission::Send => match changed {
                Ok(()) => send_latest(sink, &mut scans, flow).await,
                Err(_) => Err(Closing::Shutdown),
            },
        };
        if let Err(closing) = sent {
            return closing;
        }
    }
}

/// Waits for the instant that a permission names, or for ever.
async fn sleep_until(permission: Permission) {
    match permission {
        Permission::At(instant) => tokio::time::sleep_until(instant.into()).await,
        Permission::Send | Permission::AfterMessage => std::future::pending().await,
    }
}

async fn send_latest(
    sink: &mut Outgoing,
    scans: &mut watch::Receiver<Option<Arc<LiveScan>>>,
    flow: &Flow,
) -> Result<(), Closing> {
    let latest = scans.borrow_and_update().clone();
    let Some(scan) = latest.filter(|scan| scan.is_live(Instant::now())) else { return Ok(()) };
    let sequence = flow.pacer().sent(Instant::now());
    send(sink, api::encode(&ScanFrameRef::numbered(&scan.frame, sequence))).await
}
