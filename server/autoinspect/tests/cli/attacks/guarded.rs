//! A platform where people have to sign in, with a robot whose commands are noted on their way.

use super::tap::RobotTap;
use crate::core_process::RobotProcess;
use crate::platform::RunningPlatform;
use crate::program::{json, program, text};
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;
use tempfile::TempDir;

/// Longest wait for one answer, in all attacks.
pub const ANSWER_LIMIT: Duration = Duration::from_secs(30);

pub const PASSWORD: &str = "correct horse battery";

/// The platform. Its parts end in the order of the fields.
pub struct GuardedPlatform {
    platform: RunningPlatform,
    _robot: RobotProcess,
    pub tap: RobotTap,
    pub tokens: Tokens,
    _dir: TempDir,
}

/// Secrets of programs: one of each role, and two operators that attack.
pub struct Tokens {
    pub viewer: String,
    pub operator: String,
    pub admin: String,
    pub attackers: [String; 2],
}

impl GuardedPlatform {
    /// Starts it, with an account `ada`, who may operate.
    pub fn start(access: &[&str]) -> Self {
        let dir = tempfile::tempdir().expect("temporary directory");
        let data = dir.path().join("data");
        std::fs::create_dir_all(&data).expect("made");
        add_account(&data, "ada", "operator");
        add_account(&data, "root", "admin");
        let token = |name, role| add_token(&data, name, role);
        let tokens = Tokens {
            viewer: token("viewer", "viewer"),
            operator: token("operator", "operator"),
            admin: token("admin", "admin"),
            attackers: [token("attacker one", "operator"), token("attacker two", "operator")],
        };
        let robot =
            RobotProcess::start(&dir.path().join("robot"), &["--lidar-columns", "50", "--people", "0"]);
        crate::fake_gateway::until("the robot listens", || robot.socket.exists().then_some(()));
        let tap = RobotTap::start(dir.path(), robot.socket.clone());
        let robot_name = format!("socket:{}", tap.socket.display());
        let arguments = [access, &["--robot", &robot_name]].concat();
        let platform = RunningPlatform::launch(dir.path(), &arguments, &[]);
        Self { platform, _robot: robot, tap, tokens, _dir: dir }
    }

    pub fn address(&self) -> SocketAddr {
        self.platform.address()
    }

    /// Folder of its data.
    pub fn data(&self) -> std::path::PathBuf {
        self._dir.path().join("data")
    }

    /// Id of its process with this role.
    pub fn process(&self, role: &str) -> u32 {
        self.platform.process(role).expect("runs")
    }
}

impl Drop for GuardedPlatform {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("the platform said:\n{}", self.platform.complaints());
        }
    }
}

fn add_account(data: &Path, name: &str, role: &str) {
    let mut child = program()
        .args(["account", "--data", text(data), "add", name, "--role", role])
        .stdin(Stdio::piped())
        .spawn()
        .expect("starts");
    child.stdin.take().expect("piped").write_all(format!("{PASSWORD}\n").as_bytes()).expect("written");
    assert!(child.wait().expect("ends").success());
}

fn add_token(data: &Path, name: &str, role: &str) -> String {
    let made = json(&["account", "--data", text(data), "token", "add", name, "--role", role]);
    made["secret"].as_str().expect("a secret").to_owned()
}

/// Connects from another address of this computer: 127.0.0.`last`.
pub fn connect_from(last: u8, address: SocketAddr) -> std::io::Result<TcpStream> {
    let socket = socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None)?;
    let own = SocketAddr::new(IpAddr::V4(Ipv4Addr::new(127, 0, 0, last)), 0);
    socket.bind(&own.into())?;
    socket.connect_timeout(&address.into(), Duration::from_secs(5))?;
    let stream = TcpStream::from(socket);
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(ANSWER_LIMIT))?;
    stream.set_write_timeout(Some(ANSWER_LIMIT))?;
    Ok(stream)
}

/// A request as bytes; `head` are further header lines.
pub fn request_bytes(method: &str, path: &str, head: &str, body: &[u8]) -> Vec<u8> {
    let length = body.len();
    let start = format!(
        "{method} {path} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\ncontent-length: {length}\r\n{head}\r\n"
    );
    [start.as_bytes(), body].concat()
}

/// Sends a request over a connection of its own, and returns status and the whole answer.
pub fn ask(mut stream: impl Read + Write, request: &[u8]) -> std::io::Result<(u16, String)> {
    stream.write_all(request)?;
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer)?;
    let answer = String::from_utf8_lossy(&answer).into_owned();
    let status = answer.split(' ').nth(1).and_then(|status| status.parse().ok());
    status.map(|status| (status, answer)).ok_or_else(|| std::io::ErrorKind::UnexpectedEof.into())
}

/// The header line of a token.
pub fn bearer(token: &str) -> String {
    format!("authorization: Bearer {token}\r\n")
}
