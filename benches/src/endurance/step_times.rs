//! The limits of the control thread: CPU time of the steps that take a scan, and of those in between.

use benches::quantile;

/// Limit of the 99.9th percentile, milliseconds: a quarter of the time between two scans at 10 Hz.
const MAX_P999_MS: f64 = 25.0;
/// Limit of the longest step, milliseconds.
const MAX_STEP_MS: f64 = 60.0;

/// CPU times of the steps of a walk, by scan.
pub struct StepTimes {
    /// The steps that took a scan.
    scan: Ascending,
    /// For each scan, the longest step between its step and that of the next scan.
    longest_between: Ascending,
    /// For each scan, the sum of its step and all steps up to that of the next scan.
    sum: Ascending,
}

/// Number of the slowest steps that are printed with the scan at which they came.
const SLOWEST: usize = 4;

/// Times in ascending order, milliseconds.
struct Ascending {
    times_ms: Vec<f64>,
    /// The slowest ones, the slowest first: number of the scan in the walk, from 0, and time.
    slowest: Vec<(usize, f64)>,
}

impl Ascending {
    fn new(mut times_ms: Vec<f64>) -> Self {
        let mut slowest: Vec<(usize, f64)> = times_ms.iter().copied().enumerate().collect();
        slowest.sort_by(|a, b| b.1.total_cmp(&a.1));
        slowest.truncate(SLOWEST);
        times_ms.sort_by(f64::total_cmp);
        Self { times_ms, slowest }
    }

    /// Whether the limits are met. A walk without scans does not meet them.
    fn meets_bar(&self) -> bool {
        quantile(&self.times_ms, 0.999) <= MAX_P999_MS && quantile(&self.times_ms, 1.0) <= MAX_STEP_MS
    }
}

impl StepTimes {
    /// From times in any order, milliseconds: of the steps that took a scan, of the longest step after each, and the sums.
    pub fn new(scan_ms: Vec<f64>, longest_between_ms: Vec<f64>, sum_ms: Vec<f64>) -> Self {
        Self {
            scan: Ascending::new(scan_ms),
            longest_between: Ascending::new(longest_between_ms),
            sum: Ascending::new(sum_ms),
        }
    }

    /// Whether the steps that took a scan and those in between meet the limits. The sums need not: other inputs are handled between the steps.
    pub fn meets_bar(&self) -> bool {
        self.scan.meets_bar() && self.longest_between.meets_bar()
    }

    /// Prints the names of the columns.
    #[allow(clippy::print_stdout, reason = "the table is this program's output")]
    pub fn print_header() {
        println!("CPU time of the control thread for each scan, ms:");
        println!(
            "{:<12}{:<26}{:>8}{:>8}{:>8}{:>8}{:>8}  slowest, ms @ scan",
            "phase", "what", "scans", "p50", "p99", "p99.9", "max"
        );
    }

    /// Prints three lines. The slowest steps come with the number of their scan: a walk has the same inputs each time, so a step that is slow in
    /// every run computes much, and one that is slow in one run was disturbed by other work on the machine.
    #[allow(clippy::print_stdout, reason = "the table is this program's output")]
    pub fn print(&self, phase: &str) {
        let rows = [
            ("step that takes the scan", &self.scan),
            ("longest step after it", &self.longest_between),
            ("all steps, sum", &self.sum),
        ];
        for (what, Ascending { times_ms, slowest }) in rows {
            let [median, p99, p999, max] = [0.5, 0.99, 0.999, 1.0].map(|share| quantile(times_ms, share));
            let scans = times_ms.len();
            let slowest: Vec<String> = slowest.iter().map(|(scan, ms)| format!("{ms:.1} @ {scan}")).collect();
            let slowest = slowest.join(", ");
            println!(
                "{phase:<12}{what:<26}{scans:>8}{median:>8.2}{p99:>8.2}{p999:>8.2}{max:>8.2}  {slowest}"
            );
        }
    }
}

/// The line that states whether all phases met the limits.
pub fn verdict(meets_bar: bool) -> String {
    let verdict = if meets_bar { "bar met" } else { "BAR MISSED" };
    format!("{verdict}: 99.9th percentile at most {MAX_P999_MS} ms, no step above {MAX_STEP_MS} ms")
}

#[cfg(test)]
mod tests {
    use super::{StepTimes, verdict};

    #[test]
    fn the_limits_apply_to_the_slowest_thousandth_and_the_slowest_step() {
        fn steps(slow: &[f64]) -> Vec<f64> {
            [&[10.0; 5000][..], slow].concat()
        }
        let with = |slow: &[f64]| StepTimes::new(steps(slow), steps(&[]), steps(&[99.0; 9]));
        let between = |slow: &[f64]| StepTimes::new(steps(&[]), steps(slow), steps(&[99.0; 9]));
        for times in [with, between] as [fn(&[f64]) -> StepTimes; 2] {
            assert!(times(&[]).meets_bar());
            assert!(times(&[59.0; 4]).meets_bar());
            assert!(!times(&[59.0; 6]).meets_bar(), "more than a thousandth above 25 ms");
            assert!(!times(&[61.0]).meets_bar(), "one above 60 ms");
        }
        assert!(!StepTimes::new(Vec::new(), Vec::new(), Vec::new()).meets_bar(), "no scan at all");
    }

    #[test]
    fn the_verdict_states_the_limits() {
        assert_eq!(verdict(true), "bar met: 99.9th percentile at most 25 ms, no step above 60 ms");
        assert!(verdict(false).starts_with("BAR MISSED: "));
    }
}
