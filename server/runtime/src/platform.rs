//! State of the server itself and of the battery, as clients see it.

use api::{Battery, Platform, ProcessRestart, RobotBody, SpeedLimits};
use messages::{BatteryState, RobotProfile};
use std::fs;
use std::time::Instant;
use store::Recordings;
use vocab::{Span, Stamp};

/// Measures the resources of this process. Values that the system does not give are zero.
pub struct PlatformProbe {
    robot: String,
    manual_limits: SpeedLimits,
    body: RobotBody,
    site: Option<String>,
    recordings: Recordings,
    restarts: Vec<ProcessRestart>,
    previous: Option<Reading>,
}

/// One measurement; the next one is compared with it.
struct Reading {
    when: Instant,
    robot_clock: Stamp,
    cpu_seconds: f64,
}

impl PlatformProbe {
    /// For a robot of this profile, at this simulated site if it is simulated.
    pub fn new(
        profile: RobotProfile,
        site: Option<String>,
        recordings: Recordings,
        restarts: Vec<ProcessRestart>,
    ) -> Self {
        let messages::SpeedLimits { forward_m_s, sideways_m_s, turn_rad_s } = profile.manual_limits;
        let manual_limits = SpeedLimits { forward_m_s, sideways_m_s, turn_rad_s };
        let body = RobotBody {
            footprint_radius_m: profile.footprint_radius_m,
            clearance_height_m: profile.clearance_height_m,
            standing_height_m: profile.standing_height_m,
            step_height_m: profile.step_height_m,
            camera_head: profile.camera_head,
        };
        Self { robot: profile.name, manual_limits, body, site, recordings, restarts, previous: None }
    }

    /// The state now; rates are since the last call.
    pub fn read(&mut self, robot_clock: Stamp) -> Platform {
        let reading = Reading { when: Instant::now(), robot_clock, cpu_seconds: cpu_seconds() };
        let (real_time_factor, cpu_cores) = self.previous.as_ref().map_or((1.0, 0.0), |previous| {
            let wall = (reading.when - previous.when).as_secs_f64().max(1e-3);
            let robot = (reading.robot_clock - previous.robot_clock).secs_f64();
            (robot / wall, (reading.cpu_seconds - previous.cpu_seconds) / wall)
        });
        self.previous = Some(reading);
        Platform {
            robot: self.robot.clone(),
            site: self.site.clone(),
            now: robot_clock,
            real_time_factor: real_time_factor as f32,
            cpu_cores: cpu_cores as f32,
            memory_bytes: resident_bytes(),
            disk_free_bytes: self.recordings.free_bytes().unwrap_or(0),
            // The gateway fills in these two.
            core_connected: true,
            clients: 0,
            // The gateway adds its own.
            restarts: self.restarts.clone(),
            manual_limits: Some(self.manual_limits),
            body: Some(self.body),
        }
    }
}

/// CPU time of this process so far, seconds.
fn cpu_seconds() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // proc(5): the command's name is in parentheses and may contain blanks and parentheses. utime and stime are the 12th and 13th fields
    // after the last parenthesis.
    let fields = stat.rsplit_once(") ").map_or("", |(_, fields)| fields).split(' ');
    let ticks: u64 = fields.skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
    ticks as f64 / rustix::param::clock_ticks_per_second() as f64
}

/// Resident memory of this process, bytes.
fn resident_bytes() -> u64 {
    let statm = fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages: u64 = statm.split(' ').nth(1).and_then(|pages| pages.parse().ok()).unwrap_or(0);
    pages * rustix::param::page_size() as u64
}

/// Parameters of the [`BatteryForecast`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryForecastConfig {
    /// Shortest time over which the rate of charge is measured. Chosen: within a minute the charge of a walk falls by a hundredth; shorter spans follow each stop.
    pub min_span: Span,
    /// Smallest change of charge (0 to 1) from which a rate is computed. Chosen: a hundredth of what a minute of walking uses (`missions::BatteryConfig`).
    pub min_change: f64,
}

impl Default for BatteryForecastConfig {
    fn default() -> Self {
        Self { min_span: Span::from_millis(60_000), min_change: 1e-4 }
    }
}

/// Predicts the time until the battery is empty or full, from the mean rate since charging or discharging began.
#[derive(Default)]
pub struct BatteryForecast {
    config: BatteryForecastConfig,
    /// State at which the present charging or discharging began.
    start: Option<BatteryState>,
}

impl BatteryForecast {
    /// Adds the battery's latest state and returns it with the prediction.
    pub fn update(&mut self, state: &BatteryState) -> Battery {
        let start = *self.start.get_or_insert(*state);
        let has_changed = start.charging != state.charging || state.stamp < start.stamp;
        if has_changed {
            self.start = Some(*state);
        }
        let left = if has_changed { None } else { time_left(&self.config, &start, state) };
        Battery { stamp: state.stamp, charge: state.charge, left, charging: state.charging }
    }
}

/// Time until the battery is empty, or full while it charges; `None` while the rate is not known.
fn time_left(config: &BatteryForecastConfig, start: &BatteryState, now: &BatteryState) -> Option<Span> {
    let elapsed = now.stamp - start.stamp;
    let change = f64::from(now.charge - start.charge);
    let remaining = if now.charging { 1.0 - f64::from(now.charge) } else { -f64::from(now.charge) };
    let is_known = elapsed >= config.min_span && change.abs() > config.min_change && change * remaining > 0.0;
    is_known.then(|| Span::from_secs_f64(elapsed.secs_f64() * remaining / change))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(secs: i64, charge: f32, charging: bool) -> BatteryState {
        BatteryState { stamp: Stamp::from_parts(secs, 0), charge, charging, ..BatteryState::default() }
    }

    #[test]
    fn a_battery_that_loses_one_percent_a_minute_lasts_one_minute_per_percent() {
        let mut forecast = BatteryForecast::default();
        assert_eq!(forecast.update(&state(0, 0.90, false)).left, None);
        assert_eq!(forecast.update(&state(30, 0.895, false)).left, None);
        let left = forecast.update(&state(60, 0.89, false)).left.expect("known after a minute");
        assert!((left.secs_f64() - 89.0 * 60.0).abs() < 1.0, "{left:?}");
        // On the dock the rate is measured anew.
        assert_eq!(forecast.update(&state(70, 0.89, true)).left, None);
        let left = forecast.update(&state(170, 0.94, true)).left.expect("known again");
        assert!((left.secs_f64() - 120.0).abs() < 1.0, "{left:?}");
    }

    #[test]
    fn this_process_uses_memory_and_time() {
        let start = cpu_seconds();
        while cpu_seconds() <= start {
            std::hint::black_box((0..1000).sum::<u64>());
        }
        assert!(resident_bytes() > 100_000);
    }
}
