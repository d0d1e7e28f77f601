//! State of the server itself and of the battery, as clients see it.

use api::{Battery, Platform};
use messages::BatteryState;
use std::fs;
use std::time::Instant;
use store::Recordings;
use vocab::{Span, Stamp};

/// Reads what this process uses. Figures that the system does not give are zero.
pub struct PlatformProbe {
    robot: String,
    site: Option<String>,
    recordings: Recordings,
    before: Option<Reading>,
}

/// What was read a second ago.
struct Reading {
    when: Instant,
    robot_clock: Stamp,
    cpu_seconds: f64,
}

impl PlatformProbe {
    /// For a robot of this name, at this simulated site if it is simulated.
    pub fn new(robot: String, site: Option<String>, recordings: Recordings) -> Self {
        Self { robot, site, recordings, before: None }
    }

    /// The state now; rates are since the last call.
    pub fn read(&mut self, robot_clock: Stamp) -> Platform {
        let reading = Reading { when: Instant::now(), robot_clock, cpu_seconds: cpu_seconds() };
        let (real_time_factor, cpu_cores) = self.before.as_ref().map_or((1.0, 0.0), |before| {
            let wall = (reading.when - before.when).as_secs_f64().max(1e-3);
            let robot = (reading.robot_clock - before.robot_clock).secs_f64();
            (robot / wall, (reading.cpu_seconds - before.cpu_seconds) / wall)
        });
        self.before = Some(reading);
        Platform {
            robot: self.robot.clone(),
            site: self.site.clone(),
            now: robot_clock,
            real_time_factor: real_time_factor as f32,
            cpu_cores: cpu_cores as f32,
            memory_bytes: resident_bytes(),
            disk_free_bytes: self.recordings.free_bytes().unwrap_or(0),
            // The gateway is who knows these two; it fills them in.
            core_connected: true,
            clients: 0,
        }
    }
}

/// CPU time of this process so far, seconds.
fn cpu_seconds() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The command's name is in parentheses and may hold anything, so count from its end: utime and stime are the
    // 12th and 13th fields after it.
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

/// Says how long the battery lasts, from how fast its charge has changed.
#[derive(Default)]
pub struct BatteryForecast {
    /// Where the present stretch of charging or discharging began.
    anchor: Option<BatteryState>,
}

/// Shortest stretch from which a rate is taken.
const FORECAST_AFTER: Span = Span::from_millis(60_000);

impl BatteryForecast {
    /// Looks at the battery's latest state.
    pub fn look(&mut self, state: &BatteryState) -> Battery {
        let anchor = *self.anchor.get_or_insert(*state);
        let turned = anchor.charging != state.charging || state.stamp < anchor.stamp;
        if turned {
            self.anchor = Some(*state);
        }
        let left = if turned { None } else { time_left(&anchor, state) };
        Battery { stamp: state.stamp, charge: state.charge, left, charging: state.charging }
    }
}

/// Until empty, or until full while charging; none while there is too little to go by.
fn time_left(since: &BatteryState, now: &BatteryState) -> Option<Span> {
    let elapsed = now.stamp - since.stamp;
    let change = f64::from(now.charge - since.charge);
    let to_go = if now.charging { 1.0 - f64::from(now.charge) } else { -f64::from(now.charge) };
    let known = elapsed >= FORECAST_AFTER && change.abs() > 1e-4 && change * to_go > 0.0;
    known.then(|| Span::from_secs_f64(elapsed.secs_f64() * to_go / change))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(secs: i64, charge: f32, charging: bool) -> BatteryState {
        BatteryState { stamp: Stamp::from_parts(secs, 0), charge, charging, ..BatteryState::default() }
    }

    #[test]
    fn a_battery_that_loses_a_hundredth_in_a_minute_lasts_as_many_minutes_as_it_has_hundredths() {
        let mut forecast = BatteryForecast::default();
        assert_eq!(forecast.look(&state(0, 0.90, false)).left, None);
        assert_eq!(forecast.look(&state(30, 0.895, false)).left, None);
        let left = forecast.look(&state(60, 0.89, false)).left.expect("known after a minute");
        assert!((left.secs_f64() - 89.0 * 60.0).abs() < 1.0, "{left:?}");
        // On the dock the rate of before says nothing.
        assert_eq!(forecast.look(&state(70, 0.89, true)).left, None);
        let left = forecast.look(&state(170, 0.94, true)).left.expect("known again");
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
