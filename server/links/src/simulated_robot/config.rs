//! Parameters of the simulated robot.

use super::wait_budget::WaitBudgetConfig;
use sim::SimConfig;
use std::path::PathBuf;
use std::time::Duration;
use vocab::{Span, Vec3};

/// Parameters of a [`super::SimulatedRobot`].
pub struct SimulatedRobotConfig {
    /// Parameters of the simulation. Given by the caller.
    pub sim: SimConfig,
    /// Robot seconds per second of this computer. Given by the caller; 1 is real time.
    pub speed: f64,
    /// Path of the Unix socket. Given by the caller.
    pub socket: PathBuf,
    /// File for the ground truth, for scorers. Given by the caller.
    pub truth: Option<PathBuf>,
    /// Velocity of slipping feet over the ground in the base frame, m/s, for the fault "feet slip". Chosen: a third of a walk, so that it is plain in the odometry.
    pub slip_velocity_m_s: Vec3,
    /// Time for which the robot is carried, for the fault "carried away". Chosen: longer than the odometry needs to notice it (1 s of standing legs and 0.7 s of motion).
    pub carry_duration: Span,
    /// Longest duration of a fault. Chosen: an hour, longer than a session in which people try faults.
    pub max_fault_duration: Span,
    /// Simulated time of a step. Between steps the robot reads this computer's clock and the commands. Chosen: commands are late by a fifth of a step of control (50 ms)
    /// at most.
    pub step: Span,
    /// Largest number of messages in the queue to the core, about 0.05 s of the robot. Short: on a computer that is too slow the queue is always full, every command
    /// then is as late as the queue is long, and with a second the robot swings to and fro. So the simulated time goes more slowly instead.
    pub max_queued_messages: usize,
    /// How long the simulation waits for a core while that queue is full.
    pub wait: WaitBudgetConfig,
    /// Largest number of faults, and of requests about actions, that wait for the next step. A core that asks for more is disconnected. Chosen: four times the actions
    /// that may be open.
    pub max_pending_requests: usize,
    /// Longest time for the greeting of a core. Chosen: a core that lives greets at once.
    pub hello_timeout: Duration,
    /// Longest wait without a sign of life: half of the second in which `on_step` is called. A robot that lives a thousand times more slowly than this
    /// computer waits for 10 s between two steps.
    pub sign_of_life_period: Duration,
    /// Called by the simulation's thread at least every second while it lives, so that somebody can notice if it hangs. Given by the caller.
    pub on_step: Option<OnStep>,
}

/// Called by the simulation's thread again and again.
pub type OnStep = Box<dyn Fn() + Send>;

impl SimulatedRobotConfig {
    /// Default parameters.
    pub fn new(sim: SimConfig, speed: f64, socket: PathBuf) -> Self {
        Self {
            sim,
            speed,
            socket,
            truth: None,
            slip_velocity_m_s: Vec3::new(0.25, 0.1, 0.0),
            carry_duration: Span::from_millis(10_000),
            max_fault_duration: Span::from_millis(3_600_000),
            step: Span::from_millis(10),
            max_queued_messages: 32,
            wait: WaitBudgetConfig::default(),
            max_pending_requests: 64,
            hello_timeout: Duration::from_secs(1),
            sign_of_life_period: Duration::from_millis(500),
            on_step: None,
        }
    }
}
