//! Accepts connections, limits their number, and ends them when the gateway stops.

use crate::access::{AccessGate, TcpConnection, is_loopback};
use crate::address_places::AddressPlaces;
use crate::app::App;
use crate::client_io::{ClientIo, ConnectionPlace};
use crate::core_link;
use crate::hub::Hub;
use crate::limits::{FIXED, Limits};
use crate::tls::Encryption;
use crate::{GatewayConfig, GatewayError, router, texts, uploads};
use axum::Router;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::Service;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::future::Future;
use std::sync::Arc;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, mpsc, watch};
use watchdog::Heartbeat;

/// As [`crate::serve`], with limits of the caller's choice.
///
/// # Errors
/// When the address cannot be listened on.
pub async fn serve_with(
    config: GatewayConfig,
    limits: Limits,
    shutdown: impl Future<Output = ()>,
) -> Result<(), GatewayError> {
    let address = config.listen;
    let listen_error = |source| GatewayError::Listen { address, source };
    if config.access.is_demo && !is_loopback(address.ip()) {
        return Err(GatewayError::DemoOnNetwork { address });
    }
    let listener = TcpListener::bind(address).await.map_err(listen_error)?;
    let bound = listener.local_addr().map_err(listen_error)?;

    uploads::remove_partial(&config.data_dir).await;
    let encryption = Encryption::new(&config.tls).map_err(GatewayError::Tls)?;
    let hub = Arc::new(Hub::new(&limits, config.restart.clone(), AccessGate::new(&config.access)));
    let (stop, stopping) = watch::channel(false);
    let (alive, mut all_ended) = mpsc::channel(1);
    let app = Arc::new(App::new(&config, limits, hub.clone(), encryption, stopping, alive));

    tracing::info!(address = %bound, "listening");
    if let Some(on_ready) = config.on_ready {
        // If the caller does not wait for the address any more, the gateway serves all the same.
        on_ready.send(bound).ok();
    }
    tokio::select! {
        () = accept(listener, app) => {}
        () = core_link::run(&config.core_socket, &hub) => {}
        () = beat(config.heartbeat) => {}
        () = hub.report_uses() => {}
        () = hub.report_journal() => {}
        () = shutdown => {}
    }
    stop.send_replace(true);
    // Every connection holds the app, which holds `alive`: the channel closes with the last one. Nothing is ever sent on it.
    tokio::time::timeout(FIXED.shutdown_timeout, all_ended.recv()).await.ok();
    Ok(())
}

/// Shows that this task is polled, and that the threads of the runtime run tasks.
async fn beat(heartbeat: Option<Heartbeat>) {
    let Some(heartbeat) = heartbeat else { return std::future::pending().await };
    let mut interval = tokio::time::interval(FIXED.beat_period);
    loop {
        interval.tick().await;
        if tokio::spawn(async {}).await.is_ok() {
            heartbeat.beat();
        }
    }
}

async fn accept(listener: TcpListener, app: Arc<App>) {
    let places = Arc::new(Semaphore::new(app.limits.connections));
    let places_of_addresses = AddressPlaces::new(app.limits.connections_of_address);
    let router = router::router(app.clone());
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => {
                // Without it the connection has ended already.
                let Ok(local) = stream.local_addr() else { continue };
                let ordinary = (places_of_addresses.claim(peer.ip()), places.clone().try_acquire_owned());
                let (place, leave) = match ordinary {
                    (Some(_of_address), Ok(_of_server)) => {
                        (ConnectionPlace::Ordinary { _of_server, _of_address }, None)
                    }
                    _ => match app.reserved_places.claim(peer.ip()) {
                        Some((place, leave)) => (ConnectionPlace::Reserved(place), Some(leave)),
                        None => {
                            turn_away(&stream);
                            continue;
                        }
                    },
                };
                let about = TcpConnection {
                    peer: peer.ip(),
                    local: local.ip(),
                    is_tls: false,
                    lacks_tls: false,
                    reserved: place.reserved(),
                };
                let io = ClientIo::new(stream, app.limits.write_stall, place);
                let connection = begin_connection(io, router.clone(), about, app.clone());
                match leave {
                    None => drop(tokio::spawn(connection)),
                    // It ends as soon as its place is given to another one.
                    Some(leave) => drop(tokio::spawn(async {
                        tokio::select! { () = connection => {}, _ = leave => {} }
                    })),
                }
            }
            Err(error) => {
                tracing::warn!(%error, "could not accept a connection");
                tokio::time::sleep(FIXED.accept_pause).await;
            }
        }
    }
}

/// Answers a connection beyond the limit, without reading anything from it.
fn turn_away(stream: &TcpStream) {
    let detail = texts::NO_PLACE_FOR_CONNECTION;
    let answer = format!(
        "HTTP/1.1 503 Service Unavailable\r\ncontent-type: application/problem+json\r\nretry-after: 5\r\nconnection: close\r\n\r\n\
         {{\"status\":503,\"title\":\"Service Unavailable\",\"detail\":\"{detail}\"}}"
    );
    // A new connection's send buffer is empty, so this goes out whole or not at all.
    stream.try_write(answer.as_bytes()).ok();
}

/// Tells handlers which connection a request came over.
struct ConnectionService {
    router: TowerToHyperService<Router>,
    about: TcpConnection,
}

impl Service<Request<Incoming>> for ConnectionService {
    type Response = <TowerToHyperService<Router> as Service<Request<Incoming>>>::Response;
    type Error = <TowerToHyperService<Router> as Service<Request<Incoming>>>::Error;
    type Future = <TowerToHyperService<Router> as Service<Request<Incoming>>>::Future;

    fn call(&self, mut request: Request<Incoming>) -> Self::Future {
        request.extensions_mut().insert(self.about);
        self.router.call(request)
    }
}

/// Encrypts a connection, if this server does, and serves it.
async fn begin_connection(io: ClientIo, router: Router, about: TcpConnection, app: Arc<App>) {
    let service = |about| ConnectionService { router: TowerToHyperService::new(router), about };
    let Some(encryption) = &app.encryption else {
        return serve_connection(io, service(about), &app).await;
    };
    let handshake = async {
        if !io.begins_with_tls().await? {
            return Ok(Err(io));
        }
        encryption.accept(io, &about, &app.hub.access.hosts).await.map(Ok)
    };
    let begun = tokio::select! {
        begun = tokio::time::timeout(app.limits.header_timeout, handshake) => begun,
        () = app.shutdown() => return,
    };
    match begun {
        Ok(Ok(Ok(encrypted))) => {
            serve_connection(encrypted, service(TcpConnection { is_tls: true, ..about }), &app).await;
        }
        Ok(Ok(Err(plain))) => {
            serve_connection(plain, service(TcpConnection { lacks_tls: true, ..about }), &app).await;
        }
        Ok(Err(error)) => tracing::debug!(%error, "a connection could not be encrypted"),
        // It is silent.
        Err(_) => {}
    }
}

async fn serve_connection<Io>(io: Io, service: ConnectionService, app: &App)
where
    Io: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(app.limits.header_timeout)
        .max_headers(FIXED.max_request_headers)
        .max_buf_size(FIXED.max_request_head_bytes)
        .serve_connection(TokioIo::new(io), service)
        .with_upgrades();
    let mut connection = std::pin::pin!(connection);
    let ended = tokio::select! {
        ended = connection.as_mut() => ended,
        () = app.shutdown() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = ended {
        tracing::debug!(%error, "a connection ended early");
    }
}
