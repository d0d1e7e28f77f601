//! The limits of the control thread: CPU time of the steps that take a scan.

use benches::quantile;

/// Limit of the 99.9th percentile, milliseconds: a quarter of the time between two scans at 10 Hz.
const P999_MAX_MS: f64 = 25.0;
/// Limit of the longest step, milliseconds.
const STEP_MAX_MS: f64 = 60.0;

/// CPU times of the steps of a walk that took a scan.
pub struct StepTimes {
    /// Milliseconds, ascending.
    ascending_ms: Vec<f64>,
}

impl StepTimes {
    /// From times in any order, milliseconds.
    pub fn new(mut times_ms: Vec<f64>) -> Self {
        times_ms.sort_by(f64::total_cmp);
        Self { ascending_ms: times_ms }
    }

    /// Whether the limits are met. A walk without scans does not meet them.
    pub fn meets_bar(&self) -> bool {
        quantile(&self.ascending_ms, 0.999) <= P999_MAX_MS && quantile(&self.ascending_ms, 1.0) <= STEP_MAX_MS
    }

    /// Prints the names of the columns.
    #[allow(clippy::print_stdout, reason = "the table is this program's output")]
    pub fn print_header() {
        println!("CPU time of the control thread in a step that takes a scan, ms:");
        println!("{:<12}{:>8}{:>8}{:>8}{:>8}{:>8}", "phase", "steps", "p50", "p99", "p99.9", "max");
    }

    /// Prints one line.
    #[allow(clippy::print_stdout, reason = "the table is this program's output")]
    pub fn print(&self, phase: &str) {
        let [median, p99, p999, max] =
            [0.5, 0.99, 0.999, 1.0].map(|share| quantile(&self.ascending_ms, share));
        println!("{phase:<12}{:>8}{median:>8.2}{p99:>8.2}{p999:>8.2}{max:>8.2}", self.ascending_ms.len());
    }
}

/// The line that states whether all phases met the limits.
pub fn verdict(meets_bar: bool) -> String {
    let verdict = if meets_bar { "bar met" } else { "BAR MISSED" };
    format!("{verdict}: 99.9th percentile at most {P999_MAX_MS} ms, no step above {STEP_MAX_MS} ms")
}

#[cfg(test)]
mod tests {
    use super::{StepTimes, verdict};

    #[test]
    fn the_limits_apply_to_the_slowest_thousandth_and_the_slowest_step() {
        let with = |slow: &[f64]| StepTimes::new([&[10.0; 5000][..], slow].concat());
        assert!(with(&[]).meets_bar());
        assert!(with(&[59.0; 4]).meets_bar());
        assert!(!with(&[59.0; 6]).meets_bar(), "more than a thousandth above 25 ms");
        assert!(!with(&[61.0]).meets_bar(), "one above 60 ms");
        assert!(!StepTimes::new(Vec::new()).meets_bar(), "no scan at all");
    }

    #[test]
    fn the_verdict_states_the_limits() {
        assert_eq!(verdict(true), "bar met: 99.9th percentile at most 25 ms, no step above 60 ms");
        assert!(verdict(false).starts_with("BAR MISSED: "));
    }
}
