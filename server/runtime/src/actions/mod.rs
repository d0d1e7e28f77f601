//! Performs the actions that the stack calls, on a thread of its own: those of the robot through its [`ports::ActionServer`], and those that need no robot (`wait`,
//! `message`, `point_cloud`). What an action has gathered is on the disk before the stack hears of its success.
//!
//! | what waits | policy |
//! | --- | --- |
//! | calls | refused beyond [`ActionConfig::max_waiting`], and beyond [`ActionConfig::max_open`] that are under way: the call has failed |
//! | scans for a point cloud | the newest is left out while the thread stores something |
//! | feedback | left out if the last of its call is newer than [`ActionConfig::feedback_period`] |
//! | ends | kept; the thread waits for the control loop, which never waits for it |

mod aim;
mod own_action;
mod place;
#[cfg(test)]
mod robot_tests;
mod sight;
#[cfg(test)]
mod tests;
mod worker;

pub use sight::SightChecker;
pub use worker::{ActionWorker, OpenActions};

use crate::texts;
use aim::AimConfig;
use crossbeam_channel::{Receiver, Sender};
use messages::{ActionOutcome, CorrectedScan, Input, Publication};
use place::RecentPlaces;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use vocab::{ActionCallId, Span};

/// Parameters of the [`ActionWorker`] and its queue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionConfig {
    /// Calls and cancellations that may wait for the thread. Chosen: a call and a cancellation of each action that may be open.
    pub max_waiting: usize,
    /// Actions that may be under way at a time. It is that of all action servers.
    pub max_open: usize,
    /// Ends and feedback that may wait for the control loop. Chosen: four of each action that may be open.
    pub max_results: usize,
    /// Scans that may wait for the thread. Chosen: most of a second at 10 Hz.
    pub max_scans: usize,
    /// Time between two looks at the robot's clock while an action waits for it. Chosen: less than a step of control (50 ms).
    pub poll_period: Duration,
    /// Shortest time between two feedbacks of a call, on the robot's clock. Each is recorded. Chosen: people see progress each second.
    pub feedback_period: Span,
    /// Points of a point cloud at most: 48 MB of its file. Chosen: below the largest file that is stored, 64 MB ([`store::BlobsConfig`]).
    pub max_cloud_points: usize,
    /// Longest `wait`, seconds: the maximum in the schema of the catalogue. Chosen: a day, longer than any wait of a mission that still makes sense.
    pub max_wait_s: f64,
    /// Longest gathering of scans for a `point_cloud`, seconds: the maximum in the schema of the catalogue. Chosen: a minute, after which a standing LiDAR sees nothing
    /// new.
    pub max_capture_s: f64,
    /// Estimates of the pose that are kept, for reports of what was found a little earlier: 8 s at 30 a second. Chosen: longer than a picture takes to come.
    pub max_estimates: usize,
    /// Parameters of aiming the camera.
    pub aim: AimConfig,
}

impl Default for ActionConfig {
    fn default() -> Self {
        Self {
            max_waiting: 32,
            max_open: ports::MAX_OPEN_ACTIONS,
            max_results: 64,
            max_scans: 8,
            poll_period: Duration::from_millis(20),
            feedback_period: Span::from_millis(1_000),
            max_cloud_points: 3_000_000,
            max_wait_s: 86_400.0,
            max_capture_s: 60.0,
            max_estimates: 256,
            aim: AimConfig::default(),
        }
    }
}

/// What the control loop asks the thread for.
enum ActionRequest {
    Call { call: ActionCallId, action: String, parameters: String },
    Cancel(ActionCallId),
}

/// The control loop's end. Nothing here blocks.
pub struct ActionQueue {
    requests: Sender<ActionRequest>,
    scans: Sender<CorrectedScan>,
    places: Arc<RecentPlaces>,
    open_captures: Arc<AtomicUsize>,
}

/// The thread's end.
pub struct ActionInbox {
    requests: Receiver<ActionRequest>,
    scans: Receiver<CorrectedScan>,
    places: Arc<RecentPlaces>,
    /// Point clouds that are being gathered. Scans are sent only then.
    open_captures: Arc<AtomicUsize>,
}

impl ActionQueue {
    /// Both ends.
    pub fn new(config: &ActionConfig) -> (Self, ActionInbox) {
        let (request_sender, requests) = crossbeam_channel::bounded(config.max_waiting);
        let (scan_sender, scans) = crossbeam_channel::bounded(config.max_scans);
        let places = Arc::new(RecentPlaces::new(config.max_estimates));
        let open_captures = Arc::<AtomicUsize>::default();
        let queue = Self {
            requests: request_sender,
            scans: scan_sender,
            places: Arc::clone(&places),
            open_captures: Arc::clone(&open_captures),
        };
        (queue, ActionInbox { requests, scans, places, open_captures })
    }

    /// Hands in a call. Returns its end if it fails at once.
    pub fn call(&self, call: ActionCallId, action: String, parameters: String) -> Option<Input> {
        let is_refused = self.requests.try_send(ActionRequest::Call { call, action, parameters }).is_err();
        is_refused.then(|| failed(call, texts::TOO_MANY_ACTIONS.to_owned()))
    }

    /// Hands in a cancellation.
    pub fn cancel(&self, call: ActionCallId) {
        if self.requests.try_send(ActionRequest::Cancel(call)).is_err() {
            // Whoever called waits for its end anyway.
            tracing::warn!("the cancellation of the action {call} was left out, because too many wait");
        }
    }

    /// Follows what the stack publishes of the robot's place.
    pub fn watch(&self, publication: &Publication) {
        match publication {
            Publication::Estimate(estimate) => self.places.update(estimate),
            Publication::Localisation(state) => self.places.update_localisation(*state),
            Publication::Scan(scan) if self.open_captures.load(Ordering::Relaxed) > 0 => {
                // One that finds no room is left out: the next one follows in a tenth of a second.
                let _ = self.scans.try_send(scan.clone());
            }
            _ => {}
        }
    }
}

fn failed(call: ActionCallId, reason: String) -> Input {
    Input::ActionDone { call, outcome: ActionOutcome::Failed { reason } }
}
