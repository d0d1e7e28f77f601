//! A case of the crash tests: the situation in which the program is killed, and what has to hold afterwards.

use super::client::{CoreClient, CoreState};
use super::inventory::recorded_until;
use api::Command;
use std::path::Path;
use vocab::{MapId, SessionId, Span, Stamp, Twist, UploadId, Vec3};

/// Longest time of a mapping session that a kill may lose.
const LOSS_LIMIT: Span = Span::from_millis(1000);

/// What the program does when it is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrashSituation {
    Mapping,
    Saving,
    Localising,
    Importing,
    Idle,
}

impl CrashSituation {
    pub fn name(self) -> &'static str {
        match self {
            Self::Mapping => "mapping",
            Self::Saving => "saving",
            Self::Localising => "localising",
            Self::Importing => "importing",
            Self::Idle => "idle",
        }
    }
}

/// A session that becomes a map.
pub struct SavedAs {
    pub session: SessionId,
    pub map: MapId,
    /// Keyframes that it has at least.
    pub keyframes: u32,
    /// Whether the map was listed before the kill.
    pub is_saved: bool,
}

/// What has to hold after the next start.
#[derive(Default)]
pub struct Killed {
    /// What was killed and when.
    pub what: String,
    /// A session that ran.
    pub session: Option<CrashSession>,
    /// What was being saved: afterwards there is the session or the map.
    pub saving: Option<SavedAs>,
    /// The file of which a map was being made, and the map's name.
    pub importing: Option<(UploadId, String)>,
    /// The map that the robot must know to be in, if that is certain; or that it may be in.
    pub localised: Option<MapId>,
    /// State of the stop of motion that was being written.
    pub stop_in_flight: Option<bool>,
}

/// What clients had seen of a session when its process was killed.
pub struct CrashSession {
    pub id: SessionId,
    /// Instants of its keyframes.
    pub keyframes: Vec<Stamp>,
    /// Instant of the newest estimate.
    pub now: Option<Stamp>,
    /// Instant of the last recorded input; of the first estimate if none was recorded.
    pub recorded_until: Option<Stamp>,
}

impl CrashSession {
    pub fn of(id: SessionId, state: &CoreState, data: &Path) -> Self {
        let keyframes = state.keyframes.values().copied().collect();
        Self { id, keyframes, now: state.now, recorded_until: recorded_until(data).or(state.began) }
    }

    /// Keyframes that must be there after a kill: those older than the second that may be lost.
    pub fn certain_keyframes(&self) -> u32 {
        let is_certain = |stamp: &&Stamp| self.now.is_some_and(|now| now - **stamp > LOSS_LIMIT);
        self.keyframes.iter().filter(is_certain).count() as u32
    }

    /// Time of the session that is gone, seconds.
    pub fn lost_s(&self, recovered_until: Stamp) -> f64 {
        self.now.map_or(0.0, |now| (now - recovered_until).secs_f64().max(0.0))
    }
}

/// A slow walk on a circle, which stays where the map is.
pub fn drive(client: &mut CoreClient) {
    let velocity = Twist { linear: Vec3::new(0.6, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, 0.3) };
    client.send(Command::Teleoperate(velocity));
}

/// Begins a session, and walks until it has some keyframes.
pub fn map_until(client: &mut CoreClient, session: SessionId, keyframes: usize) -> Result<(), String> {
    client.command(Command::TakeControl { name: "Test".to_owned() })?;
    client.command(Command::StartMapping(session))?;
    client.until_with("keyframes", drive, |state| state.keyframes.len() >= keyframes)
}
