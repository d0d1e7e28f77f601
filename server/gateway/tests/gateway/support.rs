//! A gateway under test, the core it talks to, and the clients that talk to it.
//!
//! Nothing here sleeps: every wait is for a message or the end of a connection, within [`PATIENCE`].

use api::{ClientMessage, CoreMessage, Event, GatewayMessage, LeaseToken, ServerMessage};
use futures_util::{SinkExt, StreamExt};
use gateway::{GatewayConfig, Limits};
use std::collections::BTreeMap;
use std::future::Future;
use std::net::SocketAddr;
use std::time::Duration;
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpStream, UnixListener, UnixStream};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream};
use vocab::ClientId;

/// Longest wait for anything that should happen.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// Waits for what should happen.
pub async fn soon<F: Future>(what: &str, future: F) -> F::Output {
    match tokio::time::timeout(PATIENCE, future).await {
        Ok(output) => output,
        Err(_) => panic!("waited too long for {what}"),
    }
}

/// Allows as many open files as the system does: both ends of all connections are in this process.
pub fn raise_file_limit() {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let most = Rlimit { current: limit.maximum, maximum: limit.maximum };
    setrlimit(Resource::Nofile, most).expect("a limit up to the maximum");
}

/// A running gateway with its folders.
pub struct Gateway {
    pub address: SocketAddr,
    pub folder: TempDir,
    core: UnixListener,
    stop: oneshot::Sender<()>,
    task: JoinHandle<Result<(), gateway::GatewayError>>,
}

impl Gateway {
    pub async fn start() -> Self {
        Self::start_with(Limits::default()).await
    }

    pub async fn start_with(limits: Limits) -> Self {
        Self::start_again(limits, None).await
    }

    /// Starts a gateway that is told why it was started again.
    pub async fn start_again(limits: Limits, restart: Option<api::ProcessRestart>) -> Self {
        let demo = gateway::AccessConfig { is_demo: true, ..gateway::AccessConfig::default() };
        Self::start_for(demo, gateway::TlsConfig::None, limits, restart).await
    }

    /// Starts a gateway with sign-ins.
    pub async fn start_limited_with_sign_in(limits: Limits) -> Self {
        Self::start_for(gateway::AccessConfig::default(), gateway::TlsConfig::None, limits, None).await
    }

    /// Starts a demonstration with encrypted connections.
    pub async fn start_with_tls(tls: gateway::TlsConfig, limits: Limits) -> Self {
        let demo = gateway::AccessConfig { is_demo: true, ..gateway::AccessConfig::default() };
        Self::start_for(demo, tls, limits, None).await
    }

    async fn start_for(
        access: gateway::AccessConfig,
        tls: gateway::TlsConfig,
        limits: Limits,
        restart: Option<api::ProcessRestart>,
    ) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let core = UnixListener::bind(folder.path().join("core.sock")).expect("a Unix socket");
        let (on_ready, ready) = oneshot::channel();
        let config = GatewayConfig {
            listen: ([127, 0, 0, 1], 0).into(),
            core_socket: folder.path().join("core.sock"),
            data_dir: folder.path().join("data"),
            static_dir: folder.path().join("static"),
            access,
            tls,
            on_ready: Some(on_ready),
            heartbeat: None,
            restart,
        };
        let (stop, stopped) = oneshot::channel::<()>();
        let task = tokio::spawn(gateway::serve_with(config, limits, async {
            stopped.await.ok();
        }));
        let address = soon("the gateway", ready).await.expect("the gateway listens");
        Self { address, folder, core, stop, task }
    }

    /// Writes a file below the gateway's folder.
    pub fn write(&self, path: &str, content: &[u8]) {
        let file = self.folder.path().join(path);
        std::fs::create_dir_all(file.parent().expect("a parent")).expect("folders");
        std::fs::write(file, content).expect("a file");
    }

    /// The gateway's next connection to the core.
    pub async fn core(&self) -> TestCore {
        let (stream, _) = soon("a connection to the core", self.core.accept()).await.expect("accepted");
        let mut core = TestCore { stream };
        core.send(&CoreMessage::Hello { version: api::VERSION }).await;
        assert_eq!(core.receive().await, GatewayMessage::Hello { version: api::VERSION });
        core
    }

    /// As [`Gateway::core`], for a core that introduces itself as the test likes.
    pub async fn raw_core(&self) -> TestCore {
        let (stream, _) = soon("a connection to the core", self.core.accept()).await.expect("accepted");
        TestCore { stream }
    }

    /// Stops the gateway and waits for its end.
    pub async fn stop(self) {
        self.stop.send(()).ok();
        soon("the gateway's end", self.task).await.expect("no panic").expect("no error");
    }

    pub async fn socket(&self, path: &str) -> TestSocket {
        let url = format!("ws://{}{path}", self.address);
        let connecting = tokio_tungstenite::connect_async(url);
        let (stream, _) = soon("a WebSocket", connecting).await.expect("a WebSocket");
        TestSocket { stream }
    }

    /// Opens a WebSocket that claims to come from `origin`; the HTTP status if it is not let in.
    pub async fn socket_from(&self, path: &str, origin: &str) -> Result<TestSocket, u16> {
        self.socket_with(path, ("origin", origin)).await
    }

    /// As [`Gateway::socket`], with this header; the HTTP status if it is not let in.
    pub async fn socket_with(&self, path: &str, header: (&'static str, &str)) -> Result<TestSocket, u16> {
        use tokio_tungstenite::tungstenite::Error;
        let mut request = format!("ws://{}{path}", self.address).into_client_request().expect("a request");
        request.headers_mut().insert(header.0, header.1.parse().expect("a header"));
        match soon("a WebSocket", tokio_tungstenite::connect_async(request)).await {
            Ok((stream, _)) => Ok(TestSocket { stream }),
            Err(Error::Http(response)) => Err(response.status().as_u16()),
            Err(error) => panic!("{error}"),
        }
    }

    /// A control socket that has been welcomed.
    pub async fn client(&self, number: u128) -> TestSocket {
        let mut socket = self.socket(api::CONTROL_PATH).await;
        socket.send(&ClientMessage::Hello { version: api::VERSION, lease: lease(number) }).await;
        match socket.message().await {
            ServerMessage::Welcome { version: api::VERSION, .. } => socket,
            other => panic!("not welcomed but {other:?}"),
        }
    }

    /// Sends `GET path` with these header lines.
    pub async fn get(&self, path: &str, headers: &[&str]) -> Reply {
        self.request("GET", path, headers).await
    }

    pub async fn request(&self, method: &str, path: &str, headers: &[&str]) -> Reply {
        self.send(method, path, headers, b"").await
    }

    /// As [`Gateway::request`], with a body of which the header lines have to say how long it is.
    pub async fn send(&self, method: &str, path: &str, headers: &[&str], body: &[u8]) -> Reply {
        let mut head = format!("{method} {path} HTTP/1.1\r\nhost: {}\r\nconnection: close\r\n", self.address);
        headers.iter().for_each(|line| head.push_str(&format!("{line}\r\n")));
        head.push_str("\r\n");
        let mut stream = TcpStream::connect(self.address).await.expect("a connection");
        stream.write_all(head.as_bytes()).await.expect("written");
        stream.write_all(body).await.expect("written");
        let mut bytes = Vec::new();
        soon("a reply", stream.read_to_end(&mut bytes)).await.expect("read");
        Reply::parse(&bytes)
    }
}

/// An HTTP reply.
#[derive(Debug)]
pub struct Reply {
    pub status: u16,
    pub headers: BTreeMap<String, String>,
    pub body: Vec<u8>,
}

impl Reply {
    pub fn parse(bytes: &[u8]) -> Self {
        let split = bytes.windows(4).position(|window| window == b"\r\n\r\n").expect("a complete head");
        let head = std::str::from_utf8(&bytes[..split]).expect("text");
        let mut lines = head.split("\r\n");
        let status = lines.next().and_then(|line| line.split(' ').nth(1)).expect("a status");
        let headers: BTreeMap<String, String> = lines
            .filter_map(|line| line.split_once(':'))
            .map(|(name, value)| (name.to_ascii_lowercase(), value.trim().to_owned()))
            .collect();
        let mut body = bytes[split + 4..].to_vec();
        if headers.contains_key("transfer-encoding") {
            body = joined(&body);
        }
        Self { status: status.parse().expect("a number"), headers, body }
    }

    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", String::as_str)
    }

    pub fn json(&self) -> serde_json::Value {
        serde_json::from_slice(&self.body).expect("JSON")
    }

    /// Fails unless this is a problem document with this status.
    #[track_caller]
    pub fn expect_problem(&self, status: u16) {
        assert_eq!(
            (self.status, self.header("content-type")),
            (status, "application/problem+json"),
            "{self:?}"
        );
        let problem: api::Problem = serde_json::from_slice(&self.body).expect("a problem");
        assert_eq!(problem.status, status);
        assert!(problem.detail.ends_with('.') && problem.detail.len() > 15, "a sentence: {problem:?}");
    }
}

/// The content of a body in chunks. Fails without the chunk of no bytes that ends it.
fn joined(mut chunks: &[u8]) -> Vec<u8> {
    let mut content = Vec::new();
    loop {
        let line = chunks.windows(2).position(|window| window == b"\r\n").expect("the length of a chunk");
        let length = std::str::from_utf8(&chunks[..line]).expect("text");
        let length = usize::from_str_radix(length, 16).expect("a number");
        if length == 0 {
            return content;
        }
        content.extend_from_slice(&chunks[line + 2..line + 2 + length]);
        chunks = &chunks[line + 4 + length..];
    }
}

/// The core's end of the Unix socket.
pub struct TestCore {
    stream: UnixStream,
}

impl TestCore {
    pub async fn send(&mut self, message: &CoreMessage) {
        let body = api::encode(message);
        self.send_bytes(&(body.len() as u32).to_le_bytes()).await;
        self.send_bytes(&body).await;
    }

    pub async fn send_bytes(&mut self, bytes: &[u8]) {
        soon("the gateway to read", self.stream.write_all(bytes)).await.expect("written");
    }

    /// Publishes an event to all clients.
    pub async fn publish(&mut self, event: Event) {
        self.send(&CoreMessage::Event { to: None, event }).await;
    }

    /// The gateway's next message, but for lists of the clients and what is for the audit log.
    pub async fn receive(&mut self) -> GatewayMessage {
        loop {
            match self.receive_any().await {
                GatewayMessage::Clients(_) | GatewayMessage::Audit(_) => {}
                message => return message,
            }
        }
    }

    /// Waits for a note for the audit log for which `take` has a value.
    pub async fn note<T>(&mut self, mut take: impl FnMut(&api::AuditNote) -> Option<T>) -> T {
        loop {
            if let GatewayMessage::Audit(notes) = self.receive_any().await
                && let Some(found) = notes.iter().find_map(&mut take)
            {
                return found;
            }
        }
    }

    /// Waits until the gateway says that these clients are connected.
    pub async fn clients(&mut self, expected: &[ClientId]) {
        while self.receive_any().await != GatewayMessage::Clients(expected.to_vec()) {}
    }

    async fn receive_any(&mut self) -> GatewayMessage {
        let mut length = [0; 4];
        soon("a message to the core", self.stream.read_exact(&mut length)).await.expect("a length");
        let mut body = vec![0; u32::from_le_bytes(length) as usize];
        soon("a message to the core", self.stream.read_exact(&mut body)).await.expect("a body");
        api::decode(&body).expect("a message")
    }

    /// The next message that is a command.
    pub async fn command(&mut self) -> GatewayMessage {
        loop {
            match self.receive().await {
                GatewayMessage::Listeners { .. } | GatewayMessage::CredentialsUsed(_) => {}
                message => return message,
            }
        }
    }

    /// Waits until the gateway reports these listeners.
    pub async fn listeners(&mut self, expected: (u32, u32)) {
        loop {
            if let GatewayMessage::Listeners { clients, streams } = self.receive().await
                && (clients, streams) == expected
            {
                return;
            }
        }
    }

    /// Waits until the gateway hangs up.
    pub async fn closed(&mut self) {
        let mut rest = Vec::new();
        // Broken or ended: either is an end.
        soon("the gateway to hang up", self.stream.read_to_end(&mut rest)).await.ok();
    }
}

/// A WebSocket client.
pub struct TestSocket {
    stream: WebSocketStream<MaybeTlsStream<TcpStream>>,
}

impl TestSocket {
    pub async fn send(&mut self, message: &impl serde::Serialize) {
        self.send_raw(Message::Binary(api::encode(message).into())).await;
    }

    pub async fn send_raw(&mut self, message: Message) {
        soon("the gateway to read", self.stream.send(message)).await.ok();
    }

    /// The next message; `None` after the end.
    pub async fn next<T: serde::de::DeserializeOwned>(&mut self) -> Option<T> {
        loop {
            match soon("a message to the client", self.stream.next()).await? {
                Ok(Message::Binary(bytes)) => return Some(api::decode(&bytes).expect("a message")),
                Ok(Message::Close(_)) | Err(_) => return None,
                Ok(_) => {}
            }
        }
    }

    pub async fn message(&mut self) -> ServerMessage {
        self.next().await.expect("the socket is open")
    }

    /// The next event and its number.
    pub async fn event(&mut self) -> (u64, Event) {
        loop {
            match self.message().await {
                ServerMessage::Event { sequence, event } => return (sequence, event),
                ServerMessage::Pong { .. } => {}
                other => panic!("no event but {other:?}"),
            }
        }
    }

    /// The next event for which `take` has a value.
    pub async fn find<T>(&mut self, mut take: impl FnMut(&Event) -> Option<T>) -> T {
        loop {
            if let Some(found) = take(&self.event().await.1) {
                return found;
            }
        }
    }

    /// The sentence with which the server refuses to go on; fails if it does not, or does not close after it.
    pub async fn refusal(&mut self) -> String {
        loop {
            if let ServerMessage::Refused { reason } = self.message().await {
                assert_eq!(self.next::<ServerMessage>().await, None, "closed after refusing");
                return reason;
            }
        }
    }

    /// Waits for the end, whatever comes before.
    pub async fn ended(&mut self) {
        while let Some(Ok(message)) = soon("the end of the socket", self.stream.next()).await {
            if message.is_close() {
                return;
            }
        }
    }

    /// The TCP connection below.
    pub fn tcp(&mut self) -> &mut TcpStream {
        match self.stream.get_mut() {
            MaybeTlsStream::Plain(stream) => stream,
            _ => unreachable!("no TLS here"),
        }
    }
}

/// A client's secret.
pub fn lease(number: u128) -> LeaseToken {
    LeaseToken(uuid::Uuid::from_u128(number))
}

/// The id of the client with this secret, where nobody signs in.
pub fn client_id(number: u128) -> ClientId {
    gateway::socket_client(lease(number), None)
}

/// A client as the core is told of it where nobody signs in.
pub fn caller(number: u128) -> api::Caller {
    api::Caller { address: Some([127, 0, 0, 1].into()), ..client_id(number).into() }
}
