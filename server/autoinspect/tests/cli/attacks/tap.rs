//! A relay between core and simulated robot that notes when the robot is told to move and to stop.

use crate::fake_gateway::PATIENCE;
use links::{MAX_REQUEST_BYTES, RobotRequest};
use std::io::{self, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// When the robot was told to move and to stand, last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Told {
    pub moving: Option<Instant>,
    pub standing: Option<Instant>,
}

/// The relay. The core connects to it as to the robot.
pub struct RobotTap {
    pub socket: PathBuf,
    told: Arc<(Mutex<Told>, Condvar)>,
}

impl RobotTap {
    /// Listens in this directory for the core of the robot that listens at `robot`.
    pub fn start(dir: &Path, robot: PathBuf) -> Self {
        let socket = dir.join("tap.sock");
        let listener = UnixListener::bind(&socket).expect("a Unix socket");
        let told: Arc<(Mutex<Told>, Condvar)> = Arc::default();
        let noted = Arc::clone(&told);
        thread::spawn(move || {
            for core in listener.incoming() {
                let (Ok(core), Ok(robot)) = (core, UnixStream::connect(&robot)) else { return };
                let (from_core, to_robot) = (copy(&core), copy(&robot));
                let noted = Arc::clone(&noted);
                thread::spawn(move || relay_requests(from_core, to_robot, &noted));
                thread::spawn(move || {
                    let _ = io::copy(&mut &robot, &mut &core);
                    let _ = core.shutdown(Shutdown::Both);
                });
            }
        });
        Self { socket, told }
    }

    /// Waits until the robot has been told what `is_met` accepts.
    fn wait(&self, what: &str, is_met: impl Fn(&Told) -> bool) -> Told {
        let told = self.told.0.lock().expect("no thread panics with it");
        let (told, waited) = self
            .told
            .1
            .wait_timeout_while(told, PATIENCE, |told| !is_met(told))
            .expect("no thread panics with it");
        assert!(!waited.timed_out(), "the robot was not told within the limit: {what}");
        *told
    }

    /// Waits until the robot is being driven: it was told to move after `since`. Does something meanwhile.
    pub fn wait_until_driven(&self, since: Instant, mut meanwhile: impl FnMut()) {
        crate::fake_gateway::until("the robot is told to move", || {
            meanwhile();
            let told = *self.told.0.lock().expect("no thread panics with it");
            told.moving.filter(|moving| *moving > since)
        });
    }

    /// Waits until the robot is told to stand after `since`, and returns the time until then.
    pub fn wait_until_stopped(&self, since: Instant) -> Duration {
        let told = self.wait("to stand", |told| told.standing.is_some_and(|standing| standing > since));
        told.standing.expect("waited for").saturating_duration_since(since)
    }
}

fn copy(stream: &UnixStream) -> UnixStream {
    stream.try_clone().expect("a second handle")
}

/// Passes the core's requests on, and notes those to drive before the robot gets them.
fn relay_requests(mut core: UnixStream, mut robot: UnixStream, told: &(Mutex<Told>, Condvar)) {
    let mut frame = Vec::new();
    loop {
        frame.resize(4, 0);
        if core.read_exact(&mut frame).is_err() {
            break;
        }
        let length = u32::from_le_bytes([frame[0], frame[1], frame[2], frame[3]]) as usize;
        assert!(length <= MAX_REQUEST_BYTES, "a core sends short requests");
        frame.resize(4 + length, 0);
        if core.read_exact(&mut frame[4..]).is_err() {
            break;
        }
        if let Ok(RobotRequest::Drive(drive)) = api::decode(&frame[4..]) {
            let mut noted = told.0.lock().expect("no thread panics with it");
            let is_standing = drive.velocity == vocab::Twist::default();
            let slot = if is_standing { &mut noted.standing } else { &mut noted.moving };
            *slot = Some(Instant::now());
            told.1.notify_all();
        }
        if robot.write_all(&frame).is_err() {
            break;
        }
    }
    // The robot notices that its core has gone.
    let _ = robot.shutdown(Shutdown::Both);
}
